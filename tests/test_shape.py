"""Height, width, Poisson ratio, curvature and energy shares against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.post.curvature import curvature
from kirigami.post.energy import energy_shares
from kirigami.post.shape import height, poisson_ratio, width

PLATE = kg.Sheet(shapely.box(-1, -1, 1, 1)).mesh(0.12)
DISC = kg.Sheet(*kg.cuts.single_slit_disc(3.0, 2.0)).mesh(0.4)


def rolled(mesh: kg.TriMesh, radius: float, turn: float = 0.0) -> np.ndarray:
    """Nodes on a cylinder below the drawing, rolled without stretch across an axis turned by `turn` from y."""
    x, y, _ = mesh.nodes.T
    across, along = x * np.cos(turn) + y * np.sin(turn), -x * np.sin(turn) + y * np.cos(turn)
    bent = radius * np.sin(across / radius)
    return np.column_stack([
        bent * np.cos(turn) - along * np.sin(turn),
        bent * np.sin(turn) + along * np.cos(turn),
        radius * (1 - np.cos(across / radius)),
    ])


def equilateral_strip(columns: int = 12, rows: int = 15) -> kg.TriMesh:
    """Rows of equilateral triangles of side 1, trimmed by half triangles to straight sides."""
    pitch = np.sqrt(3) / 2
    points, start = [], []
    for row in range(rows + 1):
        start.append(len(points))
        shifted = np.concatenate([[0], np.arange(columns) + 0.5, [columns]])
        across = shifted if row % 2 else np.arange(columns + 1.0)
        points += [(x, row * pitch) for x in across]
    facets = []
    for row in range(rows):
        even, odd = (start[row], start[row + 1]) if row % 2 == 0 else (start[row + 1], start[row])
        facets += [(even + k, odd + k, odd + k + 1) for k in range(columns + 1)]
        facets += [(even + k, even + k + 1, odd + k + 1) for k in range(columns)]
    return kg.TriMesh(np.array(points), np.array(facets))


# ---- height and width


def test_height_counts_from_the_lowest_point() -> None:
    tilted = PLATE.nodes + np.array([0, 0, 5.0])
    tilted[:, 2] += 0.25 * tilted[:, 0]
    assert height([PLATE.nodes, tilted]) == pytest.approx([0.0, 0.5], abs=1e-14)


@pytest.mark.parametrize("band", [0.0, 0.3, 1.0])
def test_width_of_a_trapezium_is_its_mean_over_the_band(band: float) -> None:
    x, y, z = PLATE.nodes.T
    assert width(np.column_stack([x * (1 + 0.2 * y), 3 * y, z]), PLATE, band=band) == pytest.approx(2.0, rel=1e-12)


def test_width_of_a_disc_is_its_mean_chord() -> None:
    half = 0.25 * 6 / 2  # half the height of the band
    mean_chord = (half * np.sqrt(9 - half**2) + 9 * np.arcsin(half / 3)) / half
    assert width(DISC.nodes, DISC, band=0.25) == pytest.approx(mean_chord, rel=2e-3)


def test_lips_of_a_cut_that_reaches_the_side_are_no_width() -> None:
    mesh = kg.Sheet(shapely.box(0, 0, 2, 2), shapely.LineString([(1.2, 1.0), (2, 1.0)])).mesh(0.2)
    assert width(mesh.nodes, mesh) == pytest.approx(2.0, rel=1e-12)


# ---- Poisson ratio


@pytest.mark.parametrize(("axis", "expected"), [("y", 0.3), ("x", 1 / 0.3)])
def test_poisson_ratio_of_a_uniform_stretch(axis: str, expected: float) -> None:
    stretched = [PLATE.nodes * (1 - 0.3 * e, 1 + e, 1) for e in (1e-6, 0.01, 0.2, -0.1)]
    assert poisson_ratio(stretched, PLATE, axis=axis) == pytest.approx(np.full(4, expected), rel=1e-8)


def test_poisson_ratio_is_that_of_the_bars() -> None:
    # A network of bars over equilateral triangles has the Poisson ratio 1/3 exactly (Seung and Nelson 1988). The half
    # triangles at the sides take part, hence the wide strip; the ends slide freely.
    mesh = equilateral_strip(columns=24, rows=16)
    m = kg.Model.from_mesh(mesh, thickness=1e-3, material=kg.Material(E=1e9, nu=1 / 3), dim=2)
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    m.add(kg.Fix(bottom, "y"), kg.Prescribe(top, y=1e-4), kg.Fix(bottom[len(bottom) // 2], "x"))
    res = kg.LinearStatic(m).run()
    assert res.poisson_ratio()[-1] == pytest.approx(1 / 3, rel=0.02)


def test_poisson_ratio_takes_the_strain_it_is_given_and_knows_no_rest_state() -> None:
    points = np.array([PLATE.nodes, PLATE.nodes * (0.9, 1.2, 1)])
    ratio = poisson_ratio(points, PLATE, strain=[0.0, 0.4])
    assert np.isnan(ratio[0]) and ratio[1] == pytest.approx(0.25, rel=1e-12)


# ---- curvature


@pytest.mark.parametrize("per", ["facet", "node"])
@pytest.mark.parametrize("turn", [0.0, 0.4, 1.2])
def test_cylinder(per: str, turn: float) -> None:
    radius = 2.5
    principal = curvature(rolled(PLATE, radius, turn), PLATE, "principal", per)
    # Angles are exact to second order in edge length over radius, here (0.12 / 2.5)^2.
    assert np.abs(principal * radius - (1, 0)).max() < 6e-3
    assert np.abs(curvature(rolled(PLATE, radius, turn), PLATE, "gaussian", per)).max() * radius**2 < 6e-3
    tensor = curvature(rolled(PLATE, radius, turn), PLATE, "tensor", per)
    direction = np.array([np.cos(turn), np.sin(turn)])
    assert tensor @ direction == pytest.approx(np.tile(direction / radius, (len(tensor), 1)), abs=6e-3 / radius)


def test_cylinder_converges_with_the_mesh() -> None:
    error = []
    for max_edge in (0.24, 0.12):
        mesh = kg.Sheet(shapely.box(-1, -1, 1, 1)).mesh(max_edge)
        error.append(np.abs(curvature(rolled(mesh, 1.0), mesh) - 0.5).mean())
    assert error[1] < error[0] / 2


@pytest.mark.parametrize("form", [(1.0, 1.0, 0.0), (1.0, -1.0, 0.0), (0.3, 0.8, -0.7)], ids=["bowl", "saddle", "any"])
def test_quadratic_heights_are_exact_on_any_mesh(form: tuple[float, float, float]) -> None:
    kxx, kyy, kxy = 1e-4 * np.array(form)
    x, y, _ = DISC.nodes.T
    points = np.column_stack([x, y, 0.5 * (kxx * x * x + kyy * y * y) + kxy * x * y])
    tensor = curvature(points, DISC, "tensor")
    assert tensor == pytest.approx(np.broadcast_to([[kxx, kxy], [kxy, kyy]], tensor.shape), abs=1e-9)
    assert curvature(points, DISC) == pytest.approx(np.full(len(tensor), 0.5 * (kxx + kyy)), abs=1e-9)
    assert curvature(points, DISC, "gaussian") == pytest.approx(np.full(len(tensor), kxx * kyy - kxy**2), abs=1e-11)


def test_curvature_is_the_same_after_a_rigid_motion_and_turns_sign_in_a_mirror() -> None:
    bent = rolled(PLATE, 2.0, 0.3)
    a, b = 0.7, -1.1
    turn = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    turn = turn @ np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]])
    tensor = curvature([bent, bent @ turn.T + 3.0, bent * (1, 1, -1)], PLATE, "tensor")
    assert tensor[1] == pytest.approx(tensor[0], abs=1e-12)
    assert tensor[2] == pytest.approx(-tensor[0], abs=1e-12)


def test_curvature_does_not_look_across_a_cut() -> None:
    # The upper lip of a slit from side to side of a small window is rolled, the lower half stays flat.
    mesh = kg.Sheet(shapely.box(-1, -1, 1, 1), shapely.LineString([(-1, 0), (0.6, 0)])).mesh(0.15)
    facet = mesh.nodes[mesh.triangles].mean(axis=1)
    upper = np.unique(mesh.triangles[(facet[:, 1] > 0) & (facet[:, 0] < 0)])
    points = mesh.nodes.copy()
    points[upper, 2] = 0.5 * np.minimum(points[upper, 0], 0) ** 2 * 1e-3
    mean = curvature(points, mesh)
    inside = facet[:, 0] < -0.25
    assert mean[inside & (facet[:, 1] > 0)] == pytest.approx(5e-4, rel=1e-4)
    assert np.abs(mean[inside & (facet[:, 1] < 0)]).max() < 1e-9


# ---- energy shares


def test_energy_shares_of_a_bent_strip() -> None:
    mesh = kg.Sheet(shapely.box(0, 0, 4, 1)).mesh(0.4)
    m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9))
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, clamp=True), kg.Prescribe(right, z=0.02))
    shares = kg.LinearStatic(m).run().energy_shares()
    assert sum(share[-1] for share in shares.values()) == pytest.approx(1.0, abs=1e-12)
    assert shares["bars"][-1] < 1e-12  # a flat plate that bends does not stretch, to first order


def test_energy_shares_name_what_is_stored_in_each() -> None:
    m = kg.Model(dim=2)
    a, b, c, d = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(1, 1), kg.Node(2, 0))
    m.add(kg.Bar(a, b, EA=1e9), kg.Bar(b, c, EA=1e9), kg.Bar(b, d, EA=10.0), kg.TorsionSpring3(a, b, c, stiffness=2.0))
    m.add(kg.Fix([a, b]), kg.Fix(c, "y"), kg.Prescribe(c, x=0.1), kg.Prescribe(d, x=0.2, y=0))
    res = kg.LinearStatic(m).run()
    bars, springs = 0.5 * 10 * 0.2**2, 0.5 * 2.0 * 0.1**2  # both closed forms of the linear problem
    assert res.energy_shares()["bars"][-1] == pytest.approx(bars / (bars + springs), rel=1e-9)
    assert res.energy_shares()["springs"][-1] == pytest.approx(springs / (bars + springs), rel=1e-9)
    assert res.energy_shares()["bars"][0] == 0


# ---- bad input, pictures


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: height([(0, 0), (1, 1)]),
        lambda: height(np.full((3, 3), np.nan)),
        lambda: width(PLATE.nodes[:-1], PLATE),
        lambda: width(PLATE.nodes, PLATE, axis="z"),
        lambda: width(PLATE.nodes, PLATE, band=1.5),
        lambda: poisson_ratio(PLATE.nodes, PLATE, band=0),
        lambda: poisson_ratio(PLATE.nodes, PLATE, band=float("nan")),
        lambda: poisson_ratio(PLATE.nodes, PLATE, strain=[0.1, 0.2]),
        lambda: curvature(PLATE.nodes, PLATE, kind="sectional"),
        lambda: curvature(PLATE.nodes, PLATE, per="edge"),
        lambda: curvature(PLATE.nodes, kg.TriMesh(rolled(PLATE, 2.0), PLATE.triangles)),
        lambda: energy_shares({}),
        lambda: energy_shares({"bars": [0.0, 1.0], "hinges": [0.0]}),
        lambda: energy_shares({"bars": [1.0, -1.0]}),
        lambda: energy_shares({"bars": [np.inf]}),
    ],
)
def test_bad_input_gives_a_model_error(wrong: object) -> None:
    with pytest.raises(kg.ModelError):
        wrong()  # type: ignore[operator]


def test_shape_of_a_truss_needs_a_mesh() -> None:
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    res = kg.LinearStatic(m).run()
    assert res.height().tolist() == [0.0, 0.0]
    for ask in (res.width, res.poisson_ratio, res.curvature):
        with pytest.raises(kg.AnalysisError, match="from_mesh"):
            ask()


def test_pictures_of_measures_show_what_they_are_given() -> None:
    mesh = kg.Sheet(shapely.box(0, 0, 1, 2)).mesh(0.4)
    m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9), dim=2)
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="bottom")), kg.Fix(top, "x"), kg.Prescribe(top, y=1e-3))
    res = kg.LinearStatic(m).run()
    ax = kg.plot.plot_measure(res, res.poisson_ratio(), "Poisson ratio", label="strip")
    assert len(ax.lines[0].get_xdata()) == len(res) - 1  # not defined at rest, so not drawn there
    assert ax.get_legend().get_texts()[0].get_text() == "strip"
    shares = kg.plot.plot_energy_shares(res)
    assert [text.get_text() for text in shares.get_legend().get_texts()] == ["bars"]
    with pytest.raises(kg.ModelError, match="values must be numbers of shape"):
        kg.plot.plot_measure(res, [1.0, 2.0, 3.0])


@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_tube_has_no_width_and_no_poisson_ratio(axis: str) -> None:
    """Drawn rolled up, nothing says what lies across the pull: refused in words, where numbers such as -33 came out."""
    flat = kg.Sheet(shapely.box(0, 0, 0.08, 0.08), thickness=1e-4, material=kg.Material(E=4e9)).mesh(0.01)
    x, y, _ = flat.nodes.T
    radius = 0.08 / (2 * np.pi)
    rolled = np.column_stack([radius * np.cos(x / radius), y, -radius * np.sin(x / radius)])
    tube = kg.TriMesh(rolled, flat.triangles, thickness=1e-4, material=flat.material)
    m = kg.Model.from_mesh(tube)
    ends = [m.select(where=lambda x, y, z, at=at: np.abs(y - at) < 1e-9) for at in (0, 0.08)]
    m.add(kg.Fix(ends[0]), kg.Fix(ends[1], "xz"), kg.Prescribe(ends[1], y=1e-4))
    results = kg.LinearStatic(m).run()
    for measure in (results.poisson_ratio, results.width):
        with pytest.raises(kg.ModelError, match="flat and level"):
            measure(axis)
