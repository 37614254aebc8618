"""Drawings as particular programs write them: one sheet of 120 by 80 mm with slits, in the words of each of them.

`python tests/io/made_by_programs.py FOLDER` writes them all, for a look.
"""

# ruff: noqa: E501
from __future__ import annotations

import io
import json
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from made_drawings import CORNERS, HEIGHT, SLITS, WIDTH, Made, Point, box_lines, circle, dxf, line, polyline

AREA = WIDTH * HEIGHT
PT, PX = 72 / 25.4, 96 / 25.4  # points and pixels to a millimetre
NS = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
INKSCAPE = (NS + ' xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
            'xmlns:sodipodi="http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd"')  # fmt: skip


def data(points: Sequence[Point], scale: float = 1.0, closed: bool = False, digits: int = 4) -> str:
    """A path of straight lines."""
    return "M" + "L".join(f"{round(x * scale, digits)} {round(y * scale, digits)}" for x, y in points) + "Z" * closed


def paths(scale: float, rim: str, cut: str) -> str:
    """The sheet as paths with these attributes."""
    return "".join([f'<path {rim} d="{data(CORNERS, scale, True)}"/>',
                    *(f'<path {cut} d="{data(slit, scale)}"/>' for slit in SLITS)])  # fmt: skip


# ------------------------------------------------------------------------------------------- drawing programs


def inkscape() -> list[Made]:
    style = 'style="display:inline;fill:none;stroke:#000000;stroke-width:0.264583px;stroke-linecap:butt;stroke-opacity:1"'
    red = style.replace("#000000", "#ff0000")
    head = f'<svg width="210mm" height="297mm" viewBox="0 0 210 297" version="1.1" id="svg5" {INKSCAPE} inkscape:version="1.2.2">'
    view = ('<sodipodi:namedview id="namedview7" pagecolor="#ffffff" inkscape:document-units="mm"><inkscape:grid type="xygrid"/>'
            '<sodipodi:guide position="60,100" orientation="0,1"/><inkscape:page x="0" y="0" width="210" height="297" id="page2"/>'
            "</sodipodi:namedview><defs id=\"defs2\"/>")  # fmt: skip
    rim = f'<path {style} d="m 10,20 h 120 v 80 H 10 Z" id="path1"/>'
    slits = "".join(f'<path {red} d="m {10 + a[0]},{20 + a[1]} {b[0] - a[0]},{b[1] - a[1]}" id="p{k}"/>'
                    for k, (a, b) in enumerate(SLITS))  # fmt: skip
    layer = '<g inkscape:label="{}" inkscape:groupmode="layer" id="{}" transform="{}">{}</g>'
    german = (layer.format("Umriss", "layer1", "translate(0,5)", rim) + layer.format("Schnitte", "layer2", "translate(0,5)", slits)
              + layer.format("Faltlinien", "layer3", "translate(0,5)", f'<path {style} d="M 110,20 V 100"/>'))  # fmt: skip
    french = (layer.format("Contour", "layer1", "scale(1)", rim) + layer.format("Découpe", "layer2", "", slits)
              + layer.format("Plis", "layer3", "", f'<path {style} d="M 110,20 V 100"/>'))  # fmt: skip
    clones = rim + slits + "".join(
        f'<use x="0" y="0" xlink:href="#p0" id="use{k}" transform="translate({50 * (k == 1)},{30 * (k == 2)})"/>' for k in (1, 2))
    folder = f'<g id="g1" transform="matrix(0.5,0,0,0.5,3,4)"><g id="g2" transform="scale(2)">{rim}{slits}</g></g>'
    arcs = (f'<path sodipodi:type="arc" {red} sodipodi:cx="0" sodipodi:cy="0" sodipodi:rx="10" sodipodi:ry="10" '
            'd="m 10,0 a 10,10 0 1 1 -20,0 10,10 0 1 1 20,0 z" transform="translate(70,60)"/>')  # fmt: skip
    rounded = (f'<rect {style} width="120" height="80" x="10" y="20" ry="10" rx="10"/>' + slits)
    mesh = (f'<path {style} inkscape:original-d="m 0,0 500,500" inkscape:path-effect="#pe1" '
            f'd="m 10,20 h 120 v 80 H 10 Z m 30,30 h 20 v 20 H 40 Z"/>{slits.replace("p1", "q1")}')  # fmt: skip
    end = "</svg>"
    return [
        Made("inkscape_relative_paths.svg", head + view + layer.format("Layer 1", "layer1", "translate(5,5)", rim + slits) + end),
        Made("inkscape_german_layers.svg", head + view + german + end, folds=1),
        Made("inkscape_french_layers.svg", head + view + french + end, folds=1),
        Made("inkscape_clones.svg", head + view + clones + end, slits=5),
        Made("inkscape_groups_in_groups.svg", head + view + folder + end),
        Made("inkscape_old_arc.svg", head + view + rim + arcs + end, AREA - math.pi * 100, slits=0, openings=1),
        Made("inkscape_round_rectangle.svg", head + view + rounded + end, AREA - (4 - math.pi) * 100),
        Made("inkscape_path_effect.svg", head + view + mesh + end, AREA - 400, openings=1),
        Made("inkscape_y_up.svg", head + layer.format("Layer 1", "layer1", "matrix(1,0,0,-1,0,140)", rim + slits) + end),
        Made("inkscape_locked_template.svg", head + layer.format(
            "guides", "layer9", "", f'<rect {style} x="0" y="0" width="210" height="297"/>') + rim + slits + end),
    ]  # fmt: skip


