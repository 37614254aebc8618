"""From a drawing to a folder with a report: read it, stretch it, write numbers, tables and pictures."""

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
from kirigami.drawing.convert import read_drawing
from kirigami.elements.stiffness import Calibration
from kirigami.errors import ConvergenceError, KirigamiError, KirigamiWarning
from kirigami.files import whole_file
from kirigami.primitives.kernel import Array
from kirigami.primitives.material import Material
from kirigami.results.results import Results
from kirigami.results.step import Event
from kirigami.study.grips import Grips, find_grips
from kirigami.study.stretch import stretch

if TYPE_CHECKING:
    from kirigami.drawing.drawing import Drawing


FOIL = 1e-5  # thickness over size below which the unit in a drawing's head cannot be meant


@dataclass
class Report:
    """What a stretched drawing gave.

    Attributes
    ----------
    results : Results
        The path.
    grips : Grips
        Where the sheet was held, and which way it was pulled.
    wanted : float
        The strain that was asked for.
    cycle : bool
        Whether the way back was asked for too.
    notes : tuple of str
        What was read, assumed, done and met.
    files : list of Path
        What was written.
    """

    results: Results
    grips: Grips
    wanted: float
    cycle: bool
    notes: tuple[str, ...]
    files: list[Path] = field(default_factory=list)

    @property
    def complete(self) -> bool:
        """Whether the whole way was gone."""
        end = 0.0 if self.cycle else 1.0
        lam = self.results.lam
        return bool(abs(lam[-1] - end) < 1e-9 and abs(lam.max() - 1.0) < 1e-9)

    @property
    def strain(self) -> Array:
        """Grip displacement over free length at each step (s,)."""
        strain: Array = self.wanted * self.results.lam
        return strain

    @property
    def force(self) -> Array:
        """Force of the moved grip along the pull at each step (s,) [N]; negative where it pushes."""
        force: Array = self.results.reaction(self.results.grips["moved"])[:, :2] @ self.grips.direction
        return force

    @property
    def numbers(self) -> dict[str, Any]:
        """What a person or a program wants to know first, in SI units."""
        results, force, mesh = self.results, self.force, self.results.mesh
        assert mesh is not None
        peak = int(np.abs(force).argmax())
        return {
            "nodes": len(mesh.nodes),
            "facets": len(mesh.triangles),
            "cuts": len(mesh.cuts),
            "strain": float(self.strain[-1]),
            "largest_strain": float(self.strain[np.abs(self.strain).argmax()]),
            "displacement": float(self.strain[-1]) * self.grips.free_length,
            "free_length": self.grips.free_length,
            "largest_force": float(force[peak]),
            "strain_at_largest_force": float(self.strain[peak]),
            "last_force": float(force[-1]),
            "height": float(results.height()[-1]),
            "open_area": float(results.open_area(union=True)[-1]) if mesh.cuts else 0.0,
            "steps": len(results),
            "stable_steps": int(results.stable.sum()),
            "largest_residual": float(np.nanmax(results.residual)),
            "factorizations": int(results.stats["factorizations"]),
            "seconds": float(results.stats["seconds"].get("total", 0.0)),
            **({} if results.shapes is None else _shapes_in_numbers(results)),
        }

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
                f"{n['factorizations']} factorizations, {n['seconds']:.1f} s"
            ),
        ]
        lines += self.results.shape_words
        if not self.complete:
            lines.append(
                f"the path ended at {100 * self.results.lam[-1]:.3g} % of the way, at a strain of "
                f"{100 * n['strain']:.4g} %: see the events"
            )
        return "\n".join(lines)


