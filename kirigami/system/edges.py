"""What constraints on nodes mean for the edges between them: shell facets have unknowns there.

An edge is held with its ends where it lies on the boundary of the sheet, or where all facets on it are held. It then
keeps its shape along the axes held; a clamp keeps its angles, so that the sheet keeps its slope there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kirigami.geometry.topology import edges_within
from kirigami.model.constraints import Constraint
from kirigami.primitives.node import AXES
from kirigami.primitives.rows import EdgeRows

Index = NDArray[np.int64]


def held_middles(edges: EdgeRows, item: Constraint, nodes: Index, leaders: Index, dim: int) -> Index:
    """Numbers of the unknowns of edges' middles that a constraint on `nodes` holds at their rest value."""
    ahead = np.full(int(edges.ends.max()) + 1, -1)
    inside = np.isin(np.arange(len(ahead)), nodes)
    held = edges_within(edges.edge, edges.ends, inside)
    if len(leaders):  # an edge keeps its shape where both ends follow the same node
        known = nodes < len(ahead)
        ahead[nodes[known]] = leaders[known]
        held &= ahead[edges.ends[:, 0]] == ahead[edges.ends[:, 1]]
    axes = [AXES.index(axis) for axis in item.values]
    return np.asarray((edges.middle[held][:, None] * dim + axes).ravel())


def held_angles(edges: EdgeRows, nodes: Index, dim: int) -> Index:
    """Numbers of the unknown angles of edges that a clamp of `nodes` holds."""
    inside = np.isin(np.arange(int(edges.ends.max()) + 1), nodes)
    edge, row = edges.pairs
    held = row[edges_within(edges.edge, edges.ends, inside)[edge]]
    return np.asarray((held[:, None] * dim + np.arange(2)).ravel())
