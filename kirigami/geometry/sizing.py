"""Edge lengths chosen for a budget of nodes: ligaments and tips of cuts first, all else as coarse as it may be.

Wanted edge lengths grow linearly from *sources*: sections across ligaments want `LAYERS` facets across, cuts and holes
as many along their extent, and tips of cuts, where the stress is singular, far shorter edges. One number scales them
all and is chosen so that the mesh has the nodes it may have. Halving it halves all lengths but those at tips, which
are quartered: the error of a stress as 1 / sqrt(r) at a tip is then of the same order as all other errors.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.errors import KirigamiWarning
from kirigami.geometry.clean import LineWork
from kirigami.geometry.ligaments import Ligaments, find_ligaments
from kirigami.geometry.refine import EQUILATERAL, triangulate_drawing
from kirigami.geometry.triangulate import Triangulation
from kirigami.geometry.unzip import unzip
from kirigami.scale import UNKNOWN, Scale
from kirigami.words import counted

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

NODES = 4000  # the budget, unless one is given
LAYERS = 4.0  # facets wanted across a ligament
FEW_LAYERS = 2.0  # facets across, below which the worst ligament is worth a warning
EDGE = 1.0 / (LAYERS * np.sqrt(0.75))  # edge length over width that puts so many rows of facets across
GROWTH = 0.6  # increase of the edge length per distance
STEEPEST = 0.8  # increase beyond which the facets themselves set the pace
TIP = 0.2  # edge length at a tip over that of the ligament beside it
REENTRANT = 225.0  # degrees of sheet round a corner from which on it counts as a tip
CLASS = 1.3  # sources whose lengths differ by less are looked up together
TRIALS = 8  # of a scale
SHORTER = 0.9  # than a ligament with too few facets across asks for, so that it has enough
PASSES = 3  # over ligaments that came out too coarse
COARSEST = 8.0  # times the first scale: beyond, only the points of the drawing count
FLATTEST = -0.3  # least believed power of nodes over scale
CLOSE = 0.07  # of the budget: near enough
KEPT = 0.1  # of the budget: what is promised


@dataclass(frozen=True)
class Sizing:
    """What a mesh that chose its own sizes has come to.

    Attributes
    ----------
    budget, nodes : int
        Nodes that were allowed, and that the mesh has.
    longest, shortest : float
        Longest and shortest edge [length].
    ligaments : int
        Sections across ligaments that were looked at.
    coarse : int
        How many of them have fewer than four facets across.
    facets_across : float
        Facets across the worst of them: half of the facets that a straight line across it passes through, since two
        facets make a quadrilateral; infinite in a sheet without ligaments.
    width : float
        Width of the worst ligament [length].
    place : tuple of float
        Its middle (x, y) [length].
    narrowest : float
        Width of the narrowest ligament [length]; infinite without ligaments.
    scale : Scale
        In which its lengths are told, of a sheet in metres; without one they are said to be in the unit of the sheet.
    """

    budget: int
    nodes: int
    longest: float
    shortest: float
    ligaments: int
    coarse: int
    facets_across: float
    width: float
    place: tuple[float, float]
    narrowest: float
    scale: Scale = UNKNOWN

    def length(self, value: float) -> str:
        """A length in words."""
        return self.scale.show(value, "length", 3)

    @property
    def worst(self) -> str:
        """The place of the worst ligament in words."""
        return self.scale.place(self.place)

    @property
    def unsaid(self) -> str:
        """Words on the unit where none is known."""
        return "" if self.scale.length else "in the unit of the sheet"

    @property
    def across(self) -> str:
        """The facets across the worst ligament, in words."""
        return counted(self.facets_across, "facet", spec="g")

    def __str__(self) -> str:
        size = (
            f"{counted(self.nodes, 'node')}, {self.budget} asked for, edges {self.length(self.shortest)} to "
            f"{self.length(self.longest)} long {self.unsaid}".rstrip()
        )
        if not self.ligaments:
            return f"{size}; no ligaments"
        return (
            f"{size}; at least {self.across} across a ligament (width {self.length(self.width)} at "
            f"{self.worst}), fewer than {LAYERS:g} in {self.coarse} of "
            f"{counted(self.ligaments, 'section')}"
        )


class _Lengths:
    """Wanted edge length at points of the unit frame: the least that any source wants, growing with the distance."""

    def __init__(self, points: Floats, lengths: Floats, slope: float, longest: float) -> None:
        from scipy.spatial import KDTree

        self.slope, self.longest = slope, longest
        self.classes = []
        rank = np.floor(np.log(lengths / lengths.min()) / np.log(CLASS) + 1e-9) if len(lengths) else np.zeros(0)
        for number in np.unique(rank):
            members = np.flatnonzero(rank == number)
            self.classes.append((float(lengths[members].min()), lengths[members], KDTree(points[members])))

    def __call__(self, points: Floats) -> Floats:
        wanted = np.full(len(points), self.longest)
        for least, lengths, tree in self.classes:
            open_points = np.flatnonzero(wanted > least)
            reach = (wanted[open_points].max(initial=0.0) - least) / self.slope
            distance, nearest = tree.query(points[open_points], distance_upper_bound=reach)
            found = np.isfinite(distance)
            reached = open_points[found]
            grown = lengths[nearest[found]] + self.slope * distance[found]
            wanted[reached] = np.minimum(wanted[reached], grown)
        return wanted


class _Law:
    """Edge lengths of one drawing as a function of one scale."""

    def __init__(self, drawing: LineWork, ligaments: Ligaments) -> None:
        low, high = drawing.points.min(axis=0), drawing.points.max(axis=0)
        self.longest = EDGE * float(min(high - low))
        shares = np.linspace(0.0, 1.0, 5)[:, None, None]
        across = ligaments.ends[:, 0] + shares * (ligaments.ends[:, 1] - ligaments.ends[:, 0])
        extents, owner = _extents(drawing)
        self.points = np.concatenate([across.reshape(-1, 2), drawing.points[owner >= 0]])
        self.lengths = EDGE * np.concatenate([np.tile(ligaments.widths, len(shares)), extents[owner[owner >= 0]]])
        self.tips = drawing.points[_tips(drawing)]
        self.tip_lengths = _Lengths(self.points, self.lengths, GROWTH, self.longest)(self.tips)

    def refine(self, shares: Floats) -> None:
        """Shorten the lengths at those ligaments that had only these shares of the facets wanted across."""
        sections = self.lengths[: 5 * len(shares)].reshape(5, -1)
        sections *= np.where(shares < 1.0, SHORTER * shares, 1.0)

    def at(self, scale: float) -> _Lengths:
        """The lengths, all of them times a scale, and those at tips times its square."""
        tip_lengths = np.minimum(TIP * scale, 1.0) * scale * self.tip_lengths
        points = np.concatenate([self.points, self.tips])
        lengths = np.concatenate([scale * self.lengths, tip_lengths])
        return _Lengths(points, lengths, min(GROWTH * scale, STEEPEST), scale * self.longest)


def _extents(drawing: LineWork) -> tuple[Floats, Integers]:
    """Extent of each connected piece of the line work but the outermost, and the piece of each point, -1 for none."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    edges = drawing.edges[drawing.label_separates[drawing.labels]]
    count = len(drawing.points)
    graph = coo_array((np.ones(len(edges)), tuple(edges.T)), shape=(count, count))
    number, piece = connected_components(graph, directed=False)
    low, high = np.full((number, 2), np.inf), np.full((number, 2), -np.inf)
    np.minimum.at(low, piece, drawing.points)
    np.maximum.at(high, piece, drawing.points)
    extents = np.linalg.norm(high - low, axis=1)
    alone = extents == 0  # points of lines that are not cut
    outermost = int(np.argmax(extents))
    return extents, np.where(alone[piece] | (piece == outermost), -1, piece)


