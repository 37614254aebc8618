"""What accuracy costs in time: rungs of accuracy, mesh sizes and tolerances, against one reference."""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kirigami.analysis.path.checkpoint import fingerprint
from kirigami.analysis.path.methods import DisplacementControl
from kirigami.elements.stiffness import RUNGS, rung_named
from kirigami.errors import AnalysisError, KirigamiWarning, ModelError
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
from kirigami.scale import UNKNOWN, Scale
from kirigami.study.reference import QUANTITIES, Reference, limit_reference, read_reference
from kirigami.study.shape.prints import print_distance, shape_print
from kirigami.sweep.sweep import Sweep
from kirigami.sweep.table import SweepTable
from kirigami.system.system import System
from kirigami.words import percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Case = Callable[[float, str], tuple[Model, Sequence[Node], str]]
FINER = (1.0, float(np.sqrt(0.6)), 0.6)  # sizes of the reference meshes over the smallest one of the study
ALIKE = 0.35  # relative distance of two shapes from which on they are different


@dataclass(frozen=True)
class AccuracyStudy:
    """Errors and seconds of every run of an :func:`accuracy` study.

    Attributes
    ----------
    table : SweepTable
        One row a run: stiffness, max_edge, tol, nodes, unknowns, seconds (CPU), factorizations, status and error, and
        each quantity at each load factor, such as ``"force at 0.5"``; also a print of the shape there.
    at : ndarray, shape (k,)
        Load factors at which runs are compared.
    judge : Reference
        What they are compared with, and the error of that.
    shapes : tuple of str
        Prints of the shape that a run must have to be compared at all.
    alike : float
        Relative distance of two shapes from which on they are different.
    scale : Scale
        In which edges of meshes are told; by default as plain numbers.
    """

    table: SweepTable
    at: Array
    judge: Reference
    shapes: tuple[str, ...]
    alike: float = ALIKE
    scale: Scale = UNKNOWN

    @property
    def reference(self) -> dict[str, Array]:
        """The reference values of ``"force"``, ``"open_area"`` and ``"height"`` (k,); nan where nothing is known."""
        return self.judge.values

    @property
    def named(self) -> str:
        """What the reference is, and its own error."""
        return self.judge.told(self.scale)

    def other_shape(self, row: Mapping[str, Any]) -> float | None:
        """The first load factor at which a run has another shape than the reference; None where it has the same."""
        require_mapping(row, "row", "AccuracyStudy")
        for lam, shape in zip(self.at.tolist(), self.shapes):
            found = row.get(_column("shape", lam))
            if found not in (None, "") and print_distance(str(found), shape) > self.alike:
                return float(lam)
        return None

    def values(self, row: Mapping[str, Any], quantity: str) -> Array:
        """A quantity of one run at each load factor (k,); nan where the run did not get there."""
        require_choice(quantity, QUANTITIES, "quantity", "AccuracyStudy")
        require_mapping(row, "row", "AccuracyStudy")
        return _row_values(row, quantity, self.at.tolist())

    def error(self, row: Mapping[str, Any], quantity: str) -> float:
        """Largest relative error of a quantity over the load factors, and no less than that of the reference itself.

        It is nan for a run that did not reach all load factors, or has another shape than the reference: the two are
        answers to different questions then. Heights and areas are compared with their largest reference value, forces
        each with its own.
        """
        require_choice(quantity, QUANTITIES, "quantity", "AccuracyStudy")
        if require_mapping(row, "row", "AccuracyStudy").get("status") is None:
            raise ModelError("AccuracyStudy: row must be a row of the table of the study")
        scale = self.judge.scale(quantity)
        known = np.isfinite(scale)
        if row["status"] != "done" or not known.any() or self.other_shape(row) is not None:
            return float("nan")
        if not np.all(scale[known] > 0):  # nothing to compare with, as the open area of a sheet without cuts
            return float("nan")
        difference = np.abs(self.values(row, quantity) - self.reference[quantity])[known] / scale[known]
        return float(np.maximum(difference.max(), self.judge.own_error(quantity)))

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
            return f"{name}: no run reached the end in the shape of the reference, so none can be compared"
        if error < (own := self.judge.own_error(quantity)):
            return f"{100 * error:g} % in {name}: cannot be told; the reference itself is known to {percent(own)}"
        for row in front:
            if self.error(row, quantity) <= error:
                found = percent(self.error(row, quantity))
                return f"{100 * error:g} % in {name}: {self._run(row)} (error {found})"
        last = front[-1]
        return (
            f"{100 * error:g} % in {name}: not reached; the best is {self._run(last)} "
            f"with {percent(self.error(last, quantity))}, so a finer mesh is needed"
        )

    def _run(self, row: Mapping[str, Any]) -> str:
        return f"{row['stiffness']}, max_edge {edge_of(row, self.scale)}, {float(row['cpu_seconds']):.1f} s"

    def __str__(self) -> str:
        """A table to copy: every run, its cost and its largest errors in percent."""
        lines = [
            f"reference: {self.named}; errors are the largest over load factors {', '.join(f'{v:g}' for v in self.at)}"
            ", and no less than its own",
            "| stiffness | max_edge | tol | nodes | seconds | factorizations | force % | open area % | height % |",
            "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
        ]
        for row in self.table:
            head = f"| {row['stiffness']} | {edge_of(row, self.scale)} | {float(row['tol']):g} | "
            if row["status"] != "done":
                lines.append(head + f"{row['status']}: {row.get('error') or ''} |||||")
                continue
            if (lam := self.other_shape(row)) is not None:
                lines.append(f"{head}{_cost(row)} | another shape at {lam:g} |||")
                continue
            errors = " | ".join(
                "-" if np.isnan(value) else percent(value).removesuffix(" %")
                for value in (self.error(row, quantity) for quantity in QUANTITIES)
            )
            lines.append(f"{head}{_cost(row)} | {errors} |")
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


