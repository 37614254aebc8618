"""TriMesh: what a valid mesh is, its topology, and the names on its boundary."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import kirigami as kg

SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
HALVES = np.array([(0, 1, 2), (0, 2, 3)])


def annulus(inner: float = 1.0, outer: float = 2.0, count: int = 12) -> kg.TriMesh:
    angle = 2 * np.pi * np.arange(count) / count
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    here, there = np.arange(count), (np.arange(count) + 1) % count
    facets = [
        np.column_stack([here, here + count, there + count]),
        np.column_stack([here, there + count, there]),
    ]
    return kg.TriMesh(np.concatenate([inner * ring, outer * ring]), np.concatenate(facets))


def shoelace(mesh: kg.TriMesh, loop: np.ndarray) -> float:
    x, y, _ = mesh.nodes[loop].T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def test_facets_become_counter_clockwise():
    mesh = kg.TriMesh(SQUARE, [(2, 1, 0), (0, 2, 3)])
    assert sorted(map(sorted, mesh.triangles.tolist())) == [[0, 1, 2], [0, 2, 3]]
    a, b, c = mesh.nodes[mesh.triangles].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()


def test_facets_of_a_bulged_sheet_agree_and_face_up():
    flat = annulus()
    bulge = flat.nodes + np.array([0, 0, 1.0]) * (0.4 * np.sin(2 * flat.nodes[:, [0]]))
    mixed = flat.triangles.copy()
    mixed[::3] = mixed[::3, ::-1]
    mesh = kg.TriMesh(bulge, mixed)
    assert (np.sort(mesh.triangles) == np.sort(mixed)).all()
    a, b, c = mesh.nodes[mesh.triangles].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()


def test_edges_and_wings_of_two_facets():
    mesh = kg.TriMesh(SQUARE, HALVES)
    assert mesh.edges.tolist() == [[0, 1], [0, 2], [3, 0], [1, 2], [2, 3]]
    assert mesh.edge_facets.tolist() == [[0, -1], [1, 0], [1, -1], [0, -1], [1, -1]]
    assert mesh.edge_wings.tolist() == [[2, -1], [3, 1], [2, -1], [0, -1], [0, -1]]
    assert mesh.boundary_edges.tolist() == [0, 2, 3, 4]


def test_first_wing_is_left_of_the_edge_and_second_right():
    mesh = annulus()
    (j, k), (i, wing) = mesh.edges.T, mesh.edge_wings.T
    along = mesh.nodes[k] - mesh.nodes[j]
    assert (np.cross(along, mesh.nodes[i] - mesh.nodes[j])[:, 2] > 0).all()
    inner = wing >= 0
    assert (np.cross(along, mesh.nodes[wing] - mesh.nodes[j])[inner, 2] < 0).all()
    assert (j < k)[inner].all()


def test_euler_relation_and_loops_of_an_annulus():
    mesh = annulus()
    assert len(mesh.edges) - len(mesh.triangles) - len(mesh.nodes) == 1 - 1
    outer, inner = mesh.boundary_loops
    assert sorted(outer) == list(range(12, 24))
    assert shoelace(mesh, outer) == pytest.approx(12.0)  # regular dodecagon of circumradius 2: 3 r^2
    assert shoelace(mesh, inner) == pytest.approx(-3.0)
    assert mesh.facet_areas.sum() == pytest.approx(9.0, rel=1e-12)
    (cut,) = mesh.cuts
    assert (cut.members, cut.open) == ((0,), False)
    assert shoelace(mesh, cut.loop) == pytest.approx(3.0)


def test_loop_through_a_node_that_holes_share():
    """Two square holes that share a corner: the sheet round that corner has two fans, so that they are one opening."""
    columns, rows = 5, 4
    grid = np.array([(x, y) for y in range(rows + 1) for x in range(columns + 1)], float)
    facets = []
    for y in range(rows):
        for x in range(columns):
            if (x, y) not in [(1, 1), (2, 2)]:
                a, above = y * (columns + 1) + x, (y + 1) * (columns + 1) + x
                facets += [(a, a + 1, above + 1), (a, above + 1, above)]
    mesh = kg.TriMesh(grid, facets)
    assert [len(loop) for loop in mesh.boundary_loops] == [18, 8]
    assert np.bincount(mesh.cuts[0].loop).max() == 2
    assert shoelace(mesh, mesh.cuts[0].loop) == pytest.approx(2.0)
    steps = mesh.nodes[np.roll(mesh.cuts[0].loop, -1)] - mesh.nodes[mesh.cuts[0].loop]
    assert np.linalg.norm(steps, axis=1) == pytest.approx(1.0)


def test_equilateral_angles():
    assert kg.TriMesh([(0, 0), (1, 0), (0.5, np.sqrt(0.75))], [(0, 1, 2)]).min_angle == pytest.approx(60.0, abs=1e-10)


@pytest.mark.parametrize(
    ("nodes", "triangles", "message"),
    [
        ([*SQUARE[:3], (np.nan, 1)], HALVES, "node 3"),
        (SQUARE, [(0, 1, 4)], "facet 0 .* beyond 0 .. 3"),
        (SQUARE, [(0, 1, 2), (0, 2, -1)], "facet 1 .* beyond"),
        (SQUARE, [(0, 1, 2), (0, 2, 2)], "facet 1 .* twice"),
        ([(0, 0), (1, 0), (2, 0), (0, 1)], [(0, 1, 2), (0, 1, 3)], "facet 0 .* no area"),
        (SQUARE, [*HALVES, (2, 0, 1)], "facet 2 .* given twice"),
        ([*SQUARE, (5, 5)], HALVES, "node 4"),
        ([*SQUARE, (0.5, 2)], [(0, 1, 2), (0, 2, 3), (0, 2, 4)], "belongs to 3 facets"),
        ([(0, 0), (1, 0), (0.5, 1), (0.5, 2)], [(0, 1, 2), (0, 1, 3)], "overlap"),
        (SQUARE, np.array(HALVES, float), "whole numbers"),
        (SQUARE[:, :1], HALVES, "shape"),
    ],
)
def test_invalid_arrays_are_named(nodes, triangles, message):
    with pytest.raises(kg.GeometryError, match=message):
        kg.TriMesh(nodes, triangles)


def test_moebius_band_cannot_be_oriented():
    count = 12
    angle = 2 * np.pi * np.arange(count) / count
    across = np.column_stack([np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)])
    middle = 3 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
    facets = []
    for here in range(count):
        there, turned = (here + 1) % count, here + 1 == count
        a, b = (there + count, there) if turned else (there, there + count)
        facets += [(here, a, b), (here, b, here + count)]
    with pytest.raises(kg.GeometryError, match="one side"):
        kg.TriMesh(np.concatenate([middle - across, middle + across]), facets)


def test_boundary_names():
    mesh = kg.TriMesh(SQUARE, HALVES, sets={"grip": [3, 2, 3]})
    assert mesh.boundary("bottom").tolist() == [0, 1]
    assert mesh.boundary("right").tolist() == [1, 2]
    assert mesh.boundary("outer").tolist() == mesh.boundary("free").tolist() == [0, 1, 2, 3]
    assert mesh.boundary("grip").tolist() == [2, 3]
    with pytest.raises(kg.GeometryError, match=r"'side'.*bottom.*no cuts.*grip"):
        mesh.boundary("side")
    with pytest.raises(kg.GeometryError, match="cut:1"):
        annulus().boundary("cut:1")


def test_node_sets_are_checked():
    with pytest.raises(kg.GeometryError, match=r"'grip'.*index 4"):
        kg.TriMesh(SQUARE, HALVES, sets={"grip": [4]})
    with pytest.raises(kg.GeometryError, match="integers"):
        kg.TriMesh(SQUARE, HALVES, sets={"grip": [0.5]})
    assert kg.TriMesh(SQUARE, HALVES, sets={"top": SQUARE[:, 1] == 1}).sets["top"].tolist() == [2, 3]


def test_copies_leave_the_original_alone():
    mesh = kg.TriMesh(SQUARE, HALVES, thickness=0.1)
    bigger = mesh.scaled(2.0).with_sets(corner=[0])
    assert bigger.facet_areas.sum() == pytest.approx(4.0)
    assert bigger.thickness == 0.1
    assert mesh.sets == {}
    assert mesh.facet_areas.sum() == pytest.approx(1.0)
    for array in (mesh.nodes, mesh.triangles, mesh.edges, mesh.edge_wings, mesh.boundary_loops[0]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_mesh_module_loads_numpy_only():
    heavy = "{'shapely', 'triangle', 'scipy', 'matplotlib'}"
    code = f"import sys, kirigami.geometry.mesh; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
