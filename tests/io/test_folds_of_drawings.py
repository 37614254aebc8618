"""Folds of drawings: their sides and angles are read, kept by what is written, and become those of the sheet."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.drawing.convert import read_drawing, write_drawing
from kirigami.drawing.drawing import Drawing

SQUARE = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1], [1, 1]]
RIM = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [6, 7], [7, 0]]
SPOKES = [[8, 1], [8, 3], [8, 5], [8, 7]]


def waterbomb(**more: object) -> str:
    """A square with four folds that meet in its middle: three mountains and a valley."""
    pattern = {"frame_unit": "m", "vertices_coords": SQUARE, "edges_vertices": RIM + SPOKES,
               "edges_assignment": ["B"] * 8 + ["M", "M", "M", "V"]}  # fmt: skip
    return json.dumps(pattern | more)


def test_sides_of_folds_are_those_of_the_file(tmp_path: Path) -> None:
    """Mountains and valleys that go on in one line stay two folds, and rest at the angle that is asked for."""
    path = tmp_path / "pattern.fold"
    path.write_text(waterbomb())
    drawing = read_drawing(path)
    assert sorted(drawing.fold_shares) == [-1, -1, -1, 1]
    sheet = drawing.sheet(fold_angle=0.5, fold_stiffness=0.2)
    assert sorted(fold.angle for fold in sheet.folds) == [-0.5, -0.5, -0.5, 0.5]
    assert {fold.stiffness for fold in sheet.folds} == {0.2}
    valley = max(sheet.folds, key=lambda fold: fold.angle)
    assert shapely.equals(valley.line, shapely.LineString([(0, 1), (1, 1)]))
    assert [fold.angle for fold in drawing.sheet().folds] == pytest.approx([0] * 4)


def test_angles_of_a_file_are_proportions(tmp_path: Path) -> None:
    path = tmp_path / "pattern.fold"
    path.write_text(waterbomb(edges_foldAngle=[None] * 8 + [-90, -45, -90, 180]))
    angles = [fold.angle for fold in kg.Sheet.from_fold(path, fold_angle=1.0).folds]
    assert sorted(angles) == pytest.approx([-0.5, -0.25, 1.0])  # the two of 90 degrees go on in one line


@pytest.mark.parametrize("wrong", [[1, 2], ["a"] * 12, [float("nan")] * 12])
def test_angles_that_are_none(tmp_path: Path, wrong: list[object]) -> None:
    path = tmp_path / "pattern.fold"
    path.write_text(waterbomb(edges_foldAngle=wrong))
    with pytest.raises(kg.GeometryError, match="edges_foldAngle"):
        read_drawing(path)


@pytest.mark.parametrize("ending", ["dxf", "svg", "geojson", "fold"])
@pytest.mark.filterwarnings("ignore::kirigami.KirigamiWarning")
def test_written_folds_keep_their_sides(tmp_path: Path, ending: str) -> None:
    pytest.importorskip({"dxf": "ezdxf", "svg": "svgelements"}.get(ending, "json"))
    lines = [shapely.LineString([(x, 0), (x, 1)]) for x in (0.5, 1.0, 1.5)]
    sheet = kg.Sheet(shapely.box(0, 0, 2, 1), folds=[kg.Fold(line, side) for line, side in zip(lines, (0.3, -0.3, 0))])
    drawing = Drawing(sheet.outline, (), tuple(lines), "m", fold_shares=(1.0, -1.0, 0.0))
    for item in (sheet, drawing):
        back = read_drawing(write_drawing(item, tmp_path / f"plate.{ending}"), unit="m")
        found = {round(line.centroid.x, 9): side for line, side in zip(back.folds, back.fold_shares)}
        assert found == {0.5: 1, 1.0: -1, 1.5: 0}


def test_folds_end_where_cuts_open_them(tmp_path: Path) -> None:
    """A fold across a slit creases both sides and not the lips; a fold along a cut folds nothing, with a word."""
    slit = [(0.5, 0.5), (1.5, 0.5)]
    sheet = kg.Sheet(shapely.box(0, 0, 2, 1), [slit], folds=[[(1, 0), (1, 1)], slit])
    with pytest.warns(kg.KirigamiWarning, match="fold 1 folds nothing"):
        mesh = sheet.mesh(0.3)
    ends = mesh.nodes[mesh.folds[0].edges]
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum() == pytest.approx(1.0)
    inner = mesh.edge_facets[:, 1] >= 0
    assert mesh.edge_folded[inner].sum() == len(mesh.folds[0].edges) and not mesh.edge_folded[~inner].any()


def test_folds_that_cannot_be(tmp_path: Path) -> None:
    mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    with pytest.raises(kg.GeometryError, match="fold 0 runs from node 0 to node 1, where no edge joins two facets"):
        mesh.with_folds([kg.FoldEdges([(0, 1)])])
    with pytest.raises(kg.GeometryError, match="fold 1 runs"):
        mesh.with_folds([kg.FoldEdges([(0, 2)]), kg.FoldEdges([(2, 0)])])
    with pytest.raises(kg.GeometryError, match="radians"):
        kg.Fold([(0, 0), (1, 1)], angle=90)


def test_saved_results_keep_their_folds(tmp_path: Path) -> None:
    sheet = kg.Sheet(shapely.box(0, 0, 1, 2), (), 0.01, kg.Material(E=1e6), kg.Fold([(0, 1), (1, 1)], 0.2, 0.1))
    m = kg.Model.from_mesh(sheet.mesh(0.5))
    m.add(kg.Fix(m.select(boundary="bottom")), kg.Fix(m.select(boundary="top"), "xy"))
    m.add(kg.Prescribe(m.select(boundary="top"), z=0.1))
    kg.LinearStatic(m).run().save(tmp_path / "results.npz")
    (fold,) = kg.load(tmp_path / "results.npz").mesh.folds
    assert (fold.angle, fold.stiffness) == (0.2, 0.1) and fold.edges.tolist() == m.mesh.folds[0].edges.tolist()
