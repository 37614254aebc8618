"""The bending hinge: sign and size of its angle, gradient, continuity through flat and through half turns."""

from __future__ import annotations

import meshes
import numpy as np
import pytest
from meshes import Floats
from scipy.spatial.transform import Rotation

import kirigami as kg

EDGE, HEIGHT_I, HEIGHT_L = 1.7, 0.8, 1.3


def _points(fold: float, foot_i: float = 0.5, foot_l: float = 0.9) -> Floats:
    """Nodes i, j, k, l of a hinge along x whose wing i is folded up by an angle from flat."""
    wing = HEIGHT_I * np.array([np.cos(fold), np.sin(fold)])
    return np.array([[foot_i, *wing], [0, 0, 0], [EDGE, 0, 0], [foot_l, -HEIGHT_L, 0]])


def _hinge(points: Floats, stiffness: float = 1.0, rest_angle: float | None = None) -> kg.System:
    model = kg.Model()
    i, j, k, l = model.add(*(kg.Node(*point) for point in points))
    model.add(kg.BendHinge(i, j, k, l, stiffness, rest_angle=rest_angle))
    return kg.System(model)


def _angle_gradient(points: Floats) -> Floats:
    """Gradient of the angle, from two hinges that differ by one radian of rest angle alone."""
    flat = np.zeros_like(points)
    return _hinge(points, rest_angle=-0.5).gradient(flat) - _hinge(points, rest_angle=0.5).gradient(flat)


@pytest.mark.parametrize("fold", [-2.9, -1.2, -1e-3, -1e-9, 0.0, 1e-9, 1e-3, 0.7, 1.9, 3.1])
def test_angle_is_positive_towards_the_normal(fold: float) -> None:
    """Wing i folded up by `fold`: the normal of (j, k, i) at flat is +z, so the angle is +fold, to the last digit."""
    points = _points(fold)
    moment = _hinge(points, stiffness=2.0, rest_angle=0.0).gradient(np.zeros_like(points))
    # d(angle)/d(wing i) is 1 / height along the direction in which the fold grows.
    growing = np.array([0.0, -np.sin(fold), np.cos(fold)])
    assert moment[0] @ growing * HEIGHT_I / 2.0 == pytest.approx(fold, rel=1e-6, abs=1e-15)


def test_angle_of_either_wing_and_orientation() -> None:
    """Raising i or l by the same angle folds alike; reading the hinge line backwards flips the sign."""
    raised_i, raised_l = _points(0.3), _points(0.0)
    raised_l[3] = [0.9, -HEIGHT_L * np.cos(0.3), HEIGHT_L * np.sin(0.3)]
    backwards = raised_i[[0, 2, 1, 3]]
    angles = []
    for points in (raised_i, raised_l, backwards):
        (kernel,) = _hinge(points, rest_angle=0.0).kernels
        angles.append(kernel.deformation(points)[0])
    assert angles == pytest.approx([0.3, 0.3, -0.3], rel=1e-12)


@pytest.mark.parametrize("fold", [-3.0, -0.5, 0.0, 1.0, 2.8])
@pytest.mark.parametrize("feet", [(0.5, 0.9), (-0.6, 2.4)])
def test_gradient_is_one_over_height(fold: float, feet: tuple[float, float]) -> None:
    points = _points(fold, *feet)
    gradient = _angle_gradient(points)
    normal_i = np.array([0.0, -np.sin(fold), np.cos(fold)])
    normal_l = np.array([0.0, 0.0, 1.0])
    assert gradient[0] == pytest.approx(normal_i / HEIGHT_I, abs=1e-10)
    assert gradient[3] == pytest.approx(normal_l / HEIGHT_L, abs=1e-10)
    assert gradient.sum(axis=0) == pytest.approx(0, abs=1e-10)
    assert np.cross(points, gradient).sum(axis=0) == pytest.approx(0, abs=1e-10)


def test_kernel_is_consistent() -> None:
    for seed, fold in enumerate((-2.7, -0.8, 0.0, 0.4, 2.2)):
        points = _points(fold)
        (kernel,) = _hinge(_points(0.0), stiffness=1.7, rest_angle=0.1).kernels
        moved = points + 0.1 * np.random.default_rng(seed).normal(size=points.shape)
        errors = kg.check_kernel(kernel, moved)
        assert max(errors["gradient"], errors["hessian"]) < 1e-6
        assert max(errors["force"], errors["moment"], errors["rigid"]) < 1e-10
        assert errors["symmetry"] < 1e-12


def test_wings_do_not_couple() -> None:
    """The second derivative of the angle between wing i and wing l is zero: only k g g' is left in that block."""
    points = _points(0.9)
    system = _hinge(points, stiffness=3.0, rest_angle=-0.4)
    block = system.stiffness(np.zeros((4, 3)), constrained=False).toarray()[:3, 9:]
    gradient = _angle_gradient(points)
    assert block == pytest.approx(3.0 * np.outer(gradient[0], gradient[3]), abs=1e-10)


def test_tangent_at_rest_is_the_outer_product() -> None:
    points = _points(-1.1)
    tangent = _hinge(points, stiffness=3.0).stiffness(np.zeros((4, 3)), constrained=False).toarray()
    gradient = _angle_gradient(points).ravel()
    assert tangent == pytest.approx(3.0 * np.outer(gradient, gradient), abs=1e-10)


