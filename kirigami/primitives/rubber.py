"""Rubber: an incompressible sheet in plane stress that stretches by large strains."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kirigami.primitives.checks import require_finite, require_positive
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import SheetMaterial, _check_density, _known_expansion


@dataclass(frozen=True)
class NeoHookean(SheetMaterial):
    """Incompressible neo-Hookean material of a sheet, as of rubber. Only shell facets can stand for it.

    The energy per volume is (E / 6) (a^2 + b^2 + 1 / (a b)^2 - 3), with a and b the stretches of the middle surface;
    the sheet bends as an elastic one of its modulus, Poisson's ratio 1/2 and thickness at rest, however far it is
    stretched (:mod:`kirigami.elements.shell_rubber`). Forces and stresses are those per length and area at rest (second
    Piola-Kirchhoff).

    Parameters
    ----------
    E : float
        Young's modulus at small strain, three times the shear modulus [force / length^2].
    density : float, optional
        Mass per volume; only where mass or weight matters.
    expansion : float, optional
        Strain per unit of heat; only where :class:`kirigami.Actuate` heats it.

    Raises
    ------
    ModelError
        A value is out of its range or not finite.

    Examples
    --------
    >>> import kirigami as kg
    >>> rubber = kg.NeoHookean(E=1e6)
    >>> mesh = kg.Sheet([(0, 0), (2, 0), (2, 1), (0, 1)]).mesh(0.5)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=rubber, stiffness="shell")
    >>> left, right = m.select(boundary="left"), m.select(boundary="right")
    >>> held = m.add(kg.Fix(left, "xz"), kg.Fix(left[0], "y"), kg.Fix(right, "z"), kg.Prescribe(right, x=2.0))
    >>> force = kg.DisplacementControl(m).run().reaction(right, "x")[-1]      # stretch 2: (E / 3) (2 - 1 / 4) t w
    >>> round(float(force), 3)
    5833.333
    """

    E: float
    density: float | None = None
    expansion: float | None = field(default=None, kw_only=True)

    hyperelastic = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "E", require_positive(self.E, "E", "NeoHookean"))
        _check_density(self, "NeoHookean")
        if self.expansion is not None:
            object.__setattr__(self, "expansion", require_finite(self.expansion, "expansion", "NeoHookean"))

    def elasticity(self, height: float = 0.0) -> Array:
        """That at small strain."""
        return self.E * np.array([[4 / 3, 2 / 3, 0], [2 / 3, 4 / 3, 0], [0, 0, 1 / 3]])

    def free_strain(self, height: float = 0.0) -> Array:
        return float(_known_expansion(self)) * np.array([1.0, 1.0, 0.0])
