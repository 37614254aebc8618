"""What is written for the cutter: the same roles, sizes, colours, arcs and place; half a kerf beside."""

from __future__ import annotations

import math
import re
import warnings
from pathlib import Path
from typing import Any

import made_by_programs
import made_drawings
import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.drawing.convert import read_drawing, write_drawing
from kirigami.drawing.drawing import Drawing
from kirigami.drawing.strokes import strokes

pytest.importorskip("ezdxf")
pytest.importorskip("svgelements")
MADE = [*made_drawings.every(), *made_by_programs.every()]


def quietly(path: Path, **options: Any) -> Drawing:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return read_drawing(path, unit="mm", **options)


def true_area(drawing: Drawing) -> float:
    """Area of the sheet with its arcs as arcs: that of the strokes, by Green's theorem."""
    total = 0.0
    for stroke in strokes(drawing):
        if not stroke.closed:
            continue
        p, q = stroke.points, np.roll(stroke.points, -1, axis=0)
        angle = 4 * np.arctan(stroke.bulges)
        radius2 = ((q - p) ** 2).sum(axis=1) / np.where(angle, 4 * np.sin(angle / 2) ** 2, np.inf)
        area = 0.5 * float((p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]).sum() + (radius2 * (angle - np.sin(angle))).sum())
        total += abs(area) * (1 if stroke.layer == "OUTLINE" and total == 0 else -1)
    return total


@pytest.mark.parametrize("ending", ["dxf", "svg"])
@pytest.mark.parametrize("made", MADE[::3], ids=lambda made: made.name)
def test_what_is_written_reads_the_same(made: Any, ending: str, tmp_path: Path) -> None:
    path = tmp_path / made.name
    path.write_bytes(made.text.encode())
    drawing = quietly(path, **made.options)
    back = quietly(write_drawing(drawing, tmp_path / f"back.{ending}", unit="mm"))
    openings = [sum(cut.geom_type == "Polygon" for cut in each.cuts) for each in (drawing, back)]
    slits = [sum(cut.length for cut in each.cuts if cut.geom_type == "LineString") for each in (drawing, back)]
    assert openings[0] == openings[1] and len(back.folds) == len(drawing.folds)
    assert slits[0] == pytest.approx(slits[1], rel=1e-3 if len(drawing.circles) else 1e-9)
    assert sorted(back.fold_shares) == sorted(drawing.fold_shares)
    slack = 2e-4 * max(drawing.outline.bounds) if len(drawing.circles) else 1e-9  # arcs are read as chords
    assert back.outline.bounds == pytest.approx(drawing.outline.bounds, rel=1e-9, abs=slack)
    assert true_area(back) == pytest.approx(true_area(drawing), rel=1e-9)
    if not len(drawing.circles):
        assert back.sheet().area == pytest.approx(drawing.sheet().area, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("ending", ["dxf", "svg"])
@pytest.mark.parametrize("made", MADE, ids=lambda made: made.name)
def test_all_that_is_written_reads_the_same(made: Any, ending: str, tmp_path: Path) -> None:
    test_what_is_written_reads_the_same(made, ending, tmp_path)


def plate(folder: Path) -> Drawing:
    """100 by 60 with a round corner, a round and a square hole, slits straight and round, and colours."""
    rim = '<path d="M20,10 H110 A10,10 0 0 1 120,20 V70 H20 Z" fill="none" stroke="#123456"/>'
    holes = ('<circle cx="50" cy="40" r="8" fill="none" stroke="#ff8000"/>'
             '<path d="M80,30h10v10h-10z" fill="none" stroke="#ff8000"/>')  # fmt: skip
    slits = ('<path d="M30,60 A20,20 0 0 1 60,60" fill="none" stroke="#ff8000"/>'
             '<path d="M70,20 H80" fill="none" stroke="#ff8000"/>')  # fmt: skip
    path = folder / "plate.svg"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" width="210mm" height="297mm" viewBox="0 0 210 297">'
                    f"{rim}{holes}{slits}</svg>")  # fmt: skip
    return quietly(path)


PLATE = 100 * 60 - (1 - math.pi / 4) * 100 - math.pi * 64 - 100


