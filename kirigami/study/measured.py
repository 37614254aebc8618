"""A measured curve against a computed one: a CSV file of displacement or strain and force, with units in its head."""

from __future__ import annotations

import csv
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami import units
from kirigami.errors import GeometryError, ModelError
from kirigami.primitives.checks import require_path
from kirigami.primitives.kernel import Array
from kirigami.scale import Scale
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.study.report import Report

MOTIONS = {
    "displacement": ("displacement", "extension", "elongation", "travel", "crosshead", "stroke", "position", "lift"),
    "strain": ("strain", "shear"),
    "angle": ("angle", "twist", "rotation"),
}
FORCES = ("force", "load", "torque", "moment")
ANGLES = {"deg": 1.0, "degrees": 1.0, "degree": 1.0, "°": 1.0, "rad": 180.0 / np.pi}
HEAD = "such as 'displacement [mm],force [N]'"


@dataclass(frozen=True, eq=False)
class Measured:
    """A curve as it was measured.

    Attributes
    ----------
    kind : str
        What it is drawn over: "displacement" [m], "strain" or "angle" [degrees].
    motion, force : ndarray, shape (k,)
        Its points, in SI units.
    name : str
        Of the file.
    """

    kind: str
    motion: Array
    force: Array
    name: str


@dataclass(frozen=True, eq=False)
class Comparison:
    """How far a measured curve lies from the computed one.

    Attributes
    ----------
    measured : Measured
        The curve; its motion in what the report counts.
    motion : ndarray, shape (k,)
        Its motion, as the report counts it.
    rms : float
        Root mean square difference of the force over the points within the computed range [N, N m].
    share : float
        The same over the root mean square of the measured force there.
    beyond : int
        Points beyond the computed range, which are left out.
    """

    measured: Measured
    motion: Array
    rms: float
    share: float
    beyond: int

    @property
    def numbers(self) -> dict[str, Any]:
        """For the report."""
        return {
            "measured_points": len(self.motion), "measured_points_beyond": self.beyond,
            "rms_difference": self.rms, "rms_difference_share": self.share,
        }  # fmt: skip

    def __str__(self) -> str:
        return difference_in_words(self, Scale("m"))


def difference_in_words(found: Comparison, scale: Scale) -> str:
    """How far a measured curve lies from the computed one, in the units of a report."""
    left = f", {found.beyond} beyond what was computed left out" if found.beyond else ""
    return (
        f"measured curve {found.measured.name}: RMS difference "
        f"{scale.show(found.rms, 'torque' if found.measured.kind == 'angle' else 'force')}, "
        f"{100 * found.share:.3g} % of the measured force, over "
        f"{counted(len(found.motion) - found.beyond, 'point')}{left}"
    )


def read_measured(path: str | os.PathLike[str]) -> Measured:
    """Read a measured curve.

    Parameters
    ----------
    path : path
        A CSV file: a head that names a column of displacement, strain or angle and one of force or torque, with their
        units, such as ``displacement [mm],force [N]``; columns parted by commas, semicolons or tabs. Other columns are
        left out.

    Raises
    ------
    GeometryError
        No such file, no such columns, a column without a unit, or a row that is no number.

    Examples
    --------
    >>> from pathlib import Path
    >>> import kirigami as kg
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "test.csv"
    >>> written = file.write_text("time [s];Extension (mm);Load (N)\\n0;0;0\\n1;2;0,5\\n")
    >>> curve = kg.study.read_measured(file)
    >>> curve.kind, curve.motion.tolist(), curve.force.tolist()
    ('displacement', [0.0, 0.002], [0.0, 0.5])
    """
    source = require_path(path, "path", "read_measured", GeometryError)
    if not source.is_file():
        raise GeometryError(f"there is no file {source}")
    try:
        text = source.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise GeometryError(f"cannot read {source}: {error}") from None
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise GeometryError(f"{source} is empty")
    parted = max(("\t", ";", ","), key=lines[0].count)
    rows = list(csv.reader(lines, delimiter=parted))
    head = [_column(title, source) for title in rows[0]]
    found = {}
    for place, (role, kind, factor) in enumerate(head):
        if role and role not in found:
            found[role] = (place, kind, factor)
    if set(found) != {"motion", "force"}:
        missing = "force" if "motion" in found else "displacement, strain or angle"
        raise GeometryError(f"{source}: no column is called {missing}: the first line must name the columns, {HEAD}")
    columns = []
    for role in ("motion", "force"):
        place, _, factor = found[role]
        values = []
        for number, row in enumerate(rows[1:], start=2):
            try:
                word = row[place].strip()
                values.append(factor * float(word.replace(",", ".") if parted != "," else word))
            except (IndexError, ValueError):
                raise GeometryError(f"{source}: line {number} has no number for {rows[0][place].strip()!r}") from None
        columns.append(np.array(values))
    if len(columns[0]) < 2 or not np.isfinite(columns).all():
        raise GeometryError(f"{source}: a curve needs at least two points, all of them finite")
    return Measured(found["motion"][1], columns[0], columns[1], source.name)


