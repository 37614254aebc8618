"""Linear algebra: factorise a symmetric sparse matrix, count its negative eigenvalues, solve with a checked residual.

One small interface, :class:`Factor`, so that a back end is a function from a matrix to a factor. The default is
SuperLU without pivoting off the diagonal: fast on symmetric matrices, and by Sylvester's law the negative entries of
the diagonal of U then count the negative eigenvalues. It has no guarantee of stability, so every solution is checked
and refined, and a bad one is done again with pivoting.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from kirigami.errors import KirigamiError
from kirigami.kernel import Array

REFINE_ABOVE = 1e-12  # residual over right-hand side that calls for a step of refinement
PIVOT_ABOVE = 1e-6  # ... and for a new factorisation with pivoting


class SingularMatrixError(KirigamiError):
    """The matrix has no usable factorisation."""


class Factor(Protocol):
    """A factorised symmetric matrix."""

    backend: str

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues."""
        ...

    def solve(self, rhs: Array) -> Array:
        """Solution for one right-hand side (n,)."""
        ...


class Solver(Protocol):
    """A back end: factorises one matrix after another, and may keep what depends on their pattern alone."""

    def factorize(self, matrix: Any) -> Factor: ...


class SuperLU:
    """SciPy's SuperLU; the fill-reducing order is found once for matrices that share their pattern."""

    def __init__(self) -> None:
        self._pattern: tuple[Any, Any] | None = None
        self._order: Any = None
        self._permuted: tuple[Any, Any, Any] | None = None  # entries taken, indices, indptr

    def factorize(self, matrix: Any) -> Factor:
        """Factor a symmetric CSC matrix; raises SingularMatrixError where that is impossible also with pivoting."""
        if matrix.shape[0] == 0:
            return NothingToSolve()
        if self._pattern is None or matrix.indices is not self._pattern[0] or matrix.indptr is not self._pattern[1]:
            factor = SuperLUFactor(matrix)
            if factor.order is not None:
                self._remember(matrix, factor.order)
            return factor
        from scipy.sparse import csc_matrix

        taken, indices, indptr = self._permuted  # type: ignore[misc]
        permuted = csc_matrix((matrix.data[taken], indices, indptr), shape=matrix.shape)
        return SuperLUFactor(matrix, permuted, self._order)

    def _remember(self, matrix: Any, order: Any) -> None:
        """Keep the permutation, and where each entry of the permuted matrix comes from."""
        from scipy.sparse import csc_matrix

        numbered = csc_matrix((np.arange(1, matrix.nnz + 1), matrix.indices, matrix.indptr), shape=matrix.shape)
        permuted = numbered[order][:, order].tocsc()
        permuted.sort_indices()
        self._pattern = matrix.indices, matrix.indptr
        self._order = order
        self._permuted = permuted.data - 1, permuted.indices, permuted.indptr


class NothingToSolve:
    """Factor of a matrix without rows: every displacement is prescribed."""

    backend = "superlu"
    negative = 0

    def solve(self, rhs: Array) -> Array:
        return np.zeros_like(rhs)


class SuperLUFactor:
    """Factor by SuperLU of a matrix, or of the same matrix brought into a known order."""

    backend = "superlu"

    def __init__(self, matrix: Any, permuted: Any = None, order: Any = None) -> None:
        self.matrix = matrix
        self._order = order
        self._negative: int | None = None
        try:
            self._lu = self._factorize(matrix) if order is None else self._factorize(permuted, "NATURAL")
        except RuntimeError:
            # A zero on the diagonal need not mean a singular matrix once rows may be exchanged.
            self._order = None
            self._lu = self._factorize_with_pivoting(matrix)

    @staticmethod
    def _factorize(matrix: Any, ordering: str = "MMD_AT_PLUS_A") -> Any:
        from scipy.sparse.linalg import splu

        # relax=1: no artificial supernodes; they only add fill to the small node blocks of these matrices.
        return splu(matrix, permc_spec=ordering, diag_pivot_thresh=0.0, relax=1, options={"SymmetricMode": True})

    @staticmethod
    def _factorize_with_pivoting(matrix: Any) -> Any:
        from scipy.sparse.linalg import splu

        try:
            return splu(matrix, permc_spec="COLAMD")
        except RuntimeError as error:
            raise SingularMatrixError(f"the stiffness matrix is singular ({error})") from None

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

    def solve(self, rhs: Array) -> Array:
        size = np.linalg.norm(rhs)
        if size == 0:
            return np.zeros_like(rhs)
        solution = self._apply(rhs)
        error = rhs - self.matrix @ solution
        if np.linalg.norm(error) > REFINE_ABOVE * size:
            refined = solution + self._apply(error)
            refined_error = rhs - self.matrix @ refined
            if np.linalg.norm(refined_error) < np.linalg.norm(error):
                solution, error = refined, refined_error
        if not np.linalg.norm(error) <= PIVOT_ABOVE * size:
            self.negative  # counted before the factor that tells it is replaced  # noqa: B018
            self._order = None
            self._lu = self._factorize_with_pivoting(self.matrix)
            solution = self._apply(rhs)
            if not np.linalg.norm(rhs - self.matrix @ solution) <= 1e-3 * size:
                raise SingularMatrixError("the stiffness matrix is singular to working precision")
        return solution


BACKENDS: dict[str, Callable[[], Solver]] = {"superlu": SuperLU}


def make_solver(backend: str = "superlu") -> Solver:
    """A fresh solver of the given back end."""
    return BACKENDS[backend]()


def factorize(matrix: Any) -> Factor:
    """Factor one symmetric CSC matrix with the default back end."""
    return make_solver().factorize(matrix)


def smallest_eigenpairs(
    stiffness: Any, mass: Any, count: int, shift: float, factor: Factor, tol: float = 1e-10
) -> tuple[Array, Array]:
    """Eigenvalues nearest to `shift` (ascending) and mass-normalised vectors (n, count), by shift-invert Lanczos.

    `factor` is the factorised ``stiffness - shift * mass``; small problems are solved densely.
    """
    n = stiffness.shape[0]
    if n <= 400 or count >= n - 1:
        from scipy.linalg import eigh

        values, vectors = eigh(stiffness.toarray(), mass.toarray())
        return values[:count], vectors[:, :count]
    from scipy.sparse.linalg import LinearOperator, eigsh

    inverse = LinearOperator((n, n), matvec=factor.solve, dtype=float)
    start = np.random.default_rng(0).normal(size=n)  # a fixed start makes the modes repeatable
    values, vectors = eigsh(
        stiffness, k=count, M=mass, sigma=shift, OPinv=inverse, v0=start, tol=tol, ncv=max(2 * count + 1, 20)
    )
    order = np.argsort(values)
    return values[order], vectors[:, order]
