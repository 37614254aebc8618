"""Paths through limit points, snap-backs and bifurcations, and the branches that leave them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import kirigami as kg

ARCS = ["cylindrical", "spherical"]


# ------------------------------------------------------------------------------------------ snap-back, closed form


def truss_and_spring(stiffness: float) -> tuple[kg.Model, kg.Node, kg.Node]:
    """A von Mises truss (a = h = 1, EA = 1) pushed through a long soft spring."""
    m = kg.Model(dim=2)
    left, apex, right, grip = m.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0), kg.Node(0, 61))
    m.add(kg.Bar(left, apex, 1.0), kg.Bar(apex, right, 1.0), kg.Bar(apex, grip, 60 * stiffness, strain="engineering"))
    m.add(kg.Fix([left, right]), kg.Fix([apex, grip], "x"))
    return m, apex, grip


@pytest.mark.parametrize("arc", ARCS)
@pytest.mark.parametrize("stiffness", [0.05, 0.005])
def test_snap_back_of_a_truss_behind_a_spring(arc: str, stiffness: float) -> None:
    """P(w) = z (1 - z^2) / sqrt(2)^3 with z = 1 - w, while the grip goes w + P / k: forth, back and forth again."""
    m, apex, grip = truss_and_spring(stiffness)
    m.add(kg.NodalLoad(grip, (0, -1)))
    res = kg.ArcLength(m, step=0.01, arc=arc, stop=lambda step: step.u[1, 1] < -2.2).run()
    deflection = -res.u[:, 1, 1]
    height = 1 - deflection
    load = height * (1 - height**2) / 2**1.5
    assert np.all(np.diff(deflection) > 0)  # no doubling back
    assert res.lam == pytest.approx(load, abs=1e-7)
    grip_way = -res.u[:, 3, 1]
    assert grip_way == pytest.approx(deflection + load / stiffness, abs=1e-6 / stiffness)
    assert np.diff(grip_way).min() < -0.5  # it does turn back
    limit = 1 / (3 * np.sqrt(3) * np.sqrt(2))
    assert [event.kind for event in res.events] == ["limit point", "limit point"]
    assert [event.lam for event in res.events] == pytest.approx([limit, -limit], rel=1e-6)
    for event in res.events:
        assert event.mode is not None and event.mode.shape == (4, 3) and np.abs(event.mode).max() == 1
    assert np.array_equal(res.stable, (deflection < 1 - 1 / np.sqrt(3)) | (deflection > 1 + 1 / np.sqrt(3)))


@pytest.mark.parametrize("arc", ARCS)
def test_snap_back_in_the_prescribed_displacement(arc: str) -> None:
    """The same, driven by the grip: now the load factor is the grip's way, and it has the two limit points."""
    stiffness = 0.05
    m, apex, grip = truss_and_spring(stiffness)
    m.add(kg.Prescribe(grip, y=-1.0))
    res = kg.ArcLength(m, step=0.05, arc=arc, stop=lambda step: step.u[1, 1] < -2.2).run()
    height = 1 + res.u[:, 1, 1]
    load = height * (1 - height**2) / 2**1.5
    assert -res.reaction(grip, "y") == pytest.approx(load, abs=1e-7)
    assert res.lam == pytest.approx(1 - height + load / stiffness, abs=1e-5)
    # d(w + P / k) / dw = 0 at 1 - 3 z^2 = 2^1.5 k
    turn = np.sqrt((1 - 2**1.5 * stiffness) / 3)
    way = [1 - z + z * (1 - z**2) / 2**1.5 / stiffness for z in (turn, -turn)]
    assert [event.lam for event in res.events if event.kind == "limit point"] == pytest.approx(way, rel=1e-6)


