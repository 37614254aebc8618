"""Critical load factors, ``(K + f G) v = 0`` with f > 0, the lowest ones, counted by pivots."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from kirigami.errors import AnalysisError
from kirigami.linalg.checked import Factor, SingularMatrixError
from kirigami.linalg.eigenpairs import ROUNDS, SPARE, Factorize
from kirigami.linalg.krylov import BLOCK, KrylovSpace, leading_pairs
from kirigami.primitives.kernel import Array
from kirigami.words import counted

LIMIT = 10.0  # largest factor looked for, in units of that at which G is as large as K
PATIENCE = 6 * BLOCK  # size of a space after which a nearer shift is tried
NEAR = 0.3  # share of the way to the lowest factor, from above, at which a shift is near enough


def critical_factors(
    stiffness: Any, geometric: Any, count: int, factor: Factor, factorize: Factorize
) -> tuple[Array, Array]:
    """Lowest positive factors f (ascending) with ``(K + f G) v = 0``, and vectors (n, at most `count`).

    Where G is mostly positive, as in a sheet under tension, the factors sought are far inside the spectrum of its
    inverse. Seen from a shift s below the lowest of them they are outermost: ``(K + s G) v = -(f - s) G v``, and
    ``K + f G`` has as many negative pivots as there are factors below f.

    Parameters
    ----------
    stiffness : sparse matrix, shape (n, n)
        K, symmetric and positive definite.
    geometric : sparse matrix, shape (n, n)
        G, symmetric, scaled so that its largest entry is that of K: factors up to 10 are looked for, since beyond them
        some member would carry more than ten times the force that stretches it to twice its length.
    count : int
        How many.
    factor : Factor
        Factor of K.
    factorize : callable
        Factorises a symmetric CSC matrix.

    Raises
    ------
    AnalysisError
        Pairs do not settle, or their number is not that of the negative pivots.
    """
    return _CriticalSearch(stiffness, geometric, factor, factorize).run(count)


class _CriticalSearch:
    """One search for the lowest critical factors."""

    def __init__(self, stiffness: Any, geometric: Any, factor: Factor, factorize: Factorize) -> None:
        self.stiffness, self.geometric, self.factor, self.factorize = stiffness, geometric, factor, factorize
        self.nothing = np.zeros((stiffness.shape[0], 0))

    def run(self, count: int) -> tuple[Array, Array]:
        """The lowest factors, counted."""
        found = self._shift()
        if found is None:
            return np.empty(0), self.nothing
        shift, shifted, factor = found
        values, vectors = np.empty(0), self.nothing
        # Pairs beyond what is looked for need not settle; where the first was near at once, enough others should be.
        wanted = count + SPARE if shift == 0 else min(count + SPARE, self.everything)
        for seed in range(ROUNDS):
            space = self._space(shifted, factor, vectors, seed)
            try:
                inverse, more = leading_pairs(space, wanted)
            except AnalysisError:
                if wanted <= self.everything - len(values):
                    raise
                wanted = self.everything - len(values)
                continue
            near = inverse > 1 / (LIMIT - shift)
            inverse, more = inverse[near], more[:, near]
            values, vectors = np.append(values, shift + 1 / inverse), np.hstack([vectors, more])
            order = np.argsort(values, kind="stable")
            values, vectors = values[order], vectors[:, order]
            missing = self._missing(values, count)
            if not missing:
                return values[:count], vectors[:, :count]
            wanted = missing + SPARE
        raise AnalysisError("critical load factors are missing that the pivots tell of, and they cannot be found")

    def _space(self, shifted: Any, factor: Factor, avoid: Array, seed: int) -> KrylovSpace:
        return KrylovSpace(lambda v: -factor.solve(self.geometric @ v), shifted, avoid, seed)

    @cached_property
    def everything(self) -> int:
        """Number of critical factors that are looked for at all."""
        return self._negative(LIMIT)

    def _shift(self) -> tuple[float, Any, Factor] | None:
        """A shift below the lowest factor that is not far from it, its matrix, and the factor of that; None where there
        is no factor."""
        shift, shifted, factor, high = 0.0, self.stiffness, self.factor, LIMIT
        for _ in range(ROUNDS):
            space = self._space(shifted, factor, self.nothing, 0)
            while space.size < PATIENCE and not space.complete:
                space.grow()
            inverse, _, errors = space.pairs(1)
            if inverse[0] > 0:  # a Ritz value never passes the true one, so this is above the lowest factor
                high = min(high, shift + 1 / float(inverse[0]))
                if errors[0] <= 1e-3 * inverse[0]:
                    break
            elif not self.everything:
                return None
            if shift >= NEAR * high:
                break
            trial = self._trial(shift, high)
            if trial is None:
                break
            shift, shifted, factor = trial
        return shift, shifted, factor

    def _trial(self, shift: float, high: float) -> tuple[float, Any, Factor] | None:
        """The largest of a row of shifts towards `high` that still lies below every factor."""
        place = 0.5 * high
        while place > 1.5 * shift and place > 1e-15 * LIMIT:
            shifted = (self.stiffness + place * self.geometric).tocsc()
            try:
                factor = self.factorize(shifted)
                if not factor.negative:
                    return place, shifted, factor
            except SingularMatrixError:
                pass
            place *= 0.25
        return None

    def _negative(self, factor: float) -> int:
        """Number of critical factors below `factor`."""
        for nudge in (1.0, 1.001, 0.999):
            try:
                return self.factorize((self.stiffness + nudge * factor * self.geometric).tocsc()).negative
            except SingularMatrixError:
                continue
        raise AnalysisError(f"the critical load factors below {factor:.6g} cannot be counted")

    def _missing(self, values: Array, count: int) -> int:
        """How many factors were not found below the widest gap from the last one asked for on."""
        if len(values) <= count:
            return max(min(count + 1, self.everything) - len(values), 0)
        at = count + int(np.argmax(np.diff(values[count - 1 :]) / values[count:]))
        below = self._negative(0.5 * float(values[at - 1] + values[at]))
        if below < at:
            raise AnalysisError(
                f"{counted(at, 'critical load factor')} found where the pivots tell of {below}: the model is "
                "too badly scaled"
            )
        return below - at
