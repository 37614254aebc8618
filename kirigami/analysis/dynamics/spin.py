"""Angular momentum of what floats freely.

A time step goes along the straight chord between two states, on which forces turn about other points than at its ends:
their average makes a small torque about the middle of the chord although no support and no load does. On a part that
nothing holds it is taken out again, by the forces of a rigid angular acceleration, so that angular momentum is kept as
exactly as momentum is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kirigami.primitives.kernel import Array
from kirigami.system.assembly import Index, scatter_add
from kirigami.system.inertia import Inertia
from kirigami.system.supports import connected_parts
from kirigami.system.system import System


class Spin:
    """Free parts of a system, and the forces that take out the torque that a chord leaves on them."""

    def __init__(self, system: System, inertia: Inertia) -> None:
        self.system, self.inertia = system, inertia
        self.outside = [kernel for kernel in system.kernels if not kernel.stores_energy or kernel.anchored]
        anchored = np.zeros(len(system.rest), dtype=bool)
        for kernel in system.kernels:
            if kernel.anchored:
                anchored[kernel.conn.ravel()] = True
        numbers = system.unknown.reshape(system.rest.shape)
        leads = (system.leader == np.arange(system.leader.size)).reshape(system.rest.shape)
        moving = np.asarray(inertia.rows.sum(axis=1)).ravel() != 0
        self.parts: list[Index] = []
        for part in connected_parts(system):
            rows = part[moving[part]]
            if len(rows) and not anchored[part].any() and (numbers[rows] >= 0).all() and leads[rows].all():
                self.parts.append(rows)

    def forces(self, gradients: Sequence[tuple[float, Array, Array, Array]], middle: Array) -> Array:
        """Forces (rows, dim), as gradients, that leave no torque about the `middle` of the chord (rows, dim) but that
        of the loads; for the weights, rows x, load factors and gradients at the places of the average."""
        total = np.sum([weight * gradient for weight, _, _, gradient in gradients], axis=0)
        correction = np.zeros_like(middle)
        loads = []
        for weight, x, factors, _ in gradients:
            lam = self.system.factored(factors)
            outer = np.zeros_like(middle)
            for kernel in self.outside:
                gradient = kernel.evaluate(x, lam, 1).gradient
                assert gradient is not None
                scatter_add(outer, kernel.conn, gradient)
            loads.append((weight, x, outer))
        for rows in self.parts:
            torque = -_torque(middle[rows], total[rows])
            for weight, x, outer in loads:
                torque += weight * _torque(np.asarray(x)[rows], outer[rows])
            correction[rows] += self._angular(rows, middle, torque)
        return correction

    def _angular(self, rows: Index, middle: Array, torque: Array) -> Array:
        """Forces (k, dim) of a rigid angular acceleration with a given torque and no resultant."""
        mass = self.inertia.rows[rows][:, rows]
        nodes = (rows < self.system.points).astype(float)  # rows behind them are offsets, which only turn
        weight = mass @ nodes
        centre = (weight @ middle[rows]) / (weight @ nodes)
        arms = middle[rows] - nodes[:, None] * centre
        fields = np.array([_turned(arms, axis) for axis in range(len(torque))])
        forces = np.array([mass @ field for field in fields])
        inertia = np.array([[float((field * force).sum()) for force in forces] for field in fields])
        share = np.linalg.lstsq(inertia, torque, rcond=1e-10)[0]
        return np.asarray(np.einsum("a,ank->nk", share, forces))


def _torque(arms: Array, forces: Array) -> Array:
    """Torque about the origin, (3,), or (1,) in a plane."""
    if arms.shape[1] == 2:
        return np.array([float((arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0]).sum())])
    return np.asarray(np.cross(arms, forces).sum(axis=0))


def _turned(arms: Array, axis: int) -> Array:
    """Velocities of `arms` at a unit spin about an axis; in a plane there is but one."""
    if arms.shape[1] == 2:
        return np.stack([-arms[:, 1], arms[:, 0]], axis=1)
    return np.cross(np.eye(3)[axis], arms)
