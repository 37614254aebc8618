"""What the plane saves: time per step of the same panels with two and with three unknowns a node.

The panels of a square-rhombus lattice, joined by ligaments, are meshed once. The mesh becomes a planar model (bars) and
a model in space (bars and hinges, started with a slight bump), and the coarse model of bars and angle springs is put
beside them. All are stretched by the same steps; times are of this run on this machine, so only their ratios mean
something.

    python benchmarks/planar_cost.py [columns] [rows]
"""

from __future__ import annotations

import math
import sys
import time

import numpy as np

import kirigami as kg
from kirigami import tilings

SIDE, WIDTH, LENGTH, THICKNESS = 6.75e-3, 0.6e-3, 1.5e-3, 1e-3
MATERIAL = kg.Material(E=3.5e9, nu=1 / 3)


def models(columns: int, rows: int) -> dict[str, kg.Model]:
    """The coarse planar, the meshed planar and the meshed spatial model, gripped left and right."""
    piece = tilings.square_rhombus(math.pi / 16, SIDE).patch(columns, rows)
    sheet = kg.Sheet(tilings.ligament_sheet(piece, WIDTH, LENGTH), thickness=THICKNESS, material=MATERIAL)
    mesh = sheet.mesh(max_edge=1.2e-3)
    ligament = tilings.Ligament(MATERIAL.E, THICKNESS, WIDTH, LENGTH)
    found = {
        "panels in the plane": piece.model(EA=MATERIAL.E * THICKNESS * SIDE / 2, stiffness=ligament),
        "mesh in the plane": kg.Model.from_mesh(mesh, dim=2),
        "mesh in space": kg.Model.from_mesh(mesh, dim=3),
    }
    bump = found["mesh in space"].positions()
    middle, spread = bump.mean(axis=0), np.ptp(bump, axis=0).max()
    found["mesh in space"].perturb(np.exp(-(((bump - middle) / spread) ** 2).sum(axis=1)), amplitude=1e-3 * SIDE)
    for model in found.values():
        x = model.positions()[:, 0]
        grip = 0.6 * SIDE
        sides = x < x.min() + grip, x > x.max() - grip
        left, right = ([model.nodes[k] for k in np.flatnonzero(side)] for side in sides)
        model.add(kg.Fix(left), kg.Fix(right, "yz"[: model.dim - 1]), kg.Prescribe(right, x=0.01 * float(np.ptp(x))))
    return found


def main(columns: int = 6, rows: int = 4) -> dict[str, float]:
    """Seconds per corrector iteration (one assembly, one factorisation, two solves) of each model."""
    cost: dict[str, float] = {}
    for name, model in models(columns, rows).items():
        begin = time.perf_counter()
        results = kg.DisplacementControl(model, targets=[0.25, 0.5, 0.75, 1.0], step=0.25).run(on_failure="return")
        seconds = time.perf_counter() - begin
        cost[name] = seconds / max(results.stats["factorizations"], 1)
        system = kg.System(model)
        print(
            f"{name:20s} {len(model.nodes):6d} nodes {system.free:7d} unknowns, "
            f"{results.stats['factorizations']:4d} factorisations of {1e3 * cost[name]:8.2f} ms, "
            f"{1e3 * seconds / len(results):8.1f} ms a step, kernels "
            + ", ".join(sorted({kernel.name for kernel in system.kernels}))
        )
    base = cost["mesh in space"]
    for name, value in cost.items():
        print(f"{name}: {base / value:.1f} times as fast as the mesh in space")
    return cost


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:3]))
