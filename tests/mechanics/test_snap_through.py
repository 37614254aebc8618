"""Limit points and unstable branches: the von Mises truss and the 24-bar star dome."""

from __future__ import annotations

import numpy as np
import pytest
from meshes import Floats
from scipy.optimize import brentq

import kirigami as kg

EA = 2.0

# a, h: apex deflection and load / EA at the first limit point, engineering and Green strain
LIMITS = {
    (1.0, 1.0): {"engineering": (0.49017547, 0.1874032752), "green": (0.42264973, 0.1360827635)},
    (1.0, 0.5): {"engineering": (0.22211991, 0.0383837398), "green": (0.21132487, 0.0344265186)},
    (1.0, 0.2): {"engineering": (0.08528556, 0.0029605176), "green": (0.08452995, 0.0029032744)},
    (1.0, 0.1): {"engineering": (0.04236075, 0.0003810872), "green": (0.04226497, 0.0003791980)},
}


def _load(a: float, h: float, strain: str, deflection: Floats) -> Floats:
    """Load of the symmetric von Mises truss at an apex deflection.

    Green 2 EA z (h^2 - z^2) / (2 L0^3), engineering 2 EA z (1 / L - 1 / L0), z = h - deflection.
    """
    z, rest = h - np.asarray(deflection), np.hypot(a, h)
    if strain == "green":
        return EA * z * (h**2 - z**2) / rest**3
    return 2 * EA * z * (1 / np.hypot(a, z) - 1 / rest)


def _truss(a: float, h: float, strain: str, dim: int = 2) -> tuple[kg.Model, kg.Node]:
    model = kg.Model(dim=dim)
    left, apex, right = model.add(kg.Node(-a, 0), kg.Node(0, h), kg.Node(a, 0))
    model.add(kg.Bar(left, apex, EA, strain=strain), kg.Bar(apex, right, EA, strain=strain), kg.Fix([left, right]))
    if dim == 3:
        model.add(kg.Fix(apex, "z"))
    return model, apex


CASES = [(a, h, strain) for (a, h), by_strain in LIMITS.items() for strain in by_strain]


@pytest.mark.parametrize("a, h, strain", CASES)
def test_limit_point_of_the_closed_form(a: float, h: float, strain: str) -> None:
    """The table itself: where the slope of the closed form vanishes, and the load there."""
    deflection, load = LIMITS[a, h][strain]
    if strain == "green":
        exact = h * (1 - 1 / np.sqrt(3))
    else:  # L^3 = a^2 L0
        exact = h - np.sqrt((a**2 * np.hypot(a, h)) ** (2 / 3) - a**2)
    assert exact == pytest.approx(deflection, abs=1e-8)
    assert _load(a, h, strain, exact) / EA == pytest.approx(load, abs=6e-11)


@pytest.mark.parametrize("a, h, strain", CASES)
@pytest.mark.parametrize("dim", [2, 3])
def test_apex_pushed_through(a: float, h: float, strain: str, dim: int) -> None:
    """A prescribed apex deflection traces the whole path, both limit points and the negative load between them."""
    model, apex = _truss(a, h, strain, dim)
    model.add(kg.Prescribe(apex, y=-2.4 * h))
    result = kg.DisplacementControl(model, to=1.0, step=0.05).run()
    deflection = -result.u[:, 1, 1]
    assert deflection == pytest.approx(2.4 * h * result.lam, abs=1e-12 * h)
    limit = LIMITS[a, h][strain][1] * EA
    assert -result.reaction(apex, "y") == pytest.approx(_load(a, h, strain, deflection), abs=1e-8 * limit)
    assert np.abs(result.u[:, 1, 0]).max() < 1e-10 * h
    supports = [node for node in model.nodes if node is not apex]
    assert result.reaction(supports, "y") == pytest.approx(-result.reaction(apex, "y"), abs=1e-8 * limit)


