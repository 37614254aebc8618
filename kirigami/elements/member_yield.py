"""Bars and hinges that yield, with isotropic and kinematic hardening in one dimension.

A bar of stiffness EA and strain e bears EA (e - p) along the measure of its strain, a hinge k (theta - theta_0 - p);
the laws of :mod:`kirigami.primitives.hardening` say how the plastic part p follows. From one accepted equilibrium to
the next the energy, per length of a bar,

    EA (e - p)^2 / 2 + int b dp + int N_y da,

with the back force b is that after minimising over p and a: a potential of the force, with the consistent tangent
EA (N_y' + H') / (EA + N_y' + H').
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.bar import BarKernel
from kirigami.elements.bend_hinge import BendHingeKernel
from kirigami.elements.natural import YIELDS_AND_DRIVEN
from kirigami.errors import ModelError
from kirigami.primitives.hardening import Hardening, flow
from kirigami.primitives.kernel import Array, Kernel


class YieldingKernel(Kernel):
    """What bars and hinges that yield share, before the class of those that do not: the state of the flow (n, 4):
    the plastic part, its accumulated size, the back force and what this has stored. `given` and `named` are what that
    class takes."""

    path_dependent = True

    def __init__(self, rest: Array, *given: Any, yields: Array, **named: Any) -> None:
        super().__init__(rest, *given, **named)  # type: ignore[call-arg]
        self.hardening = Hardening.unpacked(yields)
        self._state = np.zeros((len(self.conn), 4))

    def arrays(self) -> dict[str, Any]:
        return {**super().arrays(), "yields": self.hardening.packed}

    def compiled(self) -> None:
        return None

    def actuate(self, members: NDArray[np.int64], values: Array, constant: bool) -> None:
        if not constant:
            raise ModelError(YIELDS_AND_DRIVEN)
        super().actuate(members, values, constant)

    def _flow(self, stiffness: Array, felt: Array) -> tuple[Array, Array, Array]:
        return flow(stiffness, self.hardening, felt, self._state)

    def _potential(self, stiffness: Array, felt: Array) -> tuple[Array, Array, Array]:
        """Energy, force and slope (n,) of the increment, per length of a bar."""
        force, slope, new = self._flow(stiffness, felt)
        energy = 0.5 * force * (felt - new[:, 0]) + new[:, 3]
        return energy + self.hardening.dissipated(new[:, 1]), force, slope

    def plastic(self) -> Array:
        return np.array(self._state[:, 1])


class YieldingBarKernel(YieldingKernel, BarKernel):
    """Bars of one strain measure that yield; curves are in force over plastic strain. `history` is the state of
    the flow (n, 4)."""

    @property
    def history(self) -> Array | None:
        return self._state

    @history.setter
    def history(self, value: Array | None) -> None:
        self._state = np.zeros((len(self.conn), 4)) if value is None else np.array(value, dtype=float)

    def commit(self, x: Array) -> None:
        self._state = self._flow(self.EA, self.beyond(self.deformation(x), 0.0))[2]

    def _law(self, strain: Array) -> tuple[Array, Array, Array]:
        energy, force, slope = self._potential(self.EA, strain)
        return energy / self.EA, force / self.EA, slope / self.EA

    def dissipated(self, x: Array) -> Array:
        return self.rest_length * self.hardening.dissipated(self._state[:, 1])


class YieldingHingeKernel(YieldingKernel, BendHingeKernel):
    """Bending hinges that yield; curves are in moment over plastic angle. `history` is (n, 5): the angle,
    and the state of the flow."""

    @property
    def history(self) -> Array | None:
        return np.column_stack([self._committed, self._state])

    @history.setter
    def history(self, value: Array | None) -> None:
        self._committed = self._initial.copy() if value is None else np.array(value[:, 0], dtype=float)
        self._state = np.zeros((len(self.conn), 4)) if value is None else np.array(value[:, 1:], dtype=float)

    def commit(self, x: Array) -> None:
        angle = self.deformation(x)
        self._committed, self._state = angle, self._flow(self.stiffness, angle - self.rest_angle)[2]

    def _law(self, excess: Array) -> tuple[Array, Array, Array]:
        return self._potential(self.stiffness, excess)

    def force(self, angle: Array) -> Array:
        return self._flow(self.stiffness, angle - self.rest_angle)[0]

    def force_at(self, deformation: Array, lam: float) -> Array:
        return self.force(deformation)

    def dissipated(self, x: Array) -> Array:
        return self.hardening.dissipated(self._state[:, 1])
