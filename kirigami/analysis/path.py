"""Path following: load control, displacement control and arc length on one corrector.

A control supplies one equation g(q, lam) = 0 beside equilibrium. The path is walked in increments of the control's
own parameter: predicted along the exact tangent of the last equilibrium, corrected, accepted or cut back. A stored
step is always a converged equilibrium; how many eigenvalues are negative there is stored with it.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.analysis.base import Analysis, checked_number, make_step
from kirigami.analysis.newton import Attempt, State, Tangent, correct
from kirigami.constraints import AXES
from kirigami.errors import ConvergenceError, KirigamiWarning, ModelError
from kirigami.kernel import Array
from kirigami.linalg import Factor, SingularMatrixError
from kirigami.model import Model, Node
from kirigami.results import Event, Results, Step
from kirigami.system import System

Recorder = Callable[[Step], None]

WANTED_ITERATIONS = 6  # increments grow or shrink towards this many corrections
MAX_ITERATIONS = 14
MAX_RELAXATION = 120
CUTS_FIRST = 3  # shorter increments tried by Newton's method before a relaxation ...
SHORT = 0.02  # ... which comes at once where the increment is below this share of the largest
DRIFT_WANTED = 0.05  # turn of a member by which corrections leave the prediction: steers the increments [rad]
DRIFT_LARGEST = 0.25  # ... above which the equilibrium found may lie on another branch, and the increment is cut [rad]
SMALLEST = 1e-7  # smallest increment, as a share of the whole range
LIMIT_TOLERANCE = 1e-7  # relative error in load to which limit points are located
PREDICTED_TURN = 0.5  # a prediction that turns a member by more is cut before it is tried [rad]


ON_INSTABILITY = ("follow", "switch", "stop")


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


class PathAnalysis(Analysis):
    """Common part of the path methods; see :class:`LoadControl`, :class:`DisplacementControl`, :class:`ArcLength`."""

    max_steps = 100_000

    def __init__(self, model: Model, tol: float, start: Step | None, on_instability: str = "follow") -> None:
        super().__init__(model)
        owner = type(self).__name__
        if on_instability not in ON_INSTABILITY:
            raise ModelError(f"{owner}: on_instability must be one of {ON_INSTABILITY}, got {on_instability!r}")
        self.on_instability = on_instability
        self.tol = checked_number(tol, "tol", owner, positive=True)
        if start is not None and not isinstance(start, Step):
            raise ModelError(f"{owner}: start must be a Step, such as results[-1], got {start!r}")
        self.start = start

    # What the three methods differ in.

    def _make_control(self, system: System) -> Control:
        raise NotImplementedError

    def _plan(self, control: Control, state: State, tangent: Tangent) -> _Walk:
        """Increments for the walk, once the starting state and its tangent are known."""
        raise NotImplementedError

    def _stops(self, step: Step) -> bool:
        return False

    # ---- the walk

    def run(
        self, progress: bool = False, recorders: Iterable[Recorder] = (), on_failure: str = "raise"
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
        """
        if on_failure not in ("raise", "return"):
            raise ModelError(f"on_failure must be 'raise' or 'return', got {on_failure!r}")
        system, results = self._begin()
        self._system, self._results, self._recorders = system, results, tuple(recorders)
        self.control = self._make_control(system)
        system.check_supports()
        from kirigami.recorders import progress_bar

        with progress_bar(progress, type(self).__name__) as self._bar:
            try:
                self._walk()
            except KeyboardInterrupt:
                lam = results.steps[-1].lam if results.steps else 0.0
                message = f"interrupted after {len(results)} steps at load factor {lam:.6g}"
                results.events.append(Event("interrupted", lam, len(results) - 1, message))
                warnings.warn(message, KirigamiWarning, stacklevel=2)
            except ConvergenceError as error:
                self._finish(system, results)
                if on_failure == "raise":
                    raise
                lam = results.steps[-1].lam if results.steps else 0.0
                results.events.append(Event("failed", lam, len(results) - 1, str(error)))
                warnings.warn(str(error), KirigamiWarning, stacklevel=2)
        return self._finish(system, results)

    def _walk(self) -> None:
        system, control = self._system, self.control
        state = self._first_equilibrium()
        walk = self._plan(control, state, self._tangent)
        self._bar.start(walk.progress(control.value(state.q, state.lam)))
        for _ in range(self.max_steps):
            if self._stops(self._results[-1]):
                return
            increment = walk.next_increment(control.value(state.q, state.lam))
            if increment is None:
                return
            before, before_tangent, before_history = state, self._tangent, system.history
            cuts = 0
            while True:
                attempt = self._try(before, before_tangent, increment)
                found = attempt.converged and self._accept_tangent(attempt)
                hard = cuts >= CUTS_FIRST or abs(increment) < SHORT * walk.largest
                if self.on_instability == "switch" and (hard if not found else self._tangent.factor.negative):
                    relaxed = self._relax(before, before_tangent, increment)
                    if relaxed.converged and self._accept_tangent(relaxed):
                        attempt, found = relaxed, True
                if found:
                    break
                self._results.stats["cutbacks"] += 1
                cuts += 1
                system.history = before_history
                shorter = walk.cut(increment)
                if shorter is None:
                    self._fail(attempt, increment)
                increment = shorter
            state = attempt.state
            system.commit(state.u)
            if isinstance(control, ArcLengthControl):
                control.direction = state.u - before.u
            self._store(state, attempt)
            self._report_events(before, before_tangent, before_history, increment, state)
            if self.on_instability == "stop" and self._tangent.factor.negative:
                return
            walk.adapt(increment, attempt)
            self._bar.move(walk.progress(control.value(state.q, state.lam)))

    def _first_equilibrium(self) -> State:
        """Equilibrium at the starting load factor, its tangent, and step 0."""
        system, start = self._system, self.start
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
        control = LoadFactorControl()
        control.begin(state, 0.0)
        blocks, factor = self._first_factor(system, self._results, state.u, lam)
        attempt = correct(system, self._new_factor, control, state, self.tol, MAX_ITERATIONS, self._count)
        if not attempt.converged:
            attempt = correct(system, self._new_factor, control, state, self.tol, MAX_RELAXATION, self._count, True)
        if not attempt.converged:
            self._fail(attempt, 0.0)
        system.commit(attempt.state.u)
        if attempt.iterations == 0:
            self._tangent = Tangent(blocks, factor, -factor.solve(system.load_rate(state.u, lam, blocks)))
        elif not self._accept_tangent(attempt):
            self._fail(attempt, 0.0)
        self._store(attempt.state, attempt)
        return attempt.state

    def _predict(self, before: State, tangent: Tangent, increment: float) -> tuple[State, Array] | None:
        """The state on the tangent, one increment on, and the change to it; None where the tangent leads nowhere."""
        control = self.control
        control.begin(before, increment)
        step_lam = control.predict(increment, tangent.rate)
        if not np.isfinite(step_lam):
            return None
        q, lam = before.q + step_lam * tangent.rate, before.lam + step_lam
        u = self._system.displacement(q, lam)
        return State(q, lam, u), u - before.u

    def _try(self, before: State, tangent: Tangent, increment: float) -> Attempt:
        """Predict along the tangent and correct."""
        system = self._system
        predicted = self._predict(before, tangent, increment)
        if predicted is None:
            return Attempt(before, False, float("inf"), 0, [], "the control does not act on the structure")
        state, change = predicted
        if system.largest_rotation(change) > PREDICTED_TURN:
            return Attempt(before, False, float("inf"), 0, [], "the increment turns members too far")
        system.linearize(before.u, change)
        attempt = correct(system, self._new_factor, self.control, state, self.tol, MAX_ITERATIONS, self._count)
        attempt.iterations += 1
        attempt.drift = system.largest_rotation(attempt.state.u - state.u)
        if attempt.converged and attempt.drift > DRIFT_LARGEST:
            attempt.converged = False
            attempt.reason = f"equilibrium found {attempt.drift:.2f} rad off the prediction, maybe on another branch"
        return attempt

    def _relax(self, before: State, tangent: Tangent, increment: float) -> Attempt:
        """Run downhill from the last equilibrium, carried along with the drive, to a stable equilibrium."""
        system = self._system
        predicted = self._predict(before, tangent, increment)
        assert predicted is not None
        state, change = predicted
        if system.largest_rotation(change) > PREDICTED_TURN:
            # The tangent shoots off near a limit point: move only what is driven, and let the rest follow.
            state = State(before.q, state.lam, system.displacement(before.q, state.lam))
            change = state.u - before.u
        system.linearize(before.u, change)
        attempt = correct(
            system, self._new_factor, self.control, state, self.tol, MAX_RELAXATION, self._count, convex=True
        )
        attempt.iterations += 1
        attempt.relaxed = True
        return attempt

    def _accept_tangent(self, attempt: Attempt) -> bool:
        """Factorise the exact tangent at a converged state; False where that cannot be done."""
        system, state = self._system, attempt.state
        blocks = system.stiffness_blocks(state.u, state.lam)
        try:
            factor = self._new_factor(blocks)
            with system.clock("solve"):
                rate = -factor.solve(system.load_rate(state.u, state.lam, blocks))
        except SingularMatrixError as error:
            attempt.reason = str(error)
            return False
        self._tangent = Tangent(blocks, factor, rate)
        return True

    def _new_factor(self, blocks: Array) -> Factor:
        return self._factorize(self._system, self._results, self._system.matrix(blocks))

    def _count(self) -> None:
        self._results.stats["iterations"] += 1

    def _store(self, state: State, attempt: Attempt) -> None:
        negative = self._tangent.factor.negative
        step = make_step(self._system, state.u, state.lam, negative, attempt.residual, attempt.iterations)
        self._results.append(step)
        for recorder in self._recorders:
            recorder(step)

    # ---- events

    def _lam_rate(self, tangent: Tangent) -> float:
        """Change of the load factor per unit of the control's parameter on the tangent."""
        return self.control.predict(1.0, tangent.rate)

    def _report_events(
        self, before: State, before_tangent: Tangent, before_history: Any, increment: float, after: State
    ) -> None:
        results, control = self._results, self.control
        index = len(results) - 2
        negative = before_tangent.factor.negative, self._tangent.factor.negative
        bracket = (before.lam, after.lam)
        if not isinstance(control, LoadFactorControl):
            sense = np.sign(increment)
            if isinstance(control, ArcLengthControl):
                rates = self._arc_rate(before, before_tangent, after), self._arc_rate(before, self._tangent, after)
            else:
                rates = self._lam_rate(before_tangent) * sense, self._lam_rate(self._tangent) * sense
            if np.isfinite(rates).all() and rates[0] * rates[1] < 0:
                found = self._locate_limit(before, before_tangent, before_history, increment, rates, after)
                kind = "maximum" if rates[0] > 0 else "minimum"
                message = f"limit point ({kind}) at load factor {found.lam:.8g}"
                results.events.append(Event("limit point", found.lam, index, message, bracket, self._full(found.u)))
                if abs(negative[1] - negative[0]) == 1:
                    return
        if isinstance(control, LoadFactorControl):
            self._report_snap(before, after, before_history, bracket, index)
        if negative[0] != negative[1]:
            message = (
                f"{negative[0]} to {negative[1]} negative eigenvalues between load factors "
                f"{bracket[0]:.6g} and {bracket[1]:.6g}"
            )
            middle = 0.5 * (bracket[0] + bracket[1])
            results.events.append(Event("stability change", middle, index, message, bracket))

    def _report_snap(
        self, before: State, after: State, before_history: Any, bracket: tuple[float, float], index: int
    ) -> None:
        """Tell of energy that was set free: on a smooth stable path the potential changes by the work of the drive."""
        system = self._system
        after_history = system.history
        system.history = before_history
        energy_before, rate_before = sum(system.energies(before.u, before.lam).values()), system.potential_rate(
            before.u, before.lam
        )
        system.history = after_history
        energy_after, rate_after = sum(system.energies(after.u, after.lam).values()), system.potential_rate(
            after.u, after.lam
        )
        distance = after.lam - before.lam
        released = energy_before + 0.5 * (rate_before + rate_after) * distance - energy_after
        expected = 0.5 * abs((rate_after - rate_before) * distance)
        if released > expected + 1e-3 * abs(energy_after):
            message = (
                f"snap between load factors {bracket[0]:.6g} and {bracket[1]:.6g}: "
                f"energy of {released:.3g} was set free ({100 * released / max(abs(energy_after), 1e-300):.2g} %)"
            )
            self._results.events.append(Event("snap", 0.5 * sum(bracket), index, message, bracket))

    def _full(self, u: Array) -> Array:
        full = np.zeros((len(u), 3))
        full[:, : self._system.dim] = u
        return full

    def _arc_rate(self, before: State, tangent: Tangent, after: State) -> float:
        """Change of the load factor per distance, with the sense in which the step was walked."""
        assert isinstance(self.control, ArcLengthControl)
        along = self.control.along(tangent.rate)
        return float(np.sign((along * (after.u - before.u)).sum()) / np.linalg.norm(along))

    def _locate_limit(
        self,
        before: State,
        before_tangent: Tangent,
        before_history: Any,
        increment: float,
        rates: tuple[float, float],
        after: State,
    ) -> State:
        """The state of extreme load factor between two steps: regula falsi (Illinois) on the rate of the load factor."""
        system, after_tangent = self._system, self._tangent
        after_history = system.history
        low, high = 0.0, increment
        f_low, f_high = rates
        best = after if abs(f_high) < abs(f_low) else before
        best_rate = min(abs(f_low), abs(f_high))
        side = 0
        try:
            for _ in range(40):
                # Where the rate vanishes linearly, the load factor is off by about half of rate times distance.
                scale = max(abs(best.lam), abs(before.lam), abs(after.lam), 1e-300)
                if best_rate * abs(high - low) < LIMIT_TOLERANCE * scale:
                    break
                trial = (low * f_high - high * f_low) / (f_high - f_low)
                system.history = before_history
                if isinstance(self.control, ArcLengthControl):
                    self.control.direction = after.u - before.u
                attempt = self._try(before, before_tangent, trial)
                if not (attempt.converged and self._accept_tangent(attempt)):
                    break
                if isinstance(self.control, ArcLengthControl):
                    rate = self._arc_rate(before, self._tangent, after)
                else:
                    rate = self._lam_rate(self._tangent) * np.sign(increment)
                if abs(rate) < best_rate:
                    best, best_rate = attempt.state, abs(rate)
                if rate * f_high < 0:
                    low, f_low, f_high = trial, rate, f_high / 2 if side == -1 else f_high
                    side = -1
                else:
                    high, f_high, f_low = trial, rate, f_low / 2 if side == 1 else f_low
                    side = 1
        finally:
            self._tangent = after_tangent
            system.history = after_history
        return best

    # ---- failure

    def _fail(self, attempt: Attempt, increment: float) -> None:
        system, results = self._system, self._results
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
        negative = self._results.steps[-1].negative if self._results.steps else 0
        if negative:
            return (
                "the last step is unstable: a slightly different imperfection (Model.perturb with a mode of Eigen) "
                "lets the path take the stable branch"
            )
        if isinstance(self.control, LoadFactorControl) and not self._system.drive.any():
            return "past a limit point no equilibrium exists at a higher load: use DisplacementControl or ArcLength"
        return (
            "a larger imperfection (Model.perturb), a smaller step, or ArcLength where the path turns back; "
            "the results so far are in error.results"
        )


