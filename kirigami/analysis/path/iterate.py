"""An iterate at a given load factor: where it is, how far from equilibrium, and the corrections that all share."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kirigami.analysis.path.newton import BLOCKED, LEAST_SHARE, ROTATION_CAP
from kirigami.analysis.path.points import State, Stiffness
from kirigami.linalg import Factor, NearbyFactor, SingularMatrixError, nearby_factor
from kirigami.primitives.kernel import Ahead, Array, Tangent
from kirigami.system.system import System

CHORD_GAIN = 0.5  # a chord step must at least halve the residual to be kept
NEAR = 1e-4  # relative residual from which on the exact tangent is used
STILL = 1e-4  # turn of a member up to which an exact tangent stands for the equilibrium found with it [rad]
CLOSE = 5e-3  # ... up to which the factor of another tangent may do, if it is shown to [rad]
CHORDS_BELOW = 0.1  # relative residual from which on chord steps are worth trying


class Iterate:
    """Unknowns, residual and the last linear step of an iteration at a given load factor.

    Attributes
    ----------
    q, lam, u : ndarray (free,), float, ndarray (n, dim)
        Unknowns, load factor and displacements.
    residual, relative : ndarray (free,), float
        Unbalanced forces, and their norm over the root sum of squares of all unassembled forces.
    ahead : tuple of ndarray, or None
        The last linear step, whose stress the next tangent takes; see :class:`kirigami.Tangent`.
    history : list of float
        Relative residuals so far.
    """

    def __init__(
        self, system: System, factorize: Callable[[Array], Factor], start: State, tol: float, ahead: Ahead = None
    ) -> None:
        self.system, self.factorize, self.tol = system, factorize, tol
        self.q, self.lam, self.u = start.q.copy(), start.lam, start.u
        self.ahead = ahead
        self.residual, self.relative = np.zeros(0), 0.0
        self.history: list[float] = []
        self._taken: Stiffness | None = None  # the last tangent, and where
        self.balance()

    @property
    def state(self) -> State:
        """Where it is."""
        return State(self.q, self.lam, self.u)

    def balance(self) -> None:
        """Evaluate the residual."""
        with np.errstate(all="ignore"):
            self.residual, self.relative = self.system.imbalance(self.u, self.lam)

    def blocks(self, convexity: float = 0.0) -> Array:
        """Node blocks of the tangent, with the stress of the last linear step."""
        with np.errstate(all="ignore"):
            return self.system.stiffness_blocks(self.u, self.lam, Tangent(convexity, self.ahead))

    def factor(self) -> Factor:
        """Factor of the tangent; of the exact one, once the residual is small."""
        if self.relative < NEAR:
            self.ahead = None
        self._taken = None  # let go before the next is made: factors are the largest things in memory
        blocks = self.blocks()
        driven = self.system.drive_rate(self.lam, blocks)
        self._taken = Stiffness(driven, self.factorize(blocks), self.u, self.ahead)
        return self._taken.factor

    def stiffness(self) -> Stiffness:
        """The exact tangent at an equilibrium, answered for by the last factor where that is close enough."""
        last = self._taken
        moved = np.inf if last is None else self.system.largest_rotation(self.u - last.u)
        if last is not None and last.ahead is None and moved < STILL:
            return last
        self.ahead = None
        blocks = self.blocks()
        driven = self.system.drive_rate(self.lam, blocks)
        near = None
        if last is not None and moved < CLOSE and self.system.conservative:
            near = nearby_factor(self.system.matrix(blocks), last.factor)
        if last is not None and near is not None:
            self._taken = Stiffness(driven, near, last.u, last.ahead)
        else:
            last = self._taken = None
            self._taken = Stiffness(driven, self.factorize(blocks), self.u)
        return self._taken

    def let_go(self) -> None:
        """Forget the last tangent."""
        self._taken = None

    def correct(self, factor: Factor) -> None:
        """One correction, shortened where it would turn a member too far."""
        step = self.solve(factor)
        change = self.change(step)
        turn = self.system.largest_rotation(change)
        if not np.isfinite(turn):
            raise SingularMatrixError("the correction is not finite")
        if turn > ROTATION_CAP:
            step, change = (ROTATION_CAP / turn) * step, (ROTATION_CAP / turn) * change
        share = self.system.admissible(self.u, self.u + change)
        if share < 1:
            if share < LEAST_SHARE:
                raise SingularMatrixError(BLOCKED)
            step, change = share * step, share * change
        self.ahead = self.u, change
        self.move(step)
        self.balance()

    def chords(self, factor: Factor, most: int) -> None:
        """Up to `most` corrections with an old factor, as long as they lower the residual well."""
        factor = factor.near if isinstance(factor, NearbyFactor) else factor
        for _ in range(most):
            if not self.tol < self.relative < CHORDS_BELOW:
                return
            step = self.solve(factor)
            change = self.change(step)
            if not self.system.largest_rotation(change) < ROTATION_CAP:
                return
            if self.system.admissible(self.u, self.u + change) < 1:
                return
            with np.errstate(all="ignore"):
                residual, relative = self.system.imbalance(self.u + change, self.lam)
            if not relative < CHORD_GAIN * self.relative:
                return
            self.ahead = self.u, change
            self.move(step)
            self.residual, self.relative = residual, relative

    def solve(self, factor: Factor) -> Array:
        """The correction of a factor."""
        with self.system.clock("solve"):
            return -factor.solve(self.residual)

    def change(self, step: Array) -> Array:
        """Displacements (n, dim) of a step of the unknowns."""
        return self.system.displacement(self.q + step, self.lam) - self.u

    def move(self, step: Array) -> None:
        """Take a step of the unknowns."""
        self.q = self.q + step
        self.u = self.system.displacement(self.q, self.lam)
