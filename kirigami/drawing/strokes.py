"""What a cutter follows: the lines of a sheet or drawing with layers, colours and arcs, with or without a kerf."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from kirigami.drawing.arcs import bulges_of, merged
from kirigami.drawing.curves import Floats
from kirigami.drawing.kerf import compensated, on_circles
from kirigami.errors import GeometryError
from kirigami.primitives.checks import require_items, require_not_negative, shown

NARROWEST = 1e-9  # kerf over size of the sheet; what is less is lost in rounding
NONE = np.empty((0, 3))
FOLD_LAYERS = {0.0: "FOLDS", 1.0: "VALLEY FOLDS", -1.0: "MOUNTAIN FOLDS"}


@dataclass(frozen=True)
class Ink:
    """Colours in which the lines of a drawing were drawn: of the rim, the holes, each cut and each fold."""

    outline: str = ""
    holes: tuple[str, ...] = ()
    cuts: tuple[str, ...] = ()
    folds: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Stroke:
    """One line: points (k, 2), of closed ones the first not repeated, and the bulge of every piece (0 straight)."""

    layer: str
    points: Floats
    closed: bool
    bulges: NDArray[np.float64]
    color: str = ""


def folds_of(sheet: Any, more: Iterable[Any]) -> list[tuple[Any, float]]:
    """The folds of a sheet or drawing, and more of them: lines, and the angle or share that tells their side, or 0."""
    if not hasattr(sheet, "outline") or not hasattr(sheet, "cuts"):
        raise GeometryError(f"writing a drawing: it must be a Sheet or a Drawing, got {shown(sheet)}")
    own = list(getattr(sheet, "folds", ()))
    sides = [*getattr(sheet, "fold_shares", ()), *(0.0 for _ in own)]
    added = [(fold, 0.0) for fold in require_items(more, "folds", "writing a drawing", GeometryError)]
    found = []
    for fold, side in [*zip(own, sides), *added]:
        line, side = getattr(fold, "line", fold), getattr(fold, "angle", side)
        if not isinstance(line, BaseGeometry):
            raise GeometryError(f"writing a drawing: folds must be lines of shapely, got {shown(fold)}")
        found.append((line, side))
    return found


def strokes(sheet: Any, folds: Iterable[Any] = (), kerf: float = 0.0, arcs: bool = True) -> list[Stroke]:
    """Every line of a sheet or drawing.

    Parameters
    ----------
    sheet : Sheet or Drawing
        What to cut.
    folds : iterable of LineString
        More folds.
    kerf : float
        Width of what the cutter takes away [length, in the unit of the sheet]: the rim grows and openings shrink by
        half of it, slits and folds stay.
    arcs : bool
        Arcs as arcs, instead of the chords that they were read as.

    Raises
    ------
    GeometryError
        Folds that are no lines, a negative kerf, or one as wide as an opening.
    """
    kerf = require_not_negative(kerf, "kerf", "writing a drawing", GeometryError)
    extra = folds_of(sheet, folds)
    size = max(np.ptp(np.reshape(sheet.outline.bounds, (2, 2)), axis=0).tolist())
    if kerf and not NARROWEST * size < kerf < size:
        amiss = "wide" if kerf >= size else "narrow"
        raise GeometryError(f"writing a drawing: a kerf of {kerf:.6g} is too {amiss} for a sheet of {size:.6g}")
    ink = getattr(sheet, "ink", None) or Ink()
    circles = getattr(sheet, "circles", NONE) if arcs else NONE
    outline, cuts = sheet.outline, list(sheet.cuts)
    cut_colors = [*ink.cuts, *[""] * len(cuts)][: len(cuts)]
    if kerf:
        outline, cuts, cut_colors = compensated(outline, cuts, cut_colors, kerf)
    holes = [*ink.holes, *[""] * len(outline.interiors)]
    drawn: list[tuple[str, Any, str]] = [("OUTLINE", outline.exterior, ink.outline)]
    drawn += [("OUTLINE", ring, color) for ring, color in zip(outline.interiors, holes)]
    drawn += [("CUTS", line, color) for cut, color in zip(cuts, cut_colors) for line in _lines_of(cut)]
    fold_colors = [*ink.folds, *[""] * len(extra)]
    drawn += [
        (FOLD_LAYERS[float(np.sign(side))], line, color)
        for (fold, side), color in zip(extra, fold_colors)
        for line in _lines_of(fold)
    ]
    lines = [shapely.get_coordinates(line) for _, line, _ in drawn]
    if kerf and len(circles):
        before = shapely.get_coordinates(shapely.GeometryCollection([sheet.outline, *sheet.cuts]))
        circles, lines = on_circles(lines, before, circles, kerf)
    found = []
    for (layer, _, color), points, bulges in zip(drawn, lines, bulges_of(lines, circles)):
        closed = len(points) > 3 and bool((points[0] == points[-1]).all())
        if bulges.any():
            points, bulges = merged(*_from_a_corner(points, bulges) if closed else (points, bulges))
        shown = "" if color in ("white", "#ffffff") else color  # drawn on black, it would be seen no more
        found.append(Stroke(layer, points[:-1] if closed else points, closed, bulges, shown))
    return found


def _from_a_corner(points: Floats, bulges: NDArray[np.float64]) -> tuple[Floats, NDArray[np.float64]]:
    """A closed line that begins where it is straight or turns, so that no arc is split for its beginning."""
    straight = np.flatnonzero(bulges == 0)
    if not straight.size or straight[0] == 0:
        return points, bulges
    first = int(straight[0])
    open_points = np.roll(points[:-1], -first, axis=0)
    return np.concatenate([open_points, open_points[:1]]), np.roll(bulges, -first)


def _lines_of(geometry: Any) -> Iterator[Any]:
    if isinstance(geometry, shapely.Polygon):
        yield from (geometry.exterior, *geometry.interiors)
    elif hasattr(geometry, "geoms"):
        for part in geometry.geoms:
            yield from _lines_of(part)
    else:
        yield geometry
