"""Meshes of sheets: areas, Euler relation, sizes, cuts in input order, names, units."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import shapely
from shapely import LineString, box

import kirigami as kg


def crosses() -> list[LineString]:
    return [LineString([(0.5, 1), (1.5, 1)]), LineString([(1, 0.5), (1, 1.5)])]


SHEETS = {
    "plain": (kg.Sheet(box(0, 0, 2, 1)), 0, 0),
    "slit": (kg.Sheet(box(0, 0, 2, 2), LineString([(0.5, 1), (1.5, 1)])), 1, 0),
    "slit from the edge": (kg.Sheet(box(0, 0, 2, 2), LineString([(0, 1), (1.2, 1)])), 0, 1),
    "crossing": (kg.Sheet(box(0, 0, 2, 2), crosses()), 1, 0),
    "hole": (kg.Sheet(box(0, 0, 2, 2), shapely.Point(1, 1).buffer(0.4)), 1, 0),
    "hole of the outline": (
        kg.Sheet(box(0, 0, 2, 2) - box(0.5, 0.5, 1, 1), LineString([(1, 0.75), (1.5, 0.75)])),
        1,
        1,
    ),
    "slit ends in a hole": (kg.Sheet(box(0, 0, 2, 2), [LineString([(0.4, 1), (1, 1)]), box(1, 0.8, 1.4, 1.2)]), 1, 0),
    "notch": (kg.Sheet(box(0, 0, 2, 2), box(-1, 0.9, 0.5, 1.1)), 0, 1),
    "disc": (kg.Sheet(*kg.cuts.single_slit_disc(radius=1, length=0.9)), 1, 0),
    "arcs": (kg.Sheet(box(0, 0, 2, 2.4), kg.cuts.curved_cells()), 16, 12),
    "arcs with width": (kg.Sheet(box(0, 0, 2, 2.4), kg.cuts.curved_cells(opening=0.005)), 16, 12),
    "random": (kg.Sheet(box(0, 0, 1, 1), kg.cuts.random_slits(30, 1, 1, (0.1, 0.3), seed=2, gap=0.02)), 30, 0),
}


@pytest.fixture(scope="module", params=SHEETS)
def case(request):
    sheet, holes, _ = SHEETS[request.param]
    max_edge = 0.12 if request.param != "random" else 0.06
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return sheet, sheet.mesh(max_edge), holes, max_edge


def test_area(case):
    sheet, mesh, *_ = case
    assert mesh.facet_areas.sum() == pytest.approx(sheet.area, rel=1e-10)


def test_euler_relation_of_one_connected_sheet(case):
    _, mesh, holes, _ = case
    assert len(mesh.boundary_loops) == 1 + holes
    assert len(mesh.edges) - len(mesh.triangles) - len(mesh.nodes) == holes - 1
    assert mesh.facet_parts.max() == 0


def test_angles_and_lengths(case):
    _, mesh, _, max_edge = case
    assert mesh.min_angle >= 20.0
    assert mesh.edge_lengths.max() <= 1.1 * max_edge
    ends = {tuple(sorted(pair)) for cut in mesh.cuts for pair in zip(cut.loop, np.roll(cut.loop, -1), strict=True)}
    on_lip = np.array([tuple(sorted(pair)) in ends for pair in mesh.edges.tolist()])
    if mesh.cuts:
        assert mesh.edge_lengths[on_lip].max() <= 0.4 * max_edge * (1 + 1e-6)


def test_every_cut_has_a_record_in_input_order(case):
    sheet, mesh, *_ = case
    members = [number for cut in mesh.cuts for number in cut.members]
    assert sorted(members) == list(range(len(sheet.cuts)))
    assert [min(cut.members) for cut in mesh.cuts] == sorted(min(cut.members) for cut in mesh.cuts)


def test_lips_lie_on_the_drawn_cuts(case):
    sheet, mesh, *_ = case
    for cut in mesh.cuts:
        drawn = shapely.union_all(
            [shapely.boundary(sheet.cuts[i]) if sheet.cuts[i].area else sheet.cuts[i] for i in cut.members]
        )
        assert shapely.distance(shapely.points(mesh.nodes[cut.loop, :2]), drawn).max() < 1e-9
        if not any(sheet.cuts[i].area for i in cut.members):
            assert shapely.Polygon(mesh.nodes[cut.loop, :2]).area == pytest.approx(0.0, abs=1e-12)


def test_open_cuts_are_marked():
    for sheet, _, open_cuts in SHEETS.values():
        assert sum(cut.open for cut in sheet.mesh(0.2).cuts) == open_cuts


def test_area_of_an_opening_is_positive():
    mesh = kg.Sheet(box(0, 0, 2, 2), box(0.5, 0.5, 1, 1)).mesh(0.2)
    x, y, _ = mesh.nodes[mesh.cuts[0].loop].T
    assert 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)) == pytest.approx(0.25, rel=1e-12)


def test_notch_is_closed_by_its_mouth():
    mesh = kg.Sheet(box(0, 0, 2, 2), box(-1, 0.9, 0.5, 1.1)).mesh(0.2)
    assert shapely.Polygon(mesh.nodes[mesh.cuts[0].loop, :2]).area == pytest.approx(0.1, rel=1e-12)
    assert mesh.nodes[mesh.cuts[0].loop[[0, -1]], 0].tolist() == [0.0, 0.0]


def test_slit_between_outline_and_its_hole_is_one_cut_with_two_lips():
    outline = shapely.Polygon(box(0, 0, 2, 2).exterior, [box(0.8, 0.8, 1.2, 1.2).exterior.coords])
    mesh = kg.Sheet(outline, LineString([(0, 1), (0.8, 1)])).mesh(0.2)
    assert len(mesh.boundary_loops) == 1
    (cut,) = mesh.cuts
    assert cut.open
    assert shapely.Polygon(mesh.nodes[cut.loop, :2]).area == pytest.approx(0.0, abs=1e-12)
    moved = mesh.nodes.copy()
    moved[:, 1] += np.where(np.isin(np.arange(len(moved)), _upper_lip(mesh, cut.loop)), 0.1, 0.0)
    assert shapely.Polygon(moved[cut.loop, :2]).area == pytest.approx(0.08, rel=1e-9)


def _upper_lip(mesh: kg.TriMesh, loop: np.ndarray) -> np.ndarray:
    """Nodes of the loop whose facets lie above."""
    centres = mesh.nodes[mesh.triangles].mean(axis=1)
    above = np.unique(mesh.triangles[centres[:, 1] > 1.0])
    return loop[np.isin(loop, above)]


def test_sides_are_exact_and_without_lips():
    mesh = SHEETS["arcs"][0].mesh(0.1)
    assert (mesh.nodes[mesh.boundary("bottom"), 1] == 0.0).all()
    assert (mesh.nodes[mesh.boundary("top"), 1] == 2.4).all()
    assert (mesh.nodes[mesh.boundary("right"), 0] == 2.0).all()
    outer = mesh.nodes[mesh.boundary("outer"), :2]
    assert (shapely.distance(shapely.points(outer), box(0, 0, 2, 2.4).exterior) < 1e-12).all()
    assert len(mesh.boundary("free")) > len(outer)
    mouths = np.intersect1d(mesh.boundary("left"), mesh.boundary("cut:0"))
    assert len(mouths) == 2  # both sides of the mouth of the half arc


def test_crossing_cuts_share_one_record():
    mesh = kg.Sheet(box(0, 0, 2, 2), [*crosses(), LineString([(1.6, 0.2), (1.6, 0.6)])]).mesh(0.2)
    assert [cut.members for cut in mesh.cuts] == [(0, 1), (2,)]
    assert mesh.boundary("cut:1").tolist() == mesh.boundary("cut:0").tolist()
    centre = np.flatnonzero((mesh.nodes[:, :2] == (1, 1)).all(axis=1))
    assert len(centre) == 4


def test_severed_sheet_names_its_parts():
    sheet = kg.Sheet(box(0, 0, 2, 1), [LineString([(0.5, 0.2), (0.5, 0.4)]), LineString([(1.5, 0), (1.5, 1)])])
    with pytest.raises(kg.GeometryError, match=r"2 parts:\s+part 1: x 0 to 1.5, .*area 1.5.*\s+part 2: .*cut 1"):
        sheet.mesh(0.2)
    mesh = sheet.mesh(0.2, allow_parts=True)
    assert sorted(np.bincount(mesh.facet_parts, mesh.facet_areas)) == pytest.approx([0.5, 1.5])
    assert [cut.members for cut in mesh.cuts] == [(0,), (1,)]
    assert shapely.Polygon(mesh.nodes[mesh.cuts[1].loop, :2]).area == pytest.approx(0.0, abs=1e-12)


def test_ring_slit_cuts_out_a_part():
    sheet = kg.Sheet(box(0, 0, 1, 1), shapely.Point(0.5, 0.5).buffer(0.2).exterior)
    with pytest.raises(kg.GeometryError, match="2 parts"):
        sheet.mesh(0.1)
    assert len(sheet.mesh(0.1, allow_parts=True).boundary_loops) == 3


def test_lines_become_edges_and_sets():
    line = LineString([(0, 0.3), (2, 0.3)])
    mesh = kg.Sheet(box(0, 0, 2, 2), LineString([(1, 0.1), (1, 1)])).mesh(0.2, lines={"grip": line})
    on_line = np.flatnonzero(np.abs(mesh.nodes[:, 1] - 0.3) < 1e-9)
    assert mesh.boundary("grip").tolist() == on_line.tolist()
    along = np.isin(mesh.edges, on_line).all(axis=1)
    assert mesh.edge_lengths[along].sum() == pytest.approx(2.0)
    assert len(mesh.cuts) == 1
    assert mesh.facet_parts.max() == 0
    with pytest.raises(kg.GeometryError, match="'far' does not meet"):
        kg.Sheet(box(0, 0, 1, 1)).mesh(0.2, lines={"far": LineString([(3, 0), (4, 0)])})


def test_same_drawing_gives_same_mesh():
    first, second = (SHEETS["crossing"][0].mesh(0.15) for _ in range(2))
    assert (first.nodes == second.nodes).all()
    assert (first.triangles == second.triangles).all()


@pytest.mark.parametrize("factor", [1e-3, 1000.0, 0.0254])
@pytest.mark.parametrize("name", ["arcs", "disc", "random"])
def test_unit_of_length_does_not_matter(name, factor):
    sheet = SHEETS[name][0]

    def scale(points: np.ndarray) -> np.ndarray:
        return factor * points

    scaled = kg.Sheet(shapely.transform(sheet.outline, scale), [shapely.transform(cut, scale) for cut in sheet.cuts])
    here, there = sheet.mesh(0.2), scaled.mesh(0.2 * factor)
    assert (here.triangles == there.triangles).all()
    assert np.abs(there.nodes - factor * here.nodes).max() < 1e-11 * factor


def test_cut_edge_sets_the_length_along_cuts():
    sheet = SHEETS["slit"][0]
    fine, coarse = sheet.mesh(0.2, cut_edge=0.02), sheet.mesh(0.2, cut_edge=0.2)
    assert len(fine.cuts[0].loop) == 2 * 50
    assert len(coarse.cuts[0].loop) == 2 * 5
    lengths = fine.edge_lengths
    distance = shapely.distance(sheet.cuts[0], shapely.points(fine.nodes[fine.edges, :2].mean(axis=1)))
    assert np.median(lengths[distance > 0.7]) > 5 * np.median(lengths[distance < 0.03])


def test_thickness_and_material_are_handed_on():
    material = kg.Material(1e9)
    mesh = kg.Sheet([(0, 0), (1, 0), (1, 1)], thickness=0.001, material=material).mesh(0.5)
    assert (mesh.thickness, mesh.material) == (0.001, material)


def test_cuts_of_any_nesting_are_numbered_in_order():
    one, two, three = (LineString([(x, 0.2), (x, 0.8)]) for x in (0.2, 0.4, 0.6))
    nested = [
        shapely.MultiLineString([one, two]),
        [shapely.GeometryCollection([box(0.8, 0.2, 0.9, 0.3)]), [(0.6, 0.2), (0.6, 0.8)]],
    ]
    sheet = kg.Sheet(box(0, 0, 1, 1), nested)
    assert [cut.geom_type for cut in sheet.cuts] == ["LineString", "LineString", "Polygon", "LineString"]
    assert sheet.cuts[3].equals(three)
    assert repr(sheet) == "Sheet(1 x 1, area 0.99, 3 slits, 1 opening)"


def test_short_slit_opens():
    mesh = kg.Sheet(box(0, 0, 1, 1), LineString([(0.5, 0.5), (0.52, 0.5)])).mesh(0.2)
    assert len(mesh.boundary_loops) == 2
    assert len(mesh.cuts[0].loop) == 4


def test_thousand_slits():
    slits = kg.cuts.random_slits(1000, 1, 1, (0.008, 0.03), seed=3, gap=0.003)
    mesh = kg.Sheet(box(0, 0, 1, 1), slits).mesh(0.05, cut_edge=0.015)
    assert len(mesh.cuts) == 1000
    assert len(mesh.edges) - len(mesh.triangles) - len(mesh.nodes) == 999
    assert mesh.min_angle >= 20


@pytest.mark.parametrize("seed", range(10))
def test_random_crossing_slits_merge_into_a_connected_sheet(seed):
    slits = kg.cuts.random_slits(25, 1, 1, (0.1, 0.4), seed=seed, gap=0.02, crossing=True)
    mesh = kg.Sheet(box(0, 0, 1, 1), slits).mesh(0.1)
    assert len(mesh.cuts) < 25
    assert mesh.facet_areas.sum() == pytest.approx(1.0, rel=1e-10)
    assert len(mesh.edges) - len(mesh.triangles) - len(mesh.nodes) == len(mesh.cuts) - 1
    assert mesh.min_angle >= 20
