"""The picture of an imperfection study: seeds, final shapes, and which leads to which."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.errors import ModelError
from kirigami.plot import style
from kirigami.plot.deformed import Picture, frame
from kirigami.plot.field import Field

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from kirigami.study.imperfections import ImperfectionStudy

MOST = 6  # final shapes drawn


@style.styled
def draw_study(study: ImperfectionStudy) -> Figure:
    """Final shapes above; below, the branch of every mode, sign and amplitude.

    Raises
    ------
    ModelError
        No run reached its end.
    """
    from matplotlib import pyplot

    numbers = list(study.branches)
    if not numbers:
        raise ModelError("no run of the study reached its end, so there is no final shape to draw")
    drawn = numbers[:MOST]
    largest = max(float(np.abs(study.final(number).position()[-1, :, 2]).max()) for number in drawn)
    figure = pyplot.figure(figsize=(max(2.0 * len(drawn), 5.2), 5.2), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=(1.0, 1.15))
    above, below = parts
    solid = study.model.dim == 3
    for place, number in enumerate(drawn):
        ax = above.add_subplot(1, len(drawn), place + 1, projection="3d" if solid else None)
        _draw_shape(study, ax, number, largest)
        energy = min(case.energy for case in study.branches[number])
        ax.set_title(f"branch {number}\nenergy {energy:.4g}", color=_color(number))
    if solid:
        above.supxlabel("heights: blue below, vermilion above", fontsize=8, color=style.INK)
    _draw_table(study, below.add_subplot())
    return figure


def _color(number: int) -> str:
    return style.CURVES[(number - 1) % len(style.CURVES)]


def _draw_shape(study: ImperfectionStudy, ax: Any, number: int, largest: float) -> None:
    """A final shape; in space by its heights, grey where they are nothing, up to the `largest` of all shapes."""
    results = study.final(number)
    if study.model.dim == 3:
        field, points = Field(results, None, smooth=True), results.position()[-1]
        picture = Picture(results, ax, field, cmap=style.diverging_map(), fine=True)
        picture.scale_colors(np.array([-largest, largest]))
        frame(ax, points, style.VIEW)
        picture.update(points, field.at(len(results) - 1))
    else:
        results.plot(ax=ax, colorbar=False)
    ax.set_axis_off()


def _draw_table(study: ImperfectionStudy, ax: Any) -> None:
    """One square per run: modes along, amplitudes and signs up."""
    from matplotlib.patches import Rectangle

    lines = sorted({(case.amplitude, case.sign) for case in study.cases}, key=lambda line: (-line[0], -line[1]))
    for case in study.cases:
        row = lines.index((case.amplitude, case.sign))
        face = _color(case.branch) if case.branch else "white"
        edge = face if case.branch else style.GREY
        square = Rectangle((case.mode - 0.44, row - 0.42), 0.88, 0.84, facecolor=face, edgecolor=edge, linewidth=0.8)
        ax.add_patch(square)
        text = f"{case.branch}" if case.branch else "failed"
        ax.text(case.mode, row, text, ha="center", va="center", color="white" if case.branch else style.INK, fontsize=8)
    top = -0.6
    if solid_sheet := study.model.dim == 3 and study.model.mesh is not None:
        top -= 0.32 * len(lines) + 0.5
    ax.set_xlim(0.4, len(study.seeds) + 0.6)
    ax.set_ylim(len(lines) - 0.4, top)
    if solid_sheet:
        for number, seed in enumerate(study.seeds, start=1):
            place = (number - 0.44, top, 0.88, -0.6 - top)
            _draw_seed(study, ax.inset_axes(place, transform=ax.transData), seed)
    ax.set_xticks(range(1, len(study.seeds) + 1))
    ax.set_yticks(range(len(lines)), [f"{'+' if sign > 0 else '-'} {amplitude:.3g}" for amplitude, sign in lines])
    ax.set_xlabel("mode that is seeded")
    ax.set_ylabel("amplitude")
    ax.tick_params(length=0)
    for side in ("left", "bottom"):
        ax.spines[side].set_visible(False)


def _draw_seed(study: ImperfectionStudy, ax: Any, seed: Any) -> None:
    """Heights of a seed from above."""
    mesh = study.model.mesh
    assert mesh is not None
    x, y, _ = study.model.positions()[: len(mesh.nodes)].T
    height = seed[: len(mesh.nodes), 2]
    limits = {"vmin": -1, "vmax": 1, "cmap": style.diverging_map()}
    ax.tripcolor(x, y, mesh.triangles, height, shading="gouraud", rasterized=True, **limits)
    ax.set_aspect("equal")
    ax.set_axis_off()