def illustrator() -> list[Made]:
    comment = "<!-- Generator: Adobe Illustrator 27.0.0, SVG Export Plug-In . SVG Version: 6.00 Build 0)  -->"
    w, h = f"{WIDTH * PT:.3f}", f"{HEIGHT * PT:.3f}"
    sheet = ('<style type="text/css">.st0{fill:none;stroke:#231F20;stroke-miterlimit:10;}.st1{fill:none;stroke:#ED1C24;'
             "stroke-width:0.25;stroke-miterlimit:10;}.st2{clip-path:url(#SVGID_2_);}.st3{fill:none;stroke:#0072BC;"
             "stroke-dasharray:4.252,2.8346;}</style>")  # fmt: skip
    head = f'<?xml version="1.0" encoding="utf-8"?>{comment}<svg version="1.1" id="Layer_1" {NS} x="0px" y="0px" width="{w}px" height="{h}px" viewBox="0 0 {w} {h}" style="enable-background:new 0 0 {w} {h};" xml:space="preserve">'
    rim = f'<rect class="st0" width="{w}" height="{h}"/>'
    lines = "".join(f'<line class="st1" x1="{a[0] * PT:.4f}" y1="{a[1] * PT:.4f}" x2="{b[0] * PT:.4f}" y2="{b[1] * PT:.4f}"/>'
                    for a, b in SLITS)  # fmt: skip
    clip = (f'<g><defs><rect id="SVGID_1_" width="{w}" height="{h}"/></defs><clipPath id="SVGID_2_"><use xlink:href="#SVGID_1_" '
            f'style="overflow:visible;"/></clipPath><g class="st2">{lines}<path class="st1" d="{data([(100, 40), (150, 40)], PT)}"/></g></g>')  # fmt: skip
    symbol = (f'<symbol id="slit" viewBox="-2 -2 {30 * PT + 4:.4f} 4"><line class="st1" x1="0" y1="0" x2="{30 * PT:.4f}" y2="0"/></symbol>'
              + "".join(f'<use xlink:href="#slit" width="{30 * PT + 4:.4f}" height="4" x="-2" y="-2" transform="matrix(1 0 0 -1 {x * PT:.4f} {y * PT:.4f})" style="overflow:visible;"/>'
                        for x, y in ((20, 20), (60, 20), (40, 50))))  # fmt: skip
    dash = f'<line class="st3" x1="{100 * PT:.4f}" y1="0" x2="{100 * PT:.4f}" y2="{h}"/>'
    switch = f'<switch><foreignObject requiredExtensions="&amp;ns_ai;" x="0" y="0" width="1" height="1"></foreignObject><g>{rim}{lines}</g></switch>'
    white = f'<g id="Background"><rect style="fill:#FFFFFF;" x="-50" y="-50" width="600" height="400"/></g><g id="Die"><g id="Cut">{rim}{lines}</g></g>'
    return [
        Made("illustrator_lines.svg", head + sheet + rim + lines + "</svg>"),
        Made("illustrator_clipped_artboard.svg", head + sheet + rim + clip + "</svg>", slits=4, told="clip path"),
        Made("illustrator_symbols.svg", head + sheet + rim + symbol + "</svg>", slits=3),
        Made("illustrator_dashed_die.svg", head + sheet + rim + lines + dash + "</svg>", folds=1),
        Made("illustrator_switch.svg", head + sheet + switch + "</svg>"),
        Made("illustrator_white_background.svg", head + sheet + white + "</svg>"),
    ]  # fmt: skip


