"""What every back end shares: the interface, a checked and refined solution, and the way out by pivoting."""

from __future__ import annotations

import copy
from typing import Any, Protocol

import numpy as np

from kirigami.errors import KirigamiError
from kirigami.primitives.kernel import Array

REFINE_ABOVE = 1e-10  # residual over right-hand side that calls for a step of refinement
PIVOT_ABOVE = 1e-6  # ... and for a second look, or a new factorisation with pivoting
SINGULAR_ABOVE = 1e-3  # ... and shows, after that, that nothing helps
ROUNDED = 1e-12  # residual over its terms, entry by entry, that rounding explains
COLUMNS = 20_000  # of a matrix that are looked at together, so that what this takes is little
NO_WORK = 1e-14  # work of a right-hand side over that of the terms one by one, below which rounding makes it all


class SingularMatrixError(KirigamiError):
    """The matrix has no usable factorisation."""


class Factor(Protocol):
    """A factorised symmetric matrix, and the matrix itself."""

    backend: str
    matrix: Any

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues."""
        ...

    def solve(self, rhs: Array) -> Array:
        """Solution for one right-hand side (n,), or for some at once (n, k)."""
        ...


class Solver(Protocol):
    """A back end: factorises one matrix after another, and may keep what depends on their pattern alone."""

    def factorize(self, matrix: Any) -> Factor: ...


class NothingToSolve:
    """Factor of a matrix without rows: every displacement is prescribed."""

    backend = "none"
    negative = 0

    def __init__(self, matrix: Any) -> None:
        self.matrix = matrix

    def solve(self, rhs: Array) -> Array:
        return np.zeros_like(rhs)


class CheckedFactor:
    """Base of all factors: a subclass applies its inverse, this class checks and refines what comes out.

    No back end exchanges rows as freely as stability asks for, because free exchange costs speed. So every solution is
    held against the matrix, refined once where it needs it, and done again with full pivoting where it is bad.

    Bad does not mean a residual that is large against the right-hand side: a soft body moves far under small forces,
    and the residual is the rounding of the terms K x, which are as large as x is. It is bad where its backward error
    is, that is where no matrix within rounding has this solution (Oettli and Prager, Numer. Math. 6 (1964)), or where
    the motion costs no more than rounding, as in a mechanism.
    """

    backend = ""

    def __init__(self, matrix: Any) -> None:
        self.matrix = matrix
        self._pivoting: Any = None

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues."""
        raise NotImplementedError

    def _apply(self, rhs: Array) -> Array:
        """The inverse times one right-hand side (n,), or some (n, k), unchecked."""
        raise NotImplementedError

    def unchecked(self) -> Unchecked | None:
        """The inverse alone, without the matrix; None where it was found to be bad."""
        if self._pivoting is not None:
            return None
        alone = copy.copy(self)
        alone.matrix = None
        return Unchecked(alone)

    def solve(self, rhs: Array) -> Array:
        """Solution for one right-hand side (n,), or for some at once (n, k), which costs less than one by one."""
        if rhs.ndim == 2:
            return self._solve_some(rhs)
        size = np.linalg.norm(rhs)
        if size == 0:
            return np.zeros_like(rhs)
        if self._pivoting is None:
            with np.errstate(all="ignore"):
                refined, error = self._refined(rhs, REFINE_ABOVE * size)
            if error <= PIVOT_ABOVE * size or self._explained(rhs, refined):
                return refined
            self.negative  # counted before the factor that tells it is replaced  # noqa: B018
            self._pivoting = factorize_with_pivoting(self.matrix)
        solution: Array = self._pivoting.solve(rhs)
        error = float(np.linalg.norm(rhs - self.matrix @ solution))
        if not error <= SINGULAR_ABOVE * size and not self._explained(rhs, solution):
            raise SingularMatrixError(
                "the stiffness matrix is singular to working precision: some motion is held by nothing, or by less "
                "than the rounding of what holds the others, as the bending of a very thin sheet that is not level"
            )
        return solution

    def _solve_some(self, rhs: Array) -> Array:
        """Solutions (n, k), each refined where it needs it; those that stay bad are looked into one by one."""
        if self._pivoting is not None or rhs.shape[1] < 2:
            return np.stack([self.solve(column) for column in rhs.T], axis=1) if rhs.size else rhs
        with np.errstate(all="ignore"):
            solution = self._apply(rhs)
            residual = rhs - self.matrix @ solution
            size, error = np.linalg.norm(rhs, axis=0), np.linalg.norm(residual, axis=0)
            again = np.flatnonzero(~(error <= REFINE_ABOVE * size))
            if again.size:
                refined = solution[:, again] + self._apply(residual[:, again])
                left = np.linalg.norm(rhs[:, again] - self.matrix @ refined, axis=0)
                better = left < error[again]
                solution[:, again[better]], error[again[better]] = refined[:, better], left[better]
        for column in np.flatnonzero(~(error <= PIVOT_ABOVE * size)).tolist():
            solution[:, column] = self.solve(rhs[:, column])
        return solution

    def _explained(self, rhs: Array, solution: Array) -> bool:
        """Whether the residual of a solution is nothing but rounding, and the motion is held by more than that."""
        added = terms(self.matrix, solution)
        residual = np.abs(rhs - self.matrix @ solution)
        rounded = bool((residual <= ROUNDED * (added + np.abs(rhs))).all())
        return rounded and abs(float(rhs @ solution)) > NO_WORK * float(np.abs(solution) @ added)

    def _refined(self, rhs: Array, enough: float) -> tuple[Array, float]:
        """A solution and the size of its residual, after one step of refinement if that helps."""
        solution = self._apply(rhs)
        residual = rhs - self.matrix @ solution
        error = float(np.linalg.norm(residual))
        if error > enough:
            refined = solution + self._apply(residual)
            refined_error = float(np.linalg.norm(rhs - self.matrix @ refined))
            if refined_error < error:
                return refined, refined_error
        return solution, error


