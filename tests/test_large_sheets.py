"""What large sheets ask for: memory for what has to be there at once, and no more."""

import tracemalloc
import weakref

import numpy as np
import pytest

import kirigami as kg
from kirigami.linalg import factorize, lowest_eigenpairs, multifrontal
from kirigami.primitives.kernel import full_hessian


def pulled(edge):
    """A slit sheet, a little off the plane, that is pulled along."""
    mesh = kg.Sheet([(0, 0), (3, 0), (3, 2), (0, 2)], [[(0.5, 1), (2.5, 1)]]).mesh(edge)
    model = kg.Model.from_mesh(mesh, 0.01, kg.Material(1e6, 0.3, density=1.0), stiffness="shell")
    model.perturb(0.01 * np.sin(model.positions()[:, 0]))
    model.add(kg.Fix(model.select(boundary="left"), clamp=True), kg.Prescribe(model.select(boundary="right"), x=1e-3))
    return model


@pytest.fixture(scope="module")
def model():
    return pulled(0.2)


def test_products_with_hessians_are_made_piece_by_piece():
    """They are those of the Hessians, of which never all are there."""
    system = kg.System(pulled(0.07))
    kernel = next(kernel for kernel in system.kernels if kernel.name == "shell")
    u = 1e-3 * np.random.default_rng(0).normal(size=system.rest.shape)
    x, vectors = system.configuration(u), u[kernel.conn]
    whole = kernel.evaluate(x, 0.0, 2)
    hessian = full_hessian(kernel, whole)
    kernel.with_product(x, 0.0, vectors)  # loads what it needs
    tracemalloc.start()
    found, product = kernel.with_product(x, 0.0, vectors)
    sizes = kernel.stiffness_size(x, 0.0)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < hessian.nbytes
    np.testing.assert_array_equal(found.gradient, whole.gradient)
    expected = np.einsum("nklab,nlb->nka", hessian, vectors)
    np.testing.assert_allclose(product, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(sizes, np.sqrt((hessian**2).sum(axis=(1, 2, 3, 4))), rtol=1e-12)


def test_modes_have_one_factor_at_a_time_and_one_order_of_elimination(model, monkeypatch):
    """The factor that finds them has gone before another one counts them, in the same pattern."""
    alive, dissections = weakref.WeakSet(), []
    make, dissect = multifrontal.MultifrontalFactor, multifrontal.dissect

    def factor(*given):
        assert not len(alive)
        made = make(*given)
        alive.add(made)
        return made

    monkeypatch.setattr(multifrontal, "MultifrontalFactor", factor)
    monkeypatch.setattr(multifrontal, "dissect", lambda *given: dissections.append(1) or dissect(*given))
    for mass in ("unit", "consistent"):
        dissections.clear()
        modes = kg.Eigen(model, n=3, mass=mass)
        assert len(modes.run()) == 3
        assert modes.results.stats["factorizations"] == 2
        assert len(dissections) == 1


def test_a_path_has_two_factors_at_a_time(model, monkeypatch):
    """That of the last equilibrium, from which it may have to start again, and the present one."""
    alive = weakref.WeakSet()
    make = multifrontal.MultifrontalFactor

    def factor(*given):
        assert len(alive) < 2
        made = make(*given)
        alive.add(made)
        return made

    monkeypatch.setattr(multifrontal, "MultifrontalFactor", factor)
    res = kg.DisplacementControl(model, step=0.2).run()
    assert res.stable.all() and res.stats["factorizations"] > 3


def test_several_right_hand_sides_are_solved_as_one_by_one(model, monkeypatch):
    """By compiled loops and by plain ones; where a front is not positive as well."""
    system = kg.System(model)
    squeezed = system.displacement(np.zeros(system.free), -50.0)
    rights = np.random.default_rng(0).normal(size=(system.free, 3))
    monkeypatch.setattr(multifrontal, "COMPILED", 1)
    for state in (np.zeros_like(system.rest), squeezed):
        factor = factorize(system.matrix(system.stiffness_blocks(state, 0.0)))
        assert bool(factor.negative) == state.any()
        together = factor.solve(rights)
        for right, solution in zip(rights.T, together.T):
            alone = factor.solve(right)
            assert np.linalg.norm(solution - alone) < 1e-7 * np.linalg.norm(alone)
        residual = factor.matrix @ together - rights
        assert np.linalg.norm(residual) < 1e-6 * np.linalg.norm(rights)


def test_masses_may_stand_where_the_stiffness_has_nothing():
    """Two equal springs k to the ground, whose masses are coupled: k v = value M v."""
    from scipy.sparse import csc_matrix

    mass = np.array([[2.0, 1.0], [1.0, 2.0]])
    values, _ = lowest_eigenpairs(csc_matrix(3.0 * np.eye(2)), csc_matrix(mass), 2, np.zeros((2, 0)), factorize)
    assert values == pytest.approx([1.0, 3.0], rel=1e-12)
