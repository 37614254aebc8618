"""Every rung of accuracy against independent shell solutions of three cut sheets, on the meshes of the shell.

* disc: radius 3, one slit pulled open, one lip up and one down; t / R = 1e-3
* strip: clamped Mylar strip with one slit across; its ligaments wrinkle above 1 % strain
* cells: curved cuts, 2 x 5 cells, to 20 % stretch

The shell curves in benchmarks/data were computed with Kratos Multiphysics 10.4.4 (corotational thin-shell triangles
with rotations, static Newton, displacement control) on these meshes and finer ones, with the same stress-free
imperfection.
The reference is the finest curve reduced by the error its own refinement shows to remain; that error is the band within
which nothing can be said. Seconds are CPU seconds of one thread; the shell's come from a like machine, good to a factor
of two.

    python benchmarks/shell_references.py                          # coarse meshes, all rungs
    python benchmarks/shell_references.py --cases disc --meshes coarse medium --stiffness shell plate
    python benchmarks/shell_references.py --meshes 1000 --stiffness shell       # own meshes of 1,000 nodes
    python benchmarks/shell_references.py --picture docs/images/accuracy_and_time.png
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely

import kirigami as kg
from kirigami.post.opening import open_area
from kirigami.study.accuracy import quantities
from kirigami.study.reference import QUANTITIES, read_reference

DATA = Path(__file__).parent / "data"
ROUGH = 2e-4  # of the size of a sheet: how far own meshes may leave its rims


@dataclass(frozen=True)
class Case:
    """One sheet and its shell solution."""

    material: kg.Material
    thickness: float
    at: tuple[float, ...]  # load factors that are compared
    finest: str  # shell mesh of the reference
    remaining: tuple[float, ...]  # error of its force that refinement shows to remain, and the band, at each of them
    band: tuple[float, float]  # of open area and of height
    shell: dict[str, tuple[int, float]]  # nodes and CPU seconds of the shell's runs
    shift: bool = True  # False: the remaining error has no known sign


CASES = {
    "disc": Case(
        kg.Material(E=760000.0, nu=0.34), 0.003, (0.2, 0.5, 1.0), "fine", (0.015, 0.033, 0.065), (0.005, 0.005),
        {"coarse": (982, 53.1), "medium": (2283, 88.9), "fine": (5524, 166.4)},
    ),
    "strip": Case(
        kg.Material(E=3.5e9, nu=0.34), 1e-4, (0.05, 0.1, 0.2), "medium", (0.03, 0.03, 0.03), (0.02, 0.05),
        {"coarse": (1172, 13.6), "medium": (2554, 32.3)}, shift=False,
    ),
    "cells": Case(
        kg.Material(E=2.5e9, nu=0.34), 0.003, (0.05, 0.2, 0.5, 1.0), "medium", (0.01, 0.01, 0.01, 0.01), (0.002, 0.015),
        {"coarse": (4614, 136.2), "medium": (9016, 305.3)},
    ),
}  # fmt: skip


def read_mesh(case: str, level: str) -> tuple[kg.TriMesh, np.ndarray]:
    """Mesh of the shell solution, with its grips as node sets, and the height of the imperfection."""
    with np.load(DATA / f"{case}_{level}.npz") as file:
        sets = {name: file[name] for name in file.files if name not in ("nodes", "triangles", "height")}
        return kg.TriMesh(file["nodes"], file["triangles"], sets), file["height"]


def own_mesh(case: str, nodes: int) -> tuple[kg.TriMesh, np.ndarray]:
    """A mesh of this package, within a budget of nodes, of the sheet that the coarse mesh outlines, with the same grips
    and the imperfection interpolated."""
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

    given, height = read_mesh(case, "coarse")
    finer, finer_height = read_mesh(case, "medium")
    outer, *inner = (given.nodes[loop, :2] for loop in given.boundary_loops)
    rough = ROUGH * given.size  # the coarse mesh has more points along its cuts than such a mesh
    sheet = kg.Sheet(
        shapely.Polygon(outer).simplify(rough), [shapely.Polygon(loop).simplify(rough) for loop in inner]
    )
    x, y = given.nodes[:, :2].T
    ends = {name: given.nodes[nodes_of, :2] for name, nodes_of in given.sets.items()}
    lines = {}
    for name, points in ends.items():
        if case == "cells":  # strips: their inner lines are mesh lines
            level = points[:, 1].max() if name == "bottom" else points[:, 1].min()
            lines[f"{name} line"] = shapely.LineString([(x.min(), level), (x.max(), level)])
    made = sheet.mesh(nodes=nodes, lines=lines)
    at = made.nodes[:, :2]
    sets = {}
    for name, points in ends.items():
        low, high = points.min(axis=0) - 1e-9, points.max(axis=0) + 1e-9
        if case == "disc":  # arcs: all of the outline between their ends
            low[1], high[1] = (0.0, np.inf) if name == "top" else (-np.inf, 0.0)
        inside = ((at >= low) & (at <= high)).all(axis=1)
        on_rim = np.isin(np.arange(len(at)), made.boundary("outer"))
        sets[name] = np.flatnonzero(inside & (on_rim | (case == "cells")))
    near, wide = (kind(finer.nodes[:, :2], finer_height) for kind in (NearestNDInterpolator, LinearNDInterpolator))
    found = wide(at)
    return made.with_sets(**sets), np.where(np.isnan(found), near(at), found)


def run(case: str, level: str, stiffness: str) -> dict[str, float]:
    """Follow one case with one rung on one mesh; cost, and the quantities at the load factors."""
    known = CASES[case]
    begin = time.process_time()
    mesh, height = own_mesh(case, int(level)) if level.isdecimal() else read_mesh(case, level)
    m = kg.Model.from_mesh(mesh, known.thickness, known.material, stiffness)
    m.perturb(height)
    grip = {name: [m.nodes[k] for k in mesh.sets[name]] for name in mesh.sets}
    start, spent = None, 0
    if case == "disc":
        m.add(kg.Prescribe(grip["top"], x=0, y=0.08, z=0), kg.Prescribe(grip["bottom"], x=0, y=-0.08, z=0))
        driven, axis = grip["top"], "y"
        start, spent = lower_lip_down(m)
    elif case == "strip":
        m.add(kg.Fix(grip["left"], clamp=True), kg.Prescribe(grip["right"], x=0.01, y=0, z=0, clamp=True))
        driven, axis = grip["right"], "x"
    else:
        m.add(kg.Fix(grip["bottom"], clamp=True), kg.Prescribe(grip["top"], x=0, y=0.4, z=0, clamp=True))
        driven, axis = grip["top"], "y"
    analysis = kg.DisplacementControl(m, to=known.at[-1], targets=known.at, start=start)
    results = analysis.run()
    row: dict[str, float] = {
        "nodes": len(mesh.nodes),
        "cpu_seconds": time.process_time() - begin,
        "factorizations": results.stats["factorizations"] + spent,
    }
    values = quantities(results, driven, axis)
    values["open_area"] = open_area(results.position(), mesh.cuts, union=True)  # within chords, as the reference's
    for lam in known.at:
        step = results.nearest(lam)
        row |= {f"{name} at {lam:g}": float(values[name][step]) for name in QUANTITIES}
        row[f"stable at {lam:g}"] = float(results.stable[step])
    return row


def lower_lip_down(m: kg.Model) -> tuple[kg.Step, int]:
    """The disc with its lower lip pushed down until it has popped: the branch on which the shell is.

    Both lips up is stable too, with more force. A small dead load chooses, and is taken away again.
    """
    x = m.positions()
    lip = m.nodes[int(np.argmin(np.hypot(x[:, 0], x[:, 1] + 0.05) + 9.0 * (x[:, 1] > 0)))]
    push = m.add(kg.NodalLoad(lip, (0, 0, -2e-3), constant=True))
    results = kg.DisplacementControl(m, to=0.02).run()
    m.remove(push)
    return results[-1], int(results.stats["factorizations"])


def reference(case: str) -> dict[str, np.ndarray]:
    """The finest shell curve at the load factors, its force reduced by the error that remains."""
    known = CASES[case]
    values = read_reference(DATA / f"{case}_{known.finest}_shell.csv", np.array(known.at)).values
    if known.shift:
        values["force"] = values["force"] * (1 - np.array(known.remaining))
    return values


def errors(case: str, row: dict[str, Any], wanted: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Relative errors of each quantity at the load factors."""
    found = {name: np.array([float(row[f"{name} at {lam:g}"]) for lam in CASES[case].at]) for name in QUANTITIES}
    return {name: found[name] / wanted[name] - 1 for name in QUANTITIES}


