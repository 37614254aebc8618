"""Pictures of what sheets bear: bands unasked, colours beside the tips of cuts, gradients per area."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from mpl_toolkits.mplot3d.proj3d import proj_transform

import kirigami as kg
from kirigami.results.smooth import surface_stress


def test_the_curve_of_a_stretched_sheet_has_its_band_unasked() -> None:
    sheet = kg.Sheet(shapely.box(0, 0, 0.05, 0.1), (), 1e-4, kg.Material(E=2e9, nu=0.3))
    res = kg.stretch(sheet, strain=0.002, accuracy="draft", max_edge=0.03)
    ax = res.plot_curve()
    assert "estimated error" in [text.get_text() for text in ax.get_legend().get_texts()]
    shaded = ax.collections[0].get_paths()[0].vertices[:, 1]
    assert shaded.max() == pytest.approx(res.drives[0].force(res)[-1] * (1 + res.error["force"][-1]))
    assert not res.plot_curve(band=False).collections


def test_colours_of_stress_leave_out_the_tips_of_cuts() -> None:
    """Colours span 99.5 % of the area, whatever the mesh does to the peak; a point of the colour bar says so."""
    slit = shapely.LineString([(0.01, 0.05), (0.04, 0.05)])
    sheet = kg.Sheet(shapely.box(0, 0, 0.05, 0.1), (slit,), 1e-4, kg.Material(E=2e9, nu=0.3))
    highest, peaks = [], []
    for nodes in (300, 1200):
        mesh = sheet.mesh(nodes=nodes)
        m = kg.Model.from_mesh(mesh, stiffness="shell")
        top = m.select(boundary="top")
        m.add(kg.Fix(m.nodes, "z"), kg.Fix(m.select(boundary="bottom"), "xy"), kg.Prescribe(top, x=0, y=1e-4))
        res = kg.LinearStatic(m).run()
        ax = res.plot(color="stress", view="top")
        highest.append(ax.figure.axes[1].get_ylim()[1])
        peaks.append(surface_stress(res)[-1].max())
    assert peaks[1] > 1.3 * peaks[0] > 1.3 * highest[0]
    assert highest[1] == pytest.approx(highest[0], rel=0.15)


@pytest.mark.parametrize("view", [(30, -62), (-30, -68), (50, 140)])
def test_rims_are_whole_lines_from_any_side(view: tuple[float, float]) -> None:
    """Ink along all of the rim, also where facets beside it are nearer to who looks; from below lines lay off it."""
    mesh = kg.Sheet(shapely.box(0, 0, 1, 1), (), 0.01, kg.Material(1e6)).mesh(max_edge=0.3)
    m = kg.Model.from_mesh(mesh)
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(m.nodes, "yz"), kg.Fix(left, "x"), kg.Prescribe(right, x=0.01))
    ax = kg.LinearStatic(m).run().plot(color="none", view=view)
    ax.figure.set_dpi(100)
    ax.figure.canvas.draw()
    picture = np.asarray(ax.figure.canvas.buffer_rgba())[..., :3].min(axis=2)
    along = np.linspace(0.02, 0.98, 60)
    sides = [(along, 0 * along), (along, 0 * along + 1), (0 * along, along), (0 * along + 1, along)]
    for x, y in sides:
        flat = proj_transform(1.01 * x, y, 0 * x, ax.get_proj())[:2]
        column, row = ax.transData.transform(np.transpose(flat)).T
        row = picture.shape[0] - row
        ink = [picture[int(r) - 2 : int(r) + 3, int(c) - 2 : int(c) + 3].min() for r, c in zip(row, column)]
        assert max(ink) < 150


def test_gradient_is_drawn_per_area():
    """What each facet counts for its size; the scale is the same to both sides."""
    mesh = kg.TriMesh([[0, 0], [2, 0], [2, 1], [0, 1], [4, 0]], [[0, 1, 2], [0, 2, 3], [1, 4, 2]])
    ax = kg.plot.plot_gradient(mesh, 3.0 * mesh.facet_areas * [1, 1, -0.5])
    drawn = ax.collections[0]
    assert np.asarray(drawn.get_array()).tolist() == pytest.approx([3.0, 3.0, -1.5])
    assert drawn.get_clim() == pytest.approx((-3.0, 3.0))
