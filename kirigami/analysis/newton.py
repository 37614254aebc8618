"""The corrector that every path method shares: Newton's method on equilibrium plus one equation of control.

Unknowns are (q, lam). Equilibrium r(q, lam) = 0 and control g(q, lam) = 0 are solved by bordering, with one
factorisation and two solves per iteration:

    dq = a + b dlam,   a = -K^-1 r,   b = -K^-1 dr/dlam,   dlam = -(g + g_q.a) / (g_lam + g_q.b)

Two things carry it through the sharp corners of thin sheets. The geometric stiffness takes its bar stresses from the
linear step just made instead of the position reached, where a rotation has pumped false stress into stiff bars
(mixed-stress Newton: Magisano, Leonetti and Garcea, Comput. Methods Appl. Mech. Eng. 313 (2017)); the residual stays
exact. And no correction may turn a member by more than a set angle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from kirigami.kernel import Array
from kirigami.linalg import Factor, SingularMatrixError

if TYPE_CHECKING:
    from kirigami.analysis.path import Control
    from kirigami.system import System

ROTATION_CAP = 0.3  # largest turn of a member in one correction [rad]
DIVERGED = 1e6  # growth of the residual after which an attempt is hopeless


@dataclass
class State:
    """A point of the path: unknowns, load factor, displacements (n, dim)."""

    q: Array
    lam: float
    u: Array


@dataclass
class Attempt:
    """How one correction went."""

    state: State
    converged: bool
    residual: float
    iterations: int
    history: list[float] = field(default_factory=list)
    reason: str = ""


@dataclass
class Tangent:
    """Exact tangent at an equilibrium: node blocks, factor, and -K^-1 dr/dlam (free,)."""

    blocks: Array
    factor: Factor
    rate: Array


def correct(
    system: System,
    factorize: Callable[[Array], Factor],
    control: Control,
    start: State,
    tol: float,
    max_iterations: int,
    first: Tangent | None = None,
    on_iteration: Callable[[], None] = lambda: None,
) -> Attempt:
    """Newton iterations from `start` until equilibrium and control hold.

    `first` is the exact tangent at `start`, if it is at hand: its factor serves the first iteration.
    """
    q, lam = start.q.copy(), start.lam
    history: list[float] = []
    factor: Factor | None = None
    u = start.u
    for iteration in range(max_iterations + 1):
        with np.errstate(all="ignore"):
            total, scale = system.forces(u, lam)
        residual = system.reduce(total)
        relative = float(np.linalg.norm(residual)) / scale if scale > 0 else 0.0
        gap, gap_q, gap_lam = control.equation(q, lam)
        history.append(relative)
        state = State(q, lam, u)
        if not np.isfinite(relative):
            return Attempt(state, False, relative, iteration, history, "a member collapsed (forces are not finite)")
        if relative <= tol and abs(gap) <= control.slack:
            system.linearize(None)
            return Attempt(state, True, relative, iteration, history)
        if iteration == max_iterations:
            break
        if len(history) > 3 and relative > DIVERGED * min(history):
            return Attempt(state, False, relative, iteration, history, "the residual grew without bound")
        try:
            if iteration == 0 and first is not None:
                factor, along = first.factor, first.rate
            else:
                blocks = system.stiffness_blocks(u, lam)
                factor = factorize(blocks)
                along = None
            with system.clock("solve"):
                against = -factor.solve(residual) if relative > 0 else np.zeros_like(residual)
                if along is None and (gap_q is not None or gap != 0):
                    along = -factor.solve(system.load_rate(u, lam, blocks))
        except SingularMatrixError as error:
            return Attempt(state, False, relative, iteration, history, str(error))
        step_q, step_lam = against, 0.0
        if along is not None:
            slope = gap_lam if gap_q is None else gap_lam + float(gap_q @ along)
            error = gap if gap_q is None else gap + float(gap_q @ against)
            if slope == 0 or not np.isfinite(slope):
                return Attempt(state, False, relative, iteration, history, "the control does not act on the structure")
            step_lam = -error / slope
            step_q = against + step_lam * along
        change = system.displacement(q + step_q, lam + step_lam) - u
        turn = system.largest_rotation(change)
        if not np.isfinite(turn):
            return Attempt(state, False, relative, iteration, history, "the correction is not finite")
        if turn > ROTATION_CAP and iteration > 0:
            factor_of_step = ROTATION_CAP / turn
            step_q, step_lam, change = factor_of_step * step_q, factor_of_step * step_lam, factor_of_step * change
        system.linearize(u, change)
        q, lam = q + step_q, lam + step_lam
        u = system.displacement(q, lam)
        on_iteration()
    system.linearize(None)
    return Attempt(State(q, lam, u), False, history[-1], max_iterations, history, "too many iterations")
