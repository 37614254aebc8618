"""Strips and chains that bend: cantilevers, columns and the elastica, against beam theory in the mesh's own units.

A mesh of bars and hinges has its own rigidities (see test_networks): an equilateral strip with free sides has
B_beam = 8/9 c E t^3 W, a leg-aligned right-angled one whose columns stay level has D_cyl = c E t^3 exactly.
"""

from __future__ import annotations

from itertools import pairwise

import meshes
import numpy as np
import pytest
from meshes import Floats
from scipy.optimize import brentq
from scipy.sparse import csc_matrix
from scipy.special import ellipe, ellipk

import kirigami as kg

# end slope [deg]: load / Euler load, shortening / L, mid deflection / L of the pinned elastica (Timoshenko and Gere)
ELASTICA = {
    20: (1.015397, 0.030269, 0.109707),
    40: (1.063663, 0.118796, 0.211120),
    60: (1.151720, 0.258980, 0.296604),
    80: (1.293889, 0.440604, 0.359749),
    100: (1.518389, 0.651011, 0.395770),
    120: (1.884801, 0.876840, 0.401585),
    140: (2.542258, 1.106923, 0.375194),
}

# P L^2 / EI: tip slope, x / L, y / L of the cantilever under a dead transverse tip load (Bisshopp and Drucker 1945)
CANTILEVER = {
    0.2: (0.099636, 0.997353, 0.066364),
    1: (0.461352, 0.943567, 0.301721),
    2: (0.781750, 0.839358, 0.493457),
    5: (1.215368, 0.612372, 0.713792),
    10: (1.430286, 0.445004, 0.810609),
}


@pytest.mark.parametrize("slope", ELASTICA)
def test_elastica_table(slope: int) -> None:
    """The table itself from its elliptic integrals: P / P_cr = (2 K / pi)^2, 2 - 2 E / K, sin(slope / 2) / K."""
    modulus = np.sin(np.radians(slope) / 2)
    first, second = ellipk(modulus**2), ellipe(modulus**2)
    exact = ((2 * first / np.pi) ** 2, 2 - 2 * second / first, modulus / first)
    assert ELASTICA[slope] == pytest.approx(exact, abs=1e-6)


# ------------------------------------------------------------------------------------------- plane Hencky chains


def _cantilever_chain(links: int, axial: float) -> tuple[kg.Model, tuple[kg.Node, ...]]:
    """Unit length along x, EI = 1. The first link is short and held, so its spring is the half cell at the wall."""
    length = 1.0 / links
    x = np.concatenate([[-length / 2], length * np.arange(links + 1)])
    model = kg.Model(dim=2)
    nodes = model.add(*(kg.Node(float(place), 0.0) for place in x))
    model.add(*(kg.Bar(a, b, axial) for a, b in pairwise(nodes)))
    for n, (a, b, c) in enumerate(zip(nodes, nodes[1:], nodes[2:])):
        model.add(kg.TorsionSpring3(a, b, c, (2.0 if n == 0 else 1.0) / length))
    model.add(kg.Fix(nodes[:2]))
    return model, nodes


def test_chain_cantilever() -> None:
    """Dead tip load on 100 links: tip within 0.2 % of the elastica from small to very large deflection."""
    links = 100
    model, nodes = _cantilever_chain(links, axial=1e6)
    model.add(kg.NodalLoad(nodes[-1], (0.0, 10.0)))
    targets = [q / 10 for q in CANTILEVER]
    result = kg.LoadControl(model, to=1.0, targets=targets, step=0.02).run()
    for load, (slope, x, y) in CANTILEVER.items():
        at = int(np.argmin(np.abs(result.lam - load / 10)))
        assert result.lam[at] == pytest.approx(load / 10, abs=1e-12)
        tip, before = (result.position(node)[at, :2] for node in (nodes[-1], nodes[-2]))
        assert tip == pytest.approx((x, y), abs=2e-3)
        assert np.arctan2(*(tip - before)[::-1]) == pytest.approx(slope, abs=2e-3)