def _tips(drawing: LineWork) -> Integers:
    """Points with more sheet between two lines than `REENTRANT` degrees: ends of slits and sharp corners."""
    chosen = drawing.label_separates[drawing.labels]
    edges, boundary = drawing.edges[chosen], drawing.is_boundary[chosen]
    # directions of the edges at each point, and whether the sheet lies counter-clockwise of each
    point = edges.ravel()
    step = drawing.points[edges[:, 1]] - drawing.points[edges[:, 0]]
    angle = np.degrees(np.arctan2(step[:, 1], step[:, 0]))
    angles = np.column_stack([angle, angle + 180.0]).ravel() % 360.0
    ahead = np.column_stack([np.ones(len(edges), bool), ~boundary]).ravel()
    order = np.lexsort([angles, point])
    point, angles, ahead = point[order], angles[order], ahead[order]
    first = np.append(True, point[1:] != point[:-1])
    start = np.maximum.accumulate(np.where(first, np.arange(len(point)), 0))
    last = np.append(first[1:], True)
    following = np.where(last, angles[start] + 360.0, np.append(angles[1:], 0.0))
    tips: Integers = np.unique(point[ahead & (following - angles > REENTRANT)])
    return tips


def mesh_within(drawing: LineWork, nodes: int, min_angle: float) -> tuple[Triangulation, Sizing]:
    """Triangulate a drawing with about so many nodes, where they are needed most, and say what came of it.

    Parameters
    ----------
    drawing : LineWork
        What `kirigami.geometry.clean.clean` returns.
    nodes : int
        Nodes that the mesh, opened along its slits, may have.
    min_angle : float
        Smallest angle in degrees.

    Returns
    -------
    Triangulation, Sizing
        In the unit frame; lengths of the sizing are in the unit of the drawing.
    """
    ligaments = find_ligaments(drawing)
    law = _Law(drawing, ligaments)
    scale = _first_scale(drawing, law, nodes)
    for _ in range(PASSES):
        made, scale, count = _scaled_to(drawing, law, scale, nodes, min_angle)
        ends = made.points[_edges(made)]
        layers = facets_across(ends, ligaments.ends)
        if scale > 1.0 or (layers >= LAYERS).all():
            break  # the budget is spent, or enough
        law.refine(layers / LAYERS)
    return made, _told(drawing, ends, ligaments, layers, nodes, count)


