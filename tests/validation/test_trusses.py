"""Trusses: von Mises, Zeitschrift fuer angewandte Mathematik und Mechanik 3 (1923) 406-422; and the step load that
snaps such a truss: its potential at the highest point of the motion is that at rest.
"""

import numpy as np
from case import Bound, Case, Found, each_rung

import kirigami as kg

HEIGHT, EA = 0.3, 10.0
STATIC = 8 / (3 * np.sqrt(3)) * EA / (4 * np.hypot(1, HEIGHT) ** 3) * HEIGHT**3  # Green strain: c (z^2 - H^2)^2


def truss():
    model = kg.Model(dim=2)
    left, apex, right = model.add(kg.Node(-1, 0), kg.Node(0, HEIGHT), kg.Node(1, 0))
    model.add(kg.Bar(left, apex, EA), kg.Bar(apex, right, EA), kg.Fix([left, right]), kg.Fix(apex, "x"))
    model.add(kg.NodalLoad(apex, (0, -1)), kg.Mass(apex, 2.0))
    return model, apex


def limit_load(rung):
    model, apex = truss()
    results = kg.ArcLength(model, step=0.1 * STATIC, max_steps=200, stop=lambda s: s.u[1, 1] < -HEIGHT).run()
    (limit, *_) = (event for event in results.events if event.kind == "limit point")
    return Found(limit.lam, results)


def step_load(rung):
    """The least load that snaps it, by halving, over the static limit."""
    model, _ = truss()
    period = 2 * np.pi * np.sqrt(2.0 / (8 * EA / (4 * np.hypot(1, HEIGHT) ** 3) * HEIGHT**2))
    low, high = 0.76, 0.78
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        results = kg.Dynamics(model, end=13 * period, step=period / 40, load=middle * STATIC, every=5).run()
        low, high = (low, middle) if results.u[:, 1, 1].min() < -2 * HEIGHT else (middle, high)
    return Found(0.5 * (low + high), results)


CASES = [
    Case("von Mises truss, limit load", STATIC, "load at the limit point", limit_load, {"bars": Bound(1e-6)}),
    Case("von Mises truss under a step load", 4 * np.sqrt(3) / 9, "critical load over the static one", step_load,
         {"bars": Bound(2e-4, long=True)}),
]  # fmt: skip


@each_rung(CASES)
def test_published_number(case, rung):
    case.check(rung)
