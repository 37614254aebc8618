"""The wall between drawings and the mesh generator: checks, repairs, and errors that say where and why.

A drawing passes as a planar graph whose edges meet only in end points and separate sheet from void or are slits; the
mesh generator can do nothing wrong with it. Everything happens in a unit frame, in which the sheet is about one in
size, so that metres and millimetres give the same mesh.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from kirigami.errors import GeometryError, KirigamiWarning
from kirigami.geometry.noding import node_lines
from kirigami.geometry.repairs import OUTLINE, Repairs, names_of
from kirigami.geometry.topology import pair_numbers, paired_half_edges, regions, signed_areas
from kirigami.geometry.triangulate import Triangulation, chosen_mesher, triangulate
from kirigami.words import counted

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

SCRAP = 0.1  # of the largest part; a part as small as this falls out, larger ones are pieces that somebody may want
FARTHEST = 1e6  # sizes of the sheet; a cut beyond is surely drawn in another unit


@dataclass(frozen=True)
class Frame:
    """Maps the drawing to the unit frame and back."""

    origin: Floats
    size: float

    def to_unit(self, coordinates: Floats) -> Floats:
        return (coordinates - self.origin) / self.size

    def from_unit(self, coordinates: Floats) -> Floats:
        return self.origin + self.size * coordinates

    def place(self, point: Floats) -> str:
        x, y = self.from_unit(point)
        return f"({x:.6g}, {y:.6g})"


@dataclass(frozen=True, eq=False)
class LineWork:
    """A clean planar graph in the unit frame.

    Attributes
    ----------
    points : ndarray, shape (p, 2)
    edges : ndarray of int, shape (s, 2)
        Edges that bound the sheet, with the sheet at their left; slits and embedded lines.
    is_boundary : ndarray of bool, shape (s,)
        Which edges bound the sheet.
    labels : ndarray of int, shape (s,)
        Index of each edge into ``owners``.
    owners : list of tuple of int
        What was drawn along an edge: 0 for the outline, i + 1 for cut i, then the embedded lines.
    cut_count : int
        Number of drawn cuts.
    area : float
        Area of the sheet without its holes.
    frame : Frame
    mesher : str
        The mesh generator that it was cleaned by and is to be meshed by.
    """

    points: Floats
    edges: Integers
    is_boundary: NDArray[np.bool_]
    labels: Integers
    owners: list[tuple[int, ...]]
    cut_count: int
    area: float
    frame: Frame
    mesher: str

    def cuts_of(self, label: int) -> tuple[int, ...]:
        """Numbers of the cuts drawn along edges with this label."""
        return tuple(owner - 1 for owner in self.owners[label] if OUTLINE < owner <= self.cut_count)

    @property
    def label_is_cut(self) -> NDArray[np.bool_]:
        return np.array([bool(self.cuts_of(label)) for label in range(len(self.owners))])

    @property
    def label_separates(self) -> NDArray[np.bool_]:
        """Whether the sheet comes apart along edges with this label; along mere lines it does not."""
        return np.array([min(owners) <= self.cut_count for owners in self.owners])


def clean(
    outline: shapely.Polygon,
    cuts: Sequence[BaseGeometry] = (),
    lines: Sequence[BaseGeometry] = (),
    snap: float = 1e-5,
    spacing: float = 0.0,
    allow_parts: bool = False,
    mesher: str | None = None,
) -> LineWork:
    """Turn an outline, its cuts and embedded lines into a clean planar graph.

    Parameters
    ----------
    outline : shapely.Polygon
        The sheet before it is cut, valid; interior rings are holes.
    cuts : sequence of LineString, LinearRing or Polygon
        Slits and holes, finite and valid.
    lines : sequence of LineString
        Lines that become mesh edges without being cut.
    snap : float
        Points closer than this times the size of the sheet become one, and a point closer than half of it to an edge is
        moved onto it.
    spacing : float
        A curve whose points are closer than this times the size of the sheet, more than half of them, is thinned as far
        as it moves by no more than ``snap``.
    allow_parts : bool
        Keep all parts into which cuts sever the sheet. Else small ones, up to a tenth of the largest, fall out.
    mesher : str, optional
        As :meth:`kirigami.Sheet.mesh` takes it.

    Raises
    ------
    GeometryError
        If a cut lies outside the sheet, if cuts sever the sheet, or if nothing of it is left.

    Warns
    -----
    KirigamiWarning
        About every repair that changes what was drawn.

    Examples
    --------
    >>> import shapely
    >>> from kirigami.geometry.clean import clean
    >>> drawing = clean(shapely.box(0, 0, 4, 2), [shapely.LineString([(1, 1), (3, 1)])])
    >>> len(drawing.edges), drawing.area
    (5, 0.5)
    """
    low, high = np.array(outline.bounds).reshape(2, 2)
    frame = Frame(low, float((high - low).max()))
    points, edges = node_lines(*_line_work([outline, *cuts, *lines], len(cuts), frame, snap, spacing), snap)
    if shapely.MultiPoint(points).convex_hull.area <= snap**2:
        raise GeometryError(f"the outline is narrower than the snapping distance, {snap * frame.size:.3g}")
    pairs, index = np.unique(np.sort(edges[:, :2], axis=1), axis=0, return_inverse=True)
    owners_of = _owners(index.ravel(), edges[:, 2], len(pairs))

    mesher = chosen_mesher(mesher)
    hull = _Hull(points, pairs, mesher)
    inside = _is_sheet(hull, edges, index.ravel())
    if not inside.any():
        raise GeometryError("nothing of the sheet is left: the holes cover it")
    sides = hull.sides(inside)
    Repairs(outline, cuts, owners_of, sides, frame.size, snap).check()
    if not allow_parts:
        inside = _largest_part(hull, inside, owners_of, len(cuts), frame)
        sides = hull.sides(inside)

    kept = np.flatnonzero(sides > 0)
    used, edge_points = np.unique(hull.directed(inside)[kept], return_inverse=True)
    owners = sorted({owners_of[edge] for edge in kept})
    label_of = {label: number for number, label in enumerate(owners)}
    return LineWork(
        points=points[used],
        edges=edge_points.reshape(-1, 2).astype(np.int64),
        is_boundary=sides[kept] == 1,
        labels=np.array([label_of[owners_of[edge]] for edge in kept], np.int64),
        owners=owners,
        cut_count=len(cuts),
        area=float(hull.areas[inside].sum()),
        frame=frame,
        mesher=mesher,
    )


def _line_work(
    drawn: Sequence[BaseGeometry], cut_count: int, frame: Frame, snap: float, spacing: float
) -> tuple[Floats, Integers]:
    """Points and edges of everything drawn, in the unit frame; an edge is start, end, owner and turn.

    The turn is 1 on a ring whose inside lies at the left, -1 where it lies at the right, and 0 on lines.
    """
    all_points: list[Floats] = []
    all_edges: list[Integers] = []
    count = 0
    for owner, geometry in enumerate(drawn):
        is_area = isinstance(geometry, shapely.Polygon)
        rings = [geometry.exterior, *geometry.interiors] if isinstance(geometry, shapely.Polygon) else [geometry]
        for number, ring in enumerate(rings):
            points = frame.to_unit(shapely.get_coordinates(ring))
            farthest = np.abs(points).max()
            if farthest > FARTHEST:
                what = f"cut {owner - 1}" if owner <= cut_count else f"line {owner - 1 - cut_count}"
                raise GeometryError(f"{what} lies {farthest:.1e} sizes of the sheet away: is it in another unit?")
            if np.median(np.hypot(*np.diff(points, axis=0).T)) < spacing:
                points = shapely.get_coordinates(shapely.simplify(shapely.LineString(points), snap))
            turn = (1 if shapely.is_ccw(ring) == (number == 0) else -1) if is_area else 0
            start = count + np.arange(len(points) - 1)
            owned, turned = np.full(len(start), owner), np.full(len(start), turn)
            all_points.append(points)
            all_edges.append(np.column_stack([start, start + 1, owned, turned]))
            count += len(points)
    return np.concatenate(all_points), np.concatenate(all_edges).astype(np.int64)


def _owners(edge: Integers, owner: Integers, count: int) -> list[tuple[int, ...]]:
    owners: list[list[int]] = [[] for _ in range(count)]
    for number, who in sorted(zip(edge.tolist(), owner.tolist(), strict=True)):
        if not owners[number] or owners[number][-1] != who:
            owners[number].append(who)
    return [tuple(group) for group in owners]


def _is_sheet(hull: _Hull, edges: Integers, pair: Integers) -> NDArray[np.bool_]:
    """Which triangles are sheet: those round which the noded outline winds and no noded hole does.

    Snapping moves points and splits edges, but a ring stays a ring: how often it winds round a region changes across
    its own edges only. So no region is classed by where its points happen to lie, and none is lost to rounding.
    """
    region = regions(hull.triangles, hull.pairs)
    outside = int(region.max()) + 1
    left, right = np.where(hull.facets < 0, outside, region[hull.facets]).T
    along = np.where(edges[:, 0] == hull.directed_pairs[pair, 0], 1, -1) * edges[:, 3]
    windings = []
    for is_own in (edges[:, 2] == OUTLINE, edges[:, 2] > OUTLINE):
        jump = np.zeros(len(hull.pairs), np.int64)
        np.add.at(jump, pair, along * is_own)
        windings.append(_potential(outside, left, right, jump, region[hull.rim]))
    is_sheet: NDArray[np.bool_] = ((windings[0] > 0) & (windings[1] <= 0))[region]
    return is_sheet


def _potential(outside: int, left: Integers, right: Integers, jump: Integers, free: Integers) -> Integers:
    """Value of each region, where the region at the left of an edge has `jump` more than that at its right.

    Outside, and in the regions `free` that are linked to it without an edge, it is zero.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order

    ends = np.concatenate([left, free]), np.concatenate([right, np.full(len(free), outside)])
    graph = coo_array((np.ones(len(ends[0])), ends), shape=(outside + 1, outside + 1))
    order, before = breadth_first_order(graph.tocsr(), outside, directed=False)
    step = {(a, b): value for a, b, value in zip(left.tolist(), right.tolist(), jump.tolist())}
    step |= dict.fromkeys(zip(free.tolist(), [outside] * len(free)), 0)
    value = np.zeros(outside + 1, np.int64)
    for region in order[1:].tolist():
        parent = int(before[region])
        value[region] = value[parent] + (
            step[region, parent] if (region, parent) in step else -step[parent, region]
        )
    return value


