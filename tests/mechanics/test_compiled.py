"""Compiled loops against the kernels they stand in for."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

import kirigami as kg
from kirigami.system import assembly

pytestmark = pytest.mark.skipif(importlib.util.find_spec("numba") is None, reason="numba is not installed")


def wavy_sheet(monkeypatch: pytest.MonkeyPatch, by_loops: bool) -> kg.System:
    """A square sheet with an offset and two held edges; with or without compiled loops."""
    monkeypatch.setattr(assembly, "MEMBERS", 1)
    monkeypatch.setenv("KIRIGAMI_COMPILED", "1" if by_loops else "0")
    sheet = kg.Sheet([(0, 0), (1, 0), (1, 1), (0, 1)], thickness=0.01, material=kg.Material(E=1e6))
    m = kg.Model.from_mesh(sheet.mesh(max_edge=0.2))
    x, y, _ = m.positions().T
    m.perturb(0.05 * np.sin(5 * x) * np.cos(4 * y))
    m.add(kg.Fix(m.select(boundary="bottom")), kg.Prescribe(m.select(boundary="top"), y=0.1))
    system = kg.System(m)
    assert all(system.twins) is by_loops
    return system


@pytest.mark.parametrize("convexity", [0.0, 0.4])
@pytest.mark.parametrize("mixed", [False, True])
def test_forces_and_blocks_agree(monkeypatch: pytest.MonkeyPatch, convexity: float, mixed: bool) -> None:
    rng = np.random.default_rng(3)
    found = []
    for by_loops in (False, True):
        system = wavy_sheet(monkeypatch, by_loops)
        u = 0.05 * np.random.default_rng(1).normal(size=system.rest.shape)
        system.commit(0.5 * u)  # angles are counted from the last committed state
        ahead = (u, 0.1 * np.random.default_rng(2).normal(size=u.shape)) if mixed else None
        tangent = kg.Tangent(convexity, ahead)
        forces, scale = system.forces(u, 0.5)
        blocks = system.stiffness_blocks(u, 0.5, tangent)
        found.append((forces, scale, blocks, system.matrix(blocks).toarray()))
    for plain, loops in zip(*found):
        assert np.abs(loops - plain).max() < 1e-13 * np.abs(plain).max()
    tangent, change = found[1][3], rng.normal(size=found[1][3].shape[0])
    assert np.abs(tangent - tangent.T).max() < 1e-13 * np.abs(tangent).max()
    if not convexity and not mixed:  # and the tangent is the derivative of the forces
        system, h = wavy_sheet(monkeypatch, True), 1e-7
        u = 0.05 * np.random.default_rng(1).normal(size=system.rest.shape)
        q = system.unknowns(u)
        tangent = system.stiffness(system.displacement(q, 0.5), 0.5)
        ahead, back = (
            system.imbalance(system.displacement(q + sign * h * change, 0.5), 0.5)[0] for sign in (1, -1)
        )
        assert np.abs((ahead - back) / (2 * h) - tangent @ change).max() < 1e-6 * np.abs(tangent @ change).max()


def test_turned_hinges_keep_count_of_their_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    """An angle beyond half a turn has the moment of that angle, not of the angle less one turn."""
    monkeypatch.setattr(assembly, "MEMBERS", 1)
    monkeypatch.setenv("KIRIGAMI_COMPILED", "1")
    m = kg.Model()
    i, j, k, l = m.add(kg.Node(0.5, 1), kg.Node(0, 0), kg.Node(1, 0), kg.Node(0.5, -1))
    m.add(kg.BendHinge(i, j, k, l, stiffness=2.0), kg.Fix([i, j, k]))
    system = kg.System(m)
    u = np.zeros((4, 3))
    for angle in np.linspace(0, 1.5 * np.pi, 7):
        u[3] = 0, 1 - np.cos(angle), np.sin(angle)
        moment = np.cross([0, -np.cos(angle), np.sin(angle)], system.forces(u, 0.0)[0][3])[0]
        assert abs(moment) == pytest.approx(2.0 * angle, abs=1e-9)
        system.commit(u)


def test_a_path_is_the_same_and_the_summary_names_the_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = []
    for by_loops in (False, True):
        res = kg.DisplacementControl(wavy_sheet(monkeypatch, by_loops).model, to=0.2, step=0.1, tol=1e-12).run()
        assert ("compiled" in res.summary()) is by_loops
        ends.append(res.u[-1])
    assert np.abs(ends[1] - ends[0]).max() < 1e-9 * np.abs(ends[0]).max()


@pytest.mark.parametrize("convexity", [0.0, 0.4])
def test_held_edges_agree(monkeypatch: pytest.MonkeyPatch, convexity: float) -> None:
    """Clamps, which carry their direction along, and mirror planes, which stand still, at rest and driven."""
    found = []
    for by_loops in (False, True):
        monkeypatch.setattr(assembly, "MEMBERS", 1)
        monkeypatch.setenv("KIRIGAMI_COMPILED", "1" if by_loops else "0")
        sheet = kg.Sheet([(0, 0), (1, 0), (1, 1), (0, 1)], thickness=0.01, material=kg.Material(E=1e6))
        m = kg.Model.from_mesh(sheet.mesh(max_edge=0.3))
        m.perturb(0.05 * np.sin(5 * m.positions()[:, 0]) * np.cos(4 * m.positions()[:, 1]))
        m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.Symmetry(m.select(boundary="left")[1:], "x"))
        m.add(kg.Actuate(strain=(0.02, 0.0, 0.0), curvature=(0.4, 0.1, 0.2)))
        system = kg.System(m)
        twin = next(twin for kernel, twin in zip(system.kernels, system.twins) if kernel.name == "clamps")
        assert (twin is not None) is by_loops
        u = 0.05 * np.random.default_rng(1).normal(size=system.rest.shape)
        system.commit(0.5 * u)
        forces, scale = system.forces(u, 0.5)
        clamps = [kernel for kernel in system.kernels if kernel.name == "clamps"]
        assert sum(len(kernel.conn) for kernel in clamps) > 6 and clamps[0]._turns.carried.any()
        assert not clamps[0]._turns.carried.all()
        found.append((forces, scale, system.stiffness_blocks(u, 0.5, kg.Tangent(convexity)), clamps[0].force_at(
            clamps[0].deformation(system.configuration(u)), 0.5)))  # fmt: skip
    assert np.abs(found[0][3]).min() > 0
    for plain, loops in zip(*found):
        assert np.abs(loops - plain).max() < 1e-13 * np.abs(plain).max()