class _Walk:
    """Increments of the parameter: first size, growth, cutbacks, and exact hits of targets."""

    def __init__(
        self, first: float, largest: float, smallest: float, targets: Sequence[float] = (), origin: float = 0.0
    ) -> None:
        self.size, self.largest, self.smallest = abs(first), abs(largest), abs(smallest)
        self.targets = list(targets)  # in the order they are met; the last one ends the walk
        self.origin = origin
        self.sense = 1.0

    def next_increment(self, value: float) -> float | None:
        """Signed increment from the parameter `value`, or None at the end."""
        if not self.targets:
            return self.size
        while self.targets and abs(self.targets[0] - value) <= 1e-12 * max(abs(self.targets[0]), abs(value)):
            if len(self.targets) == 1:
                return None
            self.targets.pop(0)
        remaining = self.targets[0] - value
        self.sense = float(np.sign(remaining))
        if abs(remaining) <= 1.0001 * self.size:
            return remaining
        if abs(remaining) < 2 * self.size:  # two even increments instead of a whole one and a splinter
            return 0.5 * remaining
        return self.sense * self.size

    def cut(self, increment: float) -> float | None:
        """A shorter increment after a failure, or None if it was the shortest."""
        if abs(increment) <= self.smallest:
            return None
        self.size = max(0.35 * abs(increment), self.smallest)
        return float(np.sign(increment)) * self.size

    def adapt(self, increment: float, attempt: Attempt) -> None:
        """Next size from how hard the last increment was, and how far the corrections led away from the prediction."""
        growth = (WANTED_ITERATIONS / max(attempt.iterations, 1)) ** 1.5
        if attempt.relaxed:
            growth = 1.0
        elif attempt.drift > 0:
            growth = min(growth, (DRIFT_WANTED / attempt.drift) ** 0.5)  # the drift grows with the square
        growth = float(np.clip(growth, 0.5, 2.5))
        # A short increment that only served to hit a target says nothing about the size to go on with.
        base = abs(increment) if growth < 1 or abs(increment) > 0.99 * self.size else self.size
        self.size = min(max(base * growth, self.smallest), self.largest)

    def progress(self, value: float) -> float | None:
        """Share of the walk done, where its end is known."""
        if not self.targets:
            return None
        span = self.targets[-1] - self.origin
        return (value - self.origin) / span if span else 1.0


