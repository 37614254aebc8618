"""Refinement of a constrained Delaunay triangulation until no angle is small and no facet large, in whole rounds.

A round puts a point at the middle of every circle round a poor facet, worst first, unless it lies within a circle that
is gone by then; where it would come too near to a segment, or lies beyond one, that segment is divided instead
(Ruppert, J. Algorithms 18, 548, 1995; how near is Chew's lens, 1993, as in Shewchuk, Comput. Geom. 22, 21, 2002).
Segments that meet at a sharp angle are divided on circles round their corner, so that the corner does not run on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kirigami.geometry.delaunay import constrained
from kirigami.geometry.topology import pair_numbers, paired_half_edges, signed_areas, within

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

SHARP = 60.0  # degrees between segments below which they are divided on circles
EQUAL = 1e-3  # relative difference of two distances from a corner that lie on one circle
OFF_CENTRE = 0.475  # of what would make the angle just allowed
STRIDES = 200  # facets passed on the way to the middle of a circle, at most
ROUNDS = 400


@dataclass(eq=False)
class Work:
    """What is refined: points, segments with the sheet at the left of those on the rim, and where they come from.

    Attributes
    ----------
    points : ndarray, shape (n, 2)
    segments : ndarray of int, shape (s, 2)
    is_rim : ndarray of bool, shape (s,)
    origin : ndarray of int, shape (s,)
        The segment of the beginning of which each is a part.
    on : dict
        For points on segments, the first segments that they lie on.
    triangles : ndarray of int, shape (m, 3)
    """

    points: Floats
    segments: Integers
    is_rim: NDArray[np.bool_]
    origin: Integers
    on: dict[int, set[int]]
    triangles: Integers


def refine(
    points: Floats,
    triangles: Integers,
    segments: Integers,
    is_rim: NDArray[np.bool_],
    min_angle: float,
    max_areas: Floats | None,
    most: float,
) -> Work:
    """Refine triangles whose rim is made of segments.

    Parameters
    ----------
    points, triangles, segments, is_rim : ndarray
        The triangulation; segments on its rim have the triangles at their left.
    min_angle : float
        Smallest angle in degrees.
    max_areas : ndarray, shape (m,), optional
        Triangles that are larger than this get a point.
    most : float
        New points after which to stop.
    """
    on: dict[int, set[int]] = {}
    for number, ends in enumerate(segments.tolist()):
        for end in ends:
            on.setdefault(end, set()).add(number)
    work = Work(points, segments.copy(), is_rim, np.arange(len(segments)), on, triangles)
    first = segments.copy()
    sharp = _sharp_ends(points, segments)
    large = np.zeros(len(triangles), bool) if max_areas is None else signed_areas(points, triangles) > max_areas
    begun = len(points)
    for _ in range(ROUNDS):
        room = most - (len(work.points) - begun)
        sides = _Sides(work)
        divided = sides.encroached(min_angle)
        poor = _poor(work, first, min_angle, large)
        centres = np.empty((0, 2))
        if len(poor):
            centres, beyond = _centres(work, sides, poor, min_angle)
            divided = np.unique(np.concatenate([divided, beyond]))
        if room <= 0 or not (len(divided) or len(centres)):
            break
        divided = divided[: int(min(room, len(divided)))]
        middles = _middles(work, divided, first, sharp)
        centres = _apart(work.points, middles, centres)[: int(max(room - len(divided), 0))]
        _take(work, divided, middles, centres)
        large = np.zeros(len(work.triangles), bool)
    return work


class _Sides:
    """The edges of the triangles, and which are segments."""

    def __init__(self, work: Work) -> None:
        triangles, count = work.triangles, len(work.points)
        first, second = paired_half_edges(triangles)
        self.twin = np.full(triangles.size, -1)
        both = second >= 0
        self.twin[first[both]], self.twin[second[both]] = second[both], first[both]
        self.start, self.end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
        self.apex = triangles[:, [2, 0, 1]].ravel()
        self.segment = pair_numbers(np.column_stack([self.start, self.end]), work.segments, count)
        self.points = work.points

    def encroached(self, min_angle: float) -> Integers:
        """Segments with the third corner of a facet in their lens."""
        here = np.flatnonzero(self.segment >= 0)
        seen = _in_lens(self.points[self.apex[here]], self.points[self.start[here]], self.points[self.end[here]],
                        min_angle)  # fmt: skip
        found: Integers = np.unique(self.segment[here[seen]])
        return found


def _in_lens(points: Floats, starts: Floats, ends: Floats, min_angle: float) -> NDArray[np.bool_]:
    """Whether points see segments under more than 180 degrees less twice the smallest angle."""
    one, two = starts - points, ends - points
    dot = np.einsum("nx,nx->n", one, two)
    sizes = np.einsum("nx,nx->n", one, one) * np.einsum("nx,nx->n", two, two)
    wide = np.cos(2.0 * np.radians(min_angle))
    return np.asarray((dot < 0.0) & (dot * dot > wide * wide * sizes))


def _poor(work: Work, first: Integers, min_angle: float, large: NDArray[np.bool_]) -> Integers:
    """Triangles to refine, those with the smallest angle first; angles that the drawing itself makes are left."""
    corners = work.points[work.triangles]
    sides = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]  # opposite each corner
    lengths = np.linalg.norm(sides, axis=2)
    shortest = np.argmin(lengths, axis=1)
    twice = 2.0 * signed_areas(work.points, work.triangles)
    sine = twice * np.take_along_axis(lengths, shortest[:, None], 1)[:, 0] / lengths.prod(axis=1)
    small = sine < np.sin(np.radians(min_angle))
    for number in np.flatnonzero(small).tolist():
        at = shortest[number]
        one, two = (int(work.triangles[number, (at + step) % 3]) for step in (1, 2))
        small[number] = not _across_a_corner(work, first, one, two)
    chosen = np.flatnonzero(small | large)
    found: Integers = chosen[np.argsort(np.where(small, sine, 1.0)[chosen], kind="stable")]
    return found


def _across_a_corner(work: Work, first: Integers, one: int, two: int) -> bool:
    """Whether two points lie as far from a sharp corner, each on one of its segments: nothing can part them."""
    for left in work.on.get(one, ()):
        for right in work.on.get(two, ()):
            common = set(first[left].tolist()) & set(first[right].tolist()) - {one, two}
            if left == right or len(common) != 1:
                continue
            (corner,) = common
            arms = work.points[[one, two]] - work.points[corner]
            reach = np.linalg.norm(arms, axis=1)
            sharp = arms[0] @ arms[1] > np.cos(np.radians(SHARP)) * reach.prod()
            if sharp and abs(reach[0] - reach[1]) < EQUAL * reach.max():
                return True
    return False


def _centres(work: Work, sides: _Sides, poor: Integers, min_angle: float) -> tuple[Floats, Integers]:
    """Middles of the circles round facets that may become points, and the segments that stand in the way of others."""
    centres = _middles_of_circles(work.points[work.triangles[poor]], min_angle)
    facet, blocked = poor.copy(), np.full(len(poor), -1)
    walking = np.arange(len(poor))
    for _ in range(STRIDES):  # from facet to facet, across the edge that the middle lies farthest beyond
        half = 3 * facet[walking, None] + np.arange(3)
        start, end = work.points[sides.start[half]], work.points[sides.end[half]]
        step, to = end - start, centres[walking, None] - start
        beyond = (step[..., 1] * to[..., 0] - step[..., 0] * to[..., 1]) / np.linalg.norm(step, axis=2)
        worst = np.argmax(beyond, axis=1)
        out = beyond[np.arange(len(walking)), worst] > 0
        walking, across = walking[out], half[np.arange(len(half)), worst][out]
        if not len(walking):
            break
        stopped = (sides.segment[across] >= 0) | (sides.twin[across] < 0)
        blocked[walking[stopped]] = sides.segment[across[stopped]]
        walking, across = walking[~stopped], across[~stopped]
        facet[walking] = sides.twin[across] // 3
    free = blocked < 0
    free[walking] = False
    divided = [blocked[blocked >= 0]]
    candidates = centres[free]
    if len(candidates) and len(work.segments):
        from scipy.spatial import KDTree

        ends = work.points[work.segments]
        along = ends[:, 1] - ends[:, 0]
        near = KDTree(candidates).query_ball_point(ends.mean(axis=1), 0.5 * np.linalg.norm(along, axis=1))
        segment = np.repeat(np.arange(len(near)), [len(found) for found in near])
        candidate = np.array([number for found in near for number in found], np.int64)
        aside = candidates[candidate] - ends[segment, 0]
        behind = work.is_rim[segment] & (along[segment, 0] * aside[:, 1] < along[segment, 1] * aside[:, 0])
        seen = ~behind & _in_lens(candidates[candidate], ends[segment, 0], ends[segment, 1], min_angle)
        divided.append(segment[seen])
        alone = np.ones(len(candidates), bool)
        alone[candidate[seen]] = False
        candidates = candidates[alone]
    return candidates, np.unique(np.concatenate(divided))


def _middles_of_circles(corners: Floats, min_angle: float) -> Floats:
    """Middle of the circle round each facet, or the place nearer to its shortest edge that makes an angle with it that
    is just allowed (Uengoer's off-centre, Comput. Geom. 42, 109, 2009): that takes fewer points."""
    sides = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]  # opposite each corner
    squares = np.einsum("mcx,mcx->mc", sides, sides)
    every, shortest = np.arange(len(corners)), np.argmin(squares, axis=1)
    edge, length = sides[every, shortest], np.sqrt(squares[every, shortest])
    to_apex = corners[every, shortest] - corners[every, (shortest + 1) % 3]
    across = np.column_stack([-edge[:, 1], edge[:, 0]]) / length[:, None]
    along, height = np.einsum("mx,mx->m", to_apex, edge) / length, np.einsum("mx,mx->m", to_apex, across)
    away = 0.5 * (along * (along - length) + height**2) / height  # of the middle of the circle from the edge
    away = np.minimum(away, OFF_CENTRE * length / np.tan(0.5 * np.radians(min_angle)))
    return np.asarray(corners[every, (shortest + 1) % 3] + 0.5 * edge + away[:, None] * across)


