"""What accuracy costs in time: the curved-cell sheet at several mesh sizes against a shell finite element model.

    python benchmarks/accuracy_and_time.py [picture.png]

The shell curves (corotational triangles with rotations, 9,016 and 4,614 nodes) were computed with Kratos Multiphysics
10.4.4 for the same sheet, cuts 5 mm wide, grips and imperfection; the finer one is about 1 % too stiff. Sheets of this
kind have many stable shapes, and different meshes may settle on different ones: that scatter is part of the error.
CPU seconds, one thread each; the shell's are from a like machine.
"""

from __future__ import annotations

import sys
import time

import numpy as np
import shapely

import kirigami as kg

LOAD_FACTORS = [0.05, 0.25, 0.5, 0.75, 1.0]
SHELL_FORCE = np.array([363.6, 484.7, 582.7, 692.0, 832.5]) / 1.01  # N, reduced by its remaining error
SHELL_AREA = np.array([0.10481, 0.31899, 0.57220, 0.80882, 1.02774])  # m2, the 16 inner cuts
SHELL_POINTS = {"shell, 9,016 nodes": (305.0, 0.01, 0.002), "shell, 4,614 nodes": (136.0, 0.02, 0.003)}
SIZES = [0.2, 0.13, 0.09, 0.065]


def errors(max_edge: float) -> tuple[int, float, float, float]:
    """Nodes, CPU seconds, and root mean square relative errors of force and open area over the stretch."""
    start = time.process_time()
    cuts = kg.cuts.curved_cells(cells_across=2, cells_along=5, opening=0.005)
    grips = {"bottom grip": shapely.LineString([(0, 0.095), (2, 0.095)]),
             "top grip": shapely.LineString([(0, 2.305), (2, 2.305)])}  # fmt: skip
    mesh = kg.Sheet(shapely.box(0, 0, 2, 2.4), cuts).mesh(max_edge, cut_edge=0.5 * max_edge, lines=grips)
    m = kg.Model.from_mesh(mesh, thickness=0.003, material=kg.Material(E=2.5e9, nu=0.34))
    x, y, _ = m.positions().T
    m.perturb(0.05 * np.exp(-((x - 1) ** 2) - (y - 1.2) ** 2))
    bottom, top = m.select(where=lambda x, y, z: y < 0.0951), m.select(where=lambda x, y, z: y > 2.3049)
    m.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=0.4))
    res = kg.DisplacementControl(m, targets=LOAD_FACTORS).run()
    at = [int(np.flatnonzero(res.lam == lam)[0]) for lam in LOAD_FACTORS]
    inner = [k for k, cut in enumerate(mesh.cuts) if not cut.open]
    force = res.reaction(top, "y")[at] / SHELL_FORCE - 1
    area = res.open_area()[at][:, inner].sum(axis=1) / SHELL_AREA - 1
    spent = time.process_time() - start
    count = res.stats["factorizations"]
    print(f"max_edge {max_edge:.3f}: {len(m.nodes)} nodes, {spent:.1f} s, {count} factorizations")
    print("   force     " + "  ".join(f"{100 * e:+6.1f} %" for e in force))
    print("   open area " + "  ".join(f"{100 * e:+6.1f} %" for e in area), flush=True)
    return len(m.nodes), spent, float(np.sqrt(np.mean(force**2))), float(np.sqrt(np.mean(area**2)))


def main(picture: str | None = None) -> None:
    rows = np.array([errors(size) for size in SIZES])
    if picture is None:
        return
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(figsize=(6, 3.6), layout="constrained")
    for column, name, color in ((2, "force", "#0072b2"), (3, "open area", "#d55e00")):
        ax.loglog(rows[:, 1], 100 * rows[:, column], "o-", color=color, label=f"bars and hinges: {name}")
        points = np.array([(cpu, 100 * error[column - 2]) for cpu, *error in SHELL_POINTS.values()])
        ax.loglog(points[:, 0], points[:, 1], "s", mfc="none", color=color, label=f"shell elements: {name}")
    for nodes, seconds, force, _ in rows:
        label = f"{nodes:,.0f} nodes"
        ax.annotate(label, (seconds, 100 * force), textcoords="offset points", xytext=(2, 6), fontsize=8, rotation=35)
    ax.set_ylim(0.1, 40)
    ax.set_xlabel("CPU seconds, one thread")
    ax.set_ylabel("error over the stretch [%]")
    ax.legend(fontsize=8, frameon=False, loc="lower left")
    ax.spines[["top", "right"]].set_visible(False)
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    main(*sys.argv[1:2])
