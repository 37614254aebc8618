"""From loose curves of a drawing to an outline, cuts and folds: what all readers of drawings share."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from kirigami.drawing.arcs import circles_of
from kirigami.drawing.curves import Curve, Floats, lines_of
from kirigami.drawing.gaps import short_of
from kirigami.drawing.joining import chained, led_together, without_doubles, without_specks
from kirigami.drawing.measure import Measure
from kirigami.drawing.regions import drawn_regions
from kirigami.drawing.rim import Rim, crossing_text, find_rim, left_out_text
from kirigami.drawing.roles import Roles, Row, color_name, listing, side_of_name, table_lines, table_of
from kirigami.drawing.strokes import NONE, Ink
from kirigami.drawing.trimming import Trimmed, trimmed, without_effect, without_scrap
from kirigami.errors import GeometryError, KirigamiWarning, ModelError
from kirigami.primitives.checks import (
    require_between,
    require_finite,
    require_not_negative,
    require_whole,
    shown,
)
from kirigami.scale import Scale
from kirigami.units import metres_per, parse
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.geometry.sheet import Sheet
    from kirigami.primitives.material import Material

SIZES = 1e-3, 10.0  # metres: a sheet smaller or larger than this is likely to be in another unit


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
    fold_shares : tuple of float
        Of each fold, from -1 to 1, how far it is folded in proportion to the others: 1 a valley seen from +z, -1 a
        mountain, 0 where the drawing does not say.
    table : tuple of Row
        What each layer, colour and line type was taken for.
    left_out : tuple of shapely LineString
        What was drawn and is none of these.
    curves : tuple of Curve
        All that was drawn.
    circles : ndarray, shape (c, 3)
        Centres and radii of the circles whose arcs are among the curves, which are made of chords.
    ink : Ink
        The colours it was drawn in.
    page : tuple of float, optional
        Left, bottom, right and top of the page it was drawn on.
    regions : mapping of str to shapely Polygon or MultiPolygon
        The areas of the layers and colours that were to be regions, by these names.
    """

    outline: Any
    cuts: tuple[Any, ...]
    folds: tuple[Any, ...] = ()
    unit: str = ""
    notes: tuple[str, ...] = field(default=(), repr=False)
    table: tuple[Row, ...] = field(default=(), repr=False)
    left_out: tuple[Any, ...] = field(default=(), repr=False)
    fold_shares: tuple[float, ...] = field(default=(), repr=False)
    curves: tuple[Curve, ...] = field(default=(), repr=False)
    circles: Floats = field(default_factory=lambda: NONE, repr=False)
    ink: Ink = field(default_factory=Ink, repr=False)
    page: tuple[float, float, float, float] | None = field(default=None, repr=False)
    regions: Mapping[str, Any] = field(default_factory=dict, repr=False)

    @property
    def report(self) -> str:
        """The notes as text, and the table of roles."""
        return "\n".join([*self.notes, *table_lines(self.table)])

    @property
    def layers(self) -> dict[str, Any]:
        """What was drawn on each layer, and in each colour, by their names: closed curves as areas, others as lines."""
        found: dict[str, list[Any]] = {}
        for curve in self.curves:
            shape = shapely.Polygon(curve.points) if curve.closed else shapely.LineString(curve.points)
            for name in {curve.layer, curve.color, color_name(curve.color)} - {""}:
                found.setdefault(name, []).append(shape if shape.is_valid else shape.boundary)
        return {name: shapely.union_all(shapes) for name, shapes in found.items()}

    def sheet(
        self,
        thickness: float | None = None,
        material: Material | None = None,
        *,
        fold_stiffness: float | None = None,
        fold_angle: float = 0.0,
    ) -> Sheet:
        """The drawing as a sheet, ready to be meshed.

        Parameters
        ----------
        thickness : float, optional
            Thickness [length, in the unit of the coordinates].
        material : Material, optional
            Its material.
        fold_stiffness : float, optional
            Moment per angle and length of its folds [force / rad]; None takes that of :class:`kirigami.Fold`.
        fold_angle : float
            Angle [rad] at which the folds rest, 0 flat: valleys at this one, mountains at its negative, where the file
            holds angles in proportion to the largest. Where it tells neither of any fold all are valleys, where it
            tells of some the others rest flat.
        """
        from kirigami.geometry.fold_line import Fold
        from kirigami.geometry.sheet import Sheet

        fold_angle = require_between(fold_angle, -np.pi, np.pi, "fold_angle", "Drawing.sheet", GeometryError)
        if fold_stiffness is not None:
            require_not_negative(fold_stiffness, "fold_stiffness", "Drawing.sheet", GeometryError)
        shares = self.fold_shares if any(self.fold_shares) else (1.0,) * len(self.folds)
        folds = [Fold(line, fold_angle * share, fold_stiffness) for line, share in zip(self.folds, shares)]
        sheet = Sheet(self.outline, self.cuts, thickness, material, folds, self.regions)
        if self.unit == "m":
            xmin, ymin, xmax, ymax = sheet.bounds
            sheet.scale = Scale.of(max(xmax - xmin, ymax - ymin))
        return sheet


