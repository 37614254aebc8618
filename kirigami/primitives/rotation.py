"""Finite rotations by their vectors, with derivatives in closed form.

The vector theta turns by |theta| about its own direction. With q = theta.theta and the even functions

    c = cos |theta|,   a = sin |theta| / |theta|,   b = (1 - cos |theta|) / q,

an arm X goes to R X = c X + a theta x X + b (theta.X) theta. All derivatives follow by the chain rule from those of
c, a and b with respect to q, which are series for small angles (Rodrigues' formula; Argyris, Comput. Methods Appl.
Mech. Eng. 32 (1982), 85-155).
"""

from __future__ import annotations

import math

import numpy as np

from kirigami.primitives.kernel import Array

TERMS = 14  # of the series, exact to rounding below q = 1


def coefficients(q: float) -> Array:
    """c, a and b (rows) with their first and second derivatives (columns) by q."""
    table = np.zeros((3, 3))
    if q < 1.0:
        for start, row in enumerate(table):
            for n in range(TERMS):
                factor = (-1.0) ** n / math.factorial(2 * n + start)
                row[0] += factor * q**n
                row[1] += factor * n * q ** (n - 1) if n > 0 else 0.0
                row[2] += factor * n * (n - 1) * q ** (n - 2) if n > 1 else 0.0
        return table
    angle = math.sqrt(q)
    c, a = math.cos(angle), math.sin(angle) / angle
    b = (1 - c) / q
    dc, da = -a / 2, (c - a) / (2 * q)
    db = (a / 2 - b) / q
    return np.array(
        [
            [c, dc, -da / 2],
            [a, da, (dc - da) / (2 * q) - (c - a) / (2 * q**2)],
            [b, db, (da / 2 - db) / q - (a / 2 - b) / q**2],
        ]
    )


def turned(theta: Array, arms: Array) -> Array:
    """Changes (n, 3) of arms (n, 3) under the rotation, without loss of digits for small ones."""
    _, a, b = coefficients(float(theta @ theta))[:, 0]
    across = np.cross(theta, arms)
    return np.asarray(a * across + b * np.cross(theta, across))


def turn_rates(theta: Array, arms: Array) -> Array:
    """Derivatives (n, 3, 3) of the turned arms (second axis) by theta (third axis)."""
    (_, dc, _), (a, da, _), (b, db, _) = coefficients(float(theta @ theta))
    along = arms @ theta
    outer = 2 * dc * arms + 2 * da * np.cross(theta, arms) + 2 * db * along[:, None] * theta
    rates = outer[:, :, None] * theta
    rates += b * (along[:, None, None] * np.eye(3) + theta[:, None] * arms[:, None, :])
    rates -= a * cross_matrices(arms)
    return np.asarray(rates)


def cross_matrices(vectors: Array) -> Array:
    """Matrices (n, 3, 3) that take the cross product of vectors (n, 3) with what follows."""
    x, y, z = vectors.T
    none = np.zeros_like(x)
    return np.moveaxis(np.array([[none, -z, y], [z, none, -x], [-y, x, none]]), 2, 0)


def turn_curvature(theta: Array, forces: Array, arms: Array) -> Array:
    """Second derivative (3, 3) of the work of forces (n, 3) on turned arms (n, 3) by theta."""
    (_, dc, ddc), (_, da, dda), (b, db, ddb) = coefficients(float(theta @ theta))
    dot = float((forces * arms).sum())
    moment = np.cross(arms, forces).sum(axis=0)
    spread = forces.T @ arms
    spread = 0.5 * (spread + spread.T)
    along, form, stretched = float(theta @ moment), float(theta @ spread @ theta), spread @ theta
    square = np.outer(theta, theta)
    mixed = np.outer(theta, da * moment + 2 * db * stretched)
    found = (dot * dc + along * da + form * db) * 2 * np.eye(3) + 2 * b * spread
    found += 4 * (dot * ddc + along * dda + form * ddb) * square + 2 * (mixed + mixed.T)
    return np.asarray(found)


def rate_of_spin(theta: Array, spin: Array) -> Array:
    """Change (3,) of theta for a small rotation `spin` (3,) that follows it."""
    q = float(theta @ theta)
    across = np.cross(theta, spin)
    if q < 1e-8:
        share = 1 / 12
    else:
        half = 0.5 * math.sqrt(q)
        share = (1 - half / math.tan(half)) / q
    return np.asarray(spin - 0.5 * across + share * np.cross(theta, across))


def best_rotation(arms: Array, now: Array) -> Array:
    """The rotation vector (3,) that takes arms (n, 3) best to where they are `now`, of at most half a turn."""
    left, _, right = np.linalg.svd(now.T @ arms)
    matrix = left @ np.diag([1.0, 1.0, float(np.sign(np.linalg.det(left @ right)))]) @ right
    axis = np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]])
    size = float(np.linalg.norm(axis))
    angle = math.atan2(size, float(np.trace(matrix)) - 1)
    if size > 1e-6 or angle < 1:
        return np.asarray(axis * (angle / size if size > 1e-12 else 0.5))
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))  # half a turn: the axis is what stays
    return np.asarray(angle * vectors[:, int(np.argmax(values))])
