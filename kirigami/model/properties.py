"""Thickness and material facet by facet: given for the sheet, for each facet, by named region or by place."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.elements.triangle import warn_of_jumps
from kirigami.errors import ModelError
from kirigami.geometry.mesh import TriMesh
from kirigami.primitives.checks import (
    require_array,
    require_callable,
    require_instance,
    require_items,
    require_positive,
)
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import SheetMaterial
from kirigami.words import counted

Index = NDArray[np.int64]

Thickness = ArrayLike | Mapping[Any, float] | Callable[[Array, Array, Array], ArrayLike] | None
Materials = (
    SheetMaterial
    | Sequence[SheetMaterial]
    | Mapping[Any, SheetMaterial]
    | Callable[[Array, Array, Array], Sequence[SheetMaterial]]
    | None
)


def facet_properties(
    mesh: TriMesh, thickness: Thickness, material: Materials, owner: str
) -> tuple[float | Array, SheetMaterial | tuple[SheetMaterial, ...]]:
    """Thickness and material of a sheet: one where all facets have the same, else those of each facet (m,).

    Raises
    ------
    ModelError
        Something missing or out of range, a region that the mesh does not have, regions that overlap.

    Warns
    -----
    KirigamiWarning
        Neighbours of which one is more than a hundred times as thick as the other.
    """
    number, materials = _materials(mesh, material, owner)
    heights = _thickness(mesh, thickness, owner, number, materials)
    one = float(heights[0]) if np.ptp(heights) == 0 else heights
    if len(materials) == 1:
        return one, materials[0]
    return one, tuple(materials[k] for k in number.tolist())


def _materials(mesh: TriMesh, given: Materials, owner: str) -> tuple[Index, list[SheetMaterial]]:
    """Number of the material of each facet, and the materials that there are."""
    count = len(mesh.triangles)
    if given is None:
        given = mesh.material
    if given is None:
        raise ModelError(f"{owner}: no material: give it here or to the Sheet the mesh is made from")
    listed: list[Any]
    if isinstance(given, Mapping):
        listed = [mesh.material] * count
        for name, facets in _by_region(mesh, given, "material", owner):
            for facet in facets.tolist():
                listed[facet] = given[name]
    elif isinstance(given, SheetMaterial):
        listed = [given]
    else:
        found = require_callable(given, "material", owner)(*_centres(mesh)) if callable(given) else given
        if isinstance(found, (str, bytes)) or not isinstance(found, (Sequence, np.ndarray)):
            require_instance(found, SheetMaterial, "material", owner)
        listed = require_items(found, "material", owner)
        if len(listed) != count:
            raise ModelError(
                f"{owner}: {counted(len(listed), 'material')} for the {counted(count, 'facet')} of the mesh: give one "
                "for each"
            )
    for facet, item in enumerate(listed):
        if item is None:
            raise ModelError(
                f"{owner}: no material for facet {facet} {_at(mesh, facet)}, which is in no region that has one: give "
                "one under the name None, or to the Sheet"
            )
        require_instance(item, SheetMaterial, "material", owner)
    known = {item: k for k, item in enumerate(dict.fromkeys(listed))}
    return np.array([known[item] for item in listed] if len(listed) == count else [0] * count), list(known)


def _thickness(
    mesh: TriMesh, given: Thickness, owner: str, number: Index, materials: list[SheetMaterial]
) -> Array:
    """Thickness (m,) of each facet; laminates have one of their own."""
    count = len(mesh.triangles)
    heights = np.full(count, np.nan)
    elsewhere = mesh.thickness if given is None else None
    if isinstance(given, Mapping):
        elsewhere = mesh.thickness
        for name, facets in _by_region(mesh, given, "thickness", owner):
            value = require_positive(given[name], f"thickness of region {name!r}" if name else "thickness", owner)
            if name is None:
                elsewhere = value
            else:
                heights[facets] = value
    elif callable(given):
        found = given(*_centres(mesh))
        heights[:] = require_array(found, (), (count,), name="what thickness() gives", owner=owner)
    elif given is not None:
        heights[:] = require_array(given, (), (count,), name="thickness", owner=owner)
    for position, material in enumerate(materials):
        own = material.checked_thickness(None, owner)
        if own is not None:
            at = number == position
            for value in np.unique(heights[at & ~np.isnan(heights)]).tolist():
                material.checked_thickness(value, owner)
            heights[at] = own
    if elsewhere is not None:
        heights[np.isnan(heights)] = elsewhere
    missing = np.flatnonzero(np.isnan(heights))
    if missing.size:
        where = "" if given is None else f" for facet {missing[0]} {_at(mesh, int(missing[0]))}"
        raise ModelError(f"{owner}: no thickness{where}: give it here or to the Sheet the mesh is made from")
    worst = int(np.argmin(heights))
    if heights[worst] <= 0:
        where = f" of facet {worst} {_at(mesh, worst)}" if np.ptp(heights) else ""
        require_positive(float(heights[worst]), f"thickness{where}", owner)
    for position, material in enumerate(materials):
        stiffest = float(heights[number == position].max(initial=0.0))
        with np.errstate(over="ignore", invalid="ignore"):
            if stiffest and not np.isfinite(material.section(stiffest)).all():
                raise ModelError(f"{owner}: the bending stiffness of thickness {stiffest:g} overflows")
    warn_of_jumps(owner, mesh.triangles, heights, mesh.nodes, stacklevel=5)
    return heights


def _by_region(mesh: TriMesh, given: Mapping[Any, Any], what: str, owner: str) -> list[tuple[Any, Index]]:
    """Facets of the regions named, and behind None those in none of them, first."""
    if not given:
        raise ModelError(f"{owner}: {what} must be given for a region at least, got an empty mapping")
    taken = np.full(len(mesh.triangles), -1)
    names = [name for name in given if name is not None]
    found: list[tuple[Any, Index]] = []
    for position, name in enumerate(names):
        if name not in mesh.regions:
            known = ", ".join(map(repr, mesh.regions)) or "none"
            raise ModelError(
                f"{owner}: {what} is given for a region {name!r}, which the mesh does not have (there are: {known}); "
                "name regions in Sheet(regions=) or TriMesh(regions=)"
            )
        facets = mesh.regions[name]
        twice = facets[taken[facets] >= 0]
        if twice.size:
            other = names[int(taken[twice[0]])]
            raise ModelError(
                f"{owner}: regions {other!r} and {name!r} overlap at facet {twice[0]} {_at(mesh, int(twice[0]))}: "
                f"each facet has one {what}"
            )
        taken[facets] = position
        found.append((name, facets))
    return [(None, np.flatnonzero(taken < 0)), *found] if None in given else found


def _centres(mesh: TriMesh) -> Array:
    """Coordinates (3, m) of the centres of the facets."""
    return np.asarray(mesh.nodes[mesh.triangles].mean(axis=1).T)


def _at(mesh: TriMesh, facet: int) -> str:
    x, y, z = _centres(mesh)[:, facet].tolist()
    return f"at ({x:.6g}, {y:.6g})" if z == 0 else f"at ({x:.6g}, {y:.6g}, {z:.6g})"
