"""What all analyses share: a system, a state that is committed or reverted, counted factorisations, results."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from kirigami.errors import ModelError
from kirigami.linalg import Factor, SingularMatrixError, make_solver
from kirigami.model.model import Model
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.step import Step
from kirigami.system.supports import check_floppy
from kirigami.system.system import System


class Analysis:
    """Base of all analyses: holds a model, and lowers it when it runs."""

    def __init__(self, model: Model) -> None:
        if not isinstance(model, Model):
            raise ModelError(f"{type(self).__name__} needs a Model, got {model!r}")
        self.model = model
        self.results: Results | None = None  # in reach also after an interruption

    def _begin(self, linear: bool = False) -> tuple[System, Results]:
        self._started = time.perf_counter()
        self._solver = make_solver()
        system = System(self.model)
        self.results = Results(system, linear=linear)
        return system, self.results

    def _finish(self, system: System, results: Results) -> Results:
        self._count_seconds(system, results)
        system.linearize(None)
        return results

    def _count_seconds(self, system: System, results: Results) -> None:
        results.stats["steps"] = len(results.steps)
        results.stats["seconds"] = {
            **{part: round(seconds, 6) for part, seconds in system.clock.seconds.items()},
            "total": round(time.perf_counter() - self._started, 6),
        }

    def _factorize(self, system: System, results: Results, matrix: Any) -> Factor:
        with system.clock("factorization"):
            factor = self._solver.factorize(matrix)
        results.stats["factorizations"] += 1
        results.stats["backend"] = factor.backend
        return factor

    def _first_factor(self, system: System, results: Results, u: Array, lam: float) -> tuple[Array, Factor]:
        """Blocks and factor of the starting state, or a MechanismError in words."""
        blocks = system.stiffness_blocks(u, lam)
        matrix = system.matrix(blocks)
        try:
            factor = self._factorize(system, results, matrix)
        except SingularMatrixError:
            with system.clock("checks"):
                check_floppy(system, matrix, None)
            raise
        with system.clock("checks"):
            check_floppy(system, matrix, factor)
        return blocks, factor


def make_step(system: System, u: Array, lam: float, negative: int | None, residual: float, iterations: int) -> Step:
    """A stored step from a converged state, with the residual measured against the reactions as well."""
    total, _ = system.forces(u, lam)
    reactions = float(np.linalg.norm(total[system.constrained]))
    unbalanced = float(np.linalg.norm(system.reduce(total)))
    full = np.zeros((len(u), 3))
    full[:, : system.dim] = u
    return Step(
        lam=float(lam),
        u=full,
        negative=negative,
        residual=residual,
        residual_over_reaction=unbalanced / reactions if reactions else float("nan"),
        iterations=iterations,
        history=system.history,
        stage=system.model.stage,
    )


def require_drive(system: System, owner: str, constant_counts: bool = False) -> None:
    """Raise a ModelError where nothing acts on the structure."""
    if system.drive.any() or any(kernel.scaled for kernel in system.kernels):
        return
    if constant_counts and (system.held.any() or any(kernel.pairs == () for kernel in system.kernels)):
        return
    raise ModelError(f"{owner}: nothing drives the model; add a NodalLoad, or a Prescribe with a value other than zero")
