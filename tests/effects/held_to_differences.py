"""A kernel held to differences of its energy: by positions and by the load factor."""

from __future__ import annotations

from typing import Any

import numpy as np

import kirigami as kg


def kernel_of(model: kg.Model, name: str) -> Any:
    return next(kernel for kernel in kg.System(model).kernels if kernel.name == name)


def assert_right(kernel: Any, x: Any, lam: float = 0.7, bound: float = 1e-7, balanced: bool = False) -> None:
    """Gradient, Hessian and change with the load factor agree with differences; forces of an element balance."""
    errors = kg.check_kernel(kernel, x, lam=lam)
    assert max(errors["gradient"], errors["hessian"], errors["symmetry"]) < bound, errors
    if balanced:
        assert max(errors["force"], errors["moment"], errors["rigid"]) < bound, errors
    if not kernel.scaled:
        return
    step = 1e-5
    rate = kernel.by_load(np.asarray(x, dtype=float), lam, 1)
    after, before = (kernel.evaluate(np.asarray(x, dtype=float), lam + sign * step, 1) for sign in (1, -1))
    pairs = (rate.energy, after.energy, before.energy), (rate.gradient, after.gradient, before.gradient)
    for found, later, earlier in pairs:
        wanted = (later - earlier) / (2 * step)
        assert np.abs(found - wanted).max() <= bound * max(np.abs(wanted).max(), np.abs(later).max())
