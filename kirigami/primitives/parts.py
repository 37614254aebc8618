"""What models are made of: nodes, materials, and the contract of everything that is added to a model."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.primitives.following import FollowingRows
from kirigami.primitives.kernel import Array, Configuration, Kernel, full_hessian
from kirigami.primitives.node import Node
from kirigami.primitives.rows import EdgeRows

KINDS = ("element", "constraint", "load", "effect")


class ModelObject:
    """Base of everything a model holds beside its nodes. ``kind`` says on which list it goes.

    Attributes
    ----------
    mirror : str
        The axis across the plane of symmetry that it makes of its nodes; "" of everything else.
    clamp : bool
        Whether the sheet keeps its direction at its nodes.
    rotation : ndarray, shape (3,), or None
        Rotation vector at load factor 1 of what turns its nodes [rad].
    border : CellBorder or None
        The border of the periodic cell that it makes of the sheet.
    shaped : bool
        Whether it says itself how it is curved, so that its nodes alone do not.
    directed : bool
        Whether its stiffness has axes of its own, which turn with it.

    Examples
    --------
    A weight on a node, lowered to a kernel with all others of its kind:

    >>> import numpy as np, kirigami as kg
    >>> class WeightsKernel(kg.Kernel):
    ...     name, pairs = "weights", ()
    ...     def __init__(self, conn):
    ...         self.conn = conn
    ...     def evaluate(self, x, lam=1.0, need=2):
    ...         down = np.zeros((len(self.conn), 1, x.shape[1]))
    ...         down[..., -1] = 1.0
    ...         return kg.Contribution(x[self.conn[:, 0], -1], down)
    >>> class Weight(kg.ModelObject):
    ...     kind = "load"
    ...     def __init__(self, node):
    ...         self.node = node
    ...     @property
    ...     def nodes(self):
    ...         return (self.node,)
    ...     @classmethod
    ...     def lower(cls, objects, numbering):
    ...         return [WeightsKernel(numbering.connectivity(objects))]
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(0, -2))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix(a), kg.Fix(b, "x"), Weight(b))
    >>> round(float(kg.LinearStatic(m).run().u[-1, 1, 1]), 9)
    -0.2
    """

    __slots__ = ()
    kind: ClassVar[str] = "element"  # "element", "constraint", "load" or "effect"
    mirror: str = ""
    clamp: bool = False
    rotation: Any = None
    border: Any = None
    shaped: bool = False
    directed: bool = False

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Every node the object touches."""
        raise NotImplementedError

    def held(self, lam: float) -> ModelObject:
        """The object as it goes on in a next stage: what acts with the load factor stays as it is at `lam`."""
        return self

    @classmethod
    def reserve(cls, objects: Sequence[Any], numbering: Numbering) -> None:
        """Ask for rows of unknowns behind the nodes, before anything is lowered; most need none."""

    @classmethod
    def lower(cls, objects: Sequence[Any], numbering: Numbering) -> list[Kernel]:
        """Turn all objects of this class, at once, into kernels."""
        raise NotImplementedError