def _column(title: str, source: Path) -> tuple[str, str, float]:
    """Role of a column, what it holds, and what turns its numbers into SI units; no role for others."""
    match = re.fullmatch(r"\s*(.*?)\s*(?:[\[(](.*?)[\])]|[/,]\s*(\S+))?\s*", title)
    assert match is not None
    words, unit = match[1].casefold().replace("_", " ").split(), (match[2] or match[3] or "").strip()
    for kind, names in MOTIONS.items():
        if set(words) & set(names):
            if kind == "angle":
                if unit not in ANGLES:
                    raise GeometryError(f"{source}: the column {title.strip()!r} needs a unit: degrees or rad")
                return "motion", kind, ANGLES[unit]
            if kind == "strain":
                return "motion", kind, {"%": 0.01, "": 1.0, "-": 1.0, "1": 1.0}.get(unit) or _factor(
                    unit, "ratio", title, source
                )
            return "motion", kind, _factor(unit, "length", title, source)
    if set(words) & set(FORCES):
        return "force", "", _factor(unit, "torque" if set(words) & {"torque", "moment"} else "force", title, source)
    return "", "", 1.0


def _factor(unit: str, kind: str, title: str, source: Path) -> float:
    if not unit:
        raise GeometryError(f"{source}: the column {title.strip()!r} says no unit: write {HEAD}")
    try:
        return units.parse(f"1 {unit}", kind)
    except ModelError as error:
        raise GeometryError(f"{source}: the column {title.strip()!r} is not understood: {error}") from None


def compare(report: Report, measured: Measured) -> Comparison:
    """Hold a measured curve against the computed one of a report.

    Raises
    ------
    ModelError
        The two are drawn over different things, or have no range in common.
    """
    drive = report.drive
    motion = measured.motion
    if (measured.kind == "angle") != drive.turns:
        raise ModelError(f"{measured.name} was measured over {measured.kind}, but the case is about a {drive.motion}")
    if measured.kind == "strain" and drive.kind != "ratio":
        raise ModelError(f"{measured.name} was measured over strain, but the case is about a {drive.motion}")
    if measured.kind == "displacement" and drive.kind == "ratio":
        assert report.free_length is not None
        motion = motion / report.free_length
    # On the way out only: on the way back there are two forces at one displacement.
    there = int(np.abs(report.motion).argmax()) + 1
    x, y = report.motion[:there], report.force[:there]
    order = np.argsort(x, kind="stable")
    within = (motion >= x.min() - 1e-12) & (motion <= x.max() + 1e-12)
    if not within.any():
        raise ModelError(
            f"{measured.name} lies wholly beyond what was computed: it spans {motion.min():.4g} to {motion.max():.4g}, "
            f"the {drive.motion} {x.min():.4g} to {x.max():.4g}"
        )
    gap = np.interp(motion[within], x[order], y[order]) - measured.force[within]
    rms, size = float(np.sqrt((gap**2).mean())), float(np.sqrt((measured.force[within] ** 2).mean()))
    return Comparison(measured, motion, rms, rms / size if size else float("nan"), int((~within).sum()))
