"""Animations of the deformation."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import ModelError
from kirigami.plot import style
from kirigami.plot.deformed import Field, Picture, chosen_view, displaced, frame, suitable_axes

if TYPE_CHECKING:
    from collections.abc import Callable

    from kirigami.results import Results

Floats = NDArray[np.float64]


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
) -> Path:
    """Write the deformation as an animated GIF.

    Frames are spaced evenly in the load factor (in the way it went, where the path turns back) and interpolated
    between the stored steps; colours and scales are the same in all of them, and the last one stays for a second.

    Parameters
    ----------
    results : Results
        What to draw.
    path : path
        File to write; its name must end in ``.gif``. It is written under another name and then renamed.
    frames : int
        Number of pictures, at least 2.
    fps : float
        Pictures per second.
    color, edges, view, magnify, cmap
        As for :func:`kirigami.plot.plot_results`.
    dpi : float
        Pixels per inch; the picture is about five inches wide.
    on_frame : callable, optional
        Called with the number of pictures done after each.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ModelError
        Too few steps or frames, a name that does not end in ``.gif``, or anything :func:`plot_results` refuses.

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
    target = Path(path)
    if target.suffix.lower() != ".gif":
        raise ModelError(f"animate writes GIF files: the name {target.name!r} must end in .gif")
    if isinstance(frames, bool) or not isinstance(frames, (int, np.integer)) or frames < 2:
        raise ModelError(f"animate: frames must be an integer of at least 2, got {frames!r}")
    if not (np.isfinite(fps) and fps > 0):
        raise ModelError(f"animate: fps must be positive, got {fps!r}")
    if len(results) < 2:
        raise ModelError(f"animate needs at least two stored steps, the results hold {len(results)}")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image  # which matplotlib depends on

    looking = chosen_view(results, None, view)
    field = Field(results, color)
    values = [field.at(number) for number in range(len(results))]
    bar = values[0] is not None
    held = np.concatenate([displaced(results, step.u, magnify) for step in results.steps])
    ax, place = suitable_axes(held, looking, bar, managed=False)
    figure = ax.figure
    picture = Picture(results, ax, field, edges, cmap)
    picture.scale_colors(*values)
    frame(ax, held, looking)
    if bar:
        style.color_bar(ax, picture.mappable, field.label, place)
    way = _way(results.lam)
    canvas: Any = FigureCanvasAgg(figure)
    figure.set_dpi(dpi)
    images: list[Any] = []
    for place_on_way in np.linspace(0.0, 1.0, frames):
        before, share = _between(way, float(place_on_way))
        u = _mix(results[before].u, results[before + 1].u, share)
        picture.update(displaced(results, u, magnify), _mix(values[before], values[before + 1], share))
        canvas.draw()
        if not images:  # the layout is settled now and must not move from frame to frame
            figure.set_layout_engine("none")
        images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
        if on_frame is not None:
            on_frame(len(images))
    pause = [max(round(1000 / fps), 20)] * frames
    pause[-1] += 1000  # so that a loop does not jump from full stretch to flat unseen
    target.parent.mkdir(parents=True, exist_ok=True)
    unfinished = target.with_name(f"{target.name}.part")
    try:
        images[0].save(unfinished, "GIF", save_all=True, append_images=images[1:], duration=pause, loop=0)
        os.replace(unfinished, target)
    finally:
        unfinished.unlink(missing_ok=True)
    return target


def _way(lam: Floats) -> Floats:
    """Share (s,) of the way done at each step, measured in the load factor; in steps where that stands still."""
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
