"""What a net of bars and hinges is worth as a sheet: moduli and rigidities of periodic cells, strips and patches.

The numbers of the structured cells are exact rationals in the unit E (membrane) and c E t^3 (bending); those of the
equilateral cell are the classical triangulated membrane (Seung and Nelson, Phys. Rev. A 38, 1005 (1988)). The rows of
irregular meshes are means over seeds of an independent periodic homogenisation.
"""

from __future__ import annotations

import meshes
import numpy as np
import pytest
from homogenise import bending_matrix, membrane_matrix, moduli, rigidities

import kirigami as kg

STRUCTURED = {
    "equilateral": lambda: meshes.periodic_equilateral(2, 2),
    "one": lambda: meshes.periodic_right_isosceles("one"),
    "union jack": lambda: meshes.periodic_right_isosceles("union jack"),
    "alternating": lambda: meshes.periodic_right_isosceles("alternating"),
}

# mesh: (mean, least, largest) over directions of E / E and G / E; least and largest nu; E_x, nu_xy, G_xy
MEMBRANE = {
    "equilateral": ((1, 1, 1), (3 / 8, 3 / 8, 3 / 8), (1 / 3, 1 / 3), (1, 1 / 3, 3 / 8)),
    "one": ((0.8475, 1 / 3, 4 / 3), (None, 1 / 6, 1 / 2), (0, 1), (1, 0, 1 / 6)),
    "union jack": ((0.949, 3 / 4, 6 / 5), (None, 1 / 4, 1 / 2), (0.2, 0.5), (1.2, 0.2, 0.25)),
    "alternating": ((0.756, 4 / 7, 1), (None, 1 / 5, 1 / 2), (0, 3 / 7), (1, 0, 0.2)),
}


@pytest.mark.parametrize("name", STRUCTURED)
def test_moduli_of_structured_cells(name: str) -> None:
    found = moduli(membrane_matrix(meshes.unit_cell(STRUCTURED[name]())))
    young, shear, poisson, along_x = MEMBRANE[name]
    for values, (mean, least, largest) in ((found.young, young), (found.shear, shear)):
        if mean is not None:
            assert values.mean() == pytest.approx(mean, abs=5e-4)
        assert (values.min(), values.max()) == pytest.approx((least, largest), abs=5e-4)
    assert (found.poisson.min(), found.poisson.max()) == pytest.approx(poisson, abs=5e-4)
    assert (found.young[0], found.poisson[0], found.shear[0]) == pytest.approx(along_x, abs=1e-9)


def test_one_diagonal_shears_when_pulled() -> None:
    """Pulling the one-diagonal net along x shears it by minus the strain: gamma_xy / eps_x = -1."""
    compliance = np.linalg.inv(membrane_matrix(meshes.unit_cell(meshes.periodic_right_isosceles("one"))))
    assert compliance[2, 0] / compliance[0, 0] == pytest.approx(-1.0, abs=1e-9)


# mesh: D_cyl along x, along +45, along -45, mean over directions; least and largest B_beam, B_beam along x;
# sphere D (1 + nu); least and largest saddle D (1 - nu)
BENDING = {
    "equilateral": ((1, 1, 1, 1), (8 / 9, 8 / 9, 8 / 9), 2 / 3, (4 / 3, 4 / 3)),
    "one": ((1, 3, 1, 3 / 2), (2 / 3, 2, 0.8), 1, (1, 3)),
    "union jack": ((5 / 6, 4 / 3, 4 / 3, 13 / 12), (0.8, 1, 0.8), 2 / 3, (1, 2)),
    "alternating": ((1, 7 / 4, 7 / 4, 11 / 8), (1, 10 / 7, 1), 1, (1, 5 / 2)),
}


@pytest.mark.parametrize("name", STRUCTURED)
def test_rigidities_of_structured_cells(name: str) -> None:
    found = rigidities(bending_matrix(meshes.unit_cell(STRUCTURED[name]())))
    cylinder, beam, sphere, saddle = BENDING[name]
    values = (found.cylinder[0], found.cylinder[90], found.cylinder[270], found.cylinder.mean())
    assert values == pytest.approx(cylinder, abs=1e-9)
    assert (found.beam.min(), found.beam.max(), found.beam[0]) == pytest.approx(beam, abs=5e-4)
    assert found.sphere == pytest.approx(sphere, abs=1e-9)
    assert (found.saddle.min(), found.saddle.max()) == pytest.approx(saddle, abs=1e-9)


