"""The angle between two facets at their edge: of any shape, and its rates where the sheet is flat."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def fold_angles(corners: Floats) -> Floats:
    """Angle (e,) between the facets at edges with corners (e, 4, 3): wing, edge nodes, wing.

    Positive where the facets are hollow from above; in (-pi, pi].
    """
    edge, first, second = (corners[:, c] - corners[:, 1] for c in (2, 0, 3))
    m, n = np.cross(edge, first), np.cross(second, edge)
    angle: Floats = np.arctan2(np.linalg.norm(edge, axis=1) * (m * second).sum(axis=1), (m * n).sum(axis=1))
    return angle


def fold_rates(corners: Floats) -> Floats:
    """Rate of the angle with the heights (e, 4) of wing, edge nodes and wing, in a flat sheet (e, 4, 2)."""
    edge = corners[:, 2] - corners[:, 1]
    length = np.linalg.norm(edge, axis=1)
    rate = np.zeros((len(corners), 4))
    for wing in (0, 3):
        arm = corners[:, wing] - corners[:, 1]
        off = np.abs(edge[:, 0] * arm[:, 1] - edge[:, 1] * arm[:, 0]) / length
        foot = (edge * arm).sum(axis=1) / length**2
        rate[:, wing] = 1 / off
        rate[:, 1] -= (1 - foot) / off
        rate[:, 2] -= foot / off
    return rate


def fold_curvature_rates(corners: Floats) -> Floats:
    """Rates (e, 3) of the angles in a flat sheet (e, 4, 2) with the curvature (kxx, kyy, kxy) of a quadratic height."""
    rate = fold_rates(corners)
    x, y = np.moveaxis(corners - corners.mean(axis=1, keepdims=True), -1, 0)
    # angle of the height (kxx x^2 + kyy y^2)/2 + kxy x y, whose linear part does not bend an edge
    return np.stack([0.5 * (rate * x * x).sum(1), 0.5 * (rate * y * y).sum(1), (rate * x * y).sum(1)], axis=1)
