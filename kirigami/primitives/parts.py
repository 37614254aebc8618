"""What models are made of: nodes, materials, and the contract of everything that is added to a model."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.node import Node

if TYPE_CHECKING:
    from kirigami.model.model import Model
    from kirigami.primitives.kernel import Array, Kernel


class ModelObject:
    """Base of everything a model holds beside its nodes. ``kind`` says on which list it goes."""

    __slots__ = ()
    kind: ClassVar[str] = "element"  # "element", "constraint", "load" or "effect"

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Every node the object touches."""
        raise NotImplementedError

    @classmethod
    def lower(cls, objects: Sequence[Any], numbering: Numbering) -> list[Kernel]:
        """Turn all objects of this class, at once, into kernels."""
        raise NotImplementedError


class Numbering:
    """What lowering needs to know of a model: node indices, rest positions (n, dim), size."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.dim = model.dim
        self.rest: Array = model.positions()[:, : model.dim].copy()
        self.size = float(np.linalg.norm(np.ptp(self.rest, axis=0))) or 1.0

    def index(self, nodes: Iterable[Node]) -> NDArray[np.int64]:
        index = self.model._index
        return np.array([index[id(node)] for node in nodes], dtype=np.int64)

    def connectivity(self, objects: Sequence[ModelObject]) -> NDArray[np.int64]:
        """Node indices (n, k) of objects that all have k nodes."""
        return self.index(node for item in objects for node in item.nodes).reshape(len(objects), -1)

    def describe(self, node: Node) -> str:
        return f"node {self.model._index[id(node)]} {node!r}"
