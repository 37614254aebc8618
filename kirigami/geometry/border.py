"""The border of a cell of a periodic sheet: which edges and nodes of a mesh repeat which, a lattice vector away.

Edges are matched, not nodes: where a slit runs through the border there are two nodes in one place, and only the edges
that meet there tell which of the two on the other side is which.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import GeometryError
from kirigami.primitives.kernel import Array

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

Index = NDArray[np.int64]
NEAR = 1e-6  # of the lattice vectors, within which places are the same


def repeated_border(mesh: TriMesh, lattice: Array) -> tuple[Index, Index]:
    """What repeats on the border of a mesh.

    Parameters
    ----------
    mesh : TriMesh
        The sheet of one cell.
    lattice : ndarray, shape (m, 3)
        One or two lattice vectors in its plane [length].

    Returns
    -------
    images : ndarray of int, shape (k, 2 + m)
        Rows (node, node it repeats, steps along each lattice vector).
    edges : ndarray of int, shape (s, 4 + m)
        Rows (ends of an edge, ends of the one it repeats in the same order, steps from that to this).

    Raises
    ------
    GeometryError
        Edges on the border that lie on others a lattice vector away but do not match them, nothing that repeats, or a
        sheet that is larger than the cell.

    Examples
    --------
    >>> import numpy as np
    >>> from kirigami.geometry.border import repeated_border
    >>> import kirigami as kg
    >>> mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    >>> repeated_border(mesh, np.array([[1.0, 0, 0], [0, 1, 0]]))[0].tolist()
    [[1, 0, 1, 0], [2, 0, 1, 1], [3, 0, 0, 1]]
    """
    rim = mesh.edges[mesh.boundary_edges]
    near = NEAR * float(np.linalg.norm(lattice, axis=1).max())
    start, end = mesh.nodes[rim[:, 0]], mesh.nodes[rim[:, 1]]
    steps = np.array(_steps(len(lattice)), dtype=np.int64)
    pairs = _matches(0.5 * (start + end), end - start, steps, lattice, near)
    _check_whole(mesh, rim, pairs, steps, lattice, near)
    image, source, step = pairs.T
    edges = np.column_stack([rim[image], rim[source][:, ::-1], steps[step]])  # round the sheet both run the same way
    return _classes(mesh.nodes, edges, lattice, near), edges


def tiled(
    mesh: TriMesh, images: Index, lattice: Array, counts: Sequence[int]
) -> tuple[TriMesh, Index, Index]:
    """A patch of equal cells as one mesh, joined as the infinite sheet is.

    Parameters
    ----------
    mesh : TriMesh
        The sheet of one cell.
    images : ndarray of int, shape (k, 2 + m)
        As from :func:`repeated_border`.
    lattice : ndarray, shape (m, 3)
        Lattice vectors [length].
    counts : sequence of int, shape (m,)
        Cells along each.

    Returns
    -------
    TriMesh
        The patch; its facets are those of the cell, cell by cell.
    node : ndarray of int, shape (n,)
        The node of the cell that each of its nodes repeats.
    steps : ndarray of int, shape (n, m)
        In how many steps along the lattice vectors.
    """
    from kirigami.geometry.mesh import TriMesh

    cells = np.array(list(product(*(range(count) for count in counts))), dtype=np.int64)
    node, away, place = joined_nodes(images, cells, len(mesh.nodes))
    triangles = place[:, mesh.triangles].reshape(-1, 3)
    nodes = mesh.nodes[node] + away @ lattice
    made = TriMesh(nodes, triangles, thickness=mesh.thickness, material=mesh.material)
    return made, node, away


def leaders(images: Index, count: int) -> tuple[Index, Index]:
    """What each of `count` nodes repeats, itself if it is none of the images (k, 2 + m), and in how many steps
    (count, m)."""
    leader, steps = np.arange(count), np.zeros((count, images.shape[1] - 2), np.int64)
    leader[images[:, 0]], steps[images[:, 0]] = images[:, 1], images[:, 2:]
    return leader, steps


def joined_nodes(images: Index, cells: Index, count: int) -> tuple[Index, Index, Index]:
    """The nodes of cells at some steps (c, m), joined as the infinite sheet is: which node of the cell each repeats
    (n,), in how many steps (n, m); and which of them are the nodes of each cell (c, count)."""
    leader, own = leaders(images, count)
    steps = (own[None] + cells[:, None]).reshape(-1, cells.shape[1])
    key = np.column_stack([np.tile(leader, len(cells)), steps])
    found, place = np.unique(key, axis=0, return_inverse=True)
    return found[:, 0], found[:, 1:], place.reshape(len(cells), count)


def _steps(vectors: int) -> list[tuple[int, ...]]:
    """Steps to the cells beyond half of the border: also across corners, as hexagons have it."""
    return [(1,)] if vectors == 1 else [(1, 0), (0, 1), (1, 1), (1, -1)]


def _matches(middle: Array, along: Array, steps: Index, lattice: Array, near: float) -> Index:
    """Rows (edge, edge it repeats, number of the step): where edges of the rim run opposite ways in the same place."""
    from scipy.spatial import cKDTree

    tree = cKDTree(middle)
    found = []
    for number, step in enumerate(steps):
        for edge, others in enumerate(tree.query_ball_point(middle + step @ lattice, near)):
            for other in others:
                if np.linalg.norm(along[edge] + along[other]) <= near:
                    found.append((other, edge, number))
    return np.array(found, dtype=np.int64).reshape(-1, 3)


def _check_whole(mesh: TriMesh, rim: Index, pairs: Index, steps: Index, lattice: Array, near: float) -> None:
    """Refuse borders that do not match, in words."""
    for number in range(len(lattice)):
        if not steps[pairs[:, 2], number].any():
            vector = ", ".join(f"{value:.6g}" for value in lattice[number, :2])
            raise GeometryError(
                f"no edge of the mesh repeats another one along the lattice vector ({vector}): opposite sides of a "
                "cell need the same nodes, a lattice vector apart; kg.CellSheet makes such meshes"
            )
    alone = np.setdiff1d(np.arange(len(rim)), pairs[:, :2])
    start, end = mesh.nodes[rim[:, 0]], mesh.nodes[rim[:, 1]]
    along = end - start
    square = (along**2).sum(axis=1)
    lengths = np.sqrt(square)
    for step in np.concatenate([steps, -steps]):
        for edge in alone.tolist():
            there = 0.5 * (start[edge] + end[edge]) + step @ lattice
            share = (((there - start) * along).sum(axis=1) / square).clip(0, 1)
            far = np.linalg.norm(there - start - share[:, None] * along, axis=1)
            at = int(far.argmin())
            if far[at] <= near and abs(np.cross(along[edge], along[at])[2]) <= near * max(lengths[edge], lengths[at]):
                x, y = 0.5 * (start[edge] + end[edge])[:2]
                raise GeometryError(
                    f"the border of the cell does not repeat at ({x:.6g}, {y:.6g}): the edge of the mesh there lies on "
                    f"that at ({there[0]:.6g}, {there[1]:.6g}) but has other ends; opposite sides of a cell need the "
                    "same nodes: kg.CellSheet makes such meshes"
                )
    if len(lattice) == 2:
        cell = abs(float(np.cross(lattice[0], lattice[1])[2]))
        area = float(mesh.facet_areas.sum())
        if area > cell * (1 + NEAR):
            raise GeometryError(
                f"the sheet of the cell has an area of {area:.6g}, more than the {cell:.6g} of a cell of this lattice: "
                "model each part of the sheet once"
            )


def _classes(nodes: Array, edges: Index, lattice: Array, near: float) -> Index:
    """Nodes that repeat others, by way of the edges: rows (node, node it repeats, steps); none repeats an image."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    first, second = edges[:, :2].ravel(), edges[:, 2:4].ravel()
    graph = coo_array((np.ones(len(first), np.int8), (first, second)), shape=(len(nodes), len(nodes)))
    label = connected_components(graph, directed=False)[1]
    _, lowest = np.unique(label, return_index=True)
    leader = lowest[label]
    follower = np.flatnonzero(leader != np.arange(len(nodes)))
    apart = nodes[follower] - nodes[leader[follower]]
    steps = np.rint(apart @ np.linalg.pinv(lattice)).astype(np.int64)
    far = np.linalg.norm(apart - steps @ lattice, axis=1)
    if far.max(initial=0.0) > near:
        x, y = nodes[follower[int(far.argmax())], :2]
        raise GeometryError(
            f"the node at ({x:.6g}, {y:.6g}) repeats one that is no whole number of lattice vectors away: a rim that "
            "lies on the border on both sides of the cell does not say which of them meet; shift the cell"
        )
    return np.column_stack([follower, leader[follower], steps])
