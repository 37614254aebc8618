"""Every effect at rest: other statements of a problem, files; and what a scene without it is made of.

A public object joins ``SERVED_BY`` with an effect or a structure, or says why not.
"""

from __future__ import annotations

import inspect
import json
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from changes import CHANGES, Change, rotation
from effects_on_sheets import EFFECTS, model_with
from structures import SAME, sheet

import kirigami as kg
from kirigami.primitives.material import SheetMaterial

CLOSE = 2e-6  # of the largest value: what the tolerance of the equilibria leaves
EVERYTHING = Change(rotation((1, 2, 3), 40) @ np.diag([-1.0, 1.0, 1.0]), 1e3, 1e-3, shuffle=True, flat=False)
HOW = {**CHANGES, "everything at once": EVERYTHING}
RUNGS = ("plate", "facet", "shell")
REFUSED = {("rubber", "plate"), ("rubber", "facet"), ("edge moment", "plate"), ("edge moment", "facet"),
           ("crease", "plate"), ("crease", "facet")}  # fmt: skip
# what stands for an object in the matrix: an effect of the table, or a structure of structures.py
SERVED_BY = {
    "effect": {
        "Contact": "contact", "Spring": "spring", "Pressure": "pressure", "Grip": "grip", "RigidLink": "link",
        "Actuate": "actuated", "Turn": "turn", "FlowPressure": "flow", "NeoHookean": "rubber", "EdgeLoad": "edge load",
        "AreaLoad": "area load", "Gravity": "gravity", "EdgeMoment": "edge moment", "Crease": "crease", "Tie": "tie",
        "BendHinge": "hinge", "Bar": "cable",
    },
    "structure": {"Facet", "ShellFacet", "Fix", "Prescribe", "NodalLoad", "Material", "TorsionSpring3"},
    "elsewhere": {
        "Orthotropic": "has axes of the drawing; validation/test_materials.py",
        "Laminate": "has axes of the drawing; validation/test_materials.py",
        "Symmetry": "a plane across an axis: mechanics/test_symmetry.py",
        "AngleLimit": "of a plane: inplane/test_angle_limit.py",
        "SelfContact": "remembers, and needs ipctk: matrix/test_history.py by stacked of matrix/structures.py",
        "Mass": "acts in motions alone: mechanics/test_masses.py",
        "Normal": "superseded",
    },
}  # fmt: skip


def test_every_object_joins_the_matrix() -> None:
    bases = {kg.ModelObject}
    public = {
        name for name in kg.__all__
        if inspect.isclass(item := getattr(kg, name)) and issubclass(item, (kg.ModelObject, SheetMaterial))
        and item not in bases
    }  # fmt: skip
    assert public == {*SERVED_BY["effect"], *SERVED_BY["structure"], *SERVED_BY["elsewhere"]}
    assert set(SERVED_BY["effect"].values()) <= set(EFFECTS)  # type: ignore[union-attr]
    for name, where in SERVED_BY["elsewhere"].items():  # type: ignore[union-attr]
        file = Path(__file__).parents[1] / where.split()[-1]
        assert where == "superseded" or f"{name}(" in file.read_text(), where


@cache
def at_rest(effect: str, rung: str, change: str = "") -> kg.Results:
    m = model_with(effect, rung, HOW.get(change, SAME))
    return kg.LoadControl(m, targets=[0.3, 1.0], tol=1e-10, on_instability="follow").run()


def assert_same(found: Any, wanted: Any, close: float = CLOSE) -> None:
    np.testing.assert_allclose(found, wanted, rtol=0, atol=close * max(np.abs(wanted).max(initial=0.0), 1e-300))


CASES = [(effect, rung) for effect in EFFECTS for rung in RUNGS]
SLOW = {(effect, "shell") for effect in ("contact", "spring", "link", "area load")}  # or like others
FAST = {case for case in CASES if case[1] == "shell"} - SLOW


