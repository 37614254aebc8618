"""From a mesh to a model: every edge a bar, every inner edge a bending hinge."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from kirigami.elements.bar import Bar
from kirigami.elements.bend_hinge import BendHinge
from kirigami.elements.stiffness import Calibration, SheetConstants, bar_stiffness, directional_bias, hinge_stiffness
from kirigami.errors import KirigamiWarning, ModelError
from kirigami.primitives.checks import require_positive
from kirigami.primitives.material import Material
from kirigami.primitives.node import Node
from kirigami.primitives.parts import ModelObject

FEW = 50  # facets below which a mesh is too small to have a pattern
BIAS = 0.2  # unevenness of stiffness over the directions, before relaxation, that is worth a warning

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh


def sheet_parts(
    mesh: TriMesh,
    thickness: float | None,
    material: Material | None,
    stiffness: str | Calibration,
    dim: int,
) -> tuple[list[Node], list[ModelObject], SheetConstants]:
    """The nodes and elements of a mesh, and the constants that the elements were made with."""
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
    rung = stiffness if isinstance(stiffness, str) else "calibration"
    constants = SheetConstants(calibration, thickness, material, rung)
    if rung == "shell":
        from kirigami.elements.shell_facet import ShellFacet

        corners = mesh.triangles.tolist()
        return nodes, [ShellFacet(nodes[i], nodes[j], nodes[k], thickness, material) for i, j, k in corners], constants
    if rung == "facet":
        return nodes, _facets(nodes, mesh, thickness, material), constants
    if rung == "split":
        if dim == 2:
            raise ModelError("Model.from_mesh: stiffness='split' bends, so it needs dim=3; in a plane use 'facet'")
        normals, curved = _curved_facets(nodes, mesh, thickness, material)
        return nodes + normals, curved, constants
    _warn_of_bias(mesh)
    EA = bar_stiffness(mesh, thickness, material.E, calibration.F_s).tolist()
    elements: list[ModelObject] = [
        Bar(nodes[j], nodes[k], value) for (j, k), value in zip(mesh.edges.tolist(), EA)
    ]
    if dim == 3:
        inner = np.flatnonzero(mesh.edge_facets[:, 1] >= 0)
        rigidity = hinge_stiffness(mesh, thickness, material.E, calibration.c)[inner].tolist()
        edges, wings = mesh.edges[inner].tolist(), mesh.edge_wings[inner].tolist()
        elements += [
            BendHinge(nodes[i], nodes[j], nodes[k], nodes[other], value)
            for (j, k), (i, other), value in zip(edges, wings, rigidity)
        ]
    return nodes, elements, constants


def _warn_of_bias(mesh: TriMesh) -> None:
    """Say so where bars and hinges on this mesh are far from isotropic, as on squares with one diagonal."""
    if len(mesh.triangles) < FEW:
        return
    low, high = directional_bias(mesh)
    if low < 1 - BIAS or high > 1 + BIAS:
        warnings.warn(
            f"the mesh is biased: its edges favour some directions, so that bars and hinges on it represent {low:.2f} "
            f"to {high:.2f} times the stiffness before they relax, and G and twisting rigidity are off by more than "
            "20 %. Use a mesh without a pattern, or stiffness='split'; kirigami.stiffness.report(mesh) has the numbers",
            KirigamiWarning,
            stacklevel=4,
        )


def _curved_facets(
    nodes: list[Node], mesh: TriMesh, thickness: float, material: Material
) -> tuple[list[Node], list[ModelObject]]:
    """Every facet a curved one, and a normal at every node, with its tip on the upper face of the sheet."""
    from kirigami.elements.curved_facet import CurvedFacet
    from kirigami.geometry.normals import Normal, sheet_normals

    directions = sheet_normals(mesh.nodes, mesh.triangles).tolist()
    normals = [Normal(node, direction, 0.5 * thickness) for node, direction in zip(nodes, directions)]
    corners = mesh.triangles.tolist()
    return [*normals], [CurvedFacet(normals[i], normals[j], normals[k], thickness, material) for i, j, k in corners]


def _facets(nodes: list[Node], mesh: TriMesh, thickness: float, material: Material) -> list[ModelObject]:
    """Every facet one that stretches and bends against its neighbours."""
    from kirigami.elements.facet import Facet

    # For each facet and corner, the corner of the neighbour across the opposite edge.
    edge_of = {tuple(edge): position for position, edge in enumerate(np.sort(mesh.edges, axis=1).tolist())}
    made: list[ModelObject] = []
    wings, facets = mesh.edge_wings.tolist(), mesh.edge_facets.tolist()
    for position, triangle in enumerate(mesh.triangles.tolist()):
        across: list[Node | None] = []
        for corner in range(3):
            a, b = sorted((triangle[corner - 2], triangle[corner - 1]))
            edge = edge_of[a, b]
            other = facets[edge][1] if facets[edge][0] == position else facets[edge][0]
            wing = wings[edge][1] if facets[edge][0] == position else wings[edge][0]
            across.append(nodes[wing] if other >= 0 else None)
        i, j, k = (nodes[corner] for corner in triangle)
        made.append(Facet(i, j, k, thickness, material, (across[0], across[1], across[2])))
    return made
