"""From derivatives by what a chart of facets holds to those by the two vectors from corner 0 to the others."""

from __future__ import annotations

import numpy as np

from kirigami.elements.shell_geometry import EDGES, Chart
from kirigami.primitives.kernel import Array


class ChartRates:
    """Derivatives of something by the chart of a `part` of the facets; see :class:`Chart`.

    Attributes
    ----------
    area : ndarray, shape (n,)
    gradient : ndarray, shape (n, 3, 2)
        By the gradients of the barycentric coordinates.
    """

    def __init__(self, chart: Chart, part: slice) -> None:
        self._vectors = chart.corner_vectors[:, :, part]
        self._length, self._tangent = chart.length[part], chart.tangent[part]
        self._normal, self._areas = chart.normal[part], chart.area[part]
        self._gradients = chart.gradient[part]
        n = len(self._areas)
        self.area, self.gradient = np.zeros(n), np.zeros((n, 3, 2))
        self._by_length, self._by_tangent, self._by_normal = np.zeros((n, 3)), np.zeros((n, 3, 2)), np.zeros((n, 3, 2))

    def by_length(self, rate: Array) -> None:
        """Add derivatives (6, n) by the lengths of the edges, Gauss point by Gauss point."""
        self._by_length += (rate[::2] + rate[1::2]).T

    def by_axes(self, rate: Array) -> None:
        """Add derivatives (6, 3, n) by (x^2, y^2, x y) of the tangents."""
        self._by_tangent += _of_dyad(self._tangent, rate, 1.0)

    def by_across(self, rate: Array) -> None:
        """Add derivatives (6, 3, n) over the area by L / 2 (x^2, y^2, 2 x y) of the normals, over the area."""
        both = (rate[::2] + rate[1::2]).transpose(2, 0, 1)
        x, y = self._normal[..., 0], self._normal[..., 1]
        dyads = np.stack([x * x, y * y, 2 * x * y], axis=-1)
        share = 0.5 * (both * dyads).sum(axis=2)
        self._by_length += share
        self.area -= (share * self._length).sum(axis=1) / self._areas
        self._by_normal += 0.5 * self._length[..., None] * _of_dyad(self._normal, rate, 2.0)

    def by_corners(self) -> Array:
        """Derivatives (2, 3, n) by the vectors from corner 0 to corners 1 and 2."""
        by_tangent = self._by_tangent.copy()  # the normal is (y, -x) of the tangent
        by_tangent[..., 0] -= self._by_normal[..., 1]
        by_tangent[..., 1] += self._by_normal[..., 0]
        t = self._tangent
        by_edge = (by_tangent - t * (t * by_tangent).sum(axis=2, keepdims=True)) / self._length[..., None]
        by_edge += self._by_length[..., None] * t
        by_area = self.area - (self.gradient * self._gradients).sum(axis=(1, 2)) / self._areas
        opposite = np.stack([self.gradient[..., 1], -self.gradient[..., 0]], axis=-1) / (2 * self._areas)[:, None, None]
        by_edge[:, [1, 2, 0]] += opposite
        by_place = np.zeros_like(by_edge)
        for number, (a, b) in enumerate(EDGES):
            by_place[:, b] += by_edge[:, number]
            by_place[:, a] -= by_edge[:, number]
        first, second = self._vectors
        base = np.linalg.norm(first, axis=0)
        along = first / base
        foot = (along * second).sum(axis=0)
        up = second - foot * along
        height = np.linalg.norm(up, axis=0)
        up = up / height
        by_base, by_foot = by_place[:, 1, 0] + 0.5 * height * by_area, by_place[:, 2, 0]
        by_height = by_place[:, 2, 1] + 0.5 * base * by_area
        return np.stack([
            by_base * along + (by_foot * height - by_height * foot) / base * up, by_foot * along + by_height * up
        ])  # fmt: skip


def _of_dyad(vectors: Array, rate: Array, twist: float) -> Array:
    """Derivatives (n, 3, 2) by vectors of what has those `rate` (6, 3, n) by (x^2, y^2, twist x y) at the points."""
    xx, yy, xy = (rate[::2] + rate[1::2]).transpose(1, 2, 0)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([2 * x * xx + twist * y * xy, 2 * y * yy + twist * x * xy], axis=-1)