def other_vector_programs() -> list[Made]:
    w, h = WIDTH * PX, HEIGHT * PX
    corel = (f'<svg {NS} xml:space="preserve" width="120mm" height="80mm" version="1.1" style="shape-rendering:geometricPrecision; text-rendering:geometricPrecision; fill-rule:evenodd" viewBox="0 0 12000 8000">'
             "<defs><style type=\"text/css\"><![CDATA[ .str1 {stroke:#DE2B26;stroke-width:7.62} .str0 {stroke:#2B2A29;stroke-width:7.62} .fil0 {fill:none} ]]></style></defs>"
             '<g id="Layer_x0020_1"><metadata id="CorelCorpID_0Corel-Layer"/><polygon class="fil0 str0" points="0,0 12000,0 12000,8000 0,8000 "/>'
             + "".join(f'<line class="fil0 str1" x1="{a[0] * 100:g}" y1="{a[1] * 100:g}" x2= "{b[0] * 100:g}" y2="{b[1] * 100:g}" />' for a, b in SLITS)
             + "</g></svg>")  # fmt: skip
    affinity = (f'<svg width="120mm" height="80mm" viewBox="0 0 1418 945" version="1.1" {NS} xmlns:serif="http://www.serif.com/" style="fill-rule:evenodd;clip-rule:evenodd;stroke-linecap:round;">'
                f'<g transform="matrix(11.816667,0,0,11.8125,0,0)"><g id="Cut" serif:id="Cut 1"><g transform="matrix(1,0,0,1,-7,-9)">'
                f'<g transform="translate(7,9)">{paths(1, "style=&quot;fill:none;stroke:black;stroke-width:0.1px;&quot;".replace("&quot;", chr(34)), "style=&quot;fill:none;stroke:red;stroke-width:0.1px;&quot;".replace("&quot;", chr(34)))}</g></g></g></g></svg>')
    figma = (f'<svg width="{w:.3f}" height="{h:.3f}" viewBox="0 0 {w:.3f} {h:.3f}" fill="none" xmlns="http://www.w3.org/2000/svg">'
             f'{paths(PX, chr(115) + "troke=" + chr(34) + "black" + chr(34), chr(115) + "troke=" + chr(34) + "#FF0000" + chr(34))}</svg>')
    drawio = (f'<svg {NS} version="1.1" width="{w + 1:.3f}px" height="{h + 1:.3f}px" viewBox="-0.5 -0.5 {w + 1:.3f} {h + 1:.3f}" content="&lt;mxfile&gt;&lt;/mxfile&gt;" style="background-color: rgb(255, 255, 255);"><defs/><g>'
              f'<rect x="0" y="0" width="{w:.4f}" height="{h:.4f}" fill="none" stroke="#000000" pointer-events="all"/>'
              + "".join(f'<path d="{data(s, PX)}" fill="none" stroke="#ff0000" stroke-miterlimit="10" pointer-events="stroke"/>' for s in SLITS)
              + "</g></svg>")  # fmt: skip
    boxes = (f'<svg height="100.00mm" viewBox="0.0 0.0 140.00 100.00" width="140.00mm" {NS}><metadata/><g id="p-0" style="fill:none;stroke-linecap:round;stroke-linejoin:round;">'
             + "".join(f'<path d="M {10 + a[0]:.3f} {10 + a[1]:.3f} H {10 + b[0]:.3f} V {10 + b[1]:.3f}" stroke="rgb(0,0,0)" stroke-width="0.20"/>'
                       for a, b in zip(CORNERS, [*CORNERS[1:], CORNERS[0]]))
             + "".join(f'<path d="M {10 + a[0]:.3f} {10 + a[1]:.3f} L {10 + b[0]:.3f} {10 + b[1]:.3f}" stroke="rgb(0,0,255)" stroke-width="0.20"/>' for a, b in SLITS)
             + '<text x="20" y="8" stroke="rgb(255,0,0)">plate</text></g></svg>')  # fmt: skip
    makerjs = (f'<svg width="120mm" height="80mm" viewBox="0 0 120 80" {NS}><g id="svgGroup" stroke-linecap="round" fill-rule="evenodd" font-size="9pt" stroke="#000" stroke-width="0.25mm" fill="none" style="stroke:#000;stroke-width:0.25mm;fill:none">'
               f'<path d="{data(CORNERS, 1, True)}{"".join(data(s) for s in SLITS)}" vector-effect="non-scaling-stroke"/></g></svg>')
    openscad = ('<?xml version="1.0" standalone="no"?><!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'
                f'<svg width="120mm" height="80mm" viewBox="0 -80 120 80" {NS} version="1.1"><title>OpenSCAD Model</title><path d="\nM 0,-0 L 0,-80 L 120,-80 L 120,-0 z\n'
                + "".join(f"M {x},-60.1 L {x + 20},-60.1 L {x + 20},-59.9 L {x},-59.9 z\n" for x in (10, 50, 90)) + '" stroke="black" fill="lightgray" stroke-width="0.5"/></svg>')
    dvisvgm = (f"<?xml version='1.0' encoding='UTF-8'?><!-- This file was generated by dvisvgm 3.0.3 --><svg version='1.1' {NS} width='{WIDTH * PT + 4:.6f}pt' height='{HEIGHT * PT + 4:.6f}pt' viewBox='-72 -72 {WIDTH * PT + 4:.6f} {HEIGHT * PT + 4:.6f}'>"
               "<g id='page1'><g stroke-miterlimit='10' transform='translate(-70,156.771654)scale(0.996264,-0.996264)' fill='#000' stroke='#000' stroke-width='0.4'>"
               f"<path d='{data(CORNERS, PT / 0.996264, True)}' fill='none'/>" + "".join(f"<g stroke='#f00'><path d='{data(s, PT / 0.996264)}' fill='none'/></g>" for s in SLITS)
               + "</g></g></svg>")  # fmt: skip
    ink = 'style="fill:none;stroke-width:0.3985;stroke-linecap:butt;stroke-linejoin:miter;stroke:rgb({},0%,0%);stroke-opacity:1;stroke-miterlimit:10;" transform="matrix(1,0,0,-1,2,228.771654)"'
    cairo = (f'<svg {NS} width="{WIDTH * PT + 4:.6f}pt" height="{HEIGHT * PT + 4:.6f}pt" viewBox="0 0 {WIDTH * PT + 4:.6f} {HEIGHT * PT + 4:.6f}" version="1.1"><defs><clipPath id="clip-0">'
             '<path clip-rule="nonzero" d="M 0 0 L 344.16 0 L 344.16 230.78 L 0 230.78 Z M 0 0 "/></clipPath></defs><g clip-path="url(#clip-0)">'
             + paths(PT, ink.format("0%"), ink.format("100%")) + "</g></svg>")  # fmt: skip
    lightburn = ('<svg xmlns="http://www.w3.org/2000/svg" width="140mm" height="100mm" viewBox="0 0 140 100" version="1.1">'
                 '<g stroke-width="0.1mm" fill="none" transform="translate(10,90)">'
                 + paths(1, 'stroke="#000000" style="stroke:#000000;stroke-width:0.1mm;fill:none" transform="matrix(1 0 0 -1 0 0)"',
                         'stroke="#0000FF" style="stroke:#0000FF;stroke-width:0.1mm;fill:none" transform="matrix(1 0 0 -1 0 0)"') + "</g></svg>")  # fmt: skip
    silhouette = (f'<svg {NS} width="8.5in" height="11in" viewBox="0 0 612 792"><g transform="translate(40,50)" fill="none" stroke="rgb(255,0,0)" stroke-width="0.1">'
                  f'<path d="{data([*CORNERS, CORNERS[0]], PT)} z"/>' + "".join(f'<path d="{data(s, PT)}"/>' for s in SLITS) + "</g></svg>")
    cricut = (f'<svg {NS} width="{w:.2f}" height="{h:.2f}" viewBox="0 0 {WIDTH * 72 / 25.4:.2f} {HEIGHT * 72 / 25.4:.2f}"><g id="Cut">{paths(PT, "fill=" + chr(34) + "none" + chr(34) + " stroke=" + chr(34) + "#000" + chr(34), "fill=" + chr(34) + "none" + chr(34) + " stroke=" + chr(34) + "#000" + chr(34))}</g>'
              f'<g id="Score"><path fill="none" stroke="#000" d="{data([(100, 0), (100, 80)], PT)}"/></g></svg>')
    onedraw = (f'<svg {NS} width="120mm" height="80mm" viewBox="0 0 120 80"><a xlink:href="https://example.org" target="_blank"><g style="stroke:currentColor;color:#000;fill:none">'
               f'<rect width="100%" height="100%"/>{"".join(f"<path d={chr(34)}{data(s)}{chr(34)}/>" for s in SLITS)}</g></a></svg>')
    return [
        Made("corel_css_in_cdata.svg", corel),
        Made("affinity_matrices.svg", affinity),
        Made("figma_pixels.svg", figma, told="96 pixels to the inch"),
        Made("drawio.svg", drawio, told="96 pixels to the inch"),
        Made("boxes_py.svg", boxes),
        Made("makerjs_one_path.svg", makerjs),
        Made("openscad.svg", openscad, AREA - 3 * 4, slits=0, openings=3),
        Made("tikz_dvisvgm.svg", dvisvgm),
        Made("pdf_to_cairo.svg", cairo),
        Made("lightburn.svg", lightburn),
        Made("silhouette_red_only.svg", silhouette),
        Made("cricut_cut_and_score.svg", cricut, folds=1, told="96 pixels to the inch"),
        Made("links_and_percent.svg", onedraw),
    ]  # fmt: skip


