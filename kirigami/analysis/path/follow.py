"""Running a path analysis: a walk, a checkpoint, a progress bar, and what becomes of an interruption or a failure."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable

from kirigami.analysis.path.checkpoint import Checkpoint, fingerprint
from kirigami.analysis.path.settings import PathSettings
from kirigami.analysis.path.walk import Recorder, Walk
from kirigami.errors import ConvergenceError, KirigamiWarning
from kirigami.linalg import one_thread
from kirigami.primitives.checks import require_boolean, require_callable, require_choice, require_items, require_path
from kirigami.progress import progress_bar
from kirigami.results.results import Results
from kirigami.results.step import Event


class PathAnalysis(PathSettings):
    """Common part of the path methods; see :class:`LoadControl`, :class:`DisplacementControl`, :class:`ArcLength`."""

    def run(
        self,
        progress: bool = False,
        recorders: Iterable[Recorder] = (),
        on_failure: str = "raise",
        checkpoint: str | os.PathLike[str] | None = None,
        resume: bool = True,
    ) -> Results:
        """Follow the path.

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
                walk.write_checkpoint()
                lam = results.steps[-1].lam if results.steps else 0.0
                message = f"interrupted after {len(results)} steps at load factor {lam:.6g}"
                results.events.append(Event("interrupted", lam, len(results) - 1, message))
                warnings.warn(message, KirigamiWarning, stacklevel=2)
            except ConvergenceError as error:
                walk.write_checkpoint()
                walk.finish()
                if on_failure == "raise":
                    raise
                lam = results.steps[-1].lam if results.steps else 0.0
                results.events.append(Event("failed", lam, len(results) - 1, str(error)))
                warnings.warn(str(error), KirigamiWarning, stacklevel=2)
        walk.write_checkpoint()
        return walk.finish()

    def _make_walk(self, recorders: Iterable[Recorder]) -> Walk:
        return Walk(self, recorders)
