"""Which imperfection opens a disc in which way: every mode, both signs, three amplitudes.

The disc of Fig. 4d of Khawale, Mehdizadeh, Brigham, Filipov, "Rapid Kirigami Simulation using the Bar & Hinge
Approach": radius 3, one cut of 2.58 by 0.1 through the middle, pulled across the cut to a strain of 0.02. The paper
seeds eigenmodes of the initial geometry, only in z, up to a hundredth of the radius, and tells that two of them lead to
shapes of their own while most lead to the intended one. What the paper does not say, and what is chosen:

* modes: the first six of the flat disc on its supports that move out of the plane; each with both signs;
* amplitudes: 1e-2, 1e-3 and 1e-4 of the radius;
* supports: as in examples/single_cut_disc.py, arcs of half-width 0.25 at both ends, held in x and z, free to turn;
* thickness 0.003, E = 760000, nu = 0.34 (the published script), "plate" constants.

    python examples/imperfection_study.py           a mesh of 0.35
    python examples/imperfection_study.py --full    a mesh of 0.2, in two processes
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import shapely

import kirigami as kg

RADIUS, LENGTH, OPENING, GRIP, STRAIN = 3.0, 2.58, 0.1, 0.25, 0.02
THICKNESS, MATERIAL = 0.003, kg.Material(E=760000, nu=0.34)
AMPLITUDES = (1e-2 * RADIUS, 1e-3 * RADIUS, 1e-4 * RADIUS)
PULL = partial(kg.DisplacementControl, step=0.01)


def flat_disc(max_edge: float) -> kg.Model:
    """The disc without imperfection, pulled to the final strain at load factor 1."""
    corner = np.arccos(GRIP / RADIUS)  # the grips end in corners of the outline, whatever the mesh
    free = int(np.ceil(2 * corner * RADIUS / max_edge))
    half = np.concatenate([np.linspace(-corner, corner, free + 1), np.linspace(corner, np.pi - corner, 6)[1:-1]])
    angle = np.concatenate([half, half + np.pi])
    outline = shapely.Polygon(RADIUS * np.column_stack([np.cos(angle), np.sin(angle)]))
    cut = shapely.box(-LENGTH / 2, -OPENING / 2, LENGTH / 2, OPENING / 2)
    m = kg.Model.from_mesh(kg.Sheet(outline, cut).mesh(max_edge), THICKNESS, MATERIAL)
    upper = m.select(boundary="outer", where=lambda x, y, z: (np.abs(x) < GRIP + 1e-9) & (y > 0))
    lower = m.select(boundary="outer", where=lambda x, y, z: (np.abs(x) < GRIP + 1e-9) & (y < 0))
    m.add(kg.Fix([*upper, *lower], "xz"))
    m.add(kg.Prescribe(upper, y=STRAIN * RADIUS), kg.Prescribe(lower, y=-STRAIN * RADIUS))
    return m


def mirror_error(study: kg.study.ImperfectionStudy) -> float:
    """Largest difference between the heights of a run and those of its mirror image, over the largest height."""
    worst = 0.0
    for one, case in enumerate(study.cases):
        for other, opposite in enumerate(study.cases):
            same = (case.mode, case.amplitude) == (opposite.mode, opposite.amplitude)
            if same and case.sign == 1 and opposite.sign == -1 and case.done and opposite.done:
                up, down = (study.results[k].position()[-1][:, 2] for k in (one, other))
                worst = max(worst, float(np.abs(up + down).max() / np.abs(up).max()))
    return worst


def force_spread(study: kg.study.ImperfectionStudy) -> float:
    """Largest relative spread of the final force among the runs of one branch."""
    spreads = []
    for cases in study.branches.values():
        force = np.array([case.force for case in cases])
        spreads.append(float(np.ptp(force) / np.abs(force).max()))
    return max(spreads)


def lowest(study: kg.study.ImperfectionStudy) -> dict[float, int]:
    """The branch of lowest energy that each amplitude leads to."""
    sizes = sorted({case.amplitude for case in study.cases}, reverse=True)
    return {size: min(c.branch for c in study.cases if c.amplitude == size and c.branch) for size in sizes}


def main(
    pictures: bool = False,
    max_edge: float = 0.35,
    modes: int = 6,
    amplitudes: Sequence[float] = AMPLITUDES,
    folder: str | Path | None = None,
    executor: Executor | None = None,
) -> kg.study.ImperfectionStudy:
    """The study; with pictures it is told and drawn."""
    study = kg.study.imperfections(
        flat_disc(max_edge), modes, amplitudes, PULL, folder=folder, executor=executor
    )
    if pictures:
        print(f"{len(study.model.nodes)} nodes, {sum(case.factorizations for case in study.cases)} factorizations")
        print(study)
        for number, cases in study.branches.items():
            scaled = cases[-1].force / (2 * STRAIN * RADIUS) * RADIUS / (MATERIAL.E * THICKNESS**3)
            print(f"branch {number}: F R / (E t^3) = {scaled:.1f}, height {cases[-1].height:.3f}")
        print(f"mirror images differ by {mirror_error(study):.1e} of the height")
        print(f"forces on one branch differ by at most {100 * force_spread(study):.2f} %")
        print("branch of lowest energy by amplitude:", {f"{size:g}": branch for size, branch in lowest(study).items()})
        study.table("imperfection_study.csv")
        study.plot().savefig("imperfection_study.png")
    return study


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--full", action="store_true", help="the finer mesh, in two processes")
    if parser.parse_args().full:
        with ProcessPoolExecutor(2) as pool:
            main(True, 0.2, folder="imperfection_study_full", executor=pool)
    else:
        main(True)
