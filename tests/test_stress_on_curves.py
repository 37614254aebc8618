"""Stress of sheets that are not flat at rest: closed forms, and what must not depend on where and how they lie."""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import kirigami as kg
from kirigami.elements.stiffness import RUNGS
from kirigami.results.smooth import known_stress, sectors, surface_stress
from kirigami.results.stress import SheetStress
from kirigami.results.yielding import YieldWatch
from kirigami.system.system import System

E, NU, T, R = 2e9, 0.34, 1e-3, 0.2
MATERIAL = kg.Material(E=E, nu=NU)
PLATE = E / (1 - NU**2)
Floats = NDArray[np.float64]


def squares(columns: int, rows: int, closed: bool = False) -> tuple[Floats, Floats, list[tuple[int, int, int]]]:
    """Coordinates u, v from 0 to 1 of the nodes of squares, cut alternately, and the facets; u may close to a ring."""
    u, v = (part.ravel() for part in np.meshgrid(np.arange(columns + 1 - closed), np.arange(rows + 1), indexing="ij"))
    facets = []
    for i in range(columns):
        for j in range(rows):
            a, b = i * (rows + 1) + j, (i + 1) % (columns + 1 - closed) * (rows + 1) + j
            facets += [(a, b, b + 1), (a, b + 1, a + 1)] if (i + j) % 2 else [(a, b, a + 1), (b, b + 1, a + 1)]
    return u / columns, v / rows, facets


def rolled(u: Floats, v: Floats) -> Floats:
    """An arch of one radian about y, hollow from above at its middle, 0.1 wide."""
    return np.column_stack([R * np.sin(u - 0.5), 0.1 * v, R * (1 - np.cos(u - 0.5))])


def modelled(rung: str, nodes: Floats, facets: list[tuple[int, int, int]], sets: dict[str, Floats] | None = None,
             **given: object) -> kg.Model:  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kg.KirigamiWarning)  # of meshes that are biased
        return kg.Model.from_mesh(kg.TriMesh(nodes, facets, sets), T, MATERIAL, rung, **given)


def moved(model: kg.Model, places: Floats) -> kg.Results:
    """Results with one step, the nodes at `places`."""
    results = kg.Results(System(model))
    results.append(kg.Step.at(model, 1.0, places - model.positions()))
    return results


def as_plate(stress: SheetStress, rung: str) -> SheetStress:
    """By shell facets, else what plate theory makes of the deformation: at free edges flat facets have no moment."""
    return stress if rung == "shell" else stress.by_plate_theory()


def in_space(stress: SheetStress, fibre: str) -> Floats:
    return np.einsum("mai,mab,mbj->mij", stress.axes, stress.tensor(fibre), stress.axes)


@pytest.mark.parametrize("rung", ("plate", "facet", "shell"))
def test_a_tube_under_pressure_and_pull(rung: str) -> None:
    """p r / t round it, p r / (2 t) along it, nothing in bending: a closed vessel."""
    u, v, facets = squares(32, 4, closed=True)
    angle = 2 * np.pi * u
    nodes = np.column_stack([R * np.cos(angle), R * np.sin(angle), 0.2 * v])
    ends = {"low": np.flatnonzero(v == 0), "high": np.flatnonzero(v == 1)}
    model = modelled(rung, nodes, facets, ends)
    low, high = model.select(boundary="low"), model.select(boundary="high")
    p = 100.0
    model.add(kg.Fix(low, "z"), kg.Fix(low[0], "y"), kg.Fix(low[16], "y"), kg.Fix(low[8], "x"))
    model.add(kg.Pressure(p), kg.EdgeLoad(high, (0, 0, 0.5 * p * R)))
    stress = kg.LinearStatic(model).run().stress(-1)
    far = {"plate": 0.06, "facet": 0.02, "shell": 0.005}[rung]
    mean = (stress.area[:, None, None] * stress.tensor()).sum(axis=0) / stress.area.sum()  # first axes run round
    np.testing.assert_allclose(mean / (p * R / T), np.diag((1, 0.5)), atol=far)
    if rung == "shell":
        for fibre in ("bottom", "middle", "top"):
            np.testing.assert_allclose(stress.principal(fibre) / (p * R / T), np.tile((1, 0.5), (256, 1)), atol=0.01)
        vector = np.einsum("mk,mki->mi", stress.directions()[:, 0], stress.axes)
        np.testing.assert_allclose(vector[:, 2], 0, atol=0.02)  # the larger one runs round


