"""Designs found again from what they do, within bounds, told where they cannot be, and kept when interrupted."""

from __future__ import annotations

import json
import warnings

import numpy as np
import pytest
import shapely
from slit_design import BOX, cuts, pulled

import kirigami as kg
from kirigami.design.search import Search
from kirigami.design.starts import spread
from kirigami.results.gradients.equilibrium import Equilibrium

FORCE = ("force", "driven_0", "y")


def design(**more):
    given = {
        "outline": BOX, "supports": pulled(0.002), "thickness": 1e-3, "material": kg.Material(2e9, 0.3),
        "mesh": {"max_edge": 0.03, "cut_edge": 0.03}, "inner": (1.0, 0.5, 1.2), "edge": (1.0, 0.5, 1.4),
    }  # fmt: skip
    return kg.Design(cuts, **{**given, **more})


def forces(found, lams):
    res = found.walk(lams, tol=1e-11)
    return np.array([res.reaction("driven_0", "y")[int(np.argmin(abs(res.lam - lam)))] for lam in lams])


def test_hidden_cuts_are_found_from_a_force_and_a_shape():
    start, lams = design(), [0.5, 1.0]
    hidden = start.at(inner=0.85, edge=1.15)
    goal = hidden.walk(lams, tol=1e-11)
    wanted = [float(goal.open_area()[int(np.argmin(abs(goal.lam - lam)))].sum()) for lam in lams]
    found = kg.Inverse(
        start, [(FORCE, lams, forces(hidden, lams)), (("open_area",), lams, wanted)], corrections=None
    ).run()
    assert found.status == "met"
    assert found.coarse_error < 1e-4
    assert found.values == pytest.approx(hidden.values, rel=1e-3)
    assert forces(found.design, lams) == pytest.approx(forces(hidden, lams), rel=1e-3)  # walked from flat once more


def test_modulus_and_thickness_are_told_from_a_strip_that_hangs_and_is_pulled():
    """E t from the pull, E t^3 from the weight at its end: a calibration with two unknowns."""

    def held(m):
        m.add(kg.Fix(m.select(boundary="left"), clamp=True))
        m.add(kg.NodalLoad(m.select(boundary="right"), (40.0, 0, 0.004)))

    known = {"E": 2e9, "thickness": 1e-3}
    start = kg.Design(
        (), outline=shapely.box(0, 0, 0.1, 0.02), supports=held, mesh={"max_edge": 0.025}, imperfection=0,
        material=lambda E: kg.Material(E, 0.3), E=(1.6e9, 1e9, 4e9), thickness=(1.2e-3, 5e-4, 2e-3),
    )  # fmt: skip
    hidden = start.at(known).walk([1.0], tol=1e-12)  # the weight is a ten-thousandth of the pull
    asked = [("position", "right", "x"), ("position", "right", "z")]
    targets = [
        (lambda x, f: float(x[hidden.node_index("right"), 0].mean()) - 0.1, 1.0,
         float(hidden.position("right")[-1, :, 0].mean()) - 0.1),
        (asked[1], 1.0, float(hidden.position("right")[-1, :, 2].mean())),
    ]  # fmt: skip
    found = kg.Inverse(start, targets, corrections=None).run()
    assert found.values == pytest.approx(known, rel=1e-4)


@pytest.mark.parametrize("method", ["slsqp", "mma"])
def test_the_widest_opening_within_a_ligament(method):
    """Longer slits open wider, so that the bound on the ligament decides."""
    if method == "mma":
        pytest.importorskip("nlopt")
    start = design(inner=(0.9, 0.5, 1.2), edge=1.0)
    kept = ("ligament", 0.05 - 0.035 * 1.1, None)
    found = kg.Inverse(start, (("open_area",), 1.0, "max"), [kept], method=method, corrections=None).run()
    assert found.values["inner"] == pytest.approx(1.1, abs=2e-3)
    assert found.design.ligament() >= kept[1] * (1 - 1e-6)


