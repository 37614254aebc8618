"""The picture of an accuracy study: error against time, rung by rung, with the Pareto front."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from kirigami.plot import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from kirigami.study.accuracy import AccuracyStudy

LOOKS = {
    "paper": ("#999999", "v"),
    "plate": (style.BLUE, "o"),
    "facet": (style.GREEN, "s"),
    "shell": (style.VERMILION, "D"),
}


@style.styled
def draw_accuracy(study: AccuracyStudy, others: Mapping[str, Mapping[str, tuple[float, float]]]) -> Figure:
    """Largest error against CPU seconds, one panel a quantity; failures are listed below."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogFormatter

    class Plain(LogFormatter):
        """Numbers as people write them, where there is room: 0.6 and not 6e-01."""

        def __call__(self, x: float, pos: int | None = None) -> str:
            return f"{x:g}" if super().__call__(x, pos) else ""

    from kirigami.study.accuracy import edge_of
    from kirigami.study.reference import QUANTITIES

    shown = [name for name in QUANTITIES if np.isfinite(study.reference[name]).any()] or ["force"]
    figure = Figure(figsize=(3.4 * len(shown), 3.4), layout="constrained")
    axes = np.atleast_1d(figure.subplots(1, len(shown)))
    rungs = list(dict.fromkeys(str(row["stiffness"]) for row in study.table))
    for ax, quantity in zip(axes, shown):
        for rung in rungs:
            color, marker = LOOKS.get(rung, ("black", "x"))
            rows = [row for row in study.table if row["stiffness"] == rung and row["status"] == "done"]
            rows.sort(key=lambda row: (-float(row["tol"]), -float(row["max_edge"])))
            errors = np.array([100 * study.error(row, quantity) for row in rows])
            seconds = np.array([float(row["cpu_seconds"]) for row in rows])
            kept = np.isfinite(errors) & (errors > 1e-6)
            if kept.any():
                ax.plot(seconds[kept], errors[kept], color=color, marker=marker, markersize=4.5, lw=1, label=rung)
        front = [row for row in study.front(quantity) if study.error(row, quantity) > 1e-8]
        ax.plot(
            [float(row["cpu_seconds"]) for row in front],
            [100 * study.error(row, quantity) for row in front],
            color="black", lw=5, alpha=0.12, solid_capstyle="round", zorder=0,
        )  # fmt: skip
        if (own := 100 * study.judge.own_error(quantity)) > 1e-6:
            ax.axhline(own, color="black", lw=0.6, ls=":", label="error of the reference")
        for number, (name, points) in enumerate(others.items()):
            if quantity in points:
                error, seconds_there = points[quantity]
                ax.plot([seconds_there], [100 * error], color="black", marker="*x+"[number % 3], lw=0, label=name)
        ax.set(xlabel="CPU seconds", title=quantity.replace("_", " "))
        ax.grid(True, which="both", lw=0.3, alpha=0.5)
        if not np.isfinite(ax.dataLim.minpos).all():  # a logarithmic axis needs something to show
            ax.text(0.5, 0.5, "nothing to compare", ha="center", va="center", transform=ax.transAxes)
            ax.set(xticks=[], yticks=[])
            continue
        ax.set(xscale="log", yscale="log")
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(Plain(labelOnlyBase=False, minor_thresholds=(1.2, 0.5)))
    axes[0].set_ylabel("largest error [%]")
    if axes[-1].get_legend_handles_labels()[0]:
        axes[-1].legend(fontsize=7)
    failed = [f"{row['stiffness']} {edge_of(row, study.scale)}" for row in study.table if row["status"] == "failed"]
    others_shaped = [
        f"{row['stiffness']} {edge_of(row, study.scale)}" for row in study.table if study.other_shape(row) is not None
    ]
    lists = {"failed": failed, "another shape": others_shaped}
    told = [f"{what}: {', '.join(runs)}" for what, runs in lists.items() if runs]
    if told:
        figure.supxlabel("; ".join(told), fontsize=7)
    return figure
