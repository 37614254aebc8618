"""Where an outline is open: the gaps that keep it from closing, and the tolerance that would close them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.drawing.curves import Curve, Floats, lines_of
from kirigami.drawing.joining import chained, led_together, open_ends
from kirigami.drawing.measure import Measure
from kirigami.drawing.network import network
from kirigami.errors import GeometryError
from kirigami.words import counted

WIDEST = 0.05  # of the size of the drawing: no gap that anybody meant to close is wider
STEPS = 12  # of the search between the tolerance and the widest gap
LARGER = 2.0  # times: what closes must enclose more than what was closed before
SHORT = 10.0  # times the tolerance: a bridge as narrow as this is none that anybody can cut
COVER = 0.3  # of the box round everything, which the closed outline must cover


def gap_error(
    chains: Sequence[Curve], raw: Sequence[Curve], area: float, gap: float, measure: Measure
) -> GeometryError | None:
    """The error that names the gaps of an outline, or None where closing gaps does not help.

    The tolerance is widened until the lines enclose a sheet; the gaps that had to close for it are the true ones, and
    the tolerance that is named was tried.

    Parameters
    ----------
    chains, raw : sequence of Curve
        Curves after and before they were joined.
    area : float
        The most that they enclose as they are.
    gap : float
        Ends nearer than this are joined.
    measure : Measure
        How to say places.
    """
    everything = np.concatenate([curve.points for curve in raw])
    least = max(LARGER * area, COVER * float(np.prod(np.ptp(everything, axis=0))))
    for reach in np.geomspace(2 * gap, WIDEST * measure.size, STEPS) if 2 * gap < WIDEST * measure.size else []:
        body = _enclosed(raw, float(reach))
        if body is None or body.area < least:
            continue
        gaps = _gaps(raw, body, gap, float(reach))
        if not gaps:
            continue
        share, words, length = measure.tolerance(max(distance for distance, *_ in gaps))
        closed = _enclosed(raw, share * measure.size)
        if closed is None or closed.area < least:
            continue
        told = ", and at ".join(
            f"{measure.point(min(pair))} and {measure.point(max(pair))}, a gap of {measure.length(distance)}"
            for distance, *ends, _ in gaps[:6]
            for pair in [[end.tolist() for end in ends]]
        )
        more = f", and {len(gaps) - 6} more" if len(gaps) > 6 else ""
        broken = set(raw[gaps[0][3]].numbers)
        first = next((curve for curve in chains if broken & set(curve.numbers)), raw[gaps[0][3]])
        return GeometryError(
            f"the outline is open: from {first.source}, layer {first.layer!r}, it ends at {told}{more}; ends closer "
            f"than {measure.length(gap)} are joined, `tolerance={words}` or `tolerance={length}` closes it"
        )
    return None


def open_outline(
    chains: Sequence[Curve], raw: Sequence[Curve], area: float, gap: float, measure: Measure
) -> GeometryError:
    """The error that says where the outline is open, or what there is in the place of one.

    Parameters
    ----------
    chains, raw : sequence of Curve
        Curves after and before they were joined.
    area : float
        The most that they enclose as they are.
    gap : float
        Ends nearer than this are joined.
    measure : Measure
        How to say places.
    """
    error = gap_error(chains, raw, area, gap, measure)
    if error is not None:
        return error
    open_ones = [curve for curve in chains if not curve.closed]
    shut = max((c for c in chains if c.closed), key=lambda c: float(np.ptp(c.points, axis=0).prod()), default=None)
    text = "no closed curve lies round all the others, so there is no outline"
    if open_ones:
        largest = max(open_ones, key=lambda curve: float(np.ptp(curve.points, axis=0).prod()))
        one, other = largest.points[0], largest.points[-1]
        text += (
            f"; the outline is open: from {largest.source}, layer {largest.layer!r}, it ends at {measure.point(one)} "
            f"and {measure.point(other)}, a gap of {measure.length(float(np.linalg.norm(one - other)))}; ends closer "
            f"than {measure.length(gap)} are joined, see `tolerance`"
        )
    if shut is not None:
        text += f"; the largest closed curve is {measure.curves([shut])}"
    return GeometryError(text)


def _enclosed(raw: Sequence[Curve], reach: float) -> shapely.Polygon | None:
    """The largest shape that the curves enclose when ends are joined within `reach`."""
    joined = chained(led_together(raw, reach, []), reach, [])
    lines = network([curve.points for curve in joined], 0.02 * reach)
    faces = lines.faces(slice(None))
    if not faces:
        return None
    parts = shapely.get_parts(shapely.union_all([shapely.Polygon(face.exterior) for face in faces]))
    return shapely.Polygon(max(parts, key=lambda part: part.area).exterior)


def _gaps(
    raw: Sequence[Curve], body: shapely.Polygon, gap: float, reach: float
) -> list[tuple[float, Floats, Floats, int]]:
    """Gaps at the rim of what closes: distance, the end, what it is to meet, and the curve; in order of the drawing."""
    numbers, ends = open_ends(raw)
    lines = lines_of(raw)
    owner: NDArray[np.int64] = np.repeat(numbers, 2)
    at_rim = np.flatnonzero(shapely.dwithin(shapely.points(ends), body.exterior, reach))
    found: list[tuple[float, Floats, Floats, int]] = []
    tree = shapely.STRtree(lines)
    for end in at_rim.tolist():
        near = tree.query(shapely.Point(ends[end]), predicate="dwithin", distance=reach)
        others = near[near != owner[end]]
        # The other end of the same curve, where it closes on itself.
        choices = [(float(np.linalg.norm(ends[end ^ 1] - ends[end])), ends[end ^ 1])]
        for other in others.tolist():
            point = lines[other].interpolate(lines[other].project(shapely.Point(ends[end])))
            tips = raw[other].points[[0, -1]]
            place = np.array([point.x, point.y])
            tip = tips[int(np.argmin(np.linalg.norm(tips - ends[end], axis=1)))]
            if not raw[other].closed and np.linalg.norm(tip - ends[end]) <= 1.5 * np.linalg.norm(place - ends[end]):
                place = tip
            choices.append((float(np.linalg.norm(place - ends[end])), place))
        distance, place = min(choices, key=lambda choice: choice[0])
        twice = any(np.linalg.norm(place - one) <= gap or np.linalg.norm(ends[end] - two) <= gap
                    for _, one, two, _ in found)  # fmt: skip
        if gap < distance <= reach and not twice:
            found.append((distance, ends[end], place, int(owner[end])))
    return found


def short_of(slits: Sequence[Curve], rings: Sequence[Any], gap: float, measure: Measure) -> list[str]:
    """A word on slits that stop just short of a rim, a hole or another slit, and the tolerance that joins them.

    Parameters
    ----------
    slits : sequence of Curve
        As they are in the sheet.
    rings : sequence of shapely LineString
        Rims of the sheet and of its holes.
    gap : float
        Ends nearer than this are joined.
    measure : Measure
        How to say places.
    """
    numbers, ends = open_ends(slits)
    if not numbers:
        return []
    points = shapely.points(ends)
    lines = np.concatenate([lines_of(slits), np.array(rings, dtype=object)])
    end, line = shapely.STRtree(lines).query(points, predicate="dwithin", distance=SHORT * gap)
    other = np.repeat(numbers, 2)[end] != line
    end, line = end[other], line[other]
    distance = shapely.distance(points[end], lines[line])
    nearest = np.full(len(ends), np.inf)
    np.minimum.at(nearest, end, distance)
    short = np.flatnonzero((nearest > gap) & np.isfinite(nearest))
    if not short.size:
        return []
    _, words, length = measure.tolerance(float(nearest[short].max()))
    places = ", ".join(f"{measure.length(float(nearest[k]))} at {measure.point(ends[k])}" for k in short[:4])
    return [
        f"{counted(len(short), 'end')} of slits just short of what they point at: a bridge of {places}"
        f"{', ...' if len(short) > 4 else ''} is left; `tolerance={words}` or `tolerance={length}` closes it"
    ]
