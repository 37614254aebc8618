"""Contact between panels: a one-sided spring on the angle, off unless added."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import trapezoid

import kirigami as kg
from kirigami import tilings
from kirigami.effects.angle_limit import AngleLimit, AngleLimitKernel

STIFFNESS, WIDTH = 30.0, 0.05


def _arms(angle: float, **limits: Any) -> tuple[kg.Model, kg.Node, kg.Node, kg.Node]:
    model = kg.Model(dim=2)
    i, j, k = model.add(kg.Node(0.8 * np.cos(angle), 0.8 * np.sin(angle)), kg.Node(0, 0), kg.Node(1.2, 0))
    model.add(kg.Bar(i, j, 1e5), kg.Bar(j, k, 1e5), kg.TorsionSpring3(i, j, k, 1.0), kg.Fix([j, k]))
    model.add(AngleLimit(i, j, k, STIFFNESS, width=WIDTH, **limits))
    return model, i, j, k


def _kernel(model: kg.Model) -> AngleLimitKernel:
    return next(kernel for kernel in kg.System(model).kernels if isinstance(kernel, AngleLimitKernel))


def _at(angle: float) -> np.ndarray:
    return np.array([[0.8 * np.cos(angle), 0.8 * np.sin(angle)], [0, 0], [1.2, 0]])


@pytest.mark.parametrize("depth", [-0.1, 0.3 * WIDTH, 0.9 * WIDTH, 3 * WIDTH, 10 * WIDTH])
@pytest.mark.parametrize("side", ["minimum", "maximum"])
def test_energy_moment_and_stiffness_belong_together(depth: float, side: str) -> None:
    model, *_ = _arms(1.0, **{side: 0.9 if side == "minimum" else 1.1})
    kernel = _kernel(model)
    errors = kg.check_kernel(kernel, _at(0.9 - depth if side == "minimum" else 1.1 + depth))
    assert max(errors["gradient"], errors["hessian"]) < 1e-6
    assert max(errors["force"], errors["moment"], errors["rigid"], errors["symmetry"]) < 1e-10


def test_law() -> None:
    """Nothing inside the limits; k d^2 / (2 w), then k (d - w / 2) beyond; energy is the integral of the moment."""
    kernel = _kernel(_arms(1.0, minimum=0.9, maximum=1.4)[0])
    assert kernel.evaluate(_at(1.2), 1.0, 0).energy[0] == 0.0
    depth = np.linspace(0, 4 * WIDTH, 2001)
    moment = np.array([-kernel.force(np.array([0.9 - d]))[0] for d in depth])
    expected = STIFFNESS * np.where(depth < WIDTH, depth**2 / (2 * WIDTH), depth - WIDTH / 2)
    assert moment == pytest.approx(expected, abs=1e-12)
    energy = [kernel.evaluate(_at(0.9 - d), 1.0, 0).energy[0] for d in depth]
    assert energy[-1] == pytest.approx(trapezoid(moment, depth), rel=1e-6)
    assert kernel.force(np.array([1.4 + 0.2]))[0] == pytest.approx(STIFFNESS * (0.2 - WIDTH / 2))


def test_stops_a_closing_joint() -> None:
    """Dead load on the arm: without limit it lies down along the load, with limit it stays near it."""
    angles = []
    for limited in (False, True):
        model, i, *_ = _arms(1.0, minimum=0.5)
        if not limited:
            model.remove(*model.effects)
        model.add(kg.NodalLoad(i, (10.0, 0.0)))
        tip = kg.LoadControl(model).run().position(i)[-1]
        angles.append(np.arctan2(tip[1], tip[0]))
    assert angles[0] < 0.15
    assert 0.5 - 0.2 < angles[1] < 0.5
    # Balance of moments about the pivot: load, spring, and the linear branch of the limit.
    load = 10.0 * 0.8 * np.sin(angles[1])
    assert load == pytest.approx(1.0 - angles[1] + STIFFNESS * (0.5 - angles[1] - WIDTH / 2), rel=1e-3)


def test_closed_joint_is_at_angle_zero_and_not_a_full_turn() -> None:
    squares = tilings.rotating_squares(0.0).patch(1, 1)
    model = squares.model(EA=1.0, stiffness=1.0)
    model.add(*squares.angle_limits(model, stiffness=1.0))
    kernel = _kernel(model)
    assert np.abs(np.sort(kernel.deformation(kernel.rest))[:4]).max() < 1e-9
    assert kernel.evaluate(kernel.rest, 1.0, 0).energy.sum() == pytest.approx(0.0, abs=1e-20)


def test_nothing_is_there_unless_added() -> None:
    squares = tilings.rotating_squares(0.5).patch(1, 1)
    names = {kernel.name for kernel in kg.System(squares.model(EA=1.0, stiffness=1.0)).kernels}
    assert names == {"bars", "springs"}


def test_survives_saving(tmp_path: Any) -> None:
    model, i, *_ = _arms(1.0, minimum=0.7)
    model.add(kg.Prescribe(i, x=0.2))
    result = kg.DisplacementControl(model).run()
    loaded = kg.load(result.save(tmp_path / "limit.npz"))
    assert result.energy["angle limits"][-1] > 0
    assert loaded.energy["angle limits"] == pytest.approx(result.energy["angle limits"], rel=1e-12)


def test_violated_limits_are_refused() -> None:
    with pytest.raises(kg.ModelError, match=r"violated in the rest state.*node 1 .*the angle 1 is not between 1.2"):
        kg.System(_arms(1.0, minimum=1.2)[0])
    squares = tilings.rotating_squares(0.3).patch(1, 1)
    with pytest.raises(kg.ModelError, match="already below the limit 0.4"):
        squares.angle_limits(squares.model(EA=1.0, stiffness=1.0), stiffness=1.0, minimum=0.4)
    i, j, k = kg.Node(1, 0), kg.Node(0, 0), kg.Node(0, 1)
    for options, words in (({}, "minimum or a maximum"), ({"minimum": 1.0, "maximum": 0.5}, "must be below"),
                           ({"minimum": np.nan}, "finite"), ({"minimum": 0.1, "width": 0.0}, "positive")):  # fmt: skip
        with pytest.raises(kg.ModelError, match=words):
            AngleLimit(i, j, k, 1.0, **options)
    space = kg.Model(dim=3)
    nodes = space.add(i, j, k)
    space.add(kg.Bar(i, j, 1.0), AngleLimit(*nodes, 1.0, minimum=0.1))
    with pytest.raises(kg.ModelError, match="dim=2"):
        kg.System(space)
