"""A load case on a sheet: the grips and places it finds, the lines its mesh needs, what it holds and drives."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.errors import ModelError
from kirigami.model.constraints import Fix, Prescribe
from kirigami.model.spread_loads import Gravity
from kirigami.primitives.node import AXES
from kirigami.results.drives import Drive
from kirigami.study.grips import Grips, find_grips
from kirigami.study.places import place

if TYPE_CHECKING:
    from kirigami.geometry.sheet import Sheet
    from kirigami.model.model import Model
    from kirigami.primitives.node import Node
    from kirigami.study.load_case import LoadCase


@dataclass(frozen=True, eq=False)
class Setting:
    """A load case on a sheet.

    Attributes
    ----------
    case : LoadCase
        What is done.
    sheet : Sheet
        To what.
    grips : Grips, optional
        The two ends, where they are held.
    lines : dict of str to shapely geometry
        What must be edges of the mesh.
    drives : tuple of Drive
        What moves; the first one is what the case is about.
    told : tuple of str
        What is held and moved, in words.
    """

    case: LoadCase
    sheet: Sheet
    grips: Grips | None
    lines: dict[str, Any]
    drives: tuple[Drive, ...]
    told: tuple[str, ...] = field(default=())

    def hold(self, model: Model) -> dict[str, list[Node]]:
        """Add supports and motions to a model made from the mesh; the nodes of each group by name.

        Raises
        ------
        ModelError
            A place that is lifted and held, or lifted twice, or that lies in a grip.
        """
        case = self.case
        chosen: dict[str, list[Node]] = {}
        taken: dict[int, str] = {}  # by node: who holds it
        if self.grips is not None:
            free = self.grips.free_length
            held, moved = self.grips.hold(model, case.strain * free, case.shear * free, case.twist)
            chosen |= {"held": held, "moved": moved}
            taken |= dict.fromkeys(map(id, held), "the held grip") | dict.fromkeys(map(id, moved), "the moved grip")
        for where, by in case.lift:
            name = f"lifted {where.text}"
            nodes = where.nodes(model, self.sheet, name)
            clash = next((taken[id(node)] for node in nodes if id(node) in taken), None)
            if clash:
                raise ModelError(f"LoadCase: {where.text} is lifted, but {clash} holds nodes of it")
            model.add(Prescribe(nodes, z=by))
            chosen[name] = nodes
            taken |= dict.fromkeys(map(id, nodes), name)
        if case.weight:
            model.add(Gravity((0, 0, -case.weight), constant=case.moves))
        lifted = {id(node) for name, nodes in chosen.items() if name.startswith("lifted") for node in nodes}
        for where, how in self._held():
            name = f"held {where.text}"
            nodes = where.nodes(model, self.sheet, name)
            clash = next((taken[id(node)] for node in nodes if id(node) in lifted), None)
            if clash:
                raise ModelError(f"LoadCase: {where.text} is held, but nodes of it are {clash}")
            nodes = [node for node in nodes if id(node) not in taken]  # grips and other places hold the rest of it
            if not nodes:
                raise ModelError(f"LoadCase: {where.text} lies wholly in what is held already")
            clamped = how == "clamp" and self._has_edges(model, nodes)
            model.add(Fix(nodes, AXES if how == "clamp" else how, clamp=clamped))
            chosen[name] = nodes
            taken |= dict.fromkeys(map(id, nodes), name)
        return chosen

    def _held(self) -> list[tuple[Any, str]]:
        if self.grips is None and not self.case.hold:
            return [(place("rim"), "clamp")]
        return list(self.case.hold)

    @staticmethod
    def _has_edges(model: Model, nodes: list[Node]) -> bool:
        """Whether a clamp of nodes finds an edge of the rim or a whole facet to hold."""
        mesh = model.mesh
        assert mesh is not None
        inside = np.isin(np.arange(len(mesh.nodes)), model.index(nodes))
        rim = mesh.edges[mesh.boundary_edges]
        return bool(inside[rim].all(axis=1).any() or inside[mesh.triangles].all(axis=1).any())


def set_up(case: LoadCase, sheet: Sheet) -> Setting:
    """Find the grips and places of a load case on a sheet.

    Raises
    ------
    ModelError
        Grips that leave nothing between them, a place that is not on the sheet.

    Examples
    --------
    >>> from kirigami.study.setting import set_up
    >>> import shapely, kirigami as kg
    >>> sheet = kg.Sheet(shapely.box(0, 0, 0.1, 0.2))
    >>> [drive.motion for drive in set_up(kg.LoadCase(strain=0.1, twist=90), sheet).drives]
    ['strain', 'twist']
    """
    grips = find_grips(sheet, case.direction, case.grip) if case.gripped else None
    lines: dict[str, Any] = {}
    drives, told = [], []
    if grips is not None:
        lines |= grips.lines()
        along, across = np.append(grips.direction, 0.0), np.append(grips.sideways, 0.0)
        told.append(f"{'strips' if grips.strip else 'edges'} held at the {' and '.join(grips.names)}")
        for motion, kind, whole, direction in (
            ("strain", "ratio", case.strain, along), ("shear", "ratio", case.shear, across),
            ("twist", "angle", case.twist, along),
        ):  # fmt: skip
            if whole:
                drives.append(Drive(motion, "moved grip", "moved", kind, whole, direction))
    for where, by in case.lift:
        name = f"lifted {where.text}"
        drives.append(Drive("lift", name, name, "length", by, np.array([0.0, 0.0, 1.0])))
        lines |= _line(name, where, sheet)
    if not case.moves:
        drives.append(Drive("weight", "sheet", "sheet", "ratio", 1.0, np.array([0.0, 0.0, -1.0])))
    setting = Setting(case, sheet, grips, lines, tuple(drives), tuple(told))
    for where, how in setting._held():
        lines |= _line(f"held {where.text}", where, sheet)
        of = "clamped" if how == "clamp" else f"held along {', '.join(how)}"
        told.append(f"{where.text} {of}")
    return Setting(case, sheet, grips, lines, tuple(drives), tuple(told))


def _line(name: str, where: Any, sheet: Sheet) -> dict[str, Any]:
    line = where.line(sheet)
    return {} if line is None else {name: line}
