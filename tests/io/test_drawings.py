"""Drawings in every dialect mean the same sheet; what is written is read back; what is broken is named."""

from __future__ import annotations

import json
import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.drawing.drawing import Drawing
from kirigami.drawing.fold import read_fold, write_fold
from kirigami.drawing.geojson import read_geojson, write_geojson

DRAWINGS = Path(__file__).parents[1] / "data" / "drawings"
SAID = {  # what the files do not say themselves
    "r12_entities_only.dxf": {"drawn_in": "mm"},
    "r12_polylines_crlf.dxf": {"drawn_in": "mm"},
    "r2000_one_layer_cm.dxf": {"folds": "blue"},
    "illustrator_classes_pt.svg": {"folds": "#0000FF"},
}


def read(path: Path, **options: Any) -> Drawing:
    if path.suffix == ".dxf":
        pytest.importorskip("ezdxf")
        from kirigami.drawing.dxf import read_dxf

        return read_dxf(path, **options)
    if path.suffix == ".svg":
        pytest.importorskip("svgelements")
        from kirigami.drawing.svg import read_svg

        return read_svg(path, **options)
    return (read_fold if path.suffix == ".fold" else read_geojson)(path, **options)


def write(item: Any, path: Path, **options: Any) -> Path:
    if path.suffix == ".dxf":
        pytest.importorskip("ezdxf")
        from kirigami.drawing.dxf import write_dxf

        return write_dxf(item, path, **options)
    if path.suffix == ".svg":
        from kirigami.drawing.svg import write_svg

        return write_svg(item, path, **options)
    return (write_fold if path.suffix == ".fold" else write_geojson)(item, path, **options)


# ------------------------------------------------------------------------------------------- dialects


@pytest.mark.filterwarnings("ignore::kirigami.errors.KirigamiWarning")
@pytest.mark.parametrize("name", sorted(file.name for file in DRAWINGS.glob("*.*") if file.suffix != ".md"))
def test_every_dialect_shows_the_same_sheet(name: str) -> None:
    """The sheet of the folder's README, in metres; files hold six decimals at least, so 1e-8 m."""
    drawing = read(DRAWINGS / name, **SAID.get(name, {}))
    assert drawing.unit == "m"
    assert drawing.outline.bounds == pytest.approx((0, 0, 0.12, 0.08), abs=1e-8)
    assert drawing.outline.area == pytest.approx(0.12 * 0.08, rel=1e-7)
    slits = sorted((cut for cut in drawing.cuts if cut.geom_type == "LineString"), key=lambda cut: cut.length)
    (hole,) = (cut for cut in drawing.cuts if cut.geom_type == "Polygon")
    edge, arc, inner = slits
    assert shapely.bounds(edge).tolist() == pytest.approx([0, 0.06, 0.03, 0.06], abs=1e-8)
    assert shapely.bounds(inner).tolist() == pytest.approx([0.02, 0.04, 0.06, 0.04], abs=1e-8)
    ends = sorted(shapely.get_coordinates(arc)[[0, -1]].tolist())
    half = 0.015 * math.cos(math.pi / 6)
    assert np.ravel(ends) == pytest.approx([0.09 - half, 0.0475, 0.09 + half, 0.0475], abs=1e-8)
    # Points lie on the arc, chords at most the flatness of 2e-4 of 0.12 m inside it; the FOLD file has 40 on the hole.
    radius = np.linalg.norm(shapely.get_coordinates(arc) - [0.09, 0.04], axis=1)
    assert radius == pytest.approx(np.full(len(radius), 0.015), abs=1e-8)
    assert 0.015 - shapely.distance(arc, shapely.Point(0.09, 0.04)) <= 2.5e-5
    assert shapely.get_coordinates(hole.centroid)[0] == pytest.approx([0.1, 0.02], abs=1e-7)
    assert hole.area == pytest.approx(math.pi * 0.005**2, rel=0.01)
    (fold,) = drawing.folds
    assert shapely.bounds(fold).tolist() == pytest.approx([0.07, 0, 0.07, 0.08], abs=1e-8)


