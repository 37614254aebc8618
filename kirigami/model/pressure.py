"""Pressure on the facets of a sheet: it follows them, so that it always acts along their normals.

With the place x = sum N_a x_a on a facet (corners, on shell facets also the bulges of the edges) the volume between the
facets and a point o is V = sum A_abc [x_a x_b x_c], the box product of rows from o. Its change is

    dV = integral n.dx + (1/3) integral over the rim of dx.(dx_s x x)

so the pressure does work by the potential -p V, whose Hessian is symmetric, and by a rest that lives on the rim alone:
-(p/3) N_a x x dx_s on each edge of it. The rest does no work where the rim is closed, is held, or lies in a plane of
symmetry through o. Elsewhere, as at every open cut, the pressure has no potential (Schweizerhof and Ramm, Comput.
Struct. 18 (1984), 1099): the kernel of the rim then says ``conservative = False`` and gives the symmetric part of its
tangent; what that lacks, paths know by :mod:`kirigami.analysis.path.skew`. The forces are exact.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import KirigamiWarning, ModelError
from kirigami.geometry.topology import paired_half_edges
from kirigami.model.constraints import Constraint
from kirigami.model.grip import Grip
from kirigami.model.loads import Load, LoadKernel
from kirigami.model.spread_loads import Surface, _facets
from kirigami.primitives.checks import require_boolean, require_finite
from kirigami.primitives.kernel import Array, Contribution, Kernel, displacement_of
from kirigami.primitives.node import AXES, Node
from kirigami.primitives.parts import Numbering
from kirigami.primitives.rotation import cross_matrices
from kirigami.words import counted

Index = NDArray[np.int64]
CLOSES = 0.25  # area vectors that are left over their sizes, below which facets close round a space
ROUND = 0.02  # ... of a space that is more than rounding
IN_PLANE = 1e-9  # distance from a plane of symmetry over the size of the structure that is none


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class Pressure(Load):
    """A pressure on facets that follows them: force per area as they are, along the normals they have then.

    Where the rim of the facets is free to move it has no potential, so that stability cannot be counted: walk with
    ``on_instability="follow"`` then.

    Parameters
    ----------
    p : float
        Pressure at load factor 1 [force / length^2], positive towards the side of the normals, from which the corners
        of facets run counter-clockwise.
    facets : str or array_like of int, optional
        Name of a region of the mesh, or numbers of facets; None is the whole sheet.
    constant : bool
        The pressure acts at full size whatever the load factor.

    Raises
    ------
    ModelError
        A pressure that is not finite; in a run facets that are not there, a model with dim=2 or without facets, or
        facets that are turned against each other.

    Warns
    -----
    KirigamiWarning
        In a run, where the facets close round a space, as a tube or a balloon, and their normals point into it, so that
        a positive pressure presses from outside.

    Examples
    --------
    >>> import kirigami as kg
    >>> mesh = kg.Sheet([(0, 0), (4, 0), (4, 4), (0, 4)]).mesh(1.5)
    >>> m = kg.Model.from_mesh(mesh, thickness=0.1, material=kg.Material(E=1e6), stiffness="shell")
    >>> held = m.add(kg.Fix(m.select(boundary="outer")), kg.Pressure(2.0))
    >>> round(float(kg.LinearStatic(m).run().reaction("fixed_0", "z")[-1]), 6)
    -32.0
    """

    p: float
    facets: Index | str | None
    constant: bool

    def __init__(self, p: float, facets: str | ArrayLike | None = None, constant: bool = False) -> None:
        object.__setattr__(self, "p", require_finite(p, "p", "Pressure"))
        object.__setattr__(self, "facets", _facets(facets, "Pressure"))
        object.__setattr__(self, "constant", require_boolean(constant, "constant", "Pressure"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return ()

    def held(self, lam: float) -> Pressure:
        """The same, constant at load factor `lam`."""
        lam = require_finite(lam, "lam", "Pressure.held")
        return self if self.constant else Pressure(lam * self.p, self.facets, constant=True)

    @classmethod
    def lower(cls, objects: Sequence[Pressure], numbering: Numbering) -> list[Kernel]:
        if numbering.dim == 2:
            raise ModelError(f"{objects[0]!r} acts across the sheet, but the model has dim=2: make it with dim=3")
        surface = Surface(numbering, "Pressure")
        origin, still, planes = _supports(numbering)
        kernels: list[Kernel] = []
        for item in objects:
            facets = surface.chosen(item.facets, repr(item))
            triangles = surface.triangles[facets]
            conn = _with_middles(triangles, surface)
            kernels.append(PressureKernel(numbering.rest, conn, item.p, origin, item.constant))
            first, second = paired_half_edges(triangles)
            both = np.flatnonzero(second >= 0)
            start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
            against = both[start[first[both]] == start[second[both]]]
            if against.size:
                a, b = (numbering.describe(int(node[first[against[0]]])) for node in (start, end))
                raise ModelError(
                    f"{item!r}: the two facets at the edge from {a} to {b} are turned against each other, so that the "
                    "pressure would change sides there: list their corners in the same sense"
                )
            if item.p > 0:
                _tell_inward(numbering.rest[triangles], repr(item))
            rim = first[second < 0]
            ends = np.stack([start[rim], end[rim]], axis=1)
            if len(ends):
                works = ~(still[ends].all(axis=1) | (planes[:, ends].all(axis=2)).any(axis=0))
                lines = _with_middles(ends, surface)
                for free in (False, True):
                    if (works == free).any():
                        own = lines[works == free]
                        kernels.append(RimPressureKernel(numbering.rest, own, item.p, origin, item.constant, free))
        return kernels

    def __repr__(self) -> str:
        where = "" if self.facets is None else f", {self.facets!r}" if isinstance(self.facets, str) else (
            f", {counted(len(self.facets), 'facet')}"
        )
        return f"Pressure({self.p:g}{where}{', constant=True' if self.constant else ''})"


def _tell_inward(corners: Array, owner: str) -> None:
    """Warn where facets with corners (n, 3, 3) close round a space that their normals point into.

    The area vectors of what closes round a space cancel; the space is then a third of the sum of theirs times the ways
    from its middle, with the sign of the side.
    """
    vectors = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(vectors, axis=1)
    if np.linalg.norm(vectors.sum(axis=0)) > CLOSES * area.sum():
        return
    centres = corners.mean(axis=1)
    ways = centres - np.average(centres, axis=0, weights=area)
    if float((ways * vectors).sum()) < -ROUND * float(np.linalg.norm(ways, axis=1) @ area):
        warnings.warn(
            f"{owner}: its facets close round a space and their normals point into it, so that this pressure presses "
            "on them from outside: give it the other sign, or list the corners of the facets the other way round, to "
            "blow them up",
            KirigamiWarning,
            stacklevel=6,
        )


def _supports(numbering: Numbering) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """The point o, the nodes (n,) that do not move freely, and those in each plane of symmetry (planes, n)."""
    items = [item for group in numbering.objects.values() for item in group if isinstance(item, Constraint)]
    origin = numbering.rest[: numbering.points].mean(axis=0)
    held = np.zeros((numbering.points, 3), dtype=bool)
    planes = []
    for item in items:
        nodes = numbering.index(item.group)
        if isinstance(item, Grip):
            held[nodes] = None not in item.move + item.turn
        for axis in item.values if not item.leaders else ():
            held[nodes, AXES.index(axis)] = True
            if item.mirror:
                origin[AXES.index(axis)] = numbering.rest[nodes[0], AXES.index(axis)]
                away = np.abs(numbering.rest[: numbering.points, AXES.index(axis)] - origin[AXES.index(axis)])
                planes.append((np.isin(np.arange(numbering.points), nodes), away <= IN_PLANE * numbering.size))
    still: NDArray[np.bool_] = np.asarray(held.all(axis=1))
    inside = np.array([(mirrored | still) & near for mirrored, near in planes], dtype=bool)
    return origin, still, inside.reshape(len(planes), numbering.points)


def _with_middles(corners: Index, surface: Surface) -> Index:
    """Rows of facets (m, 3) or edges (m, 2), with those of the middles of their edges where elements have such."""
    edges = surface.numbering.edges
    if edges is None:
        return corners
    sides = [corners] if corners.shape[1] == 2 else [corners[:, [k, (k + 1) % 3]] for k in range(3)]
    found = [surface.middles(ends) for ends in sides]
    if any((rows < 0).any() for rows in found):
        raise ModelError("Pressure: an element of the sheet was taken out, so that it cannot bear the pressure there")
    return np.column_stack([corners, *found])


def _line_tensor(k: int) -> Array:
    """Integrals L (k, k, k) of N_a N_b N_c' along an edge with k rows."""
    place, weight = np.polynomial.legendre.leggauss(5)
    s, weight = 0.5 * (place + 1), 0.5 * weight
    shape, slope = np.stack([1 - s, s, 4 * s * (1 - s)]), np.stack([0 * s - 1, 0 * s + 1, 4 - 8 * s])
    return np.asarray(np.einsum("an,bn,cn,n->abc", shape[:k], shape[:k], slope[:k], weight))


