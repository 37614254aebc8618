"""What all analyses share: a system, a state that is committed or reverted, counted factorisations, results."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kirigami.errors import ConvergenceError, ModelError
from kirigami.linalg import Factor, SingularMatrixError, make_solver
from kirigami.model.model import Model
from kirigami.primitives.checks import require_instance
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.step import Step
from kirigami.results.yielding import YieldWatch
from kirigami.system.supports import check_floppy
from kirigami.system.system import System
from kirigami.words import counted


class Analysis:
    """Base of all analyses: a description of what to do with a model, which :meth:`run` lowers anew each time.

    What a run needs and finds belongs to its own :class:`Run`, so one analysis may run again, and in several threads at
    once; ``results`` are those of the run begun last, in reach also after an interruption.
    """

    def __init__(self, model: Model) -> None:
        self.model = require_instance(model, Model, "model", type(self).__name__)
        self.results: Results | None = None


class Run:
    """One run of an analysis: the lowered model, its results, the solver, and what is counted.

    Attributes
    ----------
    system : System
        The model as it stood when the run began.
    results : Results
        What is found; its ``stats`` are kept here.
    """

    def __init__(self, analysis: Analysis, linear: bool = False, apart: Sequence[Any] = ()) -> None:
        self._started = time.perf_counter()
        self._solver = make_solver()
        self.system = System(analysis.model, apart)
        self.results = Results(self.system, linear=linear)
        self.results.stats["unknowns"] = self.system.free
        self._yields = YieldWatch(self.results)
        start = getattr(analysis, "start", None)
        self._before: Step | None = start if isinstance(start, Step) else None  # the last step there is
        analysis.results = self.results

    def factorize(self, matrix: Any) -> Factor:
        """Factor a matrix over the unknowns."""
        with self.system.clock("factorization"):
            factor = self._solver.factorize(matrix)
        self.results.stats["factorizations"] += 1
        self.results.stats["backend"] = factor.backend
        return factor

    def first_factor(self, u: Array, lam: float) -> tuple[Array, Factor]:
        """Blocks and factor of the starting state, or a MechanismError in words."""
        system = self.system
        blocks = system.stiffness_blocks(u, lam)
        matrix = system.matrix(blocks)
        try:
            factor = self.factorize(matrix)
        except SingularMatrixError:
            with system.clock("checks"):
                check_floppy(system, matrix, None)
            raise
        with system.clock("checks"):
            check_floppy(system, matrix, factor)
        return blocks, factor

    def begin_at(self, start: Step | None) -> tuple[Array, float]:
        """Unknowns and load factor where the run begins: at rest, or at a given step."""
        system = self.system
        lam, u = 0.0, np.zeros_like(system.rest)
        if start is not None:
            if start.u.shape[0] != system.points:
                raise ModelError(
                    f"start has {counted(start.u.shape[0], 'node')}, the model has {system.points}: it is of another "
                    "model"
                )
            u = system.joined(start.u, start.inner)
            if start.stage == system.model.stage:
                lam = start.lam
            else:
                system.start_stage(u)
            error = system.constraint_error(u, lam)
            if error > 1e-6 * system.size:
                raise ModelError(
                    f"start does not satisfy the constraints at load factor {lam:.6g} (off by {error:.3g}): "
                    "after changing supports call model.hold(step), which keeps what the earlier stage drove"
                )
        q = system.unknowns(u)
        if start is not None:
            system.go_on_from(start.history, system.displacement(q, lam), lam, start.stage != system.model.stage)
        system.check_start(system.displacement(q, lam))
        return q, lam

    def make_step(self, u: Array, lam: float, negative: int | None, residual: float, iterations: int) -> Step:
        """A step to store from an equilibrium, with the residual measured against the reactions as well.

        Raises a ConvergenceError where a force or the energy is not finite: also forces at supports, which no residual
        sees.
        """
        system = self.system
        with np.errstate(all="ignore"):
            total, _ = system.forces(u, lam)
            energy = sum(system.energies(u, lam).values())
        if not (np.isfinite(total).all() and np.isfinite(energy)):
            worst = np.flatnonzero(~np.isfinite(total[: system.points]).all(axis=1))[:5].tolist()
            named = ", ".join(f"{k} {system.model.nodes[k]!r}" for k in worst[:3])
            where = f"forces are not finite at nodes {named}" if worst else "its energy is not finite"
            raise ConvergenceError(
                f"a member collapsed at load factor {lam:.6g}: {where}",
                results=self.results,
                worst_nodes=worst,
                hint="prescribe less, or free the nodes between which it lies; the results so far are in error.results",
            )
        reactions = float(np.linalg.norm(total[system.constrained]))
        unbalanced = float(np.linalg.norm(system.reduce(total)))
        nodal, inner = system.parted(u)
        return Step(
            lam=float(lam),
            u=nodal,
            inner=inner,
            negative=negative if system.conservative else None,
            residual=residual,
            residual_over_reaction=unbalanced / reactions if reactions else float("nan"),
            iterations=iterations,
            history=system.history,
            stage=system.model.stage,
            stage_key=system.model.stage_key,
        )

    def store(self, step: Step) -> Step:
        """Put a step into the results, with what has yielded there; tells where something does so first."""
        watch, before = self._yields, self.results.steps[-1] if self.results.steps else self._before
        if watch.looks:
            with self.system.clock("yield"):
                share, elastic = watch.share(step)
            step = replace(step, yielded=share)
            if share > 0 and not (before is not None and before.yielded > 0):
                self.results.events.append(watch.event(step, elastic, before if self.results.steps else None))
        self.results.append(step)
        return step

    def count_seconds(self) -> None:
        """Bring the seconds and steps in the stats up to date."""
        self.results.stats["steps"] = len(self.results.steps)
        self.results.stats["seconds"] = {
            **{part: round(seconds, 6) for part, seconds in self.system.clock.seconds.items()},
            "total": round(time.perf_counter() - self._started, 6),
        }

    def take_seconds(self, seconds: dict[str, float]) -> None:
        """Add the seconds of an earlier run that this one goes on with."""
        seconds = dict(seconds)
        self._started -= seconds.pop("total", 0.0)
        self.system.clock.seconds = seconds

    def finish(self) -> Results:
        """The results, once all is in them."""
        self.count_seconds()
        return self.results


def require_potential(system: System, owner: str) -> None:
    """Raise a ModelError where a force has no potential, so that nothing can be said of stability."""
    if not system.conservative:
        names = ", ".join(sorted({kernel.name for kernel in system.kernels if not kernel.conservative}))
        raise ModelError(
            f"{owner}: the forces of {names} have no potential, so that stability cannot be counted and nothing runs "
            "downhill; follow the path with on_instability='follow', or hold the rim of the pressure"
        )


def require_drive(system: System, owner: str, constant_counts: bool = False) -> None:
    """Raise a ModelError where nothing acts on the structure.

    Where what is constant counts, so do elements that are strained where they are drawn: a fold with a rest angle.
    """
    if system.drive.any() or any(kernel.scaled for kernel in system.kernels):
        return
    if constant_counts and (system.held.any() or not all(kernel.stores_energy for kernel in system.kernels)):
        return
    if constant_counts and system.imbalance(np.zeros_like(system.rest), 0.0)[1] > 0:
        return
    raise ModelError(f"{owner}: nothing drives the model; add a NodalLoad, or a Prescribe with a value other than zero")
