"""The clamp: a boundary edge that keeps its slope, by a bending hinge against the mirror image of its facet.

The rotation phi of the facet (j, k, i) against its rest plane is the angle of a bending hinge whose other wing is the
mirror image of the facet in the rest state and moves along with the edge. A whole hinge would fold by 2 phi; half of
its energy k (2 phi)^2 / 2 with k = D L^2 / (2 A) belongs to the real facet: (D L^2 / A) phi^2 / 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.bend_hinge import BendHingeKernel
from kirigami.elements.stiffness import hinge_stiffness
from kirigami.errors import ModelError
from kirigami.primitives.kernel import (
    EXACT,
    Array,
    Configuration,
    Contribution,
    Kernel,
    Tangent,
    displacement_of,
    full_hessian,
)
from kirigami.primitives.node import Node
from kirigami.primitives.parts import Numbering


def clamp_kernels(groups: Sequence[Sequence[Node]], numbering: Numbering) -> list[Kernel]:
    """Hinges that keep the slope of boundary edges whose two nodes lie in one of the groups."""
    if numbering.edges is not None:
        return []  # the edges of shell facets have angles, which are held by elimination
    mesh, constants = numbering.mesh, numbering.sheet
    if mesh is None or constants is None:
        raise ModelError("clamp=True needs a model made by Model.from_mesh: other models have no facets to clamp")
    if len(numbering.normals[0]):
        return []  # clamped nodes hold their normals, which is done by elimination
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
    # The constant of an edge with one facet is D L^2 / A, just what the clamp needs.
    return [ClampHingeKernel(numbering.rest, conn, rigidity[edges])]


class ClampHingeKernel(Kernel):
    """Facets (j, k, i) that keep their slope at a clamped edge j-k; local nodes i, j, k. Energy k phi^2 / 2."""

    name = "clamps"
    anchored = True
    approximates = True

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

    def force(self, angle: Array) -> Array:
        """Moment (n,) of the clamp on each facet."""
        return np.asarray(self.stiffness * angle)

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        part = self._hinge.evaluate(self._points(x), lam, need, tangent)
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
