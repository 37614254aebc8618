"""Films: their frames, their files, and what is refused."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image
from plot_samples import truss

import kirigami as kg
from kirigami.plot import deformed


def test_frames_are_even_in_the_load_factor(
    lifted: kg.Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[Any] = []
    update = deformed.Picture.update
    monkeypatch.setattr(deformed.Picture, "update", lambda self, x, v: (shown.append(x.copy()), update(self, x, v)))
    done: list[int] = []
    path = lifted.animate(tmp_path / "new" / "lift.gif", frames=5, fps=10, on_frame=done.append)
    assert done == [1, 2, 3, 4, 5]
    pulled = np.array(shown)[:, 2, 1] - 3.0  # a driven displacement is linear in the load factor
    assert_allclose(pulled, 0.3 * np.linspace(0, 1, 5), atol=1e-12)
    with Image.open(path) as gif:
        assert (gif.n_frames, gif.format) == (5, "GIF")
        assert gif.info["duration"] == 100
    assert [other.name for other in path.parent.iterdir()] == ["lift.gif"]


def test_a_video_holds_the_frames_and_then_the_last_for_a_second(lifted: kg.Results, tmp_path: Path) -> None:
    video = pytest.importorskip("imageio.v3")
    pytest.importorskip("imageio_ffmpeg")
    lifted.animate(tmp_path / "lift.gif", frames=5, fps=10, dpi=67)  # sides of an odd number of pixels
    path = lifted.animate(tmp_path / "lift.mp4", frames=5, fps=10, dpi=67)
    with Image.open(tmp_path / "lift.gif") as gif:
        width, height = gif.size
        gif.seek(4)
        last = np.asarray(gif.convert("L"), dtype=float)
    assert width % 2 or height % 2
    shown = video.imread(path, plugin="FFMPEG")
    assert shown.shape == (5 + 10, height // 2 * 2, width // 2 * 2, 3)
    assert video.immeta(path, plugin="FFMPEG")["fps"] == 10
    assert video.immeta(path, plugin="FFMPEG")["codec"] == "h264"
    # The last frame is that of the GIF but for compression; the first one is not.
    far, near = (np.abs(shown[k].mean(axis=2) - last[: shown.shape[1], : shown.shape[2]]).mean() for k in (0, -1))
    assert near < 0.5 * far
    assert {other.name for other in tmp_path.iterdir()} == {"lift.gif", "lift.mp4"}


def test_a_video_without_its_library_says_what_to_install(
    lifted: kg.Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)  # as if it were not installed
    with pytest.raises(kg.KirigamiError, match=r"needs imageio_ffmpeg: pip install .*kirigami-mechanics\[viz\]"):
        lifted.animate(tmp_path / "lift.mp4", frames=2)
    assert not list(tmp_path.iterdir())


def test_a_path_that_turns_back_is_shown_as_it_went(
    snapped: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    res, *_ = snapped
    heights: list[float] = []
    monkeypatch.setattr(deformed.Picture, "update", lambda self, x, v: heights.append(x[1, 1]))
    res.animate(tmp_path / "snap.gif", frames=30, dpi=20)
    assert heights[0] == 1.0 and heights[-1] == pytest.approx(-1.0)
    assert (np.diff(heights) < 0).all()


def test_an_animation_that_fails_leaves_the_old_file(lifted: kg.Results, tmp_path: Path) -> None:
    path = tmp_path / "lift.gif"
    path.write_text("old")

    def stop(_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lifted.animate(path, frames=2, on_frame=stop)
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("name", "options", "complaint"),
    [
        ("lift.avi", {}, "writes .gif and .mp4 files, not 'lift.avi'"),
        ("lift.mp4", {"frames": 1}, "at least 2"),
        ("lift.gif", {"frames": 1}, "at least 2"),
        ("lift.gif", {"fps": 0}, "fps must be positive"),
        ("lift.gif", {"color": "hight"}, "unknown"),
    ],
)
def test_animate_refuses(lifted: kg.Results, tmp_path: Path, name: str, options: Any, complaint: str) -> None:
    with pytest.raises(kg.ModelError, match=complaint):
        lifted.animate(tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_one_step_does_not_move(tmp_path: Path) -> None:
    m, *_ = truss()
    res = kg.Results(kg.System(m))
    res.append(kg.Step.at(m, 0.0, np.zeros((3, 3))))
    with pytest.raises(kg.ModelError, match="at least two stored steps"):
        res.animate(tmp_path / "still.gif")