def test_a_stiffness_and_a_poisson_ratio_are_met():
    start = design(edge=1.0)
    hidden = start.at(inner=0.8)
    goal = hidden.walk([0.4999, 0.5, 0.5001], tol=1e-11)
    at = [int(np.argmin(abs(goal.lam - lam))) for lam in (0.4999, 0.5, 0.5001)]
    force, place = goal.reaction("driven_0", "y")[at], goal.position("top")[at, :, 1].mean(axis=1)
    slope = (force[2] - force[0]) / (place[2] - place[0])
    targets = [(("stiffness", "driven_0", "y"), 0.5, slope), (("poisson_ratio",), 0.5, goal.poisson_ratio()[at[1]])]
    found = kg.Inverse(start, targets, corrections=None).run()
    assert found.values["inner"] == pytest.approx(0.8, abs=1e-3)


def test_targets_at_one_load_factor_share_one_solution(monkeypatch):
    start = design(edge=1.0, stiffness="plate")
    solve, asked = Equilibrium.solve, []

    def counted(self, right):
        asked.append(right.shape[1])
        return solve(self, right)

    monkeypatch.setattr(Equilibrium, "solve", counted)
    targets = [(FORCE, [0.5, 1.0], [1.0, 2.0]), (("height",), 1.0, 1.0), (("open_area",), 0.5, 1.0)]
    problem = kg.Inverse(start, targets, [(("energy",), 1.0, None, 1e9)])
    trial = Search(problem, start, None, False).trial(start.vector)
    assert asked == [2, 3]
    monkeypatch.undo()
    for number, target in enumerate(targets):  # and answers are those of each alone
        alone = Search(kg.Inverse(start, target), start, None, False).trial(start.vector)
        row = [slice(0, 2), 2, 3][number]
        assert trial.told[row] == pytest.approx(alone.told if number == 0 else alone.told[0], rel=1e-6)
        assert trial.slopes[row] == pytest.approx(alone.slopes if number == 0 else alone.slopes[0], rel=1e-5)


def test_nodes_by_number_are_not_taken_for_those_of_a_finer_mesh():
    start = design(edge=1.0)
    found = kg.Inverse(start, (lambda x, f: float(x[10, 1]), 1.0, 1.0), evaluations=2).run()
    assert not found.verified
    assert "numbers its nodes anew" in found.message
    with pytest.raises(kg.ModelError, match="there is no event 7"):
        kg.Inverse(start, (("critical", 7), 1.0, 1.0)).run()


def test_a_load_factor_of_buckling_is_met():
    """A strip that is pushed buckles at a strain that grows with the square of its thickness (Euler)."""

    def pushed(m):
        top = m.select(boundary="top")
        m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.Fix(top, "xz", clamp=True))
        m.add(kg.Prescribe(top, y=-3e-4))

    start = kg.Design(
        (), outline=shapely.box(0, 0, 0.02, 0.1), supports=pushed, material=kg.Material(2e9, 0.0), imperfection=0,
        mesh={"max_edge": 0.02}, thickness=(1e-3, 8e-4, 1.3e-3),
    )  # fmt: skip
    res = start.walk([1.0])
    number = [event.kind for event in res.events].index("bifurcation")
    lam = res.events[number].lam
    assert lam * 3e-4 / 0.1 == pytest.approx(np.pi**2 / 3 * (1e-3 / 0.1) ** 2, rel=0.02)
    target = (("critical", number), 1.0, 1.44 * lam)
    found = kg.Inverse(start, target, corrections=None, enough=1e-5).run()
    assert found.values["thickness"] == pytest.approx(1.2e-3, rel=1e-3)
    assert found.design.walk([1.0]).events[number].lam == pytest.approx(1.44 * lam, rel=1e-4)


def test_thickness_of_all_facets_pulls_as_the_thickness_does():
    """Whatever is asked for, at whatever load factors: an error, a wish, and a stiffness, which has two sides."""
    stiffness = ("stiffness", "driven_0", "y")
    targets = [(FORCE, [0.5, 1.0], [1.0, 3.0]), (("open_area",), 1.0, "max"), (stiffness, 1.0, 1e3)]
    found = kg.Inverse(design(thickness=(1e-3, 5e-4, 2e-3)), targets, evaluations=1, corrections=None).run()
    whole = float(found.thicker @ found.design.mesh.facet_areas)
    assert whole == pytest.approx(found.sensitivities["thickness"], rel=1e-5)


