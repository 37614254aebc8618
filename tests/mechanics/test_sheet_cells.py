"""Periodic cells of sheets in space: their law against closed forms and against themselves, and their waves."""

from __future__ import annotations

import math

import numpy as np
import pytest

import kirigami as kg
from kirigami.geometry.border import repeated_border, tiled
from kirigami.lattice.flat_cell import FlatCell
from kirigami.results.sheet_state import StateReader

E, NU, THICKNESS = 12e6, 0.3, 0.01
MATERIAL = kg.Material(E, NU)
PLANE = E * THICKNESS / (1 - NU**2) * np.array([[1, NU, 0], [NU, 1, 0], [0, 0, (1 - NU) / 2]])
RIGIDITY = E * THICKNESS**3 / (12 * (1 - NU**2))
RUNGS = ("plate", "facet", "shell")
COSTLY = ("plate", *(pytest.param(rung, marks=pytest.mark.long) for rung in ("facet", "shell")))


def uncut(cells: int, skew: float = 0.2, size: float = 1.0) -> tuple[kg.TriMesh, np.ndarray]:
    """A periodic mesh without pattern of a parallelogram, and its lattice."""
    lattice = size * np.array([[1.0, 0.0], [skew, 1.0]])
    away = np.random.default_rng(1).uniform(-0.15, 0.15, (cells, cells, 2))
    points = [
        (np.array([i, j]) + away[i % cells, j % cells]) / cells @ lattice
        for j in range(cells + 1)
        for i in range(cells + 1)
    ]
    facets = []
    for j in range(cells):
        for i in range(cells):
            a, up = j * (cells + 1) + i, cells + 1
            one = ((a, a + 1, a + up + 1), (a, a + up + 1, a + up)), ((a, a + 1, a + up), (a + 1, a + up + 1, a + up))
            facets += one[(i + j) % 2]
    return kg.TriMesh(points, facets), lattice


def slit_sheet(thickness: float = 0.1) -> kg.CellSheet:
    """Staggered slits, some across the sides of the cell."""
    slits = [[(-6, 2.5), (6, 2.5)], [(4, 7.5), (16, 7.5)]]
    return kg.CellSheet([(20, 0), (0, 10)], slits, thickness, kg.Material(4000.0, 0.3))


def cell_of(sheet: kg.CellSheet, rung: str, edge: float = 6.0) -> kg.PeriodicCell:
    return kg.PeriodicCell(kg.Model.from_mesh(sheet.mesh(edge, edge), stiffness=rung), sheet.lattice)


def many(cell: kg.PeriodicCell, rung: str, counts: tuple[int, int]) -> kg.PeriodicCell:
    """The same sheet by a cell of several of its cells, on the same mesh."""
    mesh = cell.model.mesh
    lattice = np.column_stack([cell.lattice[:, :2], np.zeros(2)])
    images, _ = repeated_border(mesh, lattice)
    constants = cell.model.sheet_constants
    model = kg.Model.from_mesh(
        tiled(mesh, images, lattice, counts)[0], constants.thickness, constants.material, stiffness=rung
    )
    return kg.PeriodicCell(model, np.array(counts)[:, None] * cell.lattice[:, :2])


# ---- the law of small strains and curvatures


@pytest.mark.parametrize("cells, skew", [(1, 0.0), (3, 0.3)])
def test_an_uncut_cell_of_shells_is_the_sheet(cells: int, skew: float) -> None:
    """A and D of an isotropic plate, E t / (1 - nu^2) and t^2 / 12 times that, on any mesh; no coupling."""
    mesh, lattice = uncut(cells, skew)
    cell = kg.PeriodicCell(kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, "shell"), lattice)
    section = cell.section()
    assert section[:3, :3] == pytest.approx(PLANE, rel=1e-10, abs=1e-10 * PLANE.max())
    assert section[3:, 3:] == pytest.approx(PLANE * THICKNESS**2 / 12, rel=1e-9, abs=1e-10 * RIGIDITY)
    assert np.abs(section[:3, 3:]).max() < 1e-10 * PLANE.max() * THICKNESS
    assert cell.stiffness() == pytest.approx(PLANE, rel=1e-10, abs=1e-10 * PLANE.max())


