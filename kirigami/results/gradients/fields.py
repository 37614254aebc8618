"""Derivatives by what varies from facet to facet, from node to node or from member to member.

Shell facets know theirs in closed form. Everything else is lowered once more with the numbers of many facets or nodes
changed at once, so far from each other that no member feels two of them, and a member's change is that one's.
"""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.surface import SurfaceKernel, surfaces_of
from kirigami.errors import AnalysisError, KirigamiWarning, ModelError
from kirigami.model.from_mesh import sheet_parts
from kirigami.model.model import Model
from kirigami.model.moved import moved
from kirigami.model.natural_state import in_facets
from kirigami.primitives.kernel import Array, Kernel
from kirigami.primitives.laminate import Laminate
from kirigami.primitives.material import Material
from kirigami.primitives.parts import Numbering
from kirigami.primitives.sensitivity import member_work
from kirigami.results.gradients.by_rest import by_rest_state
from kirigami.results.gradients.equilibrium import Adjoint
from kirigami.system.system import System

STEP = 1e-5  # of a number, or of the spacing of the nodes, in central differences
REACH = 3  # steps from node to node within which members feel where a node is, or how thick a facet
LOST = 1e-7  # share of a change that may be felt beyond that
ROUNDING = 1e-13  # of the work of members: a change that is nothing but rounding; a real one is some STEP of it
Index = NDArray[np.int64]
FIELDS = ("thickness", "E", "strain", "curvature", "positions")


def of_sheet(adjoints: Sequence[Adjoint], name: str, owner: str) -> list[Array]:
    """Derivatives (facets,) by "thickness" or "E" of the sheet, or (facets, 3) by "strain" or "curvature"."""
    system = adjoints[0].at.system
    mesh, sheet = system.model.mesh, system.model.sheet_constants
    if mesh is None or sheet is None:
        raise ModelError(f"{owner}: {name} is that of a sheet: the model was not made by Model.from_mesh")
    here = {id(item) for item in system.model.elements}
    if not all(id(item) in here for item in system.model.sheet_elements):
        raise ModelError(f"{owner}: elements of the sheet were removed, so its {name} does not tell what is left")
    shells = [kernel for kernel in surfaces_of(system.kernels, owner) if kernel.plate_theory]
    if name in ("strain", "curvature"):
        if len(shells) == 1 and any(material.hyperelastic for material in sheet.materials):
            raise ModelError(f"{owner}: a {name} of its own is not known of rubber: take a linear elastic material")
        if len(shells) != 1:
            raise ModelError(
                f"{owner}: only stiffness='shell' has a {name} of its own; on this rung take the rest lengths of bars "
                "and the rest angles of hinges, as 'bars.rest_length'"
            )
        return _of_natural(adjoints, shells[0], name)
    count = len(mesh.triangles)
    values = sheet.thickness_of_facets(count) if name == "thickness" else _moduli(sheet.material, count, owner)
    if any(isinstance(material, Laminate) for material in sheet.materials):
        raise ModelError(f"{owner}: a Laminate brings its own thickness and moduli: give the sheet another material")
    if any(material.hyperelastic for material in sheet.materials):
        raise ModelError(f"{owner}: {name} of a sheet of rubber is not known; take stiffness and forces by differences")
    closed = [np.zeros(count) for _ in adjoints]
    closed_form = sheet.rung == "shell" and len(shells) == 1 and len(shells[0].conn) == count
    if closed_form:
        for adjoint, rate in zip(adjoints, closed):
            work = adjoint.of_member_arrays(shells[0])["section"] * shells[0].section
            membrane, bending = work[:, :3, :3].sum(axis=(1, 2)), work[:, 3:, 3:].sum(axis=(1, 2))
            rate += (membrane + (3 if name == "thickness" else 1) * bending) / values
    if closed_form and all(kernel is shells[0] or kernel.independent for kernel in system.kernels):
        return closed
    left_out = shells if closed_form else []

    def lowered(moved: Array) -> list[Kernel]:
        return _with_sheet(system.model, name, moved, owner)

    others = _felt_elsewhere(system, lowered, values, left_out)
    if others:
        near = mesh.triangles
        for rate, more in zip(closed, _by_groups(adjoints, lowered, values, near, others)):
            rate += more
    return closed


