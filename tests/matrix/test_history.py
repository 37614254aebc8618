"""Sheets that yield, touch themselves and rub, and do all of it: other statements of the problem, files, interruptions.

What they bear hangs on the way, so each row is driven there and back.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from changes import CHANGES
from structures import REMEMBERING, SAME, stacked

import kirigami as kg

NEEDS = pytest.mark.skipif(find_spec("ipctk") is None, reason="contact is searched for by ipctk")
ALONE = ("yielding shell", "yielding plate")
SHORT = ("yielding plate", "rubbing facet", "yielding and touching")  # in the default suite


def rows(*short: str) -> list[Any]:
    return [
        pytest.param(name, marks=[NEEDS] * (name not in ALONE) + [pytest.mark.long] * (name not in short))
        for name in REMEMBERING
    ]


TARGETS = [0.5, 1.0]
CLOSE = 2e-5  # of the largest value: what the tolerance leaves after a way that differs in its last digits
RUBS = 5e-4  # the same where friction lags by an increment, and one may be cut for a last digit


def walked(name: str, change: str = "", **options: Any) -> kg.Results:
    m = REMEMBERING[name](CHANGES.get(change, SAME), 1.0)
    return kg.DisplacementControl(m, targets=TARGETS, to=0.7, tol=1e-10).run(**options)


@cache
def results(name: str, change: str = "") -> kg.Results:
    return walked(name, change)


def assert_same(found: Any, wanted: Any, close: float = CLOSE) -> None:
    np.testing.assert_allclose(found, wanted, rtol=0, atol=close * max(np.abs(wanted).max(initial=0.0), 1e-300))


@pytest.mark.parametrize("name", rows(*SHORT))
def test_it_happens(name: str) -> None:
    """Rows that yield yield, rows that touch touch, and each is told."""
    res = results(name)
    kinds = {event.kind for event in res.events}
    assert res.lam[-1] == pytest.approx(0.7)
    if "yielding" in name:
        assert 0 < res.yielded.max() < 1 and res.plastic_strain()[-1].max() > 1e-3 and "yield" in kinds
        assert res.energy["dissipated"][-1] > 0
    if "touching" in name or "rubbing" in name:
        force = res.force("self-contact")
        assert np.abs(force).max() > 0 and "contact" in kinds and "crossing" not in kinds
        assert np.abs(force.sum(axis=1)).max() < 1e-9 * np.abs(force).max()
    if "rubbing" in name or name == "yielding and touching":
        assert np.linalg.norm(res.deformation("self-friction"), axis=2).max() > 0.1


@pytest.mark.parametrize("change", [pytest.param(one, marks=[] if one == "turned in space" else [pytest.mark.long])
                                    for one in CHANGES])  # fmt: skip
@pytest.mark.parametrize("name", rows(*SHORT[:2]))
def test_another_statement_of_the_problem_gives_the_same_answer(name: str, change: str) -> None:
    how, one, other = CHANGES[change], results(name), results(name, change)
    order = how.order(len(one.rest))
    close = RUBS if any(kernel.name == "self-friction" for kernel in one.kernels) else CLOSE
    for lam in (0.5, 1.0):
        a, b = (int(np.argmin(np.abs(res.lam - lam))) for res in (one, other))
        assert_same(other.u[b], how.places(one.u[a])[order], close)
        if "yielding" in name:
            assert_same(other.yielded[b], one.yielded[a])
        for kind, value in one.energy.items():
            largest = sum(abs(part[a]) for part in one.energy.values())
            assert abs(other.energy[kind][b] / (how.force * how.length) - value[a]) < 10 * close * largest
        for kernel in ("self-contact", "self-friction"):
            if any(known.name == kernel for known in one.kernels):
                assert_same(other.force(kernel)[b], how.forces(one.force(kernel)[a])[order], 40 * close)


@pytest.mark.parametrize("name", rows(*SHORT))
def test_saved_and_loaded_results_tell_the_same(name: str, tmp_path: Path) -> None:
    res = results(name)
    back = kg.load(res.save(tmp_path / "run"))
    assert np.array_equal(back.u, res.u) and back.summary() == res.summary()
    for kind, value in res.energy.items():
        assert_same(back.energy[kind], value, 1e-12)
    for kernel in res.kernels:
        if kernel.name in ("self-contact", "self-friction"):
            assert np.array_equal(back.force(kernel.name), res.force(kernel.name))
    if "yielding" in name:
        assert np.array_equal(back.plastic_strain(), res.plastic_strain())


@pytest.mark.parametrize("name", rows("yielding plate", "yielding and touching"))
def test_an_interrupted_run_goes_on_bit_for_bit(name: str, tmp_path: Path) -> None:
    whole = results(name)

    def stop(step: kg.Step) -> None:
        if step.lam > 0.8:
            raise KeyboardInterrupt

    file = tmp_path / "half.npz"
    with pytest.warns(kg.errors.KirigamiWarning, match="interrupted"):
        walked(name, recorders=[stop], checkpoint=file)
    resumed = walked(name, checkpoint=file)
    assert np.array_equal(resumed.lam, whole.lam) and np.array_equal(resumed.u, whole.u)
    told = ("interrupted",)
    assert [e.message for e in resumed.events if e.kind not in told] == [e.message for e in whole.events]


@NEEDS
@pytest.mark.parametrize(
    "analysis", [pytest.param(name, marks=pytest.mark.long) for name in ("LoadControl", "ArcLength", "Dynamics")]
)
def test_both_together_in_every_analysis(analysis: str, tmp_path: Path) -> None:
    """Interrupted and gone on with, too."""

    def run(**options: Any) -> kg.Results:
        m = REMEMBERING["yielding and touching"](SAME, 1.0)
        if analysis == "LoadControl":
            return kg.LoadControl(m, tol=1e-10).run(**options)
        if analysis == "ArcLength":
            return kg.ArcLength(m, step=0.2, max_steps=6, tol=1e-10).run(**options)
        return kg.Dynamics(m, end=0.08, step=0.01, load=[(0, 0), (0.08, 1)]).run(**options)

    whole = run()
    assert np.isfinite(whole.u).all() and len(whole) > 3
    seen = 0

    def stop(step: kg.Step) -> None:
        nonlocal seen
        seen += 1
        if seen == len(whole) // 2:
            raise KeyboardInterrupt

    file = tmp_path / "half.npz"
    with pytest.warns(kg.errors.KirigamiWarning, match="interrupted"):
        run(recorders=[stop], checkpoint=file)
    resumed = run(checkpoint=file)
    assert np.array_equal(resumed.lam, whole.lam) and np.array_equal(resumed.u, whole.u)


def pressed_by(friction: float) -> dict[str, float]:
    res = kg.DisplacementControl(stacked("facet", SAME, 1.0, friction=friction), to=0.35).run()
    pressed, rubbed = (np.abs(res.force(name)[-1]).sum() for name in ("self-contact", "self-friction"))
    return {"pressed": float(pressed), "rubbed": float(rubbed)}


@NEEDS
def test_a_sweep_goes_over_what_touches(tmp_path: Path) -> None:
    with ThreadPoolExecutor(2) as pool:
        table = kg.Sweep(pressed_by, [{"friction": mu} for mu in (0.2, 0.4)], tmp_path / "table.csv").run(pool)
    alone = pressed_by(0.4)
    assert table["pressed"][1] == alone["pressed"] and table["rubbed"][1] == alone["rubbed"]
    assert alone["rubbed"] > table["rubbed"][0] > 0
