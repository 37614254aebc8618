"""What of an SVG drawing its clip paths and masks let be seen."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import shapely

from kirigami.drawing.curves import Floats
from kirigami.drawing.svg_tree import WINDOW
from kirigami.errors import KirigamiWarning

BOX = "objectBoundingBox"
FINE = 1e-4  # of the size of a clip path: how far its chords may be off its curves
SEEN = 0.5  # luminance from which a mask shows what lies behind it
BRIGHTNESS = {"red": 0.2125, "green": 0.7154, "blue": 0.0721}  # shares in luminance, of the SVG specification


class Windows:
    """The clip paths and masks of a document, and the areas that they leave of what they are put on.

    Parameters
    ----------
    document : svgelements.SVG
        With the contents of clip paths and masks in marked groups of the root.
    elements : module
        svgelements.
    points : callable
        Rings of a path within a distance.
    notes : list of str
        What is not applied is told here.
    """

    def __init__(self, document: Any, elements: Any, points: Any, notes: list[str]) -> None:
        self._elements, self._points, self._notes = elements, points, notes
        self._areas: dict[tuple[str, int], Any] = {}
        self._groups = {
            item.values["attributes"]["id"]: item
            for item in document
            if WINDOW in item.values.get("attributes", {}) and "id" in item.values["attributes"]
        }

    def of(self, wearers: Iterable[Any]) -> Any:
        """The area in which a shape is seen, of the elements round it that wear a clip path or mask; None for all."""
        window = None
        for item in wearers:
            for name in window_names(item.values.get("attributes", {})):
                key = name, id(item)
                if key not in self._areas:
                    self._areas[key] = self._area(name, item, ())
                area = self._areas[key]
                if area is not None:
                    window = area if window is None else window.intersection(area)
        return window

    def _area(self, name: str, wearer: Any, above: tuple[str, ...]) -> Any:
        """The area of one clip path or mask on an element, in the space of the document; None where unknown."""
        group = self._groups.get(name)
        if group is None or name in above:
            return self._untold(name, "is not in the file" if group is None else "clips itself")
        own = group.values["attributes"]
        kind = own[WINDOW]
        matrix = self._elements.Matrix(str(wearer.values.get("transform") or ""))
        box = self._box(wearer, matrix) if BOX in (own.get("clipPathUnits"), own.get("maskContentUnits")) else None
        shapes = list(_shapes(group, self._elements))
        if kind == "mask":
            area = self._light(shapes, name)
            area = area if area is None else _within_region(area, own)
        else:
            area = shapely.union_all([self._filled(shape, "clip-rule") for shape in shapes])
        if area is None or not shapes:
            return self._untold(name, "holds nothing that is understood")
        if box is not None:
            area = _placed(area, [box[2] - box[0], 0, 0, box[3] - box[1], box[0], box[1]])
        area = _placed(area, [matrix.a, matrix.b, matrix.c, matrix.d, matrix.e, matrix.f])
        for further in window_names(own):
            inner = self._area(further, wearer, (*above, name))
            area = area if inner is None else area.intersection(inner)
        return area

    def _light(self, shapes: Sequence[Any], name: str) -> Any:
        """Where a mask is light, later shapes over earlier ones; None where a paint is not understood."""
        area = shapely.Polygon()
        for shape in shapes:
            values, fill = shape.values, shape.fill
            if "url(" in str(values.get("fill")):
                return None
            if fill is None or fill.value is None or not fill.alpha:
                continue
            shade = sum(share * getattr(fill, color) for color, share in BRIGHTNESS.items()) / 255
            opacity = fill.alpha / 255 * _share(values.get("fill-opacity")) * _share(values.get("opacity"))
            filled = self._filled(shape, "fill-rule")
            if shade * opacity > SEEN:
                area = area.union(filled)
            elif opacity > SEEN:
                area = area.difference(filled)
        return area

    def _filled(self, shape: Any, rule: str) -> Any:
        path = self._elements.Path(shape).reify()
        extent = path.bbox()
        size = max(extent[2] - extent[0], extent[3] - extent[1]) if extent is not None else 1.0
        rings = [points for points, _ in self._points(path, FINE * size, self._elements, "a clip path")]
        return filled(rings, even=shape.values.get(rule) == "evenodd")

    def _box(self, wearer: Any, matrix: Any) -> Any:
        """The box round an element in its own space."""
        found = [wearer] if isinstance(wearer, self._elements.Shape) else list(_shapes(wearer, self._elements))
        boxes = [
            box for shape in found
            if (box := (self._elements.Path(self._elements.Path(shape).reify()) * ~matrix).reify().bbox()) is not None
        ]  # fmt: skip
        corners = np.array(boxes, dtype=float)
        return [*corners[:, :2].min(axis=0), *corners[:, 2:].max(axis=0)] if len(corners) else None

    def _untold(self, name: str, why: str) -> None:
        text = f"the clip path or mask {name!r} {why} and is not applied"
        if text not in self._notes:
            warnings.warn(text, KirigamiWarning, stacklevel=6)
            self._notes.append(text)


def window_names(own: dict[str, Any]) -> list[str]:
    """The clip path and the mask that an element asks for."""
    asked = (str(own.get(key) or "") for key in ("clip-path", "mask"))
    found = (re.match(r"""\s*url\(\s*["']?#([^"')]+)["']?\s*\)""", text) for text in asked)
    return [match[1] for match in found if match]


def filled(rings: Sequence[Floats], even: bool) -> Any:
    """The area within rings (k, 2), by the even-odd rule or where they wind round a point at all."""
    rings = [ring for ring in rings if len(ring) > 3]
    if not rings:
        return shapely.Polygon()
    lines = shapely.union_all([shapely.LineString(np.concatenate([ring, ring[:1]])) for ring in rings])
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(lines)))
    if len(faces) == 1:
        return faces[0]
    inner = shapely.get_coordinates(shapely.point_on_surface(faces))
    turns = sum(_turns(ring, inner) for ring in rings)
    return shapely.union_all(faces[turns % 2 == 1 if even else turns != 0])


def _turns(ring: Floats, points: Floats) -> Any:
    """How often a ring winds round each of the points (k,)."""
    arms = np.concatenate([ring, ring[:1]])[None] - points[:, None]
    before, after = arms[:, :-1], arms[:, 1:]
    cross = before[..., 0] * after[..., 1] - before[..., 1] * after[..., 0]
    angles = np.arctan2(cross, (before * after).sum(axis=2))
    return np.rint(angles.sum(axis=1) / (2 * np.pi)).astype(int)


def clipped(points: Floats, window: Any) -> list[Floats]:
    """The parts of a curve that lie within an area."""
    line = shapely.LineString(points)
    if window.covers(line):
        return [points]
    common = line.intersection(window)
    lines = [part for part in shapely.get_parts(common) if isinstance(part, shapely.LineString) and part.length > 0]
    merged = shapely.get_parts(shapely.line_merge(shapely.MultiLineString(lines))) if lines else []
    return [np.asarray(shapely.get_coordinates(part)) for part in merged]


def _shapes(group: Any, elements: Any) -> Iterator[Any]:
    for item in group:
        if isinstance(item, elements.Shape):
            yield item
        elif isinstance(item, list):
            yield from _shapes(item, elements)


def _within_region(area: Any, own: dict[str, Any]) -> Any:
    """What a mask leaves is within its own rectangle, where that is in the units of the drawing."""
    try:
        x, y, width, height = (float(own[key]) for key in ("x", "y", "width", "height"))
    except (KeyError, ValueError):
        return area
    if own.get("maskUnits") != "userSpaceOnUse":
        return area
    return area.intersection(shapely.box(x, y, x + width, y + height))


def _share(text: Any) -> float:
    try:
        return float(text)
    except (TypeError, ValueError):
        return 1.0


def _placed(area: Any, matrix: Sequence[float]) -> Any:
    a, b, c, d, e, f = matrix
    return shapely.transform(area, lambda points: points @ np.array([[a, b], [c, d]]) + (e, f))
