"""Eigenmodes of the tangent stiffness: buckling shapes, vibration shapes, imperfections."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.analysis.base import Analysis, Run
from kirigami.analysis.modes import Modes, first_largest
from kirigami.errors import ModelError
from kirigami.linalg import Factor, SingularMatrixError, inverse_iteration, smallest_eigenpairs
from kirigami.model.model import Model
from kirigami.primitives.kernel import Array
from kirigami.results.step import Step
from kirigami.system.system import System

FAR, ROUNDING = 30.0, 1e-5  # lowest eigenvalues over the shift: below the first it is too far, below the second noise


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

    def __init__(
        self, model: Model, n: int = 6, about: Step | None = None, mass: str | ArrayLike = "unit"
    ) -> None:
        super().__init__(model)
        if not isinstance(n, (int, np.integer)) or n < 1:
            raise ModelError(f"Eigen: n must be a positive number of modes, got {n!r}")
        self.n, self.about, self.mass = int(n), about, mass

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
        weight = system.reduce(np.repeat(self._nodal_mass(system)[:, None], system.dim, axis=1))
        mass = diags(weight, format="csc")
        # Just below zero, so that a free body can be factorised; far below the stiffness, so that it costs no digits.
        shift = -1e-8 * float(np.median(matrix.diagonal() / weight))
        if self.about is not None:
            shift = self._below_negative(run, matrix, mass, shift)
        try:
            factor = run.factorize((matrix - shift * mass).tocsc())
            if self.about is None:
                shift, factor = self._nearer(run, matrix, mass, shift, factor)
        except SingularMatrixError:
            factor = run.factorize((matrix - 1.7 * shift * mass).tocsc())
        with system.clock("eigenpairs"):
            values, vectors = smallest_eigenpairs(matrix, mass, self.n, shift, factor)
        shapes = np.zeros((self.n, len(system.rest), 3))
        for shape, vector in zip(shapes, vectors.T):
            shape[:, : system.dim] = system.displacement(vector, 0.0) - system.displacement(0 * vector, 0.0)
            shape /= np.abs(shape).max() * np.sign(shape.ravel()[first_largest(shape.ravel())])
        run.finish()
        return Modes(values, shapes)

    def _nearer(
        self, run: Run, matrix: Any, mass: Any, shift: float, factor: Factor
    ) -> tuple[float, Factor]:
        """A shift nearer to zero where the lowest eigenvalues are far smaller, which would look alike from afar.

        A few inverse iterations tell their size; for a free body that is rounding, and the shift stays.
        """
        _, vector = inverse_iteration(factor, run.system.free, 4)
        size = float(vector @ (matrix @ vector)) / float(vector @ (mass @ vector))
        if not ROUNDING * abs(shift) < size < FAR * abs(shift):
            return shift, factor
        return -0.01 * size, run.factorize((matrix + 0.01 * size * mass).tocsc())

    def _below_negative(self, run: Run, matrix: Any, mass: Any, shift: float) -> float:
        """A shift below the lowest eigenvalue of a loaded state, by doubling until no pivot is negative."""
        for _ in range(60):
            try:
                if run.factorize((matrix - shift * mass).tocsc()).negative == 0:
                    return shift
            except SingularMatrixError:
                pass
            shift *= 4.0
        return shift

    def _nodal_mass(self, system: System) -> Array:
        n = len(system.rest)
        if isinstance(self.mass, str):
            if self.mass == "unit":
                return np.ones(n)
            if self.mass != "lumped":
                raise ModelError(f"Eigen: mass {self.mass!r} is unknown: use 'unit', 'lumped' or one value per node")
            constants, mesh = self.model.sheet_constants, self.model.mesh
            if constants is None or mesh is None or constants.material.density is None:
                raise ModelError("Eigen: mass='lumped' needs a model from a mesh whose material has a density")
            facet = constants.material.density * constants.thickness * mesh.facet_areas / 3
            return np.asarray(np.bincount(mesh.triangles.ravel(), np.repeat(facet, 3), n), dtype=float)
        given = np.asarray(self.mass, dtype=float)
        if given.shape != (n,) or not np.isfinite(given).all() or np.any(given <= 0):
            raise ModelError(f"Eigen: mass must be one positive number for each of the {n} nodes")
        return given
