"""Half-edges and orientation: the combinatorics of triangles that mesh, cleaning and refinement share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import GeometryError
from kirigami.words import counted

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


def pair_keys(pairs: Integers, count: int) -> Integers:
    """One integer per unordered pair of nodes."""
    keys: Integers = pairs.min(axis=1) * count + pairs.max(axis=1)
    return keys


def pair_numbers(pairs: Integers, among: Integers, count: int) -> Integers:
    """Number of each unordered pair of the `count` nodes among others, in any order; -1 where it is none of them.

    >>> import numpy as np
    >>> from kirigami.geometry.topology import pair_numbers
    >>> pair_numbers(np.array([(2, 1), (0, 2)]), np.array([(0, 1), (3, 0), (1, 2)]), 4).tolist()
    [2, -1]
    """
    if not len(among):
        return np.full(len(pairs), -1)
    keys, wanted = pair_keys(among, count), pair_keys(pairs, count)
    order = np.argsort(keys, kind="stable")
    place = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)]
    numbers: Integers = np.where(keys[place] == wanted, place, -1)
    return numbers


def signed_areas(points: Floats, triangles: Integers) -> Floats:
    """Area of each triangle in the plane, positive if it is counter-clockwise."""
    corners = points[triangles]
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(0.5 * (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]))


def paired_half_edges(triangles: Integers) -> tuple[Integers, Integers]:
    """First and second (or -1) half-edge of each edge; of two, the first starts at the smaller node."""
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    keys = pair_keys(np.column_stack([start, end]), int(triangles.max()) + 1)
    order = np.argsort(keys, kind="stable")
    ranked = keys[order]
    is_new = np.concatenate([[True], ranked[1:] != ranked[:-1]])
    edge = np.cumsum(is_new) - 1
    crowded = np.flatnonzero(np.bincount(edge) > 2)
    if crowded.size:
        halves = order[edge == crowded[0]]
        raise GeometryError(
            f"the edge between nodes {start[halves[0]]} and {end[halves[0]]} belongs to "
            f"{counted(len(halves), 'facet')} ({', '.join(str(half // 3) for half in halves)}); a sheet has at most "
            "two at an edge"
        )
    first = order[is_new]
    second = np.full(len(first), -1)
    second[edge[~is_new]] = order[~is_new]
    swap = (second >= 0) & (start[first] > end[first])
    first[swap], second[swap] = second[swap], first[swap]
    return first, second


def regions(triangles: Integers, barriers: Integers, among: NDArray[np.bool_] | None = None) -> Integers:
    """Number of the region of each triangle, where regions hang together across edges other than the barriers.

    With ``among``, only these triangles are linked to one another.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    first, second = paired_half_edges(triangles)
    ends = np.column_stack([triangles.ravel()[first], triangles[:, [1, 2, 0]].ravel()[first]])
    count = int(triangles.max()) + 1
    linked = (second >= 0) & ~np.isin(pair_keys(ends, count), pair_keys(barriers, count))
    left, right = first[linked] // 3, second[linked] // 3
    if among is not None:
        both = among[left] & among[right]
        left, right = left[both], right[both]
    shape = (len(triangles), len(triangles))
    graph = coo_array((np.ones(len(left), np.int8), (left, right)), shape=shape)
    region: Integers = connected_components(graph, directed=False)[1].astype(np.int64)
    return region


