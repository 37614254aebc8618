"""One small problem on every rung of accuracy, and hand-built structures, each of which can be stated differently."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from changes import CHANGES, Change

import kirigami as kg

SAME = Change()
THICKNESS, E, NU, DENSITY = 0.05, 1e6, 0.3, 1.2
LINE = 0.3  # mass per length of the bars of hand-built structures
BOTTOM, TOP, SIDE = [0, 1, 2, 3], [12, 13, 14, 15], [4, 8]  # of the sheet below
CELL_PUSH = {5: 2.0, 6: -3.0, 9: 1.0}  # forces across the sheet at inner nodes, in balance
FOLD = [(4, 5), (6, 7)]  # on both sides of the opening
RUNGS = kg.stiffness.RUNGS


@cache
def drawn() -> tuple[np.ndarray, np.ndarray]:
    """Nodes and facets of a square with a square opening, its inner nodes moved so that no two facets are alike."""
    x, y = np.meshgrid(np.linspace(0, 1, 4), np.linspace(0, 1, 4))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(16)])
    points[[5, 6, 9, 10], :2] += 0.05 * np.random.default_rng(3).uniform(-1, 1, (4, 2))
    corners = [4 * row + column for row in range(3) for column in range(3) if (row, column) != (1, 1)]
    facets = []
    for number, a in enumerate(corners):
        one = ((a, a + 1, a + 5), (a, a + 5, a + 4)), ((a, a + 1, a + 4), (a + 1, a + 5, a + 4))
        facets += one[number % 2]
    return points, np.array(facets)


def of_sheet(change: Change, limit: float | None = None) -> kg.Material:
    """The material of sheets, with a yield stress or without."""
    pressure = change.force / change.length**2
    density = DENSITY * change.force / change.length**4  # of a mass that is a force over length per time squared
    flow = {} if limit is None else {"yield_stress": limit * pressure, "hardening": 0.05 * E * pressure}
    return kg.Material(E=E * pressure, nu=NU, density=density, **flow)


def sheet(
    rung: str,
    dim: int,
    change: Change,
    drive: float = 1.0,
    fold: float | None = None,
    limit: float | None = None,
    material: Any = None,
) -> kg.Model:
    """The square on a rung; with a fold across it of this stiffness per length; with a yield stress, or of a material
    of its own."""
    points, facets = drawn()
    order = change.order(len(points))
    new = np.argsort(order)  # where each old node stands now
    facets = new[facets][change.order(len(facets))]
    if change.mirrors:
        facets = facets[:, [0, 2, 1]]
    material = of_sheet(change, limit) if material is None else material
    creased = [] if fold is None else [kg.FoldEdges(new[FOLD], stiffness=fold * change.force)]
    mesh = kg.TriMesh(change.places(points)[order][:, : 2 if change.flat else 3], facets, folds=creased)
    m = kg.Model.from_mesh(mesh, THICKNESS * change.length, material, rung, dim=dim)
    at = [m.nodes[k] for k in new]
    hold = "xyz"[:dim]
    move = change.places(drive * np.array([0.02, 0.03, 0.1 if dim == 3 else 0.0]))
    pull = change.forces(drive * np.array([-40.0, 10.0, 5.0 if dim == 3 else 0.0]))
    m.add(kg.Fix([at[k] for k in BOTTOM], hold, clamp=dim == 3))
    m.add(kg.Prescribe([at[k] for k in TOP], **dict(zip(hold, move.tolist()))))
    m.add(kg.NodalLoad([at[k] for k in SIDE], pull[:dim]))
    return m


def stacked(
    rung: str, change: Change, drive: float = 1.0, limit: float | None = None, friction: float = 0.0
) -> kg.Model:
    """A small square above a larger one that is held at its rim, pressed on it and moved aside; with self-contact."""

    def plate(count: int, size: float, corner: float, height: float) -> tuple[np.ndarray, np.ndarray]:
        x, y = np.meshgrid(*[np.linspace(corner, corner + size, count)] * 2)
        first = [count * row + column for row in range(count - 1) for column in range(count - 1)]
        facets = [part for a in first for part in ((a, a + 1, a + count + 1), (a, a + count + 1, a + count))]
        return np.column_stack([x.ravel(), y.ravel(), np.full(count**2, height)]), np.array(facets)

    (low, below), (high, above) = plate(4, 1.0, 0.0, 0.0), plate(3, 0.55, 0.19, 0.06)
    points, facets = np.concatenate([low, high]), np.concatenate([below, above + len(low)])
    order = change.order(len(points))
    new = np.argsort(order)
    facets = new[facets][change.order(len(facets))]
    if change.mirrors:
        facets = facets[:, [0, 2, 1]]
    mesh = kg.TriMesh(change.places(points)[order], facets)
    m = kg.Model.from_mesh(mesh, THICKNESS * change.length, of_sheet(change, limit), rung)
    at = [m.nodes[k] for k in new]
    rim = [k for k, (x, y, _) in enumerate(low) if min(x, y, 1 - x, 1 - y) < 0.1]
    driven = [len(low) + k for k in (1, 3, 4, 5, 7)]
    move = change.places(drive * np.array([0.03, 0.01, -0.05]))
    m.add(kg.Fix([at[k] for k in rim]), kg.Prescribe([at[k] for k in driven], **dict(zip("xyz", move.tolist()))))
    m.add(kg.NodalLoad([at[k] for k in (5, 10)], change.forces(drive * np.array([4.0, 1.0, 2.0]))))
    stiffness = 1e-2 * E * change.force / change.length**2
    layer = 0.4 * THICKNESS * change.length
    m.add(kg.SelfContact(layer=layer, stiffness=stiffness, friction=friction))
    return m


def built(
    places: list[tuple[float, ...]],
    parts: list[tuple],
    dim: int,
    fixed: list[int],
    driven: list[int],
    loaded: list[int],
) -> Callable[[Change, float], kg.Model]:
    """A structure of bars, hinges and springs given by the numbers of their nodes."""

    def make(change: Change, drive: float = 1.0) -> kg.Model:
        old = np.array([[*place, 0.0, 0.0][:3] for place in places], dtype=float)
        order = change.order(len(old))
        new = np.argsort(order)
        m = kg.Model(dim=dim)
        nodes = [kg.Node(*place) for place in change.places(old)[order].tolist()]
        m.add(*nodes)
        at = [nodes[k] for k in new]
        size = {"hinge": change.force * change.length, "spring": change.force * change.length}
        size["ground"] = change.force / change.length
        for part in [parts[k] for k in change.order(len(parts))]:
            kind, *ends, stiffness = part
            i = [at[k] for k in ends]
            value = stiffness * size.get(kind, change.force)
            line = LINE * change.force / change.length**2
            if kind == "bar":
                m.add(kg.Bar(i[0], i[1], EA=value, mass_per_length=line))
            elif kind == "cable":
                m.add(kg.Bar(i[0], i[1], EA=value, law="cable", mass_per_length=line))
            elif kind == "driven bar":
                a, b = (change.places(old)[k] for k in ends)
                length = (1 - 0.05 * drive) * float(np.linalg.norm(b - a))
                m.add(kg.Bar(i[0], i[1], EA=value, target_length=length, mass_per_length=line))
            elif kind == "link":
                m.add(kg.RigidLink(i))
            elif kind == "ground":
                m.add(kg.Spring(i[0], value))
            elif kind == "hinge":
                m.add(kg.BendHinge(*((i[0], i[2], i[1], i[3]) if change.mirrors else i), value))
            else:
                m.add(kg.TorsionSpring3(*(i[::-1] if change.mirrors else i), value))
        hold = "xyz"[:dim]
        move = change.places(drive * np.array([0.05, -0.1, 0.02 if dim == 3 else 0.0]))
        pull = change.forces(drive * np.array([0.02, -0.01, 0.01 if dim == 3 else 0.0]))
        m.add(kg.Fix([at[k] for k in fixed], hold))
        m.add(kg.Prescribe([at[k] for k in driven], **dict(zip(hold, move.tolist()))))
        m.add(kg.NodalLoad([at[k] for k in loaded], pull[:dim]))
        return m

    return make


def cell(rung: str, change: Change, drive: float = 1.0) -> kg.PeriodicCell:
    """The square as the cell of a sheet without end: stretched along x, sheared, free along y, and pushed inside."""
    points, facets = drawn()
    order = change.order(len(points))
    new = np.argsort(order)
    facets = new[facets][change.order(len(facets))]
    if change.mirrors:
        facets = facets[:, [0, 2, 1]]
    density = DENSITY * change.force / change.length**4
    material = kg.Material(E=E * change.force / change.length**2, nu=NU, density=density)
    mesh = kg.TriMesh(change.places(points)[order], facets)
    m = kg.Model.from_mesh(mesh, THICKNESS * change.length, material, rung)
    lattice = change.places(np.eye(3)[:2])
    strain = change.turn @ np.diag([0.03 * drive, 0.0, 0.0]) @ change.turn.T
    shear = change.turn @ np.array([[0, 0.02, 0], [0.02, 0, 0], [0, 0, 0]]) @ change.turn.T
    given: list[float | None] = [strain[0, 0], strain[1, 1], 2 * drive * shear[0, 1]]
    given["xy".index(change.axis("y"))] = None
    made = kg.PeriodicCell(m, lattice[:, :2])
    made.impose(given)
    at = [m.nodes[k] for k in new]
    m.add(*(kg.NodalLoad(at[k], change.forces(drive * np.array([0.0, 0.0, push]))) for k, push in CELL_PUSH.items()))
    return made


TRUSS = built(
    [(0, 0), (1, 0), (0.1, 1), (1, 1.1), (0.5, 2)],
    [("bar", *ends, 10.0) for ends in ((0, 2), (1, 3), (0, 3), (1, 2), (2, 3), (2, 4), (3, 4))],
    2, [0, 1], [4], [2],
)  # fmt: skip
TOWER = built(
    [(0, 0, 0), (1, 0, 0), (0.4, 1, 0), (0.1, 0.1, 1), (0.9, 0.2, 1.1), (0.4, 0.8, 1), (0.5, 0.4, 2)],
    [("bar", *ends, 10.0) for ends in (
        (0, 3), (1, 4), (2, 5), (0, 4), (1, 5), (2, 3), (3, 4), (4, 5), (3, 5), (3, 6), (4, 6), (5, 6)
    )],
    3, [0, 1, 2], [6], [3],
)  # fmt: skip
STRIP = built(
    [(0, 0, 0), (0, 1, 0), (1, 0.1, 0.1), (1, 1, 0), (2, 0, 0.2), (2, 1.1, 0)],
    [*(("bar", *ends, 50.0) for ends in ((0, 1), (0, 2), (1, 2), (1, 3), (2, 3), (2, 4), (3, 4), (3, 5), (4, 5))),
     ("hinge", 0, 1, 2, 3, 0.5), ("hinge", 1, 2, 3, 4, 0.4), ("hinge", 2, 3, 4, 5, 0.3)],
    3, [0, 1, 2], [5], [4],
)  # fmt: skip
CHAIN = built(
    [(0, 0), (1, 0), (2, 0.2), (3, 0.1)],
    [("bar", 0, 1, 50.0), ("bar", 1, 2, 50.0), ("bar", 2, 3, 50.0),
     ("spring", 0, 1, 2, 0.5), ("spring", 1, 2, 3, 0.4)],
    2, [0, 1], [3], [2],
)  # fmt: skip
STAYED_MAST = built(
    [(0, 0), (0.1, 1), (0, 2.1), (-1, 0.1), (1.2, 0)],
    [("bar", 0, 1, 20.0), ("bar", 1, 2, 20.0), ("spring", 0, 1, 2, 0.4), ("cable", 3, 1, 5.0), ("cable", 4, 1, 5.0),
     ("driven bar", 3, 2, 5.0), ("ground", 1, 0.3)],
    2, [0, 3, 4], [2], [1],
)  # fmt: skip
STAYED_TOWER = built(
    [(0, 0, 0), (0.1, 0, 1), (0, 0.1, 2), (-1, 0.5, 0), (1.2, 0.6, 0), (0, -1.1, 0.1)],
    [("bar", 0, 1, 20.0), ("bar", 1, 2, 20.0), *(("cable", k, 1, 5.0) for k in (3, 4, 5)),
     *(("driven bar", k, 2, 5.0) for k in (3, 5)), ("bar", 4, 2, 5.0), ("ground", 1, 0.3)],
    3, [0, 3, 4, 5], [2], [1],
)  # fmt: skip
LINKED_TOWER = built(
    [(0, 0, 0), (1, 0, 0), (0.4, 1, 0), (0.1, 0.1, 1), (0.9, 0.2, 1.1), (0.4, 0.8, 1), (0.5, 0.4, 2), (0.5, 0.4, 1.2)],
    [*(("bar", *ends, 10.0) for ends in ((0, 3), (1, 4), (2, 5), (0, 4), (1, 5), (2, 3), (3, 6), (7, 6), (5, 6))),
     ("link", 3, 4, 5, 7, 0.0)],
    3, [0, 1, 2], [6], [3],
)  # fmt: skip


def serves_plane(rung: str) -> bool:
    try:
        sheet(rung, 2, SAME)
    except kg.ModelError:
        return False
    return True


SHEETS: dict[str, Callable[[Change, float], kg.Model]] = {
    rung: lambda change, drive=1.0, rung=rung: sheet(rung, 3, change, drive) for rung in RUNGS
}
PLANE: dict[str, Callable[[Change, float], kg.Model]] = {
    f"{rung} in the plane": lambda change, drive=1.0, rung=rung: sheet(rung, 2, change, drive)
    for rung in RUNGS
    if serves_plane(rung)
}
FOLDED: dict[str, Callable[[Change, float], kg.Model]] = {
    f"folded {rung}": lambda change, drive=1.0, rung=rung: sheet(rung, 3, change, drive, fold=0.5)
    for rung in ("shell",)
}
BUILT = {"truss": TRUSS, "tower": TOWER, "hinged strip": STRIP, "chain of springs": CHAIN}
BUILT |= {"stayed mast": STAYED_MAST, "stayed tower": STAYED_TOWER, "linked tower": LINKED_TOWER}
STRUCTURES = SHEETS | PLANE | FOLDED | BUILT
# What remembers: rows of a file of their own, since most of the matrix asks for what is no question of history.
REMEMBERING: dict[str, Callable[[Change, float], kg.Model]] = {
    "yielding shell": lambda change, drive=1.0: sheet("shell", 3, change, drive, limit=2e4),
    "yielding plate": lambda change, drive=1.0: sheet("plate", 3, change, drive, limit=2e4),
    "touching plate": lambda change, drive=1.0: stacked("plate", change, drive),
    "touching shell": lambda change, drive=1.0: stacked("shell", change, drive),
    "rubbing facet": lambda change, drive=1.0: stacked("facet", change, drive, friction=0.4),
    "yielding and touching": lambda change, drive=1.0: stacked("shell", change, drive, limit=1e4, friction=0.4),
}
PLANAR = {*PLANE, "truss", "chain of springs", "stayed mast"}


def applies(structure: str, change: str) -> bool:
    """A plane structure cannot be turned out of its plane."""
    return CHANGES[change].flat or structure not in PLANAR


@cache
def _model(structure: str, change: str, drive: float) -> kg.Model:
    return STRUCTURES[structure](CHANGES.get(change, SAME), drive)


def model(structure: str, change: str = "", drive: float = 1.0) -> kg.Model:
    return _model(structure, change, drive)


@cache
def _results(structure: str, change: str) -> kg.Results:
    return kg.DisplacementControl(model(structure, change), targets=[0.5, 0.999, 1.0], to=1.001, tol=1e-10).run()


def from_the_ground(run: kg.Results, number: int) -> np.ndarray:
    """Forces (nodes, 3) of grounded springs on the structure at a step."""
    force = np.zeros((len(run.rest), 3))
    for kernel in run.kernels:
        if kernel.name == "grounded springs":
            force[kernel.conn[:, 0], : run.dim] -= kernel.force(run.member_deformation(kernel, run[number]))
    return force


def results(structure: str, change: str = "") -> kg.Results:
    """Pulled to load factor 1 in steps that every statement of the problem takes alike."""
    return _results(structure, change)


@cache
def loaded(structure: str) -> kg.Results:
    """The same, written to a file and read again."""
    with TemporaryDirectory() as folder:
        return kg.load(results(structure).save(Path(folder) / "run"))


@cache
def _linear(structure: str, change: str, drive: float) -> kg.Results:
    return kg.LinearStatic(model(structure, change, drive)).run()


def linear(structure: str, change: str = "", drive: float = 1.0) -> kg.Results:
    return _linear(structure, change, drive)