def _of_natural(adjoints: Sequence[Adjoint], shell: SurfaceKernel, name: str) -> list[Array]:
    """By a strain or curvature (facets, 3) in the axes of the drawing, there in full."""
    corners, every = shell.rest[shell.conn[:, :3]], np.arange(len(shell.conn))
    found = [np.empty((len(shell.conn), 3)) for _ in adjoints]
    for axis in range(3):
        unit = np.zeros((len(shell.conn), 6))
        unit[:, axis if name == "strain" else 3 + axis] = 1.0
        local = shell.grown(every, in_facets(corners, unit))
        for rates, adjoint in zip(found, adjoints):
            rates[:, axis] = (local * adjoint.of_member_arrays(shell)["natural"]).sum(axis=1)
    return found


def _moduli(material: Any, count: int, owner: str) -> Array:
    each = [material] * count if not isinstance(material, tuple) else list(material)
    if not all(isinstance(item, Material) for item in each):
        raise ModelError(f"{owner}: E is the modulus of an isotropic Material; this sheet has others")
    return np.array([item.E for item in each])


def _with_sheet(model: Model, name: str, values: Array, owner: str) -> list[Kernel]:
    """The kernels of a model whose sheet has another thickness or modulus, facet by facet."""
    sheet, mesh = model.sheet_constants, model.mesh
    assert sheet is not None and mesh is not None
    thickness, material = sheet.thickness, sheet.material
    if name == "thickness":
        thickness = values
    else:
        each = material if isinstance(material, tuple) else (material,) * len(values)
        material = tuple(dataclasses.replace(item, E=E) for item, E in zip(each, values.tolist()))  # type: ignore[type-var]
    stiffness = sheet.calibration if sheet.rung == "calibration" else sheet.rung
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KirigamiWarning)
        nodes = list(model.nodes[: len(mesh.nodes)])
        _, elements, constants = sheet_parts(mesh, thickness, material, stiffness, model.dim, nodes)
    own = {id(item) for item in model.sheet_elements}
    objects = elements + [item for item in model.objects if id(item) not in own]
    return _kernels(model, objects, constants, model.positions()[:, : model.dim])


def _kernels(model: Model, objects: Sequence[Any], constants: Any, rest: Array) -> list[Kernel]:
    numbering = Numbering(model.nodes, rest.copy(), model.mesh, constants)
    return System._lower(objects, numbering)


def _felt_elsewhere(
    system: System, lowered: Callable[[Array], list[Kernel]], values: Array, but: Sequence[Kernel]
) -> list[int]:
    """Numbers of the kernels, without those `but`, that a change of the values is felt by."""
    moved = lowered(values * (1 + 1e-3 * np.random.default_rng(0).uniform(0.5, 1.0, len(values))))
    _same(system.kernels, moved)
    found = []
    for number, (before, after) in enumerate(zip(system.kernels, moved)):
        if any(before is one for one in but):
            continue
        if any(
            isinstance(value, np.ndarray) and value.dtype.kind == "f" and not _alike(value, after.arrays().get(key))
            for key, value in before.arrays().items()
        ):
            found.append(number)
    return found


def _alike(one: Array, other: Any) -> bool:
    return isinstance(other, np.ndarray) and one.shape == other.shape and np.array_equal(one, other, equal_nan=True)


def _same(before: Sequence[Kernel], after: Sequence[Kernel]) -> None:
    if [kernel.conn.shape for kernel in before] != [kernel.conn.shape for kernel in after]:
        raise AnalysisError("gradient: the model has other members where it is changed a little: nothing is smooth")


def _remember(before: Sequence[Kernel], after: Sequence[Kernel]) -> None:
    for old, new in zip(before, after):
        if old.history is not None:
            new.history = old.history


