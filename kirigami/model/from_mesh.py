"""From a mesh to a model: every edge a bar, every inner edge a bending hinge."""

from __future__ import annotations

import copy
import warnings
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.bar import Bar
from kirigami.elements.bend_hinge import BendHinge
from kirigami.elements.crease import Crease, score_stiffness
from kirigami.elements.loose_ends import warn_of_loose_ends
from kirigami.elements.mesh_bias import MeshBias
from kirigami.elements.stiffness import Calibration, SheetConstants, bar_stiffness, hinge_stiffness, rung_named
from kirigami.errors import KirigamiWarning, ModelError
from kirigami.geometry.fold_line import FoldEdges
from kirigami.geometry.mesh import TriMesh
from kirigami.geometry.topology import pair_numbers
from kirigami.model.edge_yield import EdgeYield
from kirigami.model.properties import Materials, Thickness, facet_properties
from kirigami.primitives.checks import require_instance
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import Material, SheetMaterial
from kirigami.primitives.node import Node
from kirigami.primitives.parts import ModelObject

if TYPE_CHECKING:
    from kirigami.model.model import Model

FEW = 50  # facets below which a mesh is too small to have a pattern
BIAS = 0.2  # unevenness of stiffness over the directions, before relaxation, that is worth a warning
FOLD_BIAS = 0.3  # the same of bending and twisting, which meshes without a pattern make uneven by a quarter at worst


def sheet_parts(
    mesh: TriMesh,
    thickness: Thickness,
    material: Materials,
    stiffness: str | Calibration,
    dim: int,
    nodes: list[Node] | None = None,
) -> tuple[list[Node], list[ModelObject], SheetConstants]:
    """The nodes and elements of a mesh, and the constants that the elements were made with; on given nodes if any."""
    require_instance(mesh, TriMesh, "mesh", "Model.from_mesh", "make one with Sheet.mesh or TriMesh")
    height, made_of = facet_properties(mesh, thickness, material, "Model.from_mesh")
    one = made_of if isinstance(made_of, SheetMaterial) else made_of[0]
    calibration = Calibration.named(stiffness, one)
    nodes = [Node(*position) for position in mesh.nodes.tolist()] if nodes is None else nodes
    rung = rung_named(stiffness, "Model.from_mesh") if isinstance(stiffness, str) else "calibration"
    if mesh.folds and dim == 3:
        folded, rim = np.concatenate([fold.edges for fold in mesh.folds]), mesh.edges[mesh.edge_facets[:, 1] < 0]
        warn_of_loose_ends("Model.from_mesh", folded, rim, mesh.nodes, 4)
    constants = SheetConstants(calibration, height, made_of, rung)
    if rung != "shell":
        _check_isotropic(constants)
        _warn_of_bias(mesh, rung, float(np.mean(constants.of_facets("nu"))), dim)
    if rung == "shell":
        if dim == 2:
            raise ModelError("Model.from_mesh: stiffness='shell' bends, so it needs dim=3; in a plane use 'facet'")
        return nodes, [*_facets(nodes, mesh, constants), *_creases(nodes, mesh, constants)], constants
    hinges = _fold_hinges(nodes, mesh, constants) if dim == 3 else []
    if rung == "facet":
        if any(each.yields for each in constants.materials):
            warnings.warn(
                "flat facets stay elastic: results tell what is strained beyond the yield_stress of the material, but "
                "nothing yields; use stiffness='shell', or bars and hinges as of 'plate', or hardening=None in the "
                "Material if that is what you want",
                KirigamiWarning,
                stacklevel=4,
            )
        return nodes, [*_facets(nodes, mesh, constants), *hinges], constants
    E = constants.of_facets("E")
    EA = bar_stiffness(mesh, height, E, calibration.F_s).tolist()
    curves = EdgeYield(mesh, constants) if any(each.yields for each in constants.materials) else None
    elements: list[ModelObject] = [
        Bar(nodes[j], nodes[k], value, **({} if curves is None else curves.of_bar(edge, value)))
        for edge, ((j, k), value) in enumerate(zip(mesh.edges.tolist(), EA))
    ]
    if dim == 3:
        inner = np.flatnonzero((mesh.edge_facets[:, 1] >= 0) & ~mesh.edge_folded)
        rigidity = hinge_stiffness(mesh, height, E, constants.of_facets("c"))[inner].tolist()
        edges, wings = mesh.edges[inner].tolist(), mesh.edge_wings[inner].tolist()
        elements += [
            BendHinge(
                nodes[i], nodes[j], nodes[k], nodes[other], value, **({} if curves is None else curves.of_hinge(edge))
            )
            for edge, (j, k), (i, other), value in zip(inner.tolist(), edges, wings, rigidity)
        ]
    return nodes, [*elements, *hinges], constants


