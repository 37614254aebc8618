"""The error bar that results state, against the error they have: sheets of many kinds, on three rungs.

    python benchmarks/error_bar.py                       # run what has not been run, then print the table
    python benchmarks/error_bar.py --only "one slit" --rung shell
    python benchmarks/error_bar.py --table               # only print what is there

Every sheet is run on a coarse mesh (800 nodes or so). The error is told by shell facets on a mesh of five times as many
nodes that start from the very shape of the coarse run, step by step, so that both are on one branch
(kirigami/study/transfer.py); what the finer mesh lacks itself is added as if errors went with one over the nodes, which
lengths at the tips of cuts are chosen for. A step counts where the finer mesh holds the same shape. Forces are compared
with themselves, areas and heights with the largest there is on the path. The estimate was tuned on the sheets marked
TUNING; the others are held out.

Runs are kept in a folder, so that another estimate can be judged without doing them again.
"""

from __future__ import annotations

import argparse
import copy
import json
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely import LineString, Point, Polygon, box
from shapely.affinity import rotate

import kirigami as kg
from kirigami.study.accuracy import ALIKE
from kirigami.study.grips import find_grips
from kirigami.study.mesh_choice import shape_distance
from kirigami.study.stretch import default_mesh
from kirigami.study.transfer import on_shape

NODES, FINER = 800, 5
AT = (0.05, 0.2, 0.5, 1.0)  # load factors that are judged, the nearest stored ones
RUNGS = ("shell", "facet", "plate")
QUANTITIES = ("force", "open_area", "height")
PRESCRIBED = 1e-7  # error below which a quantity is prescribed, not found
MATERIAL = kg.Material(E=3.5e9, nu=0.34)
MM = 1e-3
Hold = Callable[[kg.Model], tuple[Any, str]]


@dataclass(frozen=True)
class Sheet:
    """A sheet in millimetres and how it is pulled: between grips along a direction, or as a function says."""

    outline: Any
    cuts: Any
    thickness: float
    strain: float = 0.1
    direction: Any = "y"
    hold: Hold | None = None
    tuning: bool = False

    def made(self) -> kg.Sheet:
        scaled = [shapely.affinity.scale(part, MM, MM, origin=(0, 0)) for part in (self.outline, *self.cuts)]
        return kg.Sheet(scaled[0], scaled[1:], self.thickness * MM, MATERIAL)

    def model(self, nodes: int, rung: str) -> tuple[kg.Model, Any, Any]:
        """The model with its imperfection, the nodes that bear the force, and its axis."""
        sheet = self.made()
        if self.hold is not None:
            model = kg.Model.from_mesh(sheet.mesh(nodes=nodes), stiffness=rung)
            loaded, axis = self.hold(model)
            return model, loaded, axis
        grips = find_grips(sheet, self.direction)
        model = kg.Model.from_mesh(default_mesh(sheet, grips.lines(), nodes, None), stiffness=rung)
        _, moved = grips.hold(model, self.strain * grips.free_length)
        model.imperfect()
        return model, moved, grips.direction


def line(*points: tuple[float, float]) -> LineString:
    return LineString(points)


def arc(radius: float, start: float, end: float, centre: tuple[float, float] = (50, 50)) -> LineString:
    angle = np.radians(np.linspace(start, end, 41))
    return LineString(np.column_stack([centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)]))


def cantilever(model: kg.Model) -> tuple[Any, str]:
    left, right = model.select(boundary="left"), model.select(boundary="right")
    model.add(kg.Fix(left, clamp=True), kg.Prescribe(right, z=30 * MM))
    return right, "z"


def pressed(model: kg.Model) -> tuple[Any, str]:
    rim = model.select(boundary="cut:0")
    model.add(kg.Fix(model.select(boundary="outer"), clamp=True), kg.Prescribe(rim, z=0.5 * MM))
    return rim, "z"


def twisted(model: kg.Model) -> tuple[Any, str]:
    low, high = model.select(boundary="left"), model.select(boundary="right")
    away = model.positions()[model.index(high), 1] - 0.015
    model.add(kg.Fix(low, clamp=True), kg.Fix(high, "x"), kg.Prescribe(high, z=0.3 * away))
    return [node for node in high if node.y > 0.015], "z"


def in_plane(model: kg.Model) -> tuple[Any, str]:
    low, high = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(model.nodes, "z"), kg.Fix(low, "xy"), kg.Fix(high, "x"), kg.Prescribe(high, y=0.1 * MM))
    return high, "y"