class Unchecked:
    """A positive definite factor whose matrix is let go: nothing of its solutions is checked or refined."""

    negative = 0
    matrix = None

    def __init__(self, factor: CheckedFactor) -> None:
        self._factor, self.backend = factor, factor.backend

    def solve(self, rhs: Array) -> Array:
        with np.errstate(all="ignore"):
            return self._factor._apply(rhs)


def terms(matrix: Any, vectors: Array) -> Array:
    """What the terms of ``matrix @ vectors``, for one (n,) or some (n, k), come to one by one: |A| |x|.

    A copy of a large matrix would be as much memory as it is itself, so columns are taken together by and by.
    """
    from scipy.sparse import csc_matrix

    sizes, (rows, columns) = np.abs(vectors), matrix.shape
    if matrix.format != "csc":
        return np.asarray(abs(matrix) @ sizes)
    total = np.zeros((rows, *sizes.shape[1:]))
    for first in range(0, columns, COLUMNS):
        last = min(first + COLUMNS, columns)
        part = slice(int(matrix.indptr[first]), int(matrix.indptr[last]))
        within = matrix.indptr[first : last + 1] - matrix.indptr[first]
        some = csc_matrix((np.abs(matrix.data[part]), matrix.indices[part], within), shape=(rows, last - first))
        total += some @ sizes[first:last]
    return total


def factorize_with_pivoting(matrix: Any) -> Any:
    """SuperLU with exchange of rows; raises SingularMatrixError where that fails as well."""
    from scipy.sparse.linalg import splu

    try:
        return splu(matrix, permc_spec="COLAMD")
    except RuntimeError as error:
        raise SingularMatrixError(f"the stiffness matrix is singular ({error})") from None


class PatternCache:
    """Remembers the pattern of the last matrix, so that what depends on it alone is worked out once."""

    def __init__(self) -> None:
        self._indices: Any = None
        self._indptr: Any = None

    def knows(self, matrix: Any) -> bool:
        """Whether the matrix (CSC) has the pattern of the last one; remembers it otherwise."""
        same = matrix.indices is self._indices and matrix.indptr is self._indptr
        if not same and self._indices is not None and len(matrix.indices) == len(self._indices):
            same = np.array_equal(matrix.indptr, self._indptr) and np.array_equal(matrix.indices, self._indices)
        self._indices, self._indptr = matrix.indices, matrix.indptr
        return same
