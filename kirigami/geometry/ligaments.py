"""The ligaments of a drawing: where the sheet is narrow between cuts, rims and holes, and how narrow.

A ligament is told by the empty circle that has it as its diameter: two points of the line work that see each other
through the sheet, with nothing nearer to the middle between them than they are. These are the waists of the sheet and
all cross sections of its bands, and they are the edges of a Gabriel graph (Gabriel and Sokal, 1969), so they are found
among the edges of a Delaunay triangulation of densely divided line work.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.geometry.clean import LineWork
from kirigami.geometry.triangulate import Triangulation, carve, triangulate

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

PIECE = 0.5  # longest piece of the divided line work over the distance to what lies opposite
DIAMETRAL = 0.94  # least distance from the middle to the line work, over half of the length across
ROUND = 4.0  # two points nearer along the line work than so many widths are sides of a corner or a short tongue
ROUNDS = 20
SMALLEST_PIECE = 1e-5  # of the size of the sheet


@dataclass(frozen=True, eq=False)
class Ligaments:
    """Sections across the narrow places of a sheet, in the unit frame of its drawing.

    Attributes
    ----------
    ends : ndarray, shape (k, 2, 2)
        The two points of the line work at the ends of each section.
    widths : ndarray, shape (k,)
        Diameter of the empty circle in the middle of each.
    """

    ends: Floats
    widths: Floats


def find_ligaments(drawing: LineWork) -> Ligaments:
    """Sections across every ligament of a drawing, about two per width along bands.

    Parameters
    ----------
    drawing : LineWork
        What `kirigami.geometry.clean.clean` returns; lines that are not cut do not bound ligaments.

    Examples
    --------
    >>> import numpy as np, shapely
    >>> from kirigami.geometry.ligaments import find_ligaments
    >>> from kirigami.geometry.clean import clean
    >>> slits = [shapely.LineString([(1, 2), (4.5, 2)]), shapely.LineString([(5.5, 2), (9, 2)])]
    >>> found = find_ligaments(clean(shapely.box(0, 0, 10, 4), slits))
    >>> np.unique((found.widths * 10).round(6)).tolist()  # beside and between the slits, and above and below
    [1.0, 2.0]
    """
    cut = drawing.label_separates[drawing.labels]
    lines = _Lines(drawing.points, drawing.edges[cut], drawing.is_boundary[cut])
    lines.divide()
    bare = Triangulation(lines.points, np.empty((0, 3), np.int64), lines.pieces, lines.owner)
    made = triangulate(bare, drawing.mesher)
    made = carve(made, lines.pieces[lines.is_boundary[lines.owner]])
    sections = _sections(made.triangles, lines.pieces)
    across, widths = lines.empty_circles(sections)
    sections, widths = sections[across], widths[across]
    far = lines.far_apart(sections, widths)
    return Ligaments(lines.points[sections[far]], widths[far])


def _sections(triangles: Integers, pieces: Integers) -> Integers:
    """Edges of a triangulation that are no pieces of the line work, as pairs in ascending order."""
    ends = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges = np.unique(ends, axis=0)
    count = int(edges.max()) + 1
    drawn = np.sort(pieces, axis=1)
    inner: Integers = edges[~np.isin(edges @ [count, 1], drawn @ [count, 1])]
    return inner


class _Lines:
    """The line work that bounds the sheet, divided into pieces."""

    def __init__(self, points: Floats, edges: Integers, is_boundary: NDArray[np.bool_]) -> None:
        self.corners, self.edges, self.is_boundary = points, edges, is_boundary
        self.geometry = shapely.linestrings(points[edges])
        self.tree = shapely.STRtree(self.geometry)
        self.points, self.pieces, self.owner = points, edges, np.arange(len(edges))

    def divide(self) -> None:
        """Divide until every piece is short against its distance from what it sees through the sheet."""
        limit = SMALLEST_PIECE
        count = np.ones(len(self.edges), np.int64)
        start = self.corners[self.edges[:, 0]]
        step = self.corners[self.edges[:, 1]] - start
        length = np.linalg.norm(step, axis=1)
        # pieces are kept as intervals of their edge, all of them at once
        owner, low, high = np.arange(len(count)), np.zeros(len(count)), np.ones(len(count))
        open_pieces = np.ones(len(owner), bool)
        for _ in range(ROUNDS):
            chosen = np.flatnonzero(open_pieces)
            if not chosen.size:
                break
            own = owner[chosen]
            begin, end = start[own] + low[chosen, None] * step[own], start[own] + high[chosen, None] * step[own]
            size = (high - low)[chosen] * length[own]
            near = self._distances(begin, end, own, size / PIECE)
            parts = np.ceil(np.minimum(size / (PIECE * near), size / limit) - 1e-9).clip(1, 4).astype(np.int64)
            open_pieces[chosen[parts == 1]] = False
            chosen, parts = chosen[parts > 1], parts[parts > 1]
            first = np.repeat(np.cumsum(parts) - parts, parts)
            place = np.arange(parts.sum()) - first
            width = np.repeat((high - low)[chosen] / parts, parts)
            new_low = np.repeat(low[chosen], parts) + place * width
            kept = np.setdiff1d(np.arange(len(owner)), chosen)
            owner = np.concatenate([owner[kept], np.repeat(owner[chosen], parts)])
            low, high = np.concatenate([low[kept], new_low]), np.concatenate([high[kept], new_low + width])
            open_pieces = np.concatenate([open_pieces[kept], np.ones(len(place), bool)])
        self._number(owner, low, start, step)

    def _number(self, owner: Integers, low: Floats, start: Floats, step: Floats) -> None:
        """Points and pieces of the divided edges."""
        order = np.lexsort([low, owner])
        owner, low = owner[order], low[order]
        inner = low > 0
        number = np.where(inner, len(self.corners) + np.cumsum(inner) - 1, self.edges[owner, 0])
        last = np.append(owner[1:] != owner[:-1], True)
        following = np.where(last, self.edges[owner, 1], np.append(number[1:], 0))
        own = owner[inner]
        self.points = np.concatenate([self.corners, start[own] + low[inner, None] * step[own]])
        self.pieces, self.owner = np.column_stack([number, following]), owner

    def _distances(self, begin: Floats, end: Floats, own: Integers, reach: Floats) -> Floats:
        """Distance from each piece to the nearest edge that it sees through the sheet, infinite beyond its reach."""
        geometry = shapely.linestrings(np.stack([begin, end], axis=1))
        piece, edge = self.tree.query(geometry, predicate="dwithin", distance=reach)
        ends = self.edges[own[piece]]
        meets = (ends[:, :, None] == self.edges[edge][:, None, :]).any(axis=(1, 2))
        piece, edge = piece[~meets], edge[~meets]
        joined = shapely.get_coordinates(shapely.shortest_line(geometry[piece], self.geometry[edge])).reshape(-1, 2, 2)
        middle = joined.mean(axis=1)
        seen = self._at_sheet_side(middle, own[piece]) & self._at_sheet_side(middle, edge)
        nearest = np.full(len(geometry), np.inf)
        np.minimum.at(nearest, piece[seen], np.linalg.norm(joined[:, 1] - joined[:, 0], axis=1)[seen])
        return nearest

    def _at_sheet_side(self, points: Floats, edge: Integers) -> NDArray[np.bool_]:
        """Whether each point lies where its edge has the sheet: at the left of a boundary, anywhere beside a slit."""
        begin, end = self.corners[self.edges[edge, 0]], self.corners[self.edges[edge, 1]]
        along, off = end - begin, points - begin
        left: NDArray[np.bool_] = along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0] > 0
        return left | ~self.is_boundary[edge]

    def empty_circles(self, sections: Integers) -> tuple[NDArray[np.bool_], Floats]:
        """Which sections are diameters of circles without line work inside, and the diameters."""
        ends = self.points[sections]
        middle = shapely.points(ends.mean(axis=1))
        if not len(sections):
            return np.zeros(0, bool), np.zeros(0)
        (index, _), distance = self.tree.query_nearest(middle, return_distance=True, all_matches=False)
        radius = np.empty(len(sections))
        radius[index] = distance
        half = 0.5 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        return (radius >= DIAMETRAL * half) & ~self._meet(sections), 2 * radius

    def _meet(self, sections: Integers) -> NDArray[np.bool_]:
        """Whether the ends of each section lie on edges with a common end: such a pair is a corner."""
        corners_of: list[set[int]] = [set() for _ in self.points]
        for (begin, end), own in zip(self.pieces.tolist(), self.owner.tolist(), strict=True):
            corners_of[begin].update(self.edges[own].tolist())
            corners_of[end].update(self.edges[own].tolist())
        inner = len(self.corners)
        for corner in range(min(inner, len(self.points))):
            corners_of[corner] = {corner}  # a corner lies on many edges: only the next corners would be too near
        return np.array([not corners_of[i].isdisjoint(corners_of[j]) for i, j in sections.tolist()], bool)

    def far_apart(self, sections: Integers, widths: Floats) -> NDArray[np.bool_]:
        """Whether the way along the line work between the ends of each section is long against its width."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import dijkstra

        length = np.linalg.norm(self.points[self.pieces[:, 1]] - self.points[self.pieces[:, 0]], axis=1)
        graph = coo_array((length, tuple(self.pieces.T)), shape=(len(self.points),) * 2).tocsr()
        far = np.ones(len(sections), bool)
        for number, (begin, end) in enumerate(sections.tolist()):
            limit = ROUND * float(widths[number])
            far[number] = not np.isfinite(dijkstra(graph, directed=False, indices=begin, limit=limit)[end])
        return far
