"""Meshes that choose their own sizes: facets counted across ligaments, the budget, grading, what is not resolved."""

import warnings

import numpy as np
import pytest
import shapely
from shapely import affinity

import kirigami as kg
from kirigami.geometry.clean import clean
from kirigami.geometry.ligaments import find_ligaments

SLITS = kg.cuts.parallel_slits(columns=6, rows=8, width=0.1, height=0.024, length=0.012, margin=0.018)
FIFTY_TWO = kg.Sheet(shapely.box(0, 0, 0.1, 0.06), SLITS, thickness=0.125e-3, material=kg.Material(E=4e9, nu=0.38))
CRACKED = kg.Sheet(
    shapely.box(0, 0, 0.1, 0.2), [[(0.025, 0.1), (0.075, 0.1)]], thickness=1e-4, material=kg.Material(E=4e9, nu=0.38)
)
BAND = kg.Sheet(shapely.box(0, 0, 2, 1), [[(0.2, 0.5), (1.8, 0.5)], [(0.2, 0.56), (1.8, 0.56)]])
TURN = np.linspace(0, 6 * np.pi, 200)
SPIRAL = kg.Sheet(
    shapely.Point(0, 0).buffer(0.5),
    [np.column_stack([(0.05 + 0.02 * TURN) * np.cos(TURN), (0.05 + 0.02 * TURN) * np.sin(TURN)])],
)
HOLES = kg.Sheet(shapely.box(0, 0, 1, 1), [shapely.Point(x, y).buffer(0.1, 4) for x in (0.2, 0.5) for y in (0.3, 0.7)])
SHEETS = {"slits": FIFTY_TWO, "cracked": CRACKED, "band": BAND, "spiral": SPIRAL, "holes": HOLES}


def ligaments_of(sheet):
    drawing = clean(sheet.outline, sheet.cuts)
    found = find_ligaments(drawing)
    return drawing.frame.from_unit(found.ends), found.widths * drawing.frame.size


def rows_across(mesh, low, high):
    """Fewest mesh edges on any way from one node set to another: the rows of facets between them, without geometry."""
    reached, rows = np.isin(np.arange(len(mesh.nodes)), low), 0
    while not reached[high].any():
        touched = reached[mesh.edges].any(axis=1)
        reached[mesh.edges[touched]] = True
        rows += 1
    return rows


def linear_stiffness(mesh, stiffness):
    """Force per displacement of the upper edge along y, both edges held across."""
    m = kg.Model.from_mesh(mesh, stiffness=stiffness)
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=1e-6))
    return kg.LinearStatic(m).run().reaction(top, "y")[-1] / 1e-6


def test_a_band_between_two_slits_has_four_rows_of_facets():
    mesh = BAND.mesh(nodes=4000)
    inside = np.abs(mesh.nodes[:, 0] - 1) < 0.7  # away from the open ends of the band
    low, high = (np.flatnonzero(inside & (mesh.nodes[:, 1] == y)) for y in (0.5, 0.56))
    assert rows_across(mesh, low, high) >= 4
    assert mesh.sizing.facets_across >= 4
    assert mesh.sizing.coarse == 0
    assert mesh.sizing.narrowest == pytest.approx(0.06)


@pytest.mark.parametrize("name", SHEETS)
@pytest.mark.parametrize("nodes", [1500, 3000])
def test_the_budget_is_kept_and_told(name, nodes):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kg.KirigamiWarning)
        mesh = SHEETS[name].mesh(nodes=nodes)
    assert len(mesh.nodes) == pytest.approx(nodes, rel=0.1)
    assert (mesh.sizing.nodes, mesh.sizing.budget) == (len(mesh.nodes), nodes)
    assert mesh.sizing.longest == pytest.approx(mesh.edge_lengths.max(), rel=1e-9)
    assert mesh.sizing.shortest == pytest.approx(mesh.edge_lengths.min(), rel=1e-9)
    assert f"{mesh.sizing.facets_across:g} facet" in str(mesh.sizing)


