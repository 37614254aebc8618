"""How time and memory grow with the size of a sheet: one family of slit sheets, each size in a process of its own.

    python benchmarks/scaling.py                      2,000 to 100,000 nodes
    python benchmarks/scaling.py 2000 500000          these sizes
    python benchmarks/scaling.py 500000 --pull 2e-6   a shorter stretch than the 2e-5 of the others
    python benchmarks/scaling.py 100000 --stiffness shell         another rung than "plate"
    python benchmarks/scaling.py --picture FILE.png   draw the picture from the table
    KIRIGAMI_COMPILED=0 python benchmarks/scaling.py ...        without compiled loops
    KIRIGAMI_SOLVER=superlu python benchmarks/scaling.py ...   another solver

Squares of the same staggered slits, more of them on a larger sheet, with about 60 nodes a slit. Timed are: mesh, model,
system (lowering), tangent (assembly, pattern known), ordering (first factorisation less a later one), factorisation
(pattern known), solution of one right-hand side, linear static analysis, four eigenmodes, and the first increments of
stretching from flat (to a strain of 0.002 %, with an imperfection, in two increments at first), all in CPU seconds of
one thread, so that other work on the machine matters little. The rows go to a table next to this script, each part as
it is finished.
"""

from __future__ import annotations

import csv
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

SIZES = [2_000, 5_000, 20_000, 50_000, 100_000]
TABLE = Path(__file__).with_name("scaling.csv")
COLUMNS = (
    "mesh", "model", "system", "tangent", "residual", "ordering", "factorization", "solve", "nodes", "unknowns",
    "solver", "linear static", "four modes", "first increments", "steps", "factorizations", "largest residual",
    "peak MiB",
)  # fmt: skip
PARTS = {
    "ordering": ("ordering and plan, once", "#999999"),
    "factorization": ("one factorisation", "#0072b2"),
    "solve": ("one solution", "#56b4e9"),
    "tangent": ("one tangent", "#d55e00"),
    "linear static": ("linear static", "#009e73"),
    "four modes": ("four modes", "#cc79a7"),
    "first increments": ("first increments", "#e69f00"),
}


def slit_sheet(nodes: int) -> Any:
    """Mesh of a square with rows of staggered slits, of about the given number of nodes."""
    import numpy as np
    import shapely

    import kirigami as kg

    rows = max(2, round((nodes / 60) ** 0.5))
    pitch = 1.0 / rows
    slits = []
    for row in range(1, rows):
        for column in range(-1, rows + 1):
            left = (column + 0.15 + 0.5 * (row % 2)) * pitch
            ends = np.clip([left, left + 0.7 * pitch], 0.0, 1.0)
            if ends[1] - ends[0] > 0.1 * pitch:
                slits.append(shapely.LineString([(ends[0], row * pitch), (ends[1], row * pitch)]))
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1), slits, thickness=0.003 * pitch, material=kg.Material(E=2.5e9, nu=0.34))
    return sheet.mesh(max_edge=1.86 * nodes**-0.5)


def measure_parts(m: Any, timed: Callable[..., Any]) -> dict[str, Any]:
    """Time lowering, assembly and factorisation, and forget them again."""
    import numpy as np

    import kirigami as kg
    from kirigami.linalg import make_solver

    system = timed("system", lambda: kg.System(m))
    matrix = system.stiffness()
    u = np.zeros_like(system.rest)
    timed("tangent", lambda: system.matrix(system.stiffness_blocks(u, 0.0)), 3)
    timed("residual", lambda: system.imbalance(u, 0.0), 3)
    solver = make_solver()
    timed("ordering", lambda: solver.factorize(matrix))
    factor = timed("factorization", lambda: solver.factorize(matrix), 3)
    timed("solve", lambda: factor.solve(np.ones(system.free)), 3)
    compiled = " compiled" if any(system.twins) else ""
    return {"nodes": len(m.nodes), "unknowns": system.free, "solver": factor.backend + compiled}


