"""Facets and shell facets: derivatives, patch tests, plates and strips with exact answers, convergence."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest

import kirigami as kg

_SPEC = importlib.util.spec_from_file_location(
    "closed_forms", Path(__file__).parents[2] / "benchmarks" / "closed_forms.py"
)
assert _SPEC is not None and _SPEC.loader is not None
exact = importlib.util.module_from_spec(_SPEC)
import sys  # noqa: E402

sys.modules["closed_forms"] = exact  # dataclasses look their module up by name
_SPEC.loader.exec_module(exact)


def wavy(rung: str) -> kg.System:
    """A small unstructured patch with a curved rest state."""
    rng = np.random.default_rng(4)
    mesh = exact.sheet_mesh(1.0, 0.8, 2, random=True)
    model = kg.Model.from_mesh(mesh, thickness=0.05, material=kg.Material(1e3, 0.34), stiffness=rung)
    model.perturb(0.1 * rng.random(len(mesh.nodes)))
    return kg.System(model)


@pytest.mark.parametrize("rung", ["facet", "shell"])
@pytest.mark.parametrize("size", [0.02, 0.2])
def test_derivatives_and_rigid_motion(rung: str, size: float) -> None:
    system = wavy(rung)
    rng = np.random.default_rng(1)
    x = system.rest + size * rng.normal(size=system.rest.shape)
    x[system.points :] -= 0.9 * (x - system.rest)[system.points :]  # an edge bulges less than its ends move
    for kernel in system.kernels:
        errors = kg.check_kernel(kernel, x)
        assert max(errors[name] for name in ("gradient", "hessian")) < 1e-7
        assert max(errors[name] for name in ("symmetry", "force", "rigid")) < 1e-11
        assert errors["moment"] < 1e-8  # by a difference of turns


@pytest.mark.parametrize("rung", ["facet", "shell"])
def test_a_curved_rest_state_is_free_of_stress(rung: str) -> None:
    system = wavy(rung)
    forces, scale = system.forces(np.zeros_like(system.rest), 0.0)
    assert np.abs(forces).max() < system.noise and scale < system.noise


@pytest.mark.parametrize("rung", ["facet", "shell"])
def test_the_free_sheet_has_just_six_rigid_motions(rung: str) -> None:
    mesh = exact.sheet_mesh(1.0, 0.8, 3, random=True)
    model = kg.Model.from_mesh(mesh, thickness=0.05, material=kg.Material(1e3, 0.34), stiffness=rung)
    values = np.linalg.eigvalsh(kg.System(model).stiffness().toarray())
    assert np.all(np.abs(values[:6]) < 1e-10 * values[-1]) and values[6] > 1e-7 * values[-1]


@pytest.mark.parametrize("rung", ["facet", "shell"])
@pytest.mark.parametrize("random", [False, True])
@pytest.mark.parametrize("case", [exact.tension, exact.shear])
def test_uniform_strain_is_exact_on_any_mesh(rung: str, random: bool, case) -> None:
    assert case(rung, 3, random) == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("random", [False, True])
def test_pure_twist_is_exact_for_shell_facets(random: bool) -> None:
    assert exact.twist("shell", 4, random) == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("random", [False, True])
@pytest.mark.parametrize("case", [exact.cantilever, exact.euler])
def test_strips_of_shell_facets(random: bool, case) -> None:
    assert case("shell", 2, random) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("case", [exact.plate, exact.cylinder])
@pytest.mark.parametrize("random", [False, True])
def test_plates_of_shell_facets_converge_to_second_order(case, random: bool) -> None:
    coarse, fine = (abs(case("shell", across, random) - 1) for across in (4, 8))
    assert fine < 0.02
    assert math.log2(coarse / fine) > 1.6


def test_a_moment_rolls_a_strip_into_a_circle() -> None:
    assert exact.roll_up("shell", 4, False) == pytest.approx(1.0, abs=0.015)


def test_a_bent_strip_of_shell_facets_does_not_lock() -> None:
    """Large deflection of a cantilever under a dead tip load, P L^2 / E I = 5 (Bisshopp and Drucker, 1945)."""
    length, nu = 8.0, 0.0
    model, side = exact.sheet(length, 1.0, 1, False, "shell", nu=nu, thickness=0.005)
    model.add(kg.Fix(side("left"), clamp=True))
    inertia = 0.005**3 / 12
    load = 5 * exact.E * inertia / length**2
    model.add(kg.NodalLoad(side("right"), (0, 0, load / 2)))
    results = kg.LoadControl(model).run()
    end = results.position(side("right"))[-1].mean(axis=0)
    assert end[0] / length == pytest.approx(0.612372, abs=0.01)
    assert end[2] / length == pytest.approx(0.713792, abs=0.01)


def test_reactions_of_clamped_grips_balance() -> None:
    model, side = exact.sheet(2.0, 1.0, 3, True, "shell")
    model.add(kg.Fix(side("left"), clamp=True), kg.Prescribe(side("right"), x=0.01, y=0, z=0.2, clamp=True))
    results = kg.DisplacementControl(model).run()
    forces = results.reaction(side("left")) + results.reaction(side("right"))
    assert np.abs(forces).max() < 1e-8 * np.abs(results.reaction(side("left"))).max()


def test_metres_and_millimetres_agree() -> None:
    forces = []
    for unit in (1.0, 1e3):
        mesh = exact.sheet_mesh(2.0, 1.0, 2, True)
        mesh = kg.TriMesh(mesh.nodes * unit, mesh.triangles)
        model = kg.Model.from_mesh(
            mesh, thickness=0.02 * unit, material=kg.Material(1e6 / unit**2, 0.3), stiffness="shell"
        )
        left, right = model.select(boundary="left"), model.select(boundary="right")
        model.add(kg.Fix(left, clamp=True), kg.Prescribe(right, x=-0.01 * unit, z=0.2 * unit, y=0, clamp=True))
        forces.append(kg.DisplacementControl(model).run().reaction(right)[-1])
    assert forces[1] == pytest.approx(forces[0], rel=1e-6)


def test_wrong_facets_say_what_is_wrong() -> None:
    a, b, c = kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0)
    steel = kg.Material(2e11, 0.3)
    with pytest.raises(kg.ModelError, match="corners must differ"):
        kg.Facet(a, b, b, 0.1, steel)
    with pytest.raises(kg.ModelError, match="none of them a corner"):
        kg.Facet(a, b, c, 0.1, steel, neighbours=(a, None, None))
    model = kg.Model()
    model.add(a, b, c, kg.Facet(a, b, c, 0.1, steel))
    with pytest.raises(kg.ModelError, match="without area"):
        kg.System(model)
    twice = kg.Model()
    twice.add(kg.Node(0, 0), kg.Node(0, 0), kg.Node(2, 0))
    twice.add(kg.Facet(*twice.nodes, 0.1, steel))
    with pytest.raises(kg.ModelError, match="without area"):
        kg.System(twice)


def test_facets_work_in_the_plane_and_split_needs_space() -> None:
    mesh = exact.sheet_mesh(2.0, 1.0, 2, False)
    flat = kg.Model.from_mesh(mesh, thickness=0.1, material=kg.Material(1e3, 0.3), stiffness="facet", dim=2)
    flat.add(kg.Fix(flat.select(boundary="left"), "x"), kg.Prescribe(flat.select(boundary="right"), x=2e-6))
    flat.add(kg.Fix(flat.nodes[0], "y"))
    force = kg.LinearStatic(flat).run().reaction(flat.select(boundary="right"), "x")[-1]
    assert force == pytest.approx(1e3 * 0.1 * 1e-6, rel=1e-9)
    with pytest.raises(kg.ModelError, match="dim=3"):
        kg.Model.from_mesh(mesh, thickness=0.1, material=kg.Material(1e3), stiffness="shell", dim=2)


def test_results_of_shell_facets_survive_saving(tmp_path: Path) -> None:
    model, side = exact.sheet(2.0, 1.0, 2, True, "shell")
    model.add(kg.Fix(side("left"), clamp=True), kg.Prescribe(side("right"), z=0.1))
    results = kg.DisplacementControl(model).run()
    again = kg.load(results.save(tmp_path / "run.npz"))
    right = model.index(side("right"))
    assert np.array_equal(again.reaction(right), results.reaction(right))
    assert np.array_equal(again.energy["shell"], results.energy["shell"])
