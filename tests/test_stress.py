"""Stress of sheets against closed forms, on every rung of accuracy."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from matplotlib import pyplot
from numpy.typing import NDArray

import kirigami as kg
from kirigami.elements.stiffness import RUNGS
from kirigami.results.stress import SheetStress
from kirigami.system.system import System

E, NU, T = 2e9, 0.34, 1e-3
MATERIAL = kg.Material(E=E, nu=NU)
MESH = kg.Sheet(shapely.box(0, 0, 0.2, 0.1), thickness=T, material=MATERIAL).mesh(0.02)
FACTOR = E / (1 - NU**2)
PLATES = ("facet", "shell")  # rungs whose elements are made of plates


def at(rung: str, surface: NDArray[np.float64], normal: NDArray[np.float64] | None = None, dim: int = 3) -> kg.Results:
    """Results with one step in which the nodes of MESH lie on a surface, with its normals where the rung has some."""
    model = kg.Model.from_mesh(MESH, stiffness=rung, dim=dim)
    results = kg.Results(System(model))
    results.append(kg.Step.at(model, 1.0, surface - model.positions()))
    return results


def stretched(gradient: list[list[float]]) -> NDArray[np.float64]:
    moved = MESH.nodes.copy()
    moved[:, :2] = MESH.nodes[:, :2] @ np.array(gradient).T
    return moved


def cylinder(radius: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Bent upwards round an axis along y, and its normals."""
    x, y, _ = MESH.nodes.T
    angle = x / radius
    surface = np.column_stack([radius * np.sin(angle), y, radius * (1 - np.cos(angle))])
    return surface, np.column_stack([-np.sin(angle), np.zeros_like(x), np.cos(angle)])


def told(results: kg.Results, rung: str) -> SheetStress:
    """Stress by the elements, where they are those of a plate: bars and hinges have Poisson ratios of their own."""
    stress = results.stress(0)
    return stress if rung in PLATES else stress.by_plate_theory()


@pytest.mark.parametrize("rung", RUNGS)
def test_uniform_strain_is_exact(rung: str) -> None:
    """Green strain (F'F - I) / 2 and plane stress, whatever the mesh; here also with a large rotation."""
    gradient = np.array([[1.02, 0.004], [0.001, 0.99]])
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    green = 0.5 * (gradient.T @ gradient - np.eye(2))
    expected = FACTOR * ((1 - NU) * green + NU * np.trace(green) * np.eye(2))
    results = at(rung, stretched((turn @ gradient).tolist()))
    assert results.stress().strain.shape == (1, len(MESH.triangles), 2, 2)
    stress = told(results, rung)
    np.testing.assert_allclose(stress.strain, np.tile(green, (len(MESH.triangles), 1, 1)), atol=1e-12)
    for fibre in ("bottom", "middle", "top"):
        np.testing.assert_allclose(stress.tensor(fibre), np.tile(expected, (len(MESH.triangles), 1, 1)), rtol=1e-6)
    np.testing.assert_allclose(stress.force, T * stress.tensor(), rtol=1e-14)
    assert stress.membrane_share == pytest.approx(1.0, abs=1e-9)
    energy = 0.5 * T * np.sum(expected * green) * 0.02
    assert stress.membrane_energy.sum() == pytest.approx(energy, rel=1e-10)


@pytest.mark.parametrize("rung", RUNGS)
def test_uniaxial_tension(rung: str) -> None:
    """A strip pulled between smooth grips: sigma = E strain along, nothing across, to first order."""
    model = kg.Model.from_mesh(MESH, stiffness=rung, dim=3)
    left, right = model.select(boundary="left"), model.select(boundary="right")
    strain = 1e-5
    x, y, _ = MESH.nodes.T
    moved = np.column_stack([x * (1 + strain), y * (1 - NU * strain), 0 * x])
    model.add(kg.Fix(left, "xz"), kg.Fix(left[0], "y"), kg.Fix(right, "z"), kg.Prescribe(right, x=0.2 * strain))
    stress = kg.LinearStatic(model).run().stress(-1) if rung in PLATES else told(at(rung, moved), rung)
    np.testing.assert_allclose(stress.principal()[:, 0], E * strain, rtol=2e-5)
    np.testing.assert_allclose(stress.principal()[:, 1], 0.0, atol=2e-5 * E * strain)
    np.testing.assert_allclose(stress.von_mises(), E * strain, rtol=2e-5)
    np.testing.assert_allclose(np.abs(stress.directions()[:, 0] @ (1.0, 0.0)), 1.0, rtol=1e-8)