def test_bending_energy_of_the_one_diagonal_net() -> None:
    """density = c E t^3 / 2 [(Kyy + Kxy)^2 + (Kxx + Kxy)^2 + 4 Kxy^2] for any curvature."""
    matrix = bending_matrix(meshes.unit_cell(meshes.periodic_right_isosceles("one")))
    for kxx, kyy, kxy in np.random.default_rng(2).normal(size=(5, 3)):
        curvature = np.array([kxx, kyy, 2 * kxy])
        density = 0.5 * ((kyy + kxy) ** 2 + (kxx + kxy) ** 2 + 4 * kxy**2)
        assert curvature @ matrix @ curvature / 2 == pytest.approx(density, rel=1e-8)


def test_bending_energy_of_the_equilateral_net() -> None:
    """density = (sqrt3 / 4) k (4/3 H^2 + 8/3 d^2), H and d half sum and half difference of principal curvatures."""
    matrix = bending_matrix(meshes.unit_cell(meshes.periodic_equilateral(2, 2)))
    hinge = 2.0 / np.sqrt(3.0)  # c E t^3 a^2 / (A1 + A2) with c E t^3 = 1
    for kxx, kyy, kxy in np.random.default_rng(3).normal(size=(5, 3)):
        half_sum, half_difference = (kxx + kyy) / 2, np.hypot((kxx - kyy) / 2, kxy)
        density = np.sqrt(3) / 4 * hinge * (4 / 3 * half_sum**2 + 8 / 3 * half_difference**2)
        curvature = np.array([kxx, kyy, 2 * kxy])
        assert curvature @ matrix @ curvature / 2 == pytest.approx(density, rel=1e-8)


# kind, amount: (E, nu, G) and (D_cyl, B_beam), means over directions and seeds, and how far a mean may lie off
IRREGULAR = {
    ("jitter", 0.1): ((0.987, 0.337, 0.369), (1.014, 0.899), 0.03),
    ("jitter", 0.2): ((0.953, 0.344, 0.355), (1.050, 0.926), 0.03),
    ("jitter", 0.3): ((0.898, 0.352, 0.332), (1.114, 0.975), 0.06),
    ("lloyd", 2): ((0.902, 0.353, 0.333), (1.110, 0.971), 0.06),
    ("lloyd", 10): ((0.950, 0.344, 0.354), (1.052, 0.928), 0.06),
    ("lloyd", 60): ((0.982, 0.339, 0.367), (1.019, 0.902), 0.06),
}


@pytest.mark.parametrize("kind, amount", IRREGULAR)
def test_irregular_cells(kind: str, amount: float) -> None:
    membrane, bending, tolerance = IRREGULAR[kind, amount]
    rows = []
    for seed in range(5):
        if kind == "jitter":
            mesh = meshes.periodic_equilateral(12, 12, jitter=amount, seed=seed)
        else:
            mesh = meshes.periodic_lloyd(300, int(amount), seed)
        cell = meshes.unit_cell(mesh)
        plane, plate = moduli(membrane_matrix(cell)), rigidities(bending_matrix(cell))
        rows.append([np.mean(v) for v in (plane.young, plane.poisson, plane.shear, plate.cylinder, plate.beam)])
    assert np.mean(rows, axis=0) == pytest.approx(membrane + bending, abs=tolerance)


@pytest.mark.parametrize("seed", range(2))
def test_affine_estimate_is_a_third_on_any_mesh(seed: int) -> None:
    """Without relaxation the direction-averaged net is E, nu = 1/3 on ANY mesh; relaxing can only soften it.

    The two isotropic invariants of a plane-stress matrix are 2 E / (1 - nu) and 4 E / (1 + nu): both are 3 E here.
    """
    cell = meshes.unit_cell(meshes.periodic_equilateral(8, 8, jitter=0.25, seed=seed))
    invariants = [
        (c[0, 0] + c[1, 1] + 2 * c[0, 1], c[0, 0] + c[1, 1] - 2 * c[0, 1] + 4 * c[2, 2])
        for c in (membrane_matrix(cell, relaxed=False), membrane_matrix(cell))
    ]
    assert invariants[0] == pytest.approx((3.0, 3.0), rel=1e-9)
    assert 2.5 < min(invariants[1]) <= max(invariants[1]) < 2.97


