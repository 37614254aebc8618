"""Solutions with a factor of positive fronts, for Numba to compile; only :mod:`kirigami.linalg.solve_plan` imports
this file.

A solution reads the whole factor twice and does little with it, so that all that counts is to read it once from front
to end and back, side by side in memory: column by column of L, which is how the blocks of a front lie there. Several
right-hand sides (k, n) share each column while it is at hand.
"""

from __future__ import annotations

import numpy as np

from kirigami.primitives.compiling import compiler

# sums may be taken in any order, so that the processor's vector units work on them; the order is always the same
compiled = compiler(nogil=True, fastmath={"reassoc", "contract"})


@compiled
def forward(fronts, starts, first, border, offsets, store, x):  # type: ignore[no-untyped-def]
    """Solve L y = x in place for some fronts, children before parents; front f borders on ``border[first[f] :]``."""
    longest = 0
    for f in fronts:
        longest = max(longest, first[f + 1] - first[f])
    update = np.empty((len(x), longest))
    for f in fronts:
        start, p, q = starts[f], starts[f + 1] - starts[f], first[f + 1] - first[f]
        inner, outer = offsets[2 * f], offsets[2 * f + 1]
        update[:, :q] = 0.0
        for c in range(p):
            column = store[inner : inner + p - c]
            inner += p - c
            below = store[outer + c * q : outer + (c + 1) * q]
            for k in range(len(x)):
                own, rest = x[k, start + c : start + p], update[k, :q]
                value = own[0] / column[0]
                own[0] = value
                for r in range(1, p - c):
                    own[r] -= column[r] * value
                for j in range(q):
                    rest[j] += below[j] * value
        rows = border[first[f] : first[f + 1]]
        for k in range(len(x)):
            for j in range(q):
                x[k, rows[j]] -= update[k, j]


@compiled
def backward(fronts, starts, first, border, offsets, store, x):  # type: ignore[no-untyped-def]
    """Solve L' y = x in place for some fronts, given children before parents and taken the other way round."""
    longest = 0
    for f in fronts:
        longest = max(longest, first[f + 1] - first[f])
    above = np.empty((len(x), longest))
    for f in fronts[::-1]:
        start, p, q = starts[f], starts[f + 1] - starts[f], first[f + 1] - first[f]
        inner, outer = offsets[2 * f] + p * (p + 1) // 2, offsets[2 * f + 1]
        rows = border[first[f] : first[f + 1]]
        for k in range(len(x)):
            for j in range(q):
                above[k, j] = x[k, rows[j]]
        for c in range(p - 1, -1, -1):
            inner -= p - c
            column = store[inner : inner + p - c]
            below = store[outer + c * q : outer + (c + 1) * q]
            for k in range(len(x)):
                own, known = x[k, start + c : start + p], above[k, :q]
                total = 0.0
                for j in range(q):
                    total += below[j] * known[j]
                for r in range(1, p - c):
                    total += column[r] * own[r]
                own[0] = (own[0] - total) / column[0]