def test_an_uncut_cell_of_an_unsymmetric_laminate_has_its_coupling() -> None:
    layers = [kg.Orthotropic(E1=12e6, E2=1e6, nu12=0.3, G12=0.5e6, angle=angle) for angle in (0.0, 30.0)]
    laminate = kg.Laminate([(layer, 0.005) for layer in layers])
    mesh, lattice = uncut(2)
    cell = kg.PeriodicCell(kg.Model.from_mesh(mesh, material=laminate, stiffness="shell"), lattice)
    expected = laminate.section(laminate.thickness)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs(expected[:3, 3:] / scale[:3, 3:]).max() > 0.1
    assert cell.section() / scale == pytest.approx(expected / scale, abs=1e-9)


def test_membrane_of_flat_facets_is_exact_and_bending_on_meshes_of_equal_facets() -> None:
    mesh, lattice = uncut(2)
    cell = kg.PeriodicCell(kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, "facet"), lattice)
    assert cell.section()[:3, :3] == pytest.approx(PLANE, rel=1e-10, abs=1e-10 * PLANE.max())
    half = math.sqrt(3) / 2
    points = [(i + j / 2, j * half) for j in range(4) for i in range(4)]
    facets = [t for a in (0, 1, 2, 4, 5, 6, 8, 9, 10) for t in ((a, a + 1, a + 4), (a + 1, a + 5, a + 4))]
    even = kg.PeriodicCell(
        kg.Model.from_mesh(kg.TriMesh(points, facets), THICKNESS, MATERIAL, "facet"), [(3, 0), (1.5, 3 * half)]
    )
    bending = PLANE * THICKNESS**2 / 12
    assert even.section()[3:, 3:] == pytest.approx(bending, rel=1e-9, abs=1e-9 * bending.max())


