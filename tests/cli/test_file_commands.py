"""`kirigami mesh`, `info` and `export`: what they read, say and write."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cli_sheets import DRAWINGS, PLATE, SHEET

import kirigami as kg
from kirigami import cli
from kirigami.cli import export
from kirigami.plot.field import LABELS


def test_mesh_is_described_and_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mesh.fold"
    assert cli.main(["mesh", PLATE, "--max-edge", "15mm", "-o", str(file)]) == 0
    said = capsys.readouterr().out
    assert cli.main(["mesh", PLATE, "--max-edge", "15mm", "--json"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    content = json.loads(file.read_text())
    assert len(content["faces_vertices"]) == numbers["facets"] and f"facets {numbers['facets']}, cuts 4" in said
    assert len(content["vertices_coords"]) == numbers["nodes"]
    assert numbers["longest_edge"] < 1.1 * 0.015 and numbers["area"] < 0.12 * 0.08


def test_info_says_what_was_read(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["info", PLATE, "--no-picture"]) == 0
    assert "true size 120mm x 80mm" in capsys.readouterr().out
    assert cli.main(["info", PLATE, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["width"], found["cuts"], found["folds"]) == (pytest.approx(0.12), 4, 1)
    assert cli.main(["info", PLATE, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_layers_and_units_can_be_told(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["info", str(DRAWINGS / "r2018_blocks_mm.dxf"), "--json", "--drawn-in", "cm"]
    assert cli.main([*words, "--outline", "Outline", "--cuts", "red", "--cuts", "Bend lines"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["width"], found["cuts"], found["folds"]) == (pytest.approx(1.2), 5, 0)


def test_drawings_are_exported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    targets = [str(tmp_path / "plate.geojson"), str(tmp_path / "plate.fold")]
    assert cli.main(["export", PLATE, *targets, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"files": targets}
    sheets = kg.Sheet.from_geojson(targets[0]), kg.Sheet.from_fold(targets[1])
    for sheet in sheets:
        assert sheet.area == pytest.approx(kg.Sheet.from_svg(PLATE).area, rel=1e-9) and len(sheet.cuts) == 4
    assert cli.main(["export", PLATE, str(tmp_path / "plate.doc")]) == 1
    assert "drawings end in .dxf" in capsys.readouterr().err
    assert len(list(tmp_path.iterdir())) == 2


def test_results_are_exported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    m = kg.Model(dim=2, name="bar")
    a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    saved = kg.LinearStatic(m).run().save(tmp_path / "bar.npz")
    assert cli.main(["export", str(saved), str(tmp_path / "bar.csv")]) == 0
    assert capsys.readouterr().out == f"Written to {tmp_path / 'bar.csv'}\n"
    assert (tmp_path / "bar.csv").read_text().startswith("step,load_factor")
    assert cli.main(["info", str(saved)]) == 0
    assert "bar: 2 nodes in 2D" in capsys.readouterr().out


def test_info_draws_what_was_understood(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for words in (["--json"], ["--quiet"], ["--no-picture"]):
        assert cli.main(["info", PLATE, *words]) == 0
    assert not list(tmp_path.iterdir())
    capsys.readouterr()
    assert cli.main(["info", PLATE]) == 0
    said = capsys.readouterr().out
    assert (tmp_path / "inkscape_layers_mm-read.png").read_bytes()[:4] == b"\x89PNG"
    assert "taken as" in said and said.endswith("Drawn in inkscape_layers_mm-read.png\n")
    assert cli.main(["info", PLATE, "--picture", "a.xyz"]) == 1
    assert "no format for pictures" in capsys.readouterr().err
    assert len(list(tmp_path.iterdir())) == 1
    (tmp_path / "inkscape_layers_mm-read.png").unlink()
    (tmp_path / "inkscape_layers_mm-read.png").mkdir()  # a picture that nobody asked for is no reason to fail
    assert cli.main(["info", PLATE]) == 0
    said = capsys.readouterr()
    assert "not drawn" in said.err and "taken as" in said.out


def test_pictures_are_coloured_by_all_that_there_is() -> None:
    """Plastic strain was to be had in a script only."""
    assert set(export.COLORS) == {*LABELS, "none"}


def test_pictures_films_and_bodies_are_exported(
    plain: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("trimesh")
    assert cli.main(["stretch", PLATE, *SHEET, "--folder", str(tmp_path), "--quiet"]) == 0
    saved = str(tmp_path / "results.npz")
    names = [str(tmp_path / name) for name in ("a.png", "a.gif", "a.stl")]
    words = ["export", saved, *names, "--color", "stress", "--step", "2", "--thickness", "2mm", "--frames", "2"]
    assert cli.main(words) == 0
    assert [Path(name).read_bytes()[:4] for name in names[:2]] == [b"\x89PNG", b"GIF8"]
    import trimesh

    body = trimesh.load(names[2])
    assert body.extents[:2] == pytest.approx((120, 80), rel=0.01) and body.extents[2] >= 2  # mm
    assert cli.main(["export", saved, str(tmp_path / "b.png"), "--step", "99"]) == 1
    assert "step 99 is not stored" in capsys.readouterr().err and not (tmp_path / "b.png").exists()
