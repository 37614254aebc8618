"""Creases that end inside a sheet, and what shell facets refuse of a mesh, each with its place."""

import warnings

import numpy as np
import pytest
import shapely

import kirigami as kg

E, T = 1e6, 0.02


def cantilever(crease=None, stiffness=0.0, rest_angle=None):
    """A square clamped on the left and bent by its right edge, with a crease across it from y = 0 up to `crease`."""
    lines = {} if crease is None else {"fold": [(0.5, 0), (0.5, crease)]}
    mesh = kg.Sheet([(0, 0), (1, 0), (1, 1), (0, 1)]).mesh(
        0.15, lines={"fold": shapely.LineString([(0.5, 0), (0.5, 1)])}
    )
    model = kg.Model.from_mesh(mesh, T, kg.Material(E, 0.3), stiffness="shell")
    if lines:
        along = [k for k in mesh.sets["fold"].tolist() if mesh.nodes[k, 1] < crease + 1e-9]
        along.sort(key=lambda k: mesh.nodes[k, 1])
        model.add(kg.Crease([model.nodes[k] for k in along], stiffness, rest_angle))
    right = model.select(boundary="right")
    model.add(kg.Fix(model.select(boundary="left"), clamp=True), kg.EdgeLoad(right, (0, 0, 1e-3)))
    return model, right


def deflection(*args, **options):
    model, right = cantilever(*args, **options)
    return kg.LinearStatic(model).run().position(right)[-1, :, 2].mean()


def test_a_crease_may_end_inside_the_sheet():
    """It softens the sheet by as much as it is long and soft; a stiff one is no crease, a free one no mechanism."""
    whole = deflection()
    half = 0.52  # the line of nodes goes on, the crease does not
    assert deflection(half, 1e6 * E * T**3) == pytest.approx(whole, rel=1e-4)
    free, soft, through = deflection(half, 0.0), deflection(half, 0.1 * E * T**3), deflection(1.0, 0.1 * E * T**3)
    assert whole < soft < free < 10 * whole and soft < through
    # a crease right through is a hinge in series: it turns by the moment of the load, which is 0.5 away
    assert through - whole == pytest.approx(1e-3 * 0.5**2 / (0.1 * E * T**3), rel=0.03)


@pytest.mark.parametrize("rung", ["plate", "facet", "shell"])
def test_a_fold_that_ends_inside_is_told_with_its_place(rung):
    """Creases by hand and folds of a mesh, on every rung; ends at a rim, a cut or another fold are none."""
    model, _ = cantilever(0.52, 1.0)
    with pytest.warns(kg.KirigamiWarning, match=r"Crease: 1 end of folds inside the sheet, .* \(0.5, 0.4"):
        kg.System(model)

    def folded(*lines):
        cut = shapely.LineString([(0.5, 0.2), (0.5, 0.5)])
        sheet = kg.Sheet(shapely.box(0, 0, 1, 1), cut, T, kg.Material(E), folds=[kg.Fold(line) for line in lines])
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="the mesh is biased")
            kg.Model.from_mesh(sheet.mesh(0.25), stiffness=rung)

    with pytest.warns(kg.KirigamiWarning, match=r"Model.from_mesh: 1 end of folds inside .* \(0.2, 0.7\)"):
        folded([(0.2, 0.7), (1.0, 0.7)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        folded([(0.0, 0.7), (1.0, 0.7)], [(0.5, 0.5), (0.5, 0.7)])


def test_a_thickness_that_jumps_between_facets_by_hand_is_told_with_its_place():
    for kind in (kg.Facet, kg.ShellFacet):
        model = kg.Model()
        a, b, c, d = model.add(*(kg.Node(*place) for place in ((0, 0), (1, 0), (1, 1), (0, 1))))
        model.add(kind(a, b, c, 1e-4, kg.Material(E)), kind(a, c, d, 0.02, kg.Material(E)))
        with pytest.warns(kg.KirigamiWarning, match=rf"^{kind.__name__}: the thickness jumps at \(0.6.*factor of 200"):
            kg.System(model)


def test_a_crease_that_ends_inside_folds_a_sheet_into_a_cone():
    """Its rest angle is taken up by the sheet around the end: the sheet stores energy, in balance and stable."""
    model, _ = cantilever(0.52, 1.0 * E * T**3, 0.5)
    model.remove(*model.loads)
    results = kg.LoadControl(model).run()
    assert results.stable.all() and results.energy["shell"][-1] > 0
    free, _ = cantilever(1.0, 1.0 * E * T**3, 0.5)
    free.remove(*free.loads)
    flat = kg.LoadControl(free).run()
    assert flat.energy["shell"][-1] < 0.05 * results.energy["shell"][-1]  # a crease right through is free


def bent_pair(normals):
    model = kg.Model()
    nodes = model.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1))
    model.add(kg.ShellFacet(*nodes, 0.01, kg.Material(E), normals=normals), kg.Fix(nodes, "xyz"))
    return model


def test_middles_far_off_their_edges_are_refused_with_the_place():
    up = np.array([0, 0, 1.0])
    for lean in (0.3, 0.7):  # up to a right angle between the slopes of an edge
        kg.System(bent_pair([up + lean * np.array([-1, 0, 0]), up + lean * np.array([1, 0, 0]), up]))
    for normals, words in (
        ([(-3, 0, 1), (3, 0, 1), (0, 0, 1)], r"edge from node 0 Node\(0, 0, 0\) to node 1 .* of its length off it"),
        ([(1, 0, 0), (1, 0, 0), (0, 0, 1)], "edge from node 0 .* they lie along it"),
    ):
        with pytest.raises(kg.ModelError, match=words):
            kg.System(bent_pair(normals))


def test_facets_without_area_are_refused_with_the_place():
    model = kg.Model()
    nodes = model.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    model.add(kg.ShellFacet(*nodes, 0.01, kg.Material(E)), kg.Fix(nodes))
    with pytest.raises(kg.ModelError, match=r"ShellFacets? without area, the first on node 0"):
        kg.LinearStatic(model).run()
