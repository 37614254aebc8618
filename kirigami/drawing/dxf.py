"""DXF drawings in and out, through ezdxf."""

from __future__ import annotations

import logging
import os
import re
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from kirigami.drawing.arcs import circles_of
from kirigami.drawing.curves import Curve, Floats, all_at_once, flattened, scale_of, scaled
from kirigami.drawing.drawing import Drawing, assemble
from kirigami.drawing.dxf_entities import COLORS as INDEX_COLORS
from kirigami.drawing.dxf_entities import Reader, source_of, unreadable
from kirigami.drawing.roles import COLORS, Names, Roles
from kirigami.drawing.strokes import Stroke, strokes
from kirigami.errors import GeometryError, KirigamiWarning
from kirigami.files import library, whole_file
from kirigami.primitives.checks import require_between, require_choice, require_path
from kirigami.units import metres_per
from kirigami.words import counted

INSUNITS = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m", 7: "km", 9: "mil", 12: "nm", 13: "um", 14: "dm"}

COLOR_OF_LAYER = {"OUTLINE": 7, "CUTS": 1, "FOLDS": 5, "VALLEY FOLDS": 5, "MOUNTAIN FOLDS": 3}


def read_dxf(
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
    flatness: float = 2e-4,
    part: int | None = None,
) -> Drawing:
    """Read outline, cuts and folds from the model space of a DXF file of any version.

    Lines, arcs, circles, ellipses, splines, polylines with bulges, and blocks of them are read; texts, dimensions,
    hatches and points are not, and the report counts them. Nor is read what is not shown: entities that are invisible,
    or on layers that are off, frozen or not plotted, unless these are named.

    Layers are sorted by their names ("outline", "cuts", "fold", ... in several languages) unless told; names such as
    "etch" and "text" are left out, dashed line types are folds, centre lines are left out. Without an outline layer the
    outer face of the lines is the outline: the closed curve round everything else, or the lines that together go round
    it, whose tails beyond their crossings are left out. Closed cuts are holes. Pieces that cuts sever fall out as long
    as they are small.

    Parameters
    ----------
    path : path
        The file.
    outline, cuts, folds, ignore : str or list of str, optional
        Layers, or colours ("red", "#ff0000"), that hold each kind of curve.
    regions : str or list of str, optional
        Those whose closed curves are regions of the sheet of the same name, to give thickness, material or loads to;
        they are not cut.
    unit : str
        Unit of length of the sheet: "m", "mm", ...
    drawn_in : str, optional
        Unit of the drawing, where the file does not say or says it wrong.
    tolerance : float or str
        Ends nearer than this fraction of the size, or this length ("0.1mm"), are joined; curves as near as this all
        along are drawn twice.
    flatness : float
        Largest distance between a curve and its chords, as a fraction of the size of the drawing. Ends of cuts that lie
        on the curve itself are made points of it.
    part : int, optional
        Which part to take, from 1, where several lie side by side or cuts sever the sheet.

    Returns
    -------
    Drawing
        ``drawing.sheet(thickness, material)`` makes the sheet, ``drawing.report`` says what was read.

    Raises
    ------
    GeometryError
        No such file, no DXF file or a broken one; no closed outline; curves out of the plane; an unknown layer.
        Messages name entities by their handles.
    KirigamiError
        ezdxf is not installed.

    Examples
    --------
    >>> from kirigami.drawing.drawing import Drawing
    >>> from kirigami.drawing.dxf import read_dxf, write_dxf
    >>> import shapely, tempfile
    >>> from pathlib import Path
    >>> plate = Drawing(shapely.box(0, 0, 0.2, 0.1), (shapely.LineString([(0.05, 0.05), (0.15, 0.05)]),), unit="m")
    >>> file = write_dxf(plate, Path(tempfile.mkdtemp()) / "plate.dxf")
    >>> drawing = read_dxf(file)
    >>> drawing.outline.bounds, len(drawing.cuts)
    ((0.0, 0.0, 0.2, 0.1), 1)
    """
    path = require_path(path, "path", "read_dxf", GeometryError)
    flatness = require_between(flatness, 1e-9, 1.0, "flatness", "read_dxf", GeometryError)
    document, repaired = _document(path)
    notes = [f"{path.name}: DXF {document.acad_release}"]
    if repaired:
        text = (
            f"{path.name} is damaged, and values that could not be read may now be wrong "
            f"({counted(len(repaired), 'repair')}, the first: {repaired[0]})"
        )
        warnings.warn(text, KirigamiWarning, stacklevel=3)
        notes.append(text)
    # ezdxf fills in metres where a file says nothing, so that the file itself must be asked.
    says_unit = b"$INSUNITS" in path.read_bytes()
    stated = INSUNITS.get(document.header.get("$INSUNITS", 0)) if says_unit else None
    factor, unit = scale_of(unit, drawn_in, stated, notes)
    roles = Roles(outline, cuts, folds, ignore, regions)
    reader = Reader(document, roles.names)
    seen = list(reader.curves(document.modelspace()))
    unseen = ", ".join(f"{number} on {why}" for why, number in reader.unseen.most_common())
    if not seen:
        other = ", ".join(f"{number} {kind}" for kind, number in reader.skipped.items()) or "nothing"
        also = f"; not shown: {unseen}; `cuts={reader.hidden[0]!r}` reads that layer all the same" if unseen else ""
        raise GeometryError(f"{path} holds no curves in its model space (it holds {other}{also})")
    if unseen:
        notes.append(f"not shown and not read: {unseen}")
    if reader.skipped:
        kinds = ", ".join(f"{number} {kind}" for kind, number in reader.skipped.most_common())
        notes.append(f"not read: {kinds}")
    distance = flatness * _extent([curve.entity for curve in seen])
    pieces = [(found, *piece) for found in seen for piece in _points(found.entity, distance)]
    places = all_at_once([points for _, points, _ in pieces], lambda points: scaled(points, factor))
    curves = [
        Curve(place, found.look.layer, found.look.color, found.source, found.look.line_type, scaled(bow, factor))
        for place, (found, _, bow) in zip(places, pieces)
    ]
    shown = drawn_in or stated
    return assemble(curves, roles, unit=unit, tolerance=tolerance, notes=notes, shown=shown, part=part)


