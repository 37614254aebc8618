"""Rigid grips: rows that follow u_i = c + (R(theta) - 1) X_i, with a displacement c and a rotation vector theta."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kirigami.primitives.following import FollowingRows, Index, Links
from kirigami.primitives.kernel import Array
from kirigami.primitives.rotation import best_rotation, rate_of_spin, turn_curvature, turn_rates, turned


@dataclass(frozen=True, eq=False)
class GripRows(FollowingRows):
    """The rows that move as one rigid body, and the two that say how.

    Attributes
    ----------
    points, vectors : ndarray of int, shape (k,) and (m,)
        Rows that are positions, and rows that are differences of positions, which turn but do not shift.
    arms : ndarray, shape (k + m, 3)
        What they hold at rest, the positions against their centroid.
    shift : int
        Row of the displacement of the centroid.
    turn : int
        Row of the rotation vector times `radius`; in a plane its first number is the angle times `radius`.
    radius : float
        Root mean square of the arms of the points [length].
    """

    points: Index
    vectors: Index
    arms: Array
    shift: int
    turn: int
    radius: float
    words = "a Grip or RigidLink"
    remedy = "put it into the Grip instead"

    @property
    def followers(self) -> Index:
        return np.concatenate([self.points, self.vectors])

    @property
    def links(self) -> Links:
        followers, count = self.followers, len(self.points)
        return Links(
            np.concatenate([self.points, followers]),
            np.repeat([self.shift, self.turn], [count, len(followers)]),
            np.concatenate([np.zeros(count, np.int64), 1 + np.arange(len(followers))]),
        )

    def _theta(self, u: Array) -> Array:
        row: Array = u[self.turn] / self.radius
        return row if len(row) == 3 else np.array([0.0, 0.0, row[0]])

    def rates(self, u: Array) -> Array:
        rates = turn_rates(self._theta(u), self.arms) / self.radius
        if u.shape[1] == 3:
            return rates
        plane = np.zeros((len(rates), 2, 2))
        plane[:, :, 0] = rates[:, :2, 2]
        return plane

    def fill(self, u: Array) -> None:
        u[self.followers] = turned(self._theta(u), self.arms)[:, : u.shape[1]]
        u[self.points] += u[self.shift]

    def lead(self, field: Array, spin: Array, about: Array) -> None:
        if not field[self.points].any() and not spin.any():
            return
        dim, count = field.shape[1], len(self.points)
        now = self.arms[:count] + turned(self._theta(about), self.arms[:count])
        field[self.shift] = (field[self.points] - np.cross(spin, now)[:, :dim]).mean(axis=0)
        rate = self.radius * rate_of_spin(self._theta(about), spin)
        field[self.turn] = rate if dim == 3 else (rate[2], 0.0)

    def carry(self, total: Array, u: Array, chord: Array | None = None) -> None:
        """With a `chord`: the derivative in its middle, and in the direction of the turn the quotient of both ends."""
        if chord is None:
            rates = self.rates(u)
        else:
            turn = chord[self.turn]
            rates = self.rates(u - 0.5 * chord)
            square = float(turn @ turn)
            if square > 0:
                went = chord[self.followers].copy()
                went[: len(self.points)] -= chord[self.shift]
                rates = rates + (went - rates @ turn)[:, :, None] * turn / square
        total[self.shift] += total[self.points].sum(axis=0)
        total[self.turn] += np.einsum("nij,ni->j", rates, total[self.followers])

    def curvature(self, u: Array, total: Array) -> tuple[int, Array]:
        dim = u.shape[1]
        forces = np.zeros((len(self.followers), 3))
        forces[:, :dim] = total[self.followers]
        bent = turn_curvature(self._theta(u), forces, self.arms) / self.radius**2
        if dim == 3:
            return self.turn, bent
        return self.turn, np.array([[bent[2, 2], 0.0], [0.0, 0.0]])

    def lead_rates(self, field: Array, about: Array) -> None:
        """The nearest rigid motion."""
        dim, count = field.shape[1], len(self.points)
        arms = self.arms[:count] + turned(self._theta(about), self.arms[:count])
        away = np.zeros((count, 3))
        field[self.shift] = field[self.points].mean(axis=0)
        away[:, :dim] = field[self.points] - field[self.shift]
        inertia = (arms**2).sum() * np.eye(3) - arms.T @ arms
        spin = np.linalg.lstsq(inertia, np.cross(arms, away).sum(axis=0), rcond=1e-12)[0]
        rate = self.radius * rate_of_spin(self._theta(about), spin)
        field[self.turn] = rate if dim == 3 else (rate[2], 0.0)

    def settle(self, rows: Array) -> None:
        dim, count = rows.shape[1], len(self.points)
        arms, now = self.arms[:count], np.zeros((count, 3))
        rows[self.shift] = rows[self.points].mean(axis=0)
        now[:, :dim] = arms[:, :dim] + rows[self.points] - rows[self.shift]
        theta = best_rotation(arms, now) * self.radius
        rows[self.turn] = theta if dim == 3 else (theta[2], 0.0)
        self.fill(rows)
