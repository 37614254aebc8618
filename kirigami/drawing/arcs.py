"""Arcs of circles among the chords of curves: found where curves are read, put back where they are written."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.drawing.curves import Curve, Floats

ON = 1e-7  # of the radius: how far points of an arc may lie from its circle; files often hold seven digits
WIDEST = np.radians(46.0)  # of one chord of an arc


def circles_of(curves: Iterable[Curve]) -> Floats:
    """Centre and radius (k, 3) of every circle that smooth pieces of curves follow."""
    found: list[Floats] = []
    for curve in curves:
        if len(curve.points) < 3:
            continue
        bow = np.broadcast_to(curve.bow, len(curve.points) - 1)
        smooth = bow > 0
        if smooth.sum() < 2:
            continue
        start = 0
        while start < len(smooth) - 1:
            if not (smooth[start] and smooth[start + 1]):
                start += 1
                continue
            circle = _through(*curve.points[start : start + 3])
            end = start + 2
            while end < len(smooth) and smooth[end] and circle is not None and _on(curve.points[end + 1], circle):
                end += 1
            if circle is not None and end - start > 2:
                found.append(circle)
                start = end
            else:
                start += 1
    return _distinct(np.array(found).reshape(-1, 3))


def _through(a: Floats, b: Floats, c: Floats) -> Floats | None:
    """The circle through three points that do not lie in a line."""
    one, two = b - a, c - a
    cross = float(one[0] * two[1] - one[1] * two[0])
    lengths = float(one @ one), float(two @ two)
    if abs(cross) <= 1e-9 * max(lengths):
        return None
    off = np.array([two[1] * lengths[0] - one[1] * lengths[1], one[0] * lengths[1] - two[0] * lengths[0]]) / (2 * cross)
    return np.append(a + off, np.hypot(*off))


def _on(point: Floats, circle: Floats) -> bool:
    return bool(abs(np.hypot(*(point - circle[:2])) - circle[2]) <= 30 * ON * circle[2])


def _distinct(circles: Floats) -> Floats:
    """Each circle once."""
    if len(circles) < 2:
        return circles
    scale = float(np.abs(circles).max())
    _, first = np.unique(np.round(circles / (1e-6 * scale)), axis=0, return_index=True)
    return circles[np.sort(first)]


def bulges_of(lines: Sequence[Floats], circles: Floats) -> list[NDArray[np.float64]]:
    """For the chords of each line the tangent of a quarter of the angle that they span, 0 where they are straight.

    Parameters
    ----------
    lines : sequence of ndarray, shape (k, 2)
        Points; closed lines repeat the first.
    circles : ndarray, shape (c, 3)
        Centres and radii.

    Returns
    -------
    list of ndarray, shape (k - 1,)
        Positive counter-clockwise, as DXF has it.
    """
    counts = [len(line) for line in lines]
    bulges = [np.zeros(count - 1) for count in counts]
    if not len(circles) or not lines:
        return bulges
    points = np.concatenate(lines)
    tree = shapely.STRtree(shapely.points(points))
    line_of = np.repeat(np.arange(len(lines)), counts)
    start = np.cumsum([0, *counts])
    for x, y, radius in circles.tolist():
        near = tree.query(shapely.Point(x, y), predicate="dwithin", distance=radius * (1 + 1e-5))
        arm = points[near] - (x, y)
        near = np.sort(near[np.abs(np.hypot(*arm.T) - radius) <= 10 * ON * radius])
        both = near[:-1][(np.diff(near) == 1) & (line_of[near[:-1]] == line_of[near[1:]])]
        one, two = points[both] - (x, y), points[both + 1] - (x, y)
        angle = np.arctan2(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0], (one * two).sum(axis=1))
        for first, turn in zip(both.tolist(), angle.tolist()):
            if 0 < abs(turn) <= WIDEST:
                bulges[line_of[first]][first - start[line_of[first]]] = np.tan(turn / 4)
    return bulges


def merged(points: Floats, bulges: NDArray[np.float64]) -> tuple[Floats, NDArray[np.float64]]:
    """Chords of one arc after another as arcs of up to a third of a turn.

    Returns the points (k + 1, 2) and the bulges (k,).
    """
    kept, found = [0], []
    position = 0
    while position < len(bulges):
        end, angle = position + 1, 4 * np.arctan(bulges[position])
        if bulges[position]:
            circle = _circle(points[position], points[position + 1], bulges[position])
            while end < len(bulges) and bulges[end] * bulges[position] > 0:
                more = 4 * np.arctan(bulges[end])
                other = _circle(points[end], points[end + 1], bulges[end])
                if abs(angle + more) > 2.1 or np.abs(other - circle).max() > 1e-5 * circle[2]:
                    break
                angle, end = angle + more, end + 1
        found.append(float(np.tan(angle / 4)))
        kept.append(end)
        position = end
    return points[kept], np.array(found)


def _circle(start: Floats, end: Floats, bulge: float) -> Floats:
    chord = end - start
    normal = np.array([-chord[1], chord[0]])
    center = 0.5 * (start + end) + normal * (1 - bulge**2) / (4 * bulge)
    return np.append(center, np.hypot(*(start - center)))
