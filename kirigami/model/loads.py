"""Loads: kernels whose potential falls when the structure moves along them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_boolean, require_finite
from kirigami.primitives.kernel import Array, Contribution, Kernel, displacement_of
from kirigami.primitives.node import Node, listed, vector_of
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.words import counted


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Load(ModelObject):
    """Base of all loads."""

    kind: ClassVar[str] = "load"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class NodalLoad(Load):
    """A dead force on each of the given nodes.

    Parameters
    ----------
    nodes : Node or sequence of Node
        Loaded nodes.
    force : array_like, shape (2,) or (3,)
        Force on each node at load factor 1 [force].
    constant : bool
        The force acts at full size whatever the load factor.

    Raises
    ------
    ModelError
        Empty selection, a node listed twice, or a force that is not two or three finite numbers.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.NodalLoad(kg.Node(0, 1), (0, -1))
    NodalLoad(1 node, force=(0, -1, 0))
    """

    group: tuple[Node, ...]
    force: tuple[float, float, float]
    constant: bool

    def __init__(self, nodes: Node | Iterable[Node], force: ArrayLike, constant: bool = False) -> None:
        object.__setattr__(self, "group", listed(nodes, "NodalLoad", once=True))
        object.__setattr__(self, "force", vector_of(force, "force", "NodalLoad"))
        object.__setattr__(self, "constant", require_boolean(constant, "constant", "NodalLoad"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return self.group

    def held(self, lam: float) -> NodalLoad:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "NodalLoad.held")
        return self if self.constant else NodalLoad(self.group, np.multiply(lam, self.force), constant=True)

    @classmethod
    def lower(cls, objects: Sequence[NodalLoad], numbering: Numbering) -> list[Kernel]:
        for load in objects:
            if numbering.dim == 2 and load.force[2] != 0:
                raise ModelError(f"{load!r} has a force along z, but the model has dim=2")
        kernels: list[Kernel] = []
        for constant in (False, True):
            group = [load for load in objects if load.constant == constant]
            if group:
                conn = numbering.index(node for load in group for node in load.group)[:, None]
                force = np.repeat([load.force for load in group], [len(load.group) for load in group], axis=0)
                kernels.append(NodalLoadKernel(numbering.rest, conn, force[:, : numbering.dim], constant))
        return kernels

    def __repr__(self) -> str:
        x, y, z = self.force
        constant = ", constant=True" if self.constant else ""
        return f"NodalLoad({counted(len(self.group), 'node')}, force=({x:g}, {y:g}, {z:g}){constant})"


class LoadKernel(Kernel):
    """Base of the kernels of loads, which act with the load factor or, where `constant`, whatever it is."""

    stores_energy = False

    def __init__(self, constant: bool) -> None:
        self.constant = bool(constant)
        self.scaled = not self.constant

    def factor(self, lam: float) -> float:
        """Share of the load that is there."""
        return self.begun if self.constant else lam


class NodalLoadKernel(LoadKernel):
    """Potential -lam F.u of dead forces."""

    name = "loads"
    pairs = ()
    independent = True

    def __init__(self, rest: Array, conn: NDArray[np.int64], force: Array, constant: bool = False) -> None:
        super().__init__(constant)
        self.rest, self.conn, self.applied = rest, conn, force

    def arrays(self) -> dict[str, Any]:
        return {"conn": self.conn, "force": self.applied, "constant": self.constant}

    def by_rest(self, x: Array, lam: float, fields: Array, energies: Array) -> Array | None:
        """Dead forces feel displacements alone."""
        return np.zeros((len(fields), *self.rest.shape))

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        factor = self.factor(lam)
        u = displacement_of(x, self.rest)[self.conn[:, 0]]
        return Contribution(-factor * (self.applied * u).sum(axis=1), -factor * self.applied[:, None, :])
