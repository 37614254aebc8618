"""Which of the shapes found are the same: equal, mirror images, or the same cells in another place."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kirigami.primitives.kernel import Array
from kirigami.study.shape.space import ShapeSpace
from kirigami.system.system import System

AGREE = 0.01  # relative difference of energies and of forces up to which shapes may be the same: meshes are not even
EQUIVALENT = 0.05  # relative difference of the sorted displacements of two arrangements of the same cells
ROUNDING = 1e-9  # forces and energies below this share of those of a member stretched by its length count as none
QUANTILES = 64
MOST = 32  # arrangements kept of one shape


@dataclass(eq=False)
class Kind:
    """One shape: displacements (n, 3), energy and force of its lowest example, and how often it was reached."""

    u: Array
    energy: float
    force: float
    reached_by: str
    number: int  # in the order in which they were found, from 1
    times: int = 1
    arrangements: list[Array] = field(default_factory=list)


class KnownShapes:
    """The distinct shapes of one structure.

    Two are the same where their energies and forces agree and one lies upon the other, or upon a mirror image of it.
    So are two arrangements of the same cells: where energies and forces agree, and the displacements do once they are
    sorted by size.
    """

    def __init__(self, system: System, mirrors: str, alike: float) -> None:
        self.kinds: list[Kind] = []
        self._space = ShapeSpace(system.model, mirrors)
        self._mirrored, self._alike = bool(mirrors), alike
        self._force = ROUNDING * system.stiffness_scale * system.length
        self._energy = self._force * system.length

    def add(self, u: Array, energy: float, force: float, reached_by: str) -> Kind:
        """Count a shape, known or not; the shape that it is."""
        kind = self.find(u, energy, force)
        if kind is None:
            kind = Kind(u, energy, force, reached_by, len(self.kinds) + 1, 1, [u])
            self.kinds.append(kind)
            return kind
        kind.times += 1
        if len(kind.arrangements) < MOST and not self._lies_upon(kind, u):
            kind.arrangements.append(u)
        if energy < kind.energy:
            kind.u, kind.energy, kind.force = u, energy, force
        return kind

    def find(self, u: Array, energy: float, force: float) -> Kind | None:
        """The known shape that this one is."""
        near = [kind for kind in self.kinds if self._agree(kind, energy, force)]
        for kind in near:
            if self._lies_upon(kind, u):
                return kind
        if self._mirrored:
            for kind in near:
                if self._spread(kind.u, u) < EQUIVALENT:
                    return kind
        return None

    def distance(self, one: Array, other: Array) -> float:
        """Relative distance of two shapes, the least over mirror images."""
        return self._space.distance(one, other)

    def ordered(self) -> list[Kind]:
        """Lowest energy first."""
        return sorted(self.kinds, key=lambda kind: (kind.energy, kind.number))

    def _agree(self, kind: Kind, energy: float, force: float) -> bool:
        apart = abs(kind.energy - energy) <= max(AGREE * max(abs(kind.energy), abs(energy)), self._energy)
        if np.isnan(force) or np.isnan(kind.force):
            return apart
        size = max(abs(kind.force), abs(force))
        return apart and abs(kind.force - force) <= max(AGREE * size, self._force)

    def _lies_upon(self, kind: Kind, u: Array) -> bool:
        return any(self._space.distance(known, u) < self._alike for known in kind.arrangements)

    def _spread(self, one: Array, other: Array) -> float:
        """Relative difference of the displacements, each component sorted by itself; of a flat sheet their heights."""
        a, b = (self._sorted(self._space.sizes(u)) for u in (one, other))
        size = max(float(np.linalg.norm(a)), float(np.linalg.norm(b)))
        return float(np.linalg.norm(a - b)) / size if size > 0 else 0.0

    def _sorted(self, values: Array) -> Array:
        """Quantiles (k, components) by area."""
        shares = (np.arange(QUANTILES) + 0.5) / QUANTILES
        found = []
        for column in values.T:
            order = np.argsort(column, kind="stable")
            reached = np.cumsum(self._space.weight[order])
            found.append(np.interp(shares, reached / reached[-1], column[order]))
        return np.column_stack(found)
