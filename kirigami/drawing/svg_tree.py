"""The elements of an SVG file: read with their lines, what is not drawn put away, and the size of a user unit."""

from __future__ import annotations

import copy
import math
import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np

from kirigami.drawing.curves import Floats, scaled
from kirigami.errors import GeometryError, KirigamiWarning
from kirigami.units import METRES, metres_per

VERSION = "{http://www.inkscape.org/namespaces/inkscape}version"
LINE = "data-kirigami-line"
ORIGIN = "data-kirigami-origin"  # "sheet": x and -y are coordinates of the sheet, whatever part of it the page shows
MOST_SYMBOLS = 10_000
WINDOW = "data-kirigami-window"  # marks the contents of a clip path or mask, put where they are parsed but not drawn


def read_tree(path: Path) -> tuple[Any, str]:
    """The XML tree, every element marked with its line, and the first characters of the file."""
    if not path.is_file():
        raise GeometryError(f"there is no file {path}")
    data = path.read_bytes()
    if not data.strip():
        raise GeometryError(f"{path} is empty")
    builder = ElementTree.TreeBuilder()
    parser = expat.ParserCreate(namespace_separator="}")

    def name(raw: str) -> str:
        return "{" + raw if "}" in raw else raw

    def start(tag: str, attributes: dict[str, str]) -> None:
        marked = {name(key): value for key, value in attributes.items()}
        marked[LINE] = str(parser.CurrentLineNumber)
        builder.start(name(tag), marked)

    def end(tag: str) -> None:
        builder.end(name(tag))

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(data, True)
    except (expat.ExpatError, LookupError, ValueError) as error:  # also of an encoding that there is not
        kind = "a broken SVG file" if b"<svg" in data[:8192] else "no SVG file"
        raise GeometryError(f"{path} is {kind}: {error}") from None
    root = builder.close()
    if root.tag.rpartition("}")[2] != "svg":
        raise GeometryError(f"{path} is no SVG file: its first element is <{root.tag.rpartition('}')[2]}>")
    _draw_symbols(root, path)
    _put_symbols_away(root)
    return root, data[:4096].decode("utf-8", "replace")


def _draw_symbols(root: Any, path: Path) -> None:
    """Where a symbol with a view box is used, its contents are drawn in a viewport of their own: put that there."""
    symbols = {
        element.get("id"): element
        for element in root.iter()
        if isinstance(element.tag, str) and _kind(element) == "symbol" and "viewBox" in element.attrib
    }
    originals = {name: copy.deepcopy(symbol) for name, symbol in symbols.items()}
    for symbol in symbols.values():  # they are drawn where they are used
        symbol[:] = []
    drawn = 0
    while uses := [(use, name) for use in root.iter() if (name := _used_by(use)) in originals]:
        drawn += len(uses)
        if drawn > MOST_SYMBOLS:
            raise GeometryError(f"{path} draws more than {MOST_SYMBOLS:,} symbols, or its symbols use one another")
        for use, name in uses:
            symbol = originals[name]
            own = dict(use.attrib)
            for key in [key for key in own if key.endswith("href")]:
                del own[key]
            window = ElementTree.Element(use.tag.replace("use", "svg"), {"viewBox": symbol.get("viewBox")})
            for key in ("x", "y", "width", "height"):
                value = own.pop(key, None) or (symbol.get(key) if key in ("width", "height") else None)
                if value is not None:
                    window.set(key, value)
            if ratio := symbol.get("preserveAspectRatio"):
                window.set("preserveAspectRatio", ratio)
            window.extend(copy.deepcopy(list(symbol)))
            use.tag = use.tag.replace("use", "g")
            use.attrib.clear()
            use.attrib.update(own)
            use.append(window)


def _kind(element: Any) -> str:
    return str(element.tag.rpartition("}")[2]) if isinstance(element.tag, str) else ""


def _used_by(element: Any) -> str:
    """The name of what a <use> draws, or ""."""
    if _kind(element) != "use":
        return ""
    return next((value.lstrip("#") for key, value in element.items() if key.endswith("href")), "")


def _put_symbols_away(root: Any) -> None:
    """Symbols, masks, markers and patterns are drawn only where they are used: move them into definitions.

    svgelements leaves definitions alone. The contents of clip paths and masks become groups of the root, marked and not
    drawn.
    """
    windows = []
    for parent in list(root.iter()):
        for position, child in enumerate(list(parent)):
            kind = _kind(child)
            if kind in ("symbol", "mask", "marker", "pattern", "clipPath"):
                definitions = ElementTree.Element(child.tag.replace(kind, "defs"))
                parent[position] = definitions
                if kind in ("clipPath", "mask"):
                    windows.append((kind, child))
                else:
                    definitions.append(child)
    for kind, window in windows:
        window.tag = window.tag.replace(kind, "g")
        window.set(WINDOW, kind)
        root.append(window)


