"""Open area against closed forms of plane geometry."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import LineString, box

import kirigami as kg
from kirigami.geometry.mesh import CutLoop
from kirigami.post.opening import open_area
from kirigami.results.cut_edges import CutEdges

LENS = np.column_stack([np.cos(np.linspace(0, 2 * np.pi, 41)[:-1]), 0.1 * np.sin(np.linspace(0, 2 * np.pi, 41)[:-1])])


def lens_area(a: float, b: float, corners: int = 40) -> float:
    """Area of the polygon inscribed in an ellipse at equal steps of the eccentric angle."""
    return 0.5 * corners * a * b * np.sin(2 * np.pi / corners)


def rotation(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def framed_hole(hole: np.ndarray) -> kg.TriMesh:
    """A square frame of side 4 round a convex polygon, with one outer node for each corner of the polygon."""
    count = len(hole)
    around = (4.0 * np.arange(count) / count + 0.5) % 4.0  # outer node k lies in the direction of corner k
    side, along = around.astype(int), 4 * (around % 1.0) - 2
    two = np.full(count, 2.0)
    outer = np.choose(side[None], [[two, along], [-along, two], [-two, -along], [along, -two]]).T
    ring = np.arange(count)
    after = np.roll(ring, -1)
    facets = [*zip(ring, ring + count, after), *zip(after, ring + count, after + count)]
    return kg.TriMesh(np.vstack([hole, outer]), np.array(facets))


def test_polygon_area_is_exact() -> None:
    area = open_area(LENS[None], [np.arange(40)])
    assert area.shape == (1, 1)
    assert area[0, 0] == pytest.approx(lens_area(1.0, 0.1), rel=1e-12)


def test_area_of_a_mesh_at_rest_is_the_area_of_the_drawn_hole() -> None:
    mesh = framed_hole(LENS)
    positions = mesh.nodes[None] * np.array([[[1.0]], [[2.0]]])
    assert open_area(positions, mesh.cuts)[:, 0] == pytest.approx([lens_area(1, 0.1), 4 * lens_area(1, 0.1)], rel=1e-12)
    assert 16 - mesh.facet_areas.sum() == pytest.approx(lens_area(1, 0.1), rel=1e-10)


@pytest.mark.parametrize("union", [False, True])
def test_zero_width_slit_is_closed(union: bool) -> None:
    arc = np.column_stack([np.linspace(0, 1, 14), 0.2 * np.sin(np.pi * np.linspace(0, 1, 14))])
    lips = np.vstack([arc, arc[-2:0:-1]])  # along the one lip and back along the other
    assert np.abs(open_area(lips[None] @ rotation(0.3).T, [np.arange(len(lips))], union=union)).max() < 1e-12


@pytest.mark.parametrize("union", [False, True])
def test_invariant_under_motion_in_the_plane_and_height(union: bool) -> None:
    rng = np.random.default_rng(1)
    points = np.column_stack([LENS, rng.normal(size=40)])
    moved = points.copy()
    moved[:, :2] = points[:, :2] @ rotation(1.1).T + (30.0, -20.0)
    moved[:, 2] += rng.normal(size=40)
    area = open_area([points, moved], [np.arange(40)], union=union)
    assert area[1] == pytest.approx(area[0], rel=1e-12)


def test_projection_of_a_tilted_opening() -> None:
    tilted = np.column_stack([LENS[:, 0], LENS[:, 1] * np.cos(0.7), LENS[:, 1] * np.sin(0.7)])
    assert open_area(tilted, [np.arange(40)])[0] == pytest.approx(lens_area(1.0, 0.1) * np.cos(0.7), rel=1e-12)


def test_lips_that_overlap_count_negative_but_not_in_the_union() -> None:
    # A figure of eight: a triangle of area 1, then one of area 1/4, run round clockwise and counter-clockwise.
    first, second = [(0.0, 0.0), (2.0, -1.0), (2.0, 0.0)], [(0.0, 0.0), (-1.0, -0.5), (-1.0, 0.0)]
    overlapped, open_twice = np.array(first + second), np.array(first + second[:1] + second[:0:-1])
    loop = [np.arange(6)]
    assert open_area(overlapped, loop)[0] == pytest.approx(1 - 0.25, rel=1e-12)
    assert open_area(overlapped, loop, union=True) == pytest.approx(1.0, rel=1e-12)
    assert open_area(open_twice, loop)[0] == pytest.approx(1 + 0.25, rel=1e-12)
    assert open_area(open_twice, loop, union=True) == pytest.approx(1 + 0.25, rel=1e-12)


def test_openings_that_overlap_count_once() -> None:
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    points = np.vstack([square, square + (0.5, 0.0)])
    loops = [np.arange(4), np.arange(4, 8)]
    assert open_area(points, loops).tolist() == [1.0, 1.0]
    assert open_area(points, loops, union=True) == pytest.approx(1.5, rel=1e-12)


def test_an_open_cut_is_closed_by_its_mouth() -> None:
    notch = np.array([(0.0, 0.0), (1.0, 0.5), (0.0, 1.0)])
    cut = CutLoop(np.array([2, 0, 1]), (0,), open=True)
    assert open_area(notch, [cut]).tolist() == [0.5]


def test_results_know_their_open_area() -> None:
    """A sheet stretched affinely opens its hole affinely."""
    mesh = framed_hole(LENS)
    m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9), dim=2)
    inner = m.nodes[:40]
    m.add(kg.Prescribe(inner, x=0.5 * mesh.nodes[:40, 0]), kg.Fix(inner, "y"))
    outer = m.select(boundary="outer")
    m.add(kg.Fix(outer[1:]), kg.Fix(outer[0], "x"))
    res = kg.LoadControl(m, targets=[0.5]).run()
    assert res.open_area()[:, 0] == pytest.approx(lens_area(1, 0.1) * (1 + 0.5 * res.lam), rel=1e-12)
    assert res.open_area(union=True) == pytest.approx(res.open_area()[:, 0], rel=1e-12)


def pulled_slit(nodes: int, stiffness: str = "shell") -> kg.Results:
    """A slit sheet pulled in its plane, linear."""
    sheet = kg.Sheet(box(0, 0, 1, 1), LineString([(0.25, 0.5), (0.75, 0.5)]), 0.01, kg.Material(1e6))
    m = kg.Model.from_mesh(sheet.mesh(nodes=nodes), stiffness=stiffness)
    top = m.select(boundary="top")
    m.add(kg.Fix(m.nodes, "z"), kg.Fix(m.select(boundary="bottom"), "xy"), kg.Prescribe(top, x=0, y=1e-3))
    return kg.LinearStatic(m).run()


def test_lips_of_shell_facets_are_curves() -> None:
    """Their opening is a third of the way off, or less, that its chords are; both converge to the same."""
    coarse, fine = pulled_slit(150), pulled_slit(800)
    chords = [open_area(res.position(), res.mesh.cuts)[-1, 0] for res in (coarse, fine)]
    curves = [res.open_area()[-1, 0] for res in (coarse, fine)]
    limit = curves[1] + (curves[1] - curves[0]) / (len(fine.rest) / len(coarse.rest) - 1)  # errors go with h^2
    assert abs(curves[0] / limit - 1) < 0.5 * abs(chords[0] / limit - 1) < 0.02
    assert abs(curves[1] / chords[1] - 1) < 0.25 * abs(curves[0] / chords[0] - 1)
    assert coarse.open_area(union=True) == pytest.approx(coarse.open_area()[:, 0], rel=1e-12)
    assert abs(curves[0] / limit - 1) < coarse.error["open_area"][-1] < 5 * abs(curves[0] / limit - 1)


def test_area_within_parabolas() -> None:
    """2/3 of bulge times chord beyond each chord; the derivative is that of differences."""
    square = np.array([(0.0, 0), (1, 0), (1, 1), (0, 1)])
    rows = np.concatenate([square, [(0, -0.3), (0.2, 0), (0, 0.1)]])
    edges = CutEdges(np.arange(4), np.array([1, 2, 3, 0]), np.array([4, 5, 6, -1]))
    area, rate = edges.area(rows)
    assert area == pytest.approx(1 + 2 / 3 * (0.3 + 0.2 + 0.1), rel=1e-14)
    for place in np.ndindex(*rows.shape):
        sides = [edges.area(rows + sign * 1e-6 * (np.arange(14).reshape(7, 2) == np.ravel_multi_index(place, (7, 2))))
                 for sign in (1, -1)]  # fmt: skip
        assert (sides[0][0] - sides[1][0]) / 2e-6 == pytest.approx(rate[place], abs=1e-9)


@pytest.mark.parametrize(
    ("positions", "cuts", "complaint"),
    [
        (np.zeros((3, 4, 4)), [], "shape"),
        (np.full((1, 3, 3), np.nan), [], "finite"),
        (np.zeros((1, 3, 3)), [[0, 1, 3]], "cut 0"),
        (np.zeros((1, 3, 3)), [[0, 1, 2], [0, 1]], "cut 1"),
    ],
)
def test_bad_input_is_named(positions: np.ndarray, cuts: list[list[int]], complaint: str) -> None:
    with pytest.raises(kg.ModelError, match=complaint):
        open_area(positions, cuts)
