"""How the forces of shell facets change with their rest state, in closed form and in one pass.

What is derived is W = f'[v].S f + s/2 f.S f, with f the strain and curvature at the corners, f'[v] their rates along a
field v, S the section times the area: the work of the forces along v, and s times the energy. Displacements stay.
With a = S (f'[v] + s f) and b = S f,

    dW = a.df + b.df'[v] + (W / area) d(area),    f = M m,    df = dM m + M dm

for the measures m (see :mod:`kirigami.elements.shell_membrane` and :mod:`kirigami.elements.shell_bending`) and the
matrices M, which are of the chart alone. So everything comes down to derivatives by the vectors v of the facet at rest,
by its chart and by the directors of its edges, which are those of the facets on both sides.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kirigami.elements.shell_bending import edge_frames
from kirigami.elements.shell_chart_back import ChartRates
from kirigami.elements.shell_geometry import (
    EDGE_OF_POINT,
    EDGE_PLACES,
    EDGES,
    MIDDLE_ROWS,
    by_measures,
    combine,
    dot,
    integrated,
)
from kirigami.elements.shell_rates import ALONG, INWARD, Frames, Look, Rates, spread
from kirigami.elements.smooth_normals import sums
from kirigami.primitives.kernel import Array

if TYPE_CHECKING:
    from kirigami.elements.shell_kernel import ShellFacetKernel


def by_rest(kernel: ShellFacetKernel, x: Array, fields: Array, energies: Array) -> Array:
    """Derivatives (k, rows, 3) by the rest state of the work along `fields` (k, rows, 3) and `energies` (k,) times the
    energy."""
    felt = kernel._felt(x)
    by_director = np.zeros((len(fields), *kernel._rest_directors.shape))
    by_vectors = np.empty((len(fields), 5, 3, len(kernel.conn)))
    for look in kernel._looks(x):
        here = _Pass(look, x, felt[look.part])
        edges = kernel._edge[:, look.part], kernel._stored[:, look.part]
        for number, (field, energy) in enumerate(zip(fields, energies.tolist())):
            by_vectors[number, ..., look.part], by_local = here.of(look.rates(field), energy)
            np.add.at(by_director[number], edges, by_local.transpose(0, 2, 1))
    found, onto = [], sums(kernel.conn[:, :6].ravel(), len(kernel.rest))
    for vectors, more in zip(by_vectors, _of_directors(kernel, by_director)):
        rows = np.empty((len(kernel.conn), 6, 3))
        rows[:, 1:] = (vectors + more).transpose(2, 0, 1)
        rows[:, 0] = -rows[:, 1] - rows[:, 2]
        found.append(onto @ rows.reshape(-1, 3))
    return np.array(found)


def _of_directors(kernel: ShellFacetKernel, by_director: Array) -> list[Array]:
    """Derivatives (5, 3, n) by the vectors at rest, of what has some (k, edges, 2, 3) by the directors."""
    frames = edge_frames(kernel._rest_vectors)
    total = np.zeros_like(kernel._rest_directors)
    np.add.at(total, (kernel._edge, kernel._stored), frames.normal.transpose(0, 2, 1))
    size = np.linalg.norm(total, axis=2, keepdims=True)
    unit = kernel._rest_directors
    across = frames.inward / frames.reach[:, None]
    along = frames.tangent / frames.length[:, None] - frames.slant[:, None] * across
    found = []
    for rates in by_director:
        with np.errstate(divide="ignore", invalid="ignore"):
            by_total = np.where(size > 1e-3, (rates - unit * (unit * rates).sum(axis=2, keepdims=True)) / size, 0.0)
        by_normal = by_total[kernel._edge, kernel._stored].transpose(0, 2, 1)
        slope, turn = (dot(by_normal, axis)[:, None] * frames.normal for axis in (along, across))
        found.append(-spread(ALONG, slope) - spread(INWARD, turn))
    return found


class _Pass:
    """Some facets as they are, asked for one field after the other."""

    def __init__(self, look: Look, x: Array, felt: Array) -> None:
        kernel, part = look.kernel, look.part
        self.look, self.felt = look, felt
        self.chart, self.section = kernel.chart, kernel.section[part]
        self.area, self.gradient = kernel.chart.area[part], kernel.chart.gradient[part]
        self.length = kernel.chart.length[part][:, EDGE_OF_POINT].T
        rest = kernel._rest_vectors[..., part]
        self.rest = Frames(rest, kernel._rest_directors[kernel._edge, kernel._stored].transpose(0, 2, 1)[..., part])
        self.angle = np.asarray(x)[look.rows] * look.scale
        # measures as they are
        self.along = combine(ALONG, look.change)
        half = rest + 0.5 * look.change
        self.gram = np.einsum("pan,qan->pqn", half, look.change)
        self.stretch = dot(combine(ALONG, half), self.along) * look.per_square
        self.heights = self._heights(look.frames) - self._heights(self.rest)
        jump = look.frames.angle - self.rest.angle - self.angle
        self.jump = jump - 2 * np.pi * np.round(jump / (2 * np.pi))
        self.by_axis = np.einsum("cqp,nca->aqpn", MIDDLE_ROWS, self.gradient[:, 1:])

    @staticmethod
    def _heights(frames: Frames) -> Array:
        return np.asarray(np.einsum("qan,ean->qen", frames.area.normal, frames.vectors[2:]))

    def of(self, rates: Rates, energy: float) -> tuple[Array, Array]:
        """Derivatives (5, 3, n) by the vectors at rest, and (6, 3, n) by the directors at the Gauss points."""
        look = self.look
        b = self._resultants(self.felt)
        a = self._resultants(rates.fields + energy * self.felt)
        chart = ChartRates(self.chart, look.part)
        chart.area += ((rates.fields + 0.5 * energy * self.felt) * b).sum(axis=(1, 2)) / self.area
        pull, force = (by_measures(look.to_strain, resultant[..., :3]) for resultant in (a, b))
        bend, turn = (by_measures(look.to_curvature, resultant[..., 3:]) for resultant in (a, b))
        found = self._of_membrane(chart, pull, force, rates)
        found += self._of_bending(chart, (a, bend), (b, turn), rates)
        found[:2] += chart.by_corners()
        # the directors at rest, from which the angles there are counted
        seen, edges = self.rest.turned, self.rest.edges
        share = -bend[9:] / seen.square
        return found, (share * seen.side)[:, None] * edges.normal - (share * seen.up)[:, None] * edges.inward

    def _resultants(self, fields: Array) -> Array:
        return integrated(fields @ self.section, self.area)

    def _of_membrane(self, chart: ChartRates, pull: Array, force: Array, rates: Rates) -> Array:
        look = self.look
        # the matrix to the strain at the corners is the inverse of one whose rows are these
        for edge_pull, strain in ((pull, self.felt), (force, rates.fields)):
            chart.by_axes(-edge_pull[:6, None] * _at_points(strain[..., :3]))
        chart.by_length(-2 * (pull[:6] * self.stretch + force[:6] * rates.stretch[:6]) / self.length)
        share = (pull[:6] * look.per_square)[:, None] * self.along
        share += (force[:6] * look.per_square)[:, None] * rates.motion.t
        found = spread(ALONG, share)
        for weight, field in ((pull, look.change), (force, rates.motion.move)):
            form = (look.forms * weight[6:, None, None]).sum(axis=0)
            found += np.einsum("pqn,qan->pan", form, field)
        for axis, rate in enumerate(self._by_axis(pull[6:], force[6:], rates.moving)):
            chart.gradient[:, 1:, axis] += np.einsum("cqp,qpn->nc", MIDDLE_ROWS, rate) / 3
        return np.asarray(found)

    def _by_axis(self, pull: Array, force: Array, moving: Array) -> list[Array]:
        """Derivatives (3, 5, n) by the slopes of the shape functions at the middles, along the two axes."""
        both = [
            one + one.transpose(1, 0, 2)
            for one in (pull[k] * self.gram + force[k] * moving for k in range(3))
        ]  # fmt: skip
        first, second = self.by_axis
        pairs = ((both[0], first, both[2], second), (both[1], second, both[2], first))
        return [
            np.einsum("prn,qrn->qpn", own, mine) + np.einsum("prn,qrn->qpn", mixed, other)
            for own, mine, mixed, other in pairs
        ]

    def _of_bending(
        self, chart: ChartRates, one: tuple[Array, Array], other: tuple[Array, Array], rates: Rates
    ) -> Array:
        look, n = self.look, len(self.felt)
        (a, pull), (b, force) = one, other
        by_across = np.zeros((6, 3, n))
        for resultant, measure in ((a, self.jump), (b, rates.bend[9:])):
            moment = resultant[..., 3:]
            by_across -= _at_points(12 * moment - 3 * moment.sum(axis=1, keepdims=True)) * measure[:, None]
        chart.by_across(by_across / self.area)
        inside = pull[:9].reshape(3, 3, n), force[:9].reshape(3, 3, n)
        by_second = np.einsum("qcn,qen->ecn", inside[0], self.heights)
        by_second += np.einsum("qcn,qen->ecn", inside[1], rates.heights)
        for (p, q), (xx, yy, xy) in zip(EDGES, 8 * by_second):
            for to, of in ((p, q), (q, p)):
                gx, gy = self.gradient[:, of].T
                chart.gradient[:, to, 0] += xx * gx + xy * gy
                chart.gradient[:, to, 1] += yy * gy + xy * gx
        chart.by_length((pull[9:] * self.angle + force[9:] * rates.turn) / self.length)
        here, before = (np.einsum("qcn,ecn->qen", share, look.second) for share in inside)
        found = look.frames.by_heights(here) - self.rest.by_heights(here) + rates.motion.of_heights(before)
        found += look.frames.by_angles(pull[9:]) - self.rest.by_angles(pull[9:]) + rates.motion.of_angles(force[9:])
        return np.asarray(found)


def _at_points(values: Array) -> Array:
    """Sums (6, 3, n) of values (n, 3, 3) at the corners with the barycentric coordinates of the Gauss points."""
    return np.asarray((EDGE_PLACES @ values).transpose(1, 2, 0))