def _apart(points: Floats, middles: Floats, centres: Floats) -> Floats:
    """The first of the centres, without those that are nearer to one before, or to a middle, than to any point."""
    if not len(centres):
        return centres
    from scipy.spatial import KDTree

    reach = KDTree(points).query(centres)[0]
    every = np.concatenate([middles, centres])
    near = KDTree(every).query_ball_point(centres, (1 - 1e-9) * reach)
    taken = np.zeros(len(every), bool)
    taken[: len(middles)] = True
    for number, found in enumerate(near, start=len(middles)):
        taken[number] = not taken[found].any()
    return centres[taken[len(middles) :]]


def _sharp_ends(points: Floats, segments: Integers) -> NDArray[np.bool_]:
    """Which ends (s, 2) of segments are at a sharp angle with another one."""
    point = segments.ravel()
    step = points[segments[:, ::-1].ravel()] - points[point]
    angle = np.degrees(np.arctan2(step[:, 1], step[:, 0]))
    order = np.lexsort([angle, point])
    sharp = np.zeros(len(point), bool)
    first = np.flatnonzero(np.append(True, point[order][1:] != point[order][:-1]))
    for begin, end in zip(first, np.append(first[1:], len(order))):
        group = order[begin:end]
        gap = np.diff(np.append(angle[group], angle[group[0]] + 360.0))
        close = gap < SHARP - 1e-9
        sharp[group] |= close | np.roll(close, 1)
    return sharp.reshape(-1, 2)


