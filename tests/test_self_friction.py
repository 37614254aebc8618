"""Friction of a sheet with itself and with obstacles: Coulomb's law, balances, invariances, files."""

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_self_contact import PET, grid

import kirigami as kg
from kirigami.effects.self_friction import LIMIT

pytest.importorskip("ipctk")
pytestmark = pytest.mark.filterwarnings("ignore:the mesh is biased")

MU, PRESS, THICK, WIDTH = 0.3, 6000.0, 0.018, 0.008
FAR = 6 * WIDTH
SOFT = 1e-5 * PRESS  # springs that hold the small sheet before it is pressed
TURN = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))[0]
TURN *= np.linalg.det(TURN)


def pressed(
    mu: float = MU, floor: bool = False, turn: np.ndarray | None = None, length: float = 1.0
) -> tuple[kg.Model, list[kg.Node], kg.Step]:
    """A small sheet pressed by weights on a large one that is held, or on one large facet of an obstacle; its sides are
    let go. Returns the model, the nodes of the small sheet and the step to go on from."""
    turn = np.eye(3) if turn is None else turn
    high, above = grid(3, 3, 0.5, 0.5, 0.019)
    high[:, :2] += 0.231
    ground, facets = (np.array([(-1, -1, 0), (4, -1, 0), (-1, 4, 0.0)]), np.array([(0, 1, 2)]))
    if not floor:
        ground, facets = grid(4, 4, 1.0, 1.0)
    nodes, below = (high, above) if floor else (np.concatenate([ground, high]), len(ground) + above)
    place = lambda x: length * x @ turn.T  # noqa: E731
    mesh = kg.TriMesh(place(nodes), below if floor else np.concatenate([facets, below]))
    material = kg.Material(PET.E / length**2, 0.0)
    m = kg.Model.from_mesh(mesh, thickness=0.02 * length, material=material, stiffness="facet")
    obstacles = [kg.TriMesh(place(ground), facets)] if floor else []
    size = {"thickness": THICK * length, "layer": WIDTH * length}
    top = m.nodes[-16:]
    if not floor:
        m.add(kg.Fix(m.nodes[:25]))
    down, soft = -turn[:, 2], SOFT / length
    m.add(kg.SelfContact(**size, friction=mu, obstacles=obstacles), kg.Spring(top, soft))
    m.add(kg.NodalLoad(top, PRESS / len(top) * down))
    sides = m.add(kg.Fix(top, "xy")) if turn[2, 2] == 1 else None  # else the springs alone guide it
    step = kg.LoadControl(m).run()[-1]
    m.hold(step)
    if sides is not None:
        m.remove(sides)
    return m, top, step


def along(res: kg.Results, nodes: list[kg.Node]) -> np.ndarray:
    """Force (s,) in the plane that moves the nodes."""
    return np.linalg.norm([res.reaction(nodes, axis) for axis in "xy"], axis=0)


def share_of(res: kg.Results) -> np.ndarray:
    """Share of the limit (s, nodes) that is used up at the small sheet."""
    return np.linalg.norm(res.deformation("self-friction"), axis=2)[:, -16:]


@pytest.fixture(scope="module")
def two_sheets() -> tuple[kg.Model, list[kg.Node], kg.Step]:
    return pressed()


def dragged(m: kg.Model, top: list[kg.Node], step: kg.Step, count: int = 5, **options: Any) -> kg.Results:
    """The small sheet is moved along at an angle to its edges, by six widths."""
    moved = m.add(kg.Prescribe(top, x=FAR * np.cos(0.3), y=FAR * np.sin(0.3)))
    try:
        return kg.DisplacementControl(m, targets=np.linspace(0.1, 1, count), start=step).run(**options)
    finally:
        m.remove(moved)


def test_a_sheet_on_a_plane_sticks_and_then_slides_at_mu_n():
    m, top, step = pressed(floor=True)
    res = dragged(m, top, step)
    pull, slides = along(res, top), share_of(res).min(axis=1) > 1 - 1e-6
    moved = FAR * res.lam
    sticks = share_of(res).max(axis=1) < 0.99
    assert sticks.sum() > 2 and slides.sum() > 2 and not slides[moved < 0.9 * WIDTH].any()
    assert pull[slides] == pytest.approx(MU * PRESS, rel=1e-3)
    assert pull[sticks] == pytest.approx(MU * PRESS * moved[sticks] / WIDTH, rel=0.02, abs=2e-3 * MU * PRESS)


def test_two_sheets_rub_at_mu_n_and_balance(two_sheets):
    res = dragged(*two_sheets)
    force, normal = res.force("self-friction"), res.force("self-contact")[:, 25:, 2].sum(axis=1)
    held = np.linalg.norm(force[:, 25:].sum(axis=1), axis=1)
    slides, sticks = share_of(res).min(axis=1) > 0.97, share_of(res).max(axis=1) < 0.97
    assert slides.sum() > 2 and sticks.sum() > 2
    assert held[slides] == pytest.approx(MU * normal[slides], rel=0.01)
    assert (held[sticks] < 0.97 * MU * normal[sticks]).all()
    assert np.abs(force.sum(axis=1)).max() < 1e-9 * PRESS
    x = res.rest + res.u
    moment = np.linalg.norm(np.cross(x, force).sum(axis=1), axis=1)
    assert (moment[held > 0] < 1e-3 * THICK * held[held > 0]).all()  # forces at a distance, and the couple against it


