"""Periodic cells: effective stiffness against closed forms, mean stress as a derivative, bad input."""

from __future__ import annotations

import numpy as np
import pytest

import kirigami as kg
from kirigami import tilings
from kirigami.lattice.periodic import PeriodicCell


def _triangular(dim: int, cells: int = 3, jitter: float = 0.0) -> tuple[kg.Model, np.ndarray]:
    """Periodic equilateral network of unit edge and spring constant 1: nodes on both borders, border bars once."""
    lattice = cells * np.array([[1.0, 0.0], [0.5, np.sqrt(3) / 2]])
    model = kg.Model(dim=dim)
    random = np.random.default_rng(3)
    offset = jitter * random.uniform(-1, 1, (cells, cells, 2))
    grid = {}
    for i in range(cells + 1):
        for j in range(cells + 1):
            x, y = np.array([i + j / 2, j * np.sqrt(3) / 2]) + offset[i % cells, j % cells]
            grid[i, j] = model.add(kg.Node(x, y))
    for i in range(cells):
        for j in range(cells):
            for a, b in (((i, j), (i + 1, j)), ((i, j), (i, j + 1)), ((i + 1, j), (i, j + 1))):
                length = np.hypot(grid[a].x - grid[b].x, grid[a].y - grid[b].y)
                model.add(kg.Bar(grid[a], grid[b], EA=float(length)))
    return model, lattice


def test_equilateral_network() -> None:
    """Springs k on an equilateral network: E = 2 k / sqrt3, nu = 1/3, G = sqrt3 k / 4 (Seung and Nelson 1988)."""
    model, lattice = _triangular(2)
    stiffness = PeriodicCell(model, lattice).stiffness()
    young, poisson = 2 / np.sqrt(3), 1 / 3
    plane = young / (1 - poisson**2) * np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
    assert stiffness == pytest.approx(plane, abs=1e-12)


@pytest.mark.parametrize("angle", [0.0, 0.6, 1.2])
def test_modulus_of_rotating_squares(angle: float) -> None:
    """E = 8 k / (l^2 (1 - sin theta0)), nu = -1 (Grima and Evans 2000), bars 1e6 times stiffer than joints."""
    cell = tilings.rotating_squares(angle, side=1.5)
    model = cell.model(EA=1e7, stiffness=2.0)
    compliance = np.linalg.inv(PeriodicCell(model, cell.lattice, cell.images).stiffness())
    assert 1 / compliance[0, 0] == pytest.approx(8 * 2.0 / (1.5**2 * (1 - np.sin(angle))), rel=1e-3)
    assert 1 / compliance[1, 1] == pytest.approx(1 / compliance[0, 0], rel=1e-6)
    assert -compliance[0, 1] / compliance[0, 0] == pytest.approx(-1.0, abs=1e-3)


@pytest.mark.parametrize("start, end", [(1.2, 1.9), (1.75, 2.4), (2.0, 1.1)])
def test_uniform_twist_costs_only_spring_energy(start: float, end: float) -> None:
    """From one twist to another: bars stay free, and each joint takes k (change of angle)^2 / 2, all turns alike."""
    joint = 0.7
    cell, twisted = tilings.kagome(start), tilings.kagome(end)
    energy = kg.System(_tied(cell, joint)).energies(twisted.vertices - cell.vertices)
    assert energy["springs"] == pytest.approx(3 * 0.5 * joint * (end - start) ** 2, rel=1e-10)
    assert energy["bars"] < 1e-24


def _tied(cell: tilings.Tiling, joint: float) -> kg.Model:
    model = cell.model(EA=1.0, stiffness=joint)
    PeriodicCell(model, cell.lattice, cell.images).impose(np.zeros((2, 2)))
    return model


def test_cell_driven_along_its_twist() -> None:
    """Rotating squares, dilated by 15 %: energy 4 k (phi - phi0)^2 per square, equal pressure along x and y."""
    cell = tilings.rotating_squares(0.4)
    model = cell.model(EA=1e5, stiffness=1.0)
    periodic = PeriodicCell(model, cell.lattice, cell.images)
    periodic.impose(0.15 * np.eye(2))
    result = kg.DisplacementControl(model, step=0.05).run()
    start = 0.2
    spacing = (1 + 0.15 * result.lam) * (np.cos(start) + np.sin(start))
    phi = np.pi / 4 - np.arccos(spacing / np.sqrt(2))
    assert result.energy["springs"] == pytest.approx(4 * 4 * (phi - start) ** 2, rel=1e-3)
    stress = periodic.mean_stress(result)
    # Work of both: (sxx + syy) times the growth of the spacing, per square.
    work = 8 * (phi - start) / (np.cos(phi) - np.sin(phi)) / (np.cos(start) + np.sin(start))
    assert stress[:, 0, 0] + stress[:, 1, 1] == pytest.approx(work, rel=2e-3)
    assert stress[:, 0, 0] == pytest.approx(stress[:, 1, 1], rel=1e-6)
    assert np.abs(stress[:, 0, 1]).max() < 1e-6


