"""Rows of unknowns that stand behind the nodes: what an element needs beside its corners, out of the user's sight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.kernel import Array

Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class EdgeRows:
    """The rows that belong to the edges of shell facets.

    Attributes
    ----------
    triangles : ndarray of int, shape (m, 3)
        Corners of the facets.
    ends : ndarray of int, shape (edges, 2)
        Nodes of each edge, the lower first: the direction in which it counts angles.
    edge : ndarray of int, shape (m, 3)
        Edges 01, 12 and 20 of each facet.
    middle : ndarray of int, shape (edges,)
        Row of the offset of each edge's middle from the mean of its ends.
    angle : ndarray of int, shape (m, 3)
        Row of the angles of each facet's edges; facets share it, but for those on the two sides of a crease.
    length : ndarray, shape (edges,)
        Length of each edge at rest, which is what turns stored angles into radians.
    """

    triangles: Index
    ends: Index
    edge: Index
    middle: Index
    angle: Index
    length: Array

    @property
    def forward(self) -> NDArray[np.bool_]:
        """Whether each facet (m, 3) runs along its edge in the edge's own direction."""
        return np.asarray(self.triangles < np.roll(self.triangles, -1, axis=1))

    def turn(self, x: Array, rate: Array, field: Array) -> None:
        """Write into `field` (rows, 3) what a rotation with the vector `rate` (3,) changes in these rows at `x`."""
        chord, offset = x[self.ends[:, 1]] - x[self.ends[:, 0]], x[self.middle]
        field[self.middle] = np.cross(rate, offset)
        edge, row = self.pairs
        for point, slope in enumerate((4 / np.sqrt(3), -4 / np.sqrt(3))):  # of the middle's hump at the Gauss points
            tangent = chord + slope * offset
            tangent /= np.linalg.norm(tangent, axis=1)[:, None]
            field[row, point] = -(self.length * (tangent @ rate))[edge]

    @property
    def pairs(self) -> tuple[Index, Index]:
        """Edges and angle rows that belong together, each pair once."""
        both = np.unique(np.stack([self.edge.ravel(), self.angle.ravel()], axis=1), axis=0)
        return both[:, 0], both[:, 1]


@dataclass(frozen=True, eq=False)
class GripRows:
    """The rows that move as one rigid body, and the two that say how: they follow, and are no unknowns.

    Attributes
    ----------
    points, vectors : ndarray of int, shape (k,) and (m,)
        Rows that are positions, and rows that are differences of positions, which turn but do not shift.
    arms : ndarray, shape (k + m, 3)
        What they hold at rest, the positions against their centroid.
    shift : int
        Row of the displacement of the centroid.
    turn : int
        Row of the rotation vector times `radius`; in a plane its first number is the angle times `radius`.
    radius : float
        Root mean square of the arms of the points [length].
    """

    points: Index
    vectors: Index
    arms: Array
    shift: int
    turn: int
    radius: float

    @property
    def followers(self) -> Index:
        """All rows that follow."""
        return np.concatenate([self.points, self.vectors])
