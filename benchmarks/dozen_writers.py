"""Drawings written in the manner of different programs: curves of lines and arcs as DXF, SVG, FOLD and GeoJSON.

A curve is a list of pieces, each ("line", p, q) or ("arc", centre, radius, start, end) with angles in degrees, end to
end; y points up and lengths are millimetres. Every function below is one dialect.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from itertools import pairwise

Point = tuple[float, float]
Piece = tuple
Curve = list[Piece]
FLAT = 0.01  # mm by which a chord may miss its arc


def at(centre: Point, radius: float, angle: float) -> Point:
    """The point of a circle at an angle in degrees."""
    return centre[0] + radius * math.cos(math.radians(angle)), centre[1] + radius * math.sin(math.radians(angle))


def ends(piece: Piece) -> tuple[Point, Point]:
    """First and last point of a piece."""
    if piece[0] == "line":
        return piece[1], piece[2]
    return at(piece[1], piece[2], piece[3]), at(piece[1], piece[2], piece[4])


def points_of(curve: Curve) -> list[Point]:
    """A curve as points, its arcs by chords."""
    points = [ends(curve[0])[0]]
    for piece in curve:
        if piece[0] == "arc":
            _, centre, radius, start, end = piece
            count = max(2, math.ceil(math.radians(abs(end - start)) / (2 * math.acos(1 - FLAT / radius))))
            points += [at(centre, radius, start + (end - start) * k / count) for k in range(1, count)]
        points.append(ends(piece)[1])
    if is_closed(curve):
        points[-1] = points[0]
    return points


def is_closed(curve: Curve) -> bool:
    return math.dist(ends(curve[0])[0], ends(curve[-1])[1]) < 1e-9


# ------------------------------------------------------------------------------------------------- DXF


def _dxf(groups: Sequence[tuple[int, object]]) -> str:
    return "".join(f"{code:3d}\n{value:.9g}\n" if isinstance(value, float) else f"{code:3d}\n{value}\n"
                   for code, value in groups)  # fmt: skip


def dxf_r12(outline: Curve, cuts: Sequence[Curve]) -> str:
    """Every line and arc by itself, layers of a German shop, millimetres in the header."""
    groups: list[tuple[int, object]] = [
        (999, "lines and arcs"), (0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1009"), (9, "$INSUNITS"),
        (70, 4), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"),
    ]  # fmt: skip
    for layer, curves in (("KONTUR", [outline]), ("SCHNITT", cuts)):
        for piece in (piece for curve in curves for piece in curve):
            if piece[0] == "line":
                (x, y), (u, v) = piece[1:]
                groups += [(0, "LINE"), (8, layer), (10, float(x)), (20, float(y)), (11, float(u)), (21, float(v))]
            else:
                _, (x, y), radius, start, end = piece
                low, high = sorted((start, end))
                groups += [(0, "ARC"), (8, layer), (10, float(x)), (20, float(y)), (40, float(radius)),
                           (50, float(low % 360)), (51, float(high % 360))]  # fmt: skip
    return _dxf([*groups, (0, "ENDSEC"), (0, "EOF")])


def dxf_bulges(outline: Curve, cuts: Sequence[Curve]) -> str:
    """Old polylines with bulges on one layer, told apart by colour (7 the rim, 1 the cuts), in millimetres."""
    groups: list[tuple[int, object]] = [
        (0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1009"), (9, "$INSUNITS"), (70, 4), (0, "ENDSEC"),
        (0, "SECTION"), (2, "ENTITIES"),
    ]  # fmt: skip
    for color, curves in ((7, [outline]), (1, cuts)):
        for curve in curves:
            closed = is_closed(curve)
            groups += [(0, "POLYLINE"), (8, "0"), (62, color), (66, 1), (70, int(closed))]
            for piece in curve:
                x, y = ends(piece)[0]
                bulge = math.tan(math.radians(piece[4] - piece[3]) / 4) if piece[0] == "arc" else 0.0
                groups += [(0, "VERTEX"), (8, "0"), (62, color), (10, float(x)), (20, float(y)), (42, float(bulge))]
            if not closed:
                x, y = ends(curve[-1])[1]
                groups += [(0, "VERTEX"), (8, "0"), (62, color), (10, float(x)), (20, float(y))]
            groups += [(0, "SEQEND"), (8, "0")]
    return _dxf([*groups, (0, "ENDSEC"), (0, "EOF")])


def dxf_inches(outline: Curve, cuts: Sequence[Curve]) -> str:
    """Light polylines of straight pieces, in inches, layers Outline and Cut."""
    groups: list[tuple[int, object]] = [
        (0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1015"), (9, "$INSUNITS"), (70, 1), (0, "ENDSEC"),
        (0, "SECTION"), (2, "ENTITIES"),
    ]  # fmt: skip
    for layer, curves in (("Outline", [outline]), ("Cut", cuts)):
        for curve in curves:
            points, closed = points_of(curve), is_closed(curve)
            points = points[:-1] if closed else points
            groups += [(0, "LWPOLYLINE"), (100, "AcDbEntity"), (8, layer), (100, "AcDbPolyline"), (90, len(points)),
                       (70, int(closed))]  # fmt: skip
            groups += [pair for x, y in points for pair in ((10, float(x) / 25.4), (20, float(y) / 25.4))]
    return _dxf([*groups, (0, "ENDSEC"), (0, "EOF")])


# ------------------------------------------------------------------------------------------------- SVG


def _path(curve: Curve, unit: float, top: float) -> str:
    """Path data; pages count y downwards from the top."""
    x, y = ends(curve[0])[0]
    words = [f"M{unit * x:.5f},{unit * (top - y):.5f}"]
    for piece in curve:
        x, y = ends(piece)[1]
        end = f"{unit * x:.5f},{unit * (top - y):.5f}"
        if piece[0] == "line":
            words.append(f"L{end}")
        else:
            _, _, radius, start, stop = piece
            assert abs(stop - start) < 360
            large, sweep = int(abs(stop - start) > 180), int(stop < start)
            words.append(f"A{unit * radius:.5f} {unit * radius:.5f} 0 {large} {sweep} {end}")
    return " ".join(words) + (" Z" if is_closed(curve) else "")


def _page(outline: Curve) -> tuple[float, float]:
    points = points_of(outline)
    return max(x for x, _ in points), max(y for _, y in points)


def svg_layers(outline: Curve, cuts: Sequence[Curve]) -> str:
    """Layers with labels, millimetres, a layer that is moved as a whole: in the manner of Inkscape."""
    width, height = (math.ceil(size) + 5 for size in _page(outline))
    style = "fill:none;stroke:#ff0000;stroke-width:0.1"
    paths = "\n".join(
        f'    <path id="path{200 + k}" style="{style}" d="{_path(cut, 1, height + 7)}" />' for k, cut in enumerate(cuts)
    )
    return f"""<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<!-- in the manner of Inkscape 1.x -->
