"""Nested dissection: an order of elimination that keeps the factor of a large sheet small.

The unknowns that share their neighbours (the three of a node) are taken together, and the graph of these groups is cut
in two by a small separator, both halves again, and so on, until the parts are small. Parts first, separators last: no
elimination inside one part touches the other (George, SIAM J. Numer. Anal. 10 (1973)).

A cut follows a level set of a difference of distances, counted in links, from two landmarks on the rim of the graph. A
sheet is thus cut where the way through the material is narrow, across the ligaments between its slits, and the
position needs not be known. Candidates are all pairs of a few landmarks, at any level near the middle; the smallest
separator per cut wins, and the least set of nodes that covers its links (Koenig's theorem) is the separator.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.kernel import Array

Index = NDArray[np.int64]

LANDMARKS = 4
OFF_MIDDLE = 0.2  # how far from the middle a cut may lie, as a share of the part


class Fronts(NamedTuple):
    """Unknowns in groups that are eliminated together, children before parents.

    ``order`` (n,) lists the unknowns; front f eliminates those at ``starts[f] : starts[f + 1]`` of it and changes those
    at ``borders[f]`` (ascending), all of which belong to fronts between it and the root. ``parent`` is -1 at a root.
    """

    order: Index
    starts: Index
    parent: Index
    borders: list[Index]


class Graph(NamedTuple):
    """Neighbours ``indices[indptr[v] : indptr[v + 1]]`` of each vertex, and how many unknowns it stands for."""

    indptr: Index
    indices: Index
    weight: Index


def dissect(matrix: Any, leaf: int) -> Fronts:
    """Fronts of a sparse matrix (CSC) with a symmetric pattern.

    Parameters
    ----------
    matrix : scipy.sparse.csc_matrix, shape (n, n)
        Only its pattern is read.
    leaf : int
        Unknowns up to which a part stays whole.
    """
    group, graph = _groups(matrix)
    levels = _level_functions(graph)
    front, parent = _cut(graph, levels, leaf)
    return _fronts(graph, group, front, parent, levels)


def _groups(matrix: Any) -> tuple[Index, Graph]:
    """Group of each unknown, the same for unknowns with the same neighbours, and the graph of the groups."""
    from scipy.sparse import csc_matrix

    # Equal columns have equal sums of random numbers, and different ones do not but by a chance of 1e-9 or less.
    label = np.random.default_rng(0).integers(-(2**62), 2**62, matrix.shape[0])
    sums = np.add.reduceat(np.append(label[matrix.indices], 0), matrix.indptr[:-1])
    _, first, group, weight = np.unique(sums, return_index=True, return_inverse=True, return_counts=True)
    by_place = np.argsort(first)
    rank = np.empty_like(by_place)
    rank[by_place] = np.arange(len(by_place))
    chosen = first[by_place]
    pattern = csc_matrix((np.ones(matrix.nnz, dtype=np.int8), matrix.indices, matrix.indptr), shape=matrix.shape)
    reduced = pattern[:, chosen].tocsr()[chosen].tocsc()
    reduced.setdiag(0)
    reduced.eliminate_zeros()
    graph = Graph(reduced.indptr.astype(np.int64), reduced.indices.astype(np.int64), weight[by_place])
    return rank[group].astype(np.int64), graph


def _level_functions(graph: Graph) -> Array:
    """Differences of distances from landmarks (vertices, pairs), slightly smoothed."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import dijkstra

    n = len(graph.weight)
    links = csr_matrix((np.ones(len(graph.indices)), graph.indices, graph.indptr), shape=(n, n))
    distances: list[Array] = []
    at, nearest = 0, np.full(n, np.inf)
    for count in range(LANDMARKS + 1):
        distance = dijkstra(links, indices=at, unweighted=True)
        reached = np.isfinite(distance)
        distance[~reached] = 2 * distance[reached].max() + 1
        if count > 0:  # the first only leads to the rim
            distances.append(distance)
            nearest = np.minimum(nearest, distance)
        at = int(np.argmax(distance if count == 0 else nearest))
    smooth = np.array(distances).T
    degree = np.diff(graph.indptr)[:, None] + 1.0
    for _ in range(2):
        smooth = (links @ smooth + smooth) / degree
    first, second = np.triu_indices(LANDMARKS, 1)
    differences: Array = smooth[:, first] - smooth[:, second]
    return differences