@pytest.mark.parametrize("rung", RUNGS)
def test_pure_shear(rung: str) -> None:
    """gamma: principal stresses +- G gamma under 45 degrees, von Mises' sqrt(3) G gamma."""
    gamma, G = 1e-6, E / (2 * (1 + NU))
    stress = told(at(rung, stretched([[1, gamma / 2], [gamma / 2, 1]])), rung)
    np.testing.assert_allclose(stress.principal() / (G * gamma), np.tile((1, -1), (len(MESH.triangles), 1)), rtol=1e-5)
    np.testing.assert_allclose(stress.von_mises(), np.sqrt(3) * G * gamma, rtol=1e-5)
    np.testing.assert_allclose(np.abs(stress.directions()[:, 0] @ (1, 1)), np.sqrt(2), rtol=1e-5)
    np.testing.assert_allclose((stress.directions()[:, 0] * stress.directions()[:, 1]).sum(axis=1), 0, atol=1e-14)


@pytest.mark.parametrize("rung", [rung for rung in RUNGS if rung != "shell"])
def test_gentle_cylinder_on_every_rung(rung: str) -> None:
    """So gently that the chords of flat facets hide no length: bending stress is all there is, in the mean exactly."""
    radius = 100.0
    stress = at(rung, *cylinder(radius)).stress(0).by_plate_theory()
    bending = FACTOR * T / (2 * radius)
    difference = 0.5 * (stress.tensor("bottom") - stress.tensor("top"))
    np.testing.assert_allclose(difference[:, 0, 0], bending, rtol=1e-5)
    np.testing.assert_allclose(difference[:, 1, 1], NU * bending, rtol=1e-5)
    np.testing.assert_allclose(stress.curvature[:, 0, 0], 1 / radius, rtol=1e-5)


@pytest.mark.parametrize("linear", [True, False], ids=["linear", "path"])
@pytest.mark.parametrize("rung", RUNGS)
def test_stretching_carries_the_force_that_is_reported(rung: str, linear: bool) -> None:
    """Virtual work of a uniform strain along the pull: N_xx over the sheet is force times length, slit or not."""
    slits = [shapely.LineString([(0.08, 0), (0.08, 0.06)]), shapely.LineString([(0.14, 0.03), (0.14, 0.07)])]
    mesh = kg.Sheet(shapely.box(0, 0, 0.2, 0.1), slits, thickness=T, material=MATERIAL).mesh(0.025)
    model = kg.Model.from_mesh(mesh, stiffness=rung)
    left, right = model.select(boundary="left"), model.select(boundary="right")
    pull = 1e-7  # so little that the shape does not change the balance
    model.add(kg.Fix(left, clamp=True), kg.Fix(right, "yz", clamp=True), kg.Prescribe(right, x=pull))
    results = (kg.LinearStatic(model) if linear else kg.DisplacementControl(model)).run()
    stress = results.stress(-1)
    force = results.reaction(right, "x")[-1]
    tolerance = 1e-7 if linear else 1e-5
    assert (stress.area * stress.force[:, 0, 0]).sum() == pytest.approx(force * 0.2, rel=tolerance)
    assert stress.membrane_energy.sum() == pytest.approx(0.5 * force * pull, rel=10 * tolerance)


@pytest.mark.parametrize("rung", RUNGS)
def test_bending_carries_the_force_that_is_reported(rung: str) -> None:
    """Virtual work of the deflection x^2 / 2 on a cantilever with end load P: M_xx over the sheet is P L^2 / 2."""
    model = kg.Model.from_mesh(MESH, stiffness=rung)
    left, right = model.select(boundary="left"), model.select(boundary="right")
    model.add(kg.Fix(left, clamp=True), kg.NodalLoad(right, (0, 0, 1e-3 / len(right))))
    results = kg.LinearStatic(model).run()
    stress = results.stress(-1)
    assert (stress.area * stress.moment[:, 0, 0]).sum() == pytest.approx(1e-3 * 0.2**2 / 2, rel=1e-6)
    work = 0.5 * 1e-3 * results.u[-1, results.node_index(right), 2].mean()
    assert stress.bending_energy.sum() == pytest.approx(work, rel=1e-6)
    np.testing.assert_allclose(stress.tensor("top") + stress.tensor("bottom"), 2 * stress.tensor(), atol=1e-9 * E * T)


