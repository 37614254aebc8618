"""A sheet whose folds do not rest flat, folded between its grips before it is pulled."""

from __future__ import annotations

import numpy as np

from kirigami.analysis.path.methods import LoadControl
from kirigami.errors import ConvergenceError
from kirigami.model.constraints import Fix, Prescribe, Tie
from kirigami.model.model import Model
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import Node
from kirigami.results.step import Step
from kirigami.study.grips import Grips


def fold(
    model: Model, grips: Grips, pull: float, amplitude: float | None, seed: int, tol: float
) -> tuple[list[Node], list[Node], Step, Array]:
    """Let a sheet fold while one grip slides, then drive that grip on from there.

    The grips clamp the sheet. The moved one slides, without turning, along the pull (in the plane, where the pull is
    oblique), so that it bears no force when the pull begins.

    Parameters
    ----------
    model : Model
        Made from a mesh with folds, without supports; gets supports, imperfection and drive.
    grips : Grips
        Where it is held.
    pull : float
        How far the moved grip is to go from the folded sheet [length].
    amplitude, seed
        Of the imperfection, see :meth:`kirigami.Model.imperfect`.
    tol : float
        Relative residual.

    Returns
    -------
    held, moved : list of Node
        Nodes of the grips.
    start : Step
        The folded sheet, to go on from.
    shift : ndarray, shape (3,)
        How far the moved grip went while the sheet folded [length].

    Raises
    ------
    ConvergenceError
        The sheet does not fold.
    """
    held, moved = grips.nodes(model)
    sliding = "".join(axis for axis, share in zip("xy", grips.direction.tolist()) if share)
    still = "".join(axis for axis in "xyz" if axis not in sliding)
    tie = Tie(moved[1:], moved[0], sliding)
    model.add(Fix(held, clamp=True), Fix(moved, still, clamp=True), tie)
    model.imperfect(amplitude, seed=seed)
    try:
        folded = LoadControl(model, targets=[1.0], step=1.0, tol=tol).run()
    except ConvergenceError as error:
        raise ConvergenceError(
            f"the sheet does not fold to the rest angles of its folds: {error}", results=error.results,
            history=error.history, worst_nodes=error.worst_nodes, hint="smaller angles, or a finer mesh, may help",
        ) from error  # fmt: skip
    start = folded[-1]
    shift: Array = np.append(np.asarray(start.u[model.index([moved[0]])[0], :2]), 0.0)
    model.remove(tie)
    model.hold(start)
    values = {axis: float(shift["xy".index(axis)]) for axis in sliding}
    values = {axis: value + pull * float(grips.direction["xy".index(axis)]) for axis, value in values.items()}
    model.add(Prescribe(moved, **values))
    return held, moved, start, shift
