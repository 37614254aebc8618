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
    material = options.get("material", kg.Material(E, NU))
    thickness = None if isinstance(material, kg.Laminate) else THICKNESS
    return kg.Model.from_mesh(mesh, thickness, material, stiffness=options.get("rung", "shell"))


RUNGS = ["plate", "facet", "shell"]


def loosely(m: kg.Model) -> kg.Model:
    """Held at three corners against rigid motions alone."""
    x = m.positions()
    corners = (0, 0), (x[:, 0].max(), 0), (0, 0.6)
    at = [int(np.argmin(np.linalg.norm(x[:, :2] - corner, axis=1))) for corner in corners]
    m.add(kg.Fix(m.nodes[at[0]]), kg.Fix(m.nodes[at[1]], "yz"), kg.Fix(m.nodes[at[2]], "z"))
    return m


@pytest.mark.filterwarnings("ignore:the mesh is biased")
@pytest.mark.parametrize("rung", RUNGS)
def test_the_kernels_belong_to_their_energies(rung: str) -> None:
    m = sheet(rung=rung)
    m.add(kg.Actuate([0, 1, 4], (0.1, -0.2, 0.05), (0.3, -0.2, 0.1)))
    m.add(kg.Actuate(strain=(0.02, 0.01, 0), constant=True), kg.Fix(m.select(boundary="left"), clamp=True))
    system = kg.System(m)
    x = system.rest + np.random.default_rng(0).normal(scale=0.03, size=system.rest.shape)
    for kernel in system.kernels:
        assert_right(kernel, x, balanced=not kernel.anchored)
    assert sum(kernel.scaled for kernel in system.kernels) == {"plate": 3, "facet": 3, "shell": 1}[rung]


@pytest.mark.filterwarnings("ignore:the mesh is biased")
@pytest.mark.parametrize("rung", RUNGS)
def test_a_free_sheet_takes_any_uniform_strain_without_stress(rung: str) -> None:
    """Axes are those of the drawing, however facets lie: C = 1 + 2 e is reached exactly, and nothing bears anything."""
    strain = (0.05, -0.03, 0.04)
    m = loosely(sheet(rung=rung))
    m.add(kg.Actuate(strain=strain))
    res = kg.LoadControl(m, tol=1e-11).run()
    rest, now = m.positions()[:, :2], res.position()[-1]
    gradient = np.linalg.lstsq(rest - rest[0], now - now[0], rcond=None)[0].T
    green = 0.5 * (gradient.T @ gradient - np.eye(2))
    assert green == pytest.approx(np.array([[0.05, 0.02], [0.02, -0.03]]), abs=1e-9)
    assert max(energy.max() for energy in res.energy.values()) < 1e-12
    assert np.abs(res.stress().tensor("top")[-1]).max() < 1e-6 * E


@pytest.mark.parametrize("rung", ["facet", "shell"])
def test_heat_between_walls(rung: str) -> None:
    """A strip that may swell across but not along bears E t a dT per width; linear analysis says the same, and plate
    theory makes the same stress of it."""
    m = sheet(rung=rung, material=kg.Material(E, NU, expansion=1e-5))
    ends = m.select(boundary="left") + m.select(boundary="right")
    m.add(kg.Fix(ends, "xz"), kg.Fix(m.nodes[0], "y"), kg.Actuate(heat=10.0))
    for res in (kg.LinearStatic(m).run(), kg.LoadControl(m, on_instability="follow").run()):  # flat, where it buckles
        assert res.reaction("right", "x")[-1] == pytest.approx(-E * THICKNESS * 1e-4 * 0.6, rel=1e-3)
        for stress in (res.stress(), res.stress().by_plate_theory()):
            assert stress.tensor("top")[-1][:, 0, 0] == pytest.approx(-E * 1e-4, rel=1e-3)


def test_a_heated_slit_sheet_between_clamps_buckles_without_being_asked() -> None:
    """Under loads a sheet goes over to the next stable shape, as one that is pulled does; following its path ends at
    the load factor 0.79, or in another shape."""
    slit = shapely.LineString([(0.03, 0.03), (0.07, 0.03)])
    material = kg.Material(3e9, 0.3, expansion=1e-4)
    mesh = kg.Sheet(shapely.box(0, 0, 0.1, 0.06), [slit], 2e-4, material).mesh(nodes=150)
    m = kg.Model.from_mesh(mesh, stiffness="plate")
    m.imperfect()
    held = m.select(boundary="left") + m.select(boundary="right")
    m.add(kg.Fix(held, clamp=True), kg.Actuate(heat=100))
    res = kg.LoadControl(m).run()
    assert res.lam[-1] == 1 and res.stable.all() and res.height()[-1] > 0.005