def test_flatness_sets_how_near_chords_are() -> None:
    for name in ("r12_polylines_crlf.dxf", "r2018_blocks_mm.dxf", "inkscape_layers_mm.svg"):
        for flatness in (1e-3, 1e-5):
            drawing = read(DRAWINGS / name, flatness=flatness, **SAID.get(name, {}))
            (hole,) = (cut for cut in drawing.cuts if cut.geom_type == "Polygon")
            depth = 0.005 - shapely.distance(hole.exterior, shapely.Point(0.1, 0.02))
            assert 0.02 * flatness * 0.12 < depth <= 1.2 * flatness * 0.16  # dimensions make one drawing 0.16 m wide


def test_the_report_says_what_was_read_and_assumed() -> None:
    drawing = read(DRAWINGS / "r12_entities_only.dxf", drawn_in="mm")
    assert "DXF R12" in drawing.report and "1 TEXT" in drawing.report
    assert "2 gaps between ends closed, the widest 2.24e-06" in drawing.report
    with pytest.warns(kg.KirigamiWarning, match="entity 34 .LINE. on entity 33"):
        drawing = read(DRAWINGS / "r2000_one_layer_cm.dxf", folds="blue")
    assert "drawn in cm, converted to m" in drawing.report
    with pytest.warns(kg.KirigamiWarning, match="names no unit"):
        assert read(DRAWINGS / "r12_entities_only.dxf").outline.bounds == (0, 0, 120, 80)


def test_roles_can_be_told_by_layer_and_by_colour() -> None:
    drawing = read(DRAWINGS / "r2018_blocks_mm.dxf", cuts=["Bend lines", "Laser Cut"], folds=[])
    assert len(drawing.cuts) == 5 and not drawing.folds
    drawing = read(DRAWINGS / "r2018_blocks_mm.dxf", ignore="laser cut")
    assert not drawing.cuts and len(drawing.folds) == 1
    with pytest.raises(kg.GeometryError, match="colour 'purple'; there are layer 'Laser Cut' .4., .* colour 'red'"):
        read(DRAWINGS / "r2018_blocks_mm.dxf", cuts="purple")


# ------------------------------------------------------------------------------------------- round trips


def sheet_to_write() -> Drawing:
    """Coordinates that are no round numbers, off the origin, with holes, crossing cuts and folds."""
    turn = np.linspace(0.1, 2.0, 7)
    outline = shapely.Polygon(
        [(-0.1, 0.2), (1 / 3, 0.15), (0.7, 0.2), (math.pi / 4, 0.9), (-0.1, 0.8)],
        [[(0.5, 0.7), (0.6, 0.7), (0.6, 0.75), (0.5, 0.75)]],
    )
    cuts = (
        shapely.LineString(np.column_stack([0.2 + 0.1 * np.cos(turn), 0.4 + 0.1 * np.sin(turn)])),
        shapely.LineString([(0.4, 0.3), (0.6, 0.5)]),
        shapely.LineString([(0.4, 0.5), (0.6, 0.3)]),
        shapely.Polygon([(0.1, 0.7), (0.2, 0.65), (0.25, 0.75)]),
    )
    return Drawing(outline, cuts, (shapely.LineString([(0.0, 0.6), (0.5, 0.62)]),), "m")


@pytest.mark.parametrize("ending", [".dxf", ".svg", ".geojson", ".fold"])
def test_round_trip(ending: str, tmp_path: Path) -> None:
    before = sheet_to_write()
    after = read(write(before, tmp_path / f"sheet{ending}"))
    assert list(tmp_path.iterdir()) == [tmp_path / f"sheet{ending}"]
    near = 1e-9 * 0.9
    assert shapely.hausdorff_distance(after.outline, before.outline) < near
    assert after.outline.symmetric_difference(before.outline).area < near
    for found, wanted in ((after.cuts, before.cuts), (after.folds, before.folds)):
        assert shapely.hausdorff_distance(*map(shapely.GeometryCollection, (found, wanted))) < near
        assert sum(part.length for part in found) == pytest.approx(sum(part.length for part in wanted), rel=1e-9)
    if ending != ".fold":  # there, cuts that cross are four pieces
        assert [cut.geom_type for cut in after.cuts] == [cut.geom_type for cut in before.cuts]


