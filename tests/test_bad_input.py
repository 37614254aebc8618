"""Bad input gets a typed error that names the thing and the place."""

from __future__ import annotations

import math
import pydoc
import subprocess
import sys

import numpy as np
import pytest
import shapely

import kirigami as kg


@pytest.fixture
def nodes() -> list[kg.Node]:
    return [kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1), kg.Node(0, -1), kg.Node(2, 0)]


def truss(dim: int = 2) -> tuple[kg.Model, tuple[kg.Node, ...]]:
    m = kg.Model(dim=dim)
    points = m.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0))
    m.add(kg.Bar(points[0], points[1], EA=1.0), kg.Bar(points[1], points[2], EA=1.0))
    return m, points


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, "stiff", None])
def test_stiffness_must_be_positive_and_finite(nodes, value):
    i, j, k, l, _ = nodes
    for make in (
        lambda: kg.Bar(j, k, EA=value),
        lambda: kg.BendHinge(k, i, j, l, value),
        lambda: kg.TorsionSpring3(j, i, k, value),
        lambda: kg.Material(E=value),
    ):
        with pytest.raises(kg.ModelError, match="(EA|stiffness|E) must be"):
            make()


@pytest.mark.parametrize("position", [(math.nan, 0), (0, math.inf), ("x", 0)])
def test_node_coordinates_must_be_finite(position):
    with pytest.raises(kg.ModelError, match="Node: coordinates"):
        kg.Node(*position)


def test_repeated_nodes(nodes):
    i, j, k, *_ = nodes
    with pytest.raises(kg.ModelError, match="itself"):
        kg.Bar(i, i, EA=1.0)
    with pytest.raises(kg.ModelError, match="four nodes must differ"):
        kg.BendHinge(i, j, k, i, 1.0)
    with pytest.raises(kg.ModelError, match="three nodes must differ"):
        kg.TorsionSpring3(i, j, i, 1.0)


def test_zero_length_bar_is_named_with_its_nodes():
    m = kg.Model()
    a, b, c = m.add(kg.Node(0, 0), kg.Node(3, 4), kg.Node(3, 4, name="twin"))
    m.add(kg.Bar(a, b, 1.0), kg.Bar(b, c, 1.0))
    with pytest.raises(kg.ModelError, match="zero length.*node 1 .*node 2 .*twin"):
        kg.System(m)


def test_collinear_wing_is_named():
    m = kg.Model()
    i, j, k, l = m.add(kg.Node(0.5, 0), kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, -1))
    m.add(kg.BendHinge(i, j, k, l, 1.0))
    with pytest.raises(kg.ModelError, match="wing node 0 .*stand off the line"):
        kg.System(m)


def test_foreign_and_double_nodes(nodes):
    m = kg.Model()
    i, j, *_ = nodes
    m.add(i)
    with pytest.raises(kg.ModelError, match="not in this model: add the node first"):
        m.add(kg.Bar(i, j, 1.0))
    with pytest.raises(kg.ModelError, match="already in the model"):
        m.add(i)
    with pytest.raises(kg.ModelError, match="unpack lists"):
        m.add([j])
    with pytest.raises(kg.ModelError, match="expected nodes"):
        kg.Fix([0, 1])


def test_dangling_node_is_named():
    m, _ = truss()
    m.add(kg.Node(5, 5, name="lost"))
    with pytest.raises(kg.ModelError, match="dangling.*node 3 .*lost"):
        kg.System(m)


def test_constraints_in_conflict_are_named():
    m, (left, apex, right) = truss()
    m.add(kg.Fix([left, right]), kg.Prescribe(right, x=0.1))
    with pytest.raises(kg.ModelError, match="both constrain x of node 2"):
        kg.System(m)
    m, (left, apex, right) = truss()
    m.add(kg.Fix([left, left]))
    with pytest.raises(kg.ModelError, match="lists node 0 .* twice"):
        kg.System(m)


def test_ties_in_a_circle():
    m, (left, apex, right) = truss()
    m.add(kg.Tie(left, right, "x"), kg.Tie(right, left, "x"))
    with pytest.raises(kg.ModelError, match="circle"):
        kg.System(m)


