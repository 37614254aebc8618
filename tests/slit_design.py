"""A sheet with a slit inside and one from either side, as functions of their lengths and a tilt: to be designed."""

from __future__ import annotations

import numpy as np
import shapely

import kirigami as kg

BOX = shapely.box(0, 0, 0.1, 0.08)


def cuts(inner, edge, tilt=0.0):
    """A slit inside that turns, and one from either side."""
    across = 0.035 * inner * np.array([np.cos(tilt), np.sin(tilt)])
    middle = np.array([0.05, 0.025])
    return [
        shapely.LineString([middle - across, middle + across]),
        shapely.LineString([(0, 0.055), (0.03 * edge, 0.055)]),
        shapely.LineString([(0.1 - 0.03 * edge, 0.055), (0.1, 0.055)]),
    ]


def pulled(way):
    """Both ends are clamped, and the upper one is pulled."""

    def supports(m):
        top = m.select(boundary="top")
        m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=way))

    return supports
