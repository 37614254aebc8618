"""Plates under loads: Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 2nd edition (1959); Levy, NACA
Technical Note 847 (1942), large deflections; Morley, Skew Plates and Structures (1963).
"""

import numpy as np
import shapely
from case import Bound, Case, Found, each_rung
from patterns import on
from shells import near

import kirigami as kg

MATERIAL, THICKNESS = kg.Material(1e6, 0.3), 0.01
RIGIDITY = MATERIAL.E * THICKNESS**3 / (12 * (1 - MATERIAL.nu**2))
TWIST = "hinges take twisting for more than it is"
LEVY = np.array([[17.79, 0.237], [38.3, 0.471], [63.4, 0.695], [95.0, 0.912], [134.9, 1.121], [184.0, 1.323],
                 [245.0, 1.521], [318.0, 1.714], [402.0, 1.902]])  # fmt: skip


def held_plate(rung, outline, clamped, material=MATERIAL):
    """A plate of the mesher on supports or clamps all round, and its nodes in the plane (n, 2)."""
    edge = 0.1 if rung == "shell" else 0.04
    mesh = kg.Sheet(outline).mesh(edge)
    model = kg.Model.from_mesh(mesh, THICKNESS, material, stiffness=rung)
    model.add(kg.Fix(model.select(boundary="outer"), "xyz", clamp=clamped))
    return model, mesh


def middle_of(model, u, place):
    """Deflection at a place by a quadratic through the twelve nearest nodes."""
    away = model.positions()[:, :2] - place
    near_by = np.argsort((away**2).sum(axis=1))[:12]
    x, y = away[near_by].T
    terms = np.stack([np.ones(12), x, y, x * x, y * y, x * y], axis=1)
    return np.linalg.lstsq(terms, u[near_by, 2], rcond=None)[0][0]


def uniform(rung, outline, clamped, place):
    """Deflection under a unit load an area, over a^4 / D with a = 1."""
    model, mesh = held_plate(rung, outline, clamped)
    model.add(kg.Fix([node for node in model.nodes if node not in set(model.select(boundary="outer"))], "xy"))
    model.add(kg.AreaLoad((0, 0, 1.0)))
    results = kg.LinearStatic(model).run()
    return Found(middle_of(model, results.u[-1], place) * RIGIDITY, results, len(mesh.nodes))


def point(rung, clamped):
    """Deflection of a unit square under a unit force at its middle, over a^2 / D."""
    edge = 0.08 if rung == "shell" else 0.04
    mesh = kg.Sheet(shapely.box(0, 0, 1, 1)).mesh(edge, lines={"middle": shapely.LineString([(0.4, 0.5), (0.5, 0.5)])})
    model = kg.Model.from_mesh(mesh, THICKNESS, MATERIAL, stiffness=rung)
    rim = set(model.select(boundary="outer"))
    model.add(kg.Fix(rim, "xyz", clamp=clamped), kg.Fix([node for node in model.nodes if node not in rim], "xy"))
    middle = near(model.positions(), (0.5, 0.5, 0))
    model.add(kg.NodalLoad(model.nodes[middle], (0, 0, 1.0)))
    results = kg.LinearStatic(model).run()
    return Found(results.u[-1, middle, 2] * RIGIDITY, results, len(mesh.nodes))


def skew(rung):
    """Morley's rhombus with corners of 30 degrees on supports, a uniform load: deflection of its middle, of a^4 / D."""
    run, rise = np.cos(np.pi / 6), np.sin(np.pi / 6)
    found = uniform(rung, [(0, 0), (1, 0), (1 + run, rise), (run, rise)], False, ((1 + run) / 2, rise / 2))
    return found


def large(rung):
    """Levy: a clamped square, nu 0.316, under a load grown until it sags by nearly two thicknesses."""
    model, mesh = held_plate(rung, shapely.box(0, 0, 1, 1), True, kg.Material(1e6, 0.316))
    model.add(kg.AreaLoad((0, 0, 402.0 * 1e6 * THICKNESS**4)))
    results = kg.LoadControl(model, targets=LEVY[:, 0] / 402.0).run()
    rows = [results.nearest(load / 402.0) for load in LEVY[:, 0]]
    return Found([middle_of(model, results.u[row], 0.5) / THICKNESS for row in rows], results)


SQUARE, ROUND = shapely.box(0, 0, 1, 1), shapely.Point(0, 0).buffer(1.0, quad_segs=32)
GOOD = {"shell": Bound(0.01), "facet": Bound(0.05), "plate": Bound(0.1)}
CASES = [
    Case("supported square, uniform load", 0.00406235, "deflection of the middle",
         lambda rung: uniform(rung, SQUARE, False, (0.5, 0.5)), GOOD),
    Case("clamped square, uniform load", 0.00126532, "deflection of the middle",
         lambda rung: uniform(rung, SQUARE, True, (0.5, 0.5)), GOOD),
    Case("supported square, force at the middle", 0.0116008, "deflection of the middle",
         lambda rung: point(rung, False), GOOD),
    Case("clamped square, force at the middle", 0.0056120, "deflection of the middle",
         lambda rung: point(rung, True), GOOD),
    Case("clamped disc, uniform load", 1 / 64, "deflection of the middle",
         lambda rung: uniform(rung, ROUND, True, (0, 0)), GOOD),
    Case("Morley's skew plate", 0.000408, "deflection of the middle", skew,
         {"shell": Bound(0.03), "facet": Bound(0.3), "plate": Bound(0.5)}),
    Case("clamped square, large deflection", LEVY[:, 1], "deflection over thickness", large,
         {"shell": Bound(0.03), "facet": Bound(0.05), "plate": Bound(0.06)}, LEVY[:, 0], axis="load", holds=0.03),
]  # fmt: skip


@each_rung(CASES)
def test_published_number(case, rung):
    case.check(rung)


def test_sides_of_a_plate_are_found():
    """What the cases above hold is all of the rim."""
    model, mesh = held_plate("shell", SQUARE, False)
    x, y, _ = model.positions().T
    assert set(model.index(model.select(boundary="outer"))) == set(np.concatenate(
        [on(x, 0), on(x, 1), on(y, 0), on(y, 1)]))  # fmt: skip
