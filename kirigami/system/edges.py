"""What constraints on nodes mean for the edges between them: shell facets have unknowns there.

An edge is held with its ends where it lies on the boundary of the sheet, or where all facets on it are held. It then
keeps its shape along the axes held; a clamp keeps its angles, so that the sheet keeps its slope there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kirigami.geometry.topology import edges_within
from kirigami.model.constraints import Constraint
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES
from kirigami.primitives.rows import EdgeRows

Index = NDArray[np.int64]

AFFINE = 1e-9  # deviation of driven nodes from an affine map, over the range of their displacements


def held_middles(
    edges: EdgeRows, item: Constraint, nodes: Index, leaders: Index, rest: Array
) -> tuple[Index, Array]:
    """Numbers of the unknowns of edges' middles that a constraint on `nodes` holds, and their changes.

    The middles go where the ends take them, which is known where the nodes move by an affine map, as a grip does. Where
    they are driven apart from each other, the sheet between them is free to follow a curve.
    """
    ahead = np.full(int(edges.ends.max()) + 1, -1)
    inside = np.isin(np.arange(len(ahead)), nodes)
    held = edges_within(edges.edge, edges.ends, inside)
    if len(leaders):  # an edge keeps its shape where both ends follow the same node
        known = nodes < len(ahead)
        ahead[nodes[known]] = leaders[known]
        held &= ahead[edges.ends[:, 0]] == ahead[edges.ends[:, 1]]
    dim = rest.shape[1]
    numbers, changes = [], []
    for axis, values in item.values.items():
        change = np.zeros(int(held.sum()))
        if not len(leaders) and np.ptp(values) > 0:
            arms = rest[nodes] - rest[nodes].mean(axis=0)
            slope = np.linalg.lstsq(arms, values - values.mean(), rcond=1e-9)[0]
            if np.abs(arms @ slope + values.mean() - values).max() > AFFINE * np.ptp(values):
                continue
            change = rest[edges.middle[held]] @ slope
        numbers.append(edges.middle[held] * dim + AXES.index(axis))
        changes.append(change)
    if not numbers:
        return np.empty(0, np.int64), np.empty(0)
    return np.concatenate(numbers), np.concatenate(changes)


def held_angles(edges: EdgeRows, nodes: Index, dim: int, turning: bool = False) -> Index:
    """Numbers of the unknown angles of edges that a clamp of `nodes` holds.

    Edges of facets that are wholly `turning` are left to find theirs: these facets have their direction by their nodes.
    """
    inside = np.isin(np.arange(int(edges.ends.max()) + 1), nodes)
    within = edges_within(edges.edge, edges.ends, inside)
    if turning:
        whole = inside[edges.triangles].all(axis=1)
        within[edges.edge[whole]] = False
    edge, row = edges.pairs
    held = row[within[edge]]
    return np.asarray((held[:, None] * dim + np.arange(2)).ravel())


def turned_angles(edges: EdgeRows, numbers: Index, rotation: Array, rest: Array) -> Array:
    """What a rotation by the vector `rotation` (3,) makes of held angles: as much as edges turn about themselves.

    That share of the rotation is the same all the way, since it is about the same axis for the edge as it turns.
    """
    field = np.zeros((len(rest), 3))
    edges.turn(rest, rotation, field)
    return np.asarray(field.ravel()[numbers])
