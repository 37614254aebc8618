"""A sheet that touches itself: the clamped elastica, two sheets pressed together, nothing that passes through."""

import numpy as np
import pytest
import shapely
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import kirigami as kg
from kirigami.post.crossing import crossings

pytest.importorskip("ipctk")

L, B, T = 0.1, 0.01, 0.1e-3
PET = kg.Material(3.5e9, 0.0)


def grid(columns: int, rows: int, length: float, width: float, height: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) and triangles of a rectangle."""
    x, y = np.linspace(0, length, columns + 1), np.linspace(0, width, rows + 1)
    nodes = np.array([(a, b, height) for a in x for b in y])
    triangles = []
    for i in range(columns):
        for j in range(rows):
            a, b = i * (rows + 1) + j, (i + 1) * (rows + 1) + j
            split = [(a, b, a + 1), (a + 1, b, b + 1)] if (i + j) % 2 else [(a, b, b + 1), (a, b + 1, a + 1)]
            triangles += split
    return nodes, np.array(triangles)


def stacked(gap: float, rows: int = 4) -> kg.TriMesh:
    """Two square sheets above each other, the upper one smaller and finer."""
    low, below = grid(rows, rows, 1.0, 1.0)
    high, above = grid(rows + 1, rows + 1, 0.8, 0.8, gap)
    high[:, :2] += 0.1
    return kg.TriMesh(np.concatenate([low, high]), np.concatenate([below, above + len(low)]))


def clamped_strip(rung: str, columns: int, *effects: kg.ModelObject) -> tuple[kg.Model, list[kg.Node]]:
    nodes, triangles = grid(columns, 1, L, B)
    m = kg.Model.from_mesh(kg.TriMesh(nodes, triangles), thickness=T, material=PET, stiffness=rung)
    left, right = m.select(boundary="left"), m.select(boundary="right")
    m.add(kg.Fix(left, clamp=True), kg.Fix(right, "yz", clamp=True), kg.Prescribe(right, x=-L), *effects)
    m.perturb(2 * T * np.sin(np.pi * nodes[:, 0] / L) ** 2)
    return m, right


def closed_form() -> tuple[float, float]:
    """Shortening, and force over Euler's, at which the clamped elastica touches itself.

    sin(theta / 2) = k sn(u) with u = 4 K s / L; its legs, at theta = 90 deg, reach the middle where
    2 E(am u) - u = 2 (2 E - K) with k sn(u) = 1 / sqrt 2.
    """

    def neck(m: float) -> float:
        amplitude = np.arcsin(np.sqrt(0.5 / m))
        return 2 * ellipeinc(amplitude, m) - ellipkinc(amplitude, m) - 2 * (2 * ellipe(m) - ellipk(m))

    m = brentq(neck, 0.52, 0.82)
    return 2 - 2 * ellipe(m) / ellipk(m), (4 * ellipk(m)) ** 2 / (4 * np.pi**2)


def neck_width(m: kg.Model, step: kg.Step) -> float:
    """Distance of the legs of the loop."""
    x = m.positions() + step.u
    half = len(x) // 2 - 1  # without the top of the loop
    return float(x[-half:, 0].min() - x[:half, 0].max())


def test_the_closed_form_of_the_elastica():
    shortening, force = closed_form()
    assert abs(shortening - 0.84865) < 1e-5 and abs(force - 1.8285) < 1e-4


@pytest.mark.long
def test_the_clamped_elastica_touches_itself_where_it_must():
    thin = 1e-5
    m, right = clamped_strip("shell", 60, kg.SelfContact(thickness=thin))
    targets = [0.83, 0.84, 0.845, 0.86]
    res = kg.DisplacementControl(m, to=0.88, targets=targets, corrector="newton").run()
    euler = 4 * np.pi**2 * PET.E * T**3 / 12 * B / L**2
    pressed = np.abs(res.force("self-contact")).max(axis=(1, 2)) > 0
    before, last = (int(np.argmin(np.abs(res.lam - lam))) for lam in targets[1:3])
    necks = [neck_width(m, res[step]) for step in (before, last)]
    touch = res.lam[last] + (thin - necks[1]) * (res.lam[last] - res.lam[before]) / (necks[1] - necks[0])
    shortening, force = closed_form()
    assert abs(touch / shortening - 1) < 2e-3
    pull = -res.reaction(right, "x") / euler
    slope = (pull[last] - pull[before]) / (res.lam[last] - res.lam[before])
    at_touch = pull[last] + slope * (touch - res.lam[last])
    assert abs(at_touch / force - 1) < 1e-2
    assert not pressed[res.lam < touch - 1e-3].any() and pressed[res.lam > touch + 1e-3].all()
    assert 0.7 * thin < neck_width(m, res[-1]) < 1.3 * thin
    assert not any(event.kind == "crossing" for event in res.events) and bool(res.stable.all())


@pytest.mark.parametrize("rung", kg.stiffness.RUNGS)
def test_two_sheets_pressed_together_balance(rung):
    mesh = stacked(0.03)
    m = kg.Model.from_mesh(mesh, thickness=0.02, material=PET, stiffness=rung)
    low, high = m.nodes[:25], m.nodes[25:]
    rim = [node for node in low if node.x in (0.0, 1.0) or node.y in (0.0, 1.0)]
    top = [node for node in high if abs(node.x - 0.5) < 0.41 and abs(node.y - 0.5) < 0.41]
    m.add(kg.Fix(rim), kg.Fix(high, "xy"), kg.Prescribe(top, z=-0.03), kg.SelfContact())
    res = kg.DisplacementControl(m, corrector="newton").run()
    force = res.force("self-contact")[-1]
    up, down = force[25:, 2].sum(), force[:25, 2].sum()
    assert up > 0
    assert np.abs(force.sum(axis=0)).max() < 1e-8 * up
    assert abs(up + down) < 1e-8 * up
    assert abs(res.reaction(rim, "z")[-1] - up) < 1e-7 * up
    assert abs(res.reaction(top, "z")[-1] + up) < 1e-7 * up
    assert abs(res.energy["self-contact"][-1]) > 0


UNTURNED, PUSH = np.eye(3), np.array([0.3, 0.1, -8.0])


def laid_on(rung: str, length: float = 1.0, axes: np.ndarray = UNTURNED, rows: int = 3, **grip: object) -> kg.Model:
    """A sheet on springs, most of which is a rigid grip, pressed aside of its middle on another one that is held."""
    mesh = stacked(0.03, rows)
    count = (rows + 1) ** 2
    placed, material = kg.TriMesh(length * mesh.nodes @ axes.T, mesh.triangles), kg.Material(PET.E / length**2, 0.0)
    m = kg.Model.from_mesh(placed, 0.02 * length, material, rung)
    low, high = m.nodes[:count], m.nodes[count:]
    inner = [node for node, place in zip(high, mesh.nodes[count:]) if np.abs(place[:2] - 0.5).max() < 0.35]
    near = [node for node, place in zip(low, mesh.nodes) if min(*place[:2], *(1 - place[:2])) < 0.1]
    m.add(kg.Fix(near), kg.Grip(inner, **{"move": (None,) * 3, "turn": (None,) * 3, **grip}))
    m.add(kg.Spring(high, 1.0 / length), kg.NodalLoad(inner[0], tuple(axes @ PUSH)))
    m.add(kg.SelfContact(stiffness=0.1 * PET.E / length**2))
    m.perturb(np.where(np.arange(len(m.nodes))[:, None] < count, 0.0, 1e-4 * length * axes[:, 2]))
    return m


@pytest.mark.parametrize("rung", ["plate", pytest.param("shell", marks=pytest.mark.long)])
def test_a_grip_beside_contact_bears_what_the_contact_does(rung):
    """A rigid body on a sheet: forces and moments of contact, load and springs are in balance."""
    m = laid_on(rung)
    res = kg.LoadControl(m, corrector="newton").run()
    place, force = m.positions() + res[-1].u, res.force("self-contact")[-1]
    up = force[16:, 2].sum()
    assert up > 4.0 and nothing_crosses(res)
    assert np.abs(force.sum(axis=0)).max() < 1e-8 * up
    load = np.zeros_like(force)
    load[res.node_index(next(item for item in m.objects if isinstance(item, kg.NodalLoad)).group)] = PUSH
    applied = (force + load - res[-1].u)[16:]
    assert np.abs(applied.sum(axis=0)).max() < 1e-7 * up
    assert np.abs(np.cross(place[16:], applied).sum(axis=0)).max() < 1e-7 * up


def test_the_tangent_beside_a_grip_is_that_of_its_forces():
    m = laid_on("facet", rows=4)
    u = np.zeros((len(m.nodes), 3))
    u[25:, 2] = -0.0098
    system = kg.System(m)
    rng = np.random.default_rng(4)
    q = system.unknowns(system.settled(u)) + 2e-4 * rng.normal(size=system.free)
    direction, h = rng.normal(size=system.free), 1e-8
    at = system.displacement(q, 0.5)
    assert np.abs(next(k for k in system.kernels if k.name == "self-contact").evaluate(
        system.configuration(at), 0.5, 1).gradient).max() > 0  # fmt: skip
    found = system.matrix(system.stiffness_blocks(at, 0.5)) @ direction
    sides = [system.imbalance(system.displacement(q + way * h * direction, 0.5), 0.5)[0] for way in (1, -1)]
    assert np.abs(found - (sides[0] - sides[1]) / (2 * h)).max() < 1e-6 * np.abs(found).max()


@pytest.mark.parametrize("change", ["units", "turned"])
def test_a_grip_beside_contact_is_the_same_in_other_units_and_turned(change):
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    length, axes = (1e3, UNTURNED) if change == "units" else (1.0, turn)

    def pressed(length: float, axes: np.ndarray) -> np.ndarray:
        move, spin = axes @ (0, 0, -0.015 * length), axes @ (0.02, 0.01, 0)
        m = laid_on("plate", length, axes, move=move, turn=spin)
        res = kg.DisplacementControl(m, corrector="newton").run()
        force = res.force("self-contact")[-1]
        held = np.array([res.reaction(m.nodes[:16], axis)[-1] for axis in "xyz"])
        assert np.abs(held + force[:16].sum(axis=0)).max() < 1e-7 * np.abs(force).max()  # what the grip presses with
        return force @ axes

    here = pressed(1.0, UNTURNED)
    assert np.abs(here).max() > 0
    assert np.abs(pressed(length, axes) - here).max() < 1e-6 * np.abs(here).max()


def test_contact_beside_a_periodic_cell_is_refused():
    """Its neighbours, which it would touch, are not there."""
    corners = grid(2, 2, 1.0, 1.0)
    m = kg.Model.from_mesh(kg.TriMesh(*corners), thickness=0.01, material=PET, stiffness="plate")
    cell = kg.PeriodicCell(m, [(1, 0), (0, 1)])
    m.add(kg.SelfContact())
    cell.impose((0.0, 0.0, 0.0))
    with pytest.raises(kg.ModelError, match="periodic cell, whose neighbours are not there"):
        kg.System(m)


def pressed_pair() -> kg.Model:
    m = kg.Model.from_mesh(stacked(0.03, 3), thickness=0.02, material=PET)
    low, high = m.nodes[:16], m.nodes[16:]
    m.add(kg.Fix([node for node in low if node.x in (0.0, 1.0)]), kg.Fix(high, "xy"))
    m.add(kg.Prescribe(high, z=-0.02), kg.SelfContact())
    return m


def test_files_and_checkpoints_carry_contact(tmp_path):
    whole = kg.DisplacementControl(pressed_pair(), corrector="newton").run()
    assert np.abs(whole.force("self-contact")[-1]).max() > 0
    whole.save(tmp_path / "pressed.npz")
    back = kg.load(tmp_path / "pressed.npz")
    assert np.array_equal(back.force("self-contact"), whole.force("self-contact"))
    (met,) = (event for event in back.events if event.kind == "contact")
    touches = np.abs(whole.force("self-contact")).max(axis=(1, 2)) > 0
    assert met.bracket == (whole.lam[met.step], whole.lam[met.step + 1]) and met.message in back.summary()
    assert not touches[: met.step + 1].any() and touches[met.step + 1 :].all()

    def stop(step: kg.Step) -> None:
        if step.lam > 0.5:
            raise KeyboardInterrupt

    file = tmp_path / "half.npz"
    with pytest.warns(kg.errors.KirigamiWarning, match="interrupted"):
        kg.DisplacementControl(pressed_pair(), corrector="newton").run(recorders=[stop], checkpoint=file)
    resumed = kg.DisplacementControl(pressed_pair(), corrector="newton").run(checkpoint=file)
    assert np.array_equal(resumed.lam, whole.lam) and np.array_equal(resumed.u, whole.u)
    assert [event.message for event in resumed.events if event.kind == "contact"] == [met.message]


def test_contact_is_the_same_in_other_units_and_turned():
    def pressed(length: float, turn: np.ndarray) -> np.ndarray:
        mesh = stacked(0.03, 3)
        nodes = length * mesh.nodes @ turn.T
        material = kg.Material(PET.E / length**2, 0.0)
        m = kg.Model.from_mesh(kg.TriMesh(nodes, mesh.triangles), thickness=0.02 * length, material=material)
        down = -0.012 * length * turn[:, 2]
        m.add(kg.Fix(m.nodes[:16]), kg.Prescribe(m.nodes[16:], x=down[0], y=down[1], z=down[2]), kg.SelfContact())
        m.perturb(np.where(np.arange(41)[:, None] < 16, 0.0, 1e-4 * length * turn[:, 2]))
        return kg.LoadControl(m).run().force("self-contact")[-1] @ turn

    here = pressed(1.0, np.eye(3))
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    assert np.abs(here).max() > 0
    for length, turned in ((1e3, np.eye(3)), (1.0, turn)):
        assert np.abs(pressed(length, turned) - here).max() < 1e-6 * np.abs(here).max()


def test_every_path_method_stops_at_contact_and_finds_the_same_force():
    """Weights on a free sheet lie on the one below: load, arc length and descents end in one equilibrium."""
    found = []
    for analysis in (
        lambda m: kg.LoadControl(m),
        lambda m: kg.ArcLength(m, step=0.05, stop=lambda step: step.lam > 1),
        lambda m: kg.DisplacementControl(m, control=(m.nodes[-13], "z"), to=-0.0112),
    ):
        m = kg.Model.from_mesh(stacked(0.03, 3), thickness=0.02, material=PET)
        low, high = m.nodes[:16], m.nodes[16:]
        m.add(kg.Fix(low), kg.Fix(high, "xy"), kg.Spring(high, (0, 0, 1.0)), kg.SelfContact())
        m.add(kg.NodalLoad(high, (0, 0, -5.0)))
        res = analysis(m).run()
        up = res.force("self-contact")[-1][16:, 2].sum()
        springs = 1.0 * res[-1].u[16:, 2].sum()
        assert up > 0 and abs(up - 5.0 * res.lam[-1] * len(high) - springs) < 1e-6 * up
        assert nothing_crosses(res)
        found.append(res)
    assert found[0].lam[-1] == 1.0


def test_a_sheet_thrown_on_another_bounces_and_keeps_its_energy():
    m = kg.Model.from_mesh(stacked(0.03, 3), thickness=0.02, material=kg.Material(1e6, 0.0, density=1000.0))
    low, high = m.nodes[:16], m.nodes[16:]
    m.add(kg.Fix(low), kg.Fix(high, "xy"), kg.SelfContact(stiffness=1e5))
    velocity = np.zeros((len(m.nodes), 3))
    velocity[16:, 2] = -1.0
    res = kg.Dynamics(m, end=0.03, step=5e-4, velocity=velocity).run()
    moving = np.array([step.velocity[16:, 2].mean() for step in res.steps])
    assert moving[0] < 0 < moving[-1] and nothing_crosses(res)
    (met,) = (event for event in res.events if event.kind == "contact")
    assert "touch between times" in met.message and met.message.count("until") == 1
    assert res.stats["energy_drift"] < 0.02


def test_gradient_and_tangent_are_those_of_the_potential():
    mesh = stacked(0.019)
    m = kg.Model.from_mesh(mesh, thickness=0.01, material=PET, stiffness="facet")
    m.add(kg.SelfContact(thickness=0.015, layer=0.014))
    system = kg.System(m)
    rng = np.random.default_rng(3)
    u = np.zeros((len(m.nodes), 3))
    u[25:, 2] = -0.011
    u += 5e-4 * rng.normal(size=u.shape)
    kernel = next(kernel for kernel in system.kernels if kernel.name == "self-contact")
    direction = rng.normal(size=u.shape)
    x, h = system.rest + u, 1e-8
    energies = [kernel.evaluate(x + way * h * direction, 1.0, 0).energy.sum() for way in (1, -1)]
    gradients = [kernel.evaluate(x + way * h * direction, 1.0, 1).gradient[:, 0] for way in (1, -1)]
    slope = (kernel.evaluate(x, 1.0, 1).gradient[:, 0] * direction).sum()
    assert abs((energies[0] - energies[1]) / (2 * h) / slope - 1) < 1e-6
    product = (kernel.coupling(x) @ direction.ravel()).reshape(u.shape)
    by_difference = (gradients[0] - gradients[1]) / (2 * h)
    assert np.abs(product - by_difference).max() < 1e-5 * np.abs(product).max()
    whole = system.stiffness(u, constrained=False)
    assert abs(whole - whole.T).max() < 1e-9 * abs(whole).max()
    blocks = system.stiffness_blocks(u, 0.0)
    doubled = 0.5 * blocks + blocks / 2
    assert np.allclose(system.multiply(doubled, direction), system.multiply(blocks, direction), rtol=1e-12)


def test_lips_of_a_slit_bear_nothing_at_rest_and_hold_where_they_were_cut():
    t = 0.01
    slit = shapely.LineString([(0.2, 0.5), (0.8, 0.5)])
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1), slit, thickness=t, material=PET)
    m = kg.Model.from_mesh(sheet.mesh(nodes=150), stiffness="facet")
    m.add(kg.SelfContact())
    system = kg.System(m)
    kernel = next(kernel for kernel in system.kernels if kernel.name == "self-contact")
    assert kernel.evaluate(system.rest, 1.0, 0).energy.sum() == 0.0
    lips = np.flatnonzero(np.abs(system.rest[:, 1] - 0.5) < 1e-9)
    lower = np.unique(m.mesh.triangles[(system.rest[m.mesh.triangles, 1] < 0.4999).any(axis=1)])
    low = np.intersect1d(lips, lower)
    low = low[(system.rest[low, 0] > 0.3) & (system.rest[low, 0] < 0.7)]
    assert len(low) > 2
    opened, closed = np.array(system.rest), np.array(system.rest)
    opened[low, 1] -= 0.5 * t
    closed[low, 1] += 0.9 * t
    assert kernel.admissible(system.rest, opened) == 1.0 == kernel.admissible(opened, system.rest)
    share = kernel.admissible(system.rest, closed)
    assert 0.2 < share < 1.0  # they meet, and may go into the layer only
    pressed = system.rest + 0.9 * share * (closed - system.rest)
    assert kernel.force(kernel.deformation(pressed))[low, 1].sum() < 0.0


def test_lips_that_were_apart_are_in_contact_when_they_meet_again():
    """Near the tips pairs are closer than the thickness at rest: history tells which have been apart since."""
    t = 0.05  # thick against the facets, so that lips cannot be drawn in that far
    slit = shapely.LineString([(0.2, 0.5), (0.8, 0.5)])
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1), slit, thickness=t, material=PET)
    m = kg.Model.from_mesh(sheet.mesh(nodes=600), stiffness="facet")
    m.add(kg.SelfContact())
    system = kg.System(m)
    kernel = next(kernel for kernel in system.kernels if kernel.name == "self-contact")
    assert not kernel.history.any()
    opened = np.array(system.rest)
    opened[opened[:, 1] < 0.4999, 1] -= 2 * t
    kernel.commit(opened)
    stored = kernel.history
    assert stored.any() and not stored.all()
    share = kernel.admissible(opened, system.rest)
    assert share < 1.0
    kernel.history = None
    assert kernel.admissible(opened, system.rest) >= share
    kernel.history = stored
    assert kernel.admissible(opened, system.rest) == share


def test_a_start_that_crosses_itself_is_refused_with_the_places():
    nodes = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.2, 0.2, -1), (0.2, 0.2, 1), (3, 3, 0)], dtype=float)
    mesh = kg.TriMesh(nodes, np.array([(0, 1, 2), (3, 4, 5)]))
    m = kg.Model.from_mesh(mesh, thickness=0.01, material=PET)
    m.add(kg.SelfContact())
    with pytest.raises(kg.errors.ModelError, match=r"crosses itself .* \(0.2, 0.2, 0\)|crosses itself"):
        kg.System(m)
    mesh = stacked(0.05)
    m = kg.Model.from_mesh(mesh, thickness=0.01, material=PET)
    m.add(kg.SelfContact(), kg.Fix(m.nodes[:30]), kg.Prescribe(m.nodes[31:], x=0, y=0, z=-0.01))
    u = np.zeros((len(m.nodes), 3))
    u[30, 2] = -0.2
    with pytest.raises(kg.errors.ModelError, match="crosses itself"):
        kg.LoadControl(m, start=kg.Step.at(m, 0.0, u)).run()


def test_a_thickness_larger_than_the_gap_and_what_has_no_sheet_are_refused():
    m = kg.Model.from_mesh(stacked(0.03), thickness=0.04, material=PET)
    m.add(kg.SelfContact())
    with pytest.raises(kg.errors.ModelError, match="larger than the gap at rest, 0.03"):
        kg.System(m)
    bars = kg.Model()
    a, b = bars.add(kg.Node(0, 0), kg.Node(1, 0))
    bars.add(kg.Bar(a, b, EA=1.0), kg.SelfContact(thickness=0.1))
    with pytest.raises(kg.errors.ModelError, match="from_mesh"):
        kg.System(bars)


def test_where_the_library_is_missing_it_is_said_how_to_get_it(monkeypatch):
    monkeypatch.setattr("kirigami.post.crossing.can_search", lambda: False)
    m = kg.Model.from_mesh(stacked(0.03), thickness=0.01, material=PET)
    m.add(kg.SelfContact())
    with pytest.raises(kg.errors.AnalysisError, match=r"pip install 'kirigami-mechanics\[contact\]'"):
        kg.System(m)


def crumpled(seed: int, amount: float = 0.45, nodes: int = 100) -> tuple[kg.Results, kg.Model]:
    """A slit sheet pushed together and twisted at random."""
    rng = np.random.default_rng(seed)
    slits = list(kg.cuts.parallel_slits(columns=1, rows=2, width=1.0, height=1.0, length=0.7, margin=0.1))
    sheet = kg.Sheet(shapely.box(0, 0, 1, 1), slits, thickness=0.01, material=PET)
    m = kg.Model.from_mesh(sheet.mesh(nodes=nodes), stiffness="plate")
    bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    x, y, z = amount * rng.uniform(-1, 1, 3)
    m.add(kg.Fix(bottom, clamp=True), kg.Prescribe(top, x=x, y=-amount - abs(y), z=z), kg.SelfContact())
    m.perturb(0.02 * rng.normal(size=len(m.nodes)) * (0.5 - np.abs(m.positions()[:, 1] - 0.5)))
    return kg.DisplacementControl(m, corrector="newton").run(on_failure="return"), m


def nothing_crosses(res: kg.Results) -> bool:
    """Whether the surface that is held never passes through itself in a stored step."""
    kernel = next(kernel for kernel in res.kernels if kernel.name == "self-contact")
    assert not any(event.kind == "crossing" for event in res.events)
    places = [kernel.held_at(res.rest + step.u) for step in res.steps]
    return not any(len(crossings(x, kernel.edges, kernel.triangles)) for x in places)


@pytest.mark.filterwarnings("ignore::kirigami.errors.KirigamiWarning")
@pytest.mark.parametrize("seed", range(2))
def test_nothing_crosses_in_random_sheets(seed):
    res, _ = crumpled(seed, nodes=60)
    assert nothing_crosses(res) and any(event.kind == "contact" for event in res.events)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::kirigami.errors.KirigamiWarning")
@pytest.mark.parametrize("seed", range(2, 14))
def test_nothing_crosses_in_more_random_sheets(seed):
    res, _ = crumpled(seed, 0.6)
    assert nothing_crosses(res) and any(event.kind == "contact" for event in res.events)
