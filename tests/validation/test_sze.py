"""Sze, Liu and Lo, Popular benchmark problems for geometric nonlinear analysis of shells, Finite Elements in Analysis
and Design 40 (2004) 1551-1569: tables of S4R runs of another program.

Shells on at most 2,000 corner nodes; bars and flat facets on the same squares with parallel diagonals, their best.
"""

from functools import cache

import numpy as np
import pytest
from case import Bound, Case, Found, each_rung
from shells import around_x, at_zero, cylinder, grid, hemisphere, hold, near, pattern_of, surface

import kirigami as kg

CANTILEVER = np.array([[0.1, 0.103, 1.309], [0.2, 0.381, 2.493], [0.3, 0.763, 3.488], [0.4, 1.184, 4.292],
                       [0.5, 1.604, 4.933], [0.6, 2.002, 5.444], [0.7, 2.370, 5.855], [0.8, 2.705, 6.190],
                       [0.9, 3.010, 6.467], [1.0, 3.286, 6.698]])  # fmt: skip
ANNULUS = np.array([[0.1, 4.277, 5.876], [0.2, 6.725, 9.160], [0.3, 8.340, 11.213], [0.4, 9.529, 12.661],
                    [0.5, 10.468, 13.768], [0.6, 11.257, 14.674], [0.7, 11.970, 15.469], [0.8, 12.642, 16.202],
                    [0.9, 13.282, 16.886], [1.0, 13.891, 17.528]])  # fmt: skip
HEMISPHERE = np.array([[0.05, 0.855, 0.955], [0.1, 1.499, 1.840], [0.2, 2.321, 3.261], [0.3, 2.819, 4.339],
                       [0.4, 3.158, 5.196], [0.5, 3.406, 5.902], [0.6, 3.598, 6.497], [0.7, 3.750, 7.006],
                       [0.8, 3.875, 7.448], [0.9, 3.979, 7.835], [1.0, 4.067, 8.178]])  # fmt: skip
PULL_OUT = np.array([[0.025, 0.819, 0.864, 0.872], [0.05, 1.260, 1.471, 1.493], [0.1, 1.707, 2.217, 2.293],
                     [0.2, 2.079, 2.904, 3.106], [0.3, 2.257, 3.227, 3.452], [0.4, 2.376, 3.443, 3.632],
                     [0.5, 2.473, 3.653, 3.718], [0.525, 2.543, 4.061, 3.580], [0.6, 2.618, 4.274, 3.452],
                     [0.7, 2.672, 4.385, 3.378], [0.8, 2.710, 4.455, 3.332], [0.9, 2.741, 4.508, 3.297],
                     [1.0, 2.768, 4.551, 3.269]])  # fmt: skip
PINCHED = np.array([[0.05, 9.561], [0.1, 23.164], [0.125, 29.375], [0.15, 36.208], [0.175, 51.499], [0.2, 56.373],
                    [0.3, 65.498], [0.4, 70.424], [0.5, 73.790], [0.6, 76.331], [0.7, 78.451], [0.8, 80.218],
                    [0.9, 81.766], [1.0, 83.102]])  # fmt: skip
ROOF = np.array([[0.0877, 0.693], [0.1980, 1.638], [0.3473, 3.087], [0.4686, 4.477], [0.5647, 5.802],
                 [0.6381, 7.057], [0.6908, 8.237], [0.7246, 9.339], [0.7412, 10.358], [0.7421, 11.293],
                 [0.7286, 12.141], [0.7023, 12.903], [0.6649, 13.583], [0.6182, 14.188], [0.5643, 14.728],
                 [0.5055, 15.217], [0.4442, 15.676], [0.3830, 16.125], [0.3245, 16.590], [0.2717, 17.094],
                 [0.2272, 17.657], [0.1940, 18.299], [0.1750, 19.028], [0.1729, 19.852], [0.1905, 20.771],
                 [0.2303, 21.780], [0.2950, 22.875]])  # fmt: skip

