"""The command line, quick enough for tests."""

from __future__ import annotations

from typing import Any

import pytest

import kirigami as kg
from kirigami.cli import demo


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """The demo on a mesh coarse enough for a test, without the pages that are tested elsewhere."""
    stretch = kg.stretch

    def quick(sheet: kg.Sheet, strain: float, direction: str, **options: Any) -> kg.Results:
        return stretch(sheet, strain, direction, **{**options, "accuracy": "draft", "nodes": None, "max_edge": 0.6})

    monkeypatch.setattr(kg, "stretch", quick)


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the first part of the path."""
    monkeypatch.setattr(demo, "PULL", 0.0016)


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports without pictures and pages, which other tests look at."""
    monkeypatch.setattr("kirigami.study.report_picture.write_pictures", lambda report, folder: [])
    monkeypatch.setattr("kirigami.io.vtk.write_vtk", lambda results, folder: [])
