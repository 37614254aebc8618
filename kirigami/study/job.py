"""A whole job on a drawing as one plain description, which a small JSON file keeps: run it again, or change it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kirigami import units
from kirigami.elements.stiffness import Calibration, rung_named
from kirigami.errors import ModelError
from kirigami.files import read_json, whole_file
from kirigami.primitives.checks import (
    require_between,
    require_boolean,
    require_choice,
    require_finite,
    require_instance,
    require_mapping,
    require_not_negative,
    require_path,
    require_whole,
    shown,
)
from kirigami.study.load_case import LoadCase
from kirigami.study.stretch import ACCURACY

if TYPE_CHECKING:
    from kirigami.drawing.drawing import Drawing
    from kirigami.study.report import Report

KIND = "kirigami case"
PARTS = {
    "sheet": ("thickness", "E", "nu", "density", "fold_stiffness", "fold_angle"),
    "computation": ("accuracy", "nodes", "max_edge", "stiffness", "imperfection", "seed", "shapes"),
}
QUANTITIES = {
    "thickness": "length", "E": "stress", "density": "density", "max_edge": "length", "imperfection": "length",
}  # fmt: skip
OF_REGIONS = {"thickness": "length", "E": "stress", "nu": "ratio", "density": "density"}


@dataclass(frozen=True, eq=False)
class Job:
    """A drawing, what it is made of, what is done to it, and how it is computed.

    Lengths and stresses are SI, or text with a unit ("0.1mm").

    Attributes
    ----------
    drawing : Drawing or path
        In metres, or a file.
    thickness, E : float or str
        Thickness [m] and Young's modulus [Pa].
    nu : float
        Poisson's ratio.
    case : LoadCase
        What is done, lengths in metres.
    accuracy, nodes, stiffness, seed, shapes
        As for :func:`kirigami.stretch`.
    max_edge, imperfection : float or str, optional
        Longest edge of the mesh and height of the stress-free imperfection [m].
    reading : dict
        Options of the reader of the drawing.
    fold_stiffness : float or str, optional
        Moment per angle and length of the folds of the drawing [N / rad]; None takes that of :class:`kirigami.Fold`.
    fold_angle : float
        Angle at which they rest [degrees]; see :meth:`kirigami.drawing.drawing.Drawing.sheet`.
    density : float or str, optional
        Of the material [kg / m^3], for its weight.
    regions : dict of str to dict
        What is different in regions of the sheet: by the name of a layer or colour of the drawing, whose closed curves
        bound them, some of "thickness", "E", "nu" and "density".

    Examples
    --------
    >>> from pathlib import Path
    >>> import shapely, tempfile, kirigami as kg
    >>> folder = Path(tempfile.mkdtemp())
    >>> drawing = kg.Sheet(shapely.box(0, 0, 0.05, 0.1)).to_geojson(folder / "plate.geojson")
    >>> pull = kg.LoadCase(strain=0.001)
    >>> job = kg.study.Job(drawing, "0.1mm", "3.5GPa", case=pull, accuracy="draft", max_edge="25mm")
    >>> again = kg.study.Job.load(job.save(folder / "case.json"))
    >>> again.run().complete
    True
    """

    drawing: Drawing | str | os.PathLike[str]
    thickness: float | str
    E: float | str
    nu: float = 0.34
    case: LoadCase = field(default_factory=LoadCase)
    accuracy: str = "standard"
    nodes: int | None = None
    max_edge: float | str | None = None
    stiffness: str | Calibration | None = None
    imperfection: float | str | None = None
    seed: int = 0
    shapes: bool = False
    reading: dict[str, Any] = field(default_factory=dict)
    fold_stiffness: float | str | None = None
    fold_angle: float = 0.0
    density: float | str | None = None
    regions: dict[str, dict[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not hasattr(self.drawing, "outline"):
            require_path(self.drawing, "drawing", "Job")
        require_instance(self.case, LoadCase, "case", "Job")
        if self.stiffness is not None and not isinstance(self.stiffness, Calibration):
            rung_named(self.stiffness, "Job")
        require_choice(self.accuracy, ACCURACY, "accuracy", "Job")
        require_mapping(self.reading, "reading", "Job")
        for name, kind in QUANTITIES.items():
            if (value := getattr(self, name)) is not None or name in ("thickness", "E"):
                units.parse(value, kind)
        for name, values in require_mapping(self.regions, "regions", "Job").items():
            require_mapping(values, f"region {name!r}", "Job")
            for key, value in values.items():
                if key not in OF_REGIONS:
                    raise ModelError(f"Job: region {name!r} takes {', '.join(OF_REGIONS)}, not {key!r}")
                try:
                    units.parse(value, OF_REGIONS[key])
                except ModelError as error:
                    raise ModelError(f"Job: {key} of region {name!r}: {error}") from None
        if self.fold_stiffness is not None:
            require_not_negative(units.parse(self.fold_stiffness, "force"), "fold_stiffness", "Job")
        require_between(self.fold_angle, -180.0, 180.0, "fold_angle", "Job")
        require_finite(self.nu, "nu", "Job")
        if self.nodes is not None:
            require_whole(self.nodes, "nodes", "Job", least=1)
        require_whole(self.seed, "seed", "Job")
        require_boolean(self.shapes, "shapes", "Job")

    def run(self, progress: bool = False, say: Callable[[str], None] = lambda note: None) -> Report:
        """Read the drawing, stretch it and report; see :func:`kirigami.study.stretch_drawing`.

        Parameters
        ----------
        progress : bool
            Show a progress bar.
        say : callable
            Called with each note as soon as it is known.
        """
        from kirigami.study.run_job import run_job

        return run_job(self, progress, say)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the job to a case file; the drawing is named by its way from there.

        Raises
        ------
        ModelError
            A drawing without a file, or a place or a stiffness without a name.
        KirigamiError
            The file cannot be written.
        """
        target = require_path(path, "path", "Job.save")
        if not isinstance(self.drawing, (str, os.PathLike)):
            raise ModelError("Job.save: the drawing was made by hand: write it to a file, and give that")
        if isinstance(self.stiffness, Calibration):
            raise ModelError("Job.save: a case file keeps a stiffness by its name only")
        drawing = Path(os.path.relpath(Path(self.drawing).resolve(), target.resolve().parent))
        content: dict[str, Any] = {"kind": KIND, "drawing": drawing.as_posix()}
        for part, names in PARTS.items():
            own = {name: getattr(self, name) for name in names}
            content[part] = {name: value for name, value in own.items() if value is not None and value is not False}
        content["case"] = self.case.plain()
        if self.regions:
            content["regions"] = self.regions
        if self.reading:
            content["reading"] = self.reading
        with whole_file(target) as unfinished:
            unfinished.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
        return target

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Job:
        """Read a case file.

        Raises
        ------
        GeometryError
            There is no such file, or it is no JSON.
        ModelError
            It is no case file, or an entry is missing, unknown or wrong.
        """
        source = require_path(path, "path", "Job.load")
        values = read_case(source)
        missing = [name for name in ("thickness", "E") if name not in values]
        if missing:
            raise ModelError(f"{source}: the case says no {missing[0]}")
        try:
            return cls(**values)
        except ModelError as error:
            raise ModelError(f"{source}: {error}") from None


