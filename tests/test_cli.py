"""The command line: what it writes, what it says, and how it ends."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kirigami as kg
from kirigami import cli
from kirigami.analysis.path.methods import PathAnalysis
from kirigami.cli import demo, export
from kirigami.cli.options import in_words_of_the_command
from kirigami.plot import deformed

DRAWINGS = Path(__file__).parent / "data" / "drawings"
PLATE = str(DRAWINGS / "inkscape_layers_mm.svg")  # 120 x 80 mm, three slits and a hole
SHEET = ["--thickness", "0.1mm", "--E", "3.5GPa", "--strain", "0.2%", "--max-edge", "15mm", "--accuracy", "draft"]
COMMANDS = ["demo", "stretch", "accuracy", "mesh", "info", "export"]
PICTURES = {"rest.png", "deformed.png", "above.png", "force.png", "stress.png", "opening.png", "stretch.gif"}
FILES = PICTURES | {"report.json", "curves.csv", "results.npz"}


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """The demo on a mesh coarse enough for a test, without the pages that are tested elsewhere."""
    stretch = kg.stretch

    def quick(sheet: kg.Sheet, strain: float, direction: str, **options: Any) -> kg.Results:
        return stretch(sheet, strain, direction, **{**options, "accuracy": "draft", "nodes": None, "max_edge": 0.6})

    monkeypatch.setattr(kg, "stretch", quick)


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the first part of the path."""
    monkeypatch.setattr(demo, "PULL", 0.0016)


def test_demo_writes_its_files_and_says_the_numbers(
    coarse: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["demo", "--folder", str(tmp_path / "new" / "demo"), "--frames", "2"]) == 0
    folder = tmp_path / "new" / "demo"
    made = {path.name for path in folder.iterdir()}
    assert made >= FILES and made <= FILES | {"page.html", "vtk"}  # and nothing unfinished beside them
    for name in PICTURES:
        assert (folder / name).read_bytes()[:4] in (b"\x89PNG", b"GIF8")

    results = kg.load(folder / "results.npz")
    assert results.lam[-1] == 1.0
    top = np.flatnonzero(results.rest[:, 1] >= 2.305 - 1e-9)
    assert np.array_equal(np.sort(results.grips["moved"]), top)
    assert np.abs(results.u[-1, top] - (0, 0.4, 0)).max() < 1e-12
    force = results.reaction(top.tolist(), "y")
    said = capsys.readouterr()
    opened = f"open area {results.open_area(union=True)[-1]:.4g} m2"
    shape = "one stable shape of many: --shapes looks for the others"
    for number in (f"nodes {len(results.rest)}, ", f"largest force {force.max():.4g} N at strain", opened, shape):
        assert number in said.out
    assert "strain 18.1 % = 0.4 m of grip displacement / 2.21 m between the grips" in said.out
    assert "Animation" in said.err  # progress goes to the other stream, out of the way of a pipe


def test_quiet_says_nothing(coarse: None, short: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["demo", "--folder", str(tmp_path), "--frames", "2", "-q"]) == 0
    said = capsys.readouterr()
    assert said.out == "" and "Animation" not in said.err and "Displacement" not in said.err
    assert {path.name for path in tmp_path.iterdir()} >= FILES


