"""Yield: the law of a section, the wide strip in closed form, trusses, energy and unloading."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import shapely
from yield_samples import lifted

import kirigami as kg
from kirigami.elements.layers import LAYERS, Layers
from kirigami.elements.plane_stress import STATE, PlaneStress
from kirigami.primitives.hardening import Hardening, YieldCurve, bent, checked_curve

E, NU, LIMIT, THICK = 70e9, 0.3, 150e6, 1e-3
CURVES = {
    "perfect": YieldCurve((0.0,), (LIMIT,)),
    "isotropic": YieldCurve((0.0,), (LIMIT,), beyond=2e9),
    "both": YieldCurve((0.0,), (LIMIT,), beyond=1e9, kinematic=3e9),
    "table": checked_curve(LIMIT, [(1e-3, 160e6), (3e-3, 162e6), (6e-3, 200e6)], 2e9, "Material", "yield_stress"),
    "tables": checked_curve(
        LIMIT, [(2e-3, 160e6)], [(1e-3, 30e6), (4e-3, 40e6), (9e-3, 60e6)], "Material", "yield_stress"
    ),
}
PLASTIC_MOMENT = 2 / np.sqrt(3) * LIMIT * THICK**2 / 4


def sections(count, curve, kind=Layers):
    full = [np.full(count, value) for value in (THICK, E, NU)]
    return kind(*full, Hardening.of([curve] * count))


def bent_and_stretched(rng, count):
    return rng.normal(size=(count, 3, 6)) * np.array([3e-3] * 3 + [10.0] * 3)


@pytest.mark.parametrize("name", CURVES)
def test_the_tangent_of_a_section_is_that_of_its_forces_and_these_are_those_of_its_energy(name):
    """Also from a state that has yielded before; kinks of single layers lie within a difference hardly ever."""
    rng = np.random.default_rng(0)
    law = sections(60, CURVES[name])
    state = law.respond(bent_and_stretched(rng, 60), np.zeros((60, 3, LAYERS, STATE)))[3]
    fields = bent_and_stretched(rng, 60) + bent_and_stretched(rng, 60)
    _, forces, tangent, after = law.respond(fields, state)
    assert (after[..., 3] > state[..., 3]).mean() > 0.5  # most layers flow again
    assert np.allclose(tangent, tangent.swapaxes(-1, -2), rtol=0, atol=1e-12 * np.abs(tangent).max())
    for column in range(6):
        step = np.zeros(6)
        step[column] = 1e-9 if column < 3 else 1e-5
        ahead, back = (law.respond(fields + sign * step, state, tangent=False) for sign in (1, -1))
        for up, down, slope in ((ahead[1], back[1], tangent[..., column]), (ahead[0], back[0], forces[..., column])):
            off = np.abs((up - down) / (2 * step.sum()) - slope).reshape(60 * 3, -1).max(axis=1) / np.abs(slope).max()
            assert np.quantile(off, 0.99) < 1e-7


@pytest.mark.parametrize("name", CURVES)
def test_the_compiled_layers_are_the_plain_ones(name):
    pytest.importorskip("numba")
    from kirigami.elements.compiled_yield import CompiledLayers

    rng = np.random.default_rng(1)
    plain, fast = sections(20, CURVES[name]), sections(20, CURVES[name], CompiledLayers)
    state = np.zeros((20, 3, LAYERS, STATE))
    for _ in range(3):
        fields = bent_and_stretched(rng, 20)
        one, other = plain.respond(fields, state), fast.respond(fields, state)
        for a, b in zip(one, other):
            assert np.allclose(a, b, rtol=0, atol=1e-13 * np.abs(a).max())
        assert (plain.passed(0.1 * fields) == fast.passed(0.1 * fields)).all()
        state = one[3]


def test_stress_stays_on_the_yield_surface():
    rng = np.random.default_rng(2)
    curve = CURVES["both"]
    law = PlaneStress(np.full(300, E), np.full(300, NU), Hardening.of([curve] * 300))
    stress, _, state = law.flow(rng.normal(size=(300, 3)) * 5e-3, np.zeros((300, STATE)), tangent=False)
    P, inverse = np.array([[2, -1, 0], [-1, 2, 0], [0, 0, 6]]) / 3, np.array([[2, 1, 0], [1, 2, 0], [0, 0, 0.5]])
    beyond = stress - 2 / 3 * curve.kinematic * state[:, :3] @ inverse
    size = np.sqrt(1.5 * ((beyond @ P) * beyond).sum(axis=1))
    flows = state[:, 3] > 0
    assert flows.mean() > 0.9
    assert np.allclose(size[flows], (LIMIT + curve.beyond * state[:, 3])[flows], rtol=1e-12)
    assert (size[~flows] <= LIMIT * (1 + 1e-12)).all()


# ---- pulled and pushed in one direction, in closed form

ISOTROPIC, BACK = [(2e-3, 160e6), (8e-3, 165e6)], [(1e-3, 30e6), (4e-3, 40e6), (9e-3, 60e6)]


def cycle():
    """Plastic strains and stresses of a bar that is pulled to a plastic strain p1 and pushed back by d: the back stress
    moves by the table's own rises, towards the side that flows."""
    yields_at = lambda a: np.interp(a, *zip((0.0, LIMIT), *ISOTROPIC))  # noqa: E731
    back_at = lambda a: np.interp(a, *zip((0.0, 0.0), *BACK))  # noqa: E731
    out, back = np.linspace(0, 3e-3, 4), np.linspace(0, 7e-3, 8)  # with all kinks of both tables
    pulled = yields_at(out) + back_at(out)
    pushed = 2 * back_at(out[-1]) - back_at(out[-1] + back) - yields_at(out[-1] + back)
    return np.concatenate([out, out[-1] - back]), np.concatenate([pulled, pushed])


