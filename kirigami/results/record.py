"""What results keep of the model they belong to, so that they do not change when the model does."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from kirigami.errors import AnalysisError, GeometryError, ModelError
from kirigami.model.model import Model
from kirigami.primitives.checks import require_items, require_whole_array, shown
from kirigami.primitives.node import Node
from kirigami.results.supports import Support, supports_of

if TYPE_CHECKING:
    from kirigami.elements.stiffness import SheetConstants
    from kirigami.geometry.mesh import TriMesh
    from kirigami.primitives.kernel import Array
    from kirigami.primitives.material import SheetMaterial

Nodes = Node | int | str | Iterable[Node | int]
Self = TypeVar("Self", bound="ModelRecord")


class ModelRecord:
    """The model of a run as it was when the run began: its nodes, objects, supports, and the sheet it was made from."""

    def __init__(self, model: Model) -> None:
        self._model: Model | None = model
        self.name = model.name
        self.dim: int = model.dim
        self.rest: Array = model.positions()
        self.nodes: tuple[Node, ...] = model.nodes
        self.node_names = {node.name: k for k, node in reversed(list(enumerate(self.nodes))) if node.name}
        self.objects: tuple[Any, ...] = model.objects
        self.supports: tuple[Support, ...] = supports_of(model)
        self.mesh: TriMesh | None = model.mesh
        self.sheet_constants: SheetConstants | None = model.sheet_constants

    def __getstate__(self) -> dict[str, Any]:
        """Nodes are known by identity, which a copy in another process does not share."""
        return {name: value for name, value in vars(self).items() if name != "_index"}

    @property
    def model(self) -> Model:
        """The model as it is now, to go on with; results themselves do not change with it.

        Raises
        ------
        AnalysisError
            The results have none: they were loaded from a file or come from another process.
        """
        if self._model is None:
            raise AnalysisError(
                "these results have no model: they were loaded from a file or come from another process. They know "
                "mesh, thickness, material and supports; give nodes by index, or by the name of a support "
                f"({', '.join(support.name for support in self.supports) or 'none stored'}) or a boundary of the mesh",
                results=self,
            )
        return self._model

    def forget_model(self: Self) -> Self:
        """Let go of the model and its objects, as results that were read from a file; returns the results."""
        self._model, self.nodes, self.objects = None, (), ()
        self.__dict__.pop("_index", None)
        return self

    @property
    def thickness(self) -> float | Array | None:
        """Thickness of the sheet [length], or of each facet (m,) where it varies; None where it is not known."""
        if self.sheet_constants is not None:
            return self.sheet_constants.thickness
        return None if self.mesh is None else self.mesh.thickness

    @property
    def material(self) -> SheetMaterial | tuple[SheetMaterial, ...] | None:
        """Material of the sheet, or of each facet where it varies; None where it is not known."""
        if self.sheet_constants is not None:
            return self.sheet_constants.material
        return None if self.mesh is None else self.mesh.material

    @cached_property
    def _index(self) -> dict[int, int]:
        return {id(node): position for position, node in enumerate(self.nodes)}

    def node_index(self, nodes: Nodes) -> NDArray[np.int64]:
        """Indices (k,) of nodes.

        Parameters
        ----------
        nodes : Node, int, str, or sequence of Node or int
            Nodes of the model of the run; their indices; or a name: of a node, of a support ("driven_0", see
            :attr:`supports`), or of a boundary of the mesh ("top").

        Raises
        ------
        ModelError
            No nodes, no such name, nodes that were not in the model of the run, or indices out of range.
        """
        if isinstance(nodes, str):
            return self._named(nodes)
        single = isinstance(nodes, (Node, int, np.integer)) and not isinstance(nodes, bool)
        listed: list[Any] = [nodes] if single else require_items(nodes, "nodes", "Results")
        if not listed:
            raise ModelError("the node selection is empty")
        if any(isinstance(node, Node) for node in listed):
            if not self.nodes:
                raise ModelError(
                    "these results have no nodes: they were loaded from a file or come from another process: give node "
                    "indices, or the name of a support or of a boundary of the mesh"
                )
            for node in listed:
                if id(node) not in self._index:
                    raise ModelError(
                        f"{shown(node)} was not in the model when this run began, so its results know it not"
                    )
            return np.array([self._index[id(node)] for node in listed], dtype=np.int64)
        index = require_whole_array(listed, (None,), name="node indices", owner="Results")
        count = len(self.rest)
        if index.min() < -count or index.max() >= count:
            raise ModelError(f"node indices must be integers below {count}, got {shown(nodes)}")
        return index

    def _named(self, name: str) -> NDArray[np.int64]:
        if name in self.node_names:
            return np.array([self.node_names[name]])
        for support in self.supports:
            if support.name == name:
                return support.nodes
        if self.mesh is not None:
            with suppress(GeometryError):
                return self.mesh.boundary(name)
        known = [*self.node_names, *(support.name for support in self.supports)]
        boundary = "" if self.mesh is None else ", or a boundary of the mesh such as 'top' or 'outer'"
        raise ModelError(f"no nodes are called {name!r}: use one of {', '.join(known) or '(none)'}{boundary}")

    def object_number(self, item: Any, count: int) -> int:
        """Number of an object among the `count` of its type in the model of the run; a number is taken as it is."""
        if isinstance(item, (int, np.integer)) and not isinstance(item, bool):
            if not 0 <= item < count:
                raise ModelError(f"there is no object {shown(item)}: they are counted from 0 to {count - 1}")
            return int(item)
        alike = [other for other in self.objects if type(other) is type(item)]
        for number, other in enumerate(alike):
            if other is item:
                return number
        if self._model is None:
            raise ModelError("these results have no objects: they were loaded from a file; give the object's number")
        raise ModelError(f"{item!r} was not in the model when this run began")