@pytest.mark.parametrize("rung", RUNGS)
def test_a_rolled_strip_made_flat(rung: str) -> None:
    """E t / (2 R (1 - nu^2)) at the faces: pulled where it was hollow, pushed beneath; nu times that along its axis."""
    u, v, facets = squares(20, 8)
    results = moved(modelled(rung, rolled(u, v), facets), np.column_stack([R * u, 0.1 * v, 0 * u]))
    stress = as_plate(results.stress(0), rung)
    bending = PLATE * T / (2 * R)
    across = 0.5 * (stress.tensor("top") - stress.tensor("bottom"))
    np.testing.assert_allclose(across[:, 0, 0], bending, rtol=2e-3)
    np.testing.assert_allclose(across[:, 1, 1], NU * bending, rtol=4e-3)
    np.testing.assert_allclose(across[:, 0, 1], 0, atol=2e-3 * bending)
    if rung == "shell":  # whose edges are as long as the arcs
        np.testing.assert_allclose(stress.von_mises("top"), bending * np.sqrt(1 - NU + NU**2), rtol=5e-3)


@pytest.mark.parametrize("rung", RUNGS)
def test_yield_is_seen_in_the_bending_of_a_curved_sheet(rung: str) -> None:
    """The strip made flat reaches von Mises' stress of cylindrical bending at its faces, above or below yield."""
    u, v, facets = squares(20, 8)
    reached = PLATE * T / (2 * R) * np.sqrt(1 - NU + NU**2)
    flat = np.column_stack([R * u, 0.1 * v, 0 * u])
    for yield_stress, share in ((0.8 * reached, 1.0), (1.25 * reached, 0.0)):
        mesh = kg.TriMesh(rolled(u, v), facets)
        soft = kg.Material(E=E, nu=NU, yield_stress=yield_stress, hardening=None)  # told, but without flow
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", kg.KirigamiWarning)
            results = moved(kg.Model.from_mesh(mesh, T, soft, rung), flat)
        watch = YieldWatch(results)
        assert watch.watched and watch.share(results[0]) == (pytest.approx(share), share > 0)


@cache
def turn() -> Floats:
    turned, _ = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))
    return np.asarray(turned * np.linalg.det(turned))


@pytest.mark.parametrize("shape", ("flat", "rolled", "folded"))
@pytest.mark.parametrize("rung", RUNGS)
def test_stress_turns_with_the_sheet(rung: str, shape: str) -> None:
    """Principal values, von Mises' and energies do not feel where the axes lie; the tensor in space turns. Of a sheet
    that is flat in its plane it is what it is when that lies level."""
    u, v, facets = squares(8, 4)
    nodes = rolled(u, v)
    if shape != "rolled":
        nodes = np.column_stack([R * u, 0.1 * v, 0 * u])
    if shape == "folded":
        nodes[:, 2] = 0.1 * np.maximum(u - 0.5, 0) + 0.15 * np.maximum(0.5 - u, 0)
    wave = np.column_stack([np.sin(3 * u + v), np.cos(2 * u - v), np.sin(4 * u * v + 1)])
    found = []
    for place in (np.eye(3), turn()):
        model = modelled(rung, nodes @ place.T, facets)
        first, second, third = model.mesh.nodes[model.mesh.triangles[0]]
        # facets look to where +z is, so that top and bottom may change with the turn
        side = np.sign(np.dot(np.cross(second - first, third - first), place[:, 2]))
        found.append((moved(model, (nodes + 1e-3 * wave) @ place.T).stress(0), side))
    (one, upper), (two, other) = found
    faces = ("bottom", "middle", "top")
    for fibre, same in zip(faces, faces if upper == other else faces[::-1]):
        size = np.abs(one.principal(fibre)).max()
        np.testing.assert_allclose(two.principal(same), one.principal(fibre), atol=1e-7 * size)
        np.testing.assert_allclose(two.von_mises(same), one.von_mises(fibre), atol=1e-7 * size)
        np.testing.assert_allclose(in_space(two, same), turn() @ in_space(one, fibre) @ turn().T, atol=1e-7 * size)
    np.testing.assert_allclose(two.bending_energy, one.bending_energy, rtol=1e-6, atol=1e-9 * one.bending_energy.max())
    np.testing.assert_allclose(two.membrane_energy, one.membrane_energy, rtol=1e-6)


