"""Corrections that stay on a stable path, at a given load factor: they end near the prediction or are given up early.

Newton's method with the mixed stress of :mod:`kirigami.analysis.path.newton`. The factor of the last equilibrium serves
for the first corrections, since a short increment hardly changes it. The last factor also tells whether the equilibrium
is stable, without a factorisation of its own, where it is shown to be close enough (:mod:`kirigami.linalg.nearby`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kirigami.analysis.path.iterate import Iterate
from kirigami.analysis.path.points import Attempt, State
from kirigami.linalg import Factor, SingularMatrixError
from kirigami.primitives.kernel import Ahead, Array
from kirigami.system.system import System

FACTORS = 5  # most factorisations before a shorter increment is the better idea
CHORDS = 8  # most corrections with one factor
DRIFT_LARGEST = 0.05  # turn off the prediction at which an attempt is given up [rad]


def track(
    system: System,
    factorize: Callable[[Array], Factor],
    start: State,
    tol: float,
    ahead: Ahead,
    factor: Factor,
    on_iteration: Callable[[], None] = lambda: None,
) -> Attempt:
    """Correct the prediction `start`, first with the `factor` of the equilibrium that it was made from.

    The attempt holds the stiffness at its end, which need not be stable, and the turn by which it left the prediction.
    """
    at = Iterate(system, factorize, start, tol, ahead)
    iteration = 0

    def ended(reason: str = "") -> Attempt:
        drift = system.largest_rotation(at.u - start.u)
        return Attempt(at.state, not reason, at.relative, iteration, at.history, reason, drift=drift)

    try:
        at.chords(factor, CHORDS)
        for iteration in range(FACTORS + 1):
            at.history.append(at.relative)
            if not np.isfinite(at.relative):
                return ended("a member collapsed (forces are not finite)")
            if system.largest_rotation(at.u - start.u) > DRIFT_LARGEST:
                return ended("the path bends away from the prediction")
            if at.relative <= tol:
                found = ended()
                found.stiffness = at.stiffness()
                return found
            if iteration < FACTORS:
                fresh = at.factor()
                at.correct(fresh)
                at.chords(fresh, CHORDS)
                del fresh  # so that the next one takes its place in memory
                on_iteration()
    except SingularMatrixError as error:
        return ended(str(error))
    return ended("too many iterations")
