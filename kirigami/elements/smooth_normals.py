"""Normals of the smooth surface through the nodes of facets, how edges bulge by them, and the derivatives of both."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.geometry.folds import SHARP
from kirigami.primitives.kernel import Array

Index = NDArray[np.int64]


def edge_bulges(
    points: Array, triangles: Index, edge: Index, normals: Sequence[Any], is_fold: NDArray[np.bool_]
) -> Array:
    """Offsets (edges, 3) of the middles of edges: the mean over the facets on each of what their normals ask for."""
    found = np.zeros((len(is_fold), 3))
    given = np.array([normal is not None for normal in normals], dtype=bool)
    flat = np.ptp(points[triangles.ravel()], axis=0).min() == 0.0
    if flat and not given.any():
        return found
    own = corner_normals(points, triangles, edge, is_fold)
    if given.any():
        known = np.array([normal for normal in normals if normal is not None])
        own[given] = known / np.linalg.norm(known, axis=2, keepdims=True)
    np.add.at(found, edge.ravel(), bulges(*at_edge_ends(points, triangles, own)))
    return np.asarray(found / np.bincount(edge.ravel())[:, None])


def edge_bulges_back(
    points: Array, triangles: Index, edge: Index, is_fold: NDArray[np.bool_], by_bulge: Array
) -> Array:
    """Derivatives (k, points, 3) by the points of what has the derivatives `by_bulge` (k, edges, 3) by
    :func:`edge_bulges`, where no normals are given."""
    surface = SmoothSurface(points, triangles, edge, is_fold)
    ends, normals = at_edge_ends(points, triangles, surface.normals)
    shared = by_bulge / np.bincount(edge.ravel())[:, None]
    onto = sums(triangles.ravel(), len(points))
    found = []
    for rates in shared:
        by_ends, by_normals = bulges_back(ends, normals, rates[edge.ravel()])
        by_ends, by_normals = by_ends.reshape(-1, 3, 2, 3), by_normals.reshape(-1, 3, 2, 3)
        total = onto @ (by_ends[:, :, 0] + np.roll(by_ends[:, :, 1], 1, axis=1)).reshape(-1, 3)
        found.append(total + surface.back(by_normals[:, :, 0] + np.roll(by_normals[:, :, 1], 1, axis=1)))
    return np.array(found)


def sums(places: Index, count: int) -> Any:
    """A sparse matrix (count, n) that sums up what stands in n rows by their places (n,)."""
    from scipy.sparse import csr_array

    return csr_array((np.ones(len(places)), (places, np.arange(len(places)))), shape=(count, len(places)))


def at_edge_ends(points: Array, triangles: Index, normals: Array) -> tuple[Array, Array]:
    """Places and normals (3 m, 2, 3) at the two ends of every edge of facets."""
    ends = np.stack([points[triangles], points[np.roll(triangles, -1, axis=1)]], axis=2)
    at_ends = np.stack([normals, np.roll(normals, -1, axis=1)], axis=2)
    return ends.reshape(-1, 2, 3), at_ends.reshape(-1, 2, 3)


def bulges(ends: Array, normals: Array) -> Array:
    """Offsets (n, 3) of the middles of edges from the mean of their `ends` (n, 2, 3), given the normals (n, 2, 3)
    there: the arc of a circle through both ends, to the angle between the slopes."""
    chord = ends[:, 1] - ends[:, 0]
    square = (chord**2).sum(axis=1)
    up = normals.sum(axis=1)
    up -= ((up * chord).sum(axis=1) / square)[:, None] * chord
    with np.errstate(divide="ignore", invalid="ignore"):  # normals along the edge say nothing
        up /= np.linalg.norm(up, axis=1)[:, None]
    length = np.sqrt(square)
    along = np.einsum("nka,na->nk", normals, chord) / length[:, None]
    slope = np.arctan2(-along, np.einsum("nka,na->nk", normals, up))
    return np.asarray((0.5 * length * np.tan(0.25 * (slope[:, 0] - slope[:, 1])))[:, None] * up)


def bulges_back(ends: Array, normals: Array, by_bulge: Array) -> tuple[Array, Array]:
    """Derivatives (n, 2, 3) by the ends and by the normals of what has those `by_bulge` (n, 3) by :func:`bulges`."""
    chord = ends[:, 1] - ends[:, 0]
    square = (chord**2).sum(axis=1)
    length = np.sqrt(square)
    mean = normals.sum(axis=1)
    lean = (mean * chord).sum(axis=1) / square
    off = mean - lean[:, None] * chord
    size = np.linalg.norm(off, axis=1)
    up = off / size[:, None]
    along = np.einsum("nka,na->nk", normals, chord) / length[:, None]
    rise = np.einsum("nka,na->nk", normals, up)
    slope = np.arctan2(-along, rise)
    tangent = np.tan(0.25 * (slope[:, 0] - slope[:, 1]))
    lifted = (by_bulge * up).sum(axis=1)
    by_up = (0.5 * length * tangent)[:, None] * by_bulge
    by_length = 0.5 * tangent * lifted
    by_slope = (0.125 * length * (1 + tangent**2) * lifted)[:, None] * np.array([1.0, -1.0])
    by_slope /= along**2 + rise**2
    by_along, by_rise = -rise * by_slope, along * by_slope
    by_normals = by_along[..., None] * (chord / length[:, None])[:, None] + by_rise[..., None] * up[:, None]
    by_chord = np.einsum("nk,nka->na", by_along, normals) / length[:, None]
    by_length -= (by_along * along).sum(axis=1) / length
    by_up += np.einsum("nk,nka->na", by_rise, normals)
    by_off = (by_up - up * (up * by_up).sum(axis=1)[:, None]) / size[:, None]
    by_lean = -(by_off * chord).sum(axis=1)
    by_chord += (by_lean / square)[:, None] * mean - lean[:, None] * by_off
    by_chord += (by_length / length - 2 * by_lean * lean / square)[:, None] * chord
    by_normals += (by_off + (by_lean / square)[:, None] * chord)[:, None]
    return np.stack([-by_chord, by_chord], axis=1), by_normals


def corner_normals(points: Array, triangles: Index, edge: Index, is_fold: NDArray[np.bool_]) -> Array:
    """Unit normals (m, 3, 3) at the corners of facets, see :class:`SmoothSurface`."""
    return SmoothSurface(points, triangles, edge, is_fold).normals


class SmoothSurface:
    """The smooth surface through the nodes of facets, up to the next fold: its unit normals (m, 3, 3) at the corners.

    First the mean of the facets around, weighted by sin / (|a| |b|) of the two sides at the corner (Max, 1999), then
    that of the paraboloid through the node which fits those around it best: it does not lean at a free edge.
    """

    def __init__(self, points: Array, triangles: Index, edge: Index, is_fold: NDArray[np.bool_]) -> None:
        self._count, self._triangles = len(points), triangles
        corner = points[triangles]
        self._ahead = np.roll(corner, -1, axis=1) - corner
        self._back = np.roll(corner, 1, axis=1) - corner
        product = np.cross(self._ahead, self._back)
        facet = product[:, 0] / np.linalg.norm(product[:, 0], axis=1)[:, None]
        self._squares = (self._ahead**2).sum(axis=2), (self._back**2).sum(axis=2)
        self._weighted = product / (self._squares[0] * self._squares[1])[..., None]
        nodes = triangles.ravel()
        parts, self._label = _smooth_parts(nodes, facet, edge, is_fold)
        self._node = np.zeros(parts, np.int64)
        self._node[self._label] = nodes
        total = np.zeros((parts, 3))
        np.add.at(total, self._label, self._weighted.reshape(-1, 3))
        size = np.linalg.norm(total, axis=1)
        self._size = np.where(size > 0, size, 1.0)
        mean = total / self._size[:, None]
        self._fit = _Paraboloids(points[self._node], mean, self._label.reshape(-1, 3))
        self._told = (size > 0)[self._label].reshape(-1, 3, 1)
        fitted = self._fit.normals[self._label].reshape(-1, 3, 3)
        self.normals: Array = np.where(self._told, fitted, facet[:, None])

    def back(self, by_normals: Array) -> Array:
        """Derivatives (n, 3) by the points of what has those `by_normals` (m, 3, 3) by the normals at the corners."""
        by_fitted = self._onto_parts @ np.where(self._told, by_normals, 0.0).reshape(-1, 3)
        by_mean, by_place = self._fit.back(by_fitted)
        mean = self._fit.normal
        by_total = (by_mean - mean * (mean * by_mean).sum(axis=1)[:, None]) / self._size[:, None]
        rate = by_total[self._label].reshape(-1, 3, 3)
        share = 2 * (rate * self._weighted).sum(axis=2)
        product = rate / (self._squares[0] * self._squares[1])[..., None]
        by_ahead = np.cross(self._back, product) - (share / self._squares[0])[..., None] * self._ahead
        by_back = np.cross(product, self._ahead) - (share / self._squares[1])[..., None] * self._back
        at_corner = np.roll(by_ahead, 1, axis=1) + np.roll(by_back, -1, axis=1) - by_ahead - by_back
        found = self._onto_nodes @ at_corner.reshape(-1, 3)
        np.add.at(found, self._node, by_place)
        return np.asarray(found)

    @cached_property
    def _onto_parts(self) -> Any:
        return sums(self._label, len(self._node))

    @cached_property
    def _onto_nodes(self) -> Any:
        return sums(self._triangles.ravel(), self._count)


def _smooth_parts(nodes: Index, facet: Array, edge: Index, is_fold: NDArray[np.bool_]) -> tuple[int, Index]:
    """Number of smooth parts around nodes, and the one that each corner (3 m,) of facets belongs to."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    # Link the corners of two facets at both ends of each smooth edge.
    order = np.argsort(edge.ravel(), kind="stable")
    ranked = edge.ravel()[order]
    twice = np.flatnonzero((ranked[1:] == ranked[:-1]) & (np.bincount(ranked)[ranked[1:]] == 2))
    one, two = order[twice], order[twice + 1]
    smooth = ((facet[one // 3] * facet[two // 3]).sum(axis=1) > np.cos(SHARP)) & ~is_fold[ranked[twice]]
    one, two = one[smooth], two[smooth]
    next_one, next_two = one // 3 * 3 + (one + 1) % 3, two // 3 * 3 + (two + 1) % 3
    opposed = nodes[one] != nodes[two]  # neighbours alike oriented run along the edge in opposite directions
    links = np.concatenate(
        [
            np.stack([one, np.where(opposed, next_two, two)], axis=1),
            np.stack([next_one, np.where(opposed, two, next_two)], axis=1),
        ]
    )
    graph = coo_array((np.ones(len(links), np.int8), (links[:, 0], links[:, 1])), shape=(nodes.size, nodes.size))
    parts, label = connected_components(graph, directed=False)
    return int(parts), label


class _Paraboloids:
    """Normals (n, 3) at points of smooth surfaces, from a first guess: of the paraboloids through the points that fit
    their neighbours and the neighbours of these, the nearer ones more; the guess where there are too few."""

    def __init__(self, place: Array, normal: Array, triangles: Index) -> None:
        from scipy.sparse import coo_array

        self.normal, n = normal, len(place)
        rows, columns = (
            np.concatenate([triangles[:, k] for k in which]) for which in ((0, 1, 2, 1, 2, 0), (1, 2, 0, 0, 1, 2))
        )
        near = coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(n, n)).tocsr()
        near.data[:] = 1
        pairs = (near + near @ near).tocoo()
        at, to = pairs.row[pairs.row != pairs.col], pairs.col[pairs.row != pairs.col]
        arm = place[to] - place[at]
        distance = np.linalg.norm(arm, axis=1)
        apart = distance > 0
        self._at, self._to, self._arm, self._distance = at[apart], to[apart], arm[apart], distance[apart]
        at = self._at
        reach = np.zeros(n)
        np.maximum.at(reach, at, self._distance)
        self._scale = reach[at]  # by which everything is divided, so that the answer does not feel it
        self._aside = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
        across = np.cross(normal, self._aside)
        self._across = np.linalg.norm(across, axis=1)
        self._first = across / self._across[:, None]
        self._second = np.cross(normal, self._first)
        x, y, z = (
            (self._arm * axis[at]).sum(axis=1) / self._scale for axis in (self._first, self._second, normal)
        )
        self._terms = np.stack([x, y, x * x, x * y, y * y], axis=1)
        self._height = z
        self._weight = (self._scale / self._distance) ** 2
        matrix, right = np.zeros((n, 5, 5)), np.zeros((n, 5))
        np.add.at(matrix, at, self._weight[:, None, None] * self._terms[:, :, None] * self._terms[:, None])
        np.add.at(right, at, (self._weight * z)[:, None] * self._terms)
        values = np.linalg.eigvalsh(matrix)
        sound = values[:, 0] > 1e-4 * values[:, -1]
        matrix[~sound] = np.eye(5)
        self._matrix, self._terms_of = matrix, np.linalg.solve(matrix, right[..., None])[..., 0]
        slope = self._terms_of[:, :2].copy()
        sound &= np.linalg.norm(slope, axis=1) < 1.0
        slope[~sound] = 0.0
        self._sound, self._slope = sound, slope
        found = normal - slope[:, :1] * self._first - slope[:, 1:] * self._second
        self._stretch = np.linalg.norm(found, axis=1)[:, None]
        self.normals: Array = found / self._stretch

    @cached_property
    def _onto_at(self) -> Any:
        return sums(self._at, len(self.normals))

    @cached_property
    def _onto_to(self) -> Any:
        return sums(self._to, len(self.normals))

    @cached_property
    def _seen(self) -> Array:
        """The arms (3, pairs) along the axes of the paraboloids, over the scale."""
        return np.stack([self._terms[:, 0], self._terms[:, 1], self._height])

    @cached_property
    def _fitted(self) -> Array:
        """What was fitted (5, pairs) to each pair's point."""
        return np.ascontiguousarray(self._terms_of.T[:, self._at])

    @cached_property
    def _left(self) -> Array:
        """By how much each pair is missed (pairs,), times its weight."""
        return np.asarray(self._weight * (self._height - (self._terms.T * self._fitted).sum(axis=0)))

    def back(self, by_normals: Array) -> tuple[Array, Array]:
        """Derivatives (n, 3) by the first guess and by the places of what has those `by_normals` (n, 3)."""
        by_found = (by_normals - self.normals * (self.normals * by_normals).sum(axis=1)[:, None]) / self._stretch
        right = np.zeros((len(by_found), 5))
        right[:, 0] = -(by_found * self._first).sum(axis=1)
        right[:, 1] = -(by_found * self._second).sum(axis=1)
        right[~self._sound] = 0.0
        # s = M^-1 b of a sum over pairs: with M l = ds, what changes s is l.(db - dM s)
        multiplier = np.linalg.solve(self._matrix, right[..., None])[:, :, 0].T[:, self._at]
        x, y = self._seen[:2]
        share = (multiplier * self._terms.T).sum(axis=0)
        by_height = self._weight * share
        by_terms = self._left * multiplier - by_height * self._fitted
        rates = np.stack([
            by_terms[0] + 2 * x * by_terms[2] + y * by_terms[3], by_terms[1] + x * by_terms[3] + 2 * y * by_terms[4],
            by_height,
        ])  # fmt: skip
        # by the arm along the axes of the paraboloid, and by these axes
        by_arm = rates / self._scale - 2 * self._left * share * self._scale / self._distance**2 * self._seen
        axes = np.stack([self._first, self._second, self.normal])  # (3, n, 3)
        turned = [np.stack([self._onto_at @ (rate * arm) for arm in self._seen]) for rate in rates]
        by_first, by_second, by_normal = (np.einsum("kn,kna->na", each, axes) for each in turned)
        by_first -= self._slope[:, :1] * by_found
        by_second -= self._slope[:, 1:] * by_found
        by_normal += by_found
        by_place = self._onto_to @ np.einsum("kp,kpa->pa", by_arm, axes[:, self._at])
        by_place -= np.einsum("kn,kna->na", np.stack([self._onto_at @ rate for rate in by_arm]), axes)
        by_normal += np.cross(self._first, by_second)
        by_first += np.cross(by_second, self.normal)
        by_across = (by_first - self._first * (self._first * by_first).sum(axis=1)[:, None]) / self._across[:, None]
        return by_normal + np.cross(self._aside, by_across), by_place
