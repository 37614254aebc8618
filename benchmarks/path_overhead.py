"""What a path run spends beside factorising and solving: a slit sheet, ten increments and more, seconds per part.

    python benchmarks/path_overhead.py [nodes] [solver ...]      9000 (the mesh has 9,649), the default solver

The ratio that counts is wall time of the run over the time in factorisations and solutions. With Numba installed, bars
and hinges are assembled by compiled loops; KIRIGAMI_COMPILED=0 turns them off, to compare.
"""

from __future__ import annotations

import os
import sys

import numpy as np
from scaling import slit_sheet

import kirigami as kg


def main(arguments: list[str]) -> None:
    nodes = int(arguments[0]) if arguments else 9_000
    mesh = slit_sheet(nodes)
    for solver in arguments[1:] or ["multifrontal"]:
        os.environ["KIRIGAMI_SOLVER"] = solver
        m = kg.Model.from_mesh(mesh)
        x, y, _ = m.positions().T
        m.perturb(1e-4 * np.sin(7 * x) * np.cos(5 * y))
        top = m.select(boundary="top")
        m.add(kg.Fix(m.select(boundary="bottom")), kg.Fix(top, "xz"), kg.Prescribe(top, y=1e-4))
        system, still = kg.System(m), 0.0 * m.positions()
        # Compiles the loops, or loads them: once per machine.
        system.stiffness_blocks(still, 0.0, kg.Tangent(ahead=(still, still)))
        system.largest_rotation(still)
        system.stiffness()
        system.forces(still, 0.0)
        res = kg.DisplacementControl(m, step=0.1, corrector="newton").run()  # the same work in every version
        seconds = dict(res.stats["seconds"])
        total = seconds.pop("total")
        counted = res.stats["factorizations"]
        print(f"{len(m.nodes)} nodes, {res.stats['backend']}, {len(res) - 1} steps, {counted} factorizations")
        for part, spent in sorted(seconds.items(), key=lambda item: -item[1]):
            print(f"  {part:22s} {spent:8.3f} s")
        print(f"  {'not counted':22s} {total - sum(seconds.values()):8.3f} s")
        work = seconds["factorization"] + seconds["solve"]
        print(f"  total {total:.3f} s = {total / work:.2f} times factorisation and solution ({work:.3f} s)")


if __name__ == "__main__":
    main(sys.argv[1:])
