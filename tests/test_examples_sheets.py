"""The facades of curved cells and the slit sheets of the gallery, held to independent solutions and to scaling laws."""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from slit_cells import SlitCell, stretched_freely

import kirigami as kg

EXAMPLES = Path(__file__).parent.parent / "examples"


@cache
def script(name: str) -> Any:
    specification = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module  # dataclasses look their module up
    specification.loader.exec_module(module)
    return module


facades, slits = script("cellular_facades"), script("rainbow_and_honeycomb")


# ---- curved cells


@pytest.mark.parametrize("name", facades.FACADES)
def test_curved_cells_are_those_of_the_published_generator(name: str) -> None:
    """Rt = 2 / (Nt (LcRt + 1)), Lc = LcRt Rt, D1 = Rl = 2 / (1 + 2 Nl): counts, lengths, distances and areas."""
    facade = facades.FACADES[name]
    across, along = facade.across, facade.along
    cuts = kg.cuts.curved_cells(across, along, 2.0, 2.0, margin=0.2, opening=0.005)
    length, depth = 4 / (3 * across), 2 / (1 + 2 * along)
    boxes = np.array([cut.bounds for cut in cuts])
    half = (boxes[:, 0] < 1e-12) | (boxes[:, 2] > 2 - 1e-12)
    assert len(cuts) == across * along + (across + 1) * (along + 1) and half.sum() == 2 * (along + 1)
    assert boxes[~half, 2] - boxes[~half, 0] == pytest.approx(length)
    assert boxes[half, 2] - boxes[half, 0] == pytest.approx(length / 2)
    assert boxes[:, 3] - boxes[:, 1] == pytest.approx(depth + 0.005)
    assert np.diff(np.unique(boxes[~half, 0].round(9))) == pytest.approx(1 / across)  # rows are shifted by half a cell
    assert [cut.area for cut in cuts] == pytest.approx(np.where(half, 0.5, 1.0) * 0.005 * length)


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.long) for name in facades.FACADES])
def test_meshes_are_about_as_large_as_the_published_ones(name: str) -> None:
    model, _, _ = facades.facade_model(facades.FACADES[name], facades.FULL_EDGE)
    assert len(model.nodes) == pytest.approx(facades.FACADES[name].nodes, rel=0.25)


@cache
def facade(name: str, max_edge: float, strain: float = 1.0) -> Any:
    return facades.stretch(facades.FACADES[name], max_edge, strain)


def test_two_by_five_cells_against_shells() -> None:
    """A fifth of the nodes of the published mesh: area within 4 %, force too low by up to 16 %; see the long test."""
    off = facades.against_shell(facade("2x5", 0.1))
    assert np.abs(off["open area"]).max() < 0.05
    assert np.abs(off["force"][off["strain"] <= 0.05]).max() < 0.10
    assert np.abs(off["force"]).max() < 0.18


def test_facade_keeps_the_balance_and_opens_steadily() -> None:
    found = facade("2x5", 0.1)
    assert np.nanmax(found.results.residual) <= 1e-8 and found.results.stable.all()
    assert np.abs(found.top + found.bottom).max() <= 1e-8 * np.abs(found.top).max()
    assert found.area[0] == pytest.approx([cut.area for cut in kg.cuts.curved_cells(opening=0.005)])
    assert (np.diff(found.area.sum(axis=1)) > 0).all()


# ---- straight slits


@pytest.mark.parametrize("name", slits.PATTERNS)
def test_slit_sheets_reach_half_again_their_length(name: str) -> None:
    found = slits.pull(slits.PATTERNS[name](), max_edge=5.0)
    assert found.strain[-1] == pytest.approx(0.5) and np.nanmax(found.results.residual) <= 1e-8
    assert found.poisson[-1] > 0 and (np.diff(found.area) > 0).all()


@pytest.mark.parametrize("name", slits.PATTERNS)
def test_slope_at_small_strain_is_that_of_the_plane(name: str) -> None:
    pattern = slits.PATTERNS[name]()
    model, top = slits.clamped_sheet(pattern, 5.0, strain=1e-5, parted=0.0)
    mesh = model.mesh
    res = kg.DisplacementControl(model).run()
    plane = kg.Model.from_mesh(mesh, stiffness=slits.STIFFNESS, dim=2)
    high = pattern.height + 2 * slits.MARGIN - slits.GRIP
    upper = plane.select(where=lambda x, y, z: y >= high - 1e-9)
    plane.add(kg.Fix(plane.select(where=lambda x, y, z: y <= slits.GRIP + 1e-9)), kg.Fix(upper, "x"))
    plane.add(kg.Prescribe(upper, y=1e-5 * pattern.length))
    linear = kg.LinearStatic(plane).run().reaction(upper, "y")[-1]
    assert res.reaction(top, "y")[-1] == pytest.approx(linear, rel=1e-2)


def test_slit_ribbon_stiffness_and_transition_scale_with_thickness() -> None:
    """First stiffness as h, force and slope after buckling as h^3, strain at the transition as h^2.

    Beam estimates for strips in the regime of Isobe and Okumura, Sci. Rep. 6, 24758 (2016); rows 4 mm apart.
    """
    thickness = np.array([0.1, 0.15, 0.2, 0.3])
    found = []
    for h in thickness:
        model, top = slits.clamped_sheet(slits.rainbow(columns=1, rows=7), 5.0, float(h), strain=0.1, parted=0.02)
        first = kg.LinearStatic(model).run().reaction(top, "y")[-1] / 0.1
        res = kg.DisplacementControl(model, step=2e-3).run()
        strain, force = 0.1 * res.lam, res.reaction(top, "y")
        slope, start = np.polyfit(strain[strain > 0.03], force[strain > 0.03], 1)
        found.append((first, force[-1], slope, start, start / (first - slope)))
    exponents = np.polyfit(np.log(thickness), np.log(found), 1)[0]
    assert exponents == pytest.approx([1, 3, 3, 3, 2], rel=0.1)


