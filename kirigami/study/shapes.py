"""Which deformed shapes are the same, up to reflections of the structure and the side they buckle to."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kirigami.model.model import Model
from kirigami.primitives.groups import first_of_group
from kirigami.primitives.kernel import Array

FLAT = 1e-6  # height over size below which a sheet counts as flat


class ShapeSpace:
    """Compares displacement fields of one structure.

    A field of a flat sheet is its out-of-plane displacement, up to sign; of any other structure, all displacements.
    Reflections across the planes through the middle of the structure are tried as well. Meshes need not be symmetric:
    on a sheet the reflected field is interpolated from the facet whose centre is nearest; elsewhere it is taken from
    the nearest node.
    """

    def __init__(self, model: Model, mirrors: str = "xy") -> None:
        from scipy.spatial import cKDTree

        rest, mesh, dim = model.positions(), model.mesh, model.dim
        self._triangles = None if mesh is None else mesh.triangles
        low, high = rest.min(axis=0), rest.max(axis=0)
        size = float(np.linalg.norm(high - low))
        self.flat = dim == 3 and mesh is not None and bool(high[2] - low[2] <= FLAT * size)
        places = rest if self._triangles is None else rest[self._triangles].mean(axis=1)
        self.weight = np.ones(len(places)) if mesh is None else mesh.facet_areas / mesh.facet_areas.sum()
        self._tree = cKDTree(places[:, :2] if self.flat else places)
        self._maps: list[Callable[[Array], Array]] = []
        axes = ["xyz".index(axis) for axis in mirrors if "xyz".index(axis) < (2 if self.flat else dim)]
        for chosen in range(2 ** len(axes)):
            flipped = [axis for bit, axis in enumerate(axes) if chosen >> bit & 1]
            self._maps.append(self._reflection(rest, places, flipped, 0.5 * (low + high)))

    def _reflection(self, rest: Array, places: Array, axes: list[int], middle: Array) -> Callable[[Array], Array]:
        """A function from nodal fields (n, k) to values at the places (p, k) of the reflected field."""
        image = places.copy()
        image[:, axes] = 2 * middle[axes] - image[:, axes]
        nearest = self._tree.query(image[:, :2] if self.flat else image)[1]
        sign = np.ones(3)
        sign[axes] = -1.0
        if self._triangles is None:
            return lambda field: field[nearest] * sign[: field.shape[1]]
        corners = self._triangles[nearest]
        shares = _barycentric(rest[corners][:, :, :2], image[:, :2])
        factor = np.ones(1) if self.flat else sign

        def reflected(field: Array) -> Array:
            values: Array = np.einsum("pc,pck->pk", shares, field[corners]) * factor
            return values

        return reflected

    def field(self, u: Array) -> Array:
        """The nodal field (n, k) of displacements `u` (n, 3) that is compared."""
        return u[:, 2:] if self.flat else u

    def distance(self, one: Array, other: Array) -> float:
        """Relative distance of two displacement fields (n, 3), the least over all reflections and signs."""
        a, b = self.field(one), self.field(other)
        mine = self._maps[0](a)
        size = max(self._norm(mine), self._norm(self._maps[0](b)))
        if size == 0:
            return 0.0
        signs = (1.0, -1.0) if self.flat else (1.0,)
        return min(self._norm(mine - sign * reflect(b)) for reflect in self._maps for sign in signs) / size

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
