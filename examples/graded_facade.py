"""A facade whose openings follow a curve from the ground to the roof: the lengths of its slits are searched for.

Five rows of slits across a panel that is pulled. Wanted is how much each row opens: a little at the ground, the most at
the top. The five lengths are searched for. The answer is walked from flat on a finer mesh, and written as a drawing and
a case file, with which the command line does the pull again, from the drawing alone:

    python examples/graded_facade.py folder
    kirigami stretch folder/case.json

It takes about a minute.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import shapely

import kirigami as kg

WIDTH, HEIGHT = 0.08, 0.1  # m
ROWS = (0.02, 0.035, 0.05, 0.065, 0.08)
OPEN = (1.6e-5, 3.1e-5, 4.6e-5, 6.2e-5, 7.7e-5)  # m^2, of each row


def cuts(first: float, second: float, third: float, fourth: float, fifth: float) -> list[shapely.LineString]:
    """A slit for each row; shares of the width."""
    return [
        shapely.LineString([(0.5 * (1 - share) * WIDTH, y), (0.5 * (1 + share) * WIDTH, y)])
        for share, y in zip((first, second, third, fourth, fifth), ROWS)
    ]


def panel() -> kg.Design:
    """The panel to start from, pulled by 4 %."""
    return kg.Design(
        cuts, outline=shapely.box(0, 0, WIDTH, HEIGHT), supports=kg.LoadCase(strain=0.04), thickness=3e-4,
        material=kg.Material(3.5e9, 0.34), mesh={"max_edge": 0.011, "cut_edge": 0.007},
        first=(0.7, 0.4, 0.9), second=(0.7, 0.4, 0.9), third=(0.7, 0.4, 0.9), fourth=(0.7, 0.4, 0.9),
        fifth=(0.7, 0.4, 0.9),
    )  # fmt: skip


def main(folder: Path) -> kg.InverseResult:
    """Find the lengths, write drawing, case and picture, and do the pull again, from the drawing alone."""
    targets = [(("open_area", [row]), 1.0, area, max(OPEN)) for row, area in enumerate(OPEN)]
    found = kg.Inverse(panel(), targets, evaluations=15, enough=5e-3, path=folder / "facade.json").run(progress=True)
    print(found.summary())
    res = kg.study.Job.load(found.design.export(folder)).run().results
    reached = np.sort(res.open_area()[-1])  # a reader may order cuts anew
    found.plot(res).savefig(folder / "facade.png", dpi=120)
    off = float(np.abs(reached - OPEN).max() / max(OPEN))
    print("wanted [mm2]:", np.multiply(OPEN, 1e6), " pulled from the drawing [mm2]:", (1e6 * reached).round(1))
    print(f"the run of the drawing is within {100 * off:.2g} % of the largest opening")
    return found


if __name__ == "__main__":
    where = Path(sys.argv[1] if len(sys.argv) > 1 else "facade")
    where.mkdir(parents=True, exist_ok=True)
    main(where)
