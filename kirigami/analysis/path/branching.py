"""Branch switching: the first point of the other path through a bifurcation."""

from __future__ import annotations

from kirigami.analysis.path.controls import ModeControl
from kirigami.analysis.path.points import Attempt, Point, State
from kirigami.analysis.path.run import PathRun
from kirigami.primitives.kernel import Array
from kirigami.results.step import Event, Step

TURNS = 0.05, 0.0125, 0.003, 0.0008, 0.2  # turns of a member by which the mode leads away from the bifurcation
NEAR = 0.02  # share by which the load factor may change in that first step, if a shorter one can be had
STRAIGHT = 0.5  # least cosine between the mode and the way to the point found


def leave_along_mode(run: PathRun, located: Step, mode: Array, sign: int) -> tuple[Point, Attempt] | None:
    """The point of the branch that leaves a located bifurcation along `sign` times its mode (n, 3), if one is found.

    The component along the mode is prescribed and the load factor is an unknown, so the path that the mode is neutral
    on is no solution, and it does not matter whether the load rises or falls on the branch.
    """
    system = run.system
    q = system.unknowns(system.joined(located.u, located.inner))
    origin = State(q, located.lam, system.displacement(q, located.lam))
    direction = sign * system.unknowns(mode)
    shape = system.motion(direction, about=origin.u)
    turn = system.largest_rotation(shape)
    control = ModeControl(origin, direction)
    best: tuple[Point, Attempt] | None = None
    for size in TURNS:
        far = size / turn
        system.history = located.history
        control.begin(origin, far)
        ahead = origin.q + far * direction
        if system.admissible(origin.u, system.displacement(ahead, origin.lam)) < 1:
            continue
        attempt = run.correct(control, State(ahead, origin.lam, system.displacement(ahead, origin.lam)))
        tangent = run.tangent_at(attempt)
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
    system.commit(best[0].state.u, best[0].state.lam)
    best[0].history = system.history
    return best


def switch(
    run: PathRun, events: list[Event], before: Point, after: Point, attempt: Attempt
) -> tuple[Point, Point, Attempt]:
    """Where an eigenvalue has become negative at a bifurcation, the step on to its branch instead of the one made.

    Only for controls with an unknown load factor; at a given one a relaxation finds the stable equilibrium.
    """
    for event in events:
        if event.kind != "bifurcation" or after.negative <= before.negative:
            continue
        assert event.located is not None and event.mode is not None
        found = leave_along_mode(run, event.located, event.mode, 1)
        if found is not None:
            message = f"left at the bifurcation at load factor {event.lam:.6g} for the branch along its mode"
            run.results.events.append(Event("switch", event.lam, event.step, message, event.bracket))
            q = run.system.unknowns(run.system.joined(event.located.u, event.located.inner))
            lam = event.located.lam
            origin = Point(State(q, lam, run.system.displacement(q, lam)), before.tangent, event.located.history)
            return origin, *found
    run.system.history = after.history
    return before, after, attempt
