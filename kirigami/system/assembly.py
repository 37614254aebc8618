"""Assembly: from the Hessian blocks of kernels to a sparse matrix, by plans made once.

Each Hessian block adds to the block of its node pair, lower number first, so each pair is stored once; the reduced
matrix then picks its entries, and their mirror images, from there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.compiling import compiles
from kirigami.primitives.kernel import Array, CompiledKernel, Kernel

if TYPE_CHECKING:
    from kirigami.system.grips import Grips

Index = NDArray[np.int64]

TOGETHER = 1 << 18  # blocks or entries that are taken together, so that what this takes is little
MEMBERS = 5_000  # members of a kernel below which numpy is fast enough, but for kernels that say less


def scatter_add(target: Array, conn: Index, values: Array) -> None:
    """Add member values (n, k, dim) to the rows (dim columns) of `target` that `conn` (n, k) names."""
    flat = conn.T.ravel()  # kernels keep the members last in memory
    for axis in range(target.shape[1]):
        target[:, axis] += np.bincount(flat, weights=values[:, :, axis].T.ravel(), minlength=len(target))


class BlockPlan:
    """Which node block each Hessian block of each kernel adds to."""

    def __init__(
        self, kernels: list[Kernel], nodes: int, more: Index | None = None, grips: Grips | None = None
    ) -> None:
        diagonal = np.arange(nodes)
        codes = [diagonal * nodes + diagonal]
        flips = []
        for kernel in kernels:
            k = kernel.conn.shape[1]
            listed = np.array(np.triu_indices(k)).T if kernel.pairs is None else np.array(kernel.pairs, dtype=int)
            pairs = listed.reshape(-1, 2)
            first, second = kernel.conn.T[pairs[:, 0]].ravel(), kernel.conn.T[pairs[:, 1]].ravel()
            codes.append(np.minimum(first, second) * nodes + np.maximum(first, second))
            flips.append(first > second)
        if more is not None:  # codes, lower number times nodes + higher number, of pairs that no kernel lists
            codes.append(more)
        if grips is not None:  # pairs that no kernel has
            known = np.unique(np.concatenate(codes))
            low, high = grips.pairs(known // nodes, known % nodes)
            codes.append(low * nodes + high)
        unique, inverse = np.unique(np.concatenate(codes), return_inverse=True)
        self.codes, self.count = unique, len(unique)
        self.low, self.high = unique // nodes, unique % nodes
        self.nodes = nodes
        self.own = np.flatnonzero(self.low == self.high)  # the block of each node with itself
        sections = np.cumsum([len(code) for code in codes])[:-1]
        self.slots = [
            slots + flip * self.count for slots, flip in zip(np.split(inverse, sections)[1:], flips)
        ]

    def find(self, low: Index, high: Index) -> Index | None:
        """Blocks of node pairs, lower number first; None where some have none."""
        codes = low * self.nodes + high
        slots = np.minimum(np.searchsorted(self.codes, codes), self.count - 1)
        return slots if np.array_equal(self.codes[slots], codes) else None

    def add(self, blocks: Array, kernel: Kernel, slots: Index, hessian: Array) -> None:
        """Add the Hessian of a kernel to node blocks (dim, dim, blocks)."""
        if kernel.pairs is None:  # all k * k blocks given: the upper ones say it all
            first, second = np.triu_indices(kernel.conn.shape[1])
            hessian = hessian[:, first, second]
        by_component = hessian.transpose(2, 3, 1, 0)
        for a in range(len(blocks)):
            for b in range(len(blocks)):
                sums = np.bincount(slots, by_component[a, b].ravel(), 2 * self.count)
                blocks[a, b] += sums[: self.count]
                blocks[b, a] += sums[self.count :]  # came with the higher node first: turned over

    def complete(self, blocks: Array) -> None:
        """Fill in the block of each node with itself, zero so far: shifting all nodes together makes no force."""
        for a in range(len(blocks)):
            for b in range(a + 1):
                # Blocks are sorted by their lower node and every node has a block of its own, so none is passed over.
                others = np.add.reduceat(blocks[a, b], self.own) + np.bincount(self.high, blocks[b, a], self.nodes)
                blocks[a, b, self.own] = blocks[b, a, self.own] = -others

    def complete_compiled(self, blocks: Array) -> None:
        """See :meth:`complete`; here the blocks come as (blocks, 3, 3), for compiled loops."""
        from kirigami.system import assembly_loops

        assembly_loops.complete(self.low, self.high, self.own, blocks)

    def links(self, rest: Array, points: int) -> tuple[Index, Index, Array]:
        """Joined pairs of the first `points` rows, which are nodes, and their distance."""
        off = (self.low != self.high) & (self.high < points)
        low, high = self.low[off], self.high[off]
        distance = np.linalg.norm(rest[high] - rest[low], axis=1)
        apart = distance > 0
        return low[apart], high[apart], distance[apart]

    def multiply(self, blocks: Array, vector: Array, sizes: bool = False) -> Array:
        """Product of the symmetric block matrix with a field (n, dim), which may be zero nearly everywhere; of the
        `sizes` of both, on demand."""
        product = np.zeros_like(vector)
        moving = np.asarray(vector.any(axis=1))
        moved = np.flatnonzero(moving[self.low] | moving[self.high])
        vector = np.abs(vector) if sizes else vector
        for first in range(0, len(moved), TOGETHER):
            at = moved[first : first + TOGETHER]
            low, high, some = self.low[at], self.high[at], blocks[:, :, at]
            some = np.abs(some) if sizes else some
            off = low != high
            upper = np.einsum("abn,nb->na", some, vector[high])
            lower = np.einsum("ban,nb->na", some[:, :, off], vector[low[off]])
            scatter_add(product, low[:, None], upper[:, None])
            scatter_add(product, high[off][:, None], lower[:, None])
        return product


def compiled_largest_turn(change: Array, low: Index, high: Index, distance: Array) -> float:
    """Largest relative displacement of joined nodes over their distance, for a change (n, dim); by compiled loops."""
    from kirigami.system import assembly_loops

    return float(assembly_loops.largest_turn(np.ascontiguousarray(change), low, high, distance))


def twins(kernels: list[Kernel]) -> list[CompiledKernel | None]:
    """The compiled twin of each kernel, where Numba is installed and pays.

    Numba needs seconds to compile loops once per machine and half a second to load, so small systems do without, and
    all of them where the environment variable KIRIGAMI_COMPILED is 0. Where one kernel is worth it, all are.
    """
    pays = compiles() and any(len(kernel.conn) >= min(MEMBERS, kernel.compile_from) for kernel in kernels)
    return [kernel.compiled() if pays else None for kernel in kernels]


class PickPlan:
    """Which entries of the node blocks make up each entry of the reduced CSC matrix.

    Entries of a block stand side by side in memory (see :meth:`matrix`), and the plan is sorted column by column, in
    numbers of 32 bits where they reach: for large sheets it is the largest thing in memory.
    """

    def __init__(self, plan: BlockPlan, unknown: Index, size: int, dim: int) -> None:
        small = plan.count * dim * dim < 2**31
        block = np.arange(plan.count, dtype=np.int32 if small else np.int64)
        unknown = unknown.astype(np.int32)
        off = plan.low != plan.high
        codes, sources = [], []
        for a in range(dim):
            for b in range(dim):
                row, column = unknown[plan.low * dim + a], unknown[plan.high * dim + b]
                kept = (row >= 0) & (column >= 0)
                source = block * (dim * dim) + (a * dim + b)
                codes.append(column[kept].astype(np.int64) * size + row[kept])
                sources.append(source[kept])
                kept &= off
                codes.append(row[kept].astype(np.int64) * size + column[kept])
                sources.append(source[kept])
        del row, column, kept, off, block
        code = np.concatenate(codes)
        del codes
        order = np.argsort(code, kind="stable")
        code = code[order]
        self.source = np.concatenate(sources)[order]
        del sources, order
        new = np.flatnonzero(np.diff(code, prepend=-1))
        self.starts = None if len(new) == len(code) else new  # ties put several entries in one place
        if self.starts is not None:
            code = code[new]
        self.indptr = np.searchsorted(code, np.arange(size + 1) * size).astype(np.int32)
        self.indices = (code % size).astype(np.int32)
        self.size = size

    def matrix(self, blocks: Array) -> Any:
        from scipy.sparse import csc_matrix

        side_by_side = np.ascontiguousarray(blocks.transpose(2, 0, 1)).reshape(-1)
        data = np.empty(len(self.source))
        for first in range(0, len(data), TOGETHER):  # NumPy widens numbers that it finds entries by
            part = slice(first, first + TOGETHER)
            data[part] = side_by_side[self.source[part]]
        if self.starts is not None:
            data = np.add.reduceat(data, self.starts) if len(data) else data
        matrix = csc_matrix((data, self.indices, self.indptr), shape=(self.size, self.size))
        matrix.indices, matrix.indptr = self.indices, self.indptr  # the same objects: solvers know the pattern by them
        return matrix