@pytest.mark.parametrize(
    "effect, rung, change",
    [  # on the shell all at once in the default suite; the long one tells which
        pytest.param(*case, change, marks=[pytest.mark.long] if case not in FAST or change in CHANGES else [])
        for case in CASES
        if case not in REFUSED
        for change in HOW
    ],
)
def test_an_effect_does_not_see_how_the_problem_is_stated(effect: str, rung: str, change: str) -> None:
    how, one, other = HOW[change], at_rest(effect, rung), at_rest(effect, rung, change)
    order = how.order(16)
    if effect == "cable":  # whose ground is not renumbered
        order = np.append(order, 16)
    assert_same(other[-1].u, (how.length * one[-1].u @ how.turn.T)[order])
    for name in ("driven_0", "fixed_0"):
        assert_same(other.reaction(name)[-1], how.force * one.reaction(name)[-1] @ how.turn.T, 10 * CLOSE)
    for name, energy in one.energy.items():
        unit, total = how.force * how.length, sum(values[-1] for values in one.energy.values())
        assert other.energy[name][-1] == pytest.approx(unit * energy[-1], abs=1e-5 * unit * total)


@pytest.mark.parametrize("effect", [effect for effect in EFFECTS if (effect, "shell") in FAST])
def test_an_effect_is_read_back(effect: str, tmp_path: Any) -> None:
    run = at_rest(effect, "shell")
    back = kg.load(run.save(tmp_path / "run"))
    for name in ("driven_0", "fixed_0"):
        assert_same(back.reaction(name), run.reaction(name), 1e-12)
    for kind, values in run.energy.items():
        assert_same(back.energy[kind], values, 1e-9)


@pytest.mark.parametrize("effect, rung", sorted(REFUSED))
def test_a_rung_that_has_it_not_says_so(effect: str, rung: str) -> None:
    with pytest.raises(kg.ModelError, match="shell"):
        kg.System(model_with(effect, rung, SAME))


@pytest.mark.parametrize(
    "effect, rung",
    [pytest.param(*case, marks=[] if case in FAST else [pytest.mark.long]) for case in CASES if case not in REFUSED],
)
def test_kernels_of_a_scene_belong_to_their_energies(effect: str, rung: str) -> None:
    """Where the scene has come to, and off the symmetry of it."""
    system = kg.System(model_with(effect, rung, SAME))
    x = system.rest + 1e-3 * np.random.default_rng(5).normal(size=system.rest.shape)
    for kernel in system.kernels:
        kernel.commit_at(system.rest, 0.0)
        errors = kg.check_kernel(kernel, x, lam=0.7)
        potential = kernel.conservative and kernel.name != "pressure at the rim"
        wanted = ["gradient", "hessian", "symmetry"] if potential else ["symmetry"]
        assert max(errors[name] for name in wanted) < 1e-7, (kernel.name, errors)


SCENE = """
import json, sys
sys.path.insert(0, {folder!r})
from test_effects import plain_scene
print(json.dumps([sorted(name for name in sys.modules if name.startswith("kirigami.")), *plain_scene()]))
"""


def plain_scene() -> tuple[list[str], int, list[str]]:
    """Kernels, unknowns and every bit of a run of the sheet without any effect."""
    m = sheet("shell", 3, SAME)
    run = kg.LoadControl(m, targets=[0.5], tol=1e-10).run()
    system = kg.System(m)
    bits = [float(value).hex() for value in (*run.u.ravel(), *run.reaction("driven_0").ravel())]
    return [type(kernel).__name__ for kernel in system.kernels], system.free, bits


def test_a_scene_without_an_effect_does_not_know_of_it() -> None:
    """Nothing of any effect is imported or lowered, and no bit is another beside scenes that have it."""
    for effect in EFFECTS:  # here everything is in use
        kg.System(model_with(effect, "shell", SAME)).stiffness()
    here = plain_scene()
    folder = str(Path(__file__).parent)
    told = subprocess.run(
        [sys.executable, "-c", SCENE.format(folder=folder)], capture_output=True, text=True, check=True, cwd=folder
    )
    imported, *there = json.loads(told.stdout)
    assert tuple(there) == here
    for name in kg.__all__:
        item = getattr(kg, name)
        if getattr(item, "kind", "") in ("effect", "load") and item is not kg.NodalLoad:
            assert item.__module__ not in imported, name
    kernels = {type(kernel) for effect in EFFECTS for kernel in kg.System(model_with(effect, "shell", SAME)).kernels}
    own = {kernel for kernel in kernels if kernel.__name__ not in here[0]}
    assert len(own) > 8
    shared = ("kirigami.elements.bar", "kirigami.elements.bend_hinge", "kirigami.elements.crease")  # what sheets have
    assert not [kernel for kernel in own if kernel.__module__ in imported and kernel.__module__ not in shared]
