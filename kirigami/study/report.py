"""The report on a stretched drawing: its numbers, in words, and as a folder of tables and pictures."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from kirigami import units
from kirigami.elements.stiffness import Calibration
from kirigami.errors import AnalysisError, KirigamiError
from kirigami.files import whole_file
from kirigami.primitives.kernel import Array
from kirigami.results.doubts import worth
from kirigami.results.drives import Drive
from kirigami.results.fields import facet_strain
from kirigami.results.results import Results
from kirigami.results.scale import scale_of
from kirigami.results.smooth import known_stress, sectors
from kirigami.study.job import Job
from kirigami.study.measured import Comparison, difference_in_words
from kirigami.words import counted


@dataclass
class Report:
    """What a stretched drawing gave.

    Attributes
    ----------
    results : Results
        The path; what was moved is in ``results.drives``.
    job : Job
        What was asked for.
    notes : tuple of str
        What was read, assumed, done and met.
    free_length : float, optional
        Between the grips [m], where there are grips.
    measured : Comparison, optional
        A measured curve against the computed one.
    files : list of Path
        What was written.
    """

    results: Results
    job: Job
    notes: tuple[str, ...]
    free_length: float | None = None
    measured: Comparison | None = None
    files: list[Path] = field(default_factory=list)

    @property
    def complete(self) -> bool:
        """Whether the whole way was gone."""
        end = 0.0 if self.job.case.cycle else 1.0
        lam = self.results.lam
        return bool(abs(lam[-1] - end) < 1e-9 and abs(lam.max() - 1.0) < 1e-9)

    @property
    def drive(self) -> Drive:
        """What the case is about: the first thing it moves."""
        return self.results.drives[0]

    @cached_property
    def motion(self) -> Array:
        """Strain, shear, twist [degrees], lift [m] or share of the weight at each step (s,)."""
        return self.drive.travel(self.results)

    @cached_property
    def force(self) -> Array:
        """What that takes at each step (s,) [N, N m for a twist]; negative where it pushes. Of a weight the sag [m]."""
        return self.drive.force(self.results)

    @cached_property
    def stress(self) -> Array | None:
        """Von Mises' stress at the faces as means round each node (s, k) [Pa]; None where it is not known."""
        return known_stress(self.results)

    @property
    def numbers(self) -> dict[str, Any]:
        """What a person or a program wants to know first, in SI units."""
        results, force, motion, mesh = self.results, self.force, self.motion, self.results.mesh
        assert mesh is not None
        peak, moved = int(np.abs(force).argmax()), self.drive.motion
        response = self.drive.answer
        found: dict[str, Any] = {
            "nodes": len(mesh.nodes),
            "facets": len(mesh.triangles),
            "cuts": len(mesh.cuts),
            moved: float(motion[-1]),
            f"largest_{moved}": float(motion[np.abs(motion).argmax()]),
        }
        if self.free_length is not None:
            found["free_length"] = self.free_length
            if self.drive.kind == "ratio":
                found["displacement"] = float(motion[-1]) * self.free_length
        found |= {
            f"largest_{response}": float(force[peak]),
            f"{moved}_at_largest_{response}": float(motion[peak]),
            f"last_{response}": float(force[-1]),
        }
        for drive in results.drives[1:]:
            found |= {drive.column: float(drive.travel(results)[-1]), drive.response: float(drive.force(results)[-1])}
        strain = sectors(results)
        found["largest_material_strain"] = float(np.abs(strain.means(facet_strain(results))).max())
        if self.stress is not None:
            found["largest_stress"] = float(self.stress.max())
            found[f"{moved}_at_largest_stress"] = float(motion[self.stress.max(axis=1).argmax()])
        if self.measured is not None:
            found |= self.measured.numbers
        return found | {
            "height": float(results.height()[-1]),
            "open_area": float(results.open_area(union=True)[-1]) if mesh.cuts else 0.0,
            "error": _errors(results),
            "steps": len(results),
            "stable_steps": int(results.stable.sum()),
            "largest_residual": float(np.nanmax(results.residual)),
            "factorizations": int(results.stats["factorizations"]),
            "seconds": float(results.stats["seconds"].get("total", 0.0)),
            **({} if results.shapes is None else _shapes_in_numbers(results)),
        }

    @property
    def worth(self) -> list[str]:
        """What the numbers are worth, in words."""
        return worth(self.results)

    def text(self) -> str:
        """The numbers as lines."""
        n, drive, lam, scale = self.numbers, self.drive, self.results.lam, scale_of(self.results)
        takes, kind = drive.answer, drive.answer_kind
        reached = drive.says(lam[-1], scale)
        peak = drive.says(lam[int(np.abs(self.force).argmax())], scale)
        way = f"{drive.named(scale)} {reached}"
        if "displacement" in n:
            assert self.free_length is not None
            way += (
                f" = {scale.show(n['displacement'], 'length', 6)} of grip displacement / "
                f"{scale.show(self.free_length, 'length', 6)} between the grips"
            )
        material = f"strain of the material up to {100 * n['largest_material_strain']:.3g} %"
        if self.stress is not None:
            where = drive.says(lam[int(self.stress.max(axis=1).argmax())], scale)
            material += f", stress up to {units.show(float(f'{self.stress.max():.3g}'), 'stress')} at {where}"
        if n["cuts"]:
            material += " (at the tips of cuts both grow with a finer mesh)"
        lines = [
            f"nodes {n['nodes']}, facets {n['facets']}, cuts {n['cuts']}",
            way,
            f"largest {takes} {scale.show(n[f'largest_{takes}'], kind)} at {drive.motion} {peak}, "
            f"last {scale.show(n[f'last_{takes}'], kind)}",
            *(self._further(other) for other in self.results.drives[1:]),
            material,
            f"height {scale.show(n['height'], 'length')}, open area {scale.show(n['open_area'], 'area')}",
            *([difference_in_words(self.measured, scale)] if self.measured is not None else []),
            *self.worth,
            (
                f"{counted(n['steps'], 'step')}, {n['stable_steps']} stable, largest residual "
                f"{n['largest_residual']:.1e}, {counted(n['factorizations'], 'factorization')}, {n['seconds']:.1f} s"
            ),
        ]
        lines += self.results.shape_words
        if not self.complete:
            lines.append(
                f"the path ended at {100 * lam[-1]:.3g} % of the way, at a {drive.motion} of {reached}: see the events"
            )
        return "\n".join(lines)

    def _further(self, drive: Drive) -> str:
        """A second motion in words."""
        scale = scale_of(self.results)
        borne = scale.show(float(drive.force(self.results)[-1]), drive.answer_kind)
        return f"{drive.named(scale)} {drive.says(self.results.lam[-1], scale)}: {drive.takes(scale)} {borne}"


