"""Stress intensities: Tada, Paris and Irwin, The Stress Analysis of Cracks Handbook, 3rd edition (2000); plane stress,
so that the energy release rate is K^2 / E.
"""

import numpy as np
import shapely
from case import Bound, Case, Found, each_rung

import kirigami as kg

THICKNESS = 0.01


def plate(rung, slit, nodes, grips):
    """A plate of width 1 and length 3 with a slit at half its length, drawn apart by a thousandth; K over its stress.

    `grips` that let the ends turn are a pull by edge loads.
    """
    material = kg.Material(1e6, 0.3)
    sheet = kg.Sheet(shapely.box(0, 0, 1, 3), [slit], THICKNESS, material)
    model = kg.Model.from_mesh(sheet.mesh(nodes=nodes), stiffness=rung)
    bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(model.nodes, "z"))
    if grips:
        model.add(kg.Fix(bottom, "xy"), kg.Prescribe(top, x=0, y=0.003))
        results = kg.LinearStatic(model).run()
        stress = results.reaction(top, "y")[-1] / THICKNESS
    else:
        stress = 100.0
        corners = model.select(where=lambda x, y, z: (np.abs(x - 1) < 1e-9) & (np.abs(y) < 1e-9))
        model.add(kg.EdgeLoad(top, (0, stress * THICKNESS, 0)), kg.EdgeLoad(bottom, (0, -stress * THICKNESS, 0)))
        upper = model.select(where=lambda x, y, z: (x > 1 - 1e-9) & (y > 3 - 1e-9))
        model.add(kg.Fix(corners, "xy"), kg.Fix(upper, "x"))
        results = kg.LinearStatic(model).run()
    rate = results.energy_release(0)[-1]
    return Found(np.sqrt(np.asarray(rate) * material.E) / stress, results)


def centre(half):
    """K = stress sqrt(pi a sec(pi a / W)) (1 - 0.025 s^2 + 0.06 s^4), s = 2 a / W."""
    s = 2 * half
    exact = np.sqrt(np.pi * half / np.cos(np.pi * half)) * (1 - 0.025 * s**2 + 0.06 * s**4)
    return Case(
        f"centre crack, {s:g} of the width", [exact, exact], "stress intensity at both tips",
        lambda rung: plate(rung, [(0.5 - half, 1.5), (0.5 + half, 1.5)], 1500, True),
        {"shell": Bound(0.02), "facet": Bound(0.03)}, holds=0.03,
    )  # fmt: skip


def edge(length):
    """K = stress sqrt(pi a) F, F = sqrt(2 / (pi s) tan(pi s / 2)) (0.752 + 2.02 s + 0.37 (1 - sin(pi s / 2))^3)
    / cos(pi s / 2), s = a / W, good to half a per cent."""
    bend = np.pi * length / 2
    factor = np.sqrt(np.tan(bend) / bend) * (0.752 + 2.02 * length + 0.37 * (1 - np.sin(bend)) ** 3) / np.cos(bend)
    return Case(
        f"edge crack, {length:g} of the width", [np.sqrt(np.pi * length) * factor], "stress intensity",
        lambda rung: plate(rung, [(0, 1.5), (length, 1.5)], 1500, False),
        {"shell": Bound(0.02), "facet": Bound(0.05)}, holds=0.05,
    )  # fmt: skip


CASES = [centre(0.1), centre(0.25), edge(0.3), edge(0.5)]


@each_rung(CASES)
def test_published_number(case, rung):
    case.check(rung)
