"""The angle limit: contact between panels as a one-sided spring on the angle at their joint.

With the depth d = minimum - alpha (or alpha - maximum) beyond the limit, stiffness k and width w, the moment is

    M = 0 for d <= 0,   k d^2 / (2 w) for d <= w,   k (d - w / 2) beyond,

so that moment and stiffness are continuous and the energy is twice differentiable: Newton's method sees no corner.
The angle and its derivatives are those of the three-node torsion spring.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.angle import TURN
from kirigami.elements.torsion_spring import TorsionSpring3Kernel, connected_arms
from kirigami.errors import ModelError
from kirigami.primitives.checks import require_finite, require_positive
from kirigami.primitives.kernel import EXACT, Array, Contribution, Kernel, Tangent
from kirigami.primitives.node import Node, require_nodes
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.words import counted

TOUCHING = 1e-9  # an angle at its limit up to rounding [rad]


@dataclass(frozen=True, slots=True, eq=False)
class AngleLimit(ModelObject):
    """Keeps the angle at the middle one of three nodes of a 2D model within limits.

    Parameters
    ----------
    i, j, k : Node
        Arm end, pivot, arm end, as for TorsionSpring3: counter-clockwise from the arm j->k to the arm j->i.
    stiffness : float
        Moment per angle beyond the limit [force length / rad].
    minimum, maximum : float, optional
        Limits of the angle [rad]; at least one. The angle of the rest state lies in [0, 2 pi).
    width : float
        Angle over which the moment sets in smoothly [rad].

    Raises
    ------
    ModelError
        No limit, limits in the wrong order, a value out of range; when a system is made: a limit that the rest state
        violates already.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> i, j, k = m.add(kg.Node(0, 1), kg.Node(0, 0), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(i, j, 1e7), kg.Bar(j, k, 1e7), kg.TorsionSpring3(i, j, k, 1.0), kg.Fix([j, k]))
    >>> objects = m.add(kg.AngleLimit(i, j, k, stiffness=1e3, minimum=1.0), kg.Prescribe(i, x=0.8))
    >>> res = kg.DisplacementControl(m).run()
    >>> [round(float(res.energy["angle limits"][step]), 0) for step in (0, -1)]
    [0.0, 60.0]
    """

    kind: ClassVar[str] = "effect"
    i: Node
    j: Node
    k: Node
    stiffness: float
    minimum: float
    maximum: float
    width: float

    def __init__(
        self,
        i: Node,
        j: Node,
        k: Node,
        stiffness: float,
        *,
        minimum: float | None = None,
        maximum: float | None = None,
        width: float = 0.02,
    ) -> None:
        require_nodes("AngleLimit", i=i, j=j, k=k)
        put = object.__setattr__
        put(self, "i", i)
        put(self, "j", j)
        put(self, "k", k)
        put(self, "stiffness", require_positive(stiffness, "stiffness", "AngleLimit"))
        put(self, "width", require_positive(width, "width", "AngleLimit"))
        if minimum is None and maximum is None:
            raise ModelError("AngleLimit: give a minimum or a maximum, or both")
        put(self, "minimum", -math.inf if minimum is None else require_finite(minimum, "minimum", "AngleLimit"))
        put(self, "maximum", math.inf if maximum is None else require_finite(maximum, "maximum", "AngleLimit"))
        if not self.minimum < self.maximum:
            raise ModelError(f"AngleLimit: the minimum {self.minimum:.6g} must be below the maximum {self.maximum:.6g}")
        if len({id(i), id(j), id(k)}) < 3:
            raise ModelError(f"AngleLimit on ({i!r}, {j!r}, {k!r}): the three nodes must differ")

    @property
    def nodes(self) -> tuple[Node, ...]:
        return (self.i, self.j, self.k)

    @classmethod
    def lower(cls, objects: Sequence[AngleLimit], numbering: Numbering) -> list[Kernel]:
        conn = connected_arms(objects, numbering)
        stiffness, minimum, maximum, width = np.array(
            [(item.stiffness, item.minimum, item.maximum, item.width) for item in objects]
        ).T
        kernel = AngleLimitKernel(numbering.rest, conn, stiffness, minimum, maximum, width)
        angle = kernel.deformation(numbering.rest)
        beyond = np.flatnonzero((angle < minimum - TOUCHING) | (angle > maximum + TOUCHING))
        if beyond.size:
            worst = int(beyond[0])
            raise ModelError(
                f"{counted(beyond.size, 'AngleLimit')} violated in the rest state, the first at "
                f"{numbering.describe(objects[worst].j)}: the angle {angle[worst]:.6g} is not between "
                f"{minimum[worst]:.6g} and {maximum[worst]:.6g} rad; open the joint or widen the limits"
            )
        return [kernel]


class AngleLimitKernel(Kernel):
    """All angle limits; see the module's text for the law. Local nodes: i, j, k."""

    name = "angle limits"
    approximates = True
    pairs = TorsionSpring3Kernel.pairs

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        stiffness: Array,
        minimum: Array,
        maximum: Array,
        width: Array,
        members: NDArray[np.int64] | None = None,
    ) -> None:
        self.rest, self.conn, self.members = rest, conn, members
        self.stiffness, self.minimum, self.maximum, self.width = stiffness, minimum, maximum, width
        self._spring = TorsionSpring3Kernel(rest, conn, stiffness, np.full(len(conn), math.nan))
        # A joint closed up to rounding counts as angle 0, not as a full turn.
        start = self._spring.deformation(rest)
        self._initial = np.where(start > TURN - TOUCHING, start - TURN, start)
        self._spring.history = self._initial

    def arrays(self) -> dict[str, Any]:
        names = ("conn", "stiffness", "minimum", "maximum", "width", "members")
        return {name: getattr(self, name) for name in names}

    @property
    def history(self) -> Array | None:
        return self._spring.history

    @history.setter
    def history(self, value: Array | None) -> None:
        self._spring.history = self._initial if value is None else value

    def commit(self, x: Array) -> None:
        self._spring.commit(x)

    def deformation(self, x: Array) -> Array:
        """Unwrapped angle of each joint (n,) [rad]."""
        return self._spring.deformation(x)

    def deformation_rate(self, x: Array, change: Array) -> Array:
        """First-order change of the angle (n,) for a displacement change (n_nodes, 2)."""
        return self._spring.deformation_rate(x, change)

    def _law(self, angle: Array) -> tuple[Array, Array, Array]:
        """Energy, moment and stiffness (n,) at angles (n,)."""
        sense = np.where(angle < self.minimum, -1.0, 1.0)
        depth = np.maximum(np.maximum(self.minimum - angle, angle - self.maximum), 0.0)
        k, w = self.stiffness, self.width
        onset = np.minimum(depth, w)  # the part of the depth over which the moment sets in
        past = depth - onset
        energy = k * (onset**3 / (6 * w) + past * (past + w) / 2)
        return energy, sense * k * (onset**2 / (2 * w) + past), k * onset / w

    def force(self, angle: Array) -> Array:
        """Moment (n,), negative where a minimum pushes the joint open."""
        return self._law(angle)[1]

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        angle = self.deformation(x)
        energy, moment, stiffness = self._law(angle)
        if need == 0:
            return Contribution(energy)
        # At one configuration the limit is a spring of the stiffness and moment that the law has there.
        self._spring.stiffness = stiffness
        self._spring.rest_angle = angle - moment / np.where(stiffness > 0, stiffness, 1.0)
        return self._spring.evaluate(x, lam, need, tangent)._replace(energy=energy)
