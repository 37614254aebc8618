"""The picture of the overview: its ribbon where a slow pull leads, and in the shape of least energy known.

    python tools/ribbon_picture.py              writes docs/images/ribbon.png, and prints energies and forces

The model and the pull are those of the first script of docs/overview.md, which is run as it stands up to its first
print.
"""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import kirigami as kg
from kirigami.plot import style
from kirigami.results.results import Results

ROOT = Path(__file__).resolve().parent.parent
TRIALS = 16


def first_script() -> dict[str, Any]:
    """Names of the first script of the overview, once it has run."""
    found = re.search(r"```python\n(.*?)```", (ROOT / "docs" / "overview.md").read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    names: dict[str, Any] = {}
    exec(found.group(1).partition("print(")[0], names)  # our own script, which tests/test_readme.py runs as well
    return names


@style.styled
def draw(shapes: list[tuple[str, Results]]) -> Any:
    """Shapes side by side, under one view."""
    from matplotlib import pyplot

    figure = pyplot.figure(figsize=(10.4, 4.2), layout="constrained")
    for place, (title, results) in enumerate(shapes, start=1):
        ax = figure.add_subplot(1, len(shapes), place, projection="3d")
        results.plot(ax=ax)
        ax.set_title(title, y=0.93)
        ax.set_axis_off()
    return figure


def main() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kg.KirigamiWarning)
        names = first_script()
        m, pulled = names["m"], names["res"]
        found = kg.study.shapes(m, starts=[pulled[-1]], trials=TRIALS, followed=0, most=1)
    print(found)
    print(*found.words(pulled[-1]), sep="\n")
    drawn = []
    for title, step in (("where a slow pull leads", pulled[-1]), ("the least energy known", found[0].step)):
        results = Results(kg.System(m))
        results.append(step)
        results.units = "SI"
        shape = found.which(step)
        assert shape is not None
        drawn.append((f"{title}: {1e3 * shape.energy:.1f} mJ, {shape.force:.2f} N", results))
    draw(drawn).savefig(ROOT / "docs" / "images" / "ribbon.png", dpi=110, bbox_inches="tight")


if __name__ == "__main__":
    main()
