"""Unknowns of a constrained model: which displacements are free, tied, driven or held."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES
from kirigami.primitives.parts import Numbering
from kirigami.system.assembly import Index

if TYPE_CHECKING:
    from kirigami.system.grips import Grips


class Unknowns:
    """The map between unknowns q and displacements, u = T q + lam * drive + held, where T only picks.

    Ties are resolved into a leader and an offset for each displacement, so that several may pick the same unknown.
    What turns (:class:`kirigami.model.turn.Turn`) leaves the straight line on arcs; `drive` is its rate at rest.
    What follows a rigid grip, or repeats from cell to cell, is filled in behind it (:mod:`kirigami.system.grips`).
    """

    grips: Grips | None = None
    begun: float = 1.0  # share of `held` that is there, less than 1 while a start from rest grows into it

    def __init__(self, numbering: Numbering, constraints: Sequence[Any], apart: Sequence[Any] = ()) -> None:
        self.dim = numbering.dim
        self.rest = numbering.rest
        self.points = numbering.points
        self.edges = numbering.edges
        dofs = self.rest.size
        leader = np.arange(dofs)
        fixed = np.zeros(dofs, dtype=bool)
        drive, held = np.zeros(dofs), np.zeros(dofs)
        owner: Index = np.full(dofs, -1)
        still = np.zeros(dofs, dtype=bool)  # held at zero, as another constraint may do once more
        self.arcs: list[Any] = []
        for position, item in enumerate(constraints):
            if id(item) in numbering.grips:
                known, values = self._hold_followers(item, numbering, position, owner, constraints)
                fixed[known] = True
                (held if item.constant else drive)[known] = values
                continue
            nodes = numbering.index(item.group)
            leaders = numbering.index(item.leaders)
            axes = [axis for axis in item.values if AXES.index(axis) < self.dim]
            if not axes:
                raise ModelError(f"{item!r} constrains only z, but the model has dim=2")
            for axis in axes:
                at, values = nodes * self.dim + AXES.index(axis), item.values[axis]
                holds = (values == 0) & (not item.leaders and item.rotation is None)
                self._check_conflict(at, axis, item, owner, constraints, numbering, holds & still[at])
                still[at[holds]] = True
                owner[at] = position
                (held if item.constant else drive)[at] = values
                if item.leaders:
                    leader[at] = leaders * self.dim + AXES.index(axis)
                else:
                    fixed[at] = True
            if numbering.edges is not None:
                from kirigami.system.edges import held_angles, held_middles, turned_angles  # a truss needs no mesh

                known, change = held_middles(numbering.edges, item, nodes, leaders, self.rest)
                (held if item.constant else drive)[known] = change
                middles = known // self.dim
                if item.clamp or item.mirror:
                    angles = held_angles(numbering.edges, nodes, self.dim, item.rotation is not None)
                    if item.rotation is not None:
                        change = turned_angles(numbering.edges, angles, item.rotation, self.rest)
                        (held if item.constant else drive)[angles] = change
                    known = np.concatenate([known, angles])
                owner[known], fixed[known] = position, True
            if item.rotation is not None and not item.constant:
                self._turn(item, nodes, middles if numbering.edges is not None else nodes[:0], drive, position)
        fixed |= numbering.idle.ravel()
        if numbering.grips:
            from kirigami.system.grips import Grips

            self.grips = Grips(numbering.grips.values(), self.rest)
            fixed.reshape(-1, self.dim)[self.grips.followers] = True
            tied = np.flatnonzero(np.isin(leader // self.dim, self.grips.followers) & (leader != np.arange(dofs)))
            if tied.size:
                one, other = (numbering.describe(int(dof) // self.dim) for dof in (tied[0], leader[tied[0]]))
                group = next(g for g in self.grips.groups if leader[tied[0]] // self.dim in g.followers)
                raise ModelError(f"{one} is tied to {other}, which is in {group.words}: {group.remedy}")
        for _ in range(dofs):
            following = np.flatnonzero(leader[leader] != leader)
            if not following.size:
                break
            ahead = leader[following]
            drive[following] += drive[ahead]
            held[following] += held[ahead]
            leader[following] = leader[ahead]
            if np.any(leader[following] == following):
                dof = int(following[leader[following] == following][0])
                axis = AXES[dof % self.dim]
                raise ModelError(f"ties go round in a circle at {numbering.describe(dof // self.dim)} along {axis}")
        tied = np.flatnonzero(leader != np.arange(dofs))
        drive[tied] += drive[leader[tied]]
        held[tied] += held[leader[tied]]
        fixed |= fixed[leader]
        unknown = np.full(dofs, -1)
        heads = np.flatnonzero(~fixed & (leader == np.arange(dofs)))
        unknown[heads] = np.arange(heads.size)
        self.unknown: Index = np.where(fixed, -1, unknown[leader])  # unknown of each displacement, -1 where known
        self.heads = heads
        self.leader = leader  # the displacement that each one follows, itself where it is not tied
        self.free = int(heads.size)
        self.drive = drive
        self.held = held
        self._tied: Index = tied
        self.constrained = (owner.reshape(-1, self.dim) >= 0) | numbering.idle
        places = {id(item): position for position, item in enumerate(constraints)}
        self._positions = [places.get(id(item), -2) for item in apart]
        self._moved_apart: list[Index] = [np.flatnonzero(owner[leader] == position) for position in self._positions]
        self.own = np.zeros(len(apart))  # load factors of what has its own

    def _turn(self, item: Any, nodes: Index, middles: Index, drive: Array, position: int) -> None:
        """Drive nodes, and the middles of edges between them, along arcs."""
        from kirigami.model.turn import Arc  # what turns nothing needs no arcs

        if self.dim == 2 and item.axis[:2].any():
            raise ModelError(f"{item!r}: in a model with dim=2 only axis='z' turns nodes in the plane")
        rows = np.concatenate([nodes, np.unique(middles)])
        numbers = rows[:, None] * self.dim + np.arange(self.dim)
        arms = np.zeros((len(rows), 3))
        arms[:, : self.dim] = self.rest[rows]
        arms[: len(nodes)] -= item.about  # middles are offsets from the ends of their edges
        arc = Arc(numbers, arms, item.rotation, position)
        drive[numbers] = arc.start
        drive[numbers[: len(nodes)]] += item.shift[: self.dim]
        self.arcs.append(arc)

    def straighten(self) -> None:
        """Let what turns go on along its rate at rest, as a linear analysis takes it."""
        self.arcs = []

    def known(self, lam: float) -> Array:
        """What constraints say of all displacements (dofs,) at a load factor."""
        u: Array = lam * self.drive + (self.held if self.begun == 1 else self.begun * self.held)
        for at, factor in zip(self._moved_apart, self.own):
            u[at] += (factor - lam) * self.drive[self.leader[at]]
        return self._add_arcs(u, [arc.beyond(self._factor_of(arc, lam)) for arc in self.arcs])

    def known_rate(self, lam: float, rates: Array) -> Array:
        """How fast that (dofs,) changes at rates (1 + k,) of the load factor and of those that objects have of their
        own."""
        change: Array = rates[0] * self.drive
        for at, rate in zip(self._moved_apart, rates[1:]):
            change[at] += (rate - rates[0]) * self.drive[self.leader[at]]
        parts = []
        for arc in self.arcs:
            rate = rates[1 + self._positions.index(arc.position)] if arc.position in self._positions else rates[0]
            parts.append(rate * arc.rate_beyond(self._factor_of(arc, lam)))
        return self._add_arcs(change, parts)

    def _factor_of(self, arc: Any, lam: float) -> float:
        """The load factor that turns an arc."""
        return float(self.own[self._positions.index(arc.position)]) if arc.position in self._positions else lam

    def drive_at(self, lam: float) -> Array:
        """Change of that (dofs,) with the load factor."""
        return self._add_arcs(self.drive.copy(), [arc.rate_beyond(lam) for arc in self.arcs])

    def _add_arcs(self, u: Array, parts: list[Array]) -> Array:
        if parts:
            beyond = np.zeros_like(u)
            for arc, part in zip(self.arcs, parts):
                beyond[arc.numbers] = part
            beyond[self._tied] += beyond[self.leader[self._tied]]
            u += beyond
        return u

    def _hold_followers(
        self, item: Any, numbering: Numbering, position: int, owner: Index, constraints: Sequence[Any]
    ) -> tuple[Index, Array]:
        """Claim what follows a grip or a cell; the numbers of the displacements by which it is held or driven, and
        their values at load factor 1."""
        rows = numbering.grips[id(item)]
        for axis in range(self.dim):
            at = rows.followers * self.dim + axis
            self._check_conflict(at, AXES[axis], item, owner, constraints, numbering)
            owner[at] = position
        known: Index
        known, values = item.known(rows, self.dim)
        owner[known] = position
        return known, values

    @staticmethod
    def _check_conflict(
        at: Index,
        axis: str,
        item: Any,
        owner: Index,
        constraints: Sequence[Any],
        numbering: Numbering,
        shared: NDArray[np.bool_] | bool = False,
    ) -> None:
        """Raise where displacements have an owner already, but for what they may share with it."""
        clash = at[(owner[at] >= 0) & ~np.asarray(shared)]
        if clash.size:
            node = int(clash[0]) // numbering.dim
            raise ModelError(
                f"{item!r} and {constraints[int(owner[clash[0]])]!r} both constrain {axis} of "
                f"{numbering.describe(node)} ({clash.size} such in all): constrain each displacement once"
            )
        values, counts = np.unique(at, return_counts=True)
        if np.any(counts > 1):
            node = int(values[counts > 1][0]) // numbering.dim
            raise ModelError(f"{item!r} lists {numbering.describe(node)} twice")

    def displacement(self, q: Array, lam: float) -> Array:
        """Displacements (n, dim) for unknowns `q` (free,) at load factor `lam`."""
        u = self._linear(q, lam)
        if self.grips is not None:
            self.grips.fill(u)
        return u

    def _linear(self, q: Array, lam: float) -> Array:
        u = self.known(lam)
        moving = self.unknown >= 0
        u[moving] += q[self.unknown[moving]]
        return u.reshape(self.rest.shape)

    def motion(self, q: Array, lam: float = 0.0, about: Array | None = None) -> Array:
        """Displacements (n, dim) for changes `q` (free,) and `lam` of unknowns and load factor, to first order about
        displacements `about` (n, dim), or about the rest state."""
        change: Array = self._linear(q, lam) - self._linear(np.zeros_like(q), 0.0)
        if self.grips is not None:
            self.grips.follow(change, np.zeros_like(change) if about is None else about)
        return change

    def small_displacement(self, q: Array, lam: float) -> Array:
        """Displacements (n, dim) as :meth:`displacement` gives them, to first order about the rest state."""
        u = self._linear(q, lam)
        if self.grips is not None:
            self.grips.follow(u, np.zeros_like(u))
        return u

    def carried(self, total: Array, u: Array) -> Array:
        """A force-like field (n, dim) with what acts on followers of a grip carried to the rows that lead, at `u`."""
        if self.grips is not None:
            total = total.copy()
            self.grips.carry(total, u)
        return total

    def unknowns(self, u: Array) -> Array:
        """Unknowns (free,) of displacements `u` (n, dim or 3)."""
        flat = np.asarray(u, dtype=float)[:, : self.dim].ravel()
        q: Array = flat[self.heads].copy()
        return q

    def constraint_error(self, u: Array, lam: float) -> float:
        """Largest violation [length] of the constraints by displacements `u` (n, dim or 3)."""
        expected = self.displacement(self.unknowns(u), lam)
        points = self.points  # what held edges do between nodes is no more than a guess in a step made by hand
        return float(np.abs(np.asarray(u)[:points, : self.dim] - expected[:points]).max(initial=0.0))

    def start_stage(self, u: Array) -> None:
        """Let a new stage begin at displacements `u`: what the constraints have elsewhere at load factor 0 is brought
        to its place in proportion to the load factor."""
        ahead = (np.asarray(u)[:, : self.dim] - self._linear(self.unknowns(u), 0.0)).ravel()
        if self.grips is not None:
            ahead.reshape(self.rest.shape)[self.grips.followers] = 0.0
        self.held = self.held + ahead
        self.drive = self.drive - ahead

    def reduce(self, full: Array) -> Array:
        """Sum a force-like field (n, dim) onto the unknowns (free,)."""
        moving = self.unknown >= 0
        return np.asarray(np.bincount(self.unknown[moving], full.ravel()[moving], self.free), dtype=float)
