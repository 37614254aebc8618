"""Which shapes of an SVG drawing can be seen: paint, opacity, visibility, white on nothing."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import shapely

from kirigami.drawing.roles import color_name

WHITE = "#ffffff"


@dataclass
class Canvas:
    """What has been painted so far, to tell white lines on something from white lines on nothing."""

    boxes: list[Any] = field(default_factory=list)

    def color(self, shape: Any, path: Any) -> str | None:
        """The colour by which a shape is seen, or None where it is not seen."""
        stroke = _paint(shape, "stroke") if _number(shape.stroke_width, 1.0) > 0 else None
        fill = _paint(shape, "fill") if _has_area(path) else None
        seen = [paint for paint in (stroke, fill) if paint is not None and (paint != WHITE or self._on_something(path))]
        if fill is not None and fill != WHITE and (box := path.bbox()) is not None:
            self.boxes.append(shapely.box(*box))
        return color_name(seen[0]) if seen else None

    def _on_something(self, path: Any) -> bool:
        box = path.bbox()
        return box is not None and any(below.intersects(shapely.box(*box)) for below in self.boxes)


def is_transparent(own: dict[str, Any]) -> bool:
    """Whether an element, and so all that is in it, has no opacity."""
    return _number(own.get("opacity"), 1.0) <= 0


def _paint(shape: Any, name: str) -> str | None:
    color = getattr(shape, name)
    if color is None or color.value is None or not color.alpha:
        return None
    if _number(shape.values.get(f"{name}-opacity"), 1.0) <= 0:
        return None
    return str(color.hex)[:7].casefold()


def _number(text: Any, default: float) -> float:
    match = re.match(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)", str(text)) if text is not None else None
    try:
        return float(match[1]) if match else default
    except ValueError:
        return default


def _has_area(path: Any) -> bool:
    """Whether filling a path would show: a straight line has no inside."""
    segments = [segment for segment in path if type(segment).__name__ not in ("Move", "Close")]
    return len(segments) > 1 or any(type(segment).__name__ != "Line" for segment in segments)


def line_type(shape: Any) -> str:
    """ "dashed", or "" for a line without gaps."""
    dashes = [_number(word, 0.0) for word in re.split(r"[\s,]+", str(shape.values.get("stroke-dasharray") or ""))]
    return "dashed" if any(value > 0 for value in dashes) else ""