def _document(path: Path) -> tuple[Any, list[str]]:
    """The document of a file, and what was repaired in it."""
    ezdxf = library("ezdxf", "reading and writing DXF drawings")
    recover = library("ezdxf.recover", "reading DXF drawings")
    if not path.is_file():
        raise GeometryError(f"there is no file {path}")
    if path.stat().st_size == 0:
        raise GeometryError(f"{path} is empty")
    with _Listener("ezdxf") as listener:
        try:
            return ezdxf.readfile(path), listener.heard
        except Exception as first:
            # ezdxf lets many kinds of error out of a file that is cut off, StopIteration among them.
            if not _looks_like_dxf(path):
                raise GeometryError(f"{path} is no DXF file ({first})") from None
            listener.heard.clear()
            try:  # many programs write files that are not quite right
                return recover.readfile(path)[0], listener.heard
            except Exception as error:
                why = str(first) or str(error) or "it ends too early"
                raise GeometryError(f"{path} is a broken DXF file: {why}") from None


class _Listener(logging.Handler):
    """Hears what a library repairs without more than a line in a log: numbers that are none become others."""

    def __init__(self, library: str) -> None:
        super().__init__(logging.WARNING)
        self.heard: list[str] = []
        self.logger = logging.getLogger(library)

    def emit(self, record: logging.LogRecord) -> None:
        if "invalid" in record.getMessage():
            self.heard.append(record.getMessage())

    def __enter__(self) -> _Listener:
        self.before = self.logger.propagate
        self.logger.addHandler(self)
        self.logger.propagate = False
        return self

    def __exit__(self, *error: object) -> None:
        self.logger.removeHandler(self)
        self.logger.propagate = self.before


def _looks_like_dxf(path: Path) -> bool:
    start = path.read_bytes()[:4096]
    return start.startswith(b"AutoCAD Binary DXF") or b"SECTION" in start


def _points(entity: Any, distance: float) -> Iterator[tuple[Floats, Floats]]:
    """Points of an entity and how far it bows from each chord, for every curve."""
    kind = entity.dxftype()
    try:
        if kind in ("LWPOLYLINE", "POLYLINE"):
            yield _polyline(entity, distance)
        elif kind == "LINE":
            yield _flat([entity.dxf.start, entity.dxf.end], entity), np.zeros(1)
        elif kind == "CIRCLE":
            radius = abs(entity.dxf.radius)
            points = _flat(list(entity.flattening(min(distance, 0.1 * radius))), entity)
            points[-1] = points[0]
            yield points, np.full(len(points) - 1, distance)
        else:
            points = _flat(list(entity.flattening(distance)), entity)
            if np.linalg.norm(points[-1] - points[0]) < 1e-9 * max(1e-300, float(np.ptp(points, axis=0).max())):
                points[-1] = points[0]
            yield points, np.full(len(points) - 1, distance)
    except GeometryError:
        raise
    except Exception as error:  # of a damaged file ezdxf lets many kinds out
        raise unreadable(entity, error) from None


