"""The turn of a facet about its edge, against a direction that the edge carries along or that stands still.

The wing i of the facet (j, k, i), with height h over the edge e = x_k - x_j, foot fraction beta, unit vector t away
from the edge and normal n = u x t, u = e / |e|, has turned by the angle phi from the direction m towards u x m. With
c = (1, beta - 1, -beta) and d = (0, -1, 1) for the nodes (i, j, k),

    d phi / d x_p        = c_p n / h - d_p a
    d2 phi / d x_p d x_q = -c_p c_q (n t' + t n') / h^2 - (c_p d_q u n' + d_p c_q n u') / (h |e|)
                           - d_p d_q ((n t' + t n') / (2 |e|^2) + sym a')

where a(e) is the spin of m about the edge, and only the symmetric part of its derivative a' counts, because the other
one cancels with that of the wing.

* A clamp carries its direction along: m is the rest direction m_0 turned by the smallest rotation that takes the edge
  from e_0 (unit, at rest) to u. Then a = (e x e_0) / D, D = |e| (|e| + e_0.e). An edge that turns about m_0, as one
  that tilts, or about the normal, as one that turns in the plane, takes its direction along exactly. It may not turn
  right round.
* A mirror plane stands still: m is its normal N, made perpendicular to the edge, which lies in the plane. Then
  a = -(N.e) (e x N) / D, D = |e| (|e|^2 - (N.e)^2). The facet and its mirror image fold by 2 phi.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.angle import TURN
from kirigami.primitives.kernel import Array, displacement_of

ALONG = np.array([0.0, -1.0, 1.0])  # d of the nodes i, j, k


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("na,na->n", a, b))


def _dyads(a: Array, b: Array) -> Array:
    """Symmetric part (n, 3, 3) of a b'."""
    product = a[:, :, None] * b[:, None]
    return np.asarray(0.5 * (product + product.swapaxes(1, 2)))


def _cross(a: Array, b: Array) -> Array:
    """Products (n, 3) as numpy.cross makes them, to the bit, without what it does before it begins."""
    product = np.empty_like(a)
    for axis, (one, other) in enumerate(((1, 2), (2, 0), (0, 1))):
        np.multiply(a[:, one], b[:, other], out=product[:, axis])
        product[:, axis] -= a[:, other] * b[:, one]
    return product


def _length(a: Array) -> Array:
    return np.asarray(np.sqrt(_dot(a, a)))


