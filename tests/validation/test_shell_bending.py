"""Bending of shell facets on every pattern of mesh: uniform curvature, plates, no locking, roll-up, folds."""

import numpy as np
import pytest
from patterns import PATTERNS, line_load, on, rectangle

import kirigami as kg
from kirigami.linalg import factorize

CURVATURES = {"cylinder": (1, 0, 0), "sphere": (1, 1, 0), "saddle": (1, -1, 0), "twist": (0, 0, 1)}


def curved_rows(system, height):
    """Small displacements (rows, 3) of a sheet z = height(x, y): nodes, middles, and the angles of the edges."""
    edges = system.edges
    u = np.zeros_like(system.rest)
    x, y, _ = system.rest[: system.points].T
    u[: system.points, 2] = height(x, y)
    place = system.rest[edges.ends]
    middle = place.mean(axis=1)
    u[edges.middle, 2] = height(*middle[:, :2].T) - u[edges.ends, 2].mean(axis=1)
    along = place[:, 1] - place[:, 0]
    tangent = along / np.linalg.norm(along, axis=1)[:, None]
    step = 1e-5
    edge, row = edges.pairs
    for point, share in enumerate((0.5 - 0.5 / np.sqrt(3), 0.5 + 0.5 / np.sqrt(3))):
        x, y = (place[:, 0] + share * along)[:, :2].T
        across = np.stack([-tangent[:, 1], tangent[:, 0]])
        slope = (height(x + step * across[0], y + step * across[1])
                 - height(x - step * across[0], y - step * across[1])) / (2 * step)  # fmt: skip
        # the turn about the tangent is the slope to its left; angles count the other way
        u[row, point] = -(slope * edges.length)[edge]
    return u


@pytest.mark.parametrize("shape", CURVATURES)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_uniform_curvature_is_exact(pattern, shape):
    """Patch test of bending: the energy of plate theory, and no force inside."""
    kxx, kyy, kxy = CURVATURES[shape]
    E, nu, t = 2.0, 0.3, 0.05
    model = kg.Model.from_mesh(rectangle(pattern, 1, 1, 3), t, kg.Material(E, nu), stiffness="shell")
    system = kg.System(model)
    u = curved_rows(system, lambda x, y: 0.5 * (kxx * x**2 + kyy * y**2 + 2 * kxy * x * y))
    stiffness = system.stiffness(constrained=False)
    force = (stiffness @ u.ravel()).reshape(u.shape)
    D = E * t**3 / (12 * (1 - nu**2))
    expected = D * (kxx**2 + kyy**2 + 2 * nu * kxx * kyy + 2 * (1 - nu) * kxy**2)
    assert float((force * u).sum()) == pytest.approx(expected, rel=1e-7)
    edges = system.edges
    x, y, _ = model.positions().T
    inside = (x > 1e-9) & (x < 1 - 1e-9) & (y > 1e-9) & (y < 1 - 1e-9)
    inner = np.bincount(edges.edge.ravel()) == 2
    assert np.abs(force[: len(x)][inside]).max() < 1e-7 * D
    edge, row = edges.pairs
    assert np.abs(force[row[inner[edge]], :2] * edges.length[edge[inner[edge]], None]).max() < 1e-7 * D


def plate(pattern, across, clamped):
    """Centre deflection of a square plate under uniform load over that of plate theory."""
    nu, t = 0.3, 0.001
    model = kg.Model.from_mesh(rectangle(pattern, 1, 1, across), t, kg.Material(1.0, nu), stiffness="shell")
    x, y, _ = model.positions().T
    sides = np.unique(np.concatenate([on(x, 0), on(x, 1), on(y, 0), on(y, 1)]))
    model.add(kg.Fix([model.nodes[k] for k in sides], "z", clamp=clamped), kg.Fix(model.nodes, "xy"))
    system = kg.System(model)
    edges = system.edges
    corners = system.rest[edges.triangles]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    load = np.zeros_like(system.rest)
    np.add.at(load[:, 2], edges.triangles, area[:, None] / 3)
    np.add.at(load[:, 2], edges.middle[edges.edge], area[:, None] / 3)
    solution = system.displacement(factorize(system.stiffness()).solve(system.reduce(load)), 0.0)
    rigidity = t**3 / (12 * (1 - nu**2))
    # Energy norm: work of the load, which converges at twice the rate and needs no node in the centre.
    return float((load * solution).sum()) * rigidity


