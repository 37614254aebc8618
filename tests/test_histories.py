"""Going on, turning back, stages, constant loads, interruption, files."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import kirigami as kg
from kirigami.primitives.parts import ModelObject


def cantilever_plate() -> tuple[kg.Model, list[kg.Node], list[kg.Node]]:
    """A strip of 2 x 6 squares, held at the left edge by its first two columns of nodes."""
    x, y = np.meshgrid(np.arange(7.0), np.arange(3.0))
    points = np.column_stack([x.ravel(), y.ravel()])
    triangles = []
    for row in range(2):
        for column in range(6):
            a = row * 7 + column
            triangles += [[a, a + 1, a + 8], [a, a + 8, a + 7]]
    m = kg.Model.from_mesh(kg.TriMesh(points, triangles), thickness=0.05, material=kg.Material(E=1e4, nu=0.3))
    held, tip = m.select(where=lambda x, y, z: x < 1.5), m.select(where=lambda x, y, z: x > 5.5)
    m.add(kg.Fix(held))
    return m, held, tip


def test_unload_and_reload_come_back_on_the_same_path():
    m, _, tip = cantilever_plate()
    m.add(kg.NodalLoad(tip, (0, 0, 1e-3)))
    there = kg.LoadControl(m, targets=[0.5]).run()
    back = kg.LoadControl(m, to=0.0, start=there[-1]).run()
    np.testing.assert_allclose(back.u[-1], 0, atol=1e-8)
    again = kg.LoadControl(m, to=0.5, start=back[-1]).run()
    half = there.u[np.flatnonzero(there.lam == 0.5)[0]]
    np.testing.assert_allclose(again.u[-1], half, atol=1e-7)


def test_stages_fold_then_stretch():
    """The fold of stage one stays while stage two drives something else, and its load factor starts at zero."""
    m, held, tip = cantilever_plate()
    lift = m.add(kg.Prescribe(tip, z=1.0))
    folded = kg.DisplacementControl(m).run()
    m.hold(folded[-1])
    m.add(kg.Prescribe(tip, y=0.2))
    res = kg.DisplacementControl(m, start=folded[-1]).run()
    assert res.lam[0] == 0.0 and res.lam[-1] == 1.0
    np.testing.assert_allclose(res.u[0], folded.u[-1], atol=1e-9)
    tips = m.index(tip)
    np.testing.assert_allclose(res.u[-1][tips][:, 2], 1.0, atol=1e-12)
    np.testing.assert_allclose(res.u[-1][tips][:, 1], 0.2, atol=1e-12)
    assert lift not in m.constraints


def test_edited_supports_without_hold_are_refused():
    m, held, tip = cantilever_plate()
    lift = m.add(kg.Prescribe(tip, z=1.0))
    folded = kg.DisplacementControl(m).run()
    m.remove(lift)
    m.add(kg.Prescribe(tip, z=0.5))
    with pytest.raises(kg.ModelError, match="hold"):
        kg.DisplacementControl(m, start=folded[-1]).run()


def test_constant_load_acts_at_load_factor_zero():
    m, held, tip = cantilever_plate()
    m.add(kg.NodalLoad(tip, (0, 0, 1e-3), constant=True), kg.NodalLoad(tip, (0, 1e-3)))
    res = kg.LoadControl(m).run()
    assert res.u[0, m.index(tip)[0], 2] > 1e-3
    np.testing.assert_allclose(res.reaction(held, "z"), -3e-3, rtol=1e-6)
    np.testing.assert_allclose(res.reaction(held, "y"), -3e-3 * res.lam, atol=1e-10)


def test_targets_are_hit_exactly_and_recorders_see_every_step():
    m, _, tip = cantilever_plate()
    m.add(kg.NodalLoad(tip, (0, 0, 1e-3)))
    seen: list[kg.Step] = []
    targets = [0.1, 1 / 3, 0.77]
    res = kg.LoadControl(m, targets=targets).run(recorders=[seen.append])
    assert set(targets) <= set(res.lam.tolist())
    assert [step.lam for step in seen] == res.lam.tolist()


def test_interruption_leaves_what_is_done():
    m, _, tip = cantilever_plate()
    m.add(kg.NodalLoad(tip, (0, 0, 1e-3)))

    def press_control_c(step: kg.Step) -> None:
        if step.lam > 0.3:
            raise KeyboardInterrupt

    analysis = kg.LoadControl(m)
    with pytest.warns(kg.KirigamiWarning, match="interrupted"):
        res = analysis.run(recorders=[press_control_c])
    assert res is analysis.results and res.events[-1].kind == "interrupted" and 0.3 < res.lam[-1] < 1


def test_energy_balance_and_member_forces():
    """Work of the drive equals the stored energy; energies by kernel follow from members (linear laws)."""
    m, _, tip = cantilever_plate()
    m.add(kg.Prescribe(tip, z=2.0))
    res = kg.DisplacementControl(m, targets=np.linspace(0, 1, 101)[1:]).run()
    force = res.reaction(tip, "z")
    work = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(2.0 * res.lam))
    stored = sum(energy[-1] for energy in res.energy.values())
    assert work == pytest.approx(stored, rel=1e-3)
    stiffness = np.array([e.stiffness for e in m.elements if isinstance(e, kg.BendHinge)])
    assert np.sum(res.hinge_moment[-1] ** 2 / (2 * stiffness)) == pytest.approx(res.energy["hinges"][-1], rel=1e-12)
    length = np.array([np.hypot(e.i.x - e.j.x, e.i.y - e.j.y) for e in m.elements if isinstance(e, kg.Bar)])
    EA = np.array([e.EA for e in m.elements if isinstance(e, kg.Bar)])
    assert np.sum(EA * length * res.bar_strain[-1] ** 2 / 2) == pytest.approx(res.energy["bars"][-1], rel=1e-12)


def test_results_file_round_trip(tmp_path):
    m, held, tip = cantilever_plate()
    m.add(kg.Prescribe(tip, z=1.5), kg.NodalLoad(tip, (0, 1e-3), constant=True))
    res = kg.DisplacementControl(m).run()
    back = kg.load(res.save(tmp_path / "run.npz"))
    tips = m.index(tip).tolist()
    for name in ("lam", "u", "stable", "bar_force", "bar_strain", "hinge_angle", "hinge_moment", "residual"):
        np.testing.assert_array_equal(getattr(back, name), getattr(res, name))
    np.testing.assert_array_equal(back.reaction(tips, "z"), res.reaction(tip, "z"))
    assert back.summary() == res.summary()
    assert back.energy.keys() == res.energy.keys()
    np.testing.assert_array_equal(back.mesh.triangles, res.mesh.triangles)
    assert [p.name for p in tmp_path.iterdir()] == ["run.npz"]
    with pytest.raises(kg.ModelError, match="give node indices"):
        back.reaction(tip)


def test_damaged_results_file(tmp_path):
    path = tmp_path / "run.npz"
    with pytest.raises(kg.AnalysisError, match="no results file"):
        kg.load(path)
    path.write_bytes(b"not a results file")
    with pytest.raises(kg.AnalysisError):
        kg.load(path)
    m, _, tip = cantilever_plate()
    m.add(kg.NodalLoad(tip, (0, 0, 1e-3)))
    kg.LoadControl(m).run().save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(kg.AnalysisError):
        kg.load(path)


def test_angle_history_survives_a_restart_beyond_pi():
    """A hinge wound by one and a half turns goes on from a stored step, also one read from a file."""
    m = kg.Model()
    i, j, k, l = m.add(kg.Node(0.5, 1), kg.Node(0, 0), kg.Node(1, 0), kg.Node(0.5, -1))
    hinge = m.add(kg.BendHinge(i, j, k, l, 1.0, rest_angle=0.0))
    bars = [m.add(kg.Bar(a, b, 1e3)) for a, b in ((i, j), (i, k), (j, k), (l, j), (l, k))]
    m.add(kg.Fix([i, j, k]))
    states = [kg.Step.at(m, 0.0, np.zeros((4, 3)))]
    system = kg.System(m)
    for angle in np.linspace(0, 3 * np.pi, 25)[1:]:
        u = np.zeros((4, 3))
        u[3] = [0, 1 - np.cos(angle), np.sin(angle)]
        system.commit(u)
        states.append(u)
    wound = next(kernel for kernel in system.kernels if kernel.name == "hinges")
    assert wound.history[0] == pytest.approx(3 * np.pi)
    fresh = kg.System(m)
    fresh.history = system.history
    assert sum(fresh.energies(states[-1]).values()) == pytest.approx(0.5 * (3 * np.pi) ** 2, rel=1e-9)
    assert hinge.stiffness == 1.0 and len(bars) == 5


def test_a_truss_imports_no_mesher_and_no_plots():
    """Importing the package loads numpy only, and a hand-built scene neither shapely, triangle nor matplotlib."""
    code = """
