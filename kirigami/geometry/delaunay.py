"""Constrained Delaunay triangulation of points and segments that meet in points only.

Qhull, by way of SciPy, makes the Delaunay triangulation; what it leaves out, because points lie closer than its
arithmetic resolves, is put in one by one (Lawson 1977), and segments that are missing are recovered by flips (Sloan
1993). All that decides is the sign of two determinants, exact here: what rounding may have turned is computed anew in
fractions (the error bounds are Shewchuk's, 1997). So no drawing that is clean can make it fail or run on.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import GeometryError
from kirigami.geometry.topology import pair_keys, paired_half_edges

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]
Point = tuple[Any, Any]

ROUNDING = 0.5 * np.finfo(float).eps
TURN_BOUND = (3.0 + 16.0 * ROUNDING) * ROUNDING  # of the sum of the sizes of both products
CIRCLE_BOUND = (10.0 + 96.0 * ROUNDING) * ROUNDING
FAR = 8.0  # sizes of the drawing, from its middle to the corners of the square round it


def constrained(points: Floats, segments: Integers) -> tuple[Integers, list[list[int]]]:
    """Triangles (m, 3), counter-clockwise, and the points along each segment in order.

    The triangles cover all that segments enclose, and round it about the convex hull; between a segment and its parts
    there is a difference only where another point lies on it.

    Raises
    ------
    GeometryError
        If two segments cross, or two points are one.

    Examples
    --------
    The longer diagonal of a flat rhombus is no edge of its Delaunay triangulation, unless it is asked for:

    >>> import numpy as np
    >>> from kirigami.geometry.delaunay import constrained
    >>> rhombus = np.array([(-3.0, 0.0), (0.0, -1.0), (3.0, 0.0), (0.0, 1.0)])
    >>> constrained(rhombus, np.array([(0, 2)]))
    (array([[0, 1, 2],
           [0, 2, 3]]), [[0, 2]])
    """
    low, high = points.min(axis=0), points.max(axis=0)
    middle, reach = 0.5 * (low + high), FAR * float((high - low).max() or 1.0)
    square = middle + reach * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    everything, count = np.concatenate([points, square]), len(points)
    triangles = _by_qhull(everything)
    chains = [[first, last] for first, last in segments.tolist()]
    if triangles is None or not _holds(triangles, segments, len(everything)):
        edges = _Edges(everything.tolist())
        if triangles is None:
            edges.add([(count, count + 1, count + 2), (count, count + 2, count + 3)])
            missing: Iterable[int] = range(count)
        else:
            edges.add(triangles.tolist())
            missing = np.setdiff1d(np.arange(count), triangles).tolist()
        for point in missing:
            edges.insert(point)
        kept: set[tuple[int, int]] = set()
        chains = [edges.recover(first, last, kept) for first, last in segments.tolist()]
        triangles = edges.triangles()
    inside: Integers = triangles[(triangles < count).all(axis=1)]
    first = np.argmin(inside, axis=1)  # the same triangles in the same order, whatever way they were found
    turned = np.take_along_axis(inside, (first[:, None] + np.arange(3)) % 3, axis=1)
    return turned[np.lexsort(turned.T[::-1])], chains


def _by_qhull(points: Floats) -> Integers | None:
    """Delaunay triangles by Qhull, or None where they are no triangulation; points may be left out."""
    from scipy.spatial import Delaunay, QhullError

    try:
        triangles: Integers = Delaunay(points).simplices.astype(np.int64)
    except QhullError:
        return None
    corners = points[triangles]
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    left, right = one[:, 0] * two[:, 1], one[:, 1] * two[:, 0]
    turns = left - right
    surely = np.abs(turns) > 4.0 * TURN_BOUND * (np.abs(left) + np.abs(right))
    for triangle in np.flatnonzero(~surely).tolist():
        turns[triangle] = turn(*corners[triangle].tolist())
    if not turns.all():
        return None
    triangles[turns < 0] = triangles[turns < 0][:, ::-1]
    # A surface of positive triangles with the square as its only rim covers the square once.
    used = len(np.unique(triangles))
    if len(triangles) != 2 * used - 6:
        return None
    try:
        first, second = paired_half_edges(triangles)
    except GeometryError:
        return None
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    paired = second >= 0
    agree = (start[first[paired]] == end[second[paired]]).all()
    return triangles if agree and (~paired).sum() == 4 else None


def _holds(triangles: Integers, segments: Integers, count: int) -> bool:
    """Whether all points are corners of triangles and all segments edges."""
    edges = np.column_stack([triangles.ravel(), triangles[:, [1, 2, 0]].ravel()])
    there = np.isin(pair_keys(segments, count), pair_keys(edges, count))
    return len(np.unique(triangles)) == count and bool(there.all())


def turn(a: Point, b: Point, c: Point) -> float:
    """Positive where a, b, c turn left, negative where they turn right, zero where they lie on a line: exactly.

    >>> from kirigami.geometry.delaunay import turn
    >>> turn((0.0, 0.0), (1.0, 1.0), (0.1 + 0.2, 0.3)) < 0, turn((0.0, 0.0), (1.0, 1.0), (0.3, 0.3))
    (True, 0.0)
    """
    left, right = (a[0] - c[0]) * (b[1] - c[1]), (a[1] - c[1]) * (b[0] - c[0])
    if abs(left - right) > TURN_BOUND * (abs(left) + abs(right)):
        return float(left - right)
    a, b, c = _exactly(a, b, c)
    exact = (a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0])
    return float((exact > 0) - (exact < 0))


def in_circle(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Whether d lies within the circle through a, b, c, which turn left: exactly.

    >>> from kirigami.geometry.delaunay import in_circle
    >>> in_circle((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))
    False
    >>> in_circle((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0 + 1e-16))
    True
    """
    value, size = _circle(a, b, c, d)
    if abs(value) > CIRCLE_BOUND * size:
        return bool(value > 0)
    return bool(_circle(*_exactly(a, b, c, d))[0] > 0)


