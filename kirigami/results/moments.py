"""The moment that a support puts on the structure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.clamp_hinge import HeldEdgeKernel, held_edges
from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array, Kernel
from kirigami.primitives.node import vector_of
from kirigami.primitives.rotation import turned
from kirigami.results.supports import carried_by

if TYPE_CHECKING:
    from kirigami.results.record import Nodes
    from kirigami.results.results import Results
    from kirigami.results.step import Step

TURN = 1e-4  # rotation [rad] over which a difference tells a rate


def moment(results: Results, nodes: Nodes, about: Sequence[float] | Array | None = None) -> Array:
    """Moment of the support on the structure, with that of clamps.

    Parameters
    ----------
    nodes : Node, int, str, or sequence of Node or int
        The supported nodes, as for :meth:`kirigami.Results.reaction`: such as those of a grip.
    about : array_like, shape (3,) or (2,), optional
        The point about which [length]; None takes the centroid of the nodes where they are at each step.

    Returns
    -------
    ndarray, shape (s, 3)
        Moment [force length] at each step.

    Raises
    ------
    ModelError
        As for :meth:`kirigami.Results.reaction`, or a point that is none.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b, c = m.add(kg.Node(0, 0), kg.Node(0, 2), kg.Node(1, 1))
    >>> objects = m.add(kg.Bar(a, c, EA=9.0), kg.Bar(b, c, EA=9.0), kg.Grip([a, b]), kg.NodalLoad(c, (0, 1)))
    >>> kg.LinearStatic(m).run().moment("fixed_0")[-1].round(9).tolist()
    [0.0, 0.0, -1.0]
    """
    group = results.node_index(nodes)
    point = None if about is None else np.array(vector_of(about, "about", "moment"))
    carried = carried_by(group, results.supports, len(results.rest))
    inside = np.isin(np.arange(len(results.rest)), group)
    forces = np.where(carried, results._gradients, 0.0)
    if not carried.any(axis=1).any():
        raise ModelError("moment: no node is selected")
    found = np.zeros((len(results.steps), 3))
    behind, clamps = _rows_behind(results.kernels, inside), held_edges(results.kernels, "moment")
    for number, step in enumerate(results.steps):
        u = np.zeros_like(step.u) if results.linear else step.u
        place = results.rest + u
        centre = place[group].mean(axis=0) if point is None else point
        found[number] = np.cross(place - centre, forces[number]).sum(axis=0)
        for kernel, rows in behind:
            found[number] += _of_rows(results, kernel, rows, step, results.row_gradients[number])
        for clamp in clamps:
            found[number] -= _of_clamps(results, clamp, inside, step, centre)
    return found


def _rows_behind(kernels: Sequence[Kernel], inside: NDArray[np.bool_]) -> list[tuple[Kernel, NDArray[np.int64]]]:
    """Rows behind the nodes that are held with them, each with one kernel that knows how it turns: the forces on an
    edge between two kinds of facets are those of both."""
    every = [kernel.rows_behind(np.ones_like(inside)) for kernel in kernels]
    for kernel in kernels:
        behind = kernel.conn[kernel.conn >= len(inside)] if kernel.stores_energy else kernel.conn[:0]
        if not np.isin(behind, np.concatenate(every)).all():
            raise ModelError(
                f"moment: no kernel says which of the rows of {kernel.name!r} behind the nodes are held with them: "
                f"define rows_behind of {type(kernel).__name__}"
            )
    found, known = [], np.zeros(0, dtype=np.int64)
    for kernel in kernels:
        rows = np.setdiff1d(kernel.rows_behind(inside), known)
        if len(rows):
            found.append((kernel, rows))
            known = np.concatenate([known, rows])
    return found


def _of_rows(results: Results, kernel: Kernel, rows: NDArray[np.int64], step: Step, total: Array) -> Array:
    """What forces on rows behind the nodes work in rotations about each axis."""
    found = np.zeros(3)
    at = results.configuration(None if results.linear else step)
    for axis, spin in enumerate(np.eye(3)):
        ends = []
        for way in (TURN, -TURN):
            matrix = np.eye(3) + turned(way * spin, np.eye(3)).T
            ends.append(results.evaluate_at(kernel, step, lambda x: kernel.rigidly_moved(at, matrix, np.zeros(3))))  # noqa: B023
        found[axis] = ((ends[0][rows] - ends[1][rows]) * total[rows]).sum() / (2 * TURN)
    return found


def _of_clamps(results: Results, kernel: HeldEdgeKernel, inside: NDArray[np.bool_], step: Step, centre: Array) -> Array:
    """Moment of the forces of the members at held edges inside, which stand for the clamp."""
    lines = kernel.conn[kernel.turn_of[:, None], kernel.turn_at]
    members = np.unique(kernel.turn_of[inside[lines[:, 1:]].all(axis=1)])
    if results.linear:
        felt = results.member_deformation(kernel, step)
        gradient = kernel.force(felt)[:, None, None] * kernel._slopes(np.asarray(results.configuration()))
        place = np.asarray(results.configuration())
    else:
        gradient = results.evaluate_at(kernel, step, lambda x: kernel.evaluate(x, step.lam, 1)).gradient
        place = np.asarray(results.configuration(step))
    arms = place[kernel.conn[members]] - centre
    return np.asarray(np.cross(arms, gradient[members]).sum(axis=(0, 1)))
