"""The search for stable shapes: complete where the shapes are known, each counted once, the same whoever computes."""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.model.from_mesh import on_rung
from kirigami.study.shape.relaxation import Relaxer
from kirigami.study.shape.space import ShapeSpace, is_flat_sheet
from kirigami.study.shape.trials import Descents

LOAD = -1e-3


def chain(heights: list[float]) -> kg.Model:
    """Von Mises trusses side by side, EA = 1, half-span 1, that know nothing of each other; a load on each apex."""
    m = kg.Model(dim=2)
    for k, height in enumerate(heights):
        left, apex, right = m.add(kg.Node(3 * k - 1, 0), kg.Node(3 * k, height), kg.Node(3 * k + 1, 0))
        m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0), kg.Fix([left, right]))
        m.add(kg.NodalLoad(apex, (0, LOAD)))
    return m


def energies_of(height: float) -> list[float]:
    """Potentials of the two stable shapes of a truss: (z^2 - h^2)^2 / (4 L^3) - load (z - h), L^2 = 1 + h^2."""
    cube = (1 + height**2) ** 1.5
    roots = np.roots([1 / cube, 0, -(height**2) / cube, -LOAD])
    places = roots[np.abs(roots.imag) < 1e-12].real
    stable = places[3 * places**2 > height**2]
    assert len(stable) == 2
    return [float((z**2 - height**2) ** 2 / (4 * cube) - LOAD * (z - height)) for z in stable]


@pytest.mark.parametrize("heights", [[0.5], [0.5, 0.4], [0.5, 0.4, 0.6]])
def test_n_trusses_have_two_to_the_n_shapes(heights: list[float]) -> None:
    found = kg.study.shapes(chain(heights), trials=16 * 2 ** (len(heights) - 1), mirrors="")
    expected = sorted(sum(part) for part in itertools.product(*map(energies_of, heights)))
    assert [shape.energy for shape in found] == pytest.approx(expected, rel=1e-9)
    assert all(shape.step.stable and shape.step.residual <= 1e-8 for shape in found)
    assert [shape.number for shape in found] == list(range(1, len(found) + 1))
    assert sum(shape.times for shape in found) >= len(found.trials)


def test_equal_cells_count_once() -> None:
    """Three equal trusses: by the number that hang; of the three arrangements of each, two are mirror images."""
    found = kg.study.shapes(chain([0.5] * 3), trials=60)
    up, down = energies_of(0.5)[::-1] if energies_of(0.5)[0] < energies_of(0.5)[1] else energies_of(0.5)
    expected = sorted(hanging * down + (3 - hanging) * up for hanging in range(4))
    assert [shape.energy for shape in found] == pytest.approx(expected, rel=1e-9)
    assert [shape.arrangements for shape in found] == [1, 2, 2, 1]
    assert len(kg.study.shapes(chain([0.5] * 3), trials=60, mirrors="")) == 8


def test_a_column_that_buckles_to_either_side() -> None:
    """Two nearly rigid links of length 1 and a spring k: energy k (2 a)^2 / 2 and force 2 k a / sin a, at squeeze
    2 (1 - cos a)."""
    m = kg.Model(dim=2)
    bottom, middle, top = m.add(kg.Node(0, 0), kg.Node(0, 1), kg.Node(0, 2))
    m.add(kg.Bar(bottom, middle, 1e7), kg.Bar(middle, top, 1e7), kg.TorsionSpring3(bottom, middle, top, 1.0))
    m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.Prescribe(top, y=-0.2))
    found = kg.study.shapes(m, trials=12)
    angle = np.arccos(0.9)
    (shape,) = found
    assert shape.energy == pytest.approx(2 * angle**2, rel=1e-5)
    assert abs(shape.force) == pytest.approx(2 * angle / np.sin(angle), rel=1e-5)
    assert len(kg.study.shapes(m, trials=12, mirrors="")) == 2


def two_slits(stiffness: str = "plate") -> kg.Model:
    sheet = kg.Sheet(
        shapely.box(0, 0, 0.06, 0.06),
        [[(0.0, 0.02), (0.045, 0.02)], [(0.015, 0.04), (0.06, 0.04)]],
        thickness=2e-4,
        material=kg.Material(E=3.5e9, nu=0.34),
    )
    m = kg.Model.from_mesh(sheet.mesh(0.012, cut_edge=0.01), stiffness=stiffness)
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=0.006))
    return m


@pytest.fixture(scope="module")
def sheet_study() -> kg.study.ShapeStudy:
    return kg.study.shapes(two_slits(), trials=8, followed=1, most=1)


