"""GeoJSON drawings in and out, through shapely."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely.geometry import mapping, shape

from kirigami.drawing.curves import Curve, scale_of, scaled
from kirigami.drawing.drawing import Drawing, assemble
from kirigami.drawing.roles import Names, Roles, color_name
from kirigami.drawing.strokes import FOLD_LAYERS, folds_of
from kirigami.errors import GeometryError, KirigamiWarning
from kirigami.files import read_json, whole_file
from kirigami.primitives.checks import require_path
from kirigami.units import metres_per
from kirigami.words import counted

DEGREES = ("CRS84", "EPSG::4326", "EPSG:4326")  # coordinate systems of longitude and latitude
ROLE_KEYS = ("role", "layer", "Layer", "name")  # the property of a feature that names its layer, first match


def read_geojson(
    path: str | os.PathLike[str],
    *,
    outline: Names = None,
    cuts: Names = None,
    folds: Names = None,
    ignore: Names = None,
    regions: Names = None,
    unit: str = "m",
    drawn_in: str | None = None,
    tolerance: float | str = 1e-4,
    part: int | None = None,
) -> Drawing:
    """Read outline, cuts and folds from a GeoJSON file.

    The property "role" (or "layer", "name") of a feature names its layer; how layers become roles is said at
    :func:`kirigami.drawing.dxf.read_dxf`. Coordinates are plane; a member "unit" of the collection names their unit.

    Parameters
    ----------
    path : path
        The file.
    outline, cuts, folds, ignore : str or list of str, optional
        Layers that hold each kind of curve.
    regions : str or list of str, optional
        Those whose closed curves are regions of the sheet of the same name, to give thickness, material or loads to;
        they are not cut.
    unit : str
        Unit of length of the sheet: "m", "mm", ...
    drawn_in : str, optional
        Unit of the coordinates, where the file does not say.
    tolerance : float or str
        Ends nearer than this fraction of the size, or this length ("0.1mm"), are joined; curves as near as this all
        along are drawn twice.
    part : int, optional
        Which part to take, from 1, where several lie side by side or cuts sever the sheet.

    Raises
    ------
    GeometryError
        No such file, no GeoJSON, a geometry that cannot be used (named by the number of its feature), no outline.

    Examples
    --------
    >>> from pathlib import Path
    >>> import shapely
    >>> from kirigami.drawing.drawing import Drawing
    >>> from kirigami.drawing.geojson import read_geojson, write_geojson
    >>> import tempfile
    >>> plate = Drawing(shapely.box(0, 0, 2, 1), (shapely.LineString([(0.5, 0.5), (1.5, 0.5)]),), unit="m")
    >>> read_geojson(write_geojson(plate, Path(tempfile.mkdtemp()) / "plate.geojson")).outline.area
    2.0
    """
    path = require_path(path, "path", "read_geojson", GeometryError)
    data = read_json(path, "GeoJSON")
    kind = data.get("type") if isinstance(data, dict) else None
    if kind == "FeatureCollection" and isinstance(data.get("features"), list):
        features = data["features"]
    elif kind == "Feature":
        features = [data]
    elif kind == "GeometryCollection" and isinstance(data.get("geometries"), list):
        features = [{"geometry": geometry} for geometry in data["geometries"]]
    elif kind is not None and "coordinates" in data:
        features = [{"geometry": data}]
    else:
        raise GeometryError(f"{path} is no GeoJSON: it has no features and no geometry")
    notes = [f"{path.name}: GeoJSON with {counted(len(features), 'feature')}"]
    frame = data.get("crs")
    if isinstance(frame, dict) and any(name in str(frame) for name in DEGREES):
        text = "the coordinates are degrees of longitude and latitude, not lengths: project the drawing first"
        warnings.warn(text, KirigamiWarning, stacklevel=3)
        notes.append(text)
    factor, unit = scale_of(unit, drawn_in, data.get("unit"), notes)
    curves = []
    for number, feature in enumerate(features):
        source = f"feature {number}"
        if isinstance(feature, dict) and feature.get("geometry", "") is None:  # as the format allows: it has no place
            notes.append(f"{source} has no geometry, and is left out")
            continue
        try:
            with np.errstate(invalid="ignore"):  # coordinates that are not finite are refused by name later
                geometry = shape(feature["geometry"])
            properties = feature.get("properties") or {}
        except (AttributeError, KeyError, TypeError, ValueError, IndexError, shapely.errors.ShapelyError):
            raise GeometryError(
                f"{path}, {source}: no geometry that can be used; its type and coordinates are not as GeoJSON has them"
            ) from None
        layer = str(next((properties[key] for key in ROLE_KEYS if properties.get(key)), ""))
        color = color_name(str(properties.get("stroke") or ""))  # as simplestyle-spec has it
        for line in _lines(geometry, f"{path}, {source}"):
            curves.append(Curve(scaled(shapely.get_coordinates(line), factor), layer, color, source))
    roles = Roles(outline, cuts, folds, ignore, regions)
    shown = drawn_in or data.get("unit")
    return assemble(curves, roles, unit=unit, tolerance=tolerance, notes=notes, shown=shown, part=part)


def _lines(geometry: Any, source: str) -> Iterator[Any]:
    if geometry.is_empty:
        return
    if geometry.has_z and np.ptp(np.nan_to_num(shapely.get_coordinates(geometry, include_z=True)[:, 2])) > 0:
        raise GeometryError(f"{source} leaves the plane: its coordinates have different z")
    if isinstance(geometry, shapely.Polygon):
        yield from (geometry.exterior, *geometry.interiors)
    elif hasattr(geometry, "geoms"):
        for part in geometry.geoms:
            yield from _lines(part, source)
    elif isinstance(geometry, shapely.LineString):
        yield geometry
    else:
        raise GeometryError(f"{source}: a {geometry.geom_type} is neither outline nor cut nor fold")


def write_geojson(sheet: Any, path: str | os.PathLike[str], *, unit: str = "m", folds: Iterable[Any] = ()) -> Path:
    """Write outline, cuts and folds as features with the property "role"; coordinates as they are.

    Parameters
    ----------
    sheet : Sheet or Drawing
        Its ``outline`` and ``cuts``; of a drawing also its ``folds``.
    path : path
        The file.
    unit : str
        Unit of length of the sheet, noted in the file.
    folds : iterable of LineString
        Lines to be folded and not cut.

    Raises
    ------
    KirigamiError
        The file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> import shapely
    >>> from kirigami.drawing.drawing import Drawing
    >>> from kirigami.drawing.geojson import write_geojson
    >>> import tempfile
    >>> plate = Drawing(shapely.box(0, 0, 2, 1), ())
    >>> write_geojson(plate, Path(tempfile.mkdtemp()) / "plate.geojson").name
    'plate.geojson'
    """
    metres_per(unit)
    extra = folds_of(sheet, folds)
    parts = [("outline", sheet.outline)]
    parts += [("cut", cut) for cut in sheet.cuts]
    parts += [(FOLD_LAYERS[np.sign(side)].lower().removesuffix("s"), fold) for fold, side in extra]
    features = [{"type": "Feature", "properties": {"role": role}, "geometry": mapping(part)} for role, part in parts]
    target = require_path(path, "path", "to_geojson", GeometryError)
    with whole_file(target) as unfinished:
        unfinished.write_text(json.dumps({"type": "FeatureCollection", "unit": unit, "features": features}, indent=1))
    return target
