"""Drawings, meshes and results from one kind of file to another, by the endings of their names."""

from __future__ import annotations

import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from kirigami import units
from kirigami.drawing.convert import read_drawing, write_drawing
from kirigami.drawing.drawing import Drawing
from kirigami.errors import GeometryError
from kirigami.files import library, whole_file
from kirigami.geometry.mesh import TriMesh
from kirigami.primitives.checks import require_path
from kirigami.results.archive import load
from kirigami.results.results import Results


def info(path: str | os.PathLike[str], **reading: Any) -> dict[str, Any]:
    """What a drawing or a results file holds.

    Parameters
    ----------
    path : path
        A drawing, or results that :meth:`kirigami.Results.save` wrote (.npz).
    **reading
        Options of the reader of a drawing.

    Returns
    -------
    dict
        "kind", "text" for a person, and numbers.

    Raises
    ------
    GeometryError, AnalysisError
        The file cannot be read.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.drawing.convert import write_drawing
    >>> from kirigami.io.convert import info
    >>> import shapely, tempfile, kirigami as kg
    >>> file = write_drawing(kg.Sheet(shapely.box(0, 0, 0.2, 0.1)), Path(tempfile.mkdtemp()) / "plate.geojson")
    >>> info(file)["width"]
    0.2
    """
    if Path(path).suffix.lower() != ".npz":
        return info_of_drawing(read_drawing(path, **reading))
    results = load(path)
    return {
        "kind": "results",
        "text": results.summary(),
        "nodes": len(results.rest),
        "steps": len(results),
        "load_factor": float(results.lam[-1]) if len(results) else 0.0,
    }


def info_of_drawing(drawing: Drawing) -> dict[str, Any]:
    """What was understood of a drawing: as text, and its numbers.

    Parameters
    ----------
    drawing : Drawing
        What a reader has made of a file.

    Examples
    --------
    >>> from kirigami.drawing.drawing import Drawing
    >>> from kirigami.io.convert import info_of_drawing
    >>> import shapely
    >>> info_of_drawing(Drawing(shapely.box(0, 0, 2, 1), (shapely.box(0.5, 0.5, 1, 0.75),)))["area"]
    1.875
    """
    xmin, ymin, xmax, ymax = drawing.outline.bounds
    closed = sum(cut.geom_type == "Polygon" for cut in drawing.cuts)
    return {
        "kind": "drawing",
        "text": drawing.report,
        "width": xmax - xmin,
        "height": ymax - ymin,
        "unit": drawing.unit,
        "area": drawing.sheet().area,
        "cuts": len(drawing.cuts),
        "slits": len(drawing.cuts) - closed,
        "openings": closed,
        "folds": len(drawing.folds),
        "roles": [asdict(row) for row in drawing.table],
    }


def mesh_drawing(
    path: str | os.PathLike[str],
    max_edge: float | str | None = None,
    output: str | os.PathLike[str] | None = None,
    **reading: Any,
) -> TriMesh:
    """Mesh a drawing and, if asked, write the mesh.

    Parameters
    ----------
    path : path
        The drawing.
    max_edge : float or str, optional
        Largest edge [m]; None lets the mesh choose its sizes (see :meth:`Sheet.mesh`).
    output : path, optional
        Where to write: .fold, or any ending that meshio writes triangles to (.vtu, .stl, .msh, .inp, ...).
    **reading
        Options of the reader.

    Raises
    ------
    GeometryError
        The drawing cannot be read or meshed, or the ending is unknown.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.drawing.convert import write_drawing
    >>> from kirigami.io.convert import mesh_drawing
    >>> import shapely, tempfile, kirigami as kg
    >>> file = write_drawing(kg.Sheet(shapely.box(0, 0, 0.2, 0.1)), Path(tempfile.mkdtemp()) / "plate.geojson")
    >>> round(float(mesh_drawing(file, "20mm").facet_areas.sum()), 12)
    0.02
    """
    if output is not None:
        _require_mesh_ending(require_path(output, "output", "mesh_drawing", GeometryError))
    drawing = read_drawing(path, **{**reading, "unit": "m"})
    edge = None if max_edge is None else units.parse(max_edge, "length")
    mesh = drawing.sheet().mesh(edge)
    if output is not None:
        write_mesh(mesh, output)
    return mesh


def write_mesh(mesh: TriMesh, path: str | os.PathLike[str]) -> Path:
    """Write a mesh as FOLD, or as whatever meshio knows by its ending.

    Parameters
    ----------
    mesh : TriMesh
        The mesh.
    path : path
        The file.

    Raises
    ------
    GeometryError
        An ending that meshio does not know.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.io.convert import write_mesh
    >>> import tempfile, kirigami as kg
    >>> mesh = kg.TriMesh([(0, 0), (1, 0), (0, 1)], [(0, 1, 2)])
    >>> write_mesh(mesh, Path(tempfile.mkdtemp()) / "one.fold").name
    'one.fold'
    """
    target = require_path(path, "path", "write_mesh", GeometryError)
    meshio = _require_mesh_ending(target)
    if meshio is None:
        from kirigami.drawing.fold import write_fold

        return write_fold(mesh, target)
    try:
        with whole_file(target) as unfinished:
            meshio.Mesh(np.array(mesh.nodes), [("triangle", np.array(mesh.triangles))]).write(unfinished)
    except (meshio.ReadError, meshio.WriteError, KeyError):
        raise GeometryError(f"{target}: no format for this ending: it does not take triangles") from None
    return target