def test_a_bar_pulled_and_pushed_follows_both_tables():
    plastic, stress = cycle()
    assert stress[4] > -LIMIT + 20e6  # it yields earlier when it is pushed (Bauschinger)
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    section = 1e-6
    tables = [[(p, section * s) for p, s in table] for table in (ISOTROPIC, BACK)]
    m.add(kg.Bar(a, b, EA=E * section, strain="engineering", yield_force=LIMIT * section, hardening=tables[0],
                 kinematic=tables[1]), kg.Fix(a), kg.Fix(b, "y"), kg.Prescribe(b, x=1.0))  # fmt: skip
    pull = plastic + stress / E
    results = kg.DisplacementControl(m, targets=pull[:-1], to=pull[-1], tol=1e-12).run()
    at = [int(np.argmin(np.abs(results.lam - lam))) for lam in pull]
    assert np.allclose(results.reaction(b, "x")[at], stress * section, rtol=0, atol=1e-9 * LIMIT * section)
    work = np.cumsum([0.5 * LIMIT**2 / E, *(0.5 * (stress[1:] + stress[:-1]) * np.diff(pull))]) * section
    assert np.allclose(sum(results.energy.values())[at], work, rtol=0, atol=1e-9 * work[-1])


def test_a_sheet_pulled_and_pushed_follows_both_tables():
    """Under stress in one direction, where it grows thinner and narrower by half of the plastic strain each."""
    plastic, stress = cycle()
    curve = checked_curve(LIMIT, ISOTROPIC, BACK, "Material", "yield_stress")
    law, state = PlaneStress(np.array([E]), np.array([NU]), Hardening.of([curve])), np.zeros((1, STATE))
    for p, s in zip(plastic, stress):
        strain = p * np.array([[1, -0.5, 0]]) + s / E * np.array([[1, -NU, 0]])
        found, _, state = law.flow(strain, state, tangent=False)
        assert np.allclose(found, [[s, 0, 0]], rtol=0, atol=1e-9 * LIMIT)
        assert np.allclose(state[0, :3], p * np.array([1, -0.5, 0]), rtol=0, atol=1e-12)


# ---- a wide strip, bent


@cache
def strip(hardening=7e8, steps=20):
    """Bent to 60 / m by a moment, and let go; moments over the fully plastic one, and curvatures."""
    length, count = 0.02, 4
    x = np.linspace(0, length, count + 1)
    triangles = [t for a in range(count) for t in ((a, a + 1, a + 2 + count), (a, a + 2 + count, a + 1 + count))]
    mesh = kg.TriMesh([(a, b) for b in (0, 0.005) for a in x], triangles)
    material = kg.Material(E, NU, yield_stress=LIMIT, hardening=hardening)
    m = kg.Model.from_mesh(mesh, thickness=THICK, material=material, stiffness="shell")
    left, right = m.select(boundary="left"), m.select(boundary="right")
    planes = {"left": "x", "top": "y", "bottom": "y"}
    m.add(*(kg.Symmetry(m.select(boundary=side), normal) for side, normal in planes.items()))
    m.add(kg.Fix(left[0], "z"), kg.EdgeMoment(right, PLASTIC_MOMENT))
    curvature = np.linspace(0, 60, steps + 1)[1:]
    heights = (1 - np.cos(curvature * length)) / curvature
    pulled = kg.DisplacementControl(m, to=heights[-1], control=(right[0], "z"), targets=heights).run()
    released = kg.LoadControl(m, to=0.0, start=pulled[-1]).run()
    return pulled, released


