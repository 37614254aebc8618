"""Masses at nodes: payloads, proof masses, the nodes of a spring-mass chain."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.checks import require_positive
from kirigami.primitives.kernel import Array, Contribution, Kernel
from kirigami.primitives.node import Node, listed
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.words import counted


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Mass(ModelObject):
    """A mass on each of the given nodes. It has inertia and no weight.

    Parameters
    ----------
    nodes : Node or sequence of Node
        The nodes.
    mass : float
        Mass on each node [mass].

    Raises
    ------
    ModelError
        Empty selection, a node listed twice, a mass that is not positive and finite.

    Examples
    --------
    A mass m on a spring k swings at sqrt(k / m) / (2 pi):

    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=8.0), kg.Fix(a), kg.Fix(b, "y"), kg.Mass(b, 2.0))
    >>> [round(float(f), 6) for f in kg.Eigen(m, n=1, mass="consistent").run().frequencies]
    [0.31831]
    """

    kind: ClassVar[str] = "effect"
    group: tuple[Node, ...]
    mass: float

    def __init__(self, nodes: Node | Iterable[Node], mass: float) -> None:
        object.__setattr__(self, "group", listed(nodes, "Mass", once=True))
        object.__setattr__(self, "mass", require_positive(mass, "mass", "Mass"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return self.group

    @classmethod
    def lower(cls, objects: Sequence[Mass], numbering: Numbering) -> list[Kernel]:
        conn = numbering.index(node for item in objects for node in item.group)[:, None]
        masses = np.repeat([item.mass for item in objects], [len(item.group) for item in objects])
        return [MassKernel(numbering.rest, conn, masses)]

    def __repr__(self) -> str:
        return f"Mass({counted(len(self.group), 'node')}, {self.mass:g})"


class MassKernel(Kernel):
    """Masses at nodes, which make no force at rest or in equilibrium."""

    name = "masses"
    pairs = ()

    def __init__(self, rest: Array, conn: NDArray[np.int64], masses: Array) -> None:
        self.rest, self.conn, self.masses = rest, conn, masses

    def arrays(self) -> dict[str, Any]:
        return {"conn": self.conn, "masses": self.masses}

    def mass(self, lumped: bool = False) -> Array:
        """The masses (n, 1, 1)."""
        return np.asarray(self.masses[:, None, None])

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        return Contribution(np.zeros(len(self.conn)), np.zeros((len(self.conn), 1, x.shape[1])))
