"""Landing with inertia: after a snap, lightly damped motion chooses the stable shape instead of the overdamped limit.

Increments are those of :mod:`kirigami.analysis.path.stable`. Where one of them sets energy free, the same loss of
stability is left once more at the load factor reached, now with the masses of the sheet and a small damping in
proportion to them, until what is left of the kinetic energy is nothing against what was set free. The equilibrium next
to where the motion then is, is the landing. Its masses may be scaled all alike without a change: a sheet of unknown
density gets its area.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from kirigami.analysis.dynamics.motion import Moment, Motion, StepFailedError
from kirigami.analysis.dynamics.schemes import SCHEMES
from kirigami.analysis.dynamics.steps import TimeSteps
from kirigami.analysis.path.events import tell_events
from kirigami.analysis.path.points import Attempt, Point, State
from kirigami.analysis.path.release import SMALL, SNAP
from kirigami.analysis.path.stable import PREDICTED_TURN, StableSteps
from kirigami.errors import ModelError
from kirigami.linalg import Factor
from kirigami.primitives.kernel import Array
from kirigami.system.inertia import Inertia

SWINGS = 40  # longest time steps in a period of the slowest motion about the overdamped landing
AT_REST = 1e-3  # kinetic energy over a period, as a share of what was set free, at which the motion has come to rest
BEGUN = 0.1  # share of the energy to be set free from which on the motion has begun
PERIODS = 10.0  # most periods, times the time in which the damping takes a factor e
TOLERANCE = 1e-6  # residual of a time step


class InertialSteps(StableSteps):
    """Increments of the corrector "path" that land by motion."""

    def advance(self, before: Point, increment: float) -> tuple[Point, Attempt, float]:
        run, events = self.run, self.run.results.events
        known = len(events)
        point, landed, increment = super().advance(before, increment)
        if not any(event.kind in (SNAP, SMALL) for event in events[known:]):
            return point, landed, increment
        moved = self._by_motion(before, point, landed, increment)
        tangent = None if moved is None else run.tangent_at(moved)
        if moved is None or tangent is None:
            run.system.history = point.history
            return point, landed, increment
        run.system.commit(moved.state.u, moved.state.lam)
        point = Point(moved.state, tangent, run.system.history)
        del events[known:]
        tell_events(run, before, point, increment, moved.left, moved.drift)
        return point, moved, increment

    def _by_motion(self, before: Point, point: Point, landed: Attempt, increment: float) -> Attempt | None:
        """The equilibrium that motion from the loss of stability leads to; None where none is found."""
        run, system = self.run, self.run.system
        start = self._off(before, self._lost_at(before, landed, increment), increment)
        frequency = self._frequency(point.tangent.factor)
        damping = run.settings.damping
        system.history = before.history
        motion = Motion(
            system, self._inertia, run.factorize, (2 * damping * frequency, 0.0), TOLERANCE, run.count_iteration
        )
        period, lam, still = 2 * np.pi / frequency, np.array([start.lam]), np.zeros(1)
        steps = TimeSteps(motion, SCHEMES["damped"], period / SWINGS, lambda time: (lam, still))
        moment = Moment(0.0, lam, still, start.q, np.zeros_like(system.rest))
        first = motion.potential(moment)
        free = first - sum(system.energies(point.state.u, start.lam).values())
        most = PERIODS / (2 * np.pi * damping)
        try:
            for number in range(int(np.ceil(most)) + 1):
                largest = 0.0
                while moment.time < (number + 1) * period:
                    moment = steps.advance(moment, (number + 1) * period)[0]
                    largest = max(largest, motion.kinetic(moment))
                # Where stability is just lost the motion begins slowly: nothing has been set free yet.
                if largest < AT_REST * free and first - motion.potential(moment) > BEGUN * free:
                    break
        except StepFailedError:
            return None
        state = State(moment.q, start.lam, system.displacement(moment.q, start.lam))
        moved = run.descend(state)
        if not moved.converged:
            return None
        moved.relaxed, moved.left, moved.drift = True, landed.left, landed.drift
        return moved

    def _lost_at(self, before: Point, landed: Attempt, increment: float) -> State:
        """Where stability is lost: the unstable equilibrium that was left or, without one, on the way along the tangent
        as far as that means something."""
        if landed.left is not None:
            return landed.left.state
        system = self.run.system
        predicted = self.run.predict(before, increment)
        assert predicted is not None
        guess, change = predicted
        part = min(1.0, PREDICTED_TURN / max(system.largest_rotation(change), 1e-12))
        q = before.state.q + part * (guess.q - before.state.q)
        return State(q, guess.lam, system.displacement(q, guess.lam))

    @cached_property
    def _inertia(self) -> Inertia:
        system = self.run.system
        try:
            return Inertia(system, "consistent")
        except ModelError:
            area: Array = np.ones(system.points)
            mesh = system.model.mesh
            if mesh is not None:
                shares = np.repeat(mesh.facet_areas / 3, 3)
                area = np.asarray(np.bincount(mesh.triangles.ravel(), shares, system.points), dtype=float)
            return Inertia(system, area)

    def _frequency(self, factor: Factor) -> float:
        """Circular frequency of the slowest motion about a stable equilibrium, by power iteration."""
        mass = self._inertia.matrix
        vector: Array = np.random.default_rng(0).normal(size=mass.shape[0])
        value = 0.0
        for _ in range(200):
            image = factor.solve(mass @ vector)
            size = float(np.sqrt(image @ (mass @ image)))
            vector, last, value = image / size, value, size
            if abs(value - last) < 1e-3 * value:
                break
        return float(1.0 / np.sqrt(value))
