"""A moment along edges of a sheet of shell facets, which works on the angles that these have as unknowns."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.model.loads import Load, LoadKernel
from kirigami.primitives.checks import require_boolean, require_finite
from kirigami.primitives.kernel import Array, Contribution, Kernel
from kirigami.primitives.node import Node, listed
from kirigami.primitives.parts import Numbering
from kirigami.words import counted


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class EdgeMoment(Load):
    """A moment per length on boundary edges of shell facets, about each edge.

    It goes along with its edge and works on the turn of the sheet about it, int m d(turn) ds, through any number of
    turns: the moment that rolls a strip up. Where the angle of an edge is held by a clamp or a mirror plane, it only
    adds to what these bear.

    Parameters
    ----------
    nodes : sequence of Node
        The moment acts on the boundary edges with both ends among these.
    moment : float
        Moment per length at rest, at load factor 1 [force]; positive where it makes the sheet hollow from above, that
        is, from the side of the normal.
    constant : bool
        It acts at full size whatever the load factor.

    Raises
    ------
    ModelError
        Empty selection or a moment that is not finite; in a run nodes without a boundary edge between them, or a model
        without shell facets.

    Examples
    --------
    A strip bent to a quarter of a circle, M = D / R:

    >>> import numpy as np
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (4, 0), (4, 1), (0, 1)]).mesh(0.6)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.1, material=kg.Material(E=12e3, nu=0.0), stiffness="shell")
    >>> held = m.add(kg.Fix(m.select(boundary="left"), clamp=True))
    >>> moment = m.add(kg.EdgeMoment(m.select(boundary="right"), 1.0 * np.pi / 8))
    >>> end = kg.LoadControl(m).run().position("right")[-1].mean(axis=0)
    >>> [round(float(end[k] * np.pi / 8), 2) for k in (0, 2)]
    [1.0, 1.0]
    """

    group: tuple[Node, ...]
    moment: float
    constant: bool

    def __init__(self, nodes: Iterable[Node], moment: float, constant: bool = False) -> None:
        object.__setattr__(self, "group", listed(nodes, "EdgeMoment", once=True))
        object.__setattr__(self, "moment", require_finite(moment, "moment", "EdgeMoment"))
        object.__setattr__(self, "constant", require_boolean(constant, "constant", "EdgeMoment"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return self.group

    def held(self, lam: float) -> EdgeMoment:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "EdgeMoment.held")
        return self if self.constant else EdgeMoment(self.group, lam * self.moment, constant=True)

    @classmethod
    def lower(cls, objects: Sequence[EdgeMoment], numbering: Numbering) -> list[Kernel]:
        edges = numbering.edges
        if edges is None:
            raise ModelError("EdgeMoment needs shell facets, whose edges have angles: use stiffness='shell'")
        alone = np.bincount(edges.edge.ravel(), minlength=len(edges.ends)) == 1
        facet, local = np.nonzero(alone[edges.edge])
        edge = edges.edge[facet, local]
        made: list[Kernel] = []
        for constant in (False, True):
            rows: list[NDArray[np.int64]] = []
            values: list[Array] = []
            for load in objects:
                if load.constant != constant:
                    continue
                chosen = np.isin(edges.ends[edge], numbering.index(load.group)).all(axis=1)
                if not chosen.any():
                    raise ModelError(
                        f"{load!r}: no boundary edge joins two of its nodes, the first of which is "
                        f"{numbering.describe(load.group[0])}: select both ends of edges"
                    )
                at = facet[chosen], local[chosen]
                rows.append(edges.angle[at])
                # rows hold the edge's angle times its length, at two Gauss points with half the weight each
                values.append(0.5 * load.moment * np.where(edges.forward[at], 1.0, -1.0))
            if rows:
                conn, force = np.concatenate(rows)[:, None], np.concatenate(values)
                made.append(EdgeMomentKernel(numbering.rest, conn, force, constant))
        return made

    def __repr__(self) -> str:
        constant = ", constant=True" if self.constant else ""
        return f"EdgeMoment({counted(len(self.group), 'node')}, moment={self.moment:g}{constant})"


class EdgeMomentKernel(LoadKernel):
    """Potential -m times the integral of the turn of the edges."""

    name = "edge moments"
    pairs = ()

    def __init__(self, rest: Array, conn: NDArray[np.int64], force: Array, constant: bool = False) -> None:
        super().__init__(constant)
        self.rest, self.conn, self.applied = rest, conn, force

    def arrays(self) -> dict[str, Any]:
        return {"conn": self.conn, "force": self.applied, "constant": self.constant}

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        factor = self.factor(lam)
        stored = np.asarray(x)[self.conn[:, 0], :2]
        gradient = np.zeros((len(self.conn), 1, np.asarray(x).shape[1]))
        gradient[:, 0, :2] = -factor * self.applied[:, None]
        return Contribution(-factor * self.applied * stored.sum(axis=1), gradient)