def test_chain_converges_at_second_order() -> None:
    """Halving the links quarters the error of the tip: the wall spring is placed right, and no term is missing."""
    load, (_, _, exact) = 2.0, CANTILEVER[2]
    errors = []
    for links in (10, 20):
        model, nodes = _cantilever_chain(links, axial=1e7)
        model.add(kg.NodalLoad(nodes[-1], (0.0, load)))
        result = kg.LoadControl(model, to=1.0, step=0.1).run()
        errors.append(abs(result.u[-1, -1, 1] - exact))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)


def test_end_couple_rolls_a_chain_into_a_circle() -> None:
    """A couple at the free end: constant curvature M / EI, up to 170 degrees of turn.

    Two opposite dead forces on the last link make the couple F l sin(direction - turn).
    """
    links, direction = 40, np.radians(178.0)
    model, nodes = _cantilever_chain(links, axial=1e6)
    force = 150.0 * np.array([np.cos(direction), np.sin(direction)])
    model.add(kg.NodalLoad(nodes[-1], force), kg.NodalLoad(nodes[-2], -force))
    result = kg.LoadControl(model, to=1.0, step=0.01).run()
    chain = result.position(nodes[1:])[-1, :, :2]
    link = np.diff(chain, axis=0)
    turn = np.unwrap(np.arctan2(link[:, 1], link[:, 0]))
    couple = result.lam[-1] * 150.0 / links * np.sin(direction - turn[-1])
    assert turn[-1] > np.radians(120)
    assert np.diff(turn)[:-1] == pytest.approx(couple / links, rel=5e-3)  # M / EI times the cell
    radius = 1.0 / couple
    centre = np.array([0.0, radius])
    assert np.linalg.norm(chain - centre, axis=1) == pytest.approx(radius, rel=5e-3)


# ------------------------------------------------------------------------------------------------- sheet strips


def test_end_couple_rolls_a_strip_into_a_circle() -> None:
    """The same on a sheet with level columns: every line of hinges turns by M l / (D W), D = c E t^3 of the mesh."""
    columns, rows, thickness, constant = 24, 2, 0.1, 0.09
    nodes, triangles = meshes.right_isosceles(columns, rows)
    model, points = meshes.sheet(nodes, triangles, 1.0, thickness, bending=constant)
    groups = [[p for p in points if abs(p.x - n) < 1e-9] for n in range(columns + 1)]
    model.add(kg.Fix(groups[0] + groups[1], "xz"), kg.Fix([p for p in points if p.y < 1e-9], "y"))
    model.add(*(kg.Tie(group[1:], group[0], "xz") for group in groups[2:]))
    rigidity, direction = constant * thickness**3 * rows, np.radians(178.0)
    size = 3.75 * rigidity / columns
    force = size * np.array([np.cos(direction), 0.0, np.sin(direction)])
    model.add(kg.NodalLoad(groups[-1][0], force), kg.NodalLoad(groups[-2][0], -force))
    result = kg.LoadControl(model, to=1.0, step=0.01).run()
    line = result.position([group[0] for group in groups])[-1][:, [0, 2]]
    link = np.diff(line, axis=0)
    turn = np.unwrap(np.arctan2(link[:, 1], link[:, 0]))
    couple = size * np.linalg.norm(link[-1]) * np.sin(direction - turn[-1])
    assert turn[-1] > np.radians(120)
    assert np.diff(turn) == pytest.approx(np.full(columns - 1, couple / rigidity), rel=1e-3)
    radius, wall = rigidity / couple, 0.5  # the two held columns clamp the strip half-way between them
    centre = np.array([wall, radius])
    assert np.linalg.norm(line[1:] - centre, axis=1) == pytest.approx(radius, rel=5e-3)


