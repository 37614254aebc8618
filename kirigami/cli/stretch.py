"""``kirigami stretch``: the whole job on a drawing."""

from __future__ import annotations

import argparse
import math
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from kirigami.cli.options import (
    add_command,
    add_reading,
    in_words_of_the_command,
    print_json,
    quantity,
    reading,
    speaker,
    whole_number,
)
from kirigami.errors import KirigamiError, ModelError
from kirigami.files import make_folder

DESCRIPTION = """\
Read a drawing (.dxf, .svg, .geojson, .fold), mesh it, hold its two ends, pull, push, shear or
twist one of them, or lift and push places of the sheet, and follow it through buckling. The ends
are the straight edges at the two extremes of the outline along the pull, or strips where these
are not straight. In a script: kg.stretch with a kg.LoadCase.

Writes a folder: report.json, case.json (which does the job again), curves.csv, results.npz,
pictures, page.html (turn the sheet with the mouse, run the load with a slider) and vtk/ for
ParaView."""

EPILOG = """\
Quantities take a unit: 0.1mm, 50um, 2in; 3.5GPa, 70MPa; 20%. Without one they are metres,
pascals and plain ratios. What was understood is echoed, and what looks like a slip is doubted.

A PLACE is left, right, bottom or top (the straight edge there), rim, centre, cut:NUMBER,
layer:NAME (marks in the drawing, which are left out of the sheet unless a role is said), or
coordinates: 'x,y' is a point, 'x,y,radius' a disc, 'xmin,ymin,xmax,ymax' a box, in metres or
with units: '30mm,40mm'.

examples:
  kirigami stretch plate.dxf --thickness 0.1mm --E 3.5GPa
  kirigami stretch plate.svg --thickness 75um --E 5GPa --strain 30% --direction x --grip 5mm
  kirigami stretch plate.dxf --thickness 0.1mm --E 3.5GPa --drawn-in in --cuts red --outline black
  kirigami stretch plate.dxf --thickness 0.1mm --E 3.5GPa --nodes 1000 --json | jq .largest_force
  kirigami stretch plate.dxf --thickness 0.1mm --E 3.5GPa --strain -2% --direction 30 --cycle
  kirigami stretch plate.dxf --thickness 0.1mm --E 3.5GPa --strain 5% --twist 90
  kirigami stretch miura.fold --thickness 0.2mm --E 3GPa --fold-angle 40 --strain 10% --direction x
  kirigami stretch spiral.svg --thickness 0.3mm --E 2GPa --hold rim --lift centre 40mm
  kirigami stretch plate.svg --thickness 0.1mm --E 3.5GPa --region stiff thickness=0.3mm E=70GPa
  kirigami stretch plate-stretched/case.json --nodes 3000 --compare measured.csv

Ends with 0 where the whole way was gone, 1 where the path ended early (what was found is
written) or nothing could be done, 2 for wrong usage, 130 when interrupted (what was found is
written)."""

SHEET = "thickness", "E", "nu", "density", "fold_stiffness", "fold_angle"
COMPUTATION = "accuracy", "nodes", "max_edge", "stiffness", "imperfection", "seed", "shapes"


