"""Drawings in the manner of many programs and trades, made from a few lines each: what is in them is known exactly.

`python tests/io/made_drawings.py FOLDER` writes them all, for a look.
"""

# ruff: noqa: E501
from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Point = tuple[float, float]
WIDTH, HEIGHT = 120.0, 80.0
CORNERS: list[Point] = [(0, 0), (WIDTH, 0), (WIDTH, HEIGHT), (0, HEIGHT)]
SLITS: list[list[Point]] = [[(20, 20), (60, 20)], [(30, 40), (90, 40)], [(0, 60), (30, 60)]]


@dataclass(frozen=True)
class Made:
    """A drawing, and what it shows: area of the sheet [mm2], slits, openings, folds, and words that must be told."""

    name: str
    text: str
    area: float = WIDTH * HEIGHT
    slits: int = 3
    openings: int = 0
    folds: int = 0
    told: str = ""
    options: dict[str, Any] = field(default_factory=dict)


def turned(point: Point, degrees: float, about: Point = (60, 40)) -> Point:
    """A point turned about another."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y = point[0] - about[0], point[1] - about[1]
    return about[0] + c * x - s * y, about[1] + s * x + c * y


def round_rim(radius: float, degrees: float, about: Point = (60, 40)) -> Point:
    """A point of a circle."""
    return turned((about[0] + radius, about[1]), degrees, about)


# ------------------------------------------------------------------------------------------- SVG


def svg(body: str, head: str = 'width="120mm" height="80mm" viewBox="0 0 120 80"', extra: str = "") -> str:
    return (
        f'<?xml version="1.0"?>\n<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        f'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" {head}>\n{extra}{body}\n</svg>\n'
    )


def path(points: list[Point], closed: bool = False, paint: str = 'fill="none" stroke="#f00"') -> str:
    data = "M" + " L".join(f"{x:.6f},{y:.6f}" for x, y in points) + ("Z" if closed else "")
    return f'<path d="{data}" {paint}/>'


BLACK, RED, BLUE = ('fill="none" stroke="#000"', 'fill="none" stroke="#f00"', 'fill="none" stroke="#00f"')
RIM = path(CORNERS, True, BLACK)
CUTS = "".join(path(slit) for slit in SLITS)


def sides(paint: str, over: float = 0.0) -> str:
    """The rim as four lines, each longer than its side at both ends."""
    lines = [[(-over, 0), (120 + over, 0)], [(120, -over), (120, 80 + over)]]
    lines += [[(120 + over, 80), (-over, 80)], [(0, 80 + over), (0, -over)]]
    return "".join(path(line, False, paint) for line in lines)  # type: ignore[arg-type]


def svg_drawings() -> list[Made]:
    page = '<rect x="-10" y="-10" width="140" height="100" '
    wide = 'width="160mm" height="120mm" viewBox="-20 -20 160 120"'
    boxed = RIM + CUTS
    disc = f'<circle cx="60" cy="40" r="38" {BLACK}/>'
    spokes = [path([round_rim(38, a), round_rim(12, a)]) for a in (10, 100, 190, 280)]
    ring = f'<circle cx="60" cy="40" r="10" {RED}/>'
    slots = [path([(0, y), (20, y), (20, y + 3), (0, y + 3)]) for y in (10, 30, 50)]
    cross = path([(40, 20), (80, 20)]) + path([(40, 40), (80, 40)]) + path([(50, 10), (50, 50)])
    cross += path([(70, 10), (70, 50)])
    disc_area = math.pi * 38**2
    return [
        Made("inkscape_page_without_paint.svg", svg(page + 'style="fill:none;stroke:none"/>' + boxed, wide),
             told="neither painted nor visible"),
        Made("inkscape_hidden_layers.svg", svg(
            f'<g inkscape:groupmode="layer" inkscape:label="old" style="display:none">{page}{BLACK}/></g>'
            f'<g inkscape:groupmode="layer" inkscape:label="ghost" style="opacity:0">{page}{BLACK}/></g>' + boxed, wide)),
        Made("illustrator_artboard.svg", svg(
            page + 'class="st0"/>' + path(CORNERS, True, 'class="st1"') + CUTS, wide,
            "<style>.st0{fill:none;} .st1{fill:none;stroke:#000000;stroke-width:0.1;}</style>")),
        Made("corel_hundredths.svg", svg(
            f'<g id="Ebene_x0020_1"><g transform="scale(100)">{boxed}</g></g>',
            'width="120mm" height="80mm" viewBox="0 0 12000 8000"')),
        Made("affinity_nested.svg", svg(
            f'<g transform="matrix(0,1,-1,0,80,0)"><svg x="0" y="0">{boxed}</svg></g>',
            'width="80mm" height="120mm" viewBox="0 0 80 120"')),
        Made("white_page.svg", svg(page + 'fill="white"/>' + boxed, wide), told="neither painted nor visible"),
        Made("white_on_black.svg", svg(
            page + 'fill="#000"/>' + path(CORNERS, True, 'fill="none" stroke="#fff"')
            + "".join(path(slit, False, 'fill="none" stroke="#fff"') for slit in SLITS), wide), told="frame of a page"),
        Made("transparent_ink.svg", svg(
            page + 'fill="transparent" stroke="rgba(0,0,0,0)"/>' + page + 'fill="none" stroke="#000" stroke-width="0"/>'
            + page + 'fill="none" stroke="#000" stroke-opacity="0"/>' + page + f'{BLACK} visibility="hidden"/>'
            + boxed, wide)),
        Made("defs_masks_markers.svg", svg(boxed, wide, "".join(
            f'<{kind} id="{kind}">{page}{BLACK}/></{kind}>' for kind in ("defs", "mask", "marker", "pattern", "symbol")))),
        Made("fusion_single_lines.svg", svg(sides(BLACK) + "".join(path(s, False, BLACK) for s in SLITS))),
        Made("overshot_corners.svg", svg(sides(BLACK, 1.5) + CUTS, wide), told="tails of the outline"),
        Made("slits_meet_the_rim_midway.svg", svg(sides(BLACK) + CUTS + path([(60, 80), (60, 60)]))
             , slits=4),
        Made("dashed_folds.svg", svg(
            boxed + '<path d="M100 0V80" fill="none" stroke="#000" stroke-dasharray="3,2"/>'), folds=1),
        Made("clipped_to_the_sheet.svg", svg(
            RIM + f'<clipPath id="c"><rect width="120" height="80"/></clipPath><g clip-path="url(#c)">'
            f'{path([(-15, 20), (60, 20)])}{path([(90, 40), (150, 40)])}</g>', wide), slits=2, told="clip path"),
        Made("clip_in_turned_group.svg", svg(
            RIM + '<clipPath id="c"><circle r="10"/></clipPath><g transform="translate(60,40) rotate(30)">'
            f'<g style="clip-path:url(#c)">{path([(-40, 0), (40, 0)])}</g></g>'), slits=1),
        Made("clip_with_a_hole.svg", svg(
            RIM + '<clipPath id="c"><path clip-rule="evenodd" d="M0 0H120V80H0ZM40 20H80V60H40Z"/></clipPath>'
            f'<g clip-path="url(#c)">{path([(10, 40), (110, 40)])}</g>', wide), slits=2, told="clip path"),
        Made("clip_by_the_box.svg", svg(
            RIM + '<clipPath id="c" clipPathUnits="objectBoundingBox"><rect width=".25" height="1"/><rect x=".5" width=".5" '
            f'height="1"/></clipPath><g clip-path="url(#c)">{path([(10, 20), (90, 20)])}{path([(10, 60), (90, 60)])}</g>', wide),
             slits=4, told="clip path"),
        Made("masked_by_a_shade.svg", svg(
            RIM + '<mask id="m"><rect width="120" height="80" fill="#fff"/><g transform="translate(60 40)"><circle r="10"/></g>'
            f'</mask><g style="mask:url(#m)">{path([(10, 40), (110, 40)])}</g>{path([(10, 60), (30, 60)])}', wide),
             slits=3, told="cut off at a clip path or mask"),
        Made("spokes_from_the_rim.svg", svg(disc + "".join(spokes)), disc_area, slits=4),
        Made("spokes_to_the_hub.svg", svg(disc + ring + "".join(
            path([round_rim(10, a), round_rim(30, a)]) for a in (5, 95, 185, 275))), disc_area - math.pi * 100,
             slits=4, openings=1),
        Made("round_notch.svg", svg(RIM + f'<circle cx="0" cy="40" r="6" {RED}/>' + CUTS[: len(path(SLITS[0]))]),
             WIDTH * HEIGHT - math.pi * 18, slits=1, openings=1, told="notch"),
        Made("overcut_slits.svg", svg(RIM + path([(-3, 20), (60, 20)]) + path([(70, 50), (70, 85)]), wide), slits=2,
             told="trimmed"),
        Made("register_marks.svg", svg(boxed + "".join(
            path([(x - 2, y), (x + 2, y)], False, BLACK) + path([(x, y - 2), (x, y + 2)], False, BLACK)
            + f'<circle cx="{x}" cy="{y}" r="1" {BLACK}/>'
            for x, y in ((-10, -10), (130, -10), (130, 90), (-10, 90))), wide), told="outside the sheet"),
        Made("page_frame.svg", svg(page + BLACK + "/>" + boxed, wide), told="frame of a page"),
        Made("slots_from_the_rim.svg", svg(RIM + "".join(slots)), WIDTH * HEIGHT - 180, slits=0, told="3 pieces"),
        Made("cell_that_falls_out.svg", svg(RIM + cross), WIDTH * HEIGHT - 400, slits=8, openings=1, told="1 piece"),
        Made("side_drawn_again.svg", svg(boxed + path(CORNERS[:2])), told="along the rim again"),
        Made("kerf_double_lines.svg", svg(RIM + "".join(
            path([(x, 10), (x + 0.2, 10), (x + 0.2, 60), (x, 60)], True) for x in (20, 40, 60))),
             WIDTH * HEIGHT - 30, slits=0, openings=3),
        Made("polygon_and_polyline.svg", svg(
            f'<polygon points="0,0 120,0 120,80 0,80" {BLACK}/><polyline points="30,30 50,30 50,50 30,50 30,30" {RED}/>'
            f'<line x1="70" y1="20" x2="100" y2="60" {RED}/>'), WIDTH * HEIGHT - 400, slits=1, openings=1),
        Made("window_larger_than_half.svg", svg(sides(BLACK) + f'<rect x="5" y="5" width="110" height="70" {RED}/>'),
             WIDTH * HEIGHT - 7700, slits=0, openings=1),
        Made("round_slot_from_the_rim.svg", svg(RIM + f'<path d="M0,38 H20 A2,2 0 0 1 20,42 H0" {RED}/>'),
             WIDTH * HEIGHT - 80 - 2 * math.pi, slits=0, told="1 piece"),
        Made("rim_broken_at_a_slot.svg", svg(
            path([(0, 42), (0, 80), (120, 80), (120, 0), (0, 0), (0, 38)], False, BLACK)
            + path([(0, 38), (20, 38), (20, 42), (0, 42)])), WIDTH * HEIGHT - 80, slits=0),
        Made("corner_notch.svg", svg(RIM + f'<rect x="-5" y="-5" width="15" height="15" {RED}/>', wide),
             WIDTH * HEIGHT - 100, slits=0, openings=1, told="notch"),
        Made("strip_that_falls_off.svg", svg(RIM + path([(115, -5), (115, 85)]), wide), 115 * HEIGHT, slits=0, told="1 piece"),
        Made("slit_across_itself.svg", svg(RIM + path([(20, 20), (60, 60), (60, 20), (20, 60)])), WIDTH * HEIGHT - 400,
             slits=1, openings=1, told="1 piece"),
        Made("mark_in_a_hole.svg", svg(RIM + f'<circle cx="60" cy="40" r="20" {BLACK}/>' + path([(55, 40), (65, 40)])),
             WIDTH * HEIGHT - 400 * math.pi, slits=0, openings=1, told="1 slit in an opening, without effect"),
        Made("colours_named.svg", svg(boxed + path([(100, 0), (100, 80)], False, BLUE)), folds=1,
             options={"cuts": "red", "folds": "blue"}),
        Made("two_sheets.svg", svg(boxed + path([(130, 0), (170, 0), (170, 80), (130, 80)], True, BLACK),
                                   'width="180mm" height="80mm" viewBox="0 0 180 80"'), options={"part": 1}),
    ]  # fmt: skip


# ------------------------------------------------------------------------------------------- DXF


def dxf(entities: list[str], layers: list[tuple[str, int, int, str]] | None = None, unit: int | None = 4,
        blocks: str = "") -> str:  # fmt: skip
    """A file of bare entities; layers are name, colour (negative: off), flags (1: frozen) and line type."""
    rows = []
    if unit is not None:
        rows += ["0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70", str(unit), "0\nENDSEC"]
    if layers:
        rows += ["0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70", str(len(layers))]
        rows += [f"0\nLAYER\n2\n{name}\n70\n{flags}\n62\n{color}\n6\n{kind}" for name, color, flags, kind in layers]
        rows += ["0\nENDTAB\n0\nENDSEC"]
    if blocks:
        rows += ["0\nSECTION\n2\nBLOCKS", blocks, "0\nENDSEC"]
    return "\n".join([*rows, "0\nSECTION\n2\nENTITIES", *entities, "0\nENDSEC\n0\nEOF", ""])


def line(a: Point, b: Point, layer: str = "0", more: str = "") -> str:
    return f"0\nLINE\n8\n{layer}{more}\n10\n{a[0]!r}\n20\n{a[1]!r}\n11\n{b[0]!r}\n21\n{b[1]!r}"


def polyline(points: list[Point], closed: bool, layer: str = "0", bulges: dict[int, float] | None = None) -> str:
    rows = [f"0\nPOLYLINE\n8\n{layer}\n66\n1\n70\n{int(closed)}"]
    for number, (x, y) in enumerate(points):
        rows.append(f"0\nVERTEX\n8\n{layer}\n10\n{x!r}\n20\n{y!r}\n42\n{(bulges or {}).get(number, 0.0)!r}")
    return "\n".join([*rows, f"0\nSEQEND\n8\n{layer}"])


def circle(center: Point, radius: float, layer: str = "0") -> str:
    return f"0\nCIRCLE\n8\n{layer}\n10\n{center[0]!r}\n20\n{center[1]!r}\n40\n{radius!r}"


def arc(center: Point, radius: float, start: float, end: float, layer: str = "0") -> str:
    return circle(center, radius, layer).replace("CIRCLE", "ARC") + f"\n50\n{start!r}\n51\n{end!r}"


def box_lines(points: list[Point], layer: str = "0") -> list[str]:
    return [line(a, b, layer) for a, b in zip(points, [*points[1:], points[0]])]


def dxf_drawings() -> list[Made]:
    rim, slits = polyline(CORNERS, True), [line(*slit) for slit in SLITS]
    old = polyline([(-10, -10), (130, -10), (130, 90), (-10, 90)], True, "OLD")
    broken = [(0, 0), (40, 0), (80, 0), (120, 0), (120, 80), (70, 80), (0, 80)]
    r = 10.0
    rounded: list[Point] = [(r, 0), (120 - r, 0), (120, r), (120, 80 - r), (120 - r, 80), (r, 80), (0, 80 - r), (0, r)]
    round_area = WIDTH * HEIGHT - (4 - math.pi) * r * r
    quarter = math.tan(math.pi / 8)
    on_corner = [turned((120 - r + r, r), -a, (120 - r, r)) for a in (20, 45, 70)]
    pieces = [line(rounded[k], rounded[k + 1]) for k in (0, 2, 4, 6)]
    pieces += [arc((120 - r, r), r, 270, 0), arc((120 - r, 80 - r), r, 0, 90), arc((r, 80 - r), r, 90, 180)]
    pieces += [arc((r, r), r, 180, 270)]
    block = "0\nBLOCK\n8\n0\n2\nSLIT\n70\n0\n10\n0.0\n20\n0.0\n" + line((0, 0), (30, 0), "0", "\n62\n0") + "\n0\nENDBLK\n8\n0"
    inserts = [f"0\nINSERT\n8\nCUTS\n2\nSLIT\n10\n{x}\n20\n{y}\n50\n{turn}" for x, y, turn in
               ((20, 20, 0), (60, 30, 45), (100, 30, 90))]
    plain = "CONTINUOUS"
    return [
        Made("librecad_broken_rim.dxf", dxf(
            [*box_lines(broken), line((40, 0), (40, 30)), line((80, 0), (80, 30)), line((70, 80), (70, 50))])),
        Made("qcad_center_lines.dxf", dxf(
            [rim, *slits, line((-10, 40.5), (130, 40.5), "AXES"), line((60, -10), (60, 90), "AXES")],
            [("0", 7, 0, plain), ("AXES", 1, 0, "CENTER")])),
        Made("autocad_frozen_layer.dxf", dxf([old, rim, *slits], [("0", 7, 0, plain), ("OLD", 3, 1, plain)]),
             told="frozen"),
        Made("autocad_layer_off.dxf", dxf([old, rim, *slits], [("0", 7, 0, plain), ("OLD", -3, 0, plain)]), told="off"),
        Made("invisible_entity.dxf", dxf([old.replace("8\nOLD\n66", "8\n0\n60\n1\n66"), rim, *slits]), told="invisible"),
        Made("block_by_block.dxf", dxf(
            [polyline(CORNERS, True, "EDGE"), *inserts], [("0", 7, 0, plain), ("CUTS", 1, 0, plain)], blocks=block),
             options={"cuts": "red"}),
        Made("flat_pattern.dxf", dxf(
            [polyline(CORNERS, True, "OUTER_PROFILES"), circle((60, 60), 8, "INTERIOR_PROFILES"),
             line((80, 0), (80, 80), "BEND"), line((100, 0), (100, 80), "BEND")]),
             WIDTH * HEIGHT - math.pi * 64, slits=0, openings=0, folds=2),
        Made("rounded_in_pieces.dxf", dxf([*pieces, *slits]), round_area),
        Made("slits_on_round_corners.dxf", dxf([*pieces, *(line(p, (80.0, 40.0 - k)) for k, p in enumerate(on_corner))]),
             round_area),
        Made("bulges_and_slits.dxf", dxf(
            [polyline(rounded, True, bulges=dict.fromkeys((1, 3, 5, 7), quarter)),
             *(line(p, (80.0, 40.0 - k)) for k, p in enumerate(on_corner))]), round_area),
        Made("rim_closed_by_cuts.dxf", dxf(
            [polyline([(0, 42), (0, 80), (120, 80), (120, 0), (0, 0), (0, 38)], False, "OUTLINE"),
             polyline([(0, 38), (20, 38), (20, 42), (0, 42)], False, "CUTS")]), WIDTH * HEIGHT - 80, slits=0,
             told="closed by cuts"),
        Made("frame_with_title_block.dxf", dxf(
            [*box_lines([(-20, -20), (150, -20), (150, 100), (-20, 100)]), rim, *slits, line((100, -20), (100, -10)),
             line((100, -10), (150, -10))]), told="frame of a page"),
        Made("dimension_lines.dxf", dxf([rim, *slits, line((0, -5), (120, -5)), line((0, -1), (0, -7)),
                                         line((120, -1), (120, -7))]), told="3 curves lie outside"),
        Made("slits_from_corners.dxf", dxf([polyline([(0, 0), (60, -20), (120, 0), (120, 80), (0, 80)], True),
                                            line((60, -20), (60, 20)), line((0, 80), (30, 50))]), 10800, slits=2),
        Made("disc_of_two_arcs.dxf", dxf([arc((60, 40), 38, 0, 180), arc((60, 40), 38, 180, 360),
                                          line((22, 40), (50, 40)), line((60, 20), (60, 60))]), math.pi * 38**2, slits=2),
        Made("small_gaps.dxf", dxf(
            [line((0, 0), (120, 0.004)), line((120, 0), (120, 80)), line((120.003, 80), (0, 80)), line((0, 80), (0, 0.005)),
             *slits])),
        Made("slits_just_short.dxf", dxf([rim, line((0.004, 20), (30, 20)), line((60, 79.995), (60, 60)),
                                          line((20.005, 40), (90, 40)), line((20, 20.004), (20, 50))]), slits=4),
        Made("etched_text.dxf", dxf([rim, *slits, line((50, 70), (60, 75), "ETCH"), line((62, 70), (72, 75), "Engraving")])),
        Made("scored_inches.dxf", dxf(
            [polyline([(x / 25.4, y / 25.4) for x, y in CORNERS], True, "CUT"), line((1, 1), (2, 2), "CUT"),
             line((3, 0), (3, HEIGHT / 25.4), "SCORE")], unit=1), slits=1, folds=1),
        Made("dashed_line_type.dxf", dxf([rim, *slits, line((100, 0), (100, 80), "0", "\n6\nDASHED")]), folds=1),
        Made("header_says_metres.dxf", dxf([rim, *slits], unit=6), 1e6 * WIDTH * HEIGHT, told="unit of the drawing right"),
        Made("stray_loop.dxf", dxf([rim, *slits, polyline([(120, 80), (121, 80.5), (120, 81)], True)]), told="outside"),
        Made("doubled_everything.dxf", dxf([rim, rim, *slits, *slits]), told="drawn twice"),
        Made("circles_touching_rim.dxf", dxf([rim, *slits, circle((100, 10), 5)]), WIDTH * HEIGHT - math.pi * 25,
             openings=1),
        Made("half_round_end.dxf", dxf(
            [line((0, 0), (120, 0)), line((0, 80), (120, 80)), line((0, 0), (0, 80)), arc((120, 40), 40, 270, 90),
             line((160, 40), (130, 40)), line(round_rim(40, 30, (120, 40)), (130, 45))]),
             WIDTH * HEIGHT + math.pi * 800, slits=2),
    ]  # fmt: skip


# ------------------------------------------------------------------------------------------- FOLD and GeoJSON


def fold(frame: dict[str, Any]) -> str:
    return json.dumps({"file_spec": 1.2, "frame_unit": "mm"} | frame)


def fold_drawings() -> list[Made]:
    base: list[Point] = [*CORNERS, (60, 0), (60, 80), (30, 40), (90, 40)]
    edges = [(0, 4), (4, 1), (1, 2), (2, 5), (5, 3), (3, 0), (4, 5), (6, 7)]
    letters = ["B"] * 6 + ["V", "C"]
    plain = {"vertices_coords": base[:6] + [(10, 40), (40, 40)], "edges_vertices": edges, "edges_assignment": letters}
    flat = plain["vertices_coords"]
    folded = {"frame_classes": ["foldedForm"], "vertices_coords": [(x, y, abs(x - 60)) for x, y in flat]}  # type: ignore
    strip: list[Point] = [(0, 0), (60, 0), (120, 0), (120, 80), (60, 80), (0, 80)]
    halves = [[0, 1, 4, 5], [1, 2, 3, 4]]
    lips: list[Point] = [(0, 0), (120, 0), (120, 40), (120, 80), (0, 80), (0, 40), (60, 40), (120, 40)]
    lip_faces = [[0, 1, 2, 6, 5], [5, 6, 7, 3, 4]]
    slit_face = {"vertices_coords": [*CORNERS, (0, 40), (50, 40)], "faces_vertices": [[0, 1, 2, 3, 4, 5, 4]]}
    double = {
        "vertices_coords": [*CORNERS, (30, 40), (60, 40), (90, 40), (60, 40)],
        "edges_vertices": [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)],
        "edges_assignment": ["B"] * 8,
    }
    single = double | {"edges_vertices": double["edges_vertices"][:6], "edges_assignment": ["B"] * 6}
    neighbours: list[list[int]] = [[] for _ in base[:6]]
    for a, b in edges[:7]:
        neighbours[a].append(b)
        neighbours[b].append(a)
    return [
        Made("crease_pattern.fold", fold(plain), slits=1, folds=1),
        Made("y_is_up.fold", fold(plain | {"vertices_coords": [(x, 0, y) for x, y in flat]}), slits=1, folds=1),  # type: ignore
        Made("in_the_yz_plane.fold", fold(plain | {"vertices_coords": [(7, x, y) for x, y in flat]}), slits=1, folds=1),  # type: ignore
        Made("in_a_slanted_plane.fold", fold(plain | {"vertices_coords": [
            (x, 0.6 * y, 0.8 * y) for x, y in flat]}), slits=1, folds=1),  # type: ignore
        Made("pattern_in_second_frame.fold", fold(plain | folded | {"file_frames": [
            {"frame_classes": ["creasePattern"], "frame_parent": 0, "frame_inherit": True, "vertices_coords": flat}]}),
             slits=1, folds=1, told="frame 1"),
        Made("double_rims.fold", fold(double), slits=1),
        Made("single_rim_inside.fold", fold(single), slits=1),
        Made("faces_only.fold", fold({"vertices_coords": strip, "faces_vertices": halves}), slits=0, folds=1),
        Made("faces_that_share_no_edge.fold", fold({"vertices_coords": lips, "faces_vertices": lip_faces}), slits=1,
             folds=1),
        Made("slit_in_a_face.fold", fold(slit_face), slits=1),
        Made("unassigned.fold", fold({"vertices_coords": base[:6], "edges_vertices": edges[:7]}), slits=0, folds=1,
             told="outer face of the folds"),
        Made("neighbours_only.fold", fold({"vertices_coords": base[:6], "vertices_vertices": neighbours}), slits=0,
             folds=1),
    ]  # fmt: skip


def geojson(features: list[tuple[str, str, Any]], **properties: str) -> str:
    shapes = [{"type": "Feature", "properties": {"role": role} if role else dict(properties),
               "geometry": {"type": kind, "coordinates": at}} for role, kind, at in features]  # fmt: skip
    return json.dumps({"type": "FeatureCollection", "unit": "mm", "features": shapes})


def geojson_drawings() -> list[Made]:
    ring = [*CORNERS, CORNERS[0]]
    hole = [(80, 50), (100, 50), (100, 70), (80, 70), (80, 50)]
    lean = [turned(p, 27) for p in ring]
    from_rim = [[turned(p, 27) for p in ((40.0 * k, 0), (40.0 * k + 10, 30))] for k in (1, 2)]
    from_side = [turned((0, 33.3), 27), turned((55, 33.3), 27)]
    many = [round_rim(38, 360 * k / 64) for k in range(65)]
    spokes = [[round_rim(38, 360 * (k + 0.5) / 64), round_rim(15, 360 * (k + 0.5) / 64)] for k in (3, 20, 40)]
    many_area = 0.5 * 64 * 38**2 * math.sin(2 * math.pi / 64)
    return [
        Made("polygon_with_hole.geojson", geojson(
            [("outline", "Polygon", [ring, hole]), ("cut", "MultiLineString", SLITS)]), WIDTH * HEIGHT - 400),
        Made("without_roles.geojson", geojson([("", "Polygon", [ring]), ("", "MultiLineString", SLITS)])),
        Made("bare_collection.geojson", json.dumps({"type": "GeometryCollection", "unit": "mm", "geometries": [
            {"type": "Polygon", "coordinates": [ring]}, *({"type": "LineString", "coordinates": s} for s in SLITS)]})),
        Made("turned.geojson", geojson([("outline", "Polygon", [lean]), *(
            ("cut", "LineString", s) for s in [*from_rim, from_side])])),
        Made("polygonal_disc.geojson", geojson([("outline", "Polygon", [many]), *(
            ("cut", "LineString", s) for s in spokes)]), many_area, told="trimmed"),
        Made("hub_in_chords.geojson", geojson([("outline", "Polygon", [ring]), ("cut", "Polygon", [
            [round_rim(20, 360 * k / 64) for k in range(65)]]), ("cut", "LineString", [
                round_rim(20, 360 * 3.5 / 64), round_rim(35, 360 * 3.5 / 64)])]),
             WIDTH * HEIGHT - 0.5 * 64 * 20**2 * math.sin(2 * math.pi / 64), slits=1, openings=1,
             told="a bridge of 0.0241 mm at"),
        Made("folds_too.geojson", geojson([("outline", "Polygon", [ring]), ("cut", "MultiLineString", SLITS),
                                           ("fold", "LineString", [(100, 0), (100, 80)])]), folds=1),
    ]  # fmt: skip


def every() -> list[Made]:
    """All drawings."""
    makers: list[Callable[[], list[Made]]] = [svg_drawings, dxf_drawings, fold_drawings, geojson_drawings]
    return [made for maker in makers for made in maker()]


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for made in every():
        (folder / made.name).write_text(made.text)
