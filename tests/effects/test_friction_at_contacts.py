"""Coulomb friction at contacts: a block on a plane, and a belt round a cylinder."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from held_to_differences import assert_right, kernel_of

import kirigami as kg

MU = 0.3


DEPTH, LAYER, STIFFNESS = 2e-3, 1e-3, 1e4
PRESS = STIFFNESS * (DEPTH - LAYER / 2)


def block(mu: float = MU) -> tuple[kg.Model, kg.Node, kg.Node]:
    """A node pushed into the ground, so that it is pressed by PRESS, with a bar to drag it."""
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, 100.0, strain="engineering"), kg.Fix(b), kg.Prescribe(a, y=-DEPTH))
    m.add(kg.Contact(a, kg.Plane((0, 0), (0, 1)), stiffness=STIFFNESS, layer=LAYER, friction=mu))
    return m, a, b


def test_the_kernel_belongs_to_its_energy() -> None:
    m, a, _ = block()
    kernel = kernel_of(m, "friction")
    kernel.commit(np.array([[0.0, -0.01], [1, 0]]))
    for way in (3e-4, 0.02):  # sticks, slides
        assert_right(kernel, [[way, -0.01], [1, 0]])


def test_a_block_sticks_and_then_slides_at_mu_n() -> None:
    m, a, b = block()
    pressed = kg.DisplacementControl(m).run()
    m.hold(pressed[-1])
    m.remove(m.constraints[0])
    m.add(kg.Fix(b, "y"), kg.Prescribe(b, x=0.1))
    res = kg.DisplacementControl(m, targets=np.linspace(0.02, 1, 30), start=pressed[-1]).run()
    pull = res.reaction(b, "x")
    share = np.linalg.norm(res.deformation("friction")[:, 0], axis=1)
    slides = share > 1 - 1e-9
    assert slides[-1] and not slides[1]
    assert pull[slides] == pytest.approx(MU * PRESS, rel=1e-3) and np.all(pull[~slides] < MU * PRESS)


@pytest.mark.parametrize("late", [kg.Plane((0, -1), (0, 1)), kg.Moving(kg.Plane((0, -1), (0, 1)), shift=(0, -1, 0))])
def test_what_slides_goes_on_where_another_rubbing_contact_is_added(late: Any) -> None:
    """The block is held back by mu N from the first step of the new stage on, as if it had never stopped."""
    m, a, b = block()
    c = m.add(kg.Node(2, 0))
    m.add(kg.Fix(c))
    pressed = kg.DisplacementControl(m).run()
    m.hold(pressed[-1])
    m.remove(m.constraints[0])
    m.add(kg.Fix(b, "y"), kg.Prescribe(b, x=0.1))
    slides = kg.DisplacementControl(m, targets=np.linspace(0.05, 1, 20), start=pressed[-1]).run()
    m.hold(slides[-1])
    m.remove(next(item for item in m.constraints if b in item.group and "x" in item.values))
    m.add(kg.Contact(c, late, stiffness=STIFFNESS, layer=LAYER, friction=MU), kg.Prescribe(b, x=0.101))
    on = kg.DisplacementControl(m, targets=[0.5], start=slides[-1]).run()
    assert on.force("bars")[:, 0] == pytest.approx(MU * PRESS, rel=1e-3)
    assert np.linalg.norm(on.deformation("friction")[:, 0], axis=1) == pytest.approx(1.0, abs=1e-3)


def test_a_history_belongs_to_its_own_nodes() -> None:
    m, a, b = block()
    old = kernel_of(m, "friction")
    m.add(kg.Contact(b, kg.Plane((0, 0), (0, 1)), stiffness=STIFFNESS, layer=LAYER, friction=MU))
    own, other = (kernel for kernel in kg.System(m).kernels if kernel.name == "friction")
    assert own.fits(old.history) and not other.fits(old.history)


def test_a_belt_round_a_cylinder() -> None:
    """Capstan: where the belt slides, the tensions at its ends differ by exp(mu angle)."""
    angle, count, tension = np.pi / 2, 24, 1.0
    at = np.linspace(0, angle, count + 1)
    m = kg.Model(dim=2)
    first, last = m.add(kg.Node(1, -0.4), kg.Node(-0.4, 1))  # the ends lead straight on
    belt = m.add(*(kg.Node(float(np.cos(t)), float(np.sin(t))) for t in at))
    for a, b in pairwise([first, *belt, last]):
        length = float(np.hypot(a.x - b.x, a.y - b.y))
        m.add(kg.Bar(a, b, 100.0, rest_length=length / (1 + tension / 100), strain="engineering"))
    m.add(kg.Contact(belt, kg.Cylinder((0, 0), (0, 0, 1), 1.0), stiffness=200.0, layer=5e-3, friction=MU))
    m.add(kg.NodalLoad(first, (0, -tension), constant=True), kg.Spring(first, (1e-3, 0)))
    m.add(kg.Fix(last, "y"), kg.Prescribe(last, x=-0.08))
    pulled = kg.DisplacementControl(m, targets=np.linspace(0.02, 1, 40), on_instability="follow").run()
    share = np.linalg.norm(pulled.deformation("friction")[-1], axis=1)
    pressing = pulled.force("contact")[-1] > 1e-2
    assert pressing.sum() > 20 and share[pressing].min() > 0.99
    ratio = -pulled.reaction(last, "x")[-1] / tension
    assert ratio == pytest.approx(np.exp(MU * angle), rel=0.01)


def test_friction_is_saved_and_refused(tmp_path: Any) -> None:
    m, a, b = block()
    res = kg.DisplacementControl(m).run()
    back = kg.load(res.save(tmp_path / "rub"))
    assert back.deformation("friction") == pytest.approx(res.deformation("friction"), abs=1e-15)
    with pytest.raises(kg.ModelError, match="friction"):
        kg.Contact(a, kg.Plane(), friction=-0.1)
    without, _, _ = block(0.0)
    assert all(kernel.name != "friction" for kernel in kg.System(without).kernels)
