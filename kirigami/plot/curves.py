"""Curves over the path: forces and open areas."""

from __future__ import annotations

import copy
import itertools
from collections.abc import Iterable, Sequence
from contextlib import nullcontext, suppress
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import AnalysisError, ModelError
from kirigami.plot import style
from kirigami.primitives.checks import require_array, require_axis, require_boolean, require_choice
from kirigami.results.scale import scale_of

if TYPE_CHECKING:
    from kirigami.primitives.node import Node
    from kirigami.results.drives import Drive
    from kirigami.results.results import Results
    from kirigami.scale import Scale

Floats = NDArray[np.float64]


@style.styled
def plot_curve(
    results: Results,
    nodes: Node | int | Iterable[Node | int] | None = None,
    axis: str | Sequence[float] | Floats = "y",
    x: str | tuple[Any, str] | ArrayLike = "lam",
    ax: Any = None,
    label: str | None = None,
    color: Any = None,
    markers: bool = True,
    band: bool | None = None,
) -> Any:
    """Draw the force curve: stable parts solid, unstable parts dashed, limit points marked.

    Of results of :func:`kirigami.stretch` and no further words, it is what was asked for: force over strain, torque
    over twist, and so on.

    Parameters
    ----------
    results : Results
        What to draw.
    nodes : Node, int, or sequence of them, optional
        Supported nodes whose summed reaction is drawn; None draws the load factor, or of a stretched sheet the force.
    axis : {"x", "y", "z"} or direction of 2 or 3 numbers
        Component of the reaction.
    x : "lam", "time", (node, axis) or array_like, shape (s,)
        What it is drawn over: the load factor (of a stretched sheet and its force, the strain), the time of a motion, a
        displacement of a node, or your own values.
    ax : matplotlib axes, optional
        Where to draw; a new figure by default. Draw twice on the same axes to compare two runs.
    label : str, optional
        Name of the curve in the legend.
    color : matplotlib colour, optional
        Colour of the curve; None takes the first that no curve on the axes has.
    markers : bool
        Whether to dot the stored steps.
    band : bool, optional
        Whether to shade what the estimated error of the force leaves open, ``results.error["force"]``; None does so
        round the force of a stretched sheet.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ModelError
        No steps, an unknown axis or node, or nothing to draw over.
    AnalysisError
        A band of results that have no error bar.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0))
    >>> bars = m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
    >>> rest = m.add(kg.Fix([left, right]), kg.Fix(apex, "x"), kg.NodalLoad(apex, (0, -1)))
    >>> res = kg.DisplacementControl(m, to=-2.0, control=(apex, "y")).run()
    >>> ax = res.plot_curve(x=(apex, "y"))
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['stable', 'unstable', 'limit point']
    """
    if isinstance(axis, str):
        require_axis(axis, "plot_curve")
    else:
        require_array(axis, (2,), (3,), name="axis", owner="plot_curve")
    scale = scale_of(results)
    across, what, kind = _abscissa(results, x, "plot_curve")
    drive = results.drives[0] if nodes is None and results.drives and isinstance(x, str) else None
    if drive is not None:
        across, up = drive.share * drive.travel(results), drive.force(results)
    elif nodes is None and isinstance(x, str):
        raise ModelError("plot_curve: give nodes whose reaction is drawn, or x=(node, axis) for the load factor")
    else:
        up = results.lam if nodes is None else results.reaction(nodes, axis)
    firm = np.array([step.negative in (None, 0) for step in results.steps])
    shaded = drive is not None if band is None else require_boolean(band, "band", "plot_curve")
    error = None
    with nullcontext() if band else suppress(AnalysisError):  # no estimate of what is no sheet
        error = results.error["force"] if shaded else None
    ax = style.new_axes((4.4, 3.2)) if ax is None else ax
    color = style.next_color(ax) if color is None else color
    if error is not None:
        low, high = up * (1 - error), up * (1 + error)
        ax.fill_between(across, low, high, color=color, alpha=0.2, linewidth=0, label="estimated error")
    if markers and len(across) <= 80:
        ax.plot(across, up, linestyle="none", marker="o", markersize=2.6, color=color)
    # A located limit point is a point of the curve like any other; the stable and the unstable side meet there.
    limits, after = _limit_points(results)
    located = len(after) > 0 and isinstance(x, (str, tuple))
    if located:
        if drive is not None:
            there, response = drive.share * drive.travel(limits), drive.force(limits)
        else:
            there = _abscissa(limits, x, "plot_curve")[0]
            response = limits.lam if nodes is None else limits.reaction(nodes, axis)
        across, up = np.insert(across, after, there), np.insert(up, after, response)
        firm = np.insert(firm, after, True)
        after = after + np.arange(len(after))
    names = {True: label or (None if firm.all() else "stable"), False: None if label else "unstable"}
    for begin, end, stable in _pieces(firm[:-1] & firm[1:]):
        line = "-" if stable else (0, (3, 2))
        ax.plot(across[begin:end], up[begin:end], color=color, linewidth=1.5, linestyle=line, label=names[stable])
        names[stable] = None
    if located:
        rim = {"markeredgecolor": style.VERMILION, "markeredgewidth": 1.4, "markerfacecolor": "white"}
        name = None if label else "limit point"
        ax.plot(across[after], up[after], linestyle="none", marker="o", markersize=6, zorder=3, label=name, **rim)
    if drive is not None:
        label_drive(ax, drive, scale)
        style.label_axis(ax.yaxis, drive.takes(scale), drive.answer_kind, scale)
    else:
        style.label_axis(ax.xaxis, what, kind, scale)
        reaction = "reaction" + f" along {axis}" * isinstance(axis, str)
        style.label_axis(ax.yaxis, *(("load factor", "") if nodes is None else (reaction, "force")), scale)
    if ax.get_legend_handles_labels()[0]:
        ax.legend()
    return ax