def curvatures(results):
    return results.stress().curvature[..., 0, 0].mean(axis=1)


def by_fine_layers(curvature, hardening=0.0, count=3000):
    z = ((np.arange(count) + 0.5) / count - 0.5) * THICK
    curve = YieldCurve((0.0,), (LIMIT,), hardening)
    law = PlaneStress(np.full(count, E), np.full(count, NU), Hardening.of([curve] * count))
    state, moments = np.zeros((count, STATE)), []
    for k in curvature:
        stress, _, state = law.flow(np.stack([-z * k, 0 * z, 0 * z], axis=1), state, tangent=False)
        moments.append(-(stress[:, 0] * z).sum() * THICK / count)
    return np.array(moments) / PLASTIC_MOMENT


def test_moment_over_curvature_of_a_wide_strip():
    pulled, _ = strip()
    assert np.allclose(pulled.lam[1:], by_fine_layers(curvatures(pulled)[1:], 7e8), rtol=0, atol=0.01)
    assert pulled.yielded[-1] == 1.0


def test_the_fully_plastic_moment():
    """2 / sqrt(3) sigma_y t^2 / 4 per width, approached from below as the elastic core shrinks."""
    law = sections(1, CURVES["perfect"])
    state = np.zeros((1, 3, LAYERS, STATE))
    for k in np.linspace(0, 2000, 400)[1:]:
        _, forces, _, state = law.respond(np.tile([0, 0, 0, k, 0, 0], (1, 3, 1)).astype(float), state)
    assert abs(forces[0, 0, 3] / PLASTIC_MOMENT - 1) < 2e-3
    assert abs(by_fine_layers([2000.0])[0] - 1) < 2e-3


def test_spring_back():
    """Unloading is elastic: k_r = k - M / D."""
    pulled, released = strip()
    rigidity = E * THICK**3 / (12 * (1 - NU**2))
    left = curvatures(pulled)[-1] - pulled.lam[-1] * PLASTIC_MOMENT / rigidity
    assert abs(curvatures(released)[-1] / left - 1) < 0.01
    assert released.lam[-1] == 0.0
    assert released.plastic_strain(-1) == pytest.approx(pulled.plastic_strain(-1))


def test_stress_of_what_has_yielded_is_that_of_its_layers():
    """Faces under 2 / sqrt(3) of the yield stress that the hardening has brought, where an elastic sheet has 1.5 times
    as much; and the residual moment of a released strip is none, its residual stress is some."""
    pulled, released = strip()
    strain = pulled.plastic_strain(-1).max()
    assert pulled.stress(-1).von_mises("top").max() < LIMIT + 7e8 * strain + 1e-3 * LIMIT
    left = released.stress(-1)
    assert np.abs(left.moment[:, 0, 0]).max() < 1e-3 * PLASTIC_MOMENT
    assert np.abs(left.tensor("top")[:, 0, 0]).min() > 0.2 * LIMIT


# ---- a truss


def truss(high=0.3, EA=10.0, limit=0.15, **yields):
    m = kg.Model(dim=2)
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, high), kg.Node(1, 0))
    m.add(*(kg.Bar(*ends, EA, yield_force=limit, **yields) for ends in ((left, apex), (apex, right))))
    m.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
    return m, apex


def test_plateau_of_a_truss():
    """Both bars flow under the stress N: the load is 2 N (h - w) / L."""
    m, apex = truss()
    results = kg.DisplacementControl(m, to=-0.28, control=(apex, "y"), step=0.02).run()
    w, length = -results.u[:, 1, 1], np.sqrt(1.09)
    flows = np.abs(w**2 - 0.6 * w) / (2 * length**2) > 0.0151
    assert flows.sum() > 3
    assert np.allclose(results.lam[flows], (2 * 0.15 * (0.3 - w) / length)[flows], rtol=1e-12)


