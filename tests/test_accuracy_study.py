"""The accuracy-time study: errors, front, advice, resuming, failures as rows, bad input, and its command."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.cli import main
from kirigami.scale import Scale

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
    return kg.study.accuracy(pulled, [1.0, 0.4, 0.2], path=path, stiffness=["plate", "facet", "shell"], at=[0.5, 1.0])


def test_errors_fall_with_the_mesh_and_none_is_less_than_that_of_the_reference(study: kg.study.AccuracyStudy) -> None:
    own = study.judge.own_error("force")
    assert 0 < own < 0.05
    assert study.named.startswith("limit of shell, max_edge 0.2, 0.1549, 0.12 (its own error: ")
    for rung in ("facet", "shell"):
        rows = [row for row in study.table if row["stiffness"] == rung and row["status"] == "done"]
        errors = [study.error(row, "force") for row in rows]
        assert errors == sorted(errors, reverse=True) and errors[0] > 1.3 * errors[1]
        assert errors[-1] >= own
    # the last run of the reference differs from the limit by just what the reference adds to it
    assert study.error(list(study.table)[-1], "force") == pytest.approx(own)


def test_the_reference_is_the_limit_of_its_runs(study: kg.study.AccuracyStudy) -> None:
    """A slit makes the error one of first order; uniform tension of the sheet bounds the limit from above."""
    done = [row for row in study.table if row["stiffness"] == "shell" and row["status"] == "done"]
    runs = [study.values(row, "force") for row in done]
    assert (np.diff([values[-1] for values in runs]) < 0).all()
    assert (study.reference["force"] < runs[-1]).all()
    assert study.reference["force"][1] < 1e6 / (1 - 0.3**2) * 0.01 * 1e-4


def test_failures_are_rows(study: kg.study.AccuracyStudy) -> None:
    assert len(study.table.failed) == 3 and "too coarse on purpose" in str(study)


def test_edges_are_told_in_the_unit_of_the_sheet(study: kg.study.AccuracyStudy) -> None:
    """In the table, in the name of the reference and in the advice; as plain numbers where no unit is known."""
    told = replace(study, scale=Scale("mm"))
    assert told.named.startswith("limit of shell, max_edge 200 mm, 154.9 mm, 120 mm (")
    assert "| shell | 200 mm |" in str(told) and "| shell | 0.2 |" in str(study)
    assert "mm, " in told.recommend(10.0) and "mm" not in study.recommend(10.0)


def test_front_and_advice(study: kg.study.AccuracyStudy) -> None:
    front = study.front()
    seconds = [float(row["cpu_seconds"]) for row in front]
    errors = [study.error(row, "force") for row in front]
    assert seconds == sorted(seconds) and errors == sorted(errors, reverse=True)
    assert study.recommend(10.0).startswith("1000 % in force: ")
    assert "cannot be told; the reference itself is known to" in study.recommend(1e-6)
    figure = study.plot({"another code": {"force": (0.02, 3.0)}})
    axis = figure.axes[0].xaxis
    axis.axes.set_xlim(0.25, 7.0)
    told = axis.get_minor_formatter().format_ticks([0.3, 0.4, 0.6, 2.0, 3.0])
    assert "0.6" in told and not any("e" in text for text in told)  # it said 6e-01
    assert len(figure.axes) == 3 and "failed" in figure.get_supxlabel()


def test_it_resumes_without_running_again_and_never_with_the_runs_of_another_sheet(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same sizes and rungs, but a sheet that is thicker or pulled further: numbers of the first are none of it."""
    path = tmp_path / "small"

    def study(thickness: float, pull: float) -> kg.study.AccuracyStudy:
        def case(max_edge: float, stiffness: str):
            m = kg.Model.from_mesh(SHEET.mesh(max_edge), thickness=thickness, stiffness=stiffness)
            m.add(kg.Fix(m.select(boundary="bottom"), clamp=True))
            top = m.select(boundary="top")
            m.add(kg.Prescribe(top, x=0, y=pull, z=0, clamp=True))
            return m, top, "y"

        given = {"load_factor": [0.0, 1.0], "force": [0.0, 1.0]}
        return kg.study.accuracy(case, [0.4], path=path, stiffness=["plate"], at=[1.0], reference=given)

    first = study(0.01, 1e-4)

    def broken(analysis: kg.DisplacementControl) -> kg.Results:
        raise AssertionError("a finished run must not be repeated")

    monkeypatch.setattr(kg.DisplacementControl, "run", broken)
    assert [row["force at 1"] for row in study(0.01, 1e-4).table] == [row["force at 1"] for row in first.table]
    for thickness, pull in ((0.02, 1e-4), (0.01, 2e-4)):
        with pytest.raises(kg.AnalysisError, match="belongs to accuracy of sheet .* give another path"):
            study(thickness, pull)


def test_a_study_in_which_every_run_fails_is_an_error_that_says_why(tmp_path: Path) -> None:
    given = {"load_factor": [0.0, 1.0], "force": [0.0, 1.0]}
    with pytest.raises(kg.AnalysisError, match="no run of 2 went well, the first .* by .*too coarse on purpose"):
        kg.study.accuracy(pulled, [2.0, 1.0], path=tmp_path / "a", stiffness=["plate"], at=[1.0], reference=given)


