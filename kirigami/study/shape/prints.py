"""Shapes of one sheet on different meshes, each in a line of text, so that a table can tell which runs may be compared.

The heights of a sheet over its bounding box are written as a sum of cosines; the shares of the longest ones are the
print. A reflection of the sheet turns the sign of every second one, the other side that of all.
"""

from __future__ import annotations

import base64

import numpy as np

from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.study.quadrature import POINTS, WEIGHTS

WAVES = 12  # half waves along each side, from none on
FLAT = 1e-3  # height over size of the sheet below which it has no shape
NONE = "flat"


def shape_print(results: Results, step: int) -> str:
    """The shape of a sheet at a step, whatever its height.

    Raises
    ------
    AttributeError
        Results without a mesh.
    """
    mesh = results.mesh
    assert mesh is not None
    height = (results.rest[:, 2] + results.u[step, :, 2])[: len(mesh.nodes)]
    if np.ptp(height) <= FLAT * mesh.size:
        return NONE
    places = np.einsum("qc,mcx->mqx", POINTS, mesh.nodes[mesh.triangles]).reshape(-1, 3)
    values = (np.outer(mesh.facet_areas, WEIGHTS) * (height[mesh.triangles] @ POINTS.T)).ravel()
    xmin, ymin, xmax, ymax = mesh.bounds
    order = np.arange(WAVES)
    along, across = (
        np.cos(np.pi * order * ((places[:, axis] - low) / (high - low))[:, None])
        for axis, low, high in ((0, xmin, xmax), (1, ymin, ymax))
    )
    shares = np.einsum("m,mi,mj->ij", values, along, across, optimize=True)
    shares /= np.linalg.norm(shares)
    return base64.b85encode(np.round(shares * 127).astype(np.int8).tobytes()).decode()


def print_distance(one: str, other: str) -> float:
    """Relative distance of two shapes, the least over reflections and sides: 0 for equal ones, at most sqrt(2).

    It is 0 for two flat sheets, and infinite for a flat one and one that is not.

    Examples
    --------
    >>> from kirigami.study.shape.prints import print_distance
    >>> print_distance("flat", "flat")
    0.0
    """
    if NONE in (one, other):
        return 0.0 if one == other else float("inf")
    a, b = _shares(one), _shares(other)
    sign = (-1.0) ** np.arange(WAVES)
    flips = [np.outer(x, y) for x in (np.ones(WAVES), sign) for y in (np.ones(WAVES), sign)]
    return float(min(np.linalg.norm(a - side * flip * b) for flip in flips for side in (1.0, -1.0)))


def _shares(text: str) -> Array:
    shares = np.frombuffer(base64.b85decode(text), np.int8).reshape(WAVES, WAVES).astype(float)
    normed: Array = shares / np.linalg.norm(shares)
    return normed
