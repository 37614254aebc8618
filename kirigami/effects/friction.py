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

    def __init__(self, rest: Array, friction: Array, width: Array, **contact: Any) -> None:
        self.rest, self.friction, self.width = rest, friction, width
        self._contact = ContactKernel(rest, **contact)
        self.conn, self.members = self._contact.conn, self._contact.members
        self._first = self._state(rest[self.conn[:, 0]], rest)
        self._committed = self._first

    def arrays(self) -> dict[str, Any]:
        return {"friction": self.friction, "width": self.width, **self._contact.arrays()}

    def _state(self, anchor: Array, x: Array) -> Array:
        """Anchor, normal and pressing force (n, 2 dim + 1) with the surface as it is at `x`."""
        gap, normal, _ = self._contact._distance(x)
        return np.column_stack([anchor, normal, self._contact.force(gap)])

    @property
    def history(self) -> Array | None:
        """Anchors, normals and pressing forces (n, 2 dim + 1)."""
        return self._committed

    @history.setter
    def history(self, value: Array | None) -> None:
        self._committed = self._first if value is None else np.array(value, dtype=float)

    def _way(self, x: Array, state: Array) -> tuple[Array, Array]:
        """Way along the surface (n, dim) from the anchors, and the normals."""
        dim = self.rest.shape[1]
        normal = state[:, dim : 2 * dim]
        apart = np.asarray(x)[self.conn[:, 0]] - state[:, :dim]
        return apart - (apart * normal).sum(axis=1, keepdims=True) * normal, normal

    def commit(self, x: Array) -> None:
        place = np.array(np.asarray(x)[self.conn[:, 0]])
        state = self._state(self._committed[:, : self.rest.shape[1]], np.asarray(x))
        way, _ = self._way(x, state)
        size = np.linalg.norm(way, axis=1)
        kept = np.minimum(1.0, self.width / np.where(size > 0, size, 1.0)) * (state[:, -1] > 0)
        state[:, : self.rest.shape[1]] = place - kept[:, None] * way
        self._committed = state

    def deformation(self, x: Array) -> Array:
        """Share of the limit (n, dim) that is used up along the surface: a node whose share has the length 1 slides."""
        way, _ = self._way(x, self._committed)
        size = np.linalg.norm(way, axis=1)
        return np.asarray(way / np.maximum(size, self.width)[:, None])

    def traction(self, x: Array) -> Array:
        """Force (n, dim) of the nodes on the surface, along it."""
        return np.asarray((self.friction * self._committed[:, -1])[:, None] * self.deformation(x))

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        way, normal = self._way(x, self._committed)
        size, w = np.linalg.norm(way, axis=1), self.width
        limit = self.friction * self._committed[:, -1]
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