@pytest.mark.parametrize("ending", ["dxf", "svg"])
def test_colours_arcs_and_place_are_kept(ending: str, tmp_path: Path) -> None:
    drawing = plate(tmp_path)
    assert true_area(drawing) == pytest.approx(PLATE, rel=1e-9)  # not that of the chords
    target = write_drawing(drawing, tmp_path / f"out.{ending}", unit="mm")
    back = quietly(target)
    assert true_area(back) == pytest.approx(PLATE, rel=1e-9)
    assert {row.color for row in back.table} == {"#123456", "#ff8000"}
    assert back.outline.bounds == pytest.approx((20, 227, 120, 287), abs=1e-9)
    radii = sorted(round(float(radius), 6) for *_, radius in back.circles)
    assert radii == [8, 10, 20]
    if ending == "svg":
        head = target.read_text()
        assert 'width="210.0mm" height="297.0mm"' in head and head.count(" L ") == 3 + 3 + 1
        assert back.page == pytest.approx((0, 0, 210, 297))
    else:
        import ezdxf

        kinds = [entity.dxftype() for entity in ezdxf.readfile(target).modelspace()]
        assert kinds.count("CIRCLE") == 1


def test_polygons_stay_polygons(tmp_path: Path) -> None:
    """A polygon whose corners lie on a circle is no circle, unless it was read as one."""
    ring = [(math.cos(k * math.pi / 50), math.sin(k * math.pi / 50)) for k in range(100)]
    assert not any(stroke.bulges.any() for stroke in strokes(kg.Sheet(ring)))


@pytest.mark.parametrize("ending", ["dxf", "svg"])
def test_kerf(ending: str, tmp_path: Path) -> None:
    """What the cutter leaves is what was drawn: half a kerf inside its line is the rim, outside the openings."""
    kerf = 0.2
    drawing = plate(tmp_path)
    back = quietly(write_drawing(drawing, tmp_path / f"out.{ending}", unit="mm", kerf=kerf))
    assert back.outline.bounds == pytest.approx((19.9, 226.9, 120.1, 287.1), abs=1e-9)
    radii = sorted(round(float(radius), 6) for *_, radius in back.circles)
    assert radii == [7.9, 10.1, 20]  # the hole shrinks, the corner grows, the slit is cut where it was drawn
    rim = (100.2 * 60.2) - (1 - math.pi / 4) * 10.1**2
    assert true_area(back) == pytest.approx(rim - math.pi * 7.9**2 - 9.8**2, rel=1e-9)
    slits = [[cut.length for cut in each.cuts if cut.geom_type == "LineString"] for each in (drawing, back)]
    assert slits[0] == pytest.approx(slits[1], rel=1e-3)


def test_kerf_of_notches_and_narrow_openings(tmp_path: Path) -> None:
    """A notch narrows by the kerf and keeps its mouth; what is no wider than the kerf is refused with its place."""
    notch, hole = shapely.box(4, -1, 6, 3), shapely.box(1, 1, 2, 1.1)
    (rim,) = strokes(Drawing(shapely.box(0, 0, 10, 8), (notch,)), kerf=0.2)
    assert shapely.Polygon(rim.points).equals(shapely.box(-0.1, -0.1, 10.1, 8.1) - shapely.box(4.1, -1, 5.9, 2.9))
    with pytest.raises(kg.GeometryError, match=r"opening at \(1.5, 1.05\) is no wider than the kerf of 0.1"):
        strokes(Drawing(shapely.box(0, 0, 10, 8), (hole,)), kerf=0.1)
    file = tmp_path / "narrow.dxf"
    with pytest.raises(kg.GeometryError, match="kerf"):
        write_drawing(Drawing(shapely.box(0, 0, 10, 8), (hole,)), file, kerf=0.1)
    assert not file.exists()
    for wrong in (-0.1, math.nan, "0.1"):
        with pytest.raises(kg.GeometryError, match="kerf"):
            strokes(Drawing(shapely.box(0, 0, 10, 8), ()), kerf=wrong)  # type: ignore[arg-type]


def test_indexed_colours_of_dxf(tmp_path: Path) -> None:
    rim = made_drawings.polyline(made_drawings.CORNERS, True, "rim").replace("66\n1", "62\n30\n66\n1")
    slit = made_drawings.line((20, 20), (50, 20), "cut", "\n62\n5")
    (tmp_path / "in.dxf").write_text(made_drawings.dxf([rim, slit]))
    back = quietly(write_drawing(quietly(tmp_path / "in.dxf"), tmp_path / "out.dxf", unit="mm"))
    assert [(row.color, row.role) for row in back.table] == [("color 30", "outline"), ("blue", "cut")]
    assert not re.search("color 30", (tmp_path / "out.dxf").read_text())