@pytest.mark.parametrize("pattern", PATTERNS)
def test_plates_converge(pattern):
    """Work of a uniform load p on a square plate of side a, times D / (p^2 a^6).

    Simply supported 64 / pi^8 sum over odd m, n of 1 / (m n (m^2 + n^2))^2 (Navier); clamped 3.8912e-4 (Taylor and
    Govindjee, 2004). The rate is the fourth, of which the test asks 2.5.
    """
    m = np.arange(1, 400, 2.0)
    a, b = np.meshgrid(m, m)
    supported = float((64 / np.pi**8 / (a * b * (a**2 + b**2)) ** 2).sum())
    for clamped, exact in ((False, supported), (True, 3.891200775e-4)):
        four, eight = (abs(plate(pattern, n, clamped) / exact - 1) for n in (4, 8))
        assert eight < 0.01 and eight < four / 2**2.5, (clamped, four, eight)


def rolled(pattern, across, along, thickness, angle, nu=0.0):
    """A strip rolled up by a moment at its free end: its energy over that of the arc, and the place of its end."""
    length, width = along / across, 1.0
    model = kg.Model.from_mesh(rectangle(pattern, length, width, across), thickness, kg.Material(1.0, nu),
                               stiffness="shell")  # fmt: skip
    x = model.positions()[:, 0]
    left, right = ([model.nodes[k] for k in on(x, place)] for place in (0, length))
    rigidity, bent = thickness**3 / 12 / (1 - nu**2), angle / length
    # Kept from moving sideways: under a moment that keeps its axis a strip buckles when turned by some 330 degrees.
    model.add(kg.Fix(left, "xz", clamp=True), kg.Fix(model.nodes, "y"))
    model.add(kg.EdgeMoment(right, rigidity * bent))
    results = kg.LoadControl(model).run()
    assert results.stable.all()
    energy = results.energy["shell"][-1] / (0.5 * rigidity * bent**2 * length * width)
    return energy, results.position(right)[-1].mean(axis=0) / length, results


@pytest.mark.parametrize("slenderness", [1.0, 0.1, 0.01, 0.001])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_bending_to_a_cylinder_does_not_lock(pattern, slenderness):
    """Energy under a given end moment is that of the arc, whatever the thickness, at 0.2 rad a facet."""
    energy, end, _ = rolled(pattern, 3, 8, 0.25 * slenderness, 8 * 0.2)
    # At t k = 0.2 thick-shell terms of (t k)^2 / 4, which the strain of the middle surface takes up, are seen.
    assert energy == pytest.approx(1, abs=0.02 if slenderness == 1.0 else 1e-3)
    assert end[[0, 2]] == pytest.approx([np.sin(1.6) / 1.6, (1 - np.cos(1.6)) / 1.6],
                                         abs=0.01 if slenderness == 1.0 else 2e-3)  # fmt: skip


@pytest.mark.parametrize("across, along, bound", [(2, 8, 0.03), pytest.param(4, 16, 0.003, marks=pytest.mark.long)])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_strip_rolls_up_to_a_circle(pattern, across, along, bound):
    """A full turn with 45 degrees a facet, and with half of that."""
    energy, end, _ = rolled(pattern, across, along, 0.005, 2 * np.pi)
    assert energy == pytest.approx(1, abs=bound)
    assert end[[0, 2]] == pytest.approx([0, 0], abs=bound / 2)


def two_arms(pattern, width, across):
    """A strip of two arms of length 1, the second the mirror image of the first, so that they meet node by node."""
    one = rectangle(pattern, 1.0, width, across)
    points, count = one.nodes[:, :2], len(one.nodes)
    number = np.where(points[:, 0] > 1 - 1e-9, np.arange(count), count + np.arange(count))
    every = np.concatenate([points, np.stack([2 - points[:, 0], points[:, 1]], axis=1)])
    triangles = np.concatenate([one.triangles, number[one.triangles][:, ::-1]])
    used, triangles = np.unique(triangles, return_inverse=True)
    return kg.TriMesh(every[used], triangles.reshape(-1, 3))


