"""The command line: what it writes, what it says, and how it ends."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kirigami as kg
from kirigami import cli
from kirigami.analysis.path import PathAnalysis

FILES = {"cut_sheet.png", "deformed.png", "curves.png", "stretch.gif", "results.npz"}


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """The demo on a mesh coarse enough for a test."""
    make = cli.demo_model
    monkeypatch.setattr(cli, "demo_model", lambda max_edge, pull: make(0.6, pull))


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the first part of the path."""
    analysis = kg.DisplacementControl
    monkeypatch.setattr(
        kg, "DisplacementControl", lambda model, targets: analysis(model, to=0.004, targets=targets[:1])
    )


def test_demo_writes_its_files_and_says_the_numbers(
    coarse: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["demo", "--folder", str(tmp_path / "new" / "demo"), "--frames", "2"]) == 0
    folder = tmp_path / "new" / "demo"
    assert {path.name for path in folder.iterdir()} == FILES  # and nothing unfinished beside them
    for name in FILES - {"results.npz"}:
        assert (folder / name).read_bytes()[:4] in (b"\x89PNG", b"GIF8")

    results = kg.load(folder / "results.npz")
    assert results.lam[-1] == 1.0
    top = np.flatnonzero(results.rest[:, 1] >= 2.305 - 1e-9)
    assert np.abs(results.u[-1, top] - (0, 0.4, 0)).max() < 1e-12
    force = results.reaction(top.tolist(), "y")
    said = capsys.readouterr()
    area = results.open_area(union=True)[-1]
    for number in (f" {len(results.rest):,}, ", f" {force.max():.4g} N at strain", f" {area:.4g} m^2, from 0 m^2"):
        assert number in said.out
    assert "0.2 = 0.4 m of grip displacement / 2 m of cut region" in said.out
    assert "Animation" in said.err  # progress goes to the other stream, out of the way of a pipe


def test_quiet_says_nothing(coarse: None, short: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["demo", "--folder", str(tmp_path), "--frames", "2", "-q"]) == 0
    said = capsys.readouterr()
    assert (said.out, said.err) == ("", "")
    assert {path.name for path in tmp_path.iterdir()} == FILES


@pytest.mark.parametrize("words", [["demo", "--frames", "1"], ["demo", "--frames", "many"], ["unknown"], ["--unknown"]])
def test_wrong_usage_ends_with_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(words)
    assert ended.value.code == 2
    assert capsys.readouterr().err.startswith("usage: kirigami")


def test_no_command_shows_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 2
    assert "kirigami demo --full" in capsys.readouterr().err


def test_an_error_of_the_package_is_a_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(max_edge: float, pull: float) -> None:
        raise kg.GeometryError("the cuts sever the sheet")

    monkeypatch.setattr(cli, "demo_model", broken)
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


def test_help_is_quick() -> None:
    """Asking for help must not load what only the analysis and the pictures need."""
    program = (
        "import sys, kirigami.cli as cli\n"
        "try: cli.main(['demo', '--help'])\n"
        "except SystemExit as end: code = end.code\n"
        "heavy = {'matplotlib', 'shapely', 'triangle', 'scipy.sparse.linalg'} & set(sys.modules)\n"
        "sys.exit(f'loaded {heavy}' if heavy else code)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "--folder" in done.stdout
