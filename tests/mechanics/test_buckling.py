"""Linear buckling loads: Euler's columns as strips and chains, the two-link column, what is refused."""

from __future__ import annotations

from itertools import pairwise

import meshes
import numpy as np
import pytest
from shapely import box

import kirigami as kg
from kirigami.linalg import factorize

YOUNG, NU, THICKNESS = 1e6, 1 / 3, 0.02
PLATE = 1 / (12 * (1 - NU**2))  # c of the hinge constant c E t^3 L^2 / (A1 + A2)

# Supports of a strip along x: what holds its slope, whether its far end is free, load over Euler's pinned load
COLUMNS = {"pinned": (False, False, 1.0), "clamped": (True, False, 4.0), "cantilever": (True, True, 0.25)}


@pytest.mark.parametrize("ends", COLUMNS)
@pytest.mark.parametrize("cells", [20, 40])
def test_euler_column_of_a_strip(ends: str, cells: int) -> None:
    """P = pi^2 B / L^2 and its multiples, with the bending stiffness of the equilateral mesh, B = 8/9 c E t^3 W."""
    clamp, free, factor = COLUMNS[ends]
    rows, length = 2, 20.0
    nodes, triangles = meshes.equilateral_strip(cells, rows, length / cells)
    m = kg.Model.from_mesh(kg.TriMesh(nodes, triangles), THICKNESS, kg.Material(YOUNG, nu=NU))
    width = float(np.ptp(nodes[:, 1]))
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, "xz", clamp=clamp), kg.Fix(m.select(box=(0, width / 2, 0, width / 2)), "y"))
    if not free:
        m.add(kg.Fix(right, "z", clamp=clamp))
    at_corner = np.isin(m.index(right), m.index(m.select(where=lambda x, y, z: (y < 1e-9) | (y > width - 1e-9))))
    for node, corner in zip(right, at_corner):
        m.add(kg.NodalLoad(node, ((-0.5 if corner else -1.0) / rows, 0, 0)))
    modes = kg.Buckling(m, n=3).run()
    euler = np.pi**2 * (8 / 9) * PLATE * YOUNG * THICKNESS**3 * width / length**2
    assert modes.values[0] == pytest.approx(factor * euler, rel=0.02 if cells == 20 else 0.01)
    assert np.all(np.diff(modes.values) > 0)
    assert np.abs(modes[0].shape[:, 2]).max() == 1.0 and np.abs(modes[0].shape[:, :2]).max() < 1e-6
    if ends == "pinned":  # n^2, and half sine waves
        assert modes.values / euler == pytest.approx([1, 4, 9], rel=0.02)
        wave = np.sin(np.pi * nodes[:, 0] / length)
        assert modes[0].shape[:, 2] == pytest.approx(wave, abs=0.02)


@pytest.mark.parametrize("links", [2, 3, 10, 300])
def test_hencky_chain(links: int) -> None:
    """N links, N - 1 springs, pinned ends: P = 4 k / l sin^2(pi / 2N); two links give 2 k / l. 300 are past dense."""
    m = kg.Model(dim=2)
    nodes = m.add(*(kg.Node(0, float(place)) for place in range(links + 1)))
    m.add(*(kg.Bar(a, b, 1e8) for a, b in pairwise(nodes)))
    m.add(*(kg.TorsionSpring3(a, b, c, 1.0) for a, b, c in zip(nodes, nodes[1:], nodes[2:])))
    m.add(kg.Fix(nodes[0]), kg.Fix(nodes[-1], "x"), kg.NodalLoad(nodes[-1], (0, -1)))
    found = kg.Buckling(m, n=min(links - 1, 4)).run()
    order = np.arange(1, len(found) + 1)
    assert found.values == pytest.approx(4 * np.sin(np.pi * order / (2 * links)) ** 2, rel=1e-6)


