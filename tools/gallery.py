"""Run every example in its reduced form, two at a time, and say how long each took.

    python tools/gallery.py [FOLDER] [NAME ...]

Pictures, animations and what each script printed (NAME.txt) go into FOLDER, "gallery" by default. Exits with 1 if a
script failed, which does not keep the others from running.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

EXAMPLES = Path(__file__).parent.parent / "examples"
AT_ONCE = 2


def run(script: Path, folder: Path) -> bool:
    """Run one example in `folder`; whether it ended well."""
    one_thread = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}
    start = time.monotonic()
    ended = subprocess.run(
        [sys.executable, str(script)], cwd=folder, env=os.environ | one_thread, capture_output=True, text=True
    )
    failure = ended.stderr if ended.returncode else ""  # where all is well, only progress bars went there
    (folder / f"{script.stem}.txt").write_text(ended.stdout + failure)
    state = "" if ended.returncode == 0 else f"  FAILED, see {folder / script.stem}.txt"
    print(f"{script.stem:24s} {time.monotonic() - start:6.0f} s{state}", flush=True)
    return ended.returncode == 0


def main(folder: str = "gallery", *names: str) -> int:
    """Run the named examples, all unless said."""
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    scripts = sorted(EXAMPLES.glob("*.py"))
    if names:
        scripts = [script for script in scripts if script.stem in names]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        done = list(pool.map(lambda script: run(script, target), scripts))
    return 0 if all(done) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
