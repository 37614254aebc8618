"""Orthotropic sheets, laminates and varying thickness against classical lamination theory and closed forms.

Jones, Mechanics of Composite Materials (1999), chapters 2 and 4.
"""

import numpy as np
import pytest
from patterns import PATTERNS, line_load, on, rectangle
from test_shell_bending import curved_rows

import kirigami as kg
from kirigami.linalg import factorize
from kirigami.primitives.material import strain_turn

PLY = dict(E1=140e9, E2=10e9, nu12=0.3, G12=5e9)
SLANTED = kg.Orthotropic(**PLY, angle=0.5)
PAIR = kg.Laminate([(kg.Orthotropic(**PLY), 0.02), (SLANTED, 0.01), (kg.Material(3e9, 0.4), 0.02)])


def uniform_state(pattern, material, thickness, strain, curvature):
    """Small displacements of a square under uniform strain and curvature, and the forces (rows, 3) that hold it."""
    model = kg.Model.from_mesh(rectangle(pattern, 1, 1, 3), thickness, material, stiffness="shell")
    system = kg.System(model)
    kxx, kyy, kxy = curvature
    u = curved_rows(system, lambda x, y: 0.5 * (kxx * x**2 + kyy * y**2 + kxy * x * y))
    x, y, _ = model.positions().T
    exx, eyy, gxy = strain
    u[: len(x), 0] += exx * x + 0.5 * gxy * y
    u[: len(x), 1] += eyy * y + 0.5 * gxy * x
    force = (system.stiffness(constrained=False) @ u.ravel()).reshape(u.shape)
    return system, u, force


@pytest.mark.parametrize("material", [SLANTED, PAIR], ids=["slanted", "laminate"])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_uniform_strain_and_curvature_of_a_material_with_directions_are_exact(pattern, material):
    """Patch test, with coupling: the energy is (e, k) S (e, k) / 2, and no force is left inside."""
    fields = np.array([0.3, -0.2, 0.5, 1.0, 0.7, -0.8])
    system, u, force = uniform_state(pattern, material, 0.05, fields[:3], fields[3:])
    section = material.section(0.05)
    expected = fields @ section @ fields
    assert float((force * u).sum()) == pytest.approx(expected, rel=1e-7)
    x, y, _ = system.rest[: system.points].T
    inside = (x > 1e-9) & (x < 1 - 1e-9) & (y > 1e-9) & (y < 1 - 1e-9)
    size = np.abs(section @ fields).max()
    assert np.abs(force[: len(x)][inside]).max() < 1e-7 * size
    edges = system.edges
    inner = np.bincount(edges.edge.ravel()) == 2
    edge, row = edges.pairs
    assert np.abs(force[row[inner[edge]], :2]).max() < 1e-7 * size


def test_an_angle_turns_the_material():
    """Along the grain and across it a pull meets E1 and E2, at an angle the modulus of Jones (2.97)."""
    for angle in (0.0, 0.3, np.pi / 2):
        c, s = np.cos(angle), np.sin(angle)
        E1, E2, nu, G = (PLY[name] for name in ("E1", "E2", "nu12", "G12"))
        expected = 1 / (c**4 / E1 + s**4 / E2 + (1 / G - 2 * nu / E1) * s**2 * c**2)
        compliance = np.linalg.inv(kg.Orthotropic(**PLY, angle=angle).elasticity())
        assert 1 / compliance[0, 0] == pytest.approx(expected, rel=1e-12)
    isotropic = kg.Orthotropic(E1=2.0, E2=2.0, nu12=0.3, G12=2.0 / 2.6, angle=0.7)
    np.testing.assert_allclose(isotropic.section(0.1), kg.Material(2.0, 0.3).section(0.1), atol=1e-15)
    assert strain_turn(0.0).tolist() == np.eye(3).tolist()


def cross_ply(turned):
    """Layers of equal thickness without Poisson's ratio, along (False) and across (True) the strip."""
    plies = {turn: kg.Orthotropic(E1=8e9, E2=1e9, nu12=0.0, G12=1e9, angle=turn * np.pi / 2) for turn in (False, True)}
    return kg.Laminate([(plies[turn], 0.02 / len(turned)) for turn in turned])


@pytest.mark.parametrize("turned", [(False, True), (True, False), (True, False, True), (False, True, True, False)])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_cross_ply_strip_bends_as_lamination_theory_says(pattern, turned):
    """Cantilever, free to stretch: P L^3 / (3 b D'), D' = D11 - B11^2 / A11; and drawn in by B11 / A11 of its slope."""
    length, width, t = 4.0, 0.5, 0.02
    model = kg.Model.from_mesh(rectangle(pattern, length, width, 2), material=cross_ply(turned), stiffness="shell")
    x = model.positions()[:, 0]
    left, right = on(x, 0), on(x, length)
    model.add(kg.Fix([model.nodes[k] for k in left], clamp=True))
    system = kg.System(model)
    force, load = np.zeros_like(system.rest), line_load(system, right)
    force[:, 2] = load
    solution = system.displacement(factorize(system.stiffness()).solve(system.reduce(force)), 0.0)
    heights = np.linspace(-0.5, 0.5, len(turned) + 1) * t
    E = np.where(turned, 1e9, 8e9)
    A, B, D = ((E * np.diff(heights**power)).sum() / power for power in (1, 2, 3))
    effective = width * (D - B**2 / A)
    assert float(load @ solution[:, 2]) == pytest.approx(length**3 / (3 * effective), rel=5e-3)
    slope = length**2 / (2 * effective)
    # the strain of the middle surface is B / A times the curvature
    assert float(load @ solution[:, 0]) == pytest.approx(B / A * slope, rel=5e-3, abs=1e-6 * t * slope)


