"""Motion on every rung and structure, and with every effect: other statements of a problem, energy, files."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from changes import CHANGES, Change
from effects_on_sheets import EFFECTS
from structures import SAME, STRUCTURES, applies

import kirigami as kg

STEP, COUNT = 1e-3, 3
CLOSE = 2e-6  # of the largest value: what the tolerance of the steps leaves
NOT_KEPT = ("friction", "pressure")  # what takes energy out, or has no potential on a sheet with a free rim


MOVING = ("contact", "friction", "spring", "pressure", "grip", "link", "cable", "actuated")
CASES = [*STRUCTURES, *(f"{rung}, {effect}" for rung in ("plate", "facet", "shell") for effect in MOVING)]


def model_of(case: str, how: Change) -> kg.Model:
    structure, _, effect = case.partition(", ")
    m = STRUCTURES[structure](how, 1.0)
    if effect:
        EFFECTS[effect](m, how)
    return m


@cache
def motion(case: str, change: str = "") -> kg.Results:
    """The supports begin to move, and the loads act at once."""
    m = model_of(case, CHANGES.get(change, SAME))
    return kg.Dynamics(
        m, end=COUNT * STEP, step=STEP, load=lambda t: (t / (5 * STEP)) ** 2,
        histories=dict.fromkeys(m.loads, 1.0), tol=1e-11,
    ).run()  # fmt: skip


def assert_same(found: Any, wanted: Any, close: float = CLOSE) -> None:
    np.testing.assert_allclose(found, wanted, rtol=0, atol=close * max(np.abs(wanted).max(initial=0.0), 1e-300))


def cells() -> list[Any]:
    """Every change of every case; of those with an effect the less telling ones are left to the long suite."""
    found = []
    for case in CASES:
        for change in CHANGES:
            late = "," in case and change not in ("turned in space", "renumbered", "millimetres")
            if "," in case or applies(case, change):
                found.append(pytest.param(case, change, marks=[pytest.mark.long] if late else []))
    return found


@pytest.mark.long
@pytest.mark.parametrize("case, change", cells())
def test_another_statement_of_the_problem_moves_alike(case: str, change: str) -> None:
    how, one, other = CHANGES[change], motion(case), motion(case, change)
    order = how.order(len(one.rest))
    if case.endswith("cable"):  # whose ground is not renumbered
        order = np.append(how.order(16), 16)
    assert np.abs(one.u).max() > 0 and len(one) == len(other) == COUNT + 1
    for name in ("u", "velocity"):
        assert_same(getattr(other, name), (how.length * getattr(one, name) @ how.turn.T)[:, order])
    for name in ("driven_0", "fixed_0"):
        assert_same(other.reaction(name), how.force * one.reaction(name) @ how.turn.T, 10 * CLOSE)
    assert_same(other.energy["kinetic"], how.force * how.length * one.energy["kinetic"])


@pytest.mark.parametrize("case", [case for case in CASES if not case.endswith(NOT_KEPT)])
def test_energy_is_kept(case: str) -> None:
    """Under loads that act at once, the supports at rest."""
    m = model_of(case, SAME)
    run = kg.Dynamics(
        m, end=8 * STEP, step=STEP, load=0.0, histories=dict.fromkeys(m.loads, 1.0), tol=1e-10
    ).run()
    assert run.energy["kinetic"].max() > 0 and run.stats["energy_drift"] < 1e-3


@pytest.mark.parametrize("case", CASES)
def test_motions_are_read_back(case: str, tmp_path) -> None:
    run = motion(case)
    back = kg.load(run.save(tmp_path / "motion"))
    for name in ("time", "u", "velocity"):
        assert np.array_equal(getattr(back, name), getattr(run, name))
    for name in ("driven_0", "fixed_0"):
        assert_same(back.reaction(name), run.reaction(name), 1e-12)
    for kind, values in run.energy.items():
        assert_same(back.energy[kind], values, 1e-9)
