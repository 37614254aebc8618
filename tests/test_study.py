"""Imperfection studies: seeds, final shapes that are sorted, failures as rows, going on after an interruption."""

from __future__ import annotations

import csv
import importlib.util
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot

import kirigami as kg
from kirigami.study.shape.space import ShapeSpace


def plate(columns: int = 5, rows: int = 5, length: float = 1.0) -> kg.Model:
    """A plate on simple supports all round, squeezed along y."""
    x, y = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, length, rows + 1))
    wide = columns + 1
    corners = [wide * row + column for row in range(rows) for column in range(columns)]
    triangles = [t for a in corners for t in ((a, a + 1, a + wide + 1), (a, a + wide + 1, a + wide))]
    mesh = kg.TriMesh(np.column_stack([x.ravel(), y.ravel()]), triangles)
    m = kg.Model.from_mesh(mesh, thickness=0.005, material=kg.Material(E=1e6, nu=1 / 3))
    top = m.select(boundary="top")
    m.add(kg.Fix(m.select(boundary="outer"), "z"), kg.Fix(m.select(boundary="bottom"), "xy"), kg.Fix(top, "x"))
    m.add(kg.Prescribe(top, y=-2e-4 * length))
    return m


def test_seeds_of_a_flat_sheet_move_out_of_the_plane_only() -> None:
    m = plate()
    shapes = kg.study.seeds(m, 4)
    x, y, _ = m.positions().T
    assert len(shapes) == 4
    for shape in shapes:
        assert np.abs(shape[:, 2]).max() == 1.0 and not shape[:, :2].any()
    overlap = np.array([[np.vdot(a, b) / np.linalg.norm(a) / np.linalg.norm(b) for a in shapes] for b in shapes])
    np.testing.assert_allclose(overlap, np.eye(4), atol=1e-8)  # nodes of equal mass
    assert np.vdot(shapes[0][:, 2], np.sin(np.pi * x) * np.sin(np.pi * y)) > 0.99 * 6.25  # sum of sin^4 products


def test_seeds_of_a_free_sheet_leave_out_the_rigid_motions() -> None:
    m = plate()
    m.remove(*m.constraints)
    values = kg.Eigen(m, n=8).run()
    bent = kg.study.seeds(m, 2)
    for shape, mode in zip(bent, list(values)[6:]):
        np.testing.assert_allclose(np.abs(shape[:, 2]), np.abs(mode.shape[:, 2]), atol=1e-6)
    with pytest.raises(kg.ModelError, match="modes that can seed"):
        kg.study.seeds(m, 500)


def test_a_square_plate_has_one_final_shape() -> None:
    """Half waves up or down are one shape; force and energy do not know the seed."""
    m = plate()
    before = m.positions()
    study = kg.study.imperfections(m, modes=2, amplitudes=[1e-4, 1e-6])
    assert np.array_equal(m.positions(), before)
    assert [(c.mode, c.sign, c.amplitude) for c in study.cases[:3]] == [(1, 1, 1e-4), (1, -1, 1e-4), (1, 1, 1e-6)]
    assert all(case.done and case.lam == 1.0 for case in study.cases) and list(study.branches) == [1]
    energy = np.array([case.energy for case in study.cases])
    assert np.ptp(energy) < 2e-2 * energy.max()
    for up, down in zip(study.cases[::2], study.cases[1::2]):
        assert up.energy == pytest.approx(down.energy, rel=1e-8) and up.height == pytest.approx(down.height, rel=1e-8)
    # The force is the work of the drive per load factor: reaction times grip displacement.
    last, top = study.final(1), m.index(m.select(boundary="top"))
    assert study.cases[2].force == pytest.approx(-2e-4 * last.reaction(top, "y")[-1], rel=1e-9)
    assert "branch 1" in str(study)


def test_a_long_plate_has_two() -> None:
    """Two or three half waves along a plate 2.45 times as long as wide, both stable: near the crossing at sqrt(6)."""
    m = plate(5, 12, 2.45)
    x, y, _ = m.positions().T
    waves = [np.sin(np.pi * x) * np.sin(n * np.pi * y / 2.45) for n in (2, 3)]
    study = kg.study.branches(m, modes=waves, amplitude=1e-3)
    two, three, *_ = study.branches[study.cases[0].branch], study.branches[study.cases[2].branch]
    assert len(study.branches) == 2 and len(two) == len(three) == 2
    energies = [min(case.energy for case in cases) for cases in study.branches.values()]
    assert energies == sorted(energies)


def test_shapes_are_compared_up_to_reflections() -> None:
    m = plate(7, 7)
    space = ShapeSpace(m)
    x, y, _ = m.positions().T
    shape = np.zeros((len(x), 3))
    shape[:, 2] = x * (1 - x) * y**2 * (1 - x / 2)
    other = np.zeros_like(shape)
    for mirrored in ([1 - x, y], [x, 1 - y], [1 - x, 1 - y]):
        a, b = mirrored
        other[:, 2] = -a * (1 - a) * b**2 * (1 - a / 2)
        assert space.distance(shape, other) < 0.08  # the diagonals of the mesh are not symmetric
        assert ShapeSpace(m, mirrors="").distance(shape, other) > 0.2
    assert space.distance(shape, shape) == 0.0
    assert space.clusters([shape, 2 * shape, -shape, other], alike=0.1).tolist() == [0, 1, 0, 0]


