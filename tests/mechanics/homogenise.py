"""Effective properties of periodic sheets of bars and hinges, by linear algebra on the stiffness of one cell.

The affine part of the displacement is imposed on every node; the periodic fluctuation, one value per node of the
cell, is free and relaxes. What remains is the energy per area of the strain or of the curvature imposed.
"""

from __future__ import annotations

from dataclasses import dataclass

import meshes
import numpy as np
from meshes import Floats

import kirigami as kg


def _per_area(stiffness: Floats, copies: Floats, affine: Floats, area: float, relaxed: bool = True) -> Floats:
    """Second derivative of the energy per area with respect to the amplitudes of the affine fields."""
    if not relaxed:
        return affine.T @ stiffness @ affine / area
    inner = copies.T @ stiffness @ copies
    # The fluctuation is free up to a rigid translation (and slides no bar feels), hence least squares.
    fluctuation = np.linalg.lstsq(inner, -copies.T @ stiffness @ affine, rcond=1e-11)[0]
    field = affine + copies @ fluctuation
    return field.T @ stiffness @ field / area


def membrane_matrix(cell: meshes.UnitCell, relaxed: bool = True) -> Floats:
    """Plane-stress matrix for (exx, eyy, gamma_xy)."""
    stiffness = _stiffness(cell)
    x, y = cell.position.T
    zero = np.zeros_like(x)
    affine = np.stack([np.stack([x, zero, y / 2]), np.stack([zero, y, x / 2])], axis=1)  # field, axis, node
    plane = stiffness[:, :2, :, :2].reshape(2 * len(x), 2 * len(x))
    copies = np.kron(_copies(cell), np.eye(2))
    return _per_area(plane, copies, affine.transpose(2, 1, 0).reshape(-1, 3), cell.area, relaxed)


def bending_matrix(cell: meshes.UnitCell) -> Floats:
    """Moment matrix for (Kxx, Kyy, 2 Kxy), K the second derivatives of the deflection."""
    stiffness = _stiffness(cell)
    x, y = cell.position.T
    deflection = np.column_stack([x**2 / 2, y**2 / 2, x * y / 2])
    return _per_area(stiffness[:, 2, :, 2], _copies(cell), deflection, cell.area)


def _stiffness(cell: meshes.UnitCell) -> Floats:
    count = len(cell.nodes)
    flat = np.zeros((count, 3))
    return kg.System(cell.model).stiffness(flat, constrained=False).toarray().reshape(count, 3, count, 3)


def _copies(cell: meshes.UnitCell) -> Floats:
    copies = np.zeros((len(cell.nodes), cell.count))
    copies[np.arange(len(cell.nodes)), cell.leader] = 1.0
    return copies


@dataclass(frozen=True)
class Moduli:
    """Engineering moduli over all directions in the sheet (shape (directions,))."""

    young: Floats
    poisson: Floats
    shear: Floats


def moduli(matrix: Floats, directions: int = 360) -> Moduli:
    """Young's modulus, Poisson ratio and shear modulus in each direction, from a plane-stress matrix."""
    compliance = np.linalg.inv(matrix)
    angle = np.arange(directions) * np.pi / directions
    c, s = np.cos(angle), np.sin(angle)
    along = np.stack([c * c, s * s, c * s], axis=1)  # stress (xx, yy, xy) of a unit pull along the direction
    across = np.stack([s * s, c * c, -c * s], axis=1)
    shearing = np.stack([-2 * c * s, 2 * c * s, c * c - s * s], axis=1)

    def product(left: Floats, right: Floats) -> Floats:
        return np.einsum("di,ij,dj->d", left, compliance, right)

    pull = product(along, along)
    return Moduli(1.0 / pull, -product(along, across) / pull, 1.0 / product(shearing, shearing))


@dataclass(frozen=True)
class Rigidities:
    """Bending rigidities over all directions (shape (directions,)), and of a sphere and of all saddles."""

    cylinder: Floats  # no transverse curvature
    beam: Floats  # transverse curvature free
    sphere: float  # D (1 + nu) of an isotropic plate
    saddle: Floats  # D (1 - nu)


def rigidities(matrix: Floats, directions: int = 360) -> Rigidities:
    """Rigidities in each direction from a moment matrix."""
    compliance = np.linalg.inv(matrix)
    angle = np.arange(directions) * np.pi / directions
    c, s = np.cos(angle), np.sin(angle)
    roll = np.stack([c * c, s * s, 2 * c * s], axis=1)  # curvatures (Kxx, Kyy, 2 Kxy) of a cylinder
    moment = np.stack([c * c, s * s, c * s], axis=1)
    twist = np.stack([c * c - s * s, s * s - c * c, 4 * c * s], axis=1)
    sphere = np.array([1.0, 1.0, 0.0])
    return Rigidities(
        np.einsum("di,ij,dj->d", roll, matrix, roll),
        1.0 / np.einsum("di,ij,dj->d", moment, compliance, moment),
        float(sphere @ matrix @ sphere) / 2.0,
        np.einsum("di,ij,dj->d", twist, matrix, twist) / 2.0,
    )
