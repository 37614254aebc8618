"""Error indicator, local mesh sizes, choice of the mesh and brackets: held to what finer meshes give."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import shapely
from matplotlib import pyplot
from numpy.typing import NDArray

import kirigami as kg
from kirigami.study.convergence import observed_order
from kirigami.study.mesh_choice import shape_distance
from kirigami.system.system import System

MATERIAL = kg.Material(E=3.5e9, nu=0.34)
SLIT = shapely.LineString([(0.02, 0.1), (0.08, 0.1)])
STRIP = kg.Sheet(shapely.box(0, 0, 0.1, 0.2), SLIT, thickness=1e-4, material=MATERIAL)
PLAIN = kg.Sheet(shapely.box(0, 0, 0.1, 0.2), thickness=1e-4, material=MATERIAL)


def in_plane(mesh: kg.TriMesh) -> tuple[kg.Results, float]:
    """The strip pulled by 0.25 % in its plane, and the force: 64.5 N in the limit, the energy times a constant."""
    model = kg.Model.from_mesh(mesh, stiffness="facet", dim=2)
    top = model.select(boundary="top")
    model.add(kg.Fix(model.select(boundary="bottom")), kg.Prescribe(top, x=0, y=5e-4))
    results = kg.LinearStatic(model).run()
    return results, float(results.reaction(top, "y")[-1])


def buckled(mesh: kg.TriMesh, stiffness: str) -> tuple[kg.Model, list[kg.Node]]:
    """The strip clamped and pulled by 0.25 %, with a bump one thickness high over the slit."""
    model = kg.Model.from_mesh(mesh, stiffness=stiffness)
    bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=5e-4))
    x, y, _ = mesh.nodes.T
    model.perturb(np.sin(np.pi * x / 0.1) * np.exp(-(((y - 0.1) / 0.03) ** 2)), amplitude=1e-4)
    return model, top


# ---------------------------------------------------------------------------------------------- local mesh sizes


def test_mesh_follows_a_local_size() -> None:
    def size(points: NDArray[np.float64]) -> NDArray[np.float64]:
        tips = [np.linalg.norm(points - tip, axis=1) for tip in ((0.02, 0.1), (0.08, 0.1))]
        return np.asarray(0.001 + 0.2 * np.minimum(*tips))

    mesh = STRIP.mesh(0.02, size=size)
    assert mesh.facet_areas.sum() == pytest.approx(0.02, rel=1e-12) and len(mesh.cuts) == 1
    middles = mesh.nodes[mesh.edges].mean(axis=1)[:, :2]
    wanted = np.minimum(size(middles), 0.02)
    ratio = mesh.edge_lengths / wanted
    assert 0.7 < np.median(ratio) < 1.1 and ratio.max() < 2.0 and mesh.min_angle > 25
    coarse = STRIP.mesh(0.02)
    everywhere = STRIP.mesh(0.02, size=lambda points: np.full(len(points), 1.0))  # asks for nothing
    np.testing.assert_array_equal(everywhere.nodes, coarse.nodes)
    with pytest.raises(kg.GeometryError, match="size must return one positive length"):
        STRIP.mesh(0.02, size=lambda points: np.zeros(len(points)))
    with pytest.raises(kg.GeometryError, match="the limit"):
        STRIP.mesh(0.02, size=lambda points: np.full(len(points), 1e-6))


# ---------------------------------------------------------------------------------------------------- indicator


def test_uniform_strain_has_no_error() -> None:
    mesh = PLAIN.mesh(0.03)
    model = kg.Model.from_mesh(mesh, stiffness="facet", dim=2)
    results = kg.Results(System(model))
    results.append(kg.Step.at(model, 1.0, 1e-3 * mesh.nodes))
    estimate = kg.study.estimate_error(results)
    assert estimate.relative < 1e-9 and estimate.energy > 0
    flat = kg.Results(System(model))
    flat.append(kg.Step.at(model, 1.0, 0 * mesh.nodes))
    assert kg.study.estimate_error(flat).relative == 0.0
    with pytest.raises(kg.ModelError, match="zero everywhere"):
        kg.study.estimate_error(flat).size(100)


def test_smooth_bending_is_of_first_order() -> None:
    """Curvature that is uniform in each facet errs with h in the norm of the energy."""
    found = []
    for max_edge in (0.02, 0.01):
        mesh = PLAIN.mesh(max_edge)
        model = kg.Model.from_mesh(mesh, stiffness="shell")
        a, k = 1e-6, np.pi / 0.1
        x, y, _ = mesh.nodes.T
        height = a * np.sin(k * x) * np.sin(k * y)
        u = np.zeros((len(x), 3))
        u[:, 2] = height
        results = kg.Results(System(model))
        results.append(kg.Step.at(model, 1.0, u))
        estimate = kg.study.estimate_error(results)
        assert estimate.bending.sum() > 100 * estimate.membrane.sum()
        found.append(estimate.relative)
    assert 0.75 < np.log2(found[0] / found[1]) < 1.35


def test_estimate_and_gain_at_a_slit() -> None:
    """In the plane the error of the energy is that of the force: the estimate is within a third of it, and a mesh made
    from it is more than twice as accurate as a uniform one of as many nodes."""
    start = STRIP.mesh(0.015, cut_edge=0.015)
    results, _ = in_plane(start)
    first = kg.study.estimate_error(results)
    tips = np.array([(0.02, 0.1), (0.08, 0.1)])
    assert min(np.linalg.norm(tips - first.worst(1)[0], axis=1)) < 0.01
    adapted = STRIP.mesh(0.2, cut_edge=0.2, size=first.size(600))
    better, force = in_plane(adapted)
    uniform_mesh = STRIP.mesh(0.0073, cut_edge=0.0073)
    uniform, uniform_force = in_plane(uniform_mesh)
    assert 450 < len(adapted.nodes) < 750 and len(adapted.nodes) < 1.1 * len(uniform_mesh.nodes)
    second = kg.study.estimate_error(better)
    _, reference = in_plane(STRIP.mesh(0.2, cut_edge=0.2, size=second.size(3000)))
    assert force - reference < 0.5 * (uniform_force - reference)
    for estimate, value in ((kg.study.estimate_error(uniform), uniform_force), (second, force)):
        assert estimate.relative == pytest.approx(np.sqrt(value / reference - 1), rel=1 / 3)
    assert "largest at (0.0" in str(first)
    ax = first.plot()
    assert "error per area" in "".join(a.get_ylabel() + a.get_xlabel() for a in ax.figure.axes)
    pyplot.close("all")


@pytest.mark.long
def test_gain_in_space() -> None:
    """Buckled, on the rung to trust: nodes where they are wanted err by less than half of what as many err that are
    graded along the cut, against a mesh of three times as many."""
    meshes = [STRIP.mesh(0.01)]
    model, _ = buckled(STRIP.mesh(0.02), "shell")
    estimate = kg.study.estimate_error(kg.DisplacementControl(model).run())
    forces = []
    for nodes in (0, 240, 430, 1200):
        if nodes:
            meshes.append(STRIP.mesh(0.2, cut_edge=0.2, size=estimate.size(nodes)))
        model, top = buckled(meshes[-1], "shell")
        results = kg.DisplacementControl(model).run()
        if nodes:
            estimate = kg.study.estimate_error(results)
        forces.append(results.reaction(top, "y")[-1])
    graded, _, adapted, reference = forces
    assert len(meshes[2].nodes) < 1.2 * len(meshes[0].nodes) and len(meshes[3].nodes) > 2.5 * len(meshes[2].nodes)
    assert reference < adapted < graded  # a mesh too coarse is too stiff at slit tips
    assert adapted - reference < 0.5 * (graded - reference)


# ------------------------------------------------------------------------------------------------ mesh and band


def beam(max_edge: float, stiffness: str) -> tuple[kg.Model, Sequence[kg.Node], str]:
    """A cantilever bent in its plane: no cut, and hardly singular."""
    model = kg.Model.from_mesh(PLAIN.mesh(max_edge), stiffness=stiffness, dim=2)
    top = model.select(boundary="top")
    model.add(kg.Fix(model.select(boundary="bottom")), kg.Prescribe(top, x=1e-5))
    return model, top, "x"


def test_choice_of_a_mesh_keeps_its_word() -> None:
    choice = kg.study.choose_mesh(beam, 0.03, error=0.02, stiffness="facet")
    assert len(choice.runs) == 4 and choice.reached and choice.errors[-1] < 0.02  # the order is not quite 2
    assert 1.2 < choice.order < 2.8 and choice.expected < 2.5 * choice.errors[-1] < 6 * choice.expected
    model, top, axis = beam(0.004, "facet")
    fine = kg.LinearStatic(model).run().reaction(top, axis)[-1]
    errors = np.array([run.value for run in choice.runs]) / fine - 1
    assert abs(choice.run.value / fine - 1) < 0.02
    np.testing.assert_allclose(choice.errors, errors, atol=0.01)
    assert "expected" in str(choice) and f"take max_edge {choice.max_edge:.4g}" in str(choice)


def test_an_error_that_cannot_be_met_is_told_with_the_figure_reached() -> None:
    choice = kg.study.choose_mesh(beam, 0.06, error=1e-4, stiffness="facet", most=3)
    assert not choice.reached and choice.errors[-1] > 1e-4
    assert f"not reached, the last run is within {100 * choice.errors[-1]:.2g} %" in str(choice)


def test_order_of_three_runs() -> None:
    h = np.array([1.0, 0.7, 0.4])
    for order in (0.5, 1.0, 2.0, 3.5):
        assert observed_order(h, 7 - 0.3 * h**order) == pytest.approx(order, rel=1e-9)
    assert np.isnan(observed_order(h, [1.0, 1.2, 1.1])) and np.isnan(observed_order(h, [1.0, 1.0, 1.0]))
    assert np.isnan(observed_order(h, [1.0, 1.1, 1.9]))  # the finer, the more it changes


def squeezed(waves: int, max_edge: float) -> tuple[kg.Model, Sequence[kg.Node], str]:
    model = kg.Model.from_mesh(PLAIN.mesh(max_edge), stiffness="facet")
    bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=-1e-6))
    y = model.positions()[:, 1]
    model.perturb(np.sin(waves * np.pi * y / 0.2), amplitude=5e-3)  # high enough to keep its shape
    return model, top, "y"


def test_runs_on_different_branches_are_refused() -> None:
    """One half wave on the coarse mesh, two on the finer one."""
    with pytest.raises(kg.AnalysisError, match="different branches"):
        kg.study.choose_mesh(lambda edge, _: squeezed(1 if edge > 0.035 else 2, edge), 0.04, stiffness="facet")
    one, two = (kg.DisplacementControl(squeezed(1, edge)[0]).run() for edge in (0.04, 0.03))
    assert shape_distance(one, two) < 0.1 and shape_distance(one, one) < 1e-9


def case(max_edge: float, stiffness: str) -> tuple[kg.Model, Sequence[kg.Node], str]:
    return (*buckled(STRIP.mesh(max_edge), stiffness), "y")


@pytest.mark.long
def test_band_of_a_buckled_strip() -> None:
    """At slit tips both rungs are too stiff, so that a buckled strip has no bracket, and none is claimed; the shell is
    the closer one: an adapted mesh of 1,400 nodes gives 52.1 N."""
    band = kg.study.bracket(case, 0.014, ratio=0.02 / 0.014)
    coarse, fine, shell_coarse, shell_fine = (run.value for run in band.runs)
    assert coarse > fine > shell_coarse > shell_fine > 52.1
    assert band.same_shape and not band.closing and "no bracket" in str(band)
    assert band.low == shell_fine and band.high == fine
    assert all(0.2 < run.membrane_share < 1 for run in band.runs)


@pytest.mark.parametrize(
    ("values", "closing"),
    [
        ((60, 58, 33, 44), True),
        ((33, 44, 60, 58), True),
        ((60, 58, 65, 59), False),  # both from above
        ((60, 50, 40, 51), False),  # they have passed each other
        ((60, 61, 40, 45), False),  # one goes away
    ],
)
def test_what_is_called_a_bracket(values: tuple[float, ...], closing: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    import importlib

    module = importlib.import_module("kirigami.study.bracket")
    results = kg.LinearStatic(beam(0.05, "facet")[0]).run()
    left = iter(values)

    def run(case: object, size: float, rung: str, *_: object) -> kg.study.MeshRun:
        return kg.study.MeshRun(rung, size, 10, float(next(left)), 0.9, 0.1, results)

    monkeypatch.setattr(module, "run_case", run)
    band = kg.study.bracket(case, 0.02)
    assert band.closing is closing and band.same_shape
    assert ("from both sides" in str(band)) is closing and ("no bracket" in str(band)) is not closing
    assert (band.low, band.high) == tuple(sorted((values[1], values[3])))


def test_a_coarse_run_on_another_shape_closes_no_bracket() -> None:
    """What two meshes say of convergence they say only on one shape: here two half waves and one."""
    rungs = ("plate", "facet")
    band = kg.study.bracket(lambda edge, _: squeezed(1 if edge < 0.035 else 2, edge), 0.03, stiffness=rungs)
    assert not band.same_shape and not band.closing and "different shapes" in str(band)


def test_a_band_that_is_no_bracket_says_so() -> None:
    """In the plane both rungs of bars and facets are too stiff, and go the same way."""
    band = kg.study.bracket(beam, 0.02, stiffness=("plate", "facet"))
    assert not band.closing and "no bracket" in str(band)


def test_arguments_that_cannot_be_used() -> None:
    with pytest.raises(kg.ModelError, match="quantity"):
        kg.study.choose_mesh(beam, 0.03, quantity="stress")
    with pytest.raises(kg.ModelError, match="stiffness"):
        kg.study.choose_mesh(beam, 0.03, stiffness="fine")
    with pytest.raises(kg.ModelError, match="error"):
        kg.study.choose_mesh(beam, 0.03, error=0.0)
    with pytest.raises(kg.ModelError, match="two different rungs"):
        kg.study.bracket(beam, 0.03, stiffness=("facet", "facet"))
    with pytest.raises(kg.ModelError, match="ratio"):
        kg.study.bracket(beam, 0.03, ratio=0.5)
    with pytest.raises(kg.AnalysisError, match="no relative error"):
        kg.study.choose_mesh(beam, 0.03, quantity="height", stiffness="facet")
    truss = kg.Model(dim=2)
    a, b = truss.add(kg.Node(0, 0), kg.Node(1, 0))
    truss.add(kg.Bar(a, b, EA=1.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    with pytest.raises(kg.AnalysisError, match="from_mesh"):
        kg.study.estimate_error(kg.LinearStatic(truss).run())


@pytest.mark.parametrize("follows", ["cell", "link"])
def test_an_error_that_cannot_be_estimated_is_no_zero(follows: str) -> None:
    """Nodes that follow free rows leave the stored tangent singular; their height was told as exact."""
    if follows == "cell":
        sheet = kg.CellSheet([(2, 0), (0, 1)], [[(-0.6, 0.5), (0.6, 0.5)]], 0.01, kg.Material(E=1e6, nu=0.3))
        m = kg.Model.from_mesh(sheet.mesh(0.5))
        kg.PeriodicCell(m, sheet.lattice).impose((None, 0.02, 0.0))
    else:
        m = kg.Model.from_mesh(kg.Sheet(shapely.box(0, 0, 1, 2), thickness=0.01, material=kg.Material(E=1e6)).mesh(0.6))
        top = m.select(boundary="top")
        m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.RigidLink(m.select(box=(0, 1.3, 1, 2))))
        m.add(kg.NodalLoad(top, (0, 0, 1e-4)))
    m.imperfect()
    res = kg.LinearStatic(m).run()
    assert res.height()[-1] > 0 and np.isnan(res.error["height"]).all() and res.error["force"][-1] > 0
    assert "height" not in str(res.error)
