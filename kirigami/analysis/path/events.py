"""What is met between two steps of a path: limit points, bifurcations, snaps.

At both, the tangent stiffness is singular. Where the load factor has an extremum there it is a limit point, else
another path crosses: a bifurcation. Limit points are found where the rate of the load factor vanishes, bifurcations
where the number of negative eigenvalues changes, as told by the signs of the pivots (Sylvester's law of inertia).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kirigami.analysis.modes import nodal_shape
from kirigami.analysis.path.controls import LoadFactorControl
from kirigami.analysis.path.points import Attempt, Point, Tangent
from kirigami.analysis.path.release import energy_set_free
from kirigami.analysis.path.run import PathRun
from kirigami.linalg import SingularMatrixError, factorize, inverse_iteration
from kirigami.primitives.kernel import Array
from kirigami.results.step import Event
from kirigami.system.system import System
from kirigami.words import counted

LIMIT_TOLERANCE = 1e-7  # relative error in load to which limit points are located
BIFURCATION_TOLERANCE = 1e-4  # share of the range of load factors to which bifurcations are located
KINK = 1e-2  # share of the rate at both sides below which none falls at a kink
SAME_PLACE = 0.02  # share of an increment within which a limit point and a change of stability are one
JUMP = 20.0  # growth of the mean speed along an increment beyond which displacements jump
ASIDE = 1e-6  # growth of the critical mode, as a share of all displacements, that shows an imperfection
SETTLED = 1e-4  # change of the critical eigenvalue from one inverse iteration to the next that is small enough
LEAPING = ("newton", "descent", "viscous")  # correctors whose increments may be too long to tell a snap from a bend
FAR = 0.25  # turn off the path from which on a descent is told of as a jump [rad]


@dataclass
class Place:
    """A converged point some way into an increment."""

    way: float
    point: Point
    attempt: Attempt | None = None


class LostPathError(Exception):
    """An equilibrium between two known ones was not found."""


class JumpError(Exception):
    """Two points do not lie on one path: between them the displacements jump."""


def report_events(
    run: PathRun,
    before: Point,
    after: Point,
    increment: float,
    left: Point | None = None,
    strict: bool = True,
    landed: float = 0.0,
    closely: bool = True,
) -> None:
    """Add to the results of `run` what happened between two of its points, one increment apart.

    `left` is the unstable equilibrium at the end of the increment that was left downhill for `after`, if any. With
    `strict` raises a JumpError where `after` or `left` lies on another path, or where that cannot be excluded. `landed`
    is the turn by which a descent left the path on the way to `after` [rad], 0 without one, and `closely` says whether
    its increment was as short as a snap is bracketed.
    """
    if not run.system.conservative:
        return  # without a potential the pivots count nothing
    events, index = run.results.events, len(run.results) - 1
    bracket = (before.state.lam, after.state.lam)
    reached = after if left is None else left
    try:
        leaves = run.settings.on_instability != "follow" and reached.negative > before.negative  # at the first one
        _report_singular_points(run, before, reached, increment, index, leaves, strict)
    except JumpError:
        if strict:
            raise
        if left is None:
            _tell_change(run, before.negative, reached.negative, bracket, index)
    finally:
        run.system.history = after.history
    if left is not None:
        message = (
            f"the path loses its stability between load factors {bracket[0]:.6g} and {bracket[1]:.6g} "
            f"({counted(left.negative, 'negative eigenvalue')}) and was left downhill for a stable equilibrium"
        )
        events.append(Event("switch", 0.5 * sum(bracket), index, message, bracket))
    elif run.settings.on_instability == "switch" and isinstance(run.control, LoadFactorControl) and after.negative:
        message = f"no stable equilibrium was found downhill at load factor {bracket[1]:.6g}: the step is unstable"
        events.append(Event("switch failed", bracket[1], index, message, bracket))
    if isinstance(run.control, LoadFactorControl):
        kind, released, share = energy_set_free(run, before, after, bool(landed), closely)
        if kind:
            what = f"{kind} between load factors {bracket[0]:.6g} and {bracket[1]:.6g}"
            message = (
                f"{what}: energy of {released:.3g} (force times length) was set free, "
                f"{100 * share:.2g} % of what is stored"
            )
            events.append(Event(kind, 0.5 * sum(bracket), index, message, bracket, energy=released))
        elif landed > FAR and run.settings.corrector in LEAPING:
            message = (
                f"jump between load factors {bracket[0]:.6g} and {bracket[1]:.6g}: a member turned {landed:.2g} rad "
                "off the path, in a sharp bend or a snap that sets less energy free than these increments can tell"
            )
            events.append(Event("jump", 0.5 * sum(bracket), index, message, bracket))


def tell_events(
    run: PathRun,
    before: Point,
    after: Point,
    increment: float,
    left: Point | None,
    landed: float = 0.0,
    closely: bool = True,
) -> None:
    """As :func:`report_events`, but an unstable `left` that cannot be traced back to `before` lies on another path."""
    known = len(run.results.events)
    try:
        report_events(run, before, after, increment, left, left is not None, landed, closely)
    except JumpError:
        del run.results.events[known:]
        report_events(run, before, after, increment, None, False, landed, closely)


# ---- singular points


def _report_singular_points(
    run: PathRun, before: Point, after: Point, increment: float, index: int, only_first: bool, strict: bool
) -> None:
    """Locate every limit point and bifurcation on the path from `before` to `after`, or only the first one."""
    bracket = (before.state.lam, after.state.lam)
    rates = _load_rate(run, before, before, after), _load_rate(run, after, before, after)
    limit: Place | None = None
    if not isinstance(run.control, LoadFactorControl) and np.isfinite(rates).all() and rates[0] * rates[1] < 0:
        limit = _locate_limit_point(run, before, after, increment, rates)
        kind = "maximum" if rates[0] > 0 else "minimum"
        message = f"limit point ({kind}) at load factor {limit.point.state.lam:.8g}"
        _append(run, "limit point", limit, index, message, bracket)
        if abs(after.negative - before.negative) == 1:
            return  # the change of stability is the limit point itself
    low, end = Place(0.0, before), Place(increment, after)
    crossings: list[tuple[Place, Place]] = []
    lost = False
    try:
        while low.point.negative != end.point.negative and not (only_first and crossings):
            crossings.append(_locate_crossing(run, before, low, end))
            low = crossings[-1][1]
    except LostPathError:
        if strict:
            raise JumpError from None
        lost = True
    own = None if limit is None else _crossing_at(limit, crossings, increment)
    for near, far in crossings:
        if (near, far) == own:
            continue
        place = min(near, far, key=lambda p: abs(critical_pair(run.system, p.point.tangent)[0]))
        message = (
            f"bifurcation at load factor {place.point.state.lam:.8g} "
            f"({near.point.negative} to {counted(far.point.negative, 'negative eigenvalue')})"
        )
        _append(run, "bifurcation", place, index, message, bracket)
    if lost:
        _tell_change(run, low.point.negative, end.point.negative, (low.point.state.lam, end.point.state.lam), index)


def _crossing_at(
    limit: Place, crossings: list[tuple[Place, Place]], increment: float
) -> tuple[Place, Place] | None:
    """The change of stability that is the limit point itself, since exactly one eigenvalue changes its sign there."""
    single = [pair for pair in crossings if abs(pair[1].point.negative - pair[0].point.negative) == 1]
    if not single:
        return None

    def apart(pair: tuple[Place, Place]) -> float:
        return max(abs(limit.way - place.way) for place in pair)

    nearest = min(single, key=apart)
    return nearest if apart(nearest) <= SAME_PLACE * abs(increment) else None


def _tell_change(run: PathRun, old: int, new: int, bracket: tuple[float, float], index: int) -> None:
    """Add a change of stability that was not located to the events."""
    message = (
        f"{old} to {counted(new, 'negative eigenvalue')} between load factors {bracket[0]:.6g} and {bracket[1]:.6g} "
        "(not located)"
    )
    run.results.events.append(Event("stability change", 0.5 * sum(bracket), index, message, bracket))


def _append(run: PathRun, kind: str, place: Place, index: int, message: str, bracket: tuple[float, float]) -> None:
    """Add a located point with its critical mode to the events."""
    system, point = run.system, place.point
    state = point.state
    system.history = point.history
    iterations = 0 if place.attempt is None else place.attempt.iterations
    residual = system.imbalance(state.u, state.lam)[1]
    step = run.make_step(state.u, state.lam, point.negative, residual, iterations)
    mode = nodal_shape(system, critical_pair(system, point.tangent)[1], point.state.u)
    run.results.events.append(Event(kind, float(state.lam), index, message, bracket, step, mode))


def critical_pair(system: System, tangent: Tangent) -> tuple[float, Array]:
    """Eigenvalue nearest to zero, and its vector (free,) of unit length."""
    try:
        return inverse_iteration(tangent.factor, system.free, 30, SETTLED)
    except SingularMatrixError:
        from scipy.sparse import eye

        # So near to zero that it takes a shift to solve at all.
        matrix = tangent.factor.matrix
        shift = 1e-9 * float(np.abs(matrix.diagonal()).mean())
        factor = factorize((matrix + shift * eye(system.free)).tocsc())
        value, vector = inverse_iteration(factor, system.free, 30, SETTLED)
        return value - shift, vector


def _load_rate(run: PathRun, point: Point, before: Point, after: Point) -> float:
    """Change of the load factor on the tangent of `point`, walked in the sense of the step from before to after."""
    return run.control.load_rate(point.tangent.rate, before.state, after.state)


def _at(run: PathRun, before: Point, way: float) -> Place:
    """The point of the path `way` into the increment that starts from `before`."""
    run.system.history = before.history
    attempt = run.try_increment(before, way)
    tangent = run.tangent_at(attempt)
    if tangent is None:
        raise LostPathError
    return Place(way, Point(attempt.state, tangent, before.history), attempt)


def _locate_limit_point(
    run: PathRun, before: Point, after: Point, increment: float, rates: tuple[float, float]
) -> Place:
    """The place of extreme load factor between two points: regula falsi (Illinois) on the rate of the load factor.

    Where something yields or comes in touch the rate jumps, and no place has a small one: then it is the end of the
    bracket that lies further up, or down.
    """
    low, high = 0.0, increment
    ends = {low: Place(low, before), high: Place(high, after)}
    f_low, f_high = rates
    best, best_rate = Place(low, before), abs(f_low)
    if abs(f_high) < best_rate:
        best, best_rate = Place(high, after), abs(f_high)
    scale = max(abs(before.state.lam), abs(after.state.lam), 1e-300)
    side = 0
    for _ in range(40):
        # Near its zero the rate is linear, so the load factor is off by about half of rate times distance.
        if best_rate * abs(high - low) < LIMIT_TOLERANCE * max(scale, abs(best.point.state.lam)):
            break
        trial = (low * f_high - high * f_low) / (f_high - f_low)
        try:
            place = _at(run, before, trial)
        except LostPathError:
            break
        ends[trial] = place
        rate = _load_rate(run, place.point, before, after)
        if abs(rate) < best_rate:
            best, best_rate = place, abs(rate)
        if rate * f_high < 0:
            low, f_low, f_high = trial, rate, f_high / 2 if side == -1 else f_high
            side = -1
        else:
            high, f_high, f_low = trial, rate, f_low / 2 if side == 1 else f_low
            side = 1
    if best_rate > KINK * min(map(abs, rates)):
        sense = 1.0 if rates[0] > 0 else -1.0
        return max((ends[low], ends[high]), key=lambda place: sense * place.point.state.lam)
    return best


def _locate_crossing(run: PathRun, before: Point, low: Place, high: Place) -> tuple[Place, Place]:
    """The two ends of a short piece of path on which the number of negative eigenvalues first changes.

    Brent's method on the eigenvalue nearest to zero; on which side of the change a point lies, its inertia tells.
    """
    from scipy.optimize import brentq

    first = low.point.negative
    if first == 0 and isinstance(run.control, LoadFactorControl) and _pushed_aside(run, low.point, high.point):
        raise JumpError
    known = {low.way: low, high.way: high}

    def eigenvalue(way: float) -> float:
        place = known.get(way)
        if place is None:
            place = known[way] = _at(run, before, way)
        value = abs(critical_pair(run.system, place.point.tangent)[0])
        return value if place.point.negative == first else -value

    reached = [step.lam for step in run.results.steps] + [high.point.state.lam]
    tolerance = BIFURCATION_TOLERANCE * float(np.ptp(reached))
    near, far, close = low, high, 1e-3 * abs(high.way)
    for _ in range(4):  # the load factor may change faster than the way
        brentq(eigenvalue, near.way, far.way, xtol=0.5 * close, rtol=1e-9, disp=False)
        far = min((p for p in known.values() if p.point.negative != first), key=lambda p: abs(p.way))
        near = max((p for p in known.values() if abs(p.way) < abs(far.way)), key=lambda p: abs(p.way))
        apart = abs(far.point.state.lam - near.point.state.lam)
        if apart <= tolerance:
            break
        close *= 0.5 * tolerance / apart
    for place, sense in ((near, 1.0), (far, -1.0)):  # the search may come from one side, and leave the other far off
        if abs(far.way - near.way) > close:
            eigenvalue(place.way + sense * close * np.sign(high.way))
            far = min((p for p in known.values() if p.point.negative != first), key=lambda p: abs(p.way))
            near = max((p for p in known.values() if abs(p.way) < abs(far.way)), key=lambda p: abs(p.way))
    # An imperfect structure has no bifurcation but two paths with a gap between them, and a step may jump it.
    way = abs(high.point.state.u - before.state.u).max() * (far.way - near.way) / high.way
    if abs(far.point.state.u - near.point.state.u).max() > JUMP * way:
        raise JumpError
    return near, far


def _pushed_aside(run: PathRun, low: Point, high: Point) -> bool:
    """Whether the drive pushes along the critical mode of `low`, a stable point before stability is lost at `high`.

    The stable path then turns aside and crosses no other: the mode grows as c / (lam_c - lam) with the load factor,
    however small c, and the tolerance of equilibrium may hide it or feign it. The eigenvalue falls in proportion to
    lam_c - lam, so c follows without lam_c.
    """
    value, mode = critical_pair(run.system, low.tangent)
    there = float(mode @ (high.tangent.factor.matrix @ mode))
    if not 0 < value or not there < value:
        return False
    aside = abs(float(mode @ run.settled_rate(low))) * value / (value - there) * abs(high.state.lam - low.state.lam)
    moved = float(np.linalg.norm(low.tangent.rate)) * abs(high.state.lam - run.increments.leg)
    return aside > ASIDE * moved
