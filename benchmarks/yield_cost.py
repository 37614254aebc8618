"""What yield costs: one slit sheet pulled elastically, with a yield stress that is never reached, and beyond it.

    python benchmarks/yield_cost.py [max_edge]

Processor seconds of each run, on one core, with the number of factorisations; the ratio of seconds to the elastic run
is what counts. A run that yields needs more corrections, which is part of the ratio; so it is given without them as
well, per factorisation.
"""

from __future__ import annotations

import sys
import time

import shapely

import kirigami as kg

LIMITS = {"elastic": None, "never reached": 1e12, "reached": 6e6}


def pulled(max_edge: float, rung: str, limit: float | None) -> tuple[float, kg.Results]:
    """Seconds of the processor, and the results."""
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1), shapely.LineString([(0.2, 0.5), (0.8, 0.5)]))
    material = kg.Material(E=1e9, nu=0.3, yield_stress=limit)
    m = kg.Model.from_mesh(sheet.mesh(max_edge=max_edge), thickness=3e-3, material=material, stiffness=rung)
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.Prescribe(top, x=0, y=0.03, z=0, clamp=True))
    start = time.process_time()
    results = kg.DisplacementControl(m).run()
    return time.process_time() - start, results


def main() -> None:
    max_edge = float(sys.argv[1]) if len(sys.argv) > 1 else 0.12
    for rung in ("plate", "shell"):
        pulled(0.4, rung, 6e6)  # compiles
        elastic = None
        for name, limit in LIMITS.items():
            seconds, results = min((pulled(max_edge, rung, limit) for _ in range(2)), key=lambda each: each[0])
            count = results.stats["factorizations"]
            elastic = elastic or (seconds, seconds / count)
            share = f"{100 * results.yielded[-1]:.0f} % yielded" if limit else ""
            ratios = f"ratio {seconds / elastic[0]:.2f}, per factorization {seconds / count / elastic[1]:.2f}"
            run = f"{rung:6} {len(results.rest):6} nodes {name:14} {seconds:7.2f} s {count:5} factorizations"
            print(run, ratios, share)


if __name__ == "__main__":
    main()