@pytest.mark.long
def test_more_nodes_put_more_facets_across():
    across = [SPIRAL.mesh(nodes=nodes).sizing.facets_across for nodes in (2500, 10000)]
    assert across[1] > 1.6 * across[0]  # twice as many, but for the whole numbers of rows


def test_the_shortest_edges_are_at_the_tips_and_lengths_grow_smoothly():
    mesh = CRACKED.mesh()
    middles = mesh.nodes[mesh.edges].mean(axis=1)
    far = np.minimum(*(np.linalg.norm(middles - [x, 0.1, 0], axis=1) for x in (0.025, 0.075)))
    assert far[mesh.edge_lengths < np.quantile(mesh.edge_lengths, 0.02)].max() < 0.002
    assert np.median(mesh.edge_lengths[far < 5e-4]) < 0.1 * np.median(mesh.edge_lengths[far > 0.02])
    # neighbouring facets differ in size by a factor that does not depend on where they are
    inner = mesh.edge_facets[mesh.edge_facets[:, 1] >= 0]
    ratio = np.abs(np.log(mesh.facet_areas[inner[:, 0]] / mesh.facet_areas[inner[:, 1]]))
    assert np.exp(ratio).max() < 8
    assert np.exp(np.median(ratio)) < 1.5


@pytest.mark.long
def test_the_same_mesh_in_another_unit():
    metres = FIFTY_TWO.mesh(nodes=5000)
    larger = [affinity.scale(shape, 1000, 1000, origin=(0, 0)) for shape in (FIFTY_TWO.outline, *FIFTY_TWO.cuts)]
    millimetres = kg.Sheet(larger[0], larger[1:]).mesh(nodes=5000)
    assert np.array_equal(metres.triangles, millimetres.triangles)
    assert millimetres.nodes / 1000 == pytest.approx(metres.nodes, abs=1e-12)
    assert millimetres.sizing.width / 1000 == pytest.approx(metres.sizing.width)


@pytest.mark.long
@pytest.mark.parametrize("angle", [17.0, 90.0])
def test_turned_sheets_get_as_good_a_mesh(angle):
    turned = [affinity.rotate(shape, angle, origin=(0, 0)) for shape in (BAND.outline, *BAND.cuts)]
    straight, mesh = BAND.mesh(), kg.Sheet(turned[0], turned[1:]).mesh()
    assert len(mesh.nodes) == pytest.approx(len(straight.nodes), rel=0.15)
    assert mesh.sizing.narrowest == pytest.approx(straight.sizing.narrowest)
    assert abs(mesh.sizing.facets_across - straight.sizing.facets_across) <= 1


def test_two_runs_give_one_mesh():
    one, other = (HOLES.mesh(nodes=1500) for _ in range(2))
    assert np.array_equal(one.nodes, other.nodes)
    assert np.array_equal(one.triangles, other.triangles)


def test_ligaments_between_holes_are_their_gaps():
    holes = [shapely.Point(0.3, 0.5).buffer(0.1, 64), shapely.Point(0.65, 0.5).buffer(0.2, 64)]
    ends, widths = ligaments_of(kg.Sheet(shapely.box(0, 0, 1, 1), holes))
    between = (np.abs(ends[:, :, 1] - 0.5) < 0.1).all(axis=1) & (np.abs(ends.mean(axis=1)[:, 0] - 0.425) < 0.02)
    assert widths[between].min() == pytest.approx(0.05, rel=0.01)


def test_corners_and_rims_alone_are_no_ligaments():
    triangle = kg.Sheet([(0, 0), (3, 0), (0, 1)])
    assert len(ligaments_of(triangle)[1]) == 0
    assert np.isinf(triangle.mesh(nodes=300).sizing.facets_across)
    disc = kg.Sheet(shapely.Point(0, 0).buffer(1, 32))
    assert len(ligaments_of(disc)[1]) == 0


