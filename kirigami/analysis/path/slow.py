"""The corrector "slow": a slow pull with a little damping, as the reference for where a sheet lands.

The motion is c m du/dt = -(unbalanced force), the mass m lumped by area and c of no account, while the load factor
rises by ``d lam/dt = distance / (SLOW tau)``: slow against the distance of the load factor from the start, since
buckling comes at a small share of the range. tau is the slowest relaxation time of the state at rest. Each time step is
an implicit Euler step, found by a few corrections with the mixed stress of :mod:`kirigami.analysis.path.newton`; its
length follows from how far it leaves the extrapolation of the last one. The steps stored are the equilibria next to the
motion.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.analysis.path.events import tell_events
from kirigami.analysis.path.newton import BLOCKED
from kirigami.analysis.path.points import Attempt, Point, State
from kirigami.analysis.path.run import PathRun
from kirigami.analysis.path.stable import PUSH, SHARE
from kirigami.analysis.path.steps import Steps
from kirigami.analysis.path.tracking import track
from kirigami.linalg import Factor, SingularMatrixError, inverse_iteration
from kirigami.primitives.kernel import Ahead, Array, Tangent

SLOW = 100.0  # relaxation times in which the distance of the load factor from the start grows by a factor e
STANDSTILL = 1e-3  # least distance that counts for the speed, as a share of the range
OFF = 0.01  # turn by which a step may leave the extrapolation of the last one [rad]
TURN = 0.05  # largest turn of a member in a step [rad]
CORRECTIONS = 6  # most corrections of a step
CORRECTED = 0.05  # share of the step's turn below which a correction is the last one
CAP = 0.3  # largest turn in a correction [rad]
NEAR = 0.04  # largest turn from the motion to the equilibrium stored for it [rad]
RESTING = 1e-7  # motion at a held load that turns members by less in a relaxation time has come to rest [rad]
LEAST = 1e-12  # shortest time step, in relaxation times
UNSTABLE = "the step is too long for its own stability"


class SlowSteps(Steps):
    """Increments of the corrector "slow"; the motion goes on beneath the equilibria that are stored."""

    moving: Array | None = None  # unknowns of the motion (free,)
    moving_lam = 0.0
    velocity: Array | None = None
    time_step = 0.0
    relaxation = 0.0  # slowest relaxation time at the start

    def __init__(self, run: PathRun) -> None:
        super().__init__(run)
        self._diagonal: Any = None
        self._pattern: Any = None  # of the matrix that the diagonal is of

    @property
    def memory(self) -> dict[str, Any]:
        arrays = {"moving": self.moving, "velocity": self.velocity}
        plain = {name: getattr(self, name) for name in ("moving_lam", "time_step", "relaxation")}
        return {**super().memory, **plain, **{name: value for name, value in arrays.items() if value is not None}}

    def advance(self, before: Point, increment: float) -> tuple[Point, Attempt, float]:
        run = self.run
        if self.moving is None:
            self.moving, self.moving_lam = before.state.q, before.state.lam
            self.relaxation = _slowest_relaxation(before.tangent.factor, run.weight)
            self.time_step = 0.01 * self.relaxation
        if before.state.lam == run.increments.leg:
            self.velocity = None  # the way begins or turns
        try:
            while self.moving_lam != before.state.lam + increment:
                self._move(before.state.lam + increment)
            attempt = self._equilibrium(before)
        except _StuckError as error:
            attempt = Attempt(self._state(), False, float("inf"), 0, [], str(error))
        tangent = run.tangent_at(attempt)
        if tangent is None:
            raise run.failure(attempt, increment)
        run.system.commit(attempt.state.u, attempt.state.lam)
        point = Point(attempt.state, tangent, run.system.history)
        predicted = run.predict(before, increment)
        off = 0.0 if predicted is None else run.system.largest_rotation(point.state.u - predicted[0].u)
        tell_events(run, before, point, increment, attempt.left, off)
        return point, attempt, increment

    def settle(self, before: Point, after: Point, attempt: Attempt, increment: float) -> None:
        increments = self.run.increments
        increments.resize(increment, 2.0)
        distance = abs(after.state.lam - increments.leg)
        increments.size = min(increments.size, max(SHARE * distance, increments.first))

    def _state(self) -> State:
        assert self.moving is not None
        return State(self.moving, self.moving_lam, self.run.system.displacement(self.moving, self.moving_lam))

    def _equilibrium(self, before: Point) -> Attempt:
        """The stable equilibrium by the motion, which is held at its load factor until there is one."""
        run = self.run
        near, left = NEAR, None
        while True:
            state = self._state()
            tol, count = run.settings.tol, run.count_iteration
            attempt = track(run.system, run.factorize_blocks, state, tol, None, before.tangent.factor, count)
            stable = attempt.stiffness is not None and attempt.stiffness.factor.negative == 0
            if stable and attempt.drift < NEAR:
                attempt.left, attempt.relaxed = left, left is not None
                return attempt
            near *= 0.5
            while (speed := self._move(self.moving_lam)) > near:
                pass
            if speed < RESTING:
                if attempt.stiffness is None:
                    attempt = run.descend(self._state())  # as where forces vanish, which takes more corrections
                    attempt.drift = run.system.largest_rotation(attempt.state.u - self._state().u)
                    if attempt.converged and attempt.drift < NEAR:
                        return attempt
                if attempt.stiffness is None or attempt.drift > NEAR:
                    raise _StuckError("the motion came to rest at no equilibrium")
                tangent = run.tangent_at(attempt)
                assert tangent is not None
                left = left or Point(attempt.state, tangent, before.history)
                self._push(attempt.state, tangent.factor)

    def _push(self, state: State, factor: Factor) -> None:
        """Leave an unstable equilibrium at which the motion rests along its softest mode, since nothing else will."""
        system = self.run.system
        _, mode = inverse_iteration(factor, system.free, 8)
        mode *= np.sign(mode[np.argmax(np.abs(mode))])
        shape = system.motion(mode, about=state.u)
        self.moving, self.velocity = state.q + mode * (PUSH / system.largest_rotation(shape)), None
        self.time_step = 0.01 * self.relaxation

    def _move(self, target: float) -> float:
        """One time step towards `target`, or at a held load factor; turn of a member in it or in a relaxation time."""
        run, system, increments = self.run, self.run.system, self.run.increments
        before = self._state()
        distance = max(abs(before.lam - increments.leg), STANDSTILL * increments.longest)
        speed = float(np.sign(target - before.lam)) * distance / (SLOW * self.relaxation)
        while self.time_step > LEAST * self.relaxation:
            step, lam = self.time_step, before.lam + speed * self.time_step
            if (target - lam) * speed <= 1e-9 * abs(target - before.lam) * abs(speed) and speed:
                step, lam = (target - before.lam) / speed, target
            guess, ahead = State(before.q, lam, system.displacement(before.q, lam)), None
            if self.velocity is not None:
                q = before.q + step * self.velocity
                u = system.displacement(q, lam)
                if system.largest_rotation(u - before.u) <= TURN and system.admissible(before.u, u) == 1:
                    guess, ahead = State(q, lam, u), (before.u, u - before.u)
            after, reason = self._implicit_step(before, guess, step, ahead)
            if after is None:
                run.results.stats["cutbacks"] += 1
                self.time_step = 0.35 * step
                if reason != UNSTABLE:
                    self.velocity = None
                continue
            turn, off = (system.largest_rotation(after.u - u) for u in (before.u, guess.u))
            if turn > 1.2 * TURN or off > 1.2 * OFF:
                run.results.stats["cutbacks"] += 1
                self.time_step = step * max(0.25, 0.8 * min((OFF / off) ** 0.5, TURN / turn))
                continue
            growth = min(2.0, 0.9 * (OFF / max(off, 1e-12)) ** 0.5, 0.9 * TURN / max(turn, 1e-12))
            self.velocity = (after.q - before.q) / step
            self.moving, self.moving_lam = after.q, lam
            self.time_step = max(step, self.time_step if lam == target else 0.0) * max(growth, 0.3)
            return turn * max(self.relaxation / step, 1.0)
        raise _StuckError("the motion finds no next step")

    def _implicit_step(self, before: State, guess: State, step: float, ahead: Ahead) -> tuple[State | None, str]:
        """An implicit Euler step of the motion: the state after it, or why there is none."""
        run, system, weight = self.run, self.run.system, self.run.weight / step
        q, lam, u = guess.q, guess.lam, guess.u
        if system.admissible(before.u, u) < 1:
            return None, BLOCKED
        start = system.displacement(before.q, before.lam)
        try:
            for _ in range(CORRECTIONS):
                with np.errstate(all="ignore"):
                    residual, relative = system.imbalance(u, lam)
                    if not np.isfinite(relative):
                        return None, "a member collapsed"
                    matrix = system.matrix(system.stiffness_blocks(u, lam, Tangent(ahead=ahead)))
                factor = run.factorize(self._heavier(matrix, weight))
                if factor.negative:
                    return None, UNSTABLE
                with system.clock("solve"):
                    correction = -factor.solve(residual + weight * (q - before.q))
                change = system.displacement(q + correction, lam) - u
                turn = system.largest_rotation(change)
                if not turn < CAP:
                    return None, "a correction turns members too far"
                if system.admissible(u, u + change) < 1:
                    return None, BLOCKED
                ahead = u, change
                q = q + correction
                u = system.displacement(q, lam)
                run.count_iteration()
                if turn <= max(CORRECTED * system.largest_rotation(u - start), 1e-9):
                    return State(q, lam, u), ""
        except SingularMatrixError as error:
            return None, str(error)
        return None, "too many corrections"

    def _heavier(self, matrix: Any, weight: Array) -> Any:
        """The stiffness with a mass over a time step on its diagonal."""
        if self._pattern is not matrix.indices:  # contact changes it
            self._pattern = matrix.indices
            columns = np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))
            self._diagonal = np.flatnonzero(matrix.indices == columns)
        heavier = matrix.copy()
        heavier.data[self._diagonal] += weight
        return heavier


class _StuckError(Exception):
    """The motion cannot go on."""


def _slowest_relaxation(factor: Factor, weight: Array) -> float:
    """Largest eigenvalue of K^-1 M, by power iteration from a fixed start."""
    vector = np.random.default_rng(0).normal(size=len(weight))
    value = 0.0
    for _ in range(200):
        image = factor.solve(weight * vector)
        size = float(np.sqrt(weight @ image**2))
        vector, last, value = image / size, value, size
        if abs(value - last) < 1e-3 * value:
            break
    return value
