"""Rows of a system that follow others, by rigid grips and periodic cells: they are eliminated by a map.

The unknowns stay those of the linear map u = T q + lam drive + held, in which the rows that lead stand like any others;
the rows that follow are filled in behind it. Seen from there, with J = du_follower / du_lead,

    gradient  J' g,        Hessian  J' K J + sum_i g_i . d2 u_i / d lead2,

so forces are added onto the rows that lead, node blocks onto their pairs with the neighbours of what follows, and
nothing else of the system knows of it. The pairs are planned once.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.primitives.following import FollowingRows, Links
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import place_in_words

Index = NDArray[np.int64]


class Grips:
    """All rows of a system that follow others.

    Parameters
    ----------
    groups : iterable of FollowingRows
        Grips and cells.
    rest : ndarray, shape (rows, dim)
        What each row holds in the rest state.
    """

    def __init__(self, groups: Iterable[FollowingRows], rest: Array) -> None:
        self.groups = list(groups)
        self.rest, self.dim = rest, rest.shape[1]
        self.followers = np.concatenate([group.followers for group in self.groups])
        self.links = self._joined([group.links for group in self.groups])
        self._plan: tuple[Any, ...] | None = None
        self._planned_for: Index | None = None

    def _joined(self, links: list[Links]) -> Links:
        """The links of all groups, with their rates counted on; no row that leads may follow another one."""
        before, rate = 0, []
        for own in links:
            rate.append(np.where(own.rate > 0, own.rate + before, 0))
            before += int(own.rate.max(initial=0))
        joined = Links(*(np.concatenate(part) for part in zip(*links)))._replace(rate=np.concatenate(rate))
        for row in joined.lead[np.isin(joined.lead, self.followers)].tolist():
            both = " and ".join(group.words for group in self.groups)
            raise ModelError(
                f"what is at {place_in_words(self.rest[row])} follows one of {both}, and is followed by "
                "another one: keep them apart"
            )
        return joined

    def fill(self, u: Array) -> None:
        """Put the rows (rows, dim) that follow in their places."""
        for group in self.groups:
            group.fill(u)

    def follow(self, change: Array, about: Array) -> None:
        """The same for a small change (rows, dim) of displacements, to first order `about` given ones."""
        for group in self.groups:
            group.follow(change, about)

    def lead(self, field: Array, spin: Array, about: Array) -> None:
        """Write into a rigid motion (rows, dim) with the given spin (3,) what moves the rows that lead."""
        for group in self.groups:
            group.lead(field, spin, about)

    def led_freely(self, free: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which displacements (rows, dim) follow one of those that are `free` (rows, dim)."""
        found = np.zeros_like(free)
        for group in self.groups:
            found |= group.led_freely(free)
        return found

    def carry(self, total: Array, u: Array, chord: Array | None = None) -> None:
        """Add forces (rows, dim) on what follows to the rows that lead.

        With a `chord` (rows, dim) that ends at `u`, what they work on it is the same on both sides.
        """
        for group in self.groups:
            group.carry(total, u, chord)

    def lead_rates(self, field: Array, about: Array) -> None:
        """Write into velocities (rows, dim) of what follows those of the rows that lead."""
        for group in self.groups:
            group.lead_rates(field, about)

    def settle(self, rows: Array) -> None:
        """Guess the rows that lead from the displacements of the points, and let the others follow."""
        for group in self.groups:
            group.settle(rows)

    # ---- stiffness

    def chain(self, u: Array) -> Any:
        """Sparse matrix (rows * dim, rows * dim) of the displacements of all rows by their own, with those of what
        follows by the rows that lead beside it, at `u`."""
        from scipy.sparse import coo_array, eye_array

        follower, lead, rate = self.links
        axes = np.arange(self.dim)
        row, column = (self.dim * part[:, None] + axes for part in (follower, lead))
        row, column = np.broadcast_arrays(row[:, :, None], column[:, None])
        values = self._matrices(u)[rate]
        size = self.rest.size
        beside = coo_array((values.ravel(), (row.ravel(), column.ravel())), shape=(size, size))
        return (beside + eye_array(size)).tocsr()

    def _matrices(self, u: Array) -> Array:
        """All J at displacements `u`: the unit matrix, then the rates of all groups."""
        here = u[:, : self.dim]
        return np.concatenate([np.eye(self.dim)[None], *(group.rates(here) for group in self.groups)])

    def pairs(self, low: Index, high: Index) -> tuple[Index, Index]:
        """Pairs of rows, the lower first, that blocks of given pairs are carried to."""
        _, first, second, _, _ = self._spread(low, high)
        lead = np.unique(self.links.lead[self.links.rate > 0])
        first, second = np.concatenate([first, lead]), np.concatenate([second, lead])
        return np.minimum(first, second), np.maximum(first, second)

    def _spread(self, low: Index, high: Index) -> tuple[Index, ...]:
        """Terms J_a' B J_b: block, rows a and b they belong to, and the number of the J on either side."""
        n = len(self.rest)
        alone = np.setdiff1d(np.arange(n), self.followers)  # what follows nothing leads itself
        links = Links(
            np.concatenate([alone, self.links.follower]),
            np.concatenate([alone, self.links.lead]),
            np.concatenate([np.zeros(len(alone), np.int64), self.links.rate]),
        )
        order = np.argsort(links.follower, kind="stable")
        lead, rate = links.lead[order], links.rate[order]
        count = np.bincount(links.follower, minlength=n)
        start = np.cumsum(count) - count
        follows = np.zeros(n, dtype=bool)
        follows[self.followers] = True
        block = np.flatnonzero(follows[low] | follows[high])
        wide = count[high[block]]
        terms = count[low[block]] * wide
        at = np.repeat(block, terms)
        own = np.arange(len(at)) - np.repeat(np.cumsum(terms) - terms, terms)
        left, right = start[low[at]] + own // np.repeat(wide, terms), start[high[at]] + own % np.repeat(wide, terms)
        # Within the block of a row with itself the term (a, b) is the transpose of (b, a).
        once = (low[at] != high[at]) | (lead[left] <= lead[right])
        at, left, right = at[once], left[once], right[once]
        return at, lead[left], lead[right], rate[left], rate[right]

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
        here, chains = u[:, : self.dim], self._matrices(u)
        made = chains[left].swapaxes(1, 2) @ blocks[:, :, at].transpose(2, 0, 1) @ chains[right]
        made = np.where(flipped[:, None, None], made.swapaxes(1, 2), made)
        made += np.where(both[:, None, None], made.swapaxes(1, 2), 0.0)
        for a in range(self.dim):
            for b in range(self.dim):
                blocks[a, b] += np.bincount(slot, made[:, a, b], blocks.shape[2])
        for group in self.groups:
            bent = group.curvature(here, total)
            if bent is not None:
                row, curvature = bent
                own = int(np.searchsorted(low * len(self.rest) + high, row * (len(self.rest) + 1)))
                blocks[:, :, own] += (1 - convexity) * curvature
