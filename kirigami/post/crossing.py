"""Where a sheet passes through itself: edges of facets that pierce other facets.

Facets are taken as the flat triangles of their corners, on every rung. The pairs that come close are found by `ipctk`
(the extra ``contact``), and whether an edge pierces a facet is decided here: on both sides by more than a thousandth of
the facet, so that lips of a slit, which coincide at rest, and facets that lie on each other are no crossing.
"""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import AnalysisError
from kirigami.primitives.checks import require_array
from kirigami.primitives.kernel import Array

PIERCED = 1e-3  # over the size of a facet: how far an edge must reach beyond it on both sides
ON_RIM = 1e-9  # share of a facet that is its rim, which is pierced too: mirror images meet there
INSTALL = "pip install 'kirigami-mechanics[contact]'"


def can_search() -> bool:
    """Whether `ipctk` is installed, so that contact can be searched for."""
    return importlib.util.find_spec("ipctk") is not None


def toolkit(owner: str) -> Any:
    """The module `ipctk`, on one thread; an AnalysisError says how to install it where it is missing."""
    if not can_search():
        raise AnalysisError(f"{owner} searches for contact by ipctk, which is not installed: {INSTALL}")
    import ipctk

    ipctk.set_num_threads(1)
    return ipctk


def crossings(x: ArrayLike, edges: NDArray[np.int64], triangles: NDArray[np.int64]) -> Array:
    """Places (k, 3) [length] at which edges pierce facets of a surface, none where it does not cross itself.

    Parameters
    ----------
    x : array_like, shape (n, 3)
        Positions of the nodes [length].
    edges : ndarray of int, shape (e, 2)
        Nodes of each edge.
    triangles : ndarray of int, shape (m, 3)
        Corners of each facet.

    Raises
    ------
    AnalysisError
        `ipctk` is not installed.
    """
    ipctk = toolkit("crossings")
    places = np.asfortranarray(require_array(x, (None, 3), name="x", owner="crossings"))
    ends, corners = (np.asfortranarray(part, dtype=np.int32) for part in (edges, triangles))
    search = ipctk.LBVH()
    search.build(places, ends, corners)
    pairs = np.array([(pair.edge_id, pair.face_id) for pair in search.detect_edge_face_candidates()], dtype=np.int64)
    if not len(pairs):
        return np.empty((0, 3))
    start, end = places[ends[pairs[:, 0]]].transpose(1, 0, 2)
    a, b, c = places[corners[pairs[:, 1]]].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    double = np.linalg.norm(normal, axis=1)
    size = np.sqrt(double)
    unit = normal / np.where(double > 0, double, 1.0)[:, None]
    low, high = (np.einsum("na,na->n", point - a, unit) for point in (start, end))
    apart = (low * high < 0) & (np.minimum(np.abs(low), np.abs(high)) > PIERCED * size)
    low, high, start, end, a, b, c, unit, double = (
        part[apart] for part in (low, high, start, end, a, b, c, unit, double)
    )
    point = start + (low / (low - high))[:, None] * (end - start)
    shares = [np.einsum("na,na->n", np.cross(q - p, point - p), unit) / double for p, q in ((a, b), (b, c), (c, a))]
    return np.asarray(point[np.min(shares, axis=0) > -ON_RIM])
