"""The angle between two facets at their edge: of any shape, and its rates in the plane that both are laid out in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SHARP = np.radians(30.0)  # an edge between facets that meet at more is a fold of the rest shape, not a part of a curve
STANDS = 1e-6  # sine of the angle between the x axis and a normal below which x has no projection


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


def facet_axes(corners: Floats) -> Floats:
    """Unit vectors (m, 2, 3) in the planes of facets with `corners` (m, 3, 3): the projection of x, and what is a
    quarter turn from it about the normal. That of y where a facet stands on x. On a drawing they are x and y."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    standing = np.linalg.norm(normal[:, 1:], axis=1) < STANDS
    onto = np.eye(3)[standing.astype(int)]
    first = onto - (onto * normal).sum(axis=1)[:, None] * normal
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(normal, first)], axis=1)


def laid_out(corners: Floats, axes: Floats, first: NDArray[np.bool_]) -> Floats:
    """Two facets (e, 4, 3), as wing, edge nodes, wing, unfolded into the plane of one of them, the one of the `first`
    wing or of the last: places (e, 4, 2) along its `axes` (e, 2, 3)."""
    arms = corners - corners[:, 1:2]
    places: Floats = np.einsum("epa,eka->epk", arms, axes)
    edge, every = places[:, 2], np.arange(len(corners))
    length = np.linalg.norm(edge, axis=1)
    along, aside = edge / length[:, None], np.stack([-edge[:, 1], edge[:, 0]], axis=1) / length[:, None]
    own, other = np.where(first, 0, 3), np.where(first, 3, 0)
    side = np.sign((places[every, own] * aside).sum(axis=1))
    arm = arms[every, other]
    foot = (arm * arms[:, 2]).sum(axis=1) / length
    off = np.linalg.norm(arm - (foot / length)[:, None] * arms[:, 2], axis=1)
    places[every, other] = foot[:, None] * along - (side * off)[:, None] * aside
    return places
