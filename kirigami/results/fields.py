"""Fields for colouring a deformed sheet: height, strain of the facets, stored energy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kirigami.elements.triangle import SurfaceStrain
from kirigami.errors import AnalysisError
from kirigami.post.shape import principal_values
from kirigami.primitives.kernel import Array
from kirigami.results.results import Results
from kirigami.results.step import Step


def facet_strain(results: Results) -> Array:
    """Largest principal Green strain of each facet, from its rest state.

    The Green strains of its three edges determine it; see :mod:`kirigami.elements.triangle`.

    Parameters
    ----------
    results : Results
        Of a model that was made from a mesh.

    Returns
    -------
    ndarray, shape (s, facets)

    Raises
    ------
    AnalysisError
        The model was not made from a mesh.

    Examples
    --------
    >>> from kirigami.results.fields import facet_strain
    >>> import kirigami as kg
    >>> mesh = kg.TriMesh([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]])
    >>> m = kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e6))
    >>> res = kg.Results(kg.System(m))
    >>> res.append(kg.Step.at(m, 1.0, [[0, 0, 0], [0.1, 0, 0], [0, 0, 0]]))
    >>> facet_strain(res).round(12).tolist()  # (1.1**2 - 1) / 2
    [[0.105]]
    """
    if results.mesh is None:
        raise AnalysisError("facet strains need a model made by Model.from_mesh", results=results)
    surface = SurfaceStrain(results.rest, results.mesh.triangles)
    values = np.empty((len(results), len(results.mesh.triangles)))
    for row, step in zip(values, results.steps):
        exx, eyy, shear = surface.at(step.u, results.linear).T
        row[:] = principal_values(exx, eyy, 0.5 * shear)[:, 0]
    return values


def nodal_energy(results: Results, step: int | None = None) -> Array:
    """Stored energy at each node: every element gives equal shares to its nodes.

    Parameters
    ----------
    results : Results
        Of any model.
    step : int, optional
        Number of one stored step; None takes all of them.

    Returns
    -------
    ndarray, shape (s, n), or (n,) for one step
        Energy [force length]; the sum over the nodes is the energy stored in the structure.

    Examples
    --------
    >>> from kirigami.results.fields import nodal_energy
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> nodal_energy(kg.LinearStatic(m).run()).round(12).tolist()
    [[0.0, 0.0], [0.05, 0.05]]
    """
    if step is None:  # asked for by pages and files alike
        own: Array = np.array(results.once("nodal energy", lambda: _nodal_energy(results, results.steps)))
        return own
    return np.asarray(_nodal_energy(results, [results.steps[step]])[0])


def _nodal_energy(results: Results, steps: Sequence[Step]) -> Array:
    total = np.zeros((len(steps), len(results.rest)))
    for kernel in results.kernels:
        if not kernel.stores_energy or not len(kernel.conn):
            continue
        nodes = kernel.places
        if nodes is None:  # of its rows, those behind the nodes have no place
            nodes = kernel.conn[:, (kernel.conn < len(results.rest)).all(axis=0)]
        for row, step in zip(total, steps):
            np.add.at(row, nodes, results.member_energy(kernel, step)[:, None] / nodes.shape[1])
    return total


def energy_density(results: Results, step: int | None = None) -> Array:
    """Stored energy per area of the sheet at each node; of a model without a mesh, per node.

    Parameters
    ----------
    results : Results
        Of any model.
    step : int, optional
        Number of one stored step; None takes all of them.

    Returns
    -------
    ndarray, shape (s, n), or (n,) for one step
        Energy per area at rest [force / length], zero at nodes that are not on the sheet. The sum over the nodes, each
        with the third of the area of its facets, is the energy stored at the nodes of the sheet.
    """
    energy = nodal_energy(results, step)
    if results.mesh is None:
        return energy
    area = np.zeros(len(results.rest))
    area[: len(results.mesh.nodes)] = results.mesh.nodal_areas
    return np.divide(energy, area, out=np.zeros_like(energy), where=area > 0)
