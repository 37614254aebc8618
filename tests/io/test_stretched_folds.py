"""Drawings with folds on their way through kg.stretch and the command line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami import cli
from kirigami.study.run_job import stretch_drawing

SHEET = shapely.box(0, 0, 0.05, 0.1)
LINES = [[(0, y), (0.05, y)] for y in (0.025, 0.05, 0.075)]
PAPER = kg.Material(E=3e9, nu=0.3)


def accordion(angle: float, stiffness: float | None = None) -> kg.Sheet:
    """Two valleys and a mountain across the pull."""
    folds = [kg.Fold(line, side * angle, stiffness) for line, side in zip(LINES, (1, -1, 1))]
    return kg.Sheet(SHEET, (), 1e-4, PAPER, folds)


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
@pytest.mark.parametrize("stiffness", ["facet", "shell"])
def test_a_folded_sheet_is_pulled_from_where_it_rests(stiffness: str) -> None:
    """No force at first; then the work of the grip is the energy that is stored; far softer than the flat sheet."""
    said: list[str] = []
    res = kg.stretch(accordion(0.8), 0.05, nodes=40, stiffness=stiffness, say=said.append)
    force = res.reaction(res.grips["moved"], "y")
    energy = np.sum(list(res.energy.values()), axis=0)
    assert abs(force[0]) < 1e-6 * force[-1]
    work = np.trapezoid(force, 0.005 * res.lam)
    assert energy[-1] - energy[0] == pytest.approx(work, rel=0.02)
    assert any(words.startswith("folded: the grips are 9") for words in said)
    flat = kg.stretch(accordion(0.0), 0.05, nodes=40, stiffness=stiffness)
    assert force[-1] < 1e-2 * flat.reaction(flat.grips["moved"], "y")[-1]


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
def test_a_lift_counts_from_the_folded_sheet() -> None:
    case = kg.LoadCase(lift={"top": 0.002}, hold="bottom")
    res = kg.stretch(accordion(0.5), case=case, nodes=40, stiffness="plate")
    top = res.grips["lifted top"]
    height = res.position(top)[:, :, 2]
    assert height[-1] - height[0] == pytest.approx(0.002)
    assert abs(height[0]).max() > 0.002  # it was folded before


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
@pytest.mark.parametrize("stiffness", ["plate", "shell"])
def test_a_folded_sheet_is_twisted_from_where_it_rests(stiffness: str) -> None:
    """The grip slides while the sheet folds, then turns about where it is, without torque at first; the work of the
    torque is the energy stored; a twist to the other side is the mirror image of a sheet folded to the other side."""
    both = []
    for side in (1, -1):
        case = kg.LoadCase(twist=20 * side)
        res = kg.stretch(accordion(0.5 * side), case=case, nodes=40, stiffness=stiffness, amplitude=0.0)
        torque = res.drives[0].force(res)
        energy = np.sum(list(res.energy.values()), axis=0)
        grip = res.u[:, res.node_index(res.grips["moved"])]
        assert np.ptp(grip[0], axis=0).max() < 1e-12 and grip[0, 0, 1] < -1e-3
        assert abs(torque[0]) < 1e-5 * abs(torque[-1])
        assert energy[-1] - energy[0] == pytest.approx(np.trapezoid(torque, np.radians(20 * side) * res.lam), rel=0.03)
        both.append(torque)
    assert both[0] == pytest.approx(-both[1], rel=1e-3, abs=1e-6 * abs(both[0][-1]))


def pattern(folder: Path) -> Path:
    path = folder / "accordion.fold"
    accordion(0.3).to_fold(path)
    return path


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
def test_folds_of_a_drawing_are_hinges_of_the_model(tmp_path: Path) -> None:
    """Flat unless an angle is said; what is done about them is told; softer folds, softer sheet."""
    options = {"thickness": "0.1mm", "E": "3GPa", "strain": -0.01, "nodes": 40, "stiffness": "plate"}
    forces = []
    for stiffness in ("0.1mN", None, "1N"):
        report = stretch_drawing(pattern(tmp_path), fold_stiffness=stiffness, **options)
        assert any(note.startswith("3 folds as elastic hinges, at rest flat") for note in report.notes)
        forces.append(-report.force[-1])
    assert 0 < forces[0] < forces[1] < forces[2]
    folded = stretch_drawing(pattern(tmp_path), fold_angle=30.0, **options)
    assert any("folded by up to 30 degrees, 2 as valleys and 1 as mountain" in note for note in folded.notes)


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
def test_folds_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    common = ["stretch", str(pattern(tmp_path)), *"--thickness 0.1mm --E 3GPa --strain 1% --nodes 40".split()]
    folder = tmp_path / "out"
    assert cli.main([*common, "--fold-angle", "40", "--fold-stiffness", "1mN", "--folder", str(folder), "--quiet"]) == 0
    assert json.loads((folder / "case.json").read_text())["sheet"]["fold_angle"] == 40
    for name, value in (("angle", "200"), ("angle", "steep"), ("stiffness", "-1N"), ("stiffness", "2mm")):
        with pytest.raises(SystemExit) as usage:
            cli.main([*common, f"--fold-{name}={value}"])
        assert usage.value.code == 2
    capsys.readouterr()
