"""Every effect on the sheet of the matrix, each of which can be stated differently."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from changes import Change
from structures import TOP, E, of_sheet, sheet

import kirigami as kg


def nodes_of(m: kg.Model, how: Change, *old: int) -> list[kg.Node]:
    """Nodes of the sheet of the matrix by their numbers in the drawing."""
    new = np.argsort(how.order(16))
    return [m.nodes[new[k]] for k in old]


def floor(
    m: kg.Model, how: Change, friction: float, shift: Any = (0, 0, 0), angle: float = 0.0
) -> kg.Contact:
    """A plane close under a free edge, which may move."""
    plane: Any = kg.Plane(how.places(np.array([0, 0, -2e-4])), how.turn @ [0, 0, 1])
    if any(shift):
        axis = np.linalg.det(how.turn) * how.turn @ [0.1, 0.2, 1.0]
        plane = kg.Moving(plane, how.places(np.array(shift)), angle, axis)
    return kg.Contact(
        nodes_of(m, how, 4, 8), plane, stiffness=500.0 * how.force / how.length,
        layer=1e-3 * how.length, friction=friction,
    )  # fmt: skip


def with_grip(m: kg.Model, how: Change) -> None:
    """The driven edge and the row before it as a rigid body that turns."""
    m.remove(*[item for item in m.constraints if isinstance(item, kg.Prescribe)])
    turn = np.linalg.det(how.turn) * how.turn @ [0.3, 0.1, 0.2]
    m.add(kg.Grip(nodes_of(m, how, *TOP, 9), move=how.places(np.array([0.02, 0.03, 0.1])), turn=turn))


def with_turn(m: kg.Model, how: Change) -> None:
    """The driven edge, turned about an axis of its own."""
    m.remove(*[item for item in m.constraints if isinstance(item, kg.Prescribe)])
    axis = np.linalg.det(how.turn) * how.turn @ [0.2, 1.0, 0.1]
    about, shift = how.places(np.array([0.5, 1.0, 0.0])), how.places(np.array([0.02, 0.03, 0.1]))
    m.add(kg.Turn(nodes_of(m, how, *TOP), 20.0, axis, about, shift))


def with_link(m: kg.Model, how: Change) -> None:
    m.add(kg.RigidLink(nodes_of(m, how, 4, 8, 5)))


def with_cable(m: kg.Model, how: Change) -> None:
    """From the free edge to the ground, slack or not."""
    ground = m.add(kg.Node(*how.places(np.array([-0.5, 0.3, 0.4])).tolist()))
    (end,) = nodes_of(m, how, 4)
    line = 0.3 * how.force / how.length**2
    m.add(kg.Fix(ground), kg.Bar(ground, end, EA=2e3 * how.force, law="cable", mass_per_length=line))


EFFECTS: dict[str, Callable[[kg.Model, Change], Any]] = {
    "contact": lambda m, how: m.add(floor(m, how, 0.0)),
    "friction": lambda m, how: m.add(floor(m, how, 0.4)),
    "spring": lambda m, how: m.add(kg.Spring(nodes_of(m, how, 4, 8), 800.0 * how.force / how.length)),
    "pressure": lambda m, how: m.add(kg.Pressure(400.0 * how.force / how.length**2)),
    "grip": with_grip,
    "link": with_link,
    "cable": with_cable,
    "actuated": lambda m, how: m.add(
        kg.Actuate(strain=(2e-3, 2e-3, 0), curvature=np.array([0.2, 0.2, 0]) / how.length, constant=True)
    ),
    "turn": with_turn,
    "moving surface": lambda m, how: m.add(floor(m, how, 0.4, (0.02, -0.01, 0.03), 5.0)),
    "flow": lambda m, how: m.add(kg.FlowPressure(400.0 * how.force / how.length**2, how.turn @ [0.3, 0.2, 1.0])),
    "heat": lambda m, how: m.add(kg.Actuate(heat=(300.0, 100.0))),
    "rubber": lambda m, how: None,  # by its material
    "edge load": lambda m, how: m.add(
        kg.EdgeLoad(nodes_of(m, how, 4, 8), how.turn @ [-60.0, 20.0, 10.0] * how.force / how.length)
    ),
    "area load": lambda m, how: m.add(kg.AreaLoad(how.turn @ [20.0, 0.0, 50.0] * how.force / how.length**2)),
    "gravity": lambda m, how: m.add(kg.Gravity(how.turn @ [0.0, 2e2, -8e2] * how.length)),
    "edge moment": lambda m, how: m.add(kg.EdgeMoment(nodes_of(m, how, 4, 8), 3.0 * how.force)),
    "crease": lambda m, how: m.add(kg.Crease(nodes_of(m, how, 4, 5), 0.5 * how.force)),
    "tie": lambda m, how: m.add(kg.Tie(nodes_of(m, how, 4), nodes_of(m, how, 8), "xyz")),
    "hinge": lambda m, how: m.add(kg.BendHinge(*nodes_of(m, how, *HINGE[how.mirrors]), 2.0 * how.force * how.length)),
}
HINGE = {False: (1, 5, 4, 9), True: (1, 4, 5, 9)}
MATERIALS: dict[str, Callable[[Change], Any]] = {
    "heat": lambda how: replace(of_sheet(how), expansion=1e-5),
    "rubber": lambda how: kg.NeoHookean(E * how.force / how.length**2, density=of_sheet(how).density),
}


def model_with(effect: str, rung: str, how: Change, drive: float = 1.0) -> kg.Model:
    """The sheet of the matrix with an effect."""
    m = sheet(rung, 3, how, drive, material=MATERIALS.get(effect, of_sheet)(how))
    EFFECTS[effect](m, how)
    return m
