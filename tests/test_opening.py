"""Open area against closed forms of plane geometry."""

from __future__ import annotations

import numpy as np
import pytest

import kirigami as kg
from kirigami.geometry.mesh import CutLoop
from kirigami.post.opening import open_area

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
