"""Imperfection studies: which seed leads to which final shape, and how much its size matters."""

from __future__ import annotations

import copy
import csv
import os
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import astuple, dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from kirigami.analysis.eigen import Eigen
from kirigami.analysis.modes import Mode
from kirigami.analysis.path.follow import PathAnalysis
from kirigami.analysis.path.methods import DisplacementControl
from kirigami.errors import KirigamiError, KirigamiWarning, ModelError
from kirigami.files import whole_file
from kirigami.model.model import Model
from kirigami.primitives.checks import (
    require_axes,
    require_callable,
    require_executor,
    require_instance,
    require_items,
    require_path,
    require_positive,
    require_whole,
    shown,
)
from kirigami.primitives.kernel import Array
from kirigami.primitives.rigid import rigid_motions
from kirigami.results.results import Results
from kirigami.study.imperfect import SHARE
from kirigami.study.shape.space import FLAT, ShapeSpace
from kirigami.words import counted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Build = Callable[[Model], PathAnalysis]


@dataclass(frozen=True)
class Case:
    """One run of a study: a row of its table.

    Attributes
    ----------
    mode : int
        Number of the seed, from 1.
    sign : int
        1 or -1.
    amplitude : float
        Largest offset of a node [length].
    lam : float
        Load factor at the end.
    energy : float
        Stored energy at the end [force length].
    force : float
        Work of the drive per unit of load factor at the end: of a grip that is pulled by `d` at load factor 1, force
        times d [force length].
    height : float
        Largest displacement out of the plane at the end, largest displacement of a structure in the plane [length].
    branch : int
        Number of the final shape, from 1 in the order of energy; 0 where the run failed.
    status : str
        "done", or what went wrong.
    factorizations : int
        What it cost.
    """

    mode: int
    sign: int
    amplitude: float
    lam: float = float("nan")
    energy: float = float("nan")
    force: float = float("nan")
    height: float = float("nan")
    branch: int = 0
    status: str = ""
    factorizations: int = 0

    @property
    def done(self) -> bool:
        """Whether the run reached its end."""
        return self.status == "done"


