"""Typed errors: each names the thing, the place and what to do, and none of them loses results already computed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kirigami.results import Results


class KirigamiError(Exception):
    """Base of every error this package raises on purpose."""


class GeometryError(KirigamiError, ValueError):
    """The outline, the cuts or the mesh cannot be used as given."""


class ModelError(KirigamiError, ValueError):
    """An object of the model, or a request about it, is invalid."""


class MechanismError(KirigamiError):
    """The structure can move without resistance.

    Attributes
    ----------
    motion : str
        The motion in words, for example ``"translation along y"``.
    nodes : list of int
        Indices of the nodes that move most.
    shape : ndarray, shape (n, 3), or None
        The free motion itself, largest component 1, where it was computed.
    """

    def __init__(self, message: str, *, motion: str = "", nodes: Sequence[int] = (), shape: Any = None) -> None:
        super().__init__(message)
        self.motion = motion
        self.nodes = list(nodes)
        self.shape = shape


class AnalysisError(KirigamiError):
    """An analysis could not be carried out; ``results`` holds what was computed before."""

    def __init__(self, message: str, *, results: Results | None = None) -> None:
        super().__init__(message)
        self.results = results


class ConvergenceError(AnalysisError):
    """Equilibrium was not found at the smallest allowed increment.

    Attributes
    ----------
    results : Results
        Every step that converged before the failure.
    history : list of float
        Relative residuals of the last attempt, iteration by iteration.
    worst_nodes : list of int
        Nodes with the largest residual force in the last attempt.
    hint : str
        What to try next.
    """

    def __init__(
        self,
        message: str,
        *,
        results: Results | None = None,
        history: Sequence[float] = (),
        worst_nodes: Sequence[int] = (),
        hint: str = "",
    ) -> None:
        super().__init__(f"{message}\nHint: {hint}" if hint else message, results=results)
        self.history = list(history)
        self.worst_nodes = list(worst_nodes)
        self.hint = hint


class KirigamiWarning(UserWarning):
    """Something was repaired or looks wrong, and the work went on."""
