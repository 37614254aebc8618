"""Solutions with the tangent of forces that have no potential, which is not symmetric.

Factors are symmetric, and so are the tangents of kernels; what they lack of those that are not ``conservative`` is the
skew part S, known by how the forces of these kernels change along a vector, less what their symmetric part says. With
the factor of the symmetric part K,

    (1 + K^-1 S) x = K^-1 b

is solved by GMRES (Saad and Schultz, SIAM J. Sci. Stat. Comput. 7 (1986), 856): few kernels are asked, the factor is
made once, and Newton's method converges as it does where there is a potential.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from kirigami.linalg import Factor
from kirigami.primitives.kernel import Array, hessian_product
from kirigami.system.system import System

STEP = 1e-6  # displacement of the differences over the size of the structure
EXACT = 1e-8  # what is left of the right-hand side
SOLUTIONS = 40  # with the factor, at most


def solve(system: System, factor: Factor, q: Array, lam: float, rhs: Array) -> Array:
    """Solution (free,) for a right-hand side (free,) with the whole tangent at the unknowns `q`.

    `factor` is that of its symmetric part; where all forces have a potential there is no other.
    """
    first = factor.solve(rhs)
    rows = [kernel for kernel in system.kernels if not kernel.conservative]
    if not rows or not first.any():
        return first
    u = system.displacement(q, lam)
    x = system.configuration(u)
    symmetric = [kernel.evaluate(x, lam, 2) for kernel in rows]

    def skew(vector: Array) -> Array:
        """Product (free,) of the skew part with a vector (free,)."""
        largest = float(np.abs(vector).max())
        if largest == 0:
            return np.zeros_like(vector)
        share = STEP * system.size / largest
        ahead, behind = (system.displacement(q + sign * share * vector, lam) for sign in (1, -1))
        total = np.zeros(system.rest.shape)
        way = (ahead - behind)[:, : system.dim] / (2 * share)
        for kernel, known in zip(rows, symmetric):
            after, before = (kernel.evaluate(system.configuration(end), lam, 1).gradient for end in (ahead, behind))
            assert after is not None and before is not None
            change = (after - before) / (2 * share) - hessian_product(kernel, known, way[kernel.conn])
            np.add.at(total, kernel.conn, change)
        if system.grips is not None:
            system.grips.carry(total, u)
        return system.reduce(total)

    size = len(first)
    whole = LinearOperator((size, size), matvec=lambda v: v + factor.solve(skew(v)), dtype=float)
    found, _ = gmres(whole, first, rtol=EXACT, restart=SOLUTIONS, maxiter=1)
    return np.asarray(found)
