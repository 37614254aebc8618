"""Which stable shapes there are of five cut sheets at full pull: energies, forces, how often each was reached.

    python benchmarks/which_shapes.py                        every sheet not yet done, and the tables
    python benchmarks/which_shapes.py --sheet ribbon disc    some sheets
    python benchmarks/which_shapes.py --table                print the tables of what is done
    python benchmarks/which_shapes.py --pictures folder      draw them as well

* ribbon: the README's, 0.1 x 0.24 m, nine slits, 0.2 mm, mesh of 12 mm, pulled by 4 cm
* demo: the sheet of `kirigami demo`, 2 x 2.4 m, 2 x 5 curved cells, pulled by 0.4 m
* disc: of the publication (examples/single_cut_disc.py), pulled to three quarters of its radius on each side
* squares: 0.1 x 0.1 m and two margins, 5 x 5 perpendicular slits of 34 mm, 0.1 mm, pulled by 10 %
* staggered: 0.1 x 0.1 m, 7 rows of two slits of 36 mm, every other row shifted, 0.1 mm, pulled by 10 %

All with the imperfection of Model.imperfect (the disc with the bumps of its example). Each is pulled slowly first, then
searched on "plate" by kg.study.shapes (seed 0, 80 trials, the default) with the end of the pull as one of the shapes,
told as "given"; the lowest shape is followed in the pull, and the two lowest ones are relaxed on "shell" on the same
mesh. A line of each sheet says after how many CPU seconds of trials its lowest shape was known. Rows are kept in
benchmarks/results/which_shapes.csv, and the trials of a search in a folder beside it, so that it can be interrupted and
goes on where it was.
"""

from __future__ import annotations

import argparse
import csv
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import shapely

import kirigami as kg
from kirigami.cli.demo import GRIP, PULL, demo_sheet
from kirigami.study.grips import find_grips
from kirigami.study.stretch import default_mesh

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
import tables

MYLAR = kg.Material(E=3.5e9, nu=0.34)
BUDGET = 1200.0  # CPU seconds of a sheet, so that all trials are run
NODES = 800  # of the sheets whose mesh nobody has fixed
TABLE = Path(__file__).parent / "results" / "which_shapes.csv"
TRIALS = TABLE.with_suffix("")  # folder of the trials


def ribbon() -> kg.Model:
    """The ribbon of the README."""
    slits = kg.cuts.parallel_slits(columns=1, rows=9, width=0.1, height=0.2, length=0.075, margin=0.02)
    sheet = kg.Sheet(shapely.box(0, 0, 0.1, 0.24), slits, thickness=0.2e-3, material=MYLAR)
    m = kg.Model.from_mesh(sheet.mesh(max_edge=0.012))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=0.04))
    return m


def pulled(sheet: kg.Sheet, strain: float, grip: float | None = None) -> kg.Model:
    """A sheet between clamps along y."""
    grips = find_grips(sheet, "y", grip)
    m = kg.Model.from_mesh(default_mesh(sheet, grips.lines(), NODES, None), stiffness="plate")
    grips.hold(m, strain * grips.free_length)
    return m


def demo() -> kg.Model:
    """The sheet of the demo."""
    return pulled(demo_sheet(), PULL / find_grips(demo_sheet(), "y", GRIP).free_length, GRIP)


def disc() -> kg.Model:
    """The disc of the publication."""
    import single_cut_disc

    return single_cut_disc.disc(0.4, 0.75)[0]


def squares() -> kg.Model:
    """Squares that rotate against each other."""
    cuts = kg.cuts.perpendicular_slits(5, 5, cell=0.02, length=0.034, margin=0.01)
    return pulled(kg.Sheet(shapely.box(0, 0, 0.1, 0.12), cuts, thickness=1e-4, material=MYLAR), 0.1)