def test_constant_loads_are_part_of_the_prestate() -> None:
    """With half of the buckling load on already, the scaled load needs to reach the other half only."""
    m = kg.Model(dim=2)
    bottom, middle, top = m.add(kg.Node(0, 0), kg.Node(0, 1), kg.Node(0, 2))
    m.add(kg.Bar(bottom, middle, 1e6), kg.Bar(middle, top, 1e6), kg.TorsionSpring3(bottom, middle, top, 1.0))
    m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.NodalLoad(top, (0, -1), constant=True), kg.NodalLoad(top, (0, -0.5)))
    assert kg.Buckling(m, n=1).run().values[0] == pytest.approx(2.0, rel=1e-6)
    m.add(kg.NodalLoad(top, (0, -1.5), constant=True))
    with pytest.raises(kg.AnalysisError, match="constant loads alone"):
        kg.Buckling(m, n=1).run()


def test_prescribed_displacements_drive_as_well() -> None:
    """Shortened by its grip by lam: the force is lam EA / 2, so it buckles at lam = 4 k / (l EA)."""
    m = kg.Model(dim=2)
    bottom, middle, top = m.add(kg.Node(0, 0), kg.Node(0, 1), kg.Node(0, 2))
    m.add(kg.Bar(bottom, middle, 1e4), kg.Bar(middle, top, 1e4), kg.TorsionSpring3(bottom, middle, top, 1.0))
    m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.Prescribe(top, y=-1.0))
    assert kg.Buckling(m, n=1).run().values[0] == pytest.approx(4e-4, rel=1e-9)


def test_it_agrees_with_the_bifurcation_of_the_path() -> None:
    """A square plate squeezed in its plane: what the path finds is the linear buckling load, up to the strain there."""
    nodes, triangles = meshes.right_isosceles(6, 6, 1 / 6, "union jack")
    m = kg.Model.from_mesh(kg.TriMesh(nodes, triangles), 0.005, kg.Material(YOUNG, nu=NU))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="outer"), "z"), kg.Fix(bottom, "xy"), kg.Fix(top, "x"))
    m.add(kg.Prescribe(top, y=-3e-4))
    linear = kg.Buckling(m, n=2).run()
    path = kg.DisplacementControl(m, on_instability="follow").run()
    first = next(event for event in path.events if event.kind == "bifurcation")
    assert first.lam == pytest.approx(linear.values[0], rel=5e-3)
    assert first.mode is not None
    assert np.abs(first.mode) == pytest.approx(np.abs(linear[0].shape), abs=0.02)


def test_a_structure_that_cannot_buckle_says_so() -> None:
    m = kg.Model(dim=2)
    a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1))
    m.add(kg.Bar(a, b, 1.0), kg.Bar(c, b, 1.0), kg.Fix([a, c]), kg.NodalLoad(b, (1, 0)))
    with pytest.raises(kg.AnalysisError, match="other way round"):
        kg.Buckling(m, n=1).run()
    with pytest.raises(kg.ModelError, match="2 unknowns"):
        kg.Buckling(m, n=3).run()
    with pytest.raises(kg.ModelError, match="at least 1"):
        kg.Buckling(m, n=0)


def sheet_between_grips(edge: float, rung: str, shift: float, thickness: float = 0.01, nu: float = 0.3) -> kg.Model:
    """A strip 1 x 0.2 whose right end is moved along x, both ends free to contract and hinged."""
    mesh = kg.Sheet(box(0, 0, 1, 0.2)).mesh(edge)
    m = kg.Model.from_mesh(mesh, thickness, kg.Material(E=1e9, nu=nu), stiffness=rung)
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, "xz"), kg.Fix(left[0], "y"), kg.Fix(right, "z"), kg.Prescribe(right, x=shift))
    return m


@pytest.mark.parametrize("edge", [0.07, 0.04, 0.02])
def test_a_pulled_sheet_does_not_buckle(edge: float) -> None:
    """Uniform tension, exact on facets: a named error on any size, for as many factorisations as the counts need."""
    analysis = kg.Buckling(sheet_between_grips(edge, "facet", 0.01), n=2)
    with pytest.raises(kg.AnalysisError, match="nothing in it is compressed"):
        analysis.run()
    assert analysis.results is not None and analysis.results.stats["factorizations"] <= 4


