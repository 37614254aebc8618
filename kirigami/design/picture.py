"""One picture of an inverse problem: what was wanted and reached, the sheet before and after, and the parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.plot import style
from kirigami.plot.undeformed import plot_sheet
from kirigami.primitives.checks import require_instance
from kirigami.results.results import Results
from kirigami.results.scale import scale_of
from kirigami.scale import Scale

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from kirigami.design.answer import InverseResult
    from kirigami.design.design import Design
    from kirigami.primitives.kernel import Array
    from kirigami.results.gradients.equilibrium import Equilibrium

ABREAST = 3  # panels in a row, so that a page can hold them
TOLD = {  # what targets ask for, in words, and what it is measured in
    "force": ("force", "force"), "position": ("place of nodes", "length"), "point": ("place of a point", "length"),
    "energy": ("energy", "energy"), "open_area": ("open area", "area"), "height": ("height", "length"),
    "width": ("width", "length"), "shape": ("squared distance from the shape", "area"),
    "critical": ("critical load factor", ""),
}  # fmt: skip


@style.styled
def plot_result(result: InverseResult, again: Results | None = None) -> Figure:
    """Draw the answer of an inverse problem: each target, the sheet before and after, and the course of the search.

    Parameters
    ----------
    result : InverseResult
        The answer.
    again : Results, optional
        What the drawing of the answer does by itself, from ``Job.load(result.design.export(folder)).run().results``:
        its last step gets a panel of its own, and all axes get its units.

    Returns
    -------
    matplotlib.figure.Figure
    """
    from matplotlib.figure import Figure

    curves = [number for number, lam in enumerate(result.lam) if len(lam) > 1]
    points: dict[str, list[int]] = {}  # one panel for all that is of one kind
    for number in (number for number, lam in enumerate(result.lam) if len(lam) == 1):
        points.setdefault(result.names[number], []).append(number)
    shown = result.thicker is not None
    if again is not None:
        require_instance(again, Results, "again", "InverseResult.plot")
    scale = Scale() if again is None else scale_of(again)
    targets = len(curves) + len(points)
    panels = targets + 3 + shown + (again is not None)
    rows = -(-panels // ABREAST)
    columns = -(-panels // rows)
    figure = Figure(figsize=(3.4 * columns, 3.2 * rows), layout="constrained")
    axes: Any = figure.subplots(rows, columns, squeeze=False).ravel()
    for idle in axes[panels:]:
        idle.set_axis_off()
    for number, ax in zip(curves, axes):
        _curve(ax, result, number)
    for numbers, ax in zip(points.values(), axes[len(curves) :]):
        _points(ax, result, numbers)
    for name, ax in zip([*(result.names[number] for number in curves), *points], axes):
        style.label_axis(ax.yaxis, *TOLD.get(name, (name.replace("_", " "), "")), scale)
    sheets = axes[targets:]
    for ax, title, design in ((sheets[0], "start", result.start), (sheets[1], "found", result.design)):
        plot_sheet(design.sheet(), ax=ax)
        style.axes_in_unit(ax, scale)
        ax.set_title(title)
    if shown:
        _thicker(sheets[2], result)
    _changes(sheets[2 + shown], result)
    if again is not None:
        axes[panels - 1].remove()
        last = figure.add_subplot(rows, columns, panels, projection="3d" if again.dim == 3 else None)
        again.plot(ax=last).set_title("run again, from the drawing")
    return figure


def _lines(result: InverseResult) -> list[tuple[str, Any, str, str]]:
    """Label, values by target, colour and marker of what a picture shows of each target."""
    lines = [("wanted", result.wanted, "black", "o"), ("start", result.before, "#999999", "s"),
             ("found", result.coarse, style.BLUE, "+")]  # fmt: skip
    return [*lines, ("found, finer mesh", result.reached, style.VERMILION, "x")] if result.reached else lines


def _curve(ax: Any, result: InverseResult, number: int) -> None:
    """A target over the load factor."""
    lam = result.lam[number]
    order = np.argsort(lam)
    for label, values, color, marker in _lines(result):
        width = 0 if label == "wanted" else 1.2
        ax.plot(lam[order], values[number][order], color=color, marker=marker, lw=width, label=label)
    ax.set(xlabel="load factor", title="targets")
    ax.legend(frameon=True, framealpha=0.8, edgecolor="none")


def _points(ax: Any, result: InverseResult, numbers: list[int]) -> None:
    """Targets of one kind at one load factor each, side by side."""
    for label, values, color, marker in _lines(result):
        told = [values[number][0] for number in numbers]
        ax.plot(np.arange(len(numbers)), told, color=color, marker=marker, lw=0, label=label)
    ax.set_xticks(np.arange(len(numbers)), [str(number + 1) for number in numbers])
    ax.margins(x=0.15)
    ax.set(xlabel="number of the target", title="targets")
    ax.legend(frameon=True, framealpha=0.8, edgecolor="none")


def _thicker(ax: Any, result: InverseResult) -> None:
    """Where a thicker sheet would bring the targets nearer."""
    assert result.thicker is not None
    mesh, pull = result.design.mesh, -result.thicker
    most = float(np.abs(pull).max()) or 1.0
    ax.tripcolor(
        mesh.nodes[:, 0], mesh.nodes[:, 1], mesh.triangles, pull / most, cmap="RdBu", vmin=-1, vmax=1, edgecolors="face"
    )
    ax.set(aspect="equal", title="better thicker (blue) or thinner (red)")
    ax.set_axis_off()


@style.styled
def plot_trial(design: Design, at: Equilibrium, errors: Array, names: list[str]) -> Figure:
    """One design of a search: its sheet as drawn, as it stands at the last load factor, and its errors."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 3.2), layout="constrained")
    axes: Any = figure.subplots(1, 3)
    plot_sheet(design.sheet(), ax=axes[0])
    axes[0].set_title("as drawn")
    mesh = design.mesh
    place = np.zeros((len(mesh.nodes), 3))
    place[:, : at.system.dim] = at.configuration[: len(mesh.nodes)]
    axes[1].tripcolor(place[:, 0], place[:, 1], mesh.triangles, place[:, 2], shading="gouraud", cmap="viridis")
    axes[1].set(aspect="equal", title=f"at load factor {at.lam:g}, by height")
    axes[1].set_axis_off()
    axes[2].barh(np.arange(len(names)), 100 * np.asarray(errors), color=style.BLUE, height=0.5)
    axes[2].set_yticks(np.arange(len(names)), names)
    axes[2].axvline(0, color="black", lw=0.6)
    axes[2].set(xlabel="error [%]", title="targets")
    return figure


def _changes(ax: Any, result: InverseResult) -> None:
    """How far each parameter went, as a share of its range, and which way it would still pull."""
    names = list(result.values)
    span = np.array([result.design.span(name) for name in names])
    moved = (result.design.vector - result.start.vector) / span
    ax.barh(np.arange(len(names)), moved, color=style.BLUE, height=0.5)
    pull = -np.array([result.sensitivities.get(name, 0.0) for name in names]) * span
    largest = float(np.abs(pull).max(initial=0.0))
    if largest > 0:
        reach = max(0.3 * float(np.abs(moved).max(initial=0.0)), 0.02)
        for row, (at, way) in enumerate(zip(moved, pull / largest * reach)):
            ax.annotate("", (at + way, row), (at, row), arrowprops={"arrowstyle": "->", "color": style.VERMILION})
    ax.set_yticks(np.arange(len(names)), names)
    ax.axvline(0, color="black", lw=0.6)
    meant = "\n(arrows: which way errors would still fall)" if largest > 0 else ""
    ax.set(xlabel=f"change over its range{meant}", title="parameters")
