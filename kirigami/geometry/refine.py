"""From a clean drawing to a graded triangulation: sizes, subdivision of the drawn edges, refinement and smoothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import GeometryError
from kirigami.geometry.clean import LineWork
from kirigami.geometry.topology import boundary_pairs, signed_areas
from kirigami.geometry.triangulate import Triangulation, carve, triangulate
from kirigami.words import counted

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]
LocalSize = Callable[[Floats], Floats]  # wanted edge lengths (n,) at points (n, 2)

GROWTH = 0.3  # increase of the edge length per distance from a cut
LONGEST = 1.1  # no edge is longer than this times max_edge
LONG = 1.08  # longer edges are split
LATTICE_STEP = 0.92  # of the wanted length, which leaves room for the irregular places
LEVEL_RATIO = 1.2  # between the steps of the lattices where sizes are graded
CLEARANCE = 0.75  # of the wanted length, between lattice points and what is there already
LARGEST_AREA = 2.0  # of a facet, relative to the equilateral one of the wanted length
FAIR_ANGLE = 30.0  # smoothing makes no angle smaller than this
MAX_FACETS = 2_000_000
EQUILATERAL = np.sqrt(3.0) / 4.0  # area of the triangle of side one
REFINEMENT_ROUNDS = 30
SMOOTHING_ROUNDS = 6
NONE = np.empty((0, 3), np.int64)
NO_POINTS = np.empty((0, 2))
FINE_SAMPLES = 0.5  # of the wanted length: farthest distance of the places at which it is asked for along an edge
BLOCK = 8  # steps of a fine lattice that are looked at together
SAMPLES = 40_000  # places at which a local size is asked for before meshing


@dataclass(frozen=True)
class SizeField:
    """Wanted edge length: ``cut_edge`` at the cuts, growing with the distance from them up to ``max_edge``; nowhere
    more than `local` wants, whose growth per distance is `slope` where it is known."""

    max_edge: float
    cut_edge: float
    cut_samples: Floats
    local: LocalSize | None = None
    slope: float | None = GROWTH

    def __call__(self, points: Floats) -> Floats:
        wanted: Floats = np.full(len(points), self.max_edge)
        if len(self.cut_samples):
            distance = _distances(self.cut_samples, points)
            grown = self.cut_edge + GROWTH * np.maximum(distance - 0.5 * self.cut_edge, 0.0)
            wanted = np.minimum(grown, wanted)
        if self.local is None or not len(points):  # a user's function need not know what to say of no point
            return wanted
        return np.minimum(wanted, self.local(points))


def triangulate_drawing(
    drawing: LineWork,
    max_edge: float,
    cut_edge: float,
    min_angle: float,
    local: LocalSize | None = None,
    slope: float | None = None,
) -> Triangulation:
    """Triangulate a clean drawing with graded edge lengths, all in its unit frame.

    Parameters
    ----------
    drawing : LineWork
        What `kirigami.geometry.clean.clean` returns.
    max_edge, cut_edge : float
        Edge lengths far from the cuts and along them.
    min_angle : float
        Smallest angle in degrees, kept wherever the drawing itself has no sharper one.
    local : callable, optional
        Wanted edge length at points of the unit frame, where it is less than what the others give.
    slope : float, optional
        Largest growth of `local` per distance, if it is known: fine lattices are then laid only where they are needed.

    Raises
    ------
    GeometryError
        If the edge lengths ask for more than two million facets, or a sliver for far more than expected.
    """
    is_cut = drawing.label_is_cut[drawing.labels]
    smallest, facets = cut_edge, _expected_facets(drawing, is_cut, max_edge, cut_edge)
    if local is not None:
        smallest, more = _sampled(drawing, local, max_edge)
        smallest, facets = min(smallest, cut_edge), facets + more
    if facets > MAX_FACETS:
        raise GeometryError(
            f"max_edge = {max_edge * drawing.frame.size:.4g} and cut_edge = {cut_edge * drawing.frame.size:.4g} ask "
            f"for about {facets:.1e} facets; the limit is {MAX_FACETS:.0e}. Take longer edges"
        )
    points, segments, labels, boundary = [drawing.points], [], [], []
    lengths = np.linalg.norm(drawing.points[drawing.edges[:, 1]] - drawing.points[drawing.edges[:, 0]], axis=1)
    count = len(drawing.points)

    def add(edge: int, fractions: Floats) -> None:
        """Divide a drawn edge at these fractions of its length, ends left out."""
        nonlocal count
        begin, end = drawing.edges[edge]
        inner = np.arange(count, count + len(fractions))
        count += len(fractions)
        points.append(drawing.points[begin] + fractions[:, None] * (drawing.points[end] - drawing.points[begin]))
        chain = np.concatenate([[begin], inner, [end]])
        segments.append(np.column_stack([chain[:-1], chain[1:]]))
        labels.append(np.full(len(chain) - 1, drawing.labels[edge]))
        if drawing.is_boundary[edge]:
            boundary.append(segments[-1])

    joints = np.bincount(drawing.edges[drawing.label_separates[drawing.labels]].ravel(), minlength=count)
    cut_edges = np.flatnonzero(is_cut)
    along = SizeField(cut_edge, cut_edge, NO_POINTS, local, slope)
    uneven = [] if local is None else _graded_fractions(drawing.points[drawing.edges[cut_edges]], along)
    for position, edge in enumerate(cut_edges.tolist()):
        alone = (joints[drawing.edges[edge]] == 1).all()  # one mesh edge between two tips could not open
        pieces = max(_pieces(lengths[edge] / cut_edge), 2 if alone else 1)
        inner = np.arange(1, pieces) / pieces
        if local is not None and len(uneven[position]) > len(inner):
            inner = uneven[position]
        add(edge, inner)
    cut_points = np.concatenate([*points[1:], drawing.points[np.unique(drawing.edges[is_cut])]])
    slope = GROWTH if local is None else slope
    size = SizeField(max_edge, cut_edge, cut_points if cut_edge < max_edge else NO_POINTS, local, slope)
    other_edges = np.flatnonzero(~is_cut)
    for edge, inner in zip(
        other_edges.tolist(), _graded_fractions(drawing.points[drawing.edges[other_edges]], size), strict=True
    ):
        add(edge, inner)

    drawn = Triangulation(np.concatenate(points), NONE, np.concatenate(segments), np.concatenate(labels))
    start = _seeded(drawn, size, np.concatenate(boundary), smallest, drawing.mesher)
    limit = int(4 * facets) + 20_000
    made = _refined(start, size, min_angle, limit, drawing.mesher)
    if len(made.points) - len(start.points) >= limit:
        centre = made.points[made.triangles[np.argmin(signed_areas(made.points, made.triangles))]].mean(axis=0)
        raise GeometryError(
            f"more than {counted(limit, 'node')} needed where the drawing leaves a very narrow sliver or gap, near "
            f"{drawing.frame.place(centre)}; move the cuts apart, or close it by a larger `snap`"
        )
    return _smoothed(made, size, drawing.mesher)


def _expected_facets(drawing: LineWork, is_cut: NDArray[np.bool_], max_edge: float, cut_edge: float) -> float:
    """Facets of a uniform mesh, and of the graded bands along the cuts as long as these do not overlap."""
    ends = drawing.points[drawing.edges[is_cut]]
    cut_length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    band = min(2.0 * cut_length / (EQUILATERAL * GROWTH * cut_edge), drawing.area / (EQUILATERAL * cut_edge**2))
    return float(drawing.area / (EQUILATERAL * max_edge**2) + band)


def _sampled(drawing: LineWork, local: LocalSize, max_edge: float) -> tuple[float, float]:
    """Smallest wanted length of a local size, and the facets it asks for."""
    low, high = drawing.points.min(axis=0), drawing.points.max(axis=0)
    step = float(np.sqrt(np.prod(high - low) / SAMPLES))
    places = np.concatenate([_lattice(low, high, step), drawing.points])
    wanted = np.asarray(local(places), dtype=float)
    if wanted.shape != (len(places),) or not (np.isfinite(wanted) & (wanted > 0)).all():
        raise GeometryError("size must return one positive length for each of the points (n, 2) it is given")
    wanted = np.minimum(wanted, max_edge)
    return float(wanted.min()), float(drawing.area / EQUILATERAL * (1 / wanted**2).mean())


def _pieces(ratio: float) -> int:
    return max(1, int(np.ceil(ratio - 1e-6)))  # equal lengths may differ by rounding


def _graded_fractions(ends: Floats, size: SizeField) -> list[Floats]:
    """Where to divide each edge (k, 2, 2) so that every piece is as long as wanted at its place."""
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    samples = 2 + np.ceil(4 * length / size.cut_edge).astype(np.int64)
    edge = np.repeat(np.arange(len(ends)), samples)
    place = np.concatenate([np.linspace(0.0, 1.0, number) for number in samples]) if len(ends) else np.empty(0)

    def density(edge: Integers, place: Floats) -> Floats:
        """Pieces per edge that would be asked for if the whole edge were like this place."""
        asked: Floats = length[edge] / size(ends[edge, 0] + place[:, None] * (ends[edge, 1] - ends[edge, 0]))
        return asked

    asked = density(edge, place)
    while True:
        gap = np.diff(place) * np.maximum(asked[1:], asked[:-1])
        wide = np.flatnonzero((edge[1:] == edge[:-1]) & (gap > FINE_SAMPLES))
        if not wide.size:
            break
        new_edge, new_place = edge[wide], 0.5 * (place[wide] + place[wide + 1])
        edge, place, asked = (
            np.insert(old, wide + 1, new)
            for old, new in ((edge, new_edge), (place, new_place), (asked, density(new_edge, new_place)))
        )
    fractions = []
    first = np.searchsorted(edge, np.arange(len(ends) + 1))
    for begin, end in zip(first[:-1].tolist(), first[1:].tolist(), strict=True):
        here, rate = place[begin:end], asked[begin:end]
        pieces_before = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(here))])
        pieces = _pieces(pieces_before[-1])
        fractions.append(np.interp(np.arange(1, pieces) * pieces_before[-1] / pieces, pieces_before, here))
    return fractions


def _seeded(
    drawn: Triangulation, size: SizeField, boundary: Integers, smallest: float, mesher: str
) -> Triangulation:
    """Triangulation with points of triangular lattices inside: equilateral facets wherever sizes are equal."""
    levels = max(1, int(np.ceil(np.log(size.max_edge / smallest) / np.log(LEVEL_RATIO) - 1e-9)))
    steps = np.append(smallest * (size.max_edge / smallest) ** (np.arange(levels) / levels), size.max_edge)
    if not len(size.cut_samples) and size.local is None:
        steps = steps[-1:]
    points = drawn.points
    low, high = points.min(axis=0), points.max(axis=0)
    for step, next_step in zip(steps, [*steps[1:], np.inf], strict=True):
        if np.prod((high - low) / step) > MAX_FACETS:
            continue  # a fine level for a few places: refinement fills these as well
        lattice = _lattice(low, high, LATTICE_STEP * step)
        if size.slope is not None and size.local is not None:
            lattice = lattice[_may_be_wanted(lattice, size, step, next_step)]
        wanted = size(lattice)
        lattice = lattice[(wanted > step * (1 - 1e-9)) & (wanted < next_step * (1 - 1e-9))]
        if len(lattice):
            points = np.concatenate([points, lattice[_distances(points, lattice) > CLEARANCE * step]])
    made = carve(triangulate(Triangulation(points, NONE, drawn.segments, drawn.markers), mesher), boundary)
    used, triangles = np.unique(made.triangles, return_inverse=True)
    return Triangulation(
        made.points[used], triangles.reshape(-1, 3), np.searchsorted(used, made.segments), made.markers
    )


def _may_be_wanted(lattice: Floats, size: SizeField, step: float, next_step: float) -> NDArray[np.bool_]:
    """Which points of a lattice lie in blocks where an edge length between two steps can be wanted at all."""
    assert size.slope is not None
    side = BLOCK * step
    low = lattice.min(axis=0)
    cell = np.floor((lattice - low) / side).astype(np.int64)
    columns = int(cell[:, 0].max()) + 1
    cells, block = np.unique(cell @ [1, columns], return_inverse=True)
    centres = low + (np.column_stack([cells % columns, cells // columns]) + 0.5) * side
    wanted, reach = size(centres), size.slope * side * np.sqrt(0.5)
    possible: NDArray[np.bool_] = (wanted + reach > step * (1 - 1e-9)) & (wanted - reach < next_step)
    return possible[block]


def _lattice(low: Floats, high: Floats, step: float) -> Floats:
    """Points of a triangular lattice over a box."""
    row_step = np.sqrt(0.75) * step
    columns, rows = np.ceil((high - low) / (step, row_step)).astype(int) + 1
    row, column = np.mgrid[0:rows, 0:columns]
    points: Floats = low + np.column_stack([((column + 0.5 * (row % 2)) * step).ravel(), (row * row_step).ravel()])
    return points


def _distances(points: Floats, queries: Floats) -> Floats:
    """Distance from each query to the nearest of the points."""
    from scipy.spatial import KDTree

    distances: Floats = KDTree(points).query(queries)[0]
    return distances


def _refined(start: Triangulation, size: SizeField, min_angle: float, limit: int, mesher: str) -> Triangulation:
    made = triangulate(start, mesher, min_angle=min_angle, max_new_points=limit)
    for _ in range(REFINEMENT_ROUNDS):
        area = signed_areas(made.points, made.triangles)
        _, longest = _quality(made.points, made.triangles)
        largest = LARGEST_AREA * EQUILATERAL * size(made.points[made.triangles].mean(axis=1)) ** 2
        largest = np.where(longest > LONG * size.max_edge, np.minimum(largest, 0.7 * area), largest)
        left = limit - (len(made.points) - len(start.points))
        if not (area > largest).any() or left <= 0:
            return made
        made = triangulate(made, mesher, min_angle=min_angle, max_areas=largest, max_new_points=left)
    return made


def _smoothed(made: Triangulation, size: SizeField, mesher: str) -> Triangulation:
    """Move free points to where the circumcentres of the facets round them balance, then restore Delaunay.

    This is optimal Delaunay triangulation (Chen and Holst 2011), with facets weighted for graded sizes. It goes on
    while the mean of the smallest angles grows.
    """
    fixed = np.zeros(len(made.points), bool)
    fixed[made.segments] = True
    boundary = boundary_pairs(made.triangles)
    angle, _ = _quality(made.points, made.triangles)
    for _ in range(SMOOTHING_ROUNDS):
        points = _moved(made, fixed, size)
        moved = carve(triangulate(Triangulation(points, NONE, made.segments, made.markers), mesher), boundary)
        if len(moved.points) != len(points) or len(moved.triangles) != len(made.triangles):
            return made
        new_angle, longest = _quality(moved.points, moved.triangles)
        if new_angle.mean() <= angle.mean() or longest.max() > LONGEST * size.max_edge:
            return made
        made, angle = moved, new_angle
    return made


def _moved(made: Triangulation, fixed: NDArray[np.bool_], size: SizeField) -> Floats:
    points, triangles = made.points, made.triangles
    corners = points[triangles]
    centroids = corners.mean(axis=1)
    weights = signed_areas(points, triangles) / size(centroids) ** 3
    total = np.bincount(triangles.ravel(), np.repeat(weights, 3), minlength=len(points))
    moved: Floats = points.copy()
    for axis, centre in enumerate(_circumcentres(corners).T):
        sums = np.bincount(triangles.ravel(), np.repeat(weights * centre, 3), minlength=len(points))
        moved[~fixed, axis] = (sums / np.where(total > 0, total, 1.0))[~fixed]
    # Points of a facet that would turn over, or become poor, go back: the moved triangulation stays a valid one, hence
    # no two points meet and none leaves the sheet, and Delaunay flips can only make its smallest angle larger.
    angle, longest = _quality(points, triangles)
    while True:
        new_angle, new_longest = _quality(moved, triangles)
        poor = (new_angle < np.minimum(angle, FAIR_ANGLE)) | (new_longest > np.maximum(longest, LONG * size.max_edge))
        back = triangles[poor].ravel()
        if (moved[back] == points[back]).all():
            return moved
        moved[back] = points[back]


def _circumcentres(corners: Floats) -> Floats:
    origin = corners[:, 0]
    one, two = corners[:, 1] - origin, corners[:, 2] - origin
    squares = np.einsum("mx,mx->m", one, one), np.einsum("mx,mx->m", two, two)
    double_area = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    x = two[:, 1] * squares[0] - one[:, 1] * squares[1]
    y = one[:, 0] * squares[1] - two[:, 0] * squares[0]
    return origin + np.column_stack([x, y]) / (2.0 * double_area)[:, None]


def _quality(points: Floats, triangles: Integers) -> tuple[Floats, Floats]:
    """Smallest angle in degrees, negative if the triangle is clockwise, and longest edge of each triangle."""
    corners = points[triangles]
    sides = corners[:, [1, 2, 0]] - corners
    cosines = -np.einsum("mcx,mcx->mc", sides, np.roll(sides, 1, axis=1))
    angles = np.degrees(np.arctan2(2.0 * signed_areas(points, triangles)[:, None], cosines))
    return angles.min(axis=1), np.linalg.norm(sides, axis=2).max(axis=1)
