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
from numpy.typing import NDArray

from kirigami.elements.angle import AngleKernel
from kirigami.errors import ModelError
from kirigami.kernel import Array, Contribution, Kernel, displacement_of
from kirigami.model import ModelObject, Node, Numbering, require_finite, require_positive

COLLINEAR = 1e-10  # a wing lower than this fraction of its edge has no direction


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

    Raises
    ------
    ModelError
        Stiffness not positive and finite, a repeated node, a rest angle that is not finite.

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

    def __init__(
        self, i: Node, j: Node, k: Node, l: Node, stiffness: float, *, rest_angle: float | None = None
    ) -> None:
        put = object.__setattr__
        put(self, "i", i)
        put(self, "j", j)
        put(self, "k", k)
        put(self, "l", l)
        put(self, "stiffness", require_positive(stiffness, "stiffness", "BendHinge"))
        put(
            self, "rest_angle", None if rest_angle is None else require_finite(rest_angle, "rest_angle", "BendHinge")
        )
        if len({id(i), id(j), id(k), id(l)}) < 4:
            raise ModelError(f"BendHinge on ({i!r}, {j!r}, {k!r}, {l!r}): the four nodes must differ")

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
                    f"{bad.size} BendHinge(s) with a wing on the hinge line, the first with wing "
                    f"{numbering.describe(hinge.nodes[corner])} on the line {numbering.describe(hinge.j)} to "
                    f"{numbering.describe(hinge.k)}: a wing must stand off the line"
                )
        return [BendHingeKernel(numbering.rest, conn, stiffness, rest_angle)]


