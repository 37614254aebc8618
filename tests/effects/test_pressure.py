"""Pressure that follows the facets: work, balance, its potential where there is one, and a membrane in closed form."""

from __future__ import annotations

import itertools
import warnings
from typing import Any

import numpy as np
import pytest
from held_to_differences import assert_right

import kirigami as kg
from kirigami.model.pressure import PressureKernel, RimPressureKernel

RUNGS = kg.stiffness.RUNGS
RANDOM = np.random.default_rng(8)


def square(rung: str, n: int = 3, size: float = 1.0, thickness: float = 0.02) -> kg.Model:
    x, y = np.meshgrid(np.linspace(0, size, n + 1), np.linspace(0, size, n + 1))
    corners = [(n + 1) * row + column for row in range(n) for column in range(n)]
    facets = [facet for a in corners for facet in ((a, a + 1, a + n + 2), (a, a + n + 2, a + n + 1))]
    mesh = kg.TriMesh(np.column_stack([x.ravel(), y.ravel()]), facets)
    return kg.Model.from_mesh(mesh, thickness, kg.Material(1e5, 0.3), stiffness=rung)


def octahedron() -> kg.Model:
    """A closed balloon of bars and hinges."""
    points = np.array([[1, 0, 0], [0, 1.1, 0], [-0.9, 0, 0], [0, -1, 0.1], [0, 0, 1.2], [0.1, 0, -1]])
    facets = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (1, 0, 5), (2, 1, 5), (3, 2, 5), (0, 3, 5)]
    m = kg.Model()
    nodes = m.add(*(kg.Node(*point) for point in points.tolist()))
    for facet in facets:
        m.add(kg.Facet(*(nodes[k] for k in facet), thickness=0.05, material=kg.Material(100.0, 0.3)))
    return m


def pressures(system: kg.System) -> list[Any]:
    return [kernel for kernel in system.kernels if isinstance(kernel, (PressureKernel, RimPressureKernel))]


def volume(x: np.ndarray, triangles: np.ndarray) -> float:
    i, j, k = (x[triangles[:, corner]] for corner in range(3))
    return float((i * np.cross(j, k)).sum() / 6)


@pytest.mark.parametrize("rung", ["plate", "shell"])
def test_the_potential_belongs_to_its_derivatives(rung: str) -> None:
    m = square(rung)
    m.add(kg.Fix(m.select(boundary="outer")), kg.Pressure(2.0))
    system = kg.System(m)
    x = system.rest + RANDOM.normal(scale=0.1, size=system.rest.shape)
    kernel = next(k for k in system.kernels if isinstance(k, PressureKernel))
    assert_right(kernel, x)
    assert system.conservative


@pytest.mark.parametrize("rung", ["plate", "shell"])
def test_forces_follow_the_facets_whatever_the_rim_does(rung: str) -> None:
    """Potential and rim together are p times the vector area: a third of each flat facet at its corners, and in all
    that of any surface with this rim. The rim's tangent is the symmetric part of the derivative of its forces."""
    m = square(rung)
    m.add(kg.Fix(m.select(boundary="left")), kg.Pressure(2.0))
    system = kg.System(m)
    x = system.rest + RANDOM.normal(scale=0.1, size=system.rest.shape)
    if rung == "shell":
        x[system.points :] = system.rest[system.points :]  # straight edges
    total = np.zeros_like(x)
    for kernel in pressures(system):
        np.add.at(total, kernel.conn, -kernel.evaluate(x, 1.0, 1).gradient)
    i, j, k = (x[m.mesh.triangles[:, corner]] for corner in range(3))
    area = np.cross(j - i, k - i) / 2
    wanted = np.zeros((system.points, 3))
    np.add.at(wanted, m.mesh.triangles, 2.0 * np.repeat(area[:, None], 3, axis=1) / 3)
    assert total[: system.points] == pytest.approx(wanted, abs=1e-14)
    rim = next(k for k in pressures(system) if not k.conservative)
    step = 1e-6
    for member in range(3):
        slope = np.zeros((rim.conn.shape[1], rim.conn.shape[1], 3, 3))
        for local, row in enumerate(rim.conn[member]):
            for axis in range(3):
                moved = [x.copy(), x.copy()]
                moved[0][row, axis] += step
                moved[1][row, axis] -= step
                ends = [rim.evaluate(y, 1.0, 1).gradient[member] for y in moved]
                slope[:, local, :, axis] = (ends[0] - ends[1]) / (2 * step)
        symmetric = 0.5 * (slope + slope.transpose(1, 0, 3, 2))
        assert rim.evaluate(x).hessian[member] == pytest.approx(symmetric, abs=1e-8)


