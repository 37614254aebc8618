"""Yield in files, checkpoints and stages, and after the load is gone."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from yield_samples import lifted

import kirigami as kg


@pytest.mark.parametrize("rung", ["plate", "shell"])
def test_saved_and_loaded(rung, tmp_path):
    m, right = lifted(rung, hardening=[(0.05, 65e6)], kinematic=[(0.001, 1e6), (0.03, 5e6)])
    results = kg.DisplacementControl(m).run()
    assert results.yielded[-1] > 0
    twin = kg.load(results.save(tmp_path / "bent.npz"))
    assert np.array_equal(twin.yielded, results.yielded)
    assert np.array_equal(twin.plastic_strain(), results.plastic_strain())
    assert twin.material == results.material
    for name, values in results.energy.items():
        assert np.array_equal(twin.energy[name], values)
    assert np.array_equal(twin.reaction("driven_0"), results.reaction(right))


@pytest.mark.parametrize("rung", ["plate", "shell"])
def test_resumed_bit_for_bit(rung, tmp_path):
    m, _ = lifted(rung)
    whole = kg.DisplacementControl(m, targets=[0.5, 1.0], to=0.6).run()

    def stop(step):
        if step.lam > 0.7:
            raise KeyboardInterrupt

    analysis = kg.DisplacementControl(m, targets=[0.5, 1.0], to=0.6)
    with pytest.warns(kg.KirigamiWarning, match="interrupted"):
        analysis.run(checkpoint=tmp_path / "half.npz", recorders=[stop])
    resumed = analysis.run(checkpoint=tmp_path / "half.npz")
    assert np.array_equal(resumed.u, whole.u)
    assert np.array_equal(resumed.lam, whole.lam)
    assert np.array_equal(resumed.yielded, whole.yielded)
    assert [event.kind for event in resumed.events] == [event.kind for event in whole.events]


@pytest.mark.parametrize("rung", ["plate", "shell"])
def test_a_crease_made_by_folding_stays_when_let_go(rung):
    """Forces lifted off as a stage; what was elastic comes back, and the crease opens only in part."""
    m, right = lifted(rung)
    up = kg.DisplacementControl(m).run()
    m.hold(up[-1])
    held = next(item for item in m.constraints if "z" in item.values and item is not m.constraints[0])
    m.remove(held)
    force = up.reaction(right, "z")[-1]
    share = (0, 0, force / len(right))
    m.add(kg.NodalLoad(right, share, constant=True), kg.NodalLoad(right, (0, 0, -share[2])))
    down = kg.LoadControl(m, start=up[-1]).run()
    left = down.position(right)[-1, :, 2].mean()
    assert 0.1 * 0.06 < left < 0.9 * 0.06
    assert (down.plastic_strain(-1) >= up.plastic_strain(-1)).all()  # what has flown has flown
    assert (np.diff(down.energy["dissipated"]) >= -1e-12 * down.energy["dissipated"][-1]).all()


@pytest.mark.long
def test_a_ribbon_pulled_twice_and_a_pop_up_folded():
    """The example: what stays, and where the work goes; the trapezium rule and one snap leave 1 % of it open."""
    place = Path(__file__).parents[2] / "examples" / "creased_ribbon.py"
    specification = importlib.util.spec_from_file_location("creased_ribbon", place)
    example = importlib.util.module_from_spec(specification)
    sys.modules["creased_ribbon"] = example
    specification.loader.exec_module(example)
    pulled, folded = example.ribbon(), example.popup()
    for cycle in (pulled, folded):
        assert abs(cycle.work[-1] / cycle.energy[-1] - 1) < 0.02
        assert 0.3 < cycle.left / cycle.way.max() < 0.95
        lost = cycle.results.energy["dissipated"]
        assert (np.diff(lost) >= -1e-9 * lost[-1]).all()
    area = pulled.results.open_area(union=True)
    assert area[pulled.back] > 0.05 * area[pulled.turn]  # slits stay open
