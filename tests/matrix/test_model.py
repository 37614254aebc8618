"""Every public method of Model and every analysis, on every rung and on hand-built structures.

The rows come from the public names: a new method of ``kg.Model`` or a new analysis joins one of the tables below, or is
named with the reason why not.
"""

from __future__ import annotations

import copy
import inspect
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from changes import CHANGES
from structures import BUILT, FOLDED, SAME, SHEETS, STRUCTURES, applies, results

import kirigami as kg
from kirigami.analysis.base import Analysis

CLOSE = 1e-6


def fresh(structure: str) -> kg.Model:
    return STRUCTURES[structure](SAME)


def end(m: kg.Model, **settings: Any) -> np.ndarray:
    """Displacements at load factor 1."""
    run = kg.DisplacementControl(m, tol=1e-10, **settings).run()
    return np.asarray(run[-1].u)


@cache
def plain_end(structure: str) -> np.ndarray:
    """Displacements at load factor 1 of the structure as it is."""
    return end(fresh(structure))


def assert_same(found: Any, wanted: Any, close: float = CLOSE) -> None:
    found, wanted = np.asarray(found, dtype=float), np.asarray(wanted, dtype=float)
    assert found.shape == wanted.shape and np.isfinite(found).all()
    np.testing.assert_allclose(found, wanted, rtol=0, atol=close * max(np.abs(wanted).max(initial=0.0), 1e-300))


# ---- methods of the model


def added_in_another_order(structure: str) -> None:
    """What is added last acts like what is added first."""
    m = fresh(structure)
    load = m.loads[0]
    m.remove(load)
    assert m.add(load) is load
    assert_same(end(m), plain_end(structure))


def removed_is_gone(structure: str) -> None:
    """A load that is taken out again, and its opposite, leave the same structure."""
    m, other = fresh(structure), fresh(structure)
    m.remove(m.loads[0])
    x, y, z = other.loads[0].force
    other.add(kg.NodalLoad(other.loads[0].group, (-x, -y, -z)))
    assert_same(end(m), end(other))


def held_where_it_is(structure: str) -> None:
    """Held at half and driven no more, the structure stays; its load factor starts anew."""
    m = fresh(structure)
    half = kg.DisplacementControl(m, to=0.5, tol=1e-10).run()[-1]
    m.hold(half)
    m.add(kg.NodalLoad(m.nodes[0], (1e-3,) * m.dim))  # at a support, where it moves nothing
    after = kg.LoadControl(m, start=half, tol=1e-10).run()
    assert_same(after[-1].u, half.u)


def perturbed_there_and_back(structure: str) -> None:
    """The opposite imperfection undoes one; the rest state carries no stress."""
    m = fresh(structure)
    count, rest = len(m.nodes), m.positions()
    shape = np.random.default_rng(1).normal(size=(count, m.dim))
    m.perturb(shape, amplitude=0.01)
    moved = m.positions() - rest
    assert np.linalg.norm(moved, axis=1).max() == pytest.approx(0.01)
    system = kg.System(m)
    assert sum(system.energies(np.zeros((count, 3))).values()) <= 1e-20
    m.perturb(-moved[:, : m.dim])
    assert_same(m.positions(), rest, 1e-12)
    assert_same(end(m), plain_end(structure))


def selected_by_every_way(structure: str) -> None:
    """A box, a predicate and the indices name the same nodes."""
    m = fresh(structure)
    x = m.positions()
    chosen = np.flatnonzero(x[:, 0] >= 0.45).tolist()
    low, high = x.min(axis=0), x.max(axis=0)
    low[0] = 0.45
    assert m.index(m.select(box=(*low, *high))).tolist() == chosen
    assert m.index(m.select(where=lambda x, y, z: x >= 0.45)).tolist() == chosen
    assert m.index(m.select(index=chosen)).tolist() == chosen
    assert m.select(index=chosen) == [m.nodes[k] for k in chosen]
    if m.mesh is not None:
        assert m.index(m.select(boundary="bottom")).tolist() == m.mesh.boundary("bottom").tolist()


def positions_are_those_of_the_nodes(structure: str) -> None:
    m = fresh(structure)
    assert m.positions().tolist() == [[node.x, node.y, node.z] for node in m.nodes]
    assert m.index(m.nodes).tolist() == list(range(len(m.nodes)))