def test_a_closed_balloon_works_p_dv() -> None:
    """No rim, no rest: the potential is -p V, the forces' work is p dV, and what is stored comes from there."""
    m = octahedron()
    m.add(kg.Fix(m.nodes[5]), kg.Fix(m.nodes[4], "xy"), kg.Fix(m.nodes[0], "y"), kg.Pressure(3.0))
    system = kg.System(m)
    (kernel,) = pressures(system)
    triangles = kernel.conn
    x, change = m.positions() + RANDOM.normal(scale=0.1, size=(6, 3)), RANDOM.normal(size=(6, 3))
    force = np.zeros((6, 3))
    np.add.at(force, triangles, -kernel.evaluate(x, 1.0, 1).gradient)
    step = 1e-4
    dv = (volume(x + step * change, triangles) - volume(x - step * change, triangles)) / (2 * step)
    assert (force * change).sum() == pytest.approx(3.0 * dv, rel=1e-7)
    wide, narrow = (kernel.evaluate(y, 1.0, 0).energy.sum() for y in (x + change, x))
    assert narrow - wide == pytest.approx(3.0 * (volume(x + change, triangles) - volume(x, triangles)), rel=1e-8)
    assert force.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    assert np.cross(x, force).sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    res = kg.LoadControl(m, targets=[0.999, 1.0], to=1.001, tol=1e-11).run()
    at = int(np.argmin(np.abs(res.lam - 1)))
    stored = sum(res.energy.values())
    space = [volume(position, triangles) for position in res.position()]
    assert space[at] > 1.05 * space[0]
    assert stored[at + 1] - stored[at - 1] == pytest.approx(3.0 * (space[at + 1] - space[at - 1]), rel=1e-5)
    assert np.abs(res.reaction(m.nodes)[at]).max() < 1e-8


@pytest.mark.parametrize("rung", RUNGS)
def test_a_held_rim_bears_the_pressure_on_its_own_area(rung: str) -> None:
    """However the sheet bulges, the resultant is p times the vector area, which the rim alone tells."""
    m = square(rung, 4)
    m.add(kg.Fix(m.select(boundary="outer")), kg.Pressure(20.0))
    res = kg.LoadControl(m).run()
    assert res.u[-1, :, 2].max() > 2 * 0.02
    assert res.reaction("fixed_0")[-1] == pytest.approx([0, 0, -20.0], abs=1e-6)


def test_a_free_rim_has_no_potential_and_is_followed_in_words() -> None:
    """What counts stability is refused; followed, the resultant is p times the vector area as it is."""
    m = square("plate", 3)
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Pressure(0.15))
    for refused in (kg.LoadControl(m, on_instability="switch"), kg.Buckling(m), kg.Eigen(m)):
        with pytest.raises(kg.ModelError, match="pressure at the rim have no potential.*on_instability='follow'"):
            refused.run()
    res = kg.LoadControl(m, tol=1e-10).run()
    assert res[-1].negative is None and "not counted" in str(res[-1])
    assert res.u[-1, :, 2].max() > 0.2
    x = res.position()[-1]
    i, j, k = (x[m.mesh.triangles[:, corner]] for corner in range(3))
    area = np.cross(j - i, k - i).sum(axis=0) / 2
    assert abs(area[0]) > 0.05
    assert res.reaction("fixed_0")[-1] == pytest.approx(-0.15 * area, abs=1e-8)


def test_planes_of_symmetry_keep_the_potential() -> None:
    """A quarter of a sheet does what the whole one does."""
    whole, quarter = square("shell", 4), square("shell", 2, 0.5)
    whole.add(kg.Fix(whole.select(boundary="outer")), kg.Pressure(5.0))
    quarter.add(kg.Fix(quarter.select(where=lambda x, y, z: (x < 1e-9) | (y < 1e-9))), kg.Pressure(5.0))
    quarter.add(kg.Symmetry(quarter.select(where=lambda x, y, z: (x > 0.499) & (y > 1e-9)), "x"))
    quarter.add(kg.Symmetry(quarter.select(where=lambda x, y, z: (y > 0.499) & (x > 1e-9)), "y"))
    assert kg.System(quarter).conservative
    one, two = (kg.LoadControl(m, tol=1e-10).run() for m in (whole, quarter))
    top = one.u[-1, :, 2].max()
    assert two.u[-1, :, 2].max() == pytest.approx(top, rel=0.05)  # the facets lie the other way in two quarters


def test_pressure_on_a_region_and_in_other_units(tmp_path: Any) -> None:
    found = []
    for length in (1.0, 1e3):
        m = square("shell", 3, length, 0.02 * length)
        m.remove(*m.constraints)
        m.add(kg.Fix(m.select(boundary="outer")), kg.Pressure(30.0, [8, 9]))
        res = kg.LoadControl(m, on_instability="follow").run()
        found.append(res.u[-1] / length)
        assert kg.load(res.save(tmp_path / f"{length:g}")).reaction("fixed_0")[-1] == pytest.approx(
            res.reaction("fixed_0")[-1], rel=1e-9, abs=1e-9 * length**2
        )
    assert found[1] == pytest.approx(found[0], abs=1e-6)
    m.hold(res[-1])
    (held,) = m.loads
    assert held.constant and held.p == pytest.approx(30.0)


