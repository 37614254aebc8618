"""Linear buckling: the load factors at which a small-displacement prestate loses its stability."""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.analysis.base import Analysis, Run, require_drive
from kirigami.analysis.modes import Modes, nodal_shape
from kirigami.errors import AnalysisError, ModelError
from kirigami.linalg import Factor
from kirigami.model.model import Model
from kirigami.primitives.kernel import Array, Tangent


class Buckling(Analysis):
    """Classical buckling loads, (K + value K_geometric) v = 0.

    K is the tangent stiffness at rest, with the geometric stiffness of constant loads; K_geometric is the change of
    the tangent by the forces that the scaled loads and prescribed displacements cause to first order. Displacements
    before buckling are neglected, so the result is right where they are small: columns, plates in their plane. Where
    they matter, follow the path and look at its events (Zienkiewicz, Taylor and Fox, The Finite Element Method for
    Solid and Structural Mechanics, on linear buckling).

    Parameters
    ----------
    model : Model
        Loads and prescribed displacements at load factor 1 make the prestate. Give a pull its own sign: only positive
        load factors are looked for.
    n : int
        How many buckling loads, the lowest first.

    Raises
    ------
    ModelError, MechanismError
        Nothing drives the model, it can move without resistance, or it has fewer than `n` unknowns.
    AnalysisError
        On :meth:`run`: it never buckles under this drive, because nothing is compressed.

    Examples
    --------
    Two links of length 1, a spring k = 1 between them, pinned ends: P = 2 k / l.

    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> bottom, middle, top = m.add(kg.Node(0, 0), kg.Node(0, 1), kg.Node(0, 2))
    >>> bars = m.add(kg.Bar(bottom, middle, 1e4), kg.Bar(middle, top, 1e4), kg.TorsionSpring3(bottom, middle, top, 1))
    >>> held = m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.NodalLoad(top, (0, -1)))
    >>> [round(float(v), 9) for v in kg.Buckling(m, n=1).run().values]
    [2.0]
    """

    def __init__(self, model: Model, n: int = 4) -> None:
        super().__init__(model)
        if not isinstance(n, (int, np.integer)) or n < 1:
            raise ModelError(f"Buckling: n must be a positive number of modes, got {n!r}")
        self.n = int(n)

    def run(self) -> Modes:
        """Find the lowest positive buckling load factors and their shapes; fewer than `n` where there are no more."""
        run = Run(self)
        system = run.system
        require_drive(system, "Buckling")
        system.check_supports()
        if self.n > system.free:
            raise ModelError(f"Buckling: {self.n} modes asked for, but the model has only {system.free} unknowns")
        rest = np.zeros_like(system.rest)
        blocks, factor = run.first_factor(rest, 0.0)
        forces, _ = system.forces(rest, 0.0)
        held = system.plan.multiply(blocks, system.held.reshape(rest.shape))
        with system.clock("solve"):
            constant = factor.solve(-system.reduce(forces + held))
            rate = factor.solve(-system.load_rate(rest, 0.0, blocks))
        matrices = []
        for lam in (0.0, 1.0):
            ahead = Tangent(ahead=(rest, system.displacement(constant + lam * rate, lam)))
            matrices.append(system.matrix(system.stiffness_blocks(rest, lam, ahead)))
        stiffness = matrices[0]
        geometric = (matrices[1] - stiffness).tocsc()
        factor = run.factorize(stiffness)
        if factor.negative:
            raise AnalysisError("Buckling: the constant loads alone already make the structure buckle")
        # In the inverse load factors the lowest buckling loads are the extreme eigenvalues, and K is the only factor.
        with system.clock("eigenpairs"):
            inverse, vectors = largest_eigenpairs(-geometric, stiffness, self.n, factor)
        scale = float(np.abs(geometric.data).max(initial=0.0) / np.abs(stiffness.data).max())
        found = inverse > 1e-10 * scale
        if not found.any():
            raise AnalysisError(
                "Buckling: no positive load factor makes this structure buckle; is the drive the other way round?"
            )
        run.finish()
        shapes = [nodal_shape(system, vector) for vector in vectors.T[found]]
        return Modes(1.0 / inverse[found], np.array(shapes))


def largest_eigenpairs(matrix: Any, mass: Any, count: int, factor: Factor, tol: float = 1e-10) -> tuple[Array, Array]:
    """Largest eigenvalues of ``matrix v = value mass v`` (descending) and their vectors (n, count), by Lanczos.

    `mass` is positive definite and `factor` is its factor; small problems are solved densely.
    """
    n = matrix.shape[0]
    if n <= 400 or count >= n - 1:
        from scipy.linalg import eigh

        values, vectors = eigh(matrix.toarray(), mass.toarray())
    else:
        from scipy.sparse.linalg import LinearOperator, eigsh

        inverse = LinearOperator((n, n), matvec=factor.solve, dtype=float)
        start = np.random.default_rng(0).normal(size=n)  # a fixed start makes the modes repeatable
        values, vectors = eigsh(
            matrix, k=count, M=mass, Minv=inverse, which="LA", v0=start, tol=tol, ncv=max(2 * count + 1, 20)
        )
    order = np.argsort(values)[::-1][:count]
    return values[order], vectors[:, order]
