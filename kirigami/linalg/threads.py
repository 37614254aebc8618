"""One thread of BLAS: on blocks of some hundred rows and on dot products a second one gains nothing, and waits by
spinning. Factorisations ask for it, and path analyses for all that they do between them."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from functools import cache
from typing import Any

from kirigami.primitives.processors import processors

LARGE = 4_000_000  # numbers in a factor from which on threads gain more than they cost


def one_thread() -> AbstractContextManager[Any]:
    """Keep BLAS and LAPACK to one thread where threadpoolctl is installed (extra "fast"); else change nothing."""
    controller = _controller()
    return nullcontext() if controller is None else controller.limit(limits=1, user_api="blas")


def threads_for(numbers: int) -> int:
    """How many threads a factorisation of that many numbers takes."""
    return processors() if numbers >= LARGE else 1


@cache
def _controller() -> Any:
    try:
        from threadpoolctl import ThreadpoolController
    except ImportError:
        return None
    import scipy.linalg.lapack  # noqa: F401  the controller knows only the libraries that are loaded by then

    return ThreadpoolController()