def test_ring_carries_the_energy_of_its_curvature() -> None:
    """A flat strip rolled into a closed prism: energy D W L (2 pi / L)^2 / 2 exactly, whatever the number of cells.

    This is the end moment M = 2 pi D W / L that closes the strip, and it holds to any angle: the law is linear in it.
    """
    columns, rows, edge = 12, 3, 0.5
    nodes, triangles = meshes.right_isosceles(columns, rows, edge)
    modulus, thickness, constant = 2.0, 0.1, 0.09
    model, _ = meshes.sheet(nodes, triangles, modulus, thickness, bending=constant)
    step = 2 * np.pi / columns
    column = np.rint(nodes[:, 0] / edge).astype(int)
    radius = edge / (2 * np.sin(step / 2))
    rolled = np.column_stack([radius * np.sin(step * column), nodes[:, 1], radius * (1 - np.cos(step * column))])
    flat = np.column_stack([nodes, np.zeros(len(nodes))])
    system = kg.System(model)
    energy = {kernel.name: float(kernel.evaluate(rolled).energy.sum()) for kernel in system.kernels}
    width, inner = rows * edge, (columns - 1) * edge  # an open strip has one hinge line less than cells
    rigidity = constant * modulus * thickness**3 * width
    assert energy["hinges"] == pytest.approx(rigidity * inner * (step / edge) ** 2 / 2, rel=1e-12)
    # Every cell keeps its shape, so that bars and gradients of bars stay at zero.
    assert energy["bars"] < 1e-25 * modulus
    assert np.abs((rolled - flat)[0]).max() < 1e-15


def _level_columns(nodes: Floats, edge: float) -> csc_matrix:
    """Deflections of all nodes from those of the columns (x constant): a strip that bends as a cylinder only."""
    column = np.rint(nodes[:, 0] / edge).astype(int)
    return csc_matrix((np.ones(len(nodes)), (np.arange(len(nodes)), column)))


# supports: held columns as (first two, last two), critical load over pi^2 D W / L^2, and the half cells by which a
# clamp of two held columns lies behind the inner one
COLUMNS = {
    "pinned": ((0,), (-1,), 1.0, 0.0),
    "clamped": ((0, 1), (-1, -2), 4.0, -1.0),
    "cantilever": ((0, 1), (), 0.25, -0.5),
}


@pytest.mark.parametrize("supports", COLUMNS)
def test_euler_load_of_a_strip_that_bends_as_a_cylinder(supports: str) -> None:
    """pi^2 D W / L^2, 4 and 1/4 times that, within 2 % at 20 cells along; D = c E t^3."""
    first, last, factor, behind = COLUMNS[supports]
    columns, rows, edge, thickness, constant = 22, 2, 1.0, 0.02, 0.09
    nodes, triangles = meshes.right_isosceles(columns, rows, edge)
    model, _ = meshes.sheet(nodes, triangles, 1.0, thickness, bending=constant)
    level = _level_columns(nodes, edge)
    free = np.setdiff1d(np.arange(columns + 1), np.array([*first, *last]) % (columns + 1))
    # The inner held columns of a clamp are 1 and columns - 1.
    length = columns - (len(first) - 1) - max(len(last) - 1, 0) - behind
    critical = _critical_strain(model, nodes, level[:, free])
    width = rows * edge
    euler = np.pi**2 * constant * thickness**3 * width / length**2
    assert critical * thickness * width == pytest.approx(factor * euler, rel=0.02)


def _critical_strain(model: kg.Model, nodes: Floats, shapes: csc_matrix) -> float:
    """Uniform shortening along x, sides free, at which the deflections spanned by `shapes` lose stiffness.

    A right-angled mesh with one diagonal does not widen but shears by gamma_xy = -eps_x when its ends are loaded; then
    only the bars along x carry force, E t W times the strain in all.
    """
    system = kg.System(model)

    def lowest(strain: float) -> float:
        shortened = np.zeros((len(nodes), 3))
        shortened[:, 0] = -strain * (nodes[:, 0] - nodes[:, 1])
        stiffness = system.stiffness(shortened, constrained=False)[2::3, 2::3]
        return float(np.linalg.eigvalsh((shapes.T @ stiffness @ shapes).toarray())[0])

    return float(brentq(lowest, 1e-9, 1e-3, rtol=1e-6))


