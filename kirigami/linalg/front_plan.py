"""Where the entries of a matrix, and what fronts leave over, belong: the same for all matrices of one pattern."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kirigami.linalg.checked import COLUMNS
from kirigami.linalg.dissection import Fronts, Index
from kirigami.linalg.subtrees import shares
from kirigami.primitives.kernel import Array

ENTRIES = 1 << 20  # of a matrix that are moved together, so that what this takes is little

Slices = tuple[slice, slice]
Transfer = list[tuple[int, Slices, Slices]]  # which block of the parent, where there, from where in the child's block


class FrontPlan:
    """Where everything goes.

    All pivot blocks F11, packed column by column, and border blocks F21 lie one after the other in one array, the
    factor's: those of front f begin at ``offsets[2 * f]`` and ``offsets[2 * f + 1]``. Front f borders on the rows
    ``border[first[f] : first[f + 1]]``, whose seats in its parent (its pivots first, then its border) are those of
    ``seats``; its children are ``children[first_child[f] : first_child[f + 1]]``.
    """

    def __init__(self, matrix: Any, fronts: Fronts) -> None:
        self.fronts, self.starts = fronts, fronts.starts
        count = len(fronts.parent)
        self.pivots = np.diff(fronts.starts)
        self.rows = np.array([len(border) for border in fronts.borders], dtype=np.int64)
        self.first = np.append(0, np.cumsum(self.rows))
        self.border = np.concatenate([np.zeros(0, np.int64), *fronts.borders])
        sizes = np.stack([self.pivots * (self.pivots + 1) // 2, self.pivots * self.rows], axis=1)
        self.offsets = np.append(0, np.cumsum(sizes))
        self.size = int(self.offsets[-1])
        owned = np.flatnonzero(fronts.parent >= 0)
        self.left_over = self.rows * (self.rows + 1) // 2  # numbers that count
        self.children = owned[np.argsort(fronts.parent[owned], kind="stable")]
        self.parents = fronts.parent[self.children]
        self.first_child = np.append(0, np.cumsum(np.bincount(self.parents, minlength=count)))
        codes = np.repeat(np.arange(count), self.rows) * len(fronts.order) + self.border  # ascending
        self.seats = self._seats(codes)
        self.taken, self.places = self._entries(matrix, codes)  # as small as numbers go: they are as many as entries
        self._shares: dict[int, tuple[list[Index], Index]] = {}
        self._transfers: dict[int, Transfer] = {}  # loops do without them

    def shares(self, threads: int) -> tuple[list[Index], Index]:
        """Fronts for each thread, and those left for afterwards."""
        if threads not in self._shares:
            p, q = self.pivots.astype(float), self.rows.astype(float)
            beside, rest = shares(self.fronts.parent, p**3 / 3 + p**2 * q + p * q**2, threads)
            self._shares[threads] = [np.array(part, dtype=np.int64) for part in beside], np.array(rest, dtype=np.int64)
        return self._shares[threads]

    def children_of(self, front: int) -> list[int]:
        found: list[int] = self.children[self.first_child[front] : self.first_child[front + 1]].tolist()
        return found

    def transfer(self, child: int) -> Transfer:
        """How the left-over of a front adds to the blocks of its parent, stretch by stretch."""
        if child not in self._transfers:
            self._transfers[child] = self._find_transfer(child)
        return self._transfers[child]

    def spread(self, data: Array, store: Array) -> None:
        """Put the entries of a matrix at their places in a factor's array."""
        for first in range(0, len(self.taken), ENTRIES):  # NumPy widens numbers that it finds entries by
            part = slice(first, first + ENTRIES)
            store[self.places[part]] = data[self.taken[part]]

    def _entries(self, matrix: Any, codes: Index) -> tuple[Index, Index]:
        """Which entries of the matrix are taken (the lower triangle in the new order), and their places."""
        order = self.fronts.order
        n = len(order)
        number = np.empty(n, dtype=np.int64)
        number[order] = np.arange(n)
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
        """Where entries of the lower triangle stand in a factor."""
        front = np.searchsorted(self.starts, column, side="right") - 1
        start, pivots, border = self.starts[front], self.pivots[front], self.rows[front]
        inner = row < start + pivots
        along = column - start
        where = self.offsets[2 * front] + along * pivots - along * (along + 1) // 2 + row - start
        outer = np.flatnonzero(~inner)
        rank = self._rank(front[outer], row[outer], codes)
        where[outer] = self.offsets[2 * front[outer] + 1] + along[outer] * border[outer] + rank
        return np.asarray(where)

    def _rank(self, front: Index, row: Index, codes: Index) -> Index:
        """Which row of the border of a front a row is; `codes` are n * front + row of all borders."""
        wanted = front * len(self.fronts.order) + row
        rank = np.searchsorted(codes, wanted)
        assert np.array_equal(codes[np.minimum(rank, len(codes) - 1)], wanted) if len(front) else True
        return np.asarray(rank - self.first[front])

    def _seats(self, codes: Index) -> NDArray[np.int32]:
        """Seats of the rows on the border of each front in its parent."""
        above = np.repeat(self.fronts.parent, self.rows)
        seats = self.border - self.starts[above]
        outer = np.flatnonzero(seats >= self.pivots[above])
        seats[outer] = self.pivots[above[outer]] + self._rank(above[outer], self.border[outer], codes)
        return seats.astype(np.int32)

    def _find_transfer(self, child: int) -> Transfer:
        seats = self.seats[self.first[child] : self.first[child + 1]].astype(np.int64)
        if not len(seats):
            return []
        pivots = int(self.pivots[self.fronts.parent[child]])
        outer = seats >= pivots
        breaks = np.flatnonzero((np.diff(seats) != 1) | (outer[1:] & ~outer[:-1])) + 1
        stretches = [
            (slice(a, b), slice(seat := int(seats[a]) - pivots * bool(outer[a]), seat + b - a), bool(outer[a]))
            for a, b in pairwise([0, *breaks.tolist(), len(seats)])
        ]
        return [
            (column_outer + row_outer, (column_to, row_to), (column_from, row_from))
            for k, (column_from, column_to, column_outer) in enumerate(stretches)
            for row_from, row_to, row_outer in stretches[k:]
        ]


class Eliminated(NamedTuple):
    """What an elimination leaves.

    A front is the L of Cholesky and L^-1 F21' in `store` where ``exchanges`` (n,) is 0 at its first unknown; else what
    sytrf leaves and F11^-1 F21', and its part of ``exchanges`` is what sytrf exchanged. ``negative`` and ``doubtful``
    tell for each front how many of its eigenvalues are negative, and whether displacements grow so much in it that a
    second look at these signs is due.
    """

    store: Array
    exchanges: NDArray[np.int32]
    negative: NDArray[np.int32]
    doubtful: NDArray[np.bool_]

    @classmethod
    def nothing(cls, plan: FrontPlan) -> Eliminated:
        """Room for all of it."""
        n, count = len(plan.fronts.order), len(plan.pivots)
        negative, doubtful = np.zeros(count, dtype=np.int32), np.zeros(count, dtype=bool)
        return cls(np.zeros(plan.size), np.zeros(n, dtype=np.int32), negative, doubtful)