def folded_strip(degrees, pattern, across, sign=1):
    """Tip deflection of two arms joined at a sharp fold, clamped at one end and loaded across at the other, over beam
    theory (nu = 0, small displacements, the arm at right angles to the load's plane bends too)."""
    t, width = 0.01, 0.25
    angle = np.radians(degrees)
    mesh = two_arms(pattern, width, across)
    x, y, _ = mesh.nodes.T
    past = np.maximum(x - 1, 0)
    points = np.stack([np.minimum(x, 1) + past * np.cos(angle), y, sign * past * np.sin(angle)], axis=1)
    model = kg.Model.from_mesh(kg.TriMesh(points, mesh.triangles), t, kg.Material(1.0, 0.0), stiffness="shell")
    left, right = on(x, 0), on(x, 2)
    model.add(kg.Fix([model.nodes[k] for k in left], clamp=True))
    system = kg.System(model)
    normal = np.array([-sign * np.sin(angle), 0, np.cos(angle)])
    force = line_load(system, right)[:, None] * normal
    solution = system.displacement(factorize(system.stiffness()).solve(system.reduce(force)), 0.0)
    found = float((force * solution).sum())
    # Moment of the tip load at distance s from the tip: s in the loaded arm, cos(angle) r + 1 in the other.
    rigidity, c = width * t**3 / 12, np.cos(angle)
    first = 1 + c + c**2 / 3  # integral over r from 0 to 1 of (1 + c r)^2
    return found * rigidity / (1 / 3 + first)


@pytest.mark.parametrize("degrees", [90, 150])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_sharp_fold_needs_no_care(pattern, degrees):
    """Beam theory within 2 % with four and with eight facets an arm, folded to either side."""
    for across in (1, 2):
        for sign in (1, -1):
            assert folded_strip(degrees, pattern, across, sign) == pytest.approx(1, abs=0.02)


def test_thin_sheets_stay_solvable():
    """A clamped cantilever turned in space, from t / L = 1e-2 to 1e-5, on a random mesh."""
    mesh = rectangle("random", 4, 1, 4)
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    for thickness, bound in ((4e-2, 1e-3), (4e-4, 1e-3), (4e-5, 5e-3)):
        model = kg.Model.from_mesh(kg.TriMesh(mesh.nodes @ turn.T, mesh.triangles), thickness, kg.Material(1.0, 0.0),
                                   stiffness="shell")  # fmt: skip
        left, right = on(mesh.nodes[:, 0], 0), on(mesh.nodes[:, 0], 4)
        model.add(kg.Fix([model.nodes[k] for k in left], clamp=True))
        system = kg.System(model)
        force = line_load(system, right)[:, None] * turn[:, 2]
        solution = system.displacement(factorize(system.stiffness()).solve(system.reduce(force)), 0.0)
        assert float((force * solution).sum()) == pytest.approx(64 / (3 * thickness**3 / 12), rel=bound)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_faces_of_a_cylinder_bear_what_a_plate_bears(pattern):
    """E t / (2 R) round it on both faces, of the state that the forces belong to: all energy stored is in it."""
    thickness, angle = 0.0025, 8 * 0.2
    energy, _, results = rolled(pattern, 4, 8, thickness, angle)
    stress = results.stress(-1)
    bending = thickness * (angle / 2.0) / 2
    for fibre, sign in (("top", -1), ("bottom", 1)):
        np.testing.assert_allclose(stress.tensor(fibre)[:, 0, 0], sign * bending, rtol=0.01)
        np.testing.assert_allclose(stress.tensor(fibre)[:, 1, 1], 0, atol=0.01 * bending)
    total = stress.membrane_energy.sum() + stress.bending_energy.sum()
    assert total == pytest.approx(results.energy["shell"][-1], rel=1e-9)
