"""Constraints: displacements that are known (Fix, Prescribe) or shared (Tie). They are eliminated, never penalised."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from kirigami.errors import ModelError
from kirigami.primitives.checks import require_array, require_axes, require_boolean, require_finite, shown
from kirigami.primitives.kernel import Array, Kernel
from kirigami.primitives.node import AXES, Node, listed
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.words import counted


def values_for(value: ArrayLike, count: int, owner: str) -> Array:
    """A scalar or one value per node as an array (count,)."""
    array = require_array(value, (), (count,), name="displacement", owner=owner)
    values: Array = np.broadcast_to(array, (count,)).copy()
    return values


def read_only(values: Array) -> Array:
    """A view of an array through which it cannot be changed."""
    view: Array = values.view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Constraint(ModelObject):
    """Base of all constraints: a group of nodes and what is known of their displacement.

    ``leaders`` names the node each of the group follows, if any.
    """

    kind: ClassVar[str] = "constraint"
    group: tuple[Node, ...]
    _values: dict[str, Array]
    constant: bool = False
    clamp: bool = False
    leaders: tuple[Node, ...] = ()
    mirror: str = ""  # the axis across a plane of symmetry

    def __getstate__(self) -> dict[str, Any]:
        """All there is to a constraint of any class, so that copies are whole: a dataclass knows but its own fields."""
        names = [name for cls in type(self).__mro__ for name in getattr(cls, "__slots__", ())]
        return {name: getattr(self, name) for name in names if hasattr(self, name)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, value)

    @property
    def values(self) -> Mapping[str, Array]:
        """Displacement, or difference from the leaders, of each node (number of nodes,) by axis; not to be edited."""
        return MappingProxyType({axis: read_only(values) for axis, values in self._values.items()})

    @property
    def drives(self) -> bool:
        """Whether it moves nodes with the load factor."""
        return False

    @property
    def links(self) -> bool:
        """Whether it holds nodes to others rather than to the ground."""
        return bool(self.leaders)

    @property
    def nodes(self) -> tuple[Node, ...]:
        return self.group + self.leaders

    @classmethod
    def lower(cls, objects: Sequence[Any], numbering: Numbering) -> list[Kernel]:
        """Only edges that keep their direction make force: of all constraints together, with the first of them."""
        everything = [item for group in numbering.objects.values() for item in group if isinstance(item, Constraint)]
        holding = [item for item in everything if item.clamp or item.mirror]
        if not holding or not any(item is holding[0] for item in objects):
            return []
        from kirigami.elements.held_edges import held_edge_kernels

        return held_edge_kernels(holding, numbering)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({counted(len(self.group), 'node')}, {''.join(self._values)})"


class Fix(Constraint):
    """Holds displacements at zero.

    Parameters
    ----------
    nodes : Node or sequence of Node
        The nodes to hold.
    dofs : str
        Axes to hold, letters out of "xyz".
    clamp : bool
        The sheet keeps its direction there as well (models made from a mesh): at boundary edges with both nodes in
        the set, and in facets that are wholly in it. Where the edge itself turns, its direction goes along.

    Raises
    ------
    ModelError
        Empty selection or unknown axis; in a run a clamp of nodes that hold no boundary edge and no whole facet.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Fix([kg.Node(0, 0), kg.Node(1, 0)], "xz")
    Fix(2 nodes, xz)
    """

    __slots__ = ()

    def __init__(self, nodes: Node | Iterable[Node], dofs: str = "xyz", clamp: bool = False) -> None:
        group = listed(nodes, "Fix")
        values = {axis: np.zeros(len(group)) for axis in require_axes(dofs, "Fix")}
        super().__init__(group, values, constant=True, clamp=require_boolean(clamp, "clamp", "Fix"))


class Prescribe(Constraint):
    """Drives displacements from the rest state with the load factor.

    Parameters
    ----------
    nodes : Node or sequence of Node
        The nodes to drive.
    x, y, z : float or array_like, shape (number of nodes,), optional
        Displacement at load factor 1 [length]; None leaves the axis free.
    clamp : bool
        As for :class:`Fix`.
    constant : bool
        Holds the values at full size whatever the load factor, as after an earlier stage.

    Raises
    ------
    ModelError
        Empty selection, no axis, or values that are not finite.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Prescribe(kg.Node(0, 1), y=0.4)
    Prescribe(1 node, y)
    """

    __slots__ = ()

    def __init__(
        self,
        nodes: Node | Iterable[Node],
        x: ArrayLike | None = None,
        y: ArrayLike | None = None,
        z: ArrayLike | None = None,
        clamp: bool = False,
        constant: bool = False,
    ) -> None:
        group = listed(nodes, "Prescribe")
        given = {axis: value for axis, value in zip(AXES, (x, y, z)) if value is not None}
        if not given:
            raise ModelError("Prescribe: give a displacement for at least one of x, y, z")
        values = {axis: values_for(value, len(group), f"Prescribe {axis}") for axis, value in given.items()}
        super().__init__(
            group,
            values,
            constant=require_boolean(constant, "constant", "Prescribe"),
            clamp=require_boolean(clamp, "clamp", "Prescribe"),
        )

    @property
    def drives(self) -> bool:
        return not self.constant

    def held(self, lam: float) -> Prescribe:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "Prescribe.held")
        if self.constant:
            return self
        scaled = {axis: lam * value for axis, value in self._values.items()}
        return Prescribe(self.group, **scaled, clamp=self.clamp, constant=True)


class Symmetry(Constraint):
    """Makes a plane through nodes one of symmetry: beyond it the structure goes on as its mirror image.

    The nodes stay in the plane, and the sheet meets its image there, at any rotation: half a model does what the whole
    one does, with half of its energy and of the forces on the plane's own nodes. Bars and loads that lie in the plane
    are shared by both halves: give the half model half of them. The bars of a mesh are halved already.

    Parameters
    ----------
    nodes : Node or sequence of Node
        The nodes in the plane: all those of the sheet's edges that were cut by it.
    normal : {"x", "y", "z"}
        The axis across the plane.

    Raises
    ------
    ModelError
        Empty selection or unknown axis; in a run nodes that do not lie in one plane or hold no boundary edge, a sheet
        that lies in the plane, a model that was not made from a mesh.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Symmetry([kg.Node(0, 0), kg.Node(0, 1)], "x")
    Symmetry(2 nodes, x)
    """

    __slots__ = ()

    def __init__(self, nodes: Node | Iterable[Node], normal: str = "x") -> None:
        group = listed(nodes, "Symmetry")
        if not isinstance(normal, str) or normal not in tuple(AXES):
            raise ModelError(
                f"Symmetry: normal must be 'x', 'y' or 'z', got {shown(normal)}; turn the model so that the plane lies "
                "across an axis"
            )
        super().__init__(group, {normal: np.zeros(len(group))}, constant=True, mirror=normal)


class Tie(Constraint):
    """Makes nodes move like others, up to a given difference.

    For each pair and axis: displacement of the follower = displacement of its leader + difference. One leader for
    many followers is a rigid translating grip; one leader each with differences from a mean strain is a periodic cell.

    Parameters
    ----------
    followers : Node or sequence of Node
        The nodes that follow.
    leaders : Node or sequence of Node
        One leader for all, or one for each follower.
    dofs : str
        Tied axes, letters out of "xyz".
    x, y, z : float or array_like, optional
        Difference at load factor 1 [length]; None is zero.
    constant : bool
        Holds the differences at full size whatever the load factor.

    Raises
    ------
    ModelError
        Numbers of nodes that do not match, a node tied to itself, a difference along an axis that is not tied.

    Examples
    --------
    >>> import kirigami as kg
    >>> kg.Tie([kg.Node(1, 0), kg.Node(1, 1)], kg.Node(2, 0), "x")
    Tie(2 nodes, x)
    """

    __slots__ = ()

    def __init__(
        self,
        followers: Node | Iterable[Node],
        leaders: Node | Iterable[Node],
        dofs: str = "xyz",
        x: ArrayLike | None = None,
        y: ArrayLike | None = None,
        z: ArrayLike | None = None,
        constant: bool = False,
    ) -> None:
        group, ahead = listed(followers, "Tie"), listed(leaders, "Tie")
        if len(ahead) == 1:
            ahead = ahead * len(group)
        if len(ahead) != len(group):
            raise ModelError(
                f"Tie: {counted(len(group), 'follower')} need one leader or as many, got "
                f"{counted(len(ahead), 'leader')}"
            )
        for follower, leader in zip(group, ahead):
            if follower is leader:
                raise ModelError(f"Tie: {follower!r} cannot follow itself")
        given = {axis: value for axis, value in zip(AXES, (x, y, z)) if value is not None}
        for axis in set(given) - set(require_axes(dofs, "Tie")):
            raise ModelError(f"Tie: a difference is given along {axis}, which is not among the tied dofs {dofs!r}")
        values = {axis: values_for(given.get(axis, 0.0), len(group), f"Tie {axis}") for axis in dofs}
        super().__init__(group, values, constant=require_boolean(constant, "constant", "Tie"), leaders=ahead)

    def held(self, lam: float) -> Tie:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "Tie.held")
        if self.constant:
            return self
        scaled = {axis: lam * value for axis, value in self._values.items()}
        return Tie(self.group, self.leaders, "".join(self._values), **scaled, constant=True)
