"""Linear statics: one solve about the rest state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kirigami.analysis.base import Analysis, Run, require_drive
from kirigami.model.model import Model
from kirigami.results.results import Results


class LinearStatic(Analysis):
    """Small displacements under loads and prescribed displacements at load factor 1.

    Solves K(0) u = f. The results are linear as well: reactions, strains, angles and energies are taken to first
    (energies to second) order about the rest state, so doubling the load doubles them.

    Parameters
    ----------
    model : Model
        The model to analyse.

    Raises
    ------
    ModelError, MechanismError
        On :meth:`run`: nothing drives the model, or it can move without resistance.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> round(float(kg.LinearStatic(m).run()[-1].u[1, 0]), 12)
    0.2
    """

    def __init__(self, model: Model) -> None:
        super().__init__(model)

    def run(self) -> Results:
        """Solve; step 0 has load factor 0 (constant loads only), step 1 load factor 1."""
        run = Run(self, linear=True)
        system, results = run.system, run.results
        system.straighten()
        require_drive(system, "LinearStatic", constant_counts=True)
        system.check_supports()
        rest = np.zeros_like(system.rest)
        blocks, factor = run.first_factor(rest, 0.0)
        rate = system.load_rate(rest, 0.0, blocks)
        forces, _ = system.forces(rest, 0.0)
        held = system.multiply(blocks, system.held.reshape(rest.shape))
        with system.clock("solve"):
            q_constant = factor.solve(-system.reduce(forces + held))
            q_rate = factor.solve(-rate)
        negative = factor.negative
        del factor  # the largest thing in memory
        for lam in (0.0, 1.0):
            u = system.small_displacement(q_constant + lam * q_rate, lam)
            run.store(run.make_step(u, lam, negative, float("nan"), 1))
            # The residual of the linear equations, over the forces that the displacements cause block by block.
            unbalanced = system.reduce(system.carried(results.row_gradients[-1], rest))
            caused = float(np.linalg.norm(system.multiply(blocks, u, sizes=True))) or 1.0
            results.steps[-1] = replace(
                results.steps[-1],
                residual=float(np.linalg.norm(unbalanced)) / caused,
                residual_over_reaction=float("nan"),
            )
        results.stats["iterations"] = 1
        return run.finish()
