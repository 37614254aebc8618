"""Every writer of results and models and every study, on every rung that it serves.

The rows come from the public names: methods that begin with ``to_``, ``save``, and the functions of ``kg.study``.
"""

from __future__ import annotations

import csv
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from structures import BUILT, SAME, SHEETS, STRUCTURES, from_the_ground, loaded, results

import kirigami as kg

# Writers of results: needs a mesh or not, and the files one call makes.
WRITERS: dict[str, tuple[bool, str]] = {
    "save": (False, "run.npz"),
    "to_csv": (False, "run.csv"),
    "to_html": (False, "run.html"),
    "to_surface": (True, "run.stl"),
    "to_vtk": (False, "vtk"),
}
NO_WRITER = {"to_xarray": "an object in memory of an extra library, tested in tests/io"}
MODEL_WRITERS = {"to_abaqus": "sheet.inp", "to_openseespy": "sheet.py"}


def content(path: Path) -> dict[str, bytes]:
    """What was written, file by file."""
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    return {file.name: file.read_bytes() for file in files}


def test_every_writer_has_a_row() -> None:
    of_results = {name for name in dir(kg.Results) if name.startswith("to_")} | {"save"}
    assert of_results == {*WRITERS, *NO_WRITER}
    assert {name for name in dir(kg.Model) if name.startswith("to_")} == set(MODEL_WRITERS)


@pytest.mark.parametrize("writer", WRITERS)
@pytest.mark.parametrize("structure", STRUCTURES)
def test_loaded_results_write_the_same_files(structure: str, writer: str, tmp_path: Path) -> None:
    """What needs a mesh is refused where there is none; all else is the same from memory and from a file."""
    needs_mesh, name = WRITERS[writer]
    run, back = results(structure), loaded(structure)
    if needs_mesh and structure in BUILT:
        with pytest.raises(kg.KirigamiError, match="mesh"):
            getattr(run, writer)(tmp_path / name)
        return
    written = []
    for number, one in enumerate((run, back)):
        folder = tmp_path / str(number)
        folder.mkdir()
        getattr(one, writer)(folder / name)
        written.append(content(folder / name))
    if writer == "save":  # a container with times in it: read once more
        again = kg.load(tmp_path / "1" / name)
        assert np.array_equal(again.u, run.u) and np.array_equal(again.lam, run.lam)
    else:
        assert written[0] == written[1] and all(written[0].values())


