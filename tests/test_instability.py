"""What happens at unstable equilibria: follow, switch, stop; closed forms of buckling."""

from __future__ import annotations

import numpy as np
import pytest

import kirigami as kg


def column() -> tuple[kg.Model, kg.Node, kg.Node]:
    """Two rigid links of length 1 with a spring k = 1 between them, pinned ends: buckles at P = 2 k / l = 2."""
    m = kg.Model(dim=2)
    bottom, middle, top = m.add(kg.Node(0, 0), kg.Node(0, 1), kg.Node(0, 2))
    m.add(kg.Bar(bottom, middle, 1e4), kg.Bar(middle, top, 1e4), kg.TorsionSpring3(bottom, middle, top, 1.0))
    m.add(kg.Fix(bottom), kg.Fix(top, "x"))
    return m, middle, top


def test_perfect_column_leaves_the_straight_path_when_it_buckles():
    """Squeezed by its grip it takes P = 2 phi / sin(phi) at the shortening 2 (1 - cos(phi)): the bent branch."""
    m, middle, top = column()
    m.add(kg.Prescribe(top, y=-0.2))
    res = kg.DisplacementControl(m).run()
    assert res.stable.all() and [event.kind for event in res.events] == ["bifurcation", "switch"]
    angle = np.arccos(0.9)
    assert -res.reaction(top, "y")[-1] == pytest.approx(2 * angle / np.sin(angle), rel=1e-3)
    assert abs(res.u[-1, 1, 0]) == pytest.approx(np.sin(angle), rel=1e-3)
    assert res.stats["relaxations"] >= 1


def test_perfect_column_can_be_followed_straight():
    m, middle, top = column()
    m.add(kg.Prescribe(top, y=-0.2))
    res = kg.DisplacementControl(m, on_instability="follow").run()
    np.testing.assert_allclose(res.u[:, 1, 0], 0, atol=1e-12)
    change = next(event for event in res.events if event.kind == "bifurcation")
    force = -res.reaction(top, "y")
    assert force[change.step] < 2.0 < force[change.step + 1]
    assert not res.stable[-1]


def test_stop_ends_at_the_first_unstable_step():
    m, middle, top = column()
    m.add(kg.NodalLoad(top, (0, -4.0)))
    res = kg.LoadControl(m, on_instability="stop").run()
    assert res.stable[:-1].all() and not res.stable[-1]
    assert res.lam[-2] * 4 < 2.0 < res.lam[-1] * 4


def test_imperfection_chooses_the_side():
    sides = []
    for offset in (1e-3, -1e-3):
        m, middle, top = column()
        m.add(kg.Prescribe(top, y=-0.2))
        m.perturb([[0, 0], [offset, 0], [0, 0]])
        sides.append(kg.DisplacementControl(m).run().u[-1, 1, 0])
    assert sides[0] > 0 > sides[1]
    assert sides[0] == pytest.approx(-sides[1], rel=1e-8)


def test_snap_sets_energy_free():
    """A shallow truss pushed through a soft spring: the grip's path turns back, so the truss must jump."""
    m = kg.Model(dim=2)
    left, apex, right, grip = m.add(kg.Node(-1, 0), kg.Node(0, 0.5), kg.Node(1, 0), kg.Node(0, 1.5))
    m.add(kg.Bar(left, apex, 1.0), kg.Bar(apex, right, 1.0), kg.Bar(apex, grip, 0.01))
    m.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.Fix(grip, "x"), kg.Prescribe(grip, y=-5.0))
    m.add(kg.Bar(left, grip, 1e-9), kg.Bar(right, grip, 1e-9))
    res = kg.DisplacementControl(m).run()
    assert res.lam[-1] == 1.0 and res.stable.all()
    assert any(event.kind == "snap" for event in res.events)
    assert res.position(apex)[-1, 1] < -0.4


def test_unknown_choice():
    m, *_ = column()
    with pytest.raises(kg.ModelError, match="on_instability"):
        kg.LoadControl(m, on_instability="hope")


def test_step_limit_is_told():
    m, middle, top = column()
    m.add(kg.NodalLoad(top, (0, -1.0)))
    res = kg.ArcLength(m, step=1e-3, stop=lambda step: step.lam > 1, max_steps=5).run()
    assert len(res) == 6 and res.events[-1].kind == "step limit"