def _scaled_to(
    drawing: LineWork, law: _Law, scale: float, nodes: int, min_angle: float
) -> tuple[Triangulation, float, int]:
    """The triangulation nearest to a number of nodes, its scale and its nodes, sought from a first scale."""
    tried: list[tuple[int, float, int, Triangulation]] = []
    for _ in range(TRIALS):
        local = law.at(scale)
        made = triangulate_drawing(drawing, local.longest, local.longest, min_angle, local, local.slope)
        count = len(unzip(made.triangles, made.segments[drawing.label_separates[made.markers]])[1])
        tried.append((abs(count - nodes), scale, count, made))
        if abs(count - nodes) <= CLOSE * nodes or scale > COARSEST * tried[0][1]:
            break
        below = max((entry for entry in tried if entry[2] < nodes), key=lambda entry: entry[2], default=None)
        above = min((entry for entry in tried if entry[2] > nodes), key=lambda entry: entry[2], default=None)
        power = -2.0  # nodes grow as the inverse square of the lengths
        if below is not None and above is not None:
            power = min(float(np.log(below[2] / above[2]) / np.log(below[1] / above[1])), FLATTEST)
        _, base, had, _ = min(tried, key=lambda entry: entry[0])
        scale = base * float((nodes / had) ** (1.0 / power))
    _, scale, count, made = min(tried, key=lambda entry: entry[0])
    return made, scale, count