class Numbering:
    """What lowering needs to know of a model.

    Unknowns stand in rows of `dim` numbers, the nodes first. An element may ask for rows behind them
    (:meth:`add_rows`), which only the system, the kernels and stored steps see: no selection, load or export does.

    Parameters
    ----------
    nodes : sequence of Node
        The nodes, in order.
    rest : ndarray, shape (n, dim)
        Their rest positions.
    mesh, sheet : optional
        The mesh and the constants of a sheet, where the model was made from one.

    Attributes
    ----------
    dim : int
        Unknowns per node.
    size : float
        Size of the structure, by which "zero length" is judged.
    points : int
        Number of nodes; rows from there on stand behind them.
    rest : ndarray, shape (rows, dim)
        What each row holds in the rest state: the position of a node.
    reach : ndarray, shape (rows,)
        Change [length] of a row behind the nodes that turns an element by one radian.
    idle : ndarray of bool, shape (rows, dim)
        Numbers that no element reads, so that they are no unknowns.
    edges : EdgeRows or None
        The rows of the edges of shell facets.
    grips : dict
        The rows that follow others, by the id of the constraint that says so: a rigid grip, or a periodic cell.
    objects : dict
        What is lowered, by class.

    Examples
    --------
    >>> import numpy as np, kirigami as kg
    >>> nodes = [kg.Node(0, 0), kg.Node(1, 0)]
    >>> kg.Numbering(nodes, np.array([[0.0, 0.0], [1.0, 0.0]])).index(nodes[1:]).tolist()
    [1]
    """

    def __init__(
        self,
        nodes: Sequence[Node],
        rest: Array,
        mesh: Any = None,
        sheet: Any = None,
    ) -> None:
        self.nodes = tuple(nodes)
        self.rest = rest
        self.dim = rest.shape[1]
        self.mesh = mesh
        self.sheet = sheet
        self.size = float(np.linalg.norm(np.ptp(rest, axis=0))) or 1.0
        self.kernels: list[Kernel] = []  # what has been lowered so far: elements come before what acts on them
        self.points = len(rest)
        self.reach = np.full(self.points, np.inf)
        self.idle = np.zeros(rest.shape, dtype=bool)
        self.edges: EdgeRows | None = None
        self.grips: dict[int, FollowingRows] = {}
        self.objects: dict[type[ModelObject], list[Any]] = {}
        self._index = {id(node): position for position, node in enumerate(self.nodes)}

    @property
    def model(self) -> Numbering:
        """Old way to ``mesh`` and ``nodes``, which stand on the numbering itself."""
        warnings.warn("numbering.model is now numbering itself: numbering.mesh", DeprecationWarning, stacklevel=2)
        return self

    def add_rows(self, rest: Array, reach: Array, idle: NDArray[np.bool_] | None = None) -> NDArray[np.int64]:
        """Numbers (k,) of new rows behind the nodes.

        Parameters
        ----------
        rest : ndarray, shape (k, dim)
            What they hold in the rest state.
        reach : ndarray, shape (k,)
            Change [length] of each that turns an element by one radian.
        idle : ndarray of bool, shape (k, dim) or (1, dim), optional
            Numbers that no element reads.
        """
        first = len(self.rest)
        self.rest = np.concatenate([self.rest, rest])
        self.reach = np.concatenate([self.reach, reach])
        unread = np.zeros(rest.shape, dtype=bool) if idle is None else np.broadcast_to(idle, rest.shape)
        self.idle = np.concatenate([self.idle, unread])
        return np.arange(first, len(self.rest))

    def index(self, nodes: Iterable[Node]) -> NDArray[np.int64]:
        """Indices of nodes."""
        return np.array([self._index[id(node)] for node in nodes], dtype=np.int64)

    def connectivity(self, objects: Sequence[ModelObject]) -> NDArray[np.int64]:
        """Node indices (n, k) of objects that all have k nodes."""
        return self.index(node for item in objects for node in item.nodes).reshape(len(objects), -1)

    def describe(self, node: Node | int) -> str:
        """A node in words, given itself or its index."""
        position = self._index[id(node)] if isinstance(node, Node) else int(node)
        return f"node {position} {self.nodes[position]!r}"

    def rest_stiffness(self) -> Array:
        """Largest stiffness (n,) [force / length] that any element gives each node in the rest state."""
        stiffest = np.zeros(len(self.rest))
        for kernel in self.kernels:
            if not kernel.stores_energy:
                continue
            blocks = full_hessian(kernel, kernel.evaluate(Configuration(self.rest, np.zeros_like(self.rest)), 0.0, 2))
            for local, nodes in enumerate(kernel.conn.T):
                np.maximum.at(stiffest, nodes, np.linalg.norm(blocks[:, local, local], ord=2, axis=(1, 2)))
        return stiffest

    def rest_spacing(self) -> Array:
        """Median distance (n,) [length] of each node from those that elements join it to; nan where there are none."""
        ends = [kernel.conn[:, :2] for kernel in self.kernels if kernel.stores_energy and kernel.conn.shape[1] > 1]
        pairs = np.unique(np.sort(np.concatenate(ends or [np.empty((0, 2), np.int64)]), axis=1), axis=0)
        distance = np.linalg.norm(self.rest[pairs[:, 1]] - self.rest[pairs[:, 0]], axis=1)
        at, values = pairs.T.ravel(), np.tile(distance, 2)
        order = np.lexsort((values, at))
        nodes, starts, counts = np.unique(at[order], return_index=True, return_counts=True)
        spacing = np.full(len(self.rest), np.nan)
        spacing[nodes] = values[order][starts + counts // 2]
        return spacing
