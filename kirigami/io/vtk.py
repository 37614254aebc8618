"""A series of VTK files that ParaView animates, written through meshio."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from kirigami.errors import AnalysisError, ModelError
from kirigami.files import library, whole_file
from kirigami.primitives.checks import require_path, require_text
from kirigami.results.fields import energy_density, facet_strain
from kirigami.results.results import Results
from kirigami.results.smooth import known_stress, sectors
from kirigami.results.yielding import facet_plastic_strain


def write_vtk(results: Results, folder: str | os.PathLike[str], name: str = "step") -> list[Path]:
    """Write one VTU file per step and a PVD file that lists them.

    Open the PVD file in ParaView. The points are the deformed positions; the rest state is ``points - displacement``.
    Point data: ``displacement`` [length], ``reaction`` [force], ``energy_density`` [force / length; energy per node
    without a mesh]. Cell data: ``strain`` of the facets (largest principal Green strain) and ``stress`` (von Mises' at
    the face where it is larger, of means round each node that jump at folds; where it is known) of a mesh, with
    ``plastic_strain`` (accumulated, the largest over the thickness) where something has yielded, else
    ``force`` and ``strain`` of the bars. The time of a step is its load factor where that keeps growing, else its
    number.

    Parameters
    ----------
    results : Results
        What to write.
    folder : path
        Where to; it is made if it is missing, and files of the same names are replaced.
    name : str
        Start of the file names.

    Returns
    -------
    list of Path
        The VTU files in the order of the steps, then the PVD file.

    Raises
    ------
    AnalysisError
        There are no steps.
    KirigamiError
        meshio is not installed, or the folder cannot be written.

    Examples
    --------
    >>> from kirigami.io.vtk import write_vtk
    >>> import tempfile, kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> files = write_vtk(kg.LinearStatic(m).run(), tempfile.mkdtemp())
    >>> [file.name for file in files]
    ['step_0000.vtu', 'step_0001.vtu', 'step.pvd']
    """
    target = require_path(folder, "folder", "to_vtk")
    if not require_text(name, "name", "to_vtk") or set(name) & set("/\\\0"):
        raise ModelError(f"to_vtk: name must be the start of a file name, got {name!r}")
    if not len(results):
        raise AnalysisError("there are no steps to write", results=results)
    meshio = library("meshio", "writing VTK files")
    cells, cell_data = _cells(results)
    energy = energy_density(results)
    reaction = _reactions(results)
    positions = results.position()
    files = []
    for index in range(len(results)):
        fields = {"displacement": results.u, "reaction": reaction, "energy_density": energy}
        point_data = {key: values[index] for key, values in fields.items()}
        mesh = meshio.Mesh(
            positions[index], cells, point_data, {key: [values[index]] for key, values in cell_data.items()}
        )
        path = target / f"{name}_{index:04d}.vtu"
        with whole_file(path) as unfinished:
            mesh.write(unfinished, file_format="vtu")
        files.append(path)
    path = target / f"{name}.pvd"
    with whole_file(path) as unfinished:
        unfinished.write_text(_collection(results, files), encoding="utf-8")
    return [*files, path]


def _cells(results: Results) -> tuple[list[tuple[str, Any]], dict[str, Any]]:
    """Cells to draw and their data by step (s, cells)."""
    if results.mesh is not None:
        data = {"strain": facet_strain(results)}
        parts = sectors(results)
        stress = known_stress(results)
        if stress is not None:
            data["stress"] = parts.over_facets(stress)
        if np.nan_to_num(results.yielded).any():
            data["plastic_strain"] = facet_plastic_strain(results)
        return [("triangle", results.mesh.triangles)], data
    if not len(results.bars):
        return [("vertex", np.arange(len(results.rest))[:, None])], {}
    return [("line", results.bars)], {"force": results.bar_force, "strain": results.bar_strain}


def _reactions(results: Results) -> Any:
    """Force of the supports on each node (s, n, 3), zero where nothing is held."""
    held = np.zeros((len(results.rest), 3), dtype=bool)
    held[:, : results.dim] = np.reshape(results.constrained, (-1, results.dim))[: len(results.rest)]
    return np.where(held, results._gradients, 0.0)


def _collection(results: Results, files: list[Path]) -> str:
    lam = results.time if results.moves else results.lam
    times = lam if np.all(np.diff(lam) > 0) else np.arange(len(lam))
    lines = [
        f'    <DataSet timestep="{time:.17g}" group="" part="0" file="{file.name}"/>'
        for time, file in zip(times, files)
    ]
    head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n  <Collection>'
    return "\n".join([head, *lines, "  </Collection>", "</VTKFile>", ""])
