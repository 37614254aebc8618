"""One panel and one ligament: bars that make a polygon rigid, and the angle stiffness of a flexible strip."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from kirigami.primitives.checks import require_positive
from kirigami.primitives.kernel import Array


@dataclass(frozen=True)
class Ligament:
    """A short flexible strip that joins two panels: an angle spring of stiffness E t b^3 / (12 l).

    That is the end moment over the turn of a beam bent in the plane of the sheet; the panels are taken as rigid, so
    a ligament that is not slender turns easier than this.

    Parameters
    ----------
    E : float
        Young's modulus [force / length^2].
    thickness : float
        Sheet thickness t [length].
    width : float
        Width b in the plane [length].
    length : float
        Free length l [length].

    Raises
    ------
    ModelError
        A value is not positive and finite.

    Examples
    --------
    >>> from kirigami.lattice.tilings import Ligament
    >>> round(Ligament(E=3.5e9, thickness=1e-3, width=0.6e-3, length=1.5e-3).stiffness, 9)
    0.042
    """

    E: float
    thickness: float
    width: float
    length: float

    def __post_init__(self) -> None:
        for name in ("E", "thickness", "width", "length"):
            object.__setattr__(self, name, require_positive(getattr(self, name), name, "Ligament"))

    @property
    def stiffness(self) -> float:
        """Moment per turn [force length / rad]."""
        return self.E * self.thickness * self.width**3 / (12 * self.length)


def braces(shape: Array, crossed: bool) -> list[tuple[int, int]]:
    """Pairs of corners whose bars make one panel rigid."""
    n = len(shape)
    pairs = {(i, (i + 1) % n) for i in range(n)}
    pairs |= {(i, (i + 2) % n) for i in range(n)} if crossed else {(0, i) for i in range(2, n - 1)}
    pairs = {(min(pair), max(pair)) for pair in pairs}
    if _rank(shape, pairs) < 2 * n - 3:  # three corners in line leave a bend: start again from all pairs
        pairs = {(i, j) for i in range(n) for j in range(i + 1, n)}
        if not crossed:
            chosen: set[tuple[int, int]] = set()
            for pair in sorted(pairs, key=lambda p: min(p[1] - p[0], n - p[1] + p[0])):
                if _rank(shape, chosen | {pair}) > len(chosen):
                    chosen.add(pair)
            pairs = chosen
    return sorted(pairs)


def _rank(shape: Array, pairs: Collection[tuple[int, int]]) -> int:
    rows = np.zeros((len(pairs), *shape.shape))
    for row, (i, j) in zip(rows, pairs):
        row[j] = shape[j] - shape[i]
        row[i] = -row[j]
    return int(np.linalg.matrix_rank(rows.reshape(len(rows), -1), tol=1e-6 * float(np.ptp(shape, axis=0).max())))
