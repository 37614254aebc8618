"""Curves of what follows from results: shares of energy, and any measure of your own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.plot import style
from kirigami.plot.curves import _abscissa
from kirigami.primitives.checks import require_array, require_text
from kirigami.results.scale import scale_of

if TYPE_CHECKING:
    from kirigami.results.results import Results

KIND_COLORS = {"bars": style.BLUE, "hinges": style.VERMILION, "springs": style.GREEN}
OTHER_COLORS = (*style.CURVES[3:], style.GREY)


@style.styled
def plot_energy_shares(results: Results, x: str | tuple[Any, str] | ArrayLike = "lam", ax: Any = None) -> Any:
    """Draw how the stored energy is shared between bars, hinges, springs and the rest, as stacked areas.

    Parameters
    ----------
    results : Results
        What to draw.
    x : "lam", (node, axis) or array_like, shape (s,)
        What it is drawn over, as in :func:`kirigami.plot.plot_curve`.
    ax : matplotlib axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ModelError
        No steps, no elements, or nothing to draw over.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> kg.plot.plot_energy_shares(kg.LinearStatic(m).run()).get_ylabel()
    'share of the energy'
    """
    across, what, kind = _abscissa(results, x, "plot_energy_shares")
    shares = results.energy_shares()
    stored = sum(shares.values()) > 0.5  # not at rest, where there is nothing to share
    ax = style.new_axes((4.4, 3.2)) if ax is None else ax
    spare = iter(OTHER_COLORS * len(shares))
    colors = [KIND_COLORS.get(kind) or next(spare) for kind in shares]
    ax.stackplot(
        across[stored], *(values[stored] for values in shares.values()), colors=colors, labels=list(shares), alpha=0.85
    )
    style.label_axis(ax.xaxis, what, kind, scale_of(results))
    ax.set(ylabel="share of the energy", ylim=(0, 1))
    ax.margins(x=0)
    ax.legend(loc="center right", frameon=True, framealpha=0.8, edgecolor="none")
    return ax


@style.styled
def plot_measure(
    results: Results,
    values: ArrayLike,
    name: str = "",
    x: str | tuple[Any, str] | ArrayLike = "lam",
    ax: Any = None,
    label: str | None = None,
    color: Any = None,
) -> Any:
    """Draw one value per step: a height, a width, a Poisson ratio, or any measure of your own.

    Parameters
    ----------
    results : Results
        Whose steps they are.
    values : array_like, shape (s,)
        One value for each step; steps where it is nan are left out.
    name : str
        What it is, for the vertical axis.
    x : "lam", (node, axis) or array_like, shape (s,)
        What it is drawn over, as in :func:`kirigami.plot.plot_curve`.
    ax : matplotlib axes, optional
        Where to draw; a new figure by default.
    label : str, optional
        Name of the curve in the legend.
    color : matplotlib colour, optional
        Colour of the curve; None takes the first that no curve on the axes has.

    Returns
    -------
    matplotlib axes

    Raises
    ------
    ModelError
        No steps, nothing to draw over, or another number of values.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> res = kg.LinearStatic(m).run()
    >>> kg.plot.plot_measure(res, res.height(), "height").get_ylabel()
    'height'
    """
    across, what, kind = _abscissa(results, x, "plot_measure")
    require_text(name, "name", "plot_measure")
    up = require_array(values, results.lam.shape, name="values", owner="plot_measure", finite=False)
    shown = np.isfinite(up)
    ax = style.new_axes((4.4, 3.2)) if ax is None else ax
    color = style.next_color(ax) if color is None else color
    ax.plot(across[shown], up[shown], color=color, linewidth=1.5, marker="o", markersize=2.6, label=label)
    style.label_axis(ax.xaxis, what, kind, scale_of(results))
    ax.set_ylabel(name)
    if label:
        ax.legend()
    return ax