@pytest.mark.parametrize("arc", ARCS)
def test_lee_frame(arc: str) -> None:
    """Two legs of length 120, EI = 1440, EA = 4320, pinned ends, loaded a fifth along the beam; as a Hencky chain.

    The frame snaps back in load and in displacement; its first limit load is 1.855 (Schweizerhof and Wriggers, Comput.
    Methods Appl. Mech. Eng. 59 (1986), after Lee, Manuel and Rossow 1968). The chain converges with the square of the
    link length, so two chains are extrapolated.
    """
    limits = []
    for links in (10, 20):
        length = 120.0 / links
        m = kg.Model(dim=2)
        places = [(0, length * k) for k in range(links + 1)] + [(length * k, 120.0) for k in range(1, links + 1)]
        nodes = m.add(*(kg.Node(*place) for place in places))
        m.add(*(kg.Bar(a, b, 4320.0) for a, b in pairwise(nodes)))
        m.add(*(kg.TorsionSpring3(a, b, c, 1440.0 / length) for a, b, c in zip(nodes, nodes[1:], nodes[2:])))
        m.add(kg.Fix([nodes[0], nodes[-1]]), kg.NodalLoad(nodes[links + links // 5], (0, -1)))
        res = kg.ArcLength(m, step=1.0, arc=arc, max_steps=60, stop=lambda step: step.lam > 4).run()
        assert [event.kind for event in res.events] == ["limit point", "limit point"]
        assert res.lam[-1] > 4 and np.diff(res.lam).min() < 0
        across = res.u[:, links + links // 5, 0]
        turned = np.diff(across)[res.lam[1:] < 4]
        assert turned.max() > 0 > turned.min()  # the loaded node comes back
        limits.append([event.lam for event in res.events])
    coarse, fine = np.array(limits)
    assert (4 * fine - coarse) / 3 == pytest.approx([1.855, -0.941], rel=2e-3)


def test_arc_length_backwards_and_bad_arguments() -> None:
    m, apex, grip = truss_and_spring(0.05)
    m.add(kg.NodalLoad(grip, (0, -1)))
    back = kg.ArcLength(m, step=-0.01, max_steps=5).run()
    assert np.all(np.diff(back.lam) < 0)
    with pytest.raises(kg.ModelError, match="arc must be"):
        kg.ArcLength(m, step=0.1, arc="conical")
    with pytest.raises(kg.ModelError, match="branch"):
        kg.ArcLength(m, step=0.1, branch=1)
    with pytest.raises(kg.ModelError, match="not located"):
        kg.ArcLength(m, step=0.1, start=back.events[-1])


# -------------------------------------------------------------------------------------- bifurcation, closed form


def column(offset: float = 0.0) -> tuple[kg.Model, kg.Node, kg.Node]:
    """Two stiff links of length 1, a spring k = 1 between them: P = 2 phi / sin(phi) on the bent branches."""
    m = kg.Model(dim=2)
    bottom, middle, top = m.add(kg.Node(0, 0), kg.Node(offset, 1), kg.Node(0, 2))
    m.add(kg.Bar(bottom, middle, 1e4), kg.Bar(middle, top, 1e4), kg.TorsionSpring3(bottom, middle, top, 1.0))
    m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.NodalLoad(top, (0, -1)))
    return m, middle, top


def bent_force(results: kg.Results) -> np.ndarray:
    angle = np.arcsin(np.abs(results.u[:, 1, 0]))
    return 2 / np.sinc(angle / np.pi)


def followed() -> tuple[kg.Model, kg.Results]:
    m, _, _ = column()
    return m, kg.LoadControl(m, to=3.0, on_instability="follow").run()


def test_the_bifurcation_is_located_with_its_mode() -> None:
    _, res = followed()
    (event,) = res.events
    # Exact for the elastic links: P l = 2 k with the length l at this load, 2e-4 shorter in all.
    assert event.kind == "bifurcation" and event.lam == pytest.approx(2.0004, abs=3e-4)
    assert event.mode == pytest.approx(np.array([[0, 0, 0], [1, 0, 0], [0, 0, 0]]), abs=1e-9)
    assert event.bracket[0] < event.lam < event.bracket[1]
    assert event.located is not None and event.located.residual < 1e-8
    assert [step.negative for step in res.steps] == [int(lam > event.lam) for lam in res.lam]


@pytest.mark.parametrize("branch", [1, -1])
@pytest.mark.parametrize("method", ["arc", "load", "displacement"])
def test_both_branches(branch: int, method: str) -> None:
    m, straight = followed()
    event = straight.events[0]
    if method == "arc":
        res = kg.ArcLength(
            m, step=0.1, start=event, branch=branch, stop=lambda step: abs(step.u[1, 0]) > 0.7
        ).run()
    elif method == "load":
        res = kg.LoadControl(m, to=2.4, start=event, branch=branch).run()
    else:
        control = (m.nodes[1], "x")
        res = kg.DisplacementControl(m, to=0.7 * branch, control=control, start=event, branch=branch).run()
    assert res[0].lam == event.lam and np.sign(res.u[1:, 1, 0]).tolist() == [branch] * (len(res) - 1)
    assert abs(res.u[-1, 1, 0]) > 0.69 and res.stable[1:].all()
    assert res.lam[1:] == pytest.approx(bent_force(res)[1:], rel=5e-4)


@pytest.mark.parametrize("arc", ARCS)
def test_switch_goes_over_to_the_branch(arc: str) -> None:
    m, middle, top = column()
    res = kg.ArcLength(
        m, step=0.1, arc=arc, on_instability="switch", stop=lambda step: step.u[1, 0] > 0.7
    ).run()
    assert [event.kind for event in res.events] == ["bifurcation", "switch"]
    assert res.stable.all()
    bent = res.u[:, 1, 0] > 1e-3
    assert res.lam[bent] == pytest.approx(bent_force(res)[bent], rel=5e-4)
    squeezed = kg.DisplacementControl(m, to=-0.5, control=(top, "y"), on_instability="switch").run()
    assert squeezed.u[-1, 1, 0] == pytest.approx(np.sqrt(1 - 0.75**2), rel=1e-3)


@pytest.mark.parametrize("imperfection", [1e-2, 1e-4, 1e-6])
def test_arc_length_turns_the_corner_of_a_slightly_bent_column(imperfection: float) -> None:
    """P = 2 (phi - phi0) / sin(phi): a sharp corner between two directions, taken without jumping or turning back."""
    m, _, _ = column(imperfection)
    res = kg.ArcLength(m, step=0.2, stop=lambda step: step.u[1, 0] > 0.7).run()
    angle = np.arcsin(res.u[:, 1, 0] + imperfection)
    exact = 2 * (angle - angle[0]) / np.sin(angle)
    assert res.lam == pytest.approx(exact, abs=2e-3) and res.stable.all() and not res.events
    assert np.all(np.diff(res.u[:, 1, 0]) > 0)


def test_stop_at_the_first_unstable_step() -> None:
    m, _, _ = column()
    res = kg.ArcLength(m, step=0.1, on_instability="stop").run()
    assert res.stable[:-1].all() and not res.stable[-1] and res.events[0].kind == "bifurcation"


def test_events_and_their_modes_are_saved(tmp_path) -> None:
    _, res = followed()
    again = kg.load(res.save(tmp_path / "column.npz")).events[0]
    event = res.events[0]
    assert str(again) == str(event) and np.array_equal(again.mode, event.mode)
    assert again.located is not None and event.located is not None
    assert np.array_equal(again.u, event.u) and again.located.negative == event.located.negative


# --------------------------------------------------------------------------------------------------- a flat sheet


def squeezed_plate(imperfection: float = 0.0) -> tuple[kg.Model, list[kg.Node]]:
    """A square plate on simple supports, squeezed to three times its buckling displacement."""
    x, y = np.meshgrid(np.linspace(0, 1, 6), np.linspace(0, 1, 6))
    squares = [6 * row + column for row in range(5) for column in range(5)]
    triangles = [t for a in squares for t in ((a, a + 1, a + 7), (a, a + 7, a + 6))]
    mesh = kg.TriMesh(np.column_stack([x.ravel(), y.ravel()]), triangles)
    m = kg.Model.from_mesh(mesh, thickness=0.005, material=kg.Material(E=1e6, nu=1 / 3))
    if imperfection:
        m.perturb(imperfection * np.sin(np.pi * x.ravel()) * np.sin(np.pi * y.ravel()))
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="outer"), "z"), kg.Fix(m.select(boundary="bottom"), "xy"), kg.Fix(top, "x"))
    m.add(kg.Prescribe(top, y=-3e-4))
    return m, top


