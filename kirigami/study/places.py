"""Places on a sheet, by name, by coordinates, or by a mark in its drawing: where a load case holds and lifts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami import units
from kirigami.errors import ModelError
from kirigami.primitives.checks import require_finite, shown

if TYPE_CHECKING:
    from kirigami.geometry.sheet import Sheet
    from kirigami.model.model import Model
    from kirigami.primitives.node import Node

SIDES = ("left", "right", "bottom", "top")
BY_COUNT = {2: "point", 3: "disc", 4: "box"}
KNOWN = (
    "left, right, bottom, top, rim, centre, cut:NUMBER, layer:NAME, 'x, y' (a point), 'x, y, radius' (a disc) or "
    "'xmin, ymin, xmax, ymax' (a box)"
)
ON_SHEET = 1e-3  # of the size: how far beside the sheet a point may lie
ARM = 0.01  # of the size: half the line that makes a point a node of the mesh
SLACK = 1e-9  # of the size


@dataclass(frozen=True, eq=False)
class Place:
    """Where on a sheet.

    Attributes
    ----------
    kind : str
        "side", "rim", "centre", "cut", "layer", "point", "disc", "box" or "shape".
    text : str
        As it was written, or as it would be; it means the place again.
    numbers : tuple of float
        Coordinates [length, as the sheet].
    shape : shapely geometry, optional
        Of a shape, or of a layer once the drawing is known.
    """

    kind: str
    text: str
    numbers: tuple[float, ...] = ()
    shape: Any = None

    @property
    def name(self) -> str:
        """What follows the colon: the name of a layer, the number of a cut."""
        return self.text.partition(":")[2].strip()

    @property
    def plain(self) -> str:
        """What a case file keeps."""
        if self.kind == "shape":
            raise ModelError(f"{self.text} has no name that a case file could keep: give a name or coordinates")
        return self.text

    def in_drawing(self, layers: Mapping[str, Any]) -> Place:
        """The same with the shape of its layer."""
        if self.kind != "layer":
            return self
        found = next((shape for name, shape in layers.items() if name.casefold() == self.name.casefold()), None)
        if found is None:
            there = ", ".join(map(repr, layers)) or "none"
            raise ModelError(f"no curve of the drawing is on a layer or has a colour {self.name!r}; there are {there}")
        return Place("layer", self.text, shape=found)

    def on(self, sheet: Sheet) -> Any:
        """Its shape on a sheet: a point, lines or areas; None for what the mesh knows by name."""
        import shapely

        if self.kind in ("side", "rim", "cut"):
            return None
        if self.kind == "layer" and self.shape is None:
            raise ModelError(f"the place {self.text!r} needs a drawing with layers: give a shape instead")
        xmin, ymin, xmax, ymax = sheet.bounds
        size = max(xmax - xmin, ymax - ymin)
        shape = self.shape
        if self.kind == "centre":
            shape = shapely.Point((xmin + xmax) / 2, (ymin + ymax) / 2)
        elif self.kind == "point":
            shape = shapely.Point(self.numbers)
        elif self.kind == "disc":
            shape = shapely.Point(self.numbers[:2]).buffer(self.numbers[2], 4)
        elif self.kind == "box":
            shape = shapely.box(*self.numbers)
        away = float(shapely.distance(_material(sheet), shape))
        if away > (ON_SHEET * size if shape.geom_type == "Point" else 0.0):
            low, high = (sheet.scale.place(corner, 6) for corner in ((xmin, ymin), (xmax, ymax)))
            far = units.show(away, "length") if sheet.scale.length else f"{away:.4g}"
            raise ModelError(
                f"the place {self.text!r} is not on the sheet, but {far} beside it; the sheet spans {low} to {high}"
            )
        return shape

    def line(self, sheet: Sheet) -> Any:
        """What the mesh needs as edges, so that the place has nodes of its own; None for nothing."""
        import shapely

        shape = self.on(sheet)
        if shape is None:
            return None
        xmin, ymin, xmax, ymax = sheet.bounds
        size = max(xmax - xmin, ymax - ymin)
        if shape.geom_type == "Point":
            arm = np.array([ARM * size, 0.0])
            here = np.array([shape.x, shape.y])
            lines: Any = shapely.LineString([here - arm, here, here + arm])
        else:
            lines = shape.boundary if shape.area > 0 else shape
        inside = shapely.intersection(lines, sheet.outline).difference(sheet.outline.boundary.buffer(1e-6 * size))
        return None if inside.is_empty else inside

    def nodes(self, model: Model, sheet: Sheet, line: str) -> list[Node]:
        """The nodes of a model of the sheet that lie here; `line` is the node set of its line in the mesh."""
        import shapely

        mesh = model.mesh
        assert mesh is not None
        if self.kind in ("side", "rim", "cut"):
            return model.select(boundary={"rim": "outer"}.get(self.text, self.text))
        shape = self.on(sheet)
        points = mesh.nodes[:, :2]
        if shape.geom_type == "Point":
            return [model.nodes[int(np.argmin(np.hypot(points[:, 0] - shape.x, points[:, 1] - shape.y)))]]
        chosen = np.zeros(len(points), dtype=bool)
        if shape.area > 0:
            chosen |= shapely.intersects_xy(shape.buffer(SLACK * mesh.size), *points.T)
        if line in mesh.sets:
            chosen[mesh.sets[line]] = True
        if not chosen.any():
            raise ModelError(f"the place {self.text!r} holds no node of the mesh: make it larger, or the mesh finer")
        return model.select(index=np.flatnonzero(chosen))


def place(where: Any) -> Place:
    """A place from what a person writes.

    Parameters
    ----------
    where : str, sequence of 2 to 4 numbers, shapely geometry, or Place
        "left", "right", "bottom" or "top", the straight edges there; "rim", the outline without holes and cuts;
        "centre", the middle of the bounding box; "cut:3"; "layer:marks", curves of a layer or colour of the drawing,
        and what they enclose; coordinates (x, y) of a point, (x, y, radius) of a disc, (xmin, ymin, xmax, ymax) of a
        box, also as text with units, "30mm, 40mm".

    Raises
    ------
    ModelError
        No such place; the message lists what can be said.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.study.place("30mm, 40mm").numbers, kg.study.place((0, 0, 1, 2)).kind, kg.study.place("rim").kind
    ((0.03, 0.04), 'box', 'rim')
    """
    if isinstance(where, Place):
        return where
    if hasattr(where, "geom_type"):
        if where.is_empty or not np.isfinite(where.bounds).all():
            raise ModelError(f"a place must not be empty, got {shown(where)}")
        return Place("shape", f"a {where.geom_type}", shape=where)
    if isinstance(where, str):
        text = " ".join(where.split())
        word = {"center": "centre", "middle": "centre", "outer": "rim"}.get(text.casefold(), text.casefold())
        if word in SIDES:
            return Place("side", word)
        if word in ("rim", "centre"):
            return Place(word, word)
        if word.startswith("cut:") and word[4:].isdecimal():
            return Place("cut", word)
        if word.startswith("layer:") and text[6:].strip():
            return Place("layer", f"layer:{text[6:].strip()}")
        parts: list[Any] = text.split(",")
        if len(parts) not in BY_COUNT:
            raise ModelError(f"{where!r} is no place: say {KNOWN}")
        try:
            numbers = tuple(units.parse(part, "length") for part in parts)
        except ModelError as error:
            raise ModelError(f"{where!r} is no place ({error}): say {KNOWN}") from None
        return _by_numbers(numbers, text)
    if isinstance(where, Iterable) and not isinstance(where, (bytes, Mapping)):
        numbers = tuple(require_finite(number, "a coordinate", "a place") for number in where)
        return _by_numbers(numbers, ", ".join(map(repr, numbers)))
    raise ModelError(f"{shown(where)} is no place: say {KNOWN}")


def _by_numbers(numbers: tuple[float, ...], text: str) -> Place:
    if len(numbers) not in BY_COUNT:
        raise ModelError(f"{text!r} is no place: 2 numbers are a point, 3 a disc, 4 a box")
    kind = BY_COUNT[len(numbers)]
    if kind == "disc" and not numbers[2] > 0:
        raise ModelError(f"the disc {text!r} has no radius")
    if kind == "box" and not (numbers[2] > numbers[0] and numbers[3] > numbers[1]):
        raise ModelError(f"the box {text!r} is empty: write xmin, ymin, xmax, ymax")
    return Place(kind, text, numbers)


def _material(sheet: Sheet) -> Any:
    """The sheet without its openings."""
    import shapely

    openings = [cut for cut in sheet.cuts if isinstance(cut, shapely.Polygon)]
    return sheet.outline.difference(shapely.union_all(openings)) if openings else sheet.outline
