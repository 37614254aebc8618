"""Eigenmodes of free, thin, small and loaded bodies: rigid motions exactly, then every mode, to many digits."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import shapely
from scipy.sparse.linalg import splu

import kirigami as kg

RUNGS = ("paper", "plate", "facet", "shell")
DRAWN = kg.Material(E=4e9, nu=0.38)


def slit_sheet(thickness: float, edge: float, rung: str) -> kg.Model:
    """A free sheet of 100 x 60 mm with a column of slits; all lengths are given in millimetres."""
    unit = 1e-3
    slits = kg.cuts.parallel_slits(
        columns=6, rows=8, width=100 * unit, height=24 * unit, length=12 * unit, margin=18 * unit
    )
    sheet = kg.Sheet(shapely.box(0, 0, 0.1, 0.06), slits, thickness=thickness * unit, material=DRAWN)
    return kg.Model.from_mesh(sheet.mesh(max_edge=edge * unit), stiffness=rung)


def out_of_plane(m: kg.Model, count: int) -> np.ndarray:
    """Lowest eigenvalues of the deflections of a flat sheet, whose stiffness stands apart; dense, unit masses.

    Unknowns beside the deflections of the mesh's nodes have no mass and are eliminated.
    """
    system = kg.System(m)
    matrix = system.stiffness().tocsc()
    massive = np.flatnonzero((system.heads % 3 == 2) & (system.heads // 3 < len(m.mesh.nodes)))
    light = np.flatnonzero(system.heads // 3 >= len(m.mesh.nodes))
    block = matrix[massive][:, massive].toarray()
    if light.size:
        coupling = matrix[light][:, massive].toarray()
        block -= coupling.T @ splu(matrix[light][:, light].tocsc()).solve(coupling)
    return np.linalg.eigvalsh(block)[:count]


@pytest.mark.parametrize("rung", RUNGS)
@pytest.mark.parametrize("thickness", [0.05, 0.125, 0.7])
def test_free_sheets_have_six_zeros_then_the_modes(rung: str, thickness: float) -> None:
    """The three rigid motions out of the plane and the bending modes against a dense solution; three in the plane."""
    m = slit_sheet(thickness, 8.0, rung)
    analysis = kg.Eigen(m, n=14)
    values = analysis.run().values
    assert np.array_equal(values[:6], np.zeros(6)) and values[6] > 0
    dense = out_of_plane(m, 11)[3:]
    assert values[6:14] == pytest.approx(dense, rel=1e-6)
    assert analysis.results.stats["factorizations"] <= 2


@pytest.mark.long
@pytest.mark.parametrize("rung", RUNGS)
def test_forty_free_sheets(rung: str) -> None:
    for thickness in (0.05, 0.1, 0.125, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.7):
        for edge in (4.0, 5.0, 6.0, 8.0):
            m = slit_sheet(thickness, edge, rung)
            values = kg.Eigen(m, n=9).run().values
            assert np.array_equal(values[:6], np.zeros(6)), (thickness, edge)
            assert values[6:] == pytest.approx(out_of_plane(m, 6)[3:], rel=1e-6), (thickness, edge)


@pytest.mark.parametrize("rung", RUNGS)
@pytest.mark.parametrize("edge", [0.07, 0.03])
@pytest.mark.parametrize("free", [False, True])
def test_bending_goes_with_the_third_power_of_the_thickness(rung: str, edge: float, free: bool) -> None:
    """Eigenvalue / E t^3 of one flat mesh is one number, whatever the thickness and the number of unknowns."""
    edge *= 1 + (rung == "shell")  # whose edges have unknowns of their own
    mesh = kg.Sheet(shapely.box(0, 0, 1, 0.2)).mesh(edge)
    ratios = []
    for t in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
        m = kg.Model.from_mesh(mesh, t, kg.Material(E=1e9, nu=0.3), stiffness=rung)
        if not free:
            m.add(kg.Fix(m.select(boundary="left"), clamp=True))
        ratios.append(kg.Eigen(m, n=8).run().values[6 * free : 6 * free + 2] / (1e9 * t**3))
    assert np.array(ratios) == pytest.approx(np.tile(ratios[0], (5, 1)), rel=1e-6)


@pytest.mark.parametrize("rung", RUNGS)
def test_every_number_of_modes_tells_the_same_values(rung: str) -> None:
    m = slit_sheet(0.2, 8.0, rung)
    most = kg.Eigen(m, n=20).run().values
    for n in (1, 6, 7, 13):
        assert kg.Eigen(m, n=n).run().values == pytest.approx(most[:n], rel=1e-8)


def test_a_tilted_sheet_has_the_modes_of_the_level_one() -> None:
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    mesh = kg.Sheet(shapely.box(0, 0, 1, 0.2)).mesh(0.07)
    for t in (1e-2, 1e-3):
        values = []
        for points in (mesh.nodes, mesh.nodes @ turn.T):
            m = kg.Model.from_mesh(kg.TriMesh(points, mesh.triangles), t, kg.Material(E=1e9), stiffness="facet")
            values.append(kg.Eigen(m, n=10).run().values)
        assert values[1] == pytest.approx(values[0], rel=1e-6)


def test_modes_below_rounding_are_refused_and_mechanisms_are_zero() -> None:
    """A tilted sheet of t / L = 1e-6 adds bending of 1e-16 to stretching: its modes are not zero, and not told so."""
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    mesh = kg.Sheet(shapely.box(0, 0, 1, 0.2)).mesh(0.07)
    for t in (1e-4, 1e-6):
        m = kg.Model.from_mesh(
            kg.TriMesh(mesh.nodes @ turn.T, mesh.triangles), t, kg.Material(E=1e9, nu=0.3), stiffness="plate"
        )
        m.add(kg.Fix([node for node, point in zip(m.nodes, mesh.nodes) if point[0] < 1e-9], clamp=True))
        if t == 1e-6:
            with pytest.raises(kg.AnalysisError, match="rounding of the stiffness"):
                kg.Eigen(m, n=1).run()
        else:
            assert kg.Eigen(m, n=1).run().values[0] / (1e9 * t**3) == pytest.approx(2.1053e-3, rel=1e-3)
            m.remove(*[item for item in m.elements if isinstance(item, kg.BendHinge)])
            m.remove(*m.constraints)
            m.add(kg.Fix([node for node, point in zip(m.nodes, mesh.nodes) if point[0] < 1e-9]))
            assert np.abs(kg.Eigen(m, n=4).run().values).max() < 1e-9 * 1e9 * t


def test_two_bodies_have_twelve_rigid_motions_and_a_tie_leaves_what_it_allows() -> None:
    """Two tetrahedra of bars; tied in x only they still slide and turn against each other."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    for tied, zeros in ((False, 12), (True, 11)):
        m = kg.Model()
        groups = [m.add(*(kg.Node(*(corner + shift)) for corner in corners)) for shift in ([0, 0, 0], [3, 0, 0])]
        for group in groups:
            m.add(*(kg.Bar(group[a], group[b], 1.0) for a in range(4) for b in range(a)))
        if tied:
            m.add(kg.Tie(groups[0][1], groups[1][0], "x"))
        count = 24 - tied
        values = kg.Eigen(m, n=count).run().values
        assert np.abs(values[:zeros]).max() < 1e-12 < 1e-3 < values[zeros]
        dense = np.linalg.eigvalsh(kg.System(m).stiffness().toarray())
        if not tied:
            assert values == pytest.approx(dense, abs=1e-9)


