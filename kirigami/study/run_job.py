"""The job behind `kirigami stretch`: read a drawing, do what its case says, and report."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kirigami import units
from kirigami.drawing.convert import read_drawing
from kirigami.drawing.roles import listed
from kirigami.elements.crease import SCORE
from kirigami.elements.stiffness import Calibration
from kirigami.errors import ConvergenceError, KirigamiWarning, ModelError
from kirigami.primitives.checks import require_positive
from kirigami.primitives.material import Material
from kirigami.results.step import Event
from kirigami.scale import Scale
from kirigami.study.job import OF_REGIONS, Job
from kirigami.study.load_case import STRAIN, LoadCase
from kirigami.study.report import Report
from kirigami.study.setting import set_up
from kirigami.study.stretch import stretch
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.drawing.drawing import Drawing
    from kirigami.geometry.sheet import Sheet

FOIL = 1e-5  # thickness over size below which the unit in a drawing's head cannot be meant


def stretch_drawing(
    drawing: Drawing | str | os.PathLike[str],
    *,
    thickness: float | str,
    E: float | str,
    nu: float = 0.34,
    strain: float | str = STRAIN,
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
    case: LoadCase | None = None,
    fold_stiffness: float | str | None = None,
    fold_angle: float = 0.0,
    regions: dict[str, dict[str, Any]] | None = None,
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
    case : LoadCase, optional
        Everything that is done to the sheet, in the place of strain, direction, cycle and grip; lengths in metres.
    fold_stiffness : float or str, optional
        Moment per angle and length of the folds [N / rad]; None takes that of :class:`kirigami.Fold`.
    fold_angle : float
        Angle at which the folds rest [degrees]; see :meth:`kirigami.drawing.drawing.Drawing.sheet`.
    regions : dict of str to dict, optional
        What is different in regions, by the layers or colours that bound them, such as
        ``{"stiff": {"thickness": "0.3mm", "E": "70GPa"}}``.
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
    >>> import kirigami as kg
    >>> import shapely
    >>> from kirigami.drawing.drawing import Drawing
    >>> plate = Drawing(shapely.box(0, 0, 0.05, 0.1), (shapely.LineString([(0.01, 0.05), (0.04, 0.05)]),))
    >>> report = kg.study.stretch_drawing(
    ...     plate, thickness="0.1mm", E="3.5GPa", strain="1%", accuracy="draft", max_edge="10mm"
    ... )
    >>> report.complete, round(report.numbers["displacement"], 9)
    (True, 0.001)
    """
    if case is None:
        case = LoadCase(units.parse(strain, "ratio"), direction, _length(grip), cycle=cycle)
    job = Job(
        drawing, thickness, E, nu, case, accuracy, nodes, max_edge, stiffness, imperfection, seed, shapes, reading,
        fold_stiffness, fold_angle, regions={} if regions is None else regions,
    )  # fmt: skip
    return run_job(job, progress, say)


