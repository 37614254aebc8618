"""From loose curves of a drawing to an outline, cuts and folds: what all readers of drawings share."""

from __future__ import annotations

import re
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.errors import GeometryError, KirigamiWarning
from kirigami.units import metres_per

if TYPE_CHECKING:
    from kirigami.geometry.sheet import Sheet
    from kirigami.primitives.material import Material

Floats = NDArray[np.float64]
Names = str | Iterable[str] | None

# How words in the names of layers begin or end that say what a layer is for; the first role with a match wins.
WORDS = {
    "ignore": ("defpoints", "dim", "text", "note", "construction", "guide", "title", "legend", "bemassung", "hilfs"),
    "fold": ("fold", "folds", "crease", "score", "mountain", "valley", "bend", "engrave", "falz"),
    "outline": ("outline", "contour", "border", "boundary", "frame", "perimeter", "sheet", "umriss", "kontur"),
    "cut": ("cut", "cuts", "slit", "slits", "slot", "hole", "holes", "laser", "schnitt", "kerf"),
}
COLORS = {
    "#000000": "black", "#ff0000": "red", "#0000ff": "blue", "#00ff00": "green", "#008000": "green",
    "#ff00ff": "magenta", "#00ffff": "cyan", "#ffff00": "yellow", "#ffffff": "white",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Curve:
    """One drawn curve as points (k, 2), with where it comes from; closed where the last point is the first."""

    points: Floats
    layer: str = ""
    color: str = ""
    source: str = ""

    @property
    def closed(self) -> bool:
        return len(self.points) > 3 and bool((self.points[0] == self.points[-1]).all())

    @property
    def length(self) -> float:
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())


@dataclass
class Roles:
    """Which layers (or colours) are what; None leaves it to the names of the layers."""

    outline: Names = None
    cuts: Names = None
    folds: Names = None
    ignore: Names = None

    def of(self, curves: Sequence[Curve]) -> list[str]:
        """Role of each curve: "outline", "cut", "fold", "ignore", or "" where nothing says."""
        asked: dict[str, str] = {}
        present = {name.casefold() for curve in curves for name in (curve.layer, curve.color) if name}
        for role, names in (
            ("outline", self.outline), ("cut", self.cuts), ("fold", self.folds), ("ignore", self.ignore)
        ):  # fmt: skip
            for name in listed(names):
                plain = color_name(name).casefold()
                if plain not in present:
                    raise GeometryError(f"no curve is on a layer or has a colour {name!r}; there are {listing(curves)}")
                asked[plain] = role
        by_name = {curve.layer: role_of_name(curve.layer) for curve in curves}
        return [
            asked.get(curve.layer.casefold()) or asked.get(curve.color.casefold()) or by_name[curve.layer]
            for curve in curves
        ]

    @property
    def names(self) -> set[str]:
        """All names asked for, in small letters."""
        groups = (self.outline, self.cuts, self.folds, self.ignore)
        return {name.casefold() for group in groups for name in listed(group)}


def listed(names: Names) -> list[str]:
    """One name, several or none as a list."""
    return [names] if isinstance(names, str) else list(names or ())


def color_name(color: str) -> str:
    """The common name of a colour given as #rrggbb, else what was given."""
    return COLORS.get(color.casefold(), color)


def role_of_name(name: str) -> str:
    """The role that the name of a layer tells, or ""."""
    tokens = re.findall(r"[^\W\d_]+", name.casefold())
    for role, words in WORDS.items():
        if any(token.startswith(word) or token.endswith(word) for token in tokens for word in words):
            return role
    return ""


def listing(curves: Sequence[Curve]) -> str:
    """Layers and colours with their numbers of curves, for messages."""
    parts = []
    for kind, names in (("layer", [c.layer for c in curves]), ("colour", [c.color for c in curves])):
        parts += [f"{kind} {name!r} ({number})" for name, number in Counter(filter(None, names)).most_common(12)]
    return ", ".join(parts) or "neither layers nor colours"


