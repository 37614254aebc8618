"""Bending of the shell facet: moments that are linear over the facet (Hellan-Herrmann-Johnson, order one).

With the unit normal n, the moments of the curvature with the barycentric coordinates l_i are, in the components
(11, 22, 2 12) of the chart,

    b_i = int l_i (x,ab.n) dA - sum over edges (L / 2) sum over Gauss points l_i (psi - alpha) (m_1^2, m_2^2, 2 m_1 m_2)

minus the same at rest; m is across the edge. psi is the angle of the facet's normal about the tangent tau of the edge,
measured from a director p that belongs to the edge, psi = atan2(-p.mu, p.n) with mu = n x tau; alpha, one unknown for
all facets on the edge, is the angle of the sheet there. psi - alpha is zero on average where the sheet is smooth, and
no moment jumps across an edge where alpha is free. The curvature over the facet is the linear field with these
moments. (Hellan 1967, Herrmann 1967, Johnson 1973; for shells Neunteufel and Schoeberl, 2019.)

Derivatives in closed form. With t along the edge, g inward, l = |t|, h = dg - (g.tau / l) dt, q = p - (p.tau) tau and
q' = (p.n) mu - (p.mu) n, c = p.tau / q.q,

    psi'  = -n.h / (g.mu) + c q'.dt / l
    psi'' = 2 (n.dt) (tau.h) / (l g.mu) + 2 (n.h) (mu.h) / (g.mu)^2
            + [(n.dt) (mu.dt) + (1 + (p.tau)^2) / (q.q)^2 (q.dt) (q'.dt) - 2 c (tau.dt) (q'.dt)] / l^2

and for n.w, with tangents g_1, g_2 and their dual vectors g^A, n' = -sum (n.dg_A) g^A and

    n''.w = 2 sum (n.dg_A) (g^A.dg_B) (g^B.w) - n.w sum (g^A.g^B) (n.dg_A) (n.dg_B).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kirigami.elements.shell_geometry import (
    AREA_PLACES,
    AREA_ROWS,
    EDGE_OF_POINT,
    EDGE_PLACES,
    EDGE_ROWS,
    EDGES,
    Chart,
    combine,
    cross,
    dot,
    outer,
)
from kirigami.primitives.kernel import Array


def _pairs(first: Array, second: Array) -> Array:
    """(25, points): products of two rows (points, 5) of coefficients, to spread dyads over the vectors v."""
    return np.asarray((first[:, :, None] * second[:, None]).reshape(len(first), 25).T)


_ALONG, _INWARD = EDGE_ROWS
_TT, _TG, _GT, _GG = (_pairs(a, b) for a in EDGE_ROWS for b in EDGE_ROWS)
_AREA_PAIRS = [[_pairs(AREA_ROWS[a], AREA_ROWS[b]) for b in range(2)] for a in range(2)]


class EdgeFrames(NamedTuple):
    """Frames at the six Gauss points of the edges: unit vectors (6, 3, n), else (6, n)."""

    normal: Array
    inward: Array  # mu
    tangent: Array
    length: Array  # of the derivative along the edge
    reach: Array  # inward part of the inward derivative
    slant: Array  # tangential part of it over `length`


class AreaFrames(NamedTuple):
    """Normals (3, 3, n) at the points inside, and dual vectors (2, 3, 3, n) of the tangents there."""

    normal: Array
    dual: Array


def edge_frames(vectors: Array) -> EdgeFrames:
    """Frames at the Gauss points of the edges, of the vectors v (5, 3, n)."""
    along, across = combine(_ALONG, vectors), combine(_INWARD, vectors)
    length = np.sqrt(dot(along, along))
    tangent = along / length[:, None]
    normal = cross(along, across)
    normal /= np.sqrt(dot(normal, normal))[:, None]
    inward = cross(normal, tangent)
    return EdgeFrames(normal, inward, tangent, length, dot(across, inward), dot(across, tangent) / length)


def area_frames(vectors: Array) -> AreaFrames:
    """Normals and dual vectors at the points inside."""
    first, second = (combine(rows, vectors) for rows in AREA_ROWS)
    normal = cross(first, second)
    size = np.sqrt(dot(normal, normal))[:, None]
    normal /= size
    return AreaFrames(normal, np.stack([cross(second, normal), cross(normal, first)]) / size)


def angles(frames: EdgeFrames, directors: Array) -> Array:
    """Angle psi (6, n) of the facet's normal about each edge, from the directors (6, 3, n)."""
    return np.arctan2(-dot(directors, frames.inward), dot(directors, frames.normal))


