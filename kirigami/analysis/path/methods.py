"""The path methods: load control, displacement control and arc length.

They differ in their control, in how the increments are planned and in when they stop; the walk itself is common.
"""

from __future__ import annotations

import copy
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from kirigami.analysis.base import require_drive
from kirigami.analysis.path.controls import ArcLengthControl, Control, LoadFactorControl, SingleDisplacementControl
from kirigami.analysis.path.descent import CORRECTORS
from kirigami.analysis.path.follow import PathAnalysis
from kirigami.analysis.path.increments import Increments, checked_targets
from kirigami.analysis.path.points import Point
from kirigami.analysis.path.settings import PathSettings
from kirigami.analysis.path.stable import FIRST
from kirigami.errors import ModelError
from kirigami.model.model import Model
from kirigami.primitives.checks import (
    require_between,
    require_callable,
    require_choice,
    require_finite,
    require_whole,
    shown,
)
from kirigami.primitives.node import AXES, Node
from kirigami.results.results import Results
from kirigami.results.step import Event, Step
from kirigami.system.system import System

SETTLES = ("overdamped", "dynamics")
CAREFUL = ("path", "slow")  # correctors that go on from short increments, at the start and where the way turns
SMALLEST = 1e-7  # smallest increment, as a share of the whole range
GROWTH = 0.1  # share of the distance from the start that an arc may have


class _RangeAnalysis(PathAnalysis):
    """A walk of one parameter from where it is to `to`."""

    def __init__(
        self,
        model: Model,
        to: float,
        targets: ArrayLike | None,
        step: float | None,
        tol: float,
        start: Step | Event | None,
        on_instability: str,
        branch: int | None,
        corrector: str,
        settle: str,
        damping: float,
    ) -> None:
        super().__init__(model, tol, start, on_instability, branch, corrector)
        owner = type(self).__name__
        self.settle = require_choice(settle, SETTLES, "settle", owner)
        self.damping = require_between(damping, 0.0, 1.0, "damping", owner)
        if self.settle == "dynamics" and (self.corrector != "path" or self.on_instability != "switch"):
            raise ModelError(
                f"{owner}: settle='dynamics' chooses where a snap lands, so it goes with corrector='path' and "
                "on_instability='switch'"
            )
        self.to = require_finite(to, "to", owner)
        self.targets = checked_targets(targets, owner)
        self.step = None if step is None else abs(require_finite(step, "step", owner))
        if self.step == 0:
            raise ModelError(f"{owner}: step must not be zero")

    def plan(self, control: Control, point: Point) -> Increments:
        begin = control.value(point.state.q, point.state.lam)
        targets = [*self.targets, self.to] if self.targets[-1:] != [self.to] else list(self.targets)
        span = max(begin, *targets) - min(begin, *targets)
        downhill = self.goes_downhill(control)
        near = downhill and self.corrector in CAREFUL
        first = self.step if self.step is not None else (FIRST if near else 0.05) * span
        largest, smallest = max(span / (5 if near else 10), first), SMALLEST * max(span, first)
        increments = Increments(first, largest, smallest, targets, begin)
        if near:
            increments.first = increments.at_turns = min(first, FIRST * span)
        if downhill:
            strategy = CORRECTORS[self.corrector]
            increments.least_growth, increments.growth_after_snap = strategy.least_growth, strategy.growth_after_snap
        return increments