@dataclass(frozen=True, eq=False)
class Drawing:
    """What was read from a drawing.

    Attributes
    ----------
    outline : shapely Polygon
        The sheet; closed curves inside the outline on its own layer are its holes.
    cuts : tuple of shapely LineString and Polygon
        Open cuts are slits, closed ones are holes.
    folds : tuple of shapely LineString
        Lines to be folded; they are not cut.
    unit : str
        Unit of length of the coordinates, "" where it is not known.
    notes : tuple of str
        What was read, joined, dropped and assumed.
    """

    outline: Any
    cuts: tuple[Any, ...]
    folds: tuple[Any, ...] = ()
    unit: str = ""
    notes: tuple[str, ...] = field(default=(), repr=False)

    @property
    def report(self) -> str:
        """The notes as text."""
        return "\n".join(self.notes)

    def sheet(self, thickness: float | None = None, material: Material | None = None) -> Sheet:
        """The drawing as a sheet, ready to be meshed.

        Parameters
        ----------
        thickness : float, optional
            Thickness [length, in the unit of the coordinates].
        material : Material, optional
            Its material.
        """
        from kirigami.geometry.sheet import Sheet

        return Sheet(self.outline, self.cuts, thickness=thickness, material=material)


def scale_of(unit: str, drawn_in: str | None, stated: str | None, notes: list[str]) -> tuple[float, str]:
    """Factor from drawn numbers to the wanted unit, and the unit of the result; says what it assumes."""
    if drawn_in is None and stated is None:
        warnings.warn(
            f"the drawing names no unit: its numbers are taken as {unit}; "
            'say drawn_in="mm" (or what they are) to convert them',
            KirigamiWarning,
            stacklevel=3,
        )
        notes.append(f"no unit in the drawing: numbers taken as {unit}")
        return 1.0, unit
    source = drawn_in or stated or unit
    notes.append(f"drawn in {source}, converted to {unit}")
    ratio = metres_per(source) / metres_per(unit)
    return (float(round(ratio)) if abs(ratio - round(ratio)) < 1e-12 * ratio else ratio), unit


def scaled(points: Floats, factor: float) -> Floats:
    """Points times a factor, dividing by whole numbers where that rounds less (mm to m)."""
    inverse = round(1 / factor)
    return points / inverse if factor < 1 and abs(inverse * factor - 1) < 1e-12 else points * factor


def assemble(
    curves: Sequence[Curve], roles: Roles, *, unit: str, tolerance: float, notes: Sequence[str] = ()
) -> Drawing:
    """Sort curves by role, drop duplicates, close open ends, and check the outline.

    Parameters
    ----------
    curves : sequence of Curve
        All that was drawn, in the unit of the result.
    roles : Roles
        Which layers or colours are what.
    unit : str
        Unit of the coordinates.
    tolerance : float
        Ends that lie closer are joined, and curves that lie closer all along are one; as a fraction of the size.
    notes : sequence of str
        What the reader has noted so far.

    Raises
    ------
    GeometryError
        Nothing drawn, no closed outline, several outlines, a curve that crosses itself.
    """
    said = list(notes)
    roles_of = roles.of(curves)
    kept = [(curve, role) for curve, role in zip(curves, roles_of) if role != "ignore"]
    if not kept:
        raise GeometryError(f"the drawing holds no curves to use; there are {listing(curves)}")
    for curve, _ in kept:
        if not np.isfinite(curve.points).all():
            raise GeometryError(f"{curve.source} has a coordinate that is not finite")
    everything = np.concatenate([curve.points for curve, _ in kept])
    size = float(np.ptp(everything, axis=0).max())
    if size <= 0:
        raise GeometryError("the drawing has no extent: all its points coincide")
    gap = tolerance * size
    by_layer = Counter((curve.layer or curve.color or "(no layer)", role or "cut or outline") for curve, role in kept)
    said += [f"{name}: {number} curves, read as {role}" for (name, role), number in by_layer.items()]
    kept = _without_specks(kept, gap, said)
    kept = _without_duplicates(kept, gap, said)
    groups: dict[str, list[Curve]] = {"outline": [], "cut": [], "fold": [], "": []}
    for curve, role in kept:
        groups[role].append(curve)
    if groups["outline"]:
        outline = _named_outline(chained(groups["outline"], gap, said), gap)
        cuts = chained(groups["cut"] + groups[""], gap, said)
    else:
        outline, cuts = _found_outline(chained(groups["cut"] + groups[""], gap, said), gap)
        said.append("no outline layer: the closed curve round everything else is the outline")
    shapes = [_polygon(cut) if cut.closed else shapely.LineString(cut.points) for cut in cuts]
    folds = [shapely.LineString(curve.points) for curve in chained(groups["fold"], gap, said)]
    closed = sum(cut.closed for cut in cuts)
    width, height = np.subtract(outline.bounds[2:], outline.bounds[:2])
    said.append(
        f"outline {width:.6g} x {height:.6g} {unit} with {len(outline.interiors)} holes, {len(shapes) - closed} slits, "
        f"{closed} closed cuts, {len(folds)} folds"
    )
    return Drawing(outline, tuple(shapes), tuple(folds), unit, tuple(said))


