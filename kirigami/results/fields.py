"""Fields for colouring a deformed sheet: height, strain of the facets, stored energy."""

from __future__ import annotations

import numpy as np

from kirigami.errors import AnalysisError
from kirigami.primitives.kernel import Array, Kernel, hessian_product
from kirigami.results.results import Results
from kirigami.results.step import Step


def facet_strain(results: Results) -> Array:
    """Largest principal Green strain of each facet, from its rest state.

    With rest edges e_1, e_2 of a facet, written in its plane as the columns of B, and displacement differences d_1,
    d_2 along them, the strain is B^-T [e_a.d_b + e_b.d_a + d_a.d_b] B^-1 / 2.

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
    triangles = results.mesh.triangles
    corner = results.rest[triangles]
    edges = corner[:, 1:] - corner[:, :1]  # (m, 2, 3)
    along = edges[:, 0] / np.linalg.norm(edges[:, 0], axis=1)[:, None]
    across = edges[:, 1] - (edges[:, 1] * along).sum(axis=1)[:, None] * along
    across /= np.linalg.norm(across, axis=1)[:, None]
    inverse = np.linalg.inv(np.einsum("max,mix->mia", edges, np.stack([along, across], axis=1)))
    values = np.empty((len(results), len(triangles)))
    for row, step in zip(values, results.steps):
        moved = step.u[triangles]
        change = moved[:, 1:] - moved[:, :1]
        cross = np.einsum("max,mbx->mab", edges, change)
        metric = cross + cross.swapaxes(1, 2)
        if not results.linear:
            metric += np.einsum("max,mbx->mab", change, change)
        strain = 0.5 * np.einsum("mai,mab,mbj->mij", inverse, metric, inverse)
        mean, half = 0.5 * (strain[:, 0, 0] + strain[:, 1, 1]), 0.5 * (strain[:, 0, 0] - strain[:, 1, 1])
        row[:] = mean + np.hypot(half, strain[:, 0, 1])
    return values


def nodal_energy(results: Results) -> Array:
    """Stored energy at each node: every element gives equal shares to its nodes.

    Parameters
    ----------
    results : Results
        Of any model.

    Returns
    -------
    ndarray, shape (s, n)
        Energy [force length]; the sum over the nodes is the energy stored in the structure.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(2, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "y"), kg.NodalLoad(b, (1, 0)))
    >>> nodal_energy(kg.LinearStatic(m).run()).round(12).tolist()
    [[0.0, 0.0], [0.05, 0.05]]
    """
    total = np.zeros((len(results), len(results.rest)))
    for kernel in results.kernels:
        if not kernel.stores_energy or not len(kernel.conn):  # loads store nothing
            continue
        nodes = kernel.conn[:, (kernel.conn < len(results.rest)).all(axis=0)]
        for row, step in zip(total, results.steps):
            np.add.at(row, nodes, _element_energy(results, kernel, step)[:, None] / nodes.shape[1])
    return total


def energy_density(results: Results) -> Array:
    """Stored energy per area of the sheet at each node, shape (s, n) [force / length]; per node without a mesh."""
    energy = nodal_energy(results)
    if results.mesh is None:
        return energy
    area = np.zeros(len(results.rest))
    np.add.at(area, results.mesh.triangles, results.mesh.facet_areas[:, None] / 3.0)
    return energy / area


def _element_energy(results: Results, kernel: Kernel, step: Step) -> Array:
    if not results.linear:
        energy: Array = results.evaluate_at(kernel, step, lambda x: kernel.evaluate(x, step.lam, 0)).energy
        return energy
    start = kernel.evaluate(results.configuration(), step.lam, 2)
    assert start.gradient is not None
    u = results.rows(step)[kernel.conn]
    first = np.einsum("nka,nka->n", start.gradient, u)
    second = 0.5 * (u * hessian_product(kernel, start, u)).sum(axis=(1, 2))
    return np.asarray(start.energy + first + second)
