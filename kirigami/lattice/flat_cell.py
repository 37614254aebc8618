"""A cell of a flat sheet followed in its plane, past all strains at which it would leave it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kirigami.errors import ConvergenceError, ModelError
from kirigami.lattice.cell_system import CellSystem
from kirigami.linalg import SingularMatrixError, factorize
from kirigami.primitives.kernel import Array

if TYPE_CHECKING:
    from kirigami.lattice.periodic import PeriodicCell

SMALL = 1e-10  # residual over the forces of the members that is none
ITERATIONS = 25
HALVINGS = 12


class FlatState(NamedTuple):
    """Displacements (rows, 3), mean strain and mean stress (3,) or (1,)."""

    u: Array
    strain: Array
    stress: Array


class FlatCell:
    """Equilibria of a cell under a mean strain that grows in proportion.

    Parameters
    ----------
    cell : PeriodicCell
        Of a flat sheet.
    strain : sequence of float or None
        Mean strain at load factor 1; None is free.
    """

    def __init__(self, cell: PeriodicCell, strain: Sequence[float | None]) -> None:
        if np.ptp(cell.model.positions()[:, 2]) > 0:
            raise ModelError(
                "PeriodicCell.buckling: the cell is not flat, so that it bends from the start: follow it with "
                "DisplacementControl and ask waves(..., at=step) along its path"
            )
        if not any(strain):
            raise ModelError("PeriodicCell.buckling: the strain drives nothing: give a number other than zero")
        self.known = CellSystem(cell, strain)
        system = self.known.system
        plane = np.zeros(system.rest.shape, dtype=bool)
        plane[:, :2] = True
        if system.edges is not None:
            plane[np.unique(system.edges.angle)] = False
        plane[self.known.rows.strain] = True
        known = system.unknown.reshape(system.rest.shape)
        self.plane = np.unique(known[plane & (known >= 0)])
        self._last = 0.0, np.zeros(system.free)

    def at(self, factor: float) -> FlatState:
        """The equilibrium at a load factor, from the nearest one before."""
        system = self.known.system
        start, q = self._last
        goal, halved = factor, 0
        while start != factor:
            trial = self._solved(q * (goal / start) if start else q, goal)
            if trial is None:
                halved += 1
                goal = 0.5 * (start + goal)
                if halved > HALVINGS:
                    raise ConvergenceError(
                        f"PeriodicCell.buckling: no equilibrium in the plane was found beyond load factor {start:.6g}"
                    )
                continue
            start, q, goal = goal, trial, factor
        self._last = start, q
        u = system.displacement(q, factor)
        raw, scale = system.forces(u, factor, carried=False)
        out = system.reduce(system.carried(raw, u))
        out[self.plane] = 0.0
        if np.linalg.norm(out) > 1e-7 * scale:
            raise ModelError(
                "PeriodicCell.buckling: the sheet leaves its plane at once, as one with unsymmetric layers or a load "
                "across does: follow it with DisplacementControl and ask waves(..., at=step) along its path"
            )
        return FlatState(u, self.known.mean_strain(u), self.known.mean_stress(raw))

    def _solved(self, q: Array, factor: float) -> Array | None:
        """Newton's method in the plane."""
        system, plane = self.known.system, self.plane
        q = q.copy()
        for _ in range(ITERATIONS):
            u = system.displacement(q, factor)
            total, scale = system.forces(u, factor)
            residual = system.reduce(total)[plane]
            if not np.isfinite(residual).all():
                return None
            if np.linalg.norm(residual) <= SMALL * scale:
                return q
            matrix = system.matrix(system.stiffness_blocks(u, factor))
            try:
                q[plane] -= factorize(matrix[plane][:, plane].tocsc()).solve(residual)
            except SingularMatrixError:
                return None
        return None