@pytest.mark.parametrize("ending", [".dxf", ".svg"])
def test_files_for_the_laser_cutter_have_true_units(ending: str, tmp_path: Path) -> None:
    path = write(sheet_to_write(), tmp_path / f"sheet{ending}")
    if ending == ".svg":
        assert 'width="885.3981633974' in path.read_text() and 'mm" height="750.0' in path.read_text()
        assert all(f'inkscape:label="{layer}"' in path.read_text() for layer in ("OUTLINE", "CUTS", "FOLDS"))
    else:
        document = pytest.importorskip("ezdxf").readfile(path)
        assert document.units == 4
        assert {entity.dxf.layer for entity in document.modelspace()} == {"OUTLINE", "CUTS", "FOLDS"}
        assert not document.audit().errors
        assert max(point[0] for point in document.modelspace()[0]) == pytest.approx(1000 * math.pi / 4)


def test_fold_of_a_mesh_carries_fold_angles(tmp_path: Path) -> None:
    """A square folded by 90 degrees along its diagonal into a valley; a FOLD file gives degrees."""
    fold = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0.5, 0.5, math.sqrt(0.5)]])  # node 3 lifted by 90 degrees
    mesh = kg.TriMesh(fold, [(0, 1, 2), (0, 2, 3)])
    data = json.loads(write_fold(mesh, tmp_path / "square.fold").read_text())
    inner = data["edges_vertices"].index([0, 2])
    assert data["edges_assignment"][inner] == "V" and data["edges_foldAngle"][inner] == pytest.approx(90)
    assert data["faces_vertices"] == mesh.triangles.tolist() and data["frame_classes"] == ["foldedForm"]
    with pytest.raises(kg.GeometryError, match="folded form"):
        read_fold(tmp_path / "square.fold")


def test_fold_angles_of_results_are_those_of_the_hinges(strip: kg.Results, tmp_path: Path) -> None:
    file = write_fold(strip.mesh, tmp_path / "strip.fold", positions=strip.position()[-1])
    data = json.loads(file.read_text())
    angles = np.radians([value for value in data["edges_foldAngle"] if value is not None])
    assert angles == pytest.approx(strip.hinge_angle[-1], abs=1e-12)


# ------------------------------------------------------------------------------------------- bad input


def dxf(*entities: str) -> str:
    """A drawing of lines "LAYER x0 y0 x1 y1"; handles count from A0."""
    rows = ["0", "SECTION", "2", "ENTITIES"]
    for number, (layer, *at) in enumerate(entity.split() for entity in entities):
        rows += ["0", "LINE", "5", f"{0xA0 + number:X}", "8", layer]
        values = [*at[:2], "0.0", *at[2:], "0.0"]
        rows += [text for pair in zip(("10", "20", "30", "11", "21", "31"), values) for text in pair]
    return "\n".join([*rows, "0", "ENDSEC", "0", "EOF", ""])


def svg(body: str) -> str:
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9">\n{body}\n</svg>'


