"""What results keep of the supports of a model: which nodes were held, driven or tied when the run began."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES

if TYPE_CHECKING:
    from kirigami.model.model import Model




@dataclass(frozen=True, eq=False)
class Support:
    """One constraint of the model of a run, as it was then.

    Attributes
    ----------
    name : str
        "driven_0" and on for what moves with the load factor (``Prescribe``, ``Turn``, ``Grip``), "fixed_0" and on for
        what stands still, "tied_0" and on for ties and rigid links, each counted in the order added.
    kind : str
        Type of the constraint, such as "Prescribe".
    nodes : ndarray of int, shape (k,)
        Indices of the nodes it holds.
    values : dict of str to ndarray, shape (k,)
        Displacement by axis, of ties the difference from the leaders [length]: at load factor 1, or for good where it
        is `constant`.
    leaders : ndarray of int, shape (k,) or (0,)
        The nodes that those of a tie follow.
    constant, clamp : bool
        As given.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.Prescribe(b, x=0.1))
    >>> res = kg.LinearStatic(m).run()
    >>> [(support.name, support.dofs, support.nodes.tolist()) for support in res.supports]
    [('fixed_0', 'xyz', [0]), ('fixed_1', 'y', [1]), ('driven_0', 'x', [1])]
    >>> round(float(res.reaction("driven_0", "x")[-1]), 12)
    1.0
    """

    name: str
    kind: str
    nodes: NDArray[np.int64]
    values: dict[str, Array]
    leaders: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    constant: bool = False
    clamp: bool = False

    @property
    def dofs(self) -> str:
        """The axes it holds, letters out of "xyz"."""
        return "".join(self.values)

    @property
    def driven(self) -> bool:
        """Whether it moves nodes with the load factor."""
        return self.name.startswith("driven_")


def named(constraints: Iterable[Any]) -> Iterable[tuple[str, Any]]:
    """Constraints with the names they go by in results and exports."""
    counts: Counter[str] = Counter()
    for item in constraints:
        group = "tied" if item.links else "driven" if item.drives else "fixed"
        yield f"{group}_{counts[group]}", item
        counts[group] += 1


def supports_of(model: Model) -> tuple[Support, ...]:
    """The constraints of a model as they are now."""
    return tuple(
        Support(
            name,
            type(item).__name__,
            model.index(item.group),
            {axis: np.array(values) for axis, values in item.values.items()},
            model.index(item.leaders),
            item.constant,
            item.clamp,
        )
        for name, item in named(model.constraints)
    )


def carried_by(nodes: NDArray[np.int64], supports: Iterable[Support], count: int) -> NDArray[np.bool_]:
    """Which displacements (count, 3) go where `nodes` go: their own, and those tied to them, in chains as well.

    What holds a node holds by ties all that follows it.
    """
    leader = np.full((count, 3), -1)
    for support in supports:
        if len(support.leaders):
            for letter in support.dofs:
                leader[support.nodes, AXES.index(letter)] = support.leaders
    carried = np.zeros((count, 3), dtype=bool)
    carried[nodes] = True
    follower, axis = np.nonzero(leader >= 0)
    for _ in range(len(follower)):
        new = carried[leader[follower, axis], axis] & ~carried[follower, axis]
        if not new.any():
            break
        carried[follower[new], axis[new]] = True
    return carried
