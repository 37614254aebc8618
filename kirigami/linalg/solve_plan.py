"""Solutions with positive factors by compiled loops, on both cores where the factor is large.

The fronts are taken in two halves of subtrees and a rest, however many threads there are, so that the sums, and with
them the solutions, are the same bit by bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from kirigami.linalg.dissection import Fronts, Index
from kirigami.primitives.kernel import Array

COMPILED = 200_000  # numbers in a factor from which on compiled loops pay for loading Numba


class SolvePlan:
    """What solutions with all factors of one pattern share.

    Parameters
    ----------
    fronts : Fronts
        The dissection.
    offsets : ndarray of int
        Where the pivot block and the border block of each front begin in a factor.
    halves, rest : list of lists of int, list of int
        Fronts whose subtrees are apart, and those left for afterwards.
    """

    def __init__(self, fronts: Fronts, offsets: Index, halves: list[list[int]], rest: list[int]) -> None:
        border = [np.zeros(0, np.int64), *fronts.borders]
        first = np.cumsum([len(rows) for rows in border])
        self._order = fronts.order
        self._fronts = fronts.starts, first, np.concatenate(border), offsets
        self._halves = [np.array(part, dtype=np.int64) for part in halves]
        self._rest = np.array(rest, dtype=np.int64)
        owner = np.full(len(first) - 1, len(halves))
        for number, part in enumerate(self._halves):
            owner[part] = number
        of_row = np.repeat(owner, np.diff(fronts.starts))
        self._rows = [np.flatnonzero(of_row == number) for number in range(len(halves) + 1)]

    def solve(self, store: Array, rhs: Array, threads: int) -> Array:
        """Solution of one right-hand side (n,), or of some (n, k), with the factor in `store`."""
        from kirigami.linalg import front_loops

        x = np.ascontiguousarray(rhs[self._order].reshape(len(rhs), -1).T)  # one after the other
        if not self._halves:
            front_loops.forward(self._rest, *self._fronts, store, x)
            front_loops.backward(self._rest, *self._fronts, store, x)
        elif threads > 1:
            with ThreadPoolExecutor(len(self._halves)) as pool:
                self._solve_halves(store, x, pool.map)
        else:
            self._solve_halves(store, x, map)
        solution = np.empty(rhs.shape)
        solution[self._order] = x.T.reshape(rhs.shape)
        return solution

    def _solve_halves(self, store: Array, x: Array, each: Callable[..., Iterable[Any]]) -> None:
        from kirigami.linalg import front_loops

        def ahead(part: Index) -> Array:
            own: Array = x.copy()  # what the halves do to rows of the rest is added up in their order
            front_loops.forward(part, *self._fronts, store, own)
            return own

        def back(part: Index) -> None:
            front_loops.backward(part, *self._fronts, store, x)

        shared = self._rows[-1]
        before = x[:, shared]
        for rows, own in zip(self._rows, list(each(ahead, self._halves))):
            x[:, rows] = own[:, rows]
            x[:, shared] += own[:, shared] - before
        front_loops.forward(self._rest, *self._fronts, store, x)
        front_loops.backward(self._rest, *self._fronts, store, x)
        list(each(back, self._halves))
