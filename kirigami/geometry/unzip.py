"""Opening a mesh along its slits, and finding the lips of every cut in the opened mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kirigami.geometry.mesh import CutLoop, TriMesh
from kirigami.geometry.topology import paired_half_edges

Integers = NDArray[np.int64]


def unzip(triangles: Integers, slit_edges: Integers) -> tuple[Integers, Integers]:
    """Open a mesh along interior edges.

    The corners of the facets round a node that are linked across uncut edges share one new node. This one rule serves
    slits that end inside, reach the outline, cross or branch: a tip stays closed, a crossing of two slits becomes four
    nodes. A node where facets met without sharing an edge is split as well.

    Parameters
    ----------
    triangles : ndarray of int, shape (m, 3)
        Facets, all counter-clockwise.
    slit_edges : ndarray of int, shape (s, 2)
        Node pairs of the edges to open.

    Returns
    -------
    triangles : ndarray of int, shape (m, 3)
        The same facets with the new nodes. Old nodes keep their numbers, new ones follow.
    origin : ndarray of int
        Old node from which each node comes.

    Examples
    --------
    Two facets that share the edge (0, 2) come apart:

    >>> import numpy as np
    >>> from kirigami.geometry.unzip import unzip
    >>> opened, origin = unzip(np.array([(0, 1, 2), (0, 2, 3)]), np.array([(0, 2)]))
    >>> opened.tolist(), origin.tolist()
    ([[0, 1, 2], [4, 5, 3]], [0, 1, 2, 3, 0, 2])
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = int(triangles.max()) + 1
    first, second = paired_half_edges(triangles)
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    pairs = np.sort(slit_edges, axis=1).reshape(-1, 2)
    keys = np.minimum(start[first], end[first]) * count + np.maximum(start[first], end[first])
    linked = (second >= 0) & ~np.isin(keys, pairs[:, 0] * count + pairs[:, 1])
    one, two = first[linked], second[linked]
    after = np.arange(len(start)).reshape(-1, 3)[:, [1, 2, 0]].ravel()  # the next corner of the same facet
    left, right = np.concatenate([one, after[one]]), np.concatenate([after[two], two])
    graph = coo_array((np.ones(len(left), np.int8), (left, right)), shape=(len(start), len(start)))
    fan = connected_components(graph, directed=False)[1]
    _, corner_of_fan = np.unique(fan, return_index=True)
    node_of_fan = start[corner_of_fan]
    order = np.lexsort([corner_of_fan, node_of_fan])
    is_first = np.concatenate([[True], node_of_fan[order][1:] != node_of_fan[order][:-1]])
    number = np.empty(len(order), np.int64)
    number[order[is_first]] = node_of_fan[order[is_first]]
    added = np.sort(order[~is_first])
    number[added] = count + np.arange(len(added))
    return number[fan].reshape(-1, 3), np.concatenate([np.arange(count), node_of_fan[added]])


def find_cuts(mesh: TriMesh, boundary_cuts: Sequence[Sequence[tuple[int, ...]]]) -> list[CutLoop]:
    """Lips of every cut, from the drawn cuts along each boundary edge.

    Parameters
    ----------
    mesh : TriMesh
        The opened mesh.
    boundary_cuts : sequence of sequences
        For each boundary loop of the mesh and each of its edges, the numbers of the cuts drawn along it.
    """
    runs: list[tuple[set[int], Integers, bool]] = []
    for loop, cuts in zip(mesh.boundary_loops, boundary_cuts, strict=True):
        along_cut = np.array([bool(numbers) for numbers in cuts])
        if along_cut.all():
            runs.append((set().union(*cuts), loop, False))
            continue
        starts = np.flatnonzero(along_cut & ~np.roll(along_cut, 1))
        for begin in starts.tolist():
            length = int(np.argmin(np.roll(along_cut, -begin)))
            steps = (begin + np.arange(length + 1)) % len(loop)
            runs.append((set().union(*(cuts[step] for step in steps[:-1])), loop[steps], True))
    groups: list[tuple[set[int], list[tuple[Integers, bool]]]] = []
    for members, nodes, is_open in runs:
        joined = [group for group in groups if group[0] & members]
        groups = [group for group in groups if not group[0] & members]
        pieces = [piece for group in joined for piece in group[1]]
        groups.append((members.union(*(group[0] for group in joined)), [*pieces, (nodes[::-1], is_open)]))
    groups.sort(key=lambda group: min(group[0]))
    return [_joined(mesh, tuple(sorted(members)), pieces) for members, pieces in groups]


def _joined(mesh: TriMesh, members: tuple[int, ...], pieces: list[tuple[Integers, bool]]) -> CutLoop:
    """One closed polygon from the runs of a cut: from the end of each to the nearest beginning, across the mouth."""
    is_open = len(pieces) > 1 or pieces[0][1]
    loop, rest = pieces[0][0], [nodes for nodes, _ in pieces[1:]]
    while rest:
        gaps = [np.linalg.norm(mesh.nodes[nodes[0]] - mesh.nodes[loop[-1]]) for nodes in rest]
        loop = np.concatenate([loop, rest.pop(int(np.argmin(gaps)))])
    loop = loop.copy()
    loop.setflags(write=False)
    return CutLoop(loop, members, is_open)