def matplotlib_figures() -> list[Made]:
    """Written by matplotlib itself."""
    from matplotlib.figure import Figure

    def saved(frame: bool, page: bool) -> str:
        figure = Figure(figsize=(140 / 25.4, 100 / 25.4), facecolor="white" if page else "none")
        axes = figure.add_axes((0, 0, 1, 1), frameon=frame)
        axes.set(xlim=(-10, 130), ylim=(-10, 90), xticks=[], yticks=[])
        axes.fill(*zip(*CORNERS), facecolor="none", edgecolor="k") if page else axes.plot(*zip(*CORNERS, CORNERS[0]), "k")
        for slit in SLITS:
            axes.plot(*zip(*slit), "r", lw=0.5)
        text = io.StringIO()
        figure.savefig(text, format="svg")
        return text.getvalue()

    return [Made("matplotlib_lines.svg", saved(False, False)), Made("matplotlib_white_page.svg", saved(False, True)),
            Made("matplotlib_axes_frame.svg", saved(True, True), told="frame of a page")]  # fmt: skip


# ------------------------------------------------------------------------------------------- CAD


def written(build: Callable[[Any, Any], None], version: str = "R2010", unit: int = 4) -> str:
    """A DXF file written by ezdxf."""
    import ezdxf

    document = ezdxf.new(version, setup=True)
    if version != "R12":
        document.header["$INSUNITS"] = unit
    build(document, document.modelspace())
    text = io.StringIO()
    document.write(text)
    return text.getvalue()