def _edges(made: Triangulation) -> Integers:
    edges: Integers = np.unique(np.sort(made.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    return edges


def _first_scale(drawing: LineWork, law: _Law, nodes: int) -> float:
    """A scale from the nodes that the lengths ask for on a lattice over the sheet."""
    low, high = drawing.points.min(axis=0), drawing.points.max(axis=0)
    side = 160
    places = low + (np.stack(np.meshgrid(*[(np.arange(side) + 0.5) / side] * 2), axis=-1).reshape(-1, 2)) * (high - low)
    density = (1.0 / law.at(1.0)(places) ** 2).mean()
    return float(np.sqrt(0.5 * drawing.area / EQUILATERAL * density / nodes)) or 1.0


def _told(
    drawing: LineWork, edges: Floats, ligaments: Ligaments, layers: Floats, budget: int, nodes: int
) -> Sizing:
    lengths = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1) * drawing.frame.size
    told = Sizing(
        budget, nodes, float(lengths.max()), float(lengths.min()), 0, 0, np.inf, np.inf, (np.nan, np.nan), np.inf
    )
    if not len(ligaments.widths):
        return told
    worst = int(np.lexsort([ligaments.widths, layers])[0])
    middle = drawing.frame.from_unit(ligaments.ends[worst].mean(axis=0))
    return replace(
        told,
        ligaments=len(layers),
        coarse=int((layers < LAYERS).sum()),
        facets_across=float(layers[worst]),
        width=float(ligaments.widths[worst] * drawing.frame.size),
        place=(float(middle[0]), float(middle[1])),
        narrowest=float(ligaments.widths.min() * drawing.frame.size),
    )


def facets_across(edges: Floats, sections: Floats) -> Floats:
    """Half of the facets that each section (k, 2, 2) passes through, from the edges (e, 2, 2) that it crosses."""
    inward = sections[:, ::-1] - sections
    lines = shapely.linestrings(sections + 1e-6 * inward)  # the ends lie on the line work
    crossing, _ = shapely.STRtree(shapely.linestrings(edges)).query(lines, predicate="intersects")
    crossed = np.bincount(crossing, minlength=len(sections))
    return np.asarray(0.5 * (crossed + 1), dtype=float)


def warn_of_coarse(sizing: Sizing, thickness: float | None) -> None:
    """Say so where the budget was not enough, or where a ligament is no thin sheet any more."""
    if sizing.nodes > (1 + KEPT) * sizing.budget:
        warnings.warn(
            f"the mesh has {counted(sizing.nodes, 'node')}, more than the {sizing.budget} allowed: the drawing itself "
            "has so many points or such small details. Simplify it, or allow more nodes",
            KirigamiWarning,
            stacklevel=3,
        )
    if sizing.facets_across < FEW_LAYERS:
        needed = float(f"{sizing.nodes * (LAYERS / sizing.facets_across) ** 2:.1g}")
        warnings.warn(
            f"the ligament of width {sizing.length(sizing.width)} at {sizing.worst}"
            f"{f' ({sizing.unsaid})' if sizing.unsaid else ''} has only {sizing.across} across, and {sizing.coarse} of "
            f"{counted(sizing.ligaments, 'section')} across ligaments have fewer than {LAYERS:g}: too coarse to "
            f"bend. About {counted(needed, 'node', spec=',.0f')} would do instead of {sizing.budget:,}",
            KirigamiWarning,
            stacklevel=3,
        )
    if thickness is not None and sizing.narrowest < thickness:
        warnings.warn(
            f"the narrowest ligament is {sizing.length(sizing.narrowest)} wide, {sizing.narrowest / thickness:.2g} "
            f"times the thickness {sizing.length(thickness)}{f', {sizing.unsaid}' if sizing.unsaid else ''}: it is no "
            "thin sheet, and its stiffness is not to be trusted",
            KirigamiWarning,
            stacklevel=3,
        )
