"""kg.stretch, a sheet in and its path out: balances, invariances and closed forms."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, scale

import kirigami as kg
from kirigami.drawing.drawing import Drawing
from kirigami.results.doubts import doubts

MYLAR = kg.Material(E=3.5e9, nu=1 / 3)
FLAT = {"accuracy": "draft", "amplitude": 0.0}


def two_slits(turn: float = 0.0, unit: float = 1.0) -> kg.Sheet:
    """A sheet of 60 x 100 mm with two slanted slits from its sides, turned by degrees, in metres over `unit`."""
    slits = shapely.MultiLineString([[(0, 40), (38, 36)], [(60, 64), (24, 68)]])
    shapes = shapely.box(0, 0, 60, 100), slits
    outline, cuts = (
        scale(rotate(shape, turn, origin=(0, 0)), 1e-3 / unit, 1e-3 / unit, origin=(0, 0)) for shape in shapes
    )
    material = kg.Material(E=3.5e9 * unit**2, nu=1 / 3)
    return kg.Sheet(outline, cuts, thickness=2e-4 / unit, material=material)


def force(res: kg.Results, direction: Any = "y") -> np.ndarray:
    return res.reaction(res.grips["moved"], direction)


@pytest.fixture(scope="module")
def pulled() -> kg.Results:
    return kg.stretch(two_slits(), strain=0.05, accuracy="draft", nodes=300)


def test_the_grips_balance_and_their_work_is_the_energy(pulled: kg.Results) -> None:
    """Forces of the two grips cancel; the work of the moved one is the energy stored and what snaps set free."""
    both = pulled.reaction(pulled.grips["moved"]) + pulled.reaction(pulled.grips["held"])
    assert np.abs(both).max() < 1e-6 * np.abs(force(pulled)).max()
    energy, path = sum(pulled.energy.values()), 0.05 * 0.1 * pulled.lam
    smooth = pulled.lam >= 0.3  # the sheet has buckled by then, and steps are short against what is left
    free = sum(event.energy for event in pulled.events if event.energy is not None and event.lam > 0.3)
    pairs = np.column_stack([force(pulled)[smooth][:-1], force(pulled)[smooth][1:]])
    work = (pairs.mean(axis=1) * np.diff(path[smooth])).sum()  # of the moved grip, by trapezia
    assert work == pytest.approx(energy[-1] - energy[smooth][0] + free, rel=0.01)
    assert pulled.lam[0] == 0 and pulled.lam[-1] == 1 and pulled.stable.all()


def test_grips_are_nodes_and_survive_the_file(pulled: kg.Results, tmp_path: Any) -> None:
    assert all(isinstance(node, kg.Node) for nodes in pulled.grips.values() for node in nodes)
    moved = pulled.position(pulled.grips["moved"])
    assert moved[0, :, 1] == pytest.approx(0.1) and moved[-1, :, 1] == pytest.approx(0.105)
    assert np.array_equal(pulled.position(pulled.grips["held"])[0], pulled.position(pulled.grips["held"])[-1])
    loaded = kg.load(pulled.save(tmp_path / "pulled.npz"))
    assert set(loaded.grips) == {"moved", "held"}
    assert loaded.reaction(loaded.grips["moved"], "y") == pytest.approx(force(pulled), rel=1e-9, abs=1e-12)


def test_a_strip_has_the_force_of_its_material() -> None:
    """No contraction at nu = 0: force E t W (e + e^2 / 2) (1 + e), of Green's strain, whatever the direction."""
    strip = kg.Sheet(shapely.box(0, 0, 0.02, 0.1), thickness=1e-4, material=kg.Material(E=2e9, nu=0.0))
    for direction, width, length in (("y", 0.02, 0.1), ("x", 0.1, 0.02), (180, 0.1, 0.02), (270, 0.02, 0.1)):
        res = kg.stretch(strip, 0.01, direction, stiffness="facet", max_edge=0.01, **FLAT)
        angle = {"x": 0, "y": 90}.get(direction, direction)
        along = (np.cos(np.radians(angle)), np.sin(np.radians(angle)))
        e = 0.01 * res.lam
        assert force(res, along) == pytest.approx(2e9 * 1e-4 * width * (e + e**2 / 2) * (1 + e), rel=1e-6, abs=1e-9)
        assert np.abs(res.u[-1]).max() == pytest.approx(0.01 * length)