def test_a_failure_is_a_row() -> None:
    """Pulled too far at once: a limit point that load control cannot pass."""
    m = kg.Model(dim=2)
    left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 0.5), kg.Node(1, 0))
    m.add(kg.Bar(left, apex, 1.0), kg.Bar(apex, right, 1.0), kg.Fix([left, right]), kg.NodalLoad(apex, (0, -1)))
    shape = np.array([[0, 0], [1, 0], [0, 0]])
    study = kg.study.imperfections(m, modes=[shape], amplitudes=[1e-3], analysis=kg.LoadControl)
    assert not any(case.done for case in study.cases) and not study.branches
    assert "no equilibrium found" in study.cases[0].status and 0.03 < study.cases[0].lam < 0.035
    assert "no equilibrium found" in str(study)
    with pytest.raises(kg.ModelError, match="reached its end"):
        study.plot()
    with pytest.raises(kg.ModelError, match="no branch"):
        study.final(1)


def test_it_goes_on_where_it_was_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C in the middle of the third run."""
    arguments: dict[str, Any] = {"modes": 2, "amplitudes": [1e-4], "folder": tmp_path}
    run, count = kg.DisplacementControl.run, []

    def stop(step: kg.Step) -> None:
        if len(count) == 3 and step.lam > 0.5:
            raise KeyboardInterrupt

    def interrupted(analysis: kg.DisplacementControl, **options: Any) -> kg.Results:
        count.append(analysis)
        return run(analysis, recorders=[stop], **options)

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(kg.DisplacementControl, "run", interrupted)
        kg.study.imperfections(plate(), **arguments)
    assert len(list(tmp_path.glob("*.npz"))) == 3
    study = kg.study.imperfections(plate(), **arguments)
    whole = kg.study.imperfections(plate(), modes=2, amplitudes=[1e-4])
    assert study.cases == whole.cases
    assert len(list(tmp_path.glob("*.npz"))) == 4


def test_executors_give_the_same_table(tmp_path: Path) -> None:
    analysis = partial(kg.DisplacementControl, to=0.6)
    alone = kg.study.imperfections(plate(4, 4), modes=1, amplitudes=[1e-4], analysis=analysis)
    with ThreadPoolExecutor(2) as pool:
        threads = kg.study.imperfections(plate(4, 4), 1, [1e-4], analysis, executor=pool)
    with ProcessPoolExecutor(1) as pool:
        processes = kg.study.imperfections(plate(4, 4), 1, [1e-4], analysis, executor=pool)
    assert alone.cases == threads.cases == processes.cases
    table = alone.table(tmp_path / "table.csv")
    rows = list(csv.DictReader(open(tmp_path / "table.csv", encoding="utf-8")))
    assert len(rows) == 2 and float(rows[0]["energy"]) == table["energy"][0] and rows[0]["status"] == "done"


def test_the_picture_tells_every_run() -> None:
    study = kg.study.branches(plate(4, 4), modes=1)
    figure = study.plot()
    titles = [ax.get_title() for ax in figure.axes]
    assert any("branch 1" in title for title in titles)
    texts = [text.get_text() for ax in figure.axes for text in ax.texts]
    assert texts.count("1") == 2
    # Heights are grey where they are nothing: a shape that is all on one side has the colours of that side.
    height = study.final(1).position()[-1, :, 2]
    side = 1 if height.max() > -height.min() else -1
    assert (side * height).min() > -0.01 * np.abs(height).max()
    (red, _, blue), grey = figure.axes[0].collections[0].get_facecolor()[:, :3].T, 0.04
    assert (side * (blue - red)).max() <= grey < np.abs(blue - red).max()
    pyplot.close(figure)


def test_arguments_that_cannot_be_used() -> None:
    m = plate()
    with pytest.raises(kg.ModelError, match="amplitude"):
        kg.study.imperfections(m, amplitudes=[-1.0])
    with pytest.raises(kg.ModelError, match="at least one"):
        kg.study.imperfections(m, modes=1, amplitudes=[])
    with pytest.raises(kg.ModelError, match="sign"):
        kg.study.imperfections(m, modes=1, signs=[2])
    with pytest.raises(kg.ModelError, match="zero everywhere"):
        kg.study.imperfections(m, modes=[np.zeros(36)])
    with pytest.raises(kg.ModelError, match="mirrors"):
        kg.study.imperfections(m, modes=1, mirrors="r")
    with pytest.raises(kg.ModelError, match="at least 1"):
        kg.study.seeds(m, 0)


# ------------------------------------------------------------------------------------------------- the disc


def test_disc_with_a_cut() -> None:
    """A coarse mesh: two modes, two amplitudes, both signs; branches and forces do not depend on the amplitude."""
    path = Path(__file__).parent.parent / "examples" / "imperfection_study.py"
    specification = importlib.util.spec_from_file_location("imperfection_study", path)
    assert specification is not None and specification.loader is not None
    example = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(example)
    disc = example.flat_disc(0.7)
    first, _, _, _, _, sixth = kg.study.seeds(disc, 6)
    bent = example.flat_disc(0.7)
    bent.perturb(first, amplitude=0.03)
    offset = bent.positions() - disc.positions()
    assert np.abs(offset[:, 2]).max() == 0.03 and not offset[:, :2].any()

    study = example.main(max_edge=0.7, modes=[first, sixth], amplitudes=example.AMPLITUDES[:2])
    assert all(case.done for case in study.cases)
    assert len(study.branches) >= 2
    assert example.mirror_error(study) < 1e-8
    assert example.force_spread(study) < 0.05
    assert len(set(example.lowest(study).values())) == 1
