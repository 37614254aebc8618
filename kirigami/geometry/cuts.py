"""Cut patterns: each generator returns shapely geometry, ready for `kirigami.Sheet`.

Lines are slits without width; with an ``opening`` every slit becomes a polygon of that width. The patterns fill a
rectangle of ``width`` by ``height`` that starts at ``(0, margin)``, so that the sheet with its grip strips is
``shapely.box(0, 0, width, height + 2 * margin)``. Slits that reach the sides are cut off exactly there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from kirigami.deferred import deferred
from kirigami.errors import GeometryError
from kirigami.primitives.checks import (
    require_array,
    require_boolean,
    require_finite,
    require_not_negative,
    require_positive,
    require_whole,
    shown,
)
from kirigami.words import counted

Floats = NDArray[np.float64]

MOST = 100_000  # cuts along one direction of a pattern; more is a slip

graded_slits = deferred("kirigami.geometry.graded:graded_slits", static=True)


def curved_cells(
    cells_across: int = 2,
    cells_along: int = 5,
    width: float = 2.0,
    height: float = 2.0,
    *,
    length_ratio: float = 2.0,
    depth_ratio: float = 1.0,
    margin: float = 0.2,
    opening: float = 0.0,
    points: int = 13,
) -> list[BaseGeometry]:
    """Rows of sine arcs, bent up and down in turn and shifted by half a cell; stretched along y, the cells open.

    With the cell width ``P = width / cells_across``, an arc spans ``length = P length_ratio / (1 + length_ratio)`` and
    leaves the gap ``length / length_ratio`` to the next of its row. With the rise ``depth = depth_ratio * spacing`` of
    an arc, the rows are ``depth + spacing`` apart and fill the height:
    ``height = cells_along (depth + spacing) + depth``. Arcs bent up stand at the centres of the cells, arcs bent down
    between them, with half arcs at the sides (Khawale et al., "Rapid kirigami simulation using the bar and hinge
    approach").

    Parameters
    ----------
    cells_across, cells_along : int
        Number of cells along x and y.
    width, height : float
        Size of the pattern.
    length_ratio : float
        Length of an arc over the gap to its neighbour in the row; for 1 the arcs of a row would meet.
    depth_ratio : float
        Rise of an arc over the distance from its top to the base of the row above.
    margin : float
        Height of the uncut strips below and above the pattern.
    opening : float
        Width of the cuts along y; 0 for slits.
    points : int
        Points of an arc, odd.

    Returns
    -------
    list of LineString or Polygon
        From the bottom row to the top row, each from left to right.

    Raises
    ------
    GeometryError
        If a parameter has no meaning, or the arcs touch one another.

    Examples
    --------
    >>> import shapely, kirigami as kg
    >>> cuts = kg.cuts.curved_cells(2, 5)
    >>> len(cuts)  # 5 rows of 2 arcs bent up, 6 rows of 1 arc and 2 half arcs bent down
    28
    >>> kg.Sheet(shapely.box(0, 0, 2, 2.4), cuts)
    Sheet(2 x 2.4, area 4.8, 28 slits, 0 openings)
    """
    _counts("curved_cells", cells_across=cells_across, cells_along=cells_along)
    _positive("curved_cells", width=width, height=height, length_ratio=length_ratio, depth_ratio=depth_ratio)
    _not_negative("curved_cells", margin=margin, opening=opening)
    _counts("curved_cells", points=points)
    if points < 3 or points % 2 == 0:
        raise GeometryError(f"points must be odd and at least 3, so that a half arc ends at its top; not {points}")
    pitch = width / cells_across
    length = pitch * length_ratio / (1.0 + length_ratio)
    spacing = height / (cells_along * (1.0 + depth_ratio) + depth_ratio)
    depth = depth_ratio * spacing
    along = np.linspace(0.0, 1.0, points)
    arc = np.column_stack([(along - 0.5) * length, depth * np.sin(np.pi * along)])
    cuts: list[BaseGeometry] = []
    for row in range(cells_along + 1):
        base = margin + depth + row * (depth + spacing)
        for half_cell in range(2 * cells_across + 1):
            bent_up = half_cell % 2 == 1
            if bent_up and row == cells_along:
                continue
            line = arc * (1.0, 1.0 if bent_up else -1.0) + (0.5 * half_cell * pitch, base)
            if half_cell == 0:
                line = line[points // 2 :]
                line[0, 0] = 0.0
            elif half_cell == 2 * cells_across:
                line = line[: points // 2 + 1]
                line[-1, 0] = width
            cuts.append(_cut_of_height(line, opening))
    _require_apart(cuts, "change length_ratio, depth_ratio or opening")
    return cuts


def parallel_slits(
    columns: int = 1,
    rows: int = 9,
    width: float = 1.0,
    height: float = 2.0,
    length: float = 0.8,
    *,
    margin: float = 0.0,
    opening: float = 0.0,
    sides_first: bool = False,
) -> list[BaseGeometry]:
    """Rows of straight slits along x, every other row shifted by half the distance between slits.

    With one column this is the ribbon with slits from the centre and from both sides in turn. The ligaments between
    slits of a row are ``width / columns - length`` wide, the rows ``height / rows`` apart.

    Parameters
    ----------
    columns, rows : int
        Slits in an unshifted row, and number of rows.
    width, height : float
        Size of the pattern.
    length : float
        Length of a slit; slits at the sides are half as long.
    margin : float
        Height of the uncut strips below and above the pattern.
    opening : float
        Width of the cuts along y; 0 for slits.
    sides_first : bool
        Begin with a shifted row.

    Raises
    ------
    GeometryError
        If the slits of a row or of two rows would touch.

    Examples
    --------
    >>> import kirigami as kg
    >>> [round(cut.length, 3) for cut in kg.cuts.parallel_slits(columns=1, rows=3)]
    [0.8, 0.4, 0.4, 0.8]
    """
    sides_first = require_boolean(sides_first, "sides_first", "parallel_slits", GeometryError)
    _counts("parallel_slits", columns=columns, rows=rows)
    _positive("parallel_slits", width=width, height=height, length=length)
    _not_negative("parallel_slits", margin=margin, opening=opening)
    pitch = width / columns
    cuts: list[BaseGeometry] = []
    for row in range(rows):
        y = margin + (row + 0.5) * height / rows
        shifted = (row % 2 == 1) != sides_first
        centres = pitch * np.arange(columns + 1) if shifted else pitch * (np.arange(columns) + 0.5)
        for x in centres.tolist():
            ends = np.array([(max(x - 0.5 * length, 0.0), y), (min(x + 0.5 * length, width), y)])
            cuts.append(_cut_of_height(ends, opening))
    _require_apart(cuts, "make the slits shorter or the openings narrower")
    return cuts


def perpendicular_slits(
    columns: int = 6, rows: int = 6, cell: float = 1.0, length: float = 1.7, *, margin: float = 0.0
) -> list[BaseGeometry]:
    """Slits along x and y in turn, at the centres of square cells: squares that rotate against each other.

    Parameters
    ----------
    columns, rows : int
        Number of cells along x and y.
    cell : float
        Side of a cell; the squares between the slits have this side.
    length : float
        Length of a slit, less than two cells; the hinges between squares are ``cell - length / 2`` wide. What reaches
        beyond the pattern is cut off.
    margin : float
        Height of the uncut strips below and above the pattern.

    Raises
    ------
    GeometryError
        If the slits would touch.

    Examples
    --------
    >>> import kirigami as kg
    >>> len(kg.cuts.perpendicular_slits(4, 3))
    12
    """
    _counts("perpendicular_slits", columns=columns, rows=rows)
    _positive("perpendicular_slits", cell=cell, length=length)
    _not_negative("perpendicular_slits", margin=margin)
    low, high = np.array([0.0, margin]), np.array([columns * cell, margin + rows * cell])
    cuts: list[BaseGeometry] = []
    for row in range(rows):
        for column in range(columns):
            centre = low + cell * (np.array([column, row]) + 0.5)
            direction = np.array([0.5 * length, 0.0]) if (row + column) % 2 == 0 else np.array([0.0, 0.5 * length])
            cuts.append(shapely.LineString(np.clip([centre - direction, centre + direction], low, high)))
    _require_apart(cuts, "make the slits shorter than two cells")
    return cuts


def random_slits(
    count: int,
    width: float,
    height: float,
    length: tuple[float, float],
    *,
    seed: int,
    gap: float,
    margin: float = 0.0,
    crossing: bool = False,
    angles: tuple[float, float] = (0.0, 180.0),
) -> list[BaseGeometry]:
    """Slits of random place, length and direction inside a rectangle, reproducible from the seed.

    Parameters
    ----------
    count : int
        Number of slits.
    width, height : float
        Size of the pattern; no slit reaches its edge.
    length : (float, float)
        Smallest and largest length, uniformly distributed in between.
    seed : int
        Seed of the random numbers.
    gap : float
        Smallest distance between slits, and of a slit from the edge of the pattern.
    margin : float
        Height of the uncut strips below and above the pattern.
    crossing : bool
        Let slits cross, but in such a way that each group of crossing slits encloses no piece of the sheet. They cross
        at 30 degrees or more.
    angles : (float, float)
        Smallest and largest direction in degrees, counter-clockwise from x, uniformly distributed in between.

    Raises
    ------
    GeometryError
        If there is no room for so many slits, or a parameter has no meaning.

    Examples
    --------
    >>> import kirigami as kg
    >>> slits = kg.cuts.random_slits(10, 1.0, 1.0, (0.1, 0.3), seed=1, gap=0.02)
    >>> slits == kg.cuts.random_slits(10, 1.0, 1.0, (0.1, 0.3), seed=1, gap=0.02)
    True
    """
    _counts("random_slits", count=count)
    length, angles = _range(length, "length", "random_slits"), _range(angles, "angles", "random_slits")
    shortest = length[0]
    _positive("random_slits", width=width, height=height, shortest=shortest, gap=gap)
    _not_negative("random_slits", margin=margin)
    crossing = require_boolean(crossing, "crossing", "random_slits", GeometryError)
    seed = require_whole(seed, "seed", "random_slits", 0, GeometryError)
    random = np.random.default_rng(seed)
    area = shapely.box(gap, margin + gap, width - gap, margin + height - gap)
    cuts: list[BaseGeometry] = []
    group: list[int] = []  # slits that hang together
    for _ in range(300 * count):
        centre = random.uniform((0.0, margin), (width, margin + height))
        angle, reach = np.radians(random.uniform(*angles)), 0.5 * random.uniform(*length)
        arm = reach * np.array([np.cos(angle), np.sin(angle)])
        slit = shapely.LineString([centre - arm, centre + arm])
        if not area.covers(slit):
            continue
        near = np.flatnonzero(shapely.dwithin(np.array(cuts, dtype=object), slit, gap)).tolist()
        met = [number for number in near if crossing and _crosses_clearly(cuts[number], slit, gap)]
        # Meeting one group twice would close a loop; passing close without a clear crossing would leave a sliver.
        if len(met) < len(near) or len({group[number] for number in met}) < len(met):
            continue
        joined = {group[number] for number in met}
        group = [len(cuts) if name in joined else name for name in group]
        group.append(len(cuts))
        cuts.append(slit)
        if len(cuts) == count:
            return cuts
    raise GeometryError(f"found room for {len(cuts)} of {counted(count, 'slit')}; make them fewer, shorter or closer")


def single_slit_disc(
    radius: float = 3.0, length: float = 2.58, opening: float = 0.0, points: int = 96
) -> tuple[shapely.Polygon, list[BaseGeometry]]:
    """A disc round the origin with one slit along x through its centre.

    Parameters
    ----------
    radius : float
        Radius of the circle through the corners of the outline.
    length : float
        Length of the slit, less than the diameter.
    opening : float
        Width of the cut along y; 0 for a slit.
    points : int
        Corners of the polygon that stands for the circle, divisible by four.

    Returns
    -------
    outline, cuts
        To be handed to `kirigami.Sheet` as they are.

    Examples
    --------
    >>> import kirigami as kg
    >>> outline, cuts = kg.cuts.single_slit_disc()
    >>> outline.bounds, cuts[0].length
    ((-3.0, -3.0, 3.0, 3.0), 2.58)
    """
    _positive("single_slit_disc", radius=radius, length=length)
    _not_negative("single_slit_disc", opening=opening)
    _counts("single_slit_disc", points=points)
    if points < 8 or points % 4:
        raise GeometryError(f"points must be at least 8 and divisible by four, not {points}")
    angle = 2.0 * np.pi * np.arange(points) / points
    corners = np.column_stack([np.cos(angle), np.sin(angle)])
    corners[np.abs(corners) < 1e-12] = 0.0  # the four outermost points lie on the axes exactly
    outline = shapely.Polygon(radius * corners)
    cut = _cut_of_height(np.array([(-0.5 * length, 0.0), (0.5 * length, 0.0)]), opening)
    if not outline.contains_properly(cut):
        raise GeometryError(f"a slit of length {length:g} does not fit into a disc of radius {radius:g}")
    return outline, [cut]


def single_slit_rectangle(
    width: float = 1.0,
    height: float = 1.0,
    length: float = 0.5,
    *,
    centre: tuple[float, float] | None = None,
    angle: float = 0.0,
    opening: float = 0.0,
) -> tuple[shapely.Polygon, list[BaseGeometry]]:
    """A rectangle with its lower left corner at the origin, and one slit.

    Parameters
    ----------
    width, height : float
        Size of the sheet along x and y.
    length : float
        Length of the slit.
    centre : (float, float), optional
        Middle of the slit; the middle of the sheet unless given.
    angle : float
        Direction of the slit in degrees, counter-clockwise from x.
    opening : float
        Width of the cut across the slit; 0 for a slit.

    Returns
    -------
    outline, cuts
        To be handed to `kirigami.Sheet` as they are.

    Examples
    --------
    >>> import kirigami as kg
    >>> outline, cuts = kg.cuts.single_slit_rectangle(2, 1, 0.5, angle=90)
    >>> [round(value, 12) for value in cuts[0].bounds]
    [1.0, 0.25, 1.0, 0.75]
    """
    _positive("single_slit_rectangle", width=width, height=height, length=length)
    _not_negative("single_slit_rectangle", opening=opening)
    outline = shapely.box(0.0, 0.0, width, height)
    turn = np.radians(require_finite(angle, "angle", "single_slit_rectangle", GeometryError))
    along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    middle = require_array(
        (0.5 * width, 0.5 * height) if centre is None else centre,
        (2,),
        name="centre",
        owner="single_slit_rectangle",
        error=GeometryError,
    )
    ends = middle + np.outer([-0.5 * length, 0.5 * length], along)
    cut: BaseGeometry = shapely.LineString(ends)
    if opening > 0:
        half = 0.5 * opening * across
        cut = shapely.Polygon([ends[0] - half, ends[1] - half, ends[1] + half, ends[0] + half])
    if not outline.intersects(cut):
        raise GeometryError(f"the slit with its middle at {tuple(middle.tolist())} misses the sheet")
    return outline, [cut]


def _crosses_clearly(one: BaseGeometry, other: BaseGeometry, gap: float) -> bool:
    """Whether two straight slits cross at more than 30 degrees, with all four ends at least the gap away."""
    ends = [shapely.points(shapely.get_coordinates(slit)) for slit in (one, other)]
    arms = [np.subtract(*shapely.get_coordinates(slit)) for slit in (one, other)]
    sine = abs(arms[0][0] * arms[1][1] - arms[0][1] * arms[1][0]) / (np.hypot(*arms[0]) * np.hypot(*arms[1]))
    clear = min(shapely.distance(ends[0], other).min(), shapely.distance(ends[1], one).min()) >= gap
    return bool(one.crosses(other) and sine > 0.5 and clear)


def _cut_of_height(line: Floats, opening: float) -> BaseGeometry:
    """A slit, or the strip between the line moved down and up by half the opening."""
    if opening == 0:
        return shapely.LineString(line)
    half = np.array([0.0, 0.5 * opening])
    return shapely.Polygon(np.concatenate([line - half, line[::-1] + half]))


def _require_apart(cuts: Sequence[BaseGeometry], advice: str) -> None:
    geometry = np.array(cuts, dtype=object)
    smallest = 1e-9 * float(np.ptp(shapely.get_coordinates(geometry), axis=0).max())
    one, other = shapely.STRtree(geometry).query(geometry, "dwithin", distance=smallest)
    touching = np.flatnonzero(one < other)
    if touching.size:
        first, second = cuts[one[touching[0]]], cuts[other[touching[0]]]
        place = shapely.shortest_line(first, second).coords[0]
        more = f", and so do {counted(touching.size - 1, 'more pair')}" if touching.size > 1 else ""
        pair = f"cuts {one[touching[0]]} and {other[touching[0]]}"
        raise GeometryError(f"{pair} touch at ({place[0]:.6g}, {place[1]:.6g}){more}: {advice}")


def _counts(owner: str, **values: int) -> None:
    for name, value in values.items():
        if require_whole(value, name, owner, 1, GeometryError) > MOST:
            raise GeometryError(f"{owner}: {name} must be at most {MOST}, got {shown(value)}")


def _positive(owner: str, **values: float) -> None:
    for name, value in values.items():
        require_positive(value, name, owner, GeometryError)


def _not_negative(owner: str, **values: float) -> None:
    for name, value in values.items():
        require_not_negative(value, name, owner, GeometryError)


def _range(value: Any, name: str, owner: str) -> tuple[float, float]:
    low, high = require_array(value, (2,), name=name, owner=owner, error=GeometryError).tolist()
    if low > high:
        raise GeometryError(f"{owner}: {name} must be a range from low to high, got {low:g} to {high:g}")
    return low, high
