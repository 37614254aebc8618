"""Nanometres to kilometres, pascals to gigapascals: the same sheet gives the same answer, step for step."""

from __future__ import annotations

import functools

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

import kirigami as kg

Answer = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], list[int]]

# (length factor, modulus factor)
UNITS = [(1e-9, 1.0), (1e-9, 1e9), (1e3, 1.0), (1e6, 1e-9)]


def sheet(s: float) -> kg.TriMesh:
    slits = [[(0.2, 0.45), (0.75, 0.5)], [(0.5, 0.9), (1.0, 0.85)]]
    cuts = [shapely.LineString(s * np.array(slit)) for slit in slits]
    return kg.Sheet(shapely.box(0, 0, s, 1.4 * s), cuts).mesh(0.4 * s, cut_edge=0.25 * s)


@functools.cache
def stretched(s: float, r: float) -> Answer:
    """Load factors, displacements / s, reactions / (r s^2) and work counts of a slit sheet pulled past buckling."""
    m = kg.Model.from_mesh(sheet(s), 3e-3 * s, kg.Material(3.0 * r))
    x, y, _ = m.positions().T / s
    m.perturb(1e-4 * s * np.sin(np.pi * y / 1.4) * (1 + x))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, clamp=True), kg.Fix(top, "xz"), kg.Prescribe(top, y=0.05 * s, clamp=True))
    res = kg.DisplacementControl(m).run()
    counts = [res.stats[name] for name in ("iterations", "factorizations", "steps", "cutbacks")]
    return res.lam, res.u / s, res.reaction(top, "y") / (r * s**2), counts


@pytest.mark.parametrize("s", sorted({s for s, _ in UNITS}))
def test_mesh(s: float) -> None:
    """The same drawing in another unit gives the same triangles."""
    plain, scaled = sheet(1.0), sheet(s)
    assert np.array_equal(scaled.triangles, plain.triangles)
    assert scaled.nodes / s == pytest.approx(plain.nodes, abs=1e-11)


@pytest.mark.parametrize("s, r", UNITS)
def test_sheet_past_buckling(s: float, r: float) -> None:
    plain, scaled = stretched(1.0, 1.0), stretched(s, r)
    assert np.abs(plain[1][-1, :, 2]).max() > 0.03  # it has buckled
    assert scaled[3] == plain[3]
    for one, other in zip(scaled[:3], plain[:3]):
        assert one == pytest.approx(other, rel=1e-6, abs=1e-6 * np.abs(other).max())


@pytest.mark.parametrize("s, r", [(1e-9, 1.0), (1e3, 1e9)])
def test_modes(s: float, r: float) -> None:
    """Eigenvalues (unit masses) times r s."""

    def values(s: float, r: float) -> NDArray[np.float64]:
        m = kg.Model.from_mesh(sheet(s), 3e-3 * s, kg.Material(3.0 * r))
        m.add(kg.Fix(m.select(boundary="bottom"), clamp=True))
        found: NDArray[np.float64] = kg.Eigen(m, n=4).run().values / (r * s)
        return found

    assert values(s, r) == pytest.approx(values(1.0, 1.0), rel=1e-8)


@pytest.mark.parametrize("shift", [1e3, 1e6])
def test_far_from_the_origin(shift: float) -> None:
    """A sheet drawn up to a million times its size away from the origin loses digits of its coordinates only."""
    near = sheet(1.0)
    far = kg.TriMesh(near.nodes + [shift, -shift, 0], near.triangles)

    def stretch(mesh: kg.TriMesh) -> float:
        m = kg.Model.from_mesh(mesh, 3e-3, kg.Material(3.0))
        bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
        m.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.NodalLoad(top, (0, 1e-6)))
        return float(kg.LinearStatic(m).run().u[-1, m.index(top), 1].max())

    assert stretch(far) == pytest.approx(stretch(near), rel=1e-14 * shift + 1e-10)
