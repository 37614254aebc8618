"""Where a motion stands, and what all time steps share: forces, masses, damping, and the corrections of a step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kirigami.analysis.dynamics.spin import Spin
from kirigami.linalg import Factor, SingularMatrixError
from kirigami.primitives.kernel import Array, Tangent
from kirigami.system.inertia import Inertia
from kirigami.system.system import System

CAP = 0.3  # largest turn of a member in a correction [rad]
REFUSED = 0.7  # a time step that turns a member by more is refused: beyond, normals flip and energy comes from nowhere
CORRECTIONS = 20  # most corrections of a time step
STILL = 1e-11  # turn of a member in a correction that changes nothing any more [rad]
CONVEX = Tangent(convexity=1.0)

Equations = Callable[[Array], tuple[Array, float, Callable[[], Array]]]


@dataclass
class Moment:
    """A moment of a motion.

    Attributes
    ----------
    time, lam, lam_rate : float
        Time, load factor and its rate.
    q, rate : ndarray, shape (free,)
        Unknowns and their rates.
    """

    time: float
    lam: float
    lam_rate: float
    q: Array
    rate: Array


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
        self.massless = inertia.matrix.diagonal() == 0
        self.spin = Spin(system, inertia)

    def displacement(self, moment: Moment) -> Array:
        """Displacements (rows, dim)."""
        return self.system.displacement(moment.q, moment.lam)

    def velocity(self, rate: Array, lam: float, lam_rate: float) -> Array:
        """Velocities (rows, dim) at rates of the unknowns, and at a load factor and its rate."""
        system = self.system
        full = lam_rate * system.drive_at(lam) if lam_rate else np.zeros(system.rest.size)
        moving = system.unknown >= 0
        full[moving] += rate[system.unknown[moving]]
        return full.reshape(system.rest.shape)

    def kinetic(self, moment: Moment) -> float:
        """Kinetic energy."""
        return self.inertia.energy(self.velocity(moment.rate, moment.lam, moment.lam_rate))

    def potential(self, moment: Moment) -> float:
        """Stored energy and that of the loads."""
        return sum(self.system.energies(self.displacement(moment), moment.lam).values())

    def damping_blocks(self, moment: Moment, more: float = 0.0) -> Array | None:
        """Node blocks of the damping matrix, None without any: mass, and the stiffness at the beginning of the step
        without what could make it indefinite, so that energy is only lost; of that, a share `more` [time]."""
        mass, stiffness = self.damping[0], self.damping[1] + more
        if not mass and not stiffness:
            return None
        blocks = mass * self.inertia.blocks
        if stiffness:
            blocks = blocks + stiffness * self.system.stiffness_blocks(self.displacement(moment), moment.lam, CONVEX)
        return blocks

    def corrected(
        self, start: Moment, guess: Array, lam: float, equations: Equations
    ) -> tuple[Array, int, float]:
        """Unknowns at the end of a step, the corrections it took, and the relative residual.

        `equations` gives residual (free,), its scale, and what makes the node blocks of its derivative.
        """
        system = self.system
        q = guess
        u = system.displacement(q, lam)
        before = self.displacement(start)
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
            turn = system.largest_rotation(system.displacement(q + change, lam) - u)
            if not np.isfinite(turn):
                raise StepFailedError("a correction is not finite")
            if turn > CAP:
                change, turn = (CAP / turn) * change, CAP
            still = turn < STILL
            q = q + change
            u = system.displacement(q, lam)
            self.count()
        turn = system.largest_rotation(u - before)
        if turn > REFUSED:
            raise StepFailedError(f"a member would turn by {turn:.2g} rad in one time step, more than {REFUSED:g}")
        return q, correction, relative
