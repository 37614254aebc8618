"""A sheet model as an Abaqus input file, which CalculiX reads as well."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.files import whole_file
from kirigami.io.shell import Shell, checked_targets, shell_of
from kirigami.model.model import Model
from kirigami.primitives.checks import require_choice, require_path, require_whole
from kirigami.primitives.kernel import Array
from kirigami.primitives.laminate import Laminate
from kirigami.primitives.material import Material, Orthotropic, SheetMaterial

NODES_OF = {"S3": 3, "STRI3": 3, "S6": 6, "STRI65": 6}


def to_abaqus(
    model: Model,
    path: str | os.PathLike[str],
    *,
    targets: Sequence[float] = (1.0,),
    increments: int = 20,
    element: str = "S3",
) -> Path:
    """Write the same sheet as a shell model, ready to run in Abaqus or CalculiX.

    Mesh, thickness, material with its layers and directions, stress-free imperfection, supports and dead loads are
    handed over; the elements of `stiffness` are not, since the shell has its own; a sheet that has lost or gained
    elements is refused. There is one static step with large displacements for each target, and before them one for
    what acts at load factor zero. Reactions and displacements of the supports are printed (CalculiX: file .dat),
    displacements of all nodes are stored.

    Parameters
    ----------
    model : Model
        Made by ``Model.from_mesh``, in three dimensions.
    path : path
        The file, by custom ending in .inp.
    targets : sequence of float
        Load factors to reach, one step each.
    increments : int
        First guess of the increments in each step; both programs adapt them.
    element : {"S3", "STRI3", "S6", "STRI65"}
        "S3" is read by both programs. CalculiX turns it into linear wedges, which are far too stiff in bending: choose
        "S6" there, with a node in the middle of each edge; it takes layers on no other triangle. "STRI3" and "STRI65"
        are thin shells of Abaqus.

    Raises
    ------
    ModelError
        The model has no mesh, holds ties, effects or elements beyond the sheet, an orthotropic material or a laminate
        on facets that do not face +z, rubber, a material that yields, or an argument is wrong.
    KirigamiError
        The file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from kirigami.io.abaqus import to_abaqus
    >>> import tempfile, kirigami as kg
    >>> mesh = kg.TriMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9))
    >>> held = m.add(kg.Fix(m.select(boundary="bottom")), kg.Prescribe(m.select(boundary="top"), y=0.1))
    >>> print(to_abaqus(m, Path(tempfile.mkdtemp()) / "square.inp").read_text().splitlines()[1])
    *NODE, NSET=ALL
    """
    target = require_path(path, "path", "to_abaqus")
    require_choice(element, NODES_OF, "element", "to_abaqus")
    increments = require_whole(increments, "increments", "to_abaqus", least=1)
    listed = checked_targets(targets, "to_abaqus")
    shell = shell_of(model, "to_abaqus", (Material, Orthotropic, Laminate))
    _check_sides(shell)
    with whole_file(target) as unfinished, open(unfinished, "w", encoding="ascii", errors="replace") as file:
        file.writelines(line + "\n" for line in _lines(shell, model, listed, increments, element))
    return target


def _lines(shell: Shell, model: Model, targets: list[float], increments: int, element: str) -> Iterator[str]:
    nodes, corners = shell.nodes, shell.triangles
    middles: NDArray[np.int64] = np.empty((0, 2), np.int64)
    if NODES_OF[element] == 6:
        nodes, corners, middles = _with_middles(shell)
    yield f"** {model.name or 'sheet'}: written by kirigami"
    yield "*NODE, NSET=ALL"
    for number, place in enumerate(nodes.tolist(), 1):
        yield f"{number}, {_row(place)}"
    yield f"*ELEMENT, TYPE={element}, ELSET=SHEET"
    for number, facet in enumerate((corners + 1).tolist(), 1):
        yield f"{number}, " + ", ".join(map(str, facet))
    for name, group in shell.sets.items():
        between = np.flatnonzero(np.isin(middles, group).all(axis=1)) + len(shell.nodes)  # they carry reactions, too
        group = np.concatenate([group, between])
        yield f"*NSET, NSET={name.upper()}"
        yield from _wrapped((group + 1).tolist())
    plies = [_plies(material, thickness) for thickness, material, _ in shell.parts]
    materials = list(dict.fromkeys(material for layers in plies for material, _ in layers))
    numbered = ["SHEET"] if len(materials) == 1 else [f"SHEET_{number}" for number in range(len(materials))]
    names = dict(zip(materials, numbered))
    for material, name in names.items():
        yield from _material(material, name)
    for number, (thickness, material, facets) in enumerate(shell.parts):
        part = "SHEET" if len(shell.parts) == 1 else f"PART_{number}"
        if len(shell.parts) > 1:
            yield f"*ELSET, ELSET={part}"
            yield from _wrapped((facets + 1).tolist())
        layers = [(names[ply], _axes_of(ply, names[ply]), height) for ply, height in plies[number]]
        if isinstance(material, Laminate):
            yield f"*SHELL SECTION, ELSET={part}, COMPOSITE"
            yield from (f"{height:.13g}, 3, {', '.join(filter(None, (name, axes)))}" for name, axes, height in layers)
        else:
            name, axes, _ = layers[0]
            yield f"*SHELL SECTION, ELSET={part}, MATERIAL={name}" + (f", ORIENTATION={axes}" if axes else "")
            yield _row([thickness])
    held = dict(shell.held)
    for number, (i, j) in enumerate(middles.tolist(), len(shell.nodes)):
        # A node in the middle of an edge goes along where both ends are held.
        for axis in range(3):
            if (i, axis) in held and (j, axis) in held:
                ends = np.array([held[i, axis], held[j, axis]])
                held[number, axis] = (float(ends[:, 0].mean()), float(ends[:, 1].mean()))
    clamped = shell.clamped.tolist()
    both = np.isin(middles, shell.clamped).all(axis=1) if len(middles) else np.empty(0, bool)
    clamped += (np.flatnonzero(both) + len(shell.nodes)).tolist()
    # What never moves is held for good; what moves is held anew in each step.
    still = [key for key, value in held.items() if value == (0.0, 0.0)]
    moving = [key for key, value in held.items() if value != (0.0, 0.0)]
    if still or clamped:
        yield "*BOUNDARY"
        yield from (f"{node + 1}, {axis + 1}, {axis + 1}" for node, axis in still)
        yield from (f"{node + 1}, 4, 5" for node in clamped)
    factors = ([0.0] if shell.has_constant else []) + targets
    for factor in factors:
        yield f"** load factor {factor:.13g}"
        yield f"*STEP, NLGEOM, INC={max(1000, 100 * increments)}"
        yield "*STATIC"
        yield _row([1.0 / increments, 1.0, 1e-8, 1.0])
        if moving:
            yield "*BOUNDARY"
            for node, axis in moving:
                constant, driven = held[node, axis]
                yield f"{node + 1}, {axis + 1}, {axis + 1}, {constant + factor * driven:.13g}"
        if shell.loads:
            yield "*CLOAD"
            for (node, axis), (constant, driven) in shell.loads.items():
                yield f"{node + 1}, {axis + 1}, {constant + factor * driven:.13g}"
        for name in shell.sets:
            yield f"*NODE PRINT, NSET={name.upper()}, TOTALS=YES, FREQUENCY={1000 * increments}"
            yield "RF"
        yield f"*NODE FILE, FREQUENCY={1000 * increments}"
        yield "U, RF"
        yield "*END STEP"


def _plies(material: SheetMaterial, thickness: float) -> list[tuple[SheetMaterial, float]]:
    """Layers from the lower face to the upper one, none of which has layers."""
    if not isinstance(material, Laminate):
        return [(material, thickness)]
    return [ply for layer in material.layers for ply in _plies(*layer)]


def _axes_of(material: SheetMaterial, name: str) -> str:
    """Name of the directions of a material; none for one that is the same in all of them."""
    return f"AXES_{name}" if isinstance(material, Orthotropic) else ""


def _material(material: Any, name: str) -> Iterator[str]:
    """A material, with its directions where it has such: turned about the normal from the x axis of the drawing."""
    if isinstance(material, Orthotropic):
        along, aside = math.cos(material.angle), math.sin(material.angle)
        yield f"*ORIENTATION, NAME={_axes_of(material, name)}, SYSTEM=RECTANGULAR"
        yield _row([along, aside, 0.0, -aside, along, 0.0])
        yield "3, 0."  # as they lie on the facets
    yield f"*MATERIAL, NAME={name}"
    if isinstance(material, Orthotropic):  # nothing is known of the third direction, and in a thin sheet nothing counts
        yield "*ELASTIC, TYPE=ENGINEERING CONSTANTS"
        E1, E2, G12 = material.E1, material.E2, material.G12
        yield _row([E1, E2, E2, material.nu12, 0.0, 0.0, G12, G12])
        yield _row([G12])
    else:
        yield "*ELASTIC"
        yield _row([material.E, material.nu])
    if material.density is not None:
        yield "*DENSITY"
        yield _row([material.density])


def _check_sides(shell: Shell) -> None:
    """What has directions, or differs from face to face, needs facets that face +z, as angles are counted there."""
    a, b, c = shell.nodes[shell.triangles].transpose(1, 0, 2)
    upright = np.cross(b - a, c - a)[:, 2] > 0
    for _, material, facets in shell.parts:
        if not isinstance(material, Material) and not upright[facets].all():
            first = int(facets[~upright[facets]][0])
            raise ModelError(
                f"to_abaqus cannot hand over {material!r} on facet {first}, which does not face +z: the directions of "
                "its layers would be counted the other way round; turn the model, or list the corners the other way"
            )


def _with_middles(shell: Shell) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
    """Nodes and triangles with a node in the middle of each edge, and the ends of these edges."""
    corners = shell.triangles
    sides = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    ends, which = np.unique(sides, axis=0, return_inverse=True)
    middle = len(shell.nodes) + which.reshape(-1, 3)
    nodes = np.concatenate([shell.nodes, shell.nodes[ends].mean(axis=1)])
    return nodes, np.column_stack([corners, middle]), ends


def _row(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.13g}" for value in values)  # CalculiX reads 20 characters of a number


def _wrapped(numbers: list[int]) -> Iterator[str]:
    for start in range(0, len(numbers), 16):
        yield ", ".join(map(str, numbers[start : start + 16]))
