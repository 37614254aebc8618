"""The pressure of a flow: Newton's law on a tilted plate, its derivatives, and a flag that bends out of the way."""

from __future__ import annotations

import numpy as np
import pytest
from test_pressure import square

import kirigami as kg
from kirigami.analysis.path.skew import solve
from kirigami.linalg import factorize
from kirigami.model.flow_pressure import FlowPressureKernel


def test_force_on_a_tilted_plate_and_its_derivative() -> None:
    """q A cos^2 along the normal, with the flow from either side; the tangent is the symmetric part."""
    corners = np.array([[0, 0, 0], [1, 0, 0.0], [0.3, 0.9, 0]])
    for angle in (0.0, 0.7, 2.5):
        c, s = np.cos(angle), np.sin(angle)
        x = corners @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
        kernel = FlowPressureKernel(np.zeros((3, 3)), np.array([[0, 1, 2]]), 3.0, (0, 0, 1))
        normal = np.array([0, -s, c])
        assert kernel.force_on(x)[0] == pytest.approx(3.0 * 0.45 * c * abs(c) * normal, abs=1e-14)
    kernel = FlowPressureKernel(np.zeros((3, 3)), np.array([[0, 1, 2]]), 3.0, (0.6, 0, 0.8))
    x = corners + [[0, 0.1, 0.2], [0] * 3, [0.1] * 3]
    step, slope = 1e-6, np.zeros((3, 3, 3, 3))
    for node in range(3):
        for axis in range(3):
            moved = [x.copy(), x.copy()]
            moved[0][node, axis] += step
            moved[1][node, axis] -= step
            ends = [kernel.evaluate(y, 0.7, 1).gradient[0] for y in moved]
            slope[:, node, :, axis] = (ends[0] - ends[1]) / (2 * step)
    assert kernel.evaluate(x, 0.7).hessian[0] == pytest.approx(0.5 * (slope + slope.transpose(1, 0, 3, 2)), abs=1e-8)
    assert np.abs(slope - slope.transpose(1, 0, 3, 2)).max() > 0.01


def test_a_flag_bends_out_of_the_way() -> None:
    """The resultant is what the facets bear as they are, less than across the flow."""
    m = square("plate", 3)
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.FlowPressure(0.15, (0, 0, 1)))
    res = kg.LoadControl(m, tol=1e-10).run()
    (kernel,) = [k for k in res.kernels if k.name == "flow"]
    force = kernel.force_on(res.position()[-1]).sum(axis=0)
    assert res.reaction("fixed_0")[-1] == pytest.approx(-force, abs=1e-8)
    assert 0.05 < force[2] < 0.14
    with pytest.raises(kg.ModelError, match="flow have no potential"):
        kg.LoadControl(m, on_instability="switch").run()


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(kg.ModelError, match="needs a direction"):
        kg.FlowPressure(1.0, (0, 0, 0))
    with pytest.raises(kg.ModelError, match="q must be"):
        kg.FlowPressure(float("inf"))


def bent_flag(q: float = 0.15) -> kg.Results:
    m = square("plate", 3)
    m.add(kg.Fix(m.select(boundary="left"), clamp=True), kg.FlowPressure(q, (0, 0, 1)))
    return kg.LoadControl(m, tol=1e-10).run()


def test_corrections_know_the_skew_part_of_the_tangent() -> None:
    """Moved along a solution, the forces change by the right-hand side; the symmetric part alone is off."""
    res = bent_flag()
    system, step = kg.System(res.model), res[-1]
    system.history = step.history
    u = res.rows(step)
    q = system.reduce(u)
    factor = factorize(system.matrix(system.stiffness_blocks(u, 1.0)))
    rhs = np.cos(np.arange(len(q)))
    size = 1e-7

    def change(way: np.ndarray) -> np.ndarray:
        ends = [system.imbalance(system.displacement(q + sign * size * way, 1.0), 1.0)[0] for sign in (1, -1)]
        return (ends[0] - ends[1]) / (2 * size)

    def wrong(way: np.ndarray) -> float:
        scaled = way / np.abs(way).max()
        return float(np.abs(change(scaled) - rhs / np.abs(way).max()).max() / np.abs(rhs / np.abs(way).max()).max())

    assert wrong(solve(system, factor, q, 1.0, rhs)) < 1e-4
    assert wrong(factor.solve(rhs)) > 1e-2


def test_increments_in_a_strong_flow_stay_long() -> None:
    """With the symmetric part alone each correction takes a share of the error, and increments shrink without end."""
    res = bent_flag(3.0)
    assert len(res) < 40
    assert res.stats["iterations"] < 6 * len(res)
