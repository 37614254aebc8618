"""What asks elements about themselves asks by their contract, not by their class.

An element that somebody else writes is stood for by a copy of one there is: the same text, executed once more, so that
it is a class of its own which derives from the bases of the contract alone.
"""

import ast
import importlib
import inspect
from pathlib import Path

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.elements.surface import SurfaceKernel, surfaces_of
from kirigami.results.moments import _rows_behind

ROOT = Path(kg.__file__).parent
KERNELS = {  # by rung: the kernel, and where it is made
    "shell": [("elements.shell_kernel", "ShellFacetKernel", "elements.shell_facet")],
    "facet": [("elements.facet", "FacetKernel", "elements.facet")],
    "plate": [
        ("elements.bar", "BarKernel", "elements.bar"),
        ("elements.bend_hinge", "BendHingeKernel", "elements.bend_hinge"),
    ],
}


def copied(module, name):
    """A class of its own with the same text as another."""
    home = importlib.import_module(f"kirigami.{module}")
    space = dict(vars(home))
    source = "from __future__ import annotations\n" + inspect.getsource(getattr(home, name))
    exec(compile(source, module, "exec"), space)
    return space[name]


def answers(rung):
    """What results ask of the elements of a sheet with a slit, clamped, strained and curved by itself."""
    slit = shapely.LineString([(0.3, 0.5), (0.7, 0.5)])
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1), slit, 0.01, kg.Material(1e6, 0.3))
    model = kg.Model.from_mesh(sheet.mesh(0.6, 0.4), stiffness=rung)
    bottom, top = model.select(boundary="bottom"), model.select(boundary="top")
    model.add(kg.Fix(bottom, clamp=True), kg.Prescribe(top, x=0.0, y=0.002, z=0.01))
    model.add(kg.Actuate(strain=(1e-3, 2e-3, 0.0), curvature=(0.05, 0.0, 0.0)))
    results = kg.DisplacementControl(model, corrector="newton", step=1.0).run()
    names = [kernel.name for kernel in results.kernels if kernel.surface or kernel.sheet_part]
    found = {"u": results.u, "moment": results.moment(bottom), "kernels": names, "force": results.stress().force}
    found |= dict(results.error)
    if rung != "plate":
        found["release"] = results.energy_release(0)
    wrt = ["thickness"] + ["curvature"] * (rung == "shell")
    return found | {f"by {name}": results.gradient(("force", top, "z"), name) for name in wrt}


@pytest.mark.parametrize("rung", KERNELS)
def test_an_element_of_somebody_else_is_served_like_one_of_ours(rung, monkeypatch):
    ours = answers(rung)
    for module, name, maker in KERNELS[rung]:
        other = copied(module, name)
        assert not issubclass(other, getattr(importlib.import_module(f"kirigami.{module}"), name))
        monkeypatch.setattr(importlib.import_module(f"kirigami.{maker}"), name, other)
    theirs = answers(rung)
    assert ours.keys() == theirs.keys() and ours["kernels"] == theirs["kernels"]
    for name in ours.keys() - {"kernels"}:
        assert np.array_equal(ours[name], theirs[name], equal_nan=True), name


class Bare(kg.Kernel):
    """Facets of which only the energy is known."""

    name, surface, conn = "bare", True, np.array([[0, 1, 2]])


def test_facets_that_do_not_tell_are_refused_by_name():
    with pytest.raises(kg.ModelError, match=r"energy_release: the kernel 'bare' \(Bare\) does not .*SurfaceKernel"):
        surfaces_of([Bare()], "energy_release")
    own = type("Own", (SurfaceKernel,), {"name": "own", "conn": Bare.conn})()
    assert surfaces_of([own], "stress") == [own]
    with pytest.raises(kg.ModelError, match="'own' does not know its facets on another rest state"):
        own.on_rest(np.zeros((3, 3)))
    with pytest.raises(kg.ModelError, match="'bare' takes no strain or angle of its own"):
        Bare().actuate(np.array([0]), np.zeros((1, 6)), True)


def test_rows_behind_nodes_must_be_accounted_for_in_moments():
    """An element with rows of its own that says nothing of them would leave their forces out."""
    beam = type("Beam", (kg.Kernel,), {"name": "beams", "conn": np.array([[0, 1, 2, 3]])})()
    with pytest.raises(kg.ModelError, match="which of the rows of 'beams' .*: define rows_behind of Beam"):
        _rows_behind([beam], np.array([True, False]))
    assert not _rows_behind([beam], np.ones(4, dtype=bool))  # four nodes: no rows behind them
    beam.rows_behind = lambda inside: np.array([2, 3]) if inside[0] else np.zeros(0, dtype=int)
    ((found, rows),) = _rows_behind([beam, beam], np.array([True, False]))  # each row once
    assert found is beam and rows.tolist() == [2, 3] and not _rows_behind([beam], np.array([False, True]))


def asked_for_their_class():
    """Where a class of kernels is asked for outside what defines elements, effects and the files that hold them."""
    for file in sorted(ROOT.rglob("*.py")):
        place = file.relative_to(ROOT)
        text = file.read_text()
        if place.parts[0] in ("elements", "effects") or str(place) == "results/archive.py" or "Kernel" not in text:
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "isinstance":
                names = [one.id for one in ast.walk(node.args[1]) if isinstance(one, ast.Name)]
                yield from (f"{place}:{node.lineno}: {name}" for name in names if name.endswith("Kernel"))


def test_nobody_asks_of_which_class_a_kernel_is():
    assert not list(asked_for_their_class())