def test_a_turned_sheet_pulled_along_its_own_axis_is_the_same_sheet() -> None:
    options = {"nodes": 600, "stiffness": "facet", **FLAT}
    straight, turned = kg.stretch(two_slits(), 1e-5, 90, **options), kg.stretch(two_slits(30), 1e-5, 120, **options)
    along = (np.cos(np.radians(120)), np.sin(np.radians(120)))
    assert force(turned, along)[-1] == pytest.approx(force(straight)[-1], rel=0.03)  # two meshes of one sheet
    moved = turned.node_index(turned.grips["moved"])
    assert turned.u[-1, moved] == pytest.approx(np.tile([*(1e-6 * np.array(along)), 0], (len(moved), 1)), abs=1e-15)


def test_metres_and_millimetres_agree(pulled: kg.Results) -> None:
    in_mm = kg.stretch(two_slits(unit=1e-3), strain=0.05, accuracy="draft", nodes=300)
    assert len(in_mm.rest) == len(pulled.rest)
    assert np.interp(1.0, in_mm.lam, force(in_mm)) == pytest.approx(force(pulled)[-1], rel=1e-4)
    assert in_mm.u[-1] * 1e-3 == pytest.approx(pulled.u[-1], abs=1e-6)


def test_a_small_cycle_comes_back_to_rest() -> None:
    res = kg.stretch(two_slits(), strain=1e-4, cycle=True, nodes=300, **FLAT)
    peak = int(res.lam.argmax())
    assert res.lam[peak] == 1 and res.lam[-1] == 0 and (np.diff(res.lam[: peak + 1]) > 0).all()
    assert (np.diff(res.lam[peak:]) < 0).all()
    assert abs(force(res)[-1]) < 1e-6 * force(res)[peak]
    there = dict(zip(res.lam[: peak + 1].round(9), force(res)[: peak + 1]))
    for lam, value in zip(res.lam[peak:].round(9), force(res)[peak:]):
        if lam in there:  # elastic: the same force at the same strain on both ways
            assert value == pytest.approx(there[lam], rel=1e-4, abs=1e-6 * force(res)[peak])


def test_a_push_buckles_at_eulers_load() -> None:
    """A long strip between clamps carries 4 pi^2 E I / L^2 and hardly more, at nu = 0 and small deflections."""
    width, length, thickness, modulus = 0.02, 0.2, 1e-3, 2e9
    strip = kg.Sheet(
        shapely.box(0, 0, width, length), thickness=thickness, material=kg.Material(E=modulus, nu=0.0)
    )
    critical = 4 * np.pi**2 * modulus * width * thickness**3 / 12 / length**2
    squash = critical / (modulus * width * thickness)  # strain at which the flat strip would carry it
    res = kg.stretch(strip, -4 * squash, max_edge=0.01, stiffness="shell", accuracy="draft", amplitude=thickness / 100)
    assert -force(res)[-1] == pytest.approx(critical, rel=0.03)
    assert np.ptp(res.position()[-1, :, 2]) > thickness


def test_grips_of_a_disc_are_strips_and_its_strain_is_of_what_lies_between() -> None:
    disc = kg.Sheet(shapely.Point(0, 0).buffer(0.05), thickness=1e-4, material=MYLAR)
    res = kg.stretch(disc, 0.001, 30, nodes=300, **FLAT)
    along = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6), 0])
    assert (res.u[-1] @ along).max() == pytest.approx(0.001 * 0.1 * 0.92, rel=1e-3)
    moved = res.position(res.grips["moved"])[0] @ along
    assert moved.min() == pytest.approx(0.05 - 0.04 * 0.1, rel=1e-3)


