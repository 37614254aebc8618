"""Facets ten thousand times longer than high: exact where a closed form holds, refused where nothing is left."""

from __future__ import annotations

import meshes
import numpy as np
import pytest
from meshes import Floats, Ints

import kirigami as kg

ASPECTS = [1e2, 1e4, 1e6]


def flat_cells(columns: int, rows: int, aspect: float) -> tuple[Floats, Ints]:
    """Right triangles of height 1 / aspect."""
    nodes, triangles = meshes.right_isosceles(columns, rows)
    return nodes * [1.0, 1.0 / aspect], triangles


@pytest.mark.parametrize("aspect", ASPECTS)
def test_uniform_strain_stays_uniform(aspect: float) -> None:
    """Every node of a lattice is a centre of symmetry, so an affine state balances on any aspect of its cells.

    The border is moved affinely; the inner nodes follow. Green strains of the affine map are the strains of the bars.
    """
    nodes, triangles = flat_cells(4, 4, aspect)
    model, points = meshes.sheet(nodes, triangles, 1.0, 1.0, bending=0.0)
    strain = np.array([[0.02, 0.0], [0.01 / aspect, 0.01]])
    moved = nodes @ strain.T
    inner = np.array([0 < p.x < 4 and 0 < p.y * aspect < 4 - 1e-9 for p in points])
    border = [p for p, free in zip(points, inner) if not free]
    at = model.index(border)
    model.add(kg.Prescribe(border, x=moved[at, 0], y=moved[at, 1]), kg.Fix(points, "z"))
    result = kg.DisplacementControl(model, tol=1e-10).run()
    error = np.abs(result.u[-1, inner, :2] - moved[inner])
    assert error[:, 0].max() < 1e-9 and error[:, 1].max() < 1e-9 / aspect
    green = 0.5 * (strain + strain.T + strain.T @ strain)
    along = np.array([np.subtract(*(np.array([n.x, n.y]) for n in bar.nodes)) for bar in model.elements])
    expected = np.einsum("na,ab,nb->n", along, green, along) / (along**2).sum(axis=1)
    assert result.bar_strain[-1] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_rows_of_slivers_bend_as_a_cylinder(aspect: float) -> None:
    """Bent about x by a couple, 8 rows of height 1 / aspect turn by M l / (D W) each: the plate's own answer.

    D = c E t^3 exactly for bending along the legs of right triangles (hinge constants c E t^3 L^2 / (A1 + A2)).
    """
    rows, thickness, constant = 8, 1e-2 / aspect, 0.09
    nodes, triangles = flat_cells(2, rows, aspect)
    model, points = meshes.sheet(nodes, triangles, 1.0, thickness, bending=constant)
    lines = [[p for p in points if abs(p.y * aspect - n) < 1e-6] for n in range(rows + 1)]
    model.add(kg.Fix(lines[0] + lines[1]), kg.Fix([p for line in lines[2:] for p in line], "xy"))
    model.add(*(kg.Tie(line[1:], line[0], "z") for line in lines[2:]))
    cell, width = 1.0 / aspect, 2.0
    couple = 1e-3 * constant * thickness**3 * width / cell
    for line, sign in ((lines[-1], 1.0), (lines[-2], -1.0)):
        model.add(kg.NodalLoad(line[0], (0.0, 0.0, sign * couple / cell)))
    result = kg.LinearStatic(model).run()
    deflection = result.u[-1, model.index([line[0] for line in lines[1:]]), 2]
    turn = np.diff(deflection) / cell
    assert np.diff(turn) == pytest.approx(1e-3, rel=1e-6)


@pytest.mark.parametrize("height", [1e-2, 1e-4, 1e-6])
def test_one_sliver_in_a_good_sheet_changes_little(height: float) -> None:
    """A node just off the middle of an edge makes a facet of aspect 1 / height; the sheet pulls as before.

    The slit sheet is stretched far past buckling, so that hinges next to the sliver fold.
    """

    def force(sliver: bool) -> float:
        nodes, triangles = meshes.equilateral_strip(8, 8, 0.125)
        slit = [k for k, p in enumerate(nodes) if abs(p[1] - nodes[:, 1].max() / 2) < 1e-9 and 0.2 < p[0] < 0.8]
        nodes, triangles = meshes.open_slit(nodes, triangles, slit)
        if sliver:
            nodes, triangles = with_sliver(nodes, triangles, height)
        mesh = kg.TriMesh(nodes, triangles)
        model = kg.Model.from_mesh(mesh, 3e-3, kg.Material(1e9))
        x, y, _ = model.positions().T
        model.perturb(1e-4 * np.sin(np.pi * y / y.max()) * (1 + 0.3 * x))
        bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
        model.add(kg.Fix(bottom), kg.Fix(top, "xz"), kg.Prescribe(top, y=0.04))
        result = kg.DisplacementControl(model).run()
        assert result.stable[-1] and result.residual.max() <= 1e-8
        return float(result.reaction(top, "y")[-1])

    assert force(sliver=True) == pytest.approx(force(sliver=False), rel=0.02)


def with_sliver(nodes: Floats, triangles: Ints, height: float) -> tuple[Floats, Ints]:
    """Split the facet in the lower half nearest to the middle by a node close to one of its edges."""
    centre = nodes[triangles].mean(axis=1)
    chosen = int(np.argmin(np.linalg.norm(centre - [0.5, 0.25], axis=1)))
    a, b, c = triangles[chosen]
    middle = 0.5 * (nodes[a] + nodes[b])
    new = middle + height * (nodes[c] - middle)
    p = len(nodes)
    kept = np.delete(triangles, chosen, axis=0)
    return np.vstack([nodes, new]), np.vstack([kept, [(a, b, p), (b, c, p), (c, a, p)]])


def test_a_facet_without_height_is_refused() -> None:
    nodes, triangles = flat_cells(2, 2, 1e13)
    with pytest.raises(kg.GeometryError, match="area"):
        kg.TriMesh(nodes, triangles)
