"""The curved facet of versions before 0.2, which the shell facet supersedes: its old names, and its results files.

Normals stood at the nodes, as nodes of their own at the tips of vectors d. Edge c, with vector E_c from corner a to
corner b, had the end slopes s_a = d_a.E_c, s_b = d_b.E_c and the Green strain

    e_c = Delta(|E_c|^2 / 2 + (2 s_a^2 - s_a s_b + 2 s_b^2) / 30) / L_c^2,

membrane energy (A t / 2) e' N^-T C N^-1 e as in :mod:`kirigami.elements.triangle`, bending energy Delta s' K Delta s /
2 with the discrete Kirchhoff triangle of Batoz, Bathe and Ho (1980), and D (|w| / l - 1)^2 / 2 for the length of each
vector w. That strain lost stiffness in tension. Results files hold such facets, so their energies and forces can still
be evaluated; what stood at the tips goes to the rows behind the nodes.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kirigami.elements.shell_facet import ShellFacet
from kirigami.elements.surface import SurfaceKernel
from kirigami.elements.triangle import (
    ENDS,
    STARTS,
    edge_vectors,
    flat_edges,
    membrane_stiffness,
    section_matrices,
    strain_from_edges,
)
from kirigami.errors import ModelError
from kirigami.primitives.kernel import Array, Contribution, Kernel, displacement_of
from kirigami.primitives.material import Material
from kirigami.primitives.node import Node
from kirigami.primitives.parts import ModelObject, Numbering

# End slopes are listed edge by edge: slope 2 c is at the start of edge c, slope 2 c + 1 at its end.
CORNER_OF_SLOPE = np.array([corner for pair in zip(STARTS, ENDS) for corner in pair])
EDGE_OF_SLOPE = np.repeat(np.arange(3), 2)
HIDDEN = np.array([[4.0, -1.0], [-1.0, 4.0]]) / 30  # second derivative of the length that bending hides


class Normal(ModelObject):
    """Normal of a sheet at a node, for :func:`CurvedFacet`; superseded by the ``normals`` of :class:`ShellFacet`.

    Parameters
    ----------
    base : Node
        The node the normal stands on.
    direction : sequence of 3 floats
        Direction of the normal in the rest state, of any length.
    length : float
        Without meaning now.

    Raises
    ------
    ModelError
        A direction of no length.

    Examples
    --------
    >>> import warnings, kirigami as kg
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore")
    ...     kg.Normal(kg.Node(1, 2), (0, 0, 2)).direction
    (0.0, 0.0, 1.0)
    """

    kind: ClassVar[str] = "effect"

    def __init__(self, base: Node, direction: Sequence[float] = (0.0, 0.0, 1.0), length: float = 1.0) -> None:
        _superseded("Normal", "kg.ShellFacet(..., normals=...), or leave normals to it")
        if not isinstance(base, Node):
            raise ModelError(f"Normal: base must be a Node, got {base!r}")
        vector = np.asarray(direction, dtype=float)
        size = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
        if not (np.isfinite(size) and size > 0):
            raise ModelError(f"Normal: direction must hold three finite numbers, not all zero, got {direction!r}")
        self.base, self.length = base, length
        x, y, z = (vector / size).tolist()
        self.direction = (x, y, z)

    @property
    def nodes(self) -> tuple[Node, ...]:
        return (self.base,)

    @classmethod
    def lower(cls, objects: Sequence[Any], numbering: Numbering) -> list[Kernel]:
        return []  # the facets have what it says


def CurvedFacet(i: Normal, j: Normal, k: Normal, thickness: float, material: Material) -> ShellFacet:
    """A :class:`ShellFacet` on the nodes that three normals stand on; the old way to say so.

    Parameters
    ----------
    i, j, k : Normal
        The normals at the three corners.
    thickness : float
        Sheet thickness [length].
    material : Material
        Elastic constants.

    Returns
    -------
    ShellFacet
        With these normals, where they are not all alike.

    Raises
    ------
    ModelError
        A corner is no :class:`Normal`, and what :class:`ShellFacet` refuses.

    Examples
    --------
    >>> import warnings, kirigami as kg
    >>> corners = kg.Node(0, 0), kg.Node(1, 0), kg.Node(0, 1)
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore")
    ...     facet = kg.CurvedFacet(*(kg.Normal(corner) for corner in corners), 0.01, kg.Material(E=1e9))
    >>> type(facet).__name__
    'ShellFacet'
    """
    _superseded("CurvedFacet", "kg.ShellFacet(i, j, k, thickness, material) on the nodes themselves")
    for corner in (i, j, k):
        if not isinstance(corner, Normal):
            raise ModelError(f"CurvedFacet: corners are given by their Normal, got {corner!r}")
    directions = [i.direction, j.direction, k.direction]
    curved = directions if len(set(directions)) > 1 else None
    return ShellFacet(i.base, j.base, k.base, thickness, material, normals=curved)


def _superseded(name: str, successor: str) -> None:
    warnings.warn(f"kg.{name} is superseded: use {successor}", DeprecationWarning, stacklevel=3)


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


class CurvedFacetKernel(SurfaceKernel):
    """Curved facets of a results file; local rows: three corners, three tips of normals.

    What a tip pulls is given to the node it stands on, which is what held it; the Hessian is that of the rest state.
    """

    name = "facets"

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
        self._rest_edges = edge_vectors(rest, conn)
        self._rest_tips = rest[conn[:, 3:]] - rest[conn[:, :3]]
        self.tip_length = np.linalg.norm(self._rest_tips, axis=2)
        self.flat, self.area = flat_edges(self._rest_edges)
        self._square = (self.flat**2).sum(axis=2)
        self._to_strain = strain_from_edges(self.flat)
        self._membrane = membrane_stiffness(self._to_strain, self.area, thickness, E, nu)
        parts = np.stack([self.rigidity, nu * self.rigidity, 0.5 * (1 - nu) * self.rigidity], axis=1)
        self._bending = np.einsum("nijm,nm->nij", slope_stiffness(self.flat, self.area), parts)
        directions = self._rest_tips / self.tip_length[..., None]
        self._rest_slopes = np.einsum("nsa,nsa->ns", directions[:, CORNER_OF_SLOPE], self._rest_edges[:, EDGE_OF_SLOPE])
        self._rest_hidden = self._hidden(self._rest_slopes)[0]
        self.section = section_matrices(thickness, E, nu)

    def arrays(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("conn", "thickness", "E", "nu", "members")}

    @staticmethod
    def _hidden(slopes: Array) -> tuple[Array, Array]:
        """Half squared length (n, 3) that bending hides from each chord, and its derivatives (n, 6) by the slopes."""
        pairs = slopes.reshape(-1, 3, 2)
        derivative: Array = pairs @ HIDDEN
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

    def natural_deformation(self, lam: float) -> Array | None:
        """None: these facets were never actuated."""
        return None

    def deformation(self, x: Array) -> Array:
        """Mean strain and curvature (n, 6) of each facet, as :class:`ShellFacetKernel` has them."""
        state = self._state(x)
        strain = np.einsum("nac,nc->na", self._to_strain, state[3])
        bent = mean_curvature(self.flat, self.area, state[4] - self._rest_slopes)
        return np.concatenate([strain, bent], axis=1)

    def force(self, deformation: Array) -> Array:
        """Forces and moments per length (n, 6) of a deformation (n, 6)."""
        return np.asarray(np.einsum("nab,nb->na", self.section, deformation))

    def _chain(self, edges: Array, normals: Array, stretch: Array) -> Array:
        """First derivatives (n, 9, 6, 3) of half squared chord lengths (3) and slopes (6) by corners and tips."""
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
        return chain

    def evaluate(self, x: Array, lam: float = 1.0, need: int = 2) -> Contribution:
        edges, normals, stretch, strain, slopes = self._state(x)
        force = np.einsum("ncd,nd->nc", self._membrane, strain)
        bent = slopes - self._rest_slopes
        moment = np.einsum("ncd,nd->nc", self._bending, bent)
        spread = stretch - 1.0
        energy = 0.5 * ((force * strain).sum(axis=1) + (moment * bent).sum(axis=1))
        energy += 0.5 * self.rigidity * (spread**2).sum(axis=1)
        if need == 0:
            return Contribution(energy)
        chain = self._chain(edges, normals, stretch)
        hidden = self._hidden(slopes)[1]
        pull = force / self._square
        generalized = np.concatenate([pull, moment + pull[:, EDGE_OF_SLOPE] * hidden], axis=1)
        # The pull along a normal cancels between its tip and its node, whose sum is all that is asked for.
        gradient = np.einsum("nz,nzka->nka", generalized, chain)
        if need == 1:
            return Contribution(energy, _at_corners(gradient))
        inner = np.zeros((len(energy), 9, 9))
        membrane = self._membrane / (self._square[:, :, None] * self._square[:, None])
        inner[:, :3, :3] = membrane
        inner[:, :3, 3:] = membrane[:, :, EDGE_OF_SLOPE] * hidden[:, None]
        inner[:, 3:, :3] = inner[:, :3, 3:].transpose(0, 2, 1)
        inner[:, 3:, 3:] = self._bending + membrane[:, EDGE_OF_SLOPE][:, :, EDGE_OF_SLOPE] * (
            hidden[:, :, None] * hidden[:, None]
        )
        hessian = np.einsum("nzka,nzy,nylb->nklab", chain, inner, chain, optimize=True)
        return Contribution(energy, _at_corners(gradient), _at_corners(hessian))


def _at_corners(values: Array) -> Array:
    """Members' values (n, 6, ...) with what belongs to a tip given to its corner."""
    moved: Array = values.copy()
    moved[:, :3] += values[:, 3:]
    moved[:, 3:] = 0.0
    return moved


def mean_curvature(flat: Array, area: Array, slopes: Array) -> Array:
    """Mean curvature (n, 3), (kxx, kyy, 2 kxy), of a discrete Kirchhoff triangle with end slopes (n, 6).

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
    return np.asarray(np.stack([total[:, 0, 0], total[:, 1, 1], total[:, 0, 1] + total[:, 1, 0]], axis=1))
