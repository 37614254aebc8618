"""Units are the user's: lengths times s give forces times s^2, energies times s^3; E times r gives forces times r."""

from __future__ import annotations

from typing import Any

import meshes
import numpy as np
import pytest
from meshes import Floats

import kirigami as kg

# (length factor, modulus factor): metres to millimetres, millimetres to metres, another modulus, and both
UNITS = [(1e3, 1.0), (1e-3, 1.0), (1.0, 2.5e9), (1e3, 1e-6)]
EXACT = 1e-9


def _element_model(kind: str, s: float, r: float) -> kg.Model:
    points = s * np.array([[0.5, 0.8, 0.2], [0, 0, 0], [1.7, 0.1, 0], [0.9, -1.3, -0.1]])
    model = kg.Model(dim=2 if kind == "spring" else 3)
    if kind == "spring":
        points = points * [1, 1, 0]
    i, j, k, l = nodes = model.add(*(kg.Node(*point) for point in points))
    if kind == "hinge":
        model.add(kg.BendHinge(*nodes, 0.3 * r * s**3))
    elif kind == "spring":
        model.add(kg.TorsionSpring3(i, j, k, 0.3 * r * s**3), kg.Bar(k, l, r * s**2))
    else:
        model.add(kg.Bar(i, j, 7.0 * r * s**2, strain="engineering"), kg.Bar(k, l, r * s**2, law="ogden"))
    return model


@pytest.mark.parametrize("s, r", UNITS)
@pytest.mark.parametrize("kind", ["bar", "hinge", "spring"])
def test_elements(kind: str, s: float, r: float) -> None:
    """Forces times r s^2, stiffness times r s."""
    displaced = 0.3 * np.random.default_rng(1).normal(size=(4, 3)) * ([1, 1, 0] if kind == "spring" else 1)
    plain, scaled = kg.System(_element_model(kind, 1.0, 1.0)), kg.System(_element_model(kind, s, r))
    force, tangent = plain.gradient(displaced), plain.stiffness(displaced, constrained=False).toarray()
    assert np.abs(force).max() > 1e-3
    assert scaled.gradient(s * displaced) == pytest.approx(r * s**2 * force, abs=EXACT * r * s**2 * np.abs(force).max())
    scaled_tangent = scaled.stiffness(s * displaced, constrained=False).toarray()
    assert scaled_tangent == pytest.approx(r * s * tangent, abs=EXACT * r * s * np.abs(tangent).max())


@pytest.mark.parametrize("s, r", UNITS)
@pytest.mark.parametrize("preset", ["plate", "paper"])
def test_constants_of_a_sheet(preset: str, s: float, r: float) -> None:
    """EA times r s^2, hinge stiffness times r s^3: no length hides in a constant."""
    nodes, triangles = meshes.equilateral_strip(2, 2)

    def constants(s: float, r: float) -> tuple[Floats, Floats]:
        mesh = kg.TriMesh(s * nodes, triangles)
        model = kg.Model.from_mesh(mesh, 0.01 * s, kg.Material(3.0 * r, nu=0.3), stiffness=preset)
        bars = [e.EA for e in model.elements if isinstance(e, kg.Bar)]
        return np.array(bars), np.array([e.stiffness for e in model.elements if isinstance(e, kg.BendHinge)])

    (axial, bending), (scaled_axial, scaled_bending) = constants(1.0, 1.0), constants(s, r)
    assert scaled_axial == pytest.approx(r * s**2 * axial, rel=1e-12)
    assert scaled_bending == pytest.approx(r * s**3 * bending, rel=1e-12)


def _strip(s: float, r: float) -> tuple[kg.Model, tuple[kg.Node, ...]]:
    nodes, triangles = meshes.equilateral_strip(6, 2)
    return meshes.sheet(s * nodes, triangles, 2.0 * r, 0.1 * s, bending=0.09)


@pytest.mark.parametrize("s, r", UNITS)
def test_linear_statics_and_modes(s: float, r: float) -> None:
    """Same shape; reactions times r s^2; eigenvalues (mass 1 at each node) times r s."""

    def answers(s: float, r: float) -> tuple[Floats, Floats, Floats, Floats]:
        model, points = _strip(s, r)
        wall = [p for p in points if p.x < 0.6 * s]
        model.add(kg.Fix(wall), kg.NodalLoad(points[6], r * s**2 * np.array([0.0, 1e-4, 3e-5])))
        result, modes = kg.LinearStatic(model).run(), kg.Eigen(model, n=4).run()
        shapes = np.array([modes[k].shape for k in range(4)])
        return result.u[-1] / s, result.reaction(wall, "z") / (r * s**2), modes.values / (r * s), shapes

    for plain, scaled in zip(answers(1.0, 1.0), answers(s, r)):
        assert scaled == pytest.approx(plain, rel=1e-7, abs=1e-8 * np.abs(plain).max())


