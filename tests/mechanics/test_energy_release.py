"""The energy release rate at the tips of slits: closed forms in the plane, and its definition where a sheet tears."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.results.fracture import tips

NU, THICKNESS = 0.3, 0.01


def cracked(half: float, nodes: int, rung: str = "shell", scale: float = 1.0) -> tuple[kg.Results, list[kg.Node]]:
    """A plate of width 1 and length 3 with a centre crack, pulled by a thousandth; lengths times a scale."""
    slit = [[((0.5 - half) * scale, 1.5 * scale), ((0.5 + half) * scale, 1.5 * scale)]]
    sheet = kg.Sheet(shapely.box(0, 0, scale, 3 * scale), slit, THICKNESS * scale, kg.Material(1e6 / scale**2, NU))
    m = kg.Model.from_mesh(sheet.mesh(nodes=nodes), stiffness=rung)
    top = m.select(boundary="top")
    m.add(kg.Fix(m.nodes, "z"), kg.Fix(m.select(boundary="bottom"), "xy"), kg.Prescribe(top, x=0, y=0.003 * scale))
    return kg.LinearStatic(m).run(), top


@pytest.mark.parametrize("rung, half, nodes, within", [
    ("shell", 0.1, 500, 0.02), ("shell", 0.3, 500, 0.02), ("facet", 0.2, 1200, 0.04),
])  # fmt: skip
def test_centre_crack(rung: str, half: float, nodes: int, within: float) -> None:
    """K = stress sqrt(pi a sec(pi a / W)) (1 - 0.025 s^2 + 0.06 s^4), s = 2 a / W (Tada, 1973), and G = K^2 / E."""
    res, top = cracked(half, nodes, rung)
    stress, s = res.reaction(top, "y")[-1] / THICKNESS, 2 * half
    exact = stress**2 * np.pi * half / np.cos(np.pi * half) * (1 - 0.025 * s**2 + 0.06 * s**4) ** 2 / 1e6
    np.testing.assert_allclose(res.energy_release(0)[-1], [exact, exact], rtol=within)


def test_centre_crack_in_other_units() -> None:
    here, there = cracked(0.2, 300)[0].energy_release(0)[-1], cracked(0.2, 300, scale=1e3)[0].energy_release(0)[-1]
    np.testing.assert_allclose(there, here / 1e3, rtol=1e-5)  # force over length


@pytest.mark.parametrize("half", [0.06, 0.09])
def test_a_slit_that_is_short_beside_its_distance_to_the_rim(half: float) -> None:
    """The other tip stays where it is, however near."""
    res, top = cracked(half, 800)
    stress = res.reaction(top, "y")[-1] / THICKNESS
    exact = stress**2 * np.pi * half / np.cos(np.pi * half) / 1e6
    np.testing.assert_allclose(res.energy_release(0)[-1], [exact, exact], rtol=0.02)


@pytest.mark.parametrize("angle", [0.0, np.pi / 2])
def test_a_slit_along_and_across_the_grain(angle: float) -> None:
    """G = K^2 sqrt(a11 a22 / 2) sqrt(sqrt(a22 / a11) + (2 a12 + a66) / (2 a11)) (Sih, Paris and Irwin, 1965)."""
    E1, E2, nu12, G12, half, stress = 4e9, 2e9, 0.3, 1e9, 0.01, 1e6
    sheet = kg.Sheet(shapely.box(0, 0, 0.2, 0.4), [[(0.1 - half, 0.2), (0.1 + half, 0.2)]], 1e-3,
                     kg.Orthotropic(E1, E2, nu12, G12, angle))  # fmt: skip
    m = kg.Model.from_mesh(sheet.mesh(nodes=1000), stiffness="shell")
    pull = np.array([0, stress * 1e-3, 0])
    m.add(kg.EdgeLoad(m.select(boundary="top"), pull), kg.EdgeLoad(m.select(boundary="bottom"), -pull))
    first, second = min(m.nodes, key=lambda n: n.x + n.y), min(m.nodes, key=lambda n: n.y - n.x)
    m.add(kg.Fix(m.nodes, "z"), kg.Fix(first, "xy"), kg.Fix(second, "y"))
    along, across, poisson = (E1, E2, nu12) if angle == 0 else (E2, E1, nu12 * E2 / E1)
    a11, a22, a12, a66 = 1 / along, 1 / across, -poisson / along, 1 / G12
    exact = stress**2 * np.pi * half / np.cos(np.pi * half / 0.2) * np.sqrt(a11 * a22 / 2)
    exact *= np.sqrt(np.sqrt(a22 / a11) + (2 * a12 + a66) / (2 * a11))
    np.testing.assert_allclose(kg.LinearStatic(m).run().energy_release(0)[-1], [exact, exact], rtol=0.01)


@pytest.mark.parametrize("length", [4.0, 6.0])
def test_double_cantilever_beam(length: float) -> None:
    """K = (F a / (t h^1.5)) (3.46 + 2.38 h / a), two arms of height h that bend (Gross and Srawley, 1966)."""
    h, force = 1.0, 1e-6
    sheet = kg.Sheet(shapely.box(0, -h, length + 4 * h, h), [[(0, 0), (length, 0)]], THICKNESS, kg.Material(1.0, NU))
    m = kg.Model.from_mesh(sheet.mesh(nodes=500), stiffness="shell")
    ends = m.select(where=lambda x, y, z: np.abs(x) < 1e-9)
    arms = [[node for node in ends if side * node.y > 1e-9] for side in (1, -1)]
    m.add(kg.Fix(m.nodes, "z"), kg.Fix(m.select(boundary="right"), "xy"))
    for side, arm in zip((1, -1), arms):
        m.add(kg.NodalLoad(arm, (0, side * force / len(arm), 0)))
    K = force * length / (THICKNESS * h**1.5) * (3.46 + 2.38 * h / length)
    assert kg.LinearStatic(m).run().energy_release(0)[-1] == pytest.approx([K**2], rel=0.015)


def torn(moved: float) -> kg.Results:
    """A strip slit from its rim, whose two legs are bent apart out of its plane, the tip moved along the slit."""
    sheet = kg.Sheet(shapely.box(0, 0, 3, 1), [[(0, 0.5), (1.5, 0.5)]], THICKNESS, kg.Material(1e6, NU))
    mesh = sheet.mesh(nodes=120)
    tip = tips(mesh, 0)[0]
    nodes = mesh.nodes.copy()
    nodes[tip.node, 0] += moved
    m = kg.Model.from_mesh(kg.TriMesh(nodes, mesh.triangles, cuts=mesh.cuts), THICKNESS, kg.Material(1e6, NU), "shell")
    ends = m.select(where=lambda x, y, z: np.abs(x) < 1e-9)
    m.add(kg.Fix(m.select(boundary="right"), clamp=True))
    for side in (1, -1):
        m.add(kg.Prescribe([node for node in ends if side * (node.y - 0.5) > 1e-9 or side * node.y > 1 - 1e-9 or
                            (side < 0 and node.y < 0.25)], z=0.3 * side))  # fmt: skip
    return kg.DisplacementControl(m, targets=[0.5]).run()


def test_it_is_the_derivative_of_the_energy_with_the_grips_held() -> None:
    """Of legs torn apart out of the plane, far beyond small rotations: -dU/da by two further equilibria."""
    step = 1e-3
    energies = [sum(part[-1] for part in torn(moved).energy.values()) for moved in (step, -step)]
    res = torn(0.0)
    found = res.energy_release(0)
    assert found.shape == (len(res), 1)
    assert -(energies[0] - energies[1]) / (2 * step * THICKNESS) == pytest.approx(found[-1, 0], rel=0.1)


@pytest.mark.parametrize("rung", ["plate", "shell"])
def test_what_has_no_tip_or_no_stress_there_is_refused(rung: str) -> None:
    mesh = kg.Sheet(shapely.box(0, 0, 1, 1), [shapely.Point(0.5, 0.5).buffer(0.2)]).mesh(0.2)
    res = kg.Results(kg.System(kg.Model.from_mesh(mesh, 0.01, kg.Material(1e6), rung)))
    with pytest.raises(kg.KirigamiError, match="bars and hinges" if rung == "plate" else "has no tip"):
        res.energy_release(0)
    with pytest.raises(kg.KirigamiError):
        res.energy_release(3)
