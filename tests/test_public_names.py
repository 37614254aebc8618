"""The names that scripts are written against: they exist, take what they promise to take, and explain themselves."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kirigami as kg

# An ellipsis stands for a default that may be anything.
SIGNATURES = {
    "Material": "(E, nu=1 / 3, density=None)",
    "Node": "(x, y, z=0.0, *, name=None)",
    "Bar": "(i, j, EA, *, rest_length=None, strain='green', law='linear')",
    "BendHinge": "(i, j, k, l, stiffness, *, rest_angle=None)",
    "TorsionSpring3": "(i, j, k, stiffness, *, rest_angle=None)",
    "Fix": "(nodes, dofs='xyz', clamp=False)",
    "Prescribe": "(nodes, x=None, y=None, z=None, clamp=False)",
    "Tie": "(followers, leaders, dofs='xyz')",
    "NodalLoad": "(nodes, force, constant=False)",
    "Calibration": "(F_s, c)",
    "Model": "(dim=3, name='')",
    "Model.add": "(self, *objects)",
    "Model.select": "(self, box=None, where=None, boundary=None, index=None)",
    "Model.perturb": "(self, shape, amplitude=None)",
    "Model.plot": "(self, **options)",
    "Model.from_mesh": "(mesh, thickness=None, material=None, stiffness='plate', dim=3)",
    "Sheet": "(outline, cuts=(), thickness=..., material=...)",
    "Sheet.mesh": "(self, max_edge, cut_edge=None, min_angle=28)",
    "TriMesh": "(nodes, triangles, sets=None)",
    "LinearStatic": "(model)",
    "LinearStatic.run": "(self)",
    "Eigen": "(model, n=6, about=None, mass='unit')",
    "Eigen.run": "(self)",
    "LoadControl": "(model, to=1.0, targets=None, step=None, tol=1e-8)",
    "LoadControl.run": "(self, progress=False, recorders=(), on_failure='raise')",
    "DisplacementControl": "(model, to=1.0, control=None, targets=None, step=None, tol=1e-8, start=None)",
    "DisplacementControl.run": "(self, progress=False, recorders=(), on_failure='raise')",
    "ArcLength": "(model, step, stop=None, max_steps=500, tol=1e-8, start=None)",
    "ArcLength.run": "(self, progress=False, recorders=(), on_failure='raise')",
    "Results.position": "(self, nodes=...)",
    "Results.reaction": "(self, nodes, axis=...)",
    "Results.summary": "(self)",
    "Results.open_area": "(self, union=False)",
    "Results.plot": "(self, *args, **options)",
    "Results.animate": "(self, path)",
    "Results.save": "(self, path)",
    "Results.to_vtk": "(self, folder)",
    "Results.to_xarray": "(self)",
    "load": "(path)",
    "check_kernel": "(kernel, x)",
    "Kernel.evaluate": "(self, x, lam=..., need=...)",
    "Kernel.commit": "(self, x)",
    "Kernel.revert": "(self)",
    "Kernel.update": "(self, x)",
    "cuts.curved_cells": None,
    "cuts.parallel_slits": None,
}  # fmt: skip
UNSTATED = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)


def resolve(name: str) -> Any:
    found: Any = kg
    for part in name.split("."):
        found = getattr(found, part)
    return found


def stated(signature: str) -> list[inspect.Parameter]:
    space: dict[str, Any] = {}
    exec(f"def example{signature}: ...", space)
    return list(inspect.signature(space["example"]).parameters.values())


@pytest.mark.parametrize("name", SIGNATURES)
def test_signature(name: str) -> None:
    """The stated parameters come first, in order, by kind and default; others may follow if they can be left out."""
    actual = list(inspect.signature(resolve(name)).parameters.values())
    if SIGNATURES[name] is None:
        return
    wanted = stated(SIGNATURES[name])
    positional = [p for p in wanted if p.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD]
    assert [p.name for p in actual[: len(positional)]] == [p.name for p in positional]
    by_name = {p.name: p for p in actual}
    for parameter in wanted:
        if parameter.kind in UNSTATED:
            assert any(p.kind is parameter.kind for p in actual), parameter
            continue
        found = by_name[parameter.name]
        assert found.kind is parameter.kind
        if parameter.default is not ...:
            assert found.default == parameter.default, parameter
    names = {p.name for p in wanted}
    for extra in actual:
        assert extra.name in names or extra.kind in UNSTATED or extra.default is not extra.empty, extra
