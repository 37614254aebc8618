"""Between sheets and tilings: narrow ligaments become joints, and joints become ligaments."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import shapely

from kirigami.errors import GeometryError
from kirigami.lattice.tilings.polygons import from_polygons
from kirigami.lattice.tilings.tiling import Tiling, place_of
from kirigami.primitives.checks import require_instance, require_positive
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.geometry.sheet import Sheet


class Neck(NamedTuple):
    """A ligament found in a sheet: its free length, its width in the middle, and where it is [length]."""

    length: float
    width: float
    place: tuple[float, float]


def panels_of_sheet(sheet: Sheet | shapely.Polygon, neck: float) -> tuple[Tiling, list[Neck]]:
    """A sheet whose panels hang together by narrow ligaments, as panels and joints.

    The sheet is shrunk by half of `neck` until it falls apart, each part is grown back, and what lies between two
    panels is a ligament. A joint stands in the middle of its ligament and becomes a corner of both panels.

    Parameters
    ----------
    sheet : Sheet or shapely.Polygon
        The cut sheet; slits without width are opened by a hundredth of `neck`.
    neck : float
        Ligaments are narrower than this, panels wider everywhere [length].

    Returns
    -------
    Tiling
        The panels.
    list of Neck
        The ligaments, in the order of the tiling's joints; a slender one has the stiffness
        ``Ligament(E, thickness, neck.width, neck.length).stiffness``. Between the tips of slits a ligament has no
        length to speak of: measure or compute the stiffness of such a joint.

    Raises
    ------
    GeometryError
        The sheet does not fall apart, or a ligament joins three panels.

    Examples
    --------
    >>> import shapely
    >>> from kirigami.lattice.tilings import panels_of_sheet
    >>> sheet = shapely.union_all([shapely.box(0, 0, 4, 4), shapely.box(4, 1.9, 5, 2.1), shapely.box(5, 0, 9, 4)])
    >>> tiling, (neck,) = panels_of_sheet(sheet, neck=0.5)
    >>> print(tiling, round(neck.length, 3), round(neck.width, 3))
    Tiling of 2 panels with 1 joint 1.0 0.2
    """
    neck = require_positive(neck, "neck", "panels_of_sheet")
    region = _region(sheet, neck)
    cores = _parts(region.buffer(-neck / 2))
    if len(cores) < 2:
        raise GeometryError(f"panels_of_sheet: no ligament is narrower than neck = {neck:.6g}; nothing falls apart")
    # Grown back with sharp corners for the outlines, with round ones to find where ligaments begin.
    panels = [core.buffer(neck / 2, join_style="mitre", mitre_limit=4.0).intersection(region) for core in cores]
    rounded = [core.buffer(neck / 2, quad_segs=32).intersection(region) for core in cores]
    touch = 1e-6 * neck
    between: dict[tuple[int, ...], list[Any]] = {}
    for piece in _parts(region.difference(shapely.union_all(rounded))):
        near = tuple(k for k, panel in enumerate(rounded) if panel.distance(piece) <= touch)
        if len(near) > 2:
            raise GeometryError(
                f"panels_of_sheet: the ligament around {place_of(piece.centroid.coords[0])} joins "
                f"{counted(len(near), 'panel')}"
            )
        if len(near) == 2:  # else it is a corner that growing back did not fill
            between.setdefault(near, []).append(piece)
    joints: list[tuple[tuple[int, ...], Neck]] = []
    for near, pieces in between.items():
        # The two panels of a very short ligament meet in its middle and leave two pieces of it.
        for group in _parts(shapely.union_all([piece.buffer(neck / 3) for piece in pieces])):
            own = shapely.union_all([piece for piece in pieces if piece.intersects(group)])
            joints.append((near, _neck(region, [rounded[k].intersection(own.buffer(touch)) for k in near], neck)))
    places = np.array([found.place for _, found in joints]).reshape(-1, 2)
    outlines = [
        _outline(max(_parts(panel), key=lambda part: part.area), places[[k in near for near, _ in joints]], neck)
        for k, panel in enumerate(panels)
    ]
    tiling = from_polygons(outlines, joints=places, tolerance=touch)
    at = tiling.points[tiling.joints]
    order = [int(np.argmin(np.linalg.norm(places - point, axis=1))) for point in at]
    return tiling, [joints[k][1] for k in order]


def ligament_sheet(tiling: Tiling, width: float, length: float) -> shapely.Polygon:
    """A finite tiling as one sheet: the corners at each joint are clipped, and a straight ligament bridges them.

    Parameters
    ----------
    tiling : Tiling
        Panels of which exactly two meet at each joint.
    width, length : float
        Width of the ligaments and the length between the clipped corners [length].

    Returns
    -------
    shapely.Polygon
        Outline with holes, ready for ``kg.Sheet``; the ligaments' sides have points four to a width, so that a mesh is
        fine there.

    Raises
    ------
    GeometryError
        A periodic tiling, a joint of more than two panels, or ligaments too long or too wide for the panels.

    Examples
    --------
    >>> import kirigami as kg
    >>> sheet = kg.tilings.ligament_sheet(kg.tilings.rotating_squares(angle=1.0).patch(1, 1), width=0.05, length=0.1)
    >>> sheet.geom_type, len(sheet.interiors)
    ('Polygon', 1)
    """
    width = require_positive(width, "width", "ligament_sheet")
    length = require_positive(length, "length", "ligament_sheet")
    require_instance(tiling, Tiling, "tiling", "ligament_sheet")
    size = float(np.ptp(tiling.points, axis=0).max())
    if not (1e-9 * size < width < size and 1e-9 * size < length < size):
        raise GeometryError(
            f"ligament_sheet: width {width:g} and length {length:g} must be less than the size {size:g} of the tiling, "
            "and not vanish beside it"
        )
    if tiling.lattice is not None:
        raise GeometryError("ligament_sheet: the tiling is periodic; take a patch of it")
    panels = [shapely.Polygon(tiling.vertices[polygon]) for polygon in tiling.polygons]
    clips, bridges = [], []
    for joint in tiling.joints:
        at = tiling.vertices[joint]
        corners = [_bisector(tiling, k, joint) for k, polygon in enumerate(tiling.polygons) if joint in polygon]
        if len(corners) != 2:
            raise GeometryError(
                f"ligament_sheet: {counted(len(corners), 'panel')} meet at the joint {place_of(at)}, not two"
            )
        clips.append(shapely.Point(at).buffer(length / 2, quad_segs=8))
        along = corners[0] - corners[1]
        along /= np.linalg.norm(along)
        reach, side = (0.5 * (length + width)) * along, 0.5 * width * np.array([-along[1], along[0]])
        outline = at + np.array([reach + side, -reach + side, -reach - side, reach - side])
        bridges.append(shapely.Polygon(outline).segmentize(width / 4))
    clipped = [panel.difference(shapely.union_all(clips)) for panel in panels]
    sheet = shapely.union_all([*clipped, *bridges])
    if not isinstance(sheet, shapely.Polygon):
        raise GeometryError("ligament_sheet: the ligaments do not hold the panels together: make them shorter")
    return sheet


def _bisector(tiling: Tiling, number: int, joint: int) -> Any:
    """Unit vector from a joint into a panel."""
    polygon = tiling.polygons[number]
    at = int(np.flatnonzero(polygon == joint)[0])
    arms = tiling.vertices[polygon[[(at + 1) % len(polygon), at - 1]]] - tiling.vertices[joint]
    start, end = np.arctan2(arms[:, 1], arms[:, 0])
    middle = start + 0.5 * ((end - start) % (2 * math.pi))
    return np.array([math.cos(middle), math.sin(middle)])


def _region(sheet: Sheet | shapely.Polygon, neck: float) -> Any:
    if isinstance(sheet, shapely.Polygon):
        return sheet
    from kirigami.geometry.sheet import Sheet  # a polygon needs no mesher

    require_instance(sheet, Sheet, "sheet", "panels_of_sheet")
    region: Any = sheet.outline
    for cut in sheet.cuts:
        opening = cut if isinstance(cut, shapely.Polygon) else cut.buffer(neck / 200, cap_style="flat")
        region = region.difference(opening)
    return region


def _parts(geometry: Any) -> list[Any]:
    return [part for part in shapely.get_parts(geometry) if part.geom_type == "Polygon" and part.area > 0]


def _neck(region: Any, ends: list[Any], neck: float) -> Neck:
    """Measure a ligament between its two ends, which are pieces of the rounded panels."""
    first, second = (np.array(end.centroid.coords[0]) for end in ends)
    middle, along = 0.5 * (first + second), second - first
    across = neck * np.array([-along[1], along[0]]) / np.linalg.norm(along)
    section = shapely.LineString([middle - across, middle + across]).intersection(region)
    width = min(shapely.get_parts(section), key=lambda part: part.distance(shapely.Point(middle))).length
    # A circle as wide as `neck` enters a ligament between square shoulders by this much.
    bulge = 0.5 * (neck - math.sqrt(max(neck**2 - width**2, 0.0)))
    return Neck(ends[0].distance(ends[1]) + 2 * bulge, width, (float(middle[0]), float(middle[1])))


def _outline(panel: Any, joints: Any, neck: float) -> Any:
    """Corners of a panel, those at its ligaments replaced by the joints themselves."""
    ring = panel.simplify(0.05 * neck).exterior
    corners = [np.array(corner) for corner in ring.coords[:-1]]
    far = [corner for corner in corners if all(np.linalg.norm(corner - joint) > neck for joint in joints)]
    return np.array(sorted([*far, *joints], key=lambda point: ring.project(shapely.Point(point))))