def test_a_sheet_that_is_lost_says_how_far_it_came(monkeypatch: pytest.MonkeyPatch) -> None:
    from kirigami.analysis.path.follow import PathAnalysis

    run = PathAnalysis.run

    def lost(analysis: PathAnalysis, progress: bool = False) -> kg.Results:
        analysis.targets, analysis.to = [], 0.5  # type: ignore[attr-defined]
        raise kg.ConvergenceError("no equilibrium found", results=run(analysis), worst_nodes=[3])

    monkeypatch.setattr(PathAnalysis, "run", lost)
    with pytest.raises(kg.ConvergenceError, match=r"followed to a strain of 0\.1 % on the way to 0\.2 %") as caught:
        kg.stretch(two_slits(), 0.002, nodes=200, **FLAT)
    res = caught.value.results
    assert res.lam[-1] == 0.5 and force(res)[-1] > 0 and caught.value.worst_nodes == [3]


def test_a_locked_sheet_is_told() -> None:
    """Without slits the material takes the whole strain, so that the warning names the strain itself."""
    strip = kg.Sheet(shapely.box(0, 0, 0.02, 0.1), thickness=1e-3, material=kg.Material(E=1e6, nu=0.0))
    with pytest.warns(kg.KirigamiWarning, match=r"at a strain of 6 % the material itself is strained by 5 %"):
        kg.stretch(strip, 0.2, stiffness="facet", max_edge=0.02, **FLAT)


@pytest.mark.parametrize(
    "change, message",
    [
        ({"strain": 0}, "a number other than zero"),
        ({"strain": float("nan")}, "strain must be finite"),
        ({"strain": "much"}, "strain must be a number"),
        ({"strain": -1.5}, "a strain of -150 % would push one grip through the other"),
        ({"direction": "up"}, "direction must be 'x', 'y' or an angle in degrees"),
        ({"direction": float("inf")}, "direction .an angle in degrees. must be finite"),
        ({"accuracy": "best"}, "accuracy must be one of 'draft', 'standard', 'fine'"),
        ({"accuracy": ["fine"]}, "accuracy must be"),
        ({"thickness": -1}, "thickness must be positive"),
        ({"grip": 0.06}, "do not leave a free length"),
        ({"nodes": 0}, "nodes must be a whole number"),
        ({"nodes": "many"}, "nodes must be a whole number"),
        ({"amplitude": float("nan")}, "amplitude must be finite"),
        ({"stiffness": "wood"}, "stiffness"),
    ],
)
def test_wrong_requests(change: dict[str, Any], message: str) -> None:
    with pytest.raises(kg.ModelError, match=message):
        kg.stretch(two_slits(), **{"strain": 0.001, "nodes": 200, "accuracy": "draft", **change})


def test_what_is_missing_is_named() -> None:
    bare = kg.Sheet(shapely.box(0, 0, 0.1, 0.1))
    with pytest.raises(kg.ModelError, match="the sheet has no thickness"):
        kg.stretch(bare)
    with pytest.raises(kg.ModelError, match="the sheet has no material"):
        kg.stretch(bare, thickness=1e-4)
    with pytest.raises(kg.ModelError, match=r"stretch takes a Sheet, got str; Sheet.from_dxf"):
        kg.stretch("plate.dxf")  # type: ignore[arg-type]
    res = kg.stretch(bare, 1e-4, thickness=1e-4, material=MYLAR, nodes=100, **FLAT)
    assert force(res)[-1] > 0 and bare.thickness is None