@style.styled
def plot_open_area(
    results: Results,
    x: str | tuple[Any, str] | ArrayLike = "lam",
    ax: Any = None,
    label: str | None = None,
    color: Any = None,
    cuts: bool = True,
) -> Any:
    """Draw the open area of the cuts: their union bold, each cut by itself thin.

    Parameters
    ----------
    results : Results
        What to draw; of a model made from a mesh with cuts.
    x : "lam", (node, axis) or array_like, shape (s,)
        What it is drawn over, as in :func:`plot_curve`.
    ax : matplotlib axes, optional
        Where to draw; a new figure by default.
    label : str, optional
        Name of the curve in the legend.
    color : matplotlib colour, optional
        Colour of the bold curve; None takes the first that no curve on the axes has.
    cuts : bool
        Whether to draw the curve of each cut as well.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ModelError
        No steps, or a mesh without cuts.
    AnalysisError
        The model was not made from a mesh.

    Examples
    --------
    >>> import kirigami as kg
    >>> ring = [(0, 0), (3, 0), (3, 3), (0, 3), (1, 1), (2, 1), (2, 2), (1, 2)]
    >>> facets = [(0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7)]
    >>> m = kg.Model.from_mesh(kg.TriMesh(ring, facets), thickness=0.01, material=kg.Material(E=1e9), dim=2)
    >>> bottom, top = m.select(boundary="bottom"), m.select(boundary="top")
    >>> held = m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.Prescribe(top, y=0.3))
    >>> ax = kg.plot.plot_open_area(kg.LinearStatic(m).run())
    >>> ax.get_ylabel()
    'open area'
    """
    across, what, kind = _abscissa(results, x, "plot_open_area")
    each, together = results.open_area(), results.open_area(union=True)
    if not each.shape[1]:
        raise ModelError("plot_open_area: the mesh has no cuts")
    ax = style.new_axes((4.4, 3.2)) if ax is None else ax
    color = style.next_color(ax) if color is None else color
    several = cuts and each.shape[1] > 1
    if several:
        thin = ax.plot(across, each, color=style.GREY, linewidth=0.5, alpha=0.7)
        if label is None:
            thin[0].set_label("each cut")
    name = label if label is not None else "all cuts" if several else None
    ax.plot(across, together, color=color, linewidth=1.5, marker="o", markersize=2.6, label=name)
    style.label_axis(ax.xaxis, what, kind, scale_of(results))
    style.label_axis(ax.yaxis, "open area", "area", scale_of(results))
    ax.set_ylim(bottom=min(0.0, float(each.min())))
    if ax.get_legend_handles_labels()[0]:
        ax.legend()
    return ax


def label_drive(ax: Any, drive: Drive, scale: Scale) -> None:
    """Say what of a load case lies along the horizontal axis."""
    if drive.kind == "length":
        style.label_axis(ax.xaxis, drive.title(scale), "length", scale)
    else:
        ax.set_xlabel(drive.titles(scale)[0])


def _abscissa(results: Results, x: Any, owner: str) -> tuple[Floats, str, str]:
    """Values (s,) along the horizontal axis, what they are and, for its unit, of which kind."""
    if not len(results):
        raise ModelError(f"{owner}: the results hold no step")
    if isinstance(x, str):
        known = ("lam", "time") if results.moves else ("lam",)
        require_choice(x, known, "x", owner, or_else="(node, axis), or one value for each step")
        if x == "time":
            return results.time, "time", ""
        return results.lam, "load factor", ""
    if isinstance(x, tuple) and len(x) == 2 and isinstance(x[1], str):
        node, axis = x
        require_axis(axis, owner, "the axis in x")
        index = results.node_index(node)
        return results.u[:, index, "xyz".index(axis)].mean(axis=1), f"displacement along {axis}", "length"
    return require_array(x, results.lam.shape, name="x", owner=owner), "", ""


def _limit_points(results: Results) -> tuple[Results, NDArray[np.int64]]:
    """Located limit points as results of their own, which know their reactions, and the step after each."""
    from kirigami.results.step import Step

    points = copy.copy(results)
    points.steps = []
    found = [event for event in results.events if event.kind == "limit point" and event.u is not None]
    for event in found:
        assert event.u is not None
        points.append(Step(event.lam, event.u, history=results[event.step].history))
    return points, np.array([event.step + 1 for event in found], dtype=np.int64)


def _pieces(firm: NDArray[np.bool_]) -> list[tuple[int, int, bool]]:
    """Runs of like segments as (first point, last point + 1, stable)."""
    bounds = np.concatenate([[0], np.flatnonzero(np.diff(firm)) + 1, [len(firm)]]) if len(firm) else np.zeros(1, int)
    return [(int(begin), int(end) + 1, bool(firm[begin])) for begin, end in itertools.pairwise(bounds)]
