"""One run of a motion: where it begins, how long its steps are, what is stored."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.analysis.base import Run
from kirigami.analysis.dynamics.motion import Moment, Motion, StepFailedError
from kirigami.analysis.dynamics.schemes import SCHEMES
from kirigami.analysis.dynamics.steps import TimeSteps
from kirigami.analysis.path.checkpoint import Checkpoint
from kirigami.analysis.resumable import Recorder
from kirigami.errors import ConvergenceError, MechanismError, ModelError
from kirigami.linalg import SingularMatrixError, inverse_iteration
from kirigami.primitives.kernel import Array
from kirigami.progress import ProgressBar
from kirigami.results.results import Results
from kirigami.results.step import Step
from kirigami.system.inertia import Inertia

if TYPE_CHECKING:
    from kirigami.analysis.dynamics.dynamics import Dynamics


ALIKE = 1e-3  # imbalance, and difference of kinetic energies, up to which a step of another model may be one of this


class DynamicsRun(Run):
    """A run that goes from moment to moment, and stores each, or some of them."""

    def __init__(self, settings: Dynamics, recorders: Iterable[Recorder] = ()) -> None:
        super().__init__(settings, apart=settings.apart)
        self.settings, self.factors = settings, settings.factors
        self.recorders = tuple(recorders)
        self.checkpoint: Checkpoint | None = None
        self.bar = ProgressBar(False, "")
        self.inertia = Inertia(self.system, settings.mass)
        self.motion = Motion(
            self.system, self.inertia, self.factorize, settings.damping, settings.tol, self._count_correction
        )
        self.steps = TimeSteps(
            self.motion, SCHEMES[settings.scheme], settings.step, self._load, settings.adaptive, self._count_cut
        )
        self.moment: Moment
        self.first_energy = 0.0
        self.largest_kinetic = 0.0
        self.off = 0.0  # largest change of the total energy
        self.impulse = np.zeros_like(self.system.rest)  # of the supports since the moment stored last

    def _count_correction(self) -> None:
        self.results.stats["iterations"] += 1

    def _count_cut(self) -> None:
        self.results.stats["cutbacks"] += 1

    def _load(self, time: float) -> tuple[Array, Array]:
        return self.factors.at(time), self.factors.rate(time, self.settings.step)

    def where(self) -> str:
        """How far it has come, in words."""
        return f"time {self.results.steps[-1].time if self.results.steps else 0.0:.6g}"

    # ---- beginning

    def follow(self, stored: tuple[Results, dict[str, Any]] | None) -> None:
        """Go from the beginning, or from where a checkpoint left off, to the end."""
        settings = self.settings
        self.moment = self._first_moment()
        if stored is None:
            self._push()
            self.first_energy = self.motion.kinetic(self.moment) + self.motion.potential(self.moment)
            self._store(0, 0.0)
        else:
            self._resume(*stored)
        self.bar.start(self._progress())
        taken = 0
        stops = [float(time) for time in self.factors.times if settings.begin < time < settings.end] + [settings.end]
        for stop in stops:
            while self.moment.time < stop:
                corrections, residual = self._advance(stop)
                taken += 1
                assert self.moment.impulse is not None
                self.impulse += self.moment.impulse
                if taken % settings.every == 0 or self.moment.time >= settings.end:
                    self._store(corrections, residual)
                    if self.checkpoint is not None:
                        self.checkpoint.note(self)
                self.bar.move(self._progress())

    def _progress(self) -> float:
        return (self.moment.time - self.settings.begin) / (self.settings.end - self.settings.begin)

    def _first_moment(self) -> Moment:
        """Where the settings say that the motion begins."""
        settings, system = self.settings, self.system
        start, time = settings.start, settings.begin
        factors, rates = self._load(time)
        moved = start is not None and start.velocity is not None
        before = start.lam if start is not None and start.stage == system.model.stage else 0.0
        system.own = factors[1:] if moved else np.full(len(factors) - 1, before)
        q, held = self.begin_at(start)
        stand = system.known(held)
        apart = float(np.abs(system.known(system.factored(factors)) - stand).max(initial=0.0))
        if apart > 1e-9 * system.size:
            raise ModelError(
                f"Dynamics: supports would have to jump by {apart:.3g} at the beginning, since they stand where load "
                f"factor {held:.6g} puts them and load, or a history, gives another one: let it begin with {held:.6g}, "
                f"as in load=[(0, {held:.6g}), (0.1, 1)]"
            )
        u = self.motion.at(q, factors)
        rate, given = np.zeros(system.free), None
        if settings.velocity is not None:
            given = np.zeros_like(system.rest)
            given[: system.points] = settings.velocity[:, : system.dim]
            if system.grips is not None:
                system.grips.lead_rates(given, u)
            rate = system.unknowns(given)
        elif start is not None and start.velocity is not None:
            given = system.joined(start.velocity, start.inner_velocity)
            rate = system.unknowns(given)
        velocity = self.motion.velocity(rate, factors, rates, u)
        if settings.velocity is not None:
            assert given is not None
            off = np.abs(velocity - given)[: system.points].max(axis=1)
            worst = int(np.argmax(off))
            if off[worst] > 1e-9 * float(np.abs(settings.velocity).max(initial=0.0)):
                raise ModelError(
                    f"Dynamics: the velocity of node {worst} {system.model.nodes[worst]!r} is not what its supports "
                    "and ties allow: leave it zero there"
                )
        elif given is not None:
            velocity = np.where(self.motion.free, given, velocity)
        moment = Moment(time, factors, rates, q, velocity)
        self._check_start(moment, held)
        self._check_equations(moment)
        return moment

    def _check_start(self, moment: Moment, held: float) -> None:
        """Raise a ModelError for a start that another model made and that is not one of this model.

        What another model made alike is: in balance as it was there, and with the same kinetic energy.
        """
        start, system = self.settings.start, self.system
        if start is None or start.stage_key in ("", system.model.stage_key) or start.stage != system.model.stage:
            return
        if start.velocity is not None:
            kinetic = self.motion.kinetic(moment)
            alike = abs(kinetic - start.kinetic) <= ALIKE * max(kinetic, start.kinetic)
        else:
            u = system.joined(start.u, start.inner)
            alike = not start.residual < ALIKE**2 or system.imbalance(u, held)[1] <= ALIKE
        if not alike:
            raise ModelError(
                "Dynamics: start is of another model, of which this one is no copy: give a step of this one, or "
                "kg.Step.at(model, lam, step.u), which takes the displacements alone"
            )

    def _check_equations(self, moment: Moment) -> None:
        """Raise a MechanismError where something has neither mass nor stiffness."""
        u = self.motion.displacement(moment)
        blocks = (2 / self.settings.step**2) * self.inertia.blocks + self.system.stiffness_blocks(u, moment.lam)
        try:
            self.factorize(self.system.matrix(blocks))
        except SingularMatrixError:
            raise MechanismError(
                "Dynamics: some motion has neither mass nor stiffness: give its nodes a mass (kg.Mass), or fix them"
            ) from None

    def _push(self) -> None:
        """Leave a located point along its mode, since nothing else may."""
        settings, system = self.settings, self.system
        if settings.mode is None or not settings.push:
            return
        u = self.motion.displacement(self.moment)
        matrix = system.matrix(system.stiffness_blocks(u, self.moment.lam))
        with suppress(SingularMatrixError):
            _, mode = inverse_iteration(self.factorize(matrix), system.free, 30, 1e-6)
            change = system.motion(mode, about=u)
            side = np.sign(float((system.parted(change)[0] * settings.mode).sum())) or 1.0
            self.moment.q = self.moment.q + (side * settings.push / system.largest_rotation(change)) * mode

    # ---- going on

    def _advance(self, stop: float) -> tuple[int, float]:
        """One accepted time step; the corrections it took and its residual."""
        settings = self.settings
        try:
            self.moment, corrections, residual = self.steps.advance(self.moment, stop)
        except StepFailedError as failure:
            raise self._failure(str(failure)) from None
        kinetic = self.motion.kinetic(self.moment)
        self.largest_kinetic = max(self.largest_kinetic, kinetic)
        loses = settings.scheme != "conserving" or any(settings.damping)
        if not loses and np.array_equal(self.moment.factors, self.factors.at(settings.begin)):
            self.off = max(self.off, abs(kinetic + self.motion.potential(self.moment) - self.first_energy))
            self.results.stats["energy_drift"] = self.off / (self.largest_kinetic or 1.0)
        return corrections, residual

    def _failure(self, reason: str) -> ConvergenceError:
        hint = "a smaller step" if not self.settings.adaptive else "scheme='damped', or some damping"
        return ConvergenceError(
            f"Dynamics: {reason}",
            results=self.results,
            hint=f"{hint} may help; the results so far are in error.results",
        )

    def _store(self, corrections: int, residual: float) -> None:
        system, moment = self.system, self.moment
        velocity = moment.velocity
        since = moment.time - self.results[-1].time if len(self.results) else 0.0
        nodal, inner = system.parted(self.motion.displacement(moment))
        nodal_velocity, inner_velocity = system.parted(velocity)
        forces, inner_forces = system.parted(self.impulse / since) if since > 0 else (None, np.zeros((0, 3)))
        self.impulse[:] = 0.0
        kinetic = self.inertia.energy(velocity)
        if not (np.isfinite(nodal).all() and np.isfinite(kinetic)):
            raise self._failure(f"the motion is not finite at time {self.moment.time:.6g}")
        step = Step(
            lam=float(moment.lam),
            u=nodal,
            inner=inner,
            residual=residual,
            iterations=corrections,
            history=system.history,
            stage=system.model.stage,
            stage_key=system.model.stage_key,
            time=float(moment.time),
            velocity=nodal_velocity,
            inner_velocity=inner_velocity,
            kinetic=kinetic,
            forces=forces,
            inner_forces=inner_forces,
        )
        step = self.store(step)
        for recorder in self.recorders:
            recorder(step)

    # ---- checkpoints

    @property
    def memory(self) -> dict[str, Any]:
        """What must be stored to go on later as if nothing had been."""
        names = ("first_energy", "largest_kinetic", "off")
        own = {f"moment.{name}": value for name, value in vars(self.moment).items()}
        own |= {name: getattr(self, name) for name in names}
        return {**own, **self.system.memory, "steps.size": self.steps.size}

    def _resume(self, stored: Results, memory: dict[str, Any]) -> None:
        """Go back to where a checkpoint was written."""
        self.system.remember(memory)
        for name, value in memory.items():
            if name in self.system.memory:
                continue
            if name.startswith("moment."):
                setattr(self.moment, name.removeprefix("moment."), value)
            elif name == "steps.size":
                self.steps.size = value
            else:
                setattr(self, name, value)
        for step in stored.steps:
            self.results.append(step)
        self.results.events.extend(stored.events)
        self.system.history = self.results[-1].history
        self.results.stats = stored.stats
        self.take_seconds(stored.stats["seconds"])

