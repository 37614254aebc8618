"""Coulomb friction where a sheet touches itself or an obstacle: each pair in contact is held back by at most mu N.

When an equilibrium is accepted the pairs in contact are noted with their closest points, normals n and normal forces N,
and so is the slip d0 (3,) along the surfaces that each of them has not given up yet. Up to the next equilibrium

    d = d0 + T (change of the gap r) + |r| sum over edges e in contact of (n . change of e) e*,    T = 1 - n n',
    energy  mu N (d.d / (2 w))  for |d| <= w: it sticks,      mu N (|d| - w / 2)  beyond: it slides,

with e* dual to the edges in their plane. The last term of d is the way that the gap itself turns: a sheet that turns
as a whole does not slip, and forces at the distance |r| keep the balance of moments. This is linear in the positions,
so the energy is convex. When the next equilibrium is accepted a pair keeps at most w of its slip; a pair that is new
takes over that of the pairs it shares nodes with, on the same sides, so that what sticks does not creep where closest
points wander from facet to facet. Friction is thus one increment behind the pressure, as at contacts with surfaces.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.effects.held_surface import HeldSurface
from kirigami.primitives.kernel import EXACT, Array, Contribution, Kernel, Tangent

NODES, SHARES, PLACES = slice(0, 4), slice(4, 8), slice(8, 20)
SPLIT, LIMIT, SLIP = 20, 21, slice(22, 25)
COLUMNS = 25
PARALLEL = 0.1  # sine of the angle of two edges below which they tell one direction only
SPLITS = {"ee_collisions": 2, "fv_collisions": 1, "ev_collisions": 1, "vv_collisions": 1}


class SelfFrictionKernel(Kernel):
    """Friction of one sheet with itself; a member is a node, and what it bears is the sum over its pairs.

    Parameters
    ----------
    rest : ndarray, shape (rows, 3)
        Rest positions.
    conn : ndarray of int, shape (n, 1)
        Nodes of the sheet.
    fixed : ndarray, shape (f, 3)
        Nodes of the obstacles.
    mixed, shares : ndarray, shapes (k, 2) and (k,)
        See :class:`kirigami.effects.held_surface.HeldSurface`.
    friction, width : float
        Coefficient mu, and the width w over which the force sets in [length].
    contact : SelfContactKernel, optional
        What finds the pairs when an equilibrium is accepted; None where history alone tells them, as in files.
    """

    name = "self-friction"
    pairs = ()
    stores_energy = False
    path_dependent = True

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        fixed: Array,
        mixed: NDArray[np.int64],
        shares: Array,
        friction: float,
        width: float,
        contact: Any = None,
    ) -> None:
        self.rest, self.conn, self.fixed, self.mixed, self.shares = rest, conn, fixed, mixed, shares
        self.friction, self.width, self.contact = float(friction), float(width), contact
        self._held = HeldSurface(len(rest), conn[:, 0], fixed, mixed, shares)
        self.history = None

    def arrays(self) -> dict[str, Any]:
        names = ("conn", "fixed", "mixed", "shares", "friction", "width")
        return {name: getattr(self, name) for name in names}

    # ---- which pairs rub

    @property
    def history(self) -> Array | None:
        """Of each pair (p, 25): its four nodes, a node and a facet or two edges, and their shares in the gap; their
        positions when it was accepted; how many nodes are of the first part; mu N; and the slip (3,)."""
        return self._pairs

    @history.setter
    def history(self, value: Array | None) -> None:
        self._pairs: Array = np.zeros((0, COLUMNS)) if value is None else np.array(value, dtype=float)
        self._nodes = self._pairs[:, NODES].astype(np.int64)
        self._places = self._pairs[:, PLACES].reshape(-1, 4, 3)
        self._normal, self._way = _slip_of(self._pairs)

    def fits(self, history: Array) -> bool:
        """Any number of pairs, of nodes there are."""
        count = len(self.conn) + len(self.fixed)
        return history.ndim == 2 and history.shape[1] == COLUMNS and bool((history[:, NODES] < count).all())

    def commit(self, x: Array) -> None:
        if self.contact is None:
            return
        places = self._held.at(x)
        new = self.contact.pressed(places)
        new[:, LIMIT] *= self.friction
        slip = self._slip(places)
        size = np.linalg.norm(slip, axis=1)
        slip *= np.minimum(1.0, self.width / np.where(size > 0, size, 1.0))[:, None]
        old = np.array(self._pairs)
        old[:, SLIP] = slip
        normal = _slip_of(new)[0]
        taken = _taken_over(old, self._normal, new, normal, len(places))
        new[:, SLIP] = taken - (taken * normal).sum(axis=1, keepdims=True) * normal
        self.history = new

    def _slip(self, places: Array) -> Array:
        """Slip (p, 3) of the pairs at positions of the surface."""
        change = places[self._nodes] - self._places
        return np.asarray(self._pairs[:, SLIP] + np.einsum("paib,pib->pa", self._way, change))

    # ---- the contract

    def _forces(self, places: Array) -> Array:
        """Gradient (n + f, 3) at positions of the surface."""
        slip = self._slip(places)
        reach = np.maximum(np.linalg.norm(slip, axis=1), self.width)
        each = np.einsum("paib,pa->pib", self._way, (self._pairs[:, LIMIT] / reach)[:, None] * slip)
        return _summed(self._nodes, each, len(places))

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        n = len(self.conn)
        if not len(self._pairs):
            return Contribution(np.zeros(n), np.zeros((n, 1, 3)))
        places = self._held.at(x)
        size, w = np.linalg.norm(self._slip(places), axis=1), self.width
        each = self._pairs[:, LIMIT] * np.where(size <= w, size**2 / (2 * w), size - w / 2)
        energy = np.full(n, each.sum() / n)
        if need == 0:
            return Contribution(energy)
        return Contribution(energy, self._held.back(self._forces(places))[:, None])

    def coupling(self, x: Array, tangent: Tangent = EXACT) -> Any:
        if not len(self._pairs):
            return None
        from scipy.sparse import coo_matrix

        places = self._held.at(x)
        slip = self._slip(places)
        size = np.linalg.norm(slip, axis=1)
        reach = np.maximum(size, self.width)
        unit = np.where(size > self.width, 1.0, 0.0)[:, None] * slip / reach[:, None]
        law = (self._pairs[:, LIMIT] / reach)[:, None, None] * (np.eye(3) - unit[:, :, None] * unit[:, None])
        way = self._way.reshape(len(slip), 3, 12)
        blocks = np.einsum("pak,pab,pbl->pkl", way, law, way)
        axes = (3 * self._nodes[:, :, None] + np.arange(3)).reshape(-1, 12)
        row, column = np.broadcast_arrays(axes[:, :, None], axes[:, None])
        size_of = 3 * len(places)
        hessian = coo_matrix((blocks.ravel(), (row.ravel(), column.ravel())), shape=(size_of, size_of))
        return self._held.coupling(hessian)

    # ---- what it tells

    def deformation(self, x: Array) -> Array:
        """Share of the limit (n, 3) that is used up along the surface: a node whose share has the length 1 slides."""
        places = self._held.at(x)
        weight = np.abs(self._pairs[:, SHARES]) * self._pairs[:, LIMIT, None]
        limit = np.bincount(self._nodes.ravel(), weight.ravel(), minlength=len(places))[: len(self.conn)]
        slip = self._slip(places)
        used = slip / np.maximum(np.linalg.norm(slip, axis=1), self.width)[:, None]
        signed = self._pairs[:, SHARES, None] * (self._pairs[:, LIMIT, None] * used)[:, None]
        force = _summed(self._nodes, signed, len(places))[: len(self.conn)]
        return np.asarray(force / np.where(limit > 0, limit, 1.0)[:, None])

    def force_of(self, x: Array, lam: float) -> Array:
        """Force (n, 3) by which the sheet's own other parts, and obstacles, hold each node back."""
        return -self._held.back(self._forces(self._held.at(x)))


