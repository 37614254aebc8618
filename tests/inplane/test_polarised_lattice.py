"""The polarised lattice: edge stiffness against a table, its trend with size, and what a uniform push shows."""

from __future__ import annotations

import numpy as np
import pytest
from lattices import script

import kirigami as kg
from kirigami import tilings
from kirigami.lattice.bloch import polarization
from kirigami.lattice.framework import Framework

EXAMPLE = script("examples", "polarised_lattice")

# Hard over soft edge, unit force at the middle hinge (bars 1/L, one spring 1e-6 a hinge, opposite edge pinned), from an
# independent linear computation.
RATIOS = {
    (15, 10): {1.08: 1.9, 1.40: 2.8, 1.63: 2.3, 1.75: 1.6, 1.92: 5.9, 2.00: 15.0, 2.20: 164.0, 2.40: 37.0},
    (30, 16): {1.08: 2.4, 1.63: 6.1, 1.75: 7.5, 1.92: 22.0, 2.40: 4.0},
}


@pytest.fixture(scope="module")
def ratios() -> dict[tuple[int, int], dict[float, float]]:
    return {size: {angle: EXAMPLE.contrast(angle, *size) for angle in row} for size, row in RATIOS.items()}


def test_edge_stiffness_table(ratios: dict[tuple[int, int], dict[float, float]]) -> None:
    for size, row in RATIOS.items():
        for angle, expected in row.items():
            assert ratios[size][angle] == pytest.approx(expected, rel=0.05), (size, angle)


def test_contrast_grows_with_size_where_polarised(ratios: dict[tuple[int, int], dict[float, float]]) -> None:
    small, large = ratios[15, 10], ratios[30, 16]
    for angle in (1.63, 1.75, 1.92):
        assert large[angle] > 2 * small[angle]
        assert np.any(polarization(Framework.from_tiling(tilings.kagome(angle))))
    assert large[1.08] < 1.5 * small[1.08]
    assert large[2.40] < small[2.40]
    for angle in (1.08, 2.40):
        assert not np.any(polarization(Framework.from_tiling(tilings.kagome(angle))))


def test_the_soft_edge_is_where_the_polarisation_points() -> None:
    """Two scalene triangles that polarise oppositely: the other edge is the soft one."""
    for sides, angle in (((0.8, 0.6, 1.0), 1.92), ((0.72, 1.0, 0.57), 2.32)):
        cell = tilings.kagome(angle, sides)
        up = polarization(Framework.from_tiling(cell))[1]
        piece = cell.patch(15, 11, keep=lambda a, b, panel: b > 0 if panel == 0 else b < 10)
        row, step = cell.lattice
        bottom, top = (
            [int(np.argmin(np.linalg.norm(piece.vertices - start - a * row, axis=1))) for a in range(15)]
            for start in (0 * step, 10 * step)
        )
        hard = EXAMPLE.edge_stiffness(piece, bottom, top) / EXAMPLE.edge_stiffness(piece, top, bottom)
        assert up in (1.0, -1.0)
        assert (hard > 2) if up > 0 else (hard < 0.5)


def test_near_a_critical_angle_a_finite_lattice_still_looks_polarised(
    ratios: dict[tuple[int, int], dict[float, float]],
) -> None:
    """2.2 rad is 0.1 beyond the last critical angle, unpolarised by its windings, and has the largest contrast."""
    assert not np.any(polarization(Framework.from_tiling(tilings.kagome(2.2))))
    assert ratios[15, 10][2.20] == max(ratios[15, 10].values())


def test_peak_moves_into_the_polarised_interval_with_size() -> None:
    """The contrast grows most with size between the outer critical angles."""
    low, _, high = tilings.critical_angles()
    angles = (1.2, 1.75, 1.92, 2.35)
    growth = {angle: EXAMPLE.contrast(angle, 20, 12) / EXAMPLE.contrast(angle, 10, 7) for angle in angles}
    best = max(growth, key=lambda angle: growth[angle])
    assert low < best < high


def test_gripped_edges_are_equally_stiff() -> None:
    """An edge that moves as one against a pinned one: the same relative motion whichever moves, polarised or not."""
    for angle in (1.08, 1.92):
        piece, bottom, top = EXAMPLE.lattice(angle, 9, 6)
        forces = []
        for pushed, held, inward in ((bottom, top, 1.0), (top, bottom, -1.0)):
            model = piece.model(EA=1.0, stiffness=EXAMPLE.JOINT)
            edge = [model.nodes[k] for k in pushed]
            model.add(kg.Fix([model.nodes[k] for k in held]), kg.Prescribe(edge, x=0.0, y=inward))
            forces.append(float(abs(kg.LinearStatic(model).run().reaction(edge, "y")[-1])))
        assert forces[0] == pytest.approx(forces[1], rel=1e-8)


def test_uniform_push_does_not_show_the_polarisation() -> None:
    """Free to slide: the edge that is 5.9 times harder at one hinge is 3 times softer as a whole."""
    assert EXAMPLE.contrast(1.92, 15, 10) > 5
    assert EXAMPLE.contrast(1.92, 15, 10, uniform=True) < 0.5


def test_loose_corners_hide_the_contrast() -> None:
    for angle in (1.63, 1.92):
        assert 0.5 < EXAMPLE.contrast(angle, 15, 10, clean=False) < 1.7


def test_contrast_is_one_of_small_pushes() -> None:
    hard, soft = EXAMPLE.push_forces(1.92, 15, 10, [0.001, 0.1, 0.5])
    assert hard[0] > 6 * soft[0]
    assert hard[1] > 3 * soft[1]
    assert hard[2] < soft[2]


def test_half_a_turn_exchanges_the_edges() -> None:
    """The lattice turned by 180 degrees and pushed at the other edge gives the same stiffness."""
    piece, bottom, top = EXAMPLE.lattice(1.92, 9, 6)
    turned = tilings.Tiling(-piece.points, piece.panels)
    for pushed, held in ((bottom, top), (top, bottom)):
        first = EXAMPLE.edge_stiffness(piece, pushed, held)
        assert EXAMPLE.edge_stiffness(turned, pushed, held) == pytest.approx(first, rel=1e-8)


def test_free_lattice_count() -> None:
    """The clean lattice without supports: 2 n - b zero modes and no self-stress."""
    piece, _, _ = EXAMPLE.lattice(1.75, 6, 4)
    framework = Framework.from_tiling(piece)
    found = framework.rigidity()
    assert not len(found.self_stresses)
    assert len(found.zero_modes) == 2 * len(piece.points) - 3 * len(piece.panels)
