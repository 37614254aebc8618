"""Contact with a surface that moves: carried, dragged, lifted and turned, at rest and in time."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from held_to_differences import assert_right, kernel_of

import kirigami as kg

MU, DEPTH, LAYER, STIFFNESS = 0.3, 2e-3, 1e-3, 1e4
PRESS = STIFFNESS * (DEPTH - LAYER / 2)
TARGETS = np.linspace(0.02, 1, 30)


def dragged(far_end: float, plane: float) -> kg.Results:
    """A node is pressed on a plane; then the far end of its bar is dragged, or the plane beneath it."""
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, 100.0, strain="engineering"), kg.Spring(a, (0, 1.0)), kg.NodalLoad(a, (0, -PRESS)))
    fixed = m.add(kg.Fix(b))
    ground = kg.Plane((0, 0), (0, 1))
    touch = m.add(kg.Contact(a, ground, stiffness=STIFFNESS, layer=LAYER, friction=MU))
    pressed = kg.LoadControl(m).run()
    m.hold(pressed[-1])
    if plane:
        m.remove(touch)
        m.add(kg.Contact(a, kg.Moving(ground, (plane, 0)), stiffness=STIFFNESS, layer=LAYER, friction=MU))
    else:
        m.remove(fixed)
        m.add(kg.Fix(b, "y"), kg.Prescribe(b, x=far_end))
    return kg.LoadControl(m, targets=TARGETS, start=pressed[-1]).run()


def test_a_plane_dragged_beneath_a_block_is_a_block_dragged_over_a_plane() -> None:
    by_block, by_plane = dragged(0.1, 0.0), dragged(0.0, -0.1)
    assert np.abs(by_block.force("friction") - by_plane.force("friction")).max() < 1e-12 * PRESS
    assert by_plane.reaction(1, "x") == pytest.approx(by_block.reaction(1, "x"), abs=1e-12 * PRESS)
    share = np.linalg.norm(by_plane.deformation("friction")[:, 0], axis=1)
    slides = share > 1 - 1e-9
    assert slides[-1] and not slides[1]  # stick and slip are told of the way against the surface
    pressed = by_plane.force("contact")[:, 0]
    assert by_plane.reaction(1, "x")[slides] == pytest.approx(MU * pressed[slides], rel=1e-3)


SHAPES = {
    "plane": kg.Plane((0, 0, 0), (0.1, 0.2, 1)),
    "cylinder": kg.Cylinder((0, 0, -2), (0.1, 1, 0), 2.0),
    "sphere": kg.Sphere((0, 0, -2), 2.0),
}
MOTIONS: dict[str, dict[str, Any]] = {
    "in proportion": {"shift": (0.1, -0.02, 0.03), "angle": 20.0, "axis": (1, 2, 3)},
    "by a table": {"shift": [(0, 0, 0.02), (0.1, 0.05, 0)], "angle": [5.0, 20.0], "axis": "x", "at": [0.5, 1.0]},
}


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("shape", SHAPES)
def test_kernels_belong_to_their_energies_and_change_with_the_load_factor(shape: str, motion: str) -> None:
    m = kg.Model()
    a, b = m.add(kg.Node(0.1, 0, 0.5), kg.Node(-0.2, 0.1, 0.5))
    surface = kg.Moving(SHAPES[shape], **MOTIONS[motion])
    m.add(kg.Bar(a, b, 1.0), kg.Contact([a, b], surface, stiffness=5.0, layer=0.02, friction=MU))
    contact, friction = kernel_of(m, "contact"), kernel_of(m, "friction")
    x = np.array([[0.1, 0, 0.02], [-0.2, 0.1, 0.01]])
    gap, normal = contact.normals(x, 0.7)
    x -= (gap + [-0.005, 0.03])[:, None] * normal  # one in the layer, one deep
    assert contact.deformation_at(x, 0.7) == pytest.approx([0.005, -0.03])
    assert_right(contact, x, lam=0.7)
    friction.commit_at(x, 0.7)
    friction.history = friction.history + np.array([0.004, 0.01])[:, None] * np.eye(1, friction.history.shape[1])
    for lam in (0.71, 0.9):
        assert_right(friction, x, lam=lam)


def test_what_sticks_is_carried_and_turned() -> None:
    """A bar lies on a turntable that is lifted and turned by a right angle; nothing holds it but friction."""
    m = kg.Model()
    a, b = m.add(kg.Node(1, 0, 0), kg.Node(2, 0, 0))
    m.add(kg.Bar(a, b, 100.0), kg.Spring([a, b], (1e-9, 1e-9, 1e-9)), kg.NodalLoad([a, b], (0, 0, -1), constant=True))
    table = kg.Moving(kg.Plane(), [(0, 0, 0), (0, 0, 0.5)], [90, 90], about=(0, 0), at=[0.5, 1])
    m.add(kg.Contact([a, b], table, stiffness=STIFFNESS, layer=LAYER, friction=MU))
    res = kg.LoadControl(m, targets=np.linspace(0.05, 1, 20)).run()
    x = res.position()
    turned, lifted = x[int(np.argmin(np.abs(res.lam - 0.5)))], x[-1]
    assert turned[:, :2] == pytest.approx(np.array([[0, 1], [0, 2]]), abs=1e-6)
    assert lifted - turned == pytest.approx(np.array([[0, 0, 0.5]] * 2), abs=1e-6)
    assert np.linalg.norm(res.deformation("friction"), axis=2).max() < 1e-6


def test_a_belt_round_a_cylinder_that_turns() -> None:
    """Capstan: the belt is at rest, the cylinder turns beneath it; tensions at its ends differ by exp(mu angle)."""
    angle, count, tension = np.pi / 2, 24, 1.0
    at = np.linspace(0, angle, count + 1)
    m = kg.Model(dim=2)
    first, last = m.add(kg.Node(1, -0.4), kg.Node(-0.4, 1))
    belt = m.add(*(kg.Node(float(np.cos(t)), float(np.sin(t))) for t in at))
    for a, b in pairwise([first, *belt, last]):
        length = float(np.hypot(a.x - b.x, a.y - b.y))
        m.add(kg.Bar(a, b, 100.0, rest_length=length / (1 + tension / 100), strain="engineering"))
    drum = kg.Moving(kg.Cylinder((0, 0), (0, 0, 1), 1.0), angle=-8.0)
    m.add(kg.Contact(belt, drum, stiffness=200.0, layer=5e-3, friction=MU))
    m.add(kg.NodalLoad(first, (0, -tension), constant=True), kg.Spring(first, (1e-3, 0)), kg.Fix(last))
    res = kg.LoadControl(m, targets=np.linspace(0.02, 1, 40), on_instability="follow").run()
    share = np.linalg.norm(res.deformation("friction")[-1], axis=1)
    pressing = res.force("contact")[-1] > 1e-2
    assert pressing.sum() > 20 and share[pressing].min() > 0.99
    pulls = res.reaction(last)[-1]
    assert -pulls[0] / tension == pytest.approx(np.exp(MU * angle), rel=0.01)


@pytest.mark.parametrize("scheme", ["conserving", "damped"])
def test_a_block_on_a_belt_in_time_gets_the_speed_of_the_belt(scheme: str) -> None:
    """It is dragged by mu N until it goes with the belt: v = mu N t / m, and from t = m V / (mu N) on v = V."""
    mass, speed, weight, end = 2.0, 0.5, 3.0, 2.0
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, 1e3), kg.Mass([a, b], mass / 2), kg.Spring([a, b], (1e-4, 1e-4)))
    m.add(kg.NodalLoad([a, b], (0, -weight / 2)))
    ground = kg.Plane((0, 0), (0, 1))
    touch = m.add(kg.Contact([a, b], ground, stiffness=1e4, layer=1e-3, friction=MU))
    pressed = kg.LoadControl(m).run()
    m.hold(pressed[-1])
    m.remove(touch)
    belt = kg.Moving(ground, (speed * end, 0))
    m.add(kg.Contact([a, b], belt, stiffness=1e4, layer=1e-3, friction=MU))
    res = kg.Dynamics(m, end=end, step=0.02, load=[(0, 0), (end, 1)], start=pressed[-1], scheme=scheme).run()
    together = mass * speed / (MU * weight)
    wanted = np.minimum(res.time / together, 1.0) * speed
    apart = np.abs(res.time - together) > 0.1
    assert res.velocity[apart, 0, 0] == pytest.approx(wanted[apart], abs=0.05 * speed)


def test_what_stands_where_an_earlier_stage_has_brought_it(tmp_path: Any) -> None:
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, 100.0), kg.Spring([a, b], (2.0, 3.0)))
    ground = kg.Plane((0, 0), (0, 1))
    lifted_and_dragged = kg.Moving(ground, [(0, 0.1), (0.5, 0.1)], at=[0.4, 1])
    m.add(kg.Contact([a, b], lifted_and_dragged, stiffness=1e3, layer=1e-3, friction=MU))
    moved = kg.LoadControl(m, targets=np.linspace(0.05, 1, 20)).run()
    assert moved.u[-1, :, 1].min() > 0.09 and moved.force("contact")[-1].min() > 0.2
    m.hold(moved[-1])
    m.add(kg.NodalLoad(b, (0.1, 0.0)))
    after = kg.LoadControl(m, targets=[1.0], start=moved[-1]).run()
    assert after.u[0] == pytest.approx(moved.u[-1], abs=1e-7)
    assert after.force("contact")[0] == pytest.approx(moved.force("contact")[-1], rel=1e-5)
    back = kg.load(after.save(tmp_path / "moved"))
    for name in ("contact", "friction"):
        assert back.force(name) == pytest.approx(after.force(name), rel=1e-12)
    back = kg.load(moved.save(tmp_path / "moving"))
    assert back.force("friction") == pytest.approx(moved.force("friction"), rel=1e-12)
    assert back.energy["contact"] == pytest.approx(moved.energy["contact"], rel=1e-12)


def test_what_does_not_move_is_refused_and_so_is_a_turn_out_of_the_plane() -> None:
    plane = kg.Plane((0, 0), (0, 1))
    for arguments, words in [
        ({}, "does not move"),
        ({"shift": (1, 0), "at": [1.0, 0.5]}, "rise"),
        ({"shift": (1, 0), "at": [0.0, 0.5]}, "positive"),
        ({"angle": 3.0, "axis": (0, 0, 0)}, "no direction"),
        ({"angle": [3.0, 4.0]}, "angle"),
    ]:
        with pytest.raises(kg.ModelError, match=words):
            kg.Moving(plane, **arguments)
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, 1.0), kg.Contact(a, kg.Moving(plane, angle=3.0, axis="x")))
    with pytest.raises(kg.ModelError, match="out of the plane"):
        kg.System(m)