def _by_groups(
    adjoints: Sequence[Adjoint],
    lowered: Callable[[Array], list[Kernel]],
    values: Array,
    near: Index,
    numbers: Sequence[int],
) -> list[Array]:
    """Derivatives by the values of facets with corners `near` (facets, 3), felt by the kernels of some `numbers`."""
    at = adjoints[0].at
    links = neighbours(at.system)
    found = [np.zeros(len(values)) for _ in adjoints]
    for group in apart(near, links, at.system.points):
        owner = _of_rows(owners(near[group], links, at.system.points), at.system)
        sides: list[list[list[Array]]] = []
        step = np.zeros(len(values))
        step[group] = STEP * values[group]
        for sign in (1.0, -1.0):
            kernels = lowered(values + sign * step)
            _remember(at.system.kernels, kernels)
            sides.append([
                [_work(kernels[number], adjoint) for number in numbers] for adjoint in adjoints
            ])
        for rate, ahead, behind in zip(found, *sides):
            for number, plus, minus in zip(numbers, ahead, behind):
                conn = at.system.kernels[number].conn
                _share(rate, group, owner, conn, plus, minus, 2 * STEP * values[group])
    return found


def _work(kernel: Kernel, adjoint: Adjoint) -> Array:
    at = adjoint.at
    x = at.configuration
    return member_work(kernel, x, at.lam, adjoint.v, adjoint.told.by_energy)


def _of_rows(label: Index, system: System) -> Index:
    """Labels (rows,) of nodes (points,) and of the rows of the edges between them, which are those of their ends.

    A crease is connected to nothing but rows of edges.
    """
    rows = np.full(len(system.rest), -1)
    rows[: len(label)] = label
    if system.edges is not None:
        ends = label[system.edges.ends].max(axis=1)
        edge, angle = system.edges.pairs
        rows[system.edges.middle] = ends
        np.maximum.at(rows, angle, ends[edge])
    return rows


def _share(rate: Array, group: Index, owner: Index, conn: Index, ahead: Array, behind: Array, step: Array) -> None:
    """Add the changes of the members' work to the one of the `group` that is nearest to each of them."""
    change = ahead - behind
    inside = np.where(conn < len(owner), conn, -1)
    label = np.append(owner, -1)[inside].max(axis=1)
    lost = float(np.abs(change[label < 0]).sum())
    rounding = ROUNDING * float(np.abs(ahead).sum() + np.abs(behind).sum())  # a load feels nothing else
    if lost > LOST * float(np.abs(change).sum()) + rounding:
        raise AnalysisError(
            "gradient: what a facet or a node does is felt far from it, by more than its neighbours: use a Design, "
            "whose few parameters are changed one by one"
        )
    mine = label >= 0
    total = np.bincount(label[mine], change[mine], len(group))
    rate[group] += total / step


# ---- who is near whom


def neighbours(system: System) -> Any:
    """Which nodes are joined by a member (points, points), sparse; rows behind the nodes belong to the mesh."""
    from scipy.sparse import coo_array

    n = system.points
    rows, columns = [np.arange(n)], [np.arange(n)]
    for kernel in system.kernels:
        nodes = kernel.conn
        for a in range(nodes.shape[1]):
            for b in range(nodes.shape[1]):
                both = (nodes[:, a] < n) & (nodes[:, b] < n)
                rows.append(nodes[both, a])
                columns.append(nodes[both, b])
    for group in () if system.grips is None else system.grips.groups:  # what is held together is one neighbourhood
        points = group.followers[group.followers < n]
        rows.append(np.repeat(points, len(points)))
        columns.append(np.tile(points, len(points)))
    row, column = np.concatenate(rows), np.concatenate(columns)
    found = coo_array((np.ones(len(row), np.int32), (row, column)), shape=(n, n)).tocsr()
    found.data[:] = 1
    return found


def _within(links: Any, steps: int) -> Any:
    reach = links
    for _ in range(steps - 1):
        reach = reach @ links
        reach.data[:] = 1
    return reach


