"""How fine a mesh must be, and what a value is worth: from two or three runs on coarse meshes.

A value on meshes of edge length h behaves as f(h) = f0 + c h^p once the mesh is fine enough (Richardson, 1911; Roache,
1998). Two runs and an assumed p give f0 and the length for a wanted error; a third one tests both. None of this holds
when the runs are on different branches of equilibria, which is looked for first.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from kirigami.analysis.path.methods import DisplacementControl
from kirigami.elements.stiffness import rung_named
from kirigami.errors import AnalysisError
from kirigami.primitives.checks import (
    require_between,
    require_callable,
    require_choice,
    require_positive,
    require_whole,
)
from kirigami.primitives.kernel import Array
from kirigami.primitives.node import Node
from kirigami.results.results import Results
from kirigami.study.accuracy import ALIKE, Case, quantities
from kirigami.study.convergence import limit_of
from kirigami.study.reference import QUANTITIES
from kirigami.words import counted, percent

RATIO = 1.5  # of the edge lengths of the first two runs
CLOSER = 1.25  # least refinement of the third run
LARGEST_STEP = 4.0  # largest refinement of the third run: beyond, two coarse runs say too little
SAFETY = 0.6  # of the wanted error is aimed at
FLAT = 1e-3  # height over size of the sheet below which shapes are not compared


@dataclass(frozen=True, eq=False)
class MeshRun:
    """One run of a case.

    Attributes
    ----------
    stiffness : str
        Rung of accuracy.
    max_edge : float
        Largest mesh edge [length].
    nodes : int
        Nodes of the mesh.
    value : float
        The quantity at the load factor.
    membrane_share : float
        Energy of stretching over all energy of the sheet.
    seconds : float
        CPU time.
    results : Results
        The run itself.
    """

    stiffness: str
    max_edge: float
    nodes: int
    value: float
    membrane_share: float
    seconds: float
    results: Results = field(repr=False)


@dataclass(frozen=True, eq=False)
class MeshChoice:
    """A mesh size for a wanted error, and the runs that led to it.

    Attributes
    ----------
    runs : tuple of MeshRun
        The runs from coarse to fine.
    quantity : str
        What was looked at.
    error : float
        The wanted relative error.
    limit : float
        The value towards which the runs go.
    order : float
        Order of convergence observed in the last three runs; nan where they do not converge evenly.
    errors : ndarray, shape (k,)
        Estimated relative error of each run.
    expected : float
        Error that the runs before let expect of the last.

    Examples
    --------
    See :func:`choose_mesh`.
    """

    runs: tuple[MeshRun, ...]
    quantity: str
    error: float
    limit: float
    order: float
    errors: Array
    expected: float

    @property
    def reached(self) -> bool:
        """Whether one of the runs is estimated to be within the wanted error."""
        return bool((self.errors <= self.error).any())

    @property
    def run(self) -> MeshRun:
        """The coarsest run within the wanted error, with all finer ones; else the finest there is."""
        good = self.errors <= self.error
        first = len(good)
        while first > 0 and good[first - 1]:
            first -= 1
        return self.runs[min(first, len(good) - 1)]

    @property
    def max_edge(self) -> float:
        """The chosen mesh size [length]."""
        return self.run.max_edge

    def __str__(self) -> str:
        name = self.quantity.replace("_", " ")
        last = self.runs[-1]
        lines = [
            f"max_edge {run.max_edge:.4g}: {counted(run.nodes, 'node')}, {name} {run.value:.5g}, "
            f"estimated error {percent(error)}, {run.seconds:.1f} s"
            for run, error in zip(self.runs, self.errors)
        ]
        if np.isnan(self.order):
            lines.append(
                "the last three runs do not converge evenly: their errors are rough, from the changes between runs as "
                "if of order 1; a finer start may help"
            )
        else:
            lines.append(f"observed order {self.order:.2g}; {name} tends to {self.limit:.5g}")
        lines.append(f"at max_edge {last.max_edge:.4g}: expected {percent(self.expected)}, got "
                     f"{percent(self.errors[-1])}")  # fmt: skip
        if self.reached:
            chosen = self.run
            size = f"max_edge {chosen.max_edge:.4g} ({counted(chosen.nodes, 'node')})"
            lines.append(f"{100 * self.error:g} % in {name}: take {size}")
        else:
            lines.append(
                f"{100 * self.error:g} % in {name}: not reached, the last run is within {percent(self.errors[-1])}; "
                f"start again from max_edge {last.max_edge:.4g}"
            )
        return "\n".join(lines)


def choose_mesh(
    case: Case,
    start: float,
    error: float = 0.05,
    *,
    quantity: str = "force",
    stiffness: str = "shell",
    at: float = 1.0,
    order: float | None = None,
    most: int = 4,
) -> MeshChoice:
    """Choose the mesh size for a wanted error from two coarse runs, and test the choice by another.

    Parameters
    ----------
    case : callable
        ``case(max_edge, stiffness)`` returns (model, driven nodes, axis of the force); the imperfection must not
        depend on the mesh.
    start : float
        Largest edge of the first, coarsest run [length].
    error : float
        Wanted relative error.
    quantity : {"force", "open_area", "height"}
        Of what.
    stiffness : str
        Rung of accuracy; only "shell" converges to the sheet, the others to a limit of their own.
    at : float
        Load factor.
    order : float, optional
        Order of convergence assumed for the first two runs; by default 2, and 1 for a sheet with cuts, because the
        stress at their tips grows without bound (Grisvard, 1985).
    most : int
        Largest number of runs, at least 3; a fourth is made where the third has shown another order than assumed.

    Returns
    -------
    MeshChoice
        Print it: it says what was expected, what the third run gave, and which size to take.

    Raises
    ------
    ModelError
        Unusable arguments.
    AnalysisError
        Two runs ended on different branches, or with the value zero.

    Examples
    --------
    >>> import shapely
    >>> import kirigami as kg
    >>> slit = shapely.LineString([(0.5, 0.3), (0.5, 0.7)])
    >>> sheet = kg.Sheet(shapely.box(0, 0, 1, 1), slit, thickness=0.01, material=kg.Material(E=1e6))
    >>> def pulled(max_edge, stiffness):
    ...     m = kg.Model.from_mesh(sheet.mesh(max_edge), stiffness=stiffness, dim=2)
    ...     left, right = m.select(boundary="left"), m.select(boundary="right")
    ...     objects = m.add(kg.Fix(left), kg.Prescribe(right, x=0.001, y=0))
    ...     return m, right, "x"
    >>> choice = kg.study.choose_mesh(pulled, start=0.2, error=0.03, stiffness="facet")
    >>> choice.reached, choice.max_edge <= 0.2
    (True, True)
    """
    error = require_positive(error, "error", "choose_mesh")
    most = require_whole(most, "most", "choose_mesh", least=1)
    start = require_positive(start, "start", "choose_mesh")
    given = None if order is None else require_between(order, 0.1, 10.0, "order", "choose_mesh")
    runs = [run_case(case, size, stiffness, at, quantity, "choose_mesh") for size in (start, start / RATIO)]
    _same_branch(runs[0], runs[1], "choose_mesh")
    mesh = runs[1].results.mesh
    assumed = given if given is not None else 1.0 if mesh is not None and mesh.cuts else 2.0
    change = runs[1].value - runs[0].value
    limit = runs[1].value + change / (RATIO**assumed - 1)
    now, seen, errors = abs(runs[1].value / limit - 1) if limit else np.inf, assumed, np.empty(0)
    while len(runs) < max(most, 3):
        last = runs[-1]
        closer = max((now / (SAFETY * error)) ** (1 / assumed), CLOSER)
        finer = last.max_edge / min(closer, LARGEST_STEP)
        expected = now * (finer / last.max_edge) ** assumed
        runs.append(run_case(case, finer, stiffness, at, quantity, "choose_mesh"))
        _same_branch(last, runs[-1], "choose_mesh")
        limit, seen, errors = _judged(runs)
        if errors[-1] <= error or np.isnan(seen):
            break
        now, assumed = float(errors[-1]), seen
    return MeshChoice(tuple(runs), quantity, error, limit, seen, errors, float(expected))


def _judged(runs: Sequence[MeshRun]) -> tuple[float, float, Array]:
    """Limit and order that the last three runs have, and the error of every run."""
    sizes, values = np.array([run.max_edge for run in runs]), np.array([run.value for run in runs])
    limit, seen, last = limit_of(sizes, values)
    if np.isnan(seen):  # no law to extrapolate with: no less than the spread of later runs
        errors = (np.maximum.accumulate(np.abs(values - limit)[::-1])[::-1] + last) / abs(limit)
    else:
        errors = np.abs(values / limit - 1)
    return limit, seen, errors


def run_case(case: Case, max_edge: float, stiffness: str, at: float, quantity: str, owner: str) -> MeshRun:
    """Run a case to a load factor, and take the value there."""
    require_callable(case, "case", owner)
    require_choice(quantity, QUANTITIES, "quantity", owner)
    stiffness = rung_named(stiffness, owner)
    at = require_positive(at, "at", owner)
    begin = time.process_time()
    model, nodes, axis = case(require_positive(max_edge, "max_edge", owner), stiffness)
    results = DisplacementControl(model, to=at, targets=[at]).run()
    value = last_value(results, nodes, axis, quantity)
    if not np.isfinite(value) or value == 0:
        raise AnalysisError(
            f"{owner}: the {quantity.replace('_', ' ')} at load factor {at:g} is {value:g} on the mesh of max_edge "
            f"{max_edge:g}, so it has no relative error: choose another quantity",
            results=results,
        )
    share = float(results.stress(-1).membrane_share)
    mesh = results.mesh
    assert mesh is not None
    return MeshRun(stiffness, max_edge, len(mesh.nodes), value, share, time.process_time() - begin, results)


def last_value(results: Results, nodes: Sequence[Node], axis: str, quantity: str) -> float:
    """A quantity at the last step."""
    return float(quantities(results, nodes, axis)[quantity][-1])


def shape_distance(one: Results, other: Results) -> float:
    """Relative distance of the heights at the last step of one sheet on two meshes, up to reflections and sides.

    0 for equal shapes; 0 also where both are flat, and infinite where one of them is.
    """
    from scipy.spatial import KDTree

    from kirigami.study.shape.space import ShapeSpace, _barycentric

    mesh, second = one.mesh, other.mesh
    assert mesh is not None and second is not None
    if one.dim == 2:
        return 0.0
    heights = [(r.rest[:, 2] + r.u[-1, :, 2])[: len(m.nodes)] for r, m in ((one, mesh), (other, second))]
    bent = [float(np.ptp(z)) > FLAT * mesh.size for z in heights]
    if not all(bent):
        return float("inf") if any(bent) else 0.0
    corners = second.triangles[
        KDTree(second.nodes[second.triangles].mean(axis=1)).query(mesh.nodes[mesh.triangles].mean(axis=1))[1]
    ]
    centres = mesh.nodes[mesh.triangles, :2].mean(axis=1)
    shares = _barycentric(second.nodes[corners][:, :, :2], centres)
    there = np.einsum("pc,pc->p", shares, heights[1][corners])
    space = ShapeSpace(one.model)
    here = heights[0][mesh.triangles].mean(axis=1)
    lifted = np.zeros((2, len(mesh.nodes), 3))  # both taken at the facets, so that both lose alike by it
    lifted[:, :, 2] = mesh.nodal_mean(np.column_stack([here, there])).T
    return space.distance(lifted[0], lifted[1])


def _same_branch(one: MeshRun, other: MeshRun, owner: str) -> None:
    """An AnalysisError where two runs ended in different shapes."""
    distance = shape_distance(one.results, other.results)
    if distance > ALIKE:
        raise AnalysisError(
            f"{owner}: the runs with max_edge {one.max_edge:.4g} and {other.max_edge:.4g} end on different branches: "
            f"their shapes differ by {100 * distance:.0f} % (values {one.value:.5g} and {other.value:.5g}), so no mesh "
            "size follows from them. Start from a finer mesh, or lead both by the same, larger imperfection",
            results=other.results,
        )
