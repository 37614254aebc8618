"""What a search for shapes found: the shapes, where they lead, and which of them a given step is."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from kirigami.errors import ModelError
from kirigami.files import whole_file
from kirigami.model.model import Model
from kirigami.primitives.checks import require_instance, require_path
from kirigami.results.step import Step
from kirigami.study.shape.known import KnownShapes
from kirigami.study.shape.links import Branch, Link
from kirigami.study.shape.relaxation import Relaxed, Relaxer
from kirigami.words import counted, percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Shape:
    """One stable shape.

    Attributes
    ----------
    number : int
        From 1, in the order of energy.
    energy : float
        Its energy, that of loads included [force length].
    force : float
        Work of the drive per unit of load factor over the largest displacement it prescribes [force]: of a grip, its
        reaction along the pull. nan where loads drive.
    step : Step
        The equilibrium, stable, of the model that was given: an analysis can start from it.
    reached_by : str
        What led to it first.
    times : int
        How many trials led to it.
    arrangements : int
        How many arrangements of equal cells, no mirror images of each other, count as this shape.
    trusted : Relaxed or None
        ``.energy``, ``.force`` and ``.step`` once relaxed on the rung "shell", of a model on a lesser one; None where
        it was not, or no stable shape was found there.
    trusted_distance : float
        Relative distance of the two: far above 0 where the shape is not stable on the trusted rung, and left for
        another one.
    trusted_as : int or None
        Number of the first shape that becomes the same one on the trusted rung: its own where it stays by itself.
    links : tuple of Link
        Where it is lost when the pull is let down or goes on, and what it leads to.
    """

    number: int
    energy: float
    force: float
    step: Step
    reached_by: str
    times: int
    arrangements: int
    trusted: Relaxed | None = None
    trusted_distance: float = float("nan")
    trusted_as: int | None = None
    links: tuple[Link, ...] = ()

    def __repr__(self) -> str:
        return f"<Shape {self.number}: energy {self.energy:.6g}, force {self.force:.6g}, {self.reached_by}>"


@dataclass(frozen=True, eq=False)
class ShapeStudy:
    """The stable shapes found at one load factor: a sequence, lowest energy first. Print it; ``plot()`` shows it.

    Attributes
    ----------
    model : Model
        What they are shapes of.
    at : float
        The load factor.
    shapes : list of Shape
        The shapes.
    branches : list of Branch
        Those that were followed in the pull, on the rung of the search.
    links : list of Link
        The snaps that were met.
    trials : list of dict
        One row for each trial: what it started from, what became of it, the number of its shape.
    notes : list of str
        What was met on the way, as the end of the budget.
    cpu_seconds : float
        What it cost.
    searched : str
        Rung of accuracy of the search; empty for a structure without one.
    found : int
        How many shapes were found on that rung.
    """

    model: Model
    at: float
    shapes: list[Shape]
    branches: list[Branch]
    links: list[Link]
    trials: list[dict[str, Any]]
    notes: list[str]
    cpu_seconds: float
    searched: str
    found: int
    trusted_model: Model | None = None
    _known: KnownShapes | None = field(default=None, repr=False)
    _numbers: dict[int, int] = field(default_factory=dict, repr=False)

    def __len__(self) -> int:
        return len(self.shapes)

    @overload
    def __getitem__(self, index: int) -> Shape: ...
    @overload
    def __getitem__(self, index: slice) -> list[Shape]: ...
    def __getitem__(self, index: int | slice) -> Shape | list[Shape]:
        return self.shapes[index]

    def __iter__(self) -> Iterator[Shape]:
        return iter(self.shapes)

    @property
    def forces(self) -> tuple[float, float]:
        """Least and largest force of the shapes [force]; nan where loads drive."""
        values = [shape.force for shape in self.shapes]
        return (float(np.min(values)), float(np.max(values)))

    def cpu_seconds_to(self, shape: Shape) -> float:
        """CPU seconds of the trials up to the first one that led to a shape; all of them where none did."""
        require_instance(shape, Shape, "shape", "ShapeStudy.cpu_seconds_to")
        total = 0.0
        for row in self.trials:
            total += float(row.get("cpu", 0.0))
            if row["shape"] == shape.number:
                break
        return total

    def which(self, step: Step) -> Shape | None:
        """The shape that a step of the model is; None where the search does not know it.

        Raises
        ------
        ModelError
            A step of another model, or at another load factor.
        """
        require_instance(step, Step, "step", "ShapeStudy.which")
        if len(step.u) != len(self.model.nodes) or abs(step.lam - self.at) > 1e-9 * max(abs(self.at), 1.0):
            raise ModelError(
                f"ShapeStudy.which: the step has {counted(len(step.u), 'node')} and load factor {step.lam:.6g}; the "
                f"shapes have {len(self.model.nodes)} and {self.at:.6g}"
            )
        assert self._known is not None
        kind = self._known.find(step.u, *Relaxer(self.model, self.at, 1.0).energy_and_force(step))
        return None if kind is None else self.shapes[self._numbers[kind.number] - 1]

    def words(self, step: Step) -> list[str]:
        """Which shape a step is, whether lower ones are known, and the spread of forces, in lines of text."""
        shape = self.which(step)
        known = f"{len(self)} known at load factor {self.at:g}"
        if shape is None:
            lines = [f"shape: none of the {known}"]
        elif shape.number == 1:
            lines = [f"shape: the one of least energy of {known}"]
        else:
            low = self.shapes[0].energy
            share = f", {percent(1 - low / shape.energy)} lower" if shape.energy > 0 < low else ""
            lines = [f"shape: number {shape.number} of {known}; the lowest has an energy of {low:.6g}{share}"]
        low, high = self.forces
        if np.isfinite(low) and len(self) > 1:
            lines.append(f"forces of the known shapes: {low:.5g} to {high:.5g}")
        return lines

    def table(self, path: str | os.PathLike[str] | None = None) -> dict[str, list[Any]]:
        """The shapes as columns, which pandas takes as they are, None for what is not known; with `path` also CSV."""
        rows = [
            {
                "shape": shape.number,
                "energy": shape.energy,
                "force": _known(shape.force),
                "times": shape.times,
                "arrangements": shape.arrangements,
                "trusted_energy": None if shape.trusted is None else shape.trusted.energy,
                "trusted_force": None if shape.trusted is None else _known(shape.trusted.force),
                "trusted_distance": _known(shape.trusted_distance),
                "trusted_as": shape.trusted_as,
                "reached_by": shape.reached_by,
                "leads_to": "; ".join(_told(link) for link in shape.links),
            }
            for shape in self.shapes
        ]
        if path is not None:
            target = require_path(path, "path", "ShapeStudy.table")
            with whole_file(target) as unfinished, open(unfinished, "w", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, list(rows[0]))
                writer.writeheader()
                writer.writerows(rows)
        return {name: [row[name] for row in rows] for name in rows[0]}

    def __str__(self) -> str:
        rung = "" if self.model.sheet_constants is None else f' on "{self.model.sheet_constants.rung}"'
        done = sum(row["status"] == "done" for row in self.trials)
        more = f', of {self.found} found on "{self.searched}"' if self.found > len(self) else ""
        lines = [
            f"{counted(len(self), 'shape')} at load factor {self.at:g}{rung}{more}; {done} of "
            f"{counted(len(self.trials), 'trial')} ended in "
            f"one, {self.cpu_seconds:.0f} CPU s",
            '| shape | energy | force | times | arrangements | energy, force on "shell" | reached by | it leads to |',
            "| --- | --- | --- | --- | --- | --- | --- | --- |",
        ]
        for shape in self.shapes:
            links = "; ".join(_told(link) for link in shape.links)
            lines.append(
                f"| {shape.number} | {shape.energy:.6g} | {shape.force:.5g} | {shape.times} | {shape.arrangements} | "
                f"{_trusted(shape)} | {shape.reached_by} | {links} |"
            )
        low, high = self.forces
        if np.isfinite(low):
            lines.append(f"forces from {low:.5g} to {high:.5g}")
        return "\n".join([*lines, *self.notes])

    def plot(self) -> Figure:
        """Energy against the pull with every branch that was followed, and force with its range (see
        :mod:`kirigami.plot`).

        Raises
        ------
        ModelError
            There is no shape.
        """
        from kirigami.study.shape.picture import draw_shapes

        return draw_shapes(self)


def _known(value: float) -> float | None:
    return None if np.isnan(value) else value


def _trusted(shape: Shape) -> str:
    if shape.trusted is None:
        return ""
    if shape.trusted_as != shape.number:
        return f"as shape {shape.trusted_as}"
    off = f", {100 * shape.trusted_distance:.0f} % off" if shape.trusted_distance > 0.1 else ""
    return f"{shape.trusted.energy:.6g}, {shape.trusted.force:.5g}{off}"


def _told(link: Link) -> str:
    leads = "an unknown shape" if link.leads_to is None else f"shape {link.leads_to}"
    return f"{leads} by a snap at {link.lam:.3g}"
