"""Rows that follow others: they are no unknowns, but filled in behind those that lead.

Each row that follows goes where its links take it: to the first order it moves by the sum of J du over its links, with
du the rows that lead. J is the unit matrix, or one of the `rates`. Rigid grips (:mod:`kirigami.primitives.grip_rows`)
and the borders of periodic cells (:mod:`kirigami.primitives.cell_rows`) are such.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.kernel import Array

Index = NDArray[np.int64]


class Links(NamedTuple):
    """Rows that follow (k,), rows that lead them (k,), and the J of each (k,): 0 is the unit matrix, 1 and on are the
    `rates`. A row may stand in several."""

    follower: Index
    lead: Index
    rate: Index


class FollowingRows(ABC):
    """Rows that follow, and how they do.

    Displacements and what is like them are arrays (rows, dim) of all rows of a system.
    """

    words = ""  # what it is, in messages
    remedy = ""  # what to do with a node that is tied to one of it
    one_of_many = False  # whether what is there stands for many beside each other

    @property
    @abstractmethod
    def followers(self) -> Index:
        """All rows that follow."""

    @property
    @abstractmethod
    def links(self) -> Links:
        """Which rows they follow."""

    @abstractmethod
    def rates(self, u: Array) -> Array:
        """The J (k, dim, dim) other than the unit matrix, at displacements."""

    @abstractmethod
    def fill(self, u: Array) -> None:
        """Put what follows in its place among displacements whose leading rows are known."""

    def follow(self, change: Array, about: Array) -> None:
        """The same for a small change of displacements, to first order `about` given ones."""
        follower, lead, rate = self.links
        change[self.followers] = 0.0
        np.add.at(change, follower, (self._matrices(about)[rate] @ change[lead][:, :, None])[:, :, 0])

    def carry(self, total: Array, u: Array, chord: Array | None = None) -> None:
        """Add forces on what follows to the rows that lead.

        With a `chord` (rows, dim) that ends at `u`, what they work on it is the same on both sides.
        """
        follower, lead, rate = self.links
        matrices = self._matrices(u)[rate]
        np.add.at(total, lead, (matrices.swapaxes(1, 2) @ total[follower][:, :, None])[:, :, 0])

    def curvature(self, u: Array, total: Array) -> tuple[int, Array] | None:
        """A row that leads, and the second derivative (dim, dim) by it of what the forces `total` work."""
        return None

    @abstractmethod
    def lead(self, field: Array, spin: Array, about: Array) -> None:
        """Write into a rigid motion with the given spin (3,) what moves the rows that lead."""

    @abstractmethod
    def settle(self, rows: Array) -> None:
        """Guess the rows that lead from the displacements of the nodes, and let the others follow."""

    @abstractmethod
    def lead_rates(self, field: Array, about: Array) -> None:
        """Write into velocities of what follows those of the rows that lead."""

    def led_freely(self, free: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which displacements follow one of those that are `free`."""
        follower, lead, rate = self.links
        found = np.zeros_like(free)
        any_of = np.asarray(free[lead].any(axis=1))
        moved = np.where((rate == 0)[:, None], free[lead], any_of[:, None])
        np.logical_or.at(found, follower, moved)
        return found

    def _matrices(self, u: Array) -> Array:
        """All J at displacements: the unit matrix, then the rates."""
        return np.concatenate([np.eye(u.shape[1])[None], self.rates(u)])
