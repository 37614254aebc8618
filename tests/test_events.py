"""What is met on a path is told, once: limit loads, snaps with their energy, bifurcations; against closed forms."""

from __future__ import annotations

from itertools import pairwise
from unittest import mock

import numpy as np
import pytest

import kirigami as kg
from kirigami.analysis.path import stable
from kirigami.analysis.path.descent import CORRECTORS
from kirigami.analysis.path.points import Attempt, Point, State
from kirigami.analysis.path.release import force_slope

RISE = 0.3
LENGTH = np.hypot(1.0, RISE)


def force(height: np.ndarray | float) -> np.ndarray | float:
    """Load of a von Mises truss of half-span 1 and EA = 1 with its apex at `height`: z (h^2 - z^2) / L^3."""
    return height * (RISE**2 - height**2) / LENGTH**3


def energy(height: float) -> float:
    """Its energy: the integral of the force over the deflection."""
    return (RISE**2 - height**2) ** 2 / (4 * LENGTH**3)


LIMIT = float(force(RISE / np.sqrt(3)))  # limit load; at the same load the other equilibrium lies at z = -2 h / sqrt(3)


def loaded_truss(neighbour: float = 0.0) -> kg.Model:
    """The truss under 1.5 times its limit load, beside a bar that stores about `neighbour` times 0.25 of energy."""
    m = kg.Model(dim=2)
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, RISE), kg.Node(1, 0))
    m.add(kg.Bar(left, apex, 1.0), kg.Bar(apex, right, 1.0), kg.Fix([left, right]), kg.Fix(apex, "x"))
    m.add(kg.NodalLoad(apex, (0, -1.5 * LIMIT)))
    if neighbour:
        held, pulled = m.add(kg.Node(3, 0), kg.Node(4, 0))
        m.add(kg.Bar(held, pulled, neighbour), kg.Fix(held), kg.Fix(pulled, "y"))
        m.add(kg.NodalLoad(pulled, (neighbour, 0)))
    return m


@pytest.mark.parametrize("corrector", CORRECTORS)
@pytest.mark.parametrize("neighbour", [0.0, 30.0])
def test_a_limit_load_is_not_passed_in_silence(corrector: str, neighbour: float) -> None:
    """One event about the limit load, however little of the stored energy the snap sets free."""
    res = kg.LoadControl(loaded_truss(neighbour), on_instability="switch", corrector=corrector).run()
    assert res.lam[-1] == 1.0 and res.stable.all()
    (event,) = res.events
    slack = 1e-4  # equilibrium to 1e-8 of all forces
    assert event.bracket[0] - slack < 1 / 1.5 < event.bracket[1] + slack
    if neighbour == 0:
        assert event.kind == "snap" and event.energy is not None and "force times length" in event.message
    if corrector == "path":
        assert event.bracket[1] - event.bracket[0] < 2e-3
        high, low = RISE / np.sqrt(3), -2 * RISE / np.sqrt(3)
        released = energy(high) - energy(low) + LIMIT * (high - low)
        assert event.kind == "snap" and event.energy == pytest.approx(released, rel=2e-2)


def test_following_a_load_ends_at_the_limit_load() -> None:
    """There is no equilibrium ahead, so the far one is not taken for one."""
    with pytest.raises(kg.ConvergenceError, match="no equilibrium found") as caught:
        kg.LoadControl(loaded_truss(), step=0.1).run()
    assert caught.value.results is not None
    assert caught.value.results.lam[-1] == pytest.approx(1 / 1.5, rel=1e-4)


def driven_truss(stiffness: float, way: float) -> kg.Model:
    """The truss pushed by `way` through a spring that is long enough never to turn over."""
    m = kg.Model(dim=2)
    left, apex, right, grip = m.add(kg.Node(-1, 0), kg.Node(0, RISE), kg.Node(1, 0), kg.Node(0, 20 + RISE))
    m.add(kg.Bar(left, apex, 1.0), kg.Bar(apex, right, 1.0), kg.Bar(apex, grip, 20 * stiffness, strain="engineering"))
    m.add(kg.Fix([left, right]), kg.Fix([apex, grip], "x"), kg.Prescribe(grip, y=-way))
    return m


@pytest.mark.parametrize("corrector", ["path", "slow"])
@pytest.mark.parametrize("stiffness", [0.02, 0.03])
def test_snaps_there_and_back(corrector: str, stiffness: float) -> None:
    """Pushed and let go: d(w + P / k) / dw = 0 at z = +-sqrt((h^2 - k L^3) / 3), the snap back at another place."""
    turn = np.sqrt((RISE**2 - stiffness * LENGTH**3) / 3)
    forth, back = (RISE - z + float(force(z)) / stiffness for z in (turn, -turn))
    way = 1.3 * forth
    analysis = kg.DisplacementControl(driven_truss(stiffness, way), targets=[1.0], to=0.0, corrector=corrector)
    res = analysis.run()
    assert res.stable.all() and res.lam[-1] == 0
    assert [event.kind for event in res.events] == ["snap", "snap"]
    for event, place in zip(res.events, (forth, back)):
        low, high = sorted(event.bracket)
        assert low * way <= place <= high * way
        assert event.energy is not None and event.energy > 0
        if corrector == "path":
            assert high - low <= 0.05 * 1.001 * max(high, 1 - low)
    assert res.u[-1] == pytest.approx(np.zeros((4, 3)), abs=1e-7)


