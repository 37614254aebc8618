"""What accuracy costs in time: rungs of accuracy, mesh sizes and tolerances, against one reference."""

from __future__ import annotations

import csv
import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.analysis.path.methods import DisplacementControl
from kirigami.elements.stiffness import RUNGS, rung_named
from kirigami.errors import ModelError
from kirigami.model.model import Model
from kirigami.primitives.checks import (
    require_array,
    require_boolean,
    require_callable,
    require_choice,
    require_items,
    require_mapping,
    require_path,
    require_positive,
)
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import Node
from kirigami.results.results import Results
from kirigami.sweep.sweep import Sweep
from kirigami.sweep.table import SweepTable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Case = Callable[[float, str], tuple[Model, Sequence[Node], str]]
QUANTITIES = ("force", "open_area", "height")
FINER = 0.6  # size of the reference mesh over the smallest one of the study


@dataclass(frozen=True)
class AccuracyStudy:
    """Errors and seconds of every run of an :func:`accuracy` study.

    Attributes
    ----------
    table : SweepTable
        One row a run: stiffness, max_edge, tol, nodes, unknowns, seconds (CPU), factorizations, status and error, and
        each quantity at each load factor, such as ``"force at 0.5"``.
    at : ndarray, shape (k,)
        Load factors at which runs are compared.
    reference : dict of ndarray, each shape (k,)
        The reference values of ``"force"``, ``"open_area"`` and ``"height"``; nan where the reference says nothing.
    named : str
        What the reference is.
    own : int or None
        Number of the run that is the reference, if one of them is.
    """

    table: SweepTable
    at: Array
    reference: dict[str, Array]
    named: str
    own: int | None = None

    def values(self, row: Mapping[str, Any], quantity: str) -> Array:
        """A quantity of one run at each load factor (k,); nan where the run did not get there."""
        require_choice(quantity, QUANTITIES, "quantity", "AccuracyStudy")
        require_mapping(row, "row", "AccuracyStudy")
        found = [row.get(_column(quantity, lam)) for lam in self.at]
        return np.array([np.nan if value in (None, "") else float(value) for value in found])

    def error(self, row: Mapping[str, Any], quantity: str) -> float:
        """Largest relative error of a quantity over the load factors; nan for a run that did not reach them all.

        Heights and areas are compared with their largest reference value, forces each with its own.
        """
        require_choice(quantity, QUANTITIES, "quantity", "AccuracyStudy")
        if require_mapping(row, "row", "AccuracyStudy").get("status") is None:
            raise ModelError("AccuracyStudy: row must be a row of the table of the study")
        known = np.isfinite(self.reference[quantity])
        if row["status"] != "done" or not known.any() or row["design"] == self.own:
            return float("nan")
        wanted = self.reference[quantity][known]
        scale = np.abs(wanted) if quantity == "force" else np.abs(wanted).max()
        if not np.all(scale > 0):  # nothing to compare with, as the open area of a sheet without cuts
            return float("nan")
        return float(np.max(np.abs(self.values(row, quantity)[known] - wanted) / scale))

    def front(self, quantity: str = "force") -> list[dict[str, Any]]:
        """The runs that no other run beats in both error and seconds, from cheap to accurate (the Pareto front)."""
        rows = [dict(row) for row in self.table if np.isfinite(self.error(row, quantity))]
        best: list[dict[str, Any]] = []
        for row in sorted(rows, key=lambda row: (float(row["cpu_seconds"]), self.error(row, quantity))):
            if not best or self.error(row, quantity) < self.error(best[-1], quantity):
                best.append(row)
        return best

    def recommend(self, error: float = 0.05, quantity: str = "force") -> str:
        """The cheapest run within an error, in words; or how near the study got.

        Examples
        --------
        A line such as ``2 % in force: shell, max_edge 0.12, 6.1 s (error 1.4 %)``.
        """
        error = require_positive(error, "error", "recommend")
        name = require_choice(quantity, QUANTITIES, "quantity", "recommend").replace("_", " ")
        front = self.front(quantity)
        if not front:
            return f"{name}: no run reached the end and can be compared"
        for row in front:
            if self.error(row, quantity) <= error:
                return f"{100 * error:g} % in {name}: {_told(row)} (error {100 * self.error(row, quantity):.2g} %)"
        last = front[-1]
        return (
            f"{100 * error:g} % in {name}: not reached; the best is {_told(last)} "
            f"with {100 * self.error(last, quantity):.2g} %, so a finer mesh is needed"
        )

    def __str__(self) -> str:
        """A table to copy: every run, its cost and its largest errors in percent."""
        lines = [
            f"reference: {self.named}; errors are the largest over load factors {', '.join(f'{v:g}' for v in self.at)}",
            "| stiffness | max_edge | tol | nodes | seconds | factorizations | force % | open area % | height % |",
            "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
        ]
        for row in self.table:
            head = f"| {row['stiffness']} | {float(row['max_edge']):g} | {float(row['tol']):g} | "
            if row["status"] != "done":
                lines.append(head + f"{row['status']}: {row.get('error') or ''} |||||")
                continue
            errors = " | ".join(
                "-" if np.isnan(value) else f"{100 * value:.2g}"
                for value in (self.error(row, quantity) for quantity in QUANTITIES)
            )
            cost = f"{int(row['nodes'])} | {float(row['cpu_seconds']):.1f} | {int(row['factorizations'])}"
            lines.append(f"{head}{cost} | {errors} |")
        return "\n".join(lines)

    def plot(self, others: Mapping[str, Mapping[str, tuple[float, float]]] | None = None) -> Figure:
        """Error against CPU seconds for force, open area and height, with the Pareto front.

        Parameters
        ----------
        others : mapping of str to mapping, optional
            Points of another code: name to quantity to (error, seconds).
        """
        from kirigami.study.accuracy_picture import draw_accuracy

        given = require_mapping({} if others is None else others, "others", "AccuracyStudy.plot")
        for name, points in given.items():
            for quantity, point in require_mapping(points, name, "AccuracyStudy.plot").items():
                require_choice(quantity, QUANTITIES, name, "AccuracyStudy.plot")
                require_array(point, (2,), name=f"{quantity} of {name}", owner="AccuracyStudy.plot")
        return draw_accuracy(self, given)


