"""Branch switching: the first point of the other path through a bifurcation."""

from __future__ import annotations

from typing import Protocol

from kirigami.analysis.control import Control, ModeControl
from kirigami.analysis.state import Attempt, Point, State, Tangent
from kirigami.kernel import Array
from kirigami.results import Step
from kirigami.system import System

TURNS = 0.05, 0.0125, 0.003, 0.0008, 0.2  # turns of a member by which the mode leads away from the bifurcation
NEAR = 0.02  # share by which the load factor may change in that first step, if a shorter one can be had
STRAIGHT = 0.5  # least cosine between the mode and the way to the point found


class Corrector(Protocol):
    """What is asked of the path analysis that walks."""

    system: System

    def correct(self, control: Control, state: State) -> Attempt: ...

    def tangent_at(self, attempt: Attempt) -> Tangent | None: ...


def leave_along_mode(path: Corrector, located: Step, mode: Array, sign: int) -> tuple[Point, Attempt] | None:
    """The point of the branch that leaves a located bifurcation along `sign` times its mode (n, 3), if one is found.

    The component along the mode is prescribed and the load factor is an unknown, so the path that the mode is neutral
    on is no solution, and it does not matter whether the load rises or falls on the branch.
    """
    system = path.system
    q = system.unknowns(located.u)
    origin = State(q, located.lam, system.displacement(q, located.lam))
    direction = sign * system.unknowns(mode)
    shape = system.displacement(direction, 0.0) - system.displacement(0 * direction, 0.0)
    turn = system.largest_rotation(shape)
    control = ModeControl(origin, direction)
    best: tuple[Point, Attempt] | None = None
    for size in TURNS:
        far = size / turn
        system.history = located.history
        control.begin(origin, far)
        ahead = origin.q + far * direction
        attempt = path.correct(control, State(ahead, origin.lam, system.displacement(ahead, origin.lam)))
        tangent = path.tangent_at(attempt)
        if tangent is None:
            continue
        way = attempt.state.u - origin.u
        if float((way * shape).sum()) >= STRAIGHT * float((way**2).sum() * (shape**2).sum()) ** 0.5:
            best = Point(attempt.state, tangent, located.history), attempt
            if abs(attempt.state.lam - origin.lam) <= NEAR * abs(origin.lam):
                break
        if best is not None and size == TURNS[-2]:
            break
    if best is None:
        return None
    system.history = located.history
    system.commit(best[0].state.u)
    best[0].history = system.history
    return best
