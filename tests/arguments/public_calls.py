"""One valid call of every public callable, to be spoiled one argument at a time."""

from __future__ import annotations

import math
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


CALLS: dict[str, Callable[[], Call]] = {
    "Material": lambda: (
        kg.Material,
        {"E": 1.0, "nu": 0.3, "density": 1.0, "yield_stress": 0.1, "hardening": [(0.1, 0.2)], "kinematic": 0.1,
         "expansion": 1.0},
    ),
    "NeoHookean": lambda: (kg.NeoHookean, {"E": 1.0, "density": 1.0, "expansion": 1.0}),
    "Orthotropic": lambda: (
        kg.Orthotropic,
        {"E1": 2.0, "E2": 1.0, "nu12": 0.3, "G12": 0.5, "angle": 0.1, "density": 1.0, "expansion": (1.0, 2.0)},
    ),
    "Laminate": lambda: (kg.Laminate, {"layers": [(STEEL, 0.1)]}),
    "Node": lambda: (kg.Node, {"x": 0.0, "y": 0.0, "z": 0.0, "name": "a"}),
    "Model": lambda: (kg.Model, {"dim": 3, "name": "a"}),
    "Model.add": lambda: (truss().add, {"*items": [kg.Node(3, 3)]}),
    "Model.remove": lambda: ((m := truss()).remove, {"*items": [m.loads[0]]}),
    "Model.from_mesh": lambda: (kg.Model.from_mesh, {"mesh": mesh(), "thickness": 0.1, "material": STEEL}),
    "Model.hold": lambda: ((m := truss()).hold, {"step": kg.LoadControl(m).run()[-1]}),
    "Model.index": lambda: ((m := truss()).index, {"nodes": m.nodes[0]}),
    "Model.imperfect": lambda: (plate().imperfect, {"amplitude": 0.01, "seed": 1}),
    "Model.perturb": lambda: (plate().perturb, {"shape": np.linspace(0, 0.1, 16), "amplitude": 0.01}),
    "Model.plot": lambda: (plate().plot, {}),
    "Model.positions": lambda: (plate().positions, {}),
    "Model.select": lambda: (plate().select, {"boundary": "left"}),
    "Model.to_abaqus": lambda: (plate().to_abaqus, {"path": folder() / "model.inp"}),
    "Model.to_openseespy": lambda: (plate().to_openseespy, {"path": folder() / "model.py"}),
    "Bar": lambda: (kg.Bar, named("ij", 2, EA=1.0, target_length=0.9)),
    "BendHinge": lambda: (kg.BendHinge, named("ijkl", 4, stiffness=1.0, target_angle=0.3)),
    "TorsionSpring3": lambda: (kg.TorsionSpring3, named("ijk", 3, stiffness=1.0, target_angle=0.3)),
    "Spring": lambda: (kg.Spring, {"nodes": nodes(2), "stiffness": (1.0, 0.0, 2.0)}),
    "Facet": lambda: (kg.Facet, named("ijk", 3, thickness=0.1, material=STEEL)),
    "ShellFacet": lambda: (kg.ShellFacet, named("ijk", 3, thickness=0.1, material=STEEL)),
    "Crease": lambda: (kg.Crease, {"nodes": nodes(2), "stiffness": 0.1, "rest_angle": 1.0, "target_angle": 0.5}),
    "AngleLimit": lambda: (kg.AngleLimit, named("ijk", 3, stiffness=1.0, minimum=0.1)),
    "Fix": lambda: (kg.Fix, {"nodes": nodes(2), "dofs": "xy", "clamp": False}),
    "Prescribe": lambda: (kg.Prescribe, {"nodes": nodes(2), "x": 0.1}),
    "Prescribe.held": lambda: (kg.Prescribe(nodes(2), x=0.1).held, {"lam": 0.5}),
    "Actuate": lambda: (
        kg.Actuate,
        {"facets": [0], "strain": (0.1, 0, 0), "curvature": (0, 0, 0.1), "constant": True, "heat": (1.0, 2.0)},
    ),
    "Actuate.held": lambda: (kg.Actuate(strain=(0.1, 0, 0)).held, {"lam": 0.5}),
    "FlowPressure": lambda: (kg.FlowPressure, {"q": 0.1, "direction": (0, 0, 1), "facets": [0], "constant": True}),
    "FlowPressure.held": lambda: (kg.FlowPressure(0.1).held, {"lam": 0.5}),
    "Pressure": lambda: (kg.Pressure, {"p": 0.1, "facets": [0, 1], "constant": True}),
    "Pressure.held": lambda: (kg.Pressure(0.1).held, {"lam": 0.5}),
    "Grip": lambda: (kg.Grip, {"nodes": nodes(2), "move": (0, None, 0.1), "turn": (0, 0.2, 0)}),
    "Grip.held": lambda: (kg.Grip(nodes(3), move=(0.1, 0, 0)).held, {"lam": 0.5}),
    "RigidLink": lambda: (kg.RigidLink, {"nodes": nodes(3)}),
    "Symmetry": lambda: (kg.Symmetry, {"nodes": nodes(2), "normal": "x"}),
    "Tie": lambda: (kg.Tie, {"followers": nodes(2), "leaders": kg.Node(2, 2), "dofs": "xyz", "x": 0.1}),
    "Tie.held": lambda: (kg.Tie(nodes(2), kg.Node(2, 2), x=0.1).held, {"lam": 0.5}),
    "Mass": lambda: (kg.Mass, {"nodes": nodes(2), "mass": 1.0}),
    "NodalLoad": lambda: (kg.NodalLoad, {"nodes": nodes(2), "force": (0, 1)}),
    "NodalLoad.held": lambda: (kg.NodalLoad(nodes(2), (0, 1)).held, {"lam": 0.5}),
    "EdgeLoad": lambda: (kg.EdgeLoad, {"nodes": nodes(2), "force": (0, 1)}),
    "EdgeLoad.held": lambda: (kg.EdgeLoad(nodes(2), (0, 1)).held, {"lam": 0.5}),
    "EdgeMoment": lambda: (kg.EdgeMoment, {"nodes": nodes(2), "moment": 1.0}),
    "EdgeMoment.held": lambda: (kg.EdgeMoment(nodes(2), 1.0).held, {"lam": 0.5}),
    "AreaLoad": lambda: (kg.AreaLoad, {"force": (0, 1)}),
    "AreaLoad.held": lambda: (kg.AreaLoad((0, 1)).held, {"lam": 0.5}),
    "Gravity": lambda: (kg.Gravity, {"g": (0, -9.81)}),
    "Gravity.held": lambda: (kg.Gravity((0, 1)).held, {"lam": 0.5}),
    "Calibration": lambda: (kg.Calibration, {"F_s": 0.85, "c": 0.1}),
    "Calibration.named": lambda: (kg.Calibration.named, {"stiffness": "plate", "material": STEEL}),
    "System": lambda: (kg.System, {"model": truss(), "apart": []}),
    "System.stiffness": lambda: (system().stiffness, {"u": u(), "lam": 0.0}),
    "System.gradient": lambda: (system().gradient, {"u": u(), "lam": 0.0}),
    "System.energies": lambda: (system().energies, {"u": u(), "lam": 0.0}),
    "check_kernel": lambda: (kg.check_kernel, {"kernel": kernel(), "x": [[-1, 0.1], [0, 0.5], [1, 0]]}),
    "CellSheet": lambda: (kg.CellSheet, {"lattice": [(1, 0), (0, 1)], "cuts": [[(0.3, 0.5), (0.7, 0.5)]]}),
    "CellSheet.mesh": lambda: (cell_sheet().mesh, {"max_edge": 0.5, "cut_edge": 0.2}),
    "CellSheet.repeated": lambda: (cell_sheet().repeated, {"nx": 2, "ny": 1}),
    "CellSheet.supercell": lambda: (cell_sheet().supercell, {"nx": 2, "ny": 1}),
    "Sheet": lambda: (kg.Sheet, {"outline": [(0, 0), (1, 0), (1, 1)], "thickness": 0.1, "material": STEEL}),
    "Fold": lambda: (kg.Fold, {"line": [(0, 0), (1, 1)], "angle": 0.5, "stiffness": 0.1}),
    "FoldEdges": lambda: (kg.FoldEdges, {"edges": [(0, 1)], "angle": 0.5, "stiffness": 0.1}),
    "Sheet.mesh": lambda: (kg.Sheet(shapely.box(0, 0, 1, 1)).mesh, {"max_edge": 0.5}),
    "Sheet.plot": lambda: (sheet().plot, {}),
    **{
        f"Sheet.from_{ending}": lambda ending=ending: (
            getattr(kg.Sheet, f"from_{ending}"),
            {"path": written(ending), "thickness": 0.1},
        )
        for ending in ("dxf", "svg", "geojson", "fold")
    },
    **{
        f"Sheet.to_{ending}": lambda ending=ending: (
            getattr(sheet(), f"to_{ending}"),
            {"path": folder() / f"again.{ending}"},
        )
        for ending in ("dxf", "svg", "geojson", "fold")
    },
    "TriMesh": lambda: (kg.TriMesh, {"nodes": [[0, 0], [1, 0], [0, 1]], "triangles": [[0, 1, 2]], "thickness": 0.1}),
    "TriMesh.boundary": lambda: (mesh().boundary, {"name": "left"}),
    "TriMesh.nodal_mean": lambda: (mesh().nodal_mean, {"values": np.ones(len(mesh().triangles))}),
    "TriMesh.scaled": lambda: (mesh().scaled, {"factor": 2.0}),
    "TriMesh.with_cuts": lambda: (mesh().with_cuts, {"cuts": mesh().cuts}),
    "TriMesh.with_folds": lambda: (mesh().with_folds, {"folds": [kg.FoldEdges([(0, 5)])]}),
    "TriMesh.moved": lambda: (mesh().moved, {"nodes": [0, 1, 2, 3], "places": mesh().nodes[:4, :2]}),
    "TriMesh.with_sets": lambda: (mesh().with_sets, {"mine": [0, 1]}),
    "LinearStatic": lambda: (kg.LinearStatic, {"model": truss()}),
    "LinearStatic.run": lambda: (kg.LinearStatic(truss()).run, {}),
    "Eigen": lambda: (lambda **given: kg.Eigen(**given).run(), {"model": truss(), "n": 1}),
    "Eigen.run": lambda: (kg.Eigen(truss(), n=1).run, {}),
    "Dynamics": lambda: (lambda **given: kg.Dynamics(**given).run(), {
        "model": heavy(), "end": 0.2, "step": 0.1, "damping": 0.1, "load": 1.0, "velocity": [[0, 0], [0, 1], [0, 0]],
        "push": 0.01, "histories": {}, "every": 1, "tol": 1e-8,
    }),
    "Dynamics.run": lambda: (kg.Dynamics(heavy(), end=0.2, step=0.1).run, {}),
    "Mode.plot": lambda: (kg.Eigen(heavy(), n=1).run()[0].plot, {"amplitude": 0.1}),
    "Mode.animate": lambda: (
        kg.Eigen(heavy(), n=1).run()[0].animate, {"path": folder() / "mode.gif", "amplitude": 0.1, "frames": 2}
    ),
    "Buckling": lambda: (lambda **given: kg.Buckling(**given).run(), {"model": column(), "n": 1}),
    "Buckling.run": lambda: (kg.Buckling(column(), n=1).run, {}),
    "LoadControl": lambda: (kg.LoadControl, {"model": truss()}),
    "DisplacementControl": lambda: (kg.DisplacementControl, {"model": plate()}),
    "ArcLength": lambda: (kg.ArcLength, {"model": truss(), "step": 0.1}),
    "Results.animate": lambda: (results().animate, {"path": folder() / "film.gif", "frames": 2, "dpi": 30}),
    "Results.curvature": lambda: (results().curvature, {}),
    "Results.deformation": lambda: (results().deformation, {"name": "bars"}),
    "Results.force": lambda: (results().force, {"name": "bars"}),
    "Results.energy_release": lambda: (slit_opened("facet").energy_release, {"cut": 0}),
    "Results.energy_shares": lambda: (results().energy_shares, {}),
    "Results.gradient": lambda: (results().gradient, {"functional": ("energy",), "wrt": "thickness", "step": -1}),
    "Results.height": lambda: (results().height, {}),
    "Results.node_index": lambda: (results().node_index, {"nodes": [0, 1]}),
    "Results.nearest": lambda: (results().nearest, {"load_factor": 0.5}),
    "Results.open_area": lambda: (results().open_area, {}),
    "Results.plot": lambda: (results().plot, {}),
    "Results.plot_curve": lambda: (results().plot_curve, {"nodes": [0, 1], "axis": "z"}),
    "Results.plot_stress": lambda: (results().plot_stress, {}),
    "Results.poisson_ratio": lambda: (results().poisson_ratio, {"axis": "x"}),
    "Results.position": lambda: (results().position, {"nodes": [0, 1]}),
    "Results.moment": lambda: (results().moment, {"nodes": [0, 1], "about": (0, 0, 0)}),
    "Results.reaction": lambda: (results().reaction, {"nodes": [0, 1], "axis": "z"}),
    "Results.save": lambda: (results().save, {"path": folder() / "again"}),
    "Results.plastic_strain": lambda: (results().plastic_strain, {"step": -1}),
    "Results.stress": lambda: (results().stress, {"step": -1, "thickness": 0.1}),
    "Results.summary": lambda: (results().summary, {}),
    "Results.to_csv": lambda: (results().to_csv, {"path": folder() / "table.csv"}),
    "Results.to_html": lambda: (results().to_html, {"path": folder() / "page.html"}),
    "Results.to_surface": lambda: (results().to_surface, {"path": folder() / "surface.stl"}),
    "Results.to_vtk": lambda: (results().to_vtk, {"folder": folder() / "vtk"}),
    "Results.width": lambda: (results().width, {"axis": "x"}),
    "Step.at": lambda: (kg.Step.at, {"model": plate(), "lam": 1.0, "u": u()}),
    "load": lambda: (kg.load, {"path": saved()}),
    "Framework.compatibility": lambda: (framework().compatibility, {}),
    "Framework.field": lambda: (framework().field, {"unknowns": np.zeros(framework().unknowns)}),
    "Framework.follow": lambda: (
        kg.Framework.from_model(truss_mechanism()).follow,
        {"mode": [[0, 0], [0, 1]], "distance": 0.5, "steps": 5},
    ),
    "Framework.from_model": lambda: (kg.Framework.from_model, {"model": truss()}),
    "Framework.from_tiling": lambda: (kg.Framework.from_tiling, {"tiling": tiling()}),
    "Framework.rigidity": lambda: (framework().rigidity, {"phases": [0.1, 0.2]}),
    "Framework.vectors": lambda: (framework().vectors, {}),
    "PeriodicCell": lambda: (
        kg.PeriodicCell,
        {"model": periodic()[0], "lattice": tiling().lattice, "images": tiling().images},
    ),
    "PeriodicCell.gradient": lambda: (periodic()[1].gradient, {"strain": [0.1, 0, 0]}),
    "PeriodicCell.impose": lambda: (
        kg.PeriodicCell(tiling().model(EA=1e4, stiffness=1.0), tiling().lattice, tiling().images).impose,
        {"strain": [0.1, 0, 0]},
    ),
    "PeriodicCell.stiffness": lambda: (periodic()[1].stiffness, {}),
    "PeriodicCell.law": lambda: (sheet_cell()[0].law, {"results": sheet_cell()[1]}),
    "PeriodicCell.patch": lambda: (sheet_cell()[0].patch, {"of": sheet_cell()[1], "counts": [2, 2]}),
    "PeriodicCell.waves": lambda: (sheet_cell()[0].waves, {"phases": [0.5, 0.2], "at": sheet_cell()[1][-1]}),
    "PeriodicCell.buckling": lambda: (uncut_cell().buckling, {"strain": [None, -1.0, None]}),
    "PeriodicCell.mean_stress": lambda: strained(),
    "Sweep": lambda: (kg.Sweep, {"function": area, "designs": [{"radius": 1.0}], "path": folder() / "sweep.csv"}),
    "Sweep.run": lambda: (
        kg.Sweep(area, [{"radius": 1.0}], folder() / "run.csv").run,
        {"executor": ThreadPoolExecutor(1)},
    ),
    "SweepTable": lambda: (kg.SweepTable, {"rows": [{"design": 0, "status": "done", "k": 2.0}]}),
    "SweepTable.read": lambda: (kg.SweepTable.read, {"path": swept()}),
    "SweepTable.summary": lambda: (table().summary, {}),
    "SweepTable.write": lambda: (table().write, {"path": folder() / "written.csv"}),
    "latin_hypercube": lambda: (kg.latin_hypercube, {"ranges": {"a": (0.0, 1.0)}, "n": 2, "seed": 0}),
    "bloch.bands": lambda: (kg.bloch.bands, {"framework": framework(), "phases": [0.1, 0.2]}),
    "bloch.guest_modes": lambda: (kg.bloch.guest_modes, {"framework": framework()}),
    "bloch.winding_numbers": lambda: (kg.bloch.winding_numbers, {"framework": framework()}),
    "bloch.polarization": lambda: (kg.bloch.polarization, {"framework": framework()}),
    "cuts.curved_cells": lambda: (kg.cuts.curved_cells, {}),
    "cuts.graded_slits": lambda: (kg.cuts.graded_slits, {
        "outline": [(0, 0), (3, 0), (3, 2), (0, 2)], "spacing": 0.5, "pitch": 1.0, "length": 0.4, "angle": 0.1,
        "margin": 0.01,
    }),
    "cuts.parallel_slits": lambda: (kg.cuts.parallel_slits, {}),
    "cuts.perpendicular_slits": lambda: (kg.cuts.perpendicular_slits, {}),
    "cuts.random_slits": lambda: (
        kg.cuts.random_slits,
        {"count": 2, "width": 1.0, "height": 1.0, "length": (0.1, 0.2), "seed": 1, "gap": 0.01},
    ),
    "cuts.single_slit_disc": lambda: (kg.cuts.single_slit_disc, {}),
    "cuts.single_slit_rectangle": lambda: (kg.cuts.single_slit_rectangle, {}),
    "stiffness.bar_stiffness": lambda: (
        kg.stiffness.bar_stiffness,
        {"mesh": mesh(), "thickness": 0.1, "E": 1.0, "F_s": 1.0},
    ),
    "stiffness.hinge_stiffness": lambda: (
        kg.stiffness.hinge_stiffness,
        {"mesh": mesh(), "thickness": 0.1, "E": 1.0, "c": 1.0},
    ),
    "stiffness.report": lambda: (kg.stiffness.report, {"mesh": mesh(), "thickness": 0.1, "material": STEEL}),
    "stiffness.directional_bias": lambda: (kg.stiffness.directional_bias, {"mesh": mesh()}),
    "units.unit_for": lambda: (units("unit_for"), {"value": 0.02, "kind": "length"}),
    "Turn": lambda: (kg.Turn, {"nodes": kg.Node(1, 0), "angle": 30.0, "axis": "z", "about": (0, 0)}),
    "Turn.held": lambda: (kg.Turn(kg.Node(1, 0), 30.0).held, {"lam": 0.5}),
    "Design": lambda: (kg.Design, {
        "cuts": [], "outline": [(0, 0), (1, 0), (1, 2), (0, 2)], "supports": hold, "thickness": take_size,
        "material": kg.Material(E=1e6), "mesh": {"max_edge": 1.0}, "stiffness": "plate", "imperfection": 0.01,
        "folds": [kg.Fold([(0, 1), (1, 1)])], "seed": 0, "size": (0.1, 0.05, 0.2),
    }),
    "Design.at": lambda: (drawn().at, {"size": 0.12}),
    "Design.export": lambda: (pulled_design().export, {"folder": folder(), "finer": 1.5}),
    "Design.finer": lambda: (drawn().finer, {"factor": 1.2}),
    "Design.ligament": lambda: (drawn().ligament, {}),
    "Design.model": lambda: (drawn().model, {}),
    "Design.remeshed": lambda: (drawn().remeshed, {"max_edge": 0.9}),
    "Design.sheet": lambda: (drawn().sheet, {}),
    "Design.span": lambda: (drawn().span, {"name": "size"}),
    "Design.supports": lambda: (pulled_design().supports, {"model": pulled_design()._sheet_model()}),
    "Design.walk": lambda: (drawn().walk, {"targets": [1.0]}),
    "Inverse": lambda: (kg.Inverse, {
        "design": drawn(), "targets": [(("energy",), 1.0, 1.0)], "constraints": [("ligament", 0.1, None)],
        "method": "slsqp", "evaluations": 5, "enough": 1e-4, "tolerance": 0.1, "corrections": 0, "finer": 1.5,
        "path": folder() / "search.json",
    }),
    "Inverse.run": lambda: (
        kg.Inverse(drawn(), (("energy",), 1.0, 1.0), corrections=None, evaluations=2).run,
        {"progress": False, "starts": 2, "seed": 1, "workers": 1, "pictures": folder() / "pictures"},
    ),
    "LoadCase": lambda: (
        kg.LoadCase,
        {"strain": 0.1, "grip": 0.1, "shear": 0.1, "twist": 1.0, "weight": 1.0, "lift": {"top": 0.1}, "hold": "left"},
    ),
    "LoadCase.in_drawing": lambda: (
        kg.LoadCase(hold="layer:marks").in_drawing,
        {"layers": {"marks": shapely.box(0, 0, 1, 1)}},
    ),
    "LoadCase.plain": lambda: (kg.LoadCase().plain, {}),
    "LoadCase.plain_words": lambda: (kg.LoadCase().plain_words, {}),
    "LoadCase.values": lambda: (kg.LoadCase().values, {}),
    "LoadCase.from_plain": lambda: (kg.LoadCase.from_plain, {"kept": {"strain": 0.1}}),
    "study.place": lambda: (kg.study.place, {"where": (0.1, 0.2)}),
    "study.Job": lambda: (kg.study.Job, job()),
    "study.Job.save": lambda: (kg.study.Job(**job()).save, {"path": folder() / "case.json"}),
    "study.Job.load": lambda: (
        kg.study.Job.load,
        {"path": kg.study.Job(**job()).save(folder() / "loaded.json")},
    ),
    "study.read_measured": lambda: (kg.study.read_measured, {"path": measured()}),
    "stretch": lambda: (
        kg.stretch,
        {
            "sheet": kg.Sheet(shapely.box(0, 0, 1, 2), (), 0.02, STEEL),
            "strain": 1e-3,
            "accuracy": "draft",
            "stiffness": "facet",
            "max_edge": 1.0,
            "amplitude": 0,
        },
    ),
    "study.AccuracyStudy.error": lambda: (study().error, {"row": next(iter(study().table)), "quantity": "force"}),
    "study.AccuracyStudy.other_shape": lambda: (study().other_shape, {"row": next(iter(study().table))}),
    "study.AccuracyStudy.values": lambda: (study().values, {"row": next(iter(study().table)), "quantity": "force"}),
    "study.AccuracyStudy.front": lambda: (study().front, {}),
    "study.AccuracyStudy.plot": lambda: (study().plot, {}),
    "study.AccuracyStudy.recommend": lambda: (study().recommend, {}),
    "study.ErrorEstimate.plot": lambda: (kg.study.estimate_error(results()).plot, {}),
    "study.ErrorEstimate.size": lambda: (kg.study.estimate_error(results()).size, {"nodes": 100}),
    "study.ErrorEstimate.worst": lambda: (kg.study.estimate_error(results()).worst, {}),
    "study.ImperfectionStudy.final": lambda: (imperfection_study()[1].final, {"branch": 1}),
    "study.ImperfectionStudy.plot": lambda: (imperfection_study()[1].plot, {}),
    "study.ImperfectionStudy.table": lambda: (imperfection_study()[1].table, {}),
    "study.ShapeStudy.cpu_seconds_to": lambda: (shape_study().cpu_seconds_to, {"shape": shape_study()[0]}),
    "study.ShapeStudy.plot": lambda: (shape_study().plot, {}),
    "study.ShapeStudy.table": lambda: (shape_study().table, {}),
    "study.ShapeStudy.which": lambda: (shape_study().which, {"step": shape_study()[0].step}),
    "study.ShapeStudy.words": lambda: (shape_study().words, {"step": shape_study()[0].step}),
    "study.accuracy": lambda: (
        kg.study.accuracy,
        {"case": pulled, "sizes": [0.7], "path": folder() / "accuracy", "stiffness": ["plate"]},
    ),
    "study.bracket": lambda: (kg.study.bracket, {"case": pulled, "max_edge": 1.0, "stiffness": ("plate", "facet")}),
    "study.branches": lambda: (
        kg.study.branches,
        {"model": imperfection_study()[0], "modes": [[[0, 0], [1, 0], [0, 0]]], "amplitude": 1e-2},
    ),
    "study.choose_mesh": lambda: (
        kg.study.choose_mesh,
        {"case": pulled, "start": 1.0, "error": 0.5, "stiffness": "facet"},
    ),
    "study.estimate_error": lambda: (kg.study.estimate_error, {"results": results()}),
    "study.imperfections": lambda: (
        kg.study.imperfections,
        {"model": imperfection_study()[0], "modes": [[[0, 0], [1, 0], [0, 0]]], "amplitudes": [1e-2]},
    ),
    "study.shapes": lambda: (kg.study.shapes, {"model": truss(), "trials": 2, "followed": 0}),
    "study.seeds": lambda: (kg.study.seeds, {"model": plate(), "n": 1}),
    "plot.animate": lambda: (
        kg.plot.animate,
        {"results": results(), "path": folder() / "again.gif", "frames": 2, "dpi": 30},
    ),
    "plot.plot_curve": lambda: (kg.plot.plot_curve, {"results": results(), "nodes": [0, 1], "axis": "z"}),
    "plot.plot_energy_shares": lambda: (kg.plot.plot_energy_shares, {"results": results()}),
    "plot.plot_measure": lambda: (kg.plot.plot_measure, {"results": results(), "values": results().height()}),
    "plot.plot_gradient": lambda: (
        kg.plot.plot_gradient, {"mesh": mesh(), "values": np.ones(len(mesh().triangles)), "label": "force"}
    ),
    "plot.plot_mesh": lambda: (kg.plot.plot_mesh, {"mesh": mesh()}),
    "plot.plot_model": lambda: (kg.plot.plot_model, {"model": plate()}),
    "plot.plot_open_area": lambda: (kg.plot.plot_open_area, {"results": results()}),
    "plot.plot_results": lambda: (kg.plot.plot_results, {"results": results()}),
    "plot.plot_sheet": lambda: (kg.plot.plot_sheet, {"sheet": sheet()}),
    "tilings.Ligament": lambda: (kg.tilings.Ligament, {"E": 1.0, "thickness": 0.1, "width": 0.1, "length": 1.0}),
    "tilings.Tiling": lambda: (
        kg.tilings.Tiling,
        {"points": [[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]], "panels": [[0, 1, 2], [0, 3, 4]]},
    ),
    "tilings.Tiling.angle_limits": lambda: (
        tiling().angle_limits,
        {"model": tiling().model(EA=1.0, stiffness=1e-4), "stiffness": 0.1},
    ),
    "tilings.Tiling.bars": lambda: (tiling().bars, {}),
    "tilings.Tiling.model": lambda: (tiling().model, {"EA": 1.0, "stiffness": 0.1}),
    "tilings.Tiling.patch": lambda: (tiling().patch, {"n1": 1, "n2": 2}),
    "tilings.Tiling.place": lambda: (tiling().place, {"corners": tiling().panels[0]}),
    "tilings.critical_angles": lambda: (kg.tilings.critical_angles, {}),
    "tilings.from_polygons": lambda: (
        kg.tilings.from_polygons,
        {"polygons": [[[0, 0], [1, 0], [1, 1], [0, 1]], [[1, 1], [2, 1], [2, 2]]]},
    ),
    "tilings.kagome": lambda: (kg.tilings.kagome, {"angle": 1.75}),
    "tilings.ligament_sheet": lambda: (
        kg.tilings.ligament_sheet,
        {"tiling": kg.tilings.rotating_squares(1.0).patch(1, 1), "width": 0.05, "length": 0.1},
    ),
    "tilings.panels_of_sheet": lambda: (
        kg.tilings.panels_of_sheet,
        {
            "sheet": shapely.union_all([shapely.box(0, 0, 4, 4), shapely.box(4, 1.9, 5, 2.1), shapely.box(5, 0, 9, 4)]),
            "neck": 0.5,
        },
    ),
    "tilings.rotating_squares": lambda: (kg.tilings.rotating_squares, {"angle": 0.6}),
    "tilings.rotating_triangles": lambda: (kg.tilings.rotating_triangles, {"angle": 0.6}),
    "tilings.square_rhombus": lambda: (kg.tilings.square_rhombus, {"angle": math.pi / 16}),
    "Plane": lambda: (kg.Plane, {"point": (0, 0, 0), "normal": (0, 0, 1)}),
    "Cylinder": lambda: (kg.Cylinder, {"point": (0, 0, -2), "axis": (0, 1, 0), "radius": 1.0}),
    "Sphere": lambda: (kg.Sphere, {"center": (0, 0, -2), "radius": 1.0}),
    "Moving": lambda: (
        kg.Moving,
        {"surface": kg.Plane(), "shift": [(1, 0, 0)], "angle": [3.0], "axis": "z", "about": (0, 0), "at": [1.0]},
    ),
    "Contact": lambda: (kg.Contact, {"nodes": nodes(2), "surface": kg.Plane(), "offset": 0.1, "friction": 0.2}),
    "Moving.held": lambda: (kg.Moving(kg.Plane(), (1, 0)).held, {"lam": 0.5}),
    "Contact.held": lambda: (kg.Contact(nodes(2), kg.Moving(kg.Plane(), (1, 0))).held, {"lam": 0.5}),
    "SelfContact": lambda: (kg.SelfContact, {"thickness": 0.1, "layer": 0.01, "stiffness": 1e3, "friction": 0.2}),
    "results.contact.gaps": lambda: (contact("gaps"), {"results": touching()[0], "contact": touching()[1]}),
    "results.contact.normal_forces": lambda: (contact("normal_forces"), {"results": touching()[0]}),
    "results.contact.penetration": lambda: (contact("penetration"), {"results": touching()[0]}),
    "post.curvature.curvature": lambda: (post("curvature"), {"positions": results().position(), "mesh": mesh()}),
    "post.energy.energy_shares": lambda: (post("energy", "energy_shares"), {"energy": results().energy}),
    "post.opening.open_area": lambda: (
        post("opening", "open_area"),
        {"positions": results().position(), "cuts": mesh().cuts},
    ),
    "post.shape.height": lambda: (post("shape", "height"), {"positions": results().position()}),
    "post.shape.width": lambda: (post("shape", "width"), {"positions": results().position(), "mesh": mesh()}),
    "post.shape.poisson_ratio": lambda: (
        post("shape", "poisson_ratio"),
        {"positions": results().position(), "mesh": mesh(), "axis": "x"},
    ),
    "post.friction.friction_coefficient": lambda: (
        post("friction", "friction_coefficient"),
        {"height": [0.1], "density": [0.2], "surface_factor": [0.3], "base": 0.1, "engagement": 0.2},
    ),
    "post.permeability.permeability": lambda: (post("permeability"), {"results": slit_opened()}),
    "post.permeability.slit_permeability": lambda: (
        post("permeability", "slit_permeability"),
        {"positions": slit_opened().position(), "cuts": slit_opened().mesh.cuts, "sheet_area": 1.0},
    ),
    "post.permeability.outlined_area": lambda: (
        post("permeability", "outlined_area"),
        {
            "positions": slit_opened().position(),
            "triangles": slit_opened().mesh.triangles,
            "cuts": slit_opened().mesh.cuts,
        },
    ),
    "units.metres_per": lambda: (units("metres_per"), {"unit": "mm"}),
    "units.parse": lambda: (units("parse"), {"text": "1mm", "kind": "length"}),
    "units.show": lambda: (units("show"), {"value": 1.0, "kind": "length"}),
    "units.doubts": lambda: (units("doubts"), {"thickness": 1e-4, "size": 0.1, "E": 1e9, "strain": 0.1}),
}


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
