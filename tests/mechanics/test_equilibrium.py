"""What every stored step owes: equilibrium, quadratic convergence of Newton, independence of the steps, clean modes."""

from __future__ import annotations

import meshes
import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

import kirigami as kg


def _pulled_sheet(tol: float = 1e-8, step: float = 0.1) -> tuple[kg.Model, kg.Results]:
    """An arched strip pulled flat by a quarter of its length: bars and hinges both work, large rotations."""
    nodes, triangles = meshes.equilateral_strip(8, 2)
    model, points = meshes.sheet(nodes, triangles, 3.0, 0.2, bending=0.09)
    model.perturb(1.5 * np.sin(np.pi * nodes[:, 0] / 8))
    left = [p for p in points if p.x < 1e-9]
    right = [p for p in points if p.x > 8 - 1e-9]
    model.add(kg.Fix(left), kg.Fix(right, "yz"), kg.Prescribe(right, x=1.0))
    return model, kg.DisplacementControl(model, to=1.0, step=step, tol=tol).run()


@pytest.mark.parametrize("tol", [1e-6, 1e-8, 1e-10])
def test_every_stored_step_is_in_equilibrium(tol: float) -> None:
    """Residual on free dofs over root sum of squares of all element forces, computed here from one-element systems."""
    model, result = _pulled_sheet(tol)
    system = kg.System(model)
    for step in result.steps:
        residual = np.linalg.norm(system.reduce(system.gradient(step.u, lam=step.lam)))
        positions = model.positions() + step.u
        forces = [kernel.evaluate(positions).gradient for kernel in system.kernels]
        scale = np.sqrt(sum(float((force**2).sum()) for force in forces))
        assert residual <= 1.001 * tol * scale or scale < 1e-12
    assert len(result.lam) > 5 and result.lam[-1] == pytest.approx(1.0, abs=1e-14)


def test_newton_converges_quadratically() -> None:
    """One full Newton correction with the exact tangent turns an error e into an error in proportion to e^2."""
    model, result = _pulled_sheet(tol=1e-12)
    system = kg.System(model)
    noise = np.random.default_rng(0).normal(size=result[-1].u.shape)
    sizes, left = np.array([3e-3, 1e-3, 3e-4, 1e-4]), []
    for size in sizes:
        start = system.unknowns(result[-1].u + size * noise)
        displaced = system.displacement(start, 1.0)
        residual = system.reduce(system.gradient(displaced, lam=1.0))
        corrected = start - spsolve(system.stiffness(displaced, lam=1.0), residual)
        rest = system.reduce(system.gradient(system.displacement(corrected, 1.0), lam=1.0))
        left.append(np.linalg.norm(rest))
    order = np.polyfit(np.log(sizes), np.log(left), 1)[0]
    assert order == pytest.approx(2.0, abs=0.1)


def test_final_force_does_not_depend_on_the_steps() -> None:
    ends = []
    for step in (0.2, 0.1, 0.05):
        model, result = _pulled_sheet(step=step)
        right = [p for p in model.nodes if p.x > 8 - 1e-9]
        ends.append(result.reaction(right, "x")[-1])
    assert ends == pytest.approx([ends[0]] * 3, rel=1e-6)


def test_edited_model_is_refused() -> None:
    """A system made before an edit must not answer for the model after it."""
    model = kg.Model(dim=2)
    a, b, c = model.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1))
    model.add(kg.Bar(a, b, 1.0), kg.Bar(b, c, 1.0), kg.Bar(c, a, 1.0))
    system = kg.System(model)
    system.gradient(np.zeros((3, 3)))
    model.add(kg.NodalLoad(b, (1.0, 0.0)))
    with pytest.raises(kg.ModelError):
        system.gradient(np.zeros((3, 3)))


def test_constant_loads_act_at_load_factor_zero() -> None:
    """Step 0 balances constant loads; the others scale."""
    model = kg.Model(dim=2)
    a, b, c = model.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0.5, 1))
    model.add(kg.Bar(a, b, 50.0), kg.Bar(b, c, 50.0), kg.Bar(c, a, 50.0), kg.Fix(a), kg.Fix(b, "y"))
    model.add(kg.NodalLoad(c, (0.3, 0.0), constant=True), kg.NodalLoad(c, (0.0, -1.0)))
    result = kg.LoadControl(model, to=2.0, step=1.0, tol=1e-10).run()
    assert result.reaction(a, "x") == pytest.approx(np.full(len(result.lam), -0.3), abs=1e-8)
    assert result.reaction([a, b], "y") == pytest.approx(result.lam, abs=1e-7)
    assert result.lam[0] == 0.0