def test_what_is_out_of_reach_is_told():
    found = kg.Inverse(design(), (FORCE, 1.0, 1e6), corrections=None, evaluations=12).run()
    assert found.status in ("closest", "out of evaluations")
    assert not found.verified
    assert found.coarse_error > 0.1
    assert "%" in found.message


def test_what_is_not_finite_on_the_way_keeps_the_best():
    """A function of the user's that fails for some designs: they do not count, and are told in the history."""
    start = design(edge=1.0, stiffness="plate")
    top = [node for node, (x, y, z) in enumerate(start.mesh.nodes.tolist()) if y == 0.08]
    wanted, calls = float(forces(start.at(inner=0.8), [1.0])[0]), []

    def pull(x, f):
        calls.append(float(f[top, 1].sum()))
        by_force = np.zeros_like(f)
        by_force[top, 1] = 1.0
        return (float("nan") if len(calls) == 3 else calls[-1]), np.zeros_like(x), by_force

    found = kg.Inverse(start, (pull, 1.0, wanted), corrections=None, evaluations=8).run()
    assert found.coarse_error < 0.01
    assert [number for number, entry in enumerate(found.history) if "finite" in entry["why"]] == [2]


def test_an_interrupted_search_keeps_its_best_and_goes_on(tmp_path):
    lams, path = [1.0], tmp_path / "search.json"
    start = design(edge=1.0)
    wanted = forces(start.at(inner=0.8), lams)

    def stop(number, values, error):
        if number == 2:
            raise KeyboardInterrupt

    first = kg.Inverse(start, (FORCE, lams, wanted), corrections=None, path=path).run(progress=stop)
    assert first.status == "interrupted"
    assert len(json.loads(path.read_text())["history"]) == 2
    again = kg.Inverse(start, (FORCE, lams, wanted), corrections=None, path=path).run()
    assert again.status == "met"
    assert len(again.history) > 2
    assert again.history[2]["values"] == pytest.approx(first.values)
    assert again.values["inner"] == pytest.approx(0.8, abs=1e-4)


def test_an_interrupted_wish_goes_on_from_its_best_in_the_size_it_had(tmp_path):
    start, path = design(edge=1.0, stiffness="plate"), tmp_path / "search.json"

    def stop(number, values, error):
        if number == 2:
            raise KeyboardInterrupt

    problem = kg.Inverse(start, (FORCE, 1.0, "max"), corrections=None, path=path)
    first = problem.run(progress=stop)
    assert first.status == "interrupted"
    again = Search(problem, start, path, False)
    assert dict(zip(again.design.free, again.design.vector)) == first.values != start.values  # stiffer is better
    assert again.scales == pytest.approx(forces(start, [1.0]))
    assert np.isnan(problem.targets[0].scale)  # which is of the search, and no other search sees it
    other = start.at(inner=0.6)
    assert Search(kg.Inverse(start, (FORCE, 1.0, "max")), other, None, False).scales == pytest.approx(
        forces(other, [1.0])
    )


@pytest.mark.long
def test_answer_is_walked_on_a_finer_mesh():
    start = design(edge=1.0)
    wanted = forces(start.at(inner=0.9).finer(1.5), [1.0])
    found = kg.Inverse(start, (FORCE, 1.0, wanted), finer=1.5, corrections=2).run()
    fine = forces(found.design.finer(1.5), [1.0])
    assert found.reached[0] == pytest.approx(fine, rel=1e-6)
    assert found.error == pytest.approx(abs(fine[0] / wanted[0] - 1), abs=1e-6)
    coarse = forces(found.design, [1.0])
    assert found.coarse_error == pytest.approx(abs(coarse[0] / wanted[0] - 1), abs=1e-6)  # of the targets as given
    assert found.verified == (found.error < 0.03)
    assert found.verified
    assert found.plot().axes


