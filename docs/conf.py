"""The documentation site: ``make docs``, or ``sphinx-build -W docs docs/_build/html``."""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "tools"))

import notebooks  # noqa: E402
import reference  # noqa: E402

import kirigami  # noqa: E402
from kirigami.cli import main  # noqa: E402

# Pages are written to be read where they lie. What the site has in another form is made here: tutorials are scripts,
# shown as notebooks that are run while it is built; each name of the reference has a page of its own.
notebooks.convert(HERE / "tutorials")
def of_the_house(path: str, *links: tuple[str, str]) -> str:
    """A page that lies elsewhere in the repository, with its links as from here."""
    text = (HERE.parent / path).read_text(encoding="utf-8")
    for pattern, there in links:
        text = re.sub(pattern, there, text)
    return text


MADE = {
    "api.md": reference.as_directives((HERE / "reference.md").read_text(encoding="utf-8")),
    "changelog.md": of_the_house("CHANGELOG.md"),
    "tutorials.md": of_the_house("tutorials/README.md", (r"\]\((\d\d_\w+)\.py\)", r"](tutorials/\1)")),
    "gallery.md": of_the_house(
        "examples/README.md", (r"\]\((\w+\.py)\)", r"](../examples/\1)"), (r"\]\(\.\./docs/", "](")
    ),
}
for page, text in MADE.items():
    if not (HERE / page).exists() or (HERE / page).read_text(encoding="utf-8") != text:
        (HERE / page).write_text(text, encoding="utf-8")

project = "kirigami"
author = "the authors of kirigami"
release = version = kirigami.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "myst_nb",
]
exclude_patterns = ["_build", "generated/.*", "reference.md"]
templates_path = ["_templates"]

default_role = "code"  # a name in single backticks is code
autosummary_generate = True
autodoc_typehints = "none"  # types and shapes are in the text of the docstrings
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_param = False  # types are plain words, not names to link to
napoleon_use_rtype = False
napoleon_use_ivar = True  # attributes are described once, with their class

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 2
nb_execution_mode = "cache"
nb_execution_cache_path = str(HERE / "_build" / "notebooks")
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True

html_theme = "furo"
html_title = f"kirigami {version}"
html_show_copyright = False
html_show_sphinx = False
html_copy_source = False


def formulas_as_written(app: Any, what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    """Show indented paragraphs in the text at the head of a module as they stand: they are formulas."""
    if what != "module":
        return
    shown: list[str] = []
    formula = False
    for line in lines:
        indented = line.startswith("    ")
        if line and indented != formula:
            if indented:
                shown += ["", ".. code-block:: none", ""]
            elif shown[-1]:
                shown.append("")
            formula = indented
        shown.append(line if indented else line.replace("|", "\\|"))
    lines[:] = shown


def attributes_one_by_one(app: Any, what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    """Attributes that a docstring describes together ("mesh, rung : ...") each by itself.

    Parameters may stand together; of attributes napoleon takes all but the last one for a type.
    """
    shown: list[str] = []
    inside, place = False, 0
    while place < len(lines):
        line = lines[place]
        if set(line) == {"-"} and shown:
            inside = shown[-1] == "Attributes"
        if not (inside and (names := re.fullmatch(r"(\w+(?:, \w+)+)( : .*)?", line))):
            shown.append(line)
            place += 1
            continue
        end = place + 1
        while end < len(lines) and (not lines[end] or lines[end].startswith(" ")):
            end += 1
        for single in names[1].split(", "):
            shown += [single + (names[2] or ""), *lines[place + 1 : end]]
        place = end
    lines[:] = shown


# What the site has beyond the files, which are to be read where they lie and hold no directives.
PAGES = """tutorials gallery overview scope drawings command_line maker_session formulas shell yield motion
    self_contact cells design speed validation api developer licences changelog""".split()
TREES = {
    "index": "\n".join(["```{toctree}", ":hidden:", "", *PAGES, "```"]),
    "tutorials": "\n".join(["```{toctree}", ":glob:", ":hidden:", ":titlesonly:", "", "tutorials/*", "```"]),
}


def all_options() -> str:
    """What the command line says of each command."""
    os.environ["COLUMNS"] = "100"
    parts = ["## All options, as the program prints them"]
    for command in ("demo", "info", "mesh", "stretch", "accuracy", "export"):
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.suppress(SystemExit):
            main([command, "--help"])
        parts.append(f"### kirigami {command}\n\n```text\n{said.getvalue()}```")
    return "\n\n".join(parts)


def names_linked(text: str) -> str:
    """Public names in a page, outside of code, as links to what the reference says of them."""
    parts = re.split(r"(^```.*?^```$)", text, flags=re.DOTALL | re.MULTILINE)
    return "".join(
        part if number % 2 else re.sub(r"`kg\.(\w+)`", r"{py:obj}`kg.\1 <kirigami.\1>`", part)
        for number, part in enumerate(parts)
    )


# Where links of the files lead on the site.
LINKS = [
    (r"\]\(\.\./tutorials/(\w+)\.py\)", r"](tutorials/\1)"),
    (r"\]\(\.\./tutorials/README\.md\)", "](tutorials.md)"),
    (r"\]\(\.\./examples/README\.md\)", "](gallery.md)"),
    (r"\]\(\.\./CHANGELOG\.md\)", "](changelog.md)"),
    (r"\]\(\.\./docs/", "](../"),  # from tutorials
    (r"\]\((\.\./)?reference\.md", r"](\1api.md"),
]


def as_on_the_site(app: Any, page: str, source: list[str]) -> None:
    """Links between files, as a code host follows them, become links between pages, and names ones to the reference."""
    for pattern, there in LINKS:
        source[0] = re.sub(pattern, there, source[0])
    if page in TREES:
        source[0] += f"\n{TREES[page]}\n"
    if page == "command_line":
        source[0] += f"\n{all_options()}\n"
    if "/" not in page and page != "api":
        source[0] = names_linked(source[0])


def setup(app: Any) -> None:
    app.connect("autodoc-process-docstring", attributes_one_by_one, priority=400)  # before napoleon reads them
    app.connect("source-read", as_on_the_site)
    app.connect("autodoc-process-docstring", formulas_as_written)
