"""Pictures of sheets, meshes and models at rest."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from plot_samples import frame_mesh, sheet_model, truss
from shapely import Polygon
from shapely.ops import unary_union

import kirigami as kg
from kirigami import plot


def test_model_with_supports_and_loads() -> None:
    ax = truss()[0].plot()
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["fixed xy", "fixed x", "load"]
    arrow = next(c for c in ax.collections if type(c).__name__ == "Quiver")
    assert arrow.U[0] == 0 and arrow.V[0] < 0
    assert ax.get_ylim()[0] <= 1 + arrow.V[0]
    bare = truss()[0].plot(supports=False, loads=False)
    assert bare.get_legend() is None


@pytest.mark.parametrize("height", [0.1, 0.7, 1.0, 3.0])
def test_a_legend_lies_below_the_name_of_the_axis(height: float) -> None:
    """It was hung by a part of the picture's height, so that in a low one it lay on the axis."""
    m = kg.Model(dim=2)
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, height), kg.Node(1, 0))
    m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0), kg.Fix([left, right]))
    ax = m.plot()
    ax.figure.canvas.draw()
    assert ax.get_legend().get_window_extent().y1 <= ax.xaxis.label.get_window_extent().y0


def test_what_is_shaded_has_no_seams() -> None:
    """Facets that let the sheet shine through were drawn one by one, with pale lines between."""
    m = kg.Model.from_mesh(frame_mesh(), thickness=0.1, material=kg.Material(E=1e6))
    m.add(kg.Fix(m.nodes))
    ax = m.plot()
    (shade,) = [patch for patch in ax.patches if patch.get_alpha() not in (None, 1.0)]
    rings = shade.get_path().to_polygons()
    outer, *openings = sorted((Polygon(ring).area for ring in rings), reverse=True)
    assert openings and outer - sum(openings) == pytest.approx(m.mesh.facet_areas.sum())
    assert "fixed xyz" in [text.get_text() for text in ax.get_legend().get_texts()]


def test_loads_spread_over_a_sheet_are_drawn_in_its_middle() -> None:
    m = kg.Model.from_mesh(frame_mesh(), thickness=0.1, material=kg.Material(E=1e6, density=1.0))
    m.add(kg.Gravity((0, -9.81, 0)), kg.AreaLoad((1.0, 0, 0), facets=[0, 1]))
    arrows = next(c for c in m.plot().collections if type(c).__name__ == "Quiver")
    mesh = m.mesh
    middle = np.average(mesh.nodes[mesh.triangles].mean(axis=1), axis=0, weights=mesh.facet_areas)[:2]
    assert len(arrows.U) == 2 and any(np.allclose(tail, middle) for tail in arrows.XY)
    m.add(kg.Gravity())  # towards who looks: no arrow, and no error
    assert m.plot(view=(30, -60)).name == "3d" and m.plot(view="top").name == "rectilinear"


def test_held_facets_of_a_sheet_are_shaded() -> None:
    m = kg.Model.from_mesh(frame_mesh(), thickness=0.1, material=kg.Material(E=1e6))
    m.add(kg.Fix([m.nodes[k] for k in (0, 1, 5, 4, 2)]))  # two facets, and a node by itself
    ax = m.plot()
    (shade,) = (Polygon(ring) for ring in ax.patches[-1].get_path().to_polygons())
    facets = [m.mesh.nodes[corners, :2] for corners in m.mesh.triangles if set(corners) <= {0, 1, 5, 4, 2}]
    assert len(facets) == 2 and shade.symmetric_difference(unary_union([Polygon(one) for one in facets])).area < 1e-12
    alone = [line for line in ax.lines if line.get_marker() == "s"]
    assert_allclose(alone[0].get_xydata(), [(3, 3)])


def test_nearly_flat_sheets_are_seen_from_above_and_others_in_space() -> None:
    m = sheet_model()
    assert m.plot().name == "rectilinear"
    m.perturb(np.linspace(0, 2, 8))
    assert m.plot().name == "3d"
    assert m.plot(view="top").name == "rectilinear"


def test_drawing_of_a_sheet() -> None:
    from shapely import LineString, box

    sheet = kg.Sheet(box(0, 0, 4, 2), [LineString([(1, 0.5), (1, 1.5)]), box(2, 0.5, 3, 1.5)])
    ax = sheet.plot()
    assert_allclose(ax.lines[0].get_xydata(), [(1, 0.5), (1, 1.5)])
    ax.figure.canvas.draw()
    pixels = np.asarray(ax.figure.canvas.buffer_rgba())
    seen = [tuple(pixels[-int(y), int(x), :3]) for x, y in ax.transData.transform([(0.5, 1.0), (2.5, 1.0), (3.5, 1.0)])]
    assert seen[0] == seen[2] != (255, 255, 255)
    assert seen[1] == (255, 255, 255)  # one looks through the opening


def test_drawing_of_a_mesh() -> None:
    mesh = frame_mesh()
    ax = plot.plot_mesh(mesh)
    edges, outlines, lips = (collection.get_segments() for collection in ax.collections)
    assert len(edges) == len(mesh.edges)
    assert [len(loop) for loop in outlines] == [5, 5]
    assert_allclose(np.unique(lips[0], axis=0), np.unique(mesh.nodes[4:, :2], axis=0))
