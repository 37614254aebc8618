"""Motion that is driven: histories of single loads and supports, what reactions hold, rigid grips and links."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.system.inertia import Inertia

History = Callable[[float], float]


def gust(t: float) -> float:
    return float(np.sin(7 * t) ** 2)


def sway(t: float) -> float:
    return float(1 - np.cos(5 * t))


def frame(dim: int = 2) -> tuple[kg.Model, list[kg.Node]]:
    """Two triangles of bars with mass; nothing holds it."""
    m = kg.Model(dim=dim)
    places = ((0, 0), (1, 0), (0, 1), (1, 1.1), (2, 0.6))
    nodes = m.add(*(kg.Node(*place) for place in places))
    for a, b in ((0, 1), (0, 2), (1, 2), (1, 3), (2, 3), (3, 4), (1, 4)):
        m.add(kg.Bar(nodes[a], nodes[b], 100.0, mass_per_length=1.0))
    return m, list(nodes)


def sheet(rung: str = "plate") -> kg.Model:
    mesh = kg.Sheet(shapely.box(0, 0, 0.1, 0.06)).mesh(0.03)
    return kg.Model.from_mesh(mesh, 0.5e-3, kg.Material(3.5e9, 0.34, density=1400.0), stiffness=rung)


SUPPORTS: dict[str, Callable[[list[kg.Node]], Any]] = {
    "Prescribe": lambda ends: kg.Prescribe(ends, x=0.05, y=-0.1),
    "Turn": lambda ends: kg.Turn(ends, angle=50.0, axis="z", shift=(0.3, 0.1)),
    "Grip": lambda ends: kg.Grip(ends, move=(0.3, 0.1, 0), turn=(0, 0, np.radians(50))),
}


@pytest.mark.parametrize("support", SUPPORTS)
def test_a_support_and_a_load_follow_histories_of_their_own(support: str) -> None:
    """Each alone as it would with the history of all; and both at once, whichever of them is told apart."""

    def run(apart: str, **more: Any) -> kg.Results:
        m, nodes = frame()
        objects = {"support": SUPPORTS[support](nodes[:2]), "load": kg.NodalLoad(nodes[4], (3.0, -5.0))}
        m.add(*objects.values())
        of = {"support": sway, "load": gust}
        common = {"support": "load", "load": "support", "both": "support"}[apart]
        histories = {objects[name]: of[name] for name in of if apart in (name, "both")}
        return kg.Dynamics(m, end=1.0, step=0.02, load=of[common], histories=histories, **more).run()

    runs = [run(apart) for apart in ("support", "load", "both")]
    size = np.abs(runs[0].u).max()
    assert np.abs(runs[0].u[:, 4]).max() > 0.1
    for other in runs[1:]:
        assert np.abs(other.u - runs[0].u).max() < 1e-9 * size
        assert np.abs(other.velocity - runs[0].velocity).max() < 1e-7 * np.abs(runs[0].velocity).max()
        assert other.reaction("driven_0") == pytest.approx(runs[0].reaction("driven_0"), abs=1e-6)
    # and not as with one history for all
    m, nodes = frame()
    m.add(SUPPORTS[support](nodes[:2]), kg.NodalLoad(nodes[4], (3.0, -5.0)))
    assert np.abs(kg.Dynamics(m, end=1.0, step=0.02, load=sway).run().u - runs[0].u).max() > 1e-2 * size


def loaded_sheet() -> tuple[kg.Model, dict[str, Any]]:
    m = sheet()
    m.add(kg.Fix(m.select(boundary="left"), clamp=True))
    loads = {"pressure": kg.Pressure(300.0), "area": kg.AreaLoad((0, 0, -40.0)), "weight": kg.Gravity()}
    m.add(*loads.values())
    return m, loads


def test_every_kind_of_load_takes_a_history(tmp_path) -> None:
    """A pressure that follows, an area load, the weight: at factors of their own that are all the same as the common
    one; half of it where the common one is twice."""
    m, loads = loaded_sheet()
    whole = kg.Dynamics(m, end=4e-3, step=4e-4, load=gust).run()
    m, loads = loaded_sheet()
    apart = kg.Dynamics(
        m, end=4e-3, step=4e-4, load=lambda t: -3 * gust(t), histories=dict.fromkeys(loads.values(), gust)
    ).run()
    assert np.abs(apart.u - whole.u).max() < 1e-6 * np.abs(whole.u).max()
    # what is told of it, and of a file of it
    back = kg.load(apart.save(tmp_path / "apart.npz"))
    left = m.mesh.sets["left"] if "left" in m.mesh.sets else m.index(m.select(boundary="left"))
    for told in (apart.reaction(left), back.reaction(left)):
        assert told == pytest.approx(whole.reaction(left), abs=1e-4 * np.abs(whole.reaction(left)).max())


def test_a_motion_with_histories_is_resumed_bit_by_bit(tmp_path) -> None:
    def motion(end: float, tune: float = 1.0) -> kg.Results:
        m, nodes = frame()
        support, load = SUPPORTS["Turn"](nodes[:2]), kg.NodalLoad(nodes[4], (3.0, -5.0))
        m.add(support, load)
        table = [(0.0, 0.0), (0.1, 1.0), (0.4, tune)]
        histories = {support: sway, load: table}
        motion = kg.Dynamics(m, end=end, step=0.02, load=0.0, histories=histories)
        return motion.run(checkpoint=tmp_path / "motion.npz")

    part = motion(0.31)
    again = motion(0.6)
    assert np.array_equal(again.u[: len(part) - 1], part.u[:-1]) and again.time[-1] == 0.6
    assert 0.1 in again.time and 0.4 in again.time  # corners of the table are met
    with pytest.raises(kg.AnalysisError, match="another model or analysis"):
        motion(0.6, tune=0.9)


def test_histories_that_cannot_be_are_refused() -> None:
    m, nodes = frame()
    fix, load = kg.Fix(nodes[:2]), kg.NodalLoad(nodes[4], (1, 0))
    dead, move = kg.NodalLoad(nodes[3], (1, 0), constant=True), kg.Prescribe(nodes[2], x=0.1)
    m.add(fix, load, dead, move)
    settings: dict[str, Any] = {"end": 1.0, "step": 0.1, "load": 0.0}
    for wrong in (fix, dead):
        with pytest.raises(kg.ModelError, match="does not follow a load factor"):
            kg.Dynamics(m, histories={wrong: 1.0}, **settings)
    for wrong in (kg.NodalLoad(nodes[4], (1, 0)), m.elements[0], "wind"):
        with pytest.raises(kg.ModelError, match="no load and no support of the model"):
            kg.Dynamics(m, histories={wrong: 1.0}, **settings)
    with pytest.raises(kg.ModelError, match="must map objects"):
        kg.Dynamics(m, histories=[load], **settings)
    with pytest.raises(kg.ModelError, match="history of NodalLoad.* at time 0"):
        kg.Dynamics(m, histories={load: lambda t: np.nan}, **settings).run()
    with pytest.raises(kg.ModelError, match="would have to jump"):
        kg.Dynamics(m, histories={move: 1.0}, **settings).run()


# ---- reactions


def test_the_reaction_of_a_shaken_mass_is_its_inertia() -> None:
    """Force = m a: over a time step m (v1 - v0) / h, with b = A (1 - cos p t)."""
    mass, A, p = 3.0, 0.02, 6.0
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, 100.0), kg.Mass([a, b], mass), kg.Prescribe([a, b], x=A, y=0))
    run = kg.Dynamics(m, end=1.0, step=5e-3, load=lambda t: 1 - np.cos(p * t), every=2).run()
    speed = A * p * np.sin(p * run.time)
    expected = 2 * mass * np.diff(speed) / np.diff(run.time)
    assert run.reaction([a, b], "x")[1:] == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("scheme", ["conserving", "damped"])
@pytest.mark.parametrize("rung", ["plate", "facet", "shell"])
def test_reactions_and_loads_change_the_momentum(rung: str, scheme: str) -> None:
    """On a sheet that is shaken at one edge, loaded and damped by its stiffness, whatever the steps stored."""
    m = sheet(rung)
    left = m.select(boundary="left")
    m.add(kg.Prescribe(left, x=0, y=0, z=0.004, clamp=True))
    load = m.add(kg.NodalLoad(m.select(boundary="right"), (0, 0, 0.02)))
    run = kg.Dynamics(
        m, end=8e-3, step=5e-4, load=lambda t: 1 - np.cos(500 * t), histories={load: 1.0}, damping=(0.0, 1e-5),
        scheme=scheme, every=3,
    ).run()
    system = kg.System(m)
    inertia = Inertia(system)
    momentum = np.array(
        [
            inertia.momentum(system.joined(step.velocity, step.inner_velocity))[: system.points].sum(axis=0)
            for step in run.steps
        ]
    )
    given = run.reaction(left)[1:] + len(m.select(boundary="right")) * np.array([0, 0, 0.02])
    change = np.diff(momentum, axis=0)
    assert given * np.diff(run.time)[:, None] == pytest.approx(change, abs=1e-6 * np.abs(change).max())


def test_the_work_of_a_shaken_support_is_the_energy() -> None:
    """Reaction times displacement, step by step, of a support whose speed changes evenly."""
    m, nodes = frame()
    m.add(kg.Prescribe(nodes[:2], x=0.2, y=0))
    run = kg.Dynamics(m, end=1.0, step=0.01, load=lambda t: t**2).run()
    work = (run.reaction(nodes[:2], "x")[1:] * 0.2 * np.diff(run.lam)).cumsum()
    energy = sum(run.energy.values())
    assert work == pytest.approx(energy[1:] - energy[0], abs=2e-3 * energy.max())


# ---- rigid grips


def test_a_driven_grip_moves_as_a_turn_does() -> None:
    runs = []
    for support in ("Turn", "Grip"):
        m, nodes = frame()
        m.add(SUPPORTS[support](nodes[:2]))
        runs.append(kg.Dynamics(m, end=1.5, step=0.02, load=gust).run())
    for name in ("u", "velocity"):
        one, other = (getattr(run, name) for run in runs)
        assert np.abs(one - other).max() < 1e-10 * np.abs(one).max()
    assert runs[0].moment("driven_0") == pytest.approx(runs[1].moment("driven_0"), abs=1e-8)


def body(dim: int) -> tuple[kg.Model, np.ndarray, np.ndarray]:
    """Four masses in a rigid link, and a bar that makes no force."""
    places = np.array([(0, 0, 0), (1, 0, 0), (0.3, 0.8, 0.2), (0.2, 0.1, 0.5)]) * ([1, 1, 1] if dim == 3 else [1, 1, 0])
    masses = np.array([1.0, 2.0, 0.5, 0.8])
    m = kg.Model(dim=dim)
    nodes = m.add(*(kg.Node(*place) for place in places.tolist()))
    m.add(kg.Bar(nodes[0], nodes[1], 1.0), kg.RigidLink(nodes))
    for node, mass in zip(nodes, masses.tolist()):
        m.add(kg.Mass(node, mass))
    return m, places, masses


def momenta(run: kg.Results, masses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    p = masses[:, None] * run.velocity
    return p.sum(axis=1), np.cross(run.position(), p).sum(axis=1)


def test_a_rigid_body_spins_on_in_a_plane() -> None:
    """It turns as far as it should, and keeps its energy and momenta, over many turns."""
    m, places, masses = body(2)
    spin = 2.0
    velocity = np.cross([0, 0, spin], places) + [0.1, 0.2, 0]
    run = kg.Dynamics(m, end=10.0, step=0.05, velocity=velocity).run()
    for momentum in momenta(run, masses):
        assert np.abs(momentum - momentum[0]).max() < 1e-9 * np.linalg.norm(momentum[0])
    assert run.energy["kinetic"] == pytest.approx(run.energy["kinetic"][0], rel=1e-9)
    way = run.position()[-1, 1] - run.position()[-1, 0]
    assert np.linalg.norm(way) == pytest.approx(1.0, rel=1e-12)
    off = np.angle(np.exp(1j * (np.arctan2(way[1], way[0]) - 10.0 * spin)))
    assert abs(off) < 10.0 * spin * (0.05 * spin) ** 2 / 10


def test_a_rigid_body_tumbles_in_space() -> None:
    """No axis of inertia: energy is kept to rounding, angular momentum with the square of the step."""
    m, places, masses = body(3)
    velocity = np.cross([0.9, 2.0, 0.7], places)
    off = []
    for step in (0.04, 0.02):
        run = kg.Dynamics(m, end=2.0, step=step, velocity=velocity, tol=1e-11).run()
        linear, angular = momenta(run, masses)
        assert np.abs(linear - linear[0]).max() < 1e-9 * np.linalg.norm(linear[0])
        assert run.energy["kinetic"] == pytest.approx(run.energy["kinetic"][0], rel=1e-9)
        off.append(np.abs(angular - angular[0]).max() / np.linalg.norm(angular[0]))
    assert off[0] < 1e-2 and off[1] < 0.3 * off[0]


def test_a_grip_that_is_free_to_turn_swings() -> None:
    """Two masses on a lever of arm r whose middle is held, and a spring across its end: w^2 = k / (2 m)."""
    k, mass, w = 100.0, 0.5, 10.0
    m = kg.Model(dim=2)
    a, b, ground = m.add(kg.Node(-1, 0), kg.Node(1, 0), kg.Node(1, -5))
    m.add(kg.Bar(b, ground, 5 * k), kg.Fix(ground), kg.Mass([a, b], mass))
    m.add(kg.Grip([a, b], turn=(0, 0, None)))
    size = 1e-5
    run = kg.Dynamics(m, end=2.0, step=5e-3, load=0.0, velocity=[[0, -size], [0, size], [0, 0]], tol=1e-12).run()
    exact = size / w * np.sin(w * run.time)
    assert np.abs(run.u[:, 1, 1] - exact).max() < 2e-2 * size / w
    assert run.u[:, 0, 1] == pytest.approx(-run.u[:, 1, 1], abs=1e-12)
    wide = kg.Dynamics(m, end=2.0, step=1e-2, load=0.0, velocity=[[0, -3], [0, 3], [0, 0]], tol=1e-11).run()
    assert np.abs(wide.u).max() > 0.2 and wide.stats["energy_drift"] < 1e-4
    with pytest.raises(kg.ModelError, match="supports"):
        kg.Dynamics(m, end=1.0, step=0.1, load=0.0, velocity=[[0, 1], [0, 1], [0, 0]]).run()
