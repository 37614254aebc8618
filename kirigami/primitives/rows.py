"""Rows of unknowns that stand behind the nodes: what an element needs beside its corners, out of the user's sight."""

from __future__ import annotations

from dataclasses import dataclass, field

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
        Nodes of each edge, the lower first, or those that repeat the ends of another one in the order of these: the
        direction in which it counts angles.
    edge : ndarray of int, shape (m, 3)
        Edges 01, 12 and 20 of each facet.
    middle : ndarray of int, shape (edges,)
        Row of the offset of each edge's middle from the mean of its ends.
    angle : ndarray of int, shape (m, 3)
        Row of the angles of each facet's edges; facets share it, but for those on the two sides of a crease.
    length : ndarray, shape (edges,)
        Length of each edge at rest, which is what turns stored angles into radians.
    seams : ndarray of int, shape (s, 2)
        Edges on the border of a periodic cell that repeat another one, and that one.
    """

    triangles: Index
    ends: Index
    edge: Index
    middle: Index
    angle: Index
    length: Array
    seams: Index = field(default_factory=lambda: np.empty((0, 2), np.int64))

    @property
    def forward(self) -> NDArray[np.bool_]:
        """Whether each facet (m, 3) runs along its edge in the edge's own direction."""
        return np.asarray(self.triangles == self.ends[self.edge, 0])

    @property
    def seam_angles(self) -> Index:
        """Rows of angles (s, 2) of the edges that repeat another one, and of these."""
        row = np.zeros(len(self.ends), np.int64)
        row[self.edge] = self.angle
        return np.asarray(row[self.seams])

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
