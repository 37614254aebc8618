"""The grounded spring: a node that is held elastically to the place it has in the rest state.

Energy (kx ux^2 + ky uy^2 + kz uz^2) / 2, one stiffness for each axis.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array
from kirigami.primitives.kernel import Array, Contribution, Kernel, displacement_of
from kirigami.primitives.node import Node, listed
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.words import counted


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class Spring(ModelObject):
    """A linear spring from each of the given nodes to the ground.

    Parameters
    ----------
    nodes : Node or sequence of Node
        The nodes that are held.
    stiffness : float or array_like, shape (2,) or (3,)
        Force per displacement at each node [force / length]: the same in all directions, or one for each axis; zero
        leaves an axis free.

    Raises
    ------
    ModelError
        Empty selection, a node listed twice, a stiffness that is negative, not finite, or zero along all axes.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix([a, b], "y"), kg.Spring(a, 5.0), kg.NodalLoad(b, (1, 0)))
    >>> kg.LinearStatic(m).run().u[-1, :, 0].round(9).tolist()
    [0.2, 0.3]
    """

    kind: ClassVar[str] = "effect"
    group: tuple[Node, ...]
    stiffness: tuple[float, float, float]

    def __init__(self, nodes: Node | Iterable[Node], stiffness: ArrayLike) -> None:
        object.__setattr__(self, "group", listed(nodes, "Spring", once=True))
        given = require_array(stiffness, (), (2,), (3,), name="stiffness", owner="Spring")
        along = np.full(3, given) if given.ndim == 0 else np.append(given, 0.0)[:3]
        if np.any(along < 0) or not along.any():
            raise ModelError(f"Spring: stiffness must be positive, or zero along some of the axes, got {stiffness!r}")
        object.__setattr__(self, "stiffness", tuple(along.tolist()))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return self.group

    @classmethod
    def lower(cls, objects: Sequence[Spring], numbering: Numbering) -> list[Kernel]:
        members = np.repeat(np.arange(len(objects)), [len(item.group) for item in objects])
        conn = numbering.index(node for item in objects for node in item.group)[:, None]
        stiffness = np.array([item.stiffness for item in objects])[:, : numbering.dim]
        idle = np.flatnonzero(~stiffness.any(axis=1))
        if idle.size:
            raise ModelError(f"{objects[int(idle[0])]!r} acts along z alone, but the model has dim=2")
        return [SpringKernel(numbering.rest, conn, stiffness[members], members)]

    def __repr__(self) -> str:
        return f"Spring({counted(len(self.group), 'node')}, stiffness=({', '.join(f'{k:g}' for k in self.stiffness)}))"


class SpringKernel(Kernel):
    """All grounded springs, one node per member."""

    name = "grounded springs"
    pairs = ((0, 0),)
    anchored = True
    measures_displacement = True

    def __init__(
        self, rest: Array, conn: NDArray[np.int64], stiffness: Array, members: NDArray[np.int64] | None = None
    ) -> None:
        self.rest, self.conn, self.stiffness, self.members = rest, conn, stiffness, members

    def arrays(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("conn", "stiffness", "members")}

    def deformation(self, x: Array) -> Array:
        """Displacement of each node (n, dim) [length]."""
        return displacement_of(x, self.rest)[self.conn[:, 0]]

    def deformation_rate(self, x: Array, change: Array) -> Array:
        return np.asarray(np.asarray(change)[self.conn[:, 0]])

    def force(self, deformation: Array) -> Array:
        """Force of each node on its spring (n, dim), along its displacement."""
        return np.asarray(self.stiffness * deformation)

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        u = self.deformation(x)
        pull = self.stiffness * u
        energy = 0.5 * (pull * u).sum(axis=1)
        if need < 2:
            return Contribution(energy, pull[:, None])
        return Contribution(energy, pull[:, None], (self.stiffness[:, :, None] * np.eye(u.shape[1]))[:, None])
