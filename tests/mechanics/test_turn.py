"""kg.Turn: nodes that turn like a rigid body, through any angle."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

import kirigami as kg

pytestmark = pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")  # coarse meshes of bars


def strip(rung: str, nu: float = 0.3, length: float = 1.0) -> kg.Model:
    mesh = kg.Sheet(shapely.box(0, 0, 0.2, length)).mesh(0.1)
    return kg.Model.from_mesh(mesh, thickness=0.002, material=kg.Material(E=1e9, nu=nu), stiffness=rung)


STRIPS = [(rung, axis, 0.1, 200) for rung in ("plate", "facet", "shell") for axis in "xyz"]
EDGES = [("shell", axis, 0.0, 200) for axis in "xyz"]
EDGES += [(rung, axis, 0.0, 150) for rung in ("plate", "facet") for axis in "yz"]


@pytest.mark.parametrize("rung, axis, grip, angle", STRIPS + EDGES)
def test_a_free_sheet_goes_along_like_a_rigid_body(rung: str, axis: str, grip: float, angle: float) -> None:
    """Turned at one end and shifted: no energy, and every node where the rotation takes it."""
    m = strip(rung, length=0.5)
    held = m.select(box=(0, 0, 1, grip))
    m.add(kg.Turn(held, angle, axis, about=(0.05, 0.02, 0.0), shift=(0.1, 0.2, 0.3), clamp=True))
    res = kg.DisplacementControl(m, targets=np.linspace(0.05, 1, 20)).run()
    arms = res.rest - (0.05, 0.02, 0.0)
    turn = np.radians(angle)
    unit = np.eye(3)["xyz".index(axis)]
    there = arms * np.cos(turn) + np.cross(unit, arms) * np.sin(turn) + np.outer(arms @ unit, unit) * (1 - np.cos(turn))
    assert res.position()[-1] == pytest.approx(there + (0.15, 0.22, 0.3), abs=1e-6)
    assert max(float(np.abs(values).max()) for values in res.energy.values()) < 1e-12 * 1e9 * 0.002 * 0.2
    assert res.stable.all()


def test_a_truss_on_an_arc() -> None:
    """A bar from a fixed node to one that runs round a circle: its length by the law of cosines at every step."""
    m = kg.Model(dim=2)
    pin, hub, rider = m.add(kg.Node(3, 0), kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(pin, rider, EA=1.0, strain="engineering"), kg.Bar(hub, rider, EA=1.0), kg.Fix([pin, hub]))
    m.add(kg.Turn(rider, 360, "z", about=(0, 0)))
    res = kg.DisplacementControl(m, targets=np.linspace(0.1, 1, 10)).run()
    angle = 2 * np.pi * res.lam
    length = np.sqrt(1 + 9 - 6 * np.cos(angle))
    assert res.bar_strain[:, 0] == pytest.approx((length - 2) / 2, abs=1e-12)
    assert res.bar_strain[:, 1] == pytest.approx(0, abs=1e-12)


def twisted(rung: str, degrees: float) -> kg.Results:
    m = strip(rung, nu=0.0)
    m.add(kg.Fix(m.select(boundary="bottom"), clamp=True))
    m.add(kg.Turn(m.select(boundary="top"), degrees, "y", clamp=True))
    return kg.DisplacementControl(m, targets=np.linspace(0.1, 1, 10)).run()


def torque(res: kg.Results, top: np.ndarray) -> np.ndarray:
    arms = res.position()[:, top] - res.position()[:, top].mean(axis=1, keepdims=True)
    return np.cross(arms, res._gradients[:, top])[..., 1].sum(axis=1)


def test_the_torque_of_a_small_twist_and_its_work() -> None:
    """T = G b t^3 / 3 at small twist (St Venant; the clamped ends add some), and the work of the turn is the energy."""
    res = twisted("shell", 2.0)
    top = np.flatnonzero(res.rest[:, 1] > 1 - 1e-9)
    angle = np.radians(2.0) * res.lam
    thin = 0.5e9 * 0.2 * 0.002**3 / 3 * angle
    assert torque(res, top)[1] / thin[1] == pytest.approx(1.05, abs=0.07)
    large = twisted("shell", 60.0)
    angle = np.radians(60.0) * large.lam
    energy = sum(large.energy.values())
    # T = a x + b x^3 + c x^5: fitted to the torques, and integrated
    basis = np.column_stack([angle, angle**3, angle**5])
    fitted = np.linalg.lstsq(basis, torque(large, top), rcond=None)[0]
    work = (basis * np.column_stack([angle / 2, angle / 4, angle / 6])) @ fitted
    assert work[-1] == pytest.approx(energy[-1], rel=0.01)


def test_a_turn_is_held_in_the_next_stage() -> None:
    m = strip("shell")
    grip = m.select(box=(0, 0, 1, 0.1))
    turn = kg.Turn(grip, 90, "y", clamp=True)
    m.add(turn)
    first = kg.DisplacementControl(m, targets=[0.25, 0.5, 0.75]).run()
    m.hold(first[-1])
    m.add(kg.Prescribe(m.select(index=int(np.argmax(first.rest[:, 1]))), x=0.01))
    second = kg.DisplacementControl(m, start=first[-1]).run()
    held = m.index(grip)
    assert second.u[-1, held] == pytest.approx(first.u[-1, held], abs=1e-9)


def test_linear_analyses_take_the_rate_at_rest() -> None:
    m = kg.Model(dim=2)
    hub, rider = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(hub, rider, EA=1.0), kg.Fix(hub), kg.Turn(rider, 90, "z", about=(0, 0)))
    assert kg.LinearStatic(m).run().u[-1, 1] == pytest.approx((0, np.pi / 2, 0))


@pytest.mark.parametrize("rung", ["plate", "facet"])
def test_an_edge_turned_about_itself_is_refused_where_its_facets_cannot_know(rung: str) -> None:
    m = strip(rung)
    m.add(kg.Turn(m.select(boundary="bottom"), 10, "x", clamp=True))
    with pytest.raises(kg.ModelError, match="about itself"):
        kg.DisplacementControl(m).run()


def test_what_turns_nothing_or_out_of_the_plane_is_refused() -> None:
    m = kg.Model(dim=2)
    hub, rider = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(hub, rider, EA=1.0), kg.Fix(hub))
    with pytest.raises(kg.ModelError, match="no direction"):
        kg.Turn(rider, 10, (0, 0, 0))
    with pytest.raises(kg.ModelError, match="more than 100 turns"):
        kg.Turn(rider, 1e6)
    m.add(kg.Turn(rider, 10, "x"))
    with pytest.raises(kg.ModelError, match="only axis='z'"):
        kg.DisplacementControl(m).run()
    other = kg.Model(dim=2)
    a, b, c = other.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    other.add(kg.Bar(a, b, EA=1.0), kg.Bar(b, c, EA=1.0), kg.Fix(a), kg.Turn(c, 10, about=(0, 0)))
    with pytest.raises(kg.ModelError, match="straight line"):
        kg.ArcLength(other, step=0.1).run()
