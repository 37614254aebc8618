"""The steps of results: what is stored of each, as arrays over all of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_finite, require_whole
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import Node
from kirigami.results.record import ModelRecord, Nodes
from kirigami.results.step import Step

Told = TypeVar("Told")


class StoredSteps(ModelRecord):
    """Base of results: the model as it was, and the steps that were stored of it."""

    steps: list[Step]
    grip_nodes: dict[str, NDArray[np.int64]]

    def __len__(self) -> int:
        return len(self.steps)

    def __getitem__(self, index: int) -> Step:
        return self.steps[index]

    def step_number(self, step: int, owner: str) -> int:
        """The number of a stored step, or a ModelError that says which there are."""
        count = len(self)
        number = require_whole(step, "step", owner)
        if not -count <= number < count:
            raise ModelError(
                f"{owner}: step {number} is not stored: the results hold steps 0 to {count - 1}, or -{count} to -1"
            )
        return number

    def nearest(self, load_factor: float) -> int:
        """Number of the first step whose load factor is nearest to one that is asked for.

        A run stores what it passes; steps at exactly these load factors are what ``targets`` of an analysis asks for.

        Examples
        --------
        >>> import kirigami as kg
        >>> m = kg.Model(dim=2)
        >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
        >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
        >>> results = kg.LoadControl(m, targets=[0.25, 1.0]).run()
        >>> float(results.lam[results.nearest(0.3)])
        0.25
        """
        wanted = require_finite(load_factor, "load_factor", "Results.nearest")
        if not self.steps:
            raise ModelError("Results.nearest: no step is stored")
        return int(np.argmin(np.abs(self.lam - wanted)))

    def append(self, step: Step) -> None:
        """Store one more step; derived quantities are computed anew when asked for."""
        self.steps.append(step)
        for name in ("lam", "u", "time", "velocity", "row_gradients", "energy", "_told", "error"):
            self.__dict__.pop(name, None)

    @cached_property
    def _told(self) -> dict[Any, Any]:
        return {}

    def once(self, key: Any, make: Callable[[], Told]) -> Told:
        """What is made when it is first asked for, and kept under a key until one more step is stored."""
        if key not in self._told:
            self._told[key] = make()
        kept: Told = self._told[key]
        return kept

    @cached_property
    def lam(self) -> Array:
        """Load factors (s,)."""
        return np.array([step.lam for step in self.steps])

    @cached_property
    def u(self) -> Array:
        """Displacements (s, n, 3) from the rest state [length]."""
        return np.array([step.u for step in self.steps]).reshape(len(self.steps), len(self.rest), 3)

    @cached_property
    def time(self) -> Array:
        """Times (s,) of a motion [time]; nan for equilibria."""
        return np.array([step.time for step in self.steps])

    @cached_property
    def velocity(self) -> Array:
        """Velocities (s, n, 3) of a motion [length / time]; zero for equilibria."""
        still = np.zeros_like(self.rest)
        moving = [still if step.velocity is None else step.velocity for step in self.steps]
        return np.array(moving).reshape(len(self.steps), len(self.rest), 3)

    @property
    def moves(self) -> bool:
        """Whether the steps are moments of a motion, and not equilibria."""
        return any(step.velocity is not None for step in self.steps)

    @property
    def grips(self) -> dict[str, tuple[Node, ...] | NDArray[np.int64]]:
        """Nodes of the grips of :func:`kirigami.stretch`, "held" and "moved"; indices in results without a model."""
        if not self.nodes:
            return dict(self.grip_nodes)
        return {name: tuple(self.nodes[k] for k in index) for name, index in self.grip_nodes.items()}

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether each step is stable at fixed load factor (s,)."""
        return np.array([step.stable for step in self.steps], dtype=bool)

    @property
    def yielded(self) -> Array:
        """Share (s,) of the sheet that has yielded, or is strained beyond its yield stress where it stays elastic; of
        structures without a sheet the share of the members that can yield. nan without a yield stress."""
        return np.array([step.yielded for step in self.steps])

    @property
    def residual(self) -> Array:
        """Relative residual of each step (s,)."""
        return np.array([step.residual for step in self.steps])

    def position(self, nodes: Nodes | None = None) -> Array:
        """Positions (s, 3) of one node, (s, k, 3) of many, (s, n, 3) of all [length]; nodes as for `node_index`."""
        if nodes is None:
            return self.rest + self.u
        index = self.node_index(nodes)
        moved = self.rest[index] + self.u[:, index]
        single = isinstance(nodes, (Node, int, np.integer)) or (isinstance(nodes, str) and nodes in self.node_names)
        return moved[:, 0] if single else moved