def _middles(work: Work, divided: Integers, first: Integers, sharp: NDArray[np.bool_]) -> Floats:
    """Where segments are divided: in the middle, or on a circle of a power of two round the one sharp corner."""
    ends, origin = work.segments[divided], work.origin[divided]
    share = np.full(len(divided), 0.5)
    length = np.linalg.norm(work.points[ends[:, 1]] - work.points[ends[:, 0]], axis=1)
    at_corner = np.zeros(ends.shape, bool)
    for side in (0, 1):
        for end in (0, 1):
            at_corner[:, side] |= (ends[:, side] == first[origin, end]) & sharp[origin, end]
    one = at_corner.sum(axis=1) == 1
    circle = 2.0 ** np.floor(np.log2(length[one] / 1.5))
    part = circle / length[one]  # between a third and two thirds
    share[one] = np.where(at_corner[one, 0], part, 1.0 - part)
    begin = work.points[ends[:, 0]]
    return np.asarray(begin + share[:, None] * (work.points[ends[:, 1]] - begin))


def _take(work: Work, divided: Integers, middles: Floats, centres: Floats) -> None:
    """Divide segments, add points and triangulate anew."""
    new = len(work.points) + np.arange(len(divided))
    for point, number in zip(new.tolist(), work.origin[divided].tolist()):
        work.on[point] = {number}
    second = np.column_stack([new, work.segments[divided, 1]])
    work.segments[divided, 1] = new
    work.segments = np.concatenate([work.segments, second])
    work.is_rim = np.concatenate([work.is_rim, work.is_rim[divided]])
    work.origin = np.concatenate([work.origin, work.origin[divided]])
    work.points = np.concatenate([work.points, middles, centres])
    made, _ = constrained(work.points, work.segments)
    work.triangles = within(made, work.segments, work.segments[work.is_rim])
