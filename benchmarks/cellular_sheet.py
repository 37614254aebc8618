"""Stretch the published 2 x 5 cellular sheet (7,530 nodes) from flat to full stretch and report the cost.

    python benchmarks/cellular_sheet.py             both sets of constants
    python benchmarks/cellular_sheet.py plate       plate theory only
    python benchmarks/cellular_sheet.py scripts descent         constants of the published scripts, another corrector

Every stored step holds a relative residual of 1e-8. The last line compares with one factorisation of the first
tangent, so that runs on different machines can be put on one scale.
"""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path

import numpy as np

import kirigami as kg
from kirigami.analysis.path.descent import CORRECTORS
from kirigami.linalg import make_solver

DATA = Path(__file__).resolve().parent.parent / "tests" / "data" / "seed_S2.npz"
CONSTANTS = {"plate": "plate", "scripts": kg.Calibration(F_s=1.0, c=1 / 6)}


def cellular_sheet(constants: str) -> kg.Model:
    """The sheet with its imperfection of 0.09, gripped along bottom and top, pulled by 0.4 on 2.0."""
    with np.load(DATA) as file:
        data = {name: file[name] for name in file.files}
    m = kg.Model.from_mesh(
        kg.TriMesh(data["nodes"], data["triangles"]),
        thickness=float(data["thickness"]),
        material=kg.Material(E=float(data["modulus"]), nu=0.34),
        stiffness=CONSTANTS[constants],
    )
    m.name = f"cellular sheet, {constants} constants"
    for axis, letter in enumerate("xyz"):
        m.add(kg.Fix(m.select(index=data["fixed_dofs"][data["fixed_dofs"] % 3 == axis] // 3), letter))
    m.add(kg.Prescribe(m.select(index=data["prescribed_dofs"] // 3), y=float(data["prescribed_values_full"][0])))
    return m


def main(names: list[str]) -> None:
    corrector = next((name for name in names if name in CORRECTORS), "newton")
    for name in [name for name in names if name in CONSTANTS] or CONSTANTS:
        start, start_cpu = time.perf_counter(), time.process_time()
        m = cellular_sheet(name)
        res = kg.DisplacementControl(m, corrector=corrector).run()
        wall, cpu = time.perf_counter() - start, time.process_time() - start_cpu
        top = m.select(where=lambda x, y, z: y > 2.3)
        matrix, solver = kg.System(m).stiffness(), make_solver()
        solver.factorize(matrix)  # finds the order
        once = []
        for _ in range(5):
            begin = time.process_time()
            solver.factorize(matrix)
            once.append(time.process_time() - begin)
        print(res.summary())
        print(
            f"wall {wall:.1f} s and CPU {cpu:.1f} s with building, {len(res)} stored steps, "
            f"{res.stats['factorizations']} factorizations, largest relative residual {res.residual.max():.1e}, "
            f"top force {res.reaction(top, 'y')[-1]:.1f}, "
            f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB"
        )
        typical = np.median(once)
        print(f"one factorization {typical:.3f} s (median of 5): the run cost {cpu / typical:.0f} of them (CPU)\n")


if __name__ == "__main__":
    main(sys.argv[1:])
