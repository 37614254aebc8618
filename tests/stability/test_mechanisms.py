"""Too few members: refused with the motion in words, or led along its free path. Too many: one answer all the same."""

from __future__ import annotations

import meshes
import numpy as np
import pytest

import kirigami as kg


def linkage() -> tuple[kg.Model, tuple[kg.Node, ...]]:
    """Four bars round a unit square, the lower two corners held."""
    m = kg.Model(dim=2)
    corners = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(1, 1), kg.Node(0, 1))
    m.add(*(kg.Bar(corners[k], corners[(k + 1) % 4], EA=1.0) for k in (1, 2, 3)), kg.Fix(corners[:2]))
    return m, corners


def rotating_squares() -> tuple[kg.Model, tuple[kg.Node, ...]]:
    """Two by two squares with diagonals, hinged at their corners: one zero-energy motion beside the rigid ones."""
    m = kg.Model(dim=2)
    turn = 0.3
    arm = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) / np.sqrt(2)
    pitch = np.sqrt(2) * np.cos(turn)
    at: dict[tuple[float, float], kg.Node] = {}
    for i in range(2):
        for j in range(2):
            rows = arm if (i + j) % 2 == 0 else arm * [[1, -1], [-1, 1]]
            corners = []
            for corner in (rows[0], rows[1], -rows[0], -rows[1]):
                place = np.round(pitch * np.array([i, j]) + corner, 9)
                key = (float(place[0]), float(place[1]))
                if key not in at:
                    at[key] = m.add(kg.Node(*key))
                corners.append(at[key])
            m.add(*(kg.Bar(corners[a], corners[b], 1.0) for a, b in ((0, 1), (1, 2), (2, 3), (3, 0), (0, 2), (1, 3))))
    return m, tuple(at.values())


@pytest.mark.parametrize("analysis", ["linear", "load", "arc"])
def test_linkage_under_load_is_refused(analysis: str) -> None:
    m, corners = linkage()
    m.add(kg.NodalLoad(corners[2], (1e-3, 0)))
    run = {"linear": kg.LinearStatic(m), "load": kg.LoadControl(m), "arc": kg.ArcLength(m, step=0.1)}[analysis]
    with pytest.raises(kg.MechanismError, match="along x") as caught:
        run.run()
    assert sorted(caught.value.nodes) == [2, 3]


def test_linkage_led_round_its_circle() -> None:
    """Driven by one node there is nothing left to choose: the other follows on its circle, and nothing is strained."""
    m, corners = linkage()
    m.add(kg.Prescribe(corners[2], x=0.9))
    res = kg.DisplacementControl(m).run()
    driven, follower = (res.position(node)[:, :2] for node in corners[2:])
    assert driven[:, 0] == pytest.approx(1 + 0.9 * res.lam)
    assert driven[:, 1] == pytest.approx(np.sqrt(1 - (0.9 * res.lam) ** 2), abs=1e-7)
    assert follower == pytest.approx(driven - [1, 0], abs=1e-7)
    assert res.energy["bars"].max() < 1e-14 and np.abs(res.reaction(corners[2], "x")).max() < 1e-7


def test_linkage_led_beyond_its_reach() -> None:
    """Past the dead centre the bars must stretch: the straight linkage, by closed form, and not a lost solution."""
    m, corners = linkage()
    m.add(kg.Prescribe(corners[2], x=1.2))
    res = kg.DisplacementControl(m).run()
    assert res.lam[-1] == 1.0 and res.stable[-1]
    assert res.position(corners[2])[-1] == pytest.approx([2.2, 0.0, 0.0], abs=1e-6)
    # Green strains: one bar spans 1.2, the other two in line span 2.2.
    assert res.bar_strain[-1] == pytest.approx([(1.2**2 - 1) / 2, *2 * [(1.1**2 - 1) / 2]], abs=1e-6)
    assert res.residual.max() <= 1e-8


def test_hinged_squares_are_refused() -> None:
    m, nodes = rotating_squares()
    low = min(nodes, key=lambda node: (node.y, node.x))
    high = max(nodes, key=lambda node: (node.y, node.x))
    m.add(kg.Fix(low), kg.Fix(max(nodes, key=lambda node: node.x), "y"), kg.NodalLoad(high, (0, 1e-3)))
    with pytest.raises(kg.MechanismError, match="floppy"):
        kg.LoadControl(m).run()


