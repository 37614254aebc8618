"""One thread of BLAS: on blocks of some hundred rows and on dot products a second one gains nothing, and waits by
spinning. Factorisations ask for it, and path analyses for all that they do between them."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from functools import cache
from typing import Any


def one_thread() -> AbstractContextManager[Any]:
    """Keep BLAS and LAPACK to one thread where threadpoolctl is installed (extra "fast"); else change nothing."""
    controller = _controller()
    return nullcontext() if controller is None else controller.limit(limits=1, user_api="blas")


@cache
def _controller() -> Any:
    try:
        from threadpoolctl import ThreadpoolController
    except ImportError:
        return None
    import scipy.linalg.lapack  # noqa: F401  the controller knows only the libraries that are loaded by then

    return ThreadpoolController()
