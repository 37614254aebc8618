"""Multifrontal factorisation on dense blocks: Cholesky where a block is positive definite, L D L' where it is not.

The matrix is taken apart by nested dissection into fronts (see :mod:`kirigami.linalg.dissection`). Each front gathers
its entries of the matrix and what its children left over, eliminates its own unknowns F11,

    [F11 F21']      [F22 - F21 F11^-1 F21'] goes to the parent,
    [F21 F22 ]

and nearly all work is done by dense LAPACK and BLAS (Duff and Reid, ACM Trans. Math. Softw. 9 (1983)). The negative
eigenvalues of the matrix are those of the blocks F11 together (Haynsworth, Linear Algebra Appl. 1 (1968)). Exchange of
rows is possible inside a front only, so solutions are checked.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.linalg.checked import (
    COLUMNS,
    PIVOT_ABOVE,
    CheckedFactor,
    Factor,
    NothingToSolve,
    PatternCache,
    SingularMatrixError,
)
from kirigami.linalg.compiled_fronts import CompiledFronts
from kirigami.linalg.dissection import dissect
from kirigami.linalg.front_plan import Eliminated, FrontPlan
from kirigami.linalg.plain_fronts import PlainElimination, solve
from kirigami.linalg.superlu import SuperLUFactor
from kirigami.linalg.threads import LARGE, one_thread, threads_for
from kirigami.primitives.compiling import compiles
from kirigami.primitives.kernel import Array

COMPILED = 2_000  # unknowns from which on compiled loops pay for loading Numba
LEAF, COMPILED_LEAF = 100, 50  # unknowns of a part that is not cut any more: small fronts are dear in Python


class Multifrontal:
    """The dissection, and where every entry goes, are found once for matrices that share their pattern."""

    def __init__(self) -> None:
        self._pattern = PatternCache()
        self._plan: FrontPlan | None = None
        self._loops: CompiledFronts | None = None

    def factorize(self, matrix: Any) -> Factor:
        """Factor a symmetric CSC matrix; raises SingularMatrixError where that is impossible also with pivoting."""
        if matrix.shape[0] == 0:
            return NothingToSolve(matrix)
        if not self._pattern.knows(matrix) or self._plan is None:
            if not _is_mirrored(matrix):
                return self.factorize(_mirrored(matrix))
            compiled = matrix.shape[0] >= COMPILED and compiles()
            self._plan = FrontPlan(matrix, dissect(matrix, COMPILED_LEAF if compiled else LEAF))
            self._loops = CompiledFronts(self._plan, halves=self._plan.size >= LARGE) if compiled else None
        try:
            return MultifrontalFactor(matrix, self._plan, self._loops)
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


class MultifrontalFactor(CheckedFactor):
    """Factor of a matrix, front by front."""

    backend = "multifrontal"

    def __init__(self, matrix: Any, plan: FrontPlan, loops: CompiledFronts | None) -> None:
        super().__init__(matrix)
        self._plan, self._loops = plan, loops
        self._made = Eliminated.nothing(plan)
        with one_thread():
            if loops is None:
                plan.spread(self.matrix.data, self._made.store)
                PlainElimination(plan, self._made).eliminate(np.arange(len(plan.pivots)))
            else:
                loops.eliminate(self.matrix.data, self._made, threads_for(plan.size))
        self._negative = int(self._made.negative.sum())
        self._doubtful = bool(self._made.doubtful.any())

    @property
    def negative(self) -> int:
        if self._doubtful:
            self._doubtful = False
            probe = np.ones(len(self._plan.fronts.order))
            with np.errstate(all="ignore"):
                error = float(np.linalg.norm(probe - self.matrix @ self._apply(probe)))
            if not error <= PIVOT_ABOVE * np.sqrt(len(probe)):
                self._negative = SuperLUFactor(self.matrix).negative
        return self._negative

    def _apply(self, rhs: Array) -> Array:
        if self._loops is None:
            return solve(self._plan, self._made, rhs)
        return self._loops.solve(self._made, rhs, threads_for(self._plan.size))
