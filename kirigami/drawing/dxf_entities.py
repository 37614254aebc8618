"""Entities of a DXF file as they are seen: blocks taken apart, layers and colours inherited, the unseen left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from kirigami.drawing.roles import color_name
from kirigami.errors import GeometryError

COLORS = {1: "red", 2: "yellow", 3: "green", 4: "cyan", 5: "blue", 6: "magenta", 7: "black"}
CURVES = {"LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "LWPOLYLINE", "POLYLINE"}
NESTING = 8  # blocks within blocks
BY_BLOCK, BY_LAYER = 0, 256
PLAIN = ("", "continuous", "bylayer", "byblock")


@dataclass(frozen=True)
class Look:
    """Layer, colour and line type that an entity is shown with."""

    layer: str
    color: str
    line_type: str


@dataclass(frozen=True)
class Seen:
    """A curve of the drawing and how it is shown."""

    entity: Any
    look: Look

    @property
    def source(self) -> str:
        """What it is called in messages."""
        return source_of(self.entity)


class Reader:
    """Walks through a layout; what is not read is counted."""

    def __init__(self, document: Any, asked: set[str]) -> None:
        self.document = document
        self.asked = asked
        self.skipped: Counter[str] = Counter()
        self.unseen: Counter[str] = Counter()
        self.hidden: list[str] = []  # layers of what is not shown

    def curves(self, layout: Iterable[Any], block: Look | None = None, depth: int = 0) -> Iterator[Seen]:
        """Curves of a layout or block, blocks in it taken apart."""
        for entity in layout:
            kind = entity.dxftype()
            if kind not in CURVES and kind != "INSERT":
                self.skipped[kind] += 1
                continue
            look = self._look(entity, block)
            why = self._why_unseen(entity, look)
            if kind in CURVES and not (kind == "POLYLINE" and (entity.is_poly_face_mesh or entity.is_polygon_mesh)):
                if why and look.layer.casefold() not in self.asked and look.color not in self.asked:
                    self.unseen[why] += 1
                    self.hidden.append(look.layer)
                else:
                    yield Seen(entity, look)
            elif kind == "INSERT" and depth < NESTING:
                if why.endswith(("frozen", "invisible")):  # an insert on a layer that is off shows its other layers
                    self.unseen[why] += 1
                    self.hidden.append(look.layer)
                    continue
                for parts in self._taken_apart(entity):
                    yield from self.curves(parts, look, depth + 1)
            else:
                self.skipped[kind] += 1

    @staticmethod
    def _taken_apart(insert: Any) -> list[list[Any]]:
        """The entities of a block, once for every place in which it is inserted."""
        try:
            placed = list(insert.multi_insert()) if insert.mcount > 1 else [insert]
            return [list(one.virtual_entities()) for one in placed]
        except Exception as error:
            raise unreadable(insert, error) from None

    def _look(self, entity: Any, block: Look | None) -> Look:
        layer = str(entity.dxf.get("layer", "0"))
        if block is not None and layer == "0":
            layer = block.layer
        return Look(layer, self._color(entity, layer, block), self._line_type(entity, layer, block))

    def _color(self, entity: Any, layer: str, block: Look | None) -> str:
        if entity.dxf.hasattr("true_color"):
            return color_name(f"#{entity.dxf.true_color:06x}")
        index = entity.dxf.get("color", BY_LAYER)
        if index == BY_BLOCK and block is not None:
            return block.color
        if index == BY_LAYER and layer in self.document.layers:
            definition = self.document.layers.get(layer)
            if definition.dxf.hasattr("true_color"):
                return color_name(f"#{definition.dxf.true_color:06x}")
            index = abs(definition.color)
        return COLORS.get(7 if index in (BY_BLOCK, BY_LAYER) else index, f"color {index}")

    def _line_type(self, entity: Any, layer: str, block: Look | None) -> str:
        name = str(entity.dxf.get("linetype", "BYLAYER"))
        if name.casefold() == "byblock" and block is not None:
            return block.line_type
        if name.casefold() == "bylayer" and layer in self.document.layers:
            name = str(self.document.layers.get(layer).dxf.get("linetype", ""))
        return "" if name.casefold() in PLAIN else name

    def _why_unseen(self, entity: Any, look: Look) -> str:
        if entity.dxf.get("invisible", 0):
            return f"layer {look.layer!r}, invisible"
        if look.layer in self.document.layers:
            layer = self.document.layers.get(look.layer)
            if layer.is_frozen():
                return f"layer {look.layer!r}, frozen"
            if layer.is_off():
                return f"layer {look.layer!r}, off"
            if not layer.dxf.get("plot", 1):
                return f"layer {look.layer!r}, not plotted"
        return ""


def unreadable(entity: Any, error: Exception) -> GeometryError:
    """That an entity of a damaged file cannot be read, and why."""
    why = str(error) or type(error).__name__
    return GeometryError(f"{source_of(entity)} on layer {entity.dxf.get('layer', '0')!r} cannot be read: {why}")


def source_of(entity: Any) -> str:
    """What an entity is called in messages: by its handle."""
    handle = entity.dxf.handle
    owner = getattr(entity, "source_of_copy", None)
    if handle is None and owner is not None:
        handle = f"copy of {owner.dxf.handle}"
    return f"entity {handle or '(of a block)'} ({entity.dxftype()})"
