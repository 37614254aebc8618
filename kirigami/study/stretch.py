"""The whole job on a drawing: read, mesh, clamp, stretch, report. The command line is a thin layer over this."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami import units
from kirigami.analysis.eigen import Eigen
from kirigami.analysis.path.methods import DisplacementControl
from kirigami.drawing.convert import read_drawing
from kirigami.errors import AnalysisError, KirigamiError, KirigamiWarning, ModelError
from kirigami.files import whole_file
from kirigami.geometry.mesh import TriMesh
from kirigami.geometry.sheet import Sheet
from kirigami.io.convert import edge_for
from kirigami.model.constraints import Fix, Prescribe
from kirigami.model.model import Model
from kirigami.primitives.material import Material
from kirigami.primitives.node import Node
from kirigami.results.results import Results

if TYPE_CHECKING:
    from kirigami.drawing.drawing import Drawing

SIDES = {"x": ("left", "right"), "y": ("bottom", "top")}
GRIP = 0.04  # of the length, where the end of a sheet is no straight edge to hold
STRAIGHT = 0.2  # of the width: what counts as a straight edge


@dataclass
class Report:
    """What a stretched drawing gave.

    Attributes
    ----------
    results : Results
        The path.
    numbers : dict
        What a person or a program wants to know first, in SI units.
    notes : tuple of str
        What was read, assumed and done.
    direction : {"y", "x"}
        Direction of the pull.
    files : list of Path
        What was written.
    """

    results: Results
    numbers: dict[str, Any]
    notes: tuple[str, ...]
    direction: str = "y"
    files: list[Path] = field(default_factory=list)

    @property
    def complete(self) -> bool:
        """Whether the whole strain was reached."""
        return bool(abs(self.results.lam[-1] - 1.0) < 1e-9)

    def text(self) -> str:
        """The numbers as lines."""
        n = self.numbers
        lines = [
            f"nodes {n['nodes']}, facets {n['facets']}, cuts {n['cuts']}",
            (
                f"strain {100 * n['strain']:.4g} % = {units.show(n['displacement'], 'length')} of grip displacement / "
                f"{units.show(n['free_length'], 'length')} between the grips"
            ),
            (
                f"largest force {n['largest_force']:.4g} N at strain {100 * n['strain_at_largest_force']:.4g} %, "
                f"last {n['last_force']:.4g} N"
            ),
            f"height {units.show(n['height'], 'length')}, open area {n['open_area']:.4g} m2",
            (
                f"{n['steps']} steps, {n['stable_steps']} stable, largest residual {n['largest_residual']:.1e}, "
                f"{n['seconds']:.1f} s"
            ),
        ]
        if not self.complete:
            lines.append(f"the path ended at {100 * self.results.lam[-1]:.3g} % of the way: see the events")
        return "\n".join(lines)


def stretch(
    drawing: Drawing | str | os.PathLike[str],
    *,
    thickness: float | str,
    E: float | str,
    nu: float = 0.34,
    strain: float | str = 0.2,
    direction: str = "y",
    grip: float | str | None = None,
    max_edge: float | str | None = None,
    imperfection: float | str | None = None,
    progress: bool = False,
    say: Callable[[str], None] = lambda note: None,
    **reading: Any,
) -> Report:
    """Read a drawing, clamp its two ends, pull one of them, and follow the sheet.

    Lengths are metres, or text with a unit ("0.1mm"). The ends that are held are the straight edges of the outline at
    its two extremes, or strips of the given grip length there; the grip that is pulled keeps its shape.

    Parameters
    ----------
    drawing : Drawing or path
        In metres, or a file; see :func:`kirigami.drawing.convert.read_drawing`.
    thickness, E : float or str
        Thickness [m] and Young's modulus [Pa].
    nu : float
        Poisson's ratio.
    strain : float or str
        Grip displacement over the free length between the grips, to be reached.
    direction : {"y", "x"}
        Direction of the pull.
    grip : float or str, optional
        Length of the strip held at each end [m]; 0 holds the edges alone. None takes 0 where the ends are straight,
        else 4 % of the length.
    max_edge : float or str, optional
        Largest edge of the mesh [m]; None aims at about 4,000 facets.
    imperfection : float or str, optional
        Height of the stress-free imperfection, the softest mode of the held sheet [m]; None takes the thickness.
    progress : bool
        Show a progress bar.
    say : callable
        Called with each note as soon as it is known, so that a slip shows before the path is followed.
    **reading
        Options of the reader of the drawing.

    Returns
    -------
    Report
        Also where the path ended early; ``report.complete`` tells.

    Raises
    ------
    GeometryError
        The drawing cannot be read or meshed.
    ModelError
        A quantity is wrong.
    AnalysisError
        Not even the sheet at rest was found to be in equilibrium.

    Examples
    --------
    >>> import shapely
    >>> from kirigami.drawing.drawing import Drawing
    >>> plate = Drawing(shapely.box(0, 0, 0.05, 0.1), (shapely.LineString([(0.01, 0.05), (0.04, 0.05)]),))
    >>> report = stretch(plate, thickness="0.1mm", E="3.5GPa", strain="1%", max_edge="10mm")
    >>> report.complete, round(report.numbers["displacement"], 9)
    (True, 0.001)
    """
    if direction not in SIDES:
        raise ModelError(f"direction must be 'x' or 'y', got {direction!r}")
    thick, modulus = units.parse(thickness, "length"), units.parse(E, "stress")
    wanted = units.parse(strain, "ratio")
    if not wanted or not np.isfinite(wanted):
        raise ModelError(f"strain must be a finite number other than zero, got {strain!r}")
    if isinstance(drawing, (str, os.PathLike)):
        name, drawn = Path(drawing).stem, read_drawing(drawing, **{**reading, "unit": "m"})
    else:
        name, drawn = "sheet", drawing
    sheet = drawn.sheet(thick, Material(E=modulus, nu=nu))
    xmin, ymin, xmax, ymax = sheet.bounds
    length, width = (ymax - ymin, xmax - xmin) if direction == "y" else (xmax - xmin, ymax - ymin)
    for doubt in units.doubts(thickness=thick, size=max(length, width), E=modulus, strain=wanted):
        warnings.warn(doubt, KirigamiWarning, stacklevel=2)
    held = _grip(grip, sheet, direction, length, width)
    edge = edge_for(sheet, max_edge)
    pull = wanted * (length - 2 * held)
    bump = thick if imperfection is None else units.parse(imperfection, "length")
    grips = f"strips of {units.show(held, 'length')}" if held else "edges"
    notes = (
        *drawn.notes,
        f"thickness {units.show(thick, 'length')}, E {units.show(modulus, 'stress')}, nu {nu:g}",
        f"{grips} held at the {' and '.join(SIDES[direction])}",
        f"strain {units.show(wanted, 'ratio')} to reach, {units.show(pull, 'length')} of grip displacement",
        f"mesh edges up to {units.show(edge, 'length')}, imperfection {units.show(bump, 'length')} (softest mode)",
    )
    for note in notes:
        say(note)
    model, high = held_model(sheet, edge, direction, held, pull, bump)
    model.name = name
    targets = [0.002, 0.005, 0.01, 0.02, 0.05, *np.linspace(0.1, 1.0, 10).tolist()]
    results = DisplacementControl(model, targets=targets).run(progress=progress, on_failure="return")
    events = tuple(str(event) for event in results.events)
    if not len(results):
        raise AnalysisError("\n".join(events), results=results)
    for event in events:
        say(event)
    assert model.mesh is not None
    numbers = _numbers(results, model.mesh, high, direction, pull, length - 2 * held)
    return Report(results, numbers, notes + events, direction)


def pulled_sheet(
    sheet: Sheet, max_edge: float, direction: str, strain: float, stiffness: str = "plate"
) -> tuple[Model, list[Node]]:
    """Model of a sheet clamped at its two ends and to be pulled by a strain, and the nodes that are pulled.

    Ends and imperfection as in :func:`stretch`: straight edges or strips of 4 % of the length; the softest mode, one
    thickness high.
    """
    xmin, ymin, xmax, ymax = sheet.bounds
    length, width = (ymax - ymin, xmax - xmin) if direction == "y" else (xmax - xmin, ymax - ymin)
    held = _grip(None, sheet, direction, length, width)
    if sheet.thickness is None:
        raise ModelError("the sheet has no thickness: give one to the Sheet")
    pull = strain * (length - 2 * held)
    return held_model(sheet, max_edge, direction, held, pull, sheet.thickness, stiffness)


def held_model(
    sheet: Sheet, edge: float, direction: str, held: float, pull: float, bump: float, stiffness: str = "plate"
) -> tuple[Model, list[Node]]:
    """Model of a sheet held at both ends and driven at the upper or right one, and the nodes that are driven.

    The imperfection is the softest mode of the held sheet, `bump` high.
    """
    mesh = sheet.mesh(edge, lines=_grip_lines(sheet.bounds, direction, held))
    model = Model.from_mesh(mesh, stiffness=stiffness)
    high = _hold(model, direction, held, pull)
    if bump:
        model.perturb(Eigen(model, n=1).run()[0], amplitude=bump)
    return model, high


def _grip(grip: float | str | None, sheet: Sheet, direction: str, length: float, width: float) -> float:
    if grip is not None:
        held = units.parse(grip, "length")
        if not 0 <= held < 0.45 * length:
            raise ModelError(f"the grips of {units.show(held, 'length')} do not leave a free length in the sheet of "
                             f"{units.show(length, 'length')}")  # fmt: skip
        return held
    axis = "xy".index(direction)
    points = np.asarray(sheet.outline.exterior.coords)
    for end in (points[:, axis].min(), points[:, axis].max()):
        at_end = np.abs(points[:, axis] - end) <= 1e-9 * length
        along = points[at_end, 1 - axis]
        if np.ptp(along) < STRAIGHT * width:
            return GRIP * length
    return 0.0


def _grip_lines(bounds: tuple[float, float, float, float], direction: str, held: float) -> dict[str, Any]:
    """Lines of mesh edges at the inner ends of the grips."""
    from shapely import LineString

    if not held:
        return {}
    xmin, ymin, xmax, ymax = bounds
    if direction == "y":
        return {f"grip {k}": LineString([(xmin, y), (xmax, y)]) for k, y in enumerate((ymin + held, ymax - held))}
    return {f"grip {k}": LineString([(x, ymin), (x, ymax)]) for k, x in enumerate((xmin + held, xmax - held))}


def _hold(model: Model, direction: str, held: float, pull: float) -> list[Node]:
    """Add the supports; returns the nodes that are pulled."""
    assert model.mesh is not None
    axis = "xy".index(direction)
    coordinate = model.mesh.nodes[:, axis]
    slack = 1e-9 * model.mesh.size
    low = model.select(index=np.flatnonzero(coordinate <= coordinate.min() + held + slack))
    high = model.select(index=np.flatnonzero(coordinate >= coordinate.max() - held - slack))
    others = "xz" if direction == "y" else "yz"
    drive = Prescribe(high, y=pull) if direction == "y" else Prescribe(high, x=pull)
    model.add(Fix(low, clamp=True), Fix(high, others, clamp=True), drive)
    return high


def _numbers(
    results: Results, mesh: TriMesh, high: list[Node], direction: str, pull: float, free: float
) -> dict[str, Any]:
    force = results.reaction(high, direction)
    peak = int(np.abs(force).argmax())
    last = float(results.lam[-1])
    return {
        "nodes": len(mesh.nodes),
        "facets": len(mesh.triangles),
        "cuts": len(mesh.cuts),
        "strain": last * pull / free,
        "displacement": last * pull,
        "free_length": free,
        "largest_force": float(force[peak]),
        "strain_at_largest_force": float(results.lam[peak]) * pull / free,
        "last_force": float(force[-1]),
        "height": float(results.height()[-1]),
        "open_area": float(results.open_area(union=True)[-1]) if mesh.cuts else 0.0,
        "steps": len(results),
        "stable_steps": int(results.stable.sum()),
        "largest_residual": float(np.nanmax(results.residual)),
        "seconds": float(results.stats["seconds"].get("total", 0.0)),
    }


def write_report(report: Report, folder: str | os.PathLike[str], say: Callable[[str], None] = print) -> list[Path]:
    """Write all files of a stretched drawing into a folder; parts whose library is missing are skipped with a word.

    ``report.json``, ``curves.csv``, ``results.npz``, ``rest.png``, ``deformed.png``, ``force.png``, ``page.html``, and
    ``vtk/`` for ParaView.

    Parameters
    ----------
    report : Report
        From :func:`stretch`.
    folder : path
        Where to; made if it is missing.
    say : callable
        Where words go.

    Examples
    --------
    >>> import shapely, tempfile
    >>> from kirigami.drawing.drawing import Drawing
    >>> plate = Drawing(shapely.box(0, 0, 0.05, 0.1), ())
    >>> report = stretch(plate, thickness="0.1mm", E="3.5GPa", strain="0.1%", max_edge="25mm", imperfection=0)
    >>> files = write_report(report, tempfile.mkdtemp(), say=lambda words: None)
    >>> "report.json" in [file.name for file in files]
    True
    """
    from kirigami.io.table import to_csv

    target, results = Path(folder), report.results
    files = [target / "report.json", target / "curves.csv", target / "results.npz"]
    with whole_file(files[0]) as unfinished:
        content = {"complete": report.complete, "numbers": report.numbers, "notes": list(report.notes)}
        unfinished.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    to_csv(results, files[1])
    results.save(files[2])
    files += _pictures(results, target, report.direction)

    def page() -> list[Path]:
        from kirigami.io.html import to_html

        return [to_html(results, target / "page.html")]

    for write in (page, lambda: results.to_vtk(target / "vtk")):
        try:
            files += write()
        except KirigamiError as error:
            say(f"left out: {error}")
    report.files = files
    return files


def _pictures(results: Results, folder: Path, direction: str) -> list[Path]:
    from matplotlib import pyplot

    from kirigami import plot

    pictures: dict[str, Callable[[], Any]] = {
        "rest.png": lambda: plot.plot_model(results.model),
        "deformed.png": lambda: plot.plot_results(results),
        "force.png": lambda: plot.plot_curve(results, results.node_index("driven_0"), direction),
    }
    files = []
    for name, draw in pictures.items():
        figure = draw().figure
        with whole_file(folder / name) as unfinished:
            figure.savefig(unfinished, dpi=160)
        pyplot.close(figure)
        files.append(folder / name)
    return files
