"""The look of all pictures: a few colour-blind safe colours (Okabe and Ito), thin lines, no idle frames."""

from __future__ import annotations

import functools
import importlib
import inspect
from collections.abc import Callable, Sequence
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import ModelError
from kirigami.primitives.checks import (
    require_array,
    require_boolean,
    require_choice,
    require_instance,
    require_text,
    shown,
)
from kirigami.scale import Scale

INK = "#333333"
GREY = "#9aa0a6"
PALE = "#d9dde2"
PAPER = "#eef1f5"  # fill of an undeformed sheet
BLUE = "#0072b2"
VERMILION = "#d55e00"
GREEN = "#009e73"
CURVES = (BLUE, VERMILION, GREEN, "#cc79a7", "#e69f00", "#56b4e9")
VIEW = (40.0, -60.0)  # elevation and azimuth of small shapes side by side [degrees]

SETTINGS: Any = {
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9.0,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "figure.dpi": 120.0,
    "savefig.dpi": 200.0,
}

DEFAULT_VIEW = (32.0, -62.0)  # elevation and azimuth in degrees
View = str | tuple[float, float]
Floats = NDArray[np.float64]

OWN = {  # arguments that are objects of this package
    "results": ("kirigami.results.results", "Results"),
    "model": ("kirigami.model.model", "Model"),
    "mesh": ("kirigami.geometry.mesh", "TriMesh"),
}

Parameters = ParamSpec("Parameters")
Returned = TypeVar("Returned")


def styled(draw: Callable[Parameters, Returned]) -> Callable[Parameters, Returned]:
    """Let a function draw in this style without changing the settings of the session.

    What the drawing functions have in common is checked here: axes, labels, colours, colour maps and switches.
    """
    signature = inspect.signature(draw)

    @functools.wraps(draw)
    def drawn(*args: Parameters.args, **options: Parameters.kwargs) -> Returned:
        import matplotlib

        for name, value in signature.bind(*args, **options).arguments.items():
            _check(name, value, signature.parameters[name].annotation, draw.__name__)
        with matplotlib.rc_context(SETTINGS):
            return draw(*args, **options)

    return drawn


def _check(name: str, value: Any, annotation: Any, owner: str) -> None:
    """Refuse what is no such argument of a drawing function; None is left to the function."""
    if annotation == "bool":
        require_boolean(value, name, owner)
    elif name in OWN:
        package, kind = OWN[name]
        require_instance(value, getattr(importlib.import_module(package), kind), name, owner)
    elif value is None:
        return
    elif name == "label":
        require_text(value, name, owner)
    elif name == "ax":
        from matplotlib.axes import Axes

        require_instance(value, Axes, name, owner, "matplotlib axes, or leave it out for a new figure")
    elif name in ("fill", "cut_color") or (name == "color" and annotation == "Any"):
        from matplotlib.colors import is_color_like, to_rgba

        if not is_color_like(value) or not np.isfinite(to_rgba(value)).all():
            raise ModelError(f"{owner}: {name} must be a colour of matplotlib, got {shown(value)}")
    elif name == "cmap":
        from matplotlib import colormaps
        from matplotlib.colors import Colormap

        if not isinstance(value, Colormap):
            require_choice(value, colormaps, name, owner, or_else="a colour map of matplotlib")


def new_axes(size: tuple[float, float], managed: bool = True) -> Any:
    """Flat axes of a new figure of `size` in inches.

    Without `managed` the figure does not belong to pyplot: it opens no window and needs no closing.
    """
    return _new_figure(size, managed, layout="constrained").add_subplot()


def new_solid_axes(
    points: Floats, view: tuple[float, float], bar: bool, foot: bool = False, managed: bool = True
) -> tuple[Any, Any]:
    """Axes in space in a figure cut to what will be seen of `points`, and axes for a colour bar or None.

    matplotlib's axes in space are square whatever they show; here they reach beyond the figure where they are empty.
    `foot` leaves room for a legend below.
    """
    side = 4.8
    extent = np.ptp(_seen(points, view), axis=0)
    width, height = side * np.maximum(extent / (float(extent.max()) or 1.0), 0.02)
    right, below = 0.85 if bar else 0.0, 0.4 if foot else 0.0
    total = np.array([width + right, max(1.04 * height, 2.0 if bar else 1.0) + below])
    figure = _new_figure((total[0], total[1]), managed)
    centre = np.array([width / 2, below + (total[1] - below) / 2]) - 0.0135 * side  # their origin is off the middle
    ax = figure.add_axes([*(centre - side / 2) / total, *side / total], projection="3d")
    tall = min(0.75 * total[1], 2.6)
    corner, extent = np.array([width, (total[1] - tall) / 2]), np.array([0.11, tall])
    return ax, figure.add_axes([*corner / total, *extent / total]) if bar else None


def _new_figure(size: tuple[float, float], managed: bool, layout: Any = None) -> Any:
    if managed:
        from matplotlib import pyplot

        return pyplot.figure(figsize=size, layout=layout)
    from matplotlib.figure import Figure

    return Figure(figsize=size, layout=layout)


def size_for(low: Floats, high: Floats, bar: bool) -> tuple[float, float]:
    """Size of a figure [inches] that suits a flat picture of everything between two corners."""
    width, height = (high - low)[:2] + 0.05 * max((high - low)[:2].max(), 1e-300)
    scale = min(4.6 / width, 4.2 / height)
    return scale * width + (1.7 if bar else 0.8), max(scale * height + 0.7, 2.0)


