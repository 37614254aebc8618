"""Which edges of a sheet its clamps and mirror planes hold, and the members that hold them.

A set of nodes holds the edges with both ends in it that lie on the boundary of the sheet, and those of facets that are
wholly in it (:func:`kirigami.geometry.topology.edges_within`, for every rung). Facets in the set keep their direction
by their nodes; boundary edges need members that keep it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.clamp_hinge import HeldEdgeKernel
from kirigami.elements.facet import (
    curvature_from_folds,
    fold_stiffness,
    rigidity_of,
    softness_beyond,
    without_fold,
)
from kirigami.elements.stiffness import hinge_stiffness
from kirigami.elements.triangle import ENDS, STARTS, edge_vectors, flat_edges
from kirigami.errors import ModelError
from kirigami.geometry.topology import edges_within
from kirigami.primitives.kernel import Array, Kernel
from kirigami.primitives.node import AXES
from kirigami.primitives.parts import Numbering

Index = NDArray[np.int64]
IN_PLANE = 1e-9  # distance from a mirror plane, over the size of the structure, that is none
RIGHT_ROUND = np.radians(170.0)  # an edge that turns by half a turn does not say which way it came


def facet_edges(mesh: Any) -> Index:
    """Edges (m, 3) of the facets of a mesh, each opposite its corner."""
    found = np.empty((len(mesh.triangles), 3), np.int64)
    for side in range(2):
        edge = np.flatnonzero(mesh.edge_facets[:, side] >= 0)
        facet = mesh.edge_facets[edge, side]
        corner = np.argmax(mesh.triangles[facet] == mesh.edge_wings[edge, side][:, None], axis=1)
        found[facet, corner] = edge
    return found


def check_held(item: Any, numbering: Numbering) -> None:
    """Refuse a clamp or a mirror plane where nothing of the sheet can be held, in words.

    Raises
    ------
    ModelError
        No mesh, no boundary edge and no whole facet among the nodes; for a mirror plane nodes that are not in one
        plane, or a sheet that lies in it.
    """
    said = "clamp=True" if item.clamp else "a mirror plane"
    mesh, rows, nodes = numbering.mesh, numbering.edges, numbering.index(item.group)
    if rows is not None:
        triangles, table, ends = rows.triangles, rows.edge, rows.ends
    elif mesh is not None and numbering.sheet is not None:
        triangles, table, ends = mesh.triangles, facet_edges(mesh), mesh.edges
    else:
        raise ModelError(f"{item!r}: {said} needs a model made by Model.from_mesh: other models have no facets to hold")
    first = numbering.describe(int(nodes[0]))
    inside = np.isin(np.arange(len(numbering.nodes)), nodes)
    alone = np.bincount(table.ravel(), minlength=len(ends)) == 1
    held = edges_within(table, ends, inside) if item.clamp else alone & inside[ends].all(axis=1)
    if not held.any():
        raise ModelError(
            f"{item!r} has {said}, but its nodes hold no edge on the boundary{' and no whole facet' * item.clamp} (the "
            f"first is {first}): select both ends of edges"
        )
    if item.mirror:
        axis = AXES.index(item.mirror)
        if axis >= numbering.dim:
            raise ModelError(f"{item!r}: a mirror plane across z holds nothing in a model with dim=2")
        away = np.abs(numbering.rest[nodes, axis] - numbering.rest[nodes[0], axis])
        far = int(nodes[int(np.argmax(away))])
        if away.max() > IN_PLANE * numbering.size:
            raise ModelError(
                f"{item!r}: its nodes do not lie in one plane across {item.mirror}; {first} and "
                f"{numbering.describe(far)} are {away.max():.3g} apart along it"
            )
        beside = triangles[held[table].any(axis=1)]
        wings = nodes[:1] if inside[beside].all(axis=1).any() else beside[~inside[beside]]
        off = np.abs(numbering.rest[wings, axis] - numbering.rest[nodes[0], axis])
        if off.min() <= IN_PLANE * numbering.size:
            there = numbering.describe(int(wings[int(np.argmin(off))]))
            raise ModelError(f"{item!r}: the sheet lies in the mirror plane at {there}; it must meet it at an edge")


def _on_boundary(mesh: Any, nodes: Index) -> NDArray[np.bool_]:
    return np.asarray((mesh.edge_facets[:, 1] < 0) & np.isin(mesh.edges, nodes).all(axis=1))


def held_edge_kernels(holding: Sequence[Any], numbering: Numbering) -> list[Kernel]:
    """Members that keep the direction of the sheet at the boundary edges that clamps and mirror planes hold.

    `holding` are all of them together, since a facet may meet two. On rungs that have unknowns of their own for the
    direction of an edge, nothing is made: there it is eliminated.
    """
    for item in holding:
        if item.mirror or numbering.dim == 3:
            check_held(item, numbering)
    if numbering.dim == 2 or numbering.edges is not None:
        return []
    mesh = numbering.mesh
    normals: dict[int, Array] = {}  # of the mirror plane at each edge held; zero where its direction is carried along
    for item in holding:
        nodes = numbering.index(item.group)
        whole = np.asarray(np.isin(mesh.triangles, nodes).all(axis=1))
        held_by_nodes = not item.mirror and len(item.values) == 3  # so are facets that are wholly in the set
        normal = np.eye(3)[AXES.index(item.mirror)] if item.mirror else np.zeros(3)
        for edge in np.flatnonzero(_on_boundary(mesh, nodes)).tolist():
            if not (held_by_nodes and whole[mesh.edge_facets[edge, 0]]):
                _check_turn(item, mesh.nodes[mesh.edges[edge]])
                normals.setdefault(edge, normal)
    if not normals:
        return []
    edges = np.array(sorted(normals), dtype=np.int64)
    planes = np.array([normals[edge] for edge in edges.tolist()])
    make = _facet_members if numbering.sheet.rung == "facet" else _hinge_members
    return make(edges, planes, numbering)


def _check_turn(item: Any, ends: Array) -> None:
    """Refuse to turn an edge where its direction could not go along: about itself, or right round."""
    rotation = item.rotation
    if rotation is None or not rotation.any():
        return
    along = (ends[1] - ends[0]) @ rotation / (np.linalg.norm(ends[1] - ends[0]) * np.linalg.norm(rotation))
    if abs(along) > IN_PLANE or np.linalg.norm(rotation) > RIGHT_ROUND:
        how = "about itself" if abs(along) > IN_PLANE else "right round"
        raise ModelError(
            f"{item!r} with clamp=True turns the edge at ({ends[0][0]:.6g}, {ends[0][1]:.6g}) {how}, which bars "
            "and hinges and flat facets cannot follow: turn a strip of whole facets, or take stiffness='shell'"
        )


def _hinge_members(edges: Index, planes: Array, numbering: Numbering) -> list[Kernel]:
    """One member for each edge of a sheet of bars and hinges."""
    mesh, sheet = numbering.mesh, numbering.sheet
    conn = np.column_stack([mesh.edge_wings[edges, 0], mesh.edges[edges]])
    # The constant of an edge with one facet is D L^2 / A, just what is needed.
    stiffness = hinge_stiffness(mesh, sheet.thickness, sheet.of_facets("E"), sheet.of_facets("c"))[edges]
    own = np.arange(len(edges))
    at = np.tile([0, 1, 2], (len(edges), 1))
    none = np.empty(0, np.int64), np.empty((0, 4), np.int64), np.empty(0)
    carried = np.asarray(~planes.any(axis=1))
    kernel = HeldEdgeKernel(numbering.rest, conn, stiffness, own, at, np.ones(len(edges)), planes, carried, *none)
    kernel.mesh_edges = edges
    return [kernel]


def _facet_members(edges: Index, planes: Array, numbering: Numbering) -> list[Kernel]:
    """Members that give facets back the angles of edges that are held, which were eliminated as those of free edges."""
    given = given_back(edges, numbering)
    place = {edge: row for row, edge in enumerate(edges.tolist())}
    members: dict[int, list[tuple[Any, ...]]] = {}
    for back in given:
        turns, folds, nodes = [], [], list(back.corners)
        for d, weight in back.weights.items():
            at, edge = [d, STARTS[d], ENDS[d]], back.edges[d]
            if edge in place:
                turns.append((at, weight, planes[place[edge]]))
            else:
                folds.append(([*at, len(nodes)], 0.5 * weight))
                nodes.append(back.wings[d])
        members.setdefault(len(nodes), []).append((nodes, 4.0 * back.stiffness, turns, folds))
    return [joined_members(HeldEdgeKernel, made, numbering.rest) for _, made in sorted(members.items())]


class GivenBack(NamedTuple):
    """The energy (stiffness / 2) (sum of weights * fold angles)^2 that a facet lost with a fold angle.

    ``weights`` by the local number of the edge, each opposite its corner; ``edges`` are the edges of the mesh, and
    ``wings`` the far corners beyond them, -1 where there are none.
    """

    stiffness: float
    corners: list[int]
    edges: list[int]
    wings: list[int]
    weights: dict[int, float]


def given_back(edges: Index, numbering: Numbering, partners: Index | None = None) -> list[GivenBack]:
    """What facets lost with the fold angles of edges of the boundary, one angle after the other.

    Beyond an edge lies the mirror image of its facet, or the facet of the edge that is its partner.
    """
    mesh, sheet = numbering.mesh, numbering.sheet
    table = facet_edges(mesh)
    facets = np.unique(mesh.edge_facets[edges, 0])
    of_facet = table[facets]  # (m, 3)
    held = np.isin(of_facet, edges)
    inner = mesh.edge_facets[of_facet, 1] >= 0
    first = mesh.edge_facets[of_facet, 0] == facets[:, None]
    wing = np.where(first, mesh.edge_wings[of_facet, 1], mesh.edge_wings[of_facet, 0])
    corners = mesh.triangles[facets]
    flat, area = flat_edges(edge_vectors(numbering.rest, corners))
    starts, ends = corners[:, STARTS], corners[:, ENDS]
    points = numbering.rest
    beyond = 0.5 * np.linalg.norm(np.cross(points[ends] - points[starts], points[wing] - points[starts]), axis=2)
    count = len(mesh.triangles)
    thickness, E, nu = (
        np.broadcast_to(np.asarray(values, dtype=float), (count,))
        for values in (sheet.thickness, sheet.of_facets("E"), sheet.of_facets("nu"))
    )
    rigidity = rigidity_of(thickness, E, nu)
    softer = softness_beyond(mesh.triangles, rigidity)
    if softer is not None:
        beyond = beyond * softer[facets]
    opposite = area[:, None] * np.ones(3)
    if partners is not None:
        other = np.full(len(mesh.edges), -1)
        other[edges] = mesh.edge_facets[partners, 0]
        other = other[of_facet]
        opposite = mesh.facet_areas[other] * rigidity[facets][:, None] / rigidity[other]
    across = np.where(inner, beyond, np.where(held, opposite, 0.0))
    to_curvature = curvature_from_folds(flat, area, across)
    matrix = fold_stiffness(to_curvature, area, thickness[facets], E[facets], nu[facets])
    for c in range(3):
        matrix = without_fold(matrix, c, ~inner[:, c] & ~held[:, c])[0]
    found = []
    for c in range(3):
        matrix, pivot, row = without_fold(matrix, c, held[:, c])
        for f in np.flatnonzero(pivot > 0).tolist():
            weights = {d: float(row[f, d]) for d in range(3) if inner[f, d] or (held[f, d] and row[f, d])}
            found.append(
                GivenBack(float(pivot[f]), corners[f].tolist(), of_facet[f].tolist(), wing[f].tolist(), weights)
            )
    return found


def joined_members(made: type[HeldEdgeKernel], members: list[tuple[Any, ...]], rest: Array) -> Kernel:
    """One kernel of members (nodes, stiffness, turns, folds) with one number of nodes."""
    turns = [(number, *turn) for number, (_, _, found, _) in enumerate(members) for turn in found]
    folds = [(number, *fold) for number, (_, _, _, found) in enumerate(members) for fold in found]
    planes = np.array([turn[3] for turn in turns]).reshape(-1, 3)
    return made(
        rest,
        np.array([nodes for nodes, *_ in members], dtype=np.int64),
        np.array([stiffness for _, stiffness, *_ in members]),
        np.array([turn[0] for turn in turns], dtype=np.int64),
        np.array([turn[1] for turn in turns], dtype=np.int64).reshape(-1, 3),
        np.array([turn[2] for turn in turns]),
        planes,
        np.asarray(~planes.any(axis=1)),
        np.array([fold[0] for fold in folds], dtype=np.int64),
        np.array([fold[1] for fold in folds], dtype=np.int64).reshape(-1, 4),
        np.array([fold[2] for fold in folds]),
    )