def _summed(nodes: NDArray[np.int64], each: Array, count: int) -> Array:
    """Sum over pairs of vectors (p, 4, 3) at their nodes (p, 4)."""
    flat = nodes.ravel()
    return np.column_stack([np.bincount(flat, each[:, :, axis].ravel(), minlength=count) for axis in range(3)])


def _slip_of(pairs: Array) -> tuple[Array, Array]:
    """Normals (p, 3) of pairs, and the derivative (p, 3, 4, 3) of their slip by the positions of their nodes."""
    places, shares = pairs[:, PLACES].reshape(-1, 4, 3), pairs[:, SHARES]
    gap = np.einsum("pi,pia->pa", shares, places)
    far = np.linalg.norm(gap, axis=1)
    normal = gap / np.where(far > 0, far, 1.0)[:, None]
    along = np.eye(3) - normal[:, :, None] * normal[:, None]
    way = along[:, :, None] * shares[:, None, :, None]
    ends = np.zeros((len(pairs), 2, 4))  # how the edges in contact follow the nodes
    ends[:] = [[0, -1, 1, 0], [0, -1, 0, 1]]
    ends[pairs[:, SPLIT] == 2] = [[-1, 1, 0, 0], [0, 0, -1, 1]]
    first, second = np.einsum("pki,pia->kpa", ends, places)
    turning = _duals(np.einsum("pab,pb->pa", along, first), np.einsum("pab,pb->pa", along, second))
    way += far[:, None, None, None] * np.einsum("kpa,pki,pb->paib", turning, ends, normal)
    return normal, way


