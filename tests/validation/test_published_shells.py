"""Numbers that others published for shells: within two per cent on at most 2,000 corner nodes.

Sources as in shells.py; the tables of Sze, Liu and Lo are those of their S4R runs, kept by MBDyn beside its own.
"""

import numpy as np
import pytest
from patterns import on
from shells import around_x, at_zero, cylinder, grid, hemisphere, hold, near, shell

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


def run(model, table, **options):
    results = kg.LoadControl(model, targets=table[:, 0], **options).run()
    assert len(results.rest) <= 2000
    return results


def deviation(results, table, probes):
    """Largest relative deviation of displacements (number, axis, sign) from the columns of a table."""
    rows = [int(np.argmin(np.abs(results.lam - load))) for load in table[:, 0]]
    found = np.array([[sign * results.u[row, number, axis] for number, axis, sign in probes] for row in rows])
    return float(np.abs(found / table[:, 1:] - 1).max())


def test_cantilever_under_end_shear():
    """Sze 3.1: L 10, b 1, h 0.1, E 1.2e6, nu 0, end force 4."""
    points, triangles, at = grid(16, 1, lambda u, v: (10 * u, v, 0 * u))
    model, nodes = shell(points, triangles, 0.1, kg.Material(1.2e6, 0.0))
    end = [nodes[k] for k in at[-1]]
    model.add(kg.Fix([nodes[k] for k in at[0]], clamp=True), kg.EdgeLoad(end, (0, 0, 4.0)))
    results = run(model, CANTILEVER)
    rows = [int(np.argmin(np.abs(results.lam - load))) for load in CANTILEVER[:, 0]]
    found = np.array([(-results.u[row, at[-1], 0].mean(), results.u[row, at[-1], 2].mean()) for row in rows])
    assert np.abs(found / CANTILEVER[:, 1:] - 1).max() < 0.02


def test_slit_annulus():
    """Sze 3.3: radii 6 and 10, h 0.03, E 21e6, nu 0, one lip of the slit clamped, the other lifted by 0.8 a length."""
    points, triangles, at = grid(40, 4, lambda u, v: (
        (6 + 4 * v) * np.cos(2 * np.pi * u), (6 + 4 * v) * np.sin(2 * np.pi * u), 0 * u))  # fmt: skip
    model, nodes = shell(points, triangles, 0.03, kg.Material(21e6, 0.0))
    model.add(kg.Fix([nodes[k] for k in at[0]], clamp=True), kg.EdgeLoad([nodes[k] for k in at[-1]], (0, 0, 0.8)))
    results = run(model, ANNULUS, step=0.025)
    assert deviation(results, ANNULUS, [(at[-1, 0], 2, 1), (at[-1, -1], 2, 1)]) < 0.02


def test_pinched_hemisphere():
    """Sze 3.4: R 10, h 0.04, a hole of 18 degrees, E 6.825e7, nu 0.3, four forces of 400."""
    model, nodes, points, radius = hemisphere(16)
    a, b = near(points, (radius, 0, 0)), near(points, (0, radius, 0))
    model.add(kg.NodalLoad(nodes[a], (-200, 0, 0)), kg.NodalLoad(nodes[b], (0, 200, 0)))
    results = run(model, HEMISPHERE, step=0.025)
    assert results.stable.all()
    assert deviation(results, HEMISPHERE, [(b, 1, 1), (a, 0, -1)]) < 0.02


def test_pull_out_of_an_open_cylinder():
    """Sze 3.5: R 4.953, L 10.35, h 0.094, E 10.5e6, nu 0.3125, two forces of 40,000; it snaps near 0.5."""
    radius, length = 4.953, 10.35
    model, nodes, points = cylinder(16, 12, radius, length, 0.094, kg.Material(10.5e6, 0.3125))
    hold(model, nodes, {axis: at_zero(points[:, k]) for k, axis in enumerate("xyz")})
    probes = [(near(points, (0, 0, radius)), 2, 1), (near(points, (0, radius, 0)), 1, -1),
              (near(points, (length / 2, radius, 0)), 1, -1)]  # fmt: skip
    model.add(kg.NodalLoad(nodes[probes[0][0]], (0, 0, 1e4)))
    results = run(model, PULL_OUT, step=0.025, on_instability="switch")
    (snap,) = results.events  # it was passed in silence once
    assert snap.kind == "snap" and snap.energy > 0 and snap.bracket == pytest.approx((0.5, 0.5), abs=0.03)
    assert deviation(results, PULL_OUT, probes) < 0.02


