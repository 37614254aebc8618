"""The documentation can be read where it lies, names what there is, and leads to what exists."""

from __future__ import annotations

import ast
import builtins
import configparser
import csv
import doctest
import re
import sys
from pathlib import Path

import pytest

import kirigami as kg

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tools"))

import formulas  # noqa: E402
import reference  # noqa: E402

PAGES = sorted([*(ROOT / "docs").glob("*.md"), ROOT / "README.md", *ROOT.glob("[te]*/README.md")])
MADE = ("api.md", "changelog.md", "tutorials.md", "gallery.md")  # by docs/conf.py
WRITTEN = [page for page in PAGES if page.name not in MADE]


def test_every_public_name_is_listed_once() -> None:
    names = reference.names()
    assert len(set(names)) == len(names)
    missing = set(kg.__all__) - {"__version__", *(name.split(".")[0] for name in names)}
    assert not missing, f"public names that docs/reference.md leaves out: {sorted(missing)}"


def test_the_reference_says_what_the_docstrings_say() -> None:
    text = reference.REFERENCE.read_text(encoding="utf-8")
    assert reference.filled(text) == text, "run: python tools/reference.py"
    assert all(reference.sentence(name) for name in reference.names())


@pytest.mark.parametrize("page", WRITTEN, ids=[page.name for page in WRITTEN])
def test_links_lead_somewhere(page: Path) -> None:
    """As a code host follows them: to files of the repository."""
    for there, heading in re.findall(r"\]\(([^)#\s]+)(?:#([^)]*))?\)", page.read_text(encoding="utf-8")):
        if re.match(r"https?:", there):
            continue
        assert (page.parent / there).exists(), f"{page.name}: {there}"
        if heading:
            titles = re.findall(r"^#+ (.*)$", (page.parent / there).read_text(encoding="utf-8"), re.MULTILINE)
            anchors = [re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles]
            assert heading in anchors, f"{page.name}: {there} has no heading {heading}"


@pytest.mark.parametrize("page", [*WRITTEN, ROOT / "CHANGELOG.md"], ids=lambda page: page.name)
def test_headings_hold_no_links(page: Path) -> None:
    """They stand in the contents of the site, where a link to a file of the repository ends the build."""
    assert not re.findall(r"^#+ .*\]\(.*$", page.read_text(encoding="utf-8"), re.MULTILINE)


@pytest.mark.parametrize("page", WRITTEN, ids=[page.name for page in WRITTEN])
def test_pages_say_something_without_a_build(page: Path) -> None:
    """What a code host shows of a page is more than a headline, and none of it was written for the site's builder."""
    written = page.read_text(encoding="utf-8")
    text = re.sub(r"^```.*?^```", "", written, flags=re.DOTALL | re.MULTILINE)
    assert len(text.split()) > 40
    assert not re.search(r"^```\{|^---$|\{[\w:]+\}`", written, re.MULTILINE)


def test_the_formulas_are_those_at_the_head_of_the_files() -> None:
    assert formulas.PAGE.read_text(encoding="utf-8") == formulas.page(), "run: python tools/formulas.py"


def test_formulas_of_pages_are_formulas_on_the_site() -> None:
    """They stood there as TeX: the syntax has to be asked for, which a list of other syntaxes had switched off."""
    parts = [re.sub(r"^```.*?^```", "", page.read_text(), flags=re.DOTALL | re.MULTILINE) for page in WRITTEN]
    assert any(re.search(r"\$[^$\n]+\$", part) for part in parts)
    assert re.search(r'^myst_enable_extensions = .*"dollarmath"', (ROOT / "docs" / "conf.py").read_text(), re.MULTILINE)


def test_every_page_stands_in_the_contents_of_the_site() -> None:
    (listed,) = re.findall(r'^PAGES = """(.*?)"""', (ROOT / "docs" / "conf.py").read_text(), re.DOTALL | re.MULTILINE)
    there = {page.stem for page in WRITTEN if page.parent.name == "docs"} - {"index", "reference"}
    assert set(listed.split()) == there | {page.partition(".")[0] for page in MADE}


def test_tutorials_are_numbered_and_listed() -> None:
    scripts = [script.name for script in sorted((ROOT / "tutorials").glob("*.py"))]
    numbers = [int(name[:2]) for name in scripts]
    assert numbers == list(range(1, len(numbers) + 1))
    text = (ROOT / "tutorials" / "README.md").read_text(encoding="utf-8")
    assert re.findall(r"\]\((\d\d_\w+\.py)\)", text) == scripts
    for name in scripts:
        first = (ROOT / "tutorials" / name).read_text(encoding="utf-8").splitlines()[1]
        assert first.startswith(f"# # {int(name[:2])}. ")


