"""Every quantity of results, on every rung and on hand-built structures, against invariances and balances.

The rows come from the public names of ``kg.Results``: a new name joins ``QUANTITIES`` or stands in ``NO_QUANTITY`` with
its reason. The columns come from ``kg.stiffness.RUNGS``: a new rung joins by itself.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from changes import CHANGES
from quantities import NO_QUANTITY, QUANTITIES, carried_over, told
from structures import SAME, STRUCTURES, applies, from_the_ground, linear, loaded, model, results

import kirigami as kg

CLOSE = 2e-6  # of the largest value: what the tolerance of the equilibria leaves
CELLS = [(structure, name) for structure in STRUCTURES for name in QUANTITIES]
SERVED = [(structure, name) for structure, name in CELLS if structure in QUANTITIES[name].served]


def assert_same(found: Any, wanted: Any, close: float = CLOSE) -> None:
    found, wanted = np.asarray(found, dtype=float), np.asarray(wanted, dtype=float)
    assert found.shape == wanted.shape and np.isfinite(found).all()
    np.testing.assert_allclose(found, wanted, rtol=0, atol=close * max(np.abs(wanted).max(initial=0.0), 1e-300))


def test_every_public_name_of_results_has_a_row() -> None:
    public = {name for name in dir(kg.Results) if not name.startswith("_")}
    named = {*QUANTITIES, *NO_QUANTITY}
    assert public == named & public and not set(QUANTITIES) & set(NO_QUANTITY), sorted(public ^ named)


@pytest.mark.parametrize("structure, name", [cell for cell in CELLS if cell not in SERVED])
def test_what_a_structure_does_not_have_is_refused(structure: str, name: str) -> None:
    """With an error of the package, not with an array of nothing."""
    with pytest.raises(kg.KirigamiError):
        QUANTITIES[name].tell(results(structure), SAME)


@pytest.mark.parametrize(
    "structure, name, change",
    [
        (structure, name, change)
        for structure, name in SERVED
        for change in CHANGES
        if applies(structure, change) and (CHANGES[change].flat or not QUANTITIES[name].flat)
    ],
)
def test_another_statement_of_the_problem_gives_the_same_answer(structure: str, name: str, change: str) -> None:
    quantity, how = QUANTITIES[name], CHANGES[change]
    before = quantity.tell(results(structure), SAME)
    after = told(quantity, results(structure, change), how)
    # a length of the problem itself, where a quantity is zero or cancels
    assert_same(after, carried_over(quantity, before, how), CLOSE)


@pytest.mark.parametrize("structure, name", [cell for cell in SERVED if QUANTITIES[cell[1]].order is not None])
def test_a_doubled_load_doubles_a_linear_answer(structure: str, name: str) -> None:
    quantity = QUANTITIES[name]
    once, twice = (told(quantity, linear(structure, drive=drive), SAME) for drive in (1.0, 2.0))
    assert_same(twice, 2**quantity.order * once, 1e-8)  # type: ignore[operator]


@pytest.mark.parametrize("structure, name", SERVED)
def test_saved_and_loaded_results_tell_the_same(structure: str, name: str) -> None:
    again, first = (told(QUANTITIES[name], run, SAME) for run in (loaded(structure), results(structure)))
    assert_same(again, first, 1e-12)


@pytest.fixture(scope="module")
def edited() -> dict[str, tuple[kg.Results, dict[str, Any]]]:
    """Results whose model was edited after the run in every way there is, and what they told before."""
    found = {}
    for structure in STRUCTURES:
        m = STRUCTURES[structure](SAME)
        run = kg.DisplacementControl(m, to=1.0, tol=1e-10).run()
        rows = [name for name, quantity in QUANTITIES.items() if structure in quantity.served]
        before = {name: np.copy(told(QUANTITIES[name], copy.copy(run), SAME)) for name in rows[::2]}
        m.hold(run[-1])
        m.remove(m.constraints[0])
        m.add(kg.Fix(m.nodes[0]), kg.Node(5, 5), kg.NodalLoad(m.nodes[1], (1, 1)))
        m.perturb(np.full((len(m.nodes), 2), 0.01))
        fresh = kg.DisplacementControl(STRUCTURES[structure](SAME), to=1.0, tol=1e-10).run()
        before |= {name: told(QUANTITIES[name], fresh, SAME) for name in rows[1::2]}  # nothing of run was cached there
        found[structure] = (run, before)
    return found


@pytest.mark.parametrize("structure, name", SERVED)
def test_results_do_not_change_with_the_model(structure: str, name: str, edited) -> None:
    run, before = edited[structure]
    assert_same(told(QUANTITIES[name], run, SAME), before[name], 1e-9)


# ---- balances


@pytest.mark.parametrize("change", ["", *CHANGES])
@pytest.mark.parametrize("structure", STRUCTURES)
def test_reactions_balance_the_loads(structure: str, change: str) -> None:
    """Forces and moments, at every step; the loads grow with the load factor."""
    if change and not applies(structure, change):
        return
    m, run = model(structure, change), results(structure, change)
    (load,) = m.loads
    loaded, held = m.index(load.nodes), m.index(node for item in m.constraints for node in item.group)
    count = len(m.nodes)
    largest = 1e-6 * float(np.abs(run.reaction(held)).max())  # below, a step at rest holds nothing but rounding
    for number, step in enumerate(run.steps):
        x = run.position()[number, :count]
        force = np.zeros((count, 3))
        force[loaded] += step.lam * np.array(load.force)
        for node in held.tolist():
            force[node] += run.reaction(node)[number]
        force += from_the_ground(run, number)
        size = np.abs(force).sum() + largest
        assert np.abs(force.sum(axis=0)).max() <= 1e-7 * size
        if structure not in CLAMPED:  # a clamp holds moments of its own
            moment = np.cross(x, force).sum(axis=0)
            assert np.abs(moment).max() <= 1e-6 * size * np.abs(x).max()


CLAMPED = {name for name in STRUCTURES if any(item.clamp for item in model(name).constraints)}


@pytest.mark.parametrize("structure", STRUCTURES)
def test_what_the_drive_works_is_stored(structure: str) -> None:
    """d(energy) / d(load factor) = reactions times drive + loads times velocities, by central differences."""
    m, run = model(structure), results(structure)
    at = int(np.argmin(np.abs(run.lam - 1.0)))
    before, after = (int(np.argmin(np.abs(run.lam - lam))) for lam in (0.999, 1.001))
    span = run.lam[after] - run.lam[before]
    assert span == pytest.approx(0.002)
    energy = sum(run.energy.values())
    rate = (energy[after] - energy[before]) / span
    (driven,) = [item for item in m.constraints if not item.constant]
    work = 0.0
    for axis, values in driven.values.items():
        for node, value in zip(driven.group, values):
            work += run.reaction(node, axis)[at] * value
    (load,) = m.loads
    velocity = (run.u[after] - run.u[before]) / span
    work += float((velocity[m.index(load.group)] @ np.array(load.force)).sum())
    for kernel in run.kernels:
        if kernel.scaled and kernel.stores_energy:  # rest values that are driven
            work += float(kernel.by_load(run.configuration(run[at]), run.lam[at], 0).energy.sum())
    assert rate == pytest.approx(work, rel=1e-5)
