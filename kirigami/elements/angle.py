"""What all members that resist an angle share: unwrapping against the last committed state, and a linear law."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kirigami.primitives.kernel import Array, Kernel

TURN = 2 * math.pi


class AngleKernel(Kernel):
    """Base of hinges and springs: a subclass measures the raw angle, this class counts its turns.

    The angle is unwrapped against the last committed state, so it may pass any number of turns.
    """

    approximates = True
    stiffness: Array
    rest_angle: Array
    _initial: Array
    _committed: Array

    def _begin(self, initial: Array, rest_angle: Array) -> None:
        """Start from the angles of the rest state; nan among the rest angles takes them over."""
        self._initial = initial
        self._committed = initial.copy()
        self.rest_angle = np.where(np.isnan(rest_angle), initial, rest_angle)

    def unwrap(self, angle: Array) -> Array:
        """The value of a raw angle, known up to whole turns, that lies nearest to the committed one.

        Whole turns are added, so that the same raw angle gives the same value to the last digit: a structure at rest
        has moments of exactly zero.
        """
        unwrapped: Array = angle + TURN * np.round((self._committed - angle) / TURN)
        return unwrapped

    @property
    def history(self) -> Array | None:
        return self._committed

    @history.setter
    def history(self, value: Array | None) -> None:
        self._committed = self._initial.copy() if value is None else np.array(value, dtype=float)

    def commit(self, x: Array) -> None:
        self._committed = self.deformation(x)

    def arrays(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("conn", "stiffness", "rest_angle", "members")}

    def deformation(self, x: Array) -> Array:
        """Unwrapped angle of each member (n,) [rad]."""
        raise NotImplementedError

    def force(self, angle: Array) -> Array:
        """Moment of each member (n,), positive where the angle is above its rest value."""
        return self.stiffness * (angle - self.rest_angle)
