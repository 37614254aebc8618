"""A value with a band: two rungs of accuracy that err to opposite sides, and two meshes of the better one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from kirigami.elements.stiffness import RUNGS
from kirigami.errors import ModelError
from kirigami.primitives.checks import require_choice, require_items, require_positive, shown
from kirigami.study.accuracy import ALIKE, Case
from kirigami.study.mesh_choice import RATIO, MeshRun, run_case, shape_distance
from kirigami.words import counted, percent


@dataclass(frozen=True, eq=False)
class Bracket:
    """A value between bounds, and how far they can be trusted.

    Attributes
    ----------
    runs : tuple of MeshRun
        The first rung on both meshes, then the second one on both, each from coarse to fine.
    quantity : str
        What was looked at.
    low, high : float
        The band: the values of both rungs on the finer mesh.
    value : float
        The middle of the band.
    closing : bool
        Whether both rungs move towards each other as the mesh gets finer, without having met: only then do they err to
        opposite sides, and the band holds the limit they share.
    same_shape : bool
        Whether all four runs ended in the same shape.

    Examples
    --------
    See :func:`bracket`.
    """

    runs: tuple[MeshRun, ...]
    quantity: str
    low: float
    high: float
    value: float
    closing: bool
    same_shape: bool

    @property
    def half_width(self) -> float:
        """Half the width of the band over the value."""
        return 0.5 * (self.high - self.low) / abs(self.value)

    def __str__(self) -> str:
        name = self.quantity.replace("_", " ")
        lines = [
            f"{run.stiffness}, max_edge {run.max_edge:.4g}: {counted(run.nodes, 'node')}, {name} {run.value:.5g}, "
            f"{100 * run.membrane_share:.0f} % of the energy in stretching, {run.seconds:.1f} s"
            for run in self.runs
        ]
        width = f"+- {percent(self.half_width)}"
        lines.append(f"{name} {self.value:.4g}, band {self.low:.4g} to {self.high:.4g} ({width})")
        first, second = self.runs[1].stiffness, self.runs[3].stiffness
        if not self.same_shape:
            lines.append("this is no bracket: the runs end in different shapes, so they are on different branches")
        elif self.closing:
            lines.append(
                f"the band narrows from both sides as the mesh gets finer, so {first} and {second} err to opposite "
                "sides here: a limit they share lies within, provided that they go on like this"
            )
        else:
            lines.append(
                f"this is no bracket: {first} and {second} do not close in on each other from two sides, the band only "
                "tells how far they differ; take a finer mesh"
            )
        return "\n".join(lines)


def bracket(
    case: Case,
    max_edge: float,
    *,
    quantity: str = "force",
    stiffness: Sequence[str] = ("facet", "shell"),
    at: float = 1.0,
    ratio: float = RATIO,
) -> Bracket:
    """Run two rungs on two meshes, and see whether they enclose the value.

    Flat facets cannot follow a curved sheet without stretching, so that "plate" and "facet" are too stiff on coarse
    meshes of thin sheets, once these have buckled; shell facets follow it, and may be a little too soft where a facet
    turns far. At the tips of slits all rungs are too stiff: where these rule, the values close in from one side, and
    the text says that there is no bracket. What holds for the sheet at hand is what the coarser mesh is for.

    Parameters
    ----------
    case : callable
        ``case(max_edge, stiffness)`` returns (model, driven nodes, axis of the force); the imperfection must not
        depend on mesh and rung.
    max_edge : float
        Largest edge of the finer mesh [length].
    quantity : {"force", "open_area", "height"}
        Of what.
    stiffness : sequence of two str
        Rungs of accuracy.
    at : float
        Load factor.
    ratio : float
        Edge length of the coarser mesh over that of the finer one, more than 1.

    Returns
    -------
    Bracket
        Print it: it says whether the band is a bracket.

    Raises
    ------
    ModelError
        Unusable arguments.
    AnalysisError
        A value of zero.

    Notes
    -----
    No theorem stands behind it: postbuckled energies have no bounds from one side. It is an observation about four
    runs. The rungs "paper" and "plate" have limits of their own and enclose nothing on fine meshes.

    Examples
    --------
    >>> import numpy as np, shapely
    >>> import kirigami as kg
    >>> sheet = kg.Sheet(shapely.box(0, 0, 1, 1), thickness=0.01, material=kg.Material(E=1e6))
    >>> def bent(max_edge, stiffness):
    ...     m = kg.Model.from_mesh(sheet.mesh(max_edge), stiffness=stiffness)
    ...     left, right = m.select(boundary="left"), m.select(boundary="right")
    ...     objects = m.add(kg.Fix(left, clamp=True), kg.Prescribe(right, z=0.01))
    ...     return m, right, "z"
    >>> band = kg.study.bracket(bent, 0.3)
    >>> len(band.runs), band.low <= band.value <= band.high
    (4, True)
    """
    rungs = [
        require_choice(rung, RUNGS, "stiffness", "bracket") for rung in require_items(stiffness, "stiffness", "bracket")
    ]
    if len(rungs) != 2 or rungs[0] == rungs[1]:
        raise ModelError(f"bracket: stiffness must name two different rungs, got {shown(stiffness)}")
    if not require_positive(ratio, "ratio", "bracket") > 1:
        raise ModelError(f"bracket: ratio must be more than 1, got {ratio:g}")
    fine = require_positive(max_edge, "max_edge", "bracket")
    runs = tuple(run_case(case, size, rung, at, quantity, "bracket") for rung in rungs for size in (ratio * fine, fine))
    first_coarse, first, second_coarse, second = (run.value for run in runs)
    low, high = sorted((first, second))
    gap, gap_coarse = first - second, first_coarse - second_coarse
    towards = (first_coarse - first) * gap_coarse > 0 > (second_coarse - second) * gap_coarse
    same = all(shape_distance(runs[1].results, runs[k].results) <= ALIKE for k in (0, 2, 3))
    return Bracket(runs, quantity, low, high, 0.5 * (low + high), bool(same and towards and gap * gap_coarse > 0), same)
