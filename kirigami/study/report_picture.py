"""The pictures of a report: the sheet at rest and stretched, the force and the open area over the strain."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kirigami.files import whole_file

if TYPE_CHECKING:
    from kirigami.study.report import Report

OBLIQUE = (48.0, -62.0)  # steep enough to see through the openings, flat enough to see the heights
LARGE = 1.0  # m: sheets from this size on are drawn in metres, smaller ones in millimetres


def write_pictures(report: Report, folder: Path) -> list[Path]:
    """Write ``rest.png``, ``deformed.png``, ``above.png``, ``force.png`` and, of a sheet with cuts, ``opening.png``."""
    from matplotlib import pyplot

    files = []
    for name, draw in pictures(report).items():
        figure = draw().figure
        with whole_file(folder / name) as unfinished:
            figure.savefig(unfinished, dpi=160)
        pyplot.close(figure)
        files.append(folder / name)
    return files


def pictures(report: Report) -> dict[str, Callable[[], Any]]:
    """What draws each picture of a report, by the name of its file; each returns the axes."""
    from kirigami import plot

    results, mesh = report.results, report.results.mesh
    assert mesh is not None
    large = mesh.size >= LARGE
    unit, area, lengths = ("m", "m$^2$", 1.0) if large else ("mm", "cm$^2$", 1e3)

    def in_plane(ax: Any) -> Any:
        for axis, name in ((ax.xaxis, "x"), (ax.yaxis, "y")):
            _scale(axis, lengths)
            axis.set_label_text(f"{name} [{unit}]")
        return ax

    def coloured(**view: Any) -> Any:
        ax = plot.plot_results(results, label=f"height z [{unit}]", **view)
        _scale(ax.figure.axes[-1].yaxis, lengths)
        return ax

    def over_strain(ax: Any, quantity: str) -> Any:
        ax.set_xlabel("strain: grip displacement / free length [%]")
        ax.set_ylabel(quantity)
        return ax

    def force() -> Any:
        moved = results.grips["moved"]
        ax = plot.plot_curve(results, moved, report.grips.direction, x=100 * report.strain)
        return over_strain(ax, "force of the grip [N]")

    def opening() -> Any:
        ax = plot.plot_open_area(results, x=100 * report.strain)
        _scale(ax.yaxis, 1.0 if large else 1e4)
        return over_strain(ax, f"open area seen from above [{area}]")

    drawn: dict[str, Callable[[], Any]] = {
        "rest.png": lambda: in_plane(plot.plot_model(results.model)),
        "deformed.png": lambda: coloured(view=OBLIQUE),
        "above.png": lambda: in_plane(coloured(view="top")),
        "force.png": force,
    }
    return {**drawn, "opening.png": opening} if mesh.cuts else drawn


def _scale(axis: Any, factor: float) -> None:
    """Label the ticks of an axis in another unit, at round numbers of it."""
    from matplotlib.ticker import FuncFormatter

    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{factor * value:.6g}"))
