"""Membrane strain of the shell facet: linear over the facet, out of nine numbers (Regge interpolation, order one).

The Green strain E = (x,a.x,b - X,a.X,b) / 2 of a six-node triangle is quadratic. It is replaced by the linear tensor
field that shares with it

* the strain along the edge at the two Gauss points of every edge, r = (|x'|^2 - |X'|^2) / (2 L^2), which neighbours
  share: bending to a cylinder of curvature k strains it to fourth order in k h only, so that nothing locks;
* the mean over the facet: under a uniform tension only this enters, a sum of squares of slopes, so that no tension
  makes a flat sheet buckle.

All nine are quadratic forms r = Delta(v' Q v) / 2 of the five vectors v of :mod:`kirigami.elements.shell_geometry`,
taken from displacements, r = (Q V + Q u / 2).u, which loses no digits at small strain. (Regge 1961; Neunteufel and
Schoeberl, 2021; the mean is what makes it safe in tension.)
"""

from __future__ import annotations

import numpy as np

from kirigami.elements.shell_geometry import (
    EDGE_OF_POINT,
    EDGE_PLACES,
    EDGE_ROWS,
    MIDDLE_ROWS,
    Chart,
    combine,
    dot,
)
from kirigami.primitives.kernel import Array

_EDGE_FORMS = EDGE_ROWS[0][:, :, None] * EDGE_ROWS[0][:, None]  # (6, 5, 5)


class Membrane:
    """Strain measures of facets and their derivatives by the vectors v (5, 3, n)."""

    def __init__(self, rest: Array, chart: Chart) -> None:
        self.rest = rest
        self.per_square = 1.0 / (chart.length**2)[:, EDGE_OF_POINT].T  # (6, n)
        # Derivatives by the chart of the shape functions of v, at the middles of the edges: the mean of a quadratic.
        by_axis = np.einsum("cqp,nca->aqpn", MIDDLE_ROWS, chart.gradient[:, 1:])  # (2, 3 points, 5, n)
        mean = np.einsum("aqpn,bqrn->abprn", by_axis, by_axis) / 3
        self.mean_forms = np.stack([mean[0, 0], mean[1, 1], mean[0, 1] + mean[1, 0]])  # (3, 5, 5, n)
        tangent = chart.tangent[:, EDGE_OF_POINT]
        x, y = tangent[..., 0], tangent[..., 1]
        self._along = np.stack([x * x, y * y, x * y], axis=-1)  # (n, 6, 3)
        self.to_strain = self._to_strain(self._along)

    @staticmethod
    def _to_strain(along: Array) -> Array:
        """Matrices (n, 9, 9) from the nine measures to (exx, eyy, gamma_xy) at the three corners."""
        rows = np.zeros((len(along), 9, 3, 3))
        rows[:, :6] = EDGE_PLACES[:, :, None] * along[:, :, None]
        rows[:, 6:] = np.eye(3)[:, None] / 3
        return np.asarray(np.linalg.inv(rows.reshape(-1, 9, 9)))

    def measures(self, change: Array) -> Array:
        """The nine measures (9, n) at a change of the vectors v from rest."""
        found = np.empty((9, change.shape[-1]))
        along = combine(EDGE_ROWS[0], change)
        found[:6] = dot(combine(EDGE_ROWS[0], self.rest) + 0.5 * along, along) * self.per_square
        gram = np.einsum("pan,qan->pqn", self.rest + 0.5 * change, change)
        found[6:] = np.einsum("cpqn,pqn->cn", self.mean_forms, gram)
        return found

    def derivatives(self, vectors: Array, part: slice) -> Array:
        """First derivatives (9, 5, 3, n) of the measures by v; `part` says which facets `vectors` belong to."""
        found = np.empty((9, 5, 3, vectors.shape[-1]))
        along = combine(EDGE_ROWS[0], vectors) * self.per_square[:, None, part]
        found[:6] = EDGE_ROWS[0][:, :, None, None] * along[:, None]
        found[6:] = np.einsum("cpqn,qan->cpan", self.mean_forms[..., part], vectors)
        return found

    def second_derivatives(self, force: Array, part: slice) -> Array:
        """Sum (5, 5, n) of `force` (9, n) times the forms Q: the second derivative is this times the unit matrix."""
        edges = force[:6] * self.per_square[:, part]
        found: Array = np.einsum("gpq,gn->pqn", _EDGE_FORMS, edges)
        found += np.einsum("cpqn,cn->pqn", self.mean_forms[..., part], force[6:])
        return found

    def tension_form(self, force: Array, part: slice) -> Array:
        """What remains of :meth:`second_derivatives` when the force of the facet is taken as uniform and its
        compressive principal part is dropped: a form (5, 5, n) that is never negative."""
        resultant = np.einsum("gn,ngc->cn", force[:6], self._along[part]) + force[6:]
        mean, half = 0.5 * (resultant[0] + resultant[1]), 0.5 * (resultant[0] - resultant[1])
        radius = np.hypot(half, resultant[2])
        high, low = np.maximum(mean + radius, 0.0), np.maximum(mean - radius, 0.0)
        turn = 0.5 * (high - low) / np.where(radius > 0, radius, 1.0)
        centre = 0.5 * (high + low)
        kept = np.stack([centre + turn * half, centre - turn * half, turn * resultant[2]])
        return np.asarray(np.einsum("cpqn,cn->pqn", self.mean_forms[..., part], kept))
