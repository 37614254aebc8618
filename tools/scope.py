"""Write docs/scope.md: what the package simulates on which rung, what it refuses there in which words, its price.

    python tools/scope.py

Nothing of the table is written by hand. Each object is put on one small sheet on every rung, whose tangent is then
made: the rung takes it, or refuses it with the sentence that is quoted. What an object is says its docstring. Prices
are those that benchmarks/effect_price.py has measured and left in benchmarks/results/effect_price.csv. What lies beyond
all rungs stands in BEYOND.
"""

from __future__ import annotations

import csv
import inspect
import tempfile
import warnings
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

import kirigami as kg
from kirigami.primitives.material import SheetMaterial

ROOT = Path(__file__).resolve().parent.parent
PAGE, PRICES = ROOT / "docs" / "scope.md", ROOT / "benchmarks" / "results" / "effect_price.csv"
COLUMNS = ("plane", *kg.stiffness.RUNGS)  # "plane" is "plate" with dim=2
TRUSTED = "shell"  # the rung of which it is tried what else it goes with
BEYOND_RUNGS = ("Abaqus", "OpenSees", "self-contact")
THICKNESS, E, NU, DENSITY = 0.02, 1e6, 0.3, 1.2
PLAIN = kg.Material(E, NU, density=DENSITY, expansion=1e-5)

Adds = Callable[[kg.Model], Any]


def side(m: kg.Model, x: float) -> list[kg.Node]:
    """Nodes of one side of the square, from corner to corner."""
    nodes = m.select(where=lambda px, py, pz: np.isclose(px, x))
    return sorted(nodes, key=lambda node: node.y)


def left(m: kg.Model) -> list[kg.Node]:
    return side(m, 0.0)


def right(m: kg.Model) -> list[kg.Node]:
    return side(m, 1.0)


def pair(m: kg.Model) -> list[kg.Node]:
    """Two corners that no edge joins."""
    return [left(m)[0], right(m)[-1]]


def inner(m: kg.Model) -> list[kg.Node]:
    """Two neighbours that no side touches, the first of them nearest to the middle."""
    at = m.positions()
    middle = int(np.argmin(np.linalg.norm(at[:, :2] - 0.5, axis=1)))
    mesh = m.mesh
    assert mesh is not None
    within = [(a, b) for a, b in mesh.edges[mesh.edge_facets.min(axis=1) >= 0].tolist() if middle in (a, b)]
    return m.select(index=[middle, sum(within[0]) - middle])


def on_floor(m: kg.Model, friction: float) -> kg.Contact:
    floor = kg.Plane((0, 0), (0, 1)) if m.dim == 2 else kg.Plane()
    return kg.Contact(m.nodes, floor, friction=friction)


def on_belt(m: kg.Model) -> kg.Contact:
    floor = kg.Plane((0, 0), (0, 1)) if m.dim == 2 else kg.Plane()
    return kg.Contact(m.nodes, kg.Moving(floor, shift=(0.1, 0)), friction=0.3)


