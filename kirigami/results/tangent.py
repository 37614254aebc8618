"""The tangent stiffness at a stored step, from the kernels and supports that results keep: no model is needed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kirigami.linalg import make_solver
from kirigami.primitives.kernel import Array, full_hessian
from kirigami.primitives.node import AXES
from kirigami.results.results import Results
from kirigami.results.step import Step


class StoredTangent:
    """The factored tangent stiffness at a step; of a linear analysis that at rest.

    Raises
    ------
    SingularMatrixError
        It cannot be solved with.
    """

    def __init__(self, results: Results, step: Step) -> None:
        from scipy.sparse import coo_matrix

        dim = results.dim
        count = dim * (len(results.rest) + len(results.inner_rest))
        self.unknown = _unknowns(results)
        rows, columns, values = [], [], []
        for kernel in results.kernels:
            if kernel.pairs == () or not len(kernel.conn):
                continue
            if results.linear:
                found = kernel.evaluate(results.configuration(), step.lam, 2)
            else:
                found = results.evaluate_at(kernel, step, lambda x: kernel.evaluate(x, step.lam, 2))  # noqa: B023
            blocks = full_hessian(kernel, found)
            at = (kernel.conn[:, :, None] * dim + np.arange(dim)).reshape(len(kernel.conn), -1)
            size = at.shape[1]
            rows.append(np.repeat(at, size, axis=1).ravel())
            columns.append(np.tile(at, (1, size)).ravel())
            values.append(blocks.transpose(0, 1, 3, 2, 4).ravel())
        self.count = count
        row, column = (self.unknown[np.concatenate(part)] for part in (rows, columns))
        kept = (row >= 0) & (column >= 0)
        self.free = int(self.unknown.max(initial=-1)) + 1
        matrix = coo_matrix((np.concatenate(values)[kept], (row[kept], column[kept])), shape=(self.free, self.free))
        solver = results.once("solver", make_solver)  # which dissects the pattern that all steps share but once
        self.factor = solver.factorize(matrix.tocsc())

    def solve(self, load: Array) -> Array:
        """Displacements (rows, dim) under forces (rows, dim) with the supports at rest."""
        moving = self.unknown >= 0
        reduced = np.bincount(self.unknown[moving], load.ravel()[moving], self.free).astype(float)
        answer = np.zeros(self.count)
        answer[moving] = self.factor.solve(reduced)[self.unknown[moving]]
        return np.asarray(answer.reshape(load.shape))


def _unknowns(results: Results) -> NDArray[np.int64]:
    """Number of the unknown of each displacement, -1 where a support knows it; what is tied has that of its leader."""
    dim = results.dim
    held = results.constrained.ravel()
    leader = np.arange(held.size)
    for support in results.supports:
        if len(support.leaders):
            for axis in support.dofs:
                if AXES.index(axis) < dim:
                    at = support.nodes * dim + AXES.index(axis)
                    leader[at] = support.leaders * dim + AXES.index(axis)
    for _ in range(len(results.supports)):  # chains of ties
        leader = leader[leader]
    unknown = np.full(held.size, -1)
    heads = np.flatnonzero(~held)
    unknown[heads] = np.arange(heads.size)
    return np.asarray(unknown[leader])