def resolve_percentages(element: Any, width: float, height: float) -> None:
    """Put numbers in the place of percentages, which are of the viewport that an element is in."""
    sizes = dict.fromkeys(("x", "x1", "x2", "cx", "rx", "width"), width)
    sizes |= dict.fromkeys(("y", "y1", "y2", "cy", "ry", "height"), height)
    sizes["r"] = math.hypot(width, height) / math.sqrt(2)
    for child in element:
        relative = [(name, value.strip()) for name, value in child.items() if "%" in value and name in sizes]
        for name, value in relative:
            if value.endswith("%") and (share := _number(value[:-1])) is not None:
                child.set(name, repr(0.01 * share * sizes[name]))
        if not len(child):
            continue
        inner = width, height
        if _kind(child) == "svg":
            view = _view_box(child)
            own = [_number(child.get(name, "")) for name in ("width", "height")]
            inner = (view[2], view[3]) if view else (own[0] or width, own[1] or height)
        resolve_percentages(child, *inner)


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _view_box(element: Any) -> list[float]:
    """The four numbers of a view box with an extent, or none."""
    found = re.findall(r"[-+.\deE]+", element.get("viewBox", ""))
    view = [value for text in found if (value := _number(text)) is not None]
    return view if len(view) == 4 and view[2] > 0 and view[3] > 0 else []


def user_space(root: Any, header: str, drawn_in: str | None, unit: str, notes: list[str]) -> UserSpace:
    """The way from user units to the wanted unit with y upwards."""
    per_inch = 96.0
    if "Adobe Illustrator" in header:
        per_inch = 72.0
    elif re.match(r"0\.(4\d|91)", root.get(VERSION, "")):
        per_inch = 90.0
    view = _view_box(root)
    sizes = [_length(root.get(name, "")) for name in ("width", "height")]
    if not view:
        # Without a view box a user unit is a pixel, and the page is as high as `height` says.
        value, name = sizes[1] or (0.0, "")
        pixels = value if name in ("", "px") else value * METRES[name] / METRES["in"] * per_inch
        value, name = sizes[0] or (0.0, "")
        across = value if name in ("", "px") else value * METRES[name] / METRES["in"] * per_inch
        view, scales = [0.0, 0.0, across or pixels or 1.0, pixels], []
    else:
        found = [(size[0] / extent, size[1]) for size, extent in zip(sizes, view[2:]) if size]
        scales = [(scale / per_inch, "") if name in ("", "px") else (scale, name) for scale, name in found]
    physical = any(name for _, name in scales)
    metres_per(unit)
    if drawn_in is not None:
        metres_per(drawn_in)
        per_unit, source = 1.0, drawn_in
        notes.append(f"one user unit is 1 {drawn_in}, as said")
    elif physical:
        per_unit, source = min(scale for scale in scales if scale[1])
        notes.append(f"true size {root.get('width')} x {root.get('height')}")
    else:
        per_unit, source = min(scales)[0] if scales else 1 / per_inch, "in"
        text = f"the drawing has no size in a unit of length: {per_inch:g} pixels to the inch are taken"
        warnings.warn(f'{text}; say `drawn_in="mm"` if a user unit is 1 mm', KirigamiWarning, stacklevel=3)
        notes.append(text)
    ratio = metres_per(source) / metres_per(unit)
    left, bottom = view[0], view[1] + view[3]
    corner = 0.0, 0.0
    if root.get(ORIGIN) == "sheet":
        corner = left * per_unit * ratio, -bottom * per_unit * ratio
        left = bottom = 0.0

    shown = source if physical or drawn_in else "mm"
    return UserSpace(left, bottom, per_unit, ratio, shown, (view[2], view[3]), corner)


@dataclass(frozen=True)
class UserSpace:
    """From user units to the wanted unit, with y upwards; `shown` is the unit of the drawing, `view` its page.

    `corner` is where the lower left corner of the page lies, in the wanted unit.
    """

    left: float
    bottom: float
    per_unit: float
    scale: float
    shown: str
    view: tuple[float, float]
    corner: tuple[float, float]

    @property
    def ratio(self) -> float:
        return self.per_unit * self.scale

    @property
    def page(self) -> tuple[float, float, float, float]:
        """Left, bottom, right and top of the page, in the wanted unit."""
        width, height = (size * self.ratio for size in self.view)
        left, bottom = self.corner
        return left, bottom, left + width, bottom + height

    def __call__(self, points: Floats) -> Floats:
        moved = np.column_stack([points[:, 0] - self.left, self.bottom - points[:, 1]])
        return scaled(moved * self.per_unit if self.per_unit != 1 else moved, self.scale)


def _length(text: str) -> tuple[float, str] | None:
    match = re.fullmatch(r"\s*([-+.\deE]+)\s*([a-z]*)\s*", text)
    if match is None or (match[2] and match[2] not in METRES) or float(match[1]) <= 0:
        return None
    return float(match[1]), match[2]
