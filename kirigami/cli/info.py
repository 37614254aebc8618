"""``kirigami info``: what a file holds."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from kirigami.cli.options import add_command, add_reading, in_words_of_the_command, print_json, reading, speaker

DESCRIPTION = """\
Say what a drawing (.dxf, .svg, .geojson, .fold) or a results file (.npz) holds: of a drawing what
was read as outline, cuts and folds, what was joined, dropped and assumed, and the true size; of
results the path that was followed."""

EPILOG = """\
examples:
  kirigami info plate.dxf
  kirigami info plate.svg --cuts red --json
  kirigami info plate-stretched/results.npz"""


def add(commands: Any) -> None:
    """Options of ``kirigami info``."""
    parser = add_command(
        commands, "info", run, help="what a drawing or a results file holds", description=DESCRIPTION, epilog=EPILOG
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="the file")
    add_reading(parser)


def run(options: argparse.Namespace) -> int:
    """Say what a file holds."""
    from kirigami.io.convert import info

    found = info(options.file, **reading(options))
    found["text"] = in_words_of_the_command(found["text"])
    speaker(options)(found["text"])
    print_json(options, found)
    return 0
