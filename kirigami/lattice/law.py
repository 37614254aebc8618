"""What a cell of a sheet in space makes of the infinite sheet: mean stress and strain, tangent, and section.

The energy per area of the cell depends on the mean strain E alone when all else is in equilibrium. Its derivative is
the mean stress, work-conjugate to the stretch 1 + E (Biot's, the nominal stress of a sheet that is pulled along its
axes); its second derivative is the tangent, K_EE - K_Eq K_qq^-1 K_qE with the unknowns q of the cell.

The section matrix [[A, B], [B, D]] takes the mean curvature k as well: two points a lattice vector R apart then differ
by the small rotation k R too, u = w e_z - z grad w with w = k : X X / 2, and what repeats relaxes. An uncut sheet
returns its own A and D.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.elements.shell_geometry import GAUSS
from kirigami.errors import ModelError
from kirigami.lattice.cell_system import CellSystem, require_sheet
from kirigami.primitives.checks import require_instance
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.lattice.periodic import PeriodicCell


@dataclass(frozen=True, eq=False, repr=False)
class EffectiveLaw:
    """Mean stress and strain of an infinite sheet of equal cells, step by step.

    Attributes
    ----------
    strain : ndarray, shape (s, 3) for a sheet, (s, 1) for a strip
        Mean strain (exx, eyy, gxy): the stretch without rotation is 1 + E; of a strip its elongation.
    stress : ndarray, shape (s, 3) or (s, 1)
        Work-conjugate mean stress (sxx, syy, sxy) times thickness [force / length]; of a strip its force [force].
    energy : ndarray, shape (s,)
        Stored energy of the cell over its area, or over the length of a strip [force / length].
    along : int
        The axis of the pull, 0 or 1, by which Poisson's ratio is told: that of the larger stress at the end.
    """

    strain: Array
    stress: Array
    energy: Array
    along: int

    @property
    def poisson(self) -> Array:
        """Contraction across over elongation along (s,), for a pull along x or y; nan at rest and of a strip."""
        found = np.full(len(self.strain), np.nan)
        if self.strain.shape[1] == 3:
            along, across = self.strain[:, self.along], self.strain[:, 1 - self.along]
            np.divide(-across, along, out=found, where=along != 0)
        return found

    def __repr__(self) -> str:
        strain, stress = (", ".join(f"{value:.4g}" for value in values[-1]) for values in (self.strain, self.stress))
        return f"EffectiveLaw({counted(len(self.strain), 'step')}, at the last strain ({strain}), stress ({stress}))"


def law(cell: PeriodicCell, results: Results) -> EffectiveLaw:
    """Mean stress and strain of the infinite sheet at each step.

    Parameters
    ----------
    results : Results
        Of the model of this cell, of a sheet in space, with a mean strain imposed.

    Returns
    -------
    EffectiveLaw

    Raises
    ------
    ModelError
        The cell is no sheet in space, or the results are of another model or had no mean strain imposed.
    """
    require_sheet(cell, "law")
    require_instance(results, Results, "results", "PeriodicCell.law")
    known = CellSystem(cell)
    if results.rest.shape != (len(cell.model.nodes), 3) or (
        len(results.inner_rest) + len(results.rest) <= known.rows.strain
    ):
        raise ModelError(
            "PeriodicCell.law: these results belong to another model, or to this one before impose(): give the results "
            "of a run after it"
        )
    strain = np.array([known.mean_strain(results.rows(step)) for step in results.steps])
    stress = known.mean_stress(results.row_gradients)
    energy = sum(np.asarray(values) for values in results.energy.values()) / cell.measure
    end = np.abs(stress[-1, :2]) if len(stress) and known.strains == 3 else np.zeros(1)
    return EffectiveLaw(strain, stress, np.asarray(energy), int(np.argmax(end)))


def tangent(cell: PeriodicCell, at: Any = None) -> Array:
    """The matrix (3, 3) of :meth:`kirigami.PeriodicCell.stiffness` of a sheet in space, (1, 1) of a strip."""
    known = CellSystem(cell)
    system = known.system
    u, lam = known.state(at, "PeriodicCell.stiffness")
    matrix = system.stiffness(u, lam)
    strains = system.unknown.reshape(system.rest.shape)[known.rows.strain, : known.strains]
    others = np.setdiff1d(np.arange(system.free), strains)
    coupling = matrix[:, strains].toarray()
    relaxed = known.relax(matrix[others][:, others].tocsc(), coupling[others])
    found = coupling[strains] + coupling[others].T @ relaxed
    found *= known.rows.scale**2 / cell.measure
    return np.asarray(0.5 * (found + found.T))


def section(cell: PeriodicCell) -> Array:
    """Section matrix of the infinite sheet at rest, [[A, B], [B, D]].

    It is what ``ShellFacet(section=...)`` takes: a sheet of many cells as one of none.

    Returns
    -------
    ndarray, shape (6, 6)
        Forces and moments per length (Nxx, Nyy, Nxy, Mxx, Myy, Mxy) by mean strains and curvatures (exx, eyy, gxy, kxx,
        kyy, 2 kxy); curvature is positive towards the normal of the sheet.

    Raises
    ------
    ModelError
        The cell is no sheet in space with two lattice vectors.
    MechanismError
        Some motion of the cell costs nothing and a mean strain drives it.

    Examples
    --------
    >>> import kirigami as kg
    >>> sheet = kg.CellSheet([(1, 0), (0, 1)], thickness=0.1, material=kg.Material(E=12000.0, nu=0.0))
    >>> cell = kg.PeriodicCell(kg.Model.from_mesh(sheet.mesh(0.4), stiffness="shell"), sheet.lattice)
    >>> cell.section().diagonal().round(6).tolist()  # E t, and E t^3 / 12
    [1200.0, 1200.0, 600.0, 1.0, 1.0, 0.5]
    """
    require_sheet(cell, "section")
    if len(cell.lattice) != 2:
        raise ModelError("PeriodicCell.section: a sheet has two lattice vectors, this strip has one")
    known = CellSystem(cell)
    matrix = known.system.stiffness(None, constrained=False)
    fields = _mean_fields(known)
    copies = known.copies()
    force = matrix @ fields
    relaxed = known.relax((copies.T @ matrix @ copies).tocsc(), copies.T @ force)
    found = (fields.T @ force + (copies.T @ force).T @ relaxed) / cell.measure
    return np.asarray(0.5 * (found + found.T))


def _mean_fields(known: CellSystem) -> Array:
    """Displacements (rows * 3, 6) of three uniform strains and three uniform curvatures."""
    system = known.system
    rest, points = system.rest, known.positions
    fields = np.zeros((*rest.shape, 6))
    fields[points] = _field(rest[points])
    edges = system.edges
    if edges is not None:
        ends = rest[edges.ends]
        middle = ends.mean(axis=1) + rest[edges.middle]
        fields[edges.middle] = _field(middle) - 0.5 * (_field(ends[:, 0]) + _field(ends[:, 1]))
        edge, row = edges.pairs
        chord, offset = ends[:, 1] - ends[:, 0], rest[edges.middle]
        for point, share in enumerate(GAUSS):  # the sheet turns about its edges
            slope = chord + 4 * (1 - 2 * share) * offset
            slope /= np.linalg.norm(slope, axis=1)[:, None]
            place = ends[:, 0] + share * chord + 4 * share * (1 - share) * offset
            fields[row, point] = -(edges.length[:, None] * np.einsum("ea,eas->es", slope, _spin(place)))[edge]
    return fields.reshape(-1, 6)


def _field(points: Array) -> Array:
    """Displacements (k, 3, 6) at points (k, 3)."""
    x, y, z = points.T
    found = np.zeros((len(points), 3, 6))
    found[:, 0, 0], found[:, 1, 1] = x, y
    found[:, 0, 2], found[:, 1, 2] = 0.5 * y, 0.5 * x
    found[:, 2, 3:] = np.column_stack([0.5 * x**2, 0.5 * y**2, 0.5 * x * y])
    found[:, 0, 3:] = -z[:, None] * np.column_stack([x, 0 * x, 0.5 * y])
    found[:, 1, 3:] = -z[:, None] * np.column_stack([0 * x, y, 0.5 * x])
    return found


def _spin(points: Array) -> Array:
    """Rotations (k, 3, 6) of these fields: (w,y, -w,x, 0) of the curvatures."""
    x, y, _ = points.T
    found = np.zeros((len(points), 3, 6))
    found[:, 0, 3:] = np.column_stack([0 * x, y, 0.5 * x])
    found[:, 1, 3:] = -np.column_stack([x, 0 * x, 0.5 * y])
    return found