def test_stiffness_is_total_and_not_per_length() -> None:
    """Twice the hinge line, same stiffness: the moment for an angle stays the same."""
    forces = []
    for stretch in (1.0, 2.0):
        points = _points(0.6) * [stretch, 1.0, 1.0]
        forces.append(np.linalg.norm(_hinge(points, rest_angle=0.0).gradient(np.zeros((4, 3)))[0]))
    assert forces[0] == pytest.approx(forces[1], rel=1e-12) == pytest.approx(0.6 / HEIGHT_I, rel=1e-12)


def test_rigid_motion_is_free() -> None:
    points = _points(0.8)
    turned = points @ Rotation.from_rotvec([2.1, -0.7, 1.9]).as_matrix().T + [5.0, -3.0, 8.0]
    assert np.abs(_hinge(points).gradient(turned - points)).max() < 1e-13


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_folding_through_a_half_turn(side: float) -> None:
    """A wing driven by a dead load passes +-pi without a jump: k (theta - rest) = F h sin(direction - theta)."""
    rest, stiffness, direction = side * 2.7, 0.05, side * 4.4
    points = _points(rest)
    model = kg.Model()
    i, j, k, l = model.add(*(kg.Node(*point) for point in points))
    model.add(kg.BendHinge(i, j, k, l, stiffness, rest_angle=rest), kg.Bar(i, j, 1e4), kg.Bar(i, k, 1e4))
    force = np.array([0.0, np.cos(direction), np.sin(direction)])
    model.add(kg.Fix([j, k, l]), kg.NodalLoad(i, force))
    result = kg.LoadControl(model, to=1.0, step=0.02).run()
    angle = result.hinge_angle[:, 0]
    moment = HEIGHT_I * result.lam * np.sin(direction - angle)
    assert abs(angle[0]) < np.pi < 4.0 < abs(angle[-1])
    assert np.all(np.diff(side * angle) > 0)
    assert stiffness * (angle - rest) == pytest.approx(moment, abs=1e-3 * stiffness)
    assert result.hinge_moment[:, 0] == pytest.approx(stiffness * (angle - rest), rel=1e-12)


def test_angle_follows_committed_states_beyond_a_full_turn() -> None:
    """Committed step by step, the angle counts on past pi and 2 pi, both ways, and the moment with it."""
    system = _hinge(_points(0.0), stiffness=2.0)
    (kernel,) = system.kernels
    for fold in np.concatenate([np.linspace(0, 7, 15), np.linspace(7, -7, 29)]):
        displaced = _points(fold) - _points(0.0)
        force = system.gradient(displaced)[0]
        growing = np.array([0.0, -np.sin(fold), np.cos(fold)])
        assert force @ growing * HEIGHT_I == pytest.approx(2.0 * fold, abs=1e-9)
        assert kernel.deformation(_points(fold))[0] == pytest.approx(fold, abs=1e-9)
        system.commit(displaced)


def test_both_wings_driven_past_the_hinge_line() -> None:
    """Each wing sweeps 2 atan(1 / 0.3), together 292 degrees, more than an angle that is not tracked can tell."""
    model = kg.Model()
    points = [(0.5, 0.3, -1.0), (0, 0, 0), (1, 0, 0), (0.5, -0.3, -1.0), (2, 0, 0)]
    i, j, k, l, loose = model.add(*(kg.Node(*point) for point in points))
    model.add(kg.BendHinge(i, j, k, l, 2.0), kg.Bar(k, loose, 1.0), kg.Fix([j, k]), kg.Fix(loose, "yz"))
    model.add(kg.Fix([i, l], "xy"), kg.Prescribe([i, l], z=2.0))
    result = kg.DisplacementControl(model, to=1.0, step=0.05).run()
    sweep = 2 * np.arctan2(2 * result.lam - 1.0, 0.3)
    assert result.hinge_angle[:, 0] == pytest.approx(sweep, abs=1e-9)
    assert result.energy["hinges"] == pytest.approx((sweep - sweep[0]) ** 2, abs=1e-9)


@pytest.mark.parametrize("dim, rigid", [(3, 6), (2, 3)])
def test_free_flat_sheet_has_only_rigid_modes(dim: int, rigid: int) -> None:
    """Exactly 6 in space: hinges stiffen every out-of-plane mode of a flat sheet to first order; 3 in the plane."""
    nodes, triangles = meshes.equilateral_strip(3, 3)
    nodes = nodes + 0.1 * np.random.default_rng(0).uniform(-1, 1, nodes.shape)
    if dim == 3:
        model, _ = meshes.sheet(nodes, triangles)
    else:
        mesh = kg.TriMesh(nodes, triangles)
        model = kg.Model.from_mesh(mesh, 1.0, kg.Material(1.0), dim=2)
    values = np.linalg.eigvalsh(kg.System(model).stiffness(np.zeros((len(nodes), 3)), constrained=False).toarray())
    assert np.abs(values[:rigid]).max() < 1e-10 * values[-1]
    assert values[rigid] > 1e-4 * values[-1]
