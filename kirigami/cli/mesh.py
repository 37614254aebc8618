"""``kirigami mesh``: the mesh of a drawing."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from kirigami.cli.options import add_command, add_reading, print_json, quantity, reading, speaker
from kirigami.scale import Scale
from kirigami.words import counted

DESCRIPTION = """\
Mesh a drawing with triangles, open along its slits, and say how good the mesh is. With --output,
write it as .fold or as any ending that meshio writes triangles to: .vtu, .stl, .msh, .inp, ..."""

EPILOG = """\
examples:
  kirigami mesh plate.dxf --max-edge 2mm
  kirigami mesh plate.svg -o plate.vtu"""


def add(commands: Any) -> None:
    """Options of ``kirigami mesh``."""
    parser = add_command(
        commands, "mesh", run, help="mesh a drawing, and write the mesh", description=DESCRIPTION, epilog=EPILOG
    )
    parser.add_argument("drawing", type=Path, metavar="DRAWING", help="the file: .dxf, .svg, .geojson or .fold")
    parser.add_argument(
        "--max-edge",
        type=quantity("length", "positive"),
        metavar="LENGTH",
        help="such as 2mm (default: chosen within 4,000 nodes)",
    )
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="where to write the mesh, in metres")
    add_reading(parser)


def run(options: argparse.Namespace) -> int:
    """Mesh a drawing."""
    from kirigami.io.convert import mesh_drawing

    mesh = mesh_drawing(options.drawing, options.max_edge, options.output, **reading(options))
    say = speaker(options)
    numbers = {
        "nodes": len(mesh.nodes),
        "facets": len(mesh.triangles),
        "cuts": len(mesh.cuts),
        "area": float(mesh.facet_areas.sum()),
        "longest_edge": float(mesh.edge_lengths.max()),
        "shortest_edge": float(mesh.edge_lengths.min()),
        "smallest_angle": float(mesh.min_angle),
        "output": options.output,
    }
    scale = Scale.of(mesh.size)
    shortest, longest = (scale.show(numbers[name], "length") for name in ("shortest_edge", "longest_edge"))
    say(f"nodes {numbers['nodes']}, facets {numbers['facets']}, cuts {numbers['cuts']}")
    say(f"edges {shortest} to {longest}, smallest angle {counted(numbers['smallest_angle'], 'degree', spec='.3g')}")
    if mesh.sizing is not None:
        say(str(mesh.sizing))
    say(f"area {scale.show(numbers['area'], 'area', 6)}")
    if options.output:
        say(f"Written to {options.output}")
    print_json(options, numbers)
    return 0