def _area_tensor(k: int) -> Array:
    """A (k, k, k) of a facet with k rows: a third of the integrals of N_a (N_b,u N_c,v), without what cancels."""
    place, weight = np.polynomial.legendre.leggauss(6)
    r, v = (part.ravel() for part in np.meshgrid(0.5 * (place + 1), 0.5 * (place + 1), indexing="ij"))
    weights = 0.25 * np.outer(weight, weight).ravel() * (1 - r)
    l = np.stack([1 - r - v * (1 - r), r, v * (1 - r)])
    dl = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    shape, slope = list(l), [np.tile(row[:, None], len(r)) for row in dl]
    for a, b in ((0, 1), (1, 2), (2, 0)):
        shape.append(4 * l[a] * l[b])
        slope.append(4 * (l[a] * dl[b][:, None] + l[b] * dl[a][:, None]))
    N, D = np.stack(shape)[:k], np.stack(slope)[:k]
    plain = np.einsum("an,bn,cn,n->abc", N, D[:, 0], D[:, 1], weights) / 3
    turns = plain + plain.transpose(1, 2, 0) + plain.transpose(2, 0, 1)
    return np.asarray((turns - turns.transpose(0, 2, 1)) / 6)


class _Follower(LoadKernel):
    """What the two kernels of a pressure share."""

    corners: ClassVar[int]  # of a member; the rows behind them are those of bulges

    def __init__(self, rest: Array, conn: Index, p: float, origin: Array, constant: bool = False) -> None:
        super().__init__(constant)
        self.rest, self.conn, self.p, self.origin = rest, conn, float(p), origin
        self._start = rest[conn].copy()
        self._start[:, : self.corners] -= origin

    def arrays(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("conn", "p", "origin", "constant")}

    def _places(self, x: Array) -> Array:
        """Rows (n, k, 3): corners from o, and bulges."""
        return np.asarray(self._start + displacement_of(x, self.rest)[self.conn])


