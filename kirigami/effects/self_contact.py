"""A sheet that touches itself: its facets are held apart by a barrier, and no step may lead one through another.

With d the distance of a node from a facet, or of two edges, all by the flat triangles of the corners, the potential is

    sum  w k s^2 b(d),     b -> infinity where d -> t - s,     b = 0 from d = t on,

a logarithmic barrier in a layer s below the thickness t of the sheet, twice differentiable, w the area that stands for
the pair and k a pressure (Li et al., Incremental Potential Contact, ACM Trans. Graph. 39 (2020) 49). Middle surfaces
thus touch at a distance between t - s and t. Pairs, distances, the barrier and its derivatives, and the share of a step
after which two parts would meet (continuous collision detection) are those of the library `ipctk`.

Lips of a slit coincide at rest, where no barrier is finite. The surface that is held apart is therefore drawn in at
them, by a little more than t / 2 on each side: its nodes are fixed mixtures of those of the facets about them, so that
lips that come back are held when they meet where they were cut. Pairs that are closer than t at rest nevertheless are
neighbours along the sheet, or at the tip of a slit. Each of them is left out until it has once been further apart than
t in an equilibrium; from then on it is in contact when it meets again.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.effects.held_surface import HeldSurface
from kirigami.effects.lips import check_gaps, close_pairs, drawn_in
from kirigami.errors import ModelError
from kirigami.post.crossing import crossings, toolkit
from kirigami.primitives.checks import require_instance, require_items, require_not_negative, require_positive
from kirigami.primitives.kernel import EXACT, Array, Contribution, Kernel, Tangent
from kirigami.primitives.node import Node
from kirigami.primitives.parts import ModelObject, Numbering
from kirigami.words import counted

LAYER = 0.25  # layer over the thickness
OF_EDGES = 0.25  # largest layer over the median edge
SOFTER = 1e-4  # pressure of the barrier over the stiffness of a node at rest by the thickness, about E
ITERATIONS = 2000  # most of one continuous detection; then a shorter step is as good an answer
REACH = 0.15  # how far a node may move before pairs are searched for again, over the thickness
KERF = 1.05  # distance of the lips of a slit at rest on the surface that is held, over the thickness
OWNER = "SelfContact"


class SelfContact(ModelObject):
    """Contact of a sheet with itself, and with fixed obstacles: a barrier, and steps that never lead through.

    Parameters
    ----------
    thickness : float, optional
        Distance of the middle surfaces at which they begin to touch [length]; None takes the thickness of the sheet,
        the largest one where it varies.
    layer : float, optional
        Depth over which the force sets in, below the thickness [length]; None takes a quarter of the thickness, at most
        a quarter of the median edge.
    stiffness : float, optional
        Pressure of the barrier [force / length^2], about a third of that in the middle of the layer; None takes a
        ten-thousandth of the stiffest node over the thickness.
    friction : float
        Coefficient of friction (Coulomb) where parts touch: they are held back by at most this times the force that
        presses them, and slip by up to the layer before they slide. The force that presses is that of the last
        equilibrium.
    obstacles : sequence of TriMesh
        Surfaces that do not move and are touched at the same distance.

    Raises
    ------
    AnalysisError
        When a system is made: `ipctk` is not installed (``pip install 'kirigami-mechanics[contact]'``).
    ModelError
        A value out of range; when a system is made: a model without a mesh or with dim=2, a rest state that crosses
        itself, a thickness larger than a gap at rest.

    Examples
    --------
    To be added to the model of a sheet; parts of it, or it and an obstacle, keep 2 mm apart:

    >>> import kirigami as kg
    >>> contact = kg.SelfContact(thickness=0.002)
    >>> contact
    SelfContact(thickness=0.002)
    """

    kind: ClassVar[str] = "effect"
    thickness: float | None
    layer: float | None
    stiffness: float | None
    friction: float
    obstacles: tuple[Any, ...]

    def __init__(
        self,
        thickness: float | None = None,
        layer: float | None = None,
        *,
        stiffness: float | None = None,
        friction: float = 0.0,
        obstacles: Sequence[Any] = (),
    ) -> None:
        from kirigami.geometry.mesh import TriMesh

        self.thickness = None if thickness is None else require_positive(thickness, "thickness", OWNER)
        self.layer = None if layer is None else require_positive(layer, "layer", OWNER)
        self.stiffness = None if stiffness is None else require_positive(stiffness, "stiffness", OWNER)
        self.friction = require_not_negative(friction, "friction", OWNER)
        listed = [obstacles] if isinstance(obstacles, TriMesh) else require_items(obstacles, "obstacles", OWNER)
        self.obstacles = tuple(require_instance(one, TriMesh, "obstacles", OWNER) for one in listed)
        if self.thickness is not None and self.layer is not None and self.layer > self.thickness:
            raise ModelError(f"{OWNER}: layer must be at most the thickness {thickness}, got {layer}")

    @property
    def nodes(self) -> tuple[Node, ...]:
        return ()

    @classmethod
    def lower(cls, objects: Sequence[SelfContact], numbering: Numbering) -> list[Kernel]:
        item, mesh = objects[0], numbering.mesh
        if len(objects) > 1:
            raise ModelError(f"{OWNER}: the model has {len(objects)} of them: add one, with all obstacles")
        if mesh is None or numbering.dim < 3:
            raise ModelError(f"{OWNER} is of a sheet in space: make the model by Model.from_mesh(mesh) with dim=3")
        thickness = item.thickness
        if thickness is None:
            if numbering.sheet is None:
                raise ModelError(f"{OWNER}: the model has no thickness to take: give thickness=")
            thickness = float(np.max(numbering.sheet.thickness))
        layer = item.layer
        if layer is None:
            layer = min(LAYER * thickness, OF_EDGES * float(np.median(mesh.edge_lengths)))
        if layer > thickness:
            raise ModelError(f"{OWNER}: layer must be at most the thickness {thickness:.6g}, got {layer:.6g}")
        nodes = np.arange(len(mesh.nodes))
        stiffness = item.stiffness
        if stiffness is None:
            stiffness = SOFTER * float(np.median(numbering.rest_stiffness()[nodes])) / thickness
        edges, triangles, fixed = [mesh.edges], [mesh.triangles], np.empty((0, 3))
        for obstacle in item.obstacles:
            before = len(nodes) + len(fixed)
            edges.append(obstacle.edges + before)
            triangles.append(obstacle.triangles + before)
            fixed = np.concatenate([fixed, in_space(obstacle.nodes)])
        drawn = in_space(mesh.nodes)
        inset = drawn_in(drawn, mesh.triangles, KERF * thickness).tocoo()
        kernel = SelfContactKernel(
            numbering.rest, nodes[:, None], np.concatenate(edges), np.concatenate(triangles), fixed,
            thickness, layer, stiffness, np.column_stack([inset.row, inset.col]), inset.data,
        )  # fmt: skip
        kernel.check_rest(np.concatenate([drawn, fixed]))
        if not item.friction:
            return [kernel]
        from kirigami.effects.self_friction import SelfFrictionKernel  # what does not rub needs none

        shared = {name: getattr(kernel, name) for name in ("conn", "fixed", "mixed", "shares")}
        rubs = SelfFrictionKernel(numbering.rest, **shared, friction=item.friction, width=layer, contact=kernel)
        return [kernel, rubs]

    def __repr__(self) -> str:
        given = [f"{name}={value}" for name, value in vars(self).items() if name != "obstacles" and value]
        given += [counted(len(self.obstacles), "obstacle")] * bool(self.obstacles)
        return f"SelfContact({', '.join(given)})"


def in_space(nodes: Array) -> Array:
    """Positions (n, 3) of nodes (n, 2) or (n, 3)."""
    return np.column_stack([nodes, np.zeros((len(nodes), 3 - nodes.shape[1]))])


class SelfContactKernel(Kernel):
    """The contact of one sheet; a member is a node, and what it bears is the sum over its pairs.

    Parameters
    ----------
    rest : ndarray, shape (rows, 3)
        Rest positions.
    conn : ndarray of int, shape (n, 1)
        Nodes of the sheet.
    edges, triangles : ndarray of int, shapes (e, 2) and (m, 3)
        Of the sheet and behind them of the obstacles, whose nodes are counted from n on.
    fixed : ndarray, shape (f, 3)
        Nodes of the obstacles.
    thickness, layer, stiffness : float
        See :class:`SelfContact`.
    mixed, shares : ndarray, shapes (k, 2) and (k,)
        Nodes of the surface that is held, the nodes they are mixed of, and their shares.
    """

    name = "self-contact"
    pairs = ()
    stores_energy = True

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        edges: NDArray[np.int64],
        triangles: NDArray[np.int64],
        fixed: Array,
        thickness: float,
        layer: float,
        stiffness: float,
        mixed: NDArray[np.int64],
        shares: Array,
    ) -> None:
        ipctk = self._ipctk = toolkit(OWNER)
        self.rest, self.conn, self.edges, self.triangles, self.fixed = rest, conn, edges, triangles, fixed
        self.thickness, self.layer, self.stiffness = float(thickness), float(layer), float(stiffness)
        self.mixed, self.shares = mixed, shares
        self._held = HeldSurface(len(rest), conn[:, 0], fixed, mixed, shares)
        self.least = self.thickness - self.layer  # distance that is never reached
        self._surface = ipctk.CollisionMesh(
            self.held_at(rest), np.asfortranarray(edges, np.int32), np.asfortranarray(triangles, np.int32)
        )
        self._barrier = ipctk.BarrierPotential(self.layer, self.stiffness, True)
        self._detection = ipctk.AdditiveCCD(max_iterations=ITERATIONS)
        self._search = ipctk.LBVH()
        self._reach = REACH * self.thickness  # how far a node may move before pairs are searched for again
        self._lips = close_pairs(self._surface, self.held_at(rest), self.thickness, ipctk)
        self._apart = np.zeros(len(self._lips))
        self._facets: dict[tuple[int, ...], list[int]] = {}
        self._filter()

    def arrays(self) -> dict[str, Any]:
        names = ("conn", "edges", "triangles", "fixed", "thickness", "layer", "stiffness", "mixed", "shares")
        return {name: getattr(self, name) for name in names}

    def held_at(self, x: Array) -> Array:
        """Positions (n + f, 3) of the nodes of the surface that is held, and of obstacles."""
        return self._held.at(x)

    def held_surface(self, x: Array) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
        return self.held_at(x), self.edges, self.triangles

    # ---- pairs

    def _filter(self) -> None:
        """Leave out the pairs that were close at rest and have not been apart since."""
        together = (self._lips[number] for number in np.flatnonzero(self._apart == 0))
        left_out = {nodes: False for pair in together for nodes in pair.node_pairs()}
        self._surface.can_collide = self._ipctk.make_sparse_filter(left_out, True)
        self._around: Array | None = None
        self._at: Array | None = None

    def _candidates(self, places: Array) -> Any:
        """Pairs that may touch within reach of positions; searched for again once a node has moved too far."""
        if self._around is None or np.abs(places - self._around).max() > self._reach / np.sqrt(3.0):
            self._near = self._ipctk.Candidates()
            self._near.build(self._surface, places, 0.5 * self.thickness + self._reach, self._search)
            self._around = places
        return self._near

    def _touching(self, places: Array) -> Any:
        """Pairs within the layer."""
        if self._at is None or not np.array_equal(places, self._at):
            candidates = self._candidates(places)
            self._pairs = self._ipctk.NormalCollisions()
            self._pairs.use_area_weighting = True
            self._pairs.build(candidates, self._surface, places, self.layer, self.least)
            self._at = places
        return self._pairs

    # ---- the contract

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        n = len(self.conn)
        places = self.held_at(x)
        if not np.isfinite(places).all():
            return Contribution(np.full(n, np.nan), np.full((n, 1, 3), np.nan))
        pairs = self._touching(places)
        if not len(pairs):
            return Contribution(np.zeros(n), np.zeros((n, 1, 3)))
        energy = np.full(n, self._barrier(pairs, self._surface, places) / n)
        if need == 0:
            return Contribution(energy)
        gradient = self._barrier.gradient(pairs, self._surface, places).reshape(-1, 3)
        return Contribution(energy, self._held.back(gradient)[:, None])

    def coupling(self, x: Array, tangent: Tangent = EXACT) -> Any:
        places = self.held_at(x)
        pairs = self._touching(places) if np.isfinite(places).all() else ()
        if not len(pairs):
            return None
        project = self._ipctk.PSDProjectionMethod
        share = tangent.convexity
        hessian = None
        for part, method in ((1 - share, project.NONE), (share, project.CLAMP)):
            if part:
                one = part * self._barrier.hessian(pairs, self._surface, places, method)
                hessian = one if hessian is None else hessian + one
        return None if hessian is None else self._held.coupling(hessian)

    def admissible(self, x: Array, y: Array) -> float:
        start, end = self.held_at(x), self.held_at(y)
        if not np.isfinite(end).all():
            return 1.0  # which is told elsewhere
        reach = self._reach / np.sqrt(3.0)
        known = self._around is not None and max(np.abs(p - self._around).max() for p in (start, end)) <= reach
        candidates = self._near if known else self._ipctk.Candidates()
        if not known:
            candidates.build(self._surface, start, end, 0.5 * self.least, self._search)
        if not len(candidates):
            return 1.0
        share = candidates.compute_collision_free_stepsize(self._surface, start, end, self.least, self._detection)
        return float(min(share, 1.0))

    def check_rest(self, drawn: Array) -> None:
        """Raise a ModelError where the rest state crosses itself or has a gap less than the thickness; lips of a slit
        coincide where the nodes (n + f, 3) are `drawn`."""
        places = self.held_at(self.rest)
        self._check_crossings(places)
        check_gaps(self._lips, places, drawn, self.edges, len(self.conn), self.thickness, OWNER)
        self.check_start(self.rest)

    def _check_crossings(self, places: Array) -> None:
        found = crossings(places, self.edges, self.triangles)
        if len(found):
            where = ", ".join("(" + ", ".join(f"{value:.4g}" for value in place) + ")" for place in found[:3])
            raise ModelError(
                f"{OWNER}: the sheet crosses itself or an obstacle where it starts, at {counted(len(found), 'place')}: "
                f"{where}; a barrier cannot undo that: start from a state, or draw a sheet, that is free of crossings"
            )

    def check_start(self, x: Array) -> None:
        places = self.held_at(x)
        self._check_crossings(places)
        pairs = self._ipctk.NormalCollisions()
        pairs.build(self._surface, places, self.layer, self.least, self._search)
        if not len(pairs):
            return
        gap = float(np.sqrt(pairs.compute_minimum_distance(self._surface, places)))
        if gap <= self.least * (1 + 1e-9):
            raise ModelError(
                f"{OWNER}: two parts of the sheet are {gap:.4g} apart where it starts, which leaves no room for the "
                f"thickness {self.thickness:.4g} less the layer {self.layer:.4g}: give a smaller thickness="
            )

    def pressed(self, places: Array) -> Array:
        """Pairs that press each other at positions of the surface, as :class:`SelfFrictionKernel` keeps them, with the
        normal force as their limit."""
        from kirigami.effects.self_friction import COLUMNS, LIMIT, NODES, PLACES, SHARES, SPLIT, SPLITS

        found = self._ipctk.TangentialCollisions()
        touching = self._touching(places)
        if len(touching):
            found.build(self._surface, places, touching, self._barrier, 1.0)
        edges, faces = self._surface.edges, self._surface.faces
        rows = np.zeros((len(found), COLUMNS))
        number = 0
        for group, split in SPLITS.items():
            for pair in getattr(found, group):
                shares = np.ravel(pair.compute_coefficients(places, edges, faces))
                nodes = [node for node in pair.vertex_ids(edges, faces) if node >= 0]
                if len(nodes) < 4:
                    nodes += self._rest_of_facet(nodes[1:])
                row = rows[number]
                row[NODES] = nodes
                row[SHARES][: len(shares)] = shares
                row[PLACES] = places[nodes].ravel()
                row[SPLIT], row[LIMIT] = split, pair.normal_force_magnitude * pair.weight
                number += 1
        return rows[rows[:, LIMIT] > 0]

    def _rest_of_facet(self, nodes: list[int]) -> list[int]:
        """The other corners of a facet at one or two of its nodes; a node that is of no facet, again."""
        if not self._facets:
            for facet in self.triangles.tolist():
                for k in range(3):
                    rest = facet[k + 1 :] + facet[:k]
                    self._facets.setdefault((facet[k],), rest)
                    self._facets.setdefault(tuple(sorted(rest)), [facet[k]])
        return self._facets.get(tuple(sorted(nodes)), (3 - len(nodes)) * nodes[:1])

    # ---- which lips have been apart

    def commit(self, x: Array) -> None:
        together = np.flatnonzero(self._apart == 0)
        if not len(together):
            return
        places = self.held_at(x)
        moved = [number for number in together if self._lips[number].distance(places) > self.thickness]
        if moved:
            self._apart = self._apart.copy()
            self._apart[moved] = 1.0
            self._filter()

    @property
    def history(self) -> Array | None:
        """1 for each pair close at rest that has been apart since, else 0."""
        return self._apart

    @history.setter
    def history(self, value: Array | None) -> None:
        new = np.zeros(len(self._lips)) if value is None else np.array(value, dtype=float)
        if not np.array_equal(new, self._apart):
            self._apart = new
            self._filter()

    # ---- what it tells

    def deformation(self, x: Array) -> Array:
        """Force (n, 3) by which the sheet's own other parts, and obstacles, press on each node."""
        gradient = self.evaluate(x, 1.0, 1).gradient
        assert gradient is not None
        return -gradient[:, 0]

    def force(self, deformation: Array) -> Array:
        """The same."""
        return deformation
