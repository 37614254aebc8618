"""The optimisers behind an inverse problem: SciPy's, and the method of moving asymptotes of NLopt."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from typing import Any

import numpy as np

from kirigami.design.design import Design
from kirigami.design.targets import Bound, Target
from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array

METHODS = ("least squares", "slsqp", "mma")
FLAT = 1e-12  # change of what is to be small, at which a search ends
NEAR = 1e-7  # change of the parameters, over their ranges
DEAR = 1e6  # what a design that does not exist counts


class OutOfEvaluationsError(Exception):
    """As many designs were tried as allowed."""


class GoodEnoughError(Exception):
    """The best design meets its targets so closely that no better one is looked for."""


def chosen_method(method: str, design: Design, targets: Sequence[Target], bounds: Sequence[Bound]) -> str:
    """The method for a problem, or a ModelError where the one given cannot serve it."""
    plain = not bounds and not any(target.wish for target in targets)
    installed = importlib.util.find_spec("nlopt") is not None
    if method == "auto":
        if plain:
            return "least squares"
        return "mma" if installed else "slsqp"
    if method == "least squares" and not plain:
        raise ModelError("Inverse: least squares knows no constraints and no 'max' or 'min': take 'slsqp' or 'mma'")
    if method == "mma" and not installed:
        raise ModelError("Inverse: method='mma' needs NLopt: pip install 'kirigami-mechanics[design]'")
    return method


def optimise(method: str, search: Any) -> str:
    """Run a search with the parameters divided by their ranges; "closest" where it ended by itself."""
    design = search.design
    span = np.array([design.span(name) for name in design.free])
    ends = np.array([design.bounds[name] for name in design.free]) / span[:, None]
    start = search.best.x / span
    try:
        {"least squares": _least_squares, "slsqp": _slsqp, "mma": _mma}[method](search, span, ends, start)
    except GoodEnoughError:
        pass
    return "closest"


def _least_squares(search: Any, span: Array, ends: Array, start: Array) -> None:
    from scipy.optimize import least_squares

    count = len(search.best.errors)
    kept: dict[bytes, Array] = {}

    def errors(x: Array) -> Array:
        trial = search.trial(x * span)
        if trial is None:
            return np.full(count, np.nan)  # the search tries a shorter step
        kept[x.tobytes()] = trial.slopes * span
        return np.asarray(trial.errors)

    def slopes(x: Array) -> Array:
        return kept[x.tobytes()]

    off = 1e-10  # the search starts inside
    least_squares(
        errors, np.clip(start, ends[:, 0] + off, ends[:, 1] - off), jac=slopes, bounds=(ends[:, 0], ends[:, 1]),
        method="trf", x_scale=0.2, max_nfev=10 * search.problem.evaluations, xtol=NEAR, ftol=FLAT, gtol=FLAT,
    )  # fmt: skip


def _rows(search: Any) -> list[tuple[int, float, float]]:
    """One-sided bounds as (number, sign, offset): sign * value + offset must not be positive."""
    found = []
    for number, bound in enumerate(search.problem.constraints):
        if np.isfinite(bound.high):
            found.append((number, 1.0, -bound.high))
        if np.isfinite(bound.low):
            found.append((number, -1.0, bound.low))
    return found


def _sizes(search: Any) -> Array:
    """By what the bounds are divided."""
    values = np.abs(search.best.bounds)
    return np.where(values > 0, values, 1.0)


def _slsqp(search: Any, span: Array, ends: Array, start: Array) -> None:
    from scipy.optimize import minimize

    size, rows = _sizes(search), _rows(search)

    def worth(x: Array) -> tuple[float, Array]:
        trial = search.trial(x * span)
        if trial is None:
            return DEAR, np.zeros(len(x))
        value, slope = search.wishes(trial)
        return value, slope * span

    def bound(x: Array) -> Array:
        trial = search.trial(x * span)
        if trial is None:
            return np.full(len(rows), -DEAR)
        return np.array([-(sign * trial.bounds[k] + offset) / size[k] for k, sign, offset in rows])

    def bound_slopes(x: Array) -> Array:
        trial = search.trial(x * span)
        if trial is None:
            return np.zeros((len(rows), len(x)))
        return np.array([-sign * trial.bound_slopes[k] * span / size[k] for k, sign, _ in rows])

    minimize(
        worth, start, jac=True, bounds=list(zip(*ends.T)), method="SLSQP",
        constraints=[{"type": "ineq", "fun": bound, "jac": bound_slopes}] if rows else (),
        options={"maxiter": search.problem.evaluations, "ftol": 1e-10},
    )  # fmt: skip


def _mma(search: Any, span: Array, ends: Array, start: Array) -> None:
    import nlopt  # type: ignore[import-untyped, unused-ignore]

    size, rows = _sizes(search), _rows(search)
    raised: list[BaseException] = []
    machine = nlopt.opt(nlopt.LD_MMA, len(start))

    def guarded(x: Array) -> Any:
        try:
            return search.trial(x * span)
        except BaseException as error:  # NLopt swallows what is raised in its functions
            raised.append(error)
            raise nlopt.ForcedStop from None

    def worth(x: Array, slope: Array) -> float:
        trial = guarded(x)
        if trial is None:
            slope[:] = 0.0
            return DEAR
        value, rate = search.wishes(trial)
        if slope.size:
            slope[:] = rate * span
        return float(value)

    def row(number: int, sign: float, offset: float) -> Any:
        def bound(x: Array, slope: Array) -> float:
            trial = guarded(x)
            if trial is None:
                slope[:] = 0.0
                return DEAR
            if slope.size:
                slope[:] = sign * trial.bound_slopes[number] * span / size[number]
            return float((sign * trial.bounds[number] + offset) / size[number])

        return bound

    machine.set_min_objective(worth)
    machine.set_lower_bounds(ends[:, 0])
    machine.set_upper_bounds(ends[:, 1])
    for number, sign, offset in rows:
        machine.add_inequality_constraint(row(number, sign, offset), 1e-8)
    machine.set_xtol_rel(1e-5)
    machine.set_ftol_rel(1e-7)
    try:
        machine.optimize(np.clip(start, ends[:, 0], ends[:, 1]))
    except (nlopt.ForcedStop, nlopt.RoundoffLimited, RuntimeError):
        if raised:
            raise raised[0] from None
