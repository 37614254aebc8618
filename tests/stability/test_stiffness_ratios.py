"""Stiff next to soft, eight orders of magnitude each way: the soft member still gives the answer."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import kirigami as kg

RATIOS = [1e-8, 1e-4, 1.0, 1e4, 1e8]


@pytest.mark.parametrize("ratio", RATIOS)
def test_two_bars_in_series(ratio: float) -> None:
    """Engineering strain, unit lengths: u = F (1 / EA_1 + 1 / EA_2), and the free end alone moves by F / EA_2 more."""
    m = kg.Model(dim=2)
    a, b, c = nodes = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    m.add(kg.Bar(a, b, 1.0, strain="engineering"), kg.Bar(b, c, ratio, strain="engineering"))
    force = 1e-2 * min(1.0, ratio)
    m.add(kg.Fix(a), kg.Fix(nodes[1:], "y"), kg.NodalLoad(c, (force, 0)))
    for analysis in (kg.LinearStatic(m), kg.LoadControl(m)):
        u = analysis.run().u[-1, :, 0]
        assert u[1] == pytest.approx(force, rel=1e-6, abs=1e-8 * u[2])
        assert u[2] == pytest.approx(force * (1 + 1 / ratio), rel=1e-7)


@pytest.mark.parametrize("ratio", RATIOS)
def test_two_bars_side_by_side(ratio: float) -> None:
    """The stiff bar carries its share: reactions EA_1 : EA_2."""
    m = kg.Model(dim=2)
    a, b, c, d = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1), kg.Node(1, 1))
    m.add(kg.Bar(a, b, 1.0), kg.Bar(c, d, ratio), kg.Tie(d, b, "x"), kg.Fix([a, c]), kg.Fix([b, d], "y"))
    m.add(kg.NodalLoad(b, (1e-3 * (1 + ratio), 0)))
    res = kg.LoadControl(m).run()
    assert res.reaction(c, "x")[-1] == pytest.approx(ratio * res.reaction(a, "x")[-1], rel=1e-9)
    strain = res.u[-1, 1, 0] * (1 + 0.5 * res.u[-1, 1, 0])  # Green; force (1 + u) strain EA
    assert (1 + res.u[-1, 1, 0]) * strain == pytest.approx(1e-3, rel=1e-7)


@pytest.mark.parametrize("axial", [1e2, 1e5, 1e8])
def test_cantilever_of_springs_and_stiff_bars(axial: float) -> None:
    """Bars up to 1e8 times as stiff as the springs: the tip of the rigid-link chain, within what the bars give way.

    Three links with unit springs under a dead tip load P: the moment of joint n is P times the lever arm to the tip.
    """
    m = kg.Model(dim=2)
    nodes = m.add(*(kg.Node(float(x), 0.0) for x in range(-1, 4)))
    m.add(*(kg.Bar(a, b, axial, strain="engineering") for a, b in itertools.pairwise(nodes)))
    m.add(*(kg.TorsionSpring3(a, b, c, 1.0) for a, b, c in zip(nodes, nodes[1:], nodes[2:])))
    load = 0.4
    m.add(kg.Fix(nodes[:2]), kg.NodalLoad(nodes[-1], (0, load)))
    chain = kg.LoadControl(m, tol=1e-10).run().position(nodes[1:])[-1]
    direction = np.unwrap(np.arctan2(*np.diff(chain, axis=0)[:, 1::-1].T))
    bend = np.diff(direction, prepend=0.0)
    lever = chain[-1, 0] - chain[:-1, 0]
    assert bend == pytest.approx(load * lever, rel=2e-7)  # moment balance at every joint
    length = np.linalg.norm(np.diff(chain, axis=0), axis=1)
    assert length == pytest.approx(1 + load * np.sin(direction) / axial, rel=1e-6)


@pytest.mark.parametrize("ratio", [1e-8, 1e-4, 1e4, 1e8])
def test_half_of_a_sheet_stiffer(ratio: float) -> None:
    """Two strips in series, one with bars and hinges `ratio` times as stiff: only the softer one stretches."""
    mesh = rectangle(4, 8)
    m = kg.Model.from_mesh(mesh, 0.01, kg.Material(1.0))
    for bar in [item for item in m.elements if isinstance(item, kg.Bar)]:
        if min(node.y for node in bar.nodes) > 1.0 - 1e-9 and max(node.y for node in bar.nodes) > 1.0 + 1e-9:
            m.remove(bar)
            m.add(kg.Bar(*bar.nodes, ratio * bar.EA))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, "yz"), kg.Fix(bottom[0], "x"), kg.Fix(top, "z"), kg.Prescribe(top, y=1e-3))
    res = kg.DisplacementControl(m).run()
    middle = m.select(where=lambda x, y, z: abs(y - 1.0) < 1e-9)
    moved = res.u[-1, m.index(middle), 1].mean() / 1e-3  # of the middle, as a share of the grip's
    assert moved == pytest.approx(ratio / (1 + ratio), abs=0.02 * min(1, ratio) + 1e-7)
    assert res.reaction(top, "y")[-1] == pytest.approx(-res.reaction(bottom, "y")[-1], rel=1e-6)


def rectangle(columns: int, rows: int) -> kg.TriMesh:
    """A strip 1 wide and 2 high of right triangles, whose network has no Poisson effect along its legs."""
    x, y = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 2, rows + 1))
    index = np.arange(x.size).reshape(x.shape)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    facets = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return kg.TriMesh(np.column_stack([x.ravel(), y.ravel()]), facets)
