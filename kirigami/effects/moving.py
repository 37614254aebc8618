"""A rigid surface that moves: contact with what is driven, and friction against its own velocity.

At load factor L a point X of the surface stands at

    x = p + s(L) + R(a(L)) (X - p),

with the shift s, the angle a about an axis n through p, and so moves with v = s' + a' n x (x - p - s) as L grows. A
contact is what it is at rest, seen from the surface: with H the Hessian and g the gradient by positions,

    dE/dL = -g.v,    dg/dL = a' n x g - H v.

What sticks is carried along by the surface: the anchor of a node moves with it, and slip is what is left of the way of
the node. An anchor is kept where it is in space, with the load factor at which it was there.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.effects.contact import ContactKernel
from kirigami.effects.friction import FrictionKernel
from kirigami.effects.surfaces import Moving
from kirigami.errors import ModelError
from kirigami.primitives.kernel import EXACT, Array, Contribution, Kernel, Tangent


class Placement:
    """Where a moving surface stands at a load factor.

    Parameters
    ----------
    dim : int
        Of the model.
    shift, angle : ndarray, shape (k, 3) and (k,)
        At the load factors `at` (k,), or where that is nan at load factor 1 [length, rad].
    about, axis : ndarray, shape (3,)
        Point and direction of the axis.
    reached : ndarray, shape ()
        Load factor at which it stands still; nan where it moves.
    """

    def __init__(
        self, dim: int, shift: Array, angle: Array, about: Array, axis: Array, at: Array, reached: Array
    ) -> None:
        self.dim, self.about, self.axis = dim, about[:dim], axis
        self.moves = bool(np.isnan(reached))
        self._reached = float(reached)
        self._by_factor = bool(np.isnan(at[0]))
        ways = np.concatenate([np.zeros((1, 4)), np.column_stack([shift, angle])])
        self._at, self._ways = np.array([0.0, 1.0]) if self._by_factor else np.append(0.0, at), ways
        self._spin = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])

    def _standing(self, lam: float) -> tuple[Array, Array]:
        """Shift and angle (4,) at a load factor, and their rates."""
        lam = lam if self.moves else self._reached
        if self._by_factor:
            return lam * self._ways[1], self._ways[1]
        piece = int(np.searchsorted(self._at, lam, side="right")) - 1
        if piece < 0 or piece == len(self._at) - 1:
            return self._ways[max(piece, 0)], np.zeros(4)
        rate = np.diff(self._ways, axis=0)[piece] / np.diff(self._at)[piece]
        return self._ways[piece] + (lam - self._at[piece]) * rate, rate

    def rotation(self, lam: float) -> Array:
        """Rotation (dim, dim)."""
        angle = self._standing(lam)[0][3]
        turned: Array = np.eye(3) + np.sin(angle) * self._spin + (1 - np.cos(angle)) * self._spin @ self._spin
        return turned[: self.dim, : self.dim]

    def back(self, places: Array, lam: float) -> Array:
        """Where points of the surface at `places` (n, dim) are at load factor 0."""
        shift = self._standing(lam)[0][: self.dim]
        return np.asarray((places - self.about - shift) @ self.rotation(lam) + self.about)

    def forth(self, places: Array, lam: float) -> Array:
        """Where points of the surface that are at `places` (n, dim) at load factor 0 have come to."""
        shift = self._standing(lam)[0][: self.dim]
        return np.asarray((places - self.about) @ self.rotation(lam).T + self.about + shift)

    def spin(self, lam: float) -> Array:
        """Change (dim, dim) of what turns with the surface with the load factor, by what it is."""
        return np.asarray(self._standing(lam)[1][3] * self._spin[: self.dim, : self.dim])

    def velocity(self, places: Array, lam: float) -> Array:
        """Change (n, dim) with the load factor of the place of what is at `places` (n, dim) on the surface."""
        standing, rate = self._standing(lam)
        arms = places - self.about - standing[: self.dim]
        return np.asarray(rate[: self.dim] + arms @ self.spin(lam).T)


MOTION = ("shift", "angle", "about", "axis", "at", "reached")  # arguments of a placement


class MovingContactKernel(ContactKernel):
    """Contacts of nodes with one moving surface: those of :class:`ContactKernel`, seen from the surface."""

    def __init__(self, rest: Array, conn: NDArray[np.int64], *surface: Any, **more: Any) -> None:
        self.motion = {name: np.asarray(more.pop(name), dtype=float) for name in MOTION}
        super().__init__(rest, conn, *surface, **more)
        self.placement = Placement(rest.shape[1], **self.motion)
        self.scaled = self.placement.moves

    def arrays(self) -> dict[str, Any]:
        return {**super().arrays(), **self.motion}

    def _back(self, x: Array, lam: float) -> Array:
        return self.placement.back(self.places_of(x), lam)

    def deformation_at(self, x: Array, lam: float) -> Array:
        return self.distance(self._back(x, lam))[0]

    def normals(self, x: Array, lam: float) -> tuple[Array, Array]:
        gap, direction, _ = self.distance(self._back(x, lam))
        return gap, direction @ self.placement.rotation(lam).T

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        found = self.pushed(self._back(x, lam), need, tangent)
        turn = self.placement.rotation(lam)
        return Contribution(
            found.energy,
            None if found.gradient is None else found.gradient @ turn.T,
            None if found.hessian is None else turn @ found.hessian @ turn.T,
        )

    def by_load(self, x: Array, lam: float, need: int = 1) -> Contribution:
        found = self.evaluate(x, lam, 1 if need == 0 else 2)
        velocity = self.placement.velocity(self.places_of(x), lam)
        assert found.gradient is not None
        energy = -np.einsum("na,na->n", found.gradient[:, 0], velocity)
        if need == 0:
            return Contribution(energy)
        assert found.hessian is not None
        turned = found.gradient @ self.placement.spin(lam).T
        return Contribution(energy, turned - np.einsum("nab,nb->na", found.hessian[:, 0, 0], velocity)[:, None])


class MovingFrictionKernel(FrictionKernel):
    """Friction on one moving surface, which carries the anchors."""

    _contact: MovingContactKernel
    contact_kind = MovingContactKernel

    def __init__(self, rest: Array, friction: Array, width: Array, **contact: Any) -> None:
        super().__init__(rest, friction, width, **contact)
        self.scaled = self._contact.scaled

    def _anchors(self, lam: float) -> Array:
        anchors = super()._anchors(lam)
        placement = self._contact.placement
        kept = float(np.nan_to_num(self._committed[0, -1]))
        return placement.forth(placement.back(anchors, kept), lam) if self.scaled and kept != lam else anchors

    def by_load(self, x: Array, lam: float, need: int = 1) -> Contribution:
        found = self.evaluate(x, lam, 1 if need == 0 else 2)
        velocity = self._contact.placement.velocity(self._anchors(lam), lam)
        assert found.gradient is not None
        energy = -np.einsum("na,na->n", found.gradient[:, 0], velocity)
        if need == 0:
            return Contribution(energy)
        assert found.hessian is not None
        return Contribution(energy, -np.einsum("nab,nb->na", found.hessian[:, 0, 0], velocity)[:, None])


def moving_kernels(motion: Moving, rest: Array, friction: Array, contact: dict[str, Any]) -> list[Kernel]:
    """Kernels of one contact with a moving surface; `contact` holds the arguments of that with the surface where it is
    at load factor 0."""
    dim = rest.shape[1]
    if dim == 2 and any(motion.angle) and any(motion.axis[:2]):
        raise ModelError(f"Contact: {motion!r} turns out of the plane of a model with dim=2: give axis='z'")
    at = (np.nan,) if motion.at is None else motion.at
    values = motion.shift, np.radians(motion.angle), motion.about, motion.axis, at
    reached = np.nan if motion.reached is None else motion.reached
    arrays = {**contact, **dict(zip(MOTION, (*map(np.array, values), np.array(reached))))}
    found: list[Kernel] = [MovingContactKernel(rest, **arrays)]
    if friction.any():
        found.append(MovingFrictionKernel(rest, friction, contact["layer"], **arrays))
    return found
