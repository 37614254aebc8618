"""Multifrontal factorisation on dense blocks: Cholesky where a block is positive definite, L D L' where it is not.

The matrix is taken apart by nested dissection into fronts (see :mod:`kirigami.linalg.dissection`). Each front gathers
its entries of the matrix and what its children left over, eliminates its own unknowns F11,

    [F11 F21']      [F22 - F21 F11^-1 F21'] goes to the parent,
    [F21 F22 ]

and nearly all work is done by dense LAPACK and BLAS (Duff and Reid, ACM Trans. Math. Softw. 9 (1983)). The negative
eigenvalues of the matrix are those of the blocks F11 together (Haynsworth, Linear Algebra Appl. 1 (1968)). Exchange of
rows is possible inside a front only, so solutions are checked.

Blocks are kept as C-ordered arrays of which entry [column, row] with row >= column counts: the lower triangle of the
Fortran order that LAPACK wants. The other triangle holds nothing of use, and the factor keeps pivot blocks without it.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kirigami.linalg import released
from kirigami.linalg.checked import (
    PIVOT_ABOVE,
    CheckedFactor,
    Factor,
    NothingToSolve,
    PatternCache,
    SingularMatrixError,
)
from kirigami.linalg.dissection import Fronts, Index, dissect
from kirigami.linalg.solve_plan import COMPILED, SolvePlan
from kirigami.linalg.subtrees import shares
from kirigami.linalg.superlu import SuperLUFactor
from kirigami.linalg.threads import LARGE, one_thread, threads_for
from kirigami.primitives.compiling import compiles
from kirigami.primitives.kernel import Array

COLUMNS, ENTRIES = 20_000, 1 << 20  # of a matrix that are looked at together, so that what this takes is little
HALVED = 300  # rows on the border of a front from which on two threads may share it
AMPLIFIED = 1e4  # displacements of a front per displacement of its border that are no lever any more

Slices = tuple[slice, slice]
Transfer = list[tuple[int, Slices, Slices]]  # which block of the parent, where there, from where in the child's block


class Multifrontal:
    """The dissection, and where every entry goes, are found once for matrices that share their pattern."""

    def __init__(self) -> None:
        self._pattern = PatternCache()
        self._plan: FrontPlan | None = None

    def factorize(self, matrix: Any) -> Factor:
        """Factor a symmetric CSC matrix; raises SingularMatrixError where that is impossible also with pivoting."""
        if matrix.shape[0] == 0:
            return NothingToSolve(matrix)
        if not self._pattern.knows(matrix) or self._plan is None:
            if not _is_mirrored(matrix):
                return self.factorize(_mirrored(matrix))
            self._plan = FrontPlan(matrix, dissect(matrix))
        try:
            return MultifrontalFactor(matrix, self._plan)
        except SingularMatrixError:
            return SuperLUFactor(matrix)  # may exchange rows between fronts


def _is_mirrored(matrix: Any) -> bool:
    """Whether an entry stands on one side of the diagonal where one stands on the other: by sums of random numbers,
    which are the same of each row and column, and different but by a chance of 1e-9 or less where they need not be."""
    n = matrix.shape[0]
    label = np.random.default_rng(0).integers(-(2**62), 2**62, n)
    along, down = np.zeros((2, n), dtype=np.int64)
    for first in range(0, n, COLUMNS):
        last = min(first + COLUMNS, n)
        row = matrix.indices[int(matrix.indptr[first]) : int(matrix.indptr[last])]
        column = np.repeat(np.arange(first, last), np.diff(matrix.indptr[first : last + 1]))
        np.add.at(along, row, label[column])
        np.add.at(down, column, label[row])
    return bool((along == down).all())


def _mirrored(matrix: Any) -> Any:
    """The matrix with zeros where an entry stands on one side alone: sums drop what happens to cancel, and what cancels
    to zero on one side may leave a rounding error on the other."""
    from scipy.sparse import coo_matrix

    entries = matrix.tocoo()
    data = np.concatenate([entries.data, np.zeros(entries.nnz)])
    rows, columns = np.concatenate([entries.row, entries.col]), np.concatenate([entries.col, entries.row])
    whole = coo_matrix((data, (rows, columns)), shape=matrix.shape).tocsc()
    whole.sort_indices()
    return whole


class FrontPlan:
    """Where the entries of a matrix, and the left-overs of the fronts, belong.

    All pivot blocks F11, packed column by column, and border blocks F21 lie one after the other in one array, the
    factor's.
    """

    def __init__(self, matrix: Any, fronts: Fronts) -> None:
        self.fronts = fronts
        count = len(fronts.parent)
        self.pivots = np.diff(fronts.starts)
        self.border = np.array([len(border) for border in fronts.borders], dtype=np.int64)
        sizes = np.stack([self.pivots * (self.pivots + 1) // 2, self.pivots * self.border], axis=1)
        self.offsets = np.append(0, np.cumsum(sizes))
        self.size = int(self.offsets[-1])
        self.taken, self.places = self._entries(matrix)  # as small as numbers go: they are as many as entries
        self.children: list[list[int]] = [[] for _ in range(count)]
        for child, parent in enumerate(fronts.parent.tolist()):
            if parent >= 0:
                self.children[parent].append(child)
        self.transfers = [self._transfer(f) for f in range(count)]
        self._shares: dict[int, tuple[list[list[int]], list[int]]] = {}

    def shares(self, threads: int) -> tuple[list[list[int]], list[int]]:
        """Fronts for each thread, and those left for afterwards."""
        if threads not in self._shares:
            p, q = self.pivots.astype(float), self.border.astype(float)
            self._shares[threads] = shares(self.fronts.parent, p**3 / 3 + p**2 * q + p * q**2, threads)
        return self._shares[threads]

    @cached_property
    def solve_plan(self) -> SolvePlan | None:
        """How to solve by compiled loops where all fronts are positive, if that pays."""
        if self.size < COMPILED or not compiles():
            return None
        return SolvePlan(self.fronts, self.offsets, *self.shares(2 if self.size >= LARGE else 1))

    def spread(self, data: Array) -> Array:
        """A factor's array with the entries of a matrix at their places, and zeros elsewhere."""
        store = np.zeros(self.size)
        for first in range(0, len(self.taken), ENTRIES):  # NumPy widens numbers that it finds entries by
            part = slice(first, first + ENTRIES)
            store[self.places[part]] = data[self.taken[part]]
        return store

    def _entries(self, matrix: Any) -> tuple[Index, Index]:
        """Which entries of the matrix are taken (the lower triangle in the new order), and their places."""
        fronts = self.fronts
        n = len(fronts.order)
        number = np.empty(n, dtype=np.int64)
        number[fronts.order] = np.arange(n)
        listed = np.concatenate(fronts.borders) if fronts.borders else np.empty(0, dtype=np.int64)
        codes = np.repeat(np.arange(len(fronts.parent)), self.border) * n + listed  # of all (front, border row), sorted
        count = (matrix.nnz + n) // 2  # of the lower triangle, where all of the diagonal is there
        taken = np.empty(count, dtype=np.int32 if matrix.nnz < 2**31 else np.int64)
        places = np.empty(count, dtype=np.int32 if self.size < 2**31 else np.int64)
        filled = 0
        for first in range(0, n, COLUMNS):
            last = min(first + COLUMNS, n)
            begin, end = int(matrix.indptr[first]), int(matrix.indptr[last])
            row = number[matrix.indices[begin:end]]
            column = np.repeat(number[first:last], np.diff(matrix.indptr[first : last + 1]))
            lower = np.flatnonzero(row >= column)
            found = slice(filled, filled + len(lower))
            filled = found.stop
            taken[found] = begin + lower
            places[found] = self._places(row[lower], column[lower], codes)
        return taken[:filled], places[:filled]

    def _places(self, row: Index, column: Index, codes: Index) -> Index:
        """Where entries of the lower triangle stand in a factor; `codes` are n * front + row of all borders."""
        fronts = self.fronts
        front = np.searchsorted(fronts.starts, column, side="right") - 1
        start, pivots, border = fronts.starts[front], self.pivots[front], self.border[front]
        inner = row < start + pivots
        along = column - start
        where = self.offsets[2 * front] + along * pivots - along * (along + 1) // 2 + row - start
        outer = np.flatnonzero(~inner)
        wanted = front[outer] * len(fronts.order) + row[outer]
        rank = np.searchsorted(codes, wanted)
        assert np.array_equal(codes[np.minimum(rank, len(codes) - 1)], wanted) if len(outer) else True
        rank -= (np.cumsum(self.border) - self.border)[front[outer]]
        where[outer] = self.offsets[2 * front[outer] + 1] + along[outer] * border[outer] + rank
        return np.asarray(where)

    def _transfer(self, child: int) -> Transfer:
        """How the left-over of a front adds to the blocks of its parent, stretch by stretch."""
        fronts, parent = self.fronts, int(self.fronts.parent[child])
        border = fronts.borders[child]
        if parent < 0 or not len(border):
            return []
        start, end = fronts.starts[parent], fronts.starts[parent + 1]
        inner = int(np.searchsorted(border, end))
        place = np.concatenate([border[:inner] - start, np.searchsorted(fronts.borders[parent], border[inner:])])
        breaks = np.diff(place) != 1
        if 0 < inner < len(border):
            breaks[inner - 1] = True
        begins = np.append(0, np.flatnonzero(breaks) + 1).tolist()
        ends = [*begins[1:], len(border)]
        stretches = [
            (slice(a, b), slice(int(place[a]), int(place[a]) + b - a), a >= inner) for a, b in zip(begins, ends)
        ]
        return [
            (int(column_outer) + int(row_outer), (column_to, row_to), (column_from, row_from))
            for k, (column_from, column_to, column_outer) in enumerate(stretches)
            for row_from, row_to, row_outer in stretches[k:]
        ]


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


