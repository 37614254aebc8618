"""The pressure of a flow on a sheet that stands in its way: Newton's sine-squared law, facet by facet.

A facet with area vector a (its area along its normal) in a flow along the unit vector w bears the pressure
q cos^2 of the angle between normal and flow, pushing with the flow:

    f(a) = q s |s| a / |a|^2,    s = a.w,    df/da = q (2 |s| a w' + s |s| (1 - 2 a a' / |a|^2)) / |a|^2

a third of it at each corner. What is in the lee of something else is not told apart, and q is what the flow makes of
its dynamic pressure on a plate across it. The force has no potential: it follows the sheet, and its tangent is the
symmetric part; the rest is known to paths by :mod:`kirigami.analysis.path.skew`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.model.loads import Load, LoadKernel
from kirigami.model.spread_loads import Surface, _facets
from kirigami.primitives.checks import require_array, require_boolean, require_finite
from kirigami.primitives.kernel import Array, Contribution, Kernel
from kirigami.primitives.node import Node
from kirigami.primitives.parts import Numbering
from kirigami.primitives.rotation import cross_matrices

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class FlowPressure(Load):
    """A flow that presses on facets with cos^2 of the angle between their normals and the flow.

    Stability cannot be counted: walk with ``on_instability="follow"``, as :class:`LoadControl` does.

    Parameters
    ----------
    q : float
        Pressure on a facet across the flow at load factor 1 [force / length^2].
    direction : array_like, shape (3,)
        Direction of the flow; any length.
    facets : str or array_like of int, optional
        Name of a region of the mesh, or numbers of facets; None is the whole sheet.
    constant : bool
        The flow is there in full whatever the load factor.

    Raises
    ------
    ModelError
        Values that are not finite, no direction; in a run facets that are not there, or a model with dim=2.

    Examples
    --------
    A sheet across the flow bears q times its area:

    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (2, 0), (2, 2), (0, 2)]).mesh(1.0)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.1, material=kg.Material(E=1e6), stiffness="shell")
    >>> held = m.add(kg.Fix(m.select(boundary="outer")), kg.FlowPressure(3.0, (0, 0, 1)))
    >>> round(float(kg.LinearStatic(m).run().reaction("fixed_0", "z")[-1]), 6)
    -12.0
    """

    q: float
    direction: tuple[float, float, float]
    facets: Index | str | None
    constant: bool

    def __init__(
        self,
        q: float,
        direction: ArrayLike = (0.0, 0.0, 1.0),
        facets: str | ArrayLike | None = None,
        constant: bool = False,
    ) -> None:
        along = require_array(direction, (3,), name="direction", owner="FlowPressure")
        if not along.any():
            raise ModelError("FlowPressure: the flow needs a direction")
        object.__setattr__(self, "q", require_finite(q, "q", "FlowPressure"))
        object.__setattr__(self, "direction", tuple((along / np.linalg.norm(along)).tolist()))
        object.__setattr__(self, "facets", _facets(facets, "FlowPressure"))
        object.__setattr__(self, "constant", require_boolean(constant, "constant", "FlowPressure"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return ()

    def held(self, lam: float) -> FlowPressure:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "FlowPressure.held")
        return self if self.constant else FlowPressure(lam * self.q, self.direction, self.facets, constant=True)

    @classmethod
    def lower(cls, objects: Sequence[Any], numbering: Numbering) -> list[Kernel]:
        if numbering.dim == 2:
            raise ModelError(f"{objects[0]!r} acts across the sheet, but the model has dim=2: make it with dim=3")
        surface = Surface(numbering, "FlowPressure")
        facets = [surface.triangles[surface.chosen(item.facets, repr(item))] for item in objects]
        return [
            FlowPressureKernel(numbering.rest, conn, item.q, item.direction, item.constant)
            for conn, item in zip(facets, objects)
        ]

    def __repr__(self) -> str:
        return f"FlowPressure({self.q:g}, ({', '.join(f'{c:.4g}' for c in self.direction)}))"


class FlowPressureKernel(LoadKernel):
    """The force of a flow on facets; local nodes: corners."""

    name = "flow"
    conservative = False

    def __init__(self, rest: Array, conn: Index, q: float, direction: ArrayLike, constant: bool = False) -> None:
        super().__init__(constant)
        self.rest, self.conn = rest, conn
        self.q, self.direction = float(q), np.asarray(direction, dtype=float)

    def arrays(self) -> dict[str, Any]:
        return {"conn": self.conn, "q": self.q, "direction": self.direction, "constant": self.constant}

    def force_on(self, x: Array) -> Array:
        """Force (n, 3) of the flow on each facet at load factor 1."""
        a = _area_vectors(np.asarray(x)[self.conn])
        s = a @ self.direction
        return np.asarray(self.q * (s * np.abs(s) / (a * a).sum(axis=1))[:, None] * a)

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        factor = self.factor(lam)
        share = np.repeat(-factor / 3 * self.force_on(x)[:, None], 3, axis=1)
        energy = np.zeros(len(self.conn))
        if need < 2:
            return Contribution(energy, share)
        corners = np.asarray(x)[self.conn]
        a, w = _area_vectors(corners), self.direction
        s, square = a @ w, (a * a).sum(axis=1)
        steep = 2 * np.abs(s)[:, None, None] * a[:, :, None] * w
        steep += (s * np.abs(s))[:, None, None] * (np.eye(3) - 2 * a[:, :, None] * a[:, None] / square[:, None, None])
        steep *= -factor * self.q / 3 / square[:, None, None]
        # the area vector changes by half the cross product of the opposite edge with the motion of a corner
        edges = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
        turns = 0.5 * cross_matrices(edges.reshape(-1, 3)).reshape(-1, 3, 3, 3)
        slope = np.repeat((steep[:, None] @ turns)[:, None], 3, axis=1)  # the same at every corner
        return Contribution(energy, share, 0.5 * (slope + slope.transpose(0, 2, 1, 4, 3)))


def _area_vectors(corners: Array) -> Array:
    """Area along the normal (n, 3) of facets with corners (n, 3, 3)."""
    return np.asarray(0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