def _without_specks(kept: list[tuple[Curve, str]], gap: float, notes: list[str]) -> list[tuple[Curve, str]]:
    short = [curve for curve, _ in kept if not curve.length > 1e-3 * gap]
    if short:
        notes.append(f"{len(short)} curves without length dropped: {_few(short)}")
    dropped = set(map(id, short))
    return [(curve, role) for curve, role in kept if id(curve) not in dropped]


def _without_duplicates(kept: list[tuple[Curve, str]], gap: float, notes: list[str]) -> list[tuple[Curve, str]]:
    """Drop curves that lie on an earlier one of the same role all along."""
    lines = np.array([shapely.LineString(curve.points) for curve, _ in kept], dtype=object)
    lengths = shapely.length(lines)
    # The middle of a closed curve depends on where it starts, its centroid does not.
    closed = np.array([curve.closed for curve, _ in kept])
    middles = np.where(closed, shapely.centroid(lines), shapely.line_interpolate_point(lines, 0.5, normalized=True))
    first, second = shapely.STRtree(middles).query(middles, predicate="dwithin", distance=gap)
    later = (first < second) & (np.abs(lengths[first] - lengths[second]) <= 4 * gap)
    dropped: dict[int, int] = {}
    for one, other in zip(first[later].tolist(), second[later].tolist()):
        same_role = kept[one][1] == kept[other][1]
        if same_role and one not in dropped and shapely.hausdorff_distance(lines[one], lines[other]) <= gap:
            dropped[other] = one
    if dropped:
        pairs = [f"{kept[other][0].source} on {kept[one][0].source}" for other, one in list(dropped.items())[:3]]
        more = f" and {len(dropped) - 3} more" if len(dropped) > 3 else ""
        text = f"{len(dropped)} curves drawn twice, dropped: {', '.join(pairs)}{more}"
        warnings.warn(text, KirigamiWarning, stacklevel=4)
        notes.append(text)
    return [item for number, item in enumerate(kept) if number not in dropped]


