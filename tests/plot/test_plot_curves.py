"""Curves over the path: forces, open areas, limit points and error bands."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import kirigami as kg
from kirigami import plot

UNIT = 1 / (3 * np.sqrt(3) * np.sqrt(2))  # limit load over EA of the truss of half-width and height 1, in Green strain


def test_two_curves_have_two_colours(snapped: Any) -> None:
    res, left, apex = snapped
    ax = res.plot_curve(x=(apex, "y"), label="first")
    count = len(ax.lines)
    res.plot_curve(x=-res.u[:, 1, 1], ax=ax, label="second")
    assert {line.get_color() for line in ax.lines[:count]} & {line.get_color() for line in ax.lines[count:]} == set()


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


def test_the_band_of_a_force_curve_is_its_estimated_error(lifted: kg.Results) -> None:
    ax = lifted.plot_curve([2, 3], "z", band=True)
    shaded = ax.collections[0].get_paths()[0].vertices
    force, error = lifted.reaction([2, 3], "z"), lifted.error["force"]
    wanted = {*np.round(force * (1 - error), 12), *np.round(force * (1 + error), 12)}
    assert {*np.round(shaded[:, 1], 12)} == wanted
