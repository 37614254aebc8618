"""A cell of a sheet in space as a lowered model under a mean strain: what its law and its waves are made of."""

from __future__ import annotations

import copy
from collections.abc import Sequence
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


def require_sheet(cell: PeriodicCell, owner: str) -> None:
    """The cell is that of a sheet in space."""
    if cell.border is None:
        raise ModelError(
            f"PeriodicCell.{owner}: the cell is no sheet in space: make its model by Model.from_mesh with dim=3, and "
            "let the cell find its images"
        )


class CellSystem:
    """The system of a cell, its other supports and effects as they are.

    Parameters
    ----------
    cell : PeriodicCell
        Of a sheet in space.
    strain : sequence of float or None, optional
        Mean strain at load factor 1, as of :class:`kirigami.model.periodic.Periodic`; None leaves all of it free.
    hold : bool
        Whether the motions of the whole are stopped.
    """

    def __init__(self, cell: PeriodicCell, strain: Sequence[float | None] | None = None, hold: bool = True) -> None:
        model = copy.copy(cell.model)
        model.remove(*(item for item in model.constraints if isinstance(item, Periodic)))
        self.strains = 2 * len(cell.lattice) - 1
        model.add(cell._constraint([None] * self.strains if strain is None else strain, hold=hold))
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

    def mean_strain(self, u: Array) -> Array:
        """Mean strain (..., 3), of a strip (..., 1), of displacements (..., rows, 3)."""
        return np.asarray(u[..., self.rows.strain, : self.strains] / self.rows.scale)

    def mean_stress(self, gradients: Array) -> Array:
        """Mean stress (..., 3), of a strip (..., 1), of the derivatives of the energy by all rows (..., rows, 3)."""
        rows = self.rows
        force = gradients[..., rows.repeats[: len(rows.slopes)], :]
        found = np.einsum("pab,...pa->...b", rows.slopes, force)[..., : self.strains]
        return np.asarray(found * rows.scale / self.cell.measure)

    def without_strain(self) -> tuple[Index, Index, Index, Index]:
        """Numbers (rows * dim,) of the unknowns, -1 where there is none or it is one of the mean strain; displacements
        (k,) that repeat an unknown, that unknown (k,), and how many lattice vectors away it is (k, m)."""
        system, rows = self.system, self.rows
        dim = system.dim
        unknown = system.unknown.copy()
        unknown.reshape(-1, dim)[rows.strain] = -1
        at, source = ((part[:, None] * dim + np.arange(dim)).ravel() for part in (rows.repeats, rows.sources))
        free = unknown[source] >= 0
        return unknown, at[free], unknown[source[free]], np.repeat(rows.steps, dim, axis=0)[free]

    def copies(self) -> Any:
        """All displacements (rows * dim, free) by the unknowns, without mean strain."""
        from scipy.sparse import csc_matrix

        unknown, at, source, _ = self.without_strain()
        own = np.flatnonzero(unknown >= 0)
        places = np.concatenate([own, at]), np.concatenate([unknown[own], source])
        used = np.unique(places[1])
        return csc_matrix((np.ones(len(places[0])), places), shape=(unknown.size, self.system.free))[:, used]

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
