"""Drawings as they come: what is repaired with a warning, what is refused, and that the message says where."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import LineString, Polygon, box

import kirigami as kg

SQUARE = box(0, 0, 1, 1)


def slit(x0: float, y0: float, x1: float, y1: float) -> LineString:
    return LineString([(x0, y0), (x1, y1)])


@pytest.mark.parametrize(
    ("outline", "cuts", "message"),
    [
        ([(0, 0), (1, 1), (1, 0), (0, 1)], (), r"Self-intersection\[0.5 0.5\]"),
        ([(0, 0), (1, 0), (2, 0)], (), "outline"),
        ([(0, 0), (1, 0)], (), "three"),
        ([(0, 0), (np.nan, 1), (1, 0)], (), "not finite: point 1"),
        (shapely.MultiPolygon([SQUARE, box(2, 0, 3, 1)]), (), "MultiPolygon of 2 parts"),
        (SQUARE, shapely.Point(0.5, 0.5), "cut 0 is a Point"),
        (SQUARE, [slit(0.2, 0.2, 0.8, 0.2), LineString([(0.2, 0.5), (np.inf, 0.5)])], "cut 1 .* not finite"),
        (SQUARE, Polygon([(0.2, 0.2), (0.6, 0.6), (0.6, 0.2), (0.2, 0.6)]), r"cut 0 .*Self-intersection\[0.4 0.4\]"),
        (SQUARE, 3, "int"),
        (SQUARE, [[(0.2, 0.2)]], "two points"),
    ],
)
def test_shapes_that_are_none(outline, cuts, message):
    with pytest.raises(kg.GeometryError, match=message):
        kg.Sheet(outline, cuts)


@pytest.mark.parametrize(
    ("cuts", "message"),
    [
        ([slit(3, 0.5, 4, 0.5)], r"cut 0 near \(3, 0.5\) lies outside .* x 0 to 1"),
        ([slit(0.2, 0.5, 0.8, 0.5), box(2, 2, 3, 3)], "cut 1 .* outside"),
        ([box(1, 0.2, 1.5, 0.7)], "cut 0 .* along the outline"),
        ([slit(0.2, 0.5, 2e9, 0.5)], "cut 0 .* another unit"),
        ([box(-1, -1, 2, 2)], "nothing of the sheet is left"),
        ([slit(0, 0.5, 1, 0.5)], "2 parts"),
        ([slit(-1, 0.5, 2, 0.5), slit(0.5, -1, 0.5, 2)], "4 parts"),
        ([LineString([(0.2, 0.2), (0.8, 0.2), (0.5, 0.8), (0.2, 0.2)])], "area 0.18, along cut 0"),
        ([slit(0, 0.5, 0.5, 0.5), slit(0.5, 0.5 + 1e-7, 1, 0.5)], "2 parts"),
    ],
)
@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
def test_cuts_that_cannot_be_made(cuts, message):
    with pytest.raises(kg.GeometryError, match=message):
        kg.Sheet(SQUARE, cuts).mesh(0.2)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"max_edge": 0}, "max_edge"),
        ({"max_edge": -1}, "max_edge"),
        ({"max_edge": np.nan}, "max_edge"),
        ({"max_edge": 0.1, "cut_edge": 0}, "cut_edge"),
        ({"max_edge": 1e-4}, "facets"),
        ({"max_edge": 0.1, "cut_edge": 1e-6}, "facets"),
        ({"max_edge": 0.1, "min_angle": 40}, "min_angle"),
        ({"max_edge": 0.1, "snap": 0.5}, "snapped"),
    ],
)
def test_sizes_that_make_no_mesh(arguments, message):
    with pytest.raises(kg.GeometryError, match=message):
        kg.Sheet(SQUARE, slit(0.2, 0.5, 0.8, 0.5)).mesh(**arguments)


def test_edges_longer_than_the_sheet_are_allowed():
    assert kg.Sheet(SQUARE).mesh(100.0).facet_areas.sum() == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("cuts", "warning", "records", "area"),
    [
        ([slit(0.2, 0.5, 0.6, 0.5), slit(0.6, 0.5, 0.2, 0.5)], "cuts 0, 1 are drawn on top", [(0, 1)], 1.0),
        ([slit(0.2, 0.5, 0.6, 0.5), slit(0.4, 0.5, 0.8, 0.5)], "cuts 0, 1 are drawn on top", [(0, 1)], 1.0),
        ([box(0.2, 0.2, 0.4, 0.4), box(0.4, 0.2, 0.6, 0.4)], "cuts 0, 1 are holes that touch", [(0, 1)], 0.92),
        ([box(0.2, 0.2, 0.5, 0.4), box(0.4, 0.3, 0.6, 0.5)], "cuts 0, 1 are holes that touch", [(0, 1)], 0.91),
        ([box(0.2, 0.2, 0.4, 0.4), box(0.4, 0.4, 0.6, 0.6)], "cuts 0, 1 are holes that touch", [(0, 1)], 0.92),
        ([box(0.2, 0.2, 0.4, 0.4), slit(0.25, 0.3, 0.35, 0.3)], "cut 1 is inside a hole", [(0,)], 0.96),
        ([box(0.2, 0.2, 0.4, 0.4), slit(0.2, 0.25, 0.2, 0.35)], "cut 1 is inside a hole", [(0, 1)], 0.96),
        ([slit(-0.5, 0.5, 0.5, 0.5)], "cut 0 is drawn beyond", [(0,)], 1.0),
        ([slit(0, 0.2, 0, 0.7)], "cut 0 is drawn along the outline", [(0,)], 1.0),
        ([box(0.2, 0.2, 0.4, 0.4), slit(0.3, 0.3, 0.6, 0.3)], "cut 1 is drawn beyond", [(0, 1)], 0.96),
        ([box(0.2, 0.5, 0.8, 0.5 + 1e-9)], "cut 0 is narrower", [(0,)], 1.0),
        ([slit(0.2, 0.5, 0.2 + 1e-9, 0.5), slit(0.4, 0.5, 0.6, 0.5)], "cut 0 is smaller", [(1,)], 1.0),
    ],
)
def test_repairs_with_a_warning(cuts, warning, records, area):
    with pytest.warns(kg.KirigamiWarning, match=warning) as caught:
        mesh = kg.Sheet(SQUARE, cuts).mesh(0.2)
    assert all(entry.filename == __file__ for entry in caught)
    assert [cut.members for cut in mesh.cuts] == records
    assert mesh.facet_areas.sum() == pytest.approx(area, rel=1e-8)
    assert mesh.min_angle >= 20


@pytest.mark.parametrize("miss", [-1e-6, -1e-12, 0.0, 1e-12, 1e-6])
def test_ends_that_nearly_touch_are_joined(miss):
    """A slit that stops short of the outline, or passes it, by less than the tolerance: the outline stays straight."""
    mesh = kg.Sheet(SQUARE, slit(miss, 0.5, 0.5, 0.5)).mesh(0.2)
    assert len(mesh.boundary_loops) == 1
    assert mesh.cuts[0].open
    assert mesh.nodes[:, 0].min() == 0.0
    assert np.count_nonzero(mesh.nodes[mesh.boundary("left"), 1] == 0.5) == 2


@pytest.mark.parametrize("miss", [-1e-6, 0.0, 1e-6])
def test_nearly_touching_slits_meet(miss):
    mesh = kg.Sheet(SQUARE, [slit(0.2, 0.5, 0.8, 0.5), slit(0.4, 0.5 + miss, 0.4, 0.8)]).mesh(0.2)
    assert [cut.members for cut in mesh.cuts] == [(0, 1)]


def test_gap_wider_than_the_tolerance_is_kept():
    cuts = [slit(0.2, 0.5, 0.8, 0.5), slit(0.4, 0.504, 0.4, 0.8)]
    mesh = kg.Sheet(SQUARE, cuts).mesh(0.2)
    assert [cut.members for cut in mesh.cuts] == [(0,), (1,)]
    assert mesh.min_angle >= 20
    assert [cut.members for cut in kg.Sheet(SQUARE, cuts).mesh(0.2, snap=0.01).cuts] == [(0, 1)]


def test_repeated_points_do_no_harm():
    outline = Polygon([(0, 0), (0, 0), (1, 0), (1 + 1e-13, 1e-13), (1, 1), (0, 1), (0, 1)])
    doubled = LineString([(0.2, 0.5), (0.2, 0.5), (0.5, 0.5), (0.5, 0.5 + 1e-14), (0.8, 0.5)])
    mesh = kg.Sheet(outline, doubled).mesh(0.2)
    assert mesh.facet_areas.sum() == pytest.approx(1.0, rel=1e-10)
    assert mesh.min_angle >= 20


def test_dense_curves_are_thinned():
    angle = np.linspace(0, np.pi, 200_001)
    arc = LineString(np.column_stack([0.5 + 0.3 * np.cos(angle), 0.3 + 0.3 * np.sin(angle)]))
    mesh = kg.Sheet(SQUARE, arc).mesh(0.2, cut_edge=0.1)
    assert len(mesh.nodes) < 3_000
    lips = shapely.points(mesh.nodes[mesh.cuts[0].loop, :2])
    assert shapely.distance(lips, arc).max() < 1e-4
    assert mesh.min_angle >= 20


def test_sharp_corner_is_reported_with_its_place():
    with pytest.warns(kg.KirigamiWarning, match=r"smallest angle .* at \(\d"):
        mesh = kg.Sheet([(0, 0), (1, 0), (1, 0.1)]).mesh(0.2)
    assert mesh.min_angle == pytest.approx(np.degrees(np.arctan(0.1)), rel=0.5)


def test_sliver_is_refused_with_its_place():
    cuts = [slit(0.2, 0.5, 0.8, 0.5), slit(0.2, 0.50002, 0.8, 0.50002)]
    with pytest.raises(kg.GeometryError, match=r"sliver .* near \(0\.\d+, 0\.50"):
        kg.Sheet(SQUARE, cuts).mesh(0.1, snap=1e-6)


def test_offset_far_from_the_origin():
    place = np.array([5e5, 4e6])
    sheet = kg.Sheet(shapely.transform(SQUARE, lambda p: p + place), [place + [(0.2, 0.5), (0.8, 0.5)]])
    mesh = sheet.mesh(0.2)
    assert mesh.facet_areas.sum() == pytest.approx(1.0, rel=1e-8)
    assert len(mesh.boundary("bottom")) > 4


def test_heights_are_not_dropped_in_silence():
    """A sheet is flat: coordinates with heights of their own are refused, a plane above zero is told."""
    flat = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
    assert kg.Sheet(flat).area == 0.5
    with pytest.warns(kg.KirigamiWarning, match="the outline lies at z = 2; the sheet is taken at z = 0"):
        kg.Sheet([(x, y, 2) for x, y, _ in flat])
    with pytest.raises(kg.GeometryError, match="the outline leaves the plane: z runs from 0 to 1"):
        kg.Sheet([(0, 0, 0), (1, 0, 1), (1, 1, 0)])
    with pytest.raises(kg.GeometryError, match="cut 0 leaves the plane: z runs from 0 to 3"):
        kg.Sheet(flat, [[(0.5, 0.2, 0), (0.8, 0.4, 3)]])
