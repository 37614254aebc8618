"""The trials of a search for shapes: which starts, run where, and written down so that a search can go on."""

from __future__ import annotations

import base64
import json
import pickle
import threading
import time
import zlib
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from kirigami.errors import AnalysisError, KirigamiError, ModelError
from kirigami.files import whole_file
from kirigami.model.model import Model
from kirigami.primitives.kernel import Array
from kirigami.study.imperfect import bending_field
from kirigami.study.shape.moves import Moves, Trial
from kirigami.study.shape.relaxation import Relaxer
from kirigami.sweep.workers import Row, failure, message_of, runner_for

FIRST, EVERY, SEEDED = 4, 3, 12  # the first trials and every third, so many in all, start from fields and modes
SHARE = 0.02  # share of the load factor at which a flat sheet is seeded: beyond its first buckles, and not by far
HEIGHT = 0.02  # of a seed, over the size of the structure
FORMAT = 1


def start_of(
    number: int, seed: int, moves: Moves, shapes: Sequence[Array], names: Sequence[int], tried: Collection[str]
) -> Trial:
    """Where a trial starts, by its number and what was found and tried before it, and by nothing else."""
    random = np.random.default_rng([seed, number])
    seeded = number if number < FIRST else FIRST + (number - FIRST) // EVERY
    if shapes and ((number >= FIRST and (number - FIRST) % EVERY) or seeded >= SEEDED):
        return moves.trial(random, shapes, names, tried)
    share = SHARE if moves.flat else 1.0
    try:
        if seeded % 2 == 0 and moves.model.dim == 3:
            shape, told = bending_field(moves.model, seed + seeded // 2), f"random field {seed + seeded // 2}"
        else:
            mode = seeded // 2 % len(moves.modes)
            shape, told = moves.modes[mode], f"mode {mode + 1}"
    except KirigamiError:  # nothing that bends and resists bending, as in a truss
        shape, told = moves.shake(random, np.zeros_like(moves.rest))[0], "random displacements"
    height = HEIGHT * moves.size / float(np.abs(shape).max())
    return Trial(shape * height * float(random.choice((1.0, -1.0))), share, told)


class Descents:
    """Runs trials: in this process, or in others; a callable that can be sent to them."""

    def __init__(self, model: Model, at: float, tol: float) -> None:
        self.__qualname__ = "descent to a stable shape"  # in messages; on the class it would break pickling
        self.at, self.tol = at, tol
        self._model = pickle.dumps(model)
        self._key = zlib.crc32(self._model)

    def relaxer(self) -> Relaxer:
        """The lowered model, made once in each thread."""
        key = (self._key, self.at, self.tol)
        if getattr(_LAST, "key", None) != key:
            _LAST.key, _LAST.relaxer = key, Relaxer(pickle.loads(self._model), self.at, self.tol)
        found: Relaxer = _LAST.relaxer
        return found

    def __call__(self, start: str, share: float) -> Row:
        began = time.thread_time()
        relaxer = self.relaxer()
        before = relaxer.factorizations
        found = relaxer.relax(from_text(start), share)
        return {
            "energy": found.energy,
            "force": "" if np.isnan(found.force) else found.force,
            "u": as_text(found.step.u),
            "factorizations": relaxer.factorizations - before,
            "cpu": time.thread_time() - began,
        }


_LAST = threading.local()  # the relaxer used last, and its key

Run = Callable[[Sequence[Trial]], list[Row]]


@contextmanager
def running(descents: Descents, executor: Executor | None, workers: int | None) -> Iterator[Run]:
    """What runs a round of trials, each to a row with its status."""
    if executor is None and workers in (None, 1):
        yield lambda trials: [_attempt(descents, trial) for trial in trials]
        return
    with runner_for(executor, descents, workers, workers or 1) as runner:

        def run(trials: Sequence[Trial]) -> list[Row]:
            rows: list[Row | None] = [None] * len(trials)
            for again in (True, False):  # a process that dies is replaced, and its trials are sent out once more
                sent = {
                    k: runner.submit(descents, {"start": as_text(trial.u), "share": trial.share})
                    for k, trial in enumerate(trials)
                    if rows[k] is None
                }
                for k, future in sent.items():
                    rows[k] = runner.outcome(future)
                if runner.broken and again:
                    runner.renew()
            return [failure("the worker process ended without an answer", None) if r is None else r for r in rows]

        yield run


def _attempt(descents: Descents, trial: Trial) -> Row:
    try:
        return {"status": "done", "values": descents(as_text(trial.u), trial.share), "error": None}
    except KirigamiError as error:
        return failure(message_of(error), None)


class TrialLog:
    """The trials done, in a file of lines of JSON that only grows; in memory alone without a path."""

    def __init__(self, path: Path | None, header: Row) -> None:
        self.path = path
        self.rows: list[Row] = []
        if path is None:
            return
        head = {"format": FORMAT, **header}
        if not path.exists():
            with whole_file(path) as unfinished:
                unfinished.write_text(json.dumps(head) + "\n", encoding="utf-8")
            return
        try:
            lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
            if json.loads(lines[0]) != head:
                raise AnalysisError(
                    f"{path} is the search of another model or with other arguments: give this one a file of its own"
                )
            whole = [line for line in lines[1:] if line.endswith("\n")]  # the last one may have been cut off
            self.rows = [json.loads(line) for line in whole]
            if len(whole) + 1 < len(lines):
                with whole_file(path) as unfinished:
                    unfinished.write_text("".join([lines[0], *whole]), encoding="utf-8")
        except (OSError, ValueError, IndexError) as error:
            raise AnalysisError(f"{path} cannot be read as the log of a search for shapes ({error})") from None

    def append(self, row: Row) -> None:
        """Write down one more trial."""
        self.rows.append(row)
        if self.path is not None:
            try:
                with self.path.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
            except OSError as error:
                raise AnalysisError(f"cannot write {self.path}: {error.strerror or error}") from error


def as_text(u: Array) -> str:
    """Displacements (n, 3) as a word."""
    return base64.b85encode(zlib.compress(np.ascontiguousarray(u, dtype="<f8").tobytes(), 1)).decode()


def from_text(word: str) -> Array:
    """The displacements (n, 3) of a word."""
    try:
        raw = zlib.decompress(base64.b85decode(word))
    except (ValueError, zlib.error) as error:
        raise ModelError(f"a shape of the log is damaged ({error})") from None
    found: Array = np.frombuffer(raw, "<f8").reshape(-1, 3).copy()
    return found
