"""A group of nodes that turns about an axis like a rigid body, through any angle: a constraint that follows an arc."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.errors import ModelError
from kirigami.model.constraints import Constraint
from kirigami.primitives.checks import require_boolean, require_finite
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES, Node, direction_of, listed, vector_of
from kirigami.words import counted

MOST = 36000.0  # degrees


class Turn(Constraint):
    """Turns nodes about an axis with the load factor, as one rigid body and through any angle, and shifts them.

    At load factor L a node that is an arm r away from the point `about` is displaced by R(L angle) r - r + L shift,
    with the rotation R about the axis (Rodrigues). Linear analyses take the rate of it at rest.

    Parameters
    ----------
    nodes : Node or sequence of Node
        The nodes to turn.
    angle : float
        At load factor 1 [degrees], right-handed about the axis; of any size.
    axis : {"x", "y", "z"} or array_like, shape (3,)
        Direction of the axis.
    about : array_like, shape (2,) or (3,), optional
        A point on the axis [length]; None takes the middle of the nodes at rest.
    shift : array_like, shape (2,) or (3,)
        Displacement of that point at load factor 1 [length].
    clamp : bool
        As for :class:`Fix`: the sheet keeps its direction against the nodes.
    constant : bool
        Holds the nodes turned and shifted whatever the load factor, as after an earlier stage.

    Raises
    ------
    ModelError
        Empty selection, no axis, numbers that are not finite; in a run an axis other than z in a model with dim=2, an
        ArcLength, or on "plate" and "facet" a clamped edge that is turned about itself or right round.

    Examples
    --------
    >>> import kirigami as kg
    >>> turn = kg.Turn([kg.Node(1, 0), kg.Node(-1, 0)], angle=90, axis="z")
    >>> turn.values["y"].round(12).tolist()
    [1.0, -1.0]
    """

    __slots__ = ("about", "angle", "axis", "shift")

    about: Array
    angle: float
    axis: Array
    shift: Array

    def __init__(
        self,
        nodes: Node | Iterable[Node],
        angle: float,
        axis: str | ArrayLike = "z",
        about: ArrayLike | None = None,
        shift: ArrayLike = (0.0, 0.0, 0.0),
        clamp: bool = False,
        constant: bool = False,
    ) -> None:
        group = listed(nodes, "Turn")
        angle = require_finite(angle, "angle", "Turn")
        if abs(angle) > MOST:
            raise ModelError(
                f"Turn: an angle of {counted(angle, 'degree', spec='.6g')} is more than {MOST / 360:g} turns"
            )
        along = direction_of(axis, "Turn")
        points = np.array([(node.x, node.y, node.z) for node in group])
        centre = points.mean(axis=0) if about is None else np.array(vector_of(about, "about", "Turn"))
        moved = np.array(vector_of(shift, "shift", "Turn"))
        parts = {"about": centre, "angle": angle, "axis": along, "shift": moved}
        for name, value in parts.items():
            object.__setattr__(self, name, value)
        there = turned(points - centre, along, np.radians(angle)) - (points - centre) + moved
        Constraint.__init__(
            self,
            group,
            {letter: there[:, number].copy() for number, letter in enumerate(AXES)},
            constant=require_boolean(constant, "constant", "Turn"),
            clamp=require_boolean(clamp, "clamp", "Turn"),
        )

    @property
    def rotation(self) -> Array:
        """Rotation vector (3,) at load factor 1 [rad]."""
        vector: Array = np.radians(self.angle) * self.axis
        return vector

    @property
    def drives(self) -> bool:
        return not self.constant

    def held(self, lam: float) -> Turn:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "Turn.held")
        if self.constant:
            return self
        return Turn(
            self.group, lam * self.angle, self.axis, self.about, lam * self.shift, clamp=self.clamp, constant=True
        )

    def __repr__(self) -> str:
        axis = ", ".join(f"{part:.4g}" for part in self.axis)
        return f"Turn({counted(len(self.group), 'node')}, {counted(self.angle, 'degree', spec='.6g')} about ({axis}))"


class Arc:
    """Arms that turn with the load factor: what a :class:`Turn` drives beyond its rate at rest.

    Parameters
    ----------
    numbers : ndarray of int, shape (k, dim)
        Numbers of the displacements driven.
    arms : ndarray, shape (k, 3)
        From the axis to what is turned, at rest.
    rotation : ndarray, shape (3,)
        Rotation vector at load factor 1 [rad].
    position : int
        Of the support among the constraints.
    """

    def __init__(self, numbers: Any, arms: Array, rotation: Array, position: int = -1) -> None:
        self.numbers, self.arms, self.angle = numbers, arms, float(np.linalg.norm(rotation))
        self.position = position
        self.axis = rotation / (self.angle or 1.0)
        self._dim = numbers.shape[1]
        self._start = np.cross(rotation, arms)

    @property
    def start(self) -> Array:
        """Rate (k, dim) with the load factor at rest."""
        return self._start[:, : self._dim]

    def beyond(self, lam: float) -> Array:
        """Displacement (k, dim) less that of the rate at rest."""
        there: Array = turned(self.arms, self.axis, lam * self.angle) - self.arms - lam * self._start
        return there[:, : self._dim]

    def rate_beyond(self, lam: float) -> Array:
        """Its change (k, dim) with the load factor."""
        rate: Array = turned(self._start, self.axis, lam * self.angle) - self._start
        return rate[:, : self._dim]


def turned(arms: Array, axis: Array, angle: float) -> Array:
    """Vectors (k, 3) turned about a unit axis by an angle [rad]."""
    along = np.outer(arms @ axis, axis)
    flat: Array = along + np.cos(angle) * (arms - along) + np.sin(angle) * np.cross(axis, arms)
    return flat
