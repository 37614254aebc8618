"""The lines of a drawing as a planar graph: its connected pieces, the faces they enclose and their outer rims."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.drawing.curves import Floats
from kirigami.geometry.noding import node_lines
from kirigami.geometry.topology import pair_numbers

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Network:
    """Lines split where they meet.

    Attributes
    ----------
    points : ndarray, shape (p, 2)
    pairs : ndarray of int, shape (e, 2)
        Edges, each once, in ascending order.
    owners : ndarray of int, shape (k, 2)
        Line and edge, for every edge that a line runs along.
    """

    points: Floats
    pairs: Integers
    owners: Integers

    @cached_property
    def component(self) -> Integers:
        """Number of the connected piece of each edge."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        count = len(self.points)
        graph = coo_array((np.ones(len(self.pairs), np.int8), self.pairs.T), shape=(count, count))
        piece: Integers = connected_components(graph, directed=False)[1].astype(np.int64)
        return piece[self.pairs[:, 0]]

    def lines(self, edges: Any) -> Any:
        """Some edges as LineStrings."""
        return shapely.linestrings(self.points[self.pairs[edges]])

    def faces(self, edges: Any) -> list[Any]:
        """The bounded faces between some edges, largest first; holes in them where other edges lie inside."""
        found = shapely.polygonize(self.lines(edges)).geoms
        return sorted(found, key=lambda face: -face.area)

    def ring(self, ring: Any) -> Integers:
        """The edges along a ring that is made of them."""
        numbers = self._number_of_point
        along = np.array([numbers[point] for point in map(tuple, shapely.get_coordinates(ring).tolist())])
        ends = np.column_stack([along[:-1], along[1:]])
        edges: Integers = np.unique(pair_numbers(ends, self.pairs, len(self.points)))
        return edges

    @cached_property
    def _number_of_point(self) -> dict[tuple[float, ...], int]:
        return {point: index for index, point in enumerate(map(tuple, self.points.tolist()))}

    def of_line(self, line: int) -> Integers:
        """Edges along a line."""
        edges: Integers = self.owners[self.owners[:, 0] == line, 1]
        return edges


def network(lines: Sequence[Floats], tolerance: float) -> Network:
    """Split lines where they cross, touch or come nearer than the tolerance.

    Parameters
    ----------
    lines : sequence of ndarray, shape (k, 2)
        Points along each line; those that come first stay where they are.
    tolerance : float
        Distance below which points become one; a point and a line touch below half of it.

    Examples
    --------
    >>> import numpy as np
    >>> from kirigami.drawing.network import network
    >>> cross = network([np.array([(0.0, 1.0), (2.0, 1.0)]), np.array([(1.0, 0.0), (1.0, 2.0)])], 1e-5)
    >>> len(cross.pairs), len(cross.of_line(0)), cross.faces(slice(None))
    (4, 2, [])
    """
    drawn = np.concatenate(lines)
    low = drawn.min(axis=0)
    size = float(np.ptp(drawn, axis=0).max()) or 1.0
    start = np.cumsum([0, *(len(line) for line in lines)])
    first = np.concatenate([np.arange(a, b - 1) for a, b in pairwise(start)])
    owner = np.repeat(np.arange(len(lines)), [len(line) - 1 for line in lines])
    edges = np.column_stack([first, first + 1, owner]).astype(np.int64)
    points, edges = node_lines((drawn - low) / size, edges, tolerance / size)
    pairs, index = np.unique(np.sort(edges[:, :2], axis=1), axis=0, return_inverse=True)
    owners = np.unique(np.column_stack([edges[:, 2], index.ravel()]), axis=0)
    return Network(_as_drawn(low + size * points, drawn, 1e-10 * size), pairs, owners)


def _as_drawn(points: Floats, drawn: Floats, reach: float) -> Floats:
    """Points, put back where they were drawn if only rounding has moved them."""
    from scipy.spatial import cKDTree

    distance, nearest = cKDTree(drawn).query(points)
    return np.where((distance <= reach)[:, None], drawn[nearest], points)