import sys
import kirigami as kg
heavy = [name for name in ("shapely", "triangle", "scipy.sparse.linalg", "matplotlib") if name in sys.modules]
assert not heavy, heavy
m = kg.Model(dim=2)
a, b, c = m.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0))
m.add(kg.Bar(a, b, EA=1.0), kg.Bar(b, c, EA=1.0), kg.Fix([a, c]), kg.NodalLoad(b, (0, -0.1)))
kg.LinearStatic(m).run()
kg.DisplacementControl(m, to=-0.5, control=(b, "y")).run()
loaded = [name for name in sys.modules if name.split(".")[0] in ("shapely", "triangle", "matplotlib")]
loaded += [name for name in sys.modules if name.startswith(("kirigami.geometry", "kirigami.elements.bend"))]
assert not loaded, loaded
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_summary_explains_the_cost():
    m, _, tip = cantilever_plate()
    m.add(kg.NodalLoad(tip, (0, 0, 1e-3)))
    res = kg.LoadControl(m).run()
    assert set(res.stats) >= {"iterations", "factorizations", "steps", "cutbacks", "seconds", "backend"}
    assert res.stats["factorizations"] >= res.stats["iterations"] > 0
    parts = res.stats["seconds"]
    assert {"bars", "hinges", "assembly", "factorization", "solve", "total"} <= set(parts)
    assert sum(v for k, v in parts.items() if k != "total") <= parts["total"]
    assert res.stats["backend"] in res.summary() and "factorizations" in res.summary()


