"""Pattern generators against their formulas and against the outlines of the published example."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely import box

import kirigami as kg

DATA = Path(__file__).parents[1] / "data"


@pytest.mark.parametrize(("across", "along"), [(2, 5), (5, 10), (5, 15), (10, 10)])
def test_curved_cells_count_length_and_spacing(across, along):
    cuts = kg.cuts.curved_cells(across, along, width=2.0, height=2.0)
    gap = 2 / (across * (2 + 1))  # Rt = 2 / (Nt (LcRt + 1)) with LcRt = 2
    length, depth = 2 * gap, 2 / (1 + 2 * along)
    boxes = np.array([cut.bounds for cut in cuts])
    widths, rises = boxes[:, 2] - boxes[:, 0], boxes[:, 3] - boxes[:, 1]
    assert len(cuts) == along * across + (along + 1) * (across + 1)
    assert rises == pytest.approx(depth)
    half = np.isclose(widths, length / 2)
    assert widths[~half] == pytest.approx(length)
    assert half.sum() == 2 * (along + 1)
    assert set(np.round(boxes[half][:, [0, 2]].ravel(), 12)) == {
        0.0,
        round(length / 2, 12),
        round(2 - length / 2, 12),
        2.0,
    }
    row = boxes[np.isclose(boxes[:, 1], 0.2 + depth)]  # lowest row of arcs that are bent up
    assert len(row) == across
    assert row[1:, 0] - row[:-1, 2] == pytest.approx(gap)
    assert (boxes[:, 1].min(), boxes[:, 3].max()) == pytest.approx((0.2, 2.2))


def test_curved_cells_against_the_published_example():
    """Every boundary node of the published mesh lies on a generated outline, and the areas agree."""
    with np.load(DATA / "seed_S2.npz") as data:
        published = kg.TriMesh(data["nodes"][:, :2], data["triangles"])
    sheet = kg.Sheet(box(0, 0, 2, 2.4), kg.cuts.curved_cells(2, 5, opening=0.005))
    outlines = shapely.union_all([sheet.outline.boundary, *(cut.boundary for cut in sheet.cuts)])
    boundary = shapely.points(published.nodes[published.boundary("free"), :2])
    assert shapely.distance(boundary, outlines).max() < 1e-12
    assert sheet.area == pytest.approx(published.facet_areas.sum(), rel=1e-12)
    assert len(published.cuts) == 16 == sum(not cut.open for cut in sheet.mesh(0.1).cuts)


@pytest.mark.parametrize(("across", "along", "nodes"), [(2, 5, 7542), (5, 10, 11581), (5, 15, 14068), (10, 10, 13704)])
def test_node_counts_of_table_1(across, along, nodes):
    """Khawale et al., Table 1, largest edge 0.032; within a quarter."""
    sheet = kg.Sheet(box(0, 0, 2, 2.4), kg.cuts.curved_cells(across, along, opening=0.005))
    assert len(sheet.mesh(0.032, cut_edge=0.032).nodes) == pytest.approx(nodes, rel=0.25)


def test_curved_cells_are_symmetric():
    cuts = kg.cuts.curved_cells(3, 4, width=3.0, height=1.5, margin=0.1)
    mirrored = shapely.union_all([shapely.transform(cut, lambda p: (3.0, 0.0) + p * (-1.0, 1.0)) for cut in cuts])
    assert shapely.hausdorff_distance(mirrored, shapely.union_all(cuts)) < 1e-12


def test_openings_have_their_area():
    cuts = kg.cuts.curved_cells(2, 5, opening=0.005)
    widths = [cut.bounds[2] - cut.bounds[0] for cut in cuts]
    assert [cut.area for cut in cuts] == pytest.approx([0.005 * width for width in widths])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"length_ratio": 1.0}, "touch at"),
        ({"length_ratio": 50.0, "depth_ratio": 8.0}, "touch at"),
        ({"opening": 0.3}, "touch at"),
        ({"cells_across": 0}, "cells_across"),
        ({"cells_along": 2.5}, "cells_along"),
        ({"width": -1.0}, "width"),
        ({"margin": -0.1}, "margin"),
        ({"points": 4}, "odd"),
    ],
)
def test_curved_cells_refuse_what_has_no_meaning(arguments, message):
    with pytest.raises(kg.GeometryError, match=message):
        kg.cuts.curved_cells(**arguments)


def test_parallel_slits():
    cuts = kg.cuts.parallel_slits(columns=2, rows=4, width=2.0, height=1.0, length=0.7, margin=0.1)
    assert [len([c for c in cuts if np.isclose(c.bounds[1], 0.1 + 0.125 + 0.25 * row)]) for row in range(4)] == [
        2,
        3,
        2,
        3,
    ]
    assert sorted({round(cut.length, 12) for cut in cuts}) == [0.35, 0.7]
    mesh = kg.Sheet(box(0, 0, 2, 1.2), cuts).mesh(0.1)
    assert [cut.open for cut in mesh.cuts] == [False, False, True, False, True] * 2
    with pytest.raises(kg.GeometryError, match="touch"):
        kg.cuts.parallel_slits(columns=2, rows=4, width=2.0, length=1.0)
    assert kg.cuts.parallel_slits(rows=1, sides_first=True)[0].bounds[0] == 0.0


def test_perpendicular_slits():
    cuts = kg.cuts.perpendicular_slits(4, 4, cell=1.0, length=1.6)
    assert len(cuts) == 16
    mesh = kg.Sheet(box(0, 0, 4, 4), cuts).mesh(0.4)
    assert mesh.facet_areas.sum() == pytest.approx(16.0)
    assert mesh.facet_parts.max() == 0
    with pytest.raises(kg.GeometryError, match="touch"):
        kg.cuts.perpendicular_slits(4, 4, cell=1.0, length=2.0)


def test_random_slits_keep_their_distance():
    slits = kg.cuts.random_slits(40, 1.0, 2.0, (0.1, 0.2), seed=7, gap=0.03, margin=0.5)
    assert len(slits) == 40
    assert min(a.distance(b) for i, a in enumerate(slits) for b in slits[:i]) >= 0.03
    assert shapely.union_all(slits).within(box(0.03, 0.53, 0.97, 2.47))
    assert all(0.1 <= slit.length <= 0.2 for slit in slits)
    with pytest.raises(kg.GeometryError, match="room for"):
        kg.cuts.random_slits(50, 1.0, 1.0, (0.5, 0.9), seed=1, gap=0.1)


def test_single_slits():
    outline, cuts = kg.cuts.single_slit_disc(radius=3.0, length=2.58, opening=0.1)
    assert outline.area == pytest.approx(np.pi * 9, rel=2e-3)
    assert cuts[0].area == pytest.approx(0.258)
    with pytest.raises(kg.GeometryError, match="fit"):
        kg.cuts.single_slit_disc(radius=1.0, length=2.0)
    outline, cuts = kg.cuts.single_slit_rectangle(2.0, 1.0, 0.5, angle=30.0, opening=0.01)
    assert cuts[0].area == pytest.approx(0.005)
    assert cuts[0].centroid.coords[0] == pytest.approx((1.0, 0.5))
    assert kg.Sheet(outline, cuts).area == pytest.approx(1.995)
    with pytest.raises(kg.GeometryError, match="misses"):
        kg.cuts.single_slit_rectangle(1.0, 1.0, 0.1, centre=(5.0, 5.0))
