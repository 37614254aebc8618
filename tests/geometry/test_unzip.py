"""Opening a mesh along slits: exact node counts on a small grid, and the lips of each cut."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import kirigami as kg
from kirigami.geometry.unzip import unzip

SIZE = 6  # cells; the nodes of the grid are numbered x + 7 y


def grid() -> tuple[np.ndarray, np.ndarray]:
    nodes = np.array([(x, y) for y in range(SIZE + 1) for x in range(SIZE + 1)], float)
    facets = []
    for y in range(SIZE):
        for x in range(SIZE):
            a = node(x, y)
            facets += [(a, a + 1, a + SIZE + 2), (a, a + SIZE + 2, a + SIZE + 1)]
    return nodes, np.array(facets)


def node(x: int, y: int) -> int:
    return x + (SIZE + 1) * y


def path(*corners: tuple[int, int]) -> list[tuple[int, int]]:
    """Grid edges along a polyline with sides parallel to the axes."""
    edges = []
    for (x0, y0), (x1, y1) in pairwise(corners):
        steps = max(abs(x1 - x0), abs(y1 - y0))
        along = [node(x0 + (x1 - x0) * s // steps, y0 + (y1 - y0) * s // steps) for s in range(steps + 1)]
        edges += list(pairwise(along))
    return edges


@pytest.mark.parametrize(
    ("slits", "added", "loops"),
    [
        (path((1, 3), (5, 3)), 3, 2),  # inner: every node but the two tips doubles
        (path((0, 3), (3, 3)), 3, 1),  # from the edge: the mouth doubles too
        (path((2, 2), (4, 2), (4, 4)), 3, 2),  # bent
        (
            path((1, 3), (5, 3)) + path((3, 1), (3, 5)),
            4 * 1 + 3 + 0,
            2,
        ),  # crossing: 4 on the arms, 3 more at the centre
        (path((1, 3), (5, 3)) + path((3, 3), (3, 5)), 2 + 1 + 2, 2),  # T: 3 single, and a third copy where they meet
        (path((0, 3), (3, 3)) + path((3, 1), (3, 5)), 2 + 1 + 2 + 2, 1),  # T open to the edge, two inner arms
        (path((1, 2), (5, 2)) + path((1, 4), (5, 4)), 6, 3),  # two
        (path((2, 3), (3, 3)), 0, 1),  # one edge alone cannot open
        ([], 0, 1),
    ],
)
def test_node_counts(slits, added, loops):
    nodes, facets = grid()
    opened, origin = unzip(facets, np.array(slits, int).reshape(-1, 2))
    assert len(origin) == len(nodes) + added
    assert origin[: len(nodes)].tolist() == list(range(len(nodes)))
    assert (origin[opened] == facets).all()
    mesh = kg.TriMesh(nodes[origin], opened)
    assert len(mesh.boundary_loops) == loops
    assert len(mesh.edges) - len(mesh.triangles) - len(mesh.nodes) == loops - 2


def test_severing_slit_leaves_two_parts():
    nodes, facets = grid()
    opened, origin = unzip(facets, np.array(path((0, 3), (6, 3))))
    mesh = kg.TriMesh(nodes[origin], opened)
    assert len(origin) == len(nodes) + SIZE + 1
    assert mesh.facet_parts.max() == 1
    assert np.bincount(mesh.facet_parts, mesh.facet_areas).tolist() == [18.0, 18.0]


def test_facets_that_meet_in_a_node_only_come_apart():
    opened, origin = unzip(np.array([(0, 1, 2), (2, 3, 4)]), np.empty((0, 2), int))
    assert origin.tolist() == [0, 1, 2, 3, 4, 2]
    assert opened.tolist() == [[0, 1, 2], [5, 3, 4]]
