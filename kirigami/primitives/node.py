"""Nodes, their axes, and lists of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_finite, require_items, require_text, shown

if TYPE_CHECKING:
    from weakref import ReferenceType


class Node:
    """A point of the model, with one displacement unknown per axis.

    Parameters
    ----------
    x, y, z : float
        Coordinates [length].
    name : str, optional
        A label for messages and pictures.

    Raises
    ------
    ModelError
        A coordinate is not a finite number.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Node(1, 2, name="apex")
    Node(1, 2, 0, name='apex')
    """

    __slots__ = ("_owner", "_position", "name")

    def __init__(self, x: float, y: float, z: float = 0.0, *, name: str | None = None) -> None:
        self._position = (
            require_finite(x, "coordinates", "Node"),
            require_finite(y, "coordinates", "Node"),
            require_finite(z, "coordinates", "Node"),
        )
        self.name = None if name is None else require_text(name, "name", "Node")
        self._owner: ReferenceType[Any] | None = None

    def __getstate__(self) -> tuple[dict[str, Any] | None, dict[str, Any]]:
        """A copy of a node belongs to no model yet."""
        slots = [name for cls in type(self).__mro__ for name in getattr(cls, "__slots__", ())]
        return getattr(self, "__dict__", None), {name: getattr(self, name) for name in slots} | {"_owner": None}

    @property
    def model(self) -> Any:
        """The :class:`kirigami.Model` the node was added to, or None."""
        return None if self._owner is None else self._owner()

    # Coordinates are read-only so that a model always knows when its rest state changed: move nodes by Model.perturb.
    @property
    def x(self) -> float:
        """x coordinate in the rest state."""
        return self._position[0]

    @property
    def y(self) -> float:
        """y coordinate in the rest state."""
        return self._position[1]

    @property
    def z(self) -> float:
        """z coordinate in the rest state."""
        return self._position[2]

    def __repr__(self) -> str:
        label = f", name={self.name!r}" if self.name else ""
        x, y, z = self._position
        return f"Node({x:.6g}, {y:.6g}, {z:.6g}{label})"


AXES = "xyz"


def listed(nodes: Node | Iterable[Node], owner: str, once: bool = False) -> tuple[Node, ...]:
    """One node or many as a tuple, never empty, and with `once` none of them twice."""
    group = (nodes,) if isinstance(nodes, Node) else tuple(require_items(nodes, "nodes", owner))
    if not group:
        raise ModelError(f"{owner}: the node selection is empty")
    for node in group:
        if not isinstance(node, Node):
            raise ModelError(f"{owner}: expected nodes, got {shown(node)}; select nodes with Model.select")
    if once and len({id(node) for node in group}) < len(group):
        counts = Counter(map(id, group))
        twice = next(node for node in group if counts[id(node)] > 1)
        raise ModelError(f"{owner}: {twice!r} is listed twice and would count twice: list each node once")
    return group


def vector_of(value: ArrayLike, name: str, owner: str) -> tuple[float, float, float]:
    """A vector of two or three numbers in space."""
    x, y, z = np.append(require_array(value, (2,), (3,), name=name, owner=owner), 0.0)[:3].tolist()
    return x, y, z


def direction_of(axis: str | ArrayLike, owner: str) -> NDArray[np.float64]:
    """Unit vector (3,) of an axis: its letter, or a direction of any length."""
    if isinstance(axis, str):
        if axis not in tuple(AXES):
            raise ModelError(f"{owner}: axis must be 'x', 'y', 'z' or a direction of 3 numbers, got {axis!r}")
        return np.asarray(np.eye(3)[AXES.index(axis)], dtype=float)
    along = require_array(axis, (3,), name="axis", owner=owner)
    if not along.any():
        raise ModelError(f"{owner}: the axis has no direction")
    return np.asarray(along / np.linalg.norm(along))


def place_in_words(place: NDArray[np.float64]) -> str:
    """A place (2,) or (3,) in words, without a height of zero."""
    seen = place if place[2:].any() else place[:2]
    return f"({', '.join(f'{value:.6g}' for value in seen)})"


def require_nodes(owner: str, **nodes: Any) -> None:
    """Each of the arguments is a Node."""
    for name, node in nodes.items():
        if not isinstance(node, Node):
            raise ModelError(f"{owner}: {name} must be a Node, got {shown(node)}")