def add(commands: Any) -> None:
    """Options of ``kirigami stretch``."""
    length, positive = quantity("length", "not negative"), quantity("length", "positive")
    stress, ratio = quantity("stress", "positive"), quantity("ratio")
    parser = add_command(
        commands, "stretch", run, help="stretch a drawing and write a report", description=DESCRIPTION, epilog=EPILOG
    )
    parser.add_argument("drawing", type=Path, metavar="DRAWING", help="the file, or a case.json to do again")
    sheet = parser.add_argument_group("the sheet")
    sheet.add_argument("--thickness", type=positive, metavar="LENGTH", help="thickness of the sheet (needed)")
    sheet.add_argument("--E", type=stress, metavar="STRESS", help="Young's modulus (needed)")
    sheet.add_argument("--nu", type=ratio, metavar="RATIO", help="Poisson's ratio (default: 0.34)")
    sheet.add_argument(
        "--fold-stiffness",
        type=quantity("force", "not negative"),
        metavar="FORCE",
        help="moment of the folds per length and radian, such as 20mN; 0 is a free hinge (default: a light score's)",
    )
    sheet.add_argument(
        "--fold-angle",
        type=_fold_angle,
        metavar="DEGREES",
        help="angle at which the folds rest, valleys up and mountains down; the sheet folds first (default: flat)",
    )
    sheet.add_argument(
        "--density", type=quantity("density", "positive"), metavar="DENSITY", help="such as 1390kg/m3, for its weight"
    )
    sheet.add_argument(
        "--region",
        nargs="+",
        action="append",
        metavar=("LAYER", "NAME=VALUE"),
        help="what is different within the closed curves of a layer or colour: some of thickness=, E=, nu= and "
        "density=; may be given again",
    )
    pull = parser.add_argument_group("what is done")
    pull.add_argument(
        "--strain",
        type=ratio,
        metavar="RATIO",
        help="grip displacement over the length between the grips (default: 20%%, or none where something else is "
        "done); negative to push, -5%%",
    )
    pull.add_argument(
        "--direction",
        type=_direction,
        metavar="y|x|DEGREES",
        help="of the pull: an axis, or an angle from x, counter-clockwise (default: y)",
    )
    pull.add_argument("--shear", type=ratio, metavar="RATIO", help="the same across the pull")
    pull.add_argument(
        "--twist", type=_degrees, metavar="DEGREES", help="turn of the grip about the axis of the pull, right-handed"
    )
    pull.add_argument(
        "--grip",
        type=length,
        metavar="LENGTH",
        help="length of the strips that are held; 0 holds the edges alone (default: 0 where the ends are straight, "
        "else 4%% of the length)",
    )
    pull.add_argument(
        "--lift", nargs=2, action="append", metavar=("PLACE", "LENGTH"), help="lift a place; may be given again"
    )
    pull.add_argument("--push", nargs=2, action="append", metavar=("PLACE", "LENGTH"), help="push a place down")
    pull.add_argument(
        "--hold",
        action="append",
        metavar="PLACE[=AXES]",
        help="hold a place: clamped, or along axes such as z or xz (default: the rim where no grips are)",
    )
    pull.add_argument(
        "--weight", action="store_const", const=9.81, help="let its weight act, from the start; alone with --strain 0"
    )
    pull.add_argument("--cycle", action="store_true", default=None, help="go there and back again")
    work = parser.add_argument_group("the computation")
    work.add_argument(
        "--accuracy",
        choices=("draft", "standard", "fine"),
        help="how much to pay for: stiffness, mesh and residual (default: standard)",
    )
    work.add_argument(
        "--nodes",
        type=whole_number("a budget of nodes", 10),
        metavar="N",
        help="budget of mesh nodes (default: that of the accuracy)",
    )
    work.add_argument(
        "--max-edge", type=positive, metavar="LENGTH", help="longest edge of the mesh, instead of a budget"
    )
    work.add_argument("--stiffness", metavar="NAME", help="plate, facet or shell (default: that of the accuracy)")
    work.add_argument(
        "--imperfection",
        type=length,
        metavar="LENGTH",
        help="height of the imperfection, which is free of stress (default: a tenth of the thickness)",
    )
    work.add_argument(
        "--seed", type=whole_number("a seed", 0), metavar="N", help="of the imperfection (default: 0)"
    )
    out = parser.add_argument_group("what is written")
    out.add_argument("--folder", type=Path, help="where to write (default: ./NAME-stretched)")
    out.add_argument(
        "--compare",
        type=Path,
        metavar="CSV",
        help="a measured curve to lay over the computed one: columns such as 'displacement [mm],force [N]'",
    )
    work.add_argument(
        "--shapes",
        action="store_true",
        default=None,
        help="also look which other shapes the sheet can take at the whole strain, and say which one this is: "
        "shapes.csv, shapes.png; some minutes more",
    )
    add_reading(parser)
    parser.set_defaults(wrong_usage=parser.error)


