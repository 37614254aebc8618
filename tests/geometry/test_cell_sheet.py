"""Cells of periodic sheets: cuts wrap round, opposite sides mesh alike, what cannot be is refused."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.geometry.border import repeated_border

SLITS = [[(-0.6, 0.25), (0.6, 0.25)], [(0.4, 0.75), (1.6, 0.75)]]


@pytest.mark.parametrize(
    "lattice, cuts",
    [
        ([(2, 0), (0, 1)], SLITS),
        ([(1, 0), (0.5, 0.866)], [[(0.2, 0.2), (0.9, 0.3)]]),
        ([(2, 0), (0.3, 1)], [[(-0.5, 0.5), (0.5, 0.5)], shapely.Point(0, 0).buffer(0.2, 4)]),
    ],
)
def test_sides_have_the_same_nodes(lattice: list[tuple[float, float]], cuts: list) -> None:
    sheet = kg.CellSheet(lattice, cuts)
    for mesh in (sheet.mesh(0.25), sheet.mesh(0.2, 0.1)):
        vectors = np.column_stack([sheet.lattice, np.zeros(2)])
        images, edges = repeated_border(mesh, vectors)
        apart = mesh.nodes[images[:, 0]] - mesh.nodes[images[:, 1]] - images[:, 2:] @ vectors
        assert np.abs(apart).max() < 1e-9
        assert mesh.min_angle > 20
        # all that is left of the rim is cut: lips, holes, and nothing along the sides
        paired = np.zeros(len(mesh.edges), bool)
        keys = np.sort(mesh.edges, axis=1)
        for pair in (edges[:, :2], edges[:, 2:4]):
            for ends in np.sort(pair, axis=1).tolist():
                paired |= (keys == ends).all(axis=1)
        free = mesh.boundary_edges[~paired[mesh.boundary_edges]]
        part = (mesh.nodes[mesh.edges[free], :2]) @ np.linalg.inv(sheet.lattice)
        along = (np.abs(part - np.round(part)) < 1e-9).all(axis=1).any(axis=1)
        assert not along.any()


def test_area_of_cells_and_of_many() -> None:
    sheet = kg.CellSheet([(2, 0), (0, 1)], [shapely.Point(0.1, 0).buffer(0.2)])
    hole = shapely.Point(0.1, 0).buffer(0.2).area
    assert sheet.area == pytest.approx(2 - hole, rel=1e-9)
    assert sheet.repeated(3, 2).area == pytest.approx(12 - 6 * hole, rel=1e-9)
    assert sheet.supercell(3, 2).area == pytest.approx(12 - 6 * hole, rel=1e-9)


def test_a_slit_through_the_border_stays_open_there() -> None:
    """Two lips at one place of the border: each goes on in its own on the other side."""
    sheet = kg.CellSheet([(2, 0), (0, 1)], SLITS)
    mesh = sheet.mesh(0.3)
    images, _ = repeated_border(mesh, np.column_stack([sheet.lattice, np.zeros(2)]))
    mouth = np.flatnonzero(np.abs(mesh.nodes[:, :2] - [2.0, 0.25]).max(axis=1) < 1e-9)
    assert len(mouth) == 2
    leaders = {int(images[images[:, 0] == k, 1][0]) if (images[:, 0] == k).any() else int(k) for k in mouth}
    assert len(leaders) == 2
    facets = mesh.nodes[mesh.triangles].mean(axis=1)
    for k in mouth:
        follows = images[images[:, 0] == k, 1]
        partner = int(follows[0]) if follows.size else int(images[images[:, 1] == k, 0][0])
        sides = [np.sign(facets[(mesh.triangles == n).any(axis=1), 1] - 0.25) for n in (k, partner)]
        assert len(set(np.concatenate(sides).tolist())) == 1


def test_what_is_no_cell_is_refused() -> None:
    with pytest.raises(kg.GeometryError, match="span no cell"):
        kg.CellSheet([(1, 0), (2, 0)])
    with pytest.raises(kg.GeometryError, match=r"along a side of the cell at \(0.75, 0\).*origin="):
        kg.CellSheet([(2, 0), (0, 1)], [[(0.5, 0), (1, 0)]])
    moved = kg.CellSheet([(2, 0), (0, 1)], [[(0.5, 0), (1, 0)]], origin=(0, -0.5))
    assert len(moved.mesh(0.4).cuts) == 1
