"""A matrix answered for by the factor of one close by, where that is shown to be close enough.

With L the factor of a positive definite matrix near K, the eigenvalues of the pencil (K, L) lie about 1. Where the
lowest is well above zero, K is positive definite as well (Sylvester's law of inertia), and conjugate gradients
preconditioned by L solve with K to rounding in a few rounds. Both cost solutions, a twentieth of a factorisation each.
The extreme eigenvalues stand apart from the others, so a few steps of Lanczos' method find them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.linalg.checked import CheckedFactor, Factor, SingularMatrixError
from kirigami.primitives.kernel import Array

LOWEST = 0.3  # least eigenvalue of the pencil with which the factor close by will do
STEPS = 10  # most steps of Lanczos' method; where they do not settle, the matrix is factorised
SETTLED = 0.03  # change of the lowest eigenvalue in two steps, as a share of it, that is small enough
SOLVED = 1e-11  # residual over right-hand side to which is solved
ROUNDS = 60  # most rounds of conjugate gradients


class NearbyFactor:
    """A positive definite symmetric `matrix`, and the factor of one close to it.

    Attributes
    ----------
    near : Factor
        The factor, of a matrix close by, which is not asked for any more: conjugate gradients look after themselves.
    """

    negative = 0

    def __init__(self, matrix: Any, near: Factor) -> None:
        self.matrix, self.near = matrix, _alone(near) or near
        self.backend = near.backend

    def solve(self, rhs: Array) -> Array:
        """Solution for one right-hand side (n,), to rounding."""
        enough = SOLVED * float(np.linalg.norm(rhs))
        solution, residual = np.zeros_like(rhs), rhs.copy()
        direction, product = np.zeros_like(rhs), 1.0
        for _ in range(ROUNDS):
            if np.linalg.norm(residual) <= enough:
                return solution
            correction = self.near.solve(residual)
            before, product = product, float(residual @ correction)
            direction = correction + (product / before) * direction
            image = self.matrix @ direction
            share = product / float(direction @ image)
            solution += share * direction
            residual -= share * image
        raise SingularMatrixError("the stiffness matrix is singular to working precision")


def nearby_factor(matrix: Any, near: Factor) -> NearbyFactor | None:
    """The `matrix` with the positive definite factor `near`, or None where they are not shown to be close.

    Examples
    --------
    >>> from kirigami.linalg.nearby import nearby_factor
    >>> import numpy as np
    >>> from scipy.sparse import diags
    >>> from kirigami.linalg import factorize
    >>> near = factorize(diags([1.0, 2.0, 3.0], format="csc"))
    >>> nearby_factor(diags([1.1, 2.0, 2.9], format="csc"), near).solve(np.array([1.1, 2.0, 2.9])).round(9).tolist()
    [1.0, 1.0, 1.0]
    >>> nearby_factor(diags([-0.1, 2.0, 2.9], format="csc"), near) is None
    True
    """
    alone = None if near.negative else _alone(near)
    if alone is None:
        return None
    lowest, settled = lowest_of_pencil(matrix, alone, LOWEST)
    return NearbyFactor(matrix, alone) if settled and lowest > LOWEST else None


def _alone(factor: Factor) -> Factor | None:
    """A factor without its matrix, None where its solutions must be looked after."""
    return factor.unchecked() if isinstance(factor, CheckedFactor) else factor


def lowest_of_pencil(matrix: Any, near: Factor, least: float = -np.inf) -> tuple[float, bool]:
    """Lowest eigenvalue of ``matrix v = value L v`` with L of the positive definite factor `near`, and if it settled.

    It ends early once the value, which only falls, is below `least`.

    Examples
    --------
    >>> from kirigami.linalg.nearby import lowest_of_pencil
    >>> from scipy.sparse import diags
    >>> from kirigami.linalg import factorize
    >>> near = factorize(diags([1.0, 2.0, 4.0], format="csc"))
    >>> lowest, settled = lowest_of_pencil(diags([2.0, 1.0, -1.0], format="csc"), near)
    >>> round(lowest, 9), settled
    (-0.25, True)
    """
    size = matrix.shape[0]
    lows: list[float] = []
    vectors, images = np.zeros((STEPS, size)), np.zeros((STEPS, size))
    projected = np.zeros((STEPS, STEPS))
    image = np.random.default_rng(0).normal(size=size)  # near the softest motions once it is solved for
    vector = near.solve(image)
    first = float(vector @ image)
    for k in range(min(STEPS, size)):
        norm = float(vector @ image)
        if not norm > 1e-20 * first:  # the space is exhausted
            return min(lows, default=-np.inf), True
        vectors[k], images[k] = vector / norm**0.5, image / norm**0.5
        known, duals = vectors[: k + 1], images[: k + 1]
        image = matrix @ vectors[k]
        projected[: k + 1, k] = projected[k, : k + 1] = known @ image
        lows.append(float(np.linalg.eigvalsh(projected[: k + 1, : k + 1])[0]))
        if not lows[-1] >= least:
            return lows[-1], False
        if k >= 2 and abs(lows[-1] - lows[-3]) < SETTLED * abs(lows[-1]):
            return lows[-1], True
        vector = near.solve(image)
        for _ in range(2):  # apart from all before, since rounding does not keep them so
            parts = duals @ vector
            vector, image = vector - parts @ known, image - parts @ duals
    return lows[-1], len(lows) == size
