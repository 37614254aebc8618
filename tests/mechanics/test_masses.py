"""Masses and frequencies: totals, trusses exactly, beams and plates, free sheets, what is refused."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg
import shapely

import kirigami as kg
from kirigami.system.inertia import Inertia

RUNGS = ("paper", "plate", "facet", "shell")
KINDS = ("consistent", "lumped")
DENSITY, THICKNESS = 1400.0, 0.3e-3
PAPER = kg.Material(E=4e9, nu=0.3, density=DENSITY)


def slit_sheet(rung: str) -> kg.Model:
    sheet = kg.Sheet(shapely.box(0, 0, 0.1, 0.06), [[(0.03, 0.02), (0.07, 0.04)]], THICKNESS, PAPER)
    return kg.Model.from_mesh(sheet.mesh(max_edge=0.025), stiffness=rung)


@pytest.mark.parametrize("rung", RUNGS)
@pytest.mark.parametrize("kind", KINDS)
def test_the_mass_of_a_sheet_is_density_times_volume(rung: str, kind: str) -> None:
    """And nothing acts on its centre of mass or its spin but what rigid motions of a lamina have."""
    m = slit_sheet(rung)
    inertia = Inertia(kg.System(m), kind)
    assert inertia.total == pytest.approx(DENSITY * THICKNESS * 0.1 * 0.06, rel=1e-12)
    rest = inertia.system.rest
    moving = np.zeros_like(rest)
    moving[: len(m.nodes)] = (1.0, 2.0, -2.0)  # all nodes alike; the rows behind them are offsets, which stay
    assert inertia.energy(moving) == pytest.approx(0.5 * inertia.total * 9.0, rel=1e-12)
    if kind == "consistent":  # a spin about z through the origin: polar moment of area, exactly
        spinning = np.stack([-rest[:, 1], rest[:, 0], np.zeros(len(rest))], axis=1)
        polar = DENSITY * THICKNESS * (0.1**3 * 0.06 + 0.1 * 0.06**3) / 3
        assert 2 * inertia.energy(spinning) == pytest.approx(polar, rel=1e-9)


def test_two_masses_on_two_springs() -> None:
    k1, k2, m1, m2 = 7.0, 3.0, 2.0, 0.5
    m = kg.Model(dim=2)
    wall, a, b = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    m.add(kg.Bar(wall, a, k1), kg.Bar(a, b, k2), kg.Fix(wall), kg.Fix([a, b], "y"))
    m.add(kg.Mass(a, m1), kg.Mass(b, 0.5 * m2), kg.Mass(b, 0.5 * m2))
    half, product = 0.5 * ((k1 + k2) / m1 + k2 / m2), k1 * k2 / (m1 * m2)
    exact = half + np.array([-1, 1]) * np.sqrt(half**2 - product)
    for kind in KINDS:
        modes = kg.Eigen(m, n=2, mass=kind).run()
        assert modes.frequencies == pytest.approx(np.sqrt(exact) / (2 * np.pi), rel=1e-12)
        assert modes[1].frequency == modes.frequencies[1]


def test_a_rod_of_bars_has_the_frequencies_of_its_discrete_formulas() -> None:
    """Held at one end: theta = (2 k - 1) pi / (2 n); consistent 6 c (1 - cos) / (2 + cos), lumped 2 c (1 - cos)."""
    n, EA, line, length = 6, 3.0, 2.0, 0.7
    m = kg.Model(dim=2)
    nodes = m.add(*(kg.Node(k * length, 0) for k in range(n + 1)))
    m.add(*(kg.Bar(a, b, EA, mass_per_length=line) for a, b in pairwise(nodes)))
    m.add(kg.Fix(nodes[0]), kg.Fix(list(nodes[1:]), "y"))
    cos = np.cos((2 * np.arange(1, n + 1) - 1) * np.pi / (2 * n))
    c = EA / (line * length**2)
    assert kg.Eigen(m, n=n, mass="consistent").run().values == pytest.approx(6 * c * (1 - cos) / (2 + cos), rel=1e-11)
    assert kg.Eigen(m, n=n, mass="lumped").run().values == pytest.approx(2 * c * (1 - cos), rel=1e-11)


def test_a_cantilever_has_the_frequencies_of_a_beam() -> None:
    """Euler and Bernoulli; without Poisson's effect they hold for a strip of any width. Bars on an even mesh too."""
    E, t, L, width = 1e9, 0.01, 1.0, 0.1
    beam = np.array([1.875104069, 4.694091133]) ** 2 * np.sqrt(E * t**2 / 12 / 7.0) / (2 * np.pi * L**2)
    for rung, edge in (("shell", 0.1), ("plate", 0.05)):
        mesh = kg.Sheet(shapely.box(0, 0, L, width)).mesh(edge)
        m = kg.Model.from_mesh(mesh, t, kg.Material(E, nu=0.0, density=7.0), stiffness=rung)
        m.add(kg.Fix(m.select(boundary="left"), clamp=True))
        middle = [k for k, p in enumerate(mesh.nodes) if abs(p[0] - L) < 1e-9]
        modes = kg.Eigen(m, n=6, mass="consistent").run()
        ends = [(mode.frequency, mode.shape[middle, 2]) for mode in modes]
        bending = [frequency for frequency, z in ends if np.ptp(z) < 0.1 * np.abs(z).max()]
        assert bending[0] == pytest.approx(beam[0], rel=5e-3), rung
        if rung == "shell":
            assert bending[:2] == pytest.approx(beam, rel=1e-4)