def measure(nodes: int, pull: float, stiffness: str = "plate") -> dict[str, float | str]:
    """Seconds of each part for one size, stretched by `pull` at last; meant to run in a fresh process."""
    import numpy as np

    import kirigami as kg

    cost: dict[str, Any] = {}

    def timed(part: str, do: Callable[[], Any], repeats: int = 1) -> Any:
        spent, result = [], None
        for _ in range(repeats):
            result = None  # as analyses do: they let a factor go before the next is made
            start = time.process_time()
            result = do()
            spent.append(time.process_time() - start)
        cost[part] = round(min(spent), 5)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        print(f"{part}: {cost[part]} s, {peak} MiB at most so far", file=sys.stderr, flush=True)
        return result

    mesh = timed("mesh", lambda: slit_sheet(nodes))
    m = timed("model", lambda: kg.Model.from_mesh(mesh, stiffness=stiffness))
    x, y, _ = m.positions().T
    m.perturb(1e-4 * np.sin(7 * x) * np.cos(5 * y))
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="bottom")), kg.Fix(top, "xz"), kg.Prescribe(top, y=pull))
    cost |= measure_parts(m, timed)
    cost["solver"] += "" if stiffness == "plate" else f" {stiffness}"
    cost["ordering"] = round(cost["ordering"] - cost["factorization"], 5)
    for part, analysis in (
        ("linear static", kg.LinearStatic(m)),
        ("four modes", kg.Eigen(m, n=4)),
        ("first increments", kg.DisplacementControl(m, step=0.5)),
    ):
        results = timed(part, analysis.run)
        if part == "first increments":
            cost["steps"], cost["factorizations"] = len(results) - 1, results.stats["factorizations"]
            cost["largest residual"] = float(results.residual.max())
        del results
        analysis.results = None
        cost["peak MiB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        record(cost)
    return cost


def exponent(rows: list[dict[str, Any]], part: str, above: int = 4_000) -> float:
    """Exponent of growth with the number of nodes, by least squares, over the sizes of at least 4,000."""
    import numpy as np

    chosen = [row for row in rows if float(row["nodes"]) >= above and row[part]]
    if len(chosen) < 2:
        return float("nan")
    nodes, seconds = (np.log([float(row[key]) for row in chosen]) for key in ("nodes", part))
    return float(np.polyfit(nodes, seconds, 1)[0])


def draw(rows: list[dict[str, Any]], path: str) -> None:
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(
        1, 2, figsize=(8.4, 4.0), layout="constrained", gridspec_kw={"width_ratios": (2, 1)}
    )
    nodes = [float(row["nodes"]) for row in rows]
    for part, (label, color) in PARTS.items():
        name = f"{label} ({exponent(rows, part):.2f})"
        left.loglog(nodes, [float(row[part] or "nan") for row in rows], "o-", ms=4, color=color, label=name)
    left.set_xlabel("nodes")
    left.set_ylabel("CPU seconds, one thread")
    figure.legend(
        *left.get_legend_handles_labels(), fontsize=8, frameon=False, loc="outside lower center", ncols=4,
        title="in brackets: exponent of growth above 4,000 nodes", title_fontsize=8,
    )  # fmt: skip
    right.semilogx(nodes, [float(row["peak MiB"]) / 1024 for row in rows], "o-", ms=4, color="#333333")
    right.set_ylim(bottom=0)
    right.set_xlabel("nodes")
    right.set_ylabel("peak memory of the process [GiB]")
    for ax in (left, right):
        ax.set_xticks(nodes, [f"{count / 1000:.0f}k" for count in nodes])
        ax.set_xticks([], minor=True)
        ax.grid(alpha=0.3)
        ax.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=130)


def table() -> list[dict[str, Any]]:
    """The rows measured so far."""
    if not TABLE.exists():
        return []
    with TABLE.open(newline="") as file:
        return list(csv.DictReader(file))


def record(row: dict[str, Any]) -> None:
    """Put a row into the table, in place of an older one of the same size and solver."""
    kept = [old for old in table() if (old["nodes"], old["solver"]) != (str(row["nodes"]), row["solver"])]
    rows = sorted([*kept, row], key=lambda r: (r["solver"], float(r["nodes"])))
    with TABLE.open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)


def main(arguments: list[str]) -> None:
    if arguments[:1] == ["--measure"]:
        row = measure(int(arguments[1]), float(arguments[2]), arguments[3])
        print("  ".join(f"{key} {value}" for key, value in row.items()))
        return
    pull = arguments[arguments.index("--pull") + 1] if "--pull" in arguments else "2e-5"
    stiffness = arguments[arguments.index("--stiffness") + 1] if "--stiffness" in arguments else "plate"
    sizes = [int(a) for a in arguments if a.isdigit()]
    if not sizes and "--picture" not in arguments:
        sizes = SIZES
    one_thread = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS")}
    for size in sizes:
        command = [sys.executable, __file__, "--measure", str(size), pull, stiffness]
        subprocess.run(command, env={**os.environ, **one_thread}, check=False)  # a size that fails says so itself
    solvers = sorted({row["solver"] for row in table()})
    for solver in solvers:
        rows = [row for row in table() if row["solver"] == solver]
        if sum(float(row["nodes"]) >= 4_000 for row in rows) > 1:
            growth = ", ".join(f"{part} {exponent(rows, part):.2f}" for part in PARTS)
            print(f"{solver}: exponents above 4,000 nodes: {growth}")
    if "--picture" in arguments:
        draw([row for row in table() if row["solver"] == "multifrontal"], arguments[arguments.index("--picture") + 1])


if __name__ == "__main__":
    main(sys.argv[1:])