def assemble(
    curves: Sequence[Curve],
    roles: Roles,
    *,
    unit: str,
    tolerance: float | str,
    notes: Sequence[str] = (),
    shown: str | None = None,
    part: int | None = None,
    bounded_by_folds: bool = False,
    page: tuple[float, float, float, float] | None = None,
) -> Drawing:
    """Sort curves by role, drop doubles, close open ends, find the rim, and trim the rest to it.

    Parameters
    ----------
    curves : sequence of Curve
        All that was drawn, in the unit of the result.
    roles : Roles
        Which layers or colours are what.
    unit : str
        Unit of the coordinates.
    tolerance : float or str
        Ends that lie closer are joined, and curves that lie closer all along are one; as a fraction of the size, or a
        length with its unit ("0.1mm").
    notes : sequence of str
        What the reader has noted so far.
    shown : str, optional
        Unit in which messages give lengths and places; that of the coordinates unless given.
    part : int, optional
        Which part to take, from 1, where several lie side by side or cuts sever the sheet.
    bounded_by_folds : bool
        Where nothing else can be the outline, take the outer face of the folds.
    page : tuple of float, optional
        Left, bottom, right and top of the page.

    Raises
    ------
    GeometryError
        Nothing drawn, no closed outline, several outlines or parts, a curve that crosses itself, a tolerance that is
        no share between 0 and 1 nor a length.
    """
    if part is not None:
        part = require_whole(part, "part", "reading a drawing", 1, GeometryError)
    said = list(notes)
    roles_of = roles.of(curves)
    side = {curve.layer: side_of_name(curve.layer) for curve in curves}
    sorted_ones = [
        curve.taken_as(role, k, (curve.fold or side[curve.layer]) if role == "fold" else 0.0)
        for k, (curve, role) in enumerate(zip(curves, roles_of))
    ]
    kept = [curve for curve in sorted_ones if curve.role not in ("ignore", "region")]
    if not kept:
        raise GeometryError(f"the drawing holds no curves to use; there are {listing(curves)}")
    everything = np.concatenate([curve.points for curve in kept])
    if not np.isfinite(everything).all():
        bad = next(curve for curve in kept if not np.isfinite(curve.points).all())
        raise GeometryError(f"{bad.source} has a coordinate that is not finite")
    size = float(np.ptp(everything, axis=0).max())
    if size <= 0:
        raise GeometryError("the drawing has no extent: all its points coincide")
    measure = Measure(unit, shown or unit, size)
    gap = _gap(tolerance, size, unit)
    bounded = [curve for curve in sorted_ones if curve.role == "region"]
    regions = drawn_regions(bounded, roles.regions, gap, measure, said)
    raw = without_doubles(without_specks(kept, gap, said), gap, said)
    groups = _joined(raw, gap, said)
    rim, hole_curves = _found_rim(groups, raw, gap, measure, part, bounded_by_folds, said)
    holes = [_opening(curve) for curve in hole_curves]

    cuts = trimmed([curve for curve in rim.rest if curve.role != "fold"], rim.polygon, gap)
    cuts.inside, note = roles.settle(cuts.inside, rim.made_of)
    if note:
        _tell(note, said)
    creases = [*(curve for curve in rim.rest if curve.role == "fold"), *groups["fold"]]
    folds = trimmed(creases, rim.polygon, gap)
    _tell_trimmed(cuts, "cut", rim, measure, said)
    _tell_trimmed(folds, "fold", rim, measure, said)

    openings = {id(curve): _opening(curve) for curve in cuts.inside if curve.closed}
    slits = [curve for curve in cuts.inside if not curve.closed]
    slits, in_vain = without_effect(slits, [*holes, *openings.values()])
    if in_vain:
        _tell(
            f"{counted(len(in_vain), 'slit')} in an opening, without effect, left out: {measure.curves(in_vain)}; if "
            "what lies round the opening is but a frame, leave it out by `ignore` or name the `outline`",
            said,
        )
    whole = without_scrap(rim.polygon, slits, [*holes, *openings.values()], gap, measure, part)
    if part is not None and part > max(rim.parts, whole.parts):
        raise GeometryError(f"there is no part {part}: the drawing is of one sheet that no cut severs")
    for note in whole.notes:
        _tell(note, said)
    left: dict[tuple[int, ...], list[Any]] = {}
    for slit, line in zip(whole.slits, lines_of(whole.slits)):
        left.setdefault(slit.numbers, []).append(line)
    shapes: list[Any] = []
    colors: list[str] = []
    for curve in cuts.inside:
        if not curve.closed:
            shapes += left.pop(curve.numbers, [])
        elif whole.bounded_by(openings[id(curve)], gap):
            shapes.append(openings[id(curve)])
        colors += [curve.color] * (len(shapes) - len(colors))
    inner = [(hole, curve.color) for hole, curve in zip(holes, hole_curves) if whole.bounded_by(hole, gap)]
    holes, hole_colors = [hole for hole, _ in inner], tuple(color for _, color in inner)
    outline = _with_holes(whole.rim, holes)
    shapes += whole.openings if outline.interiors or not holes else [*whole.openings, *holes]
    ink = Ink(rim.made_of[0].color, hole_colors, tuple(colors), tuple(curve.color for curve in folds.inside))
    rings = [outline.exterior, *outline.interiors, *(s.exterior for s in shapes if isinstance(s, shapely.Polygon))]
    for note in short_of(whole.slits, rings, gap, measure):
        _tell(note, said)
    _doubt_size(outline, unit, said)
    closed = sum(isinstance(shape, shapely.Polygon) for shape in shapes)
    said.append(
        f"outline {measure.extent(outline.bounds)} with {counted(len(outline.interiors), 'hole')}, "
        f"{counted(len(shapes) - closed, 'slit')}, {counted(closed, 'closed cut')}, "
        f"{counted(len(folds.inside), 'fold')}"
    )
    became = {number: "outline" for curve in rim.made_of for number in curve.numbers}
    became |= {number: "hole" for curve in hole_curves for number in curve.numbers if number not in became}
    vain = set(map(id, in_vain))
    kept_cuts = [curve for curve in cuts.inside if id(curve) not in vain]
    became |= {number: "cut" for curve in kept_cuts for number in curve.numbers if number not in became}
    became |= {number: "fold" for curve in folds.inside for number in curve.numbers if number not in became}
    became |= {number: "region" for curve in bounded for number in curve.numbers}
    table = table_of(sorted_ones, became)
    fold_lines = tuple(shapely.LineString(curve.points) for curve in folds.inside)
    largest = max((abs(curve.fold) for curve in folds.inside), default=0.0) or 1.0
    shares = tuple(curve.fold / largest for curve in folds.inside)
    others = [curve for number, curve in enumerate(sorted_ones) if number not in became]
    left_out = tuple(lines_of(others))
    return Drawing(
        outline, tuple(shapes), fold_lines, unit, tuple(said), table, left_out, shares, tuple(sorted_ones),
        circles_of(kept), ink, page, regions,
    )  # fmt: skip


