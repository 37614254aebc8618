"""Periodic cells of sheets stated differently: the same law, section, waves and energy, in other axes and units.

A file of their own, since most of the matrix asks for supports that a cell has not.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from changes import CHANGES, Change
from structures import SAME, cell

import kirigami as kg

RUNGS = ("plate", pytest.param("facet", marks=pytest.mark.long), "shell")
FLAT = [name for name, change in CHANGES.items() if change.flat]  # a cell lies in the plane of its lattice
PHASES = np.array([0.7, -0.4])


@cache
def told(rung: str, name: str) -> tuple[kg.PeriodicCell, kg.Results]:
    one = cell(rung, CHANGES.get(name, SAME))
    return one, kg.DisplacementControl(one.model, targets=[0.5, 1.0], tol=1e-10).run()


def tensors(values: np.ndarray, shear: float) -> np.ndarray:
    """Tensors (..., 2, 2) of three components (..., 3), the last of which counts `shear` times."""
    xx, yy, xy = np.moveaxis(values, -1, 0)
    return np.moveaxis(np.array([[xx, xy / shear], [xy / shear, yy]]), (0, 1), (-2, -1))


def turned(tensor: np.ndarray, change: Change) -> np.ndarray:
    turn = change.turn[:2, :2]
    return turn @ tensor @ turn.T


@pytest.mark.parametrize("name", FLAT)
@pytest.mark.parametrize("rung", RUNGS)
def test_another_statement_of_a_cell_gives_the_same_law(rung: str, name: str) -> None:
    change = CHANGES[name]
    (_, plain), (one, res) = told(rung, ""), told(rung, name)
    before, after = told(rung, "")[0].law(plain), one.law(res)
    at, there = (int(np.argmin(np.abs(r.lam - 1.0))) for r in (plain, res))
    strain = turned(tensors(before.strain[at], 2.0), change)
    stress = change.force / change.length * turned(tensors(before.stress[at], 1.0), change)
    assert tensors(after.strain[there], 2.0) == pytest.approx(strain, rel=1e-5, abs=1e-8)
    assert tensors(after.stress[there], 1.0) == pytest.approx(stress, rel=1e-5, abs=1e-6 * np.abs(stress).max())
    per_area = change.force / change.length
    assert after.energy[there] == pytest.approx(per_area * before.energy[at], rel=1e-6)
    assert after.poisson[there] == pytest.approx(before.poisson[at], rel=1e-5)


@pytest.mark.parametrize("name", FLAT)
@pytest.mark.parametrize("rung", RUNGS)
def test_another_statement_of_a_cell_gives_the_same_section_and_waves(rung: str, name: str) -> None:
    change = CHANGES[name]
    (plain, start), (one, res) = told(rung, ""), told(rung, name)
    at, there = (r[int(np.argmin(np.abs(r.lam - 1.0)))] for r in (start, res))
    # lattice vectors are taken over with the change, so phases along them stay
    assert one.waves(PHASES, there) == pytest.approx(plain.waves(PHASES, at), rel=1e-4, abs=1e-6)
    membrane, bending = change.force / change.length, change.force * change.length
    for part, size in ((slice(0, 3), membrane), (slice(3, 6), bending)):
        before, after = (np.linalg.eigvalsh(_in_mandel(c.section()[part, part])) for c in (plain, one))
        assert after == pytest.approx(size * before, rel=1e-7)


def _in_mandel(matrix: np.ndarray) -> np.ndarray:
    """A matrix of engineering components in axes in which a turn is one of space: eigenvalues do not change."""
    weight = np.array([1.0, 1.0, np.sqrt(2.0)])
    return matrix * np.outer(weight, weight)


@pytest.mark.parametrize("rung", RUNGS)
def test_results_of_a_cell_are_read_back(rung: str, tmp_path: Path) -> None:
    one, res = told(rung, "")
    read = kg.load(res.save(tmp_path / "cell.npz"))
    before, after = one.law(res), one.law(read)
    assert after.stress == pytest.approx(before.stress, rel=1e-12, abs=1e-12)
    assert after.strain == pytest.approx(before.strain, rel=1e-12, abs=1e-12)
    assert after.energy == pytest.approx(before.energy, rel=1e-12)
    assert one.waves(PHASES, read[-1]) == pytest.approx(one.waves(PHASES, res[-1]), rel=1e-9)
