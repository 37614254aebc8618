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
    motion: Motion, start: Moment, step: float, lam: float, lam_rate: float, share: float = 0.5
) -> tuple[Moment, int, float]:
    """The moment one step on, at a load factor and its rate there; the corrections it took, and the residual."""
    system, inertia = motion.system, motion.inertia
    u0, v0 = motion.displacement(start), motion.velocity(start.rate, start.lam, start.lam_rate)
    damping = motion.damping_blocks(start, step * (share - 0.5))
    before = inertia.momentum(v0)
    at_rest = float(np.linalg.norm(system.reduce(before))) / step

    def rate_at(q: Array) -> Array:
        return ((q - start.q) / step - (1 - share) * start.rate) / share

    def equations(q: Array) -> tuple[Array, float, Callable[[], Array]]:
        change = system.displacement(q, lam) - u0
        total = (inertia.momentum(motion.velocity(rate_at(q), lam, lam_rate)) - before) / step
        averaged = []
        square = at_rest**2
        for s in PLACES:
            u, factor = u0 + s * change, start.lam + s * (lam - start.lam)
            gradient, size = system.forces(u, factor)
            averaged.append((0.5, system.configuration(u), factor, gradient))
            total += 0.5 * gradient
            square += 0.5 * size**2
        if motion.spin.parts:
            total += motion.spin.forces(averaged, system.rest + u0 + 0.5 * change)
        if damping is not None:
            total += system.plan.multiply(damping, change / step)
        return system.reduce(total), float(np.sqrt(square)), lambda: tangent(change)

    def tangent(change: Array) -> Array:
        blocks = inertia.blocks / (share * step**2)
        for s in PLACES:
            blocks += 0.5 * s * system.stiffness_blocks(u0 + s * change, start.lam + s * (lam - start.lam))
        if damping is not None:
            blocks += damping / step
        return blocks

    q, corrections, residual = motion.corrected(start, start.q + step * start.rate, lam, equations)
    rate = rate_at(q)
    rate[motion.massless] = (q - start.q)[motion.massless] / step  # which no mass damps from step to step
    return Moment(start.time + step, lam, lam_rate, q, rate), corrections, residual
