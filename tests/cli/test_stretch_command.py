"""`kirigami stretch`: the whole job, its notes, doubts and ends."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_sheets import DRAWINGS, PLATE, SHEET

import kirigami as kg
from kirigami import cli
from kirigami.analysis.path.methods import PathAnalysis


def test_stretch_does_the_whole_job(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "new" / "out"
    assert cli.main(["stretch", PLATE, *SHEET, "--direction", "y", "--folder", str(folder)]) == 0
    said = capsys.readouterr()
    for words in (
        "true size 120mm x 80mm",
        "thickness 0.1 mm, E 3.5 GPa, nu 0.34",
        "edges held at the bottom and top",
        "strain 0.2 % to reach (load factor 1), 0.16 mm of grip displacement",
        "strain 0.2 % = 0.16 mm of grip displacement / 80 mm between the grips",
        f"Written to {folder}: report.json, curves.csv, results.npz, case.json, rest.png, deformed.png, above.png",
    ):
        assert words in said.out
    report = json.loads((folder / "report.json").read_text())
    assert f"largest force {report['numbers']['largest_force']:.4g} N" in said.out
    results = kg.load(folder / "results.npz")
    assert results.lam[-1] == 1.0 and np.ptp(results.u[-1, :, 1]) >= 0.16e-3
    assert not list(folder.rglob("*.part*"))


def test_stretch_prints_numbers_alone(plain: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["stretch", PLATE, *SHEET, "--grip", "10mm", "--folder", str(tmp_path), "--json", "--quiet"]
    assert cli.main(words) == 0
    said = capsys.readouterr()
    numbers = json.loads(said.out)
    assert "Displacement" not in said.err
    assert numbers["complete"] and numbers["cuts"] == 4
    assert numbers["free_length"] == pytest.approx(0.06) and numbers["displacement"] == pytest.approx(0.12e-3)
    # Stiffer than the uncut sheet it cannot be: E t W strain / (1 - nu^2), bars have nu = 1/3.
    assert 0 < numbers["largest_force"] < 3.5e9 * 1e-4 * 0.12 * 0.002 / (1 - 1 / 9)
    assert not list(tmp_path.rglob("*.part*"))


def test_doubts_are_notes_of_one_line(plain: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["stretch", PLATE, *SHEET, "--E", "3.5kPa", "--thickness", "20mm", "--folder", str(tmp_path), "--quiet"]
    assert cli.main(words) == 0
    said = capsys.readouterr()
    assert said.out == ""
    notes = said.err.splitlines()
    assert "kirigami: the thickness 20 mm is 16.6667 % of the size 120 mm: not a thin sheet" in notes
    assert all(note.startswith("kirigami: ") for note in notes)


def test_a_path_that_ends_early_is_written_and_ends_with_1(
    plain: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run = PathAnalysis.run

    def lost(analysis: PathAnalysis, progress: bool = False) -> kg.Results:
        analysis.targets = [0.25]  # type: ignore[attr-defined]
        analysis.to = 0.5  # type: ignore[attr-defined]
        raise kg.ConvergenceError("no equilibrium found after load factor 0.5", results=run(analysis))

    monkeypatch.setattr(PathAnalysis, "run", lost)
    assert cli.main(["stretch", PLATE, *SHEET, "--folder", str(tmp_path), "--json"]) == 1
    numbers = json.loads(capsys.readouterr().out)
    assert not numbers["complete"] and numbers["strain"] == pytest.approx(0.001)
    results = kg.load(tmp_path / "results.npz")
    assert results.lam[-1] == 0.5
    assert results.reaction(results.grips["moved"], "y")[-1] == pytest.approx(numbers["last_force"])
    notes = json.loads((tmp_path / "report.json").read_text())["notes"]
    assert any("followed to a strain of 0.1 % on the way to 0.2 %" in note for note in notes)


def test_an_interrupted_stretch_keeps_what_was_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run = PathAnalysis.run

    def interrupted(analysis: PathAnalysis, progress: bool = False) -> kg.Results:
        def stop(step: kg.Step) -> None:
            raise KeyboardInterrupt

        return run(analysis, recorders=[stop])

    monkeypatch.setattr(PathAnalysis, "run", interrupted)
    assert cli.main(["stretch", PLATE, *SHEET, "--folder", str(tmp_path)]) == 130
    assert len(kg.load(tmp_path / "results.npz")) == 1
    assert "the path ended at 0 % of the way" in capsys.readouterr().out


def test_a_sheet_without_equilibrium_at_rest_is_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def lost(analysis: PathAnalysis, progress: bool = False) -> kg.Results:
        raise kg.ConvergenceError("no equilibrium found at the start", results=kg.Results(kg.System(analysis.model)))

    monkeypatch.setattr(PathAnalysis, "run", lost)
    assert cli.main(["stretch", PLATE, *SHEET, "--folder", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert "kirigami: the sheet was followed to a strain of 0 %" in said and "at the start" in said
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "words, complaint",
    [
        (["absent.dxf"], "there is no file absent.dxf"),
        (["plate.step"], "drawings end in .dxf, .svg"),
        ([PLATE, "--cuts", "purple"], "no curve is on a layer or has a colour 'purple'; there are layer"),
        ([PLATE, "--grip", "60mm"], "75 % of the length at each end do not leave a free length"),
        ([str(DRAWINGS / "crease_pattern_mm.fold"), "--outline", "red"], "read without the option outline"),
    ],
)
def test_what_cannot_be_stretched_leaves_no_folder(
    words: list[str], complaint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["stretch", *words, *SHEET, "--folder", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert said.startswith("kirigami: ") and complaint in said and len(said.splitlines()) == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "words",
    [
        ["--thickness", "0"], ["--thickness=-1mm"], ["--E", "0"], ["--grip=-1mm"], ["--max-edge", "0"],
        ["--max-edge=1e300m"], ["--imperfection=-1mm"], ["--tolerance", "nan"], ["--tolerance=-1"],
        ["--tolerance", "1e9"], ["--tolerance", "1"], ["--tolerance", "0mm"], ["--tolerance", "wide"],
        ["--part", "one"],
    ],
)  # fmt: skip
def test_quantities_out_of_range_are_wrong_usage(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["stretch", PLATE, *SHEET, *words])
    assert ended.value.code == 2
    assert f"argument {words[0].partition('=')[0]}" in capsys.readouterr().err


def test_metres_that_nobody_meant_are_taken_as_millimetres(
    plain: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Libraries write metres into the head of a drawing: 80 m of 0.1 mm is no sheet, and 80 mm is meant."""
    drawing = str(DRAWINGS / "repaired" / "k13a_header_says_metres.dxf")
    words = ["stretch", drawing, "--thickness", "0.1mm", "--E", "3.5GPa", "--strain", "0.1%", "--accuracy", "draft"]
    assert cli.main([*words, "--nodes", "150", "--folder", str(tmp_path / "a"), "--json"]) == 0
    said = capsys.readouterr()
    assert "taken as millimetres; --drawn-in m" in said.err
    assert json.loads(said.out)["free_length"] < 0.1


