"""Rigid surfaces for contact: plane, cylinder and sphere, at rest or moving."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_finite, require_instance, require_positive
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import direction_of, vector_of
from kirigami.words import counted


def _direction(value: ArrayLike, name: str, owner: str) -> tuple[float, float, float]:
    vector = np.array(vector_of(value, name, owner))
    length = float(np.linalg.norm(vector))
    if length == 0:
        raise ModelError(f"{owner}: {name} must not be zero")
    x, y, z = (vector / length).tolist()
    return x, y, z


class Surface:
    """Base of rigid surfaces: what contact knows of them."""

    moves = False  # whether it does, with the load factor

    def _shape(self) -> tuple[Array, Array, Array, float]:
        """Point (3,), normal (3,) or zeros, projector on what counts for the distance (3, 3), radius."""
        raise NotImplementedError

    def _shape_in(self, dim: int) -> tuple[Array, Array, Array, float]:
        """The same in a model with so many axes, where it must be a line or circle if there are two."""
        point, normal, projector, radius = self._shape()
        even = np.diag([projector[0, 0], projector[0, 0], projector[2, 2]])
        if dim == 2 and (normal[2] != 0 or np.any(projector != even)):
            raise ModelError(f"Contact: {self} is no line or circle in the plane of a model with dim=2")
        return point[:dim], normal[:dim], projector[:dim, :dim], radius


@dataclass(frozen=True, init=False)
class Plane(Surface):
    """A rigid plane; bodies stay on the side of its normal.

    Parameters
    ----------
    point : array_like, shape (2,) or (3,)
        A point of the plane [length].
    normal : array_like, shape (2,) or (3,)
        Normal towards the bodies; any length.

    Raises
    ------
    ModelError
        A vector that is not finite, or a normal of no length.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Plane((0, 0, -1), normal=(0, 0, 2))
    Plane(point=(0.0, 0.0, -1.0), normal=(0.0, 0.0, 1.0))
    """

    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    def __init__(self, point: ArrayLike = (0, 0, 0), normal: ArrayLike = (0, 0, 1)) -> None:
        object.__setattr__(self, "point", vector_of(point, "point", "Plane"))
        object.__setattr__(self, "normal", _direction(normal, "normal", "Plane"))

    def _shape(self) -> tuple[Array, Array, Array, float]:
        """Point, normal, zeros, zero."""
        return np.array(self.point), np.array(self.normal), np.zeros((3, 3)), 0.0


@dataclass(frozen=True, init=False)
class Cylinder(Surface):
    """A rigid cylinder without ends; bodies stay outside.

    Parameters
    ----------
    point : array_like, shape (2,) or (3,)
        A point of the axis [length].
    axis : array_like, shape (3,)
        Direction of the axis; any length. In a model with dim=2 only (0, 0, 1).
    radius : float
        Radius [length].

    Raises
    ------
    ModelError
        A vector that is not finite, an axis of no length, a radius that is not positive.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Cylinder((0, 0, -2), axis=(0, 3, 0), radius=2)
    Cylinder(point=(0.0, 0.0, -2.0), axis=(0.0, 1.0, 0.0), radius=2.0)
    """

    point: tuple[float, float, float]
    axis: tuple[float, float, float]
    radius: float

    def __init__(self, point: ArrayLike, axis: ArrayLike, radius: float) -> None:
        object.__setattr__(self, "point", vector_of(point, "point", "Cylinder"))
        object.__setattr__(self, "axis", _direction(axis, "axis", "Cylinder"))
        object.__setattr__(self, "radius", require_positive(radius, "radius", "Cylinder"))

    def _shape(self) -> tuple[Array, Array, Array, float]:
        """Point of the axis, zeros, projector across the axis, radius."""
        return np.array(self.point), np.zeros(3), np.eye(3) - np.outer(self.axis, self.axis), self.radius


@dataclass(frozen=True, init=False)
class Sphere(Surface):
    """A rigid sphere, in a model with dim=2 a circle; bodies stay outside.

    Parameters
    ----------
    center : array_like, shape (2,) or (3,)
        Centre [length].
    radius : float
        Radius [length].

    Raises
    ------
    ModelError
        A centre that is not finite, a radius that is not positive.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Sphere((0, 0, -2), radius=2)
    Sphere(center=(0.0, 0.0, -2.0), radius=2.0)
    """

    center: tuple[float, float, float]
    radius: float

    def __init__(self, center: ArrayLike, radius: float) -> None:
        object.__setattr__(self, "center", vector_of(center, "center", "Sphere"))
        object.__setattr__(self, "radius", require_positive(radius, "radius", "Sphere"))

    def _shape(self) -> tuple[Array, Array, Array, float]:
        """Centre, zeros, the unit matrix, radius."""
        return np.array(self.center), np.zeros(3), np.eye(3), self.radius


@dataclass(frozen=True, init=False)
class Moving(Surface):
    """A rigid surface that is shifted and turned with the load factor, for :class:`Contact`.

    It needs no load beside it. Nodes that stick to it are carried along; those that slide are pulled by friction along
    the way that it goes beneath them.

    Parameters
    ----------
    surface : Plane, Cylinder or Sphere
        The surface where it is at load factor 0.
    shift : array_like, shape (2,), (3,), (k, 2) or (k, 3)
        Displacement at load factor 1, or at each of the load factors `at` [length].
    angle : float or array_like, shape (k,)
        Turn about the axis at load factor 1, or at each of `at` [degrees], right-handed; of any size.
    axis : {"x", "y", "z"} or array_like, shape (3,)
        Direction of the axis; in a model with dim=2 only z.
    about : array_like, shape (2,) or (3,), optional
        A point on the axis [length], which is shifted with the surface; None takes the surface's own point or centre.
    at : array_like, shape (k,), optional
        Positive load factors in rising order, for a surface that does one thing after another: straight between them,
        from nothing at load factor 0, and at rest beyond the last one. None goes on in proportion to the load factor.

    Raises
    ------
    ModelError
        Values that are not finite or do not fit each other, an axis of no length, load factors that do not rise, or a
        surface that does not move; in a run an axis other than z in a model with dim=2.

    Examples
    --------
    A block of two nodes is pressed on a belt by 2. Two springs of 5 hold it: the belt carries it along, and slides
    beneath it from where they pull by 0.3 times 2.

    >>> import numpy as np, kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=1e3), kg.Spring([a, b], (5.0, 1e-3)))
    >>> press = m.add(kg.NodalLoad([a, b], (0, -1), constant=True))
    >>> belt = kg.Moving(kg.Plane((0, 0), (0, 1)), shift=(0.2, 0))
    >>> touch = m.add(kg.Contact([a, b], belt, friction=0.3, stiffness=1e4, layer=1e-4))
    >>> res = kg.LoadControl(m, targets=np.linspace(0.05, 1, 20)).run()
    >>> [round(5 * float(res[res.nearest(lam)].u[:, 0].sum()), 2) for lam in (0.1, 0.2, 1.0)]
    [0.2, 0.4, 0.6]
    """

    surface: Plane | Cylinder | Sphere
    shift: tuple[tuple[float, ...], ...]
    angle: tuple[float, ...]
    axis: tuple[float, float, float]
    about: tuple[float, float, float]
    at: tuple[float, ...] | None
    reached: float | None

    def __init__(
        self,
        surface: Plane | Cylinder | Sphere,
        shift: ArrayLike = (0.0, 0.0, 0.0),
        angle: ArrayLike = 0.0,
        axis: str | ArrayLike = "z",
        about: ArrayLike | None = None,
        at: ArrayLike | None = None,
    ) -> None:
        put = object.__setattr__
        put(self, "surface", require_instance(surface, (Plane, Cylinder, Sphere), "surface", "Moving"))
        factors = None if at is None else require_array(at, (None,), name="at", owner="Moving")
        if factors is not None and not (np.diff(factors, prepend=0.0) > 0).all():
            raise ModelError(f"Moving: the load factors at must be positive and rise, got {at!r}")
        count = 1 if factors is None else len(factors)
        way = require_array(shift, (2,), (3,), (count, 2), (count, 3), name="shift", owner="Moving")
        put(self, "shift", tuple(tuple(row.tolist()) for row in _three(np.broadcast_to(way, (count, way.shape[-1])))))
        turns = require_array(angle, (), (count,), name="angle", owner="Moving")
        put(self, "angle", tuple(np.broadcast_to(turns, (count,)).tolist()))
        put(self, "at", None if factors is None else tuple(factors.tolist()))
        put(self, "axis", tuple(direction_of(axis, "Moving").tolist()))
        own = surface.center if isinstance(surface, Sphere) else surface.point
        put(self, "about", own if about is None else vector_of(about, "about", "Moving"))
        put(self, "reached", None)
        if not np.any(self.shift) and not any(self.angle):
            raise ModelError(f"Moving: {surface} does not move: give a shift or an angle, or the surface itself")

    moves = True

    def _shape(self) -> tuple[Array, Array, Array, float]:
        """That of the surface which moves, where it is at load factor 0."""
        return self.surface._shape()

    def held(self, lam: float) -> Moving:
        """The same, standing where it is at load factor `lam`."""
        if self.reached is not None:
            return self
        stands = copy(self)
        object.__setattr__(stands, "reached", require_finite(lam, "lam", "Moving.held"))
        return stands

    def __repr__(self) -> str:
        way = ", ".join(f"{part:.4g}" for part in self.shift[-1])
        turn = f", turned by {counted(self.angle[-1], 'degree', spec='.4g')}" if any(self.angle) else ""
        return f"Moving({self.surface}, shifted by ({way}){turn})"


def _three(vectors: Array) -> Array:
    """Vectors of two or three numbers in space."""
    return np.concatenate([vectors, np.zeros((*vectors.shape[:-1], 1))], axis=-1)[..., :3]