def test_shapes_of_a_sheet(sheet_study: kg.study.ShapeStudy) -> None:
    """Stable equilibria that an analysis takes; the force is the reaction of the grip; mirror images are the shape."""
    found, m = sheet_study, sheet_study.model
    assert len(found) > 1 and [s.energy for s in found] == sorted(s.energy for s in found)
    top = m.select(boundary="top")
    for shape in found[:2]:
        back = kg.DisplacementControl(m, start=shape.step, to=0.99).run()
        assert back[0].stable and np.abs(back[0].u - shape.step.u).max() < 1e-6
        assert back.reaction(top, "y")[0] == pytest.approx(shape.force, rel=1e-6)
        assert sum(values[0] for values in back.energy.values()) == pytest.approx(shape.energy, rel=1e-9)
        assert found.which(back[0]) is shape
        over = kg.Step.at(m, 1.0, shape.step.u * [1, 1, -1])
        assert found.which(over) is shape
    words = " ".join(found.words(found[-1].step))
    assert f"number {len(found)} of {len(found)} known" in words and "lower" in words and "forces" in words
    assert f"{len(found)} shapes" in str(found) and len(found.table()["energy"]) == len(found)
    found.plot()


def test_the_trusted_rung(sheet_study: kg.study.ShapeStudy) -> None:
    """A shape carried to "shell" is a stable equilibrium there: an analysis of a model made on that rung takes it."""
    first = sheet_study[0]
    assert first.trusted is not None and first.trusted.step.stable
    shell = two_slits("shell")
    back = kg.DisplacementControl(shell, start=first.trusted.step, to=0.99).run()
    assert np.abs(back[0].u - first.trusted.step.u).max() < 1e-6
    assert sum(values[0] for values in back.energy.values()) == pytest.approx(first.trusted.energy, rel=1e-8)


def test_a_model_on_the_trusted_rung_is_searched_on_the_cheap_one(sheet_study: kg.study.ShapeStudy) -> None:
    shell = two_slits("shell")
    end = kg.Step.at(shell, 1.0, sheet_study[0].step.u)
    found = kg.study.shapes(shell, trials=2, most=1, followed=0, starts=[end])
    assert found.searched == "plate" and found[0].step.inner.size and found[0].step.stable
    assert any(shape.reached_by == "given" for shape in found)
    assert found[0].energy == pytest.approx(sheet_study[0].trusted.energy, rel=1e-6)  # type: ignore[union-attr]


def test_a_descent_goes_on_as_long_as_it_goes_down(
    sheet_study: kg.study.ShapeStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The number of iterations of one descent is no bound of the way to a shape: a thin locked disc takes hundreds."""
    m = sheet_study.model
    start = sheet_study[0].step.u * [1, 1, 1.2]
    reached = Relaxer(m, 1.0, 1e-8).relax(start)
    monkeypatch.setattr("kirigami.analysis.path.run.MAX_RELAXATION", 5)
    monkeypatch.setattr("kirigami.study.shape.relaxation.MAX_RELAXATION", 5)
    again = Relaxer(m, 1.0, 1e-8).relax(start)
    assert again.step.stable and again.energy == pytest.approx(reached.energy, rel=1e-9)
    monkeypatch.setattr("kirigami.study.shape.relaxation.ROUNDS", 1)
    with pytest.raises(kg.ConvergenceError, match="too many iterations"):
        Relaxer(m, 1.0, 1e-8).relax(start)


def test_the_branch_that_was_followed(sheet_study: kg.study.ShapeStudy) -> None:
    """Energy against the pull rises with the force: dU / d lam = force times the displacement of the grip."""
    (branch,) = sheet_study.branches
    assert branch.lam[0] < 1.0 < branch.lam[-1] and np.all(np.diff(branch.lam) > 0)
    work = np.concatenate([[0], np.cumsum(np.diff(branch.lam) * 0.003 * (branch.force[1:] + branch.force[:-1]))])
    rise = branch.energy - branch.energy[0]
    assert np.abs(work - rise).max() < 0.02 * rise.max()


def test_another_rung_is_the_same_model() -> None:
    """A copy on another rung answers as a model made on it, imperfection and supports included."""
    m = two_slits()
    m.imperfect(seed=3)
    twin, made = on_rung(m, "facet"), two_slits("facet")
    made.perturb(m.positions() - made.positions())
    answers = [kg.DisplacementControl(model, to=0.02).run() for model in (twin, made)]
    assert np.allclose(answers[0].u[-1], answers[1].u[-1], rtol=0, atol=1e-12)
    assert twin.sheet_constants is not None and twin.sheet_constants.rung == "facet" and len(m.elements) != 0
    assert {type(item).__name__ for item in m.sheet_elements} == {"Bar", "BendHinge"}


def test_an_imperfect_sheet_is_flat_and_a_dome_is_not(sheet_study: kg.study.ShapeStudy) -> None:
    """A sheet with its imperfection buckles to either side, so mirror images in its plane are one shape of it."""
    m = two_slits()
    m.imperfect(amplitude=1e-4)
    assert is_flat_sheet(m) and ShapeSpace(m).distance(sheet_study[0].step.u, sheet_study[0].step.u * [1, 1, -1]) == 0
    x, y, _ = m.positions().T
    m.perturb(np.sin(np.pi * x / 0.06) * np.sin(np.pi * y / 0.06), amplitude=0.01)
    assert not is_flat_sheet(m)


def arguments(path: Path | None = None) -> dict[str, Any]:
    return {"trials": 24, "mirrors": "", "path": path}


def test_it_goes_on_where_it_was_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C in the tenth trial keeps what was found; the same call then finds what one without it finds."""
    whole = kg.study.shapes(chain([0.5, 0.4]), **arguments())
    path, descend, done = tmp_path / "search.jsonl", Descents.__call__, []

    def interrupted(self: Descents, start: str, share: float) -> Any:
        done.append(start)
        if len(done) == 10:
            raise KeyboardInterrupt
        return descend(self, start, share)

    monkeypatch.setattr(Descents, "__call__", interrupted)
    with pytest.warns(kg.KirigamiWarning, match="interrupted"):
        part = kg.study.shapes(chain([0.5, 0.4]), **arguments(path))
    assert len(part) >= 1 and len(part.trials) == 8 and "interrupted" in str(part)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([*lines[:-1], lines[-1][:40]]))  # as a power cut leaves it
    monkeypatch.setattr(Descents, "__call__", descend)
    again = kg.study.shapes(chain([0.5, 0.4]), **arguments(path))
    assert [row["reached_by"] for row in again.trials] == [row["reached_by"] for row in whole.trials]
    assert [shape.energy for shape in again] == [shape.energy for shape in whole]
    assert len(path.read_text().splitlines()) == 25
    with pytest.raises(kg.AnalysisError, match="another model"):
        kg.study.shapes(chain([0.5, 0.45]), **arguments(path))


