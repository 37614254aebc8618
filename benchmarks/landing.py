"""Where thin cut sheets land, by corrector, against a slow pull: energy and shape at 1/4, 1/2 and all of the pull.

    python benchmarks/landing.py                       every sheet and run not yet done, and the table
    python benchmarks/landing.py --sheet cells ring    some sheets
    python benchmarks/landing.py --table               print the table of what is done

A thin sheet has many stable shapes at one pull; which of them a slow pull with a little damping leads to is a question
with an answer (corrector "slow"). Eleven sheets of at most 1,000 nodes: those of benchmarks/correctors.py on coarser
meshes, t/L = 1e-3, imperfection 1e-3 t, pulled by 10 %; and the ribbon of the README, imperfection one thickness in
its seventh mode and in two random sums of modes, to a quarter of its pull. Two shapes are the same where they differ by
less than 2 % of the norm of the deflection; mirror images in the plane of the sheet count and are marked "m".

What the default tells of snaps and bifurcations is compared with a run of ten times shorter increments. Small snaps, of
less than a hundredth of force times displacement each, are told together by both and listed with their energy.

The slow pull itself is settled at a load factor where it ends in the same shape three times as fast, ten times as slow,
and with halved steps. Rows, with their distances from the shapes of the slow pull, are appended to
benchmarks/results/landing.csv and shapes kept in a folder beside it, so the comparison can be interrupted and goes on
where it was; the table needs the rows alone.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from shapely import box

import kirigami as kg
from kirigami.analysis.path import methods, slow, stable

sys.path.insert(0, str(Path(__file__).parent))
import correctors
import tables

POINTS = (0.25, 0.5, 1.0)  # shares of the pull
SAME = 0.02  # distance of two shapes, over the norm of the deflection, below which they count as the same
COARSE = {
    "one slit": 1.63,
    "staggered": 1.55,
    "disc": 1.65,
    "random": 1.75,
    "cross": 1.72,
    "parallel": 2.0,
    "cells": 2.2,
    "ring": 1.76,
}
RUNS: dict[str, tuple[str, dict[str, float]]] = {
    "slow": ("slow", {}),
    "slow, faster": ("slow", {"SLOW": 30.0}),
    "slow, slower": ("slow", {"SLOW": 1000.0}),
    "slow, halved steps": ("slow", {"OFF": 0.5 * slow.OFF, "TURN": 0.5 * slow.TURN}),
    **{name: (name, {}) for name in ("path", "descent", "viscous", "newton")},
    "path, ten times finer": (
        "path",
        {"FIRST": 0.1 * stable.FIRST, "SHARE": 0.1 * stable.SHARE, "CLOSE": 0.1 * stable.CLOSE},
    ),
}
TABLE = Path(__file__).parent / "results" / "landing.csv"
SHAPES = TABLE.with_suffix("")  # folder of the shapes


def benchmark_sheet(name: str) -> kg.Model:
    """A sheet of benchmarks/correctors.py on a coarser mesh."""
    geometry, edge, cut_edge = correctors.SHEETS[name]
    coarse = COARSE[name]
    with mock.patch.dict(correctors.SHEETS, {name: (geometry, coarse * edge, cut_edge and coarse * cut_edge)}):
        return correctors.sheet_model(name, 1e-3, 1e-3, 0.1)


def ribbon(seed: int) -> kg.Model:
    """The ribbon of the README; seed 0 is its own imperfection, the others are random sums of modes."""
    slits = kg.cuts.parallel_slits(columns=1, rows=9, width=0.1, height=0.2, length=0.075, margin=0.02)
    sheet = kg.Sheet(box(0, 0, 0.1, 0.24), slits, thickness=0.2e-3, material=kg.Material(E=3.5e9, nu=0.34))
    m = kg.Model.from_mesh(sheet.mesh(max_edge=0.012))
    modes = kg.Eigen(m, n=60).run()
    shape = modes[6].shape
    if seed:
        rng = np.random.default_rng(seed)
        shape = sum(rng.normal() / np.sqrt(abs(modes.values[k])) * modes[k].shape for k in range(6, 60))
    m.perturb(shape, amplitude=0.2e-3)
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=0.01))
    return m


SHEETS: dict[str, Callable[[], kg.Model]] = {
    **{f"ribbon {seed}": lambda seed=seed: ribbon(seed) for seed in range(3)},
    **{name: lambda name=name: benchmark_sheet(name) for name in correctors.SHEETS},
}


def pull(sheet: str, run: str) -> dict[str, str]:
    """Pull one sheet in one way: a row of the table; the shapes go to their file."""
    corrector, constants = RUNS[run]
    m = SHEETS[sheet]()
    began = time.process_time()
    with warnings.catch_warnings(), ExitStack() as changed:
        for module in (slow, stable, methods):
            known = {name: value for name, value in constants.items() if hasattr(module, name)}
            changed.enter_context(mock.patch.dict(vars(module), known))
        warnings.simplefilter("ignore", kg.KirigamiWarning)
        res = kg.DisplacementControl(m, targets=POINTS, corrector=corrector).run(on_failure="return")
    seconds = time.process_time() - began
    row = {"sheet": sheet, "run": run, "nodes": str(len(m.nodes)), "cpu_seconds": f"{seconds:.1f}"}
    row |= {"factorizations": str(res.stats["factorizations"]), "end": f"{res.lam[-1]:.4g}"}
    row["events"] = "; ".join(in_short(event) for event in res.events)
    energy = np.sum(list(res.energy.values()), axis=0)
    steps = [res.nearest(point) for point in POINTS]
    for point, step in zip(POINTS, steps):
        row[f"energy {point:g}"] = f"{energy[step]:.8e}" if abs(res.lam[step] - point) < 1e-9 else ""
    SHAPES.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(SHAPES / f"{sheet}, {run}.npz", u=res.u[steps].astype(np.float32))
    return row | apart(sheet, run)


def in_short(event: kg.Event) -> str:
    """Kind and bracket of an event and, if it tells of one, its energy."""
    energy = "" if event.energy is None else f", {event.energy:.3g}"
    return f"{event.kind} {event.bracket[0]:.6g} {event.bracket[1]:.6g}{energy}"


def apart(sheet: str, run: str) -> dict[str, str]:
    """Distance of a run from the slow pull at each load factor over the norm of the deflection; "m": mirror images."""
    found = dict.fromkeys((f"apart {point:g}" for point in POINTS), "")
    if not (SHAPES / f"{sheet}, slow.npz").exists():
        return found
    one, two = (np.load(SHAPES / f"{sheet}, {name}.npz")["u"].astype(float) for name in (run, "slow"))
    for point, a, b in zip(POINTS, one, two):
        size = float(np.linalg.norm(b[:, 2]))
        distance = [float(np.linalg.norm(a * side - b)) / size for side in ([1, 1, 1], [1, 1, -1])]
        found[f"apart {point:g}"] = f"{min(distance):.3g}" + " m" * (distance[1] < distance[0])
    return found


def distance(row: dict[str, str], point: float) -> tuple[float, bool] | None:
    """Distance from the slow pull, and whether of mirror images; None where the run did not come so far."""
    told = row[f"apart {point:g}"].split()
    if not told or not row[f"energy {point:g}"]:
        return None
    return float(told[0]), len(told) > 1


def settled(sheet: str, done: dict[tuple[str, str], dict[str, str]]) -> list[bool] | None:
    """At which load factors the slow pull does not depend on its own speed and steps; None where not all are done."""
    variants = [run for run in RUNS if run.startswith("slow,")]
    if any((sheet, run) not in done for run in ("slow", *variants)):
        return None
    return [all((d := distance(done[sheet, v], point)) and d[0] < SAME for v in variants) for point in POINTS]


def markdown(rows: list[dict[str, str]]) -> str:
    """A line for each sheet and load factor: is the slow pull settled, and how far the others land from it."""
    done = {(row["sheet"], row["run"]): row for row in rows}
    methods = [name for name in RUNS if "," not in name and name != "slow"]
    lines = ["| sheet | of the pull | settled | " + " | ".join(methods) + " |", "|---" * (3 + len(methods)) + "|"]
    same: dict[str, list[bool]] = {name: [] for name in methods}
    for sheet in SHEETS:
        if (sheet, "slow") not in done:
            continue
        calm = settled(sheet, done)
        for place, point in enumerate(POINTS):
            cells = []
            for name in methods:
                away = distance(done[sheet, name], point) if (sheet, name) in done else None
                if (sheet, name) in done and calm is not None and calm[place]:
                    same[name].append(away is not None and away[0] < SAME)
                if away is None:
                    cells.append("")
                    continue
                energy, reference = (float(done[sheet, run][f"energy {point:g}"]) for run in (name, "slow"))
                shown = "same" if away[0] < SAME else f"{100 * away[0]:.0f} % off"
                mark = " m" if away[1] and away[0] < SAME else ""
                cells.append(f"{shown}{mark}, energy {100 * (energy / reference - 1):+.2g} %")
            told = "" if calm is None else ("yes" if calm[place] else "no")
            lines.append(f"| {sheet} | {point:g} | {told} | " + " | ".join(cells) + " |")
        counts = [done[sheet, name]["factorizations"] if (sheet, name) in done else "" for name in methods]
        lines.append(f"| {sheet}, factorisations | | {done[sheet, 'slow']['factorizations']} | {' | '.join(counts)} |")
    for name, found in same.items():
        if found:
            lines.append(f"\n{name}: {sum(found)} of {len(found)} where the slow pull is settled")
    lines += events_agree(done)
    return "\n".join(lines)


def told(row: dict[str, str], kind: str) -> list[tuple[float, float]]:
    """Brackets of the events of a kind."""
    listed = (event.split(",")[0].rsplit(" ", 2) for event in row["events"].split("; ") if event)
    return [(float(low), float(high)) for name, low, high in listed if name == kind]


def events_agree(done: dict[tuple[str, str], dict[str, str]]) -> list[str]:
    """Snaps and bifurcations told by the default against a run of ten times shorter increments."""
    lines, agreed = [], []
    for sheet in SHEETS:
        if any((sheet, run) not in done for run in ("path", "path, ten times finer")):
            continue
        default, finer = done[sheet, "path"], done[sheet, "path, ten times finer"]
        same = True
        for kind in ("snap", "bifurcation"):
            one, two = told(default, kind), told(finer, kind)
            same &= len(one) == len(two) and all(a[0] <= b[1] and b[0] <= a[1] for a, b in zip(one, two))
        agreed.append(same)
        if not same or told(default, "small snaps") or told(finer, "small snaps"):
            lines.append(f"* {sheet}: {default['events'] or 'nothing'}; finer: {finer['events'] or 'nothing'}")
    head = f"\nsnaps and bifurcations as in a run of ten times shorter increments: {sum(agreed)} of {len(agreed)}"
    head += "; those that do not, and what is told of small snaps:"
    return [head, *lines] if agreed else []


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheet", nargs="+", choices=list(SHEETS), default=list(SHEETS))
    parser.add_argument("--run", nargs="+", choices=list(RUNS), default=list(RUNS))
    parser.add_argument("--table", action="store_true", help="print what is done, run nothing")
    wanted = parser.parse_args()
    done = {(row["sheet"], row["run"]) for row in tables.read(TABLE)}
    for sheet in () if wanted.table else wanted.sheet:
        for run in wanted.run:
            if (sheet, run) not in done:
                row: dict[str, Any] = pull(sheet, run)
                tables.add(TABLE, row)
                print(" ".join(row.values()), flush=True)
    print(markdown(tables.read(TABLE)))


if __name__ == "__main__":
    main()
