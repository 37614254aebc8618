"""Rigid motions of a set of points."""

from __future__ import annotations

import numpy as np

from kirigami.primitives.kernel import Array
from kirigami.primitives.node import AXES


def rigid_motions(points: Array) -> tuple[Array, list[str]]:
    """Translations and rotations about the centroid: fields (motions, n, dim) of size about 1, and their names."""
    n, dim = points.shape
    arm = points - points.mean(axis=0)
    arm /= np.abs(arm).max(initial=0.0) or 1.0
    fields = [np.tile(np.eye(dim)[axis], (n, 1)) for axis in range(dim)]
    names = [f"translation along {AXES[axis]}" for axis in range(dim)]
    for axis in range(3) if dim == 3 else [2]:
        first, second = (axis + 1) % 3, (axis + 2) % 3  # right-handed
        turn = np.zeros((n, dim))
        turn[:, first], turn[:, second] = -arm[:, second], arm[:, first]
        fields.append(turn)
        names.append(f"rotation about {AXES[axis]}" if dim == 3 else "rotation in the plane")
    return np.array(fields), names
