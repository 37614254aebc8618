"""Mechanism analysis: Maxwell's count, zero modes, self-stress, paths at zero energy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import kirigami as kg
from kirigami import tilings
from kirigami.lattice.framework import Framework


def _framework(
    points: Sequence[tuple[float, ...]], bars: Sequence[tuple[int, int]], held: Sequence[int] = ()
) -> Framework:
    model = kg.Model(dim=2)
    nodes = model.add(*(kg.Node(*point) for point in points))
    model.add(*(kg.Bar(nodes[i], nodes[j], EA=1.0) for i, j in bars))
    if held:
        model.add(kg.Fix([nodes[k] for k in held]))
    return Framework.from_model(model)


RING = [(0, 1), (1, 2), (2, 3), (3, 0)]
CORNERS = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


@pytest.mark.parametrize("braces, internal, stresses", [([], 1, 0), ([(0, 2)], 0, 0), ([(0, 2), (1, 3)], 0, 1)])
def test_square_frame(braces: list[tuple[int, int]], internal: int, stresses: int) -> None:
    found = _framework(CORNERS, RING + braces).rigidity()
    assert (found.rigid, len(found.internal), len(found.self_stresses)) == (3, internal, stresses)
    assert found.maxwell == len(found.zero_modes) - stresses


def test_state_of_self_stress_of_a_crossed_square() -> None:
    """Sides carry one force, diagonals -sqrt(2) times it."""
    (stress,) = _framework(CORNERS, [*RING, (0, 2), (1, 3)]).rigidity().self_stresses
    assert stress / stress[0] == pytest.approx([1, 1, 1, 1, -np.sqrt(2), -np.sqrt(2)])


def test_collinear_chain_has_a_mode_and_a_stress_at_once() -> None:
    """Two bars in line between fixed ends: the middle moves freely to first order, and the bars can be pretensioned."""
    found = _framework([(0, 0), (1, 0), (2, 0)], [(0, 1), (1, 2)], held=[0, 2]).rigidity()
    assert (found.rigid, len(found.internal), len(found.self_stresses), found.maxwell) == (0, 1, 1, 0)
    assert found.shapes[0][1] == pytest.approx([0, 1, 0])


@pytest.mark.parametrize("angle", [1.08, 1.75, 2.2])
@pytest.mark.parametrize("columns, rows", [(3, 2), (5, 4)])
def test_free_kagome_lattice_has_maxwells_count_of_zero_modes(angle: float, columns: int, rows: int) -> None:
    """No self-stress in the free lattice, so 2 n - b zero modes, three of them rigid."""
    framework = Framework.from_tiling(tilings.kagome(angle).patch(columns, rows))
    found = framework.rigidity()
    assert len(found.self_stresses) == 0
    assert len(found.zero_modes) == 2 * len(framework.points) - len(framework.bars) == found.maxwell
    assert found.rigid == 3


def test_zero_modes_stretch_nothing_and_stresses_balance() -> None:
    framework = Framework.from_tiling(tilings.rotating_squares(0.7).patch(2, 1), bracing="crossed")
    found, matrix = framework.rigidity(), framework.compatibility()
    assert np.abs(found.zero_modes @ matrix.T).max() < 1e-12
    assert np.abs(found.self_stresses @ matrix).max() < 1e-12
    # 8 panels with 3 motions each and 10 joints: one more than rigid; one spare bar in each crossed panel.
    assert len(found.internal) == 1 and len(found.self_stresses) == 8


def test_compatibility_matches_the_stiffness_of_the_model() -> None:
    """C' diag(EA / L) C is the stiffness of the bars at rest, supports and ties included."""
    tiling = tilings.kagome(1.4).patch(2, 2)
    model = kg.Model(dim=2)
    nodes = model.add(*(kg.Node(*point) for point in tiling.vertices))
    model.add(*(kg.Bar(nodes[i], nodes[j], EA=2.0) for i, j in tiling.bars()))
    model.add(kg.Fix(nodes[:2]), kg.Fix(nodes[3], "y"), kg.Tie(nodes[5], nodes[6], "x"))
    framework = Framework.from_model(model)
    matrix = framework.compatibility()
    length = np.linalg.norm(framework.vectors(), axis=1)
    expected = matrix.T @ np.diag(2.0 / length) @ matrix
    assert kg.System(model).stiffness().toarray() == pytest.approx(expected, abs=1e-12)


