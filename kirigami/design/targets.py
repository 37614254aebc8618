"""What a design is to do, at which load factors, and what bounds it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kirigami.design.design import Design
from kirigami.errors import ModelError
from kirigami.primitives.checks import (
    require_array,
    require_finite,
    require_items,
    require_positive,
    require_whole,
    shown,
)
from kirigami.primitives.kernel import Array

WISHES = {"max": -1.0, "min": 1.0}
DRAWN = ("ligament", "cut_area")
STEP = 1e-5  # of the range of a parameter, in differences of what is drawn


@dataclass(frozen=True, eq=False)
class Target:
    """A functional at some load factors, and what it should be there.

    Attributes
    ----------
    functional : tuple or callable
        As of :func:`Results.gradient`.
    lam, values : ndarray, shape (k,)
        Load factors, and what is wanted at each; nan where it is only to be large or small.
    scale : float
        By what errors are divided: the largest value wanted, unless given; nan where it is only to be large or small,
        which each search measures by what its start does.
    wish : float
        1 where the functional is to be small, -1 where it is to be large, 0 where it has a value to meet.
    """

    functional: Any
    lam: Array
    values: Array
    scale: float
    wish: float = 0.0

    @property
    def name(self) -> str:
        """The functional in a word."""
        return self.functional[0] if isinstance(self.functional, tuple) else getattr(
            self.functional, "__name__", "function"
        )


def targets_of(given: Any, owner: str = "Inverse") -> list[Target]:
    """Targets out of tuples (functional, load factors, values) or (functional, load factors, values, scale)."""
    listed = [given] if isinstance(given, tuple) and len(given) in (3, 4) and _is_functional(given[0]) else given
    found = []
    for item in require_items(listed, "targets", owner):
        if not isinstance(item, tuple) or len(item) not in (3, 4) or not _is_functional(item[0]):
            raise ModelError(
                f"{owner}: a target is (functional, load factors, values), such as (('force', 'top', 'y'), [0.5, 1], "
                f"[3.0, 4.0]), got {shown(item)}"
            )
        lam = np.atleast_1d(require_array(item[1], (), (None,), name="load factors", owner=owner))
        if isinstance(item[2], str):
            if item[2] not in WISHES:
                raise ModelError(f"{owner}: a target is a value, or 'max' or 'min', got {item[2]!r}")
            scale = require_positive(item[3], "scale", owner) if len(item) == 4 else np.nan
            found.append(Target(item[0], lam, np.full(len(lam), np.nan), scale, WISHES[item[2]]))
            continue
        values = np.broadcast_to(require_array(item[2], (), (len(lam),), name="values", owner=owner), lam.shape)
        largest = float(np.abs(values).max())
        scale = require_positive(item[3], "scale", owner) if len(item) == 4 else largest
        if not scale:
            raise ModelError(f"{owner}: a target of zero has no size: give (functional, load factors, values, scale)")
        found.append(Target(item[0], lam, np.array(values), scale))
    if not found:
        raise ModelError(f"{owner}: give a target at least")
    return found


def _is_functional(item: Any) -> bool:
    return callable(item) or (isinstance(item, tuple) and bool(item) and isinstance(item[0], str))


@dataclass(frozen=True, eq=False)
class Bound:
    """A number of the design or of its equilibria that must stay between two others.

    Attributes
    ----------
    what : tuple or callable
        A functional, or ("ligament",), ("cut_area",) or a function of the design.
    lam : float
        Load factor; nan for what is drawn.
    low, high : float
        Between which it must stay.
    """

    what: Any
    lam: float
    low: float
    high: float

    @property
    def drawn(self) -> bool:
        """Whether it needs no equilibrium."""
        return bool(np.isnan(self.lam))

    def of(self, design: Design) -> float:
        """Its value, where it needs no equilibrium."""
        if callable(self.what):
            return require_finite(self.what(design), "what a constraint returns", "Inverse")
        if self.what[0] == "ligament":
            return design.ligament()
        return float(sum(cut.area for cut in design.sheet().cuts))

    def rates_of(self, design: Design) -> Array:
        """Its derivatives by the parameters."""
        found = []
        for name in design.free:
            step = STEP * design.span(name)
            ahead, behind = (self.of(design._with({name: design.values[name] + way})) for way in (step, -step))
            found.append((ahead - behind) / (2 * step))
        return np.array(found)


def bounds_of(given: Any, owner: str = "Inverse") -> list[Bound]:
    """Bounds out of tuples (what, low, high), or (functional, load factor, low, high)."""
    found = []
    for item in require_items(given, "constraints", owner):
        parts = item if isinstance(item, tuple) else ()
        if len(parts) == 3 and (callable(parts[0]) or parts[0] in DRAWN or parts[0] in [(name,) for name in DRAWN]):
            what = (parts[0],) if isinstance(parts[0], str) else parts[0]
            lam, low, high = np.nan, parts[1], parts[2]
        elif len(parts) == 4 and _is_functional(parts[0]):
            what, lam = parts[0], require_finite(parts[1], "load factor", owner)
            low, high = parts[2], parts[3]
        else:
            raise ModelError(
                f"{owner}: a constraint is ('ligament', low, high), ('cut_area', low, high), (function of the design, "
                f"low, high) or (functional, load factor, low, high), got {shown(item)}"
            )
        ends = [
            edge if value is None else require_finite(value, "bound", owner)
            for value, edge in ((low, -np.inf), (high, np.inf))
        ]
        if not ends[0] < ends[1]:
            raise ModelError(f"{owner}: the constraint {shown(item)} leaves no room")
        found.append(Bound(what, lam, *ends))
    return found


def load_factors(targets: Sequence[Target], bounds: Sequence[Bound]) -> list[float]:
    """All load factors at which equilibria are needed, ascending."""
    wanted = [lam for target in targets if not is_critical(target.functional) for lam in target.lam.tolist()]
    wanted += [bound.lam for bound in bounds if not bound.drawn and not is_critical(bound.what)]
    return sorted(set(wanted))


def critical_events(targets: Sequence[Target], bounds: Sequence[Bound]) -> dict[int, float]:
    """Numbers of the events whose load factors are asked for, and up to which load factor they are looked for."""
    found: dict[int, float] = {}
    asked = [(target.functional, float(target.lam.max())) for target in targets]
    for what, lam in [*asked, *((bound.what, bound.lam) for bound in bounds)]:
        if is_critical(what):
            if len(what) != 2:
                raise ModelError("Inverse: give ('critical', number of the event)")
            number = require_whole(what[1], "the number of the event", "Inverse")
            found[number] = max(lam, found.get(number, -np.inf))
    return found


def is_critical(functional: Any) -> bool:
    """Whether a functional is a load factor of a limit point or a bifurcation."""
    return isinstance(functional, tuple) and bool(functional) and functional[0] == "critical"
