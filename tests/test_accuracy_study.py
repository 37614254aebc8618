"""The accuracy-time study: errors, front, advice, resuming, failures as rows, bad input, and its command."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.cli import main

SLIT = shapely.LineString([(0.3, 0.5), (0.7, 0.5)])
SHEET = kg.Sheet(shapely.box(0, 0, 1, 1), [SLIT], thickness=0.01, material=kg.Material(E=1e6, nu=0.3))


def pulled(max_edge: float, stiffness: str):
    if max_edge > 0.9:
        raise kg.ModelError("too coarse on purpose")
    m = kg.Model.from_mesh(SHEET.mesh(max_edge), stiffness=stiffness)
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, clamp=True), kg.Prescribe(top, x=0, y=1e-4, z=0, clamp=True))
    return m, top, "y"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> kg.study.AccuracyStudy:
    path = tmp_path_factory.mktemp("study") / "sheet"
    return kg.study.accuracy(pulled, [1.0, 0.3, 0.15], path=path, stiffness=["plate", "split"], at=[0.5, 1.0])


def test_errors_fall_with_the_mesh_and_the_reference_has_none(study: kg.study.AccuracyStudy) -> None:
    rows = [row for row in study.table if row["stiffness"] == "split" and row["status"] == "done"]
    errors = [study.error(row, "force") for row in rows]
    assert errors[1] < 0.6 * errors[0] and np.isnan(errors[2])
    assert study.named.startswith("split, max_edge 0.09")


def test_failures_are_rows(study: kg.study.AccuracyStudy) -> None:
    assert len(study.table.failed) == 2 and "too coarse on purpose" in str(study)


def test_front_and_advice(study: kg.study.AccuracyStudy) -> None:
    front = study.front()
    seconds = [float(row["cpu_seconds"]) for row in front]
    errors = [study.error(row, "force") for row in front]
    assert seconds == sorted(seconds) and errors == sorted(errors, reverse=True)
    assert study.recommend(10.0).startswith("1000 % in force: ")
    assert "not reached" in study.recommend(1e-6)
    figure = study.plot({"another code": {"force": (0.02, 3.0)}})
    assert len(figure.axes) == 3 and "failed" in figure.get_supxlabel()


def test_it_resumes_without_running_again(study: kg.study.AccuracyStudy, tmp_path: Path) -> None:
    path = tmp_path / "small"
    first = kg.study.accuracy(pulled, [0.3], path=path, stiffness=["plate"], at=[1.0])

    def broken(max_edge: float, stiffness: str):
        raise AssertionError("a finished run must not be repeated")

    again = kg.study.accuracy(broken, [0.3], path=path, stiffness=["plate"], at=[1.0])
    assert [row["force at 1"] for row in again.table] == [row["force at 1"] for row in first.table]


def test_a_reference_file_is_interpolated(tmp_path: Path) -> None:
    file = tmp_path / "shell.csv"
    file.write_text("# from elsewhere\nload_factor,force\n0,0\n0.5,2\n1,6\n")
    study = kg.study.accuracy(
        pulled, [0.3], path=tmp_path / "a", stiffness=["plate"], at=[0.75], reference=file
    )
    assert study.reference["force"] == pytest.approx([4.0]) and np.isnan(study.reference["height"]).all()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"sizes": []}, "at least one size"),
        ({"sizes": [0.3], "stiffness": ["brick"]}, "brick"),
        ({"sizes": [-1.0]}, "positive"),
        ({"sizes": [0.3], "reference": {"load_factor": [0, 0.5], "force": [0, 1]}}, "spans load factors"),
        ({"sizes": [0.3], "reference": {"force": [0, 1]}}, "load_factor"),
        ({"sizes": [0.3], "reference": "no such file.csv"}, "cannot be read"),
    ],
)
def test_bad_input_is_named(options: dict, words: str, tmp_path: Path) -> None:
    with pytest.raises(kg.ModelError, match=words):
        kg.study.accuracy(pulled, path=tmp_path / "x", **({"stiffness": ["plate"]} | options))


def test_the_command_writes_table_and_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--sizes", "33mm", "--stiffness", "plate", "facet", "--folder", str(tmp_path)]
    assert main(["accuracy", *options]) == 0
    assert {"study.csv", "study.md", "study.png"} <= {file.name for file in tmp_path.iterdir()}
    assert "5 % in force" in capsys.readouterr().out
