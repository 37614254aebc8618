"""The linear obstacle course: MacNeal and Harder, A proposed standard set of problems to test finite element
accuracy, Finite Elements in Analysis and Design 1 (1985) 3-20; Belytschko et al., Stress projection for membrane and
shear locking in shell finite elements, Computer Methods in Applied Mechanics and Engineering 51 (1985) 221-258.
"""

import numpy as np
from case import Bound, Case, Found, each_rung
from shells import at_zero, cylinder, grid, hemisphere, hold, near, pattern_of, surface

import kirigami as kg

CONSTANT = "membrane of constant strain, which bends in its plane and along curved generators too stiffly"
HINGES = "hinges resist twisting up to twice as much as the sheet does"


def roof(rung):
    """Scordelis and Lo: R 25, L 50, 80 degrees, h 0.25, E 4.32e8, nu 0, gravity 90 an area; at mid-edge."""
    radius, length, angle, n = 25.0, 50.0, np.radians(40), 8
    points, triangles, at = grid(n, n, lambda u, v: (
        radius * np.sin(angle * u), 0.5 * length * v, radius * np.cos(angle * u)), pattern_of(rung))  # fmt: skip
    model, nodes = surface(rung, points, triangles, 0.25, kg.Material(4.32e8, 0.0), points * (1, 0, 1) / radius)
    ends = at_zero(points[:, 1], length / 2)
    hold(model, nodes, {"x": at_zero(points[:, 0]), "y": at_zero(points[:, 1])}, {"x": ends, "z": ends})
    model.add(kg.AreaLoad((0, 0, -90.0)))
    results = kg.LinearStatic(model).run()
    return Found(-results.u[-1, at[-1, 0], 2], results)


def pinched_cylinder(rung):
    """R 300, L 600, h 3, E 3e6, nu 0.3, diaphragms, two unit forces; under them."""
    radius, length = 300.0, 600.0
    model, nodes, points = cylinder(24, 24, radius, length, 3.0, kg.Material(3e6, 0.3), rung)
    ends = at_zero(points[:, 0], length / 2)
    hold(model, nodes, {axis: at_zero(points[:, k]) for k, axis in enumerate("xyz")}, {"y": ends, "z": ends})
    a = near(points, (0, 0, radius))
    model.add(kg.NodalLoad(nodes[a], (0, 0, -0.25)))
    results = kg.LinearStatic(model).run()
    return Found(-results.u[-1, a, 2], results)


def pinched_hemisphere(rung):
    """R 10, h 0.04, a hole of 18 degrees, E 6.825e7, nu 0.3, four forces of 2; sources say 0.0930 to 0.0940."""
    model, nodes, points, radius = hemisphere(12, rung=rung)
    a, b = near(points, (radius, 0, 0)), near(points, (0, radius, 0))
    model.add(kg.NodalLoad(nodes[a], (1, 0, 0)), kg.NodalLoad(nodes[b], (0, -1, 0)))
    results = kg.LinearStatic(model).run()
    return Found(results.u[-1, a, 0], results)


def twisted_beam(rung, force):
    """L 12, b 1.1, h 0.32, turned by 90 degrees from root to tip, E 29e6, nu 0.22, unit force at the tip."""
    points, triangles, at = grid(24, 4, lambda u, v: (
        12 * u, 1.1 * (v - 0.5) * np.cos(np.pi / 2 * u), 1.1 * (v - 0.5) * np.sin(np.pi / 2 * u)),
        pattern_of(rung))  # fmt: skip
    along = np.pi / 2 * points[:, 0] / 12
    offset = np.where(np.cos(along) > 0.5, points[:, 1] / np.maximum(np.cos(along), 1e-9), 0.0)
    offset = np.where(np.cos(along) > 0.5, offset, points[:, 2] / np.maximum(np.sin(along), 1e-9))
    turn = offset * np.pi / 24
    tangent = np.stack([0 * along + 1, -turn * np.sin(along), turn * np.cos(along)], axis=1)
    across = np.stack([0 * along, np.cos(along), np.sin(along)], axis=1)
    normals = np.cross(tangent, across)
    model, nodes = surface(rung, points, triangles, 0.32, kg.Material(29e6, 0.22),
                           normals / np.linalg.norm(normals, axis=1)[:, None])  # fmt: skip
    model.add(kg.Fix([nodes[k] for k in at[0]], clamp=True))
    # at the tip the width stands along z
    model.add(kg.EdgeLoad([nodes[k] for k in at[-1]], np.array(force) / 1.1))
    results = kg.LinearStatic(model).run()
    return Found(results.u[-1, at[-1, 2]] @ np.array(force), results)


CASES = [
    Case("Scordelis-Lo roof", 0.3024, "sag of the edge", roof, {
        "shell": Bound(0.02), "facet": Bound(0.2, CONSTANT), "plate": Bound(0.4, CONSTANT)}),
    Case("pinched cylinder, linear", 1.8248e-5, "deflection under the force", pinched_cylinder, {
        "shell": Bound(0.02), "facet": Bound(0.1, CONSTANT), "plate": Bound(0.05)}),
    Case("pinched hemisphere, linear", 0.0935, "deflection under the force", pinched_hemisphere, {
        "shell": Bound(0.015), "facet": Bound(0.03), "plate": Bound(0.7, HINGES)}),
    Case("twisted beam, force in its plane", 5.424e-3, "deflection of the tip",
         lambda rung: twisted_beam(rung, (0, 0, 1.0)), {
             "shell": Bound(0.02), "facet": Bound(0.02), "plate": Bound(0.02)}),
    Case("twisted beam, force across it", 1.754e-3, "deflection of the tip",
         lambda rung: twisted_beam(rung, (0, 1.0, 0)), {
             "shell": Bound(0.02), "facet": Bound(0.1, CONSTANT), "plate": Bound(0.05, CONSTANT)}),
]  # fmt: skip


@each_rung(CASES)
def test_published_number(case, rung):
    case.check(rung)


def test_normals_found_from_the_mesh_are_as_good_as_exact_ones():
    """The linear hemisphere with the normals that the facets find themselves, also at its free and mirror edges."""
    found = []
    for exact in (True, False):
        model, nodes, points, radius = hemisphere(12, exact)
        a, b = near(points, (radius, 0, 0)), near(points, (0, radius, 0))
        model.add(kg.NodalLoad(nodes[a], (1, 0, 0)), kg.NodalLoad(nodes[b], (0, -1, 0)))
        found.append(kg.LinearStatic(model).run().u[-1, a, 0])
    assert abs(found[1] / found[0] - 1) < 0.01
