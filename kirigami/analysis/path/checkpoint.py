"""Checkpoints: a path analysis that was killed goes on where it was, and finds the same curve.

A checkpoint is a results file of the steps so far, with what steers the walk beside it. It is replaced as a whole, so
whatever happens there is a good one. A fingerprint of model and analysis keeps it from being used for another run.
"""

from __future__ import annotations

import copy
import hashlib
import json
import os
import time
import warnings
from contextlib import suppress
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.analysis.path.points import Attempt, Point, State
from kirigami.errors import AnalysisError, KirigamiError, KirigamiWarning, ModelError
from kirigami.linalg import SingularMatrixError
from kirigami.model.model import Model
from kirigami.primitives.kernel import Kernel
from kirigami.primitives.node import Node
from kirigami.results.archive import pack, read, unpack_path, write
from kirigami.results.results import Results
from kirigami.results.step import Step
from kirigami.system.system import System

if TYPE_CHECKING:
    from kirigami.analysis.path.walk import Walk
    from kirigami.analysis.resumable import Remembering, Resumable

VERSION = 2  # of what is remembered; checkpoints of another one are refused
BUSY = 20  # a checkpoint waits until this many times the seconds that the last one took have passed


class Checkpoint:
    """The file of one run; writes when it costs little, and always when told to finish."""

    def __init__(self, path: str | os.PathLike[str], fingerprint: str) -> None:
        self.path, self.fingerprint = Path(path), fingerprint
        if self.path.is_dir():
            raise ModelError(f"checkpoint must be a file, but {self.path} is a folder")
        self._pending: tuple[Results, dict[str, Any]] | None = None
        self._next = 0.0
        self._warned = False

    def read(self) -> tuple[Results, dict[str, Any]] | None:
        """A bare Results with steps, events and stats, and the memory of the walk; None where there is no file."""
        if not self.path.exists():
            return None
        head, data = read(self.path)
        try:
            walk = json.loads(str(data["walk"]))
            if walk.get("version") != VERSION:
                raise AnalysisError(
                    f"{self.path} is a checkpoint of another version of kirigami and cannot be gone on with: give the "
                    "run a file of its own, or resume=False to replace it; kirigami.load reads its steps"
                )
            if walk["fingerprint"] != self.fingerprint:
                raise AnalysisError(
                    f"{self.path} is the checkpoint of another model or analysis: give the run a file of its own, or "
                    "resume=False to replace it"
                )
            results = Results.__new__(Results)
            results.steps, results.events = unpack_path(head, data)
            results.stats = head["stats"]
            memory = {**walk["memory"], **{name: data[f"walk.{name}"] for name in walk["arrays"]}}
        except (KeyError, IndexError, TypeError, ValueError) as error:
            raise AnalysisError(f"{self.path} is no checkpoint, or it is damaged ({error!r})") from None
        return results, memory

    def note(self, walk: Remembering) -> None:
        """Remember where a walk stands and, where the last writing is long enough ago, write it."""
        walk.count_seconds()
        snapshot = copy.copy(walk.results)  # what the next step adds must not get into the file without its memory
        snapshot.steps, snapshot.events = list(walk.results.steps), list(walk.results.events)
        snapshot.stats = dict(walk.results.stats)
        self._pending = snapshot, walk.memory
        if time.monotonic() >= self._next:
            self.finish()

    def finish(self) -> None:
        """Write the last step noted, unless it is written already."""
        if self._pending is None:
            return
        started = time.monotonic()
        results, memory = self._pending
        try:
            arrays = pack(results)
        except NotImplementedError:  # an effect that does not say how to save itself
            arrays = pack(results, with_kernels=False)
        plain: dict[str, Any] = {}
        named = []
        for key, value in memory.items():
            if isinstance(value, np.ndarray):
                arrays[f"walk.{key}"] = value
                named.append(key)
            else:
                plain[key] = value
        walk = {"version": VERSION, "fingerprint": self.fingerprint, "memory": plain, "arrays": named}
        arrays["walk"] = np.array(json.dumps(walk))
        try:
            write(self.path, arrays, compressed=False)
            self._pending = None
        except (OSError, KirigamiError) as error:
            if not self._warned:
                message = f"the checkpoint {self.path} cannot be written ({error}): the run goes on, to try again later"
                warnings.warn(message, KirigamiWarning, stacklevel=2)
            self._warned = True
        ended = time.monotonic()
        self._next = ended + BUSY * (ended - started)


