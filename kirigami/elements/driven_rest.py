"""Rest lengths and rest angles that are driven: what bars, hinges, springs and creases share.

A member without force at r_0 is driven to r_1 with the load factor lam, r(lam) = r_0 + lam (r_1 - r_0): so a wire is
shortened, a fold is told to close. A model that only these drive needs no load.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import numpy as np

from kirigami.primitives.checks import require_finite
from kirigami.primitives.kernel import Array


def targets_of(objects: Sequence[Any], name: str) -> Array | None:
    """Rest values at load factor 1 (n,) and how far each stands held there (n,), both (2, n) with nan for none; None
    where no object is driven."""
    if all(getattr(item, name) is None for item in objects):
        return None
    rows = [(getattr(item, name), item.reached) for item in objects]
    return np.asarray(np.array([[np.nan if value is None else value for value in row] for row in rows]).T)


def driven(rest: Array, targets: Array | None) -> tuple[Array, Array | None]:
    """Rest values (n,) at load factor 0, and their change with it, None where nothing changes."""
    if targets is None:
        return rest, None
    target, reached = targets
    whole = np.where(np.isnan(target), 0.0, target - rest)
    still = ~np.isnan(reached)
    rest = rest + np.where(still, reached, 0.0) * whole
    return rest, np.where(still, 0.0, whole)


def untouched(rest: Array, drive: Array) -> Array:
    """What :func:`driven` makes a rest value and its change of, to be saved."""
    return np.stack([rest + drive, np.full(len(rest), np.nan)])


def held_at(item: Any, name: str, lam: float) -> Any:
    """A driven member as it goes on in a next stage: its rest value stays where the load factor has brought it."""
    if getattr(item, name) is None or item.reached is not None:
        return item
    held = copy.copy(item)
    object.__setattr__(held, "reached", require_finite(lam, "lam", f"{type(item).__name__}.held"))
    return held
