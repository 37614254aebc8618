"""A lamp of one spiral slit, hung by its middle: a disc becomes a spring under its own weight.

A disc of polypropylene, 15 cm in radius and 2 mm thick, with a spiral slit of four turns; the inner disc is held, and
the weight of all the rest pulls the turns down. While they hang little, each turn is a strip that the weight below it
twists: with the force F of what hangs below, at the radius r from the axis, the drop of the rim is

    integral of F r^2 / (G J) ds,    G J = G b t^3 / 3 (1 - 0.63 t / b)    (Wahl, Mechanical Springs, 1963)

for a strip of width b. It is checked at a hundredth of the weight; under all of it the lamp is stiffer than that. The
mesh is one facet across the strip: three times the nodes change the drop by less than 0.2 %.

    python examples/spiral_lamp.py           some ten seconds: a picture, and what it prints
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import shapely

import kirigami as kg

RADIUS, INNER, PITCH, TURNS, THICKNESS = 0.15, 0.03, 0.025, 4, 2e-3
POLYPROPYLENE = kg.Material(E=1.5e9, nu=0.4, density=905.0)
GRAVITY = 9.81
LITTLE = 0.01  # of the weight


def sheet() -> kg.Sheet:
    """The disc and its slit, an Archimedean spiral."""
    angle = np.linspace(0, 2 * np.pi * TURNS, 60 * TURNS)
    radius = INNER + PITCH * angle / (2 * np.pi)
    slit = shapely.LineString(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1))
    return kg.Sheet(
        shapely.Point(0, 0).buffer(RADIUS, quad_segs=24), [slit], thickness=THICKNESS, material=POLYPROPYLENE
    )


def hung(targets: Sequence[float] = (LITTLE, 0.2, 0.5, 1.0), nodes: int = 700) -> kg.Results:
    """The lamp from a hundredth of its weight to all of it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kg.KirigamiWarning)  # the strips are one facet wide, see above
        mesh = sheet().mesh(nodes=nodes)
    model = kg.Model.from_mesh(mesh, stiffness="shell")
    middle = model.select(where=lambda x, y, z: np.hypot(x, y) < 0.8 * INNER)
    model.add(kg.Fix(middle), kg.Gravity((0, 0, -GRAVITY)))
    return kg.LoadControl(model, to=targets[-1], targets=targets).run()


def weight_beyond(radius: float) -> float:
    """Weight of what lies outside of a radius."""
    return POLYPROPYLENE.density * THICKNESS * GRAVITY * np.pi * (RADIUS**2 - radius**2)


def drop_of_spring(share: float) -> float:
    """Drop of the rim at a share of the weight, each turn a strip that is twisted."""
    angle = np.linspace(0, 2 * np.pi * (TURNS - 1), 2000)
    radius = INNER + PITCH * (angle / (2 * np.pi) + 0.5)
    stiffness = POLYPROPYLENE.E / (2 + 2 * POLYPROPYLENE.nu) * PITCH * THICKNESS**3 / 3 * (1 - 0.63 * THICKNESS / PITCH)
    force = np.array([weight_beyond(r) for r in radius]) * share
    return float(np.trapezoid(force * radius**3, angle) / stiffness)


def drop(results: kg.Results, share: float) -> float:
    """How far the rim hangs below the middle, on average, at a share of the weight."""
    step = results.nearest(share)
    assert np.isclose(results.lam[step], share)
    rim = np.hypot(*results.rest[:, :2].T) > RADIUS - 1e-6
    return float(-results.u[step, rim, 2].mean())


def main() -> None:
    results = hung()
    print(results.summary())
    print(f"drop at {LITTLE:g} of the weight: {1e3 * drop(results, LITTLE):.2f} mm, ", end="")
    print(f"a spring of twisted strips {1e3 * drop_of_spring(LITTLE):.2f} mm")
    print(f"drop under its weight: {1e3 * drop(results, 1.0):.0f} mm")
    results.units = "SI"  # so that the picture says millimetres
    results.plot(-1).get_figure().savefig("spiral_lamp.png", dpi=120, bbox_inches="tight")


if __name__ == "__main__":
    main()
