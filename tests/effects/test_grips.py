"""Rigid grips and links: finite rotations on every rung, balances, and a twisted ribbon in closed form."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kirigami as kg
from kirigami.primitives.rotation import best_rotation, rate_of_spin, turn_curvature, turn_rates, turned

RUNGS = kg.stiffness.RUNGS
RANDOM = np.random.default_rng(4)


# ---- rotations


@pytest.mark.parametrize("size", [1e-9, 1e-3, 0.7, 0.999, 1.001, 3.0, math.pi, 8.0])
def test_rotations_and_their_derivatives(size: float) -> None:
    """Against another library's rotations, and derivatives against differences."""
    theta, arms, forces = RANDOM.normal(size=3), RANDOM.normal(size=(5, 3)), RANDOM.normal(size=(5, 3))
    theta *= size / np.linalg.norm(theta)
    wanted = Rotation.from_rotvec(theta).apply(arms)
    assert arms + turned(theta, arms) == pytest.approx(wanted, abs=1e-14)
    step = 1e-5

    def slope(function: Any) -> np.ndarray:
        ends = [(function(theta + step * e), function(theta - step * e)) for e in np.eye(3)]
        return np.stack([(after - before) / (2 * step) for after, before in ends], axis=-1)

    assert turn_rates(theta, arms) == pytest.approx(slope(lambda t: turned(t, arms)), abs=1e-9)
    pull = slope(lambda t: np.einsum("nij,ni->j", turn_rates(t, arms), forces))
    assert turn_curvature(theta, forces, arms) == pytest.approx(pull, abs=1e-8)
    spin = RANDOM.normal(size=3)
    assert turn_rates(theta, arms) @ rate_of_spin(theta, spin) == pytest.approx(np.cross(spin, wanted), abs=1e-12)
    found = Rotation.from_rotvec(best_rotation(arms, wanted)).apply(arms)
    assert found == pytest.approx(wanted, abs=1e-7 if size == math.pi else 1e-12)


# ---- the map in a system


def strip(rung: str, length: float = 1.0) -> kg.Model:
    """Three by two squares, one inner node moved."""
    x, y = np.meshgrid(np.linspace(0, 3, 4), np.linspace(0, 1, 3))
    points = length * np.column_stack([x.ravel(), y.ravel()])
    points[5] += length * np.array([0.1, 0.05])
    corners = [4 * row + column for row in range(2) for column in range(3)]
    facets = [facet for a in corners for facet in ((a, a + 1, a + 5), (a, a + 5, a + 4))]
    material = kg.Material(1e5 / length**2, 0.3)
    return kg.Model.from_mesh(kg.TriMesh(points, facets), 0.05 * length, material, stiffness=rung)


def ends(m: kg.Model) -> tuple[list[kg.Node], list[kg.Node]]:
    x = m.positions()[:, 0] / np.ptp(m.positions()[:, 0])
    return [m.nodes[k] for k in np.flatnonzero(x < 0.1)], [m.nodes[k] for k in np.flatnonzero(x > 0.6)]


@pytest.mark.parametrize("rung", RUNGS)
def test_residual_and_tangent_belong_to_the_energy(rung: str) -> None:
    """Gradient, Hessian and change with the load factor of the constrained system, by differences of its energy."""
    m = strip(rung)
    left, right = ends(m)
    m.add(kg.Fix(left, clamp=True), kg.Grip(right[:3], (None, 0.1, None), (1.3, None, None)), kg.RigidLink(right[3:]))
    m.add(kg.NodalLoad(right, (0.3, -0.2, 0.5)), kg.NodalLoad(m.nodes[5], (0.1, 0.1, -0.1), constant=True))
    s = kg.System(m)
    q, lam, step = RANDOM.normal(scale=0.03, size=s.free), 0.6, 1e-6

    def energy(q: np.ndarray, lam: float) -> float:
        return float(sum(s.energies(s.displacement(q, lam), lam).values()))

    def residual(q: np.ndarray, lam: float) -> np.ndarray:
        return s.imbalance(s.displacement(q, lam), lam)[0]

    u = s.displacement(q, lam)
    blocks = s.stiffness_blocks(u, lam)
    by_energy = [(energy(q + step * e, lam) - energy(q - step * e, lam)) / (2 * step) for e in np.eye(s.free)]
    columns = [(residual(q + step * e, lam) - residual(q - step * e, lam)) / (2 * step) for e in np.eye(s.free)]
    rate = (residual(q, lam + step) - residual(q, lam - step)) / (2 * step)
    motion = (s.displacement(q + step * q, lam + step) - s.displacement(q - step * q, lam - step)) / (2 * step)
    for found, wanted in (
        (residual(q, lam), np.array(by_energy)),
        (s.matrix(blocks).toarray(), np.stack(columns, axis=1)),
        (s.load_rate(u, lam, blocks), rate),
        (s.motion(q, 1.0, u), motion),
        (s.potential_rate(u, lam), (energy(q, lam + step) - energy(q, lam - step)) / (2 * step)),
    ):
        assert np.abs(found - wanted).max() <= 1e-7 * np.abs(wanted).max()


