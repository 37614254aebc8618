"""What is asked of an equilibrium of a design: its value, and the adjoint solutions behind its derivatives."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kirigami.results.gradients.equilibrium import Adjoint, Equilibrium
from kirigami.results.gradients.functionals import tell_of
from kirigami.results.gradients.gradient import stiffness
from kirigami.results.results import Results

BY_NODES = ("force", "position", "stiffness")


class Asked(NamedTuple):
    """A value, and its derivative as a sum of weights times those of adjoint solutions."""

    value: float
    parts: list[tuple[float, Adjoint]]


def asked(functional: Any, at: Equilibrium, results: Results, slopes: bool = True) -> Asked:
    """A functional at an equilibrium, without what derivatives need unless `slopes` are wanted."""
    if isinstance(functional, tuple) and functional[0] == "stiffness":
        return Asked(*stiffness(at, functional, results, "Inverse", slopes))
    told = at.told(tell_of(functional, results, "Inverse"))
    return Asked(told.value, [(1.0, at.adjoint(told))] if slopes else [])


def carries_over(functional: Any) -> bool:
    """Whether a functional means the same on another mesh, which numbers its nodes anew."""
    if not isinstance(functional, tuple) or functional[0] == "shape":
        return False
    return functional[0] not in BY_NODES or (len(functional) > 1 and isinstance(functional[1], str))


def combined(pieces: list[Asked], rates: Any) -> Any:
    """Derivatives (pieces, parameters) out of those of all adjoint solutions, in their order."""
    found, row = [], 0
    for piece in pieces:
        weights = np.array([weight for weight, _ in piece.parts])
        found.append(weights @ rates[row : row + len(weights)])
        row += len(weights)
    return np.array(found)