def accuracy(
    case: Case,
    sizes: Iterable[float],
    *,
    path: str | os.PathLike[str],
    stiffness: Sequence[str] = RUNGS,
    tolerances: Iterable[float] = (1e-8,),
    at: Iterable[float] = (0.25, 0.5, 1.0),
    reference: str | os.PathLike[str] | Mapping[str, Sequence[float]] | None = None,
    progress: bool = False,
) -> AccuracyStudy:
    """Run a sheet on every rung of accuracy, mesh size and tolerance, and compare error with time.

    The runs go one after the other, so that their CPU seconds can be compared. Run it again after an interruption and
    it goes on where it was; a run that fails is a row that says why.

    Parameters
    ----------
    case : callable
        ``case(max_edge, stiffness)`` makes the model, supports, drive and imperfection included, and returns
        (model, driven nodes, axis of the force).
    sizes : iterable of float
        Largest mesh edges [length].
    path : path
        Where the table goes, and the log from which a study resumes.
    stiffness : sequence of str
        Rungs, see :meth:`Model.from_mesh`.
    tolerances : iterable of float
        Relative residuals of the stored steps.
    at : iterable of float
        Load factors at which runs are compared.
    reference : path or mapping, optional
        A CSV file, or a mapping, with columns ``load_factor`` and any of ``force``, ``open_area``, ``height``. None
        runs the last rung on a mesh of 0.6 times the smallest size.
    progress : bool
        Show how far it is.

    Returns
    -------
    AccuracyStudy

    Raises
    ------
    ModelError
        No sizes, unknown rungs, a reference without the load factors asked for.
    AnalysisError
        The log at `path` belongs to another study.

    Examples
    --------
    >>> import shapely, tempfile
    >>> import kirigami as kg
    >>> sheet = kg.Sheet(shapely.box(0, 0, 2, 1), thickness=0.01, material=kg.Material(E=1e6))
    >>> def pulled(max_edge, stiffness):
    ...     m = kg.Model.from_mesh(sheet.mesh(max_edge), stiffness=stiffness)
    ...     left, right = m.select(boundary="left"), m.select(boundary="right")
    ...     objects = m.add(kg.Fix(left, clamp=True), kg.Prescribe(right, x=0.01, y=0, z=0, clamp=True))
    ...     return m, right, "x"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     study = kg.study.accuracy(pulled, [0.5, 0.3], path=folder + "/study", stiffness=["plate", "shell"])
    >>> print(study.recommend(0.05)[:12])
    5 % in force
    """
    require_callable(case, "case", "accuracy")
    path = require_path(path, "path", "accuracy")
    require_boolean(progress, "progress", "accuracy")
    load_factors = np.unique(require_array(at, (None,), name="at", owner="accuracy"))
    edges = [require_positive(size, "size", "accuracy") for size in require_items(sizes, "sizes", "accuracy")]
    rungs = [rung_named(rung, "accuracy") for rung in require_items(stiffness, "stiffness", "accuracy")]
    limits = [require_positive(tol, "tol", "accuracy") for tol in require_items(tolerances, "tolerances", "accuracy")]
    if not edges or not rungs or not limits or not load_factors.size or load_factors[0] <= 0:
        raise ModelError("accuracy: give at least one size, one stiffness, one tolerance and one positive load factor")
    designs = [{"stiffness": rung, "max_edge": edge, "tol": tol} for tol in limits for rung in rungs for edge in edges]
    if reference is None:
        designs.append({"stiffness": rungs[-1], "max_edge": FINER * min(edges), "tol": min(limits)})
    given = None if reference is None else read_reference(reference, load_factors)  # a slip must not cost the runs
    targets = load_factors.tolist()

    def run(stiffness: str, max_edge: float, tol: float) -> dict[str, float]:
        return measured(case, stiffness, max_edge, tol, targets)

    run.__qualname__ = f"accuracy at {targets}"
    with ThreadPoolExecutor(1) as alone:
        table = Sweep(run, designs, path).run(alone, progress=progress)
    if given is not None and reference is not None:
        name = "given values" if isinstance(reference, Mapping) else Path(reference).name
        return AccuracyStudy(table, load_factors, given, name)
    last = list(table)[-1]
    name = f"{last['stiffness']}, max_edge {float(last['max_edge']):.4g}"
    study = AccuracyStudy(table, load_factors, {}, name, own=int(last["design"]))
    study.reference.update({quantity: study.values(last, quantity) for quantity in QUANTITIES})
    return study