def within(triangles: Integers, barriers: Integers, boundary: Integers) -> Integers:
    """The triangles at the left of a boundary, directed segments among the barriers.

    >>> import numpy as np
    >>> from kirigami.geometry.topology import within
    >>> hull = np.array([(0, 1, 2), (0, 2, 3), (1, 3, 2)])
    >>> sides = np.array([(0, 1), (1, 2), (2, 3), (3, 0)])
    >>> within(hull, sides, sides).tolist()
    [[0, 1, 2], [0, 2, 3]]
    """
    count = max(int(triangles.max()), int(boundary.max())) + 1
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    to_void = np.isin(start * count + end, boundary[:, 1] * count + boundary[:, 0])
    region = regions(triangles, barriers)
    void = np.unique(region[np.flatnonzero(to_void) // 3])
    kept: Integers = triangles[~np.isin(region, void)]
    return kept


def boundary_pairs(triangles: Integers) -> Integers:
    """Boundary edges, directed with their triangle at the left."""
    first, second = paired_half_edges(triangles)
    half = first[second < 0]
    return np.column_stack([triangles.ravel()[half], triangles[:, [1, 2, 0]].ravel()[half]])


def joined_corners(triangles: Integers, edges: Integers, edge_facets: Integers) -> Integers:
    """Numbers (m, 3) of the pieces that the corners of facets belong to, where `edges` (k, 2) join the two facets
    (k, 2) on them: round a node, the facets that come together without a fold or a cut between them."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = [
        np.stack([3 * facet + np.argmax(triangles[facet] == end[:, None], axis=1) for facet in edge_facets.T], axis=1)
        for end in edges.T
    ]
    joined, size = np.concatenate(links), triangles.size
    graph = coo_array((np.ones(len(joined), np.int8), (joined[:, 0], joined[:, 1])), shape=(size, size))
    return np.asarray(connected_components(graph, directed=False)[1].reshape(-1, 3), dtype=np.int64)


def edges_within(edge: Integers, ends: Integers, inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which edges a set of nodes holds: those with both ends in it that have one facet, or facets all in the set.

    Parameters
    ----------
    edge : ndarray of int, shape (m, 3)
        Edges of each facet.
    ends : ndarray of int, shape (e, 2)
        Nodes of each edge.
    inside : ndarray of bool, shape (n,)
        Which nodes are in the set.
    """
    both = np.asarray(inside[ends].all(axis=1))
    whole = both[edge].all(axis=1)  # a facet whose three edges are in the set has its corners there
    facets = np.bincount(edge.ravel(), minlength=len(ends))
    held = np.bincount(edge[whole].ravel(), minlength=len(ends))
    return np.asarray(both & ((facets == 1) | (held == facets)))


def sides(nodes: Floats, triangles: Integers) -> Floats:
    """Vectors from each corner to the next, shape (m, 3, 3)."""
    corners = nodes[triangles]
    return corners[:, [1, 2, 0]] - corners


def area_vectors(nodes: Floats, triangles: Integers) -> Floats:
    """Normal of each facet times its area, shape (m, 3)."""
    vectors = sides(nodes, triangles)
    return 0.5 * np.cross(vectors[:, 0], vectors[:, 1])


def oriented_triangles(nodes: Floats, triangles: Integers) -> Integers:
    """Facets turned so that neighbours agree and the sheet as a whole faces +z."""
    oriented: Integers = triangles.copy()
    if np.ptp(nodes[:, 2]) == 0.0:
        _flip(oriented, area_vectors(nodes, oriented)[:, 2] < 0)
    else:
        _flip(oriented, _flips_of_a_surface(nodes, oriented))
    first, second = paired_half_edges(oriented)
    both = second >= 0
    start = oriented.ravel()
    clash = np.flatnonzero(both & (start[first] == start[second]))
    if clash.size:
        facets = first[clash[0]] // 3, second[clash[0]] // 3
        place = nodes[oriented[facets[0]]].mean(axis=0)
        raise GeometryError(
            f"facets {facets[0]} and {facets[1]} overlap: both lie on one side of their edge near {place}"
        )
    return oriented


def _flips_of_a_surface(nodes: Floats, triangles: Integers) -> NDArray[np.bool_]:
    """Which facets to turn, from a graph that holds every facet twice, as it is and turned.

    Links join the states in which neighbours agree. Each part of the surface then appears as two components, one for
    each way round; if they are the same component the surface has only one side.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    first, second = paired_half_edges(triangles)
    both = second >= 0
    start, count = triangles.ravel(), len(triangles)
    agree = start[first[both]] != start[second[both]]
    left, right = first[both] // 3, second[both] // 3
    rows = np.concatenate([left, left + count])
    columns = np.concatenate([np.where(agree, right, right + count), np.where(agree, right + count, right)])
    graph = coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(2 * count, 2 * count))
    state = connected_components(graph, directed=False)[1]
    if (state[:count] == state[count:]).any():
        raise GeometryError("the surface has only one side, like a Moebius band: its facets cannot be oriented")
    upward = area_vectors(nodes, triangles)[:, 2]
    facing = np.bincount(state, weights=np.concatenate([upward, -upward]))
    kept, turned = facing[state[:count]], facing[state[count:]]
    level = np.abs(kept - turned) <= 1e-12 * np.abs(upward).sum()  # a closed or upright part: keep its first facet
    flips: NDArray[np.bool_] = np.where(level, state[:count] > state[count:], turned > kept)
    return flips


def _flip(triangles: Integers, which: NDArray[np.bool_]) -> None:
    triangles[which, 1:] = triangles[which, :0:-1]


def boundary_walks(facets: int, first: Integers, second: Integers) -> list[Integers]:
    """Closed walks of boundary half-edges with the sheet at the left, given the half-edges `first` of all edges of so
    many facets and their twins `second`, negative where there is none."""
    twin = np.full(3 * facets, -1)
    inner = second >= 0
    twin[first[inner]], twin[second[inner]] = second[inner], first[inner]
    follow = np.arange(len(twin)).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    # The next boundary half-edge is found by turning about the node through its fan of facets. Where two loops
    # touch in a node, a search through the graph of boundary edges could not tell them apart; the fan can.
    boundary = np.flatnonzero(twin < 0)
    after = follow[boundary]
    while (turning := twin[after] >= 0).any():
        after[turning] = follow[twin[after[turning]]]
    successor = dict(zip(boundary.tolist(), after.tolist(), strict=True))
    walks = []
    while successor:
        start, half = next(iter(successor.items()))
        walk = [start]
        del successor[start]
        while half != start:
            walk.append(half)
            half = successor.pop(half)
        walks.append(np.array(walk))
    return walks