def plain(space: Any, layer: str = "0", cuts: str = "0", scale: float = 1.0) -> None:
    space.add_lwpolyline([(x * scale, y * scale) for x, y in CORNERS], close=True, dxfattribs={"layer": layer})
    for a, b in SLITS:
        space.add_line((a[0] * scale, a[1] * scale), (b[0] * scale, b[1] * scale), dxfattribs={"layer": cuts})


def autocad() -> list[Made]:
    def nested(document: Any, space: Any) -> None:
        slit, row = document.blocks.new("SLIT", base_point=(5, 5)), document.blocks.new("ROW")
        slit.add_line((5, 5), (15, 5), dxfattribs={"color": 0})
        for x in (10, 30, 50):
            row.add_blockref("SLIT", (x, 0), dxfattribs={"xscale": 1.5, "color": 0})
        plain(space)
        space.add_blockref("ROW", (5, 10), dxfattribs={"layer": "CUTS", "color": 1})
        space.add_blockref("ROW", (115, 70), dxfattribs={"layer": "CUTS", "xscale": -1, "color": 1})

    def array(document: Any, space: Any) -> None:
        slit = document.blocks.new("SLIT")
        slit.add_line((0, 0), (15, 0))
        space.add_lwpolyline(CORNERS, close=True)
        space.add_blockref("SLIT", (10, 10), dxfattribs={"column_count": 4, "row_count": 5, "column_spacing": 25, "row_spacing": 15})

    def squashed(document: Any, space: Any) -> None:
        hole = document.blocks.new("HOLE")
        hole.add_circle((0, 0), 5)
        hole.add_lwpolyline([(-2, -8, 0, 0, 1), (2, -8, 0, 0, 1)], close=True)
        space.add_lwpolyline(CORNERS, close=True)
        space.add_blockref("HOLE", (40, 40), dxfattribs={"xscale": 2, "yscale": 1, "rotation": 30})

    def drafting(document: Any, space: Any) -> None:
        plain(space)
        space.add_linear_dim(base=(0, -10), p1=(0, 0), p2=(120, 0)).render()
        space.add_mtext("PLATE 1.4301", dxfattribs={"insert": (10, 90)})
        space.add_hatch().paths.add_polyline_path(CORNERS)
        space.add_point((60, 40))
        paper = document.layout("Layout1")
        paper.add_lwpolyline([(0, 0), (297, 0), (297, 210), (0, 210)], close=True)

    def mirrored(document: Any, space: Any) -> None:
        space.add_lwpolyline([(0, 0, 0, 0, 0), (-120, 0, 0, 0, 0), (-120, 80, 0, 0, 0.25), (0, 80, 0, 0, 0)], close=True,
                             dxfattribs={"extrusion": (0, 0, -1), "elevation": 0})  # fmt: skip
        space.add_arc((-60, 40), 10, 0, 180, dxfattribs={"extrusion": (0, 0, -1)})

    def smooth(document: Any, space: Any) -> None:
        space.add_ellipse((60, 40), (60, 0), 2 / 3)
        space.add_spline([(30, 40), (50, 50), (70, 30), (90, 40)])
        space.add_ellipse((60, 40), (0, 20), 0.5, 0, math.pi / 2)

    def types(document: Any, space: Any) -> None:
        plain(space)
        for x, kind in ((40, "DASHED2"), (70, "HIDDEN"), (100, "CENTER")):
            space.add_line((x, 0), (x, 80), dxfattribs={"linetype": kind})

    def true_colors(document: Any, space: Any) -> None:
        plain(space)
        for entity in list(space)[1:]:
            entity.rgb = (255, 0, 0)

    def old(document: Any, space: Any) -> None:
        space.add_polyline2d(CORNERS, close=True, dxfattribs={"layer": "OUTLINE"})
        for a, b in SLITS:
            space.add_line(a, b, dxfattribs={"layer": "CUTS"})

    def off(document: Any, space: Any) -> None:
        plain(space)
        space.add_lwpolyline([(-20, -20), (140, -20), (140, 100), (-20, 100)], close=True, dxfattribs={"layer": "Defpoints"})

    ellipse = math.pi * 60 * 40
    angle = 4 * math.atan(0.25)
    bulge = 0.5 * (60 / math.sin(angle / 2)) ** 2 * (angle - math.sin(angle))  # between an arc and its chord of 120
    return [
        Made("autocad_nested_blocks.dxf", written(nested), slits=9),
        Made("autocad_block_array.dxf", written(array, "R2018"), slits=20),
        Made("autocad_squashed_block.dxf", written(squashed), AREA - 2 * (25 + 4) * math.pi, slits=0, openings=2),
        Made("autocad_drafting.dxf", written(drafting, "R2007"), told="DIMENSION"),
        Made("autocad_mirrored_normals.dxf", written(mirrored, "R2000"), AREA - bulge, slits=1),
        Made("autocad_smooth_curves.dxf", written(smooth), ellipse, slits=2),
        Made("autocad_line_types.dxf", written(types), folds=2),
        Made("autocad_true_colours.dxf", written(true_colors, "R2004")),
        Made("autocad_defpoints.dxf", written(off)),
        Made("autocad_inches.dxf", written(lambda d, s: plain(s, scale=1 / 25.4), unit=1)),
        Made("autocad_r12.dxf", written(old, "R12", 0), options={"drawn_in": "mm"}),
    ]  # fmt: skip


