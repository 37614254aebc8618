"""Gradients of every structure: what is left of a Taylor series falls with the square of the step, four decades."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import shapely
from structures import BUILT, RUNGS, STRUCTURES, results

import kirigami as kg
from kirigami.model.moved import moved as moved_model
from kirigami.primitives.sensitivity import member_work, rebuilt
from kirigami.results.fields import facet_strain
from kirigami.results.gradients import fields
from kirigami.results.gradients.by_rest import by_rest_state
from kirigami.results.gradients.critical import CriticalPoint
from kirigami.results.gradients.equilibrium import Equilibrium, prepared
from kirigami.results.gradients.fields import _kernels, _moduli, _with_sheet
from kirigami.results.gradients.functionals import tell_of
from kirigami.results.gradients.gradient import equilibrium, stiffness_pair
from kirigami.system.system import System

STEPS = 10.0 ** -np.arange(1, 5)
SHEETS = [name for name in STRUCTURES if name not in BUILT]
ROUNDING = 3e-12  # of the functional


def own(x, f):
    return float((x**3).sum() + (f**2).sum() / 1e4)


def functionals(name):
    holding = [support for support in results(name).supports if support.kind != "RigidLink"]
    known = {node for support in holding for node in support.nodes.tolist()}
    free = min(set(range(len(results(name).rest))) - known)
    plain = [("force", "driven_0", "y"), ("position", free, "y"), ("energy",), own]
    plain += [("shape", results(name).rest + 0.1 * np.random.default_rng(4).normal(size=results(name).rest.shape))]
    if results(name).dim == 3:
        plain.append(("height",))
    return plain + ([("open_area",), ("poisson_ratio",), ("width",), ("strain",), POINT] if name in SHEETS else [])


POINT = ("point", (0.1, 0.2), "x")  # of the sheet as it is drawn


def called(functional):
    return functional[0] if isinstance(functional, tuple) else "own"


def rounding_of(functional):
    """Differences round more: those of shapes, and a stiffness, whose states are a ten-thousandth apart."""
    return {"width": 1e-9, "poisson_ratio": 1e-9, "stiffness": 1e-9, "own": 1e-9}.get(called(functional), ROUNDING)


@cache
def reached(name):
    return equilibrium(results(name), results(name)[-1])


def left_over(name, functional, rate, changed):
    """What the linear term leaves of the change, as a share of the functional; `changed(share)` is a system."""
    at, res = reached(name), results(name)
    if called(functional) == "stiffness":
        tells = tell_of(("force", *functional[1:]), res), tell_of(("position", *functional[1:]), res)

        def value(state):
            _, force, place = stiffness_pair(state, tells)
            return force / place
    else:
        tell = tell_of(functional, res)

        def value(state):
            return state.told(tell).value

    start = value(at)
    size = max(abs(start), abs(rate))
    return np.array([abs(value(Equilibrium(changed(s), at.u, at.lam)) - start - s * rate) / size for s in STEPS])


def assert_second_order(left, rounding=ROUNDING):
    """A hundredth with every tenth of the step, down to rounding; terms of third order count in the first."""
    for before, after, share in zip(left, left[1:], (0.1, 0.02, 0.02)):
        assert after <= share * before + rounding, left


def with_kernels(name, kernels):
    system = System(results(name).model)
    system.kernels[:] = kernels
    system.twins = [None] * len(kernels)
    system.history = results(name)[-1].history
    return system


@pytest.mark.parametrize("name", STRUCTURES)
def test_by_places_of_nodes(name):
    res = results(name)
    asked = functionals(name)
    along = 0.02 * np.random.default_rng(1).normal(size=res.rest.shape)
    along[:, res.dim :] = 0.0
    level = along.copy()  # nodes that are held are the lowest and the highest, several of them, and have to stay so
    level[[node for support in res.supports for node in support.nodes.tolist()], 2] = 0.0
    for functional, rate in zip(asked, res.gradient(asked, "positions")):
        moved = level if called(functional) == "height" else along
        left = left_over(
            name, functional, float((rate * moved).sum()),
            lambda s, moved=moved: prepared(moved_model(res.model, res.model.positions() + s * moved), res[-1].history),
        )  # fmt: skip
        assert_second_order(left, rounding_of(functional))


def test_rounding_is_not_taken_for_what_is_felt_far_away(monkeypatch, name="folded shell"):
    """A load does not feel where nodes are: all that its work changes by is rounding, near and far."""
    asked = [("force", "driven_0", "y"), ("energy",), ("open_area",), ("position", "driven_0", "x")]
    exact = results(name).gradient(asked, "positions")
    random = np.random.default_rng(0)

    def rounded(*given):
        work = member_work(*given)
        return work * (1 + np.finfo(float).eps * random.integers(-1, 2, work.shape))

    monkeypatch.setattr(fields, "member_work", rounded)
    for again, rate in zip(results(name).gradient(asked, "positions"), exact):
        assert again == pytest.approx(rate, abs=1e-8 * np.abs(rate).max())


def test_what_is_felt_far_away_is_refused(monkeypatch):
    """Loads that every node has a little part in, wherever it is."""
    res = results("folded shell")
    start = res.rest[:, :2].sum()

    def far(kernel, x, lam, v, energy=0.0):
        work = member_work(kernel, x, lam, v, energy)
        return work + 1e-4 * (kernel.rest[: len(res.rest), :2].sum() - start) * (kernel.conn.shape[1] == 1)

    monkeypatch.setattr(fields, "member_work", far)
    with pytest.raises(kg.AnalysisError, match="felt far"):
        res.gradient(("energy",), "positions")


@pytest.mark.parametrize("name", ["shell", "plate", "facet in the plane", "tower", "hinged strip", "chain of springs"])
def test_one_pass_by_places_of_nodes_is_that_of_differences(name, monkeypatch):
    """Every kernel that tells how it follows its nodes, against the structure lowered once more."""
    asked = functionals(name)
    adjoints = [reached(name).adjoint(reached(name).told(tell_of(item, results(name)))) for item in asked]
    one_pass = by_rest_state(adjoints)
    assert one_pass is not None
    monkeypatch.setattr(fields, "by_rest_state", lambda adjoints: None)
    for closed, rate in zip(one_pass, results(name).gradient(asked, "positions")):
        assert closed == pytest.approx(rate, rel=1e-6, abs=1e-6 * np.abs(rate).max())


@pytest.mark.parametrize("wrt", ["thickness", "E"])
@pytest.mark.parametrize("name", SHEETS)
def test_by_what_the_sheet_is_made_of(name, wrt):
    res = results(name)
    sheet, count = res.model.sheet_constants, len(res.mesh.triangles)
    base = sheet.thickness_of_facets(count) if wrt == "thickness" else _moduli(sheet.material, count, "")
    along = 0.3 * base * np.random.default_rng(2).normal(size=count)
    asked = [*functionals(name), ("stiffness", "driven_0", "y")]
    for functional, rate in zip(asked, res.gradient(asked, wrt)):
        left = left_over(
            name, functional, float((rate * along).sum()),
            lambda s: with_kernels(name, _with_sheet(res.model, wrt, base + s * along, "")),
        )  # fmt: skip
        assert_second_order(left, rounding_of(functional))


@pytest.mark.parametrize("wrt", ["strain", "curvature"])
def test_by_what_facets_are_free_of_force_at(wrt):
    res = results("shell")
    along = np.random.default_rng(3).normal(size=(len(res.mesh.triangles), 3)) * (0.01 if wrt == "strain" else 0.2)
    asked = [*functionals("shell"), ("stiffness", "driven_0", "y")]

    def changed(share):
        actuated = [
            kg.Actuate([facet], **{wrt: share * row}, constant=True) for facet, row in enumerate(along) if share
        ]
        model = res.model
        kernels = _kernels(model, [*model.objects, *actuated], model.sheet_constants, model.positions())
        return with_kernels("shell", kernels)

    for functional, rate in zip(asked, res.gradient(asked, wrt)):
        left = left_over("shell", functional, float((rate * along).sum()), changed)
        assert_second_order(left, rounding_of(functional))


@pytest.mark.parametrize("name", [*BUILT, "plate"])
def test_by_the_constants_of_members(name):
    res = results(name)
    asked = [*functionals(name)[:4], ("stiffness", "driven_0", "y")]
    looked_at = 0
    for number, kernel in enumerate(res.kernels):
        same = [other for other in res.kernels if other.name == kernel.name]
        if len(same) > 1:
            continue
        for array, given in kernel.arrays().items():
            if not isinstance(given, np.ndarray) or given.dtype.kind != "f" or not np.isfinite(given).all():
                continue
            if len(given) != len(kernel.conn) or array in ("mass_per_length", "turn_weight", "normal"):
                continue
            along = 0.1 * given * np.random.default_rng(5).normal(size=given.shape)

            def changed(share, number=number, array=array, given=given, along=along):
                kernels = list(reached(name).system.kernels)
                kernels[number] = rebuilt(kernels[number], **{array: given + share * along})
                return with_kernels(name, kernels)

            for functional, rate in zip(asked, res.gradient(asked, f"{kernel.name}.{array}")):
                members = np.arange(len(given)) if kernel.members is None else kernel.members
                left = left_over(name, functional, float((rate[members] * along).sum()), changed)
                assert_second_order(left, rounding_of(functional))
            looked_at += 1
    assert looked_at


@pytest.mark.parametrize("name", RUNGS)
def test_a_sheet_as_stiff_again_bears_as_much_again(name):
    """Forces that displacements hold grow with E as it does itself where no other force acts."""
    alone = kg.Model.from_mesh(results(name).mesh, 0.05, kg.Material(E=1e6, nu=0.3), name)
    alone.add(kg.Fix(alone.select(boundary="bottom")))
    alone.add(kg.Prescribe(alone.select(boundary="top"), x=0.02, y=0.03, z=0.1))
    res = kg.DisplacementControl(alone, tol=1e-10).run()
    force = float(res.reaction("driven_0", "y")[-1])
    assert res.gradient(("force", "driven_0", "y"), ("E", None)) * 1e6 == pytest.approx(force, rel=1e-9)


@pytest.mark.parametrize("name", RUNGS)
def test_uniform_thickness_against_differences(name):
    res, at = results(name), reached(name)
    count = len(res.mesh.triangles)
    base = np.array(res.model.sheet_constants.thickness_of_facets(count))
    tell = tell_of(("force", "driven_0", "y"), res)

    def value(step):
        system = with_kernels(name, _with_sheet(res.model, "thickness", base + step, ""))
        return Equilibrium(system, at.u, at.lam).told(tell).value

    step = 1e-4 * base[0]
    fourth = (8 * (value(step) - value(-step)) - (value(2 * step) - value(-2 * step))) / (12 * step)
    assert res.gradient(("force", "driven_0", "y"), ("thickness", None)) == pytest.approx(fourth, rel=1e-7)


def test_uniform_prestrain_against_differences():
    res, at = results("shell"), reached("shell")
    tell, model = tell_of(("force", "driven_0", "y"), res), res.model

    def value(step):
        heat = kg.Actuate(strain=(step, step, 0), constant=True)
        kernels = _kernels(model, [*model.objects, heat], model.sheet_constants, model.positions())
        return Equilibrium(with_kernels("shell", kernels), at.u, at.lam).told(tell).value

    step = 1e-5
    fourth = (8 * (value(step) - value(-step)) - (value(2 * step) - value(-2 * step))) / (12 * step)
    rate = res.gradient(("force", "driven_0", "y"), ("strain", None))
    assert rate[0] + rate[1] == pytest.approx(fourth, rel=1e-7)


# ---- critical load factors


def shallow():
    m = kg.Model(dim=2)
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0.1, 0.3), kg.Node(1, 0))
    m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.3), kg.Fix([left, right]))
    m.add(kg.NodalLoad(apex, (0, -0.01)))
    return m, kg.ArcLength(m, step=0.1, max_steps=60, stop=lambda step: step.u[1, 1] < -0.4).run()


def column():
    """A bar that stands on a hinge and is held aside by a spring: it tilts at k L, with L as it is then."""
    m = kg.Model(dim=2)
    foot, head = m.add(kg.Node(0, 0), kg.Node(0, 2))
    m.add(kg.Bar(foot, head, EA=50.0), kg.Fix(foot), kg.Spring(head, (1.5, 0.0)), kg.NodalLoad(head, (0, -1.0)))
    return m, kg.LoadControl(m, to=4.0, on_instability="follow").run()


@pytest.mark.parametrize("make", [shallow, column])
def test_critical_load_factors(make):
    m, res = make()
    kinds = [event.kind for event in res.events]
    number = kinds.index("limit point" if make is shallow else "bifurcation")
    event = res.events[number]
    system = prepared(m, event.located.history)
    start = CriticalPoint(system, event).lam
    rate = res.gradient(("critical", number), "positions")
    along = np.zeros_like(res.rest)
    along[1] = (0.02, 0.05, 0) if make is shallow else (0, 0.05, 0)
    left = []
    for share in STEPS:
        moved = CriticalPoint(prepared(moved_model(m, m.positions() + share * along), event.located.history), event).lam
        left.append(abs(moved - start - share * float((rate * along).sum())) / start)
    assert_second_order(np.array(left), 1e-8)
    if make is shallow:  # all forces are in proportion to EA
        EA = np.array([bar.EA for bar in m.elements])
        assert float(EA @ res.gradient(("critical", number), "bars.EA")) == pytest.approx(start, rel=1e-8)
    else:
        both = 50.0 * res.gradient(("critical", number), "bars.EA")[0]
        springs = res.gradient(("critical", number), "grounded springs.stiffness")
        assert both + 1.5 * float(springs[..., 0].sum()) == pytest.approx(start, rel=1e-7)


# ---- what has none


def test_refusals():
    m, res = shallow()
    with pytest.raises(kg.ModelError, match="begins with one of"):
        res.gradient(("forces", 0, "x"), "positions")
    with pytest.raises(kg.ModelError, match="nothing is called"):
        res.gradient(("energy",), "bars.colour")
    with pytest.raises(kg.ModelError, match="no event"):
        res.gradient(("critical", 7), "positions")
    with pytest.raises(kg.ModelError, match="finite"):
        res.gradient(lambda x, f: float("nan"), "positions")
    with pytest.raises(kg.ModelError, match="of a sheet"):
        res.gradient(("energy",), "thickness")
    with pytest.raises(kg.AnalysisError, match="linear"):
        kg.LinearStatic(m).run().gradient(("energy",), "positions")
    m.perturb(np.array([[0, 0, 0], [0.01, 0, 0], [0, 0, 0]]))
    with pytest.raises(kg.ModelError, match="edited"):
        res.gradient(("energy",), "positions")


def test_friction_has_no_gradient():
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(0, 1))
    m.add(kg.Bar(a, b, EA=10.0), kg.Fix(b), kg.Fix(a, "x"), kg.NodalLoad(a, (0, -0.1)))
    m.add(kg.Contact([a], kg.Plane((0, -0.01), (0, 1)), friction=0.3))
    res = kg.LoadControl(m).run()
    with pytest.raises(kg.ModelError, match="depends on the way"):
        res.gradient(("energy",), "positions")


def test_yield_has_no_gradient():
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, EA=10.0, yield_force=0.05), kg.Fix(a), kg.Fix(b, "y"), kg.Prescribe(b, x=0.01))
    res = kg.DisplacementControl(m).run()
    with pytest.raises(kg.ModelError, match="depends on the way"):
        res.gradient(("energy",), "positions")


def test_self_contact_has_no_gradient():
    pytest.importorskip("ipctk")
    m = results("plate").model
    alone = kg.Model.from_mesh(m.mesh, 0.05, kg.Material(E=1e6, nu=0.3), "plate")
    alone.add(kg.Fix(alone.select(boundary="bottom")), kg.Prescribe(alone.select(boundary="top"), x=0, y=0.01, z=0))
    alone.add(kg.SelfContact())
    res = kg.DisplacementControl(alone).run()
    with pytest.raises(kg.ModelError, match="far apart"):
        res.gradient(("energy",), "thickness")


def test_the_strain_of_a_uniform_stretch_and_of_finer_meshes():
    """sqrt(exx^2 + eyy^2) of a stretch and a contraction; at a crack hardly a matter of the mesh, as its largest is."""
    found, largest = [], []
    for nodes in (150, 600):
        mesh = kg.Sheet(shapely.box(0, 0, 1, 1), [[(0.3, 0.5), (0.7, 0.5)]], 0.01, kg.Material(1e6)).mesh(nodes=nodes)
        m = kg.Model.from_mesh(mesh, stiffness="shell")
        top = m.select(boundary="top")
        m.add(kg.Fix(m.nodes, "z"), kg.Fix(m.select(boundary="bottom"), "xy"), kg.Prescribe(top, x=0, y=0.01))
        res = kg.LinearStatic(m).run()
        tell = tell_of(("strain",), res)
        found.append(tell(res.position()[-1], np.zeros_like(res.rest), 0.0).value)
        largest.append(np.abs(facet_strain(res)[-1]).max())
        drawn = mesh.nodes * [1.02, 0.99, 1.0]
        exact = np.hypot(0.5 * (1.02**2 - 1), 0.5 * (0.99**2 - 1))
        assert tell(drawn, np.zeros_like(drawn), 0.0).value == pytest.approx(exact, rel=1e-12)
    assert found[1] == pytest.approx(found[0], rel=0.05) and largest[1] > 1.4 * largest[0]
