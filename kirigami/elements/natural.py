"""What elements of a sheet bear nothing at, beside their rest state: a strain, a curvature or an angle of their own.

It is n(lam) = n_0 + lam n_1, with lam the load factor; what is felt counts from there. The energies are quadratic in
what is felt, and so in the load factor, so that their rates are differences, exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array, Contribution, Kernel

Base = TypeVar("Base", bound=Kernel)

YIELDS_AND_DRIVEN = (
    "a sheet that yields cannot be driven by Actuate with the load factor, since what has yielded would depend on it: "
    "use constant=True, or a material with hardening=None"
)


class NaturalKernel(Kernel):
    """Base of the kernels whose members :class:`kirigami.Actuate` may drive."""

    _natural: Array | None = None  # (2, n, ...): whatever the load factor, and what grows with it

    def actuate(self, members: NDArray[np.int64], values: Array, constant: bool) -> None:
        """Add `values` (k, ...) to what `members` (k,) bear nothing at, of the kind that is felt."""
        if self._natural is None:
            self._natural = np.zeros((2, len(self.conn), *values.shape[1:]))
        np.add.at(self._natural[0 if constant else 1], members, values)
        self._scale()

    def _scale(self) -> None:
        self.scaled = self._natural is not None and bool(np.any(self._natural[1]))

    def natural(self, lam: float) -> Array | None:
        """What members (n, ...) bear nothing at, at a load factor; None where it is zero."""
        return None if self._natural is None else self.begun * self._natural[0] + lam * self._natural[1]

    def beyond(self, felt: Array, lam: float) -> Array:
        """What is felt (n, ...) less what members bear nothing at."""
        natural = self.natural(lam)
        return felt if natural is None else felt - natural

    def by_load(self, x: Array, lam: float, need: int = 1) -> Contribution:
        after, before = (self.evaluate(x, lam + half, need) for half in (0.5, -0.5))
        if need == 0:
            return Contribution(after.energy - before.energy)
        assert after.gradient is not None and before.gradient is not None
        return Contribution(after.energy - before.energy, after.gradient - before.gradient)

    def with_natural(self, arrays: dict[str, Any]) -> dict[str, Any]:
        """Constructor arguments, with what members bear nothing at."""
        return arrays if self._natural is None else {**arrays, "natural": self._natural}


def derived(kernels: Iterable[Kernel], base: type[Base], says: Callable[[Kernel], bool], owner: str) -> list[Base]:
    """The kernels that tell what `base` asks of them. One that `says` what it is and does not tell that is refused:
    leaving it out would be a wrong number."""
    found: list[Base] = []
    for kernel in kernels:
        if isinstance(kernel, base):
            found.append(kernel)
        elif says(kernel):
            raise ModelError(
                f"{owner}: the kernel {kernel.name!r} ({type(kernel).__name__}) does not tell what is asked of it: "
                f"derive it from {base.__module__}.{base.__name__}"
            )
    return found
