"""The equilibria of a design as it changes: gone on from those before, and walked anew where their branch ends.

The trap of inverse design is the branch: a sheet that buckled into one shape stays in it while its cuts change, up to
where that shape ends. So each design goes on from the last one accepted, in shorter and shorter steps; where none is
found, where stability is lost or the shape leaps, the sheet is walked from flat once more, and that is told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from kirigami.design.asked import Asked, asked
from kirigami.design.design import Design
from kirigami.errors import AnalysisError
from kirigami.primitives.kernel import Array
from kirigami.results.gradients.critical import CriticalPoint, event_of
from kirigami.results.gradients.equilibrium import Equilibrium, prepared
from kirigami.results.results import Results

SHORTEST = 0.2  # share of the way to a new design below which its sheet is walked anew
LEAP = 0.6  # turn of a member from one design to the next beyond which it is another shape [rad]
State = tuple[list[Equilibrium], dict[int, CriticalPoint]]


class Branch:
    """Equilibria of a design at load factors, and critical points on its path, which follow it.

    Attributes
    ----------
    at : list of Equilibrium
        The equilibria of the last design, one for each load factor.
    points : dict of int to CriticalPoint
        Limit points and bifurcations, by their number among the events of a walk from flat.
    walks, factorizations : int
        Walks from flat, and tangents factorised, so far.
    """

    def __init__(self, design: Design, lams: Sequence[float], critical: Mapping[int, float] = MappingProxyType({})):
        """`critical`: numbers of events, and how far one must walk to meet them."""
        self.lams, self._critical = list(lams), dict(critical)
        self.walks = self.factorizations = 0
        self.design = design
        self.at, self.points = self._walk(design)

    def _walk(self, design: Design) -> State:
        """From flat, with every equilibrium to the last digits."""
        self.walks += 1
        res = design.walk(sorted({*self.lams, *self._critical.values()}))
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
        points = {}
        for number in self._critical:
            event = event_of(res, ("critical", number), "Inverse")
            assert event.located is not None
            points[number] = CriticalPoint(prepared(model, event.located.history), event, "Inverse")
        return found, points

    def go_to(self, design: Design) -> None:
        """Follow the design; raises where neither a branch goes there nor a walk from flat."""
        start, goal = self.design.vector, design.vector
        here, done, share = (self.at, self.points), 0.0, 1.0
        while done < 1.0:
            share = min(share, 1.0 - done)
            through = design if done + share >= 1.0 else design.at(start + (done + share) * (goal - start))
            states = self._from(through, *here)
            if states is not None:
                here, done, share = states, done + share, 2 * share
            elif 0.5 * share >= SHORTEST:
                share *= 0.5
            else:
                here = self._walk(design)
                break
        self.design, (self.at, self.points) = design, here

    def _from(self, design: Design, before: list[Equilibrium], points: dict[int, CriticalPoint]) -> State | None:
        """Equilibria and points of a design next to given ones, or None where the branch does not go there."""
        found: list[Equilibrium] = []
        critical: dict[int, CriticalPoint] = {}
        model = design.model()
        try:
            for old in before:
                system = prepared(model, old.system.history)
                state = Equilibrium(system, old.u, old.lam, "Inverse")
                self.factorizations += state.factorizations
                if state.negative > old.negative or system.largest_rotation(state.u - old.u) > LEAP:
                    return None
                system.commit(state.u)
                found.append(state)
            for number, point in points.items():
                critical[number] = CriticalPoint.next_to(point, prepared(model, point.system.history))
        except AnalysisError:
            return None
        system = found[-1].system if found else next(iter(critical.values())).system
        self.results = Results(system)  # nodes, supports and mesh are those of the design as it is now
        return found, critical

    def asked(self, wanted: Sequence[tuple[Any, float]], slopes: bool = True) -> list[Asked]:
        """Functionals, each at one of the load factors, or critical load factors up to there."""
        found: list[Any] = [None] * len(wanted)
        by_state: dict[int, list[int]] = {}
        for number, (functional, lam) in enumerate(wanted):
            if isinstance(functional, tuple) and functional[0] == "critical":
                point = self.points[functional[1]]
                parts = [(1.0, adjoint) for adjoint in point.adjoints()] if slopes else []
                found[number] = Asked(point.lam, parts)
            else:
                by_state.setdefault(self.lams.index(lam), []).append(number)
        for state, numbers in by_state.items():
            told = asked([wanted[number][0] for number in numbers], self.at[state], self.results, slopes)
            for number, answer in zip(numbers, told):
                found[number] = answer
        return found


def rates(design: Design, adjoints: Sequence[Any]) -> Array:
    """Derivatives (functionals, parameters)."""
    names = design.free
    return np.array([[part[name] for name in names] for part in design.derivatives(adjoints, names)])