@pytest.mark.long
def test_pinched_cylinder_with_diaphragms():
    """Sze 3.6: R 100, L 200, h 1, E 30e3, nu 0.3, two forces of 12,000; the load at the published deflections."""
    radius, length = 100.0, 200.0
    model, nodes, points = cylinder(44, 44, radius, length, 1.0, kg.Material(30e3, 0.3))
    ends = at_zero(points[:, 0], length / 2)
    hold(model, nodes, {axis: at_zero(points[:, k]) for k, axis in enumerate("xyz")}, {"y": ends, "z": ends})
    a = near(points, (0, 0, radius))
    model.add(kg.NodalLoad(nodes[a], (0, 0, -3000)))
    results = kg.DisplacementControl(
        model, control=(nodes[a], "z"), to=-83.102, targets=-PINCHED[:, 1], step=1.0, on_instability="follow"
    ).run()
    found = np.array([results.lam[int(np.argmin(np.abs(-results.u[:, a, 2] - w)))] for w in PINCHED[:, 1]])
    assert np.abs(found / PINCHED[:, 0] - 1).max() < 0.05


def test_hinged_roof():
    """Sze 3.8: R 2540, half length 254, 0.2 rad, h 12.7, E 3102.75, nu 0.3: limit load 0.7421 and least load 0.1729."""
    radius, half, angle = 2540.0, 254.0, 0.1
    points, triangles, _ = grid(8, 8, lambda u, v: (
        radius * np.sin(angle * u), half * v, radius * np.cos(angle * u)))  # fmt: skip
    normals = points * (1, 0, 1) / radius
    model, nodes = shell(points, triangles, 12.7, kg.Material(3102.75, 0.3), normals)
    edge = at_zero(points[:, 0], radius * np.sin(angle))
    hold(model, nodes, {"x": at_zero(points[:, 0]), "y": at_zero(points[:, 1])}, dict.fromkeys("xyz", edge))
    centre = near(points, (0, 0, radius))
    model.add(kg.NodalLoad(nodes[centre], (0, 0, -750)))
    results = kg.DisplacementControl(model, control=(nodes[centre], "z"), to=-22.0, step=0.5).run()
    down = -results.u[:, centre, 2]
    assert results.lam[down < 15].max() == pytest.approx(0.7421, rel=0.02)
    assert results.lam[down > 15].min() == pytest.approx(0.1729, rel=0.02)


BUCKLING = {("supported", "compression"): 4.0, ("clamped", "compression"): 10.07, ("supported", "shear"): 9.325,
            ("clamped", "shear"): 14.64}  # fmt: skip


@pytest.mark.parametrize("edges, drive", BUCKLING)
def test_buckling_of_square_plates(edges, drive):
    """k = N b^2 / (pi^2 D): 4 exactly, the others refined values (Timoshenko and Gere; shear 9.325 and 14.64)."""
    thickness, material = 0.01, kg.Material(1e6, 0.3)
    mesh = kg.Sheet([(0, 0), (1, 0), (1, 1), (0, 1)]).mesh(0.12)
    model = kg.Model.from_mesh(mesh, thickness, material, stiffness="shell")
    x, y, _ = model.positions().T
    sides = {"left": on(x, 0), "right": on(x, 1), "bottom": on(y, 0), "top": on(y, 1)}
    outer = [model.nodes[k] for k in np.unique(np.concatenate(list(sides.values())))]
    model.add(kg.Fix(outer, "z", clamp=edges == "clamped"))
    pull = {"left": (1, 0, 0), "right": (-1, 0, 0)} if drive == "compression" else {
        "left": (0, -1, 0), "right": (0, 1, 0), "bottom": (-1, 0, 0), "top": (1, 0, 0)}  # fmt: skip
    for side, force in pull.items():
        model.add(kg.EdgeLoad([model.nodes[k] for k in sides[side]], force))
    first, second = near(model.positions(), (0, 0, 0)), near(model.positions(), (1, 0, 0))
    model.add(kg.Fix(model.nodes[first], "xy"), kg.Fix(model.nodes[second], "y"))
    rigidity = material.E * thickness**3 / (12 * (1 - material.nu**2))
    value = kg.Buckling(model, n=1).run().values[0]
    assert value / (np.pi**2 * rigidity) == pytest.approx(BUCKLING[edges, drive], rel=0.02)


