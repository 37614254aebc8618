"""``kirigami export``: results and drawings as other kinds of files."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from kirigami.cli.options import add_command, add_reading, print_json, quantity, reading, speaker
from kirigami.words import counted

DESCRIPTION = """\
Turn results or a drawing into other kinds of files, by the endings of their names.

  results (.npz)     .html (a page of its own), .csv (curves), .nc (all arrays), .pvd (ParaView),
                     .png .pdf .svg (a picture), .gif .mp4 (a film; .mp4 needs imageio-ffmpeg),
                     .stl .obj .ply .glb .gltf (the deformed sheet), .fold (facets and fold angles)
  drawings           .dxf .svg (true size, colours, arcs and place as drawn, for the laser cutter),
                     .geojson, .fold (crease pattern)"""

EPILOG = """\
examples:
  kirigami export demo/results.npz page.html curves.csv paraview/sheet.pvd
  kirigami export demo/results.npz stretch.gif half.png --color stress --step 8
  kirigami export demo/results.npz print.stl --thickness 2mm
  kirigami export plate.svg plate.dxf --kerf 0.2mm"""


COLORS = ("height", "displacement", "energy", "stress", "plastic strain", "force", "strain", "none")


def add(commands: Any) -> None:
    """Options of ``kirigami export``."""
    parser = add_command(
        commands,
        "export",
        run,
        help="results or a drawing as another kind of file",
        description=DESCRIPTION,
        epilog=EPILOG,
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="what to turn")
    parser.add_argument("output", type=Path, nargs="+", metavar="OUTPUT", help="what to write")
    parser.add_argument(
        "--kerf",
        type=quantity("length", "not negative"),
        metavar="LENGTH",
        help="of .dxf and .svg: width of the cut; the rim grows and openings shrink by half of it, slits stay",
    )
    shown = parser.add_argument_group("results")
    shown.add_argument(
        "--step", type=int, default=-1, metavar="N", help="step of pictures, surfaces and .fold (default: the last)"
    )
    shown.add_argument(
        "--color", choices=COLORS, metavar="FIELD",
        help=f"of pictures and films: {', '.join(COLORS[:-1])} (of bars) or none (default: height; force of bars)",
    )  # fmt: skip
    shown.add_argument("--view", choices=("top", "3d"), help="of pictures and films (default: 3d of what is in space)")
    shown.add_argument("--frames", type=int, default=40, metavar="N", help="pictures in a film (default: %(default)s)")
    shown.add_argument("--unit", metavar="UNIT", help="of surfaces: mm, in, ... (default: mm in .stl, else m)")
    shown.add_argument(
        "--thickness",
        type=quantity("length", "positive"),
        nargs="?",
        const=True,
        default=False,
        metavar="LENGTH",
        help="surfaces as closed bodies as thick as the sheet, or as said",
    )
    add_reading(parser)


def run(options: argparse.Namespace) -> int:
    """Turn one file into others."""
    import matplotlib

    from kirigami.io.convert import export

    matplotlib.use("Agg")  # files only: no window, no display needed
    say = speaker(options)
    files: list[str] = []
    for output in options.output:
        written = export(
            options.file, output, step=options.step, unit=options.unit, thickness=options.thickness,
            color=options.color, view=options.view, frames=options.frames, kerf=options.kerf or 0.0, **reading(options),
        )  # fmt: skip
        files += map(str, written)
        beside = f" and {counted(len(written) - 1, 'file')} beside it" if len(written) > 1 else ""
        say(f"Written to {written[-1]}{beside}")
    print_json(options, {"files": files})
    return 0
