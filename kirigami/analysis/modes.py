"""Modes: shapes of eigenvectors, scaled and signed alike everywhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from kirigami.primitives.kernel import Array
from kirigami.system.system import System


def first_largest(values: Array) -> int:
    """Index of the first entry whose size is the largest up to rounding, so that signs are repeatable."""
    size = np.abs(values)
    return int(np.flatnonzero(size >= size.max() * (1 - 1e-6))[0])


def nodal_shape(system: System, vector: Array) -> Array:
    """Unknowns (free,) as a shape (n, 3): largest component 1, the first of the largest entries positive."""
    shape = system.parted(system.displacement(vector, 0.0) - system.displacement(0 * vector, 0.0))[0]
    first = shape.ravel()[first_largest(shape.ravel())]
    scaled: Array = shape / (np.abs(shape).max() * np.sign(first))
    return scaled


@dataclass(frozen=True, eq=False)
class Mode:
    """One eigenmode.

    Attributes
    ----------
    value : float
        Eigenvalue: stiffness over mass of the shape.
    shape : ndarray, shape (n, 3)
        Largest component 1, the first of the largest entries positive.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=3.0), kg.Fix(a), kg.Fix(b, "y"))
    >>> kg.Eigen(m, n=1).run()[0]
    Mode(value=3)
    """

    value: float
    shape: Array

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(self.shape, dtype=dtype)

    def __repr__(self) -> str:
        return f"Mode(value={self.value:.6g})"


@dataclass(frozen=True, eq=False)
class Modes:
    """Eigenmodes in ascending order of their values; index or loop to get each :class:`Mode`."""

    values: Array
    shapes: Array

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, index: int) -> Mode:
        return Mode(float(self.values[index]), self.shapes[index])

    def __iter__(self) -> Iterator[Mode]:
        return (self[index] for index in range(len(self)))

    def __repr__(self) -> str:
        return f"<{len(self)} modes, values {self.values[0]:.6g} to {self.values[-1]:.6g}>"
