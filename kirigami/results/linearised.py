"""What kernels answer in a linear analysis: to first order about the rest state and load factor zero."""

from __future__ import annotations

import numpy as np

from kirigami.primitives.kernel import Array, Configuration, Contribution, Kernel

NEAR = 1e-4  # share of a deformation over which the force of a linear analysis follows its tangent
SMALL = 1e-4  # load factor over which a difference tells a rate


def linear_contribution(kernel: Kernel, rest: Configuration, lam: float, rows: Array) -> Contribution:
    """Energy to second order and gradient to first of a kernel at displacements (rows, dim), for a load factor."""
    u = rows[kernel.conn]
    start, rate = _at_rest(kernel, rest, lam, u)
    assert start.gradient is not None
    energy = start.energy + ((start.gradient + 0.5 * rate) * u).sum(axis=(1, 2))
    return Contribution(energy, start.gradient + rate)


def _at_rest(kernel: Kernel, rest: Configuration, lam: float, u: Array) -> tuple[Contribution, Array]:
    """Energy and gradient of a kernel at rest, and the change of the gradient (n, k, dim) by displacements `u`."""
    if not kernel.scaled or type(kernel).by_load is Kernel.by_load:
        return _with_product(kernel, rest, lam, u)
    (found, product), rate = _with_product(kernel, rest, 0.0, u), kernel.by_load(rest, 0.0, 1)
    assert found.gradient is not None and rate.gradient is not None
    bend = (kernel.by_load(rest, SMALL, 0).energy - kernel.by_load(rest, -SMALL, 0).energy) / (2 * SMALL)
    energy = found.energy + lam * rate.energy + 0.5 * lam**2 * bend
    return found._replace(energy=energy, gradient=found.gradient + lam * rate.gradient), product


def _with_product(kernel: Kernel, rest: Configuration, lam: float, u: Array) -> tuple[Contribution, Array]:
    """See :meth:`kirigami.Kernel.with_product`; Hessians are dear, and at load factor zero nothing moves."""
    return kernel.with_product(rest, lam, u) if u.any() else (kernel.evaluate(rest, lam, 1), np.zeros_like(u))


def linear_force(kernel: Kernel, start: Array, felt: Array, lam: float) -> Array:
    """Force of a kernel whose members felt `start` at rest and feel `felt` now."""
    change = felt - start
    size = float(np.abs(change).max(initial=0.0))
    force = kernel.force_at(start, 0.0)
    if kernel.scaled:
        rate = kernel.force_at(start, SMALL) - kernel.force_at(start, -SMALL)
        force = force + lam / (2 * SMALL) * rate
    if size == 0:
        return force
    share = NEAR * (float(np.abs(start).max()) or 1.0) / size
    rate = kernel.force_at(start + share * change, 0.0) - kernel.force_at(start - share * change, 0.0)
    return np.asarray(force + rate / (2 * share))