def _wing_vectors(points: Array, conn: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """Edge e and wing vectors a, b, each (3, n)."""
    i, j, k, l = conn.T
    origin = points[j]
    return (points[k] - origin).T, (points[i] - origin).T, (points[l] - origin).T


def _dot(a: Array, b: Array) -> Array:
    product: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


def _cross(a: Array, b: Array) -> Array:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _wing(edge: Array, wing: Array) -> tuple[Array, Array, Array]:
    """Height (n,), foot fraction beta (n,) and in-facet unit vector t (3, n) of a wing."""
    beta = _dot(edge, wing) / _dot(edge, edge)
    off = wing - beta * edge
    height = np.sqrt(_dot(off, off))
    with np.errstate(divide="ignore", invalid="ignore"):
        return height, beta, off / height


class BendHingeKernel(AngleKernel):
    """All bending hinges; see the module's text for the formulas. Local nodes: i, j, k, l."""

    name = "hinges"
    pairs = ((0, 0), (0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3), (2, 2), (2, 3), (3, 3))

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        stiffness: Array,
        rest_angle: Array,
        members: NDArray[np.int64] | None = None,
    ) -> None:
        self.rest, self.conn, self.stiffness, self.members = rest, conn, stiffness, members
        self._rest_vectors = _wing_vectors(rest, conn)
        self._begin(self.raw_angle(*self._rest_vectors), rest_angle)

    def vectors(self, x: Array) -> tuple[Array, Array, Array]:
        u = displacement_of(x, self.rest)
        e, a, b = _wing_vectors(u, self.conn)
        return self._rest_vectors[0] + e, self._rest_vectors[1] + a, self._rest_vectors[2] + b

    @staticmethod
    def raw_angle(edge: Array, wing_i: Array, wing_l: Array) -> Array:
        m, n = _cross(edge, wing_i), _cross(wing_l, edge)
        angle: Array = np.arctan2(np.sqrt(_dot(edge, edge)) * _dot(m, wing_l), _dot(m, n))
        return angle

    def deformation(self, x: Array) -> Array:
        """Unwrapped angle of each hinge (n,) [rad]."""
        return self.unwrap(self.raw_angle(*self.vectors(x)))

    def deformation_rate(self, x: Array, change: Array) -> Array:
        """First-order change of the angle (n,) for a displacement change (n_nodes, 3)."""
        _, gradient = self.first_derivatives(*self.vectors(x))
        rate: Array = np.einsum("akn,nka->n", gradient, change[self.conn])
        return rate

    @staticmethod
    def first_derivatives(edge: Array, wing_i: Array, wing_l: Array) -> tuple[list[tuple[Array, ...]], Array]:
        """Per wing (h, beta, t, n, inverse length), and the gradient of the angle, shape (3, 4, n)."""
        inverse_length = 1 / np.sqrt(_dot(edge, edge))
        unit = edge * inverse_length
        wings: list[tuple[Array, ...]] = []
        gradient = np.zeros((3, 4, edge.shape[1]))
        for wing, node, side in ((wing_i, 0, 1.0), (wing_l, 3, -1.0)):
            height, beta, t = _wing(edge, wing)
            n = _cross(unit, t) * side
            g = n / height
            gradient[:, node] = g
            gradient[:, 1] += (beta - 1) * g
            gradient[:, 2] -= beta * g
            wings.append((height, beta, t, n))
        return wings, gradient

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        edge, wing_i, wing_l = self.vectors(x)
        excess = self.unwrap(self.raw_angle(edge, wing_i, wing_l)) - self.rest_angle
        moment = self.stiffness * excess
        energy = 0.5 * moment * excess
        if need == 0:
            return Contribution(energy)
        wings, angle_gradient = self.first_derivatives(edge, wing_i, wing_l)
        gradient = moment * angle_gradient
        if need == 1:
            return Contribution(energy, gradient.transpose(2, 1, 0))
        moment = (1 - self.convexity) * moment
        # Material part k g g', then the moment times the second derivatives, wing by wing.
        hessian = np.empty((3, 3, len(self.pairs), edge.shape[1]))
        stiff = self.stiffness * angle_gradient
        for slot, (p, q) in enumerate(self.pairs):
            np.multiply(stiff[:, None, p], angle_gradient[None, :, q], out=hessian[:, :, slot])
        self.add_second_derivatives(hessian, moment, edge, wings)
        return Contribution(energy, gradient.transpose(2, 1, 0), hessian.transpose(3, 2, 0, 1))

    @classmethod
    def add_second_derivatives(cls, hessian: Array, moment: Array, edge: Array, wings: list[tuple[Array, ...]]) -> None:
        """Add `moment` (n,) times the second derivatives of the angle to blocks (3, 3, pairs, n)."""
        slot_of = {pair: slot for slot, pair in enumerate(cls.pairs)}
        inverse_length = 1 / np.sqrt(_dot(edge, edge))
        unit = edge * inverse_length
        for (height, beta, t, n), node in zip(wings, (0, 3)):
            turn = n[:, None] * t[None]
            turn = (turn + turn.swapaxes(0, 1)) * (moment / height**2)  # (n t' + t n') M / h^2
            skew = unit[:, None] * (n * (moment * inverse_length / height))[None]  # u n' M / (h |e|)
            skew_turned = skew.swapaxes(0, 1)
            stretch = turn * (0.5 * (height * inverse_length) ** 2)  # (n t' + t n') M / (2 |e|^2)
            c = {node: np.ones_like(beta), 2: -beta, 1: beta - 1}
            d = {node: 0.0, 2: 1.0, 1: -1.0}
            for p, q in ((node, node), (node, 1), (node, 2), (1, 1), (1, 2), (2, 2)):
                target = hessian[:, :, slot_of[min(p, q), max(p, q)]]
                if p > q:  # stored as the block (q, p)
                    p, q = q, p
                target -= (c[p] * c[q]) * turn
                if d[q]:
                    target -= (c[p] * d[q]) * skew
                if d[p]:
                    target -= (d[p] * c[q]) * skew_turned
                if d[p] and d[q]:
                    target -= (d[p] * d[q]) * stretch
