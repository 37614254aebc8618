"""The energy that a slit would set free if it grew: what converges at its tips, where strain and stress do not.

G = -dU/da per area of new crack, with the grips held, is the derivative of the stored energy by the place of the tip at
rest. At an equilibrium the energy does not change with the displacements, so that the nodes round the tip are moved in
the rest state alone (virtual crack extension; Parks, 1974; deLorenzi, 1982): by one unit within half of a distance from
the tip, less and less up to the whole, and not at all beyond. That is the J integral over the domain in between, also
of a sheet that has buckled, where stretching and bending tear alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.surface import SurfaceKernel, surfaces_of
from kirigami.errors import AnalysisError, ModelError
from kirigami.primitives.checks import require_whole
from kirigami.primitives.kernel import Array, Configuration
from kirigami.results.linearised import linear_contribution
from kirigami.results.results import Results

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh

Index = NDArray[np.int64]
SLIT = 0.3  # opening of a tip at rest over the length of its lips, above which it is a corner
STRAIGHT = 0.1  # sideways over back, within which a lip is straight behind its tip
REACH = 0.5  # of the distance to what may not move
SHARE = 1e-4  # of that distance by which nodes are moved


@dataclass(frozen=True, eq=False)
class Tip:
    """The end of a slit: its node, its place (2,), and the unit vector (2,) along which it would grow."""

    node: int
    place: Array
    direction: Array


def tips(mesh: TriMesh, cut: int) -> list[Tip]:
    """The tips of a cut, in the order in which they stand round it.

    Raises
    ------
    ModelError
        No such cut.

    Examples
    --------
    >>> from kirigami.results.fracture import tips
    >>> import kirigami as kg, shapely
    >>> mesh = kg.Sheet(shapely.box(0, 0, 1, 1), shapely.LineString([(0.3, 0.5), (0.7, 0.5)])).mesh(0.1)
    >>> sorted(tip.place.round(6).tolist() for tip in tips(mesh, 0))
    [[0.3, 0.5], [0.7, 0.5]]
    """
    cut = require_whole(cut, "cut", "energy_release")
    if not 0 <= cut < len(mesh.cuts):
        raise ModelError(f"energy_release: there is no cut {cut}: the mesh has {len(mesh.cuts)} of them, from 0 on")
    loop = np.asarray(mesh.cuts[cut].loop)
    place = mesh.nodes[loop, :2]
    before, after = place - np.roll(place, 1, axis=0), place - np.roll(place, -1, axis=0)
    length = 0.5 * (np.linalg.norm(before, axis=1) + np.linalg.norm(after, axis=1))
    sharp = np.linalg.norm(before - after, axis=1) < SLIT * length
    if mesh.cuts[cut].open:
        sharp[[0, -1]] = False
    found = []
    for k in np.flatnonzero(sharp).tolist():
        ahead = before[k] + after[k]
        found.append(Tip(int(loop[k]), place[k], ahead / np.linalg.norm(ahead)))
    return found


def energy_release(results: Results, cut: int = 0) -> Array:
    """Energy that is set free per area of new crack, at each tip of a slit.

    In the plane it is K_I^2 / E + K_II^2 / E; bending and twisting at the tip count as well. Unlike the largest strain,
    which grows with every finer mesh, it converges.

    Parameters
    ----------
    cut : int
        Number of the cut, in the order of ``mesh.cuts``.

    Returns
    -------
    ndarray, shape (s, tips)
        Energy release rate [force / length] at each step and tip; the tips as in
        :func:`kirigami.results.fracture.tips`.

    Raises
    ------
    AnalysisError
        The model was not made from a mesh, or of bars and hinges, whose stress at a tip means nothing.
    ModelError
        No such cut, or one without a tip, as a hole.

    Examples
    --------
    >>> import kirigami as kg, shapely
    >>> sheet = kg.Sheet(shapely.box(0, 0, 1, 3), shapely.LineString([(0.3, 1.5), (0.7, 1.5)]), 0.01, kg.Material(1.0))
    >>> m = kg.Model.from_mesh(sheet.mesh(nodes=600), stiffness="shell")
    >>> top = m.select(boundary="top")
    >>> held = m.add(kg.Fix(m.nodes, "z"), kg.Fix(m.select(boundary="bottom"), "xy"), kg.Prescribe(top, x=0, y=0.003))
    >>> res = kg.LinearStatic(m).run()
    >>> stress = res.reaction(top, "y")[-1] / 0.01
    >>> import numpy as np  # K = stress sqrt(pi a / cos(pi a / W)), G = K^2 / E (Feddersen, 1966)
    >>> bool(np.allclose(res.energy_release(0)[-1] / (stress**2 * np.pi * 0.2 / np.cos(np.pi * 0.2)), 1.0, atol=0.03))
    True
    """
    mesh, constants = results.mesh, results.sheet_constants
    if mesh is None or constants is None:
        raise AnalysisError("energy_release needs a model made by Model.from_mesh", results=results)
    kernels = surfaces_of(results.kernels, "energy_release")
    if any(kernel.plastic() is not None for kernel in kernels) and not results.linear:
        raise AnalysisError(
            "energy_release is that of a sheet that stays elastic: what yields at a tip takes energy on the way there; "
            "give the material hardening=None, or look at a linear analysis",
            results=results,
        )
    if not kernels:
        raise AnalysisError(
            "energy_release needs facets: the stress of bars and hinges at a tip means nothing; take stiffness='shell' "
            "or 'facet'",
            results=results,
        )
    found = tips(mesh, cut)
    if not found:
        raise ModelError(f"energy_release: cut {cut} has no tip; it is a hole, or ends on rims")
    ends = np.array([tip.node for number in range(len(mesh.cuts)) for tip in tips(mesh, number)])
    released = np.zeros((len(results), len(found)))
    for column, tip in enumerate(found):
        moved, reach = _moved(mesh, tip, ends[ends != tip.node])
        at_tip = (mesh.triangles == tip.node).any(axis=1)
        thickness = float(constants.thickness_of_facets(len(mesh.triangles))[at_tip].mean())
        share = SHARE * reach
        for sign in (1.0, -1.0):
            rest = results.configuration()[:, : results.dim].copy()
            rest[: len(moved), :2] += sign * share * moved[:, None] * tip.direction
            for kernel in kernels:
                twin = kernel.on_rest(rest)
                energies = [_energy(results, kernel, twin, number) for number in range(len(results))]
                released[:, column] -= sign * np.array(energies) / (2 * share * thickness)
    return released


def _moved(mesh: TriMesh, tip: Tip, others: Index) -> tuple[Array, float]:
    """How far each node (n,) moves with the tip, and the distance from which on none does; `others` are the nodes of
    other tips, which stay."""
    place = mesh.nodes[:, :2] - tip.place
    distance = np.linalg.norm(place, axis=1)
    rim = np.unique(mesh.edges[mesh.boundary_edges])
    back = -place[rim] @ tip.direction
    aside = np.linalg.norm(place[rim] + back[:, None] * tip.direction, axis=1)
    behind = (back > 0) & (aside <= STRAIGHT * back) | (rim == tip.node)
    reach = REACH * float(distance[np.append(rim[~behind], others)].min(initial=float(mesh.size)))
    weight: Array = np.clip(2 * (1 - distance / reach), 0.0, 1.0)
    return weight, reach


def _energy(results: Results, kernel: SurfaceKernel, twin: SurfaceKernel, number: int) -> float:
    """Energy at a step of a kernel with another rest state; of a linear analysis to second order."""
    step = results[number]
    rows = results.rows(step)
    if results.linear:
        at_rest = Configuration(twin.rest, np.zeros_like(rows))
        return float(linear_contribution(twin, at_rest, step.lam, rows).energy.sum())
    before = kernel.history
    position = next(k for k, other in enumerate(results.kernels) if other is kernel)
    if before is not None and position < len(step.history) and step.history[position] is not None:
        twin.history = step.history[position]
    return float(twin.evaluate(Configuration(twin.rest, rows), step.lam, 0).energy.sum())