def copied_is_another(structure: str) -> None:
    """What is done to a copy does not touch the original, by either way of copying."""
    for way in (copy.copy, copy.deepcopy):
        m = fresh(structure)
        other = way(m)
        loaded = [other.nodes[k] for k in m.index(m.loads[0].group)]
        other.add(kg.NodalLoad(loaded, m.loads[0].force))
        assert len(m.loads) == 1 and len(other.loads) == 2
        assert_same(end(m), plain_end(structure))


def imperfect_alike(structure: str) -> None:
    """The same field however the sheet is stated; what has no thickness or no third dimension is refused.

    The axes of the field are the principal ones of the sheet, which a square has not: so it is not turned here.
    """
    if structure not in SHEETS | FOLDED:
        with pytest.raises(kg.ModelError):
            fresh(structure).imperfect()
        return
    moved = {}
    for name in ("", "renumbered", "millimetres", "kilonewtons"):
        m = STRUCTURES[structure](CHANGES.get(name, SAME))
        rest = m.positions()
        m.imperfect(seed=3)
        moved[name] = m.positions() - rest
    for name in ("renumbered", "millimetres", "kilonewtons"):
        how = CHANGES[name]
        assert_same(moved[name], how.places(moved[""])[how.order(len(moved[""]))], 1e-5)


METHODS: dict[str, Callable[[str], None]] = {
    "add": added_in_another_order,
    "remove": removed_is_gone,
    "hold": held_where_it_is,
    "perturb": perturbed_there_and_back,
    "select": selected_by_every_way,
    "positions": positions_are_those_of_the_nodes,
    "copies": copied_is_another,
    "imperfect": imperfect_alike,
}
NO_METHOD: dict[str, str] = {
    "from_mesh": "makes every sheet of the matrix",
    "index": "with positions",
    "plot": "a picture, tested in tests/plot",
    "to_abaqus": "with the exporters",
    "to_openseespy": "with the exporters",
    **dict.fromkeys(
        "constraints dim effects elements loads mesh nodes objects sheet_constants sheet_elements".split(),
        "hands out what the model is made of",
    ),
}


def test_every_public_name_of_the_model_has_a_row() -> None:
    public = {name for name in dir(kg.Model) if not name.startswith("_")}
    named = {*METHODS, *NO_METHOD} - {"copies"}
    assert public == named, sorted(public ^ named)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("structure", STRUCTURES)
def test_method_of_the_model(structure: str, method: str) -> None:
    METHODS[method](structure)


# ---- analyses


def squeezed(structure: str, change: str) -> kg.Model:
    """The same, with the drive taken out and the load pressing: something to buckle."""
    how = CHANGES.get(change, SAME)
    m = STRUCTURES[structure](how)
    (driven,) = [item for item in m.constraints if not item.constant]
    (load,) = m.loads
    m.remove(driven, load)
    # on sheets in the plane and along the sheet, else all along
    push = how.forces(np.array([0.0, -1.0, 0.0]))
    m.add(kg.NodalLoad(driven.group, push[: m.dim]))
    return m


def eigenvalues(structure: str, change: str) -> np.ndarray:
    return kg.Eigen(STRUCTURES[structure](CHANGES.get(change, SAME)), n=2).run().values


def buckling_factor(structure: str, change: str) -> np.ndarray:
    return kg.Buckling(squeezed(structure, change), n=1).run().values


def end_under_loads(structure: str, change: str) -> np.ndarray:
    m = STRUCTURES[structure](CHANGES.get(change, SAME))
    return end_energy(kg.LoadControl(m, tol=1e-10).run())


def end_of_drive(structure: str, change: str) -> np.ndarray:
    return end_energy(results(structure, change))


def end_of_arc(structure: str, change: str) -> np.ndarray:
    m = STRUCTURES[structure](CHANGES.get(change, SAME))
    run = kg.ArcLength(m, step=0.2, max_steps=4, tol=1e-10).run()
    return np.concatenate([run.lam, end_energy(run)])


def end_of_linear(structure: str, change: str) -> np.ndarray:
    return end_energy(kg.LinearStatic(STRUCTURES[structure](CHANGES.get(change, SAME))).run())


def end_of_motion(structure: str, change: str) -> np.ndarray:
    m = STRUCTURES[structure](CHANGES.get(change, SAME))
    return end_energy(kg.Dynamics(m, end=0.1, step=0.05, load=[(0, 0), (1, 1)], tol=1e-10).run())