@pytest.mark.filterwarnings("ignore:the mesh is biased")
def test_a_strip_of_bars_between_walls() -> None:
    """Held everywhere, bars bear the mean of the two principal forces of a plate on any mesh, -E t a dT / (1 - nu);
    what plates would bear elsewhere is not known of edges."""
    m = sheet(rung="plate", material=kg.Material(E, 1 / 3, expansion=1e-5))
    m.add(kg.Fix(m.nodes), kg.Actuate(heat=10.0))
    res = kg.LinearStatic(m).run()
    mean = 0.5 * np.trace(res.stress(-1).force, axis1=1, axis2=2)
    assert mean == pytest.approx(-E * THICKNESS * 1e-4 / (1 - 1 / 3), rel=1e-9)
    with pytest.raises(kg.ModelError, match="known of their edges alone"):
        res.stress(-1).by_plate_theory()


@pytest.mark.filterwarnings("ignore:the mesh is biased")
@pytest.mark.parametrize("rung", RUNGS)
def test_a_bimetal_strip_bends_to_the_circle_of_timoshenko(rung: str) -> None:
    """Two equal layers whose free strains differ by d: radius 2 t / (3 d); here through more than a right angle."""
    d = 0.016
    curvature = 3 * d / (2 * THICKNESS)
    m = sheet(2.0, 0.3, 0.3 if rung == "shell" else 0.1, rung=rung)
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Actuate(curvature=(curvature, 0, 0)))
    res = kg.LoadControl(m).run()
    tip = res.position(m.select(boundary="right"))[-1].mean(axis=0)
    assert curvature * 2.0 > np.pi / 2
    assert tip[0] == pytest.approx(np.sin(2.0 * curvature) / curvature, abs=0.005 * 2.0)
    assert tip[2] == pytest.approx((1 - np.cos(2.0 * curvature)) / curvature, rel=0.005)  # towards the normal
    if rung == "shell":
        assert res.curvature("principal", per="node")[-1].max() == pytest.approx(curvature, rel=0.02)


def test_two_metals_bend_as_timoshenko_says() -> None:
    """Any thicknesses and moduli: k t = 6 d (1 + m)^2 / (3 (1 + m)^2 + (1 + m n) (m^2 + 1 / (m n))), m = t1 / t2 and
    n = E1 / E2, for one Poisson's ratio; and what heat makes of a gradient in one layer is -a dT / t."""
    heat, one, two = 50.0, 2e-5, 1.1e-5
    for m, n in ((1.0, 1.0), (0.5, 3.0), (2.0, 0.2)):
        lower = kg.Material(E * n, NU, expansion=one), THICKNESS * m / (1 + m)
        upper = kg.Material(E, NU, expansion=two), THICKNESS / (1 + m)
        model = loosely(sheet(material=kg.Laminate([lower, upper])))
        model.add(kg.Actuate(heat=heat))
        res = kg.LinearStatic(model).run()
        share = 3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n))
        expected = 6 * (one - two) * heat * (1 + m) ** 2 / (THICKNESS * share)
        told = res.stress(-1)
        assert told.curvature[:, 0, 0] == pytest.approx(expected, rel=1e-6)
        assert told.curvature[:, 1, 1] == pytest.approx(expected, rel=1e-6)
        assert np.abs(told.force).max() < 1e-9 * E * THICKNESS * one * heat
    warm = kg.Material(E, NU, expansion=one)
    for material in (warm, kg.Laminate([(warm, 0.7 * THICKNESS), (warm, 0.3 * THICKNESS)])):
        model = loosely(sheet(material=material))
        model.add(kg.Actuate(heat=(10.0, 30.0)))
        told = kg.LinearStatic(model).run().stress(-1)
        assert told.curvature[:, 0, 0] == pytest.approx(-one * 20.0 / THICKNESS, rel=1e-6)
        assert told.strain[:, 1, 1] == pytest.approx(one * 20.0, rel=1e-6)
        for fibre in ("top", "middle", "bottom"):
            assert np.abs(told.tensor(fibre)).max() < 1e-6 * E * one * 20.0


