"""The distributions hold what they should and work where nothing else of the project is installed."""

from __future__ import annotations

import configparser
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "tools" / "check_packaging.sh"
# The oldest and the newest supported Python, where this machine has them, and the one at work.
INTERPRETERS = [found for found in map(shutil.which, ("python3.10", "python3.13")) if found]


@pytest.mark.external
@pytest.mark.skipif(os.name == "nt", reason="the script is written for a POSIX shell")
@pytest.mark.parametrize("interpreter", sorted({sys.executable, *INTERPRETERS}))
def test_distributions_build_install_and_work(interpreter: str) -> None:
    """Builds in a temporary folder, installs from a package index; see the script for what is checked."""
    if subprocess.run([interpreter, "-c", ""], capture_output=True).returncode:
        pytest.skip(f"{interpreter} does not start: a name that a version manager keeps for one that is not chosen")
    done = subprocess.run([str(SCRIPT), interpreter], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "contents right" in done.stdout and "newest" in done.stdout


def test_what_is_said_to_install_exists() -> None:
    """Extras are named with the distribution's own name, and are there, wherever code or pages name one."""
    setup = configparser.ConfigParser()
    setup.read(ROOT / "setup.cfg")
    extras = setup["options.extras_require"].keys()
    texts = [*ROOT.glob("kirigami/**/*.py"), *ROOT.glob("docs/*.md"), *ROOT.glob("tutorials/*"), ROOT / "README.md"]
    named = 0
    for text in texts:
        for name, extra in re.findall(r"""pip install -?e? ?["']?([\w.-]+)\[([\w{},]+)\]""", text.read_text()):
            named += 1
            assert name in (setup["metadata"]["name"], "."), f"{text}: pip install {name}[{extra}]"
            assert extra == "{extra}" or set(extra.split(",")) <= set(extras), f"{text}: {extra}"
    assert named >= 5
