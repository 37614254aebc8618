"""Grounded springs, bars that bear tension alone, and rest lengths and angles that are driven."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from held_to_differences import assert_right, kernel_of

import kirigami as kg

EA, K = 40.0, 0.7


# ---- grounded springs


def test_grounded_spring_in_series_with_a_bar() -> None:
    """Two springs in series, and the ground takes what the load brings, also at large displacements."""
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    m.add(kg.Bar(a, b, EA, strain="engineering"), kg.Fix(a, "y"), kg.Fix(b, "y"))
    m.add(kg.Spring(a, 5.0), kg.NodalLoad(b, (3.0, 0)))
    res = kg.LoadControl(m).run()
    assert res.u[-1, :, 0] == pytest.approx([3 / 5, 3 / 5 + 3 * 2 / EA], rel=1e-9)
    assert res.force("grounded springs")[-1, 0] == pytest.approx([3.0, 0.0], abs=1e-9)
    assert res.energy["grounded springs"][-1] == pytest.approx(0.5 * 3**2 / 5, rel=1e-9)


def test_grounded_springs_hold_what_nothing_else_holds() -> None:
    """Three springs carry a free triangle: no support is asked for, and eigenvalues of its shifts are k."""
    m = kg.Model(dim=2)
    corners = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0.3, 0.9))
    m.add(*(kg.Bar(corners[i], corners[j], EA) for i, j in ((0, 1), (1, 2), (2, 0))))
    m.add(kg.Spring(corners, K), kg.NodalLoad(corners[2], (0.1, 0)))
    assert kg.LinearStatic(m).run().u[-1].sum(axis=0)[0] == pytest.approx(0.1 / K, rel=1e-9)
    values = kg.Eigen(m, n=3).run().values
    assert values == pytest.approx([K] * 3, rel=1e-7)  # two shifts, and a turn about the centroid
    m.remove(m.effects[0])
    m.add(kg.Spring(corners, (K, 0.0)))
    with pytest.raises(kg.MechanismError, match="translation along y"):
        kg.LinearStatic(m).run()


def test_spring_kernel() -> None:
    m = kg.Model()
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0.2, 0.1))
    m.add(kg.Bar(a, b, EA), kg.Spring([a, b], (1.0, 0.0, 3.0)), kg.Spring(b, 2.0))
    kernel = kernel_of(m, "grounded springs")
    assert_right(kernel, np.random.default_rng(0).normal(size=(2, 3)), bound=1e-8)
    x = m.positions() + [[0.1, 0.2, 0.3], [1, 1, 1]]
    assert kernel.force(kernel.deformation(x)).tolist() == [
        pytest.approx([0.1, 0, 0.9]), pytest.approx([1, 0, 3]), pytest.approx([2, 2, 2])
    ]  # fmt: skip


# ---- tension alone


def test_a_cable_bears_tension_alone() -> None:
    """An apex between two inclined cables and a soft spring: pulled up, the cables are slack and the spring bears all;
    pulled down, they are bars."""
    answers = {}
    for law in ("cable", "linear"):
        for sign in (1, -1):
            m = kg.Model(dim=2)
            left, apex, right = m.add(kg.Node(-1, 1), kg.Node(0, 0), kg.Node(1, 1))
            m.add(*(kg.Bar(end, apex, EA, law=law, strain="engineering") for end in (left, right)))
            m.add(kg.Fix([left, right]), kg.Spring(apex, K), kg.NodalLoad(apex, (0, sign * 0.2)))
            answers[law, sign] = kg.LoadControl(m).run()
    up, down = answers["cable", 1], answers["cable", -1]
    assert up.u[-1, 1, 1] == pytest.approx(0.2 / K, rel=1e-9)
    assert not up.bar_force[-1].any() and not up.energy["bars"][-1]
    assert down.u[-1] == pytest.approx(answers["linear", -1].u[-1], rel=1e-9)
    assert down.bar_force[-1] == pytest.approx(answers["linear", -1].bar_force[-1], rel=1e-9)


def test_newton_passes_corners_of_many_cables() -> None:
    """A net of cables with random rest lengths, some slack from the start, pressed to and fro: equilibrium of every
    node at every stored step, and no cable in compression."""
    random = np.random.default_rng(5)
    m = kg.Model()
    x, y = np.meshgrid(np.arange(5.0), np.arange(5.0))
    nodes = m.add(*(kg.Node(*place, 0.0) for place in np.column_stack([x.ravel(), y.ravel()]).tolist()))
    for a, b in [(k, k + 1) for k in range(25) if k % 5 < 4] + [(k, k + 5) for k in range(20)]:
        m.add(kg.Bar(nodes[a], nodes[b], EA, rest_length=random.uniform(0.95, 1.05), law="cable"))
    rim = [node for node in nodes if node.x in (0, 4) or node.y in (0, 4)]
    inner = [node for node in nodes if node not in rim]
    m.add(kg.Fix(rim), kg.Spring(inner, 0.3))
    for node in inner:
        m.add(kg.NodalLoad(node, random.normal(size=3)))
    res = kg.LoadControl(m).run()
    assert res.residual.max() < 1e-8
    assert res.bar_force.min() == 0.0 and res.bar_force.max() > 1.0
    slack = np.sum(res.bar_force == 0, axis=1)
    assert len(set(slack.tolist())) > 2  # cables go slack and taut on the way
    outward = res.reaction(rim)[-1] + sum(np.array(load.force) for load in m.loads)
    outward -= res.force("grounded springs")[-1].sum(axis=0)
    assert np.abs(outward).max() < 1e-6


@pytest.mark.parametrize("strain", ["green", "engineering"])
@pytest.mark.parametrize("law", ["linear", "cable"])
@pytest.mark.parametrize("length", [0.8, 1.7])
def test_kernels_of_cables_and_driven_bars(strain: str, law: str, length: float) -> None:
    m = kg.Model()
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0.2, 0.1))
    m.add(kg.Bar(a, b, EA, strain=strain, law=law, target_length=1.5))
    x = [[0, 0, 0], np.array([0.6, 0.0, 0.8]) * length]
    assert_right(kernel_of(m, "bars"), x, balanced=True)


# ---- driven rest values


@pytest.mark.parametrize("law, strain", [("linear", "green"), ("linear", "engineering"), ("ogden", "green")])
def test_a_free_bar_takes_its_target_length(law: str, strain: str) -> None:
    """Nothing else drives: the bar has its target length at load factor 1, halfway the mean, and no stress."""
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(3, 4))
    bar = m.add(kg.Bar(a, b, EA, law=law, strain=strain, target_length=6.0))
    m.add(kg.Fix(a), kg.Fix(b, "x"))
    res = kg.LoadControl(m, targets=[0.5, 1.0]).run()
    at = {round(lam, 9): k for k, lam in enumerate(res.lam)}
    for lam, length in ((0.5, 5.5), (1.0, 6.0)):
        assert np.linalg.norm(res.position(b)[at[lam]]) == pytest.approx(length, rel=1e-9)
        assert abs(res.force("bars", of=bar)[at[lam], 0]) < 1e-6
    assert res.energy["bars"].max() < 1e-12


def test_a_held_bar_is_stressed_by_its_drive() -> None:
    """Between fixed ends the force is E A (L - L1) / L1, and a stage that goes on from there keeps it."""
    m = kg.Model(dim=2)
    a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    first = m.add(kg.Bar(a, b, EA, strain="engineering", target_length=0.9))
    m.add(kg.Bar(b, c, EA, strain="engineering"), kg.Fix([a, c]), kg.Fix(b, "y"))
    linear = kg.LinearStatic(m).run()
    assert linear.bar_force[-1] == pytest.approx([EA * 0.1 / 2] * 2, rel=1e-9)
    res = kg.LoadControl(m).run()
    # equal forces: (1 + d) / 0.9 - 1 = -d  for the shift d of the node between them
    shift = (1 - 1 / 0.9) / (1 + 1 / 0.9)
    assert res.u[-1, 1, 0] == pytest.approx(shift, rel=1e-8)
    assert res.bar_force[-1] == pytest.approx([-EA * shift] * 2, rel=1e-8)
    half = kg.LoadControl(m, to=0.5).run()
    m.hold(half[-1])
    m.add(kg.NodalLoad(b, (1e-9, 0)))
    after = kg.LoadControl(m, start=half[-1]).run()
    assert after.bar_force[0] == pytest.approx(half.bar_force[-1], rel=1e-7)
    assert after.u[0] == pytest.approx(half.u[-1], abs=1e-9)
    assert first.held(0.5).held(0.9).reached == 0.5


def _hinge(**options: Any) -> tuple[kg.Model, str]:
    m = kg.Model()
    i, j, k, l = m.add(kg.Node(0.5, 1), kg.Node(0, 0), kg.Node(1, 0), kg.Node(0.5, -1))
    m.add(*(kg.Bar(*ends, 1e3) for ends in ((i, j), (i, k), (j, k), (l, j), (l, k))))
    m.add(kg.BendHinge(i, j, k, l, 0.3, **options), kg.Fix([i, j, k]))
    return m, "hinges"


def _joint(**options: Any) -> tuple[kg.Model, str]:
    m = kg.Model(dim=2)
    i, j, k = m.add(kg.Node(0, 1), kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(i, j, 1e3), kg.Bar(j, k, 1e3), kg.TorsionSpring3(i, j, k, 0.3, **options), kg.Fix([j, k]))
    return m, "springs"


def _fold(**options: Any) -> tuple[kg.Model, str]:
    mesh = kg.TriMesh([[0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [2, 1]], [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]])
    m = kg.Model.from_mesh(mesh, 0.05, kg.Material(1e5, 0.3), stiffness="shell")
    m.add(kg.Crease([m.nodes[1], m.nodes[2]], 0.3, **options), kg.Fix([m.nodes[k] for k in (0, 1, 2, 3)]))
    return m, "creases"


FOLDS = {"hinge": _hinge, "three-node spring": _joint, "crease": _fold}


@pytest.mark.parametrize("fold", FOLDS)
def test_a_free_fold_takes_its_target_angle(fold: str) -> None:
    """Driven by nothing else, the fold follows its rest angle without moment; held half way it stays."""
    m, name = FOLDS[fold]()
    start = float(kernel_of(m, name).deformation(kg.System(m).rest)[0])
    m, name = FOLDS[fold](target_angle=start + 0.8)
    res = kg.LoadControl(m, targets=[0.5, 1.0]).run()
    half = int(np.argmin(np.abs(res.lam - 0.5)))
    assert res.deformation(name)[[half, -1], 0] == pytest.approx([start + 0.4, start + 0.8], abs=1e-7)
    assert np.abs(res.force(name)).max() < 1e-7
    m.hold(res[half])
    m.add(kg.NodalLoad(m.nodes[0], (1e-9,) * m.dim))
    after = kg.LoadControl(m, start=res[half]).run()
    assert after.deformation(name)[-1, 0] == pytest.approx(start + 0.4, abs=1e-7)


@pytest.mark.parametrize("fold", FOLDS)
def test_kernels_of_driven_folds(fold: str) -> None:
    m, name = FOLDS[fold](rest_angle=0.2, target_angle=1.1)
    kernel = kernel_of(m, name)
    rest = kg.System(m).rest
    assert_right(kernel, rest + np.random.default_rng(2).normal(scale=0.1, size=rest.shape))


def test_driven_members_survive_saving(tmp_path: Any) -> None:
    m, _ = _hinge(target_angle=0.7)
    m.add(kg.Bar(m.nodes[0], m.nodes[3], 0.01, law="cable", target_length=1.9), kg.Spring(m.nodes[3], 1e-3))
    res = kg.LoadControl(m).run()
    back = kg.load(res.save(tmp_path / "driven"))
    assert back.bar_force == pytest.approx(res.bar_force, rel=1e-12, abs=1e-15)
    assert back.hinge_moment == pytest.approx(res.hinge_moment, rel=1e-12, abs=1e-15)
    assert back.force("grounded springs") == pytest.approx(res.force("grounded springs"), rel=1e-12, abs=1e-15)


def test_work_of_a_drive_is_the_energy_stored() -> None:
    """The change of the potential with the load factor, summed over the path, is the energy at its end."""
    m, _ = _hinge(target_angle=0.9)
    m.add(kg.Spring(m.nodes[3], 0.4))
    system = kg.System(m)
    steps = kg.LoadControl(m, targets=np.linspace(0, 1, 41)[1:]).run()
    rates = [system.potential_rate(system.joined(step.u, step.inner), step.lam) for step in steps.steps]
    stored = sum(values[-1] for values in steps.energy.values())
    assert np.trapezoid(rates, steps.lam) == pytest.approx(stored, rel=2e-3)


# ---- bad input, and what is not used


def test_what_cannot_be_is_refused() -> None:
    a, b = kg.Node(0, 0), kg.Node(1, 0)
    for make, words in (
        (lambda: kg.Spring([], 1.0), "empty"),
        (lambda: kg.Spring(a, -1.0), "must be positive"),
        (lambda: kg.Spring(a, (0.0, 0.0)), "must be positive"),
        (lambda: kg.Spring([a, a], 1.0), "twice"),
        (lambda: kg.Bar(a, b, 1.0, target_length=0.0), "target_length"),
        (lambda: kg.Crease([a, b], 1.0, target_angle=4.0), "target_angle must lie between"),
    ):
        with pytest.raises(kg.ModelError, match=words):
            make()
    m = kg.Model(dim=2)
    m.add(a, b)
    m.add(kg.Bar(a, b, 1.0), kg.Fix(a), kg.Spring(b, (0, 0, 1)))
    with pytest.raises(kg.ModelError, match="along z alone"):
        kg.System(m)


def test_a_model_without_them_loads_nothing_of_them() -> None:
    """No effect is imported, lowered, timed or given unknowns where a scene does not call for it."""
    code = (
        "import sys, kirigami as kg; m = kg.Model(dim=2); a, b = m.add(kg.Node(0, 0), kg.Node(1, 0));"
        "m.add(kg.Bar(a, b, 1.0), kg.Fix(a), kg.Fix(b, 'y'), kg.NodalLoad(b, (1, 0))); res = kg.LoadControl(m).run();"
        "unused = ('effects.', 'model.grip', 'model.pressure', 'model.flow', 'model.actuate', 'system.grips',"
        "'primitives.rotation', 'results.moments');"
        "loaded = [name for name in sys.modules if name.startswith(tuple('kirigami.' + part for part in unused))];"
        "system = kg.System(m);"
        "sys.exit(bool(loaded) or len(system.kernels) != 2 or system.free != 1 or len(system.rest) != 2"
        " or 'grips' in res.stats['seconds'])"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
