"""The mass of a lowered model: a symmetric matrix over its rows, the same along every axis, from what kernels bring.

Rows without mass, as the angles of edges or nodes of bars without weight, follow without inertia: nothing here or
elsewhere divides by a mass.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.elements.triangle import corner_mass
from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array
from kirigami.system.assembly import Index
from kirigami.system.system import System

FACETED = ("facet", "shell")  # rungs whose elements are the facets of the sheet


class Inertia:
    """Mass matrices of a system.

    Parameters
    ----------
    system : System
        The lowered model.
    kind : {"consistent", "lumped"} or ndarray, shape (n_nodes,)
        Consistent: what the displacements of the elements between their nodes say. Lumped: the same mass at the nodes
        alone. Or the mass of each node.
    about : ndarray, shape (rows, dim), optional
        Displacements at which what follows rigid grips is carried to them; None is the rest state.

    Attributes
    ----------
    rows : sparse matrix, shape (rows, rows)
        Mass over the rows of the system, for each axis.
    blocks : ndarray, shape (dim, dim, blocks)
        The same as node blocks of the assembly plan, with what follows rigid grips carried to the rows that lead.
    uncarried : ndarray, shape (dim, dim, blocks)
        The same without that.
    matrix : sparse matrix, shape (free, free)
        Mass over the unknowns, within the pattern of the stiffness.

    Raises
    ------
    ModelError
        A sheet of unknown density, or no mass at all.
    """

    def __init__(self, system: System, kind: str | Array = "consistent", about: Array | None = None) -> None:
        from scipy.sparse import coo_matrix

        self.system = system
        if isinstance(kind, str):
            parts = mass_parts(system, kind == "lumped")
        else:
            parts = [(np.arange(system.points)[:, None], kind[:, None, None])]
        first, second, values = (np.concatenate([part[k] for part in map(_entries, parts)]) for k in range(3))
        n = len(system.rest)
        self.rows = coo_matrix((values, (first, second)), shape=(n, n)).tocsr()
        upper = first <= second
        plan, slots = system.plan_with(first[upper], second[upper])
        count = np.bincount(slots, values[upper], plan.count)
        self.blocks = np.zeros((system.dim, system.dim, plan.count))
        for axis in range(system.dim):
            self.blocks[axis, axis] = count
        self.uncarried = self.blocks
        if system.grips is not None:
            self.blocks = self.blocks.copy()
            none = np.zeros_like(system.rest)
            system.grips.condense(self.blocks, plan.low, plan.high, none if about is None else about, none, 0.0)
        self.matrix = _without_zeros(system.matrix(self.blocks))

    @property
    def total(self) -> float:
        """Mass of the structure: what resists when all nodes move together."""
        points = self.system.points
        return float(self.rows[:points, :points].sum())

    def momentum(self, velocity: Array) -> Array:
        """Momentum (rows, dim) of the rows at velocities (rows, dim)."""
        return np.asarray(self.rows @ velocity)

    def energy(self, velocity: Array) -> float:
        """Kinetic energy at velocities (rows, dim)."""
        return 0.5 * float((velocity * self.momentum(velocity)).sum())


def _without_zeros(matrix: Any) -> Any:
    """A copy of a CSC matrix without its zeros, which leaves the pattern that it shares with others as it is."""
    from scipy.sparse import csc_matrix

    there = np.flatnonzero(matrix.data)
    indptr = np.searchsorted(there, matrix.indptr)
    return csc_matrix((matrix.data[there], matrix.indices[there], indptr), shape=matrix.shape)


def mass_parts(system: System, lumped: bool) -> list[tuple[Index, Array]]:
    """Rows (m, k) and mass matrices (m, k, k) of everything that has mass."""
    parts = []
    for kernel in system.kernels:
        found = kernel.mass(lumped)
        if found is not None:
            parts.append((kernel.conn, found))
        elif kernel.surface:
            raise ModelError(UNKNOWN)
    constants, mesh = system.model.sheet_constants, system.model.mesh
    if constants is not None and mesh is not None and constants.rung not in FACETED:
        per_area = constants.mass_per_area(len(mesh.triangles))
        if per_area is None:
            raise ModelError(UNKNOWN)
        parts.append((mesh.triangles, corner_mass(per_area * mesh.facet_areas, lumped)))
    if not parts or not any(np.any(masses) for _, masses in parts):
        raise ModelError(
            "the model has no mass: give its material a density, its bars a mass_per_length, or its nodes a kg.Mass"
        )
    return parts


UNKNOWN = "the mass of the sheet is not known: give its material a density, as kg.Material(E, nu, density=1400.0)"


def _entries(part: tuple[Index, Array]) -> tuple[Index, Index, Array]:
    conn, masses = part
    first = np.broadcast_to(conn[:, :, None], masses.shape).ravel()
    second = np.broadcast_to(conn[:, None, :], masses.shape).ravel()
    there = masses.ravel() != 0
    return first[there], second[there], masses.ravel()[there]