@pytest.mark.parametrize("s, r", UNITS)
def test_truss_snaps_alike(s: float, r: float) -> None:
    def answers(s: float, r: float) -> tuple[Floats, Floats, int]:
        model = kg.Model(dim=2)
        left, apex, right = model.add(kg.Node(-s, 0), kg.Node(0, 0.4 * s), kg.Node(s, 0))
        axial = 3.0 * r * s**2
        model.add(kg.Bar(left, apex, axial), kg.Bar(apex, right, axial), kg.Fix([left, right]))
        model.add(kg.NodalLoad(apex, (0, -0.01 * r * s**2)))
        result = kg.ArcLength(model, step=0.1, stop=lambda step: step.u[1, 1] < -s).run()
        return result.lam, result.u / s, result.stats["iterations"]

    plain, scaled = answers(1.0, 1.0), answers(s, r)
    assert scaled[2] == plain[2]
    assert scaled[0] == pytest.approx(plain[0], abs=EXACT)
    assert scaled[1] == pytest.approx(plain[1], abs=EXACT)


@pytest.mark.parametrize("s, r", UNITS)
def test_strip_bends_alike(s: float, r: float) -> None:
    """Large deflection of a cantilever: shape, energy, and even the number of iterations."""

    def answers(s: float, r: float) -> tuple[Floats, float, int]:
        model, points = _strip(s, r)
        model.add(kg.Fix([p for p in points if p.x < 0.6 * s]))
        tip = [p for p in points if p.x > 5.9 * s]
        model.add(kg.NodalLoad(tip, (0, 0, 1e-6 * r * s**2)))
        result = kg.LoadControl(model, to=1.0, step=0.25, tol=1e-10).run()
        return result.u / s, sum(e[-1] for e in result.energy.values()) / (r * s**3), result.stats["iterations"]

    plain, scaled = answers(1.0, 1.0), answers(s, r)
    assert np.abs(plain[0][-1]).max() > 0.3
    assert scaled[2] == plain[2]
    assert scaled[0] == pytest.approx(plain[0], abs=EXACT * np.abs(plain[0]).max())
    assert scaled[1] == pytest.approx(plain[1], rel=EXACT)


def _slit_sheet(s: float, r: float) -> dict[str, Any]:
    """A square with one slit across, pulled until the lips of the slit have buckled out of plane."""
    cells = 10
    nodes, triangles = meshes.right_isosceles(cells, cells, diagonals="union jack")
    row = 5 * (cells + 1)
    nodes, triangles = meshes.open_slit(nodes, triangles, list(range(row + 2, row + 9)))
    model, points = meshes.sheet(s * nodes, triangles, 2.0 * r, 0.05 * s, bending=0.09)
    bump = np.exp(-((nodes[:, 0] - 5) ** 2 + (nodes[:, 1] - 5.8) ** 2) / 4)
    model.perturb(0.1 * s * bump)
    bottom = [p for p in points if p.y < 1e-9 * s]
    top = [p for p in points if p.y > (cells - 1e-9) * s]
    model.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=0.2 * s))
    result = kg.DisplacementControl(model, to=1.0, targets=np.linspace(0.05, 1.0, 20), step=0.05).run()
    return {
        "lam": result.lam,
        "u": result.u / s,
        "force": result.reaction(top, "y") / (r * s**2),
        "opposite": result.reaction(bottom, "y") / (r * s**2),
        "energy": sum(result.energy.values()) / (r * s**3),
        "stable": result.stable,
    }


@pytest.mark.parametrize("s, r", UNITS)
def test_cut_sheet_buckles_alike(s: float, r: float) -> None:
    """The same sequence of steps, and 1e-6 in shape, force and energy, in metres and in millimetres."""
    plain, scaled = _slit_sheet(1.0, 1.0), _slit_sheet(s, r)
    assert plain["stable"][-1]
    assert np.abs(plain["u"][-1, :, 2]).max() > 0.3  # several thicknesses: it has buckled
    assert scaled["lam"] == pytest.approx(plain["lam"], rel=1e-12)
    for key in ("u", "force", "energy"):
        assert scaled[key] == pytest.approx(plain[key], abs=1e-6 * np.abs(plain[key]).max())


def test_cut_sheet_balances() -> None:
    """Both grips pull alike (1e-8), and the work of the moving grip is the energy stored."""
    run = _slit_sheet(1.0, 1.0)
    assert run["opposite"] == pytest.approx(-run["force"], abs=1e-8 * run["force"].max())
    work = np.sum((run["force"][1:] + run["force"][:-1]) / 2 * np.diff(0.2 * run["lam"]))
    assert run["energy"][-1] == pytest.approx(work, rel=5e-3)
