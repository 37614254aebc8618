"""FOLD files, the format that origami programs share (Demaine, Ku and Lang, FOLD specification 1.2)."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike

from kirigami.drawing.curves import Curve, scale_of, scaled
from kirigami.drawing.drawing import Drawing, assemble
from kirigami.drawing.fold_frames import frame_of, pattern_of
from kirigami.drawing.roles import Names, Roles
from kirigami.drawing.strokes import strokes
from kirigami.errors import GeometryError
from kirigami.files import read_json, whole_file
from kirigami.geometry.folds import fold_angles
from kirigami.geometry.mesh import TriMesh
from kirigami.primitives.checks import require_array, require_path
from kirigami.units import metres_per
from kirigami.words import counted

ROLES = {"B": "outline", "C": "cut", "M": "mountain fold", "V": "valley fold", "U": "fold"}  # F, J: no line to act on
SIDES = {"M": -1.0, "V": 1.0}
LETTERS = {"OUTLINE": "B", "CUTS": "C", "FOLDS": "U", "MOUNTAIN FOLDS": "M", "VALLEY FOLDS": "V"}
UNITS = {"in", "pt", "m", "cm", "mm", "um", "nm"}  # those of the specification


def read_fold(
    path: str | os.PathLike[str],
    *,
    folds: Names = None,
    ignore: Names = None,
    unit: str = "m",
    drawn_in: str | None = None,
    tolerance: float | str = 1e-4,
    part: int | None = None,
    frame: int | None = None,
) -> Drawing:
    """Read outline, cuts and folds from the crease pattern of a FOLD file.

    Edges assigned B are the outline (and the rims of holes), C cuts, M, V and U folds; F and J are left out. Edges that
    follow one another in a line are one cut. The sheet may lie in any plane. Cuts may be written as C, or as rims
    inside the sheet, single or double; what has one facet is a rim, whatever it is assigned. Without rims, the outer
    face of all edges is the outline.

    Parameters
    ----------
    path : path
        The file.
    folds, ignore : str or list of str, optional
        Of the layers "mountain fold", "valley fold" and "fold", those to take as folds and to leave out.
    unit : str
        Unit of length of the sheet.
    drawn_in : str, optional
        Unit of the coordinates, where the file does not say.
    tolerance : float or str
        As for :func:`kirigami.drawing.dxf.read_dxf`.
    part : int, optional
        Which part to take, from 1, where several lie side by side or cuts sever the sheet.
    frame : int, optional
        Which frame of the file to read; unless given, the first crease pattern, or else the first frame with edges.

    Raises
    ------
    GeometryError
        No such file, no FOLD file, arrays that do not fit, coordinates out of the plane, a folded form that lies on
        itself, no outline.

    Examples
    --------
    >>> from pathlib import Path
    >>> import shapely
    >>> from kirigami.drawing.drawing import Drawing
    >>> from kirigami.drawing.fold import read_fold, write_fold
    >>> import tempfile
    >>> plate = Drawing(shapely.box(0, 0, 2, 1), (shapely.LineString([(0.5, 0.5), (1.5, 0.5)]),), unit="m")
    >>> drawing = read_fold(write_fold(plate, Path(tempfile.mkdtemp()) / "plate.fold"))
    >>> drawing.outline.area, drawing.cuts[0].length
    (2.0, 1.0)
    """
    path = require_path(path, "path", "read_fold", GeometryError)
    data = read_json(path, "FOLD")
    if not isinstance(data, dict):
        raise GeometryError(f"{path} is no FOLD file: it has no vertices_coords and edges_vertices")
    number, held = frame_of(data, frame, path)
    found = pattern_of(held, path)
    notes = [f"{path.name}: FOLD {data.get('file_spec', '')}".rstrip()]
    if number:
        notes.append(f"frame {number} of {1 + len(data['file_frames'])}")
    said = str(held.get("frame_unit") or data.get("frame_unit") or "unit").replace("unit", "") or None
    factor, unit = scale_of(unit, drawn_in, said, notes)
    flat = sum(letter not in ROLES for letter in found.letters)
    if flat:
        notes.append(f"{counted(flat, 'flat or joined edge')} (F, J) left out")
    curves = [
        Curve(
            scaled(found.points[edge], factor), ROLES[letter], "", f"edge {which}", fold=SIDES.get(letter, 0.0) * angle
        )
        for which, edge, letter, angle in zip(found.numbers, found.edges, found.letters, found.angles)
        if letter in ROLES
    ]
    return assemble(
        curves,
        Roles(folds=folds, ignore=ignore),
        unit=unit,
        tolerance=tolerance,
        notes=notes,
        shown=drawn_in or said,
        part=part,
        bounded_by_folds=True,
    )


def write_fold(
    item: Any,
    path: str | os.PathLike[str],
    *,
    unit: str = "m",
    folds: Iterable[Any] = (),
    positions: ArrayLike | None = None,
) -> Path:
    """Write a sheet as a crease pattern, or a mesh as facets with their fold angles.

    A sheet gives vertices and edges: B outline, C cuts, U folds, split where they cross. A mesh gives facets
    as well; the lips of cuts are B, inner edges F where flat, else M or V with ``edges_foldAngle`` in degrees, and the
    vertices are those of the deformed sheet.

    Parameters
    ----------
    item : Sheet, Drawing or TriMesh
        What to write.
    path : path
        The file.
    unit : str
        Unit of length of the coordinates; noted in the file where the format knows it.
    folds : iterable of LineString
        Of a sheet: lines to be folded and not cut.
    positions : array_like, shape (n, 3), optional
        Of a mesh: where its nodes are now; None is where they were drawn.

    Raises
    ------
    KirigamiError
        The file cannot be written.

    Examples
    --------
    >>> import json
    >>> from pathlib import Path
    >>> import kirigami as kg
    >>> from kirigami.drawing.fold import write_fold
    >>> import tempfile
    >>> mesh = kg.TriMesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 2, 3)])
    >>> file = write_fold(mesh, Path(tempfile.mkdtemp()) / "square.fold")
    >>> json.loads(file.read_text())["edges_assignment"]
    ['B', 'F', 'B', 'B', 'B']
    """
    if not isinstance(unit, str) or unit not in UNITS:
        metres_per(unit)
    if isinstance(item, TriMesh):
        shape = item.nodes.shape
        here = item.nodes if positions is None else require_array(positions, shape, name="positions", owner="to_fold")
        frame = _facets(item, here)
    elif positions is not None:
        raise GeometryError("to_fold: positions are those of a mesh, and this is a sheet")
    else:
        frame = _pattern(item, folds)
    head: dict[str, Any] = {"file_spec": 1.2, "file_creator": "kirigami", "frame_classes": [frame.pop("class")]}
    if unit in UNITS:
        head["frame_unit"] = unit
    target = require_path(path, "path", "to_fold", GeometryError)
    with whole_file(target) as unfinished:
        unfinished.write_text(json.dumps(head | frame))
    return target


def _pattern(sheet: Any, folds: Iterable[Any]) -> dict[str, Any]:
    lines, letters = [], []
    for stroke in strokes(sheet, folds, arcs=False):
        ring = np.concatenate([stroke.points, stroke.points[:1]]) if stroke.closed else stroke.points
        for piece in pairwise(ring):
            lines.append(shapely.LineString(piece))
            letters.append(LETTERS[stroke.layer])
    tree = shapely.STRtree(lines)
    vertices: dict[tuple[float, float], int] = {}
    edges: dict[tuple[int, int], str] = {}
    for line, letter in zip(lines, letters):
        start, end = (tuple(point) for point in shapely.get_coordinates(line).tolist())
        on_line = {start, end}
        for other in tree.query(line, predicate="intersects"):
            met = shapely.intersection(line, lines[other])
            on_line.update(tuple(point) for point in shapely.get_coordinates(met).tolist())
        chain = sorted(on_line, key=lambda point: math.dist(point, start))
        numbers = [vertices.setdefault(point, len(vertices)) for point in chain]
        for pair in pairwise(numbers):
            if pair[0] != pair[1]:
                edges.setdefault((min(pair), max(pair)), letter)  # an outline drawn first stays one
    return {
        "class": "creasePattern",
        "vertices_coords": [list(point) for point in vertices],
        "edges_vertices": [list(edge) for edge in edges],
        "edges_assignment": list(edges.values()),
    }


def _facets(mesh: TriMesh, points: Any) -> dict[str, Any]:
    inner = mesh.edge_facets[:, 1] >= 0
    # Positive for a valley seen from +z, as the specification has it: the wings fold towards the normal.
    corners = points[np.column_stack([mesh.edge_wings[:, 0], mesh.edges, mesh.edge_wings[:, 1]])]
    degrees = np.where(inner, np.degrees(fold_angles(corners)), 0.0)
    letters = np.where(inner, np.where(degrees > 1e-7, "V", np.where(degrees < -1e-7, "M", "F")), "B")
    return {
        "class": "foldedForm" if np.ptp(points[:, 2]) > 0 else "creasePattern",
        "vertices_coords": points.tolist(),
        "edges_vertices": mesh.edges.tolist(),
        "edges_assignment": letters.tolist(),
        "edges_foldAngle": [value if flag else None for value, flag in zip(degrees.tolist(), inner.tolist())],
        "faces_vertices": mesh.triangles.tolist(),
    }
