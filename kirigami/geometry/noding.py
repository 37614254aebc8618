"""Noding with a tolerance: line work in, a planar graph out in which nothing crosses, touches or nearly does.

Mesh generators need line work that meets only in shared end points. Drawings are not like that: cuts cross, end on one
another, miss by a rounding error or lie on top of each other. Three rules, repeated until none applies, repair it all:

1. points closer than the tolerance become one point;
2. a point that an edge passes closer than half the tolerance becomes a point of that edge;
3. two edges that cross are split at the crossing.

What was drawn first stays where it is: the end of a cut moves onto the outline that it almost reaches, and the outline
remains straight. Every new point is farther than the tolerance from all others, which bounds their number; and with
half the tolerance in rule 2, no flat triangle can ask for each of two sides to be led over the other, which would never
end.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.errors import GeometryError

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

GRID = 2.0**-40  # coordinates are rounded to this: equal drawings in different units then give equal meshes
MAX_ROUNDS = 60  # ordinary drawings need two to six


def node_lines(points: Floats, edges: Integers, tolerance: float) -> tuple[Floats, Integers]:
    """Split and snap edges until they meet in shared end points only.

    Parameters
    ----------
    points : ndarray, shape (p, 2)
        Coordinates, about one in size.
    edges : ndarray of int, shape (e, 3 or more)
        Start point, end point and owner of each edge; further columns are carried along. Edges may coincide.
    tolerance : float
        Distance below which points become one; a point and an edge touch below half of it.

    Returns
    -------
    points, edges
        The same arrays for the planar graph; points without an edge are left out. An edge that was drawn more than once
        appears as often, in the direction in which it was drawn: what winds round a place still does so.

    Raises
    ------
    GeometryError
        If the rules do not come to an end, which only line work far denser than the tolerance can cause.

    Examples
    --------
    >>> import numpy as np
    >>> from kirigami.geometry.noding import node_lines
    >>> cross = np.array([(0.0, 0.5), (1.0, 0.5), (0.5, 0.0), (0.5, 1.0)])
    >>> points, edges = node_lines(cross, np.array([(0, 1, 0), (2, 3, 1)]), 1e-5)
    >>> len(points), len(edges)
    (5, 4)
    """
    points = np.round(points / GRID) * GRID
    for _ in range(MAX_ROUNDS):
        points, edges = _merge_points(points, edges, tolerance)
        lines, line_rank, line_of_edge = _lines(edges)
        rank = _point_ranks(len(points), edges)
        split_line, split_point = _points_on_lines(points, lines, 0.5 * tolerance)
        if split_line.size:
            points = _moved_onto_lines(points, lines, split_line, split_point, rank[split_point], line_rank)
        else:
            points, split_line, split_point = _crossings(points, lines)
        if not split_line.size:
            return points, edges
        edges = _split(points, edges, lines, line_of_edge, split_line, split_point)
    raise GeometryError(
        f"the cuts are too dense to be told apart: they still touch after {MAX_ROUNDS} rounds of snapping at "
        f"{tolerance:g} of the size of the sheet; simplify the drawing or lower `snap`"
    )


def _merge_points(points: Floats, edges: Integers, tolerance: float) -> tuple[Floats, Integers]:
    # Coarse first: one point per small cell bounds the number of close pairs in densely sampled curves.
    cells = np.round(points / (0.25 * tolerance))
    _, first, cell = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    target = first[cell.ravel()]
    edges = np.column_stack([target[edges[:, :2]], edges[:, 2:]])
    kept = np.unique(edges[:, :2])
    order = np.empty(len(points), np.int64)  # the order in which points were drawn
    order[np.lexsort([np.arange(len(points)), _point_ranks(len(points), edges)])] = np.arange(len(points))
    geometry = shapely.points(points[kept])
    left, right = shapely.STRtree(geometry).query(geometry, predicate="dwithin", distance=tolerance)
    left, right = kept[left], kept[right]
    later = order[right] < order[left]
    earlier: dict[int, list[int]] = {}
    for point, other in zip(left[later].tolist(), right[later].tolist(), strict=True):
        earlier.setdefault(point, []).append(other)
    replace = np.arange(len(points))
    for point in sorted(earlier, key=order.__getitem__):
        stays = [other for other in earlier[point] if replace[other] == other]
        if stays:  # a chain of close points thins out instead of collapsing into one
            replace[point] = min(stays, key=lambda other: (float(np.hypot(*(points[other] - points[point]))), other))
    merged = np.column_stack([replace[edges[:, :2]], edges[:, 2:]])
    merged = merged[merged[:, 0] != merged[:, 1]]
    used, index = np.unique(merged[:, :2], return_inverse=True)
    return points[used], np.column_stack([index.reshape(-1, 2), merged[:, 2:]])


def _point_ranks(count: int, edges: Integers) -> Integers:
    """Lowest owner of the edges at each point."""
    rank = np.full(count, np.iinfo(np.int64).max)
    for end in (0, 1):
        np.minimum.at(rank, edges[:, end], edges[:, 2])
    return rank


def _lines(edges: Integers) -> tuple[Integers, Integers, Integers]:
    """Distinct edges as pairs in ascending order, the lowest owner of each, and the line of every edge."""
    lines, index = np.unique(np.sort(edges[:, :2], axis=1), axis=0, return_inverse=True)
    rank = np.full(len(lines), np.iinfo(np.int64).max)
    np.minimum.at(rank, index.ravel(), edges[:, 2])
    return lines, rank, index.ravel()


def _points_on_lines(points: Floats, lines: Integers, distance: float) -> tuple[Integers, Integers]:
    tree = shapely.STRtree(shapely.linestrings(points[lines]))
    point, line = tree.query(shapely.points(points), predicate="dwithin", distance=distance)
    apart = (lines[line] != point[:, None]).all(axis=1)
    return line[apart], point[apart]


def _moved_onto_lines(
    points: Floats, lines: Integers, line: Integers, point: Integers, rank: Integers, line_rank: Integers
) -> Floats:
    """Points moved onto the first-drawn of the lines they touch, if that was drawn before them."""
    moving = np.flatnonzero(line_rank[line] < rank)
    moving = moving[np.lexsort([line_rank[line[moving]], point[moving]])]
    which, first = np.unique(point[moving], return_index=True)
    start, end = points[lines[line[moving[first]]]].transpose(1, 0, 2)
    along = np.einsum("ij,ij->i", points[which] - start, end - start) / np.einsum("ij,ij->i", end - start, end - start)
    moved: Floats = points.copy()
    moved[which] = np.round((start + along[:, None] * (end - start)) / GRID) * GRID
    return moved


def _crossings(points: Floats, lines: Integers) -> tuple[Floats, Integers, Integers]:
    geometry = shapely.linestrings(points[lines])
    one, other = shapely.STRtree(geometry).query(geometry, predicate="crosses")
    once = one < other
    one, other = one[once], other[once]
    place = shapely.intersection(geometry[one], geometry[other])
    new_points = np.round(np.column_stack([shapely.get_x(place), shapely.get_y(place)]) / GRID) * GRID
    number = len(points) + np.arange(len(one))
    return np.concatenate([points, new_points]), np.concatenate([one, other]), np.concatenate([number, number])


def _split(
    points: Floats,
    edges: Integers,
    lines: Integers,
    line_of_edge: Integers,
    split_line: Integers,
    split_point: Integers,
) -> Integers:
    """Replace each split line by the chain through its points, for every owner."""
    start = points[lines[split_line, 0]]
    along = np.einsum("ij,ij->i", points[split_point] - start, points[lines[split_line, 1]] - start)
    chains: dict[int, list[int]] = {}
    for index in np.lexsort([split_point, along]):
        chains.setdefault(int(split_line[index]), []).append(int(split_point[index]))
    is_split = np.isin(line_of_edge, split_line)
    pieces: list[list[int]] = []
    for line, (begin, end, *rest) in zip(line_of_edge[is_split].tolist(), edges[is_split].tolist(), strict=True):
        chain = [min(begin, end), *chains[line], max(begin, end)]
        if begin > end:
            chain.reverse()
        pieces.extend([one, two, *rest] for one, two in pairwise(chain))
    return np.concatenate([edges[~is_split], np.array(pieces, dtype=np.int64)])