def _cut(graph: Graph, levels: Array, leaf: int) -> tuple[Index, Index]:
    """Front of each vertex and parent of each front; all parts of one generation are cut at once."""
    n = len(graph.weight)
    front: Index = np.full(n, -1)
    parents: list[int] = []
    part: Index = np.zeros(n, dtype=np.int64)  # -1 once a vertex has its front
    above: Index = np.array([-1])  # front that the front of a part will be a child of
    active: Index = np.arange(n)
    rows = np.repeat(active, np.diff(graph.indptr))
    one, other = rows[rows < graph.indices], graph.indices[rows < graph.indices]
    while active.size:
        unknowns = np.bincount(part[active], weights=graph.weight[active], minlength=len(above))
        whole = (unknowns <= leaf) | (np.bincount(part[active], minlength=len(above)) < 3)
        fresh = np.flatnonzero(whole & (unknowns > 0))
        number = np.zeros(len(above), dtype=np.int64)
        number[fresh] = len(parents) + np.arange(len(fresh))
        parents += above[fresh].tolist()
        done = whole[part[active]]
        front[active[done]] = number[part[active[done]]]
        part[active[done]] = -1
        active = active[~done]
        if not active.size:
            break
        live, part[active] = np.unique(part[active], return_inverse=True)
        above = above[live]
        inside = (part[one] >= 0) & (part[one] == part[other])
        one, other = one[inside], other[inside]

        here = part[active]
        place: Index = np.full(n, -1)
        place[active] = np.arange(len(active))
        high = _sides(here, levels[active], place[one], place[other])
        crossing = high[place[one]] != high[place[other]]
        first, second = place[one[crossing]], place[other[crossing]]
        separator = _vertex_cover(first, second, high)
        present = np.bincount(here, weights=separator, minlength=len(above)) > 0
        below = above.copy()
        below[present] = len(parents) + np.arange(np.count_nonzero(present))
        parents += above[present].tolist()
        front[active[separator]] = below[here[separator]]
        part[active] = 2 * here + high
        part[active[separator]] = -1
        active = active[~separator]
        above = np.repeat(below, 2)
    return front, np.array(parents)


