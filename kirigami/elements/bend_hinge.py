"""The bending hinge: a rotational spring on the edge between two facets.

Edge j-k, wings i and l. With e = x_k - x_j, wing vectors a = x_i - x_j and b = x_l - x_j, and the facet normals
m = e x a and n = b x e (equal directions when flat), the angle is

    theta = atan2(|e| m.b, m.n),     0 when flat, positive when the wings fold towards m,

which is exact near flat and has no threshold. Each wing has a height h over the edge, a foot at the fraction beta
along it, a unit normal n, and a unit vector t in the facet, away from the edge (all from its own triangle). Put
c = (1, -beta, beta - 1) and d = (0, 1, -1) for the nodes (wing, k, j). Then, for the nodes p and q of one wing,

    d theta / d x_p        = c_p n / h
    d2 theta / d x_p d x_q = -c_p c_q (n t' + t n') / h^2 - (c_p d_q u n' + d_p c_q n u') / (h |e|)
                             - d_p d_q (n t' + t n') / (2 |e|^2)

with u = e / |e|; theta's derivatives are the sum over both wings, and no second derivative joins the two wings.
This follows by turning and stretching one triangle at a time; it agrees with Schenk and Guest (2011) and Liu and
Paulino (2017), who write it in other vectors. Energy k (theta - theta_0)^2 / 2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.elements.angle import AngleKernel
from kirigami.elements.driven_rest import held_at, targets_of
from kirigami.errors import ModelError
from kirigami.primitives.checks import require_finite, require_positive
from kirigami.primitives.hardening import Hardening, YieldCurve, member_curve
from kirigami.primitives.kernel import EXACT, Array, CompiledKernel, Contribution, Kernel, Tangent, displacement_of
from kirigami.primitives.node import Node, require_nodes
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.words import counted

COLLINEAR = 1e-10  # a wing lower than this fraction of its edge has no direction
AT_ONCE = 8_000  # hinges whose second derivatives are worked out together, to spare memory and the processor's cache


@dataclass(frozen=True, slots=True, eq=False)
class BendHinge(ModelObject):
    """Rotational spring on the edge j-k between the facets (j, k, i) and (k, j, l).

    Parameters
    ----------
    i, j, k, l : Node
        Wing, the two nodes of the hinge line, other wing.
    stiffness : float
        Moment per angle of the whole edge [force length / rad], not per length.
    rest_angle : float, optional
        Angle without moment [rad]: 0 is flat, positive folds the wings towards the normal of (j, k, i).
        None takes the angle of the rest state (imperfection included).
    target_angle : float, optional
        Angle without moment at load factor 1 [rad]: it is driven there from the rest angle with the load factor.
    yield_moment : float, optional
        Moment at which the hinge yields first [force length]; None: it never does.
    hardening : float or array_like, shape (k, 2)
        How that moment grows with the accumulated plastic angle: a stiffness [force length / rad], or a table of angle
        and moment that does not fall, constant beyond its end.
    kinematic : float or array_like, shape (k, 2)
        Kinematic hardening, how the moment about which the hinge yields follows the plastic angle: a stiffness
        [force length / rad], or a table of plastic angle and that moment, from zero, that does not fall, constant
        beyond its end.

    Raises
    ------
    ModelError
        Stiffness not positive and finite, a repeated node, a rest angle that is not finite, a table that falls,
        hardening without a yield moment, or a hinge that both yields and is driven.

    Examples
    --------
    >>> import kirigami as kg
    >>> i, j, k, l = kg.Node(0, 1), kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, -1)
    >>> kg.BendHinge(i, j, k, l, stiffness=2.0).stiffness
    2.0
    """

    kind: ClassVar[str] = "element"
    i: Node
    j: Node
    k: Node
    l: Node
    stiffness: float
    rest_angle: float | None
    target_angle: float | None
    reached: float | None
    yield_curve: YieldCurve | None

    def __init__(
        self,
        i: Node,
        j: Node,
        k: Node,
        l: Node,
        stiffness: float,
        *,
        rest_angle: float | None = None,
        target_angle: float | None = None,
        yield_moment: float | None = None,
        hardening: float | ArrayLike = 0.0,
        kinematic: float | ArrayLike = 0.0,
    ) -> None:
        require_nodes("BendHinge", i=i, j=j, k=k, l=l)
        put = object.__setattr__
        put(self, "i", i)
        put(self, "j", j)
        put(self, "k", k)
        put(self, "l", l)
        put(self, "stiffness", require_positive(stiffness, "stiffness", "BendHinge"))
        put(self, "rest_angle", None if rest_angle is None else require_finite(rest_angle, "rest_angle", "BendHinge"))
        target = None if target_angle is None else require_finite(target_angle, "target_angle", "BendHinge")
        put(self, "target_angle", target)
        put(self, "reached", None)
        put(self, "yield_curve", member_curve(yield_moment, hardening, kinematic, "BendHinge", "yield_moment"))
        if target_angle is not None and yield_moment is not None:
            raise ModelError("a BendHinge that yields cannot be driven: give it target_angle or yield_moment")
        if len({id(i), id(j), id(k), id(l)}) < 4:
            raise ModelError(f"BendHinge on ({i!r}, {j!r}, {k!r}, {l!r}): the four nodes must differ")

    def held(self, lam: float) -> BendHinge:
        """The same, its rest angle where load factor `lam` has brought it."""
        held: BendHinge = held_at(self, "target_angle", lam)
        return held

    @property
    def nodes(self) -> tuple[Node, ...]:
        return (self.i, self.j, self.k, self.l)

    @classmethod
    def lower(cls, objects: Sequence[BendHinge], numbering: Numbering) -> list[Kernel]:
        if numbering.dim == 2:
            raise ModelError("BendHinge needs a model with dim=3: in a plane nothing bends; use TorsionSpring3 there")
        conn = numbering.connectivity(objects)
        stiffness = np.array([hinge.stiffness for hinge in objects])
        rest_angle = np.array([math.nan if hinge.rest_angle is None else hinge.rest_angle for hinge in objects])
        edge, wing_i, wing_l = _wing_vectors(numbering.rest, conn)
        for wing, corner in ((wing_i, 0), (wing_l, 3)):
            bad = np.flatnonzero(_wing(edge, wing)[0] <= COLLINEAR * np.sqrt((edge**2).sum(axis=0)))
            if bad.size:
                hinge = objects[int(bad[0])]
                raise ModelError(
                    f"{counted(bad.size, 'BendHinge')} with a wing on the hinge line, the first with wing "
                    f"{numbering.describe(hinge.nodes[corner])} on the line {numbering.describe(hinge.j)} to "
                    f"{numbering.describe(hinge.k)}: a wing must stand off the line"
                )
        yields = np.array([hinge.yield_curve is not None for hinge in objects])
        targets = targets_of(objects, "target_angle")
        if not yields.any():
            return [BendHingeKernel(numbering.rest, conn, stiffness, rest_angle, None, targets)]
        from kirigami.elements.member_yield import YieldingHingeKernel

        kernels: list[Kernel] = []
        for at in (np.flatnonzero(~yields), np.flatnonzero(yields)):
            some = [objects[position] for position in at.tolist()]
            arrays = numbering.rest, conn[at], stiffness[at], rest_angle[at], at, targets_of(some, "target_angle")
            if some and some[0].yield_curve is None:
                kernels.append(BendHingeKernel(*arrays))
            elif some:
                curves = [hinge.yield_curve for hinge in some]
                kernels.append(YieldingHingeKernel(*arrays, yields=Hardening.of(curves).packed))
        return kernels


def _wing_vectors(points: Array, conn: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """Edge e and wing vectors a, b, each (3, n)."""
    # Members last in memory, so that every operation runs through it.
    i, j, k, l = (np.ascontiguousarray(points[corner].T) for corner in np.ascontiguousarray(conn.T))
    return k - j, i - j, l - j


def _dot(a: Array, b: Array) -> Array:
    product: Array = a[0] * b[0]
    product += a[1] * b[1]
    product += a[2] * b[2]
    return product


def _cross(a: Array, b: Array) -> Array:
    product = np.empty_like(a)
    for axis, (one, other) in enumerate(((1, 2), (2, 0), (0, 1))):
        np.multiply(a[one], b[other], out=product[axis])
        product[axis] -= a[other] * b[one]
    return product


def _wing(edge: Array, wing: Array) -> tuple[Array, Array, Array]:
    """Height (n,), foot fraction beta (n,) and in-facet unit vector t (3, n) of a wing."""
    beta = _dot(edge, wing) / _dot(edge, edge)
    off = wing - beta * edge
    height = np.sqrt(_dot(off, off))
    with np.errstate(divide="ignore", invalid="ignore"):
        off /= height
    return height, beta, off


class BendHingeKernel(AngleKernel):
    """All bending hinges; see the module's text for the formulas. Local nodes: i, j, k, l."""

    name = "hinges"
    sheet_part = "hinges"
    pairs = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
    translation_invariant = True

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        stiffness: Array,
        rest_angle: Array,
        members: NDArray[np.int64] | None = None,
        targets: Array | None = None,
    ) -> None:
        self.rest, self.conn, self.stiffness, self.members = rest, conn, stiffness, members
        self._rest_vectors = _wing_vectors(rest, conn)
        self._begin(self.raw_angle(*self._rest_vectors), rest_angle, targets)

    def part(self, members: NDArray[np.int64]) -> Kernel:
        if type(self) is not BendHingeKernel:
            return self
        own = ("conn", "stiffness", "rest_angle", "drive", "members", "follows", "_initial", "_committed")
        part: BendHingeKernel = self._cut_out(members, dict.fromkeys(own, 0))
        edge, wing_i, wing_l = (np.take(vectors, members, 1) for vectors in self._rest_vectors)
        part._rest_vectors = edge, wing_i, wing_l
        return part

    def vectors(self, x: Array) -> tuple[Array, Array, Array]:
        """Current edge and wing vectors, each (3, n)."""
        edge, wing_i, wing_l = _wing_vectors(displacement_of(x, self.rest), self.conn)
        edge += self._rest_vectors[0]
        wing_i += self._rest_vectors[1]
        wing_l += self._rest_vectors[2]
        return edge, wing_i, wing_l

    @staticmethod
    def raw_angle(edge: Array, wing_i: Array, wing_l: Array) -> Array:
        m, n = _cross(edge, wing_i), _cross(wing_l, edge)
        angle: Array = np.arctan2(np.sqrt(_dot(edge, edge)) * _dot(m, wing_l), _dot(m, n))
        return angle

    def deformation(self, x: Array) -> Array:
        """Unwrapped angle of each hinge (n,) [rad]."""
        return self.unwrap(self.raw_angle(*self.vectors(x)))

    def angle_derivatives(self, x: Array) -> Array:
        return np.asarray(self.first_derivatives(*self.vectors(x))[1].transpose(2, 1, 0))

    def deformation_rate(self, x: Array, change: Array) -> Array:
        """First-order change of the angle (n,) for a displacement change (n_nodes, 3)."""
        _, gradient = self.first_derivatives(*self.vectors(x))
        rate: Array = np.einsum("akn,nka->n", gradient, change[self.conn])
        return rate

    @staticmethod
    def first_derivatives(edge: Array, wing_i: Array, wing_l: Array) -> tuple[list[tuple[Array, ...]], Array]:
        """Per wing (h, beta, t, n), and the gradient of the angle, shape (3, 4, n)."""
        unit = edge / np.sqrt(_dot(edge, edge))
        wings: list[tuple[Array, ...]] = []
        gradient = np.empty((3, 4, edge.shape[1]))
        for wing, node in ((wing_i, 0), (wing_l, 3)):
            height, beta, t = _wing(edge, wing)
            n = _cross(unit, t) if node == 0 else _cross(t, unit)
            np.divide(n, height, out=gradient[:, node])
            wings.append((height, beta, t, n))
        (_, beta, _, _), (_, other, _, _) = wings
        np.multiply(-beta, gradient[:, 0], out=gradient[:, 2])
        gradient[:, 2] -= other * gradient[:, 3]
        np.add(gradient[:, 0], gradient[:, 2], out=gradient[:, 1])  # shifting all four turns nothing
        gradient[:, 1] += gradient[:, 3]
        np.negative(gradient[:, 1], out=gradient[:, 1])
        return wings, gradient

    def _law(self, excess: Array) -> tuple[Array, Array, Array]:
        """Energy, moment and its slope, each (n,), at angles beyond those without moment."""
        moment = self.stiffness * excess
        return 0.5 * moment * excess, moment, self.stiffness

    def compiled(self) -> CompiledKernel | None:
        from kirigami.elements.compiled import CompiledHinges

        return CompiledHinges(self)

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        vectors = self.vectors(x)
        energy, moment, slope = self._law(self.unwrap(self.raw_angle(*vectors)) - self.rest_angle_at(lam))
        if need == 0:
            return Contribution(energy)
        wings, angle_gradient = self.first_derivatives(*vectors)
        gradient = (moment * angle_gradient).transpose(2, 1, 0)
        if need == 1:
            return Contribution(energy, gradient)
        hessian = np.empty((3, 3, len(self.pairs), len(energy)))
        moment = (1 - tangent.convexity) * moment
        for start in range(0, len(energy), AT_ONCE):
            some = slice(start, start + AT_ONCE)
            self.second_derivatives(
                hessian[..., some],
                slope[some],
                moment[some],
                vectors[0][:, some],
                [tuple(part[..., some] for part in wing) for wing in wings],
                angle_gradient[..., some],
            )
        return Contribution(energy, gradient, hessian.transpose(3, 2, 0, 1))

    @staticmethod
    def second_derivatives(
        hessian: Array, stiffness: Array, moment: Array, edge: Array, wings: list[tuple[Array, ...]], gradient: Array
    ) -> None:
        """Fill the blocks (3, 3, pairs, n): `stiffness` g g' plus `moment` (n,) times the second derivatives.

        Each block that a wing contributes to is n y' + z n', with n its normal.
        """
        outer = np.empty((3, 3, len(moment)))
        blocks = {pair: hessian[:, :, slot] for slot, pair in enumerate(BendHingeKernel.pairs)}

        def add(block: Array, a: Array, b: Array) -> None:
            np.multiply(a[:, None], b[None], out=outer)
            block += outer

        np.multiply((stiffness * gradient[:, 0])[:, None], gradient[None, :, 3], out=blocks[0, 3])
        np.multiply((stiffness * gradient[:, 1])[:, None], gradient[None, :, 2], out=blocks[1, 2])
        inverse_square = 1 / _dot(edge, edge)
        for (height, beta, t, n), wing in zip(wings, (0, 3)):
            share = stiffness / height
            over = (moment / height**2) * t
            skew = (moment * inverse_square / height) * edge  # M u / (h |e|)
            for node, c, along in ((1, beta - 1, skew), (2, -beta, -skew)):
                y, z = -c * over, along - c * over
                y += share * gradient[:, node]
                if wing == 0:
                    np.multiply(n[:, None], y[None], out=blocks[0, node])
                    add(blocks[0, node], z, n)
                else:
                    np.multiply(y[:, None], n[None], out=blocks[node, 3])
                    add(blocks[node, 3], n, z)
            common = (beta * (beta - 1) + 0.5 * height**2 * inverse_square) * over
            add(blocks[1, 2], n, common - beta * skew)
            add(blocks[1, 2], common - (beta - 1) * skew, n)