@pytest.mark.parametrize("rung", ["paper", "plate", "facet"])
@pytest.mark.parametrize("edge", [0.04, 0.02])
def test_buckling_of_large_models_matches_the_counted_pivots(rung: str, edge: float) -> None:
    """Just below and above each load the tangent of the linear prestate has one negative pivot more."""
    analysis = kg.Buckling(sheet_between_grips(edge, rung, -0.01), n=3)
    values = analysis.run().values
    assert len(values) == 3 and analysis.results is not None
    assert analysis.results.stats["factorizations"] <= 6
    system = kg.System(analysis.model)
    rest = np.zeros_like(system.rest)
    stiffness = system.stiffness()
    q = factorize(stiffness).solve(-system.load_rate(rest, 0.0, system.stiffness_blocks(rest, 0.0)))
    for number, value in enumerate(values):
        for side, expected in ((1 - 1e-6, number), (1 + 1e-6, number + 1)):
            ahead = kg.Tangent(ahead=(rest, system.displacement(side * value * q, side * value)))
            assert factorize(system.matrix(system.stiffness_blocks(rest, 0.0, ahead))).negative == expected


def test_a_thin_sheet_under_tension_wrinkles_where_its_grips_hold_it() -> None:
    """Clamped ends squeeze the sheet across the pull: loads far inside a spectrum of tension; they go with t^2."""
    loads = []
    for thickness in (1e-4, 1e-5):
        mesh = kg.Sheet(box(0, 0, 1, 0.4)).mesh(0.03)
        m = kg.Model.from_mesh(mesh, thickness, kg.Material(E=1e9, nu=0.49), stiffness="facet")
        right = m.select(boundary="right")
        m.add(kg.Fix(m.select(boundary="left")), kg.Fix(right, "yz"), kg.Prescribe(right, x=0.01))
        loads.append(kg.Buckling(m, n=3).run().values / thickness**2)
    assert loads[0] == pytest.approx(loads[1], rel=1e-6)


# Buckling coefficients N b^2 / (pi^2 D) of square plates, Timoshenko and Gere, Theory of Elastic Stability
PLATES = {("supported", "pressed"): 4.0, ("clamped", "pressed"): 10.07, ("supported", "sheared"): 9.34}


@pytest.mark.parametrize("case", PLATES, ids="-".join)
@pytest.mark.parametrize("rung", ["plate", "facet"])
def test_square_plates(case: tuple[str, str], rung: str) -> None:
    edge, load = case
    t, young, nu = 0.01, 1e6, 0.3
    m = kg.Model.from_mesh(kg.Sheet(box(0, 0, 1, 1)).mesh(1.15 / 16), t, kg.Material(young, nu), stiffness=rung)
    m.add(kg.Fix(m.select(boundary="outer"), "z", clamp=edge == "clamped"))
    pushes = {"left": (1, 0), "right": (-1, 0)}
    if load == "sheared":
        pushes = {"left": (0, -1), "right": (0, 1), "bottom": (-1, 0), "top": (1, 0)}
    for side, (fx, fy) in pushes.items():
        along = "y" if side in ("left", "right") else "x"
        nodes = sorted(m.select(boundary=side), key=lambda node, a=along: getattr(node, a))
        place = np.array([getattr(node, along) for node in nodes])
        share = np.zeros(len(nodes))
        share[1:] += np.diff(place) / 2
        share[:-1] += np.diff(place) / 2
        m.add(*(kg.NodalLoad(node, (fx * s, fy * s, 0)) for node, s in zip(nodes, share.tolist())))
    corners = [min(m.nodes, key=lambda node, x=x: abs(node.x - x) + abs(node.y)) for x in (0, 1)]
    m.add(kg.Fix(corners[0], "xy"), kg.Fix(corners[1], "y"))
    rigidity = young * t**3 / 12 / (1 - nu**2)
    found = kg.Buckling(m, n=1).run().values[0] / (np.pi**2 * rigidity)
    assert found == pytest.approx(PLATES[case], rel=0.05)
