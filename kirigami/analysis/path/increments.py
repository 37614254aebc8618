"""Increments of the path parameter: first size, growth, cutbacks, exact hits of targets."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from kirigami.analysis.path.points import Attempt
from kirigami.primitives.checks import require_array

WANTED_ITERATIONS = 6  # increments grow or shrink towards this many corrections
SHORT = 0.02  # share of the largest increment below which one counts as short
DRIFT_WANTED = 0.05  # turn of a member by which corrections leave the prediction: steers the increments [rad]


class Increments:
    """Increments of the parameter: first size, growth, cutbacks, and exact hits of targets."""

    def __init__(
        self, first: float, largest: float, smallest: float, targets: Sequence[float] = (), origin: float = 0.0
    ) -> None:
        self.size, self.largest, self.smallest = abs(first), abs(largest), abs(smallest)
        self.targets = list(targets)  # in the order they are met; the last one ends the walk
        self.first, self.leg = self.size, origin  # where the way last turned
        stations = [origin, *self.targets]
        self.longest = max(stations) - min(stations)
        self.sense = 0.0
        self.at_turns = float("inf")  # largest size where the way turns
        self.least_growth, self.growth_after_snap = 0.5, 1.0

    def next_increment(self, value: float) -> float | None:
        """Signed increment from the parameter `value`, or None at the end."""
        if not self.targets:
            return self.size
        while self.targets and abs(self.targets[0] - value) <= 1e-12 * max(abs(self.targets[0]), abs(value)):
            if len(self.targets) == 1:
                return None
            self.targets.pop(0)
        remaining = self.targets[0] - value
        if np.sign(remaining) != self.sense:
            self.sense, self.leg = float(np.sign(remaining)), value
            self.size = min(self.size, self.at_turns)
        if abs(remaining) <= 1.0001 * self.size:
            return remaining
        if abs(remaining) < 2 * self.size:  # two even increments instead of a whole one and a splinter
            return 0.5 * remaining
        return self.sense * self.size

    def cut(self, increment: float) -> float | None:
        """A shorter increment after a failure, or None if it was the shortest."""
        if abs(increment) <= self.smallest:
            return None
        self.size = max(0.35 * abs(increment), self.smallest)
        return float(np.sign(increment)) * self.size

    def is_short(self, increment: float) -> bool:
        """Whether an increment is far below the largest allowed."""
        return abs(increment) < SHORT * self.largest

    def adapt(self, increment: float, attempt: Attempt) -> None:
        """Next size from how hard the last increment was, and how far the corrections led away from the prediction."""
        growth = (WANTED_ITERATIONS / max(attempt.iterations, 1)) ** 1.5
        if attempt.relaxed:
            growth = self.growth_after_snap
        elif attempt.drift > 0:
            growth = min(growth, (DRIFT_WANTED / attempt.drift) ** 0.5)  # the drift grows with the square
        self.resize(increment, float(np.clip(growth, self.least_growth, 2.5)))

    def resize(self, increment: float, growth: float) -> None:
        """Next size as a multiple of the increment just made."""
        # A short increment that only served to hit a target says nothing about the size to go on with.
        base = abs(increment) if growth < 1 or abs(increment) > 0.99 * self.size else self.size
        self.size = min(max(base * growth, self.smallest), self.largest)

    def progress(self, value: float) -> float | None:
        """Share of the work done, where the end is known: of the way or, in a careful walk, of its increments."""
        if not self.targets:
            return None
        ahead = self._work([self.leg, *self.targets]) - self._work([self.leg, value])
        return min(max(1.0 - ahead / self._whole, 0.0), 1.0) if self._whole else 1.0

    @cached_property
    def _whole(self) -> float:
        return self._work([self.leg, *self.targets])

    def _work(self, stations: Sequence[float]) -> float:
        """Work from station to station, there and back, in a unit of its own."""
        places = np.array(stations)
        turns = np.flatnonzero(np.diff(np.sign(np.diff(places))) != 0) + 1
        legs = np.abs(np.diff(places[[0, *turns, -1]]))
        careful = 0 < self.at_turns < np.inf
        return float(np.log1p(legs / self.at_turns).sum() if careful else legs.sum())


def checked_targets(targets: ArrayLike | None, owner: str) -> list[float]:
    """Targets as numbers in the order given, which is the order in which they are met."""
    if targets is None:
        return []
    if isinstance(targets, (list, tuple)) and not targets:
        return []
    values: list[float] = np.atleast_1d(require_array(targets, (), (None,), name="targets", owner=owner)).tolist()
    return values