def test_flat_truss_in_space_is_refused_and_with_hinges_it_stands() -> None:
    """Bars alone do not resist the inner nodes' leaving the plane; hinges do."""
    nodes, triangles = meshes.equilateral_strip(4, 4)
    for bending in (0.0, 0.1):
        m, points = meshes.sheet(nodes, triangles, 1.0, 0.1, bending=bending)
        rim = [p for p in points if min(p.x, 4 - p.x, p.y, nodes[:, 1].max() - p.y) < 1e-9]
        m.add(kg.Fix(rim), kg.NodalLoad([p for p in points if p not in rim], (0, 0, 1e-7)))
        if bending:
            assert kg.LinearStatic(m).run().u[-1, :, 2].max() > 0
        else:
            with pytest.raises(kg.MechanismError, match="along z"):
                kg.LinearStatic(m).run()


def test_a_taut_string_stands_where_a_slack_one_does_not() -> None:
    """Two bars in line: a mechanism to first order, unless a tension T holds the middle: w = P L / (4 T)."""
    tension, load = 0.02, 1e-8
    for rest_length in (None, 1 / np.sqrt(1 + 2 * tension)):  # Green strain T at EA = 1 on the stretched length
        m = kg.Model(dim=2)
        left, middle, right = m.add(kg.Node(-1, 0), kg.Node(0, 0), kg.Node(1, 0))
        m.add(*(kg.Bar(a, middle, 1.0, rest_length=rest_length) for a in (left, right)))
        m.add(kg.Fix([left, right]), kg.NodalLoad(middle, (0, load)))
        if rest_length is None:
            with pytest.raises(kg.MechanismError, match="along y"):
                kg.LinearStatic(m).run()
        else:
            force = tension / rest_length  # EA e l / L0
            assert kg.LinearStatic(m).run().u[-1, 1, 1] == pytest.approx(load * 2 / (4 * force), rel=1e-9)


def test_everything_held() -> None:
    """No unknown is left: reactions are those of the bars, and the path has its steps."""
    m = kg.Model(dim=2)
    a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1))
    m.add(kg.Bar(a, b, 2.0), kg.Bar(b, c, 2.0), kg.Bar(c, a, 2.0), kg.Fix([a, b]), kg.Prescribe(c, x=0, y=0.5))
    res = kg.DisplacementControl(m).run()
    assert res.lam[-1] == 1.0 and res.stable.all()
    upright = 2.0 * 0.625 * 1.5  # EA e (1 + u) of the bar c-a
    slanted = 2.0 * (1 + 1.5**2 - 2) / 4 * np.array([-1.0, 1.5]) / np.sqrt(2)  # EA e / L times the vector b to c
    assert res.reaction(c)[-1, :2] == pytest.approx(slanted + [0, upright], rel=1e-12)


@pytest.mark.parametrize("extra", [1, 2, 5])
def test_members_side_by_side_add_up(extra: int) -> None:
    """A triangle with every bar several times over, and an X in a held frame: stiffnesses add, nothing is singular."""
    m = kg.Model(dim=2)
    a, b, c = m.add(kg.Node(-1, 0), kg.Node(1, 0), kg.Node(0, 1))
    m.add(*(kg.Bar(i, j, 1.0) for _ in range(extra) for i, j in ((a, b), (b, c), (c, a))))
    m.add(kg.Fix([a, b]), kg.NodalLoad(c, (0, -1e-4 * extra)))
    down = kg.LinearStatic(m).run().u[-1, 2, 1]
    assert down == pytest.approx(-1e-4 / (2 * 0.5 / np.sqrt(2)), rel=1e-9)  # 2 EA sin^2 / L


def test_sheet_held_all_round_and_everywhere_but_one_node() -> None:
    """One free node amid fixed ones, pulled out of the plane: six bars of the equilateral net, each P = EA e l / L."""
    nodes, triangles = meshes.equilateral_strip(4, 4)
    m, points = meshes.sheet(nodes, triangles, 1.0, 1.0, bending=0.0)
    middle = min(points, key=lambda p: abs(p.x - 2) + abs(p.y - nodes[:, 1].max() / 2))
    m.add(kg.Fix([p for p in points if p is not middle]), kg.Fix(middle, "xy"), kg.Prescribe(middle, z=0.5))
    res = kg.DisplacementControl(m).run()
    around = [bar for bar in m.elements if middle in bar.nodes]
    strain = 0.5**2 / 2  # Green: z^2 / (2 L^2), L = 1
    assert len(around) == 6
    assert res.reaction(middle, "z")[-1] == pytest.approx(sum(bar.EA for bar in around) * strain * 0.5, rel=1e-9)
