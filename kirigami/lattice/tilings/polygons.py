"""Tilings from outlines: corners that coincide become joints."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.errors import GeometryError
from kirigami.lattice.tilings.tiling import Tiling, place_of
from kirigami.primitives.checks import require_array, require_items, require_positive
from kirigami.primitives.groups import first_of_group
from kirigami.words import counted


def from_polygons(
    polygons: Iterable[ArrayLike], joints: ArrayLike | None = None, tolerance: float | None = None
) -> Tiling:
    """A finite tiling from the outlines of its panels, joined where corners coincide.

    Parameters
    ----------
    polygons : iterable of array_like, each shape (k, 2)
        Corners of each panel, in either sense [length]; shapely polygons (without holes) may be given too.
    joints : array_like, shape (m, 2), optional
        Where panels are joined; corners that coincide elsewhere stay apart. None joins all corners that coincide.
    tolerance : float, optional
        Corners nearer than this are one [length]; None takes 1e-6 of the size.

    Raises
    ------
    GeometryError
        A joint that fewer than two panels share, or a reason given for :class:`Tiling`.

    Examples
    --------
    >>> from kirigami.lattice.tilings import from_polygons
    >>> square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    >>> print(from_polygons([square, [[1, 1], [2, 1], [2, 2]]]))
    Tiling of 2 panels with 1 joint
    """
    from scipy.spatial import cKDTree

    shapes = []
    for number, polygon in enumerate(require_items(polygons, "polygons", "from_polygons", GeometryError)):
        outline: Any = polygon
        if hasattr(outline, "exterior"):
            if len(outline.interiors):
                raise GeometryError(f"from_polygons: panel {number} has a hole; a panel is one outline")
            outline = np.array(outline.exterior.coords)[:-1, :2]
        shape = require_array(outline, (None, 2), name=f"panel {number}", owner="from_polygons", error=GeometryError)
        if len(shape) < 3:
            raise GeometryError(f"from_polygons: panel {number} must hold three or more finite points, of shape (k, 2)")
        shapes.append(shape)
    if not shapes:
        raise GeometryError("from_polygons: there are no polygons")
    points = np.concatenate(shapes)
    owner = np.repeat(np.arange(len(shapes)), [len(shape) for shape in shapes])
    near = 1e-6 * float(np.ptp(points, axis=0).max()) if tolerance is None else tolerance
    near = require_positive(near, "tolerance", "from_polygons", GeometryError)
    if joints is None:
        leader = first_of_group(len(points), cKDTree(points).query_pairs(near, output_type="ndarray"))
    else:
        leader = np.arange(len(points))
        for joint in require_array(joints, (None, 2), name="joints", owner="from_polygons", error=GeometryError):
            here = np.flatnonzero(np.linalg.norm(points - joint, axis=1) <= near)
            touched = len(set(owner[here].tolist()))
            if touched < 2:
                raise GeometryError(
                    f"from_polygons: the joint at {place_of(joint)} touches {counted(touched, 'panel')}; a joint "
                    "needs a corner of two panels there"
                )
            leader[here] = here[0]
    kept, index = np.unique(leader, return_inverse=True)
    starts = np.cumsum([0] + [len(shape) for shape in shapes])
    return Tiling(points[kept], [index[a:b].tolist() for a, b in itertools.pairwise(starts)])
