"""How an increment is made, by corrector: attempts, cuts, and the events between the two points."""

from __future__ import annotations

from typing import Any

from kirigami.analysis.path.descent import CORRECTORS
from kirigami.analysis.path.events import JumpError, report_events
from kirigami.analysis.path.points import Attempt, Point, State, Stiffness, Tangent
from kirigami.analysis.path.run import PathRun
from kirigami.linalg import Factor, NearbyFactor
from kirigami.primitives.kernel import Array
from kirigami.primitives.kernel import Tangent as Linearised

CUTS_AT_EVENTS = 8  # shorter increments tried where the path to a change of stability cannot be traced


class Steps:
    """From one point to the next; what is remembered between increments is in :attr:`memory`."""

    taken_at: Array | None = None  # displacements that the factor of the last point was made at
    taken_from: Array | None = None  # where the linear step starts whose stress it took, if any
    taken_step: Array | None = None  # its change
    nearby = False  # whether it answers for another matrix

    def __init__(self, run: PathRun) -> None:
        self.run = run

    def advance(self, before: Point, increment: float) -> tuple[Point, Attempt, float]:
        """The next point, how it was found, and the increment that led there after as many cuts as it took."""
        raise NotImplementedError

    def settle(self, before: Point, after: Point, attempt: Attempt, increment: float) -> None:
        """Adjust the increments once `after` is accepted."""
        self.run.increments.adapt(increment, attempt)

    @property
    def memory(self) -> dict[str, Any]:
        """Attributes that must be stored to go on later as if nothing had been."""
        arrays = {name: getattr(self, name) for name in ("taken_at", "taken_from", "taken_step")}
        return {"nearby": self.nearby, **{name: value for name, value in arrays.items() if value is not None}}

    def note(self, attempt: Attempt) -> None:
        """Remember how the factor of an accepted point was made, to make it again after an interruption."""
        taken = attempt.stiffness
        self.taken_at = None if taken is None else taken.u
        self.taken_from, self.taken_step = (None, None) if taken is None or taken.ahead is None else taken.ahead
        self.nearby = taken is not None and isinstance(taken.factor, NearbyFactor)

    def retake(self, state: State) -> Stiffness | None:
        """The factor noted, made again at a point."""
        if self.taken_at is None:
            return None
        run, system = self.run, self.run.system
        ahead = None if self.taken_from is None or self.taken_step is None else (self.taken_from, self.taken_step)
        blocks = system.stiffness_blocks(self.taken_at, state.lam, Linearised(ahead=ahead))
        factor: Factor = run.factorize_blocks(blocks)
        if self.nearby:
            blocks = system.stiffness_blocks(state.u, state.lam)
            factor = NearbyFactor(system.matrix(blocks), factor)
        return Stiffness(system.drive_rate(state.lam, blocks), factor, self.taken_at, ahead)

    def cut(self, before: Point, attempt: Attempt, increment: float) -> float:
        """A shorter increment after an attempt that is not to be kept, or a ConvergenceError."""
        run = self.run
        run.results.stats["cutbacks"] += 1
        run.system.history = before.history
        shorter = run.increments.cut(increment)
        if shorter is None:
            raise run.failure(attempt, increment)
        return shorter


class NewtonSteps(Steps):
    """Newton's method at shorter and shorter increments; downhill where unstable equilibria are to be left."""

    def advance(self, before: Point, increment: float) -> tuple[Point, Attempt, float]:
        run, events = self.run, self.run.results.events
        cuts, most = 0, CORRECTORS[run.settings.corrector].cuts
        while True:
            attempt, tangent = self._attempt(before, increment, cuts >= most or run.increments.is_short(increment))
            known = len(events)
            if tangent is not None and cuts < CUTS_AT_EVENTS and run.control.hides_turns(before, attempt, tangent):
                attempt.reason, tangent = "the load factor seems to turn twice within the increment", None
            if tangent is not None:
                run.system.commit(attempt.state.u, attempt.state.lam)
                point = Point(attempt.state, tangent, run.system.history)
                try:
                    strict = attempt.left is None and cuts < CUTS_AT_EVENTS
                    landed = attempt.drift if attempt.relaxed else 0.0
                    report_events(run, before, point, increment, attempt.left, strict, landed)
                    return point, attempt, increment
                except JumpError:
                    del events[known:]
                    attempt.reason = "the equilibrium found lies on another path"
            increment = self.cut(before, attempt, increment)
            cuts += 1

    def _attempt(self, before: Point, increment: float, hard: bool) -> tuple[Attempt, Tangent | None]:
        """One increment: downhill where unstable equilibria are to be left, else by Newton's method alone."""
        run = self.run
        if run.downhill and not CORRECTORS[run.settings.corrector].newton_first:
            attempt = run.relax(before, increment, hold=hard)
            return attempt, run.tangent_at(attempt)
        attempt = run.try_increment(before, increment)
        tangent = run.tangent_at(attempt)
        if tangent is not None and not run.downhill:  # which tells by the energy set free
            attempt.reason = run.control.doubt(before, attempt, tangent)
            if attempt.reason:
                return attempt, None
        relax = hard if tangent is None else tangent.factor.negative > 0
        if run.downhill and relax:
            relaxed = run.relax(before, increment, hold=True)
            relaxed.relaxed = True
            relaxed_tangent = run.tangent_at(relaxed)
            if relaxed_tangent is not None:
                relaxed.left = None if tangent is None else Point(attempt.state, tangent, before.history)
                return relaxed, relaxed_tangent
        return attempt, tangent
