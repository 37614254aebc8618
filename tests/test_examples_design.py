"""Examples that search for a design end verified, and the drawing they write does what was wanted when run again."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.mark.long
@pytest.mark.parametrize("name", ["silhouette", "graded_facade", "dome", "flat_force_ribbon"])
def test_design_example(name, tmp_path, capsys):
    specification = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    found = module.main(tmp_path)
    assert found.verified
    assert found.error < 0.03
    last = capsys.readouterr().out.splitlines()[-1]
    off = float(last.split("within ")[1].split(" %")[0])
    assert off < 5  # of a mesh that knows the drawing alone
    assert json.loads((tmp_path / "case.json").read_text())["kind"] == "kirigami case"