def edge_of(row: Mapping[str, Any], scale: Scale) -> str:
    """The longest edge of a run's mesh in words."""
    return scale.show(float(row["max_edge"]), "length")


def accuracy(
    case: Case,
    sizes: Iterable[float],
    *,
    path: str | os.PathLike[str],
    stiffness: Sequence[str] = RUNGS,
    tolerances: Iterable[float] = (1e-8,),
    at: Iterable[float] = (0.25, 0.5, 1.0),
    reference: str | os.PathLike[str] | Mapping[str, Sequence[float]] | None = None,
    alike: float = ALIKE,
    progress: bool = False,
) -> AccuracyStudy:
    """Run a sheet on every rung of accuracy, mesh size and tolerance, and compare error with time.

    The runs go one after the other, so that their CPU seconds can be compared. Run it again after an interruption and
    it goes on where it was; a run that fails is a row that says why. Only runs on one shape are compared: a sheet has
    many, and the difference of two shapes is no error of a mesh.

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
        A CSV file, or a mapping, with columns ``load_factor`` and any of ``force``, ``open_area``, ``height``, and of
        ``force_error`` and its kin, the relative errors of these. The shape is then that of the finest run of the best
        rung. None runs the most accurate rung on meshes of 1, 0.77 and 0.6 times the smallest size and takes their
        limit; its own error is what it adds to the last of them.
    alike : float
        Relative distance of two shapes, up to reflections and sides, from which on they are different.
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
        The log at `path` belongs to another study, or to one of another sheet; or every run failed.

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
    alike = require_positive(alike, "alike", "accuracy")
    if not edges or not rungs or not limits or not load_factors.size or load_factors[0] <= 0:
        raise ModelError("accuracy: give at least one size, one stiffness, one tolerance and one positive load factor")
    designs = [{"stiffness": rung, "max_edge": edge, "tol": tol} for tol in limits for rung in rungs for edge in edges]
    given = None if reference is None else read_reference(reference, load_factors)  # a slip must not cost the runs
    finer = [] if given else [{"stiffness": RUNGS[-1], "max_edge": s * min(edges), "tol": min(limits)} for s in FINER]
    designs += [design for design in finer if design not in designs]
    targets = load_factors.tolist()

    def run(stiffness: str, max_edge: float, tol: float) -> dict[str, float | str]:
        return measured(case, stiffness, max_edge, tol, targets)

    run.__qualname__ = f"accuracy of sheet {_mark(case, designs)} on one shape at {targets}"
    with ThreadPoolExecutor(1) as alone:
        table = Sweep(run, designs, path).run(alone, progress=progress)
    rows = [dict(row) for row in table]
    if len(table.failed) == len(rows):
        raise AnalysisError(f"accuracy: no run of {len(rows)} went well, the first one failed by {rows[0]['error']}")
    if given is not None:
        return AccuracyStudy(table, load_factors, given, _shapes(_finest(rows), targets), alike)
    judges = [rows[designs.index(design)] for design in finer]
    return AccuracyStudy(table, load_factors, _limit(judges, targets, alike), _shapes(judges[-1], targets), alike)


def _mark(case: Case, designs: Sequence[Mapping[str, Any]]) -> str:
    """What tells the sheet of a study from another one, with its supports and drive: a digest of its coarsest model."""
    for design in sorted(designs, key=lambda design: -float(design["max_edge"])):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", KirigamiWarning)  # the run itself will tell
                model = case(design["max_edge"], design["stiffness"])[0]
                return fingerprint(System(model), DisplacementControl(model))[:8]
        except Exception:  # whatever it is, it will be in the row of the run
            continue
    return "unknown"


def _finest(rows: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    """The finest run that ended, of the best rung there is."""
    done = [row for row in rows if row["status"] == "done"]
    return max(done, key=lambda row: (RUNGS.index(row["stiffness"]), -float(row["max_edge"])), default={})


def _shapes(row: Mapping[str, Any], targets: Sequence[float]) -> tuple[str, ...]:
    found = [str(row.get(_column("shape", lam)) or "") for lam in targets]
    return tuple(found) if all(found) else ()


def _limit(rows: Sequence[Mapping[str, Any]], targets: Sequence[float], alike: float) -> Reference:
    """The limit of the reference runs; nan where one of them failed."""
    sizes = [float(row["max_edge"]) for row in rows]
    runs = [{name: _row_values(row, name, targets) for name in QUANTITIES} for row in rows]
    shapes = [_shapes(row, targets) for row in rows]
    one_shape = all(
        print_distance(one, other) <= alike for found in shapes[:-1] for one, other in zip(found, shapes[-1])
    )
    remark = "" if one_shape else ", which end in different shapes"
    return limit_reference(f"limit of {rows[-1]['stiffness']}", sizes, runs, one_shape, remark)


def _row_values(row: Mapping[str, Any], quantity: str, load_factors: Sequence[float]) -> Array:
    found = [row.get(_column(quantity, lam)) for lam in load_factors]
    return np.array([np.nan if value in (None, "") else float(value) for value in found])


def measured(
    case: Case, stiffness: str, max_edge: float, tol: float, targets: Sequence[float]
) -> dict[str, float | str]:
    """Run one case and return its cost, and force, open area, height and shape at the load factors `targets`."""
    begin = time.process_time()
    model, nodes, axis = case(max_edge, stiffness)
    results = DisplacementControl(model, to=max(targets), targets=targets, tol=tol).run()
    row: dict[str, float | str] = {
        "nodes": len(model.nodes),
        "unknowns": results.stats["unknowns"],
        "cpu_seconds": time.process_time() - begin,
        "factorizations": results.stats["factorizations"],
    }
    values = quantities(results, nodes, axis)
    for lam in targets:
        step = results.nearest(lam)
        found = {_column(quantity, lam): float(values[quantity][step]) for quantity in QUANTITIES}
        row |= {name: value for name, value in found.items() if np.isfinite(value)}  # no cuts, no open area
        row[_column("shape", lam)] = shape_print(results, step)
    return row


def quantities(results: Results, nodes: Sequence[Node], axis: str) -> dict[str, Array]:
    """Force, open area (all cuts, without overlap counted twice) and height (highest minus lowest node), each (s,)."""
    mesh = results.mesh
    if mesh is None:
        raise ModelError("a study of accuracy needs models made by Model.from_mesh")
    area = results.open_area(union=True) if mesh.cuts else np.full(len(results), np.nan)
    return {"force": results.reaction(nodes, axis), "open_area": area, "height": results.height()}


def _column(quantity: str, lam: float) -> str:
    return f"{quantity} at {lam:g}"


def _cost(row: Mapping[str, Any]) -> str:
    return f"{int(row['nodes'])} | {float(row['cpu_seconds']):.1f} | {int(row['factorizations'])}"
