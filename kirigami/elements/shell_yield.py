"""Shell facets that yield: von Mises plasticity in twelve layers at three points of each facet.

The law of the section is in :mod:`kirigami.elements.layers`. From one accepted equilibrium to the next the energy is
that of :mod:`kirigami.elements.plane_stress` after minimising over the plastic strain, so that all solvers work on it
as on an elastic one; when one is accepted, the plastic strains move on. A facet none of whose points has ever yielded
is elastic and costs as much, but for a look at its outermost layers.

Energy and forces at the three points inside, which integrate quadratics exactly, are those of the elastic facet as
long as it is elastic.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.layers import LAYERS, Layers
from kirigami.elements.natural import YIELDS_AND_DRIVEN
from kirigami.elements.plane_stress import STATE
from kirigami.elements.shell_derivatives import Answer
from kirigami.elements.shell_geometry import AREA_PLACES
from kirigami.elements.shell_kernel import ShellFacetKernel
from kirigami.errors import ModelError
from kirigami.primitives.hardening import Hardening
from kirigami.primitives.kernel import Array, CompiledKernel

POINTS = 3


@dataclass(eq=False)
class Flown:
    """What facets answer that have yielded or do so now.

    Attributes
    ----------
    facets : ndarray of int, shape (k,)
    energy : ndarray, shape (k,)
    at_corners : ndarray, shape (k, 3, 6)
        Derivatives of the energy by strain and curvature at the corners.
    section : ndarray, shape (k, 3, 6, 6), or None
        Tangent sections at the points inside.
    state : ndarray, shape (k, 3, layers, 8)
        Of each layer, see :mod:`kirigami.elements.plane_stress`, at the end of the increment.
    """

    facets: NDArray[np.int64]
    energy: Array
    at_corners: Array
    section: Array | None
    state: Array


def yield_constants(objects: Sequence[Any]) -> dict[str, Any]:
    """Thickness, elastic constants and yield curves of facets, as the kernel takes them."""
    curves, constants = [], np.empty((3, len(objects)))
    for position, facet in enumerate(objects):
        material = facet.material
        yields = material.yields
        if yields and facet.section is not None:
            raise ModelError(
                f"ShellFacet on {facet.nodes}: a facet with a section of its own stays elastic, since how its stress "
                "lies over the thickness is not known: give its material hardening=None, or no section"
            )
        curves.append(material.yield_curve if yields else None)
        constants[:, position] = (facet.thickness, material.E, material.nu) if yields else (facet.thickness, 1.0, 0.0)
    thickness, E, nu = constants
    return {"thickness": thickness, "E": E, "nu": nu, "yields": Hardening.of(curves).packed}


class YieldingShellKernel(ShellFacetKernel):
    """All shell facets of a sheet of which some can yield; the arguments beyond those of elastic ones are per facet.

    `history` is one row of numbers: the directors, how many layers have yielded, which these are, and their
    states; so steps keep nothing of what is elastic.
    """

    path_dependent = True
    linear_law = False

    def __init__(
        self, rest: Array, *given: Any, thickness: Array, E: Array, nu: Array, yields: Array, **named: Any
    ) -> None:
        super().__init__(rest, *given, **named)
        self.hardening = Hardening.unpacked(yields)
        self.layers = Layers(thickness, E, nu, self.hardening)
        self._facets = np.zeros(0, dtype=np.int64)  # those that have yielded, in their order
        self._states = np.zeros((0, POINTS, LAYERS, STATE))
        self._refuse_drive()

    def arrays(self) -> dict[str, Any]:
        own = {name: getattr(self.layers, name) for name in ("thickness", "E", "nu")}
        return {**super().arrays(), **own, "yields": self.hardening.packed}

    def actuate(self, members: NDArray[np.int64], values: Array, constant: bool) -> None:
        super().actuate(members, values, constant)
        self._refuse_drive()

    def _refuse_drive(self) -> None:
        if self.scaled:
            raise ModelError(YIELDS_AND_DRIVEN)

    def compiled(self) -> CompiledKernel | None:
        from kirigami.elements.compiled_shell import CompiledYieldingShell

        return CompiledYieldingShell(self)

    # ---- history

    @property
    def history(self) -> Array | None:
        directors = np.asarray(super().history)
        rows = self._states.reshape(-1, STATE)
        flown = np.flatnonzero(rows[:, 3])
        per_facet = POINTS * LAYERS
        which = self._facets[flown // per_facet] * per_facet + flown % per_facet
        return np.concatenate([directors.ravel(), [len(flown)], which, rows[flown].ravel()])

    @history.setter
    def history(self, value: Array | None) -> None:
        if value is None:
            self._directors = self._rest_directors
            self._facets, self._states = self._facets[:0], self._states[:0]
            return
        size = self._rest_directors.size
        count = int(value[size])
        self._directors = value[:size].reshape(self._rest_directors.shape)
        which = value[size + 1 : size + 1 + count].astype(np.int64)
        facet, layer = np.divmod(which, POINTS * LAYERS)
        self._facets, place = np.unique(facet, return_inverse=True)
        states = np.zeros((len(self._facets), POINTS * LAYERS, STATE))
        states[place, layer] = value[size + 1 + count :].reshape(count, STATE)
        self._states = states.reshape(-1, POINTS, LAYERS, STATE)

    def fits(self, history: Array) -> bool:
        size = self._rest_directors.size
        if history.ndim != 1 or len(history) <= size:
            return False
        return bool(len(history) == size + 1 + (1 + STATE) * history[size])

    def commit(self, x: Array) -> None:
        flown = self.flow(self._elastic(self._fields(x), 0.0), tangent=False)
        some = flown.state[..., 3].any(axis=(1, 2))
        self._facets, self._states = flown.facets[some], flown.state[some]
        super().commit(x)

    # ---- law

    def flow(self, fields: Array, tangent: bool = True, layers: Layers | None = None) -> Flown:
        """What facets that have yielded, or do so now, answer to elastic strain and curvature (n, 3, 6) at the corners;
        `layers` may be a twin of the kernel's own."""
        layers = self.layers if layers is None else layers
        inside = AREA_PLACES @ fields
        on = layers.passed(inside)
        on[self._facets] = True
        facets = np.flatnonzero(on)
        state = np.zeros((len(facets), POINTS, LAYERS, STATE))
        state[np.searchsorted(facets, self._facets)] = self._states
        energy, borne, section, new = layers.select(facets).respond(inside[facets], state, tangent)
        share = self.chart.area[facets] / POINTS
        return Flown(
            facets, share * energy.sum(axis=1), share[:, None, None] * (AREA_PLACES @ borne), section, new
        )

    def _answer(self, fields: Array, need: int = 2) -> Answer:
        answer = super()._answer(fields, need)
        flown = self.flow(fields, need == 2)
        if not len(flown.facets):
            return answer
        answer.energy[flown.facets], answer.resultants[flown.facets] = flown.energy, flown.at_corners
        sections = answer.sections
        if flown.section is not None:
            sections = np.repeat(sections, POINTS, axis=1)
            sections[flown.facets] = flown.section
        return Answer(answer.energy, answer.resultants, sections, flown.facets)

    # ---- what it tells

    def plastic(self) -> Array:
        """Accumulated plastic strain (n,) of each facet, the largest of the layers of the mean over its points."""
        found = np.zeros(len(self.conn))
        if len(self._facets):
            found[self._facets] = self._states[..., 3].mean(axis=1).max(axis=1)
        return found

    def dissipated(self, x: Array) -> Array:
        found = np.zeros(len(self.conn))
        if len(self._facets):
            lost = self.layers.select(self._facets).dissipated(self._states)
            found[self._facets] = self.chart.area[self._facets] / POINTS * lost.sum(axis=1)
        return found

    def force_of(self, x: Array, lam: float) -> Array:
        """Mean forces and moments per length (n, 6)."""
        return np.asarray(self.point_forces(x, lam).mean(axis=1))

    def point_forces(self, x: Array, lam: float) -> Array:
        """Forces and moments per length (n, 3, 6) at the points inside."""
        fields = self._elastic(self._fields(x), lam)
        inside = AREA_PLACES @ fields
        found = inside @ self.section.transpose(0, 2, 1)
        flown = self.flow(fields, tangent=False)
        if len(flown.facets):  # by the means at the corners: their inverse
            corner = flown.at_corners * (POINTS / self.chart.area[flown.facets])[:, None, None]
            found[flown.facets] = np.linalg.inv(AREA_PLACES) @ corner
        return np.asarray(found)

    def membrane_energy(self, x: Array, lam: float) -> Array:
        """That of the elastic part of the strain."""
        forces = self.point_forces(x, lam)[..., :3]
        stretch = np.linalg.solve(self.section[:, None, :3, :3], forces[..., None])[..., 0]
        return np.asarray(self.chart.area / 6 * (stretch * forces).sum(axis=(1, 2)))

    def layer_stress(self, x: Array, lam: float) -> tuple[NDArray[np.int64], Array]:
        """The facets that have yielded (k,), and the mean stress (k, layers, 3) of each of their layers, from the lower
        face to the upper one."""
        inside = AREA_PLACES @ self._elastic(self._fields(x), lam)[self._facets]
        return self._facets, self.layers.select(self._facets).stress(inside, self._states).mean(axis=1)
