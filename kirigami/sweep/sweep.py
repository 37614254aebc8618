"""Parameter studies: one function, many designs, any number of processors, and nothing lost on the way."""

from __future__ import annotations

import inspect
import os
import sys
import time
import warnings
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import Any

import numpy as np

from kirigami.errors import KirigamiWarning, ModelError
from kirigami.primitives.checks import (
    require_boolean,
    require_callable,
    require_executor,
    require_finite,
    require_items,
    require_whole,
    shown,
)
from kirigami.sweep.table import RESERVED, Row, SweepLog, SweepTable, log_path
from kirigami.sweep.workers import Runner, failure, name_of, plain, runner_for
from kirigami.words import counted

TABLE_PAUSE = 5.0  # shortest time between two copies of the table while designs come in [s]
LOOK_AROUND = 1.0  # longest time without a look at Ctrl-C and at new workers [s]
DIED = "the worker process ended without an answer: for want of memory, or by a crash"


class Sweep:
    """A function evaluated for many designs, on many processors, in a table that survives interruption.

    Every finished design goes at once, and for good, into the log ``path.jsonl``; the table ``path.csv`` (and
    ``path.parquet`` where pyarrow is installed) is made from it. Run the same script again after Ctrl-C, a crash or a
    power cut, and it goes on where it was. A design whose function raises becomes a row with status "failed" and the
    message; so does one that takes its process down with it.

    Parameters
    ----------
    function : callable
        Called with the parameters of a design as keywords; returns one number, or a mapping of names to numbers or
        words. If it has a parameter ``seed`` it is given the seed of the design.
    designs : sequence of mappings, mapping of columns, or pandas.DataFrame
        Parameters of each design: numbers or words. Constants belong here too, so that the table holds them. A
        parameter ``seed`` takes the place of the seeds made here.
    path : path
        Where the log and the table go, with or without ``.csv``.
    seed : int
        From it and the number of the design follows the seed of each design.

    Raises
    ------
    ModelError
        No designs, parameters that differ between designs or that the function does not take, values that are not
        finite numbers or words, or a name that the table needs for itself.

    Notes
    -----
    On a Dask cluster, with this package installed on every worker::

        from dask.distributed import Client
        table = kg.Sweep(function, designs, "table.csv").run(Client("scheduler:8786"))

    Every design carries its parameters, seed, seconds, the version of this package, status and error into the table.

    Examples
    --------
    >>> import kirigami as kg
    >>> import math, tempfile
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> def area(radius):
    ...     return {"area": math.pi * radius**2}
    >>> path = tempfile.mkdtemp() + "/areas.csv"
    >>> with ThreadPoolExecutor(2) as pool:
    ...     table = kg.Sweep(area, [{"radius": 1.0}, {"radius": 2.0}], path).run(pool)
    >>> table["area"].round(3).tolist()
    [3.142, 12.566]
    """

    def __init__(
        self,
        function: Callable[..., Any],
        designs: Sequence[Mapping[str, Any]] | Mapping[str, Any],
        path: str | os.PathLike[str],
        *,
        seed: int = 0,
    ) -> None:
        self.function = require_callable(function, "function", "Sweep")
        seed = require_whole(seed, "seed", "Sweep", least=0)
        self.designs = _plain_designs(designs)
        self.path = log_path(path)
        self.seeds = [design.get("seed", _seed(seed, number)) for number, design in enumerate(self.designs)]
        self._seeded = _takes(function, self.designs[0])

    def run(
        self,
        executor: Any = None,
        *,
        workers: int | None = None,
        progress: bool = False,
        retry_failed: bool = False,
        time_limit: float | None = None,
    ) -> SweepTable:
        """Compute the designs that are not in the log yet.

        Parameters
        ----------
        executor : concurrent.futures.Executor or dask.distributed.Client, optional
            What runs the designs; None uses processes on this computer. On a cluster this package must be installed on
            every worker.
        workers : int, optional
            Number of processes, if `executor` is None; None takes one for each processor.
        progress : bool
            Show how far it is.
        retry_failed : bool
            Compute the failed designs once more.
        time_limit : float, optional
            Start no design later than this [s]; the rest is left for the next run.

        Returns
        -------
        SweepTable
            All designs; after Ctrl-C or the time limit some of them with status "missing", and a warning.

        Raises
        ------
        AnalysisError
            The log at the path is damaged, in use or of other designs; or the executor broke down, with every finished
            design on the disk.
        ModelError
            `executor` is none, the function cannot be sent to it, or it returns a name that is a parameter.
        """
        require_executor(executor, "Sweep.run")
        if workers is not None:
            workers = require_whole(workers, "workers", "Sweep.run", least=1)
        require_boolean(progress, "progress", "Sweep.run")
        require_boolean(retry_failed, "retry_failed", "Sweep.run")
        if time_limit is not None:
            time_limit = require_finite(time_limit, "time_limit", "Sweep.run")
        header = {"function": name_of(self.function), "designs": self.designs, "seeds": self.seeds}
        with SweepLog(self.path, header) as log:
            if log.repaired:
                _warn(f"{self.path}: the last line was cut off by an interruption, its design is computed again")
            wanted = ("missing", "failed") if retry_failed else ("missing",)
            todo = [row["design"] for row in log.table() if row["status"] in wanted]
            early = ""
            log.table().write(self.path)  # where this fails nothing is computed in vain
            try:
                if todo:
                    with runner_for(executor, self.function, workers, len(todo)) as runner:
                        early = self._compute(runner, log, todo, progress, time_limit)
            finally:
                table = log.table()
                table.write(self.path)
        if early:
            _warn(f"{early}: {len(table.missing)} of {counted(len(table), 'design')} missing; run again to go on")
        return table

    def _compute(self, runner: Runner, log: SweepLog, todo: list[int], progress: bool, time_limit: float | None) -> str:
        """Send out designs and write down what comes back; why it ended early, or nothing."""
        begin = written = time.monotonic()
        waiting, suspects = deque(todo), deque[int]()
        accused: set[int] = set()  # may have taken a worker down
        running: dict[Future[Row], int] = {}
        with _Progress(progress, len(self.designs), len(self.designs) - len(todo)) as bar:
            try:
                while waiting or suspects or running:
                    late = time_limit is not None and time.monotonic() - begin > time_limit
                    if late and not running:
                        return "time limit"
                    while not late and (suspects or waiting):
                        # An accused design goes alone: if a worker dies once more, it was that design.
                        alone = bool(suspects) or not accused.isdisjoint(running.values())
                        if len(running) >= (1 if alone else runner.room()):
                            break
                        number = (suspects or waiting).popleft()
                        running[runner.submit(self.function, self._arguments(number))] = number
                    for future in wait(running, LOOK_AROUND, FIRST_COMPLETED).done:
                        outcome = runner.outcome(future)
                        if outcome is not None:
                            self._keep(log, running[future], outcome)
                            accused.discard(running.pop(future))
                            bar.move()
                    if runner.broken:
                        crashed = sorted(running.values())
                        running.clear()
                        runner.renew()
                        if len(crashed) == 1 and crashed[0] in accused:
                            self._keep(log, crashed[0], failure(DIED, None))
                            bar.move()
                        else:
                            accused.update(crashed)
                            suspects.extend(crashed)
                    if time.monotonic() - written > TABLE_PAUSE:
                        log.table().write(self.path)
                        written = time.monotonic()
            except KeyboardInterrupt:
                for future, number in running.items():  # finished, but not yet written down
                    if future.done() and not future.cancelled() and future.exception() is None:
                        self._keep(log, number, future.result())
                return "interrupted"
            finally:
                for future in running:
                    future.cancel()
        return ""

    def _arguments(self, number: int) -> Row:
        extra = {"seed": self.seeds[number]} if self._seeded else {}
        return self.designs[number] | extra

    def _keep(self, log: SweepLog, number: int, outcome: Row) -> None:
        taken = {*self.designs[number], "seed", *RESERVED} & set(outcome["values"])
        if taken:
            raise ModelError(f"Sweep: {name_of(self.function)} returns {sorted(taken)[0]!r}, already a column: "
                             "give it another name")  # fmt: skip
        log.append({"design": number, **outcome})