def on_rung(model: Model, stiffness: str) -> Model:
    """A copy of a sheet model on another rung of accuracy: the same mesh, imperfection, supports, loads and effects.

    Raises
    ------
    ModelError
        The model was not made from a mesh, or not all of its sheet is still in it.
    """
    constants = model.sheet_constants
    if model.mesh is None or constants is None:
        raise ModelError("only a model made by Model.from_mesh has a stiffness that can be changed")
    twin = copy.deepcopy(model)
    here = {id(item) for item in twin.elements}
    if not all(id(item) in here for item in twin.sheet_elements):
        raise ModelError("elements of the sheet were removed, so its stiffness cannot be changed as a whole")
    twin.remove(*twin.sheet_elements)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KirigamiWarning)
        nodes = list(twin.nodes[: len(model.mesh.nodes)])
        made = sheet_parts(model.mesh, constants.thickness, constants.material, stiffness, model.dim, nodes)
    _, elements, twin._sheet_constants = made
    twin.add(*elements)
    twin._sheet = tuple(elements)
    return twin


def _check_isotropic(constants: SheetConstants) -> None:
    """Bars, hinges and flat facets stand for isotropic materials only."""
    for material in constants.materials:
        if not material.isotropic:
            raise ModelError(
                f"Model.from_mesh: stiffness={constants.rung!r} stands for isotropic materials only, not for "
                f"{material!r}: use stiffness='shell'"
            )


def _warn_of_bias(mesh: TriMesh, rung: str, nu: float, dim: int) -> None:
    """Say so where the mesh makes bars and hinges, or flat facets, far from what the sheet is."""
    if len(mesh.triangles) < FEW:
        return
    bias = MeshBias(mesh, nu)
    advice = "kirigami.stiffness.report(mesh) has the numbers; use a mesh without a pattern, or stiffness='shell'"
    if rung == "facet":
        ranges = {"bending": bias.facet_bending, "twisting": bias.facet_twisting} if dim == 3 else {}
        _warn(ranges, {}, "flat facets on it represent", "of the material's", advice)
        return
    ranges = {"edges": bias.edges, "stretching": bias.stretching, "shear": bias.shear}
    bounds = dict.fromkeys(ranges, BIAS)
    if dim == 3:
        ranges |= {"bending": bias.bending, "twisting": bias.twisting}
    _warn(ranges, bounds, "bars and hinges on it represent", "of what they should before they relax", advice)


def _warn(
    ranges: dict[str, tuple[float, float]], bounds: dict[str, float], who: str, what: str, advice: str
) -> None:
    """Tell the ranges that leave their bound, which is FOLD_BIAS where none is given."""
    off = {
        name: (low, high)
        for name, (low, high) in ranges.items()
        if max(1 - low, high - 1) > bounds.get(name, FOLD_BIAS)
    }
    if off:
        words = ", ".join(f"{low:.2f} to {high:.2f} times the {name}" for name, (low, high) in off.items())
        words = words.replace("times the edges", "times the stiffness along their directions")
        warnings.warn(
            f"the mesh is biased: its edges favour some directions, so that {who} {words} {what}. {advice}",
            KirigamiWarning,
            stacklevel=5,
        )


