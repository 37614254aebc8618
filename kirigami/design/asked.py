"""What is asked of an equilibrium of a design: its value, and the adjoint solutions behind its derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from kirigami.results.gradients.equilibrium import Adjoint, Equilibrium
from kirigami.results.gradients.functionals import Told, tell_of
from kirigami.results.gradients.gradient import stiffness
from kirigami.results.results import Results

BY_NODES = ("force", "position", "stiffness")


class Asked(NamedTuple):
    """A value, and its derivative as a sum of weights times those of adjoint solutions."""

    value: float
    parts: list[tuple[float, Adjoint]]


def asked(functionals: Sequence[Any], at: Equilibrium, results: Results, slopes: bool = True) -> list[Asked]:
    """Functionals at an equilibrium, out of one solution for all of them but stiffnesses, which have two each; without
    what derivatives need unless `slopes` are wanted."""
    found: list[Any] = [None] * len(functionals)
    told: dict[int, Told] = {}
    for number, functional in enumerate(functionals):
        if isinstance(functional, tuple) and functional[0] == "stiffness":
            found[number] = Asked(*stiffness(at, functional, results, "Inverse", slopes))
        else:
            told[number] = at.told(tell_of(functional, results, "Inverse"))
    adjoints = at.adjoints(list(told.values())) if slopes and told else [None] * len(told)
    for (number, value), adjoint in zip(told.items(), adjoints):
        found[number] = Asked(value.value, [] if adjoint is None else [(1.0, adjoint)])
    return found


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