@pytest.mark.parametrize("linear", [True, False], ids=["linear", "path"])
@pytest.mark.parametrize("rung", RUNGS)
def test_energy_of_the_stress_is_that_of_the_run(rung: str, linear: bool) -> None:
    """Stretched, bent and clamped far beyond small rotations: facet by facet adds up to what is stored, by kind."""
    model = kg.Model.from_mesh(MESH, stiffness=rung)
    left, right = model.select(boundary="left"), model.select(boundary="right")
    model.add(kg.Fix(left, clamp=True), kg.Fix(right, "y", clamp=True), kg.Prescribe(right, x=-5e-3, z=0.05))
    results = (kg.LinearStatic(model) if linear else kg.DisplacementControl(model, step=0.25)).run()
    stress = results.stress()
    stored = sum(results.energy.values())
    total = (stress.membrane_energy + stress.bending_energy).sum(axis=1)
    np.testing.assert_allclose(total, stored, rtol=1e-9, atol=1e-12 * stored[-1])
    assert (stress.membrane_energy >= 0).all() and (stress.bending_energy >= 0).all()
    if "bars" in results.energy:
        np.testing.assert_allclose(stress.membrane_energy.sum(axis=1), results.energy["bars"], rtol=1e-9)
    if rung == "facet":  # the same forces by their own strain, which is uniform in a facet
        membrane = 0.5 * stress.area * (stress.force * stress.strain).sum(axis=(-2, -1))
        np.testing.assert_allclose(stress.membrane_energy, membrane, rtol=1e-9, atol=1e-12 * stored[-1])


def test_bars_of_equilateral_facets_are_a_plate() -> None:
    """With Poisson's ratio 1/3 the stress of bars is that of the plate, also at the edge of the sheet."""
    height = np.sqrt(3) / 2
    nodes = [(i + 0.5 * (j % 2), j * height) for j in range(4) for i in range(5)]
    facets = []
    for j in range(3):
        for i in range(4):
            a, b, c, d = 5 * j + i, 5 * j + i + 1, 5 * j + i + 5, 5 * j + i + 6
            facets += [(a, b, d), (a, d, c)] if j % 2 else [(a, b, c), (b, d, c)]
    mesh = kg.TriMesh(nodes, facets, thickness=T, material=kg.Material(E=E, nu=1 / 3))
    gradient = np.array([[1.002, 0.0004], [0.0001, 0.999]])
    model = kg.Model.from_mesh(mesh)
    moved = mesh.nodes.copy()
    moved[:, :2] = mesh.nodes[:, :2] @ gradient.T
    results = kg.Results(System(model))
    results.append(kg.Step.at(model, 1.0, moved - mesh.nodes))
    stress = results.stress(0)
    np.testing.assert_allclose(stress.force, stress.by_plate_theory().force, rtol=1e-9, atol=1e-9 * E * T * 2e-3)


def test_tendons_are_no_part_of_the_sheet() -> None:
    model = kg.Model.from_mesh(MESH)
    model.add(kg.Bar(model.nodes[0], model.nodes[-1], 1e3), kg.Bar(*model.elements[0].nodes, 1e3))
    step = kg.Step.at(model, 1.0, 1e-3 * MESH.nodes)
    both = []
    for one in (model, kg.Model.from_mesh(MESH)):
        results = kg.Results(System(one))
        results.append(step)
        both.append(results.stress(0).force)
    np.testing.assert_array_equal(both[0], both[1])


def test_an_imperfection_is_free_of_stress() -> None:
    for rung in RUNGS:
        model = kg.Model.from_mesh(MESH, stiffness=rung)
        x, y, _ = MESH.nodes.T
        model.perturb(np.sin(np.pi * x / 0.2) * np.sin(np.pi * y / 0.1), amplitude=T)
        results = kg.Results(System(model))
        results.append(kg.Step(0.0, np.zeros_like(model.positions())))
        stress = results.stress()
        np.testing.assert_allclose(stress.tensor("top"), 0, atol=1e-14 * E)


