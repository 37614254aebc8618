"""Fifty random cut sheets, each in a process that may die or run on: none does, and no step is stored unconverged.

The thousand, and larger ones, are run by ``make random-sheets``.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kirigami as kg

SCRIPT = Path(__file__).resolve().parents[2] / "benchmarks" / "random_sheets.py"


@pytest.fixture(scope="module")
def sheets():
    sys.path.insert(0, str(SCRIPT.parent))
    try:
        import random_sheets
    finally:
        sys.path.remove(str(SCRIPT.parent))
    return random_sheets


@pytest.mark.long
def test_fifty_sheets(sheets, tmp_path):
    """No crash, no hang, no wrong step; severed sheets refused; at least 95 % of the others reach the end."""
    rows = sheets.survey(list(range(50)), tmp_path / "table.csv", workers=1, small=True, limit=60.0, seconds=np.inf)
    outcomes = [row["outcome"] for row in rows]
    assert len(rows) == 50 and set(outcomes) <= {"reached", "typed error"}, sheets.summary(rows)
    severed = [row for row in rows if row["parts"] > 1]
    connected = [row for row in rows if row["parts"] == 1]
    assert severed and all(map(sheets.as_expected, severed)), sheets.summary(rows)
    assert sum(map(sheets.as_expected, connected)) >= 0.95 * len(connected), sheets.summary(rows)


@pytest.mark.long
def test_a_ligament_that_would_tear_ends_in_time(sheets):
    """Facets half as wide as they are thick, stretched by 83 %, collapse on bars and hinges: said, and without end."""
    row = sheets.stretch(47, small=False)
    assert row["outcome"] == "typed error" and "law of small strains" in row["message"]
    assert row["last_load_factor"] > 0.85 and row["cutbacks"] < 60


def test_the_count_of_parts_is_right(sheets):
    """The oracle itself: a line across, a closed line, a line that stops short, and a hole that is no piece."""
    import shapely

    square = shapely.box(0, 0, 1, 1)
    across = shapely.LineString([(-0.1, 0.5), (1.1, 0.5)]).intersection(square)
    ring = shapely.LineString([(0.2, 0.2), (0.4, 0.2), (0.4, 0.4), (0.2, 0.2)])
    short = shapely.LineString([(0, 0.5), (0.99, 0.5)])
    hole = shapely.Point(0.5, 0.5).buffer(0.2)
    assert [sheets.parts_of(square, cuts) for cuts in ([], [across], [ring], [short], [hole], [hole, short])] == [
        1, 2, 2, 1, 1, 1,
    ]  # fmt: skip
    assert sheets.parts_of(square, [hole, across]) == 2 and sheets.parts_of(square, [across, ring]) == 3


def test_a_wrong_step_would_be_seen(sheets):
    """The second residual agrees with the stored one to the digits that count, and grows where a step is spoilt."""
    outline, cuts, _ = sheets.drawing(1)
    mesh = sheets.mesh_of(outline, cuts[:3], 50, 150, 100)
    m = kg.Model.from_mesh(mesh)
    x, y, _ = m.positions().T
    m.perturb(1e-4 * np.sin(np.pi * y / y.max()) * (1 + x))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz"), kg.Prescribe(top, y=0.02, clamp=True))
    results = kg.DisplacementControl(m, tol=1e-6).run()
    again = np.array(sheets.residuals(m, results))
    assert again[1:] == pytest.approx(results.residual[1:], rel=1e-4, abs=1e-12)
    free = m.index(m.select(where=lambda x, y, z: abs(y - y.mean()) < 0.2))
    results.steps[-1].u[free[0], 2] += 1e-4
    assert sheets.residuals(m, results)[-1] > 1e-4
    results.steps[-1].u[free[0], 2] = np.nan
    assert sheets.residuals(m, results) == [np.inf]


@pytest.mark.parametrize("fate", ["dies", "hangs"])
def test_a_worker_that_is_lost_is_an_outcome(sheets, fate, monkeypatch, tmp_path):
    """A process that dies is a crash and one that runs on a hang; the survey goes on with a new one."""
    script = tmp_path / "worker.py"
    action = "os.abort()" if fate == "dies" else "\n        while True: pass"
    script.write_text(
        "import json, os, resource, sys\n"
        "for line in sys.stdin:\n"
        "    request = json.loads(line)\n"
        "    resource.setrlimit(resource.RLIMIT_CPU, (1, -1))\n"
        f"    if request['seed'] == 0: {action}\n"
        "    row = {'seed': 1, 'outcome': 'reached', 'kind': 'slits', 'parts': 1, 'seconds': 0}\n"
        "    print(json.dumps(row), flush=True)\n"
    )
    monkeypatch.setattr(sheets, "__file__", str(script))
    rows = sheets.survey([0, 1], None, workers=1, small=True, limit=5.0, seconds=np.inf)
    assert [row["outcome"] for row in rows] == ["crash" if fate == "dies" else "hang", "reached"]


def test_the_command_goes_on_where_it_was(tmp_path):
    """Seeds in the table are not run again."""
    table = tmp_path / "table.csv"
    command = [sys.executable, str(SCRIPT), "--small", "--workers", "1", "--table", str(table), "--first", "15"]
    subprocess.run([*command, "--seeds", "1"], check=False, capture_output=True, timeout=300)
    first = table.read_text(encoding="utf-8")
    done = subprocess.run([*command, "--seeds", "1"], check=False, capture_output=True, text=True, timeout=300)
    assert table.read_text(encoding="utf-8") == first and len(first.splitlines()) >= 2
    assert done.stdout.startswith("1 sheet,")
