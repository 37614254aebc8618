"""What is said of yield: where a sheet is strained beyond it, what cannot be, and what history forbids."""

import pytest
import shapely
from yield_samples import lifted

import kirigami as kg


@pytest.mark.parametrize("rung", ["paper", "plate", "facet", "shell"])
@pytest.mark.parametrize("analysis", [kg.LinearStatic, kg.DisplacementControl])
def test_what_stays_elastic_beyond_its_yield_stress_is_told(rung, analysis):
    def pulled(limit):
        mesh = kg.Sheet(shapely.box(0, 0, 2, 1)).mesh(max_edge=0.5)
        material = kg.Material(1e9, 1 / 3, yield_stress=limit, hardening=None)
        m = kg.Model.from_mesh(mesh, thickness=0.01, material=material, stiffness=rung)
        right = m.select(boundary="right")
        m.add(kg.Fix(m.nodes, "z"), kg.Fix(m.select(boundary="left"), "xy"), kg.Prescribe(right, x=0.004, y=0.0))
        return analysis(m).run()

    over, under = pulled(1e6), pulled(4e6)
    assert [event.kind for event in over.events] == ["beyond yield"]
    assert over.yielded[0] == 0
    assert over.yielded[-1] > 0.9
    assert "strained beyond the yield stress" in over.summary()
    assert not under.events
    assert under.yielded[-1] == 0
    assert "beyond the yield stress" not in under.summary()


def test_flat_facets_say_that_they_stay_elastic():
    with pytest.warns(kg.KirigamiWarning, match="stay elastic"):
        lifted("facet")


def test_what_has_yielded_is_told_once():
    m, _ = lifted()
    results = kg.DisplacementControl(m, targets=[1.0], to=0.8).run()
    assert [event.kind for event in results.events].count("yield") == 1
    assert "has yielded" in results.summary()
    again = kg.DisplacementControl(m, to=1.0, start=results[-1]).run()
    assert "yield" not in [event.kind for event in again.events]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: kg.Material(1e9, yield_stress=-1e6), "yield_stress must be positive"),
        (lambda: kg.Material(1e9, yield_stress=1e6, hardening=[(0.1, 5e5)]), "falls"),
        (lambda: kg.Material(1e9, yield_stress=1e6, hardening=[(0.2, 2e6), (0.1, 3e6)]), "must grow"),
        (lambda: kg.Material(1e9, yield_stress=1e6, hardening=[(0.0, 2e6)]), "must be the same"),
        (lambda: kg.Material(1e9, yield_stress=1e6, hardening=-1.0), "must not be negative"),
        (lambda: kg.Material(1e9, yield_stress=1e6, kinematic=[(0.1, 2e5), (0.2, 1e5)]), "of kinematic: the stress fa"),
        (lambda: kg.Material(1e9, yield_stress=1e6, kinematic=[(0.0, 2e5)]), "the back stress is 0"),
        (lambda: kg.Material(1e9, kinematic=[(0.1, 2e5)]), "needs a yield_stress"),
        (lambda: kg.Material(1e9, hardening=1.0), "needs a yield_stress"),
        (lambda: kg.Laminate([(kg.Material(1e9, yield_stress=1e6), 0.1)]), "stay elastic"),
        (lambda: kg.Bar(kg.Node(0, 0), kg.Node(1, 0), 1.0, yield_force=0.0), "yield_force must be positive"),
        (lambda: kg.Bar(kg.Node(0, 0), kg.Node(1, 0), 1.0, hardening=2.0), "needs a yield_force"),
        (lambda: kg.Bar(kg.Node(0, 0), kg.Node(1, 0), 1.0, law="cable", yield_force=1.0), "cannot yield"),
        (
            lambda: kg.BendHinge(
                *(kg.Node(*at) for at in ((0, 1), (0, 0), (1, 0), (0, -1))), 1.0, target_angle=1.0, yield_moment=1.0
            ),
            "cannot be driven",
        ),
    ],
)  # fmt: skip
def test_bad_input_is_refused_in_words(make, words):
    with pytest.raises(kg.ModelError, match=words):
        make()


def test_rubber_beside_what_yields_is_refused():
    mesh = kg.Sheet(shapely.box(0, 0, 1, 1)).mesh(max_edge=1.0)
    materials = [kg.NeoHookean(1e6) if k else kg.Material(1e9, yield_stress=1e6) for k in range(len(mesh.triangles))]
    with pytest.raises(kg.ModelError, match="cannot be rubber in one place"):
        kg.System(kg.Model.from_mesh(mesh, thickness=0.01, material=materials, stiffness="shell"))


def test_what_history_forbids_is_refused():
    m, right = lifted()
    results = kg.DisplacementControl(m).run()
    with pytest.raises(kg.ModelError, match="depends on the way"):
        results.gradient(("force", right, "z"), "thickness")
    m.add(kg.Actuate([0], strain=(0.1, 0, 0)))
    with pytest.raises(kg.ModelError, match="cannot be driven by Actuate"):
        kg.System(m)
