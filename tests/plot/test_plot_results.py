"""Pictures of deformed structures: facets, bars, colours, views and axes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
import shapely
from matplotlib import pyplot
from numpy.testing import assert_allclose
from plot_samples import frame_mesh, sheet_model

import kirigami as kg
from kirigami import plot
from kirigami.plot import style
from kirigami.plot.field import Field
from kirigami.results.smooth import sectors, surface_stress


def test_importing_the_plots_loads_no_matplotlib() -> None:
    program = "import sys, kirigami.plot; sys.exit('matplotlib' in sys.modules or 'shapely' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_nothing_turns_a_picture_that_is_drawn() -> None:
    """Outlines stand a little nearer to who looks: turned afterwards, they lay beside the sheets of two studies."""
    turning = [file.name for file in Path(kg.__file__).parent.rglob("*.py") if "view_init(" in file.read_text()]
    assert turning == ["style.py"]


def test_settings_of_the_session_stay_as_they_are(lifted: kg.Results) -> None:
    before = dict(matplotlib.rcParams)
    lifted.plot()
    lifted.plot_curve([2, 3])
    assert dict(matplotlib.rcParams) == before


def test_everything_draws_on_axes_of_the_caller(lifted: kg.Results, snapped: Any) -> None:
    _, flat = pyplot.subplots()
    solid = pyplot.figure().add_subplot(projection="3d")
    before = pyplot.get_fignums()
    assert lifted.plot(ax=solid) is solid
    assert sheet_model().plot(ax=solid) is solid
    for draw in (
        lambda: lifted.plot(ax=flat),
        lambda: sheet_model().plot(ax=flat),
        lambda: lifted.plot_curve([2, 3], ax=flat),
        lambda: plot.plot_open_area(lifted, ax=flat),
        lambda: plot.plot_mesh(frame_mesh(), ax=flat),
        lambda: plot.plot_sheet(kg.Sheet([(0, 0), (1, 0), (1, 1)]), ax=flat),
    ):
        assert draw() is flat
    assert pyplot.get_fignums() == before


def drawn(ax: Any) -> Any:
    return ax.collections[-1]


def test_facets_are_drawn_where_they_are(lifted: kg.Results) -> None:
    ax = lifted.plot(view="top", edges="none", step=1, smooth=False)
    corners = np.array([path.vertices[:3] for path in drawn(ax).get_paths()])
    expected = lifted.position()[1][lifted.mesh.triangles]
    order = np.argsort(expected[..., 2].mean(axis=1), kind="stable")  # what is higher covers what is lower
    assert_allclose(corners, expected[order][..., :2], atol=1e-12)


@pytest.mark.parametrize(("edges", "number"), [("boundary", 8), ("all", 16), ("none", 0)])
def test_edges_of_the_sheet_and_its_cuts(lifted: kg.Results, edges: str, number: int) -> None:
    paths = drawn(lifted.plot(view="top", edges=edges, smooth=False)).get_paths()
    assert len(paths) == len(lifted.mesh.triangles) + number


def test_colours_span_the_heights(lifted: kg.Results) -> None:
    ax = lifted.plot()
    bar = next(other for other in ax.figure.axes if other is not ax)
    height = lifted.position()[-1, :, 2]
    assert_allclose(bar.get_ylim(), (height.min(), height.max()))
    assert bar.get_ylabel() == "height z"


def test_smooth_pieces_tile_the_facets_and_take_the_colours_of_the_nodes(lifted: kg.Results) -> None:
    """Linear in between: the pieces of a facet cover it once, and a field that is linear in place is hit exactly."""
    rest = lifted.rest
    ax = lifted.plot(view="top", edges="none", step=0, color=3.0 * rest[:, 0] - rest[:, 1])
    pieces = np.array([path.vertices[:3] for path in drawn(ax).get_paths()])
    sides = pieces[:, 1:] - pieces[:, :1]
    areas = 0.5 * np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    assert areas.sum() == pytest.approx(lifted.mesh.facet_areas.sum(), rel=1e-9)
    assert len(pieces) > len(lifted.mesh.triangles)
    bar = next(other for other in ax.figure.axes if other is not ax)
    low, high = bar.get_ylim()
    middle = pieces.mean(axis=1)
    share = (3.0 * middle[:, 0] - middle[:, 1] - low) / (high - low)
    shown = drawn(ax).get_facecolor()[:, :3] / style.sequential_map()(share)[:, :3]
    assert np.ptp(shown, axis=1).max() < 0.05  # but for the light, which is the same for red, green and blue


def test_stress_jumps_across_a_fold_and_is_a_mean_elsewhere() -> None:
    """Two squares joined by a crease, one of them stretched: smooth values keep the two sides apart."""
    mesh = kg.Sheet([(0, 0), (2, 0), (2, 1), (0, 1)]).mesh(0.5, lines={"fold": shapely.LineString([(1, 0), (1, 1)])})
    m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e6, nu=0.0), stiffness="shell")
    fold = mesh.sets["fold"][np.argsort(mesh.nodes[mesh.sets["fold"], 1])]
    m.add(kg.Crease([m.nodes[k] for k in fold], stiffness=1.0))
    res = kg.Results(kg.System(m))
    u = np.zeros((len(mesh.nodes), 3))
    u[:, 0] = np.maximum(mesh.nodes[:, 0] - 1, 0) * 1e-3
    res.append(kg.Step.at(m, 1.0, u))
    parts = sectors(res)
    assert len(parts.node) == len(mesh.nodes) + len(fold)
    stress = surface_stress(res)[0]
    side = np.empty(len(parts.node))
    side[parts.corner] = (mesh.nodes[mesh.triangles].mean(axis=1)[:, 0] > 1)[:, None]
    assert stress == pytest.approx(np.where(side, 1e3, 0.0), rel=1e-2, abs=1e-6)
    plain = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e6, nu=0.0), stiffness="shell")
    whole = kg.Results(kg.System(plain))
    whole.append(kg.Step.at(plain, 1.0, u))
    between = surface_stress(whole)[0][mesh.sets["fold"]]
    assert ((between > 100) & (between < 900)).all()


def test_energy_per_area_adds_up_to_the_energy(lifted: kg.Results) -> None:
    for number in range(len(lifted)):
        density = Field(lifted, "energy").at(number)
        total = sum(part[number] for part in lifted.energy.values())
        assert (density * lifted.mesh.facet_areas).sum() == pytest.approx(total, rel=1e-12)


def test_values_of_the_caller_as_colours(snapped: Any) -> None:
    res, *_ = snapped
    assert_allclose(Field(res, [1.0, 3.0, 4.0]).at(0), [2.0, 3.5])  # three nodes: means over the two bars
    assert_allclose(Field(res, [7.0, 8.0]).at(0), [7.0, 8.0])


@pytest.mark.parametrize("view", [None, (0, 0), (90, -90), (12, 75), (-35, 200)])
@pytest.mark.parametrize("shape", ["as it is", "long", "high", "flat"])
def test_everything_is_in_view(lifted: kg.Results, view: Any, shape: str) -> None:
    stretch = {"as it is": (1, 1, 1), "long": (20, 1, 1), "high": (1, 1, 30), "flat": (1, 1, 0)}[shape]
    mesh = kg.TriMesh(frame_mesh().nodes * stretch + (0, 0, 0), frame_mesh().triangles)
    m = kg.Model.from_mesh(mesh, thickness=0.1, material=kg.Material(E=1e6))
    res = kg.Results(kg.System(m))
    res.append(kg.Step.at(m, 1.0, np.asarray(stretch) * lifted[-1].u))
    ax = res.plot(view=view)
    ax.figure.canvas.draw()
    from mpl_toolkits.mplot3d import proj3d

    x, y, _ = proj3d.proj_transform(*res.position()[0].T, ax.get_proj())
    pixels = ax.transData.transform(np.column_stack([x, y]))
    size = ax.figure.get_size_inches() * ax.figure.dpi
    assert (pixels > 0).all() and (pixels < size).all()
    # And it is not lost in the figure: it takes most of the width or of the height beside the colour bar.
    assert max(np.ptp(pixels, axis=0) / (size - (0.85 * ax.figure.dpi, 0))) > 0.85


def test_equal_scales_in_space(lifted: kg.Results) -> None:
    """A step of one unit along any axis has the length of its projection, whatever the box."""
    ax = lifted.plot(view=(30, 40))
    ax.figure.canvas.draw()
    from mpl_toolkits.mplot3d import proj3d

    points = np.vstack([np.zeros(3), np.eye(3)])
    x, y, _ = proj3d.proj_transform(*points.T, ax.get_proj())
    pixels = ax.transData.transform(np.column_stack([x, y]))
    lengths = np.linalg.norm(pixels[1:] - pixels[0], axis=1)
    up, round_z = np.radians((30, 40))
    towards_eye = np.array([np.cos(up) * np.cos(round_z), np.cos(up) * np.sin(round_z), np.sin(up)])
    seen = np.sqrt(1 - towards_eye**2)
    assert_allclose(lengths / lengths[0], seen / seen[0], rtol=1e-6)


def test_bars_are_lines_over_their_rest_state(snapped: Any) -> None:
    res, *_ = snapped
    ax = res.plot(step=4)
    behind, bars = ax.collections[:2]
    assert_allclose(behind.get_segments()[0], [(-1, 0), (0, 1)])
    assert_allclose(bars.get_segments()[0], res.position()[4, [0, 1], :2])
    low, high = (other for other in ax.figure.axes if other is not ax).__next__().get_ylim()
    assert low == -high == -np.abs(res.bar_force[4]).max()  # compression and tension weigh the same


def test_magnified_displacements(snapped: Any) -> None:
    res, *_ = snapped
    bars = res.plot(step=1, magnify=3.0).collections[1]
    assert_allclose(bars.get_segments()[0][1], (0, 1 + 3 * res.u[1, 1, 1]))


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"step": 99}, "step 99 is not stored"),
        ({"step": -99}, "step -99 is not stored"),
        ({"step": 0.5}, "step must be a whole number"),
        ({"color": "hight"}, "height, displacement, energy, stress, plastic strain, none"),
        ({"color": "force"}, "'force' is unknown"),
        ({"color": np.ones(3)}, "8 nodes or 8 facets"),
        ({"color": np.full(8, np.nan)}, "finite"),
        ({"edges": "some"}, "'boundary', 'all', 'none'"),
        ({"view": "side"}, "view must be"),
        ({"view": (1, 2, 3)}, "view must be"),
        ({"magnify": np.inf}, "magnify"),
        ({"cmap": "viridiss"}, "cmap"),
    ],
)
def test_plot_results_refuses(lifted: kg.Results, options: dict[str, Any], complaint: str) -> None:
    with pytest.raises(kg.ModelError, match=complaint):
        lifted.plot(**options)


def test_axes_and_view_must_agree(lifted: kg.Results) -> None:
    _, flat = pyplot.subplots()
    solid = pyplot.figure().add_subplot(projection="3d")
    with pytest.raises(kg.ModelError, match="projection='3d'"):
        lifted.plot(ax=flat, view="3d")
    with pytest.raises(kg.ModelError, match="flat axes"):
        lifted.plot(ax=solid, view="top")
    with pytest.raises(kg.ModelError, match="view"):
        sheet_model().plot(ax=flat, view="3d")
    with pytest.raises(kg.ModelError, match="in the plane"):
        plot.plot_mesh(frame_mesh(), ax=solid)
    with pytest.raises(kg.ModelError, match="no nodes"):
        kg.Model().plot()
