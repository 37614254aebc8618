"""Bars and bending hinges assembled by compiled loops, where Numba is installed (extra "fast").

Same formulas as :mod:`kirigami.elements.bar` and :mod:`kirigami.elements.bend_hinge`, where they are explained; here
each member is taken to its end, from displacements to entries of the node blocks, without arrays in between. Numba
needs seconds to compile them once per machine and half a second to load, so small systems do without, and all of them
where the environment variable KIRIGAMI_COMPILED is 0.
"""

from __future__ import annotations

import importlib.util
import os
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.primitives.kernel import Array, Configuration, Kernel
from kirigami.system.assembly import BlockPlan, Index

if TYPE_CHECKING:
    from kirigami.elements.bar import BarKernel
    from kirigami.elements.bend_hinge import BendHingeKernel

MEMBERS = 5_000  # below, numpy is fast enough


def serves(kernel: Kernel) -> bool:
    """Whether the compiled loops know this kernel and are worth it."""
    if len(kernel.conn) < MEMBERS or os.environ.get("KIRIGAMI_COMPILED") == "0" or not _installed():
        return False
    from kirigami.elements.bar import BarKernel
    from kirigami.elements.bend_hinge import BendHingeKernel

    if type(kernel) is BarKernel:
        return kernel.strain == "green" and kernel.law == "linear" and kernel.rest.shape[1] == 3
    return type(kernel) is BendHingeKernel


@cache
def _installed() -> bool:
    return importlib.util.find_spec("numba") is not None


def add_forces(kernel: Any, x: Configuration, total: Array) -> float:
    """Add the gradient of a kernel to `total` (n, 3); returns the sum of its squares, member by member."""
    from kirigami.elements import compiled_loops

    if kernel.name == "bars":
        return float(compiled_loops.bar_forces(*_bar(kernel, x), total))
    return float(compiled_loops.hinge_forces(*_hinge(kernel, x), total))


def add_blocks(kernel: Any, x: Configuration, slots: Index, blocks: Array) -> None:
    """Add the Hessian of a kernel to node blocks (blocks, 3, 3); `slots` are those of the block plan."""
    from kirigami.elements import compiled_loops

    if kernel.name == "bars":
        stress = np.empty(0) if kernel._stress_ahead is None else kernel._stress_ahead
        compiled_loops.bar_blocks(*_bar(kernel, x), stress, kernel.convexity, slots, blocks)
    else:
        compiled_loops.hinge_blocks(*_hinge(kernel, x), kernel.convexity, slots, blocks)


def complete(plan: BlockPlan, blocks: Array) -> None:
    """See :meth:`BlockPlan.complete`; here the blocks come as (blocks, 3, 3)."""
    from kirigami.elements import compiled_loops

    compiled_loops.complete(plan.low, plan.high, plan.own, blocks)


def linearize(kernel: Any, x: Configuration, change: Array) -> None:
    """See :meth:`Kernel.linearize`; only bars take part."""
    from kirigami.elements import compiled_loops

    if kernel.name == "bars":
        kernel._stress_ahead = np.empty(len(kernel.conn))
        compiled_loops.bar_stress_ahead(*_bar(kernel, x), np.ascontiguousarray(change), kernel._stress_ahead)


def largest_turn(change: Array, low: Index, high: Index, distance: Array) -> float:
    """Largest relative displacement of joined nodes over their distance, for a change (n, dim)."""
    from kirigami.elements import compiled_loops

    return float(compiled_loops.largest_turn(np.ascontiguousarray(change), low, high, distance))


def _bar(kernel: BarKernel, x: Configuration) -> tuple[Any, ...]:
    u = _displacement(kernel, x)
    return kernel.conn, u, kernel._rest_vector, kernel._rest_strain, kernel.EA, kernel.rest_length


def _hinge(kernel: BendHingeKernel, x: Configuration) -> tuple[Any, ...]:
    edge, wing_i, wing_l = kernel._rest_vectors
    return (
        kernel.conn, _displacement(kernel, x), edge, wing_i, wing_l,
        kernel.stiffness, kernel.rest_angle, kernel._committed,
    )  # fmt: skip


def _displacement(kernel: BarKernel | BendHingeKernel, x: Configuration) -> Array:
    u = x.displacement
    return np.ascontiguousarray(np.asarray(x) - kernel.rest if u is None else u, dtype=float)
