"""The dozen: twelve drawings in four formats, stretched with default options alone.

For each drawing of benchmarks/data/dozen: it reads right (area and number of cuts of the design), its linear in-plane
stiffness at the default mesh is held against quadratic triangles of another program (reference.json), and kg.stretch
takes it to the default strain. Prints a table and writes rows as they come; run again, it goes on where it was.

    python benchmarks/dozen.py                                   # all, draft and standard
    python benchmarks/dozen.py --only fan spiral --accuracy draft
    python benchmarks/dozen.py --linear                          # reading and stiffness alone: under a minute
    python benchmarks/dozen.py --refined --accuracy standard     # and the force against its refined limit, on its shape
    python benchmarks/dozen.py --command                         # through `kirigami stretch`, with report and pictures
"""

from __future__ import annotations

import argparse
import csv
import json
import time
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from dozen_drawings import separate

import kirigami as kg
from kirigami import units
from kirigami.drawing.convert import read_drawing
from kirigami.drawing.drawing import Drawing
from kirigami.study.accuracy import ALIKE
from kirigami.study.grips import find_grips
from kirigami.study.mesh_choice import shape_distance
from kirigami.study.stretch import ACCURACY, default_mesh
from kirigami.study.transfer import on_shape

FOLDER = Path(__file__).parent / "data" / "dozen"
ALLOWED = {"draft": 60.0, "standard": 180.0, "fine": float("inf")}  # CPU seconds
STIFFNESS_ERROR = 0.10
FORCE_ERROR, FINER = 0.05, 4  # against the refined limit, from a mesh of so many times the nodes
COLUMNS = ("name", "accuracy", "read", "area_error", "cuts", "nodes", "stiffness_error", "cpu", "factorizations",
           "steps", "strain", "force", "events", "force_error", "apart", "bar", "verdict")  # fmt: skip
HEAD = (
    "drawing   accuracy  read    cuts  nodes stiffness     CPU factor-  strain     force  events   force   bar apart\n"
    "                                          error %       s izations     %         N         error %     %"
)


def designs() -> list[dict[str, Any]]:
    """What is to be read: file, thickness, E, area and number of cuts."""
    listed: list[dict[str, Any]] = json.loads((FOLDER / "dozen.json").read_text(encoding="utf-8"))
    return listed


def references() -> dict[str, float]:
    """Stiffness over E t of each sheet, by quadratic triangles."""
    content = json.loads((FOLDER / "reference.json").read_text(encoding="utf-8"))
    return {row["name"]: row["stiffness"] for row in content["rows"]}


def read(row: dict[str, Any]) -> tuple[Drawing, kg.Sheet]:
    """The drawing, and the sheet with its thickness and material, in metres."""
    drawing = read_drawing(FOLDER / row["file"], unit="m")
    E = units.parse(row["E"], "stress")
    return drawing, drawing.sheet(units.parse(row["thickness"], "length"), kg.Material(E=E, nu=0.34))


def linear_stiffness(sheet: kg.Sheet, accuracy: str) -> tuple[float, int]:
    """Force per displacement over E t at the mesh and on the rung of an accuracy, and its nodes."""
    level, grips = ACCURACY[accuracy], find_grips(sheet, "y")
    mesh = default_mesh(sheet, grips.lines(), level.nodes, None)
    model = kg.Model.from_mesh(mesh, stiffness=level.stiffness)
    _, moved = grips.hold(model, 1e-3 * grips.free_length)
    assert sheet.material is not None and sheet.thickness is not None
    force = float(kg.LinearStatic(model).run().reaction(moved, "y")[-1])
    return force / (1e-3 * grips.free_length * sheet.material.E * sheet.thickness), len(mesh.nodes)


def judge(
    row: dict[str, Any], accuracy: str, linear: bool, reference: float, against_limit: bool = False
) -> dict[str, Any]:
    """One row of the table."""
    name = Path(row["file"]).stem
    _, sheet = read(row)
    found: dict[str, Any] = {"name": name, "accuracy": accuracy, "area_error": sheet.area / row["area"] - 1}
    found["cuts"] = separate(sheet.cuts)
    found["read"] = abs(found["area_error"]) < 1e-3 and found["cuts"] == row["cuts"]
    begun = time.process_time()
    stiffness, found["nodes"] = linear_stiffness(sheet, accuracy)
    found["stiffness_error"] = stiffness / reference - 1
    right = found["read"] and abs(found["stiffness_error"]) <= STIFFNESS_ERROR
    if not linear:
        begun = time.process_time()
        try:
            results = kg.stretch(sheet, accuracy=accuracy)
        except kg.ConvergenceError as error:
            results = error.results
        found["cpu"] = time.process_time() - begun
        found |= {
            "factorizations": results.stats["factorizations"], "steps": len(results),
            "strain": 0.2 * float(results.lam[-1]), "events": len(results.events),
            "force": float(results.reaction(results.grips["moved"], "y")[-1]),
        }  # fmt: skip
        right = right and results.lam[-1] == 1.0 and found["cpu"] <= ALLOWED[accuracy]
        if against_limit:
            found["force_error"], found["apart"] = refined(results, sheet, accuracy)
            found["bar"] = float(results.error["force"][-1])
            right = right and abs(found["force_error"]) <= FORCE_ERROR and found["apart"] <= ALIKE
    else:
        found["cpu"] = time.process_time() - begun
    found["verdict"] = "right" if right else "short"
    return found