def test_the_same_shapes_whoever_computes() -> None:
    one = kg.study.shapes(chain([0.5, 0.4]), **arguments())
    with ThreadPoolExecutor(2) as pool:
        two = kg.study.shapes(chain([0.5, 0.4]), **arguments(), executor=pool)
    assert [shape.energy for shape in one] == [shape.energy for shape in two]
    assert [row["reached_by"] for row in one.trials] == [row["reached_by"] for row in two.trials]
    three = kg.study.shapes(chain([0.5, 0.4]), **arguments(), workers=2)
    assert [shape.energy for shape in one] == [shape.energy for shape in three]
    assert [row["reached_by"] for row in one.trials] == [row["reached_by"] for row in three.trials]
    other = kg.study.shapes(chain([0.5, 0.4]), **arguments(), seed=1)
    assert [row["reached_by"] for row in one.trials] != [row["reached_by"] for row in other.trials]


def test_the_budget_is_told() -> None:
    found = kg.study.shapes(chain([0.5, 0.4]), trials=400, budget=1e-3)
    assert len(found) >= 1 and "budget" in str(found) and len(found.trials) < 400


def test_a_sheet_without_cuts_is_told() -> None:
    """A square plate on simple supports, squeezed: it bulges, and its mirror image counts as the same."""
    x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5))
    corners = [5 * row + column for row in range(4) for column in range(4)]
    facets = [t for a in corners for t in ((a, a + 1, a + 6), (a, a + 6, a + 5))]
    mesh = kg.TriMesh(np.column_stack([x.ravel(), y.ravel()]), facets)
    m = kg.Model.from_mesh(mesh, thickness=0.005, material=kg.Material(E=1e6, nu=1 / 3))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="outer"), "z"), kg.Fix(bottom, "xy"), kg.Fix(top, "x"), kg.Prescribe(top, y=-2e-4))
    found = kg.study.shapes(m, trials=12, confirm=False, followed=0)
    assert "no cut whose lips" in str(found) and found[0].arrangements >= 1


def test_bad_requests() -> None:
    m = chain([0.5])
    undriven = kg.Model(dim=2)
    left, apex, right = undriven.add(kg.Node(-1, 0), kg.Node(0, 0.5), kg.Node(1, 0))
    undriven.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0), kg.Fix([left, right]))
    with pytest.raises(kg.ModelError, match="nothing drives the model"):
        kg.study.shapes(undriven)
    assert len(kg.study.shapes(undriven, at=0.0, trials=16, mirrors="")) == 2  # at rest, it stands or hangs
    flat = kg.Model.from_mesh(two_slits().mesh, stiffness="facet", dim=2)
    with pytest.raises(kg.ModelError, match="dim=2"):
        kg.study.shapes(flat)
    with pytest.raises(kg.ModelError, match="a start has 3 nodes at load factor 0.5"):
        kg.study.shapes(m, starts=[kg.Step.at(m, 0.5, np.zeros((3, 3)))])
    found = kg.study.shapes(m, trials=8)
    with pytest.raises(kg.ModelError, match="load factor 0.5"):
        found.which(kg.Step.at(m, 0.5, np.zeros((3, 3))))