def test_a_simply_supported_plate_has_the_frequencies_of_navier() -> None:
    """(pi / 2) sqrt(D / (rho t)) (i^2 / a^2 + j^2 / b^2)."""
    E, nu, t, a, b = 2e11, 0.3, 1e-3, 0.5, 0.3
    mesh = kg.Sheet(shapely.box(0, 0, a, b)).mesh(0.075)
    m = kg.Model.from_mesh(mesh, t, kg.Material(E, nu, density=7800.0), stiffness="shell")
    m.add(kg.Fix(m.select(boundary="outer")))
    D = E * t**3 / (12 * (1 - nu**2))
    waves = sorted((i / a) ** 2 + (j / b) ** 2 for i in range(1, 5) for j in range(1, 5))[:4]
    exact = np.pi / 2 * np.sqrt(D / 7800 / t) * np.array(waves)
    assert kg.Eigen(m, n=4, mass="consistent").run().frequencies == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize("rung", RUNGS)
@pytest.mark.parametrize("kind", KINDS)
def test_what_has_no_mass_follows(rung: str, kind: str) -> None:
    """Six zeros of a free sheet, then what a dense solution says in which massless unknowns are eliminated."""
    m = slit_sheet(rung)
    values = kg.Eigen(m, n=9, mass=kind).run().values
    assert np.array_equal(values[:6], np.zeros(6)) and values[6] > 0
    system = kg.System(m)
    inertia = Inertia(system, kind)
    K, M = system.matrix(system.stiffness_blocks(system.rest * 0, 0.0)).toarray(), inertia.matrix.toarray()
    light = M.diagonal() == 0
    assert light.any() == (rung == "shell")
    heavy, across = ~light, K[np.ix_(light, ~light)]
    condensed = K[np.ix_(heavy, heavy)] - across.T @ np.linalg.solve(K[np.ix_(light, light)], across)
    dense = scipy.linalg.eigh(condensed, M[np.ix_(heavy, heavy)], eigvals_only=True)
    assert values[6:] == pytest.approx(dense[6:9], rel=1e-5)


def test_unstable_states_have_no_frequency_and_unit_masses_neither() -> None:
    m = kg.Model(dim=2)
    a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    m.add(kg.Bar(a, b, 1.0, rest_length=1.1), kg.Bar(b, c, 1.0, rest_length=1.1), kg.Fix([a, c]), kg.Mass(b, 1.0))
    modes = kg.Eigen(m, n=2, mass="consistent").run()
    assert modes.values[0] < 0 and np.isnan(modes.frequencies[0]) and modes.frequencies[1] > 0
    with pytest.raises(kg.AnalysisError, match="mass='consistent'"):
        kg.Eigen(m, n=1).run().frequencies  # noqa: B018


def test_a_model_without_mass_is_refused_with_the_remedy() -> None:
    for rung in RUNGS:
        m = slit_sheet(rung)
        bare = kg.Model.from_mesh(m.mesh, THICKNESS, kg.Material(4e9), stiffness=rung)
        with pytest.raises(kg.ModelError, match="density"):
            kg.Eigen(bare, mass="consistent").run()
    truss = kg.Model(dim=2)
    a, b = truss.add(kg.Node(0, 0), kg.Node(1, 0))
    truss.add(kg.Bar(a, b, 1.0))
    with pytest.raises(kg.ModelError, match="mass_per_length"):
        kg.Eigen(truss, n=1, mass="lumped").run()
    truss.add(kg.Mass(b, 1.0))
    with pytest.raises(kg.ModelError, match="only 2 unknowns"):
        kg.Eigen(truss, n=3, mass="lumped").run()
    with pytest.raises(kg.ModelError, match="positive"):
        kg.Mass(a, 0.0)


def test_pictures_and_films_of_modes(tmp_path) -> None:
    """Drawn with the largest displacement asked for, also of a truss, and one that swings to and fro."""
    sheet = slit_sheet("shell")
    truss = kg.Model(dim=2)
    a, b, c = truss.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1))
    truss.add(kg.Bar(a, b, 1.0), kg.Bar(b, c, 1.0), kg.Bar(c, a, 1.0))
    for m, n in ((sheet, 7), (truss, 4)):
        mode = kg.Eigen(m, n=n).run()[n - 1]
        ax = mode.plot(amplitude=0.02)
        film = mode.animate(tmp_path / "mode.gif", frames=3, dpi=30)
        from PIL import Image

        with Image.open(film) as image:
            assert image.n_frames == 3
            assert len({image.seek(k) or image.info["duration"] for k in range(3)}) == 1  # no rest at the end
    segments = ax.collections[1].get_segments()
    moved = np.concatenate(segments)
    at = truss.positions()[:, :2]
    apart = [np.abs(moved - point).max(axis=1).min() for point in at]
    assert max(apart) == pytest.approx(0.02, rel=1e-9)
    with pytest.raises(kg.AnalysisError, match="Eigen or Buckling"):
        kg.Mode(1.0, np.zeros((3, 3))).plot()