def test_a_straight_chain_of_bars_has_its_mechanisms() -> None:
    """n bars in line in space: every sideways motion is free, the stretches are those of a chain of springs."""
    n = 6
    m = kg.Model()
    nodes = m.add(*(kg.Node(k, 0) for k in range(n + 1)))
    m.add(*(kg.Bar(a, b, 1.0) for a, b in pairwise(nodes)))
    values = kg.Eigen(m, n=3 * (n + 1)).run().values
    exact = np.append(np.zeros(2 * (n + 1)), 2 - 2 * np.cos(np.pi * np.arange(n + 1) / (n + 1)))
    assert values == pytest.approx(np.sort(exact), abs=1e-12)


@pytest.mark.parametrize("rung", ["plate", "facet"])
def test_modes_about_a_loaded_state(rung: str) -> None:
    """A compressed strip that has not been let buckle: as many negative values as its path counts, dense ones all."""
    m = kg.Model.from_mesh(kg.Sheet(shapely.box(0, 0, 1, 0.2)).mesh(0.07), 0.01, kg.Material(1e9, 0.3), stiffness=rung)
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, "xz"), kg.Fix(left[0], "y"), kg.Fix(right, "z"), kg.Prescribe(right, x=-0.003))
    res = kg.DisplacementControl(m, on_instability="follow").run()
    for step in (res[len(res) // 2], res[-1]):
        dense = np.linalg.eigvalsh(kg.System(m).stiffness(step.u, step.lam).toarray())
        values = kg.Eigen(m, n=8, about=step).run().values
        assert values == pytest.approx(dense[:8], rel=1e-6)
        assert np.count_nonzero(values < 0) == step.negative


def test_a_taut_string() -> None:
    """Bars that want to be shorter, between fixed ends: (4 N / (l m)) sin^2(k pi / 2 n) with the bars' force N."""
    n, rest_length = 20, 0.99
    force = 0.5 * (1 / rest_length**2 - 1) / rest_length  # EA e l / L0 with the Green strain e
    m = kg.Model()
    nodes = m.add(*(kg.Node(k, 0) for k in range(n + 1)))
    m.add(*(kg.Bar(a, b, 1.0, rest_length=rest_length) for a, b in pairwise(nodes)))
    m.add(kg.Fix([nodes[0], nodes[-1]]))
    exact = 4 * force * np.sin(np.arange(1, 6) * np.pi / (2 * n)) ** 2
    assert kg.Eigen(m, n=10).run().values == pytest.approx(np.repeat(exact, 2), rel=1e-9)


def test_lumped_and_unit_masses_of_one_sheet_do_not_depend_on_hidden_unknowns() -> None:
    """A cantilever under unit masses: the first value of every rung is the beam's, within what its mesh allows."""
    mesh = kg.Sheet(shapely.box(0, 0, 1, 0.1)).mesh(0.025)
    t, E, width = 0.01, 1e9, 0.1
    per_length = len(mesh.nodes) / 1.0
    beam = 1.875104**4 * E * width * t**3 / 12 / per_length
    for rung in ("plate", "shell"):
        m = kg.Model.from_mesh(mesh, t, kg.Material(E, nu=0.0, density=7.0), stiffness=rung)
        m.add(kg.Fix(m.select(boundary="left"), clamp=True))
        assert kg.Eigen(m, n=1).run().values[0] == pytest.approx(beam, rel=0.07)
        lumped = kg.Eigen(m, n=1, mass="lumped").run().values[0]
        assert lumped == pytest.approx(1.875104**4 * E * t**2 / 12 / 7.0, rel=0.03)