FLAT = "flat facets of constant strain need finer meshes where the shell snaps"
SOFTER = (
    "from load factor 0.175 on the load is 5 to 6 % below the table on 4,459 corner nodes too, and within 1 % of this; "
    "solid bricks of another code bear what the shell bears, not what the table says"
)
# Load factors at the first six deflections of PINCHED: 30 x 16 bricks of CalculiX 2.20, benchmarks/pinched_solids.py.
SOLID = (0.04972, 0.09831, 0.12209, 0.14437, 0.16491, 0.18733)
HINGES = "hinges resist twisting up to twice as much as the sheet does"


def probed(results, table, probes):
    """Displacements (number, axis, sign) at the load factors of a table."""
    rows = [results.nearest(load) for load in table[:, 0]]
    return [[sign * results.u[row, number, axis] for number, axis, sign in probes] for row in rows]


def cantilever(rung):
    """3.1: L 10, b 1, h 0.1, E 1.2e6, nu 0, end force 4."""
    points, triangles, at = grid(16, 1, lambda u, v: (10 * u, v, 0 * u), pattern_of(rung))
    model, nodes = surface(rung, points, triangles, 0.1, kg.Material(1.2e6, 0.0))
    end = [nodes[k] for k in at[-1]]
    model.add(kg.Fix([nodes[k] for k in at[0]], clamp=True), kg.EdgeLoad(end, (0, 0, 4.0)))
    results = kg.LoadControl(model, targets=CANTILEVER[:, 0]).run()
    rows = [results.nearest(load) for load in CANTILEVER[:, 0]]
    return Found(
        [(-results.u[row, at[-1], 0].mean(), results.u[row, at[-1], 2].mean()) for row in rows], results
    )


def annulus(rung):
    """3.3: radii 6 and 10, h 0.03, E 21e6, nu 0, one lip of the slit clamped, the other lifted by 0.8 a length."""
    points, triangles, at = grid(40, 4, lambda u, v: (
        (6 + 4 * v) * np.cos(2 * np.pi * u), (6 + 4 * v) * np.sin(2 * np.pi * u), 0 * u), pattern_of(rung))  # fmt: skip
    model, nodes = surface(rung, points, triangles, 0.03, kg.Material(21e6, 0.0))
    model.add(kg.Fix([nodes[k] for k in at[0]], clamp=True), kg.EdgeLoad([nodes[k] for k in at[-1]], (0, 0, 0.8)))
    results = kg.LoadControl(model, targets=ANNULUS[:, 0], step=0.025).run()
    return Found(probed(results, ANNULUS, [(at[-1, 0], 2, 1), (at[-1, -1], 2, 1)]), results)


@cache
def pinched_hemisphere(rung):
    """3.4: R 10, h 0.04, a hole of 18 degrees, E 6.825e7, nu 0.3, four forces of 400."""
    model, nodes, points, radius = hemisphere(16, rung=rung)
    a, b = near(points, (radius, 0, 0)), near(points, (0, radius, 0))
    model.add(kg.NodalLoad(nodes[a], (-200, 0, 0)), kg.NodalLoad(nodes[b], (0, 200, 0)))
    results = kg.LoadControl(model, targets=HEMISPHERE[:, 0], step=0.025).run()
    return Found(probed(results, HEMISPHERE, [(b, 1, 1), (a, 0, -1)]), results)


@cache
def pull_out(rung):
    """3.5: R 4.953, L 10.35, h 0.094, E 10.5e6, nu 0.3125, two forces of 40,000; it snaps near 0.5."""
    radius, length = 4.953, 10.35
    model, nodes, points = cylinder(16, 12, radius, length, 0.094, kg.Material(10.5e6, 0.3125), rung)
    hold(model, nodes, {axis: at_zero(points[:, k]) for k, axis in enumerate("xyz")})
    probes = [(near(points, (0, 0, radius)), 2, 1), (near(points, (0, radius, 0)), 1, -1),
              (near(points, (length / 2, radius, 0)), 1, -1)]  # fmt: skip
    model.add(kg.NodalLoad(nodes[probes[0][0]], (0, 0, 1e4)))
    results = kg.LoadControl(model, targets=PULL_OUT[:, 0], step=0.025, on_instability="switch").run()
    return Found(probed(results, PULL_OUT, probes), results)


