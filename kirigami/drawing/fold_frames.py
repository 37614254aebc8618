"""Frames of a FOLD file: which one holds the flat sheet, in what plane it lies, and what each of its edges is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from kirigami.drawing.curves import Floats
from kirigami.errors import GeometryError
from kirigami.primitives.checks import require_whole
from kirigami.words import counted

Integers = NDArray[np.int64]

FLAT = 1e-6  # of the size: what leaves the plane by less is flat; files often hold single precision
SAME = 1e-9  # of the size: vertices as near as this are the lips of one cut
STRONGEST = "CBMVUFJ"  # of edges drawn on one another the first of these counts


@dataclass(frozen=True, eq=False)
class Pattern:
    """Edges of the flat sheet: their ends, a letter of the specification for each, and how far it is folded.

    The angles are in radians without their sign, which the letter has; 1 for all where the file has none.
    """

    points: Floats
    edges: Integers
    letters: list[str]
    numbers: list[int]
    angles: list[float]


def frame_of(data: dict[str, Any], wanted: int | None, path: Any) -> tuple[int, dict[str, Any]]:
    """The frame with the flat sheet, what it inherits included, and its number; frame 0 is the file itself.

    Crease patterns come first, then frames that do not say what they are, then folded forms.
    """
    frames = [data, *(data.get("file_frames") or [])]
    if not all(isinstance(frame, dict) for frame in frames):
        raise GeometryError(f"{path}: file_frames must hold frames")
    whole = {number: _inherited(frames, number, path) for number in range(len(frames))}
    able = [n for n, frame in whole.items() if frame.get("vertices_coords") and any(frame.get(key) for key in
            ("edges_vertices", "faces_vertices", "vertices_vertices"))]  # fmt: skip
    if wanted is not None:
        if require_whole(wanted, "frame", "read_fold", None, GeometryError) not in able:
            raise GeometryError(f"{path} has no frame {wanted} with vertices_coords and edges_vertices; it has {able}")
        return wanted, whole[wanted]
    if not able:
        raise GeometryError(f"{path} is no FOLD file: it has no vertices_coords and edges_vertices")

    def rank(number: int) -> int:
        classes = whole[number].get("frame_classes") or []
        return 0 if "creasePattern" in classes else 2 if "foldedForm" in classes else 1

    best = min(able, key=lambda number: (rank(number), number))
    return best, whole[best]


def _inherited(frames: list[dict[str, Any]], number: int, path: Any) -> dict[str, Any]:
    chain = [number]
    while frames[chain[-1]].get("frame_inherit") and chain[-1]:
        parent = frames[chain[-1]].get("frame_parent", 0)
        if not isinstance(parent, int) or not 0 <= parent < len(frames) or parent in chain:
            raise GeometryError(f"{path}: frame {chain[-1]} inherits from frame {parent}, which cannot be")
        chain.append(parent)
    result: dict[str, Any] = {}
    for one in reversed(chain):
        result |= {key: value for key, value in frames[one].items() if not key.startswith("file_")}
    return result


def pattern_of(frame: dict[str, Any], path: Any) -> Pattern:
    """The edges of a frame in its plane.

    A cut may be written in any of these ways: an edge assigned C; an edge assigned B with facets at both sides, or
    inside the sheet; two edges assigned B on one another, whose vertices are double; facets that lie side by side
    without sharing an edge; a facet that runs along an edge to and fro.
    """
    try:
        points = np.array([[*point, 0.0, 0.0][:3] for point in frame["vertices_coords"]], dtype=float)
        faces = [np.array(face, dtype=np.int64) for face in frame.get("faces_vertices") or []]
        edges = _edges(frame, faces)
    except (TypeError, ValueError, OverflowError) as error:
        raise GeometryError(f"{path}: vertices_coords or edges_vertices hold no numbers ({error})") from None
    letters = [str(letter).upper() for letter in frame.get("edges_assignment") or []] or ["U"] * len(edges)
    if len(letters) != len(edges):
        raise GeometryError(
            f"{path}: {counted(len(edges), 'edge')}, but {counted(len(letters), 'value')} in edges_assignment"
        )
    wrong = np.flatnonzero((edges < 0).any(axis=1) | (edges >= len(points)).any(axis=1))
    if wrong.size:
        raise GeometryError(f"{path}: edge {wrong[0]} names a vertex beyond 0 .. {len(points) - 1}")
    for number, face in enumerate(faces):
        if len(face) < 3 or (face < 0).any() or (face >= len(points)).any():
            raise GeometryError(f"{path}: face {number} has fewer than three vertices, or one beyond {len(points) - 1}")
    flat = _in_plane(points, path)
    if "foldedForm" in (frame.get("frame_classes") or []):
        _refuse_folded(flat, edges, faces, path)
    letters = [letter if letter in STRONGEST else "U" for letter in letters]
    if faces:
        letters = _by_faces(edges, letters, faces)
    return _merged(flat, edges, letters, _angles(frame, len(edges), path))


def _angles(frame: dict[str, Any], count: int, path: Any) -> list[float]:
    """How far each edge is folded in the end; of a flat frame without angles each as far as the others."""
    given = frame.get("edges_foldAngle") or []
    if given and len(given) != count:
        raise GeometryError(f"{path}: {counted(count, 'edge')}, but {counted(len(given), 'value')} in edges_foldAngle")
    try:
        degrees = np.array([0.0 if value is None else abs(float(value)) for value in given])
    except (TypeError, ValueError, OverflowError) as error:
        raise GeometryError(f"{path}: edges_foldAngle holds no numbers ({error})") from None
    if not np.isfinite(degrees).all():
        raise GeometryError(f"{path}: edges_foldAngle has a value that is not finite")
    return np.radians(degrees).tolist() if degrees.any() else [1.0] * count


def _edges(frame: dict[str, Any], faces: list[Integers]) -> Integers:
    given = frame.get("edges_vertices")
    if given:
        return np.array(given, dtype=np.int64).reshape(-1, 2)
    pairs = [pair for face in faces for pair in _sides(face)]
    if not pairs:
        beside = frame.get("vertices_vertices") or []
        pairs = [(one, int(other)) for one, others in enumerate(beside) for other in others]
    if not pairs:
        return np.empty((0, 2), np.int64)
    edges: Integers = np.unique(np.sort(np.array(pairs, dtype=np.int64), axis=1), axis=0)
    return edges


def _sides(face: Integers) -> Iterator[tuple[int, int]]:
    yield from pairwise([*face.tolist(), int(face[0])])


def _in_plane(points: Floats, path: Any) -> Floats:
    """Coordinates in the plane of the sheet, seen from the side where its normal points to the greater coordinate."""
    if not np.isfinite(points).all():
        raise GeometryError(f"{path}: vertex {int(np.argmin(np.isfinite(points).all(axis=1)))} is not finite")
    if not len(points) or np.ptp(points[:, 2]) == 0:
        return points[:, :2]
    middle = points - points.mean(axis=0)
    size = float(np.abs(middle).max()) or 1.0
    _, _, axes = np.linalg.svd(middle / size, full_matrices=False)
    normal = axes[2]
    if np.abs(middle @ normal).max() > FLAT * size:
        raise GeometryError(f"{path} holds a folded form: its vertices leave the plane; give the crease pattern")
    normal = normal * np.sign(normal[np.argmax(np.abs(normal))])
    near = np.round(normal)
    if np.abs(normal - near).max() < FLAT:
        normal = near  # a plane of two axes: coordinates stay as they were written
    along = np.eye(3)[0 if abs(normal[0]) < 0.9 else 1]
    first = along - (along @ normal) * normal
    first /= np.linalg.norm(first)
    plane: Floats = points @ np.column_stack([first, np.cross(normal, first)])
    return plane


def _refuse_folded(points: Floats, edges: Integers, faces: list[Integers], path: Any) -> None:
    """Refuse a folded form that lies on itself; one that is still flat is as good as a crease pattern."""
    size = float(np.ptp(points, axis=0).max()) or 1.0
    if faces:
        shapes = [shapely.make_valid(shapely.Polygon(points[face])) for face in faces]
        lies_on_itself = sum(shape.area for shape in shapes) > shapely.union_all(shapes).area * (1 + 1e-6)
    else:
        used = points[np.unique(edges)]
        lines = shapely.linestrings(points[edges])
        one, other = shapely.STRtree(lines).query(lines, predicate="crosses")
        lies_on_itself = len(np.unique(np.round(used / (FLAT * size)), axis=0)) < len(used) or len(one) > 0
    if lies_on_itself:
        raise GeometryError(
            f"{path} holds a folded form, as its frame_classes say, that lies on itself: give the crease pattern"
        )


def _by_faces(edges: Integers, letters: list[str], faces: list[Integers]) -> list[str]:
    """Letters put right where the facets know better: rims have one facet, cuts two."""
    count: dict[tuple[int, int], int] = {}
    slit: set[tuple[int, int]] = set()
    for face in faces:
        own: set[tuple[int, int]] = set()
        for one, other in _sides(face):
            pair = (min(one, other), max(one, other))
            count[pair] = count.get(pair, 0) + 1
            if pair in own:
                slit.add(pair)  # the facet runs to and fro along it
            own.add(pair)
    result = []
    for (one, other), letter in zip(np.sort(edges, axis=1).tolist(), letters):
        beside = count.get((one, other), 0)
        if (one, other) in slit or (letter == "B" and beside > 1):
            letter = "C"
        elif beside == 1 and letter not in "CB":
            letter = "B"
        result.append(letter)
    return result


def _merged(points: Floats, edges: Integers, letters: list[str], angles: list[float]) -> Pattern:
    """Vertices on one another become one, and edges on one another; two rims on one another are the lips of a cut."""
    size = float(np.ptp(points, axis=0).max()) if len(points) else 1.0
    cells = np.round(points / (SAME * size if size else 1.0))
    _, first, cell = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    target = first[cell.ravel()]
    on_pair: dict[tuple[int, int], list[int]] = {}
    for number, (one, other) in enumerate(np.sort(target[edges], axis=1).tolist()):
        if one != other:
            on_pair.setdefault((one, other), []).append(number)
    kept, result = [], []
    for numbers in on_pair.values():
        found = sorted((letters[number] for number in numbers), key=STRONGEST.index)
        kept.append(numbers[0])
        result.append("C" if found[:2] == ["B", "B"] else found[0])
    pairs = np.array(list(on_pair), dtype=np.int64).reshape(-1, 2)
    return Pattern(points, pairs, result, kept, [angles[number] for number in kept])
