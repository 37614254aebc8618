"""Paths that turn back in the very displacement that is driven: followed by arc length, jumped or refused otherwise."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import kirigami as kg

EA, HALF, RISE = 1.0, 1.0, 0.5


def pushed_through_a_spring(soft: float) -> tuple[kg.Model, kg.Node, kg.Node]:
    """A shallow truss pushed at its apex through a bar of spring constant `soft`; the grip sits on top of the bar."""
    m = kg.Model(dim=2)
    left, apex, right, grip = m.add(kg.Node(-HALF, 0), kg.Node(0, RISE), kg.Node(HALF, 0), kg.Node(0, RISE + 10.0))
    m.add(kg.Bar(left, apex, EA), kg.Bar(apex, right, EA), kg.Bar(apex, grip, 10.0 * soft, strain="engineering"))
    m.add(kg.Fix([left, right]), kg.Fix([apex, grip], "x"))
    return m, apex, grip


def load(deflection: NDArray[np.float64]) -> NDArray[np.float64]:
    """P = 2 EA z (h^2 - z^2) / (2 L0^3) with z = h - w: the von Mises truss with Green strain."""
    z = RISE - deflection
    return 2 * EA * z * (RISE**2 - z**2) / (2 * np.hypot(HALF, RISE) ** 3)


LIMIT = float(load(np.array(RISE * (1 - 1 / np.sqrt(3)))))


@pytest.mark.parametrize("soft", [0.02, 0.1])
def test_arc_length_follows_the_grip_back(soft: float) -> None:
    """The grip moves by w + P / soft: with a soft spring it turns back twice, and every step lies on the curve."""
    m, apex, grip = pushed_through_a_spring(soft)
    m.add(kg.NodalLoad(grip, (0, -LIMIT)))
    res = kg.ArcLength(m, step=0.05, stop=lambda step: -step.u[1, 1] > 2.2 * RISE).run()
    deflection, travel = -res.u[:, 1, 1], -res.u[:, 3, 1]
    assert res.lam * LIMIT == pytest.approx(load(deflection), abs=1e-7 * LIMIT)
    assert travel == pytest.approx(deflection + load(deflection) / soft, abs=1e-5)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(travel))))
    assert len(turns) == 2  # it goes back, and on again
    limits = [event.lam for event in res.events if event.kind == "limit point"]
    assert limits == pytest.approx([1.0, -1.0], abs=1e-5)
    assert deflection[-1] > 2.2 * RISE and res.residual.max() <= 1e-8


def test_driven_grip_jumps_and_says_so() -> None:
    """Driven by the grip the truss must jump where the grip would turn back; all steps lie on the curve."""
    soft = 0.02
    m, apex, grip = pushed_through_a_spring(soft)
    m.add(kg.Prescribe(grip, y=-4.0))
    res = kg.DisplacementControl(m).run()
    deflection, travel = -res.u[:, 1, 1], 4.0 * res.lam
    assert res.lam[-1] == 1.0 and res.stable.all() and any(event.kind == "snap" for event in res.events)
    assert travel == pytest.approx(deflection + load(deflection) / soft, abs=1e-6)
    # It jumps between the two turning points of the grip: stable from there to there is only the far branch.
    w = np.linspace(0, 2.5 * RISE, 100_001)
    turning = np.flatnonzero(np.diff(np.sign(np.diff(w + load(w) / soft))))
    assert not np.any((deflection > w[turning[0]] + 1e-3) & (deflection < w[turning[1]] - 1e-3))


def test_driven_grip_that_may_not_jump_ends_in_words() -> None:
    """With ``follow`` there is no neighbouring state past the turning point: an error with the steps so far."""
    soft = 0.02
    m, apex, grip = pushed_through_a_spring(soft)
    m.add(kg.Prescribe(grip, y=-4.0))
    try:
        res = kg.DisplacementControl(m, on_instability="follow").run()
    except kg.ConvergenceError as error:
        assert error.results is not None and error.hint and error.worst_nodes
        res = error.results
        turning = RISE - np.sqrt((RISE**2 - soft * np.hypot(HALF, RISE) ** 3 / EA) / 3)  # where 1 + P' / soft = 0
        assert 4.0 * res.lam[-1] == pytest.approx(turning + load(turning) / soft, rel=1e-5)
    else:
        assert any(event.kind == "snap" for event in res.events)
    deflection = -res.u[:, 1, 1]
    assert 4.0 * res.lam == pytest.approx(deflection + load(deflection) / soft, abs=1e-6)


def test_load_control_at_the_limit_itself() -> None:
    """Asked for exactly the limit load, it comes to it from below or says that there is nothing beyond."""
    m, apex, grip = pushed_through_a_spring(1.0)
    m.add(kg.NodalLoad(grip, (0, -LIMIT)))
    try:
        res = kg.LoadControl(m).run()
    except kg.ConvergenceError as error:
        assert error.results is not None
        res = error.results
    assert 0.999 < res.lam[-1] <= 1.0
    assert res.lam * LIMIT == pytest.approx(load(-res.u[:, 1, 1]), abs=1e-7 * LIMIT)


def test_both_ways_of_the_arc() -> None:
    """Started with a negative step the path goes up from rest: the truss is stretched, along the same closed form."""
    m, apex, grip = pushed_through_a_spring(0.5)
    m.add(kg.NodalLoad(grip, (0, -LIMIT)))
    res = kg.ArcLength(m, step=-0.1, stop=lambda step: step.lam < -20).run()
    assert res.stable.all() and np.all(np.diff(res.lam) < 0)
    assert res.lam * LIMIT == pytest.approx(load(-res.u[:, 1, 1]), rel=1e-6, abs=1e-9)