def test_which_shape_the_pull_led_to_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the summary, the report, the page and the file; the end of the pull is one of the shapes that are known."""
    from kirigami.study import shapes as search

    monkeypatch.setitem(search.__kwdefaults__, "trials", 2)
    monkeypatch.setitem(search.__kwdefaults__, "confirm", False)
    monkeypatch.setitem(search.__kwdefaults__, "most", 1)
    monkeypatch.setitem(search.__kwdefaults__, "followed", 0)
    drawing = Drawing(shapely.box(0, 0, 0.06, 0.1), tuple(two_slits().cuts), ())
    report = kg.study.stretch_drawing(
        drawing, thickness=2e-4, E=3.5e9, strain=0.05, accuracy="draft", nodes=60, shapes=True
    )
    res = report.results
    assert any(shape.reached_by == "given" for shape in res.shapes) and res.shapes.which(res[-1]) is not None
    assert res.shape_words and all(words in res.summary() and words in report.text() for words in res.shape_words)
    shape = report.numbers["shape"]
    assert report.numbers["shape_energies"][shape - 1] == pytest.approx(report.results.shapes[shape - 1].energy)
    assert report.numbers["shape_forces"][shape - 1] == pytest.approx(report.force[-1], rel=1e-6)
    names = [file.name for file in kg.study.write_report(report, tmp_path, say=lambda words: None)]
    assert "shapes.csv" in names and "shapes.png" in names
    loaded = kg.load(tmp_path / "results.npz")
    assert loaded.shape_words == res.shape_words and loaded.shapes is None
    if "page.html" in names:
        assert res.shape_words[0] in (tmp_path / "page.html").read_text(encoding="utf-8")
    assert not kg.stretch(two_slits(), strain=1e-3, nodes=60, **FLAT).shape_words


def test_a_ligament_thinner_than_the_sheet_is_told_with_its_figure() -> None:
    sheet = kg.Sheet(shapely.box(0, 0, 60, 100), [[(0, 50), (57, 50)]], 6.0, MYLAR)
    with pytest.warns(kg.KirigamiWarning, match=r"narrowest ligament is 3 wide, 0\.5 times the thickness 6"):
        res = kg.stretch(sheet, strain=1e-3, nodes=100, stiffness="facet", amplitude=0)
    assert res.lam[-1] == 1.0 and "0.5 times the thickness" in res.summary()


def test_a_sheet_that_no_budget_resolves_is_told_with_what_it_takes() -> None:
    """Slits of a millimetre, one to each two: 30 nodes cannot hold them, and the message says what would."""
    slits = [[(x, y), (x + 1, y)] for x in range(1, 12, 2) for y in range(1, 12)]
    sheet = kg.Sheet(shapely.box(0, 0, 13, 12), slits, 0.01, MYLAR)
    with pytest.warns(kg.KirigamiWarning) as told:
        res = kg.stretch(sheet, strain=1e-4, nodes=30, stiffness="facet", amplitude=0)
    words = [str(warning.message) for warning in told]
    assert any(f"{len(res.mesh.nodes)} nodes, more than the 30 allowed" in text for text in words)
    assert any("too coarse to bend. About" in text for text in words) and res.lam[-1] == 1.0


def test_a_draft_does_not_warn_of_what_its_error_bar_says(recwarn: Any) -> None:
    res = kg.stretch(two_slits(), strain=1e-3, accuracy="draft", nodes=200, amplitude=0)
    assert not [warning for warning in recwarn if "free edges" in str(warning.message)]
    assert "free edges" in res.summary() and res.error.rung["force"][-1] > 0.01


@pytest.mark.parametrize(
    "material, strain", [(kg.Orthotropic(5e9, 2e9, 0.3, 1e9), 0.01), (kg.NeoHookean(1e6), 0.2)], ids=["grain", "rubber"]
)
def test_a_draft_of_what_bars_cannot_stand_for(material: Any, strain: float) -> None:
    """By shell facets, and it says so; rubber has a law of its own at large strain, so that no lock is told."""
    sheet, told = kg.Sheet(shapely.box(0, 0, 0.05, 0.1), (), 1e-4, material), []
    with warnings.catch_warnings():
        warnings.simplefilter("error", kg.KirigamiWarning)
        res = kg.stretch(sheet, strain, max_edge=0.05, say=told.append, **FLAT)
    assert any("shell facets" in line for line in told) and "shell" in res.energy
    assert not any("linear" in line for line in doubts(res))