def _polyline(entity: Any, distance: float) -> tuple[Floats, Floats]:
    if entity.dxftype() == "LWPOLYLINE":
        corners, closed = list(entity.vertices_in_wcs()), entity.closed
        bulges = [point[4] for point in entity.get_points()]
    else:
        # A fitted polyline keeps its control frame among its vertices (flag 16): not part of the curve.
        on_curve = [not vertex.dxf.flags & 16 for vertex in entity.vertices]
        corners = [corner for corner, kept in zip(entity.points_in_wcs(), on_curve) if kept]
        bulges = [vertex.dxf.bulge for vertex, kept in zip(entity.vertices, on_curve) if kept]
        closed = entity.is_closed
    points = _flat(corners, entity)
    if closed:
        points = np.concatenate([points, points[:1]])
    mirrored = -1.0 if entity.dxf.hasattr("extrusion") and entity.dxf.extrusion.z < 0 else 1.0
    parts, bows = [points[:1]], []
    for start, end, bulge in zip(points, points[1:], bulges):
        parts.append(_bulge(start, end, mirrored * bulge, distance)[1:] if bulge else end[None])
        bows.append(np.full(len(parts[-1]), distance if bulge else 0.0))
    return np.concatenate(parts), np.concatenate(bows)


def _bulge(start: Floats, end: Floats, bulge: float, distance: float) -> Floats:
    """Arc from start to end; the bulge is the tangent of a quarter of its angle, positive counter-clockwise."""
    chord = end - start
    normal = np.array([-chord[1], chord[0]])
    center = 0.5 * (start + end) + normal * (1 - bulge**2) / (4 * bulge)
    angle = 4 * np.arctan(bulge)
    arm = start - center

    def position(t: Floats) -> Floats:
        c, s = np.cos(angle * t), np.sin(angle * t)
        on_arc: Floats = center + np.column_stack([arm[0] * c - arm[1] * s, arm[0] * s + arm[1] * c])
        return on_arc

    points = flattened(position, distance)
    points[0], points[-1] = start, end
    return points


def _flat(points: list[Any], entity: Any) -> Floats:
    array = np.array([(*point, 0.0)[:3] for point in points], dtype=float)
    if len(array) < 2:
        raise GeometryError(f"{source_of(entity)} on layer {entity.dxf.layer!r} has fewer than two points")
    if not np.isfinite(array).all():
        raise GeometryError(f"{source_of(entity)} on layer {entity.dxf.layer!r} has a coordinate that is not finite")
    if np.ptp(array[:, 2]) > 1e-6 * max(float(np.ptp(array[:, :2], axis=0).max()), 1e-300):
        raise GeometryError(
            f"{source_of(entity)} on layer {entity.dxf.layer!r} leaves the plane: z runs from {array[:, 2].min():.6g} "
            f"to {array[:, 2].max():.6g}; a sheet is drawn in a plane of constant z"
        )
    plane: Floats = array[:, :2].copy()
    return plane


def _extent(entities: list[Any]) -> float:
    """Rough size of the drawing, from points that need no flattening."""
    vector = library("ezdxf.math", "reading DXF drawings").Vec3
    points: list[Any] = []
    for entity in entities:
        try:
            points += [vector(point).vec2 for point in _rough_points(entity)]
        except Exception as error:
            raise unreadable(entity, error) from None
    array = np.array([(point.x, point.y) for point in points], dtype=float)
    finite = array[np.isfinite(array).all(axis=1)]
    return float(np.ptp(finite, axis=0).max()) if len(finite) else 1.0


