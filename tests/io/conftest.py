"""Small results and sheets that several tests of reading and writing share."""

from __future__ import annotations

import numpy as np
import pytest

import kirigami as kg


def rectangle_mesh(columns: int, rows: int, width: float = 1.0, height: float = 1.0) -> kg.TriMesh:
    """Squares cut by diagonals that change direction from square to square."""
    x, y = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1))
    index = np.arange(x.size).reshape(x.shape)
    facets = []
    for j in range(rows):
        for i in range(columns):
            a, b, c, d = index[j, i], index[j, i + 1], index[j + 1, i + 1], index[j + 1, i]
            facets += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
    return kg.TriMesh(np.column_stack([x.ravel(), y.ravel()]), np.array(facets))


@pytest.fixture(scope="session")
def strip() -> kg.Results:
    """A clamped strip, its free end lifted: large rotations, several steps, a mesh."""
    m = kg.Model.from_mesh(rectangle_mesh(8, 2, 4.0, 1.0), 0.05, kg.Material(E=1e6, nu=0.3))
    m.name = "strip"
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Prescribe(m.select(boundary="right"), z=1.5))
    return kg.DisplacementControl(m, targets=[0.25, 0.5, 1.0]).run()


@pytest.fixture(scope="session")
def truss() -> kg.Results:
    """The von Mises truss past both limit points: no mesh, two dimensions, a load factor that turns back."""
    m = kg.Model(dim=2, name="truss")
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 0.5), kg.Node(1, 0))
    m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0), kg.Fix([left, right]))
    m.add(kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
    return kg.DisplacementControl(m, to=-1.1, control=(apex, "y"), step=-0.05).run()


@pytest.fixture(scope="session")
def folded() -> kg.Results:
    """A sheet with a crease down its middle that wants to fold, clamped at one side, the other side lifted."""
    mesh = rectangle_mesh(4, 2, 2.0, 1.0)
    m = kg.Model.from_mesh(mesh, 0.05, kg.Material(E=1e6, nu=0.3), stiffness="shell")
    m.name = "folded"
    m.add(kg.Crease(m.select(where=lambda x, y, z: x == 1), stiffness=1.0, rest_angle=1.0))
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Prescribe(m.select(boundary="right"), z=0.5))
    return kg.DisplacementControl(m, targets=[0.5, 1.0]).run()
