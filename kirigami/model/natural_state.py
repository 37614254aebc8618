"""How the elements of a sheet take a strain and a curvature that its facets have by themselves, on every rung.

* Shell facets take them as they are.
* Flat facets take the strain as it is. Their folds, and the hinges of sheets of bars, take the angle that flat facets
  make on a surface of that curvature, theta = R : k (:mod:`kirigami.geometry.folds`); where the curvature jumps at the
  fold, the mean by area, since both sides bend by the same moment. So a curvature that a sheet can take without being
  stretched is taken without force, on any mesh. An edge that is held against its mirror image takes half of that.
* A bar takes the strain along it; where it jumps, the mean by the shares of the two sides in its stiffness.

Axes of a facet that is not flat in the drawing are those of its material: the first is the projection of x on it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.clamp_hinge import held_edges
from kirigami.elements.held_edges import facet_edges
from kirigami.elements.surface import surfaces_of
from kirigami.errors import ModelError
from kirigami.geometry.folds import fold_curvature_rates
from kirigami.geometry.topology import pair_numbers
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import strain_turn
from kirigami.primitives.parts import Numbering

Index = NDArray[np.int64]


class NaturalState:
    """Tells the elements of one sheet what they bear nothing at.

    Parameters
    ----------
    numbering : Numbering
        The model, its elements lowered.
    owner : str
        Who asks, for messages.
    """

    def __init__(self, numbering: Numbering, owner: str) -> None:
        self.numbering, self.owner = numbering, owner
        self.mesh: Any = numbering.mesh
        self.triangles: Index = self.mesh.triangles
        self.place = np.zeros((len(numbering.rest), 3))
        self.place[:, : numbering.dim] = numbering.rest
        self.area, self.normal, across = _frames(self.place[self.triangles])
        standing = np.flatnonzero(np.linalg.norm(across, axis=1) < 1e-6)
        if standing.size:
            raise ModelError(
                f"{owner}: facet {standing[0]} of the mesh stands on the x axis, so that it has no direction to count "
                "strain from: turn the model"
            )
        self.axis = across
        self.surfaces = surfaces_of(numbering.kernels, owner)

    def tell(self, facets: Index, values: Array, constant: bool) -> None:
        """Add strain and curvature (k, 6) of facets (k,), in the axes of the drawing."""
        state = np.zeros((len(self.triangles), 6))
        state[facets] = values
        if self.numbering.dim == 2 and state[:, 3:].any():
            raise ModelError(f"{self.owner}: nothing bends in a model with dim=2: give no curvature and even heat")
        folded = not self.surfaces or any(kernel.bends_by_folds for kernel in self.surfaces)
        folds = self._folds(state) if folded and state[:, 3:].any() else np.zeros((2, len(self.mesh.edges)))
        if folds.any() and any(kernel.across_border for kernel in self.numbering.kernels):
            raise ModelError(
                f"{self.owner}: a curvature of its own does not go with a periodic cell of bars and hinges or of flat "
                "facets, which fold at their border: take stiffness='shell'"
            )
        if self.surfaces:
            self._tell_facets(facets, state, folds[0], constant)
        else:
            self._tell_bars(facets, state, folds[0], constant)
        if folds.any():
            self._tell_held_edges(folds, constant)

    def warm(self, facets: Index, heat: Array, constant: bool) -> None:
        """Tell facets (k,) the heat (2,) at their faces."""
        for kernel in self.surfaces:
            rows, _ = self._rows(kernel.conn[:, :3], facets)
            kernel.warm(rows, np.broadcast_to(heat, (len(rows), 2)), constant)

    def _rows(self, corners: Index, facets: Index) -> tuple[Index, Index]:
        """Members (k,) that are among the facets of the mesh, and which of these they are."""
        size = len(self.numbering.rest)
        known, wanted = _codes(corners, size), _codes(self.triangles[facets], size)
        order = np.argsort(wanted)
        at = order[np.minimum(np.searchsorted(wanted[order], known), len(wanted) - 1)]
        rows = np.flatnonzero(wanted[at] == known)
        return rows, facets[at[rows]]

    def _check_found(self, found: int, wanted: int, what: str) -> None:
        if found < wanted:
            raise ModelError(f"{self.owner}: {wanted - found} of its {what} taken out of the model")

    def _local(self, corners: Index, values: Array) -> Array:
        """Strain and curvature (k, 6) in the axes of elements with `corners` (k, 3), the first along the edge 01."""
        return in_facets(self.place[corners], values)

    def _turned(self, along: Array, facets: Index, values: Array) -> Array:
        """Strain and curvature (k, 6) of facets in axes of which the first is `along` (k, 3)."""
        axis, normal = self.axis[facets], self.normal[facets]
        return _in_axes(axis, normal, along, values)

    def _tell_facets(self, facets: Index, state: Array, folds: Array, constant: bool) -> None:
        every = np.arange(len(self.triangles)) if folds.any() else facets  # facets share the folds of their neighbours
        table, found = facet_edges(self.mesh), 0
        for kernel in self.surfaces:
            rows, at = self._rows(kernel.conn[:, :3], every)
            kernel.actuate_facets(rows, self._local(kernel.conn[rows, :3], state[at]), folds[table[at]], constant)
            found += len(rows)
        self._check_found(found, len(every), "facets")

    # ---- bars and hinges

    def _sides(self, edges: Index) -> list[tuple[Index, Index, Array]]:
        """For both sides: which of `edges` have a facet there, that facet, and the edges' vectors (k, 3)."""
        mesh = self.mesh
        along = self.place[mesh.edges[edges, 1]] - self.place[mesh.edges[edges, 0]]
        found = []
        for side in (0, 1):
            facet = mesh.edge_facets[edges, side]
            there = np.flatnonzero(facet >= 0)
            found.append((there, facet[there], along[there]))
        return found

    def _folds(self, state: Array) -> Array:
        """Fold angles (2, edges) towards the normals that the curvature asks for: between the facets at an edge, zero
        at edges of one; and against the image of one that is mirrored at the edge, halved, zero at the others."""
        mesh = self.mesh
        edges = np.arange(len(mesh.edges))
        quads = np.zeros((len(edges), 4, 2))
        quads[:, 2, 0] = mesh.edge_lengths
        curvature, area = np.zeros((len(edges), 3)), np.zeros(len(edges))
        for side, (there, facet, along) in enumerate(self._sides(edges)):
            along = along / np.linalg.norm(along, axis=1)[:, None]
            arm = self.place[mesh.edge_wings[there, side]] - self.place[mesh.edges[there, 0]]
            aside = np.cross(self.normal[facet], along)
            quads[there, 3 * side] = np.stack([(arm * along).sum(axis=1), (arm * aside).sum(axis=1)], axis=1)
            curvature[there] += self.area[facet, None] * self._turned(along, facet, state[facet])[:, 3:]
            area[there] += self.area[facet]
        alone = mesh.edge_facets[:, 1] < 0
        quads[alone, 3] = quads[alone, 0] * [1.0, -1.0]
        rates = fold_curvature_rates(quads) * [1.0, 1.0, 0.5]  # of kxx, kyy and 2 kxy
        angle = (rates * curvature).sum(axis=1) / area
        angle[mesh.edge_folded] = 0.0  # a fold has an angle of its own
        return np.stack([np.where(alone, 0.0, angle), np.where(alone, 0.5 * angle, 0.0)])

    def _edges_of(self, pairs: Index) -> tuple[Index, Index]:
        """Members (k,) that are edges of the mesh, the first on each, and which."""
        at = pair_numbers(pairs, self.mesh.edges, len(self.numbering.rest))
        rows = np.flatnonzero(at >= 0)
        edges, first = np.unique(at[rows], return_index=True)
        return rows[first], edges

    def _tell_bars(self, facets: Index, state: Array, folds: Array, constant: bool) -> None:
        sheet, mesh = self.numbering.sheet, self.mesh
        count = len(self.triangles)
        stiff = sheet.thickness_of_facets(count) * sheet.of_facets("E") * self.area
        edges = np.arange(len(mesh.edges))
        strain, share = np.zeros(len(edges)), np.zeros(len(edges))
        for there, facet, along in self._sides(edges):
            strain[there] += stiff[facet] * self._turned(along, facet, state[facet])[:, 0]
            share[there] += stiff[facet]
        strain /= share
        bars, hinges = np.zeros(len(edges), dtype=bool), np.zeros(len(edges), dtype=bool)
        for kernel in self.numbering.kernels:
            if kernel.sheet_part == "bars":
                rows, at = self._edges_of(kernel.conn)
                kernel.actuate(rows, strain[at], constant)
                bars[at] = True
            elif kernel.sheet_part == "hinges" and folds.any():
                rows, at = self._edges_of(kernel.conn[:, 1:3])
                kernel.actuate(rows, self._senses(kernel.conn[rows], at) * folds[at], constant)
                hinges[at] = True
        touched = np.unique(facet_edges(mesh)[facets])
        self._check_found(int(bars[touched].sum()), len(touched), "bars")
        bent = touched[folds[touched] != 0]
        self._check_found(int(hinges[bent].sum()), len(bent), "hinges")

    def _senses(self, conn: Index, edges: Index) -> Array:
        """Sign (k,) by which hinges (k, 4) count angles that edges have towards the normals of their facets."""
        mesh = self.mesh
        side = (conn[:, 0] != mesh.edge_wings[edges, 0]).astype(np.int64)
        normal = self.normal[mesh.edge_facets[edges, side]]
        wing, start, end = (self.place[conn[:, k]] for k in range(3))
        return np.asarray(np.sign((np.cross(end - start, wing - start) * normal).sum(axis=1)))

    def _tell_held_edges(self, folds: Array, constant: bool) -> None:
        def edges(pairs: Index) -> Index:
            return pair_numbers(pairs, self.mesh.edges, len(self.numbering.rest))

        for kernel in held_edges(self.numbering.kernels, self.owner):
            kernel.actuate_edges(lambda pairs: folds[0][edges(pairs)], lambda pairs: folds[1][edges(pairs)], constant)


