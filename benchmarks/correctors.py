"""What it costs to carry thin cut sheets from flat to 20 % stretch, by corrector.

    python benchmarks/correctors.py                              every sheet, imperfection and corrector not yet done
    python benchmarks/correctors.py --sheet ring cells --corrector newton --imperfection 1e-3
    python benchmarks/correctors.py --thin                       second part: other thicknesses, to 40 %
    python benchmarks/correctors.py --table                      print the table of what is done

Eight sheets of unit size that differ in kind, t/L = 1e-3, at least 2,000 nodes, imperfection in the first eigenmode. A
run succeeds at the full strain, or where the sheet locks: where stretching stores more than half of the energy after
bending had stored more. It ends in failure after 1,500 factorisations or 300 CPU seconds. Every factorisation counts,
also those of rejected attempts, of located events and of the test for stability; only the factors of places that
settle by themselves (kirigami/analysis/path/places.py) are not, a hundredth to a tenth of the work each, which the
seconds contain. Correctors were tuned on four of the sheets (TUNING) and left alone on the other four. Rows are
appended to benchmarks/results/correctors.csv, so the comparison can be interrupted and goes on where it was.

What is compared: "path", the default (along the stable path in increments of at most a quarter of the distance from
the start, and downhill from close by where it is lost), "newton" (mixed-stress Newton at shorter and shorter
increments, then a descent with slowly changed fading), "descent" (downhill at once, compression faded out of an
indefinite tangent, chord steps with the old factor, increments that do not shrink), "viscous" (the same with a mass
shift instead of the fading: implicit pseudo-time).

What was tried in the tuning of the descent, as factorisations of staggered slits at imperfection 1e-3 until lock:

* fading changed slowly (growth 3, decay 1.5) 489, and with a monotone energy line search 484: line searches stop at
  the false stretch of a rotation, which the mixed stress forgives, so steps become short and more of them are needed;
* the same with growth 4 and decay 3, one failed factorisation in three but far fewer iterations: 243.

The last changes, as factorisations of the four tuning sheets at imperfection 1e-3 (221, 240, 115 and 191 before):

* four chord steps at most instead of two: 220, 211, 114, 188; eight: 219, 208, 113, 186 (not worth the solutions);
* all fading at once from 8 negative pivots on instead of 20: 221, 240, 113, 187; from 100 on: 221, 240, 115, 191;
* both: 220, 208, 112, 184, and one less each since the factor of the state at rest is used twice;
* four chord steps, and all fading from 5 negative pivots on, now used: 212, 212, 110, 183;
* growth 5: 216, 204, 122, 189; increments twice as long after a snap: 206, 227, 146, 142; never shorter: 235, 220, 111,
  161; predictions cut at turns of 0.7 instead of 1: 219, 228, 108, 171;
* decay 4 instead of 3: 232, 231, 139, 183; least fading 0.1 instead of 0.05: 254, 217, 105, 169.

And on meshes 1.7 times as coarse, each against the settings of that time (220):

* increments that shrink with the drift, as for Newton's method: more than 400;
* no chord steps with the old factor: 299;
* growth 5 and decay 6: 281; fading held for one iteration after it was raised: 234, to a larger strain;
* going on with one to three negative pivots where the step leads downhill: more than 400;
* the negative eigenpairs flipped (found by subspace iteration with the factor), the rest Newton: on the fine mesh
  more than 300 to half of the way; in two cases of three the subspace missed a negative eigenvalue, since these are
  not the ones nearest to zero.

The descent alone is not the default of DisplacementControl: its first increments pass the first buckle, and where it
lands is one stable shape of many (benchmarks/landing.py). What was tried in the tuning of "path", as factorisations at
imperfection 1e-3 of one slit, random, cross, parallel and ring where not said otherwise:

* increments along the path of up to half or all of the distance from the start instead of a quarter: one slit 315
  instead of 263, staggered 257 instead of 186;
* corrections given up at 0.1 rad or 0.2 rad off the prediction instead of 0.05: median of all eight 275 and 293
  instead of 248, because attempts that fail cost more;
* descents from predictions of at most 0.3 rad instead of 1: 309, 284, 311, 259, 333;
* increments steered towards a drift of 0.03 instead of 0.02 rad: 254, 310, 273, 242, 294;
* twice as many chord steps: one or two fewer each.

Most of the cost is in the descents. What was tried on them, as factorisations of the 48 longest of the eight sheets at
imperfection 1e-3 (935, for 676 iterations): growth 5 and decay 4: 1,021; least fading 0.1: 933, 0.02: 990; decay 2:
933; eight chord steps: 934; a push along the softest mode near a saddle: 940. In nearly all they ended in the same
shapes. Single descents are chaotic: a change in the last digits makes one sheet dearer or cheaper by 20, so only sums
over sheets tell. On coarse meshes of one slit, parallel, random and cross, with the pivots of L D L' flipped instead of
any fading where just one is negative: 40, 226, 54, 32 instead of 45, 187, 83, 44; up to three: 39, 381, 55, 33; not
used, since only one of the back ends can. Increments of at most an eighth or a sixteenth of the distance instead of a
quarter make more steps along the path and descents as dear as before: 140 and 165 instead of 119 on a coarse one slit.

Since then the place where the residual sits settles first, which halves the descents: on four slits in shell facets
(379 nodes) 53 factorisations in twelve descents instead of 135. What was tried on top, on that sheet, each worth 4 of
132 and not used: corrections of the whole by an old factor with the place settled after each; the same along the path,
by Newton's method. At the buckle of a flat sheet places led to the other side on parallel; pushes of one length off a
saddle that is hardly one came back to it ten times on one slit (267 instead of 175).

And on the steps along the path: Anderson's acceleration of the steps with the old factor saves one factorisation in ten
on one slit and none on cells, where turns pump false stress into the residual; the tangent of the last corrector in
place of the exact one, where it is shown to be close, saves nearly one in two of all that are not in descents.

Long descents that end further from the prediction than that leads may have crossed a sharp bend to another shape. Cut
like snaps, two sheets of four and ten slits land where the slow pull does, which they do not now, for 252 instead of
167 and 137 instead of 104; but on the sheets of benchmarks/landing.py it takes a sixth more in the median (staggered
131 instead of 98, parallel 353 instead of 197), and the ring ends in another shape beyond its lock. Not used as it is.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely import LineString, Point, box

import kirigami as kg
from kirigami.analysis.path.walk import Walk

sys.path.insert(0, str(Path(__file__).parent))
import tables

FACTORIZATIONS, SECONDS = 1500, 300.0  # limits of one run
STRAIN = 0.2
GRIP = 0.1  # half-width of the grips of the round sheets


def _slit_disc() -> tuple[Any, Any]:
    return kg.cuts.single_slit_disc(0.5, 0.43, 0.0, 96)


def _ring() -> tuple[Any, Any]:
    return Point(0, 0).buffer(0.5, quad_segs=24).difference(Point(0, 0).buffer(0.3, quad_segs=24)), []


# name: outline and cuts, largest edge, edge along the cuts. Every sheet has the size 1 and at least 2,000 nodes, with
# at least three facets across its narrowest ligament.
SHEETS: dict[str, tuple[Callable[[], tuple[Any, Any]], float, float | None]] = {
    "one slit": (lambda: (box(0, 0, 1, 1), [LineString([(0.25, 0.5), (0.75, 0.5)])]), 0.027, None),
    "staggered": (
        lambda: (box(0, 0, 1, 1), kg.cuts.parallel_slits(2, 7, 1.0, 0.84, 0.36, margin=0.08)),
        0.033,
        0.0265,
    ),
    "disc": (_slit_disc, 0.024, None),
    "random": (
        lambda: (box(0, 0, 1, 1), kg.cuts.random_slits(14, 1, 1, (0.15, 0.35), seed=3, gap=0.05)),
        0.035,
        0.016,
    ),
    "cross": (
        lambda: (box(0, 0, 1, 1), [LineString([(0.3, 0.4), (0.7, 0.6)]), LineString([(0.4, 0.7), (0.6, 0.3)])]),
        0.027,
        None,
    ),
    "parallel": (
        lambda: (box(0, 0, 1, 1), [LineString([(0.2, y), (0.8, y)]) for y in (0.2, 0.4, 0.6, 0.8)]),
        0.03,
        None,
    ),
    "cells": (lambda: (box(0, 0, 1, 1.2), kg.cuts.curved_cells(2, 3, 1.0, 1.0, margin=0.1)), 0.035, 0.02),
    "ring": (_ring, 0.018, None),
}
TUNING = ("one slit", "staggered", "disc", "random")  # correctors were tuned on these; the others are held out
IMPERFECTIONS = (1e-3, 1e-6, 0.0)  # amplitude of the first eigenmode over the thickness
CORRECTORS = ("path", "descent", "newton", "viscous")
THIN = [(name, thickness) for name in ("one slit", "staggered") for thickness in (1e-2, 1e-4)]  # second part
TABLE = Path(__file__).parent / "results" / "correctors.csv"


def sheet_model(name: str, thickness: float, imperfection: float, strain: float) -> kg.Model:
    """The sheet, held at the bottom and pulled at the top by `strain` times the distance of the grips."""
    geometry, edge, cut_edge = SHEETS[name]
    outline, cuts = geometry()
    mesh = kg.Sheet(outline, cuts).mesh(edge, cut_edge=cut_edge)
    m = kg.Model.from_mesh(mesh, thickness, kg.Material(E=1.0, nu=1 / 3))
    m.name = name
    y = mesh.nodes[:, 1]
    if outline.bounds[0] < 0:
        low, high = (
            m.select(boundary="outer", where=lambda x, y, z, side=side: (np.abs(x) < GRIP + 1e-9) & (side * y > 0))
            for side in (-1, 1)
        )
    else:
        low, high = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(low), kg.Fix(high, "xz"), kg.Prescribe(high, y=strain * float(np.ptp(y))))
    if imperfection:
        m.perturb(kg.Eigen(m, n=1).run()[0], amplitude=imperfection * thickness)
    return m


def facets_across(name: str) -> int:
    """Number of facets that the shortest line between two cuts, or a cut and the outline, passes through."""
    geometry, edge, cut_edge = SHEETS[name]
    outline, cuts = geometry()
    mesh = kg.Sheet(outline, cuts).mesh(edge, cut_edge=cut_edge)
    borders = [outline.exterior, *outline.interiors, *(getattr(cut, "exterior", cut) for cut in cuts)]
    lines = [
        shapely.shortest_line(one, other)
        for one, other in itertools.combinations(borders, 2)
        if not one.intersects(other)
    ]
    narrowest = min(lines, key=lambda line: line.length)
    facets = shapely.polygons(mesh.nodes[mesh.triangles][..., :2])
    passed = shapely.length(shapely.intersection(facets, narrowest))
    return int(np.count_nonzero(passed > 1e-6 * narrowest.length))


class EnoughError(Exception):
    """The run ends here: out of budget, or locked."""


class LimitedWalk(Walk):
    """A run that ends at a limit of cost."""

    def factorize(self, matrix: Any) -> Any:
        seconds = time.process_time() - self.settings.began
        if self.results.stats["factorizations"] >= FACTORIZATIONS or seconds > SECONDS:
            raise EnoughError("limit")
        return super().factorize(matrix)


class Watched(kg.DisplacementControl):
    """Displacement control that ends at a limit of cost, or once the sheet stretches more than it bends again."""

    bent = False
    began = 0.0

    def _make_walk(self, recorders: Any) -> Walk:
        walk = LimitedWalk(self, recorders)
        self.system = walk.system
        return walk

    def watch(self, step: kg.Step) -> None:
        """Recorder: stretching takes more than half of the energy, after bending had taken more."""
        energy = self.system.energies(step.u)
        share = energy["bars"] / sum(energy.values()) if step.lam > 0 else 1.0
        if share < 0.5:
            self.bent = True
        elif self.bent:
            raise EnoughError("lock")

    def walk(self) -> str:
        """How the run ended."""
        self.began = time.process_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", kg.KirigamiWarning)
                self.run(recorders=[self.watch])
        except EnoughError as end:
            return str(end)
        except kg.ConvergenceError:
            return "failed"
        return "full strain"


def carry(
    sheet: str, corrector: str, imperfection: float, thickness: float = 1e-3, strain: float = 0.2
) -> dict[str, str]:
    """Stretch one sheet with one corrector: a row of the table."""
    m = sheet_model(sheet, thickness, imperfection, strain)
    analysis = Watched(m, corrector=corrector)
    end = analysis.walk()
    seconds = time.process_time() - analysis.began
    res = analysis.results
    assert res is not None
    last = res[-1]
    assert res.residual.max() <= analysis.tol
    return {
        "sheet": sheet,
        "thickness": f"{thickness:g}",
        "imperfection": f"{imperfection:g}",
        "corrector": corrector,
        "nodes": str(len(m.nodes)),
        "factorizations": str(res.stats["factorizations"]),
        "cpu_seconds": f"{seconds:.1f}",
        "end": end,
        "strain": f"{last.lam * strain:.4f}",
        "steps": str(len(res)),
        "unstable": str(int((~res.stable).sum())),
        "energy": f"{sum(analysis.system.energies(last.u).values()):.5e}",
        "force": f"{float(res.reaction(m.constraints[-1].group, 'y')[-1]):.5e}",
    }


KEY = ("sheet", "thickness", "imperfection", "corrector")


def markdown(rows: list[dict[str, str]]) -> str:
    """The table of what is done, a line for each sheet, thickness and imperfection; then medians and worst cases."""
    found = [name for name in CORRECTORS if any(row["corrector"] == name for row in rows)]
    lines = ["| sheet | t | imperfection / t | " + " | ".join(found) + " |", "|---" * (3 + len(found)) + "|"]
    cases = {tuple(row[name] for name in KEY[:3]): {} for row in rows}  # type: ignore[var-annotated]
    for row in rows:
        cases[tuple(row[name] for name in KEY[:3])][row["corrector"]] = row
    order = list(SHEETS)
    for case in sorted(cases, key=lambda c: (-float(c[1]), order.index(c[0]), -float(c[2]))):
        cells = []
        for name in found:
            row = cases[case].get(name)
            cells.append("" if row is None else f"{row['factorizations']}, {row['end']} at {row['strain']}")
        mark = " (tuning)" if case[0] in TUNING else ""
        lines.append(f"| {case[0]}{mark} | {case[1]} | {case[2]} | " + " | ".join(cells) + " |")
    for name in found:
        own = [row for row in rows if row["corrector"] == name and row["thickness"] == "0.001"]
        for group, sheets in (("tuning", TUNING), ("held out", tuple(set(SHEETS) - set(TUNING)))):
            counts = [int(row["factorizations"]) for row in own if row["sheet"] in sheets]
            good = sum(row["end"] in ("lock", "full strain") for row in own if row["sheet"] in sheets)
            if counts:
                lines.append(
                    f"\n{name}, {group}: success {good} of {len(counts)}, "
                    f"factorisations median {np.median(counts):.0f}, worst {max(counts)}"
                )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheet", nargs="+", choices=list(SHEETS), default=list(SHEETS))
    parser.add_argument("--corrector", nargs="+", choices=CORRECTORS, default=CORRECTORS)
    parser.add_argument("--imperfection", nargs="+", type=float, default=IMPERFECTIONS)
    parser.add_argument("--thin", action="store_true", help="second part: other thicknesses, to 40 %% strain")
    parser.add_argument("--table", action="store_true", help="print what is done, run nothing")
    wanted = parser.parse_args()
    if not wanted.table:
        done = {tuple(row[name] for name in KEY) for row in tables.read(TABLE)}
        if wanted.thin:
            cases = [(name, t, 1e-3, 0.4) for name, t in THIN if name in wanted.sheet]
        else:
            cases = [(name, 1e-3, size, STRAIN) for size in wanted.imperfection for name in wanted.sheet]
        for corrector in wanted.corrector:
            for sheet, thickness, imperfection, strain in cases:
                if (sheet, f"{thickness:g}", f"{imperfection:g}", corrector) not in done:
                    row = carry(sheet, corrector, imperfection, thickness, strain)
                    tables.add(TABLE, row)
                    print(" ".join(row.values()), flush=True)
    print(markdown(tables.read(TABLE)))


if __name__ == "__main__":
    main()
