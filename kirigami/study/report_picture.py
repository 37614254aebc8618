"""The pictures of a report: the sheet at rest and stretched, the force and the open area over the strain."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kirigami.files import whole_file

if TYPE_CHECKING:
    from kirigami.study.report import Report


def write_pictures(report: Report, folder: Path) -> list[Path]:
    """Write ``rest.png``, ``deformed.png``, ``force.png`` and, of a sheet with cuts, ``opening.png``."""
    from matplotlib import pyplot

    from kirigami import plot

    results = report.results
    assert results.mesh is not None
    pictures: dict[str, Callable[[], Any]] = {
        "rest.png": lambda: plot.plot_model(results.model),
        "deformed.png": lambda: plot.plot_results(results),
        "force.png": lambda: _over_strain(
            report, plot.plot_curve(results, results.grips["moved"], report.grips.direction, x=100 * report.strain),
            "force of the grip [N]",
        ),
    }  # fmt: skip
    if results.mesh.cuts:
        pictures["opening.png"] = lambda: _over_strain(
            report, plot.plot_open_area(results, x=100 * report.strain), "open area [m$^2$]"
        )
    files = []
    for name, draw in pictures.items():
        figure = draw().figure
        with whole_file(folder / name) as unfinished:
            figure.savefig(unfinished, dpi=160)
        pyplot.close(figure)
        files.append(folder / name)
    return files


def _over_strain(report: Report, ax: Any, quantity: str) -> Any:
    ax.set_xlabel("strain: grip displacement / free length [%]")
    ax.set_ylabel(quantity)
    return ax