def _ordered_targets(targets: ArrayLike | None, begin: float, to: float, owner: str) -> list[float]:
    """Targets between `begin` and `to`, in the order they are met, ending in `to`."""
    if targets is None:
        return [to]
    values = np.atleast_1d(np.asarray(targets, dtype=float))
    if values.ndim != 1 or not np.isfinite(values).all():
        raise ModelError(f"{owner}: targets must be a list of finite numbers")
    low, high = min(begin, to), max(begin, to)
    outside = values[(values < low) | (values > high)]
    if outside.size:
        raise ModelError(f"{owner}: target {outside[0]:g} lies outside the range {begin:g} to {to:g} of this run")
    ordered = sorted(set(values.tolist()) | {to}, reverse=to < begin)
    return ordered


def require_drive(system: System, owner: str, constant_counts: bool = False) -> None:
    """Raise a ModelError where nothing acts on the structure."""
    if system.drive.any() or any(kernel.scaled for kernel in system.kernels):
        return
    if constant_counts and (system.held.any() or any(kernel.pairs == () for kernel in system.kernels)):
        return
    raise ModelError(f"{owner}: nothing drives the model; add a NodalLoad, or a Prescribe with a value other than zero")


class _RangeAnalysis(PathAnalysis):
    """A walk of one parameter from where it is to `to`."""

    def __init__(
        self,
        model: Model,
        to: float,
        targets: ArrayLike | None,
        step: float | None,
        tol: float,
        start: Step | None,
        on_instability: str,
    ) -> None:
        super().__init__(model, tol, start, on_instability)
        owner = type(self).__name__
        self.to = checked_number(to, "to", owner)
        self.targets = targets
        self.step = None if step is None else abs(checked_number(step, "step", owner))
        if self.step == 0:
            raise ModelError(f"{owner}: step must not be zero")

    def _plan(self, control: Control, state: State, tangent: Tangent) -> _Walk:
        begin = control.value(state.q, state.lam)
        targets = _ordered_targets(self.targets, begin, self.to, type(self).__name__)
        span = abs(self.to - begin)
        first = self.step if self.step is not None else span / 20
        return _Walk(first, max(span / 10, first), SMALLEST * max(span, first), targets, begin)


