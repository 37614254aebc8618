"""Where a motion stands, and what all time steps share: forces, masses, damping, and the corrections of a step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kirigami.analysis.dynamics.spin import Spin
from kirigami.linalg import Factor, SingularMatrixError
from kirigami.primitives.kernel import EXACT, Array, Tangent
from kirigami.system.inertia import Inertia
from kirigami.system.system import System

CAP = 0.3  # largest turn of a member in a correction [rad]
REFUSED = 0.7  # a time step that turns a member by more is refused: beyond, normals flip and energy comes from nowhere
LEAST_SHARE = 1e-8  # share of a correction that effects must allow for it to be worth another one
CORRECTIONS = 20  # most corrections of a time step
STILL = 1e-11  # turn of a member in a correction that changes nothing any more [rad]
CONVEX = Tangent(convexity=1.0)

Equations = Callable[[Array], tuple[Array, float, Callable[[], Array]]]


@dataclass
class Moment:
    """A moment of a motion.

    Attributes
    ----------
    time : float
        Time.
    factors, rates : ndarray, shape (1 + k,)
        Load factor, then those of the k objects with a history of their own; and how fast they change.
    q : ndarray, shape (free,)
        Unknowns.
    velocity : ndarray, shape (rows, dim)
        Velocities.
    impulse : ndarray, shape (rows, dim), or None
        What supports gave in the time step that led here: the change of momentum less what damping, members and loads
        gave; about zero where nothing is held. None at the beginning.
    """

    time: float
    factors: Array
    rates: Array
    q: Array
    velocity: Array
    impulse: Array | None = None

    @property
    def lam(self) -> float:
        """The load factor."""
        return float(self.factors[0])


class StepFailedError(Exception):
    """A time step was not found; a shorter one may be."""


class Motion:
    """The equations of motion of a system.

    Parameters
    ----------
    system : System
        The lowered model.
    inertia : Inertia
        Its masses.
    factorize : callable
        Factorises a matrix over the unknowns.
    damping : tuple of float
        Shares of mass [1 / time] and stiffness [time] in the damping matrix (Rayleigh).
    tol : float
        Residual of a time step over the root sum of squares of its unassembled forces.
    count : callable
        Called at every correction.
    """

    def __init__(
        self,
        system: System,
        inertia: Inertia,
        factorize: Callable[[Any], Factor],
        damping: tuple[float, float] = (0.0, 0.0),
        tol: float = 1e-8,
        count: Callable[[], None] = lambda: None,
    ) -> None:
        self.system, self.inertia, self.factorize = system, inertia, factorize
        self.damping, self.tol, self.count = damping, tol, count
        moving = system.unknown >= 0
        self.massless = moving.copy()
        self.massless[moving] = (inertia.matrix.diagonal() == 0)[system.unknown[moving]]
        self.free = moving.reshape(system.rest.shape).copy()
        if system.grips is not None:
            self.free |= system.grips.led_freely(self.free)
        self.spin = Spin(system, inertia)

    def at(self, q: Array, factors: Array) -> Array:
        """Displacements (rows, dim) for unknowns (free,) and load factors (1 + k,)."""
        lam = self.system.factored(factors)
        return self.system.displacement(q, lam)

    def displacement(self, moment: Moment) -> Array:
        """Displacements (rows, dim)."""
        return self.at(moment.q, moment.factors)

    def velocity(self, rate: Array, factors: Array, rates: Array, about: Array) -> Array:
        """Velocities (rows, dim) at rates of the unknowns (free,) and of the load factors (1 + k,), about displacements
        (rows, dim)."""
        system = self.system
        full = system.known_rate(system.factored(factors), rates)
        moving = system.unknown >= 0
        full[moving] += rate[system.unknown[moving]]
        field: Array = full.reshape(system.rest.shape)
        if system.grips is not None:
            system.grips.follow(field, about)
        return field

    def forces(self, u: Array, factors: Array) -> tuple[Array, float]:
        """Gradient of the potential (rows, dim), nothing of it carried to the rows that lead, and its scale."""
        return self.system.forces(u, self.system.factored(factors), carried=False)

    def kinetic(self, moment: Moment) -> float:
        """Kinetic energy."""
        return self.inertia.energy(moment.velocity)

    def potential(self, moment: Moment) -> float:
        """Stored energy and that of the loads."""
        return sum(self.system.energies(self.displacement(moment), moment.lam).values())

    def stiffness_blocks(self, u: Array, factors: Array, tangent: Tangent = EXACT) -> Array:
        """Node blocks of the tangent, nothing of it carried to the rows that lead."""
        return self.system.stiffness_blocks(u, self.system.factored(factors), tangent, carried=False)

    def damping_blocks(self, moment: Moment, more: float = 0.0) -> Array | None:
        """Node blocks of the damping matrix, None without any: mass, and the stiffness at the beginning of the step
        without what could make it indefinite, and of what stores energy alone, so that energy is only lost and what
        slides is held back by no more than friction; of that, a share `more` [time]."""
        mass, stiffness = self.damping[0], self.damping[1] + more
        if not mass and not stiffness:
            return None
        blocks = mass * self.inertia.uncarried
        if stiffness:
            u, lam = self.displacement(moment), moment.lam
            blocks = blocks + stiffness * self.system.stiffness_blocks(u, lam, CONVEX, carried=False, stored=True)
        return blocks

    def carried(self, total: Array, u: Array, chord: Array) -> Array:
        """Forces over the unknowns (free,) of forces (rows, dim) on a chord (rows, dim) that ends at `u`."""
        system = self.system
        if system.grips is not None:
            total = total.copy()
            system.grips.carry(total, u, chord)
        return system.reduce(total)

    def carried_blocks(self, blocks: Array, u: Array, chord: Array, total: Array) -> Array:
        """Node blocks of the derivative of that, about."""
        system = self.system
        if system.grips is not None:
            plan = system.plan
            system.grips.condense(blocks, plan.low, plan.high, u - 0.5 * chord, 0.5 * total, 0.0)
        return blocks

    def corrected(
        self, start: Moment, guess: Array, factors: Array, equations: Equations
    ) -> tuple[Array, int, float]:
        """Unknowns at the end of a step, the corrections it took, and the relative residual.

        `equations` gives residual (free,), its scale, and what makes the node blocks of its derivative.
        """
        system = self.system
        q = guess
        before = self.displacement(start)
        u = self.at(q, factors)
        share = system.admissible(before, u)
        if share < 1:  # what is driven arrives, the rest follows as far as it may
            q = start.q + 0.9 * share * (guess - start.q)
            u = self.at(q, factors)
            if system.admissible(before, u) < 1:
                raise StepFailedError("the sheet would pass through itself")
        still = False
        for correction in range(CORRECTIONS + 1):
            with np.errstate(all="ignore"):
                residual, scale, tangent = equations(q)
            size = float(np.linalg.norm(residual))
            if not np.isfinite(size):
                raise StepFailedError("a member collapsed")
            relative = size / scale if scale > 0 else 0.0
            if relative <= self.tol or still:
                break
            if correction == CORRECTIONS:
                raise StepFailedError(f"too many corrections (residual {relative:.1e})")
            try:
                with np.errstate(all="ignore"):
                    factor = self.factorize(system.matrix(tangent()))
                with system.clock("solve"):
                    change = -factor.solve(residual)
            except SingularMatrixError as error:
                raise StepFailedError(str(error)) from None
            turn = system.largest_rotation(self.at(q + change, factors) - u)
            if not np.isfinite(turn):
                raise StepFailedError("a correction is not finite")
            if turn > CAP:
                change, turn = (CAP / turn) * change, CAP
            share = system.admissible(u, self.at(q + change, factors))
            if share < LEAST_SHARE:
                raise StepFailedError("the sheet would pass through itself")
            if share < 1:
                change, turn = share * change, share * turn
            still = turn < STILL
            q = q + change
            u = self.at(q, factors)
            self.count()
        if system.admissible(before, u) < 1:
            raise StepFailedError("the sheet would pass through itself")
        turn = system.largest_rotation(u - before)
        if turn > REFUSED:
            raise StepFailedError(f"a member would turn by {turn:.2g} rad in one time step, more than {REFUSED:g}")
        return q, correction, relative
