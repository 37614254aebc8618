"""The three-node angle spring in the plane: angle, gradient, straight springs, wrap, and columns of rigid links."""

from __future__ import annotations

import meshes
import numpy as np
import pytest
from meshes import Floats
from scipy.optimize import brentq

import kirigami as kg

ARM_I, ARM_K = 0.8, 1.3


def _points(angle: float, heading: float = 0.3) -> Floats:
    """Nodes i, j, k: arm j->k at `heading`, arm j->i a counter-clockwise `angle` further."""
    towards_i = ARM_I * np.array([np.cos(heading + angle), np.sin(heading + angle)])
    towards_k = ARM_K * np.array([np.cos(heading), np.sin(heading)])
    return np.array([towards_i, [0, 0], towards_k]) + [0.2, -0.5]


def _spring(points: Floats, stiffness: float = 1.0, rest_angle: float | None = None) -> kg.System:
    model = kg.Model(dim=2)
    i, j, k = model.add(*(kg.Node(*point) for point in points))
    model.add(kg.TorsionSpring3(i, j, k, stiffness, rest_angle=rest_angle))
    return kg.System(model)


def _angle_gradient(points: Floats) -> Floats:
    still = np.zeros((3, 3))
    return (_spring(points, rest_angle=0.5).gradient(still) - _spring(points, rest_angle=1.5).gradient(still))[:, :2]


@pytest.mark.parametrize("angle", [1e-6, 0.4, np.pi - 1e-9, np.pi, np.pi + 1e-9, 4.0, 6.2])
def test_angle_is_counter_clockwise_in_the_full_turn(angle: float) -> None:
    """First value in [0, 2 pi); exact at pi, where an arc cosine is singular."""
    (kernel,) = _spring(_points(angle)).kernels
    assert kernel.deformation(_points(angle))[0] == pytest.approx(angle, abs=1e-12)


@pytest.mark.parametrize("angle", [0.1, 1.0, np.pi, 5.5])
def test_gradient_is_one_over_arm(angle: float) -> None:
    heading = 0.3
    gradient = _angle_gradient(_points(angle, heading))
    across_i = np.array([-np.sin(heading + angle), np.cos(heading + angle)])
    across_k = np.array([-np.sin(heading), np.cos(heading)])
    assert gradient[0] == pytest.approx(across_i / ARM_I, abs=1e-10)
    assert gradient[2] == pytest.approx(-across_k / ARM_K, abs=1e-10)
    assert gradient[1] == pytest.approx(-gradient[0] - gradient[2], abs=1e-10)


def test_kernel_is_consistent() -> None:
    for seed, angle in enumerate((0.2, 1.5, np.pi, 4.4, 6.0)):
        (kernel,) = _spring(_points(2.0), stiffness=1.7, rest_angle=0.6).kernels
        moved = _points(angle) + 0.1 * np.random.default_rng(seed).normal(size=(3, 2))
        errors = kg.check_kernel(kernel, moved)
        assert max(errors["gradient"], errors["hessian"]) < 1e-6
        assert max(errors["force"], errors["moment"], errors["rigid"]) < 1e-10
        assert errors["symmetry"] < 1e-12


def test_second_derivatives() -> None:
    """H_ii = N / a^2 - 2 (N a) a' / a^4 for the arm a = r_i - r_j, N the quarter turn; H_ik = 0; rows sum to zero."""
    stiffness, rest = 2.0, 0.7
    points = _points(1.9)
    arm_i, arm_k = points[0] - points[1], points[2] - points[1]
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])

    def second(arm: Floats) -> Floats:
        square = arm @ arm
        return quarter / square - 2 * np.outer(quarter @ arm, arm) / square**2

    gradient = _angle_gradient(points).ravel()
    moment = stiffness * (1.9 - rest)
    at_i, at_k = second(arm_i), -second(arm_k)
    zero = np.zeros((2, 2))
    curvature = np.block([[at_i, -at_i, zero], [-at_i, at_i + at_k, -at_k], [zero, -at_k, at_k]])
    expected = stiffness * np.outer(gradient, gradient) + moment * curvature
    tangent = _spring(points, stiffness, rest).stiffness(np.zeros((3, 3)), constrained=False).toarray()
    assert tangent == pytest.approx(expected, abs=1e-10)


def test_given_rest_angle_is_taken_literally() -> None:
    """Angle 0.3, rest angle 0.3 + 2 pi: one full turn of moment, and not none."""
    points = _points(0.3)
    force = _spring(points, stiffness=2.0, rest_angle=0.3 + 2 * np.pi).gradient(np.zeros((3, 3)))
    assert np.linalg.norm(force[0]) == pytest.approx(2.0 * 2 * np.pi / ARM_I, rel=1e-12)


