"""Edges of the sheet that a clamp or a mirror plane holds: they bend against the mirror image of their facet.

The facet (j, k, i) turns by phi about its edge, against the direction that a clamp carries along or that a mirror plane
fixes (:mod:`kirigami.elements.edge_turn`). Its mirror image turns as much the other way, so that the two fold by
2 phi, and half of the energy of that fold belongs to the facet:

* Sheets of bars and hinges: a whole hinge has k (2 phi)^2 / 2 with k = D L^2 / (2 A), half of it is
  (D L^2 / A) phi^2 / 2.
* Facets: the angle 2 phi takes its place among the fold angles of the facet, from which it was eliminated as that of a
  free edge. What the elimination took away is (B / 2) (theta_c + sum w_d theta_d)^2, and is given back with
  theta_c = 2 phi.

So half a sheet is just that, and the clamp of a facet is the sheet beyond it, bent as a mirror image.

Which edges are held is said in :mod:`kirigami.elements.held_edges`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.bend_hinge import BendHingeKernel
from kirigami.elements.edge_turn import EdgeTurn
from kirigami.elements.natural import NaturalKernel, derived
from kirigami.primitives.kernel import EXACT, Array, CompiledKernel, Contribution, Kernel, Tangent, full_hessian
from kirigami.primitives.sensitivity import by_rest_differences

Index = NDArray[np.int64]


class HeldEdgeKernel(NaturalKernel):
    """Energy k chi^2 / 2 of the change of angles chi = sum of weight * phi and of weight * theta, member by member.

    Parameters
    ----------
    rest : ndarray, shape (rows, 3)
        Rest positions.
    conn : ndarray of int, shape (n, nodes)
        Nodes of each member.
    stiffness : ndarray, shape (n,)
        k [force length / rad].
    turn_of, fold_of : ndarray of int, shape (t,) and (f,)
        Member that each turn phi, and each fold theta, belongs to.
    turn_at : ndarray of int, shape (t, 3)
        Local nodes of each turn: wing, ends of the edge.
    turn_weight, fold_weight : ndarray, shape (t,) and (f,)
        Weights.
    normal : ndarray, shape (t, 3)
        Normals of mirror planes.
    carried : ndarray of bool, shape (t,)
        True where a clamp carries the direction along instead.
    fold_at : ndarray of int, shape (f, 4)
        Local nodes of each fold, as of a bending hinge.
    members : ndarray of int, optional
        Not used.
    """

    name = "clamps"
    sheet_part = "held edges"
    anchored = True
    approximates = True

    def __init__(
        self,
        rest: Array,
        conn: Index,
        stiffness: Array,
        turn_of: Index,
        turn_at: Index,
        turn_weight: Array,
        normal: Array,
        carried: NDArray[np.bool_],
        fold_of: Index,
        fold_at: Index,
        fold_weight: Array,
        members: Index | None = None,
        natural: Array | None = None,
    ) -> None:
        self.rest, self.conn, self.stiffness, self.members = rest, conn, stiffness, members
        self._natural = natural
        self._scale()
        self.turn_of, self.turn_at, self.turn_weight = turn_of, turn_at, turn_weight
        self.normal, self.carried = normal, carried
        self.fold_of, self.fold_at, self.fold_weight = fold_of, fold_at, fold_weight
        self._turns = EdgeTurn(rest, conn[turn_of[:, None], turn_at], normal, carried)
        count = len(fold_of)
        self._folds = BendHingeKernel(
            rest, conn[fold_of[:, None], fold_at], np.ones(count), np.full(count, np.nan)
        )

    def compiled(self) -> CompiledKernel | None:
        """Where each member is one turn of its own three nodes, as on sheets of bars and hinges."""
        n = len(self.conn)
        own = np.array_equal(self.turn_of, np.arange(n)) and self.conn.shape[1] == 3 and self.rest.shape[1] == 3
        if not own or len(self.fold_of) or (self.turn_at != (0, 1, 2)).any() or (self.turn_weight != 1).any():
            return None
        from kirigami.elements.compiled import CompiledHeldEdges

        return CompiledHeldEdges(self)

    def arrays(self) -> dict[str, Any]:
        names = (
            "conn", "stiffness", "turn_of", "turn_at", "turn_weight", "normal", "carried",
            "fold_of", "fold_at", "fold_weight", "members",
        )  # fmt: skip
        return self.with_natural({name: getattr(self, name) for name in names})

    @property
    def history(self) -> Array | None:
        return np.append(self._turns.committed, np.asarray(self._folds.history))

    @history.setter
    def history(self, value: Array | None) -> None:
        count = len(self._turns.initial)
        self._turns.committed = self._turns.initial.copy() if value is None else np.array(value[:count], dtype=float)
        self._folds.history = None if value is None else value[count:]

    def commit(self, x: Array) -> None:
        self._turns.committed = self._turns.angles(x)
        self._folds.commit(x)

    def deformation(self, x: Array) -> Array:
        """Change of the angle chi of each edge (n,) [rad]: the rotation of its facet, on sheets of bars and hinges."""
        n = len(self.conn)
        turned = self.turn_weight * (self._turns.angles(x) - self._turns.initial)
        folded = self.fold_weight * (self._folds.deformation(x) - self._folds.rest_angle)
        return np.asarray(np.bincount(self.turn_of, turned, n) + np.bincount(self.fold_of, folded, n), dtype=float)

    def deformation_rate(self, x: Array, change: Array) -> Array:
        """First-order change of chi (n,) for a displacement change (n_nodes, 3)."""
        return np.asarray(np.einsum("nka,nka->n", self._slopes(x), np.asarray(change)[self.conn]))

    def force(self, deformation: Array) -> Array:
        """Moment of each edge (n,) [force length]."""
        return np.asarray(self.stiffness * deformation)

    def force_at(self, deformation: Array, lam: float) -> Array:
        return self.force(self.beyond(deformation, lam))

    def actuate_edges(
        self,
        between: Callable[[NDArray[np.int64]], Array],
        against: Callable[[NDArray[np.int64]], Array],
        constant: bool,
    ) -> None:
        """Take the angles that a curvature of their own gives to facets: `between` the two at edges (k, 2), and
        `against` the image of one that is mirrored at its edge."""
        chi = np.zeros(len(self.conn))
        for member, at, weight, angles in (
            (self.turn_of, self.turn_at[:, 1:], self.turn_weight, against),
            (self.fold_of, self.fold_at[:, 1:3], self.fold_weight, between),
        ):
            np.add.at(chi, member, weight * angles(self.conn[member[:, None], at]))
        self.actuate(np.arange(len(chi)), chi, constant)

    def by_rest(self, x: Array, lam: float, fields: Array, energies: Array) -> Array | None:
        """By differences, where the constants do not feel the rest state."""
        if self.mesh_edges is None or self._natural is not None:
            return None
        return by_rest_differences(self, x, lam, fields, energies)

    def _slopes(self, x: Array) -> Array:
        """Derivatives (n, nodes, 3) of chi by the positions."""
        chain = np.zeros((*self.conn.shape, 3))
        turn = self.turn_weight[:, None, None] * self._turns.first_derivatives(*self._turns.vectors(x))
        np.add.at(chain, (self.turn_of[:, None], self.turn_at), turn)
        _, fold = self._folds.first_derivatives(*self._folds.vectors(x))
        np.add.at(chain, (self.fold_of[:, None], self.fold_at), (self.fold_weight * fold).transpose(2, 1, 0))
        return chain

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        angle = self.beyond(self.deformation(x), lam)
        moment = self.stiffness * angle
        energy = 0.5 * moment * angle
        if need == 0:
            return Contribution(energy)
        chain = self._slopes(x)
        gradient = moment[:, None, None] * chain
        if need == 1:
            return Contribution(energy, gradient)
        hessian = np.einsum("n,npa,nqb->npqab", self.stiffness, chain, chain)
        bent = (1 - tangent.convexity) * moment
        second = self._turns.second_derivatives(*self._turns.vectors(x))
        second *= (self.turn_weight * bent[self.turn_of])[:, None, None, None, None]
        places = self.turn_at[:, :, None], self.turn_at[:, None]
        np.add.at(hessian, (self.turn_of[:, None, None], *places), second)
        if len(self.fold_of):
            vectors = self._folds.vectors(x)
            wings, fold = self._folds.first_derivatives(*vectors)
            bending = self.fold_weight * bent[self.fold_of]
            curved = np.empty((3, 3, len(self._folds.pairs), len(bending)))
            self._folds.second_derivatives(curved, np.zeros_like(bending), bending, vectors[0], wings, fold)
            found = Contribution(bending, fold.transpose(2, 1, 0), curved.transpose(3, 2, 0, 1))
            places = self.fold_at[:, :, None], self.fold_at[:, None]
            np.add.at(hessian, (self.fold_of[:, None, None], *places), full_hessian(self._folds, found))
        return Contribution(energy, gradient, hessian)


def held_edges(kernels: Iterable[Kernel], owner: str) -> list[HeldEdgeKernel]:
    """The kernels of held edges, see :func:`derived`."""
    return derived(kernels, HeldEdgeKernel, lambda kernel: kernel.sheet_part == "held edges", owner)


class ClampHingeKernel(HeldEdgeKernel):
    """Facets (j, k, i) of bars and hinges that keep their slope at a clamped edge j-k; local nodes i, j, k.

    Energy k phi^2 / 2.
    """

    def __init__(
        self,
        rest: Array,
        conn: Index,
        stiffness: Array,
        members: Index | None = None,
        natural: Array | None = None,
    ) -> None:
        own = np.arange(len(conn))
        no_folds = np.empty(0, np.int64), np.empty((0, 4), np.int64), np.empty(0)
        at, weight = np.tile([0, 1, 2], (len(conn), 1)), np.ones(len(conn))
        super().__init__(
            rest, conn, stiffness, own, at, weight, np.zeros((len(conn), 3)), own >= 0, *no_folds, members=members,
            natural=natural,
        )

    def arrays(self) -> dict[str, Any]:
        return self.with_natural({"conn": self.conn, "stiffness": self.stiffness, "members": self.members})
