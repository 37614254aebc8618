"""A cell of a sheet in space as a lowered model whose mean strain is free: what its law and its waves are made of."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import MechanismError, ModelError
from kirigami.model.periodic import Periodic
from kirigami.primitives.cell_rows import CellRows
from kirigami.primitives.checks import require_array
from kirigami.primitives.kernel import Array
from kirigami.results.step import Step
from kirigami.system.system import System

if TYPE_CHECKING:
    from kirigami.lattice.periodic import PeriodicCell

Index = NDArray[np.int64]


class CellSystem:
    """The system of a cell, its other supports and effects as they are.

    Parameters
    ----------
    cell : PeriodicCell
        Of a sheet in space.
    hold : bool
        Whether the motions of the whole are stopped.
    """

    def __init__(self, cell: PeriodicCell, hold: bool = True) -> None:
        model = copy.copy(cell.model)
        model.remove(*(item for item in model.constraints if isinstance(item, Periodic)))
        item = cell._constraint([None] * (2 * len(cell.lattice) - 1), hold=hold)
        model.add(item)
        self.cell, self.system = cell, System(model)
        assert self.system.grips is not None
        self.rows = next(group for group in self.system.grips.groups if isinstance(group, CellRows))

    @property
    def positions(self) -> Index:
        """Rows that are positions: nodes, and copies of them beyond the border."""
        return np.concatenate([np.arange(self.system.points), np.unique(self.rows.beyond)])

    def state(self, at: Any, owner: str) -> tuple[Array, float]:
        """Displacements (rows, 3) of a step, or of displacements of nodes (n, 3), and the load factor; None is rest."""
        system = self.system
        system.history = None
        if at is None:
            return np.zeros_like(system.rest), 0.0
        if isinstance(at, Step):
            if len(at.u) != system.points or len(at.u) + len(at.inner) != len(system.rest):
                raise ModelError(f"{owner}: the step belongs to another model, or to this one before impose()")
            system.history = at.history
            return system.joined(at.u, at.inner), at.lam
        u = require_array(at, (system.points, 3), name="u", owner=owner)
        return system.settled(u), 0.0

    def copies(self, phases: Array | None = None) -> Any:
        """All displacements (rows * dim, free) by the unknowns, without mean strain; what repeats is turned by Bloch
        phases (m,) along the lattice vectors [rad], if any."""
        from scipy.sparse import csc_matrix

        system, rows = self.system, self.rows
        dim = system.dim
        unknown = system.unknown.copy()
        unknown.reshape(-1, dim)[rows.strain] = -1
        own = np.flatnonzero(unknown >= 0)
        at = (rows.repeats[:, None] * dim + np.arange(dim)).ravel()
        source = unknown[(rows.sources[:, None] * dim + np.arange(dim)).ravel()]
        turn = np.ones(len(at)) if phases is None else np.repeat(np.exp(1j * (rows.steps @ phases)), dim)
        free = source >= 0
        values = np.concatenate([np.ones(len(own)), turn[free]])
        places = np.concatenate([own, at[free]]), np.concatenate([unknown[own], source[free]])
        used = np.unique(places[1])
        return csc_matrix((values, places), shape=(system.rest.size, system.free))[:, used]

    @staticmethod
    def relax(stiffness: Any, load: Array) -> Array:
        """Unknowns (free, k) that balance loads (free, k)."""
        from kirigami.linalg import SingularMatrixError, factorize

        if not load.any():
            return np.zeros_like(load)
        try:
            factor = factorize(stiffness)
            found = np.column_stack([factor.solve(-column) for column in load.T])
            if np.abs(stiffness @ found + load).max() <= 1e-6 * np.abs(load).max(initial=1e-300):
                return found
        except SingularMatrixError:
            pass
        raise MechanismError(
            "no periodic motion balances the mean strain: some motion of the cell costs nothing, or the cell is at the "
            "brink of an instability; take another state, or a sheet that resists",
            motion="periodic",
        )
