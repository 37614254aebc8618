"""The dozen drawings: each reads right, and the stiffness of the default mesh is near quadratic triangles'."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture
def dozen(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    yield importlib.import_module("dozen")
    for name in ("dozen", "dozen_drawings", "dozen_writers"):
        sys.modules.pop(name, None)


def test_drawings_are_those_that_are_generated_and_read_right(dozen: Any) -> None:
    drawn = {design.file.name: design for design in sys.modules["dozen_drawings"].dozen()}
    assert len(drawn) == 12 and {Path(name).suffix for name in drawn} == {".dxf", ".svg", ".fold", ".geojson"}
    for row in dozen.designs():
        design = drawn[row["file"]]
        assert design.file.read_text(encoding="utf-8") == design.write(design.outline, design.cuts)
        _, sheet = dozen.read(row)
        assert sheet.area == pytest.approx(row["area"], rel=1e-3), row["file"]
        assert sys.modules["dozen_drawings"].separate(sheet.cuts) == row["cuts"], row["file"]


@pytest.mark.filterwarnings("ignore::kirigami.errors.KirigamiWarning")
@pytest.mark.parametrize("name", ["lantern", "fan"])
def test_the_default_mesh_has_the_stiffness_of_quadratic_triangles(dozen: Any, name: str) -> None:
    """Both formulations are stiffer than the limit; a tenth is what a default may miss."""
    row = next(row for row in dozen.designs() if Path(row["file"]).stem == name)
    found, _ = dozen.linear_stiffness(dozen.read(row)[1], "standard")
    assert -0.02 < found / dozen.references()[name] - 1 < 0.1
