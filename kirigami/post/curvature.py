"""Curvature of a bent sheet from the angles of its hinges.

A sheet that is bent without much stretch has the curvature tensor K, second derivatives of its height in its own
plane. Where the height is a quadratic, the angle at an edge between two facets is linear in K,

    theta = K : R,    R = -(1/2) sum over the facets' nodes of c_p x_p x_p' ,

with c_p the rate of the angle with the height of node p (wings, and the two ends of the edge). Around each node the
K is sought that meets the angles of all edges there in the least squares, each weighted with the area of its two
facets over the squared size of R, and the sums of the three nodes give the K of a facet. This is exact for
quadratic heights on any mesh, and does not look across cuts, nor at the angles of folds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.geometry.folds import SHARP, facet_axes, fold_angles, fold_curvature_rates, laid_out
from kirigami.geometry.topology import joined_corners
from kirigami.post.shape import check_flat, checked_mesh, checked_positions, principal_values
from kirigami.primitives.checks import require_choice

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

Floats = NDArray[np.float64]

KINDS = ("mean", "gaussian", "principal", "tensor")
UNSEEN = 1e-6  # a combination of curvatures that the angles determine less well than this is taken as zero


def curvature(positions: ArrayLike, mesh: TriMesh, kind: str = "mean", per: str = "facet") -> Floats:
    """Curvature of a sheet that is flat in its drawing.

    Parameters
    ----------
    positions : array_like, shape (s, n, 3) or (n, 3)
        Node positions at each of s steps [length].
    mesh : TriMesh
        The sheet as drawn.
    kind : {"mean", "gaussian", "principal", "tensor"}
        Half the sum of the principal curvatures [1 / length]; their product [1 / length^2]; both, the algebraically
        larger first [1 / length]; or the tensor with axes x and y of the drawing [1 / length].
    per : {"facet", "node"}
        Where: at the facets, or at the nodes as means of the facets around, weighted with their areas.

    Returns
    -------
    ndarray, shape (s, m) for "mean" and "gaussian", (s, m, 2) for "principal", (s, m, 2, 2) for "tensor"
        Curvature at each of m facets or nodes, counted from the flat sheet (an imperfection is part of it); positive
        where the sheet is hollow from above. Without the first axis if `positions` has no step axis.

    Raises
    ------
    ModelError
        Positions of the wrong shape or not finite, an unknown kind or place, or a mesh that is not flat.

    Notes
    -----
    Least squares of the hinge angles over the edges at the three nodes of a facet; see the text of the module. Where a
    piece of sheet is so narrow that its angles leave a part of the curvature open, the smallest one is taken.

    Examples
    --------
    >>> import numpy as np
    >>> from kirigami.post.curvature import curvature
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(-1, -1), (1, -1), (1, 1), (-1, 1)]).mesh(0.2)
    >>> x, y, _ = mesh.nodes.T
    >>> bent = np.column_stack([x, y, 1e-4 * x * y])
    >>> principal = curvature(bent, mesh, "principal")
    >>> bool(np.allclose(principal, (1e-4, -1e-4), rtol=1e-6))
    True
    """
    checked_mesh(mesh, "curvature")
    points = checked_positions(positions, "curvature", len(mesh.nodes))
    require_choice(kind, KINDS, "kind", "curvature")
    require_choice(per, ("facet", "node"), "per", "curvature")
    check_flat(mesh, "curvature")
    components = CurvatureFit(mesh).components(points)
    if per == "node":
        components = np.moveaxis(mesh.nodal_mean(np.moveaxis(components, -2, 0)), 0, -2)
    kxx, kyy, kxy = np.moveaxis(components, -1, 0)
    mean: Floats = 0.5 * (kxx + kyy)
    if kind == "mean":
        return mean
    if kind == "gaussian":
        gaussian: Floats = kxx * kyy - kxy**2
        return gaussian
    if kind == "tensor":
        return _tensor(components)
    return principal_values(kxx, kyy, kxy)


class CurvatureFit:
    """Least-squares curvature of the facets of one mesh from hinge angles, whatever the positions.

    On a mesh that is not flat all angles count, those it has at rest too, and the axes are those of
    :func:`kirigami.geometry.folds.facet_axes`. Edges that are sharp at rest, and what is beyond them, say nothing of a
    facet, as at folds.
    """

    def __init__(self, mesh: TriMesh) -> None:
        normal, axes = _planes(mesh)
        inner = np.flatnonzero((mesh.edge_facets[:, 1] >= 0) & ~mesh.edge_folded)
        inner = inner[(normal[mesh.edge_facets[inner]].prod(axis=1)).sum(axis=1) > np.cos(SHARP)]
        facets, ends = mesh.edge_facets[inner], mesh.edges[inner]
        self.triangles = mesh.triangles
        self.quads = np.column_stack([mesh.edge_wings[inner, 0], ends, mesh.edge_wings[inner, 1]])
        places = mesh.nodes[self.quads]
        along = places[:, 2] - places[:, 1]
        along /= np.linalg.norm(along, axis=1)[:, None]
        beside = np.stack([along, np.cross(normal[facets[:, 0]], along)], axis=1)
        flat = fold_curvature_rates(laid_out(places, beside, np.ones(len(inner), bool)))
        # the tensors R, in the mean plane of the two facets, without a rate of twist by one of its two equal entries
        mean = normal[facets].sum(axis=1)
        beside[:, 1] = np.cross(mean / np.linalg.norm(mean, axis=1)[:, None], along)
        rows = np.einsum("eci,ei->ec", _components_in(beside), flat * [1.0, 1.0, np.sqrt(0.5)])
        weight = mesh.facet_areas[facets].sum(axis=1) / (rows**2).sum(axis=1)
        part = joined_corners(mesh.triangles, ends, facets)
        corner = np.argmax(mesh.triangles[facets[:, :1]] == ends[:, :, None], axis=2)
        at = part[facets[:, :1], corner]  # (e, 2): the pieces of smooth sheet round its ends that an edge is in
        count = int(part.max()) + 1
        self._at_pieces, self._of_facets = _sums(at, count).T.tocsr(), _sums(part, count)
        self._onto: Floats | None = None  # (m, 3, 6)
        if np.ptp(mesh.nodes[:, 2]) == 0.0:  # all facets have the axes of the drawing
            rows = rows @ _components_in(axes[:1])[0]
        else:
            self._onto = _components_in(axes).transpose(0, 2, 1)
        self.weighted = rows * weight[:, None]
        one, two = np.triu_indices(rows.shape[1])
        squares = np.empty((len(part), rows.shape[1], rows.shape[1]))
        squares[:, one, two] = squares[:, two, one] = self._gather(self.weighted[:, one] * rows[:, two])
        if self._onto is not None:
            squares = self._onto @ squares @ self._onto.transpose(0, 2, 1)
        self.inverse = np.linalg.pinv(squares, rcond=UNSEEN, hermitian=True)

    def components(self, points: Floats) -> Floats:
        """Curvature (..., facets, 3): kxx, kyy, kxy."""
        steps = points.reshape(-1, *points.shape[-2:])
        found = np.empty((len(steps), len(self.triangles), 3))
        for row, step in zip(found, steps):
            gathered = self._gather(self.weighted * fold_angles(step[self.quads])[:, None])[:, :, None]
            row[:] = (self.inverse @ (gathered if self._onto is None else self._onto @ gathered))[..., 0]
        found[..., 2] *= np.sqrt(0.5)
        return found.reshape(*points.shape[:-2], *found.shape[1:])

    def tensor(self, points: Floats) -> Floats:
        """Curvature (..., facets, 2, 2) in the axes of the drawing, at positions (..., n, 3)."""
        return _tensor(self.components(points))

    def _gather(self, per_edge: Floats) -> Floats:
        """Sums over the edges that meet each corner of a facet without a fold between, wings not counted, and over its
        three corners."""
        return np.asarray(self._of_facets @ (self._at_pieces @ per_edge))


def _sums(columns: NDArray[np.int64], count: int) -> Any:
    """A sparse matrix (n, count) that sums up what stands in the columns (n, k) of its rows."""
    from scipy.sparse import csr_array

    starts = np.arange(len(columns) + 1) * columns.shape[1]
    return csr_array((np.ones(columns.size), columns.ravel(), starts), shape=(len(columns), count))


def _planes(mesh: TriMesh) -> tuple[Floats, Floats]:
    """Normals (m, 3) and axes (m, 2, 3) of the facets as drawn."""
    axes = facet_axes(mesh.nodes[mesh.triangles])
    return np.cross(axes[:, 0], axes[:, 1]), axes


def _components_in(axes: Floats) -> Floats:
    """Matrices (k, 6, 3) from components (xx, yy, sqrt(2) xy) of tensors along `axes` (k, 2, 3) to those in space, of
    which the last three are times sqrt(2) too: scalar products are those of the tensors."""
    one, two = axes[:, 0], axes[:, 1]
    i, j = np.array([0, 1, 2, 0, 1, 2]), np.array([0, 1, 2, 1, 2, 0])
    twice = np.where(i == j, 1.0, np.sqrt(2.0))
    mixed = np.sqrt(0.5) * (one[:, i] * two[:, j] + one[:, j] * two[:, i])
    return np.stack([twice * one[:, i] * one[:, j], twice * two[:, i] * two[:, j], twice * mixed], axis=2)


def _tensor(components: Floats) -> Floats:
    """Symmetric tensors (..., 2, 2) of kxx, kyy and kxy."""
    kxx, kyy, kxy = np.moveaxis(components, -1, 0)
    return np.stack([np.stack([kxx, kxy], axis=-1), np.stack([kxy, kyy], axis=-1)], axis=-2)
