"""Tilings: geometry of the families, patches, joints and gaps, models, and bad input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

import kirigami as kg
from kirigami import tilings
from kirigami.lattice.framework import Framework
from kirigami.lattice.tilings.panel import braces

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 2, 2.5])
def test_rotating_squares_have_their_spacing(angle: float) -> None:
    """Cell of two by two squares: side (cos phi + sin phi) each, phi half the opening; every panel a unit square."""
    cell = tilings.rotating_squares(angle)
    spacing = np.cos(angle / 2) + np.sin(angle / 2)
    assert cell.lattice == pytest.approx(2 * spacing * np.eye(2), abs=1e-12)
    for polygon in cell.polygons:
        sides = np.diff(cell.vertices[np.append(polygon, polygon[0])], axis=0)
        assert np.linalg.norm(sides, axis=1) == pytest.approx(1.0, abs=1e-12)
        assert (sides * np.roll(sides, 1, axis=0)).sum(axis=1) == pytest.approx(0.0, abs=1e-12)
    # Two gaps at each joint: the opening, and what is left of the turn beside two square corners.
    assert sorted({round(gap.angle, 9) for gap in cell.gaps}) == pytest.approx(sorted({angle, np.pi - angle}), abs=1e-8)


@pytest.mark.parametrize("angle", [1.08, 1.63, 1.92, 2.2])
@pytest.mark.parametrize("sides", [(0.8, 0.6), (0.9, 1.0), (0.72, 1.0)])
def test_kagome_cell_area(angle: float, sides: tuple[float, float]) -> None:
    """|det| = sqrt3/2 + a sin alpha + a sin angle - cos(angle + alpha - pi/6) for OS = 1; general s from v1 x v2."""
    a, b = sides
    s = 1.0
    cell = tilings.kagome(angle, (a, s, b))
    alpha = np.arccos((a * a + s * s - b * b) / (2 * a * s))
    area = np.sqrt(3) / 2 + a * np.sin(alpha) + a * np.sin(angle) - np.cos(angle + alpha - np.pi / 6)
    assert cell.cell_area == pytest.approx(area, rel=1e-10)


def test_square_rhombus_is_mirrored_by_the_opposite_lean() -> None:
    one, other = (tilings.square_rhombus(angle).patch(2, 2) for angle in (0.2, -0.2))

    def shapes(tiling: tilings.Tiling, mirror: float) -> list[Any]:
        """Panels as sorted corners about the mean, in sorted order."""
        points = tiling.vertices * [mirror, 1.0]
        found = [sorted(np.round(points[p] - points[p].mean(axis=0), 9).tolist()) for p in tiling.polygons]
        return sorted(found)

    assert np.allclose(shapes(one, 1.0), shapes(other, -1.0), atol=1e-8)


def test_closed_squares_keep_their_joints_apart() -> None:
    """Closed squares touch along their sides: four corners meet at a point, but only pairs of them are joined."""
    piece = tilings.rotating_squares(0.0).patch(2, 2)
    assert len(piece.joints) == 24
    assert len(np.unique(np.round(piece.vertices, 9), axis=0)) < len(piece.vertices)
    assert min(gap.angle for gap in piece.gaps) == pytest.approx(0.0, abs=1e-9)
    model = piece.model(EA=1e3, stiffness=1.0)
    assert kg.System(model).energies(np.zeros((len(model.nodes), 2)))["springs"] == 0.0


@pytest.mark.parametrize("n1, n2", [(1, 1), (3, 2), (4, 5)])
def test_patch_counts(n1: int, n2: int) -> None:
    """2 n1 x 2 n2 squares share a corner with each neighbour."""
    piece = tilings.rotating_squares(0.5).patch(n1, n2)
    a, b = 2 * n1, 2 * n2
    assert len(piece.panels) == a * b
    assert len(piece.joints) == a * (b - 1) + b * (a - 1)
    assert len(piece.points) == 4 * a * b - len(piece.joints)
    assert piece.lattice is None and not len(piece.images)


def test_images_stand_where_the_lattice_puts_them() -> None:
    cell = tilings.kagome(1.75)
    image, leader, steps = cell.images[:, 0], cell.images[:, 1], cell.images[:, 2:]
    assert cell.vertices[image] == pytest.approx(cell.points[leader] + steps @ cell.lattice, abs=1e-12)
    assert len(set(image.tolist())) == len(image) == len(cell.vertices) - len(cell.points)


def test_periodic_gaps_are_those_of_an_inner_patch() -> None:
    cell = tilings.kagome(1.75)
    inner = sorted(round(gap.angle, 9) for gap in cell.gaps)
    found = {round(gap.angle, 9) for gap in cell.patch(3, 3).gaps}
    assert set(inner) == found
    assert sum(inner) == pytest.approx(3 * 2 * np.pi - 2 * np.pi, abs=1e-7)  # all turns but the six inner angles


def test_polygons_join_where_corners_coincide_or_where_told() -> None:
    shapes = [SQUARE, SQUARE + [1, 1], (SQUARE + [1, -1])[::-1]]
    tiling = tilings.from_polygons(shapes)
    assert sorted(map(tuple, tiling.vertices[tiling.joints])) == [(1.0, 0.0), (1.0, 1.0)]
    told = tilings.from_polygons([shapely.Polygon(shape) for shape in shapes], joints=[[1.0, 1.0]])
    assert len(told.joints) == 1 and len(told.points) == 11


def test_panels_that_share_an_edge_have_no_spring_along_it() -> None:
    tiling = tilings.from_polygons([SQUARE, SQUARE + [1, 0]])
    assert len(tiling.joints) == 2
    assert len(tiling.gaps) == 2  # one opening at each end of the common side, of half a turn
    assert [gap.angle for gap in tiling.gaps] == pytest.approx([np.pi, np.pi])


def test_both_springs_halve_the_stiffness() -> None:
    """With rigid panels the two gaps of a joint turn oppositely and equally, so the energy is the same."""
    tiling = tilings.from_polygons([SQUARE, SQUARE + [1, 1]])
    turn = 0.3
    c, s = np.cos(turn), np.sin(turn)
    moved = tiling.vertices.copy()
    second = [k for k in tiling.polygons[1] if k not in tiling.joints]
    moved[second] = (moved[second] - 1) @ np.array([[c, s], [-s, c]]) + 1
    for springs in ("one", "both"):
        model = tiling.model(EA=1.0, stiffness=2.0, springs=springs)
        energies = kg.System(model).energies(moved - tiling.vertices)
        assert energies["springs"] == pytest.approx(turn**2, rel=1e-12)
        assert energies["bars"] == pytest.approx(0.0, abs=1e-25)


def test_stiffness_joint_by_joint_and_from_a_ligament() -> None:
    tiling = tilings.rotating_squares(0.5).patch(1, 1)
    ligament = tilings.Ligament(E=3.5e9, thickness=1e-3, width=0.6e-3, length=1.5e-3)
    springs = [e for e in tiling.model(1.0, ligament).elements if isinstance(e, kg.TorsionSpring3)]
    assert [spring.stiffness for spring in springs] == pytest.approx([3.5e9 * 1e-3 * 0.6e-3**3 / (12 * 1.5e-3)] * 4)
    springs = [e for e in tiling.model(1.0, [1.0, 2.0, 3.0, 4.0]).elements if isinstance(e, kg.TorsionSpring3)]
    assert [spring.stiffness for spring in springs] == [1.0, 2.0, 3.0, 4.0]


@settings(max_examples=60, deadline=None)
@given(st.integers(3, 9), st.integers(0, 10_000), st.booleans(), st.booleans())
def test_braces_make_any_panel_rigid(corners: int, seed: int, crossed: bool, midpoints: bool) -> None:
    """Rank 2 n - 3: nothing but rigid motion is free, also with corners in line; single bracing has no bar to spare."""
    random = np.random.default_rng(seed)
    angle = np.sort(random.uniform(0, 2 * np.pi, corners))
    if np.diff(np.append(angle, angle[0] + 2 * np.pi)).min() < 0.2:
        return
    shape = random.uniform(0.4, 1.0, corners)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if midpoints:
        shape = np.stack([shape, 0.5 * (shape + np.roll(shape, -1, axis=0))], axis=1).reshape(-1, 2)
    pairs = braces(shape, crossed)
    rows = np.zeros((len(pairs), *shape.shape))
    for row, (i, j) in zip(rows, pairs):
        row[j] = shape[j] - shape[i]
        row[i] = -row[j]
    assert np.linalg.matrix_rank(rows.reshape(len(pairs), -1), tol=1e-7) == 2 * len(shape) - 3
    if not crossed:
        assert len(pairs) == 2 * len(shape) - 3


def test_sheet_of_ligaments_goes_back_to_its_tiling() -> None:
    """Panels, joints, width and (clipped on a circle, so to a tenth) length of every ligament are found again."""
    tiling = tilings.square_rhombus(np.pi / 16).patch(2, 2)
    sheet = tilings.ligament_sheet(tiling, width=0.06, length=0.2)
    found, necks = tilings.panels_of_sheet(sheet, neck=0.12)
    assert len(found.panels) == len(tiling.panels)
    assert len(necks) == len(tiling.joints)
    joints = tiling.vertices[tiling.joints]
    for neck in necks:
        assert np.linalg.norm(joints - neck.place, axis=1).min() < 0.01
        assert neck.width == pytest.approx(0.06, rel=1e-3)
        assert neck.length == pytest.approx(0.2, rel=0.12)
    assert found.vertices[found.joints] == pytest.approx(np.array([neck.place for neck in necks]), abs=1e-9)
    assert Framework.from_tiling(found).rigidity().rigid == 3


def test_cut_pattern_becomes_panels() -> None:
    """Crossed slits that stop short of each other: four panels round one cross, hanging at four ligaments."""
    slits = [shapely.LineString([(0.2, 1), (1.8, 1)]), shapely.LineString([(1, -0.1), (1, 0.9)])]
    slits += [shapely.LineString([(1, 1.1), (1, 2.1)]), shapely.LineString([(-0.1, 1), (0.1, 1)])]
    slits += [shapely.LineString([(1.9, 1), (2.1, 1)])]
    tiling, necks = tilings.panels_of_sheet(kg.Sheet(shapely.box(0, 0, 2, 2), slits), neck=0.15)
    assert len(tiling.panels) == 4 and len(necks) == 4


# ------------------------------------------------------------------------------------------------ bad input


@pytest.mark.parametrize(
    "polygons, joints, words",
    [
        ([SQUARE, SQUARE + [0.5, 0.5]], None, "panels 0 and 1 overlap around (0.75, 0.75)"),
        ([SQUARE, 0.5 * SQUARE + 0.2], None, "overlap"),
        ([[[0, 0], [1, 1], [2, 2]]], None, "has no area"),
        ([[[0, 0], [1, 1], [1, 0], [0, 1]]], None, "area"),
        ([[[0, 0], [2, 2], [2, 0], [0, 1]]], None, "crosses itself"),
        ([SQUARE, SQUARE + [1, 1]], [[0.0, 0.0]], "touches 1 panel;"),
        ([SQUARE, SQUARE + [1, 1]], [[5.0, 0.0]], "touches 0 panels;"),
        ([[[0, 0], [1, np.nan], [1, 0]]], None, "finite"),
        ([], None, "no polygons"),
        ([shapely.box(0, 0, 3, 3).difference(shapely.box(1, 1, 2, 2))], None, "hole"),
    ],
)
def test_bad_polygons(polygons: Any, joints: Any, words: str) -> None:
    with pytest.raises(kg.GeometryError) as caught:
        tilings.from_polygons(polygons, joints=joints)
    assert words in str(caught.value)


def test_bad_families_and_options() -> None:
    with pytest.raises(kg.GeometryError, match="overlap"):
        tilings.kagome(4.2)
    with pytest.raises(kg.GeometryError, match="no triangle"):
        tilings.kagome(1.5, (1.0, 1.0, 2.5))
    with pytest.raises(kg.GeometryError, match="between"):
        tilings.rotating_squares(-0.1)
    with pytest.raises(kg.GeometryError, match="periodic"):
        tilings.from_polygons([SQUARE]).patch(2, 2)
    with pytest.raises(kg.GeometryError, match="not parallel"):
        tilings.Tiling(SQUARE, [[0, 1, 2, 3]], [[1, 0], [2, 0]])
    with pytest.raises(kg.GeometryError, match="no panel uses vertex 3"):
        tilings.Tiling(SQUARE, [[0, 1, 2]])
    squares = tilings.rotating_squares(0.5).patch(1, 1)
    with pytest.raises(kg.ModelError, match="springs"):
        squares.model(1.0, 1.0, springs="three")
    with pytest.raises(kg.ModelError, match="positive"):
        squares.model(1.0, -1.0)
    with pytest.raises(kg.ModelError, match="shape \\(\\) or \\(4,\\)"):
        squares.model(1.0, [1.0, 2.0])
    with pytest.raises(kg.GeometryError, match="nothing falls apart"):
        tilings.panels_of_sheet(shapely.box(0, 0, 1, 1), neck=0.1)


def test_periodic_tiling_that_runs_into_itself() -> None:
    with pytest.raises(kg.GeometryError, match="overlap"):
        tilings.Tiling(SQUARE, [[0, 1, 2, 3]], [[0.8, 0], [0, 2]])


def test_free_lattice_is_a_mechanism() -> None:
    model = tilings.rotating_squares(0.5).patch(1, 1).model(EA=1.0, stiffness=1e-3)
    model.add(kg.NodalLoad(model.nodes[0], (1, 0)))
    with pytest.raises(kg.MechanismError, match="rigid body"):
        kg.LinearStatic(model).run()


def test_nonsense_is_refused_in_words() -> None:
    for points, panels in (("abc", [[0, 1, 2]]), (SQUARE, [[0, 1, "x"]]), (SQUARE, [[0, 1, 9]]), (SQUARE, [[0, 0, 1]])):
        with pytest.raises(kg.GeometryError, match="Tiling"):
            tilings.Tiling(points, panels)


@pytest.mark.parametrize("springs", ["one", "both"])
def test_closing_moment_presses_the_narrow_gap_shut(springs: str) -> None:
    """Turning the panel by a small angle costs moment times angle, more to open the narrow gap, less to close it."""
    angle, moment, stiffness, turn = 0.4, 0.3, 2.0, 1e-6
    c, s = np.cos(angle + np.pi / 2), np.sin(angle + np.pi / 2)
    tiling = tilings.from_polygons([SQUARE, SQUARE @ np.array([[c, s], [-s, c]])])
    (narrow,) = [gap for gap in tiling.gaps if abs(gap.angle - angle) < 1e-9]
    second = tiling.polygons[1]
    assert len(tiling.joints) == 1 and narrow.left in second
    system = kg.System(tiling.model(EA=1.0, stiffness=stiffness, springs=springs, closing_moment=moment))
    energies = []
    for sense in (-1, 1):  # the second square turns about the origin, counter-clockwise to open the narrow gap
        displacement = np.zeros((len(tiling.vertices), 2))
        cos, sin = np.cos(sense * turn), np.sin(sense * turn)
        displacement[second] = tiling.vertices[second] @ np.array([[cos, sin], [-sin, cos]]) - tiling.vertices[second]
        energies.append(system.energies(displacement)["springs"])
    assert (energies[1] - energies[0]) / (2 * turn) == pytest.approx(moment, rel=1e-6)
