"""The shells that others published numbers for, as models of shell facets with exact normals.

References: Sze, Liu and Lo, Popular benchmark problems for geometric nonlinear analysis of shells, Finite Elements in
Analysis and Design 40 (2004) 1551-1569; MacNeal and Harder, A proposed standard set of problems to test finite element
accuracy, Finite Elements in Analysis and Design 1 (1985) 3-20.
"""

from __future__ import annotations

import warnings

import numpy as np

import kirigami as kg


def grid(columns, rows, place, pattern="alternating", closed=False):
    """Nodes place(u, v) on squares cut in facets, and their numbers (columns + 1, rows + 1)."""
    u, v = np.meshgrid(np.arange(columns + 1) / columns, np.arange(rows + 1) / rows, indexing="ij")
    at = np.arange((columns + 1) * (rows + 1)).reshape(columns + 1, rows + 1)
    if closed:
        at[-1] = at[0]
    points = np.moveaxis(np.array(np.broadcast_arrays(*place(u, v)), float), 0, -1).reshape(-1, 3)
    triangles = []
    for i in range(columns):
        for j in range(rows):
            a, b, c, d = at[i, j], at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]
            if pattern == "single" or (i + j) % 2 == 0:
                triangles += [(a, b, c), (a, c, d)]
            else:
                triangles += [(a, b, d), (b, c, d)]
    return points[: at[columns - closed].max() + 1], np.array(triangles), at


def surface(rung, points, triangles, thickness, material, normals=None):
    """A model of one rung on given facets, and its nodes; shell facets take normals given by point."""
    if rung != "shell":
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", kg.KirigamiWarning)  # of biased meshes: the figures say it
            model = kg.Model.from_mesh(kg.TriMesh(points, triangles), thickness, material, stiffness=rung)
        return model, list(model.nodes)
    return shell(points, triangles, thickness, material, normals)


def pattern_of(rung):
    """Diagonals of squares: alternating ones for the shell, parallel ones, which suit hinges best, for the others."""
    return "alternating" if rung == "shell" else "single"


def shell(points, triangles, thickness, material, normals=None):
    """A model of shell facets, whose normals are given by point, and its nodes."""
    model = kg.Model()
    nodes = [model.add(kg.Node(*point)) for point in points.tolist()]
    if normals is not None:
        corner = points[triangles]
        up = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        triangles = np.where((up * normals[triangles[:, 0]]).sum(axis=1)[:, None] < 0, triangles[:, ::-1], triangles)
    for facet in triangles.tolist():
        given = None if normals is None else normals[facet]
        model.add(kg.ShellFacet(*(nodes[k] for k in facet), thickness, material, normals=given))
    return model, nodes


def hold(model, nodes, mirrors=None, supports=None):
    """Mirror planes and supports, each a dictionary of node numbers by axis."""
    taken = {}
    for axis, numbers in (mirrors or {}).items():
        taken[axis] = set(numbers)
        model.add(kg.Symmetry([nodes[k] for k in sorted(taken[axis])], axis))
    for axis, numbers in (supports or {}).items():
        left = sorted(set(numbers) - taken.get(axis, set()))
        if left:
            model.add(kg.Fix([nodes[k] for k in left], axis))


def near(points, place):
    """Number of the node at a place."""
    return int(np.argmin(np.linalg.norm(points - np.asarray(place, float), axis=1)))


def at_zero(values, place=0.0):
    return np.flatnonzero(np.abs(values - place) < 1e-6 * (np.ptp(values) or 1.0)).tolist()


def around_x(points):
    """Normals of a cylinder about the x axis."""
    radial = points * (0, 1, 1)
    return radial / np.linalg.norm(radial, axis=1)[:, None]


def hemisphere(n, exact=True, rung="shell"):
    """Sze 3.4, an octant pair: half of the hemisphere's quarter with an 18 degree hole, pinched; probes B, -A."""
    radius, top = 10.0, np.radians(72)
    points, triangles, _ = grid(n, n, lambda u, v: (
        radius * np.cos(np.pi / 2 * u) * np.cos(v * top), radius * np.sin(np.pi / 2 * u) * np.cos(v * top),
        radius * np.sin(v * top)), pattern_of(rung))  # fmt: skip
    model, nodes = surface(rung, points, triangles, 0.04, kg.Material(6.825e7, 0.3),
                           points / radius if exact else None)  # fmt: skip
    hold(model, nodes, {"x": at_zero(points[:, 0]), "y": at_zero(points[:, 1])}, {"z": [near(points, (0, radius, 0))]})
    return model, nodes, points, radius


def cylinder(columns, rows, radius, length, thickness, material, rung="shell"):
    """An octant of a cylinder about the x axis: half its length, a quarter of its circle."""
    points, triangles, _ = grid(columns, rows, lambda u, v: (
        0.5 * length * v, radius * np.cos(np.pi / 2 * u), radius * np.sin(np.pi / 2 * u)), pattern_of(rung)
    )  # fmt: skip
    return (*surface(rung, points, triangles, thickness, material, around_x(points)), points)
