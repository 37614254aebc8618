"""Numbers of things are told in words by one function, which knows one from many."""

import ast
import functools
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kirigami as kg
from kirigami.lattice.waves import BlochBuckling
from kirigami.results.error import ErrorBar
from kirigami.words import counted, percent

ROOT = Path(kg.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
OTHER = {"runs", "starts", "folds", "numbers"}  # "cut 3 runs along the outline", "a list of node numbers"


def nodes_of(where, kind):
    """Files that hold a pattern, and what is of a kind in them."""
    for file in FILES:
        text = file.read_text()
        if re.search(where, text):
            yield from ((file, node) for node in ast.walk(ast.parse(text)) if isinstance(node, kind))


@functools.cache
def things():
    """What the package counts anywhere, several of it: "nodes", "vertices", ..."""
    found = set()
    for _, node in nodes_of(r"\bcounted\(", ast.Call):
        if getattr(node.func, "id", None) == "counted":
            words = [argument.value for argument in node.args[1:] if isinstance(argument, ast.Constant)]
            found.update({(words[1] if len(words) > 1 else f"{words[0]}s").split()[-1]} if words else ())
    return found


def test_one_of_a_thing_is_one_thing():
    assert counted(1, "cut") == "1 cut" and counted(1.0, "degree", spec=".3g") == "1 degree"
    assert counted(0, "cut") == "0 cuts" and counted(11, "cut") == "11 cuts" and counted(-2, "cut") == "-2 cuts"
    assert counted(1, "vertex", "vertices") == "1 vertex" and counted(2, "vertex", "vertices") == "2 vertices"
    assert counted(0.999999, "degree", spec=".3g") == "1 degree"  # as it is read, not as it is


def test_shares_are_told_without_powers_of_ten():
    told = {0.0123: "1.2 %", 0.5: "50 %", 98.7: "9900 %", 1e-6: "0.0001 %", 1.6e-7: "0.000016 %", 0.0: "0 %"}
    assert {share: percent(share) for share in told} == told
    assert percent(1e-13) == "under 0.000001 %" and percent(-0.02) == "-2 %" and percent(0.123456, 4) == "12.35 %"


def test_no_sentence_of_the_package_counts_by_itself():
    """A number that is written straight before what `counted` counts elsewhere; constants are many."""
    several = "|".join(things())
    words = rf" (?:(?:stored|negative|final|stable|smaller|more|lattice|zero) )?({several})\b"
    wrong = []
    for file, text in nodes_of(rf"}}{words}", ast.JoinedStr):
        for value, after in zip(text.values, text.values[1:]):
            if not isinstance(value, ast.FormattedValue) or not isinstance(after, ast.Constant):
                continue
            told, found = ast.unparse(value.value), re.match(words, after.value)
            written = value.conversion == ord("r") or "shown(" in told or "proposal(" in told
            rounded = value.format_spec is not None and "e" in ast.unparse(value.format_spec).strip("f'\"")
            names = [node.id for node in ast.walk(value.value) if isinstance(node, ast.Name)]
            if not found or written or rounded or any(name.isupper() for name in names):
                continue
            if not (found[1] in OTHER and isinstance(value.value, ast.Name)):
                wrong.append(f"{file.relative_to(ROOT)}:{value.lineno}: {told}{after.value[:40]!r}")
    assert len(things()) > 40 and not wrong, "\n".join(wrong)


def test_no_sentence_leaves_one_from_many_to_the_reader():
    """"1 node(s)"; and no verb that is right of many only stands behind a number of things."""
    wrong = []
    for file, text in nodes_of(r"\(s\)|\bcounted\(", ast.JoinedStr):
        parts = [part.value if isinstance(part, ast.Constant) else ast.unparse(part) for part in text.values]
        sentence = "".join(parts)
        if re.search(r"\w\(s\)(?!\w)", "".join(part.value for part in text.values if isinstance(part, ast.Constant))):
            wrong.append(f"{file.relative_to(ROOT)}:{text.lineno}: {sentence[:80]}")
        for told, after in zip(text.values, parts[1:]):
            if "counted(" in ast.unparse(told) and re.match(r"(?: \w+)? (?:are|were|have|lie) ", after):
                wrong.append(f"{file.relative_to(ROOT)}:{text.lineno}: {sentence[:80]}")
    assert not wrong, "\n".join(wrong)


def small():
    """Two nodes, one of which moves along x."""
    model = kg.Model(dim=2)
    left, right = kg.Node(0, 0), kg.Node(1, 0)
    model.add(left, right, kg.Bar(left, right, EA=1.0), kg.Fix(left), kg.Fix(right, dofs="y"))
    model.add(kg.NodalLoad(right, (1, 0)))
    return model, left, right


def test_what_there_is_one_of_is_told_so():
    model, left, right = small()
    results = kg.LinearStatic(model).run()
    for name in ("iterations", "factorizations", "cutbacks", "relaxations"):
        results.stats[name] = 1
    shown = [results, *results, model, *model.constraints, *model.loads, kg.Mass(left, 1), kg.Spring(left, (1, 1, 0))]
    told = [results.summary(), *map(repr, shown), repr(kg.Eigen(model, n=1, mass=[1, 1]).run())]
    for text in told:
        assert not re.search(r"(?<![\d.])1 (?:\w+ )?\w+s\b", text), text
    assert "1 cutback," in told[0] and "2 nodes in 2D, 1 unknown\n" in told[0]


def test_what_is_infinite_or_unknown_is_said_in_words():
    """A wave without phases is the same in all cells; an error bar without figures says so."""
    wave = BlochBuckling(1.0, np.zeros(3), np.zeros(3), np.zeros(2), np.zeros(2), np.zeros((1, 3)), False)
    assert wave.wavelength == np.inf and "all cells alike" in repr(wave)
    longer = replace(wave, phases=np.array([0.5, 0.0]), wave_vector=np.array([0.5 / 20, 0.0]))
    assert "wavelength=251.3" in repr(longer)  # of 2 pi / 0.5 cells of length 20
    nothing = {name: np.array([np.nan, np.inf]) for name in ("force", "open_area", "height")}
    bar = ErrorBar(nothing, nothing, nothing, np.zeros(2))
    for text in (repr(wave), repr(longer), repr(bar)):
        assert not re.search(r"\b(inf|nan)\b", text) and text.split(":")[-1].strip(), text
    large = {name: np.array([2.0]) for name in nothing}
    assert "200 %" in str(ErrorBar(large, large, large, np.zeros(1)))


@pytest.mark.parametrize("angle, words", [(1, "1 degree"), (30, "30 degrees")])
def test_angles_in_words(angle, words):
    model, left, right = small()
    assert f"{words} about" in repr(kg.Turn([right], angle))
