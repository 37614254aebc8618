"""Elimination of fronts and solutions, for Numba to compile; only :mod:`kirigami.linalg.compiled_fronts` imports this
file.

The routines of LAPACK and BLAS are called by address, and so are all their arguments. Blocks lie as in
:mod:`kirigami.linalg.plain_fronts`, what fronts leave over without the other triangle on a stack: fronts are numbered
so that the children of each are the last ones done when its turn comes.

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
def spread(taken, places, data, store):  # type: ignore[no-untyped-def]
    """Put entries of a matrix at their places."""
    for k in range(len(taken)):
        store[places[k]] = data[taken[k]]


@compiled
def at(values, k):  # type: ignore[no-untyped-def]
    """Address of entry k."""
    return values[k:].ctypes.data


@compiled
def eliminate(  # type: ignore[no-untyped-def]
    fronts, starts, first, offsets, first_child, children, seats, store, exchanges, negative, doubtful, stack, room,
    halved, amplified, letters, reals, numbers, potrf, sytrf, sytrs, trsm, syrk, gemm,
):  # fmt: skip
    """Eliminate whole subtrees of fronts; -1, or the front that is singular.

    What their roots leave over stays on the stack; ``room`` is for the blocks of one front. Fronts with `halved` rows
    on the border are taken in the halves that :func:`kirigami.linalg.released.eliminate` takes, by the same calls.
    ``letters`` "LRTN", ``reals`` 1 and -1 and room for six ``numbers`` are what routines read by address: arrays made
    here would be gone as soon as nothing else reads them.
    """
    lower, right, turned, plain = at(letters, 0), at(letters, 1), at(letters, 2), at(letters, 3)
    at_p, at_q, at_half, at_other = at(numbers, 0), at(numbers, 1), at(numbers, 2), at(numbers, 3)
    at_info, at_work = at(numbers, 4), at(numbers, 5)
    one, minus = at(reals, 0), at(reals, 1)
    top = 0
    for f in fronts:
        p, q = starts[f + 1] - starts[f], first[f + 1] - first[f]
        numbers[0], numbers[1], numbers[2], numbers[3] = p, q, q // 2, q - q // 2
        pivot, original = room[: p * p], room[p * p : 2 * p * p]
        rest, solved = room[2 * p * p : 2 * p * p + q * q], room[2 * p * p + q * q : 2 * p * p + q * q + p * q]
        work = room[2 * p * p + q * q + p * q :]
        inner, outer = offsets[2 * f], offsets[2 * f + 1]
        entry = inner
        for c in range(p):
            for r in range(c, p):
                pivot[c * p + r] = store[entry]
                entry += 1
        for c in range(q):
            rest[c * q + c : (c + 1) * q] = 0.0
        for k in range(first_child[f], first_child[f + 1]):
            rows = first[children[k] + 1] - first[children[k]]
            top -= rows * (rows + 1) // 2
        entry = top
        for k in range(first_child[f], first_child[f + 1]):
            seat = seats[first[children[k]] : first[children[k] + 1]]
            n = len(seat)
            pivots = 0
            while pivots < n and seat[pivots] < p:
                pivots += 1
            for j in range(pivots):
                left = stack[entry : entry + n - j]
                entry += n - j
                column = seat[j] * p
                for i in range(j, pivots):
                    pivot[column + seat[i]] += left[i - j]
                column = outer + seat[j] * q - p
                for i in range(pivots, n):
                    store[column + seat[i]] += left[i - j]
            for j in range(pivots, n):
                left = stack[entry : entry + n - j]
                entry += n - j
                column = (seat[j] - p) * q - p
                for i in range(j, n):
                    rest[column + seat[i]] += left[i - j]
        original[:] = pivot
        at_pivot, at_outer, at_rest, at_solved = at(pivot, 0), at(store, outer), at(rest, 0), at(solved, 0)
        potrf(lower, at_p, at_pivot, at_p, at_info)
        if numbers[4] == 0:
            if q >= halved:
                half = q // 2
                at_two, at_square = at(store, outer + half), at(rest, half)
                trsm(right, lower, turned, plain, at_half, at_p, one, at_pivot, at_p, at_outer, at_q)
                trsm(right, lower, turned, plain, at_other, at_p, one, at_pivot, at_p, at_two, at_q)
                gemm(
                    plain, turned, at_other, at_half, at_p, minus, at_two, at_q, at_outer, at_q, one,
                    at_square, at_q,
                )  # fmt: skip
                syrk(lower, plain, at_half, at_p, minus, at_outer, at_q, one, at_rest, at_q)
                syrk(
                    lower, plain, at_other, at_p, minus, at_two, at_q, one, at(rest, half * (q + 1)), at_q
                )  # fmt: skip
            elif q:
                trsm(right, lower, turned, plain, at_q, at_p, one, at_pivot, at_p, at_outer, at_q)
                syrk(lower, plain, at_q, at_p, minus, at_outer, at_q, one, at_rest, at_q)
        else:
            pivot[:] = original
            numbers[5] = 64 * p
            exchanged = exchanges[starts[f] : starts[f + 1]]
            at_exchanged = at(exchanged, 0)
            sytrf(lower, at_p, at_pivot, at_p, at_exchanged, at(work, 0), at_work, at_info)
            if numbers[4] != 0:
                return f
            paired = 0
            for c in range(p):
                if not np.isfinite(pivot[c * p + c]):
                    return f
                if exchanged[c] <= 0:
                    paired += 1
                elif pivot[c * p + c] < 0:
                    negative[f] += 1
            negative[f] += paired // 2
            if q:
                for c in range(p):
                    for r in range(q):
                        solved[r * p + c] = store[outer + c * q + r]
                sytrs(
                    lower, at_p, at_q, at_pivot, at_p, at_exchanged, at_solved, at_p, at_info
                )  # fmt: skip
                for value in solved:
                    if not abs(value) < amplified:  # or no number at all
                        doubtful[f] = True
                gemm(
                    plain, plain, at_q, at_q, at_p, minus, at_outer, at_q, at_solved, at_p, one, at_rest, at_q
                )  # fmt: skip
                for c in range(p):
                    for r in range(q):
                        store[outer + c * q + r] = solved[r * p + c]
        entry = inner
        for c in range(p):
            for r in range(c, p):
                store[entry] = pivot[c * p + r]
                entry += 1
        for c in range(q):
            for r in range(c, q):
                stack[top] = rest[c * q + r]
                top += 1
    return -1


@compiled
def forward(fronts, starts, first, border, offsets, store, exchanges, x):  # type: ignore[no-untyped-def]
    """Solve L y = x in place for some fronts, children before parents; front f borders on ``border[first[f] :]``.

    Where pivots are exchanged, L has F21 F11^-1 below ones.
    """
    longest = 0
    for f in fronts:
        longest = max(longest, first[f + 1] - first[f])
    update = np.empty((len(x), longest))
    for f in fronts:
        start, p, q = starts[f], starts[f + 1] - starts[f], first[f + 1] - first[f]
        inner, outer = offsets[2 * f], offsets[2 * f + 1]
        positive = exchanges[start] == 0
        update[:, :q] = 0.0
        for c in range(p):
            column = store[inner : inner + p - c]
            inner += p - c
            below = store[outer + c * q : outer + (c + 1) * q]
            for k in range(len(x)):
                own, rest = x[k, start + c : start + p], update[k, :q]
                value = own[0]
                if positive:
                    value /= column[0]
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
def backward(fronts, starts, first, border, offsets, store, exchanges, x, letters, numbers, sptrs):  # type: ignore[no-untyped-def]
    """Solve L' y = x in place for some fronts, given children before parents and taken the other way round.

    Where pivots are exchanged, D L' y = x with D of F11.
    """
    numbers[1], numbers[2] = len(x), x.shape[1]
    at_p, at_k, at_n, at_info = at(numbers, 0), at(numbers, 1), at(numbers, 2), at(numbers, 3)
    longest = 0
    for f in fronts:
        longest = max(longest, first[f + 1] - first[f])
    above = np.empty((len(x), longest))
    for f in fronts[::-1]:
        start, p, q = starts[f], starts[f + 1] - starts[f], first[f + 1] - first[f]
        inner, outer = offsets[2 * f] + p * (p + 1) // 2, offsets[2 * f + 1]
        positive = exchanges[start] == 0
        if not positive:
            numbers[0] = p
            sptrs(
                at(letters, 0), at_p, at_k, at(store, offsets[2 * f]), at(exchanges, start), at(x[0], start), at_n,
                at_info,
            )  # fmt: skip
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
                if positive:
                    for r in range(1, p - c):
                        total += column[r] * own[r]
                    own[0] = (own[0] - total) / column[0]
                else:
                    own[0] -= total
