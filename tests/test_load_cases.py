"""Load cases: what is asked for is what is done, in Python, from a case file and on the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.results.drives import Drive
from kirigami.scale import Scale
from kirigami.study.job import read_case
from kirigami.study.measured import compare, read_measured
from kirigami.study.setting import set_up

PAPER = kg.Material(E=3e9, nu=0.3)
DRAFT: dict[str, Any] = {"accuracy": "draft", "amplitude": 0.0, "max_edge": 0.02}
pytestmark = pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")  # coarse meshes of bars


def sheet(width: float = 0.06, height: float = 0.1) -> kg.Sheet:
    return kg.Sheet(shapely.box(0, 0, width, height), (), 2e-4, PAPER)


def test_shear_moves_the_grip_across_and_its_force_is_that_of_the_strip() -> None:
    """A wide short strip in plane shear: F = G t W gamma, less what its free ends lose."""
    wide = kg.stretch(sheet(0.4, 0.02), case=kg.LoadCase(shear=5e-4), **{**DRAFT, "stiffness": "shell"})
    moved = wide.grips["moved"]
    assert wide.u[-1, wide.node_index(moved)] == pytest.approx(np.tile((1e-5, 0, 0), (len(moved), 1)), abs=1e-15)
    force = wide.drives[0].force(wide)[-1]
    ideal = 3e9 / 2.6 * 2e-4 * 0.4 * 5e-4
    assert 0.9 * ideal < force < ideal
    # The work of the drive is the energy stored: half of force times way, the sheet being linear.
    assert 0.5 * force * 1e-5 == pytest.approx(sum(values[-1] for values in wide.energy.values()), rel=1e-3)


@pytest.mark.parametrize("direction, across", [("y", (1, 0)), ("x", (0, 1)), (-90, (1, 0)), (180, (0, 1))])
def test_shear_is_towards_larger_x_or_y(direction: Any, across: tuple[float, float]) -> None:
    grips = set_up(kg.LoadCase(shear=0.1, direction=direction), sheet()).grips
    assert grips is not None and grips.sideways.tolist() == pytest.approx(across)


def test_a_mirrored_twist_is_the_mirror_image() -> None:
    cases = [kg.LoadCase(strain=1e-3, twist=twist) for twist in (20.0, -20.0)]
    right, left = (kg.stretch(sheet(), case=case, **DRAFT) for case in cases)
    assert left.drives[1].force(left) == pytest.approx(-right.drives[1].force(right), rel=1e-5, abs=1e-9)
    assert left.drives[0].force(left) == pytest.approx(right.drives[0].force(right), rel=1e-5, abs=1e-6)
    turned = right.position(right.grips["moved"])[-1]
    width = np.ptp(turned[:, [0, 2]], axis=0)
    assert width == pytest.approx(0.06 * np.array([np.cos(np.radians(20)), np.sin(np.radians(20))]))


def test_a_clamped_plate_lifted_at_its_centre() -> None:
    """F = w D / (0.0056 a^2) for a clamped square plate under a point force (Timoshenko), at small deflections."""
    plate = sheet(0.1, 0.1)
    way = 1e-5
    case = kg.LoadCase(lift={"centre": way})
    res = kg.stretch(plate, case=case, nodes=600, amplitude=0.0)
    stiffness = 3e9 * 2e-4**3 / 12 / (1 - 0.3**2)
    assert res.drives[0].force(res)[-1] == pytest.approx(way * stiffness / (0.0056 * 0.1**2), rel=0.03)
    lifted = res.grips["lifted centre"]
    assert len(lifted) == 1 and res.rest[res.node_index(lifted)[0], :2] == pytest.approx((0.05, 0.05))
    total = res.reaction(lifted, "z") + res.reaction(res.grips["held rim"], "z")
    assert np.abs(total).max() < 1e-6 * np.abs(res.reaction(lifted, "z")).max()


def test_a_push_is_a_lift_downwards_and_regions_move_as_one() -> None:
    where = {"disc": (0.03, 0.05, 0.01), "box": (0.02, 0.04, 0.04, 0.06), "shape": shapely.box(0.02, 0.04, 0.04, 0.06)}
    for kind, place in where.items():
        case = kg.LoadCase(lift={place: -1e-4} if kind != "shape" else [(place, -1e-4)], hold=["left", ("right", "z")])
        res = kg.stretch(sheet(), case=case, **DRAFT)
        name = next(name for name in res.grips if name.startswith("lifted"))
        index = res.node_index(res.grips[name])
        assert len(index) >= 4 and res.u[-1, index, 2] == pytest.approx(-1e-4)
        assert res.drives[0].force(res)[-1] < 0
        assert kind == "shape" or res.drives[0].title(Scale()).startswith(f"lift of the {kind} (0.0")
        right = res.node_index(res.grips["held right"])
        assert np.abs(res.u[-1, right, 2]).max() == 0 < np.abs(res.u[-1, right, 0]).max()


def test_axes_name_each_unit_once() -> None:
    """What is lifted may be named by coordinates, which have the unit of the way itself."""
    for name in ("lifted 0.06, 0.02", "lifted 0.03, 0.05, 0.01", "lifted centre"):
        drive = Drive("lift", name, name, "length", 1e-3, np.array([0.0, 0.0, 1.0]))
        motion, response = drive.titles(Scale("mm"))
        assert motion.endswith(" [mm]") and motion.count("mm") == 1 and response.endswith(" [N]")
        assert [title.count("[") for title in drive.titles(Scale())] == [0, 0]
    assert Drive("lift", "lifted 0.06,0.02", "", "length", 1e-3, np.zeros(3)).titles(Scale("mm")) == (
        "lift of the point (60, 20) [mm]", "force at the point (60, 20) mm [N]"
    )  # fmt: skip


def test_a_sheet_lifted_under_its_own_weight() -> None:
    """The supports bear weight and lift together, at every step; without a density the weight is refused."""
    heavy = kg.Sheet(shapely.box(0, 0, 0.06, 0.1), (), 2e-4, kg.Material(E=3e9, nu=0.3, density=1200.0))
    case = kg.LoadCase(lift={"centre": 1e-3}, hold=[("rim", "xyz")], weight=9.81)
    res = kg.stretch(heavy, case=case, **{**DRAFT, "accuracy": "standard"})
    borne = res.reaction(res.grips["lifted centre"], "z") + res.reaction(res.grips["held rim"], "z")
    assert borne == pytest.approx(1200 * 9.81 * 2e-4 * 0.06 * 0.1, rel=1e-5)
    with pytest.raises(kg.KirigamiError, match="density"):
        kg.stretch(sheet(), case=case, **DRAFT)


def test_a_sheet_under_its_own_weight_alone(tmp_path: Path) -> None:
    """Sag 0.00126 q a^4 / D of a clamped square plate (Timoshenko) at small deflections; the case file keeps it."""
    light = kg.Material(E=3e9, nu=0.3, density=0.02)
    heavy = kg.Sheet(shapely.box(0, 0, 0.1, 0.1), (), 2e-4, light)
    case = kg.LoadCase(strain=0, weight=9.81)
    res = kg.stretch(heavy, case=case, nodes=400, amplitude=0.0)
    stiffness = 3e9 * 2e-4**3 / 12 / (1 - 0.3**2)
    load = 0.02 * 9.81 * 2e-4
    (weight,) = res.drives
    sag = weight.force(res)
    assert (weight.motion, weight.answer, weight.answer_kind) == ("weight", "sag", "length") and sag[0] == 0
    assert sag[-1] == pytest.approx(0.00126 * load * 0.1**4 / stiffness, rel=0.02)
    assert res.reaction(res.grips["held rim"], "z") == pytest.approx(load * 0.01 * res.lam, rel=1e-6, abs=1e-12)
    assert kg.LoadCase.from_plain(json.loads(json.dumps(case.plain()))).values() == case.values()


def test_a_sheet_may_be_pulled_and_lifted_at_once() -> None:
    res = kg.stretch(sheet(), case=kg.LoadCase(strain=1e-3, lift={"centre": 1e-3}), **DRAFT)
    assert [drive.motion for drive in res.drives] == ["strain", "lift"] and (res.drives[1].force(res)[1:] > 0).all()


@pytest.mark.parametrize(
    "case, complaint",
    [
        ({"strain": 0}, "other than zero"), ({"strain": -1}, "through the other"),
        ({"lift": {"centre": 0}}, "by nothing"),
        ({"lift": {"nowhere": 1}}, "no place: say left, right"), ({"lift": {(1, 2, 3, 4, 5): 1}}, "4 a box"),
        ({"lift": {(0, 0, -1): 1}}, "no radius"), ({"lift": {(1, 1, 0, 0): 1}}, "is empty"),
        ({"hold": [("rim", "sideways")]}, "'clamp', or along axes"), ({"lift": [("centre",)]}, "pairs of a place"),
        ({"weight": -1.0}, "negative"),
        ({"twist": 1e9}, "more than 100 turns"), ({"shear": float("nan")}, "finite"), ({"direction": "z"}, "direction"),
    ],
)  # fmt: skip
def test_cases_that_make_no_sense(case: dict[str, Any], complaint: str) -> None:
    with pytest.raises(kg.ModelError, match=complaint):
        kg.LoadCase(**case)


@pytest.mark.parametrize(
    "case, complaint",
    [
        (kg.LoadCase(lift={(0.2, 0.2): 1e-3}), "not on the sheet"),
        (kg.LoadCase(lift={"layer:marks": 1e-3}), "needs a drawing"),
        (kg.LoadCase(lift={"cut:3": 1e-3}), "no boundary or set"),
        (kg.LoadCase(lift={"left": 1e-3}, hold="left"), "held, but nodes of it are lifted left"),
        (kg.LoadCase(lift={"top": 1e-3}, strain=0.1), "the moved grip holds nodes of it"),
        (kg.LoadCase(strain=0.1, hold="top"), "wholly in what is held already"),
    ],
)
def test_places_that_are_not_there(case: kg.LoadCase, complaint: str) -> None:
    with pytest.raises(kg.ModelError, match=complaint):
        kg.stretch(sheet(), case=case, **DRAFT)


def test_a_case_beside_its_own_arguments_is_refused() -> None:
    with pytest.raises(kg.ModelError, match="not beside it"):
        kg.stretch(sheet(), 0.1, case=kg.LoadCase())


# ---- case files


def drawn(folder: Path) -> Path:
    return sheet().to_dxf(folder / "drawings" / "plate.dxf", unit="m")


def test_a_case_file_runs_the_same_job_from_anywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    case = kg.LoadCase(strain=1e-3, lift=[("20mm,50mm,5mm", 1e-3)], hold=[("left", "z")], cycle=True)
    job = kg.study.Job(drawn(tmp_path), "0.2mm", "3GPa", case=case, accuracy="draft", max_edge="20mm")
    file = job.save(tmp_path / "cases" / "one.json")
    monkeypatch.chdir(tmp_path / "cases")
    again = kg.study.Job.load("one.json")
    assert repr(again.case) == repr(case) and again.max_edge == "20mm"
    first, second = job.run(), again.run()
    assert first.numbers["last_force"] == second.numbers["last_force"] and first.complete
    assert json.loads(file.read_text())["drawing"] == "../drawings/plate.dxf"


@pytest.mark.parametrize(
    "change, complaint",
    [
        ({"kind": "shopping list"}, "no case file"), ({"drawing": 5}, "no case file"),
        ({"extra": 1}, "no entry 'extra'"), ({"computation": {"speed": "high"}}, "takes accuracy"),
        ({"case": {"strian": 0.1}}, "no entry 'strian'"), ({"case": {"lift": 5}}, "must be a list"),
        ({"case": {"lift": [{"at": "rim"}]}}, "'at' and 'by'"), ({"sheet": {"thickness": "1mm"}}, "says no E"),
        ({"sheet": {"thickness": "thin", "E": 1e9}}, "no length"),
        ({"computation": {"accuracy": "best"}}, "accuracy"), ({"reading": 3}, "options of the reader"),
    ],
)  # fmt: skip
def test_case_files_that_make_no_sense(change: dict[str, Any], complaint: str, tmp_path: Path) -> None:
    good = {"kind": "kirigami case", "drawing": "plate.dxf", "sheet": {"thickness": "1mm", "E": "1GPa"}}
    file = tmp_path / "case.json"
    file.write_text(json.dumps(good))
    assert "thickness" in read_case(file)
    file.write_text(json.dumps({**good, **change}))
    with pytest.raises(kg.ModelError, match=complaint):
        kg.study.Job.load(file)
    file.write_text('{"kind": ')
    with pytest.raises(kg.GeometryError, match="no case file: .* in line 1"):
        kg.study.Job.load(file)


def test_marks_in_a_drawing_are_places_and_no_cuts(tmp_path: Path) -> None:
    svg = """<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
     width="60mm" height="100mm" viewBox="0 0 60 100">
    <g inkscape:groupmode="layer" inkscape:label="outline"><rect x="0" y="0" width="60" height="100" fill="none"
     stroke="black"/></g>
    <g inkscape:groupmode="layer" inkscape:label="hook"><rect x="20" y="60" width="20" height="10" fill="none"
     stroke="red"/></g></svg>"""
    file = tmp_path / "marked.svg"
    file.write_text(svg)
    job = kg.study.Job(file, 2e-4, 3e9, case=kg.LoadCase(lift={"layer:hook": 1e-3}), accuracy="draft", max_edge=0.02)
    report = job.run()
    assert report.numbers["cuts"] == 0
    held = report.results.rest[report.results.node_index(report.results.grips["lifted layer:hook"])]
    assert held.min(axis=0)[:2] == pytest.approx((0.02, 0.03)) and held.max(axis=0)[:2] == pytest.approx((0.04, 0.04))
    other = kg.study.Job(file, 2e-4, 3e9, case=kg.LoadCase(hold="layer:eye", strain=0.1))
    with pytest.raises(kg.GeometryError, match="no curve is on a layer or has a colour 'eye'"):
        other.run()


# ---- measured curves


def test_a_measured_curve_is_held_against_the_computed_one(tmp_path: Path) -> None:
    report = kg.study.Job(drawn(tmp_path), 2e-4, 3e9, case=kg.LoadCase(1e-3), accuracy="draft", max_edge=0.02).run()
    ways = 1e3 * report.free_length * report.motion  # mm
    file = tmp_path / "test.csv"
    rows = [f"{way:.9g};{force + 2.0:.9g}" for way, force in zip(ways, report.force)]
    file.write_text("\n".join(["# machine 3", "Extension [mm];Load [N]", *rows, "5;100"]))
    found = compare(report, read_measured(file))
    assert found.rms == pytest.approx(2.0, rel=1e-6) and found.beyond == 1
    strains = [f"{100 * strain:.9g},{1e3 * force:.9g}" for strain, force in zip(report.motion, report.force)]
    file.write_text("\n".join(["strain (%),force (mN)", *strains]))
    assert compare(report, read_measured(file)).rms == pytest.approx(0, abs=1e-6)
    file.write_text("angle [deg],torque [N m]\n0,0\n1,1\n")
    with pytest.raises(kg.ModelError, match="measured over angle"):
        compare(report, read_measured(file))


@pytest.mark.parametrize(
    "text, complaint",
    [
        ("", "is empty"), ("a,b\n1,2\n", "no column is called"), ("displacement,force [N]\n1,2\n", "says no unit"),
        ("displacement [mm],force [furlong]\n1,2\n", "not understood"),
        ("force [N],time [s]\n1,2", "displacement, strain"),
        ("displacement [mm],force [N]\n1,two\n", "line 2 has no number for 'force"),
        ("displacement [mm],force [N]\n1,2\n", "at least two points"), ("angle,torque [Nm]\n1,2\n", "degrees or rad"),
        ("displacement [mm],force [N]\n1\n", "line 2"), ("displacement [mm],force [N]\n0,0\n1,nan\n", "finite"),
    ],
)  # fmt: skip
def test_measured_curves_that_are_not_understood(text: str, complaint: str, tmp_path: Path) -> None:
    file = tmp_path / "test.csv"
    file.write_text(text)
    with pytest.raises(kg.GeometryError, match=complaint):
        read_measured(file)