@pytest.mark.parametrize("structure", STRUCTURES)
def test_the_table_holds_what_results_tell(structure: str, tmp_path: Path) -> None:
    run = results(structure)
    with open(run.to_csv(tmp_path / "run.csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["load_factor"]) for row in rows] == run.lam.tolist()
    for axis in "xyz"[: run.dim]:
        assert [float(row[f"reaction_driven_0_{axis}"]) for row in rows] == run.reaction("driven_0", axis).tolist()
    stored = sum(float(value) for key, value in rows[-1].items() if key.startswith("energy_"))
    assert stored == pytest.approx(sum(run.energy.values())[-1], rel=1e-12)


@pytest.mark.parametrize("writer", MODEL_WRITERS)
@pytest.mark.parametrize("structure", STRUCTURES)
def test_shell_codes_get_the_same_sheet_from_every_rung(structure: str, writer: str, tmp_path: Path) -> None:
    m = STRUCTURES[structure](SAME)
    if structure not in SHEETS:
        with pytest.raises(kg.ModelError):
            getattr(m, writer)(tmp_path / MODEL_WRITERS[writer])
        return
    text = getattr(m, writer)(tmp_path / MODEL_WRITERS[writer]).read_text()
    (tmp_path / "other").mkdir()
    other = getattr(SHEETS["plate"](SAME), writer)(tmp_path / "other" / MODEL_WRITERS[writer]).read_text()
    assert text == other


# ---- studies


def pulled(length: float) -> Callable[[float, str], Any]:
    """A strip with a slit, pulled, in a unit of length; the same mesh in every unit."""

    def case(max_edge: float, stiffness: str) -> tuple[kg.Model, list[kg.Node], str]:
        slit = np.array([(0.3, 0.55), (0.7, 0.5)]) * length
        square = length * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
        sheet = kg.Sheet(square, [slit], 0.05 * length, kg.Material(1e6 / length**2, 0.3))
        m = kg.Model.from_mesh(sheet.mesh(max_edge), stiffness=stiffness)
        top = m.select(boundary="top")
        m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.Prescribe(top, x=0, y=0.01 * length, z=0))
        return m, top, "y"

    return case


def estimated(rung: str, length: float, folder: Path) -> list[float]:
    m, *_ = pulled(length)(0.6 * length, rung)
    estimate = kg.study.estimate_error(kg.DisplacementControl(m, tol=1e-10).run())
    return [estimate.relative, *(estimate.worst(3) / length).ravel()]


def chosen(rung: str, length: float, folder: Path) -> list[float]:
    choice = kg.study.choose_mesh(pulled(length), 0.7 * length, 0.3, stiffness=rung, most=3)
    return [choice.limit, *choice.errors]  # forces


def bracketed(rung: str, length: float, folder: Path) -> list[float]:
    other = "plate" if rung == "facet" else "facet"
    band = kg.study.bracket(pulled(length), 0.6 * length, stiffness=(rung, other))
    return [band.low, band.high]


def accurate(rung: str, length: float, folder: Path) -> list[float]:
    study = kg.study.accuracy(
        pulled(length), [0.6 * length], path=folder / "study", stiffness=[rung], at=[1.0],
        reference={"load_factor": [0.0, 1.0], "force": [0.0, 100.0]},
    )  # fmt: skip
    return [study.error(next(iter(study.table)), "force")]


def seeded(rung: str, length: float, folder: Path) -> list[float]:
    m, *_ = pulled(length)(0.6 * length, rung)
    return np.abs(kg.study.seeds(m, 2)[0]).ravel().tolist()


def branched(rung: str, length: float, folder: Path) -> list[float]:
    m, top, _ = pulled(length)(0.6 * length, rung)
    study = kg.study.branches(m, modes=1, amplitude=1e-3 * length)
    return [case.branch for case in study.cases] + [case.height / length for case in study.cases]


def imperfect(rung: str, length: float, folder: Path) -> list[float]:
    m, *_ = pulled(length)(0.6 * length, rung)
    study = kg.study.imperfections(m, modes=1, amplitudes=[1e-3 * length], signs=[1])
    return [study.cases[0].energy / length]


def searched(rung: str, length: float, folder: Path) -> list[float]:
    m, *_ = pulled(length)(0.6 * length, rung)
    study = kg.study.shapes(m, at=1.0, trials=2, followed=0)
    return [shape.energy / length for shape in study]


STUDIES: dict[str, Callable[[str, float, Path], list[float]]] = {
    "estimate_error": estimated,
    "choose_mesh": chosen,
    "bracket": bracketed,
    "accuracy": accurate,
    "seeds": seeded,
    "branches": branched,
    "imperfections": imperfect,
    "shapes": searched,
}
NO_STUDY = {
    "stretch_drawing": "the job of the command line",
    "write_report": "the job of the command line",
    "place": "a place on a sheet, not a study",
    "read_measured": "reads a file",
    "compare": "holds a report against a measured curve",
}


def test_every_study_has_a_row() -> None:
    functions = {name for name in kg.study.__all__ if inspect.isfunction(getattr(kg.study, name))}
    assert functions == {*STUDIES, *NO_STUDY}


@pytest.mark.parametrize("study", STUDIES)
@pytest.mark.parametrize("rung", SHEETS)
def test_a_study_does_not_know_the_unit_of_length(rung: str, study: str, tmp_path: Path) -> None:
    found = []
    for length in (1.0, 1000.0):
        folder = tmp_path / f"{length:g}"
        folder.mkdir()
        try:
            found.append(STUDIES[study](rung, length, folder))
        except kg.AnalysisError as error:  # runs on different branches: the same word in every unit
            found.append([float(type(error) is kg.AnalysisError)])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("structure", STRUCTURES)
def test_a_load_on_every_node_reaches_the_supports(structure: str) -> None:
    """Each node bears it once, on every rung."""
    m = STRUCTURES[structure](SAME)
    (load,), held = m.loads, m.index(node for item in m.constraints for node in item.group)
    m.remove(load)
    m.add(kg.NodalLoad(m.nodes, (1e-3, 2e-3)))
    run = kg.LinearStatic(m).run()
    total = -run.reaction(held)[-1] - from_the_ground(run, -1).sum(axis=0)
    np.testing.assert_allclose(total, len(m.nodes) * np.array([1e-3, 2e-3, 0.0]), rtol=1e-7, atol=1e-9)