def test_what_sticks_does_not_creep_and_does_not_let_go(two_sheets):
    """Also where a load more is added in the next stage: what remembers is found though kernels moved on."""
    m, step = copy.deepcopy(two_sheets[0]), two_sheets[2]
    top = m.nodes[-16:]
    pull = kg.NodalLoad(top, (0.8 * MU * PRESS / len(top), 0, 0))
    m.add(pull)
    loaded = kg.LoadControl(m, start=step).run()
    first = loaded[-1].u[25:, 0].mean() - step.u[25:, 0].mean()
    assert 0.5 * WIDTH < first < WIDTH
    m.hold(loaded[-1])
    m.add(kg.NodalLoad(top, (0, 1e-3 * MU * PRESS / len(top), 0)))
    waited = kg.LoadControl(m, start=loaded[-1], targets=np.linspace(0, 1, 9)[1:]).run()
    crept = waited.u[-1, 25:, 0].mean() - loaded[-1].u[25:, 0].mean()
    assert len(waited) > 8 and abs(crept) < 0.02 * WIDTH


@pytest.fixture(scope="module")
def rubbing(two_sheets) -> tuple[kg.Kernel, np.ndarray]:
    """The kernel of two sheets, and positions in which they are pressed together."""
    m, _, step = two_sheets
    system = kg.System(m)
    kernel = next(kernel for kernel in system.kernels if kernel.name == "self-friction")
    return kernel, np.asarray(system.configuration(step.u))


def test_gradient_and_tangent_are_those_of_the_energy(rubbing):
    kernel, x = rubbing
    kernel.commit(x)
    assert kernel.history[:, LIMIT].sum() == pytest.approx(MU * PRESS, rel=2e-3)
    rng = np.random.default_rng(1)
    direction = rng.normal(size=x.shape)
    for far in (2e-3, 0.03):  # sticks, slides
        at = x + far * np.where(np.arange(len(x))[:, None] < 25, 0, 1) * [1, 0.4, 0] + 1e-4 * rng.normal(size=x.shape)
        h = 1e-7
        energy = [kernel.evaluate(at + way * h * direction, 1.0, 0).energy.sum() for way in (1, -1)]
        gradient = [kernel.evaluate(at + way * h * direction, 1.0, 1).gradient[:, 0] for way in (1, -1)]
        slope = (kernel.evaluate(at, 1.0, 1).gradient[:, 0] * direction).sum()
        assert (energy[0] - energy[1]) / (2 * h) == pytest.approx(slope, rel=1e-6)
        product = (kernel.coupling(at) @ direction.ravel()).reshape(x.shape)
        assert np.abs(product - (gradient[0] - gradient[1]) / (2 * h)).max() < 1e-5 * np.abs(product).max()


def test_what_turns_as_a_whole_does_not_slip(rubbing):
    kernel, x = rubbing
    kernel.history = None
    kernel.commit(x)
    c, s = np.cos(0.1), np.sin(0.1)
    turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    share = np.linalg.norm(kernel.deformation(x @ turn.T), axis=1)
    assert share.max() < 1e-3  # 0.1 of the gap over the width, 0.2, without the turn of the gap
    kernel.commit(x @ turn.T)
    assert np.linalg.norm(kernel.deformation(x @ turn.T), axis=1).max() < 1e-3


@pytest.mark.long
def test_friction_is_the_same_in_other_units_and_turned():
    def found(turn: np.ndarray, length: float) -> np.ndarray:
        m, top, step = pressed(turn=turn, length=length)
        m.add(kg.NodalLoad(top, 0.7 * MU * PRESS / len(top) * turn[:, 0]))
        return kg.LoadControl(m, start=step, targets=[1.0]).run().force("self-friction")[-1] @ turn

    here = found(np.eye(3), 1.0)
    assert np.abs(here).max() > 0
    for turn, length in ((TURN, 1.0), (np.eye(3), 1e3)):
        assert np.abs(found(turn, length) - here).max() < 0.01 * np.abs(here).max()


def test_files_and_checkpoints_carry_friction(two_sheets, tmp_path: Path):
    whole = dragged(*two_sheets, count=3)
    whole.save(tmp_path / "rubbed.npz")
    back = kg.load(tmp_path / "rubbed.npz")
    assert np.array_equal(back.force("self-friction"), whole.force("self-friction"))
    assert np.array_equal(back.deformation("self-friction"), whole.deformation("self-friction"))

    def stop(step: kg.Step) -> None:
        if step.lam > 0.3:
            raise KeyboardInterrupt

    file = tmp_path / "half.npz"
    with pytest.warns(kg.errors.KirigamiWarning, match="interrupted"):
        dragged(*two_sheets, count=3, recorders=[stop], checkpoint=file)
    resumed = dragged(*two_sheets, count=3, checkpoint=file)
    assert np.array_equal(resumed.lam, whole.lam) and np.array_equal(resumed.u, whole.u)


def test_no_friction_no_kernel_and_wrong_values_are_refused():
    with pytest.raises(kg.ModelError, match="friction"):
        kg.SelfContact(friction=-0.1)
    assert repr(kg.SelfContact(friction=0.2)) == "SelfContact(friction=0.2)"
    nodes, facets = grid(1, 1, 1.0, 1.0)
    m = kg.Model.from_mesh(kg.TriMesh(nodes, facets), thickness=0.02, material=PET, stiffness="facet")
    m.add(kg.SelfContact())
    assert all(kernel.name != "self-friction" for kernel in kg.System(m).kernels)
