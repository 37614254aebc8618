"""Loops that Numba compiles (extra "fast"): whether they are, and how; only what has asked so imports files of them."""

from __future__ import annotations

import importlib.util
import os
from typing import Any


def compiles() -> bool:
    """Whether loops are compiled: Numba is installed, and the environment variable KIRIGAMI_COMPILED is not 0."""
    return os.environ.get("KIRIGAMI_COMPILED") != "0" and importlib.util.find_spec("numba") is not None


def compiler(**options: Any) -> Any:
    """Decorator of loops that are compiled once a machine; plain Python without Numba, which nobody calls: too slow."""
    try:
        from numba import njit
    except ImportError:
        return lambda function: function
    return njit(cache=True, error_model="numpy", **options)