def test_tied_cell_agrees_with_algebra() -> None:
    """A cell tied to its periodic images and stretched carries the energy that the linear algebra predicts."""
    cell = meshes.unit_cell(meshes.periodic_equilateral(4, 4, jitter=0.2, seed=7))
    strain = np.array([1e-3, -2e-4, 5e-4])  # exx, eyy, gamma_xy
    expected = strain @ membrane_matrix(cell) @ strain / 2 * cell.area
    images = range(cell.count, len(cell.nodes))
    period = cell.position[cell.count :] - cell.position[cell.leader[cell.count :]]
    cell.model.add(
        kg.Tie(
            [cell.nodes[n] for n in images],
            [cell.nodes[cell.leader[n]] for n in images],
            dofs="xyz",
            x=period @ [strain[0], strain[2] / 2],
            y=period @ [strain[2] / 2, strain[1]],
        )
    )
    cell.model.add(kg.Fix(cell.nodes[0], "xy"), kg.Fix(cell.nodes[: cell.count], "z"))
    result = kg.LinearStatic(cell.model).run()
    stiffness = kg.System(cell.model).stiffness(np.zeros((len(cell.nodes), 3)), constrained=False)
    moved = result[-1].u.ravel()
    assert moved @ (stiffness @ moved) / 2 == pytest.approx(expected, rel=1e-9)


# ------------------------------------------------------------------------------------- strips, patches, presets


@pytest.mark.parametrize("rows", [1, 2, 3, 8, 20])
def test_free_strip_is_exact_at_any_width(rows: int) -> None:
    """Equilateral rows along a strip with free sides: axial E t W and bending 8/9 c E t^3 W, even one row wide.

    Exact only because a boundary bar gets the area of its one facet.
    """
    cell = meshes.unit_cell(meshes.periodic_strip(4, rows))
    assert membrane_matrix(cell)[0, 0] == pytest.approx(1.0, rel=1e-9)
    assert bending_matrix(cell)[0, 0] == pytest.approx(8 / 9, rel=1e-9)


def test_equilateral_springs() -> None:
    """Equal springs k: E = 2 k / sqrt3, G = sqrt3 / 4 k, K = sqrt3 / 2 k, all per unit width (Seung, Nelson 1988)."""
    spring = 3.0
    sheet_spring = np.sqrt(3) / 2  # E t sum(A) / L^2 of unit_cell
    matrix = spring / sheet_spring * membrane_matrix(meshes.unit_cell(meshes.periodic_equilateral(2, 2)))
    assert moduli(matrix).young == pytest.approx(2 * spring / np.sqrt(3), rel=1e-9)
    assert moduli(matrix).shear == pytest.approx(np.sqrt(3) / 4 * spring, rel=1e-9)
    assert matrix[:2, :2].sum() / 4 == pytest.approx(np.sqrt(3) / 2 * spring, rel=1e-9)  # area modulus


def test_patch_of_uniform_strain() -> None:
    """Boundary moved affinely: the interior follows affinely and the sheet carries the plane stress of nu = 1/3."""
    modulus, thickness = 5.0, 0.2
    nodes, triangles = meshes.equilateral_parallelogram(6, 5)
    model, points = meshes.sheet(nodes, triangles, modulus, thickness)
    strain = np.array([[0.01, 0.003], [0.003, -0.02]])
    moved = nodes @ strain
    edges = meshes.edges_of(nodes, triangles)
    rim = sorted({int(n) for n in edges.ends[~edges.inner].ravel()})
    model.add(kg.Prescribe([points[n] for n in rim], x=moved[rim, 0], y=moved[rim, 1]), kg.Fix(points, "z"))
    result = kg.LinearStatic(model).run()
    assert result[-1].u[:, :2] == pytest.approx(moved, abs=1e-10 * np.abs(moved).max())
    support = np.array([[result.reaction(points[n], axis)[-1] for axis in "xy"] for n in rim])
    stress = support.T @ nodes[rim] / meshes.signed_area(nodes, triangles).sum()  # mean stress: sum of f x / area
    nu = 1 / 3
    expected = modulus * thickness / (1 - nu**2) * ((1 - nu) * strain + nu * np.trace(strain) * np.eye(2))
    assert stress == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("preset, factor", [("plate", 1.0), ("paper", 0.0276)])
