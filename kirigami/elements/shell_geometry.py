"""The six-node triangle of the shell facet: its shape, its chart, and the tables of its points.

Corners 0, 1, 2 and the edges 01, 12, 20 with middles at (x_a + x_b) / 2 + w_e. With barycentric coordinates l the
position is x = sum l_i x_i + 4 sum l_a l_b w_e, so that five vectors say everything but the place:

    v = (x_1 - x_0, x_2 - x_0, w_01, w_12, w_20)

Derivatives of x along barycentric directions at fixed points are fixed combinations of these five: the tables below.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.kernel import Array

EDGES = ((0, 1), (1, 2), (2, 0))  # corners that each edge leaves from and goes to
GAUSS = (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0))


def slope_row(place: Array, direction: Array) -> Array:
    """Coefficients (5,) on the vectors v of the derivative of x at barycentric `place` along a direction of sum 0."""
    middles = [4 * (place[a] * direction[b] + place[b] * direction[a]) for a, b in EDGES]
    return np.array([direction[1], direction[2], *middles])


def _edge_place(edge: int, along: float) -> Array:
    place = np.zeros(3)
    place[EDGES[edge][0]], place[EDGES[edge][1]] = 1 - along, along
    return place


def _edge_rows(place: Array, edge: int) -> list[Array]:
    """Derivatives along an edge, and from its middle towards the opposite corner."""
    a, b = EDGES[edge]
    along, inward = np.zeros(3), np.full(3, 1.0)
    along[a], along[b] = -1.0, 1.0
    inward[[a, b]] = -0.5
    return [slope_row(place, along), slope_row(place, inward)]


EDGE_OF_POINT = np.repeat(np.arange(3), 2)
EDGE_PLACES = np.array([_edge_place(edge, along) for edge in range(3) for along in GAUSS])  # (6, 3) barycentric
# (2, 6, 5): along the edge, and inward, at the two Gauss points of each edge
EDGE_ROWS = np.array(
    [_edge_rows(place, edge) for place, edge in zip(EDGE_PLACES, EDGE_OF_POINT.tolist())]
).transpose(1, 0, 2)
AREA_PLACES = np.full((3, 3), 1 / 6) + 0.5 * np.eye(3)  # exact for quadratics over the facet
_AXES = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
# (2, 3, 5): along the edges from corner 0, at the points inside
AREA_ROWS = np.array([[slope_row(place, axis) for place in AREA_PLACES] for axis in _AXES])
_MIDDLES = np.array([_edge_place(edge, 0.5) for edge in range(3)])
MIDDLE_ROWS = np.array([[slope_row(place, axis) for place in _MIDDLES] for axis in _AXES])  # (2, 3, 5)


def dot(a: Array, b: Array) -> Array:
    """Scalar products of vectors whose components stand on the last axis but one."""
    return np.asarray((a * b).sum(axis=-2))


def cross(a: Array, b: Array) -> Array:
    """Vector products of vectors whose components stand on the last axis but one."""
    a0, a1, a2 = (a[..., k, :] for k in range(3))
    b0, b1, b2 = (b[..., k, :] for k in range(3))
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=-2)


def outer(a: Array, b: Array) -> Array:
    """Dyads (..., 3, 3, n) of vectors (..., 3, n)."""
    return np.asarray(a[..., :, None, :] * b[..., None, :, :])


def combine(table: Array, vectors: Array) -> Array:
    """Sums (k, 3, n) of the vectors v (5, 3, n) with the rows of a table (k, 5)."""
    return np.asarray((table @ vectors.reshape(5, -1)).reshape(len(table), *vectors.shape[1:]))


def facet_vectors(rows: Array, conn: NDArray[np.int64]) -> Array:
    """The vectors v (5, 3, n) of facets, out of the rows of a system (corners, then middles of the edges)."""
    at = rows[conn[:, :6]].transpose(1, 2, 0)
    vectors = np.empty((5, 3, len(conn)))
    vectors[0], vectors[1] = at[1] - at[0], at[2] - at[0]
    vectors[2:] = at[3:]
    return vectors


class Chart:
    """The facets laid out flat: the plane of the corners, first axis along edge 01.

    Attributes
    ----------
    area : ndarray, shape (n,)
    length : ndarray, shape (n, 3)
        Length of the chord of each edge.
    tangent, normal : ndarray, shape (n, 3, 2)
        Unit vectors along each edge and across it.
    gradient : ndarray, shape (n, 3, 2)
        Of the barycentric coordinates.
    corner_vectors : ndarray, shape (2, 3, n)
        From corner 0 to the others, in space.
    """

    def __init__(self, vectors: Array) -> None:
        self.corner_vectors = vectors[:2]
        first, second = vectors[0].T, vectors[1].T
        base = np.linalg.norm(first, axis=1)
        foot = np.einsum("na,na->n", first, second) / base
        height = np.linalg.norm(second - (foot / base)[:, None] * first, axis=1)
        place = np.zeros((len(base), 3, 2))
        place[:, 1, 0], place[:, 2, 0], place[:, 2, 1] = base, foot, height
        self.area = 0.5 * base * height
        along = np.stack([place[:, b] - place[:, a] for a, b in EDGES], axis=1)
        self.length = np.linalg.norm(along, axis=2)
        self.tangent = along / self.length[..., None]
        self.normal = np.stack([self.tangent[..., 1], -self.tangent[..., 0]], axis=-1)
        opposite = along[:, [1, 2, 0]]
        self.gradient = np.stack([-opposite[..., 1], opposite[..., 0]], axis=-1) / (2 * self.area)[:, None, None]


def corner_fields(matrix: Array, measures: Array) -> Array:
    """Fields (n, 3, 3) at the corners, of measures (k, n), by matrices (n, 9, k)."""
    return np.asarray((matrix @ measures.T[:, :, None]).reshape(-1, 3, 3))


def by_measures(matrix: Array, resultants: Array) -> Array:
    """Derivatives (k, n) of the energy by the measures, of those by the fields at the corners (n, 3, 3)."""
    return np.asarray((resultants.reshape(-1, 1, 9) @ matrix)[:, 0].T)


def integrated(fields: Array, area: Array) -> Array:
    """Integrals (n, 3, k) over facets of the barycentric coordinates times fields (n, 3, k) at the corners."""
    return np.asarray((fields + fields.sum(axis=1, keepdims=True)) * (area / 12)[:, None, None])
