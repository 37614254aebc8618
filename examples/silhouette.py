"""A strip that narrows to a given silhouette when it is pulled: the lengths of its slits are searched for.

Five slits across a strip; where a slit is long, the strip draws in. Wanted is how far the left side comes in at three
heights, as of a vase upside down; three lengths, the same above and below the middle, are searched for. The answer is
walked from flat on a finer mesh, and written as a drawing and a case file, with which the command line does the pull
again, from the drawing alone:

    python examples/silhouette.py folder
    kirigami stretch folder/case.json

It takes about a minute.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import shapely
from scipy.interpolate import LinearNDInterpolator

import kirigami as kg

WIDTH, HEIGHT = 0.08, 0.1  # m
ROWS = (0.02, 0.035, 0.05, 0.065, 0.08)
AT = (0.0125, 0.0275, 0.0425)  # heights, between the rows
INWARD = (0.0003, 0.0007, 0.001)  # m


def cuts(ends: float, between: float, middle: float) -> list[shapely.LineString]:
    """A slit for each row; shares of the width."""
    return [
        shapely.LineString([(0.5 * (1 - share) * WIDTH, y), (0.5 * (1 + share) * WIDTH, y)])
        for share, y in zip((ends, between, middle, between, ends), ROWS)
    ]


def strip() -> kg.Design:
    """The strip to start from, pulled by 4 %."""
    return kg.Design(
        cuts, outline=shapely.box(0, 0, WIDTH, HEIGHT), supports=kg.LoadCase(strain=0.04), thickness=3e-4,
        material=kg.Material(3.5e9, 0.34), mesh={"max_edge": 0.014, "cut_edge": 0.01},
        ends=(0.75, 0.4, 0.9), between=(0.75, 0.4, 0.9), middle=(0.75, 0.4, 0.9),
    )  # fmt: skip


def silhouette(res: kg.Results) -> np.ndarray:
    """Where the left side is at the end, at the heights asked for [m]."""
    assert res.mesh is not None
    across = LinearNDInterpolator(res.mesh.nodes[:, :2], res.position()[-1, :, 0])
    return np.array([float(across(1e-9, y)) for y in AT])


def main(folder: Path) -> kg.InverseResult:
    """Find the lengths, write drawing, case and picture, and do the pull again, from the drawing alone."""
    targets = [(("point", (0.0, y), "x"), 1.0, inward, max(INWARD)) for y, inward in zip(AT, INWARD)]
    found = kg.Inverse(strip(), targets, evaluations=15, enough=5e-3, path=folder / "silhouette.json").run(True)
    print(found.summary())
    res = kg.study.Job.load(found.design.export(folder)).run().results
    reached = silhouette(res)
    found.plot(res).savefig(folder / "silhouette.png", dpi=120)
    off = float(np.abs(reached - INWARD).max() / max(INWARD))
    print("wanted [mm]:", np.multiply(INWARD, 1e3), " pulled from the drawing [mm]:", (1e3 * reached).round(3))
    print(f"the run of the drawing is within {100 * off:.2g} % of the largest")
    return found


if __name__ == "__main__":
    where = Path(sys.argv[1] if len(sys.argv) > 1 else "silhouette")
    where.mkdir(parents=True, exist_ok=True)
    main(where)