@pytest.mark.parametrize("rows", [1, 2, 4])
def test_euler_load_of_a_pinned_free_sided_strip(rows: int) -> None:
    """pi^2 B W / L^2 with B = 8/9 c E t^3, the beam rigidity of the equilateral mesh, within 2 % at 20 cells."""
    columns, thickness, constant = 20, 0.02, 0.09
    nodes, triangles = meshes.equilateral_strip(columns, rows)
    model, points = meshes.sheet(nodes, triangles, 1.0, thickness, bending=constant)
    left = [p for p in points if p.x < 1e-9]
    right = [p for p in points if p.x > columns - 1e-9]
    model.add(kg.Fix(left, "xz"), kg.Fix(right, "z"), kg.Fix(left[0], "y"), kg.Prescribe(right, x=-1e-6 * columns))
    pushed = kg.LinearStatic(model).run()
    system = kg.System(model)
    load = -pushed.reaction(right, "x")[-1]
    free = np.array([n for n, p in enumerate(points) if 1e-9 < p.x < columns - 1e-9])

    def lowest(factor: float) -> float:
        stiffness = system.stiffness(factor * pushed[-1].u, constrained=False)[2::3, 2::3]
        return float(np.linalg.eigvalsh(stiffness[free][:, free].toarray())[0])

    width = rows * meshes.SIXTY_DEGREES
    euler = np.pi**2 * 8 / 9 * constant * thickness**3 * width / columns**2
    assert load * brentq(lowest, 1e-3, 100.0, rtol=1e-6) == pytest.approx(euler, rel=0.02)


@pytest.mark.parametrize("angle", [40, 80])
def test_postbuckled_strip_is_the_elastica(angle: int) -> None:
    """A pinned narrow equilateral strip pushed far beyond buckling: shape within 1 %, force within 5 %."""
    ratio, shortening, deflection = ELASTICA[angle]
    columns, rows, thickness, constant = 24, 1, 0.1, 0.09
    nodes, triangles = meshes.equilateral_strip(columns, rows)
    model, points = meshes.sheet(nodes, triangles, 1.0, thickness, bending=constant)
    left = [p for p in points if p.x < 1e-9]
    right = [p for p in points if p.x > columns - 1e-9]
    middle = [n for n, p in enumerate(points) if abs(p.x - columns / 2) < 0.6]
    model.perturb(np.sin(np.pi * nodes[:, 0] / columns), amplitude=2e-3 * columns)
    model.add(kg.Fix(left, "xz"), kg.Fix(right, "z"), kg.Fix([left[0], right[0]], "y"))
    model.add(kg.Prescribe(right, x=-shortening * columns))
    result = kg.DisplacementControl(model, to=1.0, step=0.02).run()
    width = rows * meshes.SIXTY_DEGREES
    euler = np.pi**2 * 8 / 9 * constant * thickness**3 * width / columns**2
    assert -result.reaction(right, "x")[-1] == pytest.approx(ratio * euler, rel=0.05)
    assert result.position(points)[-1, middle, 2].max() == pytest.approx(deflection * columns, rel=0.01)
    # The supports that hold nothing carry nothing, and both ends push alike.
    assert result.reaction(left, "x") == pytest.approx(-result.reaction(right, "x"), abs=1e-8 * euler)
    assert result.stable[-1]
    # Work of the driven end = energy stored.
    force, travel = result.reaction(right, "x"), result.u[:, points.index(right[0]), 0]
    work = np.sum((force[1:] + force[:-1]) / 2 * np.diff(travel))
    assert sum(energy[-1] for energy in result.energy.values()) == pytest.approx(work, rel=0.02)


def test_mirrored_imperfection_mirrors_the_solution() -> None:
    """z -> -z: the deflection changes sign, the force does not (1e-8)."""
    columns, shortening = 10, 0.05
    nodes, triangles = meshes.equilateral_strip(columns, 2)
    forces, shapes = [], []
    for sign in (1.0, -1.0):
        model, points = meshes.sheet(nodes, triangles, 1.0, 0.1, bending=0.09)
        left = [p for p in points if p.x < 1e-9]
        right = [p for p in points if p.x > columns - 1e-9]
        model.perturb(sign * 0.05 * np.sin(np.pi * nodes[:, 0] / columns) * (1 + 0.3 * nodes[:, 1]))
        model.add(kg.Fix(left), kg.Fix(right, "yz"), kg.Prescribe(right, x=-shortening * columns))
        result = kg.DisplacementControl(model, to=1.0, step=0.1, tol=1e-10).run()
        forces.append(result.reaction(right, "x"))
        shapes.append(result.u[-1] * [1, 1, sign])
    assert forces[0] == pytest.approx(forces[1], rel=1e-8, abs=1e-8 * np.abs(forces[0]).max())
    assert shapes[0] == pytest.approx(shapes[1], abs=1e-8 * np.abs(shapes[0]).max())
    assert np.abs(shapes[0][:, 2]).max() > 0.05 * columns