def test_a_ligament_thinner_than_the_sheet_is_told_with_its_figure(
    plain: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """And the report is written all the same, with what it is worth."""
    drawing = tmp_path / "slit.svg"
    drawing.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="100mm" viewBox="0 0 60 100">'
        '<rect width="60" height="100" fill="none" stroke="black"/><path d="M 0 50 H 57" stroke="red"/></svg>'
    )
    words = ["stretch", str(drawing), "--thickness", "6mm", "--E", "3.5GPa", "--strain", "0.1%", "--nodes", "100",
             "--stiffness", "facet", "--imperfection", "0", "--folder", str(tmp_path / "out"), "--quiet"]  # fmt: skip
    cli.main(words)
    assert "the narrowest ligament is 3 mm wide, 0.5 times the thickness 6 mm" in capsys.readouterr().err
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert any("0.5 times the thickness" in note for note in report["notes"])
    assert 0 < report["numbers"]["error"]["force"] < 1 and any("estimated error" in note for note in report["notes"])


def test_motions_and_places_are_options(plain: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["stretch", PLATE, *SHEET, "--shear", "0.1%", "--twist", "2", "--push", "90mm,20mm", "0.1mm"]
    assert cli.main([*words, "--hold", "left=z", "--folder", str(tmp_path / "a"), "--json"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    assert numbers["shear"] == pytest.approx(1e-3) and numbers["twist"] == pytest.approx(2)
    assert numbers["lift_90mm_20mm"] == pytest.approx(-1e-4) and numbers["force_90mm_20mm"] != 0
    again = ["stretch", str(tmp_path / "a" / "case.json"), "--twist", "0", "--folder", str(tmp_path / "b"), "--json"]
    assert cli.main(again) == 0
    changed = json.loads(capsys.readouterr().out)
    assert "twist" not in changed and changed["shear"] == numbers["shear"] and changed["nodes"] == numbers["nodes"]


@pytest.mark.parametrize(
    "words, complaint",
    [
        (["--lift", "nowhere", "1mm"], "is no place: say left"), (["--lift", "centre", "high"], "is no length"),
        (["--lift", "centre", "0"], "must be positive"), (["--twist", "far"], "no angle in degrees"),
        (["--hold", "rim=up"], "held by 'clamp', or along axes"), (["--strain", "0"], "other than zero"),
    ],
)  # fmt: skip
def test_motions_that_make_no_sense_are_wrong_usage(
    words: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["stretch", PLATE, *SHEET, *words])
    assert ended.value.code == 2 and complaint in capsys.readouterr().err


def test_a_measured_curve_is_compared(plain: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "test.csv"
    file.write_text("displacement [mm],force [N]\n0,0\n0.08,30\n0.16,60\n")
    words = ["stretch", PLATE, *SHEET, "--folder", str(tmp_path / "out"), "--compare", str(file)]
    assert cli.main(words) == 0
    assert "measured curve test.csv: RMS difference" in capsys.readouterr().out
    file.write_text("time,load\n1,2\n")
    assert cli.main([*words[:-3], str(tmp_path / "other"), "--compare", str(file)]) == 1
    assert "test.csv" in capsys.readouterr().err and not (tmp_path / "other").exists()


def test_one_size_of_the_mesh_takes_the_place_of_the_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a case that is done again; both at once are refused, of which one used to be left out without a word."""
    case = kg.study.Job(PLATE, "0.1mm", "3.5GPa", nodes=300, accuracy="draft").save(tmp_path / "case.json")
    asked: list[kg.study.Job] = []

    def noted(job: kg.study.Job, **options: Any) -> kg.study.Report:
        asked.append(job)
        raise kg.ModelError("enough")

    with monkeypatch.context() as patched:
        patched.setattr(kg.study.Job, "run", noted)
        for words in ([], ["--max-edge", "15mm"], ["--nodes", "400"]):
            assert cli.main(["stretch", str(case), *words, "--folder", str(tmp_path / "out")]) == 1
    assert [(job.nodes, job.max_edge) for job in asked] == [(300, None), (None, 0.015), (400, None)]
    capsys.readouterr()
    words = ["stretch", PLATE, *SHEET, "--nodes", "300", "--quiet", "--folder", str(tmp_path / "out")]
    assert cli.main(words) == 1
    assert capsys.readouterr().err.endswith("kirigami: give --max-edge or a budget of --nodes, not both\n")