SQUARE, FLAG = box(0, 0, 100, 100), box(0, 0, 100, 60)
RING = Point(50, 50).buffer(50, quad_segs=24).difference(Point(50, 50).buffer(30, quad_segs=24))
FOUR = [line((10, 12), (80, 12)), line((20, 24), (90, 24)), line((10, 36), (80, 36)), line((20, 48), (90, 48))]
SHEETS: dict[str, Sheet] = {
    "one slit": Sheet(SQUARE, [line((25, 50), (75, 50))], 0.3, tuning=True),
    "parallel": Sheet(SQUARE, [line((20, y), (80, y)) for y in (20, 40, 60, 80)], 0.2, tuning=True),
    "staggered": Sheet(
        SQUARE, kg.cuts.parallel_slits(1, 5, 100, 80, 62, margin=10), 0.2, 0.15, tuning=True
    ),
    "cross": Sheet(SQUARE, [line((30, 40), (70, 60)), line((40, 70), (60, 30))], 0.5, 0.05, tuning=True),
    "ring": Sheet(RING, [], 0.2, 0.1, tuning=True),
    "four slits": Sheet(FLAG, FOUR, 0.1, 0.2, tuning=True),
    "random": Sheet(SQUARE, kg.cuts.random_slits(7, 100, 100, (20, 40), seed=3, gap=8), 0.25, tuning=True),
    "cells": Sheet(box(0, 0, 100, 120), kg.cuts.curved_cells(2, 2, 100, 100, margin=10), 0.3, 0.15, tuning=True),
    "hole": Sheet(SQUARE, [Point(50, 50).buffer(20)], 0.2, 0.02, tuning=True),
    "cantilever": Sheet(box(0, 0, 100, 30), [], 0.5, hold=cantilever, tuning=True),
    "flat crack": Sheet(SQUARE, [line((25, 50), (75, 50))], 1.0, hold=in_plane, tuning=True),
    "notches": Sheet(
        box(0, 0, 60, 100), [line((0, 30), (40, 30)), line((60, 50), (20, 50)), line((0, 70), (40, 70))], 0.2, 0.2,
        tuning=True,
    ),
    # held out
    "turned slits": Sheet(
        SQUARE, [rotate(line((22, y), (78, y)), 25, origin=(50, 50)) for y in (32, 50, 68)], 0.2
    ),
    "tongue": Sheet(SQUARE, [line((30, 70), (30, 30), (70, 30), (70, 70))], 0.4, 0.05),
    "arcs": Sheet(SQUARE, [arc(30, 20, 160), arc(30, 200, 340), arc(18, 110, 250), arc(18, 290, 430)], 0.2),
    "squares": Sheet(box(0, 0, 90, 110), kg.cuts.perpendicular_slits(3, 3, 30, 48, margin=10), 0.3, 0.15),
    "ell cuts": Sheet(SQUARE, [line((20, 30), (60, 30), (60, 45)), line((80, 70), (40, 70), (40, 55))], 0.3, 0.08),
    "hexagon": Sheet(
        Polygon([(50 + 50 * np.cos(a), 50 + 50 * np.sin(a)) for a in np.pi / 3 * np.arange(6)]),
        [rotate(line((56, 50), (82, 50)), angle, origin=(50, 50)) for angle in (30, 150, 270)], 0.25, 0.08,
    ),
    "thick slit": Sheet(SQUARE, [line((20, 50), (80, 50))], 2.0, 0.05),
    "thin slits": Sheet(SQUARE, [line((25, y), (75, y)) for y in (35, 65)], 0.05, 0.05),
    "pulled aslant": Sheet(SQUARE, [line((25, 40), (75, 40)), line((25, 60), (75, 60))], 0.2, 0.08, 60),
    "zigzag": Sheet(
        Polygon([(0, 0), (60, 0), (60, 100), (0, 100)]),
        [line((0, 20), (20, 25), (42, 20)), line((60, 40), (40, 45), (18, 40)), line((0, 60), (20, 65), (42, 60)),
         line((60, 80), (40, 85), (18, 80))], 0.15, 0.3,
    ),
    "spiral": Sheet(
        Point(50, 50).buffer(50, quad_segs=24),
        [LineString([(50 + (8 + 30 * s) * np.cos(8 * s + p), 50 + (8 + 30 * s) * np.sin(8 * s + p))
                     for s in np.linspace(0, 1, 60)]) for p in (0, np.pi)], 0.3, 0.1,
    ),
    "random two": Sheet(SQUARE, kg.cuts.random_slits(6, 100, 100, (20, 45), seed=11, gap=8), 0.4, 0.08),
    "pressed": Sheet(SQUARE, [Point(50, 50).buffer(15)], 0.5, hold=pressed),
    "twisted": Sheet(box(0, 0, 100, 30), [], 0.5, hold=twisted),
    "flat slits": Sheet(SQUARE, kg.cuts.parallel_slits(2, 4, 100, 80, 32, margin=10), 1.0, hold=in_plane),
    "plain pushed": Sheet(box(0, 0, 60, 100), [], 0.5, -0.02),
    "star": Sheet(SQUARE, [rotate(line((50, 50), (80, 50)), angle, origin=(50, 50)) for angle in (90, 210, 330)],
                  0.25, 0.06),
    "tabs": Sheet(
        box(0, 0, 80, 100), [line((20, 25), (20, 15), (60, 15), (60, 25)), line((20, 75), (20, 85), (60, 85), (60, 75)),
                             line((15, 50), (65, 50))], 0.25, 0.1,
    ),
}  # fmt: skip


