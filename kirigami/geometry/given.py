"""Outlines, cuts, folds and lines as users give them: checked, taken apart, without heights."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from kirigami.errors import GeometryError, KirigamiWarning
from kirigami.geometry.fold_line import Fold
from kirigami.words import counted


def is_coordinates(item: Any) -> bool:
    try:
        array = np.asarray(item, dtype=float)
    except Exception:  # ragged, too large for a number, or foreign
        return False
    return array.ndim == 2 and array.shape[1] in (2, 3)


def checked_outline(outline: Any) -> shapely.Polygon:
    if not isinstance(outline, BaseGeometry):
        if not is_coordinates(outline) or len(outline) < 3:
            raise GeometryError("the outline must be a shapely Polygon or at least three (x, y) pairs")
        _check_finite(np.asarray(outline, dtype=float), "the outline")
        outline = shapely.Polygon(outline)
    if isinstance(outline, shapely.MultiPolygon) and len(outline.geoms) == 1:
        outline = outline.geoms[0]
    if not isinstance(outline, shapely.Polygon):
        parts = f" of {counted(len(outline.geoms), 'part')}" if hasattr(outline, "geoms") else ""
        raise GeometryError(f"the outline must be one Polygon, not a {outline.geom_type}{parts}")
    checked = checked_line_or_polygon(outline, "the outline")
    assert isinstance(checked, shapely.Polygon)
    return checked


def checked_line_or_polygon(geometry: BaseGeometry, what: str) -> BaseGeometry:
    if not isinstance(geometry, (shapely.LineString, shapely.Polygon)):
        raise GeometryError(f"{what} is a {geometry.geom_type}; only lines (slits) and polygons (openings) can be cut")
    if geometry.is_empty:
        raise GeometryError(f"{what} is empty")
    coordinates = shapely.get_coordinates(geometry)
    _check_finite(coordinates, what)
    geometry = _in_plane(geometry, what)
    if isinstance(geometry, shapely.Polygon):
        if not geometry.is_valid:
            raise GeometryError(f"{what} is not a simple polygon: {shapely.is_valid_reason(geometry)}")
        if not geometry.area > 0:
            raise GeometryError(f"{what} near {tuple(coordinates[0].tolist()) if len(coordinates) else ()} has no area")
    return geometry


def _in_plane(geometry: BaseGeometry, what: str) -> BaseGeometry:
    """The geometry without its heights, which must be one and the same: a sheet is cut flat and bent later."""
    heights = np.nan_to_num(shapely.get_coordinates(geometry, include_z=True)[:, 2])  # without one it is at zero
    low, high = float(heights.min()), float(heights.max())
    if high > low:
        raise GeometryError(
            f"{what} leaves the plane: z runs from {low:.6g} to {high:.6g}. A sheet is drawn flat; bend the mesh or "
            "move nodes of the model instead"
        )
    if high != 0.0:
        warnings.warn(f"{what} lies at z = {high:.6g}; the sheet is taken at z = 0", KirigamiWarning, stacklevel=5)
    return shapely.force_2d(geometry)


def _check_finite(coordinates: NDArray[np.float64], what: str) -> None:
    bad = np.flatnonzero(~np.isfinite(coordinates[:, :2]).all(axis=1))
    if bad.size:
        raise GeometryError(f"{what} has a coordinate that is not finite: point {bad[0]} is {coordinates[bad[0]]}")


def flattened(cuts: Any) -> Iterable[BaseGeometry]:
    """Simple geometries of nested collections and lists, in order."""
    if isinstance(cuts, BaseGeometry):
        if hasattr(cuts, "geoms"):
            for part in cuts.geoms:
                yield from flattened(part)
        elif not cuts.is_empty:
            yield cuts
    elif is_coordinates(cuts):
        points = np.asarray(cuts, dtype=float)
        if len(points) < 2:
            raise GeometryError(f"a slit needs at least two points, not {points.tolist()}")
        yield shapely.LineString(points)
    elif isinstance(cuts, Iterable) and not isinstance(cuts, (str, bytes, Mapping)):
        for part in cuts:
            yield from flattened(part)
    else:
        raise GeometryError(f"cuts must be shapely geometries, points or lists of them, not {type(cuts).__name__}")


def named_lines(lines: Any) -> tuple[list[str], list[BaseGeometry]]:
    """Names and geometries of the embedded lines; a collection under one name is taken apart under that name."""
    items = lines.items() if isinstance(lines, Mapping) else [("", lines)]
    names, geometries = [], []
    for name, geometry in items:
        for part in flattened(geometry):
            names.append(name)
            geometries.append(checked_line_or_polygon(part, f"line {name!r}"))
    return names, geometries


def folds_of(given: Any) -> Iterable[Fold]:
    """The folds of nested lists of folds, lines and points, in order."""
    if isinstance(given, Fold):
        yield given
    elif isinstance(given, BaseGeometry) or is_coordinates(given):
        for line in flattened(given):
            yield Fold(line)
    elif isinstance(given, Iterable) and not isinstance(given, (str, bytes, Mapping)):
        for part in given:
            yield from folds_of(part)
    else:
        raise GeometryError(f"folds must be lines, points, Folds or lists of them, not {type(given).__name__}")
