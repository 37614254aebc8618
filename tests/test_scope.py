"""The page of what the package simulates is the one its tool makes now, and leaves out nothing of a model."""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import kirigami as kg
from kirigami.analysis.base import Analysis
from kirigami.primitives.material import SheetMaterial

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture
def scope(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    return importlib.import_module("scope")


def test_page_is_what_the_objects_say_now(scope: ModuleType) -> None:
    pytest.importorskip("ipctk")  # SelfContact is made with it
    assert scope.PAGE.read_text(encoding="utf-8") == scope.page(), "run python tools/scope.py"


def test_every_public_part_and_analysis_has_a_row(scope: ModuleType) -> None:
    parts = (kg.ModelObject, SheetMaterial, Analysis)
    bases = {kg.ModelObject}
    public = {name: getattr(kg, name) for name in kg.__all__}
    wanted = {name for name, item in public.items() if _is_part(item, parts) and item not in bases}
    listed = {row[0] for table in (scope.ADDED, scope.MADE_OF, scope.ANALYSES) for row in table}
    assert listed | set(scope.BY_THE_RUNG) == wanted - set(scope.SUPERSEDED)


def test_every_row_but_of_analyses_is_measured_where_it_is_taken(scope: ModuleType) -> None:
    measured = scope.prices()
    for name, remark, _ in scope.ADDED:
        if getattr(kg, name) not in (kg.TorsionSpring3, kg.AngleLimit):  # of a plane, which is not measured
            assert "shell" in measured[name, remark], (name, remark)


def _truss(dim: int) -> kg.Model:
    """A structure without a sheet."""
    m = kg.Model(dim=dim)
    places = [(0, 0), (1, 0), (0, 1), (1, 1), (0.5, 0.4), (0.4, 0.6)]
    m.add(*(kg.Node(x, y, 0.2 * number if dim == 3 else 0.0) for number, (x, y) in enumerate(places)))
    m.add(*(kg.Bar(a, b, 1.0) for number, a in enumerate(m.nodes) for b in m.nodes[:number]))
    return m


ACROSS: dict[str, Any] = {
    "NodalLoad": lambda m: kg.NodalLoad(m.nodes[0], (0, 0, 1)),
    "EdgeLoad": lambda m: kg.EdgeLoad(m.select(boundary="right"), (0, 0, 1)),
    "AreaLoad": lambda m: kg.AreaLoad((0, 0, 1)),
    "Gravity": lambda m: kg.Gravity((0, 0, 1)),
    "Fix": lambda m: kg.Fix(m.nodes[0], "z"),
    "Prescribe": lambda m: kg.Prescribe(m.nodes[0], z=1),
    "Tie": lambda m: kg.Tie(m.nodes[1:3], m.nodes[0], "z"),
    "Symmetry": lambda m: kg.Symmetry(m.select(boundary="right"), "z"),
    "Turn": lambda m: kg.Turn(m.select(boundary="right"), 30.0, "x"),
    "Grip": lambda m: kg.Grip(m.select(boundary="right"), turn=(1, 0, 0)),
    "Spring": lambda m: kg.Spring(m.nodes, (0, 0, 1)),
    "Contact": lambda m: kg.Contact(m.nodes, kg.Plane()),
}


def test_what_is_refused_is_refused_in_its_own_name(scope: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """AngleLimit used to be refused as a TorsionSpring3, and a mirror plane across z in a plane by an IndexError."""
    pytest.importorskip("ipctk")
    monkeypatch.setattr(scope, "inner", lambda m: m.nodes[4:6])
    trials = [(name, adds, lambda: scope.sheet("plane")) for name, adds in ACROSS.items()]
    for name, _, adds in scope.ADDED:
        trials += [(name, adds, lambda dim=dim: _truss(dim)) for dim in (2, 3)]
    refused = 0
    for name, adds, make in trials:
        m = make()
        try:
            m.add(adds(m))
            kg.System(m)
        except kg.KirigamiError as refusal:
            assert name in str(refusal), refusal
            refused += 1
    assert refused > len(ACROSS) + 20
    quoted = re.findall(r"^\* `kg\.(\w+)`[^:]*: (.*)$", scope.PAGE.read_text("utf-8"), re.MULTILINE)
    assert len(quoted) > 10
    for name, said in quoted:
        assert name in said, said


def _is_part(item: Any, parts: tuple[type, ...]) -> bool:
    return inspect.isclass(item) and issubclass(item, parts)
