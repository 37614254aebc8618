"""Shell facets of rubber: an incompressible neo-Hookean membrane, which bends as an elastic sheet.

With C = 1 + 2 e in the plane and d = det C, the thickness shrinks by d^(-1/2), and per area at rest

    W = (E t / 6) (C11 + C22 + f(d) - 3) + k . D k / 2,    f(d) = 1 / d,    D that of E, 1/2 and t at rest.

W is convex in the strain e. Energies are summed up at the three points of a facet at which its linear strain is; at
small strain they are those of the elastic facet of Poisson's ratio 1/2. Below d = 0.05, where an area is squeezed to
less than a quarter, f goes on as its Taylor polynomial of second order, so that iterations that go astray come back.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kirigami.elements.shell_derivatives import Answer
from kirigami.elements.shell_geometry import AREA_PLACES
from kirigami.elements.shell_kernel import ShellFacetKernel
from kirigami.elements.surface import squares_over
from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array, Kernel

SQUEEZED = 0.05  # det C below which the law goes on as a polynomial


def rubber_moduli(objects: Sequence[Any]) -> Array:
    """E t of facets of rubber (n,), zero for others."""
    found = np.zeros(len(objects))
    for position, facet in enumerate(objects):
        material = facet.material
        if material.hyperelastic:
            if facet.section is not None:
                raise ModelError(
                    f"ShellFacet on {facet.nodes}: a facet of {type(material).__name__} has no section of its own: "
                    "leave section= out"
                )
            found[position] = material.E * facet.thickness
        elif material.yields:
            raise ModelError(
                f"ShellFacet on {facet.nodes}: a sheet cannot be rubber in one place and yield in another: give the "
                "material that yields hardening=None"
            )
    return found


def membrane(modulus: Array, strain: Array) -> tuple[Array, Array, Array]:
    """Energy (...), forces (..., 3) and tangent (..., 3, 3) by strains (exx, eyy, gamma) (..., 3), for moduli E t."""
    xx, yy, shear = np.moveaxis(strain, -1, 0)
    c11, c22 = 1 + 2 * xx, 1 + 2 * yy
    square = 4 * xx * yy - shear**2
    grown = 2 * (xx + yy) + square  # d - 1
    low = np.minimum(grown - (SQUEEZED - 1), 0.0)  # below where the polynomial begins
    d = 1 + grown - low
    # C11 + C22 + 1 / d - 3 without cancellation, then what the polynomial has beyond 1 / d
    most = np.where(low < 0, SQUEEZED - 1, grown)
    linear = 2 * (xx + yy)
    stretched = np.where(low < 0, linear - most / d, (linear * grown - square) / d)
    energy = modulus / 6 * (stretched - low / d**2 + low**2 / d**3)
    first, second = -1 / d**2 + 2 * low / d**3, 2 / d**3
    slope = np.stack([2 * c22, 2 * c11, -2 * shear], axis=-1)  # of d by the strain
    force = modulus[..., None] / 6 * first[..., None] * slope
    # 2 + 2 f' c without cancellation where f' = -1 / d^2
    near = grown * (2 + grown)
    for k, other in enumerate((yy, xx)):
        exact = 2 * (near - 2 * other) / d**2
        force[..., k] = modulus / 6 * np.where(low < 0, 2 + first * slope[..., k], exact)
    tangent = second[..., None, None] * slope[..., :, None] * slope[..., None, :]
    tangent[..., 0, 1] += 4 * first
    tangent[..., 1, 0] += 4 * first
    tangent[..., 2, 2] -= 2 * first
    return energy, force, modulus[..., None, None] / 6 * tangent


class RubberShellKernel(ShellFacetKernel):
    """All shell facets of a sheet of which some are rubber: those whose ``rubber`` (n,), E t, is not zero."""

    linear_law = False

    def __init__(self, rest: Array, *given: Any, rubber: Array, **named: Any) -> None:
        super().__init__(rest, *given, **named)
        self.rubber = rubber
        self._own = np.flatnonzero(rubber > 0)

    def arrays(self) -> dict[str, Any]:
        return {**super().arrays(), "rubber": self.rubber}

    def compiled(self) -> None:
        return None

    sensitivity = Kernel.sensitivity

    def _answer(self, fields: Array, need: int = 2) -> Answer:
        answer = super()._answer(fields, need)
        own = self._own
        inside = AREA_PLACES @ fields[own]  # (k, points, 6)
        energy, force, tangent = membrane(np.broadcast_to(self.rubber[own, None], inside.shape[:2]), inside[..., :3])
        rigidity = self.section[own, 3:, 3:]
        moment = np.einsum("nab,nib->nia", rigidity, inside[..., 3:])
        energy = energy + 0.5 * (moment * inside[..., 3:]).sum(axis=2)
        share = self.chart.area[own] / 3
        answer.energy[own] = share * energy.sum(axis=1)
        borne = np.concatenate([force, moment], axis=2)
        answer.resultants[own] = share[:, None, None] * (AREA_PLACES.T @ borne)
        sections = np.repeat(answer.sections, 3, axis=1)
        sections[own, :, :3, :3] = tangent
        return Answer(answer.energy, answer.resultants, sections, own)

    def _drive_resultants(self, drive: Array, fields: Array) -> Array:
        sections = self._answer(fields).sections
        borne = np.einsum("niab,nib->nia", sections, AREA_PLACES @ drive)
        return np.asarray((self.chart.area / 3)[:, None, None] * (AREA_PLACES.T @ borne))

    def membrane_energy(self, x: Array, lam: float) -> Array:
        """All but that of bending, which is linear."""
        found = super().membrane_energy(x, lam)
        fields = squares_over(self._elastic(self._fields(x), lam))[self._own, :, 3:]
        bending = 0.5 * self.chart.area[self._own] * np.einsum(
            "nia,nab,nib->n", fields, self.section[self._own, 3:, 3:], fields
        )
        found[self._own] = self.evaluate(x, lam, 0).energy[self._own] - bending
        return found

    def force(self, deformation: Array) -> Array:
        """Forces and moments per length at rest (n, 6) of a uniform deformation (n, 6)."""
        found = super().force(deformation)
        found[self._own, :3] = membrane(self.rubber[self._own], deformation[self._own, :3])[1]
        return found
