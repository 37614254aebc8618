"""The scripts of README and overview run as they stand and say what is printed under them."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import shapely

import kirigami as kg

ROOT = Path(__file__).resolve().parent.parent


def run(page: str, folder: Path) -> str:
    """What the first script of a page prints."""
    script = re.search(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL).group(1)
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", script], cwd=folder, capture_output=True, text=True,
        env={**os.environ, "MPLBACKEND": "Agg"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_first_lines_print_what_stands_under_them(tmp_path):
    """The force within its own error bar, which is that of another machine to a tenth; and no file is left."""
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    told = re.search(r"```\n(\d+ N, give or take [\d.]+ %)\n```", page).group(1)
    force, bar = (float(number) for number in re.findall(r"[\d.]+", told))
    now = [float(number) for number in re.findall(r"[\d.]+", run("README.md", tmp_path))]
    assert now[0] == pytest.approx(force, rel=bar / 100) and now[1] == pytest.approx(bar, rel=0.2)
    assert not list(tmp_path.iterdir())


def test_the_script_in_full_runs_unchanged(tmp_path):
    printed = run("docs/overview.md", tmp_path)
    force, area = map(float, re.search(r"force at 4 cm: ([\d.]+) N, open area: ([\d.]+) cm2", printed).groups())
    # The slits open to most of the width they were pulled by, 0.1 m x 0.04 m, and more where the sheet tilts.
    assert 0 < force < 20 and 30 < area < 80
    (told,) = re.findall(r"([\d.]+) N\. On the right", " ".join((ROOT / "docs/overview.md").read_text().split()))
    assert force == pytest.approx(float(told), rel=0.05), "another shape than the page tells: tools/ribbon_picture.py"
    assert {p.name for p in tmp_path.iterdir()} == {"ribbon.png", "ribbon_force.png"}


@pytest.mark.parametrize("rung", ["plate", "facet", "shell"])
def test_the_ribbon_on_every_rung(rung):
    """The sheet of the overview, with an imperfection from a mode of its own, opens on every rung alike."""
    slits = kg.cuts.parallel_slits(columns=1, rows=9, width=0.1, height=0.2, length=0.075, margin=0.02)
    sheet = kg.Sheet(shapely.box(0, 0, 0.1, 0.24), slits, thickness=0.2e-3, material=kg.Material(E=3.5e9, nu=0.34))
    mesh = sheet.mesh(max_edge=0.012 if rung in ("plate", "facet") else 0.024)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kg.KirigamiWarning)
        m = kg.Model.from_mesh(mesh, stiffness=rung)
    assert len(m.nodes) == len(mesh.nodes)
    m.perturb(kg.Eigen(m, n=7).run()[6], amplitude=0.2e-3)
    rest = kg.System(m)
    assert rest.imbalance(np.zeros_like(rest.rest), 0.0)[1] == 0.0  # an imperfection is free of stress
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=0.04))
    res = kg.DisplacementControl(m, corrector="descent").run()
    assert res.stable[-1] and res.u.shape[1] == len(mesh.nodes)
    force = res.reaction(top, "y")[-1]
    assert force == pytest.approx(-res.reaction(bottom, "y")[-1], rel=1e-5)
    # The slits open to most of the width they were pulled by, 0.1 m x 0.04 m, and more where the sheet tilts.
    assert 1.0 < force < 4.0 and 30e-4 < res.open_area()[-1].sum() < 80e-4
