"""A sheet whose folds do not rest flat folds before anything is done to it."""

from __future__ import annotations

import numpy as np

from kirigami.analysis.path.methods import LoadControl
from kirigami.errors import ConvergenceError
from kirigami.model.constraints import Constraint, Fix, Prescribe, Tie
from kirigami.model.model import Model
from kirigami.model.turn import Turn
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES, Node
from kirigami.results.step import Step


def fold(model: Model, grip: list[Node], tol: float) -> tuple[Step, Array]:
    """Let a sheet fold to where its folds make no moment, as far as its supports allow, and set its drive on there.

    What is driven is let go meanwhile: a grip slides as one along the axes that it is driven on, or turned about, what
    is lifted is free, and weight that grows is away. Then the drive counts from the folded sheet, so that it bears no
    force at first.

    Parameters
    ----------
    model : Model
        A sheet with folds, supports, drive and imperfection.
    grip : list of Node
        The nodes of the grip that is driven; none where there is no grip.
    tol : float
        Relative residual.

    Returns
    -------
    start : Step
        The folded sheet, to go on from.
    shift : ndarray, shape (3,)
        How far the grip went while the sheet folded [length].

    Raises
    ------
    ConvergenceError
        The sheet does not fold.
    """
    drive = [item for item in model.constraints if _drives(item)]
    loads = [item for item in model.loads if not item.constant]
    model.remove(*drive, *loads)
    gripped = set(map(id, grip))
    meanwhile: list[Constraint] = []
    for item in drive:
        slides = _slides(item)
        if isinstance(item, Turn):
            still = "".join(axis for axis in AXES if axis not in slides)
            meanwhile.append(Fix(item.group, still, clamp=item.clamp))
        if len(item.group) > 1 and all(id(node) in gripped for node in item.group):
            meanwhile.append(Tie(item.group[1:], item.group[0], slides))
    model.add(*meanwhile)
    try:
        start = LoadControl(model, targets=[1.0], step=1.0, tol=tol).run()[-1]
    except ConvergenceError as error:
        raise ConvergenceError(
            f"the sheet does not fold to the rest angles of its folds: {error}", results=error.results,
            history=error.history, worst_nodes=error.worst_nodes, hint="smaller angles or a finer mesh may help",
        ) from error  # fmt: skip
    model.remove(*meanwhile)
    model.hold(start)
    model.add(*loads)
    u = np.asarray(start.u)
    for item in drive:
        rows = model.index(item.group)
        if isinstance(item, Turn):
            by = item.shift + u[rows].mean(axis=0)
            model.add(Turn(item.group, item.angle, item.axis, item.about, by, clamp=item.clamp))
            continue
        there = {axis: values + u[rows, "xyz".index(axis)] for axis, values in item.values.items()}
        model.add(Prescribe(item.group, **there, clamp=item.clamp))
    shift: Array = u[model.index(grip)].mean(axis=0) if grip else np.zeros(3)
    return start, shift


def _slides(item: Constraint) -> str:
    """The axes along which what is driven is free while a sheet folds."""
    if isinstance(item, Turn):
        return "".join(axis for axis, of, by in zip(AXES, item.axis, item.shift) if of or by)
    return "".join(item.values)


def _drives(item: Constraint) -> bool:
    return not item.constant and any(np.any(values) for values in item.values.values())
