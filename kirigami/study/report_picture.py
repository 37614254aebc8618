"""The pictures of a report: the sheet at rest and deformed, its stress, force and open area over what was done."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.errors import AnalysisError
from kirigami.files import whole_file
from kirigami.primitives.kernel import Array
from kirigami.results.scale import scale_of

if TYPE_CHECKING:
    from kirigami.results.results import Results
    from kirigami.study.report import Report

OBLIQUE = (48.0, -62.0)  # flat enough to see the heights
ELEVATIONS, AZIMUTHS = (35.0, 42.0, 48.0), (-75.0, -62.0, -50.0, -105.0, -118.0, -130.0)  # to choose from
PLAIN = 0.1  # of the openings that are seen, which a usual view may give away for being usual


def write_pictures(report: Report, folder: Path) -> list[Path]:
    """Write the pictures of a report as PNG files; which there are is up to the sheet."""
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
    from kirigami.plot import style

    results, mesh = report.results, report.results.mesh
    assert mesh is not None
    drive, scale = report.drive, scale_of(results)
    across = drive.share * report.motion

    def rest() -> Any:
        ax = plot.plot_model(results.model)
        style.axes_in_unit(ax, scale)
        return ax

    def over_motion(ax: Any) -> Any:
        plot.curves.label_drive(ax, drive, scale)
        return ax

    def opening() -> Any:
        return over_motion(plot.plot_open_area(results, x=across))

    view = view_of_openings(results)
    drawn: dict[str, Callable[[], Any]] = {
        "rest.png": rest,
        "deformed.png": lambda: plot.plot_results(results, view=view),
        "above.png": lambda: plot.plot_results(results, view="top"),
        "force.png": lambda: over_motion(style.styled(_force)(report, across)),
    }
    if report.stress is not None:
        drawn["stress.png"] = lambda: plot.plot_results(results, color="stress", view=view)
    return {**drawn, "opening.png": opening} if mesh.cuts else drawn


def _force(report: Report, across: Array) -> Any:
    """Force or torque over the motion, each of another motion in a colour of its own, and what was measured."""
    from kirigami import plot
    from kirigami.plot import style

    results, drives, scale = report.results, report.results.drives, scale_of(report.results)
    alike = [other for other in drives[1:] if other.answer_kind == report.drive.answer_kind]
    several = len(alike) > 0 or report.measured is not None
    ax = plot.plot_measure(results, report.force, x=across, label="computed" if several and not alike else None)
    if alike:
        ax.lines[-1].set_label(report.drive.takes(scale))
        for other in alike:
            plot.plot_measure(results, other.force(results), x=across, ax=ax, label=other.takes(scale))
        ax.legend()
    title = report.drive.answer if alike else report.drive.takes(scale)
    style.label_axis(ax.yaxis, title, report.drive.answer_kind, scale)
    with suppress(AnalysisError):  # no estimate of what is no sheet
        error = results.error["force"]
        ax.fill_between(
            across, report.force * (1 - error), report.force * (1 + error), color=ax.lines[0].get_color(), alpha=0.2,
            linewidth=0, label="estimated error",
        )  # fmt: skip
        ax.legend()
    loose = np.array([step.negative not in (None, 0) for step in results.steps])
    if loose.any():
        ax.plot(across[loose], report.force[loose], linestyle="none", marker="x", color="k", label="unstable")
        ax.legend()
    if report.measured is not None:
        measured, share = report.measured, report.drive.share
        look = {"linestyle": "none", "marker": "o", "markersize": 3.2, "markerfacecolor": "none", "color": "#d55e00"}
        ax.plot(share * measured.motion, measured.measured.force, label=f"measured: {measured.measured.name}", **look)
        ax.legend()
    return ax


def view_of_openings(results: Results, step: int = -1) -> tuple[float, float]:
    """The elevation and azimuth [degrees] from which most of the openings is seen, and the heights too.

    An opening seen along v shows the part A.v of its vector area A. Of sheets without cuts, or whose cuts stay shut,
    the usual view.

    Examples
    --------
    >>> from kirigami.study.report_picture import view_of_openings
    >>> import kirigami as kg
    >>> mesh = kg.TriMesh([(0, 0), (1, 0), (0, 1)], [(0, 1, 2)])
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e6))
    >>> res = kg.Results(kg.System(m))
    >>> res.append(kg.Step.at(m, 1.0, [[0, 0, 0], [0, 0, 0], [0, 0, 0.5]]))
    >>> view_of_openings(res)
    (48.0, -62.0)
    """
    mesh = results.mesh
    if mesh is None or not mesh.cuts:
        return OBLIQUE
    points = results.position()[step]
    areas = []
    for cut in mesh.cuts:
        loop = points[cut.loop] - points[cut.loop].mean(axis=0)
        areas.append(0.5 * np.cross(loop, np.roll(loop, -1, axis=0)).sum(axis=0))

    def seen(view: tuple[float, float]) -> float:
        up, round_ = np.radians(view)
        along = np.array([np.cos(up) * np.cos(round_), np.cos(up) * np.sin(round_), np.sin(up)])
        return float(np.abs(np.array(areas) @ along).sum())

    usual = seen(OBLIQUE)
    best = max(itertools.product(ELEVATIONS, AZIMUTHS), key=seen)
    return best if seen(best) > (1 + PLAIN) * usual else OBLIQUE
