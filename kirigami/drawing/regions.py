"""Regions of a sheet that are drawn: the closed curves of a layer or colour, under its name."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any

import shapely

from kirigami.drawing.curves import Curve
from kirigami.drawing.joining import chained
from kirigami.drawing.measure import Measure
from kirigami.drawing.rim import crossing_text
from kirigami.drawing.roles import Names, color_name, listed
from kirigami.errors import GeometryError
from kirigami.words import counted


def drawn_regions(
    curves: Sequence[Curve], names: Names, gap: float, measure: Measure, said: list[str]
) -> dict[str, Any]:
    """Areas by the names asked for, out of the curves whose role is "region"; one within another is a hole of it.

    Raises
    ------
    GeometryError
        A region that is not closed, or crosses itself.
    """
    found = {}
    for name in listed(names):
        plain = color_name(name).casefold()
        own = [curve for curve in curves if plain in (curve.layer.casefold(), curve.color.casefold())]
        joined = chained(own, gap, said)
        loose = [curve for curve in joined if not curve.closed]
        if loose:
            raise GeometryError(
                f"region {name!r} is not closed, by {counted(len(loose), 'curve')}: {measure.curves(loose)}; close the "
                "border of the region, or raise `tolerance`"
            )
        areas = [shapely.Polygon(curve.points) for curve in joined]
        for curve, area in zip(joined, areas):
            if not area.is_valid:
                raise GeometryError(f"region {name!r}: {crossing_text(curve, area)}")
        found[name] = reduce(shapely.symmetric_difference, areas)
        said.append(f"region {name!r} of {counted(len(areas), 'closed curve')}")
    return found
