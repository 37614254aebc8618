"""Strain and curvature that a sheet takes by itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from held_to_differences import assert_right

import kirigami as kg

E, NU, THICKNESS = 1e5, 0.3, 0.02


def sheet(length: float = 2.0, width: float = 0.6, edge: float = 0.5, **options: Any) -> kg.Model:
    mesh = kg.Sheet(shapely.box(0, 0, length, width)).mesh(edge)
    return kg.Model.from_mesh(mesh, THICKNESS, kg.Material(E, NU), stiffness=options.get("rung", "shell"))


def loosely(m: kg.Model) -> kg.Model:
    """Held at three corners against rigid motions alone."""
    x = m.positions()
    corners = (0, 0), (x[:, 0].max(), 0), (0, 0.6)
    at = [int(np.argmin(np.linalg.norm(x[:, :2] - corner, axis=1))) for corner in corners]
    m.add(kg.Fix(m.nodes[at[0]]), kg.Fix(m.nodes[at[1]], "yz"), kg.Fix(m.nodes[at[2]], "z"))
    return m


def test_the_kernel_belongs_to_its_energy() -> None:
    m = sheet()
    m.add(kg.Actuate([0, 1, 4], (0.1, -0.2, 0.05), (0.3, -0.2, 0.1)))
    m.add(kg.Actuate(strain=(0.02, 0.01, 0), constant=True), kg.Fix(m.nodes))
    system = kg.System(m)
    x = system.rest + np.random.default_rng(0).normal(scale=0.03, size=system.rest.shape)
    assert_right(system.kernels[0], x, balanced=True)


def test_a_free_sheet_takes_any_uniform_strain_without_stress() -> None:
    """Axes are those of the drawing, however facets lie: C = 1 + 2 e is reached exactly, and nothing bears anything."""
    strain = (0.05, -0.03, 0.04)
    m = loosely(sheet())
    m.add(kg.Actuate(strain=strain))
    res = kg.LoadControl(m, tol=1e-11).run()
    rest, now = m.positions()[:, :2], res.position()[-1]
    gradient = np.linalg.lstsq(rest - rest[0], now - now[0], rcond=None)[0].T
    green = 0.5 * (gradient.T @ gradient - np.eye(2))
    assert green == pytest.approx(np.array([[0.05, 0.02], [0.02, -0.03]]), abs=1e-9)
    assert np.abs(res.force("shell")[-1]).max() < 1e-7 * E * THICKNESS
    assert res.energy["shell"].max() < 1e-12
    assert np.abs(res.stress().tensor("top")[-1]).max() < 1e-6 * E


def test_heat_between_walls() -> None:
    """A strip that may swell across but not along bears E t alpha dT per width; linear analysis says the same."""
    m = sheet()
    ends = m.select(boundary="left") + m.select(boundary="right")
    m.add(kg.Fix(ends, "xz"), kg.Fix(m.nodes[0], "y"), kg.Actuate(strain=(1e-4, 1e-4, 0)))
    for res in (kg.LinearStatic(m).run(), kg.LoadControl(m).run()):
        assert res.reaction("right", "x")[-1] == pytest.approx(-E * THICKNESS * 1e-4 * 0.6, rel=1e-3)
        assert res.stress().tensor("top")[-1][:, 0, 0] == pytest.approx(-E * 1e-4, rel=1e-3)


def test_a_bimetal_strip_bends_to_the_circle_of_timoshenko() -> None:
    """Two equal layers whose free strains differ by d: radius 2 t / (3 d); here through more than a right angle."""
    d = 0.016
    curvature = 3 * d / (2 * THICKNESS)
    m = sheet(2.0, 0.3, 0.3)
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Actuate(curvature=(curvature, 0, 0)))
    res = kg.LoadControl(m).run()
    tip = res.position(m.select(boundary="right"))[-1].mean(axis=0)
    assert curvature * 2.0 > np.pi / 2
    assert tip[0] == pytest.approx(np.sin(2.0 * curvature) / curvature, abs=0.005 * 2.0)
    assert tip[2] == pytest.approx((1 - np.cos(2.0 * curvature)) / curvature, rel=0.005)  # towards the normal
    assert res.curvature("principal", per="node")[-1].max() == pytest.approx(curvature, rel=0.02)


def test_held_saved_and_in_parts(tmp_path: Any) -> None:
    """What the load factor has reached stays in a next stage; files tell the same; parts add up."""
    m = loosely(sheet())
    m.add(kg.Actuate([0, 1, 2], curvature=(0.2, 0, 0)), kg.Actuate(strain=(0.01, 0, 0)))
    res = kg.LoadControl(m, targets=[0.5, 1.0]).run()
    half = int(np.argmin(np.abs(res.lam - 0.5)))
    back = kg.load(res.save(tmp_path / "actuated"))
    assert back.force("shell") == pytest.approx(res.force("shell"), abs=1e-12)
    m.hold(res[half])
    m.add(kg.NodalLoad(m.nodes[0], (1e-9, 0, 0)))
    after = kg.LoadControl(m, start=res[half]).run()
    assert after[-1].u == pytest.approx(res[half].u, abs=1e-6)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(kg.ModelError, match="other than zero"):
        kg.Actuate()
    with pytest.raises(kg.ModelError, match="strain"):
        kg.Actuate(strain=(1, 2))
    m = sheet(rung="plate")
    m.add(kg.Fix(m.nodes[:4]), kg.Actuate(strain=(0.1, 0, 0)))
    with pytest.raises(kg.ModelError, match="needs the sheet of a mesh with stiffness='shell'"):
        kg.System(m)
    m = sheet()
    m.add(kg.Actuate("nowhere", strain=(0.1, 0, 0)))
    with pytest.raises(kg.ModelError, match="no region 'nowhere'"):
        kg.System(m)
