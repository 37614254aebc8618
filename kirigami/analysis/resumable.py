"""Analyses that go on from a checkpoint: a file, a progress bar, and what becomes of an interruption or a failure."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterable
from typing import Any, Protocol

from kirigami.analysis.base import Analysis
from kirigami.analysis.path.checkpoint import Checkpoint, fingerprint
from kirigami.errors import ConvergenceError, KirigamiWarning
from kirigami.linalg import one_thread
from kirigami.primitives.checks import require_boolean, require_callable, require_choice, require_items, require_path
from kirigami.progress import ProgressBar, progress_bar
from kirigami.results.crossing import note_crossings
from kirigami.results.results import Results
from kirigami.results.step import Event, Step
from kirigami.results.touching import note_contacts
from kirigami.system.system import System
from kirigami.words import counted

Recorder = Callable[[Step], None]


class Remembering(Protocol):
    """A run whose state between two steps is its results and some numbers."""

    results: Results

    @property
    def memory(self) -> dict[str, Any]:
        """What must be stored to go on later as if nothing had been."""

    def count_seconds(self) -> None:
        """Bring the seconds and steps in the stats up to date."""


class Walker(Protocol):
    """A run that stores steps one by one, and can go on from what a checkpoint remembers."""

    system: System
    results: Results
    checkpoint: Checkpoint | None
    bar: ProgressBar

    def follow(self, stored: tuple[Results, dict[str, Any]] | None) -> None:
        """Go from the start, or from where a checkpoint left off, to the end."""

    def where(self) -> str:
        """How far it has come, in words."""

    def finish(self) -> Results:
        """The results, once all is in them."""


class Resumable(Analysis):
    """An analysis whose run can be interrupted and resumed."""

    def memorable(self) -> dict[str, Any]:
        """What tells this analysis from another one of the same model; where it ends by choice does not."""
        free = ("model", "results", "stop", "max_steps")
        return {name: value for name, value in vars(self).items() if name not in free and name[0] != "_"}

    def _make_walk(self, recorders: Iterable[Recorder]) -> Walker:
        raise NotImplementedError

    def run(
        self,
        progress: bool = False,
        recorders: Iterable[Recorder] = (),
        on_failure: str = "raise",
        checkpoint: str | os.PathLike[str] | None = None,
        resume: bool = True,
    ) -> Results:
        """Compute step by step.

        Parameters
        ----------
        progress : bool
            Show a progress bar.
        recorders : iterable of callables
            Each is called with every stored :class:`Step`.
        on_failure : {"raise", "return"}
            What to do where no equilibrium is found: raise a ConvergenceError, or return the results so far with a
            warning and an event.
        checkpoint : path, optional
            A file that is kept up to date with every accepted step (or so often that writing takes a twentieth of the
            time), so that nothing is lost when the process is killed. :func:`kirigami.load` reads it as results.
            Where it cannot be written, as on a full disk, a warning says so and the run goes on.
        resume : bool
            Whether to go on from the checkpoint where there is one: the same call finishes what was begun, with the
            same curve as without the interruption. False starts anew and replaces it.

        Returns
        -------
        Results
            Every accepted step. After Ctrl-C: those found until then, with an event that says so.

        Raises
        ------
        ModelError, MechanismError
            The model cannot be analysed as it is.
        ConvergenceError
            No equilibrium at the smallest increment; it carries the results so far.
        AnalysisError
            The checkpoint belongs to another model or analysis, or is damaged; it is left as it is.
        """
        owner = f"{type(self).__name__}.run"
        require_choice(on_failure, ("raise", "return"), "on_failure", owner)
        require_boolean(progress, "progress", owner)
        require_boolean(resume, "resume", owner)
        file = None if checkpoint is None else require_path(checkpoint, "checkpoint", owner)
        listeners = [require_callable(one, "recorders", owner) for one in require_items(recorders, "recorders", owner)]
        walk = self._make_walk(listeners)
        stored = None
        if file is not None:
            walk.checkpoint = Checkpoint(file, fingerprint(walk.system, self))
            stored = walk.checkpoint.read() if resume else None
        results = walk.results
        with one_thread(), progress_bar(progress, type(self).__name__) as walk.bar:
            try:
                walk.follow(stored)
            except KeyboardInterrupt:
                self._write(walk)
                lam = results.steps[-1].lam if results.steps else 0.0
                message = f"interrupted after {counted(len(results), 'step')} at {walk.where()}"
                results.events.append(Event("interrupted", lam, len(results) - 1, message))
                warnings.warn(message, KirigamiWarning, stacklevel=2)
            except ConvergenceError as error:
                self._write(walk)
                _note(results)
                walk.finish()
                if on_failure == "raise":
                    raise
                lam = results.steps[-1].lam if results.steps else 0.0
                results.events.append(Event("failed", lam, len(results) - 1, str(error)))
                warnings.warn(str(error), KirigamiWarning, stacklevel=2)
        self._write(walk)
        _note(results)
        return walk.finish()

    @staticmethod
    def _write(walk: Walker) -> None:
        """Write what the checkpoint, if there is one, has not written yet."""
        if walk.checkpoint is not None:
            walk.checkpoint.finish()


def _note(results: Results) -> None:
    """Tell, now that all steps are stored, in which of them a sheet touches or crosses itself."""
    note_contacts(results)
    note_crossings(results)
