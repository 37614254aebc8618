"""Where the middles and the angles of the edges of shell facets go with their nodes: moved as a whole, or guessed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kirigami.elements.shell_bending import angles, edge_frames
from kirigami.elements.shell_geometry import EDGE_OF_POINT
from kirigami.elements.shell_rest import across
from kirigami.elements.smooth_normals import at_edge_ends, bulges, corner_normals
from kirigami.primitives.kernel import Array

if TYPE_CHECKING:
    from kirigami.elements.shell_kernel import ShellFacetKernel


def rigidly_moved(kernel: ShellFacetKernel, x: Array, rotation: Array, shift: Array) -> Array:
    """`x` after a rotation (3, 3) and a shift (3,): offsets of middles only turn, and angles keep up with what the turn
    does to their directors."""
    moved = np.array(x, dtype=float)
    corners, middles = np.unique(kernel.conn[:, :3]), np.unique(kernel.conn[:, 3:6])
    moved[corners] = moved[corners] @ rotation.T + shift
    moved[middles] = moved[middles] @ rotation.T
    directors = kernel._local_directors()
    before, after = (angles(edge_frames(kernel._vectors(y)[0]), directors) for y in (x, moved))
    turned = (after - before + np.pi) % (2 * np.pi) - np.pi
    row = kernel.conn[:, 6:].T[EDGE_OF_POINT]
    moved[row, kernel._stored] = np.asarray(x)[row, kernel._stored] + turned / kernel._angle_scale
    return moved


def settle(kernel: ShellFacetKernel, x: Array) -> None:
    """Write into `x` (rows, 3), whose nodes are known: edges bulge as the mean normals of the facets around say, beyond
    what they do so at rest, and turn by the mean of the facets on them."""
    x[kernel.conn[:, 3:6]] = _bulged(kernel, x)
    frames = edge_frames(kernel._vectors(x)[0])
    kernel.history = None
    local = across(kernel._local_directors(), frames)
    size = np.linalg.norm(local, axis=1, keepdims=True)
    kernel._count_from(np.where(size > 0.1, local / np.where(size > 0, size, 1.0), frames.normal))
    turned = (angles(frames, kernel._local_directors()) - kernel._rest_angles) / kernel._angle_scale
    whole = 2 * np.pi / np.abs(kernel._angle_scale)
    place = kernel._edge, kernel._stored
    first = np.zeros((len(kernel._angle_rows), 2))
    first[place] = turned
    turned = turned - whole * np.round((turned - first[place]) / whole)
    total, count = np.zeros_like(first), np.zeros_like(first)
    np.add.at(total, place, turned)
    np.add.at(count, place, 1.0)
    x[kernel._angle_rows, :2] = total / count


def _bulged(kernel: ShellFacetKernel, x: Array) -> Array:
    """Offsets (n, 3, 3) of the middles of the edges of each facet at nodes of `x`."""
    triangles, middles = kernel.conn[:, :3], kernel.conn[:, 3:6]
    edge = np.unique(kernel.conn[:, 6:], return_inverse=True)[1].reshape(-1, 3)
    apart = np.bincount(edge.ravel()) < 2  # edges of one facet, and those whose sides have angles of their own
    normals, at_rest = (corner_normals(rows, triangles, edge, apart) for rows in (x, kernel.rest))
    here, there = (
        bulges(*at_edge_ends(rows, triangles, own)).reshape(-1, 3, 3)
        for rows, own in ((x, normals), (kernel.rest, at_rest))
    )
    total, count = np.zeros_like(kernel.rest), np.zeros(len(kernel.rest))
    np.add.at(total, middles, here)
    np.add.at(count, middles, 1.0)
    # what the rest shape has beyond this, carried along with the normals
    beyond = ((kernel.rest[middles] - there) * at_rest).sum(axis=2, keepdims=True)
    return np.asarray(total[middles] / count[middles][..., None] + beyond * normals)