def trusses_beside_a_bar(stiffnesses: list[float], beside: float) -> kg.Model:
    """Trusses pushed through springs of their own, all by 0.7, and a bar of that stiffness pulled as far."""
    m = kg.Model(dim=2)
    for number, stiffness in enumerate(stiffnesses):
        x = 4 * number
        left, apex, right, grip = m.add(
            kg.Node(x - 1, 0), kg.Node(x, RISE), kg.Node(x + 1, 0), kg.Node(x, 20 + RISE)
        )
        m.add(kg.Bar(left, apex, 1.0), kg.Bar(apex, right, 1.0))
        m.add(kg.Bar(apex, grip, 20 * stiffness, strain="engineering"))
        m.add(kg.Fix([left, right]), kg.Fix([apex, grip], "x"), kg.Prescribe(grip, y=-0.7))
    top, pulled = m.add(kg.Node(-5, 20), kg.Node(-5, 0))
    m.add(kg.Bar(top, pulled, 20 * beside, strain="engineering"), kg.Fix(top), kg.Fix(pulled, "x"))
    m.add(kg.Prescribe(pulled, y=-0.7))
    return m


def set_free_behind(stiffness: float) -> tuple[float, float]:
    """Displacement at which a truss behind a spring snaps, and the energy it sets free, in closed form.

    There P' = -k at z, and the other equilibrium lies at -2 z, as the roots of a cubic without a square add to zero.
    """
    height = np.sqrt((RISE**2 - stiffness * LENGTH**3) / 3)
    place = RISE - height + float(force(height)) / stiffness
    before, after = (energy(z) + 0.5 * stiffness * (place - RISE + z) ** 2 for z in (height, -2 * height))
    return place, before - after


@pytest.mark.parametrize("share", [1.0, 0.1])
@pytest.mark.parametrize(
    ("stiffnesses", "beside"), [([0.02], 0.1), ([0.02], 1.0), ([0.02, 0.03], 3.0), ([0.02, 0.03], 0.2)]
)
def test_a_snap_is_told_by_itself_where_it_is_notable(stiffnesses: list[float], beside: float, share: float) -> None:
    """From a hundredth of force times displacement on; smaller ones together. Ten times shorter increments agree.

    The energy is known as well as the snap is bracketed: to a twentieth of the way, or a tenth of that.
    """
    with mock.patch.multiple(stable, SHARE=share * stable.SHARE, CLOSE=share * stable.CLOSE):
        res = kg.DisplacementControl(trusses_beside_a_bar(stiffnesses, beside)).run()
    expected: list[tuple[str, float, float, float]] = []
    for place, free in sorted(set_free_behind(stiffness) for stiffness in stiffnesses):
        notable = free > 0.01 * (beside + sum(stiffnesses)) * place**2
        if not notable and expected and expected[-1][0] == "small snaps":
            _, first, _, before = expected.pop()
            expected.append(("small snaps", first, place, before + free))
        else:
            expected.append(("snap" if notable else "small snaps", place, place, free))
    assert [event.kind for event in res.events] == [kind for kind, *_ in expected]
    for event, (_, first, last, free) in zip(res.events, expected):
        assert event.bracket[0] * 0.7 <= first <= last <= event.bracket[1] * 0.7
        assert event.energy == pytest.approx(free, rel=0.05 * share)
    assert len(res.events) == 1 + (beside == 0.2)


@pytest.mark.parametrize("arc", ["cylindrical", "spherical"])
@pytest.mark.parametrize("step", [1e-3, 5e-4, 2e-4, 2e-5])
def test_an_arc_does_not_jump_over_limit_points(arc: str, step: float) -> None:
    """A first step of a ninth of the limit load, behind a soft spring of length 1 that could turn over instead."""
    m = kg.Model(dim=2)
    left, apex, right, top = m.add(kg.Node(-1, 0), kg.Node(0, RISE), kg.Node(1, 0), kg.Node(0, 1 + RISE))
    m.add(kg.Bar(left, apex, 1.0), kg.Bar(apex, right, 1.0), kg.Bar(apex, top, 0.01, strain="engineering"))
    m.add(kg.Fix([left, right]), kg.Fix([apex, top], "x"), kg.NodalLoad(top, (0, -1)))
    res = kg.ArcLength(m, step=step, arc=arc, stop=lambda s: s.u[3, 1] < -1.6, max_steps=2000).run()
    assert [event.kind for event in res.events] == ["limit point", "limit point"]
    assert [event.lam for event in res.events] == pytest.approx([LIMIT, -LIMIT], rel=1e-6)
    assert res.lam == pytest.approx(force(RISE + res.u[:, 1, 1]), abs=1e-8)


