"""Cuts and folds within the rim: what sticks out is trimmed, what lies outside is left out, scrap falls out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.drawing.curves import Curve, lines_of
from kirigami.drawing.measure import Measure
from kirigami.drawing.network import Network, network
from kirigami.drawing.rim import NODING
from kirigami.errors import GeometryError
from kirigami.words import counted

SCRAP = 0.1  # of the sheet: a piece at the rim as small as this falls out, a larger one may be wanted
SPECK = 1e-9  # of the sheet: what is smaller has come from rounding


@dataclass
class Trimmed:
    """Curves within the rim, and what became of the others."""

    inside: list[Curve] = field(default_factory=list)
    outside: list[Curve] = field(default_factory=list)
    along: list[Curve] = field(default_factory=list)
    shortened: list[Curve] = field(default_factory=list)
    notches: list[Curve] = field(default_factory=list)


def trimmed(curves: Sequence[Curve], rim: Any, gap: float) -> Trimmed:
    """Cut curves off at the rim.

    Closed curves that reach over the rim stay whole: as openings they are notches.

    Parameters
    ----------
    curves : sequence of Curve
        Joined.
    rim : shapely Polygon
        The sheet without its holes.
    gap : float
        What sticks out less is as good as on the rim.
    """
    result = Trimmed()
    if not curves:
        return result
    lines = lines_of(curves)
    wide = rim.buffer(gap)
    strip = rim.exterior.buffer(gap)
    shapely.prepare(wide)
    shapely.prepare(strip)
    within, on_rim = shapely.covered_by(lines, wide), shapely.covered_by(lines, strip)
    for curve, line, is_within, is_along in zip(curves, lines, within.tolist(), on_rim.tolist()):
        if not line.length:  # smaller than a gap, and led onto one point by what it meets
            continue
        if is_along:
            result.along.append(curve)
        elif is_within:
            result.inside.append(curve)
        elif curve.closed:
            opening = shapely.Polygon(curve.points)
            common = shapely.make_valid(opening).intersection(rim).area
            if common <= gap * line.length or opening.covers(rim):  # beside the sheet, or a frame round it
                result.outside.append(curve)
            else:
                result.inside.append(curve)
                result.notches.append(curve)
        else:
            pieces = [
                replace(curve, points=shapely.get_coordinates(piece), bow=0.0)
                for piece in shapely.get_parts(shapely.line_merge(line.intersection(rim)))
                if piece.length > 2 * gap and not strip.covers(piece)
            ]
            if pieces:
                result.shortened.append(curve)
                result.inside += pieces
            else:
                result.outside.append(curve)
    return result


@dataclass(frozen=True, eq=False)
class Whole:
    """The sheet without its scrap: the rim, the slits that are left, the openings that scrap has left, and notes.

    `body` is what is left of the sheet, or None where nothing fell out, `parts` how many there were to pick from.
    """

    rim: Any
    slits: list[Curve]
    openings: list[Any]
    notes: list[str]
    body: Any = None
    parts: int = 1

    def bounded_by(self, shape: Any, gap: float) -> bool:
        """Whether a hole still is one of the sheet, and not of what fell out."""
        return self.body is None or bool(shapely.dwithin(self.body, shape, gap))


def without_scrap(
    rim: Any, slits: Sequence[Curve], holes: Sequence[Any], gap: float, measure: Measure, part: int | None
) -> Whole:
    """Take out the pieces that slits cut loose.

    A piece inside, which nothing holds, leaves an opening. A small piece at the rim leaves a notch; a large one may be
    wanted, so that the user must say which part to keep.

    Parameters
    ----------
    rim : shapely Polygon
        The sheet without its holes.
    slits : sequence of Curve
        Open cuts, trimmed to the rim.
    holes : sequence of shapely Polygon
        Closed cuts, and the holes of the outline.
    gap : float
        Ends nearer than this were joined.
    measure : Measure
        How to say places.
    part : int, optional
        Which of several large parts to keep, from 1.

    Returns
    -------
    Whole
        As it was where several parts are large and none was picked; the note says so.

    Raises
    ------
    GeometryError
        There is no such part.
    """
    same = Whole(rim, list(slits), [], [])
    touching = _touching(rim, slits, holes, gap)
    if not touching:
        return same
    hole_lines = [shapely.get_coordinates(ring) for hole in holes for ring in (hole.exterior, *hole.interiors)]
    base = [shapely.get_coordinates(rim.exterior), *hole_lines]
    lines = network([*base, *(slits[k].points for k in touching)], NODING * gap)
    faces = [face for face in lines.faces(slice(None)) if face.area > SPECK * rim.area]
    if len(faces) < 2:
        return same
    spots = np.array([face.representative_point() for face in faces], dtype=object)
    void = shapely.contains(shapely.union_all(list(holes)), spots) if holes else np.zeros(len(faces), bool)
    shapely.prepare(rim)
    within = shapely.contains(rim, spots)
    pieces = [k for k in range(len(faces)) if within[k] and not void[k]]
    if len(pieces) < 2:
        return same
    at_rim = [bool(faces[k].exterior.buffer(gap).intersection(rim.exterior).length > 4 * gap) for k in pieces]
    least = SCRAP * faces[pieces[0]].area
    large = [k for k, at in zip(pieces, at_rim) if k == pieces[0] or (at and faces[k].area > least)]
    told = "; ".join(
        f"part {number}: {measure.box(faces[k].bounds)}, area {measure.area(faces[k].area)}"
        for number, k in enumerate(large[:8], start=1)
    )
    if len(large) > 1 and part is None:
        doubtful = [slits[k] for k in touching if slits[k].role != "cut"]
        names = sorted({name for slit in doubtful for name in [slit.layer or slit.color] if name})
        option = " (" + ", ".join(f"`folds={name!r}`" for name in names[:3]) + ")" if names else ""
        text = (
            f"the cuts sever the sheet into {counted(len(large), 'part')} ({told}): shorten a cut, say that it is a "
            "fold"
        )
        return Whole(rim, list(slits), [], [f"{text}{option}, or keep one part with `part=1`"])
    if len(large) > 1 and part is not None and not 1 <= part <= len(large):
        raise GeometryError(f"there is no part {part}: {told}")
    kept = large[part - 1] if part is not None and len(large) > 1 else pieces[0]
    body = shapely.Polygon(faces[kept].exterior)
    scrap = [k for k in pieces if k != kept]
    inner = [k for k in scrap if body.covers(faces[k].representative_point())]
    outer = [k for k in scrap if k not in inner]
    new_rim = rim
    if outer:
        left = shapely.union_all([faces[k] for k in range(len(faces)) if within[k] and k not in outer])
        new_rim = shapely.Polygon(max(shapely.get_parts(left), key=lambda shape: shape.area).exterior)
    left_slits = _left(lines, len(base), touching, slits, faces[kept])
    fallen = [f"{measure.area(faces[k].area)} at {measure.box(faces[k].bounds)}" for k in scrap]
    more = f"; and {len(fallen) - 6} more" if len(fallen) > 6 else ""
    verb = "falls" if len(scrap) == 1 else "fall"
    note = f"{counted(len(scrap), 'piece')} that cuts sever {verb} out: {'; '.join(fallen[:6])}{more}"
    openings = [shapely.Polygon(faces[k].exterior) for k in inner]
    return Whole(new_rim, left_slits, openings, [note], faces[kept], len(large))


def _touching(rim: Any, slits: Sequence[Curve], holes: Sequence[Any], gap: float) -> list[int]:
    """Numbers of the slits that meet something in two places or more, and so may sever."""
    if not slits:
        return []
    lines = lines_of(slits)
    rings = [rim.exterior, *(ring for hole in holes for ring in (hole.exterior, *hole.interiors))]
    tree = shapely.STRtree([*lines, *rings])
    one, other = tree.query(lines, predicate="dwithin", distance=NODING * gap)
    meets = np.bincount(one[one != other], minlength=len(lines))
    # A slit that meets one thing may meet it twice; one that meets itself is found by its own crossings.
    loops = ~shapely.is_simple(lines)
    return [int(number) for number in np.flatnonzero((meets > 0) | loops)]


def _left(lines: Network, first: int, touching: list[int], slits: Sequence[Curve], sheet: Any) -> list[Curve]:
    """Slits that still lie in the sheet; of those that bound it or lie in scrap in part, what is left."""
    every = lines.lines(slice(None))
    middles = shapely.line_interpolate_point(every, 0.5, normalized=True)
    shapely.prepare(sheet)
    inside: NDArray[np.bool_] = shapely.contains(sheet, middles)
    for ring in (sheet.exterior, *sheet.interiors):
        inside[lines.ring(ring)] = False
    order = {number: position for position, number in enumerate(touching)}
    left: list[Curve] = []
    for number, slit in enumerate(slits):
        if number not in order:
            if sheet.covers(shapely.LineString(slit.points).interpolate(0.5, normalized=True)):
                left.append(slit)
            continue
        own = lines.of_line(first + order[number])
        if inside[own].all():
            left.append(slit)
        elif inside[own].any():
            merged = shapely.line_merge(shapely.multilinestrings(every[own[inside[own]]]))
            parts = shapely.get_parts(merged)
            left += [replace(slit, points=shapely.get_coordinates(piece), bow=0.0) for piece in parts]
    return left


def without_effect(slits: Sequence[Curve], openings: Sequence[Any]) -> tuple[list[Curve], list[Curve]]:
    """The slits that cut something, and those that lie in an opening, where nothing is left to be cut."""
    if not slits or not openings:
        return list(slits), []
    lines, tree = lines_of(slits), shapely.STRtree(list(openings))
    in_vain = np.zeros(len(slits), bool)
    in_vain[tree.query(lines, predicate="covered_by")[0]] = True
    return (
        [slit for slit, flag in zip(slits, in_vain) if not flag],
        [slit for slit, flag in zip(slits, in_vain) if flag],
    )
