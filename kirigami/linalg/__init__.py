"""Linear algebra: factorise symmetric sparse matrices, count negative eigenvalues, solve with a checked residual.

A back end is a class whose objects factorise one matrix after another (:class:`Solver`). ``multifrontal``, the default,
is this package's own; ``superlu`` is SciPy's; ``rslab`` comes with the extra "fast". The environment variable
KIRIGAMI_SOLVER chooses another one than the default for a whole process.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from kirigami.errors import AnalysisError
from kirigami.linalg.checked import Factor, SingularMatrixError, Solver
from kirigami.linalg.critical import critical_factors
from kirigami.linalg.eigenpairs import inverse_iteration, lowest_eigenpairs
from kirigami.linalg.multifrontal import Multifrontal
from kirigami.linalg.nearby import NearbyFactor, lowest_of_pencil, nearby_factor
from kirigami.linalg.rslab_solver import Rslab
from kirigami.linalg.superlu import SuperLU
from kirigami.linalg.threads import one_thread

__all__ = [
    "BACKENDS",
    "Factor",
    "Multifrontal",
    "NearbyFactor",
    "Rslab",
    "SingularMatrixError",
    "Solver",
    "SuperLU",
    "critical_factors",
    "factorize",
    "inverse_iteration",
    "lowest_eigenpairs",
    "lowest_of_pencil",
    "make_solver",
    "nearby_factor",
    "one_thread",
]

BACKENDS: dict[str, Callable[[], Solver]] = {"multifrontal": Multifrontal, "superlu": SuperLU, "rslab": Rslab}


def make_solver(backend: str | None = None) -> Solver:
    """A fresh solver of the given back end; None takes what KIRIGAMI_SOLVER names, or else the default.

    Raises AnalysisError where the back end is unknown or not installed.

    Examples
    --------
    >>> from kirigami.linalg import make_solver
    >>> import numpy as np
    >>> from scipy.sparse import diags
    >>> factor = make_solver("superlu").factorize(diags([2.0, -4.0], format="csc"))
    >>> factor.negative, factor.solve(np.array([1.0, 1.0])).tolist()
    (1, [0.5, -0.25])
    """
    name = backend or os.environ.get("KIRIGAMI_SOLVER") or "multifrontal"
    if name not in BACKENDS:
        raise AnalysisError(f"no solver is called {name!r}: choose one of {', '.join(BACKENDS)}")
    return BACKENDS[name]()


def factorize(matrix: Any) -> Factor:
    """Factor one symmetric CSC matrix with the default back end."""
    return make_solver().factorize(matrix)
