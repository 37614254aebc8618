"""Fields of the sheet are of its points, and hold together: energy drawn or exported adds up to the energy stored."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

import kirigami as kg
from kirigami.plot.field import Field
from kirigami.results.fields import energy_density, nodal_energy

RUNGS = ("paper", "plate", "facet", "shell")
THICK = 0.05


def lifted(rung: str, linear: bool) -> tuple[kg.Model, kg.Results]:
    """A square plate, clamped along one side and lifted by 0.02 along the other."""
    mesh = kg.Sheet(shapely.box(0, 0, 1, 1)).mesh(0.2)
    m = kg.Model.from_mesh(mesh, THICK, kg.Material(E=1e6, nu=0.3), stiffness=rung)
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.Prescribe(m.select(boundary="right"), z=0.02))
    return m, (kg.LinearStatic(m) if linear else kg.DisplacementControl(m)).run()


@pytest.mark.parametrize("linear", [True, False], ids=["linear", "path"])
@pytest.mark.parametrize("rung", RUNGS)
def test_energy_fields_add_up_to_the_stored_energy(rung: str, linear: bool, tmp_path: Path) -> None:
    m, res = lifted(rung, linear)
    mesh = m.mesh
    assert mesh is not None
    stored = sum(res.energy.values())
    assert stored[-1] > 0
    np.testing.assert_allclose(nodal_energy(res).sum(axis=1), stored, rtol=1e-12, atol=1e-15 * stored[-1])
    area = np.zeros(len(res.rest))
    np.add.at(area, mesh.triangles, mesh.facet_areas[:, None] / 3)
    density = energy_density(res)
    assert np.isfinite(density).all()
    np.testing.assert_allclose(density @ area, stored, rtol=1e-12, atol=1e-15 * stored[-1])
    drawn = Field(res, "energy").at(len(res) - 1)
    assert drawn @ mesh.facet_areas == pytest.approx(stored[-1], rel=1e-12)
    meshio = pytest.importorskip("meshio")
    written = meshio.read(res.to_vtk(tmp_path)[-2])
    exported = np.ravel(written.point_data["energy_density"])
    assert exported @ area[: len(exported)] == pytest.approx(stored[-1], rel=1e-12)


@pytest.mark.parametrize("rung", RUNGS)
def test_linear_energy_is_half_the_work(rung: str) -> None:
    m, res = lifted(rung, linear=True)
    work = 0.5 * 0.02 * res.reaction(m.select(boundary="right"), "z")[-1]
    assert sum(res.energy.values())[-1] == pytest.approx(work, rel=1e-9)


@pytest.mark.parametrize("linear", [True, False], ids=["linear", "path"])
@pytest.mark.parametrize("rung", RUNGS)
def test_height_is_that_of_the_sheet(rung: str, linear: bool, tmp_path: Path) -> None:
    """Lifted by 0.02 the sheet is 0.02 high on every rung, whoever says so: no half thickness comes on top."""
    _, res = lifted(rung, linear)
    heights: dict[str, Any] = {"height()": res.height()[-1]}
    lines = res.to_csv(tmp_path / "curves.csv").read_text().splitlines()
    heights["csv"] = float(dict(zip(lines[0].split(","), lines[-1].split(",")))["height"])
    drawn = Field(res, "height").at(len(res) - 1)
    assert drawn.max() <= 0.02 + 1e-12
    for value in heights.values():
        assert value == pytest.approx(0.02, rel=1e-3)


def test_nodal_means_keep_the_integral() -> None:
    mesh = kg.Sheet(shapely.box(0, 0, 1, 1), [shapely.LineString([(0.3, 0.5), (0.7, 0.5)])]).mesh(0.2)
    values = np.random.default_rng(1).normal(size=(len(mesh.triangles), 2, 3))
    nodal = mesh.nodal_mean(values)
    assert nodal.shape == (len(mesh.nodes), 2, 3)
    np.testing.assert_allclose(
        np.einsum("n,nij->ij", mesh.nodal_areas, nodal), np.einsum("m,mij->ij", mesh.facet_areas, values), rtol=1e-12
    )
    np.testing.assert_allclose(mesh.nodal_mean(np.full(len(mesh.triangles), 3.0)), 3.0, rtol=1e-14)


def test_the_energy_of_a_crease_lies_at_the_ends_of_its_edges() -> None:
    """Shares of the nodes sum to the stored energy, that of the fold included, and none of it is off the fold."""
    mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9), stiffness="shell")
    m.add(kg.Crease([m.nodes[0], m.nodes[2]], stiffness=2.0, rest_angle=0.5))
    results = kg.Results(kg.System(m))
    results.append(kg.Step.at(m, 0.0, np.zeros((4, 3))))
    shares = nodal_energy(results)[0]
    stored = sum(values[0] for values in results.energy.values())
    assert stored > 0.1 and shares.sum() == pytest.approx(stored, rel=1e-12)
    assert shares[[0, 2]] == pytest.approx([stored / 2] * 2) and shares[[1, 3]] == pytest.approx([0, 0], abs=1e-12)
