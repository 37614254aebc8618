"""The walk along a path, common to all path methods: predict, correct, accept or cut back, store.

The path is walked in increments of the control's own parameter: predicted along the exact tangent of the last
equilibrium, corrected, accepted or cut back. A stored step is always a converged equilibrium; how many eigenvalues
are negative there is stored with it.
"""

from __future__ import annotations

import copy
import os
import warnings
from collections.abc import Callable, Iterable
from typing import Any, NoReturn

import numpy as np

from kirigami.analysis.base import Analysis, make_step
from kirigami.analysis.path.branching import leave_along_mode, switch
from kirigami.analysis.path.checkpoint import Checkpoint, fingerprint, resume_walk, settings_of
from kirigami.analysis.path.controls import Control, LoadFactorControl
from kirigami.analysis.path.descent import CORRECTORS, descend
from kirigami.analysis.path.events import JumpError, report_events
from kirigami.analysis.path.increments import Increments
from kirigami.analysis.path.newton import correct
from kirigami.analysis.path.points import Attempt, Point, State, Tangent
from kirigami.errors import ConvergenceError, KirigamiWarning, ModelError
from kirigami.linalg import Factor, SingularMatrixError, one_thread
from kirigami.model.model import Model
from kirigami.primitives.checks import require_positive
from kirigami.primitives.kernel import Array
from kirigami.progress import progress_bar
from kirigami.results.results import Results
from kirigami.results.step import Event, Step
from kirigami.system.system import System

Recorder = Callable[[Step], None]

ON_INSTABILITY = ("follow", "switch", "stop")
MAX_ITERATIONS = 14
CUTS_AT_EVENTS = 8  # shorter increments tried where the path to a change of stability cannot be traced
MAX_RELAXATION = 120
DRIFT_LARGEST = 0.25  # an equilibrium that far off the prediction may lie on another branch: the increment is cut [rad]
PREDICTED_TURN = 0.5  # a prediction that turns a member by more is cut before it is tried [rad]


