"""Time histories: load factors as functions of time, the common one and those that objects have of their own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_finite, shown
from kirigami.primitives.kernel import Array

NEAR = 1e-3  # share of a time step over which the rate of a function is taken
SAMPLES = 257  # times at which a function is told from another one


class History:
    """A load factor over time.

    Parameters
    ----------
    given : float, callable, or array_like, shape (k, 2)
        One value from the beginning; a function of time; or a table of times, in order, and values, linear between
        them and constant beyond.
    name, owner : str
        What it is and whose, for messages.

    Attributes
    ----------
    times : ndarray
        Times of the table, where the rate may jump; empty otherwise.
    """

    def __init__(self, given: float | Callable[[float], float] | ArrayLike, name: str, owner: str) -> None:
        self._function: Callable[[float], Any] | None = None
        self.times, self._values = np.empty(0), np.empty(0)
        self._name, self._owner = name, owner
        if callable(given):
            self._function = given
        elif isinstance(given, (int, float, np.number)):
            self._constant = require_finite(given, name, owner)
        else:
            table = require_array(given, (None, 2), name=name, owner=owner)
            if np.any(np.diff(table[:, 0]) <= 0):
                raise ModelError(f"{owner}: {name} must be a table of growing times and factors, got {shown(given)}")
            self.times, self._values = table.T.copy()

    def at(self, time: float) -> float:
        """The load factor at a time."""
        if self._function is not None:
            return require_finite(self._function(time), f"{self._name} at time {time:.6g}", self._owner)
        return float(np.interp(time, self.times, self._values)) if len(self.times) else self._constant

    def rate(self, time: float, step: float) -> float:
        """Its change with time; at a corner of a table the mean of both sides, and at time 0 that of what comes."""
        if self._function is None and not len(self.times):
            return 0.0
        near = NEAR * step
        if time < near:
            now, soon, later = (self.at(time + k * near) for k in range(3))
            return (4 * soon - 3 * now - later) / (2 * near)
        return (self.at(time + near) - self.at(time - near)) / (2 * near)

    def memorable(self, end: float) -> Array:
        """Values that tell it from another one."""
        return np.array([self.at(time) for time in np.linspace(0.0, end, SAMPLES)])


class Histories:
    """The load factor and those of the objects that have their own, over time: arrays (1 + k,)."""

    def __init__(self, histories: Sequence[History]) -> None:
        self._histories = histories

    def at(self, time: float) -> Array:
        """The factors at a time."""
        return np.array([history.at(time) for history in self._histories])

    def rate(self, time: float, step: float) -> Array:
        """Their changes with time."""
        return np.array([history.rate(time, step) for history in self._histories])

    @property
    def times(self) -> Array:
        """Times, in order, where a rate may jump."""
        return np.unique(np.concatenate([history.times for history in self._histories]))