PLY = dict(E1=140e3, E2=10e3, nu12=0.3, G12=5e3, expansion=(-0.3e-6, 28e-6))


def test_an_unsymmetric_cross_ply_bends_to_a_saddle_under_heat() -> None:
    """Classical lamination theory (Jones, ch. 4): strain and curvature are S^-1 (N_T, M_T), opposite along both axes;
    the plies bear C (e - z k - a T), which is in balance over the thickness."""
    plies = [kg.Orthotropic(**PLY, angle=angle) for angle in (0.0, np.pi / 2)]
    h, heat = 0.5 * THICKNESS, -120.0
    C = [ply.elasticity() for ply in plies]
    free = [np.array([-0.3e-6, 28e-6, 0.0]), np.array([28e-6, -0.3e-6, 0.0])]
    A, D = h * (C[0] + C[1]), h**3 / 3 * (C[0] + C[1])
    B = 0.5 * h**2 * (C[0] - C[1])
    N = h * heat * (C[0] @ free[0] + C[1] @ free[1])
    M = 0.5 * h**2 * heat * (C[0] @ free[0] - C[1] @ free[1])
    wanted = np.linalg.solve(np.block([[A, B], [B, D]]), np.concatenate([N, M]))
    m = loosely(sheet(material=kg.Laminate([(ply, h) for ply in plies])))
    m.add(kg.Actuate(heat=heat))
    told = kg.LinearStatic(m).run().stress(-1)
    assert told.curvature[:, 0, 0] == pytest.approx(wanted[3], rel=1e-6)
    assert told.curvature[:, 1, 1] == pytest.approx(-wanted[3], rel=1e-6)
    assert told.strain[:, 0, 0] == pytest.approx(wanted[0], rel=1e-6)
    for fibre, z, ply in (("bottom", -h, 0), ("top", h, 1)):
        borne = C[ply] @ (wanted[:3] - z * wanted[3:] - free[ply] * heat)
        assert told.tensor(fibre)[:, 0, 0] == pytest.approx(borne[0], rel=1e-6)
        assert told.tensor(fibre)[:, 1, 1] == pytest.approx(borne[1], rel=1e-6)


def test_a_narrow_cross_ply_strip_rolls_up_under_heat() -> None:
    """A narrow strip is free to take both curvatures, so that it follows the circle of the first."""
    plies = [kg.Orthotropic(**PLY | {"nu12": 0.0}, angle=angle) for angle in (0.0, np.pi / 2)]
    pair, heat = kg.Laminate([(ply, 0.002) for ply in plies]), -60.0
    strain, _, _, curvature, _, _ = np.linalg.solve(pair.section(0.004), pair.heated(0.004, heat, heat)).tolist()
    mesh = kg.Sheet(shapely.box(0, 0, 2.0, 0.04)).mesh(0.1)
    m = kg.Model.from_mesh(mesh, material=pair, stiffness="shell")
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, "xyz", clamp=True), kg.Actuate(heat=heat))
    tip = kg.LoadControl(m).run().position(right)[-1].mean(axis=0)
    length, turn = 2.0 * (1 + strain), 2.0 * curvature
    assert abs(turn) > 0.7
    assert tip[2] == pytest.approx(length * (1 - np.cos(turn)) / turn, rel=0.005)
    assert tip[0] == pytest.approx(length * np.sin(turn) / turn, rel=0.005)


