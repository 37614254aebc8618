"""Loads that are spread over the sheet: resultants, uniform states and closed forms, on every pattern of mesh."""

import numpy as np
import pytest
from patterns import PATTERNS, on, rectangle
from scipy.integrate import solve_bvp

import kirigami as kg

RUNGS = ("plate", "facet", "shell")
STEEL = kg.Material(2e6, 0.3, density=3.0)
pytestmark = pytest.mark.filterwarnings("ignore:the mesh is biased", "ignore:bars lose stiffness")


def strip(pattern, rung, thickness=0.05, across=3, length=2.0, material=STEEL):
    model = kg.Model.from_mesh(rectangle(pattern, length, 1.0, across), thickness, material, stiffness=rung)
    x, y, _ = model.positions().T
    return model, [model.nodes[k] for k in on(x, 0)], [model.nodes[k] for k in on(x, length)], x, y


@pytest.mark.parametrize("rung", RUNGS)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_resultants_and_their_arms_are_exact(pattern, rung):
    """Force and moment of the reactions on a sheet of a thickness that varies, held at one end."""
    model, left, right, x, y = strip(pattern, rung)
    mesh = model.mesh
    thick = 0.05 * (1 + mesh.nodes[mesh.triangles].mean(axis=1)[:, 0])
    model = kg.Model.from_mesh(mesh, thick, STEEL, stiffness=rung)
    left, right = ([model.nodes[k] for k in on(x, place)] for place in (0.0, 2.0))
    centre = mesh.nodes[mesh.triangles].mean(axis=1)
    some = np.flatnonzero(centre[:, 0] > 1)
    loads = {
        kg.EdgeLoad(right, (0, 2.0, 0)): (np.array([0, 2.0, 0]), np.array([2.0, 0.5, 0])),
        kg.AreaLoad((0, 0, -3.0), some): (
            np.array([0, 0, -3.0 * mesh.facet_areas[some].sum()]),
            (centre * mesh.facet_areas[:, None])[some].sum(axis=0) / mesh.facet_areas[some].sum(),
        ),
        kg.Gravity((1.0, 0, -9.0)): (
            np.array([1.0, 0, -9.0]) * 3.0 * (thick * mesh.facet_areas).sum(),
            (centre * (thick * mesh.facet_areas)[:, None]).sum(axis=0) / (thick * mesh.facet_areas).sum(),
        ),
    }
    model.add(kg.Fix(left, clamp=True), *loads)
    results = kg.LinearStatic(model).run()
    found = np.array([results.reaction(left, axis)[-1] for axis in "xyz"])
    total = sum(force for force, _ in loads.values())
    np.testing.assert_allclose(found, -total, rtol=1e-9)
    system = kg.System(model)
    external = -system.gradient(np.zeros((len(x), 3)), 1.0)
    arm = np.cross(system.rest[: len(x)], external).sum(axis=0)
    if system.edges is not None:  # what acts on the offsets of middles has no arm of its own about a flat sheet's edges
        rows = -system.forces(np.zeros_like(system.rest), 1.0)[0]
        assert np.abs(rows[system.edges.middle]).max() > 0
        middle = 0.5 * system.rest[system.edges.ends].sum(axis=1)
        assert np.abs(np.cross(0 * middle, rows[system.edges.middle])).max() == 0
    np.testing.assert_allclose(arm, sum(np.cross(at, force) for force, at in loads.values()), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("rung", ("facet", "shell"))
@pytest.mark.parametrize("pattern", PATTERNS)
def test_edge_loads_make_a_uniform_state(pattern, rung):
    """Patch test: pulled along by N at both ends, the strain is N / (E t) everywhere, and -nu times that across."""
    model, left, right, x, y = strip(pattern, rung)
    pull = 0.01 * STEEL.E * 0.05
    model.add(kg.EdgeLoad(left, (-pull, 0)), kg.EdgeLoad(right, (pull, 0)))
    corner, other = int(np.argmin(x + y)), int(np.argmin(y - x))
    model.add(kg.Fix(model.nodes[corner], "xy"), kg.Fix(model.nodes[other], "y"), kg.Fix(model.nodes, "z"))
    results = kg.LinearStatic(model).run()
    np.testing.assert_allclose(results.u[-1, :, 0], 0.01 * x, atol=1e-12)
    np.testing.assert_allclose(results.u[-1, :, 1], -0.003 * y, atol=1e-12)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_supported_plate_under_a_uniform_load(pattern):
    """Navier's series at the node next to the centre; one load constant, the other growing."""
    model = kg.Model.from_mesh(rectangle(pattern, 1, 1, 8), 0.01, STEEL, stiffness="shell")
    x, y, _ = model.positions().T
    sides = np.unique(np.concatenate([on(x, 0), on(x, 1), on(y, 0), on(y, 1)]))
    model.add(kg.Fix([model.nodes[k] for k in sides], "z"), kg.Fix(model.nodes, "xy"))
    model.add(kg.AreaLoad((0, 0, 1.0)), kg.AreaLoad((0, 0, 1.0), constant=True))
    results = kg.LinearStatic(model).run()
    rigidity = STEEL.E * 0.01**3 / (12 * (1 - STEEL.nu**2))
    m = np.arange(1, 100, 2.0)
    a, b = np.meshgrid(m, m)
    near = int(np.argmin(np.hypot(x - 0.5, y - 0.5)))
    series = 16 / np.pi**6 * np.sin(a * np.pi * x[near]) * np.sin(b * np.pi * y[near]) / (a * b * (a**2 + b**2) ** 2)
    assert results.u[-1, near, 2] == pytest.approx(2 * series.sum() / rigidity, rel=5e-3)


def heavy_elastica(weight):
    """End of a clamped strip of unit length under its weight per length, over its bending stiffness."""
    s = np.linspace(0, 1, 101)
    found = solve_bvp(
        lambda s, v: np.array([v[1], weight * (1 - s) * np.cos(v[0])]),
        lambda a, b: np.array([a[0], b[1]]), s, np.zeros((2, 101)), tol=1e-6, max_nodes=20000,
    )  # fmt: skip
    assert found.success
    fine = np.linspace(0, 1, 2001)
    angle = found.sol(fine)[0]
    return np.trapezoid(np.cos(angle), fine), np.trapezoid(np.sin(angle), fine)


def test_a_heavy_strip_hangs_as_the_elastica():
    """Weight L^3 / D of 5, 20 and 80, in one path: the end within 0.2 % of the length."""
    material = kg.Material(1e6, 0.0, density=2.0)
    thickness, width = 0.001, 0.2
    mesh = rectangle("alternating", 1.0, width, 2)
    model = kg.Model.from_mesh(mesh, thickness, material, stiffness="shell")
    x = model.positions()[:, 0]
    left, right = ([model.nodes[k] for k in on(x, place)] for place in (0.0, 1.0))
    rigidity = material.E * thickness**3 / 12
    model.add(kg.Fix(left, clamp=True))
    model.add(kg.Gravity((0, 0, -80 * rigidity / (material.density * thickness))))
    results = kg.LoadControl(model, targets=[5 / 80, 20 / 80, 1.0]).run()
    for weight in (5, 20, 80):
        step = results.nearest(weight / 80)
        along, down = heavy_elastica(weight)
        end = results.position(right)[step].mean(axis=0)
        assert end[[0, 2]] == pytest.approx([along, down], abs=2e-3)
    assert results.stable.all()


def test_a_stage_keeps_loads_as_they_were():
    model, left, right, _, _ = strip("single", "shell")
    loads = model.add(kg.EdgeLoad(right, (0, 0, 1.0)), kg.AreaLoad((0, 0, 1.0), [0, 1]), kg.Gravity())
    model.add(kg.Fix(left, clamp=True))
    first = kg.LoadControl(model, to=0.5).run()
    model.hold(first[-1])
    assert all(load.constant for load in model.loads) and not any(load.constant for load in loads)
    again = kg.LinearStatic(model).run()
    np.testing.assert_allclose([load.force for load in model.loads], [0.5 * np.array(load.force) for load in loads])
    np.testing.assert_allclose(again.reaction(left, "z")[0], first.reaction(left, "z")[-1], rtol=1e-6)


def test_what_is_refused():
    model, left, right, x, _ = strip("single", "shell", material=kg.Material(1.0))
    held = kg.Fix(left, clamp=True)
    for load, words in (
        (kg.Gravity(), "give its material a density"),
        (kg.AreaLoad((0, 0, 1), "patch"), "has no region 'patch'; there are: none"),
        (kg.AreaLoad((0, 0, 1), [999]), "facets must be numbers from 0 to"),
        (kg.EdgeLoad([left[0], right[0]], (0, 0, 1)), "no edge of the sheet joins"),
    ):
        model.add(held, load)
        with pytest.raises(kg.ModelError, match=words):
            kg.LinearStatic(model).run()
        model.remove(held, load)
    truss = kg.Model(dim=2)
    a, b = truss.add(kg.Node(0, 0), kg.Node(1, 0))
    truss.add(kg.Bar(a, b, 1.0), kg.Fix(a), kg.Fix(b, "y"), kg.AreaLoad((1, 0)))
    with pytest.raises(kg.ModelError, match="AreaLoad needs facets"):
        kg.LinearStatic(truss).run()


def test_shell_codes_take_spread_loads_at_the_nodes(tmp_path):
    model, left, right, x, _ = strip("single", "plate")
    model.add(kg.Fix(left, clamp=True), kg.EdgeLoad(right, (0, 0, 2.0)), kg.AreaLoad((0, 0, 0.5)))
    text = model.to_abaqus(tmp_path / "sheet.inp").read_text()
    rows = text[text.index("*CLOAD") :].splitlines()[1:]
    total = sum(float(row.split(",")[2]) for row in rows[: next(k for k, row in enumerate(rows) if row[0] == "*")])
    assert total == pytest.approx(2.0 * 1.0 + 0.5 * 2.0, rel=1e-9)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_opposite_moments_at_all_edges_bend_a_plate_to_a_cap(pattern):
    """Under M on its whole rim a plate takes the curvature M / (D (1 + nu)) both ways, exactly."""
    model = kg.Model.from_mesh(rectangle(pattern, 1, 1, 3), 0.01, STEEL, stiffness="shell")
    x, y, _ = model.positions().T
    rim = [model.nodes[k] for k in np.flatnonzero((x < 1e-9) | (x > 1 - 1e-9) | (y < 1e-9) | (y > 1 - 1e-9))]
    model.add(kg.EdgeMoment(rim, 0.5), kg.EdgeMoment(rim, 0.25, constant=True))
    corners = [model.nodes[int(np.argmin(np.hypot(x - a, y - b)))] for a, b in ((0, 0), (1, 0), (0, 1))]
    model.add(kg.Fix(corners, "z"), kg.Fix(corners[0], "xy"), kg.Fix(corners[1], "y"))
    results = kg.LinearStatic(model).run()
    curvature = 0.75 / (STEEL.E * 0.01**3 / 12 / (1 - STEEL.nu**2) * (1 + STEEL.nu))
    cap = 0.5 * curvature * (x * (x - 1) + y * (y - 1))
    np.testing.assert_allclose(results.u[-1, :, 2], cap, atol=1e-8 * curvature)
    stress = results.stress(-1)
    np.testing.assert_allclose(stress.moment, 0.75 * np.broadcast_to(np.eye(2), stress.moment.shape), atol=1e-7)


def test_moments_need_shell_facets_and_edges(tmp_path):
    for rung, words in (("plate", "use stiffness='shell'"), ("shell", "no boundary edge joins two")):
        model, left, right, _, _ = strip("single", rung)
        model.add(kg.Fix(left, clamp=True), kg.EdgeMoment([left[0], right[0]], 1.0))
        with pytest.raises(kg.ModelError, match=words):
            kg.LinearStatic(model).run()
    model, left, right, _, _ = strip("single", "shell")
    moment = model.add(kg.EdgeMoment(right, 0.1))
    model.add(kg.Fix(left, clamp=True))
    results = kg.LoadControl(model).run()
    again = kg.load(results.save(tmp_path / "x.npz"))
    assert again.energy["shell"][-1] == pytest.approx(results.energy["shell"][-1], rel=1e-9)
    kernel = next(k for k in kg.System(model).kernels if k.name == "edge moments")
    assert moment.held(0.5).moment == 0.05 and kg.check_kernel(kernel, kg.System(model).rest) is not False
