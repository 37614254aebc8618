"""The README's first script runs as it stands."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

README = Path(__file__).resolve().parent.parent / "README.md"


def test_first_script_runs_unchanged(tmp_path):
    script = re.search(r"```python\n(.*?)```", README.read_text(), re.DOTALL).group(1)
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, "MPLBACKEND": "Agg"},
    )
    assert done.returncode == 0, done.stderr
    force, area = map(float, re.search(r"force at 4 cm: ([\d.]+) N, open area: ([\d.]+) cm2", done.stdout).groups())
    # The slits open to most of the width they were pulled by, 0.1 m x 0.04 m, and more where the sheet tilts.
    assert 0 < force < 20 and 30 < area < 80
    assert {p.name for p in tmp_path.iterdir()} == {"ribbon.png", "ribbon_force.png"}
