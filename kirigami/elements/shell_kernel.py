"""The kernel of shell facets: energy, forces and tangent; the formulas are in :mod:`kirigami.elements.shell_facet`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.shell_bending import (
    Bending,
    angles,
    area_frames,
    edge_frames,
)
from kirigami.elements.shell_derivatives import Answer, piece_by_piece, pulled_back
from kirigami.elements.shell_geometry import (
    EDGE_OF_POINT,
    Chart,
    corner_fields,
    facet_vectors,
    integrated,
)
from kirigami.elements.shell_membrane import Membrane
from kirigami.elements.shell_rates import Look, Seen, looks
from kirigami.elements.shell_rest import across, angle_scale, initial_directors, repeated
from kirigami.elements.surface import SurfaceKernel
from kirigami.primitives.kernel import EXACT, Array, CompiledKernel, Contribution, Kernel, Tangent, displacement_of
from kirigami.primitives.material import strain_turn

# Integrals over the facet, by its area, of products of the l_i and of 4 l_a l_b.
CONSISTENT = np.zeros((9, 9))
CONSISTENT[:3, :3] = (1 + np.eye(3)) / 12
CONSISTENT[3:6, 3:6] = (4 + 4 * np.eye(3)) / 45
CONSISTENT[:3, 3:6] = [[2 / 15, 1 / 15, 2 / 15], [2 / 15, 2 / 15, 1 / 15], [1 / 15, 2 / 15, 2 / 15]]
CONSISTENT[3:6, :3] = CONSISTENT[:3, 3:6].T
LUMPED = np.diag([1 / 3] * 3 + [0.0] * 6)

# Where the members are in what the kernel keeps of each.
AXES = {
    **dict.fromkeys(("conn", "section", "forward", "members", "planes", "density"), 0),
    **dict.fromkeys(("_natural", "_heat", "_angle_scale", "_stored", "_edge", "_rest_angles", "_rest_curvatures"), 1),
    "_rest_vectors": 2,
}


class ShellFacetKernel(SurfaceKernel):
    """All shell facets; see the module's text for the formulas.

    Local rows: three corners, the middles and then the angles of the edges 01, 12, 20. `forward` (n, 3) tells where a
    facet runs along an edge in the direction in which the edge counts its angles; an angle row holds them at the two
    Gauss points, times the length of the edge.
    """

    name = "shell"
    uniform = False
    measures_displacement = True
    compile_from = 200  # a facet is as much work as many bars
    approximates = True
    plate_theory = True

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        section: Array,
        forward: NDArray[np.bool_],
        density: Array | None = None,
        members: NDArray[np.int64] | None = None,
        planes: Array | None = None,
        natural: Array | None = None,
        heat: Array | None = None,
        seams: NDArray[np.int64] | None = None,
    ) -> None:
        self.rest, self.conn, self.section, self.forward, self.members = rest, conn, section, forward, members
        self.planes = planes  # normals of mirror planes (n, 3, 3) that the edges lie in, zero where there are none
        self.seams = seams  # rows of angles (s, 2) on the border of a periodic cell that repeat others, and these
        self.density = density  # mass per area (n,), nan where unknown
        self._rest_vectors = facet_vectors(rest, conn)
        self.chart = Chart(self._rest_vectors)
        self._membrane = Membrane(self._rest_vectors, self.chart)
        self._bending = Bending(self.chart)
        self._angle_scale = angle_scale(self.chart, forward)  # (6, n): of the stored angles in the local ones
        point = np.tile([0, 1], 3)
        self._stored = np.where(forward[:, EDGE_OF_POINT].T, point[:, None], 1 - point[:, None])  # (6, n) of an edge's
        shared = conn[:, 6:] if seams is None else repeated(conn[:, 6:], seams)
        self._angle_rows, self._edge = np.unique(shared, return_inverse=True)
        self._edge = self._edge.reshape(-1, 3)[:, EDGE_OF_POINT].T  # (6, n)
        frames = edge_frames(self._rest_vectors)
        self._rest_directors = initial_directors(frames, self._edge, self._stored, len(self._angle_rows), planes)
        self._directors = self._rest_directors
        self._rest_angles = angles(frames, self._local_directors())
        self._rest_curvatures = self._bending.curvatures(self._rest_vectors, area_frames(self._rest_vectors))
        self.coupled = bool(np.any(section[:, :3, 3:]))
        self._natural = natural
        self._heat = heat
        self._seen: Seen | None = None
        self._scale()

    def arrays(self) -> dict[str, Any]:
        own = {name: getattr(self, name) for name in ("conn", "section", "forward", "density", "members", "planes")}
        own |= {name: getattr(self, name) for name in ("seams",) if self.seams is not None}
        return self.with_natural(own if self._heat is None else {**own, "heat": self._heat})

    def actuate(self, members: NDArray[np.int64], values: Array, constant: bool) -> None:
        super().actuate(members, self.grown(members, values), constant)

    def grown(self, members: NDArray[np.int64], values: Array) -> Array:
        """See the base; a curved sheet whose layers all are strained by e is similar to itself with the second form
        b + (e b + b e) / 2."""
        b11, b22, b12 = (self._rest_form[members] * [1.0, 1.0, 0.5]).T
        e11, e22, e12 = (values[:, :3] * [1.0, 1.0, 0.5]).T
        grown = np.stack([e11 * b11 + e12 * b12, e12 * b12 + e22 * b22, e12 * (b11 + b22) + b12 * (e11 + e22)], axis=1)
        values = values.copy()
        values[:, 3:] += grown
        return values

    def on_rest(self, rest: Array) -> ShellFacetKernel:
        """The axes of sections and of strains without stress lie along the first edges, which turn."""
        made = self.arrays()
        first, second = self.conn[:, 0], self.conn[:, 1]
        (x0, y0), (x1, y1) = ((at[second] - at[first])[:, :2].T for at in (self.rest, rest))
        turn = np.zeros((len(first), 6, 6))
        turn[:, :3, :3] = turn[:, 3:, 3:] = strain_turn(-np.arctan2(x0 * y1 - y0 * x1, x0 * x1 + y0 * y1))
        made["section"] = turn.transpose(0, 2, 1) @ made["section"] @ turn
        if made.get("natural") is not None:
            made["natural"] = np.einsum("nab,knb->kna", np.linalg.inv(turn), made["natural"])
        return type(self)(rest, **made)

    def rows_behind(self, inside: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Those of edges with both ends inside."""
        corner = inside[self.conn[:, :3]]
        both = corner & np.roll(corner, -1, axis=1)
        return np.unique(np.concatenate([self.conn[:, 3:6][both], self.conn[:, 6:][both]]))

    @property
    def _rest_form(self) -> Array:
        """Mean second form (n, 3) of facets at rest, (b11, b22, 2 b12)."""
        measures = np.concatenate([self._rest_curvatures, self._rest_angles])
        return np.asarray(corner_fields(self._bending.to_curvature, measures).mean(axis=1))

    def warm(self, facets: NDArray[np.int64], heat: Array, constant: bool) -> None:
        """Add to the heat (k, 2) at the lower and upper faces, part of what :meth:`actuate` is told."""
        if self._heat is None:
            self._heat = np.zeros((2, len(self.conn), 2))
        np.add.at(self._heat[0 if constant else 1], facets, heat)

    def heat(self, lam: float) -> Array | None:
        """Heat (n, 2) at the lower and upper faces at a load factor; None where there is none."""
        return None if self._heat is None else self._heat[0] + lam * self._heat[1]

    def natural_deformation(self, lam: float) -> Array | None:
        """Strain and curvature (n, 6), as :meth:`deformation` has them, at which facets bear nothing."""
        return self.natural(lam)

    def _elastic(self, fields: Array, lam: float) -> Array:
        """Strain and curvature (n, 3, 6) less those at which the facets bear nothing."""
        natural = self.natural(lam)
        return fields if natural is None else fields - natural[:, None]

    def by_load(self, x: Array, lam: float, need: int = 1) -> Contribution:
        assert self._natural is not None
        drive = np.repeat(-self._natural[1][:, None], 3, axis=1)
        fields = self._elastic(self._fields(x), lam)
        rate = (drive * self._answer(fields, 1).resultants).sum(axis=(1, 2))
        if need == 0:
            return Contribution(rate)
        return Contribution(rate, pulled_back(self, x, self._drive_resultants(drive, fields)))

    def _drive_resultants(self, drive: Array, fields: Array) -> Array:
        """Rate (n, 3, 6) of the resultants with elastic strain and curvature (n, 3, 6) that change by `drive`."""
        return self._resultants(drive)

    def stiffness_of_positions(self, stiffness: Array) -> Array:
        """Strain comes from displacements, curvature from positions."""
        return np.asarray(np.linalg.norm(self.section[:, 3:, 3:], axis=(1, 2)) / self.chart.area)

    def compiled(self) -> CompiledKernel | None:
        from kirigami.elements.compiled_shell import CompiledShell

        return CompiledShell(self)

    def part(self, members: NDArray[np.int64]) -> Kernel:
        if type(self) is not ShellFacetKernel:
            return self
        part: ShellFacetKernel = self._cut_out(members, AXES)
        part.chart = Chart(part._rest_vectors)
        part._membrane, part._bending = Membrane(part._rest_vectors, part.chart), Bending(part.chart)
        part._seen = None
        return part

    # ---- directors: a gauge, moved along with the edges at every commit

    @property
    def history(self) -> Array | None:
        """Directors (edges, 2, 3) against which the angles of the edges are counted."""
        return self._directors

    @history.setter
    def history(self, value: Array | None) -> None:
        self._directors = self._rest_directors if value is None else value

    def _local_directors(self) -> Array:
        """Directors (6, 3, n) at the Gauss points of each facet."""
        return np.asarray(self._directors[self._edge, self._stored].transpose(0, 2, 1))

    def _count_from(self, local: Array) -> None:
        """Take over directors (6, 3, n) at the Gauss points of each facet; they are the same from either side."""
        directors = self._directors.copy()
        directors[self._edge, self._stored] = local.transpose(0, 2, 1)
        self._directors = directors

    def commit(self, x: Array) -> None:
        local = across(self._local_directors(), edge_frames(self._vectors(x)[0]))
        self._count_from(local / np.linalg.norm(local, axis=1, keepdims=True))

    def rigidly_moved(self, x: Array, rotation: Array, shift: Array) -> Array:
        from kirigami.elements.shell_settle import rigidly_moved

        return rigidly_moved(self, x, rotation, shift)

    def settle(self, x: Array) -> None:
        from kirigami.elements.shell_settle import settle

        settle(self, x)

    # ---- measures

    def _vectors(self, x: Array) -> tuple[Array, Array]:
        """The vectors v (5, 3, n) and their change from rest."""
        change = facet_vectors(displacement_of(x, self.rest), self.conn)
        return self._rest_vectors + change, change

    def _edge_angles(self, x: Array) -> Array:
        """Angles alpha (6, n) of the edges in the local direction and order."""
        stored: Array = np.asarray(x)[self.conn[:, 6:].T[EDGE_OF_POINT], self._stored]
        return stored * self._angle_scale

    def _fields(self, x: Array) -> Array:
        """Strain and curvature (n, 3, 6) at the corners: (exx, eyy, gamma, kxx, kyy, 2 kxy)."""
        vectors, change = self._vectors(x)
        stretch = self._membrane.measures(change)
        jump = angles(edge_frames(vectors), self._local_directors()) - self._rest_angles - self._edge_angles(x)
        jump -= 2 * np.pi * np.round(jump / (2 * np.pi))
        bent = self._bending.curvatures(vectors, area_frames(vectors)) - self._rest_curvatures
        fields = np.empty((len(self.conn), 3, 6))
        fields[..., :3] = corner_fields(self._membrane.to_strain, stretch)
        fields[..., 3:] = corner_fields(self._bending.to_curvature, np.concatenate([bent, jump]))
        return fields

    def _resultants(self, fields: Array) -> Array:
        """Derivatives (n, 3, 6) of the energy by strain and curvature at the corners."""
        return integrated(fields @ self.section, self.chart.area)

    def borne_deformation(self, x: Array, lam: float) -> Array:
        """At the corners: the elastic part, of what yields; the deformation itself, where the law is linear."""
        fields = self._elastic(self._fields(x), lam)
        if self.linear_law:
            return fields
        felt = self._answer(fields, need=1).resultants  # the inverse of _resultants
        weighted = (felt - felt.sum(axis=1, keepdims=True) / 4) * (12 / self.chart.area)[:, None, None]
        return np.asarray(np.linalg.solve(self.section, weighted.transpose(0, 2, 1)).transpose(0, 2, 1))

    def deformation(self, x: Array) -> Array:
        """Mean strain and curvature of each facet (n, 6): (exx, eyy, gamma_xy, kxx, kyy, 2 kxy), the first axis along
        the edge from corner i to j."""
        return np.asarray(self._fields(x).mean(axis=1))

    def deformation_rate(self, x: Array, change: Array) -> Array:
        return np.asarray(self._rates(x, change).mean(axis=1))

    def _rates(self, x: Array, change: Array) -> Array:
        """First-order change of strain and curvature (n, 3, 6) at the corners for a change (rows, 3)."""
        field = np.asarray(change)
        return np.concatenate([look.rates(field).fields for look in self._looks(x)])

    def _looks(self, x: Array) -> list[Look]:
        """What rates at positions x need whatever the field: several are asked for at the same place."""
        return self._seen_at(x).looks

    def _felt(self, x: Array) -> Array:
        """As :meth:`_fields`, found once for all that is asked at the same place."""
        seen = self._seen_at(x)
        if seen.fields is None:
            seen.fields = self._fields(x)
        return seen.fields

    def _seen_at(self, x: Array) -> Seen:
        if self._seen is None or not self._seen.holds(x, self._directors):
            self._seen = Seen(np.array(x), self._directors, looks(self, x))
        return self._seen

    def sensitivity(self, x: Array, lam: float, v: Array, energy: float = 0.0) -> dict[str, Array]:
        """In closed form: by "section" (n, 6, 6), symmetric, and by the strain and curvature "natural" (n, 6), in the
        axes of :meth:`deformation`, at which the facets bear nothing."""
        felt, rates = self._elastic(self._felt(x), lam), self._rates(x, v)
        both = rates + 0.5 * energy * felt
        section = np.einsum("nia,nib->nab", both, integrated(felt, self.chart.area))
        natural = -self._resultants(rates + energy * felt).sum(axis=1)
        return {"section": 0.5 * (section + section.transpose(0, 2, 1)), "natural": natural}

    def by_rest(self, x: Array, lam: float, fields: Array, energies: Array) -> Array | None:
        """In closed form, see :mod:`kirigami.elements.shell_by_rest`."""
        if type(self) is not ShellFacetKernel or self._natural is not None:
            return None
        if self.planes is not None or self.seams is not None:  # whose edges bulge with what lies beyond
            return None
        from kirigami.elements.shell_by_rest import by_rest

        return by_rest(self, x, fields, energies)

    def corner_deformation(self, x: Array) -> Array:
        """Strain and curvature (n, 3, 6) at the corners of each facet, in the axes of :meth:`deformation`."""
        return self._fields(x)

    def force(self, deformation: Array) -> Array:
        """Forces and moments per length (n, 6): (Nxx, Nyy, Nxy, Mxx, Myy, Mxy) of a deformation (n, 6)."""
        return np.asarray(np.einsum("nab,nb->na", self.section, deformation))

    def force_at(self, deformation: Array, lam: float) -> Array:
        natural = self.natural(lam)
        return self.force(deformation if natural is None else deformation - natural)

    def mass(self, lumped: bool = False) -> Array | None:
        """Mass matrices (n, 9, 9) over the rows; lumped at the corners alone, a third each. Angles have none, as in
        every theory without rotary inertia. None where a density is unknown."""
        if self.density is None or not np.isfinite(self.density).all():
            return None
        shares = LUMPED if lumped else CONSISTENT
        return np.asarray((self.density * self.chart.area)[:, None, None] * shares)

    def curvature(self, x: Array) -> Array:
        """Curvature (n, 3, 3) at the corners of each facet: (kxx, kyy, 2 kxy)."""
        return self._fields(x)[..., 3:]

    # ---- energy and derivatives

    def _answer(self, fields: Array, need: int = 2) -> Answer:
        resultants = self._resultants(fields)
        return Answer(0.5 * (fields * resultants).sum(axis=(1, 2)), resultants, self.section[:, None])

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        answer = self._answer(self._elastic(self._fields(x), lam), need)
        if need == 0:
            return Contribution(answer.energy)
        n = len(answer.energy)
        gradient = np.empty((n, 9, 3))
        hessian = np.empty((n, 9, 9, 3, 3)) if need == 2 else None
        for part, forces, blocks in piece_by_piece(self, x, lam, need, answer, tangent):
            gradient[part] = forces
            if hessian is not None:
                hessian[part] = blocks
        return Contribution(answer.energy, gradient, hessian)

    def with_product(self, x: Array, lam: float, vectors: Array) -> tuple[Contribution, Array]:
        answer = self._answer(self._elastic(self._fields(x), lam))
        gradient, product = np.empty((2, len(answer.energy), 9, 3))
        for part, forces, blocks in piece_by_piece(self, x, lam, 2, answer):
            assert blocks is not None
            gradient[part], product[part] = forces, np.einsum("nklab,nlb->nka", blocks, vectors[part])
        return Contribution(answer.energy, gradient), product

    def stiffness_size(self, x: Array, lam: float) -> Array:
        answer = self._answer(self._elastic(self._fields(x), lam))
        size = np.empty(len(self.conn))
        for part, _, blocks in piece_by_piece(self, x, lam, 2, answer):
            assert blocks is not None
            size[part] = np.linalg.norm(blocks.reshape(len(blocks), -1), axis=1)
        return size
