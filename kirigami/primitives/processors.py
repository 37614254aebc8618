"""How many processors a computation may use."""

from __future__ import annotations

import os

LIMITS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")  # what users and queues set, and parallel sweeps for their workers


def processors() -> int:
    """Those that this process may run on, at most what OMP_NUM_THREADS or OPENBLAS_NUM_THREADS say."""
    here = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    told = [int(value) for value in map(os.environ.get, LIMITS) if value and value.isdigit() and int(value) > 0]
    return min([here, *told])