@pytest.mark.parametrize("start, direction", [(0.6, -2.0), (5.7, 2 * np.pi + 2.0)])
def test_angle_passes_a_full_turn(start: float, direction: float) -> None:
    """An arm driven through the angle 0 = 2 pi by a dead load does not jump: k (a - a0) = F L sin(direction - a)."""
    stiffness = 0.3
    model = kg.Model(dim=2)
    i, j, k = model.add(*(kg.Node(*point) for point in _points(start, heading=0.0)))
    model.add(kg.TorsionSpring3(i, j, k, stiffness), kg.Bar(i, j, 1e4), kg.Fix([j, k]))
    model.add(kg.NodalLoad(i, (np.cos(direction), np.sin(direction))))
    result = kg.LoadControl(model, to=1.0, step=0.02).run()
    angle, half_turns = result.spring_angle[:, 0], np.round(start / np.pi)
    assert angle[0] == pytest.approx(start, abs=1e-12)
    assert (angle[0] - np.pi * half_turns) * (angle[-1] - np.pi * half_turns) < 0  # it went through
    assert np.abs(np.diff(angle)).max() < 1.0
    assert stiffness * (angle - start) == pytest.approx(
        ARM_I * result.lam * np.sin(direction - angle), abs=2e-3 * stiffness
    )
    assert result.spring_moment[:, 0] == pytest.approx(stiffness * (angle - start), rel=1e-12)
    position = result.position(i)[:, :2] - result.position(j)[:, :2]
    heading = np.unwrap(np.arctan2(position[:, 1], position[:, 0]))
    assert heading - heading[0] == pytest.approx(angle - start, abs=1e-9)


def test_angle_follows_committed_states_beyond_a_full_turn() -> None:
    """Committed step by step, the angle counts on beyond 2 pi and below 0, and the moment with it."""
    system = _spring(_points(1.0), stiffness=2.0)
    (kernel,) = system.kernels
    for angle in np.concatenate([np.linspace(1, 9, 17), np.linspace(9, -6, 31)]):
        displaced = np.column_stack([_points(angle) - _points(1.0), np.zeros(3)])
        across = np.array([-np.sin(0.3 + angle), np.cos(0.3 + angle)])
        assert system.gradient(displaced)[0, :2] @ across * ARM_I == pytest.approx(2.0 * (angle - 1.0), abs=1e-9)
        assert kernel.deformation(_points(angle))[0] == pytest.approx(angle, abs=1e-9)
        system.commit(displaced[:, :2])


def test_both_arms_driven_past_the_middle_node() -> None:
    """The arms sweep 2 atan(1 / 0.3) each, in opposite senses: 292 degrees, below zero where the angle began above."""
    model = kg.Model(dim=2)
    i, j, k, loose = model.add(kg.Node(0.3, 1.0), kg.Node(0, 0), kg.Node(-0.3, 1.0), kg.Node(2, 0))
    model.add(kg.TorsionSpring3(k, j, i, 2.0), kg.Bar(j, loose, 1.0), kg.Fix(j), kg.Fix(loose, "y"))
    model.add(kg.Fix([i, k], "x"), kg.Prescribe([i, k], y=-2.0))
    result = kg.DisplacementControl(model, to=1.0, step=0.05).run()
    heading = np.arctan2(1.0 - 2.0 * result.lam, 0.3)  # of the arm j->i; the other is its mirror image
    angle = np.pi - 2 * heading
    assert result.spring_angle[:, 0] == pytest.approx(angle, abs=1e-9)
    assert result.energy["springs"] == pytest.approx((angle - angle[0]) ** 2, abs=1e-9)


def test_spring_through_straight() -> None:
    """An arm driven through pi: smooth, no singularity of the kind an arc cosine has there."""
    stiffness = 50.0
    model = kg.Model(dim=2)
    i, j, k = model.add(kg.Node(-1.0, 0.3), kg.Node(0, 0), kg.Node(1, 0))
    model.add(kg.TorsionSpring3(i, j, k, stiffness), kg.Bar(i, j, 1e7), kg.Fix([j, k]), kg.Prescribe(i, y=-0.6))
    result = kg.DisplacementControl(model, to=1.0, step=0.125).run()
    length, y = np.hypot(1.0, 0.3), result.position(i)[:, 1]
    angle = np.pi - np.arcsin(y / length)
    moment = stiffness * (angle - angle[0])
    force = -moment / np.sqrt(length**2 - y**2)
    assert result.reaction(i, "y") == pytest.approx(force, abs=1e-4 * np.abs(force).max())


# ------------------------------------------------------------------------------------------------ rigid links


