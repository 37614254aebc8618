"""Write docs/formulas.md from the texts at the head of the files that make forces: ``python tools/formulas.py``."""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "formulas.md"
SECTIONS = {
    "Bars": ["elements.bar"],
    "Bending hinges": ["elements.bend_hinge"],
    "Three-node torsion springs": ["elements.torsion_spring"],
    "Stiffness of bars and hinges of a sheet": ["stiffness"],
    "Flat facets": ["elements.facet"],
    "Pressure, flow, and strain of its own": ["model.pressure", "model.flow_pressure", "model.actuate"],
    "Rigid grips": ["model.grip", "primitives.rotation"],
    "Springs to the ground": ["effects.spring"],
    "Limits on angles": ["effects.angle_limit"],
    "Contact with rigid surfaces, friction": ["effects.contact", "effects.friction", "effects.moving", "post.friction"],
}
HEAD = """\
# How forces are made

Each kind of element lives in one file that holds its energy, gradient and Hessian. This page is made of the texts
at the head of those files by `python tools/formulas.py`. Shell facets have [a page of their own](shell.md), as have
[yield](yield.md) and [a sheet that touches itself](self_contact.md).
"""


def text_of(module: str) -> str:
    """The text at the head of a module as Markdown; indented paragraphs are formulas and shown as they stand."""
    text = (importlib.import_module(f"kirigami.{module}").__doc__ or "").strip()
    text = re.sub(r":(?:class|func|meth):`~?kirigami\.(\w+)`", r"`kg.\1`", text)
    text = re.sub(r":mod:`([^`]+)`", lambda role: f"[`{role[1]}`]({file_of(role[1])})", text)
    text = re.sub(r"``(.+?)``", r"`\1`", text)
    shown = []
    for paragraph in re.split(r"\n\n+", text):
        formula = all(line.startswith("    ") for line in paragraph.splitlines())
        shown.append(f"```\n{inspect.cleandoc(paragraph)}\n```" if formula else _plain(paragraph))
    return "\n\n".join(shown)


def file_of(module: str) -> str:
    """Where the file of a module is, from the page; some are also to be had under a shorter name."""
    path = Path(importlib.import_module(module).__file__ or "")
    return f"../{path.relative_to(ROOT).as_posix()}"


def _plain(paragraph: str) -> str:
    """A paragraph whose indices at brackets are no emphasis."""
    parts = re.split(r"(`[^`]*`|\]\([^)]*\))", paragraph)
    return "".join(part if number % 2 else re.sub(r"(?<!\w)_", r"\_", part) for number, part in enumerate(parts))


def page() -> str:
    """The text of the page."""
    parts = [HEAD]
    for heading, modules in SECTIONS.items():
        parts.append(f"## {heading}\n")
        parts += [f"{text_of(module)}\n\n[source]({file_of(f'kirigami.{module}')})\n" for module in modules]
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
