"""``kirigami info``: what a file holds."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from kirigami.cli.options import add_command, add_reading, in_words_of_the_command, print_json, reading, speaker
from kirigami.errors import GeometryError, KirigamiError
from kirigami.files import whole_file

DESCRIPTION = """\
Say what a drawing (.dxf, .svg, .geojson, .fold) or a results file (.npz) holds: of a drawing what
was read as outline, cuts and folds, what was joined, dropped and assumed, the true size, and a
table of what each layer, colour and line type was taken for, and it draws what it understood, one
colour a role, in NAME-read.png; of results the path that was followed."""

EPILOG = """\
examples:
  kirigami info plate.dxf                  and draw it: plate-read.png
  kirigami info plate.dxf --no-picture
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
        help="where to draw what was understood (default: NAME-read.png; nowhere with --quiet or --json)",
    )
    parser.add_argument("--no-picture", action="store_true", help="draw nothing")
    add_reading(parser)


def run(options: argparse.Namespace) -> int:
    """Say what a file holds."""
    from kirigami.drawing.convert import read_drawing
    from kirigami.io.convert import info, info_of_drawing

    say = speaker(options)
    picture, asked = options.picture or Path(), options.picture is not None
    wanted = not options.no_picture and (asked or not (options.quiet or options.json))
    if options.file.suffix.lower() == ".npz":
        found = info(options.file, **reading(options))
    else:
        drawing = read_drawing(options.file, **reading(options))
        found = info_of_drawing(drawing)
        if wanted:
            picture = picture if picture.name else Path(f"{options.file.stem}-read.png")
            try:
                _draw(drawing, picture)
                found["picture"] = picture
            except (KirigamiError, OSError) as error:
                if asked:
                    raise
                print(f"kirigami: not drawn: {error}", file=sys.stderr)  # what was asked for is the text
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
