"""E and thickness out of one measured force curve: calibration by gradients.

A strip with a slit is pulled. Before it buckles it bears by E t, and once it has it bends by E t^3 as well, so a curve
that goes through buckling tells both: E t to some tenths of a percent, and E and t, which nearly trade off, to some
percent under this noise. The curve "measured" here is that of a hidden sheet, with noise.

Run it with ``python examples/calibration.py``; it takes about half a minute.
"""

from __future__ import annotations

import numpy as np
import shapely

import kirigami as kg

AT = [0.1, 0.25, 0.5, 0.75, 1.0]
NOISE = 0.002  # of the largest force


def grips(m: kg.Model) -> None:
    """The ends are clamped; one is pulled."""
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=0.004))


def strip() -> kg.Design:
    """What is thought of the strip before it was measured."""
    return kg.Design(
        [shapely.LineString([(0.01, 0.04), (0.05, 0.04)])], outline=shapely.box(0, 0, 0.06, 0.08), supports=grips,
        mesh={"max_edge": 0.015, "cut_edge": 0.01}, thickness=(5e-4, 3e-4, 1e-3),
        material=lambda E: kg.Material(E, 0.3), E=(2e9, 1e9, 5e9), imperfection=5e-5,
    )  # fmt: skip


def measured(hidden: kg.Design) -> np.ndarray:
    """Forces of the hidden strip, with noise."""
    res = hidden.walk(AT, tol=1e-10)
    force = np.array([res.reaction("driven_0", "y")[res.nearest(lam)] for lam in AT])
    return force + NOISE * force.max() * np.random.default_rng(0).normal(size=len(AT))


def main() -> kg.InverseResult:
    """Recover what was hidden."""
    guess = strip()
    curve = measured(guess.at(E=2.6e9, thickness=6.2e-4))
    found = kg.Inverse(guess, (("force", "driven_0", "y"), AT, curve), corrections=None).run()
    print(found.summary())
    print("hidden: E=2.6e+09, thickness=0.00062")
    return found


if __name__ == "__main__":
    main()
