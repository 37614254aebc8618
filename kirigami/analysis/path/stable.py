"""The corrector "path": along the stable path, and where it is lost downhill from close by.

A sheet that is pulled slowly follows the stable equilibria that hang together, and where they end it moves downhill.
Long increments lead elsewhere: nearly all of the error of the other correctors is made in the first one, which passes
the first buckle. So

* the increments are as long as the path is smooth: predicted with the tangent and its change, corrected a few times
  (:mod:`kirigami.analysis.path.tracking`), kept where the corrections are small against the distance moved;
* where the path is lost or bends sharply, the descent starts from a short way on: at most a quarter of the distance
  from the start, and where it sets energy free a twentieth of it, so that the snap is bracketed. A long descent that
  falls below any smooth path is given up: where it would land only shows that there is a snap;
* where the path goes on unstable, the descent leaves along the softest mode of the last stable equilibrium, in the
  sense in which the path was moving, which is the side that an imperfection chooses (it is asked at an equilibrium as
  good as numbers allow, since a residual within the tolerance hides the imperfection of a very thin sheet); the first
  time, where a flat sheet buckles, from as close.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.analysis.path.descent import FELL
from kirigami.analysis.path.events import tell_events
from kirigami.analysis.path.points import Attempt, Point, State, Tangent
from kirigami.analysis.path.release import least_potential, worth_bracketing
from kirigami.analysis.path.steps import Steps
from kirigami.analysis.path.tracking import track
from kirigami.linalg import SingularMatrixError, inverse_iteration, lowest_of_pencil
from kirigami.primitives.kernel import Array

FIRST = 1e-4  # first increment, as a share of the range
SHARE = 0.25  # most that an increment may be, as a share of the distance from the start
CLOSE = 0.05  # share of the distance from the start to which a snap is bracketed
CLOSE_TO_LIMIT = 1e-3  # the same where forces drive: beyond a limit load there is no path, and it is a sharp value
CUT = 0.4  # factor of an increment that was too long
HALF = 0.5  # factor of an increment that a snap was found in
MOST_FAILURES = 20  # descents that may fail while the path moves on by short increments alone
FELT_OUT = 10.0  # most that increments grow at once before a place where a descent failed
NEXT_TO = 0.1  # share of the shortest increment of a snap below which a descent starts next to where it lands
UP_TO_LOSS = 0.9  # most of such a factor where it follows from where stability is lost
SMOOTH = 0.5  # most that corrections may turn members, as a share of what the increment turns them
STRAIGHT = 0.02  # the same where a path goes on unstable: it was predicted to second order, from close by
HARMLESS = 1e-3  # ... or this angle [rad]
WANTED = 0.02  # turn by which corrections shall leave the prediction: steers the increments [rad]
PREDICTED_TURN = 0.2  # a prediction that turns a member by more is not followed [rad]
DESCENT_TURN = 1.0  # turn up to which a prediction is followed before a descent [rad]
LOST_TURN = 3.0  # a prediction that turns a member by more says nothing [rad]
PUSH = 0.01  # turn by which an unstable equilibrium is left along the softest mode [rad]


class StableSteps(Steps):
    """Increments of the corrector "path"."""

    buckled = False  # whether the path was lost before: a flat sheet takes its side once
    rate: Array | None = None  # change of the unknowns with the load factor at the last but one point of a smooth path
    rate_lam = 0.0  # its load factor
    snap: float | None = None  # load factor before which a snap is known to lie ahead
    trouble: float | None = None  # load factor ahead at which no equilibrium was found
    failures = 0  # descents that failed since an increment was last longer than the shortest of a snap
    loss: float | None = None  # load factor at which the flat sheet seems to lose its stability

    def advance(self, before: Point, increment: float) -> tuple[Point, Attempt, float]:
        run, increments = self.run, self.run.increments
        distance = abs(before.state.lam - increments.leg)
        driven = bool(run.system.drive.any())
        least = max((CLOSE if driven else CLOSE_TO_LIMIT) * distance, increments.smallest)
        reach = max(SHARE * distance, increments.smallest)
        sense = float(np.sign(increment))
        while True:
            short = abs(increment) <= least * 1.0001
            attempt, guess, turn = self._along(before, increment)
            tangent = run.tangent_at(attempt)
            if tangent is not None and tangent.factor.negative == 0 and self._is_smooth(before, attempt):
                return self._accept(attempt, tangent), attempt, increment
            unstable = tangent is not None and tangent.factor.negative > 0
            closer = (unstable and not self.buckled) or turn > LOST_TURN or self.snap is not None or not driven
            if abs(increment) > 1.0001 * reach or (closer and not short):
                shorter = min(CUT * abs(increment), reach)
                if tangent is not None and unstable:
                    share = self._share_to_loss(before, tangent)
                    self.loss = before.state.lam + share * increment
                    shorter = min(share * abs(increment) - 0.5 * least, reach)
                increment = self._cut(before, sense * max(shorter, least))
                del attempt, tangent  # and their factor with them
                continue
            if tangent is not None and not unstable:  # a descent would only find it again
                landed = attempt
                landed.drift, landed.relaxed = run.system.largest_rotation(landed.state.u - guess.u), True
            else:
                floor = least_potential(run, before, increment) if self.buckled and not short else -np.inf
                landed = self._downhill(before, guess, attempt, tangent, increment, turn, floor, least)
            if landed.reason == FELL:
                increment = self._bracket(before, increment, least)
                del attempt, tangent, landed  # and their factors with them
                continue
            landed_tangent = run.tangent_at(landed)
            if landed_tangent is None:
                increment = self.cut(before, landed, increment)
                continue
            run.system.commit(landed.state.u, landed.state.lam)
            point = Point(landed.state, landed_tangent, run.system.history)
            if not short and worth_bracketing(run, before, point):
                increment = self._bracket(before, increment, least)
                continue
            self.buckled = True
            tell_events(run, before, point, increment, landed.left, landed.drift, short)
            return point, landed, increment

    def _share_to_loss(self, before: Point, tangent: Tangent) -> float:
        """Share of an increment to an unstable equilibrium after which the path loses its stability.

        The stiffness changes in proportion to the load factor as long as members hardly turn; where its determinant
        vanishes, the pencil of the stiffness there and here tells.
        """
        lowest, _ = lowest_of_pencil(tangent.factor.matrix, before.tangent.factor)
        return float(np.clip(1.0 / (1.0 - lowest), 0.0, UP_TO_LOSS))

    def _bracket(self, before: Point, increment: float, least: float) -> float:
        """A shorter increment where one met a snap."""
        self.snap = before.state.lam + increment
        return self._cut(before, float(np.sign(increment)) * max(HALF * abs(increment), least))

    def _cut(self, before: Point, increment: float) -> float:
        self.run.results.stats["cutbacks"] += 1
        self.run.system.history = before.history
        return increment

    def _along(self, before: Point, increment: float) -> tuple[Attempt, State, float]:
        """An attempt along the path, the prediction on its tangent, and the turn to that."""
        run, system = self.run, self.run.system
        predicted = run.predict(before, increment)
        assert predicted is not None  # the load factor itself is the parameter
        ahead, change = predicted
        turn = system.largest_rotation(change)
        if not turn < PREDICTED_TURN:
            return Attempt(before.state, False, float("inf"), 0, [], "the increment turns members too far"), ahead, turn
        start = ahead
        if self.rate is not None and self.rate_lam != before.state.lam:
            bend = 0.5 * increment**2 * (before.tangent.rate - self.rate) / (before.state.lam - self.rate_lam)
            bent = system.displacement(ahead.q + bend, ahead.lam)
            near = system.largest_rotation(bent - ahead.u) < 0.5 * turn
            if near and system.admissible(before.state.u, bent) == 1:
                start = State(ahead.q + bend, ahead.lam, bent)
        if (blocked := run.blocked(before, start)) is not None:
            return blocked, ahead, turn
        tol, count = run.settings.tol, run.count_iteration
        linear = before.state.u, change
        attempt = track(system, run.factorize_blocks, start, tol, linear, before.tangent.factor, count)
        attempt.iterations += 1
        return attempt, ahead, turn

    def _is_smooth(self, before: Point, attempt: Attempt) -> bool:
        """Whether corrections were small against the distance moved, as on one smooth path."""
        moved = self.run.system.largest_rotation(attempt.state.u - before.state.u)
        return attempt.drift < max(SMOOTH * moved, HARMLESS)

    def _goes_on(self, before: Point, attempt: Attempt) -> bool:
        """Whether an unstable equilibrium may be on the same path: beside an imperfect bifurcation lie others."""
        moved = self.run.system.largest_rotation(attempt.state.u - before.state.u)
        return attempt.drift < STRAIGHT * moved

    def _accept(self, attempt: Attempt, tangent: Tangent) -> Point:
        self.run.system.commit(attempt.state.u, attempt.state.lam)
        return Point(attempt.state, tangent, self.run.system.history)

    def _downhill(
        self,
        before: Point,
        guess: State,
        attempt: Attempt,
        tangent: Tangent | None,
        increment: float,
        turn: float,
        floor: float,
        least: float,
    ) -> Attempt:
        """A descent at the end of the increment; it tells which unstable equilibrium it left, if any."""
        run, system = self.run, self.run.system
        linear = None
        left: Point | None = None
        if tangent is not None and tangent.factor.negative:
            if self._goes_on(before, attempt):
                left = Point(attempt.state, tangent, before.history)
            start = self._off(before, guess, increment)
        elif turn <= DESCENT_TURN:
            start, linear = guess, (before.state.u, guess.u - before.state.u)
        else:
            part = DESCENT_TURN / turn if turn < LOST_TURN else 0.0
            q = before.state.q + part * (guess.q - before.state.q)
            start = State(q, guess.lam, system.displacement(q, guess.lam))
            linear = before.state.u, start.u - before.state.u
        if (blocked := run.blocked(before, start)) is not None:
            return blocked
        next_to = self.buckled and abs(increment) < NEXT_TO * least
        # A flat sheet takes its side as a whole.
        landed = run.descend(start, linear, floor, places=self.buckled, share=0.5 if next_to else 1.0)
        landed.iterations += 1
        landed.drift = system.largest_rotation(landed.state.u - guess.u)
        landed.relaxed = True
        if left is None and landed.left_at is not None:
            unstable, stiffness = landed.left_at
            met = Attempt(unstable, True, 0.0, 0, drift=system.largest_rotation(unstable.u - guess.u))
            if self._goes_on(before, met):
                left = Point(unstable, run.tangent(unstable, stiffness), before.history)
        landed.left = left
        run.results.stats["relaxations"] += 1
        return landed

    def _off(self, before: Point, guess: State, increment: float) -> State:
        """The prediction, pushed a little along the softest mode of the last stable equilibrium."""
        system = self.run.system
        try:
            _, mode = inverse_iteration(before.tangent.factor, system.free, 30, 1e-3)
            along = float(mode @ self.run.settled_rate(before)) * np.sign(increment)
        except SingularMatrixError:
            return guess
        mode *= np.sign(along) or 1.0
        shape = system.motion(mode, about=guess.u)
        q = guess.q + mode * (PUSH / system.largest_rotation(shape))
        return State(q, guess.lam, system.displacement(q, guess.lam))

    def settle(self, before: Point, after: Point, attempt: Attempt, increment: float) -> None:
        increments = self.run.increments
        distance = abs(after.state.lam - increments.leg)
        short = max(CLOSE * distance, increments.smallest)
        if abs(increment) >= short:
            self.failures = 0
        if self.trouble is not None and (self.trouble - after.state.lam) * increment <= 0:
            self.trouble = None  # passed
        if attempt.relaxed:
            self.rate = None
            # Beyond a snap the way is free again; before a place where a descent failed it is felt out.
            far = SHARE * distance / abs(increment)
            increments.resize(increment, max(2.0, far if self.trouble is None else min(far, FELT_OUT)))
        else:
            self.rate, self.rate_lam = before.tangent.rate, before.state.lam
            increments.resize(increment, float(np.clip((WANTED / max(attempt.drift, 1e-9)) ** 0.5, 0.5, 2.0)))
        straight = not attempt.relaxed and attempt.drift < 0.01 * WANTED
        share = 1.0 if straight else SHARE  # as before the first buckle
        least = increments.smallest if self.buckled else increments.first
        increments.size = min(increments.size, max(share * distance, least))
        self._hold_back(after.state.lam, float(np.sign(increment)), short)

    def cut(self, before: Point, attempt: Attempt, increment: float) -> float:
        self.failures += 1
        self.trouble = before.state.lam + increment
        if self.failures > MOST_FAILURES:
            raise self.run.failure(attempt, increment)
        return super().cut(before, attempt, increment)

    def _hold_back(self, lam: float, sense: float, short: float) -> None:
        """Shorten the next increment, down to `short`, before a snap or a loss of stability known to lie ahead."""
        increments = self.run.increments
        if self.snap is not None:
            if (ahead := (self.snap - lam) * sense) > 1e-6 * short:
                increments.size = min(increments.size, max(HALF * ahead, short))
            else:
                self.snap = None
        if self.loss is not None and not self.buckled and (ahead := (self.loss - lam) * sense) > 0:
            increments.size = min(increments.size, max(ahead - 0.5 * short, short))

    @property
    def memory(self) -> dict[str, Any]:
        own: dict[str, Any] = {} if self.rate is None else {"rate": self.rate, "rate_lam": self.rate_lam}
        places = {"snap": self.snap, "loss": self.loss, "trouble": self.trouble}
        own |= {name: place for name, place in places.items() if place is not None}
        return {**super().memory, "buckled": self.buckled, "failures": self.failures, **own}