def test_the_branch_of_a_plate_is_the_limit_of_small_imperfections() -> None:
    m, top = squeezed_plate()
    event = kg.DisplacementControl(m, on_instability="stop").run().events[0]
    sides = [kg.DisplacementControl(m, start=event, branch=sign).run() for sign in (1, -1)]
    assert np.array_equal(sides[0].stable, sides[1].stable) and sides[0].stable[-1]
    np.testing.assert_allclose(sides[0].u[-1, :, 2], -sides[1].u[-1, :, 2], atol=1e-8)
    bent, other = squeezed_plate(1e-6)
    reference = kg.DisplacementControl(bent).run()
    force = sides[0].reaction(top, "y")[-1]
    assert force == pytest.approx(reference.reaction(other, "y")[-1], rel=1e-4)
    assert np.abs(sides[0].u[-1, :, 2]).max() > 0.005


def test_arc_length_takes_a_plate_over_to_its_branch() -> None:
    m, top = squeezed_plate()
    arc = kg.ArcLength(m, step=0.1, on_instability="switch", stop=lambda step: step.lam > 0.95).run()
    assert [event.kind for event in arc.events][:2] == ["bifurcation", "switch"] and arc.stable[-1]
    driven = kg.DisplacementControl(m, to=float(arc.lam[-1])).run()
    assert arc.reaction(top, "y")[-1] == pytest.approx(driven.reaction(top, "y")[-1], rel=1e-6)
    assert np.abs(arc.u[-1, :, 2]).max() == pytest.approx(np.abs(driven.u[-1, :, 2]).max(), rel=1e-5)


