"""The border of a periodic cell: rows that follow u_i = u_source + E R, with the mean strain E in a row of its own.

R is the sum of lattice vectors between a row and the one it repeats. The row of the strain holds (exx, eyy, gxy) of a
sheet, or the one strain along the lattice vector of a strip, times a length, so that it compares with displacements.
Rows that are differences of positions, or angles, repeat their sources as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kirigami.primitives.following import FollowingRows, Index, Links
from kirigami.primitives.kernel import Array


@dataclass(frozen=True, eq=False)
class CellRows(FollowingRows):
    """The rows on the border of a cell, and beyond it, that repeat others.

    Attributes
    ----------
    repeats, sources : ndarray of int, shape (k,)
        Rows that follow and those they repeat, first the positions.
    slopes : ndarray, shape (p, dim, dim)
        Derivatives of the p positions by the row of the strain.
    strain : int
        Row of the mean strain times `scale`.
    scale : float
        Length of the lattice vectors [length].
    nodes : int
        How many of the positions are nodes; the others stand behind them.
    apart : ndarray, shape (p, dim)
        From the source of each position to it, at rest [length].
    steps : ndarray of int, shape (k, m)
        Lattice vectors between each row that follows and its source.
    beyond : ndarray of int, shape (s, 2)
        For each edge on the border that repeats another one: rows of the far corners of the facets beyond them, first
        that beyond the edge that repeats; -1 where no element asks for them.
    """

    repeats: Index
    sources: Index
    slopes: Array
    strain: int
    scale: float
    nodes: int
    apart: Array
    steps: Index
    beyond: Index
    words = "the border of a periodic cell"
    one_of_many = True
    remedy = "tie it to the node which that one repeats instead"

    @property
    def followers(self) -> Index:
        return self.repeats

    @property
    def links(self) -> Links:
        p = len(self.slopes)
        return Links(
            np.concatenate([self.repeats, self.repeats[:p]]),
            np.concatenate([self.sources, np.full(p, self.strain)]),
            np.concatenate([np.zeros(len(self.repeats), np.int64), 1 + np.arange(p)]),
        )

    def rates(self, u: Array) -> Array:
        return self.slopes

    def fill(self, u: Array) -> None:
        u[self.repeats] = u[self.sources]
        u[self.repeats[: len(self.slopes)]] += self.slopes @ u[self.strain]

    def lead(self, field: Array, spin: Array, about: Array) -> None:
        """No strain turns a cell; the copies of nodes beyond its border move with the whole."""
        copies = slice(self.nodes, len(self.slopes))
        arms = self.apart[copies] + self.slopes[copies] @ about[self.strain]
        field[self.repeats[copies]] = field[self.sources[copies]] + np.cross(spin, arms)

    def lead_rates(self, field: Array, about: Array) -> None:
        self._fit(field)

    def settle(self, rows: Array) -> None:
        self._fit(rows)
        self.fill(rows)

    def _fit(self, rows: Array) -> None:
        """The strain that the nodes tell of."""
        n = self.nodes
        apart = rows[self.repeats[:n]] - rows[self.sources[:n]]
        slopes = self.slopes[:n].reshape(-1, rows.shape[1])
        rows[self.strain] = np.linalg.lstsq(slopes, apart.ravel(), rcond=1e-9)[0]
