"""Meshes that move: some nodes are put elsewhere, and the others follow smoothly, so that the topology stays.

The sheet is stretched into its new shape as a linear elastic one whose facets are the stiffer the smaller they are, so
that the fine ones at tips of cuts keep their shape (Stein, Tezduyar and Benney, 2003). The map is linear in what the
given nodes do and starts from one reference mesh, so it is smooth and does not depend on the way.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import GeometryError, KirigamiWarning
from kirigami.geometry.mesh import TriMesh
from kirigami.geometry.topology import area_vectors
from kirigami.primitives.checks import require_array, require_whole_array
from kirigami.words import counted

POOR = 15.0  # smallest angle [deg] of a moved mesh that is worth a warning
ON = 3e-4  # of the size of the sheet: how far off a drawn line a node on it may lie
POISSON = 0.3  # of the sheet that is stretched
Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Extension:
    """How the nodes of a flat mesh follow those given."""

    def __init__(self, mesh: TriMesh, given: Integers) -> None:
        from scipy.sparse import coo_array
        from scipy.sparse.linalg import splu

        count = len(mesh.nodes)
        corner = mesh.nodes[mesh.triangles][..., :2]
        along = np.roll(corner, 1, axis=1) - np.roll(corner, -1, axis=1)  # opposite sides; gradients are these, turned
        slope = np.stack([-along[..., 1], along[..., 0]], axis=-1) / (2 * mesh.facet_areas)[:, None, None]
        lame, shear = POISSON / (1 - POISSON**2), 0.5 / (1 + POISSON)
        dot = np.einsum("mia,mja->mij", slope, slope)
        blocks = shear * np.einsum("mij,ab->miajb", dot, np.eye(2))
        blocks += shear * np.einsum("mib,mja->miajb", slope, slope) + lame * np.einsum("mia,mjb->miajb", slope, slope)
        rows = (2 * mesh.triangles[:, :, None] + np.arange(2)).reshape(len(corner), 6)
        at = np.repeat(rows, 6, axis=1).ravel(), np.tile(rows, (1, 6)).ravel()
        matrix = coo_array((blocks.ravel(), at), shape=(2 * count, 2 * count)).tocsr()
        self.given = given
        held = (2 * given[:, None] + np.arange(2)).ravel()
        self._free = np.setdiff1d(np.arange(2 * count), held)
        self._held, self._coupling = held, matrix[self._free][:, held]
        self._factor = splu(matrix[self._free][:, self._free].tocsc()) if len(self._free) else None
        self._count = count

    def field(self, change: Floats) -> Floats:
        """Displacements (n, 2) of all nodes for those (k, 2) of the given ones."""
        found = np.zeros(2 * self._count)
        found[self._held] = change.ravel()
        if self._factor is not None:
            found[self._free] = self._factor.solve(-(self._coupling @ change.ravel()))
        return found.reshape(-1, 2)

    def back(self, by_nodes: Floats) -> Floats:
        """Derivatives (k, 2) by the displacements of the given nodes of what has some (n, 2) by those of all."""
        flat = by_nodes.ravel()
        found = flat[self._held]
        if self._factor is not None:
            found = found - self._coupling.T @ self._factor.solve(flat[self._free])  # the matrix is symmetric
        return np.asarray(found.reshape(-1, 2))


def moved(mesh: TriMesh, nodes: ArrayLike, places: ArrayLike) -> TriMesh:
    """Copy in which some nodes are elsewhere in the plane, and the others have followed; facets, sets and cuts stay.

    Parameters
    ----------
    nodes : array_like of int, shape (k,)
        The nodes that are put elsewhere. The others on the boundary follow too: list those that are to stay.
    places : array_like, shape (k, 2)
        Where to [length].

    Returns
    -------
    TriMesh

    Raises
    ------
    GeometryError
        A node that is not there or listed twice, a mesh that is not flat, or a facet that would turn over.

    Warns
    -----
    KirigamiWarning
        Where the smallest angle falls below 15 degrees.

    Examples
    --------
    >>> import shapely, kirigami as kg
    >>> mesh = kg.Sheet(shapely.box(0, 0, 2, 1)).mesh(0.3)
    >>> outline = mesh.boundary("outer")
    >>> wider = mesh.moved(outline, mesh.nodes[outline, :2] * (1.5, 1))
    >>> round(float(wider.facet_areas.sum()), 9), len(wider.nodes) == len(mesh.nodes)
    (3.0, True)
    """
    which = require_whole_array(nodes, (None,), name="nodes", owner="TriMesh.moved", error=GeometryError)
    if which.min() < 0 or which.max() >= len(mesh.nodes) or len(np.unique(which)) < len(which):
        raise GeometryError(f"TriMesh.moved: nodes must be different numbers below {len(mesh.nodes)}")
    to = require_array(places, (len(which), 2), name="places", owner="TriMesh.moved", error=GeometryError)
    if np.ptp(mesh.nodes[:, 2]) > 0:
        raise GeometryError("TriMesh.moved: only a flat mesh moves in its plane")
    change = Extension(mesh, which).field(to - mesh.nodes[which, :2])
    return with_nodes(mesh, mesh.nodes[:, :2] + change)


def with_nodes(mesh: TriMesh, points: Floats, tell: bool = True) -> TriMesh:
    """The mesh with its nodes at `points` (n, 2), or a GeometryError where a facet would turn over."""
    full = np.column_stack([points, mesh.nodes[:, 2]])
    areas = area_vectors(full, mesh.triangles)[:, 2]
    worst = int(np.argmin(areas / mesh.facet_areas))
    if areas[worst] <= 1e-3 * mesh.facet_areas[worst]:
        x, y = points[mesh.triangles[worst]].mean(axis=0)
        raise GeometryError(
            f"a facet at ({x:.6g}, {y:.6g}) would turn over: move this mesh less, or mesh anew"
        )
    made = mesh._copy(full, mesh.sets, mesh.cuts)
    if tell and made.min_angle < POOR:
        at = made.nodes[made.triangles[int(np.argmin(made.facet_min_angles))], :2].mean(axis=0)
        warnings.warn(
            f"the smallest angle of the moved mesh is {counted(made.min_angle, 'degree', spec='.3g')}, at "
            f"({at[0]:.6g}, {at[1]:.6g}): mesh anew from here",
            KirigamiWarning,
            stacklevel=3,
        )
    return made


class Follower:
    """Which drawn line each node on the boundary or on a fold of a mesh lies on, and where it goes when lines of one
    topology move."""

    def __init__(
        self, mesh: TriMesh, outline: shapely.Polygon, cuts: tuple[Any, ...], folds: tuple[Any, ...] = ()
    ) -> None:
        self.mesh = mesh
        self.lines = [_corners(outline), *(_corners(cut) for cut in cuts), *(_corners(fold) for fold in folds)]
        size = mesh.size
        outer = mesh.boundary("outer")
        line, piece, share = [np.full(len(mesh.nodes), -1) for _ in range(2)] + [np.zeros(len(mesh.nodes))]
        self._crossing: dict[int, tuple[int, int, int]] = {}  # nodes on a cut and on the outline: cut, its piece, rim's
        for number, cut in enumerate(mesh.cuts):
            for node in np.unique(cut.loop).tolist():
                found = min((_nearest(self.lines[k + 1], mesh.nodes[node, :2]), k + 1) for k in cut.members)
                (distance, at, t), owner = found
                if distance > ON * size:
                    x, y = mesh.nodes[node, :2]
                    raise GeometryError(f"node {node} at ({x:.6g}, {y:.6g}) is on cut {number}, but not on its line")
                line[node], piece[node], share[node] = owner, at, t
        for node in outer.tolist():
            distance, at, t = _nearest(self.lines[0], mesh.nodes[node, :2])
            if distance > ON * size:
                continue
            if line[node] > 0:
                self._crossing[node] = (int(line[node]), int(piece[node]), at)
            line[node], piece[node], share[node] = 0, at, t
        inner = np.setdiff1d(np.unique(np.concatenate(mesh.boundary_loops)), np.flatnonzero(line >= 0))
        for node in inner.tolist():  # holes of the outline
            distance, at, t = _nearest(self.lines[0], mesh.nodes[node, :2])
            line[node], piece[node], share[node] = 0, at, t
        for number, fold in enumerate(mesh.folds, start=1 + len(cuts)):
            for node in np.unique(fold.edges).tolist():
                _, at, t = _nearest(self.lines[number], mesh.nodes[node, :2])
                if line[node] == 0 and node not in self._crossing:  # where a fold ends at the outline
                    self._crossing[node] = (number, at, int(piece[node]))
                elif line[node] < 0:
                    line[node], piece[node], share[node] = number, at, t
        self.nodes = np.flatnonzero(line >= 0)
        self._line, self._piece, self._share = line[self.nodes], piece[self.nodes], share[self.nodes]
        self._extension = Extension(mesh, self.nodes)

    def points(self, outline: shapely.Polygon, cuts: tuple[Any, ...], folds: tuple[Any, ...] = ()) -> Floats:
        """Places (n, 2) of all nodes for an outline, cuts and folds of the same topology."""
        return np.asarray(self.mesh.nodes[:, :2] + self._extension.field(self.on_lines(outline, cuts, folds)))

    def back(self, by_nodes: Floats) -> Floats:
        """Derivatives (k, 2) by what :meth:`on_lines` tells of what has some (n, 2) by the places of the nodes."""
        return self._extension.back(by_nodes)

    def on_lines(self, outline: shapely.Polygon, cuts: tuple[Any, ...], folds: tuple[Any, ...] = ()) -> Floats:
        """Displacements (k, 2) of the nodes on lines, from where they were meshed."""
        lines = [_corners(outline), *(_corners(cut) for cut in cuts), *(_corners(fold) for fold in folds)]
        change = np.zeros((len(self.nodes), 2))
        for number, (before, after) in enumerate(zip(self.lines, lines)):
            on = np.flatnonzero(self._line == number)
            piece, t = self._piece[on], self._share[on][:, None]
            motion = after - before
            change[on] = (1 - t) * motion[piece, 0] + t * motion[piece, 1]
        self._slide(change, lines)
        return change

    def _slide(self, change: Floats, lines: list[Floats]) -> None:
        """Where a cut that reaches the outline moves along it, the nodes of the outline beside it slide as well."""
        place = {node: k for k, node in enumerate(self.nodes.tolist())}
        anchors: dict[int, list[tuple[float, Floats]]] = {}
        for node, (cut, piece, rim) in self._crossing.items():
            start, end = lines[0][rim]
            a, b = lines[cut][piece]
            k = place[node]
            cross = _cross(end - start, b - a)
            t = _cross(a - start, b - a) / cross if abs(cross) > 1e-12 * self.mesh.size**2 else float(self._share[k])
            shift = start + t * (end - start) - self.mesh.nodes[node, :2]
            anchors.setdefault(rim, []).append((float(self._share[k]), shift - change[k]))
            change[k] = shift
        for rim, known in anchors.items():
            known = sorted([*known, (0.0, np.zeros(2)), (1.0, np.zeros(2))], key=lambda pair: pair[0])
            shares, shifts = np.array([s for s, _ in known]), np.array([shift for _, shift in known])
            on = np.flatnonzero((self._line == 0) & (self._piece == rim))
            on = np.array([k for k in on if int(self.nodes[k]) not in self._crossing], dtype=np.int64)
            for axis in (0, 1):
                change[on, axis] += np.interp(self._share[on], shares, shifts[:, axis])


def _cross(a: Floats, b: Floats) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _corners(geometry: Any) -> Floats:
    """Straight pieces (k, 2, 2) of a line or polygon."""
    rings = [geometry] if not isinstance(geometry, shapely.Polygon) else [geometry.exterior, *geometry.interiors]
    parts = [np.asarray(ring.coords)[:, :2] for ring in rings]
    return np.concatenate([np.stack([part[:-1], part[1:]], axis=1) for part in parts])


def _nearest(pieces: Floats, point: Floats) -> tuple[float, int, float]:
    """Distance of a point from straight pieces, the nearest of them, and where along it."""
    start, along = pieces[:, 0], pieces[:, 1] - pieces[:, 0]
    share = np.clip(((point - start) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    distance = np.linalg.norm(start + share[:, None] * along - point, axis=1)
    best = int(np.argmin(distance))
    return float(distance[best]), best, float(share[best])


def check_topology(
    outline: shapely.Polygon, cuts: tuple[Any, ...], before: tuple[shapely.Polygon, tuple[Any, ...]], who: str
) -> None:
    """Raise a GeometryError where cuts differ from those `before` in number, kind or corners, cross, or leave."""
    if len(cuts) != len(before[1]):
        raise GeometryError(
            f"{who}: {counted(len(cuts), 'cut')} in the place of {len(before[1])}: their number must stay"
        )
    for number, (one, other) in enumerate(zip((outline, *cuts), (before[0], *before[1])), start=-1):
        name = f"cut {number}" if number >= 0 else "the outline"
        if type(one) is not type(other) or len(_corners(one)) != len(_corners(other)):
            raise GeometryError(f"{who}: {name} has another kind or number of corners than before")
        if not one.is_valid or not one.is_simple:
            raise GeometryError(f"{who}: {name} crosses itself")
    listed = np.empty(len(cuts), dtype=object)
    listed[:] = cuts
    met = shapely.STRtree(listed).query(listed, predicate="intersects") if len(cuts) else np.empty((2, 0), np.int64)
    for a, b in met.T.tolist():
        if a < b:
            x, y = shapely.get_coordinates(cuts[a].intersection(cuts[b]))[0]
            raise GeometryError(f"{who}: cuts {a} and {b} meet at ({x:.6g}, {y:.6g}): they must stay apart")
    for number, (cut, old) in enumerate(zip(cuts, before[1])):
        was, now = before[0].contains_properly(old), outline.contains_properly(cut)
        if was != now or not cut.intersects(outline):
            x, y = shapely.get_coordinates(cut)[0]
            raise GeometryError(
                f"{who}: cut {number} at ({x:.6g}, {y:.6g}) {'reaches the outline' if was else 'leaves it'}, and did "
                "not before"
            )
