"""Animations of the deformation."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.files import library, whole_file
from kirigami.plot import style
from kirigami.plot.deformed import Picture, chosen_view, color_bar, displaced, frame, suitable_axes
from kirigami.plot.field import Field
from kirigami.primitives.checks import (
    require_callable,
    require_not_negative,
    require_path,
    require_positive,
    require_whole,
    shown,
)

if TYPE_CHECKING:
    from kirigami.results.results import Results

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]  # (height, width, 3)
Writer = Callable[[Path, list[Pixels], float, float], None]  # path, pictures, pictures per second, pause at the end

LAST = 1.0  # seconds that the last picture stays


MOST_FRAMES = 10_000
MIN_FPS, MAX_FPS = 0.1, 240
MIN_DPI, MAX_DPI = 10, 1000


@style.styled
def animate(
    results: Results,
    path: str | os.PathLike[str],
    frames: int = 40,
    fps: float = 15,
    color: str | ArrayLike | None = None,
    edges: str = "boundary",
    view: str | tuple[float, float] | None = None,
    magnify: float = 1.0,
    dpi: float = 110,
    cmap: Any = None,
    on_frame: Callable[[int], None] | None = None,
    pause: float = LAST,
) -> Path:
    """Write the deformation as an animated GIF or an MP4 video, by the ending of the name.

    Frames are spaced evenly in time, or of equilibria in the load factor (in the way it went, where the path turns
    back), and interpolated between the stored steps; colours and scales are the same in all of them.

    Parameters
    ----------
    results : Results
        What to draw.
    path : path
        File to write, ending in ``.gif`` or ``.mp4``. It is written under another name and then renamed. Videos are
        H.264, which every browser and slide program plays, and may be one pixel smaller for that.
    frames : int
        Number of pictures, at least 2; in a video the last one is then repeated for the time it stays.
    fps : float
        Pictures per second.
    color, edges, view, magnify, cmap
        As for :func:`kirigami.plot.plot_results`.
    dpi : float
        Pixels per inch; the picture is about five inches wide.
    on_frame : callable, optional
        Called with the number of pictures done after each.
    pause : float
        Seconds that the last picture stays, so that a loop does not jump from full stretch to flat unseen.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ModelError
        Too few steps or frames, another ending, or anything :func:`plot_results` refuses.
    KirigamiError
        imageio or imageio-ffmpeg is not installed (for videos), or the file cannot be written.

    Examples
    --------
    >>> import kirigami as kg, tempfile
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     kg.LoadControl(m).run().animate(folder + "/pull.gif", frames=2).name
    'pull.gif'
    """
    target = require_path(path, "path", "animate")
    ending = target.suffix.lower()
    if ending not in WRITERS:
        raise ModelError(f"animate writes {' and '.join(WRITERS)} files, not {target.name!r}")
    frames = require_whole(frames, "frames", "animate", least=2)
    if frames > MOST_FRAMES:
        raise ModelError(f"animate: frames must be at most {MOST_FRAMES}, got {shown(frames)}")
    fps, dpi = require_positive(fps, "fps", "animate"), require_positive(dpi, "dpi", "animate")
    pause = require_not_negative(pause, "pause", "animate")
    if not (MIN_FPS <= fps <= MAX_FPS and MIN_DPI <= dpi <= MAX_DPI):
        raise ModelError(
            f"animate: fps must lie between {MIN_FPS} and {MAX_FPS}, dpi between {MIN_DPI} and {MAX_DPI}, got {fps:g} "
            f"and {dpi:g}"
        )
    if on_frame is not None:
        require_callable(on_frame, "on_frame", "animate")
    if len(results) < 2:
        raise ModelError(f"animate needs at least two stored steps, the results hold {len(results)}")
    write = WRITERS[ending]()  # before the drawing, which would be in vain without its libraries
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    looking = chosen_view(results, None, view)
    field = Field(results, color, smooth=True)
    values = [field.at(number) for number in range(len(results))]
    bar = values[0] is not None
    held = np.concatenate([displaced(results, step.u, magnify) for step in results.steps])
    ax, place = suitable_axes(held, looking, bar, managed=False)
    figure = ax.figure
    picture = Picture(results, ax, field, edges, cmap)
    picture.scale_colors(*values)
    frame(ax, held, looking)
    if bar:
        color_bar(picture, field, place)
    way = _way(results.time if results.moves else results.lam)
    canvas: Any = FigureCanvasAgg(figure)
    figure.set_dpi(dpi)
    images: list[Pixels] = []
    for place_on_way in np.linspace(0.0, 1.0, frames):
        before, share = _between(way, float(place_on_way))
        u = _mix(results[before].u, results[before + 1].u, share)
        picture.update(displaced(results, u, magnify), _mix(values[before], values[before + 1], share))
        canvas.draw()
        if not images:  # the layout is settled now and must not move from frame to frame
            figure.set_layout_engine("none")
        images.append(np.array(np.asarray(canvas.buffer_rgba())[:, :, :3]))
        if on_frame is not None:
            on_frame(len(images))
    with whole_file(target) as unfinished:
        write(unfinished, images, float(fps), pause)
    return target


def _gif_writer() -> Writer:
    from PIL import Image  # which matplotlib depends on

    def write(path: Path, images: list[Pixels], fps: float, pause: float) -> None:
        lasts = [max(round(1000 / fps), 20)] * len(images)
        lasts[-1] += round(1000 * pause)
        first, *others = [Image.fromarray(image) for image in images]
        first.save(path, "GIF", save_all=True, append_images=others, duration=lasts, loop=0)

    return write


def _mp4_writer() -> Writer:
    library("imageio_ffmpeg", "writing a video", extra="viz")  # which brings the ffmpeg that imageio calls
    imageio = library("imageio.v2", "writing a video", extra="viz")

    def write(path: Path, images: list[Pixels], fps: float, pause: float) -> None:
        height, width = (side // 2 * 2 for side in images[0].shape[:2])  # colours are stored for 2 x 2 pixels
        with imageio.get_writer(path, format="FFMPEG", fps=fps, quality=8, macro_block_size=2) as video:
            for image in images + images[-1:] * round(pause * fps):
                video.append_data(image[:height, :width])

    return write


WRITERS: dict[str, Callable[[], Writer]] = {".gif": _gif_writer, ".mp4": _mp4_writer}


def _way(lam: Floats) -> Floats:
    """Share (s,) of the way done at each step, in the load factor or time; in steps where that stands still."""
    walked = np.abs(np.diff(lam))
    if walked.sum() == 0:
        walked = np.ones(len(lam) - 1)
    way = np.concatenate([[0.0], np.cumsum(walked)])
    return np.asarray(way / way[-1])


def _between(way: Floats, place: float) -> tuple[int, float]:
    """Step before a place on the way, and the share of the distance to the next."""
    before = int(np.clip(np.searchsorted(way, place, side="right") - 1, 0, len(way) - 2))
    gap = way[before + 1] - way[before]
    return before, float(np.clip((place - way[before]) / gap, 0.0, 1.0)) if gap > 0 else 1.0


def _mix(first: Any, second: Any, share: float) -> Any:
    return None if first is None else (1 - share) * first + share * second
