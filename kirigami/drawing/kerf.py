"""The kerf of a cutter: where it must run so that what is left has the size that was drawn."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from scipy.spatial import cKDTree

from kirigami.drawing.arcs import ON
from kirigami.drawing.curves import Floats
from kirigami.errors import GeometryError

CORNER = 0.05  # of the kerf: how far corners of chords lie from the circle that runs beside theirs


def compensated(outline: Any, cuts: list[Any], colors: list[str], kerf: float) -> tuple[Any, list[Any], list[str]]:
    """The sheet half a kerf wider all round: its rim grows, its openings shrink; slits are cut on their lines.

    Openings that reach over the rim are notches, and become part of it.

    Raises
    ------
    GeometryError
        An opening, a hole or a notch is no wider than the kerf.
    """
    openings = [number for number, cut in enumerate(cuts) if isinstance(cut, shapely.Polygon)]
    rims = [outline.exterior, *outline.interiors]
    notches = [n for n in openings if any(shapely.intersects(cuts[n], rim) for rim in rims)]
    body = shapely.difference(outline, shapely.union_all([cuts[n] for n in notches])) if notches else outline
    body = max(shapely.get_parts(body), key=lambda part: part.area)
    grown = body.buffer(kerf / 2, join_style="mitre", mitre_limit=5.0)
    if not isinstance(grown, shapely.Polygon) or len(grown.interiors) != len(body.interiors):
        raise GeometryError(f"a hole or notch of the rim is no wider than the kerf {kerf:.6g}: say a smaller `kerf`")
    rest, kept = [], []
    for number, cut in enumerate(cuts):
        if number in notches:
            continue
        if number in openings:
            x, y = cut.representative_point().coords[0]
            cut = cut.buffer(-kerf / 2, join_style="mitre", mitre_limit=5.0)
            if cut.is_empty or not isinstance(cut, shapely.Polygon):
                raise GeometryError(
                    f"the opening at ({x:.6g}, {y:.6g}) is no wider than the kerf of {kerf:.6g}: draw it as a slit, or "
                    "say a smaller `kerf`"
                )
        rest.append(cut)
        kept.append(colors[number])
    return grown, rest, kept


def on_circles(lines: list[Floats], before: Floats, circles: Floats, kerf: float) -> tuple[Floats, list[Floats]]:
    """Some circles and those half a kerf beside them, and lines with their points put onto the latter.

    Chords that are moved aside meet a little off the place to which the point between them moves with its arc.

    Parameters
    ----------
    lines : list of ndarray, shape (k, 2)
        Moved aside.
    before : ndarray, shape (p, 2)
        All points before they were moved.
    circles : ndarray, shape (c, 3)
        Centres and radii, before.
    kerf : float
        Twice the distance.
    """
    points = np.concatenate(lines)
    tree, old = shapely.STRtree(shapely.points(points)), shapely.STRtree(shapely.points(before))
    reach = CORNER * kerf
    found = [circles]
    for x, y, radius in circles.tolist():
        on = before[old.query(shapely.Point(x, y), predicate="dwithin", distance=radius * (1 + ON))] - (x, y)
        on = on[np.abs(np.hypot(*on.T) - radius) <= ON * radius]
        for beside in (radius + kerf / 2, radius - kerf / 2):
            near = tree.query(shapely.Point(x, y), predicate="dwithin", distance=beside + reach) if beside > 0 else []
            if not len(near):
                continue
            arm = points[near] - (x, y)
            length = np.hypot(*arm.T)
            near, arm, length = (values[np.abs(length - beside) <= reach] for values in (near, arm, length))
            if not len(near):
                continue
            found.append(np.array([[x, y, beside]]))
            points[near] = (x, y) + arm * (beside / length)[:, None]
            if len(on):
                exact = (x, y) + on * (beside / radius)
                distance, which = cKDTree(exact).query(points[near])
                meant = distance <= reach
                points[near[meant]] = exact[which[meant]]
    return np.concatenate(found), np.split(points, np.cumsum([len(line) for line in lines])[:-1])
