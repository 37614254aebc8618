"""States carried to another mesh of a sheet: what is linear stays, lips stay apart, equilibria are the same ones."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.study.transfer import carried, on_shape

SHEET = kg.Sheet(shapely.box(0, 0, 1, 1), [[(0.25, 0.5), (0.75, 0.5)]], 0.003, kg.Material(1e6))


def test_affine_displacements_and_the_opening_of_a_slit_are_carried_over() -> None:
    """The lower half stands still and the upper one is lifted, but for what hangs together beside the slit."""
    mesh, other = SHEET.mesh(0.1), SHEET.mesh(0.07)
    m = kg.Model.from_mesh(mesh, stiffness="facet")
    res = kg.Results(kg.System(m))
    affine = mesh.nodes @ np.array([[0.1, 0.02, 0.3], [0.0, -0.05, 0.1], [0, 0, 0]])
    res.append(kg.Step.at(m, 1.0, affine))
    wanted = other.nodes @ np.array([[0.1, 0.02, 0.3], [0.0, -0.05, 0.1], [0, 0, 0]])
    np.testing.assert_allclose(carried(res, 0, other), wanted, atol=1e-12)
    centre = mesh.nodal_mean(mesh.nodes[mesh.triangles].mean(axis=1)[:, 1])
    lifted = np.zeros((len(mesh.nodes), 3))
    lifted[centre > 0.5, 1] = 0.1
    res.append(kg.Step.at(m, 1.0, lifted))
    found = carried(res, 1, other)[:, 1]
    middle = np.flatnonzero((np.abs(other.nodes[:, 1] - 0.5) < 1e-9) & (np.abs(other.nodes[:, 0] - 0.5) < 0.15))
    above = other.nodal_mean(other.nodes[other.triangles].mean(axis=1)[:, 1])[middle] > 0.5
    assert above.any() and not above.all()
    np.testing.assert_allclose(found[middle], np.where(above, 0.1, 0.0), atol=0.02)


def pulled(nodes: int) -> tuple[kg.Model, list[kg.Node]]:
    m = kg.Model.from_mesh(SHEET.mesh(nodes=nodes), stiffness="shell")
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.Fix(top, "xz", clamp=True), kg.Prescribe(top, y=0.02))
    m.imperfect()
    return m, top


@pytest.mark.long
def test_the_shape_of_a_coarse_mesh_leads_to_the_path_of_the_fine_one() -> None:
    coarse = kg.DisplacementControl(pulled(150)[0], targets=[0.3]).run()
    model, top = pulled(400)
    own = kg.DisplacementControl(model, targets=[0.3]).run()
    model, top = pulled(400)
    found = on_shape(model, coarse, [int(np.abs(coarse.lam - lam).argmin()) for lam in (0.3, 1.0)])
    for lam, there in zip((0.3, 1.0), found):
        assert there is not None
        here = own.reaction("driven_0", "y")[np.abs(own.lam - lam).argmin()]
        assert there.reaction(top, "y")[-1] == pytest.approx(here, rel=1e-5)
