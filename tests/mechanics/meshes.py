"""Small meshes for the tests of mechanics: pure numpy and scipy, so that these tests stand without the mesher.

The constants of bars and hinges are computed here from their published formulas and never taken from the package,
so that a wrong formula in the package cannot hide behind itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, Voronoi

import kirigami as kg

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SIXTY_DEGREES = np.sqrt(3.0) / 2.0  # row height of an equilateral mesh of unit edge


# ---------------------------------------------------------------------------------------------- finite patches


def right_isosceles(columns: int, rows: int, edge: float = 1.0, diagonals: str = "one") -> tuple[Floats, Ints]:
    """Squares cut by a diagonal: ``"one"`` direction, ``"union jack"`` or ``"alternating"`` by column.

    Node of column i and row j is ``j * (columns + 1) + i``.
    """
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    nodes = edge * np.column_stack([x.ravel(), y.ravel()])
    triangles = []
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i
            b, c, d = a + 1, a + columns + 2, a + columns + 1
            if _rising(i, j, diagonals):
                triangles += [(a, b, c), (a, c, d)]
            else:
                triangles += [(a, b, d), (b, c, d)]
    return nodes, np.array(triangles)


def _rising(i: int, j: int, diagonals: str) -> bool:
    return {"one": True, "union jack": (i + j) % 2 == 0, "alternating": i % 2 == 0}[diagonals]


def equilateral_parallelogram(columns: int, rows: int, edge: float = 1.0) -> tuple[Floats, Ints]:
    """Equilateral triangles only, in the outline of a parallelogram that leans back by 30 degrees."""
    nodes, triangles = right_isosceles(columns, rows, edge)
    return np.column_stack([nodes[:, 0] - nodes[:, 1] / 2, SIXTY_DEGREES * nodes[:, 1]]), triangles


def equilateral_strip(columns: int, rows: int, edge: float = 1.0) -> tuple[Floats, Ints]:
    """Rows of equilateral triangles, edges along x; half triangles close the two ends, so the outline is a rectangle.

    Length ``columns * edge``, width ``rows * edge * sqrt(3) / 2``.
    """
    nodes: list[tuple[float, float]] = []
    layers: list[list[int]] = []
    for j in range(rows + 1):
        xs = np.arange(columns + 1.0) if j % 2 == 0 else np.r_[0.0, np.arange(columns) + 0.5, float(columns)]
        layers.append(list(range(len(nodes), len(nodes) + len(xs))))
        nodes += [(edge * x, edge * SIXTY_DEGREES * j) for x in xs]
    triangles = []
    for j in range(rows):
        lower, upper = layers[j], layers[j + 1]
        whole, staggered = (lower, upper) if j % 2 == 0 else (upper, lower)
        fan = [(whole[i], whole[i + 1], staggered[i + 1]) for i in range(columns)]
        fan += [(whole[i], staggered[i + 1], staggered[i]) for i in range(columns + 1)]
        triangles += fan
    return np.array(nodes), counter_clockwise(np.array(nodes), np.array(triangles))


def counter_clockwise(nodes: Floats, triangles: Ints) -> Ints:
    """The same triangles, all with their normal along +z."""
    backward = signed_area(nodes, triangles) < 0
    turned = triangles.copy()
    turned[backward] = turned[backward][:, ::-1]
    return turned


def signed_area(nodes: Floats, triangles: Ints) -> Floats:
    """Signed area of plane triangles."""
    a, b, c = (nodes[triangles[:, v], :2] for v in range(3))
    u, v = b - a, c - a
    return 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def open_slit(nodes: Floats, triangles: Ints, slit: list[int]) -> tuple[Floats, Ints]:
    """Unzip the mesh along a chain of nodes (y constant): inner nodes get a twin that the facets above keep.

    The first and the last node of the chain are the tips and stay single.
    """
    height = nodes[slit[0], 1]
    above = nodes[triangles].mean(axis=1)[:, 1] > height
    triangles = triangles.copy()
    twins: list[Floats] = []
    for old in slit[1:-1]:
        new = len(nodes) + len(twins)
        twins.append(nodes[old])
        triangles[(triangles == old) & above[:, None]] = new
    return np.vstack([nodes, np.array(twins)]), triangles


# ---------------------------------------------------------------------------------------------- bars and hinges


@dataclass(frozen=True)
class Edges:
    """Unique edges of a mesh with the areas and the opposite nodes of the one or two facets that share each."""

    ends: Ints  # (m, 2)
    area: Floats  # (m,) sum over the adjacent facets
    inner: NDArray[np.bool_]  # (m,) shared by two facets
    wings: Ints  # (m, 2) opposite node of each facet, -1 where there is none


def edges_of(nodes: Floats, triangles: Ints) -> Edges:
    """Collect edges, adjacent areas and wings; the first wing lies left of the edge (i.e. (j, k, i) faces +z)."""
    area = facet_area(nodes, triangles)
    found: dict[tuple[int, int], dict[str, Any]] = {}
    for facet, corners in enumerate(triangles):
        for v in range(3):
            j, k, i = (int(corners[(v + s) % 3]) for s in range(3))
            entry = found.setdefault((min(j, k), max(j, k)), {"area": 0.0, "oriented": (j, k), "wings": []})
            entry["area"] += area[facet]
            entry["wings"].append(i)
    return Edges(
        np.array([entry["oriented"] for entry in found.values()]),
        np.array([entry["area"] for entry in found.values()]),
        np.array([len(entry["wings"]) == 2 for entry in found.values()]),
        np.array([(entry["wings"] + [-1])[:2] for entry in found.values()]),
    )


def facet_area(nodes: Floats, triangles: Ints) -> Floats:
    """Area of triangles in space."""
    points = nodes if nodes.shape[1] == 3 else np.column_stack([nodes, np.zeros(len(nodes))])
    a, b, c = (points[triangles[:, v]] for v in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def sheet(
    nodes: Floats,
    triangles: Ints,
    modulus: float = 1.0,
    thickness: float = 1.0,
    *,
    membrane: float = 1.0,
    bending: float = 1.0,
    strain: str = "green",
) -> tuple[kg.Model, tuple[kg.Node, ...]]:
    """Bars ``EA = F_s E t sum(A) / L`` and hinges ``k = c E t^3 L^2 / (A1 + A2)`` on a mesh, added one by one.

    ``membrane`` is F_s and ``bending`` is c. Returns the model and its nodes in mesh order.
    """
    edges = edges_of(nodes, triangles)
    length = np.linalg.norm(nodes[edges.ends[:, 0]] - nodes[edges.ends[:, 1]], axis=1)
    axial = membrane * modulus * thickness * edges.area / length
    rotational = bending * modulus * thickness**3 * length**2 / edges.area
    model = kg.Model()
    points = model.add(*(kg.Node(*map(float, point)) for point in nodes))
    model.add(*(kg.Bar(points[a], points[b], float(s), strain=strain) for (a, b), s in zip(edges.ends, axial)))
    hinges = [
        kg.BendHinge(points[i], points[j], points[k], points[l], float(s))
        for (j, k), (i, l), s, inner in zip(edges.ends, edges.wings, rotational, edges.inner)
        if inner and bending
    ]
    if hinges:
        model.add(*hinges)
    return model, points


def chain(points: Floats, stiffness: float, axial: float, **options: Any) -> tuple[kg.Model, tuple[kg.Node, ...]]:
    """A plane Hencky chain: bars of axial stiffness EA between the points, an angle spring at each inner one."""
    model = kg.Model(dim=2)
    nodes = model.add(*(kg.Node(float(x), float(y)) for x, y in points))
    model.add(*(kg.Bar(a, b, axial, **options) for a, b in pairwise(nodes)))
    model.add(*(kg.TorsionSpring3(a, b, c, stiffness) for a, b, c in zip(nodes, nodes[1:], nodes[2:])))
    return model, nodes


# ---------------------------------------------------------------------------------------------- periodic cells


@dataclass(frozen=True)
class PeriodicMesh:
    """A triangulation of the torus: corners of facets are cell nodes, moved by whole periods."""

    points: Floats  # (n, 2) nodes of the cell
    periods: Floats  # (2, 2) rows are the two lattice vectors
    corners: Ints  # (m, 3) node of the cell
    shifts: Ints  # (m, 3, 2) periods to add to each corner

    @property
    def area(self) -> float:
        return abs(float(np.linalg.det(self.periods)))


def periodic_right_isosceles(diagonals: str) -> PeriodicMesh:
    """Two by two squares of unit side, the smallest cell of all three arrangements of diagonals."""
    corners, shifts = [], []
    for j in range(2):
        for i in range(2):
            a, b, c, d = (i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)
            for facet in ((a, b, c), (a, c, d)) if _rising(i, j, diagonals) else ((a, b, d), (b, c, d)):
                corners.append([(p % 2) + 2 * (q % 2) for p, q in facet])
                shifts.append([(p // 2, q // 2) for p, q in facet])
    points = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)])
    return PeriodicMesh(points, 2.0 * np.eye(2), np.array(corners), np.array(shifts))


def periodic_equilateral(columns: int, rows: int, jitter: float = 0.0, seed: int = 0) -> PeriodicMesh:
    """Equilateral cells of unit edge (rows even), each node moved by up to ``jitter`` in a random direction pair."""
    corners, shifts = [], []
    for j in range(rows):
        for i in range(columns):
            even = j % 2 == 0
            a, b = (i, j), (i + 1, j)
            c, d = ((i, j + 1), (i - 1, j + 1)) if even else ((i + 1, j + 1), (i, j + 1))
            for facet in ((a, b, c), (a, c, d)):
                corners.append([(p % columns) + columns * (q % rows) for p, q in facet])
                shifts.append([(p // columns, q // rows) for p, q in facet])
    column, row = np.meshgrid(np.arange(columns), np.arange(rows))
    points = np.column_stack([(column + 0.5 * (row % 2)).ravel(), SIXTY_DEGREES * row.ravel()])
    points = points + np.random.default_rng(seed).uniform(-jitter, jitter, points.shape)
    periods = np.diag([float(columns), SIXTY_DEGREES * rows])
    return PeriodicMesh(points, periods, np.array(corners), np.array(shifts))


def periodic_strip(columns: int, rows: int) -> PeriodicMesh:
    """Equilateral rows of unit edge along x: periodic along x, free sides; the second period is the width."""
    torus = periodic_equilateral(columns, rows + 2 - rows % 2)
    below_top = np.repeat(np.arange(rows + 2 - rows % 2), 2 * columns) < rows  # two facets per column and row
    points = torus.points[: columns * (rows + 1)]
    periods = np.diag([float(columns), SIXTY_DEGREES * rows])
    return PeriodicMesh(points, periods, torus.corners[below_top], torus.shifts[below_top])


def periodic_lloyd(count: int, passes: int, seed: int) -> PeriodicMesh:
    """Random points on the unit torus, moved ``passes`` times to the centroids of their Voronoi cells."""
    points = np.random.default_rng(seed).random((count, 2))
    for _ in range(passes):
        points = _voronoi_centroids(points)
    images, node, shift = _with_images(points)
    corners = Delaunay(images).simplices
    # Every facet of the torus has exactly one image whose centroid lies in the unit cell.
    centroid = images[corners].mean(axis=1)
    kept = corners[np.all((centroid >= 0.0) & (centroid < 1.0), axis=1)]
    kept = counter_clockwise(images, kept)
    return PeriodicMesh(points, np.eye(2), node[kept], shift[kept])


def _with_images(points: Floats, margin: float = 0.3) -> tuple[Floats, Ints, Ints]:
    """Points of the unit torus and those of their images that lie within ``margin`` of the cell."""
    grid = np.array([(p, q) for p in (-1, 0, 1) for q in (-1, 0, 1)])
    images = (points[None] + grid[:, None]).reshape(-1, 2)
    node = np.tile(np.arange(len(points)), len(grid))
    shift = np.repeat(grid, len(points), axis=0)
    near = np.all((images > -margin) & (images < 1.0 + margin), axis=1)
    return images[near], node[near], shift[near]


def _voronoi_centroids(points: Floats) -> Floats:
    images, node, shift = _with_images(points)
    diagram = Voronoi(images)
    ridge = np.array(diagram.ridge_vertices)
    bounded = np.all(ridge >= 0, axis=1)
    first, second = (diagram.vertices[ridge[bounded, v]] for v in range(2))
    area, moment = np.zeros(len(images)), np.zeros((len(images), 2))
    for side in range(2):
        # A Voronoi cell is the fan of triangles from its site to its ridges.
        site = diagram.ridge_points[bounded, side]
        u, v = first - images[site], second - images[site]
        piece = 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
        np.add.at(area, site, piece)
        np.add.at(moment, site, piece[:, None] * (images[site] + first + second) / 3.0)
    own = np.flatnonzero(np.all(shift == 0, axis=1))
    centroid = np.empty_like(points)
    centroid[node[own]] = moment[own] / area[own, None]
    return centroid % 1.0


@dataclass(frozen=True)
class UnitCell:
    """A periodic mesh cut open: real nodes, images that copy them, and one bar and hinge per edge of the torus."""

    model: kg.Model
    nodes: tuple[kg.Node, ...]
    position: Floats  # (N, 2)
    leader: Ints  # (N,) node of the cell that each node copies
    count: int  # nodes of the cell
    area: float


def unit_cell(mesh: PeriodicMesh, membrane: float = 1.0, bending: float = 1.0) -> UnitCell:
    """Bars and hinges of one period (E = t = 1); nodes outside the cell are images, to be tied to their leaders."""
    position = mesh.points[mesh.corners] + mesh.shifts @ mesh.periods
    areas = facet_area(position.reshape(-1, 2), np.arange(position.size // 2).reshape(-1, 3))
    edges: dict[Any, list[Any]] = {}
    for facet in range(len(mesh.corners)):
        for v in range(3):
            j, k, i = (((v + s) % 3) for s in range(3))
            ends = [(int(mesh.corners[facet, c]), *map(int, mesh.shifts[facet, c])) for c in (j, k, i)]
            if ends[0][0] > ends[1][0] or (ends[0][0] == ends[1][0] and ends[0][1:] > ends[1][1:]):
                ends = [ends[1], ends[0], ends[2]]
            # Move the edge so that its first end is the real node: edges that are images of each other then agree.
            origin = ends[0][1:]
            moved = [(n, p - origin[0], q - origin[1]) for n, p, q in ends]
            edges.setdefault((moved[0], moved[1]), []).append((moved[2], areas[facet]))
    index: dict[tuple[int, int, int], int] = {(n, 0, 0): n for n in range(len(mesh.points))}
    bars, hinges = [], []
    for (first, second), sides in edges.items():
        shared = sum(area for _, area in sides)
        j, k, *wings = (index.setdefault(corner, len(index)) for corner in (first, second, *(w for w, _ in sides)))
        bars.append((j, k, shared))
        if len(wings) == 2:
            hinges.append((wings[0], j, k, wings[1], shared))
    leader = np.array([n for n, _, _ in index])
    place = mesh.points[leader] + np.array([(p, q) for _, p, q in index]) @ mesh.periods
    model = kg.Model()
    nodes = model.add(*(kg.Node(float(x), float(y)) for x, y in place))
    for j, k, shared in bars:
        model.add(kg.Bar(nodes[j], nodes[k], float(membrane * shared / np.linalg.norm(place[j] - place[k]))))
    for i, j, k, l, shared in hinges:
        stiffness = bending * float(np.sum((place[j] - place[k]) ** 2)) / shared
        model.add(kg.BendHinge(nodes[i], nodes[j], nodes[k], nodes[l], float(stiffness)))
    return UnitCell(model, nodes, place, leader, len(mesh.points), mesh.area)
