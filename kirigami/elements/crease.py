"""The crease: a fold line of a sheet of shell facets, elastic in its angle.

An edge of a crease has two angles where a smooth edge has one, one for the facet on each side. With theta the angle
between the two sides, 0 flat and positive where they fold towards the normal, and c its stiffness per length, the
energy is c / 2 times the integral of (theta - theta_0)^2 along the edge, by the two Gauss points where the angles are.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.driven_rest import driven, held_at, targets_of, untouched
from kirigami.errors import ModelError
from kirigami.geometry.topology import pair_numbers
from kirigami.primitives.checks import require_finite
from kirigami.primitives.kernel import Array, Contribution, Kernel
from kirigami.primitives.node import Node, listed
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.primitives.rows import EdgeRows
from kirigami.words import counted

SCORE = 100.0  # thicknesses: width of the strip of sheet that is as stiff as a fold of which nothing is known


def score_stiffness(thickness: Array, sections: Array) -> Array:
    """Moment per angle and length [force / rad] of a fold of which nothing is known: that of a light score.

    D / (100 t), with D = E t^3 / (12 (1 - nu^2)), or that of the stiffer direction, for sheets of a thickness (n,) and
    section matrices (n, 6, 6): the fold turns as much as a strip of the sheet a hundred thicknesses
    wide. Folds range from ten times this, in a sheet hardly scored, down to free hinges, where it is perforated.
    """
    return np.asarray(np.maximum(sections[:, 3, 3], sections[:, 4, 4]) / (SCORE * thickness))


@dataclass(frozen=True, slots=True, eq=False, repr=False, init=False)
class Crease(ModelObject):
    """Fold line along edges of shell facets: a hinge with stiffness and rest angle.

    Parameters
    ----------
    nodes : sequence of Node
        The nodes along the fold, in order; every two in a row are the ends of an edge between two shell facets. A
        closed fold ends with the node it starts from.
    stiffness : float
        Moment per angle and length of fold [force / rad]; 0 is a free hinge.
    rest_angle : float, optional
        Angle [rad] at which the fold makes no moment, 0 flat, positive where the sides fold towards the normal; None
        takes the angle of the rest shape.
    target_angle : float, optional
        Angle without moment at load factor 1 [rad]: it is driven there from the rest angle with the load factor.

    Raises
    ------
    ModelError
        Fewer than two nodes, a node that follows itself, a negative stiffness, an angle beyond half a turn.

    Examples
    --------
    >>> import kirigami as kg
    >>> fold = kg.Crease([kg.Node(0, 0), kg.Node(0, 1)], stiffness=0.2, rest_angle=1.0)
    >>> fold
    Crease(2 nodes, stiffness=0.2)
    """

    kind: ClassVar[str] = "element"
    line: tuple[Node, ...]
    stiffness: float
    rest_angle: float | None
    target_angle: float | None
    reached: float | None

    def __init__(
        self,
        nodes: Iterable[Node],
        stiffness: float,
        rest_angle: float | None = None,
        target_angle: float | None = None,
    ) -> None:
        line = listed(nodes, "Crease")
        if len(line) < 2:
            raise ModelError("Crease: give at least two nodes, the ends of an edge")
        for a, b in pairwise(line):
            if a is b:
                raise ModelError(f"Crease: {a!r} follows itself")
        stiffness = require_finite(stiffness, "stiffness", "Crease")
        if stiffness < 0:
            raise ModelError(f"Crease: stiffness must not be negative, got {stiffness}")
        object.__setattr__(self, "line", line)
        object.__setattr__(self, "stiffness", stiffness)
        object.__setattr__(self, "rest_angle", _angle(rest_angle, "rest_angle"))
        object.__setattr__(self, "target_angle", _angle(target_angle, "target_angle"))
        object.__setattr__(self, "reached", None)

    def held(self, lam: float) -> Crease:
        """The same, its rest angle where load factor `lam` has brought it."""
        held: Crease = held_at(self, "target_angle", lam)
        return held

    @property
    def nodes(self) -> tuple[Node, ...]:
        return self.line

    def __repr__(self) -> str:
        return f"Crease({counted(len(self.line), 'node')}, stiffness={self.stiffness:.6g})"

    @classmethod
    def lower(cls, objects: Sequence[Crease], numbering: Numbering) -> list[Kernel]:
        edges = numbering.edges
        if edges is None:
            raise ModelError("Crease: the model has no shell facets to fold; make it with stiffness='shell'")
        pairs = folded_pairs(objects, numbering)
        owner = np.repeat(np.arange(len(objects)), [len(item.line) - 1 for item in objects])
        edge = pair_numbers(pairs, edges.ends, numbering.points)
        conn, angle, length = fold_sides(edges, edge, numbering.rest)
        stiffness = np.array([item.stiffness for item in objects])[owner]
        wanted = np.array([np.nan if item.rest_angle is None else item.rest_angle for item in objects])[owner]
        wanted = np.where(np.isnan(wanted), angle, wanted)
        targets = targets_of(objects, "target_angle")
        targets = None if targets is None else targets[:, owner]
        return [CreaseKernel(numbering.rest, conn, stiffness, wanted, angle, length, owner, targets, pairs)]


def _angle(value: float | None, name: str) -> float | None:
    """An angle of a fold, at most half a turn either way."""
    if value is None:
        return None
    angle = require_finite(value, name, "Crease")
    if abs(angle) > np.pi:
        raise ModelError(f"Crease: {name} must lie between -pi and pi, got {angle}")
    return angle


def folded_pairs(objects: Iterable[Crease], numbering: Numbering) -> NDArray[np.int64]:
    """Nodes (k, 2) of the edges along creases, the lower first."""
    pairs = [np.stack([line[:-1], line[1:]], axis=1) for line in (numbering.index(item.line) for item in objects)]
    both = np.sort(np.concatenate(pairs or [np.empty((0, 2), np.int64)]), axis=1)
    code, counts = np.unique(both, axis=0, return_counts=True)
    if (counts > 1).any():
        a, b = code[counts > 1][0].tolist()
        raise ModelError(f"Crease: the edge from {numbering.describe(a)} to {numbering.describe(b)} is folded twice")
    return both


def fold_sides(edges: EdgeRows, edge: NDArray[np.int64], rest: Array) -> tuple[NDArray[np.int64], Array, Array]:
    """Angle rows (k, 2) of the sides of folded edges, the side that runs with the edge first; the angles (k,) at rest
    and the lengths (k,)."""
    forward = edges.forward
    sides = []
    normals = []
    for running in (forward, ~forward):
        facet, local = np.nonzero(running)
        at = edges.edge[facet, local]
        order = np.argsort(at)
        found = order[np.searchsorted(at[order], edge)]
        sides.append(edges.angle[facet[found], local[found]])
        corners = rest[edges.triangles[facet[found]]]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals.append(normal / np.linalg.norm(normal, axis=1)[:, None])
    along = rest[edges.ends[edge, 1]] - rest[edges.ends[edge, 0]]
    length = np.linalg.norm(along, axis=1)
    sine = -np.einsum("na,na->n", np.cross(normals[0], normals[1]), along) / length
    angle = np.arctan2(sine, np.einsum("na,na->n", normals[0], normals[1]))
    return np.stack(sides, axis=1), angle, length


class CreaseKernel(Kernel):
    """All edges of creases; local rows: the angles of the facet that runs with the edge, and of the other."""

    name = "creases"
    pairs = ((0, 0), (0, 1), (1, 1))
    measures_displacement = True

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        stiffness: Array,
        rest_angle: Array,
        initial: Array,
        length: Array,
        members: NDArray[np.int64] | None = None,
        targets: Array | None = None,
        places: NDArray[np.int64] | None = None,
    ) -> None:
        self.rest, self.conn, self.members, self.places = rest, conn, members, places
        self.stiffness, self.initial, self.length = stiffness, initial, length
        self.rest_angle, self.drive = driven(rest_angle, targets)
        self.scaled = self.drive is not None

    def arrays(self) -> dict[str, Any]:
        names = ("conn", "stiffness", "rest_angle", "initial", "length", "members", "places")
        own = {name: getattr(self, name) for name in names}
        return own if self.drive is None else {**own, "targets": untouched(self.rest_angle, self.drive)}

    def rest_angle_at(self, lam: float) -> Array:
        """Angle without moment (n,) at a load factor."""
        return self.rest_angle if self.drive is None else self.rest_angle + lam * self.drive

    def _angles(self, x: Array) -> Array:
        """Angles (n, 2) of the folds at their Gauss points."""
        stored = np.asarray(x)[self.conn, :2]
        return np.asarray(self.initial[:, None] + (stored[:, 1] - stored[:, 0]) / self.length[:, None])

    def deformation(self, x: Array) -> Array:
        """Mean angle (n,) of each edge of the creases [rad]; 0 is flat."""
        return np.asarray(self._angles(x).mean(axis=1))

    def force(self, deformation: Array) -> Array:
        """Moment per length (n,) [force], positive where the angle is above its rest value."""
        return np.asarray(self.stiffness * (deformation - self.rest_angle))

    def force_at(self, deformation: Array, lam: float) -> Array:
        return np.asarray(self.stiffness * (deformation - self.rest_angle_at(lam)))

    def by_load(self, x: Array, lam: float, need: int = 1) -> Contribution:
        assert self.drive is not None
        excess = self._angles(x) - self.rest_angle_at(lam)[:, None]
        weight = 0.5 * self.stiffness * self.length
        gradient = np.zeros((len(weight), 2, 3))
        gradient[:, 1, :2] = -(weight / self.length * self.drive)[:, None]
        gradient[:, 0] = -gradient[:, 1]
        return Contribution(-weight * self.drive * excess.sum(axis=1), gradient)

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        excess = self._angles(x) - self.rest_angle_at(lam)[:, None]
        weight = 0.5 * self.stiffness * self.length
        energy = 0.5 * weight * (excess**2).sum(axis=1)
        if need == 0:
            return Contribution(energy)
        n = len(energy)
        gradient = np.zeros((n, 2, 3))
        gradient[:, 1, :2] = (weight / self.length)[:, None] * excess
        gradient[:, 0] = -gradient[:, 1]
        if need == 1:
            return Contribution(energy, gradient)
        hessian = np.zeros((n, 3, 3, 3))
        for axis in range(2):
            hessian[:, [0, 2], axis, axis] = (weight / self.length**2)[:, None]
            hessian[:, 1, axis, axis] = -weight / self.length**2
        return Contribution(energy, gradient, hessian)
