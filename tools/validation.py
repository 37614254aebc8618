"""Run every case of tests/validation on every rung, and write docs/validation.md and its pictures.

    python tools/validation.py                 all of it: a quarter of an hour on one core
    python tools/validation.py sze leissa      some sources; the rows of the others stay
    python tools/validation.py --page          the page alone, from the rows that are there

Rows are kept in docs/validation.csv. Seconds are CPU seconds of one thread, without the import.
"""

from __future__ import annotations

import argparse
import csv
import importlib
import inspect
import re
import sys
import textwrap
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import kirigami
from kirigami.plot import style
from kirigami.study.accuracy_picture import LOOKS

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / "tests" / "validation"
ROWS, PAGE, PICTURES = ROOT / "docs" / "validation.csv", ROOT / "docs" / "validation.md", ROOT / "docs" / "images"
RUNGS = ("shell", "facet", "plate", "paper", "bars")
HEADINGS = {
    "macneal_harder": "MacNeal and Harder",
    "sze": "Sze, Liu and Lo",
    "timoshenko": "Timoshenko and Gere",
}
SIDE_BY_SIDE = 4  # pictures without a curve, at most
FIELDS = ("source", "case", "rung", "error", "nodes", "seconds")


def sources() -> dict[str, Any]:
    """The modules that list cases, by the name of their source."""
    sys.path.insert(0, str(FOLDER))
    modules = {path.stem[5:]: importlib.import_module(path.stem) for path in sorted(FOLDER.glob("test_*.py"))}
    return {name: module for name, module in modules.items() if hasattr(module, "CASES")}


def picture_name(source: str, case: Any) -> str:
    return f"validation_{source}_{re.sub('[^a-z0-9]+', '_', case.name.lower()).strip('_')}.png"


def triangles_of(model: Any) -> Any:
    """Facets of a model by node number, whether it came from a mesh or was built by hand."""
    if model.mesh is not None:
        return model.mesh.triangles
    edges = kirigami.System(model).edges
    return None if edges is None else edges.triangles


@style.styled
def draw(source: str, case: Any, outcomes: dict[str, Any]) -> None:
    """The last shape on the best rung, and the curves of all rungs over the published points."""
    from matplotlib import pyplot as plt

    best = next(iter(outcomes.values())).found.results
    curve = len(case.at) > 1
    if best is None or (facets := triangles_of(best.model)) is None:
        return
    figure = plt.figure(figsize=(7.0 if curve else 3.2, 2.8), layout="constrained")
    shape = figure.add_subplot(1, 2 if curve else 1, 1, projection="3d", proj_type="ortho")
    rest, u = best.rest, best.u[-1]
    size = float(np.ptp(rest, axis=0).max())
    grow = 1.0 if np.abs(u).max() > 0.02 * size else 0.15 * size / max(np.abs(u).max(), 1e-300)
    at = rest + grow * u
    shape.plot_trisurf(*at.T, triangles=facets, color=style.PALE, edgecolor=style.GREY, linewidth=0.2)
    in_plane = np.ptp(at[:, 2]) < 1e-6 * size
    style.frame_solid(shape, at, (90.0, -90.0) if in_plane else style.DEFAULT_VIEW)
    if curve:
        axes = figure.add_subplot(1, 2, 2)
        wanted = np.atleast_2d(np.asarray(case.reference, float).T).T
        for number, (rung, outcome) in enumerate(outcomes.items()):  # the best rung before the others
            found = np.asarray(outcome.found.values, float).reshape(wanted.shape)
            look = {"color": LOOKS[rung][0], "zorder": 3 - 0.1 * number}
            for k in range(wanted.shape[1]):
                axes.plot(case.at, found[:, k], label=rung if k == 0 else None, **look)
        axes.plot(case.at, wanted, "o", color=style.INK, markersize=3.5, zorder=4)
        axes.plot([], [], "o", color=style.INK, markersize=3.5, label="published")
        axes.set_xlabel(case.axis)
        axes.set_ylabel(textwrap.fill(case.quantity, 28))
        figure.legend(loc="outside lower right", ncols=4)
    PICTURES.mkdir(exist_ok=True)
    figure.savefig(PICTURES / picture_name(source, case), dpi=110)
    plt.close(figure)


def read_rows() -> dict[tuple[str, str, str], dict[str, str]]:
    if not ROWS.exists():
        return {}
    with ROWS.open(newline="") as file:
        return {(row["source"], row["case"], row["rung"]): row for row in csv.DictReader(file)}


def write_rows(rows: dict[tuple[str, str, str], dict[str, str]]) -> None:
    with ROWS.open("w", newline="") as file:
        table = csv.DictWriter(file, FIELDS)
        table.writeheader()
        table.writerows(rows.values())


