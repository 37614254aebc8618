"""Structures that are stressed at rest: strings, nets and membranes by closed forms, and sheets that want to curl."""

from __future__ import annotations

import itertools

import meshes
import numpy as np
import pytest

import kirigami as kg

TENSION = 0.03  # Green strain of every bar at rest


def stressed(length: float, strain: float = TENSION) -> float:
    """Rest length of a bar of this length that has the Green strain (l^2 - L^2) / (2 L^2)."""
    return length / np.sqrt(1 + 2 * strain)


FORCE = TENSION * np.sqrt(1 + 2 * TENSION)  # EA e l / L at EA = 1


def string(links: int) -> tuple[kg.Model, tuple[kg.Node, ...]]:
    m = kg.Model(dim=2)
    nodes = m.add(*(kg.Node(float(x), 0.0) for x in range(links + 1)))
    m.add(*(kg.Bar(a, b, 1.0, rest_length=stressed(1.0)) for a, b in itertools.pairwise(nodes)))
    m.add(kg.Fix([nodes[0], nodes[-1]]))
    return m, nodes


def test_string_sounds_its_notes() -> None:
    """Masses 1 on a string under tension T: omega_n^2 = 4 T / (m l) sin^2(n pi / 2 N), all below the stretches."""
    links = 8
    m, _ = string(links)
    values = kg.Eigen(m, n=links - 1).run().values
    exact = 4 * FORCE * np.sin(np.arange(1, links) * np.pi / (2 * links)) ** 2
    assert values == pytest.approx(exact, rel=1e-9)


def test_string_under_dead_load() -> None:
    """Linear deflection of the prestressed state: T (2 w_i - w_i-1 - w_i+1) / l = P, so w = P i (N - i) / (2 T)."""
    links = 10
    m, nodes = string(links)
    m.add(kg.NodalLoad(nodes[1:-1], (0, 1e-6)))
    at = np.arange(links + 1)
    assert kg.LinearStatic(m).run().u[-1, :, 1] == pytest.approx(1e-6 * at * (links - at) / (2 * FORCE), abs=1e-13)


def net(cells: int) -> tuple[kg.Model, list[kg.Node]]:
    """A square net of bars under tension, held along its rim."""
    m = kg.Model()
    grid = [[m.add(kg.Node(i, j)) for i in range(cells + 1)] for j in range(cells + 1)]
    rim = [node for row in grid for node in row if {node.x, node.y} & {0, cells}]
    for j in range(cells + 1):
        for i in range(cells + 1):
            for other in ([grid[j][i + 1]] if i < cells else []) + ([grid[j + 1][i]] if j < cells else []):
                m.add(kg.Bar(grid[j][i], other, 1.0, rest_length=stressed(1.0)))
    m.add(kg.Fix(rim))
    return m, [node for row in grid for node in row if node not in rim]


def test_net_has_the_frequencies_of_a_membrane() -> None:
    """omega^2 = 4 T / (m l) (sin^2(i pi / 2 N) + sin^2(j pi / 2 N)): the discrete drum, exactly."""
    cells = 6
    m, inner = net(cells)
    m.add(kg.Fix(inner, "xy"))
    wave = np.sin(np.arange(1, cells) * np.pi / (2 * cells)) ** 2
    exact = np.sort((4 * FORCE * (wave[:, None] + wave)).ravel())
    assert kg.Eigen(m, n=len(exact)).run().values == pytest.approx(exact, rel=1e-9)


