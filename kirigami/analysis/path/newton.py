"""The corrector that every path method shares: Newton's method on equilibrium plus one equation of control.

Unknowns are (q, lam). Equilibrium r(q, lam) = 0 and control g(q, lam) = 0 are solved by bordering, with one
factorisation and two solves per iteration:

    dq = a + b dlam,   a = -K^-1 r,   b = -K^-1 dr/dlam,   dlam = -(g + g_q.a) / (g_lam + g_q.b)

Two things carry it through the sharp corners of thin sheets; the residual stays exact in both:

* Mixed stress. The geometric stiffness takes its bar stresses from the linear step just made instead of the position
  reached, where a rotation has pumped false stress into stiff bars (Magisano, Leonetti and Garcea, Comput. Methods
  Appl. Mech. Eng. 313 (2017)).
* No correction may turn a member by more than a set angle.

Where it fails, or finds an unstable equilibrium, :mod:`kirigami.analysis.path.descent` goes on.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kirigami.analysis.path.controls import Control
from kirigami.analysis.path.points import Attempt, State
from kirigami.analysis.path.skew import solve
from kirigami.linalg import Factor, SingularMatrixError
from kirigami.primitives.kernel import Ahead, Array, Tangent
from kirigami.system.system import System

ROTATION_CAP = 0.3  # largest turn of a member in one correction [rad]
LEAST_SHARE = 1e-8  # share of a correction that effects must allow for it to be worth another one
BLOCKED = "the sheet would pass through itself"
DIVERGED = 1e6  # growth of the residual after which an attempt is hopeless


def correct(
    system: System,
    factorize: Callable[[Array], Factor],
    control: Control,
    start: State,
    tol: float,
    max_iterations: int,
    on_iteration: Callable[[], None] = lambda: None,
    ahead: Ahead = None,
) -> Attempt:
    """Newton iterations from `start` until equilibrium and control hold.

    `ahead` is the linear step that led to `start`: displacements and their change, see :class:`kirigami.Tangent`.
    """
    tangent = Tangent(ahead=ahead)
    q, lam, u = start.q.copy(), start.lam, start.u
    history: list[float] = []
    sizes: list[float] = []
    for iteration in range(max_iterations + 1):
        with np.errstate(all="ignore"):
            residual, relative = system.imbalance(u, lam)
        gap, gap_q, gap_lam = control.equation(q, lam)
        history.append(relative)
        sizes.append(float(np.linalg.norm(residual)))

        def failed(reason: str) -> Attempt:
            return Attempt(State(q, lam, u), False, relative, iteration, history, reason)  # noqa: B023

        if not np.isfinite(relative):
            return failed("a member collapsed (forces are not finite)")
        if relative <= tol and abs(gap) <= control.slack:
            return Attempt(State(q, lam, u), True, relative, iteration, history)
        if iteration == max_iterations:
            return failed("too many iterations")
        if _hopeless(history, sizes):
            return failed("the residual does not fall")
        try:
            blocks = system.stiffness_blocks(u, lam, tangent)
            factor = factorize(blocks)
            with system.clock("solve"):
                step_q = -solve(system, factor, q, lam, residual) if relative > 0 else np.zeros_like(residual)
                step_lam = 0.0
                if gap_q is not None or gap != 0:
                    along = -solve(system, factor, q, lam, system.load_rate(u, lam, blocks))
                    slope = gap_lam if gap_q is None else gap_lam + float(gap_q @ along)
                    if slope == 0 or not np.isfinite(slope):
                        return failed("the control does not act on the structure")
                    step_lam = -(gap if gap_q is None else gap + float(gap_q @ step_q)) / slope
                    step_q = step_q + step_lam * along
        except SingularMatrixError as error:
            return failed(str(error))
        change = system.displacement(q + step_q, lam + step_lam) - u
        turn = system.largest_rotation(change)
        if not np.isfinite(turn):
            return failed("the correction is not finite")
        if turn > ROTATION_CAP:
            shortened = ROTATION_CAP / turn
            step_q, step_lam, change = shortened * step_q, shortened * step_lam, shortened * change
        share = system.admissible(u, u + change)
        if share < LEAST_SHARE:
            return failed(BLOCKED)
        if share < 1:
            step_q, step_lam, change = share * step_q, share * step_lam, share * change
        tangent = Tangent(ahead=(u, change))
        q, lam = q + step_q, lam + step_lam
        u = system.displacement(q, lam)
        on_iteration()
    raise AssertionError("unreachable")


def _hopeless(history: list[float], sizes: list[float]) -> bool:
    """True where a Newton attempt is not worth more factorisations, judged from its residuals.

    Whether they fall is told by their own sizes: where a stiff contact bears nearly all there is, relative ones stay
    near one while the sizes go down to a quarter each time, as its depth halves. They pause where nodes lose touch.
    """
    if history[-1] > DIVERGED * min(history):
        return True
    if len(sizes) == 5:
        return sizes[-1] > 0.3 * max(sizes[:2])
    return len(sizes) > 6 and sizes[-1] > 0.1 * sizes[-4]
