"""The correctors that end in stable equilibria: closed form of a column, a thin cut sheet, repeatability."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from shapely import LineString, box

import kirigami as kg
from kirigami.analysis.path import release
from kirigami.analysis.path.descent import CORRECTORS
from kirigami.analysis.path.increments import Increments
from kirigami.analysis.path.points import Attempt, Point, State, Tangent
from kirigami.analysis.path.run import PathRun
from kirigami.analysis.path.stable import MOST_FAILURES, StableSteps


def slit_sheet(imperfection: float, dim: int = 3) -> kg.Model:
    """A unit square with one slit, t/L = 1e-3, pulled by 2 %: far beyond buckling."""
    mesh = kg.Sheet(box(0, 0, 1, 1), [LineString([(0.25, 0.5), (0.75, 0.5)])]).mesh(0.15)
    m = kg.Model.from_mesh(mesh, 1e-3, kg.Material(E=1.0, nu=1 / 3), dim=dim)
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="bottom")), kg.Fix(top, "xz"[: dim - 1]), kg.Prescribe(top, y=0.02))
    if imperfection:
        m.perturb(kg.Eigen(m, n=1).run()[0], amplitude=imperfection * 1e-3)
    return m


@pytest.fixture(scope="module")
def energy_in_plane() -> float:
    """Energy of the same sheet kept in its plane."""
    return float(kg.DisplacementControl(slit_sheet(0.0, dim=2)).run().energy["bars"][-1])


@pytest.mark.parametrize("corrector", CORRECTORS)
def test_perfect_column_buckles(corrector: str) -> None:
    """Two rigid links with a spring k = 1 between them, squeezed by 2 (1 - cos(phi)), take P = 2 phi / sin(phi)."""
    m = kg.Model(dim=2)
    bottom, middle, top = m.add(kg.Node(0, 0), kg.Node(0, 1), kg.Node(0, 2))
    m.add(kg.Bar(bottom, middle, 1e4), kg.Bar(middle, top, 1e4), kg.TorsionSpring3(bottom, middle, top, 1.0))
    m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.Prescribe(top, y=-0.2))
    res = kg.DisplacementControl(m, corrector=corrector).run()
    assert res.stable.all()
    assert any(event.kind == "switch" for event in res.events)
    angle = np.arccos(0.9)
    assert -res.reaction(top, "y")[-1] == pytest.approx(2 * angle / np.sin(angle), rel=1e-3)


@pytest.mark.parametrize("corrector", CORRECTORS)
@pytest.mark.parametrize("imperfection", [0.0, 1e-6, 1e-3])
def test_thin_slit_sheet_is_carried_through_buckling(
    corrector: str, imperfection: float, energy_in_plane: float
) -> None:
    """Every stored step is a stable equilibrium; at the end far out of the plane, with less energy than in it."""
    m = slit_sheet(imperfection)
    analysis = kg.DisplacementControl(m, corrector=corrector)
    res = analysis.run()
    assert res.lam[-1] == 1.0
    assert res.stable[1:].all()
    assert res.residual.max() <= analysis.tol
    assert np.ptp(res.u[-1, :, 2]) > 10e-3  # many thicknesses
    assert sum(energy[-1] for energy in res.energy.values()) < 0.99 * energy_in_plane


def test_the_same_run_gives_the_same_digits() -> None:
    first, second = (kg.DisplacementControl(slit_sheet(1e-3), corrector="descent").run() for _ in range(2))
    np.testing.assert_array_equal(first.u, second.u)
    assert first.stats["factorizations"] == second.stats["factorizations"]


def test_unknown_corrector() -> None:
    with pytest.raises(kg.ModelError, match="corrector must be one of"):
        kg.DisplacementControl(slit_sheet(0.0), corrector="hope")


@pytest.fixture(scope="module")
def benchmark() -> Iterator[ModuleType]:
    """The script that compares the correctors."""
    folder = str(Path(__file__).resolve().parents[1] / "benchmarks")
    sys.path.insert(0, folder)
    try:
        import correctors

        yield correctors
    finally:
        sys.path.remove(folder)


def test_benchmark_sheets_resolve_their_ligaments(benchmark: ModuleType) -> None:
    """At least three facets across the narrowest ligament of each of the eight sheets."""
    assert len(benchmark.SHEETS) == 8
    assert {name: count for name in benchmark.SHEETS if (count := benchmark.facets_across(name)) < 3} == {}


def test_descent_of_a_thin_disc_is_cheap(benchmark: ModuleType) -> None:
    """2,315 nodes at t/L = 1e-3, one slit, to lock; 110 factorisations when this was written."""
    row = benchmark.carry("disc", "descent", 1e-3)
    assert int(row["nodes"]) >= 2000
    assert row["end"] == "lock"
    assert int(row["factorizations"]) < 200


def test_a_snap_foreseen_is_the_same_snap(monkeypatch: pytest.MonkeyPatch) -> None:
    """A descent that is given up because the potential fell below that of any smooth path only spares its rest."""
    m = kg.Model(dim=2)
    for x, rise in ((0, 0.3), (3, 0.4)):  # the first to snap is the first loss of stability, which may be a buckle
        left, apex, right = m.add(kg.Node(x - 1, 0), kg.Node(x, rise), kg.Node(x + 1, 0))
        pulled = m.add(kg.Node(x, -2))
        m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0), kg.Bar(apex, pulled, EA=0.02))
        m.add(kg.Fix([left, right]), kg.Fix([apex, pulled], "x"), kg.Prescribe(pulled, y=-3.0))
    foreseen = kg.DisplacementControl(m).run()
    monkeypatch.setattr(release, "FORESEEN", np.inf)
    landed = kg.DisplacementControl(m).run()
    assert [event.kind for event in landed.events] == ["snap", "snap"]
    assert [event.bracket for event in foreseen.events] == [event.bracket for event in landed.events]
    for one, other in zip(foreseen.events, landed.events):
        assert one.energy == pytest.approx(other.energy, rel=1e-9)
    np.testing.assert_allclose(foreseen.u, landed.u, atol=1e-9)
    assert foreseen.stats["factorizations"] < landed.stats["factorizations"]


def test_what_yields_is_no_snap_foreseen(monkeypatch: pytest.MonkeyPatch) -> None:
    """The potential of a bar that is pulled beyond yield stays above the least one that was foretold of its path."""
    met = []

    def accept(steps: StableSteps, *given: object) -> object:
        point = accepted(steps, *given)  # type: ignore[arg-type]
        met.append((steps.run, point))
        return point

    accepted = StableSteps._accept
    monkeypatch.setattr(StableSteps, "_accept", accept)
    m = kg.Model(dim=2)
    nodes = m.add(*(kg.Node(x, 0) for x in range(3)))
    m.add(kg.Bar(*nodes[:2], EA=1.0, yield_force=0.02), kg.Bar(*nodes[1:], EA=2.0, yield_force=0.05))
    m.add(kg.Fix(nodes[0]), kg.Fix(nodes[1:], "y"), kg.Prescribe(nodes[2], x=0.2))
    assert [event.kind for event in kg.DisplacementControl(m).run().events] == ["yield"]
    for (run, before), (_, after) in pairwise(met):
        least = release.least_potential(run, before, after.state.lam - before.state.lam)
        run.system.history = before.history
        assert least <= sum(run.system.energies(after.state.u, after.state.lam).values())


def strained(pull: float) -> kg.DisplacementControl:
    """A square of a few facets, pulled in its plane."""
    mesh = kg.Sheet(box(0, 0, 1, 1)).mesh(0.5)
    m = kg.Model.from_mesh(mesh, 0.05, kg.Material(E=1e9, nu=0.3))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(m.nodes, "z"), kg.Fix(bottom, "xy"), kg.Fix(top, "x"), kg.Prescribe(top, y=pull))
    return kg.DisplacementControl(m)


@pytest.mark.parametrize("pull, told", [(1.0, True), (0.02, False)])
def test_a_failure_among_torn_facets_names_their_strain(pull: float, told: bool, monkeypatch) -> None:
    """Where edges have doubled their length, no smaller step and no imperfection helps."""
    real = PathRun.tangent_at
    fails = lambda run, attempt: None if attempt.state.lam > 0.5 else real(run, attempt)  # noqa: E731
    monkeypatch.setattr(PathRun, "tangent_at", fails)
    with pytest.raises(kg.ConvergenceError) as failed:
        strained(pull).run()
    assert ("law of small strains" in failed.value.hint) == told
    assert ("imperfection" in failed.value.hint) != told


def test_beyond_a_failed_descent_increments_grow_gently() -> None:
    """A landing on this side of the place where a descent failed does not bring the long increment back that failed."""
    run = PathRun(strained(0.02))
    steps = StableSteps(run)
    run.increments = Increments(1e-3, 1.0, 1e-7, [1.0])
    tangent = Tangent(None, np.zeros(run.system.free))
    here, there = (Point(State(np.zeros(run.system.free), lam, run.system.rest), tangent, None) for lam in (0.5, 0.7))
    landed = Attempt(here.state, True, 0.0, 5, relaxed=True, drift=0.1)
    steps.cut(here, landed, 0.1)
    run.increments.size = 1e-5  # after as many cuts as it took
    steps.settle(here, here, landed, 1e-5)
    assert run.increments.size == pytest.approx(1e-4)
    steps.settle(here, there, landed, 1e-5)
    assert run.increments.size > 0.1


def test_failures_are_counted_place_by_place() -> None:
    """Once the path moves on they count no more: a long run may meet many places."""
    run = PathRun(strained(0.02))
    steps = StableSteps(run)
    run.increments = Increments(1e-3, 1.0, 1e-7, [1.0])
    tangent = Tangent(None, np.zeros(run.system.free))
    points = [Point(State(np.zeros(run.system.free), lam, run.system.rest), tangent, None) for lam in (0.1, 0.3)]
    smooth = Attempt(points[1].state, True, 0.0, 3, drift=0.01)
    for _ in range(2 * MOST_FAILURES):
        steps.cut(points[0], smooth, 0.1)
        steps.settle(*points, smooth, 0.2)
    assert steps.failures == 0 and steps.trouble is None


def test_descents_that_fail_again_and_again_end_in_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not at the smallest increment alone, which may take as many descents anew from each landing on this side."""
    descents = []

    def fails(run: PathRun, attempt: Attempt) -> Tangent | None:
        tangent = real(run, attempt)
        blocked = attempt.state.lam > 0.5 + 1e-6 * len(descents)  # a little further each time, and no end of it
        descents.extend([attempt] * blocked)
        return None if blocked else tangent

    real = PathRun.tangent_at
    monkeypatch.setattr(PathRun, "tangent_at", fails)
    with pytest.raises(kg.ConvergenceError) as failed:
        strained(0.02).run()
    results = failed.value.results
    assert results is not None and results.lam[-1] > 0.5
    assert results.stats["cutbacks"] <= 3 * MOST_FAILURES  # some of them are made before a descent
