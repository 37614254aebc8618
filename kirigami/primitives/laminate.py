"""Layers bonded to one sheet; the theory is in :mod:`kirigami.primitives.material`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from kirigami.errors import ModelError
from kirigami.primitives.checks import (
    require_instance,
    require_items,
    require_positive,
)
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import SheetMaterial

SAME = 1e-9  # two thicknesses that differ by less are one


@dataclass(frozen=True)
class Laminate(SheetMaterial):
    """Layers that are bonded to one sheet. Only shell facets (``stiffness="shell"``) can stand for it.

    A laminate that is not symmetric bends when it is pulled: its coupling B is part of the section matrix.

    Parameters
    ----------
    layers : sequence of (material, thickness)
        Layers from the lower face of the sheet to the upper one, which is the one seen from above: materials, also
        laminates, and thicknesses [length]. The sheet is as thick as all layers together.

    Raises
    ------
    ModelError
        No layers, or a layer that is no pair of a material and a positive thickness.

    Examples
    --------
    >>> import numpy as np
    >>> import kirigami as kg
    >>> ply = kg.Orthotropic(E1=140e9, E2=10e9, nu12=0.3, G12=5e9)
    >>> across = kg.Orthotropic(E1=140e9, E2=10e9, nu12=0.3, G12=5e9, angle=np.pi / 2)
    >>> two = kg.Laminate([(ply, 1e-4), (across, 1e-4)])
    >>> two.thickness, bool(two.section(2e-4)[0, 3] > 0)
    (0.0002, True)
    """

    layers: tuple[tuple[SheetMaterial, float], ...]
    thickness: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        checked: list[tuple[SheetMaterial, float]] = []
        for number, layer in enumerate(require_items(self.layers, "layers", "Laminate")):
            owner = f"Laminate: layer {number}"
            pair = require_items(layer, "a pair of material and thickness", owner)
            if len(pair) != 2:
                raise ModelError(f"{owner} must be a pair of a material and a thickness, got {layer!r}")
            material = require_instance(pair[0], SheetMaterial, "material", owner)
            if material.hyperelastic:
                raise ModelError(f"{owner} must be linear elastic, as the laws of laminates are, got {material!r}")
            thickness = require_positive(pair[1], "thickness", owner)
            material.checked_thickness(thickness, owner)
            if material.yields:
                raise ModelError(
                    f"{owner} has a yield stress, but the layers of a Laminate stay elastic: give it hardening=None, "
                    "or make the sheet of one Material"
                )
            checked.append((material, thickness))
        if not checked:
            raise ModelError("Laminate: give at least one layer, a pair of a material and a thickness")
        object.__setattr__(self, "layers", tuple(checked))
        object.__setattr__(self, "thickness", float(sum(thickness for _, thickness in checked)))

    @property
    def density(self) -> float | None:  # type: ignore[override]
        """Mean mass per volume, None where that of a layer is not known."""
        masses = [material.mass_per_area(thickness) for material, thickness in self.layers]
        return None if None in masses else sum(mass for mass in masses if mass is not None) / self.thickness

    def checked_thickness(self, thickness: float | None, owner: str) -> float:
        if thickness is not None and abs(thickness - self.thickness) > SAME * self.thickness:
            raise ModelError(
                f"{owner}: the layers of the Laminate are {self.thickness:.9g} thick together, but the thickness given "
                f"is {thickness:.9g}: leave it out"
            )
        return self.thickness

    def _bounds(self) -> Iterable[tuple[SheetMaterial, float, float]]:
        """Layers with the heights of their lower and upper faces."""
        low = -0.5 * self.thickness
        for material, thickness in self.layers:
            yield material, low, low + thickness
            low += thickness

    def _at(self, height: float) -> tuple[SheetMaterial, float]:
        """The layer at a height, and the height over its own thickness; the lower one where two meet."""
        at = height * self.thickness
        layers = list(self._bounds())
        material, low, high = next(
            (layer for layer in layers if at <= layer[2] + SAME * self.thickness), layers[-1]
        )
        return material, (at - 0.5 * (low + high)) / (high - low)

    def elasticity(self, height: float = 0.0) -> Array:
        """That of the layer at the height; of the lower one where two meet."""
        material, own = self._at(height)
        return material.elasticity(own)

    def free_strain(self, height: float = 0.0) -> Array:
        """That of the layer at the height; of the lower one where two meet."""
        material, own = self._at(height)
        return material.free_strain(own)

    def heated(self, thickness: float, below: float, above: float) -> Array:
        self.checked_thickness(thickness, "Laminate")
        total = np.zeros(6)
        rise = (above - below) / self.thickness
        for material, low, high in self._bounds():
            faces = (below + rise * (face + 0.5 * self.thickness) for face in (low, high))
            own = material.heated(high - low, *faces)
            total += own
            total[3:] -= 0.5 * (low + high) * own[:3]
        return total

    def section(self, thickness: float) -> Array:
        self.checked_thickness(thickness, "Laminate")
        total = np.zeros((6, 6))
        for material, low, high in self._bounds():
            middle = 0.5 * (low + high)
            shift = np.eye(6)  # of strain, to the middle of the layer
            shift[:3, 3:] = -middle * np.eye(3)
            total += shift.T @ material.section(high - low) @ shift
        return total