SQUARE = ("OUTLINE 0 0 9 0", "OUTLINE 9 0 9 9", "OUTLINE 9 9 0 9", "OUTLINE 0 9 0 0")
BAD = {
    "absent.dxf": (None, "there is no file"),
    "absent.svg": (None, "there is no file"),
    "empty.dxf": ("", "is empty"),
    "empty.svg": (" \n", "is empty"),
    "empty.geojson": ("", "is empty"),
    "empty.fold": ("", "is empty"),
    "noise.dxf": ("these are not group codes", "is no DXF file"),
    "noise.svg": ("just words", "is no SVG file"),
    "page.svg": ("<html></html>", "first element is <html>"),
    "noise.geojson": ('{"type": "Feature",\n "geometry": oops}', "no GeoJSON file: .* line 2"),
    "no_features.geojson": ('{"a": 1}', "no features"),
    "no_edges.fold": ('{"file_spec": 1}', "no vertices_coords"),
    "far_vertex.fold": ('{"vertices_coords": [[0, 0], [1, 0]], "edges_vertices": [[0, 7]]}', "edge 0 names a vertex"),
    "cut_off.svg": (svg('<path d="M0 0h1"/>')[:-9], "broken SVG file: .*line 2"),
    "mismatch.svg": (svg("<g>\n<path></g>"), "broken SVG file: mismatched tag: line 3"),
    "no_curves.dxf": (dxf().replace("ENTITIES", "ENTITIES\n0\nPOINT\n8\n0\n10\n1.0\n20\n1.0"), "it holds 1 POINT"),
    "no_curves.svg": (svg("<text>hello</text>"), "it holds 1 text"),
    "open.dxf": (
        dxf(*SQUARE[:3], "OUTLINE 0 8.9 0 0"),
        r"outline is open: from entity A0 .*\(0, 8.9\) and \(0, 9\), a gap of 0.1",
    ),
    "open.svg": (svg('\n<path id="outline" d="M0 0h9v9h-8"/>'), r"outline is open: from line 3 <path> 'outline'"),
    "two.svg": (
        svg('<rect id="outline1" width="3" height="3"/><rect id="outline2" x="5" width="3" height="3"/>'),
        "2 outlines side by side",
    ),
    "bow.svg": (svg('<path id="outline" d="M0 0L9 9H0L9 0z"/>'), "crosses itself.*0.0045 0.0045"),
    "unknown_unit.svg": (svg('<path id="outline" d="M0 0h9v9h-9z"/>').replace("9mm", "9furlong"), None),
    "solid.dxf": (
        dxf(*SQUARE, "CUTS 1 1 2 2").replace("31\n0.0\n0\nENDSEC", "31\n5.0\n0\nENDSEC"),
        "entity A4 .LINE. on layer 'CUTS' leaves the plane: z runs from 0 to 5",
    ),
    "no_outline.dxf": (dxf("CUTS 1 1 2 2", "CUTS 3 1 4 2"), "no outline; the outline is open: from entity A0"),
    "nan.geojson": (
        '{"type": "LineString", "coordinates": [[0, 0], [NaN, 1]]}', "feature 0 has a coordinate that is not finite"
    ),
    "far_unit.geojson": (
        '{"type": "Polygon", "unit": "parsec", "coordinates": [[[0, 0], [1, 0], [0, 1], [0, 0]]]}',
        "a unit that is not known, 'parsec': say `drawn_in='mm'`",
    ),
    "no_numbers.geojson": (
        '{"type": "LineString", "coordinates": [[0, 0], [null, 1]]}',
        "feature 0: no geometry that can be used; its type and coordinates are not as GeoJSON",
    ),
    "point.geojson": ('{"type": "Point", "coordinates": [0, 0]}', "feature 0: a Point is neither"),
    "shape.geojson": (
        '{"type": "FeatureCollection", "features": [{"geometry": {"type": "LineString"}}]}', "feature 0: no geometry"
    ),
    "dot.svg": (svg('<path d="M1 1h0"/>'), "no curves"),
    "endless_symbol.svg": (
        svg('<symbol id="s" viewBox="0 0 1 1"><use href="#s"/><use href="#s"/></symbol><use href="#s"/>'), "one another"
    ),
}