class _Elimination:
    """The fronts of one factorisation, which threads may eliminate side by side: each front's arithmetic is the same
    whoever does it, so that the factor is the same, bit by bit, for any number of threads."""

    def __init__(self, plan: FrontPlan, store: Array) -> None:
        self.plan, self.store = plan, store
        self.made: dict[int, _Front] = {}
        self.negative: dict[int, int] = {}  # eigenvalues of fronts that are not positive definite
        self.doubtful: list[int] = []
        self._left_over: dict[int, tuple[Array, Array]] = {}

    def eliminate_beside(self, numbers: list[int]) -> None:
        """The same in a thread beside others."""
        self.eliminate(numbers, beside=True)

    def eliminate(self, numbers: list[int], beside: bool = False, each: Callable[..., Any] = map) -> None:
        """Eliminate fronts, children before parents; `beside` others by routines that let them run. Halves of large
        ones are left to `each`, a map."""
        from scipy.linalg.blas import dsyrk, dtrsm
        from scipy.linalg.lapack import dpotrf

        plan, store = self.plan, self.store
        starts, offsets = plan.fronts.starts.tolist(), plan.offsets.tolist()
        buffers = _Buffers()
        squares = np.zeros((2, int(plan.pivots[np.array(numbers, dtype=np.int64)].max(initial=0)) ** 2))
        with np.errstate(all="ignore"):
            for f in numbers:
                border = plan.fronts.borders[f]
                p, q = starts[f + 1] - starts[f], len(border)
                packed = store[offsets[2 * f] : offsets[2 * f + 1]]
                pivot, original = squares[:, : p * p].reshape(2, p, p)
                released.unpack(packed, pivot)
                outer = store[offsets[2 * f + 1] : offsets[2 * f + 2]].reshape(p, q)
                buffer, rest = buffers.take(q)
                if plan.children[f]:
                    rest.fill(0.0)
                blocks = pivot, outer, rest
                for child in plan.children[f]:
                    spent, update = self._left_over.pop(child)
                    for which, to, source in plan.transfers[child]:
                        block = blocks[which][to]  # a view; adding to blocks[which][to] itself would copy it once more
                        block += update[source]
                    buffers.give(spent)
                original[...] = pivot
                kept = 1.0 if plan.children[f] else 0.0  # BLAS does not read what it is to multiply by zero
                if beside:
                    lower, info = pivot.T, released.cholesky(pivot)
                else:
                    lower, info = dpotrf(pivot.T, lower=1, overwrite_a=1, clean=0)
                if info == 0:
                    exchanges = None
                    if q >= HALVED:
                        released.eliminate(pivot, outer, kept, rest, each)
                    elif q and beside:
                        released.divide(pivot, outer)
                        released.take_off(outer, kept, rest)
                    elif q:
                        dtrsm(1.0, lower, outer.T, side=1, lower=1, trans_a=1, overwrite_b=1)
                        dsyrk(-1.0, outer.T, beta=kept, c=rest.T, lower=1, overwrite_c=1)
                else:
                    pivot[...] = original
                    lower, exchanges = self._eliminate_indefinite(f, pivot, outer, rest, kept)
                released.pack(lower.T, packed)
                self.made[f] = _Front(starts[f], starts[f + 1], border, packed, outer, exchanges)
                self._left_over[f] = buffer, rest

    def _eliminate_indefinite(
        self, f: int, pivot: Array, outer: Array, rest: Array, kept: float
    ) -> tuple[Array, NDArray[np.int32]]:
        """Factor a block that is not positive definite (Bunch and Kaufman); `outer` becomes F11^-1 F21'."""
        from scipy.linalg.lapack import dsytrf, dsytrs

        lower, exchanges, info = dsytrf(pivot.T, lower=1, lwork=64 * len(pivot), overwrite_a=1)
        if info != 0 or not np.isfinite(lower.diagonal()).all():
            raise SingularMatrixError("a front of the stiffness matrix is singular")
        # Blocks of one have the sign of their entry; blocks of two are chosen only where they are indefinite.
        single = exchanges > 0
        self.negative[f] = int(np.count_nonzero(lower.diagonal()[single] < 0)) + int(np.count_nonzero(~single)) // 2
        if rest.size:
            solved = dsytrs(lower, exchanges, outer, lower=1)[0]
            if not np.abs(solved).max() < AMPLIFIED:
                self.doubtful.append(f)
            rest *= kept
            rest -= solved.T @ outer
            outer[...] = solved
        return lower, exchanges