def values(results: kg.Results, nodes: Any, axis: Any) -> dict[str, np.ndarray]:
    """Force, open area and height at every step."""
    assert results.mesh is not None
    areas = results.open_area(union=True) if results.mesh.cuts else np.zeros(len(results))
    return {"force": results.reaction(nodes, axis), "open_area": areas, "height": results.height()}


def run(name: str, rung: str, folder: Path) -> None:
    """Run a sheet coarse, and the finer shell on its shapes; keep both."""
    sheet = SHEETS[name]
    path = folder / f"{name.replace(' ', '-')}-{rung}"
    begun = time.process_time()
    model, nodes, axis = sheet.model(NODES, rung)
    results = kg.DisplacementControl(model, targets=[0.01, *AT]).run()
    seconds = time.process_time() - begun
    coarse = values(results, nodes, axis)
    steps = [int(np.abs(results.lam - lam).argmin()) for lam in AT]
    fine_model, fine_nodes, _ = sheet.model(FINER * NODES, "shell")
    begun = time.process_time()
    found = on_shape(fine_model, results, steps, tol=1e-7)
    assert results.mesh is not None and fine_model.mesh is not None
    rows = []
    for step, fine in zip(steps, found):
        row: dict[str, Any] = {"step": step, "lam": float(results.lam[step])}
        row |= {q: float(coarse[q][step]) for q in QUANTITIES}
        if fine is not None:
            head = copy.copy(results)
            head.steps = results.steps[: step + 1]
            head.__dict__.pop("u", None)
            row["apart"] = shape_distance(fine, head)
            row |= {f"fine {q}": float(v[-1]) for q, v in values(fine, fine_nodes, axis).items()}
        rows.append(row)
    content = {
        "name": name, "rung": rung, "seconds": seconds, "fine_seconds": time.process_time() - begun,
        "nodes": len(results.mesh.nodes), "fine_nodes": len(fine_model.mesh.nodes), "rows": rows,
        "largest": {q: float(np.abs(coarse[q]).max()) for q in QUANTITIES},
        "factorizations": results.stats["factorizations"], "events": len(results.events),
    }  # fmt: skip
    results.save(path.with_suffix(".npz"))
    path.with_suffix(".json").write_text(json.dumps(content, indent=1) + "\n")
    print(name, rung, f"{seconds:.1f} s, finer {content['fine_seconds']:.1f} s",
          [round(row.get("apart", np.nan), 3) for row in rows], flush=True)  # fmt: skip


def judged(path: Path) -> list[tuple[str, float, float, float]]:
    """Quantity, load factor, true error and stated bar of a run that was kept, where the shape is the same."""
    content, results = json.loads(path.read_text()), kg.load(path.with_suffix(".npz"))
    ratio = content["fine_nodes"] / content["nodes"]
    found = []
    for row in content["rows"]:
        if row.get("apart", np.inf) > ALIKE:
            continue
        for quantity in QUANTITIES:
            scale = abs(row[quantity]) if quantity == "force" else content["largest"][quantity]
            bar = results.error[quantity][row["step"]]
            if scale > 0 and np.isfinite(bar):
                true = abs(row[f"fine {quantity}"] - row[quantity]) * ratio / (ratio - 1) / scale
                if true > PRESCRIBED:
                    found.append((quantity, row["lam"], true, float(bar)))
    return found


def table(folder: Path) -> None:
    """True errors and bars in percent, and how many bars hold, of the sheets that were tuned on and of the others."""
    pool: dict[tuple[str, str, bool], list[tuple[float, float]]] = {}
    for rung in RUNGS:
        for name in SHEETS:
            path = folder / f"{name.replace(' ', '-')}-{rung}.json"
            if not path.exists():
                continue
            cells = []
            for quantity, lam, true, bar in judged(path):
                pool.setdefault((rung, quantity, SHEETS[name].tuning), []).append((true, bar))
                mark = "" if true <= bar else " !"
                cells.append(f"{quantity} at {lam:.2g} {100 * true:.3g} < {100 * bar:.3g}{mark}")
            print(f"{rung:<6} {name:<14} {'; '.join(cells)}", flush=True)
    for (rung, quantity, tuning), pairs in sorted(pool.items()):
        true, bar = np.array(pairs).T
        print(
            f"{rung:<6} {quantity:<10} {'tuned on' if tuning else 'held out'}: {(true <= bar).sum()} of {len(true)} "
            f"within the bar, the bar {np.median(bar / true):.2f} times the error in the median"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=tuple(SHEETS))
    parser.add_argument("--rung", nargs="+", default=list(RUNGS), choices=RUNGS)
    parser.add_argument("--table", action="store_true", help="run nothing")
    parser.add_argument("--folder", type=Path, default=Path("error_bar"), help="runs (default: ./%(default)s)")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore")
    for name in options.only or SHEETS:
        for rung in options.rung:
            path = options.folder / f"{name.replace(' ', '-')}-{rung}.json"
            if not path.exists() and not options.table:
                try:
                    run(name, rung, options.folder)
                except kg.KirigamiError as error:
                    print(name, rung, "failed:", str(error)[:200], flush=True)
    table(options.folder)


if __name__ == "__main__":
    main()
