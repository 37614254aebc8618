"""Model: the container of all objects that a user builds. Objects describe; nothing here computes mechanics."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar, overload
from uuid import uuid4
from weakref import ref

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.deferred import deferred
from kirigami.errors import ModelError
from kirigami.model.select import selected
from kirigami.primitives.checks import (
    require_array,
    require_finite,
    require_items,
    require_text,
    require_whole,
    shown,
)
from kirigami.primitives.node import Node
from kirigami.primitives.parts import KINDS, ModelObject
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.elements.stiffness import Calibration, SheetConstants
    from kirigami.geometry.mesh import TriMesh
    from kirigami.model.properties import Materials, Thickness
    from kirigami.primitives.kernel import Array

Item = TypeVar("Item")


class Model:
    """A structure of nodes, elements, constraints and loads.

    Parameters
    ----------
    dim : {2, 3}
        Unknowns per node; 2 drops z altogether.
    name : str
        A label for messages and pictures.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model(dim=2, name="von Mises truss")
    >>> left, apex, right = m.add(kg.Node(-1, 0), kg.Node(0, 1), kg.Node(1, 0))
    >>> bars = m.add(kg.Bar(left, apex, EA=1.0), kg.Bar(apex, right, EA=1.0))
    >>> fixed = m.add(kg.Fix([left, right]))
    >>> print(m)
    Model 'von Mises truss' in 2D: 3 nodes, 2 Bar, 1 Fix
    """

    def __init__(self, dim: int = 3, name: str = "") -> None:
        self._dim = require_whole(dim, "dim", "Model")
        if self._dim not in (2, 3):
            raise ModelError(f"Model: dim must be 2 or 3, got {dim}")
        self.name = require_text(name, "name", "Model")
        self.version = 0  # counts edits, so that a System made before an edit refuses to be used after it
        self.stage = 0  # counts hold(): the load factor starts from zero again in each stage
        self.stage_key = uuid4().hex  # what the steps of this model in this stage are known by
        self._mesh: TriMesh | None = None
        self._sheet_constants: SheetConstants | None = None
        self._sheet: tuple[Any, ...] = ()  # the elements that from_mesh made
        self._nodes: list[Node] = []
        self._rest: list[tuple[float, float, float]] = []  # where the nodes are in the rest state of this model
        self._index: dict[int, int] = {}
        self._objects: dict[str, dict[int, Any]] = {kind: {} for kind in KINDS}  # by identity, in the order added
        self._views: dict[str, tuple[Any, ...]] = {}  # what is handed out, until the next edit

    def __setstate__(self, state: dict[str, Any]) -> None:
        """A copy has lists of its own. One made by ``copy.copy`` shares the nodes, but has its own rest state."""
        self.__dict__.update(state)
        self._nodes, self._rest = list(self._nodes), list(self._rest)
        self._index = {id(node): position for position, node in enumerate(self._nodes)}
        self._objects = {
            kind: {id(item): item for item in stored.values()} for kind, stored in self._objects.items()
        }
        self._views = {}
        self._claim(self._nodes)

    def _claim(self, nodes: Iterable[Node]) -> None:
        """Nodes that no other model holds are this one's."""
        mine = ref(self)
        for node in nodes:
            if node.model is None:
                node._owner = mine

    def _edited(self) -> None:
        self.version += 1
        self._views = {}

    # ---- building

    @classmethod
    def from_mesh(
        cls,
        mesh: TriMesh,
        thickness: Thickness = None,
        material: Materials = None,
        stiffness: str | Calibration = "plate",
        dim: int = 3,
    ) -> Model:
        """A sheet model: every mesh edge a bar, every inner edge a bending hinge, or every facet an element of its own.

        Parameters
        ----------
        mesh : TriMesh
            The mesh; ``mesh.nodes[i]`` becomes ``model.nodes[i]``.
        thickness : float, array_like (m,), mapping or callable, optional
            Thickness of the sheet [length]: one; one for each facet; a mapping from names of regions of the mesh, in
            which None stands for what is in none of them; or ``thickness(x, y, z)`` of the centres of the facets. What
            is left out is what the mesh carries from its sheet, or a laminate has by itself.
        material : Material, Orthotropic, Laminate, NeoHookean, sequence (m,), mapping or callable, optional
            The same for materials. Only "shell" stands for others than a `Material`.
        stiffness : {"plate", "paper", "facet", "shell"} or Calibration
            "plate": bars and hinges with constants from plate theory, the cheapest; "paper": with the published
            constants; "facet": facets whose three edges stretch and fold together; "shell": shell facets, which
            converge to shell theory and cost several times as much on the same mesh, but need a coarser one. "split"
            is an old name of "shell". See :mod:`kirigami.stiffness`.
        dim : {3, 2}
            2 gives bars only, or the membrane of "facet".

        Raises
        ------
        ModelError
            Thickness or material missing or out of range, unknown stiffness, a region that is not there or overlaps.

        Warns
        -----
        KirigamiWarning
            Where the edges of the mesh favour some directions so much that bars and hinges on it are off by a fifth,
            and where one facet is more than a hundred times as thick as its neighbour.

        Examples
        --------
        >>> import kirigami as kg
        >>> mesh = kg.TriMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
        >>> print(kg.Model.from_mesh(mesh, thickness=0.01, material=kg.Material(E=1e9)))
        Model in 3D: 4 nodes, 5 Bar, 1 BendHinge

        A sheet with a stiffer patch:

        >>> sheet = kg.Sheet([(0, 0), (4, 0), (4, 1), (0, 1)], regions={"patch": [(1, 0), (2, 0), (2, 1), (1, 1)]})
        >>> m = kg.Model.from_mesh(sheet.mesh(0.5), {None: 0.01, "patch": 0.02}, kg.Material(E=1e9), "shell")
        """
        from kirigami.model.from_mesh import sheet_parts

        model = cls(dim=dim)
        nodes, elements, constants = sheet_parts(mesh, thickness, material, stiffness, model.dim)
        model.add(*nodes)
        model.add(*elements)
        model._mesh, model._sheet_constants, model._sheet = mesh, constants, tuple(elements)
        return model

    @overload
    def add(self, item: Item, /) -> Item: ...
    @overload
    def add(self, first: Node, second: Node, /, *more: Node) -> tuple[Node, ...]: ...
    @overload
    def add(self, *items: Any) -> tuple[Any, ...]: ...
    def add(self, *items: Any) -> Any:
        """Add nodes, elements, constraints and loads; returns the object, or the tuple of objects.

        Raises
        ------
        ModelError
            An object is no model object, is already in the model, or uses a node that is not in the model.
        """
        fresh = self._checked(items)
        for item in items:
            if isinstance(item, Node):
                self._index[id(item)] = len(self._nodes)
                self._nodes.append(item)
                self._rest.append(item._position)
            else:
                self._objects[item.kind][id(item)] = item
        self._claim(fresh)
        self._edited()
        return items[0] if len(items) == 1 else items

    def _checked(self, items: Sequence[Any]) -> list[Node]:
        """Hold all that is to be added against the rules before anything is; returns the nodes among it."""
        fresh: list[Node] = []
        listed: set[int] = set()

        def known(node: Node) -> bool:
            return id(node) in self._index or id(node) in listed

        for item in items:
            if not isinstance(item, (Node, ModelObject)):
                hint = ": unpack lists with add(*objects)" if isinstance(item, (list, tuple)) else ""
                raise ModelError(f"cannot add a {type(item).__name__} to a model{hint}")
            if id(item) in listed:
                raise ModelError(f"{item!r} is listed twice: add it once")
            if isinstance(item, Node):
                self._check_node(item)
                fresh.append(item)
            else:
                if item.kind not in KINDS:
                    raise ModelError(f"{type(item).__name__}.kind must be one of {', '.join(KINDS)}, got {item.kind!r}")
                if id(item) in self._objects[item.kind]:
                    raise ModelError(f"{item!r} is already in the model: what is to act twice must be made twice")
                for node in item.nodes:
                    if not isinstance(node, Node):
                        raise ModelError(f"{type(item).__name__} was given {node!r} where a Node belongs")
                    if not known(node):
                        raise ModelError(f"{type(item).__name__} uses {node!r}, which is {self._whose(node)}")
            listed.add(id(item))
        return fresh

    def _check_node(self, node: Node) -> None:
        if id(node) in self._index:
            raise ModelError(f"{node!r} is already in the model")
        if node.model is not None:
            raise ModelError(f"{node!r} is in another model, and would be moved by both: make a node for this one")
        if self.dim == 2 and node.z != 0.0:
            raise ModelError(f"{node!r} has z = {node.z}, but the model has dim=2: use z = 0 or dim=3")

    @staticmethod
    def _whose(node: Node) -> str:
        if node.model is None:
            return "not in this model: add the node first"
        return "a node of another model: take this model's, such as model.nodes[k] or model.select(...)"

    def remove(self, *items: ModelObject) -> None:
        """Take elements, constraints or loads out again, all of them or none; nodes stay.

        Raises
        ------
        ModelError
            An object is not in the model, is listed twice, or is a node.
        """
        going: set[int] = set()
        for item in items:
            if isinstance(item, Node):
                raise ModelError(f"{item!r} cannot be removed: nodes stay; leave it out when the model is made")
            if id(item) not in self._objects.get(getattr(item, "kind", ""), {}):
                raise ModelError(f"{shown(item)} is not in the model, so it cannot be removed")
            if id(item) in going:
                raise ModelError(f"{item!r} is listed twice: remove it once")
            going.add(id(item))
        for item in items:
            del self._objects[item.kind][id(item)]
        self._edited()

    def hold(self, step: Any) -> None:
        """Freeze what drives the model at its value in `step` and start the load factor from zero again.

        Prescribed displacements and loads become constant ones at ``step.lam`` times their value, so that a next
        stage (fold, then stretch) can add its own drive and go on with ``start=step``. A constraint that the step
        does not meet is brought to its place in proportion to the load factor, so it holds at load factor 1.

        Parameters
        ----------
        step : Step
            The equilibrium to go on from, of this model and of its present stage.

        Raises
        ------
        ModelError
            No step, or one of another model or of another stage, whose load factor says nothing about this one.
        """
        lam, stage, key = (getattr(step, name, None) for name in ("lam", "stage", "stage_key"))
        if lam is None or stage is None:
            raise ModelError(f"hold: give a step of results, such as results[-1], got {shown(step)}")
        if stage != self.stage:
            raise ModelError(
                f"hold: the step was found in stage {stage} of a model (counted by hold), but this model is in stage "
                f"{self.stage}: its load factor {lam:.6g} is not one of what drives the model now; give a step of this "
                "stage"
            )
        # A step read from a file has no key; then the number of nodes must do.
        if key != self.stage_key if key else len(step.u) != len(self._nodes):
            raise ModelError("hold: the step belongs to another model: give a step of this model's results")
        self._objects = {
            kind: {id(held): held for held in [item.held(lam) for item in stored.values()]}
            for kind, stored in self._objects.items()
        }
        self.stage += 1
        self.stage_key = uuid4().hex
        self._edited()

    def perturb(self, shape: Any, amplitude: float | None = None) -> None:
        """Move the nodes of the rest state by a stress-free imperfection.

        Parameters
        ----------
        shape : Mode or array_like, shape (n, 3), (n, dim) or (n,)
            Offsets [length]; a one-dimensional array offsets z.
        amplitude : float, optional
            Largest length of a node's offset after scaling; None takes the shape as given.

        Raises
        ------
        ModelError
            Wrong number of rows, values that are not finite, z offsets in a 2D model, or an amplitude for a zero shape.

        Examples
        --------
        >>> import kirigami as kg
        >>> m = kg.Model()
        >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
        >>> m.perturb([0.0, 2.0], amplitude=0.1)
        >>> b
        Node(1, 0, 0.1)
        """
        offset = require_array(shape, name="shape", owner="perturb")  # a Mode turns into its shape
        n = len(self._nodes)
        if offset.shape == (n,):
            offset = np.stack([np.zeros(n), np.zeros(n), offset], axis=1)
        elif offset.shape == (n, 2):
            offset = np.column_stack([offset, np.zeros(n)])
        if offset.shape != (n, 3):
            raise ModelError(
                f"perturb: the shape must have one row for each of the {counted(n, 'node')}, got {offset.shape}"
            )
        if self.dim == 2 and np.any(offset[:, 2]):
            raise ModelError("perturb: a dim=2 model cannot take offsets in z")
        if amplitude is not None:
            largest = np.linalg.norm(offset, axis=1).max(initial=0.0)
            if largest == 0:
                raise ModelError("perturb: the shape is zero everywhere, so it cannot be scaled to an amplitude")
            offset *= require_finite(amplitude, "amplitude", "perturb") / largest
        self._claim(self._nodes)
        self._rest = [(x, y, z) for x, y, z in (self.positions() + offset).tolist()]
        for node, position in zip(self._nodes, self._rest):
            if node.model is self:  # a node shared with a copy shows where it is in the model it was made for
                node._position = position
        self._edited()

    # ---- looking

    @property
    def dim(self) -> int:
        """Unknowns per node, 2 or 3."""
        return self._dim

    @property
    def mesh(self) -> TriMesh | None:
        """The mesh of a model made by :meth:`from_mesh`."""
        return self._mesh

    @property
    def sheet_constants(self) -> SheetConstants | None:
        """Thickness, material and accuracy of a model made by :meth:`from_mesh`."""
        return self._sheet_constants

    @property
    def sheet_elements(self) -> tuple[Any, ...]:
        """The elements that :meth:`from_mesh` made, whether or not they are still in the model."""
        return self._sheet

    # Tuples, so that every edit goes through add and remove and is counted.
    @property
    def nodes(self) -> tuple[Node, ...]:
        """The nodes, in the order added."""
        if "node" not in self._views:
            self._views["node"] = tuple(self._nodes)
        return self._views["node"]

    def _all(self, kind: str) -> tuple[Any, ...]:
        if kind not in self._views:
            self._views[kind] = tuple(self._objects[kind].values())
        return self._views[kind]

    @property
    def elements(self) -> tuple[Any, ...]:
        """Bars, hinges, springs and facets, in the order added."""
        return self._all("element")

    @property
    def constraints(self) -> tuple[Any, ...]:
        """What is fixed, prescribed or tied, in the order added."""
        return self._all("constraint")

    @property
    def loads(self) -> tuple[Any, ...]:
        """The loads, in the order added."""
        return self._all("load")

    @property
    def effects(self) -> tuple[Any, ...]:
        """Everything else that makes force, in the order added."""
        return self._all("effect")

    @property
    def objects(self) -> tuple[Any, ...]:
        """Everything but the nodes, in the order added within each kind."""
        return tuple(item for kind in KINDS for item in self._all(kind))

    def positions(self) -> Array:
        """Rest positions of all nodes, shape (n, 3)."""
        return np.array(self._rest, dtype=float).reshape(-1, 3)

    def index(self, nodes: Node | Iterable[Node]) -> NDArray[np.int64]:
        """Indices of one node or many.

        Raises
        ------
        ModelError
            A node is not in the model.
        """
        listed = [nodes] if isinstance(nodes, Node) else require_items(nodes, "nodes", "Model.index")
        for node in listed:
            if not isinstance(node, Node):
                raise ModelError(f"Model.index: nodes must be nodes of the model, got {shown(node)}")
            if id(node) not in self._index:
                raise ModelError(f"{node!r} is {self._whose(node)}")
        return np.array([self._index[id(node)] for node in listed], dtype=np.int64)

    def select(
        self,
        box: Sequence[float] | None = None,
        where: Callable[[Array, Array, Array], ArrayLike] | None = None,
        boundary: str | None = None,
        index: ArrayLike | None = None,
    ) -> list[Node]:
        """Nodes that meet every condition given.

        Parameters
        ----------
        box : sequence of 4 or 6 floats
            (xmin, ymin, xmax, ymax) or (xmin, ymin, zmin, xmax, ymax, zmax), inclusive to 1e-9 of the model's size.
        where : callable
            Predicate of the coordinate arrays x, y, z that returns a boolean array.
        boundary : str
            "bottom", "top", "left", "right", "outer", "free", "cut:3", or a node set of the mesh.
        index : int or sequence of int
            Node indices.

        Raises
        ------
        ModelError
            No condition, a malformed one, an unknown boundary, or nothing selected.

        Examples
        --------
        >>> import kirigami as kg
        >>> m = kg.Model()
        >>> nodes = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(1, 2))
        >>> m.select(box=(1, 0, 1, 9))
        [Node(1, 0, 0), Node(1, 2, 0)]
        """
        return [self._nodes[k] for k in selected(self.positions(), self.mesh, box, where, boundary, index)]

    def __str__(self) -> str:
        counts = Counter(type(item).__name__ for item in self.objects)
        parts = [counted(len(self._nodes), "node")]
        parts += [f"{number} {name}" for name, number in counts.items()]
        return f"Model{f' {self.name!r}' if self.name else ''} in {self.dim}D: {', '.join(parts)}"

    def __repr__(self) -> str:
        return f"<{self}>"

    def _repr_html_(self) -> str:
        counts = Counter(type(item).__name__ for item in self.objects)
        rows = "".join(f"<tr><td>{n}</td><td>{number}</td></tr>" for n, number in counts.items())
        title = f"Model {self.name}".strip()
        return f"<b>{title}</b>, {self.dim}D<table><tr><td>nodes</td><td>{len(self._nodes)}</td></tr>{rows}</table>"

    imperfect = deferred("kirigami.study.imperfect:imperfect")
    plot = deferred("kirigami.plot.undeformed:plot_model")
    to_abaqus = deferred("kirigami.io.abaqus:to_abaqus")
    to_openseespy = deferred("kirigami.io.opensees:to_openseespy")