def test_preset_rigidity(preset: str, factor: float) -> None:
    """Effective over true rigidity at nu = 0.34 on the equilateral mesh: 1 for "plate", 0.0276 for "paper"."""
    modulus, thickness, nu = 5.0, 0.2, 0.34
    nodes, triangles = meshes.equilateral_strip(4, 2)
    material = kg.Material(modulus, nu=nu)
    model = kg.Model.from_mesh(kg.TriMesh(nodes, triangles), thickness, material, stiffness=preset)
    hinge = max(e.stiffness for e in model.elements if isinstance(e, kg.BendHinge) and _equilateral(e))
    rigidity = np.sqrt(3) / 2 * hinge  # Seung and Nelson
    true = modulus * thickness**3 / (12 * (1 - nu**2))
    assert rigidity / true == pytest.approx(factor, rel=2e-3)


def _equilateral(hinge: kg.BendHinge) -> bool:
    corner = [np.array([n.x, n.y]) for n in (hinge.i, hinge.j, hinge.k, hinge.l)]
    sides = [corner[0] - corner[1], corner[0] - corner[2], corner[3] - corner[1], corner[3] - corner[2]]
    return bool(np.allclose([np.hypot(*side) for side in sides], 1.0))


@pytest.mark.parametrize(
    "preset, membrane, bending",
    [
        ("plate", 1.0, 1 / (12 * (1 - 0.3**2))),
        ("paper", 0.85, 0.125 / 48),
        (kg.Calibration(0.9, 0.05), 0.9, 0.05),
    ],
    ids=["plate", "paper", "calibration"],
)
def test_constants_of_two_triangles(preset: str | kg.Calibration, membrane: float, bending: float) -> None:
    """k_s = F_s E t sqrt3 / 2 and k_B = c E t^3 2 / sqrt3 for the shared edge of two equilateral triangles."""
    edge, modulus, thickness = 0.7, 3.0, 0.01
    nodes = edge * np.array([(0.5, -meshes.SIXTY_DEGREES), (0.0, 0.0), (1.0, 0.0), (0.5, meshes.SIXTY_DEGREES)])
    mesh = kg.TriMesh(nodes, np.array([(0, 2, 1), (1, 2, 3)]))
    model = kg.Model.from_mesh(mesh, thickness, kg.Material(modulus, nu=0.3), stiffness=preset)
    bars = [e for e in model.elements if isinstance(e, kg.Bar)]
    hinges = [e for e in model.elements if isinstance(e, kg.BendHinge)]
    springs = sorted(bar.EA / edge for bar in bars)
    inner = membrane * modulus * thickness * np.sqrt(3) / 2
    assert springs == pytest.approx([inner / 2] * 4 + [inner], rel=1e-12)
    assert len(hinges) == 1
    assert hinges[0].stiffness == pytest.approx(bending * modulus * thickness**3 * 2 / np.sqrt(3), rel=1e-12)


def test_calibration_table() -> None:
    """D_eff / D at nu = 0.34 of the published hinge constants: how far each is from a plate."""
    exact = 1 / (12 * (1 - 0.34**2))
    for constant, ratio in ((1 / 48, 0.221), (0.125 / 48, 0.0276), (0.1 / 6, 0.177), (1 / 6, 1.77)):
        cell = meshes.unit_cell(meshes.periodic_equilateral(2, 2), bending=constant / exact)
        assert rigidities(bending_matrix(cell)).cylinder.mean() == pytest.approx(ratio, rel=3e-3)
