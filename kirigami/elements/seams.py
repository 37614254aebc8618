"""The sheet across the border of a periodic cell: what bends there, on every rung.

Edges on the border that repeat each other are one edge of the infinite sheet. Each of the two has its own facet; beyond
it lies a copy of the other one's, a lattice vector away. Bars need nothing, since each of the two edges has the share
of its own facet.

* Sheets of bars and hinges: one hinge, with the far corner of the facet beyond.
* Facets: the fold at the edge, which was eliminated as that of a free edge, is given back to both facets.
* Shell facets: the edge that repeats shares middle and angles with the other one, row by row.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.bend_hinge import BendHingeKernel
from kirigami.elements.clamp_hinge import HeldEdgeKernel
from kirigami.elements.held_edges import given_back, joined_members
from kirigami.elements.stiffness import hinge_stiffness
from kirigami.elements.triangle import ENDS, STARTS
from kirigami.errors import ModelError
from kirigami.geometry.border import joined_nodes, leaders
from kirigami.geometry.topology import pair_numbers
from kirigami.primitives.kernel import Array, Kernel
from kirigami.primitives.parts import Numbering

Index = NDArray[np.int64]


class CellBorder:
    """Which nodes and edges on the border of a periodic cell repeat which.

    Parameters
    ----------
    images : ndarray of int, shape (k, 2 + m)
        Rows (node, node it repeats, steps along each lattice vector).
    edges : ndarray of int, shape (s, 4 + m)
        Rows (ends of an edge, ends of the one it repeats in the same order, steps from that to this).
    lattice : ndarray, shape (m, 3)
        Lattice vectors [length].
    """

    def __init__(self, images: Index, edges: Index, lattice: Array) -> None:
        self.images, self.edges, self.lattice = images, edges, lattice

    def numbers(self, ends: Index) -> Index:
        """Numbers (s, 2) of the edges that repeat and of those they repeat, among edges with given ends (e, 2)."""
        pairs = self.edges[:, :4].reshape(-1, 2)
        return pair_numbers(pairs, ends, int(ends.max()) + 1).reshape(-1, 2)

    def alike(self, sources: Index) -> Index:
        """Ends (s, 2) of the edges that repeat, in the order of those (s, 2) of the edges they repeat."""
        same = sources[:, 0] == self.edges[:, 2]
        return np.where(same[:, None], self.edges[:, :2], self.edges[:, 1::-1])

    def lead(self, nodes: Index, count: int) -> tuple[Index, Index]:
        """What each of the nodes (k,) out of `count` repeats, itself if it is none of the images, and in how many steps
        (k, m)."""
        leader, steps = leaders(self.images, count)
        return leader[nodes], steps[nodes]

    def around(self, points: Array, triangles: Index, edge: Index) -> tuple[Array, Index, Index, Index]:
        """The cell with those around it: points, facets, those of the cell first, their edges (., 3), numbered so that
        those of the cell keep their numbers in `edge` (m, 3), and which of the cell's edges each is.

        Edges on the border that repeat each other keep a number each, but have the facets of both.
        """
        shifts = np.array(sorted(product((-1, 0, 1), repeat=len(self.lattice)), key=lambda s: (any(s), s)))
        node, steps, place = joined_nodes(self.images, shifts, len(points))
        facets = place[:, triangles].reshape(-1, 3)
        following = np.roll(facets, -1, axis=1)
        pairs = np.sort(np.stack([facets, following], axis=2).reshape(-1, 2), axis=1)
        ends, found = np.unique(pairs, axis=0, return_inverse=True)
        found = found.ravel()
        number = np.full(len(ends), -1)
        number[found[: edge.size]] = edge.ravel()
        new = np.flatnonzero(number < 0)
        number[new] = int(edge.max()) + 1 + np.arange(len(new))
        every = number[found].reshape(-1, 3)
        source = np.empty(int(every.max()) + 1, np.int64)
        source[every.ravel()[::-1]] = np.tile(edge.ravel(), len(shifts))[::-1]  # those of the cell count
        return points[node] + steps @ self.lattice, facets, every, source


def cell_border(numbering: Numbering) -> CellBorder | None:
    """The border of the periodic cell of a model, if it is one."""
    found = [item for items in numbering.objects.values() for item in items if item.border is not None]
    if len(found) > 1:
        raise ModelError("the model has two periodic cells: remove what was imposed before, by model.remove(...)")
    return found[0].border if found else None


def seam_kernels(border: CellBorder, beyond: Index, numbering: Numbering) -> list[Kernel]:
    """Members that bend across the border; `beyond` (s, 2) are the rows of the far corners beyond its edges."""
    mesh, sheet = numbering.mesh, numbering.sheet
    if numbering.edges is not None or not len(beyond):
        return []
    seams = border.numbers(mesh.edges)
    if sheet.rung == "facet":
        return _facet_seams(seams, beyond, numbering)
    own = hinge_stiffness(mesh, sheet.thickness, sheet.of_facets("E"), sheet.of_facets("c"))
    image, source = seams.T
    conn = np.column_stack([mesh.edge_wings[image, 0], mesh.edges[image], beyond[:, 0]])
    stiffness = 1 / (1 / own[image] + 1 / own[source])  # each alone is that of an edge with one facet
    sides = mesh.edge_facets[seams, 0]
    return [SeamHingeKernel(numbering.rest, conn, stiffness, np.full(len(conn), np.nan), facets=sides)]


def _facet_seams(seams: Index, beyond: Index, numbering: Numbering) -> list[Kernel]:
    """Members that give both facets at each seam (s, 2) back the fold there."""
    far = dict(zip(seams.ravel().tolist(), beyond.ravel().tolist()))
    members: dict[int, list[tuple[Any, ...]]] = {}
    for back in given_back(seams.ravel(), numbering, seams[:, ::-1].ravel()):
        nodes, folds = list(back.corners), []
        for d, weight in back.weights.items():
            folds.append(([d, STARTS[d], ENDS[d], len(nodes)], weight))
            nodes.append(far.get(back.edges[d], back.wings[d]))
        members.setdefault(len(nodes), []).append((nodes, back.stiffness, [], folds))
    return [joined_members(SeamFacetKernel, made, numbering.rest) for _, made in sorted(members.items())]


class SeamHingeKernel(BendHingeKernel):
    """Hinges across the border of a cell, with the far corners of facets beyond it.

    `facets` (n, 2) are the numbers in the mesh of those on the two sides.
    """

    name = sheet_part = "seams"
    across_border = True

    def __init__(self, rest: Array, *given: Any, facets: Index, **named: Any) -> None:
        super().__init__(rest, *given, **named)
        self.facets = facets

    def arrays(self) -> dict[str, Any]:
        return {**super().arrays(), "facets": self.facets}


class SeamFacetKernel(HeldEdgeKernel):
    """Folds at the border of a cell that are given back to its facets."""

    name = "seams"
    across_border = True
    anchored = False
