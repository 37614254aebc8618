"""The compiled twin of shell facets, for Numba (extra "fast")."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements import shell_loops
from kirigami.primitives.kernel import Array, Configuration, Tangent, displacement_of

if TYPE_CHECKING:
    from kirigami.elements.shell_kernel import ShellFacetKernel

Index = NDArray[np.int64]


class CompiledShell:
    """Twin of :class:`kirigami.elements.shell_kernel.ShellFacetKernel`, with each facet's numbers side by side."""

    def __init__(self, kernel: ShellFacetKernel) -> None:
        self._kernel = kernel
        membrane, bending = kernel._membrane, kernel._bending
        self._rest = _by_facet(kernel._rest_vectors)
        self._membrane = _by_facet(membrane.per_square), _by_facet(membrane.mean_forms)
        self._matrices = np.ascontiguousarray(membrane.to_strain), np.ascontiguousarray(bending.to_curvature)
        self._section = (
            _by_facet(bending.second), np.ascontiguousarray(kernel.section), kernel.chart.area,
            _by_facet(kernel._rest_angles), _by_facet(kernel._rest_curvatures),
        )  # fmt: skip
        self._stored, self._scale = _by_facet(kernel._stored), _by_facet(kernel._angle_scale)

    def _state(self, x: Array) -> tuple[Any, ...]:
        kernel = self._kernel
        u = np.ascontiguousarray(displacement_of(x, kernel.rest), dtype=float)
        directors = _by_facet(kernel._local_directors())
        return (
            kernel.conn, np.ascontiguousarray(x, dtype=float), u, self._rest, *self._membrane, *self._matrices,
            *self._section, directors, self._stored, self._scale,
        )  # fmt: skip

    def add_forces(self, x: Configuration, lam: float, total: Array) -> float:
        return float(shell_loops.forces(*self._state(x), total))

    def add_blocks(self, x: Configuration, lam: float, tangent: Tangent, slots: Index, blocks: Array) -> None:
        ahead = np.empty((0, 9))
        if tangent.ahead is not None:
            start, change = tangent.ahead
            kernel = self._kernel
            u = np.ascontiguousarray(displacement_of(start, kernel.rest), dtype=float)
            curvature = np.ascontiguousarray(kernel.curvature(start)) if kernel.coupled else np.zeros((len(u), 3, 3))
            ahead = np.empty((len(kernel.conn), 9))
            shell_loops.pull_ahead(
                kernel.conn, u, np.ascontiguousarray(change, dtype=float), self._rest, *self._membrane,
                self._matrices[0], self._section[1], self._section[2], curvature, ahead,
            )  # fmt: skip
        shell_loops.blocks(
            *self._state(x), self._kernel.chart.tangent, ahead, float(tangent.convexity), slots, blocks
        )


def _by_facet(values: Any) -> Any:
    """The facets' numbers side by side: the last axis first, in memory too."""
    return np.ascontiguousarray(np.moveaxis(values, -1, 0))
