"""``kirigami export``: results and drawings as other kinds of files."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from kirigami.cli.options import add_command, add_reading, print_json, quantity, reading, speaker

DESCRIPTION = """\
Turn results or a drawing into other kinds of files, by the endings of their names.

  results (.npz)     .html (a page of its own), .csv (curves), .nc (all arrays), .pvd (ParaView),
                     .stl .obj .ply .glb .gltf (the deformed sheet), .fold (facets and fold angles)
  drawings           .dxf .svg (true size, colours, arcs and place as drawn, for the laser cutter),
                     .geojson, .fold (crease pattern)"""

EPILOG = """\
examples:
  kirigami export demo/results.npz page.html curves.csv paraview/sheet.pvd
  kirigami export plate.svg plate.dxf --kerf 0.2mm"""


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
    add_reading(parser)


def run(options: argparse.Namespace) -> int:
    """Turn one file into others."""
    from kirigami.io.convert import export

    say = speaker(options)
    files: list[str] = []
    for output in options.output:
        written = export(options.file, output, kerf=options.kerf or 0.0, **reading(options))
        files += map(str, written)
        beside = f" and {len(written) - 1} files beside it" if len(written) > 1 else ""
        say(f"Written to {written[-1]}{beside}")
    print_json(options, {"files": files})
    return 0
