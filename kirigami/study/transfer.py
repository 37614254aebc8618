"""A state of a sheet carried over to another mesh of the same sheet, and brought to equilibrium there.

So that two meshes, or two rungs, can be compared on one shape: the finer one starts from the shape of the coarser one
instead of looking for its own way through every buckle.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.analysis.path.methods import DisplacementControl
from kirigami.elements.smooth_normals import bulges, corner_normals
from kirigami.errors import ConvergenceError, ModelError
from kirigami.geometry.mesh import TriMesh
from kirigami.model.model import Model
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.step import Step
from kirigami.study.shape.space import _barycentric
from kirigami.system.system import System

Index = NDArray[np.int64]
INWARD = 1e-3  # share of the way to the middle of its facet from where the place of a corner is looked up


def carried(results: Results, step: int, mesh: TriMesh) -> Array:
    """Displacements (n, 3) of the nodes of another mesh of the sheet at a stored step.

    Between the nodes the deformed sheet is taken as the quadratic surface whose edges bulge as the normals at the nodes
    say. A node is looked up from inside its facets, so that the lips of a cut stay apart.
    """
    old = results.mesh
    if old is None:
        raise ModelError("carried: the results have no mesh")
    count = len(old.nodes)
    x = results.rest[:count] + results.u[step, :count]
    triangles = old.triangles
    edge = _edge_numbers(triangles)
    free = np.bincount(edge.ravel()) < 2
    normals = corner_normals(x, triangles, edge, np.zeros(len(free), dtype=bool))
    ends = np.stack([x[triangles], x[np.roll(triangles, -1, axis=1)]], axis=2).reshape(-1, 2, 3)
    at_ends = np.stack([normals, np.roll(normals, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    bulge = np.zeros((len(free), 3))
    np.add.at(bulge, edge.ravel(), bulges(ends, at_ends))
    bulge /= np.bincount(edge.ravel())[:, None]
    # every corner of every facet of the other mesh, looked up a little inside
    corners = mesh.nodes[mesh.triangles][:, :, :2]
    inside = corners + INWARD * (corners.mean(axis=1, keepdims=True) - corners)
    facets = _holding(old, inside.reshape(-1, 2))
    shares = _barycentric(old.nodes[triangles[facets]][:, :, :2], corners.reshape(-1, 2))
    place = np.einsum("pc,pck->pk", shares, x[triangles[facets]])
    products = 4 * shares * np.roll(shares, -1, axis=1)
    place += np.einsum("pe,pek->pk", products, bulge[edge[facets]])
    rest = np.einsum("pc,pck->pk", shares, old.nodes[triangles[facets]])
    moved = np.zeros((len(mesh.nodes), 3))
    np.add.at(moved, mesh.triangles.ravel(), place - rest)
    return np.asarray(moved / np.bincount(mesh.triangles.ravel(), minlength=len(mesh.nodes))[:, None])


def _edge_numbers(triangles: Index) -> Index:
    pairs = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    return np.asarray(np.unique(pairs, axis=0, return_inverse=True)[1].reshape(-1, 3))


def _holding(mesh: TriMesh, points: Array) -> Index:
    """The facet (p,) in which each point (p, 2) lies, or the nearest."""
    tree = shapely.STRtree(shapely.polygons(mesh.nodes[mesh.triangles][:, :, :2]))
    places = shapely.points(points)
    point, facet = tree.query(places, predicate="intersects")
    found = np.full(len(points), -1)
    found[point[::-1]] = facet[::-1]
    lost = np.flatnonzero(found < 0)
    if lost.size:
        nearest = tree.query_nearest(places[lost], all_matches=False)
        found[lost[nearest[0]]] = nearest[1]
    return found


def step_on(model: Model, results: Results, step: int) -> Step:
    """The state of results at a step as a step of a model on another mesh of the sheet, with its supports in place."""
    if model.mesh is None:
        raise ModelError("step_on: the model has no mesh")
    lam = results[step].lam
    system = System(model)
    moved = carried(results, step, model.mesh) + model.mesh.nodes - model.positions()
    rows = system.settled(moved)
    nodal, inner = system.parted(system.displacement(system.unknowns(rows), lam))
    return Step(lam, nodal, inner=inner, history=system.history, stage=model.stage, stage_key=model.stage_key)


def on_shape(model: Model, results: Results, steps: Iterable[int], tol: float = 1e-8) -> list[Results | None]:
    """Equilibria of a model, on another mesh of the sheet, in the shapes that results have at some of their steps.

    The supports of the model must drive it to the same load factors. None where no equilibrium is found.
    """
    found: list[Results | None] = []
    for step in steps:
        start = step_on(model, results, step)
        try:
            found.append(DisplacementControl(model, to=start.lam, start=start, tol=tol).run())
        except ConvergenceError:
            found.append(None)
    return found