@pytest.mark.parametrize("rung", RUNGS)
def test_a_rigid_motion_costs_nothing(rung: str) -> None:
    """A sheet that is held by its grip alone follows it through more than a full turn, wherever it goes."""
    m = strip(rung)
    turn, move = np.array([2.0, -5.0, 4.0]), np.array([0.3, 0.2, -0.7])
    grip = ends(m)[1]
    m.add(kg.Grip(grip, move, turn))
    res = kg.DisplacementControl(m, targets=[0.25, 0.5, 0.75, 1.0]).run()
    x, centre = m.positions(), np.mean([[n.x, n.y, n.z] for n in grip], axis=0)
    for lam, position in zip(res.lam, res.position()):
        wanted = Rotation.from_rotvec(lam * turn).apply(x - centre) + centre + lam * move
        assert position == pytest.approx(wanted, abs=1e-6)
    assert max(sum(res.energy.values())) < 1e-10
    assert np.abs(res.reaction("driven_0")).max() < 1e-5


@pytest.mark.parametrize("rung", RUNGS)
def test_force_and_moment_of_a_grip_balance_those_of_the_clamp(rung: str) -> None:
    """And what both work is the energy stored: d(energy) = force times move + moment times spin."""
    m = strip(rung)
    left, right = ends(m)
    turn, move = np.array([0.5, 0.3, 0.2]), np.array([0.0, 0.1, -0.2])
    m.add(kg.Fix(left, clamp=True), kg.Grip(right, move, turn))
    res = kg.DisplacementControl(m, targets=[0.999, 1.0], to=1.001, tol=1e-11).run()
    at = int(np.argmin(np.abs(res.lam - 1)))
    force = [res.reaction(name)[at] for name in ("driven_0", "fixed_0")]
    moment = [res.moment(name, about=(0.3, 0.1, 0.2))[at] for name in ("driven_0", "fixed_0")]
    assert sum(force) == pytest.approx(np.zeros(3), abs=1e-7 * np.abs(force).max())
    assert sum(moment) == pytest.approx(np.zeros(3), abs=1e-7 * np.abs(moment).max())
    energy = sum(res.energy.values())
    rate = (energy[at + 1] - energy[at - 1]) / (res.lam[at + 1] - res.lam[at - 1])
    # the axis stands still, so the spin of the turn is its vector
    assert rate == pytest.approx(force[0] @ move + res.moment("driven_0")[at] @ turn, rel=1e-5)


def test_a_grip_that_is_moved_alone_is_a_prescribed_displacement() -> None:
    m, other = strip("shell"), strip("shell")
    left, right = ends(m)
    m.add(kg.Fix(left, clamp=True), kg.Grip(right, (0.01, 0.02, 0.3)))
    left, right = ends(other)
    other.add(kg.Fix(left, clamp=True), kg.Prescribe(right, 0.01, 0.02, 0.3))
    one, two = (kg.DisplacementControl(model, tol=1e-10).run() for model in (m, other))
    assert one[-1].u == pytest.approx(two[-1].u, abs=1e-7)
    assert one.reaction("driven_0")[-1] == pytest.approx(two.reaction("driven_0")[-1], rel=1e-6)


