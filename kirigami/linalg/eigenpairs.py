"""The lowest eigenpairs of large symmetric problems, counted so that none is missing; and the one nearest to zero.

A Krylov space answers with pairs that are right, not with all of them: one that the start hardly holds, or the third
of three equal ones, may be missing. So every answer is counted: ``K - m M`` has as many negative pivots as there are
eigenvalues below m (Sylvester's law of inertia), and where one is missing, it is searched for beside those known.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from kirigami.errors import AnalysisError
from kirigami.linalg.checked import Factor, SingularMatrixError, terms
from kirigami.linalg.krylov import KrylovSpace, leading_pairs
from kirigami.primitives.kernel import Array
from kirigami.words import counted

SHIFTED = 1e-8  # shift below zero of a matrix without usable factor, as a share of its stiffness
SPARE = 4  # pairs found beyond those asked for, to place the count where there is a gap
FREE = 1e-14  # energy of a motion over that of its entries one by one, below which it is rounding
ROUNDS = 40  # searches for what was missing before it is given up

Factorize = Callable[[Any], Factor]


def lowest_eigenpairs(
    stiffness: Any,
    mass: Any,
    count: int,
    null: Array,
    factorize: Factorize,
    is_held: Callable[[Array], bool] | None = None,
) -> tuple[Array, Array]:
    """The lowest eigenvalues of ``K v = value M v`` (ascending) and mass-normalised vectors (n, count), all of them.

    Parameters
    ----------
    stiffness : sparse matrix, shape (n, n)
        K, symmetric.
    mass : sparse matrix, shape (n, n)
        M, diagonal, positive or zero: what has no mass follows without inertia.
    count : int
        How many, at most the rank of M.
    null : ndarray, shape (n, k)
        Vectors with K v = 0 known beforehand, as the rigid motions of a free body; their values are exactly zero.
    factorize : callable
        Factorises a symmetric CSC matrix.
    is_held : callable, optional
        Tells of a vector (n,) that costs no more than the rounding of K whether it costs something all the same.

    Raises
    ------
    AnalysisError
        Pairs do not settle, their number is not that of the negative pivots, they do not solve the equation, or they
        drown in the rounding of K.
    """
    values, vectors = _Search(stiffness, mass, orthonormal(null, mass), factorize, is_held).run(count)
    _check_residuals(stiffness, mass, values, vectors)
    return values, vectors


class _Search:
    """One search for the lowest eigenpairs.

    Motions that cost nothing are left out of the space. At shift zero they are grounded by springs at a few unknowns:
    forces that do no work on them leave such springs without load, so that the solution is the right one.
    """

    def __init__(
        self, stiffness: Any, mass: Any, null: Array, factorize: Factorize, is_held: Callable[[Array], bool] | None
    ) -> None:
        self.stiffness, self.mass, self.null, self.factorize = stiffness, mass, null, factorize
        self._massive = places_in(mass, stiffness)
        self.is_held = is_held
        weight = mass.diagonal()
        self.rank = int(np.count_nonzero(weight))
        ratio = np.abs(stiffness.diagonal()[weight > 0]) / weight[weight > 0]
        self.scale = float(np.median(ratio)) or float(ratio.mean()) or 1.0

    def run(self, count: int) -> tuple[Array, Array]:
        """The lowest pairs, counted."""
        shift, factor = self._shift(count)
        values, vectors = np.zeros(self.null.shape[1]), self.null
        if factor is None:  # nothing is lower than what costs nothing
            return values[:count], vectors[:, :count]
        wanted = count + SPARE - (0 if shift else len(values))
        for seed in range(ROUNDS):
            if factor is None:
                factor = self.factorize(self._shifted(shift) if shift else grounded(self.stiffness, self.null))
            new, more = self._above(shift, factor, min(wanted, self.rank - len(values)), vectors, seed)
            values, vectors = np.append(values, new), np.hstack([vectors, more])
            order = np.argsort(values, kind="stable")
            values, vectors = values[order], vectors[:, order]
            factor = None  # not beside the one that counts: it is seldom needed again, and large
            missing = self._missing(values, count)
            if not missing:
                return values[:count], vectors[:, :count]
            wanted = missing + SPARE
        raise AnalysisError("eigenvalues are missing that the pivots tell of, and they cannot be found")

    # ---- where to start from

    def _shift(self, count: int) -> tuple[float, Factor | None]:
        """A shift below all eigenvalues but those of `null`, and its factor; None where nothing else is needed.

        Motions without stiffness that were not known beforehand join `null`.
        """
        for _ in range(ROUNDS):
            supported = grounded(self.stiffness, self.null)
            try:
                factor = self.factorize(supported)
                negative, sound = factor.negative, resists(supported, factor)
            except SingularMatrixError:
                sound = False
            if sound and negative:
                return self._below(factor)
            if self.null.shape[1] >= count:
                return 0.0, None
            if sound:
                return 0.0, factor
            shift = -SHIFTED * self.scale
            factor = self.factorize(self._shifted(shift, supported))
            if factor.negative:
                return self._below(None)
            values, vectors = self._above(shift, factor, count - self.null.shape[1], self.null, 0)
            free = np.array([costs_nothing(supported, vector) for vector in vectors.T], dtype=bool)
            if not free.any():
                near = min(-0.01 * float(values[0]), 0.5 * shift)
                return near, self.factorize(self._shifted(near))
            if self.is_held is not None and any(self.is_held(vector) for vector in vectors.T[free]):
                raise AnalysisError(
                    "the lowest eigenvalues are but rounding of the stiffness, as for a very thin sheet that does not "
                    "lie level with two axes: turn it so that it does, or make it thicker"
                )
            self.null = orthonormal(np.hstack([self.null, vectors[:, free]]), self.mass)
        raise AnalysisError("too many motions cost nothing: ask for fewer modes, or support the structure")

    def _below(self, factor: Factor | None) -> tuple[float, Factor]:
        """A shift below the lowest eigenvalue, which is negative: widened until no pivot is."""
        shift = -SHIFTED * self.scale
        if factor is not None:  # the negative eigenvalue nearest to zero is the largest of the inverse turned over
            around = factor
            space = KrylovSpace(lambda v: -around.solve(self.mass @ v), self.mass, self.null)
            for _ in range(3):
                space.grow()
            nearest = float(space.pairs(1)[0][0])
            shift = -2.0 / nearest if nearest > 0 else shift
        for _ in range(100):
            try:
                below = self.factorize(self._shifted(shift))
                if not below.negative:
                    return shift, below
            except SingularMatrixError:
                pass
            shift *= 4.0
        raise AnalysisError("no shift lies below the lowest eigenvalue: is something unstable without mass?")

    def _shifted(self, shift: float, supported: Any = None) -> Any:
        """``K - shift M``, or the same of K with springs, in the very pattern of K where that has room for M: solvers
        know it by that."""
        stiffness = self.stiffness if supported is None else supported
        if self._massive is None or stiffness.nnz != self.stiffness.nnz:
            return (stiffness - shift * self.mass).tocsc()
        from scipy.sparse import csc_matrix

        data = stiffness.data.copy()
        data[self._massive] -= shift * self.mass.data
        matrix = csc_matrix((data, stiffness.indices, stiffness.indptr), shape=stiffness.shape)
        matrix.indices, matrix.indptr = stiffness.indices, stiffness.indptr
        return matrix

    # ---- finding and counting

    def _above(self, shift: float, factor: Factor, count: int, avoid: Array, seed: int) -> tuple[Array, Array]:
        """Eigenvalues above `shift` (ascending) and vectors, beside those of `avoid`."""
        if count < 1:
            return np.empty(0), self.null[:, :0]
        space = KrylovSpace(lambda v: factor.solve(self.mass @ v), self.mass, avoid, seed)
        inverse, vectors = leading_pairs(space, count)
        return shift + 1.0 / inverse, vectors

    def _missing(self, values: Array, count: int) -> int:
        """How many eigenvalues were not found below the widest gap from the last one asked for on."""
        if len(values) >= self.rank:
            return 0
        if len(values) <= count:
            return count + 1 - len(values)
        size = np.maximum(np.abs(values[count:]), np.abs(values[count - 1 : -1]))
        gaps = np.diff(values[count - 1 :]) / np.maximum(size, np.finfo(float).tiny)
        at = count + int(np.argmax(gaps))
        below = self._count(values[at - 1], values[at])
        if below < at:
            raise AnalysisError(
                f"{counted(at, 'eigenvalue')} found where the pivots tell of {below}: the model is "
                "too badly scaled for modes"
            )
        return below - at

    def _count(self, low: float, high: float) -> int:
        """Number of eigenvalues below some place between two of them."""
        for share in (0.5, 0.4, 0.6):
            between = (1 - share) * low + share * high
            try:
                return self.factorize(self._shifted(between)).negative
            except SingularMatrixError:
                continue
        raise AnalysisError(f"the eigenvalues between {low:.6g} and {high:.6g} cannot be counted")


def places_in(part: Any, whole: Any) -> Any:
    """Where the entries of a matrix stand among those of another one (both CSC, rows in order); None where some do not,
    or rows are not in order."""
    if part.format != "csc" or whole.format != "csc" or not whole.has_sorted_indices or not part.has_sorted_indices:
        return None
    column = np.repeat(np.arange(part.shape[1]), np.diff(part.indptr))
    low, high = whole.indptr[column].astype(np.int64), whole.indptr[column + 1].astype(np.int64)
    end = high
    while np.any(low < high):  # halves what is left of each column
        middle = (low + high) // 2
        below = np.logical_and(low < high, whole.indices[np.minimum(middle, whole.nnz - 1)] < part.indices)
        low, high = np.where(below, middle + 1, low), np.where(below, high, middle)
    there = (low < end) & (whole.indices[np.minimum(low, whole.nnz - 1)] == part.indices)
    return low if there.all() else None


def orthonormal(vectors: Array, mass: Any) -> Array:
    """A basis of `vectors` (n, k) that is orthonormal in the metric of the mass, in their order."""
    for _ in range(2):
        if vectors.shape[1]:
            square = vectors.T @ (mass @ vectors)
            vectors = np.linalg.solve(np.linalg.cholesky(square), vectors.T).T
    return vectors


def grounded(stiffness: Any, null: Array) -> Any:
    """A stiffness with a spring at as many unknowns as there are motions (n, k) that cost nothing."""
    from scipy.linalg import qr

    if not null.shape[1]:
        return stiffness
    held = qr(null.T, mode="r", pivoting=True)[1][: null.shape[1]]
    diagonal = stiffness.diagonal()
    springs = np.abs(diagonal[held])
    springs[springs == 0] = float(np.abs(diagonal).mean()) or 1.0
    diagonal[held] += springs
    held_stiffness = stiffness.copy()
    held_stiffness.setdiag(diagonal)
    return held_stiffness


def costs_nothing(matrix: Any, vector: Array) -> bool:
    """Whether the energy of a motion is nothing but the rounding of the terms it sums up."""
    one_by_one = float(np.abs(vector) @ terms(matrix, vector))
    return abs(float(vector @ (matrix @ vector))) <= FREE * one_by_one


def resists(matrix: Any, factor: Factor) -> bool:
    """Whether a factor is sound and no motion costs nothing."""
    vector = np.random.default_rng(0).normal(size=matrix.shape[0])
    for _ in range(3):
        with np.errstate(all="ignore"):
            vector = factor.solve(vector)
        largest = float(np.abs(vector).max(initial=0.0))
        if not np.isfinite(largest) or largest == 0:
            return False
        vector = vector / largest
    return not costs_nothing(matrix, vector)


def _check_residuals(stiffness: Any, mass: Any, values: Array, vectors: Array) -> None:
    """Raise AnalysisError for a pair that does not solve ``K v = value M v`` as well as rounding lets it."""
    largest = float(terms(stiffness, np.ones(stiffness.shape[0])).max())
    unit = 8 * np.finfo(float).eps * largest  # rounding of a vector of length one itself
    for value, vector in zip(values.tolist(), vectors.T):
        inertia = value * (mass @ vector)
        error = float(np.linalg.norm(stiffness @ vector - inertia))
        added = float(np.linalg.norm(terms(stiffness, vector)))
        rounding = 1e-11 * added + unit * float(np.linalg.norm(vector))
        if not error <= 1e-6 * float(np.linalg.norm(inertia)) + rounding:
            raise AnalysisError(f"the eigenvalue {value:.6g} is not solved: residual {error:.1e} of forces {added:.1e}")


def inverse_iteration(factor: Factor, size: int, rounds: int, settled: float = 0.0) -> tuple[float, Array]:
    """Eigenvalue nearest to zero of a factorised matrix, and its vector (size,) of unit length.

    It ends after so many rounds, or once the eigenvalue changes by less than the share `settled`; the start is always
    the same.
    """
    vector = np.random.default_rng(0).normal(size=size)
    vector /= np.linalg.norm(vector)
    value = float("inf")
    for _ in range(rounds):
        solution = factor.solve(vector)
        length = float(np.linalg.norm(solution))
        before, value = value, float(solution @ vector) / length**2
        vector = solution / length
        if abs(value - before) < settled * abs(value):
            break
    return value, vector
