"""``kirigami stretch``: the whole job on a drawing."""

from __future__ import annotations

import argparse
import math
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from kirigami.cli.options import add_command, add_reading, print_json, quantity, reading, speaker
from kirigami.errors import KirigamiError

DESCRIPTION = """\
Read a drawing (.dxf, .svg, .geojson, .fold), mesh it, hold its two ends, pull or push one of
them, and follow the sheet through buckling. The ends are the straight edges at the two extremes
of the outline along the pull, or strips where these are not straight. In a script: kg.stretch.

Writes a folder: report.json, curves.csv, results.npz, pictures, page.html (turn the sheet with
the mouse, run the load with a slider) and vtk/ for ParaView."""

EPILOG = """\
Quantities take a unit: 0.1mm, 50um, 2in; 3.5GPa, 70MPa; 20%. Without one they are metres,
pascals and plain ratios. What was understood is echoed, and what looks like a slip is doubted.

examples:
  kirigami stretch plate.dxf --thickness 0.1mm --E 3.5GPa
  kirigami stretch plate.svg --thickness 75um --E 5GPa --strain 30% --direction x --grip 5mm
  kirigami stretch plate.dxf --thickness 0.1mm --E 3.5GPa --drawn-in in --cuts red --outline black
  kirigami stretch plate.dxf --thickness 0.1mm --E 3.5GPa --nodes 1000 --json | jq .largest_force
  kirigami stretch plate.dxf --thickness 0.1mm --E 3.5GPa --strain=-2% --direction 30 --cycle

Ends with 0 where the whole strain was reached, 1 where the path ended early (what was found is
written) or nothing could be done, 2 for wrong usage, 130 when interrupted (what was found is
written)."""


def add(commands: Any) -> None:
    """Options of ``kirigami stretch``."""
    length, positive = quantity("length", "not negative"), quantity("length", "positive")
    stress = quantity("stress", "positive")
    parser = add_command(
        commands, "stretch", run, help="stretch a drawing and write a report", description=DESCRIPTION, epilog=EPILOG
    )
    parser.add_argument("drawing", type=Path, metavar="DRAWING", help="the file")
    sheet = parser.add_argument_group("the sheet")
    sheet.add_argument("--thickness", type=positive, required=True, metavar="LENGTH", help="thickness of the sheet")
    sheet.add_argument("--E", type=stress, required=True, metavar="STRESS", help="Young's modulus")
    sheet.add_argument("--nu", type=float, default=0.34, metavar="RATIO", help="Poisson's ratio (default: %(default)s)")
    pull = parser.add_argument_group("the pull")
    pull.add_argument(
        "--strain",
        type=quantity("ratio"),
        default=0.2,
        metavar="RATIO",
        help="grip displacement over the length between the grips (default: 20%%); to push, write --strain=-5%%",
    )
    pull.add_argument(
        "--direction",
        type=_direction,
        default="y",
        metavar="y|x|DEGREES",
        help="of the pull: an axis, or an angle from x, counter-clockwise (default: %(default)s)",
    )
    pull.add_argument("--cycle", action="store_true", help="go there and back again")
    pull.add_argument(
        "--grip",
        type=length,
        metavar="LENGTH",
        help="length of the strips that are held; 0 holds the edges alone (default: 0 where the ends are straight, "
        "else 4%% of the length)",
    )
    work = parser.add_argument_group("the computation")
    work.add_argument(
        "--accuracy",
        choices=("draft", "standard", "fine"),
        default="standard",
        help="how much to pay for: stiffness, mesh and residual (default: %(default)s)",
    )
    work.add_argument("--nodes", type=_count, metavar="N", help="budget of mesh nodes (default: that of the accuracy)")
    work.add_argument(
        "--max-edge", type=positive, metavar="LENGTH", help="longest edge of the mesh, instead of a budget"
    )
    work.add_argument("--stiffness", metavar="NAME", help="plate, facet, ... (default: that of the accuracy)")
    work.add_argument(
        "--imperfection",
        type=length,
        metavar="LENGTH",
        help="height of the imperfection, which is free of stress (default: a tenth of the thickness)",
    )
    work.add_argument(
        "--seed", type=int, default=0, metavar="N", help="of the imperfection (default: %(default)s)"
    )
    work.add_argument(
        "--shapes",
        action="store_true",
        help="also look which other shapes the sheet can take at the whole strain, and say which one this is: "
        "shapes.csv, shapes.png; some minutes more",
    )
    work.add_argument("--folder", type=Path, help="where to write (default: ./NAME-stretched)")
    add_reading(parser)


def run(options: argparse.Namespace) -> int:
    """Stretch a drawing and write the report."""
    import matplotlib

    from kirigami.study.report import stretch_drawing, write_report

    matplotlib.use("Agg")  # files only: no window, no display needed
    say = speaker(options)
    folder: Path = options.folder or Path(f"{options.drawing.stem}-stretched")
    made = not folder.exists()
    folder.mkdir(parents=True, exist_ok=True)  # before the work, which would be in vain without it
    try:
        report = stretch_drawing(
            options.drawing,
            thickness=options.thickness,
            E=options.E,
            nu=options.nu,
            strain=options.strain,
            direction=options.direction,
            accuracy=options.accuracy,
            cycle=options.cycle,
            grip=options.grip,
            nodes=options.nodes,
            max_edge=options.max_edge,
            stiffness=options.stiffness,
            imperfection=options.imperfection,
            seed=options.seed,
            shapes=options.shapes,
            progress=not options.quiet,
            say=lambda note: say(f"  {note}"),
            **reading(options),
        )
    except (KirigamiError, OSError, KeyboardInterrupt):
        if made:
            with suppress(OSError):
                folder.rmdir()
        raise
    say(report.text())
    files = write_report(report, folder, lambda words: print(f"kirigami: {words}", file=sys.stderr))
    say(f"Written to {folder}: {', '.join(_names(files, folder))}")
    print_json(options, {"complete": report.complete, **report.numbers, "folder": folder})
    if any(event.kind == "interrupted" for event in report.results.events):
        return 130
    return 0 if report.complete else 1


def _direction(text: str) -> str | float:
    if text in ("x", "y"):
        return text
    try:
        angle = float(text)
    except ValueError:
        angle = math.nan
    if not math.isfinite(angle):
        raise argparse.ArgumentTypeError(f"{text!r} is neither x nor y nor an angle in degrees")
    return angle


def _count(text: str) -> int:
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of nodes")
    return number


def _names(files: list[Path], folder: Path) -> list[str]:
    """Names of the files of the folder, and of its folders in the place of what they hold."""
    parts = [file.relative_to(folder).parts for file in files]
    return list(dict.fromkeys(f"{first}/" if rest else first for first, *rest in parts))
