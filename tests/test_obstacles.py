"""Fixed surfaces given as meshes: a beam on a wedge, a sheet on a ball, and what is refused."""

import numpy as np
import pytest
from test_self_contact import PET, grid

import kirigami as kg

pytest.importorskip("ipctk")
pytestmark = pytest.mark.filterwarnings("ignore:the mesh is biased")


def ball(radius: float, count: int) -> kg.TriMesh:
    """An octahedron whose facets are split `count` times each way, its nodes on a sphere about the origin."""
    corners = np.array([(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], dtype=float)
    nodes: dict[tuple[float, ...], int] = {}
    triangles = []

    def number(a: np.ndarray, b: np.ndarray, c: np.ndarray, i: int, j: int) -> int:
        point = (a * (count - i - j) + b * i + c * j) / count
        place = radius * point / np.linalg.norm(point)
        return nodes.setdefault(tuple((np.round(place, 12) + 0.0).tolist()), len(nodes))

    for k in range(4):
        for top in (4, 5):
            a, b, c = corners[[k, (k + 1) % 4, top]]
            for i in range(count):
                for j in range(count - i):
                    triangles.append([number(a, b, c, *at) for at in ((i, j), (i + 1, j), (i, j + 1))])
                    if i + j < count - 1:
                        triangles.append([number(a, b, c, *at) for at in ((i + 1, j), (i + 1, j + 1), (i, j + 1))])
    return kg.TriMesh(np.array(list(nodes)), np.array(triangles))


def test_a_beam_on_a_wedge_bends_as_three_forces_bend_it():
    """A strip on two supports is moved down on the ridge of a wedge: P = 48 E I w / L^3."""
    length, width, t = 1.0, 0.1, 0.01
    nodes, facets = grid(20, 1, length, width)
    m = kg.Model.from_mesh(kg.TriMesh(nodes, facets), thickness=t, material=PET, stiffness="shell")
    ridge = [(0.5, -1.0, -0.02), (0.5, 1.0, -0.02)]
    feet = [(0.3, -1.0, -1), (0.3, 1.0, -1), (0.7, -1.0, -1), (0.7, 1.0, -1)]
    wedge = kg.TriMesh(np.array(ridge + feet), np.array([(0, 1, 2), (1, 3, 2), (0, 4, 1), (1, 4, 5)]))
    ends = [*m.select(boundary="left"), *m.select(boundary="right")]
    down = 0.015
    m.add(kg.Fix(m.select(boundary="left"), "xy"), kg.Fix(m.select(boundary="right"), "y"), kg.Prescribe(ends, z=-down))
    m.add(kg.SelfContact(layer=1e-3, obstacles=[wedge]))
    res = kg.DisplacementControl(m).run()
    force = res.force("self-contact")[-1]
    middle = res[-1].u[np.abs(nodes[:, 0] - 0.5) < 1e-9, 2].mean()
    deflection = down + middle
    load = force[:, 2].sum()
    assert 0.3 * down < deflection < down
    assert load == pytest.approx(48 * PET.E * width * t**3 / 12 * deflection / length**3, rel=0.01)
    assert np.abs(force[:, :2].sum(axis=0)).max() < 0.02 * load
    assert res.reaction(ends, "z")[-1] == pytest.approx(-load, rel=1e-8)
    assert -0.02 + 0.009 < middle < -0.02 + 0.010 + 1e-9  # it lies in the layer below the thickness
    assert [event.kind for event in res.events if event.kind in ("contact", "crossing")] == ["contact"]


@pytest.mark.long
def test_a_mesh_of_a_ball_does_what_the_ball_does():
    """Between a ball inside the facets, and one as much larger as the sheet's own facets cut into it."""
    radius, t, layer, parts, rows = 1.0, 0.02, 0.001, 30, 10
    nodes, facets = grid(rows, rows, 1.0, 1.0)
    nodes[:, :2] -= 0.5
    solid = ball(radius, parts)
    inside = np.linalg.norm(solid.nodes[solid.triangles].mean(axis=1), axis=1).min()
    near = solid.triangles[(solid.nodes[solid.triangles, 2].min(axis=1) > 0.7)]
    below = radius + 0.025

    def pushed(*effects: kg.ModelObject) -> float:
        high = nodes + [0, 0, below]
        m = kg.Model.from_mesh(kg.TriMesh(high, facets), thickness=t, material=PET, stiffness="facet")
        rim = [node for node in m.nodes if max(abs(node.x), abs(node.y)) > 0.49]
        m.add(kg.Fix(rim, "xy"), kg.Prescribe(rim, z=-0.12))
        for effect in effects:
            m.add(effect if isinstance(effect, kg.SelfContact) else kg.Contact(m.nodes, effect))
        return -float(kg.DisplacementControl(m).run().reaction(rim, "z")[-1])

    used, corners = np.unique(near, return_inverse=True)
    cap = kg.TriMesh(solid.nodes[used], corners.reshape(-1, 3))
    found = pushed(kg.SelfContact(layer=layer, obstacles=[cap]))
    edge = np.sqrt(2) / rows
    largest = radius + edge**2 / (8 * radius)
    bounds = [pushed(kg.Sphere((0, 0, 0), size + t)) for size in (inside - layer, largest)]
    assert bounds[0] < found < bounds[1] < 1.2 * bounds[0]


def test_what_is_no_obstacle_is_refused():
    nodes, facets = grid(2, 2, 1.0, 1.0)
    with pytest.raises(kg.ModelError, match="obstacles"):
        kg.SelfContact(obstacles=[nodes])
    wall = kg.TriMesh(np.array([(0.4, 0.4, -1), (0.4, 0.4, 1), (0.6, 0.7, 0.5)]), np.array([(0, 1, 2)]))
    m = kg.Model.from_mesh(kg.TriMesh(nodes, facets), thickness=0.01, material=PET)
    m.add(kg.SelfContact(obstacles=[wall]))
    with pytest.raises(kg.ModelError, match="crosses itself or an obstacle"):
        kg.System(m)