def other_cad() -> list[Made]:
    def rhino(document: Any, space: Any) -> None:
        space.add_polyline3d([(x, y, 0) for x, y in CORNERS], close=True, dxfattribs={"layer": "Default"})
        for a, b in SLITS:
            space.add_spline(dxfattribs={"layer": "Layer 01"}).set_open_uniform([(*a, 0), (*b, 0)], degree=1)

    def fusion(document: Any, space: Any) -> None:
        for a, b in zip(CORNERS, [*CORNERS[1:], CORNERS[0]]):
            space.add_line(a, b, dxfattribs={"layer": "OUTER_PROFILES"})
        space.add_lwpolyline([(40, 30), (80, 30), (80, 50), (40, 50)], close=True, dxfattribs={"layer": "INTERIOR_PROFILES"})
        for x in (98, 100, 102):
            space.add_line((x, 0), (x, 80), dxfattribs={"layer": "BEND" if x == 100 else "BEND_EXTENT"})

    def inventor(document: Any, space: Any) -> None:
        space.add_lwpolyline(CORNERS, close=True, dxfattribs={"layer": "IV_OUTER_PROFILE"})
        space.add_circle((30, 40), 5, dxfattribs={"layer": "IV_INTERIOR_PROFILES"})
        space.add_line((60, 0), (60, 80), dxfattribs={"layer": "IV_BEND"})
        space.add_line((90, 0), (90, 80), dxfattribs={"layer": "IV_BEND_DOWN"})
        for x in (58, 62, 88, 92):
            space.add_line((x, 0), (x, 80), dxfattribs={"layer": "IV_TANGENT"})

    def freecad(document: Any, space: Any) -> None:
        for k in range(4):
            space.add_arc(((10, 10), (110, 10), (110, 70), (10, 70))[k], 10, 180 + 90 * k, 270 + 90 * k)
        for a, b in (((10, 0), (110, 0)), ((120, 10), (120, 70)), ((110, 80), (10, 80)), ((0, 70), (0, 10))):
            space.add_line(a, b)
        for a, b in SLITS:
            space.add_line(a, b)

    noisy = [line((a[0] + 3e-7 * k, a[1] - 2e-7), (b[0], b[1] + 1e-7 * k)) for k, (a, b) in
             enumerate(zip(CORNERS, [*CORNERS[1:], CORNERS[0]]))]  # fmt: skip
    many = [round_point(k) for k in range(100)]
    return [
        Made("rhino_3d_polylines.dxf", written(rhino)),
        Made("fusion_flat_pattern.dxf", written(fusion, "R2000"), AREA - 800, slits=0, folds=1),
        Made("inventor_flat_pattern.dxf", written(inventor), AREA - 25 * math.pi, slits=0, folds=2),
        Made("freecad_sketch.dxf", written(freecad, "R2000"), AREA - (4 - math.pi) * 100),
        Made("onshape_noisy_ends.dxf", dxf([*noisy, *(line(*slit) for slit in SLITS)])),
        Made("openscad.dxf", dxf([*box_lines(many), *(line(*slit) for slit in [[(40, 40), (80, 40)]])], unit=None),
             0.5 * 100 * 38**2 * math.sin(2 * math.pi / 100), slits=1, options={"drawn_in": "mm"}),
        Made("librecad_layers.dxf", written(lambda d, s: (plain(s, "kontur", "schnitt"), s.add_line(
            (100, 0), (100, 80), dxfattribs={"layer": "biegelinie"})), "R2007"), folds=1),
        Made("qcad_spanish.dxf", written(lambda d, s: (plain(s, "contorno", "corte"), s.add_line(
            (100, 0), (100, 80), dxfattribs={"layer": "pliegue"}))), folds=1),
        Made("solidworks_rim_in_pieces.dxf", dxf([*box_lines(CORNERS, "SLD-0"), *(line(*slit, "SLD-0") for slit in SLITS),
                                                  circle((100, 20), 5, "SLD-0")]), AREA - 25 * math.pi, openings=1),
        Made("sketchup_polylines.dxf", dxf([polyline([*CORNERS, CORNERS[0]], False, "Layer0"), *(
            polyline(slit, False, "Layer0") for slit in SLITS)])),
        Made("lasercut_comments.dxf", "999\nLaserCut 5.3\n" + dxf([polyline(CORNERS, True, "Layer_255"), *(
            line(*slit, "Layer_16711680") for slit in SLITS)]).replace("\n", "\r\n")),
    ]  # fmt: skip


