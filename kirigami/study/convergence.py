"""Limits of values on finer and finer meshes: f(h) = f0 + c h^p (Richardson, 1911; Roache, 1998)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kirigami.primitives.kernel import Array

ORDERS = (0.3, 4.0)  # observed orders that make sense


def observed_order(sizes: Sequence[float] | Array, values: Sequence[float] | Array) -> float:
    """Order p of three values f0 + c h^p at decreasing sizes h; nan where they have none between 0.3 and 4.

    Examples
    --------
    >>> from kirigami.study.convergence import observed_order
    >>> round(observed_order([3.0, 2.0, 1.0], [10.0, 5.0, 2.0]), 10)
    2.0
    >>> observed_order([3.0, 2.0, 1.0], [1.0, 2.0, 1.5])
    nan
    """
    from scipy.optimize import brentq

    h, f = np.asarray(sizes, dtype=float), np.asarray(values, dtype=float)
    first, second = f[1] - f[0], f[2] - f[1]
    if not first * second > 0:
        return float("nan")

    def mismatch(p: float) -> float:
        return float((h[0] ** p - h[1] ** p) / (h[1] ** p - h[2] ** p) - first / second)

    low, high = ORDERS
    if mismatch(low) * mismatch(high) > 0:
        return float("nan")
    return float(brentq(mismatch, low, high))


def limit_of(sizes: Sequence[float] | Array, values: Sequence[float] | Array) -> tuple[float, float, float]:
    """Limit of values at decreasing sizes, its order by the last three, and how far the last value is from its limit.

    Without an order the limit is the last value itself, and the distance is its last change as if of order one.

    Examples
    --------
    >>> from kirigami.study.convergence import limit_of
    >>> [round(number, 9) for number in limit_of([3.0, 2.0, 1.0], [10.0, 5.0, 2.0])]
    [1.0, 2.0, 1.0]
    """
    h, f = np.asarray(sizes, dtype=float), np.asarray(values, dtype=float)
    order = observed_order(h[-3:], f[-3:])
    if np.isnan(order):
        return float(f[-1]), order, float(abs(f[-1] - f[-2]) / (h[-2] / h[-1] - 1))
    limit = float(f[-1] + (f[-1] - f[-2]) / ((h[-2] / h[-1]) ** order - 1))
    return limit, order, abs(float(f[-1]) - limit)
