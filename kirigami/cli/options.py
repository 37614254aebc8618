"""Options that several commands share, and how they speak."""

from __future__ import annotations

import argparse
import json
import math
import re
import shlex
from collections.abc import Callable
from typing import Any

from kirigami import units
from kirigami.errors import ModelError

READING = ("drawn_in", "outline", "cuts", "folds", "ignore", "regions", "tolerance", "part", "frame")
LARGEST = {"length": 1e9, "stress": 1e18, "force": 1e12, "density": 1e9, "ratio": 1e6}  # SI; beyond, it is a slip
WORDS = {"allow_parts=True": "--part 1"}  # what Python calls otherwise
PYTHON = (  # what only a script can do, and what it calls otherwise
    (r"[.;] kirigami\.stiffness\.report\(mesh\) has the numbers; ", "; "),
    (r"[.;] kirigami\.stiffness\.report\(mesh\) has the numbers", ""),
    (r"energy_release\(cut\) converges", "the energy release rate converges (in Python: results.energy_release)"),
    (r"the path so far is in error\.results; another amplitude", "what was found is written; another --imperfection"),
    (r"\bstiffness=['\"](\w+)['\"]", r"--stiffness \1"),
    (r"give its material a density", "say --density"),
    (r"give another path, or delete the file", "give another --folder, or delete the file"),
    (r"in the unit of the sheet", "in metres"),  # which all is that a command computes
    (r" \(force times length\)", " J"),
    (r"^(?:stretch|LoadCase|Job(?:\.\w+)?|export|to_surface|to_html|animate|plot|units(?:\.\w+)?): ", ""),
    (r"^(?:accuracy|imperfect|reading a drawing|writing a drawing|Sheet\.mesh): ", ""),
)


def add_command(
    commands: Any, name: str, run: Callable[[argparse.Namespace], int], *, help: str, description: str, epilog: str
) -> argparse.ArgumentParser:
    """A command with what all commands have: --quiet and --json; line breaks of the texts are kept."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name, help=help, description=description, epilog=epilog, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="say nothing but warnings and errors")
    parser.add_argument("--json", action="store_true", help="print the numbers as JSON, in SI units, instead of words")
    parser.set_defaults(run=run)
    return parser


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Options that tell how a drawing is to be read."""
    group = parser.add_argument_group(
        "reading the drawing",
        "Layers are told apart by their names ('outline', 'cuts', 'folds', ... in several languages)\n"
        "and units are those of the file, unless said here. LAYER options may be given more than once.",
    )
    group.add_argument("--drawn-in", metavar="UNIT", help="unit of the drawing: mm, cm, in, ...")
    for name, what in (
        ("outline", "the rim of the sheet"), ("cuts", "what is cut"), ("folds", "what is folded, not cut"),
        ("ignore", "what to leave out"), ("regions", "closed curves that bound regions, not cut"),
    ):  # fmt: skip
        group.add_argument(f"--{name}", action="append", metavar="LAYER", help=f"layer or colour of {what}")
    group.add_argument(
        "--tolerance",
        type=_tolerance,
        metavar="SHARE",
        help="join ends nearer than this share of the size, or than this length, such as 0.1mm (1e-4)",
    )
    part, frame = whole_number("a part", 1), whole_number("a frame", 0)
    group.add_argument(
        "--part", type=part, metavar="NUMBER", help="which part to take, where there are several; 1 is the largest"
    )
    group.add_argument("--frame", type=frame, metavar="NUMBER", help="which frame of a FOLD file to read, from 0")


def in_words_of_the_command(text: str) -> str:
    """A message with the options it names, such as `tolerance=3e-4`, as they are written on the command line."""

    def option(match: re.Match[str]) -> str:
        if match[0].strip("`") in WORDS:
            return WORDS[match[0].strip("`")]
        value = (match[2] or "").strip("\"'")
        name = f"--{match[1].replace('_', '-')}"
        return f"{name} {shlex.quote(value)}" if match[2] else name

    of_sheets = ("grip", "thickness", "fold_stiffness", "fold_angle", "kerf")
    names = "|".join((*READING, "allow_parts", "max_edge", "nodes", *of_sheets))
    told = re.sub(rf"`({names})(?:=([^`]*))?`", option, text)
    for pattern, words in PYTHON:
        told = re.sub(pattern, words, told)
    return told


def _tolerance(text: str) -> float | str:
    """A share of the size, or a length with its unit, which the reader understands; what it is not is wrong usage."""
    try:
        share = float(text)
    except ValueError:
        quantity("length", "positive")(text)
        return text
    if not 0 < share < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no share between 0 and 1, nor a length such as 0.1mm")
    return share


def reading(options: argparse.Namespace) -> dict[str, Any]:
    """The options of the reader that were given."""
    return {name: value for name in READING if (value := getattr(options, name)) is not None}


def quantity(kind: str, sign: str = "any") -> Callable[[str], float]:
    """A type for argparse: a quantity with its unit, in SI units; what it is not is wrong usage.

    `sign` is "any", "positive" or "not negative".
    """

    def parsed(text: str) -> float:
        try:
            value = units.parse(text, kind)
        except ModelError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
        if (sign == "positive" and not value > 0) or (sign == "not negative" and value < 0):
            raise argparse.ArgumentTypeError(f"{text!r}: must be {sign}")
        if abs(value) > LARGEST[kind]:
            raise argparse.ArgumentTypeError(f"{text!r}: no sheet has that; is the unit right?")
        return value

    return parsed


def whole_number(what: str, least: int) -> Callable[[str], int]:
    """A type for argparse: a whole number, not below `least`; what it is not is wrong usage.

    `what` says what for, as the end of a sentence: "a budget of nodes".
    """

    def parsed(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            number = least - 1
        if number < least:
            raise argparse.ArgumentTypeError(f"{text!r}: {what} is a whole number of at least {least}")
        return number

    return parsed


def speaker(options: argparse.Namespace) -> Callable[[str], None]:
    """Where words for people go: to stdout, or nowhere where they are not wanted."""
    return _silent if options.quiet or options.json else print


def print_json(options: argparse.Namespace, content: dict[str, Any]) -> None:
    """Print numbers for programs, if asked to; what is not finite becomes null, which every reader of JSON knows."""
    if options.json:
        finite = {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in content.items()}
        print(json.dumps(finite, indent=1, default=str))


def _silent(words: str) -> None:
    """In the place of print."""
