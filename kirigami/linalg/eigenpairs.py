"""Eigenpairs of large symmetric problems by shift and invert, and the one nearest to zero by inverse iteration."""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.linalg.checked import Factor
from kirigami.primitives.kernel import Array


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
