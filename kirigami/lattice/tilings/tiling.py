"""Panels that share corners: the geometry of an in-plane mechanism, and the planar model made of it.

A corner is written (vertex, n1, n2): the vertex of the cell, moved by n1 and n2 lattice vectors. A finite tiling has
no lattice and all shifts zero, so finite patches and periodic cells are one thing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kirigami.errors import GeometryError, ModelError
from kirigami.lattice.tilings.panel import Ligament, braces
from kirigami.primitives.checks import (
    require_array,
    require_callable,
    require_choice,
    require_finite,
    require_instance,
    require_items,
    require_positive,
    require_whole,
    require_whole_array,
    shown,
)
from kirigami.primitives.kernel import Array
from kirigami.words import counted

if TYPE_CHECKING:
    from kirigami.effects.angle_limit import AngleLimit
    from kirigami.model.model import Model

Corner = tuple[int, int, int]  # vertex of the cell, shifts along the two lattice vectors
TURN = 2 * math.pi
CLOSED = 1e-9  # a gap that closes to rounding [rad]
MOST_PANELS = 1_000_000  # of a patch; more is a slip
SMALL = 1e-9  # areas and overlaps below this share of a panel are rounding


class Gap(NamedTuple):
    """The opening between two neighbouring panels at a joint.

    ``left`` and ``right`` are the arm ends and ``pivot`` the joint, as indices of ``Tiling.vertices``; ``angle`` runs
    counter-clockwise from the arm to ``right`` to the arm to ``left`` [rad]; ``joint`` counts the joints.
    """

    left: int
    pivot: int
    right: int
    angle: float
    joint: int


@dataclass(frozen=True, eq=False, repr=False)
class Tiling:
    """Panels joined where they share a corner.

    Parameters
    ----------
    points : array_like, shape (v, 2)
        Vertices, for a periodic tiling those of one cell [length].
    panels : sequence of sequences
        The corners of each panel in order round it: vertex numbers, or triples (vertex, n1, n2) that move a vertex
        by lattice vectors. Clockwise panels are turned round.
    lattice : array_like, shape (2, 2), optional
        The two lattice vectors, one a row [length]; None for a finite tiling.

    Attributes
    ----------
    corners : list of (int, int, int)
        Every corner in use, in the order of `vertices`; those of the cell itself come first.
    vertices : ndarray, shape (m, 2)
        Their positions. ``model.nodes[k]`` stands at ``vertices[k]``.

    Raises
    ------
    GeometryError
        Points that are not finite, panels of fewer than three corners, without area or crossing themselves, panels
        that overlap, a vertex that no panel uses, lattice vectors that are parallel.

    Examples
    --------
    >>> from kirigami.lattice.tilings import Tiling
    >>> pair = Tiling([[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]], [[0, 1, 2], [0, 3, 4]])
    >>> print(pair)
    Tiling of 2 panels with 1 joint
    >>> print(pair.model(EA=1.0, stiffness=0.1))
    Model in 2D: 5 nodes, 6 Bar, 1 TorsionSpring3
    """

    points: Array
    panels: tuple[tuple[Corner, ...], ...]
    lattice: Array | None = None

    def __init__(self, points: ArrayLike, panels: Iterable[Sequence[Any]], lattice: ArrayLike | None = None) -> None:
        put = object.__setattr__
        put(self, "points", require_array(points, (None, 2), name="points", owner="Tiling", error=GeometryError))
        if lattice is not None:
            lattice = require_array(lattice, (2, 2), name="lattice", owner="Tiling", error=GeometryError)
            if not abs(np.linalg.det(lattice)) > SMALL * (lattice**2).sum():
                raise GeometryError("Tiling: lattice must hold two vectors (2, 2) that are not parallel")
        put(self, "lattice", lattice)
        listed = require_items(panels, "panels", "Tiling", GeometryError)
        put(self, "panels", tuple(self._checked_panel(k, panel) for k, panel in enumerate(listed)))
        used = {vertex for panel in self.panels for vertex, _, _ in panel}
        unused = sorted(set(range(len(self.points))) - used)
        if unused:
            raise GeometryError(f"Tiling: no panel uses vertex {unused[0]} at {place_of(self.points[unused[0]])}")
        self._check_overlap()

    def _checked_panel(self, number: int, panel: Sequence[Any]) -> tuple[Corner, ...]:
        corners: list[Corner] = []
        for item in require_items(panel, f"panel {number}", "Tiling", GeometryError):
            try:
                corner = (int(item), 0, 0) if isinstance(item, (int, np.integer)) else tuple(int(part) for part in item)
            except (TypeError, ValueError, OverflowError):
                corner = ()
            if len(corner) != 3 or not 0 <= corner[0] < len(self.points) or (self.lattice is None and any(corner[1:])):
                raise GeometryError(f"Tiling: panel {number} has the corner {shown(item)}, which is not in the tiling")
            corners.append(corner)
        if len(set(corners)) != len(corners) or len(corners) < 3:
            raise GeometryError(f"Tiling: panel {number} needs three or more different corners, got {list(panel)}")
        shape = self.place(corners)
        x, y = (shape - shape[0]).T
        area = 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
        if not abs(area) > SMALL * float(np.ptp(shape, axis=0).max()) ** 2:
            raise GeometryError(f"Tiling: panel {number} around {place_of(shape.mean(axis=0))} has no area")
        return tuple(corners if area > 0 else corners[::-1])

    def _check_overlap(self) -> None:
        """Panels may touch, also along whole edges, but not overlap."""
        import shapely

        shapes = [self.place(panel) for panel in self.panels]
        shifts: list[tuple[int, int]] = [(0, 0)]
        if self.lattice is not None:
            shifts += [(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1) if (a, b) != (0, 0)]
        polygons = np.array([
            shapely.Polygon(shape + (0 if self.lattice is None else shift @ self.lattice))
            for shift in np.array(shifts) for shape in shapes
        ])  # fmt: skip
        count = len(shapes)
        crossed = np.flatnonzero(~shapely.is_valid(polygons[:count]))
        if crossed.size:
            k = int(crossed[0])
            where = place_of(shapes[k].mean(axis=0))
            raise GeometryError(f"Tiling: the outline of panel {k} around {where} crosses itself")
        first, second = shapely.STRtree(polygons).query(polygons[:count], predicate="intersects")
        first, second = first[first < second], second[first < second]
        common = shapely.area(shapely.intersection(polygons[first], polygons[second]))
        smaller = np.minimum(shapely.area(polygons[first]), shapely.area(polygons[second]))
        bad = np.flatnonzero(common > SMALL * smaller)
        if bad.size:
            k = bad[0]
            both = shapely.intersection(polygons[first[k]], polygons[second[k]])
            where = place_of(both.centroid.coords[0])
            raise GeometryError(
                f"Tiling: panels {first[k]} and {second[k] % count} overlap around {where}"
                + f", the first of {counted(bad.size, 'such pair')}" * (bad.size > 1)
            )

    def place(self, corners: Iterable[Corner]) -> Array:
        """Positions (k, 2) of corners."""
        given = require_items(corners, "corners", "Tiling.place", GeometryError)
        if not given:
            return np.zeros((0, 2))
        listed = require_whole_array(given, (None, 3), name="corners", owner="Tiling.place", error=GeometryError)
        if listed[:, 0].min() < 0 or listed[:, 0].max() >= len(self.points):
            raise GeometryError(f"Tiling.place: corners must name vertices below {len(self.points)}")
        found: Array = self.points[listed[:, 0]]
        if self.lattice is not None:
            found = found + listed[:, 1:] @ self.lattice
        return found

    # ---- topology

    @cached_property
    def _meetings(self) -> dict[int, list[tuple[Corner, Corner]]]:
        """For each vertex shared by panels: their (next, previous) corners seen from it, counter-clockwise."""
        meetings: dict[int, list[tuple[Corner, Corner]]] = {}
        for panel in self.panels:
            for at, (vertex, n1, n2) in enumerate(panel):
                (v, a, b), (w, c, d) = panel[(at + 1) % len(panel)], panel[at - 1]
                meetings.setdefault(vertex, []).append(((v, a - n1, b - n2), (w, c - n1, d - n2)))
        for vertex, arms in meetings.items():
            turn = {pair: self._directions(vertex, pair) for pair in arms}
            arms.sort(key=lambda pair: turn[pair][0] + 0.5 * ((turn[pair][1] - turn[pair][0]) % TURN))
        return {vertex: arms for vertex, arms in sorted(meetings.items()) if len(arms) > 1}

    def _directions(self, vertex: int, corners: Sequence[Corner]) -> tuple[float, ...]:
        arms = self.place(corners) - self.points[vertex]
        return tuple(np.arctan2(arms[:, 1], arms[:, 0]).tolist())

    @property
    def joints(self) -> list[int]:
        """Vertices that two or more panels share."""
        return list(self._meetings)

    @cached_property
    def corners(self) -> list[Corner]:
        own: list[Corner] = [(vertex, 0, 0) for vertex in range(len(self.points))]
        moved = {corner for panel in self.panels for corner in panel}
        moved |= {corner for arms in self._meetings.values() for pair in arms for corner in pair}
        return own + sorted(moved - set(own))

    @cached_property
    def vertices(self) -> Array:
        return self.place(self.corners)

    @cached_property
    def images(self) -> NDArray[np.int64]:
        """Vertices that repeat one of the cell, rows (index in `vertices`, vertex of the cell, n1, n2)."""
        own = len(self.points)
        return np.array([(own + k, *corner) for k, corner in enumerate(self.corners[own:])], dtype=int).reshape(-1, 4)

    @cached_property
    def polygons(self) -> list[NDArray[np.int64]]:
        """Corners of each panel, counter-clockwise, as indices of `vertices`."""
        index = {corner: k for k, corner in enumerate(self.corners)}
        return [np.array([index[corner] for corner in panel]) for panel in self.panels]

    @cached_property
    def gaps(self) -> list[Gap]:
        """The openings between neighbouring panels at each joint; panels that share an edge have none there."""
        index = {corner: k for k, corner in enumerate(self.corners)}
        found = []
        for joint, (vertex, arms) in enumerate(self._meetings.items()):
            for at, (_, last) in enumerate(arms):
                following = arms[(at + 1) % len(arms)][0]
                if last == following:
                    continue
                start, end = self._directions(vertex, (last, following))
                angle = (end - start + CLOSED) % TURN - CLOSED
                found.append(Gap(index[following], vertex, index[last], angle, joint))
        return found

    @property
    def cell_area(self) -> float:
        """Area of the periodic cell [length^2]."""
        return abs(float(np.linalg.det(self._periodic())))

    def _periodic(self) -> Array:
        if self.lattice is None:
            raise GeometryError("Tiling: a periodic tiling is needed here, and this one has no lattice vectors")
        return self.lattice

    def patch(self, n1: int, n2: int, keep: Callable[[int, int, int], bool] | None = None) -> Tiling:
        """A finite piece of a periodic tiling.

        Parameters
        ----------
        n1, n2 : int
            Cells along the two lattice vectors.
        keep : callable, optional
            ``keep(a, b, panel)`` says whether panel number `panel` of cell (a, b) stays; it shapes the edges.

        Raises
        ------
        GeometryError
            The tiling is not periodic, or no panel is kept.

        Examples
        --------
        >>> import kirigami as kg
        >>> print(kg.tilings.rotating_triangles(angle=1.0).patch(3, 2, keep=lambda a, b, panel: panel == 0 or b == 0))
        Tiling of 9 panels with 8 joints
        """
        self._periodic()
        n1 = require_whole(n1, "n1", "Tiling.patch", 1, GeometryError)
        n2 = require_whole(n2, "n2", "Tiling.patch", 1, GeometryError)
        if n1 * n2 * len(self.panels) > MOST_PANELS:
            raise GeometryError(f"Tiling.patch: {shown(n1)} by {shown(n2)} cells are more than {MOST_PANELS} panels")
        if keep is not None:
            require_callable(keep, "keep", "Tiling.patch", GeometryError)
        kept = [
            tuple((vertex, a + i, b + j) for vertex, i, j in panel)
            for b in range(n2)
            for a in range(n1)
            for number, panel in enumerate(self.panels)
            if keep is None or keep(a, b, number)
        ]
        if not kept:
            raise GeometryError(f"Tiling.patch({n1}, {n2}): no panel is kept")
        index: dict[Corner, int] = {}
        panels = [[index.setdefault(corner, len(index)) for corner in panel] for panel in kept]
        return Tiling(self.place(list(index)), panels)

    # ---- models

    def bars(self, bracing: str = "crossed") -> list[tuple[int, int]]:
        """Bars that make every panel rigid, as pairs of vertices.

        Parameters
        ----------
        bracing : {"crossed", "single"}
            "crossed": edges and all diagonals that skip one corner, symmetric under every symmetry of the panel;
            "single": a fan of triangles, 2 n - 3 bars for n corners, which is just rigid.
        """
        require_choice(bracing, ("crossed", "single"), "bracing", "Tiling.bars")
        found: dict[tuple[int, int], None] = {}
        for polygon in self.polygons:
            for i, j in braces(self.vertices[polygon], bracing == "crossed"):
                a, b = sorted((int(polygon[i]), int(polygon[j])))
                found[a, b] = None
        return list(found)

    def model(
        self,
        EA: float,
        stiffness: ArrayLike | Ligament,
        *,
        springs: str = "one",
        bracing: str = "crossed",
        closing_moment: float = 0.0,
        strain: str = "green",
        name: str = "",
    ) -> Model:
        """A planar model: panels from bars, joints from angle springs.

        Parameters
        ----------
        EA : float
            Axial stiffness of every bar [force]. Panels count as rigid where EA L is far above the joint stiffness.
        stiffness : float, Ligament or array_like, shape (joints,)
            Angle stiffness of all joints, or of each in the order of `joints` [force length / rad].
        springs : {"one", "both"}
            A joint of two panels has one spring in its wider gap, or springs of half the stiffness in both gaps; with
            rigid panels the two are the same. Joints of more panels have one full spring in every gap.
        bracing : {"crossed", "single"}
            See :meth:`bars`.
        closing_moment : float
            Moment with which every two-panel joint pushes its wider gap open, the narrower one shut, in the state
            as drawn [force length]; zero is stress-free.
        strain : {"green", "engineering"}
            Strain measure of the bars.
        name : str
            Name of the model.

        Returns
        -------
        Model
            ``model.nodes[k]`` stands at ``vertices[k]``. Images of a periodic tiling are nodes of their own, to be tied
            with :class:`kirigami.lattice.periodic.PeriodicCell`.

        Raises
        ------
        ModelError
            Stiffness not positive and finite, or an unknown option.
        """
        from kirigami.elements.bar import Bar
        from kirigami.elements.torsion_spring import TorsionSpring3
        from kirigami.model.model import Model
        from kirigami.primitives.node import Node

        require_choice(springs, ("one", "both"), "springs", "Tiling.model")
        given = stiffness.stiffness if isinstance(stiffness, Ligament) else stiffness
        given = require_array(given, (), (len(self.joints),), name="stiffness", owner="Tiling.model")
        by_joint_stiffness = np.broadcast_to(given, len(self.joints)).tolist()
        closing_moment = require_finite(closing_moment, "closing_moment", "Tiling.model")
        model = Model(dim=2, name=name)
        nodes = [Node(x, y) for x, y in self.vertices.tolist()]
        model.add(*nodes)
        model.add(*(Bar(nodes[i], nodes[j], EA, strain=strain) for i, j in self.bars(bracing)))
        by_joint: dict[int, list[Gap]] = {}
        for gap in self.gaps:
            by_joint.setdefault(gap.joint, []).append(gap)
        for joint, gaps in by_joint.items():
            moment_per_turn = require_positive(by_joint_stiffness[joint], f"stiffness of joint {joint}", "Tiling.model")
            pair = len(self._meetings[gaps[0].pivot]) == 2
            gaps = sorted(gaps, key=lambda gap: -round(gap.angle, 9))
            share = 2 if pair and springs == "both" and len(gaps) == 2 else 1
            for rank, gap in enumerate(gaps[:share] if pair else gaps):
                push = closing_moment / moment_per_turn * (1 - 2 * rank) if pair else 0.0
                model.add(TorsionSpring3(
                    nodes[gap.left], nodes[gap.pivot], nodes[gap.right], moment_per_turn / share,
                    rest_angle=gap.angle + push if push else None,
                ))  # fmt: skip
        return model

    def angle_limits(
        self, model: Model, stiffness: float, minimum: float = 0.0, width: float = 0.02
    ) -> list[AngleLimit]:
        """Contact between panels: no gap may close below an angle. Add the objects to the model to switch it on.

        Parameters
        ----------
        model : Model
            The model made by :meth:`model`.
        stiffness : float
            Moment per angle beyond the limit [force length / rad].
        minimum : float
            Smallest gap angle [rad].
        width : float
            Angle over which the contact stiffens [rad].

        Raises
        ------
        ModelError
            A gap is below the limit already, or an argument is out of range.

        Examples
        --------
        >>> import kirigami as kg
        >>> squares = kg.tilings.rotating_squares(angle=0.3).patch(1, 1)
        >>> m = squares.model(EA=1.0, stiffness=1e-4)
        >>> limits = m.add(*squares.angle_limits(m, stiffness=0.1))
        >>> print(m)
        Model in 2D: 12 nodes, 24 Bar, 4 TorsionSpring3, 8 AngleLimit
        """
        from kirigami.effects.angle_limit import AngleLimit
        from kirigami.model.model import Model

        require_instance(model, Model, "model", "angle_limits")
        minimum = require_finite(minimum, "minimum", "angle_limits")
        stiffness = require_positive(stiffness, "stiffness", "angle_limits")
        width = require_positive(width, "width", "angle_limits")
        for gap in self.gaps:
            if gap.angle < minimum - CLOSED:
                raise ModelError(
                    f"angle_limits: the gap at joint {gap.pivot} {place_of(self.vertices[gap.pivot])} is "
                    f"{gap.angle:.6g} rad, already below the limit {minimum:.6g}: open the tiling further or lower it"
                )
        at = model.nodes
        return [
            AngleLimit(at[gap.left], at[gap.pivot], at[gap.right], stiffness, minimum=minimum, width=width)
            for gap in self.gaps
        ]

    def __str__(self) -> str:
        kind = "" if self.lattice is None else "Periodic "
        joints = len(self.joints)
        text = f"{kind}tiling of {counted(len(self.panels), 'panel')} with {counted(joints, 'joint')}"
        return text[0].upper() + text[1:]

    def __repr__(self) -> str:
        return f"<{self}>"


def place_of(point: ArrayLike) -> str:
    x, y = np.asarray(point, dtype=float)[:2]
    return f"({x:.6g}, {y:.6g})"
