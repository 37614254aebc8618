"""Results are those of the run: nothing they say changes with the model, and a file of them says the same."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from matplotlib import pyplot

import kirigami as kg
from kirigami.results.contact import gaps, normal_forces, penetration

RUNGS = ("plate", "facet", "shell")


class Case:
    """A strip that is held at one end, driven and tied at the other, and pressed on a plane."""

    def __init__(self, rung: str) -> None:
        sheet = kg.Sheet(
            shapely.box(0, 0, 1, 0.3),
            [shapely.LineString([(0.5, 0.1), (0.5, 0.2)])],
            thickness=0.01,
            material=kg.Material(E=1e9, nu=0.3),
        )
        m = kg.Model.from_mesh(sheet.mesh(0.25), stiffness=rung)
        left, right = m.select(boundary="left"), m.select(boundary="right")
        self.late: list[Any] = []
        self.left, self.right = left, right
        self.fixed = m.add(kg.Fix(left, clamp=True))
        self.drive = m.add(kg.Prescribe(right[0], z=-0.02))
        self.tie = m.add(kg.Tie(right[1:], right[0], "z"))
        inside = m.select(where=lambda x, y, z: (x > 0.2) & (x < 0.8))
        self.contacts = [
            m.add(kg.Contact(inside[0], kg.Plane((0, 0, -0.005)))),
            m.add(kg.Contact(inside[1:], kg.Plane((0, 0, -0.004)))),
        ]
        self.model = m
        self.results = kg.DisplacementControl(m, step=0.5).run()
        self.results.stats["seconds"] = {"total": 1.0}  # the one thing that differs from run to run


EDITS: dict[str, Callable[[Case], Any]] = {
    "hold": lambda case: case.model.hold(case.results[-1]),
    "remove supports": lambda case: case.model.remove(case.drive, case.tie, case.fixed),
    "move the drive": lambda case: (
        case.model.remove(case.drive, case.fixed),
        case.model.add(kg.Prescribe(case.left, x=0.3)),
    ),
    "remove a contact": lambda case: case.model.remove(case.contacts[0]),
    "remove elements": lambda case: case.model.remove(*case.model.elements[:5]),
    "perturb": lambda case: case.model.perturb(np.linspace(0, 0.1, len(case.model.mesh.nodes))),
    "add a node": lambda case: case.late.append(case.model.add(kg.Node(7, 7))),
    "add a load": lambda case: case.model.add(kg.NodalLoad(case.right[0], (0, 0, 9))),
}


def said(case: Case, folder: Path) -> dict[str, Any]:
    """Everything the results say, by name."""
    res = case.results
    found: dict[str, Any] = {
        "summary": res.summary(),
        "csv": res.to_csv(folder / "frozen.csv").read_text(),
        "html": len(res.to_html(folder / "frozen.html").read_text()),
        "vtk": [path.read_bytes() for path in res.to_vtk(folder / "vtk")],
        "stress": res.stress().tensor("top"),
        "thickness, material": (res.thickness, res.material),
        "supports": [(s.name, s.dofs, s.nodes.tolist(), s.constant) for s in res.supports],
        "reaction": res.reaction(case.right),
        "reaction by name": res.reaction("driven_0", "z"),
        "reaction of a boundary": res.reaction("left"),
        "position": res.position(case.right[0]),
        "forces of a contact": [normal_forces(res, contact) for contact in case.contacts],
        "gaps of a contact": [gaps(res, contact) for contact in case.contacts],
        "all forces": normal_forces(res),
        "penetration": penetration(res),
        "energy": res.energy,
        "curvature": res.curvature(),
    }
    for name in ("height", "width", "poisson_ratio", "open_area", "energy_shares"):
        found[name] = getattr(res, name)()
    for kernel in res.kernels:
        if type(kernel).deformation is not kg.Kernel.deformation:
            found[f"deformation of {kernel.name}"] = res.deformation(kernel.name)
    return found


def assert_same(now: Any, then: Any) -> None:
    if isinstance(then, dict):
        for key in then:
            assert_same(now[key], then[key])
    elif isinstance(then, (list, tuple)) and then and isinstance(then[0], np.ndarray):
        for one, other in zip(now, then, strict=True):
            assert_same(one, other)
    elif isinstance(then, np.ndarray):
        np.testing.assert_array_equal(now, then)
    else:
        assert now == then


@pytest.fixture(scope="module")
def untouched(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """What the results of each rung say, whose model nobody changed."""
    return {rung: said(Case(rung), tmp_path_factory.mktemp(rung)) for rung in RUNGS}


@pytest.mark.parametrize("rung", RUNGS)
@pytest.mark.parametrize("edit", list(EDITS))
def test_results_do_not_change_with_the_model(
    edit: str, rung: str, untouched: dict[str, dict[str, Any]], tmp_path: Path
) -> None:
    """Those of another run of the same case, which were asked for nothing before, so that nothing rests on that."""
    case, then = Case(rung), untouched[rung]
    EDITS[edit](case)
    now = said(case, tmp_path)
    assert now.keys() == then.keys()
    for name in then:
        assert_same(now[name], then[name])


def test_what_was_not_there_is_refused_in_words() -> None:
    case = Case("plate")
    m, res = case.model, case.results
    late = m.add(kg.Node(5, 5))
    wall = m.add(kg.Contact(case.right, kg.Plane((0, 0, -9))))
    other = Case("plate")
    calls: list[Callable[[], Any]] = [
        lambda: res.reaction(late),
        lambda: res.position([case.left[0], late]),
        lambda: res.reaction(other.left),
        lambda: normal_forces(res, wall),
        lambda: res.force("contact", of=other.contacts[0]),
        lambda: res.force("contact", of=2),
        lambda: res.reaction("driven_7"),
        lambda: res.position([0, [1, 2]]),  # type: ignore[list-item]
        lambda: res.position(len(res.rest)),
        lambda: res.deformation("springs"),
    ]
    for call in calls:
        with pytest.raises(kg.ModelError):
            call()


def test_contacts_are_told_apart() -> None:
    """The forces of each contact are those of its own nodes, node by node, and add up to what the plane carries."""
    case = Case("plate")
    res = case.results
    alone, many = (normal_forces(res, contact) for contact in case.contacts)
    assert alone.shape[1] == 1 and many.shape[1] == len(case.contacts[1].group)
    np.testing.assert_array_equal(np.hstack([alone, many]), normal_forces(res))
    np.testing.assert_array_equal(res.force("contact"), normal_forces(res))
    index = res.node_index(case.contacts[1].group)
    height = res.position(index)[:, :, 2]
    np.testing.assert_allclose(gaps(res, case.contacts[1]), height + 0.004, atol=1e-15)
    total = normal_forces(res)[-1].sum()
    assert total > 0
    assert total + res.reaction([*case.left, *case.right], "z")[-1] == pytest.approx(0, abs=1e-6 * total)


# ---- without a model


@pytest.mark.parametrize("rung", RUNGS)
@pytest.mark.parametrize("how", ["file", "pickle", "forgotten"])
def test_results_that_travelled_say_the_same(
    how: str, rung: str, untouched: dict[str, dict[str, Any]], tmp_path: Path
) -> None:
    case, then = Case(rung), untouched[rung]
    number = {
        "nodes": [case.results.node_index(case.left).tolist(), case.results.node_index(case.right).tolist()],
    }
    if how == "file":
        case.results = kg.load(case.results.save(tmp_path / "run.npz"))
        case.left, case.right = number["nodes"]
        case.contacts = [0, 1]
    elif how == "pickle":
        case.results, case.left, case.right, case.contacts = pickle.loads(
            pickle.dumps((case.results, case.left, case.right, case.contacts))
        )
    else:
        case.results = copy.copy(case.results).forget_model()
        case.left, case.right = number["nodes"]
        case.contacts = [0, 1]
    now = said(case, tmp_path)
    for name in then:
        assert_same(now[name], then[name])
    case.results.plot_stress()
    pyplot.close("all")


def test_loaded_results_say_that_they_have_no_model(tmp_path: Path) -> None:
    case = Case("plate")
    res = kg.load(case.results.save(tmp_path / "run.npz"))
    with pytest.raises(kg.AnalysisError, match=r"no model.*driven_0"):
        res.model.select(boundary="top")
    with pytest.raises(kg.ModelError, match="loaded from a file"):
        res.reaction(case.left)
    with pytest.raises(kg.ModelError, match="object's number"):
        normal_forces(res, case.contacts[0])
    assert case.results.model is case.model


def test_names_of_nodes_are_kept(tmp_path: Path) -> None:
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0, name="apex"))
    m.add(kg.Bar(a, b, 10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    res = kg.LinearStatic(m).run()
    for known in (res, kg.load(res.save(tmp_path / "rod.npz"))):
        assert known.position("apex")[-1, 0] == pytest.approx(1.1, rel=1e-12)
        assert known.reaction("fixed_0", "x")[-1] == pytest.approx(-1, rel=1e-12)
        with pytest.raises(kg.ModelError, match="apex, fixed_0, fixed_1"):
            known.position("top")


@pytest.mark.parametrize("path", sorted((Path(__file__).parent / "data").rglob("format*.npz")), ids=lambda p: p.stem)
def test_files_of_earlier_versions_know_less_but_are_read(path: Path) -> None:
    res = kg.load(path)
    assert res.supports == () and res.node_names == {} and res.thickness is None
    if res.mesh is not None and res.dim == 3:
        with pytest.raises(kg.ModelError, match="thickness"):
            res.stress()
        res.plot_stress(thickness=1e-3, material=kg.Material(E=1e9))
        pyplot.close("all")


def test_a_copy_of_results_is_a_copy() -> None:
    res = Case("plate").results
    count, last = len(res), res.lam[-1]
    other = copy.copy(res)
    other.append(res[0])
    other.events.append(kg.Event("interrupted", 0.0, 0, "made up"))
    other.stats["steps"] = -1
    assert (len(other), other.lam[-1], len(other.energy["bars"])) == (count + 1, 0.0, count + 1)
    assert (len(res), res.lam[-1], len(res.energy["bars"])) == (count, last, count)
    assert not res.events and res.stats["steps"] != -1


HAS = {"paper": ("bar", "hinge"), "plate": ("bar", "hinge"), "facet": (), "shell": ()}


@pytest.mark.parametrize("rung", list(HAS))
def test_what_a_rung_does_not_have_is_told(rung: str) -> None:
    """No array without columns: a quantity has a column for each member, or is an error that names what there is."""
    mesh = kg.Sheet(shapely.box(0, 0, 1, 0.3)).mesh(0.2)
    m = kg.Model.from_mesh(mesh, 0.01, kg.Material(E=1e9), stiffness=rung)
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Prescribe(m.select(boundary="right"), z=0.1))
    res = kg.LinearStatic(m).run()
    names = {kernel.name for kernel in res.kernels}
    for name in ("bar_strain", "bar_force", "hinge_angle", "hinge_moment", "spring_angle", "spring_moment"):
        if name.partition("_")[0] in HAS[rung]:
            assert getattr(res, name).shape[1] > 0
        else:
            with pytest.raises(kg.ModelError) as told:
                getattr(res, name)
            assert all(repr(kind) in str(told.value) for kind in names) and "stress()" in str(told.value)
    for kind in {kernel.name for kernel in res.kernels if kernel.surface}:
        assert res.deformation(kind).shape == res.force(kind).shape == (2, len(mesh.triangles), 6)
    truss = kg.Model(dim=2)
    a, b = truss.add(kg.Node(0, 0), kg.Node(1, 0))
    truss.add(kg.Bar(a, b, 1.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    with pytest.raises(kg.ModelError, match=r"no 'hinges', but 'bars'"):
        _ = kg.LinearStatic(truss).run().hinge_angle