# ------------------------------------------------------------------------------------------- there and back, collapse


@pytest.mark.parametrize("method", [kg.LoadControl, kg.DisplacementControl])
def test_targets_are_met_in_the_order_given(method: type) -> None:
    """A truss that does not reach its limit load is pushed, let go, and pulled: P(w) holds on every leg."""
    m, apex, grip = truss_and_spring(0.05)
    if method is kg.LoadControl:
        m.add(kg.NodalLoad(grip, (0, -0.1)))
    else:
        m.add(kg.Prescribe(grip, y=-1.0))
    seen: list[float] = []
    res = method(m, to=0.0, targets=[1.0, 0.2, 0.6, -0.5]).run(recorders=[lambda step: seen.append(step.lam)])
    stations = [0.0, 1.0, 0.2, 0.6, -0.5, 0.0]
    turns = [0, *(np.flatnonzero(np.diff(np.sign(np.diff(res.lam)))) + 1).tolist(), len(res) - 1]
    assert res.lam[turns].tolist() == stations and res.lam[0] == 0 == res.lam[-1]
    height = 1 + res.u[:, 1, 1]
    load = height * (1 - height**2) / 2**1.5
    applied = 0.1 * res.lam if method is kg.LoadControl else -res.reaction(grip, "y")
    assert applied == pytest.approx(load, abs=1e-7)
    np.testing.assert_allclose(res.u[-1], 0, atol=1e-8)


@pytest.mark.parametrize(("strain", "law"), [("engineering", "linear"), ("green", "ogden"), ("green", "linear")])
def test_no_step_holds_a_force_that_is_not_finite(strain: str, law: str) -> None:
    """A bar driven to zero length has no unknown whose residual could tell; only the Green strain stays finite."""
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, 1.0, strain=strain, law=law), kg.Fix(a), kg.Fix(b, "y"), kg.Prescribe(b, x=-1.0))
    if (strain, law) == ("green", "linear"):
        res = kg.DisplacementControl(m).run()  # the force is EA e (1 + 2 e)^(1/2) L/L0 and vanishes with the length
        assert res.lam[-1] == 1.0 and np.isfinite(res.reaction(b, "x")).all()
        return
    with pytest.raises(kg.ConvergenceError, match="a member collapsed") as caught:
        kg.DisplacementControl(m).run()
    assert caught.value.results is not None and 0.5 < caught.value.results.lam[-1] < 1
    assert np.isfinite(caught.value.results.reaction(b, "x")).all()
    assert caught.value.worst_nodes == [0, 1]
