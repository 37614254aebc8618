"""Periodic frameworks: windings and polarisation of the deformed kagome lattice, guest modes, bands."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import kirigami as kg
from kirigami import tilings
from kirigami.lattice.bloch import bands, guest_modes, polarization, winding_numbers
from kirigami.lattice.framework import Framework

# Sides (OR, OS, RS), critical angles, and windings interval by interval in one gauge; only differences count.
TABLE = [
    ((0.8, 0.6, 1.0), (1.5708, 1.6907, 2.0944), [(-1, 2), (0, 1), (-1, 1), (-1, 2)]),
    ((0.9, 0.75, 1.1), (1.6915, 1.7907, 2.0944), [(-1, 2), (0, 1), (-1, 1), (-1, 2)]),
    ((0.72, 1.0, 0.57), (2.0944, 2.5478, 2.8101), [(-1, 2), (-1, 3), (0, 2), (-1, 2)]),
]


def _cell(angle: float, sides: tuple[float, float, float] = (0.8, 0.6, 1.0)) -> Framework:
    return Framework.from_tiling(tilings.kagome(angle, sides))


@pytest.mark.parametrize("sides, critical, windings", TABLE)
def test_windings_change_at_the_critical_angles(
    sides: tuple[float, float, float], critical: tuple[float, ...], windings: list[tuple[int, int]]
) -> None:
    """Facing sides become parallel at 2 pi/3, pi - alpha, pi/3 + rho (Rocklin et al. 2017); 0.01 rad either side."""
    assert tilings.critical_angles(sides) == pytest.approx(critical, abs=1e-4)
    edges = tilings.critical_angles(sides)
    inner = [(low + 0.01, high - 0.01) for low, high in pairwise(edges)]
    inside = [(edges[0] - 0.01,), *inner, (edges[2] + 0.01,)]
    start = np.array(winding_numbers(_cell(inside[0][0], sides)))
    for angles, expected in zip(inside, windings):
        for angle in angles:
            change = np.array(winding_numbers(_cell(angle, sides))) - start
            assert change.tolist() == (np.array(expected) - windings[0]).tolist()


def test_equal_triangles_are_never_polarised() -> None:
    for angle in (1.0, 2.0, 2.2, 3.0):
        assert polarization(Framework.from_tiling(tilings.rotating_triangles(angle))).tolist() == [0.0, 0.0]


def test_windings_do_not_depend_on_the_path() -> None:
    for angle in (1.08, 1.63, 1.92, 2.4):
        assert len({winding_numbers(_cell(angle), at) for at in (0.3, 1.0, 2.0, math.pi, 5.0)}) == 1


def test_polarisation_does_not_depend_on_the_cell() -> None:
    """Other copies of the points make other windings and the same polarisation."""
    cell = tilings.kagome(1.92)
    moved = cell.points.copy()
    shift = {0: (0, 0), 1: (2, -1), 2: (0, 1)}
    for vertex, steps in shift.items():
        moved[vertex] += np.array(steps) @ cell.lattice
    panels = [[(v, a - shift[v][0], b - shift[v][1]) for v, a, b in panel] for panel in cell.panels]
    other = Framework.from_tiling(tilings.Tiling(moved, panels, cell.lattice))
    first = Framework.from_tiling(cell)
    assert winding_numbers(other) != winding_numbers(first)
    assert polarization(other).tolist() == polarization(first).tolist() != [0.0, 0.0]


def test_at_the_border_there_is_no_winding() -> None:
    with pytest.raises(kg.ModelError, match="border"):
        winding_numbers(_cell(tilings.critical_angles()[2]), at=0.0)
    with pytest.raises(kg.ModelError, match="as many of both"):
        winding_numbers(Framework.from_tiling(tilings.rotating_squares(0.5)))
    with pytest.raises(kg.ModelError, match="finite"):
        guest_modes(Framework.from_tiling(tilings.kagome(1.0).patch(1, 1)))


def test_zero_modes_of_the_periodic_cell() -> None:
    """Six coordinates, six bars: two translations at phase zero, none at other phases away from critical angles."""
    cell = _cell(1.75)
    still = cell.rigidity()
    assert (len(still.zero_modes), len(still.self_stresses), still.rigid) == (2, 2, 2)
    for phases in ([0.4, 0.0], [0.0, 2.0], [1.0, -2.0], [np.pi, np.pi]):
        found = cell.rigidity(phases)
        assert (len(found.zero_modes), len(found.self_stresses), found.rank) == (0, 0, 6)
    # The straight kagome lattice carries self-stress along its straight lines.
    straight = Framework.from_tiling(tilings.rotating_triangles(2 * np.pi / 3))
    assert len(straight.rigidity([0.0, 2.0]).zero_modes) == 1


def test_guest_mode_is_the_twist_of_the_family() -> None:
    """Cells at angle +- h: the change of lattice and points is the guest mode, up to a rotation."""
    step = 1e-5
    below, above, cell = (tilings.kagome(1.75 + h) for h in (-step, step, 0.0))
    gradient = np.linalg.solve(cell.lattice, (above.lattice - below.lattice) / (2 * step)).T
    strain = 0.5 * (gradient + gradient.T)
    (mode,) = guest_modes(Framework.from_tiling(cell))
    scale = mode.strain.ravel() @ strain.ravel() / (strain.ravel() @ strain.ravel())
    assert mode.strain == pytest.approx(scale * strain, abs=1e-8)


@pytest.mark.parametrize(
    "cell", [tilings.rotating_squares(0.6), tilings.rotating_squares(2.0), tilings.rotating_triangles(1.2)]
)
def test_twists_that_dilate(cell: tilings.Tiling) -> None:
    (mode,) = guest_modes(Framework.from_tiling(cell))
    assert mode.poisson == pytest.approx(-1.0, abs=1e-9)
    assert mode.strain[0, 1] == pytest.approx(0.0, abs=1e-9)


def test_bands_of_a_plain_network() -> None:
    """Triangular lattice of unit springs and masses: along a1 to the zone border w^2 = 6 lengthwise, 2 across."""
    lattice = np.array([[1.0, 0.0], [0.5, np.sqrt(3) / 2]])
    shifts = np.array([[1, 0], [0, 1], [-1, 1]])
    network = Framework(np.zeros((1, 2)), np.zeros((3, 2), dtype=int), np.array([[0, 1]]), lattice, shifts)
    found = bands(network, [[0.0, 0.0], [np.pi, 0.0]])
    assert found[0] == pytest.approx([0.0, 0.0], abs=1e-12)
    # Phases (pi, 0): bars along a1 and a2 - a1 open, bar a2 does not.
    assert found[1] ** 2 == pytest.approx([2.0, 6.0], abs=1e-12)