def test_four_bar_linkage_is_followed_far() -> None:
    """Crank 0.5, coupler 2, rocker 1.5, base 2: distances kept to 1e-12 and the closed form of the rocker."""
    crank, coupler, rocker, base = 0.5, 2.0, 1.5, 2.0

    def rocker_end(turn: float) -> np.ndarray:
        a = crank * np.array([np.cos(turn), np.sin(turn)])
        d = np.array([base, 0.0]) - a
        far = np.linalg.norm(d)
        along = (coupler**2 - rocker**2 + far**2) / (2 * far)
        up = np.array([-d[1], d[0]]) / far
        return np.asarray(a + along * d / far + np.sqrt(coupler**2 - along**2) * up)

    start = 1.0
    points = [(0.0, 0.0), (crank * np.cos(start), crank * np.sin(start)), tuple(rocker_end(start)), (base, 0.0)]
    framework = _framework(points, [(0, 1), (1, 2), (2, 3)], held=[0, 3])
    (mode,) = framework.rigidity().shapes
    path = framework.follow(mode, distance=2.5, steps=50)
    moved = framework.points + path[..., :2]
    turns = np.unwrap(np.arctan2(moved[:, 1, 1], moved[:, 1, 0]))
    assert abs(turns[-1] - start) > 2.0
    for turn, state in zip(turns, moved):
        assert np.linalg.norm(state[1]) == pytest.approx(crank, abs=1e-12)
        assert state[2] == pytest.approx(rocker_end(turn), abs=1e-9)


def test_rotating_squares_are_followed_from_open_to_nearly_closed() -> None:
    """The path of the finite lattice is that of the closed form: width l (cos phi + sin phi) per square, both ways."""
    tiling = tilings.rotating_squares(1.2).patch(2, 2)
    framework = Framework.from_tiling(tiling, bracing="crossed")
    (mode,) = framework.rigidity().shapes
    closing = mode[:, :2] * -np.sign(((tiling.vertices - tiling.vertices.mean(axis=0)) * mode[:, :2]).sum())
    path = framework.follow(closing, distance=2.5, steps=20)
    moved = tiling.vertices + path[..., :2]
    edges = np.linalg.norm(np.diff(moved[:, tiling.polygons[0]], axis=1), axis=2)
    assert edges == pytest.approx(1.0, abs=1e-12)
    gap = tiling.gaps[0]
    arms = moved[:, [gap.left, gap.right]] - moved[:, [gap.pivot]]
    turn = np.arctan2(*np.moveaxis(arms, 2, 0)[::-1])
    opening = np.remainder(turn[:, 0] - turn[:, 1], 2 * np.pi)
    opening = np.minimum(opening, np.pi - opening) if opening[0] < np.pi / 2 else np.pi - opening
    assert opening[-1] < 0.8
    spread = np.linalg.norm(moved - moved.mean(axis=1, keepdims=True), axis=2) ** 2
    spacing = np.cos(opening / 2) + np.sin(opening / 2)
    assert moved[:, :, 0].std() > 0 and spread.sum(axis=1)[-1] < spread.sum(axis=1)[0]
    # Centres of the first and the last square, whatever the rigid motion: 3 spacings apart along both axes.
    first, last = moved[:, tiling.polygons[0]].mean(axis=1), moved[:, tiling.polygons[-1]].mean(axis=1)
    assert np.linalg.norm(last - first, axis=1) == pytest.approx(3 * np.sqrt(2) * spacing, rel=1e-9)


def test_a_motion_that_stretches_is_refused() -> None:
    framework = _framework(CORNERS, [*RING, (0, 2)])
    with pytest.raises(kg.AnalysisError, match="stretches bars"):
        framework.follow([[0, 0], [0, 0], [1, 1], [0, 0]], distance=1.0)
    with pytest.raises(kg.ModelError, match="not zero"):
        framework.follow(np.zeros((4, 2)), distance=1.0)
    model = kg.Model(dim=2)
    model.add(kg.Node(0, 0))
    with pytest.raises(kg.ModelError, match="no bars"):
        Framework.from_model(model)