@pytest.mark.parametrize("rung", RUNGS)
def test_one_cell_and_many_have_one_section(rung: str) -> None:
    cell = cell_of(slit_sheet(), rung)
    section = cell.section()
    scale = np.sqrt(np.outer(np.diag(section), np.diag(section)))
    for counts in ((2, 1), (2, 2), (1, 3), (3, 3)):
        assert many(cell, rung, counts).section() / scale == pytest.approx(section / scale, abs=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("rung", ("plate", "shell"))
def test_finite_sheets_come_near_the_infinite_one(rung: str) -> None:
    """Pulled between grips that let it contract: off by the share of the rim, which falls as 1 / cells, to zero."""
    sheet = slit_sheet()
    cell = cell_of(sheet, rung)
    law = np.linalg.inv(cell.stiffness())
    found = {}
    for count in (5, 10, 20):
        lattice = np.column_stack([sheet.lattice, np.zeros(2)])
        mesh, _, _ = tiled(cell.model.mesh, cell.images, lattice, (count, count))
        m = kg.Model.from_mesh(mesh, sheet.thickness, sheet.material, rung)
        height, width = 10.0 * count, 20.0 * count
        top, bottom = m.select(boundary="top"), m.select(boundary="bottom")
        m.add(kg.Fix(m.nodes, "z"), kg.Fix(bottom, "y"), kg.Prescribe(top, y=1e-6 * height), kg.Fix(bottom[0], "x"))
        reaction = kg.LinearStatic(m).run().reaction(top, "y")[-1]
        found[count] = reaction / width / 1e-6 * law[1, 1]
    off = np.abs(np.array([found[count] for count in (5, 10, 20)]) - 1)
    assert off[2] < 0.05
    assert off[1] / off[2] == pytest.approx(2.0, rel=0.2)
    assert 2 * found[20] - found[10] == pytest.approx(1.0, abs=3e-3)


# ---- the law of large strains


def test_stress_of_a_buckled_cell_is_the_slope_of_its_energy_and_the_tangent_that_of_stress() -> None:
    cell = cell_of(slit_sheet(), "plate")
    cell.impose((None, 0.1, 0.0))
    cell.model.imperfect()
    res = kg.DisplacementControl(cell.model, targets=[0.4995, 0.5, 0.5005], to=0.5005, tol=1e-10).run()
    law = cell.law(res)
    at = int(np.argmin(np.abs(res.lam - 0.5)))
    assert np.ptp(res.u[at, :, 2]) > 1.0  # it has buckled
    assert cell.waves([0.0, 0.0], res[at]) > 0  # and is stable in what all cells do alike
    assert np.abs(law.stress[:, 0]).max() < 1e-6 * law.stress[at, 1]  # the width is free
    change = law.strain[at + 1] - law.strain[at - 1]
    assert law.energy[at + 1] - law.energy[at - 1] == pytest.approx(law.stress[at] @ change, rel=1e-5)
    assert law.stress[at + 1] - law.stress[at - 1] == pytest.approx(
        cell.stiffness(res[at]) @ change, rel=1e-3, abs=1e-3 * (law.stress[at + 1, 1] - law.stress[at - 1, 1])
    )
    assert law.poisson[at] == pytest.approx(-law.strain[at, 0] / 0.05, rel=1e-6)


@pytest.mark.parametrize("rung", COSTLY)
def test_two_cells_buckle_as_one_and_the_file_says_the_same(rung: str, tmp_path) -> None:
    cell = cell_of(slit_sheet(), rung)
    two = many(cell, rung, (1, 2))
    forces = []
    for one in (cell, two):
        one.impose((0.0, 0.01, 0.0))
        lift = np.sin(2 * np.pi * one.model.positions()[:, 1] / 10) * np.cos(np.pi * one.model.positions()[:, 0] / 10)
        one.model.perturb(0.1 * lift)
        res = kg.DisplacementControl(one.model, targets=[0.2, 1.0], step=0.05, tol=1e-9).run()
        forces.append([one.law(res).stress[np.argmin(np.abs(res.lam - lam))] for lam in (0.2, 1.0)])
    assert np.array(forces[1]) == pytest.approx(np.array(forces[0]), rel=1e-5, abs=1e-6)
    read = kg.load(res.save(tmp_path / "cell.npz"))
    assert two.law(read).stress == pytest.approx(two.law(res).stress, rel=1e-9)


@pytest.mark.parametrize("rung", RUNGS)
def test_all_energy_of_a_cell_is_that_of_its_facets(rung: str) -> None:
    """What bends across the border belongs to the facets on both sides of it."""
    cell = cell_of(slit_sheet(), rung)
    cell.impose((0.0, 1e-3, 0.0))
    cell.model.add(kg.NodalLoad(cell.model.nodes[int(cell.images[0, 1])], (0.0, 0.0, 1e-3)))
    res = kg.LinearStatic(cell.model).run()
    state = StateReader(res, cell.model.mesh).at(res[-1])
    stored = sum(values[-1] for values in res.energy.values())
    assert state.bending_energy.sum() > 1e-4 * stored
    assert (state.bending_energy + state.membrane_energy).sum() == pytest.approx(stored, rel=1e-9)


def test_a_strip_stretches_as_a_bar() -> None:
    """With wavy sides of the same area a little less: an even strain is one of those that could be."""
    mesh, _ = uncut(2, 0.0)
    cell = kg.PeriodicCell(kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, "shell"), [[1.0, 0.0]])
    straight = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    bar = kg.PeriodicCell(kg.Model.from_mesh(straight, THICKNESS, MATERIAL, "shell"), [[1.0, 0.0]])
    assert bar.stiffness()[0, 0] == pytest.approx(E * THICKNESS, rel=1e-9)
    assert mesh.facet_areas.sum() == pytest.approx(1.0)
    assert 0.95 * E * THICKNESS < cell.stiffness()[0, 0] < 0.999 * E * THICKNESS


