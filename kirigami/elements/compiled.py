"""The compiled twins of bars, bending hinges and the edges that clamps hold, for Numba (extra "fast").

Same formulas as :mod:`kirigami.elements.bar` and its neighbours, where they are explained; here
each member is taken to its end, from displacements to entries of the node blocks, without arrays in between.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements import compiled_loops, held_loops
from kirigami.primitives.kernel import Array, CompiledKernel, Configuration, Tangent, displacement_of

if TYPE_CHECKING:
    from kirigami.elements.bar import BarKernel
    from kirigami.elements.bend_hinge import BendHingeKernel
    from kirigami.elements.clamp_hinge import HeldEdgeKernel

Index = NDArray[np.int64]


class CompiledBars(CompiledKernel):
    """Twin of the bars in Green strain with a linear law, in three dimensions."""

    _kernel: BarKernel

    def __init__(self, kernel: BarKernel) -> None:
        self._kernel = kernel

    def _state(self, x: Array, lam: float) -> tuple[Any, ...]:
        kernel = self._kernel
        u = np.ascontiguousarray(displacement_of(x, kernel.rest))
        return kernel.conn, u, kernel._rest_vector, kernel.start_strain(lam), kernel.EA, kernel.rest_length

    def add_forces(self, x: Configuration, lam: float, total: Array) -> float:
        return float(compiled_loops.bar_forces(*self._state(x, lam), total))

    def add_blocks(self, x: Configuration, lam: float, tangent: Tangent, slots: Index, blocks: Array) -> None:
        stress = np.empty(0)
        if tangent.ahead is not None:
            start, change = tangent.ahead
            stress = np.empty(len(self._kernel.conn))
            compiled_loops.bar_stress_ahead(*self._state(start, lam), np.ascontiguousarray(change), stress)
        compiled_loops.bar_blocks(*self._state(x, lam), stress, tangent.convexity, slots, blocks)


class CompiledHinges(CompiledKernel):
    """Twin of the bending hinges."""

    _kernel: BendHingeKernel

    def __init__(self, kernel: BendHingeKernel) -> None:
        self._kernel = kernel

    def _state(self, x: Array, lam: float) -> tuple[Any, ...]:
        kernel = self._kernel
        edge, wing_i, wing_l = kernel._rest_vectors
        u = np.ascontiguousarray(displacement_of(x, kernel.rest))
        return kernel.conn, u, edge, wing_i, wing_l, kernel.stiffness, kernel.rest_angle_at(lam), kernel._committed

    def add_forces(self, x: Configuration, lam: float, total: Array) -> float:
        return float(compiled_loops.hinge_forces(*self._state(x, lam), total))

    def add_blocks(self, x: Configuration, lam: float, tangent: Tangent, slots: Index, blocks: Array) -> None:
        compiled_loops.hinge_blocks(*self._state(x, lam), tangent.convexity, slots, blocks)


class CompiledHeldEdges(CompiledKernel):
    """Twin of the held edges of bars and hinges, each of which is one turn of its facet."""

    _kernel: HeldEdgeKernel

    def __init__(self, kernel: HeldEdgeKernel) -> None:
        self._kernel = kernel

    def _state(self, x: Array, lam: float) -> tuple[Any, ...]:
        kernel, turns = self._kernel, self._kernel._turns
        u, natural = np.ascontiguousarray(displacement_of(x, kernel.rest)), kernel.natural(lam)
        stands = turns.initial if natural is None else turns.initial + natural
        return (
            kernel.conn, u, turns._edge, turns._wing, turns._unit, turns._direction, turns.carried, turns.committed,
            stands, kernel.stiffness,
        )  # fmt: skip

    def add_forces(self, x: Configuration, lam: float, total: Array) -> float:
        return float(held_loops.forces(*self._state(x, lam), total))

    def add_blocks(self, x: Configuration, lam: float, tangent: Tangent, slots: Index, blocks: Array) -> None:
        held_loops.blocks(*self._state(x, lam), tangent.convexity, slots, blocks)
