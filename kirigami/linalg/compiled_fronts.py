"""Elimination of fronts, and solutions, by compiled loops: on both cores where the factor is large.

A front is small work, and between its few calls of LAPACK and BLAS Python takes as long as they do; its lock keeps a
second thread waiting besides. So whole subtrees of fronts are eliminated by one compiled loop
(:mod:`kirigami.linalg.front_loops`). The arithmetic of a front is the same whoever does it: with any number of threads,
and by loops or in Python, the factor is the same bit by bit. Solutions are taken in two halves of subtrees and a rest,
however many threads there are, so that their sums are the same bit by bit as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np

from kirigami.linalg.checked import SingularMatrixError
from kirigami.linalg.dissection import Index
from kirigami.linalg.front_plan import Eliminated, FrontPlan
from kirigami.linalg.plain_fronts import AMPLIFIED, HALVED, PlainElimination
from kirigami.linalg.released import address
from kirigami.primitives.kernel import Array

LETTERS, REALS = np.array([ord(letter) for letter in "LRTN"], dtype=np.uint8), np.array([1.0, -1.0])


class CompiledFronts:
    """What eliminations and solutions of one pattern share.

    Parameters
    ----------
    plan : FrontPlan
        Where everything goes.
    halves : bool
        Whether solutions are taken in two halves.
    """

    def __init__(self, plan: FrontPlan, halves: bool) -> None:
        self.plan = plan
        self._halves, self._rest = plan.shares(2 if halves else 1)
        owner = np.full(len(plan.pivots), len(self._halves))
        for number, part in enumerate(self._halves):
            owner[part] = number
        of_row = np.repeat(owner, plan.pivots)
        self._rows = [np.flatnonzero(of_row == number) for number in range(len(self._halves) + 1)]

    def eliminate(self, data: Array, made: Eliminated, threads: int) -> None:
        """Eliminate all fronts of a matrix with these entries."""
        parts, rest = self.plan.shares(threads)
        if not parts:
            self._spread(data, made, 0, len(self.plan.taken))
            self._eliminate(made, rest)
            return
        plain = PlainElimination(self.plan, made)
        with ThreadPoolExecutor(len(parts)) as pool:
            bounds = np.linspace(0, len(self.plan.taken), len(parts) + 1).astype(np.int64).tolist()
            list(pool.map(lambda first, last: self._spread(data, made, first, last), bounds[:-1], bounds[1:]))
            for part, stack in zip(parts, list(pool.map(lambda part: self._eliminate(made, part), parts))):
                above = part[~np.isin(self.plan.fronts.parent[part], part)]  # the last one done of each subtree
                ends = np.cumsum(self.plan.left_over[above])
                for front, left_over in zip(above.tolist(), np.split(stack, ends)):
                    plain.leave_over(front, left_over)
            plain.eliminate(rest, pool.map)

    def _spread(self, data: Array, made: Eliminated, first: int, last: int) -> None:
        from kirigami.linalg import front_loops

        front_loops.spread(self.plan.taken[first:last], self.plan.places[first:last], data, made.store)

    def _eliminate(self, made: Eliminated, part: Index) -> Array:
        """Eliminate whole subtrees of fronts; what their roots leave over, one after the other."""
        from kirigami.linalg import front_loops

        plan = self.plan
        highest, room = self._memory(part)
        stack = np.empty(highest)
        singular = front_loops.eliminate(
            part, plan.starts, plan.first, plan.offsets, plan.first_child, plan.children, plan.seats, *made, stack,
            np.empty(room), HALVED, AMPLIFIED, LETTERS, REALS, np.zeros(6, dtype=np.int32), *_routines(),
        )  # fmt: skip
        if singular >= 0:
            raise SingularMatrixError("a front of the stiffness matrix is singular")
        return stack

    def _memory(self, part: Index) -> tuple[int, int]:
        """Numbers on the stack of left-overs at most, and in the blocks of one front."""
        p, q = self.plan.pivots[part], self.plan.rows[part]
        left = self.plan.left_over
        taken = np.zeros(len(left), dtype=np.int64)
        np.add.at(taken, self.plan.parents, left[self.plan.children])
        high = np.cumsum((left - taken)[part])
        return int(high.max(initial=0)) + 1, int((2 * p * p + q * q + p * q + 64 * p).max(initial=0)) + 1

    def solve(self, made: Eliminated, rhs: Array, threads: int) -> Array:
        """Solution of one right-hand side (n,), or of some (n, k)."""
        order = self.plan.fronts.order
        x = np.ascontiguousarray(rhs[order].reshape(len(rhs), -1).T)  # one after the other
        if not self._halves:
            self._forward(self._rest, made, x)
            self._backward(self._rest, made, x)
        elif threads > 1:
            with ThreadPoolExecutor(len(self._halves)) as pool:
                self._solve_halves(made, x, pool.map)
        else:
            self._solve_halves(made, x, map)
        solution = np.empty(rhs.shape)
        solution[order] = x.T.reshape(rhs.shape)
        return solution

    def _solve_halves(self, made: Eliminated, x: Array, each: Callable[..., Iterable[Any]]) -> None:
        def ahead(part: Index) -> Array:
            own: Array = x.copy()  # what the halves do to rows of the rest is added up in their order
            self._forward(part, made, own)
            return own

        shared = self._rows[-1]
        before = x[:, shared]
        for rows, own in zip(self._rows, list(each(ahead, self._halves))):
            x[:, rows] = own[:, rows]
            x[:, shared] += own[:, shared] - before
        self._forward(self._rest, made, x)
        self._backward(self._rest, made, x)
        list(each(lambda part: self._backward(part, made, x), self._halves))

    def _forward(self, part: Index, made: Eliminated, x: Array) -> None:
        from kirigami.linalg import front_loops

        plan = self.plan
        front_loops.forward(part, plan.starts, plan.first, plan.border, plan.offsets, made.store, made.exchanges, x)

    def _backward(self, part: Index, made: Eliminated, x: Array) -> None:
        from kirigami.linalg import front_loops

        plan = self.plan
        fronts = plan.starts, plan.first, plan.border, plan.offsets
        front_loops.backward(
            part, *fronts, made.store, made.exchanges, x, LETTERS, np.zeros(4, dtype=np.int32), _packed_solve()
        )


@cache
def _routines() -> tuple[Any, ...]:
    """Cholesky and Bunch and Kaufman's factorisation and solution, triangular solution and products, for the loops."""
    return tuple(
        _routine(module, name, arguments)
        for module, name, arguments in (
            ("cython_lapack", "dpotrf", 5),
            ("cython_lapack", "dsytrf", 8),
            ("cython_lapack", "dsytrs", 9),
            ("cython_blas", "dtrsm", 11),
            ("cython_blas", "dsyrk", 10),
            ("cython_blas", "dgemm", 13),
        )
    )


@cache
def _packed_solve() -> Any:
    return _routine("cython_lapack", "dsptrs", 8)


def _routine(module: str, name: str, arguments: int) -> Any:
    """A routine that compiled loops call by its address, with as many addresses of arguments."""
    from numba import types
    from numba.experimental import function_type  # noqa: F401  (else routines are unknown until something is compiled)

    class Routine(types.WrapperAddressProtocol):  # type: ignore[misc]
        def __wrapper_address__(self) -> int:
            return address(module, name)

        def signature(self) -> Any:
            return types.void(*[types.uintp] * arguments)

    return Routine()
