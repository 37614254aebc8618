"""Energy set free between two points of a path, and what is told of it.

Between two points of a smooth stable path the potential changes by the work of the drive; what is lost beyond was set
free in snaps. How much of a difference can be told from a bend of the path depends on the increment. Where grips drive,
it is of the order of a hundredth of force times displacement where the increment is a quarter of the way, so that is
the size from which on a snap is told by itself: it is found at any increments, and it is what shows in a curve of the
force. A sheet beyond its lock crackles: wrinkles move on in many snaps far below that size, which no two increments
divide alike. They are told together, with the energy that was set free in all of them.
"""

from __future__ import annotations

import numpy as np

from kirigami.analysis.path.points import Point
from kirigami.analysis.path.run import PathRun
from kirigami.results.step import Event
from kirigami.system.system import System

SNAP, SMALL = "snap", "small snaps"  # kinds of events
NOTABLE = 1e-2  # least energy set free, as a share of force times displacement, of a snap that is told by itself
TOLD = 1e-3  # least energy set free, as a share of the stored energy, that is told of or, where it can be, sought
FORESEEN = 2.0  # energy set free, as a multiple of that, by which a snap is told before it has landed
TOLD_AFTER_DESCENT = 1e-4  # the same where the path was left for a descent
TOLD_AT_LIMIT_LOAD = 1e-5  # ... and forces drive: a limit load is bracketed closely, so little energy is told
DOUBT = 0.3  # error of the work along a path, as a share of the last term of its estimate
STIFFENED, SOFTENED = 0.5, 1.0  # the same where there may be a kink on the way, by how the slope of the force changes
HARDLY = 1e-4  # turn of a member in a difference quotient [rad]


def energy_set_free(
    run: PathRun, before: Point, after: Point, landed: bool, closely: bool
) -> tuple[str, float, float]:
    """Kind of event to tell of, none if it is empty; the energy set free, and its share of the stored energy.

    `landed` and `closely` are whether the increment ended with a descent, and was as short as a snap is bracketed.
    """
    doubt = None if not landed else (DOUBT, DOUBT) if closely else (STIFFENED, SOFTENED)
    released, share, scale = _lost(run, before, after, doubt)
    if not run.system.drive.any():
        least, kind = TOLD_AT_LIMIT_LOAD if landed else TOLD, SNAP
    else:
        least, kind = TOLD_AFTER_DESCENT if landed else TOLD, SNAP if released > NOTABLE * scale else SMALL
    return kind if share > least else "", released, share


def gather(events: list[Event]) -> None:
    """Make one event of the last two that tell of small snaps, if no snap and no turn of the way lies between them."""
    small = [place for place, event in enumerate(events) if event.kind == SMALL]
    if len(small) < 2:
        return
    (one, other), since = (events[place] for place in small[-2:]), events[small[-2] :]
    turned = (one.bracket[1] - one.bracket[0]) * (other.bracket[1] - other.bracket[0]) < 0
    if turned or any(event.kind == SNAP for event in since):
        return
    assert one.energy is not None and other.energy is not None
    bracket, energy = (one.bracket[0], other.bracket[1]), one.energy + other.energy
    message = (
        f"{SMALL} between load factors {bracket[0]:.6g} and {bracket[1]:.6g}: energy of about {energy:.3g} (force "
        f"times length) was set free in all, each time less than {100 * NOTABLE:g} % of force times displacement"
    )
    events[small[-2]] = Event(SMALL, 0.5 * sum(bracket), one.step, message, bracket, energy=energy)
    del events[small[-1]]


def worth_bracketing(run: PathRun, before: Point, after: Point) -> bool:
    """Whether a descent from `before` to `after` set so much energy free that its increment is to be shorter.

    Where grips drive, what the estimate of the work leaves open is no reason for it, and smaller snaps are told where
    they are met, but not sought: a locked sheet has dozens, and each bracket takes several descents.
    """
    if not run.system.drive.any():
        return _lost(run, before, after, (DOUBT, DOUBT))[1] > TOLD_AT_LIMIT_LOAD
    return _lost(run, before, after, (1.0, 1.0))[1] > TOLD


