"""Regions of a sheet by the layers of a drawing, down to the forces on the command line."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kirigami as kg
from kirigami.cli import main
from kirigami.drawing.convert import read_drawing
from kirigami.study.job import Job

STIFF = '<rect x="20" y="0" width="30" height="40"/>'
RING = '<circle cx="30" cy="20" r="10"/><circle cx="30" cy="20" r="4"/>'


def svg(folder: Path, **layers: str) -> Path:
    """A strip of 100 x 40 mm with layers."""
    drawn = {"outline": '<rect x="0" y="0" width="100" height="40"/>', **layers}
    parts = "".join(
        f'<g inkscape:groupmode="layer" inkscape:label="{name}">{shapes}</g>' for name, shapes in drawn.items()
    )
    file = folder / "strip.svg"
    file.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'width="100mm" height="40mm" viewBox="0 0 100 40">{parts}</svg>'
    )
    return file


def dxf(folder: Path, **layers: list[tuple[float, float]]) -> Path:
    """The same in lines from point to point, in mm."""
    rows = ["0", "SECTION", "2", "ENTITIES"]
    for name, points in {"outline": [(0, 0), (100, 0), (100, 40), (0, 40), (0, 0)], **layers}.items():
        for (x, y), (u, v) in pairwise(points):
            rows += ["0", "LINE", "8", name, "10", f"{x}", "20", f"{y}", "11", f"{u}", "21", f"{v}"]
    file = folder / "strip.dxf"
    file.write_text("\n".join([*rows, "0", "ENDSEC", "0", "EOF"]) + "\n")
    return file


def box(x: float, y: float, right: float, top: float) -> list[tuple[float, float]]:
    return [(x, y), (right, y), (right, top), (x, top), (x, y)]


def areas(sheet: kg.Sheet) -> dict[str, float]:
    mesh = sheet.mesh(8e-3)
    return {name: float(mesh.facet_areas[facets].sum()) for name, facets in mesh.regions.items()}


def test_closed_curves_of_a_layer_are_a_region_and_no_cuts(tmp_path: Path) -> None:
    drawn = read_drawing(svg(tmp_path, stiff=STIFF, ring=RING), regions=["stiff", "ring"])
    assert not drawn.cuts and drawn.layers["stiff"].area == pytest.approx(30 * 40e-6)
    assert {row.role for row in drawn.table} == {"outline", "region"}
    found = areas(drawn.sheet())
    assert found["stiff"] == pytest.approx(1200e-6) and found["ring"] == pytest.approx(np.pi * 84e-6, rel=0.01)
    by_lines = kg.Sheet.from_dxf(dxf(tmp_path, Stiff=box(20, 0, 50, 40)), regions="stiff", drawn_in="mm")
    assert areas(by_lines) == {"stiff": pytest.approx(1200e-6)}
    without = read_drawing(svg(tmp_path, stiff=STIFF.replace("<rect", '<rect id="a"')))  # a closed cut, as ever
    assert len(without.regions) == 0 and [row.role for row in without.table] == ["outline", "cut"]


def test_thickness_and_stiffness_by_layer_are_springs_in_a_row(tmp_path: Path) -> None:
    """A strip without lateral contraction, pulled along: 30 mm of it three times as thick and twice as stiff."""
    sheet = kg.Sheet.from_svg(svg(tmp_path, stiff=STIFF), regions="stiff")
    plain, stiff = kg.Material(E=1e9, nu=0.0), kg.Material(E=2e9, nu=0.0)
    res = kg.stretch(
        sheet, 1e-4, "x", "draft", thickness={None: 1e-3, "stiff": 3e-3}, material={None: plain, "stiff": stiff},
        stiffness="shell", max_edge=2e-2, amplitude=0.0,
    )  # fmt: skip
    wanted = 1e-4 * 0.1 / (0.07 / (1e9 * 1e-3 * 0.04) + 0.03 / (2e9 * 3e-3 * 0.04))
    assert res.reaction(res.grips["moved"], "x")[-1] == pytest.approx(wanted, rel=1e-3)


def test_on_the_command_line_and_from_its_case(tmp_path: Path, capsys: Any) -> None:
    file, out = svg(tmp_path, stiff=STIFF), tmp_path / "out"
    made = ["--strain", "0.01%", "--direction", "x", "--max-edge", "30mm", "--stiffness", "shell", "--json"]
    region = ["--region", "stiff", "thickness=3mm", "E=2GPa"]
    sheet = ["--thickness", "1mm", "--E", "1GPa", "--nu", "0", "--imperfection", "0mm", *region]
    assert main(["stretch", str(file), *sheet, *made, "--folder", str(out)]) == 0
    force = json.loads(capsys.readouterr().out)["largest_force"]
    wanted = 1e-4 * 0.1 / (0.07 / (1e9 * 1e-3 * 0.04) + 0.03 / (2e9 * 3e-3 * 0.04))
    assert force == pytest.approx(wanted, rel=1e-3)
    again = Job.load(out / "case.json")
    assert again.regions == {"stiff": {"thickness": "3mm", "E": "2GPa"}}
    assert again.nu == 0.0 and again.imperfection == 0.0  # zeros used to be left out, and other values took their place
    assert again.run().numbers["largest_force"] == pytest.approx(force, rel=1e-9)


def test_what_is_wrong_with_a_region_is_told_by_its_name(tmp_path: Path) -> None:
    plain = kg.Material(E=1e9)
    both = svg(tmp_path, left='<rect x="0" y="0" width="60" height="40"/>', right=STIFF)
    with pytest.raises(kg.ModelError, match="'left' and 'right' overlap at facet"):
        kg.stretch(
            kg.Sheet.from_svg(both, regions=["left", "right"]), 0.01, "x", "draft", max_edge=2e-2, material=plain,
            thickness={None: 1e-3, "left": 1e-3, "right": 2e-3},
        )  # fmt: skip
    for layers, regions, words in [
        ({"far": '<rect x="200" y="0" width="10" height="10"/>'}, "far", "'far' lies outside of the sheet"),
        ({"open": '<path d="M 10 10 L 20 10 L 20 20" fill="none" stroke="red"/>'}, "open", "'open' is not closed"),
        ({"bow": '<path d="M 10 10 L 20 20 L 20 10 L 10 20 Z"/>'}, "bow", "'bow'"),
        ({"stiff": STIFF}, "soft", "'soft'"),
    ]:
        with pytest.raises(kg.GeometryError, match=words):
            kg.Sheet.from_svg(svg(tmp_path, **layers), regions=regions)
    inside_a_hole = svg(tmp_path, cuts='<rect x="10" y="10" width="20" height="20"/>',
                        lost='<rect x="15" y="15" width="5" height="5"/>')  # fmt: skip
    with pytest.raises(kg.GeometryError, match="'lost' is empty"):
        kg.Sheet.from_svg(inside_a_hole, regions="lost").mesh(2e-2)
    sheet = kg.Sheet.from_svg(svg(tmp_path, stiff=STIFF), 1e-3, plain, regions="stiff")
    with pytest.raises(kg.ModelError, match="region 'stif'"):
        kg.stretch(sheet, thickness={"stif": 1e-3})
    for values, words in [({"E": "3mm"}, "E of region 'stiff'"), ({"colour": "red"}, "region 'stiff' takes")]:
        with pytest.raises(kg.ModelError, match=words):
            Job(svg(tmp_path, stiff=STIFF), "1mm", "1GPa", regions={"stiff": values})
    with pytest.raises(kg.ModelError, match="region 'stiff': Material: nu"):
        Job(svg(tmp_path, stiff=STIFF), "1mm", "1GPa", regions={"stiff": {"nu": 0.9}}).run()
