"""A script written for version 0.1 goes on running: its names are there and take what they took, in the same order.

`tests/data/names_of_0_1.txt` lists them. What is gone was part of one element that has been replaced, and of no use
without it.
"""

from __future__ import annotations

import inspect
import re
import warnings
from pathlib import Path
from typing import Any

import pytest

import kirigami as kg

LISTED = (Path(__file__).parent / "data" / "names_of_0_1.txt").read_text(encoding="utf-8").splitlines()[1:]
GONE = {
    # tips of normals as nodes; shell facets keep angles behind the edges instead
    "Node.base", "Model.normals", "Kernel.normals", "CurvedFacet.i", "CurvedFacet.j", "CurvedFacet.k",
    "CurvedFacet.material", "CurvedFacet.nodes", "CurvedFacet.thickness", "Normal.base", "Normal.length", "Normal.name",
    "Normal.x", "Normal.y", "Normal.z",
    # what a tangent is made of is an argument of Kernel.evaluate, kg.Tangent
    "System.convexity", "System.linearize", "Kernel.convexity", "Kernel.linearize",
    # the reference of a study is an object of its own, AccuracyStudy.judge
    "study.AccuracyStudy.own",
}  # fmt: skip
MADE_BY_THE_PACKAGE = {"study.AccuracyStudy"}  # nobody calls it


def resolve(name: str) -> Any:
    """What a dotted name below kirigami is; None for an attribute that only instances have."""
    found: Any = kg
    for part in name.split("."):
        if inspect.isclass(found) and not hasattr(found, part):
            fields = {field for kind in found.__mro__ for field in getattr(kind, "__annotations__", {})}
            assert part in fields or part in inspect.signature(found).parameters, f"{name} is gone"
            return None
        found = getattr(found, part)
    return found


@pytest.mark.parametrize("line", [line for line in LISTED if line.partition("(")[0] not in GONE])
def test_old_name(line: str) -> None:
    name, _, told = line.partition("(")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        found = resolve(name)
    if not told or found is None or name in MADE_BY_THE_PACKAGE or not callable(found):
        return
    now = [entry for entry in inspect.signature(found).parameters.values() if entry.name not in ("self", "cls")]
    takes_all = {entry.kind for entry in now} & {inspect.Parameter.VAR_KEYWORD}
    places = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    by_place = [entry.name for entry in now if entry.kind in places]
    before = [entry for entry in told.rstrip(")").split(", ") if entry and entry != "self"]
    for entry in before:
        assert entry.startswith("*") or takes_all or entry.rstrip("=") in [one.name for one in now], f"{name}: {entry}"
    ordered = [entry for entry in before if not re.match(r"\*|.*=$", entry)]
    # a function borrowed from another module has another name than self for what it is given first
    assert ordered in (by_place[: len(ordered)], by_place[1 : 1 + len(ordered)]), f"{name}: {by_place}"


@pytest.mark.parametrize(
    ("old", "successor"),
    [
        (lambda mesh: kg.Model.from_mesh(mesh, 0.01, kg.Material(1e9), "split"), "stiffness='shell'"),
        (lambda mesh: kg.Normal(kg.Node(0, 0)), "kg.ShellFacet"),
        (
            lambda mesh: kg.CurvedFacet(
                *(kg.Normal(kg.Node(*place)) for place in ((0, 0), (1, 0), (0, 1))), 0.01, kg.Material(1e9)
            ),
            "kg.ShellFacet",
        ),
    ],
)
def test_what_is_superseded_works_and_names_its_successor(old: Any, successor: str) -> None:
    mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    with pytest.warns(DeprecationWarning, match=re.escape(successor)):
        assert old(mesh) is not None


def test_the_version_is_said_alike_everywhere() -> None:
    root = Path(__file__).parents[1]
    cited = re.search(r"^version: (.*)$", (root / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    assert cited is not None
    assert cited[1] == kg.__version__
    assert re.search(rf"^## {re.escape(kg.__version__)}\b", (root / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