# What is added to a model: name of the class, what is said of it, and the object on a sheet.
ADDED: list[tuple[str, str, Adds]] = [
    ("Bar", "", lambda m: kg.Bar(*pair(m), EA=100.0)),
    ("Bar", "one that only pulls", lambda m: kg.Bar(*pair(m), EA=100.0, law="cable")),
    ("BendHinge", "", lambda m: kg.BendHinge(pair(m)[0], *inner(m), pair(m)[1], stiffness=1.0)),
    ("TorsionSpring3", "", lambda m: kg.TorsionSpring3(left(m)[0], inner(m)[0], right(m)[0], 1.0)),
    ("Crease", "", lambda m: kg.Crease(inner(m), stiffness=0.1)),
    ("Fix", "", lambda m: kg.Fix(right(m))),
    ("Fix", "a clamp", lambda m: kg.Fix(right(m), clamp=True)),
    ("Prescribe", "", lambda m: kg.Prescribe(right(m), x=0.01)),
    ("Symmetry", "", lambda m: kg.Symmetry(right(m), "x")),
    ("Tie", "", lambda m: kg.Tie(right(m)[1:], right(m)[0], "x")),
    ("Turn", "", lambda m: kg.Turn(right(m), angle=30.0)),
    ("Grip", "", lambda m: kg.Grip(right(m), turn=(0, 0, 0.3))),
    ("RigidLink", "", lambda m: kg.RigidLink([*right(m), *inner(m)])),
    ("NodalLoad", "", lambda m: kg.NodalLoad(right(m), (1.0, 0.0, 0.0)[: m.dim])),
    ("EdgeLoad", "", lambda m: kg.EdgeLoad(right(m), (1.0, 0.0, 0.0)[: m.dim])),
    ("AreaLoad", "", lambda m: kg.AreaLoad((1.0, 0.0, 0.0)[: m.dim])),
    ("EdgeMoment", "", lambda m: kg.EdgeMoment(right(m), 0.01)),
    ("Gravity", "", lambda m: kg.Gravity((0, -9.81, 0)[: m.dim])),
    ("Pressure", "", lambda m: kg.Pressure(0.1)),
    ("FlowPressure", "", lambda m: kg.FlowPressure(0.1)),
    ("Actuate", "a strain", lambda m: kg.Actuate(strain=(0.01, 0.01, 0))),
    ("Actuate", "a curvature", lambda m: kg.Actuate(curvature=(0.5, 0, 0))),
    ("Actuate", "heat", lambda m: kg.Actuate(heat=10.0)),
    ("Contact", "", lambda m: on_floor(m, 0.0)),
    ("Contact", "with friction", lambda m: on_floor(m, 0.3)),
    ("Contact", "on a surface that moves", on_belt),
    ("SelfContact", "", lambda m: kg.SelfContact()),
    ("AngleLimit", "", lambda m: kg.AngleLimit(left(m)[0], inner(m)[0], right(m)[0], 1.0, minimum=0.1)),
    ("Spring", "", lambda m: kg.Spring(m.nodes, 1.0)),
    ("Mass", "", lambda m: kg.Mass(m.nodes, 0.1)),
]  # fmt: skip
PAPER = kg.Orthotropic(E1=2 * E, E2=E, nu12=NU, G12=0.5 * E, density=DENSITY)
MADE_OF: list[tuple[str, str, SheetMaterial]] = [
    ("Material", "", PLAIN),
    ("Material", "one that yields", kg.Material(E, NU, density=DENSITY, yield_stress=1e3, hardening=1e4)),
    ("NeoHookean", "", kg.NeoHookean(E, density=DENSITY)),
    ("Orthotropic", "", PAPER),
    ("Laminate", "", kg.Laminate([(PLAIN, THICKNESS / 2), (PAPER, THICKNESS / 2)])),
]
ANALYSES: list[tuple[str, Callable[[kg.Model], Any]]] = [
    ("LinearStatic", lambda m: kg.LinearStatic(m)),
    ("Eigen", lambda m: kg.Eigen(m, n=1, mass="consistent")),
    ("Buckling", lambda m: kg.Buckling(m, n=1)),
    ("LoadControl", lambda m: kg.LoadControl(m, targets=[0.1])),
    ("DisplacementControl", lambda m: kg.DisplacementControl(m, targets=[0.1])),
    ("ArcLength", lambda m: kg.ArcLength(m, step=1e-3, max_steps=1)),
    ("Dynamics", lambda m: kg.Dynamics(m, end=1e-3, step=5e-4, load=[(0, 0), (1e-3, 1)])),
]
SUPERSEDED = ("CurvedFacet", "Normal")
BY_THE_RUNG = {"Facet": ("facet",), "ShellFacet": ("shell",)}  # which rung is made of it

HEADINGS = {
    "material": "What a sheet is made of",
    "element": "What it is built of, and what is built onto it",
    "constraint": "How it is held and driven",
    "load": "What pushes it",
    "effect": "What else acts",
    "analysis": "How it is followed",
}
BEYOND = """\
* **Large strain of anything but rubber.** Sheets turn and bend as far as they like, but beside
  `kg.NeoHookean` the law between Green's strain and stress is linear, or plastic: what is stretched by
  more than some percent is not told rightly.
* **Cracks.** Cuts do not grow and nothing tears. `kg.Results` gives stresses to judge by.
* **Thick sheets.** Sheets do not shear across their thickness, nor do they get thinner: a cut's ligament is to be
  several thicknesses wide.
* **Contact by itself.** Without `kg.SelfContact` facets pass through each other, which an event
  "crossing" tells, and without `kg.Contact` there is no floor.
* **Creep and relaxation.** Stress does not fade with time; motions are damped by Rayleigh's two numbers.
* **Heat that flows, fluids that flow.** Temperatures are given. The pressure of a flow is a formula of the slope of
  each facet: no wake, no lee, no waves; `kg.FlowPressure` says which.
* **Electric and magnetic fields.** A sheet that they drive is driven by the strains they make, by
  `kg.Actuate`.
"""

Trial = dict[str, tuple[str, str]]  # of each column: "yes", "no", "but" or "-", and what was said
PLAIN_SHEET: dict[str, set[str]] = {}  # of each column: what the sheet says by itself


