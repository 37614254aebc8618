"""Which nodes of a model meet conditions on place, boundary and number."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import GeometryError, ModelError
from kirigami.primitives.checks import require_array, require_callable, require_text, require_whole_array, shown
from kirigami.primitives.kernel import Array

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh


def selected(
    x: Array,
    mesh: TriMesh | None,
    box: Sequence[float] | None,
    where: Callable[[Array, Array, Array], ArrayLike] | None,
    boundary: str | None,
    index: ArrayLike | None,
) -> NDArray[np.int64]:
    """Indices of the nodes at `x` (n, 3) that meet every condition given; see :meth:`kirigami.Model.select`."""
    if box is None and where is None and boundary is None and index is None:
        raise ModelError("select: give at least one of box, where, boundary, index")
    if not len(x):
        raise ModelError("select: the model has no nodes yet")
    chosen = np.ones(len(x), dtype=bool)
    if box is not None:
        chosen &= _inside(box, x)
    if where is not None:
        mask = np.asarray(require_callable(where, "where", "select")(x[:, 0], x[:, 1], x[:, 2]))
        if mask.shape != (len(x),) or mask.dtype != bool:
            raise ModelError("select: `where` must return one boolean for each node, such as lambda x, y, z: y > 1")
        chosen &= mask
    if boundary is not None:
        if mesh is None:
            raise ModelError("select: `boundary` needs a model made by Model.from_mesh")
        try:
            named = mesh.boundary(require_text(boundary, "boundary", "select"))
        except GeometryError as error:
            raise ModelError(f"select: {error}") from None
        chosen &= np.isin(np.arange(len(x)), named)
    if index is not None:
        wanted = require_whole_array(index, (), (None,), name="index", owner="select")
        if wanted.min() < -len(x) or wanted.max() >= len(x):
            raise ModelError(f"select: indices must be integers below {len(x)}, got {shown(index)}")
        chosen &= np.isin(np.arange(len(x)), wanted % len(x))
    found: NDArray[np.int64] = np.flatnonzero(chosen)
    if not found.size:
        low, high = x.min(axis=0), x.max(axis=0)
        raise ModelError(
            f"select: no node meets the condition; the nodes span x {low[0]:.6g} to {high[0]:.6g}, "
            f"y {low[1]:.6g} to {high[1]:.6g}, z {low[2]:.6g} to {high[2]:.6g}"
        )
    return found


def _inside(box: Sequence[float], x: Array) -> NDArray[np.bool_]:
    limits = require_array(box, name="box", owner="select", finite=False)
    if limits.shape not in ((4,), (6,)) or np.isnan(limits).any():
        raise ModelError(f"select: box must hold 4 or 6 numbers (all minima, then all maxima), got {shown(box)}")
    axes = len(limits) // 2
    slack = 1e-9 * (float(np.linalg.norm(np.ptp(x, axis=0))) or 1.0)
    part = x[:, :axes]
    inside: NDArray[np.bool_] = np.all((part >= limits[:axes] - slack) & (part <= limits[axes:] + slack), axis=1)
    return inside