def test_mean_stress_is_the_derivative_of_the_energy() -> None:
    model, lattice = _triangular(2, jitter=0.15)
    cell = PeriodicCell(model, lattice)
    gradient = np.array([[0.03, 0.02], [-0.01, -0.02]])
    cell.impose(gradient)
    result = kg.DisplacementControl(model, targets=[0.499, 0.5, 0.501]).run()
    stress = cell.mean_stress(result)
    energy = sum(result.energy.values())
    at = [int(np.argmin(np.abs(result.lam - target))) for target in (0.499, 0.5, 0.501)]
    slope = (energy[at[2]] - energy[at[0]]) / 0.002 / cell.measure
    assert slope == pytest.approx((stress[at[1]] * gradient).sum(), rel=1e-5)


def test_small_mean_stress_is_stiffness_times_strain() -> None:
    model, lattice = _triangular(2, jitter=0.15)
    strain = np.array([1e-6, -2e-6, 3e-6])
    expected = PeriodicCell(model, lattice).stiffness() @ strain
    cell = PeriodicCell(model, lattice)
    cell.impose(strain)
    stress = cell.mean_stress(kg.LinearStatic(model).run())[-1]
    assert [stress[0, 0], stress[1, 1], stress[0, 1]] == pytest.approx(expected.tolist(), rel=1e-9)
    assert stress[0, 1] == pytest.approx(stress[1, 0], rel=1e-9)


def test_sheet_cell_in_space_has_the_plane_stiffness() -> None:
    """Bars and hinges of a flat triangulated cell in 3D: the same in-plane matrix, whatever happens in z."""
    grid = np.array([[i + j / 2, j * np.sqrt(3) / 2] for j in range(4) for i in range(4)])
    corners = [4 * j + i for j in range(3) for i in range(3)]
    triangles = [t for a in corners for t in ((a, a + 1, a + 4), (a + 1, a + 5, a + 4))]
    found = []
    for dim in (2, 3):
        model = kg.Model.from_mesh(kg.TriMesh(grid, triangles), thickness=0.01, material=kg.Material(E=100.0), dim=dim)
        found.append(PeriodicCell(model, 3 * np.array([[1.0, 0.0], [0.5, np.sqrt(3) / 2]])).stiffness())
    assert found[1] == pytest.approx(found[0], rel=1e-9)


def test_cell_in_space() -> None:
    """Cubic network with body diagonals: one point in the cell, so the stiffness is a sum over its bars."""
    model = kg.Model(dim=3)
    corner = {(i, j, k): model.add(kg.Node(i, j, k)) for i in (0, 1) for j in (0, 1) for k in (0, 1)}
    for end in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
        model.add(kg.Bar(corner[0, 0, 0], corner[end], EA=2.0))
    diagonals = (((0, 0, 0), (1, 1, 1)), ((1, 0, 0), (0, 1, 1)), ((0, 1, 0), (1, 0, 1)), ((0, 0, 1), (1, 1, 0)))
    for start, end in diagonals:
        model.add(kg.Bar(corner[start], corner[end], EA=1.5))
    stiffness = PeriodicCell(model, np.eye(3)).stiffness()
    # One point in the cell, so the strain is affine: C_ab = sum of EA L N_a N_b, N = (nx^2, ..., 2 ny nz / 2 ...).
    expected = np.zeros((6, 6))
    for EA, vector in [(2.0, e) for e in np.eye(3)] + [(1.5, np.subtract(b, a)) for a, b in diagonals]:
        length = np.linalg.norm(vector)
        x, y, z = vector / length
        rows = np.array([x * x, y * y, z * z, y * z, x * z, x * y])
        expected += EA * length * np.outer(rows, rows)
    assert stiffness == pytest.approx(expected, abs=1e-12)


def test_bad_cells() -> None:
    model, lattice = _triangular(2)
    with pytest.raises(kg.ModelError, match="depend"):
        PeriodicCell(model, [[1, 0], [2, 0]])
    with pytest.raises(kg.ModelError, match="repeats another"):
        PeriodicCell(model, 10 * lattice)
    with pytest.raises(kg.ModelError, match="not where the lattice"):
        PeriodicCell(model, lattice, [[1, 0, 1, 0]])
    with pytest.raises(kg.ModelError, match="mean strain"):
        PeriodicCell(model, lattice).impose([1.0, 2.0])


def test_mechanism_of_a_cell_is_zero_stiffness() -> None:
    """A square network of unit springs resists stretching along its bars and not shear."""
    frame = kg.Model(dim=2)
    nodes = frame.add(*(kg.Node(i / 2, j / 2) for i in range(3) for j in range(3)))
    for corner in (0, 1, 3, 4):
        frame.add(kg.Bar(nodes[corner], nodes[corner + 1], 1.0), kg.Bar(nodes[corner], nodes[corner + 3], 1.0))
    stiffness = PeriodicCell(frame, np.eye(2)).stiffness()
    assert stiffness == pytest.approx(np.diag([2.0, 2.0, 0.0]), abs=1e-9)
