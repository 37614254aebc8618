"""The rim of the sheet: the outer face of the drawn lines, in however many pieces they are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.drawing.curves import Curve, lines_of
from kirigami.drawing.gaps import gap_error, open_outline
from kirigami.drawing.measure import Measure
from kirigami.drawing.network import Network, network
from kirigami.errors import GeometryError
from kirigami.words import counted

NODING = 0.02  # of the tolerance, to which ends were joined before: only rounding is left to be snapped
LARGE = 0.1  # of the largest part: a part that somebody may want
MAIN = 0.5  # of the outer face: what a single closed curve must have to be the rim, and the others cuts over it
FRAME_SHARE = 0.2  # of a frame: what the sheet in it must have
TOO_LARGE = 2.0  # times the sheet: the box of lines round it that look like an outline
FINE = 1e-9  # of the size


@dataclass(frozen=True, eq=False)
class Rim:
    """The rim of the sheet.

    Attributes
    ----------
    polygon : shapely Polygon
        The sheet without its holes.
    made_of : list of Curve
        Curves that form the rim.
    rest : list of Curve
        All others; of those that follow the rim in part, what leaves it.
    note : str
        What the user must be told.
    parts : int
        How many sheets lie side by side, of which this one may be picked.
    """

    polygon: Any
    made_of: list[Curve]
    rest: list[Curve]
    note: str = ""
    parts: int = 1


def find_rim(
    chains: Sequence[Curve],
    raw: Sequence[Curve],
    gap: float,
    measure: Measure,
    part: int | None,
    *,
    named: bool = False,
) -> Rim:
    """The rim among curves that are outline or cut.

    A closed curve that all others lie in is the rim. Else it is the outer face of the lines: where they cross at a
    corner their tails are left out, and closed curves drawn over it are cuts.

    Parameters
    ----------
    chains : sequence of Curve
        Joined end to end.
    raw : sequence of Curve
        The same before they were joined, to say where the rim is open.
    gap : float
        Ends nearer than this were joined.
    measure : Measure
        How to say places.
    part : int, optional
        Which part to take, from 1, where several lie side by side.
    named : bool
        Whether the curves were named as outline.

    Raises
    ------
    GeometryError
        There is no closed outline, or there are several.
    """
    if not chains:
        raise GeometryError("no curve can be the outline: all that was read are folds or left out; name the outline")
    closed = [(number, _polygon(curve)) for number, curve in enumerate(chains) if curve.closed]
    sound = sorted(((n, p) for n, p in closed if p.is_valid), key=lambda item: -item[1].area)
    if sound and not named:
        number, polygon = sound[0]
        rest = [curve for other, curve in enumerate(chains) if other != number]
        if _within(rest, polygon.bounds, gap):
            rim = Rim(polygon, [chains[number]], rest)
            return _without_frame(rim, raw, gap, measure, part)
    lines = network([curve.points for curve in chains], NODING * gap)
    blobs = _blobs(lines, np.arange(len(lines.pairs)))
    if not blobs:
        _refuse_crossing(closed, chains)
        raise open_outline(chains, raw, 0.0, gap, measure)
    if part is None and len(blobs) > 1 and blobs[1].area > LARGE * blobs[0].area:
        _refuse_crossing(closed, chains)
    body, parts = _picked(blobs, part, measure)
    if part is None:
        _refuse_open(lines, body, chains, raw, gap, measure)
    return replace(_rim_of(lines, body, chains, sound), parts=parts)


def _refuse_open(
    lines: Network, body: Any, chains: Sequence[Curve], raw: Sequence[Curve], gap: float, measure: Measure
) -> None:
    """Refuse to take a hole or a slot for the sheet: something larger lies round it that fails to close."""
    piece = lines.component
    ends = lines.points[lines.pairs]
    low = np.full((piece.max() + 1, 2), np.inf)
    high = -low
    np.minimum.at(low, piece, ends.min(axis=1))
    np.maximum.at(high, piece, ends.max(axis=1))
    box = np.array(body.bounds)
    round_it = ((low - gap <= box[:2]) & (high + gap >= box[2:])).all(axis=1)
    round_it &= (high - low).prod(axis=1) > TOO_LARGE * body.area
    if not round_it.any():
        return
    error = gap_error(chains, raw, body.area, gap, measure)
    own = np.unique(piece[lines.ring(body.exterior)])
    if error is None and round_it[np.setdiff1d(np.arange(len(low)), own)].any():
        error = open_outline(chains, raw, body.area, gap, measure)
    if error is not None:
        raise error


def _within(curves: Sequence[Curve], bounds: tuple[float, float, float, float], gap: float) -> bool:
    if not curves:
        return True
    box = shapely.total_bounds(lines_of(curves))
    return bool((box[:2] >= np.array(bounds[:2]) - gap).all() and (box[2:] <= np.array(bounds[2:]) + gap).all())


def _polygon(curve: Curve) -> Any:
    return shapely.Polygon(curve.points)


def _refuse_crossing(closed: list[tuple[int, Any]], chains: Sequence[Curve]) -> None:
    for number, polygon in closed:
        if not polygon.is_valid:
            raise GeometryError(crossing_text(chains[number], polygon))


def crossing_text(curve: Curve, polygon: Any) -> str:
    """That a curve crosses itself, and where."""
    return f"{curve.source} on layer {curve.layer!r} crosses itself: {shapely.is_valid_reason(polygon)}"


def _blobs(lines: Network, edges: Any) -> list[Any]:
    """Outer shapes of what some edges enclose, without holes, largest first."""
    faces = lines.faces(edges)
    if not faces:
        return []
    whole = shapely.union_all([shapely.Polygon(face.exterior) for face in faces])
    parts = [shapely.Polygon(part.exterior) for part in shapely.get_parts(whole)]
    return sorted(parts, key=lambda part: -part.area)


def _picked(blobs: list[Any], part: int | None, measure: Measure) -> tuple[Any, int]:
    """The part that is wanted, and how many may be."""
    large = [blob for blob in blobs if blob.area > LARGE * blobs[0].area]
    told = "; ".join(
        f"part {number}: {measure.box(blob.bounds)}, area {measure.area(blob.area)}"
        for number, blob in enumerate(large[:8], start=1)
    )
    if part is None and len(large) > 1:
        raise GeometryError(
            f"{counted(len(large), 'outline')} side by side ({told}): draw one sheet in a file, or take one with "
            "`part=1`"
        )
    if part is not None and len(large) > 1:
        if not 1 <= part <= len(large):
            raise GeometryError(f"there is no part {part}: {told}")
        return large[part - 1], len(large)
    return blobs[0], 1


def _rim_of(lines: Network, body: Any, chains: Sequence[Curve], sound: list[tuple[int, Any]]) -> Rim:
    """The rim round a body: one closed curve if that is most of it, else the outer face of open lines, or of all."""
    skin = lines.ring(body.exterior)
    lengths = shapely.length(lines.lines(slice(None)))
    perimeter = lengths[skin].sum()

    def fits(polygon: Any, edges: Any) -> bool:
        shared = lengths[np.intersect1d(edges, skin)].sum()
        return bool(polygon.area >= MAIN * body.area and shared >= MAIN * perimeter)

    for number, polygon in sound:
        if fits(polygon, lines.of_line(number)) and body.buffer(FINE).covers(polygon):
            return Rim(polygon, [chains[number]], [c for k, c in enumerate(chains) if k != number])
    is_open = np.array([not curve.closed for curve in chains])
    open_edges = np.unique(lines.owners[is_open[lines.owners[:, 0]], 1])
    for blob in _blobs(lines, open_edges)[:1] if len(open_edges) else []:
        edges = lines.ring(blob.exterior)
        if fits(blob, edges):
            return _from_pieces(lines, blob, edges, chains)
    return _from_pieces(lines, body, skin, chains)


def _from_pieces(lines: Network, polygon: Any, skin: NDArray[np.int64], chains: Sequence[Curve]) -> Rim:
    """The rim as a ring of edges; of curves along it, what leaves it."""
    on_skin = np.zeros(len(lines.pairs), bool)
    on_skin[skin] = True
    touching = set(lines.owners[on_skin[lines.owners[:, 1]], 0].tolist())
    made_of, rest = [], []
    for number, curve in enumerate(chains):
        if number not in touching:
            rest.append(curve)
            continue
        made_of.append(curve)
        own = lines.of_line(number)
        leaving = own[~on_skin[own]]
        if len(leaving) and not (curve.closed and len(leaving) == len(own)):
            for piece in shapely.get_parts(shapely.line_merge(shapely.multilinestrings(lines.lines(leaving)))):
                rest.append(replace(curve, points=shapely.get_coordinates(piece), bow=0.0))
    return Rim(polygon, made_of, rest)


def _without_frame(rim: Rim, raw: Sequence[Curve], gap: float, measure: Measure, part: int | None) -> Rim:
    """The sheet in a rectangle that is but the frame of a page: all else lies in one outline that it does not touch.

    Cuts in a hole would have no effect, so that nobody draws a sheet like that.
    """
    x0, y0, x1, y1 = rim.polygon.bounds
    if len(rim.rest) < 2 or abs(rim.polygon.area - (x1 - x0) * (y1 - y0)) > FINE * rim.polygon.area:
        return rim
    lines = lines_of(rim.rest)
    attached = _attached(lines, rim.polygon.exterior, gap)  # a title block
    free = [curve for curve, is_attached in zip(rim.rest, attached) if not is_attached]
    if len(free) < 2:
        return rim
    lines, block = lines[~attached], lines[attached]
    box = shapely.total_bounds(lines)
    # Of the lines inside only those near their common bounds can be the rim of a sheet that holds them all.
    ends = shapely.bounds(lines)
    outer = (np.abs(ends - box) <= gap).any(axis=1)
    pieces = network([curve.points for curve, is_outer in zip(free, outer) if is_outer], NODING * gap)
    for blob in _blobs(pieces, np.arange(len(pieces.pairs)))[:1]:
        skin = blob.buffer(gap)
        within, along = shapely.covered_by(lines, skin), shapely.covered_by(lines, skin.boundary.buffer(2 * gap))
        large = blob.area >= FRAME_SHARE * rim.polygon.area
        if within.all() and not along.all() and large and not shapely.intersects(block, blob).any():
            text = (
                f"{rim.made_of[0].called} is taken as the frame of a page and left out: all else lies within one "
                f"outline inside it, {measure.box(blob.bounds)}"
            )
            return replace(find_rim(free, raw, gap, measure, part), note=text)
    return rim


def _attached(lines: NDArray[np.object_], ring: Any, gap: float) -> NDArray[np.bool_]:
    """Which lines hang together with a ring."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    everything = np.append(lines, ring)
    pairs = shapely.STRtree(everything).query(everything, predicate="dwithin", distance=gap)
    graph = coo_array((np.ones(pairs.shape[1], np.int8), pairs), shape=(len(everything),) * 2)
    piece = connected_components(graph, directed=False)[1]
    attached: NDArray[np.bool_] = piece[:-1] == piece[-1]
    return attached


def left_out_text(curves: Sequence[Curve], used: Sequence[Curve], measure: Measure) -> str:
    """What lies outside the sheet, and the option that leaves it out in silence, if one leaves out nothing else."""
    verb = "lies" if len(curves) == 1 else "lie"
    needed = {name for curve in used for name in (curve.layer, curve.color)}
    alone = (name for curve in curves for name in (curve.layer, curve.color) if name and name not in needed)
    name = next(alone, "")
    hint = f"; `ignore={name}` leaves it out without a word" if name else ""
    return f"{counted(len(curves), 'curve')} {verb} outside the sheet, left out: {measure.curves(curves)}{hint}"
