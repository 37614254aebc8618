"""Contact with rigid surfaces: balance, no penetration, and shapes that beam theory knows in closed form."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from scipy.integrate import trapezoid

import kirigami as kg
from kirigami.effects.contact import Contact, ContactKernel, Cylinder, Plane, Sphere
from kirigami.results.contact import gaps, normal_forces, penetration

STIFFNESS, LAYER = 40.0, 0.05
SURFACES = {
    "plane": Plane((0, 0, -1), normal=(0.3, -0.2, 1)),
    "cylinder": Cylinder((0, 0, -1.5), axis=(0.2, 1, -0.1), radius=1.0),
    "sphere": Sphere((0.1, 0.2, -1.4), radius=1.0),
}


def _two_nodes(surface: Any, **options: Any) -> tuple[kg.Model, Contact]:
    model = kg.Model()
    a, b = model.add(kg.Node(0, 0, 0), kg.Node(0.5, 0.1, 0.2))
    model.add(kg.Bar(a, b, 1.0), kg.Fix([a, b]))
    return model, model.add(Contact([a, b], surface, **options))


def _kernel(model: kg.Model) -> ContactKernel:
    return next(kernel for kernel in kg.System(model).kernels if isinstance(kernel, ContactKernel))


# ---------------------------------------------------------------------------------------------------- the law


@pytest.mark.parametrize("depth", [-0.2, 0.4 * LAYER, 0.9 * LAYER, 3 * LAYER, 8 * LAYER])
@pytest.mark.parametrize("name", SURFACES)
def test_energy_force_and_stiffness_belong_together(name: str, depth: float) -> None:
    kernel = _kernel(_two_nodes(SURFACES[name], stiffness=STIFFNESS, layer=LAYER)[0])
    x = kernel.rest.copy()
    for _ in range(3):  # put both nodes at the given depth below the start of the layer
        gap, direction, _ = kernel.distance(kernel.places_of(x))
        x = x + (LAYER - depth - gap)[:, None] * direction
    errors = kg.check_kernel(kernel, x, step=1e-5)
    assert max(errors["gradient"], errors["hessian"]) < 1e-6
    assert errors["symmetry"] < 1e-12


def test_law_in_numbers() -> None:
    """Nothing above the layer; k d^2 / (2 w), then k (d - w / 2) below its top; energy is the integral of the force."""
    kernel = _kernel(_two_nodes(Plane((0, 0, -1)), stiffness=STIFFNESS, layer=LAYER)[0])
    depth = np.linspace(-LAYER, 4 * LAYER, 2001)
    energies, forces, _ = np.array([kernel._law(np.full(2, LAYER - d)) for d in depth])[:, :, 0].T
    inside = np.where(depth < LAYER, depth**2 / (2 * LAYER), depth - LAYER / 2)
    assert forces == pytest.approx(STIFFNESS * np.where(depth > 0, inside, 0), abs=1e-12)
    assert energies[-1] == pytest.approx(trapezoid(forces, depth), rel=1e-6)


@pytest.mark.parametrize("clearance", [0.0, 0.4 * LAYER])
def test_rest_state_on_the_surface_bears_no_force(clearance: float) -> None:
    model, ground = _two_nodes(Plane((0, 0, -0.1 - clearance)), offset=0.1, stiffness=STIFFNESS, layer=LAYER)
    assert _kernel(model).evaluate(_kernel(model).rest, 1.0, 1).gradient.any() == np.False_
    res = kg.LinearStatic(_pushed(model)).run()
    assert gaps(res, ground)[0] == pytest.approx([clearance, clearance + 0.2])


def _pushed(model: kg.Model) -> kg.Model:
    model.remove(*model.constraints)
    model.add(kg.Fix(model.nodes), kg.NodalLoad(model.nodes, (0, 0, -1)))
    return model


def test_default_stiffness_and_layer_come_from_the_bars() -> None:
    kernel = _kernel(_two_nodes(Plane((0, 0, -1)))[0])
    length = np.sqrt(0.25 + 0.01 + 0.04)
    assert kernel.stiffness == pytest.approx(100 / length)
    assert kernel.layer == pytest.approx(1e-3 * length)


# ------------------------------------------------------------------------------------------- rods on a plane


def test_pressed_rod_balances_and_stays_within_the_stated_bound() -> None:
    """A rod is driven 0.02 into a wall, drawn back past it, and driven in again."""
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, EA=10.0, strain="engineering"), kg.Fix([a, b], "y"), kg.Prescribe(a, x=0.05))
    wall = m.add(Contact(b, Plane((1.03, 0), (-1, 0)), stiffness=1000.0, layer=1e-3))
    into = kg.DisplacementControl(m, tol=1e-11).run()
    back = kg.DisplacementControl(m, to=0.2, start=into[-1], tol=1e-11).run()
    again = kg.DisplacementControl(m, start=back[-1], tol=1e-11).run()
    for res in (into, back, again):
        force = normal_forces(res, wall)[:, 0]
        assert res.reaction(a, "x") == pytest.approx(force, abs=1e-7 * force.max())
        assert (penetration(res) <= np.maximum(force.max() / 1000 + 1e-3 / 2 - 1e-3, 0)).all()
        assert (force[gaps(res)[:, 0] > 1e-3] == 0).all()
    assert back.energy["contact"][-1] == 0 and back.reaction(a, "x")[-1] == pytest.approx(0, abs=1e-12)
    depth = 0.05 - 0.03
    assert normal_forces(again)[-1, 0] == pytest.approx(10 * depth, rel=1e-3 / depth)
    assert normal_forces(again)[-1, 0] == pytest.approx(normal_forces(into)[-1, 0], rel=1e-9)


def _heavy_chain(links: int, weight: float) -> tuple[kg.Model, tuple[kg.Node, ...], Contact]:
    """Unit length on the ground, EI = 1, with its weight as a constant load."""
    length = 1 / links
    m = kg.Model(dim=2)
    nodes = m.add(*(kg.Node(length * k, 0.0) for k in range(links + 1)))
    m.add(*(kg.Bar(a, b, 1e4) for a, b in pairwise(nodes)))
    m.add(*(kg.TorsionSpring3(a, b, c, 1 / length) for a, b, c in zip(nodes, nodes[1:], nodes[2:])))
    m.add(kg.NodalLoad(nodes[1:-1], (0, -weight * length), constant=True))
    m.add(kg.NodalLoad([nodes[0], nodes[-1]], (0, -weight * length / 2), constant=True), kg.Fix(nodes[0]))
    return m, nodes, m.add(Contact(nodes, Plane((0, 0), (0, 1)), layer=1e-6))


def test_lifting_a_heavy_strip_off_the_ground() -> None:
    """Lifted at one end by h, a strip of weight q per length comes off over a = (24 EI h / q)^(1/4); lifting takes
    q a / 2, and as much presses on the ground where it touches down, beside q under what lies flat."""
    weight, height = 10.0, 1e-2
    m, nodes, ground = _heavy_chain(100, weight)
    m.add(kg.Prescribe(nodes[-1], y=height))
    targets = [0.1, 0.3]
    up = kg.DisplacementControl(m, targets=targets).run()
    for step in (np.flatnonzero(np.isclose(up.lam, 0.1))[0], np.flatnonzero(np.isclose(up.lam, 0.3))[0], -1):
        loose = (24 * up.lam[step] * height / weight) ** 0.25
        assert up.reaction(nodes[-1], "y")[step] == pytest.approx(weight * loose / 2, rel=0.03)
        forces = normal_forces(up)[step]
        lying, off = int(100 * (1 - loose)) - 6, int(100 * (1 - loose)) + 4
        assert forces[8:lying] == pytest.approx(np.full(lying - 8, weight / 100), rel=0.02)
        assert forces[lying:off].sum() > 0.9 * weight * loose / 2 and not forces[off:].any()
        assert forces.sum() + up.reaction([nodes[0], nodes[-1]], "y")[step] == pytest.approx(weight, rel=1e-6)
    assert penetration(up).max() <= weight * 0.01 * 2 / (100 * 1e6) + 1e-6  # touch-down carries more than one weight
    down = kg.DisplacementControl(m, to=0.0, targets=targets, start=up[-1]).run()
    assert down.lam[-1] == 0
    for lam in targets:
        there, back = (res.reaction(nodes[-1], "y")[np.isclose(res.lam, lam)][0] for res in (up, down))
        assert back == pytest.approx(there, rel=1e-6)
    held = down.reaction([nodes[0], nodes[-1]], "y")[-1]
    assert normal_forces(down)[-1].sum() + held == pytest.approx(weight, rel=1e-6)


def test_circle_in_the_plane_carries_a_string_over_it() -> None:
    """A string (no bending) hangs over a frictionless circle: the tension is the same all the way round."""
    radius, links = 1.0, 30
    m = kg.Model(dim=2)
    nodes = m.add(*(kg.Node(1.0001 * np.sin(s), 1.0001 * np.cos(s)) for s in np.linspace(0, np.pi / 2, links + 1)))
    bars = m.add(*(kg.Bar(a, b, 1e3) for a, b in pairwise(nodes)))
    m.add(*(kg.TorsionSpring3(a, b, c, 1e-3) for a, b, c in zip(nodes, nodes[1:], nodes[2:])))
    m.add(kg.Prescribe(nodes[-1], y=-5e-3), kg.Fix(nodes[0]), kg.Fix(nodes[1], "y"))
    m.add(Contact(nodes[2:], Sphere((0, 0), radius)))
    res = kg.DisplacementControl(m).run()
    pull = -float(res.reaction(nodes[-1], "y")[-1])
    assert pull == pytest.approx(1e3 * 5e-3 / (np.pi / 2), rel=0.05)
    assert res.bar_force[-1] == pytest.approx(np.full(len(bars), pull), rel=5e-3)
    per_length = normal_forces(res)[-1][2:-1] / (np.pi / 2 * radius / links)
    assert per_length == pytest.approx(np.full(links - 4, pull / radius), rel=5e-3)
    assert penetration(res).max() < 1e-5


# ------------------------------------------------------------------------------- a sheet bent round a cylinder


def _strip(columns: int, rows: int, edge: float) -> kg.TriMesh:
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    right, up = corner + 1, corner + columns + 1
    facets = np.concatenate([np.column_stack([corner, right, up + 1]), np.column_stack([corner, up + 1, up])])
    return kg.TriMesh(edge * np.column_stack([x.ravel(), y.ravel()]), facets)


def test_sheet_bent_round_a_cylinder() -> None:
    """Clamped on top of a cylinder and pulled down: curvature 1 / (R + t / 2) where it lies on, the elastica beyond.

    Where the sheet leaves the cylinder, B / (2 (R + t / 2)^2) = P (sin(end slope) - sin(slope there)), the first
    integral of the elastica, and its moment is that of the force, P times the arm.
    """
    radius, thickness, edge, columns, rows = 1.0, 0.02, 0.07, 32, 2
    material = kg.Material(E=12 * (1 - 0.3**2) / thickness**3, nu=0.3)  # B = 1 per width
    mesh = _strip(columns, rows, edge)
    m = kg.Model.from_mesh(mesh, thickness, material)
    width, pull = rows * edge, 4.0
    clamped, tip = m.select(box=(0, 0, 0, width)), m.select(box=(columns * edge, 0, columns * edge, width))
    m.add(kg.Fix(clamped, "xz", clamp=True), kg.Fix(m.nodes, "y"))
    share = np.array([1.0, 2.0, 1.0]) / 4
    m.add(*(kg.NodalLoad(node, (0, 0, -pull * width * part)) for node, part in zip(tip, share)))
    roll = Cylinder((0, 0, -radius - thickness / 2 - 1e-4), axis=(0, 1, 0), radius=radius)
    drum = m.add(Contact(m.nodes, roll, offset=thickness / 2))
    res = kg.LoadControl(m).run()
    outside = radius + thickness / 2

    gap = gaps(res, drum)[-1]
    assert penetration(res).max() < 1e-4 * thickness
    forces = normal_forces(res, drum)[-1].reshape(rows + 1, -1).sum(axis=0)
    assert (forces[gap.reshape(rows + 1, -1).min(axis=0) > 1e-3] == 0).all()

    x, z = res.position()[-1][: columns + 1, [0, 2]].T
    slope = -np.arctan2(np.diff(z), np.diff(x))  # of the columns, downwards
    curvature = np.diff(slope) / edge
    leaves = int(np.argmax(forces))  # where it leaves, the drum pushes once more
    assert leaves > 15 and forces[leaves] > 5 * np.median(forces[3 : leaves - 1]) > 0
    assert curvature[3 : leaves - 3] == pytest.approx(np.full(leaves - 6, 1 / outside), rel=1e-3)
    # One column either way is how well the point of leaving is known.
    there = (slope[1:] + slope[:-1])[[leaves - 2, leaves]] / 2
    below, above = sorted(pull * (np.sin(slope[-1]) - np.sin(there)))
    assert below < 1 / (2 * outside**2) < above
    below, above = sorted(pull * (x[-1] - x[[leaves - 1, leaves + 1]]))
    assert below < 1 / outside < above
    # Balance: the load, the clamp's shear and the drum.
    total = res.reaction(clamped)[-1]
    _, direction = _kernel(m).normals(res.position()[-1], 1.0)
    total = total + (normal_forces(res)[-1][:, None] * direction).sum(axis=0)
    assert total[[0, 2]] == pytest.approx([0, pull * width], abs=1e-6 * pull * width)


def test_sheet_draped_over_a_ball_and_lifted_off_again() -> None:
    """Contact closes node by node and opens again; what the ball pushes, the edges hold; nothing is left behind."""
    m = kg.Model.from_mesh(_strip(8, 8, 1 / 8), 0.005, kg.Material(E=1e6, nu=0.3))
    x, y, _ = m.positions().T
    m.perturb(1e-4 * np.sin(np.pi * x) * np.sin(np.pi * y))
    edge = m.select(boundary="outer")
    m.add(kg.Fix(edge, "xy", clamp=True), kg.Prescribe(edge, z=-0.15))
    m.add(Contact(m.nodes, Sphere((0.5, 0.5, -0.31), 0.3), offset=0.0025))
    down = kg.DisplacementControl(m).run()
    touching = (normal_forces(down) > 0).sum(axis=1)
    assert touching[0] == 0 and touching[-1] > 3
    direction = _kernel(m).normals(down.position()[-1], 1.0)[1]
    upwards = (normal_forces(down)[-1] * direction[:, 2]).sum()
    assert down.reaction(edge, "z")[-1] == pytest.approx(-upwards, rel=1e-5)
    kernel = _kernel(m)
    bound = (normal_forces(down) / kernel.stiffness + kernel.layer / 2 - kernel.start).clip(0)
    assert (-gaps(down) <= bound + 1e-12).all() and penetration(down).max() < 0.01 * 0.005
    up = kg.DisplacementControl(m, to=0.0, start=down[-1]).run()
    assert not normal_forces(up)[-1].any() and np.abs(up.u[-1]).max() < 1e-9


# ----------------------------------------------------------------------------------------- off, saved, refused


def test_nothing_changes_while_the_contact_is_open() -> None:
    results = []
    for touching in (False, True):
        m, nodes, ground = _heavy_chain(8, 0.5)
        m.add(kg.Fix(nodes[1], "y"))
        m.remove(ground)
        if touching:
            m.add(Contact(nodes, Plane((0, -5), (0, 1))))
        m.add(kg.Prescribe(nodes[-1], y=0.1))
        results.append(kg.DisplacementControl(m).run())
    assert np.abs(results[0].u[-1] - results[1].u[-1]).max() < 1e-12
    assert not normal_forces(results[1]).any() and not results[1].energy["contact"].any()


def test_contact_costs_nothing_to_a_model_without_it() -> None:
    code = (
        "import sys, kirigami as kg; m = kg.Model(dim=2); a, b = m.add(kg.Node(0, 0), kg.Node(1, 0));"
        "m.add(kg.Bar(a, b, 1.0), kg.Fix(a), kg.Fix(b, 'y'), kg.NodalLoad(b, (1, 0))); res = kg.LoadControl(m).run();"
        "sys.exit('kirigami.effects.contact' in sys.modules or 'contact' in res.energy)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_survives_saving(tmp_path: Path) -> None:
    m, nodes, ground = _heavy_chain(10, 1.0)
    m.add(kg.Prescribe(nodes[-1], y=0.01))
    res = kg.DisplacementControl(m).run()
    loaded = kg.load(res.save(tmp_path / "contact.npz"))
    assert normal_forces(loaded) == pytest.approx(normal_forces(res, ground), rel=1e-12)
    with pytest.raises(kg.ModelError, match="loaded from a file"):
        gaps(loaded, ground)


def test_two_contacts_report_apart() -> None:
    model, first = _two_nodes(Plane((0, 0, -1)))
    second = model.add(Contact(model.nodes[1], Sphere((0, 0, -3), 1.0)))
    res = kg.LinearStatic(_pushed(model)).run()
    assert gaps(res, first)[0] == pytest.approx([1.0, 1.2])
    assert gaps(res, second)[0] == pytest.approx([np.sqrt(0.25 + 0.01 + 3.2**2) - 1])
    assert gaps(res).shape == (len(res), 3)


def test_what_cannot_be_is_refused() -> None:
    node = kg.Node(0, 0)
    for make, words in (
        (lambda: Plane((0, 0, 0), (0, 0, 0)), "normal must not be zero"),
        (lambda: Plane((0, np.nan, 0)), "finite"),
        (lambda: Cylinder((0, 0, 0), (0, 0, 0), 1), "axis must not be zero"),
        (lambda: Sphere((0, 0, 0), -1), "radius must be positive"),
        (lambda: Contact([], Plane()), "empty"),
        (lambda: Contact(node, "floor"), "must be a Plane or a Cylinder or a Sphere"),
        (lambda: Contact(node, Plane(), offset=-1), "must not be negative"),
        (lambda: Contact(node, Plane(), stiffness=0), "positive"),
        (lambda: Contact(node, Plane(), layer=np.inf), "finite"),
    ):
        with pytest.raises(kg.ModelError, match=words):
            make()
    with pytest.raises(kg.ModelError, match=r"2 nodes of Contact inside .* node 0 .* by 0.5"):
        kg.System(_two_nodes(Plane((0, 0, 0.5)))[0])
    flat = kg.Model(dim=2)
    a, b, loose = flat.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    flat.add(kg.Bar(a, b, 1.0), kg.Fix([a, b, loose]))
    wrong = flat.add(Contact(a, Plane((0, 0, -1))))
    with pytest.raises(kg.ModelError, match="no line or circle in the plane"):
        kg.System(flat)
    flat.remove(wrong)
    flat.add(Contact(loose, Plane((0, -1), (0, 1))))
    with pytest.raises(kg.ModelError, match="no element gives node 2"):
        kg.System(flat)
    with pytest.raises(kg.ModelError, match="no Contact"):
        gaps(kg.LinearStatic(_without_contact()).run())


def _without_contact() -> kg.Model:
    m = kg.Model(dim=2)
    a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    m.add(kg.Bar(a, b, 1.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    return m


# ------------------------------------------------------------------------------------------- defaults on every rung


def _pressed_sheet(rung: str, unit: float = 1.0) -> kg.Model:
    """A sheet clamped along one side and pressed onto a ball by the other; `unit` is the metre in units of length."""
    material = kg.Material(E=1e9 / unit**2)
    sheet = kg.Sheet(shapely.box(0, 0, 0.1 * unit, 0.1 * unit), thickness=1e-3 * unit, material=material)
    mesh = sheet.mesh(0.03 * unit)
    m = kg.Model.from_mesh(mesh, stiffness=rung)
    m.add(kg.Fix(m.select(boundary="bottom"), clamp=True), kg.Prescribe(m.select(boundary="top"), z=-0.02 * unit))
    inside = m.select(where=lambda x, y, z: (y > 0.01 * unit) & (y < 0.09 * unit))
    m.add(kg.Contact(inside, kg.Sphere((0.05 * unit, 0.06 * unit, -0.045 * unit), radius=0.04 * unit)))
    return m


@pytest.mark.parametrize("rung", kg.stiffness.RUNGS)
def test_defaults_serve_every_rung(rung: str) -> None:
    """What the ball carries the supports do not, and no node is deeper inside than the module says."""
    m = _pressed_sheet(rung)
    (contact,) = m.effects
    res = kg.DisplacementControl(m, step=0.5).run()
    index = res.node_index(contact.group)
    ball = np.array([0.05, 0.06, -0.045])
    outward = res.position(index)[-1] - ball
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    force = (normal_forces(res, contact)[-1][:, None] * outward).sum(axis=0)
    held = res.reaction([*m.select(boundary="bottom"), *m.select(boundary="top")])[-1]
    assert force[2] > 0
    np.testing.assert_allclose(force + held, 0, atol=1e-5 * force[2])
    kernel = next(kernel for kernel in res.kernels if kernel.name == "contact")
    assert penetration(res).max() <= np.maximum(normal_forces(res) / kernel.stiffness - kernel.layer / 2, 0).max()
    assert penetration(res).max() < 1e-4 * 0.03  # of an edge


@pytest.mark.parametrize("rung", ["plate", "facet", "shell"])
def test_a_shelf_sags_onto_a_table_with_no_setting_changed(rung: str) -> None:
    """A load alone brings a free end into touch, two nodes at once; what presses and what the clamp bears is it."""
    length, width, thickness = 0.1, 0.01, 0.2e-3
    material = kg.Material(E=3.5e9, nu=0.0, density=1390.0)
    sheet = kg.Sheet(shapely.box(0, 0, length, width), thickness=thickness, material=material)
    m = kg.Model.from_mesh(sheet.mesh(0.01), stiffness=rung)
    clamped = m.select(boundary="left")
    free = [node for node in m.nodes if all(node is not held for held in clamped)]
    m.add(kg.Fix(clamped, clamp=True), kg.Gravity((0, 0, -98.1)))
    m.add(Contact(free, Plane((0, 0, -5e-3), normal=(0, 0, 1))))
    res = kg.LoadControl(m).run()
    pressing = normal_forces(res)[-1].sum()
    weight = 98.1 * 1390.0 * thickness * length * width
    assert res[-1].lam == 1 and pressing > 0.1 * weight
    assert pressing + res.reaction(clamped, "z")[-1] == pytest.approx(weight, rel=1e-5)
    assert penetration(res).max() < 0.01 * thickness


@pytest.mark.parametrize("rung", kg.stiffness.RUNGS)
def test_defaults_do_not_know_the_unit_of_length(rung: str) -> None:
    metres, millimetres = (
        next(k for k in kg.System(_pressed_sheet(rung, unit)).kernels if k.name == "contact") for unit in (1.0, 1e3)
    )
    np.testing.assert_allclose(millimetres.stiffness, metres.stiffness / 1e3, rtol=1e-9)
    np.testing.assert_allclose(millimetres.layer, metres.layer * 1e3, rtol=1e-9)


def test_no_element_no_default() -> None:
    m = kg.Model()
    a, b, c = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(2, 0))
    m.add(kg.Bar(a, b, 10.0), kg.Fix([a, b, c]), kg.Contact(c, Plane((0, 0, -1))))
    with pytest.raises(kg.ModelError, match="give stiffness="):
        kg.System(m)