def refined(results: kg.Results, sheet: kg.Sheet, accuracy: str) -> tuple[float, float]:
    """Force at the end over its refined limit, less one, and how far apart the shapes are.

    The shape is carried to a mesh of four times as many nodes and brought to equilibrium there; what that mesh lacks
    itself is a third of the difference, since errors go with one over the nodes (benchmarks/default_mesh.py).
    """
    level, grips = ACCURACY[accuracy], find_grips(sheet, "y")
    model = kg.Model.from_mesh(default_mesh(sheet, grips.lines(), FINER * level.nodes, None), stiffness="shell")
    grips.hold(model, 0.2 * grips.free_length)
    model.imperfect()
    (fine,) = on_shape(model, results, [len(results) - 1], tol=1e-7)
    if fine is None:
        return float("nan"), float("nan")
    assert results.mesh is not None and fine.mesh is not None
    force = float(results.reaction(results.grips["moved"], "y")[-1])
    moved = np.flatnonzero(fine.mesh.nodes[:, 1] >= grips.last - grips.strip - 1e-9 * fine.mesh.size)
    finer = float(fine.reaction(moved, "y")[-1])
    ratio = len(fine.mesh.nodes) / len(results.mesh.nodes)
    limit = finer - (force - finer) / (ratio - 1)
    return force / limit - 1, shape_distance(fine, results)


def shown(row: dict[str, Any]) -> str:
    """One line of the table."""

    def number(key: str, form: str, scale: float = 1.0) -> str:
        value = row.get(key, "")
        return "-" if value in ("", None) else format(scale * float(value), form)

    return (
        f"{row['name']:<9} {row['accuracy']:<9} {row['read']!s:<6} {row['cuts']:>5} {row['nodes']:>6} "
        f"{number('stiffness_error', '+.1f', 100):>9} {number('cpu', '.1f'):>7} {number('factorizations', '.0f'):>6} "
        f"{number('strain', '.3g', 100):>7} {number('force', '.4g'):>9} {number('events', '.0f'):>7} "
        f"{number('force_error', '+.1f', 100):>7} {number('bar', '.1f', 100):>5} {number('apart', '.2f'):>5}  "
        f"{row['verdict']}"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what has not been run, print the table; 1 where a row falls short."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", metavar="NAME", help="some of the drawings")
    parser.add_argument("--accuracy", nargs="+", default=["draft", "standard"], choices=tuple(ACCURACY))
    parser.add_argument("--linear", action="store_true", help="no path")
    parser.add_argument("--refined", action="store_true", help="compare the force with its refined limit on its shape")
    parser.add_argument("--command", action="store_true", help="run the command line, and write its reports")
    parser.add_argument("--table", type=Path, default=Path("dozen.csv"), help="rows (default: %(default)s)")
    parser.add_argument("--folder", type=Path, default=Path("dozen"), help="reports (default: ./%(default)s)")
    options = parser.parse_args(arguments)
    known = references()
    chosen = [row for row in designs() if not options.only or Path(row["file"]).stem in options.only]
    if options.command:
        return by_command(chosen, options.accuracy, options.folder)
    done: dict[tuple[str, str], dict[str, Any]] = {}
    if options.table.exists() and not options.linear:
        with options.table.open(newline="", encoding="utf-8") as file:
            done = {(row["name"], row["accuracy"]): row for row in csv.DictReader(file)}
    print(HEAD)
    rows = []
    for accuracy in options.accuracy:
        for design in chosen:
            name = Path(design["file"]).stem
            row = done.get((name, accuracy))
            if row is None:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    row = judge(design, accuracy, options.linear, known[name], options.refined)
                if not options.linear:
                    done[name, accuracy] = row
                    with options.table.open("w", newline="", encoding="utf-8") as file:
                        writer = csv.DictWriter(file, COLUMNS)
                        writer.writeheader()
                        writer.writerows(done.values())
            print(shown(row), flush=True)
            rows.append(row)
    short = [row for row in rows if row["verdict"] != "right"]
    print(f"{len(rows) - len(short)} of {len(rows)} right")
    return int(bool(short))


def by_command(chosen: list[dict[str, Any]], accuracies: Sequence[str], folder: Path) -> int:
    """The same through the command line: its exit codes, and a folder of pictures for each."""
    from kirigami import cli

    worst = 0
    for accuracy in accuracies:
        for row in chosen:
            target = folder / f"{Path(row['file']).stem}-{accuracy}"
            begun = time.process_time()
            words = ["stretch", str(FOLDER / row["file"]), "--thickness", row["thickness"], "--E", row["E"]]
            code = cli.main([*words, "--accuracy", accuracy, "--folder", str(target), "--quiet"])
            print(f"{target}: exit code {code}, {time.process_time() - begun:.1f} CPU s", flush=True)
            worst = max(worst, code)
    return worst


if __name__ == "__main__":
    raise SystemExit(main())
