"""Pictures of panel lattices: filled panels, red springs, modes as arrows, animations of mechanisms.

Undeformed panels are brown, deformed ones blue. Matplotlib is imported when something is drawn.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.errors import ModelError
from kirigami.files import whole_file
from kirigami.plot.style import new_axes, styled
from kirigami.primitives.kernel import Array
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.lattice.tilings.tiling import Tiling
    from kirigami.results.results import Results

REST = "#c9a27c"
REST_EDGE = "#8a623a"
MOVED = "#5b8db8"
MOVED_EDGE = "#274f73"
SPRING = "#c0392b"
ARROW = "#222222"


@styled
def plot_tiling(
    tiling: Tiling,
    u: ArrayLike | None = None,
    ax: Any = None,
    springs: bool = True,
    supports: Sequence[int] = (),
    forces: Sequence[tuple[int, ArrayLike]] = (),
    legend: bool = False,
) -> Any:
    """Draw the panels of a tiling, at rest and, where displacements are given, deformed over it.

    Parameters
    ----------
    tiling : Tiling
        A finite tiling, or the cell of a periodic one.
    u : array_like, shape (n, 2) or (n, 3), optional
        Displacements of its vertices [length]; further rows are ignored.
    ax : matplotlib axes, optional
        Where to draw; None makes new ones.
    springs : bool
        Mark the joints by red dots.
    supports : sequence of int
        Vertices to mark as held.
    forces : sequence of (int, (2,))
        Vertices and directions of arrows; the longest is drawn a tenth of the picture long.
    legend : bool
        Name the colours.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ModelError
        Displacements of the wrong shape.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    ax = new_axes((6, 5)) if ax is None else ax
    rest = tiling.vertices
    moved = rest if u is None else rest + _field(tiling, u)
    _fill(ax, tiling, rest, REST, REST_EDGE, 0.55 if u is not None else 0.9, 1)
    if u is not None:
        _fill(ax, tiling, moved, MOVED, MOVED_EDGE, 0.75, 2)
    size = float(np.ptp(np.concatenate([rest, moved]), axis=0).max())
    if springs and tiling.gaps:
        pivots = sorted({gap.pivot for gap in tiling.gaps})
        ax.scatter(*moved[pivots].T, s=_dot(ax, tiling, size), color=SPRING, zorder=4, linewidths=0)
    if len(supports):
        ax.scatter(*rest[list(supports)].T, s=22, marker="^", color="black", zorder=5, linewidths=0)
    longest = max((float(np.linalg.norm(force)) for _, force in forces), default=1.0)
    for node, force in forces:
        tip = moved[node]
        tail = tip - 0.1 * size * np.asarray(force, dtype=float)[:2] / longest
        ax.annotate("", tip, tail, arrowprops={"arrowstyle": "-|>", "color": ARROW, "lw": 1.5, "shrinkB": 1}, zorder=6)
        ax.update_datalim([tail])
    if legend:
        handles: list[Any] = [Patch(facecolor=REST, edgecolor=REST_EDGE, alpha=0.7, label="undeformed")]
        if u is not None:
            handles.append(Patch(facecolor=MOVED, edgecolor=MOVED_EDGE, alpha=0.8, label="deformed"))
        if springs:
            handles.append(Line2D([], [], marker="o", ls="", ms=4, color=SPRING, label="spring"))
        ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(0, 0), ncols=3, frameon=False, fontsize="small")
    return _finish(ax)


def plot_results_panels(tiling: Tiling, results: Results, step: int = -1, ax: Any = None, **options: Any) -> Any:
    """Draw a stored step of an analysis of ``tiling.model(...)``; options as for :func:`plot_tiling`.

    Raises
    ------
    ModelError
        No such step, or results of another model.
    """
    if not -len(results) <= step < len(results):
        raise ModelError(f"plot_results_panels: step {step} is not among the {counted(len(results), 'stored step')}")
    return plot_tiling(tiling, results.u[step], ax=ax, **options)


@styled
def plot_mode(tiling: Tiling, shape: ArrayLike, ax: Any = None, length: float = 0.12, springs: bool = False) -> Any:
    """Draw a motion as arrows on the panels.

    Parameters
    ----------
    tiling : Tiling
        The panels.
    shape : array_like, shape (n, 2) or (n, 3)
        Displacements of the vertices, in any scale.
    ax : matplotlib axes, optional
        Where to draw; None makes new ones.
    length : float
        Length of the longest arrow, as a share of the size of the tiling.
    springs : bool
        Mark the joints by red dots.

    Raises
    ------
    ModelError
        A shape that does not fit, or is zero.
    """
    field = _field(tiling, shape)
    largest = float(np.linalg.norm(field, axis=1).max())
    if largest == 0:
        raise ModelError("plot_mode: the motion is zero everywhere")
    ax = plot_tiling(tiling, ax=ax, springs=springs)
    arrows = length * float(np.ptp(tiling.vertices, axis=0).max()) / largest * field
    kept = np.linalg.norm(field, axis=1) > 0.01 * largest
    ax.quiver(
        *tiling.vertices[kept].T, *arrows[kept].T, angles="xy", scale_units="xy", scale=1,
        color=ARROW, width=0.004, zorder=5,
    )  # fmt: skip
    ax.update_datalim(tiling.vertices + arrows)
    return _finish(ax)