def test_slit_ribbon_first_stiffness_scales_with_rows_and_slit_length() -> None:
    """As 1 / (rows length^3): 1.09 and 2.78 at a length of 30 rows; the strips end in joints, not in walls."""

    def stiffness(rows: int, slit: float) -> float:
        pattern = slits.rainbow(columns=1, rows=rows, pitch=slit + 4, slit=slit)
        model, top = slits.clamped_sheet(pattern, 2.0, strain=0.01, parted=0.0)
        return float(kg.LinearStatic(model).run().reaction(top, "y")[-1] / pattern.length)

    base = stiffness(8, 120)
    assert np.log(stiffness(16, 120) / base) / np.log(2) == pytest.approx(-1, rel=0.1)
    assert np.log(stiffness(8, 150) / base) / np.log(1.25) == pytest.approx(-3, rel=0.1)


def slit_cell(name: str, max_edge: float) -> SlitCell:
    """One cell of each pattern, from a quarter of it."""
    if name == "rainbow":
        size, ends = (15.0, 4.0), [((2.0, 0.0), (15.0, 0.0)), ((0.0, 4.0), (13.0, 4.0))]
    else:
        (a, b), s = (14.0, 6.0), 0.85
        size = a, b
        ends = [
            ((0.0, 0.0), (s * a, 0.0)),
            ((a - s * a, b), (a, b)),
            ((0.0, b - s * b), (0.0, b)),
            ((a, 0.0), (a, s * b)),
        ]
    cell = SlitCell(*size, ends, max_edge, slits.THICKNESS, slits.MYLAR, slits.STIFFNESS)
    cell.part_lips(slits.PARTED * slits.THICKNESS)
    return cell


def inside(found: Any, pattern: Any, strain: float) -> dict[str, float]:
    """Poisson ratio and force over width where the middle of the sheet, not the whole, has this strain."""
    rest, shapes = found.results.rest, found.results.position()
    middle = np.array([pattern.width, pattern.height + 2 * slits.MARGIN]) / 2
    chosen = (np.abs(rest[:, :2] - middle) < np.array([pattern.width, pattern.height]) / 4).all(axis=1)
    across, along = (
        np.array([np.polyfit(rest[chosen, axis], shape[chosen, axis], 1)[0] - 1 for shape in shapes]) for axis in (0, 1)
    )
    return {
        "poisson": -float(np.interp(strain, along, across)) / strain,
        "line force": float(np.interp(strain, along, found.force)) / pattern.width,
    }


# The free sides of the sheet, three cells wide, bend as no cell inside does; so the forces differ.
@pytest.mark.parametrize(
    ("name", "contraction", "force_within"),
    [("rainbow", 0.2, 0.1), pytest.param("honeycomb", 0.5, 0.2, marks=pytest.mark.long)],
)
def test_inside_of_a_sheet_is_like_a_periodic_cell(name: str, contraction: float, force_within: float) -> None:
    """At strain 0.1 of the middle, whose ends are still held back by the clamps."""
    pattern = slits.PATTERNS[name]()
    sheet = inside(slits.pull(pattern, max_edge=2.5, strain=0.06), pattern, 0.1)
    cell = stretched_freely(slit_cell(name, 2.5), 0.1, contraction)
    assert sheet["poisson"] == pytest.approx(cell["poisson"], rel=0.1)
    assert sheet["line force"] == pytest.approx(cell["line force"], rel=force_within)


# ---- long


@pytest.mark.long
def test_all_facades_reach_the_end_in_the_order_of_stiffness() -> None:
    found = {name: facade(name, facades.EDGE) for name in facades.FACADES}
    for name, one in found.items():
        assert one.strain[-1] == pytest.approx(facades.FACADES[name].strain)
        assert np.nanmax(one.results.residual) <= 1e-8
        assert np.abs(one.top + one.bottom).max() <= 1e-8 * np.abs(one.top).max()
        assert (np.diff(one.area.sum(axis=1)) > 0).all()
    stress = {name: one.at(one.stress, 0.17) for name, one in found.items()}
    assert stress["2x5"] < stress["5x15"] < stress["5x10"] < stress["10x10"]


@pytest.mark.long
def test_published_mesh_of_two_by_five_cells_against_shells() -> None:
    """The bounds of the publication, 7 % of the open area and 10 % of the force; found 2.4 % and 5.4 %."""
    off = facades.against_shell(facade("2x5", facades.FULL_EDGE))
    assert np.abs(off["open area"]).max() < 0.07
    assert np.abs(off["force"]).max() < 0.10


@pytest.mark.long
@pytest.mark.parametrize(("name", "force_within"), [("rainbow", 0.22), ("honeycomb", 0.14)])
def test_slit_sheets_on_meshes_of_half_the_edge(name: str, force_within: float) -> None:
    """Shape within the bounds of the publication, 4, 4 and 5 %; force not: 20 and 12 % too low on the coarse mesh."""
    coarse, fine = (slits.pull(slits.PATTERNS[name](), edge) for edge in (slits.EDGE, slits.FULL_EDGE))
    for strain in slits.STRAINS:
        one, other = coarse.at(strain), fine.at(strain)
        for key, within in (("poisson", 0.04), ("height", 0.04), ("area", 0.05), ("force", force_within)):
            assert one[key] == pytest.approx(other[key], rel=within), key
