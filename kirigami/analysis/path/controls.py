"""Controls: the one equation beside equilibrium that says how far along the path to go."""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.analysis.path.points import Attempt, Point, State, Tangent
from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES, Node
from kirigami.system.system import System

BENT = 0.5  # most that corrections at a given load may turn members, as a share of what the increment turns them
HARMLESS = 1e-3  # ... or this angle [rad]
BOTH_WAYS = 0.25  # most by which a step's chord may lie off the tangents on both sides at once [rad]
SHARPEST_TURN = 0.5  # cosine of the largest angle between the tangent of a step and its chord
NEARLY_STRAIGHT = 0.95  # cosine of an angle so small that a step lies ahead whatever else speaks against it


class Control:
    """One equation beside equilibrium; the parameter is what the path is walked in."""

    slack = 0.0  # how far the equation may be off at convergence, in its own unit
    target = 0.0

    def value(self, q: Array, lam: float) -> float:
        """Parameter at a state."""
        raise NotImplementedError

    def begin(self, state: State, increment: float) -> None:
        """Ask for the parameter to move on by `increment` from `state`."""
        self.target = self.value(state.q, state.lam) + increment

    def equation(self, q: Array, lam: float) -> tuple[float, Array | None, float]:
        """Gap to the target, and its derivatives by q (None for zero) and lam."""
        raise NotImplementedError

    def predict(self, increment: float, rate: Array) -> float:
        """First-order change of the load factor for an increment, given dq/dlam."""
        raise NotImplementedError

    def load_rate(self, rate: Array, before: State, after: State) -> float:
        """Change of the load factor with the parameter, given dq/dlam, in the sense from `before` to `after`."""
        ends = [self.value(state.q, state.lam) for state in (before, after)]
        return self.predict(1.0, rate) * float(np.sign(ends[1] - ends[0]))

    def doubt(self, before: Point, attempt: Attempt, tangent: Tangent) -> str:
        """Why a converged attempt is not to be trusted to lie ahead on the same path; empty where it is."""
        return ""

    def hides_turns(self, before: Point, attempt: Attempt, tangent: Tangent) -> bool:
        """Whether the load factor seems to turn twice within an increment at whose ends it goes the same way.

        So does the cubic through both ends with the rates there. At a kink, as where contact begins, it may do so in
        increments however short.
        """
        begin, end = (self.load_rate(t.rate, before.state, attempt.state) for t in (before.tangent, tangent))
        mean = (attempt.state.lam - before.state.lam) / self.walked(before.state, attempt.state)
        if not np.isfinite([begin, end, mean]).all() or begin * end < 0:
            return False
        return bool(np.sign(begin + end) * mean < abs(begin + end) / 6)

    def walked(self, before: State, after: State) -> float:
        """How far the parameter went."""
        return abs(self.value(after.q, after.lam) - self.value(before.q, before.lam))

    def accept(self, before: State, after: State) -> None:
        """Note that the path went on from `before` to `after`."""

    @property
    def memory(self) -> dict[str, Any]:
        """Attributes that must be stored to go on later as if nothing had been."""
        return {}


class LoadFactorControl(Control):
    """The parameter is the load factor."""

    def value(self, q: Array, lam: float) -> float:
        return lam

    def equation(self, q: Array, lam: float) -> tuple[float, Array | None, float]:
        return lam - self.target, None, 1.0

    def predict(self, increment: float, rate: Array) -> float:
        return increment

    def hides_turns(self, before: Point, attempt: Attempt, tangent: Tangent) -> bool:
        return False

    def doubt(self, before: Point, attempt: Attempt, tangent: Tangent) -> str:
        if attempt.drift > max(BENT * attempt.moved, HARMLESS):
            return f"equilibrium found {attempt.drift:.2g} rad off the prediction, maybe beyond a limit point"
        return ""


class SingleDisplacementControl(Control):
    """The parameter is one displacement; the load factor is an unknown."""

    def __init__(self, system: System, node: Node, axis: str) -> None:
        dof = int(system.model.index(node)[0]) * system.dim + AXES.index(axis)
        if system.unknown[dof] < 0:
            raise ModelError(
                f"control=({node!r}, {axis!r}): this displacement is constrained, so it cannot control the path"
            )
        self.pick = np.zeros(system.free)
        self.pick[system.unknown[dof]] = 1.0
        self.offset, self.drive = float(system.held[dof]), float(system.drive[dof])
        self.slack = 1e-12 * system.length

    def value(self, q: Array, lam: float) -> float:
        return float(self.pick @ q) + self.offset + lam * self.drive

    def equation(self, q: Array, lam: float) -> tuple[float, Array | None, float]:
        return self.value(q, lam) - self.target, self.pick, self.drive

    def predict(self, increment: float, rate: Array) -> float:
        slope = float(self.pick @ rate) + self.drive
        return increment / slope if slope else float("nan")