# ---- what goes in and comes out


def _plain_designs(designs: Any) -> list[Row]:
    if hasattr(designs, "to_dict") and hasattr(designs, "columns"):  # pandas.DataFrame
        if not designs.columns.is_unique:
            raise ModelError("Sweep: two columns of the designs have the same name")
        designs = designs.to_dict("records")
    elif isinstance(designs, Mapping):
        columns = {name: require_items(values, str(name), "Sweep") for name, values in designs.items()}
        if len({len(values) for values in columns.values()}) > 1:
            raise ModelError("Sweep: the columns of the designs differ in length")
        designs = [dict(zip(columns, values)) for values in zip(*columns.values())]
    listed = require_items(designs, "designs", "Sweep")
    if not listed:
        raise ModelError("Sweep: there are no designs")
    checked = []
    for number, design in enumerate(listed):
        if not isinstance(design, Mapping) or not design:
            raise ModelError(f"Sweep: design {number} must be a mapping of parameters to values, got {shown(design)}")
        if set(design) != set(listed[0]):
            name = sorted(map(str, set(design) ^ set(listed[0])))[0]
            raise ModelError(f"Sweep: every design needs the same parameters, but {name!r} is not in both of design 0 "
                             f"and design {number}")  # fmt: skip
        checked.append({name: plain(value, f"{name!r} of design {number}") for name, value in design.items()})
    for name in checked[0]:
        if not isinstance(name, str) or not name or name in RESERVED:
            raise ModelError(f"Sweep: a parameter cannot be called {name!r}; the table needs {', '.join(RESERVED)}")
    return checked


def _seed(seed: int, number: int) -> int:
    """Seed of one design; those of two designs, or from two seeds, have nothing to do with each other."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1)[0])


def _takes(function: Callable[..., Any], design: Row) -> bool:
    """Whether the function is to be given a seed; an error if it does not take the parameters."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return False
    seeded = "seed" in signature.parameters and "seed" not in design
    try:
        signature.bind(**design, **({"seed": 0} if seeded else {}))
    except TypeError as error:
        raise ModelError(f"Sweep: {name_of(function)}{signature} cannot be called with the parameters "
                         f"{', '.join(map(str, design))}: {error}") from None  # fmt: skip
    return seeded


def _warn(message: str) -> None:
    warnings.warn(message, KirigamiWarning, stacklevel=3)


class _Progress:
    """A tqdm bar where tqdm is installed, else lines of text."""

    def __init__(self, shown: bool, total: int, done: int) -> None:
        self.shown, self.total, self.done = shown, total, done
        self._bar: Any = None

    def __enter__(self) -> _Progress:
        if self.shown:
            try:
                from tqdm.auto import tqdm

                self._bar = tqdm(total=self.total, initial=self.done, desc="Sweep", unit=" designs")
            except ImportError:
                pass
        return self

    def move(self) -> None:
        self.done += 1
        if self._bar is not None:
            self._bar.update(1)
        elif self.shown:
            print(f"Sweep: {self.done} of {counted(self.total, 'design')}", file=sys.stderr)

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()