class _Hull:
    """The triangulated convex hull of the line work, and what lies at the two sides of each drawn edge."""

    def __init__(self, points: Floats, pairs: Integers, mesher: str) -> None:
        none = np.empty((0, 3), np.int64)
        made = triangulate(Triangulation(points, none, pairs, np.zeros(len(pairs), np.int64)), mesher)
        self.points, self.triangles, self.pairs = made.points, made.triangles, pairs
        self.corners = self.points[self.triangles]
        self.areas = np.abs(signed_areas(self.points, self.triangles))
        first, second = paired_half_edges(self.triangles)
        start, end = self.triangles.ravel()[first], self.triangles[:, [1, 2, 0]].ravel()[first]
        edge = pair_numbers(pairs, np.column_stack([start, end]), len(self.points))
        if len(self.points) != len(points) or (edge < 0).any():
            raise GeometryError("the mesh generator lost an edge of the drawing; try a larger `snap`")
        self.directed_pairs = np.column_stack([start[edge], end[edge]])  # the first facet at the left
        self.facets = np.column_stack([first // 3, np.where(second < 0, -1, second // 3)])[edge]
        self.rim = first[(second < 0) & ~np.isin(np.arange(len(first)), edge)] // 3  # at undrawn edges of the hull

    def _inside_at(self, inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
        both: NDArray[np.bool_] = inside[self.facets] & (self.facets >= 0)
        return both

    def sides(self, inside: NDArray[np.bool_]) -> Integers:
        """Number of sides of each drawn edge that are sheet."""
        count: Integers = self._inside_at(inside).sum(axis=1)
        return count

    def directed(self, inside: NDArray[np.bool_]) -> Integers:
        """The drawn edges, those with sheet at one side turned to have it at the left."""
        left, right = self._inside_at(inside).T
        return np.where((right & ~left)[:, None], self.directed_pairs[:, ::-1], self.directed_pairs)


def _largest_part(
    hull: _Hull, inside: NDArray[np.bool_], owners_of: list[tuple[int, ...]], cut_count: int, frame: Frame
) -> NDArray[np.bool_]:
    """The triangles of the largest part; scrap falls out with a word, other parts are refused."""
    separates = np.array([min(owners) <= cut_count for owners in owners_of])
    part = regions(hull.triangles, hull.pairs[separates], among=inside)
    names, area = np.unique(part[inside]), np.bincount(part, weights=hull.areas * inside)
    if len(names) == 1:
        return inside
    names = names[np.argsort(-area[names], kind="stable")]

    def described(name: int) -> str:
        members = part == name
        corners = frame.from_unit(hull.corners[members].reshape(-1, 2))
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        touching = hull.sides(members) > 0
        cuts = sorted({o - 1 for e in np.flatnonzero(touching) for o in owners_of[e] if OUTLINE < o <= cut_count})
        return (
            f"x {x0:.6g} to {x1:.6g}, y {y0:.6g} to {y1:.6g}, area {area[name] * frame.size**2:.4g}, "
            f"along {names_of(cuts)}"
        )

    if (area[names[1:]] > SCRAP * area[names[0]]).any():
        described_parts = [f"part {number}: {described(name)}" for number, name in enumerate(names[:6], start=1)]
        described_parts += [] if len(names) <= 6 else [f"and {counted(len(names) - 6, 'smaller one')}"]
        raise GeometryError(
            f"the cuts sever the sheet into {counted(len(names), 'part')}:\n  " + "\n  ".join(described_parts) + "\n"
            "Shorten a cut, draw a piece that is to fall out as a closed curve (a Polygon), or use `allow_parts=True`."
        )
    fallen = counted(len(names) - 1, "piece falls", "pieces fall")
    pieces = "; ".join(described(name) for name in names[1:4]) + ("; ..." if len(names) > 4 else "")
    warnings.warn(f"{fallen} out: {pieces}", KirigamiWarning, stacklevel=4)
    kept: NDArray[np.bool_] = part == names[0]
    return kept
