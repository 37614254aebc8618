"""The elements of an SVG file: read with their lines, what is not drawn put away, and the size of a user unit."""

from __future__ import annotations

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
CLIP = "data-kirigami-clip"  # marks the contents of a clip path, put where they are parsed but not drawn


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
    except expat.ExpatError as error:
        kind = "a broken SVG file" if b"<svg" in data[:8192] else "no SVG file"
        raise GeometryError(f"{path} is {kind}: {error}") from None
    root = builder.close()
    if root.tag.rpartition("}")[2] != "svg":
        raise GeometryError(f"{path} is no SVG file: its first element is <{root.tag.rpartition('}')[2]}>")
    _put_symbols_away(root, path)
    return root, data[:4096].decode("utf-8", "replace")


def _put_symbols_away(root: Any, path: Path) -> None:
    """Symbols, masks, markers and patterns are drawn only where they are used: move them into definitions.

    svgelements leaves definitions alone. The contents of clip paths become groups of the root, marked and not drawn.
    """
    used = {value.lstrip("#") for element in root.iter() for key, value in element.items() if key.endswith("href")}
    clips = []
    for parent in list(root.iter()):
        for position, child in enumerate(list(parent)):
            kind = child.tag.rpartition("}")[2] if isinstance(child.tag, str) else ""
            if kind == "symbol" and "viewBox" in child.attrib and child.get("id") in used:
                raise GeometryError(
                    f"{path}, line {child.get(LINE)}: a symbol with a viewBox is not understood; "
                    "unlink the symbols of the drawing into plain paths"
                )
            if kind in ("symbol", "mask", "marker", "pattern", "clipPath"):
                definitions = ElementTree.Element(child.tag.replace(kind, "defs"))
                parent[position] = definitions
                if kind == "clipPath":
                    clips.append(child)
                else:
                    definitions.append(child)
    for clip in clips:
        clip.tag = clip.tag.replace("clipPath", "g")
        clip.set(CLIP, clip.attrib.pop("id", ""))
        root.append(clip)


def user_space(root: Any, header: str, drawn_in: str | None, unit: str, notes: list[str]) -> UserSpace:
    """The way from user units to the wanted unit with y upwards."""
    per_inch = 96.0
    if "Adobe Illustrator" in header:
        per_inch = 72.0
    elif re.match(r"0\.(4\d|91)", root.get(VERSION, "")):
        per_inch = 90.0
    view = [float(value) for value in re.findall(r"[-+.\deE]+", root.get("viewBox", ""))]
    sizes = [_length(root.get(name, "")) for name in ("width", "height")]
    if len(view) != 4 or view[2] <= 0 or view[3] <= 0:
        # Without a view box a user unit is a pixel, and the page is as high as `height` says.
        value, name = sizes[1] or (0.0, "")
        pixels = value if name in ("", "px") else value * METRES[name] / METRES["in"] * per_inch
        view, scales = [0.0, 0.0, 1.0, pixels], []
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
    if root.get(ORIGIN) == "sheet":
        left = bottom = 0.0

    return UserSpace(left, bottom, per_unit, ratio, source if physical or drawn_in else "mm")


@dataclass(frozen=True)
class UserSpace:
    """From user units to the wanted unit, with y upwards; `shown` is the unit of the drawing."""

    left: float
    bottom: float
    per_unit: float
    scale: float
    shown: str

    @property
    def ratio(self) -> float:
        return self.per_unit * self.scale

    def __call__(self, points: Floats) -> Floats:
        moved = np.column_stack([points[:, 0] - self.left, self.bottom - points[:, 1]])
        return scaled(moved * self.per_unit if self.per_unit != 1 else moved, self.scale)


def _length(text: str) -> tuple[float, str] | None:
    match = re.fullmatch(r"\s*([-+.\deE]+)\s*([a-z]*)\s*", text)
    if match is None or (match[2] and match[2] not in METRES) or float(match[1]) <= 0:
        return None
    return float(match[1]), match[2]