def test_triangulated_membrane_approaches_the_drum() -> None:
    """Bars whose tension over length is the cotangent weight of their edge make a membrane under tension S = FORCE.

    Lowest frequency of a rectangle a x b with density 1: omega^2 = S pi^2 (1 / a^2 + 1 / b^2), at second order in the
    edge. (Cotangent weights: the linear triangle; Pinkall and Polthier, Exp. Math. 2 (1993).)
    """
    errors = []
    for columns in (6, 12):
        nodes, triangles = meshes.equilateral_strip(columns, columns)
        nodes = nodes / columns
        weights: dict[tuple[int, int], float] = {}
        for corners in triangles.tolist():
            for k in range(3):
                a, b, c = corners[k], corners[k - 1], corners[k - 2]
                one, other = nodes[a] - nodes[c], nodes[b] - nodes[c]
                edge = (min(a, b), max(a, b))
                cotangent = (one @ other) / abs(one[0] * other[1] - one[1] * other[0])
                weights[edge] = weights.get(edge, 0.0) + 0.5 * cotangent
        m = kg.Model()
        points = m.add(*(kg.Node(*map(float, p)) for p in nodes))
        for (a, b), weight in weights.items():
            length = float(np.linalg.norm(nodes[a] - nodes[b]))
            if weight > 1e-9:
                m.add(kg.Bar(points[a], points[b], weight * length, rest_length=stressed(length)))
        top = nodes[:, 1].max()
        rim = [p for p in points if min(p.x, 1 - p.x, p.y, top - p.y) < 1e-9]
        m.add(kg.Fix(rim), kg.Fix([p for p in points if p not in rim], "xy"))
        mass = np.bincount(triangles.ravel(), np.repeat(meshes.facet_area(nodes, triangles) / 3, 3), len(nodes))
        value = kg.Eigen(m, n=1, mass=mass).run().values[0]
        errors.append(abs(value / (FORCE * np.pi**2 * (1 + 1 / top**2)) - 1))
    assert errors[1] < 0.01
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_slack_chain_hangs_below() -> None:
    """Rest lengths 5 % too long: the straight chain at rest is squeezed past buckling, and leaves it.

    Three links with weak springs under a small dead load: the outer two slant, the middle one is level.
    """
    m = kg.Model(dim=2)
    nodes = m.add(*(kg.Node(float(x), 0.0) for x in range(4)))
    m.add(*(kg.Bar(a, b, 1.0, rest_length=1.05) for a, b in itertools.pairwise(nodes)))
    m.add(*(kg.TorsionSpring3(a, b, c, 1e-4) for a, b, c in zip(nodes, nodes[1:], nodes[2:])))
    m.add(kg.Fix([nodes[0], nodes[-1]]), kg.NodalLoad(nodes[1:-1], (0, -1e-4)))
    res = kg.LoadControl(m, on_instability="switch").run()
    assert not res.stable[0]  # at load factor 0 it is still straight
    assert res.stable[1:].all() and res.residual.max() <= 1e-8
    assert any(event.kind == "switch" for event in res.events)
    sag = np.sqrt(1.05**2 - (0.5 * (3 - 1.05)) ** 2)
    assert np.abs(res.u[-1, 1:3, 1]) == pytest.approx(sag, rel=5e-3)


@pytest.mark.parametrize("cells", [6, 16])
def test_sheet_that_wants_to_curl(cells: int) -> None:
    """Hinges across a strip of squares rest at 2 pi / 3 cells each: flat at first, it rolls up without stress."""
    share = 2 * np.pi / 3 / cells
    m = kg.Model()
    low = m.add(*(kg.Node(float(x), 0.0) for x in range(cells + 1)))
    high = m.add(*(kg.Node(float(x), 1.0) for x in range(cells + 1)))
    m.add(*(kg.Bar(a, b, 1e3) for a, b in zip(low, high)))
    for k in range(cells):
        m.add(*(kg.Bar(a, b, 1e3) for a, b in ((low[k], low[k + 1]), (high[k], high[k + 1]), (low[k], high[k + 1]))))
        m.add(kg.BendHinge(high[k], low[k], high[k + 1], low[k + 1], 1.0))
    for k in range(1, cells):
        m.add(kg.BendHinge(high[k - 1], low[k], high[k], low[k + 1], 1.0, rest_angle=share))
    m.add(kg.Fix([low[0], high[0]]), kg.Fix(low[1], "yz"), kg.NodalLoad(low[-1], (0, 0, 1e-9)))
    res = kg.LoadControl(m).run()
    line = res.position(low)[-1][:, [0, 2]]
    link = np.diff(line, axis=0)
    turn = np.unwrap(np.arctan2(link[:, 1], link[:, 0]))
    assert np.abs(np.diff(turn)) == pytest.approx(share, rel=1e-5)
    assert res.stable.all() and sum(part[-1] for part in res.energy.values()) < 1e-9


def test_two_way_stressed_bar_buckles_at_rest() -> None:
    """A straight pinned chain built with too much compression is unstable from the start, and Eigen says so."""
    compression = -0.02
    for stiffness, negative in ((0.1, 0), (0.002, 1)):  # critical 2 k / l against EA 0.02
        m = kg.Model(dim=2)
        a, b, c = m.add(kg.Node(0, 0), kg.Node(0, 1), kg.Node(0, 2))
        m.add(*(kg.Bar(i, j, 1.0, rest_length=stressed(1.0, compression)) for i, j in ((a, b), (b, c))))
        m.add(kg.TorsionSpring3(a, b, c, stiffness), kg.Fix([a, c]))
        values = kg.Eigen(m, n=2).run().values
        force = -compression * np.sqrt(1 + 2 * compression)
        assert np.sum(values < 0) == negative
        assert values[0] == pytest.approx(4 * stiffness - 2 * force, rel=1e-9)  # k (2 / l)^2 - 2 P / l