def is_solid(ax: Any) -> bool:
    """Whether axes are three-dimensional."""
    return getattr(ax, "name", "") == "3d"


def checked_view(view: Any, owner: str) -> View:
    """`view` as "top" or as elevation and azimuth in degrees."""
    if isinstance(view, str):
        if view in ("top", "3d"):
            return DEFAULT_VIEW if view == "3d" else view
    elif isinstance(view, Sequence) and len(view) == 2:
        elevation, azimuth = require_array(view, (2,), name="view", owner=owner).tolist()
        return elevation, azimuth
    raise ModelError(f"{owner}: view must be 'top', '3d' or (elevation, azimuth) in degrees, got {shown(view)}")


def frame_flat(ax: Any, low: Floats, high: Floats) -> None:
    """Equal scales and named axes for a picture in the plane that holds everything between two corners."""
    ax.update_datalim([low[:2], high[:2]])
    ax.autoscale_view()
    ax.set_aspect("equal")
    ax.set_xlabel("x")
    ax.set_ylabel("y")


def frame_solid(ax: Any, points: Floats, view: tuple[float, float]) -> None:
    """Equal scales for a picture in space that just holds `points` (n, 3), without a box round it."""
    from mpl_toolkits.mplot3d import proj3d

    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    seen = _seen(points - middle, view)
    middle = middle + (seen.min(axis=0) + seen.max(axis=0)) / 2 @ _screen(view)
    reach = float(np.ptp(points, axis=0).max()) / 2 or 1.0
    for axis, centre in zip("xyz", middle):
        getattr(ax, f"set_{axis}lim")(centre - reach, centre + reach)
    ax.set_proj_type("ortho")
    ax.view_init(elev=view[0], azim=view[1])
    ax.set_box_aspect((1, 1, 1))
    across, up, _ = proj3d.proj_transform(*points.T, ax.get_proj())
    apparent = max(np.ptp(across) / np.ptp(ax.viewLim.intervalx), np.ptp(up) / np.ptp(ax.viewLim.intervaly))
    ax.set_box_aspect((1, 1, 1), zoom=0.95 / apparent if apparent > 0 else 1.0)
    ax.set_axis_off()


def _screen(view: tuple[float, float]) -> Floats:
    """Directions (2, 3) to the right and up on the screen, for an elevation and an azimuth in degrees."""
    elevation, azimuth = np.radians(view)
    right = (-np.sin(azimuth), np.cos(azimuth), 0.0)
    up = (-np.sin(elevation) * np.cos(azimuth), -np.sin(elevation) * np.sin(azimuth), np.cos(elevation))
    return np.array([right, up])


def towards_viewer(view: tuple[float, float]) -> Floats:
    """Direction (3,) to who looks from an elevation and an azimuth in degrees."""
    return np.cross(*_screen(view))


def _seen(points: Floats, view: tuple[float, float]) -> Floats:
    """Places (n, 2) of points on the screen."""
    seen: Floats = points @ _screen(view).T
    return seen


def axes_in_unit(ax: Any, scale: Scale) -> None:
    """Label the axes x and y of a picture of something flat."""
    for axis, name in ((ax.xaxis, "x"), (ax.yaxis, "y")):
        label_axis(axis, name, "length", scale)


def label_axis(axis: Any, what: str, kind: str, scale: Scale) -> None:
    """Say what an axis holds, in the unit of the picture: its numbers stay in SI units, its ticks do not."""
    if scale.unit(kind)[0]:
        axis.set_major_formatter(in_units_of(scale.unit(kind)[1]))
    axis.set_label_text(raised(scale.title(what, kind)))


def in_units_of(factor: float) -> Any:
    """What labels the ticks of an axis in another unit, which is `factor` times that of its numbers."""
    from matplotlib.ticker import Formatter, FuncFormatter

    return FuncFormatter(lambda value, _: Formatter.fix_minus(f"{value / factor:.6g}"))  # the minus of other axes


def raised(unit: str) -> str:
    """A unit with its squares raised."""
    return unit.replace("m2", "m$^2$").replace("um", "\N{MICRO SIGN}m")


def next_color(ax: Any) -> str:
    """The first colour that no curve on some axes has."""
    used = {line.get_color() for line in ax.lines}
    return next((color for color in CURVES if color not in used), INK)


def color_bar(ax: Any, mappable: Any, label: str, place: Any = None, extend: str = "neither") -> Any:
    """A slim colour bar without a frame, beside `ax` or on axes of its own."""
    where = {"ax": ax, "shrink": 0.6, "aspect": 22, "pad": 0.03} if place is None else {"cax": place}
    bar = ax.figure.colorbar(mappable, label=label, extend=extend, **where)
    bar.outline.set_visible(False)
    bar.ax.tick_params(length=2.5)
    return bar


def sequential_map() -> Any:
    from matplotlib import colormaps

    return colormaps["viridis"]


def rising_map() -> Any:
    """Pale grey over orange to dark red, for what is nothing on most of a sheet: there its light and folds are seen."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("rising", [PALE, "#e69f00", VERMILION, "#8c2d04"])


def diverging_map() -> Any:
    """Blue over grey to vermilion; grey and not white in the middle, so that an idle bar is still seen."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("blue_vermilion", [BLUE, "#c4c8cc", VERMILION])