@pytest.mark.parametrize("rung", RUNGS)
def test_modes_of_a_cell_are_among_those_of_many(rung: str) -> None:
    """What all cells do alike, many can do too; three motions of the whole cost nothing."""
    mesh, lattice = uncut(2)
    heavy = kg.Material(E, NU, density=1.0)
    cell = kg.PeriodicCell(kg.Model.from_mesh(mesh, THICKNESS, heavy, rung), lattice)
    two = many(cell, rung, (2, 1))
    found = []
    for one, count in ((cell, 6), (two, 14)):
        one.impose((0.0, 0.0, 0.0), hold=False)
        found.append(kg.Eigen(one.model, n=count, mass="consistent").run().values)
    few, more = found
    assert np.abs(few[:3]).max() < 1e-6 * few[3]
    for value in few[3:]:
        assert np.abs(more / value - 1).min() < 1e-6


def test_loads_and_folds_of_a_cell_do_not_hang_on_how_nodes_are_numbered() -> None:
    """Edges on the border run as those they repeat, so not always from the lower node to the higher one."""
    mesh, lattice = uncut(3)
    order = np.random.default_rng(2).permutation(len(mesh.nodes))  # the new number of each node
    other = kg.TriMesh(mesh.nodes[np.argsort(order)], order[mesh.triangles])
    found = []
    for one, number in ((mesh, np.arange(len(order))), (other, order)):
        sunk = []
        for load in (kg.AreaLoad((0.0, 0.0, 1.0)), kg.Pressure(1.0)):
            model = kg.Model.from_mesh(one, THICKNESS, MATERIAL, "shell")
            kg.PeriodicCell(model, lattice).impose((0.0, 0.0, 0.0))
            model.add(kg.Crease([model.nodes[number[k]] for k in (5, 9)], 10.0), load)
            sunk.append(kg.LinearStatic(model).run().u[-1][number])
        assert np.abs(sunk[0]).max() > 0
        assert sunk[0] == pytest.approx(sunk[1], rel=1e-9, abs=1e-9 * np.abs(sunk[0]).max())
        found.append(sunk[0])
    assert found[0] == pytest.approx(found[1], rel=1e-6, abs=1e-6 * np.abs(found[0]).max())


# ---- waves


@pytest.mark.parametrize("toward", [(-1.0, None, None), (None, -1.0, None)])
def test_long_waves_of_a_compressed_sheet_are_eulers(toward: tuple[float | None, ...]) -> None:
    """N k_along^2 = D k^4, so that N = D k^2 where the wave vector is along the pressure."""
    mesh, lattice = uncut(2)
    cell = kg.PeriodicCell(kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, "shell"), lattice)
    with pytest.warns(kg.KirigamiWarning, match="longest wave"):
        found = cell.buckling(toward, longest=30)
    along = 0 if toward[0] else 1
    square = found.wave_vector @ found.wave_vector
    assert found.longest
    assert -found.stress[along] * found.wave_vector[along] ** 2 == pytest.approx(RIGIDITY * square**2, rel=1e-4)
    if along == 0:
        assert abs(found.wave_vector[1]) < 1e-3 * found.wave_vector[0]
        assert found.wavelength == pytest.approx(30.0, rel=1e-3)


def test_a_long_strip_is_eulers_column() -> None:
    mesh = kg.TriMesh([(0, 0), (1, 0), (1, 0.2), (0, 0.2)], [(0, 1, 2), (0, 2, 3)])
    cell = kg.PeriodicCell(kg.Model.from_mesh(mesh, THICKNESS, kg.Material(E, 0.0), "shell"), [[1.0, 0.0]])
    inertia = 0.2 * THICKNESS**3 / 12
    for longest in (20, 40):
        with pytest.warns(kg.KirigamiWarning, match="longest wave"):
            found = cell.buckling([-1.0], longest=longest)
        assert -found.stress[0] == pytest.approx(E * inertia * (2 * math.pi / longest) ** 2, rel=2e-3)