def _exactly(*points: Point) -> list[Point]:
    return [(Fraction(x), Fraction(y)) for x, y in points]


def _circle(a: Point, b: Point, c: Point, d: Point) -> tuple[Any, Any]:
    """The determinant, positive within, and the sum of the sizes of its products."""
    ax, ay, bx, by, cx, cy = a[0] - d[0], a[1] - d[1], b[0] - d[0], b[1] - d[1], c[0] - d[0], c[1] - d[1]
    aa, bb, cc = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    value = aa * (bx * cy - cx * by) + bb * (cx * ay - ax * cy) + cc * (ax * by - bx * ay)
    size = (
        aa * (abs(bx * cy) + abs(cx * by)) + bb * (abs(cx * ay) + abs(ax * cy)) + cc * (abs(ax * by) + abs(bx * ay))
    )
    return value, size


class _Edges:
    """A triangulation as a map from each directed edge (u, v) to the corner at its left."""

    def __init__(self, points: list[Point]) -> None:
        self.points = points
        self.apex: dict[tuple[int, int], int] = {}
        self.near: dict[int, int] = {}  # some neighbour of each point

    def add(self, triangles: Iterable[Iterable[int]]) -> None:
        apex, near = self.apex, self.near
        for u, v, w in triangles:
            apex[u, v], apex[v, w], apex[w, u] = w, u, v
            near[u], near[v], near[w] = v, w, u

    def triangles(self) -> Integers:
        found = [(u, v, w) for (u, v), w in self.apex.items() if u < v and u < w]
        return np.array(found, np.int64).reshape(-1, 3)

    def turn(self, u: int, v: int, w: int) -> float:
        return turn(self.points[u], self.points[v], self.points[w])

    def insert(self, point: int) -> None:
        """Put a point in where it lies, and flip until the triangulation is Delaunay again."""
        u, v = next(iter(self.apex))
        while True:  # walk towards it; in a Delaunay triangulation no walk comes back
            w = self.apex.get((u, v), -1)
            if w < 0 or self.turn(u, v, point) < 0:
                u, v = v, u
                continue
            if self.turn(v, w, point) < 0:
                u, v = w, v
            elif self.turn(w, u, point) < 0:
                u, v = u, w
            else:
                break
        if self.points[point] in (self.points[u], self.points[v], self.points[w]):
            raise GeometryError(f"two points of the drawing are one, {self.points[point]}; try a larger `snap`")
        ring = [u, v, w]
        for start, end in ((u, v), (v, w), (w, u)):
            if self.turn(start, end, point) == 0:
                beyond = self.apex.pop((end, start))
                del self.apex[start, end]
                ring.insert(ring.index(start) + 1, beyond)
                break
        sides = list(zip(ring, [*ring[1:], ring[0]]))
        self.add((start, end, point) for start, end in sides)
        self.legalise(sides, frozenset())

    def legalise(self, edges: Iterable[tuple[int, int]], kept: Any) -> None:
        """Flip edges that are not Delaunay, but for those kept, and what stands round them."""
        waiting = list(edges)
        while waiting:
            u, v = waiting.pop()
            w, x = self.apex.get((u, v), -1), self.apex.get((v, u), -1)
            if w < 0 or x < 0 or (min(u, v), max(u, v)) in kept:
                continue
            if in_circle(*(self.points[number] for number in (u, v, w, x))):
                self.flip(u, v)
                waiting += [(u, x), (x, v), (v, w), (w, u)]

    def flip(self, u: int, v: int) -> tuple[int, int]:
        """Turn the edge of two triangles, which together are convex, into the other diagonal, and give that."""
        w, x = self.apex.pop((u, v)), self.apex.pop((v, u))
        self.add([(w, u, x), (x, v, w)])
        return w, x

    def recover(self, first: int, last: int, kept: set[tuple[int, int]]) -> list[int]:
        """Make the way between two points one of edges, which are kept from then on; the points along it."""
        chain = [first]
        while chain[-1] != last:
            chain.append(self._straight(chain[-1], last, kept))
            kept.add((min(chain[-2:]), max(chain[-2:])))
        return chain

    def _straight(self, a: int, b: int, kept: set[tuple[int, int]]) -> int:
        """Make a straight edge from a towards b, to b or to the first point that lies on the way."""
        if (a, b) in self.apex or (b, a) in self.apex:
            return b
        crossed: deque[tuple[int, int]] = deque()
        left = right = self.near[a]
        while True:  # the triangle round a through which the way to b goes
            right, left = left, self.apex[a, left]
            from_right, from_left = self.turn(a, b, right), self.turn(a, b, left)
            if from_left == 0 and self._ahead(a, b, left):
                return left
            if from_right < 0 < from_left:
                break
        while True:
            if (min(left, right), max(left, right)) in kept:
                ends = ", ".join(str(self.points[number]) for number in (a, b, left, right))
                raise GeometryError(f"two lines of the drawing cross without a common point: {ends}; try a larger snap")
            crossed.append((right, left))
            beyond = self.apex[left, right]
            side = self.turn(a, b, beyond)
            if side == 0:
                end = beyond
                break
            left, right = (beyond, right) if side > 0 else (left, beyond)
        made = []
        while crossed:
            u, v = crossed.popleft()
            w, x = self.apex[u, v], self.apex[v, u]
            if self.turn(x, v, w) <= 0 or self.turn(w, u, x) <= 0:
                crossed.append((u, v))  # not convex yet
                continue
            w, x = self.flip(u, v)
            if {w, x} != {a, end} and self.turn(a, end, w) * self.turn(a, end, x) < 0:
                crossed.append((w, x))
            else:
                made.append((w, x))
        self.legalise(made, kept | {(min(a, end), max(a, end))})
        return end

    def _ahead(self, a: int, b: int, point: int) -> bool:
        start, to, at = (np.array(self.points[number], float) for number in (a, b, point))
        return bool((to - start) @ (at - start) > 0)