@pytest.mark.filterwarnings("ignore::kirigami.errors.KirigamiWarning")
@pytest.mark.parametrize("name", [name for name, (_, message) in BAD.items() if message])
def test_bad_drawings_are_refused_by_name(name: str, tmp_path: Path) -> None:
    text, message = BAD[name]
    path = tmp_path / name
    if text is not None:
        path.write_text(text)
    with pytest.raises(kg.GeometryError, match=message):
        read(path)


def test_binary_noise_and_files_cut_off_are_refused(tmp_path: Path) -> None:
    """Every beginning of a good file is read or refused with a typed error."""
    noise = np.random.default_rng(0).bytes(5000)
    for ending in (".dxf", ".svg", ".geojson", ".fold"):
        path = tmp_path / f"noise{ending}"
        path.write_bytes(noise)
        with pytest.raises(kg.GeometryError):
            read(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name in ("r2018_blocks_mm.dxf", "r12_polylines_crlf.dxf", "inkscape_layers_mm.svg", "features_mm.geojson"):
            whole = (DRAWINGS / name).read_bytes()
            refused = 0
            for share in np.linspace(0.05, 0.95, 12):
                path = tmp_path / name
                path.write_bytes(whole[: int(share * len(whole))])
                try:
                    read(path)
                except kg.GeometryError:
                    refused += 1
            assert refused >= 6


def test_unknown_units_are_named(tmp_path: Path) -> None:
    path = tmp_path / "plate.svg"
    path.write_text(BAD["unknown_unit.svg"][0])
    with pytest.warns(kg.KirigamiWarning, match="no size in a unit of length"):
        read(path)
    with pytest.raises(kg.ModelError, match="unit of length must be one of 'm', .* got 'furlong'"):
        read(path, drawn_in="furlong")
    drawing = read(path, drawn_in="mm", unit="mm")
    assert drawing.outline.bounds == (0, 0, 9, 9)


def test_near_duplicates_are_dropped_and_near_ends_joined(tmp_path: Path) -> None:
    path = tmp_path / "plate.dxf"
    lines = ["CUTS 1 5 4 5", "CUTS 4 5.00001 1 5.00001", "CUTS 1 7 4 7", "CUTS 4.0001 7 6 7"]
    lines += ["CUTS 1 8 4 8", "CUTS 1 8.1 4 8.1"]
    path.write_text(dxf(*SQUARE, *lines))
    with pytest.warns(kg.KirigamiWarning, match="1 curve drawn twice, dropped: entity A5 .LINE. on entity A4"):
        drawing = read(path, drawn_in="m")
    assert [round(cut.length, 6) for cut in drawing.cuts] == [3, 5, 3, 3]
    assert "1 gap between ends closed, the widest 0.0001" in drawing.report


def test_four_lines_that_close_are_a_hole_and_branches_stay_slits(tmp_path: Path) -> None:
    path = tmp_path / "plate.dxf"
    square = ["CUTS 1 1 2 1", "CUTS 2 2 2 1", "CUTS 2 2 1 2", "CUTS 1 1 1 2"]
    path.write_text(dxf(*SQUARE, *square, "CUTS 5 5 6 5", "CUTS 6 5 7 4", "CUTS 6 5 7 6"))
    drawing = read(path, drawn_in="m")
    assert [cut.geom_type for cut in drawing.cuts] == ["Polygon"] + 3 * ["LineString"]
    assert drawing.cuts[0].area == 1


def test_a_large_drawing_is_read(tmp_path: Path) -> None:
    """20,000 cuts; the time grows about linearly, and the order of the drawing is kept."""
    side = 100
    lines = [f"CUTS {x + 0.1} {y / 2 + 0.1} {x + 0.9} {y / 2 + 0.1}" for y in range(2 * side) for x in range(side)]
    outline = [f"OUTLINE 0 0 {side} 0", f"OUTLINE {side} 0 {side} {side}", f"OUTLINE {side} {side} 0 {side}"]
    path = tmp_path / "large.dxf"
    path.write_text(dxf(*outline, f"OUTLINE 0 {side} 0 0", *lines))
    drawing = read(path, drawn_in="mm", unit="mm", tolerance=1e-5)
    assert len(drawing.cuts) == 2 * side * side
    assert shapely.get_coordinates(drawing.cuts[side])[0] == pytest.approx([0.1, 0.6])


def test_no_partial_file_when_writing_fails(tmp_path: Path) -> None:
    class Broken:
        outline = sheet_to_write().outline
        cuts = ("no geometry",)

    for ending in (".dxf", ".svg", ".geojson", ".fold"):
        with pytest.raises(Exception):  # noqa: B017
            write(Broken(), tmp_path / f"sheet{ending}")
    with pytest.raises(kg.GeometryError, match="drawn_in must be one of .*, got 'furlong'"):
        write(sheet_to_write(), tmp_path / "sheet.svg", drawn_in="furlong")
    assert not list(tmp_path.iterdir())


def test_a_drawing_is_drawn_with_one_artist_a_role(tmp_path: Path) -> None:
    """An artist for each line would take a minute for a drawing of 100,000 lines."""
    from kirigami.plot.drawing_picture import plot_drawing

    slits = [shapely.LineString([(0.1, y), (0.9, y)]) for y in np.linspace(0.1, 0.9, 7)]
    hole = shapely.box(0.45, 0.91, 0.55, 0.95)
    ax = plot_drawing(Drawing(shapely.box(0, 0, 1, 1), (*slits, hole), unit="mm"))
    named = {line.get_label(): line for line in ax.lines if not line.get_label().startswith("_")}
    assert set(named) == {"outline", "slit (7)", "opening (1)"} and len(ax.lines) == 3
    points = named["slit (7)"].get_xydata()
    gaps = np.isnan(points[:, 0])
    assert gaps.sum() == 6 and points[~gaps] == pytest.approx(shapely.get_coordinates(slits))


def test_a_drawing_in_metres_is_drawn_in_what_suits_its_size() -> None:
    """As all other pictures are; a sheet of 100 mm had an axis of hundredths of a metre."""
    from kirigami.plot.drawing_picture import plot_drawing

    ax = plot_drawing(Drawing(shapely.box(0, 0, 0.1, 0.06), (), unit="m"))
    ax.figure.canvas.draw()
    assert ax.get_xlabel() == "x [mm]" and "100" in [tick.get_text() for tick in ax.get_xticklabels()]


def test_a_part_that_is_not_there_is_refused(tmp_path: Path) -> None:
    """It used to be taken for the first one, in silence, where there is only one."""
    file = tmp_path / "plate.geojson"
    write_geojson(kg.Sheet(shapely.box(0, 0, 0.2, 0.1)), file)
    assert read_geojson(file, part=1).outline.area == pytest.approx(0.02)
    with pytest.raises(kg.GeometryError, match="there is no part 2: the drawing is of one sheet that no cut severs"):
        read_geojson(file, part=2)
    severed = kg.Sheet(shapely.box(0, 0, 0.2, 0.1), shapely.LineString([(0.05, 0), (0.05, 0.1)]))
    write_geojson(severed, file)
    assert [read_geojson(file, part=part).outline.area for part in (1, 2)] == pytest.approx([0.015, 0.005])
    with pytest.raises(kg.GeometryError, match="there is no part 3: part 1: .* part 2: "):
        read_geojson(file, part=3)


def test_a_feature_without_a_place_is_left_out_and_told(tmp_path: Path) -> None:
    file = tmp_path / "plate.geojson"
    write_geojson(kg.Sheet(shapely.box(0, 0, 0.2, 0.1)), file)
    data = json.loads(file.read_text())
    data["features"].append({"type": "Feature", "properties": {}, "geometry": None})
    file.write_text(json.dumps(data))
    drawing = read_geojson(file)
    assert drawing.outline.area == pytest.approx(0.02)
    assert "feature 1 has no geometry, and is left out" in drawing.notes