def _sides(part: Index, levels: Array, one: Index, other: Index) -> NDArray[np.bool_]:
    """Which vertices lie on the high side of the best cut of their part; links join the vertices `one`, `other`."""
    n = len(part)
    count = int(part.max()) + 1
    size = np.bincount(part, minlength=count)
    start = np.cumsum(size) - size
    position = np.arange(n)
    best = np.full(count, np.inf)
    high = np.zeros(n, dtype=bool)
    for values in levels.T:
        order = np.lexsort((values, part))
        rank = np.empty(n, dtype=np.int64)
        rank[order] = position
        low_end, high_end = np.minimum(rank[one], rank[other]), np.maximum(rank[one], rank[other])
        # A vertex stands at the rim of the low side for all cuts from itself on, before its farthest neighbour above.
        farthest = position.copy()
        np.maximum.at(farthest, low_end, high_end)
        rim = np.cumsum(1 - np.bincount(farthest, minlength=n))
        ordered = part[order]
        off = np.abs((position + 1 - start[ordered]) / size[ordered] - 0.5)
        cost = (rim + 0.5) * (1 + 4 * off**2)
        cost[off > OFF_MIDDLE] = np.inf
        cost[start + (size - 1) // 2] = np.minimum(cost[start + (size - 1) // 2], n)  # small parts have no other
        least = np.minimum.reduceat(cost, start)
        hits = np.flatnonzero(cost == least[ordered])
        cut = hits[np.unique(ordered[hits], return_index=True)[1]]
        better = least < best
        best[better] = least[better]
        high = np.where(better[part], rank > cut[part], high)
    return high


def _vertex_cover(one: Index, other: Index, high: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The fewest vertices that meet all links `one`-`other` between the low and the high side."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import maximum_bipartite_matching

    cover = np.zeros(len(high), dtype=bool)
    if not len(one):
        return cover
    low, row = np.unique(np.where(high[one], other, one), return_inverse=True)
    top, column = np.unique(np.where(high[one], one, other), return_inverse=True)
    links = csr_matrix((np.ones(len(row)), (row, column)), shape=(len(low), len(top)))
    match = maximum_bipartite_matching(links, perm_type="column")
    partner = np.full(len(top), -1)
    partner[match[match >= 0]] = np.flatnonzero(match >= 0)
    # Koenig: what alternating paths from unmatched low vertices reach stays out of the cover below, and makes it above.
    reached = match < 0
    covered = np.zeros(len(top), dtype=bool)
    while True:
        fresh = np.zeros(len(top), dtype=bool)
        fresh[column[reached[row]]] = True
        fresh &= ~covered
        if not fresh.any():
            break
        covered |= fresh
        reached[partner[fresh]] = True  # a maximum matching leaves no reached vertex above without a partner
    cover[low[~reached]] = True
    cover[top[covered]] = True
    return cover


def _fronts(graph: Graph, group: Index, front: Index, parent: Index, levels: Array) -> Fronts:
    """Number the fronts from the leaves up, their vertices along them, and find what each one borders on."""
    count = len(parent)
    children: list[list[int]] = [[] for _ in range(count)]
    stack = np.flatnonzero(parent < 0).tolist()
    for child, above in enumerate(parent.tolist()):
        if above >= 0:
            children[above].append(child)
    backwards: list[int] = []
    while stack:
        backwards.append(stack.pop())
        stack += children[backwards[-1]]
    sequence = np.array(backwards[::-1], dtype=np.int64)
    renumbered = np.empty(count, dtype=np.int64)
    renumbered[sequence] = np.arange(count)
    front = renumbered[front]
    parent = np.where(parent >= 0, renumbered[parent], -1)[sequence]

    # Numbered along a separator, what its parts touch of it is one stretch of numbers, not scattered ones.
    size = np.bincount(front, minlength=count)
    mean = np.stack([np.bincount(front, weights=values, minlength=count) / size for values in levels.T], axis=1)
    apart = levels - mean[front]
    spread = np.stack([np.bincount(front, weights=values**2, minlength=count) for values in apart.T], axis=1)
    along = apart[np.arange(len(front)), spread.argmax(axis=1)[front]]
    order = np.lexsort((along, front))
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    ends = np.cumsum(size)

    links = np.repeat(np.arange(len(front)), np.diff(graph.indptr))
    below, above = front[links], place[graph.indices]
    later = above >= ends[below]
    below, above = below[later], above[later]
    by_front = np.argsort(below, kind="stable")
    touched = np.split(above[by_front], np.searchsorted(below[by_front], np.arange(1, count)))
    vertex_borders: list[Index] = []
    waiting: list[list[Index]] = [[] for _ in range(count)]
    for f in range(count):
        border = np.unique(np.concatenate([touched[f], *waiting[f]]))
        border = border[border >= ends[f]]
        waiting[f] = []
        vertex_borders.append(border)
        if parent[f] >= 0:
            waiting[parent[f]].append(border)

    weight = graph.weight[order]
    last = np.cumsum(weight)
    first = last - weight
    borders = [_stretches(first[border], weight[border]) for border in vertex_borders]
    starts = np.append(0, last[ends - 1])
    return Fronts(np.argsort(place[group], kind="stable"), starts, parent, borders)


def _stretches(first: Index, length: Index) -> Index:
    """The numbers first, first + 1, ... of each stretch, one after the other."""
    shift = first - (np.cumsum(length) - length)
    return np.repeat(shift, length) + np.arange(int(length.sum()))
