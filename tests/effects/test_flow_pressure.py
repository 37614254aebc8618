"""The pressure of a flow: Newton's law on a tilted plate, its derivatives, and a flag that bends out of the way."""

from __future__ import annotations

import numpy as np
import pytest
from test_pressure import square

import kirigami as kg
from kirigami.model.flow_pressure import FlowPressureKernel


def test_force_on_a_tilted_plate_and_its_derivative() -> None:
    """q A cos^2 along the normal, with the flow from either side; the tangent is the symmetric part."""
    corners = np.array([[0, 0, 0], [1, 0, 0.0], [0.3, 0.9, 0]])
    for angle in (0.0, 0.7, 2.5):
        c, s = np.cos(angle), np.sin(angle)
        x = corners @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
        kernel = FlowPressureKernel(np.array([[0, 1, 2]]), 3.0, (0, 0, 1))
        normal = np.array([0, -s, c])
        assert kernel.force_on(x)[0] == pytest.approx(3.0 * 0.45 * c * abs(c) * normal, abs=1e-14)
    kernel = FlowPressureKernel(np.array([[0, 1, 2]]), 3.0, (0.6, 0, 0.8))
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
