"""A thousand random cut sheets, stretched by a tenth: none may crash, hang, or store a step that is no equilibrium.

    python benchmarks/random_sheets.py --table random_sheets.csv            # a thousand sheets; goes on where it was
    python benchmarks/random_sheets.py --corrector descent --table ...      # the same in less time
    python benchmarks/random_sheets.py --stiffness shell --seeds 200 ...    # on another rung
    python benchmarks/random_sheets.py --seeds 50 --small                   # the fifty of the test suite

Each seed draws a sheet one unit wide and one thousandth thick with slits, crossing slits, slots and holes, or lines
drawn at random that may reach the edges, enclose pieces or sever the sheet. It is meshed, given an imperfection of a
hundredth of its thickness, held at both ends and stretched by 10 %. Workers are processes of their own with a limit on
the time of a sheet, so that a process that dies or runs on is an outcome like any other:

    reached       the last load factor was reached
    typed error   a KirigamiError; its class and message are in the table
    crash         the worker died, or raised anything else
    hang          the sheet took longer than the limit
    wrong step    a stored step is no equilibrium, by a residual computed here from the objects of the model alone;
                  on rungs of facets, which have no second formula here, from forces of a system made anew

Whether the cuts sever the sheet is found apart from the package, from the faces of the drawing (shapely.polygonize): a
severed sheet must end in a GeometryError and a connected one must reach the end.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import json
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from random_drawings import KINDS, drawing, falls_apart, parts_of
from second_residual import residuals

import kirigami as kg
from kirigami.system.system import System
from kirigami.words import counted

THICKNESS = 1e-3
STRETCH = 0.1
TOLERANCE = 1e-8
COLUMNS = (
    "seed", "kind", "clamped", "cuts", "parts", "apart", "nodes", "min_angle", "outcome", "error", "last_load_factor",
    "steps",
    "factorizations", "cutbacks", "relaxations", "unstable_steps", "worst_residual", "seconds", "message",
)  # fmt: skip


# ------------------------------------------------------------------------------------------------------ one sheet


def mesh_of(outline: shapely.Polygon, cuts: list[Any], fewest: int, most: int, target: float) -> kg.TriMesh:
    """A mesh of about so many nodes, between the bounds where the drawing allows it."""
    sheet = kg.Sheet(outline, cuts, thickness=THICKNESS, material=kg.Material(E=3.5e9, nu=0.34))
    edge = float(np.sqrt(sheet.area / (0.87 * target)))
    for _ in range(4):
        mesh = sheet.mesh(edge, cut_edge=0.6 * edge)
        nodes = len(mesh.nodes)
        if fewest <= nodes <= most:
            break
        edge *= float(np.clip(np.sqrt(nodes / target), 0.5, 2.0))
    return mesh


def worst_residual(m: kg.Model, results: kg.Results, stiffness: str) -> float:
    """Largest relative residual of the stored steps, found a second time."""
    if stiffness == "plate":
        return max(residuals(m, results))
    system, found = System(m), []
    for step in results.steps:
        system.history = step.history  # the frames from which shell facets measure their turns
        found.append(float(system.imbalance(system.joined(step.u, step.inner), step.lam)[1]))
    return max(found)


def stretch(seed: int, small: bool, corrector: str = "path", stiffness: str = "plate") -> dict[str, Any]:
    """Mesh and stretch the sheet of a seed; a row of the table."""
    outline, cuts, random = drawing(seed, small)
    clamped = bool(seed // len(KINDS) % 2)
    row: dict[str, Any] = {
        "seed": seed, "kind": KINDS[seed % len(KINDS)], "clamped": clamped, "cuts": len(cuts),
        "parts": parts_of(outline, cuts),
        "apart": falls_apart(outline, cuts),
    }  # fmt: skip
    began = time.process_time()
    try:
        fewest, most = (50, 150) if small else (300, 1500)
        mesh = mesh_of(outline, cuts, fewest, most, np.exp(random.uniform(np.log(1.2 * fewest), np.log(0.8 * most))))
        row.update(nodes=len(mesh.nodes), min_angle=round(mesh.min_angle, 2))
        m = kg.Model.from_mesh(mesh, stiffness=stiffness)
        x, y, _ = m.positions().T
        waves = sum(
            random.normal() * np.sin(kx * np.pi * x + random.uniform(0, 2 * np.pi)) * np.sin(ky * np.pi * y / y.max())
            for kx in range(1, 4) for ky in range(1, 4)
        )  # fmt: skip
        m.perturb(waves, amplitude=0.01 * THICKNESS)
        bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
        m.add(kg.Fix(bottom, clamp=clamped), kg.Fix(top, "xz"))
        m.add(kg.Prescribe(top, y=STRETCH * float(np.ptp(y)), clamp=clamped))
        analysis = kg.DisplacementControl(m, tol=TOLERANCE, corrector=corrector)
        try:
            results = analysis.run()
            row["outcome"] = "reached" if results.lam[-1] == 1.0 else "stopped short"
        except kg.ConvergenceError as error:
            assert error.results is not None
            results = error.results
            row.update(outcome="typed error", error=type(error).__name__, message=str(error))
        row["seconds"] = round(time.process_time() - began, 2)
        if results.steps:
            stats = results.stats
            row.update({name: stats[name] for name in ("steps", "factorizations", "cutbacks", "relaxations")})
            row.update(last_load_factor=float(results.lam[-1]), unstable_steps=int(np.sum(~results.stable)))
            row["worst_residual"] = float(f"{worst_residual(m, results, stiffness):.3g}")
            # A thousandth of the tolerance is left for the rounding of another order of summation.
            if not row["worst_residual"] <= 1.001 * TOLERANCE:
                row["outcome"] = "wrong step"
    except kg.KirigamiError as error:
        row.update(outcome="typed error", error=type(error).__name__, message=str(error))
    row.setdefault("seconds", round(time.process_time() - began, 2))
    return row


def is_severed(row: dict[str, Any]) -> bool:
    """Whether the cuts sever the sheet into pieces that are more than scrap, which falls out."""
    return str(row.get("apart", int(row["parts"]) > 1)) == "True"


def as_expected(row: dict[str, Any]) -> bool:
    """A sheet that falls apart ends in a GeometryError, any other one at the last load factor."""
    if is_severed(row):
        return bool(row["outcome"] == "typed error" and row["error"] == "GeometryError")
    return bool(row["outcome"] == "reached")


# -------------------------------------------------------------------------------------------------------- workers


def work() -> None:
    """Answer each request on standard input, a line of JSON, by a row of the table."""
    warnings.simplefilter("ignore", kg.KirigamiWarning)
    for line in sys.stdin:
        request = json.loads(line)
        seed, limit = request["seed"], request["limit"]
        _limit_processor_time(limit)
        try:
            row = stretch(seed, request["small"], request["corrector"], request["stiffness"])
        except Exception as error:
            row = {"outcome": "crash", "error": type(error).__name__, "message": str(error)}
        print(json.dumps(row), flush=True)


def _limit_processor_time(seconds: float) -> None:
    """Let the kernel end this process after so much more processor time, where it can."""
    try:
        import resource
    except ImportError:
        return
    _, hardest = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time() + seconds) + 1, hardest))


class Worker:
    """A process that stretches one sheet after another, replaced when it dies."""

    def __init__(self, corrector: str, stiffness: str) -> None:
        self.corrector, self.stiffness = corrector, stiffness
        self.process: subprocess.Popen[str] | None = None

    def ask(self, seed: int, small: bool, limit: float) -> dict[str, Any]:
        process = self.process
        if process is None:
            command = [sys.executable, "-W", "ignore", __file__, "--work"]
            # One thread each: workers that share the processors must not wait for one another in small matrices.
            alone = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **os.environ}
            process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=alone
            )
            self.process = process
        assert process.stdin is not None and process.stdout is not None and process.stderr is not None
        # Sleeping without end would not use up processor time.
        late = threading.Timer(20 * limit, process.kill)
        late.start()
        request = {"seed": seed, "small": small, "limit": limit, "corrector": self.corrector}
        request["stiffness"] = self.stiffness
        process.stdin.write(json.dumps(request) + "\n")
        process.stdin.flush()
        answer = process.stdout.readline()
        late.cancel()
        if answer:
            row: dict[str, Any] = json.loads(answer)
        else:
            code = process.wait()
            self.process = None
            timed_out = -code in (getattr(signal, "SIGXCPU", None), getattr(signal, "SIGKILL", None))
            outcome = "hang" if timed_out else "crash"
            row = {"outcome": outcome, "seconds": limit, "message": f"exit {code}: {process.stderr.read()[-300:]}"}
        if "parts" not in row:
            outline, cuts, _ = drawing(seed, small)
            row.update(seed=seed, kind=KINDS[seed % len(KINDS)], cuts=len(cuts), parts=parts_of(outline, cuts))
            row["apart"] = falls_apart(outline, cuts)
        return row

    def close(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.wait()


def survey(
    seeds: list[int], table: Path | None, workers: int, small: bool, limit: float, seconds: float,
    corrector: str = "path", stiffness: str = "plate",
) -> list[dict[str, Any]]:
    """Rows of all seeds; each is appended to the table at once. No sheet is begun after so many seconds."""
    rows: list[dict[str, Any]] = []
    waiting = list(reversed(seeds))
    lock = threading.Lock()
    stop = time.monotonic() + seconds

    def serve() -> None:
        with contextlib.closing(Worker(corrector, stiffness)) as worker:
            while time.monotonic() < stop:
                with lock:
                    if not waiting:
                        return
                    seed = waiting.pop()
                row = worker.ask(seed, small, limit)
                with lock:
                    rows.append(row)
                    if table is not None:
                        with table.open("a", newline="", encoding="utf-8") as file:
                            csv.DictWriter(file, COLUMNS, lineterminator="\n").writerow(row)
                    if not as_expected(row):
                        print(f"seed {row['seed']}: {row['outcome']} {row.get('error', '')} "
                              f"{str(row.get('message', '')).splitlines()[:1]}", flush=True)  # fmt: skip

    threads = [threading.Thread(target=serve) for _ in range(workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return sorted(rows, key=lambda row: int(row["seed"]))


def summary(rows: list[dict[str, Any]]) -> str:
    """The figures that count."""
    count = Counter(row["outcome"] for row in rows)
    severed = [row for row in rows if is_severed(row)]
    connected = [row for row in rows if not is_severed(row)]
    scrap = sum(int(row["parts"]) > 1 for row in connected)
    reached = sum(map(as_expected, connected))
    nodes = [int(row["nodes"]) for row in rows if row.get("nodes")]
    seconds = [float(row["seconds"]) for row in connected]
    worst = max((float(row["worst_residual"]) for row in rows if row.get("worst_residual")), default=0.0)
    lines = [
        f"{counted(len(rows), 'sheet')}, {min(nodes, default=0)} to {max(nodes, default=0)} nodes, "
        f"{sum(float(row['seconds']) for row in rows):.0f} s of processor time",
        f"crashes {count['crash']}, hangs {count['hang']}, stored steps above tolerance {count['wrong step']} "
        f"(worst residual {worst:.2e})",
        f"seconds a connected sheet: median {np.median(seconds or [0]):.1f}, largest {max(seconds, default=0):.0f}",
        f"connected: {reached} of {len(connected)} reached the end ({100 * reached / max(len(connected), 1):.1f} %), "
        f"{scrap} of them without scrap that falls out",
        f"severed: {sum(map(as_expected, severed))} of {len(severed)} were refused with a GeometryError",
    ]
    for kind in KINDS:
        of_kind = [row for row in connected if row["kind"] == kind]
        lines.append(f"   {kind}: {sum(map(as_expected, of_kind))} of {len(of_kind)}")
    failed = Counter(f"{row['outcome']} {row.get('error') or ''}".strip() for row in rows if not as_expected(row))
    lines += [f"   not as expected: {name} {number}" for name, number in failed.most_common()]
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=1000, help="how many, from --first on")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--table", type=Path, help="CSV file to append to; seeds found there are not run again")
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    parser.add_argument("--limit", type=float, default=300.0, help="seconds of processor time allowed for one sheet")
    parser.add_argument("--seconds", type=float, default=np.inf, help="begin no sheet after this time")
    parser.add_argument("--corrector", default="path", help="path, the default of the package, or any other")
    parser.add_argument("--stiffness", default="plate", help="plate, the default of Model.from_mesh, facet or shell")
    parser.add_argument("--small", action="store_true", help="at most five cuts, and 50 to 150 nodes where they allow")
    parser.add_argument("--work", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.work:
        work()
        return 0
    seeds = list(range(arguments.first, arguments.first + arguments.seeds))
    before: list[dict[str, Any]] = []
    if arguments.table is not None:
        if arguments.table.exists():
            with arguments.table.open(newline="", encoding="utf-8") as file:
                before = [row for row in csv.DictReader(file) if int(row["seed"]) in set(seeds)]
        else:
            arguments.table.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
    known = {int(row["seed"]) for row in before}
    todo = [seed for seed in seeds if seed not in known]
    rows = survey(
        todo, arguments.table, arguments.workers, arguments.small, arguments.limit, arguments.seconds,
        arguments.corrector, arguments.stiffness,
    )  # fmt: skip
    print(summary(before + rows))
    return 0 if all(map(as_expected, before + rows)) else 1


if __name__ == "__main__":
    raise SystemExit(main())
