"""The three-node torsion spring: resists a change of the angle between two arms in a plane.

Angle at node j from the arm j->k to the arm j->i, counter-clockwise. With a = x_i - x_j and b = x_k - x_j,

    alpha = atan2(b x a, b.a),   d alpha / d x_i = N a / |a|^2,   d alpha / d x_k = -N b / |b|^2,

N the quarter turn counter-clockwise, and x_j takes minus the sum. The Hessian of the direction angle of a vector
(x, y) of length r is [[2 x y, y^2 - x^2], [y^2 - x^2, -2 x y]] / r^4. Nothing is singular at straight or closed
arms. Energy k (alpha - alpha_0)^2 / 2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.angle import TURN, AngleKernel
from kirigami.elements.driven_rest import held_at, targets_of
from kirigami.errors import ModelError
from kirigami.primitives.checks import require_finite, require_positive
from kirigami.primitives.kernel import EXACT, Array, Contribution, Kernel, Tangent, displacement_of
from kirigami.primitives.node import Node, require_nodes
from kirigami.primitives.parts import ModelObject, Numbering


@dataclass(frozen=True, slots=True, eq=False)
class TorsionSpring3(ModelObject):
    """Rotational spring at the middle one of three nodes of a 2D model.

    Parameters
    ----------
    i, j, k : Node
        Arm end, pivot, arm end. The angle runs counter-clockwise from the arm j->k to the arm j->i.
    stiffness : float
        Moment per angle [force length / rad].
    rest_angle : float, optional
        Angle without moment [rad], taken literally; None takes the angle of the rest state, in [0, 2 pi).
    target_angle : float, optional
        Angle without moment at load factor 1 [rad]: it is driven there from the rest angle with the load factor.

    Raises
    ------
    ModelError
        Stiffness not positive and finite, a repeated node, a rest angle that is not finite.

    Examples
    --------
    >>> import kirigami as kg
    >>> spring = kg.TorsionSpring3(kg.Node(0, 1), kg.Node(0, 0), kg.Node(1, 0), stiffness=3.0)
    >>> spring.stiffness
    3.0
    """

    kind: ClassVar[str] = "element"
    i: Node
    j: Node
    k: Node
    stiffness: float
    rest_angle: float | None
    target_angle: float | None
    reached: float | None

    def __init__(
        self,
        i: Node,
        j: Node,
        k: Node,
        stiffness: float,
        *,
        rest_angle: float | None = None,
        target_angle: float | None = None,
    ) -> None:
        require_nodes("TorsionSpring3", i=i, j=j, k=k)
        put = object.__setattr__
        put(self, "i", i)
        put(self, "j", j)
        put(self, "k", k)
        put(self, "stiffness", require_positive(stiffness, "stiffness", "TorsionSpring3"))
        angle = None if rest_angle is None else require_finite(rest_angle, "rest_angle", "TorsionSpring3")
        put(self, "rest_angle", angle)
        target = None if target_angle is None else require_finite(target_angle, "target_angle", "TorsionSpring3")
        put(self, "target_angle", target)
        put(self, "reached", None)
        if len({id(i), id(j), id(k)}) < 3:
            raise ModelError(f"TorsionSpring3 on ({i!r}, {j!r}, {k!r}): the three nodes must differ")

    def held(self, lam: float) -> TorsionSpring3:
        """The same, its rest angle where load factor `lam` has brought it."""
        held: TorsionSpring3 = held_at(self, "target_angle", lam)
        return held

    @property
    def nodes(self) -> tuple[Node, ...]:
        return (self.i, self.j, self.k)

    @classmethod
    def lower(cls, objects: Sequence[TorsionSpring3], numbering: Numbering) -> list[Kernel]:
        conn = connected_arms(objects, numbering)
        stiffness = np.array([spring.stiffness for spring in objects])
        rest_angle = np.array([math.nan if s.rest_angle is None else s.rest_angle for s in objects])
        targets = targets_of(objects, "target_angle")
        return [TorsionSpring3Kernel(numbering.rest, conn, stiffness, rest_angle, None, targets)]


def connected_arms(objects: Sequence[Any], numbering: Numbering) -> NDArray[np.int64]:
    """Nodes (n, 3) of objects that have an angle between two arms in the plane, or a ModelError in their name."""
    owner = type(objects[0]).__name__
    if numbering.dim != 2:
        raise ModelError(f"{owner} needs a model with dim=2: its angle is counted in the plane")
    conn = numbering.connectivity(objects)
    for arm, end in ((conn[:, 0], 0), (conn[:, 2], 2)):
        length = np.linalg.norm(numbering.rest[arm] - numbering.rest[conn[:, 1]], axis=1)
        short = np.flatnonzero(length <= 1e-12 * numbering.size)
        if short.size:
            item = objects[int(short[0])]
            raise ModelError(
                f"{short.size} {owner} with an arm of zero length, the first between "
                f"{numbering.describe(item.nodes[1])} and {numbering.describe(item.nodes[end])}"
            )
    return conn


def _arms(points: Array, conn: NDArray[np.int64]) -> tuple[Array, Array]:
    """Arms a and b, each (2, n)."""
    i, j, k = conn.T
    return (points[i] - points[j]).T, (points[k] - points[j]).T


def _quarter_turn_over_square(arm: Array) -> Array:
    """Gradient N a / |a|^2 of the direction angle of an arm."""
    gradient: Array = np.stack([-arm[1], arm[0]]) / (arm[0] ** 2 + arm[1] ** 2)
    return gradient


def _direction_hessian(arm: Array) -> Array:
    """Second derivative (2, 2, n) of the direction angle of an arm."""
    x, y = arm
    r4 = (x**2 + y**2) ** 2
    mixed = (y**2 - x**2) / r4
    straight = 2 * x * y / r4
    return np.array([[straight, mixed], [mixed, -straight]])


class TorsionSpring3Kernel(AngleKernel):
    """All torsion springs; see the module's text for the formulas. Local nodes: i, j, k."""

    name = "springs"
    pairs = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        stiffness: Array,
        rest_angle: Array,
        members: NDArray[np.int64] | None = None,
        targets: Array | None = None,
    ) -> None:
        self.rest, self.conn, self.stiffness, self.members = rest, conn, stiffness, members
        self._rest_arms = _arms(rest, conn)
        raw = self._raw_angle(*self._rest_arms)
        self._begin(raw + TURN * (raw < 0), rest_angle, targets)

    def _current_arms(self, x: Array) -> tuple[Array, Array]:
        a, b = _arms(displacement_of(x, self.rest), self.conn)
        return self._rest_arms[0] + a, self._rest_arms[1] + b

    @staticmethod
    def _raw_angle(a: Array, b: Array) -> Array:
        angle: Array = np.arctan2(b[0] * a[1] - b[1] * a[0], a[0] * b[0] + a[1] * b[1])
        return angle

    def deformation(self, x: Array) -> Array:
        """Unwrapped angle of each spring (n,) [rad]."""
        return self.unwrap(self._raw_angle(*self._current_arms(x)))

    def angle_derivatives(self, x: Array) -> Array:
        return np.asarray(self._angle_gradient(*self._current_arms(x)).transpose(2, 1, 0))

    def deformation_rate(self, x: Array, change: Array) -> Array:
        """First-order change of the angle (n,) for a displacement change (n_nodes, 2)."""
        rate: Array = np.einsum("akn,nka->n", self._angle_gradient(*self._current_arms(x)), change[self.conn])
        return rate

    @staticmethod
    def _angle_gradient(a: Array, b: Array) -> Array:
        at_i, at_k = _quarter_turn_over_square(a), -_quarter_turn_over_square(b)
        return np.stack([at_i, -at_i - at_k, at_k], axis=1)

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        a, b = self._current_arms(x)
        excess = self.unwrap(self._raw_angle(a, b)) - self.rest_angle_at(lam)
        moment = self.stiffness * excess
        energy = 0.5 * moment * excess
        if need == 0:
            return Contribution(energy)
        angle_gradient = self._angle_gradient(a, b)
        gradient = moment * angle_gradient
        if need == 1:
            return Contribution(energy, gradient.transpose(2, 1, 0))
        moment = (1 - tangent.convexity) * moment
        hessian = np.empty((2, 2, len(self.pairs), len(moment)))
        stiff = self.stiffness * angle_gradient
        for slot, (p, q) in enumerate(self.pairs):
            np.multiply(stiff[:, None, p], angle_gradient[None, :, q], out=hessian[:, :, slot])
        at_a, at_b = moment * _direction_hessian(a), moment * _direction_hessian(b)
        hessian[:, :, 0] += at_a
        hessian[:, :, 1] -= at_a
        hessian[:, :, 3] += at_a - at_b
        hessian[:, :, 4] += at_b
        hessian[:, :, 5] -= at_b
        return Contribution(energy, gradient.transpose(2, 1, 0), hessian.transpose(3, 2, 0, 1))
