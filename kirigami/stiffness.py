"""From a mesh and a material to bar and hinge constants: the named calibrations.

With facet areas A, edge length L, thickness t and material (E, nu):

* bars    EA = F_s E t (sum of A over the one or two facets of the edge) / L
* hinges  k = c E t^3 L^2 / (A1 + A2), the total of the edge

"plate" takes F_s = 1, the triangulated-membrane rule of Van Gelder (1998), which is exact for equilateral facets at
nu = 1/3, and c = 1 / (12 (1 - nu^2)), which makes cylindrical bending exact on equilateral and on leg-aligned
right-angled facets (Seung and Nelson, 1988). "paper" takes the published F_s = 0.85, c = 0.125 / 48, which is
about 36 times softer in bending than the material; it is kept to reproduce the publication.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.bar import Bar
from kirigami.elements.bend_hinge import BendHinge, BendHingeKernel
from kirigami.errors import ModelError
from kirigami.kernel import Array, Configuration, Contribution, Kernel, displacement_of, full_hessian
from kirigami.model import Material, Model, Node, Numbering, require_positive

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh


@dataclass(frozen=True)
class Calibration:
    """Factors of the bar and hinge constants; see the module's text.

    Parameters
    ----------
    F_s : float
        Factor of the bar stiffness.
    c : float
        Factor of the hinge stiffness; plate theory has 1 / (12 (1 - nu^2)).

    Raises
    ------
    ModelError
        A factor is not positive and finite.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Calibration(F_s=1.0, c=0.09)
    Calibration(F_s=1.0, c=0.09)
    """

    F_s: float
    c: float

    def __post_init__(self) -> None:
        require_positive(self.F_s, "F_s", "Calibration")
        require_positive(self.c, "c", "Calibration")

    @classmethod
    def named(cls, stiffness: str | Calibration, material: Material) -> Calibration:
        """The calibration of a name, or the one given."""
        if isinstance(stiffness, Calibration):
            return stiffness
        if stiffness == "plate":
            return cls(F_s=1.0, c=1 / (12 * (1 - material.nu**2)))
        if stiffness == "paper":
            return cls(F_s=0.85, c=0.125 / 48)
        raise ModelError(f"stiffness {stiffness!r} is unknown: use 'plate', 'paper' or a Calibration(F_s, c)")


@dataclass(frozen=True)
class SheetConstants:
    """The calibration a model was made with, and what it was applied to."""

    calibration: Calibration
    thickness: float
    material: Material


def bar_stiffness(mesh: TriMesh, thickness: float, E: float, F_s: float) -> Array:
    """EA of each mesh edge (edges,) [force]."""
    return F_s * E * thickness * _facet_area_sum(mesh) / mesh.edge_lengths


def hinge_stiffness(mesh: TriMesh, thickness: float, E: float, c: float) -> Array:
    """Rotational stiffness of each mesh edge (edges,) [force length / rad]; meaningful for inner edges."""
    return c * E * thickness**3 * mesh.edge_lengths**2 / _facet_area_sum(mesh)


def _facet_area_sum(mesh: TriMesh) -> Array:
    areas = np.append(mesh.facet_areas, 0.0)  # a missing facet has index -1
    total: Array = areas[mesh.edge_facets].sum(axis=1)
    return total


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


def clamp_kernels(groups: Sequence[Sequence[Node]], numbering: Numbering) -> list[Kernel]:
    """Hinges that keep the slope of boundary edges whose two nodes lie in one of the groups."""
    model = numbering.model
    if model.mesh is None or model.sheet_constants is None:
        raise ModelError("clamp=True needs a model made by Model.from_mesh: other models have no facets to clamp")
    mesh, constants = model.mesh, model.sheet_constants
    rigidity = hinge_stiffness(mesh, constants.thickness, constants.material.E, constants.calibration.c)
    boundary = np.flatnonzero(mesh.edge_facets[:, 1] < 0)
    chosen: set[int] = set()
    for group in groups:
        inside = np.isin(mesh.edges[boundary], numbering.index(group)).all(axis=1)
        chosen.update(boundary[inside].tolist())
    if not chosen:
        return []
    edges = np.array(sorted(chosen))
    conn = np.column_stack([mesh.edge_wings[edges, 0], mesh.edges[edges]])
    # The facet and its mirror image turn by phi each: half the energy of k (2 phi)^2 / 2 with k = D L^2 / (2 A), in all
    # (D L^2 / A) phi^2 / 2, and D L^2 / A is what the formula gives for an edge with one facet.
    return [ClampHingeKernel(numbering.rest, conn, rigidity[edges])]


class ClampHingeKernel(Kernel):
    """Facets (j, k, i) that keep their slope at a clamped edge j-k; local nodes i, j, k.

    The rotation phi of the facet against its rest plane is the angle of a bending hinge whose other wing is the mirror
    image of the facet in the rest state and moves along with the edge. Energy k phi^2 / 2.
    """

    name = "clamps"
    anchored = True

    def __init__(
        self, rest: Array, conn: NDArray[np.int64], stiffness: Array, members: NDArray[np.int64] | None = None
    ) -> None:
        self.rest, self.conn, self.stiffness, self.members = rest, conn, stiffness, members
        n = len(conn)
        i, j, k = (rest[nodes] for nodes in conn.T)
        edge = k - j
        wing = i - j
        along = edge * (np.einsum("na,na->n", wing, edge) / np.einsum("na,na->n", edge, edge))[:, None]
        mirror = j + 2 * along - wing
        # Every facet gets its own four points, so that the mirror image can be carried along by the edge's node j.
        self._hinge = BendHingeKernel(
            np.concatenate([i, j, k, mirror]),
            np.arange(4 * n).reshape(4, n).T,
            stiffness,
            np.full(n, np.nan),
        )

    def arrays(self) -> dict[str, Any]:
        return {"conn": self.conn, "stiffness": self.stiffness, "members": self.members}

    @property
    def history(self) -> Array | None:
        return self._hinge.history

    @history.setter
    def history(self, value: Array | None) -> None:
        self._hinge.history = value

    def _points(self, x: Array) -> Array:
        u = displacement_of(x, self.rest)[self.conn.T]  # (3, n, dim)
        return Configuration(self._hinge.rest, np.concatenate([u[0], u[1], u[2], u[1]]))

    def commit(self, x: Array) -> None:
        self._hinge.commit(self._points(x))

    def deformation(self, x: Array) -> Array:
        """Rotation of each clamped facet (n,) [rad]."""
        return self._hinge.deformation(self._points(x))

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        self._hinge.convexity = self.convexity
        part = self._hinge.evaluate(self._points(x), lam, need)
        if part.gradient is None:
            return part
        gradient = part.gradient[:, :3].copy()
        gradient[:, 1] += part.gradient[:, 3]
        if part.hessian is None:
            return Contribution(part.energy, gradient)
        full = full_hessian(self._hinge, part)
        full[:, 1] += full[:, 3]
        full[:, :, 1] += full[:, :, 3]
        return Contribution(part.energy, gradient, np.ascontiguousarray(full[:, :3, :3]))