def apart(near: Index, links: Any, points: int, reach: int = REACH) -> list[Index]:
    """Groups of items on nodes `near` (items, k), no two of one group within twice the reach of each other."""
    from scipy.sparse import coo_array

    count = len(near)
    on = coo_array(
        (np.ones(near.size, np.int32), (np.repeat(np.arange(count), near.shape[1]), near.ravel())),
        shape=(count, points),
    ).tocsr()
    close = on @ _within(links, reach)
    clash = (close @ close.T).tocsr()
    colour = np.full(count, -1)
    for item in range(count):
        taken = set(colour[clash.indices[clash.indptr[item] : clash.indptr[item + 1]]].tolist())
        colour[item] = next(k for k in range(count + 1) if k not in taken)
    return [np.flatnonzero(colour == k) for k in range(int(colour.max()) + 1)]


def owners(near: Index, links: Any, points: int, reach: int = REACH) -> Index:
    """Number of the item of a group each node is within reach of (points,), -1 for none."""
    label = np.full(points, -1)
    label[near.ravel()] = np.repeat(np.arange(len(near)), near.shape[1])
    for _ in range(reach):
        free = np.flatnonzero(label < 0)
        best = np.full(points, -1)
        for node in free.tolist():
            best[node] = label[links.indices[links.indptr[node] : links.indptr[node + 1]]].max()
        label = np.where(label < 0, best, label)
    return label


# ---- where nodes are at rest


def of_positions(adjoints: Sequence[Adjoint], owner: str) -> list[Array]:
    """Derivatives (n, 3) by the places of the nodes in the stress-free rest state, as :meth:`Model.perturb` moves them.

    Supports go along, with what they hold behind the nodes; prescribed displacements stay.
    """
    told = by_rest_state(adjoints)
    if told is not None:
        return list(told)
    at = adjoints[0].at
    system = at.system
    links = neighbours(system)
    nodes = np.arange(system.points)[:, None]
    spacing = np.median(_distances(system, links))
    step = STEP * float(spacing)
    found = [np.zeros((system.points, 3)) for _ in adjoints]
    for group in apart(nodes, links, system.points):
        label = owners(nodes[group], links, system.points)
        rows = _of_rows(label, system)
        for axis in range(system.dim):
            sides = []
            for sign in (1.0, -1.0):
                offset = np.zeros((system.points, 3))
                offset[group, axis] = sign * step
                sides.append(_moved_work(adjoints, offset))
            for rate, ahead, behind in zip(found, *sides):
                column = np.zeros(system.points)
                full = np.full(len(group), 2 * step)
                for kernel, plus, minus in zip(system.kernels, ahead[0], behind[0]):
                    _share(column, group, rows, kernel.conn, plus, minus, full)
                explicit = (ahead[1] - behind[1]).sum(axis=1)
                mine = rows >= 0
                column[group] += np.bincount(rows[mine], explicit[mine], len(group)) / (2 * step)
                rate[:, axis] += column
    return found


def _distances(system: System, links: Any) -> Array:
    pairs = links.tocoo()
    apart_by = np.linalg.norm(system.rest[pairs.row] - system.rest[pairs.col], axis=1)
    return np.asarray(apart_by[apart_by > 0])


def _moved_work(adjoints: Sequence[Adjoint], offset: Array) -> list[tuple[list[Array], Array]]:
    """For each functional: the work of every member with the rest state moved, and what positions alone make of it."""
    at = adjoints[0].at
    model = at.system.model
    system = System(moved(model, model.positions() + offset))
    _same(at.system.kernels, system.kernels)
    _remember(at.system.kernels, system.kernels)
    u = system.displacement(at.q, at.lam)
    x = system.configuration(u)
    found = []
    for adjoint in adjoints:
        v = adjoint.field(system, u)
        works = [member_work(kernel, x, at.lam, v, adjoint.told.by_energy) for kernel in system.kernels]
        placed = np.zeros((len(system.rest), 3))
        placed[:, : system.dim] = x - at.configuration
        found.append((works, adjoint.told.by_position * placed))
    return found