def end_energy(run: kg.Results) -> np.ndarray:
    return np.array([sum(run.energy.values())[-1]])


# What an analysis tells, and the powers of length and force in it; None where only some of it has units.
ANALYSES: dict[str, tuple[Callable[[str, str], np.ndarray], int, int, frozenset[str]]] = {
    "LinearStatic": (end_of_linear, 1, 1, frozenset(STRUCTURES)),
    "Eigen": (eigenvalues, -1, 1, frozenset(STRUCTURES)),
    "Buckling": (buckling_factor, 0, 1, frozenset(SHEETS)),
    "LoadControl": (end_under_loads, 1, 1, frozenset(STRUCTURES)),
    "DisplacementControl": (end_of_drive, 1, 1, frozenset(STRUCTURES)),
    "Dynamics": (end_of_motion, 1, 1, frozenset(STRUCTURES) - {"linked tower"}),  # grips in motion are refused
    "ArcLength": (end_of_arc, 1, 1, frozenset(STRUCTURES)),
}


@cache
def as_it_is(analysis: str, structure: str) -> np.ndarray:
    """What an analysis tells of the structure as it is."""
    return ANALYSES[analysis][0](structure, "")


def test_every_analysis_has_a_row() -> None:
    public = {
        name for name in kg.__all__ if inspect.isclass(getattr(kg, name)) and issubclass(getattr(kg, name), Analysis)
    }
    assert public == set(ANALYSES)


@pytest.mark.parametrize(
    "structure, analysis, change",
    [  # every other one in the default suite, for its time, and all of them in the long one
        pytest.param(*cell, marks=[pytest.mark.long] if number % 2 else [])
        for number, cell in enumerate(
            (structure, analysis, change)
            for analysis, (*_, served) in ANALYSES.items()
            for structure in STRUCTURES
            if structure in served
            for change in CHANGES
            if applies(structure, change)
        )
    ],
)
def test_an_analysis_does_not_see_how_the_problem_is_stated(structure: str, analysis: str, change: str) -> None:
    run, length, force, _ = ANALYSES[analysis]
    how = CHANGES[change]
    before, after = as_it_is(analysis, structure), run(structure, change)
    scale = how.length**length * how.force**force
    if analysis == "ArcLength":
        assert_same(after[:-1], before[:-1], 1e-5)
        before, after = before[-1:], after[-1:]
    if analysis == "Buckling":  # a factor of a force of 1 in each unit
        scale = how.force / how.force
    assert_same(after, scale * before, 1e-5)


@pytest.mark.parametrize("mass", ["consistent", "lumped"])
@pytest.mark.parametrize("structure", STRUCTURES)
def test_frequencies_do_not_depend_on_how_the_problem_is_stated(structure: str, mass: str) -> None:
    """In whatever unit of length and force, with the same one of time."""
    found = {}
    for change in ("", *CHANGES):
        if not change or applies(structure, change):
            m = STRUCTURES[structure](CHANGES.get(change, SAME))
            found[change] = kg.Eigen(m, n=2, mass=mass).run().frequencies
    for frequencies in found.values():
        assert_same(frequencies, found[""], 1e-6)
        assert frequencies[0] > 0


@pytest.mark.parametrize("structure", STRUCTURES)
def test_all_ways_along_the_path_meet(structure: str) -> None:
    """Load control, displacement control and arc length stand at the same state at the same load factor."""
    by_drive = results(structure)
    at = int(np.argmin(np.abs(by_drive.lam - 0.5)))
    by_load = kg.LoadControl(fresh(structure), to=by_drive.lam[at], tol=1e-10).run()
    assert_same(by_load[-1].u, by_drive[at].u)
    arc = kg.ArcLength(fresh(structure), step=0.1, stop=lambda step: step.lam >= 0.5, tol=1e-10).run()
    meet = kg.LoadControl(fresh(structure), to=arc.lam[-1], tol=1e-10).run()
    assert_same(meet[-1].u, arc[-1].u)


@pytest.mark.parametrize("structure", [name for name in STRUCTURES if name not in BUILT])
def test_small_displacements_are_linear(structure: str) -> None:
    """A tiny drive leads along the path to the linear answer."""
    small = STRUCTURES[structure](SAME, 1e-7)
    nonlinear = kg.DisplacementControl(small, tol=1e-10).run()[-1].u
    assert_same(nonlinear, kg.LinearStatic(small).run()[-1].u, 2e-4)


