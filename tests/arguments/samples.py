"""Small models, meshes, results and files that the valid calls are made of."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import shapely

import kirigami as kg

Call = tuple[Callable[..., Any], dict[str, Any]]
STEEL = kg.Material(E=1e6, nu=0.3, density=1.0)


@cache
def folder() -> Path:
    return Path(tempfile.mkdtemp())


@cache
def take_size(size: float) -> float:
    return size


def hold(m: kg.Model) -> None:
    m.add(kg.Fix(m.select(boundary="bottom")), kg.Prescribe(m.select(boundary="top"), x=0, y=0.01, z=0))


def drawn() -> kg.Design:
    return kg.Design(
        (), outline=[(0, 0), (1, 0), (1, 2), (0, 2)], supports=hold, thickness=take_size, material=kg.Material(E=1e6),
        mesh={"max_edge": 1.0}, stiffness="plate", imperfection=0, size=(0.1, 0.05, 0.2),
    )  # fmt: skip


def pulled_design() -> kg.Design:
    return kg.Design(
        (), outline=[(0, 0), (1, 0), (1, 2), (0, 2)], supports=kg.LoadCase(strain=0.01), thickness=take_size,
        material=kg.Material(E=1e6), mesh={"max_edge": 1.0}, stiffness="plate", imperfection=0, size=(0.1, 0.05, 0.2),
    )  # fmt: skip


def mesh() -> kg.TriMesh:
    x, y = np.meshgrid(np.linspace(0, 1, 4), np.linspace(0, 1, 4))
    corners = [4 * row + column for row in range(3) for column in range(3)]
    facets = [t for a in corners for t in ((a, a + 1, a + 5), (a, a + 5, a + 4))]
    centre = facets.pop(8), facets.pop(8)  # an opening
    assert len(centre) == 2
    return kg.TriMesh(np.column_stack([x.ravel(), y.ravel()]), facets, thickness=0.02, material=STEEL)


@cache
def sheet() -> kg.Sheet:
    return kg.Sheet(shapely.box(0, 0, 1, 1), [[(0.3, 0.5), (0.7, 0.5)]], 0.02, STEEL)


def job() -> dict[str, Any]:
    return {"drawing": "plate.dxf", "thickness": 0.1, "E": 1e9, "nodes": 100, "max_edge": 0.1, "imperfection": 0.01}


@cache
def measured() -> Path:
    file = folder() / "measured.csv"
    file.write_text("displacement [mm],force [N]\n0,0\n1,2\n")
    return file


def plate(stiffness: str = "plate") -> kg.Model:
    """Clamped at the left, lifted at the right."""
    m = kg.Model.from_mesh(mesh(), stiffness=stiffness)
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Prescribe(m.select(boundary="right"), z=0.05))
    return m


@cache
def results() -> kg.Results:
    return kg.DisplacementControl(plate()).run()


def truss(dim: int = 2) -> kg.Model:
    m = kg.Model(dim=dim)
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 0.5), kg.Node(1, 0))
    m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0), kg.Fix([left, right]), kg.Fix(apex, "x"))
    m.add(kg.NodalLoad(apex, (0, -0.01)))
    return m


def heavy() -> kg.Model:
    m = truss()
    m.add(kg.Mass(m.nodes[1], 1.0))
    return m


@cache
def slit_opened(rung: str = "plate") -> Any:
    m = kg.Model.from_mesh(sheet().mesh(0.3), stiffness=rung, dim=2)
    m.add(kg.Fix(m.select(boundary="bottom")), kg.Prescribe(m.select(boundary="top"), x=0, y=0.05))
    return kg.DisplacementControl(m, step=0.5).run()


@cache
def framework() -> kg.Framework:
    return kg.Framework.from_tiling(kg.tilings.kagome(angle=1.75))


@cache
def touching() -> tuple[kg.Results, kg.Contact]:
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, EA=10.0), kg.Fix([a, b], "y"), kg.Prescribe(a, x=0.11))
    wall = m.add(kg.Contact(b, kg.Plane((1.1, 0), normal=(-1, 0))))
    return kg.DisplacementControl(m).run(), wall


def column(dim: int = 2) -> kg.Model:
    m = kg.Model(dim=dim)
    bottom, middle, top = m.add(kg.Node(0, 0), kg.Node(0, 1), kg.Node(0, 2))
    m.add(kg.Bar(bottom, middle, 1e4), kg.Bar(middle, top, 1e4), kg.TorsionSpring3(bottom, middle, top, 1))
    m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.NodalLoad(top, (0, -1)))
    return m


def pulled(max_edge: float, stiffness: str) -> tuple[kg.Model, list[kg.Node], str]:
    m = kg.Model.from_mesh(kg.Sheet(shapely.box(0, 0, 2, 1), (), 0.01, STEEL).mesh(max_edge), stiffness=stiffness)
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="bottom")), kg.Prescribe(top, x=0, y=0.01, z=0))
    return m, top, "y"


@cache
def study() -> Any:
    return kg.study.accuracy(pulled, [0.7], path=folder() / "study", stiffness=["plate"])


@cache
def imperfection_study() -> Any:
    m = kg.Model(dim=2)
    bottom, middle, top = m.add(kg.Node(0, 0), kg.Node(0, 1), kg.Node(0, 2))
    m.add(kg.Bar(bottom, middle, 1e4), kg.Bar(middle, top, 1e4), kg.TorsionSpring3(bottom, middle, top, 1))
    m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.Prescribe(top, y=-0.2))
    return m, kg.study.imperfections(m, modes=[[[0, 0, 0], [1, 0, 0], [0, 0, 0]]], amplitudes=[1e-2])


@cache
def shape_study() -> Any:
    return kg.study.shapes(truss(), trials=8)


@cache
def periodic() -> tuple[kg.Model, kg.PeriodicCell]:
    squares = kg.tilings.rotating_squares(angle=0.6)
    m = squares.model(EA=1e4, stiffness=1.0)
    return m, kg.PeriodicCell(m, squares.lattice, squares.images)


def cell_sheet() -> kg.CellSheet:
    return kg.CellSheet([(1, 0), (0, 1)], [[(0.3, 0.5), (0.7, 0.5)]], 0.02, STEEL)


@cache
def sheet_cell() -> tuple[kg.PeriodicCell, kg.Results]:
    cell = kg.PeriodicCell(kg.Model.from_mesh(cell_sheet().mesh(0.5, 0.2)), cell_sheet().lattice)
    cell.impose([None, 1e-4, None])
    return cell, kg.LinearStatic(cell.model).run()


@cache
def uncut_cell() -> kg.PeriodicCell:
    mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    return kg.PeriodicCell(kg.Model.from_mesh(mesh, 0.02, STEEL, "shell"), [(1, 0), (0, 1)])


@cache
def tiling() -> Any:
    return kg.tilings.rotating_squares(angle=0.6)


@cache
def table() -> kg.SweepTable:
    return kg.SweepTable([{"design": 0, "status": "done", "k": 2.0}, {"design": 1, "status": "failed", "k": None}])


@cache
def swept() -> Path:
    kg.Sweep(area, [{"radius": 1.0}], folder() / "swept.csv").run(ThreadPoolExecutor(1))
    return folder() / "swept.csv"


@cache
def written(ending: str) -> Path:
    path = folder() / f"drawing.{ending}"
    getattr(sheet(), f"to_{ending}")(path)
    return path


@cache
def saved() -> Path:
    return results().save(folder() / "saved")


def nodes(count: int) -> list[kg.Node]:
    places = [(0, 0.5, 0), (0, 0, 0), (1, 0, 0), (0.5, -1, 0.2)]
    return [kg.Node(*places[k]) for k in range(count)]


def named(names: str, count: int, **rest: Any) -> dict[str, Any]:
    return dict(zip(names, nodes(count))) | rest


def area(radius: float = 1.0) -> dict[str, float]:
    return {"area": radius**2}


def system() -> kg.System:
    return kg.System(plate())


def u() -> Any:
    return results()[-1].u


def kernel() -> kg.Kernel:
    return kg.System(truss()).kernels[0]


def truss_mechanism() -> kg.Model:
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, EA=1.0), kg.Fix(a))
    return m


@cache
def strained() -> Call:
    m = tiling().model(EA=1e4, stiffness=1.0)
    cell = kg.PeriodicCell(m, tiling().lattice, tiling().images)
    cell.impose([1e-3, 0, 0])
    return cell.mean_stress, {"results": kg.LinearStatic(m).run()}


def contact(name: str) -> Callable[..., Any]:
    import kirigami.results.contact as module

    return getattr(module, name)  # type: ignore[no-any-return]


def post(module: str, name: str = "") -> Callable[..., Any]:
    import importlib

    return getattr(importlib.import_module(f"kirigami.post.{module}"), name or module)  # type: ignore[no-any-return]


def units(name: str) -> Callable[..., Any]:
    import kirigami.units as module

    return getattr(module, name)  # type: ignore[no-any-return]
