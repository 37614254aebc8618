"""Materials of sheets."""

from __future__ import annotations

from dataclasses import dataclass

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_finite, require_positive


@dataclass(frozen=True)
class Material:
    """Linear elastic, isotropic material of a sheet.

    Parameters
    ----------
    E : float
        Young's modulus [force / length^2].
    nu : float
        Poisson's ratio, above -1 and below 0.5.
    density : float, optional
        Mass per volume; only where mass or weight matters.

    Raises
    ------
    ModelError
        A value is out of its range or not finite.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Material(E=3.5e9, nu=0.34)
    Material(E=3500000000.0, nu=0.34, density=None)
    """

    E: float
    nu: float = 1 / 3
    density: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "E", require_positive(self.E, "E", "Material"))
        nu = require_finite(self.nu, "nu", "Material")
        if not -1 < nu < 0.5:
            raise ModelError(f"Material: nu must lie between -1 and 0.5, got {nu}")
        object.__setattr__(self, "nu", nu)
        if self.density is not None:
            object.__setattr__(self, "density", require_positive(self.density, "density", "Material"))