class LoadControl(_RangeAnalysis):
    """Walk the load factor to a value; fails at limit points, where loads have a maximum.

    Parameters
    ----------
    model : Model
        Loads and prescribed displacements scale with the load factor.
    to : float
        Load factor at the end.
    targets : array_like, optional
        Load factors that are hit exactly and stored on the way.
    step : float, optional
        First increment; None takes a twentieth of the range. Increments adapt and stay below a tenth of it.
    tol : float
        Relative residual that every stored step meets.
    start : Step, optional
        Stored step to go on from.
    on_instability : {"follow", "switch", "stop"}
        At an unstable equilibrium: follow the path; leave it downhill for a stable one at the same load factor, as a
        real structure does in a snap; or stop there. Events tell what was met.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> res = kg.LoadControl(m, targets=[0.5]).run()
    >>> 0.5 in res.lam, bool(res.stable.all())
    (True, True)
    """

    def __init__(
        self,
        model: Model,
        to: float = 1.0,
        targets: ArrayLike | None = None,
        step: float | None = None,
        tol: float = 1e-8,
        start: Step | None = None,
        on_instability: str = "follow",
    ) -> None:
        super().__init__(model, to, targets, step, tol, start, on_instability)

    def _make_control(self, system: System) -> Control:
        require_drive(system, type(self).__name__)
        return LoadFactorControl()