def round_point(k: int) -> Point:
    return 60 + 38 * math.cos(2 * math.pi * k / 100), 40 + 38 * math.sin(2 * math.pi * k / 100)


# ------------------------------------------------------------------------------------------- origami and maps


def origami() -> list[Made]:
    vertices = [*CORNERS, (60, 0), (60, 80), (30, 40), (50, 40)]
    edges = [(0, 4), (4, 1), (1, 2), (2, 5), (5, 3), (3, 0), (4, 5), (6, 7), (0, 7), (7, 5)]
    letters = [*"BBBBBB", "V", "C", "F", "F"]
    ear = {"file_spec": 1.1, "file_creator": "Rabbit Ear", "file_classes": ["singleModel"], "frame_classes": ["creasePattern"],
           "frame_attributes": ["2D"], "vertices_coords": vertices, "edges_vertices": edges, "edges_assignment": letters,
           "edges_foldAngle": [0] * 6 + [180, 0, 0, 0]}  # fmt: skip
    up = [(x / 100 - 0.6, 0.0, y / 100 - 0.4) for x, y in [*CORNERS, (60.0, 0.0), (60.0, 80.0)]]
    simulator = {"file_spec": 1.1, "file_creator": "Origami Simulator: http://git.io/origami-simulator", "file_author": "",
                 "frame_title": "", "frame_classes": ["foldedForm"], "frame_attributes": ["3D"], "frame_unit": "unit",
                 "vertices_coords": up, "edges_vertices": [*edges[:7], (0, 5), (4, 2)],
                 "edges_assignment": [*"BBBBBBM", "F", "F"], "edges_foldAngle": [None] * 6 + [-90, 0, 0],
                 "faces_vertices": [[0, 4, 5], [0, 5, 3], [4, 1, 2], [4, 2, 5]]}  # fmt: skip
    oripa = {"file_spec": 1, "file_creator": "oripa", "frame_classes": ["creasePattern"], "frame_title": "",
             "vertices_coords": [[x - 60, y - 40] for x, y in [*CORNERS, (60, 0), (60, 80)]],
             "edges_vertices": edges[:7], "edges_assignment": [*"BBBBBBM"], "faces_vertices": [[0, 4, 5, 3], [4, 1, 2, 5]]}  # fmt: skip
    return [
        Made("rabbit_ear.fold", json.dumps(ear | {"frame_unit": "mm"}), slits=1, folds=1),
        Made("origami_simulator.fold", json.dumps(simulator), AREA * 1e-4, slits=0, folds=1, options={"drawn_in": "mm"}),
        Made("oripa.fold", json.dumps(oripa), slits=0, folds=1, options={"drawn_in": "mm"}),
        Made("origami_simulator.svg", f'<svg {NS} width="120mm" height="80mm" viewBox="0 0 120 80">'
             f'<path fill="none" stroke="#000000" d="{data(CORNERS, 1, True)}"/><path stroke="#ff0000" d="M40 0V80"/>'
             '<path stroke="#0000ff" d="M80 0V80"/><path stroke="#00ff00" d="M50 40H70"/></svg>', slits=1, folds=2,
             options={"cuts": "green", "folds": ["red", "blue"]}),
    ]  # fmt: skip


