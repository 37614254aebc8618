"""Drawings as people make them: the sheet that is meant is read, repairs are told, what cannot be read is named."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import made_drawings
import pytest
import shapely

import kirigami as kg
from kirigami import cli
from kirigami.drawing.convert import read_drawing

REPAIRED = Path(__file__).parents[1] / "data" / "drawings" / "repaired"


def need(name: str) -> None:
    """Skip where the library for a format is missing."""
    if name.endswith(".dxf"):
        pytest.importorskip("ezdxf")
    if name.endswith(".svg"):
        pytest.importorskip("svgelements")


@pytest.mark.parametrize("made", made_drawings.every(), ids=lambda made: made.name)
def test_drawings_in_the_manner_of_many_programs(made: Any, tmp_path: Path) -> None:
    """Outline, area, number of slits, openings and folds; what was repaired is told; the sheet meshes in one part."""
    need(made.name)
    path = tmp_path / made.name
    path.write_text(made.text)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        drawing = read_drawing(path, unit="mm", **made.options)
        sheet = drawing.sheet()
        mesh = sheet.mesh(sheet.area**0.5 / 8)
    openings = sum(cut.geom_type == "Polygon" for cut in drawing.cuts)
    assert (len(drawing.cuts) - openings, openings, len(drawing.folds)) == (made.slits, made.openings, made.folds)
    assert sheet.area == pytest.approx(made.area, rel=2e-3)  # curves are chords: a circle loses a thousandth
    assert mesh.facet_areas.sum() == pytest.approx(sheet.area, rel=2e-4)
    assert mesh.facet_parts.max() == 0
    assert made.told in drawing.report


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
@pytest.mark.parametrize("made", [m for m in made_drawings.every() if "spokes" in m.name or "slits_on" in m.name],
                         ids=lambda made: made.name)  # fmt: skip
def test_slits_that_end_on_a_curve_open_there(made: Any, tmp_path: Path) -> None:
    """No bridge is left between a slit and the chords of the curve that it ends on: they are one boundary."""
    need(made.name)
    path = tmp_path / made.name
    path.write_text(made.text)
    drawing = read_drawing(path, unit="mm")
    mesh = drawing.sheet().mesh(5.0)
    holes = sum(cut.geom_type == "Polygon" for cut in drawing.cuts)
    assert len(mesh.boundary_loops) == 1 + holes


WANTED = {  # width, height [mm], slits, closed cuts, words that must be told; a single text is an error
    "k01a_slit_from_slanted_rim.geojson": (10, 12, 1, 0, ""),
    "k01c_turned_rectangle.geojson": (10.19615, 11.66025, 1, 0, ""),
    "k02a_rim_broken_at_slits.dxf": (80, 40, 2, 0, "outer face"),
    "k02c_lines_overshoot_corners.svg": (80, 40, 1, 0, "8 tails of the outline beyond its corners left out"),
    "k02d_outline_lines_with_creases_to_corners.svg": "`cuts=red` `folds=blue`",
    "k03a_edge_slot_open.dxf": (80, 40, 0, 0, "1 piece that cuts sever falls out: 40 mm2 at x 10 to 30, y 29 to 31 mm"),
    "k04a_artboard_without_paint.svg": (80, 40, 1, 0, "1 neither painted nor visible"),
    "k04c_opacity_zero.svg": (80, 40, 1, 0, "1 neither painted nor visible"),
    "k04d_layer_off.dxf": (80, 40, 1, 0, "1 on layer 'OLD', off"),
    "k05a_register_mark.svg": (80, 40, 1, 0, "2 curves lie outside the sheet, left out: line 2 <path> (black) at x 2"),
    "k05c_stray_loop_at_corner.dxf": (80, 40, 1, 0, "1 curve lies outside the sheet"),
    "k06a_no_assignment_but_U.fold": (4, 4, 0, 0, "the outer face of the folds is the outline"),
    "k07a_flat_in_the_xz_plane.fold": (4, 4, 0, 0, ""),
    "k07c_flat_folded_state.fold": "frame_classes say, that lies on itself",
    "k09a_etch_and_engraving.dxf": (80, 40, 1, 0, "ETCH       blue    -          1       left out"),
    "k10a_crease_colours.svg": "nothing says which are cut and which are folded: blue .1., green .1.; name them",
    "k11a_two_small_gaps.dxf": r"\(90, 10\) and \(90, 10.02\), a gap of 0.02 mm, and at \(10, 50\) and "
                               r"\(10, 50.02\), a gap of 0.02 mm; .* `tolerance=3e-4`",
    "k12a_side_drawn_again.dxf": (80, 40, 1, 0, "1 cut drawn along the rim again, left out"),
    "k13a_header_says_metres.dxf": (80e3, 40e3, 1, 0, "the sheet measures 80 m: is the unit of the drawing right?"),
    "k14a_round_notch_over_rim.svg": (80, 40, 0, 1, "1 closed cut over the rim"),
    "k15_clip_path.svg": (80, 40, 1, 0, "cut off at a clip path"),
    "overcut.svg": (100, 60, 1, 0, "drawn beyond the rim and trimmed"),
    "spiral.svg": (90, 90, 1, 0, ""),
    "bad_open.svg": r"\(0, 59.6\) and \(0, 60\), a gap of 0.4 mm; .* `tolerance=0.5mm` closes it",
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
@pytest.mark.parametrize("name", WANTED)
def test_faults_of_public_drawings(name: str) -> None:
    need(name)
    wanted = WANTED[name]
    if isinstance(wanted, str):
        with pytest.raises(kg.GeometryError, match=wanted):
            read_drawing(REPAIRED / name)
        return
    drawing = read_drawing(REPAIRED / name, unit="mm")
    width, height, slits, closed, told = wanted
    xmin, ymin, xmax, ymax = drawing.outline.bounds
    assert (xmax - xmin, ymax - ymin) == pytest.approx((width, height), rel=1e-6)
    openings = sum(cut.geom_type == "Polygon" for cut in drawing.cuts)
    assert (len(drawing.cuts) - openings, openings) == (slits, closed)
    assert told in drawing.report
    assert drawing.sheet().mesh(width / 20).facet_parts.max() == 0


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
def test_options_that_errors_name_help() -> None:
    """Each hint was tried: the option it names reads the drawing."""
    need("x.dxf")
    need("x.svg")
    assert read_drawing(REPAIRED / "bad_open.svg", tolerance="0.5mm").outline.area == pytest.approx(0.006)
    closed = read_drawing(REPAIRED / "k11a_two_small_gaps.dxf", tolerance=3e-4)
    assert closed.outline.area == pytest.approx(0.0032, rel=1e-3)
    told = read_drawing(REPAIRED / "k02d_outline_lines_with_creases_to_corners.svg", folds=["red", "blue"])
    assert len(told.folds) == 2 and not told.cuts
    assert len(read_drawing(REPAIRED / "k10a_crease_colours.svg", cuts="green", folds="blue").folds) == 1
    assert read_drawing(REPAIRED / "k13a_header_says_metres.dxf", drawn_in="mm").outline.area == pytest.approx(0.0032)
    shown = read_drawing(REPAIRED / "k04d_layer_off.dxf", outline="OLD", unit="mm")
    assert shown.outline.area == pytest.approx(6000)  # a hidden layer that is named is read
    assert len(read_drawing(REPAIRED / "k08a_block_on_layer.dxf", cuts="CUTS").cuts) == 1
    notch = read_drawing(REPAIRED / "k01d_notch_polygon_on_slanted_rim.svg", outline="black")
    assert notch.sheet().mesh(0.005).facet_parts.max() == 0


def test_no_curve_can_be_the_outline() -> None:
    need("x.svg")
    with pytest.raises(kg.GeometryError, match="no curve can be the outline"):
        read_drawing(REPAIRED / "k06c_all_colours_given_as_folds.svg", folds="red")


def test_hints_speak_the_language_of_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    need("x.dxf")
    need("x.svg")
    for name, words in (
        ("k11a_two_small_gaps.dxf", "--tolerance 3e-4 or --tolerance 0.024mm closes it"),
        ("k02d_outline_lines_with_creases_to_corners.svg", "--cuts red --folds blue"),
    ):
        assert cli.main(["info", str(REPAIRED / name)]) == 1
        said = capsys.readouterr().err
        assert words in said and "`" not in said
    assert cli.main(["info", "--no-picture", str(REPAIRED / "k13a_header_says_metres.dxf")]) == 0
    said = capsys.readouterr()
    assert "--drawn-in mm" in said.err and "--drawn-in mm" in said.out


@pytest.mark.parametrize("tolerance", [-1, 0, 1, 2.0, float("nan"), float("inf"), "-1mm", "wide", "1kg", "10m"])
def test_tolerances_that_are_none(tolerance: Any, tmp_path: Path) -> None:
    path = REPAIRED / "k01a_slit_from_slanted_rim.geojson"
    with pytest.raises(kg.GeometryError, match="tolerance must be (a share|finite)"):
        read_drawing(path, tolerance=tolerance)


def test_parts_are_picked_by_number(tmp_path: Path) -> None:
    """Two sheets side by side, the larger first; a sheet that a slit severs, likewise."""
    two = shapely.MultiPolygon([shapely.box(0, 0, 3, 2), shapely.box(4, 0, 5, 2)])
    severed = [shapely.box(0, 0, 3, 2), shapely.LineString([(1, 0), (1, 2)])]
    for shapes in (list(two.geoms), severed):
        path = tmp_path / "parts.geojson"
        geometries = [json.loads(shapely.to_geojson(shape)) for shape in shapes]
        path.write_text(json.dumps({"type": "GeometryCollection", "unit": "m", "geometries": geometries}))
        areas = [read_drawing(path, part=part).outline.area for part in (1, 2)]
        assert areas == pytest.approx([6, 2] if shapes is not severed else [4, 2])
        with pytest.raises(kg.GeometryError, match="there is no part 3: part 1: x"):
            read_drawing(path, part=3)
