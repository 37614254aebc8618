"""A reduced matrix with what couples rows beyond the plan of blocks, in a pattern that changes as rarely as it can.

Pairs in contact come and go from one correction to the next, but what follows from the pattern of a matrix, an order of
elimination above all, costs several factorisations. So node pairs that were coupled once keep their places, with zeros,
until new ones come and most of the old ones have gone.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.primitives.kernel import Array
from kirigami.system.assembly import Index

CROWDED = 3  # times the pairs that couple now, and more than there are nodes: then the others are forgotten


class CouplingPlan:
    """Where entries of the plain matrix, and those of coupled node pairs, stand in the matrix of both.

    Parameters
    ----------
    unknown : ndarray of int
        Unknown of each displacement, negative where it is none.
    size : int
        Number of unknowns.
    dim : int
        Axes.

    Attributes
    ----------
    pairs : ndarray of int, shape (k,)
        Coupled pairs of nodes, n_nodes * first + second. A run that goes on needs those it had, since the last bits of
        every solution come from the order of elimination.
    """

    def __init__(self, unknown: Index, size: int, dim: int) -> None:
        self.unknown, self.size, self.dim = unknown, size, dim
        self.nodes = len(unknown) // dim
        self.pairs: Index = np.empty(0, dtype=np.int64)
        self._plain: Any = None  # whose pattern is known
        self._codes: Index | None = None

    def remember(self, pairs: Index) -> None:
        """Take over the pairs that were coupled when a run was interrupted."""
        self.pairs, self._codes = np.asarray(pairs, dtype=np.int64), None

    def matrix(self, plain: Any, more: Any) -> Any:
        """The sum of a CSC matrix (size, size) and a sparse one over all displacements, None where nothing couples."""
        from scipy.sparse import csc_matrix

        if more is None and not len(self.pairs):
            return plain
        if plain.indices is not self._plain:
            self._plain, self._codes = plain.indices, None
        codes, values = np.empty(0, dtype=np.int64), np.empty(0)
        if more is not None:
            codes, values = self._entries(more.tocoo())
        if self._codes is None:
            self._place(plain)
        assert self._codes is not None
        at = np.searchsorted(self._codes, codes)
        data = np.bincount(at, values, minlength=len(self._codes)).astype(float)  # of nothing it makes whole numbers
        data[self._at] += plain.data
        matrix = csc_matrix((data, self.indices, self.indptr), shape=plain.shape)
        matrix.indices, matrix.indptr = self.indices, self.indptr  # the same objects: solvers know the pattern by them
        return matrix

    def _entries(self, entries: Any) -> tuple[Index, Array]:
        """Codes, column by column, and values of the entries over unknowns; new node pairs get their places."""
        row, column = self.unknown[entries.row], self.unknown[entries.col]
        kept = (row >= 0) & (column >= 0)
        pairs = np.unique((entries.row[kept] // self.dim).astype(np.int64) * self.nodes + entries.col[kept] // self.dim)
        joined = np.union1d(self.pairs, pairs)
        if len(joined) > len(self.pairs):
            crowded = len(joined) > max(CROWDED * len(pairs), self.nodes)
            self.pairs = pairs if crowded else joined
            self._codes = None
        return column[kept].astype(np.int64) * self.size + row[kept], entries.data[kept]

    def _place(self, plain: Any) -> None:
        """Give every entry of the plain matrix and of the coupled pairs its place."""
        own = np.repeat(np.arange(self.size, dtype=np.int64), np.diff(plain.indptr)) * self.size + plain.indices
        axes = np.arange(self.dim)
        first, second = (self.dim * part[:, None] + axes for part in np.divmod(self.pairs, self.nodes))
        row, column = np.broadcast_arrays(self.unknown[first][:, :, None], self.unknown[second][:, None])
        kept = (row >= 0) & (column >= 0)
        row, column = row[kept].astype(np.int64), column[kept].astype(np.int64)
        wanted = np.unique(np.concatenate([column * self.size + row, row * self.size + column]))
        near = np.searchsorted(own, wanted)
        new = wanted[own[np.minimum(near, len(own) - 1)] != wanted]
        self._codes = np.insert(own, np.searchsorted(own, new), new)  # sorted both: no need to sort all
        self._at = np.arange(len(own)) + np.searchsorted(new, own)
        self.indptr = np.searchsorted(self._codes, np.arange(self.size + 1) * self.size).astype(np.int32)
        self.indices = (self._codes % self.size).astype(np.int32)