def maps() -> list[Made]:
    far = [(x + 691_000, y + 5_334_000) for x, y in [*CORNERS, CORNERS[0]]]
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}

    def feature(kind: str, at: Any, **properties: Any) -> dict[str, Any]:
        return {"type": "Feature", "properties": {"fid": 1, **properties}, "geometry": {"type": kind, "coordinates": at}}

    slits = [[(x + 691_000, y + 5_334_000) for x, y in slit] for slit in SLITS]
    qgis = {"type": "FeatureCollection", "name": "plate", "crs": crs, "unit": "mm", "features": [
        feature("MultiPolygon", [[far]], layer="outline"), feature("MultiLineString", slits, layer="cuts")]}  # fmt: skip
    bare = {"type": "FeatureCollection", "unit": "mm", "features": [
        feature("Polygon", [[(*p, 0.0) for p in [*CORNERS, CORNERS[0]]]]), *(feature("LineString", s) for s in SLITS)]}  # fmt: skip
    styled = {"type": "FeatureCollection", "unit": "mm", "features": [
        feature("LineString", [*CORNERS, CORNERS[0]], stroke="#000000"), *(feature("LineString", s, stroke="#ff0000") for s in SLITS)]}  # fmt: skip
    return [
        Made("qgis_projected.geojson", json.dumps(qgis)),
        Made("qgis_with_heights.geojson", json.dumps(bare)),
        Made("geojson_io_styles.geojson", json.dumps(styled)),
    ]  # fmt: skip


def every() -> list[Made]:
    """All drawings that this machine can write."""
    makers = [inkscape, illustrator, other_vector_programs, matplotlib_figures, autocad, other_cad, origami, maps]
    made: list[Made] = []
    for maker in makers:
        try:
            made += maker()
        except ModuleNotFoundError:  # ezdxf is an extra
            continue
    return made


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for one in every():
        (folder / one.name).write_bytes(one.text.encode())
