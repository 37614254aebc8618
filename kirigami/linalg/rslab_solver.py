"""The rslab package (optional): supernodal L D L' with pivoting by Bunch and Kaufman, written in Rust."""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.errors import AnalysisError
from kirigami.linalg.checked import CheckedFactor, Factor, NothingToSolve, PatternCache
from kirigami.linalg.superlu import SuperLUFactor
from kirigami.primitives.kernel import Array


class Rslab:
    """The analysis is made once for matrices that share their pattern; raises AnalysisError without rslab."""

    def __init__(self) -> None:
        try:
            import rslab
        except ImportError:
            raise AnalysisError(
                "the solver 'rslab' is not installed: pip install 'kirigami-mechanics[fast]', or choose another"
            ) from None
        self._analyze = rslab.analyze
        self._pattern = PatternCache()
        self._analysis: Any = None
        self._lower: Any = None

    def factorize(self, matrix: Any) -> Factor:
        """Factor a symmetric CSC matrix; raises SingularMatrixError where that is impossible also with pivoting."""
        if matrix.shape[0] == 0:
            return NothingToSolve(matrix)
        if not self._pattern.knows(matrix) or self._analysis is None:
            column = np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))
            self._lower = np.flatnonzero(matrix.indices >= column)
            self._analysis = self._analyze(matrix, path="ldlt")
        try:
            return RslabFactor(matrix, self._analysis.factor(matrix.data[self._lower]))
        except RuntimeError:
            return SuperLUFactor(matrix)


class RslabFactor(CheckedFactor):
    """Factor by rslab."""

    backend = "rslab"

    def __init__(self, matrix: Any, factor: Any) -> None:
        super().__init__(matrix)
        self._factor = factor

    @property
    def negative(self) -> int:
        _, negative, zero = self._factor.inertia
        return int(negative) if zero == 0 else SuperLUFactor(self.matrix).negative

    def _apply(self, rhs: Array) -> Array:
        if rhs.ndim == 2:
            return np.stack([self._apply(column) for column in rhs.T], axis=1)
        return np.asarray(self._factor.solve(np.ascontiguousarray(rhs)))