@pytest.mark.filterwarnings("ignore:the mesh is biased")
@pytest.mark.parametrize("rung", RUNGS)
def test_a_rolled_sheet_grows_round_and_along(rung: str) -> None:
    """Axes lie in the facets: heat makes a tube wider by the same share all round, and longer, without stress."""
    radius, around, along = 1.0, 16, 4
    angle, height = np.meshgrid(np.linspace(0, np.pi, around + 1) + 0.1, np.linspace(0, 1.0, along + 1))
    points = np.stack([height.ravel(), radius * np.cos(angle.ravel()), radius * np.sin(angle.ravel())], axis=1)
    first = (np.arange(along)[:, None] * (around + 1) + np.arange(around)).ravel()
    other = first + around + 1
    mesh = kg.TriMesh(points, np.concatenate([
        np.stack([first, other, other + 1], axis=1), np.stack([first, other + 1, first + 1], axis=1)
    ]))  # fmt: skip
    m = kg.Model.from_mesh(mesh, THICKNESS, kg.Material(E, 1 / 3, expansion=1e-3), stiffness=rung)
    corner = [m.nodes[0], m.nodes[around], m.nodes[-1]]
    m.add(kg.Fix(corner[0]), kg.Fix(corner[1], "xz"), kg.Fix(corner[2], "z"), kg.Actuate(heat=20.0))
    res = kg.LoadControl(m).run()
    now = res.position()[-1]
    apart = [np.linalg.norm(now[-1] - now[0]), np.linalg.norm(now[around // 2] - now[0])]
    rest = [np.linalg.norm(points[-1] - points[0]), np.linalg.norm(points[around // 2] - points[0])]
    assert np.divide(apart, rest) == pytest.approx((1 + 2 * 0.02) ** 0.5, rel=1e-3)


@pytest.mark.filterwarnings("ignore:the mesh is biased")
@pytest.mark.parametrize("rung", RUNGS)
def test_held_saved_and_in_parts(tmp_path: Any, rung: str) -> None:
    """What the load factor has reached stays in a next stage; files tell the same; parts add up."""
    m = sheet(rung=rung, material=kg.Material(E, NU, expansion=1e-3))
    m.add(kg.Fix(m.select(boundary="left"), clamp=True))
    m.add(kg.Actuate([0, 1, 2], curvature=(0.2, 0, 0)), kg.Actuate(strain=(0.01, 0, 0)), kg.Actuate([3], heat=(4, 6)))
    res = kg.LoadControl(m, targets=[0.5, 1.0]).run()
    half = int(np.argmin(np.abs(res.lam - 0.5)))
    back = kg.load(res.save(tmp_path / "actuated"))
    for kernel in res.kernels:
        assert back.force(kernel.name) == pytest.approx(res.force(kernel.name), abs=1e-12)
    for one, other in ((back.stress(), res.stress()),):
        assert one.tensor("top") == pytest.approx(other.tensor("top"), abs=1e-9 * E)
    m.hold(res[half])
    m.add(kg.NodalLoad(m.nodes[0], (1e-9, 0, 0)))
    after = kg.LoadControl(m, start=res[half]).run()
    assert after[-1].u == pytest.approx(res[half].u, abs=1e-6)


@pytest.mark.filterwarnings("ignore:the mesh is biased")
@pytest.mark.parametrize("rung", ["plate", "shell"])
def test_what_yields_takes_a_constant_strain_without_stress(rung: str) -> None:
    """Pulled on it, it is strained beyond the yield strain as a whole, but what counts is what it bears."""
    soft = kg.Material(E, 1 / 3, yield_stress=1e-4 * E, hardening=0.1 * E, expansion=1e-4)
    m = loosely(sheet(rung=rung, material=soft))
    m.add(kg.Actuate(heat=0.5, constant=True))
    for side, sign in (("left", -1), ("right", 1)):
        m.add(kg.EdgeLoad(m.select(boundary=side), (sign * 6.5e-5 * E * THICKNESS, 0, 0)))
    res = kg.LoadControl(m).run()
    length = np.ptp(res.position()[:, :, 0], axis=1) / np.ptp(m.positions()[:, 0])
    assert length[0] == pytest.approx(1 + 5e-5, abs=1e-8)
    assert max(energy[0] for energy in res.energy.values()) < 1e-12
    assert length[-1] > 1 + 1.1e-4
    told = [kernel.plastic() for kernel in res.kernels]
    assert max(values.max() for values in told if values is not None) == 0


@pytest.mark.filterwarnings("ignore:the mesh is biased")
@pytest.mark.parametrize("rung", ["plate", "shell"])
def test_constant_cold_beyond_yield_between_walls_is_a_pull_by_the_same_strain(rung: str) -> None:
    """A start at rest with all of it at once used to find no equilibrium: it is grown in steps."""
    limit, modulus, times = 1e-5 * E, 0.1 * E, 5.0
    strain = times * limit / E
    metal = kg.Material(E, NU, expansion=1e-5, yield_stress=limit, hardening=modulus)

    def walls(pull: float, cold: float) -> kg.Results:
        m = sheet(1.0, 0.6, 0.4, rung=rung, material=metal)
        left, right = m.select(boundary="left"), m.select(boundary="right")
        m.add(kg.Fix(left, "x"), kg.Fix(left[0], "y"), kg.Fix(m.nodes, "z"))
        if cold:
            m.add(kg.Fix(right, "x"), kg.Actuate(heat=-cold / 1e-5, constant=True))
            return kg.LoadControl(m, targets=[1.0]).run()
        m.add(kg.Prescribe(right, x=pull))
        return kg.LoadControl(m, targets=np.linspace(0.1, 1, 10)).run()

    cooled = walls(0.0, strain)
    found = cooled.reaction("right", "x")[0]
    assert cooled.yielded[0] == 1.0
    assert found == pytest.approx(walls(strain, 0.0).reaction("right", "x")[-1], rel=2e-3)
    if rung == "shell":  # one direction alone: the curve of the material
        along = limit + (strain - limit / E) * E * modulus / (E + modulus)
        assert found == pytest.approx(along * THICKNESS * 0.6, rel=1e-4)


@pytest.mark.filterwarnings("ignore:the mesh is biased")
@pytest.mark.parametrize("rung", ["plate", "shell"])
def test_what_is_constant_grows_in_steps_to_where_it_is_found_at_once(rung: str) -> None:
    """Loads, supports and strains alike; where all of it at once is found, nothing is grown."""
    from kirigami.analysis.path.begin import grown
    from kirigami.analysis.path.methods import LoadControl
    from kirigami.analysis.path.walk import Walk

    m = sheet(1.0, 0.6, 0.4, rung=rung)
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, clamp=True), kg.Prescribe(right, x=4e-3, constant=True), kg.NodalLoad(right, (0, 0, 1e-6)))
    m.add(kg.NodalLoad(right, (0, 0.02, 0.002), constant=True), kg.AreaLoad((0, 0, 0.003), constant=True))
    m.add(kg.Actuate(strain=(2e-3, 1e-3, 0), curvature=(0.02, 0, 0), constant=True))
    analysis = LoadControl(m, targets=[1.0])
    at_once = analysis.run()[0]
    walk = Walk(analysis, [])
    stepped = grown(walk, walk._starting_state())
    assert stepped.converged and walk.system.begun == 1.0
    assert walk.system.parted(stepped.state.u)[0] == pytest.approx(at_once.u, abs=1e-6)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(kg.ModelError, match="other than zero"):
        kg.Actuate()
    with pytest.raises(kg.ModelError, match="strain"):
        kg.Actuate(strain=(1, 2))
    m = kg.Model()
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, EA=1.0), kg.Fix([a, b]), kg.Actuate(strain=(0.1, 0, 0)))
    with pytest.raises(kg.ModelError, match="needs the sheet of a mesh"):
        kg.System(m)
    mesh = kg.Sheet(shapely.box(0, 0, 2, 1)).mesh(0.5)
    m = kg.Model.from_mesh(mesh, THICKNESS, kg.Material(E, NU), stiffness="facet", dim=2)
    m.add(kg.Fix(m.nodes), kg.Actuate(curvature=(0.1, 0, 0)))
    with pytest.raises(kg.ModelError, match="nothing bends in a model with dim=2"):
        kg.System(m)
    m = sheet()
    m.add(kg.Fix(m.nodes), kg.Actuate(heat=10.0))
    with pytest.raises(kg.ModelError, match="its expansion is not known"):
        kg.System(m)
    soft = kg.Material(E, 1 / 3, yield_stress=1e-2 * E, hardening=0.1 * E)
    for rung in ("plate", "shell"):
        m = kg.Model.from_mesh(mesh, THICKNESS, soft, stiffness=rung)
        m.add(kg.Fix(m.nodes), kg.Actuate(strain=(0.1, 0, 0)))
        with pytest.raises(kg.ModelError, match="sheet that yields cannot be driven by Actuate with the load factor"):
            kg.System(m)
    for rung, what in (("shell", "facets"), ("facet", "facets"), ("plate", "bars")):
        m = kg.Model.from_mesh(mesh, THICKNESS, kg.Material(E, 1 / 3), stiffness=rung)
        m.add(kg.Fix(m.nodes), kg.Actuate(strain=(0.1, 0, 0)))
        m.remove(m.elements[0])
        with pytest.raises(kg.ModelError, match=f"1 of its {what} taken out"):
            kg.System(m)
    m = sheet()
    m.add(kg.Actuate("nowhere", strain=(0.1, 0, 0)))
    with pytest.raises(kg.ModelError, match="no region 'nowhere'"):
        kg.System(m)
