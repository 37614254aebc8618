"""Frequencies of plates: Leissa, The free vibration of rectangular plates, Journal of Sound and Vibration 31 (1973)
257-293; nu 0.3, omega a^2 sqrt(rho h / D) of the first modes of a square.
"""

import numpy as np
from case import Bound, Case, Found, each_rung
from patterns import on

import kirigami as kg

MATERIAL, THICKNESS = kg.Material(1e6, 0.3, density=2.0), 0.005
HINGES = "hinges resist twisting up to twice as much as the sheet does"


def square(rung, edges, count):
    """Frequency parameters of a unit square of the mesher: "clamped", "cantilever" or "free"."""
    mesh = kg.Sheet([(0, 0), (1, 0), (1, 1), (0, 1)]).mesh(0.1 if rung == "shell" else 0.04)
    model = kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, stiffness=rung)
    x, _, _ = model.positions().T
    if edges != "free":
        held = model.select(boundary="outer") if edges == "clamped" else [model.nodes[k] for k in on(x, 0)]
        model.add(kg.Fix(held, clamp=True))
    extra = 6 if edges == "free" else 0
    frequencies = kg.Eigen(model, n=count + extra, mass="consistent").run().frequencies[extra:]
    rigidity = MATERIAL.E * THICKNESS**3 / (12 * (1 - MATERIAL.nu**2))
    scale = np.sqrt(MATERIAL.density * THICKNESS / rigidity)
    return Found(2 * np.pi * frequencies * scale, nodes=len(mesh.nodes))


CASES = [
    Case("frequencies of a clamped square", [35.992, 73.413, 73.413, 108.27], "four modes",
         lambda rung: square(rung, "clamped", 4),
         {"shell": Bound(0.01), "facet": Bound(0.05), "plate": Bound(0.1)}, holds=0.05),
    Case("frequencies of a cantilevered square", [3.4917, 8.5246, 21.429, 27.331, 31.111], "five modes",
         lambda rung: square(rung, "cantilever", 5),
         {"shell": Bound(0.01), "facet": Bound(0.05), "plate": Bound(0.35, HINGES)}, holds=0.05),
    Case("frequencies of a free square", [13.489, 19.789, 24.432, 35.024, 35.024], "five modes",
         lambda rung: square(rung, "free", 5),
         {"shell": Bound(0.01), "facet": Bound(0.05), "plate": Bound(0.35, HINGES)}, holds=0.05),
]  # fmt: skip


@each_rung(CASES)
def test_published_number(case, rung):
    case.check(rung)
