"""Folds that end inside a sheet, told of for creases made by hand and for the folds of a mesh alike."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import KirigamiWarning
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import place_in_words
from kirigami.words import counted


def warn_of_loose_ends(
    owner: str, folded: NDArray[np.int64], rim: NDArray[np.int64], nodes: Array, stacklevel: int
) -> None:
    """Say where folds along edges `folded` (k, 2) end at a node that no other fold and no edge of the `rim` (e, 2)
    meets: the curvature about such a point has no bound, as the stress has none at the tip of a cut."""
    degree = np.bincount(folded.ravel(), minlength=len(nodes))
    loose = np.setdiff1d(np.flatnonzero(degree == 1), rim)
    if not loose.size:
        return
    warnings.warn(
        f"{owner}: {counted(loose.size, 'end')} of folds inside the sheet, the first at "
        f"{place_in_words(nodes[loose[0]])}: there curvature is the mesh's and grows with every finer one; lead "
        "the fold to a rim, a cut or another fold, if that is how it is made",
        KirigamiWarning,
        stacklevel=stacklevel,
    )
