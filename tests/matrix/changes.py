"""Ways to state one problem differently: turned, mirrored, renumbered, in other units."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rotation(axis: tuple[float, float, float], degrees: float) -> Array:
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    turn, cross = np.radians(degrees), np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(turn) * cross + (1 - np.cos(turn)) * cross @ cross


@dataclass(frozen=True)
class Change:
    """A problem stated differently.

    ``turn`` (3, 3) takes vectors over, ``length`` and ``force`` are the sizes of the old units in the new ones, and
    ``shuffle`` says whether nodes, facets and members are numbered anew.
    """

    turn: Array = field(default_factory=lambda: np.eye(3))
    length: float = 1.0
    force: float = 1.0
    shuffle: bool = False
    flat: bool = True  # a drawing stays in its plane, and its axes stay axes

    @property
    def mirrors(self) -> bool:
        return bool(np.linalg.det(self.turn) < 0)

    def order(self, count: int) -> NDArray[np.int64]:
        """Which old item stands at each new place."""
        return np.random.default_rng(count).permutation(count) if self.shuffle else np.arange(count)

    def places(self, points: Array) -> Array:
        """Positions or displacements (..., 3), in the old order."""
        return np.asarray(self.length * points @ self.turn.T)

    def forces(self, vectors: Array) -> Array:
        return np.asarray(self.force * vectors @ self.turn.T)

    def axis(self, letter: str) -> str:
        """Where an axis goes to."""
        return "xyz"[int(np.abs(self.turn[:, "xyz".index(letter)]).argmax())]


CHANGES = {
    "quarter turn": Change(turn=np.round(rotation((0, 0, 1), 90))),
    "turned in space": Change(turn=rotation((1, 2, 3), 40), flat=False),
    "mirrored": Change(turn=np.diag([-1.0, 1.0, 1.0])),
    "renumbered": Change(shuffle=True),
    "millimetres": Change(length=1e3),
    "kilonewtons": Change(force=1e-3),
}
