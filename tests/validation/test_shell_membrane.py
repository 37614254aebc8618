"""Tension and in-plane bending of shell facets on every pattern of mesh."""

import numpy as np
import pytest
from patterns import PATTERNS, line_load, on, rectangle

import kirigami as kg
from kirigami.linalg import factorize

E, NU = 3.0, 0.3
STATES = {"along": (1, -NU, 0), "across": (-NU, 1, 0), "biaxial": (1, 1, 0), "two to one": (1, 0.5, 0),
          "uniaxial strain": (1, 0, 0), "with shear": (1, 0.9, 0.8)}  # fmt: skip
SLENDER = (1.0, 1 / 8, 1 / 40, 1 / 1000)  # thickness over edge


def stretched(pattern, thickness, strain):
    """System of a unit square with its sides held out of plane, and the rows of a uniform Green strain."""
    model = kg.Model.from_mesh(rectangle(pattern, 1, 1, 4), thickness, kg.Material(E, NU), stiffness="shell")
    x, y = model.positions()[:, :2].T
    sides = np.unique(np.concatenate([on(x, 0), on(x, 1)]))
    model.add(kg.Fix([model.nodes[k] for k in sides], "z"))
    model.add(kg.Fix(model.nodes[0], "xy"), kg.Fix(model.nodes[int(np.argmax(x + 1e-3 * (y == 0)))], "y"))
    system = kg.System(model)
    green = np.array([[strain[0], 0.5 * strain[2]], [0.5 * strain[2], strain[1]]])
    values, axes = np.linalg.eigh(np.eye(2) + 2 * green)
    stretch = axes @ np.diag(np.sqrt(values)) @ axes.T
    u = np.zeros_like(system.rest)
    u[: len(x), :2] = np.stack([x, y], axis=1) @ (stretch - np.eye(2)).T
    return system, u, stretch, green


def edge_forces(system, traction):
    """Forces (rows, 2) of a first Piola-Kirchhoff force per length (2, 2) on the edges of the boundary."""
    edges = system.edges
    facet, local = np.nonzero((np.bincount(edges.edge.ravel()) == 1)[edges.edge])
    edge = edges.edge[facet, local]
    start, end = edges.triangles[facet, local], edges.triangles[facet, (local + 1) % 3]
    along = system.rest[end, :2] - system.rest[start, :2]
    pull = np.stack([along[:, 1], -along[:, 0]], axis=1) @ traction.T
    forces = np.zeros((len(system.rest), 2))
    np.add.at(forces, start, 0.5 * pull)
    np.add.at(forces, end, 0.5 * pull)
    forces[edges.middle[edge]] = 2 / 3 * pull
    return forces


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_tension_is_exact_and_never_buckles(pattern, state):
    """A flat sheet under non-negative membrane force is in equilibrium, with the force of the strain, and stable."""
    for ratio in SLENDER:
        for size in (0.01, 0.1):
            thickness = ratio / 4
            strain = size * np.array(STATES[state])
            system, u, stretch, green = stretched(pattern, thickness, strain)
            trace = np.trace(green)
            stress = E / (1 - NU**2) * ((1 - NU) * green + NU * trace * np.eye(2))
            assert np.linalg.eigvalsh(stress).min() > -1e-12
            forces = system.forces(u, 1.0)[0]
            expected = edge_forces(system, thickness * stretch @ stress)
            assert np.abs(forces[:, :2] - expected).max() < 1e-9 * thickness * E * size
            assert np.abs(forces[:, 2]).max() < 1e-12 * thickness * E * size
            assert factorize(system.matrix(system.stiffness_blocks(u, 1.0))).negative == 0


@pytest.mark.parametrize("pattern", PATTERNS)
def test_shear_is_exact_while_the_sheet_is_kept_flat(pattern):
    system, u, stretch, green = stretched(pattern, 0.01, (0, 0, 0.1))
    stress = E / (1 + NU) * green + E * NU / (1 - NU**2) * np.trace(green) * np.eye(2)
    forces = system.forces(u, 1.0)[0]
    assert np.abs(forces[:, :2] - edge_forces(system, 0.01 * stretch @ stress)).max() < 1e-9 * 0.01 * E * 0.1
    in_plane = np.flatnonzero(system.unknown.reshape(-1, 3)[:, :2].ravel() >= 0)
    blocks = system.stiffness(u, 1.0, constrained=False).tocsr()
    at = (3 * (in_plane // 2) + in_plane % 2)[np.isin(in_plane // 2, np.r_[: system.points, system.edges.middle])]
    assert factorize(blocks[at][:, at].tocsc()).negative == 0  # kept flat it is stable


@pytest.mark.parametrize("ratio", [1 / 2, 1 / 8, 1 / 40, 1 / 500])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_tension_stiffens_a_strip(pattern, ratio):
    """End deflection of a cantilever strip pulled by T = E t e (nu = 0): (L - tanh(k L) / k) / T, k^2 = T / D."""
    length, width, strain = 4.0, 1.0, 0.01
    thickness = ratio / 4
    model = kg.Model.from_mesh(rectangle(pattern, length, width, 4), thickness, kg.Material(1.0, 0.0),
                               stiffness="shell")  # fmt: skip
    x, y, _ = model.positions().T
    left, right = on(x, 0), on(x, length)
    model.add(kg.Fix([model.nodes[k] for k in left], "z", clamp=True), kg.Fix(model.nodes, "xy"))
    system = kg.System(model)
    u = np.zeros_like(system.rest)
    u[: len(x), 0] = (np.sqrt(1 + 2 * strain) - 1) * x
    force, load = np.zeros_like(u), line_load(system, right)
    force[:, 2] = load
    matrix = system.matrix(system.stiffness_blocks(u, 0.0))
    deflection = system.displacement(factorize(matrix).solve(system.reduce(force)), 0.0)
    found = float(load @ deflection[:, 2])
    tension, rigidity = thickness * strain, thickness**3 / 12
    k = np.sqrt(tension / rigidity)
    assert found == pytest.approx((length - np.tanh(k * length) / k) / tension, rel=0.01)


def ligament(pattern, across, rung="shell"):
    """End deflection over beam theory of a ligament five times as long as wide, bent in its plane by an end force."""
    length, width, thickness = 5.0, 1.0, 0.1
    model = kg.Model.from_mesh(rectangle(pattern, length, width, across), thickness, kg.Material(E, NU),
                               stiffness=rung)  # fmt: skip
    x, y, _ = model.positions().T
    left, right = on(x, 0), on(x, length)
    model.add(kg.Fix([model.nodes[k] for k in left], "xy"), kg.Fix(model.nodes, "z"))
    system = kg.System(model)
    force, load = np.zeros_like(system.rest), line_load(system, right)
    force[:, 1] = load
    solution = factorize(system.stiffness()).solve(system.reduce(force))
    deflection = float(load @ system.displacement(solution, 0.0)[:, 1])
    shear = E / (2 * (1 + NU))
    beam = length**3 / (3 * E * thickness * width**3 / 12) + 1.2 * length / (shear * thickness * width)
    return deflection / beam


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_ligament_bends_in_its_plane(pattern):
    """At least 0.97 of the deflection with two facets across; the converged value of this case is 0.996."""
    two, four = ligament(pattern, 2), ligament(pattern, 4)
    assert two > 0.97
    assert abs(four - 0.996) < 0.004
