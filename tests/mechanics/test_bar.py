"""The bar against its closed forms: force laws, tangent, invariances, and strains too small for squared lengths."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from meshes import Floats
from scipy.spatial.transform import Rotation

import kirigami as kg

EA, LENGTH = 7.0, 2.5
OPTIONS = {
    "green": {"strain": "green"},
    "engineering": {"strain": "engineering"},
    "ogden": {"strain": "green", "law": "ogden"},
}


def _axial_force(name: str, length: float) -> float:
    """Force along a bar of rest length LENGTH, positive in tension."""
    stretch = length / LENGTH
    if name == "engineering":
        return EA * (length - LENGTH) / LENGTH
    if name == "green":
        return EA * (length**2 - LENGTH**2) / (2 * LENGTH**2) * stretch
    return EA / 4 * (stretch**3 - 1 / stretch) * stretch


def _energy(name: str, length: float) -> float:
    stretch = length / LENGTH
    if name == "engineering":
        return EA * LENGTH * (stretch - 1) ** 2 / 2
    if name == "green":
        return EA * LENGTH * (stretch**2 - 1) ** 2 / 8
    return EA * LENGTH / 4 * ((stretch**5 - 1) / 5 - (stretch - 1))


def _one_bar(start: Any = (0.1, -0.4, 0.3), **options: Any) -> tuple[kg.System, Floats]:
    direction = np.array([2.0, -1.0, 2.0]) / 3.0
    rest = np.array([start, start + LENGTH * direction])
    model = kg.Model()
    nodes = model.add(*(kg.Node(*point) for point in rest))
    model.add(kg.Bar(*nodes, EA, **options))
    return kg.System(model), rest


@pytest.mark.parametrize("name", OPTIONS)
@pytest.mark.parametrize("stretch", [0.3, 0.9, 1.0 + 1e-7, 1.4, 2.5])
def test_force_and_energy_follow_the_law(name: str, stretch: float) -> None:
    system, rest = _one_bar(**OPTIONS[name])
    direction = np.array([-0.6, 0.0, 0.8])
    displaced = np.array([rest[0], rest[0] + stretch * LENGTH * direction]) - rest
    force = _axial_force(name, stretch * LENGTH) * direction
    scale = max(np.abs(force).max(), EA * 1e-9)
    assert system.gradient(displaced) == pytest.approx(np.array([-force, force]), abs=1e-10 * max(scale, EA * 1e-5))
    (kernel,) = system.kernels
    assert kernel.evaluate(rest + displaced).energy.sum() == pytest.approx(
        _energy(name, stretch * LENGTH), rel=1e-10, abs=1e-15 * EA
    )


@pytest.mark.parametrize("name", OPTIONS)
def test_rest_length_prestresses(name: str) -> None:
    model = kg.Model(dim=2)
    a, b = model.add(kg.Node(0, 0), kg.Node(3.0, 0))
    model.add(kg.Bar(a, b, EA, rest_length=LENGTH, **OPTIONS[name]))
    force = _axial_force(name, 3.0)
    assert kg.System(model).gradient(np.zeros((2, 3)))[:, 0] == pytest.approx([-force, force], rel=1e-10)


@pytest.mark.parametrize("name", OPTIONS)
def test_laws_agree_to_first_order_only(name: str) -> None:
    """Any two laws differ by order strain^2: the departure from E A e, over e, falls in proportion to e."""
    departure = []
    for strain in (1e-3, 1e-4):
        system, rest = _one_bar(**OPTIONS[name])
        displaced = np.array([rest[0] * 0, (rest[1] - rest[0]) * strain])
        force = np.linalg.norm(system.gradient(displaced)[1])
        departure.append(abs(force / (EA * strain) - 1))
    if name == "engineering":
        assert max(departure) < 1e-10
    else:
        assert departure[0] / departure[1] == pytest.approx(10.0, rel=0.02)


@pytest.mark.parametrize("name", OPTIONS)
def test_kernel_is_consistent(name: str) -> None:
    system, rest = _one_bar(**OPTIONS[name])
    (kernel,) = system.kernels
    for seed in range(4):
        moved = rest + 0.4 * LENGTH * np.random.default_rng(seed).normal(size=rest.shape)
        errors = kg.check_kernel(kernel, moved)
        assert max(errors["gradient"], errors["hessian"]) < 1e-6
        assert max(errors["force"], errors["moment"], errors["rigid"]) < 1e-10
        assert errors["symmetry"] < 1e-12


@pytest.mark.parametrize("name", OPTIONS)
def test_tangent_is_material_plus_geometric(name: str) -> None:
    """K = dN/dl d d' + N/l (1 - d d'), d the current direction, N the axial force, for any law."""
    system, rest = _one_bar(**OPTIONS[name])
    length, direction = 1.3 * LENGTH, np.array([0.0, 0.6, 0.8])
    displaced = np.array([rest[0], rest[0] + length * direction]) - rest
    h = 1e-5 * LENGTH
    slope = (_axial_force(name, length + h) - _axial_force(name, length - h)) / (2 * h)
    along = np.outer(direction, direction)
    block = slope * along + _axial_force(name, length) / length * (np.eye(3) - along)
    expected = np.block([[block, -block], [-block, block]])
    tangent = system.stiffness(displaced, constrained=False).toarray()
    assert tangent == pytest.approx(expected, abs=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("name", OPTIONS)
def test_rigid_motion_is_free(name: str) -> None:
    system, rest = _one_bar(**OPTIONS[name])
    turned = rest @ Rotation.from_rotvec([2.1, -0.7, 1.9]).as_matrix().T + [5.0, -3.0, 8.0]
    assert np.abs(system.gradient(turned - rest)).max() < 1e-13 * EA * 10


@pytest.mark.parametrize("name", OPTIONS)
def test_tiny_strain_far_from_the_origin(name: str) -> None:
    """A strain of 1e-10 on a bar 1e5 lengths away keeps ten digits: it is not a difference of squared lengths."""
    strain = 1e-10
    system, rest = _one_bar(start=(1e5 * LENGTH, 3e5 * LENGTH, 0.0), **OPTIONS[name])
    direction = (rest[1] - rest[0]) / np.linalg.norm(rest[1] - rest[0])
    displaced = np.array([np.zeros(3), strain * LENGTH * direction])
    force = system.gradient(displaced)[1] @ direction
    assert force == pytest.approx(EA * strain, rel=1e-8)


def test_plane_bar_is_the_space_bar() -> None:
    displaced = np.array([[0.2, -0.1, 0.0], [0.5, 0.9, 0.0]])
    gradients = []
    for dim in (2, 3):
        model = kg.Model(dim=dim)
        a, b = model.add(kg.Node(0, 0), kg.Node(1.5, 0.5))
        model.add(kg.Bar(a, b, EA))
        gradients.append(kg.System(model).gradient(displaced))
    assert gradients[0] == pytest.approx(gradients[1], rel=1e-14)


@pytest.mark.parametrize("dim, rigid", [(2, 3), (3, 6)])
def test_free_triangle_has_only_rigid_modes(dim: int, rigid: int) -> None:
    model = kg.Model(dim=dim)
    a, b, c = model.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0.3, 0.8))
    model.add(kg.Bar(a, b, EA), kg.Bar(b, c, EA), kg.Bar(c, a, EA))
    stiffness = kg.System(model).stiffness(np.zeros((3, 3)), constrained=False).toarray()
    values = np.linalg.eigvalsh(stiffness)
    assert np.abs(values[:rigid]).max() < 1e-10 * values[-1]
    assert values[rigid:].min() > 1e-3 * values[-1]


def test_hanging_bar_by_load_control() -> None:
    """One bar pulled along itself: the load follows the law at every stored step."""
    model = kg.Model()
    a, b = model.add(kg.Node(0, 0), kg.Node(LENGTH, 0))
    model.add(kg.Bar(a, b, EA), kg.Fix(a), kg.Fix(b, "yz"), kg.NodalLoad(b, (0.5 * EA, 0, 0)))
    result = kg.LoadControl(model, to=1.0, step=0.25).run()
    for factor, displacement in zip(result.lam, result.u[:, 1, 0]):
        assert _axial_force("green", LENGTH + displacement) == pytest.approx(0.5 * EA * factor, abs=1e-7 * EA)
    assert result.lam[-1] == pytest.approx(1.0, abs=1e-14)
    assert result.bar_force[:, 0] == pytest.approx(0.5 * EA * result.lam, abs=1e-7 * EA)
    length = LENGTH + result.u[:, 1, 0]
    assert result.bar_strain[:, 0] == pytest.approx((length**2 / LENGTH**2 - 1) / 2, abs=1e-12)
    assert result.reaction(a, "x")[-1] == pytest.approx(-0.5 * EA, rel=1e-7)