class EdgeTurn:
    """Angles phi of many edges.

    Parameters
    ----------
    rest : ndarray, shape (rows, 3)
        Rest positions.
    lines : ndarray of int, shape (n, 3)
        Wing i and ends j, k of each edge, counter-clockwise in the facet.
    normal : ndarray, shape (n, 3)
        Normals of mirror planes; not read where the direction is carried.
    carried : ndarray of bool, shape (n,)
        True for clamps, whose direction is that of the facet at rest; False for mirror planes.
    """

    def __init__(self, rest: Array, lines: NDArray[np.int64], normal: Array, carried: NDArray[np.bool_]) -> None:
        self.rest, self.lines, self.carried = rest, lines, carried
        self._edge, self._wing = self._vectors(rest)
        self._unit = self._edge / np.linalg.norm(self._edge, axis=1)[:, None]
        off = self._wing - _dot(self._wing, self._unit)[:, None] * self._unit
        inward = normal * np.where(_dot(normal, off) < 0, -1.0, 1.0)[:, None]
        self._direction = np.where(carried[:, None], off / np.linalg.norm(off, axis=1)[:, None], inward)
        self.initial = self._raw(self._edge, self._wing)
        self.committed = self.initial.copy()

    def _vectors(self, points: Array) -> tuple[Array, Array]:
        i, j, k = self.lines.T
        return np.asarray(points[k] - points[j]), np.asarray(points[i] - points[j])

    def vectors(self, x: Array) -> tuple[Array, Array]:
        """Current edge and wing vectors (n, 3)."""
        edge, wing = self._vectors(displacement_of(x, self.rest))
        return self._edge + edge, self._wing + wing

    def _raw(self, edge: Array, wing: Array) -> Array:
        u = edge / _length(edge)[:, None]
        m = self._direction - np.where(
            self.carried[:, None],
            (_dot(u, self._direction) / (1 + _dot(u, self._unit)))[:, None] * (self._unit + u),
            _dot(u, self._direction)[:, None] * u,
        )
        m /= _length(m)[:, None]
        return np.asarray(np.arctan2(_dot(wing, _cross(u, m)), _dot(wing, m)))

    def angles(self, x: Array) -> Array:
        """Angle (n,) [rad], with the turns it has made since the rest state."""
        raw = self._raw(*self.vectors(x))
        return np.asarray(raw + TURN * np.round((self.committed - raw) / TURN))

    def _frame(self, edge: Array, wing: Array) -> tuple[Array, Array, Array, Array, Array, Array]:
        """|e|, u, h, c (n, 3), t and n."""
        length = _length(edge)
        u = edge / length[:, None]
        beta = _dot(wing, u) / length
        off = wing - (beta * length)[:, None] * u
        height = _length(off)
        t = off / height[:, None]
        c = np.stack([np.ones_like(beta), beta - 1, -beta], axis=1)
        return length, u, height, c, t, _cross(u, t)

    def _spin(self, edge: Array, length: Array, need: int) -> tuple[Array, Array | None]:
        """a (n, 3), and where `need` is 2 the symmetric part (n, 3, 3) of its derivative."""
        if self.carried.all():
            return self._carried_spin(edge, length, need)
        if not self.carried.any():
            return self._still_spin(edge, length, need)
        (a, by_edge), (other, by_other) = (
            spin(edge, length, need) for spin in (self._carried_spin, self._still_spin)
        )
        chosen = self.carried[:, None]
        if by_edge is None or by_other is None:
            return np.where(chosen, a, other), None
        return np.where(chosen, a, other), np.where(chosen[..., None], by_edge, by_other)

    def _carried_spin(self, edge: Array, length: Array, need: int) -> tuple[Array, Array | None]:
        """Of clamps."""
        e_0 = self._unit
        along = _dot(e_0, edge)
        w = _cross(edge, e_0)
        size = length * (length + along)
        if need < 2:
            return w / size[:, None], None
        change = 2 * edge + (along / length)[:, None] * edge + length[:, None] * e_0
        return w / size[:, None], -_dyads(w, change) / (size**2)[:, None, None]

    def _still_spin(self, edge: Array, length: Array, need: int) -> tuple[Array, Array | None]:
        """Of mirror planes."""
        normal = self._direction
        p = _dot(normal, edge)
        w = _cross(edge, normal)
        across = length**2 - p**2
        size = length * across
        spin = -(p / size)[:, None] * w
        if need < 2:
            return spin, None
        change = (across / length)[:, None] * edge + 2 * length[:, None] * (edge - p[:, None] * normal)
        return spin, -_dyads(w, normal) / size[:, None, None] + (p / size**2)[:, None, None] * _dyads(w, change)

    def first_derivatives(self, edge: Array, wing: Array) -> Array:
        """Gradient (n, 3 nodes, 3) of the angles by the positions of i, j and k."""
        length, _, height, c, _, n = self._frame(edge, wing)
        spin, _ = self._spin(edge, length, 1)
        return np.asarray(c[:, :, None] * (n / height[:, None])[:, None] - ALONG[:, None] * spin[:, None])

    def second_derivatives(self, edge: Array, wing: Array) -> Array:
        """Second derivatives (n, 3, 3, 3, 3): node and node, then direction and direction."""
        length, u, height, c, t, n = self._frame(edge, wing)
        _, twist = self._spin(edge, length, 2)
        assert twist is not None
        bend = 2 * _dyads(n, t)
        slant = (u[:, :, None] * n[:, None]) / (height * length)[:, None, None]
        cd = c[:, :, None] * ALONG
        both = (0.5 / length**2)[:, None, None] * bend + twist
        cc, dd = c[:, :, None] * c[:, None], ALONG[:, None] * ALONG
        found = cc[..., None, None] * (bend / -(height**2)[:, None, None])[:, None, None]
        sloped = cd[..., None, None] * slant[:, None, None]
        found -= sloped
        found -= sloped.transpose(0, 2, 1, 4, 3)
        found -= dd[..., None, None] * both[:, None, None]
        return np.asarray(found)
