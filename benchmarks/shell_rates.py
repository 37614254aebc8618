"""How fast shell facets converge on five patterns of mesh: plates and ligaments, drawn with slopes.

    python benchmarks/shell_rates.py                                        # the numbers
    python benchmarks/shell_rates.py --picture docs/images/shell_rates.png

The cases are those of tests/validation, against the same closed forms; the ligament, whose clamped corners are
singular, against its own finest mesh.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "validation"))

from patterns import PATTERNS
from test_shell_bending import plate
from test_shell_membrane import ligament

MODES = np.arange(1, 400, 2.0)
FIRST, SECOND = np.meshgrid(MODES, MODES)
SUPPORTED = float((64 / np.pi**8 / (FIRST * SECOND * (FIRST**2 + SECOND**2)) ** 2).sum())
# name, error on a mesh of a pattern with that many facets across, and how many
CASES: dict[str, tuple[Callable[[str, int], float], tuple[int, ...]]] = {
    "supported plate, work of the load": (lambda p, n: plate(p, n, False) / SUPPORTED - 1, (2, 4, 8, 16)),
    "clamped plate, work of the load": (lambda p, n: plate(p, n, True) / 3.891200775e-4 - 1, (2, 4, 8, 16)),
    "ligament bent in its plane": (lambda p, n: ligament(p, n) / finest() - 1, (1, 2, 4, 8)),
}


@cache
def finest() -> float:
    """Deflection of the ligament over that of beam theory, on crossed diagonals with 32 facets across."""
    return ligament("crossed", 32)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    found = {
        name: {pattern: [abs(error(pattern, n)) for n in across] for pattern in PATTERNS}
        for name, (error, across) in CASES.items()
    }
    for name, rows in found.items():
        across = np.array(CASES[name][1])
        print(f"{name}, {', '.join(map(str, across))} facets across")
        for pattern, errors in rows.items():
            rate = np.log(errors[-2] / errors[-1]) / np.log(across[-1] / across[-2])
            print(f"  {pattern:12s} {'  '.join(f'{error:.1e}' for error in errors)}   last rate {rate:.1f}")
    if options.picture:
        draw(found, options.picture)


def draw(found: dict[str, dict[str, list[float]]], path: Path) -> None:
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, len(found), figsize=(3.4 * len(found), 3.4), layout="constrained")
    for ax, (name, rows) in zip(panels, found.items()):
        across = np.array(CASES[name][1], float)
        for marker, (pattern, errors) in zip("osD^v", rows.items()):
            ax.loglog(across, errors, marker=marker, ms=4, lw=1, label=pattern)
        low = min(min(errors) for errors in rows.values())
        for rate, style in ((2, ":"), (4, "--")):
            ax.loglog(across, low * (across[-1] / across) ** rate, "k" + style, lw=0.8, label=f"rate {rate}")
        ax.set(title=name, xlabel="facets across")
        ax.title.set_fontsize(9)
        ax.set_xticks(across, [f"{value:g}" for value in across])
        ax.minorticks_off()
        ax.grid(True, lw=0.3, alpha=0.5)
    panels[0].set_ylabel("relative error")
    panels[-1].legend(fontsize=7)
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    main()
