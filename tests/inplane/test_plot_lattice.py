"""Pictures of lattices: what is drawn, not how it looks."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

from matplotlib import pyplot as plt
from matplotlib.colors import to_rgb

import kirigami as kg
from kirigami import tilings
from kirigami.lattice.framework import Framework
from kirigami.lattice.picture import MOVED, REST, animate_path, plot_mode, plot_results_panels, plot_tiling

PIECE = tilings.rotating_squares(0.6).patch(2, 1)


def teardown_function() -> None:
    plt.close("all")


def test_panels_at_rest_are_brown_and_moved_ones_blue() -> None:
    moved = np.full((len(PIECE.vertices), 2), 0.1)
    ax = plot_tiling(PIECE, moved, supports=[0], forces=[(1, (1, 0))], legend=True)
    rest, blue, springs = ax.collections[:3]
    assert len(rest.get_paths()) == len(blue.get_paths()) == 8
    assert to_rgb(rest.get_facecolor()[0, :3]) == to_rgb(REST) and to_rgb(blue.get_facecolor()[0, :3]) == to_rgb(MOVED)
    shift = blue.get_paths()[0].vertices - rest.get_paths()[0].vertices
    assert shift == pytest.approx(0.1)
    assert len(springs.get_offsets()) == len(PIECE.joints)
    assert np.asarray(springs.get_offsets())[0] == pytest.approx(PIECE.vertices[PIECE.joints[0]] + 0.1)


def test_a_mode_is_arrows_along_it() -> None:
    (shape,) = Framework.from_tiling(PIECE, bracing="crossed").rigidity().shapes
    ax = plot_mode(PIECE, shape)
    quiver = ax.collections[-1]
    drawn = np.stack([quiver.U, quiver.V], axis=1)
    kept = np.linalg.norm(shape, axis=1) > 0.01 * np.linalg.norm(shape, axis=1).max()
    scale = np.linalg.norm(drawn, axis=1).max() / np.linalg.norm(shape, axis=1).max()
    assert drawn == pytest.approx(scale * shape[kept, :2])


def test_results_and_animation(tmp_path: Path) -> None:
    model = PIECE.model(EA=1e3, stiffness=1.0)
    model.add(kg.Fix(model.nodes[:2]), kg.NodalLoad(model.nodes[-1], (0.05, 0.0)))
    results = kg.LoadControl(model).run()
    ax = plot_results_panels(PIECE, results)
    last = PIECE.vertices[PIECE.polygons[0]] + results.u[-1][PIECE.polygons[0], :2]
    assert ax.collections[1].get_paths()[0].vertices[:-1] == pytest.approx(last)
    written = animate_path(PIECE, results.u, tmp_path / "moving.gif", frames=4)
    from PIL import Image

    assert Image.open(written).n_frames == 6  # there and back, ends once
    assert [file.name for file in tmp_path.iterdir()] == ["moving.gif"]


def test_bad_pictures() -> None:
    with pytest.raises(kg.ModelError, match="displacements must have shape"):
        plot_tiling(PIECE, np.zeros((2, 2)))
    with pytest.raises(kg.ModelError, match="zero everywhere"):
        plot_mode(PIECE, np.zeros((len(PIECE.vertices), 2)))
    with pytest.raises(kg.ModelError, match="path must have shape"):
        animate_path(PIECE, np.zeros((3, 2)), "never.gif")
    assert not Path("never.gif").exists()
