"""Assembly against sums over members, and what follows from shift invariance."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import LineString, box

import kirigami as kg
from kirigami.primitives.kernel import full_hessian, hessian_product


@pytest.fixture(scope="module")
def system() -> kg.System:
    """A slit sheet with bars, hinges, and a clamped edge, whose members are not all shift invariant."""
    mesh = kg.Sheet(box(0, 0, 1, 1), [LineString([(0.3, 0.5), (0.7, 0.5)])]).mesh(0.15)
    m = kg.Model.from_mesh(mesh, 1e-2, kg.Material(E=1.0, nu=0.3))
    m.add(kg.Fix(m.select(boundary="bottom"), clamp=True))
    return kg.System(m)


@pytest.fixture(scope="module")
def state(system: kg.System) -> np.ndarray:
    return 0.02 * np.random.default_rng(3).normal(size=system.rest.shape)


def test_tangent_is_the_sum_of_all_blocks_of_all_members(system: kg.System, state: np.ndarray) -> None:
    n, dim = system.rest.shape
    dense = np.zeros((n, dim, n, dim))
    for kernel in system.kernels:
        blocks = full_hessian(kernel, kernel.evaluate(system.configuration(state), 0.0, 2))
        for member, nodes in enumerate(kernel.conn):
            for a, first in enumerate(nodes):
                for b, second in enumerate(nodes):
                    dense[first, :, second] += blocks[member, a, b]
    found = system.stiffness(state, constrained=False).toarray()
    assert np.abs(found - dense.reshape(n * dim, -1)).max() < 1e-13 * np.abs(dense).max()
    assert np.abs(found - found.T).max() < 1e-14 * np.abs(dense).max()


def test_shifting_a_free_sheet_makes_no_force(system: kg.System, state: np.ndarray) -> None:
    """Bars and hinges alone: the blocks of every row sum to zero."""
    free = [kernel for kernel in system.kernels if kernel.translation_invariant]
    assert {kernel.name for kernel in free} == {"bars", "hinges"}
    for kernel in free:
        found = kernel.evaluate(system.configuration(state), 0.0, 2)
        shift = np.broadcast_to([1.0, -2.0, 0.5], (*kernel.conn.shape, 3))
        assert not hessian_product(kernel, found, shift).any()


def test_product_with_the_hessian_of_each_member(system: kg.System, state: np.ndarray) -> None:
    for kernel in system.kernels:
        found = kernel.evaluate(system.configuration(state), 0.0, 2)
        vectors = np.random.default_rng(4).normal(size=(*kernel.conn.shape, 3))
        expected = np.einsum("nklab,nlb->nka", full_hessian(kernel, found), vectors)
        assert np.abs(hessian_product(kernel, found, vectors) - expected).max() < 1e-13 * np.abs(expected).max()


def test_product_with_a_field_that_is_zero_nearly_everywhere(system: kg.System, state: np.ndarray) -> None:
    blocks = system.stiffness_blocks(state, 0.0)
    field = np.zeros_like(system.rest)
    field[[3, 7]] = [[1.0, 2.0, 3.0], [-1.0, 0.5, 0.0]]
    expected = system.stiffness(state, constrained=False) @ field.ravel()
    found = system.plan.multiply(blocks, field).ravel()
    assert np.abs(found - expected).max() < 1e-13 * np.abs(expected).max()