def staggered() -> kg.Model:
    """Rows of slits, every second one shifted by half a slit and its gap."""
    slits = kg.cuts.parallel_slits(2, 7, 0.1, 0.084, 0.036, margin=0.008)
    return pulled(kg.Sheet(shapely.box(0, 0, 0.1, 0.1), slits, thickness=1e-4, material=MYLAR), 0.1)


SHEETS: dict[str, Callable[[], kg.Model]] = {
    "ribbon": ribbon,
    "demo": demo,
    "disc": disc,
    "squares": squares,
    "staggered": staggered,
}


def study(name: str, workers: int | None = None) -> kg.study.ShapeStudy:
    """The search of one sheet; trials that were done are not done again."""
    TRIALS.mkdir(parents=True, exist_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kg.KirigamiWarning)
        m = SHEETS[name]()
        if not np.ptp(m.positions()[:, 2]):
            m.imperfect()
        pull = kg.DisplacementControl(m).run(on_failure="return")
        ends = [step for step in pull.steps[-1:] if step.lam == 1.0]
        path = TRIALS / f"{name}.jsonl"
        return kg.study.shapes(m, starts=ends, budget=BUDGET, most=2, followed=1, path=path, workers=workers)


def rows_of(name: str, found: kg.study.ShapeStudy) -> list[dict[str, str]]:
    """The rows of the table of one sheet."""
    columns = found.table()
    common = {
        "sheet": name,
        "nodes": str(len(found.model.nodes)),
        "trials": str(len(found.trials)),
        "cpu_seconds": f"{found.cpu_seconds:.0f}",
        "cpu_seconds_to_lowest": f"{found.cpu_seconds_to(found[0]):.1f}",
    }
    return [
        common | {key: _cell(values[k]) for key, values in columns.items()} for k in range(len(found))
    ]


def _cell(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def markdown(rows: list[dict[str, str]]) -> str:
    """The tables."""
    lines = []
    for name in SHEETS:
        mine = [row for row in rows if row["sheet"] == name]
        if not mine:
            continue
        first = mine[0]
        lines += [
            f"\n{name}: {first['nodes']} nodes, {first['trials']} trials, {first['cpu_seconds']} CPU s; the lowest "
            f"shape after {first['cpu_seconds_to_lowest']} CPU s of the search",
            "| shape | energy J | force N | reached | arrangements | on shell: J, N, off, as | first by | leads to |",
            "| --- | --- | --- | --- | --- | --- | --- | --- |",
        ]
        for row in mine:
            trusted = ", ".join(row[f"trusted_{key}"] for key in ("energy", "force", "distance", "as"))
            lines.append(
                f"| {row['shape']} | {row['energy']} | {row['force']} | {row['times']} | {row['arrangements']} | "
                f"{trusted if row['trusted_energy'] else ''} | {row['reached_by']} | {row['leads_to']} |"
            )
        forces = [float(row["force"]) for row in mine]
        lines.append(f"forces {min(forces):.4g} to {max(forces):.4g} N")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sheet", nargs="+", choices=list(SHEETS), default=list(SHEETS))
    parser.add_argument("--table", action="store_true", help="print what is done, run nothing")
    parser.add_argument("--pictures", type=Path, help="folder for pictures; runs what is missing")
    parser.add_argument("--workers", type=int, help="processes for the trials")
    wanted = parser.parse_args()
    for name in () if wanted.table else wanted.sheet:
        if wanted.pictures is None and any(row["sheet"] == name for row in tables.read(TABLE)):
            continue
        found = study(name, wanted.workers)
        print(f"{name}\n{found}", flush=True)
        rows = [row for row in tables.read(TABLE) if row["sheet"] != name] + rows_of(name, found)
        with TABLE.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(rows[-1]), restval="", extrasaction="ignore")
            writer.writeheader()
            writer.writerows(rows)
        if wanted.pictures is not None:
            wanted.pictures.mkdir(parents=True, exist_ok=True)
            found.plot().savefig(wanted.pictures / f"{name}.png", dpi=130)
    print(markdown(tables.read(TABLE)))


if __name__ == "__main__":
    main()