@pytest.mark.parametrize("a, h, strain", CASES)
def test_unknown_load_with_controlled_apex(a: float, h: float, strain: str) -> None:
    """The load factor is found while the apex deflection is controlled: P(h) = P(2 h) = 0, lower limit = - upper."""
    model, apex = _truss(a, h, strain)
    limit = LIMITS[a, h][strain][1] * EA
    model.add(kg.NodalLoad(apex, (0, -limit)))
    result = kg.DisplacementControl(model, to=-2 * h, control=(apex, "y"), targets=-h * np.linspace(0.05, 2, 40)).run()
    deflection = -result.u[:, 1, 1]
    assert deflection[-1] == pytest.approx(2 * h, rel=1e-12)
    assert result.lam == pytest.approx(_load(a, h, strain, deflection) / limit, abs=1e-8)
    assert result.lam[-1] == pytest.approx(0.0, abs=1e-8)
    assert 0.97 < result.lam.max() < 1.0 + 1e-8 and -1.0 - 1e-8 < result.lam.min() < -0.97


@pytest.mark.parametrize("strain", ["green", "engineering"])
def test_arc_length_follows_the_same_path(strain: str) -> None:
    a, h = 1.0, 0.5
    model, apex = _truss(a, h, strain)
    deflection_at_limit, limit = LIMITS[a, h][strain]
    model.add(kg.NodalLoad(apex, (0, -limit * EA)))
    result = kg.ArcLength(model, step=0.1, stop=lambda step: -step.u[1, 1] > 2.1 * h).run()
    deflection = -result.u[:, 1, 1]
    assert np.all(np.diff(deflection) > 0) and deflection[-1] > 2.1 * h
    assert result.lam == pytest.approx(_load(a, h, strain, deflection) / (limit * EA), abs=1e-7)
    assert result.lam.min() < -0.9
    # Between the limit points no step is stable under the load, outside all are.
    mirror = 2 * h - deflection_at_limit
    between = (deflection > deflection_at_limit) & (deflection < mirror)
    assert np.array_equal(result.stable, ~between)


@pytest.mark.parametrize("strain", ["green", "engineering"])
def test_energy_balance(strain: str) -> None:
    """Work of the driven apex = energy stored, by the trapezoid rule on 100 steps to 1e-3."""
    model, apex = _truss(1.0, 0.5, strain)
    model.add(kg.Prescribe(apex, y=-0.4))
    result = kg.DisplacementControl(model, to=1.0, targets=np.linspace(0, 1, 101)[1:], step=0.01).run()
    force, travel = result.reaction(apex, "y"), result.u[:, 1, 1]
    work = np.sum((force[1:] + force[:-1]) / 2 * np.diff(travel))
    assert work == pytest.approx(result.energy["bars"][-1], rel=1e-3)
    # Exact energy of two bars, for the sum itself.
    rest, length = np.hypot(1.0, 0.5), np.hypot(1.0, 0.1)
    measure = (length**2 / rest**2 - 1) / 2 if strain == "green" else length / rest - 1
    assert result.energy["bars"][-1] == pytest.approx(EA * rest * measure**2, rel=1e-9)


def test_unload_returns_the_same_way() -> None:
    model, apex = _truss(1.0, 0.5, "green")
    model.add(kg.Prescribe(apex, y=-0.9))
    out = kg.DisplacementControl(model, to=1.0, step=0.1).run()
    back = kg.DisplacementControl(model, to=0.0, start=out[-1], step=0.1).run()
    assert back.lam[-1] == pytest.approx(0.0, abs=1e-14)
    assert np.abs(back.u[-1]).max() < 1e-12
    deflection = -back.u[:, 1, 1]
    assert -back.reaction(apex, "y") == pytest.approx(_load(1.0, 0.5, "green", deflection), abs=1e-8 * EA)


@pytest.mark.parametrize("fraction", [0.5, 0.9, 0.999])
def test_load_control_below_the_limit(fraction: float) -> None:
    a, h = 1.0, 0.5
    model, apex = _truss(a, h, "green")
    limit = LIMITS[a, h]["green"][1] * EA
    model.add(kg.NodalLoad(apex, (0, -limit)))
    result = kg.LoadControl(model, to=fraction, step=0.1, tol=1e-11).run()
    top = LIMITS[a, h]["green"][0]
    exact = brentq(lambda w: float(_load(a, h, "green", w)) - fraction * limit, 0.0, top, xtol=1e-14)
    assert -result.u[-1, 1, 1] == pytest.approx(exact, rel=1e-6)
    assert result.stable.all()