class PressureKernel(_Follower):
    """The part of a pressure with the potential -p V, by facets. Rows: corners, then bulges of edges 01, 12, 20."""

    name = "pressure"
    corners = 3

    def __init__(self, rest: Array, conn: Index, p: float, origin: Array, constant: bool = False) -> None:
        super().__init__(rest, conn, p, origin, constant)
        self._tensor = _area_tensor(conn.shape[1])

    def deformation(self, x: Array) -> Array:
        """Volume (n,) between each facet and the point o [length^3]."""
        places = self._places(x)
        return np.asarray(np.einsum("nai,nai->n", places, self._slopes(places)) / 3)

    def _slopes(self, places: Array) -> Array:
        """Derivatives (n, k, 3) of the volume."""
        return np.asarray(3 * np.einsum("abc,nbci->nai", self._tensor, _products(places)))

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        places, p = self._places(x), self.p * self.factor(lam)
        slopes = self._slopes(places)
        energy = -p * np.einsum("nai,nai->n", places, slopes) / 3
        if need < 2:
            return Contribution(energy, -p * slopes)
        n, k = self.conn.shape
        arms = np.einsum("abc,nci->nabi", self._tensor, places)
        return Contribution(energy, -p * slopes, 6 * p * cross_matrices(arms.reshape(-1, 3)).reshape(n, k, k, 3, 3))


class RimPressureKernel(_Follower):
    """What the rim adds to the forces of a pressure, edge by edge; it has no potential. Rows: ends, then the bulge.

    `free` says that the rim can move so that this does work.
    """

    name = "pressure at the rim"
    corners = 2

    def __init__(
        self, rest: Array, conn: Index, p: float, origin: Array, constant: bool = False, free: bool = True
    ) -> None:
        super().__init__(rest, conn, p, origin, constant)
        self.free = bool(free)
        self.conservative = not self.free
        self._tensor = _line_tensor(conn.shape[1])

    def arrays(self) -> dict[str, Any]:
        return {**super().arrays(), "free": self.free}

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        places, p = self._places(x), self.p * self.factor(lam)
        gradient = -p / 3 * np.einsum("abc,nbci->nai", self._tensor, _products(places))
        energy = np.zeros(len(places))
        if need < 2:
            return Contribution(energy, gradient)
        n, k = self.conn.shape
        arms = np.einsum("abc,nci->nabi", self._tensor - self._tensor.transpose(0, 2, 1), places)
        slope = p / 3 * cross_matrices(arms.reshape(-1, 3)).reshape(n, k, k, 3, 3)
        return Contribution(energy, gradient, 0.5 * (slope + slope.transpose(0, 2, 1, 4, 3)))


def _products(places: Array) -> Array:
    """Cross products (n, k, k, 3) of all pairs of rows."""
    return np.asarray(np.cross(places[:, :, None], places[:, None, :]))
