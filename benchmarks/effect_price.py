"""The price of each effect: time of one tangent of a sheet with it, over that of the same sheet without it.

    python benchmarks/effect_price.py           some seconds; writes benchmarks/results/effect_price.csv

The objects are those of tools/scope.py, on the square sheet there, meshed finer. Sheet and sheet with effect are
assembled in turn, and the median ratio of their CPU times is kept; a sheet against itself, in the third row of each
rung, says what that is good to. The rungs "plate" and "shell" are measured. Then run tools/scope.py, which puts the
prices on its page.
"""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import kirigami as kg

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tools"))
RUNGS, EDGE, TIMES = ("plate", "shell"), 0.05, 9


def tangent(m: kg.Model) -> Callable[[], Any]:
    """Assembles the tangent of a model where it is slightly out of its rest state."""
    system = kg.System(m)
    u = np.zeros(system.rest.shape)
    u[: len(m.nodes), : m.dim] = 1e-3 * np.random.default_rng(1).standard_normal((len(m.nodes), m.dim))
    return lambda: system.stiffness(u, 1.0)


def seconds(call: Callable[[], Any]) -> float:
    """CPU time of a call."""
    start = time.process_time()
    call()
    return time.process_time() - start


def ratio(plain: Callable[[], Any], with_it: Callable[[], Any]) -> float:
    """Median of the ratios of two calls that are timed in turn, the first pair of which warms up."""
    pairs = [(seconds(plain), seconds(with_it)) for _ in range(TIMES + 1)][1:]
    return median(b / a for a, b in pairs)


def measured() -> list[tuple[str, str, str, str]]:
    """Rows (name, remark, rung, price)."""
    import scope

    rows = []
    for rung in RUNGS:
        m = scope.sheet(rung, edge=EDGE)
        plain = tangent(m)
        plain()
        each = 1e6 * median(seconds(plain) for _ in range(TIMES)) / len(m.nodes)
        rows.append(("the sheet:", "nodes", rung, str(len(m.nodes))))
        rows.append(("the sheet:", "microseconds a node", rung, f"{each:.0f}"))
        rows.append(("the sheet", "against itself", rung, f"{ratio(plain, tangent(scope.sheet(rung, edge=EDGE))):.2f}"))
        for name, remark, adds in scope.ADDED:
            m = scope.sheet(rung, edge=EDGE)
            try:
                m.add(adds(m))
                with_it = tangent(m)
            except kg.ModelError:  # the rung refuses it, see docs/scope.md
                continue
            rows.append((name, remark, rung, f"{ratio(plain, with_it):.2f}"))
            print(*rows[-1], flush=True)
    return rows


def main() -> None:
    rows = measured()
    with (ROOT / "benchmarks" / "results" / "effect_price.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("name", "remark", "column", "price"))
        writer.writerows(rows)


if __name__ == "__main__":
    main()
