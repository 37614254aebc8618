"""Sheets on five patterns of mesh, for the tests of what a rung must pass on every one of them."""

from __future__ import annotations

import numpy as np

import kirigami as kg

PATTERNS = ("mesher", "single", "alternating", "crossed", "random")


def rectangle(pattern: str, length: float, width: float, across: int, seed: int = 0) -> kg.TriMesh:
    """Rectangle with its corner at the origin, `across` edges over its width.

    "random" moves the nodes of squares by up to 0.3 of their side and turns diagonals at random; angles go down to
    some twenty degrees.
    """
    side = width / across
    if pattern == "mesher":
        return kg.Sheet([(0, 0), (length, 0), (length, width), (0, width)]).mesh(1.2 * side)
    columns = max(1, round(length / side))
    x, y = np.meshgrid(np.linspace(0, length, columns + 1), np.linspace(0, width, across + 1), indexing="ij")
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    at = np.arange(len(points)).reshape(columns + 1, across + 1)
    random = np.random.default_rng(seed)
    triangles = []
    for i in range(columns):
        for j in range(across):
            a, b, c, d = at[i, j], at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]
            if pattern == "crossed":
                middle = len(points)
                points = np.concatenate([points, points[[a, b, c, d]].mean(axis=0)[None]])
                triangles += [(a, b, middle), (b, c, middle), (c, d, middle), (d, a, middle)]
                continue
            turned = {"single": False, "alternating": (i + j) % 2 == 1, "random": random.random() < 0.5}[pattern]
            triangles += [(a, b, d), (b, c, d)] if turned else [(a, b, c), (a, c, d)]
    if pattern == "random":
        # Nodes inside move freely and those of the sides along them.
        step = 0.3 * random.uniform(-1, 1, points.shape) * (length / columns, side)
        step[(points[:, 0] < 1e-9) | (points[:, 0] > length - 1e-9), 0] = 0.0
        step[(points[:, 1] < 1e-9) | (points[:, 1] > width - 1e-9), 1] = 0.0
        points = points + step
    return kg.TriMesh(points, np.array(triangles))


def on(values: np.ndarray, place: float) -> np.ndarray:
    """Indices of coordinates at a place."""
    return np.flatnonzero(np.abs(values - place) < 1e-9)


def line_load(system: kg.System, nodes: np.ndarray) -> np.ndarray:
    """Weights (rows,) of a uniform load of unit total along the boundary edges between nodes, also on their middles."""
    edges = system.edges
    inside = np.isin(edges.ends, nodes).all(axis=1) & (np.bincount(edges.edge.ravel()) == 1)
    share = edges.length[inside] / edges.length[inside].sum()
    weights = np.zeros(len(system.rest))
    np.add.at(weights, edges.ends[inside], 0.5 * share[:, None])
    weights[edges.middle[inside]] = 2 / 3 * share
    return weights


def tributary(places: np.ndarray) -> np.ndarray:
    """Share of each of some points on a line in its length, summing to one."""
    order = np.argsort(places)
    gaps = np.diff(places[order])
    share = np.zeros(len(places))
    share[order[:-1]] += 0.5 * gaps
    share[order[1:]] += 0.5 * gaps
    return share / share.sum()
