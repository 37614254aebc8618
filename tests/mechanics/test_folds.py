"""Folds of a sheet on every rung, against closed forms for panels that are stiff against them."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.results.fields import nodal_energy

RUNGS = ["plate", "paper", "facet", "shell"]
STIFF = kg.Material(E=1e9, nu=0.3)
THICK = 0.02  # panels of length 1 bend ten thousand times less than the folds below turn
SOFT = 0.01


def two_panels(rung: str, **fold: Any) -> tuple[kg.Model, list[kg.Node]]:
    """A strip 2 by 0.5 with a fold across its middle, its first panel held; the nodes of its far end."""
    sheet = kg.Sheet(shapely.box(0, 0, 2, 0.5), folds=kg.Fold([(1, -1), (1, 2)], **fold))
    mesh = sheet.mesh(0.5)
    m = kg.Model.from_mesh(mesh, THICK, STIFF, rung)
    m.add(kg.Fix(m.select(index=np.flatnonzero(mesh.nodes[:, 0] < 1 + 1e-9))))
    return m, m.select(boundary="right")


@pytest.mark.filterwarnings("ignore:bars lose:kirigami.KirigamiWarning")
@pytest.mark.parametrize("stiffness", RUNGS)
def test_moment_of_one_fold(stiffness: str) -> None:
    """Lifted by sin(theta), the far panel of length 1 turns by theta: force = c w theta / cos(theta)."""
    m, end = two_panels(stiffness, stiffness=SOFT)
    m.add(kg.Prescribe(end, z=math.sin(1.0)), kg.Fix(end, "y"))
    res = kg.DisplacementControl(m, targets=[0.5, 1.0]).run()
    theta = np.arcsin(res.lam[1:] * math.sin(1.0))
    assert res.reaction(end, "z")[1:] == pytest.approx(SOFT * 0.5 * theta / np.cos(theta), rel=2e-3)
    stored = np.sum(list(res.energy.values()), axis=0)[-1]
    assert stored == pytest.approx(0.5 * SOFT * 0.5 * 1.0**2, rel=2e-3)


@pytest.mark.parametrize("angle", [0.4, -1.2, 2.5])
@pytest.mark.parametrize("stiffness", RUNGS)
def test_rest_angle_is_where_a_free_fold_comes_to_rest(stiffness: str, angle: float) -> None:
    """A valley (positive) lifts the free panel, a mountain lowers it; nothing but the fold drives the model."""
    m, end = two_panels(stiffness, angle=angle, stiffness=SOFT)
    res = kg.LoadControl(m, targets=[1.0], step=1.0).run()
    place = res.position(end)[-1].mean(axis=0)
    assert place[[0, 2]] == pytest.approx([1 + math.cos(angle), math.sin(angle)], abs=1e-5)
    assert np.sum(list(res.energy.values()), axis=0)[-1] < 1e-6 * SOFT


@pytest.mark.parametrize("stiffness", ["plate", "facet", "shell"])
def test_a_free_fold_is_a_hinge(stiffness: str) -> None:
    """Without stiffness the far panel turns freely."""
    m, end = two_panels(stiffness, stiffness=0.0)
    m.add(kg.Prescribe(end, z=0.5), kg.Fix(end, "y"))
    res = kg.DisplacementControl(m, targets=[1.0]).run()
    assert np.abs(res.reaction(end, "z")[-1]) < 1e-6 * SOFT


def test_usual_stiffness_of_a_fold() -> None:
    """A fold of which nothing is said gives way as a strip a hundred thicknesses wide: D / (100 t)."""
    m, end = two_panels("plate")
    m.add(kg.NodalLoad(end, (0, 0, 1e-3)))
    hinge = max(m.elements, key=lambda e: isinstance(e, kg.BendHinge) and abs(e.j._position[0] - 1) < 1e-9
                and abs(e.k._position[0] - 1) < 1e-9)  # fmt: skip
    length = abs(hinge.j._position[1] - hinge.k._position[1])
    D = STIFF.E * THICK**3 / 12 / (1 - STIFF.nu**2)
    assert hinge.stiffness / length == pytest.approx(D / (100 * THICK), rel=1e-12)


# --------------------------------------------------------------------------------------- Miura-ori

A, B, GAMMA = 1.0, 1.2, math.radians(60)  # straight edges, zigzag edges, the angle between them


def miura(theta: float) -> tuple[float, float, float, float]:
    """Length, height, width and shift of a unit whose facets are inclined by theta (Schenk and Guest 2013)."""
    c, t = math.cos(theta), math.tan(GAMMA)
    root = math.sqrt(1 + (c * t) ** 2)
    return (A * math.sqrt(1 - (math.sin(theta) * math.sin(GAMMA)) ** 2), A * math.sin(theta) * math.sin(GAMMA),
            B * c * t / root, B / root)  # fmt: skip


def unit(theta: float) -> np.ndarray:
    """Vertices (3, 3, 3) of two by two facets: along zigzags, along straight lines, coordinates."""
    length, height, width, shift = miura(theta)
    return np.array([[(i * width, j * length + (i % 2) * shift, (j % 2) * height) for j in range(3)] for i in range(3)])


def dihedral(a: np.ndarray, b: np.ndarray, left: np.ndarray, right: np.ndarray) -> float:
    """Angle between the facets left and right of the way from a to b, positive for a valley seen from +z."""
    along = (b - a) / np.linalg.norm(b - a)
    m, n = np.cross(along, left - a), np.cross(right - a, along)
    return math.atan2(np.dot(np.cross(n, m), along), np.dot(m, n))


def miura_sheet(theta: float) -> kg.Sheet:
    """The flat pattern with the fold angles of the folded unit."""
    flat, folded = unit(0.0), unit(theta)
    folds = []
    for (i, j), (di, dj) in product([(1, 0), (1, 1), (0, 1), (1, 1)], [(0, 1), (1, 0)]):
        if (dj and i == 1) or (di and j == 1):
            k, l = i + di, j + dj
            sides = ((i - dj, j + di), (i + dj, j - di))
            angle = dihedral(folded[i, j], folded[k, l], *(folded[p, q] for p, q in sides))
            fold = kg.Fold(flat[[i, k], [j, l], :2], angle, 1e-4)
            if not any(np.allclose(shapely.get_coordinates(f.line), flat[[i, k], [j, l], :2]) for f in folds):
                folds.append(fold)
    rim = [flat[i, j, :2] for i, j in ((0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
    return kg.Sheet(rim, folds=folds)


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
@pytest.mark.parametrize("stiffness", ["plate", "facet", "shell"])
def test_miura_unit_has_one_way_to_move(stiffness: str) -> None:
    """Folded by its rest angles it has the sizes of the closed form, and then one soft motion, which keeps to it."""
    sheet = miura_sheet(0.7)
    assert len(sheet.folds) == 4
    mesh = sheet.mesh(1.5)
    m = kg.Model.from_mesh(mesh, 0.02, STIFF, stiffness)
    flat = unit(0.0)[..., :2]
    at = [[m.nodes[int(np.argmin(np.linalg.norm(mesh.nodes[:, :2] - flat[i, j], axis=1)))] for j in range(3)]
          for i in range(3)]  # fmt: skip
    m.add(kg.Fix(at[0][0]), kg.Fix(at[2][0], "yz"), kg.Fix(at[0][2], "z"))
    folding = kg.LoadControl(m, targets=[1.0], step=1.0).run()

    def sizes(step: int, res: kg.Results) -> tuple[float, float, float, float]:
        p = np.array([[res.position(node)[step] for node in column] for column in at])
        along, across = p[0, 2] - p[0, 0], p[2, 0] - p[0, 0]
        normal = np.cross(across, along)
        height = abs((p[0, 1] - p[0, 0]) @ normal) / np.linalg.norm(normal)
        shift = (p[1, 0] - p[0, 0]) @ along / np.linalg.norm(along)
        return np.linalg.norm(along) / 2, height, np.linalg.norm(across) / 2, shift

    assert sizes(-1, folding) == pytest.approx(miura(0.7), rel=1e-3)
    if stiffness != "shell":  # whose edges have unknowns of their own
        soft = np.linalg.eigvalsh(kg.System(m).stiffness(folding[-1].u).toarray())[:2]
        assert 0 < 100 * soft[0] < soft[1]
    m.hold(folding[-1])
    m.add(kg.Prescribe(at[2][0], x=float(folding[-1].u[m.index([at[2][0]])[0], 0]) + 0.12))
    opening = kg.DisplacementControl(m, targets=[0.5, 1.0], start=folding[-1]).run()
    widths = []
    for step in (-1, list(opening.lam).index(0.5)):
        length, height, width, shift = sizes(step, opening)
        theta = math.acos(width / shift / math.tan(GAMMA))
        assert (length, height, width, shift) == pytest.approx(miura(theta), rel=2e-3)
        widths.append(width)
    assert widths[0] > widths[1] > miura(0.7)[2]


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
@pytest.mark.parametrize("stiffness", RUNGS)
def test_energy_of_folds_has_its_place_at_their_nodes(stiffness: str) -> None:
    """Shares of the nodes add up to what is stored, and what folds store lies on them."""
    m, end = two_panels(stiffness, stiffness=SOFT)
    m.add(kg.Prescribe(end, z=math.sin(1.0)), kg.Fix(end, "y"))
    res = kg.DisplacementControl(m, targets=[1.0]).run()
    shares = nodal_energy(res, -1)
    assert shares.sum() == pytest.approx(np.sum(list(res.energy.values()), axis=0)[-1])
    assert shares[np.abs(m.mesh.nodes[:, 0] - 1) < 1e-9].sum() > 0.4 * shares.sum()


@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
@pytest.mark.parametrize("stiffness", RUNGS)
def test_folds_are_not_lost_on_the_way_to_other_programs(stiffness: str, tmp_path: Path) -> None:
    """A shell of triangles is smooth where the model is folded: refused, and nothing written."""
    m, _ = two_panels(stiffness)
    for write in (m.to_abaqus, m.to_openseespy):
        with pytest.raises(kg.ModelError, match="1 fold of the sheet would be lost"):
            write(tmp_path / "model.txt")
    assert not list(tmp_path.iterdir())
