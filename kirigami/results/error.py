"""What results are worth: an estimated relative error of force, open area and height at every stored step.

Three parts, each estimated from the stored states alone:

* *the mesh's*. The force is conjugate to the displacement that drives it, so that its relative error is that of the
  energy: the energy of what lies between the deformation and a smoother one (:mod:`kirigami.results.recovery`) over the
  energy stored and dissipated. Of another quantity J it is the work that this does on the same of the dual state z,
  K z = dJ/du with the tangent stiffness K at the step (Becker and Rannacher, 2001), facet by facet: its sum, and a
  share of the sum of its sizes for what has cancelled. The edge of a cut is an arc where the area of the rungs below
  the shell takes its chord: that is added.
* *the rung's*. Bars and hinges, and flat facets, do not store the energy that the theory of plates gives to their
  deformation; to first order the force and J are off by the difference. Shell facets obey the theory.
* *the tolerance's*: the unbalanced force over the reactions.

Strains of bars jump from facet to facet in the pattern of the mesh, so that what the mesh seems to lose and what the
rung seems to lack cancel for the most part. There the two are estimated as one: what plate theory gives to the smooth
deformation, less what the elements store, or for J the work of both on the dual state.

All but the tolerance is multiplied by `SAFETY`, calibrated by benchmarks/error_bar.py. What no estimate sees is said
in words by :mod:`kirigami.results.doubts`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kirigami.errors import AnalysisError
from kirigami.linalg import SingularMatrixError
from kirigami.post.shape import FLAT
from kirigami.primitives.kernel import Array
from kirigami.results.cut_edges import cut_edges
from kirigami.results.recovery import BENDING, MEMBRANE, Recovery
from kirigami.results.results import Results
from kirigami.results.sheet_state import SheetState
from kirigami.results.step import Step
from kirigami.results.tangent import StoredTangent
from kirigami.words import percent

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

SAFETY = 1.5  # times the estimate of the force
AREA_SAFETY, HEIGHT_SAFETY = 1.3, 1.75  # the same of the open area, and of the height, which bifurcations magnify
FACET_AREA_SAFETY, FACET_HEIGHT_SAFETY = 2.35, 2.2  # the same of flat facets
BARS_SAFETY = 1.0  # the same of the force of bars and hinges
BARS_AREA_SAFETY, BARS_HEIGHT_SAFETY = 1.5, 1.3
CANCELLED = 0.3  # share of what cancels over the sheet that is counted all the same
ENERGIES, DUALS = 10, 4  # steps that are looked at, and steps whose tangent is factored; the others lie between
CORNER = np.radians(30.0)  # turn of the rim of a cut at a node from which on it is a corner of it
NOTHING = 1e-12  # energy over the largest below which a state says nothing of its error

_Goal = Callable[[Recovery, Step], tuple[Array, float]]


@dataclass(frozen=True, eq=False)
class ErrorBar(Mapping[str, Array]):
    """Estimated relative errors, ``error["force"]``, ``error["open_area"]`` and ``error["height"]``, each (s,).

    Of the force at the displacement there, or where a load is given of its displacement, over the stated value; of
    heights and areas over the largest on the path; nan where there is no height, or no cut, and where rows that nodes
    follow are free, as those of a periodic cell or a rigid link.

    Attributes
    ----------
    total : dict of ndarray, each (s,)
        The error bar by quantity.
    mesh, rung : dict of ndarray, each (s,)
        The parts of mesh and rung, with their safety, each alone; what they have of each other's opposite sign cancels
        in part.
    tolerance : ndarray, shape (s,)
        The part of the tolerance, of every quantity.

    Examples
    --------
    >>> import kirigami as kg, shapely
    >>> sheet = kg.Sheet(shapely.box(0, 0, 1, 1), shapely.LineString([(0.3, 0.5), (0.7, 0.5)]), 0.01, kg.Material(1e6))
    >>> m = kg.Model.from_mesh(sheet.mesh(nodes=200), stiffness="shell")
    >>> top = m.select(boundary="top")
    >>> held = m.add(kg.Fix(m.nodes, "z"), kg.Fix(m.select(boundary="bottom"), "xy"), kg.Prescribe(top, x=0, y=1e-3))
    >>> error = kg.LinearStatic(m).run().error
    >>> bool(0.001 < error["force"][-1] < 0.02), list(error)
    (True, ['force', 'open_area', 'height'])
    """

    total: dict[str, Array]
    mesh: dict[str, Array]
    rung: dict[str, Array]
    tolerance: Array

    def __getitem__(self, quantity: str) -> Array:
        return self.total[quantity]

    def __iter__(self) -> Iterator[str]:
        return iter(self.total)

    def __len__(self) -> int:
        return len(self.total)

    def __str__(self) -> str:
        told = []
        for name in self:
            total = self[name]
            if len(total) and np.isfinite(total[-1]):
                parts = f"mesh {percent(self.mesh[name][-1])}, rung {percent(self.rung[name][-1])}"
                told.append(f"{name.replace('_', ' ')} {percent(total[-1])} ({parts})")
        if not told:
            return "no error is estimated at the last step"
        return "estimated error at the last step: " + ", ".join(told)

    __repr__ = __str__


def estimated_error(results: Results) -> ErrorBar:
    """The error bar of results; see :class:`ErrorBar`.

    Raises
    ------
    AnalysisError
        The model was not made from a mesh, or moves; its bars and hinges can yield; or it has bars, hinges or flat
        facets on a mesh that was not drawn flat, of which not all that they make of a curve is estimated.
    """
    mesh = results.mesh
    if mesh is None or results.sheet_constants is None:
        raise AnalysisError(
            "the error is estimated of sheets: of a model made by Model.from_mesh, with thickness and material",
            results=results,
        )
    if results.moves:
        raise AnalysisError("the error is estimated of equilibria, not of motions", results=results)
    recovery = Recovery(results, mesh)
    if recovery.shell is None and results.dim == 3 and np.ptp(mesh.nodes[:, 2]) > FLAT * mesh.size:
        raise AnalysisError(
            "the error of bars, hinges and flat facets is estimated on meshes that were drawn flat; of "
            "stiffness='shell' on any",
            results=results,
        )
    if recovery.shell is None and not results.linear and any(k.plastic() is not None for k in results.kernels):
        raise AnalysisError(
            "the error of bars and hinges that can yield is not estimated; of stiffness='shell' it is", results=results
        )
    force, of_mesh, of_rung = _of_force(results, recovery)
    quantities = {"open_area": _opening, "height": _heights}
    meshes, rungs = {"force": of_mesh}, {"force": of_rung}
    scales = {"open_area": _largest_area(results, mesh), "height": _largest_height(results)}
    chosen = _some(len(results), DUALS)
    found: dict[str, list[Array]] = {name: [] for name in quantities if scales[name] > 0}
    for number in chosen.tolist() if found and len(results) else ():
        step = results[number]
        for name, errors in zip(found, _of_goals(recovery, step, [quantities[name] for name in found])):
            found[name].append(np.array(errors) / scales[name])
    tolerance = _unbalanced(results)
    total = {"force": force + tolerance}
    for name in quantities:
        both = meshes[name] = rungs[name] = np.full(len(results), np.nan)
        if name in found:
            values = np.array(found[name]).reshape(-1, 3).T
            both, meshes[name], rungs[name] = (_between(chosen, column, len(results), np.nan) for column in values)
        total[name] = both + tolerance
    return ErrorBar(total, meshes, rungs, tolerance)


def _of_force(results: Results, recovery: Recovery) -> tuple[Array, Array, Array]:
    """The error of the force at every step, and the parts of mesh and rung in it: too coarse a mesh is too stiff, and a
    rung that stores less than it should is too soft."""
    chosen = _some(len(results), ENERGIES)
    taken, lost, off, both = np.zeros((4, len(chosen)))
    for number, step in enumerate(results[k] for k in chosen.tolist()):
        taken[number] = _taken(results, step)
        state = recovery.state(step)
        fields = recovery.fields(step, state)
        lost[number] = sum(part.sum() for part in recovery.lost(step, fields))
        together = lost[number]
        if state is not None:
            stored = state.membrane_energy.sum() + state.bending_energy.sum()
            smooth = recovery.smooth(fields)
            off[number] = 0.5 * _work(recovery, _mixed(fields, smooth), _mixed(fields, smooth)) - stored
            together = lost[number] - off[number]
            if recovery.patterned:
                level = _mixed(smooth, fields)
                together = 0.5 * _work(recovery, level, level) - stored
        both[number] = abs(together) + CANCELLED * min(lost[number], max(off[number], 0.0))
    known = taken > NOTHING * taken.max(initial=0.0)
    safety = BARS_SAFETY if recovery.patterned else SAFETY
    parts = ((both, safety), (lost, SAFETY), (off, SAFETY))
    shares = [np.where(known, times * np.abs(part) / np.where(known, taken, 1.0), np.nan) for part, times in parts]
    return (
        _between(chosen, shares[0], len(results)),
        _between(chosen, shares[1], len(results)),
        _between(chosen, shares[2], len(results)),
    )


def _taken(results: Results, step: Step) -> float:
    """Energy stored, and dissipated by yield."""
    total = sum(results.member_energy(kernel, step).sum() for kernel in results.kernels if kernel.stores_energy)
    if not results.linear:
        flowed = [kernel for kernel in results.kernels if kernel.plastic() is not None]
        total += sum(results.member_dissipation(kernel, step).sum() for kernel in flowed)
    return float(total)


def _mixed(stretched: Array, bent: Array) -> Array:
    """The deformation (m, 3, 6) with the strain of one and the curvature of another."""
    return np.concatenate([stretched[..., MEMBRANE], bent[..., BENDING]], axis=-1)


def _work(recovery: Recovery, one: Array, other: Array) -> float:
    """Work of the stress that plate theory makes of a deformation on another."""
    return float(sum(part.sum() for part in recovery.work(one, other)))


def _of_goals(recovery: Recovery, step: Step, goals: list[_Goal]) -> list[tuple[float, float, float]]:
    """Errors of mesh and rung together, and of each, in quantities at a step; nan where the tangent is singular."""
    results = recovery.results
    try:
        tangent = StoredTangent(results, step)
    except SingularMatrixError:
        return [(float("nan"),) * 3] * len(goals)
    state = recovery.state(step)
    fields = recovery.fields(step, state)
    smooth = recovery.smooth(fields)
    found = []
    for goal in goals:
        load, chord = goal(recovery, step)
        dual = tangent.solve(load)
        rate = recovery.rate(step, dual)
        smooth_rate = recovery.smooth(rate)
        borne = recovery.borne(step, fields)
        smooth_borne = smooth if borne is fields else recovery.smooth(borne)
        work = np.concatenate(recovery.work(smooth_borne - borne, smooth_rate - rate))
        cancelled = CANCELLED * float(np.abs(work).sum()) + chord
        mesh, rung = abs(float(work.sum())) + cancelled, 0.0
        both = mesh
        if state is not None:  # the strain as it is, and the smooth curvature, since angles at edges jump
            borne_work = _borne(recovery, state, rate)
            rung = abs(_work(recovery, _mixed(fields, smooth), _mixed(rate, smooth_rate)) - borne_work)
            both += rung
            if recovery.patterned:
                together = _work(recovery, _mixed(smooth, fields), _mixed(smooth_rate, rate)) - borne_work
                both = abs(together) + cancelled
        own, of_both = _safeties(recovery, goal is _heights)
        found.append((of_both * both, own * mesh, own * rung))
    return found


def _safeties(recovery: Recovery, high: bool) -> tuple[float, float]:
    """Times the parts of mesh and rung of an area or a height, and times what they come to together."""
    if recovery.patterned:
        return (HEIGHT_SAFETY, BARS_HEIGHT_SAFETY) if high else (AREA_SAFETY, BARS_AREA_SAFETY)
    if recovery.shell is None:
        return (FACET_HEIGHT_SAFETY,) * 2 if high else (FACET_AREA_SAFETY,) * 2
    return (HEIGHT_SAFETY,) * 2 if high else (AREA_SAFETY,) * 2


def _borne(recovery: Recovery, state: SheetState, rate: Array) -> float:
    """Work of the forces and moments of the elements on a deformation."""
    turn = recovery.reader.turn
    total = 0.0
    for tensor, part in ((state.force, MEMBRANE), (state.moment, BENDING)):
        local = turn @ tensor @ turn.transpose(0, 2, 1)
        flat = np.stack([local[:, 0, 0], local[:, 1, 1], local[:, 0, 1]], axis=1)
        total += float((recovery.area[:, None] * flat * rate[..., part].mean(axis=1)).sum())
    return total


# ---- quantities: their derivative by the displacements (rows, dim), and what chords of curved edges leave out of them


def _opening(recovery: Recovery, step: Step) -> tuple[Array, float]:
    results, mesh = recovery.results, recovery.mesh
    gradient = np.zeros((len(results.rest) + len(results.inner_rest), results.dim))
    x = np.asarray(results.configuration(step))
    left_out = 0.0
    for edges in cut_edges(results, mesh):
        area, rate = edges.area(x)
        if area <= 0:
            continue
        gradient += rate
        if not edges.curved.any():
            loop = edges.start
            left_out += _over_chords(x[loop, :2]) - _over_chords(results.rest[loop, :2])  # drawn corners stay corners
    return gradient, abs(left_out)


def _heights(recovery: Recovery, step: Step) -> tuple[Array, float]:
    results = recovery.results
    gradient = np.zeros((len(results.rest) + len(results.inner_rest), results.dim))
    heights = results.rest[:, 2] + step.u[:, 2]
    gradient[int(heights.argmax()), 2] += 1.0
    gradient[int(heights.argmin()), 2] -= 1.0
    return gradient, 0.0


def _over_chords(loop: Array) -> float:
    """Area between a smooth closed line through points (k, 2) and its chords, L^2 / 12 times the turn between them."""
    chord = np.roll(loop, -1, axis=0) - loop
    back = np.roll(chord, 1, axis=0)
    turn = np.arctan2(back[:, 0] * chord[:, 1] - back[:, 1] * chord[:, 0], (back * chord).sum(axis=1))
    turn = np.where(np.abs(turn) < CORNER, turn, 0.0)
    return float(((chord**2).sum(axis=1) / 24 * (turn + np.roll(turn, -1))).sum())


def _largest_area(results: Results, mesh: TriMesh) -> float:
    if not mesh.cuts:
        return 0.0
    return float(np.maximum(results.open_area(), 0.0).sum(axis=1).max(initial=0.0))


def _largest_height(results: Results) -> float:
    if results.dim == 2 or not len(results) or results.mesh is None:
        return 0.0
    largest = float(results.height().max())
    return largest if largest > NOTHING * results.mesh.size else 0.0


# ---- steps without a number of their own


def _some(count: int, most: int) -> Array:
    """Some of the steps (k,), evenly spread and with the last; the first, at rest, only where it is the only one."""
    return np.unique(np.linspace(min(1, count - 1), count - 1, most).round().astype(int)) if count else np.zeros(0, int)


def _between(steps: Array, values: Array, count: int, where_none: float = 0.0) -> Array:
    """Values at all steps, from those at some; their logarithms are interpolated. States that store nothing are as
    wrong as the next one that does; where none does, nothing is wrong. What is known nowhere is no zero."""
    known = np.isfinite(values)
    if not known.any():
        return np.full(count, where_none)
    floor = NOTHING
    logs = np.log(np.maximum(values[known], floor))
    found = np.exp(np.interp(np.arange(count), steps[known], logs))
    return np.where(found > 2 * floor, found, 0.0)


def _unbalanced(results: Results) -> Array:
    """Unbalanced force over the reactions at every step, over the forces of the elements where there are none."""
    share = np.array([step.residual_over_reaction for step in results.steps])
    share = np.where(np.isfinite(share), share, results.residual)
    return np.where(np.isfinite(share), share, 0.0)
