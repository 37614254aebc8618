"""Twelve sheets in the manner of different trades and programs: writes benchmarks/data/dozen.

Own designs after kinds of cut sheets that are common, none copied. Deterministic: the files are the same every time.

    python benchmarks/dozen_drawings.py
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import dozen_writers as writers
import shapely
from dozen_writers import Curve, Piece, Point, at, points_of

FOLDER = Path(__file__).parent / "data" / "dozen"


@dataclass(frozen=True)
class Design:
    """One sheet, in millimetres, and what it is made of.

    Attributes
    ----------
    name, ending : str
        Of its file.
    about : str
        What it is after.
    write : callable
        The dialect.
    outline, cuts
        Curves; a cut that closes is an opening.
    thickness : float
        Millimetres.
    E : float
        Young's modulus in GPa.
    """

    name: str
    ending: str
    about: str
    write: Callable[[Curve, Sequence[Curve]], str]
    outline: Curve
    cuts: list[Curve]
    thickness: float
    E: float

    @property
    def file(self) -> Path:
        return FOLDER / f"{self.name}.{self.ending}"

    def polygon(self) -> shapely.Polygon:
        """The outline [mm]."""
        return shapely.Polygon(points_of(self.outline))

    def shapes(self) -> list[shapely.LineString | shapely.Polygon]:
        """The cuts: lines and, of openings, polygons [mm]."""
        return [
            (shapely.Polygon if writers.is_closed(cut) else shapely.LineString)(points_of(cut)) for cut in self.cuts
        ]

    @property
    def area(self) -> float:
        """Area of the outline without openings [m2]."""
        return 1e-6 * (self.polygon().area - sum(shape.area for shape in self.shapes()))


# ---------------------------------------------------------------------------------------------- strokes


def chain(*points: Point, closed: bool = False) -> Curve:
    """Straight pieces from point to point."""
    ring = [*points, points[0]] if closed else list(points)
    return [("line", a, b) for a, b in pairwise(ring)]


def bow(a: Point, b: Point, sag: float) -> Piece:
    """The arc from a to b that rises by sag to the left of the way (to the right where sag is negative)."""
    chord = math.dist(a, b)
    radius = (chord**2 / 4 + sag**2) / (2 * abs(sag))
    along = math.degrees(math.atan2(b[1] - a[1], b[0] - a[0]))
    half = math.degrees(2 * math.atan(2 * abs(sag) / chord))
    side = math.copysign(1.0, sag)
    centre = at(((a[0] + b[0]) / 2, (a[1] + b[1]) / 2), radius - abs(sag), along - 90 * side)
    start = along + 90 * side
    return ("arc", centre, radius, start + side * half, start - side * half)


def rounded(*corners: Point, radius: float) -> Curve:
    """A closed polygon, drawn counter-clockwise, with round corners."""
    curve: Curve = []
    last: Point | None = None
    first: Point | None = None
    count = len(corners)
    for k, corner in enumerate(corners):
        before, after = corners[k - 1], corners[(k + 1) % count]
        a = math.degrees(math.atan2(corner[1] - before[1], corner[0] - before[0]))
        b = math.degrees(math.atan2(after[1] - corner[1], after[0] - corner[0]))
        turn = (b - a + 180) % 360 - 180
        trim = radius * math.tan(math.radians(turn) / 2)
        begin, end = at(corner, trim, a + 180), at(corner, trim, b)
        centre = at(begin, radius, a + 90)
        if last is not None:
            curve.append(("line", last, begin))
        curve.append(("arc", centre, radius, a - 90, a - 90 + turn))
        first, last = first or begin, end
    assert last is not None and first is not None
    return [*curve, ("line", last, first)]


def circle(centre: Point, radius: float, start: float = 90.0) -> Curve:
    """A circle by two halves."""
    return [("arc", centre, radius, start, start + 180), ("arc", centre, radius, start + 180, start + 360)]


def within(outline: Curve, cuts: Sequence[Curve], margin: float) -> list[Curve]:
    """The cuts that stay away from the rim by a margin, drawn as they are."""
    inner = shapely.Polygon(points_of(outline)).buffer(-margin)
    return [cut for cut in cuts if inner.contains(shapely.LineString(points_of(cut)))]


def staggered(box: tuple[float, float, float, float], pitch: float, rise: float) -> Iterator[Point]:
    """Places in rows, every other row moved by half a pitch."""
    x0, y0, x1, y1 = box
    for row in range(int((y1 - y0) / rise) + 1):
        x = x0 + (row % 2) * pitch / 2
        while x <= x1:
            yield x, y0 + row * rise
            x += pitch


def turned(point: Point, angle: float, centre: Point = (0.0, 0.0)) -> Point:
    """A point turned by degrees about a centre."""
    now = math.degrees(math.atan2(point[1] - centre[1], point[0] - centre[0]))
    return at(centre, math.dist(point, centre), now + angle)


# ---------------------------------------------------------------------------------------------- the dozen


def ribbon() -> tuple[Curve, list[Curve]]:
    outline = rounded((0, 0), (60, 0), (60, 150), (0, 150), radius=6)
    cuts: list[Curve] = []
    for row in range(9):
        y = 25 + 12.5 * row
        if row % 2:
            cuts += [[bow((0, y), (23, y), 1.2)], [bow((60, y), (37, y), -1.2)]]
        else:
            cuts.append([bow((9, y), (51, y), 3)])
    return outline, cuts


def squares() -> tuple[Curve, list[Curve]]:
    outline = rounded((0, 0), (90, 0), (90, 120), (0, 120), radius=4)
    cuts = []
    for i in range(-8, 9):
        for j in range(-8, 9):
            centre, half = (17.0 * i, 17.0 * j), 14.0
            along = (half, 0.0) if (i + j) % 2 else (0.0, half)
            pair = [turned((centre[0] + s * along[0], centre[1] + s * along[1]), 20.0) for s in (-1, 1)]
            a, b = ((45 + x, 60 + y) for x, y in pair)
            cuts.append(chain(a, b))
    return outline, within(outline, cuts, 2.5)


def spiral() -> tuple[Curve, list[Curve]]:
    """Two arms of half circles of growing radius about two centres."""
    outline, cuts, growth = circle((45, 45), 44), [], 7.5
    for first in (10.0, 190.0):
        curve: Curve = []
        for half in range(4):
            centre = at((45, 45), growth / 2, first + 180.0 * (half + 1))
            curve.append(("arc", centre, 10.0 + growth * half, first + 180.0 * half, first + 180.0 * (half + 1)))
        cuts.append(curve)
    return outline, cuts


def smiles() -> tuple[Curve, list[Curve]]:
    """A tension specimen with a waist."""
    outline: Curve = [
        ("line", (0, 0), (70, 0)), ("line", (70, 0), (70, 14)), bow((70, 14), (70, 116), 6),
        ("line", (70, 116), (70, 130)), ("line", (70, 130), (0, 130)), ("line", (0, 130), (0, 116)),
        bow((0, 116), (0, 14), 6), ("line", (0, 14), (0, 0)),
    ]  # fmt: skip
    cuts = [[bow((x - 7, y), (x + 7, y), -2.5)] for x, y in staggered((-1, 24, 71, 108), 18, 6.5)]
    return outline, within(outline, cuts, 1.5)


def fan() -> tuple[Curve, list[Curve]]:
    centre, spread = (70.0, -40.0), 32.0
    a, b = 90 - spread, 90 + spread
    outline: Curve = [
        ("arc", centre, 150, a, b), ("line", at(centre, 150, b), at(centre, 50, b)), ("arc", centre, 50, b, a),
        ("line", at(centre, 50, a), at(centre, 150, a)),
    ]  # fmt: skip
    cuts: list[Curve] = []
    for ring in range(7):
        radius = 64.0 + 12.0 * ring
        if ring % 2:  # from both sides
            cuts += [[("arc", centre, radius, a, a + 23)], [("arc", centre, radius, b, b - 23)]]
        else:
            cuts.append([("arc", centre, radius, a + 7, b - 7)])
    return outline, cuts


def rings() -> tuple[Curve, list[Curve]]:
    outline, cuts = circle((50, 50), 50), []
    for ring in range(5):
        radius, shift = 8.0 + 8.0 * ring, 60.0 * (ring % 2)
        gap = math.degrees(5.0 / radius)  # ligaments of five millimetres
        for k in range(3):
            start = 30.0 + shift + 120.0 * k
            cuts.append([("arc", (50.0, 50.0), radius, start + gap / 2, start + 120 - gap / 2)])
    return outline, cuts


def fractal() -> tuple[Curve, list[Curve]]:
    """Cuts of two levels on an eight-cornered plate."""
    c = 18.0
    outline = chain((c, 0), (100 - c, 0), (100, c), (100, 100 - c), (100 - c, 100), (c, 100), (0, 100 - c), (0, c),
                    closed=True)  # fmt: skip
    cuts = [chain((16, 50), (84, 50)), chain((50, 6), (50, 44)), chain((50, 56), (50, 94))]
    for x in (27.0, 73.0):
        for y in (27.0, 73.0):
            if x < 50:
                cuts.append(chain((x - 15, y), (x + 19, y)))
            else:
                cuts.append(chain((x - 19, y), (x + 15, y)))
            cuts += [chain((x, y - 15), (x, y - 4)), chain((x, y + 4), (x, y + 15))]
    return outline, cuts


def graft() -> tuple[Curve, list[Curve]]:
    """Skin for a burn: slits of one length in slanted rows on a patch with round ends."""
    outline: Curve = [
        ("line", (22, 0), (58, 0)), ("arc", (58, 22), 22, -90, 0), ("line", (80, 22), (80, 108)),
        ("arc", (58, 108), 22, 0, 90), ("line", (58, 130), (22, 130)), ("arc", (22, 108), 22, 90, 180),
        ("line", (0, 108), (0, 22)), ("arc", (22, 22), 22, 180, 270),
    ]  # fmt: skip
    cuts = []
    for x, y in staggered((-80, -70, 80, 70), 20, 7):
        a, b = (turned((x + s * 7.5, y), 14.0) for s in (-1, 1))
        cuts.append(chain((40 + a[0], 65 + a[1]), (40 + b[0], 65 + b[1])))
    return outline, within(outline, cuts, 2.5)


def facade() -> tuple[Curve, list[Curve]]:
    """A tapered panel with lens-shaped openings that grow towards its foot."""
    outline = chain((0, 0), (110, 0), (90, 140), (20, 140), closed=True)
    cuts: list[Curve] = []
    for row in range(10):
        y = 16 + 12 * row
        half, open_by = 9.5 - 0.35 * row, 1.0 - 0.05 * row
        pitch = 2 * half + 5
        count = 4
        for k in range(count + row % 2):
            x = 55 + pitch * (k - (count - 1 + row % 2) / 2)
            a, b = (x - half, y), (x + half, y)
            cuts.append([bow(a, b, -open_by), bow(b, a, -open_by)])
    return outline, within(outline, cuts, 2.0)


def scales() -> tuple[Curve, list[Curve]]:
    """The skin of a crawling robot: scales of two strokes each on a strip with tapered ends."""
    outline = chain((18, 0), (52, 0), (70, 22), (70, 138), (52, 160), (18, 160), (0, 138), (0, 22), closed=True)
    cuts = [chain((x - 8, y + 5), (x, y), (x + 8, y + 5)) for x, y in staggered((-5, 18, 75, 140), 20, 7)]
    return outline, within(outline, cuts, 2.0)


def tripods() -> tuple[Curve, list[Curve]]:
    """Cuts of three legs on a triangular lattice, in a slanted panel."""
    outline = chain((0, 0), (80, 0), (100, 120), (20, 120), closed=True)
    cuts: list[Curve] = []
    for x, y in staggered((0, 14, 100, 110), 19, 16.5):
        knee, angles = (x, y), (100.0, 220.0, 340.0)
        first, second, third = (at(knee, 9.0, angle) for angle in angles)
        pair = within(outline, [chain(first, knee, second), chain(knee, third)], 2.5)
        cuts += pair if len(pair) == 2 else []
    return outline, cuts


def lantern() -> tuple[Curve, list[Curve]]:
    """Rings of hexagons, each cut but for two ligaments, in a hexagon."""
    centre = (52.0, 60.0)
    outline = chain(*(at(centre, 60, 30 + 60 * k) for k in range(6)), closed=True)
    cuts: list[Curve] = []
    for ring in range(4):
        radius = 14.0 + 11.0 * ring
        corners = [at(centre, radius, 30 + 60 * k) for k in range(6)]
        shift = ring % 2
        for half in (0, 3):
            k = half + shift  # from the middle of a side, round three corners, to the middle of a side
            a, b = corners[(k - 1) % 6], corners[k % 6]
            c, d = corners[(k + 2) % 6], corners[(k + 3) % 6]
            gap = 2.5 / radius
            begin = tuple(p + (0.5 + gap) * (q - p) for p, q in zip(a, b))
            end = tuple(p + (0.5 - gap) * (q - p) for p, q in zip(c, d))
            cuts.append(chain(begin, b, corners[(k + 1) % 6], c, end))  # type: ignore[arg-type]
    return outline, cuts


def _inch_fold(outline: Curve, cuts: Sequence[Curve]) -> str:
    return writers.fold(outline, cuts, "in")


def _centimetre_fold(outline: Curve, cuts: Sequence[Curve]) -> str:
    return writers.fold(outline, cuts, "cm")


def dozen() -> list[Design]:
    """The twelve designs."""
    table: list[tuple[str, str, str, Callable[..., str], Callable[[], tuple[Curve, list[Curve]]], float, float]] = [
        ("ribbon", "dxf", "ribbon from a laser cutter, bowed slits", writers.dxf_r12, ribbon, 0.1, 3.5),
        ("fan", "dxf", "folding fan, concentric slits from both sides", writers.dxf_bulges, fan, 0.2, 3.5),
        ("scales", "dxf", "skin of a crawling robot, scales of two strokes", writers.dxf_inches, scales, 0.125, 4.0),
        ("squares", "svg", "auxetic: turned squares on ligaments", writers.svg_layers, squares, 0.25, 2.5),
        ("spiral", "svg", "disc with a spiral of two arms", writers.svg_classes, spiral, 0.2, 3.5),
        ("graft", "svg", "meshed skin graft, slanted slits", writers.svg_uses, graft, 0.3, 0.02),
        ("fractal", "fold", "cuts of two levels", writers.fold, fractal, 0.2, 2.0),
        ("tripods", "fold", "three-legged cuts in a slanted panel", _centimetre_fold, tripods, 0.2, 2.5),
        ("lantern", "fold", "hexagonal lantern", _inch_fold, lantern, 0.1, 5.0),
        ("smiles", "geojson", "tension specimen with smiling cuts", writers.geojson_features, smiles, 0.1, 3.5),
        ("rings", "geojson", "disc of concentric arcs", writers.geojson_collected, rings, 0.1, 3.5),
        ("facade", "geojson", "tapered facade, lens-shaped openings", writers.geojson_features, facade, 0.5, 70.0),
    ]
    return [
        Design(name, ending, about, write, *make(), thickness, E)
        for name, ending, about, write, make, thickness, E in table
    ]


def separate(cuts: Sequence[shapely.LineString | shapely.Polygon]) -> int:
    """Number of cuts that do not touch each other, however many strokes drew them."""
    size = max(abs(value) for cut in cuts for value in cut.bounds)
    return len(shapely.get_parts(shapely.union_all([cut.buffer(1e-5 * size) for cut in cuts])))


def main() -> None:
    """Write the drawings and what is to be read in them."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    listed = []
    for design in dozen():
        design.file.write_text(design.write(design.outline, design.cuts), encoding="utf-8", newline="\n")
        listed.append({
            "file": design.file.name, "about": design.about, "dialect": design.write.__name__.strip("_"),
            "thickness": f"{design.thickness:g}mm", "E": f"{design.E:g}GPa", "area": float(f"{design.area:.9g}"),
            "cuts": separate(design.shapes()),
        })  # fmt: skip
    text = "[\n" + ",\n".join(json.dumps(row) for row in listed) + "\n]\n"
    (FOLDER / "dozen.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