class DisplacementControl(_RangeAnalysis):
    """Walk prescribed displacements, or one chosen displacement, to a value.

    Parameters
    ----------
    model : Model
        The model to analyse.
    to : float
        Without `control`: load factor at the end, which scales the Prescribe objects. With it: the displacement at
        the end [length].
    control : (Node, str), optional
        A node and an axis whose displacement is walked, while the load factor is an unknown.
    targets : array_like, optional
        Values of what is walked that are hit exactly and stored on the way.
    step : float, optional
        First increment; None takes a twentieth of the range. Increments adapt and stay below a tenth of it.
    tol : float
        Relative residual that every stored step meets.
    start : Step, optional
        Stored step to go on from.
    on_instability : {"switch", "follow", "stop"}, optional
        As for :class:`LoadControl`; the default is "switch" for prescribed displacements, because a pulled sheet
        snaps from one stable shape to the next, and "follow" with `control`.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0))
    >>> bars = m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
    >>> rest = m.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
    >>> res = kg.DisplacementControl(m, to=-2.0, control=(apex, "y")).run()
    >>> print(res.events[0])
    limit point (maximum) at load factor 0.13608276
    """

    def __init__(
        self,
        model: Model,
        to: float = 1.0,
        control: tuple[Node, str] | None = None,
        targets: ArrayLike | None = None,
        step: float | None = None,
        tol: float = 1e-8,
        start: Step | None = None,
        on_instability: str | None = None,
    ) -> None:
        if on_instability is None:
            on_instability = "switch" if control is None else "follow"
        if on_instability == "switch" and control is not None:
            raise ModelError("on_instability='switch' needs a prescribed load factor: leave out `control`")
        super().__init__(model, to, targets, step, tol, start, on_instability)
        if control is not None:
            node, axis = control if isinstance(control, (tuple, list)) and len(control) == 2 else (None, None)
            if not isinstance(node, Node) or axis not in tuple(AXES[: model.dim]):
                raise ModelError(f"control must be a node and an axis, such as (node, 'y'), got {control!r}")
        self.single = control

    def _make_control(self, system: System) -> Control:
        if self.single is None:
            if not system.drive.any():
                raise ModelError(
                    "DisplacementControl: no Prescribe drives the model; add one, or give control=(node, axis)"
                )
            return LoadFactorControl()
        require_drive(system, type(self).__name__)
        return SingleDisplacementControl(system, *self.single)