def stretch_drawing(
    drawing: Drawing | str | os.PathLike[str],
    *,
    thickness: float | str,
    E: float | str,
    nu: float = 0.34,
    strain: float | str = 0.2,
    direction: str | float = "y",
    accuracy: str = "standard",
    cycle: bool = False,
    grip: float | str | None = None,
    nodes: int | None = None,
    max_edge: float | str | None = None,
    stiffness: str | Calibration | None = None,
    imperfection: float | str | None = None,
    seed: int = 0,
    shapes: bool = False,
    progress: bool = False,
    say: Callable[[str], None] = lambda note: None,
    **reading: Any,
) -> Report:
    """Read a drawing and stretch it: :func:`kirigami.stretch` with a file in front and a report behind.

    Lengths are metres, or text with a unit ("0.1mm").

    Parameters
    ----------
    drawing : Drawing or path
        In metres, or a file; see :func:`kirigami.drawing.convert.read_drawing`.
    thickness, E : float or str
        Thickness [m] and Young's modulus [Pa].
    nu : float
        Poisson's ratio.
    strain : float or str
        Grip displacement over the free length between the grips, to be reached; negative to push.
    direction, accuracy, cycle, nodes, stiffness, seed, shapes, progress
        As for :func:`kirigami.stretch`.
    grip : float or str, optional
        Length of the strip held at each end [m]; 0 holds the edges alone. None takes 0 where the ends are straight,
        else 4 % of the length.
    max_edge : float or str, optional
        Longest edge of the mesh [m], in the place of a budget of nodes.
    imperfection : float or str, optional
        Height of the stress-free imperfection [m]; None takes the one of :func:`kirigami.stretch`.
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
    ConvergenceError
        Not even the sheet at rest was found to be in equilibrium.

    Examples
    --------
    >>> import shapely
    >>> from kirigami.drawing.drawing import Drawing
    >>> plate = Drawing(shapely.box(0, 0, 0.05, 0.1), (shapely.LineString([(0.01, 0.05), (0.04, 0.05)]),))
    >>> report = stretch_drawing(
    ...     plate, thickness="0.1mm", E="3.5GPa", strain="1%", accuracy="draft", max_edge="10mm"
    ... )
    >>> report.complete, round(report.numbers["displacement"], 9)
    (True, 0.001)
    """
    notes: list[str] = []

    def note(words: str) -> None:
        notes.append(words)
        say(words)

    thick, modulus = units.parse(thickness, "length"), units.parse(E, "stress")
    wanted = units.parse(strain, "ratio")
    if isinstance(drawing, (str, os.PathLike)):
        name, drawn = Path(drawing).stem, _read_in_metres(drawing, thick, reading, say)
    else:
        name, drawn = "sheet", drawing
    sheet = drawn.sheet(thick, Material(E=modulus, nu=nu))
    grips = find_grips(sheet, direction, _length(grip))
    for doubt in units.doubts(thickness=thick, size=max(_size(sheet.bounds)), E=modulus, strain=wanted):
        warnings.warn(doubt, KirigamiWarning, stacklevel=2)
    for words in drawn.notes:
        note(words)
    if drawn.folds:
        number = f"{len(drawn.folds)} fold{'s' if len(drawn.folds) > 1 else ''}"
        words = f"{number} of the drawing left out of the model: the sheet is stretched as if it were not creased"
        warnings.warn(words, KirigamiWarning, stacklevel=2)
        notes.append(words)
    note(f"thickness {units.show(thick, 'length')}, E {units.show(modulus, 'stress')}, nu {nu:g}")
    note(
        f"strain {units.show(wanted, 'ratio')} to reach (load factor 1), "
        f"{units.show(wanted * grips.free_length, 'length')} of grip displacement{' and back' if cycle else ''}"
    )
    try:
        results = stretch(
            sheet, wanted, direction, accuracy, cycle=cycle, grip=_length(grip), nodes=nodes,
            max_edge=_length(max_edge), stiffness=stiffness, amplitude=_length(imperfection),
            seed=seed, shapes=shapes, progress=progress, say=note,
        )  # fmt: skip
    except ConvergenceError as error:
        results = error.results
        if results is None or not len(results):
            raise
        results.events.append(Event("failed", float(results.lam[-1]), len(results) - 1, str(error)))
    results.name = name
    for event in results.events:
        note(str(event))
    return Report(results, grips, wanted, cycle, tuple(notes))


def _shapes_in_numbers(results: Results) -> dict[str, Any]:
    """Which of the known shapes the end is, and what they need; number 0 for none of them."""
    study = results.shapes
    shape = study.which(results.steps[int(np.abs(results.lam).argmax())])
    return {
        "shape": 0 if shape is None else shape.number,
        "shape_energies": [one.energy for one in study],
        "shape_forces": [one.force for one in study],
    }


def _length(value: float | str | None) -> float | None:
    return None if value is None else units.parse(value, "length")


def _size(bounds: tuple[float, float, float, float]) -> tuple[float, float]:
    xmin, ymin, xmax, ymax = bounds
    return xmax - xmin, ymax - ymin


def write_report(report: Report, folder: str | os.PathLike[str], say: Callable[[str], None] = print) -> list[Path]:
    """Write all files of a stretched drawing into a folder; parts whose library is missing are skipped with a word.

    ``report.json``, ``curves.csv``, ``results.npz``, ``rest.png``, ``deformed.png``, ``above.png``, ``force.png``,
    ``opening.png`` of a sheet with cuts, ``page.html``, and ``vtk/`` for ParaView; ``shapes.csv`` and ``shapes.png``
    where other shapes were looked for.

    Parameters
    ----------
    report : Report
        From :func:`stretch_drawing`.
    folder : path
        Where to; made if it is missing.
    say : callable
        Where words go.

    Examples
    --------
    >>> import shapely, tempfile
    >>> from kirigami.drawing.drawing import Drawing
    >>> plate = Drawing(shapely.box(0, 0, 0.05, 0.1), ())
    >>> report = stretch_drawing(plate, thickness="0.1mm", E="3.5GPa", strain="0.1%", max_edge="25mm", imperfection=0)
    >>> files = write_report(report, tempfile.mkdtemp(), say=lambda words: None)
    >>> "report.json" in [file.name for file in files]
    True
    """
    from kirigami.io.table import to_csv
    from kirigami.study.report_picture import write_pictures

    target, results = Path(folder), report.results
    files = [target / "report.json", target / "curves.csv", target / "results.npz"]
    with whole_file(files[0]) as unfinished:
        content = {"complete": report.complete, "numbers": report.numbers, "notes": list(report.notes)}
        unfinished.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    to_csv(results, files[1])
    results.save(files[2])
    files += write_pictures(report, target)
    if results.shapes is not None:
        results.shapes.table(target / "shapes.csv")
        with whole_file(target / "shapes.png") as unfinished:
            results.shapes.plot().savefig(unfinished, dpi=160)
        files += [target / "shapes.csv", target / "shapes.png"]

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


def _read_in_metres(path: Any, thickness: float, reading: dict[str, Any], say: Callable[[str], None]) -> Drawing:
    """The drawing in metres; where its head says metres and no sheet can be so large and thin, taken as millimetres.

    Libraries write metres into a drawing's head unless they are told otherwise.
    """
    drawn = read_drawing(path, **{**reading, "unit": "m"})
    size = max(_size(drawn.outline.bounds))
    if "drawn_in" in reading or "drawn in m, converted to m" not in drawn.notes or thickness > FOIL * size:
        return drawn
    words = (
        f"the head of the drawing says metres, which makes a sheet of {size:.6g} m and "
        f"{units.show(thickness, 'length')}: taken as millimetres; --drawn-in m takes it at its word"
    )
    warnings.warn(words, KirigamiWarning, stacklevel=3)
    say(words)
    return read_drawing(path, **{**reading, "unit": "m", "drawn_in": "mm"})
