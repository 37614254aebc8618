"""The page of what the package simulates is the one its tool makes now, and leaves out nothing of a model."""

from __future__ import annotations

import importlib
import inspect
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


def _is_part(item: Any, parts: tuple[type, ...]) -> bool:
    return inspect.isclass(item) and issubclass(item, parts)
