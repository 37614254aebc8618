"""A ribbon that bears about 1.6 N between 50 and 62 % of its pull: the lengths of its slits are searched for.

Five rows of slits over a strip, with one length for those in the middle and one for those from the sides. Wanted is
the same force at three places of that range. Long slits make the force flat, and no lengths make it flat altogether: it
grows by some 3 % over the range, and by 15 % over the whole second half. The answer is walked from flat on a finer
mesh, and written as a drawing and a case file, with which the command line does the pull again, from the drawing alone:

    python examples/flat_force_ribbon.py folder
    kirigami stretch folder/case.json

It takes about a minute.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import shapely

import kirigami as kg

WIDTH, HEIGHT, STRAIN = 0.06, 0.1, 0.06  # m
AT = [0.5, 0.56, 0.62]  # shares of the pull
PLATEAU = 1.6  # N
FORCE = ("force", "driven_0", "y")


def cuts(ends: float, middle: float) -> list[shapely.LineString]:
    """Rows of slits in the middle of the strip, and from both sides between them; shares of the width."""
    lines = []
    for number, share in enumerate((ends, middle, ends, middle, ends)):
        y, half = 0.02 + 0.015 * number, 0.5 * share * WIDTH
        if number % 2 == 0:
            lines.append([(0.5 * WIDTH - half, y), (0.5 * WIDTH + half, y)])
        else:
            lines += [[(0, y), (half, y)], [(WIDTH - half, y), (WIDTH, y)]]
    return [shapely.LineString(line) for line in lines]


def ribbon() -> kg.Design:
    """The ribbon to start from."""
    return kg.Design(
        cuts, outline=shapely.box(0, 0, WIDTH, HEIGHT), thickness=2e-4,
        supports=kg.LoadCase(strain=STRAIN),
        material=kg.Material(3.5e9, 0.34), mesh={"max_edge": 0.012, "cut_edge": 0.01},
        ends=(0.75, 0.5, 0.92), middle=(0.75, 0.5, 0.92),
    )  # fmt: skip


def main(folder: Path) -> kg.InverseResult:
    """Find the lengths, write drawing, case and picture, and do the pull again, from the drawing alone."""
    start = ribbon()
    print("forces of the start [N]:", forces(start.walk(AT)).round(3))
    problem = kg.Inverse(start, (FORCE, AT, PLATEAU), evaluations=15, enough=0.02, path=folder / "ribbon.json")
    found = problem.run(progress=True)
    print(found.summary())
    print("forces of the answer on the finer mesh [N]:", np.round(found.reached, 3))
    res = kg.study.Job.load(found.design.export(folder)).run().results
    again = forces(res)
    found.plot(res).savefig(folder / "ribbon.png", dpi=120)
    off = float(np.abs(again / PLATEAU - 1).max())
    print("pulled from the drawing [N]:", again.round(3))
    print(f"the run of the drawing is within {100 * off:.2g} % of it")
    return found


def forces(res: kg.Results) -> np.ndarray:
    """Forces at the places asked for [N], in between stored steps where these lie there."""
    return np.interp(AT, res.lam, res.reaction("driven_0", "y"))


if __name__ == "__main__":
    where = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    where.mkdir(parents=True, exist_ok=True)
    main(where)
