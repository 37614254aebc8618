"""Rigid grips in a system: rows that follow, u_i = c + (R(theta) - 1) X_i, are eliminated by a nonlinear map.

The unknowns stay those of the linear map u = T q + lam drive + held, in which the rows of c and theta stand like any
others; the rows that follow are filled in behind it. Seen from there, with J = du / d(c, theta),

    gradient  J' g,        Hessian  J' K J + sum_i g_i . d2 u_i / d theta2,

so forces are added onto the two rows of a grip, node blocks onto their pairs with the neighbours of what follows, and
nothing else of the system knows of it. The pairs are planned once.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.kernel import Array
from kirigami.primitives.rotation import best_rotation, rate_of_spin, turn_curvature, turn_rates, turned
from kirigami.primitives.rows import GripRows

Index = NDArray[np.int64]


class Grips:
    """All grips of a system.

    Parameters
    ----------
    grips : iterable of GripRows
        The rows that follow, and those that lead.
    rest : ndarray, shape (rows, dim)
        What each row holds in the rest state.
    """

    def __init__(self, grips: Iterable[GripRows], rest: Array) -> None:
        self.grips = list(grips)
        self.rest, self.dim = rest, rest.shape[1]
        self.followers = np.concatenate([grip.followers for grip in self.grips])
        self._plan: tuple[Any, ...] | None = None
        self._planned_for: Index | None = None

    def _theta(self, grip: GripRows, u: Array) -> Array:
        row = u[grip.turn] / grip.radius
        return row if self.dim == 3 else np.array([0.0, 0.0, row[0]])

    def _rates(self, grip: GripRows, u: Array) -> Array:
        """Derivatives (followers, dim, dim) of what follows by the row of the rotation."""
        rates = turn_rates(self._theta(grip, u), grip.arms) / grip.radius
        if self.dim == 3:
            return rates
        plane = np.zeros((len(rates), 2, 2))
        plane[:, :, 0] = rates[:, :2, 2]
        return plane

    def fill(self, u: Array) -> None:
        """Put the rows (rows, dim) that follow where the grips are."""
        for grip in self.grips:
            u[grip.followers] = turned(self._theta(grip, u), grip.arms)[:, : self.dim]
            u[grip.points] += u[grip.shift]

    def follow(self, change: Array, about: Array) -> None:
        """The same for a small change (rows, dim) of displacements, to first order `about` given ones."""
        for grip in self.grips:
            change[grip.followers] = self._rates(grip, about) @ change[grip.turn]
            change[grip.points] += change[grip.shift]

    def lead(self, field: Array, spin: Array, about: Array) -> None:
        """Write into a rigid motion (rows, dim) with the given spin (3,) what moves the grips `about` displacements."""
        for grip in self.grips:
            if not np.isin(grip.points, np.flatnonzero(field.any(axis=1))).any() and not spin.any():
                continue
            count = len(grip.points)
            now = grip.arms[:count] + turned(self._theta(grip, about), grip.arms[:count])
            field[grip.shift] = (field[grip.points] - np.cross(spin, now)[:, : self.dim]).mean(axis=0)
            rate = grip.radius * rate_of_spin(self._theta(grip, about), spin)
            field[grip.turn] = rate if self.dim == 3 else (rate[2], 0.0)

    def led_freely(self, free: Any) -> Any:
        """Which displacements (rows, dim) follow one of those that are `free` (rows, dim)."""
        found = np.zeros_like(free)
        for grip in self.grips:
            found[grip.followers] = free[grip.turn].any()
            found[grip.points] |= free[grip.shift].any()
        return found

    def carry(self, total: Array, u: Array, chord: Array | None = None) -> None:
        """Add forces (rows, dim) on what follows to the rows that lead.

        With a `chord` (rows, dim) that ends at `u`, what they work on it is the same on both sides: the derivative in
        its middle, and in the direction of the turn the quotient of differences.
        """
        for grip in self.grips:
            if chord is None:
                rates = self._rates(grip, u)
            else:
                turn = chord[grip.turn]
                rates = self._rates(grip, u - 0.5 * chord)
                square = float(turn @ turn)
                if square > 0:
                    went = chord[grip.followers].copy()
                    went[: len(grip.points)] -= chord[grip.shift]
                    rates = rates + (went - rates @ turn)[:, :, None] * turn / square
            total[grip.shift] += total[grip.points].sum(axis=0)
            total[grip.turn] += np.einsum("nij,ni->j", rates, total[grip.followers])

    def lead_rates(self, field: Array, about: Array) -> None:
        """Write into velocities (rows, dim) of what follows those of the rows that lead: the nearest rigid motion."""
        for grip in self.grips:
            count = len(grip.points)
            arms = grip.arms[:count] + turned(self._theta(grip, about), grip.arms[:count])
            away = np.zeros((count, 3))
            field[grip.shift] = field[grip.points].mean(axis=0)
            away[:, : self.dim] = field[grip.points] - field[grip.shift]
            inertia = (arms**2).sum() * np.eye(3) - arms.T @ arms
            spin = np.linalg.lstsq(inertia, np.cross(arms, away).sum(axis=0), rcond=1e-12)[0]
            rate = grip.radius * rate_of_spin(self._theta(grip, about), spin)
            field[grip.turn] = rate if self.dim == 3 else (rate[2], 0.0)

    def settle(self, rows: Array) -> None:
        """Guess the rows that lead from the displacements of the points, and let the others follow."""
        for grip in self.grips:
            count = len(grip.points)
            arms, now = grip.arms[:count], np.zeros((count, 3))
            rows[grip.shift] = rows[grip.points].mean(axis=0)
            now[:, : self.dim] = arms[:, : self.dim] + rows[grip.points] - rows[grip.shift]
            theta = best_rotation(arms, now) * grip.radius
            rows[grip.turn] = theta if self.dim == 3 else (theta[2], 0.0)
        self.fill(rows)

    # ---- stiffness

    def images(self) -> tuple[Index, Index, Index]:
        """Rows that follow (n,), the rows they lead to (n, 2) as shift and turn, and whether they shift (n,)."""
        leads = [np.tile([grip.shift, grip.turn], (len(grip.followers), 1)) for grip in self.grips]
        shifts = [np.arange(len(grip.followers)) < len(grip.points) for grip in self.grips]
        return self.followers, np.concatenate(leads), np.concatenate(shifts)

    def pairs(self, low: Index, high: Index) -> tuple[Index, Index]:
        """Pairs of rows, the lower first, that blocks of given pairs are carried to."""
        rows = self._spread(low, high)
        first, second = rows[1], rows[2]
        lead = np.array([[grip.turn, grip.turn] for grip in self.grips])
        first, second = np.concatenate([first, lead[:, 0]]), np.concatenate([second, lead[:, 1]])
        return np.minimum(first, second), np.maximum(first, second)

    def _spread(self, low: Index, high: Index) -> tuple[Index, ...]:
        """Terms J_a' B J_b: block, rows a and b they belong to, and which J stand on either side.

        J number 0 is the identity; then come those of the turns of what follows.
        """
        followers, leads, shifts = self.images()
        place = np.full(len(self.rest), -1)
        place[followers] = np.arange(len(followers))
        block = np.flatnonzero((place[low] >= 0) | (place[high] >= 0))
        terms = []
        for left in (0, 1, 2):  # not a follower, its shift, its turn
            for right in (0, 1, 2):
                at = block
                rows: list[Index] = []
                numbers: list[Index] = []
                for side, ends in ((left, low), (right, high)):
                    number = place[ends[at]]
                    fits = number < 0 if side == 0 else (number >= 0) & (shifts[number] | (side == 2))
                    at = at[fits]
                    rows, numbers = [row[fits] for row in rows], [other[fits] for other in numbers]
                    number = place[ends[at]]
                    rows.append(ends[at] if side == 0 else leads[number, side - 1])
                    numbers.append(np.where(side == 2, number + 1, 0))
                terms.append((at, *rows, *numbers))
        at, first, second, left_of, right_of = (np.concatenate(part) for part in zip(*terms))
        # Within the block of a follower with itself the term (turn, shift) is the transpose of (shift, turn).
        once = (low[at] != high[at]) | (first <= second)
        return at[once], first[once], second[once], left_of[once], right_of[once]

    def _planned(self, low: Index, high: Index) -> tuple[Any, ...]:
        """The terms of :meth:`_spread` with the slot each adds to, whether turned over, and whether both ways."""
        at, first, second, left, right = self._spread(low, high)
        size = len(self.rest)
        slot = np.searchsorted(low * size + high, np.minimum(first, second) * size + np.maximum(first, second))
        return at, slot, left, right, first > second, (first == second) & (low[at] != high[at])

    def condense(
        self, blocks: Array, low: Index, high: Index, u: Array, total: Array, convexity: float
    ) -> None:
        """Add the blocks (dim, dim, blocks) of what follows to those of the rows that lead.

        `low` and `high` are the rows of each block, sorted by the lower one and then the higher; `total` (rows, dim)
        are the forces at `u`.
        """
        if self._plan is None or self._planned_for is not low:
            self._plan, self._planned_for = self._planned(low, high), low
        at, slot, left, right, flipped, both = self._plan
        chains = np.concatenate([np.eye(self.dim)[None], *(self._rates(grip, u) for grip in self.grips)])
        made = chains[left].swapaxes(1, 2) @ blocks[:, :, at].transpose(2, 0, 1) @ chains[right]
        made = np.where(flipped[:, None, None], made.swapaxes(1, 2), made)
        made += np.where(both[:, None, None], made.swapaxes(1, 2), 0.0)
        for a in range(self.dim):
            for b in range(self.dim):
                blocks[a, b] += np.bincount(slot, made[:, a, b], blocks.shape[2])
        for grip in self.grips:
            forces = np.zeros((len(grip.followers), 3))
            forces[:, : self.dim] = total[grip.followers]
            bent = (1 - convexity) * turn_curvature(self._theta(grip, u), forces, grip.arms) / grip.radius**2
            own = int(np.searchsorted(low * len(self.rest) + high, grip.turn * (len(self.rest) + 1)))
            if self.dim == 3:
                blocks[:, :, own] += bent
            else:
                blocks[0, 0, own] += bent[2, 2]