<svg width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}" version="1.1" inkscape:version="1.2.2"
   xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape">
  <g inkscape:label="Outline" inkscape:groupmode="layer" id="layer1">
    <path id="path100" style="fill:none;stroke:#000000;stroke-width:0.1" d="{_path(outline, 1, height)}" />
  </g>
  <g inkscape:label="Cuts" inkscape:groupmode="layer" id="layer2" transform="translate(0,-7)">
{paths}
  </g>
</svg>
"""


def svg_classes(outline: Curve, cuts: Sequence[Curve]) -> str:
    """Points (72 to the inch), classes of a style sheet, roles by colour: in the manner of Illustrator."""
    unit = 72 / 25.4
    width, height = (math.ceil(size) for size in _page(outline))
    paths = "\n".join(f'\t<path class="st1" d="{_path(cut, unit, height)}"/>' for cut in cuts)
    return f"""<?xml version="1.0" encoding="utf-8"?>
<!-- Generator: Adobe Illustrator 24.0.1, SVG Export Plug-In: in its manner -->
<svg version="1.1" xmlns="http://www.w3.org/2000/svg" x="0px" y="0px" width="{unit * width:.6f}px"
  height="{unit * height:.6f}px" viewBox="0 0 {unit * width:.6f} {unit * height:.6f}">
