"""Permeability of 75 sheets of curved cells, stretched: which of them lets most liquid through, and why?

The study is that of Khawale, Mehdizadeh, Brigham and Filipov, "Rapid kirigami simulation using the bar and hinge
approach". They state the five parameters, the 75 designs by Latin hypercube sampling and the formula for permeability.
They do not state the ranges, the size and thickness of the sheets, the mesh, the imperfection, the seed, nor which area
and which cut lengths enter the formula: what stands below under "our choices" is ours.

    python permeability_sweep.py           24 designs with fewer cells: a few minutes on two cores
    python permeability_sweep.py --full    75 designs with up to 326 cuts: a quarter of an hour on two cores

Interrupted runs go on where they stopped. The table is permeability_sweep.csv (or permeability_sweep_full.csv), the
figure is beside it. Designs that fail are rows of the table and listed at the end.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from scipy.stats import spearmanr
from shapely import LineString, box

import kirigami as kg
from kirigami.post.permeability import outlined_area, permeability

# ---- our choices
RANGES = {
    "cells_across": (2, 10),
    "cells_along": (5, 15),
    "length_ratio": (1.5, 4.0),  # length of a cut over the gap to the next; at 1 the cuts of a row meet
    "depth_ratio": (0.5, 2.0),  # rise of a cut over the distance to the next row
    "stretch": (0.05, 0.20),  # of the height of the pattern
}
SMALLER = RANGES | {"cells_across": (2, 4), "cells_along": (4, 7)}  # without --full
SEED = 2026
WIDTH, HEIGHT, MARGIN, GRIP, THICKNESS = 2.0, 2.0, 0.2, 0.095, 0.003  # [m]; slits have no width before stretching
MATERIAL = kg.Material(E=2.5e9, nu=0.34)
BUMP = 0.05  # height of the stress-free imperfection [m]
EDGES_PER_CUT = 4
FLOW = {"sheet": "deformed", "length": "diameter"}  # area and lengths of the stretched sheet, in projection


def stretched(stretch: float, **pattern: Any) -> kg.Results:
    """One design, stretched."""
    cuts = kg.cuts.curved_cells(width=WIDTH, height=HEIGHT, margin=MARGIN, points=EDGES_PER_CUT + 1, **pattern)
    top = HEIGHT + 2 * MARGIN
    edge = 1.2 * max(cut.length for cut in cuts) / EDGES_PER_CUT
    lines = [LineString([(0, y), (WIDTH, y)]) for y in (GRIP, top - GRIP)]
    sheet = kg.Sheet(box(0, 0, WIDTH, top), cuts, THICKNESS, MATERIAL)
    m = kg.Model.from_mesh(sheet.mesh(min(2.5 * edge, 0.4), edge, lines=lines))
    x, y, _ = m.positions().T
    m.perturb(BUMP * np.exp(-((x - WIDTH / 2) ** 2) - (y - top / 2) ** 2))
    lower, upper = m.select(box=(0, 0, WIDTH, GRIP)), m.select(box=(0, top - GRIP, WIDTH, top))
    m.add(kg.Fix(lower), kg.Fix(upper, "xz"), kg.Prescribe(upper, y=stretch * HEIGHT))
    return kg.DisplacementControl(m, targets=[RANGES["stretch"][0] / stretch]).run()


def evaluate(**design: Any) -> dict[str, float]:
    """What the table holds of one design: permeability [m^2] at its stretch, and at the smallest stretch of all."""
    res = stretched(**design)
    k, sheet_area = permeability(res, **FLOW), outlined_area(res.position(), res.mesh.triangles, res.mesh.cuts)
    least = int(np.argmin(np.abs(res.lam * design["stretch"] - RANGES["stretch"][0])))
    around = sum(np.linalg.norm(np.diff(res.rest[np.append(cut.loop, cut.loop[0])], axis=0), axis=1).sum()
                 for cut in res.mesh.cuts)  # fmt: skip
    return {
        "permeability": k[-1], "open_area": res.open_area()[-1].sum() / sheet_area[-1], "cuts": len(res.mesh.cuts),
        "cut_length": 0.5 * around / sheet_area[0],  # of all cuts, over the area of the sheet [1/m]
        "permeability_at_least_stretch": k[least], "largest_strain": np.abs(res.bar_strain[-1]).max(),
        "nodes": len(res.rest), "iterations": res.stats["iterations"],
    }  # fmt: skip


def fit(table: kg.SweepTable, scale: np.ndarray | float = 1.0) -> tuple[float, float, float]:
    """Exponent, factor and R^2 of scale * permeability = factor * open_area^exponent, fitted on logarithmic axes."""
    x, y = np.log(table["open_area"]), np.log(scale * table["permeability"])
    exponent, constant = np.polyfit(x, y, 1)
    return float(exponent), float(np.exp(constant)), float(np.corrcoef(x, y)[0, 1] ** 2)


def rank_correlation(table: kg.SweepTable, name: str) -> float:
    """Spearman's correlation of permeability with a column."""
    return float(spearmanr(table[name], table["permeability"]).statistic)


