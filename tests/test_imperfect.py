"""The imperfection of a sheet: one field for every mesh, unit and position of it; free of stress; held by supports."""

import numpy as np
import pytest
import shapely
from scipy.spatial import cKDTree
from shapely import affinity

import kirigami as kg
from kirigami.system.system import System

SLITS = [[(0.02, 0.015), (0.06, 0.015)], [(0.04, 0.03), (0.08, 0.03)], [(0.02, 0.045), (0.06, 0.045)]]
FILM = {"thickness": 1e-4, "material": kg.Material(E=3.5e9, nu=0.3)}
SLIT_SHEET = kg.Sheet(shapely.box(0, 0, 0.1, 0.06), SLITS, **FILM)
RING = kg.Sheet(shapely.Point(0, 0).buffer(0.1).difference(shapely.Point(0.02, 0.01).buffer(0.03)), **FILM)


MESHES = {}  # of the sheets, by the number of nodes asked for: every rung stands on the same


def held(sheet, nodes=1500, stiffness="plate", sides=("bottom", "top")):
    if (sheet, nodes) not in MESHES:
        MESHES[sheet, nodes] = sheet.mesh(nodes=nodes)
    model = kg.Model.from_mesh(MESHES[sheet, nodes], stiffness=stiffness)
    for side in sides:
        model.add(kg.Fix(model.select(boundary=side), clamp=True))
    return model


def offsets(model, **options):
    """Offsets of the nodes of the mesh, with largest length 1 unless said."""
    flat = model.positions()
    model.imperfect(**{"amplitude": 1.0, **options})
    return (model.positions() - flat)[: len(model.mesh.nodes)]


def distance(mesh, field, other_mesh, other_field):
    """Root mean square difference of two fields (n, 3) over the root mean square of the first."""
    centres = mesh.nodes[mesh.triangles].mean(axis=1)[:, :2]
    values = field[mesh.triangles].mean(axis=1)
    _, candidates = cKDTree(other_mesh.nodes[other_mesh.triangles].mean(axis=1)[:, :2]).query(centres, k=8)
    best, found = np.full(len(centres), -np.inf), np.zeros((len(centres), 3))
    for facet in candidates.T:
        corners = other_mesh.triangles[facet]
        place = other_mesh.nodes[corners][:, :, :2]
        shares = np.linalg.solve(
            np.concatenate([place.transpose(0, 2, 1), np.ones((len(facet), 1, 3))], axis=1),
            np.column_stack([centres, np.ones(len(centres))])[:, :, None],
        )[:, :, 0]
        better = shares.min(axis=1) > best
        best[better] = shares.min(axis=1)[better]
        found[better] = np.einsum("mc,mcx->mx", shares, other_field[corners])[better]
    area = mesh.facet_areas[:, None]
    return float(np.sqrt((area * (values - found) ** 2).sum() / (area * values**2).sum()))


@pytest.mark.parametrize(("stiffness", "bound"), [("plate", 0.08), ("facet", 0.1), ("shell", 0.04)])
@pytest.mark.parametrize(("sheet", "sides"), [(SLIT_SHEET, ("bottom", "top")), (RING, ())], ids=["slits", "free ring"])
def test_two_meshes_of_a_sheet_get_one_field(sheet, sides, stiffness, bound):
    coarse, fine = (held(sheet, nodes, stiffness, sides) for nodes in (900, 2500))
    assert distance(coarse.mesh, offsets(coarse), fine.mesh, offsets(fine)) < bound


@pytest.mark.parametrize(("stiffness", "bound"), [("plate", 0.25), ("facet", 0.12)])
def test_the_rungs_get_one_field_within_their_error_in_bending(stiffness, bound):
    """Plates of bars and hinges cost twice in twist, facets are 2 to 12 % off on meshes of the mesher."""
    shell, other = held(SLIT_SHEET, stiffness="shell"), held(SLIT_SHEET, stiffness=stiffness)
    assert distance(shell.mesh, offsets(shell), other.mesh, offsets(other)) < bound


