"""The walk along a path, common to all path methods: predict, correct, accept or cut back, store.

The path is walked in increments of the control's own parameter: predicted along the exact tangent of the last
equilibrium, corrected, accepted or cut back. A stored step is always a converged equilibrium; how many eigenvalues
are negative there is stored with it.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable
from typing import Any

from kirigami.analysis.path.begin import grown
from kirigami.analysis.path.branching import leave_along_mode, switch
from kirigami.analysis.path.checkpoint import Checkpoint, resume
from kirigami.analysis.path.controls import LoadFactorControl
from kirigami.analysis.path.increments import Increments
from kirigami.analysis.path.points import Attempt, Point, State, Stiffness
from kirigami.analysis.path.release import gather
from kirigami.analysis.path.run import PathRun
from kirigami.analysis.path.settings import PathSettings
from kirigami.analysis.path.slow import SlowSteps
from kirigami.analysis.path.stable import StableSteps
from kirigami.analysis.path.steps import NewtonSteps, Steps
from kirigami.analysis.resumable import Recorder
from kirigami.errors import ConvergenceError
from kirigami.progress import ProgressBar
from kirigami.results.results import Results
from kirigami.results.step import Event, Step
from kirigami.words import counted

# Where unstable equilibria are left; else increments are made by Newton's method.
STEPS: dict[str, type[Steps]] = {"path": StableSteps, "slow": SlowSteps}


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
        self.steps: Steps = self._make_steps()

    def _make_steps(self) -> Steps:
        if not self.downhill:
            return NewtonSteps(self)
        if self.settings.settle == "dynamics":
            from kirigami.analysis.path.inertial import InertialSteps  # what does not move needs no masses

            return InertialSteps(self)
        return STEPS.get(self.settings.corrector, NewtonSteps)(self)

    @property
    def memory(self) -> dict[str, Any]:
        """What must be stored to go on later as if nothing had been."""
        own = {f"steps.{name}": value for name, value in self.steps.memory.items()}
        return {
            "increments": copy.deepcopy(vars(self.increments)), **self.control.memory, **own, **self.system.memory
        }  # fmt: skip

    @memory.setter
    def memory(self, stored: dict[str, Any]) -> None:
        self.increments = Increments(1.0, 1.0, 1.0)
        vars(self.increments).update(stored["increments"])
        self.system.remember(stored)
        vars(self.control).update({name: stored[name] for name in self.control.memory})
        for name in [name for name in stored if name.startswith("steps.")]:
            setattr(self.steps, name.removeprefix("steps."), stored[name])

    def follow(self, stored: tuple[Results, dict[str, Any]] | None) -> None:
        """Walk from the start, or from where a checkpoint left off, to the end."""
        settings, results = self.settings, self.results
        start = self._starting_state()
        if stored is not None:
            point = resume(self, start, *stored)
        else:
            point = self._first_equilibrium(start) if settings.branch is None else self._begin_branch(start)
            self.increments = settings.plan(self.control, point)
        self.bar.start(self._progress(point))
        while len(results) <= settings.max_steps:
            stop = settings.on_instability == "stop" and len(results) > 1 and point.negative > 0
            if stop or settings.stops(results):
                return
            increment = self.increments.next_increment(self.control.value(point.state.q, point.state.lam))
            if increment is None:
                return
            before, known = point, len(results.events)
            point, attempt, increment = self.steps.advance(before, increment)
            gather(results.events)
            if settings.on_instability == "switch" and not isinstance(self.control, LoadFactorControl):
                before, point, attempt = switch(self, results.events[known:], before, point, attempt)
            self.steps.note(attempt)
            self.control.accept(before.state, point.state)
            self._store(point, attempt)
            settings.steer(self.increments, results, point)
            self.steps.settle(before, point, attempt, increment)
            if self.checkpoint is not None:
                self.checkpoint.note(self)
            self.bar.move(self._progress(point))
        steps = counted(settings.max_steps, "step")
        message = f"ended after {steps}, the most allowed, at load factor {results[-1].lam:.6g}"
        results.events.append(Event("step limit", results[-1].lam, len(results) - 1, message))

    def _progress(self, point: Point) -> float | None:
        return self.increments.progress(self.control.value(point.state.q, point.state.lam))

    def where(self) -> str:
        """How far it has come, in words."""
        return f"load factor {self.results.steps[-1].lam if self.results.steps else 0.0:.6g}"

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
        q, lam = self.begin_at(self.settings.start)
        return State(q, lam, self.system.displacement(q, lam))

    def _first_equilibrium(self, state: State) -> Point:
        """Equilibrium at the starting load factor, stored as step 0."""
        system = self.system
        stay = LoadFactorControl()
        stay.begin(state, 0.0)
        blocks, factor = self.first_factor(state.u, state.lam)
        tangent_there = Stiffness(system.drive_rate(state.lam, blocks), factor, state.u)
        del blocks, factor
        attempt = self.correct(stay, state)
        if attempt.iterations == 0:
            attempt.stiffness = tangent_there
        del tangent_there
        if not attempt.converged:
            attempt = self.descend(state)
        if not attempt.converged and self.settings.start is None:
            attempt = grown(self, state)
        tangent = self.tangent_at(attempt)
        if tangent is None:
            raise self.failure(attempt, 0.0)
        system.commit(attempt.state.u, attempt.state.lam)
        point = Point(attempt.state, tangent, system.history)
        self._store(point, attempt)
        return point

    def _store(self, point: Point, attempt: Attempt) -> None:
        state = point.state
        self._record(self.make_step(state.u, state.lam, point.negative, attempt.residual, attempt.iterations))

    def _record(self, step: Step) -> None:
        step = self.store(step)
        for recorder in self.recorders:
            recorder(step)