@pytest.mark.parametrize("rung", RUNGS)
def test_moments_of_an_arch_carry_its_load(rung: str) -> None:
    """Clamped at one end, a force P along the tangent of the other: round the arch the moment is P R (1 - cos phi),
    phi from the loaded end, whatever the sheet is made of."""
    u, v, facets = squares(24, 6)
    ends = {"low": np.flatnonzero(u == 0), "high": np.flatnonzero(u == 1)}
    model = modelled(rung, rolled(u, v), facets, ends)
    low, high = model.select(boundary="low"), model.select(boundary="high")
    load = 1e-4
    rim = np.array([1 if 0 < k < len(high) - 1 else 0.5 for k in range(len(high))]) * load / (len(high) - 1)
    model.add(kg.Fix(low, clamp=True))
    for node, share in zip(sorted(high, key=lambda node: node.y), rim.tolist()):
        model.add(kg.NodalLoad(node, (share * np.cos(0.5), 0, share * np.sin(0.5))))
    stress = kg.LinearStatic(model).run().stress(-1)
    total = (stress.area[:, None, None] * stress.moment).sum(axis=0)
    assert abs(total[0, 0]) == pytest.approx(load * R**2 * (1 - np.sin(1.0)), rel=0.01)
    stored = stress.membrane_energy.sum() + stress.bending_energy.sum()
    results = kg.LinearStatic(model).run()
    assert stored == pytest.approx(sum(energy[-1] for energy in results.energy.values()), rel=1e-9)


@pytest.mark.parametrize("rung", ("facet", "shell"))
def test_nothing_is_averaged_over_an_edge_of_a_profile(rung: str) -> None:
    """An angle of 90 degrees, one leg pulled away from its edge, the other left alone: the edge knows both stresses."""
    u, v, facets = squares(8, 4)
    down, along = 0.2 * np.maximum(0.5 - u, 0), 0.2 * np.maximum(u - 0.5, 0)
    nodes = np.column_stack([along, 0.1 * v, down])
    strain = 1e-5
    results = moved(modelled(rung, nodes, facets), nodes * (1 + strain, 1, 1))
    stress, parts = surface_stress(results, 0), sectors(results)
    expected = PLATE * strain * np.sqrt(1 - NU + NU**2)
    edge = np.flatnonzero(u == 0.5)
    assert np.bincount(parts.node)[edge].tolist() == [2] * len(edge)
    for corner, mean in zip(parts.corner, results.stress(0).strain[:, 0, 0]):
        pulled = abs(mean) > 0.5 * strain
        np.testing.assert_allclose(stress[corner], expected * pulled, rtol=1e-4, atol=1e-6 * expected)


@pytest.mark.parametrize("rung", RUNGS)
def test_nothing_is_averaged_over_a_flat_fold_or_a_step_in_thickness(rung: str) -> None:
    """Where a fold runs, and where the sheet becomes thicker, nodes have a value on each side."""
    folded = kg.Sheet([(0, 0), (2, 0), (2, 1), (0, 1)], folds=[kg.Fold([(1, 0), (1, 1)])], thickness=T,
                      material=MATERIAL).mesh(0.5)  # fmt: skip
    u, v, facets = squares(4, 2)
    plain = kg.TriMesh(np.column_stack([2 * u, v, 0 * u]), facets)
    stepped = np.where(plain.nodes[plain.triangles, 0].mean(axis=1) > 1, 2 * T, T)
    for mesh, thickness in ((folded, T), (plain, stepped)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", kg.KirigamiWarning)
            results = kg.Results(System(kg.Model.from_mesh(mesh, thickness, MATERIAL, rung)))
        twice = np.bincount(sectors(results).node) == 2
        assert np.array_equal(twice, np.abs(mesh.nodes[:, 0] - 1) < 1e-9)


def test_pictures_have_the_stress_of_a_curved_sheet() -> None:
    u, v, facets = squares(12, 6)
    results = moved(modelled("shell", rolled(u, v), facets), np.column_stack([R * u, 0.1 * v, 0 * u]))
    found = known_stress(results)
    assert found is not None
    np.testing.assert_allclose(found, PLATE * T / (2 * R) * np.sqrt(1 - NU + NU**2), rtol=0.01)
