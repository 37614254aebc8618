"""A sheet model in the words of a shell code: what the writers for other programs share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.stiffness import SheetConstants
from kirigami.errors import ModelError
from kirigami.model.constraints import Constraint, Fix, Prescribe
from kirigami.model.loads import NodalLoad
from kirigami.model.model import Model
from kirigami.model.spread_loads import AreaLoad, EdgeLoad, Gravity, SpreadLoad, Surface
from kirigami.primitives.checks import require_array, require_instance, shown
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import Material, SheetMaterial
from kirigami.primitives.node import AXES
from kirigami.primitives.parts import Numbering
from kirigami.results.supports import named
from kirigami.words import counted

LOADS = (NodalLoad, EdgeLoad, AreaLoad, Gravity)  # that shell triangles take as nodal forces


@dataclass(eq=False)
class Shell:
    """A sheet as shell triangles.

    Attributes
    ----------
    nodes : ndarray, shape (n, 3)
        Rest positions, the stress-free imperfection included.
    triangles : ndarray of int, shape (m, 3)
        Facets, counter-clockwise.
    parts : list of (float, SheetMaterial, ndarray of int)
        Thickness [length], material and facets of each part that has one thickness and material.
    held : dict of (node, axis) to (constant, driven)
        Known displacements: constant part, and part that grows with the load factor.
    clamped : ndarray of int
        Nodes whose rotations about x and y are held.
    loads : dict of (node, axis) to (constant, driven)
        Forces.
    sets : dict of str to ndarray of int
        Named sets of supported nodes: ``fixed_0``, ``driven_0``, ...
    """

    nodes: Array
    triangles: NDArray[np.int64]
    parts: list[tuple[float, Any, NDArray[np.int64]]]
    held: dict[tuple[int, int], tuple[float, float]] = field(default_factory=dict)
    clamped: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    loads: dict[tuple[int, int], tuple[float, float]] = field(default_factory=dict)
    sets: dict[str, NDArray[np.int64]] = field(default_factory=dict)

    @property
    def has_constant(self) -> bool:
        """Whether anything acts before the load factor grows."""
        return any(constant != 0 for group in (self.held, self.loads) for constant, _ in group.values())


def shell_of(model: Model, owner: str, materials: tuple[type[SheetMaterial], ...] = (Material,)) -> Shell:
    """The model as shell triangles.

    Parameters
    ----------
    model : Model
        Made by ``Model.from_mesh`` with any `stiffness`, in three dimensions, with supports and dead loads only.
    owner : str
        Who asks, for messages.
    materials : tuple of type
        Materials that can be handed over.

    Raises
    ------
    ModelError
        The model has no mesh, or holds something that a shell model of it would not.

    Examples
    --------
    >>> from kirigami.io.shell import shell_of
    >>> import kirigami as kg
    >>> mesh = kg.TriMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9))
    >>> held = m.add(kg.Fix(m.select(boundary="bottom")), kg.Prescribe(m.select(boundary="top"), y=0.1))
    >>> shell = shell_of(m, "example")
    >>> shell.held[2, 1], shell.sets["driven_0"].tolist()
    ((0.0, 0.1), [2, 3])
    """
    require_instance(model, Model, "model", owner)
    if model.mesh is None or model.sheet_constants is None or model.dim != 3:
        raise ModelError(f"{owner} needs a three-dimensional model made by Model.from_mesh")
    _check_elements(model, owner)
    mesh = model.mesh
    if mesh.folds:
        raise ModelError(
            f"{owner}: the {counted(len(mesh.folds), 'fold')} of the sheet would be lost: a shell of triangles is "
            "smooth there; make the model of `mesh.with_folds([])` if that is meant"
        )
    shell = Shell(
        model.positions()[: len(mesh.nodes)],
        mesh.triangles,
        _parts(model.sheet_constants, len(mesh.triangles), owner, materials),
    )
    clamped: set[int] = set()
    boundary = mesh.edges[mesh.boundary_edges]
    for name, item in named(model.constraints):
        _hold(shell, model, item, owner)
        group = _on_sheet(shell, model.index(item.group), item, owner)
        shell.sets[name] = group
        if item.clamp:
            for corners in (boundary, mesh.triangles):  # edges keep their slope, facets that are held as a whole, too
                clamped.update(corners[np.isin(corners, group).all(axis=1)].ravel().tolist())
    shell.clamped = np.array(sorted(clamped), dtype=np.int64)
    for load in model.loads:
        _load(shell, model, load, owner)
    return shell


def _load(shell: Shell, model: Model, load: Any, owner: str) -> None:
    """Add a load to the nodal forces; what is spread as on triangles with linear displacements."""
    if isinstance(load, SpreadLoad):
        numbering = Numbering(model.nodes, model.positions(), model.mesh, model.sheet_constants)
        weight = load.weights(Surface(numbering, owner))
        group = np.flatnonzero(weight)
    else:
        group = model.index(load.group)
        weight = np.ones(len(model.nodes))
    for node in _on_sheet(shell, group, load, owner).tolist():
        for axis, force in enumerate(load.force):
            if force:
                constant, driven = shell.loads.get((node, axis), (0.0, 0.0))
                force *= float(weight[node])
                shell.loads[node, axis] = (constant + force * load.constant, driven + force * (not load.constant))


def _parts(
    constants: SheetConstants, count: int, owner: str, served: tuple[type[SheetMaterial], ...]
) -> list[tuple[float, Any, NDArray[np.int64]]]:
    """The parts of a sheet that have one thickness and material, the thinnest first."""
    number, materials = constants.material_of_facets(count)
    thickness = constants.thickness_of_facets(count)
    pairs, which = np.unique(np.stack([number, thickness], axis=1), axis=0, return_inverse=True)
    found = []
    for part, (position, height) in enumerate(pairs.tolist()):
        material = materials[int(position)]
        if not isinstance(material, served):
            known = ", ".join(kind.__name__ for kind in served)
            raise ModelError(f"{owner} cannot hand over {material!r}: it writes sheets of {known} only")
        if material.yields:
            raise ModelError(
                f"{owner} cannot hand over that {material!r} yields: hand over a sheet with hardening=None, which "
                "stays elastic, and give the other program its own law"
            )
        found.append((height, material, np.flatnonzero(which.ravel() == part)))
    return found


def _check_elements(model: Model, owner: str) -> None:
    """The model must be the sheet as meshed: what a shell of the same mesh would not know of is refused."""
    sheet = {id(item) for item in model.sheet_elements}
    there = {id(item) for item in model.elements}
    gone = Counter(type(item).__name__ for item in model.sheet_elements if id(item) not in there)
    others = [item for item in model.elements if id(item) not in sheet]
    others += [item for item in (*model.loads, *model.effects) if type(item) not in LOADS]
    beyond = Counter(type(item).__name__ for item in others)
    wrong = [f"{number} {kind} beyond the sheet" for kind, number in beyond.items()]
    wrong += [f"the sheet without {number} {kind} of its own" for kind, number in gone.items()]
    if wrong:
        raise ModelError(
            f"{owner} cannot hand over {', '.join(wrong)}: it writes shell triangles, one for each facet of the mesh, "
            "with supports and dead loads only"
        )


def _on_sheet(shell: Shell, nodes: NDArray[np.int64], item: object, owner: str) -> NDArray[np.int64]:
    if nodes.max(initial=0) >= len(shell.nodes):
        raise ModelError(f"{owner} cannot hand over {item!r}: it is on nodes that are not of the sheet")
    return nodes


def _hold(shell: Shell, model: Model, item: Constraint, owner: str) -> None:
    if type(item) not in (Fix, Prescribe):
        raise ModelError(f"{owner} cannot hand over {item!r}: only Fix and Prescribe")
    if item.clamp and "z" not in item.values:
        raise ModelError(f"{owner} cannot hand over {item!r} with clamp=True, since it leaves z free")
    group = model.index(item.group).tolist()
    for letter, values in item.values.items():
        for node, value in zip(group, values.tolist()):
            if (node, AXES.index(letter)) in shell.held:
                raise ModelError(f"{owner}: {item!r} holds {letter} of node {node} once more: constrain it once")
            shell.held[node, AXES.index(letter)] = (value, 0.0) if item.constant else (0.0, value)


def checked_targets(targets: Sequence[float], owner: str) -> list[float]:
    """Load factors as a list of finite numbers, none of them repeated in a row."""
    listed = require_array(targets, (None,), name="targets", owner=owner)
    if 0.0 in np.diff(listed, prepend=0.0):
        raise ModelError(f"{owner}: targets must be finite load factors, none twice in a row, got {shown(targets)}")
    found: list[float] = listed.tolist()
    return found