@pytest.mark.parametrize("step", [0.02, 0.2])
def test_the_load_is_largest_at_first_yield_where_the_path_has_a_kink(step):
    m, apex = truss()
    results = kg.DisplacementControl(m, to=-0.28, control=(apex, "y"), step=step).run()
    w = 0.3 - np.sqrt(0.09 - 2 * 1.09 * 0.015)
    limit = next(event for event in results.events if event.kind == "limit point")
    assert limit.lam == pytest.approx(2 * 0.15 * (0.3 - w) / np.sqrt(1.09), rel=1e-6)
    (first,) = (event for event in results.events if event.kind == "yield")
    assert first.bracket == (results.lam[first.step], results.lam[first.step + 1])
    assert results.yielded[first.step] == 0 < results.yielded[first.step + 1]


def test_first_yield_alone_is_no_limit_point():
    m, apex = truss(hardening=10.0)
    results = kg.DisplacementControl(m, to=-0.08, control=(apex, "y"), step=0.02).run()
    assert [event.kind for event in results.events] == ["yield"]


def test_unloading_from_every_stored_step_is_elastic():
    m, apex = truss(hardening=1.0, kinematic=2.0)
    results = kg.DisplacementControl(m, to=-0.25, control=(apex, "y"), step=0.02).run()
    height, back = 0.3 + results.u[:, 1, 1], 1e-3
    for number in range(1, len(results)):
        start = results[number]
        less = kg.DisplacementControl(m, to=start.u[1, 1] + back, control=(apex, "y"), start=start).run()
        stress = (results.force("bars")[number, 0] / np.sqrt((1 + height[number] ** 2) / 1.09))
        after = height[number] + back
        stress += 10.0 * (after**2 - height[number] ** 2) / (2 * 1.09)
        assert less.lam[-1] == pytest.approx(-2 * stress * after / np.sqrt(1.09), rel=1e-9)
        assert np.array_equal(less[-1].history[0], start.history[0])


# ---- energy


def test_a_turn_makes_no_bar_yield_in_the_tangent():
    """A linear step that turns a bar far pumps false strain into it: the force sees that, the tangent must not."""
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, EA=100.0, yield_force=1.0), kg.Fix(a), kg.Fix(b))
    (kernel,) = kg.System(m).kernels
    rest = np.array([[0.0, 0.0], [1.0, 0.0]])
    turned = np.array([[0.0, 0.0], [0.0, 0.3]])
    ahead = kg.Tangent(ahead=(rest, turned))
    along = np.array([1.0, 0.3])

    def stiffness(x, *given):
        found = kernel.evaluate(x, 1.0, 2, *given)
        block = np.abs(found.hessian.reshape(-1, 2, 2)[0])
        return along @ block @ along / (along @ along) ** 2

    assert np.abs(kernel.evaluate(rest + turned, 1.0, 1).gradient).max() > 0.9  # it does yield there
    assert stiffness(rest + turned) < 2.0  # the exact tangent: its force alone
    assert stiffness(rest + turned, ahead) == pytest.approx(100.0, rel=1e-6)
    pulled = np.array([[0.0, 0.0], [1.1, 0.0]])
    along = np.array([1.1, 0.0])
    assert stiffness(pulled) < 2.0 and stiffness(pulled, kg.Tangent(convexity=1.0)) > 99.0


@pytest.mark.parametrize("hardening", [1e7, *(pytest.param(value, marks=pytest.mark.long) for value in (0.0, 1e6))])
def test_bars_and_hinges_unload_in_a_few_times_the_corrections_of_their_loading(hardening):
    """Of a slit sheet pulled out of its plane: it was from twelve to sixty-seven times as many."""
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1), shapely.LineString([(0.2, 0.5), (0.8, 0.5)]))
    material = kg.Material(E=1e9, nu=0.3, yield_stress=6e6, hardening=hardening)
    m = kg.Model.from_mesh(sheet.mesh(max_edge=0.25), thickness=3e-3, material=material, stiffness="plate")
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.Prescribe(top, x=0, y=0.03, z=0, clamp=True))
    loaded = kg.DisplacementControl(m).run()
    back = kg.DisplacementControl(m, to=0.6, start=loaded[-1]).run()
    assert loaded.yielded[-1] > 0.2 and back[-1].negative == 0
    assert back.stats["factorizations"] < 4 * loaded.stats["factorizations"]


FIRST = 2 * LIMIT / (E + 5e9)  # plastic strain at the first reversal of the test below


