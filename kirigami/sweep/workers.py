"""What runs the designs of a sweep: processes on this computer, or an executor that the user brings."""

from __future__ import annotations

import math
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from concurrent.futures.process import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing.connection import wait
from typing import Any

import numpy as np

from kirigami.errors import AnalysisError, ModelError
from kirigami.version import __version__

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
Row = dict[str, Any]


class Runner:
    """An executor given by the user; its breakdown ends the run."""

    broken = False  # whether a process died, and everything under way has to be sent out again

    def __init__(self, executor: Any) -> None:
        is_client = hasattr(executor, "get_executor")
        self.client = executor if is_client else getattr(executor, "_client", None)
        self.executor: Executor = executor.get_executor(pure=False) if is_client else executor

    def room(self) -> int:
        """How many designs may be out at a time."""
        if self.client is not None:  # a cluster grows and shrinks; two for each thread keep it busy
            return 2 * max(1, sum(int(threads) for threads in self.client.nthreads().values()))
        return int(getattr(self.executor, "_max_workers", sys.maxsize))

    def submit(self, function: Callable[..., Any], arguments: Row) -> Future[Row]:
        """Send out one design."""
        try:
            return self.executor.submit(_attempt, function, arguments)
        except RuntimeError as error:  # shut down, or broken
            raise _breakdown(error) from error

    def outcome(self, future: Future[Row]) -> Row | None:
        """What a finished future says; None if it has to be sent out again."""
        try:
            return future.result()
        except (BrokenExecutor, CancelledError) as error:
            raise _breakdown(error) from error
        except Exception as error:  # a cluster that gave the design up
            return failure(message_of(error), None)

    def renew(self) -> None:
        """Replace what died."""


class Processes(Runner):
    """Processes on this computer; when one dies, new ones take over."""

    def __init__(self, function: Callable[..., Any], workers: int) -> None:
        self.client, self.function, self.workers = None, function, workers
        self.executor: ProcessPoolExecutor = self._start()

    def _start(self) -> ProcessPoolExecutor:
        pool = ProcessPoolExecutor(self.workers, multiprocessing.get_context("spawn"), _follow_parent)
        try:
            pool.submit(_greet, self.function).result()
        except BrokenExecutor as error:
            raise AnalysisError(
                f"no worker process could start with {name_of(self.function)}: its message stands above. A script that "
                "runs a sweep must do so under `if __name__ == '__main__':`; a function typed into a notebook must go "
                "into a module, or run with a ThreadPoolExecutor or on Dask"
            ) from error
        return pool

    def submit(self, function: Callable[..., Any], arguments: Row) -> Future[Row]:
        try:
            return self.executor.submit(_attempt, function, arguments)
        except BrokenExecutor as error:  # died since the last design
            future: Future[Row] = Future()
            future.set_exception(error)
            return future

    def outcome(self, future: Future[Row]) -> Row | None:
        try:
            return future.result()
        except BrokenExecutor:
            self.broken = True
            return None

    def renew(self) -> None:
        self.close()
        self.executor, self.broken = self._start(), False

    def close(self) -> None:
        """End the processes, with or without work at hand."""
        processes = list((self.executor._processes or {}).values())
        self.executor.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()
            process.join()


def _breakdown(error: BaseException) -> AnalysisError:
    return AnalysisError(
        f"the executor broke down ({message_of(error)}); every finished design is saved: make a new executor and run "
        "the sweep again to go on"
    )


@contextmanager
def runner_for(executor: Any, function: Callable[..., Any], workers: int | None, designs: int) -> Iterator[Runner]:
    """What runs the designs, ended afterwards if it was started here."""
    if executor is None and getattr(multiprocessing.current_process(), "_inheriting", False):
        # A worker that has just been started reads the main script, and came upon the sweep in there.
        raise AnalysisError("a script that runs a sweep must do so under `if __name__ == '__main__':`")
    if executor is None or isinstance(executor, ProcessPoolExecutor):
        try:
            pickle.dumps(function)
        except Exception as error:
            raise ModelError(
                f"{name_of(function)} cannot be sent to other processes: define it at the top of a module or "
                f"script ({error})"
            ) from error
    if executor is not None:
        yield Runner(executor)
        return
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update({name: "1" for name, value in before.items() if value is None})  # one thread for each worker
    try:
        processes = Processes(function, min(workers or available, designs))
        try:
            yield processes
        finally:
            processes.close()
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)


def _follow_parent() -> None:
    """End with the parent even when it is killed, instead of waiting for work for ever."""
    parent = multiprocessing.parent_process()

    def watch(sentinel: int) -> None:
        wait([sentinel])
        os._exit(1)

    if parent is not None:
        threading.Thread(target=watch, args=(parent.sentinel,), daemon=True).start()


def _greet(function: Callable[..., Any]) -> bool:
    """Shows that a worker can start and knows the function."""
    return callable(function)


def _attempt(function: Callable[..., Any], arguments: Row) -> Row:
    """Evaluate one design, in the worker."""
    if multiprocessing.parent_process() is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent; half an analysis is no result
    begin = time.perf_counter()
    try:
        values = plain_values(function(**arguments))
    except (Exception, SystemExit) as error:
        return failure(message_of(error), time.perf_counter() - begin)
    return _outcome("done", values, None, time.perf_counter() - begin)


def failure(message: str, seconds: float | None) -> Row:
    """The record of a design that failed."""
    return _outcome("failed", {}, message, seconds)


def _outcome(status: str, values: Row, error: str | None, seconds: float | None) -> Row:
    return {"status": status, "values": values, "error": error, "seconds": seconds, "version": __version__}


def plain_values(returned: Any) -> Row:
    """What the function returned, by name."""
    values = returned if isinstance(returned, Mapping) else {"value": returned}
    if any(not isinstance(name, str) for name in values):
        raise ModelError("what the function returns must be named by words")
    return {name: plain(value, repr(name)) for name, value in values.items()}


def plain(value: Any, what: str) -> Any:
    """A number, a word or a truth value of plain Python."""
    if isinstance(value, (np.generic, np.ndarray)) and np.ndim(value) == 0:
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        raise ModelError(f"{what} is {value}, not a finite number")
    if not isinstance(value, (bool, int, float, str)):
        raise ModelError(f"{what} must be a number or a word, got {type(value).__name__}")
    return value


def name_of(function: Callable[..., Any]) -> str:
    """The name of a function, with the arguments that are bound to it."""
    if isinstance(function, partial):
        bound = [*map(repr, function.args), *(f"{name}={value!r}" for name, value in function.keywords.items())]
        return f"{name_of(function.func)}({', '.join(bound)})"
    return str(getattr(function, "__qualname__", type(function).__qualname__))


def message_of(error: BaseException) -> str:
    """Kind and text of an error in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())[:500]