def _fold_stiffness(mesh: TriMesh, constants: SheetConstants) -> list[tuple[FoldEdges, NDArray[np.int64], Array]]:
    """The folds of a mesh with the numbers of their edges and the stiffness of each [force / rad], which is that of a
    score of the softer side where a fold has none of its own."""
    score = np.zeros(0)
    if any(fold.stiffness is None for fold in mesh.folds):
        count = len(mesh.triangles)
        score = score_stiffness(constants.thickness_of_facets(count), constants.sections(count))
    found = []
    for fold in mesh.folds:
        at = pair_numbers(fold.edges, mesh.edges, len(mesh.nodes))
        own = score[mesh.edge_facets[at]].min(axis=1) if fold.stiffness is None else np.full(len(at), fold.stiffness)
        found.append((fold, at, own))
    return found


def _rest_angle(fold: FoldEdges) -> float | None:
    """None where the fold rests flat, so that it is free of moment in a rest shape with an imperfection too."""
    return fold.angle if fold.angle else None


def _creases(nodes: list[Node], mesh: TriMesh, constants: SheetConstants) -> list[ModelObject]:
    """The folds of a mesh of shell facets, edge by edge."""
    return [
        Crease((nodes[a], nodes[b]), stiffness, _rest_angle(fold))
        for fold, _, own in _fold_stiffness(mesh, constants)
        for (a, b), stiffness in zip(fold.edges.tolist(), own.tolist())
    ]


def _fold_hinges(nodes: list[Node], mesh: TriMesh, constants: SheetConstants) -> list[ModelObject]:
    """The hinges of folds, in the place of those of the sheet; that of a free fold is none."""
    made: list[ModelObject] = []
    for fold, at, own in _fold_stiffness(mesh, constants):
        moment = own * mesh.edge_lengths[at]
        for (j, k), (i, other), value in zip(mesh.edges[at].tolist(), mesh.edge_wings[at].tolist(), moment.tolist()):
            if value > 0:
                hinge = BendHinge(nodes[i], nodes[j], nodes[k], nodes[other], value, rest_angle=_rest_angle(fold))
                made.append(hinge)
    return made


def _facets(nodes: list[Node], mesh: TriMesh, constants: SheetConstants) -> list[ModelObject]:
    """Every facet an element: shell facets, or flat ones that stretch and bend against their neighbours, but not across
    a fold."""
    count = len(mesh.triangles)
    number, materials = constants.material_of_facets(count)
    corners = mesh.triangles.tolist()
    properties = zip(constants.thickness_of_facets(count).tolist(), [materials[k] for k in number.tolist()])
    if constants.rung == "shell":
        from kirigami.elements.shell_facet import ShellFacet

        return [
            ShellFacet(nodes[i], nodes[j], nodes[k], thickness, material)
            for (i, j, k), (thickness, material) in zip(corners, properties)
        ]
    from kirigami.elements.facet import Facet

    # For each facet and corner, the corner of the neighbour across the opposite edge.
    edge_of = {tuple(edge): position for position, edge in enumerate(np.sort(mesh.edges, axis=1).tolist())}
    made: list[ModelObject] = []
    wings, facets = mesh.edge_wings.tolist(), mesh.edge_facets.tolist()
    for position, (triangle, (thickness, material)) in enumerate(zip(corners, properties)):
        across: list[Node | None] = []
        for corner in range(3):
            a, b = sorted((triangle[corner - 2], triangle[corner - 1]))
            edge = edge_of[a, b]
            other = facets[edge][1] if facets[edge][0] == position else facets[edge][0]
            wing = wings[edge][1] if facets[edge][0] == position else wings[edge][0]
            across.append(nodes[wing] if other >= 0 and not mesh.edge_folded[edge] else None)
        i, j, k = (nodes[corner] for corner in triangle)
        assert isinstance(material, Material)
        made.append(Facet(i, j, k, thickness, material, (across[0], across[1], across[2])))
    return made
