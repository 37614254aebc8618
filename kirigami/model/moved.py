"""A model whose rest state is elsewhere, for what asks how things change with it; nodes and objects are shared."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from kirigami.primitives.kernel import Array

if TYPE_CHECKING:
    from kirigami.geometry.mesh import TriMesh
    from kirigami.model.model import Model


def moved(model: Model, places: Array, mesh: TriMesh | None = None) -> Model:
    """A copy of a model with its nodes at rest at `places` (n, 3), and if need be with the mesh that goes with it."""
    twin = copy.copy(model)
    twin._rest = [(x, y, z) for x, y, z in places.tolist()]
    twin._mesh = model.mesh if mesh is None else mesh
    twin._edited()
    return twin


@contextmanager
def nodes_of(model: Model) -> Iterator[None]:
    """While it lasts, nodes that models share say where they are in this one, as functions of users ask them."""
    nodes, before = model.nodes, [node._position for node in model.nodes]
    try:
        for node, place in zip(nodes, model._rest):
            node._position = place
        yield
    finally:
        for node, place in zip(nodes, before):
            node._position = place
