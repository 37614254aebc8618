"""Slit permeability against closed forms, and its known distance from exact flow through ducts."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.post.permeability import outlined_area, permeability, slit_permeability


def rectangle(length: float, width: float) -> np.ndarray:
    return np.array([(0, 0), (length, 0), (length, width), (0, width)])


def ellipse(a: float, b: float, corners: int) -> np.ndarray:
    angle = 2 * np.pi * np.arange(corners) / corners
    return np.column_stack([a * np.cos(angle), b * np.sin(angle)])


def of_loop(loop: np.ndarray, sheet_area: float = 1.0, **options: object) -> float:
    return float(slit_permeability(loop, [np.arange(len(loop))], sheet_area, **options))


@pytest.mark.parametrize("width", [1.0, 0.5, 0.1, 0.01])
def test_rectangle(width: float) -> None:
    """Area l w over half the perimeter l + w."""
    expected = (width / (1 + width)) ** 3 / 12 / 5
    loop = rectangle(1, width)
    assert of_loop(loop, 5.0, length=[1.0]) == pytest.approx(expected, rel=1e-10)
    assert of_loop(loop, 5.0) == pytest.approx(expected * np.hypot(1, width), rel=1e-10)
    assert of_loop(loop, 5.0, length="half perimeter") == pytest.approx(expected * (1 + width), rel=1e-10)


@pytest.mark.parametrize("b", [1.0, 0.5, 0.1, 0.02])
def test_ellipse(b: float) -> None:
    """Perimeter by the complete elliptic integral; the polygon comes down on it with the square of its sides."""
    from scipy.special import ellipe

    width = 2 * np.pi * b / (4 * ellipe(1 - b**2))
    expected = width**3 * 2 / 12
    coarse, middle, fine = (of_loop(ellipse(1, b, corners)) / expected - 1 for corners in (500, 1000, 2000))
    assert coarse / middle == pytest.approx(4, rel=0.01) and middle / fine == pytest.approx(4, rel=0.01)
    # Richardson's extrapolation, twice: to polygons of infinitely many sides.
    assert (coarse - 20 * middle + 64 * fine) / 45 == pytest.approx(0, abs=1e-10)


def duct_rectangle(width: float) -> float:
    """Flow through a long duct of section 1 x width per pressure gradient and fluidity, by its Fourier series."""
    odd = np.arange(1, 400, 2)
    series = np.tanh(odd * np.pi / (2 * width)) / odd**5
    return float(width**3 / 12 * (1 - 192 * width / np.pi**5 * series.sum()))


RATIOS = [1.0, 0.5, 0.2, 0.1, 0.02]


@pytest.mark.parametrize(("width", "bias"), list(zip(RATIOS, [0.2964, 0.4319, 0.6622, 0.8019, 0.9544])))
def test_known_bias_of_rectangles(width: float, bias: float) -> None:
    assert of_loop(rectangle(1, width), length=[1.0]) / duct_rectangle(width) == pytest.approx(bias, abs=1e-4)


@pytest.mark.parametrize(("b", "bias"), list(zip(RATIOS, [0.4244, 0.5788, 0.7378, 0.7921, 0.8204])))
def test_known_bias_of_ellipses(b: float, bias: float) -> None:
    exact = np.pi * b**3 / (4 * (1 + b**2))
    assert of_loop(ellipse(1, b, 2000)) / exact == pytest.approx(bias, abs=1e-4)


def test_the_docstring_reports_the_bias() -> None:
    rows = [line.split()[-5:] for line in (slit_permeability.__doc__ or "").splitlines() if "l = long" in line]
    measured = [
        [of_loop(rectangle(1, ratio), length=[1.0]) / duct_rectangle(ratio) for ratio in RATIOS],
        [of_loop(ellipse(1, b, 2000)) / (np.pi * b**3 / (4 * (1 + b**2))) for b in RATIOS],
    ]
    assert np.array(rows, dtype=float) == pytest.approx(np.array(measured), abs=6e-4)


@pytest.mark.parametrize("length", ["diameter", "half perimeter"])
def test_grows_with_the_square_of_the_size_and_not_with_position(length: str) -> None:
    rng = np.random.default_rng(3)
    loop = ellipse(1, 0.2, 24) + 0.02 * rng.normal(size=(24, 2))
    once, turned = of_loop(loop, 3.0, length=length), loop @ [[0.6, 0.8], [-0.8, 0.6]] + [5, -7]
    assert of_loop(7 * loop, 49 * 3.0, length=length) == pytest.approx(49 * once, rel=1e-9)
    assert of_loop(turned, 3.0, length=length) == pytest.approx(once, rel=1e-9)
    assert of_loop(np.column_stack([loop, rng.normal(size=24)]), 3.0, length=length) == pytest.approx(once, rel=1e-12)


def test_openings_add_up_and_closed_ones_let_nothing_through() -> None:
    two = np.vstack([rectangle(1, 0.1), rectangle(2, 0.3) + [3, 0]])
    k = slit_permeability(two, [np.arange(4), np.arange(4, 8)], 1.0)
    assert k == pytest.approx(of_loop(two[:4]) + of_loop(two[4:]), rel=1e-12)
    slit = np.array([(0, 0), (0.5, 0), (1, 0), (0.5, 0)])
    overlapping = rectangle(1, 0.1)[::-1]  # lips that have passed each other run clockwise
    for loop in (slit, overlapping, np.zeros((4, 2))):
        assert of_loop(loop) == 0.0
    assert slit_permeability(two, [], 1.0) == 0.0


def pulled(thickness: float) -> kg.Results:
    """Two slits pulled open in the plane: one inside, one from the edge."""
    cuts = [shapely.LineString([(0.3, 1), (0.7, 1)]), shapely.LineString([(0, 0.5), (0.3, 0.5)])]
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1.5), cuts, thickness, kg.Material(E=1.0, nu=0.3))
    m = kg.Model.from_mesh(sheet.mesh(0.2), dim=2)
    top, bottom = m.select(where=lambda x, y, z: y > 1.5 - 1e-9), m.select(where=lambda x, y, z: y < 1e-9)
    m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.Prescribe(top, y=0.1))
    return kg.LinearStatic(m).run()


def test_results_of_a_sheet() -> None:
    res = pulled(0.01)
    k = permeability(res)
    assert k.shape == (len(res),) and k[0] == pytest.approx(0, abs=1e-12) and k[-1] > 1e-8
    # Thickness enters through the deformed shape alone; in the plane that does not depend on it.
    assert permeability(pulled(0.03)) == pytest.approx(k, rel=1e-9)
    # By hand, from the same loops.
    total = 0.0
    for cut in res.mesh.cuts:
        opening = shapely.Polygon(res.position()[-1, cut.loop, :2])
        points = np.asarray(opening.exterior.coords)
        longest = max(np.hypot(*(p - q)) for p in points for q in points)
        total += (2 * opening.area / opening.length) ** 3 * longest / 12
    # The outline with its chords over the mouths of cuts, from the boundary of the mesh.
    x, y, _ = res.position()[-1].T
    around = shapely.union_all([shapely.Polygon(np.column_stack([x, y])[list(t)]) for t in res.mesh.triangles])
    around = shapely.union_all([around, *(shapely.Polygon(np.column_stack([x, y])[c.loop]) for c in res.mesh.cuts)])
    assert k[-1] == pytest.approx(total / around.area, rel=1e-9)
    assert permeability(res, sheet="rest")[-1] == pytest.approx(total / 1.5, rel=1e-9)
    assert permeability(res, sheet=3.0)[-1] == pytest.approx(total / 3, rel=1e-9)
    assert permeability(res, cuts=[0]) + permeability(res, cuts=[1]) == pytest.approx(k, rel=1e-12)


def test_length_at_rest_is_that_of_the_drawn_slit() -> None:
    res = pulled(0.01)
    drawn = {False: 0.4, True: 0.3}
    lengths = [drawn[cut.open] for cut in res.mesh.cuts]
    assert permeability(res, length="rest") == pytest.approx(permeability(res, length=lengths), rel=1e-9)


def test_outlined_area_of_a_sheet_at_rest_includes_its_holes() -> None:
    hole = shapely.box(0.3, 0.3, 0.6, 0.7)
    mesh = kg.Sheet(shapely.box(0, 0, 1, 1), [hole, shapely.LineString([(0.8, 0.5), (1, 0.5)])]).mesh(0.3)
    assert outlined_area(mesh.nodes[None], mesh.triangles, mesh.cuts) == pytest.approx([1.0], rel=1e-12)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"sheet_area": 0.0}, "sheet_area must be positive"),
        ({"sheet_area": float("nan")}, "sheet_area"),
        ({"sheet_area": [1.0, 2.0]}, "sheet_area"),
        ({"sheet_area": 1.0, "length": "width"}, "'diameter', 'half perimeter'"),
        ({"sheet_area": 1.0, "length": [1.0, 2.0]}, r"shape \(1,\)"),
        ({"sheet_area": 1.0, "length": [-1.0]}, "length must not be negative"),
    ],
)
def test_refuses_what_makes_no_sense(options: dict[str, object], words: str) -> None:
    with pytest.raises(kg.ModelError, match=words):
        slit_permeability(rectangle(1, 0.1), [[0, 1, 2, 3]], **options)


def test_refuses_wrong_requests_about_results() -> None:
    res = pulled(0.01)
    wrong = ({"cuts": [2]}, "below 2"), ({"sheet": "gross"}, "'deformed', 'rest'"), ({"length": "no"}, "length")
    for options, words in wrong:
        with pytest.raises(kg.ModelError, match=words):
            permeability(res, **options)
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, EA=1.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    with pytest.raises(kg.AnalysisError, match="from_mesh"):
        permeability(kg.LinearStatic(m).run())
