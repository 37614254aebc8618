"""From a drawing to a report, and between kinds of files; quantities with units."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami import units
from kirigami.drawing.convert import read_drawing, write_drawing
from kirigami.drawing.drawing import Drawing
from kirigami.io.convert import export, info, mesh_drawing, write_mesh
from kirigami.study.report import write_report
from kirigami.study.run_job import stretch_drawing

DRAWINGS = Path(__file__).parents[1] / "data" / "drawings"

# ------------------------------------------------------------------------------------------- units


@pytest.mark.parametrize(
    "text, kind, value",
    [
        ("0.1mm", "length", 1e-4), ("0.1 mm", "length", 1e-4), ("2in", "length", 0.0508), ("3", "length", 3.0),
        (0.25, "length", 0.25), ("50um", "length", 5e-5), ("1e-3 m", "length", 1e-3), ("3.5GPa", "stress", 3.5e9),
        ("70 N/mm^2", "stress", 70e6), ("10 ksi", "stress", 68947572.93168), ("20%", "ratio", 0.2),
        ("-.5 %", "ratio", -0.005),
        ("1.39 g/cm³", "density", 1390.0),
    ],
)  # fmt: skip
def test_quantities(text: str | float, kind: str, value: float) -> None:
    assert units.parse(text, kind) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "text, kind, message",
    [
        ("thin", "length", "no length: write a number and a unit, such as 0.1mm"),
        ("3.5GPa", "length", "'GPa' is a unit of stress"),
        ("3.5gpa", "stress", r"unit 'gpa' is unknown \(did you mean GPa\?\)"),
        ("1 cubit", "length", "'cubit' is unknown; a length takes m, km"),
        ("1e999", "length", "not a finite length"),
        ("nan", "ratio", "no ratio"),
    ],
)
def test_quantities_that_make_no_sense(text: str, kind: str, message: str) -> None:
    with pytest.raises(kg.ModelError, match=message):
        units.parse(text, kind)


def test_what_is_shown_is_read_back() -> None:
    written = {"length": [1e-7, 3e-5, 1e-4, 0.012, 0.3, 24.0], "stress": [12.0, 5e4, 3e6, 3.5e9], "ratio": [0.2, 3]}
    for kind, values in written.items():
        for value in values:
            assert units.parse(units.show(value, kind), kind) == pytest.approx(value, rel=1e-6)


def test_slips_of_units_are_doubted() -> None:
    right = {"thickness": 1e-4, "size": 0.1, "E": 3.5e9, "strain": 0.2}
    assert units.doubts(**right) == []
    for slip, words in (
        ({"thickness": 0.1}, "not a thin sheet"), ({"E": 3.5}, "1 kPa to 1.5 TPa"), ({"strain": 20}, "was 20 % meant"),
        ({"size": 120.0, "thickness": 0.1}, "unit of the drawing"), ({"thickness": 1e-9}, "less than a millionth"),
    ):  # fmt: skip
        assert any(words in doubt for doubt in units.doubts(**{**right, **slip}))


# ------------------------------------------------------------------------------------------- stretch


def test_a_plain_strip_from_a_drawing_has_the_force_of_its_material(tmp_path: Path) -> None:
    """F = E t W strain / (1 - nu^2) at most, at clamped ends, and E t W strain at least; bars have nu = 1/3."""
    outline = shapely.box(0, 0, 0.2, 0.02)
    path = write_drawing(Drawing(outline, (), unit="m"), tmp_path / "strip.dxf")
    report = stretch_drawing(
        path, thickness="0.1mm", E="2GPa", strain="0.1%", direction="x", max_edge="6mm", imperfection=0
    )
    force, uniaxial = report.numbers["last_force"], 2e9 * 1e-4 * 0.02 * 1e-3
    assert 0.95 * uniaxial < force < uniaxial / (1 - 1 / 9)
    assert report.numbers["displacement"] == pytest.approx(2e-4) and report.numbers["free_length"] == pytest.approx(0.2)
    assert report.complete and "edges held at the left and right" in report.notes


def test_ends_that_are_not_straight_are_held_in_strips() -> None:
    outline, cuts = kg.cuts.single_slit_disc(radius=0.03, length=0.0258)
    disc = Drawing(outline, tuple(cuts))
    report = stretch_drawing(disc, thickness=3e-5, E=5e9, strain=0.001, max_edge=0.01, accuracy="draft")
    assert report.numbers["free_length"] == pytest.approx(0.06 * 0.92)
    assert report.numbers["strain"] == pytest.approx(0.001)
    held = report.results.model.mesh.nodes[report.results.model.index(report.results.model.constraints[0].group)]
    assert held[:, 1].max() == pytest.approx(-0.03 + 0.04 * 0.06)


def test_report_folder(tmp_path: Path) -> None:
    report = stretch_drawing(
        DRAWINGS / "inkscape_layers_mm.svg", thickness="0.1mm", E="3.5GPa", strain="0.2%", max_edge="15mm",
        accuracy="draft",
    )  # fmt: skip
    skipped: list[str] = []
    files = write_report(report, tmp_path / "out", say=skipped.append)
    assert all(file.stat().st_size > 0 for file in files)
    always = {"report.json", "curves.csv", "results.npz", "rest.png", "deformed.png", "force.png"}
    assert always <= {file.name for file in files}
    found = {entry for entry in (tmp_path / "out").rglob("*") if entry.is_file()}
    assert found == set(files)
    said = json.loads((tmp_path / "out" / "report.json").read_text())
    assert said["complete"] and said["numbers"]["cuts"] == 4 and "true size 120mm x 80mm" in said["notes"]
    assert info(tmp_path / "out" / "results.npz")["steps"] == report.numbers["steps"]


@pytest.mark.parametrize(
    "change, message",
    [
        ({"direction": "z"}, "direction must be 'x', 'y' or an angle in degrees"),
        ({"strain": "-100%"}, "would push one grip through the other"),
        ({"accuracy": "good"}, "accuracy must be one of 'draft', 'standard', 'fine'"),
        ({"grip": "-1mm"}, "grip must not be negative"),
        ({"strain": "0%"}, "strain must be a number other than zero"),
        ({"thickness": "3GPa"}, "unit of stress"),
        ({"thickness": -1e-4}, "thickness must be positive"),
        ({"grip": "60mm"}, "60 % of the length at each end do not leave a free length"),
        ({"nu": 0.7}, "nu must lie between"),
    ],
)
@pytest.mark.filterwarnings("ignore::kirigami.errors.KirigamiWarning")
def test_wrong_requests(change: dict, message: str) -> None:
    right = {"thickness": 1e-4, "E": 3e9, "max_edge": 0.05, "strain": 1e-4}
    with pytest.raises(kg.ModelError, match=message):
        stretch_drawing(Drawing(shapely.box(0, 0, 0.1, 0.1), ()), **{**right, **change})


def test_doubts_are_said() -> None:
    plate = Drawing(shapely.box(0, 0, 0.1, 0.1), ())
    with pytest.warns(kg.KirigamiWarning, match="outside what sheets are made of"):
        stretch_drawing(plate, thickness=1e-4, E=3.5, strain=1e-4, max_edge=0.05, imperfection=0)


# ------------------------------------------------------------------------------------------- convert


def test_every_drawing_can_be_meshed() -> None:
    mesh = mesh_drawing(DRAWINGS / "r2018_blocks_mm.dxf", "10mm")
    (hole,) = (cut for cut in read_drawing(DRAWINGS / "r2018_blocks_mm.dxf").cuts if cut.geom_type == "Polygon")
    assert mesh.facet_areas.sum() == pytest.approx(0.12 * 0.08 - hole.area, rel=1e-9)
    assert len(mesh.cuts) == 4
    # The fold is a line of mesh edges from side to side.
    (fold,) = mesh.folds
    on_fold = mesh.nodes[np.unique(fold.edges)]
    assert np.ptp(on_fold[:, 0]) < 1e-12 and np.ptp(on_fold[:, 1]) == pytest.approx(0.08)


def test_meshes_are_written(tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    path = tmp_path / "plate.vtu"
    mesh = mesh_drawing(DRAWINGS / "inkscape_layers_mm.svg", "20mm", output=path)
    assert np.array_equal(meshio.read(path).points, mesh.nodes)
    with pytest.raises(kg.GeometryError, match="no format for this ending"):
        write_mesh(mesh, tmp_path / "plate.xyz123")
    with pytest.raises(kg.GeometryError, match=r"there\.xyz: no format for this ending; meshes end in \.fold, .*\.vtu"):
        mesh_drawing(tmp_path / "absent.svg", output=tmp_path / "there.xyz")  # said before anything is read or meshed
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("ending", [".html", ".csv", ".nc", ".pvd", ".fold", ".stl", ".glb"])
def test_results_are_exported(ending: str, strip: kg.Results, tmp_path: Path) -> None:
    saved = strip.save(tmp_path / "strip.npz")
    files = export(saved, tmp_path / "out" / f"strip{ending}")
    assert files[-1] == tmp_path / "out" / f"strip{ending}" and all(file.stat().st_size > 0 for file in files)
    assert set((tmp_path / "out").iterdir()) == set(files)


def test_kinds_that_cannot_be_exported(strip: kg.Results, tmp_path: Path) -> None:
    saved = strip.save(tmp_path / "strip.npz")
    with pytest.raises(kg.GeometryError, match="results are exported as .html, .csv"):
        export(saved, tmp_path / "strip.doc")
    with pytest.raises(kg.GeometryError, match="drawings end in .dxf"):
        export(DRAWINGS / "features_mm.geojson", tmp_path / "plate.doc")
    with pytest.raises(kg.AnalysisError, match="no results file"):
        export(tmp_path / "absent.npz", tmp_path / "x.html")


def test_drawings_keep_their_size_from_format_to_format(tmp_path: Path) -> None:
    first = read_drawing(DRAWINGS / "inkscape_layers_mm.svg")
    export(DRAWINGS / "inkscape_layers_mm.svg", tmp_path / "a.dxf")
    export(tmp_path / "a.dxf", tmp_path / "b.fold")
    export(tmp_path / "b.fold", tmp_path / "c.geojson")
    last = read_drawing(tmp_path / "c.geojson")
    assert last.outline.symmetric_difference(first.outline).area < 1e-12
    cuts = [shapely.GeometryCollection(drawing.cuts) for drawing in (first, last)]
    # an arc goes out as an arc, and comes back with chords of its own, which lie within 2e-4 of the extent of the sheet
    near = 2 * 2e-4 * np.ptp(np.reshape(first.outline.bounds, (2, 2)), axis=0).max()
    assert shapely.hausdorff_distance(*cuts) < near
    lines = [[cut for cut in drawing.cuts if cut.geom_type == "LineString"] for drawing in (first, last)]
    assert len(lines[0]) == len(lines[1]) > 0
    assert shapely.hausdorff_distance(*map(shapely.GeometryCollection, lines)) < 1e-10
    assert info(tmp_path / "c.geojson")["folds"] == 1