def test_it_is_the_deflection_under_a_pressure_hence_a_sum_of_bending_modes():
    """Against the modes of the assembled matrix: each has its share of one load vector over its eigenvalue."""
    model = held(SLIT_SHEET, nodes=120)
    flat = System(model)
    stiffness = flat.stiffness().toarray()
    field = flat.reduce(np.ascontiguousarray(offsets(model)))
    values, vectors = np.linalg.eigh(stiffness)
    shares = vectors.T @ field
    loads = vectors.T @ (stiffness @ field)
    assert shares == pytest.approx(loads / values, abs=1e-9 * np.abs(shares).max())
    # soft modes are strong: the ten softest of many hold nearly all of it
    assert (shares[np.argsort(values)[:10]] ** 2).sum() > 0.9 * (shares**2).sum()


@pytest.mark.parametrize("stiffness", ["plate", "facet", "shell"])
def test_it_is_free_of_stress_and_keeps_the_supports_in_place(stiffness):
    model = held(SLIT_SHEET, nodes=600, stiffness=stiffness)
    moved = offsets(model, amplitude=None)
    assert np.linalg.norm(moved, axis=1).max() == pytest.approx(1e-5, rel=1e-9)  # a tenth of the thickness
    assert np.abs(moved[:, :2]).max() == 0
    assert np.abs(moved[model.mesh.boundary("bottom")]).max() == 0
    system = System(model)
    residual, _ = system.forces(np.zeros_like(system.rest), 0.0)
    assert np.abs(system.reduce(residual)).max() < 1e-9 * 3.5e9 * 1e-4 * 1e-5  # against E t times the offset
    assert sum(system.energies(np.zeros_like(system.rest)).values()) < 1e-20 * 3.5e9 * 1e-4 * 0.006


def test_the_lips_of_a_cut_part():
    model = held(SLIT_SHEET)
    moved = offsets(model)
    lips = np.unique(model.mesh.cuts[1].loop)
    middle = lips[np.abs(model.mesh.nodes[lips, 0] - 0.06) < 0.002]
    assert np.ptp(moved[middle, 2]) > 0.01


@pytest.mark.long
def test_the_same_in_metres_and_millimetres():
    metres = held(SLIT_SHEET, nodes=5000)
    larger = [affinity.scale(shape, 1000, 1000, origin=(0, 0)) for shape in (SLIT_SHEET.outline, *SLIT_SHEET.cuts)]
    sheet = kg.Sheet(larger[0], larger[1:], thickness=0.1, material=kg.Material(E=3.5e3, nu=0.3))
    millimetres = held(sheet, nodes=5000)
    assert offsets(millimetres) == pytest.approx(offsets(metres), abs=1e-6)


@pytest.mark.parametrize("stiffness", ["plate", "shell"])
def test_it_turns_with_the_sheet(stiffness):
    model = held(SLIT_SHEET, nodes=800, stiffness=stiffness)
    angle = np.radians(20)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    mesh = kg.TriMesh(model.mesh.nodes @ turn.T + [3, 1, 0], model.mesh.triangles, **FILM)
    turned = kg.Model.from_mesh(mesh, stiffness=stiffness)
    for side in ("bottom", "top"):
        turned.add(kg.Fix(turned.select(index=model.mesh.boundary(side)), clamp=True))
    assert offsets(turned) == pytest.approx(offsets(model) @ turn.T, abs=1e-6)


def test_a_sheet_in_another_plane_gets_it_along_its_normal():
    model = held(SLIT_SHEET, nodes=400, stiffness="facet")
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    mesh = kg.TriMesh(model.mesh.nodes @ turn.T, model.mesh.triangles, **FILM)
    upright = kg.Model.from_mesh(mesh, stiffness="facet")
    for side in ("bottom", "top"):
        upright.add(kg.Fix(upright.select(index=model.mesh.boundary(side)), clamp=True))
    here, there = offsets(model)[:, 2], offsets(upright)
    assert np.abs(there[:, [0, 2]]).max() < 1e-12
    assert np.abs(there[:, 1]) == pytest.approx(np.abs(here), abs=1e-6)


