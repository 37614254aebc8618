"""Designs drawn from ranges: evenly spread, independent, repeatable."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kirigami as kg


@pytest.mark.parametrize("n", [1, 7, 75])
def test_each_share_of_each_range_holds_one_design(n: int) -> None:
    ranges = {"a": (0.05, 0.2), "b": (-3.0, 5.0), "c": (1e3, 1e6)}
    designs = kg.latin_hypercube(ranges, n, seed=8)
    assert len(designs) == n and all(list(design) == list(ranges) for design in designs)
    for name, (low, high) in ranges.items():
        shares = sorted(int(n * (design[name] - low) / (high - low)) for design in designs)
        assert shares == list(range(n))
    assert designs == kg.latin_hypercube(ranges, n, seed=8)
    assert designs != kg.latin_hypercube(ranges, n, seed=9)


@pytest.mark.parametrize(("low", "high", "n"), [(2, 10, 75), (5, 15, 75), (0, 1, 9), (3, 3, 4), (1, 20, 5)])
def test_whole_numbers_are_equally_frequent(low: int, high: int, n: int) -> None:
    values = [design["cells"] for design in kg.latin_hypercube({"cells": (low, high), "x": (0.0, 1.0)}, n, seed=2)]
    assert all(type(value) is int for value in values) and low <= min(values) and max(values) <= high
    counts = [values.count(value) for value in range(low, high + 1)]
    assert max(abs(count - n / len(counts)) for count in counts) < 2


def test_parameters_do_not_follow_one_another() -> None:
    designs = kg.latin_hypercube({"a": (0.0, 1.0), "b": (0.0, 1.0)}, 400, seed=0)
    a, b = np.array([list(design.values()) for design in designs]).T
    assert abs(np.corrcoef(a, b)[0, 1]) < 4 / np.sqrt(400)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (({}, 3, 0), "at least one range"),
        (({"a": (1.0, 0.0)}, 3, 0), "must rise"),
        (({"a": (1.0, 1.0)}, 3, 0), "must rise"),
        (({"a": (0.0, float("inf"))}, 3, 0), "finite"),
        (({"a": 3.0}, 3, 0), r"\(low, high\)"),
        (({"a": (0, 1, 2)}, 3, 0), r"\(low, high\)"),
        (({1: (0, 1)}, 3, 0), "map names to values"),
        (({"a": (0, 1)}, 0, 0), "n must be a whole number"),
        (({"a": (0, 1)}, 2.5, 0), "n must be a whole number"),
        (({"a": (0, 1)}, 3, -1), "seed must be a whole number"),
        (({"a": (0, 1)}, 3, None), "seed must be a whole number"),
    ],
)
def test_ranges_that_make_no_sense(arguments: Any, words: str) -> None:
    ranges, n, seed = arguments
    with pytest.raises(kg.ModelError, match=words):
        kg.latin_hypercube(ranges, n, seed=seed)
