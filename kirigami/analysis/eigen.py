"""Eigenmodes of the tangent stiffness: buckling shapes, vibration shapes, imperfections."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from kirigami.analysis.base import Analysis, Run, require_potential
from kirigami.analysis.modes import Modes
from kirigami.errors import ModelError
from kirigami.linalg import lowest_eigenpairs
from kirigami.model.model import Model
from kirigami.primitives.checks import require_array, require_choice, require_instance, require_whole
from kirigami.primitives.kernel import Array
from kirigami.results.step import Step
from kirigami.system.inertia import Inertia
from kirigami.system.supports import costs_energy, rigid_unknowns
from kirigami.words import counted

MASSES = ("unit", "consistent", "lumped")


class Eigen(Analysis):
    """The lowest eigenmodes of the tangent stiffness, K v = value M v.

    Needs neither support nor load: a free sheet shows six values of zero. Displacements under Fix or Prescribe stay
    zero in the modes.

    Parameters
    ----------
    model : Model
        The model to analyse.
    n : int
        How many modes.
    about : Step, optional
        Equilibrium about which the stiffness is taken; None is the rest state.
    mass : "unit", "consistent", "lumped" or array_like, shape (n_nodes,)
        "unit": 1 at each node, for shapes. The masses of the model, which make frequencies: "consistent", as the
        displacements of facets and bars distribute them, or "lumped", the same at the nodes alone, a third of each
        facet's and a half of each bar's. Or the mass of each node.

    Raises
    ------
    ModelError
        More modes than unknowns, a sheet without density or a model without any mass, or one that is not positive.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> bar = m.add(kg.Bar(a, b, EA=1.0))
    >>> values = kg.Eigen(m, n=4).run().values     # three rigid motions and the stretch, 2 EA / L
    >>> [round(abs(float(v)), 6) for v in values]
    [0.0, 0.0, 0.0, 2.0]
    >>> masses = m.add(kg.Mass([a, b], 0.5))       # two masses on a spring: sqrt(2 k / m) / (2 pi) hertz
    >>> round(float(kg.Eigen(m, n=4, mass="consistent").run().frequencies[3]), 6)
    0.31831
    """

    def __init__(self, model: Model, n: int = 6, about: Step | None = None, mass: str | ArrayLike = "unit") -> None:
        super().__init__(model)
        self.n = require_whole(n, "n", "Eigen", least=1)
        self.about = None if about is None else require_instance(about, Step, "about", "Eigen", "such as results[-1]")
        if isinstance(mass, str):
            self.mass: str | Array = require_choice(mass, MASSES, "mass", "Eigen", or_else="one value per node")
        else:
            self.mass = require_array(mass, (None,), name="mass", owner="Eigen")

    def run(self) -> Modes:
        """Compute the modes."""
        run = Run(self)
        system = run.system
        require_potential(system, "Eigen")
        if self.n > system.free:
            raise ModelError(
                f"Eigen: {counted(self.n, 'mode')} asked for, but the model has only {counted(system.free, 'unknown')}"
            )
        u, lam = np.zeros_like(system.rest), 0.0
        if self.about is not None:
            u, lam = system.joined(self.about.u, self.about.inner), self.about.lam
            system.history = self.about.history
        inertia = Inertia(system, self._mass(system.points), u)
        matrix = system.matrix(system.stiffness_blocks(u, lam))  # in the pattern that has room for the masses
        mass = inertia.matrix
        del inertia
        massive = int(np.count_nonzero(mass.diagonal()))
        if self.n > massive:
            raise ModelError(
                f"Eigen: {counted(self.n, 'mode')} asked for, but only {counted(massive, 'unknown')} with mass"
            )
        with system.clock("eigenpairs"):
            rigid = rigid_unknowns(system, u, matrix)
            values, vectors = lowest_eigenpairs(
                matrix,
                mass,
                self.n,
                rigid,
                run.factorize,
                (lambda vector: costs_energy(system, vector)) if self.about is None else None,
            )
        run.finish()
        timed = not (isinstance(self.mass, str) and self.mass == "unit")
        return Modes.of(run.results, system, values, vectors, u, lam, timed)

    def _mass(self, n: int) -> str | Array:
        """What the masses are, by name or at each node."""
        if isinstance(self.mass, str):
            return np.ones(n) if self.mass == "unit" else self.mass
        given = self.mass
        if given.shape != (n,) or not np.isfinite(given).all() or np.any(given <= 0):
            raise ModelError(f"Eigen: mass must be one positive number for each of the {counted(n, 'node')}")
        return given