def test_a_model_without_free_displacements_still_answers():
    mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e3))
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left), kg.Fix(right, "yz"), kg.Prescribe(right, x=0.1))
    for res in (kg.LinearStatic(m).run(), kg.DisplacementControl(m).run()):
        np.testing.assert_allclose(res.reaction(left, "x")[-1], -res.reaction(right, "x")[-1], rtol=1e-12)
        assert res.reaction(right, "x")[-1] > 0.5


def test_an_effect_on_single_nodes():
    """An elastic bed of stiffness k under a node: the smallest effect there is, object and kernel in a few lines."""

    class BedKernel(kg.Kernel):
        name = "bed"
        anchored = True

        def __init__(self, rest, conn, stiffness):
            self.rest, self.conn, self.stiffness = rest, conn, stiffness

        def evaluate(self, x, lam=1.0, need=2):
            sunk = (np.asarray(x) - self.rest)[self.conn]
            block = self.stiffness * np.eye(x.shape[1])
            energy = 0.5 * self.stiffness * (sunk**2).sum(axis=(1, 2))
            blocks = np.broadcast_to(block, (len(sunk), 1, 1, *block.shape))
            return kg.Contribution(energy, self.stiffness * sunk, blocks)

    class Bed(ModelObject):
        kind = "effect"

        def __init__(self, node, stiffness):
            self.node, self.stiffness = node, stiffness

        @property
        def nodes(self):
            return (self.node,)

        @classmethod
        def lower(cls, objects, numbering):
            return [BedKernel(numbering.rest, numbering.connectivity([bed]), bed.stiffness) for bed in objects]

    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    m.add(kg.Bar(a, b, EA=10.0), Bed(a, 5.0), kg.Fix(b, "y"), kg.NodalLoad(b, (1.0, 0)))
    res = kg.LinearStatic(m).run()
    np.testing.assert_allclose(res.u[-1, :, 0], [1 / 5, 1 / 5 + 2 / 10], rtol=1e-12)
    assert res.energy["bed"][-1] == pytest.approx(0.1, rel=1e-12)
    assert max(kg.check_kernel(kg.System(m).kernels[-1], [[0.1, 0.2], [2.0, 0]])["hessian"], 0) < 1e-6
