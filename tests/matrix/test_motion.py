"""Motion on every rung and structure, and with every effect: other statements of a problem, energy, files."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from changes import CHANGES, Change
from structures import SAME, STRUCTURES, TOP, applies

import kirigami as kg

STEP, COUNT = 1e-3, 3
CLOSE = 2e-6  # of the largest value: what the tolerance of the steps leaves
NOT_KEPT = ("friction", "pressure")  # what takes energy out, or has no potential on a sheet with a free rim


def nodes_of(m: kg.Model, how: Change, *old: int) -> list[kg.Node]:
    """Nodes of the sheet of the matrix by their numbers in the drawing."""
    new = np.argsort(how.order(16))
    return [m.nodes[new[k]] for k in old]


def floor(m: kg.Model, how: Change, friction: float) -> kg.Contact:
    """A plane close under a free edge."""
    point, normal = how.places(np.array([0, 0, -2e-4])), how.turn @ [0, 0, 1]
    return kg.Contact(
        nodes_of(m, how, 4, 8), kg.Plane(point, normal), stiffness=500.0 * how.force / how.length,
        layer=1e-3 * how.length, friction=friction,
    )  # fmt: skip


def with_grip(m: kg.Model, how: Change) -> None:
    """The driven edge and the row before it as a rigid body that turns."""
    m.remove(*[item for item in m.constraints if isinstance(item, kg.Prescribe)])
    turn = np.linalg.det(how.turn) * how.turn @ [0.3, 0.1, 0.2]
    m.add(kg.Grip(nodes_of(m, how, *TOP, 9), move=how.places(np.array([0.02, 0.03, 0.1])), turn=turn))


def with_link(m: kg.Model, how: Change) -> None:
    m.add(kg.RigidLink(nodes_of(m, how, 4, 8, 5)))


def with_cable(m: kg.Model, how: Change) -> None:
    """From the free edge to the ground, slack or not."""
    ground = m.add(kg.Node(*how.places(np.array([-0.5, 0.3, 0.4])).tolist()))
    (end,) = nodes_of(m, how, 4)
    line = 0.3 * how.force / how.length**2
    m.add(kg.Fix(ground), kg.Bar(ground, end, EA=2e3 * how.force, law="cable", mass_per_length=line))


EFFECTS: dict[str, Callable[[kg.Model, Change], Any]] = {
    "contact": lambda m, how: m.add(floor(m, how, 0.0)),
    "friction": lambda m, how: m.add(floor(m, how, 0.4)),
    "spring": lambda m, how: m.add(kg.Spring(nodes_of(m, how, 4, 8), 800.0 * how.force / how.length)),
    "pressure": lambda m, how: m.add(kg.Pressure(400.0 * how.force / how.length**2)),
    "grip": with_grip,
    "link": with_link,
    "cable": with_cable,
    "actuated": lambda m, how: m.add(
        kg.Actuate(strain=(2e-3, 2e-3, 0), curvature=np.array([0.2, 0.2, 0]) / how.length, constant=True)
    ),
}
CASES = [*STRUCTURES, *(f"{rung}, {effect}" for rung in ("plate", "facet", "shell") for effect in EFFECTS)]


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
