"""Derivatives by the rest state in one pass: each kernel tells its own, contracted with the adjoint fields."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kirigami.primitives.kernel import Array
from kirigami.results.gradients.equilibrium import Adjoint
from kirigami.system.system import System


def by_rest_state(adjoints: Sequence[Adjoint], sections_are_known: bool = False) -> Array | None:
    """Derivatives (functionals, n, 3) of the functionals of one equilibrium by the places of the nodes at rest.

    Rest lengths, rest angles and bulges of edges follow the nodes as they do when the model is lowered; stiffnesses
    and prescribed displacements stay. None where the structure has anything that does not tell how it follows, such as
    sections with axes, which turn with their facets, unless the caller knows of these.
    """
    at = adjoints[0].at
    system = at.system
    if not _plain(system) or not (sections_are_known or _isotropic(system)):
        return None
    fields = np.array([adjoint.v for adjoint in adjoints])
    shares = np.array([adjoint.told.by_energy for adjoint in adjoints])
    total = np.zeros_like(fields)
    for kernel in system.kernels:
        found = kernel.by_rest(at.configuration, at.lam, fields, shares if kernel.stores_energy else 0.0 * shares)
        if found is None:
            return None
        total += found
    total += np.array([adjoint.told.by_position[:, : system.dim] for adjoint in adjoints])
    nodes = total[:, : system.points]
    if system.edges is not None:
        from kirigami.elements.smooth_normals import edge_bulges_back  # a truss needs no mesh

        edges = system.edges
        unfolded = np.zeros(len(edges.ends), dtype=bool)
        points = np.array(system.rest[: system.points])
        nodes = nodes + edge_bulges_back(points, edges.triangles, edges.edge, unfolded, total[:, edges.middle])
    answer = np.zeros((len(adjoints), system.points, 3))
    answer[..., : system.dim] = nodes
    return answer


def _plain(system: System) -> bool:
    """Whether displacements are the same function of the unknowns wherever the nodes are at rest, and edges bulge as
    the nodes alone say."""
    if system.grips is not None or system.arcs:
        return False
    if system.edges is None:
        return True
    if any(item.shaped for item in system.model.elements):
        return False
    return all(
        not item.mirror and all(np.ptp(values) == 0 for values in item.values.values())
        for item in system.model.constraints
    )


def _isotropic(system: System) -> bool:
    """Whether no section has axes of its own."""
    return not any(item.directed for item in system.model.elements)
