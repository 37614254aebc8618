"""What was drawn in pieces becomes whole: doubles dropped, ends joined, ends led onto the curves they touch."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.drawing.curves import Curve, Floats, lines_of
from kirigami.errors import KirigamiWarning
from kirigami.words import counted

ROUNDING = 1e-9  # of the tolerance: what ends are moved by less is not told


def without_specks(curves: Sequence[Curve], gap: float, notes: list[str]) -> list[Curve]:
    """Drop curves that have no length."""
    short = [curve for curve, length in zip(curves, shapely.length(lines_of(curves))) if not length > 1e-3 * gap]
    if short:
        few = ", ".join(curve.source for curve in short[:3]) + (" ..." if len(short) > 3 else "")
        notes.append(f"{counted(len(short), 'curve')} without length dropped: {few}")
    dropped = set(map(id, short))
    return [curve for curve in curves if id(curve) not in dropped]


def without_doubles(curves: Sequence[Curve], gap: float, notes: list[str]) -> list[Curve]:
    """Drop curves that lie on an earlier one of the same role all along."""
    lines = lines_of(curves)
    lengths = shapely.length(lines)
    # The middle of a closed curve depends on where it starts, its centroid does not.
    closed = np.array([curve.closed for curve in curves], dtype=bool)
    middles = np.where(closed, shapely.centroid(lines), shapely.line_interpolate_point(lines, 0.5, normalized=True))
    first, second = shapely.STRtree(middles).query(middles, predicate="dwithin", distance=gap)
    later = (first < second) & (np.abs(lengths[first] - lengths[second]) <= 4 * gap)
    dropped: dict[int, int] = {}
    for one, other in zip(first[later].tolist(), second[later].tolist()):
        same_role = curves[one].role == curves[other].role
        if same_role and one not in dropped and shapely.hausdorff_distance(lines[one], lines[other]) <= gap:
            dropped[other] = one
    if dropped:
        pairs = [f"{curves[other].source} on {curves[one].source}" for other, one in list(dropped.items())[:3]]
        more = f" and {len(dropped) - 3} more" if len(dropped) > 3 else ""
        text = f"{counted(len(dropped), 'curve')} drawn twice, dropped: {', '.join(pairs)}{more}"
        warnings.warn(text, KirigamiWarning, stacklevel=4)
        notes.append(text)
    return [curve for number, curve in enumerate(curves) if number not in dropped]


def open_ends(curves: Sequence[Curve]) -> tuple[list[int], Floats]:
    """Numbers of the open curves, and their ends (2 k, 2): that of the first point, then that of the last."""
    numbers = [number for number, curve in enumerate(curves) if not curve.closed]
    if not numbers:
        return numbers, np.empty((0, 2))
    first, last = _tips(curves, np.array(numbers))
    return numbers, np.stack([first, last], axis=1).reshape(-1, 2)


def clusters(points: Floats, gap: float) -> NDArray[np.int64]:
    """Number of the group of each point, where groups hang together over distances up to `gap`."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    near = cKDTree(points).query_pairs(gap, output_type="ndarray")
    graph = coo_array((np.ones(len(near), np.int8), near.T), shape=(len(points), len(points)))
    group: NDArray[np.int64] = connected_components(graph, directed=False)[1].astype(np.int64)
    return group


def led_together(curves: Sequence[Curve], gap: float, notes: list[str]) -> list[Curve]:
    """Move three and more ends that nearly meet into one point, and ends that nearly touch a curve onto it.

    Where the curve is smooth, its chords bow away from it: an end that was drawn to lie on the curve lies off the
    chord. There the curve gives way and gets the end as a point of its own; where it was drawn straight, the end moves.

    Parameters
    ----------
    curves : sequence of Curve
        Of all roles.
    gap : float
        How far an end may be from what it was meant to touch.
    notes : list of str
        Gets a word on what was moved.
    """
    result = list(curves)
    numbers, ends = open_ends(result)
    if not numbers:
        return result
    group = clusters(ends, gap)
    _, first = np.unique(group, return_index=True)
    met = np.bincount(group)[group] > 2  # two ends are joined to one curve later
    moved = np.where(met[:, None], ends[first[group]], ends)
    onto: dict[int, list[tuple[int, Floats]]] = {}
    bows = largest_bows(result)
    lines = lines_of(result)
    reach = gap + float(bows.max())
    end, line = shapely.STRtree(lines).query(shapely.points(ends), predicate="dwithin", distance=reach)
    own = np.repeat(numbers, 2)[end] == line
    distance = shapely.distance(shapely.points(ends[end]), lines[line])
    shut = np.array([curve.closed for curve in result])[line]
    tips = [np.linalg.norm(lines_ends - ends[end], axis=1) for lines_ends in _tips(result, line)]
    at_tip = ~shut & (np.minimum(*tips) <= gap)
    touching = ~own & ~at_tip & (distance <= gap + bows[line]) & (distance > ROUNDING * gap)
    longest = float(np.linalg.norm(moved - ends, axis=1).max())
    order = np.lexsort([distance, end])
    seen: set[int] = set()
    for k in order[touching[order]].tolist():
        where = _landing(result[line[k]], moved[end[k]], gap)
        if where is None:
            continue
        segment, place, insert = where
        if insert:
            onto.setdefault(int(line[k]), []).append((segment, moved[end[k]]))
        elif int(group[end[k]]) not in seen:
            longest = max(longest, float(np.linalg.norm(place - moved[end[k]])))
            moved[group == group[end[k]] if met[end[k]] else end[k]] = place
        seen.add(int(group[end[k]]))
    for position, number in enumerate(numbers):
        pair = moved[2 * position : 2 * position + 2]
        if (pair != ends[2 * position : 2 * position + 2]).any():
            points = result[number].points.copy()
            points[[0, -1]] = pair
            if np.ptp(points, axis=0).max() > 0:
                result[number] = replace(result[number], points=points)
    for number, places in onto.items():
        result[number] = _with_points(result[number], places)
    if longest > ROUNDING * gap:
        notes.append(f"ends led onto the curves they nearly touch, by {longest:.3g} at most")
    return result