def test_a_study_without_anything_to_compare_is_drawn_all_the_same(study: kg.study.AccuracyStudy) -> None:
    """Where no run of the reference ended, there are no errors: a logarithmic axis has nothing to begin with."""
    nothing = {name: np.full(2, np.nan) for name in ("force", "open_area", "height")}
    figure = replace(study, judge=replace(study.judge, values=nothing, errors={})).plot()
    figure.canvas.draw()
    assert [text.get_text() for ax in figure.axes for text in ax.texts] == ["nothing to compare"]


def test_a_reference_file_is_interpolated(tmp_path: Path) -> None:
    file = tmp_path / "shell.csv"
    file.write_text("# from elsewhere\nload_factor,force\n0,0\n0.5,2\n1,6\n")
    study = kg.study.accuracy(
        pulled, [0.3], path=tmp_path / "a", stiffness=["plate"], at=[0.75], reference=file
    )
    assert study.reference["force"] == pytest.approx([4.0]) and np.isnan(study.reference["height"]).all()


def test_the_error_of_a_given_reference_bounds_that_of_the_runs(tmp_path: Path) -> None:
    known = {"load_factor": [0, 1], "force": [0, 1.04], "force_error": [0.2, 0.2]}
    study = kg.study.accuracy(pulled, [0.3], path=tmp_path / "a", stiffness=["plate"], at=[1.0], reference=known)
    assert study.error(next(iter(study.table)), "force") == pytest.approx(0.2)
    assert "given values (its own error: 20 % in force)" in str(study)
    del known["force_error"]
    silent = kg.study.accuracy(pulled, [0.3], path=tmp_path / "b", stiffness=["plate"], at=[1.0], reference=known)
    assert "its own error is not stated" in str(silent)


def squeezed(max_edge: float, stiffness: str):
    """A clamped strip bent into one wave by what it rests in, or, on the coarsest mesh, into three."""
    sheet = kg.Sheet(shapely.box(0, 0, 3, 1), thickness=0.02, material=kg.Material(E=1e6, nu=0.3))
    m = kg.Model.from_mesh(sheet.mesh(max_edge), stiffness=stiffness)
    x = m.positions()[:, 0]
    m.perturb(np.sin((3 if max_edge > 0.3 else 1) * np.pi * x / 3), amplitude=0.05)
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left), kg.Prescribe(right, x=-1e-4, y=0, z=0))
    return m, right, "x"


def test_runs_on_another_shape_are_told_and_not_compared(tmp_path: Path) -> None:
    study = kg.study.accuracy(squeezed, [0.4, 0.25], path=tmp_path / "a", stiffness=["facet"], at=[1.0])
    coarse, fine = list(study.table)[:2]
    assert study.other_shape(coarse) == 1.0 and study.other_shape(fine) is None
    assert np.isnan(study.error(coarse, "force")) and np.isfinite(study.error(fine, "force"))
    assert all(row["max_edge"] != 0.4 for row in study.front())
    assert "another shape at 1" in str(study)
    assert "another shape: facet 0.4" in study.plot().get_supxlabel()


def test_prints_of_shapes_know_reflections_and_sides() -> None:
    from kirigami.study.shape.prints import print_distance, shape_print

    sheet = kg.Sheet(shapely.box(0, 0, 3, 2), thickness=0.02, material=kg.Material(E=1e6, nu=0.3))

    def shape(max_edge: float, height) -> str:
        m = kg.Model.from_mesh(sheet.mesh(max_edge))
        x, y, _ = m.positions().T
        m.perturb(height(x / 3, y / 2))
        m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.NodalLoad(m.nodes[-1], (0, 0, 1e-12)))
        return shape_print(kg.LinearStatic(m).run(), 0)

    def bump(x, y):
        return np.exp(-20 * ((x - 0.3) ** 2 + (y - 0.6) ** 2))

    one = shape(0.1, bump)
    assert print_distance(one, shape(0.14, bump)) < 0.05
    assert print_distance(one, shape(0.1, lambda x, y: -0.3 * bump(1 - x, y))) < 0.05
    assert print_distance(one, shape(0.1, lambda x, y: bump(x, 1 - y))) < 0.05
    assert print_distance(one, shape(0.1, lambda x, y: bump(x - 0.2, y))) > 0.5
    flat = shape(0.1, lambda x, y: 0 * x)
    assert flat == "flat" and print_distance(flat, one) == np.inf


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"sizes": []}, "at least one size"),
        ({"sizes": [0.3], "stiffness": ["brick"]}, "brick"),
        ({"sizes": [-1.0]}, "positive"),
        ({"sizes": [0.3], "reference": {"load_factor": [0, 0.5], "force": [0, 1]}}, "spans load factors"),
        ({"sizes": [0.3], "reference": {"force": [0, 1]}}, "load_factor"),
        ({"sizes": [0.3], "reference": "no such file.csv"}, "cannot read no such file.csv: No such file"),
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
