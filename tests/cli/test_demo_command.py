"""`kirigami demo`: its files, its numbers, and what is left of it when it is stopped."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import kirigami as kg
from kirigami import cli
from kirigami.analysis.path.methods import PathAnalysis

PICTURES = {"rest.png", "deformed.png", "above.png", "force.png", "stress.png", "opening.png", "stretch.gif"}
FILES = PICTURES | {"report.json", "curves.csv", "results.npz"}


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


def test_quiet_says_nothing(
    coarse: None, short: None, plain: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["demo", "--folder", str(tmp_path), "--frames", "2", "-q"]) == 0
    said = capsys.readouterr()
    assert said.out == "" and "Animation" not in said.err and "Displacement" not in said.err
    assert {path.name for path in tmp_path.iterdir()} >= FILES - PICTURES | {"stretch.gif"}


def test_demo_prints_numbers(
    coarse: None, short: None, plain: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["demo", "--folder", str(tmp_path), "--frames", "2", "--json", "-q"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    assert numbers["displacement"] == pytest.approx(0.0016) and numbers["strain"] == pytest.approx(0.0016 / 2.21)
    assert numbers["largest_force"] > 0 and numbers["folder"] == str(tmp_path)
    assert not list(tmp_path.rglob("*.part*"))


def test_a_folder_that_cannot_be_made_is_a_sentence(
    coarse: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    occupied = tmp_path / "file"
    occupied.write_text("")
    assert cli.main(["demo", "--folder", str(occupied)]) == 1
    said = capsys.readouterr().err
    assert said.startswith("kirigami: ") and str(occupied) in said and len(said.splitlines()) == 1


def test_interruption_keeps_what_was_found(
    coarse: None, short: None, plain: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
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
