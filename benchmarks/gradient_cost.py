"""What gradients cost beside one factorisation: five targets by fields, and by twenty parameters of cuts.

``python benchmarks/gradient_cost.py [nodes]`` prints CPU seconds over those of one factorisation of the same tangent,
at a state close to rest: what they cost does not depend on the state.
"""

from __future__ import annotations

import sys
import time

import numpy as np
import shapely

import kirigami as kg
from kirigami.linalg import make_solver
from kirigami.results.gradients.equilibrium import Equilibrium
from kirigami.results.gradients.fields import of_sheet
from kirigami.results.gradients.functionals import tell_of
from kirigami.system.system import System

NAMES = [f"length_{number}" for number in range(20)]


def cuts(**lengths):
    """Four rows of five slits, each with a length of its own."""
    found = []
    for number, name in enumerate(NAMES):
        x, y = 0.1 + 0.2 * (number % 5), 0.2 + 0.2 * (number // 5)
        found.append(shapely.LineString([(x - 0.5 * lengths[name], y), (x + 0.5 * lengths[name], y)]))
    return found


def pulled(m):
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=1e-4))


def timed(function):
    """Answer and CPU seconds."""
    began = time.process_time()
    return function(), time.process_time() - began


def main(nodes=1000):
    """Print the table."""
    design = kg.Design(
        cuts, outline=shapely.box(0, 0, 1, 1), supports=pulled, thickness=0.01, material=kg.Material(1e9, 0.3),
        mesh={"nodes": nodes}, imperfection=1e-3, **dict.fromkeys(NAMES, (0.12, 0.08, 0.16)),
    )  # fmt: skip
    system = System(design.model())
    u = 1e-5 * np.random.default_rng(0).normal(size=system.rest.shape)
    at = Equilibrium.as_given(system, system.unknowns(u), 1.0)
    at.take_tangent()
    solver = make_solver()
    solver.factorize(at.matrix)  # its order of elimination is found once for all tangents
    at.factor, one = timed(lambda: solver.factorize(at.matrix))
    results = kg.Results(system)
    asked = [("force", "driven_0", "y"), ("height",), ("open_area",), ("energy",), ("position", "top", "y")]
    told, telling = timed(lambda: [at.told(tell_of(item, results)) for item in asked])
    adjoints, solving = timed(lambda: at.adjoints(told))
    _, fields = timed(lambda: (of_sheet(adjoints, "thickness", "gradient"), of_sheet(adjoints, "strain", "gradient")))
    _, chain = timed(lambda: design.derivatives(adjoints))
    print(
        f"{len(design.mesh.nodes)} nodes, {system.free} unknowns: one factorisation {one:.3f} CPU s; over it, a target:"
        f" functional {telling / 5 / one:.2f}, adjoint solution {solving / 5 / one:.2f}, thickness and prestrain by "
        f"facets {fields / 5 / one:.2f}, twenty lengths {chain / 5 / one:.2f}",
        flush=True,
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
