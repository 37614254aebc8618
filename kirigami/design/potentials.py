"""What a functional and its multipliers make of an equilibrium where the design is changed: J - mu . r."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kirigami.errors import AnalysisError
from kirigami.primitives.kernel import Array
from kirigami.results.gradients.equilibrium import Adjoint, borne
from kirigami.system.system import System


class Changed(System):
    """A system that is asked for forces alone, so that nothing else need be known of it."""

    def _measure(self) -> None:
        pass


def potentials(adjoints: Sequence[Adjoint], system: System) -> list[float]:
    """J - mu . r at the unknowns of each equilibrium, in the system of another design."""
    forces: dict[int, tuple[Array, Array, Array, float]] = {}  # by equilibrium, which several functionals share
    found = []
    for adjoint in adjoints:
        at = adjoint.at
        if id(at) not in forces:
            if not np.array_equal(system.unknown, at.system.unknown):
                raise AnalysisError("gradient: the supports hold other nodes where the design is changed a little")
            system.history = at.system.history
            u = system.displacement(at.q, at.lam)
            x = system.configuration(u)
            total, _, energy = borne(system, x, at.lam)
            placed = np.asarray(x) - np.asarray(at.configuration)
            forces[id(at)] = u, total, placed, energy
        u, total, placed, energy = forces[id(at)]
        value = float((adjoint.field(system, u) * total).sum()) + adjoint.told.by_energy * energy
        found.append(value + float((adjoint.told.by_position[:, : system.dim] * placed).sum()))
    return found
