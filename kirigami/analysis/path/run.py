"""One run of a path: what is lowered and found, and how a point is predicted, corrected and examined."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from kirigami.analysis.base import Run
from kirigami.analysis.path.controls import Control, LoadFactorControl
from kirigami.analysis.path.descent import CORRECTORS, descend
from kirigami.analysis.path.increments import Increments
from kirigami.analysis.path.newton import correct
from kirigami.analysis.path.points import Attempt, Point, State, Tangent
from kirigami.analysis.path.settings import PathSettings
from kirigami.linalg import Factor, SingularMatrixError
from kirigami.primitives.kernel import Ahead, Array

MAX_ITERATIONS = 14
MAX_RELAXATION = 120
DRIFT_LARGEST = 0.25  # an equilibrium that far off the prediction may lie on another branch: the increment is cut [rad]
PREDICTED_TURN = 0.5  # a prediction that turns a member by more is cut before it is tried [rad]


class PathRun(Run):
    """One run of a path analysis.

    Attributes
    ----------
    settings : PathSettings
        What is to be done; a run reads it and changes nothing in it.
    control : Control
        The equation beside equilibrium.
    increments : Increments
        How far to go next.
    """

    increments: Increments

    def __init__(self, settings: PathSettings) -> None:
        super().__init__(settings)
        self.settings = settings
        self.control: Control = settings.make_control(self.system)
        self.system.check_supports()

    @property
    def memory(self) -> dict[str, Any]:
        """What must be stored to go on later as if nothing had been."""
        return {"increments": copy.deepcopy(vars(self.increments)), **self.control.memory}

    def go_on(self, memory: dict[str, Any], stats: dict[str, Any]) -> None:
        """Take up the memory and the counts of an earlier run."""
        self.increments = Increments(1.0, 1.0, 1.0)
        vars(self.increments).update(memory.pop("increments"))
        vars(self.control).update(memory)
        self.results.stats = stats
        self.take_seconds(stats["seconds"])

    @property
    def downhill(self) -> bool:
        """Whether unstable equilibria are left for stable ones at the same load factor."""
        return self.settings.on_instability == "switch" and isinstance(self.control, LoadFactorControl)

    def predict(self, before: Point, increment: float) -> tuple[State, Array] | None:
        """The state on the tangent, one increment on, and the change to it; None where the tangent leads nowhere."""
        state, rate = before.state, before.tangent.rate
        self.control.begin(state, increment)
        step_lam = self.control.predict(increment, rate)
        if not np.isfinite(step_lam):
            return None
        q, lam = state.q + step_lam * rate, state.lam + step_lam
        u = self.system.displacement(q, lam)
        return State(q, lam, u), u - state.u

    def try_increment(self, before: Point, increment: float) -> Attempt:
        """Predict along the tangent and correct by Newton's method."""
        system = self.system
        predicted = self.predict(before, increment)
        if predicted is None:
            return Attempt(before.state, False, float("inf"), 0, [], "the control does not act on the structure")
        state, change = predicted
        if system.largest_rotation(change) > PREDICTED_TURN:
            return Attempt(before.state, False, float("inf"), 0, [], "the increment turns members too far")
        attempt = self.correct(self.control, state, (before.state.u, change))
        attempt.iterations += 1
        attempt.drift = system.largest_rotation(attempt.state.u - state.u)
        if attempt.converged and attempt.drift > DRIFT_LARGEST:
            attempt.converged = False
            attempt.reason = f"equilibrium found {attempt.drift:.2f} rad off the prediction, maybe on another branch"
        return attempt

    def relax(self, before: Point, increment: float, hold: bool) -> Attempt:
        """Run downhill from the prediction to a stable equilibrium.

        Near a limit point the tangent shoots off: then fail, or with `hold` move only what is driven, and let the rest
        follow.
        """
        system, strategy = self.system, CORRECTORS[self.settings.corrector]
        predicted = self.predict(before, increment)
        assert predicted is not None  # the load factor itself is the parameter
        state, change = predicted
        if system.largest_rotation(change) > strategy.turn:
            if not hold:
                return Attempt(before.state, False, float("inf"), 0, [], "the increment turns members too far")
            q = before.state.q
            state = State(q, state.lam, system.displacement(q, state.lam))
            change = state.u - before.state.u
        attempt = self.descend(state, (before.state.u, change))
        attempt.iterations += 1
        attempt.drift = system.largest_rotation(attempt.state.u - state.u)
        attempt.relaxed = attempt.drift > DRIFT_LARGEST
        if attempt.left_at is not None:
            left, blocks, factor = attempt.left_at
            attempt.relaxed = True
            if system.largest_rotation(left.u - state.u) <= DRIFT_LARGEST:  # else the descent came from elsewhere
                rate = -factor.solve(system.load_rate(left.u, left.lam, blocks))
                attempt.left = Point(left, Tangent(blocks, factor, rate), before.history)
        self.results.stats["relaxations"] += int(attempt.relaxed or strategy.newton_first)
        return attempt

    def correct(self, control: Control, state: State, ahead: Ahead = None) -> Attempt:
        """Correct a state, which a linear step `ahead` may have led to, by Newton's method under any control."""
        tol, count = self.settings.tol, self.count_iteration
        return correct(self.system, self.factorize_blocks, control, state, tol, MAX_ITERATIONS, count, ahead)

    def descend(self, state: State, ahead: Ahead = None) -> Attempt:
        """Run downhill from a state, at its load factor, by the means of the corrector that was chosen."""
        strategy, tol, count = CORRECTORS[self.settings.corrector], self.settings.tol, self.count_iteration
        return descend(self.system, self.factorize_blocks, state, tol, MAX_RELAXATION, strategy, count, ahead)

    def tangent_at(self, attempt: Attempt) -> Tangent | None:
        """The exact tangent at a converged state; None where the attempt failed or the tangent is singular."""
        if not attempt.converged:
            return None
        system, state = self.system, attempt.state
        try:
            if attempt.stiffness is not None:
                blocks, factor = attempt.stiffness
            else:
                with np.errstate(all="ignore"):  # a member without length is told of where the step is stored
                    blocks = system.stiffness_blocks(state.u, state.lam)
                factor = self.factorize_blocks(blocks)
            with system.clock("solve"), np.errstate(all="ignore"):
                rate = -factor.solve(system.load_rate(state.u, state.lam, blocks))
        except SingularMatrixError as error:
            attempt.reason = str(error)
            return None
        return Tangent(blocks, factor, rate)

    def factorize_blocks(self, blocks: Array) -> Factor:
        """Factor of the reduced matrix of assembled blocks."""
        return self.factorize(self.system.matrix(blocks))

    def count_iteration(self) -> None:
        """One more correction."""
        self.results.stats["iterations"] += 1
