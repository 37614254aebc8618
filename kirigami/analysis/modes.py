"""Modes: shapes of eigenvectors, scaled and signed alike everywhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kirigami.deferred import deferred
from kirigami.errors import AnalysisError
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.step import Step
from kirigami.system.system import System
from kirigami.words import counted

UNTIMED = "modes of unit masses have no frequency: ask for them with Eigen(model, mass='consistent')"


def first_largest(values: Array) -> int:
    """Index of the first entry whose size is the largest up to rounding, so that signs are repeatable."""
    size = np.abs(values)
    return int(np.flatnonzero(size >= size.max() * (1 - 1e-6))[0])


def mode_shape(system: System, vector: Array, about: Array | None = None) -> tuple[Array, Array]:
    """Unknowns (free,) as a shape (n, 3) and what stands behind it (h, 3): largest component of the shape 1, the first
    of the largest entries positive."""
    shape, inner = system.parted(system.motion(vector, about=about))
    first = shape.ravel()[first_largest(shape.ravel())]
    scale = np.abs(shape).max() * np.sign(first)
    return shape / scale, inner / scale


def nodal_shape(system: System, vector: Array, about: Array | None = None) -> Array:
    """Unknowns (free,) as a shape (n, 3): largest component 1, the first of the largest entries positive."""
    return mode_shape(system, vector, about)[0]


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
    >>> mode = kg.Eigen(m, n=1).run()[0]
    >>> mode
    Mode(value=3)
    >>> ax = mode.plot()
    """

    value: float
    shape: Array
    inner: Array = field(default_factory=lambda: np.zeros((0, 3)), repr=False)
    origin: Results | None = field(default=None, repr=False)  # holds the state the mode is about
    timed: bool = field(default=False, repr=False)

    @property
    def frequency(self) -> float:
        """Frequency [1 / time, hertz in SI units]; nan where the value is negative, since the state is unstable.

        Raises
        ------
        AnalysisError
            The mode was found with unit masses.
        """
        return float(frequencies(np.array([self.value]), self.timed)[0])

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(self.shape, dtype=dtype)

    def __repr__(self) -> str:
        return f"Mode(value={self.value:.6g})"

    plot = deferred("kirigami.plot.modes:plot_mode")
    animate = deferred("kirigami.plot.modes:animate_mode")


@dataclass(frozen=True, eq=False)
class Modes:
    """Eigenmodes in ascending order of their values; index or loop to get each :class:`Mode`."""

    values: Array
    shapes: Array
    inner: Array | None = field(default=None, repr=False)
    origin: Results | None = field(default=None, repr=False)
    timed: bool = field(default=False, repr=False)

    @classmethod
    def of(
        cls, results: Results, system: System, values: Array, vectors: Array, u: Array, lam: float, timed: bool = False
    ) -> Modes:
        """Modes with eigenvectors (free, k) about displacements `u` (rows, dim), which become the step of `results`."""
        nodal, inner = system.parted(u)
        results.append(Step(lam, nodal, inner=inner, history=system.history))
        shapes = [mode_shape(system, vector, u) for vector in vectors.T]
        return cls(values, np.array([s[0] for s in shapes]), np.array([s[1] for s in shapes]), results, timed)

    @property
    def frequencies(self) -> Array:
        """Frequency of each mode [1 / time, hertz in SI units]; nan where the value is negative.

        Raises
        ------
        AnalysisError
            The modes were found with unit masses.
        """
        return frequencies(self.values, self.timed)

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, index: int) -> Mode:
        inner = np.zeros((0, 3)) if self.inner is None else self.inner[index]
        return Mode(float(self.values[index]), self.shapes[index], inner, self.origin, self.timed)

    def __iter__(self) -> Iterator[Mode]:
        return (self[index] for index in range(len(self)))

    def __repr__(self) -> str:
        return f"<{counted(len(self), 'mode')}, values {self.values[0]:.6g} to {self.values[-1]:.6g}>"


def frequencies(values: Array, timed: bool) -> Array:
    """sqrt(value) / (2 pi) of eigenvalues, where masses were real."""
    if not timed:
        raise AnalysisError(UNTIMED)
    return np.asarray(np.sqrt(np.where(values < 0, np.nan, values)) / (2 * np.pi))
