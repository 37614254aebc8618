"""What ParaView, xarray and spreadsheets read is what was computed."""

from __future__ import annotations

import csv
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import kirigami as kg
from kirigami.files import library, whole_file
from kirigami.io.table import curves, to_csv, to_xarray
from kirigami.io.vtk import write_vtk
from kirigami.results.fields import energy_density, facet_strain, nodal_energy
from kirigami.results.smooth import sectors, surface_stress


def test_vtk_series_holds_every_step(strip: kg.Results, tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    *files, collection = strip.to_vtk(tmp_path / "new" / "folder")
    assert len(files) == len(strip)
    for index, file in enumerate(files):
        read = meshio.read(file)
        assert np.array_equal(read.points, strip.position()[index])
        assert np.array_equal(read.cells_dict["triangle"], strip.mesh.triangles)
        assert np.array_equal(read.point_data["displacement"], strip.u[index])
        assert np.array_equal(read.cell_data["strain"][0], facet_strain(strip)[index])
        assert np.array_equal(read.cell_data["stress"][0], sectors(strip).over_facets(surface_stress(strip))[index])
        held = strip.model.index(strip.model.select(boundary="left"))
        assert read.point_data["reaction"][held].sum(axis=0) == pytest.approx(strip.reaction(held)[index], abs=1e-15)
    listed = ElementTree.parse(collection).getroot().findall("Collection/DataSet")
    assert [entry.get("file") for entry in listed] == [file.name for file in files]
    assert [float(entry.get("timestep")) for entry in listed] == strip.lam.tolist()
    assert {entry.name for entry in collection.parent.iterdir()} == {file.name for file in [*files, collection]}


def test_vtk_of_bars_is_lines_and_times_count_where_the_load_turns_back(truss: kg.Results, tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    *files, collection = write_vtk(truss, tmp_path)
    assert np.any(np.diff(truss.lam) < 0)
    listed = ElementTree.parse(collection).getroot().findall("Collection/DataSet")
    assert [float(entry.get("timestep")) for entry in listed] == list(range(len(truss)))
    last = meshio.read(files[-1])
    assert last.cells_dict["line"].tolist() == [[0, 1], [1, 2]]
    assert np.array_equal(last.cell_data["force"][0], truss.bar_force[-1])


def test_paraview_library_reads_the_series(strip: kg.Results, tmp_path: Path) -> None:
    """pyvista wraps the readers that ParaView itself uses."""
    pyvista = pytest.importorskip("pyvista")
    reader = pyvista.get_reader(write_vtk(strip, tmp_path)[-1])
    assert reader.time_values == pytest.approx(strip.lam.tolist())
    for index, time in enumerate(reader.time_values):
        reader.set_active_time_value(time)
        grid = reader.read()[0]
        assert np.array_equal(grid.points, strip.position()[index])
        assert grid.n_cells == len(strip.mesh.triangles)
        assert np.array_equal(grid.point_data["energy_density"], energy_density(strip)[index])


def test_vtk_of_loaded_results(strip: kg.Results, tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    loaded = kg.load(strip.save(tmp_path / "strip.npz"))
    before, after = (meshio.read(write_vtk(res, tmp_path / name)[-2]) for res, name in ((strip, "a"), (loaded, "b")))
    assert np.array_equal(before.points, after.points)
    assert np.array_equal(before.point_data["energy_density"], after.point_data["energy_density"])


def test_nothing_to_write_is_said(strip: kg.Results, tmp_path: Path) -> None:
    empty = kg.Results(kg.System(strip.model))
    for write in (write_vtk, to_csv):
        with pytest.raises(kg.AnalysisError, match="no steps"):
            write(empty, tmp_path / "x")
    assert not list(tmp_path.iterdir())


def test_facet_strain_is_exact_for_uniform_strain_and_blind_to_rotation(strip: kg.Results) -> None:
    """Green strain of x -> R F x is (F'F - 1)/2 for every facet, whatever the rotation R."""
    model = strip.model
    gradient = np.array([[1.2, 0.3, 0.0], [-0.1, 0.9, 0.0], [0.0, 0.0, 1.0]])
    rotation = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    results = kg.Results(kg.System(model))
    for turn in (np.eye(3), rotation):
        results.append(kg.Step.at(model, 1.0, results.rest @ (turn @ gradient - np.eye(3)).T))
    largest = np.linalg.eigvalsh((gradient.T @ gradient - np.eye(3))[:2, :2] / 2)[-1]
    assert facet_strain(results) == pytest.approx(np.full((2, len(strip.mesh.triangles)), largest), abs=1e-13)


def test_energy_at_the_nodes_adds_up(strip: kg.Results, truss: kg.Results) -> None:
    for results in (strip, truss, kg.LinearStatic(strip.model).run()):
        assert nodal_energy(results).sum(axis=1) == pytest.approx(sum(results.energy.values()), rel=1e-12, abs=1e-18)


def test_csv_keeps_every_digit(strip: kg.Results, tmp_path: Path) -> None:
    path = to_csv(strip, tmp_path / "curves.csv")
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    driven = strip.model.select(boundary="right")
    assert [float(row["reaction_driven_0_z"]) for row in rows] == strip.reaction(driven, "z").tolist()
    assert [float(row["load_factor"]) for row in rows] == strip.lam.tolist()
    assert [float(row["height"]) for row in rows] == np.ptp(strip.position()[..., 2], axis=1).tolist()
    assert "reaction_grip_x" in curves(strip, {"grip": driven})


def test_dataset_names_what_it_holds_and_survives_netcdf(strip: kg.Results, truss: kg.Results, tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    for results in (strip, truss):
        data = to_xarray(results)
        data.to_netcdf(tmp_path / f"{results.name}.nc", engine="h5netcdf")
        with xarray.open_dataset(tmp_path / f"{results.name}.nc", engine="h5netcdf") as read:
            assert np.array_equal(read.displacement, results.u)
            assert np.array_equal(read.load_factor, results.lam)
            assert np.array_equal(read.bar_force, results.bar_force)
            assert read.bar_force.dims == ("step", "bar")
            assert read.stable.dtype == bool
    assert np.array_equal(to_xarray(strip).hinge_angle, strip.hinge_angle)
    assert np.array_equal(to_xarray(strip).triangles, strip.mesh.triangles)


def test_a_file_is_whole_or_absent(tmp_path: Path) -> None:
    path = tmp_path / "result.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError), whole_file(path) as unfinished:
        unfinished.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old" and [entry.name for entry in tmp_path.iterdir()] == ["result.txt"]
    with pytest.raises(kg.KirigamiError, match="folder"), whole_file(tmp_path):
        pass
    with pytest.raises(kg.KirigamiError, match="cannot write"), whole_file(path / "below" / "a file"):
        pass


def test_missing_library_says_what_for_and_how() -> None:
    with pytest.raises(kg.KirigamiError, match=r"making tea needs no_such_kettle: pip install"):
        library("no_such_kettle.spout", "making tea")
