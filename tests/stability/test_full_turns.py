"""Hinges and springs through flat, through folded shut, and round whole turns and back: the moment stays linear."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest

import kirigami as kg

Place = Callable[[float], tuple[float, float, float]]

STIFFNESS, HEIGHT = 0.3, 0.8
# Two turns one way, two turns the other way, and back, in stages of a quarter turn [rad].
THERE_AND_BACK = np.concatenate([np.arange(0.5, 9), np.arange(7.5, -9, -1), np.arange(-7.5, 0)]) * np.pi / 2


def hinge(rest_angle: float = 0.0) -> tuple[kg.Model, kg.Node]:
    """A flat hinge on the x axis whose wing l, at y = -HEIGHT, is still free."""
    m = kg.Model()
    i, j, k, l = m.add(kg.Node(0.4, 1.1), kg.Node(0, 0), kg.Node(1, 0), kg.Node(0.5, -HEIGHT))
    m.add(kg.BendHinge(i, j, k, l, STIFFNESS, rest_angle=rest_angle), kg.Fix([i, j, k]))
    return m, l


def drive(m: kg.Model, node: kg.Node, angles: np.ndarray, place: Place) -> list[kg.Step]:
    """Carry a node through places on a circle, straight from one to the next, as stages of prescribed displacements."""
    steps: list[kg.Step] = []
    start = None
    for angle in angles:
        if start is not None:
            m.hold(start)
            m.remove(*(item for item in m.constraints if item.group == (node,)))
        target = np.array(place(angle)) - (node.x, node.y, node.z)
        driven = dict(zip("xyz"[: m.dim], target.tolist()))
        m.add(kg.Prescribe(node, **driven))
        start = kg.DisplacementControl(m, start=start, step=1.0).run()[-1]
        steps.append(start)
    return steps


@pytest.mark.parametrize("rest_angle", [0.0, -7.0])
def test_hinge_goes_two_turns_and_back(rest_angle: float) -> None:
    """The reaction of the driven wing times its height is k (theta - theta_0), to 4 pi, to -4 pi and back."""
    angles = THERE_AND_BACK
    m, wing = hinge(rest_angle)
    steps = drive(m, wing, angles, lambda a: (0.5, -HEIGHT * np.cos(a), HEIGHT * np.sin(a)))
    system = kg.System(m)
    for angle, step in zip(angles, steps):
        system.history = step.history
        growing = np.array([0.0, np.sin(angle), np.cos(angle)])
        moment = system.gradient(step.u)[m.index(wing)[0]] @ growing * HEIGHT
        assert moment == pytest.approx(STIFFNESS * (angle - rest_angle), abs=1e-9)


def test_spring_goes_two_turns_and_back() -> None:
    """The same in the plane: the angle of a spring counts on past 2 pi, and its moment with it."""
    angles = THERE_AND_BACK
    m = kg.Model(dim=2)
    arm, centre, tip = m.add(kg.Node(1, 0), kg.Node(0, 0), kg.Node(0, -1))
    m.add(kg.TorsionSpring3(tip, centre, arm, STIFFNESS), kg.Fix([arm, centre]))
    steps = drive(m, tip, angles, lambda a: (np.sin(a), -np.cos(a), 0.0))
    system = kg.System(m)
    for angle, step in zip(angles, steps):
        system.history = step.history
        around = system.gradient(step.u)[m.index(tip)[0]] @ (np.cos(angle), np.sin(angle), 0.0)
        assert around == pytest.approx(STIFFNESS * angle, abs=1e-9)


def test_a_stage_may_lead_back_to_rest() -> None:
    """Folded by half a turn and, as the next stage, unfolded to exactly where it began: flat, and free of force."""
    m, wing = hinge()
    m.add(kg.Prescribe(wing, x=0.0, y=2 * HEIGHT, z=1e-3))
    folded = kg.DisplacementControl(m).run()
    assert abs(folded.hinge_moment[-1, 0]) == pytest.approx(STIFFNESS * np.pi, rel=1e-2)
    m.hold(folded[-1])
    m.remove(m.constraints[-1])
    m.add(kg.Prescribe(wing, x=0.0, y=0.0, z=0.0))
    back = kg.DisplacementControl(m, start=folded[-1]).run()
    assert back.lam[-1] == 1.0 and np.abs(back.u[-1]).max() < 1e-14
    assert abs(back.hinge_moment[-1, 0]) < 1e-12


@pytest.mark.parametrize("fold", [0.0, 1e-12, np.pi / 2, np.pi - 1e-9, np.pi, -np.pi + 1e-9])
def test_forces_of_any_fold_are_finite_and_balanced(fold: float) -> None:
    """Flat, barely folded, square, and shut: 1 / height on each wing, no resultant, a symmetric finite tangent."""
    m = kg.Model()
    wing = np.array([0.5, -HEIGHT * np.cos(fold), HEIGHT * np.sin(fold)])
    i, j, k, l = m.add(kg.Node(0.4, 1.1), kg.Node(0, 0), kg.Node(1, 0), kg.Node(*wing))
    m.add(kg.BendHinge(i, j, k, l, STIFFNESS, rest_angle=fold - 0.1))
    system = kg.System(m)
    force = system.gradient(np.zeros((4, 3)))
    assert np.linalg.norm(force[[0, 3]], axis=1) == pytest.approx(0.1 * STIFFNESS / np.array([1.1, HEIGHT]), rel=1e-6)
    assert np.abs(force.sum(axis=0)).max() < 1e-15
    tangent = system.stiffness(constrained=False).toarray()
    assert np.isfinite(tangent).all() and np.abs(tangent - tangent.T).max() < 1e-13 * np.abs(tangent).max()


@pytest.mark.parametrize("turns", [1, 2])
def test_chain_with_bent_rest_angles_rolls_up(turns: int) -> None:
    """A straight cantilever chain whose springs rest at an angle rolls up without stress, over itself if it is long."""
    links = 12 * turns
    share = 2 * np.pi / 12
    m = kg.Model(dim=2)
    nodes = m.add(*(kg.Node(float(x), 0.0) for x in range(-1, links)))
    m.add(*(kg.Bar(a, b, 1e3) for a, b in itertools.pairwise(nodes)))
    m.add(*(kg.TorsionSpring3(a, b, c, 1.0, rest_angle=np.pi - share) for a, b, c in zip(nodes, nodes[1:], nodes[2:])))
    m.add(kg.Fix(nodes[:2]), kg.NodalLoad(nodes[-1], (0, 1e-9)))
    res = kg.LoadControl(m, step=1.0).run()
    turn = np.unwrap(np.arctan2(*np.diff(res.position(nodes[1:])[-1], axis=0)[:, 1::-1].T))
    assert np.abs(np.diff(turn)) == pytest.approx(share, abs=1e-6)
    assert abs(turn[-1] - turn[0]) == pytest.approx(turns * 2 * np.pi - 2 * share, abs=1e-5)
    assert sum(part[-1] for part in res.energy.values()) < 1e-9
    assert res.stable.all()
