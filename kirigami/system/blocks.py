"""Node blocks of a tangent, with what couples rows beyond the plan: contact, whose pairs come and go."""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.primitives.kernel import Array

LINEAR = {np.add: 1.0, np.subtract: -1.0}


class Blocks(np.ndarray[Any, np.dtype[np.float64]]):
    """Node blocks (dim, dim, blocks), and a sparse matrix `more` (rows * dim, rows * dim) that belongs to them.

    Sums and multiples carry both; whatever else is done to them gives plain arrays.
    """

    more: Any

    def __new__(cls, blocks: Array, more: Any) -> Blocks:
        made = np.asarray(blocks).view(cls)
        made.more = more
        return made

    def __array_finalize__(self, source: Any) -> None:
        self.more = None

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        if "out" in options:
            options["out"] = tuple(np.asarray(part) for part in options["out"])
        result = getattr(ufunc, method)(*(np.asarray(part) for part in inputs), **options)
        more = None
        if method == "__call__" and ufunc in LINEAR:
            first, second = (getattr(part, "more", None) for part in inputs)
            second = None if second is None else LINEAR[ufunc] * second
            more = first if second is None else second if first is None else first + second
        elif method == "__call__" and ufunc in (np.multiply, np.divide):
            for part, other in (inputs, inputs[::-1]):
                if getattr(part, "more", None) is not None and np.ndim(other) == 0:
                    more = part.more * other if ufunc is np.multiply else part.more / other
        return result if more is None else Blocks(result, more)


def more_of(blocks: Array) -> Any:
    """What blocks couple beyond their plan, None where nothing does."""
    return getattr(blocks, "more", None)
