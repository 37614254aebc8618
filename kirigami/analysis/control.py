"""Controls: the one equation beside equilibrium that says how far along the path to go."""

from __future__ import annotations

import numpy as np

from kirigami.analysis.state import State
from kirigami.constraints import AXES
from kirigami.errors import ModelError
from kirigami.kernel import Array
from kirigami.model import Node
from kirigami.system import System


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


class LoadFactorControl(Control):
    """The parameter is the load factor."""

    def value(self, q: Array, lam: float) -> float:
        return lam

    def equation(self, q: Array, lam: float) -> tuple[float, Array | None, float]:
        return lam - self.target, None, 1.0

    def predict(self, increment: float, rate: Array) -> float:
        return increment


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


class ArcLengthControl(Control):
    """The parameter is the distance walked in displacement space (cylindrical arc, Crisfield 1981).

    The arc's equation is linearised anew at each iterate (Ramm 1981), so no quadratic root is chosen. The direction
    is the one that goes on from the last step.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.direction: Array | None = None  # displacement of the last accepted step (n, dim)
        self.sense = 1.0
        self._drive = system.drive
        self._moving = system.unknown >= 0
        self._origin = State(np.zeros(system.free), 0.0, system.rest * 0)
        self._length = 0.0

    def value(self, q: Array, lam: float) -> float:
        return self.target

    def begin(self, state: State, increment: float) -> None:
        self._origin, self._length = state, increment
        self.slack = 1e-9 * increment**2

    def equation(self, q: Array, lam: float) -> tuple[float, Array | None, float]:
        walked = self.system.displacement(q, lam) - self._origin.u
        gap = float((walked**2).sum()) - self._length**2
        if not walked.any():
            return -self._length, None, 0.0
        by_lam = 2 * float((walked.ravel() * self._drive).sum())
        return gap, 2 * self.system.reduce(walked), by_lam

    def along(self, rate: Array) -> Array:
        """Displacement (n, dim) per unit of load factor on the tangent."""
        return self.system.displacement(rate, 1.0) - self.system.displacement(0 * rate, 0.0)

    def predict(self, increment: float, rate: Array) -> float:
        along = self.along(rate)
        size = float(np.linalg.norm(along))
        if size == 0 or not np.isfinite(size):
            return float("nan")
        if self.direction is not None:
            self.sense = 1.0 if float((along * self.direction).sum()) >= 0 else -1.0
        return self.sense * increment / size