class MultifrontalFactor(CheckedFactor):
    """Factor of a matrix, front by front."""

    backend = "multifrontal"

    def __init__(self, matrix: Any, plan: FrontPlan) -> None:
        super().__init__(matrix)
        self._order = plan.fronts.order
        store = plan.spread(self.matrix.data)
        work = _Elimination(plan, store)
        with one_thread():
            side_by_side, rest = plan.shares(threads_for(plan.size))
            if side_by_side:
                with ThreadPoolExecutor(len(side_by_side)) as pool:
                    list(pool.map(work.eliminate_beside, side_by_side))
                    work.eliminate(rest, each=pool.map)
            else:
                work.eliminate(rest)
        self._fronts = [work.made[f] for f in range(len(work.made))]
        positive = not any(front.exchanges is not None for front in self._fronts)
        self._solve_plan = plan.solve_plan if positive else None
        self._store = store
        self._negative = sum(work.negative.values())
        self._doubtful = any(work.doubtful)  # whether some front amplifies so much that its signs want a second look

    @property
    def negative(self) -> int:
        if self._doubtful:
            self._doubtful = False
            probe = np.ones(len(self._order))
            with np.errstate(all="ignore"):
                error = float(np.linalg.norm(probe - self.matrix @ self._apply(probe)))
            if not error <= PIVOT_ABOVE * np.sqrt(len(probe)):
                self._negative = SuperLUFactor(self.matrix).negative
        return self._negative

    def _apply(self, rhs: Array) -> Array:
        from scipy.linalg.lapack import dsytrs

        if self._solve_plan is not None:
            return self._solve_plan.solve(self._store, rhs, threads_for(len(self._store)))
        triangular = _triangular if rhs.ndim == 1 else _triangular_of_some
        x = rhs[self._order]
        square = np.zeros(max(front.end - front.start for front in self._fronts) ** 2)
        for front in self._fronts:
            own = x[front.start : front.end]
            if front.exchanges is None:
                triangular(front.lower(square), own, False)
            if len(front.border):
                x[front.border] -= front.outer.T @ own
        for front in reversed(self._fronts):
            own = x[front.start : front.end]
            if front.exchanges is not None:
                own[...] = dsytrs(front.lower(square), front.exchanges, own, lower=1)[0].reshape(own.shape)
            if len(front.border):
                own -= front.outer @ x[front.border]
            if front.exchanges is None:
                triangular(front.lower(square), own, True)
        solution = np.empty_like(x)
        solution[self._order] = x
        return solution


def _triangular(lower: Array, x: Array, turned: bool) -> None:
    """Solve with a lower triangular matrix, or the same turned over, in the place of x (n,)."""
    from scipy.linalg.blas import dtrsv

    dtrsv(lower, x, lower=1, trans=int(turned), overwrite_x=1)


def _triangular_of_some(lower: Array, x: Array, turned: bool) -> None:
    """The same in the place of x (n, k), rows side by side in memory."""
    from scipy.linalg.blas import dtrsm

    dtrsm(1.0, lower, x.T, side=1, lower=1, trans_a=int(not turned), overwrite_b=1)


class _Front(NamedTuple):
    """One eliminated front: its pivots, its border, and the factor of F11.

    With `exchanges` None, ``packed`` is the L of Cholesky and ``outer`` is L^-1 F21'; else they are what sytrf leaves,
    and F11^-1 F21'.
    """

    start: int
    end: int
    border: Index
    packed: Array
    outer: Array
    exchanges: NDArray[np.int32] | None

    def lower(self, room: Array) -> Array:
        """The factor (p, p) of F11, in Fortran's order, in some room for it."""
        p = self.end - self.start
        square = room[: p * p].reshape(p, p)
        released.unpack(self.packed, square)
        return np.asarray(square.T)
