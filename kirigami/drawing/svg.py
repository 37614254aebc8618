"""SVG drawings in and out: Inkscape, Illustrator and others; paths are understood by svgelements."""

from __future__ import annotations

import io
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from kirigami.drawing.curves import Curve, Floats, all_at_once, flattened, scaled
from kirigami.drawing.drawing import Drawing, assemble
from kirigami.drawing.roles import Names, Roles, role_of_name
from kirigami.drawing.strokes import Stroke, strokes
from kirigami.drawing.svg_paint import Canvas, is_transparent, line_type
from kirigami.drawing.svg_tree import LINE, ORIGIN, WINDOW, read_tree, resolve_percentages, user_space
from kirigami.drawing.svg_windows import Windows, clipped, window_names
from kirigami.errors import GeometryError
from kirigami.files import library, whole_file
from kirigami.primitives.checks import require_between, require_choice, require_path
from kirigami.units import metres_per
from kirigami.words import counted

LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
HIDDEN = "neither painted nor visible"
STROKES = {
    "OUTLINE": "#000000", "CUTS": "#ff0000", "FOLDS": "#0000ff", "VALLEY FOLDS": "#0000ff", "MOUNTAIN FOLDS": "#008000",
}  # fmt: skip


def read_svg(
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
    """Read outline, cuts and folds from an SVG file.

    Paths and all basic shapes are read, with transforms, symbols, clip paths, masks and style sheets; texts and images
    are not, nor what is neither painted nor visible, unless its layer is named; the report counts them. Dashed lines
    are folds. The true size is that of ``width``, ``height`` and ``viewBox``; a size in pixels has 96 to the
    inch, 72 where Illustrator wrote the file and 90 where an Inkscape before 0.92 did. The y axis is turned upwards.
    Layers are named groups; an object may also carry the role in its own name. How layers and colours become roles is
    said at :func:`kirigami.drawing.dxf.read_dxf`.

    Parameters
    ----------
    path : path
        The file.
    outline, cuts, folds, ignore : str or list of str, optional
        Layers, or stroke colours ("red", "#ff0000"), that hold each kind of curve.
    regions : str or list of str, optional
        Those whose closed curves are regions of the sheet of the same name, to give thickness, material or loads to;
        they are not cut.
    unit : str
        Unit of length of the sheet: "m", "mm", ...
    drawn_in : str, optional
        Length of one user unit ("mm", ...), where the file does not say or says it wrong.
    tolerance : float or str
        Ends nearer than this fraction of the size, or this length ("0.1mm"), are joined; curves as near as this all
        along are drawn twice.
    flatness : float
        Largest distance between a curve and its chords, as a fraction of the size of the drawing.
    part : int, optional
        Which part to take, from 1, where several lie side by side or cuts sever the sheet.

    Returns
    -------
    Drawing
        ``drawing.sheet(thickness, material)`` makes the sheet, ``drawing.report`` says what was read.

    Raises
    ------
    GeometryError
        No such file, no SVG file or a broken one; no closed outline; an unknown layer. Messages name line numbers.
    KirigamiError
        svgelements is not installed.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.drawing.drawing import Drawing
    >>> from kirigami.drawing.svg import read_svg, write_svg
    >>> import shapely, tempfile
    >>> plate = Drawing(shapely.box(0, 0, 0.2, 0.1), (shapely.LineString([(0.05, 0.05), (0.15, 0.05)]),), unit="m")
    >>> drawing = read_svg(write_svg(plate, Path(tempfile.mkdtemp()) / "plate.svg"))
    >>> drawing.outline.equals_exact(plate.outline, 1e-12), len(drawing.cuts)
    (True, 1)
    """
    elements = library("svgelements", "reading SVG drawings")
    path = require_path(path, "path", "read_svg", GeometryError)
    flatness = require_between(flatness, 1e-9, 1.0, "flatness", "read_svg", GeometryError)
    root, header = read_tree(path)
    notes = [f"{path.name}: SVG"]
    to_drawing = user_space(root, header, drawn_in, unit, notes)
    sized = "viewBox" in root.attrib or "height" in root.attrib
    resolve_percentages(root, *to_drawing.view)
    for name in ("width", "height", "viewBox", "preserveAspectRatio"):
        root.attrib.pop(name, None)  # sizes are worked out above: svgelements rounds millimetres to seven digits
    try:
        document = elements.SVG.parse(io.BytesIO(ElementTree.tostring(root)), reify=False)
    except (ValueError, TypeError, IndexError, KeyError, ZeroDivisionError, AttributeError, RecursionError) as error:
        raise GeometryError(f"{path} holds something that is not SVG: {error}") from None
    if not isinstance(document, list):
        raise GeometryError(f"{path} holds nothing that is shown")
    skipped: Counter[str] = Counter()
    roles = Roles(outline, cuts, folds, ignore, regions)
    hidden: list[str] = []
    found = list(_shapes(document, _Place(), skipped, elements, roles.names, hidden))
    windows = Windows(document, elements, _points, notes)
    if skipped:
        notes.append("not read: " + ", ".join(f"{number} {kind}" for kind, number in skipped.most_common()))
    boxes = np.array([box for *_, drawn in found if (box := drawn.bbox()) is not None], dtype=float)
    if not len(boxes):
        seen = ", ".join(f"{number} {kind}" for kind, number in skipped.items()) or "nothing"
        hint = f"; `cuts={hidden[0]!r}` reads that layer all the same" if hidden else ""
        raise GeometryError(f"{path} holds no curves (it holds {seen}){hint}")
    distance = flatness * float((boxes[:, 2:].max(axis=0) - boxes[:, :2].min(axis=0)).max())
    seen_pieces: list[tuple[Floats, Any, str, str, str, Floats | float]] = []
    cut_off = 0
    for shape, place, color, drawn in found:
        source = f"line {shape.values.get(LINE, '?')} <{shape.values.get('tag', 'path')}>"
        if identity := shape.values.get("attributes", {}).get("id"):
            source += f" {identity!r}"
        window, kind = windows.of(place.wearers), line_type(shape)
        for points, bow in _points(drawn, distance, elements, source):
            pieces = [points] if window is None else clipped(points, window)
            cut_off += len(pieces) != 1 or pieces[0] is not points
            for piece in pieces:
                bent = scaled(bow, to_drawing.ratio) if piece is points else 0.0
                seen_pieces.append((piece, place, color, source, kind, bent))
    places = all_at_once([piece for piece, *_ in seen_pieces], to_drawing)
    curves = [
        Curve(points, place.layer, color, source, kind, bent)
        for points, (_, place, color, source, kind, bent) in zip(places, seen_pieces)
    ]
    if cut_off:
        notes.append(f"{counted(cut_off, 'curve')} cut off at a clip path or mask")
    if not curves:
        raise GeometryError(f"{path} holds no curves with a length")
    return assemble(
        curves, roles, unit=unit, tolerance=tolerance, notes=notes, shown=to_drawing.shown, part=part,
        page=to_drawing.page if sized else None,
    )  # fmt: skip


@dataclass(frozen=True)
class _Place:
    """Where in the tree a shape is: names of the groups round it, what wears a clip path or mask, and its layer."""

    names: tuple[str, ...] = ()
    wearers: tuple[Any, ...] = ()
    layer: str = ""
    unseen: bool = False

    def within(self, item: Any, called: list[str], layer: str = "") -> _Place:
        """The place of what is in a group."""
        own = item.values.get("attributes", {})
        wearers = (*self.wearers, item) if window_names(own) else self.wearers
        return _Place((*self.names, *called), wearers, layer, self.unseen or is_transparent(own))


def _shapes(
    group: Any,
    place: _Place,
    skipped: Counter[str],
    elements: Any,
    asked: set[str],
    hidden: list[str],
    canvas: Canvas | None = None,
) -> Iterator[tuple[Any, _Place, str, Any]]:
    """Shapes that are shown, or asked for by name: each with its place, its colour and its path.

    What is not read is counted in `skipped`, and the layers of what is not shown are noted in `hidden`.
    """
    canvas = canvas or Canvas()
    for item in group:
        values = item.values
        own = values.get("attributes", {})
        called = [name for name in (own.get(LABEL), own.get("data-name"), own.get("id")) if name]
        kind = type(item).__name__
        if WINDOW in own:
            continue
        if isinstance(item, list) and not isinstance(item, elements.Shape):
            yield from _shapes(item, place.within(item, called[:2]), skipped, elements, asked, hidden, canvas)
        elif isinstance(item, elements.Shape):
            here = place.within(item, [], _layer(list(place.names), called, asked))
            # as a path: svgelements turns mirrored circles into wrong ones
            drawn = (item if isinstance(item, elements.Path) else elements.Path(item)).reify()
            color = canvas.color(item, drawn)
            seen = color is not None and not here.unseen and values.get("visibility") not in ("hidden", "collapse")
            if seen or here.layer.casefold() in asked:
                yield item, here, color or "", drawn
            else:
                skipped[HIDDEN] += 1
                if here.layer:
                    hidden.append(here.layer)
        elif kind in ("Text", "Image"):
            skipped[kind.lower()] += 1


def _layer(groups: list[str], own: list[str], asked: set[str]) -> str:
    """The innermost name that was asked for, or else that tells a role, or else the innermost group's."""
    inward_out = own + groups[::-1]
    for wanted in (lambda name: name.casefold() in asked, role_of_name):
        for name in inward_out:
            if wanted(name):
                return name
    return groups[-1] if groups else ""


def _points(path: Any, distance: float, elements: Any, source: str) -> Iterator[tuple[Floats, Floats]]:
    """Points of a path in user units, and how far it bows from each chord, for every subpath."""
    parts: list[Floats] = []
    bows: list[float] = []

    def finished(closed: bool) -> Iterator[tuple[Floats, Floats]]:
        if len(parts) == 1 and bows == [0.0] and not closed:  # one straight line, as most are
            points = parts.pop()
            bows.clear()
            if (points[0] != points[1]).any():
                yield points, np.zeros(1)
        elif parts:
            points = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
            bow = np.repeat(bows, [len(part) - 1 for part in parts])
            parts.clear()
            bows.clear()
            size = np.ptp(points, axis=0).max()
            if np.linalg.norm(points[0] - points[-1]) <= 1e-9 * size:
                points[-1] = points[0]
            elif closed:
                points, bow = np.concatenate([points, points[:1]]), np.append(bow, 0.0)
            if size > 0:
                yield points, bow

    try:
        for segment in path:
            if isinstance(segment, elements.Move):
                yield from finished(False)
            elif isinstance(segment, elements.Close):
                yield from finished(True)
            elif isinstance(segment, elements.Line):
                parts.append(np.array([segment.start, segment.end], dtype=float))
                bows.append(0.0)
            else:
                points = flattened(lambda t, curve=segment: np.asarray(curve.npoint(t), dtype=float), distance)
                points[0], points[-1] = segment.start, segment.end
                parts.append(points)
                bows.append(distance)
    except (ValueError, TypeError, IndexError, ZeroDivisionError) as error:
        raise GeometryError(f"{source} cannot be read: {error}") from None
    yield from finished(False)


def write_svg(
    sheet: Any,
    path: str | os.PathLike[str],
    *,
    unit: str = "m",
    drawn_in: str = "mm",
    folds: Iterable[Any] = (),
    kerf: float = 0.0,
) -> Path:
    """Write a sheet for the laser cutter: true size, one layer and colour for each kind of line.

    Layers OUTLINE (black), CUTS (red), FOLDS (blue, dashed), VALLEY FOLDS and MOUNTAIN FOLDS, as Inkscape knows them.
    Coordinates are those of the sheet; the page is as large as the sheet. A drawing that was read keeps its colours,
    its arcs, and its page with its place on it.

    Parameters
    ----------
    sheet : Sheet or Drawing
        Its outline, cuts and folds.
    path : path
        The file.
    unit : str
        Unit of length of the sheet.
    drawn_in : str
        Unit of length of the file: "mm", "cm", "in".
    folds : iterable of LineString
        More lines to be folded and not cut.
    kerf : float
        Width of what the cutter takes away [length, in the unit of the sheet]: the rim grows and openings shrink by
        half of it, slits stay.

    Raises
    ------
    KirigamiError
        The unit is unknown, an opening is no wider than the kerf, or the file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.drawing.drawing import Drawing
    >>> from kirigami.drawing.svg import write_svg
    >>> import shapely, tempfile
    >>> plate = Drawing(shapely.box(0, 0, 1, 1), ())
    >>> write_svg(plate, Path(tempfile.mkdtemp()) / "plate.svg").read_text().count("<path")
    1
    """
    require_choice(drawn_in, ("mm", "cm", "in"), "drawn_in", "to_svg", GeometryError)
    ratio = metres_per(unit) / metres_per(drawn_in)
    factor = float(round(ratio)) if abs(ratio - round(ratio)) < 1e-12 * ratio else ratio
    found = strokes(sheet, folds, kerf)
    bounds = np.array(sheet.outline.bounds) + 0.5 * kerf * np.array([-1, -1, 1, 1])
    page = np.array(getattr(sheet, "page", None) or bounds)
    page = np.where(np.arange(4) < 2, np.minimum(page, bounds), np.maximum(page, bounds))
    left, bottom, right, top = (page * factor).tolist()
    width, height = right - left, top - bottom
    groups: dict[str, list[str]] = {layer: [] for layer in ("OUTLINE", "CUTS", "FOLDS")}
    for stroke in found:
        paint = f' stroke="{stroke.color}"' if re.fullmatch(r"#[0-9a-f]{6}|[a-z]+", stroke.color) else ""
        groups.setdefault(stroke.layer, []).append(f'    <path d="{_path_data(stroke, factor)}"{paint}/>')
    thin = 1e-3 * float(np.ptp(bounds.reshape(2, 2), axis=0).max()) * factor
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="{LABEL[1:-6]}" version="1.1" {ORIGIN}="sheet"',
        f'     width="{width!r}{drawn_in}" height="{height!r}{drawn_in}"',
        f'     viewBox="{left!r} {-top!r} {width!r} {height!r}">',
    ]
    for layer, paths in groups.items():
        dash = f' stroke-dasharray="{5 * thin:.3g}"' if "FOLDS" in layer else ""
        stroke_of_layer = f'fill="none" stroke="{STROKES[layer]}" stroke-width="{thin:.3g}"{dash}'
        lines.append(f'  <g id="{layer}" inkscape:groupmode="layer" inkscape:label="{layer}" {stroke_of_layer}>')
        lines += [*paths, "  </g>"]
    text = "\n".join([*lines, "</svg>", ""])
    target = require_path(path, "path", "to_svg", GeometryError)
    with whole_file(target) as unfinished:
        unfinished.write_text(text, encoding="utf-8")
    return target


def _path_data(stroke: Stroke, factor: float) -> str:
    """The d of a path, y downwards."""
    points = stroke.points * factor + 0.0
    ends = np.concatenate([points[1:], points[:1]]) if stroke.closed else points[1:]
    words = [f"M {float(points[0, 0])!r},{-float(points[0, 1])!r}"]
    for start, end, bulge in zip(points, ends, stroke.bulges.tolist()):
        if bulge:
            radius = float(np.hypot(*(end - start))) * (1 + bulge**2) / (4 * abs(bulge))
            words.append(f"A {radius!r},{radius!r} 0 0 {int(bulge < 0)} {float(end[0])!r},{-float(end[1])!r}")
        else:
            words.append(f"L {float(end[0])!r},{-float(end[1])!r}")
    if stroke.closed:
        words = [*words[: -1 if not stroke.bulges[-1] else None], "Z"]
    return " ".join(words)