@pytest.mark.parametrize("kinematic", [5e9, [(FIRST, 5e9 * FIRST), (20 * FIRST, 30e9 * FIRST)]], ids=["line", "table"])
def test_energy_balance_of_a_sheet_pulled_and_pushed(kinematic):
    """Work of the grips against what is stored and what is lost, through three reversals; steps meet the kinks."""
    mesh = kg.Sheet(shapely.box(0, 0, 2, 1)).mesh(max_edge=1.0)
    material = kg.Material(E, NU, yield_stress=LIMIT, kinematic=kinematic)
    m = kg.Model.from_mesh(mesh, thickness=THICK, material=material, stiffness="shell")
    left, right = m.select(boundary="left"), m.select(boundary="right")
    strain = LIMIT / E * np.array([*range(4), *range(2, -4, -1), *range(-2, 4), *range(2, -1, -1)])[1:]
    pull = 2 * (np.sqrt(1 + 2 * strain) - 1)
    m.add(kg.Fix(m.nodes, "z"), kg.Fix(left, "x"), kg.Fix(left[0], "y"), kg.Prescribe(right, x=1.0))
    results = kg.DisplacementControl(m, targets=pull[:-1], to=pull[-1], tol=1e-11, corrector="newton").run()
    length = 2 + results.lam
    force, green = results.reaction(right, "x"), (length**2 - 4) / 8
    stress = force * 2 / length  # work is stress d(green strain)
    work = 2 * np.concatenate([[0], np.cumsum(0.5 * (stress[1:] + stress[:-1]) * np.diff(green))])
    stored = sum(results.energy.values())
    assert np.abs(work - stored).max() < 1e-6 * work.max()
    lost = results.energy["dissipated"]
    assert (np.diff(lost) >= -1e-12 * lost[-1]).all()
    assert lost[-1] > 0.5 * work.max()


def test_where_nothing_yields_the_run_is_the_elastic_one():
    def pulled(rung, **yields):
        mesh = kg.Sheet(shapely.box(0, 0, 1, 1), [[(0.3, 0.5), (0.7, 0.5)]]).mesh(max_edge=0.35)
        m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(1e9, 0.3, **yields), stiffness=rung)
        top = m.select(boundary="top")
        m.add(kg.Fix(m.select(boundary="bottom")), kg.Prescribe(top, x=0, y=5e-4, z=0.02))
        return kg.DisplacementControl(m).run()

    for rung in ("plate", "shell"):
        elastic, other = pulled(rung), pulled(rung, yield_stress=1e9, hardening=[(0.1, 2e9)])
        assert np.allclose(other.u, elastic.u, rtol=0, atol=1e-9)
        assert elastic.stats["factorizations"] == other.stats["factorizations"]
        assert (other.yielded == 0).all()
        assert other.energy["dissipated"].max() == 0


# ---- bars and hinges of a sheet


def test_hinges_of_a_sheet_yield_at_the_moment_of_cylindrical_bending():
    m, _ = lifted("plate", hardening=1e8)
    hinges = [item for item in m.elements if isinstance(item, kg.BendHinge)]
    for hinge in hinges:
        length = np.hypot(hinge.j.x - hinge.k.x, hinge.j.y - hinge.k.y)
        assert hinge.yield_curve.stress[0] == pytest.approx(2 / np.sqrt(3) * 60e6 * 25e-6 / 4 * length)
        # of the elastic stiffness D as E' of 4/3 H: slopes over curvature
        share = hinge.yield_curve.beyond / hinge.stiffness
        assert share == pytest.approx(4 / 3 * 1e8 / 3.5e9 * (1 - 0.34**2))
    bars = [item for item in m.elements if isinstance(item, kg.Bar)]
    assert all(bar.yield_curve.stress[0] == pytest.approx(bar.EA * 60e6 / 3.5e9) for bar in bars)


def test_a_table_that_is_straight_bends_like_its_modulus():
    straight = bent(YieldCurve((0.0,), (LIMIT,), beyond=2e9), THICK)
    table = bent(checked_curve(LIMIT, [(0.1, LIMIT + 2e8), (1.0, LIMIT + 2e9)], 0.0, "Material", "yield_stress"), THICK)
    behind = bent(checked_curve(LIMIT, 0.0, [(0.1, 2e8), (1.0, 2e9)], "Material", "yield_stress"), THICK)
    assert np.allclose(behind.back, np.array(table.stress) - table.stress[0], rtol=1e-12)
    assert np.allclose(behind.stress, table.stress[0], rtol=1e-12)
    inside = [k for k in table.strain if k * THICK / np.sqrt(3) < 1.0]
    values = np.interp(inside, table.strain, table.stress)
    assert np.allclose(values, straight.stress[0] + straight.beyond * np.array(inside), rtol=1e-3)
