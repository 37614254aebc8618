"""The walk along a path, common to all path methods: predict, correct, accept or cut back, store.

The path is walked in increments of the control's own parameter: predicted along the exact tangent of the last
equilibrium, corrected, accepted or cut back. A stored step is always a converged equilibrium; how many eigenvalues
are negative there is stored with it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NoReturn

import numpy as np

from kirigami.analysis.path.branching import leave_along_mode, switch
from kirigami.analysis.path.checkpoint import Checkpoint, resume
from kirigami.analysis.path.controls import LoadFactorControl
from kirigami.analysis.path.descent import CORRECTORS
from kirigami.analysis.path.events import JumpError, report_events
from kirigami.analysis.path.points import Attempt, Point, State, Tangent
from kirigami.analysis.path.run import PathRun
from kirigami.analysis.path.settings import PathSettings
from kirigami.errors import ConvergenceError, ModelError
from kirigami.progress import ProgressBar
from kirigami.results.results import Results
from kirigami.results.step import Event, Step

Recorder = Callable[[Step], None]

CUTS_AT_EVENTS = 8  # shorter increments tried where the path to a change of stability cannot be traced


class Walk(PathRun):
    """A run that goes from point to point, and stores each.

    Attributes
    ----------
    recorders : tuple of callables
        Each is called with every stored step.
    checkpoint : Checkpoint or None
        The file kept up to date on the way.
    bar : ProgressBar
        Shows how far it has come.
    """

    def __init__(self, settings: PathSettings, recorders: Iterable[Recorder] = ()) -> None:
        super().__init__(settings)
        self.recorders = tuple(recorders)
        self.checkpoint: Checkpoint | None = None
        self.bar = ProgressBar(False, "")

    def follow(self, stored: tuple[Results, dict[str, Any]] | None) -> None:
        """Walk from the start, or from where a checkpoint left off, to the end."""
        settings, results = self.settings, self.results
        start = self._starting_state()
        if stored is not None:
            point = resume(self, start, *stored)
        else:
            point = self._first_equilibrium(start) if settings.branch is None else self._begin_branch(start)
            self.increments = settings.plan(self.control, point)
        if self.downhill:
            strategy = CORRECTORS[settings.corrector]
            self.increments.least_growth = strategy.least_growth
            self.increments.growth_after_snap = strategy.growth_after_snap
        self.bar.start(self._progress(point))
        while len(results) <= settings.max_steps:
            stop = settings.on_instability == "stop" and len(results) > 1 and point.negative > 0
            if stop or settings.stops(results):
                return
            increment = self.increments.next_increment(self.control.value(point.state.q, point.state.lam))
            if increment is None:
                return
            before, known = point, len(results.events)
            point, attempt, increment = self._advance(before, increment)
            if settings.on_instability == "switch" and not isinstance(self.control, LoadFactorControl):
                before, point, attempt = switch(self, results.events[known:], before, point, attempt)
            self.control.accept(before.state, point.state)
            self._store(point, attempt)
            settings.steer(self.increments, results, point)
            self.increments.adapt(increment, attempt)
            if self.checkpoint is not None:
                self.checkpoint.note(self)
            self.bar.move(self._progress(point))
        message = f"ended after {settings.max_steps} steps, the most allowed, at load factor {results[-1].lam:.6g}"
        results.events.append(Event("step limit", results[-1].lam, len(results) - 1, message))

    def _advance(self, before: Point, increment: float) -> tuple[Point, Attempt, float]:
        """The next point, how it was found, and the increment that led there after as many cuts as it took."""
        system, results = self.system, self.results
        cuts, most = 0, CORRECTORS[self.settings.corrector].cuts
        while True:
            attempt, tangent = self._step(before, increment, cuts >= most or self.increments.is_short(increment))
            known = len(results.events)
            if tangent is not None:
                system.commit(attempt.state.u)
                point = Point(attempt.state, tangent, system.history)
                try:
                    report_events(self, before, point, increment, attempt.left, strict=cuts < CUTS_AT_EVENTS)
                    return point, attempt, increment
                except JumpError:
                    del results.events[known:]
                    attempt.reason = "the equilibrium found lies on another path"
            results.stats["cutbacks"] += 1
            cuts += 1
            system.history = before.history
            shorter = self.increments.cut(increment)
            if shorter is None:
                self._fail(attempt, increment)
            increment = shorter

    def _progress(self, point: Point) -> float | None:
        return self.increments.progress(self.control.value(point.state.q, point.state.lam))

    def write_checkpoint(self) -> None:
        """Write what the checkpoint, if there is one, has not written yet."""
        if self.checkpoint is not None:
            self.checkpoint.finish()

    def _step(self, before: Point, increment: float, hard: bool) -> tuple[Attempt, Tangent | None]:
        """One increment: downhill where unstable equilibria are to be left, else by Newton's method alone."""
        if self.downhill and not CORRECTORS[self.settings.corrector].newton_first:
            attempt = self.relax(before, increment, hold=hard)
            return attempt, self.tangent_at(attempt)
        attempt = self.try_increment(before, increment)
        tangent = self.tangent_at(attempt)
        if tangent is not None:
            attempt.reason = self.control.doubt(before, attempt, tangent)
            if attempt.reason:
                return attempt, None
        relax = hard if tangent is None else tangent.factor.negative > 0
        if self.downhill and relax:
            relaxed = self.relax(before, increment, hold=True)
            relaxed.relaxed = True
            relaxed_tangent = self.tangent_at(relaxed)
            if relaxed_tangent is not None:
                relaxed.left = None if tangent is None else Point(attempt.state, tangent, before.history)
                return relaxed, relaxed_tangent
        return attempt, tangent

    def _begin_branch(self, origin: State) -> Point:
        """The first step on a branch of the bifurcation that the analysis starts from, which is stored as step 0."""
        assert self.settings.start is not None and self.settings.mode is not None and self.settings.branch is not None
        self._record(self.settings.start)
        found = leave_along_mode(self, self.settings.start, self.settings.mode, self.settings.branch)
        if found is None:
            raise ConvergenceError(
                f"no branch was found along the mode of the bifurcation at load factor {self.settings.start.lam:.6g}",
                results=self.results,
                hint="start from the event of a run with a smaller step or tol, or perturb the model with event.mode",
            )
        self.control.accept(origin, found[0].state)
        self._store(*found)
        return found[0]

    def _starting_state(self) -> State:
        """Where the walk starts: at rest, or at a given step."""
        system, start = self.system, self.settings.start
        lam, u = 0.0, np.zeros_like(system.rest)
        if start is not None:
            if start.u.shape[0] != system.points:
                raise ModelError(f"start has {start.u.shape[0]} nodes, the model has {system.points}")
            u = system.joined(start.u, start.inner)
            if start.stage == system.model.stage:
                lam = start.lam
            else:
                system.start_stage(u)
            error = system.constraint_error(u, lam)
            if error > 1e-6 * system.size:
                raise ModelError(
                    f"start does not satisfy the constraints at load factor {lam:.6g} (off by {error:.3g}): "
                    "after changing supports call model.hold(step), which keeps what the earlier stage drove"
                )
            system.history = start.history
        q = system.unknowns(u)
        state = State(q, lam, system.displacement(q, lam))
        if start is not None and not any(value is not None for value in start.history):
            system.commit(state.u)
        return state

    def _first_equilibrium(self, state: State) -> Point:
        """Equilibrium at the starting load factor, stored as step 0."""
        system = self.system
        stay = LoadFactorControl()
        stay.begin(state, 0.0)
        tangent_there = self.first_factor(state.u, state.lam)
        attempt = self.correct(stay, state)
        if attempt.iterations == 0:
            attempt.stiffness = tangent_there
        if not attempt.converged:
            attempt = self.descend(state)
        tangent = self.tangent_at(attempt)
        if tangent is None:
            self._fail(attempt, 0.0)
        system.commit(attempt.state.u)
        point = Point(attempt.state, tangent, system.history)
        self._store(point, attempt)
        return point

    def _store(self, point: Point, attempt: Attempt) -> None:
        state = point.state
        self._record(self.make_step(state.u, state.lam, point.negative, attempt.residual, attempt.iterations))

    def _record(self, step: Step) -> None:
        self.results.append(step)
        for recorder in self.recorders:
            recorder(step)

    # ---- failure

    def _fail(self, attempt: Attempt, increment: float) -> NoReturn:
        system, results = self.system, self.results
        total, _ = system.forces(attempt.state.u, attempt.state.lam)
        unbalanced = np.zeros(system.rest.size)
        moving = system.unknown >= 0
        unbalanced[moving] = total.ravel()[moving]
        size = np.linalg.norm(unbalanced.reshape(total.shape)[: system.points], axis=1)
        worst = np.argsort(-np.nan_to_num(size, nan=np.inf), kind="stable")[:5].tolist()
        where = f"after load factor {results.steps[-1].lam:.6g}" if results.steps else "at the start"
        named = ", ".join(f"{k} {system.model.nodes[k]!r}" for k in worst[:3])
        raise ConvergenceError(
            f"no equilibrium found {where}, last increment {increment:.3g}: {attempt.reason or 'not converged'}; "
            f"largest unbalanced forces at nodes {named}",
            results=results,
            history=attempt.history,
            worst_nodes=worst,
            hint=self._hint(attempt),
        )

    def _hint(self, attempt: Attempt) -> str:
        negative = self.results.steps[-1].negative if self.results.steps else 0
        if negative:
            return (
                "the last step is unstable: a slightly different imperfection (Model.perturb with a mode of Eigen) "
                "lets the path take the stable branch"
            )
        if isinstance(self.control, LoadFactorControl) and not self.system.drive.any():
            return "past a limit point no equilibrium exists at a higher load: use DisplacementControl or ArcLength"
        return (
            "a larger imperfection (Model.perturb), a smaller step, or ArcLength where the path turns back; "
            "the results so far are in error.results"
        )