def test_clamped_link_under_dead_tip_load() -> None:
    """Two collinear unit bars, the first held, k = 50, EA = 1.5e6, tip load to 400: P = k phi / (L cos phi)."""
    model, nodes = meshes.chain(np.array([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]), 50.0, 1.5e6)
    model.add(kg.Fix(nodes[:2]), kg.NodalLoad(nodes[2], (0.0, 400.0)))
    result = kg.LoadControl(model, to=1.0, step=0.05).run()
    tip = result.u[:, 2, 1]
    for factor, lift in zip(result.lam, tip):
        load = 400.0 * factor
        # Bars of finite stiffness stretch by about P sin(phi) / EA = 2.6e-4, hence the tolerance.
        turn = brentq(lambda phi, load=load: 50.0 * phi - load * np.cos(phi), 0.0, np.pi / 2)
        assert lift == pytest.approx(np.sin(turn), abs=5e-4)
    assert tip[-1] > 0.98


def test_two_link_column() -> None:
    """Two links L = 1 with k = 1000 between, offset 0.01: P = 2 k (phi - phi0) / (L sin phi) to large rotations.

    The perfect column has P = 2 k phi / (L sin phi), P_cr = 2 k / L; the stress-free offset phi0 = 0.01 shifts the
    moment, not the lever.
    """
    stiffness, offset = 1000.0, 0.01
    rise = np.sqrt(1 - offset**2)
    model, nodes = meshes.chain(np.array([(0.0, 0.0), (offset, rise), (0.0, 2 * rise)]), stiffness, 3e9)
    model.add(kg.Fix(nodes[0]), kg.Fix(nodes[2], "x"), kg.Prescribe(nodes[2], y=-1.0))
    result = kg.DisplacementControl(model, to=1.0, step=0.02).run()
    start = np.arcsin(offset)
    found = -result.reaction(nodes[2], "y")
    length = 1 - found * rise / 3e9  # at the smallest load factors the strain of the links counts
    turn = np.arccos((rise - result.lam / 2) / length)
    load = 2 * stiffness * (turn - start) / np.sin(turn)
    assert found == pytest.approx(load, abs=1e-4 * 2 * stiffness)
    assert result.reaction(nodes[0], "y") == pytest.approx(-result.reaction(nodes[2], "y"), rel=1e-8, abs=1e-5)
    assert load[-1] > 2 * stiffness


@pytest.mark.parametrize("links", [2, 3, 5, 10, 40])
def test_hencky_chain_buckles_at_its_closed_form(links: int) -> None:
    """P_cr = (4 k / l) sin^2(pi / (2 N)) for pinned ends (Hencky 1920), where the lowest eigenvalue passes zero."""
    length, stiffness, axial = 0.5, 3.0, 1e8
    points = np.column_stack([length * np.arange(links + 1), np.zeros(links + 1)])
    model, nodes = meshes.chain(points, stiffness, axial)
    model.add(kg.Fix(nodes[0]), kg.Fix(nodes[-1], "y"))
    system = kg.System(model)

    def lowest(load: float) -> float:
        shortened = np.zeros((links + 1, 3))
        shortened[:, 0] = -load / axial * points[:, 0]
        return float(np.linalg.eigvalsh(system.stiffness(shortened).toarray())[0])

    critical = 4 * stiffness / length * np.sin(np.pi / (2 * links)) ** 2
    assert brentq(lowest, 0.5 * critical, 1.5 * critical, rtol=1e-9) == pytest.approx(critical, rel=1e-4)
    if links == 40:
        euler = np.pi**2 * stiffness * length / (links * length) ** 2  # EI = k l
        assert critical == pytest.approx(euler, rel=1e-3)


def test_stability_flag_of_a_perfect_column() -> None:
    """Shortening a perfect chain: every step below the critical load is stable, every one above it is not."""
    links, stiffness, axial = 6, 1.0, 1e3
    model, nodes = meshes.chain(np.column_stack([np.arange(links + 1.0), np.zeros(links + 1)]), stiffness, axial)
    critical = 4 * stiffness * np.sin(np.pi / (2 * links)) ** 2
    model.add(kg.Fix(nodes[0]), kg.Fix(nodes[-1], "y"), kg.NodalLoad(nodes[-1], (-1.0, 0.0)))
    result = kg.LoadControl(model, to=1.5 * critical, step=0.3 * critical).run()
    assert np.abs(result.u[:, :, 1]).max() < 1e-12
    assert np.array_equal(result.stable, result.lam < critical)
    assert result.stable.any() and not result.stable.all()


def test_plane_free_body_has_three_rigid_modes() -> None:
    model, nodes = meshes.chain(np.array([(0, 0), (1, 0.1), (2, -0.2), (3, 0.4)], dtype=float), 2.0, 30.0)
    values = np.linalg.eigvalsh(kg.System(model).stiffness(np.zeros((4, 3)), constrained=False).toarray())
    assert np.abs(values[:3]).max() < 1e-10 * values[-1]
    assert values[3] > 1e-3 * values[-1]
    assert len(nodes) == 4
