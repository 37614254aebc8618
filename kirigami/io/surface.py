"""The deformed sheet as a surface for other programs: STL, OBJ, PLY and glTF, through trimesh."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import AnalysisError, ModelError
from kirigami.files import library, whole_file
from kirigami.geometry.mesh import TriMesh
from kirigami.primitives.checks import require_path, require_positive, require_whole
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.units import metres_per

ENDINGS = (".stl", ".obj", ".ply", ".glb", ".gltf")


def write_surface(
    results: Results,
    path: str | os.PathLike[str],
    step: int = -1,
    unit: str | None = None,
    thickness: float | bool = False,
) -> Path:
    """Write the facets of one step; the ending of the file name says how.

    STL knows no unit, and what prints or slices it takes millimetres: results that are known to be in metres are
    written so.

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
    unit : str, optional
        Unit of the coordinates, "mm", "in" and so on, of results in metres; None takes millimetres for STL of results
        that are known to be in metres, else leaves the numbers as they are.
    thickness : bool or float
        True for a closed body as thick as the sheet, half to each side of it; or how thick [length].

    Raises
    ------
    AnalysisError
        The model has no mesh, or there is no such step.
    ModelError
        Another ending, an unknown unit, or a thickness that is not known.
    KirigamiError
        trimesh is not installed, or the file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.io.surface import write_surface
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
    if unit is None:
        unit = "mm" if ending == ".stl" and results.units else "m"
    factor = 1.0 / metres_per(unit)
    trimesh = library("trimesh", "writing surfaces")
    points, facets = results.position()[step][: len(results.mesh.nodes)], np.asarray(results.mesh.triangles)
    if thickness is not False:
        points, facets = solid(points, results.mesh, _checked_thickness(results, thickness))
    surface = trimesh.Trimesh(factor * points, facets, process=False)
    options = {"digits": 17} if ending == ".obj" else {}
    if ending == ".gltf":
        files = trimesh.exchange.gltf.export_gltf(trimesh.Scene(surface), embed_buffers=True)
        content = files["model.gltf"]
    else:
        content = surface.export(file_type=ending[1:], **options)
    with whole_file(target) as unfinished:
        unfinished.write_bytes(content if isinstance(content, bytes) else content.encode())
    return target


def solid(points: Array, mesh: TriMesh, thickness: float) -> tuple[Array, NDArray[np.int64]]:
    """A closed body round a surface: both faces, half the thickness off along the mean normals, and walls at the rims.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Positions of the nodes of the mesh.
    mesh : TriMesh
        The surface.
    thickness : float
        How thick [length].

    Returns
    -------
    points, facets : ndarray, shape (2 n, 3) and (k, 3)
        Corners and triangles, which face outwards.

    Examples
    --------
    >>> import numpy as np, kirigami as kg
    >>> from kirigami.io.surface import solid
    >>> mesh = kg.TriMesh([(0, 0), (1, 0), (0, 1)], [(0, 1, 2)])
    >>> corners, facets = solid(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), mesh, 0.2)
    >>> len(corners), len(facets), corners[:, 2].tolist()
    (6, 8, [0.1, 0.1, 0.1, -0.1, -0.1, -0.1])
    """
    facets = np.asarray(mesh.triangles)
    corners = points[facets]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = np.zeros_like(points)
    for corner in facets.T:
        np.add.at(normal, corner, area)
    length = np.linalg.norm(normal, axis=1)
    off = 0.5 * thickness * normal / np.where(length > 0, length, 1.0)[:, None]
    n = len(points)
    walls = []
    for a, b in ((facets[:, k], facets[:, (k + 1) % 3]) for k in range(3)):
        code = np.minimum(a, b) * n + np.maximum(a, b)
        ends = mesh.edges[mesh.boundary_edges]
        rim = np.isin(code, ends.min(axis=1) * n + ends.max(axis=1))
        first, second = a[rim], b[rim]
        walls += [np.stack([first, first + n, second + n], axis=1), np.stack([first, second + n, second], axis=1)]
    return np.concatenate([points + off, points - off]), np.concatenate([facets, facets[:, ::-1] + n, *walls])


def _checked_thickness(results: Results, thickness: float | bool) -> float:
    if thickness is not True:
        return require_positive(thickness, "thickness", "to_surface")
    known = results.thickness
    if known is None:
        raise ModelError("to_surface: the thickness of the sheet is not known: say how thick")
    if np.ndim(known):
        raise ModelError("to_surface: the sheet has several thicknesses: say how thick the body is to be")
    return float(known)
