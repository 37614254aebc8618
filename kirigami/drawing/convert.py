"""Drawings read and written by the ending of their name."""

from __future__ import annotations

import importlib
import inspect
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from kirigami.drawing.drawing import Drawing
from kirigami.errors import GeometryError
from kirigami.geometry.sheet import Sheet
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
    >>> read_drawing("plate.step")
    Traceback (most recent call last):
    kirigami.errors.GeometryError: plate.step: drawings end in .dxf, .svg, .geojson, .json, .fold
    """
    read = _of_format("read", path)
    unknown = sorted(options.keys() - inspect.signature(read).parameters.keys())
    if unknown:
        raise GeometryError(f"{path}: drawings of this kind are read without the option {', '.join(unknown)}")
    drawing: Drawing = read(path, **options)
    return drawing


def write_drawing(item: Any, path: str | os.PathLike[str], unit: str = "m") -> Path:
    """Write a sheet or drawing by the ending of the name: .dxf, .svg, .geojson, .json or .fold.

    Parameters
    ----------
    item : Sheet or Drawing
        What to write.
    path : path
        The file.
    unit : str
        Unit of length of its coordinates.

    Raises
    ------
    GeometryError
        Another ending.

    Examples
    --------
    >>> import tempfile, shapely
    >>> plate = kg.Sheet(shapely.box(0, 0, 1, 1))
    >>> write_drawing(plate, Path(tempfile.mkdtemp()) / "plate.geojson").name
    'plate.geojson'
    """
    write = _of_format("write", path)
    written: Path = write(item, path, unit=unit)
    return written


def _of_format(verb: str, path: str | os.PathLike[str]) -> Callable[..., Any]:
    """The function that reads or writes drawings with this ending; only its own library is imported."""
    name = FORMATS.get(Path(path).suffix.lower())
    if name is None:
        raise GeometryError(f"{path}: drawings end in {', '.join(FORMATS)}")
    found: Callable[..., Any] = getattr(importlib.import_module(f"kirigami.drawing.{name}"), f"{verb}_{name}")
    return found


def sheet_from_dxf(
    path: str | os.PathLike[str], thickness: float | None = None, material: Material | None = None, **options: Any
) -> Sheet:
    """Read a sheet from a DXF drawing of any version.

    Parameters
    ----------
    path : path
        The file.
    thickness : float, optional
        Thickness, in the unit of the sheet [m].
    material : Material, optional
        Of the sheet.
    **options
        Of :func:`kirigami.drawing.dxf.read_dxf`: layers of outline, cuts and folds, units, tolerances.

    Raises
    ------
    GeometryError
        The drawing cannot be read, or has no closed outline.
    KirigamiError
        ezdxf is not installed.

    Examples
    --------
    >>> import kirigami as kg, pathlib, shapely, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "plate.dxf"
    >>> file = kg.Sheet(shapely.box(0, 0, 0.2, 0.1), [[(0.05, 0.05), (0.15, 0.05)]]).to_dxf(path)
    >>> kg.Sheet.from_dxf(file, thickness=1e-4, cuts="CUTS")
    Sheet(0.2 x 0.1, area 0.02, 1 slit, 0 openings)
    """
    from kirigami.drawing.dxf import read_dxf

    return read_dxf(path, **options).sheet(thickness, material)


def sheet_from_svg(
    path: str | os.PathLike[str], thickness: float | None = None, material: Material | None = None, **options: Any
) -> Sheet:
    """Read a sheet from an SVG drawing.

    Parameters
    ----------
    path : path
        The file.
    thickness : float, optional
        Thickness, in the unit of the sheet [m].
    material : Material, optional
        Of the sheet.
    **options
        Of :func:`kirigami.drawing.svg.read_svg`: layers or colours of outline, cuts and folds, units, tolerances.

    Raises
    ------
    GeometryError
        The drawing cannot be read, or has no closed outline.
    KirigamiError
        svgelements is not installed.

    Examples
    --------
    >>> import kirigami as kg, pathlib, shapely, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "plate.svg"
    >>> file = kg.Sheet(shapely.box(0, 0, 0.2, 0.1), [[(0.05, 0.05), (0.15, 0.05)]]).to_svg(path)
    >>> kg.Sheet.from_svg(file, cuts="red")
    Sheet(0.2 x 0.1, area 0.02, 1 slit, 0 openings)
    """
    from kirigami.drawing.svg import read_svg

    return read_svg(path, **options).sheet(thickness, material)


def sheet_from_geojson(
    path: str | os.PathLike[str], thickness: float | None = None, material: Material | None = None, **options: Any
) -> Sheet:
    """Read a sheet from GeoJSON features or geometries.

    Parameters
    ----------
    path : path
        The file.
    thickness : float, optional
        Thickness, in the unit of the sheet [m].
    material : Material, optional
        Of the sheet.
    **options
        Of :func:`kirigami.drawing.geojson.read_geojson`: roles of the features, units, tolerance.

    Raises
    ------
    GeometryError
        The file cannot be read, or has no closed outline.

    Examples
    --------
    >>> import kirigami as kg, pathlib, shapely, tempfile
    >>> file = kg.Sheet(shapely.box(0, 0, 2, 1)).to_geojson(pathlib.Path(tempfile.mkdtemp()) / "plate.geojson")
    >>> kg.Sheet.from_geojson(file)
    Sheet(2 x 1, area 2, 0 slits, 0 openings)
    """
    from kirigami.drawing.geojson import read_geojson

    return read_geojson(path, **options).sheet(thickness, material)


def sheet_from_fold(
    path: str | os.PathLike[str], thickness: float | None = None, material: Material | None = None, **options: Any
) -> Sheet:
    """Read a sheet from the crease pattern of a FOLD file.

    Parameters
    ----------
    path : path
        The file.
    thickness : float, optional
        Thickness, in the unit of the sheet [m].
    material : Material, optional
        Of the sheet.
    **options
        Of :func:`kirigami.drawing.fold.read_fold`: which creases are folds, units, tolerance.

    Raises
    ------
    GeometryError
        The file cannot be read, or has no outline.

    Examples
    --------
    >>> import kirigami as kg, pathlib, shapely, tempfile
    >>> plate = kg.Sheet(shapely.box(0, 0, 2, 1), [[(0.5, 0.5), (1.5, 0.5)]])
    >>> kg.Sheet.from_fold(plate.to_fold(pathlib.Path(tempfile.mkdtemp()) / "plate.fold"))
    Sheet(2 x 1, area 2, 1 slit, 0 openings)
    """
    from kirigami.drawing.fold import read_fold

    return read_fold(path, **options).sheet(thickness, material)
