"""Where the energy is: shares of stretching, bending and springs over a path."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_mapping

Floats = NDArray[np.float64]

NOTHING = 1e-14  # part of the largest energy of a path below which a step stores nothing but rounding


def energy_shares(energy: Mapping[str, ArrayLike]) -> dict[str, Floats]:
    """Stored energy of each kind as a fraction of the whole, step by step.

    Parameters
    ----------
    energy : mapping of str to array_like, shape (s,)
        Energies by kind [force length], as in :attr:`kirigami.Results.energy`.

    Returns
    -------
    dict of str to ndarray, shape (s,)
        Fractions, which add up to 1; all are 0 at steps that store nothing.

    Raises
    ------
    ModelError
        No kinds, unequal numbers of steps, or energies that are negative or not finite.

    Examples
    --------
    >>> from kirigami.post.energy import energy_shares
    >>> shares = energy_shares({"bars": [0.0, 1.0], "hinges": [0.0, 3.0]})
    >>> shares["bars"].tolist(), shares["hinges"].tolist()
    ([0.0, 0.25], [0.0, 0.75])
    """
    given = require_mapping(energy, "energy", "energy_shares")
    kinds = {name: require_array(values, (None,), name=name, owner="energy_shares") for name, values in given.items()}
    if not kinds:
        raise ModelError("energy_shares: there is no stored energy; the structure has no elements")
    shapes = {values.shape for values in kinds.values()}
    if len(shapes) > 1 or len(next(iter(shapes))) != 1:
        raise ModelError(f"energy_shares: every kind needs one value for each step, got shapes {sorted(shapes)}")
    total = sum(kinds.values(), np.zeros(next(iter(shapes))))
    largest = float(np.max(total, initial=0.0))
    for name, values in kinds.items():
        if not np.isfinite(values).all() or (values < -1e-9 * largest).any():
            raise ModelError(f"energy_shares: the energy of {name!r} must be finite and not negative")
    stored = total > NOTHING * largest
    return {name: np.where(stored, values / np.where(stored, total, 1.0), 0.0) for name, values in kinds.items()}