class ArcLength(PathAnalysis):
    """Follow the path wherever it goes, past limit points of load and of displacement.

    Parameters
    ----------
    model : Model
        Loads and prescribed displacements scale with the load factor.
    step : float
        First increment of the load factor; it fixes the arc length, which then adapts but never exceeds four times
        its first value. A negative step starts backwards.
    stop : callable, optional
        ``stop(step) -> bool``; the path ends after the first stored step for which it is true.
    max_steps : int
        Most steps to take.
    tol : float
        Relative residual that every stored step meets.
    start : Step, optional
        Stored step to go on from.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0))
    >>> bars = m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
    >>> rest = m.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
    >>> res = kg.ArcLength(m, step=0.02, stop=lambda s: s.u[1, 1] < -2).run()
    >>> [event.kind for event in res.events]
    ['limit point', 'limit point']
    """

    def __init__(
        self,
        model: Model,
        step: float,
        stop: Callable[[Step], bool] | None = None,
        max_steps: int = 500,
        tol: float = 1e-8,
        start: Step | None = None,
    ) -> None:
        super().__init__(model, tol, start)
        self.step = checked_number(step, "step", "ArcLength")
        if self.step == 0:
            raise ModelError("ArcLength: step must not be zero")
        if not isinstance(max_steps, (int, np.integer)) or max_steps < 1:
            raise ModelError(f"ArcLength: max_steps must be a positive integer, got {max_steps!r}")
        self.max_steps = int(max_steps)
        self.stop = stop

    def _make_control(self, system: System) -> Control:
        require_drive(system, type(self).__name__)
        return ArcLengthControl(system)

    def _plan(self, control: Control, state: State, tangent: Tangent) -> _Walk:
        assert isinstance(control, ArcLengthControl)
        control.sense = float(np.sign(self.step))
        length = abs(self.step) * float(np.linalg.norm(control.along(tangent.rate)))
        if not length > 0:
            raise ModelError("ArcLength: the loads do not move the structure, so there is no path to follow")
        return _Walk(length, 4 * length, 1e-6 * length)

    def _stops(self, step: Step) -> bool:
        return self.stop is not None and len(self._results) > 1 and bool(self.stop(step))
