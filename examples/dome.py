"""A disc that lifts to a given dome: the lengths of the arcs cut into it are searched for.

Three rings of three arcs each in a disc whose rim is held; its middle is lifted by 12 mm. With alike arcs the disc
becomes a cone that is hollow outside; wanted is a dome, z = 12 mm (1 - (r / 45 mm)^1.4), between the rings. The answer
is walked from flat on a finer mesh, and written as a drawing and a case file, with which the command line does the lift
again, from the drawing alone:

    python examples/dome.py folder
    kirigami stretch folder/case.json

It takes about two minutes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import shapely
from scipy.interpolate import LinearNDInterpolator

import kirigami as kg

RADIUS, LIFT, ARCS = 0.05, 0.012, 3  # m
RINGS = (0.016, 0.027, 0.038)
AT = np.array([0.0215, 0.0325])  # radii between the rings [m]
DOME = LIFT * (1 - (AT / 0.045) ** 1.4)


def circle(radius: float, start: float, end: float, count: int) -> np.ndarray:
    """Points (count, 2) of an arc; angles in radians."""
    angle = np.linspace(start, end, count)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def cuts(inner: float, middle: float, outer: float) -> list[shapely.LineString]:
    """Arcs of each ring, staggered; shares of the third of a turn that each may take."""
    arcs = []
    for ring, (radius, share) in enumerate(zip(RINGS, (inner, middle, outer))):
        for number in range(ARCS):
            centre = 2 * np.pi * (number + 0.5 * (ring % 2)) / ARCS + 0.5 * np.pi
            half = share * np.pi / ARCS
            arcs.append(shapely.LineString(circle(radius, centre - half, centre + half, 9)))
    return arcs


def disc() -> kg.Design:
    """The disc to start from."""
    return kg.Design(
        cuts, outline=shapely.Polygon(circle(RADIUS, 0, 2 * np.pi, 25)[:-1]), thickness=3e-4,
        supports=kg.LoadCase(lift={"0,0,0.006": LIFT}, hold="rim"), material=kg.Material(3.5e9, 0.34),
        mesh={"max_edge": 0.014, "cut_edge": 0.01}, inner=(0.5, 0.3, 0.85), middle=(0.65, 0.3, 0.85),
        outer=(0.8, 0.3, 0.9),
    )  # fmt: skip


def points() -> np.ndarray:
    """Where the dome is asked for, half way from a neck to the next."""
    return AT[:, None] * circle(1.0, 2 * np.pi / 3, 2 * np.pi / 3, 1)


def main(folder: Path) -> kg.InverseResult:
    """Find the lengths, write drawing, case and picture, and do the lift again, from the drawing alone."""
    targets = [(("point", tuple(at), "z"), 1.0, height, LIFT) for at, height in zip(points().tolist(), DOME)]
    found = kg.Inverse(disc(), targets, evaluations=15, enough=5e-3, path=folder / "dome.json").run(progress=True)
    print(found.summary())
    res = kg.study.Job.load(found.design.export(folder)).run().results
    assert res.mesh is not None
    found.plot(res).savefig(folder / "dome.png", dpi=120)
    reached = LinearNDInterpolator(res.mesh.nodes[:, :2], res.position()[-1, :, 2])(points())
    off = float(np.abs(reached - DOME).max() / LIFT)
    print("wanted [mm]:", (1e3 * DOME).round(3), " lifted from the drawing [mm]:", (1e3 * reached).round(3))
    print(f"the run of the drawing is within {100 * off:.2g} % of the lift")
    return found


if __name__ == "__main__":
    where = Path(sys.argv[1] if len(sys.argv) > 1 else "dome")
    where.mkdir(parents=True, exist_ok=True)
    main(where)