def test_no_support_names_every_rigid_motion():
    m, (_, apex, _) = truss()
    m.add(kg.NodalLoad(apex, (0, -1)))
    with pytest.raises(kg.MechanismError, match="translation along x, translation along y, rotation in the plane") as e:
        kg.LinearStatic(m).run()
    assert e.value.nodes == [0, 1, 2]


def test_one_missing_support_is_named():
    m, (left, apex, right) = truss()
    m.add(kg.Fix(left), kg.NodalLoad(apex, (0, -1)))
    with pytest.raises(kg.MechanismError, match="rotation"):
        kg.DisplacementControl(m, to=-0.1, control=(apex, "y")).run()


def test_floppy_motion_is_named():
    """The middle node of two bars in one line has nothing to hold it sideways."""
    m = kg.Model(dim=2)
    left, middle, right = m.add(kg.Node(0, 0), kg.Node(1, 0, name="middle"), kg.Node(2, 0))
    m.add(kg.Bar(left, middle, 1.0), kg.Bar(middle, right, 1.0), kg.Fix([left, right]), kg.NodalLoad(middle, (0, 1)))
    with pytest.raises(kg.MechanismError, match="floppy.*1 Node.*middle.*along y") as e:
        kg.LinearStatic(m).run()
    assert e.value.nodes == [1]
    np.testing.assert_allclose(np.abs(e.value.shape[1]), [0, 1, 0], atol=1e-6)


def test_out_of_plane_swing_of_a_flat_truss_is_named():
    m, (left, apex, right) = truss(dim=3)
    m.add(kg.Fix([left, right]), kg.NodalLoad(apex, (0, -1)))
    with pytest.raises(kg.MechanismError, match="axis through its supports"):
        kg.LinearStatic(m).run()


def test_nothing_drives_the_model():
    m, (left, apex, right) = truss()
    m.add(kg.Fix([left, right]))
    for analysis in (kg.LinearStatic(m), kg.LoadControl(m), kg.ArcLength(m, step=0.1)):
        with pytest.raises(kg.ModelError, match="nothing drives"):
            analysis.run()
    with pytest.raises(kg.ModelError, match="no Prescribe drives"):
        kg.DisplacementControl(m).run()


def test_empty_models():
    with pytest.raises(kg.ModelError, match="no nodes"):
        kg.System(kg.Model())
    m = kg.Model()
    m.add(kg.Node(0, 0))
    with pytest.raises(kg.ModelError, match="no elements"):
        kg.System(m)


def test_empty_selection_says_where_the_nodes_are():
    m, _ = truss()
    with pytest.raises(kg.ModelError, match="no node meets.*x -1 to 1"):
        m.select(box=(5, 5, 6, 6))
    with pytest.raises(kg.ModelError, match="at least one"):
        m.select()
    with pytest.raises(kg.ModelError, match="4 or 6"):
        m.select(box=(1, 2))
    with pytest.raises(kg.ModelError, match="from_mesh"):
        m.select(boundary="top")
    with pytest.raises(kg.ModelError, match="empty"):
        kg.Fix([])


def test_dimension_mismatch():
    m = kg.Model(dim=2)
    with pytest.raises(kg.ModelError, match="dim=2"):
        m.add(kg.Node(0, 0, 1))
    i, j, k, l = m.add(kg.Node(0, 1), kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, -1))
    m.add(kg.BendHinge(i, j, k, l, 1.0))
    with pytest.raises(kg.ModelError, match="dim=3"):
        kg.System(m)
    m = kg.Model()
    i, j, k = m.add(kg.Node(0, 1), kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.TorsionSpring3(i, j, k, 1.0))
    with pytest.raises(kg.ModelError, match="dim=2"):
        kg.System(m)


def test_stale_system_refuses():
    m, (left, apex, right) = truss()
    system = kg.System(m)
    m.add(kg.Fix(left))
    with pytest.raises(kg.ModelError, match="edited after"):
        system.stiffness()


