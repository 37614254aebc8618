"""Pictures: what is drawn is what was computed, everything drawn is in view, and nothing else is touched."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
import shapely
from matplotlib import pyplot
from numpy.testing import assert_allclose
from PIL import Image

import kirigami as kg
from kirigami import plot
from kirigami.plot import deformed, style
from kirigami.results.smooth import sectors, surface_stress

matplotlib.use("Agg")

UNIT = 1 / (3 * np.sqrt(3) * np.sqrt(2))  # limit load over EA of the truss of half-width and height 1, in Green strain


@pytest.fixture(autouse=True)
def _close_figures() -> Iterator[None]:
    yield
    pyplot.close("all")


def truss() -> tuple[kg.Model, kg.Node, kg.Node]:
    m = kg.Model(dim=2)
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0))
    m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
    m.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
    return m, left, apex


@pytest.fixture(scope="module")
def snapped() -> tuple[kg.Results, kg.Node, kg.Node]:
    m, left, apex = truss()
    return kg.DisplacementControl(m, to=-2.0, control=(apex, "y")).run(), left, apex


def frame_mesh() -> kg.TriMesh:
    """A square frame of side 3 round a hole of side 1."""
    nodes = [(0, 0), (3, 0), (3, 3), (0, 3), (1, 1), (2, 1), (2, 2), (1, 2)]
    facets = [(0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7)]
    return kg.TriMesh(nodes, facets)


def sheet_model() -> kg.Model:
    """The frame, held at the bottom and pulled up and out of its plane at the top."""
    m = kg.Model.from_mesh(frame_mesh(), thickness=0.1, material=kg.Material(E=1e6))
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.Prescribe(top, y=0.3, z=0.6))
    return m


@pytest.fixture(scope="module")
def lifted() -> kg.Results:
    return kg.DisplacementControl(sheet_model(), targets=[0.1, 0.5]).run()


# ---- manners


def test_importing_the_plots_loads_no_matplotlib() -> None:
    program = "import sys, kirigami.plot; sys.exit('matplotlib' in sys.modules or 'shapely' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


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


# ---- deformed structures


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


def test_two_curves_have_two_colours(snapped: Any) -> None:
    res, left, apex = snapped
    ax = res.plot_curve(x=(apex, "y"), label="first")
    count = len(ax.lines)
    res.plot_curve(x=-res.u[:, 1, 1], ax=ax, label="second")
    assert {line.get_color() for line in ax.lines[:count]} & {line.get_color() for line in ax.lines[count:]} == set()


def test_energy_per_area_adds_up_to_the_energy(lifted: kg.Results) -> None:
    for number in range(len(lifted)):
        density = deformed.Field(lifted, "energy").at(number)
        total = sum(part[number] for part in lifted.energy.values())
        assert (density * lifted.mesh.facet_areas).sum() == pytest.approx(total, rel=1e-12)


def test_values_of_the_caller_as_colours(snapped: Any) -> None:
    res, *_ = snapped
    assert_allclose(deformed.Field(res, [1.0, 3.0, 4.0]).at(0), [2.0, 3.5])  # three nodes: means over the two bars
    assert_allclose(deformed.Field(res, [7.0, 8.0]).at(0), [7.0, 8.0])


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


# ---- curves


def test_the_curve_turns_at_the_limit_points(snapped: Any) -> None:
    res, _, apex = snapped
    ax = res.plot_curve(x=(apex, "y"))
    lines = {line.get_label(): line for line in ax.lines}
    w = 1 - 1 / np.sqrt(3)
    assert_allclose(lines["limit point"].get_xydata(), [(-w, UNIT), (w - 2, -UNIT)], rtol=1e-5)
    unstable = lines["unstable"].get_xydata()
    assert_allclose(unstable[[0, -1]], [(-w, UNIT), (w - 2, -UNIT)], rtol=1e-5)
    assert lines["unstable"].is_dashed() and not lines["stable"].is_dashed()
    assert (lines["stable"].get_xdata() > -w - 1e-5).all()


def test_reaction_over_the_load_factor(snapped: Any) -> None:
    """Each support carries half of the load; at limit points too, which are steps of no store."""
    res, left, _ = snapped
    ax = res.plot_curve([left], "y")
    for line in ax.lines:
        assert_allclose(line.get_ydata(), 0.5 * np.asarray(line.get_xdata()), atol=1e-9)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("load factor", "reaction along y")


def test_two_runs_on_one_picture(snapped: Any) -> None:
    res, _, apex = snapped
    ax = res.plot_curve(x=(apex, "y"), label="first")
    res.plot_curve(x=-res.u[:, 1, 1], ax=ax, label="mirrored", color="k")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["first", "mirrored"]


def test_curves_of_loaded_results(lifted: kg.Results, tmp_path: Path) -> None:
    again = kg.load(lifted.save(tmp_path / "lifted.npz"))
    here, there = lifted.plot_curve([2, 3]).lines[-1], again.plot_curve([2, 3]).lines[-1]
    assert_allclose(there.get_xydata(), here.get_xydata())
    assert again.plot() is not None


def test_open_area_curve(lifted: kg.Results) -> None:
    strain = 0.1 * lifted.lam
    ax = plot.plot_open_area(lifted, x=strain)
    assert_allclose(ax.lines[-1].get_xydata(), np.column_stack([strain, lifted.open_area(union=True)]))


# ---- undeformed


def test_model_with_supports_and_loads() -> None:
    ax = truss()[0].plot()
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["fixed xy", "fixed x", "load"]
    arrow = next(c for c in ax.collections if type(c).__name__ == "Quiver")
    assert arrow.U[0] == 0 and arrow.V[0] < 0
    assert ax.get_ylim()[0] <= 1 + arrow.V[0]
    bare = truss()[0].plot(supports=False, loads=False)
    assert bare.get_legend() is None


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
    shaded = ax.collections[-1].get_paths()
    centres = sorted(tuple(path.vertices[:3].mean(axis=0)) for path in shaded)
    assert_allclose(centres, [(1, 2 / 3), (5 / 3, 1 / 3)])
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


# ---- animation


def test_frames_are_even_in_the_load_factor(
    lifted: kg.Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[Any] = []
    update = deformed.Picture.update
    monkeypatch.setattr(deformed.Picture, "update", lambda self, x, v: (shown.append(x.copy()), update(self, x, v)))
    done: list[int] = []
    path = lifted.animate(tmp_path / "new" / "lift.gif", frames=5, fps=10, on_frame=done.append)
    assert done == [1, 2, 3, 4, 5]
    pulled = np.array(shown)[:, 2, 1] - 3.0  # a driven displacement is linear in the load factor
    assert_allclose(pulled, 0.3 * np.linspace(0, 1, 5), atol=1e-12)
    with Image.open(path) as gif:
        assert (gif.n_frames, gif.format) == (5, "GIF")
        assert gif.info["duration"] == 100
    assert [other.name for other in path.parent.iterdir()] == ["lift.gif"]


def test_a_video_holds_the_frames_and_then_the_last_for_a_second(lifted: kg.Results, tmp_path: Path) -> None:
    video = pytest.importorskip("imageio.v3")
    pytest.importorskip("imageio_ffmpeg")
    lifted.animate(tmp_path / "lift.gif", frames=5, fps=10, dpi=67)  # sides of an odd number of pixels
    path = lifted.animate(tmp_path / "lift.mp4", frames=5, fps=10, dpi=67)
    with Image.open(tmp_path / "lift.gif") as gif:
        width, height = gif.size
        gif.seek(4)
        last = np.asarray(gif.convert("L"), dtype=float)
    assert width % 2 or height % 2
    shown = video.imread(path, plugin="FFMPEG")
    assert shown.shape == (5 + 10, height // 2 * 2, width // 2 * 2, 3)
    assert video.immeta(path, plugin="FFMPEG")["fps"] == 10
    assert video.immeta(path, plugin="FFMPEG")["codec"] == "h264"
    # The last frame is that of the GIF but for compression; the first one is not.
    far, near = (np.abs(shown[k].mean(axis=2) - last[: shown.shape[1], : shown.shape[2]]).mean() for k in (0, -1))
    assert near < 0.5 * far
    assert {other.name for other in tmp_path.iterdir()} == {"lift.gif", "lift.mp4"}


def test_a_video_without_its_library_says_what_to_install(
    lifted: kg.Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)  # as if it were not installed
    with pytest.raises(kg.KirigamiError, match=r"needs imageio_ffmpeg: pip install .*kirigami-mechanics\[viz\]"):
        lifted.animate(tmp_path / "lift.mp4", frames=2)
    assert not list(tmp_path.iterdir())


def test_a_path_that_turns_back_is_shown_as_it_went(
    snapped: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    res, *_ = snapped
    heights: list[float] = []
    monkeypatch.setattr(deformed.Picture, "update", lambda self, x, v: heights.append(x[1, 1]))
    res.animate(tmp_path / "snap.gif", frames=30, dpi=20)
    assert heights[0] == 1.0 and heights[-1] == pytest.approx(-1.0)
    assert (np.diff(heights) < 0).all()


def test_an_animation_that_fails_leaves_the_old_file(lifted: kg.Results, tmp_path: Path) -> None:
    path = tmp_path / "lift.gif"
    path.write_text("old")

    def stop(_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lifted.animate(path, frames=2, on_frame=stop)
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


# ---- bad input


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


@pytest.mark.parametrize(
    ("arguments", "options", "complaint"),
    [
        ((), {}, "give nodes"),
        (([0],), {"axis": "w"}, "'w'"),
        (([0],), {"x": "time"}, "'time'"),
        (([0],), {"x": (0, "w")}, "'w'"),
        (([0],), {"x": [1.0, 2.0]}, "numbers of shape"),
        (([],), {}, "empty"),
    ],
)
def test_plot_curve_refuses(lifted: kg.Results, arguments: Any, options: dict[str, Any], complaint: str) -> None:
    with pytest.raises(kg.ModelError, match=complaint):
        lifted.plot_curve(*arguments, **options)


def test_open_area_needs_a_sheet_with_cuts(snapped: Any) -> None:
    with pytest.raises(kg.AnalysisError, match="from_mesh"):
        plot.plot_open_area(snapped[0])
    square = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    m = kg.Model.from_mesh(square, thickness=0.1, material=kg.Material(E=1.0), dim=2)
    m.add(kg.Fix(m.nodes[0]), kg.Fix(m.nodes[1], "y"), kg.NodalLoad(m.nodes[2], (1, 0)))
    with pytest.raises(kg.ModelError, match="no cuts"):
        plot.plot_open_area(kg.LinearStatic(m).run())


@pytest.mark.parametrize(
    ("name", "options", "complaint"),
    [
        ("lift.avi", {}, "writes .gif and .mp4 files, not 'lift.avi'"),
        ("lift.mp4", {"frames": 1}, "at least 2"),
        ("lift.gif", {"frames": 1}, "at least 2"),
        ("lift.gif", {"fps": 0}, "fps must be positive"),
        ("lift.gif", {"color": "hight"}, "unknown"),
    ],
)
def test_animate_refuses(lifted: kg.Results, tmp_path: Path, name: str, options: Any, complaint: str) -> None:
    with pytest.raises(kg.ModelError, match=complaint):
        lifted.animate(tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_one_step_does_not_move(tmp_path: Path) -> None:
    m, *_ = truss()
    res = kg.Results(kg.System(m))
    res.append(kg.Step.at(m, 0.0, np.zeros((3, 3))))
    with pytest.raises(kg.ModelError, match="at least two stored steps"):
        res.animate(tmp_path / "still.gif")


def test_the_band_of_a_force_curve_is_its_estimated_error(lifted: kg.Results) -> None:
    ax = lifted.plot_curve([2, 3], "z", band=True)
    shaded = ax.collections[0].get_paths()[0].vertices
    force, error = lifted.reaction([2, 3], "z"), lifted.error["force"]
    wanted = {*np.round(force * (1 - error), 12), *np.round(force * (1 + error), 12)}
    assert {*np.round(shaded[:, 1], 12)} == wanted
