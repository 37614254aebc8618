"""Triangle meshes of sheets: checked, immutable arrays and the topology that bars, hinges and post-processing need.

Only numpy is needed here (scipy's graph routines are imported where a mesh has several boundary loops), so that meshes
made elsewhere can be used without the meshing libraries.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.deferred import deferred
from kirigami.errors import GeometryError
from kirigami.geometry.fold_line import FoldEdges
from kirigami.geometry.mesh_checks import Floats, Integers, checked_nodes, checked_triangles, indices, read_only
from kirigami.geometry.topology import (
    area_vectors,
    boundary_walks,
    oriented_triangles,
    pair_keys,
    paired_half_edges,
    sides,
)
from kirigami.primitives.checks import (
    require_array,
    require_instance,
    require_items,
    require_mapping,
    require_positive,
    require_text,
)
from kirigami.primitives.material import SheetMaterial
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.geometry.sizing import Sizing

SIDES = {"left": (0, 0), "right": (0, 1), "bottom": (1, 0), "top": (1, 1)}  # axis, and 0 for its lower end
SIDE_TOLERANCE = 1e-9  # of the size of the mesh


@dataclass(frozen=True, eq=False)
class CutLoop:
    """The boundary of one cut as nodes of the mesh.

    Attributes
    ----------
    loop : ndarray of int, shape (k,)
        Nodes along the lips, counter-clockwise round the opening, so that the shoelace formula gives its area with a
        positive sign; the first node is not repeated. An open cut runs from mouth to mouth and is closed by the chord.
    members : tuple of int
        Numbers of the drawn cuts that form this one; more than one where cuts cross or touch.
    open : bool
        Whether the cut reaches the outline (or a hole of it).
    """

    loop: Integers
    members: tuple[int, ...]
    open: bool = False


class TriMesh:
    """A triangle mesh of a sheet, checked once and never changed afterwards.

    Parameters
    ----------
    nodes : array_like, shape (n, 2) or (n, 3)
        Coordinates in the unit of length of the model; ``z`` is zero when it is left out.
    triangles : array_like of int, shape (m, 3)
        Node indices of each facet, in any order: they are turned counter-clockwise, seen from +z.
    sets : mapping of str to array_like of int, optional
        Named sets of nodes.
    thickness : float, optional
        Thickness of the sheet, passed on to the model.
    material : Material, Orthotropic, Laminate or NeoHookean, optional
        Material of the sheet, passed on to the model.
    cuts : sequence of CutLoop, optional
        The cuts. Without it every boundary loop but the outer one is a cut, from bottom to top and left to right.
    folds : sequence of FoldEdges
        Edges along which the sheet is creased.
    regions : mapping of str to array_like of int or of bool (m,), optional
        Named sets of facets, for thickness, material and loads.

    Raises
    ------
    GeometryError
        If a coordinate is not finite, an index is out of range, a facet is degenerate or given twice, an edge has more
        than two facets, facets overlap along an edge, a node is unused, the surface has only one side, or a fold runs
        where no edge has two facets, or where another one runs.

    Notes
    -----
    For one connected sheet, edges - facets - nodes = holes - 1, where holes counts the closed boundaries inside it.

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    >>> mesh
    TriMesh(4 nodes, 2 facets, size 1 x 1, smallest angle 45 deg, 0 cuts, 0 holes)
    >>> mesh.edges.tolist()
    [[0, 1], [0, 2], [3, 0], [1, 2], [2, 3]]
    >>> mesh.boundary("left").tolist()
    [0, 3]
    """

    def __init__(
        self,
        nodes: ArrayLike,
        triangles: ArrayLike,
        sets: Mapping[str, ArrayLike] | None = None,
        *,
        thickness: float | None = None,
        material: SheetMaterial | None = None,
        cuts: Sequence[CutLoop] | None = None,
        folds: Sequence[FoldEdges] = (),
        regions: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        self.nodes: Floats = read_only(checked_nodes(nodes))
        self.triangles: Integers = read_only(oriented_triangles(self.nodes, checked_triangles(self.nodes, triangles)))
        given = {} if sets is None else require_mapping(sets, "sets", "TriMesh", GeometryError)
        self.sets: dict[str, Integers] = {
            name: indices(which, len(self.nodes), f"node set {name!r}", "node") for name, which in given.items()
        }
        self.thickness = None if thickness is None else require_positive(thickness, "thickness", "TriMesh")
        self.material = None if material is None else require_instance(material, SheetMaterial, "material", "TriMesh")
        areas = {} if regions is None else require_mapping(regions, "regions", "TriMesh", GeometryError)
        self.regions: dict[str, Integers] = {name: self._region(name, which) for name, which in areas.items()}
        self._given_cuts = None if cuts is None else _checked_cuts(cuts, len(self.nodes))
        self.folds: tuple[FoldEdges, ...] = tuple(self._checked_folds(folds))
        self.sizing: Sizing | None = None  # what a mesh with a budget of nodes has come to

    # --- edges -----------------------------------------------------------------------------------------------------

    @cached_property
    def _half_edges(self) -> tuple[Integers, Integers]:
        """First and second half-edge of every edge; half-edge 3 f + c runs from corner c of facet f to the next."""
        return paired_half_edges(self.triangles)

    @cached_property
    def edges(self) -> Integers:
        """Edges, shape (e, 2): edge (j, k) runs counter-clockwise round its first facet, with j < k if it has two."""
        return read_only(self._end_nodes(self._half_edges[0]))

    @cached_property
    def edge_facets(self) -> Integers:
        """Facets at the left and at the right of each edge, shape (e, 2); -1 where the sheet ends."""
        first, second = self._half_edges
        return read_only(np.column_stack([first // 3, np.where(second < 0, -1, second // 3)]))

    @cached_property
    def edge_wings(self) -> Integers:
        """Nodes opposite to each edge in its first and second facet, shape (e, 2); -1 where the sheet ends."""
        first, second = self._half_edges
        wings = [np.where(half < 0, -1, self.triangles[half // 3, (half + 2) % 3]) for half in (first, second)]
        return read_only(np.column_stack(wings))

    @cached_property
    def edge_folded(self) -> NDArray[np.bool_]:
        """Which edges lie on a fold, shape (e,)."""
        folded = np.zeros(len(self.edges), bool)
        if self.folds:
            count = len(self.nodes)
            along = np.concatenate([pair_keys(fold.edges, count) for fold in self.folds])
            folded = np.isin(pair_keys(self.edges, count), along)
        return read_only(folded)

    @cached_property
    def boundary_edges(self) -> Integers:
        """Indices of the edges with one facet."""
        return read_only(np.flatnonzero(self._half_edges[1] < 0))

    @cached_property
    def edge_lengths(self) -> Floats:
        """Length of each edge, shape (e,)."""
        return read_only(np.linalg.norm(self.nodes[self.edges[:, 1]] - self.nodes[self.edges[:, 0]], axis=1))

    def _end_nodes(self, half_edges: Integers) -> Integers:
        facet, corner = half_edges // 3, half_edges % 3
        return np.column_stack([self.triangles[facet, corner], self.triangles[facet, (corner + 1) % 3]])

    # --- facets ----------------------------------------------------------------------------------------------------

    @cached_property
    def facet_areas(self) -> Floats:
        """Area of each facet, shape (m,)."""
        return read_only(np.linalg.norm(area_vectors(self.nodes, self.triangles), axis=1))

    @cached_property
    def nodal_areas(self) -> Floats:
        """Area of the sheet that belongs to each node, a third of the facets around it, shape (n,)."""
        share = np.repeat(self.facet_areas / 3.0, 3)
        return read_only(np.bincount(self.triangles.ravel(), share, len(self.nodes)))

    def nodal_mean(self, values: ArrayLike) -> Floats:
        """Means over the facets around each node (n, ...) of values at facets (m, ...), weighted with area.

        Examples
        --------
        >>> import kirigami as kg
        >>> mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
        >>> mesh.nodal_mean([1.0, 3.0]).tolist()
        [2.0, 1.0, 2.0, 3.0]
        """
        given = require_array(values, name="values", owner="TriMesh.nodal_mean", error=GeometryError)
        if given.shape[:1] != (len(self.triangles),):
            raise GeometryError(
                f"TriMesh.nodal_mean: values must have a row for each of the {counted(len(self.triangles), 'facet')}, "
                f"got shape {given.shape}"
            )
        per_facet = given.reshape(len(self.triangles), -1)
        total = np.zeros((len(self.nodes), per_facet.shape[1]))
        for corner in self.triangles.T:
            np.add.at(total, corner, per_facet * (self.facet_areas / 3.0)[:, None])
        return np.asarray((total / self.nodal_areas[:, None]).reshape(len(self.nodes), *given.shape[1:]))

    @cached_property
    def facet_min_angles(self) -> Floats:
        """Smallest angle of each facet in degrees, shape (m,)."""
        vectors = sides(self.nodes, self.triangles)
        cosines = -np.einsum("mcx,mcx->mc", vectors, np.roll(vectors, 1, axis=1))  # the sides that meet at corner c
        return read_only(np.degrees(np.arctan2(2.0 * self.facet_areas[:, None], cosines)).min(axis=1))

    @property
    def min_angle(self) -> float:
        """Smallest angle of any facet, in degrees."""
        return float(self.facet_min_angles.min())

    @cached_property
    def facet_parts(self) -> Integers:
        """Number of the connected part each facet belongs to, shape (m,); parts hang together across edges."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        left, right = self.edge_facets[self.edge_facets[:, 1] >= 0].T
        count = len(self.triangles)
        graph = coo_array((np.ones(len(left), np.int8), (left, right)), shape=(count, count))
        return read_only(connected_components(graph, directed=False)[1].astype(np.int64))

    # --- boundary --------------------------------------------------------------------------------------------------

    @cached_property
    def _boundary_walks(self) -> list[Integers]:
        """Closed walks of boundary half-edges with the sheet at the left; the outer one of each part comes first."""
        return self._outer_first(boundary_walks(len(self.triangles), *self._half_edges))

    def _outer_first(self, walks: list[Integers]) -> list[Integers]:
        if len(walks) < 2:
            return walks
        extent = [np.linalg.norm(np.ptp(self.nodes[self._end_nodes(walk)[:, 0]], axis=0)) for walk in walks]
        part = [int(self.facet_parts[walk[0] // 3]) for walk in walks]
        outer: dict[int, int] = {}  # part -> its walk with the largest extent
        for number in range(len(walks)):
            if part[number] not in outer or extent[number] > extent[outer[part[number]]]:
                outer[part[number]] = number
        outers = sorted(outer.values(), key=lambda number: -extent[number])
        inners = sorted(set(range(len(walks))) - set(outers), key=lambda number: self._reading_order(walks[number]))
        return [walks[number] for number in outers + inners]

    def _reading_order(self, walk: Integers) -> tuple[float, ...]:
        centroid = self.nodes[self._end_nodes(walk)[:, 0]].mean(axis=0)
        return tuple(np.round(centroid / self.size, 6)[[1, 0, 2]].tolist())  # rows first, rounding errors set aside

    @cached_property
    def boundary_loops(self) -> list[Integers]:
        """Closed loops of boundary nodes with the sheet at the left, not repeating the first node; outer loop first."""
        return [read_only(self._end_nodes(walk)[:, 0]) for walk in self._boundary_walks]

    @cached_property
    def cuts(self) -> list[CutLoop]:
        """The cuts in the order in which they were drawn; cuts that cross or touch are one record."""
        if self._given_cuts is not None:
            return self._given_cuts
        inner = self.boundary_loops[self._outer_loop_count :]
        return [CutLoop(read_only(loop[::-1].copy()), (number,)) for number, loop in enumerate(inner)]

    @property
    def _outer_loop_count(self) -> int:
        return len(self.boundary_loops) if len(self.boundary_loops) < 2 else int(self.facet_parts.max()) + 1

    @cached_property
    def size(self) -> float:
        """Largest side of the bounding box."""
        return float(np.ptp(self.nodes, axis=0).max())

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Bounding box in the plane: xmin, ymin, xmax, ymax."""
        low, high = self.nodes[:, :2].min(axis=0), self.nodes[:, :2].max(axis=0)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    def boundary(self, name: str) -> Integers:
        """Nodes of a named piece of the boundary, or of a named set, in ascending order.

        Parameters
        ----------
        name : str
            ``"bottom"``, ``"top"``, ``"left"`` or ``"right"`` for the nodes of the outline on that side of the bounding
            box (to 1e-9 of the size); ``"outer"`` for the outline without holes and lips of cuts; ``"free"`` for all
            boundary nodes; ``"cut:3"`` for the cut that contains drawn cut 3; or the name of a set, which comes first.

        Raises
        ------
        GeometryError
            If there is no such name; the message lists the names there are.
        """
        require_text(name, "name", "TriMesh.boundary", GeometryError)
        if name in self.sets:
            return self.sets[name]
        if name == "free":
            return np.unique(self.edges[self.boundary_edges])
        if name == "outer":
            return self._outline_nodes
        if name in SIDES:
            axis, end = SIDES[name]
            coordinate = self.nodes[:, axis]
            side = coordinate.max() if end else coordinate.min()
            near = np.abs(coordinate[self._outline_nodes] - side) <= SIDE_TOLERANCE * self.size
            on_side: Integers = self._outline_nodes[near]
            return on_side
        if name.startswith("cut:") and name[4:].isdecimal():
            loops = [cut.loop for cut in self.cuts if int(name[4:]) in cut.members]
            if loops:
                return np.unique(np.concatenate(loops))
        members = sorted(number for cut in self.cuts for number in cut.members)
        cut_names = " to ".join(f"cut:{number}" for number in dict.fromkeys([*members[:1], *members[-1:]])) or "no cuts"
        raise GeometryError(
            f"the mesh has no boundary or set named {name!r}; there are {', '.join([*SIDES, 'outer', 'free'])}, "
            f"{cut_names}, and {'the sets ' + ', '.join(self.sets) if self.sets else 'no sets'}"
        )

    @cached_property
    def _outline_nodes(self) -> Integers:
        outer = [self._end_nodes(walk) for walk in self._boundary_walks[: self._outer_loop_count]]
        pairs = np.concatenate(outer) if outer else np.empty((0, 2), np.int64)  # a closed surface has no boundary
        lips = [np.column_stack([np.roll(cut.loop, -1), cut.loop]) for cut in self.cuts if cut.open]
        if lips:
            along_cut = np.isin(pair_keys(pairs, len(self.nodes)), pair_keys(np.concatenate(lips), len(self.nodes)))
            pairs = pairs[~along_cut]
        return read_only(np.unique(pairs))

    # --- copies ----------------------------------------------------------------------------------------------------

    def with_sets(self, **sets: ArrayLike) -> TriMesh:
        """Copy with more named node sets; a name that exists is replaced."""
        copied = self._copy(self.nodes, {**self.sets, **sets}, self._given_cuts)
        copied.sizing = self.sizing
        return copied

    def with_cuts(self, cuts: Sequence[CutLoop], sizing: Sizing | None = None) -> TriMesh:
        """Copy in which the cuts are these and not the inner boundary loops."""
        if sizing is not None:
            from kirigami.geometry.sizing import Sizing

            require_instance(sizing, Sizing, "sizing", "TriMesh.with_cuts", error=GeometryError)
        copied = self._copy(self.nodes, self.sets, cuts)
        copied.sizing = sizing
        return copied

    def with_folds(self, folds: Sequence[FoldEdges]) -> TriMesh:
        """Copy with these folds, in the place of those that it has.

        Parameters
        ----------
        folds : sequence of FoldEdges
            Edges along which the sheet is creased; see :class:`kirigami.Fold` for what they do.
        """
        copied = TriMesh(
            self.nodes, self.triangles, self.sets,
            thickness=self.thickness, material=self.material, cuts=self._given_cuts, folds=folds, regions=self.regions,
        )  # fmt: skip
        copied.sizing = self.sizing
        return copied

    def scaled(self, factor: float) -> TriMesh:
        """Copy with all coordinates times ``factor``; the thickness stays as it is."""
        factor = require_positive(factor, "factor", "TriMesh.scaled", GeometryError)
        return self._copy(self.nodes * factor, self.sets, self._given_cuts)

    moved = deferred("kirigami.geometry.moving:moved")

    def _copy(self, nodes: Floats, sets: Mapping[str, ArrayLike], cuts: Sequence[CutLoop] | None) -> TriMesh:
        return TriMesh(
            nodes, self.triangles, sets,
            thickness=self.thickness, material=self.material, cuts=cuts, folds=self.folds, regions=self.regions,
        )  # fmt: skip

    def _checked_folds(self, folds: Sequence[FoldEdges]) -> list[FoldEdges]:
        listed = require_items(folds, "folds", "TriMesh", GeometryError)
        if not listed:
            return []
        count = len(self.nodes)
        free = set(pair_keys(self.edges[self.edge_facets[:, 1] >= 0], count).tolist())
        for number, fold in enumerate(listed):
            require_instance(fold, FoldEdges, "folds", "TriMesh", error=GeometryError)
            for (a, b), key in zip(fold.edges.tolist(), pair_keys(fold.edges, count).tolist()):
                if min(a, b) < 0 or max(a, b) >= count or key not in free:
                    raise GeometryError(
                        f"fold {number} runs from node {a} to node {b}, where no edge joins two facets, or another "
                        "fold runs"
                    )
                free.remove(key)
        return listed

    def _region(self, name: str, which: ArrayLike) -> Integers:
        facets = indices(which, len(self.triangles), f"region {name!r}", "facet")
        if not facets.size:
            raise GeometryError(f"region {name!r} is empty: it has no facet")
        return facets

    def __repr__(self) -> str:
        size = " x ".join(f"{extent:.4g}" for extent in np.ptp(self.nodes, axis=0) if extent > 0)
        closed_cuts = sum(not cut.open for cut in self.cuts)
        holes = max(len(self.boundary_loops) - self._outer_loop_count - closed_cuts, 0)
        return (
            f"TriMesh({counted(len(self.nodes), 'node')}, {counted(len(self.triangles), 'facet')}, size {size}, "
            f"smallest angle {self.min_angle:.3g} deg, {counted(len(self.cuts), 'cut')}, {counted(holes, 'hole')})"
        )


def _checked_cuts(cuts: Sequence[CutLoop], count: int) -> list[CutLoop]:
    listed = require_items(cuts, "cuts", "TriMesh", GeometryError)
    for cut in listed:
        require_instance(cut, CutLoop, "cuts", "TriMesh", error=GeometryError)
        if np.min(cut.loop, initial=0) < 0 or np.max(cut.loop, initial=0) >= count:
            raise GeometryError(f"TriMesh: the loop of a cut names a node beyond 0 .. {count - 1}")
    return listed