@pytest.mark.parametrize("rung", COSTLY)
def test_waves_of_a_cell_are_what_many_cells_do_alike(rung: str) -> None:
    """A wave of two cells, just before and just after its load, against the cell of two: stable, then not."""
    cell = cell_of(slit_sheet(), rung)
    strain, phases = (0.0, 1.0, 0.0), np.array([math.pi, 0.0])
    two = many(cell, rung, (2, 1))

    def at(one: kg.PeriodicCell, phases: np.ndarray, factor: float) -> float:
        state = FlatCell(one, strain).at(factor).u
        points = len(one.model.nodes)
        return float(one.waves(phases, kg.Step(factor, state[:points], inner=state[points:])))

    low, high = 1e-4, 5e-3
    assert at(cell, phases, low) > 0 > at(cell, phases, high)
    for _ in range(9):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if at(cell, phases, middle) > 0 else (low, middle)
    both = [(at(cell, np.zeros(2), factor), at(two, np.zeros(2), factor)) for factor in (0.99 * low, 1.01 * high)]
    known = [min(alike, at(cell, phases, factor)) > 0 for (alike, _), factor in zip(both, (0.99 * low, 1.01 * high))]
    assert [value > 0 for _, value in both] == known


def test_buckling_in_waves_is_that_of_a_finite_supercell() -> None:
    """Classical buckling of 2 x 2 cells, by other means, against the waves that fit into them; what it neglects, the
    strain before, is small in a thin sheet."""
    cell = cell_of(slit_sheet(0.03), "plate")
    four = many(cell, "plate", (2, 2))
    four.impose((0.0, 1.0, 0.0))
    classical = kg.Buckling(four.model, n=1).run().values[0]
    assert cell.buckling((0.0, 1.0, 0.0), longest=2).factor == pytest.approx(classical, rel=1e-3)


def test_what_is_not_compressed_does_not_buckle() -> None:
    mesh, lattice = uncut(1)
    cell = kg.PeriodicCell(kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, "shell"), lattice)
    with pytest.raises(kg.AnalysisError, match="does not buckle"):
        cell.buckling((None, 1.0, 0.0), most=0.05)


# ---- bad input


def test_borders_that_do_not_match_are_told_with_their_place() -> None:
    square = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0.5), (1, 0.4)]
    mesh = kg.TriMesh(square, [(0, 1, 5), (0, 5, 4), (4, 5, 2), (4, 2, 3)])
    m = kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, "shell")
    with pytest.raises(kg.GeometryError, match=r"no edge of the mesh repeats .* \(1, 0\).*CellSheet"):
        kg.PeriodicCell(m, np.eye(2))
    three = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0.5), (1, 0.5), (1, 0.75)]
    mesh = kg.TriMesh(three, [(0, 1, 5), (0, 5, 4), (4, 5, 6), (4, 6, 3), (3, 6, 2)])
    m = kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, "shell")
    with pytest.raises(kg.GeometryError, match=r"does not repeat at .*CellSheet"):
        kg.PeriodicCell(m, np.eye(2))
    with pytest.raises(kg.GeometryError, match="no edge of the mesh repeats"):
        kg.PeriodicCell(m, [[3, 0], [0, 1]])


