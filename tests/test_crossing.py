"""A sheet that passes through itself is told, where somebody can look; slits at rest do not."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.post import crossing
from kirigami.post.crossing import crossings
from kirigami.results.crossing import note_crossings
from kirigami.results.results import Results

pytest.importorskip("ipctk")


def strip(columns: int = 12, length: float = 1.0, width: float = 0.2) -> kg.TriMesh:
    along, across = np.linspace(0, length, columns + 1), (0.0, width)
    nodes = np.array([(x, y) for x in along for y in across])
    first = 2 * np.arange(columns)[:, None]
    return kg.TriMesh(nodes, np.concatenate([first + (0, 2, 1), first + (1, 2, 3)]))


def rolled(mesh: kg.TriMesh, radius: float) -> np.ndarray:
    """Displacements that roll a strip up on a circle: over 2 pi r it lies in itself, and grows outwards a little."""
    x, y = mesh.nodes[:, 0], mesh.nodes[:, 1]
    out = radius * (1 + 0.3 * y / y.max() * np.sign(x - 0.5))
    return np.column_stack([out * np.sin(x / radius) - x, 0 * x, out * (1 - np.cos(x / radius)) - radius * 0])


def held(mesh: kg.TriMesh) -> kg.Model:
    m = kg.Model.from_mesh(mesh, thickness=1e-3, material=kg.Material(1e9))
    m.add(kg.Fix(m.nodes, "xyz"))
    return m


def test_two_triangles_that_pierce_each_other_are_found_where_they_do():
    x = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.2, 0.2, -1), (0.2, 0.2, 1), (3, 3, 0)], dtype=float)
    triangles = np.array([(0, 1, 2), (3, 4, 5)])
    edges = np.array([(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3)])
    places = crossings(x, edges, triangles)
    assert any(np.allclose(place, (0.2, 0.2, 0)) for place in places)
    x[3:, 2] += 1.5  # lifted off
    assert not len(crossings(x, edges, triangles))


@pytest.mark.parametrize("scale", [1.0, 1e3])
@pytest.mark.parametrize("shape", ["flat", "cylinder"])
def test_slits_at_rest_and_bent_with_closed_lips_are_no_crossing(scale, shape):
    slits = list(kg.cuts.parallel_slits(columns=1, rows=3, width=0.1, height=0.08, length=0.075, margin=0.02))
    mesh = kg.Sheet(shapely.box(0, 0, 0.1, 0.1), slits).mesh(nodes=400)
    x = np.column_stack([mesh.nodes[:, :2], np.zeros(len(mesh.nodes))])
    if shape == "cylinder":
        x = np.column_stack([0.05 * np.sin(x[:, 0] / 0.05), x[:, 1], 0.05 * (1 - np.cos(x[:, 0] / 0.05))])
    assert not len(crossings(scale * x, mesh.edges, mesh.triangles))
    rng = np.random.default_rng(1)
    assert not len(crossings(scale * (x + 1e-9 * rng.normal(size=x.shape)), mesh.edges, mesh.triangles))


def test_stored_steps_in_which_a_strip_crosses_itself_are_one_event():
    mesh = strip(60)
    m = held(mesh)
    results = Results(kg.System(m))
    turns = (0.4, 0.9, 1.6, 1.8, 0.9)
    for number, turn in enumerate(turns):
        results.append(replace(kg.Step.at(m, float(number), rolled(mesh, 1.0 / (2 * np.pi * turn))), residual=0.0))
    note_crossings(results)
    told = [event for event in results.events if event.kind == "crossing"]
    assert len(told) == 1 and told[0].bracket == (2.0, 3.0) and told[0].step == 2
    assert "passes through itself" in results.summary()
    note_crossings(results)
    assert len([event for event in results.events if event.kind == "crossing"]) == 1


def test_where_nobody_can_look_it_is_said(monkeypatch):
    mesh = strip(60)
    m = held(mesh)
    results = Results(kg.System(m))
    results.append(replace(kg.Step.at(m, 0.0, rolled(mesh, 0.5)), residual=0.0))
    monkeypatch.setattr("kirigami.post.crossing.can_search", lambda: False)
    note_crossings(results)
    assert "not checked" in results.summary() and "kirigami-mechanics[contact]" in results.summary()
    monkeypatch.setattr(crossing, "can_search", lambda: False)
    with pytest.raises(kg.errors.AnalysisError, match="pip install"):
        crossings(results.rest, mesh.edges, mesh.triangles)


def test_a_run_that_pushes_a_strip_through_itself_says_so():
    """Clamped ends pushed together beyond 0.849 of the length: the legs of the loop cross."""
    mesh = strip(24)
    m = kg.Model.from_mesh(mesh, thickness=2e-3, material=kg.Material(1e9, 0.0))
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, clamp=True), kg.Fix(right, "yz", clamp=True), kg.Prescribe(right, x=-1.0))
    m.perturb(4e-3 * np.sin(np.pi * mesh.nodes[:, 0]) ** 2)
    res = kg.DisplacementControl(m, to=0.95, corrector="newton").run(on_failure="return")
    told = [event for event in res.events if event.kind == "crossing"]
    assert told and 0.849 < told[0].lam <= 0.95


def test_parts_that_are_mirror_images_cross_on_the_rims_of_their_facets() -> None:
    """Every edge of one meets the other just where two facets join, or at its rim."""
    x = np.array([(0, 0, 0.0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])
    one, other = x.copy(), x.copy()
    one[:, 2], other[:, 2] = x[:, 0] - 0.5, 0.5 - x[:, 0]
    triangles = np.array([(0, 1, 3), (0, 3, 2)])
    mesh = kg.TriMesh(np.concatenate([one, other]), np.concatenate([triangles, triangles + 4]))
    found = crossings(mesh.nodes, mesh.edges, mesh.triangles)
    assert len(found) and np.abs(found[:, [0, 2]] - [0.5, 0.0]).max() < 1e-12
    apart = mesh.nodes + np.where(np.arange(8)[:, None] < 4, 0.0, [0.0, 1.5, 0.0])
    assert not len(crossings(apart, mesh.edges, mesh.triangles))
