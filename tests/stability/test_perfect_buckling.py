"""Columns and strips without any imperfection: Euler's load, both branches, and modes that come together."""

from __future__ import annotations

import meshes
import numpy as np
import pytest

import kirigami as kg


def column(links: int, axial: float = 1e4) -> tuple[kg.Model, tuple[kg.Node, ...]]:
    """A straight, pinned chain of links of length 1 with springs k = 1, standing along y."""
    m, nodes = meshes.chain(np.column_stack([np.zeros(links + 1), np.arange(links + 1.0)]), 1.0, axial)
    m.add(kg.Fix(nodes[0]), kg.Fix(nodes[-1], "x"))
    return m, nodes


def hencky(links: int, mode: int = 1) -> float:
    """Critical load (4 k / l) sin^2(n pi / 2 N) of a pinned chain of N links (Hencky 1921)."""
    return float(4 * np.sin(mode * np.pi / (2 * links)) ** 2)


@pytest.mark.parametrize("links", [2, 5, 12])
def test_perfect_column_is_followed_through_all_its_critical_loads(links: int) -> None:
    """On the straight path one more eigenvalue turns negative at each of Hencky's loads."""
    m, nodes = column(links, axial=1e6)
    m.add(kg.NodalLoad(nodes[-1], (0, -4.0)))
    modes = np.array([hencky(links, n) for n in range(1, links)])
    between = np.sort(np.concatenate([[0.5 * modes[0]], 0.5 * (modes[1:] + modes[:-1]), [0.5 * (modes[-1] + 4.0)]])) / 4
    res = kg.LoadControl(m, targets=between, on_instability="follow").run()
    assert np.abs(res.u[:, :, 0]).max() < 1e-9
    at = [int(np.argmin(np.abs(res.lam - lam))) for lam in between]
    assert [res[k].negative for k in at] == list(range(links))


@pytest.mark.parametrize("links", [2, 5, 12])
def test_perfect_column_leaves_for_the_bent_branch(links: int) -> None:
    """Shortened by its grip: stable, bent, the force just above Hencky's load (it rises by the shortening / 2 L)."""
    m, nodes = column(links)
    shortening = 0.02 * links
    m.add(kg.Prescribe(nodes[-1], y=-shortening))
    res = kg.DisplacementControl(m).run()
    assert res.lam[-1] == 1.0 and res.stable.all()
    assert np.abs(res.u[-1, :, 0]).max() > 0.1
    force = -res.reaction(nodes[-1], "y")[-1]
    assert force == pytest.approx(hencky(links) * (1 + 0.5 * shortening / links), rel=5e-3)


def strip(columns: int = 20) -> tuple[kg.Model, list[list[kg.Node]], float]:
    """A perfect strip of right triangles with level columns, and its rigidity D W (D = c E t^3, exact here)."""
    nodes, triangles = meshes.right_isosceles(columns, 2)
    thickness, constant = 0.05, 0.09
    m, points = meshes.sheet(nodes, triangles, 1.0, thickness, bending=constant)
    lines = [[p for p in points if abs(p.x - n) < 1e-9] for n in range(columns + 1)]
    m.add(*(kg.Tie(line[1:], line[0], "z") for line in lines[1:-1]), kg.Fix([line[0] for line in lines], "y"))
    return m, lines, constant * thickness**3 * 2.0


@pytest.mark.parametrize("start", ["follow", "switch"])
def test_perfect_strip_buckles_at_the_load_of_euler(start: str) -> None:
    """Pinned strip of 20 cells, shortened in its plane: flat up to (4 D W / l^2) sin^2(pi / 2 N), then not.

    Euler's pi^2 D W / L^2 is 0.2 % higher.
    """
    m, lines, rigidity = strip()
    critical = hencky(20) * rigidity
    assert critical == pytest.approx(np.pi**2 * rigidity / 20**2, rel=3e-3)
    m.add(kg.Fix(lines[0], "xz"), kg.Fix(lines[-1], "z"), kg.Prescribe(lines[-1], x=-0.02))
    res = kg.DisplacementControl(m, on_instability=start, step=1e-3).run()
    force = -res.reaction(lines[-1], "x")
    assert res.lam[-1] == 1.0 and res.residual.max() <= 1e-8
    bent = np.abs(res.u[:, :, 2]).max(axis=1) > 1e-6
    assert force[~bent & res.stable].max() < critical * 1.001
    if start == "follow":
        assert not bent.any() and not res.stable[-1]
        assert force[~res.stable].min() > critical * 0.999
    else:
        assert bent[-1] and res.stable.all()
        assert force[-1] == pytest.approx(critical, rel=0.01)  # the plateau of a strip that hardly shortens