def _duals(first: Array, second: Array) -> Array:
    """Duals (2, p, 3) of two vectors (p, 3) in the plane they span; of the first alone where they hardly span one."""
    one, mixed, other = ((a * b).sum(axis=1) for a, b in ((first, first), (first, second), (second, second)))
    area = one * other - mixed**2
    spans = area > PARALLEL**2 * one * other
    area = np.where(spans, area, 1.0)[:, None]
    alone = first / np.where(one > 0, one, 1.0)[:, None]
    both = (other[:, None] * first - mixed[:, None] * second) / area
    last = (one[:, None] * second - mixed[:, None] * first) / area
    return np.stack([np.where(spans[:, None], both, alone), np.where(spans[:, None], last, 0.0)])


def _taken_over(old: Array, old_normal: Array, new: Array, normal: Array, count: int) -> Array:
    """Slip (p, 3) that new pairs take over from old ones: their own where they were in contact before, else the mean of
    those that they share nodes with on the same sides."""
    from scipy.sparse import csr_matrix

    if not len(old) or not len(new):
        return np.zeros((len(new), 3))
    known = {tuple(nodes): number for number, nodes in enumerate(old[:, NODES].tolist())}
    same = np.array([known.get(tuple(nodes), -1) for nodes in new[:, NODES].tolist()], dtype=np.int64)

    def of_nodes(pairs: Array) -> Any:
        nodes = pairs[:, NODES].astype(np.int64).ravel()
        entries = (pairs[:, SHARES].ravel(), (np.repeat(np.arange(len(pairs)), 4), nodes))
        return csr_matrix(entries, shape=(len(pairs), count))

    shared = (of_nodes(new) @ of_nodes(old).T).tocoo()
    row, column = shared.row, shared.col
    weight = np.maximum(shared.data * (normal[row] * old_normal[column]).sum(axis=1), 0.0) * old[column, LIMIT]
    signed = np.sign(shared.data) * weight
    total = np.bincount(row, weight, minlength=len(new))
    slips = [np.bincount(row, signed * old[column, SLIP][:, axis], minlength=len(new)) for axis in range(3)]
    mean = np.column_stack(slips) / np.where(total > 0, total, 1.0)[:, None]
    return np.where((same >= 0)[:, None], old[same, SLIP], mean)
