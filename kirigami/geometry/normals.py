"""The sheet's normal at a node, as a point: what lets a facet with curved edges bend without rotational unknowns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.geometry.mesh import TriMesh
from kirigami.primitives.checks import require_positive
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import Node

Index = NDArray[np.int64]


class Normal(Node):
    """Tip of the sheet's normal at a node; its displacement against the node's is how the normal turns.

    Only the direction from the node to the tip enters the mechanics. The tip is a node of the model like any other,
    so normals are held, tied and stored like nodes; selections and imperfections leave normals to their nodes.

    Parameters
    ----------
    base : Node
        The node the normal stands on.
    direction : sequence of 3 floats
        Direction of the normal in the rest state, of any length.
    length : float
        Distance of the tip from the node [length]; half the thickness puts it on the upper face of the sheet.

    Raises
    ------
    ModelError
        A direction of no length, or a length that is not positive.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Normal(kg.Node(1, 2), (0, 0, 2), length=0.5).z
    0.5
    """

    __slots__ = ("base", "length")
    base: Node
    length: float

    def __init__(self, base: Node, direction: Sequence[float] = (0.0, 0.0, 1.0), length: float = 1.0) -> None:
        if not isinstance(base, Node):
            raise ModelError(f"Normal: base must be a Node, got {base!r}")
        self.base = base
        self.length = require_positive(length, "length", "Normal")
        vector = np.asarray(direction, dtype=float)
        size = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
        if not (np.isfinite(size) and size > 0):
            raise ModelError(f"Normal: direction must hold three finite numbers, not all zero, got {direction!r}")
        super().__init__(*(np.array(base._position) + self.length * vector / size).tolist())

    def __repr__(self) -> str:
        return f"Normal of {self.base!r}"


def sheet_normals(points: Array, triangles: Index) -> Array:
    """Unit normals (n, 3) of a triangulated sheet at its nodes: the area-weighted mean of the facets around."""
    corners = points[triangles]
    facet = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(points)
    for corner in range(3):
        np.add.at(total, triangles[:, corner], facet)
    return np.asarray(total / np.linalg.norm(total, axis=1)[:, None])


def moved_tips(base: Index, tip: Index, before: Array, after: Array, mesh: TriMesh | None) -> Array:
    """Rest positions (number of normals, 3) of the tips once the nodes have moved from `before` to `after`.

    On a mesh the normals follow the surface; without one they move along with their nodes.
    """
    arm = before[tip] - before[base]
    if mesh is not None:
        normals = sheet_normals(after[: len(mesh.nodes)], mesh.triangles)
        arm = normals[base] * np.linalg.norm(arm, axis=1)[:, None]
    return np.asarray(after[base] + arm)
