"""Loads with a load factor of their own: what they do at it beyond what they do at the common one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kirigami.errors import ModelError
from kirigami.model.model import Model
from kirigami.primitives.checks import require_items, shown
from kirigami.primitives.kernel import Array, Contribution, Kernel
from kirigami.primitives.parts import Numbering

DELEGATED = ("name", "conn", "places", "pairs", "stores_energy", "conservative", "translation_invariant", "anchored")


class ApartKernel(Kernel):
    """A load at a factor of its own, less the same at the load factor, which its plain kernel adds.

    So the kernels of a model, and what they remember, stand where they stand without it. The factor is what it
    remembers from step to step.
    """

    scaled = True

    def __init__(self, kernel: Kernel) -> None:
        self.kernel, self.factor = kernel, 0.0
        for name in DELEGATED:
            setattr(self, name, getattr(kernel, name))

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        own, common = (self.kernel.evaluate(x, factor, need) for factor in (self.factor, lam))

        def less(one: Array | None, other: Array | None) -> Array | None:
            return None if one is None or other is None else one - other

        return Contribution(
            own.energy - common.energy, less(own.gradient, common.gradient), less(own.hessian, common.hessian)
        )

    @property
    def history(self) -> Array | None:
        return np.array([self.factor])

    @history.setter
    def history(self, value: Array | None) -> None:
        if value is not None:
            self.factor = float(value[0])

    def arrays(self) -> dict[str, Any]:
        return self.kernel.arrays()


def require_apart(items: Any, model: Model, name: str, owner: str) -> tuple[Any, ...]:
    """Loads and supports of a model that follow a load factor, as given, or a ModelError."""
    found = tuple(require_items(items, name, owner))
    for item in found:
        if not any(item is known for known in (*model.loads, *model.constraints)):
            raise ModelError(f"{owner}: {name}: {shown(item)} is no load and no support of the model")
        if item.constant or not (item.kind == "load" or item.drives):
            raise ModelError(
                f"{owner}: {name}: {item!r} does not follow a load factor: give it a value that is not constant"
            )
    return found


def kernels_apart(item: Any, numbering: Numbering) -> Sequence[ApartKernel]:
    """What an object with a load factor of its own adds; nothing for supports, which :class:`Unknowns` moves."""
    if item.kind != "load":
        return ()
    return [ApartKernel(kernel) for kernel in type(item).lower([item], numbering) if kernel.scaled]
