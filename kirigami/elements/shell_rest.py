"""The rest state of shell facets: where their directors stand, which rows their edges have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.loose_ends import warn_of_loose_ends
from kirigami.elements.seams import cell_border
from kirigami.elements.shell_bending import EdgeFrames
from kirigami.elements.shell_geometry import EDGE_OF_POINT, Chart, dot
from kirigami.elements.shell_images import Images
from kirigami.elements.smooth_normals import edge_bulges
from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array
from kirigami.primitives.parts import Numbering
from kirigami.primitives.rows import EdgeRows
from kirigami.words import counted

FAR = 0.21  # of its length is how far the middle of an edge may be off it: the arc of a right angle
Index = NDArray[np.int64]


def angle_scale(chart: Chart, forward: NDArray[np.bool_]) -> Array:
    """Factors (6, n) from the stored numbers of the edges' angles, which are lengths, to local angles."""
    signed = np.where(forward, 1.0, -1.0) / chart.length
    return np.asarray(signed[:, EDGE_OF_POINT].T)


def initial_directors(frames: EdgeFrames, edge: Index, stored: Index, count: int, planes: Array | None) -> Array:
    """Directors (count, 2, 3) of the edges: the mean of the normals of the facets on them, and of their images in
    mirror planes, whose normals are the `planes` (n, 3, 3) of the facets' edges."""
    total = np.zeros((count, 2, 3))
    np.add.at(total, (edge, stored), frames.normal.transpose(0, 2, 1))
    if planes is not None:
        across = np.zeros((count, 1, 3))
        across[edge, 0] = planes[:, EDGE_OF_POINT].transpose(1, 0, 2)
        total -= (total * across).sum(axis=2, keepdims=True) * across
    size = np.linalg.norm(total, axis=2, keepdims=True)
    alone = np.zeros_like(total)  # facets folded flat onto each other have no mean: take one of them
    alone[edge, stored] = frames.normal.transpose(0, 2, 1)
    return np.where(size > 1e-3, total / np.where(size > 0, size, 1.0), alone)


def across(directors: Array, frames: EdgeFrames) -> Array:
    """Directors (6, 3, n) without what lies along the edges."""
    return directors - dot(directors, frames.tangent)[:, None] * frames.tangent


def repeated(rows: Index, seams: Index) -> Index:
    """Rows of angles (n, 3) with those that repeat others replaced by these: they share their directors."""
    order = np.argsort(seams[:, 0])
    known = seams[order]
    place = np.minimum(np.searchsorted(known[:, 0], rows), len(known) - 1)
    return np.where(known[place, 0] == rows, known[place, 1], rows)


def numbered_edges(numbering: Numbering, triangles: Index, normals: Sequence[Any], folded: Index) -> EdgeRows:
    """Number the edges of facets, with two rows of angles where an edge is one of the `folded` (k, 2) ones."""
    following = np.roll(triangles, -1, axis=1)
    pairs = np.sort(np.stack([triangles, following], axis=2).reshape(-1, 2), axis=1)
    ends, edge = np.unique(pairs, axis=0, return_inverse=True)
    edge = edge.reshape(-1, 3)
    count = len(ends)
    is_fold = np.zeros(count, dtype=bool)
    if len(folded):
        size = len(numbering.rest)
        is_fold = np.isin(ends[:, 0] * size + ends[:, 1], folded[:, 0] * size + folded[:, 1])
    _check_folds(numbering, triangles, edge, ends, folded, is_fold)
    corners = numbering.rest[ends]
    length = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
    images = Images(numbering, triangles, list(normals))
    border = cell_border(numbering)
    seams = border.numbers(ends) if border else np.empty((0, 2), np.int64)
    if border and images.planes:
        raise ModelError("a periodic cell and a plane of symmetry do not go together: model the whole cell")
    if border:  # edges on the border bulge as those of the whole sheet
        points, copies, every, source = border.around(numbering.rest, triangles, edge)
        offset = edge_bulges(points, copies, every, list(normals) * (len(copies) // len(edge)), is_fold[source])[:count]
        offset[seams[:, 0]] = offset[seams[:, 1]]
    elif images.planes:  # edges in a mirror plane bulge as those of the whole sheet
        every, source = images.edges(edge)
        offset = edge_bulges(images.points, images.triangles, every, images.normals, is_fold[source])[:count]
    else:
        offset = edge_bulges(numbering.rest, triangles, edge, normals, is_fold)
    _check_middles(numbering, ends, offset, length)
    middle = numbering.add_rows(offset, 0.25 * length)
    idle = np.zeros((1, 3), dtype=bool)
    idle[0, 2] = True
    one = numbering.add_rows(np.zeros((count, 3)), length, idle)
    other = one.copy()
    other[is_fold] = numbering.add_rows(np.zeros((int(is_fold.sum()), 3)), length[is_fold], idle)
    angle = np.where(triangles < following, one[edge], other[edge])
    if border:
        ends[seams[:, 0]] = border.alike(ends[seams[:, 1]])
    return EdgeRows(triangles, ends, edge, middle, angle, length, seams)


def _check_middles(numbering: Numbering, ends: Index, offset: Array, length: Array) -> None:
    """The middle of an edge lies by the edge: normals that say otherwise belong to another surface or a finer mesh."""
    bad = np.flatnonzero(~(np.linalg.norm(offset, axis=1) <= FAR * length))
    if bad.size:
        a, b = ends[bad[0]].tolist()
        far = np.linalg.norm(offset[bad[0]]) / length[bad[0]]
        where = f"{far:.3g} of its length off it" if np.isfinite(far) else "nowhere, since they lie along it"
        raise ModelError(
            f"ShellFacet: by the normals at its ends, the middle of the edge from {numbering.describe(a)} to "
            f"{numbering.describe(b)} ({bad.size} such in all) is {where}: an edge may turn by a right angle at most; "
            "give the normals of the surface there, or make the mesh finer"
        )


def _check_folds(
    numbering: Numbering, triangles: Index, edge: Index, ends: Index, folded: Index, is_fold: NDArray[np.bool_]
) -> None:
    """A crease runs along edges between two facets, one on each side."""
    known = {tuple(pair) for pair in ends[is_fold].tolist()}
    for a, b in folded.tolist():
        if (a, b) not in known:
            raise ModelError(
                f"Crease: no edge of a shell facet joins {numbering.describe(a)} and {numbering.describe(b)}: a crease "
                "runs from node to node along edges of the mesh"
            )
    forward = triangles < np.roll(triangles, -1, axis=1)
    ahead = np.bincount(edge[forward], minlength=len(ends))
    back = np.bincount(edge[~forward], minlength=len(ends))
    bad = np.flatnonzero(is_fold & ((ahead != 1) | (back != 1)))
    if bad.size:
        a, b = ends[bad[0]].tolist()
        raise ModelError(
            f"Crease: the edge from {numbering.describe(a)} to {numbering.describe(b)} has "
            f"{counted(ahead[bad[0]] + back[bad[0]], 'facet')}: a crease folds two facets, alike oriented, "
            "against each other"
        )
    if numbering.mesh is None or not numbering.mesh.folds:  # else it was said of the mesh
        warn_of_loose_ends("Crease", folded, ends[ahead + back == 1], numbering.rest, 2)
