"""Where a sheet is out of balance: the unknowns of one place, which may settle by themselves before all others follow.

A snap, a sharp bend or a wrinkle at the tip of a cut takes place between few nodes: nearly all of the residual sits
there, and the iterations that it takes are Newton's with that place while the rest hardly moves. So the place is
relaxed alone, with all else held, and the whole goes on from there: a nonlinear elimination (Lanzkron, Rose and Wilkes,
SIAM J. Sci. Comput. 17 (1996); Cresta, Allix, Rey and Guinard, Comput. Methods Appl. Mech. Eng. 196 (2007)).
"""

from __future__ import annotations

import numpy as np

from kirigami.primitives.kernel import Array
from kirigami.system.assembly import Index
from kirigami.system.system import System

GATHERED = 0.9  # share of the squared residual that is in the place
RINGS = 2  # rings of neighbours about it that settle with it
LARGEST = 0.25  # share of all unknowns from which on it is no place


def place_of(system: System, residual: Array) -> Index | None:
    """The unknowns (k,) of the place where nearly all of a residual (free,) sits; None where it is spread too far."""
    squares = np.bincount(system.heads // system.dim, residual**2, len(system.rest))
    largest_first = np.argsort(-squares, kind="stable")
    few = 1 + int(np.searchsorted(np.cumsum(squares[largest_first]), GATHERED * squares.sum()))
    near = np.zeros(len(squares), dtype=bool)
    near[largest_first[:few]] = True
    low, high = system.plan.low, system.plan.high
    for _ in range(RINGS):
        joined = near[low] | near[high]
        near[low[joined]] = near[high[joined]] = True
    unknowns = system.unknown.reshape(system.rest.shape)[near]
    place: Index = np.unique(unknowns[unknowns >= 0])
    return place if len(place) < LARGEST * system.free else None
