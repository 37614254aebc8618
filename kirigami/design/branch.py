"""The equilibria of a design as it changes: gone on from those before, and walked anew where their branch ends.

The trap of inverse design is the branch: a sheet that buckled into one shape stays in it while its cuts change, up to
where that shape ends. So each design goes on from the last one accepted, in shorter and shorter steps; where none is
found, where stability is lost or the shape leaps, the sheet is walked from flat once more, and that is told.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kirigami.design.design import Design
from kirigami.errors import AnalysisError
from kirigami.primitives.kernel import Array
from kirigami.results.gradients.equilibrium import Equilibrium, prepared
from kirigami.results.results import Results

SHORTEST = 0.2  # share of the way to a new design below which its sheet is walked anew
LEAP = 0.6  # turn of a member from one design to the next beyond which it is another shape [rad]


class Branch:
    """Equilibria of a design at load factors, which follow it.

    Attributes
    ----------
    at : list of Equilibrium
        The equilibria of the last design, one for each load factor.
    walks, factorizations : int
        Walks from flat, and tangents factorised, so far.
    """

    def __init__(self, design: Design, lams: Sequence[float]) -> None:
        self.lams = list(lams)
        self.walks = self.factorizations = 0
        self.design, self.at = design, self._walk(design)

    def _walk(self, design: Design) -> list[Equilibrium]:
        """From flat, with every equilibrium to the last digits."""
        self.walks += 1
        res = design.walk(self.lams)
        self.factorizations += int(res.stats["factorizations"])
        self.results: Results = res
        found = []
        model = res.model
        for lam in self.lams:
            step = res[res.nearest(lam)]
            if abs(step.lam - lam) > 1e-9 * max(1.0, abs(lam)):
                raise AnalysisError(f"Inverse: the walk from flat did not store load factor {lam:.6g}", results=res)
            system = prepared(model, step.history)
            state = Equilibrium(system, system.joined(step.u, step.inner), step.lam, "Inverse")
            self.factorizations += state.factorizations
            found.append(state)
        return found

    def go_to(self, design: Design) -> None:
        """Follow the design; raises where neither a branch goes there nor a walk from flat."""
        start, goal = self.design.vector, design.vector
        here, done, share = self.at, 0.0, 1.0
        while done < 1.0:
            share = min(share, 1.0 - done)
            through = design if done + share >= 1.0 else design.at(start + (done + share) * (goal - start))
            states = self._from(through, here)
            if states is not None:
                here, done, share = states, done + share, 2 * share
            elif 0.5 * share >= SHORTEST:
                share *= 0.5
            else:
                here = self._walk(design)
                break
        self.design, self.at = design, here

    def _from(self, design: Design, before: list[Equilibrium]) -> list[Equilibrium] | None:
        """Equilibria of a design next to given ones, or None where the branch does not go there."""
        found = []
        model = design.model()
        for old in before:
            system = prepared(model, old.system.history)
            try:
                state = Equilibrium(system, old.u, old.lam, "Inverse")
            except AnalysisError:
                return None
            self.factorizations += state.factorizations
            if state.negative > old.negative or system.largest_rotation(state.u - old.u) > LEAP:
                return None
            system.commit(state.u, state.lam)
            found.append(state)
        self.results = Results(found[-1].system)  # nodes, supports and mesh are those of the design as it is now
        return found


def rates(design: Design, adjoints: Sequence[Any]) -> Array:
    """Derivatives (functionals, parameters)."""
    names = design.free
    return np.array([[part[name] for name in names] for part in design.derivatives(adjoints, names)])