def _examples() -> dict[str, ast.Module]:
    """The example of each docstring of the package, by place."""
    found = {}
    for file in sorted((ROOT / "kirigami").rglob("*.py")):
        for item in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(item, ast.Module | ast.ClassDef | ast.FunctionDef):
                lines = doctest.DocTestParser().get_examples(ast.get_docstring(item) or "")
                if lines:
                    name = f"{file.relative_to(ROOT)}: {getattr(item, 'name', 'module')}"
                    found[name] = ast.parse("".join(line.source for line in lines))
    return found


def _bound(item: ast.AST) -> set[str]:
    """Names that a part of a program gives."""
    if isinstance(item, ast.Import | ast.ImportFrom):
        return {(name.asname or name.name).partition(".")[0] for name in item.names}
    if isinstance(item, ast.Name) and not isinstance(item.ctx, ast.Load):
        return {item.id}
    if isinstance(item, ast.FunctionDef | ast.ClassDef | ast.ExceptHandler):
        return {item.name or ""}
    return {item.arg} if isinstance(item, ast.arg) else set()


def test_examples_run_from_what_they_import_and_reach_public_names_as_a_user_does() -> None:
    """Some used names of the module they stand in, so that who copied them met a NameError."""
    examples = _examples()
    assert len(examples) > 200
    for place, example in examples.items():
        parts = list(ast.walk(example))
        given = set(dir(builtins)).union(*map(_bound, parts))
        used = {item.id for item in parts if isinstance(item, ast.Name)}
        assert used <= given, f"{place}: import {sorted(used - given)}"
        deep = {name.name for item in parts if isinstance(item, ast.ImportFrom) for name in item.names}
        assert not deep & set(kg.__all__), f"{place}: say kg.{sorted(deep & set(kg.__all__))[0]}"


@pytest.mark.parametrize("folder", ["tutorials", "examples"])
def test_scripts_reach_public_names_as_a_user_does(folder: str) -> None:
    for file in sorted((ROOT / folder).glob("*.py")):
        parts = ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        deep = {name.name for item in parts if isinstance(item, ast.ImportFrom) for name in item.names}
        assert not deep & set(kg.__all__), f"{file.name}: say kg.{sorted(deep & set(kg.__all__))[0]}"


def test_every_package_that_is_asked_for_has_its_licence_told() -> None:
    setup = configparser.ConfigParser()
    setup.read(ROOT / "setup.cfg")
    asked = {"": setup["options"]["install_requires"], **setup["options.extras_require"]}
    page = (ROOT / "docs" / "licences.md").read_text(encoding="utf-8")
    told = set(re.findall(r"^\| `([\w-]+)` \|", page, re.MULTILINE))
    names = {re.split(r"[><=!~ ]", line)[0] for lines in asked.values() for line in lines.split("\n") if line}
    assert names - told == set()


def test_the_tables_beside_other_codes_are_those_of_the_runs() -> None:
    """That of the docs digit by digit, that of the README, which leaves out codes and digits, as rounded."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    import peers

    with (ROOT / "benchmarks" / "results" / "peers.csv").open(newline="", encoding="utf-8") as file:
        measured = peers.shown(list(csv.DictReader(file)))
    assert measured in (ROOT / "docs" / "speed.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in measured.splitlines()[2:]]
    cases = list(dict.fromkeys(row[0].split(",")[0] for row in rows))
    codes = list(dict.fromkeys(row[1] for row in rows))[:5]
    told = re.findall(r"^\| (?:slit|52 slits|strip).* \|$", (ROOT / "README.md").read_text(), re.MULTILINE)
    assert len(told) == len(cases)
    for case, line in zip(cases, told):
        for code, cell in zip(codes, line.split("|")[2:-1], strict=True):
            ((_, _, error, seconds, *_),) = [row for row in rows if row[0].startswith(case) and row[1] == code]
            if error == "-":
                assert cell.strip() == "did not end"
                continue
            numbers = [float(number) for number in re.findall(r"[+-]?[\d.]+", cell)]
            assert numbers == pytest.approx([float(error.split()[0]), float(seconds)], rel=0.03), f"{case}, {code}"


def test_the_citation_names_this_version() -> None:
    (version,) = re.findall(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    assert version == kg.__version__
