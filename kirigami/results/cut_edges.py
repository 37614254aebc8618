"""The edges round the cuts of a sheet, and the rows of those that bulge: an edge of shell facets is a parabola."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kirigami.geometry.topology import pair_numbers
from kirigami.primitives.kernel import Array, Kernel

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh
    from kirigami.results.results import Results

Index = NDArray[np.int64]


class CutEdges(NamedTuple):
    """Edges round one cut, counter-clockwise: from node `start` to node `end`, with the row of the offset of their
    middles, or -1 where they are straight, as the mouth of an open cut is; all (k,)."""

    start: Index
    end: Index
    middle: Index

    @property
    def curved(self) -> NDArray[np.bool_]:
        """Which edges may bulge."""
        return np.asarray(self.middle >= 0)

    def area(self, x: Array) -> tuple[float, Array]:
        """Area within the edges in the plane xy at rows `x` (rows, 2 or 3), and its derivative by them.

        The shoelace formula, and 2/3 of bulge times chord for each edge beyond it.
        """
        chord, across = x[self.end, :2] - x[self.start, :2], x[self.start, :2] + x[self.end, :2]
        total = 0.25 * _cross(across, chord).sum()
        rate = np.zeros_like(x)
        _add(rate, self.start, 0.5 * _turned(x[self.end, :2]))
        _add(rate, self.end, -0.5 * _turned(x[self.start, :2]))
        rows, along = self.middle[self.curved], chord[self.curved]
        bulge = x[rows, :2]
        total += _cross(bulge, along).sum() * 2 / 3
        _add(rate, rows, 2 / 3 * _turned(along))
        _add(rate, self.end[self.curved], -2 / 3 * _turned(bulge))
        _add(rate, self.start[self.curved], 2 / 3 * _turned(bulge))
        return float(total), rate


def _add(rate: Array, rows: Index, values: Array) -> None:
    for axis in (0, 1):
        np.add.at(rate[:, axis], rows, values[:, axis])


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _turned(a: Array) -> Array:
    """Derivative of b x a by b."""
    return np.stack([a[:, 1], -a[:, 0]], axis=1)


def cut_edges(results: Results, mesh: TriMesh) -> list[CutEdges]:
    """The edges round every cut of the mesh of some results, found once for all who ask."""
    return results.once("cut edges", lambda: _found(mesh, results.kernels, len(results.rest)))


def _found(mesh: TriMesh, kernels: Sequence[Kernel], points: int) -> list[CutEdges]:
    ends, rows = np.zeros((0, 2), np.int64), np.full(1, -1)
    for kernel in kernels:
        if kernel.name == "shell":
            ends = np.stack([kernel.conn[:, :3], np.roll(kernel.conn[:, :3], -1, axis=1)], axis=2).reshape(-1, 2)
            rows = np.append(kernel.conn[:, 3:6].ravel(), -1)
    found = []
    for cut in mesh.cuts:
        start = np.asarray(cut.loop)
        end = np.roll(start, -1)
        middle = rows[pair_numbers(np.stack([start, end], axis=1), ends, points)]
        found.append(CutEdges(start, end, middle))
    return found


def bulges(results: Results, edges: Sequence[CutEdges]) -> list[Array]:
    """Offsets (s, k, 2) of the middles of the edges round each cut from the mean of their ends, in the plane xy."""
    found = [np.zeros((len(results), len(each.start), 2)) for each in edges]
    if not any(each.curved.any() for each in edges):
        return found
    for number, step in enumerate(results.steps):
        x = np.asarray(results.configuration(step))
        for each, offsets in zip(edges, found):
            offsets[number, each.curved] = x[each.middle[each.curved], :2]
    return found