@cache
def pinched_cylinder(rung):
    """3.6: R 100, L 200, h 1, E 30e3, nu 0.3, two forces of 12,000; the load at the published deflections.

    Facets short around the cylinder, where the fold runs: on squares of 44 the fold snaps from row to row.
    """
    radius, length = 100.0, 200.0
    model, nodes, points = cylinder(60, 31, radius, length, 1.0, kg.Material(30e3, 0.3), rung)
    ends = at_zero(points[:, 0], length / 2)
    hold(model, nodes, {axis: at_zero(points[:, k]) for k, axis in enumerate("xyz")}, {"y": ends, "z": ends})
    a = near(points, (0, 0, radius))
    model.add(kg.NodalLoad(nodes[a], (0, 0, -3000)))
    results = kg.DisplacementControl(
        model, control=(nodes[a], "z"), to=-83.102, targets=-PINCHED[:, 1], step=1.0, on_instability="follow"
    ).run()
    return Found([results.lam[int(np.argmin(np.abs(-results.u[:, a, 2] - w)))] for w in PINCHED[:, 1]], results)


def half_cylinder(material):
    """3.7: R 101.6, L 304.8, h 3, one end clamped, a force of 2,000 at the crown of the other; the long edges neither
    lift nor turn about the axis. The deflection under the force."""
    radius, length, n = 101.6, 304.8, 24
    points, triangles, _ = grid(n, n, lambda u, v: (
        length * v, radius * np.cos(np.pi / 2 * u), radius * np.sin(np.pi / 2 * u)), pattern_of("shell"))  # fmt: skip
    model, nodes = surface("shell", points, triangles, 3.0, material, around_x(points))
    clamped = at_zero(points[:, 0])
    model.add(kg.Fix([nodes[k] for k in clamped], clamp=True))
    for axis, column in (("z", 2), ("y", 1)):
        held = sorted(set(at_zero(points[:, column])) - set(clamped))
        model.add(kg.Symmetry([nodes[k] for k in held], axis))
    tip = near(points, (length, 0, radius))
    model.add(kg.NodalLoad(nodes[tip], (0, 0, -1000)))
    results = kg.LoadControl(model, step=0.05).run()
    return Found(-results.u[-1, tip, 2], results)


def half_cylinder_isotropic(_):
    """E 2068.5, nu 0.3."""
    return half_cylinder(kg.Material(2068.5, 0.3))


def half_cylinder_layered(_):
    """Three layers at 90, 0 and 90 degrees from the axis: E 2068.5 along and 517.125 across, nu 0.3, G 795.6."""
    along, across = (kg.Orthotropic(2068.5, 517.125, 0.3, 795.6, angle=angle) for angle in (0.0, np.pi / 2))
    return half_cylinder(kg.Laminate(((across, 1.0), (along, 1.0), (across, 1.0))))


