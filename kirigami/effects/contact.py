"""Contact of nodes with a rigid plane, cylinder or sphere: one-sided, smooth; friction is in a file of its own.

A surface has a signed distance with closed derivatives. With y = x - p for the plane (point p, unit normal n) and the
part of x - p across the axis (cylinder) or all of it (sphere), and r = |y|,

    plane     g = n.y       grad g = n        grad grad g = 0
    round     g = r - R     grad g = y / r    grad grad g = (P - grad g grad g') / r,    P: projector across the axis

less an offset, such as half the thickness of a sheet, of which the nodes are the middle surface. A node starts to feel
the surface at the distance s and is pushed off with the force, per depth d = s - g,

    N = 0 for d <= 0,   k d^2 / (2 w) for d <= w,   k (d - w / 2) beyond,

so that force and stiffness are continuous and the energy is twice differentiable. The distance s is the width w of the
layer above the surface, or the distance the node has at rest if that is less: the rest state bears no force. A node
that carries N is then at most

    penetration <= max(0, N / k + w / 2 - s)

inside the surface: not at all up to N = k w / 2 if it starts clear of the layer. Nodes touch, facets do not: between
the nodes the chords of a mesh with edges L cut into a convex surface by up to L^2 / (8 R).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.effects.surfaces import Cylinder, Moving, Plane, Sphere
from kirigami.errors import ModelError
from kirigami.moved import forward
from kirigami.primitives.checks import require_finite, require_instance, require_not_negative, require_positive
from kirigami.primitives.kernel import EXACT, Array, Contribution, Kernel, Tangent
from kirigami.primitives.node import Node, listed
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.words import counted

STIFFER = 100.0  # default stiffness over the largest that an element gives the node at rest
LAYER = 1e-3  # default layer over the median distance of the nodes from their neighbours
TOUCHING = 1e-9  # of the size of the model: distance at rest that counts as zero


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Contact(ModelObject):
    """Keeps nodes off a rigid surface.

    What is not in touch has no stiffness: LinearStatic and Eigen on the rest state do not see the surface, and a body
    needs supports that hold it without.

    Parameters
    ----------
    nodes : Node or sequence of Node
        The nodes that may touch.
    surface : Plane, Cylinder, Sphere or Moving
        The rigid surface, or one that moves.
    offset : float
        Distance the nodes keep from the surface, such as half the thickness of a sheet [length].
    stiffness : float, optional
        Force per depth at each node [force / length]; None takes a hundred times the stiffness of the
        elements at the node.
    layer : float, optional
        Thickness of the layer above the surface (and the offset) in which the force sets in [length]; None takes a
        thousandth of the median distance of the nodes from their neighbours.
    friction : float
        Coefficient of friction (Coulomb): a node is held back by at most this times the force that presses it, and
        slips by up to the layer before it slides. The force that presses is that of the last equilibrium. Results
        tell by ``force("friction")`` and, as shares of the limit, ``deformation("friction")``: at length 1 it slides.

    Raises
    ------
    ModelError
        Empty selection, no such surface, a value out of range; when a system is made: a node inside the surface at
        rest, a surface that does not fit a model with dim=2, a node without an element if stiffness or layer is
        left out.

    Examples
    --------
    A rod is pushed against a wall that is 0.1 away, and then by 0.01 more:

    >>> import kirigami as kg
    >>> from kirigami.results.contact import normal_forces, penetration
    >>> m = kg.Model(dim=2)
    >>> a, b = m.add(kg.Node(0, 0), kg.Node(1, 0))
    >>> objects = m.add(kg.Bar(a, b, EA=10.0), kg.Fix([a, b], "y"), kg.Prescribe(a, x=0.11))
    >>> wall = m.add(kg.Contact(b, kg.Plane((1.1, 0), normal=(-1, 0))))
    >>> res = kg.DisplacementControl(m).run()
    >>> [round(float(force), 2) for force in normal_forces(res)[[0, -1], 0]], float(penetration(res).max())
    ([0.0, 0.1], 0.0)
    """

    kind: ClassVar[str] = "effect"
    group: tuple[Node, ...]
    surface: Plane | Cylinder | Sphere | Moving
    offset: float
    stiffness: float | None
    layer: float | None
    friction: float

    def __init__(
        self,
        nodes: Node | Iterable[Node],
        surface: Plane | Cylinder | Sphere | Moving,
        *,
        offset: float = 0.0,
        stiffness: float | None = None,
        layer: float | None = None,
        friction: float = 0.0,
    ) -> None:
        put = object.__setattr__
        put(self, "group", listed(nodes, "Contact", once=True))
        put(self, "surface", require_instance(surface, (Plane, Cylinder, Sphere, Moving), "surface", "Contact"))
        put(self, "offset", require_not_negative(offset, "offset", "Contact"))
        put(self, "stiffness", None if stiffness is None else require_positive(stiffness, "stiffness", "Contact"))
        put(self, "friction", require_not_negative(friction, "friction", "Contact"))
        put(self, "layer", None if layer is None else require_positive(layer, "layer", "Contact"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return self.group

    @classmethod
    def lower(cls, objects: Sequence[Contact], numbering: Numbering) -> list[Kernel]:
        counts = [len(item.group) for item in objects]
        members = np.repeat(np.arange(len(objects)), counts)
        conn = numbering.index(node for item in objects for node in item.group)[:, None]
        point, normal, projector, radius = (
            np.array(values)[members] for values in zip(*(item.surface._shape_in(numbering.dim) for item in objects))
        )
        offset = np.array([item.offset for item in objects])[members]
        stiffness, layer = _scales(objects, conn[:, 0], members, numbering)
        kernel = ContactKernel(
            numbering.rest, conn, point, normal, projector, radius + offset, stiffness, layer, members
        )
        gap = kernel.deformation(numbering.rest)
        inside = np.flatnonzero(gap < -TOUCHING * numbering.size)
        if inside.size:
            worst = int(inside[np.argmin(gap[inside])])
            raise ModelError(
                f"{counted(inside.size, 'node')} of Contact inside the surface at rest, the deepest "
                f"{numbering.describe(int(conn[worst, 0]))} by {-gap[worst]:.6g} below "
                f"{objects[int(members[worst])].surface} and its offset: move the surface away"
            )
        moves = np.array([item.surface.moves for item in objects])[members]
        rubbing = np.array([item.friction for item in objects])[members]
        found: list[Kernel] = [kernel]
        if moves.any():
            found = [] if moves.all() else [ContactKernel(numbering.rest, **_of(kernel, ~moves))]
        for number in np.unique(members[~moves & (rubbing > 0)]).tolist():  # each keeps anchors of its own
            from kirigami.effects.friction import FrictionKernel  # what does not rub needs none

            own = members == number
            found.append(FrictionKernel(numbering.rest, rubbing[own], layer[own], **_of(kernel, own)))
        for number in np.unique(members[moves]).tolist():
            from kirigami.effects.moving import moving_kernels  # nor does what stands need this

            item, own = objects[number], members == number
            assert isinstance(item.surface, Moving)
            found += moving_kernels(item.surface, numbering.rest, rubbing[own], _of(kernel, own))
        return found

    def held(self, lam: float) -> Contact:
        """The same, with a surface that stands where it is at load factor `lam`."""
        lam = require_finite(lam, "lam", "Contact.held")
        if not isinstance(self.surface, Moving) or self.surface.reached is not None:
            return self
        return Contact(
            self.group, self.surface.held(lam), offset=self.offset, stiffness=self.stiffness, layer=self.layer,
            friction=self.friction,
        )  # fmt: skip

    def __repr__(self) -> str:
        return f"Contact({counted(len(self.group), 'node')}, {self.surface})"


def _of(kernel: ContactKernel, which: NDArray[np.bool_]) -> dict[str, Any]:
    """Constructor arguments of some of the members of a kernel."""
    return {name: value[which] for name, value in kernel.arrays().items()}


def _scales(
    objects: Sequence[Contact], nodes: NDArray[np.int64], members: NDArray[np.int64], numbering: Numbering
) -> tuple[Array, Array]:
    """Stiffness and layer of each member (n,), those that are left out from the elements at the nodes."""
    stiffness = np.array([np.nan if item.stiffness is None else item.stiffness for item in objects])[members]
    layer = np.array([np.nan if item.layer is None else item.layer for item in objects])[members]
    if not (np.isnan(stiffness).any() or np.isnan(layer).any()):
        return stiffness, layer
    at_nodes = numbering.rest_stiffness()[nodes]
    stiffness = np.where(np.isnan(stiffness), STIFFER * at_nodes, stiffness)
    bare = np.flatnonzero(stiffness == 0)
    if bare.size:
        first = numbering.describe(int(nodes[bare[0]]))
        raise ModelError(f"Contact: no element gives {first} a stiffness to take the default from: give stiffness=")
    spacing = numbering.rest_spacing()[nodes]
    for number in np.unique(members[np.isnan(layer)]):
        own = members == number
        if not np.isfinite(spacing[own]).any():
            raise ModelError(f"{objects[int(number)]!r}: no element joins the nodes to others: give layer=")
        layer[own] = LAYER * float(np.nanmedian(spacing[own]))
    return stiffness, layer


class ContactKernel(Kernel):
    """All contacts of nodes with rigid surfaces; see the module's text for the law. One node per member.

    A member with a normal other than zero faces a plane; its ``radius`` then holds the offset alone.
    """

    name = "contact"
    approximates = True

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        point: Array,
        normal: Array,
        projector: Array,
        radius: Array,
        stiffness: Array,
        layer: Array,
        members: NDArray[np.int64] | None = None,
    ) -> None:
        self.rest, self.conn, self.members = rest, conn, members
        self.point, self.normal, self.projector, self.radius = point, normal, projector, radius
        self.stiffness, self.layer = stiffness, layer
        self._flat: NDArray[np.bool_] = np.asarray(np.any(normal != 0, axis=1))
        at_rest = self.distance(self.places_of(rest))[0]
        self.start = np.clip(at_rest, 0.0, layer)  # distance at which the force sets in

    def arrays(self) -> dict[str, Any]:
        names = ("conn", "point", "normal", "projector", "radius", "stiffness", "layer", "members")
        return {name: getattr(self, name) for name in names}

    def places_of(self, x: Array) -> Array:
        """Positions (n, dim) of the members' nodes among all rows."""
        return np.asarray(x)[self.conn[:, 0]]

    def distance(self, places: Array) -> tuple[Array, Array, Array]:
        """Distance (n,) of nodes at `places` (n, dim), its gradient (n, dim), and 1 / r (n,), which is zero for
        planes."""
        y = places - self.point
        height = np.einsum("na,na->n", self.normal, y)
        across = np.einsum("nab,nb->na", self.projector, y)
        r: Array = np.sqrt(np.einsum("na,na->n", across, across))
        inverse: Array = np.divide(1.0, r, out=np.zeros_like(r), where=r > 0)
        direction = np.where(self._flat[:, None], self.normal, across * inverse[:, None])
        return np.where(self._flat, height, r) - self.radius, direction, inverse

    def _law(self, gap: Array) -> tuple[Array, Array, Array]:
        """Energy, normal force and stiffness (n,) at distances (n,)."""
        depth = np.maximum(self.start - gap, 0.0)
        k, w = self.stiffness, self.layer
        onset = np.minimum(depth, w)  # the part of the depth over which the force sets in
        past = depth - onset
        return k * (onset**3 / (6 * w) + past * (past + w) / 2), k * (onset**2 / (2 * w) + past), k * onset / w

    def deformation(self, x: Array) -> Array:
        """Distance of each node from its surface (n,) [length], negative inside."""
        return self.distance(self.places_of(x))[0]

    def normals(self, x: Array, lam: float) -> tuple[Array, Array]:
        """Distance of each node (n,), and the normal (n, dim) of its surface there, as both are at a load factor."""
        return self.distance(self.places_of(x))[:2]

    def deformation_rate(self, x: Array, change: Array) -> Array:
        """First-order change of the distance (n,) for a displacement change (n_nodes, dim)."""
        rate: Array = np.einsum("na,na->n", self.distance(self.places_of(x))[1], self.places_of(change))
        return rate

    def force(self, gap: Array) -> Array:
        """Force that pushes each node off its surface (n,)."""
        return self._law(gap)[1]

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        return self.pushed(self.places_of(x), need, tangent)

    def pushed(self, places: Array, need: int, tangent: Tangent) -> Contribution:
        """What the surface does to nodes at `places` (n, dim)."""
        gap, direction, inverse = self.distance(places)
        energy, force, stiffness = self._law(gap)
        if need == 0:
            return Contribution(energy)
        gradient = -force[:, None] * direction
        if need == 1:
            return Contribution(energy, gradient[:, None])
        outer = direction[:, :, None] * direction[:, None, :]
        # The force turns with the node round a curved surface, which makes a pressed node unstable sideways.
        turning = (1 - tangent.convexity) * force * inverse
        hessian = stiffness[:, None, None] * outer - turning[:, None, None] * (self.projector - outer)
        return Contribution(energy, gradient[:, None], hessian[:, None, None])


__getattr__ = forward("effects.contact", ("results.contact",))  # gaps, normal_forces and penetration stood here in 0.1
