"""Linear buckling: the load factors at which a small-displacement prestate loses its stability."""

from __future__ import annotations

from typing import Any

import numpy as np

from kirigami.analysis.base import Analysis, Run, require_drive, require_potential
from kirigami.analysis.modes import Modes
from kirigami.errors import AnalysisError, ModelError
from kirigami.linalg import SingularMatrixError, critical_factors
from kirigami.model.model import Model
from kirigami.primitives.checks import require_whole
from kirigami.primitives.kernel import Array, Tangent
from kirigami.system.system import System
from kirigami.words import counted

NO_STRESS = 1e-12  # geometric over elastic stiffness, at displacements of a member's length, that is rounding


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
        self.n = require_whole(n, "n", "Buckling", least=1)

    def run(self) -> Modes:
        """Find the lowest positive buckling load factors and their shapes; fewer than `n` where there are no more."""
        run = Run(self)
        system = run.system
        system.straighten()
        require_drive(system, "Buckling")
        require_potential(system, "Buckling")
        system.check_supports()
        if self.n > system.free:
            raise ModelError(
                f"Buckling: {counted(self.n, 'mode')} asked for, but the model has only "
                f"{counted(system.free, 'unknown')}"
            )
        rest = np.zeros_like(system.rest)
        blocks, factor = run.first_factor(rest, 0.0)
        forces, _ = system.forces(rest, 0.0)
        held = system.multiply(blocks, system.held.reshape(rest.shape))
        with system.clock("solve"):
            constant = factor.solve(-system.reduce(forces + held))
            rate = factor.solve(-system.load_rate(rest, 0.0, blocks))
        stiffness = self._prestressed(system, constant, rate, 0.0)
        try:
            factor = run.factorize(stiffness) if constant.any() else factor
            unstable = factor.negative > 0
        except SingularMatrixError:
            unstable = True
        if unstable:
            raise AnalysisError("Buckling: the constant loads alone already make the structure buckle")
        geometric, scale = self._geometric(system, stiffness, constant, rate)
        values = np.empty(0)
        if geometric is not None:
            with system.clock("eigenpairs"):
                values, vectors = critical_factors(stiffness, geometric, self.n, factor, run.factorize)
        if not len(values):
            raise AnalysisError(
                "Buckling: no positive load factor makes this structure buckle, because nothing in it is compressed; "
                "is the drive the other way round?"
            )
        run.finish()
        return Modes.of(run.results, system, scale * values, vectors, rest, 0.0)

    @staticmethod
    def _prestressed(system: System, constant: Array, rate: Array, lam: float) -> Any:
        """Stiffness at rest with the stress that the linear solution has at a load factor."""
        rest = np.zeros_like(system.rest)
        ahead = Tangent(ahead=(rest, system.small_displacement(constant + lam * rate, lam)))
        return system.matrix(system.stiffness_blocks(rest, lam, ahead))

    def _geometric(self, system: System, stiffness: Any, constant: Array, rate: Array) -> tuple[Any, float]:
        """Change of the stiffness with the load, as large as the stiffness itself, and the load factor that makes it.

        At that size no digits are lost in the difference. None where the drive makes no stress.
        """
        change = system.motion(rate, 1.0)
        scale = 1.0 / (system.largest_rotation(change) or 1.0)
        largest = float(np.abs(stiffness.data).max())
        for _ in range(2):
            geometric = (self._prestressed(system, constant, rate, scale) - stiffness).tocsc()
            size = float(np.abs(geometric.data).max(initial=0.0)) / largest
            if size < NO_STRESS:
                return None, scale
            if 0.1 < size < 10.0:
                break
            scale /= size
        return geometric, scale