class LoadControl(_RangeAnalysis):
    """Walk the load factor to a value; where loads have a maximum, sheets snap and other structures end.

    Parameters
    ----------
    model : Model
        Loads and prescribed displacements scale with the load factor.
    to : float
        Load factor at the end.
    targets : array_like, optional
        Load factors that are hit exactly and stored on the way, in the order given, and then `to`: ``targets=[1.0],
        to=0.0`` pulls and lets go.
    step : float, optional
        First increment; None takes a twentieth of the range, or with corrector "path" and "slow" where they act a
        ten-thousandth. Increments adapt; they stay below a tenth of the range, or with these two below a fifth, and
        below a quarter of the distance from where the way began or last turned.
    tol : float
        Relative residual that every stored step meets.
    start : Step or Event, optional
        Stored step, or located limit point or bifurcation, to go on from.
    on_instability : {"follow", "switch", "stop"}, optional
        At an unstable equilibrium: follow the path, which fails at limit points; leave it downhill for a stable one at
        the same load factor, as a real structure does in a snap; or stop there. Events tell what was met. None
        switches for sheets in space whose forces have a potential, and follows otherwise.
    branch : {1, -1}, optional
        With a bifurcation as `start`: leave it along its mode, or against it.
    corrector : {"path", "slow", "newton", "descent", "viscous"}
        How the stable equilibria of a structure that snaps are found (on_instability "switch"). "path": along the
        stable path in increments as long as it is smooth, and where it is lost downhill from close by; lands where a
        slow pull does (benchmarks/landing.py). "slow": that slow pull itself, with a little damping, as the reference;
        two to twenty times dearer. The others take long increments from the start, so that they may pass over a buckle
        and land on another stable shape: "newton" by Newton's method at shorter and shorter increments, and downhill
        where it fails; "descent" downhill at once, with compression faded out of the tangent where it is indefinite;
        "viscous" the same by an implicit viscous motion.
    settle : {"overdamped", "dynamics"}
        What chooses where a snap lands, with corrector "path": the limit of a motion without inertia, or motion with
        the masses of the model and little damping, which may fly over shapes that the former stops at
        (benchmarks/inertia.py).
    damping : float
        With settle "dynamics": share of the critical damping of the slowest motion about the landing.

    Raises
    ------
    ModelError
        A value out of range; in a run a model that nothing drives, or a `start` of another model.
    MechanismError
        In a run: the structure can move without resistance.
    ConvergenceError
        In a run: no equilibrium at the smallest increment; the error carries the steps so far and says what to try.

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
        start: Step | Event | None = None,
        on_instability: str | None = None,
        branch: int | None = None,
        corrector: str = "path",
        settle: str = "overdamped",
        damping: float = 0.05,
    ) -> None:
        self.by_structure = on_instability is None  # see chosen_for
        at_once = "switch" if on_instability is None else on_instability
        super().__init__(model, to, targets, step, tol, start, at_once, branch, corrector, settle, damping)

    def chosen_for(self, system: System) -> PathSettings:
        found = copy.copy(self)
        if self.by_structure and not (system.model.mesh is not None and system.dim == 3 and system.conservative):
            found.on_instability = "follow"
        return found

    def make_control(self, system: System) -> Control:
        require_drive(system, type(self).__name__, constant_counts=True)
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
        Values of what is walked that are hit exactly and stored on the way, in the order given, and then `to`:
        ``targets=[1.0], to=0.0`` pulls and lets go.
    step : float, optional
        First increment; None takes a twentieth of the range, or with corrector "path" and "slow" where they act a
        ten-thousandth. Increments adapt; they stay below a tenth of the range, or with these two below a fifth, and
        below a quarter of the distance from where the way began or last turned.
    tol : float
        Relative residual that every stored step meets.
    start : Step or Event, optional
        Stored step, or located limit point or bifurcation, to go on from.
    on_instability : {"switch", "follow", "stop"}, optional
        As for :class:`LoadControl`; the default is "switch" for prescribed displacements, because a pulled sheet
        snaps from one stable shape to the next, and "follow" with `control`. With `control` the load factor is free,
        so "switch" goes over to the other path at bifurcations and follows limit points.
    branch : {1, -1}, optional
        With a bifurcation as `start`: leave it along its mode, or against it.
    corrector : {"path", "slow", "newton", "descent", "viscous"}
        How the stable equilibria of a structure that snaps are found (on_instability "switch"). "path": along the
        stable path in increments as long as it is smooth, and where it is lost downhill from close by; lands where a
        slow pull does (benchmarks/landing.py). "slow": that slow pull itself, with a little damping, as the reference;
        two to twenty times dearer. The others take long increments from the start, so that they may pass over a buckle
        and land on another stable shape: "newton" by Newton's method at shorter and shorter increments, and downhill
        where it fails; "descent" downhill at once, with compression faded out of the tangent where it is indefinite;
        "viscous" the same by an implicit viscous motion.
    settle : {"overdamped", "dynamics"}
        What chooses where a snap lands, with corrector "path": the limit of a motion without inertia, or motion with
        the masses of the model and little damping, which may fly over shapes that the former stops at
        (benchmarks/inertia.py).
    damping : float
        With settle "dynamics": share of the critical damping of the slowest motion about the landing.

    Raises
    ------
    ModelError
        A value out of range, a `control` that is no node and axis; in a run a model that nothing drives, or a `start`
        of another model.
    MechanismError
        In a run: the structure can move without resistance.
    ConvergenceError
        In a run: no equilibrium at the smallest increment; the error carries the steps so far and says what to try.

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
        start: Step | Event | None = None,
        on_instability: str | None = None,
        branch: int | None = None,
        corrector: str = "path",
        settle: str = "overdamped",
        damping: float = 0.05,
    ) -> None:
        if on_instability is None:
            on_instability = "switch" if control is None else "follow"
        super().__init__(model, to, targets, step, tol, start, on_instability, branch, corrector, settle, damping)
        if control is not None:
            node, axis = control if isinstance(control, (tuple, list)) and len(control) == 2 else (None, None)
            if not isinstance(node, Node) or not isinstance(axis, str) or axis not in tuple(AXES[: model.dim]):
                raise ModelError(f"control must be a node and an axis, such as (node, 'y'), got {shown(control)}")
        self.single = control

    def make_control(self, system: System) -> Control:
        if self.single is None:
            # A new stage brings its constraints to their place from wherever the last one ended, also back to zero.
            in_place = self.start is None or self.start.stage == system.model.stage
            if in_place and not system.drive.any():
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
        its first value or a tenth of the distance from the start. A negative step starts backwards; on a branch only
        the size of its first step counts.
    stop : callable, optional
        ``stop(step) -> bool``; the path ends after the first stored step for which it is true.
    max_steps : int
        Most steps to take.
    tol : float
        Relative residual that every stored step meets.
    start : Step or Event, optional
        Stored step, or located limit point or bifurcation, to go on from.
    arc : {"cylindrical", "spherical"}
        Whether the arc is measured in displacements alone, or with the load factor as one more displacement, scaled
        to count as much as the others in the first step.
    on_instability : {"follow", "switch", "stop"}
        At an unstable equilibrium: follow the path through limit points and bifurcations; go over to the other path
        at each bifurcation at which stability is lost; or stop there.
    branch : {1, -1}, optional
        With a bifurcation as `start`: leave it along its mode, or against it.

    Raises
    ------
    ModelError
        A value out of range, a step of zero; in a run a model that nothing drives or a :class:`Turn`, or a `start` of
        another model.
    MechanismError
        In a run: the structure can move without resistance.
    ConvergenceError
        In a run: no equilibrium at the smallest increment; the error carries the steps so far and says what to try.

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
        start: Step | Event | None = None,
        arc: str = "cylindrical",
        on_instability: str = "follow",
        branch: int | None = None,
    ) -> None:
        super().__init__(model, tol, start, on_instability, branch)
        self.arc = require_choice(arc, ("cylindrical", "spherical"), "arc", "ArcLength")
        self.step = require_finite(step, "step", "ArcLength")
        if self.step == 0:
            raise ModelError("ArcLength: step must not be zero")
        self.max_steps = require_whole(max_steps, "max_steps", "ArcLength", least=1)
        self.stop = None if stop is None else require_callable(stop, "stop", "ArcLength")

    def make_control(self, system: System) -> Control:
        require_drive(system, type(self).__name__)
        if system.arcs:
            raise ModelError("ArcLength: nodes that a Turn drives leave the straight line: use DisplacementControl")
        return ArcLengthControl(system)

    def plan(self, control: Control, point: Point) -> Increments:
        assert isinstance(control, ArcLengthControl)
        control.sense = float(np.sign(self.step))
        along = control.along(point.tangent.rate, point.state)
        if self.arc == "spherical":
            control.weight = float(np.linalg.norm(along))
        length = abs(self.step) * control.distance(along, 1.0)
        if control.direction is not None:  # a branch: its first step is made, and near its root the tangent is steep
            length = control.distance(control.direction, control.load_direction)
        if not length > 0:
            raise ModelError("ArcLength: the loads do not move the structure, so there is no path to follow")
        return Increments(length, 4 * length, 1e-6 * length)

    def steer(self, increments: Increments, results: Results, point: Point) -> None:
        moved = point.state.u[: len(results.rest)] - results[0].u[:, : self.model.dim]
        away = float(np.linalg.norm(moved))  # of the nodes: rows behind them are no distances
        increments.largest = max(increments.largest, GROWTH * away)

    def stops(self, results: Results) -> bool:
        return self.stop is not None and len(results) > 1 and bool(self.stop(results[-1]))