def fingerprint(system: System, settings: Resumable) -> str:
    """A digest of a lowered model and of the settings of an analysis, but for where it ends by choice."""
    digest = hashlib.sha256()
    for name in ("rest", "unknown", "leader", "drive", "held"):
        _add(digest, getattr(system, name), system.model)
    if system.arcs:
        _add(digest, system.known(1.0), system.model)
    for kernel in system.kernels:
        _add(digest, [type(kernel).__name__, kernel.conn, _content(kernel)], system.model)
    _add(digest, [type(settings).__name__, settings.memorable()], system.model)
    return digest.hexdigest()


def _content(kernel: Kernel) -> dict[str, Any]:
    """What a kernel is made of: its own account of it or, where it has none, its attributes."""
    try:
        return kernel.arrays()
    except NotImplementedError:
        return vars(kernel)


def _add(digest: Any, value: Any, model: Model) -> None:
    if isinstance(value, np.ndarray) and value.dtype != object:
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
    elif value is None or isinstance(value, (bool, int, float, complex, str, bytes, np.generic)):
        digest.update(f"{type(value).__name__}:{value!r};".encode())
    elif isinstance(value, (list, tuple, np.ndarray)):
        digest.update(f"[{len(value)}".encode())
        for item in value:
            _add(digest, item, model)
    elif isinstance(value, dict):
        for key in sorted(value, key=str):
            digest.update(f"{key}=".encode())
            _add(digest, value[key], model)
    elif isinstance(value, Node):
        digest.update(f"node {model.index(value)[0]};".encode())
    elif isinstance(value, Step):
        _add(digest, [value.lam, value.u, value.inner, list(value.history), value.stage], model)
    elif is_dataclass(value) and not isinstance(value, type):
        content = {field.name: getattr(value, field.name) for field in fields(value)}
        _add(digest, [type(value).__qualname__, content], model)
    else:
        raise AnalysisError(
            f"a checkpoint cannot tell this run from another one, because it does not know what a "
            f"{type(value).__name__} holds: let arrays() of the kernel return numbers, text and arrays, or run "
            "without checkpoint"
        )


def resume(walk: Walk, start: State, stored: Results, memory: dict[str, Any]) -> Point:
    """Bring a walk to where a checkpoint left it."""
    system, results = walk.system, walk.results
    walk.memory = memory
    # The order of elimination comes from the first matrix, and the last bits of every solution from the order.
    with suppress(SingularMatrixError):
        walk.factorize_blocks(system.stiffness_blocks(start.u, start.lam))
    for step in stored.steps:
        results.append(step)
    results.events.extend(stored.events)
    last, before = results[-1], results[max(len(results) - 2, 0)]
    q = system.unknowns(system.joined(last.u, last.inner))
    state = State(q, last.lam, system.displacement(q, last.lam))
    system.history = before.history  # as it was when the tangent was taken
    attempt = Attempt(state, True, last.residual, 0)
    try:
        attempt.stiffness = walk.steps.retake(state)
        tangent = walk.tangent_at(attempt)
    except SingularMatrixError:
        tangent = None
    if tangent is None:
        raise AnalysisError("the last step of the checkpoint is singular: it was not written by this version")
    system.history = last.history
    results.stats = stored.stats
    walk.take_seconds(stored.stats["seconds"])
    return Point(state, tangent, last.history)