def test_a_hinged_grip_turns_as_statics_says() -> None:
    """A rigid arm on a pin, with a soft spring at one end and a force at the other: the moment about the pin is zero
    at any angle, the pin bears the rest, and load, displacement and arc length control meet."""
    m = kg.Model(dim=2)
    a, b, c, d = m.add(kg.Node(-1, 0), kg.Node(1, 0), kg.Node(-1, -2), kg.Node(0, 0.5))
    m.add(kg.Grip([a, b], (0, 0, 0), (0, 0, None)), kg.Bar(a, c, 3.0, strain="engineering"), kg.Bar(b, d, 1e-9))
    m.add(kg.Fix([c, d]), kg.NodalLoad(b, (0, -1.2)))
    res = kg.LoadControl(m, tol=1e-11).run()
    arm = res.position(b)[-1]
    assert np.linalg.norm(arm) == pytest.approx(1.0, abs=1e-12) and abs(arm[1]) > 0.5
    rod = res.position(c)[-1] - res.position(a)[-1]
    pull = res.bar_force[-1, 0] * rod / np.linalg.norm(rod)
    moment = np.cross(-arm, pull)[2] + np.cross(arm, [0, -1.2, 0])[2]
    assert abs(moment) < 1e-8
    assert res.reaction([a, b])[-1] == pytest.approx(-pull - [0, -1.2, 0], abs=1e-8)
    arc = kg.ArcLength(m, step=0.2, tol=1e-11, stop=lambda step: step.lam > 0.8).run()
    same = kg.LoadControl(m, to=float(arc.lam[-1]), tol=1e-11).run()
    assert arc[-1].u == pytest.approx(same[-1].u, abs=1e-8)


def test_a_free_body_with_a_link_has_six_rigid_motions() -> None:
    """They cost nothing, and all of them are named where a load asks for supports."""
    m = strip("plate")
    m.add(kg.RigidLink(ends(m)[1]))
    values = kg.Eigen(m, n=7).run().values
    assert np.abs(values[:6]).max() < 1e-9 * values[6]
    m.add(kg.NodalLoad(m.nodes[0], (1, 0, 0)))
    with pytest.raises(kg.MechanismError, match="translation along x.*rotation about z"):
        kg.LinearStatic(m).run()


def test_stages_go_on_from_a_turned_grip() -> None:
    """Held half way, the sheet stays; a second stage pulls it from there."""
    m = strip("shell")
    left, right = ends(m)
    m.add(kg.Fix(left, clamp=True), kg.Grip(right, (0, 0, 0), (1.0, 0, 0)))
    half = kg.DisplacementControl(m, to=0.5, tol=1e-10).run()
    m.hold(half[-1])
    m.add(kg.NodalLoad(m.nodes[5], (0, 0, 1e-9)))
    after = kg.LoadControl(m, start=half[-1], tol=1e-10).run()
    assert after[-1].u == pytest.approx(half[-1].u, abs=1e-6)


def test_results_of_grips_survive_saving(tmp_path: Any) -> None:
    m = strip("shell")
    left, right = ends(m)
    m.add(kg.Fix(left, clamp=True), kg.Grip(right, (0, 0, None), (0.4, 0, 0)))
    res = kg.DisplacementControl(m).run()
    back = kg.load(res.save(tmp_path / "grip"))
    assert back.moment("driven_0") == pytest.approx(res.moment("driven_0"), rel=1e-10, abs=1e-12)
    assert back.supports[1].kind == "Grip" and back.supports[1].driven


def test_the_unit_of_length_does_not_matter() -> None:
    found = []
    for length in (1.0, 1e3):
        m = strip("shell", length)
        left, right = ends(m)
        m.add(kg.Fix(left, clamp=True), kg.Grip(right, (0, 0, None), (0.4, None, 0)))
        res = kg.DisplacementControl(m).run()
        found.append((len(res), res.moment("driven_0")[-1] / length, res[-1].u / length))
    assert found[0][0] == found[1][0]
    assert found[1][1] == pytest.approx(found[0][1], rel=1e-6)
    assert found[1][2] == pytest.approx(found[0][2], abs=1e-8)


def test_masses_of_a_link_move_with_it() -> None:
    """A dumb-bell of two masses on a pin and a spring: omega^2 = k r^2 / (inertia about the pin)."""
    m = kg.Model(dim=2)
    a, b, c = m.add(kg.Node(-2, 0), kg.Node(1, 0), kg.Node(1, -3))
    m.add(kg.Bar(b, c, 6.0), kg.Fix(c), kg.Mass(a, 0.5), kg.Mass(b, 2.0))
    m.add(kg.Grip([a, b], (0, 0, 0), (0, 0, None)))
    value = kg.Eigen(m, n=1, mass="lumped").run().values[0]
    assert value == pytest.approx((6.0 / 3) * 1.5**2 / (0.5 * 1.5**2 + 2.0 * 1.5**2), rel=1e-9)