def measured(case: Case, stiffness: str, max_edge: float, tol: float, targets: Sequence[float]) -> dict[str, float]:
    """Run one case and return its cost, and force, open area and height at the load factors `targets`."""
    begin = time.process_time()
    model, nodes, axis = case(max_edge, stiffness)
    results = DisplacementControl(model, to=max(targets), targets=targets, tol=tol).run()
    row: dict[str, float] = {
        "nodes": len(model.nodes),
        "unknowns": results.stats["unknowns"],
        "cpu_seconds": time.process_time() - begin,
        "factorizations": results.stats["factorizations"],
    }
    values = quantities(results, nodes, axis)
    for lam in targets:
        step = int(np.argmin(np.abs(results.lam - lam)))
        found = {_column(quantity, lam): float(values[quantity][step]) for quantity in QUANTITIES}
        row |= {name: value for name, value in found.items() if np.isfinite(value)}  # no cuts, no open area
    return row


def quantities(results: Results, nodes: Sequence[Node], axis: str) -> dict[str, Array]:
    """Force, open area (all cuts, without overlap counted twice) and height (highest minus lowest node), each (s,)."""
    mesh = results.mesh
    if mesh is None:
        raise ModelError("a study of accuracy needs models made by Model.from_mesh")
    area = results.open_area(union=True) if mesh.cuts else np.full(len(results), np.nan)
    return {"force": results.reaction(nodes, axis), "open_area": area, "height": results.height()}


def read_reference(
    reference: str | os.PathLike[str] | Mapping[str, Sequence[float]], load_factors: Array
) -> dict[str, Array]:
    """Reference values at the load factors, between those given by linear interpolation."""
    if isinstance(reference, Mapping):
        given = require_mapping(reference, "reference", "accuracy")
        columns = {name: require_array(values, (None,), name=name, owner="accuracy") for name, values in given.items()}
        owner = "the reference"
    else:
        owner = str(require_path(reference, "reference", "accuracy"))
        try:
            with open(reference, newline="") as file:
                rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
            columns = {name: np.array([float(row[name]) for row in rows]) for name in (rows[0] if rows else {})}
        except (OSError, ValueError, TypeError) as error:
            raise ModelError(f"accuracy: {owner} cannot be read as a table of numbers ({error})") from None
    lam = columns.get("load_factor")
    if lam is None or not set(QUANTITIES) & set(columns):
        raise ModelError(f"accuracy: {owner} needs columns load_factor and at least one of {', '.join(QUANTITIES)}")
    order = np.argsort(lam)
    if load_factors.max() > lam.max() * (1 + 1e-9) or load_factors.min() < lam.min() * (1 - 1e-9):
        raise ModelError(
            f"accuracy: {owner} spans load factors {lam.min():g} to {lam.max():g}, not all of {load_factors.tolist()}"
        )
    missing = np.full(len(load_factors), np.nan)
    return {
        name: np.interp(load_factors, lam[order], columns[name][order]) if name in columns else missing.copy()
        for name in QUANTITIES
    }


def _column(quantity: str, lam: float) -> str:
    return f"{quantity} at {lam:g}"


def _told(row: Mapping[str, Any]) -> str:
    return f"{row['stiffness']}, max_edge {float(row['max_edge']):.3g}, {float(row['cpu_seconds']):.1f} s"
