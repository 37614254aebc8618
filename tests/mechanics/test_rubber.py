"""Neo-Hookean sheets: closed forms of uniform stretch, the small-strain limit, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.elements.shell_rubber import membrane

E, THICKNESS = 1e6, 0.01
RUBBER = kg.NeoHookean(E, expansion=1e-2)


def strip(material: Any = RUBBER, edge: float = 0.4) -> kg.Model:
    mesh = kg.Sheet(shapely.box(0, 0, 2, 1)).mesh(edge)
    return kg.Model.from_mesh(mesh, THICKNESS, material, stiffness="shell")


def pulled(m: kg.Model, shift: float) -> kg.Results:
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, "xz"), kg.Fix(left[0], "y"), kg.Fix(right, "z"), kg.Prescribe(right, x=shift))
    return kg.DisplacementControl(m, tol=1e-10).run()


def test_the_law_belongs_to_its_energy_on_both_sides_of_its_end() -> None:
    random = np.random.default_rng(0)
    strain = np.concatenate([random.uniform(-0.3, 2.0, (50, 3)), random.uniform(-0.6, -0.38, (50, 3))])
    one = np.ones(len(strain))
    _, force, tangent = membrane(one, strain)
    step = 1e-6
    for k in range(3):
        after, before = (membrane(one, strain + sign * step * np.eye(3)[k]) for sign in (1, -1))
        scale = np.abs(force).max(axis=1)
        assert np.abs((after[0] - before[0]) / (2 * step) - force[:, k]).max() < 1e-7 * scale.max()
        wanted = (after[1] - before[1]) / (2 * step)
        assert np.abs(wanted - tangent[:, k]).max() < 1e-6 * np.abs(tangent).max()


def test_the_kernel_belongs_to_its_energy() -> None:
    """Also where it is heated, and beside facets that are not rubber."""
    stiff, count = kg.Material(E, 0.3, expansion=0.1), len(strip().mesh.triangles)
    m = strip([stiff if k % 3 == 0 else RUBBER for k in range(count)])
    m.add(kg.Actuate(heat=2.0), kg.Fix(m.nodes))
    system = kg.System(m)
    x = system.rest + np.random.default_rng(0).normal(scale=0.02, size=system.rest.shape)
    kernel = system.kernels[0]
    errors = kg.check_kernel(kernel, x, lam=0.7)
    assert max(errors.values()) < 1e-7, errors
    rate, (after, before) = kernel.by_load(x, 0.7), (kernel.evaluate(x, 0.7 + step, 1) for step in (1e-5, -1e-5))
    found = (after.gradient - before.gradient) / 2e-5
    assert np.abs(rate.gradient - found).max() < 1e-7 * np.abs(found).max()
    assert rate.energy.sum() == pytest.approx((after.energy - before.energy).sum() / 2e-5, rel=1e-7)


def test_a_strip_to_three_times_its_length_is_exact(tmp_path: Path) -> None:
    """N = (E t / 3) (a - 1 / a^2) per width, narrowed by a^(-1/2); the energy is what the pull works."""
    res = pulled(strip(), 4.0)
    a = 1 + res.lam * 2.0
    assert res.reaction("right", "x") == pytest.approx(E * THICKNESS / 3 * (a - a**-2), rel=1e-7, abs=1e-6)
    assert res.width("x") == pytest.approx(a**-0.5, rel=1e-7)
    stored = E * THICKNESS / 6 * 2.0 * (a**2 + 2 / a - 3)
    assert sum(res.energy.values()) == pytest.approx(stored, rel=1e-7, abs=1e-9)
    told = res.stress(-1)
    assert told.tensor("top")[:, 0, 0] == pytest.approx(E / 3 * (1 - 3.0**-3), rel=1e-6)
    assert told.membrane_energy.sum() == pytest.approx(stored[-1], rel=1e-6)
    again = kg.load(res.save(tmp_path / "rubber"))
    assert again.material == RUBBER
    assert again.stress(-1).tensor("top") == pytest.approx(told.tensor("top"), rel=1e-9)


def test_at_small_strain_it_is_the_elastic_sheet_of_poissons_ratio_one_half() -> None:
    """To the last digits that a linear law differs by: forces and bending alike."""
    elastic = kg.Material(E, 0.4999999999)
    one, other = (kg.System(strip(material)).stiffness(constrained=False) for material in (RUBBER, elastic))
    assert abs(one - other).max() < 1e-8 * abs(other).max()
    small = [pulled(strip(material), 2e-7).reaction("right", "x")[-1] for material in (RUBBER, elastic)]
    assert small[0] == pytest.approx(small[1], rel=1e-6)


def test_what_rubber_is_not() -> None:
    mesh = strip().mesh
    for rung in ("plate", "facet"):
        with pytest.raises(kg.ModelError, match="use stiffness='shell'"):
            kg.Model.from_mesh(mesh, THICKNESS, RUBBER, stiffness=rung)
    with pytest.raises(kg.ModelError, match="layer 0 must be linear elastic"):
        kg.Laminate([(RUBBER, 0.1)])
    for wrong in (0.0, -1.0, float("nan")):
        with pytest.raises(kg.ModelError, match="E must be"):
            kg.NeoHookean(wrong)
    soft = kg.Material(E, 0.3, yield_stress=1e3)
    m = strip([soft] + [RUBBER] * (len(mesh.triangles) - 1))
    m.add(kg.Fix(m.nodes))
    with pytest.raises(kg.ModelError, match="rubber in one place and yield in another"):
        kg.System(m)