@cache
def square(edge: float) -> kg.TriMesh:
    """The mesh of all sheets."""
    return kg.Sheet([(0, 0), (1, 0), (1, 1), (0, 1)]).mesh(edge)


def sheet(column: str, material: SheetMaterial = PLAIN, edge: float = 0.3) -> kg.Model:
    """A square sheet on a rung, held along its left side."""
    thickness = None if isinstance(material, kg.Laminate) else THICKNESS
    mesh = square(edge)
    dim, rung = (2, "plate") if column == "plane" else (3, column)
    m = kg.Model.from_mesh(mesh, thickness, material, rung, dim=dim)
    m.add(kg.Fix(left(m), clamp=dim == 3))
    return m


def heard(make: Callable[[str], Any], column: str) -> list[str]:
    """What the package warns of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        make(column)
    return [str(one.message) for one in caught if issubclass(one.category, kg.KirigamiWarning)]


def tried(make: Callable[[str], Any]) -> Trial:
    """What every column says to something; whatever is not refused by a typed error is to work."""
    said = {}
    for column in COLUMNS:
        if column not in PLAIN_SHEET:
            PLAIN_SHEET[column] = set(heard(tangent_of, column))
        try:
            words = [one for one in heard(make, column) if one not in PLAIN_SHEET[column]]
            said[column] = ("but", words[0]) if words else ("yes", "")
        except kg.KirigamiError as refusal:
            said[column] = ("no", str(refusal))
    return said


def tangent_of(column: str, material: SheetMaterial = PLAIN) -> Any:
    """Tangent at rest of the sheet of a material."""
    return kg.System(sheet(column, material)).stiffness()


def tangent_with(column: str, adds: Adds) -> Any:
    """Tangent at rest of the sheet with an object."""
    m = sheet(column)
    m.add(adds(m))
    return kg.System(m).stiffness()


def handed(how: str, add: Callable[[kg.Model], Any], material: SheetMaterial = PLAIN) -> None:
    """The sheet with an object written for another program."""
    m = sheet(TRUSTED, material)
    add(m)
    with tempfile.TemporaryDirectory() as folder:
        getattr(m, how)(Path(folder) / "sheet")


def beside(add: Callable[[kg.Model], Any], material: SheetMaterial = PLAIN) -> None:
    """The tangent at rest of the sheet with an object and self-contact."""
    m = sheet(TRUSTED, material)
    add(m)
    m.add(kg.SelfContact())
    kg.System(m).stiffness()


def goes_with(trial: Trial, add: Callable[[kg.Model], Any], material: SheetMaterial = PLAIN) -> Trial:
    """Whether what the trusted rung takes is taken by other programs, and beside self-contact."""
    trials = [partial(handed, "to_abaqus"), partial(handed, "to_openseespy"), beside]
    said = dict(trial)
    for column, ask in zip(BEYOND_RUNGS, trials):
        said[column] = ("-", "") if trial[TRUSTED][0] in "no-" else asked(partial(ask, add, material))
    return said


def asked(ask: Callable[[], Any]) -> tuple[str, str]:
    """"yes", or "no" and what was said."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", kg.KirigamiWarning)
            ask()
    except kg.KirigamiError as refusal:
        return "no", str(refusal)
    return "yes", ""


@cache
def stretched(column: str) -> kg.Results:
    """The sheet, stretched a little."""
    m = sheet(column, edge=0.6)
    m.add(kg.Prescribe(right(m), x=1e-3))
    return kg.DisplacementControl(m, step=1.0, corrector="newton").run()


def gradient_by(column: str, what: str) -> Any:
    """The gradient of a force by what the facets of a sheet have."""
    return stretched(column).gradient(("force", "driven_0", "x"), what)


def analysed(column: str, make: Callable[[kg.Model], Any]) -> Any:
    """An analysis of the sheet, pushed along one side and driven at the other."""
    m = sheet(column)
    m.add(kg.EdgeLoad(left(m), (-1.0, 0.0, 0.0)[: m.dim]), kg.Prescribe(right(m), x=-1e-3))
    return make(m).run()


def rows() -> dict[str, list[tuple[str, str, Trial]]]:
    """(class, what is said of it, what the rungs say to it), by kind."""
    found: dict[str, list[tuple[str, str, Trial]]] = {kind: [] for kind in HEADINGS}
    for name, remark, material in MADE_OF:
        trial = tried(partial(tangent_of, material=material))
        found["material"].append((name, remark, goes_with(trial, lambda m: None, material)))
    for name, rungs in BY_THE_RUNG.items():
        said = {column: ("yes" if column in rungs else "-", "") for column in COLUMNS}
        found["element"].append((name, "", goes_with(said, lambda m: None)))
    for name, remark, adds in ADDED:
        trial = tried(partial(tangent_with, adds=adds))
        trial = goes_with(trial, lambda m, adds=adds: m.add(adds(m)))  # type: ignore[misc]
        found[getattr(kg, name).kind].append((name, remark, trial))
    for name, make in ANALYSES:
        found["analysis"].append((name, "", tried(partial(analysed, make=make))))
    return found


