"""What was understood of a drawing: one colour a role, and what was left out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.plot import style
from kirigami.plot.undeformed import draw_paper, flat_axes
from kirigami.scale import Scale

if TYPE_CHECKING:
    from kirigami.drawing.drawing import Drawing

MANY = 2000  # lines that would cover the sheet if they were drawn as wide as a few are


@style.styled
def plot_drawing(drawing: Drawing, ax: Any = None) -> Any:
    """Draw outline, slits, openings, folds and what was left out, each in a colour of its own.

    Parameters
    ----------
    drawing : Drawing
        What a reader has made of a file.
    ax : matplotlib axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ModelError
        Axes that are not flat.

    Examples
    --------
    >>> from kirigami.plot.drawing_picture import plot_drawing
    >>> import shapely
    >>> from kirigami.drawing.drawing import Drawing
    >>> ax = plot_drawing(Drawing(shapely.box(0, 0, 2, 1), (shapely.LineString([(0.5, 0.5), (1.5, 0.5)]),), unit="mm"))
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['outline', 'slit (1)']
    """
    import shapely

    everything = shapely.GeometryCollection([drawing.outline, *drawing.left_out])
    bounds = np.array(everything.bounds).reshape(2, 2)
    ax = flat_axes(ax, "plot_drawing", bounds)
    draw_paper(ax, drawing.outline, drawing.cuts, style.PAPER)
    ax.plot([], [], color=style.INK, label="outline")
    kinds: list[tuple[str, list[Any], dict[str, Any]]] = [
        ("slit", [cut for cut in drawing.cuts if not isinstance(cut, shapely.Polygon)], {"color": style.VERMILION}),
        ("opening", [cut.exterior for cut in drawing.cuts if isinstance(cut, shapely.Polygon)], {"color": style.GREEN}),
        ("fold", list(drawing.folds), {"color": style.BLUE, "linestyle": "--"}),
        ("left out", list(drawing.left_out), {"color": style.GREY, "linestyle": ":"}),
    ]
    for name, lines, look in kinds:
        if lines:
            width = 1.2 if len(lines) < MANY else 0.4
            ax.plot(*_in_one(lines).T, linewidth=width, label=f"{name} ({len(lines)})", **look)
    style.frame_flat(ax, bounds[0], bounds[1])
    if drawing.unit == "m":
        style.axes_in_unit(ax, Scale.of(float(np.ptp(bounds, axis=0).max())))
    elif drawing.unit:
        ax.set(xlabel=f"x [{drawing.unit}]", ylabel=f"y [{drawing.unit}]")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=4)
    return ax


def _in_one(lines: Sequence[Any]) -> Any:
    """The points of many lines as those of one that is interrupted: an artist for each would take half a minute."""
    import shapely

    points, owner = shapely.get_coordinates(lines, return_index=True)
    return np.insert(points, np.flatnonzero(np.diff(owner)) + 1, np.nan, axis=0)