def run_job(job: Job, progress: bool, say: Callable[[str], None]) -> Report:
    """Read the drawing of a job, do what its case says, and report; see :func:`stretch_drawing`."""
    notes: list[str] = []

    def note(words: str) -> None:
        notes.append(words)
        say(words)

    thick, modulus = units.parse(job.thickness, "length"), units.parse(job.E, "stress")
    density = None if job.density is None else units.parse(job.density, "density")
    if isinstance(job.drawing, (str, os.PathLike)):
        name, drawn = Path(job.drawing).stem, _read_in_metres(job.drawing, thick, _with_marks(job), say)
    else:
        name, drawn = "sheet", job.drawing
    case = job.case.in_drawing(drawn.layers) if any(where.kind == "layer" for where in job.case.places) else job.case
    stiffness = None if job.fold_stiffness is None else units.parse(job.fold_stiffness, "force")
    angle = math.radians(job.fold_angle)
    material = Material(E=modulus, nu=job.nu, density=density)
    of_regions = _of_regions(job, thick, material)
    sheet = drawn.sheet(thick, material, fold_stiffness=stiffness, fold_angle=angle)
    setting = set_up(case, sheet)
    grips, drive = setting.grips, setting.drives[0]
    for doubt in units.doubts(
        thickness=thick, size=max(_size(sheet.bounds)), E=modulus, strain=case.strain,
        imperfection=_length(job.imperfection) or 0.0,
    ):  # fmt: skip
        warnings.warn(doubt, KirigamiWarning, stacklevel=2)
    for words in drawn.notes:
        note(words)
    if sheet.folds:
        note(_folds_in_words(sheet, thick, modulus, job.nu))
    note(f"thickness {units.show(thick, 'length')}, E {units.show(modulus, 'stress')}, nu {job.nu:g}")
    for region, made in job.regions.items():
        note(f"region {region!r}: {', '.join(f'{key} {value}' for key, value in made.items()) or 'as the rest'}")
    if case.weight and case.moves:
        note(f"under its own weight from the start, g = {case.weight:g} m/s2")
    back = " and back" if case.cycle else ""
    scale = Scale.of(max(_size(sheet.bounds)))
    for drive in setting.drives:
        whole = drive.says(1.0, scale)
        if grips is not None and drive.kind == "ratio":
            by = scale.show(drive.whole * grips.free_length, "length", 6)
            note(f"{drive.motion} {whole} to reach (load factor 1), {by} of grip displacement{back}")
        elif drive.motion == "weight":
            note(f"its own weight, g = {case.weight:g} m/s2, to bear (load factor 1){back}")
        elif drive.motion == "lift":
            note(f"{drive.named(scale)} {whole} (load factor 1){back}")
        else:
            note(f"{drive.motion} {whole} to reach (load factor 1){back}")
    try:
        results = stretch(
            sheet, accuracy=job.accuracy, nodes=job.nodes, max_edge=_length(job.max_edge), stiffness=job.stiffness,
            amplitude=_length(job.imperfection), seed=job.seed, shapes=job.shapes, case=case, progress=progress,
            say=note, **of_regions,
        )  # fmt: skip
    except ConvergenceError as error:
        results = error.results
        if results is None or not len(results):
            raise
        results.events.append(Event("failed", float(results.lam[-1]), len(results) - 1, str(error)))
    results.name, results.units = name, "SI"
    for event in results.events:
        note(str(event))
    return Report(results, job, tuple(notes), None if grips is None else grips.free_length)


def _folds_in_words(sheet: Sheet, thickness: float, modulus: float, nu: float) -> str:
    """How the folds of a sheet are taken."""
    count = len(sheet.folds)
    valleys, mountains = (sum(side * fold.angle > 0 for fold in sheet.folds) for side in (1, -1))
    rest = "at rest flat"
    if valleys or mountains:
        largest = math.degrees(max(abs(fold.angle) for fold in sheet.folds))
        ways = f"{counted(valleys, 'as valley')} and {counted(mountains, 'as mountain')}"
        rest = f"at rest folded by up to {counted(largest, 'degree', spec='.4g')}, {ways}"
    words = f"{counted(count, 'fold as elastic hinge', 'folds as elastic hinges')}, {rest}; "
    given = sheet.folds[0].stiffness
    if given is None:
        usual = units.show(modulus * thickness**2 / (12 * (1 - nu**2) * SCORE), "force")
        return f"{words}moment per length {usual} per radian, that of a light score; `fold_stiffness` says another"
    return f"{words}moment per length {units.show(given, 'force')} per radian"


def _with_marks(job: Job) -> dict[str, Any]:
    """The options of the reader, which takes the regions that have something of their own as such, and leaves out the
    layers that are but places of the case."""
    asked = dict(job.reading)
    roles = ("outline", "cuts", "folds", "ignore", "regions")
    told = {name.casefold() for key in roles for name in listed(asked.get(key))}
    more = [name for name in job.regions if name.casefold() not in told]
    if more:
        asked["regions"] = [*listed(asked.get("regions")), *more]
    told |= {name.casefold() for name in more}
    marks = [where.name for where in job.case.places if where.kind == "layer"]
    more = [name for name in dict.fromkeys(marks) if name.casefold() not in told]
    if more:
        asked["ignore"] = [*listed(asked.get("ignore")), *more]
    return asked


def _of_regions(job: Job, thickness: float, material: Material) -> dict[str, Any]:
    """Thickness and material of the rest of the sheet and of its regions, as :func:`stretch` takes them."""
    if not job.regions:
        return {}
    heights: dict[str | None, float] = {None: thickness}
    materials: dict[str | None, Material] = {None: material}
    for name, given in job.regions.items():
        values = {key: units.parse(value, OF_REGIONS[key]) for key, value in given.items()}
        try:
            heights[name] = require_positive(values.pop("thickness", thickness), "thickness", "the sheet")
            materials[name] = replace(material, **values)
        except ModelError as error:
            raise ModelError(f"region {name!r}: {error}") from None
    return {"thickness": heights, "material": materials}


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


def _length(value: float | str | None) -> float | None:
    return None if value is None else units.parse(value, "length")


def _size(bounds: tuple[float, float, float, float]) -> tuple[float, float]:
    xmin, ymin, xmax, ymax = bounds
    return xmax - xmin, ymax - ymin
