"""The deformed sheet as a surface for other programs: STL, OBJ, PLY and glTF, through trimesh."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from kirigami.errors import AnalysisError, ModelError
from kirigami.files import library, whole_file
from kirigami.primitives.checks import require_path, require_whole
from kirigami.results.results import Results

ENDINGS = (".stl", ".obj", ".ply", ".glb", ".gltf")


def write_surface(results: Results, path: str | os.PathLike[str], step: int = -1) -> Path:
    """Write the facets of one step; the ending of the file name says how.

    glTF is written as one binary file (``.glb``), or as JSON with its data inside (``.gltf``). STL and glTF keep single
    precision only, about seven digits; STL keeps no connections between facets.

    Parameters
    ----------
    results : Results
        Of a model that was made from a mesh.
    path : path
        The file, ending in .stl, .obj, .ply, .glb or .gltf.
    step : int
        Which step.

    Raises
    ------
    AnalysisError
        The model has no mesh, or there is no such step.
    ModelError
        Another ending.
    KirigamiError
        trimesh is not installed, or the file cannot be written.

    Examples
    --------
    >>> import tempfile, kirigami as kg
    >>> mesh = kg.TriMesh([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]])
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e6))
    >>> res = kg.Results(kg.System(m))
    >>> res.append(kg.Step.at(m, 1.0, [[0, 0, 0], [0, 0, 0], [0, 0, 0.5]]))
    >>> write_surface(res, Path(tempfile.mkdtemp()) / "sheet.stl").stat().st_size  # 84 bytes and 50 for each facet
    134
    """
    target = require_path(path, "path", "to_surface")
    step = require_whole(step, "step", "to_surface")
    ending = target.suffix.lower()
    if ending not in ENDINGS:
        raise ModelError(f"surfaces are written as {', '.join(ENDINGS)}, not {target.name!r}")
    if results.mesh is None:
        raise AnalysisError("a surface needs a model made by Model.from_mesh", results=results)
    if not -len(results) <= step < len(results):
        raise AnalysisError(f"there is no step {step}: the results hold {len(results)}", results=results)
    trimesh = library("trimesh", "writing surfaces")
    positions = results.position()[step]
    surface = trimesh.Trimesh(positions, np.asarray(results.mesh.triangles), process=False)
    options = {"digits": 17} if ending == ".obj" else {}
    if ending == ".gltf":
        files = trimesh.exchange.gltf.export_gltf(trimesh.Scene(surface), embed_buffers=True)
        content = files["model.gltf"]
    else:
        content = surface.export(file_type=ending[1:], **options)
    with whole_file(target) as unfinished:
        unfinished.write_bytes(content if isinstance(content, bytes) else content.encode())
    return target