def _shapes_in_numbers(results: Results) -> dict[str, Any]:
    """Which of the known shapes the end is, and what they need; number 0 for none of them."""
    study = results.shapes
    shape = study.which(results.steps[int(np.abs(results.lam).argmax())])
    return {
        "shape": 0 if shape is None else shape.number,
        "shape_energies": [one.energy for one in study],
        "shape_forces": [one.force for one in study],
    }


def _errors(results: Results) -> dict[str, float]:
    """Estimated errors at the last step, of what there is."""
    with suppress(AnalysisError):
        return {name: float(values[-1]) for name, values in results.error.items() if np.isfinite(values[-1])}
    return {}


def write_report(report: Report, folder: str | os.PathLike[str], say: Callable[[str], None] = print) -> list[Path]:
    """Write all files of a stretched drawing into a folder; parts whose library is missing are skipped with a word.

    ``report.json``, ``case.json`` (which runs the job again), ``curves.csv``, ``results.npz``, ``page.html``, ``vtk/``
    for ParaView, and pictures: ``rest.png``, ``deformed.png``, ``above.png``, ``stress.png``, ``force.png``, and
    ``opening.png`` of a sheet with cuts; ``shapes.csv`` and ``shapes.png`` where other shapes were looked for.

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
    >>> import kirigami as kg
    >>> import shapely, tempfile
    >>> from kirigami.drawing.drawing import Drawing
    >>> plate = Drawing(shapely.box(0, 0, 0.05, 0.1), ())
    >>> report = kg.study.stretch_drawing(
    ...     plate, thickness="0.1mm", E="3.5GPa", strain="0.1%", max_edge="25mm", imperfection=0
    ... )
    >>> files = kg.study.write_report(report, tempfile.mkdtemp(), say=lambda words: None)
    >>> "report.json" in [file.name for file in files]
    True
    """
    from kirigami.io.table import to_csv
    from kirigami.study.report_picture import write_pictures

    target, results = Path(folder), report.results
    files = [target / "report.json", target / "curves.csv", target / "results.npz"]
    with whole_file(files[0]) as unfinished:
        notes = [*report.notes, *report.worth]
        content = {"complete": report.complete, "numbers": report.numbers, "notes": notes}
        unfinished.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    to_csv(results, files[1])
    results.save(files[2])
    if isinstance(report.job.drawing, (str, os.PathLike)) and not isinstance(report.job.stiffness, Calibration):
        files.append(report.job.save(target / "case.json"))
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
