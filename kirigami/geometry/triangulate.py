"""The mesh generators behind one function: planar line work in, triangles out.

There are two. "triangle" is Jonathan Shewchuk's Triangle (`kirigami.geometry.shewchuk`), quick and proven, but not free
to be sold on; "delaunay" is this package's own (`kirigami.geometry.delaunay` and `ruppert`). Both get line work from
`kirigami.geometry.noding` only, and what is void is removed here.
"""

from __future__ import annotations

import importlib.util
import os
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import GeometryError
from kirigami.geometry.topology import boundary_pairs, pair_numbers, within
from kirigami.primitives.checks import require_choice

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

MESHERS = ("triangle", "delaunay")


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Points (n, 2), triangles (m, 3), and the pieces (s, 2) of the given segments with the marker of each."""

    points: Floats
    triangles: Integers
    segments: Integers
    markers: Integers


def chosen_mesher(name: str | None = None) -> str:
    """The mesh generator that a name stands for: without one what the environment variable KIRIGAMI_MESHER says, else
    Triangle where it is installed.

    >>> from kirigami.geometry.triangulate import chosen_mesher
    >>> chosen_mesher("delaunay")
    'delaunay'
    """
    there = importlib.util.find_spec("triangle") is not None
    wanted: str | None = name if name is not None else os.environ.get("KIRIGAMI_MESHER") or None
    if wanted is None:
        return "triangle" if there else "delaunay"
    wanted = require_choice(wanted, MESHERS, "mesher", "Sheet.mesh", GeometryError)
    if wanted == "triangle" and not there:
        raise GeometryError('mesher "triangle" needs the package triangle: pip install triangle, or use "delaunay"')
    return wanted


def triangulate(
    start: Triangulation,
    mesher: str,
    *,
    min_angle: float = 0.0,
    max_areas: Floats | None = None,
    max_new_points: int | None = None,
) -> Triangulation:
    """Constrained Delaunay triangulation of all that segments enclose, or the refinement of a triangulation.

    Parameters
    ----------
    start : Triangulation
        Points and segments; with triangles, these are refined and nothing grows beyond them.
    mesher : str
        "triangle" or "delaunay".
    min_angle : float
        Smallest angle in degrees; 0 adds no points. Termination is proved up to 20.7 and usual up to about 33.
    max_areas : ndarray, shape (m,), optional
        Largest area into which each triangle of ``start`` is to be refined; -1 for no limit.
    max_new_points : int, optional
        Stop refining after so many new points, whatever the angles.

    Examples
    --------
    >>> import numpy as np
    >>> from kirigami.geometry.triangulate import MESHERS, Triangulation, triangulate
    >>> corners = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    >>> nothing = np.empty((0, 3), dtype=int)
    >>> sides = np.array([(0, 1), (1, 2), (2, 0)])
    >>> for mesher in MESHERS:
    ...     triangulate(Triangulation(corners, nothing, sides, np.zeros(3, int)), mesher).triangles.tolist()
    [[0, 1, 2]]
    [[0, 1, 2]]
    """
    if mesher == "triangle":
        from kirigami.geometry.shewchuk import triangulated

        return triangulated(start, min_angle, max_areas, max_new_points)
    if len(start.triangles):
        return _refined(start, min_angle, max_areas, max_new_points)
    from kirigami.geometry.delaunay import constrained

    triangles, chains = constrained(start.points, start.segments)
    pieces = np.array([pair for chain in chains for pair in pairwise(chain)], np.int64).reshape(-1, 2)
    markers = np.repeat(start.markers, [len(chain) - 1 for chain in chains])
    return Triangulation(start.points, triangles, pieces, markers)


def _refined(
    start: Triangulation, min_angle: float, max_areas: Floats | None, max_new_points: int | None
) -> Triangulation:
    """The same by the mesh generator of this package; what bounds the triangles is not crossed."""
    from kirigami.geometry.ruppert import refine

    count = len(start.points)
    rim = boundary_pairs(start.triangles)
    inner = pair_numbers(start.segments, rim, count) < 0
    drawn = pair_numbers(rim, start.segments, count)
    markers = np.concatenate([start.markers[inner], np.where(drawn >= 0, start.markers[drawn], -1)])
    segments = np.concatenate([start.segments[inner], rim])
    is_rim = np.arange(len(segments)) >= inner.sum()
    most = np.inf if max_new_points is None else max_new_points
    limits = None if max_areas is None else np.where(max_areas < 0, np.inf, max_areas)
    made = refine(start.points, start.triangles, segments, is_rim, min_angle, limits, most)
    markers = markers[made.origin]
    return Triangulation(made.points, made.triangles, made.segments[markers >= 0], markers[markers >= 0])


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
    >>> import numpy as np
    >>> from kirigami.geometry.triangulate import Triangulation, carve, triangulate
    >>> corners = np.array([(0.0, 0.0), (4.0, 0.0), (1.0, 1.0), (0.0, 4.0)])
    >>> sides = np.array([(0, 1), (1, 2), (2, 3), (3, 0)])
    >>> hull = triangulate(Triangulation(corners, np.empty((0, 3), dtype=int), sides, np.zeros(4, int)), "delaunay")
    >>> len(hull.triangles), len(carve(hull, sides).triangles)
    (3, 2)
    """
    kept = within(hull.triangles, hull.segments, boundary)
    return Triangulation(hull.points, kept, hull.segments, hull.markers)
