"""First-order changes of the measures of shell facets along a field, and their contracted second derivatives.

The same formulas as in :mod:`kirigami.elements.shell_bending`, taken along one direction instead of all: with t along
an edge, g inward and dual vectors g^A, everything is made of

    dn = -sum (n.dg_A) g^A,    dg^A = -sum (g^A.dg_B) g^B + n sum (g^A.g^B) (n.dg_B).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kirigami.elements.shell_bending import AreaFrames, EdgeFrames, area_frames, edge_frames
from kirigami.elements.shell_geometry import (
    AREA_ROWS,
    EDGE_OF_POINT,
    EDGE_ROWS,
    combine,
    corner_fields,
    cross,
    dot,
    facet_vectors,
)
from kirigami.primitives.kernel import Array

if TYPE_CHECKING:
    from kirigami.elements.shell_kernel import ShellFacetKernel

AT_ONCE = 1024  # facets at a time, so that they stay in the processor's cache
ALONG, INWARD = EDGE_ROWS


class Turned(NamedTuple):
    """Directors as seen across the edges: up (6, n), aside, along; q.q; q' (6, 3, n) over q.q and times the lean."""

    up: Array
    side: Array
    lean: Array
    square: Array
    slide: Array


class Frames:
    """Frames of facets with vectors v (5, 3, n), seen from directors (6, 3, n)."""

    def __init__(self, vectors: Array, directors: Array) -> None:
        self.vectors, self.directors = vectors, directors
        self.area: AreaFrames = area_frames(vectors)
        self.edges: EdgeFrames = edge_frames(vectors)
        edges = self.edges
        up, side, lean = (dot(directors, axis) for axis in (edges.normal, edges.inward, edges.tangent))
        square = up**2 + side**2
        turned = up[:, None] * edges.inward - side[:, None] * edges.normal
        self.turned = Turned(up, side, lean, square, (lean / (square * edges.length))[:, None] * turned)
        self.angle = np.arctan2(-side, up)
        # dual vectors at the Gauss points of the edges
        self.across = edges.inward / edges.reach[:, None]
        self.along = edges.tangent / edges.length[:, None] - edges.slant[:, None] * self.across

    # ---- contracted first derivatives (5, 3, n)

    def by_heights(self, share: Array) -> Array:
        """Of the sum with `share` (3, 3, n) of the parts of the middles along the normals inside."""
        normal, dual = self.area
        load = np.einsum("qen,ean->qan", share, self.vectors[2:])
        found = np.zeros_like(self.vectors)
        for rows, vector in zip(AREA_ROWS, dual):
            found -= spread(rows, dot(vector, load)[:, None] * normal)
        found[2:] += np.einsum("qen,qan->ean", share, normal)
        return found

    def by_angles(self, force: Array) -> Array:
        """Of the sum with `force` (6, n) of the angles."""
        edges = self.edges
        lever = (force / edges.reach)[:, None] * edges.normal
        slide = edges.slant[:, None] * lever + force[:, None] * self.turned.slide
        return spread(ALONG, slide) - spread(INWARD, lever)


class Motion:
    """What a field `move` (5, 3, n) of the vectors changes in frames, to first order."""

    def __init__(self, frames: Frames, move: Array) -> None:
        self.frames, self.move = frames, move
        normal, dual = frames.area
        self.inside = [combine(rows, move) for rows in AREA_ROWS]
        self._tilt = [dot(normal, change)[:, None] for change in self.inside]
        self.normal = -(self._tilt[0] * dual[0] + self._tilt[1] * dual[1])
        self.t, self.g = combine(ALONG, move), combine(INWARD, move)

    def heights(self) -> Array:
        """Rates (3, 3, n) of the parts of the middles along the normals inside."""
        found = np.einsum("qan,ean->qen", self.frames.area.normal, self.move[2:])
        return np.asarray(found + np.einsum("qan,ean->qen", self.normal, self.frames.vectors[2:]))

    def angles(self) -> Array:
        """Rates (6, n) of the angles."""
        edges = self.frames.edges
        return np.asarray(
            dot(self.frames.turned.slide, self.t)
            - dot(edges.normal, self.g - edges.slant[:, None] * self.t) / edges.reach
        )

    def of_heights(self, share: Array) -> Array:
        """Change (5, 3, n) of :meth:`Frames.by_heights`."""
        (normal, dual), vectors = self.frames.area, self.frames.vectors
        load = np.einsum("qen,ean->qan", share, vectors[2:])
        loading = np.einsum("qen,ean->qan", share, self.move[2:])
        at = [dot(dual[k], load) for k in range(2)]
        height = dot(normal, load)
        found = np.zeros_like(vectors)
        for k in range(2):
            rate = dot(dual[k], loading)
            for other in range(2):
                rate -= dot(dual[k], self.inside[other]) * at[other]
                rate += dot(dual[k], dual[other]) * self._tilt[other][:, 0] * height
            found -= spread(AREA_ROWS[k], rate[:, None] * normal + at[k][:, None] * self.normal)
        found[2:] += np.einsum("qen,qan->ean", share, self.normal)
        return found

    def of_angles(self, force: Array) -> Array:
        """Change (5, 3, n) of :meth:`Frames.by_angles`."""
        frames, edges, seen = self.frames, self.frames.edges, self.frames.turned
        normal, inward, tangent, length, reach, slant = edges
        directors = frames.directors
        stretch = dot(tangent, self.t)
        d_tangent = (self.t - stretch[:, None] * tangent) / length[:, None]
        d_normal = -(dot(normal, self.t)[:, None] * frames.along + dot(normal, self.g)[:, None] * frames.across)
        d_inward = cross(d_normal, tangent) + cross(normal, d_tangent)
        g = (slant * length)[:, None] * tangent + reach[:, None] * inward
        d_reach = dot(self.g, inward) + dot(g, d_inward)
        d_slant = (dot(self.g, tangent) + dot(g, d_tangent) - slant * stretch) / length
        share = (force / reach)[:, None]
        lever = share * normal
        d_lever = share * (d_normal - (d_reach / reach)[:, None] * normal)
        d_up, d_side, d_lean = (dot(directors, change) for change in (d_normal, d_inward, d_tangent))
        turned = seen.up[:, None] * inward - seen.side[:, None] * normal
        d_turned = (
            d_up[:, None] * inward + seen.up[:, None] * d_inward
            - d_side[:, None] * normal - seen.side[:, None] * d_normal
        )  # fmt: skip
        scale = 1 / (seen.square * length)
        relative = 2 * (seen.up * d_up + seen.side * d_side) / seen.square + stretch / length
        d_slide = ((d_lean - seen.lean * relative) * scale)[:, None] * turned + (seen.lean * scale)[:, None] * d_turned
        d_along = d_slant[:, None] * lever + slant[:, None] * d_lever + force[:, None] * d_slide
        return spread(ALONG, d_along) - spread(INWARD, d_lever)


