"""The mesh generator behind one function: planar line work in, triangles out.

This is the only file that knows Jonathan Shewchuk's Triangle, so that another generator can take its place. Triangle
ends the whole process on a repeated point, and on some points that mark a hole, and silently returns nonsense for
coordinates that are not finite. So it gets line work from `kirigami.geometry.noding` only, and what is void is removed
here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import triangle as shewchuk
from numpy.typing import NDArray

from kirigami.geometry.topology import paired_half_edges

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
    *,
    min_angle: float = 0.0,
    max_areas: Floats | None = None,
    max_new_points: int | None = None,
) -> Triangulation:
    """Constrained Delaunay triangulation of the convex hull of segments, or the refinement of a triangulation.

    Parameters
    ----------
    start : Triangulation
        Points and segments; with triangles, these are refined and nothing grows beyond them.
    min_angle : float
        Smallest angle in degrees; 0 adds no points. Termination is proved up to 20.7 and usual up to about 33.
    max_areas : ndarray, shape (m,), optional
        Largest area into which each triangle of ``start`` is to be refined; -1 for no limit.
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


def carve(hull: Triangulation, boundary: Integers) -> Triangulation:
    """Keep the triangles at the left of a boundary.

    Parameters
    ----------
    hull : Triangulation
        A triangulation of the convex hull.
    boundary : ndarray of int, shape (b, 2)
        Segments between sheet and void, directed with the sheet at the left.

    Examples
    --------
    >>> corners = np.array([(0.0, 0.0), (4.0, 0.0), (1.0, 1.0), (0.0, 4.0)])
    >>> sides = np.array([(0, 1), (1, 2), (2, 3), (3, 0)])
    >>> hull = triangulate(Triangulation(corners, np.empty((0, 3), dtype=int), sides, np.zeros(4, int)))
    >>> len(hull.triangles), len(carve(hull, sides).triangles)
    (3, 2)
    """
    count = len(hull.points)
    start, end = hull.triangles.ravel(), hull.triangles[:, [1, 2, 0]].ravel()
    to_void = np.isin(start * count + end, boundary[:, 1] * count + boundary[:, 0])
    region = regions(hull.triangles, hull.segments)
    void = np.unique(region[np.flatnonzero(to_void) // 3])
    return Triangulation(hull.points, hull.triangles[~np.isin(region, void)], hull.segments, hull.markers)


def regions(triangles: Integers, barriers: Integers, among: NDArray[np.bool_] | None = None) -> Integers:
    """Number of the region of each triangle, where regions hang together across edges other than the barriers.

    With ``among``, only these triangles are linked to one another.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    first, second = paired_half_edges(triangles)
    start, end = triangles.ravel()[first], triangles[:, [1, 2, 0]].ravel()[first]
    pairs = np.sort(barriers, axis=1)
    count = int(triangles.max()) + 1
    keys = np.minimum(start, end) * count + np.maximum(start, end)
    linked = (second >= 0) & ~np.isin(keys, pairs[:, 0] * count + pairs[:, 1])
    left, right = first[linked] // 3, second[linked] // 3
    if among is not None:
        both = among[left] & among[right]
        left, right = left[both], right[both]
    shape = (len(triangles), len(triangles))
    graph = coo_array((np.ones(len(left), np.int8), (left, right)), shape=shape)
    region: Integers = connected_components(graph, directed=False)[1].astype(np.int64)
    return region
