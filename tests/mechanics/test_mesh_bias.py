"""What a mesh does to bars, hinges and flat facets is known and told, whatever the mesh and wherever it lies."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

import kirigami as kg
from kirigami.elements.mesh_bias import MeshBias
from kirigami.results.doubts import doubts

NU = 0.3
STEEL = kg.Material(E=1e6, nu=NU)


def squares(n: int, pattern: str, aspect: float = 1.0) -> kg.TriMesh:
    """Rectangles with one diagonal each, all alike ("single") or turned about from one to the next ("alternate")."""
    nodes = [(aspect * i, j) for j in range(n + 1) for i in range(n + 1)]
    facets = []
    for j in range(n):
        for i in range(n):
            a, b = (n + 1) * j + i, (n + 1) * j + i + 1
            c, d = a + n + 1, b + n + 1
            falling = pattern == "alternate" and (i + j) % 2
            facets += [(a, b, c), (b, d, c)] if falling else [(a, b, d), (a, d, c)]
    return kg.TriMesh(nodes, facets)


def meshed(width: float, length: float, edge: float) -> kg.TriMesh:
    return kg.Sheet(shapely.box(0, 0, width, length)).mesh(edge)


def rolled(mesh: kg.TriMesh) -> kg.TriMesh:
    """Round an axis along y, to a full turn less the width of a slit."""
    x, y, _ = mesh.nodes.T
    radius = np.ptp(x) / 6.2
    return kg.TriMesh(np.column_stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)]), mesh.triangles)


def turned(mesh: kg.TriMesh, seed: int = 0) -> kg.TriMesh:
    rotation: NDArray[np.float64] = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    rotation[:, 0] *= np.linalg.det(rotation)
    return kg.TriMesh(mesh.nodes @ rotation.T + 3, mesh.triangles)


MEASURES = ("edges", "stretching", "shear", "bending", "twisting", "facet_bending", "facet_twisting")


def told(mesh: kg.TriMesh, rung: str, dim: int = 3) -> list[str]:
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        kg.Model.from_mesh(mesh, 0.01, STEEL, stiffness=rung, dim=dim)
    ours = [w for w in said if issubclass(w.category, kg.KirigamiWarning)]
    assert all(w.filename == __file__ for w in ours)  # the line of the script that made the model
    return [str(w.message) for w in ours]


@pytest.mark.parametrize("pattern", ["single", "alternate"])
def test_on_a_pattern_the_closed_form_is_what_the_mesh_represents(pattern: str) -> None:
    """No node gives way there, so that the relaxed constants of the report are those before."""
    mesh = squares(16, pattern)
    bias = MeshBias(mesh, NU)
    bars, facets = (kg.stiffness.report(mesh, 0.01, STEEL, rung).ratios for rung in ("plate", "facet"))
    G = 1 / (2 * (1 + NU))
    np.testing.assert_allclose(bias.stretching, bars["E"][1:], rtol=5e-3)
    np.testing.assert_allclose(np.array(bias.shear) * 3 / 8, np.array(bars["G"][1:]) * G, rtol=3e-2)
    np.testing.assert_allclose(bias.facet_bending, facets["bending"][1:], rtol=1e-6)
    np.testing.assert_allclose(bias.facet_twisting, facets["twisting"][1:], rtol=1e-6)
    np.testing.assert_allclose(bias.bending, bars["bending"][1:], atol=0.15)  # alternating hinges give way a little
    if pattern == "single":
        np.testing.assert_allclose(bias.stretching, (1 / 3, 4 / 3), rtol=5e-3)  # in the limit of many squares
        np.testing.assert_allclose(bias.edges, (4 / 9, 4 / 3), rtol=5e-3)
        np.testing.assert_allclose(bias.bending, (3 / 4, 3), rtol=5e-3)


def test_equilateral_facets_have_no_bias() -> None:
    height = np.sqrt(3) / 2
    nodes = [(i + 0.5 * j, j * height) for j in range(9) for i in range(9)]
    facets = [t for j in range(8) for i in range(8) for t in _pair(9 * j + i, 9)]
    bias = MeshBias(kg.TriMesh(nodes, facets), NU)
    for name in MEASURES:
        if name not in ("bending", "twisting"):  # hinges of the rim have less than their share
            np.testing.assert_allclose(getattr(bias, name), 1.0, rtol=1e-9, err_msg=name)
    np.testing.assert_allclose(bias.free_stretching, 1.0, rtol=1e-9)


def _pair(a: int, row: int) -> list[tuple[int, int, int]]:
    return [(a, a + 1, a + row), (a + 1, a + row + 1, a + row)]


@pytest.mark.parametrize(
    "make", [lambda: squares(12, "single"), lambda: squares(12, "alternate"), lambda: meshed(1, 1, 0.06)], ids="sam"
)
def test_bias_does_not_know_where_the_sheet_lies(make) -> None:
    """Turned in space the same, as far as directions are sampled; rolled up to the square of the fold angles."""
    flat = make()
    for name in MEASURES:
        here = getattr(MeshBias(flat, NU), name)
        np.testing.assert_allclose(getattr(MeshBias(turned(flat), NU), name), here, rtol=3e-3, err_msg=name)
        np.testing.assert_allclose(getattr(MeshBias(rolled(flat), NU), name), here, rtol=0.1, err_msg=name)
        around = getattr(MeshBias(turned(rolled(flat)), NU), name)
        np.testing.assert_allclose(around, getattr(MeshBias(rolled(flat), NU), name), rtol=3e-3, err_msg=name)


@pytest.mark.parametrize(
    "size", [(0.06, 0.1, 0.012), (0.06, 0.1, 0.006), (0.1, 0.2, 0.01), (1, 0.2, 0.07), (1, 0.2, 0.03)], ids=str
)
def test_loss_at_free_edges_is_that_of_a_plain_pull(size: tuple[float, float, float]) -> None:
    """Force of a strip that is pulled between smooth grips over E t W strain, against the prediction along the pull."""
    mesh = meshed(*size)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        m = kg.Model.from_mesh(mesh, 1e-4, kg.Material(E=3.5e9, nu=1 / 3))
        report = kg.stiffness.report(mesh, 1e-4, kg.Material(E=3.5e9, nu=1 / 3))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, "yz"), kg.Fix(bottom[0], "x"), kg.Fix(top, "z"), kg.Prescribe(top, y=1e-4 * size[1]))
    results = kg.LinearStatic(m).run()
    pulled = results.reaction(top, "y")[-1] / (3.5e9 * 1e-4 * size[0] * 1e-4)
    assert report.free is not None
    predicted = 1 / (report.free[1, 1] * 3.5e9 * 1e-4)
    assert predicted == pytest.approx(pulled, abs=0.015)
    assert report.free_stretching is not None and "edges are free" in str(report)
    low, high = report.free_stretching[1:]
    assert low - 1e-6 <= predicted <= high + 1e-6
    told_of = [words for words in doubts(results) if "free edges" in words]
    assert bool(told_of) == (low < 0.9) and all(f"{low:.2f} to" in text for text in told_of)
    assert kg.stiffness.report(mesh, 1e-4, STEEL, "facet").free_stretching is None and not told(mesh, "facet")


@pytest.mark.parametrize("where", ["flat", "turned", "rolled"])
def test_patterns_are_warned_of_wherever_they_lie(where: str) -> None:
    place = {"flat": lambda m: m, "turned": turned, "rolled": rolled}[where]
    for mesh in (squares(12, "single"), squares(12, "alternate"), squares(12, "alternate", 3.0)):
        assert "biased" in told(place(mesh), "plate")[0]
        assert "biased" in told(place(mesh), "paper")[0]
    for mesh in (squares(12, "alternate"), squares(12, "alternate", 3.0)):
        (text,) = told(place(mesh), "facet")
        assert "flat facets" in text and "twisting" in text
    assert not told(place(squares(12, "single")), "facet")  # on which flat facets are right
    fine = meshed(1, 1, 0.05)
    for rung in kg.stiffness.RUNGS:
        assert not told(place(fine), rung)
        if rung == "shell":
            assert not told(place(squares(12, "alternate")), rung)


def test_in_a_plane_bars_alone_count() -> None:
    assert "biased" in told(squares(12, "alternate"), "plate", dim=2)[0]
    assert not told(squares(12, "alternate"), "facet", dim=2)