def label(name: str, remark: str) -> str:
    return f"`kg.{name}`" + (f", {remark}" if remark else "")


def prices() -> dict[tuple[str, str], dict[str, str]]:
    """Measured prices by class and remark; of each the columns that were measured."""
    found: dict[tuple[str, str], dict[str, str]] = {}
    with PRICES.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            found.setdefault((row["name"], row["remark"]), {})[row["column"]] = row["price"]
    return found


def page() -> str:
    """The text of the page."""
    lines = [HEAD]
    refused: dict[str, list[str]] = {}
    for kind, found in rows().items():
        columns = COLUMNS if kind == "analysis" else (*COLUMNS, *BEYOND_RUNGS)
        lines += [f"## {HEADINGS[kind]}", "", f"| | {' | '.join(columns)} | what it is |"]
        lines += ["| --- " * (len(columns) + 2) + "|"]
        for name, remark, trial in found:
            marks = " | ".join(trial[column][0] for column in columns)
            summary = "" if remark else (inspect.getdoc(getattr(kg, name)) or "").partition("\n\n")[0]
            lines += [f"| {label(name, remark)} | {marks} | {_without_links(summary)} |"]
            for column, (_, said) in trial.items():
                if said and column not in BEYOND_RUNGS[:2]:
                    refused.setdefault(f"{label(name, remark)}: {_first(said, column)}", []).append(column)
        lines += [""]
    lines += ["## By what there are gradients", "", GRADIENTS, f"| | {' | '.join(COLUMNS)} |"]
    lines += ["| --- " * (len(COLUMNS) + 1) + "|"]
    for what in ("thickness", "E", "strain", "curvature", "positions"):
        trial = tried(partial(gradient_by, what=what))
        lines += [f"| `\"{what}\"` | {' | '.join(mark for mark, _ in trial.values())} |"]
        for column, (_, said) in trial.items():
            if said:
                refused.setdefault(f"Gradients by `\"{what}\"`: {_first(said, column)}", []).append(column)
    lines += [""]
    lines += ["## What is refused or warned of, and in which words", ""]
    lines += [f"* {sentence} ({', '.join(columns)})" for sentence, columns in refused.items()]
    lines += ["", "## What lies beyond", "", BEYOND, PRICE_HEAD, ""]
    measured = prices()
    columns = [column for column in COLUMNS if any(column in of for of in measured.values())]
    lines += [f"| | {' | '.join(columns)} |", "| --- " * (len(columns) + 1) + "|"]
    for (name, remark), of in measured.items():
        title = label(name, remark) if hasattr(kg, name) else f"{name} {remark}".strip()
        lines += [f"| {title} | {' | '.join(of.get(column, '') for column in columns)} |"]
    return "\n".join(lines) + "\n"


HEAD = """\
# What it simulates, and what it does not

This page is made by `tools/scope.py`, which puts every object on a small sheet on every rung: **yes** is taken, **no**
is refused and **but** is taken with a warning, both with the sentence quoted below, **-** does not arise. "plane" is a
sheet that stays in its plane (`dim=2`, of bars); "paper" and "plate" are bars and hinges, "facet" and "shell" facets:
see `kg.stiffness`. On the shell rung it is also tried what `model.to_abaqus` and `model.to_openseespy` hand over to
other programs, which both refuse the rest in words, and what goes beside `kg.SelfContact`.
"""
GRADIENTS = """\
Of any number that `results.gradient` knows, by what each facet has or where each node is; [gradients and
design](design.md) has the rest.
"""
PRICE_HEAD = """\
## What it costs

Time to assemble one tangent of a sheet with the effect over that of the same sheet without it; in the first rows the
sheet itself: its nodes, microseconds a node on the machine that measured, and the sheet against itself, which says
what the ratios are good to. An effect that a scene does not have costs nothing: no kernel of it is made.
`python benchmarks/effect_price.py` measures them again; factorising the tangent comes on top and is in
[speed](speed.md)."""


def _without_links(text: str) -> str:
    """Docstring markup as the page's."""
    return " ".join(text.split()).replace(":class:`", "`kg.").replace("``", "`")


def _first(said: str, column: str) -> str:
    """A refusal on one line, the same for all rungs that make it."""
    return " ".join(said.replace(f"stiffness='{'plate' if column == 'plane' else column}'", "stiffness=...").split())


def main() -> None:
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
