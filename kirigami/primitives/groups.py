"""Groups of things that are linked in pairs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def first_of_group(count: int, pairs: Any) -> NDArray[np.int64]:
    """For each of `count` things the first one of its group, given the linked pairs (k, 2); chains are one group."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    first, second = np.asarray(pairs, dtype=np.int64).reshape(-1, 2).T
    links = coo_matrix((np.ones(len(first)), (first, second)), shape=(count, count))
    _, label = connected_components(links, directed=False)
    _, leaders = np.unique(label, return_index=True)
    return np.asarray(leaders[label], dtype=np.int64)
