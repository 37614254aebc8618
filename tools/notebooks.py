"""Turn the tutorials into Jupyter notebooks: ``python tools/notebooks.py [folder]``, by default into ``notebooks/``."""

from __future__ import annotations

import sys
from pathlib import Path

TUTORIALS = Path(__file__).resolve().parent.parent / "tutorials"
KERNEL = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}


def convert(folder: Path) -> list[Path]:
    """Write every tutorial as a notebook without outputs into `folder`; returns the files in order."""
    import jupytext

    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for script in sorted(TUTORIALS.glob("*.py")):
        notebook = jupytext.read(script, fmt="py:percent")
        notebook.metadata.update(KERNEL)
        for number, cell in enumerate(notebook.cells):
            cell["id"] = f"cell-{number}"  # not the random one, so that the same tutorial gives the same file
        target = folder / f"{script.stem}.ipynb"
        text = jupytext.writes(notebook, fmt="ipynb")
        if not target.exists() or target.read_text(encoding="utf-8") != text:
            target.write_text(text, encoding="utf-8")
        written.append(target)
    return written


if __name__ == "__main__":
    for path in convert(Path(sys.argv[1] if len(sys.argv) > 1 else "notebooks")):
        print(path)