class PathAnalysis(Analysis):
    """Common part of the path methods; see :class:`LoadControl`, :class:`DisplacementControl`, :class:`ArcLength`."""

    max_steps = 100_000

    def __init__(
        self,
        model: Model,
        tol: float,
        start: Step | Event | None,
        on_instability: str,
        branch: int | None,
        corrector: str = "newton",
    ) -> None:
        super().__init__(model)
        owner = type(self).__name__
        if on_instability not in ON_INSTABILITY:
            raise ModelError(f"{owner}: on_instability must be one of {ON_INSTABILITY}, got {on_instability!r}")
        self.on_instability = on_instability
        if corrector not in CORRECTORS:
            raise ModelError(f"{owner}: corrector must be one of {tuple(CORRECTORS)}, got {corrector!r}")
        self.corrector = corrector
        self.tol = require_positive(tol, "tol", owner)
        self.branch = branch
        self.mode: Array | None = None
        if branch is not None and (branch not in (1, -1) or getattr(start, "kind", "") != "bifurcation"):
            raise ModelError(f"{owner}: branch=+1 or -1 goes with start=event, a located bifurcation of results.events")
        if isinstance(start, Event):
            if start.located is None:
                raise ModelError(f"{owner}: this event was not located, so nothing can start from it: {start}")
            self.mode = start.mode
            start = start.located
        if start is not None and not isinstance(start, Step):
            raise ModelError(f"{owner}: start must be a Step, such as results[-1], or an Event, got {start!r}")
        self.start = start

    # What the three methods differ in.

    def _make_control(self, system: System) -> Control:
        raise NotImplementedError

    def _plan(self, control: Control, state: State, tangent: Tangent) -> Increments:
        """Increments for the walk, once the starting state and its tangent are known."""
        raise NotImplementedError

    def _stops(self, step: Step) -> bool:
        return False

    def _steer(self, increments: Increments, point: Point) -> None:
        """Adjust the increments once a point is accepted."""

    # ---- the walk

    def run(
        self,
        progress: bool = False,
        recorders: Iterable[Recorder] = (),
        on_failure: str = "raise",
        checkpoint: str | os.PathLike[str] | None = None,
        resume: bool = True,
    ) -> Results:
        """Follow the path.

        Parameters
        ----------
        progress : bool
            Show a progress bar.
        recorders : iterable of callables
            Each is called with every stored :class:`Step`.
        on_failure : {"raise", "return"}
            What to do where no equilibrium is found: raise a ConvergenceError, or return the results so far with a
            warning and an event.
        checkpoint : path, optional
            A file that is kept up to date with every accepted step (or so often that writing takes a twentieth of the
            time), so that nothing is lost when the process is killed. :func:`kirigami.load` reads it as results.
        resume : bool
            Whether to go on from the checkpoint where there is one: the same call finishes what was begun, with the
            same curve as without the interruption. False starts anew and replaces it.

        Returns
        -------
        Results
            Every accepted step. After Ctrl-C: those found until then, with an event that says so.

        Raises
        ------
        ModelError, MechanismError
            The model cannot be analysed as it is.
        ConvergenceError
            No equilibrium at the smallest increment; it carries the results so far.
        AnalysisError
            The checkpoint belongs to another model or analysis, or is damaged; it is left as it is.
        """
        if on_failure not in ("raise", "return"):
            raise ModelError(f"on_failure must be 'raise' or 'return', got {on_failure!r}")
        system, results = self._begin()
        self.system, self.found, self._recorders = system, results, tuple(recorders)
        self.control = self._make_control(system)
        system.check_supports()
        self._checkpoint = None
        stored = None
        if checkpoint is not None:
            self._checkpoint = Checkpoint(checkpoint, fingerprint(system, settings_of(self)))
            stored = self._checkpoint.read() if resume else None
        with one_thread(), progress_bar(progress, type(self).__name__) as self._bar:
            try:
                self._walk(stored)
            except KeyboardInterrupt:
                self._write_checkpoint()
                lam = results.steps[-1].lam if results.steps else 0.0
                message = f"interrupted after {len(results)} steps at load factor {lam:.6g}"
                results.events.append(Event("interrupted", lam, len(results) - 1, message))
                warnings.warn(message, KirigamiWarning, stacklevel=2)
            except ConvergenceError as error:
                self._write_checkpoint()
                self._finish(system, results)
                if on_failure == "raise":
                    raise
                lam = results.steps[-1].lam if results.steps else 0.0
                results.events.append(Event("failed", lam, len(results) - 1, str(error)))
                warnings.warn(str(error), KirigamiWarning, stacklevel=2)
        self._write_checkpoint()
        return self._finish(system, results)

    def _walk(self, stored: tuple[Results, dict[str, Any]] | None) -> None:
        system, control, results = self.system, self.control, self.found
        start = self._starting_state()
        if stored is not None:
            point, increments = resume_walk(self, start, *stored)
        else:
            point = self._first_equilibrium(start) if self.branch is None else self._begin_branch(start)
            increments = self._plan(control, point.state, point.tangent)
        if self._downhill:
            strategy = CORRECTORS[self.corrector]
            increments.least_growth, increments.growth_after_snap = strategy.least_growth, strategy.growth_after_snap
        self._bar.start(increments.progress(control.value(point.state.q, point.state.lam)))
        while len(results) <= self.max_steps:
            if self._stops(results[-1]) or (self.on_instability == "stop" and len(results) > 1 and point.negative):
                return
            increment = increments.next_increment(control.value(point.state.q, point.state.lam))
            if increment is None:
                return
            before = point
            cuts, most = 0, CORRECTORS[self.corrector].cuts
            while True:
                attempt, tangent = self._step(before, increment, cuts >= most or increments.is_short(increment))
                known = len(results.events)
                if tangent is not None:
                    system.commit(attempt.state.u)
                    point = Point(attempt.state, tangent, system.history)
                    try:
                        report_events(self, before, point, increment, attempt.left, strict=cuts < CUTS_AT_EVENTS)
                        break
                    except JumpError:
                        del results.events[known:]
                        attempt.reason = "the equilibrium found lies on another path"
                results.stats["cutbacks"] += 1
                cuts += 1
                system.history = before.history
                shorter = increments.cut(increment)
                if shorter is None:
                    self._fail(attempt, increment)
                increment = shorter
            if self.on_instability == "switch" and not isinstance(control, LoadFactorControl):
                before, point, attempt = switch(self, results.events[known:], before, point, attempt)
            control.accept(before.state, point.state)
            self._store(point, attempt)
            self._steer(increments, point)
            increments.adapt(increment, attempt)
            self._note(increments)
            self._bar.move(increments.progress(control.value(point.state.q, point.state.lam)))
        message = f"ended after {self.max_steps} steps, the most allowed, at load factor {results[-1].lam:.6g}"
        results.events.append(Event("step limit", results[-1].lam, len(results) - 1, message))

    # ---- checkpoints

    def _note(self, increments: Increments) -> None:
        """Tell the checkpoint, if there is one, where the walk stands."""
        if self._checkpoint is not None:
            self._count_seconds(self.system, self.found)
            self._checkpoint.note(self.found, {"increments": copy.deepcopy(vars(increments)), **self.control.memory})

    def _write_checkpoint(self) -> None:
        if self._checkpoint is not None:
            self._checkpoint.finish()

    # ---- one step

    @property
    def _downhill(self) -> bool:
        """Whether unstable equilibria are left for stable ones at the same load factor."""
        return self.on_instability == "switch" and isinstance(self.control, LoadFactorControl)

    def _step(self, before: Point, increment: float, hard: bool) -> tuple[Attempt, Tangent | None]:
        """One increment: downhill where unstable equilibria are to be left, else by Newton's method alone."""
        if self._downhill and not CORRECTORS[self.corrector].newton_first:
            attempt = self._relax(before, increment, hold=hard)
            return attempt, self.tangent_at(attempt)
        attempt = self.try_increment(before, increment)
        tangent = self.tangent_at(attempt)
        if tangent is not None:
            attempt.reason = self.control.doubt(before, attempt, tangent)
            if attempt.reason:
                return attempt, None
        relax = hard if tangent is None else tangent.factor.negative > 0
        if self._downhill and relax:
            relaxed = self._relax(before, increment, hold=True)
            relaxed.relaxed = True
            relaxed_tangent = self.tangent_at(relaxed)
            if relaxed_tangent is not None:
                relaxed.left = None if tangent is None else Point(attempt.state, tangent, before.history)
                return relaxed, relaxed_tangent
        return attempt, tangent

    def _begin_branch(self, origin: State) -> Point:
        """The first step on a branch of the bifurcation that the analysis starts from, which is stored as step 0."""
        assert self.start is not None and self.mode is not None and self.branch is not None
        self._record(self.start)
        found = leave_along_mode(self, self.start, self.mode, self.branch)
        if found is None:
            raise ConvergenceError(
                f"no branch was found along the mode of the bifurcation at load factor {self.start.lam:.6g}",
                results=self.found,
                hint="start from the event of a run with a smaller step or tol, or perturb the model with event.mode",
            )
        self.control.accept(origin, found[0].state)
        self._store(*found)
        return found[0]

    def _starting_state(self) -> State:
        """Where the walk starts: at rest, or at a given step."""
        system, start = self.system, self.start
        lam, u = 0.0, np.zeros_like(system.rest)
        if start is not None:
            if start.u.shape[0] != len(system.rest):
                raise ModelError(f"start has {start.u.shape[0]} nodes, the model has {len(system.rest)}")
            if start.stage == system.model.stage:
                lam = start.lam
            else:
                system.start_stage(start.u)
            error = system.constraint_error(start.u, lam)
            if error > 1e-6 * system.size:
                raise ModelError(
                    f"start does not satisfy the constraints at load factor {lam:.6g} (off by {error:.3g}): "
                    "after changing supports call model.hold(step), which keeps what the earlier stage drove"
                )
            u = start.u[:, : system.dim]
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
        tangent_there = self._first_factor(system, self.found, state.u, state.lam)
        attempt = self.correct(stay, state)
        if attempt.iterations == 0:
            attempt.stiffness = tangent_there
        if not attempt.converged:
            strategy = CORRECTORS[self.corrector]
            attempt = descend(system, self._new_factor, state, self.tol, MAX_RELAXATION, strategy, self._count)
        tangent = self.tangent_at(attempt)
        if tangent is None:
            self._fail(attempt, 0.0)
        system.commit(attempt.state.u)
        point = Point(attempt.state, tangent, system.history)
        self._store(point, attempt)
        return point

    def _predict(self, before: Point, increment: float) -> tuple[State, Array] | None:
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
        predicted = self._predict(before, increment)
        if predicted is None:
            return Attempt(before.state, False, float("inf"), 0, [], "the control does not act on the structure")
        state, change = predicted
        if system.largest_rotation(change) > PREDICTED_TURN:
            return Attempt(before.state, False, float("inf"), 0, [], "the increment turns members too far")
        system.linearize(before.state.u, change)
        attempt = self.correct(self.control, state)
        attempt.iterations += 1
        attempt.drift = system.largest_rotation(attempt.state.u - state.u)
        if attempt.converged and attempt.drift > DRIFT_LARGEST:
            attempt.converged = False
            attempt.reason = f"equilibrium found {attempt.drift:.2f} rad off the prediction, maybe on another branch"
        return attempt

    def _relax(self, before: Point, increment: float, hold: bool) -> Attempt:
        """Run downhill from the prediction to a stable equilibrium.

        Near a limit point the tangent shoots off: then fail, or with `hold` move only what is driven, and let the rest
        follow.
        """
        system, strategy = self.system, CORRECTORS[self.corrector]
        predicted = self._predict(before, increment)
        assert predicted is not None  # the load factor itself is the parameter
        state, change = predicted
        if system.largest_rotation(change) > strategy.turn:
            if not hold:
                return Attempt(before.state, False, float("inf"), 0, [], "the increment turns members too far")
            q = before.state.q
            state = State(q, state.lam, system.displacement(q, state.lam))
            change = state.u - before.state.u
        system.linearize(before.state.u, change)
        attempt = descend(system, self._new_factor, state, self.tol, MAX_RELAXATION, strategy, self._count)
        attempt.iterations += 1
        attempt.drift = system.largest_rotation(attempt.state.u - state.u)
        attempt.relaxed = attempt.drift > DRIFT_LARGEST
        if attempt.left_at is not None:
            left, blocks, factor = attempt.left_at
            attempt.relaxed = True
            if system.largest_rotation(left.u - state.u) <= DRIFT_LARGEST:  # else the descent came from elsewhere
                rate = -factor.solve(system.load_rate(left.u, left.lam, blocks))
                attempt.left = Point(left, Tangent(blocks, factor, rate), before.history)
        self.found.stats["relaxations"] += int(attempt.relaxed or strategy.newton_first)
        return attempt

    def correct(self, control: Control, state: State) -> Attempt:
        """Correct a state by Newton's method under any control."""
        return correct(self.system, self._new_factor, control, state, self.tol, MAX_ITERATIONS, self._count)

    def tangent_at(self, attempt: Attempt) -> Tangent | None:
        """The exact tangent at a converged state; None where the attempt failed or the tangent is singular."""
        if not attempt.converged:
            return None
        system, state = self.system, attempt.state
        try:
            if attempt.stiffness is not None:
                blocks, factor = attempt.stiffness
            else:
                blocks = system.stiffness_blocks(state.u, state.lam)
                factor = self._new_factor(blocks)
            with system.clock("solve"):
                rate = -factor.solve(system.load_rate(state.u, state.lam, blocks))
        except SingularMatrixError as error:
            attempt.reason = str(error)
            return None
        return Tangent(blocks, factor, rate)

    def _new_factor(self, blocks: Array) -> Factor:
        return self._factorize(self.system, self.found, self.system.matrix(blocks))

    def _count(self) -> None:
        self.found.stats["iterations"] += 1

    def _store(self, point: Point, attempt: Attempt) -> None:
        state = point.state
        self._record(make_step(self.system, state.u, state.lam, point.negative, attempt.residual, attempt.iterations))

    def _record(self, step: Step) -> None:
        self.found.append(step)
        for recorder in self._recorders:
            recorder(step)

    # ---- failure

    def _fail(self, attempt: Attempt, increment: float) -> NoReturn:
        system, results = self.system, self.found
        total, _ = system.forces(attempt.state.u, attempt.state.lam)
        unbalanced = np.zeros(system.rest.size)
        moving = system.unknown >= 0
        unbalanced[moving] = total.ravel()[moving]
        size = np.linalg.norm(unbalanced.reshape(total.shape), axis=1)
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
        negative = self.found.steps[-1].negative if self.found.steps else 0
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
