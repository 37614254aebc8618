"""The package's own mesh generator beside Triangle: the same cuts, areas and parts, sound angles, one mechanics."""

from __future__ import annotations

import subprocess
import sys
import warnings
from fractions import Fraction

import numpy as np
import pytest
import shapely
import test_mesher_fuzz
from test_sheet import SHEETS

import kirigami as kg
from kirigami.geometry import triangulate as generators
from kirigami.geometry.clean import clean
from kirigami.geometry.delaunay import constrained, in_circle, turn


@pytest.mark.parametrize("name", SHEETS)
def test_both_make_the_same_sheet(name):
    sheet, holes, open_cuts = SHEETS[name]
    max_edge = 0.06 if name == "random" else 0.12
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        one, other = (sheet.mesh(max_edge, mesher=mesher) for mesher in generators.MESHERS)
    assert other.facet_areas.sum() == pytest.approx(sheet.area, rel=1e-10)
    assert [cut.members for cut in other.cuts] == [cut.members for cut in one.cuts]
    assert sum(cut.open for cut in other.cuts) == open_cuts
    assert len(other.boundary_loops) == 1 + holes
    assert len(other.edges) - len(other.triangles) - len(other.nodes) == holes - 1
    assert other.facet_parts.max() == 0
    assert other.min_angle >= min(27.9, one.min_angle)  # 28 is asked for; the drawing may have sharper corners
    assert other.edge_lengths.max() <= 1.1 * max_edge
    assert len(other.nodes) == pytest.approx(len(one.nodes), rel=0.05)
    for side in ("left", "right", "bottom", "top"):
        along = [mesh.nodes[mesh.boundary(side)] for mesh in (one, other)]
        assert np.ptp(along[1][:, 0 if side in ("left", "right") else 1]) == 0
        assert np.array_equal(along[0].min(axis=0), along[1].min(axis=0))  # from end to end
        assert np.array_equal(along[0].max(axis=0), along[1].max(axis=0))
    for cut in other.cuts:
        drawn = shapely.union_all([sheet.cuts[number] for number in cut.members])
        assert shapely.distance(shapely.points(other.nodes[cut.loop, :2]), drawn).max() < 1e-9


def test_parts_lines_and_regions_are_the_same():
    sheet = kg.Sheet(
        shapely.box(0, 0, 2, 1), [[(1.2, 0), (1.2, 1)]], regions={"patch": shapely.box(0.2, 0.2, 0.7, 0.6)},
        folds=[[(0.9, 0), (0.9, 1)]],
    )  # fmt: skip
    lines = {"grip": shapely.LineString([(0, 0.8), (2, 0.8)])}
    one, other = (sheet.mesh(0.15, lines=lines, allow_parts=True, mesher=mesher) for mesher in generators.MESHERS)
    for mesh in (one, other):
        assert np.sort(np.bincount(mesh.facet_parts, mesh.facet_areas)) == pytest.approx([0.8, 1.2])
        assert mesh.facet_areas[mesh.regions["patch"]].sum() == pytest.approx(0.2)
        assert np.abs(mesh.nodes[mesh.boundary("grip"), 1] - 0.8).max() < 1e-12
        begin, end = mesh.nodes[mesh.folds[0].edges].swapaxes(0, 1)
        assert np.linalg.norm(end - begin, axis=1).sum() == pytest.approx(1.0)


@pytest.mark.parametrize("seed", range(3))
def test_signs_are_exact(seed):
    """Points on a line and on a circle, moved by a few of the smallest steps that numbers can make."""
    random = np.random.default_rng(seed)
    for _ in range(200):
        a, b = random.random((2, 2))
        c = a + random.random() * (b - a) + random.integers(-2, 3, 2) * 2.0**-53
        exact = [tuple(map(Fraction, point)) for point in (a.tolist(), b.tolist(), c.tolist())]
        doubled = (exact[1][0] - exact[0][0]) * (exact[2][1] - exact[0][1]) - (exact[1][1] - exact[0][1]) * (
            exact[2][0] - exact[0][0]
        )
        assert np.sign(turn(tuple(a), tuple(b), tuple(c))) == (doubled > 0) - (doubled < 0)
        angles = np.sort(random.random(4)) * 2 * np.pi
        four = (1.0 + np.column_stack([np.cos(angles), np.sin(angles)])) + random.integers(-1, 2, (4, 2)) * 2.0**-52
        pairs = [(Fraction(x), Fraction(y)) for x, y in four.tolist()]
        matrix = [[x, y, x**2 + y**2, Fraction(1)] for x, y in pairs]
        assert in_circle(*map(tuple, four.tolist())) == (_determinant(matrix) > 0)


def _determinant(rows: list[list[Fraction]]) -> Fraction:
    if len(rows) == 1:
        return rows[0][0]
    minors = ([row[:k] + row[k + 1 :] for row in rows[1:]] for k in range(len(rows)))
    return sum(((-1) ** k * rows[0][k] * _determinant(minor) for k, minor in enumerate(minors)), Fraction(0))


