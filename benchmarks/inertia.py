"""Where snaps land with inertia: lightly damped motion against the overdamped limit that the default follows.

    python benchmarks/inertia.py                      every sheet, seed and run not yet done, and the table
    python benchmarks/inertia.py --sheet cells ring   some sheets
    python benchmarks/inertia.py --table              print the table of what is done

The eight sheets of benchmarks/landing.py on meshes of about 500 nodes, t/L = 1e-3, with the imperfection of
``Model.imperfect`` (a tenth of the thickness) in three seeds, pulled by 10 %, where hardly any snaps. So each is
then held, and its highest or lowest node is pushed through to the other side. The corrector is "path" throughout; with
settle="dynamics" each snap is left once more with masses, damped by 5 and by 2 % of the critical damping of the slowest
motion about the landing. Two shapes at one load factor are the same where they differ by less than 2 % of the norm of
the deflection. Only load factors at or after the first snap say something: before it there is nothing to choose.

Rows are appended to benchmarks/results/inertia.csv and shapes kept in a folder beside it, so the comparison can be
interrupted and goes on where it was. Where the shapes of an overdamped run are missing, it is made again.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import kirigami as kg

sys.path.insert(0, str(Path(__file__).parent))
import correctors
import landing
import tables

POINTS = (0.25, 0.5, 0.75, 1.0)  # shares of the pull
SEEDS = (0, 1, 2)
COARSER = 1.55  # factor on the edges of benchmarks/landing.py
RUNS: dict[str, dict[str, Any]] = {
    "overdamped": {},
    "damped 0.05": {"settle": "dynamics", "damping": 0.05},
    "damped 0.02": {"settle": "dynamics", "damping": 0.02},
}
TABLE = Path(__file__).parent / "results" / "inertia.csv"
SHAPES = TABLE.with_suffix("")


def sheet_model(name: str, seed: int) -> kg.Model:
    """A sheet with the imperfection of a seed."""
    geometry, edge, cut_edge = correctors.SHEETS[name]
    factor = COARSER * landing.COARSE[name]
    coarse = (geometry, factor * edge, cut_edge and factor * cut_edge)
    with mock.patch.dict(correctors.SHEETS, {name: coarse}), warnings.catch_warnings():
        warnings.simplefilter("ignore", kg.KirigamiWarning)
        m = correctors.sheet_model(name, 1e-3, 0.0, 0.1)
        m.imperfect(seed=seed)
    return m


def pull(sheet: str, seed: int, run: str) -> dict[str, str]:
    """Pull one sheet, push it through in one way: a row of the table; the shapes go to their file."""
    m = sheet_model(sheet, seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kg.KirigamiWarning)
        pulled = kg.DisplacementControl(m).run(on_failure="return")
        met = sum(event.kind == "snap" for event in pulled.events)
        m.hold(pulled[-1])
        z = (m.positions() + pulled.u[-1])[:, 2]
        pushed = int(np.argmax(np.abs(z)))
        m.add(kg.Prescribe(m.nodes[pushed], z=float(pulled.u[-1, pushed, 2] - 2 * z[pushed])))
        began = time.process_time()
        res = kg.DisplacementControl(m, targets=POINTS, start=pulled[-1], **RUNS[run]).run(on_failure="return")
    snaps = [event for event in res.events if event.kind == "snap"]
    row = {"sheet": sheet, "seed": str(seed), "run": run, "nodes": str(len(m.nodes)), "snaps of the pull": str(met)}
    row |= {"cpu_seconds": f"{time.process_time() - began:.1f}", "factorizations": str(res.stats["factorizations"])}
    row |= {"end": f"{res.lam[-1]:.4g}", "snaps": " ".join(f"{event.lam:.5g}" for event in snaps)}
    energy = np.sum(list(res.energy.values()), axis=0)
    steps = [res.nearest(point) for point in POINTS]
    for point, step in zip(POINTS, steps):
        row[f"energy {point:g}"] = f"{energy[step]:.8e}" if abs(res.lam[step] - point) < 1e-9 else ""
    SHAPES.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(SHAPES / f"{sheet}, {seed}, {run}.npz", u=res.u[steps].astype(np.float32))
    row["apart"] = " ".join(f"{distance:.3g}" for distance in apart(sheet, seed, run))
    return row


def apart(sheet: str, seed: int, run: str) -> list[float]:
    """Distance of a run to the overdamped one at each load factor, over the norm of the deflection."""
    if not (SHAPES / f"{sheet}, {seed}, overdamped.npz").exists():
        pull(sheet, seed, "overdamped")
    one, two = (
        np.load(SHAPES / f"{sheet}, {seed}, {name}.npz")["u"].astype(float) for name in (run, "overdamped")
    )
    return [float(np.linalg.norm(a - b)) / (float(np.linalg.norm(b[:, 2])) or 1.0) for a, b in zip(one, two)]


def markdown(rows: list[dict[str, str]]) -> str:
    """For each sheet, how many of the shapes at or after a snap differ from the overdamped ones."""
    done = {(row["sheet"], int(row["seed"]), row["run"]): row for row in rows}
    moving = [run for run in RUNS if run != "overdamped"]
    lines = ["| sheet | seeds | snaps, overdamped | " + " | ".join(f"{run}: other shapes" for run in moving) + " |"]
    lines.append("|---" * (3 + len(moving)) + "|")
    total = {run: [0, 0] for run in moving}
    cost = {run: [0.0, 0.0] for run in moving}
    for sheet in landing.COARSE:
        seeds = [seed for seed in SEEDS if (sheet, seed, "overdamped") in done]
        if not seeds:
            continue
        snaps = [done[sheet, seed, "overdamped"]["snaps"].split() for seed in seeds]
        cells = []
        for run in moving:
            count, other = 0, 0
            for seed, met in zip(seeds, snaps):
                if (sheet, seed, run) not in done:
                    continue
                mine, base = done[sheet, seed, run], done[sheet, seed, "overdamped"]
                cost[run][0] += float(mine["factorizations"])
                cost[run][1] += float(base["factorizations"])
                first = min((float(lam) for lam in met), default=np.inf)
                for point, distance in zip(POINTS, map(float, mine["apart"].split())):
                    there = mine[f"energy {point:g}"] and base[f"energy {point:g}"] and np.isfinite(distance)
                    if point >= first and there:
                        count, other = count + 1, other + (distance > landing.SAME)
            total[run][0] += other
            total[run][1] += count
            ran = any((sheet, seed, run) in done for seed in seeds)
            cells.append(f"{other} of {count}" if count else "no snap" if ran else "not run")
        lines.append(f"| {sheet} | {len(seeds)} | {' / '.join(str(len(s)) for s in snaps)} | {' | '.join(cells)} |")
    for run, (other, count) in total.items():
        if count:
            price = cost[run][0] / cost[run][1]
            lines.append(f"\n{run}: {other} of {count} shapes after a snap are other ones; {price:.1f} times the work")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheet", nargs="+", choices=list(landing.COARSE), default=list(landing.COARSE))
    parser.add_argument("--seed", nargs="+", type=int, choices=SEEDS, default=list(SEEDS))
    parser.add_argument("--run", nargs="+", choices=list(RUNS), default=list(RUNS))
    parser.add_argument("--table", action="store_true", help="print what is done, run nothing")
    wanted = parser.parse_args()
    done = {(row["sheet"], int(row["seed"]), row["run"]) for row in tables.read(TABLE)}
    for seed in () if wanted.table else wanted.seed:
        for sheet in wanted.sheet:
            for run in wanted.run:
                if (sheet, seed, run) not in done:
                    row = pull(sheet, seed, run)
                    tables.add(TABLE, row)
                    print(" ".join(row.values()), flush=True)
    print(markdown(tables.read(TABLE)))


if __name__ == "__main__":
    main()
