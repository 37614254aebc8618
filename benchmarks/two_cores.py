"""What a second core gains: tangent and factorisation of a pulled sheet of shell facets on one core and on two.

    python benchmarks/two_cores.py                  # 10,000 corner nodes
    python benchmarks/two_cores.py --nodes 4000

Each number of cores has a process of its own, since threads of BLAS are counted when it is loaded. Wall seconds mean
something on a quiet machine only; the best of some repetitions is told. Answers must agree: the factor is the same bit
by bit, and sums over facets are up to rounding.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time


def measure(nodes: int, repeats: int) -> dict[str, float]:
    """Best wall seconds of each part on the cores that the environment allows."""
    import numpy as np
    import shapely

    import kirigami as kg
    from kirigami.linalg import make_solver

    slits = kg.cuts.parallel_slits(columns=6, rows=8, width=0.1, height=0.1, length=0.014, margin=0.01)
    sheet = kg.Sheet(shapely.box(0, 0, 0.1, 0.12), slits, 1e-4, kg.Material(E=4e9, nu=0.38))
    model = kg.Model.from_mesh(sheet.mesh(nodes=nodes), stiffness="shell")
    bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(bottom, clamp=True), kg.Prescribe(top, x=0, y=1e-3, z=0, clamp=True))
    system = kg.System(model)
    u = system.displacement(np.zeros(system.free), 0.1)
    solver = make_solver()  # finds the order of elimination once, as in an analysis
    best = dict.fromkeys(("forces", "tangent", "factorisation", "solution"), np.inf)
    for _ in range(repeats + 1):  # the first one compiles and plans
        times = [time.perf_counter()]
        forces = system.forces(u, 0.1)[0]
        times.append(time.perf_counter())
        tangent = system.matrix(system.stiffness_blocks(u, 0.1))
        times.append(time.perf_counter())
        factor = solver.factorize(tangent)
        times.append(time.perf_counter())
        solution = factor.solve(system.reduce(forces))
        times.append(time.perf_counter())
        best = {name: min(best[name], seconds) for name, seconds in zip(best, np.diff(times).tolist())}
    return best | {"nodes": len(model.nodes), "answer": float(np.abs(solution).sum())}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nodes", type=int, default=10_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--alone", action="store_true", help="measure here and print JSON")
    options = parser.parse_args()
    if options.alone:
        print(json.dumps(measure(options.nodes, options.repeats)))
        return
    found = {}
    for cores in (1, 2):
        environment = os.environ | {"OMP_NUM_THREADS": str(cores), "OPENBLAS_NUM_THREADS": str(cores)}
        numbers = ["--nodes", str(options.nodes), "--repeats", str(options.repeats)]
        command = [sys.executable, __file__, "--alone", *numbers]
        found[cores] = json.loads(subprocess.run(command, env=environment, capture_output=True, check=True).stdout)
    one, two = found[1], found[2]
    print(f"{one['nodes']} corner nodes; answers differ by {abs(two['answer'] / one['answer'] - 1):.1e}")
    parts = ("forces", "tangent", "factorisation", "solution")
    for name in (*parts, "all"):
        before, after = (sum(run[part] for part in (parts if name == "all" else (name,))) for run in (one, two))
        print(f"{name:14s} {before:8.3f} s on one core, {after:8.3f} s on two: {before / after:.2f} times faster")


if __name__ == "__main__":
    main()