def shell_errors(case: str, level: str, wanted: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    values = read_reference(DATA / f"{case}_{level}_shell.csv", np.array(CASES[case].at)).values
    return {name: values[name] / wanted[name] - 1 for name in QUANTITIES}


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", nargs="+", choices=list(CASES), default=list(CASES))
    parser.add_argument("--meshes", nargs="+", default=["coarse"], help="coarse, medium, or a budget of own nodes")
    parser.add_argument("--stiffness", nargs="+", default=["paper", "plate", "facet", "shell"])
    parser.add_argument("--folder", type=Path, default=Path("shell_references"))
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args(arguments)
    options.folder.mkdir(parents=True, exist_ok=True)
    rows: list[dict[str, Any]] = []
    for case in options.cases:
        for level in options.meshes:
            for stiffness in options.stiffness:
                design = {"case": case, "level": level, "stiffness": stiffness}
                with ThreadPoolExecutor(1) as alone:
                    table = kg.Sweep(run, [design], options.folder / f"{case}_{level}_{stiffness}").run(alone)
                rows.append(next(iter(table)))
    print("| case | mesh | rung | nodes | CPU s | factorizations | force % | open area % | height % |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for case in options.cases:
        wanted = reference(case)
        for level, (nodes, seconds) in CASES[case].shell.items():
            found = shell_errors(case, level, wanted)
            print(f"| {case} | {level} | shell code | {nodes} | {seconds:.0f} | | {_told(found)} |")
        for row in rows:
            if row["case"] != case:
                continue
            head = f"| {case} | {row['level']} | {row['stiffness']} | "
            if row["status"] != "done":
                print(f"{head}{row['status']}: {str(row['error'])[:100]} |")
                continue
            found = errors(case, row, wanted)
            print(
                f"{head}{int(row['nodes'])} | {float(row['cpu_seconds']):.1f} | {int(row['factorizations'])} | "
                f"{_told(found)} |"
            )
    if options.picture:
        draw(rows, options.picture)


def _told(found: dict[str, np.ndarray]) -> str:
    return " | ".join(" / ".join(f"{100 * value:+.1f}" for value in found[name]) for name in QUANTITIES)


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """Largest force error against CPU seconds, one panel a case, the shell's own points in black."""
    import matplotlib.pyplot as plt

    from kirigami.study.accuracy_picture import LOOKS

    cases = list(dict.fromkeys(row["case"] for row in rows))
    figure, panels = plt.subplots(1, len(cases), figsize=(3.5 * len(cases), 3.5), layout="constrained", squeeze=False)
    for ax, case in zip(panels[0], cases):
        wanted = reference(case)
        shell = CASES[case].shell
        worst = [100 * np.abs(shell_errors(case, level, wanted)["force"]).max() for level in shell]
        points = [(seconds, error) for (_, seconds), error in zip(shell.values(), worst) if error > 0.1]
        ax.plot(*zip(*points), "k*-", lw=0.8, label="shell code")
        for rung, (color, marker) in LOOKS.items():
            chosen = [r for r in rows if r["case"] == case and r["stiffness"] == rung and r["status"] == "done"]
            chosen.sort(key=lambda row: float(row["cpu_seconds"]))
            seconds = [float(row["cpu_seconds"]) for row in chosen]
            found = [100 * np.abs(errors(case, row, wanted)["force"]).max() for row in chosen]
            if chosen:
                ax.plot(seconds, found, color=color, marker=marker, lw=1, label=rung)
        ax.axhspan(1e-2, 100 * max(CASES[case].remaining), color="black", alpha=0.07, lw=0)
        ax.set(xscale="log", yscale="log", ylim=(0.5, 200), xlabel="CPU seconds", title=case, xlim=(2, 400))
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter("")
        ax.grid(True, which="both", lw=0.3, alpha=0.5)
    panels[0][0].set_ylabel("largest force error [%]")
    panels[0][0].legend(fontsize=7)
    figure.savefig(path, dpi=130)


if __name__ == "__main__":
    main()
