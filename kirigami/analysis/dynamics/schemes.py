"""One implicit time step h; M, C masses and damping, V the potential, u displacements, v velocities.

Momentum changes by the average gradient along the chord of the step, the average vector field (Quispel, McLaren,
J. Phys. A 41 (2008) 045206), and displacement by a mean velocity:

    M (v1 - v0) / h + (C + h (a - 1/2) K+) (u1 - u0) / h + int_0^1 grad V(u0 + s (u1 - u0)) ds = 0,
    (u1 - u0) / h = a v1 + (1 - a) v0.

Times u1 - u0 that is the balance of energy of the step: it loses

    (u1 - u0)'C (u1 - u0) / h + (a - 1/2) [ |v1 - v0|^2_M + (u1 - u0)'K+ (u1 - u0) ],

as far as the integral is exact; two Gauss points are, for energies of degree four, as those of bars with Green strain.

* "conserving": a = 1/2. Energy is kept at any step, also through snaps; of second order.
* "damped": a = 1 / (1 + rho), with K+ the stiffness at the beginning of the step without what makes it indefinite. The
  motions that are much faster than the step die out by the factor rho = 0.8 a step (their spectral radius), a slow one
  of circular frequency w is damped by (a - 1/2) w h of its critical damping, and energy never grows; of first order.

(Generalised-alpha, which is of second order, has been tried: through a snap it gains energy without bound.)

What has no mass follows: its forces vanish on the average of a step, so no mass is divided by.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kirigami.analysis.dynamics.motion import Moment, Motion
from kirigami.primitives.kernel import Array

PLACES = (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0))  # Gauss points of the chord, of equal weights
RHO = 0.8  # spectral radius of the damped scheme for motions much faster than the step
SCHEMES = {"conserving": 0.5, "damped": 1.0 / (1.0 + RHO)}  # the share a


def advance(
    motion: Motion, start: Moment, step: float, factors: Array, rates: Array, share: float = 0.5
) -> tuple[Moment, int, float]:
    """The moment one step on, at load factors and their rates there; the corrections it took, and the residual."""
    system, inertia = motion.system, motion.inertia
    u0, v0 = motion.displacement(start), start.velocity
    damping = motion.damping_blocks(start, step * (share - 0.5))
    before = inertia.momentum(v0)
    at_rest = float(np.linalg.norm(before)) / step
    nothing = np.zeros(system.free)
    known = motion.velocity(nothing, factors, rates, motion.at(start.q, factors))

    def velocity_after(change: Array) -> Array:
        return np.where(motion.free, (change / step - (1 - share) * v0) / share, known)

    def forces(change: Array) -> tuple[Array, float]:
        """What inertia, damping, members and loads leave (rows, dim), and its scale."""
        total = (inertia.momentum(velocity_after(change)) - before) / step
        averaged = []
        square = at_rest**2
        for s in PLACES:
            u, between = u0 + s * change, start.factors + s * (factors - start.factors)
            gradient, size = motion.forces(u, between)
            averaged.append((0.5, system.configuration(u), between, gradient))
            total += 0.5 * gradient
            square += 0.5 * size**2
        if motion.spin.parts:
            total += motion.spin.forces(averaged, system.rest + u0 + 0.5 * change)
        if damping is not None:
            total += system.multiply(damping, change / step)
        return total, float(np.sqrt(square))

    def equations(q: Array) -> tuple[Array, float, Callable[[], Array]]:
        u = motion.at(q, factors)
        change = u - u0
        total, scale = forces(change)
        return motion.carried(total, u, change), scale, lambda: tangent(u, change, total)

    def tangent(u: Array, change: Array, total: Array) -> Array:
        blocks = inertia.uncarried / (share * step**2)
        for s in PLACES:
            blocks += 0.5 * s * motion.stiffness_blocks(u0 + s * change, start.factors + s * (factors - start.factors))
        if damping is not None:
            blocks += damping / step
        return motion.carried_blocks(blocks, u, change, total)

    guess = start.q + step * system.unknowns(v0)
    q, corrections, residual = motion.corrected(start, guess, factors, equations)
    change = motion.at(q, factors) - u0
    velocity = velocity_after(change)
    # what has no mass: no inertia damps its rate from step to step
    velocity.ravel()[motion.massless] = change.ravel()[motion.massless] / step
    impulse = step * forces(change)[0]
    return Moment(start.time + step, factors, rates, q, velocity, impulse), corrections, residual
