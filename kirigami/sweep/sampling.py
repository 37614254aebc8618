"""Designs for a parameter study, spread evenly over the ranges of their parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_finite, require_mapping, require_whole, shown

MOST = 10_000_000  # designs; more is a slip


def latin_hypercube(ranges: Mapping[str, tuple[float, float]], n: int, *, seed: int) -> list[dict[str, float | int]]:
    """Designs by Latin hypercube sampling: each of n equal shares of every range holds exactly one design.

    Parameters
    ----------
    ranges : mapping of str to (low, high)
        The range of each parameter, by name. Two integers make a whole-numbered parameter, both ends included, whose
        values are as equally frequent as n allows.
    n : int
        Number of designs.
    seed : int
        Seed of the random numbers; the same seed gives the same designs.

    Returns
    -------
    list of dict
        One dict of parameters for each design, ready for :class:`kirigami.Sweep`.

    Raises
    ------
    ModelError
        No ranges, a range without extent or not finite, or `n` or `seed` that is not a whole number.

    Notes
    -----
    McKay, Beckman and Conover, Technometrics 21, 1979; drawn by ``scipy.stats.qmc.LatinHypercube``.

    Examples
    --------
    >>> import kirigami as kg
    >>> designs = kg.latin_hypercube({"cells": (2, 4), "stretch": (0.0, 1.0)}, 3, seed=1)
    >>> sorted(design["cells"] for design in designs)
    [2, 3, 4]
    >>> sorted(int(3 * design["stretch"]) for design in designs)
    [0, 1, 2]
    """
    from scipy.stats import qmc

    require_mapping(ranges, "ranges", "latin_hypercube")
    if not ranges:
        raise ModelError("latin_hypercube: give at least one range, such as {'stretch': (0.05, 0.2)}")
    count = require_whole(n, "n", "latin_hypercube", least=1)
    start = require_whole(seed, "seed", "latin_hypercube", least=0)
    if count > MOST:
        raise ModelError(f"latin_hypercube: n must be at most {MOST}, got {shown(n)}")
    bounds = {name: _bounds(name, limits) for name, limits in ranges.items()}
    random = np.random.default_rng(start)
    try:
        sampler = qmc.LatinHypercube(len(bounds), rng=random)
    except TypeError:  # scipy before 1.15
        sampler = qmc.LatinHypercube(len(bounds), seed=random)
    designs: list[dict[str, float | int]] = []
    for row in sampler.random(count):
        design: dict[str, float | int] = {}
        for share, (name, (low, high, whole)) in zip(row.tolist(), bounds.items()):
            if whole:
                design[name] = int(min(low + np.floor(share * (high - low + 1)), high))
            else:
                design[name] = low + share * (high - low)
        designs.append(design)
    return designs


def _bounds(name: str, limits: Any) -> tuple[float, float, bool]:
    if not isinstance(name, str):
        raise ModelError(f"latin_hypercube: parameters are named by words, not by {shown(name)}")
    if isinstance(limits, (str, bytes)) or not hasattr(limits, "__len__") or len(limits) != 2:
        raise ModelError(f"latin_hypercube: the range of {name} must be (low, high), got {shown(limits)}")
    whole = all(isinstance(limit, (int, np.integer)) and not isinstance(limit, bool) for limit in limits)
    low, high = (require_finite(limit, f"the range of {name}", "latin_hypercube") for limit in limits)
    if low > high or (low == high and not whole):
        raise ModelError(f"latin_hypercube: the range of {name} must rise, got {shown(limits)}")
    return low, high, whole
