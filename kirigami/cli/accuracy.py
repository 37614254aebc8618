"""``kirigami accuracy``: what accuracy costs in time, on a drawing or on a built-in sheet."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from kirigami.cli.options import add_command, add_reading, print_json, quantity, reading, speaker
from kirigami.files import make_folder, whole_file

DESCRIPTION = """\
Stretch one sheet on several meshes with every rung of accuracy, from bars and hinges to shell
facets, and compare errors with seconds. Without a drawing it takes a built-in strip with one slit.

Writes a folder: study.csv (every run), study.md (a table to copy), study.png (error against
seconds). Run again after an interruption, it goes on where it was."""

EPILOG = """\
examples:
  kirigami accuracy
  kirigami accuracy plate.dxf --thickness 0.1mm --E 3.5GPa --strain 5% --sizes 8mm 5mm 3mm
  kirigami accuracy plate.dxf --thickness 0.1mm --E 3.5GPa --reference shell.csv --error 2%

A reference file has the columns load_factor and any of force, open_area, height (and force_error
and its kin, if these are known). Without one, the limit of the shell rung on finer meshes is the
reference. Runs that end in another shape are told and not compared."""


def add(commands: Any) -> None:
    """Options of ``kirigami accuracy``."""
    length, stress, ratio = (quantity(kind, "positive") for kind in ("length", "stress", "ratio"))
    parser = add_command(
        commands, "accuracy", run, help="compare error with time", description=DESCRIPTION, epilog=EPILOG
    )
    parser.add_argument("drawing", type=Path, nargs="?", metavar="DRAWING", help="the file")
    parser.add_argument("--thickness", type=length, default=5e-4, metavar="LENGTH", help="default: 0.5 mm")
    parser.add_argument("--E", type=stress, default=3.5e9, metavar="STRESS", help="default: 3.5 GPa")
    parser.add_argument("--nu", type=quantity("ratio"), default=0.34, metavar="RATIO", help="default: %(default)s")
    parser.add_argument(
        "--strain", type=quantity("ratio"), default=0.01, metavar="RATIO", help="strain to reach (default: 1%%)"
    )
    parser.add_argument("--direction", choices=("y", "x"), default="y", help="of the pull (default: %(default)s)")
    parser.add_argument(
        "--sizes",
        type=length,
        nargs="+",
        metavar="LENGTH",
        help="largest mesh edges (default: a fifth, a seventh and a tenth of the shorter side)",
    )
    parser.add_argument(
        "--stiffness", nargs="+", default=["plate", "facet", "shell"], metavar="RUNG", help="default: plate facet shell"
    )
    parser.add_argument(
        "--tol", type=ratio, nargs="+", default=[1e-8], metavar="RATIO", help="relative residuals (default: 1e-8)"
    )
    parser.add_argument("--reference", type=Path, metavar="CSV", help="values to compare with")
    parser.add_argument(
        "--error", type=ratio, default=0.05, metavar="RATIO", help="error to recommend for (default: 5%%)"
    )
    parser.add_argument("--folder", type=Path, default=Path("accuracy"), help="where to write (default: %(default)s)")
    add_reading(parser)


def run(options: argparse.Namespace) -> int:
    """Run the study and write table and picture."""
    import shapely

    import kirigami as kg
    from kirigami.drawing.convert import read_drawing
    from kirigami.drawing.drawing import Drawing
    from kirigami.study.stretch import pulled_sheet

    say = speaker(options)
    if options.drawing is None:
        slit = shapely.LineString([(0.02, 0.1), (0.08, 0.1)])
        drawing = Drawing(shapely.box(0, 0, 0.1, 0.2), (slit,), unit="m")
    else:
        drawing = read_drawing(options.drawing, **{**reading(options), "unit": "m"})
    sheet = drawing.sheet(options.thickness, kg.Material(E=options.E, nu=options.nu))
    xmin, ymin, xmax, ymax = sheet.bounds
    sizes = options.sizes or [min(xmax - xmin, ymax - ymin) / count for count in (5, 7, 10)]

    def case(max_edge: float, stiffness: str) -> tuple[kg.Model, list[kg.Node], str]:
        model, nodes = pulled_sheet(sheet, max_edge, options.direction, options.strain, stiffness)
        return model, nodes, options.direction

    make_folder(options.folder)
    study = kg.study.accuracy(
        case,
        sizes,
        path=options.folder / "study",
        stiffness=options.stiffness,
        tolerances=options.tol,
        reference=options.reference,
        progress=not options.quiet,
    )
    study = replace(study, scale=sheet.scale)
    with whole_file(options.folder / "study.md") as unfinished:
        unfinished.write_text(f"{study}\n", encoding="utf-8")
    with whole_file(options.folder / "study.png") as unfinished:
        study.plot().savefig(unfinished, dpi=150)
    say(str(study))
    advice = [study.recommend(options.error, name) for name in ("force", "open_area", "height")]
    for line in advice:
        say(line)
    say(f"Written to {options.folder}: study.csv, study.md, study.png")
    print_json(options, {"runs": len(study.table), "failed": len(study.table.failed), "advice": advice})
    return 0
