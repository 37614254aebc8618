"""The kernel of the shell facet against differences, rigid motion, and its compiled twin."""

import numpy as np
import pytest

import kirigami as kg
from kirigami.elements.crease import CreaseKernel
from kirigami.elements.shell_kernel import ShellFacetKernel
from kirigami.primitives.kernel import Configuration, Tangent
from kirigami.system.assembly import BlockPlan

SQUARE = [[0, 0, 0], [1, 0.1, 0], [1.1, 1, 0.1], [-0.1, 0.9, 0]]
FACETS = [[0, 1, 2], [0, 2, 3]]


def kernel_of(points=SQUARE, facets=FACETS, coupled=False, creases=(), **options):
    """The lowered shell facets of a small mesh, and their rows at rest."""
    model = kg.Model()
    nodes = [model.add(kg.Node(*point)) for point in points]
    section = None
    if coupled:
        random = np.random.default_rng(3).normal(size=(6, 6))
        section = random @ random.T + 6 * np.eye(6)
    material = kg.Material(E=3.0, nu=0.3)
    model.add(*(kg.ShellFacet(*(nodes[k] for k in facet), 0.2, material, section=section, **options)
                for facet in facets))  # fmt: skip
    for line, stiffness, angle in creases:
        model.add(kg.Crease([nodes[k] for k in line], stiffness, angle))
    system = kg.System(model)
    return next(k for k in system.kernels if isinstance(k, ShellFacetKernel)), system


def folded(angle):
    """Two facets that meet at an edge at an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return [[0, 0, 0], [0, 1, 0], [-0.9, 0.4, 0], [0.8 * c, 0.6, 0.8 * s]], [[0, 1, 2], [1, 0, 3]]


@pytest.mark.parametrize("coupled", [False, True])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_derivatives_at_large_deformations(coupled, seed):
    kernel, system = kernel_of(coupled=coupled)
    x = system.rest + 0.25 * np.random.default_rng(seed).normal(size=system.rest.shape)
    assert max(kg.check_kernel(kernel, x).values()) < 1e-7


@pytest.mark.parametrize("degrees", [-170, -90, 30, 120, 170])
def test_derivatives_at_folds(degrees):
    points, facets = folded(np.radians(degrees))
    kernel, system = kernel_of(points, facets)
    x = system.rest + 0.1 * np.random.default_rng(4).normal(size=system.rest.shape)
    assert max(kg.check_kernel(kernel, x).values()) < 1e-7


def test_derivatives_of_a_crease():
    points, facets = folded(1.0)
    _, system = kernel_of(points, facets, creases=[((0, 1), 0.7, 0.2)])
    kernel = next(k for k in system.kernels if isinstance(k, CreaseKernel))
    x = system.rest + 0.1 * np.random.default_rng(5).normal(size=system.rest.shape)
    errors = kg.check_kernel(kernel, x)
    assert max(errors[name] for name in ("gradient", "hessian", "symmetry")) < 1e-7
    assert kernel.deformation(system.rest) == pytest.approx(1.0, abs=1e-12)


def test_moving_the_directors_along_changes_no_energy():
    kernel, system = kernel_of(coupled=True)
    random = np.random.default_rng(6)
    before = system.rest + 0.2 * random.normal(size=system.rest.shape)
    x = before + 0.1 * random.normal(size=system.rest.shape)
    energy = kernel.evaluate(x, need=0).energy
    kernel.commit(before)
    turned = kernel.evaluate(x, need=0).energy
    kernel.commit(x)
    assert kernel.evaluate(x, need=0).energy == pytest.approx(turned, rel=1e-12)
    assert not np.allclose(energy, turned)  # angles are counted from the directors, so x is another state meanwhile


@pytest.mark.parametrize("coupled", [False, True])
@pytest.mark.parametrize("convexity, ahead", [(0.0, False), (0.6, False), (0.3, True)])
@pytest.mark.parametrize("actuated", [False, True])
def test_the_compiled_twin_agrees(coupled, convexity, ahead, actuated):
    pytest.importorskip("numba")
    kernel, system = kernel_of(coupled=coupled)
    random = np.random.default_rng(7)
    if actuated:
        for constant in (False, True):
            kernel.actuate(np.arange(0, len(kernel.conn), 2), 0.3 * random.normal(size=(1, 6)), constant)
    kernel.commit(system.rest + 0.2 * random.normal(size=system.rest.shape))
    u = 0.2 * random.normal(size=system.rest.shape)
    x = Configuration(system.rest, u)
    plain, fast = np.zeros_like(u), np.zeros_like(u)
    contribution = kernel.evaluate(x, 1.0, 2)
    np.add.at(plain, kernel.conn, contribution.gradient)
    twin = kernel.compiled()
    assert twin.energy(x, 1.0) == pytest.approx(contribution.energy.sum(), rel=1e-12)
    squares = twin.add_forces(x, 1.0, fast)
    np.testing.assert_allclose(fast, plain, atol=1e-12 * np.abs(plain).max())
    assert squares == pytest.approx((contribution.gradient**2).sum(), rel=1e-12)
    tangent = Tangent(convexity, (Configuration(system.rest, 0.5 * u), 0.1 * u) if ahead else None)
    plan = BlockPlan([kernel], len(u))
    blocks, gathered = np.zeros((3, 3, plan.count)), np.zeros((plan.count, 3, 3))
    plan.add(blocks, kernel, plan.slots[0], kernel.evaluate(x, 1.0, 2, tangent).hessian)
    twin.add_blocks(x, 1.0, tangent, plan.slots[0], gathered)
    np.testing.assert_allclose(gathered.transpose(1, 2, 0), blocks, atol=1e-12 * np.abs(blocks).max())


def test_the_faded_tangent_is_never_indefinite():
    kernel, system = kernel_of()
    x = 0.7 * system.rest + 0.05 * np.random.default_rng(8).normal(size=system.rest.shape)  # pushed together
    n = len(kernel.conn)
    for convexity, indefinite in ((0.0, True), (1.0, False)):
        blocks = kernel.evaluate(x, 1.0, 2, Tangent(convexity)).hessian
        matrices = blocks.transpose(0, 1, 3, 2, 4).reshape(n, 27, 27)
        values = np.linalg.eigvalsh(matrices)
        assert (values.min() < -1e-6 * values.max()) is np.bool_(indefinite)


def test_small_strains_lose_no_digits():
    """Strain of 1e-12 in a sheet far from the origin, to nine digits."""
    kernel, system = kernel_of([[1e3 + x, 5e2 + y, 0] for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    u = np.zeros_like(system.rest)
    u[:4, 0] = 1e-12 * (system.rest[:4, 0] - 1e3)
    strain = kernel.deformation(Configuration(system.rest, u))
    assert strain[0, 0] == pytest.approx(1e-12, rel=1e-9)


def test_six_motions_cost_nothing_at_rest():
    kernel, system = kernel_of()
    matrix = system.stiffness(constrained=False).toarray()
    values = np.linalg.eigvalsh(matrix)
    idle = 5  # one number of each edge's angle row means nothing
    assert np.sum(np.abs(values) < 1e-12 * values.max()) == 6 + idle
    assert values.min() > -1e-12 * values.max()
