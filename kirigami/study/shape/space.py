"""Which deformed shapes are the same, up to reflections of the structure and the side they buckle to."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kirigami.model.model import Model
from kirigami.primitives.groups import first_of_group
from kirigami.primitives.kernel import Array

FLAT = 1e-6  # height over size below which a sheet counts as flat
IMPERFECT = 0.01  # the same of the rest state of a sheet that was drawn flat


def is_flat_sheet(model: Model) -> bool:
    """Whether a model is a sheet that was drawn flat, with an imperfection or without: it buckles to either side."""
    if model.dim == 2 or model.mesh is None:
        return False
    heights, size = model.mesh.nodes[:, 2:], model.mesh.size
    drawn = float(np.ptp(heights)) if heights.size else 0.0
    return drawn <= FLAT * size and float(np.ptp(model.positions()[:, 2])) <= IMPERFECT * size


class Reflections:
    """Fields of a structure, reflected across the planes through its middle: one map for each choice of planes.

    On a sheet a reflected field is interpolated from the facet whose centre is nearest, so that its mesh need not be
    symmetric; elsewhere it is taken from the nearest node.

    Attributes
    ----------
    maps : list of callable
        From nodal fields (n, k) to values (p, k) at the places of the reflected field; the first one reflects nothing.
    axes : list of list of int
        Which axes each map reflects.
    flat : bool
        Whether the structure is a flat sheet: heights are no component that a reflection turns round then.
    """

    def __init__(self, model: Model, mirrors: str, places: Array) -> None:
        from scipy.spatial import cKDTree

        rest, mesh, dim = model.positions(), model.mesh, model.dim
        self._triangles = None if mesh is None else mesh.triangles
        low, high = rest.min(axis=0), rest.max(axis=0)
        self.flat = is_flat_sheet(model)
        known = rest if self._triangles is None else rest[self._triangles].mean(axis=1)
        self._tree = cKDTree(known[:, :2] if self.flat else known)
        axes = ["xyz".index(axis) for axis in mirrors if "xyz".index(axis) < (2 if self.flat else dim)]
        self.axes = [[axis for bit, axis in enumerate(axes) if chosen >> bit & 1] for chosen in range(2 ** len(axes))]
        self.maps = [self._reflection(rest, places, flipped, 0.5 * (low + high)) for flipped in self.axes]

    def _reflection(self, rest: Array, places: Array, axes: list[int], middle: Array) -> Callable[[Array], Array]:
        image = places.copy()
        image[:, axes] = 2 * middle[axes] - image[:, axes]
        nearest = self._tree.query(image[:, :2] if self.flat else image)[1]
        sign = np.ones(3)
        sign[axes] = -1.0
        if self._triangles is None:
            return lambda field: field[nearest] * sign[: field.shape[1]]
        corners = self._triangles[nearest]
        shares = _barycentric(rest[corners][:, :, :2], image[:, :2])

        def reflected(field: Array) -> Array:
            factor = np.ones(1) if field.shape[1] == 1 else sign  # heights alone are turned round by no reflection
            values: Array = np.einsum("pc,pck->pk", shares, field[corners]) * factor
            return values

        return reflected


class ShapeSpace:
    """Compares displacement fields of one structure.

    A field of a flat sheet is its out-of-plane displacement, up to sign; of any other structure, all displacements.
    Reflections across the planes through the middle of the structure are tried as well. Meshes need not be symmetric:
    on a sheet the reflected field is interpolated from the facet whose centre is nearest; elsewhere it is taken from
    the nearest node.
    """

    def __init__(self, model: Model, mirrors: str = "xy") -> None:
        rest, mesh = model.positions(), model.mesh
        places = rest if mesh is None else rest[mesh.triangles].mean(axis=1)
        self._reflections = Reflections(model, mirrors, places)
        self.flat = self._reflections.flat
        self.weight = np.ones(len(places)) if mesh is None else mesh.facet_areas / mesh.facet_areas.sum()

    def field(self, u: Array) -> Array:
        """The nodal field (n, k) of displacements `u` (n, 3) that is compared."""
        return u[:, 2:] if self.flat else u

    def distance(self, one: Array, other: Array) -> float:
        """Relative distance of two displacement fields (n, 3), the least over all reflections and signs."""
        a, b = self.field(one), self.field(other)
        maps = self._reflections.maps
        mine = maps[0](a)
        size = max(self._norm(mine), self._norm(maps[0](b)))
        if size == 0:
            return 0.0
        signs = (1.0, -1.0) if self.flat else (1.0,)
        return min(self._norm(mine - sign * reflect(b)) for reflect in maps for sign in signs) / size

    def sizes(self, u: Array) -> Array:
        """What is compared (p, k), at the places where it is; of a flat sheet heights without their sign."""
        there = self._reflections.maps[0](self.field(u))
        return np.abs(there) if self.flat else there

    def _norm(self, values: Array) -> float:
        return float(np.sqrt((self.weight[:, None] * values**2).sum()))

    def clusters(self, fields: list[Array], alike: float) -> NDArray[np.int64]:
        """Number of the cluster of each field: a chain of neighbours nearer than `alike` is one cluster."""
        near = [
            (i, j) for i in range(len(fields)) for j in range(i) if self.distance(fields[i], fields[j]) < alike
        ]
        first = first_of_group(len(fields), np.array(near, dtype=np.int64).reshape(-1, 2))
        return np.unique(first, return_inverse=True)[1].astype(np.int64)


def _barycentric(corners: Array, points: Array) -> Array:
    """Shares (p, 3) of the corners (p, 3, 2) in points (p, 2); outside a triangle they go on linearly."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    off = points - corners[:, 0]
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    a = (off[:, 0] * second[:, 1] - off[:, 1] * second[:, 0]) / area
    b = (first[:, 0] * off[:, 1] - first[:, 1] * off[:, 0]) / area
    return np.column_stack([1 - a - b, a, b])