@pytest.mark.parametrize("depth", [0.01, 0.05])
def test_the_slope_of_the_force_of_the_drive(depth: float) -> None:
    """Along w + P / k a spring behind a truss gives dF / dw = 1 / (1 / k + 1 / P'), in closed form."""
    stiffness, way = 0.05, depth
    analysis = kg.DisplacementControl(driven_truss(stiffness, way))
    res = analysis.run()
    walk = analysis._make_walk([])
    u, lam = res.u[-1, :, :2], float(res.lam[-1])
    state = State(walk.system.unknowns(u), lam, u)
    tangent = walk.tangent_at(Attempt(state, True, 0.0, 0))
    slope = force_slope(walk.system, Point(state, tangent, None), 0.1)
    height = RISE + u[1, 1]
    of_truss = -(RISE**2 - 3 * height**2) / LENGTH**3  # dP / dw, where the apex comes down by w
    assert slope / way**2 == pytest.approx(1 / (1 / stiffness + 1 / of_truss), rel=1e-5)


def star_dome() -> kg.Model:
    """The star dome of 24 bars (Hangai and Kawamata 1973)."""
    m = kg.Model()
    turn = np.arange(6) * np.pi / 3
    apex = m.add(kg.Node(0, 0, 8.216))
    inner = m.add(*(kg.Node(25 * np.cos(t), 25 * np.sin(t), 6.216) for t in turn))
    outer = m.add(*(kg.Node(50 * np.cos(t), 50 * np.sin(t), 0) for t in turn + np.pi / 6))
    for k in range(6):
        m.add(kg.Bar(apex, inner[k], 1e3), kg.Bar(inner[k], inner[(k + 1) % 6], 1e3))
        m.add(kg.Bar(inner[k], outer[k], 1e3), kg.Bar(inner[k], outer[k - 1], 1e3))
    m.add(kg.Fix(outer), kg.NodalLoad(apex, (0, 0, -1)))
    return m


def test_each_singular_point_of_the_star_dome_is_told_once() -> None:
    """At a limit point one eigenvalue changes its sign; it is not told a second time as a bifurcation.

    The path is symmetric under turning the dome upside down, so both halves tell the same kinds at opposite loads.
    """
    res = kg.ArcLength(star_dome(), step=0.05, stop=lambda s: s.u[0, 2] < -20, max_steps=400).run()
    span = float(np.ptp(res.lam))
    for one, other in pairwise(res.events):
        assert abs(one.lam - other.lam) > 1e-6 * span or np.abs(one.u - other.u).max() > 1e-2
    kinds = [event.kind for event in res.events]
    assert kinds == kinds[::-1]
    loads = np.array([event.lam for event in res.events])
    assert loads == pytest.approx(-loads[::-1], abs=1e-4 * span)
    assert set(kinds) == {"limit point", "bifurcation"}


def column(offset: float) -> tuple[kg.Model, kg.Node]:
    """Two stiff links of length 1 with a spring k = 1 between them, squeezed by 0.2."""
    m = kg.Model(dim=2)
    bottom, middle, top = m.add(kg.Node(0, 0), kg.Node(offset, 1), kg.Node(0, 2))
    m.add(kg.Bar(bottom, middle, 1e4), kg.Bar(middle, top, 1e4), kg.TorsionSpring3(bottom, middle, top, 1.0))
    m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.Prescribe(top, y=-0.2))
    return m, top


@pytest.mark.parametrize("offset", [1e-2, 1e-4, 1e-6])
def test_an_imperfect_column_meets_nothing(offset: float) -> None:
    """Its path P = 2 (phi - phi0) / sin(phi) is smooth however sharp the corner, so there is no event to tell."""
    m, top = column(offset)
    res = kg.DisplacementControl(m).run()
    assert res.events == [] and res.stable.all()
    angle = np.arcsin(res.u[:, 1, 0] + offset)
    exact = 2 * (angle - angle[0]) / np.sin(angle)
    assert -res.reaction(top, "y") == pytest.approx(exact, abs=2e-3)


def test_a_perfect_column_meets_its_bifurcation_once() -> None:
    m, _ = column(0.0)
    res = kg.DisplacementControl(m).run()
    assert [event.kind for event in res.events] == ["bifurcation", "switch"]
    # P l = 2 k with links that P shortens by P / EA each, so the grip has come down by 2 P / EA = 4e-4.
    assert res.events[0].lam == pytest.approx(2 * 2.0 / 1e4 / 0.2, rel=1e-3)
    assert res.events[0].located is not None


def test_events_keep_their_energy_in_a_file(tmp_path) -> None:
    res = kg.LoadControl(loaded_truss(), on_instability="switch").run()
    again = kg.load(res.save(tmp_path / "snap.npz"))
    assert [event.energy for event in again.events] == [event.energy for event in res.events]
    assert again.events[0].energy is not None
