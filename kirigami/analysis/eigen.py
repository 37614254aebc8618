"""Eigenmodes of the tangent stiffness: buckling shapes, vibration shapes, imperfections."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from kirigami.analysis.base import Analysis, Run
from kirigami.analysis.modes import Modes, nodal_shape
from kirigami.errors import ModelError
from kirigami.linalg import lowest_eigenpairs
from kirigami.model.model import Model
from kirigami.primitives.checks import require_array, require_choice, require_instance, require_whole
from kirigami.primitives.kernel import Array
from kirigami.results.step import Step
from kirigami.system.supports import costs_energy, rigid_unknowns

MASSES = ("unit", "lumped")


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
    mass : "unit", "lumped" or array_like, shape (n_nodes,)
        Mass of the nodes: 1 each, a third of the mass of the facets around (models from a mesh, with a density), or
        given.

    Raises
    ------
    ModelError
        More modes than unknowns, or mass that is missing or not positive.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> bar = m.add(kg.Bar(a, b, EA=1.0))
    >>> values = kg.Eigen(m, n=4).run().values     # three rigid motions and the stretch, 2 EA / L
    >>> [round(abs(float(v)), 6) for v in values]
    [0.0, 0.0, 0.0, 2.0]
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
        from scipy.sparse import diags

        run = Run(self)
        system = run.system
        if self.n > system.free:
            raise ModelError(f"Eigen: {self.n} modes asked for, but the model has only {system.free} unknowns")
        u, lam = np.zeros_like(system.rest), 0.0
        if self.about is not None:
            u, lam = system.joined(self.about.u, self.about.inner), self.about.lam
            system.history = self.about.history
        matrix = system.matrix(system.stiffness_blocks(u, lam))
        nodal = np.zeros(len(system.rest))  # rows behind the nodes follow without inertia
        nodal[: system.points] = self._nodal_mass(system.points)
        weight = system.reduce(np.repeat(nodal[:, None], system.dim, axis=1))
        massive = int(np.count_nonzero(weight))
        if self.n > massive:
            raise ModelError(f"Eigen: {self.n} modes asked for, but only {massive} unknowns of the model have mass")
        with system.clock("eigenpairs"):
            rigid = rigid_unknowns(system, u, matrix)
            values, vectors = lowest_eigenpairs(
                matrix,
                diags(weight, format="csc"),
                self.n,
                rigid,
                run.factorize,
                (lambda vector: costs_energy(system, vector)) if self.about is None else None,
            )
        run.finish()
        return Modes(values, np.array([nodal_shape(system, vector) for vector in vectors.T]))

    def _nodal_mass(self, n: int) -> Array:
        if isinstance(self.mass, str):
            if self.mass == "unit":
                return np.ones(n)
            constants, mesh = self.model.sheet_constants, self.model.mesh
            per_area = None if constants is None or mesh is None else constants.mass_per_area(len(mesh.triangles))
            if mesh is None or per_area is None:
                raise ModelError("Eigen: mass='lumped' needs a model from a mesh whose material has a density")
            facet = per_area * mesh.facet_areas / 3
            return np.asarray(np.bincount(mesh.triangles.ravel(), np.repeat(facet, 3), n), dtype=float)
        given = self.mass
        if given.shape != (n,) or not np.isfinite(given).all() or np.any(given <= 0):
            raise ModelError(f"Eigen: mass must be one positive number for each of the {n} nodes")
        return given
