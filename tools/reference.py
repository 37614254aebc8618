"""Fill the tables of docs/reference.md with the first sentence of every docstring: ``python tools/reference.py``.

A new public name needs a row ``| `Name` | |`` under its subject; the sentence comes from its docstring.
"""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from typing import Any

import kirigami as kg

REFERENCE = Path(__file__).resolve().parent.parent / "docs" / "reference.md"
ROW = re.compile(r"^\| `([\w.]+)` \|.*\|$", re.MULTILINE)


def names() -> list[str]:
    """All names of the reference, in order."""
    return ROW.findall(REFERENCE.read_text(encoding="utf-8"))


def found(name: str) -> Any:
    """What a name of the reference stands for."""
    item: Any = kg
    for position, part in enumerate(name.split("."), start=1):
        try:
            item = getattr(item, part)
        except AttributeError:
            item = importlib.import_module("kirigami." + ".".join(name.split(".")[:position]))
    return item


def sentence(name: str) -> str:
    """The first sentence of its docstring, in plain words of Markdown."""
    text = " ".join((found(name).__doc__ or "").strip().partition("\n\n")[0].split())
    text = re.sub(r":\w+:`~?([^`]+)`", lambda role: f"`{role[1].rpartition('.')[2]}`", text)
    return re.sub(r"``(.+?)``", r"`\1`", text).replace("|", "\\|")


def filled(text: str) -> str:
    """The page with the sentences as the docstrings have them."""
    return ROW.sub(lambda row: f"| `{row[1]}` | {sentence(row[1])} |", text)


def as_directives(text: str) -> str:
    """The page with an autosummary in the place of each table, for the site."""
    lines, inside = [], False
    for line in text.splitlines():
        row = ROW.match(line)
        if line.startswith("| name |"):
            lines += ["```{eval-rst}", ".. currentmodule:: kirigami", ".. autosummary::", "   :toctree: generated"]
            lines += ["   :nosignatures:", ""]
            inside = True
        elif inside and row:
            lines.append(f"   {row[1]}")
        elif inside and line.startswith("| ---"):
            continue
        else:
            lines += ["```"] * inside + [line]
            inside = False
    return "\n".join([*lines, *["```"] * inside, ""])


if __name__ == "__main__":
    REFERENCE.write_text(filled(REFERENCE.read_text(encoding="utf-8")), encoding="utf-8")