def test_the_picture_shows_the_run_of_the_drawing():
    start = design(edge=1.0)
    one = [np.array([1.0])]
    found = kg.InverseResult(
        start.at(inner=0.9), start, {"inner": 0.9}, 0.0, 0.0, True, "met", "met", one, one, one, one, one, ["force"],
        [{"values": {"inner": 0.9}, "error": 0.0}],
    )  # fmt: skip
    plain, more = found.plot(), found.plot(start.walk())
    titles = [ax.get_title() for ax in more.axes]
    last = "run again, from the drawing"
    assert last in titles and last not in [ax.get_title() for ax in plain.axes]
    assert "height z" in [ax.get_ylabel() for ax in more.axes]  # colours have a bar
    with pytest.raises(kg.ModelError, match=r"InverseResult\.plot: again must be a Results"):
        found.plot(start)


def test_the_picture_shows_targets_by_kind_in_units_where_these_are_known():
    """A force and an area share no axis; without a run of the drawing nothing says that lengths are metres."""
    start = design(edge=1.0)
    each = [np.array([1.0]), np.array([1.0]), np.array([0.5, 1.0]), np.array([1.0])]
    found = kg.InverseResult(
        start.at(inner=0.9), start, {"inner": 0.9}, 0.0, 0.0, True, "met", "met", each, each, each, each, each,
        ["force", "open_area", "height", "force"], [{"values": {"inner": 0.9}, "error": 0.0}],
    )  # fmt: skip
    plain = [ax.get_ylabel() for ax in found.plot().axes]
    assert plain[:5] == ["height", "force", "open area", "y", "y"]
    again = start.walk()
    again.units = "SI"
    axes = found.plot(again).axes
    labels = [ax.get_ylabel() for ax in axes]
    assert labels[:5] == ["height [mm]", "force [N]", "open area [mm$^2$]", "y [mm]", "y [mm]"]
    assert "height z [mm]" in labels[5:]
    assert [mark.get_text() for mark in axes[1].get_xticklabels()] == ["1", "4"]  # by its number among all


def test_the_best_of_several_starts_counts():
    start = design(edge=1.0, stiffness="plate")
    wanted = forces(start.at(inner=0.8), [1.0])
    problem = kg.Inverse(start, (FORCE, 1.0, wanted), corrections=None, evaluations=2)
    one, some = problem.run(), problem.run(starts=3, seed=1)
    assert some.worth < one.worth  # one of the others is nearer
    assert some.start.values != one.start.values
    assert problem.run(starts=3, seed=1).values == some.values


@pytest.mark.long
def test_starts_side_by_side_are_those_one_by_one(tmp_path):
    start = design(edge=1.0, stiffness="plate", supports=kg.LoadCase(strain=0.025))  # which other processes know
    wanted = forces(start.at(inner=0.8), [1.0])
    problem = kg.Inverse(start, (FORCE, 1.0, wanted), corrections=None, enough=1e-4, path=tmp_path / "search.json")
    with pytest.raises(kg.ModelError, match="cannot be sent to other processes"):
        kg.Inverse(design(edge=1.0, stiffness="plate"), (FORCE, 1.0, wanted)).run(starts=2, workers=2)
    found = problem.run(starts=3, seed=1, workers=2)
    assert found.coarse_error < 1e-4
    assert found.values["inner"] == pytest.approx(0.8, abs=1e-3)
    assert (tmp_path / "search_2.json").exists()


@pytest.mark.long
def test_a_wish_means_the_same_from_all_starts_and_side_by_side(tmp_path):
    """The force alone tells which answer is better, by whatever it is divided."""
    start = design(edge=1.0, stiffness="plate", supports=kg.LoadCase(strain=0.025))
    problem = kg.Inverse(start, (FORCE, 1.0, "max"), corrections=None, evaluations=1, path=tmp_path / "search.json")
    found = problem.run(starts=3, seed=1, workers=2)
    size = forces(start, [1.0])[0]
    assert found.worth == pytest.approx(-found.coarse[0][0] / size, rel=1e-6)
    assert found.coarse[0][0] >= max(forces(each, [1.0])[0] for each in (start, *spread(start, 2, 1))) * (1 - 1e-6)
    alone = kg.Inverse(start, (FORCE, 1.0, "max"), corrections=None, evaluations=1).run(starts=3, seed=1)
    assert alone.worth == pytest.approx(-alone.coarse[0][0] / size, rel=1e-6)


