"""The curved facet: a triangle of sheet whose edges bend with the normals at its corners.

Every corner has a normal d, a unit vector of its own, shared by the facets that meet there. Edge c, with vector
E_c from corner a to corner b, then has a stretch and two end slopes

    s_a = d_a.E_c,   s_b = d_b.E_c

and is the cubic through its ends with these slopes. Its Green strain, with Delta for "now minus at rest", is

    e_c = Delta(|E_c|^2 / 2 + (2 s_a^2 - s_a s_b + 2 s_b^2) / 30) / L_c^2,

the second part being the length that bending hides from the chord. A facet without it would have to strain to
follow a curved sheet, and locks; with it, a sheet bends to a cylinder at no membrane energy.

* Membrane: the three edge strains determine the strain of the facet, energy (A t / 2) e' N^-T C N^-1 e; see
  :mod:`kirigami.elements.triangle`. Interpolating the strain of the curved surface along edges only, is the Regge
  interpolation of Neunteufel and Schoeberl (2021).
* Bending: the six slopes, taken against the chords, fix the slope field of a discrete Kirchhoff triangle (Batoz,
  Bathe and Ho, 1980): quadratic over the facet, along each edge that of the edge's cubic, across each edge linear.
  Energy Delta s' K Delta s / 2 with a constant 6 x 6 matrix K.
* The length of the vector from a node to the tip of its normal enters nowhere; an energy D (|w| / l - 1)^2 / 2 for
  each corner keeps it, and is zero in equilibrium.

Free edges need nothing: no edge moment is their natural condition. A clamped grip holds the normals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.triangle import (
    ENDS,
    STARTS,
    check_areas,
    edge_vectors,
    flat_edges,
    membrane_stiffness,
    section_matrices,
    strain_from_edges,
    without_compression,
)
from kirigami.errors import ModelError
from kirigami.geometry.normals import Normal
from kirigami.primitives.checks import require_positive
from kirigami.primitives.kernel import EXACT, Array, Contribution, Kernel, Tangent, displacement_of
from kirigami.primitives.material import Material
from kirigami.primitives.node import Node
from kirigami.primitives.parts import ModelObject, Numbering

CHUNK = 512  # facets whose Hessians are made at a time, so that they stay in the processor's cache
# End slopes are listed edge by edge: slope 2 c is at the start of edge c, slope 2 c + 1 at its end.
CORNER_OF_SLOPE = np.array([corner for pair in zip(STARTS, ENDS) for corner in pair])
EDGE_OF_SLOPE = np.repeat(np.arange(3), 2)
HIDDEN = np.array([[4.0, -1.0], [-1.0, 4.0]]) / 30  # second derivative of the length that bending hides


@dataclass(frozen=True, slots=True, eq=False)
class CurvedFacet(ModelObject):
    """Triangle of an elastic sheet that stretches, and bends with the normals at its corners.

    Parameters
    ----------
    i, j, k : Normal
        The normals at the three corners; the corners are the nodes they stand on, counter-clockwise seen from the
        tips.
    thickness : float
        Sheet thickness [length].
    material : Material
        Elastic constants.

    Raises
    ------
    ModelError
        A corner is no :class:`Normal`, a repeated corner, a thickness that is not positive.

    Examples
    --------
    >>> import kirigami as kg
    >>> m = kg.Model()
    >>> corners = m.add(kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1))
    >>> normals = m.add(*(kg.Normal(corner, (0, 0, 1), length=0.005) for corner in corners))
    >>> facet = m.add(kg.CurvedFacet(*normals, thickness=0.01, material=kg.Material(E=1e9)))
    >>> print(m)
    Model in 3D: 3 nodes, 3 normals, 1 CurvedFacet
    """

    kind: ClassVar[str] = "element"
    i: Normal
    j: Normal
    k: Normal
    thickness: float
    material: Material

    def __post_init__(self) -> None:
        for corner in (self.i, self.j, self.k):
            if not isinstance(corner, Normal):
                raise ModelError(f"CurvedFacet: corners are given by their Normal, got {corner!r}")
        if len({id(self.i.base), id(self.j.base), id(self.k.base)}) < 3:
            raise ModelError(f"CurvedFacet on ({self.i!r}, {self.j!r}, {self.k!r}): the three corners must differ")
        object.__setattr__(self, "thickness", require_positive(self.thickness, "thickness", "CurvedFacet"))

    @property
    def nodes(self) -> tuple[Node, ...]:
        return (self.i.base, self.j.base, self.k.base, self.i, self.j, self.k)

    @classmethod
    def lower(cls, objects: Sequence[CurvedFacet], numbering: Numbering) -> list[Kernel]:
        if numbering.dim == 2:
            raise ModelError("CurvedFacet needs a model with dim=3")
        conn = numbering.connectivity(objects)
        check_areas("CurvedFacet", conn[:, :3], numbering)
        thickness = np.array([facet.thickness for facet in objects])
        E = np.array([facet.material.E for facet in objects])
        nu = np.array([facet.material.nu for facet in objects])
        return [CurvedFacetKernel(numbering.rest, conn, thickness, E, nu)]


def slope_stiffness(flat: Array, area: Array) -> Array:
    """Discrete Kirchhoff stiffness (n, 6, 6, 3) of the six end slopes s: K_ij = sum over m of it times (D, nu D, G).

    The last axis holds the parts that go with D, nu D and (1 - nu) D / 2, so that facets may differ in material.
    """
    n = len(area)
    # Gradients of the three barycentric coordinates: the opposite edge turned by a right angle.
    gradient = np.stack([-flat[..., 1], flat[..., 0]], axis=-1) / (2 * area)[:, None, None]
    # Slopes along the two edges that meet at a corner determine its slope vector g: s = -y.g for each edge.
    corner_slope = np.zeros((n, 3, 2, 6))
    for corner in range(3):
        at = np.flatnonzero(CORNER_OF_SLOPE == corner)
        both = np.stack([-flat[:, EDGE_OF_SLOPE[at[0]]], -flat[:, EDGE_OF_SLOPE[at[1]]]], axis=1)
        corner_slope[:, corner][:, :, at] = np.linalg.inv(both)
    # In the middle of an edge: along it minus a quarter of the sum (a cubic without end deflection), across the mean.
    middle_slope = np.empty((n, 3, 2, 6))
    for edge, (a, b) in enumerate(zip(STARTS, ENDS)):
        unit = flat[:, edge] / np.linalg.norm(flat[:, edge], axis=1)[:, None]
        share = 0.5 * np.eye(2) - 0.75 * unit[:, :, None] * unit[:, None]
        middle_slope[:, edge] = share @ (corner_slope[:, a] + corner_slope[:, b])
    stiffness = np.zeros((n, 6, 6, 3))
    for point in ((0.5, 0.5, 0.0), (0.0, 0.5, 0.5), (0.5, 0.0, 0.5)):  # exact: curvature is linear over the facet
        slope_gradient = np.zeros((n, 2, 2, 6))  # derivative along axis b of slope component a
        for corner in range(3):
            shape = (4 * point[corner] - 1) * gradient[:, corner]
            slope_gradient += corner_slope[:, corner, :, None] * shape[:, None, :, None]
        for edge, (a, b) in enumerate(zip(STARTS, ENDS)):
            shape = 4 * (point[a] * gradient[:, b] + point[b] * gradient[:, a])
            slope_gradient += middle_slope[:, edge, :, None] * shape[:, None, :, None]
        kxx, kyy = slope_gradient[:, 0, 0], slope_gradient[:, 1, 1]
        twist = slope_gradient[:, 0, 1] + slope_gradient[:, 1, 0]
        weight = (area / 3)[:, None, None]
        stiffness[..., 0] += weight * (kxx[:, :, None] * kxx[:, None] + kyy[:, :, None] * kyy[:, None])
        stiffness[..., 1] += weight * (kxx[:, :, None] * kyy[:, None] + kyy[:, :, None] * kxx[:, None])
        stiffness[..., 2] += weight * twist[:, :, None] * twist[:, None]
    return stiffness


def mean_curvature(flat: Array, area: Array, slopes: Array) -> Array:
    """Mean curvature tensor (n, 2, 2) of a discrete Kirchhoff triangle with end slopes (n, 6) against its chords.

    By Gauss's theorem it is the sum over the edges of the slope vector times the outward normal; along an edge the
    slope vector is quadratic, so Simpson's rule is exact.
    """
    corner = np.empty((len(area), 3, 2))
    for k in range(3):
        at = np.flatnonzero(CORNER_OF_SLOPE == k)
        along = -flat[:, EDGE_OF_SLOPE[at]]
        corner[:, k] = np.linalg.solve(along, slopes[:, at, None])[..., 0]
    total = np.zeros((len(area), 2, 2))
    for edge, (a, b) in enumerate(zip(STARTS, ENDS)):
        vector = flat[:, edge]
        both = corner[:, a] + corner[:, b]
        unit = vector / np.linalg.norm(vector, axis=1)[:, None]
        middle = 0.5 * both - 0.75 * (unit * both).sum(axis=1)[:, None] * unit
        outward = np.stack([vector[:, 1], -vector[:, 0]], axis=1)
        total += ((both + 4 * middle) / 6)[:, :, None] * outward[:, None]
    total /= area[:, None, None]
    return np.asarray(0.5 * (total + total.transpose(0, 2, 1)))


class CurvedFacetKernel(Kernel):
    """All curved facets; see the module's text for the formulas. Local nodes: three corners, three tips of normals."""

    name = "facets"
    surface = True
    approximates = True

    def __init__(
        self,
        rest: Array,
        conn: NDArray[np.int64],
        thickness: Array,
        E: Array,
        nu: Array,
        members: NDArray[np.int64] | None = None,
    ) -> None:
        self.rest, self.conn, self.members = rest, conn, members
        self.thickness, self.E, self.nu = thickness, E, nu
        self.rigidity = E * thickness**3 / (12 * (1 - nu**2))
        tips, first = np.unique(conn[:, 3:], return_index=True)
        self.normals = (conn[:, :3].ravel()[first], tips)
        self._rest_edges = edge_vectors(rest, conn)
        self._rest_tips = rest[conn[:, 3:]] - rest[conn[:, :3]]
        self.tip_length = np.linalg.norm(self._rest_tips, axis=2)
        flat, self.area = flat_edges(self._rest_edges)
        self._flat = flat
        self.section = section_matrices(thickness, E, nu)
        self._square = (flat**2).sum(axis=2)
        self._to_strain = strain_from_edges(flat)
        self._membrane = membrane_stiffness(self._to_strain, self.area, thickness, E, nu)
        parts = np.stack([self.rigidity, nu * self.rigidity, 0.5 * (1 - nu) * self.rigidity], axis=1)
        self._bending = np.einsum("nijm,nm->nij", slope_stiffness(flat, self.area), parts)
        directions = self._rest_tips / self.tip_length[..., None]
        self._rest_slopes = np.einsum("nsa,nsa->ns", directions[:, CORNER_OF_SLOPE], self._rest_edges[:, EDGE_OF_SLOPE])
        self._rest_hidden = self._hidden(self._rest_slopes)[0]

    def arrays(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("conn", "thickness", "E", "nu", "members")}

    @staticmethod
    def _hidden(slopes: Array) -> tuple[Array, Array]:
        """Half squared length (n, 3) that bending hides from each chord, and its derivatives (n, 6) by the slopes."""
        pairs = slopes.reshape(-1, 3, 2)
        derivative = pairs @ HIDDEN
        return 0.5 * (derivative * pairs).sum(axis=2), derivative.reshape(-1, 6)

    def _state(self, x: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Edges (n, 3, 3), normals (n, 3, 3), stretch of the tips (n, 3), edge strains (n, 3) and slopes (n, 6)."""
        u = displacement_of(x, self.rest)
        change = edge_vectors(u, self.conn)
        edges = self._rest_edges + change
        tips = (self._rest_tips + (u[self.conn[:, 3:]] - u[self.conn[:, :3]])) / self.tip_length[..., None]
        stretch = np.linalg.norm(tips, axis=2)
        normals = tips / stretch[..., None]
        slopes = np.einsum("nsa,nsa->ns", normals[:, CORNER_OF_SLOPE], edges[:, EDGE_OF_SLOPE])
        chord = ((self._rest_edges + 0.5 * change) * change).sum(axis=2)
        strain = (chord + self._hidden(slopes)[0] - self._rest_hidden) / self._square
        return edges, normals, stretch, strain, slopes

    def deformation(self, x: Array) -> Array:
        """Strain and mean curvature of each facet (n, 6): (exx, eyy, gamma_xy, kxx, kyy, 2 kxy), the first axis along
        the edge from corner i to j."""
        _, _, _, strain, slopes = self._state(x)
        bent = mean_curvature(self._flat, self.area, slopes - self._rest_slopes)
        found = np.empty((len(strain), 6))
        found[:, :3] = np.einsum("nac,nc->na", self._to_strain, strain)
        found[:, 3:] = np.stack([bent[:, 0, 0], bent[:, 1, 1], 2 * bent[:, 0, 1]], axis=1)
        return found

    def force(self, deformation: Array) -> Array:
        """Forces and moments per length (n, 6): (Nxx, Nyy, Nxy, Mxx, Myy, Mxy) of a deformation (n, 6)."""
        return np.asarray(np.einsum("nab,nb->na", self.section, deformation))

    def _chain(self, edges: Array, normals: Array, stretch: Array) -> tuple[Array, Array]:
        """First derivatives (n, 9, 6, 3) of half squared chord lengths (3) and slopes (6) by corners and tips, and
        the projectors (n, 3, 3, 3) across the normals over the stretch of the tips."""
        n = len(edges)
        across = (np.eye(3) - normals[..., :, None] * normals[..., None, :]) / stretch[..., None, None]
        chain = np.zeros((n, 9, 6, 3))
        for c, (a, b) in enumerate(zip(STARTS, ENDS)):
            chain[:, c, b], chain[:, c, a] = edges[:, c], -edges[:, c]
        for s, (corner, c) in enumerate(zip(CORNER_OF_SLOPE.tolist(), EDGE_OF_SLOPE.tolist())):
            row = chain[:, 3 + s]
            row[:, ENDS[c]] += normals[:, corner]
            row[:, STARTS[c]] -= normals[:, corner]
            turn = np.einsum("nab,nb->na", across[:, corner], edges[:, c]) / self.tip_length[:, corner, None]
            row[:, 3 + corner] += turn
            row[:, corner] -= turn
        return chain, across

    def _force_ahead(self, x: Array, change: Array) -> Array:
        """Derivatives of the membrane energy by the edge strains (n, 3) after a linear step `change` off `x`."""
        edges, normals, stretch, strain, slopes = self._state(x)
        chain, _ = self._chain(edges, normals, stretch)
        rates = np.einsum("nzka,nka->nz", chain, change[self.conn])
        hidden_rate = (self._hidden(slopes)[1] * rates[:, 3:]).reshape(-1, 3, 2).sum(axis=2)
        ahead = strain + (rates[:, :3] + hidden_rate) / self._square
        return np.asarray(np.einsum("ncd,nd->nc", self._membrane, ahead))

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2, tangent: Tangent = EXACT) -> Contribution:
        edges, normals, stretch, strain, slopes = self._state(x)
        force = np.einsum("ncd,nd->nc", self._membrane, strain)
        bent = slopes - self._rest_slopes
        moment = np.einsum("ncd,nd->nc", self._bending, bent)
        spread = stretch - 1.0
        energy = 0.5 * ((force * strain).sum(axis=1) + (moment * bent).sum(axis=1))
        energy += 0.5 * self.rigidity * (spread**2).sum(axis=1)
        if need == 0:
            return Contribution(energy)
        chain, across = self._chain(edges, normals, stretch)
        hidden = self._hidden(slopes)[1]
        pull = force / self._square
        generalized = np.concatenate([pull, moment + pull[:, EDGE_OF_SLOPE] * hidden], axis=1)
        gradient = np.einsum("nz,nzka->nka", generalized, chain)
        keep = (self.rigidity[:, None] * spread / self.tip_length)[..., None] * normals
        gradient[:, 3:] += keep
        gradient[:, :3] -= keep
        if need == 1:
            return Contribution(energy, gradient)
        if tangent.ahead is not None:
            force = self._force_ahead(*tangent.ahead)
        state = (edges, normals, stretch, force, moment, spread, hidden, chain, across)
        hessian = np.empty((len(energy), 6, 6, 3, 3))
        for start in range(0, len(energy), CHUNK):
            part = slice(start, start + CHUNK)
            hessian[part] = self._hessian(part, tangent.convexity, *(values[part] for values in state))
        return Contribution(energy, gradient, hessian)

    def _hessian(
        self,
        part: slice,
        convexity: float,
        edges: Array,
        normals: Array,
        stretch: Array,
        force: Array,
        moment: Array,
        spread: Array,
        hidden: Array,
        chain: Array,
        across: Array,
    ) -> Array:
        n = len(edges)
        exact = 1.0 - convexity
        tension = force
        if convexity:
            force = exact * force + convexity * without_compression(force, self._to_strain[part])
            tension = exact * tension + convexity * np.maximum(force, 0.0)
        square = self._square[part]
        pull = force / square
        # Second derivatives by the nine generalized strains. The hidden length acts through the slopes.
        inner = np.empty((n, 9, 9))
        membrane = self._membrane[part] / (square[:, :, None] * square[:, None])
        inner[:, :3, :3] = membrane
        inner[:, :3, 3:] = membrane[:, :, EDGE_OF_SLOPE] * hidden[:, None]
        inner[:, 3:, :3] = inner[:, :3, 3:].transpose(0, 2, 1)
        inner[:, 3:, 3:] = self._bending[part] + membrane[:, EDGE_OF_SLOPE][:, :, EDGE_OF_SLOPE] * (
            hidden[:, :, None] * hidden[:, None]
        )
        for c in range(3):
            ends = slice(3 + 2 * c, 5 + 2 * c)
            inner[:, ends, ends] += (tension[:, c] / square[:, c])[:, None, None] * HIDDEN
        flat = chain.reshape(n, 9, 18)
        hessian = (flat.transpose(0, 2, 1) @ inner @ flat).reshape(n, 6, 3, 6, 3).transpose(0, 1, 3, 2, 4).copy()
        # Geometric part: the chords, the product of normal and chord, and the curving of the unit sphere.
        eye = np.eye(3)
        for c, (a, b) in enumerate(zip(STARTS, ENDS)):
            block = pull[:, c, None, None] * eye
            _add(hessian, a, a, block)
            _add(hessian, b, b, block)
            _add(hessian, a, b, -block)
        turning = exact * (moment + pull[:, EDGE_OF_SLOPE] * hidden)
        for corner in range(3):
            length = self.tip_length[part, corner, None, None]
            tip = 3 + corner
            load = np.zeros((n, 3))
            for s in np.flatnonzero(CORNER_OF_SLOPE == corner):
                c = EDGE_OF_SLOPE[s]
                load += turning[:, s, None] * edges[:, c]
                mixed = turning[:, s, None, None] * across[:, corner] / length
                for node, sign in ((ENDS[c], 1.0), (STARTS[c], -1.0)):
                    _add_pair(hessian, node, tip, sign * mixed)
                    _add_pair(hessian, node, corner, -sign * mixed)
            d, size = normals[:, corner], stretch[:, corner, None, None]
            outward = np.einsum("na,na->n", load, d)[:, None, None]
            off = np.einsum("nab,nb->na", across[:, corner], load)[:, :, None] * d[:, None]
            curl = -(outward * across[:, corner] + off + off.transpose(0, 2, 1)) / size
            rigidity = self.rigidity[part, None, None]
            curl += rigidity * d[:, :, None] * d[:, None]
            curl += exact * rigidity * spread[:, corner, None, None] * across[:, corner]
            curl /= length**2
            _add(hessian, tip, tip, curl)
            _add(hessian, corner, corner, curl)
            _add(hessian, corner, tip, -curl)
        summed: Array = hessian
        return summed


def _add(hessian: Array, a: int, b: int, block: Array) -> None:
    """Add a symmetric block at (a, b), and at (b, a) where they differ."""
    hessian[:, a, b] += block
    if a != b:
        hessian[:, b, a] += block


def _add_pair(hessian: Array, a: int, b: int, block: Array) -> None:
    """Add a symmetric block that stems from a product of something at `a` and something at `b`."""
    hessian[:, a, b] += block
    hessian[:, b, a] += block