def two_modes(ratio: float) -> tuple[kg.Model, tuple[kg.Node, ...], float, float]:
    """Three links with joint springs k and side springs c: critical loads of the even and the odd mode.

    With deflections w1, w2 of the joints the energy is c (w1^2 + w2^2) / 2 + k ((2 w1 - w2)^2 + (2 w2 - w1)^2) / 2
    less P (w1^2 + (w2 - w1)^2 + w2^2) / 2 (l = 1), hence P = c + k for w1 = w2 and P = c / 3 + 3 k for w1 = -w2:
    equal for k = c / 3.
    """
    side = 1.0
    joint = ratio * side / 3
    m, nodes = meshes.chain(np.column_stack([np.zeros(4), np.arange(4.0)]), joint, 1e5)
    reach = 100.0  # long bars across act as side springs
    walls = m.add(*(kg.Node(reach, node.y) for node in nodes[1:3]))
    m.add(*(kg.Bar(node, wall, side * reach) for node, wall in zip(nodes[1:3], walls)))
    m.add(kg.Fix([nodes[0], *walls]), kg.Fix(nodes[-1], "x"))
    return m, nodes, side + joint, side / 3 + 3 * joint


@pytest.mark.parametrize("ratio", [0.98, 1.0, 1.001, 1.05])
def test_two_modes_at_nearly_the_same_load(ratio: float) -> None:
    """Followed: no eigenvalue is negative below both loads, two above. Switched: a stable bent state of less energy."""
    m, nodes, even, odd = two_modes(ratio)
    m.add(kg.NodalLoad(nodes[-1], (0, -1.0)))
    targets = [0.99 * min(even, odd), 1.01 * max(even, odd)]
    res = kg.LoadControl(m, to=targets[-1], targets=targets, on_instability="follow").run()
    at = [int(np.argmin(np.abs(res.lam - lam))) for lam in targets]
    assert [res[k].negative for k in at] == [0, 2]

    energies = {}
    for choice in ("follow", "switch"):
        m, nodes, *_ = two_modes(ratio)
        m.add(kg.Prescribe(nodes[-1], y=-0.05))
        res = kg.DisplacementControl(m, on_instability=choice).run()
        assert res.lam[-1] == 1.0 and res.residual.max() <= 1e-8
        assert np.abs(res.u[-1, :4, 0]).max() < 1e-6 if choice == "follow" else res.stable.all()
        energies[choice] = sum(part[-1] for part in res.energy.values())
    assert energies["switch"] < 0.9 * energies["follow"]


def test_no_imperfection_asked_for_is_none() -> None:
    m, nodes = column(4)
    before = m.positions()
    m.perturb(np.eye(5, 2), amplitude=0.0)
    m.perturb(np.zeros((5, 3)))
    assert np.array_equal(m.positions(), before)


@pytest.mark.parametrize("choice", ["switch", "follow", "stop"])
def test_perfectly_flat_slit_sheet(choice: str) -> None:
    """A flat sheet stays flat on its symmetric path, and is told unstable there; switched, it leaves it.

    The lips of a slit buckle when the sheet is pulled across it.
    """
    nodes, triangles = meshes.equilateral_strip(10, 10, 0.1)
    slit = [k for k, p in enumerate(nodes) if abs(p[1] - nodes[:, 1].max() / 2) < 0.05 and 0.15 < p[0] < 0.85]
    level = nodes[slit[0], 1]
    slit = [k for k in slit if abs(nodes[k, 1] - level) < 1e-9]
    mesh = kg.TriMesh(*meshes.open_slit(nodes, triangles, slit))
    m = kg.Model.from_mesh(mesh, 2e-3, kg.Material(1e9))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=0.05))
    res = kg.DisplacementControl(m, on_instability=choice).run()
    out_of_plane = np.abs(res.u[:, :, 2]).max(axis=1)
    assert res.residual.max() <= 1e-8 and np.isfinite(res.u).all()
    if choice == "switch":
        assert res.lam[-1] == 1.0 and res.stable.all() and out_of_plane[-1] > 0.02
        assert any(event.kind == "switch" for event in res.events)
    else:
        assert not out_of_plane.any() and not res.stable[-1]
        assert (res.lam[-1] == 1.0) == (choice == "follow")
        assert np.array_equal(res.stable, np.arange(len(res)) < np.argmin(res.stable))
