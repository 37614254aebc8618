"""What a drawing needed to become a mesh: cuts that are useless or not what was drawn, told with their numbers."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from kirigami.errors import GeometryError, KirigamiWarning

OUTLINE = 0  # owner of the edges of the outline; cut i owns with i + 1, and lines follow after the cuts


class Repairs:
    """Finds cuts that are useless or not what was drawn, from the number of sheet sides of their edges."""

    def __init__(
        self,
        outline: shapely.Polygon,
        cuts: Sequence[BaseGeometry],
        owners_of: list[tuple[int, ...]],
        sides: NDArray[np.int64],
        size: float,
        snap: float,
    ) -> None:
        self.filled = shapely.Polygon(outline.exterior)
        self.cuts, self.owners_of, self.sides, self.size, self.snap = cuts, owners_of, sides, size, snap
        self.edges_of: list[list[int]] = [[] for _ in cuts]
        for edge, owners in enumerate(owners_of):
            for owner in owners:
                if OUTLINE < owner <= len(cuts):
                    self.edges_of[owner - 1].append(edge)

    def check(self) -> None:
        short, beyond, inert, thin, along = [], [], [], [], []
        for number, cut in enumerate(self.cuts):
            edges = self.edges_of[number]
            sides = self.sides[edges]
            if not edges:
                short.append(number)
            elif isinstance(cut, shapely.Polygon):
                if (sides == 2).all():
                    thin.append(number)
                elif not any(self.sides[edge] == 1 and OUTLINE not in self.owners_of[edge] for edge in edges):
                    self._refuse_if_outside(number, edges)
                    inert.append(number)
            elif not (sides == 2).any():
                if any(self.sides[edge] == 1 and OUTLINE in self.owners_of[edge] for edge in edges):
                    along.append(number)
                    continue
                self._refuse_if_outside(number, edges)
                inert.append(number)
            elif (sides < 2).any():
                beyond.append(number)
        snap = f"{self.snap * self.size:.3g}"
        self._warn(short, f"smaller than the snapping distance {snap} and left out")
        self._warn(thin, f"narrower than the snapping distance {snap} and taken as a slit")
        self._warn(inert, "inside a hole or along the edge of one, and without effect")
        self._warn(along, "drawn along the outline, and without effect")
        self._warn(beyond, "drawn beyond the edge of the sheet or of a hole; what lies beyond is left out")
        self._warn(self._touching_holes(), "holes that touch or overlap, and merged")
        self._warn(self._repeated(), "drawn on top of each other, in part or whole, and merged")

    def _refuse_if_outside(self, number: int, edges: list[int]) -> None:
        cut = self.cuts[number]
        place = cut.representative_point()
        where = f"cut {number} near ({place.x:.6g}, {place.y:.6g})"
        if any(self.sides[edge] == 1 and OUTLINE in self.owners_of[edge] for edge in edges):
            raise GeometryError(f"{where} runs along the outline and cuts nothing; remove it or move it into the sheet")
        if not self.filled.covers(place):
            x0, y0, x1, y1 = self.filled.bounds
            raise GeometryError(
                f"{where} lies outside the sheet, which spans x {x0:.6g} to {x1:.6g} and y {y0:.6g} to {y1:.6g}; "
                "remove it or check its units"
            )

    def _touching_holes(self) -> list[int]:
        holes = [number for number, cut in enumerate(self.cuts) if isinstance(cut, shapely.Polygon)]
        if len(holes) < 2:
            return []
        geometry = np.array([self.cuts[number] for number in holes], dtype=object)
        reach = 0.5 * self.snap * self.size
        pairs = shapely.STRtree(geometry).query(geometry, "dwithin", distance=reach).T
        return sorted({holes[one] for one, other in pairs.tolist() if one != other})

    def _repeated(self) -> list[int]:
        repeated: set[int] = set()
        for edge in np.flatnonzero(self.sides == 2):
            cuts = [owner - 1 for owner in self.owners_of[edge] if OUTLINE < owner <= len(self.cuts)]
            if len(cuts) > 1:
                repeated.update(cuts)
        return sorted(repeated)

    def _warn(self, numbers: list[int], what: str) -> None:
        if numbers:
            verb = "is" if len(numbers) == 1 else "are"
            message = f"{names_of(numbers)} {verb} {what}; the first lies at {self._place(numbers[0])}"
            warnings.warn(message, KirigamiWarning, stacklevel=5)

    def _place(self, number: int) -> str:
        x, y = shapely.get_coordinates(self.cuts[number])[0]
        return f"({x:.6g}, {y:.6g})"


def names_of(numbers: Sequence[int]) -> str:
    """A short list of cuts for a message."""
    if not numbers:
        return "no cut"
    shown = ", ".join(str(number) for number in numbers[:8])
    return f"cut{'s' if len(numbers) > 1 else ''} {shown}" + (
        f" and {len(numbers) - 8} more" if len(numbers) > 8 else ""
    )