def hinged_roof(rung):
    """3.8: R 2540, half length 254, 0.2 rad, h 12.7, E 3102.75, nu 0.3, force of 3,000 at the centre."""
    radius, half, angle = 2540.0, 254.0, 0.1
    points, triangles, _ = grid(8, 8, lambda u, v: (
        radius * np.sin(angle * u), half * v, radius * np.cos(angle * u)), pattern_of(rung))  # fmt: skip
    model, nodes = surface(rung, points, triangles, 12.7, kg.Material(3102.75, 0.3), points * (1, 0, 1) / radius)
    edge = at_zero(points[:, 0], radius * np.sin(angle))
    hold(model, nodes, {"x": at_zero(points[:, 0]), "y": at_zero(points[:, 1])}, dict.fromkeys("xyz", edge))
    centre = near(points, (0, 0, radius))
    model.add(kg.NodalLoad(nodes[centre], (0, 0, -750)))
    results = kg.DisplacementControl(
        model, control=(nodes[centre], "z"), to=-ROOF[-1, 1], targets=-ROOF[:, 1], step=0.5
    ).run()
    return Found([results.lam[int(np.argmin(np.abs(-results.u[:, centre, 2] - w)))] for w in ROOF[:, 1]], results)


def roof_limits(rung):
    """The same: the limit load, and the least load behind it."""
    results = hinged_roof(rung).results
    centre = near(results.rest, (0, 0, 2540.0))
    down = -results.u[:, centre, 2]
    return Found([[results.lam[down < 15].max(), results.lam[down > 15].min()]], results)


CASES = [
    Case("cantilever under end shear", CANTILEVER[:, 1:], "shortening and deflection of the end", cantilever,
         {"shell": Bound(0.02), "facet": Bound(0.02), "plate": Bound(1.5, HINGES)}, CANTILEVER[:, 0]),
    Case("slit annular plate", ANNULUS[:, 1:], "lift of both corners of the lip", annulus,
         {"shell": Bound(0.02), "facet": Bound(0.05), "plate": Bound(0.3, HINGES)}, ANNULUS[:, 0]),
    Case("pinched hemisphere", HEMISPHERE[:, 1:], "deflections under both forces", pinched_hemisphere,
         {"shell": Bound(0.02), "facet": Bound(0.05), "plate": Bound(0.7, HINGES)}, HEMISPHERE[:, 0]),
    Case("pull-out of an open cylinder", PULL_OUT[:, 1:], "deflections of three points", pull_out,
         {"shell": Bound(0.02), "facet": Bound(0.1, FLAT), "plate": Bound(0.2, HINGES)}, PULL_OUT[:, 0]),
    Case("pinched cylinder with diaphragms", PINCHED[:, 0], "load at fourteen deflections", pinched_cylinder,
         {"shell": Bound(0.065, SOFTER, long=True)}, PINCHED[:, 1], axis="deflection", holds=0.05),
    Case("half cylinder under an end force", 171.5, "deflection under the force", half_cylinder_isotropic,
         {"shell": Bound(0.02, long=True)}),
    Case("layered half cylinder", 178.39, "deflection under the force", half_cylinder_layered,
         {"shell": Bound(0.02, long=True)}),
    Case("hinged roof", ROOF[:, 0], "load at 27 deflections", hinged_roof,
         {"shell": Bound(0.02), "facet": Bound(0.05), "plate": Bound(0.4, HINGES)}, ROOF[:, 1], axis="deflection",
         whole=True),
    Case("hinged roof, limits", [[0.7421, 0.1729]], "limit load and least load", roof_limits,
         {"shell": Bound(0.02), "facet": Bound(0.02), "plate": Bound(1.0, HINGES)}),
]  # fmt: skip


@each_rung(CASES)
def test_published_number(case, rung):
    case.check(rung)


def test_the_pull_out_snaps_once_and_is_told():
    """It was passed in silence once."""
    (snap,) = pull_out("shell").results.events
    assert snap.kind == "snap" and snap.energy > 0 and snap.bracket == pytest.approx((0.5, 0.5), abs=0.03)


@pytest.mark.long
def test_the_pinched_cylinder_bears_what_a_solid_bears():
    """Where the table is 6 % higher: another code, and no theory of shells."""
    np.testing.assert_allclose(pinched_cylinder("shell").values[: len(SOLID)], SOLID, rtol=0.02)


def test_the_hemisphere_is_stable_all_the_way():
    assert pinched_hemisphere("shell").results.stable.all()