def test_roof_of_scordelis_and_lo():
    """MacNeal and Harder: R 25, L 50, 80 degrees, h 0.25, E 4.32e8, nu 0, gravity 90 an area: 0.3024 at the edge."""
    radius, length, angle, n = 25.0, 50.0, np.radians(40), 8
    points, triangles, at = grid(n, n, lambda u, v: (
        radius * np.sin(angle * u), 0.5 * length * v, radius * np.cos(angle * u)))  # fmt: skip
    model, nodes = shell(points, triangles, 0.25, kg.Material(4.32e8, 0.0), points * (1, 0, 1) / radius)
    ends = at_zero(points[:, 1], length / 2)
    hold(model, nodes, {"x": at_zero(points[:, 0]), "y": at_zero(points[:, 1])}, {"x": ends, "z": ends})
    model.add(kg.AreaLoad((0, 0, -90.0)))
    assert -kg.LinearStatic(model).run().u[-1, at[-1, 0], 2] == pytest.approx(0.3024, rel=0.02)


def test_pinched_cylinder_of_the_obstacle_course():
    """R 300, L 600, h 3, E 3e6, nu 0.3, two unit forces: 1.8248e-5 under them."""
    radius, length = 300.0, 600.0
    model, nodes, points = cylinder(24, 24, radius, length, 3.0, kg.Material(3e6, 0.3))
    ends = at_zero(points[:, 0], length / 2)
    hold(model, nodes, {axis: at_zero(points[:, k]) for k, axis in enumerate("xyz")}, {"y": ends, "z": ends})
    a = near(points, (0, 0, radius))
    model.add(kg.NodalLoad(nodes[a], (0, 0, -0.25)))
    assert -kg.LinearStatic(model).run().u[-1, a, 2] == pytest.approx(1.8248e-5, rel=0.02)


def test_hemisphere_of_the_obstacle_course():
    """As the pinched one, with forces of 2: 0.0930 to 0.0940 by the sources."""
    model, nodes, points, radius = hemisphere(12)
    a, b = near(points, (radius, 0, 0)), near(points, (0, radius, 0))
    model.add(kg.NodalLoad(nodes[a], (1, 0, 0)), kg.NodalLoad(nodes[b], (0, -1, 0)))
    assert 0.0930 * 0.99 < kg.LinearStatic(model).run().u[-1, a, 0] < 0.0940 * 1.01


def test_normals_found_from_the_mesh_are_as_good_as_exact_ones():
    """The linear hemisphere with the normals that the facets find themselves, also at its free and mirror edges."""
    found = []
    for exact in (True, False):
        model, nodes, points, radius = hemisphere(12, exact)
        a, b = near(points, (radius, 0, 0)), near(points, (0, radius, 0))
        model.add(kg.NodalLoad(nodes[a], (1, 0, 0)), kg.NodalLoad(nodes[b], (0, -1, 0)))
        found.append(kg.LinearStatic(model).run().u[-1, a, 0])
    assert found[1] == pytest.approx(found[0], rel=0.01)
    assert around_x(np.array([[3.0, 0.0, 2.0]])).tolist() == [[0.0, 0.0, 1.0]]