def _require_mesh_ending(target: Path) -> Any:
    """The library that writes meshes of this ending; None where that is this package."""
    ending = target.suffix.lower()
    if ending == ".fold":
        return None
    meshio = library("meshio", "writing meshes")
    if ending not in meshio.extension_to_filetypes:
        known = ", ".join(sorted(meshio.extension_to_filetypes))
        raise GeometryError(f"{target}: no format for this ending; meshes end in .fold, {known}")
    return meshio


PICTURES, FILMS = (".png", ".pdf", ".svg"), (".gif", ".mp4")


def export(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    step: int = -1,
    unit: str | None = None,
    thickness: float | bool = False,
    color: str | None = None,
    view: str | tuple[float, float] | None = None,
    frames: int = 40,
    kerf: float = 0.0,
    **reading: Any,
) -> list[Path]:
    """Turn results or a drawing into another kind of file, by the ending of its name.

    Results (.npz) become a page (.html), tables (.csv, .nc), ParaView files (.pvd; its .vtu files go beside it),
    pictures (.png, .pdf, .svg), films (.gif, .mp4), surfaces (.stl, .obj, .ply, .glb, .gltf) or .fold; drawings become
    .dxf, .svg, .geojson or .fold.

    Parameters
    ----------
    path : path
        What to turn.
    output : path
        What to write.
    step : int
        Which step of results a picture, a surface or a .fold file shows; -1 is the last.
    unit, thickness
        Of surfaces, see :func:`kirigami.io.surface.write_surface`.
    color, view
        Of pictures and films, see :func:`kirigami.plot.plot_results`.
    frames : int
        Pictures in a film.
    kerf : float
        Of a drawing as .dxf or .svg: width of what the cutter takes away [m].
    **reading
        Options of the reader of a drawing.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    GeometryError, AnalysisError, ModelError
        The file cannot be read, or there is no such kind of output, step or colour.
    KirigamiError
        A library that is needed is not installed: the message names it.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.drawing.convert import write_drawing
    >>> from kirigami.io.convert import export
    >>> import shapely, tempfile, kirigami as kg
    >>> folder = Path(tempfile.mkdtemp())
    >>> file = write_drawing(kg.Sheet(shapely.box(0, 0, 0.2, 0.1)), folder / "plate.geojson")
    >>> [made.name for made in export(file, folder / "plate.fold")]
    ['plate.fold']
    """
    target = Path(output)
    if Path(path).suffix.lower() != ".npz":
        return [write_drawing(read_drawing(path, **{**reading, "unit": "m"}), target, kerf=kerf)]
    if kerf:
        raise GeometryError(f"{path}: a `kerf` is for drawings that are cut, not for results")
    results = load(path)
    step = results.step_number(step, "export")
    ending = target.suffix.lower()
    if ending in PICTURES:
        return [_write_picture(results, target, step, color, view)]
    if ending in FILMS:
        return [results.animate(target, frames=frames, color=color, view=view)]
    if ending == ".html":
        from kirigami.io.html import to_html

        return [to_html(results, target)]
    if ending == ".csv":
        from kirigami.io.table import to_csv

        return [to_csv(results, target)]
    if ending == ".nc":
        with whole_file(target) as unfinished:
            results.to_xarray().to_netcdf(unfinished)
        return [target]
    if ending == ".pvd":
        from kirigami.io.vtk import write_vtk

        return write_vtk(results, target.parent, target.stem)
    if ending == ".fold":
        from kirigami.drawing.fold import write_fold

        if results.mesh is None:
            raise GeometryError("only results of a model made by Model.from_mesh have facets to write")
        return [write_fold(results.mesh, target, positions=results.position()[step, : len(results.mesh.nodes)])]
    from kirigami.io.surface import ENDINGS, write_surface

    if ending in ENDINGS:
        return [write_surface(results, target, step, unit, thickness)]
    kinds = ", ".join((".html", ".csv", ".nc", ".pvd", *PICTURES, *FILMS, ".fold", *ENDINGS))
    raise GeometryError(f"{target}: results are exported as {kinds}")


def _write_picture(results: Results, target: Path, step: int, color: Any, view: Any) -> Path:
    from matplotlib import pyplot

    figure = results.plot(step, color=color, view=view).figure
    try:
        with whole_file(target) as unfinished:
            figure.savefig(unfinished, dpi=200, bbox_inches="tight")
    finally:
        pyplot.close(figure)
    return target