def test_demo_prints_numbers(
    coarse: None, short: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["demo", "--folder", str(tmp_path), "--frames", "2", "--json", "-q"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    assert numbers["displacement"] == pytest.approx(0.0016) and numbers["strain"] == pytest.approx(0.0016 / 2.21)
    assert numbers["largest_force"] > 0 and numbers["folder"] == str(tmp_path)


@pytest.mark.parametrize(
    "words",
    [
        ["demo", "--frames", "1"],
        ["demo", "--frames", "many"],
        ["unknown"],
        ["--unknown"],
        ["stretch", PLATE],
        ["stretch", PLATE, *SHEET, "--thickness", "3GPa"],
        ["stretch", PLATE, *SHEET, "--direction", "z"],
        ["stretch", PLATE, *SHEET, "--direction", "nan"],
        ["stretch", PLATE, *SHEET, "--nodes", "0"],
        ["stretch", PLATE, *SHEET, "--accuracy", "best"],
        ["mesh", PLATE, "--max-edge", "2 cubits"],
        ["export", PLATE],
    ],
)
def test_wrong_usage_ends_with_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(words)
    assert ended.value.code == 2
    assert capsys.readouterr().err.startswith("usage: kirigami")


def test_wrong_units_are_explained(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["stretch", PLATE, "--thickness", "0.1mm", "--E", "3.5gpa"])
    assert "argument --E: '3.5gpa': the unit 'gpa' is unknown (did you mean GPa?)" in capsys.readouterr().err


def test_no_command_shows_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 2
    said = capsys.readouterr().err
    assert all(f"  kirigami {command} " in said for command in COMMANDS)


def test_an_error_of_the_package_is_a_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken() -> None:
        raise kg.GeometryError("the cuts sever the sheet")

    monkeypatch.setattr(demo, "demo_sheet", broken)
    assert cli.main(["demo", "--folder", str(tmp_path)]) == 1
    assert capsys.readouterr().err == "kirigami: the cuts sever the sheet\n"


def test_a_folder_that_cannot_be_made_is_a_sentence(
    coarse: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    occupied = tmp_path / "file"
    occupied.write_text("")
    assert cli.main(["demo", "--folder", str(occupied)]) == 1
    said = capsys.readouterr().err
    assert said.startswith("kirigami: ") and str(occupied) in said and len(said.splitlines()) == 1


def test_interruption_keeps_what_was_found(
    coarse: None, short: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = PathAnalysis.run

    def interrupted(analysis: PathAnalysis, progress: bool) -> kg.Results:
        def stop(step: kg.Step) -> None:
            if step.lam == 0.002:
                raise KeyboardInterrupt

        return run(analysis, recorders=[stop])

    monkeypatch.setattr(PathAnalysis, "run", interrupted)
    assert cli.main(["demo", "--folder", str(tmp_path), "--frames", "2"]) == 130
    assert kg.load(tmp_path / "results.npz").lam[-1] == 0.002
    assert "kirigami: interrupted after" in capsys.readouterr().err


@pytest.mark.parametrize("command", COMMANDS)
def test_help_is_quick_and_fits(command: str) -> None:
    """Asking for help must not load what only the analysis and the pictures need; examples must be right."""
    program = (
        "import sys, kirigami.cli as cli\n"
        f"try: cli.main(['{command}', '--help'])\n"
        "except SystemExit as end: code = end.code\n"
        "heavy = {'matplotlib', 'shapely', 'triangle', 'scipy.sparse.linalg'} & set(sys.modules)\n"
        "sys.exit(f'loaded {heavy}' if heavy else code)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "--json" in done.stdout and "--quiet" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 100
    examples = [line.strip() for line in done.stdout.splitlines() if line.strip().startswith(f"kirigami {command}")]
    assert examples
    for example in examples:
        words = example.partition(" |")[0].partition("    ")[0].split()[1:]
        assert cli.make_parser().parse_args(words).command == command


# ---- stretch


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


def test_stretch_prints_numbers_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["stretch", PLATE, *SHEET, "--grip", "10mm", "--folder", str(tmp_path), "--json", "--quiet"]
    assert cli.main(words) == 0
    said = capsys.readouterr()
    numbers = json.loads(said.out)
    assert "Displacement" not in said.err
    assert numbers["complete"] and numbers["cuts"] == 4
    assert numbers["free_length"] == pytest.approx(0.06) and numbers["displacement"] == pytest.approx(0.12e-3)
    # Stiffer than the uncut sheet it cannot be: E t W strain / (1 - nu^2), bars have nu = 1/3.
    assert 0 < numbers["largest_force"] < 3.5e9 * 1e-4 * 0.12 * 0.002 / (1 - 1 / 9)


def test_doubts_are_notes_of_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["stretch", PLATE, *SHEET, "--E", "3.5kPa", "--thickness", "20mm", "--folder", str(tmp_path), "--quiet"]
    assert cli.main(words) == 0
    said = capsys.readouterr()
    assert said.out == ""
    notes = said.err.splitlines()
    assert "kirigami: the thickness 20 mm is 16.6667 % of the size 120 mm: not a thin sheet" in notes
    assert all(note.startswith("kirigami: ") for note in notes)


def test_a_path_that_ends_early_is_written_and_ends_with_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
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


# ---- mesh, info, export


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
    assert set(export.COLORS) == {*deformed.LABELS, "none"}


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


def test_a_closed_pipe_ends_quietly() -> None:
    """`kirigami info plate.svg | head -0`: nobody reads, and that is no error."""
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-m", "kirigami.cli", "info", PLATE, "--no-picture"],
        stdout=write, stderr=subprocess.PIPE, check=False,
    )  # fmt: skip
    os.close(write)
    assert (done.returncode, done.stderr) == (0, b"")


def test_metres_that_nobody_meant_are_taken_as_millimetres(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Libraries write metres into the head of a drawing: 80 m of 0.1 mm is no sheet, and 80 mm is meant."""
    drawing = str(DRAWINGS / "repaired" / "k13a_header_says_metres.dxf")
    words = ["stretch", drawing, "--thickness", "0.1mm", "--E", "3.5GPa", "--strain", "0.1%", "--accuracy", "draft"]
    assert cli.main([*words, "--nodes", "150", "--folder", str(tmp_path / "a"), "--json"]) == 0
    said = capsys.readouterr()
    assert "taken as millimetres; --drawn-in m" in said.err
    assert json.loads(said.out)["free_length"] < 0.1


def test_a_ligament_thinner_than_the_sheet_is_told_with_its_figure(
    short: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
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


# ---- what holds for every command

RESULTS = "made.npz"
TABLE = {
    "demo": ["--folder", "d", "--frames", "2"],
    "stretch": [PLATE, *SHEET, "--folder", "s"],
    "accuracy": [PLATE, "--sizes", "40mm", "--stiffness", "plate", "--strain", "0.05%", "--reference", "shell.csv",
                 "--tolerance", "1mm", "--folder", "a"],
    "mesh": [PLATE, "--max-edge", "20mm", "-o", "m.fold"],
    "info": [PLATE],
    "export": [RESULTS, "x.csv", "x.html"],
}  # fmt: skip


LENGTHY = ("demo", "stretch", "accuracy")


def test_the_table_holds_every_command() -> None:
    from argparse import _SubParsersAction

    (commands,) = (item for item in cli.make_parser()._actions if isinstance(item, _SubParsersAction))
    assert set(commands.choices) == set(TABLE)


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports without pictures and pages, which other tests look at."""
    monkeypatch.setattr("kirigami.study.report_picture.write_pictures", lambda report, folder: [])
    monkeypatch.setattr("kirigami.io.vtk.write_vtk", lambda results, folder: [])


@pytest.fixture
def workplace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the files that the table of commands names."""
    monkeypatch.chdir(tmp_path)
    m = kg.Model(dim=2, name="bar")
    a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    kg.LinearStatic(m).run().save(tmp_path / RESULTS)
    (tmp_path / "shell.csv").write_text("load_factor,force\n0,0\n0.5,10\n1,20\n")
    return tmp_path


@pytest.mark.parametrize("command", TABLE)
@pytest.mark.filterwarnings("ignore")
def test_every_command_is_silent_or_speaks_json(
    command: str, coarse: None, short: None, plain: None, workplace: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """0 where all went well; --quiet leaves stdout empty; --json leaves one object there and nothing else."""
    if command not in LENGTHY:  # which take seconds, and whose silence is tested above
        assert cli.main([command, *TABLE[command], "--quiet"]) == 0
        said = capsys.readouterr()
        assert said.out == "" and "Traceback" not in said.err
    assert cli.main([command, *TABLE[command], "--json", "--quiet"]) == 0
    assert isinstance(json.loads(capsys.readouterr().out), dict)
    assert not list(workplace.rglob("*.part*"))


@pytest.mark.parametrize("command", TABLE)
def test_every_command_ends_with_2_for_wrong_usage_and_with_1_for_a_missing_file(
    command: str, workplace: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main([command, *TABLE[command], "--no-such-option"])
    assert ended.value.code == 2 and "usage: kirigami" in capsys.readouterr().err
    words = ["absent.dxf" if word in (PLATE, RESULTS) else word for word in TABLE[command]]
    if command == "demo":
        (workplace / "d").write_text("a file where the folder is to be")
    assert cli.main([command, *words]) == 1
    said = capsys.readouterr().err
    assert said.startswith("kirigami: ") and len(said.splitlines()) == 1
    assert ("d" if command == "demo" else "absent.dxf") in said


READ = [["--help"], *([command, "--help"] for command in TABLE)]
READ += [[command, *words, "--json"] for command, words in TABLE.items() if command not in LENGTHY]


@pytest.mark.parametrize("words", READ)
@pytest.mark.filterwarnings("ignore")
def test_a_reader_that_has_enough_is_no_error(
    words: list[str], coarse: None, short: None, plain: None, workplace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`kirigami ... | head -0`, for the help as well; nothing is left for Python to complain about as it ends."""
    read, write = os.pipe()
    os.close(read)
    with open(write, "w") as closed:
        monkeypatch.setattr(sys, "stdout", closed)
        assert cli.main(words) == 0
        closed.flush()


def test_hints_speak_the_language_of_the_command_line() -> None:
    for python, command in (
        ("use a mesh without a pattern, or stiffness='shell'", "use a mesh without a pattern, or --stiffness shell"),
        ("by 3. kirigami.stiffness.report(mesh) has the numbers; use a finer mesh", "by 3; use a finer mesh"),
        ("Hint: the path so far is in error.results; another amplitude", "Hint: what was found is written; another"),
        ("LoadCase: rim is held", "rim is held"), ("give `max_edge=2`", "give --max-edge 2"),
        ("energy of 0.002 (force times length) was set free", "energy of 0.002 J was set free"),
        ("width 0.015 (in the unit of the sheet) has", "width 0.015 (in metres) has"),
    ):  # fmt: skip
        assert in_words_of_the_command(python).startswith(command)


# ---- load cases


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
