"""``kirigami info``: what a file holds."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from kirigami.cli.options import add_command, add_reading, in_words_of_the_command, print_json, reading, speaker
from kirigami.errors import GeometryError
from kirigami.files import whole_file

DESCRIPTION = """\
Say what a drawing (.dxf, .svg, .geojson, .fold) or a results file (.npz) holds: of a drawing what
was read as outline, cuts and folds, what was joined, dropped and assumed, the true size, and a
table of what each layer, colour and line type was taken for; of results the path that was
followed."""

EPILOG = """\
examples:
  kirigami info plate.dxf
  kirigami info plate.svg --picture        and draw it
  kirigami info plate.svg --cuts red --json
  kirigami info plate-stretched/results.npz"""


def add(commands: Any) -> None:
    """Options of ``kirigami info``."""
    parser = add_command(
        commands, "info", run, help="what a drawing or a results file holds", description=DESCRIPTION, epilog=EPILOG
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="the file")
    parser.add_argument(
        "--picture",
        type=Path,
        nargs="?",
        const=Path(),
        metavar="PNG",
        help="draw what was understood of a drawing, one colour a role (default name: NAME-read.png)",
    )
    add_reading(parser)


def run(options: argparse.Namespace) -> int:
    """Say what a file holds."""
    from kirigami.drawing.convert import read_drawing
    from kirigami.io.convert import info, info_of_drawing

    say = speaker(options)
    if options.picture is None or options.file.suffix.lower() == ".npz":
        found = info(options.file, **reading(options))
    else:
        drawing = read_drawing(options.file, **reading(options))
        found = info_of_drawing(drawing)
        found["picture"] = options.picture if options.picture.name else Path(f"{options.file.stem}-read.png")
        _draw(drawing, found["picture"])
    found["text"] = in_words_of_the_command(found["text"])
    say(found["text"])
    if "picture" in found:
        say(f"Drawn in {found['picture']}")
    print_json(options, found)
    return 0


def _draw(drawing: Any, picture: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")  # files only: no window, no display needed
    from matplotlib import pyplot

    from kirigami.plot.drawing_picture import plot_drawing

    figure = plot_drawing(drawing).figure
    try:
        with whole_file(picture) as unfinished:
            figure.savefig(unfinished, dpi=160, bbox_inches="tight", format=picture.suffix.lstrip(".") or "png")
    except ValueError as error:
        raise GeometryError(f"{picture}: no format for pictures ({error})") from None
    finally:
        pyplot.close(figure)