def _tips(curves: Sequence[Curve], which: Any) -> tuple[Floats, Floats]:
    points = np.concatenate([curve.points for curve in curves])
    end = np.cumsum([len(curve.points) for curve in curves])
    start = np.concatenate([[0], end[:-1]])
    return points[start[which]], points[end[which] - 1]


def largest_bows(curves: Sequence[Curve]) -> Floats:
    """The largest bow of each curve."""
    bows = [np.atleast_1d(curve.bow) for curve in curves]
    start = np.cumsum([0, *(len(bow) for bow in bows[:-1])])
    return np.asarray(np.maximum.reduceat(np.concatenate(bows), start), dtype=float)


def _landing(curve: Curve, end: Floats, gap: float) -> tuple[int, Floats, bool] | None:
    """The segment of a curve that an end touches, the nearest place on it, and whether the curve is to give way."""
    start, chord = curve.points[:-1], np.diff(curve.points, axis=0)
    square = np.maximum(np.einsum("ij,ij->i", chord, chord), 1e-300)
    along = np.clip(np.einsum("ij,ij->i", end - start, chord) / square, 0.0, 1.0)
    place = start + along[:, None] * chord
    off = np.linalg.norm(place - end, axis=1)
    bow = np.broadcast_to(curve.bow, len(chord))
    fits = np.flatnonzero(off <= gap + bow)
    if not fits.size:
        return None
    segment = int(fits[np.argmin(off[fits])])
    if min(np.linalg.norm(curve.points[segment] - end), np.linalg.norm(curve.points[segment + 1] - end)) <= gap:
        corner = segment if along[segment] < 0.5 else segment + 1
        return segment, curve.points[corner], False
    return segment, place[segment], bool(bow[segment] > 0)


def _with_points(curve: Curve, places: list[tuple[int, Floats]]) -> Curve:
    """A curve with further points in its segments."""
    along = [float(np.dot(place - curve.points[segment], curve.points[segment + 1] - curve.points[segment]))
             for segment, place in places]  # fmt: skip
    order = sorted(range(len(places)), key=lambda k: (places[k][0], along[k]))
    at = [places[k][0] + 1 for k in order]
    bow = np.broadcast_to(curve.bow, len(curve.points) - 1)
    points = np.insert(curve.points, at, [places[k][1] for k in order], axis=0)
    return replace(curve, points=points, bow=np.insert(bow, at, [bow[places[k][0]] for k in order]))


def chained(curves: Sequence[Curve], gap: float, notes: list[str]) -> list[Curve]:
    """Join curves end to end where exactly two ends meet within `gap`; the order is that of the first pieces."""
    open_ones, ends = open_ends(curves)
    if not open_ones:
        return list(curves)
    meeting: dict[int, list[int]] = {}
    for end, number in enumerate(clusters(ends, gap).tolist()):
        meeting.setdefault(number, []).append(end)
    partner = {}
    for members in meeting.values():
        if len(members) == 2:
            partner[members[0]], partner[members[1]] = members[1], members[0]
    # End 2 k is the first point of open curve k, end 2 k + 1 its last; end ^ 1 is the other end of the same curve.
    used: set[int] = set()
    found: dict[int, Curve] = {number: curve for number, curve in enumerate(curves) if curve.closed}
    gaps: list[float] = []
    for start in range(0, len(ends), 2):
        if start // 2 in used:
            continue
        if start not in partner and start + 1 not in partner:  # most lines of a drawing are on their own
            found[open_ones[start // 2]] = curves[open_ones[start // 2]]
            continue
        entry, closes = start, False
        while entry in partner and not closes:  # back to the free end, or once round
            entry = partner[entry] ^ 1
            closes = entry == start
        walk = [entry]
        while (after := partner.get(walk[-1] ^ 1)) is not None and after != entry:
            walk.append(after)
        used.update(end // 2 for end in walk)
        parts = [curves[open_ones[end // 2]].points[:: -1 if end % 2 else 1] for end in walk]
        following = parts[1:] + parts[:1] if closes else parts[1:]
        gaps += [float(np.linalg.norm(a[-1] - b[0])) for a, b in zip(parts, following)]
        points = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
        if closes:
            points[-1] = points[0]
        number = open_ones[min(end // 2 for end in walk)]
        numbers = tuple(part for end in walk for part in curves[open_ones[end // 2]].numbers)
        bows = [np.broadcast_to(curves[open_ones[end // 2]].bow, len(part) - 1)[:: -1 if end % 2 else 1]
                for end, part in zip(walk, parts)]  # fmt: skip
        found[number] = replace(curves[number], points=points, bow=np.concatenate(bows), numbers=numbers)
    real = [value for value in gaps if value > 1e-5 * gap]
    if real:
        notes.append(f"{counted(len(real), 'gap')} between ends closed, the widest {max(real):.3g}")
    return [found[number] for number in sorted(found)]
