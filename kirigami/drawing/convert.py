"""Drawings read and written by the ending of their name."""

from __future__ import annotations

import importlib
import inspect
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from kirigami.drawing.drawing import Drawing
from kirigami.errors import GeometryError, nearest_name
from kirigami.geometry.sheet import Sheet
from kirigami.primitives.checks import require_not_negative
from kirigami.primitives.material import Material

FORMATS = {".dxf": "dxf", ".svg": "svg", ".geojson": "geojson", ".json": "geojson", ".fold": "fold"}


def read_drawing(path: str | os.PathLike[str], **options: Any) -> Drawing:
    """Read a drawing by the ending of its name: .dxf, .svg, .geojson, .json or .fold.

    Parameters
    ----------
    path : path
        The file.
    **options
        As for the reader: :func:`kirigami.drawing.dxf.read_dxf`, :func:`kirigami.drawing.svg.read_svg`,
        :func:`kirigami.drawing.geojson.read_geojson`, :func:`kirigami.drawing.fold.read_fold`.

    Raises
    ------
    GeometryError
        Another ending, an option that its reader does not have, or a drawing that cannot be read.

    Examples
    --------
    >>> from kirigami.drawing.convert import read_drawing
    >>> read_drawing("plate.step")
    Traceback (most recent call last):
    kirigami.errors.GeometryError: plate.step: drawings end in .dxf, .svg, .geojson, .json, .fold
    """
    return _read(_of_format("read", path), path, options)


def _read(reader: Callable[..., Drawing], path: str | os.PathLike[str], options: dict[str, Any]) -> Drawing:
    """What a reader makes of a file, once all options are ones that it has."""
    known = list(inspect.signature(reader).parameters)
    unknown = sorted(options.keys() - set(known))
    if unknown:
        near = nearest_name(unknown[0], known)
        hint = f": did you mean `{near}`?" if near else ""
        raise GeometryError(f"{path}: drawings of this kind are read without the option {', '.join(unknown)}{hint}")
    return reader(path, **options)


def write_drawing(item: Any, path: str | os.PathLike[str], unit: str = "m", kerf: float = 0.0) -> Path:
    """Write a sheet or drawing by the ending of the name: .dxf, .svg, .geojson, .json or .fold.

    Parameters
    ----------
    item : Sheet or Drawing
        What to write.
    path : path
        The file.
    unit : str
        Unit of length of its coordinates.
    kerf : float
        Width of what the cutter takes away [length, in this unit]; of .dxf and .svg.

    Raises
    ------
    GeometryError
        Another ending, a kerf for another kind of file, or an opening that is no wider than the kerf.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.drawing.convert import write_drawing
    >>> import tempfile, shapely, kirigami as kg
    >>> plate = kg.Sheet(shapely.box(0, 0, 1, 1))
    >>> write_drawing(plate, Path(tempfile.mkdtemp()) / "plate.geojson").name
    'plate.geojson'
    """
    write = _of_format("write", path)
    kerf = require_not_negative(kerf, "kerf", "writing a drawing", GeometryError)
    if kerf and "kerf" not in inspect.signature(write).parameters:
        raise GeometryError(f"{path}: only .dxf and .svg are written for a cutter, with a `kerf`")
    written: Path = write(item, path, unit=unit, **({"kerf": kerf} if kerf else {}))
    return written


def _of_format(verb: str, path: str | os.PathLike[str]) -> Callable[..., Any]:
    """The function that reads or writes drawings with this ending; only its own library is imported."""
    name = FORMATS.get(Path(path).suffix.lower())
    if name is None:
        raise GeometryError(f"{path}: drawings end in {', '.join(FORMATS)}")
    found: Callable[..., Any] = getattr(importlib.import_module(f"kirigami.drawing.{name}"), f"{verb}_{name}")
    return found


def _sheet_reader(name: str, kind: str) -> Callable[..., Sheet]:
    """The function behind ``Sheet.from_...`` for one format of drawings."""

    def read(
        path: str | os.PathLike[str],
        thickness: float | None = None,
        material: Material | None = None,
        fold_stiffness: float | None = None,
        fold_angle: float = 0.0,
        **options: Any,
    ) -> Sheet:
        function = getattr(importlib.import_module(f"kirigami.drawing.{name}"), f"read_{name}")
        drawing = _read(function, path, options)
        return drawing.sheet(thickness, material, fold_stiffness=fold_stiffness, fold_angle=fold_angle)

    read.__name__ = f"from_{name}"
    read.__doc__ = f"""Read a sheet from {kind}.

    Parameters
    ----------
    path : path
        The file.
    thickness : float, optional
        Thickness, in the unit of the sheet [m].
    material : Material, optional
        Of the sheet.
    fold_stiffness : float, optional
        Moment per angle and length of its folds [force / rad]; None takes that of :class:`kirigami.Fold`.
    fold_angle : float
        Angle [rad] at which the folds rest: valleys at this one, mountains at its negative, others as
        :meth:`kirigami.drawing.drawing.Drawing.sheet` says.
    **options
        Of :func:`kirigami.drawing.{name}.read_{name}`: roles of the lines, units, tolerances.

    Raises
    ------
    GeometryError
        The drawing cannot be read, or has no closed outline.
    KirigamiError
        The library that reads it is not installed.

    Examples
    --------
    >>> import kirigami as kg, pathlib, shapely, tempfile
    >>> plate = kg.Sheet(shapely.box(0, 0, 0.2, 0.1), [[(0.05, 0.05), (0.15, 0.05)]])
    >>> file = plate.to_{name}(pathlib.Path(tempfile.mkdtemp()) / "plate.{name}")
    >>> kg.Sheet.from_{name}(file)
    Sheet(0.2 x 0.1, area 0.02, 1 slit, 0 openings)
    """
    return read


sheet_from_dxf = _sheet_reader("dxf", "a DXF drawing of any version")
sheet_from_svg = _sheet_reader("svg", "an SVG drawing")
sheet_from_geojson = _sheet_reader("geojson", "GeoJSON features or geometries")
sheet_from_fold = _sheet_reader("fold", "the crease pattern of a FOLD file")
