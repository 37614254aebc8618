"""What the pictures show."""

from __future__ import annotations

import kirigami as kg


def truss() -> tuple[kg.Model, kg.Node, kg.Node]:
    m = kg.Model(dim=2)
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0))
    m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
    m.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
    return m, left, apex


def frame_mesh() -> kg.TriMesh:
    """A square frame of side 3 round a hole of side 1."""
    nodes = [(0, 0), (3, 0), (3, 3), (0, 3), (1, 1), (2, 1), (2, 2), (1, 2)]
    facets = [(0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7)]
    return kg.TriMesh(nodes, facets)


def sheet_model() -> kg.Model:
    """The frame, held at the bottom and pulled up and out of its plane at the top."""
    m = kg.Model.from_mesh(frame_mesh(), thickness=0.1, material=kg.Material(E=1e6))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.Prescribe(top, y=0.3, z=0.6))
    return m
