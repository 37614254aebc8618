"""What all members that resist an angle share: unwrapping against the last committed state, and a linear law.

The angle without moment may be driven: theta_0 + lam (theta_1 - theta_0), with lam the load factor. The energy
k (theta - theta_0(lam))^2 / 2 then changes with it by -M (theta_1 - theta_0), M the moment.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.driven_rest import driven, untouched
from kirigami.primitives.kernel import Array, Configuration, Contribution, Kernel, full_hessian

TURN = 2 * math.pi


class AngleKernel(Kernel):
    """Base of hinges and springs: a subclass measures the raw angle, this class counts its turns.

    The angle is unwrapped against the last committed state, so it may pass any number of turns.
    """

    approximates = True
    stiffness: Array
    rest_angle: Array
    drive: Array | None  # change of the rest angle with the load factor
    _initial: Array
    _committed: Array
    follows: NDArray[np.bool_] | None = None  # whose angle without moment (n,) is that of the rest state

    def _begin(self, initial: Array, rest_angle: Array, targets: Array | None = None) -> None:
        """Start from the angles of the rest state; nan among the rest angles takes them over. `targets` as by
        :func:`kirigami.elements.driven_rest.targets_of`."""
        self._initial = initial
        self._committed = initial.copy()
        self.follows = np.isnan(rest_angle)
        self.rest_angle, self.drive = driven(np.where(np.isnan(rest_angle), initial, rest_angle), targets)
        self.scaled = self.drive is not None

    def actuate(self, members: NDArray[np.int64], values: Array, constant: bool) -> None:
        """Add `values` (k,) to the angle without moment of `members` (k,), in full or with the load factor."""
        self.follows = None  # what is told may depend on the rest state as well
        turned = np.zeros(len(self.conn))
        np.add.at(turned, members, values)
        if constant:
            self.rest_angle = self.rest_angle + turned
        else:
            self.drive = turned if self.drive is None else self.drive + turned
            self.scaled = True

    def rest_angle_at(self, lam: float) -> Array:
        """Angle without moment (n,) at a load factor."""
        return self.rest_angle if self.drive is None else self.rest_angle + lam * self.drive

    def by_load(self, x: Array, lam: float, need: int = 1) -> Contribution:
        assert self.drive is not None
        angle = self.deformation(x)
        rate = -self.force_at(angle, lam) * self.drive
        if need == 0:
            return Contribution(rate)
        pull = self.angle_derivatives(x) * (-self.stiffness * self.drive)[:, None, None]
        return Contribution(rate, pull)

    def angle_derivatives(self, x: Array) -> Array:
        """Gradient (n, k, dim) of the angle of each member."""
        raise NotImplementedError

    def by_rest(self, x: Array, lam: float, fields: Array, energies: Array) -> Array | None:
        """In closed form: where the nodes are, by the Hessian; what angles without moment are, by their gradients."""
        if self.follows is None or self.drive is not None:
            return None
        rest: Array = self.rest  # type: ignore[attr-defined]
        told = self.evaluate(x, lam, 2)
        assert told.gradient is not None
        hessian, turning = full_hessian(self, told), self.angle_derivatives(x)
        at_rest = self.angle_derivatives(Configuration(rest, np.zeros_like(rest))) * self.follows[:, None, None]
        excess = self.deformation(x) - self.rest_angle
        found = np.zeros((len(fields), *rest.shape))
        for total, field, share in zip(found, fields, energies.tolist()):
            moved = field[self.conn]
            rows = np.einsum("nklab,nlb->nka", hessian, moved) + share * told.gradient
            moment = self.stiffness * (np.einsum("nka,nka->n", turning, moved) + share * excess)
            np.add.at(total, self.conn, rows - moment[:, None, None] * at_rest)
        return found

    def unwrap(self, angle: Array) -> Array:
        """The value of a raw angle, known up to whole turns, that lies nearest to the committed one.

        Whole turns are added, so that the same raw angle gives the same value to the last digit: a structure at rest
        has moments of exactly zero.
        """
        unwrapped: Array = angle + TURN * np.round((self._committed - angle) / TURN)
        return unwrapped

    @property
    def history(self) -> Array | None:
        return self._committed

    @history.setter
    def history(self, value: Array | None) -> None:
        self._committed = self._initial.copy() if value is None else np.array(value, dtype=float)

    def commit(self, x: Array) -> None:
        self._committed = self.deformation(x)

    def arrays(self) -> dict[str, Any]:
        own = {name: getattr(self, name) for name in ("conn", "stiffness", "rest_angle", "members")}
        return own if self.drive is None else {**own, "targets": untouched(self.rest_angle, self.drive)}

    def deformation(self, x: Array) -> Array:
        """Unwrapped angle of each member (n,) [rad]."""
        raise NotImplementedError

    def force(self, angle: Array) -> Array:
        """Moment of each member (n,), positive where the angle is above its rest value."""
        return self.stiffness * (angle - self.rest_angle)

    def force_at(self, deformation: Array, lam: float) -> Array:
        return self.stiffness * (deformation - self.rest_angle_at(lam))
