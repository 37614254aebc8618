"""A model knows its objects by identity: each is in it once, an edit is made whole or not at all, a copy is a copy."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.effects.angle_limit import AngleLimit
from kirigami.effects.contact import Contact, Plane

RUNGS = ("plate", "facet", "shell")
COPIES: dict[str, Callable[[kg.Model], kg.Model]] = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda model: pickle.loads(pickle.dumps(model)),
}


def rod() -> tuple[kg.Model, kg.Node, kg.Node]:
    """A bar of stiffness 10 between two nodes, pulled with a force of 1: it stretches by 0.1."""
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, 10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    return m, a, b


def stretch(model: kg.Model) -> float:
    return float(kg.LinearStatic(model).run().u[-1, 1, 0])


def sheet(rung: str = "plate") -> kg.Model:
    mesh = kg.Sheet(shapely.box(0, 0, 1, 0.3)).mesh(0.2)
    m = kg.Model.from_mesh(mesh, 0.01, kg.Material(E=1e9), stiffness=rung)
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.NodalLoad(m.select(boundary="right"), (0, 0, 1)))
    return m


def one_of_each() -> tuple[kg.Model, dict[str, Any]]:
    m = kg.Model(dim=2)
    a, b, c = m.add(kg.Node(0, 1), kg.Node(0, 0), kg.Node(1, 0))
    objects = {
        "node": a,
        "bar": kg.Bar(a, b, 10.0),
        "spring": kg.TorsionSpring3(a, b, c, 1.0),
        "fix": kg.Fix([b, c]),
        "prescribe": kg.Prescribe(a, x=0.1),
        "load": kg.NodalLoad(a, (0, 1)),
        "limit": AngleLimit(a, b, c, stiffness=1.0, minimum=0.5),
        "contact": Contact(a, Plane((0, -5), (0, 1))),
    }
    m.add(*list(objects.values())[1:])
    return m, objects


# ---- in once


@pytest.mark.parametrize("kind", list(one_of_each()[1]))
def test_nothing_is_added_twice(kind: str) -> None:
    m, objects = one_of_each()
    before, version = m.objects, m.version
    with pytest.raises(kg.ModelError, match="already in the model"):
        m.add(objects[kind])
    assert m.objects == before and m.version == version


def test_nothing_is_listed_twice() -> None:
    m, _, b = rod()
    load = kg.NodalLoad(b, (1, 0))
    node = kg.Node(3, 3)
    for item in (load, node):
        with pytest.raises(kg.ModelError, match="listed twice"):
            m.add(item, item)
        assert m.version == 2
    with pytest.raises(kg.ModelError, match="listed twice"):
        m.remove(m.loads[0], m.loads[0])
    assert stretch(m) == pytest.approx(0.1, rel=1e-12)


def test_no_node_is_listed_twice() -> None:
    """A force on a node that is named twice would act twice, a contact be twice as stiff, a reaction count twice."""
    m, a, b = rod()
    for make in (lambda: kg.NodalLoad([a, b, a], (1, 0)), lambda: kg.Contact([b, b], kg.Plane((5, 0), (-1, 0)))):
        with pytest.raises(kg.ModelError, match="listed twice"):
            make()
    for item in (kg.Fix([b, b], "x"), kg.Prescribe([b, b], x=1.0), kg.Tie([b, b], a, "x")):
        m.add(item)
        with pytest.raises(kg.ModelError, match="twice"):
            kg.System(m)
        m.remove(item)
    res = kg.LinearStatic(m).run()
    assert res.reaction([a, a], "x")[-1] == res.reaction(a, "x")[-1] == pytest.approx(-1, rel=1e-12)


def test_what_was_removed_can_come_back() -> None:
    m, _, _ = rod()
    load = m.loads[0]
    m.remove(load)
    m.add(load)
    assert stretch(m) == pytest.approx(0.1, rel=1e-12)


def test_a_node_has_one_model() -> None:
    m, a, b = rod()
    other = kg.Model(dim=2)
    with pytest.raises(kg.ModelError, match="another model"):
        other.add(a)
    with pytest.raises(kg.ModelError, match="another model"):
        other.add(kg.Bar(a, b, 1.0))
    with pytest.raises(kg.ModelError, match="another model"):
        other.index(a)
    assert not other.nodes and other.version == 0 and a.model is m


# ---- all or nothing


@pytest.mark.parametrize("bad", ["oops", [1], kg.Bar(kg.Node(0, 0), kg.Node(1, 0), 1.0), None])
def test_an_add_that_fails_adds_nothing(bad: Any) -> None:
    m, _, b = rod()
    system, version = kg.System(m), m.version
    with pytest.raises(kg.ModelError):
        m.add(kg.Node(5, 5), kg.NodalLoad(b, (9, 0)), bad)
    assert m.version == version and len(m.nodes) == 2 and len(m.loads) == 1
    system.check_version()
    assert stretch(m) == pytest.approx(0.1, rel=1e-12)


def test_a_removal_that_fails_removes_nothing() -> None:
    m, a, b = rod()
    version, objects = m.version, m.objects
    for bad in (kg.Bar(a, b, 2.0), a, "oops"):
        with pytest.raises(kg.ModelError):
            m.remove(m.elements[0], bad)  # type: ignore[arg-type]
    assert m.objects == objects and m.version == version


def test_what_is_added_in_one_call_may_use_each_other() -> None:
    m = kg.Model(dim=2)
    a, b = kg.Node(0, 0), kg.Node(1, 0)
    m.add(a, b, kg.Bar(a, b, 10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    assert stretch(m) == pytest.approx(0.1, rel=1e-12)


# ---- edits are counted


@pytest.mark.parametrize("name", ["nodes", "elements", "constraints", "loads", "effects", "objects"])
def test_lists_that_are_handed_out_cannot_be_edited(name: str) -> None:
    m, objects = one_of_each()
    handed = getattr(m, name)
    assert len(handed) > 0
    with pytest.raises((AttributeError, TypeError)):
        handed.append(objects["bar"])
    with pytest.raises(TypeError):
        handed[0] = objects["bar"]


def test_values_of_a_constraint_cannot_be_edited() -> None:
    m, _, b = rod()
    for item in (kg.Prescribe(b, x=0.1), kg.Fix(b, "x"), kg.Tie(b, m.nodes[0], "x", x=0.2)):
        for kept in (item, copy.deepcopy(item), pickle.loads(pickle.dumps(item))):
            with pytest.raises(ValueError, match="read-only"):
                kept.values["x"][0] = 7.0
            with pytest.raises(TypeError):
                kept.values["x"] = np.array([7.0])
            assert kept.values["x"][0] in (0.1, 0.0, 0.2)


@pytest.mark.parametrize("name", ["mesh", "dim", "sheet_constants"])
def test_what_the_elements_were_made_from_cannot_be_replaced(name: str) -> None:
    with pytest.raises(AttributeError):
        setattr(sheet(), name, None)


@pytest.mark.parametrize("edit", ["add", "remove", "hold", "perturb"])
def test_every_edit_makes_a_system_stale(edit: str) -> None:
    m, _, b = rod()
    step = kg.LoadControl(m).run()[-1]
    system = kg.System(m)
    {
        "add": lambda: m.add(kg.NodalLoad(b, (1, 0))),
        "remove": lambda: m.remove(m.loads[0]),
        "hold": lambda: m.hold(step),
        "perturb": lambda: m.perturb([[0, 0], [0.1, 0]]),
    }[edit]()
    still = np.zeros((2, 3))
    calls: list[Callable[[], Any]] = [
        system.stiffness,
        system.check_version,
        system.check_supports,
        lambda: system.gradient(still),
        lambda: system.forces(still, 0.0),
        lambda: system.energies(still),
        lambda: system.imbalance(still, 0.0),
        lambda: system.stiffness_blocks(still, 0.0),
        lambda: system.potential_rate(still, 0.0),
        lambda: system.commit(still),
    ]
    for call in calls:
        with pytest.raises(kg.ModelError, match="edited"):
            call()


def test_an_edit_in_the_middle_of_a_run_is_refused() -> None:
    m, _, b = rod()

    def stop(step: kg.Step) -> bool:
        m.add(kg.NodalLoad(b, (1, 0)))
        return False

    with pytest.raises(kg.ModelError, match="edited"):
        kg.ArcLength(m, step=0.05, stop=stop, max_steps=5).run()


# ---- copies


@pytest.mark.parametrize("how", list(COPIES))
def test_a_copy_is_a_copy(how: str) -> None:
    m, _, _ = rod()
    other = COPIES[how](m)
    assert stretch(other) == pytest.approx(0.1, rel=1e-12)
    other.add(kg.NodalLoad(other.nodes[1], (9, 0)))
    other.add(kg.Node(5, 5))
    other.remove(other.constraints[0])
    other.add(kg.Fix(other.nodes[0]), kg.Fix(other.nodes[2]))
    other.perturb([[0, 0], [1, 0], [0, 0]])
    assert stretch(other) == pytest.approx(2.0, rel=1e-12)  # force 10, length 2
    assert (len(m.nodes), len(m.loads), len(m.constraints)) == (2, 1, 2)
    assert m.positions().tolist() == [[0, 0, 0], [1, 0, 0]] and m.nodes[1].x == 1
    assert stretch(m) == pytest.approx(0.1, rel=1e-12)
    m.perturb([[0, 0], [3, 0]])
    assert stretch(m) == pytest.approx(0.4, rel=1e-12) and m.nodes[1].x == 4
    assert stretch(other) == pytest.approx(2.0, rel=1e-12)


def test_a_shallow_copy_knows_the_nodes_of_the_original() -> None:
    """``copy.copy`` shares what the lists hold: nodes in hand serve both models, nodes added later one of them."""
    m, _, b = rod()
    other = copy.copy(m)
    other.add(kg.NodalLoad(b, (9, 0)))
    assert (stretch(other), stretch(m)) == (pytest.approx(1.0, rel=1e-12), pytest.approx(0.1, rel=1e-12))
    late = other.add(kg.Node(2, 0))
    with pytest.raises(kg.ModelError, match="another model"):
        m.add(kg.Fix(late))


@pytest.mark.parametrize("how", ["deepcopy", "pickle"])
def test_a_deep_copy_has_nodes_of_its_own(how: str) -> None:
    m, _, b = rod()
    other = COPIES[how](m)
    with pytest.raises(kg.ModelError, match="another model"):
        other.add(kg.NodalLoad(b, (9, 0)))
    assert other.nodes[1] is not b and other.nodes[1].model is other


@pytest.mark.parametrize("rung", RUNGS)
@pytest.mark.parametrize("how", list(COPIES))
def test_a_copied_sheet_answers_alike(how: str, rung: str) -> None:
    m = sheet(rung)
    expected = kg.LinearStatic(m).run().u[-1]
    other = COPIES[how](m)
    np.testing.assert_array_equal(kg.LinearStatic(other).run().u[-1], expected)
    other.perturb(np.linspace(0, 0.2, len(other.mesh.nodes)) ** 2)
    assert np.abs(kg.LinearStatic(other).run().u[-1] - expected).max() > 1e-3 * np.abs(expected).max()
    np.testing.assert_array_equal(kg.LinearStatic(m).run().u[-1], expected)


# ---- stages


def staged() -> tuple[kg.Model, kg.Results]:
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, 10.0), kg.Fix(a), kg.Prescribe(b, x=0.1), kg.Fix(b, "y"))
    return m, kg.DisplacementControl(m).run()


def test_hold_takes_a_step_of_the_present_stage() -> None:
    m, first = staged()
    m.hold(first[-1])
    m.remove(m.constraints[2])
    m.add(kg.Prescribe(m.nodes[1], y=0.5))
    second = kg.DisplacementControl(m, to=0.5, start=first[-1]).run()
    state = m.version, m.stage, m.objects
    with pytest.raises(kg.ModelError, match="stage 0"):
        m.hold(first[-1])
    assert (m.version, m.stage, m.objects) == state
    m.hold(second[-1])
    assert m.constraints[-1].values["y"].tolist() == [0.25]
    with pytest.raises(kg.ModelError, match="stage 1"):
        m.hold(second[-1])


def test_hold_takes_a_step_of_this_model(tmp_path: Any) -> None:
    m, first = staged()
    other, _ = staged()
    for foreign in (first[-1], kg.Step.at(m, 1.0, first[-1].u)):
        with pytest.raises(kg.ModelError, match="another model"):
            other.hold(foreign)
    for junk in (1.0, None, first, "step"):
        with pytest.raises(kg.ModelError, match="give a step"):
            m.hold(junk)  # type: ignore[arg-type]
    same = copy.deepcopy(m)
    same.hold(first[-1])  # the copy is in the same stage of the same model
    third = kg.Model()
    third.add(*(kg.Node(k, 0) for k in range(3)))
    stored = kg.load(first.save(tmp_path / "first.npz"))
    with pytest.raises(kg.ModelError, match="another model"):
        third.hold(stored[-1])
    other.hold(stored[-1])  # a script that reads its results anew makes its model anew
    assert other.stage == 1


def test_any_object_can_be_held() -> None:
    """What an author of effects does not say about stages is: nothing changes."""
    _, objects = one_of_each()
    for name, item in objects.items():
        if name in ("bar", "spring", "limit", "contact", "fix"):
            assert item.held(0.5) is item