def chained(curves: Sequence[Curve], gap: float, notes: list[str]) -> list[Curve]:
    """Join curves end to end where exactly two ends meet within `gap`; the order is that of the first pieces."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    open_ones = [number for number, curve in enumerate(curves) if not curve.closed]
    if not open_ones:
        return list(curves)
    ends = np.array([curves[number].points[[0, -1]] for number in open_ones]).reshape(-1, 2)
    near = cKDTree(ends).query_pairs(gap, output_type="ndarray")
    graph = coo_array((np.ones(len(near), np.int8), near.T), shape=(len(ends), len(ends)))
    cluster = connected_components(graph, directed=False)[1]
    meeting: dict[int, list[int]] = {}
    for end, number in enumerate(cluster.tolist()):
        meeting.setdefault(number, []).append(end)
    partner = {}
    for members in meeting.values():
        if len(members) == 2:
            partner[members[0]], partner[members[1]] = members[1], members[0]
    # End 2 k is the first point of open curve k, end 2 k + 1 its last; end ^ 1 is the other end of the same curve.
    used: set[int] = set()
    found: dict[int, Curve] = {number: curve for number, curve in enumerate(curves) if curve.closed}
    gaps: list[float] = []
    for start in range(0, len(ends), 2):
        if start // 2 in used:
            continue
        entry, closes = start, False
        while entry in partner and not closes:  # back to the free end, or once round
            entry = partner[entry] ^ 1
            closes = entry == start
        walk = [entry]
        while (after := partner.get(walk[-1] ^ 1)) is not None and after != entry:
            walk.append(after)
        used.update(end // 2 for end in walk)
        parts = [curves[open_ones[end // 2]].points[:: -1 if end % 2 else 1] for end in walk]
        following = parts[1:] + parts[:1] if closes else parts[1:]
        gaps += [float(np.linalg.norm(a[-1] - b[0])) for a, b in zip(parts, following)]
        points = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
        if closes:
            points[-1] = points[0]
        number = open_ones[min(end // 2 for end in walk)]
        found[number] = replace(curves[number], points=points)
    real = [value for value in gaps if value > 1e-5 * gap]
    if real:
        notes.append(f"{len(real)} gaps between ends closed, the widest {max(real):.3g}")
    return [found[number] for number in sorted(found)]


def _polygon(curve: Curve) -> Any:
    polygon = shapely.Polygon(curve.points)
    if not polygon.is_valid:
        reason = shapely.is_valid_reason(polygon)
        raise GeometryError(f"{curve.source} on layer {curve.layer!r} crosses itself: {reason}")
    return polygon


def _named_outline(chains: list[Curve], gap: float) -> Any:
    for curve in chains:
        if not curve.closed:
            raise GeometryError(_open_text(curve, gap))
    shells = sorted((_polygon(curve) for curve in chains), key=lambda polygon: -polygon.area)
    outline, inner = shells[0], shells[1:]
    outside = [polygon for polygon in inner if not outline.covers(polygon)]
    if outside:
        where = ", ".join(f"x {p.bounds[0]:.6g} to {p.bounds[2]:.6g}, y {p.bounds[1]:.6g} to {p.bounds[3]:.6g}"
                          for p in [outline, *outside[:2]])  # fmt: skip
        raise GeometryError(f"{1 + len(outside)} outlines lie side by side ({where}): draw one sheet in a file")
    return shapely.Polygon(outline.exterior, [hole.exterior for hole in inner])


def _found_outline(chains: list[Curve], gap: float) -> tuple[Any, list[Curve]]:
    """The closed curve round all others, and the others."""
    everything = np.concatenate([curve.points for curve in chains])
    low, high = everything.min(axis=0) + gap, everything.max(axis=0) - gap
    for curve in chains:
        if curve.closed and (curve.points.min(axis=0) <= low).all() and (curve.points.max(axis=0) >= high).all():
            return _polygon(curve), [other for other in chains if other is not curve]
    largest = max(chains, key=lambda curve: float(np.ptp(curve.points, axis=0).prod()))
    hint = _open_text(largest, gap) if not largest.closed else f"the largest closed curve is {largest.source}"
    raise GeometryError(f"no closed curve lies round all the others, so there is no outline; {hint}")


def _open_text(curve: Curve, gap: float) -> str:
    (x0, y0), (x1, y1) = curve.points[0], curve.points[-1]
    distance = float(np.hypot(x1 - x0, y1 - y0))
    return (
        f"the outline is open: from {curve.source}, layer {curve.layer!r}, it ends at ({x0:.6g}, {y0:.6g}) and "
        f"({x1:.6g}, {y1:.6g}), a gap of {distance:.3g}; ends closer than {gap:.3g} are joined, see `tolerance`"
    )


def _few(curves: Sequence[Curve]) -> str:
    return ", ".join(curve.source for curve in curves[:3]) + (" ..." if len(curves) > 3 else "")


def flattened(position: Any, flatness: float) -> Floats:
    """Points along a smooth curve ``position(t)``, t in [0, 1] -> (k, 2), with chords nearer to it than `flatness`."""
    t = np.linspace(0.0, 1.0, 9)
    for _ in range(12):
        points, middles = position(t), position(0.5 * (t[1:] + t[:-1]))
        chord = points[1:] - points[:-1]
        length = np.maximum(np.linalg.norm(chord, axis=1), 1e-300)
        off = middles - points[:-1]
        height = np.abs(chord[:, 0] * off[:, 1] - chord[:, 1] * off[:, 0]) / length
        rough = height > flatness
        if not rough.any():
            break
        t = np.sort(np.concatenate([t, 0.5 * (t[1:] + t[:-1])[rough]]))
    return np.asarray(position(t), dtype=float)


def layered(sheet: Any, folds: Iterable[Any] = ()) -> Iterator[tuple[str, Floats, bool]]:
    """Layer, points (closed curves without the repeated point) and closedness of every line of a sheet."""
    rings = [sheet.outline.exterior, *sheet.outline.interiors]
    lines = [("OUTLINE", ring) for ring in rings]
    lines += [("CUTS", line) for cut in sheet.cuts for line in _lines_of(cut)]
    lines += [("FOLDS", line) for fold in [*getattr(sheet, "folds", ()), *folds] for line in _lines_of(fold)]
    for layer, line in lines:
        points = shapely.get_coordinates(line)
        closed = len(points) > 3 and bool((points[0] == points[-1]).all())
        yield layer, points[:-1] if closed else points, closed


def _lines_of(geometry: Any) -> Iterator[Any]:
    if isinstance(geometry, shapely.Polygon):
        yield from (geometry.exterior, *geometry.interiors)
    elif hasattr(geometry, "geoms"):
        for part in geometry.geoms:
            yield from _lines_of(part)
    else:
        yield geometry