# -------------------------------------------------------------------------------------------------------- modes


def test_modes_of_a_free_flat_sheet() -> None:
    """Six zero values, no more; modes of the flat sheet move either in the plane or out of it."""
    nodes, triangles = meshes.equilateral_strip(5, 4)
    model, _ = meshes.sheet(nodes, triangles, 2.0, 0.1, bending=0.09)
    modes = kg.Eigen(model, n=10).run()
    assert np.all(np.diff(modes.values) >= -1e-12)
    stiffness = kg.System(model).stiffness(np.zeros((len(nodes), 3)), constrained=False).toarray()
    dense = np.linalg.eigvalsh(stiffness)
    assert np.abs(modes.values[:6]).max() < 1e-9 * dense[-1]
    assert modes.values[6:] == pytest.approx(dense[6:10], rel=1e-6)
    # Eigenvectors of distinct values are orthogonal, and each satisfies K v = value v.
    for k in range(6, 10):
        shape = modes[k].shape.ravel()
        assert np.abs(shape).max() == pytest.approx(1.0, abs=1e-6)
        assert shape[np.argmax(np.abs(shape) > 1 - 1e-6)] > 0
        assert stiffness @ shape == pytest.approx(modes.values[k] * shape, abs=1e-8 * dense[-1])
        flat, out = np.linalg.norm(modes[k].shape[:, :2]), np.linalg.norm(modes[k].shape[:, 2])
        assert min(flat, out) < 1e-6 * max(flat, out)


def test_imperfection_has_exactly_the_amplitude_asked_for() -> None:
    """max |dz| as requested, dx = dy = 0, and no stress: the rest state includes it."""
    nodes, triangles = meshes.equilateral_strip(5, 4)
    model, points = meshes.sheet(nodes, triangles, 2.0, 0.1, bending=0.09)
    model.add(kg.Fix([p for p in points if p.x < 1e-9 or p.x > 5 - 1e-9]))
    mode = kg.Eigen(model, n=1).run()[0]
    before = model.positions()
    model.perturb(mode, amplitude=0.037)
    offset = model.positions() - before
    assert np.abs(offset[:, 2]).max() == pytest.approx(0.037, rel=1e-12)
    assert np.abs(offset[:, :2]).max() < 1e-12
    assert np.abs(kg.System(model).gradient(np.zeros((len(nodes), 3)))).max() == 0.0
    # Any shape is scaled, one number per node is an offset in z, and without an amplitude it is taken as given.
    for shape, amplitude, largest in ((-5.0 * nodes[:, 0], 0.2, 0.2), (3.0 * nodes[:, 1], None, 3 * nodes[:, 1].max())):
        before = model.positions()
        model.perturb(shape, amplitude=amplitude)
        offset = model.positions() - before
        assert np.abs(offset).max(axis=0) == pytest.approx([0, 0, largest], abs=1e-12)
        assert offset[:, 2] * np.abs(shape).max() == pytest.approx(shape * largest, abs=1e-9)


def test_supports_hold_in_modes() -> None:
    """Constrained displacements stay zero; the lowest value is positive once rigid motion is stopped."""
    nodes, triangles = meshes.equilateral_strip(4, 2)
    model, points = meshes.sheet(nodes, triangles, 2.0, 0.1, bending=0.09)
    wall = [n for n, p in enumerate(points) if p.x < 0.6]
    model.add(kg.Fix([points[n] for n in wall]))
    modes = kg.Eigen(model, n=3).run()
    assert modes.values[0] > 0
    assert all(np.abs(modes[k].shape[wall]).max() == 0.0 for k in range(3))
    reduced = kg.System(model).stiffness(np.zeros((len(nodes), 3))).toarray()
    assert modes.values == pytest.approx(np.linalg.eigvalsh(reduced)[:3], rel=1e-7)
