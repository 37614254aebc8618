"""Rigid bodies of nodes: grips that are moved and turned, and links that hold nodes together.

A grip is no stiff spring: its nodes are eliminated. What stays are the displacement c of their centroid and a rotation
vector theta about it, x = x_0 + c + (R(theta) - 1) (X - X_0), each component of c and theta held, driven or free.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.geometry.topology import edges_within
from kirigami.model.constraints import Constraint
from kirigami.primitives.checks import require_boolean, require_finite, require_items, shown
from kirigami.primitives.grip_rows import GripRows
from kirigami.primitives.kernel import Array, Kernel
from kirigami.primitives.node import AXES, Node, listed
from kirigami.primitives.parts import Numbering
from kirigami.words import counted

Motion = tuple[float | None, float | None, float | None]
STRAIGHT = 1e-9  # width of a set of nodes over its length, below which it is a line


def _motion(values: Any, name: str, owner: str) -> Motion:
    items = tuple(require_items(values, name, owner))
    if len(items) != 3:
        raise ModelError(f"{owner}: {name} must hold three values, one for each axis, got {shown(values)}")
    x, y, z = (None if value is None else require_finite(value, f"{name} along {axis}", owner)
               for axis, value in zip(AXES, items))  # fmt: skip
    return x, y, z


class Grip(Constraint):
    """Holds nodes together as a rigid body that is moved and turned.

    Translations are those of the centroid of the nodes. On the shell rung the middles of their edges belong to it; a
    sheet is clamped by a grip of whole facets, such as the nodes of a strip, and hinged by a grip of a single line.

    Parameters
    ----------
    nodes : Node or sequence of Node
        The nodes of the grip, at least two.
    move : sequence of 3 floats or None
        Displacement of the centroid at load factor 1 along x, y, z [length]; 0 holds it, None leaves it free.
    turn : sequence of 3 floats or None
        Components of the rotation vector about the centroid at load factor 1 [rad]; its length is the angle, of any
        size, and its direction the axis. In a model with dim=2 only the last one counts.
    constant : bool
        Holds the values at full size whatever the load factor.

    Raises
    ------
    ModelError
        Fewer than two nodes, values that are no three numbers or None; when a system is made: nodes in one place, or on
        a line about which they are asked to turn.

    Examples
    --------
    A beam of two bars is turned by a right angle about its middle; the force of a rigid motion is zero:

    >>> import math, kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0.5, 0.5))
    >>> objects = m.add(kg.Bar(a, c, EA=1.0), kg.Bar(b, c, EA=1.0))
    >>> grip = m.add(kg.Grip([a, b], move=(0, 0, 0), turn=(0, 0, math.pi / 2)))
    >>> res = kg.DisplacementControl(m).run()
    >>> res.u[-1, 0].round(9).tolist(), res.u[-1, 2].round(9).tolist()
    ([0.5, -0.5, 0.0], [-0.5, -0.5, 0.0])
    """

    __slots__ = ("move", "turn")
    move: Motion
    turn: Motion

    def __init__(
        self,
        nodes: Node | Iterable[Node],
        move: Sequence[float | None] = (0, 0, 0),
        turn: Sequence[float | None] = (0, 0, 0),
        constant: bool = False,
    ) -> None:
        owner = type(self).__name__
        group = listed(nodes, owner, once=True)
        if len(group) < 2:
            raise ModelError(f"{owner}: one node is no rigid body; give at least two, or hold it by Fix or Prescribe")
        super().__init__(group, {}, constant=require_boolean(constant, "constant", owner))
        object.__setattr__(self, "move", _motion(move, "move", owner))
        object.__setattr__(self, "turn", _motion(turn, "turn", owner))

    def held(self, lam: float) -> Constraint:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "Grip.held")
        if self.constant or not self.drives:
            return self
        move, turn = ([None if v is None else lam * v for v in values] for values in (self.move, self.turn))
        return Grip(self.group, move, turn, constant=True)

    @property
    def drives(self) -> bool:
        """Whether it moves with the load factor."""
        return not self.constant and any(self.move + self.turn)

    @classmethod
    def reserve(cls, objects: Sequence[Any], numbering: Numbering) -> None:
        for item in objects:
            numbering.grips[id(item)] = item._rows(numbering)

    @classmethod
    def lower(cls, objects: Sequence[Any], numbering: Numbering) -> list[Kernel]:
        """A grip makes no force."""
        return []

    def known(self, rows: GripRows, dim: int) -> tuple[NDArray[np.int64], Array]:
        """Numbers of the displacements that are held or driven, and their values at load factor 1.

        The second number of a turn in a plane means nothing.
        """
        turn = self.turn if dim == 3 else (self.turn[2], 0.0)
        values = [*self.move[:dim], *(None if value is None else rows.radius * value for value in turn)]
        at = np.concatenate([row * dim + np.arange(dim) for row in (rows.shift, rows.turn)])
        given = np.array([value is not None for value in values])
        return at[given], np.array([value for value in values if value is not None])

    def _rows(self, numbering: Numbering) -> GripRows:
        """The rows that follow the grip, and two new ones that move it."""
        dim, points = numbering.dim, numbering.index(self.group)
        arms = np.zeros((len(points), 3))
        arms[:, :dim] = numbering.rest[points] - numbering.rest[points].mean(axis=0)
        radius = float(np.sqrt((arms**2).sum() / len(arms)))
        self._check_turn(arms, radius, numbering)
        middles = np.empty(0, np.int64)
        if numbering.edges is not None:
            edges = numbering.edges
            inside = np.isin(np.arange(numbering.points), points)
            middles = np.unique(edges.middle[edges_within(edges.edge, edges.ends, inside)])
        offsets = np.zeros((len(middles), 3))
        offsets[:, :dim] = numbering.rest[middles]
        idle = np.zeros((2, dim), dtype=bool)
        idle[1, 1:] = dim == 2
        shift, turn = numbering.add_rows(np.zeros((2, dim)), np.array([np.inf, radius]), idle).tolist()
        return GripRows(points, middles, np.concatenate([arms, offsets]), shift, turn, radius)

    def _check_turn(self, arms: Array, radius: float, numbering: Numbering) -> None:
        first = numbering.describe(self.group[0])
        if radius <= 1e-12 * numbering.size:
            raise ModelError(f"{self!r}: its nodes lie in one place, {first}, and have no rotation")
        if numbering.dim == 2:
            if any(self.turn[:2]) or self.move[2]:
                raise ModelError(
                    f"{self!r} leaves the plane, but the model has dim=2: give move=(x, y, 0), turn=(0, 0, rz)"
                )
            return
        _, sizes, axes = np.linalg.svd(arms, full_matrices=False)
        if sizes[1] > STRAIGHT * sizes[0]:
            return
        line = axes[0]
        free = np.array([value is None for value in self.turn])
        given = np.array([value or 0.0 for value in self.turn])
        if np.linalg.norm(line[~free]) < STRAIGHT or abs(line @ given) > STRAIGHT * np.abs(given).max():
            along = ", ".join(f"{c:.3g}" for c in line)
            raise ModelError(
                f"{self!r}: its nodes, from {first} on, lie on a line along ({along}) and cannot be asked to turn "
                "about it: nothing would turn; add nodes off the line, such as a second row, or hold that turn at 0"
            )

    def __repr__(self) -> str:
        def said(values: Motion) -> str:
            return ", ".join("free" if value is None else f"{value:g}" for value in values)

        return (
            f"{type(self).__name__}({counted(len(self.group), 'node')}, move=({said(self.move)}), "
            f"turn=({said(self.turn)}))"
        )


class RigidLink(Grip):
    """Holds nodes together as a rigid body that is free to move and turn.

    Parameters
    ----------
    nodes : sequence of Node
        The nodes that keep their distances, at least two; not all on a line in a model with dim=3.

    Raises
    ------
    ModelError
        As for :class:`Grip`.

    Examples
    --------
    A lever bears half the force at an arm that is twice as long:

    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b, c, d = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(3, 0), kg.Node(3, 1))
    >>> objects = m.add(kg.RigidLink([a, b, c]), kg.Bar(c, d, EA=100.0), kg.Spring(b, 1e6), kg.Fix(d))
    >>> load = m.add(kg.NodalLoad(a, (0, -1)))
    >>> round(float(kg.LinearStatic(m).run().bar_force[-1, 0]), 6)
    -0.5
    """

    __slots__ = ()

    def __init__(self, nodes: Iterable[Node]) -> None:
        super().__init__(nodes, (None, None, None), (None, None, None), constant=True)

    @property
    def links(self) -> bool:
        return True

    def __repr__(self) -> str:
        return f"RigidLink({counted(len(self.group), 'node')})"