# ---- bad input


def test_what_cannot_be_is_refused() -> None:
    def tried(make: Any, dim: int = 3) -> None:
        m = kg.Model(dim=dim)
        nodes = m.add(*(kg.Node(x, y) for x, y in ((0, 0), (0, 1), (0, 2), (1, 0))))
        m.add(kg.Bar(nodes[0], nodes[3], 1.0), *make(nodes))
        kg.System(m)

    line = "lie on a line along .* cannot be asked to turn about it"
    for make, words in (
        (lambda n: [kg.Grip(n[0])], "one node is no rigid body"),
        (lambda n: [kg.Grip(n[:2], move=(1, 2))], "three values"),
        (lambda n: [kg.Grip(n[:2], turn=(1, 2, math.nan))], "turn along z"),
        (lambda n: [kg.Grip(n[:3], turn=(0, 0.2, 0))], line),
        (lambda n: [kg.Grip(n[:3], turn=(0, None, 0))], line),
        (lambda n: [kg.RigidLink(n[:3])], line),
        (lambda n: [kg.Grip(n[:3]), kg.Fix(n[0])], "both constrain x"),
        (lambda n: [kg.Grip(n[:3]), kg.RigidLink(n[2:])], "both constrain x|lie on a line"),
        (lambda n: [kg.Grip(n[:3]), kg.Tie(n[3], n[0])], "put it into the Grip instead"),
    ):
        with pytest.raises(kg.ModelError, match=words):
            tried(make)
    with pytest.raises(kg.ModelError, match="leaves the plane"):
        tried(lambda n: [kg.Grip(n[:2], turn=(0.1, 0, 0))], dim=2)
    same = kg.Model()
    a, b, c = same.add(kg.Node(0, 0), kg.Node(0, 0), kg.Node(1, 0))
    same.add(kg.Bar(a, c, 1.0), kg.Grip([a, b]))
    with pytest.raises(kg.ModelError, match="in one place"):
        kg.System(same)


# ---- the twisted ribbon


@pytest.mark.parametrize("twist", [0.03, pytest.param(0.25, marks=pytest.mark.long)])
def test_torque_of_a_twisted_ribbon(twist: float) -> None:
    """M = G b t^3 / 3 tau + E t b^5 tau^3 / 360 for a ribbon that is free to shorten: long fibres are stretched and the
    middle is pressed (Green, Proc. R. Soc. A 154 (1936), 430). tau is measured in the middle, away from the grips."""
    length, width, thickness, E, nu = 6.0, 1.0, 0.02, 1e6, 0.3
    x, y = np.meshgrid(np.linspace(0, length, 25), np.linspace(-width / 2, width / 2, 5))
    corners = [25 * row + column for row in range(4) for column in range(24)]
    facets = [
        facet
        for a in corners
        for facet in (
            ((a, a + 1, a + 26), (a, a + 26, a + 25)) if a % 2 else ((a, a + 1, a + 25), (a + 1, a + 26, a + 25))
        )
    ]
    mesh = kg.TriMesh(np.column_stack([x.ravel(), y.ravel()]), facets)
    m = kg.Model.from_mesh(mesh, thickness, kg.Material(E, nu), stiffness="shell")
    left, right = m.select(where=lambda x, y, z: x < 0.1), m.select(where=lambda x, y, z: x > length - 0.1)
    m.add(kg.Grip(left), kg.Grip(right, (None, 0, 0), (twist * length, 0, 0)))
    res = kg.DisplacementControl(m, on_instability="follow").run()

    def angle(station: float) -> float:
        row = m.select(where=lambda x, y, z: np.abs(x - station) < 1e-9)
        across = res.position(row[-1])[-1] - res.position(row[0])[-1]
        return math.atan2(across[2], across[1])

    tau = (angle(4.0) - angle(2.0)) / 2.0
    wanted = E / (2 * (1 + nu)) * width * thickness**3 / 3 * tau + E * thickness * width**5 * tau**3 / 360
    torque = res.moment("driven_0")[-1, 0]
    assert torque == pytest.approx(wanted, rel=0.02)
    assert abs(res.reaction("driven_0", "x")[-1]) < 1e-6 * E * thickness