@pytest.mark.parametrize("angle", [0.0, 31.0])
def test_a_tip_before_a_rim_is_a_ligament_of_their_distance(angle):
    slit = shapely.LineString([(0.2, 0.4), (0.9, 0.4)])
    shapes = [affinity.rotate(shape, angle, origin=(0, 0)) for shape in (shapely.box(0, 0, 1, 2), slit)]
    _, widths = ligaments_of(kg.Sheet(*shapes))
    assert widths.min() == pytest.approx(0.1, rel=1e-6)
    assert np.abs(widths - 0.2).min() < 1e-6


@pytest.mark.long
def test_the_limit_of_quadratic_elements_is_met():
    """Limits of benchmarks/default_mesh.py: quadratic elements of scikit-fem on ever finer meshes, extrapolated.

    Sheet with 52 slits 52.28 kN/m; cracked plate of 0.125 mm 205.38 kN/m, so 164.3 for 0.1 mm.
    """
    cracked, slits = CRACKED.mesh(), FIFTY_TWO.mesh()
    for stiffness in ("plate", "facet", "shell"):
        assert linear_stiffness(cracked, stiffness) == pytest.approx(164.3e3, rel=0.02)
    assert linear_stiffness(slits, "shell") == pytest.approx(52.28e3, rel=0.05)
    # constant strain errs to the stiff side, and as the inverse of the nodes
    coarse, fine = (linear_stiffness(FIFTY_TWO.mesh(nodes=nodes), "facet") / 52.28e3 - 1 for nodes in (3000, 9000))
    assert 0 < fine < 0.45 * coarse


def test_what_the_budget_cannot_resolve_is_told():
    with pytest.warns(kg.KirigamiWarning, match=r"has only 0?\.?\d+ facets? across.*About \d[\d,]*000 nodes") as caught:
        mesh = FIFTY_TWO.mesh(nodes=1000)
    assert all(entry.filename == __file__ for entry in caught)
    assert mesh.sizing.facets_across < 2
    dense = kg.Sheet(shapely.Point(0, 0).buffer(1), [shapely.Point(0, 0).buffer(0.5, 500)])
    with pytest.warns(kg.KirigamiWarning, match="nodes, more than the 50 allowed"):
        dense.mesh(nodes=50)
    with pytest.warns(kg.KirigamiWarning, match="narrowest ligament is 0.06 wide, 0.6 times the thickness 0.1"):
        kg.Sheet(BAND.outline, BAND.cuts, thickness=0.1).mesh(nodes=2000)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"nodes": 0}, "nodes must be a whole number"),
        ({"nodes": 99.5}, "nodes must be a whole number"),
        ({"nodes": "many"}, "nodes must be a whole number"),
        ({"nodes": True}, "nodes must be a whole number"),
        ({"nodes": 10**9}, "nodes must be a whole number"),
        ({"nodes": 1000, "max_edge": 0.1}, "not both"),
        ({"cut_edge": 0.1}, "cut_edge goes with max_edge"),
        ({"size": len}, "size goes with max_edge"),
        ({"nodes": 1000, "snap": 0.5}, "details can be snapped at"),
    ],
)
def test_bad_budgets_are_refused(arguments, message):
    with pytest.raises(kg.GeometryError, match=message):
        BAND.mesh(**arguments)


def test_a_size_is_asked_of_points_only() -> None:
    """A sheet without cuts has no point on one: a function that reduces over its points has nothing to say of none."""
    asked = []

    def size(points: np.ndarray) -> np.ndarray:
        asked.append(len(points))
        return 0.1 + np.abs(points[:, :, None] - [0.0, 0.5]).min(axis=(1, 2))

    mesh = kg.Sheet([(0, 0), (1, 0), (1, 1), (0, 1)]).mesh(0.5, size=size)
    assert min(asked) > 0
    assert mesh.edge_lengths.min() < 0.15
