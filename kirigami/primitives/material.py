"""Materials of sheets: what makes forces and moments of strain and curvature.

A sheet bears forces N and moments M per length, in the axes x, y of the drawing, by the section matrix
S = [[A, B], [B, D]] of classical lamination theory (Jones, 1999): (N, M) = S (e, k), with e = (exx, eyy, gamma_xy) of
the middle surface and k = (kxx, kyy, 2 kxy) positive where the sheet is hollow from above. A fibre at the height z is
strained by e - z k, so that with the plane-stress matrix C(z) of each layer

    A = int C dz        B = - int z C dz        D = int z^2 C dz

and a material turned by an angle has C' = R' C R. Heat T(z) makes a fibre free of stress at the strain a(z) T(z), a its
expansion; a sheet that is held as it is then bears less by

    N_T = int C a T dz        M_T = - int z C a T dz

so that, left alone, it takes the strain and curvature S^-1 (N_T, M_T).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import (
    require_array,
    require_finite,
    require_positive,
)
from kirigami.primitives.hardening import YieldCurve, checked_curve, checked_table
from kirigami.primitives.kernel import Array


class SheetMaterial:
    """Base of the materials of a sheet.

    ``isotropic`` tells whether bars, hinges and flat facets can stand for it, ``hyperelastic`` whether its stress at
    large strain is its own, ``yields`` whether elements that can shall yield, along its ``yield_curve``.
    """

    isotropic: bool = False
    density: float | None = None
    yield_stress: float | None = None
    hyperelastic: bool = False

    @property
    def yields(self) -> bool:
        """Whether elements that can shall yield."""
        return False

    @property
    def yield_curve(self) -> YieldCurve | None:
        """Yield stress over plastic strain; None where nothing shall yield."""
        return None

    def free_strain(self, height: float = 0.0) -> Array:
        """Strain (3,) per unit of heat at which a fibre bears nothing, at a height over the thickness, in the axes of
        the drawing."""
        raise ModelError(f"{type(self).__name__}: heat has no meaning for this material, which has no expansion")

    def heated(self, thickness: float, below: float, above: float) -> Array:
        """What a sheet that is held bears less (6,), as forces and moments per length, when heat goes in a straight
        line from `below` at its lower face to `above` at the upper one."""
        force = self.elasticity() @ self.free_strain()
        return np.concatenate(
            [0.5 * thickness * (below + above) * force, -(thickness**2) / 12 * (above - below) * force]
        )

    def elasticity(self, height: float = 0.0) -> Array:
        """Plane-stress matrix (3, 3) for (exx, eyy, gamma_xy) at a height over the thickness, from -1/2 to 1/2."""
        raise NotImplementedError

    def section(self, thickness: float) -> Array:
        """Section matrix (6, 6) of a sheet [force / length, force, force length], in the axes of the drawing."""
        found = np.zeros((6, 6))
        elasticity = self.elasticity()
        found[:3, :3] = thickness * elasticity
        found[3:, 3:] = np.float64(thickness) ** 3 / 12 * elasticity
        return found

    def mass_per_area(self, thickness: float) -> float | None:
        """Mass per area of a sheet, None where the density is not known."""
        return None if self.density is None else self.density * thickness

    def checked_thickness(self, thickness: float | None, owner: str) -> float | None:
        """The thickness given, or the one that the material itself has."""
        return thickness


def _check_density(material: Any, owner: str) -> None:
    if material.density is not None:
        object.__setattr__(material, "density", require_positive(material.density, "density", owner))


def _known_expansion(material: Any) -> Any:
    if material.expansion is None:
        raise ModelError(f"{material!r} is to be heated, but its expansion is not known: give expansion=")
    return material.expansion


@dataclass(frozen=True)
class Material(SheetMaterial):
    """Isotropic material of a sheet: linear elastic and, where a yield stress is given, plastic beyond it.

    Shell facets yield layer by layer (von Mises), bars and hinges by their own force and moment. Where a rung or an
    analysis stays elastic, results tell of what is strained beyond the yield stress.

    Parameters
    ----------
    E : float
        Young's modulus [force / length^2].
    nu : float
        Poisson's ratio, above -1 and below 0.5.
    density : float, optional
        Mass per volume; only where mass or weight matters.
    yield_stress : float, optional
        Stress under tension at which the material yields first [force / length^2]; None: it never does.
    hardening : float or array_like, shape (k, 2), or None
        How the yield stress grows with the accumulated plastic strain (isotropic hardening): a modulus
        [force / length^2], or a table of plastic strain and yield stress that does not fall, constant beyond its end.
        None keeps the material elastic, and results tell where the yield stress is passed.
    kinematic : float or array_like, shape (k, 2)
        Kinematic hardening, how the stress about which the material yields follows the plastic strain in tension: a
        modulus [force / length^2], or a table of accumulated plastic strain and that stress, from zero, that does not
        fall, constant beyond its end.
    expansion : float, optional
        Strain per unit of heat, or of what else makes it swell; only where :class:`kirigami.Actuate` heats it.

    Raises
    ------
    ModelError
        A value is out of its range or not finite, a table that falls, hardening without a yield stress.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Material(E=3.5e9, nu=0.34)
    Material(E=3500000000.0, nu=0.34, density=None)
    >>> pet = kg.Material(E=3.5e9, nu=0.34, yield_stress=60e6, hardening=[(0.05, 65e6), (0.3, 120e6)])
    >>> pet.yields
    True
    """

    E: float
    nu: float = 1 / 3
    density: float | None = None
    yield_stress: float | None = None
    hardening: float | tuple[tuple[float, float], ...] | None = 0.0
    kinematic: float | tuple[tuple[float, float], ...] = 0.0
    expansion: float | None = field(default=None, kw_only=True)

    isotropic = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "E", require_positive(self.E, "E", "Material"))
        nu = require_finite(self.nu, "nu", "Material")
        if not -1 < nu < 0.5:
            raise ModelError(f"Material: nu must lie between -1 and 0.5, got {nu}")
        object.__setattr__(self, "nu", nu)
        _check_density(self, "Material")
        if self.expansion is not None:
            object.__setattr__(self, "expansion", require_finite(self.expansion, "expansion", "Material"))
        if self.hardening is not None:
            object.__setattr__(self, "hardening", checked_table(self.hardening, "Material"))
        object.__setattr__(self, "kinematic", checked_table(self.kinematic, "Material", "kinematic"))
        if self.yield_stress is not None:
            first = require_positive(self.yield_stress, "yield_stress", "Material")
            object.__setattr__(self, "yield_stress", first)
            checked_curve(first, self.hardening or 0.0, self.kinematic, "Material", "yield_stress")
        elif self.hardening not in (None, 0.0) or self.kinematic:
            raise ModelError("Material: hardening needs a yield_stress, the stress at which it begins")

    def __repr__(self) -> str:
        beyond = "" if self.yield_stress is None else f", yield_stress={self.yield_stress}, hardening={self.hardening}"
        beyond += f", kinematic={self.kinematic}" if self.kinematic else ""
        beyond += "" if self.expansion is None else f", expansion={self.expansion}"
        return f"Material(E={self.E}, nu={self.nu}, density={self.density}{beyond})"

    @property
    def yields(self) -> bool:
        """Whether elements that can shall yield: a yield stress is given, and not ``hardening=None``."""
        return self.yield_stress is not None and self.hardening is not None

    @property
    def yield_curve(self) -> YieldCurve | None:
        """Yield stress over plastic strain; None where nothing shall yield."""
        if self.yield_stress is None or self.hardening is None:
            return None
        return checked_curve(self.yield_stress, self.hardening, self.kinematic, "Material", "yield_stress")

    def free_strain(self, height: float = 0.0) -> Array:
        return float(_known_expansion(self)) * np.array([1.0, 1.0, 0.0])

    def elasticity(self, height: float = 0.0) -> Array:
        E, nu = self.E / (1 - self.nu**2), self.nu
        return np.array([[E, nu * E, 0], [nu * E, E, 0], [0, 0, (1 - nu) / 2 * E]])


@dataclass(frozen=True)
class Orthotropic(SheetMaterial):
    """Linear elastic material of a sheet that is stiffer along one direction than across it: paper, a ply of fibres.

    Only shell facets (``stiffness="shell"``) can stand for it.

    Parameters
    ----------
    E1, E2 : float
        Young's moduli along the grain and across it [force / length^2].
    nu12 : float
        Contraction across the grain over the extension along it, when pulled along it; nu12^2 < E1 / E2.
    G12 : float
        Shear modulus [force / length^2].
    angle : float
        Direction of the grain, counter-clockwise from the x axis of the drawing [rad].
    density : float, optional
        Mass per volume; only where mass or weight matters.
    expansion : array_like, shape (2,), optional
        Strains along the grain and across it per unit of heat, or of moisture; only where :class:`kirigami.Actuate`
        heats it.

    Raises
    ------
    ModelError
        A value is out of its range or not finite.

    Examples
    --------
    >>> import numpy as np
    >>> import kirigami as kg
    >>> paper = kg.Orthotropic(E1=6e9, E2=3e9, nu12=0.3, G12=1.7e9, angle=0.0)
    >>> round(float(1 / np.linalg.inv(paper.elasticity())[1, 1] / 1e9), 9)
    3.0
    """

    E1: float
    E2: float
    nu12: float
    G12: float
    angle: float = 0.0
    density: float | None = None
    expansion: tuple[float, float] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        for name in ("E1", "E2", "G12"):
            object.__setattr__(self, name, require_positive(getattr(self, name), name, "Orthotropic"))
        for name in ("nu12", "angle"):
            object.__setattr__(self, name, require_finite(getattr(self, name), name, "Orthotropic"))
        if not self.nu12**2 < self.E1 / self.E2:
            raise ModelError(
                f"Orthotropic: nu12 must lie between -{(self.E1 / self.E2) ** 0.5:.6g} and its opposite, the root of "
                f"E1 / E2, got {self.nu12:.6g}: beyond, stretching would set energy free"
            )
        _check_density(self, "Orthotropic")
        if self.expansion is not None:
            along, across = require_array(self.expansion, (2,), name="expansion", owner="Orthotropic").tolist()
            object.__setattr__(self, "expansion", (along, across))

    def free_strain(self, height: float = 0.0) -> Array:
        along, across = _known_expansion(self)
        return np.asarray(strain_turn(-self.angle) @ np.array([along, across, 0.0]))

    def elasticity(self, height: float = 0.0) -> Array:
        compliance = np.array(
            [[1 / self.E1, -self.nu12 / self.E1, 0], [-self.nu12 / self.E1, 1 / self.E2, 0], [0, 0, 1 / self.G12]]
        )
        return turned_elasticity(np.linalg.inv(compliance), self.angle)


def strain_turn(angle: Any) -> Array:
    """Matrices (..., 3, 3) that turn (exx, eyy, gamma_xy) into what it is in axes turned by `angle` [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    rows = [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def turned_elasticity(elasticity: Array, angle: float) -> Array:
    """The matrix (3, 3) in axes from which those of a material are turned by `angle` [rad]."""
    turn = strain_turn(angle)
    return np.asarray(turn.T @ elasticity @ turn)


def uniaxial_stiffness(section: Array) -> float:
    """Force per length and strain of a sheet pulled along the stiffer of its two axes: E t of an isotropic one."""
    return float((1 / np.diag(np.linalg.inv(section[:3, :3]))[:2]).max())


def each_section(thickness: Array, number: NDArray[np.int64], materials: Sequence[SheetMaterial]) -> Array:
    """Section matrices (m, 6, 6) of facets of a thickness (m,) and a material, by its number (m,) among `materials`."""
    pairs, which = np.unique(np.stack([thickness, number], axis=1), axis=0, return_inverse=True)
    made = np.array([materials[int(position)].section(float(height)) for height, position in pairs.tolist()])
    return np.asarray(made[which.ravel()])
