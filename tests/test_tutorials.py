"""Every tutorial runs as a script, leaves no files, and becomes a notebook that says the same."""

from __future__ import annotations

import re
import runpy
import sys
import tempfile
from pathlib import Path

import pytest
from matplotlib import pyplot

import kirigami as kg

ROOT = Path(__file__).resolve().parent.parent
TUTORIALS = sorted((ROOT / "tutorials").glob("*.py"))
LONG = ("05_which_shape", "13_yield_and_contact")
LIBRARIES = {"04_your_own_drawing": ("svgelements", "ezdxf", "plotly"), "13_yield_and_contact": ("ipctk",)}


@pytest.mark.parametrize(
    "script",
    [pytest.param(script, marks=pytest.mark.long if script.stem in LONG else ()) for script in TUTORIALS],
    ids=[script.stem for script in TUTORIALS],
)
def test_runs_and_meets_its_number(script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in LIBRARIES.get(script.stem, ()):
        pytest.importorskip(name)
    pyplot.switch_backend("Agg")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    try:
        runpy.run_path(str(script), run_name="__main__")  # the assertions at its end are the test
    finally:
        pyplot.close("all")
    assert [path.name for path in tmp_path.rglob("*")] == ["temporary"]


def test_a_newcomers_effect_takes_thirty_lines_of_public_names() -> None:
    text = (ROOT / "tutorials" / "10_your_own_effect.py").read_text(encoding="utf-8")
    cell = text.partition("@dataclass")[2].partition("# %%")[0]
    assert "class Bed(" in cell and "class BedKernel(" in cell
    assert 1 + sum(bool(line.strip()) for line in cell.splitlines()) <= 30
    assert set(re.findall(r"\bkg\.(\w+)", text)) <= set(kg.__all__) and "from kirigami" not in text


@pytest.mark.parametrize("script", TUTORIALS, ids=[script.stem for script in TUTORIALS])
def test_is_laid_out_as_a_tutorial(script: Path) -> None:
    lines = script.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "# %% [markdown]" and lines[1].startswith("# # ")
    assert max(map(len, lines)) <= 120
    last_cell = lines[len(lines) - lines[::-1].index("# %%") :]
    assert any(line.lstrip().startswith("assert ") for line in last_cell), "a tutorial ends in a checked number"


def test_notebooks_hold_the_code_of_the_scripts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("jupytext")
    nbformat = pytest.importorskip("nbformat")
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    sys.modules.pop("notebooks", None)
    import notebooks

    written = notebooks.convert(tmp_path)
    assert [path.stem for path in written] == [script.stem for script in TUTORIALS]
    for path, script in zip(written, TUTORIALS):
        notebook = nbformat.read(path, as_version=4)
        nbformat.validate(notebook)
        code = [cell.source for cell in notebook.cells if cell.cell_type == "code"]
        plain = [line for line in script.read_text(encoding="utf-8").splitlines() if line and line[0] != "#"]
        assert [line for line in "\n".join(code).splitlines() if line and line[0] != "#"] == plain
        assert notebook.cells[0].cell_type == "markdown"
    before = [path.read_bytes() for path in written]
    assert [path.read_bytes() for path in notebooks.convert(tmp_path)] == before
