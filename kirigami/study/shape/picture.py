"""The picture of a search for shapes: energy and force against the pull, with every branch that is known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.errors import ModelError
from kirigami.plot import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from kirigami.study.shape.study import ShapeStudy

DRAWN = 3  # shapes drawn as pictures


@style.styled
def draw_shapes(study: ShapeStudy) -> Figure:
    """Above the lowest shapes; below energy and force against the load factor, the range of forces shaded.

    Raises
    ------
    ModelError
        There is no shape.
    """
    from matplotlib import pyplot

    if not len(study):
        raise ModelError("there is no shape to draw")
    drawn = list(study[:DRAWN])
    solid = study.model.dim == 3
    figure = pyplot.figure(figsize=(6.4, 5.8), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=(1.0, 1.1))
    above, below = parts
    for place, shape in enumerate(drawn, start=1):
        ax = above.add_subplot(1, len(drawn), place, projection="3d" if solid else None)
        _draw_shape(study, ax, place - 1)
        force = "" if np.isnan(shape.force) else f", force {shape.force:.4g}"
        ax.set_title(f"shape {shape.number}: energy {shape.energy:.4g}{force}", color=_color(shape.number), fontsize=8)
    left, right = below.subplots(1, 2)
    _draw_curves(study, left, "energy")
    _draw_curves(study, right, "force")
    return figure


def _color(number: int) -> str:
    return style.CURVES[(number - 1) % len(style.CURVES)]


def _draw_shape(study: ShapeStudy, ax: Any, place: int) -> None:
    from kirigami.results.results import Results
    from kirigami.system.system import System

    results = Results(System(study.model))
    results.append(study[place].step)
    results.plot(ax=ax, colorbar=False, view=style.VIEW if study.model.dim == 3 else None)
    ax.set_axis_off()


def _draw_curves(study: ShapeStudy, ax: Any, quantity: str) -> None:
    """Branches as lines, all shapes as points; a snap is a dotted line up or down to where it leads."""
    for branch in study.branches:
        color = _color(branch.shape)
        ax.plot(branch.lam, getattr(branch, quantity), color=color, linewidth=1.2)
        ends = [link.lam for link in study.links if link.shape == branch.shape]
        for end, at in ((0, branch.lam[0]), (-1, branch.lam[-1])):
            if ends and min(abs(at - lam) for lam in ends) < 0.1 * abs(study.at):
                ax.plot(at, getattr(branch, quantity)[end], "x", color=color, markersize=5)
    for shape in study:
        ax.plot(study.at, getattr(shape, quantity), "o", color=_color(shape.number), markersize=3.5)
    values = [getattr(shape, quantity) for shape in study]
    if quantity == "force" and np.isfinite(values).all() and len(values) > 1:
        ax.axhspan(min(values), max(values), color=style.PALE, alpha=0.6, linewidth=0)
        ax.set_title(f"at {study.at:g}: {min(values):.4g} to {max(values):.4g}", fontsize=8)
    ax.set_xlabel("load factor")
    ax.set_ylabel(f"{quantity}{f' on {study.searched}' if study.branches and study.searched else ''}")
