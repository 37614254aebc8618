"""Block Krylov spaces: the largest eigenpairs of an operator that is symmetric in a metric."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import AnalysisError
from kirigami.primitives.kernel import Array
from kirigami.words import counted

SETTLED = 1e-9  # residual of a pair over its value at which it is taken: the error of the value is its square
USABLE = 1e-4  # ... and at which it is taken where more rounds do not help
DROWNED = 1e-6  # value over the largest one below which it has lost too many digits
SPENT = 1e-12  # what is left of a vector when that is nothing but rounding
PASSES = 4  # most that it takes to leave nothing of a vector along others
BLOCK = 4  # vectors that start a space together, so that equal eigenvalues are found at once
RESTARTS = 40  # times that a space is restarted before it is given up


class KrylovSpace:
    """The largest eigenpairs of a linear operator that is symmetric in a metric, by block Lanczos with restarts.

    The basis is kept orthogonal to the last digit, and the operator is projected on it as it is (Rayleigh-Ritz), so no
    eigenvalue comes twice and restarts lose nothing. Images of the basis lie in the space and its next block, by
    coefficients: they are not kept beside it.

    Parameters
    ----------
    operator : callable
        Maps vectors (n, k) to vectors (n, k).
    metric : sparse matrix, shape (n, n)
        Symmetric, positive semi-definite; where it is not definite, the operator must send its null vectors to zero.
    avoid : ndarray, shape (n, k)
        Vectors to leave out, orthonormal in the metric.
    seed : int
        Start of the random vectors, so that answers repeat.
    """

    def __init__(self, operator: Callable[[Array], Array], metric: Any, avoid: Array, seed: int = 0) -> None:
        self._operator, self._metric = operator, metric
        self._avoid, self._metric_avoid = avoid, metric @ avoid
        n = metric.shape[0]
        self.size = 0  # vectors in the basis
        self._room = np.empty((0, n))  # the basis, vector by vector; made once as large as it gets
        self._projected = np.empty((0, 0))
        self._beyond = np.empty((0, 0))  # coefficients (next block, basis) of what images have beyond the basis
        start = np.random.default_rng(seed).normal(size=(n, min(BLOCK, n)))
        self._next = self._new_directions(self._clear(self._operator(self._clear(start))))

    @property
    def complete(self) -> bool:
        """Whether the operator leads out of the space no more, so that its pairs are exact."""
        return bool(self._next.shape[1] == 0)

    @property
    def _basis(self) -> Array:
        return np.asarray(self._room[: self.size].T)

    def reserve(self, size: int) -> None:
        """Make room for so many vectors, and a block more."""
        if len(self._room) < size + BLOCK:
            room = np.empty((size + BLOCK, self._room.shape[1]))
            room[: self.size] = self._room[: self.size]
            self._room = room

    def grow(self) -> None:
        """One more block."""
        block, self._next = self._next, self._next[:, :0]
        self.reserve(self.size)
        before, self.size = self.size, self.size + block.shape[1]
        image = self._clear(self._operator(block)) if block.size else block
        self._room[before : self.size] = block.T
        weighed = self._metric @ image
        columns = self._basis.T @ weighed
        projected = np.empty((self.size, self.size))
        projected[:before, :before] = self._projected
        projected[:, before:], projected[before:] = columns, columns.T
        self._projected = projected
        self._next = self._new_directions(image)
        self._beyond = np.zeros((self._next.shape[1], self.size))  # images of blocks before lie in the basis by now
        self._beyond[:, before:] = self._next.T @ weighed

    def pairs(self, count: int) -> tuple[Array, Array, Array]:
        """Largest Ritz values (descending), their vectors (n, count), and the size of their residuals."""
        values, rows = self._ritz(count)
        return values, self._basis @ rows, self._errors(rows)

    def _errors(self, rows: Array) -> Array:
        """Size of the residuals of combinations `rows` of the basis: what their images have beyond it."""
        return np.asarray(np.linalg.norm(self._beyond @ rows, axis=0))

    def errors(self, count: int) -> tuple[Array, Array]:
        """Values and errors as :meth:`pairs` gives them, without the vectors."""
        values, rows = self._ritz(count)
        return values, self._errors(rows)

    def images(self, values: Array, vectors: Array) -> Array:
        """Ritz vectors once more through the operator, which leaves less in them of what it makes small."""
        return self._clear(self._operator(vectors)) / values

    def restart(self, count: int) -> None:
        """Keep the vectors of the largest Ritz values only."""
        values, rows = self._ritz(count)
        kept = len(values)
        self._room[:kept] = rows.T @ self._room[: self.size]
        self._beyond = self._beyond @ rows
        self.size, self._projected = kept, np.diag(values)

    def _ritz(self, count: int) -> tuple[Array, Array]:
        values, rows = np.linalg.eigh(0.5 * (self._projected + self._projected.T))
        return values[::-1][:count], rows[:, ::-1][:, :count]

    def _clear(self, vectors: Array) -> Array:
        """`vectors` without what lies along those to be left out."""
        return np.asarray(vectors - self._avoid @ (self._metric_avoid.T @ vectors))

    def _new_directions(self, vectors: Array) -> Array:
        """An orthonormal basis of what in `vectors` is new to the space, and nothing where that is only rounding."""
        found = np.empty((len(vectors), 0))
        sizes = [_norm(self._metric, vector) for vector in vectors.T]
        vectors = self._clear(vectors)  # all at once, which reads the basis once
        vectors = vectors - self._basis @ (self._basis.T @ (self._metric @ vectors))
        for vector, size in zip(vectors.T, sizes):
            before = _norm(self._metric, vector)
            for _ in range(PASSES):
                vector = self._clear(vector[:, None])[:, 0]
                image = self._metric @ vector
                vector = vector - self._basis @ (self._basis.T @ image) - found @ (found.T @ image)
                length = _norm(self._metric, vector)
                if not length > SPENT * size:
                    break
                vector = vector / length
                if length > 0.5 * before:  # nothing cancelled, so that nothing is left along the others
                    found = np.column_stack([found, vector])
                    break
                before = size = 1.0
        return found


def _norm(metric: Any, vector: Array) -> float:
    return float(np.sqrt(max(float(vector @ (metric @ vector)), 0.0)))


def leading_pairs(space: KrylovSpace, count: int) -> tuple[Array, Array]:
    """Largest positive eigenvalues of the operator of a space (descending) and their vectors, all settled.

    At most `count`, and those only that are not drowned by the rounding of the largest: leave those found out of a
    new space to find more. Raises AnalysisError where they do not settle.
    """

    def settled(clear: NDArray[np.bool_]) -> tuple[Array, Array]:
        values, vectors, _ = space.pairs(count)
        return values[clear], space.images(values[clear], vectors[:, clear])

    longest, best = 2 * count + 12 * BLOCK, float("inf")
    space.reserve(longest)
    for _ in range(RESTARTS):
        while True:
            if space.size < longest:
                space.grow()
            if space.complete or space.size >= longest or space.size % (3 * BLOCK) == 0:
                values, errors = space.errors(count)
                clear = values > max(DROWNED * float(values.max(initial=0.0)), 0.0)
                error = float((errors[clear] / values[clear]).max(initial=0.0))
                if space.complete or (len(values) == count and clear.any() and error <= SETTLED):
                    return settled(clear)
            if space.size >= longest:
                break
        if clear.any() and USABLE >= error > 0.5 * best:  # as good as the solutions of equations let it become
            return settled(clear)
        best = min(best, error)
        space.restart(count + 2 * BLOCK)
    raise AnalysisError(
        f"{counted(count, 'eigenpair')} did not settle, the best to {best:.0e}: ask for fewer or for a few more; or "
        "the lowest of them are but rounding of the stiffness, as for a very thin sheet that does not lie level with "
        "two axes"
    )
