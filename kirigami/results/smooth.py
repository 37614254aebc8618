"""Values of facets as smooth fields: means round each node, with the jumps kept across folds, cuts and steps.

A facet knows its stress in the mean, and its neighbours' differ by the size of the mesh; the mean over the facets round
a node, weighted with their areas, is better by an order where the field is smooth. Across a fold it is not, nor where
thickness or material change, and across a cut there is nothing to average. So round each node the facets are parted
into *sectors* by folds, edges that are sharp at rest and jumps of the section; the two lips of a cut have nodes of
their own anyhow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import AnalysisError, KirigamiError
from kirigami.geometry.folds import SHARP
from kirigami.geometry.mesh import TriMesh
from kirigami.geometry.topology import joined_corners
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.stress import sheet_stress

Index = NDArray[np.int64]
SHOWN = 0.995  # share of the area over which colours span: at the tip of a cut all grows with every refinement
JUMP = 0.3  # change of a section from facet to facet, over the section, from which on it is no smooth field


@dataclass(frozen=True, eq=False)
class Sectors:
    """The smooth pieces of a sheet round each of its nodes.

    Attributes
    ----------
    corner : ndarray of int, shape (m, 3)
        Sector of each corner of each facet.
    node : ndarray of int, shape (k,)
        Node of each sector; without folds sectors are the nodes of the facets, in their order.
    """

    corner: Index
    node: Index
    _share: Array  # area (m,) of the facets

    def means(self, values: Array) -> Array:
        """Means (s, k) over the facets of each sector, weighted with their areas, of values (s, m)."""
        weight = np.bincount(self.corner.ravel(), np.repeat(self._share, 3), len(self.node))
        rows = [np.bincount(self.corner.ravel(), np.repeat(row * self._share, 3), len(self.node)) for row in values]
        return np.array(rows).reshape(len(values), len(self.node)) / weight

    def span(self, values: Array) -> tuple[float, float]:
        """Smallest of values (s, k), and the one that `SHOWN` of the area stays below, of the area that has any."""
        weight = np.bincount(self.corner.ravel(), np.repeat(self._share, 3), len(self.node))
        held, weights = values.ravel(), np.tile(weight, len(values)) * (values.ravel() != 0)
        order = np.argsort(held)
        below = np.cumsum(weights[order])
        high = held[order[min(int(np.searchsorted(below, SHOWN * below[-1])), len(held) - 1)]]
        return float(held.min()), float(high)

    def over_facets(self, means: Array) -> Array:
        """Means (s, m) of the three corners of each facet."""
        found: Array = means[:, self.corner].mean(axis=2)
        return found


def sectors(results: Results) -> Sectors:
    """The smooth pieces of the sheet of some results.

    Raises
    ------
    AnalysisError
        The model was not made from a mesh.

    Examples
    --------
    >>> from kirigami.results.smooth import sectors
    >>> import kirigami as kg
    >>> mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9), stiffness="shell")
    >>> crease = m.add(kg.Crease([m.nodes[0], m.nodes[2]], stiffness=0.0))
    >>> sectors(kg.Results(kg.System(m))).node.tolist()  # the nodes on the fold have one on each side
    [0, 0, 1, 2, 2, 3]
    """
    mesh = results.mesh
    if mesh is None:
        raise AnalysisError("smooth fields need a model made by Model.from_mesh", results=results)
    return results.once("sectors", lambda: _parted(results, mesh))


def _parted(results: Results, mesh: TriMesh) -> Sectors:
    inner = mesh.edge_facets[:, 1] >= 0
    joined = np.flatnonzero(inner & ~folded_edges(results, mesh) & ~_stepped_edges(results, mesh))
    label = joined_corners(mesh.triangles, mesh.edges[joined], mesh.edge_facets[joined]).ravel()
    node = np.empty(int(label.max()) + 1, dtype=np.int64)
    node[label] = mesh.triangles.ravel()
    order = np.argsort(node, kind="stable")
    place = np.empty(len(node), dtype=np.int64)
    place[order] = np.arange(len(node))
    return Sectors(place[label].reshape(-1, 3), node[order], np.asarray(mesh.facet_areas))


def _stepped_edges(results: Results, mesh: TriMesh) -> NDArray[np.bool_]:
    """Edges of the mesh (e,) where the section jumps, in the axes of the drawing: in those of facets a grain turns with
    them."""
    stepped = np.zeros(len(mesh.edges), bool)
    if results.sheet_constants is None:
        return stepped
    inner = np.flatnonzero(mesh.edge_facets[:, 1] >= 0)
    one, two = mesh.edge_facets[inner].T
    section = results.sheet_constants.sections(len(mesh.triangles))
    for part in (slice(0, 3), slice(3, 6)):  # stretching and bending
        of_one, of_two = section[one, part, part], section[two, part, part]
        stepped[inner] |= np.abs(of_one - of_two).max(axis=(1, 2)) > JUMP * np.abs(of_one).max(axis=(1, 2))
    return stepped


def folded_edges(results: Results, mesh: TriMesh) -> NDArray[np.bool_]:
    """Which edges of the mesh (e,) are folds or creases of shell facets, or fold sharply at rest."""
    rest = results.rest[: len(mesh.nodes)]
    corners = rest[mesh.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    first, second = mesh.edge_facets.T
    inner = second >= 0
    folded = mesh.edge_folded | (inner & ((normal[first] * normal[second]).sum(axis=1) < np.cos(SHARP)))
    for kernel in results.kernels:
        if kernel.name != "shell" or not np.array_equal(kernel.conn[:, :3], mesh.triangles):
            continue
        # Facets on the two sides of a crease have angles of their own at its edge.
        angle: dict[tuple[int, ...], set[int]] = {}
        for facet, (a, b, c) in enumerate(mesh.triangles.tolist()):
            for pair, row in zip(((a, b), (b, c), (c, a)), kernel.conn[facet, 6:].tolist()):
                angle.setdefault(tuple(sorted(pair)), set()).add(row)
        folded |= inner & np.array([len(angle[tuple(sorted(pair))]) > 1 for pair in mesh.edges.tolist()])
    return np.asarray(folded)


def surface_stress(results: Results, step: int | None = None) -> Array:
    """Von Mises' stress at the face where it is larger, as means over sectors (s, k) [force / length^2].

    That of a step is computed once, however many pictures and tables show it.

    Parameters
    ----------
    results : Results
        Of a model made from a mesh, whose thickness and material are known.
    step : int, optional
        Number of one stored step, (k,); None takes all of them.

    Raises
    ------
    KirigamiError
        The stress is not known; see :func:`kirigami.results.stress.sheet_stress`.
    """
    parts = sectors(results)

    def of_one(number: int) -> Array:
        stress = sheet_stress(results, number)
        larger = np.maximum(stress.von_mises("top"), stress.von_mises("bottom"))
        return np.asarray(parts.means(larger[None])[0])

    def kept(number: int) -> Array:
        return results.once(("surface stress", number), lambda: of_one(number))

    if step is not None:
        return kept(results.step_number(step, "surface_stress") % len(results))
    return np.array([kept(number) for number in range(len(results))]).reshape(len(results), len(parts.node))


def known_stress(results: Results) -> Array | None:
    """That of all steps, or None where the stress is not known."""
    try:
        return surface_stress(results)
    except KirigamiError:
        return None
