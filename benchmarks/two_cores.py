"""What a second core gains: tangent and factorisation of a pulled sheet of shell facets on one core and on two.

    python benchmarks/two_cores.py                  # 10,000 corner nodes
    python benchmarks/two_cores.py --nodes 4000 --repeats 20

One core and two take turns in one process, and the best of each is told, so that what else the machine does meanwhile
counts less; how much that is, is told as well. BLAS has one thread throughout, as analyses leave it. Answers must
agree: the factor is the same bit by bit, and sums over facets are up to rounding.
"""

from __future__ import annotations

import argparse
import os
import time
from typing import Any

CORES = (1, 2)
PARTS = ("forces", "tangent", "factorisation", "solution")


def pulled_sheet(nodes: int) -> Any:
    """The lowered model of a slit sheet."""
    import shapely

    import kirigami as kg

    slits = kg.cuts.parallel_slits(columns=6, rows=8, width=0.1, height=0.1, length=0.014, margin=0.01)
    sheet = kg.Sheet(shapely.box(0, 0, 0.1, 0.12), slits, 1e-4, kg.Material(E=4e9, nu=0.38))
    model = kg.Model.from_mesh(sheet.mesh(nodes=nodes), stiffness="shell")
    bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(bottom, clamp=True), kg.Prescribe(top, x=0, y=1e-3, z=0, clamp=True))
    return kg.System(model)


def measure(system: Any, repeats: int) -> tuple[dict[int, dict[str, float]], dict[int, float]]:
    """Best wall seconds of each part, and the sum of the sizes of the solution, on each number of cores."""
    import numpy as np

    from kirigami.linalg import make_solver

    u = system.displacement(np.zeros(system.free), 0.1)
    solver = make_solver()  # finds the order of elimination once, as in an analysis
    best = {cores: dict.fromkeys(PARTS, np.inf) for cores in CORES}
    answers = {}
    for turn in range(repeats + 1):
        for cores in CORES:
            os.environ["OMP_NUM_THREADS"] = str(cores)  # the package asks each time
            times = [time.perf_counter()]
            forces = system.forces(u, 0.1)[0]
            times.append(time.perf_counter())
            tangent = system.matrix(system.stiffness_blocks(u, 0.1))
            times.append(time.perf_counter())
            factor = solver.factorize(tangent)
            times.append(time.perf_counter())
            solution = factor.solve(system.reduce(forces))
            times.append(time.perf_counter())
            answers[cores] = float(np.abs(solution).sum())
            del factor, tangent
            if turn:  # the first one compiles and plans
                for name, seconds in zip(PARTS, np.diff(times).tolist()):
                    best[cores][name] = min(best[cores][name], seconds)
    return best, answers


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nodes", type=int, default=10_000)
    parser.add_argument("--repeats", type=int, default=10)
    options = parser.parse_args()
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before it is loaded
    load = os.getloadavg()[0]
    system = pulled_sheet(options.nodes)
    del os.environ["OPENBLAS_NUM_THREADS"]  # which the package would take as the most that it may have
    best, answers = measure(system, options.repeats)
    print(f"{system.points} corner nodes; answers differ by {abs(answers[2] / answers[1] - 1):.1e}")
    print(f"load of the machine before {load:.1f}, after {os.getloadavg()[0]:.1f}")
    for name in (*PARTS, "all"):
        one, two = (sum(best[cores][part] for part in (PARTS if name == "all" else (name,))) for cores in CORES)
        print(f"{name:14s} {one:8.3f} s on one core, {two:8.3f} s on two: {one / two:.2f} times faster")


if __name__ == "__main__":
    main()
