"""One place of a structure by itself: it is the same as in the whole, and settles first without landing elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import LineString, box

import kirigami as kg
from kirigami.analysis.path import descent
from kirigami.analysis.path.places import LARGEST, place_of
from kirigami.primitives.kernel import Tangent


@pytest.mark.parametrize("stiffness", ["plate", "shell", "facet"])
def test_a_part_answers_as_the_whole_does_there(stiffness: str) -> None:
    """Forces and tangent on its unknowns, also with faded compression and stress ahead, after a history of its own."""
    mesh = kg.Sheet(box(0, 0, 1, 1), [LineString([(0.25, 0.5), (0.75, 0.5)])]).mesh(0.09)
    m = kg.Model.from_mesh(mesh, 1e-2, kg.Material(E=1.0, nu=0.3), stiffness=stiffness)
    m.add(kg.Fix(m.select(boundary="bottom")), kg.NodalLoad(m.select(boundary="top"), (0, 1e-6, 1e-7)))
    m.add(kg.Actuate(strain=(0.01, 0.02, 0.0), curvature=(0.2, 0.1, 0.0)))
    system, rng = kg.System(m), np.random.default_rng(0)
    q, change = 2e-2 * rng.normal(size=(2, system.free))
    u = system.displacement(q, 0.5)
    system.commit(u, 0.5)
    u = system.displacement(q + 0.3 * change, 0.7)
    residual = system.imbalance(u, 0.7)[0]
    middle = np.zeros_like(residual)
    middle[system.free // 2] = 1.0
    place = place_of(system, middle)
    assert place is not None and 10 < len(place) < LARGEST * system.free
    part = system.part(place, u)
    np.testing.assert_allclose(part.displacement(q[place] + 0.3 * change[place], 0.7), u, atol=1e-15)
    np.testing.assert_allclose(part.imbalance(u, 0.7)[0], residual[place], atol=1e-12 * np.abs(residual).max())
    for tangent in (Tangent(), Tangent(0.3), Tangent(0.0, (u, system.displacement(q, 0.7) - u))):
        whole = system.matrix(system.stiffness_blocks(u, 0.7, tangent))[place][:, place].toarray()
        alone = part.matrix(part.stiffness_blocks(u, 0.7, tangent)).toarray()
        np.testing.assert_allclose(alone, whole, atol=1e-12 * np.abs(whole).max())
    moved = part.displacement(q[place], 0.7) - u
    still = np.ones(system.rest.size, dtype=bool)
    still[np.isin(system.unknown, place)] = False
    assert not moved.ravel()[still].any() and moved.any()


def row_of_arches(count: int) -> kg.Model:
    """Shallow arches side by side on one elastic rail, each pulled down through a spring; they snap one by one."""
    m = kg.Model(dim=2)
    rises = np.random.default_rng(1).permutation(np.linspace(0.3, 0.5, count)).tolist()
    for x, rise in zip(range(0, 3 * count, 3), rises):
        left, apex, right = m.add(kg.Node(x - 1, 0), kg.Node(x, rise), kg.Node(x + 1, 0))
        pulled = m.add(kg.Node(x, -2))
        m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0), kg.Bar(apex, pulled, EA=0.02))
        m.add(kg.Fix([left, right], "y"), kg.Fix([apex, pulled], "x"), kg.Prescribe(pulled, y=-3.0))
        m.add(kg.Spring(left, (50.0, 0.0)), kg.Spring(right, (50.0, 0.0)))
    return m


def test_what_settles_in_its_place_first_lands_where_all_together_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same snaps with the same energy, and the same shape, for fewer factors of the whole."""
    first = kg.DisplacementControl(row_of_arches(8)).run()
    monkeypatch.setattr(descent, "place_of", lambda *_: None)
    together = kg.DisplacementControl(row_of_arches(8)).run()
    assert [event.kind for event in first.events] == ["snap"] * 8
    assert len(together.events) == 8
    for one, other in zip(first.events, together.events):
        assert one.bracket == pytest.approx(other.bracket, rel=1e-6)
        assert one.energy == pytest.approx(other.energy, rel=1e-6)
    np.testing.assert_allclose(first.u[-1], together.u[-1], atol=1e-9)
    assert first.stats["factorizations"] < 0.9 * together.stats["factorizations"]
