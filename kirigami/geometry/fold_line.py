"""Folds of a sheet: lines along which it is creased, and the edges of a mesh that lie on them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import GeometryError
from kirigami.primitives.checks import require_finite, require_not_negative, require_whole_array, shown

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False, init=False)
class Fold:
    """A line along which a sheet is creased and not cut.

    Parameters
    ----------
    line : shapely LineString or LinearRing, or sequence of (x, y)
        Where it runs.
    angle : float
        Angle [rad] between its two sides at which it makes no moment: 0 is flat, positive a valley seen from +z,
        negative a mountain.
    stiffness : float, optional
        Moment per angle and length [force / rad]; 0 is a free hinge. None takes that of a strip of the sheet which is
        a hundred thicknesses wide, D / (100 t) with D = E t^3 / (12 (1 - nu^2)): a light score.

    Raises
    ------
    GeometryError
        No line, an angle beyond half a turn, a negative stiffness.

    Examples
    --------
    >>> import shapely, kirigami as kg
    >>> kg.Sheet(shapely.box(0, 0, 2, 1), folds=kg.Fold([(1, 0), (1, 1)], angle=0.5))
    Sheet(2 x 1, area 2, 0 slits, 0 openings, 1 fold)
    """

    line: Any
    angle: float
    stiffness: float | None

    def __init__(self, line: Any, angle: float = 0.0, stiffness: float | None = None) -> None:
        object.__setattr__(self, "line", _checked_line(line))
        angle, stiffness = _checked(angle, stiffness, "Fold")
        object.__setattr__(self, "angle", angle)
        object.__setattr__(self, "stiffness", stiffness)


@dataclass(frozen=True, eq=False, init=False)
class FoldEdges:
    """One fold in a mesh.

    Parameters
    ----------
    edges : array_like of int, shape (k, 2)
        Nodes at the ends of the edges of the mesh along the fold, in any order.
    angle, stiffness
        As those of :class:`kirigami.Fold`.

    Raises
    ------
    GeometryError
        Edges that are no pairs of nodes, an angle beyond half a turn, a negative stiffness.

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)], folds=[kg.FoldEdges([(0, 2)])])
    >>> mesh.folds[0].edges.tolist()
    [[0, 2]]
    """

    edges: Integers
    angle: float
    stiffness: float | None

    def __init__(self, edges: ArrayLike, angle: float = 0.0, stiffness: float | None = None) -> None:
        pairs = require_whole_array(edges, (None, 2), name="edges", owner="FoldEdges", error=GeometryError)
        pairs.setflags(write=False)
        object.__setattr__(self, "edges", pairs)
        angle, stiffness = _checked(angle, stiffness, "FoldEdges")
        object.__setattr__(self, "angle", angle)
        object.__setattr__(self, "stiffness", stiffness)


def _checked_line(line: Any) -> Any:
    import shapely  # here, so that meshes made elsewhere need numpy only

    if isinstance(line, shapely.Polygon):
        line = line.exterior
    if not isinstance(line, shapely.LineString):
        from kirigami.geometry.given import is_coordinates

        if not is_coordinates(line) or len(line) < 2:
            raise GeometryError(f"Fold: line must be a LineString or at least two (x, y) pairs, got {shown(line)}")
        line = shapely.LineString(np.asarray(line, dtype=float))
    points = shapely.get_coordinates(line)
    if not np.isfinite(points).all():
        raise GeometryError("Fold: line has a coordinate that is not finite")
    if len(points) < 2 or not np.ptp(points, axis=0).max() > 0:
        raise GeometryError("Fold: line has no length")
    return line


def _checked(angle: Any, stiffness: Any, owner: str) -> tuple[float, float | None]:
    angle = require_finite(angle, "angle", owner, GeometryError)
    if abs(angle) > math.pi:
        raise GeometryError(f"{owner}: angle must lie between -pi and pi, got {angle:.6g}; it is in radians")
    return angle, None if stiffness is None else require_not_negative(stiffness, "stiffness", owner, GeometryError)