def test_what_is_no_cell_or_no_wave_is_refused() -> None:
    mesh, lattice = uncut(1)
    m = kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, "shell")
    cell = kg.PeriodicCell(m, lattice)
    with pytest.raises(kg.ModelError, match="from -pi to pi"):
        cell.waves([4.0, 0.0])
    with pytest.raises(kg.ModelError, match="phases must have the shape"):
        cell.waves([1.0])
    with pytest.raises(kg.ModelError, match="drives nothing"):
        cell.buckling((None, 0.0, None))
    with pytest.raises(kg.ModelError, match="rotation costs nothing"):
        cell.impose(np.array([[0, 0.1, 0], [0, 0, 0], [0, 0, 0]]))
    res = kg.Results(kg.System(m))
    with pytest.raises(kg.ModelError, match="before impose"):
        cell.law(res)
    cell.impose((None, 0.1, None))
    cell.impose((None, 0.2, None))
    with pytest.raises(kg.ModelError, match="two periodic cells"):
        kg.System(m)
    with pytest.raises(kg.ModelError, match="no sheet in space"):
        squares = kg.tilings.rotating_squares(angle=0.6)
        plane = kg.PeriodicCell(squares.model(EA=1e4, stiffness=1.0), squares.lattice, squares.images)
        plane.section()


def test_a_rest_shape_that_does_not_repeat_is_told() -> None:
    mesh, lattice = uncut(2)
    m = kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, "plate")
    kg.PeriodicCell(m, lattice).impose((None, 0.1, None))
    m.perturb(np.arange(len(m.nodes), dtype=float), amplitude=1e-3)
    with pytest.raises(kg.ModelError, match="at rest does not repeat.*imperfect"):
        kg.System(m)


def test_cells_of_any_outline_that_tiles_are_the_sheet() -> None:
    """A hexagon, whose six sides repeat along two lattice vectors and their difference."""
    angle = np.arange(6) * math.pi / 3
    corners = np.column_stack([np.cos(angle), np.sin(angle)])
    mesh = kg.TriMesh([(0, 0), *corners.tolist()], [(0, 1 + k, 1 + (k + 1) % 6) for k in range(6)])
    lattice = [(1.5, math.sqrt(0.75)), (0.0, 2 * math.sqrt(0.75))]
    section = kg.PeriodicCell(kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, "shell"), lattice).section()
    assert section[:3, :3] == pytest.approx(PLANE, rel=1e-10, abs=1e-10 * PLANE.max())
    assert section[3:, 3:] == pytest.approx(PLANE * THICKNESS**2 / 12, rel=1e-9, abs=1e-10 * RIGIDITY)


@pytest.mark.parametrize("rung", RUNGS)
def test_a_cell_that_is_not_held_moves_as_a_whole_and_does_not_turn(rung: str) -> None:
    mesh, lattice = uncut(1, 0.0)
    known = (lattice, "along x, translation along y, translation along z;"), ([[1, 0]], "rotation about x;")
    for vectors, free in known:
        m = kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, rung)
        kg.PeriodicCell(m, vectors).impose([0.1] if len(vectors) == 1 else (None, 0.1, 0.0), hold=False)
        with pytest.raises(kg.MechanismError, match=free):
            kg.LinearStatic(m).run()


def test_nodes_of_the_border_are_constrained_once() -> None:
    mesh, lattice = uncut(2)
    m = kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, "plate")
    cell = kg.PeriodicCell(m, lattice)
    cell.impose((None, 0.1, None))
    m.add(kg.Fix(m.nodes[int(cell.images[0, 0])], "z"))
    with pytest.raises(kg.ModelError, match="constrain each displacement once"):
        kg.System(m)


@pytest.mark.parametrize("rung", ["paper", "plate", "facet", kg.Calibration(0.9, 0.01)], ids=str)
def test_a_patch_stores_the_energy_of_its_cells(rung: str | kg.Calibration) -> None:
    """Wherever nodes tell all, each rung with its own elements: six cells store six times what one does."""
    cell = cell_of(slit_sheet(), rung)
    cell.impose((1e-6, 0.0, 0.0))
    one = kg.LinearStatic(cell.model).run()
    stored = [sum(values[-1] for values in results.energy.values()) for results in (one, cell.patch(one, (3, 2)))]
    assert stored[1] == pytest.approx(6 * stored[0], rel=1e-5, abs=0)
