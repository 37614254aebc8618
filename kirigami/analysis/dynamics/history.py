"""Time histories: the load factor as a function of time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_finite, shown
from kirigami.primitives.kernel import Array

NEAR = 1e-3  # share of a time step over which the rate of a function is taken
SAMPLES = 257  # times at which a function is told from another one


class History:
    """The load factor over time.

    Parameters
    ----------
    given : float, callable, or array_like, shape (k, 2)
        One value from the beginning; a function of time; or a table of times, in order, and values, linear between
        them and constant beyond.

    Attributes
    ----------
    times : ndarray
        Times of the table, where the rate may jump; empty otherwise.
    """

    def __init__(self, given: float | Callable[[float], float] | ArrayLike, owner: str) -> None:
        self._function: Callable[[float], Any] | None = None
        self.times, self._values = np.empty(0), np.empty(0)
        self._owner = owner
        if callable(given):
            self._function = given
        elif isinstance(given, (int, float, np.number)):
            self._constant = require_finite(given, "load", owner)
        else:
            table = require_array(given, (None, 2), name="load", owner=owner)
            if np.any(np.diff(table[:, 0]) <= 0):
                raise ModelError(f"{owner}: load must be a table of growing times and factors, got {shown(given)}")
            self.times, self._values = table.T.copy()

    def at(self, time: float) -> float:
        """The load factor at a time."""
        if self._function is not None:
            return require_finite(self._function(time), f"load at time {time:.6g}", self._owner)
        return float(np.interp(time, self.times, self._values)) if len(self.times) else self._constant

    def rate(self, time: float, step: float) -> float:
        """Its change with time; at a corner of a table the mean of both sides, and at time 0 that of what comes."""
        if self._function is None and not len(self.times):
            return 0.0
        near = NEAR * step
        before = max(time - near, 0.0)
        return (self.at(time + near) - self.at(before)) / (time + near - before)

    def memorable(self, end: float) -> Array:
        """Values that tell it from another one."""
        return np.array([self.at(time) for time in np.linspace(0.0, end, SAMPLES)])