@pytest.mark.parametrize("spread", [1.0, 1e-11])
def test_no_circle_holds_a_point_and_no_point_is_lost(spread):
    """Random points, points of a grid, whose circles hold four, and a cluster closer than Qhull can tell apart."""
    random = np.random.default_rng(3)
    grid = np.stack(np.meshgrid(np.arange(8) / 8, np.arange(8) / 8), axis=-1).reshape(-1, 2)
    points = np.concatenate([random.random((40, 2)), grid, 0.53 + spread * random.random((30, 2))])
    triangles, _ = constrained(points, np.empty((0, 2), int))
    assert set(triangles.ravel()) == set(range(len(points)))
    corners = points[triangles]
    for triangle, nodes in zip(corners.tolist(), triangles.tolist(), strict=True):
        assert turn(*triangle) > 0
        if spread == 1.0:
            assert not any(in_circle(*triangle, point) for k, point in enumerate(points.tolist()) if k not in nodes)
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    hull = shapely.MultiPoint(points).convex_hull.area
    assert 0.5 * (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]).sum() == pytest.approx(hull, rel=1e-12)


def test_segments_are_edges_and_split_where_a_point_lies_on_them():
    random = np.random.default_rng(5)
    points = np.concatenate([random.random((300, 2)), [(0.0, 0.0), (1.0, 1.0), (0.5, 0.5)]])
    triangles, chains = constrained(points, np.array([(300, 301)]))
    assert chains == [[300, 302, 301]]
    pairs = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1).tolist()
    assert [300, 302] in pairs
    assert [301, 302] in pairs
    with pytest.raises(kg.GeometryError, match="two lines of the drawing cross"):
        constrained(np.array([(0.0, 0.0), (2.0, 2.0), (0.0, 2.0), (2.0, 0.1)]), np.array([(0, 1), (2, 3)]))
    with pytest.raises(kg.GeometryError, match="two points of the drawing are one"):
        constrained(np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 0.0)]), np.array([(0, 1)]))


@pytest.mark.parametrize("angle", [1.0, 10.0])
def test_a_sharp_corner_does_not_run_on(angle):
    """What the drawing makes sharp stays sharp, and costs no more points than Triangle spends on it."""
    tip = shapely.Polygon([(0, 0), (1, 0), (1, np.tan(np.radians(angle)))])
    meshes = []
    for mesher in generators.MESHERS:
        with pytest.warns(kg.KirigamiWarning, match="the drawing has a sharp corner"):
            meshes.append(kg.Sheet(tip).mesh(0.2, mesher=mesher))
    one, other = meshes
    assert other.facet_areas.sum() == pytest.approx(tip.area, rel=1e-10)
    assert (other.facet_min_angles < 20).sum() <= (one.facet_min_angles < 20).sum() + 1
    assert len(other.nodes) < 1.5 * len(one.nodes)


def test_drawings_full_of_coincidences(monkeypatch):
    monkeypatch.setenv("KIRIGAMI_MESHER", "delaunay")
    assert test_mesher_fuzz.survey(23, 3).split()[0] != "0"


@pytest.mark.long
def test_many_drawings_full_of_coincidences(monkeypatch):
    monkeypatch.setenv("KIRIGAMI_MESHER", "delaunay")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        meshes, errors = (int(part.split()[0]) for part in test_mesher_fuzz.survey(0, 120).split(","))
    assert meshes + errors == 120
    assert min(meshes, errors) > 4


def test_which_one_is_taken(monkeypatch):
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1))
    assert clean(sheet.outline).mesher == "triangle"
    monkeypatch.setenv("KIRIGAMI_MESHER", "delaunay")
    assert clean(sheet.outline).mesher == "delaunay"
    assert clean(sheet.outline, mesher="triangle").mesher == "triangle"
    monkeypatch.delenv("KIRIGAMI_MESHER")
    monkeypatch.setattr(generators.importlib.util, "find_spec", lambda name: None)
    assert clean(sheet.outline).mesher == "delaunay"
    with pytest.raises(kg.GeometryError, match="needs the package triangle.*or use \"delaunay\""):
        sheet.mesh(0.2, mesher="triangle")
    with pytest.raises(kg.GeometryError, match="mesher must be one of 'triangle', 'delaunay', got 'netgen'"):
        sheet.mesh(0.2, mesher="netgen")


def test_nothing_needs_triangle():
    """In a process in which the package triangle cannot be imported."""
    code = (
        "import sys; sys.modules['triangle'] = None\n"
        "import shapely, kirigami as kg\n"
        "sheet = kg.Sheet(shapely.box(0, 0, 1, 1), [[(0.2, 0.5), (0.8, 0.5)]])\n"
        "assert len(sheet.mesh(0.3, mesher='delaunay').cuts) == 1"
    )
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-800:]


@pytest.mark.long
@pytest.mark.parametrize("pattern", ["slits", "staggered"])
def test_forces_agree_within_the_error_bar(pattern, monkeypatch):
    """A sheet by both on the trusted rung: apart by no more than what their error estimates say together."""
    cuts = {
        "slits": [[(0.02, y), (0.08, y)] for y in (0.03, 0.05, 0.07)],
        "staggered": kg.cuts.parallel_slits(columns=2, rows=4, width=0.1, height=0.06, length=0.03, margin=0.02),
    }[pattern]
    film = kg.Material(E=3.5e9, nu=0.34)
    sheet = kg.Sheet(shapely.box(0, 0, 0.1, 0.1), cuts, thickness=0.2e-3, material=film)
    found = []
    for mesher in generators.MESHERS:
        monkeypatch.setenv("KIRIGAMI_MESHER", mesher)
        results = kg.stretch(sheet, strain=0.005, nodes=800)
        found.append((results.drives[0].force(results)[-1], results.error["force"][-1]))
    (one, bar), (other, its_bar) = found
    print(f"{pattern}: {one:.4g} +- {100 * bar:.2f} %, {other:.4g} +- {100 * its_bar:.2f} %")
    assert other == pytest.approx(one, rel=bar + its_bar)
