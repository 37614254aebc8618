"""What is met between two steps of a path: limit points, changes of stability, snaps."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from kirigami.analysis.control import ArcLengthControl, Control, LoadFactorControl
from kirigami.analysis.state import Attempt, Point, State, Tangent
from kirigami.kernel import Array
from kirigami.results import Event, Results
from kirigami.system import System

LIMIT_TOLERANCE = 1e-7  # relative error in load to which limit points are located
SNAP = 1e-3  # least energy set free, as a share of the stored energy, that counts as a snap


class Walker(Protocol):
    """What is asked of the path analysis that walks."""

    system: System
    found: Results
    control: Control

    def try_increment(self, before: Point, increment: float) -> Attempt: ...

    def tangent_at(self, attempt: Attempt) -> Tangent | None: ...


def report_events(path: Walker, before: Point, after: Point, increment: float, left_unstable: int = 0) -> None:
    """Add to the results of `path` what happened between two of its points, one increment apart."""
    events, index = path.found.events, len(path.found) - 2
    bracket = (before.state.lam, after.state.lam)
    if left_unstable:
        message = (
            f"the path loses its stability between load factors {bracket[0]:.6g} and {bracket[1]:.6g} "
            f"({left_unstable} negative eigenvalues) and was left downhill for a stable equilibrium"
        )
        events.append(Event("switch", 0.5 * sum(bracket), index, message, bracket))
    if isinstance(path.control, LoadFactorControl):
        released, share = _energy_set_free(path, before, after)
        if share > SNAP:
            message = (
                f"snap between load factors {bracket[0]:.6g} and {bracket[1]:.6g}: "
                f"energy of {released:.3g} was set free ({100 * share:.2g} %)"
            )
            events.append(Event("snap", 0.5 * sum(bracket), index, message, bracket))
    else:
        rates = _load_rate(path, before, before, after), _load_rate(path, after, before, after)
        if np.isfinite(rates).all() and rates[0] * rates[1] < 0:
            found = _locate_limit_point(path, before, after, increment, rates)
            kind = "maximum" if rates[0] > 0 else "minimum"
            message = f"limit point ({kind}) at load factor {found.lam:.8g}"
            u = np.zeros((len(found.u), 3))
            u[:, : found.u.shape[1]] = found.u
            events.append(Event("limit point", found.lam, index, message, bracket, u))
            if abs(after.negative - before.negative) == 1:
                return  # the change of stability is the limit point itself
    if before.negative != after.negative:
        message = (
            f"{before.negative} to {after.negative} negative eigenvalues between load factors "
            f"{bracket[0]:.6g} and {bracket[1]:.6g}"
        )
        events.append(Event("stability change", 0.5 * sum(bracket), index, message, bracket))


def _energy_set_free(path: Walker, before: Point, after: Point) -> tuple[float, float]:
    """Energy lost between two points beyond what a smooth stable path explains, and its share of the stored energy.

    There the potential changes by the work of the drive, which the trapezoidal rule knows up to the change of force.
    """
    system = path.system
    energy, rate = [], []
    for point in (before, after):
        system.history = point.history
        energy.append(sum(system.energies(point.state.u, point.state.lam).values()))
        rate.append(system.potential_rate(point.state.u, point.state.lam))
    distance = after.state.lam - before.state.lam
    released = energy[0] + 0.5 * (rate[0] + rate[1]) * distance - energy[1]
    explained = 0.5 * abs((rate[1] - rate[0]) * distance)
    return released, (released - explained) / max(abs(energy[1]), 1e-300)


def _load_rate(path: Walker, point: Point, before: Point, after: Point) -> float:
    """Change of the load factor on the tangent of `point`, walked in the sense of the step from before to after."""
    control = path.control
    step = after.state.u - before.state.u
    if isinstance(control, ArcLengthControl):
        along = control.along(point.tangent.rate)
        return float(np.sign((along * step).sum()) / np.linalg.norm(along))
    ends = [control.value(p.state.q, p.state.lam) for p in (before, after)]
    return control.predict(1.0, point.tangent.rate) * float(np.sign(ends[1] - ends[0]))


def _locate_limit_point(
    path: Walker, before: Point, after: Point, increment: float, rates: tuple[float, float]
) -> State:
    """The state of extreme load factor between two points: regula falsi (Illinois) on the rate of the load factor."""
    low, high = 0.0, increment
    f_low, f_high = rates
    best, best_rate = (after.state, abs(f_high)) if abs(f_high) < abs(f_low) else (before.state, abs(f_low))
    scale = max(abs(before.state.lam), abs(after.state.lam), 1e-300)
    side = 0
    try:
        for _ in range(40):
            # Near its zero the rate is linear, so the load factor is off by about half of rate times distance.
            if best_rate * abs(high - low) < LIMIT_TOLERANCE * max(scale, abs(best.lam)):
                break
            trial = (low * f_high - high * f_low) / (f_high - f_low)
            path.system.history = before.history
            _keep_direction(path, after.state.u - before.state.u)
            attempt = path.try_increment(before, trial)
            tangent = path.tangent_at(attempt)
            if tangent is None:
                break
            rate = _load_rate(path, Point(attempt.state, tangent, before.history), before, after)
            if abs(rate) < best_rate:
                best, best_rate = attempt.state, abs(rate)
            if rate * f_high < 0:
                low, f_low, f_high = trial, rate, f_high / 2 if side == -1 else f_high
                side = -1
            else:
                high, f_high, f_low = trial, rate, f_low / 2 if side == 1 else f_low
                side = 1
    finally:
        path.system.history = after.history
    return best


def _keep_direction(path: Walker, step: Array) -> None:
    if isinstance(path.control, ArcLengthControl):
        path.control.direction = step
