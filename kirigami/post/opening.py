"""Open area: how much of the view from above the cuts let through."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_boolean, require_items, require_whole_array

Floats = NDArray[np.float64]

PARABOLA = ((0.0, 0.0), (0.25, 0.75), (0.5, 1.0), (0.75, 0.75))  # along an edge, and how much of its bulge is there


def open_area(positions: ArrayLike, cuts: Sequence[Any], union: bool = False) -> Floats:
    """Area of the cut openings, projected on the xy plane.

    Parameters
    ----------
    positions : array_like, shape (s, n, 2 or 3) or (n, 2 or 3)
        Node positions at each of s steps [length].
    cuts : sequence of CutLoop or of integer arrays
        Node indices round each opening, counter-clockwise at rest, the first node not repeated. A cut that is open to
        the edge of the sheet runs from mouth to mouth and is closed by the chord of its mouth.
    union : bool
        False: the signed area of each cut by itself. Where one lip lies over the other, seen from above, the area
        between them counts negative, so the value varies smoothly through closure. True: the area open in any cut;
        openings that overlap each other count once, lips that overlap close the view and count nothing.

    Returns
    -------
    ndarray, shape (s, cuts), or (s,) with ``union``
        Area [length^2]; one step less a dimension if `positions` has no step axis.

    Raises
    ------
    ModelError
        Positions of the wrong shape or not finite, or a cut that names a node that is not there.

    Notes
    -----
    Shoelace formula, A = 1/2 sum (x_i y_{i+1} - x_{i+1} y_i), about the first node of each loop. Seen from above only:
    a flap that shades another opening is not taken into account.

    Examples
    --------
    >>> from kirigami.post.opening import open_area
    >>> import numpy as np
    >>> square = np.array([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)])
    >>> open_area(square, [[0, 1, 2, 3]]).tolist()
    [2.0]
    >>> open_area([square, 2 * square], [[0, 1, 2, 3], [0, 1, 2]], union=True).tolist()
    [2.0, 8.0]
    """
    shapes = (None, 2), (None, 3), (None, None, 2), (None, None, 3)
    points = require_array(positions, *shapes, name="positions", owner="open_area")
    listed = require_items(cuts, "cuts", "open_area")
    loops = [_checked_loop(cut, number, points.shape[-2]) for number, cut in enumerate(listed)]
    require_boolean(union, "union", "open_area")
    steps = points[None] if points.ndim == 2 else points
    area = areas([steps[:, loop, :2] for loop in loops], len(steps), union)
    return area[0] if points.ndim == 2 else area


def areas(loops: Sequence[Floats], steps: int, union: bool, bulges: Sequence[Floats] | None = None) -> Floats:
    """Area (s, cuts) within loops of points, each (s, k, 2), or (s,) of their union.

    `bulges`, of the shape of the loops, are the offsets of the middles of their edges, from each point to the next,
    from the mean of its ends: edges are parabolas then, and have 2/3 of bulge times chord beyond their chords.
    """
    if bulges is not None and any(part.any() for part in bulges):
        loops = [_rounded(loop, part) for loop, part in zip(loops, bulges)]
    if union:
        return np.array([_union_area([loop[step] for loop in loops]) for step in range(steps)], dtype=float)
    area = np.zeros((steps, len(loops)))
    for column, loop in enumerate(loops):
        area[:, column] = _shoelace(loop)
    return area


def _rounded(loop: Floats, bulge: Floats) -> Floats:
    """Loops (s, 4 k, 2) with three points on every edge of (s, k, 2) that bulges; 1/15 farther out than on the
    parabola, so that the polygon has the very area under it."""
    after = np.roll(loop, -1, axis=1)
    parts = [loop + along * (after - loop) + up * 16 / 15 * bulge for along, up in PARABOLA]
    found: Floats = np.stack(parts, axis=2).reshape(len(loop), -1, 2)
    return found


def _checked_loop(cut: Any, number: int, nodes: int) -> NDArray[np.int64]:
    loop = require_whole_array(getattr(cut, "loop", cut), (None,), name=f"cut {number}", owner="open_area")
    if len(loop) < 3 or loop.min() < 0 or loop.max() >= nodes:
        raise ModelError(f"open_area: cut {number} must list at least three node indices below {nodes}")
    return loop


def _shoelace(loop: Floats) -> Floats:
    """Signed area (s,) of closed loops (s, k, 2)."""
    x, y = np.moveaxis(loop - loop[:, :1], -1, 0)
    area: Floats = 0.5 * (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1)
    return area


def _union_area(loops: list[Floats]) -> float:
    from shapely import union_all

    return float(union_all([face for loop in loops for face in _open_faces(loop)]).area)


def _open_faces(loop: Floats) -> list[Any]:
    """Faces of the plane that a closed loop (k, 2) runs round counter-clockwise: the parts one can see through."""
    from shapely import LineString, Point, Polygon, get_parts, polygonize, unary_union

    whole = Polygon(loop)
    if whole.is_valid:
        return [whole] if _shoelace(loop[None])[0] > 0 else []
    ring = np.vstack([loop, loop[:1]])
    faces = get_parts(polygonize(get_parts(unary_union(LineString(ring))).tolist()))
    return [face for face in faces if _winding(Point(face.representative_point()), loop) > 0]


def _winding(point: Any, loop: Floats) -> int:
    """How often a closed loop (k, 2) runs counter-clockwise round a point that is not on it."""
    x, y = (loop - (point.x, point.y)).T
    angle = np.arctan2(y, x)
    turn = np.diff(angle, append=angle[:1])
    return int(np.rint(((turn + np.pi) % (2 * np.pi) - np.pi).sum() / (2 * np.pi)))
