"""The command line: ``kirigami demo``, ``stretch``, ``accuracy``, ``mesh``, ``info`` and ``export``.

A command is a module with two functions: ``add`` adds its options to the parser, and ``run`` does the work and returns
the exit code. Exit codes: 0 done, 1 an error of this package or of a file (said in one sentence) or a path that ended
early, 2 wrong usage, 130 interrupted. What was asked for goes to stdout, everything else to stderr.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
import warnings
from collections.abc import Sequence
from typing import Any, NoReturn

import kirigami as kg
from kirigami.cli import accuracy, demo, export, info, mesh, stretch
from kirigami.cli.options import in_words_of_the_command
from kirigami.errors import nearest_name

DESCRIPTION = """\
Mechanics of cut sheets.

Draw an outline and cuts, clamp the sheet, pull, twist, lift: kirigami follows it through buckling
and snapping, and says what force that takes, what shape comes of it, and how far both can be
trusted."""

EPILOG = """\
examples:
  kirigami demo                            stretch a built-in sheet; pictures and numbers in ./demo
  kirigami stretch plate.dxf --thickness 0.1mm --E 3.5GPa --strain 20%
                                           stretch your own; report in ./plate-stretched
  kirigami accuracy plate.dxf --thickness 0.1mm --E 3.5GPa
                                           error and seconds of every rung on it
  kirigami info plate.svg                  what is outline, cut and fold, and how large
  kirigami mesh plate.dxf -o plate.vtu     its mesh, for a look or for another program
  kirigami export results.npz page.html    results as a page, table, surface, ParaView files

'kirigami COMMAND --help' explains a command. In Python: import kirigami as kg; help(kg)."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Words after the program's name; None takes them from the command line.

    Examples
    --------
    >>> from kirigami.cli import main
    >>> main(["--version"])
    Traceback (most recent call last):
    SystemExit: 0
    """
    try:
        try:
            return _run(arguments)
        finally:
            sys.stdout.flush()
    except BrokenPipeError:  # whoever read the words has enough of them
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _run(arguments: Sequence[str] | None) -> int:
    """Run the command line; what its reader does not want to hear is left to the caller."""
    parser = make_parser()
    options = parser.parse_args(arguments)
    if options.command is None:
        parser.print_help(sys.stderr)
        return 2
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _say_warning
            return int(options.run(options))
    except kg.KirigamiError as error:
        print(f"kirigami: {in_words_of_the_command(str(error))}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        raise
    except OSError as error:
        where = f": {error.filename}" if error.filename else ""
        print(f"kirigami: {error.strerror or error}{where}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("kirigami: interrupted", file=sys.stderr)
        return 130


def make_parser() -> argparse.ArgumentParser:
    """The parser with all commands."""
    parser = _Parser(
        prog="kirigami", description=DESCRIPTION, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--version", action="version", version=f"kirigami {kg.__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    for command in (demo, stretch, accuracy, mesh, info, export):
        command.add(commands)
    return parser


class _Parser(argparse.ArgumentParser):
    """Takes quantities below zero, `--strain -5%`, and answers a mistyped command or option with the nearest one; so do
    the commands, whose parsers are like it."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        # By itself argparse takes -5 for a value, and -5% or -5mm for an option that is not there.
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def error(self, message: str) -> NoReturn:
        mistyped = re.search(r"invalid choice: '([^']*)'|unrecognized arguments: (--[\w-]+)", message)
        near = nearest_name(mistyped[1] or mistyped[2], self._names(bool(mistyped[2]))) if mistyped else None
        super().error(f"{message}: did you mean {near}?" if near else message)

    def _names(self, options: bool) -> set[str]:
        """Options of this parser and its commands, or else what may be chosen."""
        names: set[str] = set()
        for action in self._actions:
            names.update(action.option_strings if options else map(str, action.choices or ()))
            if isinstance(action.choices, dict):
                names.update(*(command._names(options) for command in action.choices.values()))
        return names


def _say_warning(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
    if issubclass(category, (DeprecationWarning, PendingDeprecationWarning)):
        return  # between libraries; nothing a user of the command could do
    words = in_words_of_the_command(str(message))
    print(f"kirigami: {'' if issubclass(category, kg.KirigamiWarning) else 'warning: '}{words}", file=sys.stderr)