def test_faces_of_a_laminate_bear_what_their_layers_bear():
    """A cross-ply strip pulled along: each layer by its own modulus, the upper one is told on top."""
    mesh = kg.Sheet([(0, 0), (2, 0), (2, 1), (0, 1)]).mesh(0.5)
    model = kg.Model.from_mesh(mesh, material=cross_ply((True, False, True)), stiffness="shell")
    left, right = model.select(boundary="left"), model.select(boundary="right")
    model.add(kg.Fix(left, "xz"), kg.Fix(left[0], "y"), kg.Fix(right, "z"), kg.Prescribe(right, x=2e-3))
    results = kg.LinearStatic(model).run()
    stress = results.stress(-1)
    for fibre, modulus in (("top", 1e9), ("middle", 8e9), ("bottom", 1e9)):
        np.testing.assert_allclose(stress.tensor(fibre)[:, 0, 0], 1e-3 * modulus, rtol=1e-6)
    assert results.reaction(right, "x")[-1] == pytest.approx(1e-3 * 0.02 * (2 * 1e9 + 8e9) / 3, rel=1e-9)
    np.testing.assert_allclose(stress.by_plate_theory().force, stress.force, rtol=1e-9, atol=1e-3)


# ---- thickness that varies


@pytest.mark.parametrize("rung", ["facet", "shell"])
def test_a_pull_meets_thin_and_thick_parts_in_series(rung):
    sheet = kg.Sheet([(0, 0), (4, 0), (4, 1), (0, 1)], regions={"patch": [(1, 0), (2, 0), (2, 1), (1, 1)]})
    mesh = sheet.mesh(0.3)
    assert mesh.facet_areas[mesh.regions["patch"]].sum() == pytest.approx(1.0, rel=1e-9)
    one, two = 0.01, 0.03
    by_region = {None: one, "patch": two}
    x = mesh.nodes[mesh.triangles].mean(axis=1)[:, 0]
    by_facet = np.where((x > 1) & (x < 2), two, one)
    found = []
    for thickness in (by_region, by_facet, lambda x, y, z: np.where((x > 1) & (x < 2), two, one)):
        model = kg.Model.from_mesh(mesh, thickness, kg.Material(1e9, 0.0), stiffness=rung)
        left, right = model.select(boundary="left"), model.select(boundary="right")
        model.add(kg.Fix(left, "xz"), kg.Fix(left[0], "y"), kg.Fix(right, "z"), kg.Prescribe(right, x=1e-4))
        results = kg.LinearStatic(model).run()
        found.append(results.reaction(right, "x")[-1])
    assert found == pytest.approx([1e-4 / (3 / (1e9 * one) + 1 / (1e9 * two))] * 3, rel=1e-9)
    tension = results.stress(-1).tensor("top")[:, 0, 0] * np.where((x > 1) & (x < 2), two, one)
    np.testing.assert_allclose(tension, found[0], rtol=1e-6)


@pytest.mark.filterwarnings("ignore:the mesh is biased")
@pytest.mark.parametrize("rung", ["plate", "facet", "shell"])
def test_a_cantilever_with_a_thick_part_bends_as_a_beam(rung):
    """On a mesh of single diagonals, on which all rungs bend a strip without Poisson's ratio exactly enough."""
    length, one, two = 4.0, 0.01, 0.02
    mesh = rectangle("single", length, 0.5, 2)
    x = mesh.nodes[mesh.triangles].mean(axis=1)[:, 0]
    thick = (x > 1) & (x < 2)
    tips = []
    for thickness in (one, np.where(thick, two, one)):
        model = kg.Model.from_mesh(mesh, thickness, kg.Material(1e9, 0.0), stiffness=rung)
        left, right = model.select(boundary="left"), model.select(boundary="right")
        model.add(kg.Fix(left, clamp=True))
        model.add(kg.NodalLoad(right, (0, 0, 1e-3)))
        tips.append(kg.LinearStatic(model).run().position(right)[-1, :, 2].mean())
    cube = lambda a, b: (b**3 - a**3) / 3  # noqa: E731
    whole = cube(0, length)
    expected = (cube(0, 2) + cube(2, 3) / 8 + cube(3, 4)) / whole
    assert tips[1] / tips[0] == pytest.approx(expected, rel=2e-3 if rung == "shell" else 0.02)
