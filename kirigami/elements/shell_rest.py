"""The rest state of shell facets: how their edges bulge, where their directors stand, which rows their edges have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.loose_ends import warn_of_loose_ends
from kirigami.elements.seams import cell_border
from kirigami.elements.shell_bending import EdgeFrames
from kirigami.elements.shell_geometry import EDGE_OF_POINT, Chart
from kirigami.elements.shell_images import Images
from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array
from kirigami.primitives.parts import Numbering
from kirigami.primitives.rows import EdgeRows

SHARP = np.radians(30.0)  # an edge between facets that meet at more is a fold of the rest shape, not a part of a curve
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
            f"{ahead[bad[0]] + back[bad[0]]} facet(s): a crease folds two facets, alike oriented, against each other"
        )
    if numbering.mesh is None or not numbering.mesh.folds:  # else it was said of the mesh
        warn_of_loose_ends("Crease", folded, ends[ahead + back == 1], numbering.rest, 2)


def edge_bulges(
    points: Array, triangles: Index, edge: Index, normals: Sequence[Any], is_fold: NDArray[np.bool_]
) -> Array:
    """Offsets (edges, 3) of the middles of edges: the mean over the facets on each of what their normals ask for."""
    found = np.zeros((len(is_fold), 3))
    given = np.array([normal is not None for normal in normals], dtype=bool)
    flat = np.ptp(points[triangles.ravel()], axis=0).min() == 0.0
    if flat and not given.any():
        return found
    own = corner_normals(points, triangles, edge, is_fold)
    if given.any():
        known = np.array([normal for normal in normals if normal is not None])
        own[given] = known / np.linalg.norm(known, axis=2, keepdims=True)
    ends = np.stack([points[triangles], points[np.roll(triangles, -1, axis=1)]], axis=2).reshape(-1, 2, 3)
    at_ends = np.stack([own, np.roll(own, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    np.add.at(found, edge.ravel(), bulges(ends, at_ends))
    return np.asarray(found / np.bincount(edge.ravel())[:, None])


def bulges(ends: Array, normals: Array) -> Array:
    """Offsets (n, 3) of the middles of edges from the mean of their `ends` (n, 2, 3), given the normals (n, 2, 3)
    there: the arc of a circle through both ends, to the angle between the slopes."""
    chord = ends[:, 1] - ends[:, 0]
    square = (chord**2).sum(axis=1)
    up = normals.sum(axis=1)
    up -= ((up * chord).sum(axis=1) / square)[:, None] * chord
    with np.errstate(divide="ignore", invalid="ignore"):  # normals along the edge say nothing
        up /= np.linalg.norm(up, axis=1)[:, None]
    length = np.sqrt(square)
    along = np.einsum("nka,na->nk", normals, chord) / length[:, None]
    slope = np.arctan2(-along, np.einsum("nka,na->nk", normals, up))
    return np.asarray((0.5 * length * np.tan(0.25 * (slope[:, 0] - slope[:, 1])))[:, None] * up)


def corner_normals(points: Array, triangles: Index, edge: Index, is_fold: NDArray[np.bool_]) -> Array:
    """Unit normals (m, 3, 3) at the corners of facets: of the smooth surface through the nodes, up to the next fold.

    First the mean of the facets around, weighted by sin / (|a| |b|) of the two sides at the corner (Max, 1999), then
    that of the paraboloid through the node which fits those around it best: it does not lean at a free edge.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    corner = points[triangles]
    ahead = np.roll(corner, -1, axis=1) - corner
    back = np.roll(corner, 1, axis=1) - corner
    product = np.cross(ahead, back)
    facet = product[:, 0] / np.linalg.norm(product[:, 0], axis=1)[:, None]
    weighted = product / ((ahead**2).sum(axis=2) * (back**2).sum(axis=2))[..., None]
    # Link the corners of two facets at both ends of each smooth edge.
    order = np.argsort(edge.ravel(), kind="stable")
    ranked = edge.ravel()[order]
    twice = np.flatnonzero((ranked[1:] == ranked[:-1]) & (np.bincount(ranked)[ranked[1:]] == 2))
    one, two = order[twice], order[twice + 1]
    smooth = ((facet[one // 3] * facet[two // 3]).sum(axis=1) > np.cos(SHARP)) & ~is_fold[ranked[twice]]
    one, two = one[smooth], two[smooth]
    next_one, next_two = one // 3 * 3 + (one + 1) % 3, two // 3 * 3 + (two + 1) % 3
    nodes = triangles.ravel()
    opposed = nodes[one] != nodes[two]  # neighbours alike oriented run along the edge in opposite directions
    links = np.concatenate(
        [
            np.stack([one, np.where(opposed, next_two, two)], axis=1),
            np.stack([next_one, np.where(opposed, two, next_two)], axis=1),
        ]
    )
    graph = coo_array((np.ones(len(links), np.int8), (links[:, 0], links[:, 1])), shape=(nodes.size, nodes.size))
    parts, label = connected_components(graph, directed=False)
    place = np.zeros((parts, 3))
    place[label] = points[nodes]
    total = np.zeros((parts, 3))
    np.add.at(total, label, weighted.reshape(-1, 3))
    size = np.linalg.norm(total, axis=1)
    mean = total / np.where(size > 0, size, 1.0)[:, None]
    fitted = _of_paraboloids(place, mean, label.reshape(-1, 3))[label].reshape(-1, 3, 3)
    return np.asarray(np.where((size > 0)[label].reshape(-1, 3, 1), fitted, facet[:, None]))


def _of_paraboloids(place: Array, normal: Array, triangles: Index) -> Array:
    """Normals (n, 3) at points of smooth surfaces, from a first guess: of the paraboloids through the points that fit
    their neighbours and the neighbours of these, the nearer ones more; the guess where there are too few."""
    from scipy.sparse import coo_array

    n = len(place)
    rows, columns = (np.concatenate([triangles[:, k] for k in which]) for which in ((0, 1, 2, 1, 2, 0),
                                                                                   (1, 2, 0, 0, 1, 2)))  # fmt: skip
    near = coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(n, n)).tocsr()
    near.data[:] = 1
    pairs = (near + near @ near).tocoo()
    at, to = pairs.row[pairs.row != pairs.col], pairs.col[pairs.row != pairs.col]
    arm = place[to] - place[at]
    distance = np.linalg.norm(arm, axis=1)
    apart = distance > 0
    at, arm, distance = at[apart], arm[apart], distance[apart]
    reach = np.zeros(n)
    np.maximum.at(reach, at, distance)
    aside = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    first = np.cross(normal, aside)
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(normal, first)
    scale = reach[at]
    x, y, z = ((arm * axis[at]).sum(axis=1) / scale for axis in (first, second, normal))
    terms = np.stack([x, y, x * x, x * y, y * y], axis=1)
    weight = (scale / distance) ** 2
    matrix, right = np.zeros((n, 5, 5)), np.zeros((n, 5))
    np.add.at(matrix, at, weight[:, None, None] * terms[:, :, None] * terms[:, None])
    np.add.at(right, at, (weight * z)[:, None] * terms)
    values = np.linalg.eigvalsh(matrix)
    sound = values[:, 0] > 1e-4 * values[:, -1]
    matrix[~sound] = np.eye(5)
    slope = np.linalg.solve(matrix, right[..., None])[:, :2, 0]
    sound &= np.linalg.norm(slope, axis=1) < 1.0
    slope[~sound] = 0.0
    found = normal - slope[:, :1] * first - slope[:, 1:] * second
    return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])