class Look:
    """A `part` of the facets of a kernel at positions x, to be asked for rates along one field after the other."""

    def __init__(self, kernel: ShellFacetKernel, x: Array, now: Array, change: Array, part: slice) -> None:
        self.kernel, self.part, self.change = kernel, part, change[..., part]
        self.frames = Frames(now[..., part], kernel._local_directors()[..., part])
        self.conn = kernel.conn[part]
        self.rows = self.conn[:, 6:].T[EDGE_OF_POINT], kernel._stored[:, part]
        self.scale = kernel._angle_scale[:, part]
        self.per_square, self.forms = kernel._membrane.per_square[:, part], kernel._membrane.mean_forms[..., part]
        self.second = kernel._bending.second[..., part]
        self.to_strain, self.to_curvature = kernel._membrane.to_strain[part], kernel._bending.to_curvature[part]

    def rates(self, field: Array) -> Rates:
        """Rates of the measures, and of strain and curvature at the corners, along a field (rows, 3)."""
        n = len(self.conn)
        motion = Motion(self.frames, facet_vectors(field, self.conn))
        turn = field[self.rows] * self.scale
        moving = np.einsum("pan,qan->pqn", self.frames.vectors, motion.move)
        stretch = np.empty((9, n))
        edges = self.frames.edges
        stretch[:6] = self.per_square * edges.length * dot(edges.tangent, motion.t)
        stretch[6:] = (self.forms * moving).sum(axis=(1, 2))
        heights = motion.heights()
        bend = np.empty((15, n))
        bend[:9] = np.einsum("ecn,qen->qcn", self.second, heights).reshape(9, n)
        bend[9:] = motion.angles() - turn
        fields = np.empty((n, 3, 6))
        fields[..., :3] = corner_fields(self.to_strain, stretch)
        fields[..., 3:] = corner_fields(self.to_curvature, bend)
        return Rates(motion, turn, moving, heights, stretch, bend, fields)


class Rates(NamedTuple):
    """Along a field: frames, stored angles (6, n), products with the vectors (5, 5, n), heights inside (3, 3, n),
    membrane measures (9, n), bending measures (15, n), strain and curvature at the corners (n, 3, 6)."""

    motion: Motion
    turn: Array
    moving: Array
    heights: Array
    stretch: Array
    bend: Array
    fields: Array


@dataclass
class Seen:
    """What is known of the facets at positions `x`, counted from `directors`; strain and curvature once asked for."""

    x: Array
    directors: Array
    looks: list[Look]
    fields: Array | None = None

    def holds(self, x: Array, directors: Array) -> bool:
        """Whether nothing moved since."""
        return self.directors is directors and np.array_equal(self.x, x)


def looks(kernel: ShellFacetKernel, x: Array) -> list[Look]:
    """All facets at positions x, part by part."""
    now, change = kernel._vectors(x)
    parts = [slice(start, start + AT_ONCE) for start in range(0, len(kernel.conn), AT_ONCE)]
    return [Look(kernel, x, now, change, part) for part in parts]


def spread(table: Array, values: Array) -> Array:
    """Sums (5, 3, n) of values (k, 3, n) with the columns of a table (k, 5)."""
    return np.asarray((table.T @ values.reshape(len(values), -1)).reshape(5, *values.shape[1:]))