def test_better_designs_leave_pictures(tmp_path):
    start = design(edge=1.0, stiffness="plate")
    wanted = forces(start.at(inner=0.8), [1.0])
    found = kg.Inverse(start, (FORCE, 1.0, wanted), corrections=None, evaluations=3).run(pictures=tmp_path)
    errors = [entry["error"] for entry in found.history]
    better = [k + 1 for k, error in enumerate(errors) if error < min([np.inf, *errors[:k]])]
    assert sorted(file.name for file in tmp_path.iterdir()) == [f"design_{number:04d}.png" for number in better]


def test_corrections_go_on_where_evaluations_ran_out():
    start = design(edge=1.0, stiffness="plate")
    wanted = 1.2 * forces(start, [1.0])
    found = kg.Inverse(start, (FORCE, 1.0, wanted), evaluations=1, corrections=1, finer=1.2, tolerance=1e-4).run()
    assert found.status == "out of evaluations"
    assert len(found.reached) == 1
    assert not found.verified
    assert found.error > 1e-4
    assert "corrected by the finer mesh" in found.message
    assert found.coarse_error == pytest.approx(abs(found.coarse[0][0] / wanted[0] - 1))


def test_what_was_walked_on_a_finer_mesh_is_not_told_of_a_later_design():
    """Interrupted while it goes on with corrected targets, the best design is one that no finer mesh has seen."""
    start = design(edge=1.0, stiffness="plate")
    wanted = 1.1 * forces(start, [1.0])

    first = kg.Inverse(start, (FORCE, 1.0, wanted), evaluations=3, corrections=0, finer=1.2).run()

    def stop(number, values, error):
        if number > first.evaluations + 1:
            raise KeyboardInterrupt

    problem = kg.Inverse(start, (FORCE, 1.0, wanted), evaluations=3, corrections=1, finer=1.2, tolerance=1e-6)
    found = problem.run(progress=stop)
    assert found.status == "interrupted"
    assert not found.reached
    assert not found.verified
    assert found.error == found.coarse_error


def test_a_mesh_that_gets_poor_is_made_anew_and_told():
    """What was walked before still counts."""
    start = design(stiffness="plate", inner=0.7, edge=0.6, tilt=(0.0, -1.5, 1.5)).at(tilt=0.8)
    search = Search(kg.Inverse(start, (FORCE, 1.0, 1.0)), start, None, False)
    with warnings.catch_warnings():
        warnings.simplefilter("error", kg.KirigamiWarning)
        assert search.trial(np.array([0.8])) is not None
    spent = search.branch.factorizations
    with pytest.warns(kg.KirigamiWarning, match="made anew"):
        assert search.trial(np.array([0.92])) is not None
    assert search.design.mesh.min_angle > 20
    assert search.branch.walks == 2
    assert search.branch.factorizations > spent


def test_bad_input():
    with pytest.raises(kg.ModelError, match="a target is"):
        kg.Inverse(design(), [("force", 1.0)])
    with pytest.raises(kg.ModelError, match="'max' or 'min'"):
        kg.Inverse(design(), (FORCE, 1.0, "most"))
    with pytest.raises(kg.ModelError, match="target of zero"):
        kg.Inverse(design(), (FORCE, 1.0, 0.0))
    with pytest.raises(kg.ModelError, match="leaves no room"):
        kg.Inverse(design(), (FORCE, 1.0, 1.0), [("ligament", 2.0, 1.0)])
    with pytest.raises(kg.ModelError, match="knows no constraints"):
        kg.Inverse(design(), (FORCE, 1.0, 1.0), [("ligament", 0.001, None)], method="least squares")
    with pytest.raises(kg.ModelError, match="finite"):
        kg.Inverse(design(), (lambda x, f: float("nan"), 1.0, 1.0), corrections=None).run()
