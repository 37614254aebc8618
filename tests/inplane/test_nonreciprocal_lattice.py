"""The nonreciprocal lattice: linear reciprocity, growth with force, symmetries, and the same panels meshed finely."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from lattices import node_at, script

import kirigami as kg
from kirigami import tilings
from kirigami.lattice.framework import Framework

EXAMPLE = script("examples", "nonreciprocal_lattice")
LEAN = math.pi / 16


def _linear(angle: float, state: str) -> float:
    piece, pins, left, right = EXAMPLE.lattice(angle)
    model = piece.model(EA=1e4, stiffness=EXAMPLE.JOINT, springs="both")
    push, read, inward = (left, right, 1.0) if state == "A" else (right, left, -1.0)
    model.add(kg.Fix([model.nodes[k] for k in pins]), kg.NodalLoad(model.nodes[push], (inward, 0)))
    return float(inward * kg.LinearStatic(model).run().u[-1, read, 0])


@pytest.mark.parametrize("angle", [0.0, LEAN, -0.3])
def test_reciprocal_for_small_forces(angle: float) -> None:
    """Symmetric stiffness: u21 = u12 (Maxwell, Betti)."""
    assert _linear(angle, "A") == pytest.approx(_linear(angle, "B"), rel=1e-8)


def test_difference_grows_with_the_square_of_the_force() -> None:
    forces = np.array([0.05, 0.1, 0.2, 0.4])
    rows = np.array([EXAMPLE.outputs(LEAN, force)[-1] for force in forces])
    difference = np.abs(rows[:, 1] - rows[:, 2])
    slope = np.polyfit(np.log(forces), np.log(difference), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.1)


@pytest.fixture(scope="module")
def leaning() -> np.ndarray:
    return np.asarray(EXAMPLE.outputs(LEAN))


def test_no_lean_no_difference() -> None:
    _, u21, u12 = EXAMPLE.outputs(0.0).T
    assert u21 == pytest.approx(u12, abs=1e-8 * np.abs(u21).max())
    assert np.abs(u21).max() > 0.1e-3


def test_opposite_lean_exchanges_the_roles(leaning: np.ndarray) -> None:
    _, u21, u12 = EXAMPLE.outputs(-LEAN).T
    assert u21 == pytest.approx(leaning[:, 2], abs=1e-8 * np.abs(leaning[:, 2]).max())
    assert u12 == pytest.approx(leaning[:, 1], abs=1e-8 * np.abs(leaning[:, 2]).max())


def test_substantial_at_ten_newtons(leaning: np.ndarray) -> None:
    """More than a tenth at 10 N for the chosen joint; less for stiffer joints, down to a percent at 50 times."""
    _, u21, u12 = leaning[-1]
    assert abs(u21 - u12) / max(abs(u21), abs(u12)) > 0.1
    shares = []
    for factor in (1, 5, 50):
        _, u21, u12 = EXAMPLE.outputs(LEAN, joint=factor * EXAMPLE.JOINT)[-1]
        shares.append(abs(u21 - u12) / max(abs(u21), abs(u12)))
    assert shares[0] > shares[1] > shares[2] and shares[2] < 0.02


def test_steps_and_controls_agree(leaning: np.ndarray) -> None:
    piece, pins, left, right = EXAMPLE.lattice(LEAN)
    halved = EXAMPLE.transmit(LEAN, "A", step=0.05)
    assert halved.u[-1, right, 0] == pytest.approx(leaning[-1, 1], rel=1e-5)
    model = piece.model(EA=EXAMPLE.E * EXAMPLE.THICKNESS * EXAMPLE.SIDE / 2, stiffness=EXAMPLE.JOINT, springs="both")
    model.add(kg.Fix([model.nodes[k] for k in pins]), kg.Prescribe(model.nodes[left], x=float(halved.u[-1, left, 0])))
    driven = kg.DisplacementControl(model).run()
    assert driven.reaction(model.nodes[left], "x")[-1] == pytest.approx(10.0, rel=1e-5)
    free = EXAMPLE.transmit(LEAN, "A")
    assert free.u[-1, right, 0] == pytest.approx(driven.u[-1, right, 0], rel=1e-5)


def test_turns_die_out_along_a_pinned_row() -> None:
    """Rigid squares on pins: each turns tan(pi/4 - lean) as far as its neighbour (chain of Kane and Lubensky 2014)."""
    cell = tilings.square_rhombus(LEAN)
    piece = cell.patch(5, 1, keep=lambda a, b, panel: panel == 0 or a < 4)
    model = piece.model(EA=1.0, stiffness=1.0)
    model.add(kg.Fix([node_at(model, a * cell.lattice[0]) for a in range(5)]))
    found = Framework.from_model(model).rigidity()
    assert len(found.internal) == 1
    shape = found.shapes[0]
    turns = []
    for polygon in piece.polygons[::2]:
        arm = piece.vertices[polygon[2]] - piece.vertices[polygon[0]]
        turns.append((arm[0] * shape[polygon[2], 1] - arm[1] * shape[polygon[2], 0]) / (arm @ arm))
    assert np.array(turns[1:]) / turns[:-1] == pytest.approx(math.tan(math.pi / 4 - LEAN), rel=1e-9)


# ------------------------------------------------------------------------------------ the same panels, meshed finely

WIDTH, LENGTH, THICKNESS = 0.6e-3, 1.5e-3, 1e-3
MATERIAL = kg.Material(E=3.5e9, nu=1 / 3)


def _fine(piece: tilings.Tiling, edge: float) -> kg.Model:
    sheet = kg.Sheet(tilings.ligament_sheet(piece, WIDTH, LENGTH), thickness=THICKNESS, material=MATERIAL)
    return kg.Model.from_mesh(sheet.mesh(max_edge=edge), dim=2)


def _measured_joint(cell: tilings.Tiling, edge: float) -> float:
    """Stiffness of a meshed ligament between a square, held, and a rhombus, turned by a couple."""
    pair = cell.patch(1, 1)
    model = _fine(pair, edge)
    joint = pair.vertices[pair.joints[0]]
    centre = pair.vertices[pair.polygons[0]].mean(axis=0) - joint
    away = (model.positions()[:, :2] - joint) @ centre / (centre @ centre)
    model.add(kg.Fix([model.nodes[k] for k in np.flatnonzero(away > 0.9)]))
    tips = [pair.vertices[k] for k in pair.polygons[1] if k != pair.joints[0]]
    a, b = (node_at(model, tip) for tip in (tips[0], tips[2]))
    arm = np.array([b.x - a.x, b.y - a.y])
    across = np.array([-arm[1], arm[0]]) / np.linalg.norm(arm)
    model.add(kg.NodalLoad(b, across), kg.NodalLoad(a, -across))
    u = kg.LinearStatic(model).run().u[-1, :, :2]
    i, j = model.index([a, b])
    return float(arm @ arm / ((u[j] - u[i]) @ across))


def test_few_bars_for_each_panel_do_for_a_fine_mesh() -> None:
    """Transmitted displacements of a row within 10 % of meshed panels and ligaments (they agree within 2 %).

    The stiffness of the ligament comes from its mesh; E t b^3 / (12 l) is 15 % too stiff for one this stout.
    """
    cell = tilings.square_rhombus(LEAN, EXAMPLE.SIDE)
    piece = cell.patch(3, 1, keep=lambda a, b, panel: panel == 0 or a < 2)
    joint = _measured_joint(cell, edge=0.9e-3)
    beam = tilings.Ligament(MATERIAL.E, THICKNESS, WIDTH, LENGTH).stiffness
    assert 0.8 < joint / beam < 1.0
    row = cell.lattice[0]
    ends = cell.points[2], cell.points[1] + 2 * row
    coarse = piece.model(EA=MATERIAL.E * THICKNESS * EXAMPLE.SIDE / 2, stiffness=joint, springs="both")
    fine = _fine(piece, edge=1.2e-3)
    assert len(fine.nodes) > 30 * len(coarse.nodes)
    outputs = {}
    for name, base in (("coarse", coarse), ("fine", fine)):
        base.add(kg.Fix([node_at(base, a * row) for a in range(3)]))
        for state, (push, read), inward in (("A", ends, 1.0), ("B", ends[::-1], -1.0)):
            load = base.add(kg.NodalLoad(node_at(base, push), (6.0 * inward, 0)))
            result = kg.LoadControl(base).run()
            outputs[name, state] = inward * result.u[-1, base.index(node_at(base, read))[0], 0]
            base.remove(load)
    for state in "AB":
        assert outputs["coarse", state] == pytest.approx(outputs["fine", state], rel=0.1)
    difference = {name: outputs[name, "B"] - outputs[name, "A"] for name in ("coarse", "fine")}
    assert difference["fine"] > 0 and difference["coarse"] > 0
    assert shapely.area(tilings.ligament_sheet(piece, WIDTH, LENGTH)) > 0.8 * 5 * EXAMPLE.SIDE**2
