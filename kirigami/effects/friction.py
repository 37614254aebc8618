"""Coulomb friction at contacts: a node that is pressed on a surface with N is held back by at most mu N.

Each node has an anchor on the surface. With d the part along the surface of its way from there, n the normal,

    energy  mu N (d.d / (2 w))  for |d| <= w: it sticks,      mu N (|d| - w / 2)  beyond: it slides,

which is Coulomb's law with its corner rounded over the width w. N and n are those of the last accepted equilibrium,
so that between two equilibria there is a potential; when one is accepted the anchor of a node that slides follows it
at the distance w, and N and n move on. Friction is thus one increment behind the pressure: press first, and then drag.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.effects.contact import ContactKernel
from kirigami.primitives.kernel import Array, Contribution, Kernel


class FrictionKernel(Kernel):
    """Friction of the nodes of contacts, one node per member.

    Parameters
    ----------
    rest : ndarray, shape (rows, dim)
        Rest positions.
    friction, width : ndarray, shape (n,)
        Coefficient mu, and the width w over which the force sets in [length].
    contact : dict
        Arguments of the :class:`ContactKernel` of the same nodes.
    """

    name = "friction"
    stores_energy = False
    anchored = True
    path_dependent = True
    contact_kind: type[ContactKernel] = ContactKernel

    def __init__(self, rest: Array, friction: Array, width: Array, **contact: Any) -> None:
        self.rest, self.friction, self.width = rest, friction, width
        self._contact = self.contact_kind(rest, **contact)
        self.conn, self.members = self._contact.conn, self._contact.members
        self._pressing = 2 * rest.shape[1]  # column of a state
        self.history = None

    def arrays(self) -> dict[str, Any]:
        return {"friction": self.friction, "width": self.width, **self._contact.arrays()}

    def _state(self, anchors: Array, x: Array, lam: float) -> Array:
        """Anchor, normal, pressing force, row and load factor (n, 2 dim + 3) with the surface as it is at `x`."""
        gap, normal = self._contact.normals(x, lam)
        return np.column_stack([anchors, normal, self._contact.force(gap), self.conn, np.full(len(anchors), lam)])

    @property
    def history(self) -> Array | None:
        """Anchors, normals, pressing forces, rows of the nodes, and the load factor at which anchors were there
        (n, 2 dim + 3), which is nan before the first equilibrium: that says where they are."""
        return self._committed

    @history.setter
    def history(self, value: Array | None) -> None:
        if value is None:
            value = self._state(self._contact.places_of(self.rest), self.rest, 0.0)
            value[:, -1] = np.nan
        self._committed = np.array(value, dtype=float)

    def fits(self, history: Array) -> bool:
        return super().fits(history) and np.array_equal(history[:, self._pressing + 1], self.conn[:, 0])

    def start_stage(self) -> None:
        self._committed[:, -1] = 0.0

    def _anchors(self, lam: float) -> Array:
        """Where the anchors (n, dim) are at a load factor."""
        return self._committed[:, : self.rest.shape[1]]

    def _way(self, x: Array, anchors: Array, state: Array) -> tuple[Array, Array]:
        """Way along the surface (n, dim) from the anchors, and the normals."""
        dim = self.rest.shape[1]
        normal = state[:, dim : 2 * dim]
        apart = self._contact.places_of(x) - anchors
        return apart - (apart * normal).sum(axis=1, keepdims=True) * normal, normal

    def commit(self, x: Array) -> None:
        self.commit_at(x, 0.0)

    def commit_at(self, x: Array, lam: float) -> None:
        places = self._contact.places_of(x)
        anchors = places if np.isnan(self._committed[0, -1]) else self._anchors(lam)
        state = self._state(anchors, np.asarray(x), lam)
        way, _ = self._way(x, anchors, state)
        size = np.linalg.norm(way, axis=1)
        kept = np.minimum(1.0, self.width / np.where(size > 0, size, 1.0)) * (state[:, self._pressing] > 0)
        state[:, : self.rest.shape[1]] = places - kept[:, None] * way
        self._committed = state

    def deformation(self, x: Array) -> Array:
        """Share of the limit (n, dim) that is used up along the surface: a node whose share has the length 1 slides."""
        return self.deformation_at(x, 0.0)

    def deformation_at(self, x: Array, lam: float) -> Array:
        way, _ = self._way(x, self._anchors(lam), self._committed)
        size = np.linalg.norm(way, axis=1)
        return np.asarray(way / np.maximum(size, self.width)[:, None])

    @property
    def _limit(self) -> Array:
        """Most that each node (n,) is held back by."""
        return np.asarray(self.friction * self._committed[:, self._pressing])

    def force(self, share: Array) -> Array:
        """Force (n, dim) of the nodes on the surface, along it."""
        return np.asarray(self._limit[:, None] * share)

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        way, normal = self._way(x, self._anchors(lam), self._committed)
        size, w = np.linalg.norm(way, axis=1), self.width
        limit = self._limit
        sticks = size <= w
        energy = limit * np.where(sticks, size**2 / (2 * w), size - w / 2)
        reach = np.maximum(size, w)
        gradient = (limit / reach)[:, None] * way
        if need < 2:
            return Contribution(energy, gradient[:, None])
        along = np.eye(way.shape[1]) - normal[:, :, None] * normal[:, None]
        turned = np.where(sticks, 0.0, 1.0)[:, None, None] * way[:, :, None] * way[:, None] / reach[:, None, None] ** 2
        hessian = (limit / reach)[:, None, None] * (along - turned)
        return Contribution(energy, gradient[:, None], hessian[:, None, None])