<style type="text/css">
 .st0{{fill:none;stroke:#000000;stroke-width:0.25;}}
 .st1{{fill:none;stroke:#FF0000;stroke-width:0.25;}}
</style>
<g>
 <path class="st0" d="{_path(outline, unit, height)}"/>
{paths}
</g>
</svg>
"""


def svg_uses(outline: Curve, cuts: Sequence[Curve]) -> str:
    """Straight cuts as one symbol used again and again, turned and moved; centimetres: in the manner of a script."""
    first = cuts[0][0]
    length = math.dist(first[1], first[2])
    width, height = (math.ceil(size) for size in _page(outline))
    uses = []
    for (_, (x, y), (u, v)), in cuts:  # one straight piece each, all of one length
        turn, scale = math.degrees(math.atan2(y - v, u - x)), math.dist((x, y), (u, v)) / length
        uses.append(f'    <use href="#slit" transform="translate({x / 10:.6f} {(height - y) / 10:.6f}) '
                    f'rotate({turn:.6f}) scale({scale:.8f})"/>')  # fmt: skip
    listed = "\n".join(uses)
    return f"""<svg xmlns="http://www.w3.org/2000/svg" width="{width / 10}cm" height="{height / 10}cm"
  viewBox="0 0 {width / 10} {height / 10}">
  <defs><line id="slit" x1="0" y1="0" x2="{length / 10:.6f}" y2="0"/></defs>
  <path id="outline" fill="none" stroke="black" stroke-width="0.01" d="{_path(outline, 0.1, height)}"/>
  <g id="cuts" stroke="red" stroke-width="0.01">
{listed}
  </g>
</svg>
"""


# ------------------------------------------------------------------------------------------------- FOLD, GeoJSON


def fold(outline: Curve, cuts: Sequence[Curve], unit: str = "mm") -> str:
    """A crease pattern without faces: rims B and cuts C, vertices shared where curves meet."""
    ratio = {"mm": 1.0, "cm": 0.1, "in": 1 / 25.4}[unit]
    vertices: dict[tuple[float, float], int] = {}

    def number(point: Point) -> int:
        return vertices.setdefault((round(ratio * point[0], 7), round(ratio * point[1], 7)), len(vertices))

    edges, letters = [], []
    for letter, curves in (("B", [outline]), ("C", cuts)):
        for curve in curves:
            chain = [number(point) for point in points_of(curve)]
            edges += [[a, b] for a, b in pairwise(chain)]
            letters += [letter] * (len(chain) - 1)
    content = {
        "file_spec": 1.1, "file_creator": "a script", "file_classes": ["singleModel"],
        "frame_classes": ["creasePattern"], "frame_attributes": ["2D"], "frame_unit": unit,
        "vertices_coords": [list(point) for point in vertices], "edges_vertices": edges, "edges_assignment": letters,
    }  # fmt: skip
    return json.dumps(content) + "\n"


def _rounded(points: Sequence[Point], ratio: float) -> list[list[float]]:
    return [[round(ratio * x, 6), round(ratio * y, 6)] for x, y in points]


def _collection(features: list[tuple[str, str, object]], unit: str, key: str) -> str:
    content = {
        "type": "FeatureCollection", "unit": unit,
        "features": [
            {"type": "Feature", "properties": {key: role}, "geometry": {"type": kind, "coordinates": coordinates}}
            for role, kind, coordinates in features
        ],
    }  # fmt: skip
    return json.dumps(content) + "\n"


def geojson_features(outline: Curve, cuts: Sequence[Curve]) -> str:
    """One feature for each curve, in millimetres, its role in the property "layer"."""
    features: list[tuple[str, str, object]] = [("outline", "Polygon", [_rounded(points_of(outline), 1)])]
    for cut in cuts:
        closed, points = is_closed(cut), _rounded(points_of(cut), 1)
        features.append(("cuts", "Polygon" if closed else "LineString", [points] if closed else points))
    return _collection(features, "mm", "layer")


def geojson_collected(outline: Curve, cuts: Sequence[Curve]) -> str:
    """All cuts as one multiple line, in centimetres: in the manner of a geometry library."""
    features: list[tuple[str, str, object]] = [
        ("cut", "MultiLineString", [_rounded(points_of(cut), 0.1) for cut in cuts]),
        ("outline", "LineString", _rounded(points_of(outline), 0.1)),
    ]
    return _collection(features, "cm", "role")
