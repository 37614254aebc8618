"""Jonathan Shewchuk's Triangle, by way of the package `triangle`: the only file that knows it.

Triangle ends the whole process on a repeated point, and on some points that mark a hole, and silently returns nonsense
for coordinates that are not finite. It may not be sold or put into what is sold without its author's consent.
"""

from __future__ import annotations

import numpy as np
import triangle as shewchuk
from numpy.typing import NDArray

from kirigami.geometry.triangulate import Triangulation

Floats = NDArray[np.float64]

FIRST_MARKER = 2  # Triangle marks unnamed boundaries with 0 and 1


def triangulated(
    start: Triangulation, min_angle: float, max_areas: Floats | None, max_new_points: int | None
) -> Triangulation:
    """What `kirigami.geometry.triangulate.triangulate` says, of the convex hull of the segments."""
    data = {
        "vertices": np.ascontiguousarray(start.points, dtype=float),
        "segments": np.ascontiguousarray(start.segments, dtype=np.int32),
        "segment_markers": np.ascontiguousarray(start.markers + FIRST_MARKER, dtype=np.int32).reshape(-1, 1),
    }
    switches = "pQ"
    if len(start.triangles):
        switches += "r"
        data["triangles"] = np.ascontiguousarray(start.triangles, dtype=np.int32)
    else:
        switches += "c"
    if min_angle > 0:
        switches += f"q{min_angle:.6f}"
    if max_areas is not None:
        switches += "a"
        data["triangle_max_area"] = np.ascontiguousarray(max_areas, dtype=float).reshape(-1, 1)
    if max_new_points is not None:
        switches += f"S{max_new_points:d}"
    made = shewchuk.triangulate(data, switches)
    markers = made["segment_markers"].astype(np.int64).ravel() - FIRST_MARKER
    drawn = markers >= 0  # the others are edges of the convex hull
    return Triangulation(
        made["vertices"],
        made["triangles"].astype(np.int64).reshape(-1, 3),
        made["segments"].astype(np.int64).reshape(-1, 2)[drawn],
        markers[drawn],
    )