class Bending:
    """Bending measures of facets and their derivatives by the vectors v (5, 3, n).

    The fifteen measures are the curvatures x,ab.n at the three points inside (nine numbers, point by point) and the
    angles psi at the six Gauss points of the edges.
    """

    def __init__(self, chart: Chart) -> None:
        gradient = chart.gradient
        # second derivatives of 4 l_a l_b in the chart, with the twist counted twice
        pairs = [(gradient[:, a], gradient[:, b]) for a, b in EDGES]
        self.second = np.array(
            [[8 * a[:, 0] * b[:, 0], 8 * a[:, 1] * b[:, 1], 8 * (a[:, 0] * b[:, 1] + a[:, 1] * b[:, 0])]
             for a, b in pairs]
        )  # (edge, component, n)  # fmt: skip
        self.to_curvature = self._to_curvature(chart)

    @staticmethod
    def _to_curvature(chart: Chart) -> Array:
        """Matrices (n, 9, 15) from the measures to the curvature (k11, k22, 2 k12) at the three corners."""
        m = chart.normal[:, EDGE_OF_POINT]
        weight = 0.5 * chart.length[:, EDGE_OF_POINT]
        across = np.stack([m[..., 0] ** 2, m[..., 1] ** 2, 2 * m[..., 0] * m[..., 1]], axis=-1) * weight[..., None]
        moments = np.zeros((len(chart.area), 3, 3, 15))  # corner, component, measure
        for component in range(3):
            moments[:, :, component, component:9:3] = AREA_PLACES / 3
        moments[:, :, :, 9:] = -np.einsum("gi,ngc->nicg", EDGE_PLACES, across) / chart.area[:, None, None, None]
        linear = 12 * moments - 3 * moments.sum(axis=1, keepdims=True)  # inverse of the mass of the l_i
        return np.asarray(linear.reshape(-1, 9, 15))

    def curvatures(self, vectors: Array, frames: AreaFrames) -> Array:
        """x,ab.n at the points inside, (9, n)."""
        heights = np.einsum("qan,ean->qen", frames.normal, vectors[2:])
        return np.asarray(np.einsum("ecn,qen->qcn", self.second, heights).reshape(9, -1))

    def curvature_derivatives(self, vectors: Array, frames: AreaFrames, part: slice) -> Array:
        """First derivatives (9, 5, 3, n) of :meth:`curvatures` by v."""
        second = self.second[..., part]
        tilt = np.einsum("Aqan,ean->Aqen", frames.dual, vectors[2:])
        coefficient = -np.einsum("ecn,Aqen,Aqp->qcpn", second, tilt, AREA_ROWS, optimize=True)
        coefficient[:, :, 2:] += second.transpose(1, 0, 2)
        return np.asarray((coefficient[:, :, :, None] * frames.normal[:, None, None]).reshape(9, 5, 3, -1))

    def curvature_second(self, force: Array, vectors: Array, frames: AreaFrames, part: slice) -> Array:
        """Second derivatives (25, 3, 3, n) by pairs of v of the curvatures (9, n), summed with `force`."""
        shares = np.einsum("qcn,ecn->qen", force.reshape(3, 3, -1), self.second[..., part])
        load = np.einsum("qen,ean->qan", shares, vectors[2:])
        normal, dual = frames
        height = dot(normal, load)
        tilt = np.stack([dot(dual[0], load), dot(dual[1], load)])
        twice = outer(normal, normal) * height[:, None, None]
        n = vectors.shape[-1]
        total = np.zeros((25, 9 * n))
        for a in range(2):
            for b in range(2):
                block = outer(normal, dual[a] * tilt[b][:, None]) + outer(dual[b] * tilt[a][:, None], normal)
                block -= twice * dot(dual[a], dual[b])[:, None, None]
                total += _AREA_PAIRS[a][b] @ block.reshape(3, -1)
        result = total.reshape(5, 5, 3, 3, n)
        turn = np.concatenate([outer(normal, dual[0]), outer(normal, dual[1])])  # (6, 3, 3, n)
        rows = AREA_ROWS.reshape(6, 5).T
        for edge in range(3):
            share = np.tile(shares[:, edge], (2, 1))[:, None, None]
            mixed = (rows @ (turn * share).reshape(6, -1)).reshape(5, 3, 3, n)
            result[:, 2 + edge] -= mixed
            result[2 + edge] -= mixed.transpose(0, 2, 1, 3)
        return result.reshape(25, 3, 3, n)


def angle_derivatives(frames: EdgeFrames, directors: Array) -> Array:
    """First derivatives (6, 5, 3, n) of :func:`angles` by v."""
    _, turned, lean, square = _seen(frames, directors)
    slide = (lean / (square * frames.length))[:, None] * turned
    lever = -frames.normal / frames.reach[:, None]
    rows = _INWARD[:, :, None] - frames.slant[:, None] * _ALONG[:, :, None]
    return np.asarray(rows[:, :, None] * lever[:, None] + _ALONG[:, :, None, None] * slide[:, None])


def angle_second(force: Array, frames: EdgeFrames, directors: Array) -> Array:
    """Second derivatives (25, 3, 3, n) by pairs of v of the angles, summed with `force` (6, n)."""
    normal, inward, tangent, length, reach, slant = frames
    seen, turned, lean, square = _seen(frames, directors)
    mixed = outer(normal, tangent) * (force / (length * reach))[:, None, None]
    bent = outer(normal, inward)
    inner = (bent + _turned_over(bent)) * (force / reach**2)[:, None, None]
    curl = 0.5 * ((1 + lean**2) / square**2)[:, None] * seen - (lean / square)[:, None] * tangent
    along = 0.5 * bent + outer(turned, curl)
    along = (along + _turned_over(along)) * (force / length**2)[:, None, None]
    rho = slant[:, None, None]
    along = along - rho * (mixed + _turned_over(mixed)) + rho**2 * inner
    mixed = mixed - rho * inner
    n = force.shape[-1]
    total = _TT @ along.reshape(6, -1) + _GG @ inner.reshape(6, -1)
    total += _TG @ mixed.reshape(6, -1) + _GT @ _turned_over(mixed).reshape(6, -1)
    return np.asarray(total.reshape(25, 3, 3, n))


def _seen(frames: EdgeFrames, directors: Array) -> tuple[Array, Array, Array, Array]:
    """The director across the edge (q), turned by a right angle (q'), its part along the edge, and q.q."""
    up, side, lean = (dot(directors, axis)[:, None] for axis in frames[:3])
    seen = up * frames.normal + side * frames.inward
    turned = up * frames.inward - side * frames.normal
    return seen, turned, lean[:, 0], (up**2 + side**2)[:, 0]


def _turned_over(dyads: Array) -> Array:
    return np.asarray(dyads.swapaxes(-3, -2))