def test_perturb_checks_its_shape():
    m, _ = truss()
    for shape in (3.0, np.ones(2), np.ones((3, 5)), np.full(3, math.nan)):
        with pytest.raises(kg.ModelError, match="perturb"):
            m.perturb(shape)
    with pytest.raises(kg.ModelError, match="zero everywhere"):
        m.perturb(np.zeros((3, 3)), amplitude=1.0)


def test_analysis_arguments():
    m, (left, apex, right) = truss()
    m.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
    with pytest.raises(kg.ModelError, match="to must be"):
        kg.LoadControl(m, to=math.nan)
    with pytest.raises(kg.ModelError, match="step must not be zero"):
        kg.ArcLength(m, step=0)
    with pytest.raises(kg.ModelError, match="tol must be positive"):
        kg.LoadControl(m, tol=0)
    for bad in ("abc", [1j], [[0.1], [0.2, 0.3]], [math.inf], {0.1}, [10**400], [None], [True]):
        with pytest.raises(kg.ModelError, match="targets must be"):
            kg.LoadControl(m, to=0.1, targets=bad)
    with pytest.raises(kg.ModelError, match="control must be"):
        kg.DisplacementControl(m, control=apex)
    with pytest.raises(kg.ModelError, match="constrained"):
        kg.DisplacementControl(m, control=(left, "x")).run()
    with pytest.raises(kg.ModelError, match="on_failure"):
        kg.LoadControl(m).run(on_failure="ignore")
    with pytest.raises(kg.ModelError, match="modes asked for"):
        kg.Eigen(m, n=3).run()


def test_failure_carries_the_results():
    """Beyond its limit load of 0.136 a load-controlled truss has no neighbouring equilibrium."""
    m, (left, apex, right) = truss()
    m.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
    with pytest.raises(kg.ConvergenceError) as caught:
        kg.LoadControl(m, to=0.2).run()
    error = caught.value
    assert error.results is not None and 0.13 < error.results.lam[-1] < 0.13608276349
    assert error.history and error.worst_nodes[0] == 1 and "limit point" in error.hint
    with pytest.warns(kg.KirigamiWarning):
        res = kg.LoadControl(m, to=0.2).run(on_failure="return")
    assert res.events[-1].kind == "failed" and res.lam[-1] == error.results.lam[-1]


def test_a_misspelt_name_is_answered_with_the_right_one():
    with pytest.raises(AttributeError, match="'Nod': did you mean 'Node'"):
        kg.Nod  # noqa: B018


def test_the_right_name_is_told_once():
    """As a person sees it: Python adds a hint of its own to what it prints where it can."""
    ran = subprocess.run([sys.executable, "-c", "import kirigami as kg; kg.strech"], capture_output=True, text=True)
    assert ran.returncode and ran.stderr.lower().count("did you mean") == 1 and ran.stderr.count("'stretch'") == 1


def test_an_empty_outline_is_told():
    """As a difference or an intersection of shapes may be; an empty cut is none."""
    with pytest.raises(kg.GeometryError, match="the outline is empty"):
        kg.Sheet(shapely.Polygon())
    assert kg.Sheet(shapely.box(0, 0, 1, 1), shapely.LineString()).cuts == ()


@pytest.mark.parametrize("kind", ["dxf", "svg", "geojson", "fold"])
def test_a_mistyped_option_of_a_reader_is_answered_with_the_nearest_one(kind):
    with pytest.raises(kg.GeometryError, match="without the option tolerence: did you mean `tolerance`"):
        getattr(kg.Sheet, f"from_{kind}")(f"plate.{kind}", tolerence=0.1)


def test_help_of_what_lives_elsewhere_is_that_of_the_function():
    """In a class such a function is itself; in a module it used to have the documentation of what stands for it."""
    from kirigami.geometry.graded import graded_slits
    from kirigami.study.effective import report

    assert kg.stiffness.report.__doc__ == report.__doc__ and kg.cuts.graded_slits.__doc__ == graded_slits.__doc__
    assert report.__doc__.splitlines()[0] in pydoc.render_doc(kg.stiffness.report, renderer=pydoc.plaintext)
