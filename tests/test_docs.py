"""The reference of the documentation site lists every public name, and only names that exist."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from typing import Any

import kirigami as kg

REFERENCE = Path(__file__).resolve().parent.parent / "docs" / "reference.md"


def listed() -> list[str]:
    blocks = re.findall(r"```\{eval-rst\}\n(.*?)```", REFERENCE.read_text(encoding="utf-8"), re.DOTALL)
    return [line.strip() for block in blocks for line in block.splitlines() if re.fullmatch(r"   [\w.]+", line)]


def test_every_public_name_is_listed_once() -> None:
    names = listed()
    assert len(set(names)) == len(names)
    missing = set(kg.__all__) - {"__version__", *(name.split(".")[0] for name in names)}
    assert not missing, f"public names that the reference leaves out: {sorted(missing)}"


def test_every_listed_name_exists_and_says_what_it_is() -> None:
    for name in listed():
        found: Any = kg
        for position, part in enumerate(name.split("."), start=1):
            try:
                found = getattr(found, part)
            except AttributeError:
                found = importlib.import_module("kirigami." + ".".join(name.split(".")[:position]))
        assert found.__doc__, name
