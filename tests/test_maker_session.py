"""The session in the documentation is run: each command, and what it says where that does not depend on the machine."""

from __future__ import annotations

import doctest
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "maker_session.md"
PROGRESS = re.compile(r"[^\r\n]*\r|^(?:DisplacementControl|Animation):.*?(?:steps|%\|[^|]*\| [^ ]*)$", re.MULTILINE)


def session() -> list[tuple[str, str]]:
    """Commands of the page and what they are to say."""
    blocks = re.findall(r"```console\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    found = []
    for block in blocks:
        command, _, said = block.partition("\n")
        assert command.startswith("$ kirigami ")
        found.append((command.removeprefix("$ kirigami "), said))
    return found


def test_the_session_of_the_documentation(tmp_path: Path) -> None:
    for name in ("trimesh", "plotly", "meshio", "ezdxf"):
        pytest.importorskip(name)
    shutil.copy(ROOT / "examples" / "data" / "lantern.svg", tmp_path)
    surroundings = {**os.environ, "PYTHONUNBUFFERED": "1", "MPLBACKEND": "Agg", "PYTHONPATH": str(ROOT)}
    alike = doctest.OutputChecker()
    for command, wanted in session():
        words = [sys.executable, "-m", "kirigami.cli", *shlex.split(command)]
        done = subprocess.run(words, cwd=tmp_path, env=surroundings, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        said = PROGRESS.sub("", done.stdout.decode())
        said = "\n".join(line for line in said.splitlines() if line.strip() and "Control: " not in line) + "\n"
        assert done.returncode == 0, said
        flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
        assert alike.check_output(wanted, said, flags), f"{command}\nsays\n{said}\nnot\n{wanted}"
    assert (tmp_path / "lantern.gif").read_bytes()[:4] == b"GIF8"
    assert (tmp_path / "laser.dxf").stat().st_size > 1000
    import trimesh

    body = trimesh.load(tmp_path / "lantern.stl")
    assert 100 < body.extents.max() < 140  # mm