def solve(source: str, module: Any, rows: dict[tuple[str, str, str], dict[str, str]]) -> None:
    """Run the cases of one source, and keep their rows."""
    for case in module.CASES:
        outcomes = {}
        for rung in sorted(case.bounds, key=RUNGS.index):
            outcome = outcomes[rung] = case.run(rung)
            rows[source, case.name, rung] = {
                "source": source, "case": case.name, "rung": rung, "error": f"{outcome.error:.3g}",
                "nodes": str(outcome.nodes), "seconds": f"{outcome.seconds:.1f}",
            }  # fmt: skip
            print(f"{source:20s} {case.name:42s} {rung:6s} {100 * outcome.error:8.2f} %", flush=True)
        draw(source, case, outcomes)
        write_rows(rows)


def percent(value: float) -> str:
    return f"{100 * value:.2f} %" if value < 0.1 else f"{100 * value:.0f} %"


def shown(cases: list[Any], source: str) -> list[str]:
    """The pictures of cases: those with a curve by themselves, the others side by side over their names."""
    text = []
    alone = [case for case in cases if len(case.at) > 1]
    for case in alone:
        text += [f"![{case.name}](images/{picture_name(source, case)})", "", f"*{case.name}*", ""]
    others = [case for case in cases if case not in alone]
    most = -(-len(others) // -(-len(others) // SIDE_BY_SIDE)) if others else 1  # rows of one length, as far as may be
    for first in range(0, len(others), most):
        row = others[first : first + most]
        text += [f"| {' | '.join(f'![{case.name}](images/{picture_name(source, case)})' for case in row)} |"]
        text += ["| --- " * len(row) + "|", f"| {' | '.join(case.name for case in row)} |", ""]
    return text


def page(modules: dict[str, Any], rows: dict[tuple[str, str, str], dict[str, str]]) -> str:
    """The page, from the rows."""
    done = [(name, case) for name, module in modules.items() for case in module.CASES]
    missed = sum(bool(bound.miss) for _, case in done for bound in case.bounds.values())
    runs = sum(len(case.bounds) for _, case in done)
    text = [
        "# Held against the world",
        "",
        f"{len(done)} published cases, {runs} runs of them on the rungs of accuracy side by side; {missed} of these "
        "runs miss their case, which is said, with the cause. An error is the largest relative one of all values of a "
        "case (*of the largest value*: where values pass through zero). Nodes are corners of facets; seconds are CPU "
        "seconds of one thread, "
        "on a shared machine. `facet` and `plate` run on the mesh of the shell, or on a finer one of the mesher; on "
        "squares they get parallel diagonals, which suit them best.",
        "",
        "All of it again: `python tools/validation.py`; as tests: "
        '`python -m pytest tests/validation -m "long or not long"`; '
        'one case: `python -m pytest tests/validation -m "long or not long" -k "annular"`.',
        "",
    ]
    for name, module in modules.items():
        lines = [line.strip() for line in (inspect.getdoc(module) or "").split("\n\n")]
        heading = HEADINGS.get(name, name.replace("_", " ").capitalize())
        text += [f"## {heading}", "", *(" ".join(p.split()) + "\n" for p in lines)]
        text += ["| case | compared | rung | error | bound | nodes | seconds |", "| " + "--- | " * 6 + "--- |"]
        causes = []
        for case in module.CASES:
            for rung in sorted(case.bounds, key=RUNGS.index):
                bound, row = case.bounds[rung], rows.get((name, case.name, rung))
                first = rung == min(case.bounds, key=RUNGS.index)
                said = percent(float(row["error"])) if row else ""
                said = f"**{said}**" if bound.miss else said
                allowed = f"{100 * case.holds:g} %, missed" if bound.miss else f"{100 * bound.error:g} %"
                compared = case.quantity + (", of the largest value" if case.whole else "")
                text.append(
                    f"| {case.name if first else ''} | {compared if first else ''} | {rung} | {said} | {allowed} "
                    f"| {row['nodes'] if row else ''} | {row['seconds'] if row else ''} |"
                )
                if bound.miss:
                    causes.append((bound.miss, f"{case.name} on `{rung}`"))
        text.append("")
        for cause in dict.fromkeys(cause for cause, _ in causes):
            where = ", ".join(place for said, place in causes if said == cause)
            text += [f"*Missed because {cause}:* {where}.", ""]
        text += shown([case for case in module.CASES if (PICTURES / picture_name(name, case)).exists()], name)
    return "\n".join(text).rstrip() + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sources", nargs="*")
    parser.add_argument("--page", action="store_true", help="write the page from the rows, run nothing")
    options = parser.parse_args()
    modules, rows = sources(), read_rows()
    warnings.simplefilter("ignore")
    for name in () if options.page else options.sources or modules:
        solve(name, modules[name], rows)
    PAGE.write_text(page(modules, rows))


if __name__ == "__main__":
    main()