def _lost(
    run: PathRun, before: Point, after: Point, doubt: tuple[float, float] | None
) -> tuple[float, float, float]:
    """Energy lost between two points beyond what a smooth stable path explains, its share of the stored energy, and
    what is stored or force times displacement, whichever is more.

    There the potential changes by the work of the drive. Its rate F is known at both ends, and so is the rate of that,
    which gives the work over a distance h to fourth order: h (F0 + F1) / 2 + h^2 (F0' - F1') / 12. How good this is the
    last term tells, as long as the path is smooth: `doubt` is the share of it that may be error, where the slope of the
    force grew and where it fell. Behind one kink at a share s of h the error is (s (1 - s) / 2 - 1 / 12) h^2 (F1' -
    F0'), which passes for energy set free up to half of the term where the slope grew, and up to all of it where it
    fell. Where the path was not left (no `doubt`), a force that grows all the way is not excluded, which explains up
    to h |F1 - F0| / 2.
    """
    system, distance = run.system, after.state.lam - before.state.lam
    energy, rate, slope = zip(*(_potential(system, point, distance) for point in (before, after)))
    system.history = after.history
    bend = distance**2 * (slope[0] - slope[1]) / 12
    released = energy[0] + 0.5 * (rate[0] + rate[1]) * distance + bend - energy[1]
    if doubt is None:
        explained = abs(bend) + 0.5 * abs((rate[1] - rate[0]) * distance)
    else:
        explained = doubt[0 if bend < 0 else 1] * abs(bend)
    rounding = 1e3 * system.noise * system.length
    stored = max(abs(energy[0]), abs(energy[1]), rounding, 1e-300)
    pulled = max(abs(rate[0] * before.state.lam), abs(rate[1] * after.state.lam))
    return released, released / stored if released > explained else 0.0, max(stored, pulled)


def least_potential(run: PathRun, before: Point, increment: float) -> float:
    """Potential one increment on below which a snap was met that is worth bracketing, told without a landing.

    The forces at the point before and their slope give the potential of a smooth path to third order. Where the sheet
    grows stiffer this is too low, so that fewer snaps are told. What yields or slides grows softer on the way, which no
    slope at its start tells of: there the forces are only taken not to fall.
    """
    system = run.system
    if not system.drive.any():
        return -np.inf
    energy, rate, slope = _potential(system, before, increment)
    if any(kernel.path_dependent for kernel in system.kernels):
        slope = min(slope, 0.0)
    ahead = energy + rate * increment + 0.5 * slope * increment**2
    return ahead - FORESEEN * TOLD * max(abs(energy), abs(ahead))


def _potential(system: System, point: Point, distance: float) -> tuple[float, float, float]:
    """The potential at a point, its rate with the load factor and the change of that, found once."""
    if point.potential is None:
        state, system.history = point.state, point.history
        with np.errstate(all="ignore"):
            value = sum(system.energies(state.u, state.lam).values())
            work = system.potential_rate(state.u, state.lam)
            point.potential = value, work, force_slope(system, point, distance)
    return point.potential


def force_slope(system: System, point: Point, distance: float) -> float:
    """Change of what the drive works with the load factor, along the path: by a difference on the tangent.

    It is so short, also against the `distance` to go, that members hardly turn, and central, so that the false stress
    of a turn falls out.
    """
    state, rate = point.state, point.tangent.rate
    turn = system.largest_rotation(system.motion(rate, 1.0, state.u)) * abs(distance)
    step = abs(distance) * min(1e-3, HARDLY / max(turn, 1e-300))
    ends = [(state.q + way * rate, state.lam + way) for way in (-step, step)]
    low, high = (system.potential_rate(system.displacement(q, lam), lam) for q, lam in ends)
    return (high - low) / (2 * step)
