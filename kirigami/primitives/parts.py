"""What models are made of: nodes, materials, and the contract of everything that is added to a model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError

if TYPE_CHECKING:
    from kirigami.model.model import Model
    from kirigami.primitives.kernel import Array, Kernel


def require_finite(value: Any, name: str, owner: str) -> float:
    """`value` as a float, or a ModelError that names the argument."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ModelError(f"{owner}: {name} must be a number, got {value!r}") from None
    if not math.isfinite(number):
        raise ModelError(f"{owner}: {name} must be finite, got {number}")
    return number


def require_positive(value: Any, name: str, owner: str) -> float:
    """`value` as a positive float, or a ModelError that names the argument."""
    number = require_finite(value, name, owner)
    if number <= 0:
        raise ModelError(f"{owner}: {name} must be positive, got {number}")
    return number


@dataclass(frozen=True)
class Material:
    """Linear elastic, isotropic material of a sheet.

    Parameters
    ----------
    E : float
        Young's modulus [force / length^2].
    nu : float
        Poisson's ratio, above -1 and below 0.5.
    density : float, optional
        Mass per volume; only where mass or weight matters.

    Raises
    ------
    ModelError
        A value is out of its range or not finite.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Material(E=3.5e9, nu=0.34)
    Material(E=3500000000.0, nu=0.34, density=None)
    """

    E: float
    nu: float = 1 / 3
    density: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "E", require_positive(self.E, "E", "Material"))
        nu = require_finite(self.nu, "nu", "Material")
        if not -1 < nu < 0.5:
            raise ModelError(f"Material: nu must lie between -1 and 0.5, got {nu}")
        object.__setattr__(self, "nu", nu)
        if self.density is not None:
            object.__setattr__(self, "density", require_positive(self.density, "density", "Material"))


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

    __slots__ = ("_position", "name")
    base: Node | None = None  # the node whose normal this one is the tip of (see kirigami.geometry.normals)

    def __init__(self, x: float, y: float, z: float = 0.0, *, name: str | None = None) -> None:
        try:
            position = (float(x), float(y), float(z))
        except (TypeError, ValueError):
            raise ModelError(f"Node: coordinates must be numbers, got ({x!r}, {y!r}, {z!r})") from None
        if not all(map(math.isfinite, position)):
            raise ModelError(f"Node: coordinates must be finite, got {position}")
        self._position = position
        self.name = name

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


class ModelObject:
    """Base of everything a model holds beside its nodes. ``kind`` says on which list it goes."""

    __slots__ = ()
    kind: ClassVar[str] = "element"  # "element", "constraint", "load" or "effect"

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Every node the object touches."""
        raise NotImplementedError

    @classmethod
    def lower(cls, objects: Sequence[Any], numbering: Numbering) -> list[Kernel]:
        """Turn all objects of this class, at once, into kernels."""
        raise NotImplementedError


class Numbering:
    """What lowering needs to know of a model: node indices, rest positions (n, dim), size."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.dim = model.dim
        self.rest: Array = model.positions()[:, : model.dim].copy()
        self.size = float(np.linalg.norm(np.ptp(self.rest, axis=0))) or 1.0

    def index(self, nodes: Iterable[Node]) -> NDArray[np.int64]:
        index = self.model._index
        return np.array([index[id(node)] for node in nodes], dtype=np.int64)

    def connectivity(self, objects: Sequence[ModelObject]) -> NDArray[np.int64]:
        """Node indices (n, k) of objects that all have k nodes."""
        return self.index(node for item in objects for node in item.nodes).reshape(len(objects), -1)

    def describe(self, node: Node) -> str:
        return f"node {self.model._index[id(node)]} {node!r}"
