"""Where the shapes lead when the pull is let down or goes on, and which of them a snap joins."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kirigami.analysis.path.methods import LoadControl
from kirigami.errors import KirigamiError, KirigamiWarning
from kirigami.model.model import Model
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.step import Step
from kirigami.study.shape.relaxation import Relaxer

BEYOND = 1.25  # load factor up to which a shape is followed, over that of the search
LOST = ("snap", "small snaps", "jump")  # events at which a path goes over to another shape


@dataclass(frozen=True, eq=False)
class Branch:
    """A shape followed in the pull, as far as it is one path.

    Attributes
    ----------
    shape : int
        Number of the shape.
    lam : ndarray, shape (k,)
        Load factors, ascending.
    energy, force : ndarray, shape (k,)
        Energy [force length] and force of the drive [force] there.
    """

    shape: int
    lam: Array
    energy: Array
    force: Array


@dataclass(frozen=True)
class Link:
    """A snap from one shape to another.

    Attributes
    ----------
    shape : int
        Number of the shape that is lost.
    lam : float
        Load factor at which it is lost.
    energy : float or None
        What the snap sets free [force length]; None where it is too little to tell.
    leads_to : int or None
        Number of the shape that there is once the pull is back where it was; None for one that is not known.
    """

    shape: int
    lam: float
    energy: float | None
    leads_to: int | None


def follow(
    model: Model, step: Step, shape: int, tol: float, recognise: Callable[[Step], int | None]
) -> tuple[Branch, list[Link]]:
    """Follow a shape down to no pull and up beyond, and from behind the first snap of each way back.

    Parameters
    ----------
    model : Model
        The model the step is of.
    step : Step
        The shape, stable.
    shape : int
        Its number.
    tol : float
        Relative residual of stored steps.
    recognise : callable
        The number of the known shape that a step at the load factor of the search is.
    """
    measure = Relaxer(model, step.lam, tol)
    ways, links = [], []
    for end in (0.0, BEYOND * step.lam):
        results = _run(model, step, end, tol)
        lost = next((event for event in results.events if event.kind in LOST), None)
        last = len(results) if lost is None else lost.step + 1
        ways.append(results.steps[:last] if end else results.steps[:last][::-1])
        if lost is not None and lost.step + 1 < len(results):
            back = _run(model, results[lost.step + 1], step.lam, tol)
            there = back[-1] if len(back) and abs(back[-1].lam - step.lam) < 1e-9 * abs(step.lam) else None
            leads_to = None if there is None else recognise(there)
            links.append(Link(shape, float(lost.lam), lost.energy, leads_to))
    steps = [*ways[0][:-1], *ways[1]]
    values = [measure.energy_and_force(one) for one in steps]
    lam = np.array([one.lam for one in steps])
    return Branch(shape, lam, np.array([e for e, _ in values]), np.array([f for _, f in values])), links


def _run(model: Model, step: Step, to: float, tol: float) -> Results:
    """A path from a step to a load factor, as far as it goes."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KirigamiWarning)  # where it ends early, the branch ends
        try:
            return LoadControl(model, to=to, start=step, tol=tol, on_instability="switch").run(on_failure="return")
        except KirigamiError as error:
            found = getattr(error, "results", None)
            if not isinstance(found, Results) or not len(found):
                raise
            return found
