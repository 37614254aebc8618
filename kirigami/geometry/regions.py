"""Named parts of a sheet: polygons whose borders are edges of the mesh and whose facets it keeps by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from kirigami.errors import GeometryError
from kirigami.primitives.checks import require_array, require_mapping

OUTSIDE = 1e-9  # area of a region beyond the sheet over that of the sheet, below which it is rounding


def checked_regions(regions: Any, outline: shapely.Polygon) -> dict[str, BaseGeometry]:
    """Regions by name as polygons of shapely.

    Raises
    ------
    GeometryError
        A region that is no polygon, crosses itself, is empty or lies outside of the sheet.
    """
    found: dict[str, BaseGeometry] = {}
    given: Mapping[Any, Any] = {} if regions is None else require_mapping(regions, "regions", "Sheet", GeometryError)
    for name, region in given.items():
        if not isinstance(region, BaseGeometry):
            points = require_array(region, (None, 2), name=f"region {name!r}", owner="Sheet", error=GeometryError)
            if len(points) < 3:
                raise GeometryError(f"region {name!r} must be a polygon: give at least three (x, y) pairs")
            region = shapely.Polygon(points)
        if not isinstance(region, (shapely.Polygon, shapely.MultiPolygon)):
            raise GeometryError(f"region {name!r} is a {region.geom_type}: only polygons have facets")
        if not np.isfinite(shapely.get_coordinates(region)).all():
            raise GeometryError(f"region {name!r} has a coordinate that is not finite")
        if not region.is_valid:
            raise GeometryError(f"region {name!r} is not a simple polygon: {shapely.is_valid_reason(region)}")
        if not region.area > 0:
            raise GeometryError(f"region {name!r} is empty: it has no area")
        region = shapely.force_2d(region)
        if not shapely.intersection(region, outline).area > OUTSIDE * outline.area:
            raise GeometryError(f"region {name!r} lies outside of the sheet")
        found[name] = region
    return found


def region_borders(regions: Mapping[str, BaseGeometry], outline: shapely.Polygon) -> list[shapely.LineString]:
    """Lines along the borders of regions, as far as they run inside the sheet."""
    found = []
    for region in regions.values():
        inside = shapely.difference(shapely.intersection(region.boundary, outline), outline.boundary)
        found += [line for line in shapely.get_parts(shapely.line_merge(inside)) if line.length > 0]
    return found


def region_facets(
    regions: Mapping[str, BaseGeometry], nodes: NDArray[np.float64], triangles: NDArray[np.int64]
) -> dict[str, NDArray[np.int64]]:
    """Facets of each region, those whose centre lies in it."""
    if not regions:
        return {}
    centre = nodes[triangles].mean(axis=1)
    found = {
        name: np.flatnonzero(shapely.contains_xy(region, centre[:, 0], centre[:, 1]))
        for name, region in regions.items()
    }
    for name, facets in found.items():
        if not facets.size:
            raise GeometryError(
                f"region {name!r} is empty: no facet lies in it, since it is smaller than the details that are kept or "
                "lies in an opening"
            )
    return found
