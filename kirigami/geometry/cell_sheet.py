"""The cell of a periodic sheet: cuts that leave it on one side come in on the other, and opposite sides mesh alike."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely import affinity
from shapely.geometry.base import BaseGeometry

from kirigami.errors import GeometryError
from kirigami.geometry.border import repeated_border
from kirigami.geometry.given import checked_line_or_polygon, flattened
from kirigami.geometry.mesh import TriMesh
from kirigami.geometry.sheet import Sheet
from kirigami.primitives.checks import require_array, require_whole
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import SheetMaterial

ROUNDS = 12  # of meshing, in which opposite sides take over each other's nodes
NEAR = 1e-9  # of the cell, within which points are one
FLAT = 1e-3  # area of a cell over that of its sides, below which it is none


class CellSheet(Sheet):
    """The cell of a sheet that repeats along two vectors, with its cuts.

    Parameters
    ----------
    lattice : array_like, shape (2, 2)
        Lattice vectors, one a row [length]: the sides of the cell, a parallelogram.
    cuts : geometry or nested sequences of geometries
        As for :class:`kirigami.Sheet`, drawn wherever they lie: each is repeated by the lattice, and what falls into
        the cell is cut. Give those of one period; a cut longer than the cell runs on into its own copies.
    thickness, material
        As for :class:`kirigami.Sheet`.
    origin : array_like, shape (2,)
        Corner of the cell from which the lattice vectors go. Shift it where a cut would run along a side.

    Attributes
    ----------
    lattice : ndarray, shape (2, 2)
        The lattice vectors.

    Raises
    ------
    GeometryError
        Lattice vectors that span no cell, or a cut along a side of it.

    Examples
    --------
    A slit that crosses the side of the cell becomes two:

    >>> import kirigami as kg
    >>> sheet = kg.CellSheet([(2, 0), (0, 1)], cuts=[[(-0.5, 0.5), (0.5, 0.5)]])
    >>> sheet
    CellSheet(2 x 1, area 2, 2 slits, 0 openings)
    >>> mesh = sheet.mesh(0.2)
    >>> mesh.boundary("left").size == mesh.boundary("right").size
    True
    """

    def __init__(
        self,
        lattice: ArrayLike,
        cuts: Any = (),
        thickness: float | None = None,
        material: SheetMaterial | None = None,
        origin: ArrayLike = (0.0, 0.0),
    ) -> None:
        vectors = require_array(lattice, (2, 2), name="lattice", owner="CellSheet", error=GeometryError)
        self.origin = require_array(origin, (2,), name="origin", owner="CellSheet", error=GeometryError)
        turn = float(np.linalg.det(vectors))
        if not abs(turn) > FLAT * float(np.prod(np.linalg.norm(vectors, axis=1))):
            raise GeometryError(
                f"CellSheet: the lattice vectors {vectors.tolist()} span no cell: give two that do not point along one "
                "line"
            )
        self.lattice: Array = vectors
        self._period = [
            checked_line_or_polygon(cut, f"cut {number}") for number, cut in enumerate(flattened(cuts))
        ]
        outline = shapely.Polygon(_corners(self.origin, vectors, 1, 1))
        inside = self._inside(outline)
        for cut in inside:
            self._check_side(cut, outline)
        super().__init__(outline, inside, thickness, material)

    def repeated(self, nx: int, ny: int) -> Sheet:
        """A finite sheet of `nx` times `ny` cells, which ends where the outer cells do.

        Parameters
        ----------
        nx, ny : int
            Cells along the first and the second lattice vector.
        """
        outline = self._of_many(nx, ny, "repeated")
        return Sheet(outline, self._inside(outline), self.thickness, self.material)

    def supercell(self, nx: int, ny: int) -> CellSheet:
        """The cell of `nx` times `ny` of these, in which a sheet may do what repeats less often.

        Parameters
        ----------
        nx, ny : int
            Cells along the first and the second lattice vector.
        """
        self._of_many(nx, ny, "supercell")
        many = np.array([[nx], [ny]]) * self.lattice
        shifts = [self.lattice.T @ step for step in product(range(nx), range(ny))]
        cuts = [affinity.translate(cut, *shift) for shift in shifts for cut in self._period]
        return CellSheet(many, cuts, self.thickness, self.material, self.origin)

    def _of_many(self, nx: int, ny: int, owner: str) -> shapely.Polygon:
        counts = [
            require_whole(value, name, f"CellSheet.{owner}", 1, GeometryError)
            for value, name in ((nx, "nx"), (ny, "ny"))
        ]
        return shapely.Polygon(_corners(self.origin, self.lattice, *counts))

    def _inside(self, outline: shapely.Polygon) -> list[BaseGeometry]:
        """What of the cuts and their copies falls into an outline."""
        found: list[BaseGeometry] = []
        for cut in self._period:
            for shift in self._shifts(cut, outline):
                part = shapely.intersection(affinity.translate(cut, *shift), outline)
                for piece in shapely.get_parts(part).tolist():
                    if isinstance(piece, type(cut)) or (
                        cut.geom_type == "LinearRing" and piece.geom_type == "LineString"
                    ):
                        small = piece.area if piece.geom_type == "Polygon" else piece.length
                        if small > NEAR * (outline.area if piece.geom_type == "Polygon" else outline.length):
                            found.append(piece)
        return found

    def _shifts(self, cut: BaseGeometry, outline: shapely.Polygon) -> Iterator[Array]:
        """Shifts by lattice vectors that may bring a cut into an outline."""
        inverse = np.linalg.inv(self.lattice)
        here, there = (shapely.get_coordinates(shape) @ inverse for shape in (cut, outline))
        low = np.floor(there.min(axis=0) - here.max(axis=0)).astype(int)
        high = np.ceil(there.max(axis=0) - here.min(axis=0)).astype(int)
        for step in product(range(low[0], high[0] + 1), range(low[1], high[1] + 1)):
            yield np.array(step) @ self.lattice

    def _check_side(self, cut: BaseGeometry, outline: shapely.Polygon) -> None:
        """A cut along a side would have to be on both sides at once."""
        if not isinstance(cut, shapely.LineString):
            return
        along = shapely.intersection(cut, outline.exterior.buffer(1e-7 * math.sqrt(outline.area)))
        if along.length > 1e-3 * math.sqrt(outline.area):
            x, y = along.centroid.coords[0]
            raise GeometryError(
                f"CellSheet: a cut runs along a side of the cell at ({x:.6g}, {y:.6g}): shift the cell with origin=, "
                "so that cuts lie inside it or cross its sides"
            )

    def mesh(
        self,
        max_edge: float | None = None,
        cut_edge: float | None = None,
        min_angle: float = 28.0,
        *,
        nodes: int | None = None,
        size: Callable[[Array], Array] | None = None,
        lines: Mapping[str, BaseGeometry] | Sequence[BaseGeometry] = (),
        snap: float | None = None,
        allow_parts: bool = False,
        mesher: str | None = None,
    ) -> TriMesh:
        """Mesh the cell, with the same nodes on opposite sides.

        Parameters
        ----------
        max_edge, cut_edge, min_angle, nodes, size, lines, snap, allow_parts, mesher
            As for :meth:`kirigami.Sheet.mesh`. The sides are divided until each has the nodes of the other.

        Returns
        -------
        TriMesh

        Raises
        ------
        GeometryError
            As for a sheet; or the sides do not come to agree, which other sizes may mend.
        """
        vectors = np.column_stack([self.lattice, np.zeros(2)])
        sides: list[Array] = [np.empty(0), np.empty(0)]
        for number in range(ROUNDS):
            sheet = Sheet(self._divided(sides), self.cuts, self.thickness, self.material)
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                made = sheet.mesh(
                    max_edge, cut_edge, min_angle, nodes=nodes, size=size, lines=lines, snap=snap,
                    allow_parts=allow_parts, mesher=mesher,
                )  # fmt: skip
            now = [self._on_sides(made, axis) for axis in (0, 1)]
            if all(_same(low, high) for low, high in now):
                for warning in told:  # of the last round alone
                    warnings.warn(warning.message, stacklevel=2)
                repeated_border(made, vectors)  # says where, if it does not
                return made
            # First one side is as the other; then each takes over where the other was divided further.
            sides = [_union(np.concatenate(pair)) if number else pair[0] for pair in now]
        raise GeometryError(
            f"CellSheet.mesh: after {ROUNDS} rounds opposite sides of the cell still do not have the same nodes; give "
            "another max_edge, or shift the cell with origin="
        )

    def _on_sides(self, mesh: TriMesh, axis: int) -> tuple[Array, Array]:
        """Places along lattice vector `axis`, from 0 to 1, of the nodes on the two sides that run along it."""
        part = (mesh.nodes[:, :2] - self.origin) @ np.linalg.inv(self.lattice)
        across = part[:, 1 - axis]
        low, high = (_union(part[np.abs(across - side) < NEAR, axis]) for side in (0.0, 1.0))
        return low, high

    def _divided(self, sides: Sequence[Array]) -> shapely.Polygon:
        """The outline with points along its sides."""
        first, second = (np.concatenate([[0.0], part[(part > NEAR) & (part < 1 - NEAR)]]) for part in sides)
        ring = [(a, 0.0) for a in first] + [(1.0, b) for b in second]
        ring += [(a, 1.0) for a in [1.0, *first[:0:-1]]] + [(0.0, b) for b in [1.0, *second[:0:-1]]]
        return shapely.Polygon(self.origin + np.array(ring) @ self.lattice)


def _corners(origin: Array, lattice: Array, nx: int, ny: int) -> Array:
    ring = np.array([(0, 0), (nx, 0), (nx, ny), (0, ny)])
    return np.asarray(origin + ring @ lattice)


def _union(places: Array) -> Array:
    """Places with those that are the same taken once."""
    ordered = np.sort(places)
    return ordered[np.diff(ordered, prepend=-np.inf) > NEAR]


def _same(one: Array, other: Array) -> bool:
    return len(one) == len(other) and bool(np.abs(one - other).max(initial=0.0) < NEAR)
