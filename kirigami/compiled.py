"""Bars and bending hinges assembled by compiled loops, where Numba is installed (extra "fast").

Same formulas as :mod:`kirigami.elements.bar` and :mod:`kirigami.elements.bend_hinge`, where they are explained; here
each member is taken to its end, from displacements to entries of the node blocks, without arrays in between. Numba
needs seconds to compile them once per machine and half a second to load, so small systems do without, and all of them
where the environment variable KIRIGAMI_COMPILED is 0.
"""

from __future__ import annotations

import importlib.util
import math
import os
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from kirigami.assembly import Index
from kirigami.kernel import Array, Configuration, Kernel

if TYPE_CHECKING:
    from kirigami.elements.bar import BarKernel
    from kirigami.elements.bend_hinge import BendHingeKernel

MEMBERS = 5_000  # below, numpy is fast enough


class Loops(NamedTuple):
    """The compiled functions: forces and blocks of bars and of hinges."""

    bar_forces: Callable[..., float]
    bar_blocks: Callable[..., None]
    hinge_forces: Callable[..., float]
    hinge_blocks: Callable[..., None]


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
    if kernel.name == "bars":
        return compile_loops().bar_forces(*_bar(kernel, x), total)
    return compile_loops().hinge_forces(*_hinge(kernel, x), total)


def add_blocks(kernel: Any, x: Configuration, slots: Index, blocks: Array) -> None:
    """Add the Hessian of a kernel to node blocks (blocks, 3, 3); `slots` are those of the block plan."""
    if kernel.name == "bars":
        stress = np.empty(0) if kernel._stress_ahead is None else kernel._stress_ahead
        compile_loops().bar_blocks(*_bar(kernel, x), stress, kernel.convexity, slots, blocks)
    else:
        compile_loops().hinge_blocks(*_hinge(kernel, x), kernel.convexity, slots, blocks)


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


