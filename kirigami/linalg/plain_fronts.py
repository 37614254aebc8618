"""Elimination of fronts, and solutions with what it leaves, by SciPy's LAPACK and BLAS: front by front in Python.

Blocks are kept as C-ordered arrays of which entry [column, row] with row >= column counts: the lower triangle of the
Fortran order that LAPACK wants. The other triangle holds nothing of use, and the factor keeps pivot blocks without it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from kirigami.linalg import released
from kirigami.linalg.checked import SingularMatrixError
from kirigami.linalg.dissection import Index
from kirigami.linalg.front_plan import Eliminated, FrontPlan
from kirigami.primitives.kernel import Array

HALVED = 300  # rows on the border of a front from which on two threads may share it
AMPLIFIED = 1e4  # displacements of a front per displacement of its border that are no lever any more


class PlainElimination:
    """One elimination; what some fronts leave over may come from elsewhere."""

    def __init__(self, plan: FrontPlan, made: Eliminated) -> None:
        self.plan, self.made = plan, made
        self._buffers = _Buffers()
        self._left_over: dict[int, tuple[Array, Array]] = {}

    def leave_over(self, front: int, packed: Array) -> None:
        """Take what a front left over, packed column by column (q (q + 1) / 2,)."""
        buffer, rest = self._buffers.take(int(self.plan.rows[front]))
        released.unpack(packed, rest)
        self._left_over[front] = buffer, rest

    def eliminate(self, fronts: Index, each: Callable[..., Any] = map) -> None:
        """Eliminate some fronts, children before parents; halves of large ones are left to `each`, a map."""
        from scipy.linalg.blas import dsyrk, dtrsm
        from scipy.linalg.lapack import dpotrf

        plan, store = self.plan, self.made.store
        squares = np.zeros((2, int(plan.pivots[fronts].max(initial=0)) ** 2))
        with np.errstate(all="ignore"):
            for f in fronts.tolist():
                p, q = int(plan.pivots[f]), int(plan.rows[f])
                packed = store[plan.offsets[2 * f] : plan.offsets[2 * f + 1]]
                pivot, original = squares[:, : p * p].reshape(2, p, p)
                released.unpack(packed, pivot)
                outer = store[plan.offsets[2 * f + 1] : plan.offsets[2 * f + 2]].reshape(p, q)
                buffer, rest = self._buffers.take(q)
                children = plan.children_of(f)
                if children:
                    rest.fill(0.0)
                blocks = pivot, outer, rest
                for child in children:
                    spent, update = self._left_over.pop(child)
                    for which, to, source in plan.transfer(child):
                        block = blocks[which][to]  # a view; adding to blocks[which][to] itself would copy it once more
                        block += update[source]
                    self._buffers.give(spent)
                original[...] = pivot
                kept = 1.0 if children else 0.0  # BLAS does not read what it is to multiply by zero
                lower, info = dpotrf(pivot.T, lower=1, overwrite_a=1, clean=0)
                if info != 0:
                    pivot[...] = original
                    lower = self._eliminate_indefinite(f, pivot, outer, rest, kept)
                elif q >= HALVED:
                    released.eliminate(pivot, outer, kept, rest, each)
                elif q:
                    dtrsm(1.0, lower, outer.T, side=1, lower=1, trans_a=1, overwrite_b=1)
                    dsyrk(-1.0, outer.T, beta=kept, c=rest.T, lower=1, overwrite_c=1)
                released.pack(lower.T, packed)
                self._left_over[f] = buffer, rest

    def _eliminate_indefinite(self, f: int, pivot: Array, outer: Array, rest: Array, kept: float) -> Array:
        """Factor a block that is not positive definite (Bunch and Kaufman); `outer` becomes F11^-1 F21'."""
        from scipy.linalg.lapack import dsytrf, dsytrs

        lower, exchanges, info = dsytrf(pivot.T, lower=1, lwork=64 * len(pivot), overwrite_a=1)
        if info != 0 or not np.isfinite(lower.diagonal()).all():
            raise SingularMatrixError("a front of the stiffness matrix is singular")
        # Blocks of one have the sign of their entry; blocks of two are chosen only where they are indefinite.
        single = exchanges > 0
        negative = int(np.count_nonzero(lower.diagonal()[single] < 0)) + int(np.count_nonzero(~single)) // 2
        self.made.negative[f] = negative
        start = int(self.plan.starts[f])
        self.made.exchanges[start : start + len(pivot)] = exchanges
        if rest.size:
            solved = dsytrs(lower, exchanges, outer, lower=1)[0]
            self.made.doubtful[f] = not np.abs(solved).max() < AMPLIFIED
            released.take_off_product(solved, outer, kept, rest)
            outer[...] = solved
        return np.asarray(lower)