def animate_path(
    tiling: Tiling,
    path: ArrayLike,
    file: str | os.PathLike[str],
    frames: int = 40,
    fps: int = 20,
    there_and_back: bool = True,
    springs: bool = True,
) -> Path:
    """Write a motion of the panels as a GIF.

    Parameters
    ----------
    tiling : Tiling
        The panels.
    path : array_like, shape (s, n, 2) or (s, n, 3)
        Displacements of the vertices, state by state: ``results.u``, a path of ``Framework.follow``, a mode times
        growing factors [length].
    file : path
        Where to write; a file of that name is replaced when the new one is complete.
    frames : int
        Pictures one way.
    fps : int
        Pictures per second.
    there_and_back : bool
        Run the motion back as well.
    springs : bool
        Mark the joints by red dots.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ModelError
        A path that does not fit the tiling.
    """
    import matplotlib.pyplot as plt
    from matplotlib.animation import FuncAnimation, PillowWriter

    states = np.asarray(path, dtype=float)
    if states.ndim != 3 or len(states) < 1:
        raise ModelError(f"animate_path: the path must have shape (s, n, 2) or (s, n, 3), got {states.shape}")
    moved = np.array([tiling.vertices + _field(tiling, state) for state in states])
    at = np.linspace(0, len(moved) - 1, max(int(frames), 2))
    low = np.minimum(at.astype(int), len(moved) - 2) if len(moved) > 1 else np.zeros(len(at), dtype=int)
    high = np.minimum(low + 1, len(moved) - 1)
    part = (at - low)[:, None, None]
    shown = (1 - part) * moved[low] + part * moved[high]
    if there_and_back:
        shown = np.concatenate([shown, shown[-2:0:-1]])
    corner, size = moved.min(axis=(0, 1)), np.ptp(moved, axis=(0, 1))
    figure, ax = plt.subplots(figsize=(5.0, max(1.2, min(8.0, 5.0 * size[1] / size[0]))), dpi=100)
    figure.subplots_adjust(0, 0, 1, 1)
    pivots = sorted({gap.pivot for gap in tiling.gaps}) if springs else []
    dot = _dot(ax, tiling, float(size.max()))

    def draw(frame: int) -> list[Any]:
        ax.clear()
        _fill(ax, tiling, moved[0], REST, REST_EDGE, 0.45, 1)
        _fill(ax, tiling, shown[frame], MOVED, MOVED_EDGE, 0.8, 2)
        if pivots:
            ax.scatter(shown[frame][pivots, 0], shown[frame][pivots, 1], s=dot, color=SPRING, zorder=4, linewidths=0)
        margin = 0.04 * size.max()
        ax.set(xlim=(corner[0] - margin, corner[0] + size[0] + margin))
        ax.set(ylim=(corner[1] - margin, corner[1] + size[1] + margin))
        ax.set_aspect("equal")
        ax.set_axis_off()
        return []

    try:
        with whole_file(file) as unfinished:
            named = unfinished.with_suffix(".gif")  # the writer goes by the ending
            FuncAnimation(figure, draw, frames=len(shown)).save(named, writer=PillowWriter(fps=fps))
            os.replace(named, unfinished)
    finally:
        plt.close(figure)
    return Path(file)


def _field(tiling: Tiling, u: ArrayLike) -> Array:
    field = np.asarray(u, dtype=float)
    count = len(tiling.vertices)
    if field.ndim != 2 or field.shape[0] < count or field.shape[1] not in (2, 3):
        raise ModelError(f"displacements must have shape ({count}, 2) or ({count}, 3), got {field.shape}")
    return field[:count, :2]


def _fill(ax: Any, tiling: Tiling, points: Array, face: str, edge: str, alpha: float, order: int) -> None:
    from matplotlib.collections import PolyCollection

    width = float(np.clip(12 / np.sqrt(len(tiling.panels)), 0.4, 1.0))
    shapes = [points[polygon] for polygon in tiling.polygons]
    ax.add_collection(
        PolyCollection(shapes, facecolors=face, edgecolors=edge, linewidths=width, alpha=alpha, zorder=order)
    )
    ax.update_datalim(np.concatenate(shapes))


def _dot(ax: Any, tiling: Tiling, size: float) -> float:
    """Area of a spring's dot in points squared: small beside a panel, however many panels there are."""
    panel = np.median([np.ptp(tiling.vertices[polygon], axis=0).max() for polygon in tiling.polygons])
    width = 72 * ax.figure.get_size_inches()[0]
    return float(np.clip((0.1 * panel / size * width) ** 2, 1.5, 24.0))


def _finish(ax: Any) -> Any:
    ax.margins(0.04)
    ax.autoscale_view()
    ax.set_aspect("equal")
    ax.set_axis_off()
    return ax
