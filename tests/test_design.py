"""Sheets that move with a few numbers."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import shapely
from slit_design import BOX, cuts, pulled

import kirigami as kg
from kirigami.results.gradients.equilibrium import Equilibrium, prepared
from kirigami.results.gradients.functionals import tell_of


def design(**more):
    given = {
        "outline": BOX, "supports": pulled(0.003), "thickness": (8e-4, 4e-4, 2e-3), "material": kg.Material(2e9, 0.3),
        "mesh": {"max_edge": 0.03, "cut_edge": 0.025}, "inner": (1.0, 0.5, 1.3), "edge": (1.0, 0.5, 1.4),
        "tilt": (0.1, -0.5, 0.5),
    }  # fmt: skip
    return kg.Design(cuts, **{**given, **more})


def test_moved_mesh_is_that_of_the_moved_cuts():
    start = design()
    moved = start.at(inner=0.8, edge=1.2, tilt=-0.2)
    assert np.array_equal(moved.mesh.triangles, start.mesh.triangles)
    assert moved.mesh.facet_areas.sum() == pytest.approx(BOX.area, rel=1e-12)
    for number, line in enumerate(moved.sheet().cuts):
        points = [shapely.Point(place) for place in moved.mesh.nodes[moved.mesh.cuts[number].loop, :2]]
        assert max(line.distance(point) for point in points) < 1e-12
        ends = [shapely.Point(place) for place in line.coords]
        assert all(min(end.distance(point) for point in points) < 1e-12 for end in ends)


def test_a_mesh_whose_rim_moves_rigidly_moves_rigidly():
    """Also where small facets are stiffer: rigid motions strain nothing."""
    mesh = design().mesh
    rim = np.unique(np.concatenate(mesh.boundary_loops))
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    moved = mesh.moved(rim, mesh.nodes[rim, :2] + (0.01, 0.02))
    assert np.allclose(moved.nodes[:, :2], mesh.nodes[:, :2] + (0.01, 0.02), atol=1e-12)
    small = 1e-6 * mesh.nodes[:, :2] @ (turn - turn.T) / 2
    spun = mesh.moved(rim, mesh.nodes[rim, :2] + small[rim])
    assert np.allclose(spun.nodes[:, :2], mesh.nodes[:, :2] + small, atol=1e-13)


def pulled_on(start, inner):
    res = start.at(inner=inner).walk([1.0], tol=1e-11)
    return {"force": res.reaction("driven_0", "y")[-1]}


def test_a_sweep_over_a_parameter_has_the_slope_that_gradients_say(tmp_path):
    """One mesh and one imperfection follow the parameter, in other processes as well."""
    start, thinner = (
        design(supports=kg.LoadCase(strain=0.02), stiffness="plate", thickness=thickness) for thickness in (1e-3, 5e-4)
    )
    step = 1e-4
    rows = [{"inner": 1.0 + side * step} for side in (-1, 0, 1)]
    table = kg.Sweep(partial(pulled_on, start), rows, tmp_path / "force").run(workers=1)
    assert len(table.done) == 3
    less, here, more = table["force"].tolist()
    slope = start.walk([1.0], tol=1e-11).gradient(("force", "driven_0", "y"), start)["inner"]
    assert (more - less) / (2 * step) == pytest.approx(slope, rel=1e-4)
    assert more - 2 * here + less == pytest.approx(0.0, abs=0.01 * abs(more - less))
    with pytest.raises(kg.AnalysisError, match="belongs to"):  # rows of another thickness
        kg.Sweep(partial(pulled_on, thinner), rows, tmp_path / "force").run(workers=1)


def test_where_it_goes_does_not_depend_on_the_way():
    start = design()
    there = start.at(inner=0.9).at(inner=0.7, edge=1.1)
    assert np.array_equal(there.mesh.nodes, start.at(inner=0.7, edge=1.1).mesh.nodes)


@pytest.mark.parametrize("kind", ["plate", "paper", "facet", "shell", "orthotropic"])
def test_gradient_by_parameters_against_differences(kind, monkeypatch):
    """By the one contraction, which is not allowed to ask for the structure of another design."""
    more = {"stiffness": kind} if kind != "orthotropic" else {"material": kg.Orthotropic(2e9, 1e9, 0.3, 5e8, angle=20)}
    here = design(**more)
    res = here.walk([1.0])
    if kind != "facet":  # whose clamps are made of the rest state
        monkeypatch.setattr("kirigami.design.design.potentials", None)
    asked = [("force", "driven_0", "y"), ("open_area",), ("energy",), ("height",)]
    found = res.gradient(asked, here)
    u = prepared(res.model).joined(res[-1].u, res[-1].inner)
    for name in here.values:
        step = 2e-5 * here.span(name)
        sides = []
        for sign in (2, 1, -1, -2):
            system = prepared(here._with({name: here.values[name] + sign * step}).model(), res[-1].history)
            state = Equilibrium(system, u, 1.0)
            sides.append([state.told(tell_of(item, res)).value for item in asked])
        far, near, back, behind = np.array(sides)
        differences = (8 * (near - back) - (far - behind)) / (12 * step)
        assert [rates[name] for rates in found] == pytest.approx(differences, rel=1e-6)


@pytest.mark.parametrize("free", [False, True])
def test_what_is_measured_against_the_drawing_changes_with_it(free):
    """The Poisson ratio of a sheet whose width is a parameter, with supports that the nodes alone place or not."""

    def supports(m):
        pulled(0.002)(m)
        if free:  # another force for another width
            m.add(kg.NodalLoad(m.select(boundary="right"), (0.1 * m.positions()[:, 0].max(), 0, 0)))

    def slits(width):
        return [shapely.LineString([(0.3 * width, 0.025), (0.7 * width, 0.025)])]

    here = kg.Design(
        slits, outline=lambda width: shapely.box(0, 0, width, 0.08), supports=supports, thickness=1e-3,
        material=kg.Material(2e9, 0.3), mesh={"max_edge": 0.03}, width=(0.1, 0.05, 0.2),
    )  # fmt: skip
    asked = [("poisson_ratio",), ("width",), ("force", "driven_0", "y")]
    res = here.walk([1.0])
    found = [rates["width"] for rates in res.gradient(asked, here)]
    u, step, sides = prepared(res.model).joined(res[-1].u, res[-1].inner), 1e-5, []
    for sign in (1, -1):
        system = prepared(here.at(width=0.1 + sign * step).model(), res[-1].history)
        state = Equilibrium(system, u, 1.0)
        sides.append([state.told(tell_of(item, kg.Results(system))).value for item in asked])
    assert found == pytest.approx((np.array(sides[0]) - np.array(sides[1])) / (2 * step), rel=1e-5)


@pytest.mark.parametrize("stiffness", ["plate", "shell"])
def test_folds_follow_parameters(stiffness):
    """A crease whose place and stiffness are parameters: its nodes stay on it, and gradients know both."""

    def folds(at, stiff):
        return [kg.Fold([(0, at), (0.1, at + 0.005)], stiffness=stiff)]

    here = kg.Design(
        [shapely.LineString([(0.03, 0.03), (0.07, 0.03)])], outline=BOX, supports=pulled(0.002), thickness=1e-3,
        material=kg.Material(2e9, 0.3), folds=folds, mesh={"max_edge": 0.03}, stiffness=stiffness,
        at=(0.05, 0.04, 0.06), stiff=(5.0, 1.0, 20.0),
    )  # fmt: skip
    moved = here.at(at=0.055, stiff=7.0).mesh
    on = moved.nodes[np.unique(moved.folds[0].edges)]
    assert on[:, 1] == pytest.approx(0.055 + 0.05 * on[:, 0], abs=1e-12)
    assert moved.folds[0].stiffness == 7.0
    res = here.walk([1.0])
    asked = [("force", "driven_0", "y"), ("energy",)]
    found = res.gradient(asked, here)
    u = prepared(res.model).joined(res[-1].u, res[-1].inner)
    for name in here.values:
        step, sides = 1e-4 * here.span(name), []
        for sign in (1, -1):
            system = prepared(here._with({name: here.values[name] + sign * step}).model(), res[-1].history)
            state = Equilibrium(system, u, 1.0)
            sides.append([state.told(tell_of(item, res)).value for item in asked])
        differences = (np.array(sides[0]) - np.array(sides[1])) / (2 * step)
        assert [rates[name] for rates in found] == pytest.approx(differences, rel=1e-4)


def test_finer_and_remeshed():
    start = design().at(inner=0.8)
    assert len(start.finer().mesh.nodes) > 1.4 * len(start.mesh.nodes)
    again = start.remeshed()
    assert again.values == start.values
    assert again.mesh.min_angle > 20


# ---- bad input


def test_cuts_that_meet_or_change():
    with pytest.raises(kg.GeometryError, match="meet at"):
        design(edge=(1.0, 0.5, 3.0)).at(edge=1.9)
    with pytest.raises(kg.GeometryError, match="reaches|leaves"):
        design(inner=(1.0, 0.5, 3.0)).at(inner=1.9, tilt=0.0)

    def more(count):
        return [shapely.LineString([(0.02, 0.01 * k + 0.01), (0.05, 0.01 * k + 0.01)]) for k in range(int(count))]

    with pytest.raises(kg.GeometryError, match="number must stay"):
        kg.Design(
            more, outline=BOX, supports=pulled(0.003), thickness=1e-3, material=kg.Material(1e9), count=(2, 1, 5),
            mesh={"max_edge": 0.03},
        ).at(count=3)  # fmt: skip


def test_parameters():
    with pytest.raises(kg.ModelError, match="no function takes 'width'"):
        design(width=1.0)
    with pytest.raises(kg.ModelError, match="between 0.5 and 1.3"):
        design().at(inner=2.0)
    with pytest.raises(kg.ModelError, match="there is no"):
        design().at(length=2.0)
    with pytest.raises(kg.ModelError, match="range"):
        design(inner=(2.0, 0.5, 1.3))


def test_moved_refuses_what_turns_facets_over():
    mesh = kg.Sheet(BOX).mesh(0.03)
    corner = mesh.boundary("outer")
    places = mesh.nodes[corner, :2].copy()
    places[0] += (0.2, 0.2)
    with pytest.raises(kg.GeometryError, match="turn over"):
        mesh.moved(corner, places)
    with pytest.raises(kg.GeometryError, match="different numbers"):
        mesh.moved([0, 0], [[0, 0], [0, 0]])
