"""SuperLU of SciPy, without exchange of rows.

Fast on symmetric matrices, and by Sylvester's law the negative entries of the diagonal of U then count the negative
eigenvalues. It has no guarantee of stability, so solutions are checked.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.linalg.checked import (
    CheckedFactor,
    Factor,
    NothingToSolve,
    PatternCache,
    SingularMatrixError,
    factorize_with_pivoting,
)
from kirigami.primitives.kernel import Array


class SuperLU:
    """The fill-reducing order is found once for matrices that share their pattern."""

    def __init__(self) -> None:
        self._pattern = PatternCache()
        self._order: Any = None
        self._permuted: tuple[Any, Any, Any] | None = None  # entries taken, indices, indptr

    def factorize(self, matrix: Any) -> Factor:
        """Factor a symmetric CSC matrix; raises SingularMatrixError where that is impossible also with pivoting."""
        if matrix.shape[0] == 0:
            return NothingToSolve(matrix)
        if not self._pattern.knows(matrix) or self._permuted is None:
            factor = SuperLUFactor(matrix)
            self._remember(matrix, factor.order)
            return factor
        from scipy.sparse import csc_matrix

        taken, indices, indptr = self._permuted
        permuted = csc_matrix((matrix.data[taken], indices, indptr), shape=matrix.shape)
        return SuperLUFactor(matrix, permuted, self._order)

    def _remember(self, matrix: Any, order: Any) -> None:
        """Keep the permutation, and where each entry of the permuted matrix comes from."""
        from scipy.sparse import csc_matrix

        self._order, self._permuted = order, None
        if order is None:
            return
        numbered = csc_matrix((np.arange(1, matrix.nnz + 1), matrix.indices, matrix.indptr), shape=matrix.shape)
        permuted = numbered[order][:, order].tocsc()
        permuted.sort_indices()
        self._permuted = permuted.data - 1, permuted.indices, permuted.indptr


class SuperLUFactor(CheckedFactor):
    """Factor by SuperLU of a matrix, or of the same matrix brought into a known order."""

    backend = "superlu"

    def __init__(self, matrix: Any, permuted: Any = None, order: Any = None) -> None:
        super().__init__(matrix)
        self._order = order
        self._negative: int | None = None
        try:
            self._lu = self._factorize(matrix) if order is None else self._factorize(permuted, "NATURAL")
        except RuntimeError:
            # A zero on the diagonal need not mean a singular matrix once rows may be exchanged.
            self._order = None
            self._lu = factorize_with_pivoting(matrix)

    @staticmethod
    def _factorize(matrix: Any, ordering: str = "MMD_AT_PLUS_A") -> Any:
        from scipy.sparse.linalg import splu

        # relax=1: no artificial supernodes; they only add fill to the small node blocks of these matrices.
        return splu(matrix, permc_spec=ordering, diag_pivot_thresh=0.0, relax=1, options={"SymmetricMode": True})

    @property
    def order(self) -> Any:
        """The order of elimination found, or None where rows were exchanged."""
        if not np.array_equal(self._lu.perm_r, self._lu.perm_c):
            return None
        return np.argsort(self._lu.perm_c)

    @property
    def negative(self) -> int:
        if self._negative is None:
            lu = self._lu
            if not np.array_equal(lu.perm_r, lu.perm_c):
                # Rows were exchanged, so U tells no inertia; a shift far below the stiffness avoids the exact zero.
                shifted = self.matrix.copy()
                shifted.setdiag(shifted.diagonal() + 1e-13 * np.abs(shifted.diagonal()).mean())
                try:
                    lu = self._factorize(shifted)
                except RuntimeError as error:
                    raise SingularMatrixError(f"the stiffness matrix is singular ({error})") from None
            self._negative = int(np.count_nonzero(lu.U.diagonal() < 0))
        return self._negative

    def _apply(self, rhs: Array) -> Array:
        if self._order is None:
            return self._lu.solve(rhs)  # type: ignore[no-any-return]
        solution = np.empty_like(rhs)
        solution[self._order] = self._lu.solve(rhs[self._order])
        return solution