def solve(plan: FrontPlan, made: Eliminated, rhs: Array) -> Array:
    """Solution for one right-hand side (n,), or for some (n, k)."""
    from scipy.linalg.lapack import dsytrs

    triangular = _triangular if rhs.ndim == 1 else _triangular_of_some
    starts, first, offsets = plan.starts.tolist(), plan.first.tolist(), plan.offsets.tolist()
    square = np.zeros(int(plan.pivots.max()) ** 2)

    def factor(f: int) -> tuple[Array, Array, Any]:
        """The factor (p, p) of F11, in Fortran's order, the border block, and what was exchanged, if anything."""
        start, end, p = starts[f], starts[f + 1], starts[f + 1] - starts[f]
        pivot = square[: p * p].reshape(p, p)
        released.unpack(made.store[offsets[2 * f] : offsets[2 * f + 1]], pivot)
        outer = made.store[offsets[2 * f + 1] : offsets[2 * f + 2]].reshape(p, -1)
        return pivot.T, outer, made.exchanges[start:end] if made.exchanges[start] else None

    x = rhs[plan.fronts.order]
    for f in range(len(plan.pivots)):
        own, border = x[starts[f] : starts[f + 1]], plan.border[first[f] : first[f + 1]]
        lower, outer, exchanges = factor(f)
        if exchanges is None:
            triangular(lower, own, False)
        if len(border):
            x[border] -= outer.T @ own
    for f in reversed(range(len(plan.pivots))):
        own, border = x[starts[f] : starts[f + 1]], plan.border[first[f] : first[f + 1]]
        lower, outer, exchanges = factor(f)
        if exchanges is not None:
            own[...] = dsytrs(lower, exchanges, own, lower=1)[0].reshape(own.shape)
        if len(border):
            own -= outer @ x[border]
        if exchanges is None:
            triangular(lower, own, True)
    solution = np.empty_like(x)
    solution[plan.fronts.order] = x
    return solution


def _triangular(lower: Array, x: Array, turned: bool) -> None:
    """Solve with a lower triangular matrix, or the same turned over, in the place of x (n,)."""
    from scipy.linalg.blas import dtrsv

    dtrsv(lower, x, lower=1, trans=int(turned), overwrite_x=1)


def _triangular_of_some(lower: Array, x: Array, turned: bool) -> None:
    """The same in the place of x (n, k), rows side by side in memory."""
    from scipy.linalg.blas import dtrsm

    dtrsm(1.0, lower, x.T, side=1, lower=1, trans_a=int(not turned), overwrite_b=1)


class _Buffers:
    """Square blocks that are used over and over, because fresh memory costs as much as filling it."""

    def __init__(self) -> None:
        self._free: dict[int, list[Array]] = {}

    def take(self, n: int) -> tuple[Array, Array]:
        """A buffer, and an (n, n) view of it with any finite content."""
        length = 1 << max(n * n - 1, 1).bit_length()
        waiting = self._free.get(length)
        buffer = waiting.pop() if waiting else np.zeros(length)
        return buffer, buffer[: n * n].reshape(n, n)

    def give(self, buffer: Array) -> None:
        self._free.setdefault(len(buffer), []).append(buffer)