@dataclass(frozen=True, eq=False)
class ImperfectionStudy:
    """What an imperfection study found.

    Attributes
    ----------
    model : Model
        The model without imperfection.
    seeds : list of ndarray, shape (n, 3)
        Shapes of the imperfections, largest component 1.
    cases : list of Case
        The table.
    results : list of Results
        The runs, in the order of the cases; of a failed one, as far as it came.
    """

    model: Model
    seeds: list[Array]
    cases: list[Case]
    results: list[Results | None]

    @property
    def branches(self) -> dict[int, list[Case]]:
        """The cases that lead to each final shape; number 1 has the lowest energy."""
        numbers = sorted({case.branch for case in self.cases if case.branch})
        return {number: [case for case in self.cases if case.branch == number] for number in numbers}

    def final(self, branch: int) -> Results:
        """The run with the smallest imperfection that leads to a branch.

        Raises
        ------
        ModelError
            There is no such branch.
        """
        branch = require_whole(branch, "branch", "ImperfectionStudy.final")
        found = [(case.amplitude, k) for k, case in enumerate(self.cases) if case.branch == branch and branch]
        if not found:
            raise ModelError(f"there is no branch {shown(branch)}: the study found {len(self.branches)}")
        results = self.results[min(found)[1]]
        assert results is not None
        return results

    def table(self, path: str | os.PathLike[str] | None = None) -> dict[str, list[Any]]:
        """The cases as columns, which pandas takes as they are; with `path` also written as CSV."""
        names = [field.name for field in fields(Case)]
        rows = [astuple(case) for case in self.cases]
        if path is not None:
            target = require_path(path, "path", "ImperfectionStudy.table")
            with whole_file(target) as unfinished, open(unfinished, "w", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows([names, *rows])
        return {name: [row[k] for row in rows] for k, name in enumerate(names)}

    def __str__(self) -> str:
        lines = [f"{counted(len(self.cases), 'run')}, {counted(len(self.branches), 'final shape')}"]
        for number, cases in self.branches.items():
            energies = [case.energy for case in cases]
            leading = ", ".join(_range(cases, mode) for mode in sorted({case.mode for case in cases}))
            modes = "modes" if "," in leading else "mode"
            lines.append(f"branch {number}: energy {min(energies):.6g} to {max(energies):.6g}, from {modes} {leading}")
        lines += [f"mode {c.mode}, sign {c.sign:+d}, {c.amplitude:g}: {c.status}" for c in self.cases if not c.done]
        return "\n".join(lines)

    def plot(self) -> Figure:
        """The seeds, the final shapes, and which seed leads where (see :mod:`kirigami.plot`)."""
        from kirigami.study.imperfection_picture import draw_study

        return draw_study(self)


def _range(cases: list[Case], mode: int) -> str:
    signs = {case.sign for case in cases if case.mode == mode}
    return f"{mode}" if len(signs) == 2 else f"{mode}{'+' if 1 in signs else '-'}"


def seeds(model: Model, n: int = 6) -> list[Array]:
    """The lowest eigenmodes of a model that are no rigid motions, as seeds for imperfections.

    Of a flat sheet only the modes out of its plane are taken, and exactly those: x and y are zero.

    Parameters
    ----------
    model : Model
        The model; displacements that are constrained stay zero in the modes.
    n : int
        How many.

    Returns
    -------
    list of ndarray, shape (nodes, 3)
        Ascending in eigenvalue, largest component 1, the first of the largest entries positive.

    Raises
    ------
    ModelError
        The model has fewer such modes.

    Examples
    --------
    >>> import kirigami as kg
    >>> square = kg.TriMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    >>> m = kg.Model.from_mesh(square, thickness=0.01, material=kg.Material(E=1e9))
    >>> (fold,) = kg.study.seeds(m, 1)      # the only shape that bends its one hinge
    >>> (fold[:, 2] / fold[0, 2]).round(6).tolist()
    [1.0, -1.0, 1.0, -1.0]
    """
    require_instance(model, Model, "model", "seeds")
    n = require_whole(n, "n", "seeds", least=1)
    rest = model.positions()
    size = float(np.linalg.norm(np.ptp(rest, axis=0)))
    flat = model.dim == 3 and bool(np.ptp(rest[:, 2]) <= FLAT * size)
    rigid = _rigid_motions(rest)
    most = len(rest) * model.dim
    asked = min(n + 6, most)
    while True:
        try:
            modes = Eigen(model, n=asked).run()
        except ModelError:
            if asked <= 1:
                raise
            asked, most = asked - 1, asked - 1
            continue
        found = []
        for mode in modes:
            shape = mode.shape
            if flat:
                if np.abs(shape[:, 2]).max() < 0.99:
                    continue
                shape = shape * [0.0, 0.0, 1.0]
            left = shape.ravel() - rigid @ (rigid.T @ shape.ravel())
            if np.linalg.norm(left) > 1e-4 * np.linalg.norm(shape):
                found.append(shape)
        if len(found) >= n:
            return found[:n]
        if asked >= most:
            raise ModelError(
                f"seeds: the model has only {counted(len(found), 'mode')} that can seed an imperfection, not {n}"
            )
        asked = min(2 * asked, most)


def _rigid_motions(rest: Array) -> Array:
    """Orthonormal basis (3 n, 6) of the rigid motions."""
    moves = rigid_motions(rest)[0].reshape(-1, rest.size)
    basis, values, _ = np.linalg.svd(moves.T, full_matrices=False)
    kept: Array = basis[:, values > 1e-9 * values.max()]
    return kept


def imperfections(
    model: Model,
    modes: int | Sequence[Mode | ArrayLike] = 6,
    amplitudes: Sequence[float] | None = None,
    analysis: Build = DisplacementControl,
    signs: Sequence[int] = (1, -1),
    mirrors: str = "xy",
    alike: float = 0.2,
    folder: str | os.PathLike[str] | None = None,
    executor: Executor | None = None,
) -> ImperfectionStudy:
    """Run a model once with each of many imperfections, and sort the final shapes.

    Parameters
    ----------
    model : Model
        Without imperfection; it is not changed.
    modes : int or sequence of Mode or array_like, shape (n, 3) or (n,)
        Shapes to seed: so many of the lowest eigenmodes (see :func:`seeds`), or your own.
    amplitudes : sequence of float, optional
        Largest offsets [length]; by default that of :meth:`kirigami.Model.imperfect`, a tenth and a
        hundredth of it.
    analysis : callable
        Makes the analysis of a model, such as ``functools.partial(kg.DisplacementControl, to=0.5)``. With processes it
        must be picklable: a function of a module, not a lambda.
    signs : sequence of int
        Signs with which each shape is seeded.
    mirrors : str
        Axes along which final shapes may be reflected and still count as the same. A flat sheet may always be turned
        over.
    alike : float
        Relative distance of two final shapes (root mean square over the area) below which they are the same.
    folder : path, optional
        Keeps every run there: with the same arguments the study goes on where it was stopped, also inside a run.
    executor : concurrent.futures.Executor, optional
        Does the runs, in processes for example; one after the other by default.

    Returns
    -------
    ImperfectionStudy
        One row per mode, sign and amplitude. A run that fails is a row with its message.

    Raises
    ------
    ModelError
        Amplitudes or shapes that cannot be used.

    Examples
    --------
    A two-link column that may buckle to either side: one shape, since its mirror image counts as the same.

    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> bottom, middle, top = m.add(kg.Node(0, 0), kg.Node(0, 1), kg.Node(0, 2))
    >>> bars = m.add(kg.Bar(bottom, middle, 1e4), kg.Bar(middle, top, 1e4), kg.TorsionSpring3(bottom, middle, top, 1))
    >>> held = m.add(kg.Fix(bottom), kg.Fix(top, "x"), kg.Prescribe(top, y=-0.2))
    >>> study = kg.study.imperfections(m, modes=[[[0, 0, 0], [1, 0, 0], [0, 0, 0]]], amplitudes=[1e-2, 1e-3])
    >>> len(study.cases), list(study.branches)
    (4, [1])
    """
    require_instance(model, Model, "model", "imperfections")
    if folder is not None:
        folder = require_path(folder, "folder", "imperfections")
    require_callable(analysis, "analysis", "imperfections")
    alike = require_positive(alike, "alike", "imperfections")
    signs = require_items(signs, "signs", "imperfections")
    if not isinstance(mirrors, str) or mirrors:
        require_axes(mirrors, "imperfections", "mirrors")
    require_executor(executor, "imperfections")
    if isinstance(modes, (int, np.integer)):
        shapes = seeds(model, modes)
    else:
        shapes = [_full(model, shape) for shape in require_items(modes, "modes", "imperfections")]
    if amplitudes is None:
        if model.sheet_constants is None:
            raise ModelError("imperfections: give amplitudes; only sheets have a thickness to measure them by")
        thinnest = float(np.min(model.sheet_constants.thickness))
        amplitudes = [share * thinnest for share in (SHARE, 0.1 * SHARE, 0.01 * SHARE)]
    listed = require_items(amplitudes, "amplitudes", "imperfections")
    sizes = [require_positive(a, "amplitude", "imperfections") for a in listed]
    signs = [require_whole(sign, "signs", "imperfections") for sign in signs]
    if not shapes or not sizes or not signs or any(sign not in (1, -1) for sign in signs):
        raise ModelError("imperfections: give at least one shape, one amplitude and one sign, which is 1 or -1")
    cases = [Case(mode, sign, size) for mode in range(1, len(shapes) + 1) for size in sizes for sign in signs]
    work = [(model, shapes[case.mode - 1], case, analysis, folder) for case in cases]
    answers = [_run(*job) for job in work] if executor is None else _in_executor(executor, work)
    rows, results = [row for row, _ in answers], [res for _, res in answers]
    return ImperfectionStudy(model, shapes, _with_branches(model, rows, results, mirrors, alike), results)


def _full(model: Model, shape: Any) -> Array:
    """A shape (n, 3) with largest component 1 from what :meth:`Model.perturb` takes."""
    probe = copy.deepcopy(model)
    probe.perturb(shape)
    offset = probe.positions() - model.positions()
    largest = np.abs(offset).max()
    if largest == 0:
        raise ModelError("imperfections: a shape is zero everywhere")
    return np.asarray(offset / largest)


def _in_executor(executor: Executor, work: list[Any]) -> list[tuple[Case, Results | None]]:
    waiting = [executor.submit(_run, *job) for job in work]
    return [future.result() for future in waiting]


def _run(
    model: Model, shape: Array, case: Case, analysis: Build, folder: str | os.PathLike[str] | None
) -> tuple[Case, Results | None]:
    """One run, and its row without the number of the branch."""
    bent = copy.deepcopy(model)
    bent.perturb(case.sign * shape, amplitude=case.amplitude)
    checkpoint = None
    if folder is not None:
        checkpoint = Path(folder) / f"mode{case.mode}{'+' if case.sign > 0 else '-'}_{case.amplitude:.6g}.npz"
    results: Results | None = None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", KirigamiWarning)  # a failure is told in its row
            results = analysis(bent).run(on_failure="return", checkpoint=checkpoint)
    except KirigamiError as error:
        return replace(case, status=f"{type(error).__name__}: {error}"), getattr(error, "results", None)
    status = "done"
    for event in results.events:
        if event.kind == "interrupted":
            raise KeyboardInterrupt
        if event.kind == "failed":
            status = str(event)
    results.forget_model()  # it is known by the study, and travels between processes
    return replace(case, status=status, **(_measured(bent, results) if len(results) else {})), results


def _measured(model: Model, results: Results) -> dict[str, Any]:
    from kirigami.system.system import System

    step = results[-1]
    system = System(model)
    system.history = step.history
    away = step.u[:, 2] if model.dim == 3 else np.linalg.norm(step.u, axis=1)
    return {
        "lam": step.lam,
        "energy": float(sum(values[-1] for values in results.energy.values())),
        "force": system.potential_rate(system.joined(step.u, step.inner), step.lam),
        "height": float(np.abs(away).max()),
        "factorizations": int(results.stats["factorizations"]),
    }


def _with_branches(
    model: Model, rows: list[Case], results: list[Results | None], mirrors: str, alike: float
) -> list[Case]:
    """The rows with the number of their final shape, counted in the order of the lowest energy."""
    ended = [k for k, row in enumerate(rows) if row.done]
    if not ended:
        return rows
    space = ShapeSpace(model, mirrors)
    rest = model.positions()
    fields = []
    for k in ended:
        found = results[k]
        assert found is not None
        fields.append(found.position()[-1] - rest)
    label = space.clusters(fields, alike)
    lowest = [min(rows[k].energy for k, own in zip(ended, label) if own == number) for number in range(label.max() + 1)]
    rank = np.argsort(np.argsort(lowest))
    for k, own in zip(ended, label):
        rows[k] = replace(rows[k], branch=int(rank[own]) + 1)
    return rows
