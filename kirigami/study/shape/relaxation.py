"""From any shape downhill to a stable equilibrium: at a load factor, or up to it from a share of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kirigami.analysis.path.controls import Control, LoadFactorControl
from kirigami.analysis.path.points import Attempt, Point, State
from kirigami.analysis.path.run import MAX_RELAXATION, PathRun
from kirigami.analysis.path.settings import PathSettings
from kirigami.errors import ConvergenceError
from kirigami.linalg import SingularMatrixError, one_thread
from kirigami.model.model import Model
from kirigami.primitives.kernel import Array
from kirigami.results.step import Step
from kirigami.system.system import System

RISE = 1.25  # factor from one load factor to the next on the way up
ROUNDS = 8  # most descents in a row, each from where the last one ran out of iterations, as long as the energy falls


@dataclass(frozen=True, eq=False)
class Relaxed:
    """A stable equilibrium: its step, its energy [force length], and the force of the drive there [force]."""

    step: Step
    energy: float
    force: float


class _Downhill(PathSettings):
    """A path at whose every point unstable equilibria are left downhill."""

    def __init__(self, model: Model, tol: float) -> None:
        super().__init__(model, tol, None, "switch", None, "descent")

    def make_control(self, system: System) -> Control:
        return LoadFactorControl()


class Relaxer:
    """Runs shapes of one model downhill, at one load factor.

    Attributes
    ----------
    at : float
        The load factor.
    system : System
        The model, lowered.
    settings : PathSettings
        What tells the descents from others.
    """

    def __init__(self, model: Model, at: float, tol: float) -> None:
        self.at = at
        self.settings = _Downhill(model, tol)
        self._run = PathRun(self.settings)
        self.system = self._run.system

    @property
    def factorizations(self) -> int:
        """How many there were so far."""
        return int(self._run.results.stats["factorizations"])

    def relax(self, u: Array, share: float = 1.0) -> Relaxed:
        """The stable equilibrium below displacements `u` (n, 3) of the nodes, which are those at a share of the load.

        Below 1 the sheet is let down there, and then pulled up: a small buckle finds its place more easily than a
        large one.

        Raises
        ------
        ConvergenceError
            No stable equilibrium was found.
        """
        run, system = self._run, self.system
        with one_thread():
            system.history = None
            rows = system.settled(u)
            lam = self.at * share
            q = system.unknowns(rows)
            attempt = self._downhill(State(q, lam, system.displacement(q, lam)))
            while share < 1.0:
                point = self._point(attempt)
                share = min(RISE * share, 1.0)
                attempt = run.relax(point, self.at * share - point.state.lam, hold=True)
            state = self._point(attempt).state
            step = run.make_step(state.u, state.lam, 0, attempt.residual, attempt.iterations)
        return Relaxed(step, *self.energy_and_force(step))

    def _downhill(self, state: State) -> Attempt:
        """Downhill for as long as it goes down: a thin locked sheet takes hundreds of iterations."""
        energy = self._energy(state)
        for _ in range(ROUNDS):
            attempt = self._run.descend(state)
            state, before, energy = attempt.state, energy, self._energy(attempt.state)
            if attempt.converged or attempt.iterations < MAX_RELAXATION or not energy < before:
                break
        return attempt

    def _energy(self, state: State) -> float:
        return float(sum(self.system.energies(state.u, state.lam).values()))

    def _point(self, attempt: Attempt) -> Point:
        """The equilibrium of an attempt, accepted."""
        try:
            tangent = self._run.tangent_at(attempt)
        except SingularMatrixError:
            tangent = None
        if tangent is None or tangent.factor.negative:
            raise ConvergenceError(f"no stable equilibrium found: {attempt.reason or 'the tangent is singular'}")
        self.system.commit(attempt.state.u, attempt.state.lam)
        return Point(attempt.state, tangent, self.system.history)

    def energy_and_force(self, step: Step) -> tuple[float, float]:
        """Energy of a step, that of loads included, and the work of the drive per unit of load factor over the largest
        displacement it prescribes; nan without one."""
        system = self.system
        rows = system.joined(step.u, step.inner)
        before, system.history = system.history, step.history
        try:
            energy = float(sum(system.energies(rows, step.lam).values()))
            reach = np.linalg.norm(system.drive.reshape(system.rest.shape)[: system.points], axis=1).max(initial=0.0)
            force = system.potential_rate(rows, step.lam) / float(reach) if reach > 0 else float("nan")
        finally:
            system.history = before
        return energy, force