@cache
def compile_loops() -> Loops:
    """Compile the loops, or load them from Numba's cache."""
    from numba import njit

    compiled = njit(cache=True, error_model="numpy")

    @compiled
    def bar_state(m, conn, u, rest_vector, rest_strain, rest_length, vector):  # type: ignore[no-untyped-def]
        """Green strain of bar m, and its current vector."""
        i, j = conn[m, 0], conn[m, 1]
        strain = 0.0
        for axis in range(3):
            change = u[j, axis] - u[i, axis]
            vector[axis] = rest_vector[axis, m] + change
            strain += (rest_vector[axis, m] + 0.5 * change) * change
        return rest_strain[m] + strain / rest_length[m] ** 2

    @compiled
    def bar_forces(conn, u, rest_vector, rest_strain, EA, rest_length, total):  # type: ignore[no-untyped-def]
        vector = np.empty(3)
        squares = 0.0
        for m in range(len(conn)):
            strain = bar_state(m, conn, u, rest_vector, rest_strain, rest_length, vector)
            scale = EA[m] * strain / rest_length[m]
            for axis in range(3):
                pull = scale * vector[axis]
                squares += 2 * pull * pull
                total[conn[m, 0], axis] -= pull
                total[conn[m, 1], axis] += pull
        return squares

    @compiled
    def bar_blocks(  # type: ignore[no-untyped-def]
        conn, u, rest_vector, rest_strain, EA, rest_length, ahead, convexity, slots, blocks
    ):
        count, n = len(blocks), len(conn)
        vector = np.empty(3)
        for m in range(n):
            stress = bar_state(m, conn, u, rest_vector, rest_strain, rest_length, vector)
            if len(ahead):
                stress = ahead[m]
            if stress < 0.0:
                stress -= convexity * stress
            geometric = EA[m] * stress / rest_length[m]
            along = EA[m] / rest_length[m] ** 3
            first, cross, second = slots[m], slots[n + m], slots[2 * n + m]
            if cross >= count:
                cross -= count  # a symmetric block: no need to turn it over
            for a in range(3):
                for b in range(3):
                    value = along * vector[a] * vector[b]
                    if a == b:
                        value += geometric
                    blocks[first, a, b] += value
                    blocks[cross, a, b] -= value
                    blocks[second, a, b] += value

    @compiled
    def hinge_state(  # type: ignore[no-untyped-def]
        m, conn, u, rest_edge, rest_i, rest_l, rest_angle, committed, edge, wings, beta, height, t, n, grad
    ):
        """Excess of the angle of hinge m over its rest value; fills the geometry of its wings and the gradient."""
        j, k = conn[m, 1], conn[m, 2]
        for axis in range(3):
            edge[axis] = rest_edge[axis, m] + (u[k, axis] - u[j, axis])
            wings[0, axis] = rest_i[axis, m] + (u[conn[m, 0], axis] - u[j, axis])
            wings[1, axis] = rest_l[axis, m] + (u[conn[m, 3], axis] - u[j, axis])
        e0, e1, e2 = edge[0], edge[1], edge[2]
        a0, a1, a2 = wings[0, 0], wings[0, 1], wings[0, 2]
        b0, b1, b2 = wings[1, 0], wings[1, 1], wings[1, 2]
        square = e0 * e0 + e1 * e1 + e2 * e2
        length = math.sqrt(square)
        m0, m1, m2 = e1 * a2 - e2 * a1, e2 * a0 - e0 * a2, e0 * a1 - e1 * a0
        n0, n1, n2 = b1 * e2 - b2 * e1, b2 * e0 - b0 * e2, b0 * e1 - b1 * e0
        angle = math.atan2(length * (m0 * b0 + m1 * b1 + m2 * b2), m0 * n0 + m1 * n1 + m2 * n2)
        angle += 2 * math.pi * np.rint((committed[m] - angle) / (2 * math.pi))
        grad[:] = 0.0
        for w in range(2):
            beta[w] = (e0 * wings[w, 0] + e1 * wings[w, 1] + e2 * wings[w, 2]) / square
            for axis in range(3):
                t[w, axis] = wings[w, axis] - beta[w] * edge[axis]
            height[w] = math.sqrt(t[w, 0] ** 2 + t[w, 1] ** 2 + t[w, 2] ** 2)
            for axis in range(3):
                t[w, axis] /= height[w]
            side = (1.0 - 2.0 * w) / length
            n[w, 0] = side * (e1 * t[w, 2] - e2 * t[w, 1])
            n[w, 1] = side * (e2 * t[w, 0] - e0 * t[w, 2])
            n[w, 2] = side * (e0 * t[w, 1] - e1 * t[w, 0])
            for axis in range(3):
                g = n[w, axis] / height[w]
                grad[3 * w, axis] = g
                grad[1, axis] += (beta[w] - 1.0) * g
                grad[2, axis] -= beta[w] * g
        return angle - rest_angle[m]

    @compiled
    def hinge_forces(  # type: ignore[no-untyped-def]
        conn, u, rest_edge, rest_i, rest_l, stiffness, rest_angle, committed, total
    ):
        edge, wings, beta, height = np.empty(3), np.empty((2, 3)), np.empty(2), np.empty(2)
        t, n, grad = np.empty((2, 3)), np.empty((2, 3)), np.empty((4, 3))
        squares = 0.0
        for m in range(len(conn)):
            excess = hinge_state(
                m, conn, u, rest_edge, rest_i, rest_l, rest_angle, committed, edge, wings, beta, height, t, n, grad
            )
            moment = stiffness[m] * excess
            for p in range(4):
                for axis in range(3):
                    force = moment * grad[p, axis]
                    squares += force * force
                    total[conn[m, p], axis] += force
        return squares

    @compiled
    def hinge_blocks(  # type: ignore[no-untyped-def]
        conn, u, rest_edge, rest_i, rest_l, stiffness, rest_angle, committed, convexity, slots, blocks
    ):
        edge, wings, beta, height = np.empty(3), np.empty((2, 3)), np.empty(2), np.empty(2)
        t, n, grad, h = np.empty((2, 3)), np.empty((2, 3)), np.empty((4, 3)), np.empty((10, 3, 3))
        count, members = len(blocks), len(conn)
        for m in range(members):
            excess = hinge_state(
                m, conn, u, rest_edge, rest_i, rest_l, rest_angle, committed, edge, wings, beta, height, t, n, grad
            )
            moment = (1.0 - convexity) * stiffness[m] * excess
            length = math.sqrt(edge[0] ** 2 + edge[1] ** 2 + edge[2] ** 2)
            # Blocks of the nodes i, k, l, places 0, 2, 3, 7, 8, 9; those of j follow, as a shift of all costs nothing.
            for a in range(3):
                for b in range(3):
                    h[0, a, b] = stiffness[m] * grad[0, a] * grad[0, b]
                    h[2, a, b] = stiffness[m] * grad[0, a] * grad[2, b]
                    h[3, a, b] = stiffness[m] * grad[0, a] * grad[3, b]
                    h[7, a, b] = stiffness[m] * grad[2, a] * grad[2, b]
                    h[8, a, b] = stiffness[m] * grad[2, a] * grad[3, b]
                    h[9, a, b] = stiffness[m] * grad[3, a] * grad[3, b]
                    for w in range(2):
                        turn = (n[w, a] * t[w, b] + t[w, a] * n[w, b]) * moment
                        over = turn / height[w] ** 2
                        skew = edge[a] * n[w, b] * moment / (height[w] * length * length)
                        turned = n[w, a] * edge[b] * moment / (height[w] * length * length)
                        h[7, a, b] -= beta[w] ** 2 * over - beta[w] * (skew + turned) + 0.5 * turn / length**2
                        if w == 0:
                            h[0, a, b] -= over
                            h[2, a, b] += beta[w] * over - skew
                        else:
                            h[9, a, b] -= over
                            h[8, a, b] += beta[w] * over - turned
            for a in range(3):
                for b in range(3):
                    h[1, a, b] = -(h[0, a, b] + h[2, a, b] + h[3, a, b])
                    h[5, a, b] = -(h[2, a, b] + h[7, a, b] + h[8, b, a])
                    h[6, a, b] = -(h[3, a, b] + h[8, a, b] + h[9, a, b])
            for a in range(3):
                for b in range(3):
                    h[4, a, b] = -(h[1, a, b] + h[5, b, a] + h[6, b, a])
            for pair in range(10):
                slot = slots[pair * members + m]
                if slot < count:
                    for a in range(3):
                        for b in range(3):
                            blocks[slot, a, b] += h[pair, a, b]
                else:
                    for a in range(3):
                        for b in range(3):
                            blocks[slot - count, b, a] += h[pair, a, b]

    return Loops(bar_forces, bar_blocks, hinge_forces, hinge_blocks)
