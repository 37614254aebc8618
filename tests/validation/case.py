"""A case of validation: a published number, the model that shall reach it on each rung, and how near it must come.

A module of this folder is one source. It lists its cases; its tests run them, and `tools/validation.py` writes the page
of the docs from the same list. A rung that cannot hold a case is listed too, as a miss with its cause: its test fails
as soon as that rung gets worse than stated, or does hold the case.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import kirigami as kg


@dataclass(frozen=True)
class Bound:
    """Largest relative error of one rung; where it misses the case, its cause, and the error it must not exceed."""

    error: float
    miss: str = ""
    long: bool = False


@dataclass(frozen=True)
class Found:
    """What a run gave: the quantities (places, quantities) or one number, and the results for the picture."""

    values: Any
    results: kg.Results | None = None
    nodes: int = 0


@dataclass(frozen=True)
class Outcome:
    """A run judged: largest relative error, corner nodes, CPU seconds."""

    error: float
    found: Found
    nodes: int
    seconds: float


@dataclass(frozen=True)
class Case:
    """One published number or table, and its bounds by rung."""

    name: str
    reference: Any  # a number, or a table (places, quantities)
    quantity: str
    solve: Callable[[str], Found]
    bounds: Mapping[str, Bound]
    at: Sequence[float] = ()  # the places of a table: load factors, deflections
    axis: str = "load factor"
    whole: bool = False  # whether errors are shares of the largest value of a column, not of each value
    holds: float = 0.02  # the bound that a rung which does not miss the case keeps, for the page
    most: int = 2000  # corner nodes that the trusted rung may take

    def run(self, rung: str) -> Outcome:
        """Solve it on one rung, and judge."""
        begin = time.process_time()
        found = self.solve(rung)
        spent = time.process_time() - begin
        nodes = found.nodes or (0 if found.results is None else len(found.results.rest))
        return Outcome(self.error(found.values), found, nodes, spent)

    def error(self, values: Any) -> float:
        """Largest relative error."""
        wanted = np.atleast_2d(np.asarray(self.reference, float).T).T
        got = np.asarray(values, float).reshape(wanted.shape)
        size = np.abs(wanted).max(axis=0) if self.whole else np.abs(wanted)
        return float((np.abs(got - wanted) / size).max())

    def check(self, rung: str) -> None:
        """What the test of this case on this rung asserts."""
        bound, outcome = self.bounds[rung], self.run(rung)
        error = outcome.error
        assert rung != "shell" or outcome.nodes <= self.most, f"{outcome.nodes} nodes"
        assert error <= bound.error, f"{100 * error:.2f} % off, {100 * bound.error:g} % are allowed"
        if bound.miss:
            assert error > self.holds, f"only {100 * error:.2f} % off: this is no miss any more"


def each_rung(cases: Sequence[Case]) -> Any:
    """A test of every case on every rung."""
    rows = [
        pytest.param(case, rung, id=f"{case.name}, {rung}", marks=[pytest.mark.long] if bound.long else [])
        for case in cases
        for rung, bound in case.bounds.items()
    ]
    return pytest.mark.parametrize("case, rung", rows)
