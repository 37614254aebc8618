"""The rest state of shell facets: how their edges bulge, where their directors stand, which way angles count."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.shell_bending import EdgeFrames
from kirigami.elements.shell_geometry import EDGE_OF_POINT, Chart
from kirigami.primitives.kernel import Array


def angle_scale(chart: Chart, forward: NDArray[np.bool_]) -> Array:
    """Factors (6, n) from the stored numbers of the edges' angles, which are lengths, to local angles."""
    signed = np.where(forward, 1.0, -1.0) / chart.length
    return np.asarray(signed[:, EDGE_OF_POINT].T)


def initial_directors(
    frames: EdgeFrames, edge: NDArray[np.int64], stored: NDArray[np.int64], count: int
) -> Array:
    """Directors (count, 2, 3) of the edges: the mean of the normals of the facets on them."""
    total = np.zeros((count, 2, 3))
    np.add.at(total, (edge, stored), frames.normal.transpose(0, 2, 1))
    return np.asarray(total / np.linalg.norm(total, axis=2, keepdims=True))


def bulges(ends: Array, normals: Array) -> Array:
    """Offsets (n, 3) of the middles of edges from the mean of their `ends` (n, 2, 3), given the normals (n, 2, 3)
    there: the arc of a circle through both ends, to the angle between the slopes."""
    chord = ends[:, 1] - ends[:, 0]
    square = (chord**2).sum(axis=1)
    up = normals.sum(axis=1)
    up -= ((up * chord).sum(axis=1) / square)[:, None] * chord
    up /= np.linalg.norm(up, axis=1)[:, None]
    length = np.sqrt(square)
    along = np.einsum("nka,na->nk", normals, chord) / length[:, None]
    slope = np.arctan2(-along, np.einsum("nka,na->nk", normals, up))
    return np.asarray((0.5 * length * np.tan(0.25 * (slope[:, 0] - slope[:, 1])))[:, None] * up)
