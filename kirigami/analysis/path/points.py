"""Where a path analysis stands: states, attempts at one, tangents, accepted points."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from kirigami.linalg import Factor
from kirigami.primitives.kernel import Ahead, Array


@dataclass
class State:
    """A point of the path: unknowns, load factor, displacements (n, dim)."""

    q: Array
    lam: float
    u: Array


@dataclass
class Stiffness:
    """Exact stiffness at an equilibrium: a factor that answers for its matrix, and how driven displacements change the
    forces (n, dim) with the load factor.

    `u` are the displacements (n, dim) that the factor was made at, there or close by, and `ahead` the linear step whose
    stress it took, if any. Node blocks are not kept: beside factors they are the largest things in memory.
    """

    drive_rate: Array
    factor: Factor
    u: Array
    ahead: Ahead = None


@dataclass
class Attempt:
    """How one correction went."""

    state: State
    converged: bool
    residual: float
    iterations: int
    history: list[float] = field(default_factory=list)
    reason: str = ""
    relaxed: bool = False
    drift: float = 0.0  # turn by which the corrections left the prediction
    moved: float = 0.0  # turn from the last point
    left: Point | None = None  # the unstable equilibrium that a relaxation left
    stiffness: Stiffness | None = None  # there, if it is known
    left_at: tuple[State, Stiffness] | None = None  # first unstable equilibrium met


@dataclass
class Tangent:
    """Exact tangent at an equilibrium: factor, which knows the matrix, and -K^-1 dr/dlam (free,)."""

    factor: Factor
    rate: Array


@dataclass
class Point:
    """An accepted equilibrium: its state, its exact tangent, and the history of the kernels there."""

    state: State
    tangent: Tangent
    history: Any
    potential: tuple[float, float, float] | None = None  # its value, rate and curvature, once asked for

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues of the tangent."""
        return self.tangent.factor.negative