def _gap(tolerance: float | str, size: float, unit: str) -> float:
    """The length within which ends are joined."""
    wrong = f"tolerance must be a share of the size between 0 and 1, or a length such as 0.1mm, not {shown(tolerance)}"
    if isinstance(tolerance, str):
        try:
            share = parse(tolerance, "length") / metres_per(unit) / size
        except ModelError:
            raise GeometryError(wrong) from None
    else:
        share = require_finite(tolerance, "tolerance", "reading a drawing", GeometryError)
    if not 0 < share < 1:
        raise GeometryError(wrong)
    return share * size


def _joined(raw: Sequence[Curve], gap: float, said: list[str]) -> dict[str, list[Curve]]:
    """Curves joined end to end within their group, outline, loose ones and folds, and then led onto one another."""
    groups = {
        "outline": [curve for curve in raw if curve.role == "outline"],
        "loose": [curve for role in ("cut", "") for curve in raw if curve.role == role],
    }
    for curve in raw:  # a mountain and a valley that meet stay two
        if curve.role == "fold":
            groups.setdefault(f"fold {curve.fold}", []).append(curve)
    chains = {name: chained(curves, gap, said) for name, curves in groups.items()}
    chains = {name: chains[name] for name in ("outline", "loose")} | {
        "fold": [curve for name, curves in chains.items() if name.startswith("fold") for curve in curves]
    }
    led = iter(led_together([curve for curves in chains.values() for curve in curves], gap, said))
    return {name: [next(led) for _ in curves] for name, curves in chains.items()}