def _rough_points(entity: Any) -> list[Any]:
    kind = entity.dxftype()
    if kind == "LINE":
        return [entity.dxf.start, entity.dxf.end]
    if kind in ("CIRCLE", "ARC"):
        radius = entity.dxf.radius
        center = entity.ocs().to_wcs(entity.dxf.center)
        return [center + (radius, radius), center - (radius, radius)]
    if kind == "ELLIPSE":
        return [entity.dxf.center + entity.dxf.major_axis, entity.dxf.center - entity.dxf.major_axis]
    if kind == "SPLINE":
        return list(entity.control_points if len(entity.control_points) else entity.fit_points)
    return list(entity.vertices_in_wcs() if kind == "LWPOLYLINE" else entity.points_in_wcs())


def write_dxf(
    sheet: Any,
    path: str | os.PathLike[str],
    *,
    unit: str = "m",
    drawn_in: str = "mm",
    folds: Iterable[Any] = (),
    kerf: float = 0.0,
) -> Path:
    """Write a sheet for the laser cutter: true size, each kind of line on a layer of its own.

    Layers OUTLINE (black), CUTS (red), FOLDS (blue), VALLEY FOLDS and MOUNTAIN FOLDS, units in the header. A drawing
    that was read keeps its colours, its place, and its arcs: as circles and bulges of polylines.

    Parameters
    ----------
    sheet : Sheet or Drawing
        Its outline, cuts and folds.
    path : path
        The file.
    unit : str
        Unit of length of the sheet.
    drawn_in : str
        Unit of length of the file.
    folds : iterable of LineString
        More lines to be folded and not cut.
    kerf : float
        Width of what the cutter takes away [length, in the unit of the sheet]: the rim grows and openings shrink by
        half of it, slits stay.

    Raises
    ------
    KirigamiError
        ezdxf is not installed, the unit is unknown, an opening is no wider than the kerf, the file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.drawing.drawing import Drawing
    >>> from kirigami.drawing.dxf import write_dxf
    >>> import shapely, tempfile
    >>> plate = Drawing(shapely.box(0, 0, 1, 1), ())
    >>> write_dxf(plate, Path(tempfile.mkdtemp()) / "plate.dxf").name
    'plate.dxf'
    """
    ezdxf = library("ezdxf", "reading and writing DXF drawings")
    codes = {name: code for code, name in INSUNITS.items()}
    require_choice(drawn_in, codes, "drawn_in", "to_dxf", GeometryError)
    ratio = metres_per(unit) / metres_per(drawn_in)
    factor = float(round(ratio)) if abs(ratio - round(ratio)) < 1e-12 * ratio else ratio
    lines = strokes(sheet, folds, kerf)
    document = ezdxf.new("R2010", units=codes[drawn_in])
    space = document.modelspace()
    for layer, color in COLOR_OF_LAYER.items():
        if layer in ("OUTLINE", "CUTS", "FOLDS") or any(layer == stroke.layer for stroke in lines):
            document.layers.add(layer, color=color)
    for stroke in lines:
        points, look = scaled(stroke.points, factor), {"layer": stroke.layer, **_colored(stroke.color)}
        if (circle := _circle(stroke, points)) is not None:
            space.add_circle(circle[:2].tolist(), float(circle[2]), dxfattribs=look)
            continue
        bulges = stroke.bulges if stroke.closed else np.append(stroke.bulges, 0.0)
        space.add_lwpolyline(np.column_stack([points, bulges]).tolist(), "xyb", close=stroke.closed, dxfattribs=look)
    target = require_path(path, "path", "to_dxf", GeometryError)
    with whole_file(target) as unfinished:
        document.saveas(unfinished)
    return target


def _colored(color: str) -> dict[str, int]:
    """Attributes of an entity in a colour: by its name, its index ("color 12"), as #rrggbb; else that of its layer."""
    index = next((number for number, name in INDEX_COLORS.items() if name == color), None)
    if index is None and color.startswith("color ") and color[6:].isdigit():
        index = int(color[6:])
    if index is not None:
        return {"color": index}
    code = next((code for code, name in COLORS.items() if name == color), color)
    return {"true_color": int(code[1:], 16)} if re.fullmatch(r"#[0-9a-f]{6}", code) else {}


def _circle(stroke: Stroke, points: Floats) -> Floats | None:
    """Centre and radius of a line that is a whole circle, or None."""
    if not stroke.closed or not stroke.bulges.all() or abs(np.arctan(stroke.bulges).sum()) < np.pi / 2 - 1e-6:
        return None
    found = circles_of([Curve(np.concatenate([points, points[:1]]), bow=1.0)])
    if len(found) == 1:
        circle: Floats = found[0]
        return circle
    return None