def _frames(corners: Array) -> tuple[Array, Array, Array]:
    """Areas (k,), normals and projections of x (k, 3) of facets with `corners` (k, 3, 3)."""
    product = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(product, axis=1)
    normal = product / size[:, None]
    return 0.5 * size, normal, np.array([1.0, 0.0, 0.0]) - normal[:, :1] * normal


def _in_axes(axis: Array, normal: Array, along: Array, values: Array) -> Array:
    """Strain and curvature (k, 6) in axes of which the first is `along`, from those of which it is `axis` (k, 3)."""
    angle = np.arctan2((np.cross(axis, along) * normal).sum(axis=1), (axis * along).sum(axis=1))
    parts = np.einsum("nab,npb->npa", strain_turn(angle), values.reshape(-1, 2, 3))
    return np.asarray(parts.reshape(-1, 6))


def in_facets(corners: Array, values: Array) -> Array:
    """Strain and curvature (k, 6) in the axes of facets with `corners` (k, 3, 3), the first along the edge from corner
    0 to 1, from those of the drawing."""
    _, normal, axis = _frames(corners)
    return _in_axes(axis, normal, corners[:, 1] - corners[:, 0], values)


def _codes(nodes: Index, size: int) -> Index:
    """One number (m,) for the nodes of each member (m, k), in whatever order."""
    found = np.zeros(len(nodes), np.int64)
    for column in np.sort(nodes, axis=1).T:
        found = found * size + column
    return found