class ModeControl(Control):
    """The parameter is how far a state has gone from a given one along a mode; the load factor is an unknown.

    The path on which the mode is neutral does not move along it to first order, so away from zero this finds the
    other path through a bifurcation.
    """

    def __init__(self, origin: State, mode: Array) -> None:
        self.origin, self.mode = origin.q, mode / float(mode @ mode)

    def value(self, q: Array, lam: float) -> float:
        return float(self.mode @ (q - self.origin))

    def begin(self, state: State, increment: float) -> None:
        super().begin(state, increment)
        self.slack = 1e-9 * abs(increment)

    def equation(self, q: Array, lam: float) -> tuple[float, Array | None, float]:
        return self.value(q, lam) - self.target, self.mode, 0.0


class ArcLengthControl(Control):
    """The parameter is the distance walked: in displacements alone (a cylinder about the load axis, Crisfield 1981),
    or with the load factor times `weight` as one more displacement (a sphere).

    The arc's equation is linearised anew at each iterate (Ramm 1981), so no quadratic root is chosen. The direction
    is the one that goes on from the last step. It agrees with the inertia of the tangent: on one smooth path the load
    factor turns exactly where the number of negative eigenvalues changes from even to odd or back.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.weight = 0.0  # displacement that one unit of load factor counts for
        self.direction: Array | None = None  # displacement of the last accepted step (n, dim)
        self.load_direction = 0.0  # its change of the load factor
        self.sense = 1.0
        self._drive = system.drive
        self._origin = State(np.zeros(system.free), 0.0, system.rest * 0)
        self._length = 0.0

    def value(self, q: Array, lam: float) -> float:
        return self.target

    def begin(self, state: State, increment: float) -> None:
        self._origin, self._length = state, increment
        self.slack = 1e-9 * increment**2

    def equation(self, q: Array, lam: float) -> tuple[float, Array | None, float]:
        walked = self.system.displacement(q, lam) - self._origin.u
        rise = self.weight**2 * (lam - self._origin.lam)
        gap = float((walked**2).sum()) + rise * (lam - self._origin.lam) - self._length**2
        if not walked.any():
            return -self._length, None, 0.0
        carried = self.system.carried(walked, self._origin.u + walked)
        by_lam = 2 * float((carried.ravel() * self._drive).sum()) + 2 * rise
        return gap, 2 * self.system.reduce(carried), by_lam

    def along(self, rate: Array, state: State) -> Array:
        """Displacement (n, dim) per unit of load factor on the tangent at a state."""
        return self.system.motion(rate, 1.0, state.u)

    def distance(self, change: Array, rise: float) -> float:
        """Length of a step of displacements `change` (n, dim) and load factor `rise`."""
        return float(np.hypot(np.linalg.norm(change), self.weight * rise))

    def _dot(self, along: Array, change: Array, rise: float) -> float:
        return float((along * change).sum()) + self.weight**2 * rise

    def predict(self, increment: float, rate: Array) -> float:
        along = self.along(rate, self._origin)
        size = self.distance(along, 1.0)
        if size == 0 or not np.isfinite(size):
            return float("nan")
        if self.direction is not None:
            self.sense = 1.0 if self._dot(along, self.direction, self.load_direction) >= 0 else -1.0
        return self.sense * increment / size

    def load_rate(self, rate: Array, before: State, after: State) -> float:
        along = self.along(rate, before)
        ahead = self._dot(along, after.u - before.u, after.lam - before.lam)
        return float(np.sign(ahead) / self.distance(along, 1.0))

    def doubt(self, before: Point, attempt: Attempt, tangent: Tangent) -> str:
        state = attempt.state
        change, rise = state.u - before.state.u, state.lam - before.state.lam
        begin, end = self.along(before.tangent.rate, before.state), self.along(tangent.rate, state)
        walked = self.distance(change, rise)
        straight = self.sense * self._dot(begin, change, rise) / (self.distance(begin, 1.0) * walked)
        if straight < SHARPEST_TURN:
            return "the path would turn back on itself"
        if np.arccos(np.clip(straight, -1, 1)) + self._angle(end, change, rise) - self._between(begin, end) > BOTH_WAYS:
            return "the path bends to and fro within the increment, maybe to another path"
        turned = self._dot(end, change, rise) * self.sense < 0
        if turned and (tangent.factor.negative - before.negative) % 2 == 0 and straight < NEARLY_STRAIGHT:
            return "the load factor turned without a limit point, maybe on another branch"
        return ""

    def walked(self, before: State, after: State) -> float:
        return self.distance(after.u - before.u, after.lam - before.lam)

    def _angle(self, along: Array, change: Array, rise: float) -> float:
        """Angle [rad] between the line of a tangent and a step, at most a right one."""
        size = self.distance(along, 1.0) * self.distance(change, rise)
        return float(np.arccos(min(abs(self._dot(along, change, rise)) / size, 1.0)))

    def _between(self, begin: Array, end: Array) -> float:
        return self._angle(begin, end, 1.0)

    def accept(self, before: State, after: State) -> None:
        self.direction, self.load_direction = after.u - before.u, after.lam - before.lam

    @property
    def memory(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("weight", "direction", "load_direction", "sense")}