def test_what_cannot_be_is_refused() -> None:
    m = square("plate")
    m.add(kg.Fix(m.select(boundary="outer")))
    for load, words in (
        (kg.Pressure(1.0, "nowhere"), "no region 'nowhere'"),
        (kg.Pressure(1.0, [99]), "numbers from 0 to 17"),
    ):
        m.add(load)
        with pytest.raises(kg.ModelError, match=words):
            kg.System(m)
        m.remove(load)
    with pytest.raises(kg.ModelError, match="p must be"):
        kg.Pressure(float("nan"))
    flat = kg.Model(dim=2)
    a, b, c = flat.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1))
    flat.add(kg.Facet(a, b, c, thickness=0.1, material=kg.Material(1.0)), kg.Pressure(1.0))
    with pytest.raises(kg.ModelError, match="dim=2"):
        kg.System(flat)
    turned = kg.Model()
    a, b, c, d = turned.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1), kg.Node(1, 1))
    turned.add(*(kg.Facet(*nodes, thickness=0.1, material=kg.Material(1.0)) for nodes in ((a, b, c), (b, c, d))))
    turned.add(kg.Pressure(1.0))
    with pytest.raises(kg.ModelError, match="turned against each other"):
        kg.System(turned)


def tube(inward: bool, turns: float = 1.0, long: float = 3.0) -> kg.Model:
    """A sleeve of a radius of 1, or a part of it."""
    n, rows = 16, 4
    angle, along = np.meshgrid(2 * np.pi * turns * np.arange(n + (turns < 1)) / n, np.linspace(0, long, rows + 1))
    points = np.column_stack([np.cos(angle).ravel(), np.sin(angle).ravel(), along.ravel()])
    count, facets = angle.shape[1], []
    for row in range(rows):
        for k in range(n):
            a, b = row * count + k, row * count + (k + 1) % count
            facets += [(a, b, b + count), (a, b + count, a + count)]
    facets = [facet[::-1] for facet in facets] if inward else facets
    return kg.Model.from_mesh(kg.TriMesh(points, facets), 0.01, kg.Material(1e6), stiffness="facet")


def test_a_tube_whose_normals_point_inwards_is_told() -> None:
    for inward, p, turns, long in itertools.product((True, False), (1.0, -1.0), (1.0, 0.5), (3.0, 60.0)):
        m = tube(inward, turns, long)
        m.add(kg.Pressure(p))
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            kg.System(m)
        said = [one for one in told if "point into it" in str(one.message)]
        assert len(said) == (inward and p > 0 and turns == 1.0)
    ball = octahedron()
    ball.add(kg.Pressure(1.0))
    flat = square("facet")
    flat.add(kg.Pressure(1.0))
    for m in (ball, flat):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            kg.System(m)


def test_inflated_square_membrane() -> None:
    """p = 1.994 (1 - 0.271 nu) E t h^3 / ((1 - nu) a^4) for a clamped square of side 2 a without initial stress, h the
    deflection of its middle (Maier-Schneider, Maibach and Obermeier, J. Microelectromech. Syst. 4 (1995), 238)."""
    E, nu, half, thickness, n = 1e5, 0.3, 1.0, 1e-3, 5
    x, y = np.meshgrid(*[half * np.sin(np.linspace(0, np.pi / 2, n + 1))] * 2)
    points = half - np.column_stack([x.ravel(), y.ravel()])
    corners = [(n + 1) * row + column for row in range(n) for column in range(n)]
    facets = [facet for a in corners for facet in ((a, a + 1, a + n + 2), (a, a + n + 2, a + n + 1))]
    m = kg.Model.from_mesh(kg.TriMesh(points, facets), thickness, kg.Material(E, nu), stiffness="shell")
    on = {name: m.select(where=where) for name, where in {
        "x": lambda x, y, z: (x > half - 1e-9) & (y > 1e-9), "y": lambda x, y, z: (y > half - 1e-9) & (x > 1e-9),
        "rim": lambda x, y, z: (x < 1e-9) | (y < 1e-9),
    }.items()}  # fmt: skip
    height = 0.1 * half
    p = 1.994 * (1 - 0.271 * nu) * E * thickness * height**3 / ((1 - nu) * half**4)
    m.add(kg.Fix(on["rim"]), kg.Symmetry(on["x"], "x"), kg.Symmetry(on["y"], "y"), kg.Pressure(p))
    res = kg.LoadControl(m, step=1e-4).run()
    middle = m.select(where=lambda x, y, z: (x > half - 1e-9) & (y > half - 1e-9))
    found = res.position(middle[0])[-1][2]
    assert found == pytest.approx(height, rel=0.01)
