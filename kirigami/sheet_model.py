"""From a mesh to a model: every edge a bar, every inner edge a bending hinge."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kirigami.elements.bar import Bar
from kirigami.elements.bend_hinge import BendHinge
from kirigami.errors import ModelError
from kirigami.model import Material, Model, Node, require_positive
from kirigami.stiffness import Calibration, SheetConstants, bar_stiffness, hinge_stiffness

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh


def populate(
    model: Model,
    mesh: TriMesh,
    thickness: float | None,
    material: Material | None,
    stiffness: str | Calibration,
) -> None:
    """Fill an empty model with the nodes, bars and hinges of a mesh."""
    thickness = mesh.thickness if thickness is None else thickness
    material = mesh.material if material is None else material
    if thickness is None or material is None:
        missing = "thickness" if thickness is None else "material"
        raise ModelError(f"Model.from_mesh: no {missing}: give it here or to the Sheet the mesh is made from")
    thickness = require_positive(thickness, "thickness", "Model.from_mesh")
    if not isinstance(material, Material):
        raise ModelError(f"Model.from_mesh: material must be a Material, got {material!r}")
    calibration = Calibration.named(stiffness, material)
    nodes = [Node(*position) for position in mesh.nodes.tolist()]
    model.add(*nodes)
    EA = bar_stiffness(mesh, thickness, material.E, calibration.F_s).tolist()
    model.add(*(Bar(nodes[j], nodes[k], value) for (j, k), value in zip(mesh.edges.tolist(), EA)))
    if model.dim == 3:
        inner = np.flatnonzero(mesh.edge_facets[:, 1] >= 0)
        rigidity = hinge_stiffness(mesh, thickness, material.E, calibration.c)[inner].tolist()
        edges, wings = mesh.edges[inner].tolist(), mesh.edge_wings[inner].tolist()
        model.add(
            *(
                BendHinge(nodes[i], nodes[j], nodes[k], nodes[other], value)
                for (j, k), (i, other), value in zip(edges, wings, rigidity)
            )
        )
    model.mesh = mesh
    model.sheet_constants = SheetConstants(calibration, thickness, material)
