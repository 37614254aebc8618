"""``kirigami demo``: the curved-cell sheet of the published study, stretched by :func:`kirigami.stretch`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import kirigami as kg
from kirigami.cli.options import add_command, in_words_of_the_command, print_json, speaker, whole_number
from kirigami.files import make_folder

DESCRIPTION = """\
Stretch a sheet of 2 x 2.4 m with 2 x 5 curved cells (3 mm thick, E = 2.5 GPa, nu = 0.34) by 0.4 m,
held in strips of 95 mm.

Writes what kirigami stretch writes (pictures, curves.csv, results.npz, which kirigami.load reads
back, page.html, vtk/) and an animation, stretch.gif."""

EPILOG = """\
examples:
  kirigami demo                    pictures and numbers in ./demo
  kirigami demo --shapes           also look which other shapes there are, minutes more
  kirigami demo --full             the same on a mesh as fine as that of the published study
  kirigami demo --folder out -q    say nothing, write to ./out"""

ONE_OF_MANY = "where a slow pull leads is one stable shape of many: --shapes looks for the others, some minutes more"
GRIP, PULL = 0.095, 0.4  # m
FULL = 7500  # nodes of the mesh of the published study


def add(commands: Any) -> None:
    """Options of ``kirigami demo``."""
    parser = add_command(
        commands,
        "demo",
        run,
        help="stretch a built-in sheet and write pictures, an animation and the numbers",
        description=DESCRIPTION,
        epilog=EPILOG,
    )
    parser.add_argument("--full", action="store_true", help=f"a mesh of up to {FULL:,} nodes")
    parser.add_argument(
        "--shapes", action="store_true", help="also look which other shapes it can take: shapes.csv, shapes.png"
    )
    parser.add_argument("--folder", type=Path, default=Path("demo"), help="where to write (default: %(default)s)")
    parser.add_argument(
        "--frames",
        type=whole_number("the number of pictures", 2),
        default=40,
        metavar="N",
        help="pictures in the animation (default: %(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Stretch the curved-cell sheet of the published study."""
    import matplotlib

    from kirigami.drawing.drawing import Drawing
    from kirigami.progress import progress_bar
    from kirigami.study.grips import find_grips
    from kirigami.study.job import Job
    from kirigami.study.report import Report, write_report

    matplotlib.use("Agg")  # files only: no window, no display needed
    say = speaker(options)
    sheet = demo_sheet()
    grips = find_grips(sheet, "y", GRIP)
    strain = PULL / grips.free_length
    make_folder(options.folder)  # before the work, which would be in vain without it
    say(f"Stretching a sheet of 2 x 5 curved cells by {PULL} m")
    notes: list[str] = []
    try:
        results = kg.stretch(
            sheet, strain, "y", grip=GRIP, nodes=FULL if options.full else None, shapes=options.shapes,
            progress=not options.quiet, say=notes.append,
        )  # fmt: skip
    except kg.ConvergenceError as error:
        if error.results is None or not len(error.results):
            raise
        results = error.results
        say(str(error))
    results.name, results.units = "sheet of 2 x 5 curved cells", "SI"
    assert sheet.thickness is not None and isinstance(sheet.material, kg.Material)
    job = Job(Drawing(sheet.outline, tuple(sheet.cuts)), sheet.thickness, sheet.material.E, sheet.material.nu,
              kg.LoadCase(strain, "y", GRIP))  # fmt: skip
    report = Report(results, job, (*notes, *map(str, results.events)), grips.free_length)
    for line in in_words_of_the_command("\n".join((*report.notes, report.text()))).splitlines():
        say(f"  {line}")
    if results.shapes is None:
        say(f"  {ONE_OF_MANY}")
    files = write_report(report, options.folder, lambda words: print(f"kirigami: {words}", file=sys.stderr))
    if len(results) > 1:
        with progress_bar(not options.quiet, "Animation") as bar:
            bar.start(0.0)
            files.append(results.animate(
                options.folder / "stretch.gif", frames=options.frames,
                on_frame=lambda done: bar.move(done / options.frames),
            ))  # fmt: skip
    say(f"Written to {options.folder}: {', '.join(file.name for file in files if file.parent == options.folder)}")
    print_json(options, {"complete": report.complete, **report.numbers, "folder": options.folder})
    if any(event.kind == "interrupted" for event in results.events):
        return 130
    return 0 if report.complete else 1


def demo_sheet() -> kg.Sheet:
    """The curved-cell sheet of the published study."""
    from shapely import box

    return kg.Sheet(
        box(0, 0, 2, 2.4),
        kg.cuts.curved_cells(2, 5, opening=0.005),
        thickness=0.003,
        material=kg.Material(E=2.5e9, nu=0.34),
    )
