"""What meshes are made of, checked: nodes, facets, and numbers of both."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import GeometryError
from kirigami.geometry.topology import area_vectors, sides
from kirigami.primitives.checks import require_array, require_whole_array, shown

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]
DEGENERATE = 1e-10  # a facet with less area than this times its longest edge squared has no usable normal


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """The array itself, which cannot be changed from now on."""
    array.setflags(write=False)
    return array


def indices(which: ArrayLike, count: int, what: str, of: str) -> Integers:
    """Numbers of nodes or facets in ascending order, each once; from numbers or from one boolean for each."""
    try:
        found = np.asarray(which)
    except ValueError:
        raise GeometryError(f"{what} must be a flat list of {of} numbers, got {shown(which)}") from None
    if found.dtype == bool and found.shape == (count,):
        found = np.flatnonzero(found)
    if found.size and not np.issubdtype(found.dtype, np.integer):
        raise GeometryError(f"{what} must hold integers or one boolean per {of}, not {found.dtype}")
    found = np.unique(found).astype(np.int64)
    if found.size and not (found[0] >= 0 and found[-1] < count):
        worst = found[0] if found[0] < 0 else found[-1]
        raise GeometryError(f"{what} holds index {worst}, but the mesh has {count} {of}s")
    return read_only(found)


def checked_nodes(nodes: ArrayLike) -> Floats:
    """Nodes (n, 3) of a mesh, from two coordinates each or from three."""
    given = require_array(nodes, (None, 2), (None, 3), name="nodes", owner="TriMesh", error=GeometryError, finite=False)
    bad = np.flatnonzero(~np.isfinite(given).all(axis=1))
    if bad.size:
        raise GeometryError(f"node {bad[0]} has the coordinates {given[bad[0]]}: every coordinate must be finite")
    checked = np.zeros((len(given), 3))
    checked[:, : given.shape[1]] = given
    return checked


def checked_triangles(nodes: Floats, triangles: ArrayLike) -> Integers:
    """Facets (m, 3) that have area, each once, and leave no node over."""
    checked = require_whole_array(triangles, (None, 3), name="triangles", owner="TriMesh", error=GeometryError)

    def refuse(wrong: Any, why: str) -> None:
        if wrong.any():
            facet = int(np.flatnonzero(wrong)[0])
            raise GeometryError(f"facet {facet} with nodes {checked[facet].tolist()} {why}")

    refuse(((checked < 0) | (checked >= len(nodes))).any(axis=1), f"names a node beyond 0 .. {len(nodes) - 1}")
    refuse((checked == np.roll(checked, 1, axis=1)).any(axis=1), "names one node twice")
    longest = np.linalg.norm(sides(nodes, checked), axis=2).max(axis=1)
    area = np.linalg.norm(area_vectors(nodes, checked), axis=1)
    refuse(area <= DEGENERATE * longest**2, "has no area: its nodes lie on a line")
    ordered = np.sort(checked, axis=1)
    rank = np.lexsort(ordered.T)
    again = np.zeros(len(checked), bool)
    again[rank[1:]] = (ordered[rank[1:]] == ordered[rank[:-1]]).all(axis=1)
    refuse(again, "is given twice")
    unused = np.flatnonzero(np.bincount(checked.ravel(), minlength=len(nodes)) == 0)
    if unused.size:
        raise GeometryError(f"node {unused[0]} at {nodes[unused[0]]} and {unused.size - 1} more belong to no facet")
    return checked
