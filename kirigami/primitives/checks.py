"""Checks of numbers given by users, each a ModelError that names the argument."""

from __future__ import annotations

import math
from typing import Any

from kirigami.errors import ModelError


def require_finite(value: Any, name: str, owner: str) -> float:
    """`value` as a float, or a ModelError that names the argument."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ModelError(f"{owner}: {name} must be a number, got {value!r}") from None
    if not math.isfinite(number):
        raise ModelError(f"{owner}: {name} must be finite, got {number}")
    return number


def require_positive(value: Any, name: str, owner: str) -> float:
    """`value` as a positive float, or a ModelError that names the argument."""
    number = require_finite(value, name, owner)
    if number <= 0:
        raise ModelError(f"{owner}: {name} must be positive, got {number}")
    return number
