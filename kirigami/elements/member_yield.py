"""Bars and hinges that yield, with isotropic and linear kinematic hardening in one dimension.

A bar of stiffness EA and strain e bears EA (e - p) along the measure of its strain, a hinge k (theta - theta_0 - p);
the laws of :mod:`kirigami.primitives.hardening` say how the plastic part p follows. From one accepted equilibrium to
the next the energy, per length of a bar,

    EA (e - p)^2 / 2 + K p^2 / 2 + int N_y da,

is that after minimising over p and a: a potential of the force, with the consistent tangent
EA (N_y' + K) / (EA + N_y' + K).
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
from kirigami.primitives.kernel import Array


class YieldingBarKernel(BarKernel):
    """Bars of one strain measure that yield; curves are in force over plastic strain. `history` is (n, 2): plastic
    strain, and its accumulated size."""

    path_dependent = True

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        EA: Array,
        rest_length: Array,
        strain: str = "green",
        law: str = "linear",
        members: NDArray[np.int64] | None = None,
        targets: Array | None = None,
        mass_per_length: Array | None = None,
        natural: Array | None = None,
        *,
        yields: Array,
    ) -> None:
        super().__init__(rest, conn, EA, rest_length, strain, law, members, targets, mass_per_length, natural)
        self.hardening = Hardening.unpacked(yields)
        self._state = np.zeros((len(conn), 2))

    def arrays(self) -> dict[str, Any]:
        return {**super().arrays(), "yields": self.hardening.packed}

    def compiled(self) -> None:
        return None

    @property
    def history(self) -> Array | None:
        return self._state

    @history.setter
    def history(self, value: Array | None) -> None:
        self._state = np.zeros((len(self.conn), 2)) if value is None else np.array(value, dtype=float)

    def commit(self, x: Array) -> None:
        _, _, plastic, accumulated = self._flow(self.beyond(self.deformation(x), 0.0))
        self._state = np.stack([plastic, accumulated], axis=1)

    def actuate(self, members: NDArray[np.int64], values: Array, constant: bool) -> None:
        super().actuate(members, values, constant)
        _refuse_drive(constant)

    def _flow(self, strain: Array) -> tuple[Array, Array, Array, Array]:
        return flow(self.EA, self.hardening, strain, self._state[:, 0], self._state[:, 1])

    def _law(self, strain: Array) -> tuple[Array, Array, Array]:
        force, slope, plastic, accumulated = self._flow(strain)
        energy = 0.5 * force * (strain - plastic) + 0.5 * self.hardening.kinematic * plastic**2
        energy += self.hardening.dissipated(accumulated)
        return energy / self.EA, force / self.EA, slope / self.EA

    def plastic(self) -> Array:
        return np.array(self._state[:, 1])

    def dissipated(self, x: Array) -> Array:
        return self.rest_length * self.hardening.dissipated(self._state[:, 1])


class YieldingHingeKernel(BendHingeKernel):
    """Bending hinges that yield; curves are in moment over plastic angle. `history` is (n, 3): angle, plastic angle,
    and its accumulated size."""

    path_dependent = True

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        stiffness: Array,
        rest_angle: Array,
        members: NDArray[np.int64] | None = None,
        targets: Array | None = None,
        *,
        yields: Array,
    ) -> None:
        super().__init__(rest, conn, stiffness, rest_angle, members, targets)
        self.hardening = Hardening.unpacked(yields)
        self._state = np.zeros((len(conn), 2))

    def arrays(self) -> dict[str, Any]:
        return {**super().arrays(), "yields": self.hardening.packed}

    def compiled(self) -> None:
        return None

    @property
    def history(self) -> Array | None:
        return np.column_stack([self._committed, self._state])

    @history.setter
    def history(self, value: Array | None) -> None:
        self._committed = self._initial.copy() if value is None else np.array(value[:, 0], dtype=float)
        self._state = np.zeros((len(self.conn), 2)) if value is None else np.array(value[:, 1:], dtype=float)

    def commit(self, x: Array) -> None:
        angle = self.deformation(x)
        _, _, plastic, accumulated = self._flow(angle - self.rest_angle)
        self._committed, self._state = angle, np.stack([plastic, accumulated], axis=1)

    def actuate(self, members: NDArray[np.int64], values: Array, constant: bool) -> None:
        super().actuate(members, values, constant)
        _refuse_drive(constant)

    def _flow(self, excess: Array) -> tuple[Array, Array, Array, Array]:
        return flow(self.stiffness, self.hardening, excess, self._state[:, 0], self._state[:, 1])

    def _law(self, excess: Array) -> tuple[Array, Array, Array]:
        moment, slope, plastic, accumulated = self._flow(excess)
        energy = 0.5 * moment * (excess - plastic) + 0.5 * self.hardening.kinematic * plastic**2
        return energy + self.hardening.dissipated(accumulated), moment, slope

    def force(self, angle: Array) -> Array:
        return self._flow(angle - self.rest_angle)[0]

    def force_at(self, deformation: Array, lam: float) -> Array:
        return self.force(deformation)

    def plastic(self) -> Array:
        return np.array(self._state[:, 1])

    def dissipated(self, x: Array) -> Array:
        return self.hardening.dissipated(self._state[:, 1])


def _refuse_drive(constant: bool) -> None:
    if not constant:
        raise ModelError(YIELDS_AND_DRIVEN)
