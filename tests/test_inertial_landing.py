"""Where a snap lands with inertia: settle="dynamics" against the overdamped limit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kirigami as kg


def two_trusses(**masses: float) -> kg.Model:
    """A heavy von Mises truss that hangs a light one on a soft bar: pushed over its limit, it may pull that along."""
    m = kg.Model(dim=2)
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 0.3), kg.Node(1, 0))
    low_left, low, low_right = m.add(kg.Node(-1, -2), kg.Node(0, -1.75), kg.Node(1, -2))
    m.add(*(kg.Bar(a, b, 10.0) for a, b in ((left, apex), (apex, right), (low_left, low), (low, low_right))))
    m.add(kg.Bar(apex, low, 0.31), kg.Fix([left, right, low_left, low_right]), kg.Fix([apex, low], "x"))
    m.add(kg.NodalLoad(apex, (0, -1)))
    if masses:
        m.add(kg.Mass(apex, masses["heavy"]), kg.Mass(low, masses["light"]))
    return m


def landing(m: kg.Model, **how: Any) -> tuple[np.ndarray, kg.Results]:
    """Heights of the two apexes after the first snap."""
    run = kg.LoadControl(m, to=0.115, on_instability="switch", **how).run()
    snap = next(event for event in run.events if event.kind == "snap")
    return run.u[snap.step + 1, [1, 4], 1], run


def test_little_damping_carries_a_snap_on_and_much_damping_does_not() -> None:
    """The light truss snaps too where the heavy one overshoots; nearly critical damping is the overdamped limit."""
    heavy = {"heavy": 1.0, "light": 0.05}
    stays, run = landing(two_trusses(**heavy))
    assert stays[0] < -0.6 and stays[1] > -0.1
    carried, moved = landing(two_trusses(**heavy), settle="dynamics", damping=0.05)
    assert carried[0] < -0.6 and carried[1] < -0.5
    assert landing(two_trusses(**heavy), settle="dynamics", damping=0.8)[0] == pytest.approx(stays, abs=1e-6)
    # the energy that was set free is what the potential lost between the two equilibria, and more of it here
    free = [next(event.energy for event in one.events if event.kind == "snap") for one in (run, moved)]
    assert free[1] > free[0] > 0
    for step in moved.steps:
        assert step.residual <= 1e-8 and step.stable


def test_the_unit_of_mass_is_of_no_account() -> None:
    """Only ratios of masses choose, so that sheets of unknown density land alike; without any, all weigh the same."""
    one, _ = landing(two_trusses(heavy=1.0, light=0.05), settle="dynamics")
    other, _ = landing(two_trusses(heavy=1e6, light=5e4), settle="dynamics")
    assert other == pytest.approx(one, abs=1e-7)
    none, _ = landing(two_trusses(), settle="dynamics")
    alike, _ = landing(two_trusses(heavy=3.0, light=3.0), settle="dynamics")
    assert none == pytest.approx(alike, abs=1e-7)


def test_where_nothing_snaps_there_is_nothing_to_choose() -> None:
    runs = [
        kg.LoadControl(two_trusses(heavy=1.0, light=0.05), to=0.05, on_instability="switch", settle=settle).run()
        for settle in ("overdamped", "dynamics")
    ]
    assert np.array_equal(runs[0].u, runs[1].u)


def test_what_cannot_be_settled_by_motion_is_refused() -> None:
    m = two_trusses(heavy=1.0, light=0.05)
    for wrong in ({"on_instability": "follow"}, {"corrector": "slow"}):
        with pytest.raises(kg.ModelError, match="on_instability='switch'"):
            kg.LoadControl(m, settle="dynamics", **{"on_instability": "switch", **wrong})
    for wrong in ({"settle": "fast"}, {"damping": 0.0}, {"damping": 1.0}):
        with pytest.raises(kg.ModelError):
            kg.LoadControl(m, on_instability="switch", **wrong)
