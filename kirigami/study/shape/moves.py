"""Moves that a cut sheet makes from one stable shape to another, as starts for a descent.

A lip of a cut pops through; a row between cuts tilts the other way; one part of the sheet takes the shape it has in
another equilibrium, or in a mirror image of one. The same on a structure without a mesh: nodes and patches of nodes pop
through what holds them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from kirigami.model.model import Model
from kirigami.primitives.kernel import Array
from kirigami.study.imperfections import seeds
from kirigami.study.shape.space import Reflections, is_flat_sheet
from kirigami.system.system import System

Integers = NDArray[np.int64]

SHARES = (0.05, 0.2, 1.0)  # of the load factor at which a flat sheet is changed
REACH = (0.25, 0.9)  # radius of a patch that pops, over the length of its lip
MODES = 6  # that trials start from
DRAWS = 10  # most draws for a move that was not tried before
THIN = 0.1  # extent of a rim over its largest one below which it does not count as a direction


@dataclass(frozen=True, eq=False)
class Trial:
    """Where a descent starts: displacements (n, 3) at a share of the load factor, and how they came about.

    In the words a shape is "#" and its number in the order in which shapes are found.
    """

    u: Array
    share: float
    told: str


@dataclass(frozen=True)
class Lip:
    """One side of a cut: number of the cut and of the side, from 1, the node in the middle, and the length."""

    cut: int
    side: int
    middle: int
    length: float


class Moves:
    """The moves of one structure.

    Attributes
    ----------
    lips : list of Lip
        Free lips of cuts; none on a sheet without cuts and on a structure without a mesh.
    """

    def __init__(self, model: Model, system: System) -> None:
        from scipy.sparse import coo_matrix

        self.model, self.rest = model, model.positions()
        low, high, distance = system.plan.links(system.rest, system.points)
        n = len(self.rest)
        self._graph = coo_matrix((distance, (low, high)), shape=(n, n)).tocsr()
        self.size = float(np.linalg.norm(np.ptp(self.rest, axis=0)))
        self.dim = model.dim
        self.flat = is_flat_sheet(model)
        self.free = np.flatnonzero((system.unknown.reshape(system.rest.shape)[:n] >= 0).any(axis=1))
        self.lips = [] if model.mesh is None else _lips(model)
        drive = np.zeros((n, 3))
        drive[:, : model.dim] = system.drive.reshape(system.rest.shape)[:n]
        self._along = _direction(self.rest, drive)
        self._images = Reflections(model, "xy", self.rest)
        self._held = (system.unknown < 0).reshape(system.rest.shape)[:n]
        self._rows = self._row_bounds(model)

    @cached_property
    def modes(self) -> list[Array]:
        """The lowest modes (n, 3) that are no rigid motions, or a ModelError."""
        most = max(1, min(MODES, len(self.free) * self.dim // 2))
        return seeds(self.model, most)

    # ---- choosing

    def trial(
        self, random: Generator, parents: Sequence[Array], names: Sequence[int], tried: Collection[str] = ()
    ) -> Trial:
        """A random move from one of the shapes (n, 3) found so far, the first ones more often than the last.

        What was tried already, by its words, is drawn again a few times.
        """
        for _ in range(DRAWS):
            drawn = self._draw(random, parents, names)
            if drawn.told not in tried:
                break
        return drawn

    def _draw(self, random: Generator, parents: Sequence[Array], names: Sequence[int]) -> Trial:
        weight = 0.65 ** np.arange(len(parents))
        chosen = int(random.choice(len(parents), p=weight / weight.sum()))
        moves: list[Callable[[Generator, Array], tuple[Array, str]]] = [self.pop]
        if self.flat:
            other = int(random.choice(len(parents), p=weight / weight.sum()))
            moves += [self.tilt, lambda r, u: self.cross(r, u, parents[other], names[other])]
            moves += moves[1:]  # a row or a part more often than one lip
        else:
            moves += [self.pop, self.pop]
        moves.append(self.shake)
        moved, told = moves[int(random.integers(len(moves)))](random, parents[chosen])
        share = float(random.choice(SHARES)) if self.flat else 1.0
        return Trial(self.lowered(moved, share), share, f"shape #{names[chosen]}, {told}")

    def lowered(self, u: Array, share: float) -> Array:
        """About the displacements at a share of the load: those in the plane in proportion, heights with its root."""
        factor = np.array([share, share, np.sqrt(share)]) if self.flat else np.ones(3)
        return u * factor

    # ---- moves

    def pop(self, random: Generator, u: Array) -> tuple[Array, str]:
        """A patch goes through the plane of its rim: about the middle of a lip, or about any free node."""
        if self.lips:
            lip = self.lips[int(random.integers(len(self.lips)))]
            centre, reach = lip.middle, lip.length * float(random.uniform(*REACH))
            told = f"lip {lip.side} of cut {lip.cut} popped through"
        else:
            centre = int(self.free[random.integers(len(self.free))])
            near = np.concatenate([self._graph[centre].data, self._graph[:, [centre]].data])
            reach, told = 0.5 * float(near.min()), f"node {centre} popped through"
            if random.random() < 0.3:
                reach = max(2 * reach, float(random.uniform(0.05, 0.5)) * self.size)
                told = f"all within {reach:.3g} of {told}"
        distance = self._distance(centre)
        weight = np.where(distance < reach, 0.5 * (1 + np.cos(np.pi * np.minimum(distance / reach, 1.0))), 0.0)
        place = self.rest + u
        rim = np.flatnonzero((distance >= reach) & np.isfinite(distance))
        if not rim.size:
            return -u, "turned over"
        rim = rim[np.argsort(distance[rim], kind="stable")][: max(2, int((distance[rim] < 1.5 * reach).sum()))]
        through = place - _projected(place, place[rim])
        return u - 2 * weight[:, None] * through, told

    def tilt(self, random: Generator, u: Array) -> tuple[Array, str]:
        """A band across the pull goes to the other side of the plane of the sheet."""
        first, last = sorted(random.choice(len(self._rows), 2, replace=False).tolist())
        low, high = self._rows[first], self._rows[last]
        along = self.rest @ self._along
        width = 0.25 * float(np.diff(self._rows).min())
        inside = _step((along - low) / width) * _step((high - along) / width)
        moved = u.copy()
        moved[:, 2] *= 1 - 2 * inside
        return moved, f"tilted the other way from {low:.4g} to {high:.4g}"

    def cross(self, random: Generator, u: Array, other: Array, name: int) -> tuple[Array, str]:
        """One part of the sheet takes the shape it has in another equilibrium, or in an image of it."""
        taken = self._images.maps[int(random.integers(len(self._images.maps)))](other)
        for axis in range(2):  # an image of what moves one end moves the other
            held = self._held[:, axis]
            taken[:, axis] += float((other - taken)[held, axis].mean()) if held.any() else 0.0
        taken[:, 2] *= float(random.choice((1.0, -1.0)))
        direction = self._along if random.random() < 0.7 else np.cross(self._along, [0.0, 0.0, 1.0])
        along = self.rest @ direction
        border = float(random.uniform(*np.quantile(along, (0.1, 0.9))))
        width = 0.05 * float(np.ptp(along))
        share = _step((along - border) / width)[:, None]
        return (1 - share) * u + share * taken, f"beyond a line that of shape #{name}"

    def shake(self, random: Generator, u: Array) -> tuple[Array, str]:
        """All nodes are moved by a random smooth field."""
        places = self.rest / self.size
        directions = [2] if self.flat else range(self.dim)
        moved = u.copy()
        scale = max(float(np.abs(u).max()), 0.02 * self.size) * float(random.uniform(0.1, 0.6))
        for axis in directions:
            waves = random.normal(size=(24, 3)) * random.uniform(2.0, 30.0, size=(24, 1))
            heights = random.normal(size=24) / (1 + np.linalg.norm(waves, axis=1))
            field = np.cos(places @ waves.T + random.uniform(0, 2 * np.pi, size=24)) @ heights
            moved[:, axis] += scale * field / np.abs(field).max()
        return moved, "shaken"

    # ---- places

    def _distance(self, centre: int) -> Array:
        """Distance (n,) from a node along the sheet, which cuts make longer [length]."""
        from scipy.sparse.csgraph import dijkstra

        found: Array = dijkstra(self._graph, directed=False, indices=centre)
        return found

    def _row_bounds(self, model: Model) -> Array:
        """Places along the pull that bound the rows between cuts, ends included; tenths of a sheet without rows."""
        along = self.rest @ self._along
        low, high = float(along.min()), float(along.max())
        cuts = [] if model.mesh is None else [float(along[cut.loop].mean()) for cut in model.mesh.cuts]
        bounds = [low]
        for place in [*sorted(cuts), high]:
            if place - bounds[-1] > 0.02 * (high - low):
                bounds.append(place)
        return np.array(bounds) if len(bounds) > 2 else np.linspace(low, high, 11)


def _lips(model: Model) -> list[Lip]:
    """Both sides of every cut of the mesh of a model that is longer than two edges."""
    assert model.mesh is not None
    found = []
    for number, cut in enumerate(model.mesh.cuts, start=1):
        place = model.mesh.nodes[cut.loop][:, :2]
        gaps = np.linalg.norm(place - place[0], axis=1)
        if cut.open:
            sides = np.split(np.arange(len(place)), [int(gaps.argmax())])
        else:  # from the point that is farthest from the first one to that which is farthest from it
            far = int(gaps.argmax())
            other = int(np.linalg.norm(place - place[far], axis=1).argmax())
            order = np.roll(np.arange(len(place)), -far)
            sides = np.split(order, [int(np.flatnonzero(order == other)[0])])
        for which, side in enumerate(sides, start=1):
            if len(side) > 2:
                length = float(np.linalg.norm(np.diff(place[side], axis=0), axis=1).sum())
                found.append(Lip(number, which, int(cut.loop[side[len(side) // 2]]), length))
    return found


def _direction(rest: Array, drive: Array) -> Array:
    """Unit vector in the plane along the pull; along the sheet where nothing in its plane is driven."""
    mean = drive.mean(axis=0) * [1.0, 1.0, 0.0]
    if np.linalg.norm(mean) > 1e-6 * np.linalg.norm(drive, axis=1).max(initial=0.0) > 0:
        return np.asarray(mean / np.linalg.norm(mean))
    return np.asarray(np.eye(3)[int(np.argmax(np.ptp(rest, axis=0)[:2]))])


def _projected(place: Array, rim: Array) -> Array:
    """Feet (n, 3) of the points on the plane, the line or the point that fits the points of a rim best."""
    centre = rim.mean(axis=0)
    _, sizes, axes = np.linalg.svd(rim - centre, full_matrices=False)
    basis = axes[:2][sizes[:2] > THIN * max(float(sizes[0]), 1e-300)]
    feet: Array = centre + (place - centre) @ basis.T @ basis
    return feet


def _step(values: Array) -> Array:
    """0 below -1/2, 1 above 1/2, and a smooth rise between."""
    t = np.clip(values + 0.5, 0.0, 1.0)
    rise: Array = t * t * (3 - 2 * t)
    return rise