def test_halving_steps_keeps_the_force() -> None:
    """The end state does not depend on the steps that led to it: force to 1e-6."""
    columns = 10
    nodes, triangles = meshes.equilateral_strip(columns, 2)
    forces = []
    for step in (0.1, 0.05):
        model, points = meshes.sheet(nodes, triangles, 1.0, 0.1, bending=0.09)
        left = [p for p in points if p.x < 1e-9]
        right = [p for p in points if p.x > columns - 1e-9]
        model.perturb(0.05 * np.sin(np.pi * nodes[:, 0] / columns))
        model.add(kg.Fix(left), kg.Fix(right, "yz"), kg.Prescribe(right, x=-0.5))
        result = kg.DisplacementControl(model, to=1.0, step=step).run()
        forces.append(result.reaction(right, "x")[-1])
    assert forces[0] == pytest.approx(forces[1], rel=1e-6)


def test_strip_cantilever_with_clamp() -> None:
    """A clamped sheet strip under a dead tip load: the tip of the elastica within 1 %.

    Columns are tied level, so the strip bends as a cylinder with D = c E t^3 and the clamp is the only unknown.
    """
    columns, rows, load = 30, 2, 2.0
    _, x, y = CANTILEVER[2]
    nodes, triangles = meshes.right_isosceles(columns, rows)
    thickness = 0.1
    mesh = kg.TriMesh(nodes, triangles)
    model = kg.Model.from_mesh(mesh, thickness, kg.Material(1.0, nu=0.0), stiffness="plate")
    rigidity = thickness**3 / 12 * rows
    columns_of_nodes = [[p for p in model.nodes if abs(p.x - n) < 1e-9] for n in range(columns + 1)]
    model.add(kg.Fix(columns_of_nodes[0], clamp=True))
    for group in columns_of_nodes[1:]:
        model.add(kg.Tie(group[1:], group[0], "xz"))
    tip = columns_of_nodes[-1][0]
    model.add(kg.NodalLoad(tip, (0, 0, load * rigidity / columns**2)))
    result = kg.LoadControl(model, to=1.0, step=0.1).run()
    assert result.position(tip)[-1, [0, 2]] == pytest.approx((x * columns, y * columns), rel=0.01)


def test_clamped_edge_is_half_a_cell_of_plate() -> None:
    """Small deflection of the clamped strip, node by node: exactly a chain with springs D W / l, and 2 D W / l at the
    wall (an edge hinged to its mirror image: angle 2 phi, half the energy)."""
    columns, rows, thickness, force = 5, 3, 0.1, 1e-7
    nodes, triangles = meshes.right_isosceles(columns, rows)
    model = kg.Model.from_mesh(kg.TriMesh(nodes, triangles), thickness, kg.Material(1.0, nu=0.0), stiffness="plate")
    groups = [[p for p in model.nodes if abs(p.x - n) < 1e-9] for n in range(columns + 1)]
    model.add(kg.Fix(groups[0], clamp=True))
    for group in groups[1:]:
        model.add(kg.Tie(group[1:], group[0], "xyz"))
    model.add(kg.NodalLoad(groups[-1][0], (0, 0, force)))
    found = [kg.LinearStatic(model).run()[-1].u[model.nodes.index(group[0]), 2] for group in groups]
    spring = thickness**3 / 12 * rows  # D W / l with l = 1
    moment = force * (columns - np.arange(columns))
    turn = moment / (spring * np.where(np.arange(columns) == 0, 2.0, 1.0))
    assert found == pytest.approx(np.concatenate([[0.0], np.cumsum(np.cumsum(turn))]), rel=1e-9)
