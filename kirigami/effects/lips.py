"""Pairs of a surface that are closer at rest than its thickness: neighbours along the sheet, and lips of slits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array

ALONG = 2.0  # way along the sheet, over thickness and longest edge, up to which a close pair counts as neighbours
COINCIDENT = 1e-9  # distance over the size of the sheet at which nodes coincide, as on lips of a slit


@dataclass(frozen=True)
class ClosePair:
    """Two edges, or a node and a facet, that are close at rest."""

    stencil: Any
    corners: tuple[list[int], list[int]]
    edges: NDArray[np.int32]
    triangles: NDArray[np.int32]

    def distance(self, places: Array) -> float:
        """Their distance at positions (n, 3)."""
        return float(np.sqrt(self.stencil.compute_distance(places, self.edges, self.triangles)))

    def node_pairs(self) -> list[tuple[int, int]]:
        """The pairs of nodes, one of each part, lower number first."""
        first, second = self.corners
        return [(min(a, b), max(a, b)) for a in first for b in second if a != b]


def coincident(drawn: Array) -> NDArray[np.int64]:
    """Pairs (k, 2) of nodes that coincide where they are drawn (n, 3), as on the lips of a slit."""
    from scipy.spatial import cKDTree

    size = float(np.linalg.norm(np.ptp(drawn, axis=0)))
    pairs = cKDTree(drawn).query_pairs(COINCIDENT * size, output_type="ndarray")
    return np.asarray(pairs, dtype=np.int64)


def drawn_in(drawn: Array, triangles: NDArray[np.int64], apart: float) -> Any:
    """Sparse matrix (n, n) that takes nodes to a surface whose lips of slits are `apart`.

    A node on a lip goes towards the centroid c of the facets about it, at most all the way; with c' that of the node it
    coincides with, it goes half of `apart` along c - c'.
    """
    from scipy.sparse import coo_matrix, diags

    n = len(drawn)
    corners = triangles.ravel()
    others = np.repeat(triangles, 3, axis=0)
    rows, columns = np.repeat(corners, 3), others.ravel()
    fan = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(n, n)).tocsr()
    mean = diags(1.0 / np.maximum(np.asarray(fan.sum(axis=1)).ravel(), 1.0)) @ fan
    inward = mean @ drawn - drawn
    share = np.zeros(n)
    for one, other in coincident(drawn):
        across = inward[one] - inward[other]
        size = float(np.linalg.norm(across))
        for node, sign in ((one, 1.0), (other, -1.0)):
            far = sign * float(inward[node] @ across) / size if size > 0 else 0.0
            share[node] = max(share[node], min(0.5 * apart / far, 1.0) if far > 0 else 0.0)
    return (diags(1.0 - share) + diags(share) @ mean).tocsr()


def close_pairs(surface: Any, places: Array, thickness: float, toolkit: Any) -> list[ClosePair]:
    """All pairs of a collision mesh that are closer than `thickness` at positions (n, 3)."""
    candidates = toolkit.Candidates()
    candidates.build(surface, places, 0.5 * thickness, toolkit.LBVH())
    edges, triangles = surface.edges, surface.faces
    found = []
    for group, split in ((candidates.ee_candidates, 2), (candidates.fv_candidates, 1), (candidates.ev_candidates, 1)):
        for stencil in group:
            if stencil.compute_distance(places, edges, triangles) < thickness**2:
                nodes = [int(node) for node in stencil.vertex_ids(edges, triangles) if node >= 0]
                found.append(ClosePair(stencil, (nodes[:split], nodes[split:]), edges, triangles))
    return found


def check_gaps(
    pairs: Sequence[ClosePair],
    places: Array,
    drawn: Array,
    edges: NDArray[np.int64],
    sheet: int,
    thickness: float,
    owner: str,
) -> None:
    """Raise a ModelError where a pair close at rest is neither neighbours along the sheet nor lips of a slit.

    Nodes that coincide where they are `drawn`, without an imperfection, count as joined; `sheet` is the number of nodes
    that are not of obstacles.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    own = [pair for pair in pairs if min(node for part in pair.corners for node in part) < sheet]
    if not own:
        return
    size = float(np.linalg.norm(np.ptp(places, axis=0)))
    twins = coincident(drawn)
    links = np.concatenate([edges, twins])
    length = np.linalg.norm(places[links[:, 1]] - places[links[:, 0]], axis=1)
    graph = coo_matrix((np.maximum(length, COINCIDENT * size), links.T), shape=(len(places),) * 2).tocsr()
    reach = ALONG * (thickness + float(length.max()))
    starts = np.unique([pair.corners[0][0] for pair in own])
    way = dijkstra(graph, directed=False, indices=starts, limit=reach)
    row = {int(node): number for number, node in enumerate(starts)}
    for pair in own:
        first, second = pair.corners[0][0], pair.corners[1][0]
        if not np.isfinite(way[row[first], second]):
            raise ModelError(
                f"{owner}: the thickness {thickness:.4g} is larger than the gap at rest, {pair.distance(places):.4g} "
                f"between nodes {first} and {second} at ({', '.join(f'{value:.4g}' for value in places[first])}): "
                "give a smaller thickness=, or draw the gap wider"
            )
