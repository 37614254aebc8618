"""A planar scene holds, imports and computes nothing of bending, meshing or z."""

from __future__ import annotations

import subprocess
import sys

import numpy as np

import kirigami as kg
from kirigami import tilings

SCENE = """
import sys
import kirigami as kg
from kirigami import tilings
squares = tilings.rotating_squares(angle=0.6).patch(2, 2)
m = squares.model(EA=1e5, stiffness=1.0)
x = [node.x for node in m.nodes]
left = [node for node in m.nodes if node.x < min(x) + 1e-9]
right = [node for node in m.nodes if node.x > max(x) - 1e-9]
m.add(kg.Fix(left, "x"), kg.Fix(left[0], "y"), kg.Prescribe(right, x=0.1))
res = kg.DisplacementControl(m).run()
assert res.reaction(right, "x")[-1] > 0
print("\\n".join(name for name in sys.modules))
"""


def test_imports_nothing_of_bending_meshing_or_pictures() -> None:
    found = subprocess.run([sys.executable, "-c", SCENE], capture_output=True, text=True, check=True).stdout.split()
    assert "kirigami.elements.torsion_spring" in found
    unwanted = ("kirigami.geometry", "kirigami.elements.bend_hinge", "kirigami.elements.facet", "kirigami.stiffness")
    unwanted += ("kirigami.effects.", "kirigami.io", "kirigami.post", "kirigami.plot", "triangle", "matplotlib")
    assert [name for name in found if name.startswith(unwanted)] == []


def test_kernels_and_unknowns_are_planar() -> None:
    piece = tilings.kagome(1.75).patch(3, 3)
    model = piece.model(EA=1.0, stiffness=1e-4)
    model.add(kg.Fix(model.nodes[:3]))
    system = kg.System(model)
    assert {kernel.name for kernel in system.kernels} == {"bars", "springs"}
    assert system.dim == 2 and system.rest.shape == (len(piece.vertices), 2)
    assert system.free == 2 * len(piece.vertices) - 6
    for kernel in system.kernels:
        found = kernel.evaluate(system.configuration(np.zeros_like(system.rest)), 1.0, 2)
        assert found.gradient is not None and found.gradient.shape[2] == 2
        assert found.hessian is not None and found.hessian.shape[2:] == (2, 2)


def test_results_stay_in_the_plane() -> None:
    model = tilings.rotating_squares(0.6).patch(1, 1).model(EA=1e3, stiffness=1.0)
    model.add(kg.Fix(model.nodes[:2]), kg.NodalLoad(model.nodes[-1], (0.01, 0.0)))
    result = kg.LoadControl(model).run()
    assert not result.u[..., 2].any()
    assert set(result.stats["seconds"]) & {"hinges", "facets", "clamps"} == set()