def _found_rim(
    groups: dict[str, list[Curve]],
    raw: Sequence[Curve],
    gap: float,
    measure: Measure,
    part: int | None,
    bounded_by_folds: bool,
    said: list[str],
) -> tuple[Rim, list[Curve]]:
    """The rim, with all other curves that are cuts or nothing yet, and the holes that belong to the outline."""
    loose, named = groups["loose"], groups["outline"]
    raw_loose = [curve for curve in raw if curve.role in ("cut", "")]
    if named:
        raw_named = [curve for curve in raw if curve.role == "outline"]
        try:
            rim = find_rim(named, raw_named, gap, measure, part, named=True)
        except GeometryError:
            # Perhaps cuts close it: a rim that is broken at the mouths of slots.
            both = chained(named + loose, gap, [])
            wanted = 0.5 * sum(curve.length for curve in named)
            with suppress(GeometryError):
                rim = find_rim(both, [*raw_named, *raw_loose], gap, measure, part, named=True)
                wanted -= sum(curve.length for curve in rim.made_of if curve.role == "outline")
            if wanted > 0:
                raise
            said.append("the outline is closed by cuts that meet it")
            loose = []
        covered = rim.polygon.buffer(gap)
        inner = [curve for curve in rim.rest if curve.closed and curve.role == "outline"]
        holes = [curve for curve in inner if covered.covers(_opening(curve))]
        own = [curve for curve in rim.rest if not (curve.closed and curve.role == "outline")]
        return replace(rim, rest=[*own, *loose]), holes
    if not loose and bounded_by_folds:
        folds, groups["fold"] = groups["fold"], []
        said.append("no edge bounds the sheet: the outer face of the folds is the outline")
        return find_rim(folds, [curve for curve in raw if curve.role == "fold"], gap, measure, part), []
    rim = find_rim(loose, raw_loose, gap, measure, part)
    how = "the closed curve" if len(rim.made_of) == 1 else "the outer face of the lines"
    said.append(f"no outline layer: {how} round everything else is the outline")
    if rim.note:
        _tell(rim.note, said)
    return rim, []


def _with_holes(rim: Any, holes: Sequence[Any]) -> Any:
    """The outline with its holes, or without them where they touch it or one another: then they are cuts."""
    outline = shapely.Polygon(rim.exterior, [hole.exterior for hole in holes])
    return outline if outline.is_valid else rim


def _opening(curve: Curve) -> Any:
    polygon = shapely.Polygon(curve.points)
    if not polygon.is_valid:
        raise GeometryError(crossing_text(curve, polygon))
    return polygon


def _tell(text: str, said: list[str]) -> None:
    warnings.warn(text, KirigamiWarning, stacklevel=5)
    said.append(text)


def _tell_trimmed(found: Trimmed, what: str, rim: Rim, measure: Measure, said: list[str]) -> None:
    """Say what was trimmed and left out."""
    of_rim = {number for curve in rim.made_of for number in curve.numbers}
    tails = [curve for curve in found.outside if of_rim & set(curve.numbers)]
    others = [curve for curve in found.outside if not of_rim & set(curve.numbers)]
    if tails:
        longest = measure.length(max(curve.length for curve in tails))
        said.append(
            f"{counted(len(tails), 'tail')} of the outline beyond its corners left out, the longest {longest}: "
            f"{measure.curves(tails, 2)}"
        )
    if others:
        _tell(left_out_text(others, [*rim.made_of, *found.inside], measure), said)
    if found.shortened:
        number = counted(len(found.shortened), what)
        _tell(f"{number} drawn beyond the rim and trimmed to it: {measure.curves(found.shortened)}", said)
    if found.notches:
        number = counted(len(found.notches), "closed cut")
        _tell(f"{number} over the rim, taken as notches: {measure.curves(found.notches)}", said)
    if found.along:
        number = counted(len(found.along), what)
        _tell(f"{number} drawn along the rim again, left out: {measure.curves(found.along)}", said)


def _doubt_size(outline: Any, unit: str, said: list[str]) -> None:
    size = max(np.subtract(outline.bounds[2:], outline.bounds[:2]).tolist()) * metres_per(unit)
    if not SIZES[0] <= size <= SIZES[1]:
        _tell(
            f"the sheet measures {size:.6g} m: is the unit of the drawing right? Say `drawn_in='mm'`, or what it is",
            said,
        )