def run(options: argparse.Namespace) -> int:
    """Stretch a drawing and write the report."""
    import matplotlib

    from kirigami.study.measured import compare, read_measured
    from kirigami.study.report import write_report

    matplotlib.use("Agg")  # files only: no window, no display needed
    say = speaker(options)
    job = _job(options)
    measured = None if options.compare is None else read_measured(options.compare)
    folder: Path = options.folder or Path(f"{Path(str(job.drawing)).stem}-stretched")
    made = not folder.exists()
    make_folder(folder)  # before the work, which would be in vain without it
    try:
        report = job.run(progress=not options.quiet, say=lambda note: say(f"  {in_words_of_the_command(note)}"))
    except (KirigamiError, OSError, KeyboardInterrupt):
        if made:
            with suppress(OSError):
                folder.rmdir()
        raise
    if measured is not None:
        try:
            report.measured = compare(report, measured)
        except KirigamiError as error:  # the computation is not in vain for that
            print(f"kirigami: not compared: {error}", file=sys.stderr)
    say(in_words_of_the_command(report.text()))
    files = write_report(report, folder, lambda words: print(f"kirigami: {words}", file=sys.stderr))
    say(f"Written to {folder}: {', '.join(_names(files, folder))}")
    print_json(options, {"complete": report.complete, **report.numbers, "folder": folder})
    if any(event.kind == "interrupted" for event in report.results.events):
        return 130
    return 0 if report.complete else 1


def _job(options: argparse.Namespace) -> Any:
    """What was asked for: the options, over what a case file says."""
    from kirigami.study.job import Job, is_case, read_case
    from kirigami.study.load_case import LoadCase

    values: dict[str, Any] = read_case(options.drawing) if is_case(options.drawing) else {"drawing": options.drawing}
    given = {name: value for name in SHEET + COMPUTATION if (value := getattr(options, name)) is not None}
    for one, other in (("nodes", "max_edge"), ("max_edge", "nodes")):
        if one in given:  # takes the place of the other in a case that is done again
            values.pop(other, None)
    values |= given
    missing = [f"--{name}" for name in ("thickness", "E") if name not in values]
    if missing:
        options.wrong_usage(f"the following arguments are required: {', '.join(missing)}")
    if options.region:
        made = {layer: _of_region(*pairs) for layer, *pairs in options.region}
        values["regions"] = {**values.get("regions", {}), **made}
    values["reading"] = {**values.get("reading", {}), **reading(options)}
    said: dict[str, Any] = {
        name: value
        for name in ("strain", "direction", "grip", "shear", "twist", "weight", "cycle")
        if (value := getattr(options, name)) is not None
    }
    try:
        if options.lift or options.push:
            moved = [(place, 1, length) for place, length in options.lift or []]
            moved += [(place, -1, length) for place, length in options.push or []]
            said["lift"] = [(place, sign * _length(length)) for place, sign, length in moved]
        if options.hold:
            parts = (place.partition("=") for place in options.hold)
            said["hold"] = [(place, how or "clamp") for place, _, how in parts]
        case = values.get("case")
        values["case"] = LoadCase(**{**(case.values() if case is not None else {}), **said})
    except ModelError as error:
        options.wrong_usage(in_words_of_the_command(str(error)))
    try:
        return Job(**values)
    except ModelError as error:
        if not options.region:
            raise
        options.wrong_usage(in_words_of_the_command(str(error)))


def _of_region(*made: str) -> dict[str, Any]:
    """What is different in a region, as NAME=VALUE says it."""
    return {name: value for name, _, value in (text.partition("=") for text in made)}


def _length(text: str) -> float:
    """A length that is an argument of an option with two."""
    try:
        return quantity("length", "positive")(text)
    except argparse.ArgumentTypeError as error:
        raise ModelError(str(error)) from None


def _degrees(text: str) -> float:
    try:
        angle = float(text.strip().removesuffix("deg").removesuffix("\N{DEGREE SIGN}"))
    except ValueError:
        angle = math.nan
    if not math.isfinite(angle) or abs(angle) > 36000:
        raise argparse.ArgumentTypeError(f"{text!r} is no angle in degrees of at most 100 turns")
    return angle


def _fold_angle(text: str) -> float:
    angle = _degrees(text)
    if not -180 < angle < 180:
        raise argparse.ArgumentTypeError(f"{text!r}: a fold rests at an angle between -180 and 180 degrees, 0 flat")
    return angle


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


def _names(files: list[Path], folder: Path) -> list[str]:
    """Names of the files of the folder, and of its folders in the place of what they hold."""
    parts = [file.relative_to(folder).parts for file in files]
    return list(dict.fromkeys(f"{first}/" if rest else first for first, *rest in parts))