def is_case(path: Path) -> bool:
    """Whether a file is a case file."""
    if path.suffix.lower() != ".json" or not path.is_file():
        return False
    content = read_json(path, "case")
    return isinstance(content, dict) and content.get("kind") == KIND


def read_case(path: Path) -> dict[str, Any]:
    """The arguments of a :class:`Job` that a case file holds, some of which may be missing."""
    content = read_json(path, "case")
    if not isinstance(content, dict) or content.get("kind") != KIND or not isinstance(content.get("drawing"), str):
        raise ModelError(f"{path} is no case file: it must say \"kind\": \"{KIND}\" and name a drawing")
    known = ("kind", "drawing", *PARTS, "regions", "case", "reading")
    unknown = [name for name in content if name not in known]
    if unknown:
        raise ModelError(f"{path}: a case file has no entry {unknown[0]!r}: it has {', '.join(known)}")
    values: dict[str, Any] = {"drawing": path.parent / content["drawing"]}
    for part, names in PARTS.items():
        entries = content.get(part, {})
        if not isinstance(entries, dict) or not set(entries) <= set(names):
            raise ModelError(f"{path}: {part!r} takes {', '.join(names)}, got {shown(entries)}")
        values |= entries
    if "regions" in content:
        values["regions"] = content["regions"]
    reading = content.get("reading", {})
    if not isinstance(reading, dict) or not all(isinstance(name, str) for name in reading):
        raise ModelError(f"{path}: 'reading' takes options of the reader, got {shown(reading)}")
    try:
        return {**values, "reading": reading, "case": LoadCase.from_plain(content.get("case", {}))}
    except ModelError as error:
        raise ModelError(f"{path}: {error}") from None


NAMES = tuple(item.name for item in fields(Job))