def test_load_control_beyond_the_limit_says_so() -> None:
    """No silent jump past the limit: an error that keeps the steps below, or a step on the far, stable branch."""
    a, h = 1.0, 0.5
    model, apex = _truss(a, h, "green")
    limit = LIMITS[a, h]["green"][1] * EA
    model.add(kg.NodalLoad(apex, (0, -limit)))
    with pytest.raises(kg.ConvergenceError) as caught:
        kg.LoadControl(model, to=1.2, step=0.1).run()
    kept = caught.value.results
    assert kept is not None
    assert 0.9 < kept.lam.max() < 1.0 + 1e-6
    assert kept.lam == pytest.approx(_load(a, h, "green", -kept.u[:, 1, 1]) / limit, abs=1e-7)


# ------------------------------------------------------------------------------------------------- star dome

# The usual 24-bar benchmark geometry; loads / EA computed with 0.001 steps of the apex by an independent program.
DOME = {
    "engineering": {"limit": 3.08475e-4, "valley": -2.8142e-4},
    "green": {"limit": 3.08425e-4, "valley": -2.8146e-4},
}
DOME_LIMIT_AT, DOME_VALLEY_AT = 0.788, 3.071


def _dome(strain: str) -> tuple[kg.Model, kg.Node]:
    model = kg.Model()
    turn = np.pi / 3 * np.arange(6)
    apex = model.add(kg.Node(0, 0, 8.216))
    ring = model.add(*(kg.Node(25 * np.cos(q), 25 * np.sin(q), 6.216) for q in turn))
    base = model.add(*(kg.Node(43.3 * np.cos(q), 43.3 * np.sin(q), 0) for q in turn + np.pi / 6))
    for n in range(6):
        for end in (apex, ring[(n + 1) % 6], base[n], base[n - 1]):
            model.add(kg.Bar(ring[n], end, 1e4, strain=strain))
    model.add(kg.Fix(base), kg.NodalLoad(apex, (0, 0, -1e4 * DOME[strain]["limit"])))
    return model, apex


def _turning_point(deflection: Floats, load: Floats, at: int) -> tuple[float, float]:
    """Vertex of the parabola through three neighbouring points of a curve."""
    curve = np.polyfit(deflection[at - 1 : at + 2], load[at - 1 : at + 2], 2)
    place = -curve[1] / (2 * curve[0])
    return float(place), float(np.polyval(curve, place))


@pytest.mark.parametrize("strain", DOME)
def test_dome_by_apex_deflection(strain: str) -> None:
    model, apex = _dome(strain)
    result = kg.DisplacementControl(model, to=-3.6, control=(apex, "z"), targets=-np.linspace(0.05, 3.6, 72)).run()
    deflection, load = -result.u[:, 0, 2], result.lam * DOME[strain]["limit"]
    top, bottom = int(load.argmax()), int(load.argmin())
    place, limit = _turning_point(deflection, load, top)
    assert place == pytest.approx(DOME_LIMIT_AT, abs=2e-3)
    assert limit == pytest.approx(DOME[strain]["limit"], rel=1e-4)
    place, valley = _turning_point(deflection, load, bottom)
    assert place == pytest.approx(DOME_VALLEY_AT, abs=5e-3)
    assert valley == pytest.approx(DOME[strain]["valley"], rel=1e-4)
    # No bifurcation before the limit point: the tangent stays positive definite up to it.
    assert _negative_eigenvalues(model, result.u[:top]) == [0] * top
    # The apex sinks on the axis of the sixfold dome.
    assert np.abs(result.u[:, 0, :2]).max() < 1e-8


@pytest.mark.parametrize("strain", DOME)
def test_dome_by_arc_length(strain: str) -> None:
    model, _ = _dome(strain)
    result = kg.ArcLength(model, step=0.02, stop=lambda step: -step.u[0, 2] > 1.6).run()
    deflection, load = -result.u[:, 0, 2], result.lam * DOME[strain]["limit"]
    top = int(load.argmax())
    assert 0 < top < len(load) - 1
    place, limit = _turning_point(deflection, load, top)
    assert place == pytest.approx(DOME_LIMIT_AT, abs=1e-2)
    assert limit == pytest.approx(DOME[strain]["limit"], rel=1e-3)
    assert result.stable[:top].all() and not result.stable[top + 1]


def _negative_eigenvalues(model: kg.Model, displacements: Floats) -> list[int]:
    system = kg.System(model)
    return [int(np.sum(np.linalg.eigvalsh(system.stiffness(u).toarray()) < 0)) for u in displacements]
