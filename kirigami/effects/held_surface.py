"""The surface that contact holds apart: fixed mixtures of the nodes of a sheet, and behind them those of obstacles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.kernel import Array


class HeldSurface:
    """How nodes of the surface follow the nodes of the sheet, and how forces on it go back to those.

    Parameters
    ----------
    rows : int
        Rows of all positions, of which those of nodes are some.
    nodes : ndarray of int, shape (n,)
        Nodes of the sheet.
    fixed : ndarray, shape (f, 3)
        Nodes of the obstacles.
    mixed, shares : ndarray, shapes (k, 2) and (k,)
        Nodes of the surface that is held, the nodes they are mixed of, and their shares.
    """

    def __init__(self, rows: int, nodes: NDArray[np.int64], fixed: Array, mixed: NDArray[np.int64], shares: Array):
        from scipy.sparse import csr_matrix, identity, kron

        count = len(nodes)
        self.rows, self.nodes, self.fixed = rows, nodes, fixed
        self._plain = bool(len(shares) == count and (mixed[:, 0] == mixed[:, 1]).all() and (shares == 1.0).all())
        self._mix = csr_matrix((shares, mixed.T), shape=(count, count))
        self._mix_axes = kron(self._mix, identity(3)).tocsr()
        self._axes = (3 * nodes[:, None] + np.arange(3)).ravel()

    def at(self, x: Array) -> Array:
        """Positions (n + f, 3) of its nodes when those of the sheet are at `x`."""
        own = np.asarray(x, dtype=float)[self.nodes]
        own = own if self._plain else self._mix @ own
        return np.asfortranarray(np.concatenate([own, self.fixed]) if len(self.fixed) else own)

    def back(self, force: Array) -> Array:
        """Forces (n + f, 3) on its nodes as forces (n, 3) on those of the sheet."""
        own = force[: len(self.nodes)]
        return np.asarray(own if self._plain else self._mix.T @ own)

    def coupling(self, hessian: Any) -> Any:
        """A sparse Hessian over its nodes (3 (n + f), 3 (n + f)) as one over all rows of the sheet."""
        from scipy.sparse import coo_matrix

        moving = 3 * len(self.nodes)
        if not self._plain:
            hessian = self._mix_axes.T @ hessian.tocsc()[:moving, :moving] @ self._mix_axes
        own = hessian.tocoo()
        row, column, data = own.row, own.col, own.data
        if self._plain and len(self.fixed):
            kept = (row < moving) & (column < moving)
            row, column, data = row[kept], column[kept], data[kept]
        size = 3 * self.rows
        return coo_matrix((data, (self._axes[row], self._axes[column])), shape=(size, size))
