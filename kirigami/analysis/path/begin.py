"""The first equilibrium of a walk: constant loads, heat and supports are taken in steps where one is too much."""

from __future__ import annotations

from kirigami.analysis.path.controls import LoadFactorControl
from kirigami.analysis.path.points import Attempt, State
from kirigami.analysis.path.run import PathRun

FIRST = 0.25  # first share of what is constant
GROWTH = 1.5  # factor from one share to the next
SMALL = 2e-3  # where Newton's method fails with less, it is not the step
LEAST = 1e-4  # smallest


def grown(run: PathRun, start: State) -> Attempt:
    """The equilibrium at the load factor of a start from rest, with what is constant grown from nothing; or the last
    attempt that failed.

    What yields or slides does so on the way, so each step is accepted before the next.
    """
    system, stay = run.system, LoadFactorControl()
    stay.begin(start, 0.0)
    share, more, attempt = 0.0, FIRST, Attempt(start, False, float("inf"), 0, [])
    system.history, q = None, start.q
    try:
        while share < 1.0:
            before, there = system.history, min(share + more, 1.0)
            system.begin(there)
            state = State(q, start.lam, system.displacement(q, start.lam))
            attempt = run.correct(stay, state)
            if not attempt.converged and more < SMALL:  # else a smaller step is cheaper
                attempt = run.descend(state)
            if attempt.converged:
                system.commit(attempt.state.u, start.lam)
                q, share, more = attempt.state.q, there, GROWTH * more
                continue
            system.history = before
            more = 0.5 * more
            if more < LEAST:
                break
    finally:
        system.begin(1.0)
    return attempt