def report(table: kg.SweepTable) -> str:
    """The findings as text; failures are listed."""
    done = table.done
    equal = done["permeability_at_least_stretch"]
    ranks = ", ".join(f"{name} {rank_correlation(done, name):+.2f}" for name in ("open_area", "cuts", *RANGES))
    # Slits of width w and total length L in a sheet of area A open phi = w L / A of it, so that k = (A/L)^2 phi^3 / 12.
    exponents = [fit(done)[::2], fit(done, done["cut_length"] ** 2)[::2]]
    return "\n".join([
        table.summary(),
        "permeability ~ open area ^ {:.2f}, R^2 = {:.2f}".format(*exponents[0]),
        "permeability (cut length / sheet area)^2 ~ open area ^ {:.2f}, R^2 = {:.2f}".format(*exponents[1]),
        f"rank correlations of permeability: {ranks}",
        f"all at stretch {RANGES['stretch'][0]:g}: permeabilities span a factor of {equal.max() / equal.min():.0f}",
    ])  # fmt: skip


def pair_to_show(table: kg.SweepTable) -> tuple[dict[str, Any], dict[str, Any]]:
    """Two designs stretched alike, within 0.01, whose permeability differs most; the tighter one first."""
    rows = sorted(table.done, key=lambda row: row["permeability"])
    pairs = [(one, other) for k, one in enumerate(rows) for other in rows[k + 1 :]]
    alike = [pair for pair in pairs if abs(pair[0]["stretch"] - pair[1]["stretch"]) < 0.01] or pairs
    return max(alike, key=lambda pair: pair[1]["permeability"] / pair[0]["permeability"])


def figure(table: kg.SweepTable) -> Any:
    """Permeability over open area, number of cuts and stretch, and two of the sheets at the same stretch."""
    import matplotlib.pyplot as plt
    from matplotlib.ticker import LogLocator, NullFormatter

    done, shown = table.done, pair_to_show(table)
    stretch = float(np.mean([row["stretch"] for row in shown]))
    fig = plt.figure(figsize=(7.2, 6.6), layout="constrained")
    top, bottom = fig.subfigures(2, 1, height_ratios=(1.3, 1.0))
    for number, (ax, row) in enumerate(zip(top.subplots(1, 2), shown), start=1):
        res = stretched(**{name: row[name] for name in RANGES} | {"stretch": stretch})
        res.units = "SI"
        res.plot(ax=ax, view="top")
        ax.set_axis_off()
        ax.set_title(f"{number}:  {row['cells_across']} x {row['cells_along']} cells at {100 * stretch:.0f} %, "
                     f"k = {1e6 * permeability(res, **FLOW)[-1]:.3g} mm$^2$", fontsize=9)  # fmt: skip
    axes = bottom.subplots(1, 3, sharey=True)
    k = 1e6 * done["permeability"]
    labels = {"open_area": "open area / sheet area", "cuts": "number of cuts", "stretch": "stretch"}
    for ax, (name, label) in zip(axes, labels.items()):
        points = ax.scatter(done[name], k, c=done["open_area"], s=14, cmap="viridis")
        ax.set(xscale="linear" if name == "stretch" else "log", yscale="log", xlabel=label)
        for axis in (ax.xaxis, ax.yaxis)[name == "stretch" :]:
            axis.set_major_locator(LogLocator(subs=(1, 2, 3, 5)))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
        ax.set_title(f"rank correlation {rank_correlation(done, name):+.2f}", fontsize=9)
        for number, row in enumerate(shown, start=1):
            at = row[name], 1e6 * row["permeability"]
            offset, side = ((5, -12), "left") if number == 1 else ((-5, 4), "right")
            ax.annotate(str(number), at, offset, ha=side, textcoords="offset points")
            ax.plot(*at, "o", ms=8, mfc="none", mec="k", mew=0.8)
    exponent, _, r2 = fit(done)
    ends = np.array([done["open_area"].min(), done["open_area"].max()])
    x, y = np.log(done["open_area"]), np.log(k)
    axes[0].plot(ends, np.exp(y.mean()) * (ends / np.exp(x.mean())) ** 3, "k-", lw=0.8, label="slope 3")
    axes[0].plot(ends, np.exp(y.mean()) * (ends / np.exp(x.mean())) ** exponent, "k--", lw=0.8,
                 label=f"slope {exponent:.2f}, $R^2$ = {r2:.2f}")  # fmt: skip
    exponent, _, r2 = fit(done, done["cut_length"] ** 2)
    axes[0].plot([], [], " ", label=f"k (cut length / area)$^2$:\nslope {exponent:.2f}, $R^2$ = {r2:.2f}")
    axes[0].legend(fontsize=7, frameon=False, loc="upper left", handlelength=1.5)
    axes[0].set(ylabel="permeability k [mm$^2$]", ylim=(0.7 * k.min(), 12 * k.max()))
    bottom.colorbar(points, ax=axes, label="open area / sheet area", pad=0.01)
    return fig


def sweep(n: int, ranges: dict[str, Any], path: str, **options: Any) -> kg.SweepTable:
    """The table of n designs."""
    return kg.Sweep(evaluate, kg.latin_hypercube(ranges, n, seed=SEED), path).run(**options)


if __name__ == "__main__":
    if "--full" in sys.argv:
        name, found = "permeability_sweep_full", sweep(75, RANGES, "permeability_sweep_full", progress=True)
    else:
        name, found = "permeability_sweep", sweep(24, SMALLER, "permeability_sweep", progress=True)
    if found.missing:
        sys.exit(found.summary())
    print(report(found))
    figure(found).savefig(f"{name}.png", dpi=150)