def test_a_free_sheet_is_not_moved_as_a_whole():
    model = held(RING, sides=())
    moved, mesh = offsets(model)[:, 2], model.mesh
    area = np.bincount(mesh.triangles.ravel(), np.repeat(mesh.facet_areas / 3, 3), len(moved))
    for rigid in (np.ones(len(moved)), mesh.nodes[:, 0], mesh.nodes[:, 1]):
        assert abs(area @ (rigid * moved)) < 1e-6 * np.sqrt((area @ rigid**2) * (area @ moved**2))


def test_seeds_and_signs():
    first, again, other, down = (held(SLIT_SHEET, nodes=300) for _ in range(4))
    one = offsets(first, seed=1)
    assert np.array_equal(one, offsets(again, seed=1))
    assert offsets(down, seed=1, amplitude=-1.0) == pytest.approx(-one)
    third = offsets(other, seed=2)
    assert abs(np.sum(one * third)) < 0.9 * np.linalg.norm(one) * np.linalg.norm(third)
    flat = held(SLIT_SHEET, nodes=300)
    assert not offsets(flat, amplitude=0).any()


def test_a_framework_of_ones_own():
    """A shallow arch of bars and hinges in space: the field is a small deflection of it."""
    model = kg.Model()
    x = np.linspace(-1, 1, 9)
    rows = [model.add(*(kg.Node(a, y, 0.2 * (1 - a * a)) for a in x.tolist())) for y in (0.0, 0.3)]
    for k in range(8):
        (a, b), (c, d) = rows[0][k : k + 2], rows[1][k : k + 2]
        model.add(kg.Bar(a, b, 1e3), kg.Bar(c, d, 1e3), kg.Bar(a, d, 1e3), kg.BendHinge(b, a, d, c, 1.0))
        if k:
            model.add(kg.Bar(a, c, 1e3), kg.BendHinge(rows[0][k - 1], a, c, d, 1.0))
    model.add(kg.Fix([rows[0][0], rows[1][0], rows[0][-1], rows[1][-1]]))
    before = model.positions()
    with pytest.raises(kg.ModelError, match="give an amplitude"):
        model.imperfect()
    model.imperfect(0.01)
    moved = np.linalg.norm(model.positions() - before, axis=1)
    assert moved.max() == pytest.approx(0.01)
    assert moved[[0, 8, 9, 17]].max() == 0


def test_what_has_no_such_field_is_refused():
    plane = kg.Model.from_mesh(SLIT_SHEET.mesh(nodes=200), dim=2)
    with pytest.raises(kg.ModelError, match="dim=2"):
        plane.imperfect()
    net = kg.Model()
    a, b, c, d = net.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(1, 1), kg.Node(0, 1))
    net.add(kg.Bar(a, b, 1.0), kg.Bar(b, c, 1.0), kg.Bar(c, d, 1.0), kg.Bar(d, a, 1.0), kg.Bar(a, c, 1.0))
    net.add(kg.Fix([a, b, d]))
    with pytest.raises(kg.ModelError, match="without resistance"):
        net.imperfect(0.1)
    stuck = kg.Model.from_mesh(SLIT_SHEET.mesh(nodes=200))
    stuck.add(kg.Fix(stuck.nodes))
    with pytest.raises(kg.ModelError, match="hold every node"):
        stuck.imperfect()
    model = held(SLIT_SHEET, nodes=200)
    for options, message in (
        ({"seed": -1}, "seed"),
        ({"seed": 1.5}, "seed"),
        ({"seed": True}, "seed"),
        ({"amplitude": np.nan}, "amplitude"),
        ({"amplitude": "big"}, "amplitude"),
    ):
        with pytest.raises(kg.ModelError, match=message):
            model.imperfect(**options)