def test_a_linear_analysis_has_stress_to_first_order() -> None:
    """Deflections of many thicknesses do not stretch the sheet there; twice the load is twice the stress."""
    for rung in ("plate", "shell"):
        found = []
        for pull in (1e-3, 2e-3):
            model = kg.Model.from_mesh(MESH, stiffness=rung)
            right = model.select(boundary="right")
            model.add(kg.Fix(model.select(boundary="left"), clamp=True), kg.Prescribe(right, z=20 * pull))
            stress = kg.LinearStatic(model).run().stress(-1)
            assert np.abs(stress.tensor()).max() < 1e-6 * np.abs(stress.tensor("top")).max()
            found.append(stress.tensor("top"))
        np.testing.assert_allclose(found[1], 2 * found[0], atol=1e-6 * np.abs(found[0]).max())


def test_energy_is_that_of_the_elements() -> None:
    """On curved facets in a nonlinear run: recovered stretching and bending add up to the stored energy."""
    model = kg.Model.from_mesh(MESH, stiffness="shell")
    x, y, _ = MESH.nodes.T
    model.perturb(np.sin(np.pi * x / 0.2), amplitude=T)
    left, right = model.select(boundary="left"), model.select(boundary="right")
    model.add(kg.Fix(left), kg.Fix(right, "yz"), kg.Prescribe(right, x=-2e-3))
    results = kg.DisplacementControl(model).run()
    stress = results.stress(-1)
    total = stress.membrane_energy.sum() + stress.bending_energy.sum()
    assert total == pytest.approx(results.energy["shell"][-1], rel=1e-2)  # curvature is not quite uniform in a facet
    assert stress.membrane_share < 0.1  # an elastica


def test_in_a_plane_nothing_bends() -> None:
    stress = at("facet", stretched([[1.01, 0], [0, 1]]), dim=2).stress(0)
    assert not stress.curvature.any()
    np.testing.assert_allclose(stress.tensor("top"), stress.tensor("bottom"))


def test_shape_measures_take_nodes_of_the_mesh_only() -> None:
    results = at("shell", *cylinder(1.0))
    np.testing.assert_allclose(results.curvature("mean"), 0.5, rtol=0.05)
    assert results.width("x")[0] == pytest.approx(0.1)


def test_picture() -> None:
    results = at("shell", *cylinder(0.1))
    ax = results.plot_stress(fibre="bottom")
    bar = ax.figure.axes[-1]
    assert "largest principal stress, bottom" in bar.get_ylabel() + bar.get_xlabel()
    with pytest.raises(kg.ModelError, match="kind"):
        results.plot_stress(kind="hoop")
    pyplot.close("all")


def test_what_cannot_be_told() -> None:
    results = at("plate", MESH.nodes.copy())
    with pytest.raises(kg.ModelError, match="step 3 is not stored"):
        results.stress(3)
    with pytest.raises(kg.ModelError, match="fibre"):
        results.stress(0).tensor("upper")
    truss = kg.Model(dim=2)
    a, b = truss.add(kg.Node(0, 0), kg.Node(1, 0))
    truss.add(kg.Bar(a, b, EA=1.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    with pytest.raises(kg.AnalysisError, match="from_mesh"):
        kg.LinearStatic(truss).run().stress()
    bare = kg.TriMesh(MESH.nodes, MESH.triangles)
    model = kg.Model.from_mesh(bare, thickness=T, material=MATERIAL)
    held = kg.Results(System(model))
    held.append(kg.Step(0.0, np.zeros_like(model.positions())))
    assert held.stress().thickness == T
    assert held.forget_model().stress().thickness == T
    held.sheet_constants = None
    with pytest.raises(kg.ModelError, match="thickness is unknown"):
        held.stress()
    assert held.stress(0, thickness=2 * T, material=MATERIAL).thickness == 2 * T


@pytest.mark.parametrize(
    "wrong",
    [
        {"thickness": -1}, {"thickness": float("nan")}, {"thickness": 0}, {"thickness": "thin"}, {"material": 5},
        {"step": "a"}, {"step": 1.5}, {"step": 9}, {"step": True},
    ],
    ids=str,
)  # fmt: skip
def test_arguments_of_stress_are_checked(wrong: dict[str, object]) -> None:
    results = at("plate", MESH.nodes.copy())
    with pytest.raises(kg.ModelError, match="stress"):
        results.stress(**{"step": -1, **wrong})  # type: ignore[arg-type]
