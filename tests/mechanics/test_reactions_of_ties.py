"""A support holds what is tied to the node it holds: balance of forces, work and energy, files, chains, stages."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import shapely

import kirigami as kg


def gripped(rung: str, how: str, spread: float = 0.0) -> tuple[kg.Model, list[kg.Node], list[kg.Node]]:
    """A strip whose right end is a rigid grip, driven by its first node: all follow it, or each the one before."""
    mesh = kg.Sheet(shapely.box(0, 0, 1, 0.2)).mesh(0.07)
    m = kg.Model.from_mesh(mesh, 0.01, kg.Material(E=1e9, nu=0.3), stiffness=rung)
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left), kg.Fix(right, "yz"), kg.Prescribe(right[0], x=0.01))
    if how == "star":
        m.add(kg.Tie(right[1:], right[0], "x", x=spread))
    else:
        m.add(*(kg.Tie(follower, leader, "x", x=spread) for leader, follower in pairwise(right)))
    return m, left, right


@pytest.mark.parametrize("rung", ["plate", "facet", "shell"])
@pytest.mark.parametrize("how", ["star", "chain"])
def test_the_driving_support_carries_the_grip(rung: str, how: str, tmp_path: Path) -> None:
    m, left, right = gripped(rung, how)
    res = kg.DisplacementControl(m).run()
    force = res.reaction(right[0], "x")
    assert force == pytest.approx(-res.reaction(left, "x"), rel=1e-7, abs=1e-6)
    assert res.reaction(right, "x") == pytest.approx(force, rel=1e-12)  # nothing is counted twice
    assert res.reaction([right[0], right[0]], "x") == pytest.approx(force, rel=1e-12)
    assert abs(res.reaction(right[-1], "x")[-1]) < 0.5 * force[-1]  # a follower alone: the force of its tie
    header, *rows = res.to_csv(tmp_path / "curves.csv").read_text().splitlines()
    column = header.split(",").index("reaction_driven_0_x")
    assert [float(row.split(",")[column]) for row in rows] == force.tolist()
    loaded = kg.load(res.save(tmp_path / "grip.npz"))
    assert np.array_equal(loaded.reaction("driven_0", "x"), force)


@pytest.mark.parametrize("how", ["star", "chain"])
def test_work_of_the_driving_force_is_the_stored_energy(how: str) -> None:
    m, _, right = gripped("facet", how)
    res = kg.LinearStatic(m).run()
    assert 0.5 * res.reaction(right[0], "x")[-1] * 0.01 == pytest.approx(sum(res.energy.values())[-1], rel=1e-9)
    path = kg.DisplacementControl(m, targets=np.linspace(0.01, 1.0, 100)).run()
    work = np.trapezoid(path.reaction(right[0], "x"), 0.01 * path.lam)
    assert work == pytest.approx(sum(path.energy.values())[-1], rel=1e-4)


def test_ties_with_differences_balance() -> None:
    """The grip opens like a fan; the support still holds all of it."""
    m, left, right = gripped("facet", "chain", spread=1e-3)
    res = kg.DisplacementControl(m).run()
    moved = res.u[-1][m.index(right), 0]
    assert moved == pytest.approx(0.01 + 1e-3 * np.arange(len(right)), abs=1e-12)
    assert res.reaction(right[0], "x")[-1] == pytest.approx(-res.reaction(left, "x")[-1], rel=1e-7)


def test_a_free_leader_carries_the_load_on_its_followers() -> None:
    """A load on a follower pulls at the leader; the leader is held by nothing, so its support gives nothing."""
    m = kg.Model(dim=2)
    a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(1, 1))
    m.add(kg.Bar(a, b, 2.0), kg.Bar(b, c, 2.0), kg.Fix(a), kg.Fix(b, "y"), kg.Fix(c, "y"), kg.Tie(c, b, "x"))
    m.add(kg.NodalLoad(c, (0.1, 0)))
    res = kg.LinearStatic(m).run()
    assert res.u[-1, 1, 0] == pytest.approx(0.05)
    assert abs(res.reaction(b, "x")[-1]) < 1e-12
    assert res.reaction(a, "x")[-1] == pytest.approx(-0.1)


def test_across_stages() -> None:
    m, left, right = gripped("facet", "star")
    first = kg.DisplacementControl(m).run()
    m.hold(first[-1])
    m.remove(*[item for item in m.constraints if isinstance(item, kg.Prescribe)])
    m.add(kg.Prescribe(right[0], x=0.02))
    second = kg.DisplacementControl(m, start=first[-1]).run()
    assert second.reaction(right[0], "x")[0] == pytest.approx(first.reaction(right[0], "x")[-1], rel=1e-6)
    assert second.reaction(right[0], "x") == pytest.approx(-second.reaction(left, "x"), rel=1e-7)
    assert second.reaction(right[0], "x")[-1] > 1.5 * second.reaction(right[0], "x")[0]
