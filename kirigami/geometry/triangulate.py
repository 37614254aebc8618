"""The mesh generator behind one function: planar line work in, triangles out.

This is the only file that knows Jonathan Shewchuk's Triangle, so that another generator can take its place. Triangle ends
the whole process on a repeated point and silently returns nonsense for coordinates that are not finite: call it with line
work from `kirigami.geometry.noding` only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import triangle as shewchuk
from numpy.typing import NDArray

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

FIRST_MARKER = 2  # Triangle marks unnamed boundaries with 0 and 1


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Points (n, 2), triangles (m, 3), and the pieces (s, 2) of the given segments with the marker of each."""

    points: Floats
    triangles: Integers
    segments: Integers
    markers: Integers


def triangulate(
    start: Triangulation,
    holes: Floats | None = None,
    *,
    min_angle: float = 0.0,
    max_areas: Floats | None = None,
    convex: bool = False,
    max_new_points: int | None = None,
) -> Triangulation:
    """Constrained Delaunay triangulation of segments, refined where asked.

    Parameters
    ----------
    start : Triangulation
        Points and segments; with triangles, these are refined.
    holes : ndarray, shape (h, 2), optional
        One point inside every region that is to stay empty.
    min_angle : float
        Smallest angle in degrees; 0 adds no points. Termination is proved up to 20.7 and usual up to about 33.
    max_areas : ndarray, shape (m,), optional
        Largest area into which each triangle of ``start`` is to be refined; -1 for no limit.
    convex : bool
        Triangulate the whole convex hull and not only what the segments enclose.
    max_new_points : int, optional
        Stop refining after so many new points, whatever the angles.

    Examples
    --------
    >>> corners = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    >>> nothing = np.empty((0, 3), dtype=int)
    >>> sides = np.array([(0, 1), (1, 2), (2, 0)])
    >>> triangulate(Triangulation(corners, nothing, sides, np.zeros(3, int))).triangles.tolist()
    [[0, 1, 2]]
    """
    data = {
        "vertices": np.ascontiguousarray(start.points, dtype=float),
        "segments": np.ascontiguousarray(start.segments, dtype=np.int32),
        "segment_markers": np.ascontiguousarray(start.markers + FIRST_MARKER, dtype=np.int32).reshape(-1, 1),
    }
    switches = "pQ"
    if len(start.triangles):
        switches += "r"
        data["triangles"] = np.ascontiguousarray(start.triangles, dtype=np.int32)
    if holes is not None and len(holes):
        data["holes"] = np.ascontiguousarray(holes, dtype=float)
    if min_angle > 0:
        switches += f"q{min_angle:.6f}"
    if max_areas is not None:
        switches += "a"
        data["triangle_max_area"] = np.ascontiguousarray(max_areas, dtype=float).reshape(-1, 1)
    if convex:
        switches += "c"
    if max_new_points is not None:
        switches += f"S{max_new_points:d}"
    made = shewchuk.triangulate(data, switches)
    return Triangulation(
        made["vertices"],
        made["triangles"].astype(np.int64).reshape(-1, 3),
        made["segments"].astype(np.int64).reshape(-1, 2),
        made["segment_markers"].astype(np.int64).ravel() - FIRST_MARKER,
    )
