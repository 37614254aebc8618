"""Motion in time: balances of energy and momentum, closed forms, order, snaps, what is refused, what is resumed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.system.inertia import Inertia

RUNGS = ("plate", "facet", "shell")


def spring(k: float = 100.0, mass: float = 1.0) -> kg.Model:
    """A mass on a linear spring along x."""
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, EA=k, strain="engineering"), kg.Fix(a), kg.Fix(b, "y"), kg.Mass(b, mass))
    return m


def truss(height: float = 0.3, EA: float = 10.0, mass: float = 2.0) -> kg.Model:
    """von Mises truss whose potential is exactly c (z^2 - H^2)^2 with c = EA / (4 L^3): Green strain."""
    m = kg.Model(dim=2)
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, height), kg.Node(1, 0))
    m.add(kg.Bar(left, apex, EA), kg.Bar(apex, right, EA), kg.Fix([left, right]), kg.Fix(apex, "x"))
    m.add(kg.NodalLoad(apex, (0, -1)), kg.Mass(apex, mass))
    return m


def strip(nx: int, ny: int = 2, length: float = 0.1, width: float = 0.02) -> kg.TriMesh:
    x, y = np.meshgrid(np.linspace(0, length, nx + 1), np.linspace(0, width, ny + 1))
    facets = []
    for j in range(ny):
        for i in range(nx):
            p = j * (nx + 1) + i
            q = p + nx + 1
            odd = (i + j) % 2
            facets += [[p, p + 1, q + 1], [p, q + 1, q]] if odd else [[p, p + 1, q], [p + 1, q + 1, q]]
    return kg.TriMesh(np.column_stack([x.ravel(), y.ravel()]), facets)


def arch(nx: int, rung: str) -> tuple[kg.Model, kg.Step, list[int], float]:
    """A strip pushed together by 1 % stands as an arch, with a load on its middle; the side it stands on."""
    t, length = 0.5e-3, 0.1
    m = kg.Model.from_mesh(strip(nx), t, kg.Material(3.5e9, nu=0.34, density=1400.0), stiffness=rung)
    x = m.mesh.nodes[:, 0]
    m.perturb(t * np.sin(np.pi * x / length) ** 2)
    m.add(kg.Fix(m.select(boundary="left"), clamp=True))
    m.add(kg.Prescribe(m.select(boundary="right"), x=-0.01 * length, y=0, z=0, clamp=True))
    start = kg.DisplacementControl(m).run()[-1]
    m.hold(start)
    middle = np.flatnonzero(np.abs(x - 0.5 * length) < 1e-9).tolist()
    side = float(np.sign(start.u[middle[0], 2]))
    m.add(kg.NodalLoad(m.select(index=middle), (0, 0, -side / len(middle))))
    return m, start, middle, side


def test_a_step_load_snaps_a_truss_at_its_dynamic_critical_load() -> None:
    """P_d / P_s = 4 sqrt(3) / 9, since the highest point of a motion from rest is where the potential is as at rest."""
    H, EA, mass = 0.3, 10.0, 2.0
    c = EA / (4 * np.hypot(1, H) ** 3)
    static = 8 / (3 * np.sqrt(3)) * c * H**3
    period = 2 * np.pi * np.sqrt(mass / (8 * c * H**2))
    m = truss(H, EA, mass)
    lowest = {}
    for side in (-1, 1):
        load = (4 * np.sqrt(3) / 9 + 1e-4 * side) * static
        run = kg.Dynamics(m, end=13 * period, step=period / 40, load=load, every=5).run()
        lowest[side] = run.u[:, 1, 1].min()
        assert run.stats["energy_drift"] < 1e-6
    assert lowest[-1] > -H and lowest[1] < -2 * H


@pytest.mark.parametrize(
    "rung, nx, end, step",
    [("plate", 4, 0.005, 2e-4), pytest.param("shell", 12, 0.008, 1e-4, marks=pytest.mark.long)],
)
def test_energy_is_kept_through_the_snap_of_a_shell(rung: str, nx: int, end: float, step: float) -> None:
    m, start, middle, side = arch(nx, rung)
    run = kg.Dynamics(m, end=end, step=step, start=start, load=3.5).run()
    z = side * run.u[:, middle[0], 2]
    assert z[0] > 5e-3 and z.min() < -5e-3
    total = sum(run.energy.values()) + 3.5 * run.u[:, middle, 2].mean(axis=1) * side
    kinetic = run.energy["kinetic"]
    assert np.abs(total - total[0]).max() <= 1e-4 * kinetic.max()
    assert run.stats["energy_drift"] <= 1e-4


@pytest.mark.long
def test_energy_is_kept_while_an_arch_swings_after_its_snap() -> None:
    """Loaded at once by 1.3 of its static limit load it snaps through, and swings on for sixty milliseconds."""
    m, start, middle, side = arch(12, "shell")
    control = (m.nodes[middle[0]], "z")
    path = kg.DisplacementControl(m, to=-side * 5e-4, control=control, start=start, on_instability="follow").run()
    (limit,) = [event for event in path.events if event.kind == "limit point"]
    load = 1.3 * limit.lam
    run = kg.Dynamics(m, end=0.06, step=1e-4, start=start, load=load).run()
    z = side * run.u[:, middle[0], 2]
    assert z[0] > 5e-3 and z.min() < -5e-3
    total = sum(run.energy.values()) + load * run.u[:, middle, 2].mean(axis=1) * side
    assert np.abs(total - total[0]).max() <= 1e-4 * run.energy["kinetic"].max()


def test_the_damped_scheme_never_gains_energy_in_a_snap() -> None:
    m, start, middle, side = arch(4, "plate")
    run = kg.Dynamics(m, end=0.02, step=4e-4, start=start, load=3.5, scheme="damped").run()
    total = sum(run.energy.values()) + 3.5 * run.u[:, middle, 2].mean(axis=1) * side
    assert np.diff(total).max() <= 1e-6 * run.energy["kinetic"].max()
    assert side * run.u[-1, middle[0], 2] < -5e-3 and run.energy["kinetic"][-1] < 0.1 * run.energy["kinetic"].max()


@pytest.mark.parametrize("rung", RUNGS)
def test_a_free_spinning_sheet_keeps_its_momenta(rung: str) -> None:
    """It tumbles and flutters; linear and angular momentum stay."""
    mesh = kg.Sheet(shapely.box(0, 0, 0.1, 0.06)).mesh(0.06)
    m = kg.Model.from_mesh(mesh, 0.5e-3, kg.Material(3.5e9, 0.34, density=1400.0), stiffness=rung)
    arms = m.positions() - [0.05, 0.03, 0]
    velocity = np.cross([3.0, 5.0, 20.0], arms) + [1.0, 2.0, 3.0]
    velocity[:, 2] += 0.2 * np.sin(40 * arms[:, 0])
    run = kg.Dynamics(m, end=0.02, step=1e-3, velocity=velocity, tol=1e-12).run()
    system = kg.System(m)
    inertia = Inertia(system)
    linear, angular = [], []
    for step in run.steps:
        x = system.rest + system.joined(step.u, step.inner)
        momentum = inertia.momentum(system.joined(step.velocity, step.inner_velocity))
        linear.append(momentum[: system.points].sum(axis=0))
        angular.append(np.cross(x, momentum).sum(axis=0))
    for momenta in (np.array(linear), np.array(angular)):
        assert np.abs(momenta - momenta[0]).max() <= 1e-10 * np.linalg.norm(momenta[0])
    moved = np.linalg.norm(run.u[-1], axis=1)
    assert moved.min() > 0.03  # it has gone its way


def test_the_time_steps_are_of_second_order() -> None:
    """A swinging pendulum of one stiff bar against itself at finer steps."""
    def angle(step: float) -> float:
        m = kg.Model(dim=2)
        a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
        m.add(kg.Bar(a, b, 50.0), kg.Fix(a), kg.Mass(b, 1.0), kg.NodalLoad(b, (0, -1)))
        return float(kg.Dynamics(m, end=2.0, step=step, tol=1e-12).run().u[-1, 1, 1])

    coarse, middle, fine = (angle(0.04 / 2**k) for k in range(3))
    assert (coarse - middle) / (middle - fine) == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("damping", [1.0, (0.0, 0.01), (0.4, 0.006)])
def test_damping_decays_as_it_should(damping: Any) -> None:
    """Mass / (2 w) + stiffness w / 2 of critical damping, here 0.05 at w = 10: exp(-zeta w t) sin(w_d t)."""
    w, zeta = 10.0, 0.05
    wd = w * np.sqrt(1 - zeta**2)
    run = kg.Dynamics(
        spring(), end=1.0, step=2e-3, damping=damping, load=0.0, velocity=[[0, 0], [1e-6, 0]], tol=1e-12, every=10
    ).run()
    exact = 1e-6 / wd * np.exp(-zeta * w * run.time) * np.sin(wd * run.time)
    assert np.abs(run.u[:, 1, 0] - exact).max() < 5e-4 * np.abs(exact).max()


def test_the_damped_scheme_damps_what_is_fast_by_its_spectral_radius() -> None:
    """0.8 a step where w h = 1e4; (a - 1/2) w h of critical damping where the motion is slow, a = 1 / 1.8."""
    fast = kg.Dynamics(
        spring(k=1e10), end=30.0, step=0.1, scheme="damped", load=0.0, velocity=[[0, 0], [1e-8, 0]], tol=1e-13
    ).run()
    energy = sum(fast.energy.values())
    assert np.sqrt(energy[-1] / energy[-11]) ** 0.1 == pytest.approx(0.8, rel=0.02)
    slow = kg.Dynamics(
        spring(), end=2.0, step=0.01, scheme="damped", load=0.0, velocity=[[0, 0], [1e-6, 0]], tol=1e-12
    ).run()
    energy = sum(slow.energy.values())
    assert -np.log(energy[-1] / energy[0]) / (2 * 10.0 * 2.0) == pytest.approx((1 / 1.8 - 0.5) * 0.1, rel=0.01)


def test_a_shaken_support_also_moves_the_mass_it_carries() -> None:
    """A bar of consistent mass M: (M / 3) x'' + (M / 6) b'' + k (x - b) = 0, with b = A (1 - cos(p t)) from rest."""
    M, k, A, p = 3.0, 100.0, 1e-6, 6.0
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, k, mass_per_length=M), kg.Prescribe(a, x=A, y=0), kg.Fix(b, "y"))
    w2 = k / (M / 3)
    w = np.sqrt(w2)
    # x = A + C cos(p t) + E cos(w t): the support's acceleration A p^2 cos(p t) acts by M / 6
    C = -A * (w2 + 0.5 * p**2) / (w2 - p**2)
    for load in (lambda t: 1 - np.cos(p * t), [(t, 1 - np.cos(p * t)) for t in np.linspace(0, 1, 251)]):
        run = kg.Dynamics(m, end=1.0, step=4e-3, load=load, every=5, tol=1e-12).run()
        exact = A + C * np.cos(p * run.time) - (A + C) * np.cos(w * run.time)
        assert np.abs(run.u[:, 1, 0] - exact).max() < 2e-3 * np.abs(exact).max()
        assert run.u[:, 0, 0] == pytest.approx(A * (1 - np.cos(p * run.time)), abs=1e-6 * A)


def test_nodes_without_mass_follow_in_balance() -> None:
    """Two springs in a row with a massless node between them: it takes the middle; half the stiffness swings."""
    m = kg.Model(dim=2)
    a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    m.add(kg.Bar(a, b, 200.0), kg.Bar(b, c, 200.0), kg.Fix(a), kg.Fix([b, c], "y"), kg.Mass(c, 1.0))
    run = kg.Dynamics(m, end=1.0, step=2e-3, load=0.0, velocity=[[0, 0], [0, 0], [1e-6, 0]], tol=1e-12).run()
    exact = 1e-7 * np.sin(10 * run.time)
    assert np.abs(run.u[:, 2, 0] - exact).max() < 1e-3 * 1e-7
    assert np.abs(run.u[:, 1, 0] - 0.5 * run.u[:, 2, 0]).max() < 1e-6 * 1e-7


def test_contact_bounces_elastically() -> None:
    """A mass flies into a wall and comes back as fast as it came."""
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, 1e4, mass_per_length=1.0), kg.Fix([a, b], "y"))
    m.add(kg.Contact([b], kg.Plane((1.05, 0), normal=(-1, 0))))
    run = kg.Dynamics(m, end=0.6, step=5e-4, velocity=[[0.2, 0], [0.2, 0]], every=5).run()
    total = sum(run.energy.values())
    assert np.abs(total - total[0]).max() < 5e-4 * total[0]  # the force has a corner where the touch begins
    mean = run.velocity[:, :, 0].mean(axis=1)
    assert mean[0] == pytest.approx(0.2) and mean[-1] < -0.15


def test_a_located_limit_point_is_left_to_either_side() -> None:
    m = truss()
    apex = m.nodes[1]
    path = kg.DisplacementControl(m, to=-0.3, control=(apex, "y")).run()
    (event,) = [event for event in path.events if event.kind == "limit point"]
    ends = {}
    for push in (0.01, -0.01):
        run = kg.Dynamics(m, end=40.0, step=0.4, start=event, push=push, damping=0.3).run()
        assert run.lam == pytest.approx(event.lam)
        ends[push] = run.u[:, 1, 1].min()
    down = np.sign(-event.mode[1, 1]) * 0.01
    assert ends[down] < -0.6 and event.u is not None and ends[-down] < 0


@pytest.mark.parametrize("scheme", ["conserving", "damped"])
def test_a_motion_that_was_interrupted_goes_on_bit_by_bit(scheme: str, tmp_path) -> None:
    m, start, *_ = arch(4, "plate")

    def motion(**how: Any) -> kg.Results:
        def load(t: float) -> float:
            return 2.5 * min(t / 1e-3, 1.0)

        return kg.Dynamics(m, end=3e-3, step=1e-4, start=start, load=load, scheme=scheme, every=2).run(**how)

    whole = motion()

    def stop(step: kg.Step) -> None:
        if step.time > 1.5e-3:
            raise KeyboardInterrupt

    with pytest.warns(kg.KirigamiWarning, match="interrupted after .* at time"):
        part = motion(recorders=[stop], checkpoint=tmp_path / "motion.npz")
    assert len(part) < len(whole)
    again = motion(checkpoint=tmp_path / "motion.npz")
    assert np.array_equal(again.u, whole.u) and np.array_equal(again.velocity, whole.velocity)
    assert np.array_equal(again.time, whole.time)
    back = kg.load(again.save(tmp_path / "all.npz"))
    assert np.array_equal(back.velocity, whole.velocity) and np.array_equal(back.time, whole.time)
    for kind, values in whole.energy.items():
        assert back.energy[kind] == pytest.approx(values, rel=1e-9, abs=1e-15)
    assert "kinetic energy" in back.summary() and "moments, time 0 to 0.003" in back.summary()
    on = kg.Dynamics(m, end=4e-3, step=1e-4, start=whole[-1], load=2.5).run()
    assert on.time[0] == whole.time[-1] and np.array_equal(on.velocity[0], whole.velocity[-1])


def test_what_cannot_move_as_asked_is_refused() -> None:
    m, start, *_ = arch(4, "plate")
    free = kg.Model(dim=2)
    a, b = free.add(kg.Node(0, 0), kg.Node(1, 0))
    free.add(kg.Bar(a, b, 1e4, mass_per_length=1.0))
    spin = {"velocity": [[0, -0.75], [0, 0.75]], "end": 1.0}  # 1.5 rad in a unit of time
    with pytest.raises(kg.ConvergenceError, match="time step of 1 was found after time 0") as caught:
        kg.Dynamics(free, step=1.0, adaptive=False, **spin).run()
    assert caught.value.results is not None and len(caught.value.results) == 1
    halved = kg.Dynamics(free, step=1.0, **spin).run()
    assert halved.stats["cutbacks"] > 0 and halved.time[-1] == 1.0
    other, *_ = arch(6, "plate")
    with pytest.raises(kg.ModelError, match="another model"):
        kg.Dynamics(other, end=1.0, step=0.1, start=start).run()
    bare = kg.Model.from_mesh(strip(2), 1e-3, kg.Material(1e9))
    with pytest.raises(kg.ModelError, match="density"):
        kg.Dynamics(bare, end=1.0, step=0.1).run()
    driven = spring()
    driven.remove(driven.constraints[0])
    driven.add(kg.Prescribe(driven.nodes[0], x=0.1, y=0))
    with pytest.raises(kg.ModelError, match="would have to jump"):
        kg.Dynamics(driven, end=1.0, step=0.1).run()
    with pytest.raises(kg.ModelError, match="supports"):
        kg.Dynamics(spring(), end=1.0, step=0.1, velocity=[[1, 0], [0, 0]]).run()
    loose = kg.Model(dim=2)
    a, b, c = loose.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    loose.add(kg.Bar(a, b, 1.0), kg.Bar(b, c, 1.0), kg.Fix(a), kg.Mass(c, 1.0))
    with pytest.raises(kg.MechanismError, match="neither mass nor stiffness"):
        kg.Dynamics(loose, end=1.0, step=0.1).run()
    for wrong in ({"end": -1.0}, {"damping": (1.0, 2.0, 3.0)}, {"load": [(0, 1), (0, 2)]}, {"scheme": "explicit"}):
        with pytest.raises(kg.ModelError):
            kg.Dynamics(**{"model": spring(), "end": 1.0, "step": 0.1, **wrong})


def test_a_start_of_another_model_is_refused_and_one_of_a_copy_is_not() -> None:
    def pushed(thickness: float) -> kg.Model:
        m = kg.Model.from_mesh(strip(4), thickness, kg.Material(3.5e9, 0.34, density=1400.0))
        m.perturb(5e-4 * np.sin(np.pi * m.mesh.nodes[:, 0] / 0.1) ** 2)
        m.add(kg.Fix(m.select(boundary="left"), clamp=True))
        m.add(kg.Prescribe(m.select(boundary="right"), x=-1e-3, y=0, z=0, clamp=True))
        return m

    m, copy, thicker = pushed(5e-4), pushed(5e-4), pushed(1e-3)
    rest = kg.DisplacementControl(m).run()[-1]
    velocity = np.zeros((len(m.nodes), 3))
    velocity[np.isclose(m.positions()[:, 0], 0.05), 2] = 0.1
    moving = kg.Dynamics(m, end=2e-4, step=1e-4, start=rest, velocity=velocity).run()[-1]
    for step in (rest, moving):
        assert len(kg.Dynamics(copy, end=4e-4, step=1e-4, start=step).run()) > 1
        with pytest.raises(kg.ModelError, match="of another model, of which this one is no copy"):
            kg.Dynamics(thicker, end=4e-4, step=1e-4, start=step).run()
    taken_over = kg.Step.at(thicker, 1.0, rest.u)
    assert kg.Dynamics(thicker, end=1e-4, step=1e-4, start=taken_over).run().energy["kinetic"][-1] > 0


def test_ties_carry_masses_and_turned_nodes_move_along_arcs() -> None:
    """Two tied masses swing as one; nodes that a support turns have the velocity of their arc, and its energy."""
    m = spring(k=100.0, mass=0.25)
    other = m.add(kg.Node(1, 1))
    m.add(kg.Mass(other, 0.75), kg.Tie(other, m.nodes[1], "xy"))
    velocity = [[0, 0], [1e-6, 0], [1e-6, 0]]
    run = kg.Dynamics(m, end=0.5, step=2e-3, load=0.0, velocity=velocity, tol=1e-12).run()
    assert np.abs(run.u[:, 2, 0] - 1e-7 * np.sin(10 * run.time)).max() < 1e-3 * 1e-7
    turned = spring()
    ends = turned.add(kg.Node(4, 0), kg.Node(6, 0))
    turned.add(kg.Bar(*ends, 1.0), kg.Mass(ends, 1.0), kg.Turn(ends, angle=90.0, axis="z"))
    run = kg.Dynamics(turned, end=1.0, step=0.05, load=lambda t: t).run()
    speed = np.pi / 2
    assert run.energy["kinetic"][1:] == pytest.approx(speed**2, rel=1e-5)
    assert np.linalg.norm(run.velocity[1:, 2:], axis=2) == pytest.approx(speed, rel=1e-5)
    assert run.position(3)[-1] == pytest.approx([5.0, 1.0, 0.0], abs=1e-9)


def test_time_goes_into_tables_and_films(tmp_path) -> None:
    """A column of times, the kinetic energy beside the stored one, and frames that are evenly spaced in time."""
    run = kg.Dynamics(spring(), end=0.4, step=0.1, load=0.0, velocity=[[0, 0], [0.1, 0]]).run()
    lines = run.to_csv(tmp_path / "motion.csv").read_text().splitlines()
    names = lines[0].split(",")
    table = np.array([[float(cell or "nan") for cell in line.split(",")] for line in lines[1:]])
    assert table[:, names.index("time")] == pytest.approx([0, 0.1, 0.2, 0.3, 0.4])
    assert table[:, names.index("energy_kinetic")] == pytest.approx(run.energy["kinetic"])
    assert run.energy_shares()["kinetic"][0] == 1.0
    seen: list[int] = []
    run.animate(tmp_path / "motion.gif", frames=3, dpi=30, on_frame=seen.append)
    assert seen == [1, 2, 3]
    ax = run.plot_curve(nodes=[0], axis="x", x="time")
    assert ax.get_xlabel() == "time"
    pytest.importorskip("plotly")
    assert '"time": [0.0, ' in run.to_html(tmp_path / "motion.html").read_text(encoding="utf-8")
